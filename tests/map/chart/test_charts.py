"""Loci over two inputs: against the events on random sweeps, and their points of codimension two in 40 digits."""

from __future__ import annotations

from collections import Counter
from functools import cache
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES
from exact import printed_maps, printed_trace
from mpmath import mp, mpf
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from vireport import load
from vireport.design.lines import line_of
from vireport.design.margins import margins_of
from vireport.design.point import motions_at
from vireport.figures.captions import held_by
from vireport.map.chart.chart import PlaneLoci, loci_over
from vireport.map.chart.loci import Locus
from vireport.map.chart.meetings import Meeting
from vireport.map.chart.network import FollowedLocus
from vireport.map.chart.over import plane_of
from vireport.map.chart.plane import DevicePlane, StraightSweep
from vireport.motions.atlas.families import atlas
from vireport.motions.conditions import Condition
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Limits
from vireport.physics.device import RESTITUTIONS
from vireport.physics.groups import Groups
from vireport.physics.motion import SAME_TOUCH
from vireport.physics.word import Word
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import attractors
from vireport.simulation.starts import random_starts, start_speed
from vireport.study.checks import reference
from vireport.text.templates import Words

PLANES = (
    "inclination_deg=0..90,length_m=0.3..1",
    "restitution=0.2..0.8,length_m=0.3..1",
    "frequency_hz=1..3,amplitude_n=1..6",
    "restitution_bottom=0.05..0.95,length_m=0.3..1.9",
)


@cache
def plane(over: str) -> DevicePlane:
    return plane_of(load(EXAMPLES / "inclined.yaml").scenario, over)


@cache
def one_to_one(over: str) -> PlaneLoci:
    return loci_over(plane(over), Limits(2, 1), cuts=0)


@cache
def all_words() -> PlaneLoci:
    return loci_over(plane(PLANES[1]), Limits(4, 2))


@cache
def two_touches() -> PlaneLoci:
    return loci_over(plane("capsule_mass_kg,restitution"), Limits(4, 2))


@cache
def horizontal(over: str, limits: Limits) -> PlaneLoci:
    cuts = 0 if limits.impacts == 2 else 2
    return loci_over(plane_of(load(EXAMPLES / "horizontal.yaml").scenario, over), limits, cuts=cuts)


@cache
def symmetric() -> PlaneLoci:
    return horizontal("restitution=0.05..0.97,length_m=0.1..4", Limits(2, 1))


def crossings(locus: FollowedLocus, k: int, value: float) -> list[NDArray[Any]]:
    """Where a locus crosses a value of one of the inputs: the unknowns of its motions there."""
    p, places, normal = locus.inputs[:, k], [], np.eye(locus.x.shape[1])[k - 2]
    for i in np.flatnonzero((p[:-1] - value) * (p[1:] - value) <= 0):
        share = (value - p[i]) / (p[i + 1] - p[i]) if p[i + 1] != p[i] else 0.5
        guess = locus.x[i] + share * (locus.x[i + 1] - locus.x[i])
        guess[k - 2] = value
        x = locus.path.solved(guess, normal)
        places += [] if x is None else [x]
    return places


def nearest(drawn: PlaneLoci, event: Event, k: int, other: float, value: float) -> float:
    """Relative distance, along a sweep, from a value to the nearest crossing of a locus."""
    loci = (locus for locus in drawn.loci if locus.event is event)
    return min((abs(x[-2 + k] / value - 1) for locus in loci for x in crossings(locus, 1 - k, other)), default=np.inf)


@pytest.mark.slow
@pytest.mark.parametrize("over", PLANES)
def test_every_critical_point_of_1_1_motions_on_random_sweeps_lies_on_a_locus(over: str):
    rng, drawn, checked = np.random.default_rng(7), one_to_one(over), 0
    for i in range(16):
        k = 1 if plane(over).inputs[0] in RESTITUTIONS else i % 2
        other = float(plane(over).low[1 - k] + plane(over).widths[1 - k] * rng.uniform(0.02, 0.98))
        for critical in solve(StraightSweep(plane(over), k, other).sweep).critical_points:
            value = critical.sweep_value
            assert nearest(drawn, critical.event, k, other, value) < 1e-10, (critical.event, k, other, value)
            checked += 1
    assert checked > 20


