"""What a search for the best design comes to, as text, JSON, a figure, and a scenario that runs."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from itertools import pairwise
from math import isfinite
from textwrap import fill
from typing import TYPE_CHECKING, Any, cast

from vireport.design import Tolerances
from vireport.gate import OfMotions, OfShaker, Question, named_alerts
from vireport.optimise.grid import SAME_VALUE, JudgedDesign
from vireport.optimise.search import SearchResult
from vireport.scenario import Objective, loads
from vireport.study import FIGURE_FORMATS, Provenance, Study, Task, analyse, json_bytes
from vireport.text import (
    Table,
    capital,
    numbers,
    percent,
    plain_text,
    significant,
    texts,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vireport.base import Progress
    from vireport.figures import Picture

ROUNDED_UP = 1 + 5e-6
"""A positive bound times this, rounded to six digits, still is one."""

MOST_SHOWN = 8
"""Digits of the inputs of the best design in a table; best.yaml has all."""

PAGES = Task.HTML, Task.PDF
"""Reports on the best design."""

OPTIMISE_FILES = {
    Task.HTML: ("report.html",),
    Task.PDF: ("report.pdf",),
    Task.PNG: ("front.png",),
    Task.SVG: ("front.svg",),
    Task.FIGURE_PDF: ("front.pdf",),
}
"""Files that a search may be written to beside its data, by their formats."""

FORMATS = (Task.HTML, Task.PDF, Task.PNG)
"""What is written by default."""

DATA = "best.yaml", "optimise.json"
"""Files that every search writes, the first where there is a best design."""


def run_of(result: SearchResult, pages: Collection[Task] = (), progress: Progress | None = None) -> Study | None:
    """What a run finds of the best design, or else of the nearest one; None where there is neither.

    Parameters
    ----------
    result : SearchResult
    pages : collection of Task
        Reports that are wanted of it, among `PAGES`.
    progress : callable, optional
        Called with each long step as it begins.

    Raises
    ------
    NumericalError
        Where a run ends with it.
    """
    point = result.best if result.best is not None else result.nearest
    if point is None:
        return None
    return analyse(loads(result.problem.scenario_text(point.t), DATA[0]), pages or (Task.JSON,), progress)


def files(
    result: SearchResult,
    study: Study | None,
    provenance: Provenance,
    formats: Collection[Task] = FORMATS,
    width_mm: float | None = None,
) -> dict[str, bytes]:
    """The data of a search and its figure by their names; the best design is there where there is one.

    Parameters
    ----------
    result : SearchResult
    study : Study or None
        `run_of` it.
    provenance : Provenance
    formats : collection of Task
        Of the figure, among `OPTIMISE_FILES`.
    width_mm : float, optional
        Of the figure, for a column of a paper.
    """
    written = {"optimise.json": optimise_json(result, study, provenance)}
    if result.best is not None:
        written["best.yaml"] = result.problem.scenario_text(result.best.t).encode()
    asked = [task for task in FIGURE_FORMATS if task in formats]
    if len(result.front) > 1 and asked:
        from vireport.figures import Sheet, drawn_for

        with drawn_for(Sheet.of(width_mm)):
            drawn = picture_front(result)
        for (name,) in (OPTIMISE_FILES[task] for task in asked):
            written[name] = getattr(drawn, name.rpartition(".")[2])
    return written


def section(result: SearchResult) -> tuple[tuple[str | Table, ...], tuple[Picture, ...]]:
    """What the report on the best design says of the search, and its figure of the front."""
    return tuple(_parts(result)), (picture_front(result),) if len(result.front) > 1 else ()


def optimise_json(result: SearchResult, study: Study | None, provenance: Provenance) -> bytes:
    """The result as JSON, one top-level key a line; `study` is `run_of` it."""
    problem, evidence = result.problem, result.evidence
    return json_bytes(
        {
            "objective": problem.objective,
            "sense": "maximise" if problem.sign > 0 else "minimise",
            "unit": problem.objective.unit,
            "limits_by_default": {row.key: limit.value if limit.numbers else True for row, limit in problem.usual},
            "best": _data(result, result.best, study),
            "nearest": _data(result, result.nearest, study),
            "front": [_data(result, point, point.study) for point in result.front],
            "evidence": {
                "cells": list(evidence.counts),
                "stable": evidence.stable,
                "within_limits": evidence.within,
                "tolerated": evidence.tolerated,
                "no_cell_tolerates_percent": None if evidence.tolerances == 1 else 100 * evidence.tolerances,
                "yield_takes_percent": None if evidence.yielding is None else 100 * evidence.yielding,
                "judged": evidence.judged,
                "candidates": evidence.candidates,
                "candidates_judged": evidence.candidates_judged,
                "best_cell": None if evidence.best_cell is None else problem.sign * evidence.best_cell,
                "largest_step": evidence.step,
                "no_cell_has_margin_percent": None if evidence.widest is None else 100 * evidence.widest,
                "proved_bound": evidence.bound,
                "cells_elsewhere": evidence.elsewhere,
            },
        },
        provenance,
    )


def _data(result: SearchResult, point: JudgedDesign | None, study: Study | None) -> dict[str, Any] | None:
    """A design of a search, with the alerts of a study of it."""
    if point is None:
        return None
    alerts = () if study is None else study.alerts
    return {
        "inputs": dict(zip(result.problem.paths, result.problem.values(point.t).tolist(), strict=True)),
        "value": result.problem.sign * point.value if isfinite(point.value) else None,
        "margin_percent": 100 * point.margin if isfinite(point.margin) else None,
        "at_limit": {path: "upper" if upper else "lower" for path, upper in result.problem.at_limits(point.t)},
        "requirements": [criterion.to_dict() | {"line": None} for criterion in point.study.criteria],
        "alerts": [alert.to_dict() for alert in alerts],
    }


def shortcoming(result: SearchResult) -> str:
    """What is in the way of the requirements, and by how much; "" where they are met."""
    if result.best is not None:
        return ""
    if result.nearest is None:
        return "no design with a stable 1:1 motion was found in the ranges (more design.cells are a finer grid)"
    failed = [
        f"{line.title} ({line.limit.text}): {line.outcome.text}"
        + (f" (margin {line.margin_text})" if line.margin_text else "")
        for line in result.nearest.study.criteria
        if not line.passed
    ]
    if not result.nearest.tolerated:
        failed.append(_beyond_tolerances(cast(Tolerances, result.nearest.study.tolerances)))
    evidence, nearest = result.evidence, f"the nearest fails {'; '.join(failed)}"
    if evidence.complete:
        return f"no design found in the ranges meets the requirements; {nearest}"
    return (
        f"none of the {evidence.candidates_judged} designs judged, of {evidence.candidates} candidates on the grid, "
        f"meets the requirements, and whether another does is open; {nearest}"
    )


def _beyond_tolerances(tolerances: Tolerances) -> str:
    """How far the tolerances of a design may not go."""
    if tolerances.worst is None:
        open_share = tolerances.proof.open_share if tolerances.proof else 1.0
        return f"tolerances: not proved for {percent(open_share)} of their volume"
    device = ", ".join(
        f"{varied.quantity} {varied.show(tolerances.worst.values[varied])}" for varied in tolerances.region.ranges
    )
    return f"tolerances: towards {device} stable motion ends at {percent(tolerances.worst.share)} of them"


def text(result: SearchResult, study: Study | None) -> str:
    """The result for a terminal, with what a run says of the best design: `study` is `run_of` it."""
    return plain_text([*_parts(result), *(() if study is None else _as_a_run_says(study))]) + "\n"


def _as_a_run_says(study: Study) -> Iterator[str]:
    yield f"A run of it says: {study.opening.worded().sentence}"
    if study.alerts:
        yield named_alerts(study.alerts)


def _parts(result: SearchResult) -> Iterator[str | Table]:
    problem, best = result.problem, result.best
    point = best if best is not None else result.nearest
    if best is None:
        yield f"{capital(shortcoming(result))}."
    else:
        margin = f"; smallest margin {significant(100 * best.margin, 4)} %" if isfinite(best.margin) else ""
        value = f"{problem.objective.words} {_in_unit(result, best.value, 4)}"
        yield f"Best design: {value}{'' if problem.objective is Objective.MARGIN else margin}."
    if point is not None:
        rows = tuple(
            (
                varied.path.value,
                significant(value, MOST_SHOWN),
                significant(now, MOST_SHOWN),
                *map(significant, sorted((varied.from_, varied.to))),
            )
            for varied, value, now in zip(
                problem.design.vary, problem.values(point.t).tolist(), problem.given, strict=True
            )
        )
        caption = "The best design" if best is not None else "The nearest design"
        yield Table(caption, (*texts("Input"), *numbers("Value", "In the scenario", "From", "To")), rows)
    if best is not None and (ends := _ends_text(result, best)):
        yield ends
    if problem.usual:
        yield _usual_text(result)
    yield _evidence_text(result)
    if len(result.front) > 1:
        yield _front_table(result)


def _ends_text(result: SearchResult, best: JudgedDesign) -> str:
    """Which inputs end the search where the best design is at an end of their range."""
    ends = [
        f"{path} is at its {'upper' if upper else 'lower'} limit" for path, upper in result.problem.at_limits(best.t)
    ]
    return f"{', '.join(ends)}; a wider range may give more." if ends else ""


def _usual_text(result: SearchResult) -> str:
    """What is required though the scenario does not say so."""
    limits = "; ".join(
        f"{row.title}{f' {limit.text}' if limit.numbers else ''} ({row.key})" for row, limit in result.problem.usual
    )
    return f"Required because the scenario does not say otherwise: {limits}."


def _better(result: SearchResult) -> str:
    return "more" if result.problem.sign > 0 else "less"


def _extreme(result: SearchResult) -> str:
    return "largest" if result.problem.sign > 0 else "smallest"


def _in_unit(result: SearchResult, value: float, digits: int) -> str:
    """A value of the objective with its unit."""
    return f"{significant(abs(value), digits)} {result.problem.objective.unit}".rstrip()


def _evidence_text(result: SearchResult) -> str:
    """What was evaluated, what follows from it, and what does not."""
    evidence = result.evidence
    said = (
        f"Evaluated: {' × '.join(map(str, evidence.counts))} designs on a grid, by the closed form; {evidence.stable} "
        f"have a stable motion, {evidence.within} of them meet the limits {_decided(result)}."
    )
    if evidence.yielding is not None:
        said += (
            f" The required yield takes stable motion at all corners of {percent(evidence.yielding)} of the "
            f"tolerances, as designs with more and with less show; {evidence.tolerated} of these keep that, and "
            f"{evidence.judged} designs were judged in full."
        )
    elif evidence.tolerated is not None:
        share = "" if evidence.tolerances == 1 else f" even {percent(evidence.tolerances)} of"
        said += (
            f" {evidence.tolerated or 'None'} of these keep stable motion at all corners of{share} the tolerances; for "
            f"each design judged in full, {evidence.judged}, the proof over the tolerances was tried."
        )
    if evidence.widest is not None:
        ruled_out = " that may meet the other requirements" if result.problem.rules_out else ""
        said += f" None of these{ruled_out} has a margin of {significant(100 * evidence.widest, 4)} %."
    if evidence.candidates:
        said += f" {_candidates_text(result)}"
    if evidence.best_cell is None:
        return said
    if evidence.bound is not None and result.best is not None:
        above = percent(max(evidence.bound / result.best.value - 1, 0.0))
        said += (
            f" No design in the ranges that meets the requirements, on the grid or between, has more than "
            f"{_in_unit(result, ROUNDED_UP * evidence.bound, 6)}, {above} above the best: proved in affine arithmetic."
        )
    kept = "meets all requirements" if evidence.yielding is None else "keeps that and meets the other requirements"
    count = evidence.elsewhere
    others = f"{count} other parts of the grid may" if count else "No other part of the grid can"
    return (
        f"{said} No cell that {kept} has {_better(result)} than {_in_unit(result, evidence.best_cell, 6)}; around the "
        f"best design neighbouring cells differ by at most {_in_unit(result, evidence.step, 3)}. {others} hold a "
        "better design, by the differences between neighbouring cells, to first order; what is narrower than a cell "
        "may be missed."
    )


def _decided(result: SearchResult) -> str:
    """What the limits are on that every cell is judged by."""
    usual = {Question.VOLTAGE, Question.SHAKER}
    exact = (row for row, _ in result.problem.required if isinstance(row.quantity, OfMotions | OfShaker))
    return "on voltage, energy and shaker" if {row.question for row in exact} <= usual else "that the grid decides"


def _candidates_text(result: SearchResult) -> str:
    """What is known of the cells that only runs could judge."""
    count, judged = result.evidence.candidates, result.evidence.candidates_judged
    could = "could meet the requirements" if result.best is None else "could be better than the best design"
    if judged == count:
        each = "1 cell" if count == 1 else f"{count} cells"
        return f"By the grid {each} {could}; judged one by one as a run does, none meets the requirements."
    return (
        f"By the grid {count} cells {could}; {judged} of them were judged one by one as a run does, and none of these "
        f"meets the requirements. The other {count - judged} are open."
    )


def _front_table(result: SearchResult) -> Table:
    """The best designs for rising margins, and what each per cent of margin costs."""
    objective = result.problem.objective
    costs = ("", *(significant(cost, 3) for cost in _costs(result)))
    rows = [
        (
            significant(100 * point.margin, 4),
            significant(abs(point.value)),
            cost,
            *map(significant, result.problem.values(point.t)),
        )
        for point, cost in zip(result.front, costs, strict=True)
    ]
    unit = f" [{objective.unit}]" if objective.unit else ""
    head = ("margin [%]", f"{objective.words}{unit}", f"cost of 1 %{unit}")
    caption = f"What margin costs: the {_extreme(result)} {objective.words} for each smallest margin"
    return Table(caption, numbers(*head, *result.problem.paths), tuple(rows))


def _costs(result: SearchResult) -> list[float]:
    """What a per cent of margin costs between the designs of the front; nothing where a limit holds both values."""
    falls = ((before.value - after.value, before, after) for before, after in pairwise(result.front))
    return [
        fall / (100 * (after.margin - before.margin)) if fall > SAME_VALUE * abs(before.value) else 0.0
        for fall, before, after in falls
    ]


def picture_front(result: SearchResult) -> Picture:
    """The front with its words."""
    from vireport.figures import Picture

    of, first, last = result.problem.objective, result.front[0], result.front[-1]
    margins = f"{significant(100 * first.margin, 3)} to {significant(100 * last.margin, 3)} %"
    caption = (
        f"The {_extreme(result)} {of.words} against the smallest margin to the end of stable motion, in whichever "
        "input that is. "
        f"Each point is the best design with that margin, from {margins}."
    )
    fall = f"from {_in_unit(result, first.value, 4)} to {_in_unit(result, last.value, 4)}"
    alt = f"Line chart. With smallest margins of {margins} the {_extreme(result)} {of.words} goes {fall}."
    return Picture("figure-front", "What margin costs", caption, alt, _front(result))


def figure_front(
    result: SearchResult, *, width_mm: float | None = None, style: Mapping[str, Any] | None = None
) -> Figure:
    """The largest objective against the smallest margin in any input, with the margin that is required.

    Parameters
    ----------
    result : SearchResult
        With a front.
    width_mm, style : float and mapping, optional
        As in `vireport.figure_2`.
    """
    from vireport.figures import Sheet, drawn_for

    with drawn_for(Sheet.of(width_mm, style)):
        return _front(result)


def _front(result: SearchResult) -> Figure:
    from vireport.figures import (
        Color,
        blank,
        finished,
        round_ticks,
        sheet,
        style,
    )

    objective, share = result.problem.objective, result.problem.share
    with style():
        figure, panels = blank(1)
        axes = panels[0, 0]
        margins, values = zip(*((100 * point.margin, abs(point.value)) for point in result.front), strict=True)
        axes.plot(margins, values, color=Color.BLUE, marker="o")
        axes.set_xticks(*round_ticks(0.0, margins[-1], min(WIDTH, sheet().across)))
        if share:
            axes.axvline(100 * share, color=Color.VERMILION, linestyle="--", zorder=1.5)
        along = "smallest margin to the end of stable motion, in any input [%]"
        axes.set_xlabel(fill(along, sheet().letters(sheet().across)))
        axes.set_ylabel(f"{objective.words} [{objective.unit}]")
        low, high = (significant(cost(_costs(result)), 3) for cost in (min, max))
        lines: list[tuple[str, str]] = [(f"1 % of margin costs {low} to {high} {objective.unit}", Color.BLUE)]
        lines += [("dashed: the margin that is required", Color.VERMILION)] if share else []
        return finished(figure, HEIGHT, lines, [])


HEIGHT, WIDTH = 3.0, 5.5
"""Height of the figure under its heading, and width of its horizontal axis for the choice of ticks [in]."""
