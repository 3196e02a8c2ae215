"""Many designs at once: their stable motions by the closed form, what they come to, and which lack a margin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.design import FACTOR_OF, HIGHEST_RESTITUTION, devices_off
from vireport.motions import PointwiseMotions, differentiated_motions, find_motions
from vireport.optimise.problem import SHAKER, Problem, of_impacts
from vireport.physics import (
    Device,
    Dielectric,
    Membrane,
    magnitude,
)
from vireport.scenario import DesignInput, Parameter

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]

OF_MOTION = 2
"""Slacks in front of those of the limits: of stability, and of the gap to a membrane."""

AT_FOLD = 2.5
"""Power of a trace's distance from a fold, which itself goes with the root of the inputs' distance. With more than 2 a
search that takes the power for linear nears the fold from inside; beyond it there is no motion to return by."""

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
    """Evaluate designs t, shape (cells, inputs), by the closed form, as exactly as doubles allow.

    Complex ones give derivatives, see `analysis.differentiated_motions`.
    """
    device, membrane = problem.at(t)
    count = len(t)
    found, r = _motions(device, count)
    rows = np.flatnonzero(found.stable(r))
    cell = found.cell[rows]

    def worst(values: Floats, least: bool) -> Floats:
        return _extreme(values, cell, count, np.minimum if least else np.maximum)

    with np.errstate(all="ignore"):
        columns = _of_motions(device, membrane, found, rows, r)
        slack = [worst(part[rows], True) for part in _slack(found, r)]
        for quantity, least, limit in problem.limits:
            if quantity in SHAKER:
                shaker = device.shaker(Parameter.LENGTH, device.length_m)
                slack.append(np.broadcast_to(1 - getattr(shaker, quantity) / limit, count))
            else:
                ratio = worst(columns[quantity], least) / limit
                slack.append(ratio - 1 if least else 1 - ratio)
    nothing = np.full_like(slack[0], np.nan)
    value = worst(columns[problem.objective], True) if problem.objective in columns else nothing
    stable = np.isfinite(slack[0])
    return Cells(stable, value, np.where(stable[:, None], np.stack(slack, axis=1), np.nan))


def keeps_motion(problem: Problem, t: Floats, share: float | Floats) -> Mask:
    """Whether designs have stable motion where any one input is off by a share, or each by its own, to either side.

    A design has that margin only if so: where this fails, a stable motion ends on the way.
    """
    kept, share = np.ones(len(t), dtype=bool), np.broadcast_to(share, len(t))
    for ring in RINGS:
        for varied, sign in DISPLACED:
            rows = np.flatnonzero(kept)
            device, _ = problem.at(t[rows])
            value = np.broadcast_to(getattr(device, varied) * (1 + sign * ring * share[rows]), len(rows))
            high = HIGHEST_RESTITUTION if varied is DesignInput.RESTITUTION else varied.limits[1]
            moved = np.flatnonzero(value <= high)  # beyond it no margin is looked for
            device, _ = problem.at(t[rows[moved]])
            found, r = _motions(device.with_values({varied: value[moved]}), len(moved))
            there = np.zeros(len(moved), dtype=bool)
            there[found.cell[found.stable(r)]] = True
            kept[rows[moved]] = there
    return kept


def corner_slack(problem: Problem, t: Floats, share: float = 1.0) -> Floats:
    """How far the devices at the corners of the tolerances are from the end of stable motion, shape (cells, corners).

    Of the motion that is farthest from it: the lesser of its slacks of stability and gap, as in `Cells`; negative where
    none is stable, NaN where there is none. Every device within the tolerances has stable motion only if all corners
    have.

    Parameters
    ----------
    problem : Problem
    t : ndarray, shape (cells, inputs)
        May be complex, see `evaluate`.
    share : float
        Of the tolerances.
    """
    device, _ = problem.at(t)
    widths = problem.half_widths(device)
    factors = sorted({FACTOR_OF[varied] for varied in widths})
    ends = np.array(list(product((-share, share), repeat=len(factors)))).T if widths else np.empty((0, 0))
    slack = []
    for end in ends.T:
        steps = np.array([end[factors.index(FACTOR_OF[x])] * (-1 if x is DesignInput.AMPLITUDE else 1) for x in widths])
        found, r = _motions(devices_off(device, widths, np.tile(steps[:, None], len(t))), len(t))
        with np.errstate(all="ignore"):
            slack.append(_extreme(np.minimum(*_slack(found, r)), found.cell, len(t), np.maximum))
    return np.stack(slack, axis=1) if slack else np.empty((len(t), 0))


def _motions(device: Device, count: int) -> tuple[PointwiseMotions, Floats]:
    """All motions of devices, and the restitution of each device; with derivatives where an input is complex."""
    r, (d, gbar) = np.asarray(device.restitution), device.groups(Parameter.LENGTH, device.length_m)
    kind = np.result_type(d, gbar, r, float)
    d, gbar, whole = (np.array(np.broadcast_to(x, count), dtype=kind) for x in (d, gbar, r))
    with np.errstate(all="ignore"):
        if np.iscomplexobj(d):
            return differentiated_motions(d, gbar, whole, device.period_ratio), whole
        return find_motions(d, gbar, whole if r.ndim else float(r), device.period_ratio), whole


def _slack(found: PointwiseMotions, r: Floats) -> tuple[Floats, Floats]:
    """How far motions are from losing their stability and from grazing.

    By the trace over 1 + r^4, with a power of its distance from a fold, see `AT_FOLD`; by the gap over d.
    """
    share = found.trace / (1 + r[found.cell] ** 4)
    to_fold = (1 - share) * magnitude(1 - share) ** (AT_FOLD - 1)
    return np.minimum(1 + share, to_fold), found.wall_gap / found.orbit.d


def _extreme(values: Floats, cell: Ints, count: int, of: np.ufunc) -> Floats:
    """Least or largest value of the motions of each cell, which are in order; NaN where there is none."""
    whole, first = np.full(count, np.nan, dtype=values.dtype), np.flatnonzero(np.diff(cell, prepend=-1))
    whole[cell[first]] = of.reduceat(values, first) if cell.size else values
    return whole


def _of_motions(
    device: Device, membrane: Membrane | None, found: PointwiseMotions, rows: Ints, r: Floats
) -> dict[str, Floats]:
    """The quantities of stable motions."""
    cell, orbit = found.cell[rows], found.orbit.select(rows)
    gap = np.minimum(found.wall_gap[rows], orbit.d)

    def of_cell(x: Any) -> Floats:
        return np.broadcast_to(np.asarray(x), len(r))[cell]

    unit = of_cell(device.velocity_unit(Parameter.LENGTH, device.length_m))
    period = of_cell(device.period_ratio / device.frequency_hz)
    membrane = None if membrane is None else _each(membrane, of_cell)
    return of_impacts(orbit.velocity_bottom, orbit.velocity_top, gap, unit, membrane, of_cell(r), period)


def _each(membrane: Membrane, of_cell: Callable[[Any], Any]) -> Membrane:
    """A membrane whose numbers are arrays, one for each motion."""
    parts = {one.name: getattr(membrane, one.name) for one in fields(Membrane)}
    dielectric: Dielectric | None = parts.pop("dielectric")
    if dielectric is not None:
        dielectric = Dielectric(*(of_cell(getattr(dielectric, one.name)) for one in fields(Dielectric)))
    return Membrane(**{name: of_cell(x) for name, x in parts.items()}, dielectric=dielectric)
