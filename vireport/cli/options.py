"""Every argument and option of the command line, declared once: each means the same wherever it stands.

A command takes its own from here by annotating its parameters. What follows from the options given is here as well:
the command for the record, the folder and the width of figures, and which options do not go together.
"""

import re
from collections.abc import Iterable, Iterator
from enum import StrEnum
from pathlib import Path
from shlex import join
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vireport.base.additions import ADDITIONS
from vireport.base.errors import UsageError
from vireport.text.foreign import visible

if TYPE_CHECKING:
    from vireport.study.plan import Task


class OptionPanel(StrEnum):
    """What an option is for: the headings of the help of a command, in their order; others come first."""

    OUTPUT = "Output"
    MESSAGES = "Messages"


class PaperSize(StrEnum):
    """The sizes of paper that a PDF can have."""

    A4 = "a4"
    LETTER = "letter"


class ClockReference(StrEnum):
    """What time 0 of a record of impacts can be known to be."""

    FORCE = "force"


def _folder(text: str) -> Path:
    if not text.strip():
        raise typer.BadParameter("is empty (name a folder; . is the current one)")
    return Path(text)


def output_option(*names: str, **declared: Any) -> object:
    """An option that says what is written, and where."""
    return typer.Option(*names, rich_help_panel=OptionPanel.OUTPUT, **declared)


def _messages(*names: str, **declared: Any) -> object:
    return typer.Option(*names, rich_help_panel=OptionPanel.MESSAGES, **declared)


SCENARIO = (
    "Reads the scenario from this YAML file, or that of an earlier run from its results.json, report.html or "
    "report.pdf; - is standard input."
)

Scenario = Annotated[str, typer.Argument(metavar="SCENARIO", help=SCENARIO)]
ScenarioIfAny = Annotated[str | None, typer.Argument(metavar="SCENARIO", help=SCENARIO)]
Scenarios = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENARIO",
        help="Compares these: scenarios, or those of earlier runs from their results.json, report.html or "
        "report.pdf; with --vary, the variants of one.",
    ),
]
ScenarioOrMap = Annotated[
    str,
    typer.Argument(
        metavar="FILE",
        help="Reads a YAML file with a map block, or with --over a scenario; - is standard input.",
    ),
]
NewFile = Annotated[str, typer.Argument(metavar="FILE", help="Writes the scenario to this file; - prints it.")]
AlertOrTerm = Annotated[
    str | None,
    typer.Argument(
        metavar="CODE", help="Explains this alert, such as VR010, or term, such as fold; by default all alerts."
    ),
]

Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Replaces a value of the scenario; may be repeated."),
]
AllowOutside = Annotated[
    bool,
    typer.Option(
        "--allow-outside",
        help="Reads records that the scenario names outside of its folder, too. Allow it where you trust the scenario.",
    ),
]
Certify = Annotated[
    bool,
    typer.Option(
        "--certify",
        hidden="certificates" not in ADDITIONS,
        help="Proves the critical points in ball arithmetic; prints enclosures.",
    ),
]
Full = Annotated[
    bool,
    typer.Option(
        "--full",
        help=f"Adds those of the blocks {'disturbances, ' * ('outcomes' in ADDITIONS)}motions and simulation that the "
        "scenario lacks, with their defaults.",
    ),
]
Baseline = Annotated[
    str | None,
    typer.Option(
        metavar="FILE",
        help="Lists in the report what has changed since an earlier run, read from its results.json, report.html or "
        "report.pdf; the exit code is not affected.",
    ),
]
Vary = Annotated[
    list[str] | None,
    typer.Option("--vary", metavar="KEY=A,B,...", help="Varies a key over these values; may be repeated."),
]
RankBy = Annotated[
    list[str] | None,
    typer.Option("--rank-by", metavar="WHAT", help="Ranks by from-rest, recovery or shock before the margin."),
]
ExitCode = Annotated[
    bool,
    typer.Option(
        "--exit-code",
        help="Lists what has changed from OLD, an earlier run, to NEW, and writes no file; the exit code is 1 if "
        "anything has.",
    ),
]
Tolerance = Annotated[
    float,
    typer.Option(metavar="SHARE", min=0.0, help="Ignores relative changes up to this share; for --exit-code."),
]
Markdown = Annotated[bool, typer.Option("--markdown", help="Prints a table for a pull request; for --exit-code.")]
Over = Annotated[
    str | None,
    typer.Option(
        metavar="INPUT,INPUT",
        help="Draws the exact curves over two inputs of a scenario, each with an optional range: "
        "inclination_deg=0..90,length_m=0.3..1.",
    ),
]
Scheduler = Annotated[
    str | None, typer.Option(metavar="tcp://HOST:PORT", help="Computes cells on the workers of this Dask scheduler.")
]
Workers = Annotated[
    int | None,
    typer.Option(min=1, metavar="N", help="Uses so many processes of this machine for cells; by default one per core."),
]
Port = Annotated[
    int, typer.Option(min=0, max=65535, metavar="N", help="Listens on this port; by default on one that is free.")
]
Browser = Annotated[bool, typer.Option(help="Opens the page in the browser.")]
Impacts = Annotated[
    str | None,
    typer.Option(
        metavar="IMPACTS.csv", help="Reads measured impacts, with columns time_s and membrane (bottom or top)."
    ),
]
Record = Annotated[
    str | None,
    typer.Option(
        metavar="RECORD",
        help="Picks the impacts from raw signals: an export of an instrument, WAV, MATLAB, TDMS, HDF5 and others.",
    ),
]
Inspected = Annotated[
    str | None,
    typer.Option(
        "--inspect",
        metavar="FILE",
        help="Shows what is in a file of signals, and prints the record: block that says what its columns are.",
    ),
]
Clock = Annotated[
    ClockReference | None,
    typer.Option(help="States that the force is largest at time 0; without it, its phase is identified as well."),
]
Free = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY", help="Identifies this input; may be repeated. By default both restitutions are identified."
    ),
]
Extremes = Annotated[
    bool,
    typer.Option(
        "--extremes",
        help="Runs the catalogue of extreme cases against 40-digit arithmetic instead, around the device of the "
        "scenario or the paper's. The exit code is 1 if one fails, and 3 if some could not be run or if none applies.",
    ),
]
Validate = Annotated[
    bool,
    typer.Option(
        "--validate",
        help="Prints instead what the paper and others have published beside what is computed here, some 10 seconds. "
        "The exit code is 3 if anything but a misprint of the paper differs.",
    ),
]
EveryRun = Annotated[bool, typer.Option("--all", help="Prints a row for every run, not only for the best.")]
Schema = Annotated[bool, typer.Option("--schema", help="Prints the JSON Schema of scenarios instead, for editors.")]

