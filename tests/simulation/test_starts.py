"""Starts in flight: spread over the states they are said to cover, each value's own, the same in every run."""

from __future__ import annotations

from math import comb, pi

import numpy as np
import pytest

from vireport.base.shares import share_interval
from vireport.physics.groups import Groups
from vireport.simulation.attractors import attractors
from vireport.simulation.events import BOTTOM, Impact, InFlight, check_start, start_of
from vireport.simulation.starts import even_starts, random_starts, start_speed


def test_starts_fill_the_states_evenly() -> None:
    """Of a uniform number the mean, the spread and the largest of 20,000 are known to about a hundredth."""
    d, speed = np.array([0.3, 5.0]), np.array([2.0, 7.0])
    for k, rows in enumerate(random_starts(d, speed, 20_000, seed=1)):
        wall, position, velocity, phase = rows.T
        assert not wall.any()
        for values, low, high in ((position, -d[k] / 2, d[k] / 2), (velocity, -speed[k], speed[k]), (phase, 0, 2 * pi)):
            shares = (values - low) / (high - low)
            assert np.abs(np.histogram(shares, 10, (0, 1))[0] / 2000 - 1).max() < 0.1
            assert (shares.min(), shares.max()) == pytest.approx((0, 1), abs=1e-3)
        assert np.abs(np.corrcoef(rows[:, 1:].T) - np.eye(3)).max() < 0.03


def test_a_few_even_starts_fill_the_states_better_than_random_ones() -> None:
    """By the largest difference between the share of a box at a corner that they fill and its volume."""
    shares = even_starts(0.3, 2.0, 64)[:, 1:] / (0.3, 4.0, 2 * pi) + (0.5, 0.5, 0.0)
    assert (shares.min(), shares.max()) == pytest.approx((0, 1), abs=0.05)
    corners = np.random.default_rng(1).random((2000, 3))

    def off(shares: np.ndarray) -> float:
        inside = (shares[:, None] < corners).all(axis=-1).mean(axis=0)
        return float(np.abs(inside - corners.prod(axis=1)).max())

    random = min(off(np.random.default_rng(seed).random((64, 3))) for seed in range(20))
    assert off(shares) < 0.9 * random
    np.testing.assert_array_equal(even_starts(0.3, 2.0, 64)[:6], even_starts(0.3, 2.0, 6))


def test_each_value_has_starts_of_its_own_and_every_run_the_same() -> None:
    left, right = random_starts([0.4, 0.4], 2.0, 8, seed=3)
    assert not np.isclose(left, right).any(axis=0)[1:].any()
    np.testing.assert_array_equal(random_starts([0.4, 0.4], 2.0, 8, seed=3), [left, right])
    assert not np.isclose(random_starts([0.4], 2.0, 8, seed=4)[0], left)[:, 1:].any()


def test_starts_reach_beyond_what_the_forcing_sustains_and_beyond_the_fastest_motion() -> None:
    """(3.9) for q = 1/2 without gravity: (1-r) Z' = 2 sin(phi)/pi."""
    assert start_speed(0.5) == pytest.approx(1.5 * 4 / pi)
    assert start_speed(0.5, [1.0, 3.0]) == pytest.approx([1.5 * 4 / pi, 4.5])
    assert start_speed(0.95) == start_speed(0.9999) == pytest.approx(1.5 * 20 / pi)


def test_rows_are_starts() -> None:
    for start in (InFlight(0.1, -0.3, 2.0), Impact(BOTTOM, 0.7, 1.0)):
        assert start_of(np.array(check_start(start, 0.4))) == start


def test_own_starts_of_each_parameter_are_simulated_at_it() -> None:
    d, gbar = np.array([0.25, 0.45]), 0.28
    starts = random_starts(d, 2.0, 3, seed=5)
    together = attractors(Groups(d, gbar, 0.5), starts, 500)
    for k in range(2):
        alone = attractors(Groups(d[k], gbar, 0.5), [start_of(row) for row in starts[k]], 500)[0]
        assert [a.word for a in together[k]] == [a.word for a in alone]
        assert [a.impacts for a in together[k]] == [a.impacts for a in alone]
    with pytest.raises(ValueError, match="starts for 2 parameters, of which there are 3"):
        attractors(Groups([0.2, 0.3, 0.4], gbar, 0.5), starts)


def test_share_interval() -> None:
    assert share_interval(0, 10)[:2] == (0.0, 0.0)
    assert share_interval(10, 10)[2] == 1.0
    # 8 of 10 (Clopper and Pearson 1934): 0.4439 to 0.9748.
    share, low, high = share_interval(8, 10)
    assert share == 0.8
    assert low == pytest.approx(0.4439, abs=5e-5)
    assert high == pytest.approx(0.9748, abs=5e-5)


@pytest.mark.parametrize("p", [0.5, 0.9, 0.99, 0.9995])
def test_the_interval_covers_shares_near_100_percent(p: float) -> None:
    covered = 0.0
    for hits in range(257):
        _, low, high = share_interval(hits, 256)
        covered += comb(256, hits) * p**hits * (1 - p) ** (256 - hits) * (low <= p <= high)
    assert covered >= 0.95
