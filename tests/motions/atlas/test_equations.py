"""The conditions of motions with any sequence of impacts, against differences, the simulation and 40 digits."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from exact import printed_maps, printed_trace
from mpmath import mp, mpf
from msgspec.structs import replace

from vireport import load, loads
from vireport.motions.atlas.families import atlas
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.periodicity import Model, linearised, residuals, trace
from vireport.motions.sweep import Held, Level
from vireport.motions.switching import Limits
from vireport.motions.turning import turns
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import Impact, check_model, check_start, follow_one
from vireport.simulation.kernel import PHASE, VELOCITY
from vireport.study.checks import reference
from vireport.study.study import sweep_of

WORDS = "B", "BT", "BBT", "BTT", "BBTT", "BBTBT"
LEVELS = Level(Held.GBAR, 0.2), Level(Held.RATIO, 1.7), Level(Held.D, 0.4)
ROUNDINGS = 10
"""Units of rounding in the conditions of a motion."""

SIMULATED = {"BT": (0.46, 0.2876, 0.5), "BTBT": (0.405, 0.2876, 0.5), "BBT": (0.187, 0.122, 0.5)}
"""Words with d, gbar and r at which there is a stable motion."""


def walls(word: str) -> tuple[int, ...]:
    return tuple(1 if letter == "B" else -1 for letter in word)


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("level", LEVELS)
def test_derivatives_are_those_of_the_conditions(word: str, level: Level):
    rng, word = np.random.default_rng(len(word)), Word(walls(word), 2)
    count = len(word)
    x = np.concatenate([rng.uniform(0.2, 1, count), np.sort(rng.uniform(0, 4, count)), [0.3]])
    model = Model(level, 0.6)
    values, matrix = linearised(word, x, model)
    np.testing.assert_allclose(values, residuals(word, x.tolist(), model), atol=1e-14)
    step = 1e-5
    for i, unit in enumerate(np.eye(len(x)) * step):
        ahead, behind = (np.array(residuals(word, (x + way * unit).tolist(), model)) for way in (1, -1))
        np.testing.assert_allclose(matrix[:, i], (ahead - behind) / (2 * step), atol=1e-8)


def test_a_word_stands_for_its_rotations_and_with_mirror_for_its_image():
    assert Word.of("TBT").canonical().letters == "BTT"
    assert Word.of("TBT").canonical(mirror=True).letters == "BBT"
    assert Word.of("BBT", 2).canonical(mirror=True) == Word((1, 1, -1), 2)


@cache
def simulated(word: str) -> Motion:
    """A stable motion, found by simulation."""
    d, gbar, r = SIMULATED[word]
    starts = (Impact(1, velocity, phase) for velocity in (0.5, 0.8, 0.9, 0.3) for phase in np.linspace(0, 6, 13))
    ends = (find_attractor(Groups(d, gbar, r), start, 5_000).cycle for start in starts)
    return next(cycle for cycle in ends if cycle is not None and cycle.word == word).motion(d)


@pytest.mark.parametrize("word", SIMULATED)
def test_simulated_motions_solve_the_conditions(word: str):
    motion, (d, gbar, r) = simulated(word), SIMULATED[word]
    x = [*motion.velocity, *motion.time, d]
    assert max(map(abs, residuals(motion.word, x, Model(Level(Held.GBAR, gbar), r)))) < 1e-13
    assert motion.word.letters == word
    assert all(turn.gap > 0 for turn in turns(motion, Groups(d, gbar, r)))


@pytest.mark.parametrize("word", SIMULATED)
def test_multipliers_are_those_of_the_simulated_return_map(word: str):
    motion, (d, gbar, r) = simulated(word), SIMULATED[word]
    step, count, wall = 1e-6, len(word), motion.word.walls[0]
    columns = []
    for unit in np.eye(2) * step:
        ends = []
        for way in (1, -1):
            velocity, phase = float(motion.velocity[0] + way * unit[0]), float(motion.phase[0] + way * unit[1])
            rows, _ = follow_one(
                check_model(Groups(d, gbar, r))[0], check_start(Impact(wall, velocity, phase), d), count
            )
            ends.append(rows[-1, [VELOCITY, PHASE]])
        columns.append((ends[0] - ends[1]) / (2 * step))
    matrix, x = np.stack(columns, axis=1), [*motion.velocity, *motion.time, d]
    value = trace(motion.word, x, Model(Level(Held.GBAR, gbar), r))
    assert value == pytest.approx(np.trace(matrix), rel=1e-6)
    assert np.linalg.det(matrix) == pytest.approx(r ** (2 * count), rel=1e-4)


def test_turning_points_tell_motions_from_solutions_that_pass_through_a_membrane(example):
    sweep = replace(sweep_of(load(example("inclined")).scenario), start=0.06)
    decided, gbar = [], float(sweep.level.value)
    for branch in solve(sweep).branches:
        m = branch.motions
        for row in range(1, len(m) - 1, 5):
            time = m.phi_bottom[row] / np.pi + np.array([0, 2 * m.q[row]])
            velocity = np.array([m.velocity_bottom[row], m.velocity_top[row]])
            motion = Motion(Word((1, -1), 1), velocity, time, float(m.d[row]))
            gaps = [turn.gap for turn in turns(motion, Groups(float(m.d[row]), gbar, m.restitution))]
            assert all(gap > 0 for gap in gaps) == m.admissible_mask[row]
            decided.append(bool(m.admissible_mask[row]))
    assert {True, False} == set(decided)


def test_a_motion_is_the_same_from_whichever_impact_it_is_counted():
    word = Word(walls("BBTBT"), 3)
    rng = np.random.default_rng(1)
    motion = Motion(word, rng.uniform(0.1, 1, 5) * word.walls, np.sort(rng.uniform(0, 6, 5)), 0.3)
    for i in range(5):
        assert motion.distance(motion.rotated(i)) < 1e-14
        assert motion.canonical().apart(motion.rotated(i).canonical()) < 1e-14
    assert motion.distance(motion.mirrored()) == np.inf
    assert motion.distance(motion.mirrored(), mirror=True) < 1e-14
    assert motion.times(3).primitive().apart(motion) < 1e-14
    assert motion.primitive() is motion


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inclined", "horizontal", "inclined-forcing"])
def test_points_are_those_of_the_printed_maps_to_the_last_digit(name: str, example):
    sweep, kinds = sweep_of(load(example(name)).scenario), set()
    swept_atlas = atlas(sweep, Limits(6, 4))
    marks = [mark for family in swept_atlas.families for mark in family.marks if mark.point is not None]
    assert all(mark.point.error_bound < 1e-14 for mark in marks)  # next to impacts of velocity zero too
    vertices = swept_atlas.vertices
    for vertex in vertices[:: 1 + len(vertices) // 6]:
        motion, event, r = vertex.motion, vertex.event, mpf(sweep.device.restitution)
        if event is Event.PITCHFORK:
            continue  # singular without its symmetry; that of the 1:1 motions is compared with theirs
        word, count = motion.word, len(motion.word)
        rest = int(np.argmin(np.abs(motion.velocity)))

        def conditions(x, word=word, event=event, rest=rest, r=r):
            d, gbar = reference.groups(sweep.device, sweep.parameter, x[-1])
            if event is Event.GRAZING:
                return [*printed_maps(word, x, d, gbar, r), x[rest]]
            border = (1 + r ** (2 * len(word))) * (-1 if event is Event.PERIOD_DOUBLING else 1)
            return [*printed_maps(word, x, d, gbar, r), printed_trace(word, x, d, gbar, r) - border]

        with reference.precise(), mp.workdps(150):  # differences of differences
            guess = [mpf(float(v)) for v in (*motion.velocity, *motion.time, vertex.sweep_value)]
            exact = reference.newton(conditions, guess, [1] * (2 * count + 1))
            assert abs(exact[-1] - guess[-1]) <= vertex.error_bound
            assert max(abs(a - b) for a, b in zip(exact, guess, strict=True)) < 1e-15 * max(1, 2 * word.periods)
        kinds.add(event)
    assert Event.GRAZING in kinds or Event.FOLD in kinds


UPRIGHT = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.4, length_m: 1.5}
excitation: {frequency_hz: 2}
inclination_deg: 90
sweep: {parameter: amplitude_n, from: 2.1, to: 2.7}
"""
"""Most of its motions are on the bottom only."""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inclined", "horizontal", "inclined-forcing", "upright"])
def test_motions_are_those_of_the_printed_maps_within_their_bounds(name: str, example):
    sweep = sweep_of((loads(UPRIGHT) if name == "upright" else load(example(name))).scenario)
    if sweep.parameter is Parameter.LENGTH:
        sweep = replace(sweep, start=0.7 * sweep.start)
    families = [family for family in atlas(sweep, Limits(6, 4)).families if len(family.word) > 2]
    rng, r = np.random.default_rng(3), mpf(sweep.device.restitution)
    for _ in range(12):
        family = families[rng.integers(len(families))]
        row = int(rng.integers(1, len(family.x) - 1))
        word, curve, x = family.word, family.curve, family.x[row]
        tangent = curve.tangent(x)
        tangent[-1] /= curve.high - curve.low

        def across(y, word=word, x=x, tangent=tangent):
            """The conditions, with the coordinate as an unknown beside the swept value, straight across the curve."""
            d, gbar = reference.groups(sweep.device, sweep.parameter, y[-1])
            coordinate = gbar if sweep.parameter is Parameter.INCLINATION else d
            away = [a - mpf(float(b)) for a, b in zip([*y[:-1], coordinate], x, strict=True)]
            along = sum(mpf(float(t)) * a for t, a in zip(tangent, away, strict=True))
            return [*printed_maps(word, y, d, gbar, r), along]

        with reference.precise():
            given = [mpf(float(value)) for value in (*x[:-1], family.sweep_value[row])]
            exact = reference.newton(across, given, [1] * len(given))
            error = np.array([float(abs(a - b)) for a, b in zip(exact, given, strict=True)])
        bounds = family.error_bounds
        phase = bounds["phase"][row] / np.pi
        limit = np.concatenate([bounds["velocity"][row], phase, bounds["sweep_value"][[row]]])
        assert (error <= limit).all()
        assert (limit < 1e-10).all()
