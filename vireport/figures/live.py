"""What moves a crosshair through the figures of an HTML page: places of the motions, and readings of results.json."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vireport.figures.curves import Floats
from vireport.figures.style import Picture
from vireport.figures.sweeps import HEIGHTS, Drawing, drawing_of, panel_curves
from vireport.motions import Branch, eigenvalues
from vireport.physics import Device, by_wall
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
    """What the script of a page knows of the motions along a sweep, as JSON; empty where no motion is drawn.

    Parameters
    ----------
    study : Study
    pictures : sequence of Picture
        Of the study.
    """
    shown = [picture for picture in pictures if picture.name in HEIGHTS]
    if not shown or not (drawing := drawing_of(study)).parts:
        return ""
    device, swept = study.solution.device, study.solution.parameter
    apart = dict(zip(("bottom", "top"), by_wall(device.restitution), strict=True))
    ordered = sorted(drawing.parts, key=lambda part: (not part.stable, part.branch.number))
    branches = [_branch(branch, drawing, shown) for branch in dict.fromkeys(part.branch for part in ordered)]
    known = branches[0]["columns"]
    data = {
        "swept": swept.symbol,
        "unit": swept.unit,
        "angle": None if swept is Parameter.INCLINATION else device.inclination_deg,
        "r": device.restitution if device.alike else apart,
        "n": device.period_ratio,
        "readings": [("sweep_value", swept.symbol, swept.unit), *(x for x in READINGS if x[0] in known)],
        "figures": {picture.name: _extent(picture) for picture in shown},
        "branches": branches,
    }
    return json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _branch(branch: Branch, drawing: Drawing, pictures: Sequence[Picture]) -> dict[str, Any]:
    """The motions of a branch that are drawn: their readings, and their places in the figures."""
    solution = drawing.study.solution
    parts = [part.rows for part in drawing.parts if part.branch is branch]
    rows = np.unique(np.concatenate([np.arange(part.start, part.stop) for part in parts]))
    mirror = f", mirror image of branch {branch.mirror_of}" if branch.mirror_of else ""
    points = branch.family.critical_points
    labels = {k: points[row].label for k, row in enumerate(rows.tolist()) if row in points}
    words = branch.motions.words
    return {
        "name": f"branch {branch.number}, {branch.symmetry}{mirror}",
        "columns": dict(_columns(branch, solution.parameter, solution.device, rows)),
        "words": [words[row] for row in rows],
        "labels": labels,
        "places": {picture.name: list(_places(picture, drawing, branch, rows)) for picture in pictures},
    }


def _columns(branch: Branch, swept: Parameter, device: Device, rows: RowNumbers) -> Iterator[tuple[str, list[Any]]]:
    """The readings of some rows of a branch, by the names of results.json where they are there."""
    motions, voltages = branch.motions, branch.voltages
    unit = device.velocity_unit(swept, motions.sweep_value)
    numbers = {
        "sweep_value": motions.sweep_value,
        "d": motions.d,
        "gbar": motions.gbar,
        "q": motions.q,
        "phi_bottom_rad": motions.phi_bottom,
        "phi_top_rad": motions.phi_top,
        "velocity_bottom": motions.velocity_bottom,
        "velocity_top": motions.velocity_top,
        "velocity_bottom_m_s": unit * motions.velocity_bottom,
        "velocity_top_m_s": unit * motions.velocity_top,
    }
    if voltages is not None:
        numbers |= {"u_ave_v": voltages.average_v, "u_bottom_v": voltages.bottom_v, "u_top_v": voltages.top_v}
    for name, values in numbers.items():
        yield name, [_rounded(value) for value in values[rows]]
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
