"""The command line: each command reads its options, makes one call, and delivers what comes of it.

Exit codes: 0 done; 1 done, but a requirement of the scenario is not met; 2 usage, or an invalid scenario; 3 the
numbers could not be had or written, or an internal error; 130 interrupted, 143 ended by SIGTERM.

Each command imports the rooms that it uses, and no other: `vireport --help` needs none of them.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Collection
from difflib import get_close_matches
from enum import StrEnum
from pathlib import Path
from shlex import join
from traceback import format_exc
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, cast

import typer
from msgspec.structs import replace
from typer.core import TyperGroup
from typer.main import get_command

from vireport.base import (
    ReadingPlace,
    ScenarioError,
    UsageError,
    VireportError,
    WorkStep,
    __version__,
    interrupts,
    json_text,
    portion,
    require_writable,
    writable,
    write_new,
)
from vireport.cli.formats import format_option, formats_of
from vireport.cli.outcome import (
    RED,
    CommandOutcome,
    deliver,
    emit,
    progress,
    tell,
)
from vireport.text import explanation, visible

if TYPE_CHECKING:
    from vireport.report import Carried
    from vireport.scenario import Loaded
    from vireport.study import Task

PROGRAM = "vireport"

CHARTED_SHARE = 0.9
"""Share of the time of `chart` that the chart takes, as measured; its report takes the rest."""

LONGEST_HELP = 200
"""Characters of what the list of commands tells of each: none is cut."""

COMPLETION = "_VIREPORT_COMPLETE"
"""Set by a shell that completes a line of the program, as Typer has it."""

EPILOG = (
    "vireport SCENARIO is short for vireport run SCENARIO, and vireport COMMAND --help lists the options of a command. "
    "Exit codes: 0 done; 1 done, but a requirement of the scenario is not met; 2 usage, or an invalid scenario; 3 the "
    "numbers could not be computed or written, or an internal error; 130 interrupted; 143 ended by SIGTERM."
)


def _folder(text: str) -> Path:
    if not text.strip():
        raise typer.BadParameter("is empty (name a folder; . is the current one)")
    return Path(text)


ScenarioFile = Annotated[
    str, typer.Argument(metavar="SCENARIO", help="Reads the scenario from this YAML file; - is standard input.")
]


def _folder_option(help_: str) -> Any:
    return typer.Option("--output", "-o", metavar="DIR", parser=_folder, help=help_)


Folder = Annotated[
    Path | None,
    _folder_option("Writes to this folder; by default to one named after the scenario or the command."),
]
SetOption = Annotated[
    list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Replaces a value of the file; may be repeated.")
]
AllowOutside = Annotated[
    bool,
    typer.Option(
        "--allow-outside",
        help="Reads records that the scenario names outside of its folder, too. Allow it where you trust the scenario.",
    ),
]
Templates = Annotated[
    Path | None,
    typer.Option(
        "--templates",
        metavar="DIR",
        exists=True,
        file_okay=False,
        help="Uses the report templates of this folder instead of ours. Templates are code: use those you trust.",
    ),
]


class PaperSize(StrEnum):
    """The sizes of paper that a PDF can have."""

    A4 = "a4"
    LETTER = "letter"


Paper = Annotated[PaperSize, typer.Option(help="Sets the paper size of the PDF.")]
FigureWidth = Annotated[
    str | None,
    typer.Option(
        metavar="86mm",
        help="Draws figures this wide, for a column of a paper; needs --format png, svg or figure-pdf.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Prints errors only.")]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", help="Writes each step with its seconds to standard error as it ends.")
]
QuietCheck = Annotated[bool, typer.Option("--quiet", "-q", help="Prints nothing; the exit code tells the outcome.")]
Json = Annotated[bool, typer.Option("--json", help="Prints the results as JSON and writes no file.")]
JsonCheck = Annotated[bool, typer.Option("--json", help="Prints it as JSON; the exit code stays the same.")]


MEANT = {
    "map": "sweep",
    "maps": "sweep",
    "optimize": "optimise",
    "check": "validate",
    "report": "run",
    "help": "--help",
}
"""What other words for commands mean."""


class Panel(StrEnum):
    """What a command is for: the headings of the list of commands, in their order."""

    ONE = "One device"
    SEVERAL = "Several devices"
    MEASURED = "Measurement and accuracy"
    HELP = "Scenarios and terms"


class Command(NamedTuple):
    """A command: the function whose arguments are its options, and where it is listed."""

    function: Callable[..., None]
    panel: Panel


COMMANDS: dict[str, Command] = {}
"""Every command by its name, in the order in which they stand here."""


def _command_of(panel: Panel) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Make a function the command of its name."""

    def declare(function: Callable[..., None]) -> Callable[..., None]:
        COMMANDS[function.__name__] = Command(function, panel)
        return function

    return declare


