"""What a search for the best design comes to, as text, JSON, a figure, and a scenario that runs."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import pairwise
from math import isfinite, prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from msgspec.structs import replace

from vireport.base.records import keyed
from vireport.optimise.grid import OFF, SAME_VALUE, JudgedDesign
from vireport.optimise.results import OptimiseData, SearchedDesign, SearchEvidenceData
from vireport.optimise.search import SearchResult
from vireport.scenario.blocks import DesignPath, Objective, key_of, set_in_type, unit_of
from vireport.scenario.demands import Need
from vireport.scenario.loading import loads
from vireport.scenario.parameters import DesignInput
from vireport.study.judging.alerts import named_alerts
from vireport.study.judging.evidence import unmet_criteria
from vireport.study.judging.opening import MOST_FACTS, Opening, Statement
from vireport.study.judging.verdict import Status
from vireport.study.plan import FIGURE_FORMATS, Task, page_and_figure_files
from vireport.study.provenance import Provenance
from vireport.study.results import json_bytes
from vireport.study.study import Study, analyse
from vireport.text.formatting import (
    OF_A_MODEL,
    OF_INPUTS,
    ROUGHLY,
    Exactness,
    apart,
    error_bound,
    percent,
    quantity,
    rounded_text,
    span,
    stated_text,
)
from vireport.text.said import Said, words_of
from vireport.text.tables import Table, numbers, plain_text, worded_table
from vireport.text.templates import Words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vireport.base.progress import Progress
    from vireport.cli.outputs import PageSettings
    from vireport.figures.style import Picture

ROUNDED_UP = 1 + 5e-6
"""A positive bound times this, rounded to six digits, still is one."""

MOST_NAMED = 3
"""Inputs up to which each stands in the sentence."""

PREFIXED = "V", "V/s", "V/m", "m", "m/s", "N/mʰ"
"""Units of objectives and of membranes that take a prefix."""

FILE = "optimise"
"""Of words."""

_said = words_of(FILE)

PAGES = Task.HTML, Task.PDF
"""Reports on the best design."""

OPTIMISE_FILES = page_and_figure_files(["front"])
"""Files that a search may be written to beside its data, by their formats."""

BEST, UNROUNDED = "best.yaml", "unrounded.yaml"
"""The design that is shown, where it meets the requirements, and as it was before it was rounded."""

DATA = BEST, UNROUNDED, "optimise.json"
"""Files that every search writes, the first two where there is such a design."""


def run_of(result: SearchResult, pages: Collection[Task] = (), progress: Progress | None = None) -> Study | None:
    """What a run finds of the design that is shown: see `SearchResult.reported`; None where there is none.

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
    if result.reported is None:
        return None
    return analyse(loads(result.problem.scenario_text(result.reported.t), BEST), pages or (Task.JSON,), progress)


def files(
    result: SearchResult,
    study: Study | None,
    provenance: Provenance,
    pages: PageSettings,
) -> dict[str, bytes]:
    """The data of a search and its figure by their names; the best design is there where there is one.

    Parameters
    ----------
    result : SearchResult
    study : Study or None
        `run_of` it.
    provenance : Provenance
    pages : PageSettings
        By which the figure is written.
    """
    written = {"optimise.json": optimise_json(result, study, provenance)}
    if result.best is not None:
        design = result.best if result.built is None else result.built
        written[BEST] = result.problem.scenario_text(design.t).encode()
        if result.built is not None:
            written[UNROUNDED] = result.problem.scenario_text(result.best.t).encode()
    figure_formats = [task for task in FIGURE_FORMATS if task in pages.formats]
    if len(result.front) > 1 and figure_formats:
        from vireport.figures.style import Sheet, drawn_for

        with drawn_for(Sheet.of(pages.width_mm)):
            drawn = picture_front(result, pages.templates)
        for (name,) in (OPTIMISE_FILES[task] for task in figure_formats):
            written[name] = getattr(drawn, name.rpartition(".")[2])
    return written


def section(result: SearchResult, templates: Path | None = None) -> tuple[tuple[str | Table, ...], tuple[Picture, ...]]:
    """What the report on the best design says of the search, and its figure of the front."""
    drawn = (picture_front(result, templates),) if len(result.front) > 1 else ()
    return tuple(_parts(result, Words(FILE, templates))), drawn


