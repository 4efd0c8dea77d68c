"""Which end is the head: links between midlines, appearance of the ends, and what motion tells."""
