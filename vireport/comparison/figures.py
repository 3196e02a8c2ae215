"""Figures 2, 4 and 7 of several scenarios: a column for each, rows on shared axes, as the paper prints them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from vireport.comparison.comparison import Comparison, left_out
from vireport.comparison.differences import listed
from vireport.comparison.pages import columns
from vireport.figures import (
    BLACK,
    BRANCH_COLORS,
    OUTSIDE,
    TITLES,
    WARNING,
    Column,
    Drawing,
    Entry,
    Floats,
    Picture,
    Row,
    Simulated,
    Stretch,
    alt_text,
    column_caption,
    grid,
    held,
    legend_2,
    legend_4,
    legend_7,
    letters_along,
    limits,
    outside_geometry,
    panel_letter,
    png_of,
    point_legend,
    prefix,
    rows_2,
    rows_4,
    rows_7,
    seen_7,
    simulated_points,
    style,
    without_mirrors,
)
from vireport.gate import capital
from vireport.study import Study

HEIGHTS = {"figure-2": 1.75, "figure-4": 2.1, "figure-7": 2.6}
"""Of the panels [in]."""

ROWS = {"figure-2": 3, "figure-4": 2, "figure-7": 1}

ABOUT = {
    "figure-2": "From above: magnitude of the impact velocity |Ż| in units of F/(2 M f), phase φ of the force at the "
    "impact, flight time over two Δt/2, which is the flight time in forcing periods. Blue and thick: impact k−1, on "
    "the bottom membrane, and the flight from it; green and thin: impact k, on the top one. Solid: stable; "
    "dash-dotted: unstable.",
    "figure-4": "Above: discriminant Δ = tr² − 4 det of the linearised return map; below: its eigenvalues λ₁ ≥ λ₂, and "
    "where Δ < 0 the real part that they share (thick). Solid: stable; dash-dotted: unstable. Red, thin: Δ = 0, λ = 0 "
    "and λ = ±1, the bounds of Table 1. Of each family, branches with stable motions come first; mirror images share "
    "one curve. Where a motion is far from stable, its curves leave the axes.",
    "figure-7": "Red and thick: U_ave, the mean over both impacts; blue: U_imp − U_in at the bottom membrane (solid) "
    "and at the top one (dashed); dotted where the motion is unstable, more sparsely at the top.",
}

SHARED = "The panels of a row share their vertical axis."


@dataclass(frozen=True, slots=True, eq=False)
class _Shown:
    """A scenario in a figure."""

    name: str
    study: Study
    simulated: Simulated | None


def compare_pictures(comparison: Comparison) -> tuple[Picture, ...]:
    """Draw figures 2, 4 and 7 of a comparison, at most four scenarios in each.

    Parameters
    ----------
    comparison : Comparison
        Scenarios without a sweep are left out, and from figure 7 those without a ball mass.
    """
    found = []
    for name in ROWS:
        for page, shown in enumerate(_pages(comparison, name), 1):
            file = name if page == 1 else f"{name}-{page}"
            with style():
                drawn = png_of(_figure(name, shown))
            found.append(Picture(file, TITLES[name], _caption(name, shown), _alt(name, shown), *drawn))
    return tuple(found)


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
    with style():
        return tuple(_figure(name, shown) for shown in _pages(comparison, name))


def _pages(comparison: Comparison, name: str) -> list[list[_Shown]]:
    skipped = {scenario for scenario, _ in left_out(comparison, name)}
    shown = [
        _Shown(scenario, study, simulated_points(study) if study.crosscheck is not None else None)
        for scenario, study in zip(comparison.names, comparison.studies, strict=True)
        if scenario not in skipped
    ]
    return [shown[part] for part in columns(len(shown))]


def _figure(name: str, shown: Sequence[_Shown]) -> Figure:
    drawings = [Drawing(one.study, letters_along(len(shown))) for one in shown]
    rows, legend = {"figure-2": _two, "figure-4": _four, "figure-7": _seven}[name](drawings, shown)
    common, own = _conditions([one.study for one in shown])
    columns = [
        Column(one.name, remark, drawing.along) for one, remark, drawing in zip(shown, own, drawings, strict=True)
    ]
    head = [(common, BLACK)] if common else []
    if name == "figure-7" and (note := _outside(shown)):
        head.append((note, WARNING))
    points = point_legend(event for drawing in drawings for event in drawing.events)
    page = grid(columns, ROWS[name], HEIGHTS[name], head, [legend, points])
    for k, across in enumerate(zip(*rows, strict=True)):
        fixed = across[0].fixed or limits([y for row in across for y in row.values])
        for column, row in enumerate(across):
            row.draw(page.panel(k, column, row.label, fixed, row.ticks))
    return page.figure


Made = tuple[list[list[Row]], list[Entry]]
"""The rows of each scenario, and a legend for all."""


def _two(drawings: Sequence[Drawing], shown: Sequence[_Shown]) -> Made:
    rows = [rows_2(drawing, one.simulated) for drawing, one in zip(drawings, shown, strict=True)]
    return rows, legend_2(_parts(drawings), any(one.simulated for one in shown))


def _four(drawings: Sequence[Drawing], shown: Sequence[_Shown]) -> Made:
    del shown
    families = [_ranked(drawing) for drawing in drawings]
    names = sorted(
        {name for ranked in families for name in ranked.values()}, key=lambda name: (name[0] != "symmetric", name)
    )
    colors = {name: BRANCH_COLORS[k % len(BRANCH_COLORS)] for k, name in enumerate(names)}
    rows = [
        rows_4(drawing, {number: colors[name] for number, name in ranked.items()})
        for drawing, ranked in zip(drawings, families, strict=True)
    ]
    several = {family for family, rank in names if rank}
    named = {f"{family} {rank + 1}" if family in several else family: colors[family, rank] for family, rank in names}
    return rows, legend_4(_parts(drawings), named)


def _ranked(drawing: Drawing) -> dict[int, tuple[str, int]]:
    """Family of each branch and its rank there, those with stable motions first.

    The number of a branch stands for another family in another scenario.
    """
    branches = without_mirrors(drawing)
    stable = {part.branch.number for part in drawing.parts if part.stable}
    ordered = sorted(branches, key=lambda number: (number not in stable, number))
    families = [branches[number] for number in ordered]
    return {
        number: (family, families[:k].count(family))
        for k, (number, family) in enumerate(zip(ordered, families, strict=True))
    }


def _seven(drawings: Sequence[Drawing], shown: Sequence[_Shown]) -> Made:
    seen: list[Floats] = [
        y for drawing, one in zip(drawings, shown, strict=True) for y in seen_7(drawing, one.simulated)
    ]
    power = prefix(seen)
    rows = [rows_7(drawing, one.simulated, power) for drawing, one in zip(drawings, shown, strict=True)]
    return rows, legend_7(_parts(drawings), any(one.simulated and one.simulated.voltages for one in shown))


def _parts(drawings: Sequence[Drawing]) -> list[Stretch]:
    return [part for drawing in drawings for part in drawing.parts]


def _conditions(studies: Sequence[Study]) -> tuple[str, list[str]]:
    """What all scenarios hold, and what each holds beyond that."""
    each = [held(study) for study in studies]
    common = [text for text in each[0] if all(text in texts for texts in each)]
    return ", ".join(common), [", ".join(text for text in texts if text not in common) for texts in each]


def _outside(shown: Sequence[_Shown]) -> str:
    names = [one.name for one in shown if outside_geometry(one.study)]
    if not names:
        return ""
    return capital(OUTSIDE) if len(names) == len(shown) else f"{listed(names)}: {OUTSIDE}"


def _caption(name: str, shown: Sequence[_Shown]) -> str:
    told = [ABOUT[name], SHARED if len(shown) > 1 else ""]
    if name == "figure-7" and (note := _outside(shown)):
        told.append(f"{note} (VR010).")
    for column, one in enumerate(shown):
        first, last = (panel_letter(row, column, ROWS[name]) for row in (0, ROWS[name] - 1))
        letters = first if first == last else f"{first}–{last}"
        told.append(f"{letters} {one.name}: {column_caption(one.study, name, one.simulated)}")
    if any(one.study.solution.design is not None for one in shown):
        told.append("Vertical lines: the design points.")
    return " ".join(filter(None, told))


def _alt(name: str, shown: Sequence[_Shown]) -> str:
    count = len(shown)
    head = f"{count} column{'s' * (count != 1)} of {ROWS[name]} panel{'s' * (ROWS[name] != 1)}."
    return " ".join([head, *(f"{capital(one.name)}: {alt_text(one.study, name, one.simulated)}" for one in shown)])
