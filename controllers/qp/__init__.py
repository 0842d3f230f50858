"""Quadratic programmes whose failures are statuses, never silently wrong solutions."""
