"""Which end is the head: how midlines are linked, how the ends look, and what motion tells."""
