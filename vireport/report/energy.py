"""The section on voltages: of the stable motions, and what the ball mass makes of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vireport.physics import Membrane, Voltages, voltages
from vireport.report.pages import Block, Paragraph
from vireport.scenario import Parameter
from vireport.study import Study
from vireport.text import Table, numbers, scaled, significant, texts

MASS_FACTORS = (0.5, 1.0, 2.0)
"""Of the ball mass, for what the voltage makes of it."""

PUBLISHED_MASS_RATIO = 0.2
"""m/M in published code for this device."""

CYCLE = (
    "Energy gained at an impact, *C*_0 *U*_imp (*U*_imp − *U*_in)/2, in a cycle of constant charge with the flat "
    "membrane's capacitance *C*_0, without losses of the circuit; efficiency over the kinetic energy lost at the "
    "impacts; field *U*_imp over the thickness."
)

MANY_VOLTS = 1e4
"""From here on a column is in kilovolts."""


@dataclass(frozen=True, slots=True)
class Place:
    """A stable motion whose voltages are shown.

    Attributes
    ----------
    name : str
    swept : float
        The swept parameter there.
    d : float
    speed_bottom, speed_top : float
        Impact speeds [m/s].
    """

    name: str
    swept: float
    d: float
    speed_bottom: float
    speed_top: float

    def voltages(self, membrane: Membrane) -> Voltages:
        """What its impacts generate."""
        return voltages(np.array(self.speed_bottom), np.array(self.speed_top), membrane)


def energy(study: Study) -> Iterator[Block]:
    """Voltages of the stable motions, and how they depend on the ball mass."""
    membrane = study.solution.membrane
    if membrane is None:
        return
    origin = "set over the scenario" if study.loaded.is_set_over("device.ball_mass_kg") else "given by the scenario"
    yield Paragraph(
        f"The ball mass *m* = {scaled(membrane.ball_mass_kg, 3, 8)} g is {origin} (device.ball_mass_kg); the paper "
        "does not state it. All voltages are *U*_imp − *U*_in, the gain over the bias."
    )
    motions = places(study)
    if not motions:
        yield Paragraph("There is no stable motion to evaluate them for.")
        return
    yield _voltage_table(motions, study.solution.parameter, membrane)
    yield _mass_table(motions[0], study.solution.device.capsule_mass_kg, membrane)
    yield from _conversion(study)
    power = 1 / (membrane.exponent + 1)
    yield Paragraph(
        f"By (5.5), *δ* grows with the power 1/(*h* + 1) = {significant(power, 4)} of *m*: a ball of twice "
        f"the mass goes {significant(2**power, 3)} times as deep. The motion does not depend on *m*, as "
        "long as *m* is small against *M*."
    )


def _conversion(study: Study) -> Iterator[Block]:
    """Energy, power, efficiency and field of the stable motions at the design point."""
    design, membrane = study.solution.design, study.solution.membrane
    if design is None or design.conversion is None or membrane is None or membrane.dielectric is None:
        return
    x, stable = design.conversion, design.motions.stable
    over_breakdown = x.field_v_m / membrane.dielectric.breakdown_field_v_m
    energies = 1e3 * x.energy_bottom_j, 1e3 * x.energy_top_j
    columns = np.stack([*energies, x.power_mw, 100 * x.efficiency, 100 * over_breakdown])[:, stable]
    rows = tuple(tuple(significant(value, 5) for value in row) for row in columns.T.tolist())
    if rows:
        head = numbers("bottom [mJ]", "top [mJ]", "mean power [mW]", "efficiency [%]", "field over breakdown [%]")
        yield Table("Electrical energy of the stable motions at the design point", head, rows, CYCLE)


def places(study: Study) -> list[Place]:
    """The stable motions at the design point, then those at the ends of the stable ranges."""
    motions = []
    if study.solution.design is not None:
        x = study.solution.design.motions
        for row in np.nonzero(x.stable)[0]:
            state = float(x.d[row]), float(x.velocity_bottom[row]), float(x.velocity_top[row])
            motions.append(_place(study, "Design point", study.solution.design.value, *state))
    for part in study.solution.stable_ranges:
        for value, point in part.ends:
            name = "End of the sweep" if point is None else f"{point.label}, end of the stable range"
            motions += [_place(study, name, value, *state) for state in _at(study, value)]
    return motions


def _place(study: Study, name: str, value: float, d: float, bottom: float, top: float) -> Place:
    unit = float(study.solution.device.velocity_unit(study.solution.parameter, value))
    return Place(name, value, d, unit * bottom, -unit * top)


def _at(study: Study, value: float) -> Iterator[tuple[float, float, float]]:
    """Motions with which a stable stretch of a branch begins or ends; of mirror images the first."""
    for branch in study.solution.branches:
        x = branch.motions
        for part in branch.segments():
            for row in (part.first, part.last):
                if part.stable and branch.mirror_of is None and float(x.sweep_value[row]) == value:
                    yield float(x.d[row]), float(x.velocity_bottom[row]), float(x.velocity_top[row])


def _unit(largest: float) -> tuple[str, int]:
    """Unit of a column of voltages, and the power of ten that brings volts there."""
    return ("kV", -3) if largest >= MANY_VOLTS else ("V", 0)


def _voltage_table(motions: Sequence[Place], swept: Parameter, membrane: Membrane) -> Table:
    gains = [place.voltages(membrane) for place in motions]
    unit, power = _unit(max(float(max(gain.bottom_v, gain.top_v)) for gain in gains))
    rows = [
        (
            place.name,
            significant(place.swept, 8),
            significant(place.d, 8),
            significant(place.speed_bottom, 5),
            significant(place.speed_top, 5),
            *(scaled(float(volts), power, 5) for volts in (gain.bottom_v, gain.top_v, gain.average_v)),
            scaled(float(gain.deflection_m), 3, 4),
        )
        for place, gain in zip(motions, gains, strict=True)
    ]
    place = numbers(f"*{swept.symbol}* [{swept.unit}]", "*d*", "*V*_B [m/s]", "*V*_T [m/s]")
    gain = numbers(f"bottom [{unit}]", f"top [{unit}]", f"*U*_ave [{unit}]", "*δ* [mm]")
    radius = scaled(membrane.active_radius_m, 3, 6)
    note = f"*V* are the impact speeds, *δ* the larger deflection; *R*_c = {radius} mm."
    return Table("Voltages of the stable motions", (*texts("Stable motion"), *place, *gain), tuple(rows), note)


def _mass_table(place: Place, capsule_mass: float, membrane: Membrane) -> Table:
    masses = [
        ("*m*, this scenario" if factor == 1 else f"{significant(factor)} *m*", factor * membrane.ball_mass_kg)
        for factor in MASS_FACTORS
    ]
    ratio = significant(PUBLISHED_MASS_RATIO)
    masses.append((f"{ratio} *M*, as in published code for this device", PUBLISHED_MASS_RATIO * capsule_mass))
    gains = [place.voltages(replace(membrane, ball_mass_kg=each)) for _, each in masses]
    unit, power = _unit(max(float(gain.average_v) for gain in gains))
    rows = [
        (
            name,
            scaled(each, 3, 6),
            scaled(float(gain.deflection_m), 3, 4),
            significant(float(gain.deflection_m) / membrane.active_radius_m, 3),
            scaled(float(gain.average_v), power, 5),
        )
        for (name, each), gain in zip(masses, gains, strict=True)
    ]
    return Table(
        f"How *U*_ave depends on the ball mass: {place.name[0].lower()}{place.name[1:]}",
        (*texts("Ball mass"), *numbers("[g]", "*δ* [mm]", "*δ*/*R*_c", f"*U*_ave [{unit}]")),
        tuple(rows),
    )
