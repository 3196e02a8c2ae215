"""What a block of keys is: how each key is declared, and how a tree of values is held to the declarations.

Every mistake of a tree is told at once, by its path. Types are not converted, but that a whole number stands for a
number, a list for a tuple, and the text of a choice for its member.
"""

from collections.abc import Iterator, Mapping
from enum import Enum, auto
from functools import cache
from math import inf, isfinite
from re import fullmatch
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    ClassVar,
    NamedTuple,
    Self,
    TypeVar,
    Union,
    dataclass_transform,
    get_args,
    get_origin,
)

from msgspec import Struct
from msgspec.structs import replace

from vireport.scenario.document import join
from vireport.text.foreign import without_joins

REQUIRED: Any = ...
"""Stands for the default of a key that has none."""


class Kind(Enum):
    """What may be wrong with a key."""

    MISSING = auto()
    UNKNOWN = auto()
    VALUE = auto()
    """A value of the wrong type or out of the range of its key, or of the parameter that it is a value of."""
    RULE = auto()
    """Does not fit what is elsewhere: the value of the finding is the message."""


class Finding(NamedTuple):
    """Something wrong at a path."""

    path: str
    kind: Kind
    value: object = None


class Text(Struct, frozen=True):
    """What a text is held to: its characters, which can all be printed, or the pattern of all of it.

    Attributes
    ----------
    longest : int or None
        Most characters.
    pattern : str
        A regular expression; "" for free text.
    meaning : str
        Of what has the pattern, where that does not say it.
    """

    longest: int | None = None
    pattern: str = ""
    meaning: str = ""

    def allows(self, text: str) -> bool:
        """Whether a text is one of them."""
        if self.longest is not None and len(text) > self.longest:
            return False
        return fullmatch(self.pattern, text) is not None if self.pattern else is_printable(text)


def is_printable(text: str) -> bool:
    """Whether a text is one line that any output can show: not blank, and without control characters."""
    return without_joins(text).isprintable() and bool(text.strip())


class Key(Struct, frozen=True, kw_only=True, eq=False):
    """A key as it is declared.

    Attributes
    ----------
    default : object
        Where the key is not given; `REQUIRED` where it must be.
    title, unit, meaning : str
        For the reader; the unit is "" where there is none and "1" for a pure number.
    examples : tuple
        Values that it might have.
    ge, gt, le : float
        What a number is at least, above, and at most.
    min_length, max_length : int or None
        How many values a list has at least and at most.
    beyond : str
        Why what is beyond the range is refused.
    addition : str
        Without which the key is an unknown one.
    alias : str
        Its name in a file, where that is no name of Python; "" where it is that of the attribute.
    annotation : object
        Type of the value; from where the key stands.
    """

    default: Any
    title: str
    unit: str
    meaning: str
    examples: tuple[Any, ...] = ()
    ge: float = -inf
    gt: float = -inf
    le: float = inf
    min_length: int | None = None
    max_length: int | None = None
    beyond: str = ""
    addition: str = ""
    alias: str = ""
    annotation: Any = None

    @property
    def type(self) -> "KeyType":
        """What the value may be."""
        return _type_of(self.annotation)

    def has_room_for(self, number: float) -> bool:
        """Whether a number is within its range."""
        return self.ge <= number <= self.le and number > self.gt


class KeyType(NamedTuple):
    """What the value of a key may be.

    Attributes
    ----------
    kind : type
        Of the value, or of the elements of a list: float, int, bool, str, an enumeration, a block, or NoneType.
    optional : bool
        Whether it may be None.
    many : bool
        Whether it is a list.
    text : Text
        What a text is held to.
    marks : tuple
        What else stands beside the type.
    """

    kind: Any
    optional: bool = False
    many: bool = False
    text: Text = Text()
    marks: tuple[Any, ...] = ()


@cache
def _type_of(annotation: Any) -> KeyType:
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        inner = _type_of(parts[0])
        text = next((part for part in parts[1:] if isinstance(part, Text)), inner.text)
        return inner._replace(text=text, marks=(*inner.marks, *parts[1:]))
    if origin in (Union, UnionType):
        (part,) = (part for part in parts if part is not NoneType)
        return _type_of(part)._replace(optional=True)
    if origin is tuple:
        return _type_of(parts[0])._replace(many=True)
    return KeyType(annotation or NoneType)


class _Keyed(type):
    """Takes the keys of a block from the body of its class, and from what that is made of."""

    def __init__(cls, name: str, bases: tuple[type, ...], body: dict[str, Any]) -> None:
        super().__init__(name, bases, body)
        declared = {name: value for name, value in body.items() if isinstance(value, Key)}
        types = cls.__annotations__ if declared else {}
        keys = {name: replace(key, annotation=types[name]) for name, key in declared.items()}
        cls.keys = {**getattr(cls, "keys", {}), **keys}


