"""Strict reading of YAML 1.2: text into a plain tree, with the line of every key.

A misread number is a wrong report, so nothing is guessed here: only the types of the YAML 1.2 core schema
exist (``1e-3`` is a number, ``yes`` and ``1:30`` are text), a key stands once, and what a scenario has no use
for (anchors, aliases, tags, several documents) is refused. The tree is built from parser events and is never
deeper or larger than the limits below, so no input can exhaust the memory or the stack; composing PyYAML's nodes
instead would end at the first alias, and lose every mistake before an error of syntax. This module does not know what
the keys mean.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Set
from itertools import accumulate, islice
from math import inf, nan
from typing import NoReturn

import yaml
from msgspec import Struct
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

from vireport.base.errors import Mistake, ScenarioError
from vireport.base.records import brief

LARGEST_FILE = 1_000_000  # bytes; a scenario has about a thousand
DEEPEST = 20  # levels of nesting; a scenario has three
MOST_NODES = 5_000  # keys and values; a scenario has about fifty
MOST_CHARACTERS = 20  # invisible characters that are reported one by one
LONGEST_INTEGER = 300  # characters; a longer one is beyond double precision, and slow to convert

_NAME = re.compile(r"[^\W\d]\w{0,59}")
_NUMBER = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_BASED_INTEGER = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_CONSTANTS: dict[str, object] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), nan),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), inf),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -inf),
}
# What YAML forbids, and what it takes for a line break, which would shift the later lines.
_FORBIDDEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff]")


class Document(Struct, frozen=True):
    """A YAML text as read: its tree, and the lines of everything in it.

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
        Mistakes whose values are left out of the tree. The document of a loaded scenario has none.
    unread : frozenset of str
        Paths whose value is not known because of a mistake: nothing more can be said about keys below them.
    """

    name: str
    text: str
    data: object
    lines: dict[str, int]
    written: dict[str, str]
    mistakes: tuple[Mistake, ...] = ()
    unread: frozenset[str] = frozenset()

    __repr__ = brief

    def line_of(self, path: str) -> int:
        """Line of a key, or of the innermost block that would hold it."""
        while path not in self.lines and path:
            path = path.rpartition(".")[0]
        return self.lines[path]


def read(source: str | bytes, name: str, path: str = "") -> Document:
    """Parse a YAML document with the lines of its keys.

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
    return _Reader(name, path).read(_decoded(source, name))


def join(path: str, key: str | int) -> str:
    """Dotted path of a key; one that is no plain name is put in quotes, its control characters escaped."""
    step = str(key) if isinstance(key, int) or _NAME.fullmatch(key) else repr(key[:60])
    return f"{path}.{step}" if path else step


def is_within(path: str, block: str) -> bool:
    """Whether a path is a block's own, or that of a key in it."""
    return path == block or path.startswith(f"{block}.") or not block


def is_within_any(path: str, blocks: Set[str]) -> bool:
    """Whether a path is that of one of some blocks or of a key in one, in a time that does not grow with their number.

    Examples
    --------
    >>> is_within_any("a.b.c", {"a.b"}), is_within_any("a.bc", {"a.b"}), is_within_any("a", {""})
    (True, False, True)
    """
    return not blocks.isdisjoint(["", *accumulate(path.split("."), "{}.{}".format)])


def scalar(text: str) -> object:
    """Value of a plain scalar by the core schema of YAML 1.2, section 10.3.2: None, bool, int, float, or else itself.

    Parameters
    ----------
    text : str
        The scalar without quotes; what stands in quotes is text whatever it looks like.

    Examples
    --------
    >>> [scalar(text) for text in ("1e-3", ".5", "017", "0o17", "True")]
    [0.001, 0.5, 17, 15, True]
    >>> [scalar(text) for text in ("yes", "1:30", "1_000", "2024-01-01")]
    ['yes', '1:30', '1_000', '2024-01-01']
    """
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if _NUMBER.fullmatch(text):
        whole = len(text) <= LONGEST_INTEGER and set(text).isdisjoint(".eE")
        return int(text) if whole else float(text)
    if _BASED_INTEGER.fullmatch(text):
        return int(text, 0) if len(text) <= LONGEST_INTEGER else inf
    return text


