"""The commands: each reads its options, makes one call, and delivers what comes of it.

Each imports the rooms that it uses, and no other: `vireport --help` needs none of them.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vireport.base import interrupts
from vireport.base.encoding import json_text
from vireport.base.errors import ScenarioError, UsageError
from vireport.base.files import require_writable, writable, write_new
from vireport.base.progress import WorkStep, portion
from vireport.base.version import __version__
from vireport.cli import options as given
from vireport.cli.formats import format_option, formats_of
from vireport.cli.group import Command, CommandPanel, Program
from vireport.cli.options import default_folder, figure_width_mm, recorded, refuse, refuse_files_beside_json
from vireport.cli.outcome import CommandOutcome, deliver, emit, progress, tell, tell_lacking
from vireport.text.alerts import explanation

if TYPE_CHECKING:
    from vireport.scenario.loading import Loaded
    from vireport.study.earlier import Earlier

CHARTED_SHARE = 0.9
"""Share of the time of exact curves that they take, as measured; their report takes the rest."""

DEFAULT_TOLERANCE = 1e-6

NEW_FILE = "scenario.yaml"

EPILOG = (
    "vireport SCENARIO is short for vireport run SCENARIO, and vireport COMMAND --help lists the options of a command. "
    "Exit codes: 0 done; 1 done, but a requirement of the scenario is not met; 2 usage, or an invalid scenario; 3 the "
    "numbers could not be computed or written, or an internal error; 130 interrupted; 143 ended by SIGTERM."
)

app = typer.Typer(
    cls=Program,
    invoke_without_command=True,
    subcommand_metavar="SCENARIO | COMMAND ...",
    epilog=EPILOG,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(shown: bool) -> None:
    if shown:
        print(f"vireport {__version__}")
        raise typer.Exit


@app.callback()
def _group(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", "-V", callback=_version, is_eager=True, help="Prints the version.")
    ] = False,
) -> None:
    """Compute the periodic motions, stability and voltage of a vibro-impact energy harvester from a YAML scenario."""
    if context.invoked_subcommand is None:
        print(context.get_help(), file=sys.stderr)
        raise typer.Exit(UsageError.exit_code)


@app.command(cls=Command, rich_help_panel=CommandPanel.ONE)
def run(
    context: typer.Context,
    scenario: given.Scenario,
    set_: given.Set = None,
    allow_outside: given.AllowOutside = False,
    full: given.Full = False,
    certify: given.Certify = False,
    baseline: given.Baseline = None,
    output: given.Folder = None,
    json: given.Json = False,
    format_: Annotated[list[str] | None, format_option("run")] = None,
    templates: given.Templates = None,
    paper: given.Paper = given.PaperSize.A4,
    figure_width: given.FigureWidth = None,
    force: given.Force = False,
    quiet: given.Quiet = False,
    verbose: given.Verbose = False,
) -> None:
    """Solve a scenario and write its report, figures and results."""
    refuse_files_beside_json(context, "results")
    if json and baseline is not None:
        raise UsageError(
            "--json prints the results and no changes: leave out --baseline, or use vireport compare OLD NEW "
            "--exit-code --json"
        )
    if baseline == scenario == "-":
        raise UsageError("standard input can be the results or the scenario, not both")
    before = None
    if baseline is not None:  # before the scenario is solved
        from vireport.comparison.baseline import read_baseline

        before = read_baseline(baseline)
    loaded, earlier = _read(scenario, set_, allow_outside)
    if full:
        from vireport.scenario.loading import with_default_blocks

        loaded = with_default_blocks(loaded)
    certify = certify or (earlier is not None and bool(earlier.results.get("certificates")))
    if certify:
        from vireport.study.plan import refuse_special, require_proofs

        refuse_special(loaded.scenario, "--certify")
        require_proofs()
    from vireport.cli.outputs import file_names, results_outcome, run_outcome

    command = recorded(context)
    if json:
        tell_lacking(loaded, ("json",), quiet)
        with progress(quiet, verbose) as say:
            outcome = results_outcome(loaded, command, certify, earlier, say)
        deliver(outcome, quiet=quiet)
        return
    folder, formats = output or default_folder(scenario), formats_of("run", format_)
    width_mm = figure_width_mm(figure_width, formats)
    require_writable(folder, file_names(formats), force)
    tell_lacking(loaded, formats, quiet)
    with progress(quiet, verbose) as say:
        outcome = run_outcome(loaded, formats, command, templates, say, certify, before, earlier, paper, width_mm)
    deliver(outcome, folder, quiet)


@app.command(cls=Command, rich_help_panel=CommandPanel.ONE)
def explore(
    scenario: given.Scenario,
    set_: given.Set = None,
    allow_outside: given.AllowOutside = False,
    port: given.Port = 0,
    browser: given.Browser = True,
    output: given.Folder = None,
) -> None:
    """Change a design by hand in a page of this machine, with margins and verdict following. Ctrl-C ends it.

    What the page saves goes to the current folder, unless -o names another.
    """
    from vireport.bench.server import serve
    from vireport.bench.session import opened

    earlier, folder = _earlier(scenario), output or Path()
    loaded = scenario if earlier is None else earlier.loaded(set_ or (), allow_outside)
    known = opened(loaded, tuple(set_ or ()), allow_outside)
    require_writable(folder)

    def begun(address: str) -> None:
        emit(f"{address}\n")
        for note in known.notes:
            tell([note])
        tell(["The page is at this address on this machine alone. Ctrl-C ends the program."])
        if browser:
            from webbrowser import open as open_page

            if not open_page(address):
                tell(["No browser could be opened: open the address by hand."])

    try:
        serve(known, folder, port, begun)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("the page keeps what is set; files that it saved are there") from None


@app.command(cls=Command, rich_help_panel=CommandPanel.SEVERAL)
def compare(
    context: typer.Context,
    scenarios: given.Scenarios,
    set_: given.Set = None,
    allow_outside: given.AllowOutside = False,
    vary: given.Vary = None,
    rank_by: given.RankBy = None,
    exit_code: given.ExitCode = False,
    tolerance: given.Tolerance = DEFAULT_TOLERANCE,
    markdown: given.Markdown = False,
    output: given.Folder = None,
    json: given.Json = False,
    format_: Annotated[list[str] | None, format_option("compare")] = None,
    templates: given.Templates = None,
    paper: given.Paper = given.PaperSize.A4,
    figure_width: given.FigureWidth = None,
    force: given.Force = False,
    quiet: given.Quiet = False,
    verbose: given.Verbose = False,
) -> None:
    """Compare scenarios, or variants of one, and tell which is best; with --exit-code, what has changed.

    An earlier run is solved again, and what is no longer the same is told; with --exit-code its results count as they
    are.
    """
    if exit_code:
        writing = ("output", "format_", "templates", "paper", "figure_width")
        refuse(context, "--exit-code prints what has changed between two", "vary", "rank_by", *writing)
        with progress(quiet, verbose) as say:
            outcome = _changes(
                scenarios, set_, allow_outside, tolerance, "json" if json else "markdown" if markdown else "", say
            )
        deliver(outcome, quiet=quiet)
        return
    refuse(context, "without --exit-code no changes are listed", "tolerance", "markdown")
    refuse_files_beside_json(context, "comparison")
    from vireport.cli.outputs import compare_outcome, file_names
    from vireport.comparison.comparison import compare as compare_scenarios
    from vireport.comparison.diff_outputs import rerun_text
    from vireport.comparison.outputs import (
        COMPARISON_FILES,
        COMPARISON_FOLDER,
        compare_json,
        comparison_provenance,
        folder_of,
    )

    command, formats = recorded(context), formats_of("compare", format_)
    width_mm = figure_width_mm(figure_width, formats)
    names = file_names(formats, COMPARISON_FILES)
    if not json:
        # Where no folder is named, another one is chosen than that of another comparison.
        require_writable(output or Path(COMPARISON_FOLDER), names, force or output is None)
    earlier = [_earlier(path) for path in scenarios]
    items = [
        path if run is None else run.loaded((), allow_outside) for path, run in zip(scenarios, earlier, strict=True)
    ]
    with progress(quiet, verbose) as say:
        comparison = compare_scenarios(items, vary or None, None, set_ or (), say, rank_by or (), allow_outside)
        if not json:
            outcome = compare_outcome(comparison, formats, command, templates, say, paper, width_mm, verbose)
    if json:
        outcome = CommandOutcome(compare_json(comparison, comparison_provenance(comparison, command)))
    if not (quiet or vary or set_):
        for before, study in zip(earlier, comparison.studies, strict=True):
            if before is not None:
                tell(rerun_text(before.results, study, before.file).splitlines())
    folder = output or folder_of(comparison, command)
    if not json:
        require_writable(folder, names, force)
    deliver(outcome, folder, quiet)


def _changes(
    files: Sequence[str], overrides: list[str] | None, allow_outside: bool, tolerance: float, form: str, say: Any
) -> CommandOutcome:
    """What has changed since an earlier run, whose results are those that it wrote."""
    if len(files) != 2:
        raise UsageError(
            f"--exit-code takes two files, got {len(files)} (allowed: OLD, the results.json or report of an earlier "
            "run, and NEW, another or a scenario)"
        )
    old, new = files
    if old == new == "-":
        raise UsageError("standard input can be the results or the scenario, not both")
    if _earlier(old) is None and Path(old).is_file() and _earlier(new) is not None:
        raise UsageError(
            f"{old} is no results.json and no report, and {new} is one: were they swapped? (vireport compare {new} "
            f"{old} --exit-code)"
        )
    from vireport.comparison.baseline import diff, read_baseline
    from vireport.comparison.diff_outputs import diff_json, diff_markdown, diff_text
    from vireport.study.plan import Task
    from vireport.study.study import analyse

    before, later = read_baseline(old), _earlier(new)
    if later is not None and not overrides:
        changes = diff(before, later.results, tolerance)
    else:
        changes = diff(before, analyse(_read(new, overrides, allow_outside)[0], (Task.JSON,), say), tolerance)
    code = 1 if changes else 0
    if form == "json":
        return CommandOutcome(diff_json(changes, tolerance), exit_code=code)
    render = diff_markdown if form else diff_text
    text = render(changes, "standard input" if old == "-" else Path(old).name)
    return CommandOutcome(text=text.rstrip("\n") + "\n", exit_code=code)


@app.command("map", cls=Command, rich_help_panel=CommandPanel.SEVERAL)
def map_(
    context: typer.Context,
    file: given.ScenarioOrMap,
    over: given.Over = None,
    set_: given.Set = None,
    scheduler: given.Scheduler = None,
    workers: given.Workers = None,
    output: given.Folder = None,
    json: given.Json = False,
    format_: Annotated[list[str] | None, format_option("map")] = None,
    figures: given.Figures = True,
    templates: given.Templates = None,
    paper: given.Paper = given.PaperSize.A4,
    figure_width: given.FigureWidth = None,
    force: given.Force = False,
    quiet: given.Quiet = False,
    verbose: given.Verbose = False,
) -> None:
    """Map what is stable over two or more inputs: cells of a map block, or with --over the exact boundaries.

    Cells go to files as they are computed; an interrupted run is resumed where it stopped.
    """
    command, formats = recorded(context), formats_of("map" if over is None else "map --over", format_)
    if over is None:
        refuse(context, "cells are of the map file as it is, and go to files (--over draws curves)", "json", "set_")
        if not figures:
            refuse(context, "--no-figures writes the cells alone", "format_", "figure_width")
        from vireport.maps.outputs import MapOutput

        asked = MapOutput(formats, command, templates, paper, figure_width_mm(figure_width, formats))
        _cells(file, output or default_folder(file), scheduler, workers, figures, asked, force, quiet, verbose)
        return
    refuse(context, "--over draws curves, and computes no cells", "scheduler", "workers", "figures")
    refuse_files_beside_json(context, "chart")
    loaded, _ = _read(file, set_)
    from vireport.chart import outputs as charts
    from vireport.chart.over import chart_of
    from vireport.cli.outputs import file_names
    from vireport.study.provenance import provenance_of

    width_mm, names = figure_width_mm(figure_width, formats), file_names(formats, charts.CHART_FILES)
    folder = output or default_folder(file, "-chart")
    if not json:
        require_writable(folder, names, force)
    with progress(quiet, verbose) as say:
        result = chart_of(loaded, over, portion(say, 0.0, 1.0 if json else CHARTED_SHARE))
        if not json:
            say(WorkStep("setting the report", CHARTED_SHARE))
            files = charts.files(result, loaded, formats, command, templates, paper, width_mm)
    if json:
        deliver(CommandOutcome(charts.chart_json(result, provenance_of(loaded, command))))
        return
    beside = file_names([task for task in charts.CHART_FILES if task not in formats], charts.CHART_FILES)
    outcome = CommandOutcome(text=charts.text(result, templates), files=files, stale=names, beside=beside)
    deliver(outcome, folder, quiet)


def _cells(
    file: str, folder: Path, scheduler: str | None, workers: int | None, figures: bool, asked: Any, force: bool,
    quiet: bool, verbose: bool,
) -> None:  # fmt: skip
    """Compute a map file, or what is missing of it."""
    from vireport.cli.outputs import file_names
    from vireport.maps.outputs import MAP_FILES
    from vireport.maps.run import run_map

    require_writable(folder, file_names(asked.formats, MAP_FILES) if figures else (), force)
    try:
        with progress(quiet, verbose) as say:

            def show(done: int, total: int) -> None:
                say(WorkStep("computing cells", done / total, f"{done:,} of {total:,}"))

            summary = run_map(file, folder, scheduler, workers, show, figures, asked)
        interrupts.check()
    except KeyboardInterrupt:
        raise KeyboardInterrupt("what is computed so far is kept: run the same command again to go on") from None
    deliver(CommandOutcome(summary=summary), quiet=quiet)


@app.command(cls=Command, rich_help_panel=CommandPanel.SEVERAL)
def optimise(
    context: typer.Context,
    scenario: given.Scenario,
    set_: given.Set = None,
    output: given.Folder = None,
    json: given.Json = False,
    format_: Annotated[list[str] | None, format_option("optimise")] = None,
    templates: given.Templates = None,
    paper: given.Paper = given.PaperSize.A4,
    figure_width: given.FigureWidth = None,
    force: given.Force = False,
    quiet: given.Quiet = False,
    verbose: given.Verbose = False,
) -> None:
    """Find the best design that meets the requirements. The scenario's design block says what may vary.

    The exit code is 1 if no design meets the requirements.
    """
    refuse_files_beside_json(context, "result")
    loaded, _ = _read(scenario, set_)
    from vireport.cli.outputs import file_names, run_files
    from vireport.optimise import outputs
    from vireport.optimise.problem import problem_of
    from vireport.optimise.search import optimise as search
    from vireport.study.provenance import provenance_of

    problem, command, formats = problem_of(loaded), recorded(context), formats_of("optimise", format_)
    width_mm, provenance = figure_width_mm(figure_width, formats), provenance_of(loaded, command)
    stale = (*outputs.DATA, *file_names(formats, outputs.OPTIMISE_FILES))
    folder = output or default_folder(scenario, "-best")
    if not json:
        require_writable(folder, stale, force)
    tell_lacking(loaded, formats, quiet)
    with progress(quiet, verbose) as say:
        result = search(problem, say)
        pages = [task for task in outputs.PAGES if task in formats and result.best is not None and not json]
        say("solving the best design")
        study = outputs.run_of(result, pages, say)
        files = {} if json else outputs.files(result, study, provenance, formats, width_mm)
        if study is not None and pages:
            found = outputs.sentence(result, study)
            files |= run_files(study, command, templates, say, None, paper, *outputs.section(result), sentence=found)
    failure = outputs.shortcoming(result)
    beside = file_names([task for task in outputs.OPTIMISE_FILES if task not in formats], outputs.OPTIMISE_FILES)
    outcome = CommandOutcome(
        outputs.optimise_json(result, study, provenance) if json else "",
        "" if json else outputs.text(result, study),
        files,
        failure=failure,
        exit_code=bool(failure),
        stale=stale,
        beside=beside,
    )
    deliver(outcome, folder, quiet)


@app.command(cls=Command, rich_help_panel=CommandPanel.MEASURED)
def identify(
    context: typer.Context,
    scenario: given.Scenario,
    impacts: given.Impacts = None,
    record: given.Record = None,
    clock: given.Clock = None,
    free: given.Free = None,
    set_: given.Set = None,
    output: given.Folder = None,
    json: given.Json = False,
    force: given.Force = False,
    quiet: given.Quiet = False,
    verbose: given.Verbose = False,
) -> None:
    """Identify restitutions and other inputs from measured impacts or raw signals, and test whether the model fits.

    The exit code is 1 if the impacts contradict the model, and 3 if they do not determine what is asked for.
    """
    refuse_files_beside_json(context, "result")
    loaded, _ = _read(scenario, set_)
    from vireport.cli import identify_outputs

    if (impacts is None) == (record is None):
        raise UsageError("either --impacts or --record is needed (allowed: one of them)")
    command, folder = recorded(context), output or default_folder(scenario, "-identified")
    if not json:
        names: tuple[str, ...] = identify_outputs.NAMES
        if impacts is not None and Path(impacts).resolve() == (folder / identify_outputs.RECORD).resolve():
            names = tuple(name for name in names if name != identify_outputs.RECORD)  # it is written as it is
        require_writable(folder, names, force)
    with progress(quiet, verbose) as say:
        outcome = identify_outputs.outcome(loaded, impacts, record, clock is not None, free or [], command, json, say)
    deliver(outcome, folder, quiet)


@app.command(cls=Command, rich_help_panel=CommandPanel.MEASURED)
def verify(
    context: typer.Context,
    scenario: given.ScenarioIfAny = None,
    extremes: given.Extremes = False,
    every: given.EveryRun = False,
    set_: given.Set = None,
    allow_outside: given.AllowOutside = False,
    output: given.Folder = None,
    json: given.Json = False,
    figure_width: given.FigureWidth = None,
    force: given.Force = False,
    quiet: given.Quiet = False,
    verbose: given.Verbose = False,
) -> None:
    """Measure the error of every method against its run time, and compare compliant with rigid membranes.

    Files, the figures and accuracy.json, are written with -o only.
    """
    from vireport.study.plan import Task, refuse_special, require_reference

    if scenario is None and not extremes:
        raise UsageError("Missing argument 'SCENARIO' (only --extremes has a device of its own)")
    if scenario is None and set_:
        raise UsageError("--set needs a scenario to set it over")
    loaded = None if scenario is None else _read(scenario, set_, allow_outside)[0]
    if loaded is not None:
        refuse_special(loaded.scenario, f"vireport verify{' --extremes' * extremes}")
    require_reference()
    if extremes or loaded is None:
        refuse(context, "--extremes prints the cases", "output", "figure_width", "every")
        from vireport.extremes.catalogue import exit_status, run_catalogue, table_data, table_text

        with progress(quiet, verbose) as say:
            outcomes = run_catalogue(loaded, say)
        code, failure = exit_status(outcomes)
        data = f"{json_text(table_data(outcomes))}\n" if json else ""
        deliver(
            CommandOutcome(data, "" if json else table_text(outcomes), failure=failure, exit_code=code), quiet=quiet
        )
        return
    if output is None:
        refuse(context, "figures are written to a folder, give --output", "figure_width")
    from vireport.cli import accuracy_outputs

    if output is not None:
        require_writable(output, accuracy_outputs.NAMES, force)
    width_mm = figure_width_mm(figure_width, (Task.PNG,))
    loaded = accuracy_outputs.asked(loaded)
    tell_lacking(loaded, accuracy_outputs.FORMATS, quiet)
    with progress(quiet, verbose) as say:
        study = accuracy_outputs.measured(loaded, say)
        files = accuracy_outputs.files(study, recorded(context), width_mm) if output is not None else {}
    printed, text = (
        (accuracy_outputs.data(study, recorded(context)), "") if json else ("", accuracy_outputs.text(study, every))
    )
    deliver(CommandOutcome(printed, text, files, stale=accuracy_outputs.NAMES), output, quiet)


@app.command(cls=Command, rich_help_panel=CommandPanel.HELP)
def check(
    scenario: given.Scenario,
    set_: given.Set = None,
    allow_outside: given.AllowOutside = False,
    json: given.Json = False,
    format_: Annotated[list[str] | None, format_option("check")] = None,
    quiet: given.Quiet = False,
) -> None:
    """Check a scenario or a map file: every mistake in it, or what a run would compute and what to add for more.

    Computes nothing.
    """
    from vireport.scenario.loading import LoadedMap, load_any

    formats, earlier = formats_of("check", format_), _earlier(scenario)
    try:
        loaded = (
            load_any(scenario, set_ or (), allow_outside)
            if earlier is None
            else earlier.loaded(set_ or (), allow_outside)
        )
        if not isinstance(loaded, LoadedMap) and loaded.scenario.measured:
            from vireport.study.measured import require_records

            require_records(loaded)
    except ScenarioError as error:
        if not json:
            raise
        refused = {"valid": False, "kind": None, "mistakes": error.to_dicts(), "more": error.more, "steps": []}
        deliver(CommandOutcome(_json(refused), exit_code=error.exit_code))
        return
    from vireport.gate.alerts import input_alerts

    alerts = input_alerts(loaded.scenario)
    if isinstance(loaded, LoadedMap):
        name, kind = loaded.name, "map"
        over = " x ".join(axis.path for axis in loaded.block.axes)
        rows = [("cells", True, f"{loaded.block.cells:,} cells over {over}", "the file has a map block")]
        left_out: tuple[str, ...] = ()
    else:
        from vireport.study.plan import plan

        name, kind = loaded.document.name, "scenario"
        planned = plan(loaded.scenario, formats)
        rows = [(step.task, step.runs, step.what, step.why) for step in planned.steps]
        left_out = () if json else planned.left_out_lines()
    if json:
        steps = [dict(zip(("step", "runs", "what", "why"), row, strict=True)) for row in rows]
        told = [alert.to_dict() for alert in alerts]
        deliver(CommandOutcome(_json({"valid": True, "kind": kind, "mistakes": [], "alerts": told, "steps": steps})))
        return
    width = max(len(step) for step, runs, *_ in rows if runs)
    lines = [f"{name}: valid {kind}", *(alert.text for alert in alerts)]
    lines += [f"run  {step:<{width}}  {what} ({why})" for step, runs, what, why in rows if runs]
    deliver(CommandOutcome(text="\n".join([*lines, *left_out, ""])), quiet=quiet)


@app.command(cls=Command, rich_help_panel=CommandPanel.HELP)
def init(context: typer.Context, path: given.NewFile = NEW_FILE, schema: given.Schema = False) -> None:
    """Write a commented scenario to start from. An existing file is not overwritten."""
    if schema:
        if path != NEW_FILE:
            raise UsageError(f"--schema prints the schema: leave out {path}")
        from vireport.scenario.json_schema import schema as schema_of_scenarios

        deliver(CommandOutcome(json_text(schema_of_scenarios(), indent=2, ascii_only=False) + "\n"))
        return
    from vireport.scenario.json_schema import init_text

    if path == "-":
        deliver(CommandOutcome(init_text()))
        return
    with writable(Path(path)):
        try:
            write_new(Path(path), init_text().encode())
        except FileExistsError as error:
            raise UsageError(f"{path} exists already; name another file, or - to print the scenario") from error
    deliver(CommandOutcome(summary=f"wrote {path}; next: vireport {path}"))


@app.command(cls=Command, rich_help_panel=CommandPanel.HELP)
def explain(code: given.AlertOrTerm = None) -> None:
    """Explain an alert, its causes and its remedies, or a term."""
    deliver(CommandOutcome(explanation(code)))


def _json(data: dict[str, Any]) -> str:
    return json_text(data, indent=2) + "\n"


def _earlier(path: str) -> "Earlier | None":
    """The earlier run whose results.json or report a path is; None where it is that of a scenario."""
    if Path(path).suffix.lower() not in (".json", ".html", ".pdf"):
        return None  # what reads it need not be imported
    from vireport.study.earlier import earlier_run

    earlier = earlier_run(path)
    if earlier is not None:
        from vireport.comparison.baseline import require_comparable

        require_comparable(earlier.results, earlier.file)
    return earlier


def _read(
    scenario: str, overrides: Sequence[str] | None, allow_outside: bool = False
) -> "tuple[Loaded, Earlier | None]":
    """The scenario of a file, and the earlier run that the file is of, if it is of one."""
    earlier = _earlier(scenario)
    if earlier is not None:
        return earlier.loaded(overrides or (), allow_outside), earlier
    from vireport.scenario.loading import load

    return load(scenario, overrides or (), allow_outside), None
