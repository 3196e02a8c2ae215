"""The event search of `kernel` compiled by numba, which is imported when it is first asked for."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from inspect import getmembers, isfunction
from typing import Any

from vireport.simulation import kernel

OPTIONS: Any = {"error_model": "numpy", "fastmath": False}

MATHEMATICS = {
    kernel.acos: lambda x: math.acos(x),
    kernel.cos: lambda x: math.cos(x),
    kernel.sin: lambda x: math.sin(x),
}
"""What compiled code calls where the kernel has a version for the interpreter."""


@cache
def compiled_search() -> Callable[..., None] | None:
    """Return `kernel.follow_starts` compiled, or None where numba is missing.

    The functions that it calls stay those of the interpreter; numba is told to compile them where compiled code calls
    them.
    """
    try:
        from numba import njit
        from numba.extending import overload, register_jitable
    except ImportError:
        return None

    def compiled_as(implementation: Callable[[float], float]) -> Callable[..., Any]:
        return lambda x: implementation

    for function, implementation in MATHEMATICS.items():
        overload(function, inline="always")(compiled_as(implementation))
    for _, function in getmembers(kernel, isfunction):
        if function.__module__ == kernel.__name__ and function not in MATHEMATICS:
            register_jitable(forceinline=True, **OPTIONS)(function)
    search: Callable[..., None]
    try:  # the result is kept on disk if there is a place to write to
        search = njit(cache=True, nogil=True, **OPTIONS)(kernel.follow_starts)
    except RuntimeError:
        search = njit(nogil=True, **OPTIONS)(kernel.follow_starts)
    return search
