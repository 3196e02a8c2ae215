"""Families of motions: where they meet, that nothing simulated is missing, and that the stable ones attract."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from conftest import EXAMPLES, first
from msgspec.structs import replace

from vireport import analyse, load, loads
from vireport.motions.atlas.families import SearchEffort, atlas
from vireport.motions.events import Event
from vireport.motions.families import Atlas, Family
from vireport.motions.paths import completed, follow
from vireport.motions.points import polished
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Limits, neighbours, openings
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.simulation.attractors import attractors, find_attractor
from vireport.simulation.events import Impact
from vireport.simulation.starts import random_starts, start_speed
from vireport.study.study import sweep_of

ASIDE = 1e-7
"""Relative change of the velocity by which a simulation starts beside a motion: less where a stretch is narrow."""

LITERATURE = """\
schema_version: 1
device: {{capsule_mass_kg: 0.1245, restitution: 0.5}}
excitation: {{amplitude_n: 5, frequency_hz: 2.5}}
inclination_deg: {inclination}
sweep: {{parameter: length_m, from: 0.16, to: 0.6}}
"""

COUNTS = {"inclined": 2, "inclined-forcing": 2, "horizontal": 3}
"""Families of 1:1 motions in the examples."""


def sweep(path, **changes: float) -> Sweep:
    return replace(sweep_of(load(path).scenario), **changes)


@cache
def whole(name: str) -> Atlas:
    """Of an example, up to six impacts in four periods."""
    return atlas(sweep(EXAMPLES / f"{name}.yaml"), Limits(6, 4))


def marks(family: Family, event: Event) -> list[float]:
    return [mark.point.sweep_value for mark in family.marks if mark.event is event and mark.point is not None]


def test_a_motion_is_solved_for_once_where_a_row_of_its_family_is(study_of):
    family = study_of("inclined").solution.branches[0].family
    coordinates = family.x[:, -1]
    turns = np.flatnonzero(np.diff(coordinates[:-1]) * np.diff(coordinates[1:]) <= 0)
    assert not turns.size
    assert {len(family.at(float(coordinates[row]))) for row in (0, 1, 30, len(coordinates) - 1)} == {1}


@pytest.mark.parametrize("name", first(1, ["inclined", "inclined-forcing", "horizontal"]))
def test_families_of_1_1_motions_are_what_is_followed_from_one_of_them(name: str, study_of):
    solution = study_of(name).solution
    families = [f for f in atlas(solution.sweep, Limits(2, 1)).families if f.word.letters == "BT"]
    assert len(families) == COUNTS[name]
    for family in families:
        curve, middle = family.curve, family.x[len(family.x) // 2]
        start = curve.point(middle, curve.tangent(middle))
        trail = completed(curve, start, follow(curve, start))
        x = np.array([point.x for point in trail.points])
        for row in range(1, len(x) - 1, 7):
            followed = curve.motion(x[row])
            assert min(followed.distance(motion) for motion in family.at(followed.coordinate)) < 1e-10
        events = sorted((float(x[row, -1]), event) for row, event in trail.events)
        known = sorted((float(family.x[mark.row, -1]), mark.event) for mark in family.marks)
        assert [event for _, event in events] == [event for _, event in known]
        assert [place for place, _ in events] == pytest.approx([place for place, _ in known], abs=1e-9)


@pytest.mark.parametrize("name", first(1, ["inclined", "inclined-forcing", "horizontal"]))
def test_critical_points_of_1_1_motions_are_vertices_with_the_same_label(name: str, study_of):
    solution = study_of(name).solution
    swept_atlas = atlas(solution.sweep, Limits(2, 1))
    marks = [mark for family in swept_atlas.families for mark in family.marks if mark.point is not None]
    for point in solution.critical_points:
        (of_label,) = {mark.point for mark in marks if mark.point.label == point.label}
        assert (of_label.sweep_value, of_label.error_bound) == (point.sweep_value, point.error_bound)
        assert of_label.event is point.event
        # Where the ball oscillates between both membranes without an impact, there is no vertex.
        if point.event is not Event.NODE_FOCUS and (point.closed.velocity_bottom or point.closed.velocity_top):
            assert of_label in swept_atlas.vertices


@pytest.mark.slow
def test_at_a_period_doubling_the_doubled_word_begins(example):
    swept_atlas = atlas(sweep(example("inclined"), start=0.6), Limits(4, 2))
    (vertex,) = [v for v in swept_atlas.vertices if v.label == "B1"]
    parent, child = (swept_atlas.families[number - 1] for number in vertex.families)
    assert (parent.word.letters, child.word.letters, child.word.periods) == ("BT", "BTBT", 2)
    assert child.marks[0].point is vertex
    assert child.x[0, :4] == pytest.approx(np.tile(vertex.motion.velocity, 2), abs=1e-9)
    # It leaves with the square root of the distance: half as far beside at a quarter of it.
    aside = [
        abs(m.velocity[0] - m.velocity[2])
        for share in (1, 4)
        for m in child.at(vertex.motion.coordinate - share * 1e-6)[:1]
    ]
    assert aside[1] / aside[0] == pytest.approx(2, abs=0.01)
    # The trace of the doubled motion is that of the square: from 1 + det downward, so that it begins stable.
    assert child.segments[0].stable
    assert vertex.sweep_value in child.stable_ranges[0]


@pytest.mark.slow
@pytest.mark.parametrize(("inclination", "event"), [(30, Event.GRAZING), (60, Event.PERIOD_DOUBLING)])
def test_2_1_motion_ends_in_a_grazing_at_small_inclination_and_doubles_at_a_large_one(inclination: int, event: Event):
    swept_atlas = atlas(sweep_of(loads(LITERATURE.format(inclination=inclination)).scenario), Limits(6, 4))
    (family,) = [f for f in swept_atlas.families if f.word.letters == "BBT" and f.word.periods == 1 and f.stable_runs]
    (run,) = family.stable_runs
    last = max(run, key=lambda row: -family.sweep_value[row])
    (mark,) = [mark for mark in family.marks if mark.row == last]
    assert mark.event is event
    grazing = [m.point for m in family.marks if m.event is Event.GRAZING]
    words = {swept_atlas.families[number - 1].word.letters for vertex in grazing for number in vertex.families}
    assert {"BBT", "BBBT"} <= words
    begins = [m.point for m in family.marks if m.event is Event.ZERO_VELOCITY]
    words = {swept_atlas.families[number - 1].word.letters for vertex in begins for number in vertex.families}
    assert {"BT", "BBT"} <= words
    energies = [
        max(float(np.mean(f.velocity[list(run)] ** 2)) for run in f.stable_runs)
        for word in ("BT", "BBT", "BBBT", "BBBBT")
        for f in swept_atlas.families
        if f.word == Word.of(word, 1) and f.stable_runs and np.ptp(f.stable_ranges) > 0.01
    ]
    assert len(energies) == 4
    assert energies == sorted(energies, reverse=True)


def test_families_join_at_grazing_points_where_an_impact_has_no_velocity(example):
    swept_atlas = atlas(sweep(example("inclined-forcing"), start=5.0, end=5.4), Limits(3, 2))
    (vertex,) = [v for v in swept_atlas.vertices if v.event is Event.GRAZING]
    words = {swept_atlas.families[number - 1].word.letters for number in vertex.families}
    assert words == {"B", "BT", "BBT"}
    motion = vertex.motion
    assert motion.word.letters == "BT"
    assert motion.velocity[1] == 0.0
    for number in vertex.families:
        family = swept_atlas.families[number - 1]
        (mark,) = [mark for mark in family.marks if mark.point is vertex]
        speeds = np.sort(np.abs(family.velocity[mark.row]))
        assert speeds[-1] == pytest.approx(motion.velocity[0], abs=1e-9)
        assert np.isnan(family.trace[mark.row]) == (speeds[0] < 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "count", "apart"),
    [("inclined", 314, {"BBTBT"}), ("horizontal", 320, set())],
)
def test_every_periodic_attractor_lies_on_a_family(name: str, count: int, apart: set[str], example):
    # A family that joins no other, and has more than four impacts, is known from the simulation only.
    swept = sweep(example(name))
    values, r = np.linspace(swept.start, swept.end, 41), float(swept.device.restitution)
    d, gbar = (np.broadcast_to(x, 41).astype(float) for x in swept.device.groups(swept.parameter, values)[:2])
    ends = attractors(Groups(d, gbar, r), random_starts(d, start_speed(r, [0.0] * 41), 8, 20190301))
    simulated = [
        end.cycle.motion(float(swept.coordinate_of(value)))
        for value, row in zip(values, ends, strict=True)
        for end in row
        if end.cycle is not None and not end.cycle.sticks and len(end.cycle.wall) <= 6 and end.cycle.period <= 4
    ]
    assert len(simulated) == count

    def missing(swept_atlas: Atlas) -> set[str]:
        def off(motion: Motion) -> float:
            known = (place for family in swept_atlas.families for place in family.at(motion.coordinate))
            return min(motion.distance(other, mirror=swept.level.horizontal) for other in known)

        return {motion.word.letters for motion in simulated if off(motion) > 1e-10}

    assert missing(whole(name)) == apart
    assert not apart or missing(atlas(swept, Limits(6, 4), simulated)) == set()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "count"), [("inclined", 5), ("horizontal", 12), ("inclined-forcing", 54)])
def test_every_stable_stretch_attracts_from_beside_it(name: str, count: int):
    checked = 0
    for family in whole(name).families:
        for part in family.segments:
            if part.stable:
                between = family.x[(part.first + part.last) // 2 : (part.first + part.last + 3) // 2].mean(axis=0)
                x, checked = family.curve.nearest(between), checked + 1
                motion = family.curve.motion(x)
                d, gbar, *_ = family.curve.model.groups(x[-1]).as_floats()
                ends = family.sweep_value[[part.first, part.last]]
                aside = min(ASIDE, 0.1 * float(np.ptp(ends) / ends[0]))
                start = Impact(motion.word.walls[0], float(x[0]) * (1 + aside), float(motion.phase[0]))
                cycle = find_attractor(Groups(d, gbar, family.curve.model.r), start).cycle
                assert cycle is not None
                assert motion.distance(cycle.motion(motion.coordinate)) < 1e-8
    assert checked >= count


@pytest.mark.slow
def test_the_cascade_beyond_b1_doubles_at_feigenbaums_rate(example):
    swept = sweep(example("inclined"), start=0.5965, end=0.64)
    swept_atlas = atlas(swept, Limits(2, 1))
    (vertex,) = [v for v in swept_atlas.vertices if v.label == "B1"]
    curve, motion, doublings = swept_atlas.families[vertex.families[0] - 1].curve, vertex.motion, []
    for low in (swept.start, *4 * [0.6183]):
        doublings.append(polished(swept, motion, Event.PERIOD_DOUBLING).sweep_value)
        curve = replace(curve, low=float(swept.coordinate_of(low)))
        _, curve, _, start = next(neighbours(curve, motion, Event.PERIOD_DOUBLING, swept_atlas.limits))
        strand = follow(curve, start)
        (row,) = [row for row, event in strand.events if event is Event.PERIOD_DOUBLING]
        motion = curve.motion(strand.points[row].x)
    assert motion.word == Word.of(32 * "BT", 32)
    doublings.append(polished(swept, motion, Event.PERIOD_DOUBLING).sweep_value)
    gaps = -np.diff(doublings[1:])  # the first doubling is apart from the others by two folds
    assert gaps[:-1] / gaps[1:] == pytest.approx([4.445, 4.650, 4.662], abs=1e-3)
    assert doublings[0] == pytest.approx(0.6294571410117573, abs=1e-15)


@pytest.mark.slow
def test_the_shortest_words_are_followed_first_and_what_is_left_out_is_said():
    """In an atlas that is cut short all families up to `followed` impacts are those of the whole."""
    swept = sweep_of(loads(LITERATURE.format(inclination=30)).scenario)
    cut = [atlas(swept, Limits(7, 1), effort=SearchEffort(openings=count)) for count in (0, 2, 1000)]
    assert [part.followed for part in cut] == [4, 5, 7]

    def families(of: Atlas, impacts: int) -> list[tuple[str, int]]:
        return [(family.name, len(family.x)) for family in of.families if len(family.word) <= impacts]

    for part in cut:
        assert families(part, part.followed) == families(cut[-1], part.followed)
    assert len(cut[0].families) < len(cut[1].families) < len(cut[-1].families)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("impacts", "periods", "r", "openings", "some"),
    [
        # Steps become as short as rounding lets the length be: events are located on a staircase.
        (6, 8, 0.9, 20, {"BBT": 34, "BBB": 42}),
        # All that begins was followed for 16 minutes without end.
        (10, 10, 0.95, 6, {}),
    ],
)
def test_an_atlas_of_very_many_families_ends_and_says_what_it_leaves_out(
    impacts: int, periods: int, r: float, openings: int, some: dict[str, int], example
):
    """Over the whole of lengths; words of more than four impacts are tried a few times, where families meet."""
    changes = [f"motions.impacts={impacts}", f"motions.periods={periods}", f"device.restitution={r}"]
    swept = sweep_of(load(example("inclined"), [*changes, "sweep.from=0.05", "sweep.to=2"]).scenario)
    found = atlas(swept, Limits(impacts, periods), effort=SearchEffort(openings=openings))
    assert 4 <= found.followed < impacts
    assert all(Event.LOST not in {mark.event for mark in family.marks} for family in found.families)
    assert {word: sum(family.word.letters == word for family in found.families) for word in some} == some


def test_of_repeated_periods_each_word_is_tried_once_and_the_shortest_first():
    """Of n periods with one touch, 2, 1, 2, 3 and 6 choices are neither rotations of others nor repeat themselves."""
    swept = sweep_of(loads(LITERATURE.format(inclination=30)).scenario)
    whole = atlas(swept, Limits(3, 1))
    vertices = (v for v in whole.vertices if v.event is Event.GRAZING and len(v.motion.rests) == 1)
    vertex = next(v for v in vertices if len(v.motion.word) <= 3 and v.motion.word.periods == 1)
    curve = replace(whole.families[vertex.families[0] - 1].curve, word=vertex.motion.word)
    tried = [impacts for impacts, _ in openings(curve, vertex.motion, Event.GRAZING, Limits(16, 5))]
    assert len(tried) == 2 + 1 + 2 + 3 + 6
    assert tried == sorted(tried)


WIDE = """\
schema_version: 1
device: {{capsule_mass_kg: 0.1245, restitution: {r}, length_m: 0.7}}
excitation: {{amplitude_n: 3.0}}
inclination_deg: {beta}
sweep: {{parameter: frequency_hz, from: {low}, to: {high}}}
motions: {{impacts: 2, periods: 2}}
"""


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("r", "beta", "low", "high"),
    [
        pytest.param(0.375, 0.0, 1e-6, 1e6, marks=pytest.mark.slow),
        (0.538, 45.0, 1e-9, 1e9),
        pytest.param(0.9, 90.0, 1e-3, 1e12, marks=pytest.mark.slow),
    ],
)
def test_motions_are_the_same_in_a_sweep_over_many_decades_of_frequency(r: float, beta: float, low: float, high: float):
    def found(low: float, high: float) -> dict[tuple[str, int], set[float]]:
        """Where families of each word begin or end by grazing or a fold."""
        study = analyse(loads(WIDE.format(r=r, beta=beta, low=low, high=high)), ["json"])
        places: dict[tuple[str, int], set[float]] = {}
        for family in study.atlas.families:
            assert Event.LOST not in {mark.event for mark in family.marks}
            own = {round(mark.point.sweep_value, 6) for mark in family.marks if mark.point is not None}
            places.setdefault((family.word.letters, family.word.periods), set()).update(own)
        return places

    assert found(low, high) == found(0.02, 200)


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("r", first(1, [0.5, 0.0, 0.97]))
def test_a_ball_that_all_but_floats_has_room_from_its_amplitude_on_in_a_sweep_over_many_decades(r: float):
    """With next to no gravity the ball rises above the membrane that it touches by 2/pi^2, twice its amplitude."""
    study = analyse(loads(WIDE.format(r=r, beta=1e-6, low=1e-9, high=1e9)), ["json"])
    families = [family for family in study.atlas.families if family.word.letters == "B"]
    assert len(families) == 2
    for family in families:
        assert [mark.event for mark in family.marks] == [Event.GRAZING, Event.SWEEP_END]
        assert family.marks[0].point.d == pytest.approx(2 / np.pi**2, rel=1e-6)
        assert family.sweep_value[-1] == 1e9
