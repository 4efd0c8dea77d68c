"""Reads bags record by record: whatever is whole is found, and what is not is said."""
