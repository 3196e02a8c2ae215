"""1:1 motions of a ball with friction: against the equations of their flights in 40 digits, simulation and theory."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf
from msgspec.structs import replace
from raw_flights import Flights

from vireport.base.errors import UsageError
from vireport.design.margins import margins_of
from vireport.design.point import motions_at
from vireport.design.solution import solution_of
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.orbits import Dynamics, Friction, orbits, orbits_of
from vireport.motions.pointwise import find_motions
from vireport.motions.stability import return_trace
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions, by_wall
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import BOTTOM, Impact

PAPER = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0)
SECOND = (Harmonic.of(2, 20.0, 130.0),)
KINDS = {
    "alike": (0.5, (), 1),
    "unlike": (Restitutions(0.6, 0.3), (), 1),
    "harmonics": (0.5, SECOND, 1),
    "two periods": (0.4, (), 2),
    "all together": (Restitutions(0.7, 0.8), (*SECOND, Harmonic.of(3, 5.0, 10.0)), 1),
}


def endings(device: Device) -> list:
    """The ends of the stable motions of a device, nearest first."""
    return [end for end in margins_of(device, motions_at(device, Parameter.LENGTH)[0]).margins if end.ends_stability]


@pytest.mark.parametrize("kind", KINDS)
def test_every_place_of_the_surface_is_a_motion_in_forty_digits(kind: str) -> None:
    r, harmonics, n = KINDS[kind]
    rng = np.random.default_rng(1)
    u, phi, f = rng.uniform(-0.4, 0.4, 40), rng.uniform(0, 2 * np.pi, 40), rng.uniform(0, 0.4, 40)
    laws = Friction(f), Friction(0, 0.2), Friction(0, 0, 0.3)
    for law in laws:
        orbit = orbits_of(Dynamics(r, n, harmonics, law), u, phi)
        for i in range(0, 40, 4):
            with mp.workdps(40):
                flights = Flights(Groups(orbit.d[i], orbit.gbar[i], r, harmonics, orbit.friction[i]))
                start = mpf(float(phi[i])) / mp.pi
                x = [mpf(float(v)) for v in (orbit.velocity_bottom[i], orbit.velocity_top[i])]
                left = flights.missed(*x, start, start + n * (1 + 2 * mpf(float(u[i]))), period=2 * n)
            scale = 1 + max(map(abs, (orbit.d[i], orbit.gbar[i], orbit.velocity_bottom[i])))
            assert max(map(abs, left)) < 2e-14 * n * scale
    constant, by_gbar, by_d = (orbits_of(Dynamics(r, n, harmonics, law), u, phi) for law in laws)
    assert np.array_equal(constant.friction, f)
    np.testing.assert_allclose(by_gbar.friction, 0.2 * by_gbar.gbar, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(by_d.friction, 0.3 * by_d.d, rtol=1e-12, atol=1e-14)


def test_no_friction_to_speak_of_leaves_every_number() -> None:
    u, phi = np.linspace(-0.3, 0.3, 13), np.linspace(0, 6, 13)
    plain, none = orbits(u, phi, 0.5, 1), orbits_of(Dynamics(0.5, 1, friction=Friction(0.0)), u, phi)
    for name in ("gbar", "d", "velocity_bottom", "velocity_top"):
        np.testing.assert_allclose(getattr(plain, name), getattr(none, name), rtol=0, atol=1e-16)


def test_how_far_friction_moves_the_period_doubling_is_what_theory_has() -> None:
    """The paper's device at 45 degrees: B1 in frequency, of which published theory has 0.3, 0.7 and 1.4 %."""

    def nearest(friction: float):
        ends = endings(replace(PAPER, friction=friction))
        return next(end for end in ends if end.parameter is DesignInput.FREQUENCY)

    without = nearest(0.0)
    for friction, moved, left in ((0.02, 0.3, 4.5), (0.05, 0.7, 4.0), (0.1, 1.4, 3.4)):
        end = nearest(friction)
        assert 100 * (end.sweep_value / without.sweep_value - 1) == pytest.approx(moved, abs=0.05)
        assert -100 * end.relative == pytest.approx(left, abs=0.06)
        assert end.error_bound < 1e-14


