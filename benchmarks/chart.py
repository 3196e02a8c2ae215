"""Time of a chart of two inputs, beside root finding along the same loci and simulation over a grid of the same plane.

    python benchmarks/chart.py

The first peer is given a motion at the start of each locus and what happens there, and follows it by SciPy's root
finder, one input held at a time, through as many points as the chart has: without search, events or admissibility. The
second one simulates a grid of the plane, from eight starts each, which finds the stable motions only, and boundaries
to the grid's width. Times are of the processor, on one core.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from pathlib import Path
from typing import Any

import numpy as np
from record import processor_time, record
from scipy.optimize import root

from vireport import load
from vireport.map.chart.chart import PlaneLoci, loci_over
from vireport.map.chart.network import FollowedLocus
from vireport.map.chart.over import plane_of
from vireport.map.chart.plane import DevicePlane
from vireport.motions.switching import Limits
from vireport.physics.groups import Groups, by_wall
from vireport.physics.numbers import FLOATS
from vireport.simulation.attractors import attractors
from vireport.simulation.starts import random_starts, start_speed

EXAMPLE = Path(__file__).resolve().parent.parent / "examples" / "inclined.yaml"
PLANES = (
    "inclination_deg,length_m",
    "restitution,length_m",
    "capsule_mass_kg,restitution",
    "restitution_bottom,restitution_top",
)
LIMITS, CELLS, STARTS, SEED = Limits(4, 2), 32, 8, 20190301
"""Of the motions, of the grid along each input, and of the simulation at each of its points."""

TOLERANCE = 1e-9
"""Residual of a motion that the root finder is taken to have found."""


def by_root_finder(drawn: PlaneLoci) -> tuple[int, int]:
    """Follow the loci of a chart with SciPy: points that were found, and all."""
    points = [follow_by_root_finder(locus) for locus in drawn.loci]
    return sum(points), sum(len(locus.x) for locus in drawn.loci)


def follow_by_root_finder(locus: FollowedLocus) -> int:
    """Points of a locus that are found, each from the one before, with the input held that changes most."""
    path, y, solved = locus.path, locus.x[0], 0
    own = 2 * len(path.word)
    for before, after in zip(locus.x, locus.x[1:], strict=False):
        held = own + int(np.argmax(np.abs((after - before) / path.scale)[own:]))
        free = np.arange(len(y)) != held

        def conditions(part: np.ndarray, held: int = held, free: np.ndarray = free, after: np.ndarray = after) -> Any:
            x = np.empty(len(free))
            x[free], x[held] = part, after[held]
            row = x.tolist()
            value = path.condition.value(path.word, row[:own], path.plane.at(row[own:]), FLOATS)
            return [*path.residuals(row, path.plane), value]

        at = root(conditions, y[free], tol=1e-12)
        y = y.copy()
        y[free], y[held] = at.x, after[held]
        solved += bool(np.abs(at.fun).max() < TOLERANCE)
    return solved


def simulated_words(plane: DevicePlane) -> set[str]:
    """Words of the motions within the limits that a simulation over a grid of the plane ends in."""
    shares = (np.arange(CELLS) + 0.5) / CELLS
    grid = plane.low + plane.widths * np.stack(np.meshgrid(shares, shares), axis=-1).reshape(-1, 2)
    alike: dict[Any, list[Groups[float]]] = {}
    for groups in map(plane.at, grid.tolist()):
        alike.setdefault(by_wall(groups.restitution), []).append(groups)
    words = set()
    for cells in alike.values():
        r, d, gbar = cells[0].restitution, np.array([own.d for own in cells]), np.array([own.gbar for own in cells])
        ends = attractors(Groups(d, gbar, r), random_starts(d, start_speed(r, [0.0] * len(d)), STARTS, SEED))
        cycles = (end.cycle for row in ends for end in row if end.cycle is not None and not end.cycle.sticks)
        words |= {c.word for c in cycles if len(c.wall) <= LIMITS.impacts and c.period <= LIMITS.periods}
    return words


def main() -> None:
    """Print and record the table."""
    scenario, rows = load(EXAMPLE).scenario, []
    loci_over(plane_of(scenario, PLANES[0]), Limits(2, 1), cuts=0)  # imported
    attractors(
        Groups(np.ones(2), np.ones(2), 0.5), random_starts(np.ones(2), start_speed(0.5, [0.0] * 2), 1, SEED)
    )  # compiled
    for over in PLANES:
        plane = plane_of(scenario, over)
        seconds, drawn = processor_time(lambda plane=plane: loci_over(plane, LIMITS), 1)
        finder, (solved, points) = processor_time(lambda drawn=drawn: by_root_finder(drawn), 1)
        simulation, words = processor_time(lambda plane=plane: simulated_words(plane), 1)
        rows.append(
            {
                "plane": over, "seconds": seconds, "loci": len(drawn.loci), "points": points,
                "meetings": len(drawn.meetings), "words": len({locus.word for locus in drawn.loci}),
                "scipy_seconds": finder, "scipy_points": solved, "scipy_ratio": finder / seconds,
                "cells": CELLS, "simulation_seconds": simulation, "simulation_words": len(words),
                "simulation_ratio": simulation / seconds,
            }
        )  # fmt: skip
        print(
            f"{over:<28} chart {seconds:5.2f} s, {len(drawn.loci)} loci, {points} points; SciPy along the same loci "
            f"{finder:5.2f} s, {solved} points; simulation at {CELLS}x{CELLS} values {simulation:6.2f} s, "
            f"{len(words)} words"
        )
    record("chart", chart=rows)


if __name__ == "__main__":
    main()
