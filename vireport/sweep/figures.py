"""Heat maps of a grid over two parameters, with the curves along which motions change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq  # type: ignore[import-untyped]
from matplotlib.colors import Colormap, ListedColormap, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from vireport.analysis import STABILITIES
from vireport.figures import (
    BLACK,
    DPI,
    OUTSIDE,
    PURPLE,
    ROW,
    SMALL,
    VERMILION,
    WARNING,
    WIDTH,
    Entry,
    Page,
    Panel,
    Place,
    fitting_ticks,
    prefix,
    sheet,
    style,
    wrapped,
)
from vireport.scenario import Parameter
from vireport.sweep.cells import MapPlan, axis_values
from vireport.sweep.loci import Locus, loci_of
from vireport.text import PREFIXES

Floats = NDArray[np.float64]

FINEST = 1000
"""Cells along either axis that a picture shows; of more, every second, third, ... is drawn."""

PANEL: Place = (sheet.LEFT, sheet.BOTTOM, 4.75, 4.1)
"""The map itself [in]."""

BAR: Place = (sheet.LEFT + 4.75 + 0.16, sheet.BOTTOM, 0.18, 4.1)
"""The scale of its colours [in]."""

BLANK: dict[str, Any] = {"facecolor": "#FFFFFF", "edgecolor": "#999999", "hatch": "////", "linewidth": 0.0}
"""Where there is no motion: hatched, as white is a shade of the margin too."""

TYPES = {"stable node": "#0072B2", "stable focus": "#7CC4EE", "unstable node": "#F3DCB0"}
"""From dark to light, so that they are apart in grey as well."""

NO_MOTION = "no 1:1 motion"
OF_ALL = "curves: where any of the 1:1 motions changes or ends, also an unstable one beside a stable one"

LOCI: dict[str, tuple[str, dict[str, Any]]] = {
    "period_doubling": ("period doubling (B)", {"color": BLACK, "linestyle": "-"}),
    "fold": ("fold or pitchfork (C)", {"color": VERMILION, "linestyle": (0, (5, 1.6))}),
    "grazing": ("grazing (G)", {"color": PURPLE, "linestyle": (0, (1.2, 1.2))}),
}

LINE, HALO = 1.4, 2.8
"""Widths of a curve and of the white under it [pt]."""

OTHER_NAMES = {"restitution": "restitution r [–]", "ball_mass_kg": "ball mass m [kg]"}


@dataclass(frozen=True, slots=True)
class MapPicture:
    """A heat map as a PNG file.

    Attributes
    ----------
    name : str
        Of the file, without its suffix.
    png : bytes
    """

    name: str
    png: bytes


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """Cells of a map as they are drawn.

    Attributes
    ----------
    x, y : ndarray
        Values of the two axes.
    columns : dict of str to ndarray, shape (len(y), len(x))
        NaN where there is nothing; for ``stability`` the index into `kinds.STABILITIES`.
    """

    x: Floats
    y: Floats
    columns: dict[str, Floats]


def is_drawn(plan: MapPlan) -> bool:
    """Whether there are heat maps of a map: of a grid over two parameters."""
    return plan.sampling == "grid" and len(plan.axes) == 2


def picture_names(plan: MapPlan) -> tuple[str, ...]:
    """Names of the heat maps of a map."""
    if not is_drawn(plan):
        return ()
    return ("map-stability", "map-margin", *(("map-voltage",) if plan.membrane is not None else ()))


def map_pictures(plan: MapPlan, result: Path) -> tuple[MapPicture, ...]:
    """Draw the heat maps of a map.

    Parameters
    ----------
    plan : MapPlan
    result : Path
        The finished map; it is read piece by piece.
    """
    if not is_drawn(plan):
        return ()
    raster, loci = _raster(plan, result), loci_of(plan)
    draw = {"map-stability": _stability, "map-margin": _margin, "map-voltage": _voltage}
    with style():
        return tuple(MapPicture(name, _png(draw[name](plan, raster, loci))) for name in picture_names(plan))


def _raster(plan: MapPlan, result: Path) -> Raster:
    """Every cell of the result, or every second, third, ... along either axis."""
    shape = plan.shape
    stride = [-(-count // FINEST) for count in shape]
    kept = [np.arange(0, count, step) for count, step in zip(shape, stride, strict=True)]
    names = ["multiplier_margin", *(["u_ave_v", "deflection_m"] if plan.membrane is not None else [])]
    columns = {name: np.full((len(kept[1]), len(kept[0])), np.nan) for name in ("stability", *names)}
    codes = {word: float(k) for k, word in enumerate(STABILITIES)}
    first = 0
    with pq.ParquetFile(result) as file:
        for batch in file.iter_batches(columns=list(columns)):
            i, j = np.unravel_index(np.arange(first, first + len(batch)), shape)
            first += len(batch)
            chosen = np.flatnonzero((i % stride[0] == 0) & (j % stride[1] == 0))
            where = j[chosen] // stride[1], i[chosen] // stride[0]
            for name in names:
                columns[name][where] = batch.column(name).to_numpy(zero_copy_only=False)[chosen]
            words = batch.column("stability")
            code = np.array([codes[word] for word in words.dictionary.to_pylist()] + [np.nan])
            columns["stability"][where] = code[words.indices.fill_null(len(code) - 1).to_numpy()[chosen]]
    x, y = (axis_values(axis, index) for axis, index in zip(plan.axes, kept, strict=True))
    return Raster(x, y, columns)


def _stability(plan: MapPlan, raster: Raster, loci: Sequence[Locus]) -> Figure:
    entries: list[Entry] = [
        (name, {"color": color, "linewidth": 7.0, "solid_capstyle": "butt"}) for name, color in _relabelled().items()
    ]
    page = _page(plan, raster, "stability of the 1:1 motion", entries, loci)
    colors = ListedColormap([TYPES[word] for word in STABILITIES])
    _fill(page.panel, raster, raster.columns["stability"], colors, Normalize(-0.5, len(STABILITIES) - 0.5))
    _curves(page.panel, loci)
    return page.page.figure


def _relabelled() -> dict[str, str]:
    return {
        "stable node": TYPES["stable node"],
        "stable focus": TYPES["stable focus"],
        "only unstable": TYPES["unstable node"],
    }


def _margin(plan: MapPlan, raster: Raster, loci: Sequence[Locus]) -> Figure:
    margin = raster.columns["multiplier_margin"]
    highest = float(1 + np.max(_restitutions(plan)) ** 4)
    page = _page(plan, raster, "stability margin 1 + r⁴ − |tr|, positive where stable", [], loci)
    colors = _colormap("PuOr")
    norm = TwoSlopeNorm(0.0, -highest, highest)
    _fill(page.panel, raster, np.clip(margin, -highest, highest), colors, norm)
    _bar(page.page, colors, norm, "1 + r⁴ − |tr| [–]", below=bool((margin < -highest).any()))
    _curves(page.panel, loci)
    return page.page.figure


def _voltage(plan: MapPlan, raster: Raster, loci: Sequence[Locus]) -> Figure:
    volts = raster.columns["u_ave_v"]
    power = prefix([volts])
    page = _page(plan, raster, "average voltage generated at an impact", [], loci, _outside(plan, raster))
    known = volts[np.isfinite(volts)] / 10.0**power
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    norm = Normalize(low, high if high > low else low + 1.0)
    colors = _colormap("cividis")
    _fill(page.panel, raster, volts / 10.0**power, colors, norm)
    _bar(page.page, colors, norm, f"Uₐᵥₑ [{PREFIXES[power]}V]")
    _curves(page.panel, loci)
    return page.page.figure


def _outside(plan: MapPlan, raster: Raster) -> str:
    """What a reader of voltages must know where deflections exceed the membrane."""
    deflection = raster.columns["deflection_m"]
    known = np.isfinite(deflection)
    if plan.membrane is None or not (deflection[known] > plan.membrane.active_radius_m).any():
        return ""
    share = 100 * float(np.mean(deflection[known] > plan.membrane.active_radius_m))
    return f"{OUTSIDE[0].upper()}{OUTSIDE[1:]}, at {share:.3g} % of the cells with a motion"


def _restitutions(plan: MapPlan) -> Floats:
    axis = next((a for a, name in zip(plan.axes, plan.names, strict=True) if name == "restitution"), None)
    if axis is None:
        return np.array([plan.device.restitution])
    return np.array(axis.values or (axis.from_, axis.to), dtype=float)


@dataclass(frozen=True, slots=True)
class _MapPage:
    """A page with the empty map on it."""

    page: Page
    panel: Panel


def _page(
    plan: MapPlan, raster: Raster, title: str, entries: list[Entry], loci: Sequence[Locus], note: str = ""
) -> _MapPage:
    """A page with a title, a legend and the axes."""
    drawn = dict.fromkeys(locus.kind for locus in loci)
    legend = wrapped(
        [entries, [(LOCI[kind][0], LOCI[kind][1] | {"linewidth": LINE}) for kind in LOCI if kind in drawn]]
    )
    head = [(f"{title}; hatched: {NO_MOTION}", BLACK)] + ([(note, WARNING)] if note else [])
    if loci:
        head.append((OF_ALL, BLACK))
    height = PANEL[1] + PANEL[3] + 0.16 + ROW * (len(head) + len(legend))
    page = Page(sheet.blank(height), height)
    page.heading(head, legend)
    x, y = _edges(raster.x), _edges(raster.y)
    panel = page.frame(PANEL, _limits(x), _limits(y), True)
    letters = int(72 * PANEL[2] / (0.62 * SMALL))
    page.along_bottom(panel, PANEL, fitting_ticks(*panel.x, letters), _label(plan.names[0]))
    page.along_side(panel, PANEL, fitting_ticks(*panel.y, letters, 8))
    page.words(0.08, PANEL[1] + PANEL[3] / 2, _label(plan.names[1]), rotation=90, ha="left", va="center")
    return _MapPage(page, panel)


def _label(name: str) -> str:
    if name in tuple(Parameter):
        swept = Parameter(name)
        return f"{swept.quantity} {swept.symbol} [{swept.unit}]"
    return OTHER_NAMES[name]


def _limits(edges: Floats) -> tuple[float, float]:
    return float(edges.min()), float(edges.max())


def _edges(values: Floats) -> Floats:
    """Borders between cells: half way between their values."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _fill(panel: Panel, raster: Raster, values: Floats, colors: Colormap, norm: Normalize) -> None:
    """Colour the cells."""
    orders = np.argsort(raster.x), np.argsort(raster.y)
    x, y = raster.x[orders[0]], raster.y[orders[1]]
    shown = np.ma.masked_invalid(values[np.ix_(orders[1], orders[0])])
    panel.axes.patch.set(**BLANK)
    panel.axes.pcolorfast(_edges(x), _edges(y), shown, cmap=colors, norm=norm, zorder=0.5)
    panel.axes.set_xlim(panel.x)
    panel.axes.set_ylim(panel.y)


