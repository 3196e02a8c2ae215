"""Reads scenarios and map files, with values set on the command line, into validated, frozen values in SI units.

If a file cannot be used, every mistake in it is reported at once, by line and key. Nothing here knows what is computed
from it.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from copy import deepcopy
from functools import reduce
from hashlib import sha256
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from msgspec import Struct
from msgspec.structs import replace
from pydantic import ValidationError

from vireport.base.additions import ADDITIONS
from vireport.base.errors import Mistake, ScenarioError, UsageError
from vireport.base.reading import ReadingPlace
from vireport.scenario.blocks import (
    AxisPath,
    Scenario,
    keys_left_out,
)
from vireport.scenario.document import (
    LARGEST_FILE,
    Document,
    is_within,
    join,
    read,
)
from vireport.scenario.overrides import apply, as_texts, yaml_of
from vireport.scenario.rules import (
    ADDED_IF_FULL,
    AXES,
    Finding,
    Kind,
    barred_blocks,
    inconsistencies,
    is_number,
    path_of,
    rows_of,
)
from vireport.text.foreign import visible

if TYPE_CHECKING:
    from vireport.scenario.map_file import MapBlock

MOST_NAMES = 1_000  # files of a folder that are compared with the name of a missing one

LONGEST_NAME = 60
"""Largest number of characters that are shown of a text that is no name of a file."""

Source = str | Path | Mapping[str, object]
Overrides = str | Sequence[str] | Mapping[str, object]
FileModel = TypeVar("FileModel", bound=Scenario)


class Loaded(Struct, frozen=True):
    """A validated scenario, with the file and the overrides that it came from.

    Attributes
    ----------
    scenario : Scenario
        The scenario as understood, defaults filled in.
    document : Document
        The file as it was read, before overrides.
    stated_keys : frozenset of str
        Dotted paths of all keys and blocks that the file or an override gives; the others have defaults.
    overrides : tuple of str
        Values that replaced those of the file, as ``path=value``, in their order.
    place : ReadingPlace
        Place of the files that the scenario names.
    """

    scenario: Scenario
    document: Document
    stated_keys: frozenset[str]
    overrides: tuple[str, ...] = ()
    place: ReadingPlace = ReadingPlace()

    def __repr__(self) -> str:
        over = f" with {', '.join(self.overrides)}" if self.overrides else ""
        return f"<Loaded {visible(self.document.name)}{visible(over)}>"

    def line_of(self, path: str) -> int | None:
        """Line of a key in the file; None where an override gives the key."""
        return None if self.is_set_over(path) else self.document.lines.get(path)

    def is_set_over(self, path: str) -> bool:
        """Whether an override gives a key, or a block that contains it."""
        return any(is_within(path, text.partition("=")[0].strip()) for text in self.overrides)

    @property
    def sha256(self) -> str:
        """SHA-256 of the text of the file, followed by a zero byte and the text of each override.

        Without overrides it is what ``sha256sum`` prints for the file.
        """
        return _sha256("\0".join([self.document.text, *self.overrides]))


class LoadedMap(Struct, frozen=True):
    """A validated map file: the inputs that are constant, and those that vary.

    Attributes
    ----------
    scenario : Scenario
        The scenario of the constant inputs; an input that varies has a value of its axis.
    block : MapBlock
        The axes, and how cells are chosen.
    document : Document
        The file as it was read or, with overrides, a file that says the same.
    overrides : tuple of str
        Values that replaced those of the file, as ``path=value``.
    """

    scenario: Scenario
    block: MapBlock
    document: Document
    overrides: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The text of the file that gives the map."""
        return self.document.text

    @property
    def name(self) -> str:
        """Name of the file that gives the map."""
        return self.document.name

    @property
    def sha256(self) -> str:
        """Digest of the file, as ``sha256sum`` prints it."""
        return _sha256(self.text)

    @property
    def design(self) -> Loaded | None:
        """The scenario at the values that the file gives beside the map; None where an input that varies has none.

        Raises
        ------
        ScenarioError
            Where a value that is given cannot be used.
        """
        keys: Any = self.document.data
        held = {key: value for key, value in keys.items() if key != "map"}
        stated = frozenset(_stated_paths(held))
        if any(axis.path.value not in stated for axis in self.block.axes):
            return None
        scenario = _validated(replace(self.document, data=held), Scenario, {})
        return Loaded(scenario, self.document, stated, self.overrides, ReadingPlace(str(Path(self.name).parent)))


