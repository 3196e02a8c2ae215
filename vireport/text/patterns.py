"""Sentences as data: a pattern of a file of words, with places for numbers, and what stands in its places.

The pattern says how each number is printed, whoever chooses the sentence gives it. Files of patterns are JSON: what
`run --json` says too would cost it 6.5 % of its time by Jinja.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from enum import StrEnum
from functools import cache, lru_cache
from pathlib import Path
from string import Formatter
from typing import Any

from msgspec import Struct

from vireport.base.errors import RenderError
from vireport.text.folders import ROOTS
from vireport.text.formatting import OF_A_MODEL, ROUGHLY, error_bound, rounded_text, stated_text


class Phrase(Struct, frozen=True):
    """A sentence, or a part of one: a pattern of a file of words, and what stands in its places.

    A number or a text is printed as the pattern says, a phrase as its own pattern says. Of a list each is printed, with
    the format of its place between them. `str` gives what data has: the package's words.
    """

    file: str
    pattern: str
    values: Mapping[str, object] = {}

    def __repr__(self) -> str:
        return repr(str(self))

    def __str__(self) -> str:
        return self._filled(None, on_page=False)

    def words(self, templates: Path | None = None) -> str:
        """What a page or a terminal says.

        Parameters
        ----------
        templates : Path, optional
            A folder whose words come before the package's own.

        Raises
        ------
        RenderError
            If its file of patterns is not as ours is.
        """
        return self._filled(templates, on_page=True)

    def _filled(self, templates: Path | None, on_page: bool) -> str:
        def printed(value: object) -> object:
            if isinstance(value, float):
                return _Number(value)
            if isinstance(value, list):
                return _Listed(map(printed, value))
            if isinstance(value, OnPage):
                return value.text if on_page else value.in_data
            return value._filled(templates, on_page) if isinstance(value, Phrase) else value

        pattern = patterns(self.file, templates)[self.pattern]
        try:
            return pattern.format(**{place: printed(value) for place, value in self.values.items()})
        except ValueError as error:
            raise RenderError(f"{_path(self.file)}: {self.pattern}: {error}") from error


class OnPage(Struct, frozen=True):
    """A text that has another form in data: an input by its symbol there, as ``*s* = 0.5 m``, and by its key here."""

    text: str
    in_data: str


class Pattern(StrEnum):
    """Names of the patterns of a file of words; each subclass names its file."""

    file: str

    def __init_subclass__(cls, file: str) -> None:
        cls.file = file

    def said(self, **values: object) -> Phrase:
        """The pattern with numbers and texts in its places."""
        return Phrase(self.file, self.value, values)


def patterns(file: str, templates: Path | None = None) -> Mapping[str, str]:
    """The patterns of a file of words by their names, those of a folder of templates in place of the package's own.

    Raises
    ------
    RenderError
        If the folder's file is not JSON, names a pattern that there is not, or has one with other places.
    """
    ours = _ours(file)
    reworded = None if templates is None else templates / _path(file)
    if reworded is None or not reworded.exists():
        return ours
    return ours | _checked(file, reworded, reworded.stat().st_mtime_ns)


@cache
def _ours(file: str) -> dict[str, str]:
    path_of_ours = next(path for root in ROOTS if (path := root / _path(file)).exists())
    read: dict[str, str] = json.loads(path_of_ours.read_text(encoding="utf-8"))
    return read


@lru_cache
def _checked(file: str, reworded: Path, changed_ns: int) -> dict[str, str]:
    """A user's patterns, which are read again where the time of their last change is another."""
    ours, place = _ours(file), _path(file)
    try:
        read = json.loads(reworded.read_text(encoding="utf-8"))
        if not isinstance(read, dict):
            raise ValueError("is not an object that has a pattern by each name")
        for name, pattern in read.items():
            place = f"{_path(file)}: {name}"
            if name not in ours:
                raise ValueError("is the name of no pattern")
            if not isinstance(pattern, str) or _places(pattern) != _places(ours[name]):
                places = ", ".join(sorted(f"{{{place}}}" for place in _places(ours[name]))) or "none"
                raise ValueError(f"must be a text whose places are: {places}")
    except ValueError as error:
        raise RenderError(f"{place}: {error}") from error
    return read


def _path(file: str) -> str:
    return f"words/{file}.json"


def _places(pattern: str) -> set[str]:
    return {place for _, place, _, _ in Formatter().parse(pattern) if place is not None}


class _Listed(tuple[Any, ...]):
    """What stands in one place; the format of the place stands between them."""

    def __format__(self, between: str) -> str:
        return between.join(self)


class _Number(float):
    """A number of a sentence; its pattern says whether it is given, a bound, or told roughly, and with a sign.

    Examples
    --------
    >>> share, size, length, error = map(_Number, (12.345, 0.123, 0.123456, 5.551e-17))
    >>> f"{share:roughly} %, {size:+roughly} %, of {length:given} m, to {error:bound}"
    '12 %, +0.12 %, of 0.123456 m, to 5.6 × 10⁻¹⁷'
    """

    def __format__(self, kind: str) -> str:
        if kind == "given":
            return stated_text(self)
        if kind == "bound":
            return error_bound(self)
        sign = "+" if kind.startswith("+") and self > 0 else ""
        return sign + rounded_text(self, ROUGHLY if "roughly" in kind else OF_A_MODEL)
