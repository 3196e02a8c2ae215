"""Turning points found for certain, against dense sampling of the flights."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import random_sweeps

from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.orbits import Orbits, orbits
from vireport.motions.turning import flight_turns, wall_gap
from vireport.physics import flight


def random_motions(seed: int, n: int, count: int = 4000) -> tuple[Orbits, float]:
    rng = np.random.default_rng(seed)
    r = rng.uniform(0.02, 0.98)
    o = orbits(rng.uniform(-0.49, 0.49, count), rng.uniform(0, 2 * np.pi, count), r, n)
    return o.select((o.velocity_bottom > 0) & (o.velocity_top < 0) & (o.d > 0) & (o.gbar >= 0)), r


def sampled_extremes(o: Orbits, r: float, i: int) -> list[float]:
    """Distances to the two walls at the turning points of both flights, from 40,000 samples of each."""
    gaps = []
    flights = (
        (o.time_up[i], -r * o.velocity_bottom[i], o.sin_phi[i], o.cos_phi[i], o.d[i] / 2),
        (o.time_down[i], -r * o.velocity_top[i], o.sin_top[i], o.cos_top[i], -o.d[i] / 2),
    )
    for duration, velocity, sine, cosine, start in flights:
        t = np.linspace(0, duration, 40_001)
        phase = np.arctan2(sine, cosine) + np.pi * t
        z = start + flight.displacement(t, velocity, sine, cosine, np.cos(phase), o.gbar[i])
        v = flight.velocity(t, velocity, sine, np.sin(phase), o.gbar[i])
        for k in np.nonzero(v[1:] * v[:-1] < 0)[0]:
            gaps += [o.d[i] / 2 - z[k], z[k] + o.d[i] / 2]
    return gaps


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_gap_against_dense_sampling(seed: int, n: int) -> None:
    o, r = random_motions(seed, n)
    gap = wall_gap(o, r)
    rows = np.concatenate([np.nonzero(gap < o.d)[0][:12], np.nonzero(gap == o.d)[0][:12]])
    assert len(rows) >= 12
    for i in rows:
        expected = min([o.d[i], *sampled_extremes(o, r, i)])
        assert gap[i] == pytest.approx(expected, abs=1e-6 * (1 + o.d[i]))


@pytest.mark.parametrize("n", [1, 2])
def test_turning_points_are_at_rest_and_inside_their_flight(n: int) -> None:
    o, r = random_motions(11, n)
    count = 0
    for impact, turn in flight_turns(o, o.flights(r)):
        k, upward = turn.index, impact == 0
        before = o.velocity_bottom[k] if upward else o.velocity_top[k]
        sine, cosine = (o.sin_phi[k], o.cos_phi[k]) if upward else (o.sin_top[k], o.cos_top[k])
        later = np.arctan2(sine, cosine) + np.pi * turn.time
        v = flight.velocity(turn.time, -r * before, sine, np.sin(later), o.gbar[k])
        # Newton's last step is at most 1e-10 there: the position, which is what counts, depends on its square.
        assert np.all(np.abs(v) < 1e-10 * np.maximum(turn.time, 1.0) * (1 + o.gbar[k]))
        assert np.all((turn.time >= 0) & (turn.time <= (o.time_up[k] if upward else o.time_down[k])))
        np.testing.assert_allclose(turn.covered + turn.room, o.d[k])
        count += len(k)
    assert count > 100


def test_without_restitution_a_ball_that_is_pressed_on_is_not_admissible() -> None:
    """For r = 0 it leaves an impact at rest, and where it is pressed outwards it would fall through."""
    rng = np.random.default_rng(5)
    o = orbits(rng.uniform(-0.45, 0.45, 3000), rng.uniform(0, 2 * np.pi, 3000), 0.0, 1)
    o = o.select((o.velocity_bottom > 1e-3) & (o.velocity_top < -1e-3) & (o.d > 0) & (o.gbar >= 0))
    pressed = (o.gbar + o.cos_phi > 1e-3) | (o.gbar + o.cos_top < -1e-3)
    assert pressed.sum() > 20
    assert np.all(wall_gap(o, 0.0)[pressed] <= 0)


def test_a_motion_that_touches_a_membrane_is_none_and_one_that_comes_to_rest_on_it_has_a_gap() -> None:
    kinds = set()
    for sweep in random_sweeps(8, seed=77):
        for branch in solve(sweep).branches:
            for row in range(len(branch.motions)):
                point = branch.family.critical_points.get(row)
                if point is not None and point.event is Event.GRAZING:
                    kinds.add(point.rest is not None)
                    assert (branch.motions.wall_gap[row] > 0) == (point.rest is not None)
                    assert not branch.motions.admissible_mask[row] or point.rest is not None
    assert kinds == {False, True}
