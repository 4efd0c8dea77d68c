"""Observables, episodes, correlators and statistics of a tracked worm, and the report."""