def _decoded(source: str | bytes, name: str) -> str:
    if len(source) > LARGEST_FILE:
        size = f"larger than {LARGEST_FILE // 1_000_000} MB"
        raise ScenarioError.in_line(name, 1, "", f"the file is {size} (a scenario has about 1 kB)")
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
    raise ScenarioError.in_line(name, line, "", f"the file {what} (save it as UTF-8 text)")


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
            line, message = explain(error, plain)
            self._stop(line, self.root, message)
        mistakes, unread = tuple(self.mistakes), frozenset(self.unread)
        return Document(self.name, text, data, self.lines, self.written, mistakes, unread)

    def _stop(self, line: int, path: str, message: str) -> NoReturn:
        raise ScenarioError(self.name, [*self.mistakes, Mistake(line, path, message)])

    def _refuse(self, event: Event, path: str, message: str) -> None:
        self.mistakes.append(Mistake(_line(event), path, message))

    def _refuse_characters(self, text: str) -> None:
        for match in islice(_FORBIDDEN.finditer(text), MOST_CHARACTERS):
            message = f"the invisible character U+{ord(match[0]):04X} is not allowed (delete it)"
            self.mistakes.append(Mistake(text.count("\n", 0, match.start()) + 1, self.root, message))
        if self.mistakes:
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
            self._refuse(after, self.root, "a second document starts here (one scenario per file)")
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
        whole = _with_whole_characters(text)
        if whole is None:
            self._refuse(event, path, "an escape of half a character (write the character itself)")
            self.unread.add(path)
        return whole

    def _sequence(self, path: str, depth: int) -> list[object]:
        elements: list[object] = []
        while not isinstance(event := next(self.events), SequenceEndEvent):
            element = join(path, len(elements))
            self.lines[element] = _line(event)
            elements.append(self._node(event, element, depth + 1))
        return elements

    def _mapping(self, path: str, depth: int) -> dict[str, object]:
        block: dict[str, object] = {}
        while not isinstance(event := next(self.events), MappingEndEvent):
            key = self._key(event, path, depth + 1)
            value = next(self.events)
            if key is None:
                self._skip(value, path, depth + 1)
                continue
            key_path = join(path, key)
            if key in block:
                first = self.lines[key_path]
                self._refuse(event, key_path, f"given twice, first on line {first} (keep one of them)")
                self._skip(value, key_path, depth + 1)
                if isinstance(value, CollectionStartEvent):
                    self.unread.add(key_path)  # its keys may be in either of the two
                continue
            self.lines[key_path] = _line(event)
            block[key] = self._node(value, key_path, depth + 1)
        return block

    def _key(self, event: Event, path: str, depth: int) -> str | None:
        """Return the name in a key's event; None, with the mistake recorded, where it is not a name."""
        if not isinstance(event, ScalarEvent):
            self._skip(event, path, depth)
            self._refuse(event, path, "a key that is not a name (keys are names, followed by a colon)")
            return None
        self._guard(event, path, depth)
        key, key_path = event.value, join(path, event.value)
        if event.anchor is not None or event.tag is not None:
            self._refuse(event, key_path, "anchors and tags are not read (delete it)")
        if event.style:
            whole = _with_whole_characters(key)
            if whole is None:
                self._refuse(event, key_path, "an escape of half a character (keys are names)")
            return whole
        if key == "<<":
            self._refuse(event, key_path, "merge keys are not read (write the keys out)")
            return None
        if not isinstance(scalar(key), str):
            self._refuse(event, key_path, f"the key {key or 'null'} is not a name (keys are names)")
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


def _with_whole_characters(text: str) -> str | None:
    """Join the two escapes by which JSON writes a character beyond U+FFFF; None where one is missing."""
    try:
        return text.encode("utf-16", "surrogatepass").decode("utf-16")
    except UnicodeDecodeError:
        return None


