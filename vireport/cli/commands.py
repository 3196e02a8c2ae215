"""The commands: each reads its options, makes one call, and delivers what comes of it.

Each imports the rooms that it uses, and no other: `vireport --help` needs none of them.
"""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from vireport.base.additions import ADDITIONS, adding
from vireport.base.encoding import json_text
from vireport.base.errors import ScenarioError, UsageError
from vireport.base.files import require_writable, writable, write_new
from vireport.base.version import __version__
from vireport.cli import options
from vireport.cli.declared import Command, CommandPanel, DeclaredCommand, declared_command, formats_of
from vireport.cli.formats import RUN, CommandFormats, format_option
from vireport.cli.group import Program
from vireport.cli.inputs import read_earlier_run, read_scenario
from vireport.cli.options import default_folder, figure_width_mm, recorded, refuse_files_beside_json
from vireport.cli.outcome import CommandOutcome, deliver, progress, tell_lacking
from vireport.text.alerts import explanation

_AnyFunction = TypeVar("_AnyFunction", bound=Callable[..., None])

CHECK = CommandFormats("check", RUN.allowed, RUN.usual)

NEW_FILE = "scenario.yaml"

CERTIFICATES = "certificates"
"""The addition that `--certify` asks for."""

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


BUILDERS: dict[str, Callable[[], typer.Typer]] = {}
"""What makes each command, by their names: a run imports and makes its own alone."""


def _command(panel: CommandPanel) -> Callable[[_AnyFunction], _AnyFunction]:
    """Make a function the command that has its name."""

    def declared(function: _AnyFunction) -> _AnyFunction:
        name = function.__name__
        BUILDERS[name] = lambda: _made(DeclaredCommand(name, function, panel))
        return function

    return declared


def _made(command: DeclaredCommand) -> typer.Typer:
    builder = typer.Typer(add_completion=False, rich_markup_mode=None)
    builder.command(command.name, cls=Command, rich_help_panel=command.panel)(command.function)
    return builder


def _added(name: str) -> typer.Typer:
    return _made(declared_command(name))


def _version(requested: bool) -> None:
    if requested:
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


@_command(CommandPanel.ONE)
def run(
    context: typer.Context,
    scenario: options.Scenario,
    set_: options.Set = None,
    allow_outside: options.AllowOutside = False,
    full: options.Full = False,
    certify: options.Certify = False,
    baseline: options.Baseline = None,
    output: options.Folder = None,
    json: options.Json = False,
    format_: Annotated[list[str] | None, format_option(RUN)] = None,
    templates: options.Templates = None,
    paper: options.Paper = options.PaperSize.A4,
    figure_width: options.FigureWidth = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
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
        from vireport.report.changes.baseline import read_baseline

        before = read_baseline(baseline)
    loaded, earlier = read_scenario(scenario, set_, allow_outside)
    if full:
        from vireport.scenario.loading import with_default_blocks

        loaded = with_default_blocks(loaded)
    if certify and CERTIFICATES not in ADDITIONS:
        raise UsageError("No such option: --certify")
    certified = earlier is not None and bool(earlier.results.get(CERTIFICATES))
    added = (CERTIFICATES,) if certify or (certified and CERTIFICATES in ADDITIONS) else ()
    if added:
        from vireport.study.plan import refuse_special, require_proofs

        refuse_special(loaded.scenario, "--certify")
        require_proofs()
    from vireport.cli.outputs import BeforeRun, PageSettings, file_names, results_outcome, run_outcome

    command = recorded(context)
    if json:
        tell_lacking(loaded, ("json",), quiet)
        with progress(quiet, verbose) as say:
            outcome = results_outcome(loaded, command, ("json", *added), earlier, say)
        deliver(outcome, quiet=quiet)
        return
    folder, formats = output or default_folder(scenario), formats_of(RUN, format_)
    width_mm = figure_width_mm(figure_width, formats)
    require_writable(folder, file_names(formats), force)
    tell_lacking(loaded, formats, quiet)
    with progress(quiet, verbose) as say:
        # Those of a sweep are asked for by it; a device without one has none but those of its pages.
        every_figure = bool(format_) or loaded.scenario.sweep is None
        pages = PageSettings((*formats, *added), templates, paper, width_mm, every_figure)
        outcome = run_outcome(loaded, command, pages, BeforeRun(before, earlier), say)
    deliver(outcome, folder, quiet)


@_command(CommandPanel.HELP)
def check(
    scenario: options.Scenario,
    set_: options.Set = None,
    allow_outside: options.AllowOutside = False,
    json: options.Json = False,
    format_: Annotated[list[str] | None, format_option(CHECK)] = None,
    quiet: options.Quiet = False,
) -> None:
    """Check a scenario or a map file: every mistake in it, or what a run would compute and what to add for more.

    Computes nothing.
    """
    from vireport.scenario.loading import LoadedMap, load_any

    formats, earlier = formats_of(CHECK, format_), read_earlier_run(scenario)
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
        from vireport.cli.results import mistakes_data

        deliver(CommandOutcome(_json(mistakes_data(error)), exit_code=error.exit_code))
        return
    from vireport.cli.results import CheckedData, StepData
    from vireport.study.judging.alerts import input_alerts

    alerts = input_alerts(loaded.scenario)
    if isinstance(loaded, LoadedMap):
        name, kind = loaded.name, "map"
        what = f"{loaded.block.cells:,} cells over {' x '.join(axis.path for axis in loaded.block.axes)}"
        steps = [StepData(step="cells", runs=True, what=what, why="the file has a map block")]
        left_out: tuple[str, ...] = ()
    else:
        from vireport.study.plan import plan

        name, kind = loaded.document.name, "scenario"
        planned = plan(loaded.scenario, formats)
        steps = [StepData(step=step.task, runs=step.runs, what=step.what, why=step.why) for step in planned.steps]
        left_out = () if json else planned.left_out_lines()
    if json:
        data = CheckedData(valid=True, kind=kind, mistakes=[], alerts=[alert.data for alert in alerts], steps=steps)
        deliver(CommandOutcome(_json(data)))
        return
    running = [step for step in steps if step.runs]
    width = max(len(step.step) for step in running)
    lines = [f"{name}: valid {kind}", *(alert.words() for alert in alerts)]
    lines += [f"run  {step.step:<{width}}  {step.what} ({step.why})" for step in running]
    deliver(CommandOutcome(text="\n".join([*lines, *left_out, ""])), quiet=quiet)


@_command(CommandPanel.HELP)
def init(context: typer.Context, path: options.NewFile = NEW_FILE, schema: options.Schema = False) -> None:
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


@_command(CommandPanel.HELP)
def explain(code: options.AlertOrTerm = None) -> None:
    """Explain an alert, its causes and its remedies, or a term."""
    deliver(CommandOutcome(explanation(code)))


def _json(data: object) -> str:
    return json_text(data, indent=2) + "\n"


BUILDERS |= {_name: partial(_added, _name) for _name in adding("command")}
