"""A scenario on the bench: the file as it was opened, and the values that were changed by hand."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from msgspec import Struct, to_builtins

from vireport.base.errors import ScenarioError, UsageError, VireportError
from vireport.base.files import writable, write_new
from vireport.base.reading import ReadingPlace
from vireport.base.version import __version__
from vireport.bench.answers import first_answer
from vireport.bench.controls import CHOICES, controls_of, ends_of
from vireport.bench.jobs import Aside, Asked, Job
from vireport.scenario.blocks import Scenario, to_dict
from vireport.scenario.loading import Loaded, LoadedMap, load_any, loads
from vireport.scenario.overrides import as_texts
from vireport.scenario.parameters import DesignInput, Parameter, ScalarInput
from vireport.scenario.rules import ADDED_IF_FULL
from vireport.scenario.writing import as_yaml, with_paths

NOT_HERE = {
    "accuracy": "vireport verify measures error against run time",
    "design": "vireport optimise looks for the best design",
}
"""Blocks of a scenario that the bench leaves out, and the command that does what they ask for."""

OPTIONAL = "requirements", "tolerances"
"""Blocks whose keys a page can take away one by one."""

MODULES = "elements.js", "panels.js", "sketch.js", "bench.js"
"""The modules that draw a page, each after those that it imports."""

NAME = re.compile(r"\w[\w .-]{0,59}")
"""What a file that is saved may be called, without its ending."""

State = Mapping[str, Any]
"""Values changed on a page, by their paths; None for a key that is removed."""


class Opened(Struct, frozen=True):
    """A scenario as it was opened.

    Attributes
    ----------
    text, name : str
        The file.
    overrides : tuple of str
        Overrides before any change on the page, as ``path=value``.
    notes : tuple of str
        What of it is left out on the bench, and which command does it.
    stated_keys : frozenset of str
        Paths of the keys that it gives.
    place : ReadingPlace
        Where the records that it names are looked for.
    """

    text: str
    name: str
    overrides: tuple[str, ...]
    notes: tuple[str, ...]
    stated_keys: frozenset[str]
    place: ReadingPlace

    def over(self, state: State) -> tuple[str, ...]:
        """All overrides of the file in a state of the page.

        A block of which every key is taken away goes as a whole: an empty one would be a mistake.
        """
        emptied = (f"{block}=" for block in OPTIONAL if self._empties(state, block))
        return (*self.overrides, *as_texts(state), *emptied)

    def _empties(self, state: State, block: str) -> bool:
        changed = {path for path in state if path.startswith(f"{block}.")}
        left = {path for path in self.stated_keys if path.startswith(f"{block}.")} - changed
        return bool(changed) and not left and all(state[path] is None for path in changed)


def opened(source: str | Path | Loaded, overrides: tuple[str, ...] = (), allow_outside: bool = False) -> Opened:
    """Open a scenario for the bench.

    Parameters
    ----------
    source : str, Path or Loaded
        The file, or what was loaded of it.
    overrides : tuple of str
        Overrides of a file, as ``path=value``.
    allow_outside : bool
        Whether records that a file names may be outside of its folder.

    Raises
    ------
    UsageError
        Where there is no such file, or it is a map.
    ScenarioError
        Where the scenario cannot be used.
    """
    loaded = source if isinstance(source, Loaded) else load_any(source, overrides, allow_outside)
    if isinstance(loaded, LoadedMap):
        raise UsageError(f"{loaded.name}: has a map block: the bench shows one design (vireport map computes the map)")
    blocks = [block for block in NOT_HERE if getattr(loaded.scenario, block) is not None]
    over = (*loaded.overrides, *(f"{block}=" for block in blocks))
    notes = tuple(f"The block {block} has no part here: {NOT_HERE[block]}." for block in blocks)
    return Opened(loaded.document.text, loaded.document.name, over, notes, loaded.stated_keys, loaded.place)


def loaded_of(session: Opened, state: State) -> Loaded:
    """The scenario with what a state of the sliders sets over it.

    Raises
    ------
    ScenarioError
        With every mistake in it.
    """
    return loads(session.text, session.name, session.over(state), session.place)


def start_data(session: Opened) -> dict[str, object]:
    """What a page begins with: the controls, what can be swept or added, and what is left out."""
    scenario = loaded_of(session, {}).scenario
    return {
        "title": scenario.title or session.name,
        "name": session.name,
        "version": __version__,
        "notes": list(session.notes),
        "controls": [to_builtins(control) for control in controls_of(scenario)],
        "may_be_added": list(ADDED_IF_FULL),
        "choices": {path: list(words) for path, words in CHOICES.items()},
        "inputs": [_named(scenario, varied) for varied in DesignInput],
        "sweepable": [_named(scenario, parameter) for parameter in Parameter],
    }


def _named(scenario: Scenario, varied: ScalarInput) -> dict[str, object]:
    """An input in words, and from where to where it is moved."""
    low, high = ends_of(scenario, varied)
    named = {"key": varied.value, "path": varied.path, "quantity": varied.quantity}
    return {**named, "symbol": varied.symbol, "unit": varied.unit, "from": low, "to": high}


def first(session: Opened, state: State) -> dict[str, object]:
    """The first answer of a state, see `answers.first_answer`."""
    return first_answer(loaded_of(session, state))


def job_of(session: Opened, kind: Aside, question: Asked) -> Job:
    """A question about a state, for the process that answers it."""
    return Job(
        kind, session.text, session.name, session.over(question.state), session.place, question.axes, question.ranges
    )


def refusal(error: VireportError) -> dict[str, object]:
    """What a page is told where there is no answer: each mistake with the path of its control, if it has one.

    Of many mistakes it is told the first, and how many more there are.
    """
    if isinstance(error, ScenarioError):
        mistakes = [{"path": mistake.path, "message": mistake.message} for mistake in error.mistakes]
        if error.more:
            mistakes.append({"path": "", "message": f"There are {error.more} more mistakes."})
    else:
        mistakes = [{"path": "", "message": line} for line in error.lines]
    return {"refused": mistakes}


def require_new(folder: Path) -> None:
    """Refuse to write a report where there is something.

    Raises
    ------
    UsageError
    """
    with writable(folder):
        if folder.is_file() or (folder.is_dir() and any(folder.iterdir())):
            raise UsageError(f"{folder} exists already (give another name)")


def save(session: Opened, state: State, name: str, folder: Path) -> Path:
    """Write the scenario of a state to a new file, with paths of records that lead to the same files from there.

    Parameters
    ----------
    session : Opened
    state : State
    name : str
        Of the file, without its ending and without a folder.
    folder : Path
        Made where there is none.

    Raises
    ------
    UsageError
        For another name, one that is taken, a folder that cannot be written to, or a record outside of the scenario's.
    ScenarioError
        Where the scenario cannot be used.
    """
    if not NAME.fullmatch(name):
        raise UsageError(f"{name!r} is no name for a file (allowed: letters, digits, spaces, . _ and -, at most 60)")
    scenario = to_dict(loaded_of(session, state).scenario)
    text = as_yaml(with_paths(scenario, partial(session.place.path_from, str(folder))))
    path = folder / f"{name}.yaml"
    with writable(path):
        folder.mkdir(parents=True, exist_ok=True)
        try:
            write_new(path, text.encode())
        except FileExistsError as error:
            raise UsageError(f"{path} exists already (give another name)") from error
    return path