def optimise_json(result: SearchResult, study: Study | None, provenance: Provenance) -> bytes:
    """The result as JSON, one top-level key a line; `study` is `run_of` it."""
    problem, evidence, design = result.problem, result.evidence, result.reported

    def data(point: JudgedDesign | None) -> SearchedDesign | None:
        return None if point is None else _data(result, point, study if point is design else point.study)

    searched = OptimiseData(
        objective=problem.objective,
        sense="maximise" if problem.sign > 0 else "minimise",
        unit=problem.objective.unit,
        limits_by_default={row.key: limit.value if limit.numbers else True for row, limit in problem.usual},
        best=data(result.best),
        built=data(result.built),
        nearest=data(result.nearest),
        front=[_data(result, point, point.study) for point in result.front],
        evidence=SearchEvidenceData(
            cells=list(evidence.counts),
            stable=evidence.stable,
            within_limits=evidence.within,
            tolerated=evidence.tolerated,
            no_cell_tolerates_percent=None if evidence.tolerances == 1 else 100 * evidence.tolerances,
            yield_takes_percent=None if evidence.yielding is None else 100 * evidence.yielding,
            judged=evidence.judged,
            candidates=evidence.candidates,
            candidates_judged=evidence.candidates_judged,
            best_cell=None if evidence.best_cell is None else problem.sign * evidence.best_cell,
            largest_step=evidence.step,
            no_cell_has_margin_percent=None if evidence.widest is None else 100 * evidence.widest,
            proved_bound=evidence.bound,
            cells_elsewhere=evidence.elsewhere,
        ),
    )
    return json_bytes(keyed(searched), provenance)


def _data(result: SearchResult, point: JudgedDesign, study: Study | None) -> SearchedDesign:
    """A design of a search, with the alerts of a study of it."""
    alerts = () if study is None else study.alerts
    return SearchedDesign(
        inputs=dict(zip(map(str, result.problem.paths), result.problem.values(point.t).tolist(), strict=True)),
        value=result.problem.sign * point.value if isfinite(point.value) else None,
        margin_percent=100 * point.margin if isfinite(point.margin) else None,
        at_limit={path: "upper" if upper else "lower" for path, upper in result.problem.at_limits(point.t)},
        requirements=[replace(criterion.data, line=None) for criterion in point.study.criteria],
        alerts=[alert.data for alert in alerts],
    )


def shortcoming(result: SearchResult, templates: Path | None = None) -> str:
    """The requirement that no design meets, and by how much it is missed; "" where they are met."""
    return "" if result.best is not None else _shortcoming(result).words(templates)


def _shortcoming(result: SearchResult) -> Said:
    nearest, evidence = result.nearest, result.evidence
    if nearest is None:
        return _said("none_stable_in_ranges")
    unmet = unmet_criteria(nearest.study.criteria)
    failed = [_said("missed_by" if line.margin_text else "missed", line) for line in unmet]
    if not nearest.tolerated:
        failed.append(_beyond_tolerances(nearest.study.findings[Need.TOLERANCES]))
    if not nearest.repeats:
        failed.append(_said("does_not_repeat", OFF))
    if evidence.complete:
        return _said("none_found", failed)
    return _said("none_of_judged", evidence.candidates_judged, evidence.candidates, failed)


def _beyond_tolerances(tolerances: Any) -> Said:
    """How far the tolerances of a design may not go."""
    worst = tolerances.worst
    if worst is None:
        return _said("tolerances_open", tolerances.proof.open_share if tolerances.proof else 1.0)
    values = tolerances.toleranced_of_worst
    device = [_said("input", varied.quantity, varied.stated(value)) for varied, value in values.items()]
    return _said("tolerances_end", device, worst.share)


def text(result: SearchResult, study: Study | None, templates: Path | None = None, tables: bool = False) -> str:
    """The result for a terminal, with `tables` also the design and what is known of others; `study` is `run_of` it."""
    said = opening(result, study).worded(templates).lines
    if not tables:
        return "\n".join([*said, ""])
    alerts = [named_alerts(study.alerts, templates)] if study is not None and study.alerts else []
    return "\n".join([*said, "", plain_text([*_parts(result, Words(FILE, templates)), *alerts]), ""])


