"""Search for the elements of electrode arrays, and the charge, that produce a movement."""