class DefaultGroup(TyperGroup):
    """Commands, with `run` understood where the first word is none of them."""

    group_only = frozenset({"--help", "-h", "--version", "-V", "--install-completion", "--show-completion"})

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put `run` before anything that is neither a command nor an option of the group."""
        if args and args[0] not in COMMANDS and args[0] not in self.group_only:
            if not ctx.resilient_parsing:  # as it is while a shell completes a line
                self._refuse_misspelt_command(args[0])
            args = ["run", *args]
        return super().parse_args(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands by what they are for; Typer itself would need Rich for it."""
        for panel in Panel:
            with formatter.section(panel):
                commands: list[tuple[str, Any]] = list(self.commands.items())
                of_panel = [(name, own) for name, own in commands if own.rich_help_panel is panel]
                formatter.write_dl([(name, own.get_short_help_str(LONGEST_HELP)) for name, own in of_panel])

    def _refuse_misspelt_command(self, word: str) -> None:
        if word.startswith("-") or Path(word).exists():
            return
        if word in MEANT:
            raise UsageError(f"there is no command '{word}'; did you mean '{MEANT[word]}'?")
        if close := get_close_matches(word, COMMANDS, 1):
            raise UsageError(f"no such file '{word}'; did you mean the command '{close[0]}'?")


def _version(shown: bool) -> None:
    if shown:
        print(f"vireport {__version__}")
        raise typer.Exit


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


