"""Cameras: captured from, looked for when lost, and their record."""
