"""A capsule that recoils from the ball: held against two bodies that are simulated as they are, in SI units."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest
from mpmath import mp, mpf
from msgspec import Struct, field
from msgspec.structs import replace
from scipy.optimize import brentq

from vireport.design.point import design_point
from vireport.physics.device import Device
from vireport.physics.energy import Dielectric, Membrane, Strikes, conversion, deflection, voltages
from vireport.physics.groups import Restitutions, by_wall
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.checks import reference

PAPER = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0, ball_mass_kg=0.0041)
FREE = replace(PAPER, capsule=CapsuleMotion.FREE)
HEAVY = replace(FREE, ball_mass_kg=0.04, length_m=0.9, restitution=Restitutions(0.45, 0.55), inclination_deg=35.0)
LEVEL = replace(FREE, ball_mass_kg=0.04, length_m=0.5554, inclination_deg=0.0)


class TwoBodies(Struct):
    """Capsule and ball as two bodies on an incline: places and velocities up the incline, in m and m/s.

    The force F cos(2 pi f t + phase) and what holds the weight of both in the mean act on the capsule.
    """

    device: Device
    phase: float
    capsule: tuple[float, float]
    ball: tuple[float, float]
    time: float = 0.0
    places: list[float] = field(default_factory=list)

    @property
    def weight(self) -> float:
        return self.device.gravity_m_s2 * sin(radians(self.device.inclination_deg))

    def after(self, t: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Place and velocity of both a time after the last impact, each by its own equation of motion."""
        x, m = self.device, self.device.ball_mass_kg
        w = 2 * pi * x.frequency_hz
        (at, v), (ball_at, ball_v) = self.capsule, self.ball
        start, end = w * self.time + self.phase, w * (self.time + t) + self.phase
        # The support carries (M + m) g sin(beta), of which M g sin(beta) pulls the capsule down.
        steady, size = m * self.weight / x.capsule_mass_kg, x.amplitude_n / x.capsule_mass_kg
        velocity = v + steady * t + size / w * (sin(end) - sin(start))
        place = at + v * t + steady * t**2 / 2 + size / w**2 * (cos(start) - cos(end)) - size / w * sin(start) * t
        return (place, velocity), (ball_at + ball_v * t - self.weight * t**2 / 2, ball_v - self.weight * t)

    def gap(self, t: float, wall: int) -> float:
        """Room between ball and a membrane: the lower one (1) is half a length below the capsule's middle."""
        (place, _), (ball, _) = self.after(t)
        return self.device.length_m / 2 - wall * (place - ball)

    def impact(self) -> tuple[int, float, float, float]:
        """Fly to the next impact: wall, relative velocity there, phase of the force, energy lost."""
        step = 1e-3 / self.device.frequency_hz
        t = step
        while min(self.gap(t, 1), self.gap(t, -1)) > 0:
            t += step
            self.places.append(self.after(t)[0][0])
        wall = 1 if self.gap(t, 1) <= 0 else -1
        t = brentq(lambda t: self.gap(t, wall), t - step, t, xtol=1e-15, rtol=8.9e-16)
        (place, v), (ball, u) = self.after(t)
        big, small = self.device.capsule_mass_kg, self.device.ball_mass_kg
        r = by_wall(self.device.restitution)[0 if wall > 0 else 1]
        # M V+ + m u+ = M V + m u and V+ - u+ = -r (V - u)
        together, apart = (big * v + small * u) / (big + small), v - u
        after, ball_after = together - r * small / (big + small) * apart, together + r * big / (big + small) * apart
        lost = (big * (v**2 - after**2) + small * (u**2 - ball_after**2)) / 2
        self.time, self.capsule, self.ball = self.time + t, (place, after), (ball, ball_after)
        return wall, apart, (2 * pi * self.device.frequency_hz * self.time + self.phase) % (2 * pi), lost


