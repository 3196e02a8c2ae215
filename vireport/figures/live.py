"""What moves a crosshair through the figures of an HTML page: places of the motions, and readings of results.json."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vireport.base import json_text
from vireport.design import Solution
from vireport.figures.curves import Floats
from vireport.figures.style import Picture
from vireport.figures.sweeps import HEIGHTS, Drawing, drawing_of, panel_curves, panel_marks
from vireport.motions import Branch, Motions, eigenvalues
from vireport.physics import Device, Harmonic, Voltages
from vireport.scenario import Approach, Parameter
from vireport.study import Study, Task
from vireport.text import MINUS

if TYPE_CHECKING:
    from vireport.study import MeasuredAt

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

NOT_MEASURED = "–"
"""Stands for what is not measured."""


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
        drawing = drawing_of(study)
        told = _along_the_sweep(drawing, shown) if shown and drawing.parts else None
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
        "narrow": {
            picture.name: _moved(picture, picture.narrow, drawing)
            for picture in shown
            if picture.narrow is not None and picture.name in HEIGHTS
        },
        "start": start,
        "branches": branches,
    }
    return json_text(data, compact=True, ascii_only=False)


def _harmonics(device: Device) -> Sequence[Harmonic]:
    """The harmonics of the force, over its amplitude."""
    return device.groups(Parameter.LENGTH, device.length_m).harmonics


def _along_the_sweep(drawing: Drawing, pictures: Sequence[Picture]) -> tuple[list[dict[str, Any]], tuple[int, int]]:
    """The branches that are drawn, and which motion is shown first: by its branch, and its place on that."""
    ordered = sorted(drawing.parts, key=lambda part: (not part.stable, part.branch.number))
    drawn = {branch: _rows(drawing, branch) for branch in dict.fromkeys(part.branch for part in ordered)}
    told = [_branch(branch, rows, drawing, pictures) for branch, rows in drawn.items()]
    told += _measured(drawing.study, drawing, pictures, told[0]["columns"])
    return told, _first(drawing.study.solution, [branch.motions.select(rows) for branch, rows in drawn.items()])


def _rows(drawing: Drawing, branch: Branch) -> RowNumbers:
    """The rows of a branch that are drawn."""
    parts = [part.rows for part in drawing.parts if part.branch is branch]
    return np.unique(np.concatenate([np.arange(part.start, part.stop) for part in parts]))


def _first(solution: Solution, branches: Sequence[Motions]) -> tuple[int, int]:
    """The motion of the design point, or next to it a stable one; the first stable one where there is no such point."""
    design = solution.design
    value, q = branches[0].sweep_value[0], np.zeros(0)
    if design is not None:
        value, q = design.value, design.motions.q[design.motions.admissible_mask]
    places = []
    for number, motions in enumerate(branches):
        far = np.abs(motions.sweep_value - value) / np.ptp([value, *motions.sweep_value])
        other = np.abs(motions.q - q[0]) if len(q) else ~motions.stable_mask
        row = int(np.lexsort((other, far))[0])
        places.append((float(other[row]), float(far[row]), number, row))
    *_, number, row = min(places)
    return number, row


def _at_the_design(study: Study) -> tuple[list[dict[str, Any]], tuple[int, int]] | None:
    """The motions of the design point, the stable ones first."""
    solution, design = study.solution, study.solution.design
    if design is None or not design.motions.admissible_mask.any():
        return None
    places = np.flatnonzero(design.motions.admissible_mask)
    told = [
        {
            "name": f"motion {number}, {design.families[row]}",
            **_motions(design.motions, design.voltages_by_motion, solution, np.array([row])),
            "labels": {},
            "places": {},
        }
        for number, row in enumerate(places.tolist(), 1)
    ]
    return told + _measured(study, None, (), told[0]["columns"]), (0, 0)


def _measured(
    study: Study, drawing: Drawing | None, pictures: Sequence[Picture], known: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """The 1:1 motions that were measured, as a branch: with the columns of others, and standard errors beside them."""
    shown = [at for at in study.measured if at.multipliers is not None]
    if not shown:
        return []
    device, columns = study.solution.device, {name: list[Any]() for name in known}
    errors: dict[str, list[float]] = {}
    for at in shown:
        readings = _measured_readings(device, study.solution.parameter, at)
        for name, values in columns.items():
            value, error = readings.get(name, (NOT_MEASURED, None))
            values.append(value)
            if error is not None:
                errors.setdefault(f"{name}_error", []).append(_rounded(error))
    ways = {Approach.UP: ", upwards", Approach.DOWN: ", downwards", Approach.NONE: ""}
    places = {} if drawing is None else {x.name: list(_measured_places(x, drawing, shown)) for x in pictures}
    return [
        {
            "name": "measured 1:1 motion",
            "columns": columns | errors,
            "words": [f"measured{ways[at.direction]}" for at in shown],
            "outside": [],
            "labels": {},
            "places": places,
        }
    ]


def _measured_readings(device: Device, swept: Parameter, at: MeasuredAt) -> dict[str, tuple[Any, float | None]]:
    """What is read of a measured 1:1 motion, with standard errors where there are such."""
    own, motion = at.impacts_shown, at.multipliers
    assert own is not None
    assert motion is not None
    (bottom, top), (bottom_error, top_error) = own.values.T, own.errors.T
    groups, unit, speed_errors = device.groups(swept, at.value), at.velocity_unit, at.speed_errors
    turn = 2 * np.pi
    numbers: dict[str, tuple[float, float | None]] = {
        "sweep_value": (at.value, None),
        "d": (at.d, None),
        "q": (bottom[3] / (2 * device.period_ratio), bottom_error[3] / (2 * device.period_ratio)),
        "phi_bottom_rad": (bottom[2] % turn, bottom_error[2]),
        "phi_top_rad": (top[2] % turn, top_error[2]),
        "velocity_bottom": (bottom[0], bottom_error[0]),
        "velocity_top": (top[0], top_error[0]),
        "velocity_bottom_m_s": (unit * bottom[0], speed_errors[0]),
        "velocity_top_m_s": (unit * top[0], speed_errors[1]),
        "after_bottom": (bottom[1], None),
        "after_top": (top[1], None),
        "gravity_bottom": (float(groups.gravity(-1)), None),
        "gravity_top": (float(groups.gravity(1)), None),
    }
    readings: dict[str, tuple[Any, float | None]] = {
        name: (_rounded(value), error) for name, (value, error) in numbers.items()
    }
    names = _multiplier_names(np.array([motion.trace]), np.array([motion.discriminant]), motion.decay)
    return readings | {f"multiplier_{k}": (texts[0], None) for k, texts in enumerate(names, 1)}


def _measured_places(picture: Picture, drawing: Drawing, shown: Sequence[MeasuredAt]) -> Iterator[list[float | None]]:
    """Where measured 1:1 motions are in a figure, as `_places`; nowhere on panels that do not show them."""
    marked = panel_marks(Task(picture.name), drawing, shown)
    x = np.array([drawing.axis.of_value(at.value) for at in shown])
    panels = picture.figure.axes[: len(marked)]
    yield _points(picture, panels[0], x, np.full(len(x), panels[0].get_ylim()[0]))[0]
    for axes, (count, values) in zip(panels, marked, strict=True):
        for k in range(count):
            yield [None] * len(x) if values is None else _points(picture, axes, x, values[k])[1]


def _branch(branch: Branch, rows: RowNumbers, drawing: Drawing, pictures: Sequence[Picture]) -> dict[str, Any]:
    """The motions of a branch that are drawn: their readings, and their places in the figures."""
    mirror = f", mirror image of branch {branch.mirror_of}" if branch.mirror_of else ""
    points = branch.family.critical_points
    return {
        "name": f"branch {branch.number}, {branch.symmetry}{mirror}",
        **_motions(branch.motions, branch.voltages_by_motion, drawing.study.solution, rows),
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
    decay = motions.decay[rows] if np.ndim(motions.decay) else motions.decay
    names = _multiplier_names(motions.trace[rows], motions.discriminant[rows], decay)
    yield from ((f"multiplier_{k}", texts) for k, texts in enumerate(names, 1))


def _multiplier_names(trace: Floats, discriminant: Floats, decay: Any) -> Iterator[list[Any]]:
    """Both eigenvalues of motions: numbers, or texts of complex ones."""
    imaginary = np.sqrt(np.maximum(-discriminant, 0.0)) / 2
    for k, values in enumerate(eigenvalues(trace, decay), 1):
        turns = f" {'+' if k == 1 else MINUS} "
        yield [
            f"{_rounded(real)}{turns}{_rounded(turn)} i" if turn else _rounded(real)
            for real, turn in zip(values, imaginary, strict=True)
        ]


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


def _moved(wide: Picture, narrow: Picture, drawing: Drawing) -> dict[str, Any]:
    """Where a place of a figure is in its narrow drawing: factor and shift across, and down for each curve."""
    counts = [len(curves) for curves in panel_curves(Task(wide.name), drawing, drawing.parts[0].branch)]
    panels = [_boxes(picture, len(counts)) for picture in (wide, narrow)]

    def map_of(before: tuple[float, float], after: tuple[float, float]) -> tuple[float, float]:
        factor = (after[1] - after[0]) / (before[1] - before[0])
        return round(factor, 5), round(after[0] - factor * before[0], 2)

    moved = [[map_of(before[axis], after[axis]) for before, after in zip(*panels, strict=True)] for axis in (0, 1)]
    return {
        "extent": _extent(narrow),
        "across": moved[0][0],
        "down": [own for own, count in zip(moved[1], counts, strict=True) for _ in range(count)],
    }


def _boxes(picture: Picture, count: int) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Left and right, upper and lower end of the first panels of a figure [pt]."""
    width, height = (72 * size for size in picture.figure.get_size_inches())
    boxes = [axes.get_position() for axes in picture.figure.axes[:count]]
    return [((width * box.x0, width * box.x1), (height * (1 - box.y1), height * (1 - box.y0))) for box in boxes]
