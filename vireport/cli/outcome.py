"""What commands do with their results: progress while they work, then files, printed text, a summary, an exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from vireport.progress import Progress


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a command comes to, before anything of it is printed or written.

    Attributes
    ----------
    printed : str or bytes
        For standard output.
    files : mapping of str to bytes
        Contents of the files to write, by their names.
    summary : str
        For standard error, unless nothing but errors is to be said.
    failure : str
        Why the exit code is 1, said where the summary is not.
    exit_code : int
    """

    printed: str | bytes = b""
    files: Mapping[str, bytes] = field(default_factory=dict)
    summary: str = ""
    failure: str = ""
    exit_code: int = 0


def deliver(outcome: Outcome, folder: Path | None = None, quiet: bool = False) -> None:
    """Print and write what a command comes to, and leave with its exit code.

    Parameters
    ----------
    outcome : Outcome
    folder : Path, optional
        Where the files go; created if there are any.
    quiet : bool
        Whether to say nothing but errors.

    Raises
    ------
    UsageError
        If the folder cannot be written to.
    typer.Exit
        If the exit code is not 0.
    """
    emit(outcome.printed)
    summary = [outcome.summary] if outcome.summary else []
    if folder is not None and outcome.files:
        from vireport.files import write_files

        write_files(folder, outcome.files)
        summary.append(f"wrote {', '.join(str(folder / name) for name in outcome.files)}")
    if summary and not quiet:
        print("\n".join(summary), file=sys.stderr)
    elif outcome.failure:
        print(f"vireport: {outcome.failure}", file=sys.stderr)
    if outcome.exit_code:
        raise typer.Exit(outcome.exit_code)


def emit(data: str | bytes) -> None:
    """Write to standard output as UTF-8, and not mind a reader that has gone."""
    try:
        sys.stdout.flush()
        sys.stdout.buffer.write(data.encode() if isinstance(data, str) else data)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        # What is still buffered must not raise again when the interpreter closes the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def progress(quiet: bool) -> Iterator[Progress]:
    """What is told each step: shown on one line of a terminal, of which nothing is left, and nowhere else."""
    if quiet or not sys.stderr.isatty():
        yield lambda what: None
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    # Redrawn only at each step: a thread that draws a spinner would be in the way where times are measured.
    with Live(console=Console(stderr=True), auto_refresh=False, transient=True) as line:
        yield lambda what: line.update(Text(what, overflow="ellipsis", no_wrap=True), refresh=True)
