"""Several scenarios on one axis, and their figures 2, 4 and 7 with a column for each, as the paper prints them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.comparison.comparison import (
    COMPARED_FIGURES,
    OVERLAY,
    Comparison,
    columns,
    left_out,
)
from vireport.comparison.ranking import Merit
from vireport.figures.captions import about, alt_text, caption_facts, held, swept_range, title_of
from vireport.figures.curves import simulated_points
from vireport.figures.overlay import SCENARIO_COLORS, has_stable, overlay
from vireport.figures.style import Color, Picture, Sheet, drawn_for, literal, sheet
from vireport.figures.sweeps import PANELS, Drawing, drawing_of, panel_letters, sweep_figure
from vireport.physics.motion import Symmetry
from vireport.report.changes.sentences import listed
from vireport.scenario.parameters import Parameter
from vireport.study.plan import Task
from vireport.text.said import Said, words_of

_said = words_of("compare")

MOST_BESIDE = 5
"""Scenarios beside one another in a figure."""

NARROWEST = 1.1
"""Width of a scenario's panels that its ticks and labels take at least [in]."""

Columns = dict[str, Drawing]
"""The scenarios of one figure by their names."""


def compare_pictures(comparison: Comparison, templates: Path | None = None) -> tuple[Picture, ...]:
    """Draw all scenarios on one axis, and figures 2, 4 and 7 with at most five of them beside one another.

    Parameters
    ----------
    comparison : Comparison
        Scenarios without a sweep are left out, and from figure 7 those without a ball mass.
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    return (*_overlaid(comparison, templates), *_side_by_side(comparison, templates))


def _overlaid(comparison: Comparison, templates: Path | None) -> Iterator[Picture]:
    """Draw all scenarios on one axis, or the best of them; nothing where there are not two to draw."""
    axis_name = comparison.axes.always[0]
    parameter = axis_name if isinstance(axis_name, Parameter) else None
    drawn: Columns = {}
    for scenario in comparison.ranking:
        solution = scenario.study.solution
        # A sweep of the inclination or a restitution holds d: over d it would be a single point.
        if solution.sweep is not None and (parameter or solution.parameter.moves_d):
            drawing = _with_stable(drawing_of(scenario.study))
            if drawing.parts and len(drawn) < len(SCENARIO_COLORS):
                drawn[scenario.name] = drawing
    if len(drawn) < 2:
        return
    axis = _said("over", parameter.quantity) if parameter else _said("over_d")
    others = [name for name in comparison.names if name not in drawn]
    remarks = [_said("not_drawn", listed(others))] if others else []
    unstable = [name for name, drawing in drawn.items() if not has_stable(drawing)]
    if 0 < len(unstable) < len(drawn):
        remarks.append(_said("no_stable_voltage", listed(unstable)))
    remarked = _said("overlay_caption_remarks", axis, remarks) if remarks else _said("overlay_caption", axis)
    ranked = [scenario for scenario in comparison.ranking if scenario.name in drawn]
    ranges = [_said("stable_range", scenario.name, scenario.said(Merit.RANGE)) for scenario in ranked]
    description = _said("overlay_alt", len(drawn), axis, ranges)
    title, caption, alt = (said.words(templates) for said in (_said("overlay_title"), remarked, description))

    yield Picture(OVERLAY, title, caption, alt, overlay(drawn, parameter))


def _with_stable(drawing: Drawing) -> Drawing:
    """Leave out branches without stable motion and their critical points, unless no branch has stable motion."""
    branches = {part.branch.number for part in drawing.parts if part.stable}
    if not branches:
        return drawing
    parts = [part for part in drawing.parts if part.branch.number in branches]
    events = [event for event in drawing.events if any(branch.number in branches for branch, _ in event.places)]
    return replace(drawing, parts=parts, events=events)


def _side_by_side(comparison: Comparison, templates: Path | None) -> Iterator[Picture]:
    """Draw the scenarios beside one another, with so many figures of a kind as it takes."""
    return (
        Picture(
            figure if number == 1 else f"{figure}-{number}",
            title_of(figure, templates),
            _caption(figure, page, templates),
            _alt(figure, page, templates),
            _figure(figure, page),
        )
        for figure in PANELS
        for number, page in enumerate(_pages(comparison, figure), 1)
    )


def compare_figure(
    comparison: Comparison, name: str, *, width_mm: float | None = None, style: Mapping[str, object] | None = None
) -> tuple[Figure, ...]:
    """Draw a figure of the paper for all scenarios of a comparison side by side, by Matplotlib.

    Parameters
    ----------
    comparison : Comparison
    name : str
        ``figure-2``, ``figure-4`` or ``figure-7``.
    width_mm : float, optional
        Width of a column of a paper [mm], 60 to 250; inputs that all scenarios share are then left to the caption.
    style : mapping, optional
        Settings of Matplotlib, such as ``{"font.size": 8}``.

    Returns
    -------
    tuple of Figure
        A figure for every five scenarios, or fewer at a small width; empty if no scenario has this figure.

    Raises
    ------
    UsageError
        For another width.
    """
    if not isinstance(comparison, Comparison):
        raise UsageError(
            f"a Comparison is needed, not a value of type {type(comparison).__name__} (allowed: what compare gives)"
        )
    if name not in COMPARED_FIGURES:
        raise UsageError(f"there is no figure {name!r} of a comparison (allowed: {', '.join(COMPARED_FIGURES)})")
    figure = Task(name)
    with drawn_for(Sheet.of(width_mm, style)):
        return tuple(_figure(figure, page) for page in _pages(comparison, figure))


def _pages(comparison: Comparison, figure: Task) -> Iterator[Columns]:
    """Part the scenarios of one kind of figure into groups of as many as fit beside one another."""
    skipped = {name for name, _ in left_out(comparison, figure)}
    drawn = [(name, study) for name, study in comparison.by_name.items() if name not in skipped]
    fitting = max(1, min(MOST_BESIDE, int(sheet().across / NARROWEST)))
    for part in columns(len(drawn), fitting):
        yield {name: _ranked(drawing_of(study, simulated_points(study))) for name, study in drawn[part]}


def _ranked(drawing: Drawing) -> Drawing:
    """Name the branches of a drawing by family, and number them there, the stable ones first.

    The number of a branch stands for another family in another scenario, so that one colour would mean two things.
    """
    stable = {part.branch.number for part in drawing.parts if part.stable}
    families = {part.branch.number: part.branch.symmetry for part in drawing.parts}
    ordered = sorted(
        drawing.branches, key=lambda number: (families[number] is not Symmetry.SYMMETRIC, number not in stable, number)
    )
    ranks = {
        number: 1 + [families[other] for other in ordered[:k]].count(families[number])
        for k, number in enumerate(ordered)
    }
    return replace(drawing, branches={number: f"{families[number]} {ranks[number]}" for number in ordered})


def _figure(figure: Task, page: Columns) -> Figure:
    """Draw scenarios beside one another, with what all of them hold above them, and what each holds at its head."""
    common, differing = _conditions(list(page.values()))
    lines = [(common, Color.BLACK)] if common else []
    return sweep_figure(figure, list(page.values()), [literal(name) for name in page], differing, lines)


def _conditions(drawings: Sequence[Drawing]) -> tuple[str, list[str]]:
    """Find what all scenarios hold, and what each holds beyond that."""
    conditions = [held(drawing.study) for drawing in drawings]
    common = [text for text in conditions[0] if all(text in texts for texts in conditions)]
    return ", ".join(common), [", ".join(text for text in texts if text not in common) for texts in conditions]


def _caption(figure: Task, page: Columns, templates: Path | None) -> str:
    """Say what the columns of a figure show, each with the letters of its panels."""
    common, differing = _conditions(list(page.values()))
    columns: list[str | Said] = [common] if common else []
    for column, (scenario, drawing) in enumerate(page.items()):
        parts = [text for text in (differing[column], swept_range(drawing.study)) if text]
        columns.append(_said("column", panel_letters(figure, column), scenario, parts))
    macro = "panels_shared" if len(page) > 1 else "panels_alone"
    return _said(macro, about(figure, templates), columns).words(templates)


def _alt(figure: Task, page: Columns, templates: Path | None) -> str:
    """Describe a figure to those who cannot see it."""
    columns = [
        _said("column_alt", name, alt_text(figure, caption_facts(drawing.study, figure, drawing.simulated), templates))
        for name, drawing in page.items()
    ]
    across = _said("columns" if len(page) > 1 else "one_column", len(page))
    down = _said("panels" if PANELS[figure] > 1 else "one_panel", PANELS[figure])
    return _said("panels_alt", across, down, columns).words(templates)
