"""Ctrl-C: recorded when it comes, so that no library can swallow it, and deferred while files are put in place.

Before `install` is called, and in programs that use the package, Python's own handling of Ctrl-C is left alone.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

EXIT_CODE = 128 + signal.SIGINT
"""What a shell reports of a process that ended by Ctrl-C."""

_received = _held = False


def install() -> None:
    """Record Ctrl-C from here on; where the process was started to ignore it, it is still ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
        sys.unraisablehook = _without_interrupts


def _interrupt(number: int, frame: FrameType | None) -> None:
    global _received
    _received = True
    if not _held:
        raise KeyboardInterrupt


def _without_interrupts(unraisable: sys.UnraisableHookArgs) -> None:
    """Ctrl-C in a callback of the interpreter cannot be raised there; `check` raises it at the next step."""
    if unraisable.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(unraisable)


def received() -> bool:
    """Whether there was a Ctrl-C."""
    return _received


def check() -> None:
    """Raise a Ctrl-C that was deferred, or that a library has swallowed.

    Raises
    ------
    KeyboardInterrupt
    """
    if _received:
        raise KeyboardInterrupt


@contextmanager
def deferred() -> Iterator[None]:
    """Let what is inside run to its end; what came before it is raised before it begins."""
    global _held
    check()
    _held = True
    try:
        yield
    finally:
        _held = False