@_command_of(Panel.ONE)
def run(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO",
            help="Reads the scenario from this YAML file; - is standard input. A report is run again with what it "
            "carries.",
        ),
    ],
    output: Folder = None,
    json: Json = False,
    set_: SetOption = None,
    format_: Annotated[list[str] | None, format_option("run")] = None,
    certify: Annotated[
        bool,
        typer.Option("--certify", help="Proves the critical points in ball arithmetic; prints enclosures."),
    ] = False,
    baseline: Annotated[
        str | None,
        typer.Option(
            metavar="RESULTS.json",
            help="Lists in the report what has changed since an earlier run; the exit code is not affected.",
        ),
    ] = None,
    templates: Templates = None,
    paper: Paper = PaperSize.A4,
    figure_width: FigureWidth = None,
    allow_outside: AllowOutside = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Solve a scenario and write its report, figures and results."""
    if json and baseline is not None:
        raise UsageError("--json prints the results and no changes: leave out --baseline, or use vireport diff --json")
    before = None if baseline is None else _baseline(baseline, scenario)
    carried = _carried(scenario)
    loaded = _loaded(scenario, set_, carried, allow_outside)
    certify = certify or (carried is not None and bool(carried.results.get("certificates")))
    _refuse_files_beside_json(json, "results", output, format_, figure_width)
    if certify:
        from vireport.study import refuse_special

        refuse_special(loaded.scenario, "--certify")
    from vireport.cli.outputs import file_names, results_outcome, run_outcome

    options = (("--json", json), ("--set", set_), ("--format", format_), ("--certify", certify))
    outside = ("--allow-outside", allow_outside)
    against = ("--baseline", None if baseline is None else [Path(baseline).name])
    command = _command("run", [scenario], *options, _wide(figure_width), against, _paper(paper), outside)
    if json:
        with progress(quiet, verbose) as say:
            outcome = results_outcome(loaded, command, certify, carried, say)
        deliver(outcome, quiet=quiet)
        return
    folder, formats = output or _default_folder(scenario), formats_of("run", format_)
    width_mm = _figure_width(figure_width, formats)
    require_writable(folder, file_names(formats))
    with progress(quiet, verbose) as say:
        outcome = run_outcome(loaded, formats, command, templates, say, certify, before, carried, paper, width_mm)
    deliver(outcome, folder, quiet)


@_command_of(Panel.ONE)
def explore(
    scenario: ScenarioFile,
    output: Annotated[
        Path | None,
        _folder_option("Saves scenarios and reports of the page to this folder; by default to the current one."),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="N", help="Listens on this port; by default on one that is free.")
    ] = 0,
    browser: Annotated[bool, typer.Option(help="Opens the page in the browser.")] = True,
    set_: SetOption = None,
) -> None:
    """Change a design by hand in a page of this machine, with margins and verdict following. Ctrl-C ends it."""
    from vireport.bench import opened, serve

    known, folder = opened(scenario, tuple(set_ or ())), output or Path()
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


@_command_of(Panel.HELP)
def validate(
    scenario: ScenarioFile,
    json: JsonCheck = False,
    set_: SetOption = None,
    allow_outside: AllowOutside = False,
    quiet: Quiet = False,
) -> None:
    """Check a scenario or a map file. Lists every mistake; computes nothing."""
    from vireport.scenario import LoadedMap, load_any

    try:
        loaded = load_any(scenario, set_ or (), allow_outside)
        if not isinstance(loaded, LoadedMap) and loaded.scenario.measured:
            from vireport.study import require_records

            require_records(loaded)
    except ScenarioError as error:
        if not json:
            raise
        refused = {"valid": False, "kind": None, "mistakes": error.to_dicts(), "more": error.more}
        deliver(CommandOutcome(_json(refused), exit_code=error.exit_code))
        return
    from vireport.gate import input_alerts

    name, what = (loaded.name, "map") if isinstance(loaded, LoadedMap) else (loaded.document.name, "scenario")
    alerts = input_alerts(loaded.scenario)
    if json:
        told = [alert.to_dict() for alert in alerts]
        deliver(CommandOutcome(_json({"valid": True, "kind": what, "mistakes": [], "alerts": told})))
    else:
        lines = [f"{name}: valid {what}", *(alert.text for alert in alerts)]
        deliver(CommandOutcome(summary="\n".join(lines)), quiet=quiet)


@_command_of(Panel.HELP)
def schema() -> None:
    """Print the JSON Schema of scenarios, for editors."""
    from vireport.scenario import schema as schema_of_scenarios

    deliver(CommandOutcome(json_text(schema_of_scenarios(), indent=2, ascii_only=False) + "\n"))


@_command_of(Panel.HELP)
def init(
    path: Annotated[
        str, typer.Argument(metavar="FILE", help="Writes the scenario to this file; - prints it.")
    ] = "scenario.yaml",
) -> None:
    """Write a commented scenario to start from. An existing file is not overwritten."""
    from vireport.scenario import init_text

    if path == "-":
        deliver(CommandOutcome(init_text()))
        return
    with writable(Path(path)):
        try:
            write_new(Path(path), init_text().encode())
        except FileExistsError as error:
            raise UsageError(f"{path} exists already; name another file, or - to print the scenario") from error
    deliver(CommandOutcome(summary=f"wrote {path}; next: vireport {path}"))


@_command_of(Panel.ONE)
def plan(
    scenario: ScenarioFile,
    json: JsonCheck = False,
    set_: SetOption = None,
    format_: Annotated[list[str] | None, format_option("plan")] = None,
    quiet: QuietCheck = False,
) -> None:
    """Print what a run would compute and leave out, with the reasons. Computes nothing."""
    from vireport.study import plan as plan_of

    steps = plan_of(_loaded(scenario, set_).scenario, formats_of("plan", format_)).steps
    if json:
        told = [{"step": step.task, "runs": step.runs, "what": step.what, "why": step.why} for step in steps]
        deliver(CommandOutcome(_json({"steps": told})))
        return
    width = max(len(step.task) for step in steps)
    rows = [f"{'run ' if step.runs else 'skip'}  {step.task:<{width}}  {step.what} ({step.why})\n" for step in steps]
    deliver(CommandOutcome("" if quiet else "".join(rows)))


@_command_of(Panel.MEASURED)
def accuracy(
    scenario: ScenarioFile,
    output: Annotated[Path | None, _folder_option("Writes figures and accuracy.json to this folder.")] = None,
    json: Json = False,
    every: Annotated[bool, typer.Option("--all", help="Prints a row for every run, not only for the best.")] = False,
    set_: SetOption = None,
    figure_width: Annotated[
        str | None,
        typer.Option(metavar="86mm", help="Draws the figures this wide, for a column of a paper; needs --output."),
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Measure the error of every method against its run time, and compare compliant with rigid membranes."""
    if output is None and figure_width is not None:
        raise UsageError("--figure-width: figures are written to a folder (give --output)")
    loaded = _loaded(scenario, set_)
    from vireport.cli import accuracy_outputs
    from vireport.study import Task, refuse_special

    refuse_special(loaded.scenario, "vireport accuracy")
    if output is not None:
        require_writable(output, accuracy_outputs.NAMES)
    width_mm = _figure_width(figure_width, (Task.PNG,))
    with progress(quiet, verbose) as say:
        study = accuracy_outputs.measured(loaded, say)
        files = accuracy_outputs.files(study, width_mm) if output is not None else {}
    printed = accuracy_outputs.data(study) if json else accuracy_outputs.text(study, every)
    deliver(CommandOutcome(printed, files, stale=accuracy_outputs.NAMES), output, quiet)


