"""Which samples are new, and what is wrong with them."""
