"""Sweeps over a restitution: the plane of q and phase, its motions and their events, in 40 digits and otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf
from raw_flights import Flights

from vireport.motions.bounces import Bounces
from vireport.motions.diagram import solve
from vireport.motions.error_bounds import one_to_one_bounds
from vireport.motions.events import Event
from vireport.motions.orbits import Dynamics, Friction, orbits, orbits_of
from vireport.motions.stability import return_trace
from vireport.motions.sweep import Held, Level, Sweep
from vireport.physics.device import Device, moved
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions, by_wall
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import BOTTOM, Impact, check_model, follow_one
from vireport.study.checks import reference

VARIED = Parameter.RESTITUTION, Parameter.RESTITUTION_BOTTOM, Parameter.RESTITUTION_TOP
PAPER = Device(0.1245, 0.5, 9.8, 0.7, 3.0, 2.0, 45.0)


def random_sweeps(count: int, seed: int) -> list[Sweep]:
    """Over one restitution, the other, or both, of equal and unequal membranes, horizontal, nearly so and inclined."""
    rng, sweeps = np.random.default_rng(seed), []
    for i in range(count):
        bottom, top = rng.uniform(0.05, 0.9, 2)
        alike, n = bool(rng.random() < 0.5), int(rng.choice([1, 1, 1, 2, 3]))
        beta = float(rng.choice([0.0, rng.uniform(0, 90), 10 ** rng.uniform(-5, 0)]))
        length, force = float(10 ** rng.uniform(-1, 0.5) * n * n), float(10 ** rng.uniform(0.2, 1.2))
        r = float(bottom) if alike else Restitutions(float(bottom), float(top))
        device = Device(0.1245, r, 9.8, length, force, 2.0, beta, n)
        half = 0.0 if alike or VARIED[i % 3] is not Parameter.RESTITUTION else abs(bottom - top) / 2
        low, high = np.sort(rng.uniform(half + 0.01, 0.99 - half, 2)).tolist()
        sweeps.append(Sweep(device, VARIED[i % 3], low, high))
    return sweeps


SWEEPS = random_sweeps(14, 25)
LEVEL = PAPER.with_values({Parameter.INCLINATION: 0.0, Parameter.LENGTH: 0.4})
EVENTFUL = [*(Sweep(PAPER, parameter, 0.1, 0.9) for parameter in VARIED), Sweep(LEVEL, Parameter.RESTITUTION, 0.3, 0.8)]


def speeds(flights: Flights, way: mpf, t: mpf, x: mpf, gravity: mpf) -> tuple[mpf, mpf]:
    """Velocities at the begin and the end of a flight that covers `way` in a time."""
    gained, moved = flights.moved(0, gravity, x / mp.pi, t)
    return (way - moved) / t, (way - moved) / t + gained


class Digits:
    """Functions of 40 digits."""

    pi, sin, cos, sinc = mp.pi, staticmethod(mp.sin), staticmethod(mp.cos), staticmethod(mp.sincpi)


DIGITS = Digits()


def places(count: int) -> Iterator[tuple[float, float, float, float, int]]:
    """u, phase, two restitutions and n, nowhere special."""
    rng = np.random.default_rng(9)
    for n in range(1, count + 1):
        yield *rng.uniform((-0.45, 0.0, 0.05, 0.05), (0.45, 6.2, 0.95, 0.95)).tolist(), 1 + n % 3


@pytest.mark.parametrize("rubs", [False, True])
@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("alike", [False, True])
def test_the_height_is_zero_where_what_is_held_has_its_value(alike: bool, flat: bool, rubs: bool) -> None:
    """Against the flights, integrated here, in 40 digits; over u where motions have mirror images."""
    for (u, phi, b, t, n), distorted in product(places(3), (False, True)):
        height_is_right(u, phi, b, t, n, alike=alike, flat=flat, rubs=rubs, distorted=distorted)


def height_is_right(
    u: float, phi: float, b: float, t: float, n: int, *, alike: bool, flat: bool, rubs: bool, distorted: bool
) -> None:
    with reference.precise():
        harmonics = (Harmonic(3, mpf(b) / 5, mpf(t) / 7), Harmonic(2, mpf(t) / 9, mpf(0)))[: 1 if flat else 2]
        harmonics = harmonics if distorted else ()
        friction, gbar, d = mpf(b) / 9 if rubs else mpf(0), mpf(0) if flat else mpf(t) / 3, mpf(t) + mpf(b) / 3
        r = mpf(b) if alike else Restitutions(mpf(b), mpf(t))
        u, phi = mpf(u) + mpf(1) / 1000, mpf(phi)
        up, down = n + 2 * n * u, n - 2 * n * u
        flights = Flights(Groups(d, gbar, r, harmonics))
        after_bottom, before_top = speeds(flights, -d, up, phi, gbar + friction)
        after_top, before_bottom = speeds(flights, d, down, phi + mp.pi * up, gbar - friction)
        (bottom, top), both = by_wall(r), up * down
        divided = flat and alike and n % 2 == 1
        for varied, expected in (
            (Parameter.RESTITUTION_BOTTOM, (after_top + top * before_top) * both),
            (Parameter.RESTITUTION_TOP, (after_bottom + bottom * before_bottom) * both),
            (
                Parameter.RESTITUTION,
                (after_bottom * before_top - after_top * before_bottom + (bottom - top) * before_bottom * before_top)
                * both**2,
            ),
        ):
            if varied is Parameter.RESTITUTION and alike and flat:
                expected = expected / u if divided else expected
                if not rubs:
                    expected = expected / (before_top - after_top) / both
            level = Level(Held.BOTH, gbar, Friction(friction) if rubs else None, d, varied)
            plane = Bounces(level, r, n, harmonics)
            assert abs(plane.value(u, phi, DIGITS) - expected) < mpf(10) ** -33 * (1 + abs(expected))
            orbit = plane.orbits(u, phi, mp)
            assert abs(orbit.velocity_bottom - before_bottom) + abs(orbit.velocity_top - before_top) < mpf(10) ** -33


@pytest.mark.parametrize("rubs", [False, True])
@pytest.mark.parametrize("distorted", [False, True])
def test_a_motion_of_given_restitutions_is_on_the_levels_of_its_groups(rubs: bool, distorted: bool) -> None:
    """The closed form of (q, phase) at given restitutions, the other way round, in 40 digits."""
    for u, phi, b, t, n in places(4):
        with reference.precise():
            r, harmonics = Restitutions(mpf(b), mpf(t)), (Harmonic(2, mpf(t) / 9, mpf(b) / 7),) if distorted else ()
            friction = Friction(mpf(b) / 5) if rubs else None
            own = orbits_of(Dynamics(r, n, harmonics, friction), mpf(u), mpf(phi), mp)
            for varied in VARIED:
                plane = Bounces(Level(Held.BOTH, own.gbar, friction, own.d, varied), r, n, harmonics)
                size = 1 + own.velocity_bottom**2 + own.velocity_top**2
                assert abs(plane.value(mpf(u), mpf(phi), mp)) < mpf(10) ** -30 * size
                found = plane.orbits(mpf(u), mpf(phi), mp)
                for x, y in zip(by_wall(found.restitution), by_wall(r), strict=True):
                    assert abs(x - y) < mpf(10) ** -25


def at_value(sweep: Sweep, value: Any) -> tuple[Any, Any, Any]:
    """d, gbar and r where the restitution has a value, by the reference's own formulae."""
    d, gbar = reference.groups(sweep.device, Parameter.LENGTH, mpf(sweep.device.length_m))
    bottom, top = (mpf(own) for own in by_wall(sweep.device.restitution))
    if sweep.parameter is Parameter.RESTITUTION:
        half = (bottom - top) / 2
        return d, gbar, Restitutions(value + half, value - half)
    return (
        d,
        gbar,
        Restitutions(*((value, top) if sweep.parameter is Parameter.RESTITUTION_BOTTOM else (bottom, value))),
    )


