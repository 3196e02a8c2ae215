"""Several scenarios on one axis, and their figures 2, 4 and 7 with a column for each, as the paper prints them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from vireport.comparison.comparison import (
    OVERLAY,
    Comparison,
    columns,
    left_out,
)
from vireport.comparison.differences import listed
from vireport.comparison.ranking import Merit
from vireport.figures import (
    COLORS,
    OUTSIDE,
    Color,
    Drawing,
    Picture,
    about,
    alt_text,
    drawing_of,
    held,
    letter_of,
    literal,
    overlay,
    shown_along,
    simulated_points,
    sweep_figure,
    swept_range,
    title_of,
)
from vireport.scenario import Parameter
from vireport.study import Task
from vireport.text import AlertCode, capital

ROWS = {Task.FIGURE_2: 3, Task.FIGURE_4: 2, Task.FIGURE_7: 1}

SHARED = ", on axes that the panels of a row share"

Columns = dict[str, Drawing]
"""The scenarios of one figure by their names."""


def compare_pictures(comparison: Comparison) -> tuple[Picture, ...]:
    """Draw all scenarios on one axis, and figures 2, 4 and 7 with at most four of them beside one another.

    Parameters
    ----------
    comparison : Comparison
        Scenarios without a sweep are left out, and from figure 7 those without a ball mass.
    """
    return (*_overlaid(comparison), *_side_by_side(comparison))


def _overlaid(comparison: Comparison) -> Iterator[Picture]:
    """All scenarios on one axis, or the best of them."""
    along = comparison.axes.always[0]
    parameter = along if isinstance(along, Parameter) else None
    shown: dict[str, Drawing] = {}
    for one in comparison.ranking:
        solution = one.study.solution
        # A sweep of the inclination holds d.
        if solution.sweep is not None and (parameter or solution.parameter is not Parameter.INCLINATION):
            drawing = _with_stable(drawing_of(one.study))
            if drawing.parts and len(shown) < len(COLORS):
                shown[one.name] = drawing
    if len(shown) < 2:
        return
    axis = f"Over the {parameter.quantity}" if parameter else "Over d, as the sweeps are of different parameters"
    drawn = (
        "impact velocity on the bottom membrane and U_ave of the branches with stable 1:1 motion, or of all where none "
        "is stable, numbered as they are ranked"
    )
    others = [name for name in comparison.names if name not in shown]
    remarks = [f"not drawn: {listed(others)}"] if others else []
    if any(not drawing.study.solution.within_membrane for drawing in shown.values()):
        remarks.append(f"voltages {OUTSIDE} ({AlertCode.OUTSIDE_MEMBRANE_GEOMETRY})")
    note = f" {capital('; '.join(remarks))}." if remarks else ""
    ranges = "; ".join(f"{one.name}: {one.show(Merit.RANGE)}" for one in comparison.ranking if one.name in shown)
    alt = f"Line charts of {len(shown)} scenarios. {axis}: {drawn}. Stable ranges: {ranges}."
    figure = overlay(shown, parameter)
    yield Picture(OVERLAY, "All scenarios on one axis", f"{axis}: {drawn}.{note}", alt, figure)


def _with_stable(drawing: Drawing) -> Drawing:
    """A drawing without the branches and critical points that have no stable motion, where others have one."""
    branches = {part.branch.number for part in drawing.parts if part.stable}
    if not branches:
        return drawing
    parts = [part for part in drawing.parts if part.branch.number in branches]
    events = [event for event in drawing.events if any(branch.number in branches for branch, _ in event.places)]
    return replace(drawing, parts=parts, events=events)


def _side_by_side(comparison: Comparison) -> Iterator[Picture]:
    return (
        Picture(
            figure if number == 1 else f"{figure}-{number}",
            title_of(figure),
            _caption(figure, shown),
            _alt(figure, shown),
            _figure(figure, shown),
        )
        for figure in ROWS
        for number, shown in enumerate(_pages(comparison, figure), 1)
    )


def compare_figure(comparison: Comparison, name: str) -> tuple[Figure, ...]:
    """One kind of figure of a comparison, for notebooks.

    Parameters
    ----------
    comparison : Comparison
    name : str
        ``figure-2``, ``figure-4`` or ``figure-7``.

    Returns
    -------
    tuple of Figure
        One for each four scenarios; none where no scenario has it.
    """
    figure = Task(name)
    return tuple(_figure(figure, shown) for shown in _pages(comparison, figure))


def _pages(comparison: Comparison, figure: Task) -> Iterator[Columns]:
    """The scenarios of each figure of one kind, in groups of as many as fit beside one another."""
    skipped = {scenario for scenario, _ in left_out(comparison, figure)}
    shown = [
        (scenario, study)
        for scenario, study in zip(comparison.names, comparison.studies, strict=True)
        if scenario not in skipped
    ]
    for part in columns(len(shown)):
        yield {scenario: _ranked(drawing_of(study, simulated_points(study))) for scenario, study in shown[part]}


def _ranked(drawing: Drawing) -> Drawing:
    """A drawing whose branches are named by family, and numbered there if there are several, the stable ones first.

    The number of a branch stands for another family in another scenario.
    """
    stable = {part.branch.number for part in drawing.parts if part.stable}
    families = {part.branch.number: part.branch.symmetry for part in drawing.parts}
    ordered = sorted(
        drawing.branches, key=lambda number: (families[number] != "symmetric", number not in stable, number)
    )
    ranks = {
        number: 1 + [families[other] for other in ordered[:k]].count(families[number])
        for k, number in enumerate(ordered)
    }
    return replace(drawing, branches={number: f"{families[number]} {ranks[number]}" for number in ordered})


def _figure(figure: Task, shown: Columns) -> Figure:
    common, own = _conditions(list(shown.values()))
    lines = [(common, Color.BLACK)] if common else []
    if figure == Task.FIGURE_7 and (note := _outside(shown)):
        lines.append((literal(note), Color.WARNING))
    return sweep_figure(figure, list(shown.values()), [literal(name) for name in shown], own, lines)


def _conditions(drawings: Sequence[Drawing]) -> tuple[str, list[str]]:
    """What all scenarios hold, and what each holds beyond that."""
    each = [held(drawing.study) for drawing in drawings]
    common = [text for text in each[0] if all(text in texts for texts in each)]
    return ", ".join(common), [", ".join(text for text in texts if text not in common) for texts in each]


def _outside(shown: Columns) -> str:
    names = [name for name, drawing in shown.items() if not drawing.study.solution.within_membrane]
    if not names:
        return ""
    return capital(OUTSIDE) if len(names) == len(shown) else f"{listed(names)}: {OUTSIDE}"


def _caption(figure: Task, shown: Columns) -> str:
    common, own = _conditions(list(shown.values()))
    columns = [common] if common else []
    for column, (scenario, drawing) in enumerate(shown.items()):
        first, last = (letter_of(column * ROWS[figure] + row) for row in (0, ROWS[figure] - 1))
        letters = f"({first})" if first == last else f"({first})–({last})"
        known = [text for text in (own[column], swept_range(drawing.study)) if text]
        columns.append(f"{letters} {scenario}: {', '.join(known)}")
    if figure == Task.FIGURE_7 and (note := _outside(shown)):
        columns.append(f"{note} ({AlertCode.OUTSIDE_MEMBRANE_GEOMETRY})")
    return f"{about(figure)}{SHARED if len(shown) > 1 else ''}. {'; '.join(columns)}."


def _alt(figure: Task, shown: Columns) -> str:
    count = len(shown)
    head = f"{count} column{'s' * (count != 1)} of {ROWS[figure]} panel{'s' * (ROWS[figure] != 1)}."
    columns_in_words = [
        f"{capital(scenario)}: {alt_text(figure, shown_along(drawing.study, figure, drawing.simulated))}"
        for scenario, drawing in shown.items()
    ]
    return " ".join([head, *columns_in_words])