def opening(result: SearchResult, study: Study | None) -> Opening:
    """What page and terminal begin with: the design, and what a run says of it; `study` is `run_of` it."""
    if result.best is None or result.reported is None or study is None:
        name = "none_stable" if result.nearest is None else "none_meets" if result.evidence.complete else "none_judged"
        missed = Statement(Status.BAD, _said("shortcoming", _shortcoming(result)))
        return Opening(Status.BAD, _said("word_none"), _said(name), (missed,))
    run, values = study.opening, _values(result, result.reported)
    ends = [
        _said("at_upper" if upper else "at_lower", path.rpartition(".")[2])
        for path, upper in result.problem.at_limits(result.reported.t)
    ]
    limits = [Statement(Status.NEUTRAL, _said("limits", ends))] if ends else []
    grave = [fact for fact in run.facts if fact.status in (Status.BAD, Status.CAUTION)]
    fulfilled = [fact for fact in run.facts if fact.said.macro == "requirements_met"]
    facts = [Statement(run.status, run.sentence), *grave[: MOST_FACTS - 1 - len(limits)], *limits, *fulfilled]
    named = [_said("input", _named(path), value) for path, value in zip(result.problem.paths, values, strict=True)]
    sentence = _said("best", named) if len(named) <= MOST_NAMED else _said("best_of_many", named)
    return Opening(run.status, run.word, sentence, tuple(facts[:MOST_FACTS]), tuple(_tiles(result, study)))


def _tiles(result: SearchResult, study: Study) -> Iterator[Statement]:
    """The tiles of a run; the objective instead of the range, where neither the sentence nor another number is that."""
    objective, design, run = result.problem.objective, cast(JudgedDesign, result.reported), study.opening
    if objective.path is not None or objective is Objective.U_AVE:
        yield from run.tiles
        return
    exactness, large = study.evidence.exactness, _said("large" if result.problem.sign > 0 else "small")
    value = _in_unit(result, design.value, exactness)
    if objective.unit in PREFIXED:
        value = quantity(abs(design.value), objective.unit, exactness)
    yield Statement(Status.NEUTRAL, _said("tile_objective", objective, value, large))
    yield from run.tiles[-3:]


def _extreme(result: SearchResult) -> Said:
    return _said("largest" if result.problem.sign > 0 else "smallest")


def _named(path: DesignPath) -> str:
    """What an input is called within a sentence."""
    quantity = next((varied.quantity for varied in DesignInput if varied.path == path), None)
    return quantity or (key_of(path).title or path).lower()


def _values(result: SearchResult, point: JudgedDesign) -> list[str]:
    """The inputs of a design with their units."""
    units = {varied.path: varied for varied in DesignInput}
    values = zip(result.problem.paths, result.problem.values(point.t).tolist(), strict=True)
    return [units[path].stated(value) if path in units else _with_unit(path, value) for path, value in values]


def _with_unit(path: DesignPath, value: float) -> str:
    """An input that has no margins, with the unit of its key."""
    unit = set_in_type(unit_of(key_of(path)))
    return quantity(value, unit, OF_INPUTS) if unit in PREFIXED else f"{stated_text(value)} {unit}".rstrip()


def _parts(result: SearchResult, say: Words) -> Iterator[str | Table]:
    """The inputs of the design, what is required by default, what is known of others, and what a margin costs."""
    if result.reported is not None:
        yield _table(result, result.reported, say)
    problem = result.problem
    if problem.usual:
        yield say(
            "usual",
            [say("usual_number" if limit.numbers else "usual_held", row, limit) for row, limit in problem.usual],
        )
    if evidence := " ".join(_evidence(result, say)):
        yield evidence
    if len(result.front) > 1:
        yield _front_table(result, say)


def _table(result: SearchResult, point: JudgedDesign, say: Words) -> Table:
    problem, best, built = result.problem, result.best, result.built
    ends = dict(problem.at_limits(point.t))
    rows = tuple(
        (
            varied.path.value,
            stated_text(value),
            stated_text(now),
            *map(stated_text, sorted((varied.from_, varied.to))),
            say({True: "upper", False: "lower", None: "inside"}[ends.get(varied.path)]),
        )
        for varied, value, now in zip(
            problem.design.vary, problem.values(point.t).tolist(), problem.stated, strict=True
        )
    )
    note = "" if best is None else say("rounded" if built is not None else "not_rounded")
    return worded_table(say, "table_best" if best is not None else "table_nearest", "tnnnnt", rows, note=note)


def _in_unit(result: SearchResult, value: float, exactness: Exactness = OF_A_MODEL) -> str:
    """A value of the objective with its unit."""
    objective = result.problem.objective
    number = rounded_text(abs(value), exactness) if objective.path is None else stated_text(abs(value))
    return f"{number} {objective.unit}".rstrip()


