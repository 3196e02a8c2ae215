"""Regions of a chart: the parts of the plane between the loci on which stable motions end, and what is stable in each.

The plane is cut into pixels, far smaller than what a figure shows. A region is a set of pixels that no such locus
parts; in each one that has room, all stable motions within the limits are solved for at the point that is farthest from
the loci. What lies between loci that are closer together is taken into the nearest region: there a motion may be stable
in a band that no figure can show, see `NarrowBand`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, pairwise

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.progress import Progress, counted
from vireport.design.point import motions_at
from vireport.map.chart.network import FollowedLocus
from vireport.map.chart.plane import Cut, DevicePlane, Stable, StraightSweep, is_swept
from vireport.motions.atlas.exclusion import FINE
from vireport.motions.atlas.families import SearchEffort, atlas
from vireport.motions.paths import Curve
from vireport.motions.sweep import NO_TOLERANCE, settable
from vireport.motions.switching import Limits
from vireport.physics.motion import IMAGE, Motion
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

Kind = tuple[int, str, int, bool]
"""What stable motions are told apart by: impacts, word, forcing periods, and whether they are asymmetric."""

Kinds = tuple[Kind, ...]

PIXELS = 720
"""Pixels along either input."""

ROOM = 3.0
"""Distance from the nearest locus [pixels] that the inner point of a region has at least: a band without such a point
is narrower than two lines of a figure."""

ASIDE = 2.5
"""Distance from a locus [pixels] at which it is told what is on either side of it."""

CROSSING = 12.0
"""Length of a stretch of a locus [pixels] up to which it is not told from its neighbours."""

AROUND = 1e-6
"""Share of the range of an input to either side of a point within which its motions are looked for."""


class StableMotion(Struct, frozen=True, eq=False):
    """A motion that is stable at a point of a chart.

    Attributes
    ----------
    motion : Motion
        Its coordinate is d.
    trace, decay : float
        Of the product of its Jacobians: the trace, and the root of the determinant.
    asymmetric : bool
        Whether it has a mirror image of its own, which is stable as well: the capsule is horizontal.
    """

    motion: Motion
    trace: float
    decay: float
    asymmetric: bool

    @property
    def word(self) -> Word:
        """The impacts of the motion, from the one with which its word comes first in the alphabet."""
        return self.motion.word.canonical()

    @property
    def kind(self) -> Kind:
        """What stable motions are told apart by."""
        return len(self.word), self.word.letters, self.word.periods, self.asymmetric

    @property
    def one_to_one(self) -> bool:
        """Whether the ball strikes each membrane once."""
        return self.word.letters == "BT"


class ChartRegion(Struct, frozen=True, eq=False):
    """A part of the plane that no locus on which a stable motion ends parts.

    Attributes
    ----------
    inputs : tuple of float
        The point inside it that is farthest from the loci, at which the motions are solved for.
    share : float
        Of the plane, by pixels.
    motions : tuple of StableMotion or None
        All that are stable there within the limits; None where rounding does not resolve motions.
    """

    inputs: tuple[float, float]
    share: float
    motions: tuple[StableMotion, ...] | None

    @property
    def kinds(self) -> Kinds | None:
        """What the stable motions are told apart by."""
        return None if self.motions is None else tuple(dict.fromkeys(motion.kind for motion in self.motions))


class RegionSet(Struct, frozen=True, eq=False):
    """The regions in which the same motions are stable.

    Attributes
    ----------
    kinds : tuple of Kind or None
        See `ChartRegion.kinds`.
    regions : tuple of ChartRegion
        The largest first.
    """

    kinds: Kinds | None
    regions: tuple[ChartRegion, ...]

    @property
    def share(self) -> float:
        """Share of the plane that the regions have, by pixels."""
        return sum(region.share for region in self.regions)

    @property
    def rank(self) -> tuple[bool, bool, bool, float, Kinds]:
        """1:1 motions alone first, then what covers most; last where nothing is stable, or nothing is resolved."""
        alone = self.kinds is not None and len(self.kinds) == 1 and self.kinds[0][1] == "BT"
        return not self.kinds, self.kinds is None, not alone, -self.share, self.kinds or ()


class Regions(Struct, frozen=True, eq=False):
    """The regions of a chart in which the same motions are stable.

    Attributes
    ----------
    plane : DevicePlane
    every : tuple of ChartRegion
        The largest first.
    number : ndarray (PIXELS, PIXELS)
        Of the region that each pixel belongs to; the first index is that of the first input.
    edges : tuple of ndarray
        Of each locus, for each piece of its curve as it is drawn, whether what is stable differs on its two sides.
    """

    plane: DevicePlane
    every: tuple[ChartRegion, ...]
    number: Ints
    edges: tuple[Mask, ...]

    @property
    def sets(self) -> tuple[RegionSet, ...]:
        """Regions by what is stable in them, in the order of `RegionSet.rank`."""
        by_kinds: dict[Kinds | None, list[ChartRegion]] = {}
        for region in self.every:
            by_kinds.setdefault(region.kinds, []).append(region)
        return tuple(
            sorted(
                (RegionSet(kinds, tuple(regions)) for kinds, regions in by_kinds.items()),
                key=lambda region_set: region_set.rank,
            )
        )

    def within(self, region_set: RegionSet) -> Mask:
        """The pixels of some of the regions."""
        return np.isin(self.number, [n for n, region in enumerate(self.every) if region in region_set.regions])

    def at(self, inputs: Sequence[float]) -> ChartRegion | None:
        """The region around a point; None outside the plane."""
        share = self.plane.shares(inputs)
        if ((share < 0) | (share > 1)).any():
            return None
        i, j = pixel(share)
        return self.every[int(self.number[i, j])]


class NarrowBand(Struct, frozen=True, eq=False):
    """Stretches of an input in which a word is stable, too narrow for a figure to show.

    Attributes
    ----------
    word : str
    varied : int
        Which of the two inputs.
    least, most : float
        Width of the narrowest and the widest of them, in the input's unit.
    settable : bool
        Whether one of them is wide enough for a device to be set into it.
    """

    word: str
    varied: int
    least: float
    most: float
    settable: bool


def narrow_bands(
    regions: Regions, cuts: Sequence[Cut], off: Sequence[tuple[float, float]] = 2 * (NO_TOLERANCE,)
) -> tuple[NarrowBand, ...]:
    """The words that are stable in bands on sweeps across the plane that the regions there do not show.

    Their ends on the sweeps are solved for, and not those of pixels.

    Parameters
    ----------
    regions : Regions
    cuts : sequence of Cut
    off : sequence of (float, float)
        The tolerance of each input, see `settable`.
    """
    intervals: dict[tuple[int, str], list[tuple[float, float]]] = {}
    for cut in cuts:
        k, other = cut.line.varied, cut.line.other
        most, ends = 2 * ROOM / PIXELS * float(regions.plane.widths[k]), (cut.stable[0][0], cut.stable[-1][1])
        for word, low, high in _ranges(cut.stable):
            region = regions.at(np.insert([other], k, (low + high) / 2).tolist())
            resolved = (
                region is None or region.motions is None or word in {motion.word.letters for motion in region.motions}
            )
            if high - low < most and low > ends[0] and high < ends[1] and not resolved:
                intervals.setdefault((k, word), []).append((low, high))
    return tuple(
        NarrowBand(
            word,
            k,
            min(high - low for low, high in bands),
            max(high - low for low, high in bands),
            any(settable(low, high, off[k]) for low, high in bands),
        )
        for (k, word), bands in sorted(intervals.items(), key=lambda item: (item[0][0], len(item[0][1]), item[0][1]))
    )


def _ranges(stable: Stable) -> Iterator[tuple[str, float, float]]:
    """The ranges of a sweep in which each word is stable: stretches beside one another are one."""
    for word in dict.fromkeys(chain.from_iterable(words for _, _, words in stable)):
        ranges = [(low, high) for low, high, words in stable if word in words]
        starts = [0, *(i for i in range(1, len(ranges)) if ranges[i][0] != ranges[i - 1][1]), len(ranges)]
        yield from ((word, ranges[first][0], ranges[after - 1][1]) for first, after in pairwise(starts))


def regions_of(plane: DevicePlane, limits: Limits, loci: Sequence[FollowedLocus], progress: Progress) -> Regions:
    """Find the regions between loci, and solve for what is stable in each."""
    from scipy.ndimage import distance_transform_edt, label  # type: ignore[import-untyped]

    drawn = [pieces(locus) for locus in loci]
    free = np.ones((PIXELS, PIXELS), dtype=bool)
    for points, bounds in drawn:
        block(free, plane.shares(points), bounds)
    parts, count = label(free)
    # The frame parts regions no less than loci do: a point on it is none inside.
    room = distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1]
    inner = _farthest(parts, room, count)
    sizes = np.bincount(parts.ravel(), minlength=count + 1)
    order = sorted((k for k in inner if room[inner[k]] > ROOM), key=lambda k: (-sizes[k], inner[k]))
    place = np.full(count + 1, -1)
    place[order] = np.arange(len(order))
    number = place[parts]
    if (number < 0).any() and order:
        number = number[tuple(distance_transform_edt(number < 0, return_distances=False, return_indices=True))]
    shares, every = np.bincount(number.ravel(), minlength=len(order)) / number.size, []
    for n, k in enumerate(order, 1):
        x, y = (plane.low + plane.widths * (np.array(inner[k]) + 0.5) / PIXELS).tolist()
        progress(counted("stable motions of the regions", n, len(order)))
        every.append(ChartRegion((x, y), float(shares[n - 1]), stable_motions(plane, (x, y), limits)))
    regions = Regions(plane, tuple(every), number, ())
    return replace(regions, edges=tuple(_edges(regions, points) & bounds for points, bounds in drawn))


def pieces(locus: FollowedLocus) -> tuple[Floats, Mask]:
    """A locus as it is drawn, and whether a stable motion ends on each of its pieces."""
    points = locus.drawn()
    return points, np.repeat(locus.bounds_stability, (len(points) - 1) // (len(locus.x) - 1))


def pixel(share: Floats) -> Ints:
    """The pixels of points that are given by their shares of the ranges."""
    return np.clip((share * PIXELS).astype(np.intp), 0, PIXELS - 1)


def block(free: Mask, shares: Floats, kept: Mask) -> None:
    """Clear the pixels that some pieces of a curve pass through, which is given by shares of the ranges."""
    for first, last in zip(shares[:-1][kept], shares[1:][kept], strict=True):
        free[tuple(pixel(np.linspace(first, last, int(2 * PIXELS * np.abs(last - first).max()) + 2)).T)] = False


def _farthest(parts: Ints, room: Floats, count: int) -> dict[int, tuple[int, int]]:
    """The pixel of each part that is farthest from its ends, by its number."""
    from scipy.ndimage import maximum_position

    numbers = np.arange(1, count + 1)
    positions = maximum_position(room, parts, numbers) if count else []
    return {int(k): (int(i), int(j)) for k, (i, j) in zip(numbers, positions, strict=True)}


def _edges(regions: Regions, points: Floats) -> Mask:
    """Whether different motions are stable on the two sides of each piece of a curve."""
    share = regions.plane.shares(points)
    way = np.diff(share, axis=0)
    length = np.hypot(*way.T)[:, None]
    normal = np.divide(way[:, ::-1] * [-1, 1], length, out=np.zeros_like(way), where=length > 0)
    middle = (share[1:] + share[:-1]) / 2
    kinds = list(dict.fromkeys(region.kinds for region in regions.every))
    of_region = np.array([kinds.index(region.kinds) for region in regions.every], dtype=np.intp)
    left, right = (
        of_region[regions.number[tuple(pixel(middle + sign * ASIDE / PIXELS * normal).T)]] for sign in (1, -1)
    )
    edges = np.asarray(left != right)
    # Where a locus crosses another one, the sides of the two are mixed up over a few pixels.
    ends = np.flatnonzero(np.diff(edges, prepend=not edges[0], append=not edges[-1]))
    for first, after in pairwise(ends.tolist()):
        if float(length[first:after].sum()) * PIXELS < CROSSING and after - first < len(edges):
            edges[first:after] = not edges[first]
    return edges


def stable_motions(plane: DevicePlane, inputs: tuple[float, float], limits: Limits) -> tuple[StableMotion, ...] | None:
    """Solve for all stable motions at a point of a plane.

    Those with up to four impacts are looked for among all flight times (see `atlas`), on a sweep that is next to
    nothing long; 1:1 motions are in closed form, and alone where there are no sweeps across the plane.

    Returns
    -------
    tuple of StableMotion or None
        1:1 motions first; None where rounding does not resolve motions.
    """
    device = plane.device_at(list(inputs))
    if not plane.swept:
        (motions, *_), periods = motions_at(device, Parameter.LENGTH), device.period_ratio
        rows = motions.stable_mask.nonzero()[0]
        by_row = [motions.motion(int(row), periods) for row in rows]
        decay = float(device.groups(Parameter.LENGTH, device.length_m, FLOATS).decay((1, -1)))
        solved = [(motion, float(motions.trace[row]), decay) for motion, row in zip(by_row, rows, strict=True)]
    else:
        k = next(k for k in (1, 0) if is_swept(plane.inputs[k], plane.device.recoils))
        off = AROUND * plane.widths * np.eye(2)[k]
        around = replace(plane, low=np.array(inputs) - off, high=np.array(inputs) + off)
        line = StraightSweep(around, k, inputs[1 - k])
        try:
            if line.sweep.unresolved:
                return None
            families = atlas(line.sweep, limits, effort=SearchEffort(FINE))
        except NumericalError:
            return None
        value = line.swept(inputs[k])
        solved = list(chain.from_iterable(_stable(family.curve, motion) for family, motion in families.at(value)))
    d = float(plane.at(inputs).d)
    stable = [
        StableMotion(replace(motion, coordinate=d), trace, decay, _parted(plane, motion))
        for motion, trace, decay in solved
    ]
    return tuple(sorted(stable, key=lambda x: (not x.one_to_one, x.kind, -float(x.motion.velocity.max()))))


def _stable(curve: Curve, motion: Motion) -> Iterator[tuple[Motion, float, float]]:
    """A motion with trace and decay, if it is stable."""
    x = curve.vector(motion)
    # Without the distances to both ends of the sweep, which say nothing of the motion.
    if min(curve.margins(x)[2:]) > 0 and curve.stability(x).attracts:
        yield motion, float(curve.trace(x)), float(curve.decay(x))


def _parted(plane: DevicePlane, motion: Motion) -> bool:
    """Whether a motion of a horizontal capsule is another one than its mirror image."""
    if not plane.horizontal:
        return False
    return motion.distance(motion.mirrored()) > IMAGE
