"""Ctrl-C and SIGTERM: recorded as they come, so that no library swallows them, and deferred as files are put in place.

Both are raised as a `KeyboardInterrupt`, so that of what is unfinished nothing is left.

Before `install` is called, and in programs that use the package, Python's own handling of signals is left alone.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_received = 0
_held = False


class Interruption(KeyboardInterrupt):
    """The interruption of a run by Ctrl-C or SIGTERM.

    Where `KeyboardInterrupt` itself passes through code that was compiled from a string, as that of a dataclass is,
    CPython ends the process by SIGINT when all is done, though it was caught. A subclass has its exit code.
    """


def install() -> None:
    """Record both signals from here on; where the process was started to ignore one, it is still ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _interrupt)
    sys.unraisablehook = _without_interrupts


def _interrupt(number: int, frame: FrameType | None) -> None:
    global _received
    _received = number
    if not _held:
        raise Interruption


def _without_interrupts(unraisable: sys.UnraisableHookArgs) -> None:
    """A signal in a callback of the interpreter cannot be raised there; `check` raises it at the next step."""
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)


def received() -> bool:
    """Whether there was a signal."""
    return _received > 0


def exit_code() -> int:
    """What a shell reports of a process that ended by the signal received; by Ctrl-C where none is recorded."""
    return 128 + (_received or signal.SIGINT)


def check() -> None:
    """Raise a signal that was deferred, or that a library has swallowed.

    Raises
    ------
    KeyboardInterrupt
    """
    if _received:
        raise Interruption


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
