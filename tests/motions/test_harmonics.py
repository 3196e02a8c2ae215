"""1:1 motions of a force with harmonics: against flights in 40 digits, and the simulation."""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from conftest import first
from mpmath import mp, mpf
from msgspec.structs import replace
from raw_flights import Flights

from vireport.base.errors import NumericalError
from vireport.design.point import motions_at
from vireport.motions.contour import contours, places
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.level_plane import ContourPlane, SweptPlane
from vireport.motions.orbits import Dynamics, orbits_of
from vireport.motions.pointwise import PointwiseMotions
from vireport.motions.sweep import Held, Level, Sweep
from vireport.motions.turning import turns, wall_gap
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic, unaccelerated
from vireport.physics.groups import Groups
from vireport.scenario.parameters import DRIVING, Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import BOTTOM, Impact
from vireport.study.checks import reference

INCLINED = Device(
    capsule_mass_kg=0.1245, restitution=0.5, gravity_m_s2=9.8, length_m=0.6934, amplitude_n=3.0, frequency_hz=2.0,
    inclination_deg=45.0,
)  # fmt: skip
Parts = tuple[tuple[int, float, float], ...]
"""Order, share and phase in degrees of harmonics."""

SECOND, THIRD = (2, 0.02, 225.0), (3, 0.1, 30.0)
FORCES = [(SECOND,), (THIRD,), (SECOND, THIRD), ((5, 0.3, 30.0),), ((2, 0.2, 10.0), (8, 0.1, 70.0))]


def with_force(device: Device, *parts: tuple[int, float, float]) -> Device:
    return replace(device, harmonics=tuple(Harmonic.of(j, 100 * p, psi) for j, p, psi in parts))


def flights_of(groups: Groups, parts: Parts) -> Flights:
    return Flights(groups, [(j, mpf(p), mpf(psi) * mp.pi / 180) for j, p, psi in parts])


def test_the_motions_of_a_design_point_are_those_of_the_raw_flights_in_40_digits() -> None:
    as_in_40_digits(FORCES[2], 45.0, 1)
    as_in_40_digits(FORCES[4], 20.0, 2)


@pytest.mark.slow
@pytest.mark.parametrize("parts", FORCES)
def test_the_motions_of_many_design_points_are_those_of_the_raw_flights_in_40_digits(parts) -> None:
    for beta, n in ((45.0, 1), (0.0, 1), (20.0, 2)):
        as_in_40_digits(parts, beta, n)


def as_in_40_digits(parts: Parts, beta: float, n: int) -> None:
    device = with_force(replace(INCLINED, inclination_deg=beta, period_ratio=n, length_m=0.6934 * n), *parts)
    motions, _, (error_u, error_phi) = motions_at(device, Parameter.LENGTH)
    groups = device.groups(Parameter.LENGTH, device.length_m)
    assert motions.stable_mask.any() or n == 2
    with reference.precise():
        flights = flights_of(groups, parts)
        for row in range(len(motions)):
            x = flights.nearest(motions, row, n)
            # The groups are rounded, and the parts of harmonics: what that moves is some roundings.
            assert abs(x[0] - float(motions.velocity_bottom[row])) < 1e-13
            assert abs(x[1] - float(motions.velocity_top[row])) < 1e-13
            assert abs((x[3] - x[2]) / (2 * n) - mpf(1) / 2 - float(motions.u[row])) < 1e-14 + float(error_u[row])
            assert abs(x[2] * mp.pi - float(motions.phi_bottom[row])) < 1e-13 + float(error_phi[row])
            own, product = flights.map_of(*x, 2 * n)
            assert abs(product - (flights.r[0] * flights.r[1]) ** 2) < mpf(10) ** -18
            assert abs(own - float(motions.trace[row])) < 1e-11 * max(1, abs(float(own)))


