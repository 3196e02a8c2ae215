"""A proved upper bound of the objective over all designs in the ranges.

Every stable motion is a point of the surface over (q, phase), see `vireport.motions.orbits`. Tiles in affine arithmetic
cover the surface; those on which no motion is stable, or the ball would pass through a membrane, are left out. The
others are drawn into a picture of (log d, gbar): where stable motions may be, and how fast their impacts. The ranges
are cut into boxes. If a box meets only empty pixels, or its devices do with one input off by the required margin, no
design in it meets the requirements. For the other boxes the fastest impacts bound the objective. Boxes that may hold a
better design are halved, and the picture is drawn again for what they meet.
"""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.boxes import Boxes
from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.orbits import Orbits, orbits
from vireport.motions.stability import lap_decay, return_trace
from vireport.optimise.problem import Problem, objectives
from vireport.physics.affine import AFFINE, between
from vireport.physics.device import RESTITUTIONS, Device, Shaker
from vireport.physics.groups import Restitution, by_wall, map_restitution
from vireport.physics.numbers import ARRAYS, Arithmetic
from vireport.scenario.blocks import DesignPath, Objective
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.judging.designs import DISPLACED, RINGS
from vireport.study.judging.impacts import Impacts, generated, impacts_of
from vireport.study.judging.requirements import OfShaker

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

GROWING = (
    *(Objective.U_AVE, Objective.VOLTAGE_RATE, Objective.POWER),
    *(Objective.U_BOTTOM, Objective.U_TOP, Objective.VELOCITY_BOTTOM),
)
"""Objectives that grow with both impact speeds, with the ball's mass and with the frequency."""

FALLING = DesignPath.AMPLITUDE
"""The input with which d and gbar fall; with all others they grow, if they change."""

SYMBOLS = 2
"""Symbols of the affine numbers: half the duration of a flight, as q, and the phase."""

PIXELS = np.array([64, 16])
"""Pixels of the picture along either axis; it is drawn anew where it matters."""

TILES, MOST_TILES, BLOCK = 32, 20_000, 4096
"""Tiles along q and phase at first, for each forcing period; after how many the rest is drawn as it is, some seconds;
tiles evaluated at once."""

SAMPLES = 6
"""Times of each flight, for each forcing period, at which the ball must be between the membranes."""

FIRST = 16
"""Boxes along each input at first."""

AIM, ROUNDS, MOST_BOXES, LEAST_GAIN = 1e-3, 5, 10_000, 0.9
"""Share of the best value up to which a box need not be cut further; the most rounds; the most boxes into which those
that are left are cut more than once; share of what is above the best value that a round must leave less than, for
another."""

TOGETHER, TELLING = 2, 2
"""Rounds in which one picture serves for all; in the others that many devices off by the margin, those that exclude
most."""

ROUNDING = 1e-9
"""Share by which ranges of d and gbar, and values against limits, are widened."""


class PixelPicture(Struct, frozen=True, eq=False):
    """A picture of where stable motions may be, in pixels of (log d, gbar).

    Attributes
    ----------
    low, high, pixel : ndarray, shape (2,)
        Corners of the picture, and size of a pixel, in (log d, gbar).
    fastest, slowest : ndarray, shape `(2, *PIXELS)`
        Bounds of the impact speeds at the bottom and at the top [y_c]; -inf and inf where there is no motion.
    """

    low: Floats
    high: Floats
    pixel: Floats
    fastest: Floats
    slowest: Floats

    def index(self, value: Floats, axis: int) -> Ints:
        """The pixels of values along an axis."""
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            place = np.floor((value - self.low[axis]) / self.pixel[axis])
        return np.asarray(np.clip(np.nan_to_num(place), 0, PIXELS[axis] - 1), dtype=np.intp)

    def over(self, boxes: Boxes) -> tuple[Floats, Floats]:
        """Fastest and slowest, (2, k), over boxes of (log d, gbar)."""
        fastest, slowest = np.full(boxes.low.shape, -np.inf), np.full(boxes.low.shape, np.inf)
        for rows, i, j in self.pixels(boxes):
            fastest[:, rows] = np.maximum(fastest[:, rows], self.fastest[:, i, j])
            slowest[:, rows] = np.minimum(slowest[:, rows], self.slowest[:, i, j])
        return fastest, slowest

    def pixels(self, boxes: Boxes) -> Iterator[tuple[Ints, Ints, Ints]]:
        """All pixels that boxes of (log d, gbar) touch, in batches: boxes, and both indices of a pixel of each."""
        ends = boxes.low, boxes.high
        (i, j), (last_i, last_j) = ([self.index(end[axis], axis) for axis in (0, 1)] for end in ends)
        for di in range(int((last_i - i).max(initial=-1)) + 1):
            rows = np.flatnonzero(i + di <= last_i)
            for dj in range(int((last_j - j)[rows].max(initial=-1)) + 1):
                chosen = rows[(j + dj <= last_j)[rows]]
                yield chosen, i[chosen] + di, j[chosen] + dj


