"""Entry point of the `vireport` command: what holds of the process from its first moment to its last.

A standard stream may be closed, full, or a pipe whose reader has gone; Ctrl-C may come at any time. Neither may end in
a traceback, nor in the exit code 1, which means that a requirement is not met.
"""

from __future__ import annotations

import atexit
import gc
import io
import os
import sys

TYPE_CHECKING = False  # until `entry` begins, Ctrl-C is a traceback: only what Python itself has loaded is imported
if TYPE_CHECKING:
    from typing import Any, TextIO


class _Output(io.FileIO):
    """A standard stream that never fails: what cannot be written is dropped, and the first reason kept."""

    failure: OSError | None = None

    def write(self, data: Any, /) -> int:
        if self.failure is None:
            try:
                return super().write(data)
            except OSError as error:
                self.failure = error
        return memoryview(data).nbytes


def entry() -> int:
    """Run the command line on the arguments of the process and return its exit code."""
    try:
        from vireport.base import install

        install()
        code = _run()
    except KeyboardInterrupt:  # while the command line was imported
        from vireport.base import EXIT_CODE as code

        print("vireport: interrupted", file=sys.stderr)
    from signal import SIG_IGN, SIGINT, signal

    signal(SIGINT, SIG_IGN)  # nothing is left that could be interrupted
    return code


def _run() -> int:
    _open_missing_streams()
    output = _Output(1, "w", closefd=False)
    if os.name != "nt":  # a console of Windows takes text, not bytes
        sys.stdout = _text(output, sys.stdout)
        sys.stderr = _text(_Output(2, "w", closefd=False), sys.stderr)
    # No matrix here is so large that several threads of the linear algebra pay, and they take long to start.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # None is needed, and to look for some, the metadata of every installed package is read.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Hardly any object here is in a cycle: to look for them, and to free all one by one at the end, takes 60 ms.
    gc.set_threshold(100_000)
    atexit.register(gc.freeze)
    from errno import EPIPE

    from vireport.cli import main

    code = main(sys.argv[1:])
    sys.stdout.flush()
    failure = output.failure
    if failure is None or failure.errno == EPIPE or code not in (0, 1):  # a reader that has gone wants no more
        return code
    from vireport.base import OutputError

    print(f"vireport: error: standard output cannot be written: {failure.strerror}", file=sys.stderr)
    return OutputError.exit_code


def _open_missing_streams() -> None:
    """Open what the process was started without, so that no other file takes its number.

    It cannot be read or written to, except for messages, which are dropped.
    """
    for number, mode in enumerate((os.O_WRONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)
    if sys.stdin is None:
        sys.stdin = io.TextIOWrapper(io.FileIO(0, closefd=False))


def _text(raw: _Output, stream: TextIO | None) -> TextIO:
    encoding = "utf-8" if stream is None else stream.encoding
    buffer = io.BufferedWriter(raw)
    return io.TextIOWrapper(buffer, encoding, "backslashreplace", line_buffering=raw.fileno() == 2 or raw.isatty())


if __name__ == "__main__":
    sys.exit(entry())
