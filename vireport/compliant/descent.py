"""From rigid membranes, which are infinitely stiff, to compliant ones: what is followed, and how.

A contact lasts in proportion to epsilon = K^(-1/(h+1)), so that everything approaches the rigid model at that rate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base import NumericalError
from vireport.design import Solution, stable_motion
from vireport.motions import Event
from vireport.physics import Device
from vireport.scenario import Parameter

Floats = NDArray[np.float64]

SHORTEST = 1 / 8
"""Share of the way in epsilon below which no smaller step is tried where a motion is lost."""

MULTIPLIER = {Event.PERIOD_DOUBLING: -1.0, Event.FOLD: 1.0}
"""Multiplier at each kind of critical point that is followed, the preferred kind first."""

Finder = Callable[[float, Floats], tuple[Any, Floats]]
"""(factor, guess of the unknowns) -> what is found, and its unknowns."""


class Rigid(Struct, frozen=True, eq=False):
    """The motion with rigid impacts that is followed: where it is, why this one, and its numbers as in `Motions`.

    Attributes
    ----------
    parameter : Parameter
    value : float
    chosen : str
    velocity_bottom, velocity_top : float
        Z' just before the impact [y_c].
    phase_bottom, phase_top : float
        Forcing phase there [rad].
    time_up : float
        Of the flight from the bottom to the top [t_c].
    """

    parameter: Parameter
    value: float
    chosen: str
    velocity_bottom: float
    velocity_top: float
    phase_bottom: float
    phase_top: float
    time_up: float


def rigid_motion(solution: Solution) -> tuple[Rigid, Device] | None:
    """The motion that is followed, and the device that has it."""
    chosen = stable_motion(solution)
    if chosen is None:
        return None
    design, row = chosen
    where = "at the design point" if design is solution.design else "in the middle of the first stable range"
    m = design.motions
    time_up = 2 * solution.device.period_ratio * m.q
    numbers = (float(a[row]) for a in (m.velocity_bottom, m.velocity_top, m.phi_bottom, m.phi_top, time_up))
    rigid = Rigid(design.parameter, design.value, f"the stable motion {where}", *numbers)
    return rigid, solution.device.with_values({design.parameter: design.value})


def descend(factors: Sequence[float], exponent: float, start: Floats | None, find: Finder) -> list[tuple[Any, str]]:
    """Follow something from rigid membranes down to each factor, extrapolating in epsilon; what is found, or why not.

    Once it is lost it stays lost on the softer rungs.
    """
    if start is None:
        return [(None, "there is no period doubling and no fold to follow")] * len(factors)
    (e0, x0), (e1, x1) = (0.0, start), (0.0, start)
    rungs: list[tuple[Any, str]] = []
    lost = ""
    for factor in sorted(factors, reverse=True):
        # epsilon = K^(-1/(h+1)) goes as the duration of a contact, in which the shift from the rigid motion is of
        # first order: straight lines in epsilon extrapolate well down to its zero.
        goal, reached = float(factor ** (-1 / (exponent + 1))), None
        step = goal - e1
        while not lost and reached is None:
            aim = min(e1 + step, goal)
            slope = (x1 - x0) / (e1 - e0) if e1 > e0 else np.zeros_like(x1)
            try:
                result, x = find(factor if aim == goal else aim ** -(exponent + 1), x1 + slope * (aim - e1))
            except NumericalError as error:
                # The motion may be there though the guess was too far off: only when steps of almost nothing fail is
                # it lost.
                step /= 2
                if step < SHORTEST * goal:
                    lost = f"followed to about K times {max(aim, 1e-300) ** -(exponent + 1):.2g}: {error}"
                continue
            (e0, x0), (e1, x1) = (e1, x1), (aim, x)
            reached = result if aim == goal else None
        rungs.append((reached, lost))
    return rungs[::-1]