Folder = Annotated[
    Path | None,
    output_option(
        "--output",
        "-o",
        metavar="DIR",
        parser=_folder,
        help="Writes files to this folder; run, compare, map, optimise and identify have one by default.",
    ),
]
Json = Annotated[bool, output_option("--json", help="Prints the results as JSON and writes no file.")]
Templates = Annotated[
    Path | None,
    output_option(
        "--templates",
        metavar="DIR",
        exists=True,
        file_okay=False,
        help="Uses the report templates of this folder first. Templates are code: use those you trust.",
    ),
]
Paper = Annotated[PaperSize, output_option(help="Sets the paper size of the PDF.")]
FigureWidth = Annotated[
    str | None,
    output_option(
        metavar="86mm",
        help="Draws figures this wide, for a column of a paper, where no page is written: --format png, svg or "
        "figure-pdf.",
    ),
]
Figures = Annotated[
    bool, output_option(help="Writes a report, with heat maps of a grid over two parameters, beside the cells.")
]
Force = Annotated[bool, output_option("--force", help="Replaces also files that vireport did not write.")]
Quiet = Annotated[bool, _messages("--quiet", "-q", help="Prints errors only, and what --json prints.")]
Verbose = Annotated[
    bool,
    _messages(
        "--verbose",
        "-v",
        help="Prints tables as well, and each step with its seconds on standard error.",
    ),
]

NOT_RECORDED = {"output", "templates", "figures", "force", "quiet", "verbose", "scheduler", "workers"}
"""Options that do not change the results."""

FILES = {"scenario", "scenarios", "file", "baseline", "impacts", "record"}
"""Arguments and options whose values are files: their folders do not change the results either."""


def _changed_options(context: typer.Context, names: Iterable[str]) -> Iterator[tuple[str, Any]]:
    """The parameters of a command among some that have another value than by default: how it is written, its value."""
    for parameter in context.command.params:
        value = context.params.get(parameter.name or "")
        if parameter.name in names and value != parameter.default and value not in (None, (), []):
            flag = parameter.opts[0] if parameter.param_type_name == "option" else ""
            yield (parameter.secondary_opts[0] if value is False else flag), value


def recorded(context: typer.Context) -> str:
    """Write the command for the record: without what does not change the results."""
    words = ["vireport", context.command.name or ""]
    for parameter in context.command.params:
        name = parameter.name or ""
        for flag, value in _changed_options(context, {name} - NOT_RECORDED):
            for one in value if isinstance(value, list | tuple) else [value]:
                text = [] if isinstance(one, bool) else [visible(Path(one).name if name in FILES else str(one))]
                words += [*filter(None, [flag]), *text]
    return join(words)


def refuse(context: typer.Context, why: str, *names: str) -> None:
    """Refuse options that were given, with what they do not go together with.

    Raises
    ------
    UsageError
        If one of them was given.
    """
    if flags := [flag for flag, _ in _changed_options(context, names)]:
        raise UsageError(f"{why}: leave out {' and '.join(flags)}")


def refuse_files_beside_json(context: typer.Context, what: str) -> None:
    """Refuse options that say which files are written, where JSON is printed."""
    if context.params.get("json"):
        refuse(context, f"--json prints the {what} and writes no file", "output", "format_", "figure_width")


def figure_width_mm(text: str | None, formats: "tuple[Task, ...]") -> float | None:
    """The width that figures are asked for with [mm]; None where they are those of a report."""
    if text is None:
        return None
    number = re.fullmatch(r"\s*(\d+(?:\.\d*)?)\s*(mm|cm|in)?\s*", text)
    if number is None:
        raise UsageError(f"--figure-width: {text!r} is no width (allowed: a number with mm, cm or in, such as 86mm)")
    from vireport.study.plan import FIGURE_FORMATS

    if {"html", "pdf"} & set(formats) or not set(formats) & set(FIGURE_FORMATS):
        raise UsageError(
            "--figure-width: figures of a report are as wide as its page (give --format with "
            f"{', '.join(FIGURE_FORMATS)}, and neither html nor pdf)"
        )
    from vireport.figures.style import Sheet

    width_mm = float(number[1]) * {"mm": 1.0, "cm": 10.0, "in": 25.4}[number[2] or "mm"]
    Sheet.of(width_mm)  # refuses what is too narrow or too wide
    return width_mm


def default_folder(scenario: str, suffix: str = "") -> Path:
    """Folder named after the scenario, in the current one; "report" where its name makes none."""
    name = "stdin" if scenario == "-" else Path(scenario).stem
    folder = Path((name if name.strip(".") else "report") + suffix)
    return folder.with_name(f"{folder.name}-report") if folder.is_file() else folder
