"""What moves a crosshair through the figures of an HTML page: places of the motions, and readings of results.json."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vireport.design import Solution
from vireport.figures.curves import Floats
from vireport.figures.style import Picture
from vireport.figures.sweeps import HEIGHTS, Drawing, drawing_of, panel_curves
from vireport.motions import Branch, Motions, eigenvalues
from vireport.physics import Device, Harmonic, Voltages
from vireport.scenario import Parameter
from vireport.study import Study, Task
from vireport.text import MINUS

RowNumbers = NDArray[np.intp]

DIGITS = 5
"""Significant digits of a reading; as many are in the page."""

READINGS = (
    ("d", "d", ""),
    ("q", "q", ""),
    ("phi_bottom_rad", "φ bottom", "rad"),
    ("phi_top_rad", "φ top", "rad"),
    ("velocity_bottom", "Ż bottom", "–"),
    ("velocity_top", "Ż top", "–"),
    ("velocity_bottom_m_s", "Ż bottom", "m/s"),
    ("velocity_top_m_s", "Ż top", "m/s"),
    ("multiplier_1", "λ₁", ""),
    ("multiplier_2", "λ₂", ""),
    ("u_ave_v", "Uₐᵥₑ", "V"),
    ("u_bottom_v", "Uᵢₘₚ − Uᵢₙ bottom", "V"),
    ("u_top_v", "Uᵢₘₚ − Uᵢₙ top", "V"),
)
"""What is read beside the swept parameter: column, label and unit."""


def live_data(study: Study, pictures: Sequence[Picture]) -> str:
    """What the script of a page knows of the motions in its figures, as JSON; empty where none is drawn.

    Along a sweep these are the branches of figures 2, 4 and 7, otherwise the motions of the design point, each for
    itself, beside the device's sketch.

    Parameters
    ----------
    study : Study
    pictures : sequence of Picture
        Of the study.
    """
    device, swept = study.solution.device, study.solution.parameter
    if study.solution.sweep is not None:
        shown = [picture for picture in pictures if picture.name in HEIGHTS]
        told = _along_the_sweep(study, shown) if shown else None
    else:
        shown = [picture for picture in pictures if picture.name == Task.FIGURE_DEVICE]
        told = _at_the_design(study) if shown else None
    if told is None:
        return ""
    branches, start = told
    known = branches[0]["columns"]
    data = {
        "swept": swept.symbol,
        "unit": swept.unit,
        "angle": None if swept is Parameter.INCLINATION else device.inclination_deg,
        "n": device.period_ratio,
        "force": [(1, 1.0, 0.0), *((own.order, float(own.cosine), float(own.sine)) for own in _harmonics(device))],
        "readings": [("sweep_value", swept.symbol, swept.unit), *(x for x in READINGS if x[0] in known)],
        "figures": {picture.name: _extent(picture) if picture.name in HEIGHTS else None for picture in shown},
        "start": start,
        "branches": branches,
    }
    return json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _harmonics(device: Device) -> Sequence[Harmonic]:
    """The harmonics of the force, over its amplitude."""
    return device.groups(Parameter.LENGTH, device.length_m).harmonics


def _along_the_sweep(study: Study, pictures: Sequence[Picture]) -> tuple[list[dict[str, Any]], tuple[int, int]] | None:
    """The branches that are drawn, and which motion is shown first: by its branch, and its place on that."""
    drawing = drawing_of(study)
    if not drawing.parts:
        return None
    ordered = sorted(drawing.parts, key=lambda part: (not part.stable, part.branch.number))
    drawn = {branch: _rows(drawing, branch) for branch in dict.fromkeys(part.branch for part in ordered)}
    told = [_branch(branch, rows, drawing, pictures) for branch, rows in drawn.items()]
    return told, _first(study.solution, [branch.motions.select(rows) for branch, rows in drawn.items()])


def _rows(drawing: Drawing, branch: Branch) -> RowNumbers:
    """The rows of a branch that are drawn."""
    parts = [part.rows for part in drawing.parts if part.branch is branch]
    return np.unique(np.concatenate([np.arange(part.start, part.stop) for part in parts]))


def _first(solution: Solution, branches: Sequence[Motions]) -> tuple[int, int]:
    """The motion of the design point, or next to it a stable one; the first stable one where there is no such point."""
    design = solution.design
    value, q = branches[0].sweep_value[0], np.zeros(0)
    if design is not None:
        value, q = design.value, design.motions.q[design.motions.admissible]
    places = []
    for number, motions in enumerate(branches):
        far = np.abs(motions.sweep_value - value) / np.ptp([value, *motions.sweep_value])
        other = np.abs(motions.q - q[0]) if len(q) else ~motions.stable
        row = int(np.lexsort((other, far))[0])
        places.append((float(other[row]), float(far[row]), number, row))
    *_, number, row = min(places)
    return number, row


def _at_the_design(study: Study) -> tuple[list[dict[str, Any]], tuple[int, int]] | None:
    """The motions of the design point, the stable ones first."""
    solution, design = study.solution, study.solution.design
    if design is None or not design.motions.admissible.any():
        return None
    places = np.flatnonzero(design.motions.admissible)
    told = [
        {
            "name": f"motion {number}, {design.families[row]}",
            **_motions(design.motions, design.voltages, solution, np.array([row])),
            "labels": {},
            "places": {},
        }
        for number, row in enumerate(places.tolist(), 1)
    ]
    return told, (0, 0)


def _branch(branch: Branch, rows: RowNumbers, drawing: Drawing, pictures: Sequence[Picture]) -> dict[str, Any]:
    """The motions of a branch that are drawn: their readings, and their places in the figures."""
    mirror = f", mirror image of branch {branch.mirror_of}" if branch.mirror_of else ""
    points = branch.family.critical_points
    return {
        "name": f"branch {branch.number}, {branch.symmetry}{mirror}",
        **_motions(branch.motions, branch.voltages, drawing.study.solution, rows),
        "labels": {k: points[row].label for k, row in enumerate(rows.tolist()) if row in points},
        "places": {picture.name: list(_places(picture, drawing, branch, rows)) for picture in pictures},
    }


def _motions(motions: Motions, voltages: Voltages | None, solution: Solution, rows: RowNumbers) -> dict[str, Any]:
    """Some motions: their readings, the names of their stability, and which have no voltage by the membrane's shape."""
    outside = np.zeros(len(rows), bool)
    if voltages is not None and solution.membrane is not None:
        outside = voltages.deflection_m[rows] > solution.membrane.active_radius_m
    words = motions.words
    return {
        "columns": dict(_columns(motions, voltages, solution, rows)),
        "words": [words[row] for row in rows],
        "outside": np.flatnonzero(outside).tolist(),
    }


