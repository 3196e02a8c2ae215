"""What the bench answers for a scenario: at once what a hand waits for, then its margins, then all that a run finds.

Each answer is plain data for JSON, with the names of results.json where that has the same numbers, and comes from the
functions that a run uses: the page computes nothing.
"""

from __future__ import annotations

import numpy as np

from vireport.base.errors import UsageError
from vireport.base.records import plain
from vireport.bench.controls import values_of
from vireport.design.margins import margins_of
from vireport.design.plane import Plane
from vireport.design.solution import Solution, solution_of
from vireport.motions.branches import Branch
from vireport.motions.one_to_one import ball_path
from vireport.motions.stability import eigenvalues
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.scenario.blocks import Scenario
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DesignInput
from vireport.scenario.rules import ADDED_IF_FULL
from vireport.study.judging.designs import Designs
from vireport.study.plan import ALL_FORMATS, FIGURES, Task
from vireport.study.results import margin_data, motion_columns
from vireport.study.study import Study, sweep_of

NOTHING, UNSTABLE, STABLE = 0, 1, 2
"""What a cell of the plane of two inputs has: no 1:1 motion, unstable ones alone, or a stable one."""

PLANE = 108, 81
"""Cells of that plane, across and up."""

OF_REPORTS = {*ALL_FORMATS, *FIGURES, Task.CIRCLES, Task.REPRODUCTION}
"""Steps of a run that the page has no part in."""

DRAWN_BEFORE = "branches", "critical_points", "stable_range", "table_1"
"""What results.json has of a sweep, which the first answer has told already."""


def first_answer(loaded: Loaded) -> dict[str, object]:
    """The motions along the sweep and at the design point, without their margins.

    Returns
    -------
    dict
        ``values`` of the controls by their paths; ``swept`` and the ``branches`` along it, ``points`` and ``stable``
        ranges; ``motions`` of the design point, which of them is ``shown``, and the ``path`` of ball and capsule.
    """
    scenario = loaded.scenario
    device, membrane = Device.of(scenario), Membrane.of(scenario)
    solution = solution_of(device, membrane, sweep_of(scenario), _has_design(scenario), margins=False)
    return {
        "values": values_of(scenario),
        "blocks": [block for block in ADDED_IF_FULL if getattr(scenario, block) is not None],
        "swept": _swept(scenario),
        "branches": [_branch(branch) for branch in solution.branches],
        "points": [
            {
                "label": point.label,
                "words": point.event.words,
                "sweep_value": point.sweep_value,
                "branch": point.families[0],
            }
            for point in solution.critical_points
        ],
        "stable": [[part.start, part.end] for part in solution.stable_ranges],
        **_at_design(solution),
    }


def margins_answer(loaded: Loaded) -> dict[str, object]:
    """How far the design point's stable motions are from their ends, nearest first; null without a design point.

    It is told without the labels of a sweep, which need not be solved for it.
    """
    if not _has_design(loaded.scenario):
        return {"margins": None, "unresolved": []}
    design = solution_of(Device.of(loaded.scenario), None, None, True, margins=False).design
    assert design is not None
    ends = margins_of(Device.of(loaded.scenario), design.motions)
    rows = [plain(margin_data(margin)) for margin in ends.margins]
    return {
        "margins": [{key: value for key, value in margin.items() if key != "label"} for margin in rows],
        "unresolved": list(ends.unresolved),
    }


def _has_design(scenario: Scenario) -> bool:
    return scenario.value_of(scenario.parameter) is not None


def study_answer(study: Study) -> dict[str, object]:
    """All that a run finds out, but for what is drawn along the sweep: the verdict in words, and results.json.

    It has the ``digits`` to show of numbers of motion and margins.
    """
    opening = study.opening.worded()
    return {
        "verdict": {
            "status": opening.status,
            "sentence": opening.sentence,
            "facts": [{"status": status, "text": text} for status, text in opening.facts],
            "tiles": [
                {"status": tile.status, "label": tile.label, "value": tile.value, "remark": tile.remark}
                for tile in opening.tiles
            ],
        },
        "digits": study.evidence.exactness.digits,
        "results": {name: part for name, part in study.to_dict(printed=True).items() if name not in DRAWN_BEFORE},
        "left_out": [
            {"what": step.task.what, "why": step.why} for step in study.plan.left_out if step.task not in OF_REPORTS
        ],
    }


