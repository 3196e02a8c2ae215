"""The best design as it can be built: rounded to the fewest digits that keep its requirements, as runs judge them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product
from math import ceil, floor, log10

import numpy as np

from vireport.optimise.grid import JudgedDesign, judged_design
from vireport.optimise.problem import Floats, Problem

FEWEST, MOST = 3, 6
"""Significant digits that inputs are rounded to, at least and at most."""

LOSS = 0.01
"""Share of the objective up to which a rounded design may fall short of the best one."""

TRIED, TRIED_COSTLY = 24, 6
"""Rounded designs that are judged at most, where each run is short, and where it is long."""

ROUNDINGS = 6
"""Rounded designs of one number of digits that are judged, the nearest first."""


def built_design(problem: Problem, best: JudgedDesign) -> JudgedDesign | None:
    """Round a design to as few digits as possible; None where no rounded one that is tried meets all requirements.

    Each input is rounded up or down, within its range; an input at an end of it stays there.

    Parameters
    ----------
    problem : Problem
    best : JudgedDesign
        A design that meets all requirements.
    """
    tried = TRIED_COSTLY if problem.is_costly else TRIED
    for t in islice(_rounded(problem, best.t), tried):
        point = judged_design(problem, t)
        if point is not None and point.meets_requirements() and point.value >= best.value - LOSS * abs(best.value):
            return point
    return None


def _rounded(problem: Problem, t: Floats) -> Iterator[Floats]:
    """Designs with few digits near one, those with the fewest first."""
    for digits in range(FEWEST, MOST + 1):
        ways = product(*(_both(value, digits) for value in problem.values(t).tolist()))
        near = sorted(
            (_shares(problem, t, values) for values in ways), key=lambda other: float(np.abs(other - t).sum())
        )
        yield from (other for other in near[:ROUNDINGS] if ((other >= 0) & (other <= 1)).all())


def _both(value: float, digits: int) -> tuple[float, float]:
    """A value rounded down and up."""
    if value == 0:
        return 0.0, 0.0
    power = floor(log10(abs(value))) + 1 - digits
    down, up = (f(float(f"{value:.15e}") / 10.0**power) for f in (floor, ceil))
    return float(f"{down}e{power}"), float(f"{up}e{power}")


def _shares(problem: Problem, t: Floats, values: tuple[float, ...]) -> Floats:
    """Values as shares of their ranges, from which these very values come back; those of inputs at an end stay."""
    low = np.array([min(varied.from_, varied.to) for varied in problem.design.vary])
    wanted = np.array(values)
    share = (wanted - low) / problem.widths
    for nearby in (share, np.nextafter(share, 1.0), np.nextafter(share, 0.0)):
        share = np.where(problem.values(nearby) == wanted, nearby, share)
    return np.where((t == 0) | (t == 1), t, share)
