"""Strict reading of YAML 1.2: text into a plain tree, with the line of every key.

A misread number is a wrong report, so nothing is guessed here: only the types of the YAML 1.2 core schema
exist (``1e-3`` is a number, ``yes`` and ``1:30`` are text), a key stands once, and what a scenario has no use
for (anchors, aliases, tags, several documents) is refused. The tree is built from parser events and is never
deeper or larger than the limits below, so no input can exhaust the memory or the stack. What the keys mean is
not known here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NoReturn

import yaml
from yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    CollectionStartEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    NodeEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
)

from vireport.errors import Mistake, ScenarioError
from vireport.scenario.scalars import is_forbidden, joined, scalar

LARGEST_FILE = 1_000_000  # bytes; a scenario has about a thousand
DEEPEST = 20  # levels of nesting; a scenario has three
MOST_NODES = 5_000  # keys and values; a scenario has about fifty
MOST_CHARACTERS = 20  # invisible characters that are reported one by one

_NAME = re.compile(r"[^\W\d]\w{0,59}")


@dataclass(frozen=True, slots=True)
class Document:
    """A YAML text as read: its tree, and where everything in it stands.

    Attributes
    ----------
    name : str
        Name of the file, for messages.
    text : str
        The whole text, exactly as given.
    data : object
        The tree: dictionaries with string keys, lists, str, int, float, bool and None.
    lines : dict of str to int
        Dotted path of every key and list element to its line, counted from 1; "" is the root.
    written : dict of str to str
        Dotted path of every scalar to how it was written, with its quotes.
    mistakes : tuple of Mistake
        What is left out of the tree. The document of a loaded scenario has none.
    unread : frozenset of str
        Paths whose value is not known because of a mistake: nothing more can be said about what is below
        them.
    """

    name: str
    text: str
    data: object
    lines: dict[str, int]
    written: dict[str, str]
    mistakes: tuple[Mistake, ...] = ()
    unread: frozenset[str] = frozenset()


def read(source: str | bytes, name: str, path: str = "") -> Document:
    """Read one YAML document.

    Parameters
    ----------
    source : str or bytes
        The text; bytes are UTF-8, with or without a byte order mark.
    name : str
        Name of the file, for messages.
    path : str
        Path of the root, where the text is a part of something larger.

    Raises
    ------
    ScenarioError
        Where the text cannot be read to its end, with every mistake up to there. Mistakes that leave the rest
        readable are in the `mistakes` of the result instead.
    """
    text = _decode(source, name)
    return _Reader(name, path).read(text)


def _decode(source: str | bytes, name: str) -> str:
    if len(source) > LARGEST_FILE:
        size = f"larger than {LARGEST_FILE // 1_000_000} MB"
        raise ScenarioError(name, [Mistake(1, "", f"the file is {size} (a scenario has about 1 kB)")])
    if isinstance(source, str):
        return source
    line, what = 1, "is not text"
    if source[:2] in (b"\xff\xfe", b"\xfe\xff"):
        what = "is UTF-16"
    elif b"\0" not in source:
        try:
            return source.decode("utf-8")
        except UnicodeDecodeError as error:
            line = source.count(b"\n", 0, error.start) + 1
            what = f"has the byte 0x{source[error.start]:02X}, which is not UTF-8"
    raise ScenarioError(name, [Mistake(line, "", f"the file {what} (save it as UTF-8 text)")])


def join(path: str, key: str | int) -> str:
    """Dotted path of a key; one that is no plain name is put in quotes, its control characters escaped."""
    step = str(key) if isinstance(key, int) or _NAME.fullmatch(key) else repr(key[:60])
    return f"{path}.{step}" if path else step


class _Reader:
    """Builds the tree of one document from parser events, recording places and mistakes on the way."""

    def __init__(self, name: str, path: str) -> None:
        self.name, self.root = name, path
        self.events: Iterator[Event] = iter(())
        self.lines: dict[str, int] = {path: 1}
        self.written: dict[str, str] = {}
        self.mistakes: list[Mistake] = []
        self.unread: set[str] = set()
        self.nodes = 0

    def read(self, text: str) -> Document:
        plain = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
        self._refuse_characters(plain)
        # The loader written in Python: the one in C crashes the process on deep nesting.
        self.events = yaml.parse(plain, Loader=yaml.SafeLoader)
        try:
            data = self._document()
        except (yaml.YAMLError, ValueError, OverflowError) as error:  # the last two: \U beyond Unicode
            from vireport.scenario.syntax import explain

            line, message = explain(error, plain)
            self._stop(line, self.root, message)
        mistakes, unread = tuple(self.mistakes), frozenset(self.unread)
        return Document(self.name, text, data, self.lines, self.written, mistakes, unread)

    def _stop(self, line: int, path: str, message: str) -> NoReturn:
        raise ScenarioError(self.name, [*self.mistakes, Mistake(line, path, message)])

    def _refuse(self, event: Event, path: str, message: str) -> None:
        self.mistakes.append(Mistake(_line(event), path, message))

    def _refuse_characters(self, text: str) -> None:
        bad = sorted(filter(is_forbidden, set(text)))
        if not bad:
            return
        for found in re.finditer(f"[{re.escape(''.join(bad))}]", text):
            line = text.count("\n", 0, found.start()) + 1
            message = f"the invisible character U+{ord(found[0]):04X} is not allowed (delete it)"
            self.mistakes.append(Mistake(line, self.root, message))
            if len(self.mistakes) == MOST_CHARACTERS:
                break
        raise ScenarioError(self.name, self.mistakes)

    def _document(self) -> object:
        next(self.events)  # the start of the stream
        start = next(self.events)
        if isinstance(start, StreamEndEvent):
            return None
        if isinstance(start, DocumentStartEvent) and (start.tags or start.version not in (None, (1, 2))):
            self._refuse(start, self.root, "directives are not read (delete the line that starts with '%')")
        first = next(self.events)
        self.lines[self.root] = _line(first)
        data = self._node(first, self.root, 1)
        next(self.events)  # the end of the document
        after = next(self.events)
        if not isinstance(after, StreamEndEvent):
            self._refuse(after, self.root, "a second document starts here (one scenario to a file)")
        return data

    def _guard(self, event: Event, path: str, depth: int) -> None:
        self.nodes += 1
        if depth > DEEPEST:
            outer = ".".join(path.split(".")[:3])
            self._stop(_line(event), outer, f"nested more than {DEEPEST} levels deep (a scenario has three)")
        if self.nodes > MOST_NODES:
            many = f"more than {MOST_NODES} keys and values"
            self._stop(_line(event), path, f"{many} (a scenario has about fifty)")

    def _node(self, event: Event, path: str, depth: int) -> object:
        self._guard(event, path, depth)
        if isinstance(event, AliasEvent):
            self._refuse(event, path, f"aliases are not read, got *{event.anchor} (write the value out)")
            self.unread.add(path)
            return None
        if isinstance(event, NodeEvent) and event.anchor is not None:
            self._refuse(event, path, f"anchors are not read, got &{event.anchor} (delete it)")
        if isinstance(event, (ScalarEvent, CollectionStartEvent)) and event.tag is not None:
            tag = event.tag.replace("tag:yaml.org,2002:", "!!")[:60]
            self._refuse(event, path, f"tags are not read, got {tag!r} (delete it)")
            self.unread.add(path)
        if isinstance(event, ScalarEvent):
            return self._scalar(event, path)
        if isinstance(event, SequenceStartEvent):
            return self._sequence(path, depth)
        return self._mapping(path, depth)

    def _scalar(self, event: ScalarEvent, path: str) -> object:
        text = event.value
        self.written[path] = f"{event.style}{text}{event.style}" if event.style in ("'", '"') else text
        if not event.style:
            return scalar(text)
        whole = joined(text)
        if whole is None:
            self._refuse(event, path, "an escape of half a character (write the character itself)")
            self.unread.add(path)
        return whole

    def _sequence(self, path: str, depth: int) -> list[object]:
        found: list[object] = []
        while not isinstance(event := next(self.events), SequenceEndEvent):
            element = join(path, len(found))
            self.lines[element] = _line(event)
            found.append(self._node(event, element, depth + 1))
        return found

    def _mapping(self, path: str, depth: int) -> dict[str, object]:
        found: dict[str, object] = {}
        while not isinstance(event := next(self.events), MappingEndEvent):
            key = self._key(event, path, depth + 1)
            value = next(self.events)
            if key is None:
                self._skip(value, path, depth + 1)
                continue
            here = join(path, key)
            if key in found:
                first = self.lines[here]
                self._refuse(event, here, f"given twice, first on line {first} (keep one of them)")
                self._skip(value, here, depth + 1)
                if isinstance(value, CollectionStartEvent):
                    self.unread.add(here)  # its keys may be in either of the two
                continue
            self.lines[here] = _line(event)
            found[key] = self._node(value, here, depth + 1)
        return found

    def _key(self, event: Event, path: str, depth: int) -> str | None:
        """Return the name in a key's event; None, with the mistake recorded, where it is not a name."""
        if not isinstance(event, ScalarEvent):
            self._skip(event, path, depth)
            self._refuse(event, path, "a key that is not a name (keys are names, followed by a colon)")
            return None
        self._guard(event, path, depth)
        key = event.value
        if event.anchor is not None or event.tag is not None:
            self._refuse(event, join(path, key), "anchors and tags are not read (delete it)")
        if event.style:
            whole = joined(key)
            if whole is None:
                self._refuse(event, join(path, key), "an escape of half a character (keys are names)")
            return whole
        if key == "<<":
            self._refuse(event, join(path, key), "merge keys are not read (write the keys out)")
            return None
        if not isinstance(scalar(key), str):
            self._refuse(event, join(path, key), f"the key {key or 'null'} is not a name (keys are names)")
            return None
        return key

    def _skip(self, event: Event, path: str, depth: int) -> None:
        self._guard(event, path, depth)
        if isinstance(event, CollectionStartEvent):
            while not isinstance(event := next(self.events), CollectionEndEvent):
                self._skip(event, path, depth + 1)


def _line(event: Event) -> int:
    mark = event.start_mark
    return 1 if mark is None else mark.line + 1
