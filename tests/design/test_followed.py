"""Stable motions of any word, followed along an input: against the simulation at the design point and at their ends."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import solved
from exact_device import ExactDevice
from mpmath import mp
from msgspec.structs import replace

from vireport.design.followed import followed_motion
from vireport.design.from_rest import FromRest
from vireport.design.switched_on import switched_on_at_once
from vireport.motions.events import Event
from vireport.physics.device import Device
from vireport.physics.groups import Restitutions
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import start_of

BESIDE = 2e-4
"""Share of the value of an input by which devices are off the end of a motion."""


@pytest.mark.parametrize(
    ("over", "word", "periods", "ends"),
    [
        ({"device__length_m": 0.3718}, "BBTBBT", 3, (Event.GRAZING, Event.GRAZING)),
        ({"device__length_m": 0.3}, "BBT", 1, (Event.PERIOD_DOUBLING, Event.FOLD)),
        ({"device__length_m": 0.5}, "BBT", 2, (Event.PERIOD_DOUBLING, Event.FOLD)),
    ],
)
def test_the_motion_from_rest_is_that_of_its_equations_and_ends_where_the_simulation_loses_it(
    over: dict[str, float], word: str, periods: int, ends: tuple[Event, Event]
) -> None:
    solution = solved("inclined", **over)
    found = switched_on_at_once(solution)
    end, reached = found.from_rest, found.motion_from_rest
    assert (reached.motion.word.letters, reached.motion.word.periods) == (word, periods) == (end.word, end.periods)
    assert end.cycle.motion(0.0).distance(reached.motion) < 1e-6
    assert reached.multipliers == pytest.approx(end.cycle.multipliers, rel=1e-5, abs=1e-9)
    assert reached.growth == pytest.approx(end.cycle.growth, rel=1e-5)
    assert (reached.below, reached.above) == ends
    assert reached.varied is DesignInput.LENGTH
    for value, outward in ((reached.low, -1), (reached.high, 1)):
        assert simulated_word(solution.device, end, value * (1 - outward * BESIDE)) == word
        assert simulated_word(solution.device, end, value * (1 + outward * BESIDE)) != word


@pytest.mark.parametrize(
    "over",
    [
        {"device__length_m": 0.3},
        {"device__length_m": 0.3718},
        {"device__length_m": 0.75, "excitation__amplitude_n": 3.6, "device__restitution": Restitutions(0.475, 0.525)},
    ],
)
def test_the_motion_from_rest_is_within_its_error_bounds_of_one_in_forty_digits(over: dict[str, object]) -> None:
    over = dict(over)
    restitution = over.pop("device__restitution", 0.5)
    device = replace(solved("inclined", **over).device, restitution=restitution)
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    end = find_attractor(groups, start_of(np.array([1.0, 0.0, 0.0, float(np.arccos(-groups.gbar))])), 4000)
    found = followed_motion(device, end.cycle.motion(0.0), DesignInput.LENGTH)
    motion = found.motion
    with mp.workdps(40):
        raw, word = ExactDevice(device), motion.word
        x = [mp.mpf(float(value)) for value in (*motion.velocity, *motion.time)]
        exact = mp.findroot(lambda *x: raw.missed(*x, period=2 * word.periods, walls=word.walls), x, tol=1e-60)
        away = np.array([float(abs(a - b)) for a, b in zip(exact, x, strict=True)])
    bounds = np.concatenate([found.velocity_error, found.time_error])
    assert (away <= bounds).all()
    assert (bounds < 1e-11).all()


def test_only_stable_motions_are_followed_and_from_the_least_inclination_upwards_alone() -> None:
    """A horizontal capsule's two symmetric motions, which are no mirror images of each other any more as it tilts."""
    solution = solved("horizontal", device__length_m=0.5554, excitation__amplitude_n=5.0)
    here, highs = solution.design.motions, []
    assert set(here.stable_mask) == {True, False}
    for row, stable in enumerate(here.stable_mask):
        found = followed_motion(solution.device, here.motion(row, 1), DesignInput.INCLINATION)
        assert (found is not None) == stable
        if found is not None:
            assert (found.low, found.below) == (0.0, Event.SWEEP_END)
            highs.append(found.high)
    ends = [x.sweep_value for x in solution.design.endings() if x.parameter is DesignInput.INCLINATION]
    assert sorted(highs) == pytest.approx(sorted(ends), rel=1e-11)


