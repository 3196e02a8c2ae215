"""What commands do with their results: progress while they work, then files, printed text, a summary, an exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from datetime import timedelta
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, TextIO

import typer
from msgspec import Struct, field

from vireport.base import interrupts
from vireport.base.errors import UsageError
from vireport.base.files import write_files
from vireport.base.progress import WorkStep
from vireport.text.foreign import visible

if TYPE_CHECKING:
    from rich.console import RenderableType

    from vireport.base.progress import Progress
    from vireport.scenario.loading import Loaded

REPORT = "report.html"
"""The file that a reader opens first."""

TELLING = 0.01
"""Share of the work from which on its time tells how long the rest will take."""

BAR = 20
"""Characters of the bar that shows which share of the work is done."""

RED, BOLD, PLAIN = "\x1b[31m", "\x1b[1m", "\x1b[0m"


class CommandOutcome(Struct, frozen=True, eq=False):
    """What a command comes to, before anything of it is printed or written.

    Attributes
    ----------
    printed : str or bytes
        For standard output, whatever is asked for: data, and texts that a command is for.
    text : str
        For a reader, on standard output, unless nothing but errors is to be said.
    files : mapping of str to bytes
        Contents of the files to write, by their names.
    summary : str
        As `text`; for standard error where anything else is printed.
    failure : str
        Why the exit code is not 0, said where the summary is not.
    exit_code : int
    stale : tuple of str
        Files that this command may write: those of an earlier run go, also where it wrote none.
    other_files : tuple of str
        Files that other options would have written: those of an earlier run stay, and are named.
    """

    printed: str | bytes = b""
    text: str = ""
    files: Mapping[str, bytes] = field(default_factory=dict)
    summary: str = ""
    failure: str = ""
    exit_code: int = 0
    stale: tuple[str, ...] = ()
    other_files: tuple[str, ...] = ()


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
    if earlier := [name for name in outcome.other_files if (folder / name).exists()]:
        yield f"of an earlier run, and left as they are: {', '.join(earlier)}"
    if REPORT in outcome.files and sys.stderr.isatty():
        yield f"open {(folder / REPORT).resolve().as_uri()}"


def _say(outcome: CommandOutcome, written: Sequence[str], quiet: bool) -> None:
    """Print the results or the summary on standard output, and what was written on standard error."""
    emit(outcome.printed)
    if not quiet:
        emit(outcome.text)
    summary = outcome.summary.splitlines()
    if quiet or not (summary or written):
        if outcome.failure:
            tell([f"vireport: {outcome.failure}"], RED)
        return
    color = RED if outcome.failure else BOLD
    # Where results are printed they stay alone there, as a script reads them.
    if summary and (outcome.printed or outcome.text):
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


def tell_lacking(loaded: Loaded, formats: Iterable[str], quiet: bool) -> None:
    """Say before work begins what missing packages leave out or slow down, with the commands that install them."""
    from vireport.study.plan import plan

    lines = plan(loaded.scenario, formats).lacking
    if lines and not quiet:
        tell([f"vireport: {line}" for line in lines])


def _colored(lines: Iterable[str], color: str, stream: TextIO) -> list[str]:
    first, *others = map(visible, lines)
    if color and stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb":
        first = f"{color}{first}{PLAIN}"
    return [first, *others]


@contextmanager
def progress(quiet: bool, verbose: bool = False) -> Iterator[Progress]:
    """A callable for the steps of a command: each is shown on one line of a terminal, of which nothing is left.

    Parameters
    ----------
    quiet : bool
        Whether to show nothing.
    verbose : bool
        Whether to write each step to standard error as it ends, with its seconds, terminal or not.

    Raises
    ------
    UsageError
        If both are asked for.
    """
    if quiet and verbose:
        raise UsageError("--quiet and --verbose: one of them (leave the other out)")
    printer = nullcontext() if quiet or not sys.stderr.isatty() else _on_one_line()
    with printer as show, _logged() if verbose else nullcontext() as log:

        def say(what: str) -> None:
            interrupts.check()
            for reporter in (log, show):
                if reporter is not None:
                    reporter(what)

        yield say


@contextmanager
def _on_one_line() -> Iterator[Progress]:
    """The step that is under way, and from when it is known the share of the work that is done and the time left."""
    from rich.console import Console
    from rich.live import Live
    from rich.progress_bar import ProgressBar
    from rich.table import Column, Table
    from rich.text import Text

    reports: list[tuple[float, float]] = []  # when a share was told, and which
    # Redrawn only at each step: a thread that draws a spinner would be in the way where times are measured.
    with Live(console=Console(stderr=True), auto_refresh=False, transient=True) as line:

        def show(what: str) -> None:
            step = WorkStep.of(what)
            if step.share is not None:
                reports.append((perf_counter(), step.share))
            cells: list[RenderableType] = [Text(visible(step), overflow="ellipsis", no_wrap=True)]
            if reports:
                # From the first share that was told, which of a map that is resumed is what was there before.
                (begun, before), (_, done) = reports[0], reports[-1]
                seconds = (perf_counter() - begun) * (1 - done) / (done - before) if done - before > TELLING else None
                left = "" if seconds is None else f", {timedelta(seconds=round(seconds))} left"
                share = Text(f"{int(100 * done):3d} %{left}", no_wrap=True)
                cells += [ProgressBar(total=1.0, completed=done, width=BAR), share]
            row = Table.grid(Column(ratio=1), padding=(0, 1), expand=True)
            row.add_row(*cells)
            line.update(row, refresh=True)

        yield show


@contextmanager
def _logged() -> Iterator[Progress]:
    """Each step with its seconds, as it ends; alike ones that follow one another are one, and all of them at last."""
    begun = first = perf_counter()
    under_way = ""

    def end() -> None:
        if under_way:
            tell([f"{perf_counter() - begun:8.2f} s  {under_way}"])

    def log(what: str) -> None:
        nonlocal begun, under_way
        name = WorkStep.of(what).name
        if name != under_way:
            end()
            begun, under_way = perf_counter(), name

    yield log
    end()
    tell([f"{perf_counter() - first:8.2f} s  in all"])
