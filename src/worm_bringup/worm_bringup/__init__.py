"""The graph put together: the `worm` command, the recorder, launch files."""
