"""Simulated motions as points to be drawn over the analytic curves of figures 2 and 7."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from vireport.figures.curves import Simulated
from vireport.physics import (
    Voltages,
    deflection,
    generated_voltage,
)
from vireport.simulation import BOTTOM, Attractor, Cycle
from vireport.study import Study

Floats = NDArray[np.float64]

MOST_IMPACTS = 16
"""Impacts in a period up to which a motion is drawn as points; longer ones are a cloud, for the diagram."""

NOTHING = np.nan
"""Where an impact has no partner on the other membrane."""


def simulated_points(study: Study) -> Simulated | None:
    """Every periodic motion that the simulation of a sweep found, once at each value; None where there is no sweep.

    An impact on the bottom shares a row with the impact on the top that follows it.
    """
    check = study.crosscheck
    if check is None or study.solution.sweep is None:
        return None
    rows: list[tuple[float, ...]] = []
    motion: list[int] = []
    for value, d, found in zip(check.values, check.d, check.found, strict=True):
        for cycle in _distinct(found):
            pairs = _pairs(cycle)
            motion += [motion[-1] + 1 if motion else 0] * len(pairs)
            rows += [(value, d, *pair) for pair in pairs]
    columns = np.array(rows, dtype=float).reshape(len(rows), 8).T
    names = [field.name for field in fields(Simulated) if field.name != "voltages"]
    return Simulated(
        **dict(zip(names, columns, strict=True)), voltages=_voltages(study, columns, np.array(motion, dtype=np.intp))
    )


def _distinct(found: tuple[Attractor, ...]) -> list[Cycle]:
    """The cycles among some attractors, each once; those that stick are left to the bifurcation diagram."""
    cycles = {id(one.cycle): one.cycle for one in found if one.cycle is not None and not one.cycle.sticks}
    return [cycle for cycle in cycles.values() if len(cycle.wall) <= MOST_IMPACTS]


def _pairs(cycle: Cycle) -> list[tuple[float, ...]]:
    """Rows (velocities, phases, half flight times) of a cycle: a bottom impact, and the top one that follows it."""
    count = len(cycle.wall)
    rows: list[tuple[float, ...]] = []
    for i in range(count):
        after = (i + 1) % count
        velocity, phase, flight = float(cycle.velocity[i]), float(cycle.phase[i]), float(cycle.flight[after]) / 2
        if cycle.wall[i] == BOTTOM and cycle.wall[after] != BOTTOM:
            top = float(cycle.velocity[after]), float(cycle.phase[after]), float(cycle.flight[(i + 2) % count]) / 2
            rows.append((velocity, top[0], phase, top[1], flight, top[2]))
        elif cycle.wall[i] == BOTTOM:
            rows.append((velocity, NOTHING, phase, NOTHING, flight, NOTHING))
        elif cycle.wall[i - 1] != BOTTOM:
            rows.append((NOTHING, velocity, NOTHING, phase, NOTHING, flight))
    return rows


def _voltages(study: Study, columns: Floats, motion: NDArray[np.intp]) -> Voltages | None:
    """Voltages of the simulated impacts; the average is over all impacts of a motion, as in Eq. (5.1)."""
    solution = study.solution
    if solution.membrane is None or solution.sweep is None:
        return None
    unit = np.asarray(solution.device.velocity_unit(solution.parameter, columns[0]))
    bottom = generated_voltage(unit * columns[2], solution.membrane)
    top = generated_voltage(unit * columns[3], solution.membrane)
    both = np.stack([bottom, top])
    impacts = np.bincount(motion, np.sum(~np.isnan(both), axis=0))
    average = (np.bincount(motion, np.nansum(both, axis=0)) / impacts)[motion]
    speeds = unit * np.nanmax(np.abs(columns[2:4]), axis=0, initial=0.0)
    return Voltages(bottom, top, average, deflection(speeds, solution.membrane))
