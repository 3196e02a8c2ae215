"""The least kicks that lead out of a motion: they do, less does not, and how they vanish where the motion ends."""

from __future__ import annotations

from itertools import pairwise
from math import log

import numpy as np
import pytest
from msgspec.structs import replace

from tests.findings.escape.test_lifetimes import UNLIKE, cores_of
from tests.findings.outcomes.devices import Case, case, of
from vireport.findings.escape import escape
from vireport.findings.escape import least_kicks as module
from vireport.findings.escape.least_kicks import (
    KickedPath,
    impact_rows,
    kicked,
    kicks_along,
    least_kicks,
    leaving,
)
from vireport.findings.outcomes.shock import MotionsByStability
from vireport.findings.outcomes.withstood import least_of
from vireport.physics.forcing import Harmonic
from vireport.simulation.events import check_model, follow_impacts
from vireport.simulation.kernel import PHASE, VELOCITY, WALL

pytest.importorskip("numba")

HARMONIC = case(force=2.2, harmonics=(Harmonic.of(2, 2.0, 30.0), Harmonic.of(3, 2.0, 225.0)))


def exponent_of(device: Case, which: int = 0) -> float:
    way = least_kicks(device.groups, cores_of(device, which))
    assert way is not None
    assert way.path.exponent <= way.shock**2 / 2
    return way.path.exponent


def driven(device: Case, path: KickedPath, kicks: np.ndarray) -> np.ndarray:
    """The impacts (n, 4) at the ends of sequences of kicks (n, m) after those of a path."""
    motion, model = device.stable[0], check_model(device.groups)
    first = next(i for i, wall in enumerate(motion.word.walls) if wall == path.walls[0])
    count = len(kicks)
    states = np.repeat(impact_rows(path.walls[0], motion.phase[[first]], motion.velocity[[first]]), count, axis=0)
    for column in kicks.T:
        rows, _ = follow_impacts(np.repeat(model, count, axis=0), states, 1, 1)
        last = rows[:, 0]
        states = impact_rows(
            last[:, WALL], last[:, PHASE], kicked(device.groups, last[:, WALL], last[:, VELOCITY], column)
        )
    return states


@pytest.mark.parametrize(
    "device", [case(force=3.0, length=1.3), case(force=3.0, length=0.3, inclination=0.0), HARMONIC]
)
def test_a_little_more_than_the_least_kicks_leads_out_and_a_little_less_does_not(device: Case) -> None:
    cores = cores_of(device)
    path = least_kicks(device.groups, cores).path
    scaled = np.array([[0.9], [0.98], [1.02], [1.1]]) * path.kicks
    # Beyond the least kicks some of the larger ones come back, as bands are folded there: the first do not.
    assert leaving(device.groups, driven(device, path, scaled), cores).tolist()[:3] == [False, False, True]


def test_no_kicks_with_a_smaller_sum_of_squares_lead_out() -> None:
    device = case()
    cores = cores_of(device)
    path = least_kicks(device.groups, cores).path
    random = np.random.default_rng(11)
    near = path.kicks + 0.3 * np.abs(path.kicks).max() * random.standard_normal((3000, len(path.kicks))) * (
        np.abs(path.kicks) > 0.02 * np.abs(path.kicks).max()
    ) * random.random((3000, 1))
    kicks = 0.995 * near * np.sqrt(path.kicks @ path.kicks / (near**2).sum(axis=1))[:, None]
    assert not leaving(device.groups, driven(device, path, kicks), cores).any()


def test_it_is_at_most_half_the_square_of_the_least_shock_after_an_impact() -> None:
    device = case()
    shock = least_of(device.groups, MotionsByStability(device.stable, device.unstable))
    assert shock.delay == 0
    way = least_kicks(device.groups, cores_of(device))
    assert way.shock == pytest.approx(shock.jump, rel=1e-5)  # among folded bands
    assert way.path.exponent == pytest.approx(0.0035456, rel=1e-4)


@pytest.mark.parametrize("device", [case(), HARMONIC, of(UNLIKE)])
def test_kicks_along_a_motion_are_none(device: Case) -> None:
    motion = device.stable[0].times(3)
    walls = np.array(motion.word.walls)
    assert np.abs(kicks_along(device.groups, walls, motion.time)).max() < 1e-12
    # A kick more, and the next impact is sooner by the duration over the velocity there.
    later = motion.time.copy()
    later[2] += 1e-6
    first = kicks_along(device.groups, walls, later)[0]
    assert first == pytest.approx(-1e-6 * motion.velocity[2] / motion.durations[1], rel=1e-4)


def powers(values: list[float]) -> list[float]:
    """The local exponents of values at distances that are halved from one to the next."""
    return [log(a / b) / log(2) for a, b in pairwise(values)]


@pytest.mark.slow
def test_it_vanishes_at_a_fold_with_the_distance_to_the_power_of_three_halves() -> None:
    fold = 0.37487717091730804  # C1 of 1 degree and 3 N, where a stable and an unstable motion meet
    distances = (0.002, 0.001, 0.0005)
    values = [exponent_of(case(force=3.0, length=fold - away, inclination=1.0), 1) for away in distances]
    assert powers(values) == pytest.approx([1.5, 1.5], abs=0.02)


@pytest.mark.slow
def test_it_vanishes_at_a_pitchfork_with_the_square_of_the_distance() -> None:
    scale = case(force=3.0, length=1.0, inclination=0.0).groups.d
    distances = (0.01, 0.005)
    values = [exponent_of(case(force=3.0, length=(0.2634315843 - away) / scale, inclination=0.0)) for away in distances]
    assert powers(values) == pytest.approx([2.0], abs=0.01)


@pytest.mark.slow
def test_at_b1_it_does_not_vanish_faster_than_linearly() -> None:
    """The period doubling B1 is supercritical: the edge of the basin stays where it is, and Q tends to a line."""
    scale = case(force=3.0, length=1.0, inclination=0.0).groups.d
    distances = np.array([0.0025, 0.00125, 0.000625])
    devices = [case(force=3.0, length=(0.1870532313 + away) / scale, inclination=0.0) for away in distances]
    values = [exponent_of(device) for device in devices]
    first, second = powers(values)
    assert 1.0 < second < first < 1.5
    # What is left of Q at B1 itself, by the parabola through the three.
    assert 0 < np.polyfit(distances, values, 2)[-1] < values[-1] / 2
    shocks = [least_kicks(device.groups, cores_of(device)).shock for device in devices]
    assert shocks[-1] > 0.7 * shocks[0]


@pytest.mark.parametrize("confirmed", [False, True])
def test_no_law_is_claimed_of_a_sequence_that_is_not_confirmed_or_takes_more_than_one_kick(
    confirmed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Q would be too large, and the motion said to last too long."""
    device = case(force=3.0, length=1.3)
    if confirmed:
        found = module._settled
        monkeypatch.setattr(
            module, "_settled", lambda *at: (path := found(*at)) and replace(path, kicks=10 * path.kicks)
        )
    else:
        monkeypatch.setattr(module, "_is_flown", lambda *_: False)
    way = least_kicks(device.groups, cores_of(device))
    assert way.path is None
    assert way.shock > 0
    monkeypatch.setattr(escape, "BUDGET", 20_000)
    motions = MotionsByStability(device.stable, device.unstable)
    lasting = escape.escape_from(device.groups, device.stable[0], motions, way.shock / 100)
    assert (lasting.law, lasting.periods, lasting.reason) == (None, None, escape.Unlimited.TOO_LONG)
    assert lasting.interval[0] > 0
    assert escape.exponent_of(device.groups, device.stable[0], motions) is None
