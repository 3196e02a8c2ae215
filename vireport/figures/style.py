"""The look of every figure, whatever the user's settings, and the picture with its words that a figure becomes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, cached_property
from html import escape
from io import BytesIO
from typing import Any

import matplotlib
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from msgspec import Struct, field
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.base.files import WRITTEN_BY
from vireport.figures.vector import Drawn, drawing, png

Look = dict[str, Any]
"""Properties of a line or of markers, as `matplotlib.lines.Line2D` takes them."""


class Color:
    """The colours of Okabe and Ito, which colour-blind readers tell apart, and greys."""

    BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
    BLUE, VERMILION, PURPLE = "#0072B2", "#D55E00", "#CC79A7"
    GREY, LIGHT = "#767676", "#D8D8D8"
    WARNING = "#A33A00"
    """Vermilion, dark enough for text."""
    WHITE = "#FFFFFF"
    FILL_A, FILL_B, FILL_C, FILL_D = "#D3E8F7", "#FAD58A", "#A9DCC3", "#E8B9D2"
    FILL_E, FILL_F, FILL_G = "#8FC1E3", "#E39A63", "#B0A78F"
    """Of areas under texts, from light to dark, so that they are apart in grey as well."""


class Pixel:
    """Colours of pictures made of pixels, and in their legends: no dark page exchanges them."""

    LIGHT, ORANGE, PURPLE, SKY, GREEN, GREY = "#D9D9D9", "#E69F01", "#CC79A8", "#56B4EA", "#009E74", "#767677"
    BLACK, WHITE = "#000001", "#FEFEFE"

    @staticmethod
    def like(color: str) -> str:
        """The one that looks like some `Color`; that one itself where there is none."""
        name = next((name for name, value in vars(Color).items() if value == color), "")
        return str(getattr(Pixel, name, color))


ON_DARK = {
    Color.BLACK: "#e7e9eb", Color.ORANGE: "#f0b429", Color.SKY: "#7cc7f2", Color.GREEN: "#2fc79b",
    Color.BLUE: "#4da6e8", Color.VERMILION: "#ff8a3d", Color.PURPLE: "#e39ac2", Color.GREY: "#a0a6ad",
    Color.LIGHT: "#3d434a", Color.WARNING: "#ffa06b", Color.WHITE: "#14171b",
    Color.FILL_A: "#1d3b52", Color.FILL_B: "#5a4410", Color.FILL_C: "#14503c", Color.FILL_D: "#5b3049",
    Color.FILL_E: "#2b648d", Color.FILL_F: "#7a3f14", Color.FILL_G: "#4f4a38",
}  # fmt: skip
"""What each colour becomes on a dark page."""


DASHED: Any = (0, (5, 2))
DASH_DOTTED: Any = (0, (5, 1.6, 1, 1.6))
DOTTED: Any = (0, (1, 1.5))

LOCI: dict[str, tuple[str, Look]] = {
    "period_doubling": ("period doubling (B)", {"color": Color.BLACK, "linestyle": "-"}),
    "fold": ("fold (C)", {"color": Color.VERMILION, "linestyle": (0, (5, 1.6))}),
    "pitchfork": ("pitchfork (C)", {"color": Color.GREEN, "linestyle": (0, (5, 1.6))}),
    "grazing": ("grazing (G)", {"color": Color.PURPLE, "linestyle": (0, (1.2, 1.2))}),
    "node_focus": ("node to focus (A)", {"color": Color.GREY, "linestyle": "-", "linewidth": 0.7}),
}
"""Name and look of the curves in a plane of two inputs along which motions change, by what happens there."""

FILLS = Color.FILL_A, Color.FILL_B, Color.FILL_C, Color.FILL_D, Color.FILL_E, Color.FILL_F, Color.FILL_G
"""Colours of areas, the first ones first."""

HALO = 2.8
"""Width of the white under such a curve [pt]."""

GUIDE: Look = {"color": Color.LIGHT, "linewidth": 0.6, "zorder": 1.0}

WIDTH = 6.7
"""Width of every figure [in]: that of the text of an A4 page."""

DPI = 150

TEXT, SMALL = 8.5, 8.0
"""Sizes of type [pt]."""

NARROWEST, WIDEST = 60, 250
"""Widths that a caller's figures may have [mm]: a column of a paper is 80 to 90 wide, its page up to 190."""

PER_LETTER = 0.58
"""Mean width of a letter over its size."""

BESIDE_PANELS = 0.95
"""Room beside the panels of a figure for ticks and labels [in], for the choice of ticks."""

UNRELATED = {"backend", "backend_fallback", "interactive", "timezone", "toolbar"}
"""Settings of Matplotlib that have no part in how a figure looks."""


