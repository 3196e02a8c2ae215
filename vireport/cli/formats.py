"""The formats that a command writes: what `--format` allows, what is written by default, and what its help says.

The words are those of `study.Task`, which is imported when a command is run, and not for its help.
"""

from __future__ import annotations

from msgspec import Struct

from vireport.cli.options import output_option

PAGES = "html", "pdf"
FIGURES = "png", "svg", "figure-pdf"


class CommandFormats(Struct, frozen=True):
    """The output formats that a command allows, and those that it writes by default.

    Attributes
    ----------
    command : str
        As it is typed, with the option that has formats of its own.
    allowed : tuple of str
        In the order in which they are listed.
    usual : tuple of str
        What is written where `--format` is not given.
    always : str
        What is written in any case, in words; "" where that is nothing.
    """

    command: str
    allowed: tuple[str, ...]
    usual: tuple[str, ...]
    always: str = ""


RUN = CommandFormats(
    "run",
    (*PAGES, "png", "json", "csv", "svg", "figure-pdf", "junit", "markdown", "github"),
    (*PAGES, "png", "json", "csv"),
)


def format_option(formats: CommandFormats, over: CommandFormats | None = None) -> object:
    """The option `--format` of a command, which may have other formats with `--over`."""
    besides = f" beside {formats.always}" if formats.always else ""
    curves = "" if over is None else f"; with --over {', '.join(over.allowed)}"
    return output_option(
        "--format",
        metavar="FORMAT",
        help=f"Writes only these formats{besides}, separated by commas: {', '.join(formats.allowed)}{curves}.",
    )
