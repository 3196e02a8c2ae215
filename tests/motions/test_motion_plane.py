"""Motions of many devices under a force with harmonics: all of them, alike one by one, on both sides of folds."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import first

from vireport.motions.orbits import Dynamics, Friction, orbits_of
from vireport.motions.pointwise import find_motions
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions

FORCE = Harmonic.of(2, 5.0, 225.0), Harmonic.of(3, 4.0, 40.0)
STRONG = Harmonic.of(2, 40.0, 70.0), Harmonic.of(5, 30.0, 200.0)
TINY = (Harmonic(3, 1e-13, -1e-13),)


def random_groups(rng: np.random.Generator, count: int, n: int, parted: bool) -> Groups:
    """Devices of all kinds, some of them horizontal, some hardly inclined."""
    gbar = rng.uniform(0.0, 0.8, count)
    gbar[: count // 8] = 0.0
    gbar[count // 8 : count // 4] = 10.0 ** rng.uniform(-12, -3, count // 4 - count // 8)
    r = rng.uniform(0.0, 0.9, count)
    other = Restitutions(r, rng.uniform(0.0, 0.9, count)) if parted else r
    return Groups(rng.uniform(0.02, 1.0, count) * n, gbar, other)


def apart(u: np.ndarray, phi: np.ndarray, other_u: np.ndarray, other_phi: np.ndarray) -> float:
    """Largest distance of places, in q or in the phase."""
    turn = np.angle(np.exp(1j * (phi - other_phi)))
    return float(max(np.abs(u - other_u).max(initial=0.0), np.abs(turn).max(initial=0.0)))


@pytest.mark.parametrize(
    ("n", "parted"), first(2, [(1, False), (1, True), (2, False), (2, True), (3, True)], unpacked=True)
)
def test_motions_without_harmonics_to_speak_of_are_those_of_the_sine(n: int, parted: bool) -> None:
    """Which are found by another route: the phase eliminated, on a grid of q."""
    groups = random_groups(np.random.default_rng(4 + n), 40, n, parted)
    plain, other = find_motions(groups, n), find_motions(groups._replace(harmonics=TINY), n)
    np.testing.assert_array_equal(plain.cell, other.cell)
    assert len(plain.cell) > 20
    assert apart(plain.orbit.u, plain.orbit.phi, other.orbit.u, other.orbit.phi) < 1e-11
    np.testing.assert_allclose(other.trace, plain.trace, rtol=1e-9)
    np.testing.assert_allclose(other.wall_gap, plain.wall_gap, atol=1e-11)


@pytest.mark.parametrize("parted", first(1, [True, False]))
def test_each_device_has_alone_the_motions_that_it_has_among_others(parted: bool) -> None:
    groups = random_groups(np.random.default_rng(11), 24, 1, parted)._replace(harmonics=FORCE)
    together = find_motions(groups, 1)
    for k in range(24):
        r = groups.restitution
        own = Restitutions(r.bottom[[k]], r.top[[k]]) if parted else r[[k]]
        alone = find_motions(Groups(groups.d[[k]], groups.gbar[[k]], own, FORCE), 1)
        among = together.cell == k
        assert np.count_nonzero(among) == len(alone.cell)
        assert apart(together.orbit.u[among], together.orbit.phi[among], alone.orbit.u, alone.orbit.phi) < 1e-11


def rubbing(groups: Groups) -> Friction | None:
    return None if groups.friction is None else Friction(groups.friction)


def differences(u: np.ndarray, phi: np.ndarray, groups: Groups) -> np.ndarray:
    """Of gbar and d of the motion at places from those of a device."""
    at = orbits_of(Dynamics(groups.restitution, 1, groups.harmonics, rubbing(groups)), u, phi)
    return np.stack([at.gbar - groups.gbar[0], at.d - groups.d[0]])


def scanned(groups: Groups, side: int) -> list[np.ndarray]:
    """Motions of one device by Newton's method from every cell of a fine grid in which both functions change sign."""
    u, phi = np.linspace(-0.4999, 0.4999, side), np.linspace(0, 2 * np.pi, side)
    both = differences(*np.meshgrid(u, phi, indexing="ij"), groups)
    corners = np.stack([both[:, :-1, :-1], both[:, 1:, :-1], both[:, :-1, 1:], both[:, 1:, 1:]])
    crossed = ((corners.min(axis=0) <= 0) & (corners.max(axis=0) >= 0)).all(axis=0)
    found: list[np.ndarray] = []
    for i, k in np.argwhere(crossed):
        x = np.array([(u[i] + u[i + 1]) / 2, (phi[k] + phi[k + 1]) / 2])
        for _ in range(30):
            by = [differences(x[0] + 1e-30j * (j == 0), x[1] + 1e-30j * (j == 1), groups) for j in (0, 1)]
            step = np.linalg.solve(np.stack([own.imag for own in by], axis=1) / 1e-30, by[0].real)
            x = x - step
            if np.abs(step).max() < 1e-14 or not abs(x[0]) < 0.5:
                break
        own = orbits_of(Dynamics(groups.restitution, 1, groups.harmonics, rubbing(groups)), x[0], x[1])
        inside = abs(x[0]) < 0.5 and np.abs(step).max() < 1e-12
        new = all(apart(x[:1], x[1:], y[:1], y[1:]) > 1e-7 for y in found)
        if inside and new and own.velocity_bottom > 0 > own.velocity_top:
            found.append(x)
    return found