@pytest.mark.slow
def test_every_critical_point_of_sweeps_over_a_restitution_lies_on_a_locus():
    rng, drawn, checked = np.random.default_rng(3), one_to_one(PLANES[3]), 0
    for length in rng.uniform(0.35, 1.85, 8):
        device = plane(PLANES[3]).device.with_values({DesignInput.LENGTH: float(length)})
        for critical in solve(Sweep(device, Parameter.RESTITUTION_BOTTOM, 0.06, 0.94)).critical_points:
            near = nearest(drawn, critical.event, 0, float(length), critical.sweep_value)
            assert near < 1e-10, (critical.event, length, critical.sweep_value)
            checked += 1
    assert checked > 10


@pytest.mark.slow
def test_a_curve_of_grazing_over_one_restitution_tells_where_stable_motion_ends():
    grazing = [locus for locus in one_to_one(PLANES[3]).loci if locus.event is Event.GRAZING]
    pairs = [(locus, row) for locus in grazing for row in range(len(locus.x) - 1)]
    stable = {abs(locus.trace[row]) < 1 + (0.5 * locus.inputs[row, 0]) ** 2 for locus, row in pairs}
    for locus, row in pairs:
        # One piece ends at a period doubling, where the trace is the limit but for rounding.
        both = [abs(locus.trace[k]) < 1 + (0.5 * locus.inputs[k, 0]) ** 2 + 1e-6 for k in (row, row + 1)]
        assert locus.bounds_stability[row] == all(both)
    assert stable == {True, False}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "ranges", "events"),
    [
        ("inclined", "0.3..0.7", {Event.PERIOD_DOUBLING, Event.NODE_FOCUS}),
        ("horizontal", "0.2..0.9", {Event.PERIOD_DOUBLING}),
    ],
)
def test_stable_motion_ends_on_a_curve_over_both_restitutions(name: str, ranges: str, events: set[Event]) -> None:
    """The ends of the margins of random devices, which are followed from these along either restitution."""
    over = f"restitution_bottom={ranges},restitution_top={ranges}"
    own = plane_of(load(EXAMPLES / f"{name}.yaml").scenario, over)
    drawn, rng, checked = loci_over(own, Limits(4, 2)), np.random.default_rng(3), 0
    assert events <= {locus.event for locus in drawn.loci}
    caption = Words("chart")("caption", drawn, False, held_by(own.device, own.inputs))
    assert caption.startswith("Restitution at the top against restitution at the bottom, of 1:1")
    for _ in range(8):
        at = own.low + own.widths * rng.uniform(0.02, 0.98, 2)
        device = own.device_at(at.tolist())
        motions, *_ = motions_at(device, Parameter.LENGTH)
        for k, varied in enumerate(own.inputs):
            for margin in margins_of(device, motions, [line_of(varied, device)]).margins:
                if own.low[k] < (value := margin.sweep_value) < own.high[k]:
                    assert nearest(drawn, margin.event, k, float(at[1 - k]), value) < 1e-10
                    checked += 1
    assert checked > 3
    stable = {words for cut in drawn.cuts for _, _, words in cut.stable}
    assert stable == {("BT",), ()}


@pytest.mark.slow
def test_every_event_of_families_on_random_sweeps_lies_on_a_locus():
    rng, drawn, checked = np.random.default_rng(5), all_words(), Counter()
    for other in rng.uniform(0.25, 0.6, 2):
        families = atlas(StraightSweep(drawn.plane, 1, float(other)).sweep, Limits(4, 2))
        points = [(vertex, vertex.event) for vertex in families.vertices]
        marks = (mark for family in families.families for mark in family.marks)
        points += [(mark.point, mark.event) for mark in marks if mark.event is Event.NODE_FOCUS]
        for point, event in points:
            motion = point.motion
            if min(np.diff(motion.time, append=motion.time[0] + 2 * motion.word.periods)) < SAME_TOUCH:
                continue  # two impacts without velocity that are one touch
            assert nearest(drawn, event, 1, float(other), point.sweep_value) < 1e-10, (event, motion.word.letters)
            checked[event] += 1
    assert checked[Event.NODE_FOCUS] > 10
    assert checked.total() > 40


