"""What the nodes send becomes tables, sums, a summary and a bag."""
