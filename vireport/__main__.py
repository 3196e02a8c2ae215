"""Entry point of the `vireport` command."""

from __future__ import annotations

import sys

from vireport.cli import main


def entry() -> int:
    """Run the command line on the arguments of the process and return its exit code."""
    return main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(entry())
