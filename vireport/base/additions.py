"""What can be taken out: each addition is its packages with their tests, templates and pages, and a row here.

`python tools/take_out.py NAME` shows in a copy of the project that the rest stands without one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

Declares = Literal["command", "finding", "keys"]


class AdditionRow(NamedTuple):
    """What an addition consists of.

    Attributes
    ----------
    packages : tuple of str
        The first is the one that declares what it brings.
    declares : tuple of str
        The modules of that package in which it does so: `command` has a command as `COMMAND`, `finding` has what it
        adds to a study as `FINDING`, and `keys` has what it adds to the keys of a scenario as `KEYS`.
    after : tuple of str
        The additions that it needs: without one of them it is left out as well.
    old_names : mapping of str to str
        The names that its command had, which go on working, and the option that each of them stands for, if any.
    """

    packages: tuple[str, ...]
    declares: tuple[Declares, ...]
    after: tuple[str, ...] = ()
    old_names: Mapping[str, str] = MappingProxyType({})


ROWS: Mapping[str, AdditionRow] = {
    "outcomes": AdditionRow(("findings.outcomes",), ("finding", "keys")),
    "certificates": AdditionRow(("findings.certificates",), ("finding",)),
    "checks": AdditionRow(("findings.accuracy",), ("finding", "keys")),
    "membranes": AdditionRow(("findings.membranes",), ("finding",), after=("checks",)),
    "driven": AdditionRow(("findings.driven",), ("finding",)),
    "proofs": AdditionRow(("findings.proofs",), ("finding",), after=("outcomes",)),
    "escape": AdditionRow(("findings.escape",), ("finding", "keys"), after=("outcomes",)),
    "tolerances": AdditionRow(("findings.tolerances",), ("finding", "keys")),
    "paper": AdditionRow(("paper",), ("command",)),
    "identify": AdditionRow(("identify",), ("command",)),
    "verify": AdditionRow(("verify",), ("command",), ("checks",), {"accuracy": "", "extremes": "--extremes"}),
    "compare": AdditionRow(("comparison",), ("command",), old_names={"diff": "--exit-code"}),
    "map": AdditionRow(("map",), ("command",), old_names={"chart": "", "sweep": ""}),
    "optimise": AdditionRow(("optimise",), ("command",)),
    "explore": AdditionRow(("bench",), ("command",)),
}
"""Each addition by the name of its command, in the order of the help, or of its block in results.json, in the order in
which a report has them. A key of a scenario that names an addition is known where the addition is."""


def complete(rows: Mapping[str, AdditionRow]) -> Mapping[str, AdditionRow]:
    """The rows of additions all of which have what they need."""
    kept = {name: row for name, row in rows.items() if all(needed in rows for needed in row.after)}
    return kept if len(kept) == len(rows) else complete(kept)


ADDITIONS = complete(ROWS)
"""The additions that there are."""


def adding(what: Declares) -> tuple[str, ...]:
    """The names of the additions that declare something of a kind, in the order of their rows."""
    return tuple(name for name, row in ADDITIONS.items() if what in row.declares)


def declaration(name: str, what: Declares) -> Any:
    """What an addition declares of a kind; its module is imported for it."""
    return getattr(import_module(f"vireport.{ADDITIONS[name].packages[0]}.{what}"), what.upper())


def declared(what: Declares) -> Iterator[Any]:
    """What all additions declare of a kind, in the order of their rows."""
    return (declaration(name, what) for name in adding(what))
