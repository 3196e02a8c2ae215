"""A chart: every locus that is reached in the plane of two inputs, and what is stable along some sweeps across it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, pairwise

from msgspec import Struct

from vireport.atlas import FINE, atlas
from vireport.base import NumericalError, Progress
from vireport.chart.meetings import Meeting
from vireport.chart.network import (
    AT_EDGE,
    FollowedLocus,
    LocusStart,
    Network,
)
from vireport.chart.plane import Plane, StraightSweep, straight_sweeps
from vireport.motions import Atlas, Event, Limits, solve
from vireport.physics import Word

CUTS, SOLVED_CUTS = 3, 16
"""Sweeps across the plane along each input, on which loci are looked for: of all motions, and of 1:1 motions, which are
in closed form."""

Stable = tuple[tuple[float, float, tuple[str, ...]], ...]
"""Stretches of a line: their ends, and the words of the motions that are stable between them."""


class Cut(Struct, frozen=True, eq=False):
    """A sweep across the plane, and what is stable along it."""

    line: StraightSweep
    stable: Stable


class Chart(Struct, frozen=True, eq=False):
    """Loci in a plane, the points where they meet, and what is stable along some sweeps across it."""

    plane: Plane
    limits: Limits
    loci: tuple[FollowedLocus, ...]
    meetings: tuple[Meeting, ...]
    cuts: tuple[Cut, ...]

    @property
    def not_followed(self) -> int:
        """Ends of loci, off the edges of the plane, beyond which nothing was found."""
        lost = [locus.inputs[row] for locus in self.loci for row, event in locus.events if event is Event.LOST]
        return sum(self.plane.room(p) > AT_EDGE for p in lost)


def chart(plane: Plane, limits: Limits, progress: Progress = lambda what: None, cuts: int = CUTS) -> Chart:
    """Find the loci of the events of motions in a plane, and the points of codimension two.

    Parameters
    ----------
    plane : Plane
    limits : Limits
        Of the motions.
    progress : callable
        Called with what is done next.
    cuts : int
        Sweeps along each input on which motions of any sequence are looked for; none where only 1:1 motions are wanted.
    """
    one_to_one = Word((1, -1), plane.device.period_ratio)
    network, crossed = Network(plane, limits, None if cuts else one_to_one), []
    for line in straight_sweeps(plane, SOLVED_CUTS):
        progress(f"1:1 motions along the {line.quantity}")
        for start in _one_to_one_starts(line):
            network.explore(start)
    for line in straight_sweeps(plane, cuts):
        progress(f"motions along the {line.quantity}, {plane.inputs[1 - line.varied].show(line.other)}")
        if not line.sweep.unresolved:
            families = atlas(line.sweep, limits, finest=FINE)
            crossed.append(Cut(line, _stable(families, line)))
            for start in _starts(families, line):
                progress(f"loci of {start.motion.word.letters}")
                network.explore(start)
    return Chart(plane, limits, tuple(network.loci), tuple(network.meetings), tuple(crossed))


def _one_to_one_starts(line: StraightSweep) -> Iterator[LocusStart]:
    """The critical points of the 1:1 motions on a sweep across a plane."""
    sweep = line.sweep
    try:
        points = [] if sweep.unresolved else solve(sweep).critical_points
    except NumericalError:
        points = []
    for critical in points:
        yield LocusStart(critical.motion, line.inputs(critical.sweep_value), critical.event)


def _starts(families: Atlas, line: StraightSweep) -> Iterator[LocusStart]:
    """The points on a sweep across a plane where families meet, or motions change between node and focus."""
    marks = chain.from_iterable(family.marks for family in families.families)
    turned = [mark.point for mark in marks if mark.point is not None and mark.event is Event.NODE_FOCUS]
    for point in (*families.vertices, *turned):
        yield LocusStart(point.motion, line.inputs(point.sweep_value), point.event)


def _stable(families: Atlas, line: StraightSweep) -> Stable:
    """Between the ends of stable ranges, the words of the motions that are stable."""

    def place(pair: tuple[float, float]) -> list[float]:
        return sorted(float(line.inputs(value)[line.varied]) for value in pair)

    ranges = [(place(pair), family.word.letters) for family in families.families for pair in family.stable_ranges]
    ends = place((families.sweep.start, families.sweep.end))
    stretches = []
    for low, high in pairwise(sorted({*ends, *chain.from_iterable(pair for pair, _ in ranges)})):
        words = {word for (first, last), word in ranges if first < (low + high) / 2 < last}
        stretches.append((low, high, tuple(sorted(words, key=lambda word: (len(word), word)))))
    return tuple(stretches)