@pytest.mark.parametrize(
    "parts", first(1, [((2, 0.5, 200.0),), ((8, 0.4, 50.0), (3, 0.2, 10.0)), ((2, 0.4, 0.0), (4, 0.5, 90.0))])
)
def test_the_gap_to_a_membrane_is_that_of_many_times(parts) -> None:
    seen = 0
    for length in (0.25, 0.4, 0.9):
        device = with_force(replace(INCLINED, length_m=length, inclination_deg=20.0), *parts)
        motions, _, _ = motions_at(device, Parameter.LENGTH)
        groups = device.groups(Parameter.LENGTH, length)
        flights = Flights(groups, ops=np)
        for row in range(len(motions)):
            motion = motions.motion(row, 1)
            expected = flights.gap(*motion.velocity, *motion.time)
            assert motions.wall_gap[row] == pytest.approx(expected, abs=2e-7)
            found = [turn.gap for turn in turns(motion, groups.as_floats())]
            assert min([float(groups.d), *found]) == pytest.approx(motions.wall_gap[row], abs=1e-9)
            seen += motions.wall_gap[row] < groups.d
    assert seen


def test_the_gaps_of_many_motions_are_those_of_each_by_itself() -> None:
    """Of two forcing periods: some have accelerations that vanish at two phases, others at four."""
    rng = np.random.default_rng(1)
    force = Harmonic.of(2, 50.0, 20.0), Harmonic.of(3, 30.0, 100.0)
    orbit = orbits_of(Dynamics(0.5, 2, force), rng.uniform(-0.45, 0.45, 400), rng.uniform(0, 2 * pi, 400))
    orbit = orbit.select((orbit.velocity_bottom > 0) & (orbit.velocity_top < 0) & (orbit.d > 0.01))
    assert {len(unaccelerated(float(gbar), force)) for gbar in orbit.gbar} == {2, 4}
    gaps, seen = wall_gap(orbit, 0.5), set()
    motions = PointwiseMotions(np.arange(len(gaps)), orbit, gaps, gaps)
    for k, gap in enumerate(gaps):
        groups = Groups(float(orbit.d[k]), float(orbit.gbar[k]), 0.5, force)
        least = min([groups.d, *(turn.gap for turn in turns(motions.motion(k, 2), groups))])
        assert gap == pytest.approx(least, abs=1e-9) or max(gap, least) < 0  # beyond a membrane either is
        seen.add(bool(gap > 0))
    assert seen == {False, True}


def test_a_sweep_has_the_motions_of_each_of_its_points() -> None:
    as_many_along_a_sweep(Parameter.AMPLITUDE, (SECOND,), 45.0)


@pytest.mark.slow
@pytest.mark.parametrize("parameter", DRIVING)
def test_every_sweep_has_the_motions_of_each_of_its_points(parameter) -> None:
    for parts, beta in (((SECOND, THIRD), 0.0), ((THIRD,), 0.0)):
        as_many_along_a_sweep(parameter, parts, beta)


def as_many_along_a_sweep(parameter: Parameter, parts: Parts, beta: float) -> None:
    """Whatever is swept: by the branches as many motions as at the point alone, where these are admissible."""
    value = float(INCLINED.value_of(parameter)) if parameter is not Parameter.INCLINATION else 40.0
    device = with_force(replace(INCLINED, inclination_deg=beta), *parts)
    diagram = solve(Sweep(device, parameter, 0.5 * value, 1.5 * value))
    for share in (0.61, 0.87, 1.2, 1.43):
        at = device.with_values({parameter: share * value})
        motions, _, _ = motions_at(at, parameter)
        crossed = 0
        for branch in diagram.branches:
            x = branch.motions.sweep_value
            inner = branch.motions.admissible_mask
            for (a, b), both in zip(pairwise(x), inner[:-1] & inner[1:], strict=True):
                crossed += bool(both) and (a - share * value) * (b - share * value) < 0
        assert crossed == np.count_nonzero(motions.admissible_mask), (share, motions.u)


