"""One figure of the report a file."""
