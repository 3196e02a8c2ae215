"""How long work tells what it is doing: a function that is told each step as it begins."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str], None]
