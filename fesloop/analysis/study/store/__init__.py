"""Results on disk: one SQLite file."""