@pytest.mark.slow
@pytest.mark.parametrize(
    "device",
    [
        replace(PAPER, friction=0.05),
        *(
            replace(PAPER, friction=0.05, **others)
            for others in (
                {"restitution": Restitutions(0.525, 0.475)},
                {"capsule": CapsuleMotion.FREE, "ball_mass_kg": 0.0041},
                {"harmonics": (Harmonic.of(2, 2.0, 225.0),)},
                {"inclination_deg": 0.0, "length_m": 0.5554},
                {"inclination_deg": 20.0},
            )
        ),
    ],
    ids=["friction", "unlike", "free", "harmonics", "level", "flat"],
)
def test_derivatives_of_every_end_are_its_differences(device: Device) -> None:
    """By force, mass, inclination and restitution of the bottom, through which friction moves as well."""
    ends = [end for end in endings(device) if end.event is not Event.FOLD][:4]
    assert ends
    checked = 0
    for end in ends:
        for varied in (DesignInput.AMPLITUDE, DesignInput.CAPSULE_MASS, DesignInput.INCLINATION):
            slope = end.derivatives.get(varied)
            if varied is end.parameter or slope is None or not float(device.value_of(varied)):
                continue
            step, values = 1e-5 * float(device.value_of(varied)), []
            for sign in (1, -1):
                moved = device.with_values({varied: float(device.value_of(varied)) + sign * step})
                others = [o for o in endings(moved) if o.event is end.event and o.parameter is end.parameter]
                values.append(min((o.sweep_value for o in others), key=lambda v, end=end: abs(v - end.sweep_value)))
            assert (values[0] - values[1]) / (2 * step) == pytest.approx(slope, rel=2e-4, abs=1e-7)
            checked += 1
        if checked >= 3:
            break
    assert checked


@pytest.mark.slow
def test_stable_motions_are_those_that_the_simulation_comes_to() -> None:
    """Velocity, phase and the larger multiplier, of random devices whose ball does not stop, and no others stay 1:1."""
    rng = np.random.default_rng(8)
    agreed = 0
    for _ in range(12):
        d, gbar, f = rng.uniform(0.35, 0.6), rng.uniform(0.1, 0.45), rng.uniform(0.01, 0.1)
        r = Restitutions(*rng.uniform(0.4, 0.65, 2))
        groups = Groups(float(d), float(gbar), r, (), float(f))
        motions = find_motions(groups._replace(d=np.array([d]), gbar=np.array([gbar])), 1)
        for i in np.flatnonzero(motions.stable(Restitutions(*(np.array([x]) for x in by_wall(r))))):
            orbit = motions.orbit
            start = Impact(BOTTOM, float(orbit.velocity_bottom[i]) * 1.00001, float(orbit.phi[i] % (2 * np.pi)))
            end = find_attractor(groups, start, compiled=False)
            if end.cycle is None or end.cycle.growth > 0.9:
                continue
            assert end.word == "BT"
            bottom = int(np.argmax(end.cycle.wall == BOTTOM))
            assert end.cycle.velocity[bottom] == pytest.approx(float(orbit.velocity_bottom[i]), abs=1e-10)
            assert sum(end.cycle.multipliers).real == pytest.approx(float(motions.trace[i]), abs=1e-8)
            agreed += 1
    assert agreed >= 5