@dataclass_transform(kw_only_default=True, frozen_default=True)
class Block(metaclass=_Keyed):
    """A block of keys: frozen, without keys that are not declared, and without conversion of types.

    Parameters
    ----------
    **values : object
        Values of its keys, by their names in a file.

    Raises
    ------
    ValueError
        If one cannot be used.
    """

    keys: ClassVar[Mapping[str, Key]]
    """The keys by their names, in the order of the format."""

    def __init__(self, **values: Any) -> None:
        findings = list[Finding]()
        vars(self).update(_values(type(self), values, "", findings))
        if findings:
            wrong = ", ".join(f"{found.path}={found.value!r} ({found.kind.name})" for found in findings)
            raise ValueError(f"{type(self).__name__}: {wrong}")

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is frozen: {name} cannot be set")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__} is frozen: {name} cannot be deleted")

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and vars(other) == vars(self)

    def __hash__(self) -> int:
        return hash((type(self), *vars(self).values()))

    def __repr__(self) -> str:
        """The block without the keys that are as by default."""
        changed = (name for name, key in self.keys.items() if getattr(self, name) != key.default)
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in changed)})"

    @classmethod
    def completed(cls, tree: dict[str, Any]) -> dict[str, Any]:
        """The values as they are given, with those that follow from others."""
        return tree

    def replaced(self, values: Mapping[str, Any]) -> Self:
        """The block with other values of some keys, which are not held to the declarations."""
        other = object.__new__(type(self))
        vars(other).update({**vars(self), **values})
        return other


AnyBlock = TypeVar("AnyBlock", bound=Block)


def read_block(block: type[AnyBlock], tree: dict[str, Any], findings: list[Finding], path: str = "") -> AnyBlock:
    """Make a block of a tree of values, and add what is wrong with them to the findings.

    Where anything is, the block is of no use.
    """
    made = object.__new__(block)
    vars(made).update(_values(block, tree, path, findings))
    return made


def read_value(key: Key, given: Any, findings: list[Finding], path: str) -> Any:
    """The value of a key as it is given, or what is made of it; what is wrong with it is added to the findings."""
    kind = key.type
    if not kind.many or (given is None and kind.optional):
        return _single(key, kind, given, findings, path)
    values, known = given, len(findings)
    if isinstance(given, list | tuple):
        values = tuple(_single(key, kind, value, findings, join(path, k)) for k, value in enumerate(given))
        # What is wrong with its values is told before how many they are.
        if len(findings) > known or (key.min_length or 0) <= len(given) <= (key.max_length or inf):
            return values
    findings.append(Finding(path, Kind.VALUE, given))
    return values


def to_dict(block: Block) -> dict[str, Any]:
    """Return a block as plain data, defaults filled in, by the names and in the order of the file.

    What is optional and absent is None. Loading the result gives an equal block.
    """
    return {key.alias or name: _plain(getattr(block, name)) for name, key in block.keys.items()}


def _values(block: type[Block], given: dict[str, Any], path: str, findings: list[Finding]) -> Iterator[tuple[str, Any]]:
    """The value of every attribute of a block."""
    tree = block.completed(given)
    unknown = dict.fromkeys(tree)
    for name, key in block.keys.items():
        written = key.alias or name
        if written in tree:
            del unknown[written]
            yield name, read_value(key, tree[written], findings, join(path, written))
        else:
            if key.default is REQUIRED:
                findings.append(Finding(join(path, written), Kind.MISSING, given))
            yield name, key.default
    findings += [Finding(join(path, name), Kind.UNKNOWN, tree[name]) for name in unknown]


def _single(key: Key, kind: KeyType, given: Any, findings: list[Finding], path: str) -> Any:
    """A value that is no list, or an element of one."""
    wanted = kind.kind
    if given is None and (kind.optional or wanted is NoneType):
        return None
    if issubclass(wanted, Block):
        if isinstance(given, wanted):
            return given
        if isinstance(given, dict):
            return read_block(wanted, given, findings, path)
    elif issubclass(wanted, Enum):
        if isinstance(given, str) and given in tuple(wanted):
            return wanted(given)
    elif wanted is str:
        if isinstance(given, str) and kind.text.allows(given):
            return given
    elif isinstance(given, bool) or wanted is bool:
        if type(given) is wanted:
            return given
    elif isinstance(given, (int, float) if wanted is float else wanted) and _finite(given) and key.has_room_for(given):
        return wanted(given)
    findings.append(Finding(path, Kind.VALUE, given))
    return given


def _finite(number: float) -> bool:
    try:
        return isfinite(number)
    except OverflowError:  # a whole number beyond all floats
        return False


def _plain(value: Any) -> Any:
    if isinstance(value, Block):
        return to_dict(value)
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    return value.value if isinstance(value, Enum) else value
