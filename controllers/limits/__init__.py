"""Limits of stimulation that all controllers share."""
