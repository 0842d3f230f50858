"""Figures of a study: heat maps and curves, with theory over them."""