def _curves(panel: Panel, loci: Sequence[Locus]) -> None:
    """Draw the curves, white under each so that it shows on any colour."""
    for kind, (_, look) in LOCI.items():
        parts = [(locus.x, locus.y) for locus in loci if locus.kind == kind]
        panel.curves(parts, color="white", linewidth=HALO, zorder=2.0, solid_capstyle="round")
        panel.curves(parts, linewidth=LINE, zorder=2.5, **look)


def _colormap(name: str) -> Colormap:
    from matplotlib import colormaps

    return colormaps[name]


def _bar(page: Page, colors: Colormap, norm: Any, label: str, below: bool = False) -> None:
    """The scale of the colours, with its ticks on its right."""
    low, high = float(norm.vmin), float(norm.vmax)
    panel = page.frame(BAR, (0.0, 1.0), (low, high), False)
    shades = np.linspace(low, high, 257)
    panel.axes.pcolorfast(
        np.array([0.0, 1.0]), shades, (shades[1:, None] + shades[:-1, None]) / 2, cmap=colors, norm=norm
    )
    panel.axes.set_xlim(panel.x)
    panel.axes.set_ylim(panel.y)
    left, bottom, width, height = BAR
    values, texts = fitting_ticks(low, high, 60, 8)
    for value, text in zip(values, texts, strict=True):
        y = bottom + (value - low) / (high - low) * height
        page.words(left + width + 0.05, y, text, ha="left", va="center_baseline", size=SMALL)
    if below:
        page.words(left + width + 0.05, bottom - 0.13, "and less", ha="left", va="center_baseline", size=SMALL)
    page.words(WIDTH - 0.08, bottom + height / 2, label, rotation=90, ha="right", va="center")


def _png(figure: Figure) -> bytes:
    """Draw a figure as a PNG file, in full colour and the same in every run."""
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())  # type: ignore[attr-defined]
    data = BytesIO()
    Image.fromarray(pixels).convert("RGB").save(data, "png", dpi=(DPI, DPI), compress_level=6)
    return data.getvalue()
