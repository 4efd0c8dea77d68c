"""Sums that a trial adds to, frame by frame, in bounded memory."""