def _evidence(result: SearchResult, say: Words) -> Iterator[str]:
    """Sentences on the evidence that no other design is better; optimise.json has all numbers."""
    evidence, cells, design = result.evidence, f"{prod(result.evidence.counts):,}", result.reported
    if evidence.yielding is not None:
        yield say("yielding", percent(evidence.yielding))
    elif evidence.tolerated == 0:
        yield say("none_tolerates", percent(evidence.tolerances))
    if evidence.widest is not None:
        yield say("widest", _not_less(evidence.widest))
    if result.best is None or design is None:
        pass
    elif evidence.bound is not None:
        above = ROUNDED_UP * evidence.bound / design.value - 1
        yield say("proved", _not_less(above)) if above > SAME_VALUE else say("proved_best")
    elif evidence.best_cell is not None:
        above = (evidence.best_cell - design.value) / abs(design.value)
        yield say("on_grid_by", cells, _not_less(above)) if above > SAME_VALUE else say("on_grid", cells)
    if evidence.elsewhere:
        yield say("elsewhere", evidence.elsewhere)
    if not evidence.complete:
        yield say("not_judged", evidence.candidates - evidence.candidates_judged)


def _not_less(share: float) -> str:
    """A share in per cent, rounded up: what none exceeds none exceeds as it is printed."""
    return f"{error_bound(100 * share)} %"


def _front_table(result: SearchResult, say: Words) -> Table:
    """The best designs for rising margins, and what each per cent of margin costs."""
    objective = result.problem.objective
    costs = ("", *(rounded_text(cost) for cost in _costs(result)))
    values = [abs(point.value) for point in result.front]
    printed = apart(values) if objective.path is None else [stated_text(value) for value in values]
    # Nobody builds these: digits that tell them apart are enough, and all are in optimise.json.
    inputs = map(apart, np.transpose([result.problem.values(point.t) for point in result.front]).tolist())
    rows = [
        (rounded_text(100 * point.margin, ROUGHLY), value, cost, *input_values)
        for point, value, cost, *input_values in zip(result.front, printed, costs, *inputs, strict=True)
    ]
    heads = [objective.words, say("front_cost")]
    if objective.unit:
        heads = [say("in_unit", head, objective.unit) for head in heads]
    head = (say("front_margin"), *heads)
    caption = say("front_table", objective.words, _extreme(result).words(say.templates))
    return Table(caption, numbers(*head, *result.problem.paths), tuple(rows))


def _costs(result: SearchResult) -> list[float]:
    """What a per cent of margin costs between the designs of the front; nothing where a limit holds both values."""
    falls = ((before.value - after.value, before, after) for before, after in pairwise(result.front))
    return [
        fall / (100 * (after.margin - before.margin)) if fall > SAME_VALUE * abs(before.value) else 0.0
        for fall, before, after in falls
    ]


def picture_front(result: SearchResult, templates: Path | None = None) -> Picture:
    """The front with its words."""
    from vireport.figures.style import Picture

    say, of, first, last = Words(FILE, templates), result.problem.objective, result.front[0], result.front[-1]
    margins = f"{span(first.margin, last.margin, ROUGHLY, 2)} %"
    largest = _extreme(result).words(templates)
    values = [_in_unit(result, point.value) for point in (first, last)]
    caption = say("front_caption", of.words, largest, margins)
    alt = say("front_alt", of.words, largest, margins, *values)
    return Picture("figure-front", say("front_title"), caption, alt, _front(result, say))


def _front(result: SearchResult, say: Words) -> Figure:
    from vireport.figures.layout import blank, finished, fit_vertically, folded, round_ticks
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
        axes.set_xlabel(folded(say("front_along"), sheet().letters(sheet().across)))
        axes.set_ylabel(say("in_unit", objective.words, objective.unit))
        fit_vertically([axes])
        costs = span(min(_costs(result)), max(_costs(result)))
        lines: list[tuple[str, str]] = [(say("front_costs", costs, objective.unit), Color.BLUE)]
        lines += [(say("front_required"), Color.VERMILION)] if share else []
        return finished(figure, HEIGHT, lines, [])


HEIGHT, WIDTH = 3.0, 5.5
"""Height of the figure under its heading, and width of its horizontal axis for the choice of ticks [in]."""
