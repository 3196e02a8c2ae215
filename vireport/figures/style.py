"""The look of every figure, whatever the user's settings, and the picture with its words that a figure becomes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from typing import Any

import matplotlib
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font

Look = dict[str, Any]
"""Properties of a line or of markers, as `matplotlib.lines.Line2D` takes them."""


class Color:
    """The colours of Okabe and Ito, which colour-blind readers tell apart, and greys."""

    BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
    BLUE, VERMILION, PURPLE = "#0072B2", "#D55E00", "#CC79A7"
    GREY, LIGHT = "#767676", "#D8D8D8"
    WARNING = "#A33A00"
    """Vermilion, dark enough for text."""


DASHED: Any = (0, (5, 2))
DASH_DOTTED: Any = (0, (5, 1.6, 1, 1.6))
DOTTED: Any = (0, (1, 1.5))

GUIDE: Look = {"color": Color.LIGHT, "linewidth": 0.6, "zorder": 1.0}

WIDTH = 6.7
"""Of every figure [in]: the text of an A4 page."""

DPI = 150

TEXT, SMALL = 8.5, 8.0
"""Sizes of type [pt]."""

UNRELATED = {"backend", "backend_fallback", "interactive", "timezone", "toolbar"}
"""Settings of Matplotlib that have no part in how a figure looks."""

STYLE: dict[Any, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": TEXT,
    "text.hinting": "none",
    "figure.dpi": DPI,
    "figure.constrained_layout.h_pad": 0.03,
    "figure.constrained_layout.w_pad": 0.05,
    "figure.constrained_layout.hspace": 0.0,
    "figure.constrained_layout.wspace": 0.0,
    "axes.linewidth": 0.7,
    "axes.titlesize": SMALL,
    "axes.titlepad": 4.0,
    "axes.formatter.useoffset": False,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
    "legend.fontsize": SMALL,
    "legend.handlelength": 2.6,
    "legend.columnspacing": 1.4,
    "legend.borderpad": 0.0,
    "legend.borderaxespad": 0.0,
    "lines.dash_capstyle": "butt",
    "lines.scale_dashes": False,
    "svg.hashsalt": "vireport",
}


@contextmanager
def style() -> Iterator[None]:
    """The look of the figures, whatever the user has set; the user's settings are there again afterwards.

    `matplotlib.rcdefaults` would do as well, but it reads all style sheets first.
    """
    current = matplotlib.rcParams
    changed: dict[Any, Any] = {
        key: value
        for key, value in matplotlib.rcParamsDefault.items()
        if key not in UNRELATED and current[key] != value
    }
    with matplotlib.rc_context(changed | STYLE):
        yield


NUMBERS = {"margins": "8", "accuracy": "9", "stiffness": "10", "diagram": "11"}
"""Of the figures that the paper does not have."""


class NotebookFigure(Figure):
    """A figure that a notebook shows as it would be written to a file, without pyplot."""

    def _repr_png_(self) -> bytes:
        return png_of(self)


def png_of(figure: Figure) -> bytes:
    """Save a figure as a PNG file; the same figure gives the same bytes in every run."""
    file = BytesIO()
    canvas: Any = figure.canvas
    with style():
        # `Figure.savefig` does the same, but first lays the figure out, which is final already.
        canvas.print_png(file, metadata={"Software": None})
    return file.getvalue()


def literal(text: str) -> str:
    """Text that is not ours as a figure shows it: no dollar sign begins mathematics, no character is missing.

    What the font lacks is given by its number in Unicode, as in the PDF report.
    """
    font = get_font(findfont(FontProperties(family=STYLE["font.family"])))
    shown = (x if x.isspace() or font.get_char_index(ord(x)) else f"⟨U+{ord(x):04X}⟩" for x in text)
    return "".join(shown).replace("$", "\\$")


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure with its words.

    Attributes
    ----------
    name : str
        Of its file, without the suffix.
    title, caption, alt : str
    figure : Figure
    """

    name: str
    title: str
    caption: str
    alt: str
    figure: Figure

    @property
    def number(self) -> str:
        """By which it is referred to: that of the paper's figure, or one after them; of a further page in brackets."""
        number, _, page = self.name.removeprefix("figure-").partition("-")
        return f"{NUMBERS.get(number, number)}{f' ({page})' if page else ''}"

    @cached_property
    def png(self) -> bytes:
        """The figure as a PNG file."""
        return png_of(self.figure)

    @property
    def width(self) -> int:
        """Of the PNG file [px]."""
        return int(self.figure.bbox.width)

    @property
    def height(self) -> int:
        """Of the PNG file [px]."""
        return int(self.figure.bbox.height)