def picture_of(r: Restitution, n: int, low: Floats, high: Floats) -> PixelPicture:
    """Draw where devices with a restitution may have stable motions, between two corners in (log d, gbar).

    Invariant: a stable motion lies over a tile that is still to be drawn, or in a pixel that is drawn with its speeds.
    """
    pixel = (high - low) / PIXELS
    pixel = np.maximum(pixel, pixel.max() / 4)  # not too fine across a picture that is a line
    shape = (2, *PIXELS)
    picture = PixelPicture(low, high, pixel, np.full(shape, -np.inf), np.full(shape, np.inf))
    # All motions there are lie over these tiles: q - 1/2 between -1/2 and 1/2, and the phase over one turn, of which
    # the end overlaps the beginning, as the double 2 pi is not the number.
    u, phi = np.linspace(-0.5, 0.5, TILES * n + 1), np.linspace(0, 2 * np.pi * (1 + ROUNDING), TILES * n + 1)
    tiles, tiles_so_far = Boxes.grid(u, phi), 0
    while len(tiles):
        tiles_so_far += len(tiles)
        blocks = [tiles[first : first + BLOCK] for first in range(0, len(tiles), BLOCK)]
        parts = [_drawn(picture, block, r, n, last=tiles_so_far > MOST_TILES) for block in blocks]
        tiles = Boxes(*(np.hstack([getattr(part, end) for part in parts]) for end in ("low", "high")))
    return picture


def _drawn(picture: PixelPicture, tiles: Boxes, r: Restitution, n: int, last: bool) -> Boxes:
    """Draw the tiles that are small enough; returns both halves of the others that may have a stable motion."""
    restitution = map_restitution(r, lambda at: between(np.full(len(tiles), at), np.full(len(tiles), at), 0, SYMBOLS))
    times, phases = (between(tiles.low[i], tiles.high[i], i, SYMBOLS) for i in (0, 1))
    with np.errstate(all="ignore"):  # what is not finite leaves out nothing
        orbit = orbits(times, phases, restitution, n, AFFINE)
        lower, upper = (
            np.stack([np.log(np.maximum(d, 0)), gbar])
            for d, gbar in ((orbit.d.lower, orbit.gbar.lower), (orbit.d.upper, orbit.gbar.upper))
        )
        edge = picture.low[:, None], picture.high[:, None]
        out = (upper < edge[0]).any(axis=0) | (lower > edge[1]).any(axis=0)
        # A tile is left out only if the reason holds in all of it. Comparisons with NaN are false, so that unresolved
        # tiles stay.
        rows = np.flatnonzero(~(out | (orbit.velocity_bottom.upper <= 0) | (orbit.velocity_top.lower >= 0)))
        rows = rows[_may_be_stable(orbit.select(rows), map_restitution(restitution, itemgetter(rows)))]
        rows = rows[_may_stay_between(orbit.select(rows), map_restitution(restitution, itemgetter(rows)), n)]
        # First-order change of (log d, gbar) with either unknown, in pixels: it tells whether a tile is small enough,
        # and which way to halve it.
        moved = np.abs(np.stack([orbit.d.linear[:2] / orbit.d.centre, orbit.gbar.linear[:2]]))[:, :, rows]
        moved = np.nan_to_num(moved / picture.pixel[:, None, None], nan=np.inf)
    fine = (2 * moved.sum(axis=1) <= 1).all(axis=0) & np.isfinite(upper[:, rows]).all(axis=0) | last
    drawn = rows[fine]
    speeds = orbit.velocity_bottom[drawn], -orbit.velocity_top[drawn]
    fast, slow = (
        np.nan_to_num(np.stack(x), nan=limit)
        for x, limit in (([v.upper for v in speeds], np.inf), ([v.lower for v in speeds], 0.0))
    )
    where = Boxes(np.nan_to_num(lower[:, drawn], nan=-np.inf), np.nan_to_num(upper[:, drawn], nan=np.inf))
    for which, i, j in picture.pixels(where):
        for side in (0, 1):
            # The speeds belong to the tile, not to the pixel: unions over all tiles that touch a pixel keep both
            # bounds valid.
            np.maximum.at(picture.fastest[side], (i, j), fast[side, which])
            np.minimum.at(picture.slowest[side], (i, j), np.maximum(slow[side, which], 0))
    return tiles[rows[~fine]].halved(moved[:, :, ~fine].max(axis=0).argmax(axis=0))


