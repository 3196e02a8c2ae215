"""Runs a scenario to its files: study, pictures, report, results; each file is whole or is not there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.files import write_files
from vireport.scenario import Loaded
from vireport.study import (
    Study,
    analyse,
    provenance_of,
    with_certificates,
)

if TYPE_CHECKING:
    from vireport.figures import Picture, Simulated
    from vireport.gate import Criterion
    from vireport.progress import Progress


@dataclass(frozen=True, slots=True)
class Written:
    """What a run comes to, once its files are there.

    Attributes
    ----------
    summary : str
        In words.
    printed : str
        For standard output: annotations and proven enclosures, "" where neither is asked for.
    criteria : tuple of Criterion
        What the scenario requires.
    """

    summary: str
    printed: str
    criteria: tuple[Criterion, ...]


def default_folder(scenario: str) -> Path:
    """Folder named after the scenario, in the current one."""
    return Path("stdin" if scenario == "-" else Path(scenario).stem or "report")


def write_outputs(
    loaded: Loaded,
    folder: Path,
    formats: Iterable[str],
    command: str,
    templates: Path | None = None,
    progress: Progress | None = None,
    certify: bool = False,
) -> Written:
    """Study a scenario, write the outputs asked for, and return what it comes to.

    Parameters
    ----------
    loaded : Loaded
    folder : Path
        Created if it is not there.
    formats : iterable of str
        Among `plan.ALL_FORMATS`.
    command : str
        For the record.
    templates : Path, optional
        A folder whose report templates replace the package's.
    progress : callable, optional
        Told each step as it begins.
    certify : bool
        Whether to prove the critical points.

    Raises
    ------
    UsageError
        If the folder cannot be written to.
    """
    say = progress or (lambda what: None)
    say("solving")
    study = analyse(loaded, formats, say)
    if certify:
        say("proving the critical points")
        study = with_certificates(study)
    files = render(study, command, templates, say)
    say("writing")
    write_files(folder, files)
    say("")

    wrote = f"\nwrote {', '.join(str(folder / name) for name in files)}" if files else ""
    return Written(f"{study.verdict.headline}{wrote}", _printed(study), study.criteria)


def _printed(study: Study) -> str:
    text = ""
    if study.certificates is not None and study.solution.sweep is not None:
        from vireport.report import certify_text

        text += certify_text(study.certificates, study.solution.sweep.parameter).rstrip() + "\n"
    elif study.certificates is not None:
        text += "No critical point to prove: there is no sweep.\n"
    if study.plan.runs("github"):
        from vireport.report import github

        text += github(study)
    return text


def render(study: Study, command: str, templates: Path | None, say: Progress) -> dict[str, bytes]:
    """The files of a study by their names, in memory; only what its plan asks for is imported."""
    plan, provenance, files = study.plan, provenance_of(study.loaded, command), {}
    drawn: tuple[Picture, ...] = ()
    if any(step.runs for step in plan.steps if step.name.startswith("figure-")):
        say("drawing")
        from vireport.figures import pictures

        drawn = pictures(study, _overlay(study))
    if plan.runs("html") or plan.runs("pdf"):
        say("setting the report")
        from vireport.report import (
            build_report,
            render_html,
            render_pdf,
        )

        model = build_report(study, drawn, provenance)
        if plan.runs("html"):
            files["report.html"] = render_html(model, templates)
        if plan.runs("pdf"):
            files["report.pdf"] = render_pdf(model, templates)
    if plan.runs("png"):
        files |= {f"{picture.name}.png": picture.png for picture in drawn}
    if plan.runs("json") or plan.runs("csv"):
        from vireport.study import (
            branches_csv,
            results_json,
        )

        if plan.runs("json"):
            files["results.json"] = results_json(study, provenance)
        if plan.runs("csv"):
            files["branches.csv"] = branches_csv(study)
    if plan.runs("junit") or plan.runs("markdown"):
        from vireport.report import (
            junit,
            markdown,
        )

        if plan.runs("junit"):
            files["junit.xml"] = junit(study)
        if plan.runs("markdown"):
            files["summary.md"] = markdown(study, provenance).encode()
    return files


def _overlay(study: Study) -> Simulated | None:
    if study.crosscheck is None:
        return None
    from vireport.figures import simulated_points

    return simulated_points(study)
