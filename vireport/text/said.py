"""Something to be said as data: Python chooses the macro of a file of words, and gives it numbers and texts.

It becomes text where it is shown, with the words of the caller's folder of templates before the package's own.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from msgspec import Struct

from vireport.base.records import brief
from vireport.text.patterns import Phrase

BETWEEN = " | "
"""What stands between the parts of a text in its macro: of a tile, or of the head of a table."""


class Said(Struct, frozen=True):
    """Something to be said: a macro of a file of words, and its arguments.

    A `Said` or a `Phrase` among the arguments is said first, also one in a list.
    """

    macro: str
    values: tuple[object, ...] = ()
    file: str = "opening"

    __repr__ = brief

    def words(self, templates: Path | None = None) -> str:
        """The sentence in the words of the templates.

        Parameters
        ----------
        templates : Path, optional
            A folder whose words come before the package's own.

        Raises
        ------
        RenderError
            Where a macro fails, with the line.
        """
        from vireport.text.templates import Words

        return Words(self.file, templates)(self.macro, *(spoken(value, templates) for value in self.values))

    def parts(self, templates: Path | None = None) -> list[str]:
        """The words, parted at the bars."""
        return self.words(templates).split(BETWEEN)


def spoken(value: object, templates: Path | None = None) -> Any:
    """A `Said` or a `Phrase` as text, also one in a list; all else as it is."""
    if isinstance(value, list):
        return [spoken(item, templates) for item in value]
    return value.words(templates) if isinstance(value, Said | Phrase) else value


def words_of(file: str) -> Callable[..., Said]:
    """What takes a macro of a file of words and its arguments, and makes a `Said` of them."""
    return lambda macro, *values: Said(macro, values, file)
