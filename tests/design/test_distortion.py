"""The harmonics of the force that end stable motion: against flights in 40 digits, a simulator, and rays all round."""

from __future__ import annotations

from math import atan2, cos, hypot, inf, pi, radians, sin

import numpy as np
import pytest
from conftest import first
from mpmath import mpf
from msgspec.structs import replace
from raw_flights import Flights

from vireport.design import distortion
from vireport.design.distortion import ORDERS, Distortion, Ray, distortions, with_harmonic
from vireport.design.lines import ends_on_curve, mirrored, stable_ones
from vireport.design.margins import Margin, margins_of
from vireport.design.point import motions_at
from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions
from vireport.motions.paths import Curve
from vireport.motions.periodicity import linearised, residuals, trace
from vireport.motions.turning import turns
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic, unaccelerated, wave
from vireport.physics.groups import Restitutions
from vireport.physics.numbers import FLOATS
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.checks import reference

INCLINED = Device(
    capsule_mass_kg=0.1245, restitution=0.5, gravity_m_s2=9.8, length_m=0.6934, amplitude_n=3.0, frequency_hz=2.0,
    inclination_deg=45.0,
)  # fmt: skip
LEVEL, NEAR_PITCHFORK = (replace(INCLINED, length_m=length, inclination_deg=0.0) for length in (0.65, 0.32))
SIGNS = {Event.PERIOD_DOUBLING: -1, Event.FOLD: 1}
"""Of the trace at an event, of size 1 + determinant."""

UNEQUAL = replace(INCLINED, restitution=Restitutions(0.49, 0.5))


def found(device: Device) -> tuple[Motions, tuple[Distortion, ...], Margin]:
    motions, _, _ = motions_at(device, Parameter.LENGTH)
    nearest = next(margin for margin in margins_of(device, motions).margins if margin.ends_stability)
    return motions, distortions(device, motions, nearest), nearest


@pytest.mark.parametrize("device", first(2, [INCLINED, LEVEL, NEAR_PITCHFORK, UNEQUAL]))
def test_the_least_harmonic_has_the_trace_of_its_event_by_the_raw_maps_in_40_digits(device: Device) -> None:
    motions, told, _ = found(device)
    assert [each.order for each in told] == [2, 3]
    own = motions.stable_mask & ((motions.u >= 0) | (device.inclination_deg > 0))
    motion = motions.motion(int(np.argmax(own)), 1)
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    for each in told:
        if each.share is None:
            continue
        phase = radians(each.phase_deg)
        curve = Curve(motion.word, Ray.of(device, each.order, phase, FLOATS), -1.0, 1.0, 1.0)
        event, x, _, _ = next(iter(ends_on_curve(curve, motion, 1.0, mirrored(device) and each.order == 3)))
        assert event is each.event
        # At a fold two motions meet: with a little less of the harmonic they, and the trace, are off by its root.
        short = 1e-12 if event is Event.FOLD else 0.0
        with reference.precise():
            flights = Flights(groups, [(each.order, each.share * (1 - short), phase)])
            _, _, trace, determinant = flights.periodic((1, -1), x[0], (x[2], x[3]), 2)
            product = flights.r[0] ** 2 * flights.r[1] ** 2
            assert abs(determinant - product) < mpf(10) ** -15
            assert abs(trace - SIGNS[event] * (1 + product)) < mpf(10) ** (-4 if short else -9)
    assert told[0].share is not None


def settled(flights: Flights, velocity: float, start: float) -> list[float]:
    """Velocities at the bottom of the last eight periods of 300, by a simulator of fixed steps and bisections."""
    wall, speeds = 1, []
    for _ in range(600):
        wall, long, velocity = flights.struck(wall, velocity, start)
        start += long
        if wall > 0:
            speeds.append(velocity)
    return speeds[-8:]


