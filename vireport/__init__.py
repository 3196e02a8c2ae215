"""Periodic motions, stability and voltage of vibro-impact energy harvesters."""

__version__ = "0.1.0"
