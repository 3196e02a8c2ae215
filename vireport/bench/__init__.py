"""The bench: a design changed by hand in a page of this machine or in a notebook, and what the program says of it."""