def _may_be_stable(orbit: Orbits, r: Restitution) -> Mask:
    """Whether the trace may be within the bounds of stability."""
    trace, border = return_trace(orbit, r), TRACE_LEVELS[Event.FOLD](lap_decay(r))
    return np.asarray(~((trace - border).lower > 0) & ~((trace + border).upper < 0))


def _may_stay_between(orbit: Orbits, r: Restitution, n: int) -> Mask:
    """Whether the ball may be between the membranes at some times of its flights."""
    ops, inside = AFFINE, np.ones(len(orbit.d.centre), dtype=bool)
    for way in orbit.flights(r):
        for k in range(SAMPLES * n):
            # A sample beyond a membrane proves that the motion passes through it; samples within prove nothing. So a
            # few suffice for a bound, and more only sharpen it.
            time = way.duration * ((k + 0.5) / (SAMPLES * n))
            angle = ops.pi * time
            covered = way.covered(time, way.turned(ops.sin(angle), ops.cos(angle))[1], ops.pi)
            inside &= ~(covered.upper < 0) & ~((way.d - covered).upper < 0)
    return inside


class _Bounded(Struct, frozen=True, eq=False):
    """Boxes of designs, each with a bound.

    Invariant: no design of a box that meets the requirements has an objective above the `most` of the box.

    Attributes
    ----------
    boxes : Boxes
        Of k.
    most : ndarray (k,)
        Bound of the objective; -inf where no design of the box meets the requirements.
    excluded : ndarray of int
        Number of boxes that each of the devices with an input off by the margin has excluded.
    """

    boxes: Boxes
    most: Floats
    excluded: Ints

    @property
    def largest(self) -> float:
        """Bound of the objective over all boxes."""
        return float(self.most.max(initial=-np.inf))

    def __getitem__(self, rows: Any) -> _Bounded:
        return _Bounded(self.boxes[rows], self.most[rows], self.excluded)


