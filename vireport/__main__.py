"""Entry point of the `vireport` command: what holds of the process from its first moment to its last.

A standard stream may be closed, full, or a pipe whose reader has gone; Ctrl-C may come at any time. Neither may end in
a traceback, nor in the exit code 1, which means that a requirement is not met.
"""

from __future__ import annotations

import errno
import os
import signal
import sys


def entry() -> int:
    """Run the command line on the arguments of the process and return its exit code."""
    try:
        # Not at the top of the file: from here on, Ctrl-C ends in a message, and while modules are imported there it
        # would end in a traceback.
        from vireport.base import interrupts, streams
        from vireport.base.errors import OutputError

        interrupts.install()
        output = streams.install()
        # OpenBLAS starts a thread for each core as NumPy is imported, and no matrix here is so large that they pay:
        # without them, a run with --json takes 340 ms instead of 380 on two cores.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        # Pydantic looks for plugins in the metadata of every package installed: 5 ms where there are a hundred.
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")
        # Figures look the same whatever the user has set: what cannot be read of it must not end a run.
        os.environ.update(MATPLOTLIBRC=os.devnull, MPLBACKEND="agg")
        from vireport.cli.app import main

        code = main(sys.argv[1:])
        sys.stdout.flush()
        # A reader that has gone wants no more; any other fault counts where the run itself has not failed.
        if output.failure is not None and output.failure.errno != errno.EPIPE and code in (0, 1):
            print(f"vireport: error: standard output cannot be written: {output.failure.strerror}", file=sys.stderr)
            code = OutputError.exit_code
    except KeyboardInterrupt:  # while the command line was imported
        from vireport.base import interrupts

        print("vireport: interrupted", file=sys.stderr)
        code = interrupts.exit_code()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # nothing is left that could be interrupted
    return code


if __name__ == "__main__":
    sys.exit(entry())
