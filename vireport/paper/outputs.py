"""The files of `vireport paper`: report, figures and paper.json."""

from __future__ import annotations

from pathlib import Path

from vireport.base.progress import Progress
from vireport.base.records import plain
from vireport.cli.outcome import CommandOutcome
from vireport.cli.outputs import PageSettings, file_names
from vireport.paper.opening import paper_opening
from vireport.paper.reproduction import ReproducedPaper, reproduce_paper
from vireport.paper.results import paper_data
from vireport.study.plan import FIGURE_FORMATS, Task, page_and_figure_files
from vireport.study.provenance import Provenance, provenance_of_several, with_pages
from vireport.study.results import json_bytes
from vireport.text.tables import plain_text

PAPER_FOLDER = Path("paper")
"""Folder within the current one that the report is written to by default."""

PAPER_FILES = {
    **page_and_figure_files([f"figure-{number}" for number in (2, 3, 4, 6, 7)]),
    Task.JSON: ("paper.json",),
}
"""Files that may be written, by their formats."""


def paper_provenance(paper: ReproducedPaper, command: str) -> Provenance:
    """Record where the numbers come from: the paper's scenarios, each by its name."""
    return provenance_of_several([study.loaded for study in paper.studies], command, len(paper.studies))


def paper_json(paper: ReproducedPaper, command: str) -> bytes:
    """The contents of paper.json."""
    return json_bytes(plain(paper_data(paper)), paper_provenance(paper, command))


def paper_outcome(
    paper: ReproducedPaper, pages: PageSettings, command: str, say: Progress, whole: bool = False
) -> CommandOutcome:
    """The files of a reproduction, and what it comes to; the `whole` opening where that is asked for."""
    formats, provenance, files = set(pages.formats), paper_provenance(paper, command), dict[str, bytes]()
    if formats & {Task.HTML, Task.PDF, *FIGURE_FORMATS}:
        say("drawing")
        from vireport.figures.style import Sheet, drawn_for
        from vireport.paper.figures import paper_pictures

        with drawn_for(Sheet.of(pages.width_mm)):
            drawn = {picture.name: picture for picture in paper_pictures(paper, pages.templates)}
        say("setting the report")
        from vireport.paper.page import PaperReport
        from vireport.report.rendering import render_files

        report = PaperReport(paper, drawn, with_pages(provenance, drawn=True), pages.templates)
        files |= render_files(report, formats, pages.paper)
    if Task.JSON in formats:
        files["paper.json"] = paper_json(paper, command)
    opening = paper_opening(paper).worded(pages.templates)
    stale = file_names(pages.formats, PAPER_FILES)
    others = file_names([task for task in PAPER_FILES if task not in pages.formats], PAPER_FILES)
    summary = "\n".join(opening.text if whole else opening.lines)
    return CommandOutcome(files=files, stale=stale, other_files=others, summary=summary)


def validation_outcome(templates: Path | None, say: Progress) -> CommandOutcome:
    """What the paper and others have published beside what is computed here, as a table; misprints do not count."""
    from vireport.paper.validation import paper_rows, validate, validation_table

    others = validate(say)
    table = validation_table([*paper_rows(reproduce_paper((), say)), *others], templates)
    differing = [f"{row.source.name}, {row.what}" for row in others if not row.agrees]
    failure = f"not as published: {'; '.join(differing)}" if differing else ""
    return CommandOutcome(plain_text([table]) + "\n", failure=failure, exit_code=3 if differing else 0)
