"""A figure as a drawing in SVG and in pixels, and the sizes of texts: each is measured once for all figures.

A figure is laid out and drawn once, in SVG; its lines, markers and texts are then drawn again in pixels where they are.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import lru_cache
from io import BytesIO, StringIO
from typing import Any, Literal

import numpy as np
from matplotlib.backend_bases import FigureCanvasBase, RendererBase
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from matplotlib.transforms import Affine2D
from msgspec import Struct
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from vireport.base.files import WRITTEN_BY

PER_INCH = 72
"""Points, in which figures are laid out and drawn."""

PNG_LEVEL = 3
"""Of compression: with the usual 6 files are 3 % smaller, and saved in one and a half times the time."""

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


Stroke = Callable[[Any], None]
"""What draws a line, markers or a text in pixels."""


class _Drawing(_Ruler, RendererSVG):
    """What draws in SVG, without a group around each artist and the identifier of that, and records what it draws.

    Parameters
    ----------
    width, height : float
        Of the figure [pt].
    file : StringIO
    dpi : float
        Pixels to an inch of images, and of what is recorded.
    recorded : bool
        Whether what is drawn is recorded.
    """

    def __init__(self, width: float, height: float, file: StringIO, dpi: float, recorded: bool) -> None:
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        super().__init__(width, height, file, image_dpi=dpi, metadata=nothing)  # type: ignore[no-untyped-call]
        self.strokes: list[Stroke] = []
        self.recorded = recorded
        self._scale = Affine2D().scale(dpi / PER_INCH)

    def open_group(self, s: str, gid: str | None = None) -> None:
        pass

    def close_group(self, s: str) -> None:
        pass

    def draw_path(self, gc: object, path: object, transform: object, rgbFace: object = None) -> None:
        if self.recorded:
            context, place = self._kept(gc), self._placed(transform)
            self.strokes.append(lambda pixels: pixels.draw_path(context, path, place, rgbFace))
        super().draw_path(gc, path, transform, rgbFace)  # type: ignore[no-untyped-call]

    def draw_markers(
        self,
        gc: object,
        marker_path: object,
        marker_trans: object,
        path: object,
        trans: object,
        rgbFace: object = None,
    ) -> None:
        if self.recorded:
            context, form, places = self._kept(gc), self._placed(marker_trans), self._placed(trans)
            self.strokes.append(lambda pixels: pixels.draw_markers(context, marker_path, form, path, places, rgbFace))
        super().draw_markers(gc, marker_path, marker_trans, path, trans, rgbFace)  # type: ignore[no-untyped-call]

    def draw_text(
        self, gc: object, x: float, y: float, s: str, prop: object, angle: float, ismath: Any = False, mtext: Any = None
    ) -> None:
        if self.recorded:
            context, at = self._kept(gc), self._scale.transform((x, y))
            self.strokes.append(lambda pixels: pixels.draw_text(context, *at, s, prop, angle, ismath, mtext))
        super().draw_text(gc, x, y, s, prop, angle, ismath, mtext)  # type: ignore[no-untyped-call]

    def draw_image(self, *args: object, **kwargs: object) -> None:
        self.recorded = False
        super().draw_image(*args, **kwargs)  # type: ignore[no-untyped-call]

    def draw_path_collection(self, *args: object, **kwargs: object) -> None:
        self.recorded = False
        super().draw_path_collection(*args, **kwargs)  # type: ignore[no-untyped-call]

    def draw_gouraud_triangles(self, *args: object, **kwargs: object) -> None:
        self.recorded = False
        super().draw_gouraud_triangles(*args, **kwargs)  # type: ignore[no-untyped-call]

    def _kept(self, gc: Any) -> object:
        """A copy of a graphics context, which Matplotlib uses again, for pixels."""
        context: Any = self.new_gc()
        context.copy_properties(gc)
        if (clip := gc.get_clip_rectangle()) is not None:
            context.set_clip_rectangle(clip.transformed(self._scale))
        if gc.get_clip_path()[0] is not None:
            self.recorded = False
        return context

    def _placed(self, transform: Any) -> object:
        """Where a transform, which may change with the figure, leads to in pixels."""
        return Affine2D((transform.frozen() + self._scale).get_matrix())


class LayoutCanvas(FigureCanvasBase):
    """The canvas of a figure for as long as it is laid out, in points."""

    _ruler = _Ruler()

    def get_renderer(self) -> RendererBase:
        """The renderer by which Matplotlib measures texts."""
        return self._ruler


class Drawn(Struct, frozen=True, eq=False):
    """A figure as it was drawn.

    Attributes
    ----------
    box : str
        The view box in SVG.
    elements : str
        The elements of SVG, the same in every run.
    strokes : tuple of callable, optional
        What draws it in pixels; None where it was not recorded, or holds more than lines, markers and texts.
    """

    box: str
    elements: str
    strokes: tuple[Stroke, ...] | None

    @property
    def size(self) -> tuple[str, str]:
        """Width and height [pt], as they are written."""
        _, _, width, height = self.box.split()
        return width, height


def drawing(figure: Figure, recorded: bool = True) -> Drawn:
    """Draw a figure that is laid out, `recorded` where it will be drawn in pixels as well."""
    file, dpi = StringIO(), figure.dpi
    figure.dpi = PER_INCH  # as it was laid out, so that nothing moves
    renderer: Any = _Drawing(*figure.bbox.size, file, dpi, recorded)
    figure.draw(renderer)
    renderer.finalize()
    figure.dpi = dpi
    # The head that is cut off declares the prefix, which HTML does not know either.
    text = file.getvalue().replace("xlink:href", "href")
    head = _HEAD.match(text)
    if head is None:
        raise ValueError("Matplotlib wrote an SVG file without a head that is known")
    elements = re.sub(r"\n\s*", "\n", _NEEDLESS.sub("", text[head.end() :].removesuffix("</svg>\n")))
    strokes = tuple(renderer.strokes) if renderer.recorded else None
    return Drawn(f"0 0 {head['width']} {head['height']}", elements, strokes)


def png(figure: Figure, strokes: Iterable[Stroke] | None = None) -> bytes:
    """A figure as a PNG file, of the strokes that it was drawn with or, without these, as Matplotlib draws it."""
    renderer: Any = figure.canvas
    if strokes is None:
        renderer.draw()
    else:
        renderer = RendererAgg(*figure.bbox.size, figure.dpi)  # type: ignore[no-untyped-call]
        for stroke in strokes:
            stroke(renderer)
    file, written = BytesIO(), PngInfo()
    written.add_text("Software", WRITTEN_BY)
    image = Image.fromarray(np.asarray(renderer.buffer_rgba())).convert("RGB")
    image.save(file, "PNG", dpi=(figure.dpi, figure.dpi), pnginfo=written, compress_level=PNG_LEVEL)
    return file.getvalue()