@pytest.mark.slow
@pytest.mark.parametrize("device", [INCLINED, LEVEL])
def test_a_simulator_repeats_every_period_short_of_it_and_every_second_one_beyond(device: Device) -> None:
    motions, told, _ = found(device)
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    for each in (each for each in told if each.share is not None):
        spread = {}
        for share in (0.9 * each.share, 1.1 * each.share):
            flights = Flights(groups, [(each.order, share, radians(each.phase_deg))], np)
            last = settled(flights, float(motions.velocity_bottom[0]), float(motions.phi_bottom[0]) / pi)
            spread[share] = abs(last[-1] - last[-2]), abs(last[-1] - last[-3])
        short, beyond = spread.values()
        assert short[0] < 1e-3 < 1e-2 < beyond[0]
        assert beyond[1] < 5e-2 * beyond[0] or each.share > 0.3


def least_of_rays(device: Device, motions: Motions, order: int, rays: int) -> float:
    """The least share on many rays, for the first stable motion."""
    least, motion = inf, motions.motion(0, device.period_ratio)
    for phase in np.linspace(0, 2 * pi, rays, endpoint=False):
        limit = min(least, distortion.LARGEST)
        curve = Curve(motion.word, Ray.of(device, order, float(phase), FLOATS), -1.0, limit, 1.0)
        for event, x, _, taken_over in ends_on_curve(curve, motion, 1.0, False):
            if event is not Event.SWEEP_END and not taken_over:
                least = min(least, float(x[-1]))
    return least


def random_device(rng: np.random.Generator) -> Device | None:
    device = Device(
        0.1245, rng.uniform(0.2, 0.7), 9.8, rng.uniform(0.15, 0.8), 3.0, rng.uniform(1.6, 2.6), rng.uniform(5, 85)
    )
    motions, _, _ = motions_at(device, Parameter.LENGTH)
    return device if motions.stable_mask.sum() == 1 else None


def no_ray_is_shorter(seed: int, count: int, rays: int) -> None:
    rng, seen = np.random.default_rng(seed), 0
    while seen < count:
        if (device := random_device(rng)) is None:
            continue
        motions, told, _ = found(device)
        for each in told:
            least = least_of_rays(device, motions, each.order, rays)
            reached = inf if each.share is None else each.share
            assert reached <= least * (1 + 1e-9), (device, each)
            # Between two rays a straight border is as much nearer as this.
            assert least == inf or least <= reached / cos(pi / rays) * 1.02, (device, each)
        seen += 1


@pytest.mark.slow
def test_no_ray_is_shorter() -> None:
    no_ray_is_shorter(3, 2, 8)


@pytest.mark.slow
def test_no_ray_of_many_is_shorter() -> None:
    no_ray_is_shorter(11, 6, 24)


def test_derivatives_of_an_end_are_those_of_the_end_with_a_little_of_a_harmonic() -> None:
    """Along the length, with harmonics of 1e-6 of either part: the end moves by what its derivative says."""
    motions, _, _ = found(INCLINED)
    margin = next(x for x in margins_of(INCLINED, motions).margins if x.parameter is DesignInput.LENGTH)
    word, x = margin.point.motion.word, margin.point.motion
    unknown = np.array([*x.velocity, *x.time, INCLINED.length_m])
    for order in ORDERS:
        for part, slope in enumerate(margin.by_harmonics[order]):
            moved = []
            for size in (1e-6, -1e-6):
                harmonic = Harmonic(order, *(size if k == part else 0.0 for k in (0, 1)))
                moved.append(_length_of_doubling(word, unknown, margin.sweep_value, harmonic))
            assert (moved[0] - moved[1]) / 2e-6 == pytest.approx(slope, rel=1e-6)


def _length_of_doubling(word, guess, length, harmonic):
    """The length at which the period doubles, by Newton's method on the residuals and the trace in differences."""

    class AtLength:
        def at(self, varied):
            groups = INCLINED.groups(Parameter.LENGTH, varied[0])
            return groups._replace(harmonics=(harmonic,))

    def equations(x):
        return np.array([*residuals(word, x, AtLength()), trace(word, x, AtLength()) + 1 + 0.5**4])

    x = np.array([*guess[:4], length])
    for _ in range(20):
        value = equations(x)
        jacobian = np.array([(equations(x + h) - equations(x - h)) / 2e-7 for h in 1e-7 * np.eye(5)]).T
        x = x - np.linalg.solve(jacobian, value)
    return x[-1]


