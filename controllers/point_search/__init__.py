"""Search for the elements of electrode arrays, and the charge, that bring about a movement."""
