"""Tables of the voltages of stable motions, of what the ball mass does to them, and of the energy they convert."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from vireport.design.solution import Solution
from vireport.physics.energy import Membrane, voltages
from vireport.text.formatting import Exactness, capital, exact, rounded_text, stated_text
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words

MASS_FACTORS = (0.5, 1.0, 2.0)
"""Factors on the ball mass with which the voltage is evaluated again."""

PUBLISHED_MASS_RATIO = 0.2
"""m/M in published code for this device."""

IN_KILOVOLTS = 1e4
"""The largest voltage of a table from which on it is in kV [V]."""


class _Place(NamedTuple):
    """A stable motion: where it is, the swept parameter there as text, the group d, and the impact speeds [m/s]."""

    name: str
    swept: str
    d: float
    speed_bottom: float
    speed_top: float


def voltage_tables(solution: Solution, exactness: Exactness, say: Words) -> Iterator[Table]:
    """Voltages of the stable motions at the design point and the ends of the stable ranges, the first with other balls.

    None where there is no membrane or no such motion; of the design point, energies where the dielectric is stated.
    """
    membrane, stable = solution.membrane, list(_places(solution, exactness, say))
    if membrane is None or not stable:
        return

    def text(value: float, power: int = 0) -> str:
        return rounded_text(float(value), exactness, power)

    gains = [_gains(place, membrane) for place in stable]
    unit, power = _unit(max(volts for bottom, top, *_ in gains for volts in (bottom, top)))
    rows = [
        (capital(name), swept, *map(text, state), *(text(volts, power) for volts in gain[:3]), text(gain[3], 3))
        for (name, swept, *state), gain in zip(stable, gains, strict=True)
    ]
    note = say("voltages_note", membrane)
    yield worded_table(say, "voltages", "tnnnnnnnn", rows, solution.parameter, unit, note=note)

    balls = [(say("mass", factor), factor * membrane.ball_mass_kg) for factor in MASS_FACTORS]
    balls += [(say("published_mass", PUBLISHED_MASS_RATIO), PUBLISHED_MASS_RATIO * solution.device.capsule_mass_kg)]
    effects = [(*ball, *_gains(stable[0], replace(membrane, ball_mass_kg=ball[1]))[2:]) for ball in balls]
    unit, power = _unit(max(average for *_, average, _ in effects))
    rows = [
        (name, stated_text(1e3 * mass), text(depth, 3), text(depth / membrane.active_radius_m), text(average, power))
        for name, mass, average, depth in effects
    ]
    note = say("masses_note", membrane.exponent, solution.device.recoils)
    yield worded_table(say, "masses", "tnnnn", rows, stable[0].name, unit, note=note)

    design, dielectric = solution.design, membrane.dielectric
    if design is not None and dielectric is not None and design.conversion_by_motion is not None:
        x, powers = design.conversion_by_motion, (3, 3, 0, 2, 2)
        field = x.field_v_m / dielectric.breakdown_field_v_m
        columns = np.array([x.energy_bottom_j, x.energy_top_j, x.power_mw, x.efficiency, field])
        rows = [tuple(map(text, column, powers)) for column in columns.T[design.motions.stable_mask]]
        if rows:
            yield worded_table(say, "energy", "nnnnn", rows, note=say("energy_note"))


def _unit(most: float) -> tuple[str, int]:
    """Unit of a table whose largest voltage is known, and the power of ten that its numbers are multiplied by."""
    return ("kV", -3) if most >= IN_KILOVOLTS else ("V", 0)


def _gains(place: _Place, membrane: Membrane) -> tuple[float, float, float, float]:
    """Gain over the bias at the bottom, at the top and on average [V], and the deflection on the harder side [m]."""
    gain = voltages(np.array(place.speed_bottom), np.array(place.speed_top), membrane)
    return float(gain.bottom_v), float(gain.top_v), float(gain.average_v), float(gain.deflection_m)


def _places(solution: Solution, exactness: Exactness, say: Words) -> Iterator[_Place]:
    """The stable motions at the design point, then those at the ends of the stable ranges."""
    design = solution.design
    if design is not None:
        motions = design.motions
        columns = (motions.d, motions.velocity_bottom, motions.velocity_top)
        for state in zip(*(column[motions.stable_mask] for column in columns), strict=True):
            yield _place(solution, say("at_design"), design.value, exact(design.value), state)
    for value, point in (end for part in solution.stable_ranges for end in part.ends):
        name = say("sweep_end") if point is None else say("range_end", point)
        swept = exact(value) if point is None else rounded_text(value, exactness)
        for state in _at(solution, value):
            yield _place(solution, name, value, swept, state)


def _place(solution: Solution, name: str, value: float, swept: str, state: tuple[float, ...]) -> _Place:
    d, bottom, top = map(float, state)
    unit = float(solution.device.velocity_unit(solution.parameter, value))
    return _Place(name, swept, d, unit * bottom, -unit * top)


def _at(solution: Solution, value: float) -> Iterator[tuple[float, float, float]]:
    """Motions with which a stable stretch of a branch begins or ends; of mirror images the first."""
    for branch in solution.branches:
        motions = branch.motions
        for part in branch.family.segments:
            for row in (part.first, part.last):
                if part.stable and branch.mirror_of is None and float(motions.sweep_value[row]) == value:
                    yield motions.d[row], motions.velocity_bottom[row], motions.velocity_top[row]
