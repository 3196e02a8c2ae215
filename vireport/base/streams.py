"""The standard streams of a process: each may be closed, full, or a pipe whose reader has gone."""

from __future__ import annotations

import io
import os
import sys
from typing import Any, TextIO


class StandardStream(io.FileIO):
    """A standard stream that never fails: what cannot be written is dropped, and the first reason kept.

    Attributes
    ----------
    failure : OSError or None
        Why the first piece could not be written that was not.
    """

    failure: OSError | None = None

    def write(self, data: Any, /) -> int:
        """Write bytes, or drop them; returns their number in either case."""
        if self.failure is None:
            try:
                return super().write(data)
            except OSError as error:
                self.failure = error
        return memoryview(data).nbytes


def install() -> StandardStream:
    """Open the streams that are missing, and put in place of the two for output what never fails.

    Returns
    -------
    StandardStream
        Standard output.
    """
    _open_missing()
    output = StandardStream(1, "w", closefd=False)
    if os.name != "nt":  # a console of Windows takes text, not bytes
        sys.stdout = _text(output, sys.stdout)
        sys.stderr = _text(StandardStream(2, "w", closefd=False), sys.stderr)
    return output


def _open_missing() -> None:
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


def _text(raw: StandardStream, stream: TextIO | None) -> TextIO:
    encoding = "utf-8" if stream is None else stream.encoding
    buffer = io.BufferedWriter(raw)
    return io.TextIOWrapper(buffer, encoding, "backslashreplace", line_buffering=raw.fileno() == 2 or raw.isatty())