TARGETS = {
    Event.PERIOD_DOUBLING: lambda decay, trace: -(1 + decay**2),
    Event.FOLD: lambda decay, trace: 1 + decay**2,
    Event.PITCHFORK: lambda decay, trace: 1 + decay**2,
    Event.NODE_FOCUS: lambda decay, trace: 2 * decay if trace > 0 else -2 * decay,
}


@pytest.mark.slow
@pytest.mark.usefixtures("forty_digits")
def test_critical_points_are_those_of_the_printed_equations_in_40_digits() -> None:
    checked: set[tuple[Parameter, Event]] = set()
    for sweep in (*EVENTFUL, *SWEEPS[:6]):
        n = sweep.device.period_ratio
        for point in solve(sweep).critical_points:
            if point.event not in TARGETS:
                continue
            closed = point.closed
            symmetric = point.event is Event.PITCHFORK or closed.u == 0

            def equations(x: list[Any], point=point, symmetric=symmetric, sweep=sweep, n=n) -> list[Any]:
                d, gbar, r = at_value(sweep, x[3])
                state = x[0], x[1], x[2]
                trace = reference.trace(state, gbar, r, n)
                closing = reference.periodicity(state, d, gbar, r, n)
                if symmetric:
                    closing = [x[0] - reference.symmetric_velocity(x[1], r.bottom), x[2], closing[0]]
                return [*closing, trace - TARGETS[point.event](r.bottom * r.top, trace)]

            guess = [closed.velocity_bottom, closed.phi_bottom, closed.u, point.sweep_value]
            exact = reference.newton(equations, [mpf(x) for x in guess])
            assert abs(mpf(point.sweep_value) - exact[3]) <= point.error_bound, (sweep, point.event)
            checked.add((sweep.parameter, point.event))
    assert {parameter for parameter, _ in checked} == set(VARIED)
    assert {event for _, event in checked} == set(TARGETS)


