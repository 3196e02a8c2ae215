"""Search for the best design: the values of some inputs that make an objective largest with all requirements met."""
