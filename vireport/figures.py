"""Draws the figures of a study: pure functions from its numbers to pictures, without pyplot.

Only motions are drawn: what is not admissible is neither a line nor a point here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from vireport.axes import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    limits,
    prefix,
    style,
    within,
)
from vireport.captions import LAMBDA_LIMIT, OUTSIDE, TITLES, alt_text, caption, outside_geometry
from vireport.curves import (
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
from vireport.drawing import (
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
from vireport.energy import Voltages
from vireport.formatting import PREFIXES
from vireport.panel import Panel
from vireport.pixels import png_of
from vireport.sheet import Entry, Sheet
from vireport.simulated_figures import Words, simulated_figures
from vireport.stability import eigenvalues
from vireport.study import Study

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


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure as a PNG file and in words.

    Attributes
    ----------
    name : str
        Of the file, without its suffix.
    title, caption, alt : str
    png : bytes
    width, height : int
        [px]
    """

    name: str
    title: str
    caption: str
    alt: str
    png: bytes
    width: int
    height: int


def pictures(study: Study, simulated: Simulated | None = None) -> tuple[Picture, ...]:
    """Draw the figures that a study's plan runs.

    Parameters
    ----------
    study : Study
    simulated : Simulated, optional
        Motions from a simulation, drawn over the analytic ones.
    """
    draw: dict[str, Callable[[], Figure]] = {
        "figure-2": partial(_figure_2, study, simulated),
        "figure-4": partial(_figure_4, study),
        "figure-7": partial(_figure_7, study, simulated),
    }

    def words(name: str) -> Words:
        return name, TITLES[name], caption(study, name, simulated), alt_text(study, name, simulated)

    with style():
        drawn = [Picture(*words(name), *png_of(draw[name]())) for name in draw if study.plan.runs(name)]
        drawn += [Picture(*told, *png_of(figure)) for told, figure in simulated_figures(study)]
    return tuple(sorted(drawn, key=lambda picture: picture.name))


def figure_2(study: Study, simulated: Simulated | None = None) -> Figure:
    """Impact velocity, phase and flight time over two along the sweep, as in Fig. 2.

    Parameters
    ----------
    study : Study
        With a sweep.
    simulated : Simulated, optional
    """
    with style():
        return _figure_2(study, simulated)


def _figure_2(study: Study, simulated: Simulated | None) -> Figure:
    drawing = Drawing(study)
    legend: list[Entry] = [("impact k−1, bottom", BOTTOM), ("impact k, top", TOP), *_stability(drawing)]
    page = drawing.sheet(3, 1.85, legend + ([("simulation", CIRCLE)] if simulated else []))
    for k in (VELOCITY, PHASE, FLIGHT):
        _panel_2(drawing, page, k, simulated)
    return page.figure


def _panel_2(drawing: Drawing, page: Sheet, k: int, simulated: Simulated | None) -> None:
    n, design = drawing.study.device.period_ratio, drawing.study.design
    sides = {part: pairs(part.branch.motions, n)[k] for part in drawing.parts}
    overlay = simulated.pairs[k] if simulated else ()

    def curve(part: Stretch, side: int) -> list[Curve]:
        x, y = drawing.x(part), sides[part][side][part.rows]
        return phase_curve(x, y) if k == PHASE else [(x, y)]

    if k == PHASE:
        panel = page.panel(LABELS_2[k], PHASES, PHASE_TICKS)
    else:
        panel = page.panel(LABELS_2[k], limits([*(y[part.rows] for part in sides for y in sides[part]), *overlay]))
    for stable, line in ((False, UNSTABLE), (True, STABLE)):
        for side, color in enumerate((BOTTOM, TOP)):
            drawing.curves(panel, partial(curve, side=side), stable, color | line)
    for y in overlay:
        panel.marks(drawing.along.of(simulated), y, **crowded(CIRCLE, simulated))
    if design is not None:
        drawing.design(panel, pairs(design.motions, n)[k], (BLUE, GREEN))
    drawing.letters(panel, lambda branch: pairs(branch.motions, n)[k])


def figure_4(study: Study) -> Figure:
    """The discriminant, and the eigenvalues or their real parts, along the sweep, as in Fig. 4.

    Parameters
    ----------
    study : Study
        With a sweep.
    """
    with style():
        return _figure_4(study)


def _figure_4(study: Study) -> Figure:
    drawing = Drawing(study)
    drawing.parts = [part for part in drawing.parts if part.branch.mirror_of is None]
    branches = dict(sorted((part.branch.number, part.branch.family) for part in drawing.parts))
    colors = {number: BRANCH_COLORS[k % len(BRANCH_COLORS)] for k, number in enumerate(branches)}
    legend: list[Entry] = [
        (f"branch {number}, {family}", {"color": colors[number], "linewidth": THIN})
        for number, family in branches.items()
    ]
    legend += _stability(drawing)
    if any(part.focus for part in drawing.parts):
        legend.append(("Re λ", {"color": GREY, "linewidth": THICK}))
    page = drawing.sheet(2, 2.3, legend)
    _discriminants(drawing, page, colors)
    _eigenvalues(drawing, page, colors)
    return page.figure


