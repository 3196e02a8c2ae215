"""Entry point of the `vireport` command."""

from __future__ import annotations

import contextlib
import gc
import os
import sys
from typing import NoReturn


def main() -> int:
    """Run the command line and return its exit code."""
    if sys.argv[1:] in (["--version"], ["-V"]):
        from vireport.version import __version__

        print(f"vireport {__version__}")
        return 0
    # What is imported stays: looking through it again and again for garbage costs a tenth of a short run.
    gc.set_threshold(100_000, 50, 50)
    from vireport.cli import main as run

    return run(sys.argv[1:])


def entry() -> NoReturn:
    """Run the command line as a process of its own, and leave at once when it is done.

    By then every file is closed. Taking down an interpreter full of modules would be a seventh of a short run.
    """
    code = main()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(BrokenPipeError, ValueError):
            stream.flush()
    os._exit(code)


if __name__ == "__main__":
    entry()