@_command_of(Panel.SEVERAL)
def compare(
    scenarios: Annotated[
        list[str], typer.Argument(metavar="SCENARIO", help="Compares these files, or with --vary the variants of one.")
    ],
    vary: Annotated[
        list[str] | None,
        typer.Option("--vary", metavar="PATH=A,B,...", help="Varies a key over these values; may be repeated."),
    ] = None,
    rank_by: Annotated[
        list[str] | None,
        typer.Option("--rank-by", metavar="WHAT", help="Ranks by from-rest, recovery or shock before the margin."),
    ] = None,
    output: Folder = None,
    json: Json = False,
    set_: SetOption = None,
    format_: Annotated[list[str] | None, format_option("compare")] = None,
    templates: Templates = None,
    paper: Paper = PaperSize.A4,
    figure_width: FigureWidth = None,
    allow_outside: AllowOutside = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Compare scenarios, or variants of one, and tell which is best."""
    _refuse_files_beside_json(json, "comparison", output, format_, figure_width)
    from vireport.cli.outputs import compare_outcome, file_names
    from vireport.comparison import COMPARISON_FILES, COMPARISON_FOLDER, compare_json, comparison_provenance, folder_of
    from vireport.comparison import compare as compare_scenarios

    options = (("--vary", vary), ("--rank-by", rank_by), ("--json", json), ("--set", set_), ("--format", format_))
    outside = ("--allow-outside", allow_outside)
    command = _command("compare", scenarios, *options, _wide(figure_width), _paper(paper), outside)
    formats = formats_of("compare", format_)
    width_mm = _figure_width(figure_width, formats)
    if not json:
        require_writable(output or Path(COMPARISON_FOLDER), file_names(formats, COMPARISON_FILES))
    with progress(quiet, verbose) as say:
        comparison = compare_scenarios(scenarios, vary or None, None, set_ or (), say, rank_by or (), allow_outside)
        if not json:
            outcome = compare_outcome(comparison, formats, command, templates, say, paper, width_mm)
    if json:
        outcome = CommandOutcome(compare_json(comparison, comparison_provenance(comparison, command)))
    deliver(outcome, output or folder_of(comparison, command), quiet)


@_command_of(Panel.SEVERAL)
def diff(
    baseline: Annotated[
        str,
        typer.Argument(metavar="RESULTS.json", help="Reads the results.json of an earlier run; - is standard input."),
    ],
    scenario: ScenarioFile,
    tolerance: Annotated[
        float, typer.Option(metavar="SHARE", min=0.0, help="Ignores relative changes up to this share.")
    ] = 1e-6,
    markdown: Annotated[bool, typer.Option("--markdown", help="Prints a table for a pull request.")] = False,
    json: Json = False,
    set_: SetOption = None,
    allow_outside: AllowOutside = False,
    quiet: QuietCheck = False,
    verbose: Verbose = False,
) -> None:
    """List what has changed since earlier results.

    The exit code is 1 if anything has changed by more than the tolerance.
    """
    from vireport.comparison import diff as changes_since
    from vireport.comparison import diff_json, diff_markdown, diff_text
    from vireport.study import Task, analyse

    before = _baseline(baseline, scenario)
    loaded = _loaded(scenario, set_, allow_outside=allow_outside)
    with progress(quiet, verbose) as say:
        changes = changes_since(before, analyse(loaded, (Task.JSON,), say), relative=tolerance)
    printed: str | bytes
    if json:
        printed = diff_json(changes, tolerance)
    else:
        render = diff_markdown if markdown else diff_text
        printed = render(changes, "standard input" if baseline == "-" else Path(baseline).name).rstrip("\n") + "\n"
    deliver(CommandOutcome("" if quiet else printed, exit_code=1 if changes else 0))


@_command_of(Panel.HELP)
def explain(
    code: Annotated[
        str | None,
        typer.Argument(
            metavar="CODE", help="Explains this alert, such as VR010, or term, such as fold; by default all alerts."
        ),
    ] = None,
) -> None:
    """Explain an alert, its causes and its remedies, or a term."""
    deliver(CommandOutcome(explanation(code)))


@_command_of(Panel.MEASURED)
def extremes(
    scenario: Annotated[
        str | None,
        typer.Argument(
            metavar="SCENARIO", help="Takes the device of this scenario to extremes; by default the paper's."
        ),
    ] = None,
    json: Json = False,
    set_: SetOption = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Run the catalogue of extreme cases against 40-digit arithmetic.

    The exit code is 1 if one fails, and 3 if some could not be run or if none applies.
    """
    from vireport.extremes import (
        exit_status,
        run_catalogue,
        table_data,
        table_text,
    )
    from vireport.study import refuse_special

    if scenario is None and set_:
        raise UsageError("--set needs a scenario to set it over")
    loaded = None if scenario is None else _loaded(scenario, set_)
    if loaded is not None:
        refuse_special(loaded.scenario, "vireport extremes")
    with progress(quiet, verbose) as say:
        outcomes = run_catalogue(loaded, say)
    printed = f"{json_text(table_data(outcomes))}\n" if json else table_text(outcomes)
    code, failure = exit_status(outcomes)
    deliver(CommandOutcome(printed, failure=failure, exit_code=code))


@_command_of(Panel.SEVERAL)
def optimise(
    scenario: ScenarioFile,
    output: Folder = None,
    json: Json = False,
    set_: SetOption = None,
    format_: Annotated[list[str] | None, format_option("optimise")] = None,
    templates: Templates = None,
    paper: Paper = PaperSize.A4,
    figure_width: FigureWidth = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Find the best design that meets the requirements. The scenario's design block says what may vary.

    The exit code is 1 if no design meets the requirements.
    """
    _refuse_files_beside_json(json, "result", output, format_, figure_width)
    loaded = _loaded(scenario, set_)
    from vireport.cli.outputs import file_names, run_files
    from vireport.optimise import optimise as search
    from vireport.optimise import outputs, problem_of
    from vireport.study import provenance_of

    problem = problem_of(loaded)
    options = (("--json", json), ("--set", set_), ("--format", format_), _wide(figure_width), _paper(paper))
    command = _command("optimise", [scenario], *options)
    formats = formats_of("optimise", format_)
    width_mm, provenance = _figure_width(figure_width, formats), provenance_of(loaded, command)
    stale = (*outputs.DATA, *file_names(formats, outputs.OPTIMISE_FILES))
    folder = _writable_folder(output, scenario, "-best", json, stale)
    with progress(quiet, verbose) as say:
        result = search(problem, say)
        pages = [task for task in outputs.PAGES if task in formats and result.best is not None and not json]
        say("solving the best design")
        study = outputs.run_of(result, pages, say)
        files = {} if json else outputs.files(result, study, provenance, formats, width_mm)
        if study is not None and pages:
            files |= run_files(study, command, templates, say, None, paper, *outputs.section(result))
    printed: str | bytes = (
        outputs.optimise_json(result, study, provenance) if json else "" if quiet else outputs.text(result, study)
    )
    failure = outputs.shortcoming(result)
    others = [task for task in outputs.OPTIMISE_FILES if task not in formats]
    beside = file_names(others, outputs.OPTIMISE_FILES)
    told = CommandOutcome(printed, files, failure=failure, exit_code=bool(failure), stale=stale, beside=beside)
    deliver(told, folder, quiet)


@_command_of(Panel.ONE)
def portrait(
    results: Annotated[
        str, typer.Argument(metavar="RESULTS.json", help="Reads the results.json of a run; - is standard input.")
    ],
    at: Annotated[
        str,
        typer.Option(
            metavar="VALUE[,VELOCITY]",
            help="Draws the motions at this value of the swept parameter, in its unit; with a dimensionless impact "
            "velocity, only the nearest.",
        ),
    ],
    output: Folder = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Draw the motions at a point of a diagram; with a velocity, only the nearest of them."""
    _refuse_files_beside_json(json, "motions", output, None)
    from vireport.cli.portrait_outputs import NAMES, portrait_outcome
    from vireport.comparison import read_baseline

    earlier = read_baseline(results)
    run = Path(results).resolve().parent.name if Path(results).name == "results.json" else results
    folder = _writable_folder(output, run, "-portrait", json, NAMES)
    outcome = portrait_outcome(earlier, Path(results).name, at, json)
    deliver(outcome, folder, quiet)


class ClockReference(StrEnum):
    """What time 0 of a record can be."""

    FORCE = "force"


@_command_of(Panel.MEASURED)
def identify(
    scenario: ScenarioFile,
    impacts: Annotated[
        str | None,
        typer.Option(
            metavar="IMPACTS.csv", help="Reads measured impacts, with columns time_s and membrane (bottom or top)."
        ),
    ] = None,
    record: Annotated[
        str | None,
        typer.Option(
            metavar="RECORD",
            help="Picks the impacts from raw signals, a CSV, WAV or MATLAB file in which they are named with units.",
        ),
    ] = None,
    clock: Annotated[
        ClockReference | None,
        typer.Option(help="States that the force is largest at time 0; without it, its phase is identified as well."),
    ] = None,
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY", help="Identifies this input; may be repeated. By default both restitutions are identified."
        ),
    ] = None,
    output: Folder = None,
    json: Json = False,
    set_: SetOption = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Identify restitutions and other inputs from measured impacts or raw signals, and test whether the model fits.

    The exit code is 1 if the impacts contradict the model, and 3 if they do not determine what is asked for.
    """
    _refuse_files_beside_json(json, "result", output, None)
    loaded = _loaded(scenario, set_)
    from vireport.cli import identify_outputs

    if (impacts is None) == (record is None):
        raise UsageError("either --impacts or --record is needed (allowed: one of them)")
    given = ("--impacts", impacts), ("--record", record)
    against = [(option, [Path(path).name]) for option, path in given if path is not None]
    reference: tuple[str, list[str] | None] = ("--clock", None if clock is None else [clock.value])
    options = (("--free", free), ("--json", json), ("--set", set_))
    command = _command("identify", [scenario], *against, reference, *options)
    folder = _writable_folder(output, scenario, "-identified", json, identify_outputs.NAMES)
    with progress(quiet, verbose) as say:
        outcome = identify_outputs.outcome(loaded, impacts, record, clock is not None, free or [], command, json, say)
    if json:
        outcome = replace(outcome, files={})
    elif quiet:
        outcome = replace(outcome, printed="")
    deliver(outcome, folder, quiet)


@_command_of(Panel.SEVERAL)
def chart(
    scenario: ScenarioFile,
    over: Annotated[
        str,
        typer.Option(
            metavar="INPUT,INPUT",
            help="Spans the chart by two inputs, each with an optional range: inclination_deg=0..90,length_m=0.3..1.",
        ),
    ],
    output: Folder = None,
    json: Json = False,
    set_: SetOption = None,
    format_: Annotated[list[str] | None, format_option("chart")] = None,
    templates: Templates = None,
    paper: Paper = PaperSize.A4,
    figure_width: FigureWidth = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Draw the stable motions over two inputs, bounded by the exact curves along which motions change."""
    _refuse_files_beside_json(json, "chart", output, format_, figure_width)
    loaded = _loaded(scenario, set_)
    from vireport.chart import chart_of
    from vireport.chart import outputs as charts
    from vireport.cli.outputs import file_names
    from vireport.study import provenance_of

    options = (("--over", [over]), ("--json", json), ("--set", set_), ("--format", format_))
    command = _command("chart", [scenario], *options, _wide(figure_width), _paper(paper))
    formats = formats_of("chart", format_)
    width_mm = _figure_width(figure_width, formats)
    names = file_names(formats, charts.CHART_FILES)
    folder = _writable_folder(output, scenario, "-chart", json, names)
    with progress(quiet, verbose) as say:
        result = chart_of(loaded, over, portion(say, 0.0, 1.0 if json else CHARTED_SHARE))
        if not json:
            say(WorkStep("setting the report", CHARTED_SHARE))
            files = charts.files(result, loaded, formats, command, templates, paper, width_mm)
    if json:
        deliver(CommandOutcome(charts.chart_json(result, provenance_of(loaded, command))), quiet=quiet)
        return
    beside = file_names([task for task in charts.CHART_FILES if task not in formats], charts.CHART_FILES)
    printed = "" if quiet else charts.text(result, templates)
    deliver(CommandOutcome(printed, files, stale=names, beside=beside), folder, quiet)


@_command_of(Panel.SEVERAL)
def sweep(
    map_file: Annotated[
        str, typer.Argument(metavar="MAP", help="Reads the map from this YAML file, which has a map block.")
    ],
    output: Folder = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help="Computes on the workers of this Dask scheduler.")
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Uses so many processes on this machine; by default one per core."),
    ] = None,
    figures: Annotated[
        bool, typer.Option(help="Writes a report, with heat maps of a grid over two parameters, beside the cells.")
    ] = True,
    format_: Annotated[list[str] | None, format_option("sweep")] = None,
    templates: Templates = None,
    paper: Paper = PaperSize.A4,
    figure_width: FigureWidth = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Compute a map over two or more parameters. An interrupted run is resumed where it stopped."""
    if not figures and (format_ or figure_width):
        raise UsageError("--no-figures writes the cells alone: leave out --format and --figure-width")
    from vireport.cli.outputs import file_names
    from vireport.maps import MAP_FILES, MapOutput, run_map

    command = _command("sweep", [map_file], ("--format", format_), _wide(figure_width), _paper(paper))
    formats = formats_of("sweep", format_)
    width_mm = _figure_width(figure_width, formats)
    folder = output or _default_folder(map_file)
    require_writable(folder, file_names(formats, MAP_FILES) if figures else ())
    asked = MapOutput(formats, command, templates, paper, width_mm)
    try:
        with progress(quiet, verbose) as say:

            def show(done: int, total: int) -> None:
                say(WorkStep("computing cells", done / total, f"{done:,} of {total:,}"))

            summary = run_map(map_file, folder, scheduler, workers, show, figures, asked)
        interrupts.check()
    except KeyboardInterrupt:
        raise KeyboardInterrupt("what is computed so far is kept: run the same command again to go on") from None
    deliver(CommandOutcome(summary=summary), quiet=quiet)


def _json(data: dict[str, Any]) -> str:
    return json_text(data, indent=2) + "\n"


def _loaded(
    scenario: str, overrides: list[str] | None, carried: Carried | None = None, allow_outside: bool = False
) -> Loaded:
    """The scenario of a file, or the one that a report carries, whose records are beside the report."""
    from vireport.scenario import load, loads

    if carried is None:
        return load(scenario, overrides or (), allow_outside)
    over, place = [*carried.overrides, *(overrides or ())], ReadingPlace(str(Path(scenario).parent), allow_outside)
    return loads(carried.scenario, f"{scenario}/{carried.name}", over, place)


def _baseline(baseline: str, scenario: str) -> dict[str, Any]:
    """The results of an earlier run; read before the scenario, so that nothing is computed where they are none."""
    if baseline == scenario == "-":
        raise UsageError("standard input can be the results or the scenario, not both")
    from vireport.comparison import read_baseline

    return read_baseline(baseline)


def _carried(path: str) -> Carried | None:
    """What a report carries; None where the path is none of a report."""
    if Path(path).suffix.lower() not in (".html", ".pdf") or not Path(path).is_file():
        return None
    from vireport.comparison import require_comparable
    from vireport.report import read_carried

    carried = read_carried(path)
    require_comparable(carried.results, carried.report)
    return carried


def _figure_width(text: str | None, formats: tuple[Task, ...]) -> float | None:
    """The width that figures are asked for with [mm]; None where they are those of a report."""
    if text is None:
        return None
    number = re.fullmatch(r"\s*(\d+(?:\.\d*)?)\s*(mm|cm|in)?\s*", text)
    if number is None:
        raise UsageError(f"--figure-width: {text!r} is no width (allowed: a number with mm, cm or in, such as 86mm)")
    from vireport.study import FIGURE_FORMATS

    if {"html", "pdf"} & set(formats) or not set(formats) & set(FIGURE_FORMATS):
        raise UsageError(
            "--figure-width: figures of a report are as wide as its page (give --format with "
            f"{', '.join(FIGURE_FORMATS)}, and neither html nor pdf)"
        )
    from vireport.figures import Sheet

    width_mm = float(number[1]) * {"mm": 1.0, "cm": 10.0, "in": 25.4}[number[2] or "mm"]
    Sheet.of(width_mm)  # refuses what is too narrow or too wide
    return width_mm


def _refuse_files_beside_json(
    json: bool, what: str, output: Path | None, formats: list[str] | None, figure_width: str | None = None
) -> None:
    if json and (output is not None or formats):
        raise UsageError(f"--json prints the {what} and writes no file: leave out --output and --format")
    if json and figure_width is not None:
        raise UsageError(f"--json prints the {what} and draws no figure: leave out --figure-width")


def _writable_folder(output: Path | None, file: str, suffix: str, json: bool, names: tuple[str, ...]) -> Path:
    """Where the files of a command go; unless it prints JSON, what cannot be written is told before any work."""
    folder = output or _default_folder(file, suffix)
    if not json:
        require_writable(folder, names)
    return folder


def _default_folder(scenario: str, suffix: str = "") -> Path:
    """Folder named after the scenario, in the current one; "report" where its name makes none."""
    name = "stdin" if scenario == "-" else Path(scenario).stem
    folder = Path((name if name.strip(".") else "report") + suffix)
    return folder.with_name(f"{folder.name}-report") if folder.is_file() else folder


def _command(command: str, files: list[str], *options: tuple[str, list[str] | bool | None]) -> str:
    """The command for the record: without the folders, which do not change the results."""
    words = ["vireport", command, *(visible(Path(name).name) for name in files)]
    for option, values in options:
        words += [option] if values is True else [word for value in values or [] for word in (option, visible(value))]
    return join(words)


def _wide(figure_width: str | None) -> tuple[str, list[str] | None]:
    """The command's width of figures for the record, where one is given."""
    return "--figure-width", None if figure_width is None else [figure_width]


