"""The commands that packages bring with them, each a row of `base.additions`, and which formats a command writes."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from typer.core import TyperCommand

from vireport.base.additions import adding, declaration
from vireport.base.errors import UsageError
from vireport.cli.formats import RUN, CommandFormats
from vireport.cli.options import OptionPanel

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
    """

    name: str
    function: Callable[..., None]
    panel: CommandPanel
    formats: tuple[CommandFormats, ...] = ()


def declared_command(name: str) -> DeclaredCommand:
    """The command of a row of `base.additions`, whose module is imported."""
    command: DeclaredCommand = declaration(name, "command")
    return command


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
    if others := [word for word in words if word not in formats.allowed]:
        rows = [RUN, *(row for name in adding("command") for row in declared_command(name).formats)]
        unknown = [word for word in others if not any(word in row.allowed for row in rows)]
        if unknown:
            raise UsageError(f"--format: unknown {', '.join(map(repr, unknown))} ({allowed})")
        commands = ", ".join(row.command for row in rows if others[0] in row.allowed)
        raise UsageError(
            f"--format: vireport {formats.command} has no {others[0]} ({allowed}; {others[0]} is written by vireport "
            f"{commands})"
        )
    return tuple(Task(word) for word in formats.allowed if word in words)