@pytest.mark.slow
def test_critical_points_have_the_trace_of_their_event_in_40_digits() -> None:
    for parts, beta in (((SECOND,), 45.0), ((SECOND, THIRD), 0.0), ((THIRD,), 0.0)):
        device = with_force(replace(INCLINED, inclination_deg=beta), *parts)
        sweep = Sweep(device, Parameter.LENGTH, 0.2, 0.9)
        points = solve(sweep).critical_points
        assert {Event.PERIOD_DOUBLING} < {point.event for point in points}
        for point in points:
            if point.event is Event.GRAZING:
                continue
            at = replace(device, length_m=point.sweep_value)
            closed = point.closed
            orbit = orbits_of(Dynamics(0.5, 1, device.harmonics), np.array([closed.u]), np.array([closed.phi_bottom]))
            assert float(orbit.d[0]) == pytest.approx(point.d, rel=1e-13)
            with reference.precise():
                flights = flights_of(at.groups(Parameter.LENGTH, point.sweep_value), parts)
                start = mpf(closed.phi_bottom) / mp.pi
                x = mpf(closed.velocity_bottom), mpf(closed.velocity_top), start, start + 1 + 2 * mpf(closed.u)
                own, _ = flights.map_of(*x)
            level = {Event.PERIOD_DOUBLING: -1.0625, Event.NODE_FOCUS: np.copysign(0.5, float(own))}
            assert float(own) == pytest.approx(level.get(point.event, 1.0625), abs=1e-9)


@pytest.mark.slow
def test_an_even_harmonic_makes_a_fold_of_the_pitchfork_and_an_odd_one_keeps_it() -> None:
    level = replace(INCLINED, inclination_deg=0.0)
    for parts, event, symmetric in (((THIRD,), Event.PITCHFORK, True), ((SECOND,), Event.FOLD, False)):
        diagram = solve(Sweep(with_force(level, *parts), Parameter.LENGTH, 0.2, 0.9))
        assert [point.event for point in diagram.critical_points if point.event.letter == "C"] == [event]
        assert any(branch.motions.u.any() == 0 for branch in diagram.branches) is symmetric
        mirrors = [branch for branch in diagram.branches if branch.mirror_of is not None]
        assert bool(mirrors) is symmetric
    # A second harmonic that hardly is one parts the pitchfork by little: the fold is next to it.
    plain = solve(Sweep(with_force(level, (3, 1e-9, 0.0)), Parameter.LENGTH, 0.2, 0.9))
    parted = solve(Sweep(with_force(level, (2, 1e-9, 0.0)), Parameter.LENGTH, 0.2, 0.9))
    first, second = (
        next(point.sweep_value for point in diagram.critical_points if point.event.letter == "C")
        for diagram in (plain, parted)
    )
    assert abs(first - second) < 1e-5
    assert first == pytest.approx(solve(Sweep(level, Parameter.LENGTH, 0.2, 0.9)).critical_points[5].sweep_value, 1e-8)


def test_five_per_cent_of_the_second_harmonic_double_the_papers_period() -> None:
    """At 45 degrees and 0.6934 m: published theory has the frequency of the period doubling 2.6 % up at 2 %."""
    stable = motions_at(with_force(INCLINED, SECOND), Parameter.LENGTH)[0].stable_mask
    assert stable.any()
    assert not motions_at(with_force(INCLINED, (2, 0.05, 225.0)), Parameter.LENGTH)[0].stable_mask.any()
    ends = [
        solve(Sweep(device, Parameter.FREQUENCY, 1.8, 2.1)).critical_points[0].sweep_value
        for device in (INCLINED, with_force(INCLINED, (2, 0.02, 225.7)))
    ]
    assert ends[1] / ends[0] == pytest.approx(1.026, abs=5e-4)


@pytest.mark.parametrize("parts", FORCES[2:4])
def test_the_simulation_ends_on_every_stable_motion(parts) -> None:
    device = with_force(INCLINED, *parts)
    motions, _, _ = motions_at(device, Parameter.LENGTH)
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    for row in np.flatnonzero(motions.stable_mask):
        start = Impact(BOTTOM, float(motions.velocity_bottom[row]) * (1 + 1e-6), float(motions.phi_bottom[row]))
        cycle = find_attractor(groups, start, compiled=False).cycle
        assert cycle is not None
        assert (cycle.word, cycle.period) == ("BT", 1)
        assert cycle.velocity[0] == pytest.approx(motions.velocity_bottom[row], abs=1e-12)
        assert cycle.phase[0] == pytest.approx(motions.phi_bottom[row], abs=1e-12)
        assert sum(cycle.multipliers).real == pytest.approx(motions.trace[row], abs=1e-10)