def _paper(paper: PaperSize) -> tuple[str, list[str] | None]:
    """What the record says of the paper: nothing of the one by default."""
    return "--paper", None if paper is PaperSize.A4 else [paper]


def program(names: Collection[str] = COMMANDS) -> DefaultGroup:
    """The program with some of its commands, by default all.

    A line is of one command: what Typer makes of the options of all is a fortieth of a run with --json.
    """
    app = typer.Typer(
        cls=DefaultGroup,
        invoke_without_command=True,
        subcommand_metavar="SCENARIO | COMMAND ...",
        epilog=EPILOG,
        context_settings={"help_option_names": ["-h", "--help"]},
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    app.callback()(_group)
    for name in names:
        app.command(rich_help_panel=COMMANDS[name].panel)(COMMANDS[name].function)
    return cast(DefaultGroup, get_command(app))


def main(arguments: list[str]) -> int:
    """Run the command line on `arguments` and return the exit code."""
    if COMPLETION in os.environ:
        program()(prog_name=PROGRAM)  # says how the words go on, and ends the process
    try:
        code = _run(arguments)
    except KeyboardInterrupt as error:
        return _interrupted(str(error) or "no file was written")
    except VireportError as error:
        if interrupts.received():
            return _interrupted()
        first, *others = error.lines
        tell([first if isinstance(error, ScenarioError) else f"vireport: error: {first}", *others], RED)
        return error.exit_code
    except BaseException:  # those of extension modules, too, that are no Exception
        if interrupts.received():  # it may have come where a library makes another error of it
            return _interrupted()
        fault = "internal error: this is a fault of ours; please report it with the lines above"
        tell([*format_exc().splitlines(), f"vireport {__version__}: {fault}"])
        return VireportError.exit_code
    return _interrupted("all was done") if interrupts.received() else code


def _run(arguments: list[str]) -> int:
    """Run a command and return its exit code; what the command raises is raised."""
    first = arguments[0] if arguments else ""
    asked = first if first in COMMANDS else "run"
    group = program(COMMANDS if not arguments or first in DefaultGroup.group_only else (asked,))
    # The two steps of a call of the group, which has exit codes of its own for an interrupt and for a broken pipe.
    try:
        with group.make_context(PROGRAM, [*arguments]) as context:
            group.invoke(context)
    except typer.Exit as stop:
        return stop.exit_code
    except SystemExit as stop:  # Typer ends the process once it has shown or installed the script of completion
        return stop.code if isinstance(stop.code, int) else 0
    except typer.TyperException as refused:
        interrupts.check()  # one that came while the arguments were read: nothing was done
        tell([f"{PROGRAM}: error: {refused.format_message()}", f"{PROGRAM} {asked} --help lists the options"], RED)
        return refused.exit_code
    return 0


def _interrupted(what: str = "") -> int:
    tell([f"vireport: interrupted{what and f' ({what})'}"], RED)
    return interrupts.exit_code()
