"""What `vireport verify` prints and writes: the text, the figures and the data of what was measured."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING

from msgspec.structs import replace

from vireport.base.encoding import json_text
from vireport.findings.accuracy.keys import AccuracyBlock
from vireport.findings.accuracy.methods import CLOSED, WHOLE
from vireport.findings.accuracy.tables import measurements, power, ranking
from vireport.findings.accuracy.workprecision import WorkPrecision
from vireport.scenario.keys import block_of
from vireport.scenario.loading import Loaded
from vireport.study.finding import AddedFinding
from vireport.study.judging.findings import findings, with_results
from vireport.study.judging.opening import Opening, Statement, gravest
from vireport.study.judging.verdict import Status
from vireport.study.plan import Task
from vireport.study.provenance import provenance_of
from vireport.study.result_records import blocks_of
from vireport.study.study import Study, analyse
from vireport.text.said import Said, words_of
from vireport.text.tables import Table, plain_text
from vireport.verify.results import AccuracyFile

if TYPE_CHECKING:
    from vireport.base.progress import Progress


NAMES = ("accuracy.json", "figure-accuracy.png", "figure-stiffness.png")
"""Files that may be written."""


_said = words_of("verify")

AGREES = 1e-9
"""Error up to which the solution is right: far below any digit that is shown, above what rounding leaves."""

CHECKS, MEMBRANES = "checks", "membranes"
"""The additions whose results are said and written; the latter where it is there."""

FORMATS = Task.PNG, Task.JSON
"""What a study of accuracy has."""


def with_accuracy_block(loaded: Loaded) -> Loaded:
    """A scenario with its accuracy block, or with the default one where it has none.

    Simulation and requirements are left out: they have no part in error against run time.
    """
    block = block_of(loaded.scenario, "accuracy", AccuracyBlock) or AccuracyBlock()
    changes = {"accuracy": block, "simulation": None, "requirements": None}
    return replace(loaded, scenario=loaded.scenario.model_copy(update=changes))


def measured_study(loaded: Loaded, progress: Progress | None = None) -> Study:
    """Study a scenario that has an accuracy block: error against run time, and compliant membranes."""
    return analyse(loaded, FORMATS, progress)


def accuracy_opening(study: Study) -> Opening:
    """Choose what is said of a study of accuracy: whether the solution is right, its worst error, its time."""
    work: WorkPrecision | None = study.findings.get(CHECKS)
    if work is None or work.benchmark is None:
        why = "" if work is None else work.nothing
        return Opening(Status.BAD, _said("word_nothing"), _said("nothing", why), tuple(_soft_membranes(study)))
    point, errors = work.benchmark.point, dict(_errors(work))
    wrong = [key for key, error in errors.items() if not error <= AGREES]
    names = [_said(key, point) for key in wrong or errors]
    status, name = (Status.BAD, "departs") if wrong else (Status.GOOD, "agrees")
    tiles = [Statement(Status.NEUTRAL, _said("tile_methods", len({run.method for run in work.runs}), len(work.runs)))]
    if errors:
        worst = max(errors, key=errors.__getitem__)
        tiles.append(Statement(status, _said("tile_worst", power(errors[worst]), _said(worst, point))))
    whole = work.without_guess()
    if whole is not None and whole.seconds is not None:
        tiles.append(Statement(Status.NEUTRAL, _said("tile_time", whole.seconds.median)))
    facts = gravest([*_soft_membranes(study), *_of_runs(work)])
    return Opening(status, _said(f"word_{name}"), _said(name, names), facts, tuple(tiles))


def _findings() -> Iterator[AddedFinding[object]]:
    """The additions whose results are said and written."""
    return (finding for name, finding in findings().items() if name in (CHECKS, MEMBRANES))


def _errors(work: WorkPrecision) -> Iterator[tuple[str, float]]:
    """The largest error of each quantity of which the closed form and the whole sweep leave one."""
    for quantity in work.quantities:
        errors = [
            runs[-1].errors[quantity.key]
            for name in (CLOSED, WHOLE)
            if (runs := [run for run in work.runs_of(name, quantity.task) if run.errors])
        ]
        if errors:
            yield quantity.key, max(errors)


def _soft_membranes(study: Study) -> Iterator[Statement]:
    """Whether rigid impacts are good enough, or why that is not known."""
    finding = findings().get(MEMBRANES)
    if finding is None:
        return
    compliance, answer = study.findings.get(MEMBRANES), study.verdict.added.get(MEMBRANES)
    if compliance is None:
        task = next(iter(finding.steps())).task
        yield Statement(Status.NEUTRAL, _said("soft_membranes_left_out", study.plan.reason(task)))
    else:
        status = Status.NEUTRAL if answer is None else answer.status
        yield Statement(status, _said("soft_membranes", finding.parts(compliance, None)["verdict"]))


def _of_runs(work: WorkPrecision) -> Iterator[Statement]:
    """Methods that were not tried, whose runs gave no answer, and a machine on which times tell little."""
    for untried in work.absent:
        yield Statement(Status.CAUTION, _said("not_tried", untried.method, untried.why))
    failed = Counter(run.method for run in work.runs if run.failed)
    if failed:
        names = [_said("failed_of", name, count) for name, count in failed.items()]
        yield Statement(Status.NEUTRAL, _said("failed", names))
    if work.busy:
        yield Statement(Status.CAUTION, Said("busy", (work.unsteadiness,), "accuracy"))


def text(study: Study, tables: bool = False, every: bool = False) -> str:
    """What was measured, for a terminal: the answer, and where asked for tables; with `every`, each run in a row."""
    opening = accuracy_opening(study).worded()
    facts = [fact for _, fact in opening.facts[1:]]
    parts = plain_text([*facts, *_parts(study, every)]).replace("*", "") if tables or every else ""
    return "\n\n".join(filter(None, ("\n".join(opening.lines), parts))) + "\n"


def _parts(study: Study, every: bool) -> Iterator[Table]:
    work: WorkPrecision | None = study.findings.get(CHECKS)
    if work is None:
        return
    yield from measurements(work, every)
    yield from ranking(work)
    for finding, result in with_results(study.findings):
        if finding.name == MEMBRANES:
            parts = finding.parts(result, None)
            yield from (*parts["comparison"], *parts["solvers"])


def data(study: Study, command: str) -> bytes:
    """What was measured by a command, as JSON."""
    blocks = (finding.results(study.findings.get(finding.name), study) for finding in _findings())
    content = AccuracyFile(
        scenario_sha256=study.loaded.sha256,
        added={key: block for added in blocks for key, block in added.items()},
        provenance=provenance_of(study.loaded, command),
    )
    return (json_text(blocks_of(content), indent=1) + "\n").encode()


def files(study: Study, command: str, width_mm: float | None = None) -> dict[str, bytes]:
    """The figures, as wide as a column of a paper where a width is given, and accuracy.json, by their names."""
    from vireport.figures.style import Sheet, drawn_for

    with drawn_for(Sheet.of(width_mm)):
        added = (finding.pictures(result, study, None) for finding, result in with_results(study.findings))
        drawn = {picture.name: picture.png for picture in chain.from_iterable(added)}
    return {"accuracy.json": data(study, command), **{f"{name}.png": png for name, png in drawn.items()}}
