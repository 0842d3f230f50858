"""Blocks written as dependency-free C, and their FMUs; nothing here is loaded by a run."""
