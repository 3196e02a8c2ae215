"""Motions in closed form above their flight times, and that none is missed: any of them lies on a family."""

from __future__ import annotations

from collections import Counter
from itertools import product

import numpy as np
import pytest
from msgspec.structs import replace

from vireport import load, loads
from vireport.motions.atlas.exclusion import Exclusion
from vireport.motions.atlas.families import atlas
from vireport.motions.atlas.four_impacts import four_impacts
from vireport.motions.atlas.one_impact import one_impact
from vireport.motions.atlas.surface import candidates_above, onto_sweep
from vireport.motions.families import Claim
from vireport.motions.paths import Curve
from vireport.motions.periodicity import Model, residuals
from vireport.motions.stability import flight_jacobian
from vireport.motions.sweep import Held, Level
from vireport.motions.switching import Limits
from vireport.motions.turning import turns
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.simulation.attractors import attractors, find_attractor
from vireport.simulation.events import Impact
from vireport.simulation.starts import random_starts, start_speed
from vireport.study.study import sweep_of

BBT, BTT = (1, 1, -1), (1, -1, -1)


def random_flights(seed: int, periods: int, count: int, impacts: int = 3) -> np.ndarray:
    """All flight times but the last."""
    return np.random.default_rng(seed).dirichlet([1] * impacts, count).T[:-1] * 2 * periods


@pytest.mark.parametrize(("walls", "periods"), [(BBT, 1), (BTT, 2), (BBT, 3)])
def test_motions_with_three_impacts_solve_the_conditions(walls: tuple[int, ...], periods: int):
    word, r = Word(walls, periods), 0.6
    candidates = candidates_above(word, random_flights(periods, periods, 40), r)
    for i in np.flatnonzero(np.abs(candidates.gbar) < 1):
        x, d = [*candidates.velocity[:, i], *candidates.time[:, i], candidates.gbar[i]], candidates.d[i]
        assert max(map(abs, residuals(word, x, Model(Level(Held.D, d), r)))) < 1e-13
        motion = Motion(word, candidates.velocity[:, i], candidates.time[:, i], candidates.gbar[i])
        inside = all(turn.gap > 0 for turn in turns(motion, Groups(d, candidates.gbar[i], r)))
        assert candidates.admissible[i] == (inside and (motion.velocity * walls > 0).all())
    assert 0 < candidates.admissible.sum() < 20


