"""The files of a comparison: report, figures, compare.json and compare.csv."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.cli.outcome import CommandOutcome
from vireport.cli.outputs import PageSettings, file_names
from vireport.comparison.comparison import COMPARED_FIGURES, FEW_NAMES, OVERLAY, Comparison
from vireport.comparison.ranking import ranking_table, remarks
from vireport.comparison.variants import MOST_SCENARIOS
from vireport.study.plan import FIGURE_FORMATS, Task, page_and_figure_files
from vireport.study.provenance import Provenance, provenance_of_several, with_pages
from vireport.study.results import csv_bytes, json_bytes
from vireport.text.said import Said
from vireport.text.tables import plain_text

if TYPE_CHECKING:
    from vireport.base.progress import Progress

COMPARISON_FOLDER = "comparison"
"""Folder within the current one that a comparison is written to by default."""

_PAGES = ("", *(f"-{number}" for number in range(2, MOST_SCENARIOS + 1)))
_FIGURES = [f"{name}{page}" for name in COMPARED_FIGURES for page in _PAGES]
_FIGURES.append(OVERLAY)

COMPARISON_FILES = {
    **page_and_figure_files(_FIGURES),
    Task.JSON: ("compare.json",),
    Task.CSV: ("compare.csv",),
    Task.MARKDOWN: ("summary.md",),
}
"""Files that a comparison may write, by their formats."""


def folder_of(comparison: Comparison, command: str) -> Path:
    """Choose where a comparison goes by default: where the same one is already, or else where there is nothing yet.

    That is `COMPARISON_FOLDER`, with a number where others have been.
    """
    digest = comparison_provenance(comparison, command).scenario_sha256
    folder, number = Path(COMPARISON_FOLDER), 1
    while folder.exists() and _compared_in(folder) != digest:
        number += 1
        folder = Path(f"{COMPARISON_FOLDER}-{number}")
    return folder


def _compared_in(folder: Path) -> str | None:
    """Read the SHA-256 of the scenarios that were compared in a folder; None where that cannot be known."""
    try:
        with open(folder / "compare.json", "rb") as file:
            digest = json.load(file)["provenance"]["scenario_sha256"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return str(digest)


def terminal_summary(comparison: Comparison, tables: bool = False, templates: Path | None = None) -> str:
    """Tell which scenario is best and why; with `tables` also the ranking, and each difference in a line."""
    lines = comparison.opening.worded(templates).lines
    if not tables:
        return "\n".join(lines)
    different, count = len(comparison.differences), len(comparison.quantities)
    counted = Said("count", (different, count), "compare").words(templates)
    sentences = [f"{counted}{':' if different else '.'}", *(row.worded(templates) for row in comparison.differences)]
    remarked = " ".join(remark.words(templates) for remark in remarks(comparison.ranking))
    ranking = plain_text((ranking_table(comparison.ranking, templates), remarked))
    return "\n".join([*lines, "", ranking.rstrip("\n"), "", *sentences])


def render_comparison(comparison: Comparison, command: str, pages: PageSettings, say: Progress) -> dict[str, bytes]:
    """Make the files of a comparison by their names, in memory; only what they need is imported."""
    formats, templates = set(pages.formats), pages.templates
    provenance, files = comparison_provenance(comparison, command), dict[str, bytes]()
    if formats & {Task.HTML, Task.PDF, *FIGURE_FORMATS}:
        say("drawing")
        from vireport.comparison.figures import compare_pictures
        from vireport.figures.style import Sheet, drawn_for

        with drawn_for(Sheet.of(pages.width_mm)):
            drawn = compare_pictures(comparison, templates)
        say("setting the report")
        from vireport.comparison.pages import ComparisonReport
        from vireport.report.rendering import render_files

        origin = with_pages(provenance, drawn=bool(drawn)) if formats & {"html", "pdf"} else provenance
        report = ComparisonReport(comparison, {picture.name: picture for picture in drawn}, origin, templates)
        files |= render_files(report, formats, pages.paper)
    if "json" in formats:
        files["compare.json"] = compare_json(comparison, provenance, templates)
    if "csv" in formats:
        files["compare.csv"] = compare_csv(comparison)
    if "markdown" in formats:
        from vireport.comparison.pages import ComparisonReport
        from vireport.report.rendering import render_markdown

        report = ComparisonReport(comparison, {}, provenance, templates, "comparison-summary.md.j2")
        files["summary.md"] = render_markdown(report)
    return files


def comparison_provenance(comparison: Comparison, command: str) -> Provenance:
    """Record where a comparison comes from, made by a `command` as given, without folders."""
    return provenance_of_several([study.loaded for study in comparison.studies], command, FEW_NAMES)


def compare_json(comparison: Comparison, provenance: Provenance, templates: Path | None = None) -> bytes:
    """Write the comparison as JSON, one top-level key a line, its sentences in the words of a folder of templates."""
    return json_bytes(comparison.to_dict(templates), provenance)


def compare_csv(comparison: Comparison) -> bytes:
    """Write a row for each scenario, with a column for each quantity; what there is not is empty."""
    rows = comparison.rows()
    head = list(dict.fromkeys(name for row in rows for name in row))
    return csv_bytes(head, ([row.get(name) for name in head] for row in rows))


def compare_outcome(
    comparison: Comparison, files: dict[str, bytes], pages: PageSettings, tables: bool = False
) -> CommandOutcome:
    """The files of a comparison, and which scenario is best; with `tables`, the numbers on the terminal too."""
    stale, summary = file_names(pages.formats, COMPARISON_FILES), terminal_summary(comparison, tables, pages.templates)
    other_files = file_names([task for task in COMPARISON_FILES if task not in pages.formats], COMPARISON_FILES)
    return CommandOutcome(files=files, stale=stale, other_files=other_files, summary=summary)
