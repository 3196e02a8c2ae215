"""The device of a scenario driven by a recorded acceleration of the shaker, impact by impact.

The acceleration is the cubic spline of the samples, for which the flight between two impacts is exact. At the beginning
of the record the ball lies on the bottom membrane; impacts while the motion settles are left out. As the motion need
not be periodic, the results are counts and means, with intervals, and no bifurcations.
"""

from __future__ import annotations

from collections import Counter
from math import ceil, pi
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError, UsageError
from vireport.base.progress import Progress
from vireport.base.records import brief
from vireport.design.solution import Solution, solution_of, stable_motion
from vireport.findings.driven.means import Mean, batched, parts_of
from vireport.measurement.recordings import HeardPlace, Recording, Unbroken, read_recording
from vireport.measurement.shaker import ShakerFinding, ShakerMotion, shaker_findings
from vireport.measurement.signals import shaken, shaker_of
from vireport.motions.one_to_one import impact_velocities
from vireport.physics.cubics import Cubics
from vireport.physics.device import Device
from vireport.physics.energy import Membrane, deflection, energy_gained, generated_voltage
from vireport.physics.word import Word
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import Impact, check_model, check_start, follow_recorded
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, TURN, VELOCITY, WALL
from vireport.text.foreign import visible

Floats = NDArray[np.float64]

KEY = "excitation.record"

SETTLED, SETTLING_PERIODS, MOST_SETTLING = 0.1, 40.0, 0.5
"""Share of the record after which the motion counts, but after so many periods of the force if that is more, and no
more than so much of the record."""

LARGEST_PHASE = 0.01
"""By how much times may be off an even clock, on which samples are put, in the phase of the force [rad]: by so much of
its amplitude the acceleration is wrong then."""

LARGEST_RESAMPLED = 0.05
"""Share of the amplitude by which samples may be wrong that were put on an even clock by splines."""

LONGEST_BRIDGED = TURN / 20
"""Phase of the force [rad] in which samples may be missing: a spline goes on over so much of a sine."""

MOST_IMPACTS = 300
"""In a period of the force: beyond, hops are followed that cannot be told from rest."""

COMPILED = 100_000
"""Samples from which on the search is compiled: less is done sooner without."""

RESTS = "rest"
"""Stands for the word of a period in which the ball comes to rest on a membrane."""


class WordShare(Struct, frozen=True):
    """How often a word was seen: its letters, "" without an impact, and its share of the periods."""

    letters: str
    share: float


class Prediction(Struct, frozen=True):
    """The stable 1:1 motion under the harmonic force that was fitted to the record.

    Attributes
    ----------
    speed_bottom_m_s, speed_top_m_s : float
        Speeds just before the impacts [m/s].
    impacts_per_s : float
        Impacts in a second [1/s].
    voltage_per_s, power_mw : float or None
        Sum of the gains of voltage in a second [V/s], and mean power [mW]; None where they are not evaluated.
    """

    speed_bottom_m_s: float
    speed_top_m_s: float
    impacts_per_s: float
    voltage_per_s: float | None
    power_mw: float | None


