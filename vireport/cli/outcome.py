"""What commands do with their results: progress while they work, then files, printed text, a summary, an exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import typer
from msgspec import Struct, field

from vireport.base import interrupts, write_files
from vireport.text import visible

if TYPE_CHECKING:
    from vireport.base import Progress

REPORT = "report.html"
"""The file that a reader opens first."""

RED, BOLD, PLAIN = "\x1b[31m", "\x1b[1m", "\x1b[0m"


class CommandOutcome(Struct, frozen=True, eq=False):
    """What a command comes to, before anything of it is printed or written.

    Attributes
    ----------
    printed : str or bytes
        For standard output.
    files : mapping of str to bytes
        Contents of the files to write, by their names.
    summary : str
        For standard output, unless nothing but errors is to be said; for standard error where results are printed.
    failure : str
        Why the exit code is not 0, said where the summary is not.
    exit_code : int
    stale : tuple of str
        Files that this command may write: those of an earlier run go, also where it wrote none.
    beside : tuple of str
        Files that other options would have written: those of an earlier run stay, and are named.
    """

    printed: str | bytes = b""
    files: Mapping[str, bytes] = field(default_factory=dict)
    summary: str = ""
    failure: str = ""
    exit_code: int = 0
    stale: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()


def deliver(outcome: CommandOutcome, folder: Path | None = None, quiet: bool = False) -> None:
    """Print and write what a command comes to, and leave with its exit code.

    Parameters
    ----------
    outcome : CommandOutcome
    folder : Path, optional
        Where the files go; created if there are any.
    quiet : bool
        Whether to say nothing but errors.

    Raises
    ------
    UsageError, OutputError
        If the folder cannot be written to.
    typer.Exit
        If the exit code is not 0.
    """
    interrupts.check()
    if folder is None or not outcome.files:
        _say(outcome, [], quiet)
    else:
        write_files(folder, outcome.files, outcome.stale)
        # From here on an interrupt must not say that no file was written.
        try:
            _say(outcome, list(_written(outcome, folder)), quiet)
        except KeyboardInterrupt:
            raise KeyboardInterrupt("all files were written") from None
    if outcome.exit_code:
        raise typer.Exit(outcome.exit_code)


def _written(outcome: CommandOutcome, folder: Path) -> Iterator[str]:
    yield f"wrote {', '.join(str(folder / name) for name in outcome.files)}"
    if earlier := [name for name in outcome.beside if (folder / name).exists()]:
        yield f"of an earlier run, and left as they are: {', '.join(earlier)}"
    if REPORT in outcome.files and sys.stderr.isatty():
        yield f"open {(folder / REPORT).resolve().as_uri()}"


def _say(outcome: CommandOutcome, written: Sequence[str], quiet: bool) -> None:
    """Print the results or the summary on standard output, and what was written on standard error."""
    emit(outcome.printed)
    summary = outcome.summary.splitlines()
    if quiet or not (summary or written):
        if outcome.failure:
            tell([f"vireport: {outcome.failure}"], RED)
        return
    color = RED if outcome.failure else BOLD
    # Where results are printed they stay alone there, as a script reads them.
    if summary and outcome.printed:
        tell(summary, color)
    elif summary:
        emit("\n".join(_colored(summary, color, sys.stdout)) + "\n")
    if written:
        tell(written, "" if summary else color)


def emit(data: str | bytes) -> None:
    """Write to standard output, as UTF-8."""
    if data:
        sys.stdout.flush()
        sys.stdout.buffer.write(data.encode("utf-8", "backslashreplace") if isinstance(data, str) else data)
        sys.stdout.buffer.flush()


def tell(lines: Iterable[str], color: str = "") -> None:
    """Write lines to standard error, in which there may be text that is not ours; the first in colour on a terminal."""
    print("\n".join(_colored(lines, color, sys.stderr)), file=sys.stderr)


def _colored(lines: Iterable[str], color: str, stream: TextIO) -> list[str]:
    first, *others = map(visible, lines)
    if color and stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb":
        first = f"{color}{first}{PLAIN}"
    return [first, *others]


@contextmanager
def progress(quiet: bool) -> Iterator[Progress]:
    """What is told each step: shown on one line of a terminal, of which nothing is left, and nowhere else."""
    if quiet or not sys.stderr.isatty():
        yield lambda what: interrupts.check()
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    # Redrawn only at each step: a thread that draws a spinner would be in the way where times are measured.
    with Live(console=Console(stderr=True), auto_refresh=False, transient=True) as line:

        def show(what: str) -> None:
            interrupts.check()
            line.update(Text(visible(what), overflow="ellipsis", no_wrap=True), refresh=True)

        yield show
