"""Which command writes which formats: what `--format` of each allows, writes by default, and says in its help.

The words are those of `study.Task`, which is imported when a command is run, and not for its help.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from vireport.base.errors import UsageError
from vireport.cli.options import output_option

if TYPE_CHECKING:
    from vireport.study.plan import Task

PAGES = "html", "pdf"
FIGURES = "png", "svg", "figure-pdf"


class CommandFormats(NamedTuple):
    """The formats of a command.

    Attributes
    ----------
    allowed : tuple of str
        In the order in which they are listed.
    usual : tuple of str
        What is written where none is asked for.
    always : str
        What is written whatever is asked for, in words; "" where that is nothing.
    """

    allowed: tuple[str, ...]
    usual: tuple[str, ...]
    always: str = ""


RUN = CommandFormats(
    (*PAGES, "png", "json", "csv", "svg", "figure-pdf", "junit", "markdown", "github"),
    (*PAGES, "png", "json", "csv"),
)

FORMATS: Mapping[str, CommandFormats] = {
    "run": RUN,
    "check": RUN,
    "compare": CommandFormats((*PAGES, *FIGURES, "json", "csv", "markdown"), (*PAGES, "png", "json", "csv")),
    "map --over": CommandFormats((*PAGES, *FIGURES, "json", "markdown"), (*PAGES, "png", "svg", "json", "markdown")),
    "map": CommandFormats((*PAGES, *FIGURES), (*PAGES, "png"), "the cells"),
    "optimise": CommandFormats((*PAGES, *FIGURES), (*PAGES, "png"), "best.yaml and optimise.json"),
}
"""The formats of each command that has `--format`."""


def format_option(command: str) -> Any:
    """The option `--format` of a command."""
    own, over = FORMATS[command], FORMATS.get(f"{command} --over")
    beside = f" beside {own.always}" if own.always else ""
    curves = "" if over is None else f"; with --over {', '.join(over.allowed)}"
    return output_option(
        "--format",
        metavar="FORMAT",
        help=f"Writes only these formats{beside}, separated by commas: {', '.join(own.allowed)}{curves}.",
    )


def formats_of(command: str, requested: list[str] | None) -> tuple[Task, ...]:
    """The formats that a command writes: those requested, or the usual ones where `--format` is not given.

    Raises
    ------
    UsageError
        For a word that is no format, a format that the command does not have, and where none is named.
    """
    from vireport.study.plan import Task

    own = FORMATS[command]
    if not requested:
        return tuple(map(Task, own.usual))
    words = [word.strip() for part in requested for word in part.split(",") if word.strip()]
    allowed = f"allowed: {', '.join(own.allowed)}"
    if not words:
        raise UsageError(f"--format: no format is named ({allowed})")
    unknown = [word for word in words if not any(word in other.allowed for other in FORMATS.values())]
    if unknown:
        raise UsageError(f"--format: unknown {', '.join(map(repr, unknown))} ({allowed})")
    for word in words:
        if word not in own.allowed:
            others = [name for name in FORMATS if word in FORMATS[name].allowed and name != "check"]
            raise UsageError(
                f"--format: vireport {command} has no {word} ({allowed}; {word} is written by vireport "
                f"{', '.join(others)})"
            )
    return tuple(Task(word) for word in own.allowed if word in words)
