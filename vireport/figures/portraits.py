"""Single motions in full, as phase portraits, time series and paths, with their words: figures 3 and 6, and others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vireport.figures.captions import pictured
from vireport.figures.curves import DrawnCurve, Floats, joined
from vireport.figures.labels import Label
from vireport.figures.layout import (
    Entry,
    blank,
    columns_of,
    finished,
    fit_vertically,
    letter_of,
    round_ticks,
    say,
    title,
    widened,
)
from vireport.figures.measured import LOOSE, MOST_LOOSE, bars
from vireport.figures.style import (
    GUIDE,
    WIDTH,
    Color,
    Look,
    Picture,
    sheet,
    style,
)
from vireport.figures.ticks import set_ticks
from vireport.physics.forcing import wave
from vireport.simulation.attractors import Outcome
from vireport.study.plan import Task
from vireport.text.formatting import rounded_text

if TYPE_CHECKING:
    from vireport.simulation.trajectories import Portrait
    from vireport.study.measured import DrawnImpacts

SampleIndices = NDArray[np.intp]
"""Indices of samples of a portrait."""

AT_WALL = 1e-9
"""Share of d within which a position is on a membrane."""

RIDE = 1e-4
"""Time from which a ball that leaves a membrane later than it came has ridden on it [t_c]."""

AT_END = 0.05
"""Time beyond the ends of a portrait up to which measured impacts are in it [t_c]: it begins and ends with one."""

LEAST_MOTION = 1e-6
"""Velocity up to which nothing is seen to move [y_c]."""

SAMPLES = 160
"""Samples of the capsule's motion in a forcing period."""

LONGEST_WORD = 14
"""Letters of a word that is written in full."""

DECIMALS = 9
"""Decimals of a multiplier that rounding leaves: at a period doubling or a fold it is 1."""

HIGHEST = 7.0
"""Rows of panels together become no higher, if each needs not be lower than `ROW_HEIGHT[0]` [in]."""

ROW_HEIGHT = 0.85, 2.2
"""Least and largest height of a row of panels with its title and ticks [in]."""

STACKED, MOST_STACKED = 1.7, 3
"""Height of a panel with its title and axis where all are below one another [in], and motions of which they are so."""

WORDS_FROM = 1.6
"""Height of a row from which the labels at its side have words [in]."""

LEFT, RIGHT = 2.4, 2.9
"""Widths of figure 3's panels in a report [in]."""

TIME = "time t [forcing periods]"

MOTION: Look = {"color": Color.BLACK, "linewidth": 1.1, "zorder": 2.5}
REBOUND: Look = {"color": Color.GREY, "linewidth": 0.8, "linestyle": (0, (3, 2)), "zorder": 2.3}
WALL: Look = {"color": Color.LIGHT, "linewidth": 3.6, "zorder": 1.2}
BOTTOM_MEMBRANE: Look = {"color": Color.BLUE, "linewidth": 2.8, "zorder": 2.2}
TOP_MEMBRANE: Look = {"color": Color.GREEN, "linewidth": 1.1, "zorder": 2.2}
BALL: Look = {"color": Color.BLACK, "linewidth": 1.4, "zorder": 2.5}
MARK: Look = {"linestyle": "none", "zorder": 3.5, "markeredgecolor": "white", "markeredgewidth": 0.5}
BOTTOM_IMPACT: Look = MARK | {"color": Color.BLUE, "marker": "o", "markersize": 5.5}
TOP_IMPACT: Look = MARK | {"color": Color.GREEN, "marker": "^", "markersize": 6.0}
MEASURED: Look = {
    "linestyle": "none", "marker": "D", "markersize": 3.4, "markeredgewidth": 0.9, "color": Color.VERMILION,
    "markerfacecolor": "white", "zorder": 4.2,
}  # fmt: skip
IMPACTS: list[Entry] = [("impact, bottom", BOTTOM_IMPACT), ("impact, top", TOP_IMPACT)]


