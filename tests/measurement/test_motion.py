"""What a record shows of the motion, held against simulated impacts whose velocities are known."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from synthetic import EXAMPLES, device_of, in_force_time, slow_sweep, truth

from vireport import load, loads
from vireport.measurement.identification import NoFit, Unidentifiable
from vireport.measurement.motion import ForceMaximum, Measured, Quantity, measured
from vireport.measurement.records import Record
from vireport.physics.device import Device
from vireport.physics.word import Word
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.cycles import SimulatedMotion
from vireport.simulation.events import BOTTOM, Impact

REGIMES = {
    "1:1": ("inclined", {}, "BT", 1),
    "2:1": ("inclined", {"device__length_m": 0.3}, "BBT", 1),
    "doubled": ("inclined", {"device__length_m": 0.60}, "BTBT", 2),
    "capsule recoils": ("inclined", {"device__capsule": "free"}, "BT", 1),
    "unlike membranes": (
        "inclined",
        {"device__restitution": None, "device__restitution_bottom": 0.52, "device__restitution_top": 0.47},
        "BT",
        1,
    ),
    "no sine": ("inclined", {"excitation__harmonics": [{"order": 2, "percent": 5.0, "phase_deg": 225}]}, "BTBT", 2),
}
"""Example, what is set over it, and the word and forcing periods of the motion that the simulation comes to."""

START = Impact(BOTTOM, 1.0, 0.3)


@cache
def regime(name: str, impacts: int = 240, skipped: int = 1500):
    example, over, letters, periods = REGIMES[name]
    device = device_of(example, **over)
    known = in_force_time(truth(device, impacts, skipped, START), device)
    return device, known, Word.of(letters, periods)


def simulated(device: Device) -> SimulatedMotion:
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    cycle = find_attractor(groups, START, compiled=False).cycle
    assert cycle is not None
    return cycle


def expected(device: Device, found: Measured) -> np.ndarray:
    """The simulated values of the impacts of a measured motion, each that of the nearest phase and velocity."""
    cycle, motion = simulated(device), found.motion
    groups = device.groups(Parameter.LENGTH, device.length_m)
    unit = float(device.velocity_unit(Parameter.LENGTH, device.length_m))
    after = np.where(cycle.wall > 0, groups.after(1, cycle.velocity), groups.after(-1, cycle.velocity))
    flight = np.roll(cycle.flight, -1)
    rows = np.stack([cycle.velocity, after, cycle.phase, flight, unit * cycle.velocity, unit * after])
    phases, speeds = motion.values[Quantity.PHASE], motion.values[Quantity.BEFORE]
    apart = np.abs(np.exp(1j * phases[:, None]) - np.exp(1j * cycle.phase)) + np.abs(speeds[:, None] - cycle.velocity)
    return rows[:, np.argmin(apart, axis=1)]


def off(device: Device, found: Measured) -> np.ndarray:
    """Differences of a measured motion from the simulated one."""
    apart = found.motion.values - expected(device, found)
    apart[Quantity.PHASE] = (apart[Quantity.PHASE] + np.pi) % (2 * np.pi) - np.pi
    return apart


@pytest.mark.parametrize("name", REGIMES)
def test_exact_times_give_the_word_and_the_values_of_the_simulation(name):
    device, known, word = regime(name)
    found = measured(device, Record("x", known.times, known.walls), None, ForceMaximum(0.0))
    assert found.motion.word == word.canonical()
    assert np.abs(off(device, found)).max() < 1e-8
    # Not only their mean: every impact by itself.
    after = found.values[Quantity.AFTER, :-1] / found.values[Quantity.BEFORE, :-1]
    bottom, top = (float(device.value_of(x)) for x in (DesignInput.RESTITUTION_BOTTOM, DesignInput.RESTITUTION_TOP))
    assert after[1:] == pytest.approx(-np.where(found.walls > 0, bottom, top)[1:-1], abs=1e-7)


@pytest.mark.parametrize("first", [1, 2])
def test_it_does_not_matter_with_which_impact_a_record_begins(first):
    device, known, word = regime("2:1", 60)
    found, later = (
        measured(device, Record("x", known.times[k:], known.walls[k:]), None, ForceMaximum(0.0)).motion
        for k in (0, first)
    )
    assert later.word == found.word == word.canonical()
    assert later.values == pytest.approx(found.values, abs=1e-7)


def noisy(known, rng: np.random.Generator, error: float, missed: float = 0.0) -> Record:
    kept = rng.random(len(known.times)) >= missed
    return Record("x", (known.times + error * rng.standard_normal(len(kept)))[kept], known.walls[kept])


def test_times_of_unlike_errors_count_by_them():
    """What is said of motions holds with some poor times as well, and poor times have poor phases."""
    device, known, word = regime("1:1", 120)
    rng, rows, poor = np.random.default_rng(4), [], np.arange(120) % 6 == 1
    errors = np.where(poor, 1e-3, 5e-5)
    for _ in range(8):
        record = Record("x", known.times + errors * rng.standard_normal(120), known.walls, errors=errors)
        found = measured(device, record, None, ForceMaximum(0.0))
        assert found.motion.word == word.canonical()
        rows.append((off(device, found) / found.motion.errors)[[0, 1, 2, 3]].ravel())
    assert 0.6 < np.sqrt(np.mean(np.square(rows))) < 1.4
    phase = found.errors[Quantity.PHASE]
    assert phase[poor].mean() > 10 * phase[~poor].mean()


def scores(name: str, count: int, seed: int = 0) -> np.ndarray:
    """Differences from the truth over their standard errors, of some records: a row for each."""
    device, known, word = regime(name)
    rng, rows = np.random.default_rng(seed), []
    for _ in range(count):
        found = measured(device, noisy(known, rng, rng.choice([2e-5, 1e-4, 5e-4]), 0.01), None, ForceMaximum(0.0))
        assert found.motion.word == word.canonical()
        rows.append((off(device, found) / found.motion.errors)[[0, 1, 2, 3]].ravel())
    return np.array(rows)


def test_noisy_times_are_off_by_no_more_than_their_errors_allow():
    found = scores("1:1", 6)
    assert np.abs(found).max() < 4.5
    assert 0.6 < np.sqrt(np.mean(found**2)) < 1.4  # neither too wide nor too narrow


@pytest.mark.slow
@pytest.mark.parametrize("name", ["1:1", "2:1"])
def test_intervals_of_95_per_cent_cover_the_truth(name):
    found = scores(name, 60, 1)
    assert 0.92 < np.mean(np.abs(found) < 1.96) < 0.98
    assert np.abs(found.mean(axis=0)).max() < 0.5  # means of 60, with a deviation of 0.13


def test_errors_of_inputs_are_carried_to_velocities_in_both_units():
    device, known, _ = regime("1:1")
    record = noisy(known, np.random.default_rng(4), 1e-5)
    unsure = load_tolerances("{amplitude_percent: 2, distribution: normal}")
    exact, wide = (measured(device, record, block, ForceMaximum(0.0)).motion for block in (None, unsure))
    # Without any the two units differ by a factor; a force that is not known changes the flights and the unit.
    unit = float(device.velocity_unit(Parameter.LENGTH, device.length_m))
    assert exact.values[Quantity.BEFORE_SI] == pytest.approx(unit * exact.values[Quantity.BEFORE], rel=1e-12)
    assert exact.errors[Quantity.BEFORE_SI] == pytest.approx(unit * exact.errors[Quantity.BEFORE], rel=1e-6)
    stronger = device.with_values({DesignInput.AMPLITUDE: float(device.amplitude_n) * (1 + 0.02 / 3)})
    moved = measured(stronger, record, None, ForceMaximum(0.0)).motion
    for quantity in (Quantity.BEFORE, Quantity.AFTER, Quantity.BEFORE_SI, Quantity.AFTER_SI):
        shift = np.abs(moved.values[quantity] - exact.values[quantity])
        assert wide.errors[quantity] == pytest.approx(np.hypot(shift, exact.errors[quantity]), rel=0.05)


def load_tolerances(block: str):
    text = (
        "schema_version: 1\ndevice: {capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 0.7}\n"
        f"excitation: {{amplitude_n: 3.0, frequency_hz: 2.0}}\ninclination_deg: 45.0\ntolerances: {block}\n"
    )
    return loads(text).scenario.tolerances


def test_an_error_of_the_reference_is_one_of_all_phases():
    device, known, _ = regime("1:1")
    record = noisy(known, np.random.default_rng(5), 1e-5)
    sure, unsure = (measured(device, record, None, ForceMaximum(0.0, error)).motion for error in (0.0, 1e-3))
    turned = 2 * np.pi * float(device.frequency_hz) * 1e-3
    # What the record says of the phase itself, by the motion being one of constant restitutions, is little.
    assert unsure.errors[Quantity.PHASE] == pytest.approx(np.full(2, turned), rel=0.02)
    assert sure.errors[Quantity.PHASE].max() < 0.01 * turned


def test_without_a_reference_the_phase_is_fitted():
    device, known, _ = regime("2:1")
    late = Record("x", known.times[:60] + 3.21, known.walls[:60])
    found = measured(device, late, None, None)
    assert np.abs(off(device, found)).max() < 1e-6


def test_chaos_has_no_word():
    device = device_of("inclined", device__length_m=0.42)
    known = in_force_time(truth(device, 150, 100, START), device)
    found = measured(device, noisy(known, np.random.default_rng(1), 1e-4), None, ForceMaximum(0.0))
    assert found.motion is None
    assert np.isfinite(found.values[:, 1:-1]).all()


def test_what_settles_has_the_word_of_its_end_only():
    device = device_of("inclined")
    known = in_force_time(truth(device, 240, 0, Impact(BOTTOM, 0.4, 2.0)), device)
    found = measured(device, noisy(known, np.random.default_rng(2), 2e-5), None, ForceMaximum(0.0))
    assert found.motion.from_s > known.times[5]
    assert np.abs(off(device, found) / found.motion.errors).max() < 5
    # The transient is no part of the mean, and is told as single impacts.
    assert np.ptp(found.values[Quantity.BEFORE, found.walls > 0][1:]) > 0.01


def test_other_devices_and_short_records_show_nothing():
    device, known, _ = regime("1:1")
    record = Record("x", known.times, known.walls)
    other = device.with_values({DesignInput.INCLINATION: 5.0})
    assert isinstance(measured(other, Record("x", known.times, -known.walls), None, ForceMaximum(0.0)), NoFit)
    with pytest.raises(Unidentifiable) as refused:
        measured(device, Record("x", record.times[:8], record.walls[:8]), None, ForceMaximum(0.0))
    assert refused.value.left_open.impacts == 12


@pytest.mark.slow
def test_a_slow_sweep_shows_hysteresis_with_the_words_of_the_simulation():
    lengths = (0.216, 0.223, 0.226, 0.233, 0.226, 0.223, 0.216)
    device = device_of("hysteresis")
    known, held = slow_sweep(device, lengths, 80, START)
    times = known.times + 1e-4 * np.random.default_rng(3).standard_normal(len(held))
    words = []
    for k, length in enumerate(lengths):
        rows = slice(80 * k, 80 * (k + 1))
        own = device.with_values({DesignInput.LENGTH: length})
        words.append(measured(own, Record("x", times[rows], known.walls[rows]), None, ForceMaximum(0.0)).motion.word)
    assert [word.ratio for word in words] == ["3:1", "3:1", "3:1", "2:1", "2:1", "2:1", "3:1"]


def test_the_example_is_the_slow_sweep_that_its_page_tells():
    scenario = load(EXAMPLES / "measured-sweep.yaml").scenario
    rows = (EXAMPLES / "measured-sweep.csv").read_text().splitlines()[1:]
    lengths = [0.216, 0.22, 0.223, 0.226, 0.229, 0.233, 0.229, 0.226, 0.223, 0.22, 0.216]
    known, held = slow_sweep(Device.of(scenario), lengths, 80, START)
    times, walls, columns = zip(*(row.split(",") for row in rows), strict=True)
    errors = np.array(times, dtype=float) - known.times
    assert [float(value) for value in columns] == held.tolist()
    assert list(walls) == ["bottom" if wall > 0 else "top" for wall in known.walls]
    assert errors.std() == pytest.approx(1e-4, rel=0.1)
    assert np.abs(errors).max() < 5e-4