def exact_inputs(drawn: PlaneLoci, point: Meeting) -> list[Any]:
    """The inputs at a point with a touch, in 40 digits by the printed maps, from a start that is off by some 1e-7."""
    motion, rests, event = point.motion, point.motion.rests, point.events[0]
    word, count = motion.word, len(motion.word)
    without = motion.without_impacts(rests).word
    kept = [i for i in range(count) if i not in rests]

    def conditions(x: list[Any], speed: Any) -> list[Any]:
        if event is Event.PITCHFORK:  # the second half of the motion is the image of the first
            v, t = x[: count // 2], x[count // 2 : count]
            x = [*v, *(-each for each in v), *t, *(each + word.periods for each in t), *x[count:]]
        device = drawn.plane.device_at(x[-2:])
        r, (d, gbar) = mpf(device.restitution), reference.groups(device, "length_m", device.length_m)
        maps = [*printed_maps(word, x, d, gbar, r), *(x[rest] - speed for rest in rests)]
        if event is Event.GRAZING:
            return maps
        if event is Event.DEGENERATE_GRAZING:
            return [*maps, speed * printed_trace(word, x, d, gbar, r)]
        border = (1 + r ** (2 * len(without))) * (-1 if event is Event.PERIOD_DOUBLING else 1)
        if event is Event.PITCHFORK:
            maps = [*maps[:count], x[rests[0]]]
        own = [x[i] for i in (*kept, *(count + i for i in kept))]
        return [*maps, printed_trace(without, own, d, gbar, r) - border]

    part = slice(count // 2 if event is Event.PITCHFORK else count)
    given = np.array([*motion.velocity[part], *motion.time[part], *point.inputs])
    guess = given * (1 + 1e-7 * np.random.default_rng(1).uniform(-1, 1, len(given)))

    def solved(speed: Any) -> list[Any]:
        return reference.newton(lambda x: conditions(x, speed), guess.tolist(), [1] * len(guess))[-2:]

    if event is not Event.DEGENERATE_GRAZING:
        return solved(0)
    once, twice = solved(mpf("1e-12")), solved(mpf("2e-12"))  # where the pole of the trace vanishes: as a limit
    return [2 * a - b for a, b in zip(once, twice, strict=True)]


@pytest.mark.slow
def test_points_of_codimension_two_are_those_of_the_printed_maps_in_40_digits():
    kinds = Counter[Event]()
    for drawn in (all_words(), two_touches(), symmetric()):
        for point in drawn.meetings:
            if point.events[1] is Event.GRAZING and kinds[point.events[0]] < 2:
                assert np.isfinite(point.error_bound).all()
                with reference.precise(), mp.workdps(150):
                    for value, bound, exact in zip(
                        point.inputs, point.error_bound, exact_inputs(drawn, point), strict=True
                    ):
                        assert abs(exact - mpf(value)) <= bound < 1e-12, (point.events, point.inputs)
                kinds[point.events[0]] += 1
    assert set(kinds) == {
        Event.PERIOD_DOUBLING, Event.FOLD, Event.PITCHFORK, Event.DEGENERATE_GRAZING, Event.GRAZING,
    }  # fmt: skip


@pytest.mark.slow
def test_where_a_pitchfork_grazes_one_curve_of_grazing_ends_and_one_goes_through():
    """Symmetric motions touch both membranes, asymmetric ones a single one, and no point lies beside it."""
    (point,) = [meeting for meeting in symmetric().meetings if meeting.events == (Event.PITCHFORK, Event.GRAZING)]
    others = [meeting.inputs for meeting in symmetric().meetings if meeting is not point]
    assert np.abs(np.array(others) - point.inputs).max(axis=1).min() > 0.01
    grazing = [locus for locus in symmetric().loci if locus.event is Event.GRAZING]
    assert sorted(len(locus.path.condition.rests) for locus in grazing) == [1, 2]
    ends = [locus.inputs[[0, -1]] - point.inputs for locus in grazing]
    assert sorted(int((np.abs(end).max(axis=1) < 1e-8).sum()) for end in ends) == [0, 1]
    assert min(abs(x[-1] - point.inputs[1]) for locus in grazing for x in crossings(locus, 0, point.inputs[0])) < 1e-8


@pytest.mark.slow
def test_a_touch_counts_once_where_its_impacts_come_at_one_time():
    drawn = horizontal("restitution=0.03..0.06,length_m=0.8..0.83", Limits(4, 3))
    for point in drawn.meetings:
        assert np.isfinite(point.error_bound).all()
        wait = np.diff(point.motion.time, append=point.motion.time[0] + 2 * point.motion.word.periods)
        assert wait.min() > SAME_TOUCH, point.motion
    assert len({meeting.inputs for meeting in drawn.meetings}) == len(drawn.meetings) > 5


@pytest.mark.slow
def test_a_cusp_is_where_three_motions_are_one_in_40_digits():
    """With one velocity given and one condition left out, what is left of that one has a triple zero there."""
    (cusp,) = [point for point in all_words().meetings if point.events[1] is Event.CUSP]
    motion, step = cusp.motion, mpf(10) ** -30
    unknown = [mpf(float(v)) for v in (*motion.velocity[1:], *motion.time)]

    def rest(speed: Any, inputs: list[Any]) -> Any:
        device = all_words().plane.device_at(inputs)
        groups = reference.groups(device, "length_m", device.length_m)

        def maps(x: list[Any]) -> list[Any]:
            return printed_maps(motion.word, [speed, *x], *groups, device.restitution)

        return maps(reference.newton(lambda x: maps(x)[:-1], unknown, [1] * len(unknown)))[-1]

    def conditions(x: list[Any]) -> list[Any]:
        behind, here, ahead = (rest(x[0] + k * step, x[1:]) for k in (-1, 0, 1))
        return [here, (ahead - behind) / step, (ahead - 2 * here + behind) / step**2]

    with reference.precise(), mp.workdps(150):
        guess = [mpf(float(v)) * (1 + mpf(k) / 10**6) for k, v in enumerate((motion.velocity[0], *cusp.inputs), 1)]
        _, *exact = reference.newton(conditions, guess, [1] * 3)
        for value, bound, there in zip(cusp.inputs, cusp.error_bound, exact, strict=True):
            assert abs(there - mpf(value)) <= bound


@pytest.mark.slow
def test_a_degenerate_period_doubling_is_that_of_the_printed_maps_in_40_digits():
    """With one velocity of two periods given and one condition left out, its first and third derivative are zero."""
    drawn = loci_over(plane("restitution=0.84..0.9,length_m=1.15..1.35"), Limits(2, 1), cuts=0)
    (point,) = [meeting for meeting in drawn.meetings if meeting.events[1] is Event.DEGENERATE_DOUBLING]
    assert max(point.error_bound) < 1e-14
    word, twice, step = point.motion.word, point.motion.times(2), mpf(10) ** -12

    def solved(equations: Any, guess: list[Any]) -> list[Any]:
        return reference.newton(equations, guess, [1] * len(guess))

    def conditions(inputs: list[Any]) -> list[Any]:
        device = drawn.plane.device_at(inputs)
        groups = (*reference.groups(device, "length_m", device.length_m), device.restitution)
        once = [mpf(float(v)) for v in (*point.motion.velocity, *point.motion.time)]
        once = solved(lambda x: printed_maps(word, x, *groups), once)
        unknown = [once[1], *once[:2], *once[2:], *(t + 2 for t in once[2:])]

        def rest(speed: Any) -> Any:
            x = solved(lambda x: printed_maps(twice.word, [speed, *x], *groups)[:-1], unknown)
            return printed_maps(twice.word, [speed, *x], *groups)[-1]

        far_behind, behind, ahead, far_ahead = (rest(once[0] + k * step) for k in (-2, -1, 1, 2))
        first = (8 * (ahead - behind) - (far_ahead - far_behind)) / (12 * step)
        return [first, (far_ahead - 2 * (ahead - behind) - far_behind) / (2 * step**3)]

    with reference.precise(), mp.workdps(150):
        exact = solved(conditions, [mpf(value) * (1 + mpf(10) ** -6) for value in point.inputs])
        for value, bound, there in zip(point.inputs, point.error_bound, exact, strict=True):
            assert abs(there - mpf(value)) <= bound


@pytest.mark.slow
def test_no_curve_is_there_twice():
    loci = all_words().loci
    for locus in loci:
        middle = locus.x[len(locus.x) // 2]
        for other in loci:
            if other is not locus and (other.word, other.event) == (locus.word, locus.event):
                assert not any(np.abs(x - middle).max() < 1e-9 for x in crossings(other, 0, middle[-2]))


@pytest.mark.slow
def test_two_curves_of_folds_end_together_in_a_cusp():
    (cusp,) = [point for point in all_words().meetings if point.events[1] is Event.CUSP]
    r, length = cusp.inputs
    assert max(cusp.error_bound) < 1e-15
    folds = [locus for locus in all_words().loci if locus.word == cusp.word and locus.event is Event.FOLD]

    def beside(off: float) -> list[float]:
        return sorted(float(x[-1]) for fold in folds for x in crossings(fold, 0, r + off) if abs(x[-1] - length) < 0.02)

    assert beside(-1e-4) == []
    widths = [np.ptp(beside(off)) for off in (1e-4, 4e-4)]
    assert widths[1] / widths[0] == pytest.approx(8, rel=0.02)  # the power 3/2 of the distance


def known_regions(drawn: PlaneLoci, count: int) -> tuple[NDArray[Any], NDArray[Any], dict[int, set[tuple[str, ...]]]]:
    """Regions between curves on a raster, the distance to the nearest curve, and the words that sweeps find in each."""
    plane, free = drawn.plane, np.ones((count, count), dtype=bool)
    for locus in drawn.loci:
        for x, y in zip(locus.drawn(40)[:-1], np.repeat(locus.bounds_stability, 40), strict=True):
            if y:
                free[raster(plane, x, count)] = False
    room, regions, words = distance_transform_edt(free), label(free)[0], {}
    for cut in drawn.cuts:
        for low, high, stable in cut.stable:
            for value in np.linspace(low, high, 50)[1:-1]:
                at = raster(plane, np.insert([cut.line.other], cut.line.varied, value), count)
                if room[at] > 2:
                    words.setdefault(regions[at], set()).add(stable)
    return regions, room, words


def raster(plane: DevicePlane, inputs: Any, count: int) -> tuple[int, ...]:
    share = (np.asarray(inputs) - plane.low) / plane.widths
    return tuple(np.clip((share * count).astype(int), 0, count - 1).tolist())


@pytest.mark.slow
def test_a_simulation_ends_in_the_words_of_its_region_and_in_no_others():
    drawn, cells, checked = all_words(), 7, 0
    regions, room, words = known_regions(drawn, 240)
    assert all(len(sets) == 1 for sets in words.values())
    shares = (np.arange(cells) + 0.5) / cells
    for r in (drawn.plane.low[0] + drawn.plane.widths[0] * shares).tolist():
        lengths = drawn.plane.low[1] + drawn.plane.widths[1] * shares
        groups = np.array([drawn.plane.at([r, length])[:2] for length in lengths.tolist()])
        d, gbar = groups.T.copy()
        ends = attractors(Groups(d, gbar, r), random_starts(d, start_speed(r, [0.0] * cells), 16, 1))
        for length, each in zip(lengths, ends, strict=True):
            at = raster(drawn.plane, [r, length], 240)
            if room[at] > 3 and regions[at] in words:
                cycles = [end.cycle for end in each if end.cycle is not None and not end.cycle.sticks]
                short = [cycle for cycle in cycles if len(cycle.wall) <= 4 and cycle.period <= 2]
                ((stable,),) = [tuple(words[regions[at]])]
                assert {Word.of(cycle.word).canonical().letters for cycle in short} == set(stable), (r, length)
                checked += 1
    assert checked > 24


CONDITIONS = (
    Condition(Event.PERIOD_DOUBLING),
    Condition(Event.FOLD),
    Condition(Event.NODE_FOCUS, sign=-1),
    Condition(Event.GRAZING, (1,)),
    Condition(Event.FOLD, (1,)),
    Condition(Event.DEGENERATE_GRAZING, (1,)),
)


@pytest.mark.parametrize("condition", CONDITIONS)
@pytest.mark.parametrize("over", [*PLANES, "capsule_mass_kg=0.1..0.2,inclination_deg"])
def test_derivatives_of_a_locus_are_those_of_its_conditions(over: str, condition: Condition):
    rng, word = np.random.default_rng(3), Word((1, 1, -1), 1)
    path = Locus(word, plane(over), condition)
    p = path.plane.low + path.plane.widths * [0.3, 0.6]
    x = np.concatenate([rng.uniform(0.2, 1, 3), np.sort(rng.uniform(0, 2, 3)), p])
    length = np.linalg.norm(path.linearised(x)[1][-1] / path.scale)
    assert length == pytest.approx(1)

    def values(x):
        groups = path.plane.at(x[6:].tolist())
        own = condition.value(word, x[:6].tolist(), groups, path.plane.ops)
        return np.append(path.residuals(x.tolist(), path.plane), own)

    matrix = path.linearised(x)[1]
    differences = np.array([(values(x + step) - values(x - step)) / 2e-6 for step in np.eye(8) * 1e-6 * path.scale]).T
    differences[-1] /= np.linalg.norm(differences[-1] / path.scale)
    np.testing.assert_allclose(matrix, differences, atol=1e-6 * path.scale.max())