def largest_value(problem: Problem, best: float) -> float | None:
    """A value of the objective that no design in the ranges exceeds; None where none can be given.

    None is returned where the objective is none of `GROWING`, or is to be small, or where the restitution or a number
    of the membranes varies. Tolerances, margins in restitution or to one kind of critical point, and the difference of
    the voltages are ignored: without them the bound can only be larger.

    Invariant: no design exceeds the larger of `done`, which bounds the boxes that are cut no further, and of the bounds
    of the boxes that are `left`.

    Parameters
    ----------
    problem : Problem
    best : float
        The best value known.
    """
    restitutions = {varied.path for varied in RESTITUTIONS}
    beyond = any(path in restitutions or path.startswith("device.membrane.") for path in problem.paths)
    if problem.objective not in GROWING or problem.sign < 0 or beyond:
        return None
    axes, done, above = len(problem.paths), best, np.inf
    boxes = Boxes.grid(*[np.linspace(0, 1, FIRST + 1)] * axes)
    off = displaced(problem.share)
    for number in range(ROUNDS):
        bounded = _bounds(problem, boxes, off, together=number < TOGETHER)
        # Each device costs a picture. Those that excluded most boxes in the round before do nearly all, and leaving out
        # the others can only make the bound larger.
        order = bounded.excluded.argsort(kind="stable")[::-1]
        off = [off[k] for k in sorted(order[:TELLING])] if number else off
        goes_on = bounded.most > best * (1 + AIM)
        # The bound of a box that is cut no further still counts.
        left, done, before = bounded[goes_on], max(done, bounded[~goes_on].largest), above
        above = max(left.largest, best) - best
        if not len(left.boxes) or above > LEAST_GAIN * before:
            break
        # On while the parts are few: to draw a picture takes 0.2 s, to look up ten thousand boxes in it 0.01 s.
        boxes = left.boxes.cut()
        while len(boxes) * 2**axes <= MOST_BOXES:
            boxes = boxes.cut()
    most = max(done, left.largest)
    return most if np.isfinite(most) else None


def displaced(share: float) -> list[tuple[DesignInput, float]]:
    """Inputs other than restitutions, and factors by which they are off in devices within a margin."""
    # A design with the margin has stable motion wherever one input is off by less: each such device that surely has
    # none excludes the design. This needs pictures alone, no margins of boxes.
    inputs = [change for change in DISPLACED if change[0] not in RESTITUTIONS] if share else []
    return [(varied, 1 + sign * ring * share) for ring in RINGS for varied, sign in inputs]


class _Place(NamedTuple):
    """Where the devices of boxes of designs are, with an input off or not.

    Invariant: where `applies`, every device of the designs of a box has its (log d, gbar) in the box of the same
    number. Elsewhere some device would be beyond the limits of the input, and the box excludes nothing.
    """

    boxes: Boxes
    applies: Mask


def _bounds(problem: Problem, boxes: Boxes, off: list[tuple[DesignInput, float]], together: bool) -> _Bounded:
    """Boxes of designs with upper bounds of the objective.

    `off` are inputs and by what factor they are off in devices that have stable motion, if a design has the margin. One
    picture serves for all that is looked up, or one for each.
    """
    first = _place(problem, boxes, None, 1.0)
    others = [_place(problem, boxes, *change) for change in off]
    scenario = problem.loaded.scenario

    def drawn(places: list[_Place], rows: Any) -> PixelPicture:
        corner = np.min([place.boxes.low[:, rows].min(axis=1) for place in places], axis=0)
        opposite = np.max([place.boxes.high[:, rows].max(axis=1) for place in places], axis=0)
        return picture_of(Device.of(scenario).restitution, scenario.period_ratio, corner, opposite)

    picture = drawn([first, *others] if together else [first], slice(None))
    fastest, slowest = picture.over(first.boxes)
    flies, excluded = fastest[0] > 0, []
    for place in others:
        rows = np.flatnonzero(flies & place.applies)
        if rows.size:
            # Of the boxes that are left a picture of their own has finer pixels than the one of all.
            looked_up = picture if together else drawn([place], rows)
            flies[rows] = looked_up.over(place.boxes[rows])[0][0] > 0
        excluded.append(rows.size - np.count_nonzero(flies[rows]))
    most = np.full(len(boxes), -np.inf)
    rows = np.flatnonzero(flies)
    with np.errstate(all="ignore"):  # no impacts, no efficiency
        value, meets = _values(problem, boxes[rows], fastest[:, rows], slowest[:, rows])
    most[rows] = np.where(meets, value * (1 + ROUNDING), -np.inf)
    return _Bounded(boxes, most, np.array(excluded, dtype=np.intp))


