"""Voltages of the stable motions at the design point and the ends of the stable ranges, and what the ball mass does."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.design.solution import Solution
from vireport.motions.points import Point
from vireport.physics.energy import Membrane, Voltages, voltages

MASS_FACTORS = (0.5, 1.0, 2.0)
"""Factors on the ball mass with which the voltage is evaluated again."""

PUBLISHED_MASS_RATIO = 0.2
"""m/M in published code for this device."""


class Place(Struct, frozen=True):
    """A stable motion with its voltages.

    Attributes
    ----------
    at_design : bool
        Whether it is one of the design point; else it is an end of a stable range.
    point : Point or None
        What ends the range; None where the sweep does.
    swept : float
        The swept parameter.
    d : float
    speed_bottom, speed_top : float
        Impact speeds [m/s].
    bottom_v, top_v, average_v : float
        Gain over the bias [V].
    deflection_m : float
        Of the membrane that is struck harder [m].
    """

    at_design: bool
    point: Point | None
    swept: float
    d: float
    speed_bottom: float
    speed_top: float
    bottom_v: float
    top_v: float
    average_v: float
    deflection_m: float


class MassEffect(Struct, frozen=True):
    """Voltage and deflection with another ball mass.

    Attributes
    ----------
    factor : float or None
        Of the scenario's mass; None for `PUBLISHED_MASS_RATIO` of the capsule's.
    mass_kg, deflection_m, average_v : float
    """

    factor: float | None
    mass_kg: float
    deflection_m: float
    average_v: float


def places(solution: Solution) -> list[Place]:
    """The stable motions at the design point, then those at the ends of the stable ranges; empty without a membrane."""
    membrane, design, rows = solution.membrane, solution.design, list[tuple[Any, ...]]()
    if membrane is None:
        return []
    if design is not None:
        motions = design.motions
        states = zip(
            motions.d[motions.stable_mask],
            motions.velocity_bottom[motions.stable_mask],
            motions.velocity_top[motions.stable_mask],
            strict=True,
        )
        rows += [(True, None, design.value, *state) for state in states]
    ends = (end for part in solution.stable_ranges for end in part.ends)
    rows += [(False, point, value, *state) for value, point in ends for state in _at(solution, value)]
    stable = []
    for at_design, point, value, *state in rows:
        d, bottom, top = map(float, state)
        unit = float(solution.device.velocity_unit(solution.parameter, value))
        gain = _voltages(unit * bottom, -unit * top, membrane)
        numbers = (float(x) for x in (gain.bottom_v, gain.top_v, gain.average_v, gain.deflection_m))
        stable.append(Place(at_design, point, value, d, unit * bottom, -unit * top, *numbers))
    return stable


def _voltages(speed_bottom: float, speed_top: float, membrane: Membrane) -> Voltages:
    return voltages(np.array(speed_bottom), np.array(speed_top), membrane)


def _at(solution: Solution, value: float) -> Iterator[tuple[float, float, float]]:
    """Motions with which a stable stretch of a branch begins or ends; of mirror images the first."""
    for branch in solution.branches:
        motions = branch.motions
        for part in branch.family.segments:
            for row in (part.first, part.last):
                if part.stable and branch.mirror_of is None and float(motions.sweep_value[row]) == value:
                    yield motions.d[row], motions.velocity_bottom[row], motions.velocity_top[row]


def mass_effects(solution: Solution) -> list[MassEffect]:
    """What the ball mass makes of the voltage of the first stable motion; empty where there is none."""
    membrane, stable = solution.membrane, places(solution)
    if membrane is None or not stable:
        return []
    masses = [(factor, factor * membrane.ball_mass_kg) for factor in MASS_FACTORS]
    effects = []
    for factor, mass in [*masses, (None, PUBLISHED_MASS_RATIO * solution.device.capsule_mass_kg)]:
        gain = _voltages(stable[0].speed_bottom, stable[0].speed_top, replace(membrane, ball_mass_kg=mass))
        effects.append(MassEffect(factor, mass, float(gain.deflection_m), float(gain.average_v)))
    return effects
