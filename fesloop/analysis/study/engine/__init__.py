"""Runs studies: coordinator, cluster, workers."""
