"""Tables of text: the records, which the report's templates set, and their text for a terminal, Markdown and HTML.

What a scenario or a file's name says is text in all of them, and never markup.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from html import escape
from itertools import zip_longest
from textwrap import fill, wrap
from typing import ClassVar, Literal

from msgspec import Struct

from vireport.base.errors import RenderError
from vireport.text.foreign import visible
from vireport.text.formatting import NO_BREAK, tied
from vireport.text.said import BETWEEN

LINE = 110
"""Characters after which a paragraph is broken on a terminal."""


_MARKS = re.compile(r"([\\`*_\[\]|~$])")
_LINKS = re.compile(r"@(?=\w)|#(?=\d)|:(?=//)|\bwww(?=\.)|\bmailto(?=:)", re.IGNORECASE)
"""What sites like GitHub make a link of, or a message to somebody."""
_ENTITIES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})


Kind = Literal["text", "number", "code"]
KINDS: dict[str, Kind] = {"t": "text", "n": "number", "c": "code"}
"""What the columns of a table hold, by letters."""


class Column(Struct, frozen=True, eq=False):
    """A column of a table: its title and what its cells hold.

    Attributes
    ----------
    title : str
    kind : str
        ``text``, ``number`` (aligned at the right) or ``code``.
    width : int or None
        Characters after which a terminal breaks a cell; None where it never does.
    """

    title: str
    kind: Kind = "text"
    width: int | None = None


class Table(Struct, frozen=True, eq=False):
    """A table with caption, head, rows and a note.

    Attributes
    ----------
    caption : str
    columns : tuple of Column
    rows : tuple of tuple of str
        A cell for each column.
    note : str
        What a reader needs for reading it, or "".
    """

    kind: ClassVar[str] = "table"
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def worded_table(
    say: Callable[..., str], macro: str, kinds: str, rows: Iterable[Sequence[str]], *values: object, note: str = ""
) -> Table:
    """Make a table whose caption and heads are said by one macro, with bars between them.

    Parameters
    ----------
    say : callable
        What a macro says of what it is given: `Words` of its file.
    macro : str
    kinds : str
        A letter for each column: t for text, n for numbers, c for code.
    rows : iterable of sequence of str
    *values
        What the macro is given.
    note : str
        Of the table.

    Raises
    ------
    RenderError
        Where the macro, which may be a user's, has more or fewer heads than there are columns.
    """
    caption, *heads = say(macro, *values).split(BETWEEN)
    if len(heads) != len(kinds):
        raise RenderError(
            f"macro {macro!r}: a caption and {len(kinds)} heads are needed, with '{BETWEEN}' between them"
        )
    columns = tuple(Column(head, KINDS[kind]) for head, kind in zip(heads, kinds, strict=True))
    return Table(caption, columns, tuple(map(tuple, rows)), note)


def numbers(*titles: str) -> tuple[Column, ...]:
    """Columns of numbers with these heads."""
    return tuple(Column(title, "number") for title in titles)


def texts(*titles: str) -> tuple[Column, ...]:
    """Columns of text with these heads."""
    return tuple(Column(title) for title in titles)


def plain_text(parts: Iterable[str | Table]) -> str:
    """Paragraphs, broken into lines, and tables under their captions, for a terminal; a blank line between them."""
    return "\n\n".join(broken(part) if isinstance(part, str) else _captioned(part) for part in parts)


def broken(text: str) -> str:
    """A paragraph in lines for a terminal, none of which begins with a unit."""
    return fill(tied(text), LINE, break_long_words=False, break_on_hyphens=False).replace(NO_BREAK, " ")


def _captioned(table: Table) -> str:
    parts = (table.caption, plain_table(table), broken(table.note))
    return "\n".join(part for part in parts if part)


def plain_table(table: Table) -> str:
    """The head and the rows in aligned columns two spaces apart, for a terminal; without caption and note."""
    lines = [tuple(column.title for column in table.columns)]
    for row in table.rows:
        cells = (_wrapped(cell.strip(), column.width) for cell, column in zip(row, table.columns, strict=True))
        lines += zip_longest(*cells, fillvalue="")
    # A head is two characters narrower than its column, so that heads of several words stand apart.
    widths = [max([len(head) + 2, *map(len, cells)]) for head, *cells in zip(*lines, strict=True)]
    sides = [">" if column.kind == "number" else "<" for column in table.columns]
    aligned = (map(format, line, map("{}{}".format, sides, widths)) for line in lines)
    return "\n".join("  ".join(cells).rstrip() for cells in aligned)


def _wrapped(cell: str, width: int | None) -> list[str]:
    return [cell] if width is None else wrap(cell, width, break_on_hyphens=False)


def markdown_text(text: str) -> str:
    r"""Plain text on one line, with nothing in it that Markdown or HTML would read as markup, a mention or a link.

    Mentions and bare addresses are kept apart by a word joiner, U+2060, which has no width.

    Examples
    --------
    >>> markdown_text("U_ave < 2 kV")
    'U\\_ave &lt; 2 kV'
    """
    plain = visible(" ".join(text.split()))
    apart = _LINKS.sub(lambda match: f"{match[0]}\u2060", plain)
    return _MARKS.sub(r"\\\1", apart.translate(_ENTITIES))


def markdown_of(table: Table, written: Callable[[str], str] = markdown_text) -> str:
    """A table under its caption, without its note, as Markdown; the caption as a sentence where it has no rows.

    Parameters
    ----------
    table : Table
    written : callable
        Makes Markdown of the text of a caption, a head or a cell.
    """
    caption = written(table.caption)
    if not table.rows:
        return f"{caption}.\n"
    rows = [[written(column.title) for column in table.columns]]
    rows += [[written(cell) for cell in row] for row in table.rows]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    lines.insert(1, f"|{'|'.join('---:' if column.kind == 'number' else '---' for column in table.columns)}|")
    return "\n".join((f"**{caption}**\n", *lines, ""))


def html_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in HTML for a notebook, its text inert."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
