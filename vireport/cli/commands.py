"""The commands beside `run`, registered where one is asked for: accuracy, compare, diff, explain, extremes, sweep."""

from __future__ import annotations

import json as plain_json
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Annotated

import typer

from vireport.cli.options import (
    Formats,
    Json,
    Overrides,
    Quiet,
    ScenarioFile,
    Templates,
    command_of,
    emit,
    formats_of,
    load,
    show,
)
from vireport.errors import UsageError


@cache
def register(app: typer.Typer) -> None:
    """Add the commands to the command line."""
    for command in (accuracy, compare, diff, explain, extremes, sweep):
        app.command()(command)


def accuracy(
    scenario: ScenarioFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Write the figures and accuracy.json here too.")
    ] = None,
    json: Json = False,
    every: Annotated[bool, typer.Option("--all", help="A row for every run, not only the best.")] = False,
    set_: Overrides = None,
    quiet: Quiet = False,
) -> None:
    """Measure error against run time of every method, and the compliant membrane beside the rigid one."""
    from vireport.cli import accuracy_outputs

    study = accuracy_outputs.measured(load(scenario, set_), _steps(quiet))
    if json:
        emit(accuracy_outputs.data(study))
    else:
        emit(accuracy_outputs.text(study, every).encode())
    if output is not None:
        said = accuracy_outputs.write(study, output)
        if not quiet:
            print(said, file=sys.stderr)


def extremes(
    scenario: Annotated[
        str | None, typer.Argument(metavar="[SCENARIO]", help="Whose device is taken to extremes; else the paper's.")
    ] = None,
    json: Json = False,
    set_: Overrides = None,
    quiet: Quiet = False,
) -> None:
    """Run the catalogue of extreme cases against 40-digit arithmetic; exit code 1 if one fails."""
    from vireport.extremes import (
        run_catalogue,
        table_data,
        table_text,
    )

    if scenario is None and set_:
        raise UsageError("--set needs a scenario to set it over")
    loaded = load(scenario, set_) if scenario is not None else None
    progress = _steps(quiet)
    outcomes = run_catalogue(loaded, progress)
    if progress is not None:
        progress("")
    text = plain_json.dumps(table_data(outcomes), allow_nan=False) + "\n" if json else table_text(outcomes)
    emit(text.encode())
    if any(outcome.verdict == "failed" for outcome in outcomes):
        raise typer.Exit(1)


def explain(
    code: Annotated[str | None, typer.Argument(metavar="[CODE]", help="Of an alert, such as VR010; else all.")] = None,
) -> None:
    """Say what an alert means, what causes it, and what to do."""
    from vireport.gate import explanation

    emit(explanation(code).encode())


def compare(
    scenarios: Annotated[list[str], typer.Argument(metavar="SCENARIO...", help="Two or more, or one with --vary.")],
    vary: Annotated[
        list[str] | None,
        typer.Option("--vary", metavar="PATH=A,B,...", help="Values of a key; several of them make a grid."),
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="DIR", help="Where to write.")] = None,
    json: Json = False,
    set_: Overrides = None,
    format_: Formats = None,
    templates: Templates = None,
    quiet: Quiet = False,
) -> None:
    """Compare scenarios, or variants of one: figures on shared axes, and what differs, most changed first."""
    if json and (output is not None or format_):
        raise UsageError("--json prints the comparison and writes no file: leave out --output and --format")
    from vireport.comparison import compare as compared
    from vireport.comparison import outputs as compare_outputs

    options = (("--vary", vary), ("--json", json), ("--set", set_), ("--format", format_))
    command = command_of("compare", scenarios, *options)
    progress = _steps(quiet)
    result = compared(scenarios, vary or None, overrides=set_ or (), progress=progress)
    if json:
        from vireport.comparison import comparison_provenance

        emit(compare_outputs.compare_json(result, comparison_provenance(result, command)))
        return
    folder = output or Path(compare_outputs.FOLDER)
    summary = compare_outputs.write_comparison(result, folder, formats_of(format_), command, templates, progress)
    if not quiet:
        print(summary, file=sys.stderr)


def diff(
    baseline: Annotated[str, typer.Argument(metavar="RESULTS.json", help="The results.json of an earlier run.")],
    scenario: ScenarioFile,
    tolerance: Annotated[
        float, typer.Option(metavar="SHARE", min=0.0, help="Relative change up to which nothing has changed.")
    ] = 1e-6,
    markdown: Annotated[bool, typer.Option("--markdown", help="As a table for a pull request.")] = False,
    json: Json = False,
    set_: Overrides = None,
) -> None:
    """Say what has changed since earlier results, beyond the tolerance; exit code 1 if anything has."""
    from vireport.comparison import baseline as earlier
    from vireport.study import analyse

    before = earlier.read_baseline(baseline)
    changes = earlier.diff(before, analyse(load(scenario, set_), ("json",)), relative=tolerance)
    name = Path(baseline).name
    if json:
        emit(earlier.diff_json(changes, tolerance))
    else:
        text = earlier.diff_markdown(changes, name) if markdown else earlier.diff_text(changes, name)
        emit((text.rstrip("\n") + "\n").encode())
    if changes:
        raise typer.Exit(1)


def sweep(
    map_file: Annotated[str, typer.Argument(metavar="MAP", help="A YAML file with a map block.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="DIR", help="Where to write.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help="A Dask scheduler whose workers compute.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Processes on this machine; by default one a core.")
    ] = None,
    figures: Annotated[bool, typer.Option(help="Whether to draw heat maps.")] = True,
    quiet: Quiet = False,
) -> None:
    """Compute a map over two or more parameters; begun anew, it resumes where it was interrupted."""
    # One process works on each core: threads of the linear algebra would be in their way. Before numpy is imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from vireport.cli.outputs import default_folder
    from vireport.sweep import (
        run_map,
        terminal_progress,
    )

    folder = output or default_folder(map_file)
    progress = None if quiet or not sys.stderr.isatty() else terminal_progress()
    summary = run_map(map_file, folder, scheduler, workers, progress, figures)
    if not quiet:
        print(summary, file=sys.stderr)


def _steps(quiet: bool) -> Callable[[str], None] | None:
    """What is told each step, where somebody sees it."""
    return None if quiet or not sys.stderr.isatty() else show
