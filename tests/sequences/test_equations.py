"""The conditions of motions with any sequence of impacts, against differences, the simulation and 40 digits."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from vireport import load
from vireport.analysis import Held, Level, solve
from vireport.scenario import Parameter
from vireport.sequences import (
    Limits,
    Model,
    Motion,
    Sequence,
    atlas,
    linearised,
    motion_of_cycle,
    residuals,
    trace,
    turns,
)
from vireport.sequences.surface import three_impacts
from vireport.simulation import Impact, find_attractor, simulate
from vireport.study.study import sweep_of

WORDS = "B", "BT", "BBT", "BTT", "BBTT", "BBTBT"
LEVELS = Level(Held.GBAR, 0.2), Level(Held.RATIO, 1.7), Level(Held.D, 0.4)
SIMULATED = {"BT": (0.46, 0.2876, 0.5), "BTBT": (0.405, 0.2876, 0.5), "BBT": (0.187, 0.122, 0.5)}
"""Words with d, gbar and r at which there is a stable motion."""


def walls(word: str) -> tuple[int, ...]:
    return tuple(1 if letter == "B" else -1 for letter in word)


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("level", LEVELS)
def test_derivatives_are_those_of_the_conditions(word: str, level: Level):
    rng, sequence = np.random.default_rng(len(word)), Sequence(walls(word), 2)
    count = len(word)
    x = np.concatenate([rng.uniform(0.2, 1, count), np.sort(rng.uniform(0, 4, count)), [0.3]])
    model = Model(level, 0.6)
    values, matrix = linearised(sequence, x, model)
    np.testing.assert_allclose(values, residuals(sequence, x.tolist(), model), atol=1e-14)
    step = 1e-5
    for i, unit in enumerate(np.eye(len(x)) * step):
        ahead, behind = (np.array(residuals(sequence, (x + way * unit).tolist(), model)) for way in (1, -1))
        np.testing.assert_allclose(matrix[:, i], (ahead - behind) / (2 * step), atol=1e-8)


@cache
def simulated(word: str) -> Motion:
    """A stable motion, found by simulation."""
    d, gbar, r = SIMULATED[word]
    starts = (Impact(1, velocity, phase) for velocity in (0.5, 0.8, 0.9, 0.3) for phase in np.linspace(0, 6, 13))
    ends = (find_attractor(d, gbar, r, start, 5_000).cycle for start in starts)
    return motion_of_cycle(next(cycle for cycle in ends if cycle is not None and cycle.word == word), d)


@pytest.mark.parametrize("word", SIMULATED)
def test_simulated_motions_solve_the_conditions(word: str):
    motion, (d, gbar, r) = simulated(word), SIMULATED[word]
    x = [*motion.velocity, *motion.time, d]
    assert max(map(abs, residuals(motion.sequence, x, Model(Level(Held.GBAR, gbar), r)))) < 1e-13
    assert motion.sequence.word == word
    assert all(turn.gap > 0 for turn in turns(motion, d, gbar, r))


@pytest.mark.parametrize("word", SIMULATED)
def test_multipliers_are_those_of_the_simulated_return_map(word: str):
    motion, (d, gbar, r) = simulated(word), SIMULATED[word]
    step, count, wall = 1e-6, len(word), motion.sequence.walls[0]
    columns = []
    for unit in np.eye(2) * step:
        ends = []
        for way in (1, -1):
            velocity, phase = float(motion.velocity[0] + way * unit[0]), float(motion.phase[0] + way * unit[1])
            path = simulate(d, gbar, r, Impact(wall, velocity, phase), count)
            ends.append(np.array([path.velocity[-1], path.phase[-1]]))
        columns.append((ends[0] - ends[1]) / (2 * step))
    matrix, x = np.stack(columns, axis=1), [*motion.velocity, *motion.time, d]
    found = trace(motion.sequence, x, Model(Level(Held.GBAR, gbar), r))
    assert found == pytest.approx(np.trace(matrix), rel=1e-6)
    assert np.linalg.det(matrix) == pytest.approx(r ** (2 * count), rel=1e-4)


def test_turning_points_tell_motions_from_solutions_that_pass_through_a_membrane(example):
    sweep = replace(sweep_of(load(example("inclined")).scenario), start=0.06)
    decided, gbar = [], float(sweep.level.value)
    for branch in solve(sweep).branches:
        m = branch.motions
        for row in range(1, len(m) - 1, 5):
            time = m.phi_bottom[row] / np.pi + np.array([0, 2 * m.q[row]])
            velocity = np.array([m.velocity_bottom[row], m.velocity_top[row]])
            motion = Motion(Sequence((1, -1), 1), velocity, time, float(m.d[row]))
            gaps = [turn.gap for turn in turns(motion, float(m.d[row]), gbar, m.restitution)]
            assert all(gap > 0 for gap in gaps) == m.admissible[row]
            decided.append(bool(m.admissible[row]))
    assert {True, False} == set(decided)


def test_a_motion_is_the_same_from_whichever_impact_it_is_counted():
    sequence = Sequence(walls("BBTBT"), 3)
    rng = np.random.default_rng(1)
    motion = Motion(sequence, rng.uniform(0.1, 1, 5) * sequence.walls, np.sort(rng.uniform(0, 6, 5)), 0.3)
    for i in range(5):
        assert motion.distance(motion.rotated(i)) < 1e-14
        assert motion.canonical().apart(motion.rotated(i).canonical()) < 1e-14
    assert motion.distance(motion.mirrored()) == np.inf
    assert motion.distance(motion.mirrored(), mirror=True) < 1e-14
    assert motion.times(3).primitive().apart(motion) < 1e-14
    assert motion.primitive() is motion


def test_the_search_for_three_impacts_comes_close_to_a_simulated_motion():
    motion, (d, gbar, r) = simulated("BBT"), SIMULATED["BBT"]
    model = Model(Level(Held.GBAR, gbar), r)
    starts = three_impacts(model, motion.sequence, 0.95 * d, 1.05 * d)
    nearest = min(starts, key=motion.apart)
    assert motion.apart(nearest) < 0.1
    assert nearest.coordinate == pytest.approx(d, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["inclined", "horizontal", "inclined-forcing"])
def test_motions_are_those_of_the_printed_maps_in_40_digits(name: str, example):
    from vireport import reference
    from vireport.reference import mp, mpf

    sweep = sweep_of(load(example(name)).scenario)
    if sweep.parameter is Parameter.LENGTH:
        sweep = replace(sweep, start=0.7 * sweep.start)
    families = [family for family in atlas(sweep, Limits(6, 4)).families if len(family.sequence) > 2]
    rng = np.random.default_rng(3)
    for _ in range(25):
        family = families[rng.integers(len(families))]
        row = int(rng.integers(1, len(family.x) - 1))
        sequence, count = family.sequence, len(family.sequence)
        with reference.precise():
            d, gbar = reference.groups(sweep.device, sweep.parameter, mpf(float(family.sweep_value[row])))
            r = mpf(sweep.device.restitution)

            def maps(x, d=d, gbar=gbar, r=r, sequence=sequence, count=count):
                values = []
                for i, wall in enumerate(sequence.walls):
                    j = (i + 1) % count
                    duration = x[count + j] - x[count + i] + (0 if j else 2 * sequence.periods)
                    z, speed = reference.flight(duration, wall * d / 2, -r * x[i], mp.pi * x[count + i], gbar)
                    values += [z - sequence.walls[j] * d / 2, speed - x[j]]
                return values

            exact = reference.newton(maps, [mpf(float(value)) for value in family.x[row, :-1]], [1] * (2 * count))
            error = max(float(abs(a - float(b))) for a, b in zip(exact, family.x[row, :-1], strict=True))
        # The nearer to a fold or pitchfork, the farther a residual of rounding moves the motion.
        assert error * min(1.0, abs(1 + float(r) ** (2 * count) - family.trace[row])) < 1e-13