class Driven(Struct, frozen=True, eq=False):
    """What a device does under a recorded motion of its shaker.

    Attributes
    ----------
    recording : Recording
    shaker : ShakerMotion
        The sine and harmonics that were fitted to the record.
    device : Device
        The device of the scenario under the fitted force.
    settled_s : float
        Time on the record's clock from which on the motion counts [s].
    periods : int
        Number of periods of a 1:1 motion, each n forcing periods, that count.
    times_s, walls, speeds_m_s, phases : ndarray, shape (k,)
        Of the impacts that count: on the record's clock [s]; 1 bottom, -1 top; relative speed [m/s]; phase of the
        fitted force [rad].
    words : tuple of WordShare
        The words of the periods, the most frequent first, each as the alphabetically first of its rotations.
    rests : float
        Share of the periods in which the ball comes to rest on a membrane.
    impacts_per_s : Mean
        Impacts in a second [1/s].
    speed_bottom_m_s, speed_top_m_s : Mean or None
        Mean speeds [m/s]; None without an impact there.
    voltage_per_s, power_mw : Mean or None
        Sum of the gains of voltage in a second [V/s], and mean power [mW]; None where they are not evaluated.
    deepest_m : float or None
        Largest deflection of a membrane [m].
    predicted : Prediction or None
        None where there is no stable 1:1 motion.
    doubts : tuple of ShakerFinding
        What may be wrong with the record, compared with the scenario.
    resampled : float or None
        Error of the samples from putting them on an even clock, as a share of the amplitude; None where they were on
        one.
    """

    recording: Recording
    shaker: ShakerMotion
    device: Device
    settled_s: float
    periods: int
    times_s: Floats
    walls: Floats
    speeds_m_s: Floats
    phases: Floats
    words: tuple[WordShare, ...]
    rests: float
    impacts_per_s: Mean
    speed_bottom_m_s: Mean | None
    speed_top_m_s: Mean | None
    voltage_per_s: Mean | None
    power_mw: Mean | None
    deepest_m: float | None
    predicted: Prediction | None
    doubts: tuple[ShakerFinding, ...] = ()
    resampled: float | None = None

    __repr__ = brief

    @property
    def share_of_1_1(self) -> float:
        """Share of the periods with one impact on each membrane."""
        return sum(row.share for row in self.words if row.letters == "BT")


def driven_by(loaded: Loaded, device: Device, membrane: Membrane | None, say: Progress | None = None) -> Driven:
    """Drive a device with a recorded acceleration.

    Parameters
    ----------
    loaded : Loaded
        The scenario that names the record.
    device : Device
        The device of the scenario; its force and frequency are replaced by those fitted to the record.
    membrane : Membrane or None
        For voltages.
    say : callable, optional
        Called with each step as it begins.

    Raises
    ------
    UsageError, ScenarioError
        If the record cannot be used, or the device has a feature that is not modelled under such a force.
    NumericalError
        If the ball does not cease to bounce.
    """
    say = say or (lambda what: None)
    if device.rubs:
        raise UsageError(f"{KEY} is not driven through a device with friction (allowed: none, without device.friction)")
    say("reading the record of the shaker")
    record = loaded.scenario.excitation.record
    assert record is not None
    # A report names the record as its scenario does, not by the folder of the scenario.
    recording = replace(read_recording(record, loaded.place, loaded.scenario.record), name=visible(record))
    shaker = shaker_of(recording, device, say)
    if shaker is None or shaker.channel.place is not HeardPlace.CAPSULE:
        raise UsageError(f"{KEY}: {recording.name} has no acceleration (allowed: a signal acceleration_m_s2 or _g)")
    rate = TURN * shaker.frequency_hz
    gaps = [(after.start_s - float(recording.times[after.first - 1])) * rate for after in recording.stretches[1:]]
    if gaps and max(gaps) > LONGEST_BRIDGED:
        lost = recording.stretches[gaps.index(max(gaps)) + 1].start_s
        allowed = f"gaps of up to {100 * LONGEST_BRIDGED / TURN:g} % of a period, which are bridged"
        raise UsageError(f"{KEY}: {recording.name} lacks samples before {lost:.6g} s (allowed: {allowed})")
    resampled = None
    # A sample that is late by t has the acceleration of a phase that is later by 2 pi f t.
    if gaps or not recording.even or rate * recording.uneven_s > LARGEST_PHASE:
        recording, error = _resampled(recording)
        resampled = error / shaker.amplitude
        if resampled > LARGEST_RESAMPLED:
            wrong = f"put on an even clock it would be wrong by up to {100 * resampled:.2g} % of its amplitude"
            allowed = f"(allowed: {100 * LARGEST_RESAMPLED:g} %; sample faster)"
            raise UsageError(f"{KEY}: {recording.name}: its times are uneven; {wrong} {allowed}")
        shaker = shaker_of(recording, device, say) or shaker
    driven_device = shaken(device, shaker)
    say("driving the record through the device")
    followed = _followed(recording, shaker, driven_device)
    answer = _counted(recording, shaker, driven_device, membrane, followed)
    return replace(answer, doubts=shaker_findings(recording, shaker, device), resampled=resampled)