def test_their_multipliers_have_the_product_of_the_restitution_and_the_sum_of_the_trace():
    word, r = Word(BBT, 2), 0.7
    candidates = candidates_above(word, random_flights(0, 2, 100), r)
    product, pull = np.eye(2), candidates.gbar + np.cos(np.pi * candidates.time)
    ends = [*candidates.time[1:], candidates.time[0] + 4]
    for i in range(3):
        j = (i + 1) % 3
        parts = flight_jacobian(
            ends[i] - candidates.time[i], (candidates.velocity[i], candidates.velocity[j]), (pull[i], pull[j]), r
        )
        product = np.moveaxis(np.array(parts).reshape(2, 2, -1), -1, 0) @ product
    size = np.abs(product).max(axis=(1, 2))
    assert (np.abs(np.linalg.det(product) - r**6) < 1e-13 * size**2).all()
    np.testing.assert_allclose(np.trace(product, axis1=1, axis2=2), candidates.trace, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("walls", [BBT, BTT, (1, 1, 1, -1), (1, 1, -1, -1)])
def test_the_mirror_image_is_a_motion_with_gravity_the_other_way(walls: tuple[int, ...]):
    flights = random_flights(1, 2, 50, len(walls))
    one, other = (candidates_above(s, flights, 0.5) for s in (Word(walls, 2), Word(walls, 2).mirrored()))
    np.testing.assert_allclose(other.velocity, -one.velocity, atol=1e-12)
    np.testing.assert_allclose(other.gbar, -one.gbar, atol=1e-12)
    np.testing.assert_allclose(other.d, one.d, atol=1e-12)
    np.testing.assert_allclose((other.time - one.time) % 2, 1, atol=1e-12)


@pytest.mark.parametrize("periods", [1, 2])
@pytest.mark.parametrize(
    ("level", "low", "high"),
    [(Level(Held.GBAR, 0.05), 0.05, 3.0), (Level(Held.RATIO, 8.0), 0.2, 3.0), (Level(Held.D, 0.5), 0.01, 0.3)],
)
def test_motions_with_one_impact_solve_the_conditions(level: Level, low: float, high: float, periods: int):
    model = Model(level, 0.8)
    motions = one_impact(model, low, high, periods)
    assert len(motions.d)
    assert motions.admissible.all()
    for velocity, time, coordinate in zip(*motions.velocity, *motions.time, motions.coordinate(level), strict=True):
        assert low < coordinate < high
        assert max(map(abs, residuals(motions.word, [velocity, time, coordinate], model))) < 1e-13


@pytest.mark.parametrize("periods", [1, 2, 3])
def test_motions_with_two_impacts_on_the_bottom_solve_the_conditions_at_any_d(periods: int):
    word, r = Word((1, 1), periods), 0.6
    candidates = candidates_above(word, random_flights(periods, periods, 20, 2), r)
    assert np.isnan(candidates.d).all()
    assert (candidates.gbar > 0).all()
    for i in range(20):
        x = [*candidates.velocity[:, i], *candidates.time[:, i], candidates.gbar[i]]
        for d in (0.1, 1.0):
            assert max(map(abs, residuals(word, x, Model(Level(Held.D, d), r)))) < 1e-11 * max(1, candidates.gbar[i])


def test_the_shortest_crossing_is_by_the_fastest_ball_with_the_largest_acceleration():
    gbar, d, r = 0.3, 0.05, 0.8
    t = Exclusion(Model(Level(Held.GBAR, gbar), r), d, 2 * d, (Word((1, 1, -1), 2),)).shortest(4.0)
    fastest = (4 * gbar + 2 / np.pi) / (1 - r)  # that four units of time with a growth of Z' by (2.11) keep up
    assert r * fastest * t + (1 + gbar) * t**2 / 2 == pytest.approx(d)


@pytest.mark.parametrize(("walls", "periods"), [(BBT, 1), (BTT, 1), pytest.param(BBT, 2, marks=pytest.mark.slow)])
def test_no_cell_with_a_motion_is_left_out(walls: tuple[int, ...], periods: int):
    word, r = Word(walls, periods), 0.6
    flights = random_flights(periods, periods, 4000)
    candidates = candidates_above(word, flights, r)
    rows = np.flatnonzero(candidates.admissible & (candidates.gbar > 0.02) & (candidates.gbar < 1) & (candidates.d < 2))
    for i in rows[np.argsort(candidates.gap[rows])[:3]]:  # next to grazing, where other motions of a cell are none
        d, gbar = float(candidates.d[i]), float(candidates.gbar[i])
        levels = (Level(Held.GBAR, gbar), d), (Level(Held.RATIO, d / gbar), d), (Level(Held.D, d), gbar)
        for level, coordinate in levels:
            [cells] = Exclusion(Model(level, r), 0.95 * coordinate, 1.05 * coordinate, (word,)).cells()
            own = flights[:, [i]]
            assert ((cells.corner <= own) & (own <= cells.corner + cells.side)).all(axis=0).any()
            assert 0 < cells.share < 0.001


ONE_SIDED = """\
schema_version: 1
device: {{capsule_mass_kg: 0.1245, restitution: {r}, length_m: 1.5}}
excitation: {{amplitude_n: 5, frequency_hz: 2}}
inclination_deg: {inclination}
sweep: {{parameter: {swept}}}
"""


@pytest.mark.parametrize("r", [0.3, 0.8])
@pytest.mark.parametrize("periods", [1, 2, 4])
def test_motions_with_four_impacts_on_the_bottom_solve_the_conditions(periods: int, r: float):
    word, flights = Word((1, 1, 1, 1), periods), random_flights(5, periods, 400, 4)
    moved, settled = onto_sweep(word, flights, Model(Level(Held.D, 1.0), r), 0.2 * periods)
    assert moved.excess.shape == (2, settled.shape[1])
    rows = np.flatnonzero((moved.gbar < 2) & (np.diff(moved.velocity, axis=0) != 0).any(axis=0))
    assert len(rows) > 10
    for i in rows:
        x = [*moved.velocity[:, i], *moved.time[:, i], moved.gbar[i]]
        assert max(map(abs, residuals(word, x, Model(Level(Held.D, 1.0), r)))) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("swept", "r", "inclination", "most"),
    [
        ("length_m, from: 0.2, to: 3", 0.8, 15, 2),
        ("amplitude_n, from: 2, to: 9", 0.75, 10, 2),
        ("inclination_deg, from: 5, to: 90", 0.3, 45, 2),
        ("amplitude_n, from: 1.5, to: 6", 0.4, 90, 4),
    ],
)
def test_newtons_method_finds_no_other_motion_on_one_membrane(swept: str, r: float, inclination: int, most: int):
    sweep = sweep_of(loads(ONE_SIDED.format(swept=swept, r=r, inclination=inclination)).scenario)
    low, high = map(float, sweep.coordinate_range)
    model, rng, counts = Model(sweep.level, r), np.random.default_rng(5), Counter[str]()
    families = atlas(sweep, Limits(4, 3)).families
    for word, periods, _ in product(("B", "BB", "BBB", "BBBB", "T", "TT"), (1, 2, 3), range(30)):
        curve, count = Curve(Word.of(word, periods), model, low, high, high - low), len(word)
        coordinate = rng.uniform(low, high)
        largest = 6 * periods * model.groups(coordinate)[1] / (1 + r) / count * curve.word.walls[0]
        time = rng.uniform(0, 2) + np.sort(rng.uniform(0, 2 * periods, count))
        x = curve.nearest(np.array([*largest * rng.random(count), *time, coordinate]))
        motion = None if x is None or not curve.admits(x) else curve.motion(x)
        if motion is None or motion.primitive() is not motion:
            continue
        if (np.diff(motion.time, append=motion.time[0] + 2 * periods) > 0).all():
            alike = [known for f in families if f.word == motion.word for known in f.at(motion.coordinate)]
            assert min(map(motion.distance, alike)) < 1e-8
            counts[word] += 1
    assert {"B", "BB", most * "B"} <= set(counts) <= {"B", "BB", "BBB", "BBBB"}


