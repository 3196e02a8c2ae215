"""The command line."""

from vireport.cli.app import main

__all__ = [
    "main",
]
