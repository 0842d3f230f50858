"""Closed-loop co-simulation of functional electrical stimulation of the hand."""
