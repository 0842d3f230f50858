"""Columns that every table of results has."""

OWN_COLUMNS = ("cell", "replicate", "seed", "id", "status", "cause", "wall_s", "recording")
"""Names that neither an axis nor a metric may have."""
