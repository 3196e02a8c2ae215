"""The version, where every module can import it."""

__version__ = "1.0.0"