def load(source: Source, overrides: Overrides = (), allow_outside: bool = False) -> Loaded:
    """Read and validate a scenario from a file, from standard input ("-") or from a mapping.

    Parameters
    ----------
    source : str, Path or mapping
        Path of the file, or the keys of a scenario: ``{"schema_version": 1, "device": {...}, ...}``. Lines in messages
        are then those of its text as JSON.
    overrides : sequence of str, or mapping of str to object
        Values that replace those of the file: ``"device.length_m=0.7"``, or ``{"device.length_m": 0.7}``. The last
        one counts; an empty value removes an optional key.
    allow_outside : bool
        Whether records that the scenario names may be outside of its folder.

    Returns
    -------
    Loaded
        The scenario, with the file and the overrides that it came from.

    Raises
    ------
    UsageError
        Where there is no such file, or it cannot be opened.
    ScenarioError
        Where the scenario cannot be used, with all its mistakes.
    """
    if isinstance(source, Mapping):
        return loads(yaml_of(source, indent=2), "<dict>", overrides, ReadingPlace(outside=allow_outside))
    text, name = _contents(source)
    return loads(text, name, overrides, ReadingPlace(str(Path(source).parent), allow_outside))


def loads(
    text: str | bytes, name: str = "<text>", overrides: Overrides = (), place: ReadingPlace | None = None
) -> Loaded:
    """Read and validate a scenario from text or UTF-8 bytes.

    Parameters
    ----------
    text : str or bytes
        Content of a scenario file.
    name : str
        Name of the file, for messages.
    overrides : sequence of str, or mapping of str to object
        Values that replace those of the text, as in `load`.
    place : ReadingPlace, optional
        Where records that the scenario names are looked for; by default in the folder of `name`.

    Returns
    -------
    Loaded
        The scenario, with the text and the overrides that it came from.

    Raises
    ------
    UsageError
        If `text` is neither str nor bytes.
    ScenarioError
        Where the scenario cannot be used, with all its mistakes.
    """
    if not isinstance(text, str | bytes):
        raise UsageError(f"the text of a scenario cannot be of type {type(text).__name__} (allowed: str, bytes)")
    document, texts = _block_of_keys(text, name), as_texts(overrides)
    effective = apply(document, texts) if texts else document
    scenario = _validated(effective, Scenario, {})
    return Loaded(
        scenario,
        document,
        frozenset(_stated_paths(effective.data)),
        texts,
        place or ReadingPlace(str(Path(name).parent)),
    )


def with_default_blocks(loaded: Loaded) -> Loaded:
    """A scenario completed by overrides with every block of `ADDED_IF_FULL` that it lacks and can have."""
    barred = barred_blocks(loaded.scenario)
    lacking = [name for name in ADDED_IF_FULL if getattr(loaded.scenario, name) is None and name not in barred]
    overrides = (*loaded.overrides, *(f"{name}={{}}" for name in lacking))
    return loads(loaded.document.text, loaded.document.name, overrides, loaded.place) if lacking else loaded


def load_any(source: str | Path, overrides: Overrides = (), allow_outside: bool = False) -> Loaded | LoadedMap:
    """Read a scenario, or a map where the file has a block `map` (see `load` and `load_map`)."""
    text, name = _contents(source)
    data: Any = _block_of_keys(text, name).data
    if "map" not in data or "map" not in ADDITIONS:
        return loads(text, name, overrides, ReadingPlace(str(Path(source).parent), allow_outside))
    return loads_map(text, name, overrides)


def load_map(source: str | Path, overrides: Overrides = ()) -> LoadedMap:
    """Read a map from a file, or from standard input where `source` is "-"; overrides as in `load`.

    Raises
    ------
    UsageError
        Where there is no such file, or it cannot be opened.
    ScenarioError
        Where the map cannot be used.
    """
    return loads_map(*_contents(source), overrides)


def loads_map(text: str | bytes, name: str = "<text>", overrides: Overrides = ()) -> LoadedMap:
    """Read and validate a map file from text or UTF-8 bytes; `name` is its name in messages, see `load_map`."""
    document, texts = _block_of_keys(text, name), as_texts(overrides)
    if texts:
        document = apply(document, texts)
        # Cells are kept with the file that gives them, which must be whole: another value is another map.
        document = replace(document, text=yaml_of(document.data, indent=1))
    keys: Any = document.data
    if "map" not in keys:
        raise UsageError(
            f"{name}: has no map block, which says what varies (give one; or vireport map {name} --over INPUT,INPUT "
            "for the exact boundaries of a scenario)"
        )
    from vireport.scenario.map_file import MapFile

    filled, axes = _with_a_value_of_each_axis(document.data)
    file = _validated(replace(document, data=filled), MapFile, axes)
    return LoadedMap(file, file.map, document, texts)


def _contents(source: str | Path) -> tuple[bytes, str]:
    """The first `LARGEST_FILE` + 1 bytes of a file, and its name for messages."""
    if not isinstance(source, str | Path):
        raise UsageError(
            f"a scenario cannot be read from a value of type {type(source).__name__} (allowed: the path of a YAML file "
            "as str or Path, or a dict of the scenario's keys; its text is for loads)"
        )
    try:
        if str(source) == "-":
            return sys.stdin.buffer.read(LARGEST_FILE + 1), "<stdin>"
        with open(source, "rb") as file:
            return file.read(LARGEST_FILE + 1), visible(str(source))
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise UsageError(_unreadable(Path(source), error)) from error


