"""Draws the figures of a study: pure functions from its numbers to pictures, without pyplot.

Only motions are drawn: what is not admissible is neither a line nor a point here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from matplotlib.figure import Figure

from vireport.figures.axes import style
from vireport.figures.captions import OUTSIDE, TITLES, alt_text, caption, outside_geometry
from vireport.figures.curves import Simulated
from vireport.figures.drawing import Drawing
from vireport.figures.pixels import png_of
from vireport.figures.rows import (
    BRANCH_COLORS,
    HEIGHTS,
    Row,
    legend_2,
    legend_4,
    legend_7,
    rows_2,
    rows_4,
    rows_7,
    without_mirrors,
)
from vireport.figures.sheet import Sheet
from vireport.figures.simulated_figures import Words, simulated_figures
from vireport.study import Study, Task


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
    draw: dict[Task, Callable[[], Figure]] = {
        Task.FIGURE_2: partial(_figure_2, study, simulated),
        Task.FIGURE_4: partial(_figure_4, study),
        Task.FIGURE_7: partial(_figure_7, study, simulated),
    }

    def words(name: str) -> Words:
        return name, TITLES[name], caption(study, name, simulated), alt_text(study, name, simulated)

    with style():
        drawn = [Picture(*words(name), *png_of(draw[name]())) for name in draw if study.plan.runs(name)]
        drawn += [Picture(*told, *png_of(figure)) for told, figure in simulated_figures(study)]
        if study.work is not None:
            from vireport.figures.measured_figures import measured_figures

            drawn += [Picture(*told, *png_of(figure)) for told, figure in measured_figures(study)]
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
    page = drawing.sheet(3, HEIGHTS["figure-2"], legend_2(drawing.parts, bool(simulated)))
    return _filled(page, rows_2(drawing, simulated))


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
    branches = without_mirrors(drawing)
    colors = {number: BRANCH_COLORS[k % len(BRANCH_COLORS)] for k, number in enumerate(branches)}
    named = {f"branch {number}, {family}": colors[number] for number, family in branches.items()}
    page = drawing.sheet(2, HEIGHTS["figure-4"], legend_4(drawing.parts, named))
    return _filled(page, rows_4(drawing, colors))


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
    legend = legend_7(drawing.parts, bool(simulated and simulated.voltages))
    note = f"{OUTSIDE[0].upper()}{OUTSIDE[1:]}" if outside_geometry(study) else ""
    return _filled(drawing.sheet(1, HEIGHTS["figure-7"], legend, note), rows_7(drawing, simulated))


def _filled(page: Sheet, rows: Sequence[Row]) -> Figure:
    for row in rows:
        row.draw(page.panel(row.label, row.limits, row.ticks))
    return page.figure
