"""Files that are there whole or not at all, and files that others may have written."""