def _block_of_keys(text: str | bytes, name: str) -> Document:
    document = read(text, name)
    if isinstance(document.data, dict):
        return document
    what = "the file is empty" if document.data is None else "the file is not a block of keys"
    message = f"{what} (a scenario starts with 'schema_version: 1'; 'vireport init' writes a complete one)"
    raise ScenarioError(name, document.mistakes or [Mistake(document.lines[""], "", message)])


def _validated(document: Document, model: type[FileModel], stands_for: Mapping[str, str]) -> FileModel:
    """Make a scenario or a map file of a document as it was read.

    Parameters
    ----------
    document : Document
    model : type
    stands_for : mapping of str to str
        Paths of values that were filled in, to the paths that they were taken from.

    Raises
    ------
    ScenarioError
        If it cannot be used, with every mistake in it.
    """
    file, keys = None, document.data
    findings = list[Finding]()
    for path in keys_left_out(model):
        keys, refused = _without(keys, path)
        findings += refused
    try:
        file = model.model_validate(keys)
    except ValidationError as error:
        kinds = {"missing": Kind.MISSING, "extra_forbidden": Kind.UNKNOWN}
        for mistake in error.errors(include_url=False):
            if mistake["type"] == "too_short" and len(mistake["input"]) > mistake["ctx"]["actual_length"]:
                continue  # a list is only short of the elements that are wrong in themselves
            path = reduce(join, mistake["loc"], "")
            findings.append(Finding(path, kinds.get(mistake["type"], Kind.VALUE), mistake["input"]))
    wrong = {finding.path for finding in findings} | document.unread
    if findings:
        from vireport.scenario.messages import misspelt

        wrong |= misspelt(findings, document, model)
    findings += inconsistencies(document, wrong, model)
    if file is not None and not findings and not document.mistakes:
        return file
    from vireport.scenario.messages import worded

    findings = [finding._replace(path=stands_for.get(finding.path, finding.path)) for finding in findings]
    mistakes, more = worded(findings, document, model)
    raise ScenarioError(document.name, [*document.mistakes, *mistakes], more)


def _without(tree: object, path: str, block: str = "") -> tuple[object, list[Finding]]:
    """A block without a key that counts as unknown, and the finding on that key if it is there."""
    name, _, rest = path.partition(".")
    if not isinstance(tree, dict) or name not in tree:
        return tree, []
    if not rest:
        return {key: value for key, value in tree.items() if key != name}, [
            Finding(block + name, Kind.UNKNOWN, tree[name])
        ]
    inner, refused = _without(tree[name], rest, f"{block}{name}.")
    return tree | {name: inner}, refused


def _with_a_value_of_each_axis(data: Any) -> tuple[dict[str, object], dict[str, str]]:
    """The tree of a map file with a value of every input that varies, and the paths of the axes they are taken from."""
    filled, stands_for = deepcopy(data), {}
    for k, axis in enumerate(rows_of(data, *AXES)):
        path = path_of(axis, AxisPath)
        if path is None:
            continue
        parent, _, key = path.rpartition(".")
        block = filled.setdefault(parent, {}) if parent else filled
        if isinstance(block, dict):
            block[key] = _value_on(axis, path)
            stands_for[path.value] = f"map.axes.{k}"
    return filled, stands_for


def _value_on(axis: dict[str, object], path: AxisPath) -> float:
    """A value of an axis for the scenario of a map: the first one, or the largest for the ball's mass.

    The one rule between several keys that a map can break is that the ball is lighter than the capsule.
    """
    low, high = path.limits
    on_axis = axis.get("values") or [axis.get("from"), axis.get("to")]
    values: list[float] = [x for x in on_axis if is_number(x) and low <= x <= high] if isinstance(on_axis, list) else []
    if not values:
        return low  # what is wrong with the axis is said of the axis
    return max(values) if path is AxisPath.BALL_MASS else values[0]


def _stated_paths(block: Any, path: str = "") -> list[str]:
    """Paths of all keys that have a value."""
    paths = []
    for key, value in block.items():
        key_path = join(path, key)
        if value is not None:
            paths.append(key_path)
        if isinstance(value, dict):
            paths += _stated_paths(value, key_path)
    return paths


def _unreadable(path: Path, error: Exception) -> str:
    if str(path) == "-":
        return f"standard input cannot be read ({getattr(error, 'strerror', None) or error})"
    if isinstance(error, FileNotFoundError):
        if "\n" in str(path) or path == Path():
            name = visible(str(path), LONGEST_NAME) if path != Path() else "''"
            return f"{name}: is no name of a file (the text of a scenario is for loads)"
        from vireport.scenario.hints import closest

        try:
            close = closest(path.name, [entry.name for entry in islice(path.parent.iterdir(), MOST_NAMES)])
        except OSError:
            return f"{path}: no such folder as {path.parent}"
        return f"{path}: no such file" + (f"; did you mean '{path.parent / close}'?" if close else "")
    if isinstance(error, IsADirectoryError):
        return f"{path}: is a folder, not a scenario file"
    if isinstance(error, PermissionError):
        return f"{path}: may not be read (permission denied)"
    return f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})"


def _sha256(text: str) -> str:
    return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()
