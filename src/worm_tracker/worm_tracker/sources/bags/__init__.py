"""Bags: read, checked, recorded, and what is left of damaged ones."""