@pytest.mark.parametrize("seed", first(1, range(6)))
def test_a_scan_of_the_plane_finds_the_same_motions(seed: int) -> None:
    rng, seen = np.random.default_rng(seed), 0
    for friction in (None, 0.35, None):
        r = Restitutions(float(rng.uniform(0.2, 0.8)), float(rng.uniform(0.2, 0.8)))
        gbar = np.array([float(rng.choice([0.0, rng.uniform(0.05, 0.8)]))])
        groups = Groups(np.array([float(rng.uniform(0.05, 0.8))]), gbar, r, STRONG, friction)
        expected = scanned(groups, 300)
        known = find_motions(groups, 1).orbit
        assert len(known.u) == len(expected)
        for x in expected:
            assert min(apart(x[:1], x[1:], known.u[[k]], known.phi[[k]]) for k in range(len(known.u))) < 1e-10
        seen += len(expected)
    assert seen


@pytest.mark.parametrize("depth", first(2, [1e-4, 1e-10, 1e-6, 1e-8]))
def test_next_to_a_fold_there_are_two_motions_on_one_side_and_none_on_the_other(depth: float) -> None:
    """The Jacobian of (gbar, d) by (q, phase) is singular there; along its left null vector the two meet."""
    r = Restitutions(0.5, 0.45)

    def jacobian(u: float, phi: float) -> np.ndarray:
        at = [orbits_of(Dynamics(r, 1, FORCE), *place) for place in ((u + 1e-30j, phi), (u, phi + 1e-30j))]
        return np.array([[own.gbar.imag for own in at], [own.d.imag for own in at]]) / 1e-30

    folds = 0
    for u in (-0.12, 0.03, 0.1):
        phases = np.linspace(0, 2 * np.pi, 181)
        signs = [np.linalg.det(jacobian(u, phi)) for phi in phases]
        for (low, f_low), (high, f_high) in pairwise(zip(phases, signs, strict=True)):
            if f_low * f_high > 0:
                continue
            for _ in range(60):
                middle = (low + high) / 2
                low, high = (middle, high) if np.linalg.det(jacobian(u, middle)) * f_low > 0 else (low, middle)
            at = orbits_of(Dynamics(r, 1, FORCE), u, low)
            normal = np.linalg.svd(jacobian(u, low))[0][:, 1]
            if not (at.velocity_bottom > 0.05 and at.velocity_top < -0.05 and at.d > 0.02 and at.gbar > 0.02):
                continue
            sides = np.array([-depth, depth])
            found = find_motions(Groups(at.d + sides * normal[1], at.gbar + sides * normal[0], r, FORCE), 1)
            near = [
                (found.cell == k)
                & (np.abs(found.orbit.u - u) < 20 * depth**0.5)
                & (np.abs(np.angle(np.exp(1j * (found.orbit.phi - low)))) < 20 * depth**0.5)
                for k in (0, 1)
            ]
            assert sorted(map(np.count_nonzero, near)) == [0, 2], (u, low)
            folds += 1
    assert folds


def test_a_device_beyond_all_motions_has_none() -> None:
    groups = Groups(np.array([1e8, 0.5, 1e-9]), np.array([0.3, 1e9, 0.3]), 0.5, FORCE)
    assert not set(find_motions(groups, 1).cell) & {0, 1}
    assert not len(find_motions(Groups(np.empty(0), np.empty(0), 0.5, FORCE), 1).cell)
