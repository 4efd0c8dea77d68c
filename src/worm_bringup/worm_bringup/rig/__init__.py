"""Rig files: read and checked, or made of what pictures show."""
