"""Every number of a trial from its sums: with interval, n and the paper's value."""