def _discriminants(drawing: Drawing, page: Sheet, colors: dict[int, str]) -> None:
    r, design = drawing.study.device.restitution, drawing.study.design
    highest = (LAMBDA_LIMIT - r**4 / LAMBDA_LIMIT) ** 2
    curves = {part: [(drawing.x(part), part.branch.motions.discriminant[part.rows])] for part in drawing.parts}
    seen = [within(y, -np.inf, highest) for drawn in curves.values() for _, y in drawn]
    panel = page.panel("discriminant Δ [–]", limits([*seen, np.array([0.0, (1 - r**4) ** 2])]))
    panel.level(0.0, **BOUND)
    for part, drawn in curves.items():
        _branch(panel, part, drawn, colors, THIN)
    if design is not None:
        drawing.design(panel, [design.motions.discriminant], [GREY])
    drawing.letters(panel, lambda branch: [branch.motions.discriminant])


def _eigenvalues(drawing: Drawing, page: Sheet, colors: dict[int, str]) -> None:
    r, design = drawing.study.device.restitution, drawing.study.design
    curves = {part: list(eigenvalue_curves(part, drawing.x(part))) for part in drawing.parts}
    seen = [within(y, -LAMBDA_LIMIT, LAMBDA_LIMIT) for drawn in curves.values() for _, y in drawn]
    panel = page.panel("eigenvalues λ₁, λ₂ or Re λ [–]", limits([*seen, np.array([-1.0, 1.0])]))
    for bound in (-1.0, 0.0, 1.0):
        panel.level(bound, **BOUND)
    for part, drawn in curves.items():
        _branch(panel, part, drawn, colors, THICK if part.focus else THIN)
    if design is not None:
        drawing.design(panel, eigenvalues(design.motions.trace, r), (GREY, GREY))
    drawing.letters(panel, lambda branch: larger_first(eigenvalues(branch.motions.trace, r)))


def _branch(panel: Panel, part: Stretch, drawn: list[Curve], colors: dict[int, str], width: float) -> None:
    """Draw what of a stretch is on a panel."""
    look = STABLE if part.stable else UNSTABLE
    pieces = [piece for curve in drawn for piece in visible(curve, *panel.y)]
    panel.curves(pieces, color=colors[part.branch.number], linewidth=width, **look)


def figure_7(study: Study, simulated: Simulated | None = None) -> Figure:
    """The voltage generated at the impacts and its average along the sweep, as in Fig. 7.

    Parameters
    ----------
    study : Study
        With a sweep, and with voltages.
    simulated : Simulated, optional
        Its voltages are drawn, where it has them.
    """
    with style():
        return _figure_7(study, simulated)


def _figure_7(study: Study, simulated: Simulated | None) -> Figure:
    drawing = Drawing(study)
    points = simulated.voltages if simulated else None
    legend: list[Entry] = [
        ("Uₐᵥₑ", AVERAGE),
        ("Uᵢₘₚ − Uᵢₙ, bottom", BOTTOM_VOLTAGE),
        ("Uᵢₘₚ − Uᵢₙ, top", TOP_VOLTAGE),
    ]
    if any(not part.stable for part in drawing.parts):
        legend.append(("unstable", AVERAGE | UNSTABLE_VOLTAGE | {"color": GREY, "linewidth": 1.6}))
    legend += [("simulated Uₐᵥₑ", STAR), ("simulated", CIRCLE)] if points else []
    page = drawing.sheet(1, 3.1, legend, f"{OUTSIDE[0].upper()}{OUTSIDE[1:]}" if outside_geometry(study) else "")
    seen = [y[part.rows] for part in drawing.parts for y in _three(study.voltages[part.index])]
    seen += _three(points) if points else []
    power = prefix(seen)
    unit = 10.0**power
    panel = page.panel(f"generated voltage U [{PREFIXES[power]}V]", limits([y / unit for y in seen]))

    def curve(part: Stretch, k: int) -> list[Curve]:
        return [(drawing.x(part), _three(study.voltages[part.index])[k][part.rows] / unit)]

    for k, (look, unstable) in enumerate(VOLTAGES):
        drawing.curves(panel, partial(curve, k=k), False, look | unstable)
        drawing.curves(panel, partial(curve, k=k), True, look | {"zorder": STABLE["zorder"]})
    if points:
        for y, look in zip(_three(points), (STAR, CIRCLE, CIRCLE), strict=True):
            panel.marks(drawing.along.of(simulated), y / unit, **crowded(look, simulated))
    if study.design_voltages is not None:
        drawing.design(panel, [y / unit for y in _three(study.design_voltages)], (VERMILION, BLUE, BLUE))
    drawing.letters(panel, lambda branch: [y / unit for y in _three(study.voltages[branch.number - 1])])
    return page.figure


def _three(voltages: Voltages) -> list[Floats]:
    return [voltages.average_v, voltages.bottom_v, voltages.top_v]


def _stability(drawing: Drawing) -> Iterator[Entry]:
    """Samples of the line styles that occur."""
    for name, stable, line in (("stable", True, STABLE), ("unstable", False, UNSTABLE)):
        if any(part.stable == stable for part in drawing.parts):
            yield name, {"color": GREY, "linewidth": THIN, **line}
