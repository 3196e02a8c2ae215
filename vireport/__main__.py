"""Entry point of the `vireport` command."""

from __future__ import annotations

import gc
import sys


def main() -> int:
    """Run the command line and return its exit code."""
    if sys.argv[1:] in (["--version"], ["-V"]):
        from vireport import __version__

        print(f"vireport {__version__}")
        return 0
    # What is imported stays: looking through it again and again for garbage costs a tenth of a short run.
    gc.set_threshold(100_000, 50, 50)
    from vireport.cli import main as run

    return run(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