def test_where_friction_stops_the_ball_a_motion_is_followed_no_farther() -> None:
    """The simulation comes to the motion on one side; on the other, it goes on with a stop, in which it forgets."""
    device = replace(PAPER, friction=0.05, inclination_deg=0.0, length_m=0.5554)
    diagram = solve(Sweep(device, Parameter.LENGTH, 0.3, 0.75))
    (stop,) = [point for point in diagram.critical_points if point.event is Event.STOP]
    assert stop.label == "S1"
    assert stop.error_bound < 1e-15
    assert "followed no farther" in stop.detail
    for branch in diagram.branches:
        beyond = branch.motions.stable_mask & (branch.motions.sweep_value < stop.sweep_value * (1 - 1e-9))
        assert not beyond.any()
    for share, moves_on in ((1 + 1e-4, True), (1 - 1e-4, False)):
        groups = device.groups(Parameter.LENGTH, stop.sweep_value * share).as_floats()
        start = Impact(BOTTOM, stop.closed.velocity_bottom, stop.closed.phi_bottom)
        end = find_attractor(groups, start, compiled=False)
        assert end.word == "BT"
        determinant = abs(end.cycle.multipliers[0] * end.cycle.multipliers[1])
        assert determinant == pytest.approx(0.5**4 if moves_on else 0.0, abs=1e-10)


def test_the_determinant_is_the_product_of_the_restitutions_squared() -> None:
    rng = np.random.default_rng(5)
    from vireport.motions.stability import flight_jacobians

    orbit = orbits_of(
        Dynamics(Restitutions(0.7, 0.4), 1, friction=Friction(0.2)), rng.uniform(-0.3, 0.3, 50), rng.uniform(0, 6, 50)
    )
    up, down = (np.array(j).reshape(2, 2, -1) for j in flight_jacobians(orbit, Restitutions(0.7, 0.4)))
    product = np.linalg.det(np.moveaxis(down, -1, 0)) * np.linalg.det(np.moveaxis(up, -1, 0))
    np.testing.assert_allclose(product, (0.7 * 0.4) ** 2, rtol=1e-9)
    assert return_trace(orbit, Restitutions(0.7, 0.4)).shape == (50,)


@pytest.mark.parametrize("angle", [0.0, 45.0])
def test_along_a_sweep_of_the_force_friction_goes_with_it(angle: float) -> None:
    device = replace(PAPER, friction=0.1, inclination_deg=angle, length_m=0.6)
    diagram = solve(Sweep(device, Parameter.AMPLITUDE, 2.5, 4.5))
    rows = 0
    for branch in diagram.branches:
        motions = branch.motions
        for i in range(0, len(motions), 25):
            groups = device.groups(Parameter.AMPLITUDE, float(motions.sweep_value[i]))
            place = motions.u[i], motions.phi_bottom[i]
            orbit = orbits_of(Dynamics(0.5, 1, friction=Friction(groups.friction)), *place)
            assert orbit.d == pytest.approx(groups.d, rel=1e-8)
            assert orbit.gbar == pytest.approx(groups.gbar, rel=1e-8, abs=1e-10)
            rows += 1
    assert rows > 4


def test_a_sweep_of_the_inclination_is_refused_by_name() -> None:
    with pytest.raises(UsageError, match="friction"):
        solve(Sweep(replace(PAPER, friction=0.1), Parameter.INCLINATION, 10.0, 60.0))


def test_upright_there_is_no_friction() -> None:
    upright = replace(PAPER, inclination_deg=90.0, amplitude_n=6.0)
    assert replace(upright, friction=0.3).groups(Parameter.LENGTH, 0.5) == upright.groups(Parameter.LENGTH, 0.5)
    solution_of(replace(upright, friction=0.3), None, None, True)


def test_a_free_capsule_has_both_weights_in_friction() -> None:
    free = replace(PAPER, friction=0.1, capsule=CapsuleMotion.FREE, ball_mass_kg=0.0041)
    ratio = (
        free.groups(Parameter.LENGTH, 0.7).friction
        / replace(PAPER, friction=0.1).groups(Parameter.LENGTH, 0.7).friction
    )
    assert ratio == pytest.approx(1 + 0.0041 / 0.1245, rel=1e-15)
