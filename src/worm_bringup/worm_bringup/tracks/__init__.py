"""Tracks that another tracker made, analysed without a graph."""
