"""Controllers as C programmes: their constants, and the code that uses them in the `.c` files here."""