def _columns(
    motions: Motions, voltages: Voltages | None, solution: Solution, rows: RowNumbers
) -> Iterator[tuple[str, list[Any]]]:
    """The numbers of some motions, by the names of results.json where they are there.

    After the readings comes what moves the ball: the velocities just after the impacts, and what stands for gbar in the
    flights from either membrane.
    """
    device, swept = solution.device, solution.parameter
    unit, groups = device.velocity_unit(swept, motions.sweep_value), device.groups(swept, motions.sweep_value)
    numbers = {
        "sweep_value": motions.sweep_value,
        "d": motions.d,
        "q": motions.q,
        "phi_bottom_rad": motions.phi_bottom,
        "phi_top_rad": motions.phi_top,
        "velocity_bottom": motions.velocity_bottom,
        "velocity_top": motions.velocity_top,
        "velocity_bottom_m_s": unit * motions.velocity_bottom,
        "velocity_top_m_s": unit * motions.velocity_top,
        "after_bottom": groups.after(1, motions.velocity_bottom),
        "after_top": groups.after(-1, motions.velocity_top),
        "gravity_bottom": groups.gravity(-1),
        "gravity_top": groups.gravity(1),
    }
    if voltages is not None:
        numbers |= {"u_ave_v": voltages.average_v, "u_bottom_v": voltages.bottom_v, "u_top_v": voltages.top_v}
    for name, values in numbers.items():
        yield name, [_rounded(value) for value in np.broadcast_to(values, len(motions))[rows]]
    imaginary = np.sqrt(np.maximum(-motions.discriminant, 0.0)) / 2
    for k, values in enumerate(eigenvalues(motions.trace, motions.decay), 1):
        turns = f" {'+' if k == 1 else MINUS} "
        yield (
            f"multiplier_{k}",
            [
                f"{_rounded(real)}{turns}{_rounded(turn)} i" if turn else _rounded(real)
                for real, turn in zip(values[rows], imaginary[rows], strict=True)
            ],
        )


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _places(picture: Picture, drawing: Drawing, branch: Branch, rows: RowNumbers) -> Iterator[list[float | None]]:
    """Where rows of a branch are in a figure: across, and down for each curve [pt]; None off a panel."""
    curves = panel_curves(Task(picture.name), drawing, branch)
    panels, x = picture.figure.axes[: len(curves)], drawing.axis.of(branch.motions)[rows]
    yield _points(picture, panels[0], x, np.full(len(x), panels[0].get_ylim()[0]))[0]
    for axes, curves_of_panel in zip(panels, curves, strict=True):
        for y in curves_of_panel:
            yield _points(picture, axes, x, y[rows])[1]


def _points(picture: Picture, axes: Axes, x: Floats, y: Floats) -> tuple[list[float | None], list[float | None]]:
    low, high = axes.get_ylim()
    points = axes.transData.transform(np.column_stack([x, np.clip(y, low, high)])) * (72 / picture.figure.dpi)
    seen = (y >= low) & (y <= high)
    down = picture.figure.get_figheight() * 72 - points[:, 1]
    return (
        [round(float(at), 1) for at in points[:, 0]],
        [round(float(at), 1) if there else None for at, there in zip(down, seen, strict=True)],
    )


def _extent(picture: Picture) -> tuple[float, float]:
    """Upper and lower end of the panels of a figure [pt]."""
    height = picture.figure.get_figheight() * 72
    boxes = [axes.get_position() for axes in picture.figure.axes]
    ends = height * (1 - max(box.y1 for box in boxes)), height * (1 - min(box.y0 for box in boxes))
    return round(ends[0], 1), round(ends[1], 1)