def _resampled(recording: Recording) -> tuple[Recording, float]:
    """A recording on an even clock, by cubic splines, and the error of its acceleration [m/s^2].

    The error is the larger root mean square by which the splines through every other sample, even or odd, differ from
    the spline through all: an upper estimate, as it contains the noise of the sensor.
    """
    from scipy.interpolate import CubicSpline  # type: ignore[import-untyped]

    times = recording.times if recording.clock is None else recording.clock
    even = np.linspace(times[0], times[-1], 1 + round(float(times[-1] - times[0]) / recording.step_s))
    channels, error = [], 0.0
    for channel in recording.channels:
        values = CubicSpline(times, channel.values)(even)
        channels.append(replace(channel, values=values))
        if channel.place is HeardPlace.CAPSULE:
            inner = (even >= times[1]) & (even <= times[-2])
            halves = (CubicSpline(times[k::2], channel.values[k::2])(even[inner]) for k in (0, 1))
            error = max(float(np.sqrt(np.mean((half - values[inner]) ** 2))) for half in halves)
    stretch = Unbroken(0, len(even), float(even[0]))
    step = float(even[-1] - even[0]) / (len(even) - 1)
    made = replace(recording, step_s=step, stretches=(stretch,), channels=tuple(channels), clock=None, even=True)
    return made, error


class _Followed(NamedTuple):
    """A ball followed through a record.

    Attributes
    ----------
    rows : ndarray, shape (k, 6)
        Its impacts, as rows of the simulation.
    clock : ndarray, shape (k,)
        Their times since the first sample [t_c].
    phase : float
        Phase of the fitted force at the first sample [rad].
    """

    rows: Floats
    clock: Floats
    phase: float


def _followed(recording: Recording, shaker: ShakerMotion, device: Device) -> _Followed:
    """Drive a device with the samples of a record, beginning with the ball on the bottom membrane.

    Raises
    ------
    NumericalError
        If the ball does not cease to bounce.
    """
    # The samples contain the harmonics: the fitted ones must not be added a second time.
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()._replace(harmonics=())
    rate = 2 * shaker.frequency_hz
    samples = (shaker.channel.values - shaker.offset) / shaker.amplitude
    cubics = Cubics.of(samples, recording.step_s * rate, float(groups.gbar))
    phase = float(pi * rate * (recording.start_s - shaker.maximum_s) % TURN)
    begin, most = check_start(Impact(1, 0.0, phase), groups.d), MOST_IMPACTS * ceil(cubics.duration / 2)
    model = check_model(groups)[0]
    rows, summary = follow_recorded(model, begin, cubics, most, compiled=len(samples) > COMPILED)
    if summary[0] >= most:
        raise NumericalError(f"{KEY}: more than {MOST_IMPACTS} impacts in each period of the force: they are not told")
    held = rows[:, SETTLING] + rows[:, RIDING]
    # The flight time of a row is that of the flight which ends there: time on a membrane comes before the next flight.
    return _Followed(rows, np.cumsum(rows[:, FLIGHT] + np.concatenate([[0.0], held[:-1]])), phase)


