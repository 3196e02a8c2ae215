"""Tables of text, set by `tabulate` for a terminal or as Markdown; the report's templates set the same records."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from textwrap import fill
from typing import ClassVar, Literal

LINE = 110
"""Characters after which a paragraph is broken on a terminal."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    title : str
    kind : str
        ``text``, ``number`` (aligned at the right) or ``code``.
    width : int or None
        Characters after which a terminal breaks a cell; None where it never does.
    """

    title: str
    kind: Literal["text", "number", "code"] = "text"
    width: int | None = None


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a head.

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


def numbers(*titles: str) -> tuple[Column, ...]:
    """Columns of numbers."""
    return tuple(Column(title, "number") for title in titles)


def texts(*titles: str) -> tuple[Column, ...]:
    """Columns of text."""
    return tuple(Column(title) for title in titles)


def plain_text(parts: Iterable[str | Table]) -> str:
    """Paragraphs, broken into lines, and tables under their captions, for a terminal; a blank line between them."""
    return "\n\n".join(broken(part) if isinstance(part, str) else _captioned(part) for part in parts)


def broken(text: str, indent: str = "") -> str:
    """A paragraph in lines for a terminal; all but the first are indented."""
    return fill(text, LINE, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def _captioned(table: Table) -> str:
    parts = (table.caption, plain_table(table), broken(table.note))
    return "\n".join(part for part in parts if part)


def plain_table(table: Table) -> str:
    """The head and the rows in aligned columns two spaces apart, for a terminal; without caption and note."""
    from tabulate import tabulate

    sides = _sides(table)
    widths = [column.width for column in table.columns]
    lines = tabulate(
        table.rows,
        _titles(table),
        "plain",
        colalign=sides,
        headersalign=sides,
        maxcolwidths=widths,
        break_on_hyphens=False,
        disable_numparse=True,
    )
    return "\n".join(line.rstrip() for line in lines.splitlines())


def markdown_table(table: Table) -> str:
    """The head and the rows as a table of GitHub-flavoured Markdown; without caption and note."""
    from tabulate import tabulate

    sides = _sides(table)
    # The bar is the one mark that ends a cell.
    heads, *rows = ([cell.replace("|", "\\|") for cell in row] for row in (_titles(table), *table.rows))
    return tabulate(rows, heads, "pipe", colalign=sides, headersalign=sides, disable_numparse=True)


def _titles(table: Table) -> tuple[str, ...]:
    return tuple(column.title for column in table.columns)


def _sides(table: Table) -> list[str]:
    return ["right" if column.kind == "number" else "left" for column in table.columns]
