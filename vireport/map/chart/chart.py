"""A chart: all loci that are reached in the plane of two inputs, and which motions are stable along some sweeps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, pairwise

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import NumericalError, UsageError
from vireport.base.progress import Progress, WorkStep, portion
from vireport.design.lines import line_of, model_on_line
from vireport.design.point import motions_at
from vireport.map.chart.design import ChartedDesign, charted_design
from vireport.map.chart.meetings import Meeting
from vireport.map.chart.network import (
    AT_EDGE,
    FollowedLocus,
    LocusStart,
    Network,
)
from vireport.map.chart.plane import Cut, DevicePlane, Stable, StraightSweep, straight_sweeps
from vireport.map.chart.regions import NarrowBand, Regions, narrow_bands, pieces, regions_of
from vireport.motions.atlas.exclusion import FINE
from vireport.motions.atlas.families import SearchEffort, atlas
from vireport.motions.atlas.guesses import motions_of
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.families import Atlas
from vireport.motions.paths import Curve, PathPoint, completed, follow
from vireport.motions.periodicity import model_of
from vireport.motions.sweep import NO_TOLERANCE
from vireport.motions.switching import Limits, touching
from vireport.physics.device import Device
from vireport.physics.motion import Motion
from vireport.physics.numbers import ARRAYS, FLOATS
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter

CUTS, SOLVED_CUTS = 3, 16
"""Sweeps across the plane along each input, on which loci are looked for: of all motions, and of 1:1 motions, which are
in closed form."""

LINES, STATIONS = 8, 3
"""Lines across a plane of two restitutions, along each, and devices on each line whose 1:1 motions are followed."""


CLOSED_FORM_SHARE = 0.1
"""Share of the time of the loci, as measured, in which those of 1:1 motions are found, in closed form."""

REGIONS_SHARE = 0.9
"""Share of the time of the regions, as measured, after which the margins of the design point follow."""


class ChartStart(Struct, frozen=True):
    """Motions of a word at a point of a plane, from which families are followed.

    Attributes
    ----------
    word : Word
    varied : int
        Along which of the two inputs.
    inputs : tuple of float
        The point.
    """

    word: Word
    varied: int
    inputs: tuple[float, float]


class PlaneLoci(Struct, frozen=True, eq=False):
    """Loci in a plane, the points where they meet, and the motions that are stable along some sweeps across it.

    Attributes
    ----------
    plane : DevicePlane
    limits : Limits
        Of the motions.
    loci : tuple of FollowedLocus
    meetings : tuple of Meeting
    cuts : tuple of Cut
    """

    plane: DevicePlane
    limits: Limits
    loci: tuple[FollowedLocus, ...]
    meetings: tuple[Meeting, ...]
    cuts: tuple[Cut, ...]

    @property
    def not_followed(self) -> int:
        """Ends of loci, off the edges of the plane, beyond which nothing was found."""
        lost = [locus.inputs[row] for locus in self.loci for row, event in locus.events if event is Event.LOST]
        return sum(self.plane.room(p) > AT_EDGE for p in lost)


class Chart(PlaneLoci, frozen=True, eq=False):
    """Loci in a plane with what is stable between them, and the design point there.

    Attributes
    ----------
    regions : Regions
    design : ChartedDesign or None
        None where the scenario has no design point in the plane.
    tolerances : tuple of (float, float)
        Tolerance of each input, in its unit and in per cent; zeros where none is stated.
    """

    regions: Regions
    design: ChartedDesign | None = None
    tolerances: tuple[tuple[float, float], tuple[float, float]] = NO_TOLERANCE, NO_TOLERANCE

    @property
    def narrow(self) -> tuple[NarrowBand, ...]:
        """Words that are stable in bands which the regions do not show."""
        return narrow_bands(self.regions, self.cuts, self.tolerances)

    @property
    def unmeasured(self) -> tuple[str, ...]:
        """Words of motions that end on loci, and are stable neither in a region nor in a band that a sweep crosses."""
        measured_words = {band.word for band in self.narrow}
        measured_words |= {letters for region in self.regions.every for _, letters, *_ in region.kinds or ()}
        bounds = (pieces(locus)[1] for locus in self.loci)
        pairs = zip(self.loci, bounds, self.regions.edges, strict=True)
        hidden = {locus.word for locus, locus_kinds, edges in pairs if (locus_kinds & ~edges).any()}
        return tuple(sorted(hidden - measured_words, key=lambda word: (len(word), word)))


def loci_over(
    plane: DevicePlane,
    limits: Limits,
    progress: Progress = lambda what: None,
    cuts: int = CUTS,
    starts: Sequence[ChartStart] = (),
) -> PlaneLoci:
    """Find the loci of the events of motions in a plane, and the points of codimension two.

    Parameters
    ----------
    plane : DevicePlane
    limits : Limits
        Of the motions.
    progress : callable
        Called with what is done next.
    cuts : int
        Sweeps along each input on which motions of any sequence are looked for; none where only 1:1 motions are wanted.
    starts : sequence of ChartStart
        Motions that a sweep across the plane goes through as well.

    Raises
    ------
    UsageError
        If there is no motion of the word of a start.
    """
    one_to_one = Word((1, -1), plane.device.period_ratio)
    if not plane.swept:
        return _between_restitutions(plane, one_to_one, progress)
    network, crossed = Network(plane, limits, None if cuts else one_to_one), []
    solved, searched = list(straight_sweeps(plane, SOLVED_CUTS)), list(straight_sweeps(plane, cuts))
    say = portion(progress, 0.0, CLOSED_FORM_SHARE)
    for k, line in enumerate(solved):
        say(WorkStep(f"1:1 motions along the {line.quantity}", k / len(solved)))
        for start in _one_to_one_starts(line):
            network.explore(start)
    say = portion(progress, CLOSED_FORM_SHARE, 1.0)
    through = [(StraightSweep(plane, began.varied, began.inputs[1 - began.varied]), began) for began in starts]
    lines = [*((line, None) for line in searched), *through]
    for k, (line, began) in enumerate(lines):
        at = plane.inputs[1 - line.varied].stated(line.other)
        say(WorkStep(f"motions along the {line.quantity}, {at}", k / len(lines)))
        if not line.sweep.unresolved:
            motions = () if began is None else _motions_to_start_from(line, began)
            families = atlas(line.sweep, limits, motions, effort=SearchEffort(FINE))
            crossed.append(Cut(line, _stable(families, line)))
            for start in _starts(families, line):
                progress(f"loci of {start.motion.word.letters}")
                network.explore(start)
    return PlaneLoci(plane, limits, tuple(network.loci), tuple(network.meetings), tuple(crossed))


def with_regions(drawn: PlaneLoci, device: Device, progress: Progress = lambda what: None) -> Chart:
    """Find the stable motions in each of the regions between loci, and the margins of a device as the design point.

    Parameters
    ----------
    drawn : PlaneLoci
    device : Device
        Of the scenario: a value that it does not have is that of no design point.
    progress : callable
        Called with what is done next.
    """
    regions = regions_of(drawn.plane, drawn.limits, drawn.loci, portion(progress, 0.0, REGIONS_SHARE))
    progress(WorkStep("margins of the design point", REGIONS_SHARE))
    design = charted_design(device, drawn.plane, drawn.limits)
    return Chart(drawn.plane, drawn.limits, drawn.loci, drawn.meetings, drawn.cuts, regions, design)


def _motions_to_start_from(line: StraightSweep, start: ChartStart) -> list[Motion]:
    """The motions of a word that is asked for at a point of a line."""
    sweep, word = line.sweep, start.word
    low, high = map(float, sweep.coordinate_range)
    coordinate = float(sweep.coordinate_of(line.swept(start.inputs[line.varied])))
    motions = motions_of(word, model_of(sweep, ARRAYS), low, high, coordinate)
    if not motions:
        at = " and ".join(varied.stated(value) for varied, value in zip(line.plane.inputs, start.inputs, strict=True))
        raise UsageError(
            f"motions.starts: no motion {word.name} was found at {at} (leave it out, or give another value)"
        )
    return motions


def _between_restitutions(plane: DevicePlane, word: Word, progress: Progress) -> PlaneLoci:
    """The loci of the 1:1 motions of a plane across which there are no sweeps."""
    limits, crossed = Limits(len(word), word.periods), []
    network = Network(plane, limits, word)
    lines = list(straight_sweeps(plane, LINES))
    for k, line in enumerate(lines):
        progress(WorkStep(f"1:1 motions along the {line.quantity}", k / len(lines)))
        starts = list(_followed_starts(line, word))
        for start in starts:
            network.explore(start)
        ends = plane.low[line.varied], plane.high[line.varied]
        places = sorted({*map(float, ends), *(float(start.inputs[line.varied]) for start in starts)})
        crossed.append(Cut(line, tuple(_stable_between(line, low, high) for low, high in pairwise(places))))
    return PlaneLoci(plane, limits, tuple(network.loci), tuple(network.meetings), tuple(crossed))


def _followed_starts(line: StraightSweep, word: Word) -> Iterator[LocusStart]:
    """What happens to the 1:1 motions along a line: those of some devices on it, which are all known, are followed."""
    k, plane = line.varied, line.plane
    for value in plane.centres((STATIONS, STATIONS))[k].tolist():
        device = plane.device_at(line.inputs(value).tolist())
        moved = model_on_line(line_of(plane.inputs[k], device), device, FLOATS)
        low, high = float(plane.low[k]) - value, float(plane.high[k]) - value
        curve = Curve(word, moved, low, high, high - low)
        motions, *_ = motions_at(device, Parameter.LENGTH)
        for row in motions.admissible_mask.nonzero()[0]:
            x = curve.vector(replace(motions.motion(int(row), word.periods), coordinate=0.0))
            start = PathPoint(curve, x, curve.tangent(x))
            trail = completed(curve, start, follow(curve, start))
            for at, event in trail.events:
                motion, inputs = curve.motion(trail.points[at].x), line.inputs(value + trail.points[at].x[-1])
                if event in (Event.GRAZING, Event.ZERO_VELOCITY):
                    yield LocusStart(touching(motion, curve.turns(trail.points[at].x)), inputs, Event.GRAZING)
                elif event not in (Event.SWEEP_END, Event.CLOSED, Event.LOST):
                    yield LocusStart(motion, inputs, event)


def _stable_between(line: StraightSweep, low: float, high: float) -> tuple[float, float, tuple[str, ...]]:
    """A stretch of a line within which nothing happens to a 1:1 motion, with its word where one is stable."""
    device = line.plane.device_at(line.inputs((low + high) / 2).tolist())
    motions, *_ = motions_at(device, Parameter.LENGTH)
    return low, high, ("BT",) if motions.stable_mask.any() else ()


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