def figure_3(portraits: Sequence[Portrait], held: str = "", measured: Sequence[DrawnImpacts | None] = ()) -> Figure:
    """Phase portraits and time series of simulated motions, as in Fig. 3: a row for each.

    Parameters
    ----------
    portraits : sequence of Portrait
    held : str
        The parameters that they share, in words.
    measured : sequence of DrawnImpacts or None
        Impacts that were measured of each.
    """
    return _beside_phase_portraits(portraits, held, _time_series, measured=measured)


def figure_portraits(portraits: Sequence[Portrait], held: str = "") -> Figure:
    """Phase portraits and paths of motions: a row for each. Parameters are those of `figure_3`."""
    return _beside_phase_portraits(portraits, held, _path, "Z [–]")


def portraits_picture(
    portraits: Sequence[Portrait],
    held: Sequence[str],
    name: Task = Task.FIGURE_PORTRAITS,
    templates: Path | None = None,
    mass_ratio: float = 0.0,
    measured: Sequence[DrawnImpacts | None] = (),
) -> Picture:
    """One of these figures with its words.

    Parameters
    ----------
    portraits : sequence of Portrait
    held : sequence of str
        The parameters that they share.
    name : Task
    templates : Path, optional
        A folder whose words come before the package's own.
    mass_ratio : float
        As in `capsule`.
    measured : sequence of DrawnImpacts or None
        Impacts that were measured of each, in figures 3 and 6.
    """
    words = ", ".join(held)

    if name == Task.FIGURE_6:
        figure = figure_6(portraits, words, mass_ratio, measured)
    elif name == Task.FIGURE_3:
        figure = figure_3(portraits, words, measured)
    else:
        figure = figure_portraits(portraits, words)
    facts = portrait_facts(name, portraits, held) | {"measured": sum(impacts is not None for impacts in measured)}
    return pictured(name, facts, figure, templates)


def portrait_facts(name: Task, portraits: Sequence[Portrait], held: Sequence[str]) -> dict[str, object]:
    """What one of these figures shows, for its words."""
    columns = 1 if name == Task.FIGURE_6 else 2
    panels = [[letter_of(columns * k + column) for column in range(columns)] for k in range(len(portraits))]
    motions = [{"panels": panel, **_facts_of(portrait)} for panel, portrait in zip(panels, portraits, strict=True)]
    return {"held": held, "motions": motions, "measured": 0}


def _beside_phase_portraits(
    portraits: Sequence[Portrait],
    held: str,
    draw: Callable[[Axes, Portrait], None],
    label: str = "",
    measured: Sequence[DrawnImpacts | None] = (),
) -> Figure:
    """Two panels for each motion; the second one shares the vertical axis of the first, or has one with a label.

    They are beside one another; below one another where two vertical axes would leave them no room.
    """
    columns = columns_of(2) if label and len(portraits) <= MOST_STACKED else 2
    height, ticks = _row_height(len(portraits)) if columns == 2 else (STACKED, int(3 * STACKED))
    spacing: dict[str, object] = {"width_ratios": (LEFT, RIGHT), "sharey": "none" if label else "row"}
    rows = 2 * len(portraits) // columns
    with style():
        figure, panels = blank(rows, columns, **spacing if columns == 2 else {})
        labels = []
        for k, (portrait, (left, right)) in enumerate(zip(portraits, panels.reshape(-1, 2), strict=True)):
            title(left, f"({letter_of(2 * k)}) {setting(portrait)}", columns)
            title(right, f"({letter_of(2 * k + 1)}) {motion_words(portrait)}", columns)
            left.set_ylabel("velocity Ż [–]" if height > WORDS_FROM else "Ż [–]")
            _phase_portrait(left, portrait)
            draw(right, portrait)
            if k < len(measured) and (impacts := measured[k]) is not None:
                _measured_states(left, right, portrait, impacts)
            if label:
                right.set_ylabel(label)
                fit_vertically([left], ticks)
                fit_vertically([right], ticks)
            else:
                fit_vertically([left, right], ticks)
            if moves(portrait):
                labels.append((left, _membranes(left, portrait)))
            if columns == 1 or k == len(portraits) - 1:
                left.set_xlabel("relative position Z [–]")
                right.set_xlabel(TIME)
        legend: list[Entry] = [
            *IMPACTS,
            ("rebound Ż → −r Ż", REBOUND),
            ("membrane", WALL),
            *_measured_entries(measured),
        ]
        return finished(figure, height * rows + 0.3, _head(held), [legend], labels)