def _counted(
    recording: Recording, shaker: ShakerMotion, device: Device, membrane: Membrane | None, followed: _Followed
) -> Driven:
    """Count the impacts of whole periods once the motion has settled, and form their means.

    Raises
    ------
    UsageError
        If no period is left.
    """
    rows, clock, phase = followed
    rate = 2 * shaker.frequency_hz
    end = (recording.end_s - recording.start_s) * rate
    span = 2.0 * device.period_ratio
    rested = rows[:, SETTLING] + rows[:, RIDING] > 0
    # Periods are cut at the phase farthest from impacts, and counted back from the end: an impact that jitters across a
    # cut would move from one word to the next.
    settled = min(max(SETTLED * end, 2 * SETTLING_PERIODS), MOST_SETTLING * end)
    cut = _emptiest(rows[clock > settled, PHASE])
    # The last time at which the force has the phase of the cut; a period of it is 2 t_c.
    last = end - (phase / pi + end - cut / pi) % 2
    periods = int((last - settled) / span)
    if periods < 1:
        raise UsageError(f"{KEY}: {recording.name} is too short: no period is left where the motion has settled")
    first = last - periods * span
    # The first row is the start, which is no impact.
    counted = (clock >= first) & (clock < last) & (np.arange(len(rows)) > 0)
    counted_rows, times = rows[counted], clock[counted]
    period = np.clip(((times - first) / span).astype(int), 0, periods - 1)
    # All parts have as many periods; the periods left over, at the beginning, are in no part.
    parts = max(parts_of(periods), 1)
    periods_per_part = periods // parts
    part = (period - (periods - parts * periods_per_part)) // periods_per_part
    length = np.full(parts, periods_per_part * span / rate)
    velocity_unit = float(device.velocity_unit(Parameter.LENGTH, device.length_m))
    speeds = np.abs(counted_rows[:, VELOCITY]) * velocity_unit

    def per_second(values: Floats) -> Mean:
        """Mean rate, per second, of a quantity that each impact adds to."""
        used = part >= 0
        return batched(_sums(part[used], values[used], parts), length)

    def speed(wall: float) -> Mean | None:
        used = (part >= 0) & (counted_rows[:, WALL] == wall)
        # A mean over impacts, not over time: the interval needs the number of impacts in each part.
        counts = _sums(part[used], np.ones(int(used.sum())), parts)
        return batched(_sums(part[used], speeds[used], parts), counts) if used.any() else None

    gains = None if membrane is None else generated_voltage(speeds, membrane)
    power = None
    if membrane is not None and membrane.dielectric is not None and gains is not None:
        power = per_second(1e3 * energy_gained(gains, membrane, membrane.dielectric))
    words, rests = _words(counted_rows[:, WALL], rested[counted], period, periods)
    return Driven(
        recording,
        shaker,
        device,
        recording.start_s + first / rate,
        periods,
        recording.start_s + times / rate,
        counted_rows[:, WALL],
        speeds,
        counted_rows[:, PHASE],
        words,
        rests,
        per_second(np.ones(len(counted_rows))),
        speed(1.0),
        speed(-1.0),
        None if gains is None else per_second(gains),
        power,
        None if membrane is None or not len(speeds) else float(deflection(speeds, membrane).max()),
        _predicted(solution_of(device, membrane, None, True)),
    )


def _sums(part: NDArray[np.intp], values: Floats, parts: int) -> Floats:
    """Sums of values over parts, (parts,); `part` has the number of the part of each value."""
    return np.asarray(np.bincount(part, values, parts), dtype=np.float64)


def _emptiest(phases: Floats) -> float:
    """The phase that is farthest from the phases of all impacts [rad]."""
    if not len(phases):
        return 0.0
    ordered = np.sort(phases % TURN)
    gaps = np.diff(ordered, append=ordered[0] + TURN)
    widest = int(np.argmax(gaps))
    return float((ordered[widest] + gaps[widest] / 2) % TURN)


def _words(
    walls: Floats, rested: NDArray[np.bool_], period: NDArray[np.intp], periods: int
) -> tuple[tuple[WordShare, ...], float]:
    """The shares of the words of periods, and the share of periods in which the ball comes to rest."""
    letters = np.where(walls > 0, "B", "T")
    # Impacts are in order of time, so that those of a period are neighbours.
    edges = np.searchsorted(period, np.arange(periods + 1))
    resting = set(period[rested].tolist())
    seen: Counter[str] = Counter()
    for k in range(periods):
        sequence = "".join(letters[edges[k] : edges[k + 1]])
        seen[RESTS if k in resting else sequence] += 1
    # Many periods have the same few sequences of impacts: each sequence is reduced to its word only once.
    same: Counter[str] = Counter()
    for sequence, count in seen.items():
        same[sequence if sequence in ("", RESTS) else Word.of(sequence).canonical().letters] += count
    rests = same.pop(RESTS, 0) / periods
    return tuple(WordShare(sequence, count / periods) for sequence, count in same.most_common()), rests


def _predicted(solution: Solution) -> Prediction | None:
    stable = stable_motion(solution)
    if stable is None:
        return None
    design, row = stable
    device = solution.device
    bottom, top = (abs(float(speed[row])) for speed in impact_velocities(device, design.parameter, design.motions))
    volts = design.voltages_by_motion
    gained = None if volts is None else float(volts.bottom_v[row] + volts.top_v[row]) / device.period_s
    power = None if design.conversion_by_motion is None else float(design.conversion_by_motion.power_mw[row])
    return Prediction(bottom, top, 2 / device.period_s, gained, power)
