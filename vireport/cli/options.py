"""What the commands share: their options, reading a scenario, and talking to the terminal."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vireport.errors import UsageError

if TYPE_CHECKING:
    from vireport.scenario import Loaded

ScenarioFile = Annotated[str, typer.Argument(metavar="SCENARIO", help="A YAML file, or - for standard input.")]
Overrides = Annotated[
    list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Set a value over the file's; may be repeated.")
]
Formats = Annotated[
    list[str] | None,
    typer.Option(
        "--format",
        metavar="FORMAT",
        help="Write only these: html, pdf, png, json, csv; junit, markdown, github for CI; commas, or repeated.",
    ),
]
Templates = Annotated[
    Path | None,
    typer.Option("--templates", metavar="DIR", help="A folder whose report templates replace ours, file by file."),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print the results as JSON, and write no file.")]


def load(scenario: str, overrides: list[str] | None) -> Loaded:
    """Read a scenario and what is set over it."""
    from vireport.scenario import loading as reader

    return reader.load(scenario, overrides or ())


def formats_of(asked: list[str] | None) -> tuple[str, ...]:
    """The outputs asked for, the usual ones where none are."""
    from vireport.study import (
        ALL_FORMATS,
        FORMATS,
    )

    words = [word.strip() for part in asked or [] for word in part.split(",") if word.strip()]
    unknown = [word for word in words if word not in ALL_FORMATS]
    if unknown:
        raise UsageError(f"--format: unknown {', '.join(map(repr, unknown))} (allowed: {', '.join(ALL_FORMATS)})")
    return tuple(name for name in ALL_FORMATS if name in words) or FORMATS


def show(what: str) -> None:
    """Show a step on one line of the terminal; nothing is left of it afterwards."""
    sys.stderr.write(f"\r\x1b[K{what}")
    sys.stderr.flush()


def emit(data: bytes) -> None:
    """Write to standard output, and not mind a reader that has gone."""
    try:
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        # What is still buffered must not raise again when the interpreter closes the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def command_of(command: str, files: list[str], *options: tuple[str, list[str] | bool | None]) -> str:
    """The command for the record: without the folders, which do not change the results."""
    from shlex import join

    words = ["vireport", command, *(name if name == "-" else Path(name).name for name in files)]
    for option, values in options:
        words += [option] if values is True else [word for value in values or [] for word in (option, value)]
    return join(words)
