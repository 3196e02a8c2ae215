"""No family is missed: the motions found are counted against a scan of the paper's own quadratic (3.17)-(3.20)."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import first
from msgspec.structs import replace
from raw_flights import Flights
from strategies import random_sweeps

from vireport.base.errors import NumericalError
from vireport.design.point import design_point
from vireport.motions.diagram import solve
from vireport.motions.pointwise import find_motions
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions
from vireport.scenario.parameters import Parameter


def scan(d: float, gbar: float, r: float, samples: int = 400_001) -> list[tuple[float, float, float]]:
    """Solutions (velocity, phase, q) by the sign of (3.10) along both roots of (3.18)-(3.20)."""
    q = np.linspace(0, 1, samples)[1:-1]
    up, down, period = 2 * q, 2 * (1 - q), 2.0
    k = up * down / period
    a = np.pi**2 * (r - 1) ** 2 + np.pi**4 * (r + 1) ** 2 * k**2
    b = (
        2 * np.pi**2 * (r - 1) * gbar * (period / (1 + r) - up)
        - np.pi**4 * (r + 1) * gbar * period * k**2
        - 2 * np.pi**4 * d * (r + 1) * k
    )
    c = (
        np.pi**2 * gbar**2 * (period / (1 + r) - up) ** 2
        + np.pi**4 * (d + gbar * up * down / 2) ** 2
        - 2
        + 2 * np.cos(2 * np.pi * q)
    )
    seen = []
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - 4 * a * c)
        for sign in (1.0, -1.0):
            velocity = (-b + sign * root) / (2 * a)
            first = np.pi * (velocity * (r - 1) + gbar * (period / (1 + r) - up))
            second = np.pi**2 * (d - k / 2 * (2 * (r + 1) * velocity - gbar * period))
            # (cos a - 1) S + sin a C = first and (cos a - 1) C - sin a S = second.
            angle = np.arctan2(np.sin(np.pi * up), np.cos(np.pi * up) - 1)
            phase = np.arctan2(first, second) - angle
            phase = np.arctan2(np.sin(phase), np.cos(phase))
            residual = (r * up - down) * velocity + period / np.pi * np.sin(phase) - period / 2 * (up - down) * gbar
            good = np.isfinite(residual[1:] * residual[:-1]) & (residual[1:] * residual[:-1] < 0)
            good &= np.abs(np.angle(np.exp(1j * (phase[1:] - phase[:-1])))) < 0.5
            for i in np.nonzero(good)[0]:
                if velocity[i] > 0 > gbar * period / (1 + r) - velocity[i]:
                    seen.append((velocity[i], phase[i] % (2 * np.pi), q[i]))
    return seen


@pytest.mark.parametrize("seed", first(1, range(16)))
def test_every_motion_of_a_scan_is_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    d, gbar, r = 10 ** rng.uniform(-1.5, 0.1), 10 ** rng.uniform(-2.5, 0.2), rng.uniform(0.05, 0.95)
    # M = 1, g = 1, F = 1/gbar and f = 1 at a vertical capsule give these groups.
    device = Device(1.0, r, 1.0, d / (4 * gbar), 1 / gbar, 1.0, 90.0)
    ours = design_point(device, solve(Sweep(device, Parameter.LENGTH, 1.0, 1.001))).motions
    expected = scan(d, gbar, r)
    assert len(ours) == len(expected)
    for velocity, phase, q in expected:
        off = (
            np.abs(ours.velocity_bottom - velocity) + np.abs(ours.q - q) + np.abs(np.sin((ours.phi_bottom - phase) / 2))
        )
        assert off.min() < 1e-3


def random_groups(rng: np.random.Generator, parts: tuple[str, ...]) -> Groups[float]:
    """Groups of a device whose membranes are not alike, with some parts."""
    r = Restitutions(*rng.uniform(0.1, 0.85, 2).tolist())
    orders = rng.choice(np.arange(2, 9), size=int(rng.integers(1, 4)), replace=False).tolist()
    harmonics = tuple(Harmonic.of(order, *rng.uniform((1, 0), (50, 360)).tolist()) for order in orders)
    d, gbar = float(10 ** rng.uniform(-0.9, -0.1)), float(rng.choice([0.0, 1e-6, rng.uniform(0, 0.6)]))
    friction = float(rng.uniform(0.01, 0.3)) if "friction" in parts else None
    return Groups(d, gbar, r, harmonics if "harmonics" in parts else (), friction)


@pytest.mark.parametrize(
    ("count", "parts"),
    [
        (4, ()),
        (2, ("friction",)),
        *(pytest.param(9, parts, marks=pytest.mark.slow) for parts in (("friction",), ("harmonics",))),
        pytest.param(9, ("friction", "harmonics"), marks=pytest.mark.slow),
    ],
)
def test_newton_from_anywhere_finds_no_motion_that_is_not_listed(count: int, parts: tuple[str, ...]) -> None:
    rng, seen = np.random.default_rng(5), 0
    for k in range(count):
        groups, n = random_groups(rng, parts), 1 + k % 3
        try:
            listed = find_motions(groups._replace(d=np.array([groups.d]), gbar=np.array([groups.gbar])), n).orbit
        except NumericalError:
            assert "harmonics" in parts  # next to the largest gravity at which there are motions they are refused
            continue
        for x in Flights(groups, ops=np).from_anywhere(rng, 40, 2 * n):
            phase = np.abs(np.mod(listed.phi - np.pi * x[2] + np.pi, 2 * np.pi) - np.pi)
            off = np.maximum(np.abs(listed.u - ((x[3] - x[2]) / (2 * n) - 0.5)), phase)
            assert off.min(initial=np.inf) < 1e-5, (groups, n, x)
            seen += 1
    assert seen > 2 * count


def test_small_inclination_has_two_families_and_large_has_fewer_stable_ones() -> None:
    def stable(angle: float) -> int:
        device = Device(0.1245, 0.5, 9.8, 0.33, 3.0, 2.0, angle)
        return int(design_point(device, solve(Sweep(device, Parameter.LENGTH, 0.4, 0.5))).motions.stable_mask.sum())

    assert stable(0.01) == 2
    assert stable(45.0) <= 1


@pytest.mark.parametrize("angle", first(2, [1e-9, 1e-6, 1e-3, 0.01, 0.1]))
def test_nearly_symmetric_branch_of_a_nearly_horizontal_capsule_is_found(angle: float) -> None:
    device = Device(0.1245, 0.5, 9.8, None, 3.0, 2.0, angle)
    solution = solve(Sweep(device, Parameter.LENGTH, 0.26, 0.75))
    flat = solve(Sweep(Device(0.1245, 0.5, 9.8, None, 3.0, 2.0, 0.0), Parameter.LENGTH, 0.26, 0.75))
    # The stable focus of the symmetric family is still there at d = 0.4, with q off one half by about gbar.
    near = [
        (m.q[row] - 0.5, m.velocity_bottom[row])
        for m in (branch.motions for branch in solution.branches)
        for row in np.nonzero(m.stable_mask & (m.d > 0.39) & (m.d < 0.41))[0]
    ]
    symmetric = flat.branches[0].motions
    expected = np.interp(0.4, symmetric.d, symmetric.velocity_bottom)
    gbar = solution.branches[0].motions.gbar[0]
    assert near
    for offset, velocity in near:
        assert 0 < abs(offset) < 5 * gbar + 1e-15
        assert velocity == pytest.approx(expected, rel=0.05 + 5 * gbar)


def test_branch_across_the_singularity_of_the_printed_form() -> None:
    """Eq. (3.10) as printed divides by r Tu - Td, zero at q = 1/(1+r): nothing happens there."""
    solution = solve(Sweep(Device(0.1245, 0.5, 9.8, 0.75, None, 2.0, 45.0), Parameter.AMPLITUDE, 3.0, 6.0))
    (doubling,) = (point for point in solution.critical_points if point.label == "B1")
    main = solution.branches[doubling.families[0] - 1].motions
    assert main.q.min() < 2 / 3 < main.q.max()
    inside = np.abs(main.q - 2 / 3) < 0.02
    assert inside.sum() > 3
    smooth = np.polynomial.Polynomial.fit(main.q[inside], main.velocity_bottom[inside], 7)
    np.testing.assert_allclose(smooth(main.q[inside]), main.velocity_bottom[inside], rtol=1e-9)


SWEEPS, BATCHES = 70, 14
"""Random sweeps, and the parts of them of which each is a test."""


def crossings(solution, value: float) -> int:
    """How many motions the branches have at a value of the swept parameter."""
    count = 0
    for branch in solution.branches:
        beyond = branch.motions.sweep_value > value
        count += int((beyond[1:] != beyond[:-1]).sum())
    return count


@pytest.mark.parametrize("batch", first(1, range(BATCHES)))
def test_branches_hold_every_motion_of_each_design_point(batch: int) -> None:
    """The branches of a sweep and the design points along it are found apart from each other, at different samples."""
    rng = np.random.default_rng(batch)
    for sweep in random_sweeps(SWEEPS, seed=77)[batch::BATCHES]:
        solution = solve(sweep)
        for share in rng.uniform(0.02, 0.98, 2):
            value = sweep.start + share * (sweep.end - sweep.start)
            device = replace(sweep.device, **{sweep.parameter: float(value)})
            alone = design_point(
                device, solve(Sweep(device, Parameter.LENGTH, device.length_m * 50, device.length_m * 51))
            )
            assert crossings(solution, value) == len(alone.motions), (sweep, value)


@pytest.mark.parametrize("angle", first(2, [0.0, 1e-9, 1e-4, 0.01, 0.05, 0.1, 0.5]))
def test_unstable_branch_near_pi_of_a_nearly_horizontal_capsule(angle: float) -> None:
    device = Device(0.1245, 0.5, 9.8, None, 3.0, 2.0, angle)
    solution = solve(Sweep(device, Parameter.LENGTH, 0.1, 1.0))
    assert any(np.abs(m.phi_bottom - np.pi).min() < 0.1 for m in (branch.motions for branch in solution.branches))
    assert crossings(solution, 0.6) == 2
