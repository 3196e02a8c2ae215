"""The event search of `kernel` compiled by numba, which is imported with the first search that is compiled."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from inspect import getmembers, isfunction
from math import sqrt
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


def _compiled(search: Callable[..., Result]) -> Callable[..., Result] | None:
    """Compile a function of the kernel; None where numba is missing.

    The functions that it calls stay interpreted for other callers, so that both forms exist in one process; numba is
    told to compile them where compiled code calls them.
    """
    try:
        from numba import njit
    except ImportError:
        return None
    _register_kernel()
    compiled: Callable[..., Result]
    try:  # the result is kept on disk if there is a place to write to
        compiled = njit(cache=True, nogil=True, **OPTIONS)(search)
    except RuntimeError:
        compiled = njit(nogil=True, **OPTIONS)(search)
    return compiled


@cache
def _register_kernel() -> None:
    """Let compiled code call every function of the kernel, once in a process.

    Functions that treat arrays as a whole are replaced by forms for single numbers and by loops.
    """
    from numba.extending import overload, register_jitable

    overload(kernel.pick, strict=False)(lambda *_: lambda condition, yes, no: yes if condition else no)
    overload(kernel.root, strict=False)(lambda *_: lambda square: sqrt(square))
    overload(kernel.note, strict=False)(lambda *_: kernel.note_each)
    overload(kernel.advance, strict=False)(lambda *_: kernel.advance_each)
    for _, function in getmembers(kernel, isfunction):
        if function.__module__ == kernel.__name__ and function not in kernel.OF_ARRAYS:
            # A loop becomes one of vectors only if all that it calls is in it.
            register_jitable(forceinline=function in kernel.STRAIGHT, **OPTIONS)(function)