def figure_6(
    portraits: Sequence[Portrait],
    held: str = "",
    mass_ratio: float = 0.0,
    measured: Sequence[DrawnImpacts | None] = (),
) -> Figure:
    """Absolute displacement of the capsule's ends and of the ball, as in Fig. 6: a panel for each motion.

    Parameters are those of `figure_3` and of `capsule`.
    """
    height, ticks = _row_height(len(portraits))
    with style():
        figure, panels = blank(len(portraits))
        for k, (portrait, axes) in enumerate(zip(portraits, panels[:, 0], strict=True)):
            title(axes, f"({letter_of(k)}) {setting(portrait)}: {motion_words(portrait)}")
            axes.set_ylabel("displacement X, x [–]" if height > WORDS_FROM else "X, x [–]")
            _displacement(axes, portrait, mass_ratio)
            if k < len(measured) and (impacts := measured[k]) is not None:
                _measured_displacements(axes, portrait, impacts, mass_ratio)
            fit_vertically([axes], ticks)
        axes.set_xlabel(TIME)
        legend: list[Entry] = [
            ("top X + d/2", TOP_MEMBRANE),
            ("ball x", BALL),
            ("bottom X − d/2", BOTTOM_MEMBRANE),
            *IMPACTS,
            *_measured_entries(measured),
        ]
        return finished(figure, height * len(portraits) + 0.3, _head(held), [legend])


def _row_height(count: int) -> tuple[float, int]:
    """Height of a row of panels [in], and how many ticks its vertical axis has."""
    height = float(np.clip(HIGHEST / count, *ROW_HEIGHT))
    return height, int(3 * height)


def _head(held: str) -> list[tuple[str, str]]:
    return [(held, Color.BLACK)] if held else []


def _phase_portrait(axes: Axes, portrait: Portrait) -> None:
    z, v, half = portrait.position, portrait.velocity, portrait.d / 2
    axes.set_xlim(*widened(-half, half, 0.09))
    set_ticks(axes.xaxis, *round_ticks(*axes.get_xlim(), _on_sheet(LEFT)))
    for wall in (-half, half):
        axes.axvline(wall, **WALL)
    axes.axhline(0.0, **GUIDE)
    if not moves(portrait):
        return
    _lines(axes, [(z[rows], v[rows]) for rows in flights(portrait)], MOTION)
    rows, pairs = arrivals(portrait), [[i, i + 1] for i in rebounds(portrait)]
    cycle = portrait.attractor.cycle
    if cycle is not None and not cycle.sticks:
        rows = rows[-len(cycle.wall) :]
        if len(pairs) < len(rows):  # one period, which begins after the impact that it ends with
            pairs.append([-1, 0])
    _lines(axes, [(z[pair[:1] * 2], v[pair]) for pair in pairs], REBOUND)
    _impacts(axes, portrait, rows, z, v)


def _membranes(axes: Axes, portrait: Portrait) -> list[Label]:
    """Names of the membranes, to stand anywhere along them."""
    y = np.linspace(*axes.get_ylim(), 16)[1:-1]
    half = np.full(len(y), portrait.d / 2)
    size = sheet().small
    return [Label("bottom", half, y, size, Color.GREY), Label("top", -half, y[::-1], size, Color.GREY)]