@pytest.mark.parametrize(
    ("device", "loose"),
    [(FREE, 1.09), (HEAVY, 1.71), (LEVEL, 1.75)],
    ids=["paper", "a third of the capsule", "horizontal"],
)
def test_two_bodies_meet_as_the_relative_motion_does(device: Device, loose: float) -> None:
    design = design_point(device, None)
    row = int(np.argmax(design.motions.stable_mask))
    motions, unit = design.motions, device.velocity_unit(Parameter.LENGTH, device.length_m)
    bottom, top = (unit * float(x[row]) for x in (motions.velocity_bottom, motions.velocity_top))
    phase = float(motions.phi_bottom[row])
    # Just after the impact at the bottom; the capsule moves with the velocity that has no drift.
    mu, r = device.mass_ratio, by_wall(device.restitution)[0]
    force = device.amplitude_n / device.capsule_mass_kg / (2 * pi * device.frequency_hz)
    v = (force * sin(phase) - mu * r * bottom) / (1 + mu)
    bodies = TwoBodies(device, phase, (device.length_m / 2, v), (0.0, v + r * bottom))
    start, membrane = bodies.capsule, Membrane(4e5, 2.6, 6e-3, 5e-3, 2000.0, 1.0).of_device(device)
    for _ in range(3):
        wall, speed, _, lost = bodies.impact()
        assert (wall, speed) == (-1, pytest.approx(top, rel=1e-9))
        of_wall = by_wall(device.restitution)[1]
        assert lost == pytest.approx(membrane.reduced_mass_kg * (1 - of_wall**2) * speed**2 / 2, rel=1e-9)
        wall, speed, at, lost = bodies.impact()
        assert (wall, speed) == (1, pytest.approx(bottom, rel=1e-9))
        assert cos(at - phase) == pytest.approx(1, abs=1e-15)
        assert lost == pytest.approx(membrane.reduced_mass_kg * (1 - r**2) * speed**2 / 2, rel=1e-9)
    assert bodies.capsule == pytest.approx(start, rel=1e-8)  # the support carries just both weights
    stroke = device.shaker(Parameter.LENGTH, device.length_m).stroke_m
    moved = max(bodies.places) - min(bodies.places)
    assert stroke / moved == pytest.approx(loose, abs=0.01)  # a bound, as the model page says
    with_force_alone = replace(device, capsule=CapsuleMotion.PRESCRIBED).shaker(Parameter.LENGTH, device.length_m)
    assert moved != pytest.approx(with_force_alone.stroke_m, rel=0.01)


def test_what_recoils_is_the_mass_ratio_alone() -> None:
    """A capsule that is prescribed does not know the ball's mass; a free one has gbar (1 + mu), in 40 digits."""
    heavier = {"ball_mass_kg": 0.05}
    assert replace(PAPER, **heavier).groups(Parameter.LENGTH, 0.7) == PAPER.groups(Parameter.LENGTH, 0.7)
    d, gbar, r, *_ = FREE.groups(Parameter.LENGTH, 0.7)
    prescribed = PAPER.groups(Parameter.LENGTH, 0.7)
    assert (d, r) == (prescribed.d, prescribed.restitution)
    assert gbar == pytest.approx(prescribed.gbar * (1 + 0.0041 / 0.1245), rel=1e-15)
    assert replace(FREE, inclination_deg=0.0).groups(Parameter.LENGTH, 0.7).gbar == 0
    with reference.precise():
        true = (mpf(0.1245) + mpf(0.0041)) * mpf(9.8) * mp.sin(mp.pi / 4) / 3
        assert abs(reference.groups(FREE, Parameter.LENGTH, 0.7)[1] / true - 1) < 1e-38
        assert abs(gbar / true - 1) < 1e-15
    assert FREE.value(Parameter.INCLINATION, d, gbar) == pytest.approx(45.0, rel=1e-14)


@pytest.mark.parametrize("varied", list(DesignInput))
def test_slopes_are_those_of_differences(varied: DesignInput) -> None:
    value, step = FREE.value_of(varied), 1e-6 * FREE.value_of(varied)
    near = [FREE.with_values({varied: value + side * step}) for side in (-1, 1)]
    low, high = (np.array(x.groups(Parameter.LENGTH, x.length_m).numbers, dtype=float) for x in near)
    groups = FREE.groups(Parameter.LENGTH, FREE.length_m)
    slopes = np.array(FREE.slopes(varied, groups.d, groups.gbar))
    np.testing.assert_allclose((high - low) / (2 * step), slopes, rtol=1e-8, atol=1e-9)


def test_energies_are_those_of_the_relative_motion() -> None:
    dielectric = Dielectric(1e-3, 4.7, 1e8)
    prescribed = Membrane(4e5, 2.6, 6e-3, 5e-3, 2000.0, 0.0041, dielectric)
    free, light = prescribed.of_device(FREE), replace(prescribed, ball_mass_kg=0.0041 / (1 + 0.0041 / 0.1245))
    assert prescribed.of_device(PAPER) == prescribed
    assert free.reduced_mass_kg == pytest.approx(1 / (1 / 0.0041 + 1 / 0.1245), rel=1e-15)
    speeds = np.array(0.7), np.array(1.1)
    assert deflection(speeds[0], free) == pytest.approx(float(deflection(speeds[0], light)), rel=1e-15)
    converted = [
        conversion(Strikes((v.bottom_v, v.top_v), speeds, 0.5), membrane, dielectric, 0.5)
        for membrane, v in ((x, voltages(*speeds, x)) for x in (free, light, prescribed))
    ]
    assert float(converted[0].efficiency) == pytest.approx(float(converted[1].efficiency), rel=1e-14)
    assert float(converted[0].energy_top_j) == pytest.approx(float(converted[1].energy_top_j), rel=1e-14)
    assert float(converted[0].power_mw) < float(converted[2].power_mw)
