"""Results of a study on disk: one SQLite file."""