def _time_series(axes: Axes, portrait: Portrait) -> None:
    t, v = periods(portrait.time), portrait.velocity
    _time_axis(axes, portrait, RIGHT)
    axes.axhline(0.0, **GUIDE)
    if not moves(portrait):
        say(axes, portrait.attractor.outcome.value)
        return
    _lines(axes, [(t[rows], v[rows]) for rows in flights(portrait)], MOTION)
    _lines(axes, [(t[[i, i + 1]], np.zeros(2)) for i in rides(portrait)], MOTION)
    _lines(axes, [(t[[i, i]], v[[i, i + 1]]) for i in rebounds(portrait)], REBOUND)
    _impacts(axes, portrait, arrivals(portrait), t, v)


def _path(axes: Axes, portrait: Portrait) -> None:
    _time_axis(axes, portrait, RIGHT)
    for wall in (-portrait.d / 2, portrait.d / 2):
        axes.axhline(wall, **WALL)
    _lines(axes, [(periods(portrait.time), portrait.position)], MOTION)
    _impacts(axes, portrait, arrivals(portrait), periods(portrait.time), portrait.position)


def _displacement(axes: Axes, portrait: Portrait, mass_ratio: float) -> None:
    _time_axis(axes, portrait, LEFT + RIGHT)
    low, high = axes.get_xlim()
    time = even_times(2 * low, 2 * high)
    if mass_ratio and moves(portrait):  # how it recoils is known where the ball's position is
        time = np.sort(np.append(time[(time > 0) & (time < portrait.time[-1])], portrait.time))
    bottom_end, top_end = (capsule(portrait, time, mass_ratio) + side * portrait.d / 2 for side in (-1, 1))
    axes.plot(periods(time), bottom_end, **BOTTOM_MEMBRANE)
    axes.plot(periods(time), top_end, **TOP_MEMBRANE)
    axes.set_xlim(low, high)
    if moves(portrait):
        at, x = ball(portrait, mass_ratio)
        axes.plot(periods(at), x, **BALL)
        displacement = capsule(portrait, portrait.time, mass_ratio) - portrait.position
        _impacts(axes, portrait, arrivals(portrait), periods(portrait.time), displacement)
    elif portrait.attractor.outcome is Outcome.REST:
        axes.plot(periods(time), bottom_end, **BALL)


def _measured_entries(measured: Sequence[DrawnImpacts | None]) -> list[Entry]:
    return [("measured, 95 %", MEASURED)] if any(impacts is not None for impacts in measured) else []


def _measured_states(left: Axes, right: Axes, portrait: Portrait, impacts: DrawnImpacts) -> None:
    """Mark the velocities just before and just after measured impacts, over the position and over time."""
    (before, after), errors = impacts.values[:2], impacts.errors[:2]
    look = MEASURED if impacts.repeats else MEASURED | LOOSE | {"markerfacecolor": MEASURED["color"]}
    rows = slice(None) if impacts.repeats else slice(-MOST_LOOSE, None)
    z = impacts.walls[rows] * portrait.d / 2
    for values, error in ((before, errors[0]), (after, errors[1])):
        bars(left, z, values[rows], error[rows] if impacts.repeats else None, look)
    if impacts.repeats and moves(portrait):
        t, places = measured_times(portrait, impacts)
        for values, error in ((before, errors[0]), (after, errors[1])):
            bars(right, periods(t), values[places], error[places], look)


def _measured_displacements(axes: Axes, portrait: Portrait, impacts: DrawnImpacts, mass_ratio: float) -> None:
    """Mark when measured impacts were, on the end of the capsule that they hit; bars are of the time."""
    if impacts.repeats and moves(portrait):
        t, places = measured_times(portrait, impacts)
        x = capsule(portrait, t, mass_ratio) - impacts.walls[places] * portrait.d / 2
        bars(axes, periods(t), x, periods(impacts.errors[2][places] / np.pi), MEASURED, across=True)


