"""The rows of figures 2, 4 and 7: what each shows of a study, which values it holds, and how it is drawn on a panel.

One figure of a scenario and the columns of a comparison are made of the same rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from vireport.analysis import Branch, eigenvalues
from vireport.figures.axes import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION, limits, prefix, within
from vireport.figures.captions import LAMBDA_LIMIT
from vireport.figures.curves import (
    TURN,
    Curve,
    Floats,
    Simulated,
    Stretch,
    eigenvalue_curves,
    larger_first,
    pairs,
    phase_curve,
    visible,
)
from vireport.figures.drawing import (
    AVERAGE,
    BOTTOM,
    BOTTOM_VOLTAGE,
    BOUND,
    CIRCLE,
    STABLE,
    STAR,
    TOP,
    TOP_VOLTAGE,
    UNSTABLE,
    UNSTABLE_TOP_VOLTAGE,
    UNSTABLE_VOLTAGE,
    Drawing,
    crowded,
)
from vireport.figures.panel import Panel
from vireport.figures.sheet import Entry, Ticks
from vireport.physics import Voltages
from vireport.text import PREFIXES

LABELS_2 = ("impact velocity |Ż| [–]", "phase φ [rad]", "flight time Δt/2 [periods]")
VELOCITY, PHASE, FLIGHT = range(3)

PHASES = (-0.03 * TURN, 1.03 * TURN)
PHASE_TICKS = ([k * TURN / 4 for k in range(5)], ["0", "π/2", "π", "3π/2", "2π"])

VOLTAGES = (
    (AVERAGE, UNSTABLE_VOLTAGE),
    (BOTTOM_VOLTAGE, UNSTABLE_VOLTAGE),
    (TOP_VOLTAGE, UNSTABLE_TOP_VOLTAGE),
)

BRANCH_COLORS = (BLUE, PURPLE, BLACK, SKY, GREEN, ORANGE)
"""The first three are also apart in grey."""
THIN, THICK = 1.5, 3.4
"""Widths of curves in figure 4 [pt]; thick where the eigenvalues are complex."""

HEIGHTS = {"figure-2": 1.85, "figure-4": 2.3, "figure-7": 3.1}
"""Of the panels [in]."""


@dataclass(frozen=True, slots=True)
class Row:
    """One quantity along the sweep, as a panel shows it.

    Attributes
    ----------
    label : str
        Word, symbol and unit.
    values : tuple of ndarray
        What the axis has to hold.
    draw : callable
        Draws it on a panel, whose limits may be wider than its own.
    fixed : tuple of float or None
        Limits that hold whatever the values are.
    ticks : tuple of sequences or None
        Values and labels, where they are not at round numbers.
    """

    label: str
    values: tuple[Floats, ...]
    draw: Callable[[Panel], None]
    fixed: tuple[float, float] | None = None
    ticks: Ticks | None = None

    @property
    def limits(self) -> tuple[float, float] | None:
        """Limits of the axis; None where there is nothing to show."""
        return self.fixed or limits(list(self.values))


def rows_2(drawing: Drawing, simulated: Simulated | None) -> list[Row]:
    """Impact velocity, phase and flight time over two."""
    return [_row_2(drawing, k, simulated) for k in (VELOCITY, PHASE, FLIGHT)]


def _row_2(drawing: Drawing, k: int, simulated: Simulated | None) -> Row:
    n, design = drawing.study.solution.device.period_ratio, drawing.study.solution.design
    sides = {part: pairs(part.branch.motions, n)[k] for part in drawing.parts}
    overlay = simulated.pairs[k] if simulated else ()

    def curve(part: Stretch, side: int) -> list[Curve]:
        x, y = drawing.x(part), sides[part][side][part.rows]
        return phase_curve(x, y) if k == PHASE else [(x, y)]

    def draw(panel: Panel) -> None:
        for stable, line in ((False, UNSTABLE), (True, STABLE)):
            for side, color in enumerate((BOTTOM, TOP)):
                drawing.curves(panel, partial(curve, side=side), stable, color | line)
        for y in overlay:
            panel.marks(drawing.along.of(simulated), y, **crowded(CIRCLE, simulated))
        if design is not None:
            drawing.design(panel, pairs(design.motions, n)[k], (BLUE, GREEN))
        drawing.letters(panel, lambda branch: pairs(branch.motions, n)[k])

    if k == PHASE:
        return Row(LABELS_2[k], (), draw, PHASES, PHASE_TICKS)
    return Row(LABELS_2[k], (*(y[part.rows] for part in sides for y in sides[part]), *overlay), draw)


def rows_4(drawing: Drawing, colors: dict[int, str]) -> list[Row]:
    """The discriminant, and the eigenvalues or their real parts; `colors` are those of the branches by number."""
    return [_discriminants(drawing, colors), _eigenvalues(drawing, colors)]


def without_mirrors(drawing: Drawing) -> dict[int, str]:
    """Leave out of a drawing the branches that are mirror images; the family of each that stays, by its number."""
    drawing.parts = [part for part in drawing.parts if part.branch.mirror_of is None]
    return dict(sorted((part.branch.number, part.branch.family) for part in drawing.parts))


def _discriminants(drawing: Drawing, colors: dict[int, str]) -> Row:
    r, design = drawing.study.solution.device.restitution, drawing.study.solution.design
    highest = (LAMBDA_LIMIT - r**4 / LAMBDA_LIMIT) ** 2
    curves = {part: [(drawing.x(part), part.branch.motions.discriminant[part.rows])] for part in drawing.parts}
    seen = [within(y, -np.inf, highest) for drawn in curves.values() for _, y in drawn]

    def draw(panel: Panel) -> None:
        panel.level(0.0, **BOUND)
        for part, drawn in curves.items():
            _branch(panel, part, drawn, colors, THIN)
        if design is not None:
            drawing.design(panel, [design.motions.discriminant], [GREY])
        drawing.letters(panel, lambda branch: [branch.motions.discriminant])

    return Row("discriminant Δ [–]", (*seen, np.array([0.0, (1 - r**4) ** 2])), draw)


def _eigenvalues(drawing: Drawing, colors: dict[int, str]) -> Row:
    r, design = drawing.study.solution.device.restitution, drawing.study.solution.design
    curves = {part: list(eigenvalue_curves(part, drawing.x(part))) for part in drawing.parts}
    seen = [within(y, -LAMBDA_LIMIT, LAMBDA_LIMIT) for drawn in curves.values() for _, y in drawn]

    def draw(panel: Panel) -> None:
        for bound in (-1.0, 0.0, 1.0):
            panel.level(bound, **BOUND)
        for part, drawn in curves.items():
            _branch(panel, part, drawn, colors, THICK if part.focus else THIN)
        if design is not None:
            drawing.design(panel, eigenvalues(design.motions.trace, r), (GREY, GREY))
        drawing.letters(panel, lambda branch: larger_first(eigenvalues(branch.motions.trace, r)))

    return Row("eigenvalues λ₁, λ₂ or Re λ [–]", (*seen, np.array([-1.0, 1.0])), draw)


def _branch(panel: Panel, part: Stretch, drawn: list[Curve], colors: dict[int, str], width: float) -> None:
    """Draw what of a stretch is on a panel."""
    look = STABLE if part.stable else UNSTABLE
    pieces = [piece for curve in drawn for piece in visible(curve, *panel.y)]
    panel.curves(pieces, color=colors[part.branch.number], linewidth=width, **look)


def seen_7(drawing: Drawing, simulated: Simulated | None) -> list[Floats]:
    """The voltages that figure 7 shows [V]."""
    points = simulated.voltages if simulated else None
    seen = [y[part.rows] for part in drawing.parts for y in _three(part.branch)]
    return seen + (_each(points) if points else [])


def rows_7(drawing: Drawing, simulated: Simulated | None, power: int | None = None) -> list[Row]:
    """The voltages; `power` of ten is that of their unit, by default what brings the largest below 1000."""
    design, seen = drawing.solution.design, seen_7(drawing, simulated)
    points = simulated.voltages if simulated else None
    power = prefix(seen) if power is None else power
    unit = 10.0**power

    def curve(part: Stretch, k: int) -> list[Curve]:
        return [(drawing.x(part), _three(part.branch)[k][part.rows] / unit)]

    def draw(panel: Panel) -> None:
        for k, (look, unstable) in enumerate(VOLTAGES):
            drawing.curves(panel, partial(curve, k=k), False, look | unstable)
            drawing.curves(panel, partial(curve, k=k), True, look | {"zorder": STABLE["zorder"]})
        if points:
            for y, look in zip(_each(points), (STAR, CIRCLE, CIRCLE), strict=True):
                panel.marks(drawing.along.of(simulated), y / unit, **crowded(look, simulated))
        if design is not None and design.voltages is not None:
            drawing.design(panel, [y / unit for y in _each(design.voltages)], (VERMILION, BLUE, BLUE))
        drawing.letters(panel, lambda branch: [y / unit for y in _three(branch)])

    return [Row(f"generated voltage U [{PREFIXES[power]}V]", tuple(y / unit for y in seen), draw)]


def _three(branch: Branch) -> list[Floats]:
    """The voltages of a branch where energy is evaluated."""
    return _each(branch.voltages) if branch.voltages is not None else []


def _each(voltages: Voltages) -> list[Floats]:
    return [voltages.average_v, voltages.bottom_v, voltages.top_v]


def legend_2(parts: list[Stretch], simulated: bool) -> list[Entry]:
    """The legend of figure 2."""
    legend: list[Entry] = [("impact k−1, bottom", BOTTOM), ("impact k, top", TOP), *stability(parts)]
    return legend + ([("simulation", CIRCLE)] if simulated else [])


def legend_4(parts: list[Stretch], branches: dict[str, str]) -> list[Entry]:
    """The legend of figure 4; `branches` are the colours by name."""
    legend: list[Entry] = [(name, {"color": color, "linewidth": THIN}) for name, color in branches.items()]
    legend += stability(parts)
    if any(part.focus for part in parts):
        legend.append(("Re λ", {"color": GREY, "linewidth": THICK}))
    return legend


def legend_7(parts: list[Stretch], simulated: bool) -> list[Entry]:
    """The legend of figure 7."""
    legend: list[Entry] = [
        ("Uₐᵥₑ", AVERAGE),
        ("Uᵢₘₚ − Uᵢₙ, bottom", BOTTOM_VOLTAGE),
        ("Uᵢₘₚ − Uᵢₙ, top", TOP_VOLTAGE),
    ]
    if any(not part.stable for part in parts):
        legend.append(("unstable", AVERAGE | UNSTABLE_VOLTAGE | {"color": GREY, "linewidth": 1.6}))
    return legend + ([("simulated Uₐᵥₑ", STAR), ("simulated", CIRCLE)] if simulated else [])


def stability(parts: list[Stretch]) -> Iterator[Entry]:
    """Samples of the line styles that occur."""
    for name, stable, line in (("stable", True, STABLE), ("unstable", False, UNSTABLE)):
        if any(part.stable == stable for part in parts):
            yield name, {"color": GREY, "linewidth": THIN, **line}