@pytest.mark.slow
@pytest.mark.usefixtures("forty_digits")
def test_exact_motions_are_within_the_bounds_of_those_on_branches() -> None:
    """Beside each row, where q or the phase is kept: the one by which the level changes less."""
    checked = 0
    for sweep in SWEEPS[:6]:
        n, plane = sweep.device.period_ratio, Bounces(sweep.level, sweep.device.restitution, sweep.device.period_ratio)
        for branch in solve(sweep).branches:
            m = branch.motions
            bounds = one_to_one_bounds(sweep, m, None)
            rows = [row for row in range(2, len(m) - 2, 41) if m.u[row] != 0]
            for row in rows:
                _, by_u, by_phi = plane.gradient(m.u[row], m.phi_bottom[row])
                kept = 1 if abs(by_u) >= abs(by_phi) else 2
                start = [mpf(float(x[row])) for x in (m.velocity_bottom, m.phi_bottom, m.u, m.sweep_value)]

                def equations(x: list[Any], start=start, kept=kept, sweep=sweep, n=n) -> list[Any]:
                    d, gbar, r = at_value(sweep, x[3])
                    return [*reference.periodicity((x[0], x[1], x[2]), d, gbar, r, n), x[kept] - start[kept]]

                velocity, phase, u, value = reference.newton(equations, start)
                _, gbar, r = at_value(sweep, value)
                trace = reference.trace((velocity, phase, u), gbar, r, n)
                for name, stored, exact in (
                    ("velocity_bottom", m.velocity_bottom, velocity),
                    ("phi_bottom", m.phi_bottom, phase),
                    ("q", m.u, u),
                    ("sweep_value", m.sweep_value, value),
                    ("trace", m.trace, trace),
                    ("determinant", m.determinant, (r.bottom * r.top) ** 2),
                ):
                    assert abs(mpf(float(stored[row])) - exact) <= bounds[name][row], (sweep, row, name)
                checked += 1
    assert checked >= 15


@pytest.mark.slow
def test_every_critical_point_is_one_of_the_sweep_over_the_length_through_it() -> None:
    checked = 0
    for sweep in (*EVENTFUL, *SWEEPS[:4]):
        for point in solve(sweep).critical_points:
            device, length = sweep.device.with_values({sweep.parameter: point.sweep_value}), sweep.device.length_m
            across = solve(Sweep(device, Parameter.LENGTH, 0.99 * length, 1.01 * length)).critical_points
            near = [other for other in across if other.event is point.event and np.isfinite(other.error_bound)]
            assert any(abs(other.sweep_value / length - 1) < 1e-9 for other in near), (sweep, point)
            checked += 1
    assert checked > 15


def newton_from(rng: np.random.Generator, device: Device, starts: int) -> list[tuple[float, float]]:
    """Places of motions of a device that Newton's steps on the closed form of given restitutions come to."""
    d, gbar, r, *_ = device.groups(Parameter.LENGTH, device.length_m)
    n, step = device.period_ratio, 1e-30

    def off(u: Any, phi: Any) -> Any:
        orbit = orbits(u, phi, r, n)
        return np.stack([orbit.d - d, orbit.gbar - gbar])

    u, phi = rng.uniform(-0.5, 0.5, starts), rng.uniform(0, 2 * np.pi, starts)
    for _ in range(40):
        here, by_u, by_phi = off(u, phi), off(u + 1j * step, phi).imag / step, off(u, phi + 1j * step).imag / step
        determinant = by_u[0] * by_phi[1] - by_u[1] * by_phi[0]
        with np.errstate(all="ignore"):
            u = np.clip(u - (here[0] * by_phi[1] - here[1] * by_phi[0]) / determinant, -0.499, 0.499)
            phi = phi - (here[1] * by_u[0] - here[0] * by_u[1]) / determinant
    with np.errstate(all="ignore"):
        orbit = orbits(u, phi, r, n)
        good = (np.abs(off(u, phi)).max(axis=0) < 1e-12) & (orbit.velocity_bottom > 0) & (orbit.velocity_top < 0)
    return list(zip(u[good].tolist(), np.mod(phi[good], 2 * np.pi).tolist(), strict=True))