@pytest.mark.slow
def test_a_ball_that_does_not_bounce_grazes_where_it_does_without_a_harmonic_to_speak_of() -> None:
    """Without restitution flights begin at rest: rounding there is no turning point, and no grazing point."""
    device = replace(
        INCLINED,
        restitution=0.0,
        length_m=2.4,
        amplitude_n=5.6,
        frequency_hz=1.84,
        inclination_deg=1e-6,
        period_ratio=3,
    )
    plain, more = (
        solve(Sweep(own, Parameter.FREQUENCY, 0.97, 1.7)).critical_points
        for own in (device, with_force(device, (7, 1e-9, 90.0)))
    )
    assert [point.event for point in plain] == [point.event for point in more]
    for point, other in zip(plain, more, strict=True):
        assert point.sweep_value == pytest.approx(other.sweep_value, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    "below", [1e-2, 3e-4, 1e-8, *(pytest.param(below, marks=pytest.mark.slow) for below in (1e-3, 1e-4, 1e-5))]
)
def test_curves_within_a_cell_of_the_grid_are_found_or_refused(below: float) -> None:
    """Around the two largest gbar of a surface, mirror images of each other: next to them a curve goes round each."""
    harmonics = (Harmonic.of(2, 30.0, 40.0), Harmonic.of(5, 20.0, 100.0))
    # Located by a simplex on the surface.
    u, phi = np.array([-0.1625118]), np.array([-0.87289133])
    largest = float(orbits_of(Dynamics(0.5, 1, harmonics), u, phi).gbar[0])
    surface = ContourPlane(Level(Held.GBAR, largest * (1 - below)), 0.5, 1, harmonics)
    try:
        found = contours(surface)
        along = [np.linspace(0, own.end, 7 * len(own.u)) for own in found]
        at = [places([own], np.zeros(len(w), dtype=np.intp), w, surface) for own, w in zip(found, along, strict=True)]
    except NumericalError:
        assert 1e-5 < below < 1e-3  # the curve is thin and as large as a cell
        return
    assert len(found) == 2
    for own, (at_u, at_phi) in zip(found, at, strict=True):
        assert own.closed
        assert np.abs(surface.value(at_u, at_phi)).max() < 1e-13
        # Next to an extremum a curve is an ellipse, whose extent goes with the root of the depth.
        assert np.ptp(at_u) == pytest.approx(0.369 * below**0.5, rel=0.03)


def test_a_level_from_which_symmetric_motions_are_divided_out_is_zero_where_nothing_pulls_the_ball() -> None:
    """Of a horizontal capsule and odd harmonics; in phase, as the level is that of gbar = 0."""
    device = with_force(replace(INCLINED, inclination_deg=0.0), THIRD, (5, 0.3, 30.0))
    sweep = Sweep(device, Parameter.LENGTH, 0.3, 0.7)
    plane = SweptPlane(sweep.level, device.restitution, 1, device.harmonics)
    assert plane.mirrors
    u, phi = 0.07, np.linspace(0.0, 2 * pi, 2001)
    parts, held = plane.polynomial(np.array(u))
    height = sum(a * np.sin(j * phi) + b * np.cos(j * phi) for j, a, b in parts) - held
    crossed = np.flatnonzero(np.sign(height[1:]) != np.sign(height[:-1]))
    assert len(crossed) >= 2
    gbar = plane.orbits(np.full(len(phi), u), phi).gbar
    for i in crossed:
        at = phi[i] - height[i] * (phi[i + 1] - phi[i]) / (height[i + 1] - height[i])
        assert abs(float(plane.orbits(np.array([u]), np.array([at])).gbar[0])) < 1e-5 * np.abs(gbar).max()
