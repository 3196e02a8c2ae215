"""The command `vireport compare`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.base.files import require_writable
from vireport.base.progress import Progress
from vireport.cli import options
from vireport.cli.declared import CommandPanel, DeclaredCommand, formats_of
from vireport.cli.formats import FIGURES, PAGES, CommandFormats, format_option
from vireport.cli.inputs import read_earlier_run, read_scenario
from vireport.cli.options import figure_width_mm, recorded, refuse, refuse_files_beside_json
from vireport.cli.outcome import CommandOutcome, deliver, progress, tell

if TYPE_CHECKING:
    from vireport.report.changes.table import ComparisonRow

COMPARE = CommandFormats("compare", (*PAGES, *FIGURES, "json", "csv", "markdown"), (*PAGES, "png", "json", "csv"))

DEFAULT_TOLERANCE = 1e-6


def compare(
    context: typer.Context,
    scenarios: options.Scenarios,
    set_: options.Set = None,
    allow_outside: options.AllowOutside = False,
    vary: options.Vary = None,
    rank_by: options.RankBy = None,
    exit_code: options.ExitCode = False,
    tolerance: options.Tolerance = DEFAULT_TOLERANCE,
    markdown: options.Markdown = False,
    output: options.Folder = None,
    json: options.Json = False,
    format_: Annotated[list[str] | None, format_option(COMPARE)] = None,
    templates: options.Templates = None,
    paper: options.Paper = options.PaperSize.A4,
    figure_width: options.FigureWidth = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Compare scenarios, or variants of one, and say which is best; with --exit-code, what has changed.

    An earlier run is solved again, and what has changed is reported; with --exit-code its results count as they
    are.
    """
    if exit_code:
        writing = ("output", "format_", "paper", "figure_width")
        refuse(context, "--exit-code prints what has changed between two", "vary", "rank_by", *writing)
        with progress(quiet, verbose) as say:
            changes = _changes(scenarios, set_, allow_outside, tolerance, say)
        from vireport.report.changes.diff_outputs import diff_json, diff_markdown, diff_text

        if json:
            outcome = CommandOutcome(diff_json(changes, tolerance))
        else:
            old, text_of = scenarios[0], diff_markdown if markdown else diff_text
            text = text_of(changes, "standard input" if old == "-" else Path(old).name, templates)
            outcome = CommandOutcome(text=text.rstrip("\n") + "\n")
        deliver(replace(outcome, exit_code=int(bool(changes))), quiet=quiet)
        return
    refuse(context, "without --exit-code no changes are listed", "tolerance", "markdown")
    refuse_files_beside_json(context, "comparison")
    from vireport.cli.outputs import PageSettings, file_names
    from vireport.comparison.comparison import compare as compare_scenarios
    from vireport.comparison.outputs import (
        COMPARISON_FILES,
        COMPARISON_FOLDER,
        compare_json,
        compare_outcome,
        comparison_provenance,
        folder_of,
        render_comparison,
    )
    from vireport.report.changes.diff_outputs import rerun_text

    command, formats = recorded(context), formats_of(COMPARE, format_)
    pages = PageSettings(formats, templates, paper, figure_width_mm(figure_width, formats))
    names = file_names(formats, COMPARISON_FILES)
    if not json:
        # Where no folder is named, another one is chosen than that of another comparison.
        require_writable(output or Path(COMPARISON_FOLDER), names, force or output is None)
    earlier = [read_earlier_run(path) for path in scenarios]
    items = [
        path if run is None else run.loaded((), allow_outside) for path, run in zip(scenarios, earlier, strict=True)
    ]
    with progress(quiet, verbose) as say:
        comparison = compare_scenarios(items, vary or None, None, set_ or (), say, rank_by or (), allow_outside)
        if not json:
            files = render_comparison(comparison, command, pages, say)
            outcome = compare_outcome(comparison, files, pages, verbose)
    if json:
        outcome = CommandOutcome(compare_json(comparison, comparison_provenance(comparison, command), templates))
    if not (quiet or vary or set_):
        for before, study in zip(earlier, comparison.studies, strict=True):
            if before is not None:
                tell(rerun_text(before.results, study, before.file, templates).splitlines())
    folder = output or folder_of(comparison, command)
    if not json:
        require_writable(folder, names, force)
    deliver(outcome, folder, quiet)


def _changes(
    files: Sequence[str], overrides: list[str] | None, allow_outside: bool, tolerance: float, say: Progress
) -> "tuple[ComparisonRow, ...]":
    """What has changed since an earlier run, whose results are those that it wrote."""
    if len(files) != 2:
        raise UsageError(
            f"--exit-code takes two files, got {len(files)} (allowed: OLD, the results.json or report of an earlier "
            "run, and NEW, another or a scenario)"
        )
    old, new = files
    if old == new == "-":
        raise UsageError("standard input can be the results or the scenario, not both")
    if read_earlier_run(old) is None and Path(old).is_file() and read_earlier_run(new) is not None:
        raise UsageError(
            f"{old} is no results.json and no report, and {new} is one: were they swapped? (vireport compare {new} "
            f"{old} --exit-code)"
        )
    from vireport.report.changes.baseline import diff, read_baseline
    from vireport.study.plan import Task
    from vireport.study.study import analyse

    before, later = read_baseline(old), read_earlier_run(new)
    if later is not None and not overrides:
        return diff(before, later.results, tolerance)
    return diff(before, analyse(read_scenario(new, overrides, allow_outside)[0], (Task.JSON,), say), tolerance)


COMMAND = DeclaredCommand("compare", compare, CommandPanel.SEVERAL, (COMPARE,))
