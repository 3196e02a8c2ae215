"""The best design: which values of some inputs make an objective largest, all requirements met."""
