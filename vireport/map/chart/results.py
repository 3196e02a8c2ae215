"""A chart as records of chart.json."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vireport.base.records import ResultsBlock
from vireport.map.chart.chart import Chart
from vireport.map.chart.design import ChartedDesign, ChartMargin
from vireport.map.chart.meetings import Meeting
from vireport.map.chart.network import FollowedLocus
from vireport.map.chart.plane import Cut, DevicePlane
from vireport.map.chart.regions import ChartRegion, NarrowBand, StableMotion
from vireport.map.design import alerts_of
from vireport.motions.events import Event
from vireport.motions.switching import Limits
from vireport.scenario.parameters import DesignInput
from vireport.study.result_records import AlertData
from vireport.study.results import finite

Values = tuple[float, ...]
"""Values of the two inputs."""


class ChartInput(ResultsBlock, frozen=True, kw_only=True):
    """An input of a chart.

    Attributes
    ----------
    name, unit
        the input, and its unit
    from_, to : `unit`
        ends of its range
    """

    name: DesignInput
    unit: str
    from_: float
    to: float


class ConditionData(ResultsBlock, frozen=True, kw_only=True):
    """What holds on a curve besides the equations of motion.

    Attributes
    ----------
    trace
        of the motion without its touches, D being its determinant; null where it is not fixed
    touches, membranes
        impacts of zero velocity by their place from 0, and the membrane of each
    """

    trace: str | None
    touches: list[int]
    membranes: list[str]


class StartData(ResultsBlock, frozen=True, kw_only=True):
    """A motion of a curve to start from, with its touches as impacts without velocity.

    Attributes
    ----------
    values, d
        of the inputs, and the dimensionless length
    impacts, periods
        its word, and the number of forcing periods
    velocity, time, phase_rad : F π/(M ω), half a forcing period, rad
        of each impact
    """

    values: Values
    d: float
    impacts: str
    periods: int
    velocity: list[float]
    time: list[float]
    phase_rad: list[float]


class LocusData(ResultsBlock, frozen=True, kw_only=True):
    """A curve of critical points.

    Attributes
    ----------
    kind
        of the critical points
    word, periods
        impacts of the motion without touches, and its forcing periods
    begins_with, ends_with
        what happens at its ends
    values
        pairs of the inputs
    bounds_stability, parts_regions
        for each piece between two pairs, whether stable motion ends there, and whether it parts regions with different
        stable words
    symmetric
        whether its motions are their own mirror images; null where gravity breaks the symmetry
    condition
        what holds on it
    start
        its motion in the middle
    """

    kind: Event
    word: str
    periods: int
    begins_with: Event
    ends_with: Event
    values: list[Values]
    bounds_stability: list[bool]
    parts_regions: list[bool]
    symmetric: bool | None
    condition: ConditionData
    start: StartData


class MeetingData(ResultsBlock, frozen=True, kw_only=True):
    """A point of codimension two, where curves meet, end or touch.

    Attributes
    ----------
    kinds
        both that happen there
    word, periods
        impacts of the motion without touches, and its forcing periods
    values, error_bounds
        of the inputs, and the bounds of their errors, null where not known
    velocity, phase_rad : F π/(M ω), rad
        of each impact, touches with velocity 0
    """

    kinds: tuple[Event, Event]
    word: str
    periods: int
    values: Values
    error_bounds: list[float | None]
    velocity: list[float]
    phase_rad: list[float]


class StableMotionData(ResultsBlock, frozen=True, kw_only=True):
    """A stable motion at a point of a chart.

    Attributes
    ----------
    word
        its impacts, from the one with which they come first in the alphabet
    asymmetric
        whether it has a mirror image of its own, which is stable as well: the capsule is horizontal
    impacts, periods
        its impacts in the order of what follows, and the number of forcing periods
    velocity, time, phase_rad : F π/(M ω), half a forcing period, rad
        of each impact
    trace, determinant : 1
        of the linearised return map
    """

    word: str
    asymmetric: bool
    impacts: str
    periods: int
    velocity: list[float]
    time: list[float]
    phase_rad: list[float]
    trace: float
    determinant: float


StableMotions = list[StableMotionData] | None
"""Null where rounding does not resolve motions."""


class RegionOfChart(ResultsBlock, frozen=True, kw_only=True):
    """A region that no curve on which a stable motion ends parts.

    Attributes
    ----------
    values
        of the inputs at its inner point
    share : 1
        share of the plane
    stable
        the motions that are stable there; null where rounding does not resolve motions
    """

    values: Values
    share: float
    stable: StableMotions


class NarrowBandData(ResultsBlock, frozen=True, kw_only=True):
    """Stretches of an input in which a word is stable, too narrow for the figure to show.

    Attributes
    ----------
    word, along
        the word, and the input
    least, most
        width of the narrowest and the widest of them, in the input's unit
    settable
        whether one of them is wide enough for a device to be set into it
    """

    word: str
    along: DesignInput
    least: float
    most: float
    settable: bool


class ChartMarginData(ResultsBlock, frozen=True, kw_only=True):
    """A margin of the design point of a chart.

    Attributes
    ----------
    along, kind
        the input, and what happens there
    value, distance
        of the input there, and less that of the design point, in its unit
    relative : 1
        distance over the design value; null where that is zero
    error_bound
        of the value; null where it is not known
    taken_over
        whether another motion takes over the stability there
    stable_beyond
        the motions that are stable next to it on the other side; null where rounding does not resolve motions
    """

    along: DesignInput
    kind: Event
    value: float
    distance: float
    relative: float | None
    error_bound: float | None
    taken_over: bool
    stable_beyond: StableMotions


class ChartedDesignData(ResultsBlock, frozen=True, kw_only=True):
    """The design point of a scenario in a chart.

    Attributes
    ----------
    values
        of the inputs
    stable
        the motions that are stable there; null where rounding does not resolve motions
    margins
        the nearest along each input and either way
    """

    values: Values
    stable: StableMotions
    margins: list[ChartMarginData]


class StableStretch(ResultsBlock, frozen=True, kw_only=True):
    """A stretch of a sweep across a chart.

    Attributes
    ----------
    from_, to
        ends of the stretch
    words
        those that are stable there
    """

    from_: float
    to: float
    words: tuple[str, ...]


class CutData(ResultsBlock, frozen=True, kw_only=True):
    """A sweep across a chart, and what is stable along it.

    Attributes
    ----------
    along, at
        the input that is swept, and the value of the other
    stable
        its stretches, from one break to the next
    """

    along: DesignInput
    at: float
    stable: list[StableStretch]


class ChartData(ResultsBlock, frozen=True, kw_only=True):
    """A chart: chart.json without its version and provenance.

    Attributes
    ----------
    inputs
        both inputs
    limits
        of the motions
    loci
        the curves
    points
        points of codimension two
    regions
        parts of the plane with different stable words
    narrow_bands
        what is too narrow for the figure
    design_point
        that of the scenario; null where it has no place in the plane
    alerts
        what a run of the design point alone warns of, as in [results.json](results.md#requirements-and-alerts)
    sweeps
        sweeps across the plane
    """

    inputs: list[ChartInput]
    limits: Limits
    loci: list[LocusData]
    points: list[MeetingData]
    regions: list[RegionOfChart]
    narrow_bands: list[NarrowBandData]
    design_point: ChartedDesignData | None
    alerts: list[AlertData]
    sweeps: list[CutData]


def chart_data(chart: Chart) -> ChartData:
    """A chart as it is written."""
    plane = chart.plane
    return ChartData(
        inputs=[
            ChartInput(name=varied, unit=varied.unit, from_=float(low), to=float(high))
            for varied, low, high in zip(plane.inputs, plane.low, plane.high, strict=True)
        ],
        limits=chart.limits,
        loci=[_locus(locus, edges) for locus, edges in zip(chart.loci, chart.regions.edges, strict=True)],
        points=[_point(point) for point in chart.meetings],
        regions=[_region(region) for region in chart.regions.every],
        narrow_bands=[_band(band, plane) for band in chart.narrow],
        design_point=None if chart.design is None else _design(chart.design, plane),
        alerts=[alert.data for alert in alerts_of(chart.design)],
        sweeps=[_cut(cut, plane) for cut in chart.cuts],
    )


def _locus(locus: FollowedLocus, edges: NDArray[np.bool_]) -> LocusData:
    return LocusData(
        kind=locus.event,
        word=locus.word,
        periods=locus.path.word.periods,
        begins_with=locus.events[0][1],
        ends_with=locus.events[-1][1],
        values=locus.inputs.tolist(),
        bounds_stability=locus.bounds_stability.tolist(),
        parts_regions=[bool(sides.any()) for sides in edges.reshape(len(locus.x) - 1, -1)],
        symmetric=locus.symmetric,
        condition=_condition(locus),
        start=_start(locus),
    )


def _condition(locus: FollowedLocus) -> ConditionData:
    """What holds on a locus besides the equations of motion: a trace over the determinant's root, and the touches."""
    condition, event = locus.path.condition, locus.event
    walls = [locus.path.word.walls[i] for i in condition.rests]
    levels = {Event.PERIOD_DOUBLING: "-(1 + D)", Event.FOLD: "1 + D", Event.PITCHFORK: "1 + D"}
    levels[Event.NODE_FOCUS] = "2 sqrt(D)" if condition.sign > 0 else "-2 sqrt(D)"
    return ConditionData(
        trace=levels.get(event),
        touches=list(condition.rests),
        membranes=["bottom" if wall > 0 else "top" for wall in walls],
    )


def _start(locus: FollowedLocus) -> StartData:
    """The motion in the middle of a locus."""
    x = locus.x[len(locus.x) // 2]
    motion = locus.path.motion(x)
    return StartData(
        values=tuple(x[-2:].tolist()),
        d=motion.coordinate,
        impacts=motion.word.letters,
        periods=motion.word.periods,
        velocity=motion.velocity.tolist(),
        time=motion.time.tolist(),
        phase_rad=motion.phase.tolist(),
    )


def _point(point: Meeting) -> MeetingData:
    return MeetingData(
        kinds=point.events,
        word=point.word,
        periods=point.motion.word.periods,
        values=point.inputs,
        error_bounds=[finite(bound) for bound in point.error_bound],
        velocity=point.motion.velocity.tolist(),
        phase_rad=point.motion.phase.tolist(),
    )


def _region(region: ChartRegion) -> RegionOfChart:
    return RegionOfChart(values=region.inputs, share=region.share, stable=_stable(region.motions))


def _stable(motions: tuple[StableMotion, ...] | None) -> StableMotions:
    if motions is None:
        return None
    return [
        StableMotionData(
            word=stable.word.letters,
            asymmetric=stable.asymmetric,
            impacts=stable.motion.word.letters,
            periods=stable.motion.word.periods,
            velocity=stable.motion.velocity.tolist(),
            time=stable.motion.time.tolist(),
            phase_rad=stable.motion.phase.tolist(),
            trace=stable.trace,
            determinant=stable.decay**2,
        )
        for stable in motions
    ]


def _band(band: NarrowBand, plane: DevicePlane) -> NarrowBandData:
    return NarrowBandData(
        word=band.word, along=plane.inputs[band.varied], least=band.least, most=band.most, settable=band.settable
    )


def _design(design: ChartedDesign, plane: DevicePlane) -> ChartedDesignData:
    return ChartedDesignData(
        values=design.inputs,
        stable=_stable(design.motions),
        margins=[_margin(end, plane) for end in design.margins],
    )


def _margin(end: ChartMargin, plane: DevicePlane) -> ChartMarginData:
    return ChartMarginData(
        along=plane.inputs[end.axis],
        kind=end.event,
        value=end.value,
        distance=end.distance,
        relative=end.relative,
        error_bound=finite(end.error_bound),
        taken_over=end.taken_over,
        stable_beyond=_stable(end.beyond),
    )


def _cut(cut: Cut, plane: DevicePlane) -> CutData:
    return CutData(
        along=plane.inputs[cut.line.varied],
        at=cut.line.other,
        stable=[StableStretch(from_=low, to=high, words=words) for low, high, words in cut.stable],
    )
