"""Membranes with restitutions of their own: the closed form and its events against the maps themselves in 40 digits."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from exact_device import ExactDevice
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from msgspec.structs import replace
from raw_flights import Flights

from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.orbits import coefficients, orbits
from vireport.motions.periodicity import Model, trace
from vireport.motions.pointwise import differentiated_motions, find_motions, forms
from vireport.motions.stability import determinant_of, flight_jacobians, return_trace
from vireport.motions.sweep import Sweep
from vireport.motions.turning import wall_gap
from vireport.physics.device import Device
from vireport.physics.groups import Groups, Restitutions
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import BOTTOM, Impact, check_model, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, VELOCITY, WALL
from vireport.study.checks import reference

restitutions = st.floats(0, 0.95)
shares, phases, ratios = st.floats(-0.49, 0.49), st.floats(0, 6.28), st.integers(1, 3)


def missed(orbit: Any, r: Restitutions, n: int) -> list[Any]:
    """By how much a motion misses the raw maps (2.10)-(2.13) of a period: velocities at top and bottom, d twice."""
    start = mpf(orbit.phi) / mp.pi
    flights = Flights(Groups(orbit.d, orbit.gbar, r))
    return flights.missed(
        mpf(orbit.velocity_bottom), orbit.velocity_top, start, start + n + 2 * n * mpf(orbit.u), period=2 * n
    )


@settings(max_examples=20)
@given(shares, phases, restitutions, restitutions, ratios)
def test_every_share_and_phase_is_a_motion_of_the_raw_maps(u: float, phi: float, b: float, t: float, n: int) -> None:
    with reference.precise():
        r = Restitutions(mpf(b), mpf(t))
        assert max(map(abs, missed(orbits(mpf(u), mpf(phi), r, n, mp), r, n))) < mpf(10) ** -35
    r = Restitutions(b, t)
    orbit = orbits(u, phi, r, n)
    size = n / (1 - max(b, t))
    assert max(abs(float(x)) for x in missed(orbit, r, n)) < 1e-13 * size


@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_system_is_never_singular(n: int) -> None:
    """D2 = u^2 + a_b a_t is at least a_b a_t, a = (1-r)/(2(1+r)); K(q) = -T^2 (1+r_b) D2: 2,000 cases each."""
    rng = np.random.default_rng(n)
    u, (b, t) = rng.uniform(-0.5, 0.5, 2000), np.where(rng.random((2, 2000)) < 0.1, 0.0, rng.random((2, 2000)))
    least = (1 - b) * (1 - t) / (4 * (1 + b) * (1 + t))
    found = coefficients(u, Restitutions(b, t), n).determinant / (-4 * n * n * (1 + b))
    assert (found >= least * (1 - 1e-12)).all()
    np.testing.assert_allclose(found, u * u + least, rtol=1e-11)


@settings(max_examples=20)
@given(st.floats(-0.45, 0.45), phases, st.floats(0.01, 0.95), st.floats(0.01, 0.95))
def test_the_determinant_is_the_square_of_the_product(u: float, phi: float, b: float, t: float) -> None:
    with reference.precise():
        r = Restitutions(mpf(b), mpf(t))
        orbit = orbits(mpf(u), mpf(phi), r, 1, mp)
        assume(min(abs(orbit.velocity_bottom), abs(orbit.velocity_top)) > 1e-3)  # at which the Jacobians have a pole
        (a11, a12, a21, a22), (b11, b12, b21, b22) = flight_jacobians(orbit, r)
        determinant = (a11 * a22 - a12 * a21) * (b11 * b22 - b12 * b21)
        assert abs(determinant / determinant_of(r) - 1) < mpf(10) ** -25
    assert determinant_of(Restitutions(0.4, 0.6)) == pytest.approx((0.4 * 0.6) ** 2)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_equal_restitutions_of_two_membranes_give_the_numbers_of_one(n: int) -> None:
    rng = np.random.default_rng(n)
    u, phi, r = rng.uniform(-0.5, 0.5, 500), rng.uniform(0, 7, 500), rng.uniform(0, 0.99, 500)
    one, two = orbits(u, phi, r, n), orbits(u, phi, Restitutions(r, r.copy()), n)
    for name in type(one).__struct_fields__:
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    np.testing.assert_array_equal(return_trace(one, r), return_trace(two, Restitutions(r, r.copy())))
    np.testing.assert_array_equal(wall_gap(one, r), wall_gap(two, Restitutions(r, r.copy())))
    for name in ("sine_gbar", "sine_d", "cosine_gbar", "cosine_d", "delta"):
        same = (getattr(forms(u, x, n), name) for x in (r, Restitutions(r, r.copy())))
        np.testing.assert_array_equal(*same)


def test_derivatives_by_one_restitution_are_those_of_differences() -> None:
    r, step = Restitutions(np.array([0.45]), np.array([0.55])), 1e-30
    groups = Groups(np.array([0.46 + 0j]), np.array([0.287 + 0j]), Restitutions(r.bottom + 1j * step, r.top + 0j))
    exact = differentiated_motions(groups, 1)
    at = np.array([0.46]), np.array([0.287])
    ends = [find_motions(Groups(*at, Restitutions(r.bottom + h, r.top)), 1) for h in (-1e-6, 1e-6)]
    for name in ("velocity_bottom", "u", "phi"):
        low, high = (getattr(end.orbit, name) for end in ends)
        np.testing.assert_allclose(getattr(exact.orbit, name).imag / step, (high - low) / 2e-6, rtol=1e-6)
    np.testing.assert_allclose(exact.trace.imag / step, (ends[1].trace - ends[0].trace) / 2e-6, rtol=1e-5)


INCLINED = Device(0.1245, Restitutions(0.47, 0.52), 9.8, 0.6934, 3.0, 2.0, 45.0)
LEVEL = replace(INCLINED, inclination_deg=0.0, length_m=0.5554)


@pytest.mark.parametrize(("device", "low", "high"), [(INCLINED, 0.59, 0.75), (LEVEL, 0.26, 0.75)])
def test_critical_points_against_the_raw_maps(device: Device, low: float, high: float) -> None:
    sweep = Sweep(device, Parameter.LENGTH, low, high)
    points = [p for p in solve(sweep).critical_points if p.event in (Event.PERIOD_DOUBLING, Event.FOLD)]
    assert points
    with mp.workdps(45):
        for point in points[:2]:
            exact = ExactDevice(device.with_values({sweep.parameter: point.sweep_value}))
            at = point.closed
            start = mpf(at.phi_bottom) / mp.pi
            x = mpf(at.velocity_bottom), mpf(at.velocity_top), start, start + 1 + 2 * mpf(at.u)
            border, (tr, determinant) = {Event.PERIOD_DOUBLING: -1, Event.FOLD: 1}[point.event], exact.map_of(*x)
            # As far as the rounding of the point's numbers goes, times the slopes.
            assert max(map(abs, [*exact.missed(*x), tr - border * (1 + determinant)])) < 1e-12
            assert point.error_bound < 1e-15


def test_a_horizontal_capsule_loses_its_symmetry() -> None:
    """No motion is its own mirror image: in place of the pitchfork one of two families ends in a fold."""
    unlike = solve(Sweep(LEVEL, Parameter.LENGTH, 0.2, 0.75))
    alike = solve(Sweep(replace(LEVEL, restitution=0.5), Parameter.LENGTH, 0.2, 0.75))
    events = {point.event for point in unlike.critical_points}
    assert Event.PITCHFORK in {point.event for point in alike.critical_points}
    assert Event.PITCHFORK not in events
    assert Event.FOLD in events
    assert all(branch.mirror_of is None for branch in unlike.branches)


def test_turned_about_a_horizontal_capsule_is_that_with_its_membranes_exchanged() -> None:
    other = replace(LEVEL, restitution=Restitutions(LEVEL.restitution.top, LEVEL.restitution.bottom))
    found = [
        sorted((point.event, round(point.sweep_value, 12)) for point in solve(sweep).critical_points)
        for sweep in (Sweep(device, Parameter.LENGTH, 0.2, 0.75) for device in (LEVEL, other))
    ]
    assert found[0] == found[1]


@pytest.mark.parametrize("device", [INCLINED, LEVEL])
@pytest.mark.parametrize(
    ("parameter", "low", "high"),
    [
        (Parameter.LENGTH, 0.4, 0.8),
        (Parameter.FREQUENCY, 1.6, 2.4),
        (Parameter.AMPLITUDE, 2.5, 5.0),
        (Parameter.INCLINATION, 0.0, 60.0),
    ],
)
def test_stable_motions_of_every_sweep_are_those_of_the_simulation(
    device: Device, parameter: Parameter, low: float, high: float
) -> None:
    sweep, seen = Sweep(device, parameter, low, high), 0
    for branch in solve(sweep).branches:
        motions = branch.motions
        stable = np.flatnonzero(motions.stable_mask)
        for row in stable[:: max(len(stable) // 3, 1)]:
            groups = device.groups(parameter, float(motions.sweep_value[row])).as_floats()
            velocity, phase = float(motions.velocity_bottom[row]), float(motions.phi_bottom[row])
            rows, _ = follow_one(check_model(groups)[0], (BOTTOM, 0.0, velocity, phase), 4, compiled=False)
            np.testing.assert_allclose(rows[2, 3], velocity, atol=1e-9)
            np.testing.assert_array_equal(rows[:, 0], [1, -1, 1, -1, 1])
            seen += 1
    assert seen > 1


def test_a_motion_found_unstable_is_left_by_the_simulation() -> None:
    """r at the bottom 5 % less doubles the period at s = 0.67 m, where equal ones do not."""
    device = Device(0.1245, 0.5, 9.8, 0.67, 3.0, 2.0, 45.0)
    for r, word in ((0.5, "BT"), (Restitutions(0.475, 0.5), "BTBT")):
        groups = replace(device, restitution=r).groups(Parameter.LENGTH, 0.67).as_floats()
        motions = find_motions(Groups(np.array([groups.d]), np.array([groups.gbar]), r), 1)
        start = Impact(BOTTOM, float(motions.orbit.velocity_bottom[0]) * 1.001, float(motions.orbit.phi[0]))
        assert find_attractor(groups, start, compiled=False).word == word


def test_the_trace_of_any_word_has_the_restitution_of_each_wall() -> None:
    orbit, r = orbits(0.08, 0.55, INCLINED.restitution, 1), INCLINED.restitution
    sweep = Sweep(INCLINED, Parameter.LENGTH, 0.6, 0.7)
    motion = Motion(
        Word((1, -1), 1),
        np.array([orbit.velocity_bottom, orbit.velocity_top]),
        np.array([0.55 / np.pi, 0.55 / np.pi + orbit.time_up]),
        float(orbit.d),
    )
    model = replace(Model(sweep.level, r), level=replace(sweep.level, value=float(orbit.gbar)))
    x = [*motion.velocity.tolist(), *motion.time.tolist(), motion.coordinate]
    assert trace(motion.word, x, model) == pytest.approx(return_trace(orbit, r), rel=1e-13)
    assert model.determinant((1, -1), 0.4) == pytest.approx((0.47 * 0.52) ** 2)


def test_a_membrane_that_is_struck_twice_counts_twice_in_the_determinant() -> None:
    """Of BBT, against differences of the simulated return map."""
    groups, step = Groups(0.4, 0.5, Restitutions(0.6, 0.4)), 1e-5
    cycle = find_attractor(groups, Impact(BOTTOM, 0.3, 1.0), compiled=False).cycle
    assert cycle is not None
    assert sorted(cycle.wall) == [-1, 1, 1]

    def after_a_period(x: np.ndarray) -> np.ndarray:
        start = float(cycle.wall[0]), 0.0, float(x[1]), float(x[0])
        return follow_one(check_model(groups)[0], start, 3, compiled=False)[0][3, [PHASE, VELOCITY]]

    at = np.array([cycle.phase[0], cycle.velocity[0]])
    slopes = [(after_a_period(at + h) - after_a_period(at - h)) / (2 * step) for h in step * np.eye(2)]
    decay = groups.decay(cycle.wall.tolist())
    assert decay == pytest.approx(0.6 * 0.6 * 0.4)
    assert np.linalg.det(slopes) == pytest.approx(decay**2, rel=1e-5)


def test_after_each_impact_the_ball_has_the_share_of_its_speed_that_the_membrane_leaves_it() -> None:
    """Of simulated flights, whose raw equations give the velocity that each must have begun with."""
    groups = Groups(0.4, 0.3, Restitutions(0.6, 0.4))
    rows, _ = follow_one(check_model(groups)[0], (1.0, 0.0, 0.3, 1.0), 12, compiled=False)
    flights = [(before, after) for before, after in pairwise(rows) if not before[SETTLING] + before[RIDING]]
    assert {before[WALL] for before, _ in flights} == {1.0, -1.0}
    for before, after in flights:
        speed, _ = Flights(groups).moved(0, groups.gbar, mpf(before[PHASE]) / mp.pi, mpf(after[FLIGHT]))
        left = float(after[VELOCITY] - speed)
        wall = int(before[WALL])
        assert left == pytest.approx(-groups.restitution_at(wall) * before[VELOCITY], rel=1e-9)
        assert left == pytest.approx(groups.after(wall, before[VELOCITY]), rel=1e-9)


def test_inputs_of_restitution_move_what_they_say() -> None:
    both = INCLINED.with_values({DesignInput.RESTITUTION: 0.5})
    assert (both.restitution.bottom, both.restitution.top) == pytest.approx((0.475, 0.525))
    alone = replace(INCLINED, restitution=0.5).with_values({DesignInput.RESTITUTION_BOTTOM: 0.4})
    assert alone.restitution == Restitutions(0.4, 0.5)
    assert alone.with_values({DesignInput.RESTITUTION_TOP: 0.4}).restitution == 0.4
    assert INCLINED.value_of(DesignInput.RESTITUTION) == pytest.approx(0.495)


def test_a_flight_begins_with_the_rebound_from_the_membrane_that_it_leaves() -> None:
    r = Restitutions(0.4, 0.7)
    orbit = orbits(np.array([0.05]), np.array([0.5]), r, 1)
    up, down = orbit.flights(r)
    np.testing.assert_allclose(up.velocity, -0.4 * orbit.velocity_bottom, rtol=1e-15)
    np.testing.assert_allclose(down.velocity, -0.7 * orbit.velocity_top, rtol=1e-15)
