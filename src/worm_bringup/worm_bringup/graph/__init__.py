"""The nodes put together: in this process, or with a process each."""
