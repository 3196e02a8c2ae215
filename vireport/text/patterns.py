"""Sentences with places for numbers: the pattern says how each is printed, whoever chooses the sentence gives it."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Any

from vireport.text.formatting import OF_A_MODEL, ROUGHLY, error_bound, rounded_text, stated_text


class Pattern(StrEnum):
    """Sentences of a module of words by their names; one without places is said as it is."""

    def worded(self, **values: Any) -> str:
        """The sentence with its numbers and texts."""
        return filled(self, values)


def filled(pattern: str, values: Mapping[str, Any]) -> str:
    """Put numbers and texts into a pattern.

    Examples
    --------
    >>> filled("{share:roughly} %, {size:+roughly} %, of {length:given} m, to {error:bound}", {
    ...     "share": 12.345, "size": 0.123, "length": 0.123456, "error": 5.551e-17})
    '12 %, +0.12 %, of 0.123456 m, to 5.6 × 10⁻¹⁷'
    """
    return pattern.format(**{name: _Number(x) if isinstance(x, float) else x for name, x in values.items()})


class _Number(float):
    """A number of a sentence; its pattern says whether it is given, a bound, or told roughly, and with a sign."""

    def __format__(self, kind: str) -> str:
        if kind == "given":
            return stated_text(self)
        if kind == "bound":
            return error_bound(self)
        sign = "+" if kind.startswith("+") and self > 0 else ""
        return sign + rounded_text(self, ROUGHLY if "roughly" in kind else OF_A_MODEL)