def measured_times(portrait: Portrait, impacts: DrawnImpacts) -> tuple[Floats, SampleIndices]:
    """Times of the impacts of a measured motion in the time of a portrait [t_c], and the place of each in its word.

    Their phases say them but for whole forcing periods, of which a motion may take several: there it is put where it
    comes nearest to the impacts of the portrait.
    """
    start = (impacts.values[2, 0] - portrait.phase) / np.pi % 2
    since = np.concatenate([[0.0], np.cumsum(impacts.values[3])])
    period, end = round(float(since[-1]) / 2) * 2, float(portrait.time[-1])
    at = arrivals(portrait)
    choices = []
    for first in start + np.arange(0.0, period, 2.0):
        t = (first + since[:-1]) % period
        apart = np.abs(t[:, None] - portrait.time[at]) + np.abs(impacts.values[0][:, None] - portrait.velocity[at])
        choices.append((float(apart.min(axis=1).sum()), t))
    _, t = min(choices, key=lambda choice: choice[0])
    many = (t[:, None] + period * np.arange(-1, int(end // period) + 1)).ravel()
    places = np.repeat(np.arange(len(t)), len(many) // len(t))
    within = (many >= -AT_END) & (many <= end + AT_END)
    return many[within], places[within]


def _time_axis(axes: Axes, portrait: Portrait, width: float) -> None:
    end = float(periods(portrait.time[-1])) if moves(portrait) else 2.0
    axes.set_xlim(*widened(0.0, end, 0.02))
    set_ticks(axes.xaxis, *round_ticks(*axes.get_xlim(), _on_sheet(width)))


def _on_sheet(width: float) -> float:
    """Width of a panel on the sheet, from that in a report [in]."""
    return width * sheet().width / WIDTH


def _lines(axes: Axes, parts: Sequence[DrawnCurve], look: Look) -> None:
    if parts:
        axes.plot(*joined(parts), **look)


def _impacts(axes: Axes, portrait: Portrait, rows: SampleIndices, x: Floats, y: Floats) -> None:
    """Mark impacts, those on the two membranes apart."""
    at_bottom = portrait.position[rows] > 0
    for chosen, look in ((rows[at_bottom], BOTTOM_IMPACT), (rows[~at_bottom], TOP_IMPACT)):
        axes.plot(x[chosen], y[chosen], **look)


def moves(portrait: Portrait) -> bool:
    """Whether there is motion to be drawn: not where the ball rests."""
    return len(portrait.time) > 1 and bool(np.abs(portrait.velocity).max() > LEAST_MOTION)


def arrivals(portrait: Portrait) -> SampleIndices:
    """Samples at which the ball has come to a membrane: an impact each, before its rebound."""
    ends = rebounds(portrait)
    last = len(portrait.time) - 1
    return np.append(ends, last) if last >= 0 and _on_wall(portrait)[last] else ends


def rebounds(portrait: Portrait) -> SampleIndices:
    """The arrivals after which the motion goes on: the last sample of each flight but the last."""
    if len(portrait.time) < 2:
        return np.empty(0, dtype=np.intp)
    # A rebound is two samples at one time, before and after; a ride is two samples with nothing between them. Samples
    # of a short hop are on the wall as well, within rounding, but a little apart in time.
    wall, step = _on_wall(portrait), np.diff(portrait.time)
    side = np.sign(portrait.position)
    stays = wall[1:] & wall[:-1] & (side[1:] == side[:-1])
    return np.flatnonzero(stays & ((step == 0) | (step > RIDE)))


def _on_wall(portrait: Portrait) -> NDArray[np.bool_]:
    return np.asarray(np.abs(portrait.position) >= portrait.d * (0.5 - AT_WALL))


def flights(portrait: Portrait) -> list[SampleIndices]:
    """The samples of a portrait, flight by flight."""
    return np.split(np.arange(len(portrait.time)), rebounds(portrait) + 1)


def rides(portrait: Portrait) -> SampleIndices:
    """The arrivals after which the ball rides on the membrane."""
    ends = rebounds(portrait)
    return ends[portrait.time[ends + 1] - portrait.time[ends] > RIDE]


def periods(time: Floats) -> Floats:
    """Time in forcing periods, of which one is 2 t_c."""
    return time / 2


def capsule(portrait: Portrait, time: Floats, mass_ratio: float = 0.0) -> Floats:
    """Displacement of the capsule's centre X [x_c] without drift.

    Parameters
    ----------
    portrait : Portrait
    time : ndarray
        [t_c].
    mass_ratio : float
        mu = m/M of a free capsule, 0 of one whose motion is prescribed.

    Notes
    -----
    P'' = cos(pi t + phi) moves a prescribed capsule. Of a free one it moves the centre of mass with the ball,
    (X + mu x)/(1 + mu) = P/(1 + mu), x = X - Z, which impacts leave alone: X = (P + mu Z)/(1 + mu).
    """
    phase = np.pi * time + portrait.phase
    steady = -wave(np.sin(phase), np.cos(phase), portrait.harmonics).path / np.pi**2
    if not mass_ratio:
        return np.asarray(steady)
    position = np.interp(time, portrait.time, portrait.position)
    return np.asarray((steady + mass_ratio * position) / (1 + mass_ratio))


def ball(portrait: Portrait, mass_ratio: float = 0.0) -> DrawnCurve:
    """Time and displacement x = X - Z of the ball [t_c, x_c], on the membrane where it rides."""
    time, position = portrait.time, portrait.position
    for i in rides(portrait)[::-1]:  # from the last one on, so that the others keep their places
        between = even_times(float(time[i]), float(time[i + 1]))
        time, position = np.insert(time, i + 1, between), np.insert(position, i + 1, np.full(len(between), position[i]))
    return time, capsule(portrait, time, mass_ratio) - position


def even_times(start: float, end: float) -> Floats:
    """Times from a start to an end [t_c], dense enough for a smooth curve."""
    return np.linspace(start, end, int(np.ceil(SAMPLES * (end - start) / 2)) + 2)


def motion_words(portrait: Portrait) -> str:
    """What a motion is: its word and its period, or its kind."""
    attractor = portrait.attractor
    if attractor.cycle is None:
        return attractor.outcome.value
    every = "every forcing period" if attractor.period == 1 else f"every {attractor.period} forcing periods"
    return f"{short(attractor.word)}, {every}"


def setting(portrait: Portrait) -> str:
    """The parameters of a portrait."""
    return f"{portrait.label}, d = {rounded_text(portrait.d)}, ḡ = {rounded_text(portrait.gbar)}"


def short(word: str) -> str:
    """A word, a long one as its repeated part or its beginning.

    Examples
    --------
    >>> short("BTBT"), short("BT" * 16), short("B" * 17 + "T")
    ('BTBT', '(BT)×16', 'BBBBBBBBBBBBBB… (18)')
    """
    if len(word) <= LONGEST_WORD:
        return word
    unit = next(word[:k] for k in range(1, len(word) + 1) if word[:k] * (len(word) // k) == word)
    if len(unit) <= LONGEST_WORD:
        return f"({unit})×{len(word) // len(unit)}"
    return f"{word[:LONGEST_WORD]}… ({len(word.replace('~', ''))})"


def _facts_of(portrait: Portrait) -> dict[str, object]:
    """What a motion is told by: a periodic one by its impact speeds, the first on the bottom, and the phase of that."""
    attractor = portrait.attractor
    facts = {"setting": setting(portrait), "motion": motion_words(portrait), "cycle": attractor.cycle, "lyapunov": None}
    cycle = attractor.cycle
    if cycle is None:
        return facts | {"lyapunov": attractor.lyapunov if np.isfinite(attractor.lyapunov) else None}
    first = int(np.argmax(cycle.wall > 0))
    growth = round(cycle.growth, DECIMALS)
    return facts | {
        "speeds": np.abs(np.roll(cycle.velocity, -first)).tolist(),
        "phase": float(cycle.phase[first]),
        "growth": None if cycle.sticks or not np.isfinite(growth) else growth,
    }
