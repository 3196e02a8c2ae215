"""The group of commands: what its first word may be, and how its help is set."""

from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from shlex import join
from typing import Any, cast

from typer import Typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from vireport.base.additions import ADDITIONS
from vireport.base.errors import UsageError
from vireport.cli.declared import CommandPanel

PROGRAM = "vireport"

LONGEST_HELP = 200
"""Characters of what the list of commands tells of each: none is cut."""

OLD_NAMES: Mapping[str, list[str]] = {
    "validate": ["check"],
    "plan": ["check"],
    "schema": ["init", "--schema"],
    **{old: [name, *option.split()] for name, row in ADDITIONS.items() for old, option in row.old_names.items()},
}
"""Names that commands had: they go on working."""

MEANT = {"maps": "map", "optimize": "optimise", "report": "run", "help": "--help"}
"""What other words for commands mean."""

NO_PORTRAIT = (
    "vireport portrait is no more (vireport run FILE --set 'motions.portraits=[BT]' draws motions by their words, "
    "vireport explore FILE the motion at any value)"
)


class Commands(Mapping[str, TyperCommand]):
    """Commands by their names, each built when it is first asked for.

    Parameters
    ----------
    builders : mapping of str to callable
        What makes each of them.
    """

    def __init__(self, builders: Mapping[str, Callable[[], Typer]]) -> None:
        self.builders, self.built = builders, dict[str, Any]()

    def __getitem__(self, name: str) -> TyperCommand:
        if name not in self.built:
            self.built[name] = get_command(self.builders[name]())
        return cast(TyperCommand, self.built[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self.builders)

    def __len__(self) -> int:
        return len(self.builders)

    def __contains__(self, name: object) -> bool:
        return name in self.builders


class Program(TyperGroup):
    """Commands, with `run` understood where the first word is none of them."""

    group_only = frozenset({"--help", "-h", "--version", "-V", "--install-completion", "--show-completion"})

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the new name of a command in place of an old one, and `run` before anything that is none."""
        first, *others = args or [""]
        if first in OLD_NAMES:
            args = [*OLD_NAMES[first], *others]
        elif args and first not in self.commands and first not in self.group_only:
            if not ctx.resilient_parsing:  # as it is while a shell completes a line
                self._refuse_misspelt_command(first, others)
            args = ["run", *args]
        return super().parse_args(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands by what they are for; Typer itself would need Rich for it."""
        for panel in CommandPanel:
            with formatter.section(panel):
                commands: list[tuple[str, Any]] = list(self.commands.items())
                of_panel = [(name, command) for name, command in commands if command.rich_help_panel is panel]
                formatter.write_dl([(name, command.get_short_help_str(LONGEST_HELP)) for name, command in of_panel])

    def _refuse_misspelt_command(self, word: str, others: list[str]) -> None:
        if word == "portrait":
            raise UsageError(NO_PORTRAIT)
        if others and others[0] in (*self.commands, *OLD_NAMES) and not Path(others[0]).exists():
            raise UsageError(f"the command comes first: {join([PROGRAM, others[0], word, *others[1:]])}")
        if word.startswith("-") or Path(word).exists():
            return
        if word in MEANT:
            raise UsageError(f"there is no command '{word}'; did you mean '{MEANT[word]}'?")
        if close := get_close_matches(word, [*self.commands, *OLD_NAMES], 1):
            raise UsageError(f"no such file '{word}'; did you mean the command '{close[0]}'?")
        if others and Path(others[0]).exists():
            raise UsageError(f"there is no command '{word}' (allowed: {', '.join(self.commands)})")