@pytest.mark.slow
@pytest.mark.parametrize(("low", "high"), [(2.1, 2.2), (2.2, 2.7)])
def test_every_attractor_of_an_upright_capsule_lies_on_a_family(low: float, high: float):
    swept = f"amplitude_n, from: {low}, to: {high}"
    sweep = sweep_of(loads(ONE_SIDED.format(swept=swept, r=0.4, inclination=90)).scenario)
    values, words = np.linspace(low, high, 41), set()
    d, gbar = (np.broadcast_to(x, 41).astype(float) for x in sweep.device.groups(sweep.parameter, values)[:2])
    ends = attractors(Groups(d, gbar, 0.4), random_starts(d, start_speed(0.4, [0.0] * 41), 8, 20190301))
    families = atlas(sweep, Limits(4, 4)).families
    for value, end in ((value, end) for value, row in zip(values, ends, strict=True) for end in row):
        if end.cycle is not None and not end.cycle.sticks and len(end.cycle.wall) <= 4 and end.cycle.period <= 4:
            motion = end.cycle.motion(float(sweep.coordinate_of(value)))
            assert min(motion.distance(known) for f in families for known in f.at(motion.coordinate)) < 1e-10
            words.add(motion.word.letters)
    assert {"BB", "BBBB"} <= words


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("walls", [BBT, BTT])
def test_every_motion_with_three_impacts_lies_on_a_family(walls: tuple[int, ...], seed: int, example):
    """Random ones, most of them unstable and on families that join no other, each with a sweep that passes it."""
    sweep = sweep_of(load(example("inclined")).scenario)
    periods = 1 + seed % 3
    candidates = candidates_above(Word(walls, periods), random_flights(seed, periods, 4000), sweep.device.restitution)
    rows = np.flatnonzero(
        candidates.admissible
        & (candidates.gbar > 0.02)
        & (candidates.gbar < 0.9 * unit_gbar(sweep))
        & (candidates.d < 2)
    )
    i = int(rows[0])
    device = replace(sweep.device, inclination_deg=float(np.degrees(np.arcsin(candidates.gbar[i] / unit_gbar(sweep)))))
    middle = float(candidates.d[i] / sweep.device.groups(sweep.parameter, 1.0)[0])
    passing = replace(sweep, device=device, start=0.99 * middle, end=1.01 * middle)
    motion = candidates.motion(i, passing.level)
    found_atlas = atlas(passing, Limits(3, periods))
    near = [motion.distance(m) for family in found_atlas.families for m in family.at(motion.coordinate)]
    assert min(near) < 1e-8
    (claim,) = [of for of in found_atlas.completeness if of.word == motion.word.canonical().letters]
    assert claim.claim is Claim.COMPLETE
    assert claim.undecided is not None
    assert claim.undecided < 1e-4


