"""A figure of panels in rows and columns: rows share their vertical axis, each column has its own along the sweep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from string import ascii_lowercase

from vireport.figures.axes import BLACK, LETTERS_ALONG, SMALL, Along
from vireport.figures.panel import Panel
from vireport.figures.sheet import (
    ACROSS,
    BOTTOM,
    LEFT,
    RIGHT,
    ROW,
    TOP_AXIS,
    WIDTH,
    Entry,
    Page,
    Place,
    Ticks,
    blank,
    wrapped,
)
from vireport.figures.ticks import fitting_ticks

APART, BETWEEN = 0.15, 0.22
"""Gaps between columns and between rows [in]."""

TITLE_ROW = 0.15
"""Height of a line over a column [in]."""

NARROW = 0.54
"""Mean width of a letter over the size of type, where a line is broken."""

SHORT = {
    "distance d = 4 M s f² / F [–]": "distance d [–]",
    "gravity ḡ = M g sin β / F [–]": "gravity ḡ [–]",
    "force amplitude F [N]": "force F [N]",
}
"""Labels of an axis along the sweep where a column is too narrow for the whole."""

LETTER_ROOM = 8
"""Letters that the letters of the panels take of the line in which an axis is labelled."""


@dataclass(frozen=True, slots=True)
class Column:
    """What is over a column, and its axis along the sweep.

    Attributes
    ----------
    title : str
    remark : str
        Under it.
    along : Along
    """

    title: str
    remark: str
    along: Along


@dataclass(frozen=True, slots=True)
class Grid(Page):
    """A figure of panels in rows and columns.

    Attributes
    ----------
    columns : tuple of Column
    rows : tuple of (float, float)
        Bottom and height of each [in], from the top one down.
    """

    columns: tuple[Column, ...]
    rows: tuple[tuple[float, float], ...]

    def panel(
        self, row: int, column: int, label: str, limits: tuple[float, float] | None, y_ticks: Ticks | None
    ) -> Panel:
        """A panel with its axes; those of the first column have the labels of the row.

        Parameters
        ----------
        row, column : int
        label : str
            Of the vertical axis.
        limits : tuple of float or None
            Of the row; None where it has nothing to show.
        y_ticks : tuple of sequences or None
            Values and labels; None for round numbers.
        """
        along, count = self.columns[column].along, len(self.columns)
        bottom, height = self.rows[row]
        left, across = _across(column, count)
        place: Place = (left, bottom, across, height)
        panel = self.frame(place, along.limits, limits or (0.0, 1.0), row == 0)
        ticks = fitting_ticks(along.low, along.high, letters_along(count))
        self.along_bottom(panel, place, ticks, _fitting(along.label, count) if row + 1 == len(self.rows) else None)
        if row == 0:
            self.along_top(panel, place, along.top, _fitting(along.top_label, count))
        if limits:
            values, texts = y_ticks or fitting_ticks(*limits, LETTERS_ALONG, 6)
            self.along_side(panel, place, (values, texts if column == 0 else [""] * len(texts)))
        if column == 0:
            self.words(0.08, bottom + height / 2, label, rotation=90, ha="left", va="center")
        over = 0.22 if row == 0 else 0.05
        letter = panel_letter(row, column, len(self.rows))
        self.words(left, bottom + height + over, letter, ha="left", va="bottom", size=SMALL)
        return panel


def panel_letter(row: int, column: int, rows: int) -> str:
    """The letter of a panel: down the columns, as the paper has them."""
    return f"({ascii_lowercase[column * rows + row]})"


def letters_along(columns: int) -> int:
    """How many letters of the small size fit along a panel."""
    return int(LETTERS_ALONG * _across(0, columns)[1] / ACROSS)


def _across(column: int, count: int) -> tuple[float, float]:
    """Left end and width of a column [in]."""
    across = (WIDTH - LEFT - RIGHT - (count - 1) * APART) / count
    return LEFT + column * (across + APART), across


def _fitting(label: str, count: int) -> str:
    return SHORT.get(label, label) if len(label) + LETTER_ROOM > letters_along(count) else label


def grid(
    columns: Sequence[Column],
    rows: int,
    row_height: float,
    head: Sequence[tuple[str, str]],
    legend: Sequence[Sequence[Entry]],
) -> Grid:
    """An empty figure: lines of text, a legend, titles over the columns, and room for the panels.

    Parameters
    ----------
    columns : sequence of Column
    rows : int
    row_height : float
        [in]
    head : sequence of (str, str)
        Lines of text and their colours; those too long are broken.
    legend : sequence of sequences of (str, dict)
        Each begins a line.
    """
    count = len(columns)
    lines = wrapped(legend)
    broken = [(part, color) for text, color in head for part in _broken(text, _most(ACROSS))]
    titles = [_broken(one.title, _most(_across(0, count)[1])) for one in columns]
    remarks = [_broken(one.remark, _most(_across(0, count)[1])) for one in columns]
    deepest = max(len(title) + len(remark) for title, remark in zip(titles, remarks, strict=True))
    panels = rows * row_height + (rows - 1) * BETWEEN
    height = BOTTOM + panels + TOP_AXIS + TITLE_ROW * deepest + ROW * (len(broken) + len(lines)) + 0.10
    places = tuple((BOTTOM + (rows - 1 - k) * (row_height + BETWEEN), row_height) for k in range(rows))
    made = Grid(blank(height), height, tuple(columns), places)
    made.heading(broken, lines)
    for k, (title, remark) in enumerate(zip(titles, remarks, strict=True)):
        left, across = _across(k, count)
        y = BOTTOM + panels + TOP_AXIS + TITLE_ROW * (len(title) + len(remark) - 0.5)
        for text, weight in [(part, "bold") for part in title] + [(part, "normal") for part in remark]:
            made.words(left + across / 2, y, text, ha="center", va="center", size=SMALL, color=BLACK, weight=weight)
            y -= TITLE_ROW
    return made


def _most(width: float) -> int:
    """Letters of the small size in a width [in]."""
    return int(72 * width / (NARROW * SMALL))


def _broken(text: str, most: int) -> list[str]:
    """A text in lines of at most so many letters, broken at spaces, and within words where there is no other way."""
    lines: list[str] = []
    for word in text.split(" ") if text else []:
        while True:
            if lines and len(lines[-1]) + 1 + len(word) <= most:
                lines[-1] += f" {word}"
                break
            lines.append(word[:most])
            word = word[most:]
            if not word:
                break
    return lines
