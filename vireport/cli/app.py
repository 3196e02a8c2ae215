"""The command line: reads options, calls one function, says what was done, returns an exit code.

Exit codes: 0 done; 1 done, but a requirement of the scenario is not met; 2 usage, or an invalid scenario; 3 the
numbers could not be had, or an internal error; 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

os.environ.setdefault(
    "PYDANTIC_DISABLE_PLUGINS", "__all__"
)  # Typer would load every plugin installed: milliseconds, and not ours

import typer
from typer.core import TyperGroup

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
from vireport.errors import ScenarioError, UsageError, VireportError
from vireport.version import __version__

if TYPE_CHECKING:
    from vireport.gate import Criterion

EPILOG = (
    "vireport SCENARIO is short for vireport run SCENARIO (options: vireport run --help). Exit codes: 0 done; 1 done, "
    "but a requirement of the scenario is not met; 2 usage, or an invalid scenario; 3 the numbers could not be had, or "
    "an internal error; 130 interrupted."
)


class DefaultGroup(TyperGroup):
    """Commands, with `run` understood where the first word is none of them."""

    group_only = frozenset({"--help", "-h", "--version", "-V", "--install-completion", "--show-completion"})

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put `run` before anything that is neither a command nor an option of the group."""
        if args and args[0] not in self.commands and args[0] not in self.group_only:
            self._refuse_misspelt_command(args[0])
            args = ["run", *args]
        return super().parse_args(ctx, args)

    def _refuse_misspelt_command(self, word: str) -> None:
        if word.startswith("-") or Path(word).exists():
            return
        from difflib import get_close_matches

        if close := get_close_matches(word, self.commands, 1, 0.7):
            raise UsageError(f"no such file {word!r}; did you mean the command {close[0]!r}?")


app = typer.Typer(
    cls=DefaultGroup,
    no_args_is_help=True,
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
    version: Annotated[
        bool, typer.Option("--version", "-V", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Periodic motions, stability and voltage of a vibro-impact energy harvester, from a YAML scenario to a report."""


@app.command()
def run(
    scenario: ScenarioFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="DIR", help="Where to write; by default a folder named after the scenario."
        ),
    ] = None,
    json: Json = False,
    set_: Overrides = None,
    format_: Formats = None,
    certify: Annotated[
        bool, typer.Option("--certify", help="Prove the critical points in ball arithmetic, and print enclosures.")
    ] = False,
    templates: Templates = None,
    quiet: Quiet = False,
) -> None:
    """Solve a scenario and write its report, figures and results."""
    loaded = load(scenario, set_)
    options = (("--json", json), ("--set", set_), ("--format", format_), ("--certify", certify))
    command = command_of("run", [scenario], *options)
    if json:
        if output is not None or format_:
            raise UsageError("--json prints the results and writes no file: leave out --output and --format")
        from vireport.study import (
            analyse,
            provenance_of,
            results_json,
            with_certificates,
        )

        study = analyse(loaded, ("json",))
        if certify:
            study = with_certificates(study)
        emit(results_json(study, provenance_of(loaded, command)))
        _exit_by(study.criteria, said=False)
        return
    from vireport.cli.outputs import default_folder, write_outputs

    folder = output or default_folder(scenario)
    progress = None if quiet or not sys.stderr.isatty() else show
    written = write_outputs(loaded, folder, formats_of(format_), command, templates, progress, certify)
    if written.printed:
        emit(written.printed.encode())
    if not quiet:
        print(written.summary, file=sys.stderr)
    _exit_by(written.criteria, said=not quiet)


@app.command()
def validate(scenario: ScenarioFile, set_: Overrides = None) -> None:
    """Check a scenario and say what is wrong with it; compute nothing."""
    loaded = load(scenario, set_)
    print(f"{loaded.document.name}: valid", file=sys.stderr)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scenarios, for editors."""
    import json

    from vireport.scenario import schema as build

    print(json.dumps(build(), indent=2, ensure_ascii=False))


@app.command()
def init(
    path: Annotated[str, typer.Argument(metavar="[FILE]", help="Where to write it; - prints it.")] = "scenario.yaml",
) -> None:
    """Write a commented scenario to start from; an existing file is left alone."""
    from vireport.scenario import init_text

    if path == "-":
        print(init_text(), end="")
        return
    try:
        with open(path, "x", encoding="utf-8") as file:
            file.write(init_text())
    except FileExistsError as error:
        raise UsageError(f"{path} exists already; name another file, or - to print the scenario") from error
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from error
    print(f"wrote {path}; next: vireport {path}", file=sys.stderr)


@app.command(name="plan")
def show_plan(scenario: ScenarioFile, set_: Overrides = None, format_: Formats = None) -> None:
    """Print what a run would do, what it would leave out, and why; compute nothing."""
    from vireport.study import plan

    steps = plan(load(scenario, set_).scenario, formats_of(format_)).steps
    width = max(len(step.name) for step in steps)
    for step in steps:
        print(f"{'run ' if step.runs else 'skip'}  {step.name:<{width}}  {step.what} ({step.why})")


def _exit_by(criteria: tuple[Criterion, ...], said: bool) -> None:
    """Leave with 1 where something that is required is not met, and say what, unless that is said already."""
    if all(criterion.passed for criterion in criteria):
        return
    if not said:
        from vireport.gate import unmet

        print(f"vireport: {unmet(criteria)}", file=sys.stderr)
    raise typer.Exit(1)


def _runs(arguments: list[str]) -> bool:
    """Whether it is plainly a run that is asked for: the other commands, each some work to set up, are not needed."""
    return bool(arguments) and (arguments[0] in ("run", "-") or arguments[0].endswith((".yaml", ".yml")))


def main(arguments: list[str]) -> int:
    """Run the command line on `arguments` and return the exit code."""
    try:
        if not _runs(arguments):
            from vireport.cli.commands import register

            register(app)
        app(args=arguments, prog_name="vireport")
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 0
    except ScenarioError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    except VireportError as error:
        print(f"vireport: error: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("vireport: interrupted", file=sys.stderr)
        return 130
    except Exception:
        import traceback

        traceback.print_exc()
        print(
            f"vireport {__version__}: internal error: this is a fault of ours; please report it with the lines above",
            file=sys.stderr,
        )
        return VireportError.exit_code
    return 0