def unit_gbar(sweep) -> float:
    """What gbar would be at 90 degrees."""
    return float(replace(sweep.device, inclination_deg=90.0).groups(sweep.parameter, sweep.start)[1])


@pytest.mark.slow
@pytest.mark.parametrize("periods", [3, 4])
def test_the_search_for_four_impacts_finds_a_family_that_joins_no_other(periods: int, example):
    sweep = sweep_of(load(example("inclined")).scenario)
    low, high = map(float, sweep.coordinate_range)
    model = Model(sweep.level, float(sweep.device.restitution))
    motions, flights = four_impacts(model, low, high, Word((1, 1, 1, -1), periods))
    assert motions.admissible.all()
    for i in range(0, len(motions.d), 5):
        x = [*motions.velocity[:, i], *motions.time[:, i], motions.d[i]]
        assert max(map(abs, residuals(motions.word, x, model))) < 1e-7
    assert np.ptp(flights, axis=1).max() > 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "word", "fold"),
    [("horizontal", Word.of("BTBT", 3), 0.708135), ("inclined-forcing", Word.of("BBBT", 4), 3.239618)],
)
def test_families_within_few_cells_are_found(name: str, word: Word, fold: float, example):
    swept_atlas = atlas(sweep_of(load(example(name)).scenario), Limits(4, word.periods))
    families = [family for family in swept_atlas.families if family.word == word]
    ends = [end for family in families for end in (family.sweep_value.min(), family.sweep_value.max())]
    assert min(abs(end - fold) for end in ends) < 1e-6


UPRIGHT = """\
schema_version: 1
device: {capsule_mass_kg: 0.125, restitution: 0.565, length_m: 0.02}
excitation: {amplitude_n: 5.75, frequency_hz: 8.6}
inclination_deg: 90
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("swept", "value"),
    [
        ("frequency_hz, from: 7.5, to: 8.9", 8.6),
        ("inclination_deg, from: 75, to: 90", 89.0),
        ("frequency_hz, from: 8.599, to: 8.601", 8.6),
    ],
)
def test_a_family_is_found_that_joins_no_other(swept: str, value: float):
    """The simulation ends on it; the factor of the solutions changes its sign beside it, or it is within one cell."""
    sweep = sweep_of(loads(UPRIGHT + f"sweep: {{parameter: {swept}}}\n").scenario)
    d, gbar, *_ = sweep.device.groups(sweep.parameter, value).as_floats()
    cycle = find_attractor(Groups(d, gbar, float(sweep.device.restitution)), Impact(1, 0.375, 5.66)).cycle
    assert cycle is not None
    assert cycle.word == "BBBT"
    motion = cycle.motion(float(sweep.coordinate_of(value)))
    assert min(motion.distance(other) for _, other in atlas(sweep, Limits(4, 1)).stable_at(value)) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inclined-forcing", "horizontal"])
def test_what_is_claimed_of_each_word_is_said(name: str, example):
    sweep = replace(sweep_of(load(example(name)).scenario), end=3.3 if name == "inclined-forcing" else 0.5)
    claims = {of.word: of for of in atlas(sweep, Limits(4, 1)).completeness}
    mirror = sweep.level.horizontal
    both = {"BT", "BBT", "BBBT", "BBTT", "BTBT"} | (set() if mirror else {"BTT", "BTTT"})
    assert set(claims) == both | {"B", "BB", "BBB", "BBBB"} | (set() if mirror else {"T", "TT", "TTT", "TTTT"})
    assert all(of.claim is Claim.COMPLETE for word, of in claims.items() if word in both and len(word) < 4)
    assert all(of.claim is Claim.COMPLETE for word, of in claims.items() if word not in both)
    assert (claims["BBB"].undecided is None) == (claims["BBBB"].undecided is None) == mirror  # where there is none
    assert claims["BBTT"].claim is Claim.SEARCHED
    assert 0 < claims["BBT"].resolution < claims["BBTT"].resolution < 0.1
    assert claims["BBT"].undecided < 1e-4
