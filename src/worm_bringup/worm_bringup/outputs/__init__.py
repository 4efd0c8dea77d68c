"""Results directories: where they may be, and how nothing in them is lost."""
