"""What a search for the best design comes to, as text, JSON, a figure, and a scenario that runs."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import pairwise
from math import isfinite, prod
from textwrap import fill
from typing import TYPE_CHECKING, Any, cast

from vireport.design.tolerances import Tolerances
from vireport.gate.alerts import named_alerts
from vireport.optimise.grid import SAME_VALUE, JudgedDesign
from vireport.optimise.search import SearchResult
from vireport.scenario.blocks import DesignPath, Objective
from vireport.scenario.loading import loads
from vireport.scenario.parameters import DesignInput
from vireport.study.plan import FIGURE_FORMATS, Task
from vireport.study.provenance import Provenance
from vireport.study.results import json_bytes
from vireport.study.study import Study, analyse
from vireport.text.formatting import capital, error_bound, percent, significant
from vireport.text.tables import Table, numbers, plain_text, texts
from vireport.wording.templates import Words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vireport.base.progress import Progress
    from vireport.figures.style import Picture

ROUNDED_UP = 1 + 5e-6
"""A positive bound times this, rounded to six digits, still is one."""

MOST_SHOWN = 8
"""Digits of the inputs of the best design in a table; best.yaml has all."""

MOST_NAMED = 3
"""Inputs up to which each stands in the sentence."""

OBJECTIVE_DIGITS = 3
"""Significant digits of the objective; optimise.json has all."""

WORDS = Words("optimise")

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
        from vireport.figures.style import Sheet, drawn_for

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
            "built": _data(result, result.built, None),
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
    said = () if study is None else _as_a_run_says(study)
    return plain_text([sentence(result, study), *_parts(result), *said]) + "\n"


def _as_a_run_says(study: Study) -> Iterator[str]:
    yield f"A run of it says: {study.opening.worded().sentence}"
    if study.alerts:
        yield named_alerts(study.alerts)


def sentence(result: SearchResult, study: Study | None) -> str:
    """What a search comes to, in one sentence: the best design and whether it starts by itself."""
    point = result.built if result.built is not None else result.best
    if point is None:
        if result.nearest is None:
            return WORDS("none_stable")
        return WORDS("none_meets" if result.evidence.complete else "none_judged_meets")
    # Of a rounded design it is known only where that is required.
    own = point.study if result.built is not None else study
    evidence = None if own is None else own.evidence
    end = None if evidence is None else evidence.from_rest
    if evidence is None or end is None:
        name = "best_runs"
    else:
        name = "best_starts" if evidence.is_reached else "best_does_not_start" if end.decided else "best_not_known"
    names = [
        f"{_named(path)} {value}" for path, value in zip(result.problem.paths, _values(result, point), strict=True)
    ]
    return WORDS(name, ", ".join(names) if len(names) <= MOST_NAMED else WORDS("many_inputs", len(names)))


def _named(path: DesignPath) -> str:
    """What an input is called within a sentence; by its key where it has no name."""
    known = next((own.quantity for own in DesignInput if own.path == path), None)
    return known or path.rpartition(".")[2].replace("_", " ")


def _values(result: SearchResult, point: JudgedDesign) -> list[str]:
    """The inputs of a design with their units, in as many digits as they have, up to `MOST_SHOWN`."""
    units = {own.path: own for own in DesignInput}
    values = zip(result.problem.paths, result.problem.values(point.t).tolist(), strict=True)
    return [
        units[path].show(value, MOST_SHOWN) if path in units else significant(value, MOST_SHOWN)
        for path, value in values
    ]


def _parts(result: SearchResult) -> Iterator[str | Table]:
    problem, best = result.problem, result.best
    shown = result.built if result.built is not None else best
    point = shown if shown is not None else result.nearest
    if shown is None:
        yield f"{capital(shortcoming(result))}."
    else:
        objective = f"{problem.objective.words} {_in_unit(result, shown.value, OBJECTIVE_DIGITS)}"
        if problem.objective is Objective.MARGIN or not isfinite(shown.margin):
            yield WORDS("number", objective)
        else:
            yield WORDS("numbers", objective, percent(shown.margin, 2))
    if point is not None:
        ends = dict(problem.at_limits(point.t))
        rows = tuple(
            (
                varied.path.value,
                significant(value, MOST_SHOWN),
                significant(now, MOST_SHOWN),
                *map(significant, sorted((varied.from_, varied.to))),
                WORDS({True: "upper", False: "lower", None: "inside"}[ends.get(varied.path)]),
            )
            for varied, value, now in zip(
                problem.design.vary, problem.values(point.t).tolist(), problem.given, strict=True
            )
        )
        caption = "The best design" if best is not None else "The nearest design"
        note = WORDS("rounded") if result.built is not None else ""
        head = (*texts("Input"), *numbers("Value", "In the scenario", "From", "To"), *texts("At its limit"))
        yield Table(caption, head, rows, note)
    if best is not None and (ends_of_best := [_named(path) for path, _ in problem.at_limits(best.t)]):
        yield WORDS("limits", ends_of_best)
    if problem.usual:
        yield _usual_text(result)
    yield " ".join(_evidence(result))
    if len(result.front) > 1:
        yield _front_table(result)


def _usual_text(result: SearchResult) -> str:
    """What is required though the scenario does not say so."""
    limits = "; ".join(
        f"{row.title}{f' {limit.text}' if limit.numbers else ''} ({row.key})" for row, limit in result.problem.usual
    )
    return f"Required because the scenario does not say otherwise: {limits}."


def _extreme(result: SearchResult) -> str:
    return "largest" if result.problem.sign > 0 else "smallest"


def _in_unit(result: SearchResult, value: float, digits: int) -> str:
    """A value of the objective with its unit."""
    return f"{significant(abs(value), digits)} {result.problem.objective.unit}".rstrip()


def _evidence(result: SearchResult) -> Iterator[str]:
    """What is known of other designs; optimise.json has all numbers."""
    evidence, cells = result.evidence, prod(result.evidence.counts)
    shown = result.built if result.built is not None else result.best
    if evidence.yielding is not None:
        yield WORDS("yielding", percent(evidence.yielding))
    elif evidence.tolerated == 0:
        yield WORDS("none_tolerates", percent(evidence.tolerances))
    if evidence.widest is not None:
        yield WORDS("widest", _not_less(evidence.widest))
    if evidence.bound is not None and shown is not None:
        above = ROUNDED_UP * evidence.bound / shown.value - 1
        yield WORDS("proved", _not_less(above)) if above > SAME_VALUE else WORDS("proved_best")
    elif evidence.best_cell is not None:
        yield WORDS("on_grid", f"{cells:,}")
    if evidence.elsewhere:
        yield WORDS("elsewhere", evidence.elsewhere)
    if not evidence.complete:
        yield WORDS("not_judged", evidence.candidates - evidence.candidates_judged)


def _not_less(share: float) -> str:
    """A share in per cent, rounded up: what none exceeds none exceeds as it is printed."""
    return f"{error_bound(100 * share)} %"


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
    from vireport.figures.style import Picture

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


def _front(result: SearchResult) -> Figure:
    from vireport.figures.layout import blank, finished, round_ticks
    from vireport.figures.style import Color, sheet, style

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
