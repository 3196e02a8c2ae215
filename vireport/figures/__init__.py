"""Every figure of a study, drawn from its numbers."""

from vireport.figures import sheet
from vireport.figures.axes import BLACK, DPI, PURPLE, SMALL, VERMILION, WARNING, limits, prefix, style
from vireport.figures.captions import OUTSIDE, TITLES, alt_text, column_caption, held, outside_geometry
from vireport.figures.curves import Floats, Simulated, Stretch
from vireport.figures.drawing import Drawing, point_legend
from vireport.figures.grid import Column, grid, letters_along, panel_letter
from vireport.figures.measured_figures import measured_figures
from vireport.figures.overlay import simulated_points
from vireport.figures.panel import Panel
from vireport.figures.paper_figures import Picture, figure_2, figure_4, figure_7, pictures
from vireport.figures.pixels import png_of
from vireport.figures.rows import (
    BRANCH_COLORS,
    Row,
    legend_2,
    legend_4,
    legend_7,
    rows_2,
    rows_4,
    rows_7,
    seen_7,
    without_mirrors,
)
from vireport.figures.sheet import ROW, WIDTH, Entry, Page, Place, wrapped
from vireport.figures.ticks import fitting_ticks

__all__ = [
    "BLACK",
    "BRANCH_COLORS",
    "DPI",
    "OUTSIDE",
    "PURPLE",
    "ROW",
    "SMALL",
    "TITLES",
    "VERMILION",
    "WARNING",
    "WIDTH",
    "Column",
    "Drawing",
    "Entry",
    "Floats",
    "Page",
    "Panel",
    "Picture",
    "Place",
    "Row",
    "Simulated",
    "Stretch",
    "alt_text",
    "column_caption",
    "figure_2",
    "figure_4",
    "figure_7",
    "fitting_ticks",
    "grid",
    "held",
    "legend_2",
    "legend_4",
    "legend_7",
    "letters_along",
    "limits",
    "measured_figures",
    "outside_geometry",
    "panel_letter",
    "pictures",
    "png_of",
    "point_legend",
    "prefix",
    "rows_2",
    "rows_4",
    "rows_7",
    "seen_7",
    "sheet",
    "simulated_points",
    "style",
    "without_mirrors",
    "wrapped",
]