def _place(problem: Problem, designs: Boxes, varied: DesignInput | None, factor: float) -> _Place:
    """The (log d, gbar) of boxes of designs with an input off by a factor."""
    falls = np.array([path == FALLING for path in problem.paths])[:, None]
    ends, count, (low, high) = [], len(designs), (designs.low, designs.high)
    applies = np.ones(count, dtype=bool)
    # The groups are monotonic in every input, so that two opposite corners of a box enclose them.
    for t in (np.where(falls, high, low), np.where(falls, low, high)):
        device, _ = problem.at(t.T)
        if varied is not None:
            value = np.broadcast_to(device.value_of(varied) * factor, count)
            applies &= value <= varied.limits[1]
            device = device.with_values({varied: np.minimum(value, varied.limits[1])})
        d, gbar = (np.broadcast_to(x, count) for x in device.groups(Parameter.LENGTH, device.length_m)[:2])
        ends.append(np.stack([np.log(d), gbar]))
    start, end = ends
    return _Place(Boxes(start - ROUNDING * (1 + np.abs(start)), end + ROUNDING * (1 + np.abs(end))), applies)


class _Extreme(NamedTuple):
    """What one device of each box has with one pair of impact speeds: no device of the box has more, or none less."""

    objectives: dict[Objective, Any]
    impacts: Impacts
    shaker: Shaker


def _extreme(problem: Problem, most: Floats, least: Floats, speeds: Floats, period_s: Arithmetic) -> _Extreme:
    """What the devices in one corner of each box have: of `most` and `least`, the ends of each input, (inputs, k)."""
    rising = np.array([path in (FALLING, DesignPath.BALL_MASS) for path in problem.paths])[:, None]
    # A light capsule moves faster, and the impacts on it; but on a free one their energy at a given speed grows with M.
    heavier = rising | np.array([path == DesignPath.CAPSULE_MASS for path in problem.paths])[:, None]
    device, _ = problem.at(np.where(rising, most, least).T)
    _, membrane = problem.at(np.where(heavier, most, least).T)
    bottom, top = speeds
    unit = device.velocity_unit(Parameter.LENGTH, device.length_m)
    output = generated((unit * bottom, unit * top), membrane, 0.0, period_s)
    shaker = device.shaker(Parameter.LENGTH, device.length_m)
    return _Extreme(objectives(bottom, bottom, *output, period_s), impacts_of(*output, membrane), shaker)


def _values(problem: Problem, boxes: Boxes, fastest: Floats, slowest: Floats) -> tuple[Floats, Mask]:
    """The objective at the fastest impacts of boxes of designs, and whether the slowest may meet the limits."""
    quickest, _ = problem.at(boxes.high.T)
    period_s = quickest.period_ratio / quickest.frequency_hz
    above = _extreme(problem, boxes.high, boxes.low, fastest, period_s)
    below = _extreme(problem, boxes.low, boxes.high, slowest, period_s)
    largest, meets = above.objectives[problem.objective], np.ones(len(boxes), dtype=bool)
    if problem.objective is Objective.POWER and problem.most_efficient is not None:
        # Restitution 0 above makes the efficiency one of all the kinetic energy: the power that the fastest impacts
        # have is their power over that, and no design within the limit makes more of it than this.
        varies = any(varied.path in problem.paths for varied in RESTITUTIONS)
        lost = 1.0 if varies else 1 - min(by_wall(Device.of(problem.loaded.scenario).restitution)) ** 2
        largest = np.fmin(largest, problem.most_efficient * lost * largest / above.objectives[Objective.EFFICIENCY])
    # A limit from below is held against the largest that the box may reach, one from above against the least: what
    # fails so fails everywhere in the box.
    for quantity, limit in problem.limits:
        extreme = above if limit.is_least else below
        if isinstance(quantity, OfShaker):
            if quickest.recoils:
                continue  # acceleration and stroke do not grow or fall with all inputs
            value = quantity.of(extreme.shaker)
        elif quantity.grows:
            value = quantity.of(extreme.impacts, ARRAYS)
        else:
            continue  # at neither end of the speeds is it known to be the least or the largest
        kept = value >= limit.value * (1 - ROUNDING) if limit.is_least else value <= limit.value * (1 + ROUNDING)
        meets &= kept
    return np.broadcast_to(largest, meets.shape), meets
