"""A figure as a drawing in SVG, and the sizes of texts: each is measured once for all figures, laid out and drawn."""

from __future__ import annotations

import re
from functools import lru_cache
from io import StringIO
from typing import Any, Literal

from matplotlib.backend_bases import FigureCanvasBase, RendererBase
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

PER_INCH = 72
"""Points, in which figures are laid out and drawn."""

_HEAD = re.compile(r'.*?viewBox="0 0 (?P<width>[\d.]+) (?P<height>[\d.]+)".*?</defs>\s*', re.DOTALL)
"""What Matplotlib writes before the drawing."""

_NEEDLESS = re.compile(r""" font-family: 'DejaVu Sans';| transform="rotate\(-0 [^"]*\)\"""")
"""What says nothing."""


# Matplotlib keeps sizes for one renderer alone; layout and drawing use two, and without this take a sixth longer.
@lru_cache(4096)
def text_size(text: str, font: FontProperties, mathematics: bool = False) -> tuple[float, float, float]:
    """Width, height and descent of a text [pt], in a font that nobody changes any more."""
    width, height, descent = text_to_path.get_text_width_height_descent(text, font, mathematics)
    return width, height, descent


class _Ruler(RendererBase):
    """What measures texts, and draws nothing."""

    def get_text_width_height_descent(
        self, s: str, prop: FontProperties, ismath: bool | Literal["TeX"]
    ) -> tuple[float, float, float]:
        return text_size(s, prop, bool(ismath))


class _Drawing(_Ruler, RendererSVG):
    """What draws in SVG, without a group around each artist and the identifier of that."""

    def open_group(self, s: str, gid: str | None = None) -> None:
        pass

    def close_group(self, s: str) -> None:
        pass


class LayoutCanvas(FigureCanvasBase):
    """The canvas of a figure for as long as it is laid out, in points."""

    _ruler = _Ruler()

    def get_renderer(self) -> RendererBase:
        """What measures the texts."""
        return self._ruler


def drawing(figure: Figure) -> tuple[str, str]:
    """The view box of a figure, and its drawing as elements of SVG, the same in every run."""
    file, dpi = StringIO(), figure.dpi
    figure.dpi = PER_INCH  # as it was laid out, so that nothing moves
    nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    renderer: Any = _Drawing(*figure.bbox.size, file, image_dpi=dpi, metadata=nothing)  # type: ignore[no-untyped-call]
    figure.draw(renderer)
    renderer.finalize()
    figure.dpi = dpi
    # The head that is cut off declares the prefix, which HTML does not know either.
    text = file.getvalue().replace("xlink:href", "href")
    head = _HEAD.match(text)
    if head is None:
        raise ValueError("Matplotlib wrote an SVG file without a head that is known")
    elements = _NEEDLESS.sub("", text[head.end() :].removesuffix("</svg>\n"))
    return f"0 0 {head['width']} {head['height']}", re.sub(r"\n\s*", "\n", elements)
