"""Many designs at once: their stable motions by the closed form, what they come to, and which lack a margin."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import HIGHEST_RESTITUTION, PointwiseMotions, find_motions
from vireport.optimise.problem import ACCELERATION, FIELD, STROKE, Problem, quantities
from vireport.physics import Device, Membrane, conversion, voltages
from vireport.scenario import DesignInput, Parameter

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]

OF_MOTION = 2
"""Slacks in front of those of the limits: of stability, and of the gap to a membrane."""

RINGS = 1.0, 0.5
"""Shares of a margin at which a motion is looked for: a device with the margin has one at each."""

DISPLACED = (
    *((DesignInput.FREQUENCY, sign) for sign in (-1, 1)),
    *((varied, -1) for varied in (DesignInput.AMPLITUDE, DesignInput.CAPSULE_MASS)),
    *((varied, sign) for varied in (DesignInput.INCLINATION, DesignInput.RESTITUTION) for sign in (-1, 1)),
)
"""Inputs that are moved, and whither. By d = 4 M s f^2/F and gbar = M g sin(beta)/F all others lie between these."""


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """What is known of designs, arrays with a row for each.

    Attributes
    ----------
    stable : ndarray of bool
        Whether there is a stable motion.
    value : ndarray
        The objective, the least of the stable motions; NaN where there is none, or where it is a margin.
    slack : ndarray, shape (cells, OF_MOTION + limits)
        How far on the right side of its limit each quantity is, over the limit, in the worst stable motion; negative
        on the wrong side. The first two are for stability and the gap to a membrane.
    """

    stable: Mask
    value: Floats
    slack: Floats


def evaluate(problem: Problem, t: Floats) -> Cells:
    """Evaluate designs t, shape (cells, inputs), by the closed form, as exactly as doubles allow."""
    device, membrane = problem.at(t)
    count = len(t)
    found, rows, r = _stable(device, count)
    cell = found.cell[rows]
    first = np.flatnonzero(np.diff(cell, prepend=-1))

    def worst(values: Floats, least: bool) -> Floats:
        whole = np.full(count, np.nan)
        reduce = np.minimum.reduceat if least else np.maximum.reduceat
        whole[cell[first]] = reduce(values, first) if cell.size else values
        return whole

    with np.errstate(all="ignore"):
        columns = _of_motions(device, membrane, found, rows, r)
        trace = found.trace[rows]
        slack = [worst(1 - np.abs(trace) / (1 + r[cell] ** 4), True)]
        slack.append(worst(found.wall_gap[rows] / found.orbit.d[rows], True))
        for quantity, least, limit in problem.limits:
            if quantity in (ACCELERATION, STROKE):
                shaker = device.shaker(Parameter.LENGTH, device.length_m)
                ratio = (shaker.acceleration_g if quantity == ACCELERATION else shaker.stroke_m) / limit
                slack.append(np.broadcast_to(1 - ratio, count))
            else:
                ratio = worst(columns[quantity], least) / limit
                slack.append(ratio - 1 if least else 1 - ratio)
    nothing = np.full(count, np.nan)
    value = worst(columns[problem.objective], True) if problem.objective in columns else nothing
    stable = np.isfinite(slack[0])
    return Cells(stable, value, np.where(stable[:, None], np.stack(slack, axis=1), np.nan))


def keeps_motion(problem: Problem, t: Floats, share: float) -> Mask:
    """Whether designs have stable motion where any one input is off by a share, to either side.

    A design has that margin only if so: where this fails, a stable motion ends on the way.
    """
    kept = np.ones(len(t), dtype=bool)
    for ring in RINGS:
        for varied, sign in DISPLACED:
            rows = np.flatnonzero(kept)
            device, _ = problem.at(t[rows])
            value = np.broadcast_to(getattr(device, varied) * (1 + sign * ring * share), len(rows))
            high = HIGHEST_RESTITUTION if varied is DesignInput.RESTITUTION else varied.limits[1]
            moved = np.flatnonzero(value <= high)  # beyond it no margin is looked for
            device, _ = problem.at(t[rows[moved]])
            changed: dict[str, Any] = {varied: value[moved]}
            found, stable, _ = _stable(replace(device, **changed), len(moved))
            there = np.zeros(len(moved), dtype=bool)
            there[found.cell[stable]] = True
            kept[rows[moved]] = there
    return kept


def _stable(device: Device, count: int) -> tuple[PointwiseMotions, Ints, Floats]:
    """All motions of devices, which rows of them are stable, and the restitution of each device."""
    x, r = device.groups(Parameter.LENGTH, device.length_m), np.asarray(device.restitution, dtype=float)
    d, gbar = (np.array(np.broadcast_to(np.asarray(one, dtype=float), count)) for one in x)
    with np.errstate(all="ignore"):
        found = find_motions(d, gbar, r if r.ndim else float(r), device.period_ratio)
        r = np.broadcast_to(r, count)
        stable = found.stable(r)
    return found, np.flatnonzero(stable), r


def _of_motions(
    device: Device, membrane: Membrane | None, found: PointwiseMotions, rows: Ints, r: Floats
) -> dict[str, Floats]:
    """The quantities of stable motions."""
    cell, orbit = found.cell[rows], found.orbit.select(rows)
    gap = np.minimum(found.wall_gap[rows], orbit.d)

    def of_cell(x: Any) -> Floats:
        return np.broadcast_to(np.asarray(x, dtype=float), len(r))[cell]

    period = of_cell(device.period_ratio / device.frequency_hz)
    if membrane is None:
        return quantities(orbit.velocity_bottom, gap, None, None, period)
    membrane = replace(membrane, ball_mass_kg=of_cell(membrane.ball_mass_kg))  # type: ignore[arg-type]
    unit = of_cell(device.velocity_unit(Parameter.LENGTH, device.length_m))
    speeds = unit * orbit.velocity_bottom, unit * orbit.velocity_top
    volts, dielectric = voltages(*speeds, membrane), membrane.dielectric
    if dielectric is None:
        return quantities(orbit.velocity_bottom, gap, volts, None, period)
    gains = volts.bottom_v, volts.top_v
    converted = conversion(gains, speeds, membrane, dielectric, of_cell(r), period)
    columns = quantities(orbit.velocity_bottom, gap, volts, converted, period)
    return columns | {FIELD: 100 * converted.field_v_m / dielectric.breakdown_field_v_m}