def test_the_second_harmonic_moves_the_papers_device_as_published_theory_says() -> None:
    """At 45 degrees and 0.6934 m, 2 % of the second harmonic take 2.6 % of frequency at the worst phase."""
    _, told, nearest = found(INCLINED)
    assert nearest.parameter is DesignInput.FREQUENCY
    per_percent = {order: hypot(*slopes) / 100 / nearest.sweep_value for order, slopes in nearest.by_harmonics.items()}
    assert 2 * per_percent[2] == pytest.approx(0.026, abs=5e-4)
    assert 5 * per_percent[3] == pytest.approx(0.040, abs=2e-3)
    assert [each.order for each in told] == [2, 3]
    assert told[0].share == pytest.approx(0.0385, abs=5e-5)
    assert told[0].phase_deg == pytest.approx(225.7, abs=0.05)
    # To first order, the margin over what a share takes of it, where the border is straight.
    assert told[0].share == pytest.approx(-nearest.distance / hypot(*nearest.by_harmonics[2]), rel=0.02)


def test_a_device_without_a_stable_motion_has_none() -> None:
    motions, _, _ = motions_at(replace(INCLINED, length_m=0.3718), Parameter.LENGTH)
    assert distortions(replace(INCLINED, length_m=0.3718), motions) == ()


@pytest.mark.parametrize("seed", range(3))
def test_the_force_is_what_its_wave_says(seed: int) -> None:
    """Derivatives of path and impulse are the impulse and the force; phases without acceleration are all there are."""
    rng = np.random.default_rng(seed)
    harmonics = tuple(Harmonic(int(k), *rng.normal(0, 0.4, 2)) for k in rng.choice(np.arange(2, 9), 2, replace=False))
    x, h = rng.uniform(0, 2 * pi, 50), 1e-5
    here, (before, after) = wave(np.sin(x), np.cos(x), harmonics), (
        wave(np.sin(x + way), np.cos(x + way), harmonics) for way in (-h, h)
    )  # fmt: skip
    np.testing.assert_allclose((after.impulse - before.impulse) / (2 * h), here.force, atol=1e-8)
    np.testing.assert_allclose((before.path - after.path) / (2 * h), here.impulse, atol=1e-8)
    grid, gbar = np.linspace(0, 2 * pi, 20001), float(rng.uniform(0, 0.8))
    signs = gbar + wave(np.sin(grid), np.cos(grid), harmonics).force > 0
    crossed = grid[:-1][signs[1:] != signs[:-1]]
    zeros = unaccelerated(gbar, harmonics)
    assert all(min(abs(zero - near) for zero in zeros) < 1e-3 for near in crossed)
    assert all(abs(gbar + wave(sin(zero), cos(zero), harmonics).force) < 1e-2 for zero in zeros)


@pytest.mark.parametrize("share", [1e-12, 1e-6, 0.05, 0.5])
def test_turning_points_are_those_of_the_flights(share: float) -> None:
    device = replace(INCLINED, length_m=0.2, inclination_deg=20.0)
    motion = motions_at(device, Parameter.LENGTH)[0].motion(0, 1)
    groups = device.groups(Parameter.LENGTH, 0.2).as_floats()._replace(harmonics=(Harmonic(3, share, share),))
    velocity, start = groups.after(1, float(motion.velocity[0])), float(motion.time[0])
    begun = groups.wave(pi * start, FLOATS)
    t = np.linspace(0, float(motion.time[1]) - start, 40001)
    waves = wave(np.sin(pi * (start + t)), np.cos(pi * (start + t)), groups.harmonics)
    speed = velocity + groups.gbar * t + (waves.impulse - begun.impulse) / pi
    seen = start + t[:-1][speed[1:] * speed[:-1] < 0]
    told = [turn.time for turn in turns(motion, groups) if turn.after == 0]
    assert len(seen) == len(told)
    np.testing.assert_allclose(told, seen, atol=1e-4)