@pytest.mark.slow
def test_newton_from_random_starts_finds_no_motion_that_is_not_on_a_branch() -> None:
    rng, seen = np.random.default_rng(4), 0
    for sweep in SWEEPS[:8]:
        value = float(rng.uniform(sweep.start, sweep.end))
        branches, n = solve(sweep).branches, sweep.device.period_ratio
        known = []
        for branch in branches:
            for motion in branch.family.at(value):
                first = int(np.argmax(np.array(motion.word.walls) > 0))
                motion = motion.rotated(first)
                known.append(((motion.time[1] - motion.time[0]) / (2 * n) - 0.5, motion.phase[0]))
        for u, phi in newton_from(rng, sweep.device.with_values({sweep.parameter: value}), 40):
            turned = [abs((phi - at + np.pi) % (2 * np.pi) - np.pi) for _, at in known]
            assert any(abs(u - at) < 1e-6 and off < 1e-6 for (at, _), off in zip(known, turned, strict=True)), sweep
            seen += 1
    assert seen > 40


@pytest.mark.slow
@pytest.mark.parametrize("parameter", VARIED)
def test_the_simulation_stays_on_what_is_stable_and_leaves_what_is_not(parameter: Parameter) -> None:
    device = PAPER if parameter is not Parameter.RESTITUTION else LEVEL
    stable = unstable = 0
    for branch in solve(Sweep(device, parameter, 0.15, 0.85)).branches:
        motions = branch.motions
        for row in np.flatnonzero(motions.admissible_mask)[3::47]:
            if abs(abs(motions.trace[row]) - 1 - motions.determinant[row]) < 0.05:
                continue  # so near to a critical point that it would take long
            groups = device.groups(parameter, float(motions.sweep_value[row])).as_floats()
            velocity, phase = float(motions.velocity_bottom[row]), float(motions.phi_bottom[row])
            rows, _ = follow_one(check_model(groups)[0], (BOTTOM, 0.0, velocity, phase), 2, compiled=False)
            np.testing.assert_allclose(rows[2, 3], velocity, atol=1e-9)
            end = find_attractor(groups, Impact(BOTTOM, velocity * (1 + 1e-4), phase), compiled=False)
            same = end.word == "BT" and end.cycle is not None
            same = same and abs(end.cycle.velocity[end.cycle.wall == BOTTOM][0] - velocity) < 1e-6
            assert same == bool(motions.stable_mask[row]), (branch.number, row)
            stable, unstable = stable + same, unstable + (not same)
    assert stable
    assert unstable


def test_one_membrane_alone_breaks_the_symmetry_of_a_horizontal_capsule() -> None:
    both, *each = (solve(Sweep(LEVEL, parameter, 0.3, 0.8)) for parameter in VARIED)
    assert [point.event for point in both.critical_points].count(Event.PITCHFORK) == 1
    assert any(branch.mirror_of for branch in both.branches)
    for diagram in each:
        assert Event.PITCHFORK not in {point.event for point in diagram.critical_points}
        assert not any(branch.mirror_of or branch.symmetry == "symmetric" for branch in diagram.branches)
    bottom, top = (sorted(point.sweep_value for point in diagram.critical_points) for diagram in each)
    assert bottom == pytest.approx(top)  # what one membrane does to the motion, the other does to its mirror image


@pytest.mark.slow
@pytest.mark.parametrize("parameter", VARIED)
def test_harmonics_and_friction_have_the_motions_of_each_value(parameter: Parameter) -> None:
    device = Device(0.1245, 0.5, 9.8, 0.7, 3.0, 2.0, 45.0, harmonics=(Harmonic.of(2, 4.0, 30.0),), friction=0.02)
    points = solve(Sweep(device, parameter, 0.2, 0.8)).critical_points
    assert points
    for point in points:
        at = device.with_values({parameter: point.sweep_value})
        across = solve(Sweep(at, Parameter.LENGTH, 0.69, 0.71)).critical_points
        assert any(other.event is point.event and abs(other.sweep_value / 0.7 - 1) < 1e-9 for other in across), point


@pytest.mark.parametrize("parameter", VARIED)
def test_the_range_goes_from_impacts_without_rebound_to_nearly_without_loss(parameter: Parameter) -> None:
    diagram = solve(Sweep(PAPER, parameter, 0.0, parameter.limits[1]))
    ends = [float(end) for branch in diagram.branches for end in branch.motions.sweep_value[[0, -1]]]
    assert max(ends) == parameter.limits[1]
    for branch in diagram.branches:
        row = len(branch.motions) // 2
        m = branch.motions
        r = moved(PAPER.restitution, parameter, float(m.sweep_value[row]))
        orbit = orbits(m.u[[row]], m.phi_bottom[[row]], r, 1)
        np.testing.assert_allclose([orbit.d[0], orbit.gbar[0]], [m.d[row], m.gbar[row]], rtol=1e-9)
        np.testing.assert_allclose(return_trace(orbit, r)[0], m.trace[row], rtol=1e-7)
