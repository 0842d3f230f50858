"""Definition of a study: its file, axes, cells, figures and kept metrics."""
