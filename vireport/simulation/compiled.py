"""The event search of `kernel` compiled by numba, which is imported when it is first asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from inspect import getmembers, isfunction
from typing import Any, TypeVar

from vireport.simulation import kernel

Result = TypeVar("Result")

OPTIONS: Any = {"error_model": "numpy", "fastmath": False}


@cache
def compiled_search() -> Callable[..., None] | None:
    """Return `kernel.follow_starts` compiled, or None where numba is missing."""
    return _compiled(kernel.follow_starts)


@cache
def compiled_rubbed_search() -> Callable[..., None] | None:
    """Return `kernel.follow_rubbed_starts` compiled, or None where numba is missing."""
    return _compiled(kernel.follow_rubbed_starts)


@cache
def compiled_ways() -> Callable[..., bool] | None:
    """Return `kernel.follow_ways` compiled, or None where numba is missing."""
    return _compiled(kernel.follow_ways)


def _compiled(followed: Callable[..., Result]) -> Callable[..., Result] | None:
    """A function of the kernel compiled, or None where numba is missing.

    The functions that it calls stay those of the interpreter; numba is told to compile them where compiled code calls
    them.
    """
    try:
        from numba import njit
    except ImportError:
        return None
    _teach()
    search: Callable[..., Result]
    try:  # the result is kept on disk if there is a place to write to
        search = njit(cache=True, nogil=True, **OPTIONS)(followed)
    except RuntimeError:
        search = njit(nogil=True, **OPTIONS)(followed)
    return search


@cache
def _teach() -> None:
    """Tell numba, once, what the functions of the kernel are in compiled code."""
    from numba.extending import register_jitable

    for _, function in getmembers(kernel, isfunction):
        if function.__module__ == kernel.__name__:
            register_jitable(forceinline=True, **OPTIONS)(function)