def test_derivatives_by_what_varies_are_differences() -> None:
    motions, _, _ = found(UNEQUAL)
    motion, ray = motions.motion(0, 1), Ray.of(UNEQUAL, 3, 0.7, FLOATS)
    x = np.array([*motion.velocity, *motion.time, 0.02])
    _, matrix = linearised(motion.word, x, ray)
    steps = 1e-6 * np.eye(5)
    columns = [(linearised(motion.word, x + h, ray)[0] - linearised(motion.word, x - h, ray)[0]) / 2e-6 for h in steps]
    np.testing.assert_allclose(matrix, np.array(columns).T, atol=1e-8)


@pytest.mark.slow
def test_what_is_found_does_not_hang_on_the_first_ray() -> None:
    for device in (INCLINED, NEAR_PITCHFORK):
        motions, told, _ = found(device)
        for one, other in zip(told, distortions(device, motions), strict=True):
            assert one.share == pytest.approx(other.share, rel=1e-9)


def test_a_pitchfork_at_which_another_motion_takes_over_is_no_end() -> None:
    """Just beyond the pitchfork of the level capsule a little of the third harmonic leads through it, and goes on."""
    device = replace(LEVEL, length_m=0.41)
    motions, told, _ = found(device)
    motion = motions.motion(0, 1)
    phase = radians(told[1].phase_deg)
    curve = Curve(motion.word, Ray.of(device, 3, phase, FLOATS), -1.0, 1.0, 1.0)
    (first, *_), (last, x, *_) = ends_on_curve(curve, motion, 1.0, True)
    assert first is Event.PITCHFORK
    assert told[1].event is last is not Event.PITCHFORK
    assert told[1].share == pytest.approx(float(x[-1]), rel=1e-6)


def test_a_pitchfork_moves_with_the_third_harmonic_and_opens_with_the_second() -> None:
    motions, _, _ = found(LEVEL)
    margin = next(x for x in margins_of(LEVEL, motions).margins if x.parameter is DesignInput.LENGTH and x.taken_over)
    assert margin.by_harmonics[2] is None
    velocity, start = float(margin.point.closed.velocity_bottom), margin.point.closed.phi_bottom / pi

    def length_at(harmonic: Harmonic) -> float:
        """Where the symmetric motion has the multiplier 1, by Newton's method on half its conditions and the trace."""

        class AtLength:
            def at(self, varied):
                return LEVEL.groups(Parameter.LENGTH, varied[0])._replace(harmonics=(harmonic,))

        def equations(y: np.ndarray) -> np.ndarray:
            x = [y[0], -y[0], y[1], y[1] + 1, y[2]]
            half = residuals(margin.point.motion.word, x, AtLength())[:2]
            return np.array([*half, trace(margin.point.motion.word, x, AtLength()) - 1 - 0.5**4])

        y = np.array([velocity, start, margin.sweep_value])
        for _ in range(20):
            jacobian = np.array([(equations(y + h) - equations(y - h)) / 2e-7 for h in 1e-7 * np.eye(3)]).T
            y = y - np.linalg.solve(jacobian, equations(y))
        return float(y[2])

    for part, slope in enumerate(margin.by_harmonics[3]):
        ends = [length_at(Harmonic(3, *(size if k == part else 0.0 for k in (0, 1)))) for size in (1e-6, -1e-6)]
        assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(slope, rel=1e-5)


def test_a_motion_with_a_harmonic_is_one_of_its_flights() -> None:
    """An even harmonic parts the flights of a level capsule, an odd one does not."""
    stable = stable_ones(LEVEL, motions_at(LEVEL, Parameter.LENGTH)[0])
    for order, symmetric in ((2, False), (3, True)):
        harmonic = Harmonic(order, 0.03, -0.02)
        (left,) = with_harmonic(LEVEL, stable, harmonic)
        assert (left.u == 0) is symmetric
        ray = Ray.of(LEVEL, order, atan2(0.02, 0.03), FLOATS)
        missed = residuals(left.motion.word, [*left.motion.velocity, *left.motion.time, hypot(0.03, 0.02)], ray)
        assert max(map(abs, missed)) < 1e-10
    assert (
        with_harmonic(
            INCLINED, stable_ones(INCLINED, motions_at(INCLINED, Parameter.LENGTH)[0]), Harmonic(2, -0.04, 0.04)
        )
        == []
    )