# Explanations of a text that is not YAML. The parser's own messages speak of tokens and block ends, these of what was
# probably meant. The first one whose text is in the parser's message counts.
_EXPLANATIONS = (
    ("found character '\\t'", "a tab where YAML does not allow one (indent and separate with spaces)"),
    ("that cannot start any token", "a value cannot start with this character (put text in quotes)"),
    ("found unexpected end of stream", "a quote is opened here and never closed (close it)"),
    ("found unexpected document separator", "a quote is opened here and never closed (close it)"),
    ("expected ',' or ']'", "a '[' is opened here and not closed, or a comma is missing (close it with ']')"),
    ("expected ',' or '}'", "a '{' is opened here and not closed, or a comma is missing (close it with '}')"),
    ("invalid indentation or unclosed", "a '[' or '{' is not closed (close it)"),
    ("could not find expected ':'", "a key without its colon (write 'key: value')"),
    ("mapping values are not allowed here", "a second colon in one value, or wrong indentation (quote text with ': ')"),
    ("sequence entries are not allowed here", "a list cannot start here (a list is the value of a key)"),
    ("but found '-'", "a list entry among keys (a list is the value of a key)"),
    ("expected <block end>", "wrong indentation (keys of one block start in the same column)"),
    ("expected '<document start>'", "text after the end of the scenario (everything belongs in one block of keys)"),
    ("expected the node content", "a value is missing before this bracket or comma (write it)"),
    ("unknown escape character", "an unknown escape after '\\' (use single quotes for text with backslashes)"),
    ("hexadecimal numbers", "an incomplete escape after '\\' (use single quotes for text with backslashes)"),
    ("chomping or indentation", "'|' or '>' starts a text of several lines (put the text in quotes)"),
    ("indentation indicator", "'|' or '>' starts a text of several lines (put the text in quotes)"),
    ("scanning an alias", "a value cannot start with '*' (put text in quotes)"),
    ("scanning an anchor", "a value cannot start with '&' (put text in quotes)"),
    ("tag", "a value cannot start with '!' (put text in quotes)"),
    ("directive", "a line cannot start with '%' (put text in quotes)"),
    ("incompatible YAML document", "a line cannot start with '%' (delete it)"),
)
_UNEXPLAINED = "this is not YAML (write 'key: value', one to a line)"
# Messages whose cause is where the construct began, not where the parser gave up.
_FROM_START = ("end of stream", "document separator", "or ']'", "or '}'", "could not find expected ':'")
_BARE = re.compile(r"\s*[^\s:#][^:#]*$")
_NO_SPACE = re.compile(r"\s*(?!['\"#])[^\s:#]+:[^\s/:]")


def explain(error: Exception, text: str) -> tuple[int, str]:
    """Return the line, counted from 1, and the explanation of a parser's error.

    Parameters
    ----------
    error : yaml.YAMLError, ValueError or OverflowError
        The error that the parser raised.
    text : str
        The text that the parser read.
    """
    lines = text.split("\n")
    if not isinstance(error, yaml.MarkedYAMLError):
        # Only an escape or a version number that does not exist raises an error without a mark.
        line = next((i for i, row in enumerate(lines, 1) if "\\U" in row or row.startswith("%")), 1)
        return line, "an escape or a number that does not exist (delete it)"
    message = f"{error.context} {error.problem}"
    mark = error.problem_mark
    if error.context_mark is not None and any(part in message for part in _FROM_START):
        mark = error.context_mark
    line = 1 if mark is None else mark.line + 1
    # A key without its colon, or without the space after it, runs on into the next line.
    for earlier in (line - 1, line):
        row = lines[earlier - 1] if 0 < earlier <= len(lines) else ""
        if _NO_SPACE.match(row):
            return earlier, "no space after the colon (write 'key: value')"
        if earlier < line and "mapping values" in message and _BARE.match(row):
            return earlier, "a key without its colon (write 'key: value')"
    return line, next((words for part, words in _EXPLANATIONS if part in message), _UNEXPLAINED)