class Sheet(Struct, frozen=True):
    """What figures are drawn for: the page of a report, or the column of a paper.

    Attributes
    ----------
    width : float
        Of a figure [in].
    headed : bool
        Whether a figure says what is held along it. In a paper its caption does.
    settings : mapping
        Of Matplotlib (`matplotlib.rcParams`), which come before ours: the caller's fonts and their size.
    """

    width: float = WIDTH
    headed: bool = True
    settings: Mapping[str, Any] = {}

    @staticmethod
    def of(width_mm: float | None = None, settings: Mapping[str, object] | None = None) -> Sheet:
        """The sheet for figures of some width or, without one, the sheet that figures are drawn for just now.

        Parameters
        ----------
        width_mm : float, optional
            Of a figure, 60 to 250; of that of a report by default.
        settings : mapping, optional
            Of Matplotlib.

        Raises
        ------
        UsageError
            For another width.
        """
        if width_mm is None and settings is None:
            return sheet()
        if width_mm is not None and not NARROWEST <= width_mm <= WIDEST:
            raise UsageError(f"figures are {NARROWEST} to {WIDEST} mm wide (got {width_mm:g} mm)")
        return Sheet(WIDTH if width_mm is None else width_mm / 25.4, False, settings or {})

    @property
    def text(self) -> float:
        """Size of the type of labels and ticks [pt]."""
        return float(self.settings.get("font.size", TEXT))

    @property
    def small(self) -> float:
        """Size of type of what is said beside the curves [pt]."""
        return self.text * SMALL / TEXT

    @property
    def letter(self) -> float:
        """Mean width of a letter of the small size [in]."""
        return PER_LETTER * self.small / 72

    @property
    def across(self) -> float:
        """Width of a panel, or of the panels beside one another, for the choice of ticks [in]."""
        return self.width - BESIDE_PANELS

    def letters(self, width: float) -> int:
        """Letters of the small size in a line of some width [in]."""
        return int(width / self.letter)

    @property
    def fonts(self) -> list[str]:
        """The families of fonts, the preferred one first."""
        family = self.settings.get("font.family", STYLE["font.family"])
        return [family] if isinstance(family, str) else list(family)


_REPORT = Sheet()

_SHEET = ContextVar("_SHEET", default=_REPORT)


def sheet() -> Sheet:
    """What figures are drawn for just now."""
    return _SHEET.get()


@contextmanager
def drawn_for(requested: Sheet) -> Iterator[None]:
    """Within it figures are drawn for some sheet; they are for a report otherwise."""
    before = _SHEET.set(requested)
    try:
        yield
    finally:
        _SHEET.reset(before)


STYLE: dict[Any, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": TEXT,
    "text.hinting": "none",
    "figure.dpi": DPI,
    "axes.linewidth": 0.7,
    "axes.titlesize": SMALL,
    "axes.titlepad": 4.0,
    "axes.titley": 1.0,
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
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}
"""Texts in SVG files stay texts, and PDF files have TrueType fonts, as journals ask for."""

_STYLED = ContextVar[Sheet | None]("_STYLED", default=None)
"""The sheet whose look figures have just now."""

_SMALL = "axes.titlesize", "xtick.labelsize", "ytick.labelsize", "legend.fontsize"


@cache
def _defaults() -> dict[Any, Any]:
    """Matplotlib's settings that have a part in how a figure looks."""
    return {key: value for key, value in matplotlib.rcParamsDefault.items() if key not in UNRELATED}


@contextmanager
def style() -> Iterator[None]:
    """The look of the figures, whatever the user has set; the user's settings are there again afterwards.

    `matplotlib.rcdefaults` would do as well, but it reads all style sheets first. Within another one for the same sheet
    it leaves all as it is.
    """
    if _STYLED.get() is sheet():
        yield
        return
    current = matplotlib.rcParams
    changed: dict[Any, Any] = {key: value for key, value in _defaults().items() if current[key] != value}
    smaller = dict.fromkeys(_SMALL, sheet().small)
    before = _STYLED.set(sheet())
    try:
        with matplotlib.rc_context(changed | STYLE | smaller | dict(sheet().settings)):
            yield
    finally:
        _STYLED.reset(before)


class NotebookFigure(Figure):
    """A figure that a notebook shows without pyplot.

    Attributes
    ----------
    stretch : callable
        What makes it, and its panels with it, higher than they were drawn for by some inches.
    """

    stretch: Callable[[float], None]

    def _repr_png_(self) -> bytes:
        with style():
            return png(self)


SVG_FONTS = "DejaVu Sans, Libertinus Serif, sans-serif"
"""Fonts of the texts in an SVG file: the one they were laid out in, and the narrower one of the PDF report."""

_LINK = re.compile(r"</?a\b[^>]*>")
_COLOR = re.compile(r"#[0-9a-f]{6}\b")
_NAMES = {value.lower(): name.lower() for name, value in vars(Color).items() if name.isupper()}


