"""Estimators with their intervals, for sums and samples of any kind."""
