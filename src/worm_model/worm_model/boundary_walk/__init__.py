"""The boundary walk: by Monte Carlo, and exactly."""
