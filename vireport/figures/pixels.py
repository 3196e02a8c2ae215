"""Writes a figure as a PNG of few colours: the inks, and their shades towards the paper and each other.

Half the size of the same picture in full colour, and a fifth of the time; the paper stays exactly white.
"""

from __future__ import annotations

from functools import cache
from io import BytesIO
from itertools import combinations

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from vireport.figures.axes import BLACK, BLUE, DPI, GREEN, ORANGE, PURPLE, SKY, VERMILION, WARNING

WHITE = (255, 255, 255)

STEP, GREY_STEP = 14, 5
"""Least difference of two shades, below which edges look no smoother; greys show a tint sooner."""

NEAR_WHITE = 247
"""Shades from here on are left out: Pillow looks colours up in steps of four, the paper would take one."""

OVERLAPS = (BLACK, BLUE, GREEN, VERMILION, PURPLE)
"""Inks that are drawn over one another."""

SHADES_BETWEEN = 8
"""Of two inks that overlap."""

Color = tuple[int, int, int]


def png_of(figure: Figure) -> tuple[bytes, int, int]:
    """Draw a figure, and return it as a PNG file with its width and height in pixels."""
    canvas = figure.canvas
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())  # type: ignore[attr-defined]
    image = Image.fromarray(pixels).convert("RGB").quantize(palette=_palette(), dither=Image.Dither.NONE)
    data = BytesIO()
    image.save(data, "png", dpi=(DPI, DPI), compress_level=4)
    return data.getvalue(), image.width, image.height


@cache
def _palette() -> Image.Image:
    inks = [_color(ink) for ink in (BLACK, BLUE, GREEN, VERMILION, PURPLE, SKY, ORANGE, WARNING)]
    colors: list[Color] = []
    for ink in inks:
        step = GREY_STEP if len(set(ink)) == 1 else STEP
        colors += _shades(WHITE, ink, max(max(b - a for a, b in zip(ink, WHITE, strict=True)) // step, 2))
    for one, two in combinations([_color(ink) for ink in OVERLAPS], 2):
        colors += _shades(one, two, SHADES_BETWEEN)[:-1]
    colors = [WHITE, *(color for color in colors if min(color) < NEAR_WHITE)]
    image = Image.new("P", (1, 1))
    image.putpalette([channel for color in dict.fromkeys(colors) for channel in color])
    return image


def _shades(start: Color, end: Color, count: int) -> list[Color]:
    """Evenly spaced colours from one to another, the first left out."""
    parts = [k / count for k in range(1, count + 1)]
    return [tuple(round(a + (b - a) * part) for a, b in zip(start, end, strict=True)) for part in parts]  # type: ignore[misc]


def _color(ink: str) -> Color:
    red, green, blue = (int(ink[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue
