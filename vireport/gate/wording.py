"""Ranges and sentences as the verdict and the report print them."""

from __future__ import annotations

from vireport.analysis import StableInterval

SWEEP_END = "end of the sweep"
"""What ends a stable range that no critical point ends."""


def range_text(part: StableInterval, digits: int = 6) -> str:
    """Print a stable range as an inequality, strict at a critical point."""
    low, high = ("≤" if point is None else "<" for _, point in part.ends)
    parameter = part.parameter
    return f"{parameter.show(part.start, digits)} {low} {parameter.symbol} {high} {parameter.show(part.end, digits)}"


def capital(text: str) -> str:
    """Begin with a capital letter, unless with the path of a key; leave the rest alone."""
    first = text.partition(" ")[0]
    return text if "_" in first else text[:1].upper() + text[1:]
