"""Quadratic programmes, of which none hands back a silently wrong answer."""
