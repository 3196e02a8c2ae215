"""The event search of `kernel` compiled by numba, which is imported when it is first asked for."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

from vireport.simulation import kernel

OPTIONS: Any = {"error_model": "numpy", "fastmath": False, "nogil": True, "no_cfunc_wrapper": True}
INNER: Any = {"forceinline": True, "no_cpython_wrapper": True}
MATH = ("acos", "cos", "floor", "sin", "sqrt")
"""Functions of which the kernel has versions for the interpreter."""

ENTRY = kernel.follow_starts.__name__


@cache
def compiled_search() -> Callable[..., None] | None:
    """Return `kernel.follow_starts` compiled, or None where numba is missing.

    Every function of the kernel is translated, in a scope in which they find each other and the functions of `math`.
    """
    try:
        from numba import njit
    except ImportError:
        return None
    scope = {**vars(kernel), **{name: getattr(math, name) for name in MATH}}
    for name, function in vars(kernel).items():
        own = isinstance(function, FunctionType) and function.__module__ == kernel.__name__
        if own and name not in (*MATH, ENTRY):
            scope[name] = njit(**OPTIONS, **INNER)(FunctionType(function.__code__, scope, name))
    entry = FunctionType(kernel.follow_starts.__code__, scope, ENTRY)
    search: Callable[..., None]
    try:  # the result is kept on disk if there is a place to write to
        search = njit(cache=True, **OPTIONS)(entry)
    except RuntimeError:
        search = njit(**OPTIONS)(entry)
    return search
