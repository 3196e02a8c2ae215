"""What the commands `run` and `compare` come to: results on standard output, or reports, figures and tables as files.

Only what the formats asked for need is imported.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.progress import portion
from vireport.cli.outcome import CommandOutcome
from vireport.scenario.loading import Loaded
from vireport.study.judging.evidence import unmet
from vireport.study.judging.findings import findings, with_results
from vireport.study.plan import FIGURE_FORMATS, FIGURES_OF_PAGES, Task, figures, page_and_figure_files
from vireport.study.provenance import Provenance, provenance_of, with_pages
from vireport.study.results import branches_csv
from vireport.study.study import Study, analyse, results_json
from vireport.text.alerts import AlertCode

if TYPE_CHECKING:
    from vireport.base.progress import Progress
    from vireport.figures.style import Picture
    from vireport.study.earlier import Earlier
    from vireport.study.judging.opening import Opening
    from vireport.text.tables import Table


ANALYSED_SHARE = 0.9
"""Share of the time of a run that the study takes where it is long enough to wait for; figures and pages take the rest.
"""

NAMES = {
    **page_and_figure_files(figures()),
    Task.JSON: ("results.json", *(file for finding in findings().values() for file in finding.files)),
    Task.CSV: ("branches.csv",),
    Task.JUNIT: ("junit.xml",),
    Task.MARKDOWN: ("summary.md",),
}
"""Files that a run may write, by their formats."""


def file_names(formats: Iterable[str], names: Mapping[Any, tuple[str, ...]] = NAMES) -> tuple[str, ...]:
    """The files that a run may write in these formats, or another command, by its table of names."""
    return tuple(name for task in formats for name in names.get(task, ()))


def results_outcome(
    loaded: Loaded, command: str, formats: Sequence[str], earlier: Earlier | None = None, say: Progress | None = None
) -> CommandOutcome:
    """The results of a scenario, on standard output."""
    study = analyse(loaded, formats, say)
    outcome = CommandOutcome(results_json(study, provenance_of(loaded, command)))
    return _again(_judged(outcome, study), study, earlier)


class PageSettings(Struct, frozen=True):
    """The formats that a command writes for a reader, with templates, paper and width.

    Attributes
    ----------
    formats : sequence of str
        Among `study.ALL_FORMATS`, or the name of an addition that is asked for as these are.
    templates : Path, optional
        A folder whose report templates replace the package's.
    paper : str
        Of the PDF: a4 or letter.
    width_mm : float, optional
        Of figures for a column of a paper.
    every_figure : bool
        Whether the figures that are on the pages are files of their own as well.
    """

    formats: Sequence[str] = ()
    templates: Path | None = None
    paper: str = "a4"
    width_mm: float | None = None
    every_figure: bool = True


class BeyondStudy(Struct, frozen=True, eq=False):
    """What a report has beyond its study.

    Attributes
    ----------
    changes : Table, optional
        What has changed since a baseline.
    search : tuple of str or Table
        On the search for the best design, if it is one.
    pictures : tuple of Picture
        Of that search.
    opens : Opening, optional
        What it begins with, if that is not a run.
    """

    changes: Table | None = None
    search: tuple[str | Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    opens: Opening | None = None


class BeforeRun(Struct, frozen=True, eq=False):
    """Earlier results that a run is held against.

    Attributes
    ----------
    baseline : mapping, optional
        results.json as data. What has changed since is told, and has no part in the exit code.
    earlier : Earlier, optional
        The run that the scenario comes from: what differs from its results is told.
    """

    baseline: Mapping[str, object] | None = None
    earlier: Earlier | None = None


def run_outcome(loaded: Loaded, command: str, pages: PageSettings, before: BeforeRun, say: Progress) -> CommandOutcome:
    """The files of a scenario, what is for standard output beside them, and the verdict.

    Parameters
    ----------
    loaded : Loaded
    command : str
        For the record.
    pages : PageSettings
    before : BeforeRun
    say : callable
        Called with each step as it begins.
    """
    formats, templates = pages.formats, pages.templates
    study = analyse(loaded, formats, portion(say, 0.0, ANALYSED_SHARE))
    printed = ""
    if study.plan.runs(Task.GITHUB):
        from vireport.report.ci_formats import github

        printed = github(study)
    doubts = (alert.words(templates) for alert in study.alerts if alert.code in DOUBTFUL_INPUTS)
    summary, changes = "\n".join([*study.opening.worded(templates).lines, *doubts]), None
    if before.baseline is not None:
        from vireport.report.changes.baseline import diff
        from vireport.report.changes.diff_outputs import changes_table, diff_text

        changed = diff(before.baseline, study)
        summary, changes = (
            f"{summary}\n{diff_text(changed, templates=templates)}",
            changes_table(changed, templates=templates),
        )
    files = run_files(study, command, pages, say, BeyondStudy(changes))
    outcome = _judged(CommandOutcome(printed, _printed(study), files, summary=summary), study, templates)
    others = [task for task in NAMES if task not in formats]
    return replace(
        _again(outcome, study, before.earlier, templates), stale=file_names(formats), other_files=file_names(others)
    )


DOUBTFUL_INPUTS = (AlertCode.IMPLAUSIBLE_INPUT, AlertCode.RECORD_DOUBTFUL)
"""Alerts that a terminal says in full: what was given may be wrong, and so may all that follows."""


def run_files(
    study: Study, command: str, pages: PageSettings, say: Progress, beyond: BeyondStudy | None = None
) -> dict[str, bytes]:
    """The files of a study by their names.

    Parameters
    ----------
    study : Study
        Of which the plan says which files there are.
    command : str
        For the record.
    pages : PageSettings
    say : callable
        Called with each step as it begins.
    beyond : BeyondStudy, optional
    """
    templates, beyond = pages.templates, beyond or BeyondStudy()
    plan, provenance, files = study.plan, provenance_of(study.loaded, command), dict[str, bytes]()
    pictures = beyond.pictures
    if plan.runs(*figures()):
        say("drawing")
        from vireport.figures.curves import simulated_points
        from vireport.figures.pictures import pictures as pictures_of

        pictures = (*pictures_of(study, simulated_points(study), templates, width_mm=pages.width_mm), *pictures)
    if plan.runs(Task.HTML, Task.PDF, *FIGURE_FORMATS):
        say("setting the report")
        from vireport.report.context import Report
        from vireport.report.rendering import render_files

        paged = plan.runs(Task.HTML, Task.PDF)
        origin = with_pages(provenance, drawn=bool(pictures)) if paged else provenance
        on_pages = () if pages.every_figure else FIGURES_OF_PAGES
        pixels = {picture.name for picture in pictures if plan.runs(Task.PNG) and picture.name not in on_pages}
        drawn = {picture.name: replace(picture, recorded=picture.name in pixels) for picture in pictures}
        report = Report(study, drawn, origin, beyond.changes, beyond.search, templates, opens=beyond.opens)
        drawn_in = {task for task in NAMES if plan.runs(task)}
        files |= render_files(report, drawn_in, pages.paper, lambda: _data_files(study, provenance), on_pages)
    else:
        files |= _data_files(study, provenance)
    if plan.runs(Task.JUNIT):
        from vireport.report.ci_formats import junit

        files["junit.xml"] = junit(study, templates)
    if plan.runs(Task.MARKDOWN):
        from vireport.report.context import Report
        from vireport.report.rendering import render_markdown

        summary = Report(study, {}, provenance, beyond.changes, templates=templates, template="summary.md.j2")
        files["summary.md"] = render_markdown(summary)
    return files


def _data_files(study: Study, provenance: Provenance) -> dict[str, bytes]:
    """The results of a study as data, in the files that are asked for."""
    files = dict[str, bytes]()
    if study.plan.runs(Task.JSON):
        files["results.json"] = results_json(study, provenance)
        for finding, result in with_results(study.findings):
            files |= finding.written(result, study)
    if study.plan.runs(Task.CSV):
        files["branches.csv"] = branches_csv(study.solution, study.atlas)
    return files


def _judged(outcome: CommandOutcome, study: Study, templates: Path | None = None) -> CommandOutcome:
    """The outcome of a study, which fails where a requirement of the scenario is not met."""
    missed = unmet(study.criteria)
    return outcome if missed is None else replace(outcome, failure=missed.words(templates), exit_code=1)


def _again(
    outcome: CommandOutcome, study: Study, earlier: Earlier | None, templates: Path | None = None
) -> CommandOutcome:
    """The outcome with what differs from the results of the earlier run that the scenario comes from, if it does."""
    if earlier is None:
        return outcome
    from vireport.report.changes.diff_outputs import rerun_text

    lines = (outcome.summary or outcome.failure, rerun_text(earlier.results, study, earlier.file, templates))
    return replace(outcome, summary="\n".join(filter(None, lines)))


def _printed(study: Study) -> str:
    """What additions to a study print on standard output beside the summary."""
    return "".join(finding.printed(result, study) for finding, result in with_results(study.findings))
