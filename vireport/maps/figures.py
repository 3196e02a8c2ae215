"""Heat maps of a grid over two parameters, with the curves along which motions change."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq  # type: ignore[import-untyped]
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base import write_whole
from vireport.disturbances import Destination
from vireport.figures import (
    HALO,
    LOCI,
    OUTCOMES,
    OUTSIDE,
    Color,
    Entry,
    Look,
    blank,
    finished,
    held_by,
    png_of,
    prefix,
    round_ticks,
    style,
)
from vireport.maps.cells import MapPlan, axis_values
from vireport.maps.disturbed import DESTINATIONS
from vireport.maps.evaluation import CODES
from vireport.maps.loci import DrawnLocus, loci_of
from vireport.maps.store import Store, writing
from vireport.motions import STABILITIES, TRACE_LEVELS, Event, Stability, lap_decay
from vireport.physics import RESTITUTIONS, Restitutions
from vireport.scenario import DRIVING, Parameter, Sampling
from vireport.text import PREFIXES, capital, percent

Floats = NDArray[np.float64]

FINEST = 1000
"""Cells along either axis that a picture shows; of more, every second, third, ... is drawn."""

HEIGHT = 4.7
"""Height of a map with its axes [in]."""

NO_CELL: Look = {"facecolor": "#FFFFFF", "edgecolor": "#999999", "hatch": "////", "linewidth": 0.0}
"""Look of cells without motion: hatched, as white is a shade of the margin too."""

TYPES = {
    Stability.STABLE_NODE: ("stable node", "#0072B2"),
    Stability.STABLE_FOCUS: ("stable focus", "#7CC4EE"),
    Stability.UNSTABLE_NODE: ("only unstable", "#F3DCB0"),
}
"""Name and colour of each type, from dark to light so that they are apart in grey as well."""

HATCHED = "; hatched: no 1:1 motion"
OF_ALL = "Curves: where any of the 1:1 motions changes or ends, also an unstable one beside a stable one"

NONE_FOUND = "none found up to the impact velocity", Color.LIGHT
NOT_TOLD = "too near a critical point to tell", Color.GREY

OF_CELLS: Look = {"linewidth": 7.0, "solid_capstyle": "butt"}
"""Look of cells of one colour in a legend."""

LINE = 1.4
"""Width of a curve [pt]."""

OTHER_NAMES = {name.value: f"{name.quantity} {name.symbol} [–]" for name in RESTITUTIONS} | {
    "ball_mass_kg": "ball mass m [kg]"
}


class Raster(Struct, frozen=True, eq=False):
    """Cells of a map as they are drawn.

    Attributes
    ----------
    x, y : ndarray
        Values of the two axes.
    columns : dict of str to ndarray, shape (len(y), len(x))
        NaN where there is nothing; of a column of words the place of each in `CODES`.
    """

    x: Floats
    y: Floats
    columns: dict[str, Floats]


def is_drawn(plan: MapPlan) -> bool:
    """Whether there are heat maps of a map: of a grid over two parameters."""
    return plan.sampling is Sampling.GRID and len(plan.axes) == 2


def picture_names(plan: MapPlan) -> tuple[str, ...]:
    """Names of the heat maps of a map."""
    if not is_drawn(plan):
        return ()
    return ("map-stability", "map-margin", *(name for name, wanted in _optional(plan).items() if wanted))


def _optional(plan: MapPlan) -> dict[str, bool]:
    return {"map-voltage": plan.membrane is not None, "map-from-rest": plan.from_rest, "map-shock": plan.shock}


def draw_missing(store: Store) -> list[Path]:
    """Draw those heat maps of a finished map that are not there yet, and return the paths of all."""
    paths = [store.folder / f"{name}.png" for name in picture_names(store.plan)]
    if not all(path.exists() for path in paths):
        with writing(store.folder):
            for name, figure in map_figures(store.plan, store.result).items():
                write_whole(store.folder / f"{name}.png", png_of(figure))
    return paths


def map_figures(plan: MapPlan, result: Path) -> dict[str, Figure]:
    """Draw the heat maps of a map, by their names.

    Parameters
    ----------
    plan : MapPlan
    result : Path
        The finished map; it is read piece by piece.
    """
    if not is_drawn(plan):
        return {}
    raster, loci = _raster(plan, result), loci_of(plan)
    draw = {"map-stability": _stability, "map-margin": _margin, "map-voltage": _voltage}
    draw |= {"map-from-rest": _from_rest, "map-shock": _shock}
    with style():
        return {name: draw[name](plan, raster, loci) for name in picture_names(plan)}


def _raster(plan: MapPlan, result: Path) -> Raster:
    """Every cell of the result, or every second, third, ... along either axis."""
    shape = plan.shape
    stride = [-(-count // FINEST) for count in shape]
    indices = [np.arange(0, count, step) for count, step in zip(shape, stride, strict=True)]
    names = ["multiplier_margin", *(["u_ave_v", "deflection_m"] if plan.membrane is not None else [])]
    names += ["least_jump_m_s", "jump_searched_to_m_s"] if plan.shock else []
    coded = ["stability", *(["from_rest"] if plan.from_rest else [])]
    columns = {name: np.full((len(indices[1]), len(indices[0])), np.nan) for name in (*coded, *names)}
    first = 0
    with open(result, "rb") as opened, pq.ParquetFile(opened) as file:
        for batch in file.iter_batches(columns=list(columns)):
            i, j = np.unravel_index(np.arange(first, first + len(batch)), shape)
            first += len(batch)
            chosen = np.flatnonzero((i % stride[0] == 0) & (j % stride[1] == 0))
            where = j[chosen] // stride[1], i[chosen] // stride[0]
            for name in names:
                columns[name][where] = batch.column(name).to_numpy(zero_copy_only=False)[chosen]
            for name in coded:
                words = batch.column(name)
                code = np.array([float(CODES[name].index(word)) for word in words.dictionary.to_pylist()] + [np.nan])
                columns[name][where] = code[words.indices.fill_null(len(code) - 1).to_numpy()[chosen]]
    x, y = (axis_values(axis, index) for axis, index in zip(plan.axes, indices, strict=True))
    return Raster(x, y, columns)


def _stability(plan: MapPlan, raster: Raster, loci: Sequence[DrawnLocus]) -> Figure:
    colors = ListedColormap([TYPES[stability][1] for stability in STABILITIES])
    figure, axes = _blank(plan, raster)
    _fill(axes, raster, raster.columns["stability"], colors, -0.5, len(STABILITIES) - 0.5)
    return _with_loci(figure, axes, plan, f"Stability of the 1:1 motion{HATCHED}", loci, _types(*STABILITIES))


def _types(*kinds: Stability) -> list[Entry]:
    """Entries of the legend for types of motion."""
    return [(TYPES[kind][0], OF_CELLS | {"color": TYPES[kind][1]}) for kind in kinds]


def _of_stable(
    plan: MapPlan, raster: Raster, values: Floats, colors: str, ends: tuple[float, float] | None = None
) -> tuple[Figure, Axes]:
    """A figure with values where the motion is stable, from the least to the largest where no ends are given."""
    figure, axes = _blank(plan, raster)
    code = raster.columns["stability"]
    unstable = code == Stability.UNSTABLE_NODE.code
    flat = ListedColormap([TYPES[Stability.UNSTABLE_NODE][1]])
    _fill(axes, raster, np.where(unstable, 1.0, np.nan), flat, 0.0, 2.0)
    shown = np.where(np.isfinite(code) & ~unstable, values, np.nan)
    known = shown[np.isfinite(shown)]
    low, high = ends or ((float(known.min()), float(known.max())) if known.size else (0.0, 1.0))
    _fill(axes, raster, shown, colors, low, high if high > low else low + 1.0)
    return figure, axes


def _margin(plan: MapPlan, raster: Raster, loci: Sequence[DrawnLocus]) -> Figure:
    restitution = _restitution(plan, raster)
    decay = lap_decay(restitution)
    determinant = "(r_bottom r_top)²" if isinstance(restitution, Restitutions) else "r⁴"
    percent = 100 * raster.columns["multiplier_margin"] / TRACE_LEVELS[Event.FOLD](decay)
    figure, axes = _of_stable(plan, raster, percent, "viridis", (0.0, 100.0))
    figure.colorbar(axes.images[-1], ax=axes, label=f"1 − |tr|/(1 + {determinant}) [%]")
    title = f"Stability margin: 0 % where a multiplier reaches 1 or −1{HATCHED}"
    return _with_loci(figure, axes, plan, title, loci, _types(Stability.UNSTABLE_NODE))


def _voltage(plan: MapPlan, raster: Raster, loci: Sequence[DrawnLocus]) -> Figure:
    volts = raster.columns["u_ave_v"]
    power = prefix([volts])
    figure, axes = _of_stable(plan, raster, volts / 10.0**power, "cividis")
    figure.colorbar(axes.images[-1], ax=axes, label=f"Uₐᵥₑ [{PREFIXES[power]}V]")
    title, types = f"Average voltage generated at an impact{HATCHED}", _types(Stability.UNSTABLE_NODE)
    return _with_loci(figure, axes, plan, title, loci, types, _outside(plan, raster))


def _from_rest(plan: MapPlan, raster: Raster, loci: Sequence[DrawnLocus]) -> Figure:
    code = raster.columns["from_rest"]
    figure, axes = _blank(plan, raster)
    colors = ListedColormap([OUTCOMES[each][1] for each in DESTINATIONS])
    _fill(axes, raster, code, colors, -0.5, len(DESTINATIONS) - 0.5)
    # A stable motion that is not reached is where a design may seem good and is not.
    missed = _is_stable(raster) & (code != DESTINATIONS.index(Destination.ONE_TO_ONE))
    met = [each for k, each in enumerate(DESTINATIONS) if (code == k).any()]
    entries: list[Entry] = [(OUTCOMES[each][0], OF_CELLS | {"color": OUTCOMES[each][1]}) for each in met]
    share = percent(float(missed.mean()), 3)
    note = f"Stable 1:1 motion is not reached from rest at {share} of the cells" if missed.any() else ""
    title = "What the device comes to that is switched on from rest"
    return _with_loci(figure, axes, plan, title, loci, entries, note)


def _shock(plan: MapPlan, raster: Raster, loci: Sequence[DrawnLocus]) -> Figure:
    jump, searched = raster.columns["least_jump_m_s"], raster.columns["jump_searched_to_m_s"]
    power = prefix([jump])
    figure, axes = _of_stable(plan, raster, jump / 10.0**power, "viridis")
    figure.colorbar(axes.images[-1], ax=axes, label=f"least shock [{PREFIXES[power]}m/s]")
    flat = ((np.isnan(jump) & np.isfinite(searched), NONE_FOUND), (_is_stable(raster) & np.isnan(searched), NOT_TOLD))
    entries = _types(Stability.UNSTABLE_NODE)
    for cells, (words, color) in flat:
        if cells.any():
            _fill(axes, raster, np.where(cells, 1.0, np.nan), ListedColormap([color]), 0.0, 2.0)
            entries.append((words, OF_CELLS | {"color": color}))
    title = f"Least jump of the velocity found that leads out of the stable motion{HATCHED}"
    return _with_loci(figure, axes, plan, title, loci, entries)


def _is_stable(raster: Raster) -> NDArray[np.bool_]:
    code = raster.columns["stability"]
    return np.asarray(np.isfinite(code) & (code != Stability.UNSTABLE_NODE.code))


def _outside(plan: MapPlan, raster: Raster) -> str:
    """What a reader of voltages must know where deflections exceed the membrane."""
    deflection = raster.columns["deflection_m"]
    known = deflection[np.isfinite(deflection)]
    if plan.membrane is None or not (known > plan.membrane.active_radius_m).any():
        return ""
    share = percent(float(np.mean(known > plan.membrane.active_radius_m)), 3)
    return f"{capital(OUTSIDE)}, at {share} of the cells with a motion"


def _restitution(plan: MapPlan, raster: Raster) -> Any:
    """R at the cells, of both membranes or of each: numbers, columns or rows."""
    axes = dict(zip(plan.names, (raster.x, raster.y[:, None]), strict=False))
    return plan.device.with_values({name: axes[name] for name in RESTITUTIONS if name in axes}).restitution


def _blank(plan: MapPlan, raster: Raster) -> tuple[Figure, Axes]:
    """A figure with the axes of a map."""
    figure, ((axes,),) = blank(1)
    axes.patch.set(**NO_CELL)
    for axis, name, values in zip((axes.xaxis, axes.yaxis), plan.names, (raster.x, raster.y), strict=True):
        edges = _edges(np.sort(values))
        axis.set_ticks(*round_ticks(edges.min(), edges.max(), HEIGHT))
        axis.set_label_text(_label(name))
    return figure, axes


def _fill(axes: Axes, raster: Raster, values: Floats, colors: str | ListedColormap, low: float, high: float) -> None:
    """Colour the cells that have a value; the scale of the colours goes from `low` to `high`."""
    i, j = np.argsort(raster.x), np.argsort(raster.y)
    shown = np.ma.masked_invalid(values[np.ix_(j, i)])
    edges = _edges(raster.x[i]), _edges(raster.y[j])
    axes.pcolorfast(*edges, shown, cmap=colors, norm=Normalize(low, high), zorder=0.5)


def _edges(values: Floats) -> Floats:
    """Borders between cells: half way between their values."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _label(name: str) -> str:
    if name in DRIVING:
        swept = Parameter(name)
        return f"{swept.quantity} {swept.symbol} [{swept.unit}]"
    return OTHER_NAMES[name]


def _with_loci(
    figure: Figure,
    axes: Axes,
    plan: MapPlan,
    title: str,
    loci: Sequence[DrawnLocus],
    types: Sequence[Entry],
    note: str = "",
) -> Figure:
    """Draw the curves, white under each so that it shows on any colour, and write the heading."""
    limits = axes.get_xlim(), axes.get_ylim()
    for locus in loci:
        if locus.event is not Event.NODE_FOCUS:
            axes.plot(*locus.points.T, color="white", linewidth=HALO, zorder=2.0, solid_capstyle="round")
        look: Look = {"linewidth": LINE, "zorder": 2.5} | LOCI[locus.event][1]
        axes.plot(*locus.points.T, **look)
    axes.set(xlim=limits[0], ylim=limits[1])
    drawn = {locus.event for locus in loci}
    curves: list[Entry] = [(name, {"linewidth": LINE} | look) for kind, (name, look) in LOCI.items() if kind in drawn]
    head = ", ".join(held_by(plan.device, plan.names)), title
    lines = [(text, Color.BLACK) for text in head]
    lines += [(note, Color.WARNING)] if note else []
    if loci:
        lines.append((OF_ALL, Color.BLACK))
    return finished(figure, HEIGHT, lines, [types, curves])
