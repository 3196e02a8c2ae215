"""Every figure of a study, drawn from its numbers, with caption and alternative text."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.figures.captions import about, alt_text, held, held_by, shown_along, swept_range, title_of
from vireport.figures.curves import PairedImpacts, simulated_points
from vireport.figures.labels import Label
from vireport.figures.layout import Entry, blank, finished, letter_of, prefix, round_ticks
from vireport.figures.overlay import SCENARIO_COLORS, has_stable, overlay
from vireport.figures.pictures import measured_pictures, pictures
from vireport.figures.planes import DESIGN, mark_design
from vireport.figures.style import (
    FILLS,
    HALO,
    LOCI,
    PER_LETTER,
    Color,
    Look,
    Picture,
    Pixel,
    Sheet,
    drawn_for,
    figure_css,
    literal,
    png_of,
    sheet,
    style,
)
from vireport.figures.sweeps import OUTCOMES, Drawing, drawing_of, figure_2, figure_4, figure_7, sweep_figure

if TYPE_CHECKING:
    from vireport.figures.record import record_picture
else:
    __getattr__ = deferred(__name__, "record")

__all__ = [
    "DESIGN",
    "FILLS",
    "HALO",
    "LOCI",
    "OUTCOMES",
    "PER_LETTER",
    "SCENARIO_COLORS",
    "Color",
    "Drawing",
    "Entry",
    "Label",
    "Look",
    "PairedImpacts",
    "Picture",
    "Pixel",
    "Sheet",
    "about",
    "alt_text",
    "blank",
    "drawing_of",
    "drawn_for",
    "figure_2",
    "figure_4",
    "figure_7",
    "figure_css",
    "finished",
    "has_stable",
    "held",
    "held_by",
    "letter_of",
    "literal",
    "mark_design",
    "measured_pictures",
    "overlay",
    "pictures",
    "png_of",
    "prefix",
    "record_picture",
    "round_ticks",
    "sheet",
    "shown_along",
    "simulated_points",
    "style",
    "sweep_figure",
    "swept_range",
    "title_of",
]