def plane_answer(loaded: Loaded, axes: tuple[str, str], ranges: tuple[tuple[float, float], ...]) -> dict[str, object]:
    """What there is in the plane of two inputs around the design: no 1:1 motion, unstable ones, or a stable one.

    Parameters
    ----------
    loaded : Loaded
    axes : tuple of str
        Inputs across and up, by their keys; see `DesignInput`.
    ranges : tuple of (float, float)
        Of each.

    Returns
    -------
    dict
        ``cells``, rows from the lower end upwards: `NOTHING`, `UNSTABLE` or `STABLE`.

    Raises
    ------
    UsageError
        For inputs that are none, or a range that is none of theirs; and where the plane is not known.
    """
    device = Device.of(loaded.scenario).constant_restitution("the plane of two inputs")
    inputs = [_input(device, key) for key in axes]
    if not _has_design(loaded.scenario):
        raise UsageError("the plane of two inputs is that around a design point (give the value of the swept input)")
    if len(set(inputs)) < 2:
        raise UsageError("the plane has two inputs (name another one)")
    low, high = np.array([_range(varied, ends) for varied, ends in zip(inputs, ranges, strict=True)]).T
    x, y = Plane((inputs[0], inputs[1]), low, high).centres(PLANE)
    values = dict(zip(inputs, (grid.ravel() for grid in np.meshgrid(x, y)), strict=True))
    designs = Designs(loaded.scenario, device.with_values(values), None, x.size * y.size)
    cells = np.zeros(designs.count, dtype=np.intp)
    cells[designs.motions.cell[designs.motions.admissible]] = UNSTABLE
    cells[designs.cell] = STABLE
    return {
        "axes": list(axes),
        "ranges": [list(ends) for ends in ranges],
        "cells": cells.reshape(y.size, x.size).tolist(),
    }


def _input(device: Device, key: str) -> DesignInput:
    by_name = {varied.value: varied for varied in device.inputs}
    if key not in by_name:
        raise UsageError(f"{key!r} is no input of the device (allowed: {', '.join(by_name)})")
    return by_name[key]


def _range(varied: DesignInput, ends: tuple[float, float]) -> tuple[float, float]:
    """The range of an axis, if the input may have all of it."""
    low, high = varied.limits
    start, end = ends
    if not low <= start < end <= high:
        raise UsageError(f"{varied}: no range from {start:g} to {end:g} (allowed: ascending, {low:g} to {high:g})")
    return ends


def _swept(scenario: Scenario) -> dict[str, object] | None:
    if scenario.sweep is None:
        return None
    swept, ends = scenario.sweep.parameter, (scenario.sweep.from_, scenario.sweep.to)
    return {
        "parameter": swept,
        "path": swept.path,
        "quantity": swept.quantity,
        "symbol": swept.symbol,
        "unit": swept.unit,
        "from": min(ends),
        "to": max(ends),
        "value": scenario.value_of(swept),
    }


CURVES = (
    *("sweep_value", "velocity_bottom", "velocity_top", "phi_bottom_rad", "phi_top_rad", "q", "discriminant"),
    *("u_bottom_v", "u_top_v", "u_ave_v"),
)
"""What figures show of the motions of a branch; all columns would take twice as long on their way to the page."""


def _branch(branch: Branch) -> dict[str, object]:
    """A branch as it is drawn: its motions, and the pieces of it that are motions, with whether they are stable."""
    motions = branch.motions
    columns = motion_columns(motions, branch.voltages_by_motion)
    real = {
        f"multiplier_{k}": np.real(eigenvalue).tolist()
        for k, eigenvalue in enumerate(eigenvalues(motions.trace, motions.decay), 1)
    }
    return {
        "number": branch.number,
        "family": branch.symmetry,
        "mirror_of": branch.mirror_of,
        "pieces": [[part.first, part.last, part.stable] for part in branch.family.segments if part.admissible],
        "labels": {row: point.label for row, point in branch.family.critical_points.items() if point.label},
        **{name: column for name, column in columns.items() if name in CURVES},
        **real,
    }


def _at_design(solution: Solution) -> dict[str, object]:
    design = solution.design
    if design is None:
        return {"motions": None, "shown": None, "path": None}
    motions = design.motions
    columns = {"family": list(design.families), **motion_columns(motions, design.voltages_by_motion)}
    row = motions.drawn_row
    if row is None:
        return {"motions": columns, "shown": None, "path": None}
    path = ball_path(solution.device, design.parameter, motions, row)
    return {
        "motions": columns,
        "shown": row,
        "path": {
            "time": path.time.tolist(),
            "distance": path.distance.tolist(),
            "capsule": (path.capsule / motions.d[row]).tolist(),  # over the length, as the distance is
        },
    }
