"""The commands that packages bring with them, each a row of `base.additions`, and which formats a command writes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from typer.core import TyperCommand

from vireport.base.additions import ADDITIONS
from vireport.base.errors import UsageError
from vireport.command.formats import RUN, CommandFormats
from vireport.command.options import OptionPanel

if TYPE_CHECKING:
    from vireport.study.plan import Task


class CommandPanel(StrEnum):
    """What a command is for: the headings of the list of commands, in their order."""

    ONE = "One device"
    SEVERAL = "Several devices"
    MEASURED = "Measurement and accuracy"
    HELP = "Scenarios and terms"


class Command(TyperCommand):
    """A command whose help groups its options; Typer itself would need Rich for it."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """List the options: those of the command, of what is written, and of what is said."""
        rows = [(getattr(x, "rich_help_panel", None), x.get_help_record(ctx)) for x in self.get_params(ctx)]
        for panel in (None, *OptionPanel):
            if listed := [row for group, row in rows if row is not None and group is panel]:
                with formatter.section(panel or "Options"):
                    formatter.write_dl(listed)


class DeclaredCommand(Struct, frozen=True):
    """A command of a package that can be taken out.

    Attributes
    ----------
    name : str
    function : callable
        Its parameters are its options, its docstring is its help.
    panel : CommandPanel
    formats : tuple of CommandFormats
        Those of its `--format`.
    old_names : mapping
        Names that it had, each with the words that stand for it now.
    """

    name: str
    function: Callable[..., None]
    panel: CommandPanel
    formats: tuple[CommandFormats, ...] = ()
    old_names: Mapping[str, list[str]] = {}


@cache
def declared_commands() -> tuple[DeclaredCommand, ...]:
    """The commands of the packages that are rows of `base.additions`."""
    return tuple(import_module(f"vireport.{package}.command").COMMAND for package, *_ in ADDITIONS.values())


def formats_of(formats: CommandFormats, requested: list[str] | None) -> tuple[Task, ...]:
    """The formats that a command writes: those requested, or the usual ones where `--format` is not given.

    Raises
    ------
    UsageError
        For a word that is no format, a format that the command does not have, and where no format is named.
    """
    from vireport.study.plan import Task

    if not requested:
        return tuple(map(Task, formats.usual))
    words = [word.strip() for part in requested for word in part.split(",") if word.strip()]
    allowed = f"allowed: {', '.join(formats.allowed)}"
    if not words:
        raise UsageError(f"--format: no format is named ({allowed})")
    known = [RUN, *(other for command in declared_commands() for other in command.formats)]
    unknown = [word for word in words if not any(word in other.allowed for other in known)]
    if unknown:
        raise UsageError(f"--format: unknown {', '.join(map(repr, unknown))} ({allowed})")
    for word in words:
        if word not in formats.allowed:
            others = [other.command for other in known if word in other.allowed]
            raise UsageError(
                f"--format: vireport {formats.command} has no {word} ({allowed}; {word} is written by vireport "
                f"{', '.join(others)})"
            )
    return tuple(Task(word) for word in formats.allowed if word in words)