def simulated_word(device: Device, end: FromRest, length: float) -> str:
    """The motion at another length, by simulation alone: gone to slowly from that at the design point."""
    cycle = end.cycle
    for value in device.length_m + (length - device.length_m) * (1 - np.linspace(1, 0, 12) ** 3):
        groups = device.groups(Parameter.LENGTH, float(value)).as_floats()
        start = np.array([cycle.wall[0], 0.0, cycle.velocity[0], cycle.phase[0]])
        cycle = find_attractor(groups, start_of(start), 4000).cycle
        if cycle is None:
            return ""
    return str(cycle.word)


def test_a_motion_on_one_membrane_is_there_at_any_greater_length() -> None:
    """It ends where the top comes so near that the ball grazes it, and is followed to ten times the length."""
    over = {"device__length_m": 1.3838911, "excitation__amplitude_n": 2.83326937, "inclination_deg": 36.702719}
    solution = solved("design-point", **over, device__restitution=0.01)
    reached = switched_on_at_once(solution).motion_from_rest
    assert set(reached.motion.word.letters) == {"B"}
    assert reached.varied == DesignInput.LENGTH
    assert (reached.below, reached.above) == (Event.GRAZING, Event.SWEEP_END)
    assert reached.high == pytest.approx(13.838911)
    assert reached.ends == ("grazing", "followed no farther")


def test_a_motion_on_a_table_is_followed_along_the_force() -> None:
    """As its length moves no motion there."""
    over = {"device__length_m": 1.3838911, "excitation__amplitude_n": 2.83326937, "inclination_deg": 36.702719}
    solution = solved("design-point", **over, device__restitution=0.01, device__ball_mass_kg=None)
    assert switched_on_at_once(solution).motion_from_rest.varied == DesignInput.AMPLITUDE


def test_a_ball_that_does_not_bounce_is_not_followed() -> None:
    """Its impacts forget what was before, and no curve leads from one motion to the next."""
    solution = solved("inclined", device__length_m=0.3)
    motion = switched_on_at_once(solution).motion_from_rest.motion
    assert followed_motion(replace(solution.device, restitution=0.0), motion, DesignInput.LENGTH) is None


def test_where_a_one_to_one_motion_is_stable_nothing_else_is_followed() -> None:
    assert switched_on_at_once(solved("inclined")).motion_from_rest is None
    assert switched_on_at_once(solved("inclined", excitation__amplitude_n=0.8)).motion_from_rest is None  # at rest


@pytest.mark.slow
def test_the_fold_of_a_followed_motion_does_not_hang_on_rounding() -> None:
    """The period-two motion of membranes with 0.47 and 0.54, from starts that differ in the last bits."""
    device = replace(solved("inclined", device__length_m=0.72).device, restitution=Restitutions(0.47, 0.54))
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    end = find_attractor(groups, start_of(np.array([1.0, 0.0, 0.0, float(np.arccos(-groups.gbar))])), 4000)
    motion, rng = end.cycle.motion(0.0), np.random.default_rng(0)
    assert motion.word.letters == "BTBT"
    for _ in range(6):
        velocity = motion.velocity * (1 + 2.2e-16 * rng.integers(-2, 3, 4))
        found = followed_motion(device, replace(motion, velocity=velocity), DesignInput.LENGTH)
        assert (found.below, found.above) == (Event.PERIOD_DOUBLING, Event.FOLD)
        assert found.high == pytest.approx(0.7599, abs=1e-4)