def figure_css() -> str:
    """The colours of the figures within a page, on light and on dark, as custom properties."""
    light, dark = (
        "".join(f"--figure-{name}:{shades.get(value, value)};" for value, name in _NAMES.items())
        for shades in ({}, {value.lower(): shade for value, shade in ON_DARK.items()})
    )
    return (
        f":root{{{light}}}\n@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
        "svg.figure{display:block;width:100%;height:auto;min-width:35.5rem;max-width:62rem;fill:var(--figure-black)}\n"
        "@media print{svg.figure{min-width:0}}\n"
    )


def literal(text: str) -> str:
    """Text that is not ours as a figure shows it: no dollar sign begins mathematics, no character is missing.

    What the font lacks is given by its number in Unicode, as in the PDF report.
    """
    font = get_font(findfont(FontProperties(family=sheet().fonts)))
    # Of a character that the font lacks, Matplotlib warns and draws an empty box.
    characters = (
        character if character.isspace() or font.get_char_index(ord(character)) else f"⟨U+{ord(character):04X}⟩"
        for character in text
    )
    return "".join(characters).replace("$", "\\$")


class Picture(Struct, frozen=True, eq=False, dict=True):
    """A figure as it is written: its images, title, caption and alternative text.

    Attributes
    ----------
    name : str
        Of its file, without the suffix.
    title, caption, alt : str
    figure : Figure
    sheet : Sheet
        What it is drawn for.
    on_paper : float
        How much higher the PDF of a report has it [in].
    recorded : bool
        Whether a PNG file comes of what is drawn in SVG: otherwise it is drawn again for one.
    """

    name: str
    title: str
    caption: str
    alt: str
    figure: Figure
    sheet: Sheet = field(default_factory=sheet)
    on_paper: float = 0.0
    recorded: bool = True

    def __repr__(self) -> str:
        return f"<Picture {self.name}: {self.title}>"

    def _repr_svg_(self) -> str:
        return self.svg.decode()

    @cached_property
    def png(self) -> bytes:
        """The figure as a PNG file; the same figure gives the same bytes in every run."""
        with drawn_for(self.sheet), style():
            return png(self.figure, self._drawn.strokes)

    @cached_property
    def _drawn(self) -> Drawn:
        # All figures are in one page, where no two things have the same identifier.
        with drawn_for(self.sheet), style():
            matplotlib.rcParams["svg.hashsalt"] = self.name
            return drawing(self.figure, self.recorded)

    @cached_property
    def pdf(self) -> bytes:
        """The figure as a PDF file with TrueType fonts; the same figure gives the same bytes in every run."""
        from matplotlib.backends.backend_pdf import FigureCanvasPdf

        file, canvas, dpi = BytesIO(), self.figure.canvas, self.figure.dpi
        metadata: Any = {"Title": self.title, "Creator": WRITTEN_BY, "Producer": None, "CreationDate": None}
        with drawn_for(self.sheet), style():
            FigureCanvasPdf(self.figure).print_pdf(file, metadata=metadata)  # type: ignore[no-untyped-call]
        self.figure.set_canvas(canvas)
        self.figure.dpi = dpi
        return file.getvalue()

    @property
    def svg(self) -> bytes:
        """The figure as an SVG file with texts as texts; the same figure gives the same bytes in every run."""
        drawn = self._drawn
        width, height = drawn.size
        fonts = SVG_FONTS if self.sheet.fonts == STYLE["font.family"] else ", ".join(self.sheet.fonts)
        head = f'width="{width}pt" height="{height}pt" font-family="{escape(fonts)}" role="img"'
        return f"{_opened(head, drawn.box, self.alt)}{_LINK.sub('', drawn.elements)}</svg>\n".encode()

    @cached_property
    def printed(self) -> bytes:
        """The figure as the PDF of a report has it, as an SVG file."""
        if not self.on_paper:
            return self.svg
        figure: Any = self.figure
        with drawn_for(self.sheet), style():
            figure.stretch(self.on_paper)
            higher = replace(self, on_paper=0.0, recorded=False).svg
            figure.stretch(0.0)
        return higher

    @property
    def inline(self) -> str:
        """The figure as an element of an HTML page, with links, in the page's font; `figure_css` has its colours."""
        drawn = self._drawn
        head = f'class="figure" data-figure="{self.name}" role="group"'
        return f"{_opened(head, drawn.box, self.alt)}{_COLOR.sub(_property, drawn.elements)}</svg>"


def _property(color: re.Match[str]) -> str:
    """The custom property of one of our colours."""
    return f"var(--figure-{_NAMES[color[0]]})" if color[0] in _NAMES else color[0]


def _opened(attributes: str, box: str, alt: str) -> str:
    """The first tag of a drawing in SVG."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" {attributes} aria-label="{escape(alt)}" '
        'stroke-linejoin="round" stroke-linecap="butt">\n'
    )
