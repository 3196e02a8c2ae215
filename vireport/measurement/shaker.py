"""The shaker's motion as it was measured: the capsule's acceleration as a sine with harmonics, with standard errors.

Linear least squares for all harmonics and Newton's steps for the frequency. What impacts add is left out: samples that
stand out of the rest. The errors are of the noise that is there around each harmonic, white or not.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from math import atan2, degrees, hypot, pi, sin, sqrt

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.base.records import ResultsBlock, brief
from vireport.measurement.flights import Array, Mask
from vireport.measurement.recordings import Channel, HeardPlace, Recording
from vireport.physics.device import Device

ORDERS = 8
"""Harmonics that are fitted, the first included."""

PARTS = 128
"""Means in a period of the force that samples are made into, where there are more."""

FEWEST_PARTS = 20
"""Samples in a period for `ORDERS` harmonics."""

FEWEST_PERIODS = 10
"""Of the force, for a frequency and the noise around it."""

WITHIN = 0.1
"""Of the frequency that is expected, where the line is looked for."""

PADDED = 4
"""Length of the spectrum in which it is looked for over that of the record."""

OUTLYING = 5.0
"""Standard deviations from which a sample is of an impact."""

ROUNDS = 30
SETTLED, FEW_CHANGE = 1e-9, 1e-3
"""Change of the phase between the ends [rad] and share of the samples that change sides, below which steps end."""

NEIGHBOURS = 2, 20
"""Distances, least and largest, in lines of the spectrum from a harmonic to those that its noise is taken from."""

SIGNIFICANT = 5.0
"""Standard errors from which a harmonic is one."""

LEAST_PERCENT = 1e-6
"""Of the sine, that a harmonic is of."""

FACTORS = 9.81, 1 / 9.81, 1000.0, 1 / 1000
"""By which an acceleration is off that is in another unit: g, one that was g and is taken for it once more, and a
thousand either way."""

NO_FACTOR = 1.5
"""Ratio of amplitudes from which the shaker moves otherwise than the scenario says."""

SAME_FACTOR = 0.1
"""Relative difference of a ratio from one of `FACTORS`: a force is set as well as that."""

TURNED_DEG = 30.0
"""Difference of the phase of an even harmonic from that of a reversed axis, which turns it by 180 degrees."""

MOST_LONE, FAR = 3, 5.0
"""Samples at most that are reported as far from the fit, and how many times as far as all others: impacts make many
such samples, and the largest of noise are alike."""

LEAST_FAR = 0.1
"""Of the amplitude, up to which no sample is far."""

FULLER = 5.0
"""Samples at the largest or least value of a signal that is clipped, over those of the value next to it: of the crests
of a sine there are less than three times as many, however coarse its steps are."""

TILTED = 0.1
"""Part of gravity by which an offset may differ from what a sensor shows that hangs upside down."""


class ShakerDoubt(StrEnum):
    """What may be wrong with a recorded acceleration."""

    FACTOR = "factor"
    FORCE = "amplitude"
    REVERSED = "reversed"
    LONE = "lone_sample"
    CLIPPED = "clipped"


class ShakerFinding(Struct, frozen=True):
    """A possible fault of a recorded acceleration: its kind, its channel, and its size.

    Attributes
    ----------
    doubt : ShakerDoubt
    channel : str
    value : float
        Factor by which the record fits the scenario; without one, ratio of the amplitudes; of a lone sample, how far it
        is from what is fitted [m/s^2]; of clipping, the share of the samples.
    at_s : float
        When [s].
    recorded, stated : float
        Amplitude of the record and of the scenario; of a lone sample its value, and how far all others are from what is
        fitted at most [m/s^2].
    """

    doubt: ShakerDoubt
    channel: str
    value: float
    at_s: float = 0.0
    recorded: float = 0.0
    stated: float = 0.0


class MeasuredHarmonic(ResultsBlock, frozen=True):
    """A harmonic of the force in a record, with standard errors.

    Attributes
    ----------
    order, percent, phase_deg : –, %, degrees
        order, and amplitude and phase in F[cos x + percent/100 cos(order x + phase)]
    percent_error, phase_error_deg : %, degrees
        standard errors
    """

    order: int
    percent: float
    phase_deg: float
    percent_error: float
    phase_error_deg: float

    @property
    def significant(self) -> bool:
        """Whether it is more than the noise, and than what rounding leaves of samples without any."""
        return self.percent > max(SIGNIFICANT * self.percent_error, LEAST_PERCENT)


class ShakerMotion(Struct, frozen=True, eq=False):
    """The capsule's acceleration, A cos x and harmonics, with standard errors; fitted to it or to a displacement.

    Attributes
    ----------
    channel : Channel
    amplitude, amplitude_error : float
        [m/s^2].
    frequency_hz, frequency_error_hz : float
    maximum_s : float
        Time at which x = 0, next to the middle of the record, where it does not depend on the frequency.
    phase_error : float
        Of x there [rad].
    harmonics : tuple of MeasuredHarmonic
        Of orders 2 to 8.
    offset : float
        Constant part [m/s^2].
    noise : float
        Standard deviation of what is left of the means [m/s^2]; of a displacement, times the square of the frequency.
    left_out : float
        Share of them that stand out.
    phases, means : Array (k,)
        x of the means and their values in the unit of the channel, for a picture.
    fitted : Array (k,)
        What is fitted there.
    """

    channel: Channel
    amplitude: float
    amplitude_error: float
    frequency_hz: float
    frequency_error_hz: float
    maximum_s: float
    phase_error: float
    harmonics: tuple[MeasuredHarmonic, ...]
    offset: float
    noise: float
    left_out: float
    phases: Array
    means: Array
    fitted: Array

    __repr__ = brief

    def at(self, times: Array) -> Array:
        """The fitted acceleration of the capsule at some times [m/s^2]."""
        x = 2 * pi * self.frequency_hz * (times - self.maximum_s)
        more = (
            harmonic.percent / 100 * np.cos(harmonic.order * x + np.radians(harmonic.phase_deg))
            for harmonic in self.harmonics
        )
        return np.asarray(self.offset + self.amplitude * (np.cos(x) + sum(more)))

    @property
    def maximum_error_s(self) -> float:
        """Standard error of `maximum_s` [s]."""
        return self.phase_error / (2 * pi * self.frequency_hz)


def shaker_motion(recording: Recording, channel: Channel, frequency_hz: float) -> ShakerMotion:
    """The acceleration of the capsule as a sine with harmonics, by a channel of it or of the displacement.

    Parameters
    ----------
    recording : Recording
    channel : Channel
        Of the capsule's acceleration [m/s^2] or displacement [m], positive towards the top.
    frequency_hz : float
        That is expected.

    Raises
    ------
    UsageError
        If the record is too short or too coarse, or has another line.
    """
    name = f"{recording.name}: {channel.name}"
    if frequency_hz * recording.step_s * FEWEST_PARTS > 1:
        raise UsageError(
            f"{name}: {1 / (frequency_hz * recording.step_s):.3g} samples in a period of the force (allowed: "
            f"{FEWEST_PARTS} and more for harmonics up to order {ORDERS})"
        )
    # Means of neighbours have less noise, and the harmonics lose only what `_design` takes into account.
    together = max(1, int(1 / (frequency_hz * recording.step_s * PARTS)))
    times, values = _means(recording, channel, together)
    span = float(times[-1] - times[0]) if len(times) else 0.0
    if span * frequency_hz < FEWEST_PERIODS:
        raise UsageError(f"{name}: {span * frequency_hz:.3g} periods of the force (allowed: {FEWEST_PERIODS} and more)")
    # From the middle of the record on, where the phase does not depend on the frequency.
    middle = float(times[0] + times[-1]) / 2
    means = _Means(times - middle, values, together * recording.step_s, span)
    omega = 2 * pi * _line(name, means, frequency_hz)
    t, used = means.times, np.ones(len(times), dtype=bool)
    coefficients: Array = np.zeros(2 * ORDERS + 1)
    for _ in range(ROUNDS):
        design = _design(t, omega, recording.step_s, together)
        # Before there is an amplitude nothing depends on the frequency.
        slope = _by_frequency(design, t, coefficients)
        every = np.column_stack([design, slope]) if slope.any() else design
        solved = _solved(every[used], values[used])
        coefficients, move = solved[: 2 * ORDERS + 1], float(solved[-1]) if slope.any() else 1.0
        left = values - design @ coefficients
        # The median of the absolute deviations is hardly moved by impacts; 1.4826 of it is a standard deviation.
        deviation = 1.4826 * float(np.median(np.abs(left)))
        now = np.abs(left) <= max(OUTLYING * deviation, 1e-12 * float(np.abs(values).max()))
        same = bool(np.mean(now != used) < FEW_CHANGE)
        used = now
        if slope.any():
            # Not more than a part of the width of a line of the spectrum, beyond which another maximum may be nearer.
            omega += float(np.clip(move, -1 / span, 1 / span))
        if same and slope.any() and abs(move) * span < SETTLED:
            break
    design = _design(t, omega, recording.step_s, together)
    every = np.column_stack([design, _by_frequency(design, t, coefficients)])
    solved = _solved(every[used], values[used])
    left = np.where(used, values - every @ solved, 0.0)
    inverse: Array = np.asarray(np.linalg.inv(every[used].T @ every[used]), dtype=np.float64)
    noise = _noise(means, left, omega, int(used.sum()))
    # Coefficients have the noise at their own frequency: that of a machine is not white.
    spread = np.repeat(np.sqrt(noise), 2)
    deviations = np.concatenate([[spread[0]], spread, [spread[0]]])
    covariance = inverse * np.outer(deviations, deviations)
    motion = _motion(channel, means, middle, _Fit(coefficients, covariance, omega, used, left[used], design))
    return _accelerated(motion) if channel.place is HeardPlace.DISPLACEMENT else motion


class _Means(Struct, frozen=True, eq=False):
    """Means of neighbouring samples, from which a motion is fitted.

    Attributes
    ----------
    times : Array (k,)
        Of their middles, from the middle of the record on [s].
    values : Array (k,)
    step : float
        Time from a mean to the next [s].
    span : float
        Time from the first to the last [s].
    """

    times: Array
    values: Array
    step: float
    span: float


class _Fit(Struct, frozen=True, eq=False):
    """A sum of harmonics fitted to means of samples.

    Attributes
    ----------
    coefficients : Array (2 `ORDERS` + 1,)
        The constant, then cosine and sine of each order.
    covariance : Array (2 `ORDERS` + 2, 2 `ORDERS` + 2)
        Of these and the angular frequency.
    omega : float
        The angular frequency [rad/s].
    used : Mask (k,)
        Means that do not stand out of the rest.
    residuals : Array
        Of the means that are used.
    design : Array (k, 2 `ORDERS` + 1)
        Derivatives of the means by the coefficients.
    """

    coefficients: Array
    covariance: Array
    omega: float
    used: Mask
    residuals: Array
    design: Array


def _means(recording: Recording, channel: Channel, together: int) -> tuple[Array, Array]:
    """Times of the middles [s] and values of the means of so many samples each, in each unbroken stretch."""
    times, values = [], []
    for stretch in recording.stretches:
        count = (stretch.last - stretch.first) // together
        samples = channel.values[stretch.first : stretch.first + count * together]
        values.append(samples.reshape(count, together).mean(axis=1))
        middles = stretch.first + np.arange(count) * together + (together - 1) / 2
        times.append(recording.times_of(stretch, middles))
    return np.concatenate(times), np.concatenate(values)


def _even(t: Array, values: Array, step: float) -> Array:
    """Values at times that are multiples of a step, on an even clock without gaps: 0 where there are none."""
    rows = np.round((t - t[0]) / step).astype(int)
    even = np.zeros(rows[-1] + 1)
    even[rows] = values
    return even


def _line(name: str, means: _Means, expected: float) -> float:
    """Frequency of the strongest line of the spectrum near an expected one [Hz].

    Raises
    ------
    UsageError
        If another line is stronger.
    """
    even = _even(means.times, means.values - np.median(means.values), means.step)
    size = 1 << int(np.ceil(np.log2(PADDED * len(even))))
    power = np.abs(np.fft.rfft(even, size)) ** 2
    lines = np.fft.rfftfreq(size, means.step)
    near = np.abs(lines / expected - 1) < WITHIN
    peak = float(lines[near][np.argmax(power[near])])
    # Twice and half the frequency would be of another motion: the line must be the strongest of all slow ones.
    slow = (lines > max(0.2 * expected, 3 / means.span)) & (lines < 5 * expected)
    strongest = float(lines[slow][np.argmax(power[slow])])
    if abs(strongest / expected - 1) >= WITHIN:
        raise UsageError(
            f"{name}: its strongest line is at {strongest:.4g} Hz, and excitation.frequency_hz is {expected:g} "
            f"(allowed: within {WITHIN:.0%} of it; is it the right channel, unit of time and frequency?)"
        )
    return peak


def _design(t: Array, omega: float, step: float, together: int) -> Array:
    """Columns of the least squares (k, 2 `ORDERS` + 1): 1, and the means of cosine and sine of each order."""
    columns = [np.ones_like(t)]
    for order in range(1, ORDERS + 1):
        # The mean of neighbouring samples of a wave is smaller by the Dirichlet kernel.
        half = order * omega * step / 2
        share = np.sin(together * half) / (together * np.sin(half))
        columns += [share * np.cos(order * omega * t), share * np.sin(order * omega * t)]
    return np.column_stack(columns)


def _solved(design: Array, values: Array) -> Array:
    """Least squares by the normal equations of columns of one size: they are nearly orthogonal."""
    size = np.linalg.norm(design, axis=0)
    scaled = design / size
    # Without the threads of a matrix product, which cost more than they save where the columns are few.
    square, right = np.einsum("ij,ik->jk", scaled, scaled), np.einsum("ij,i->j", scaled, values)
    return np.asarray(np.linalg.solve(square, right) / size)


def _by_frequency(design: Array, t: Array, coefficients: Array) -> Array:
    """Derivative of the fitted means by the angular frequency: (k,)."""
    slope = np.zeros_like(t)
    for order in range(1, ORDERS + 1):
        a, b = coefficients[2 * order - 1 : 2 * order + 1]
        slope += order * t * (b * design[:, 2 * order - 1] - a * design[:, 2 * order])
    return slope


def _noise(means: _Means, residuals: Array, omega: float, count: int) -> Array:
    """Variance of the white noise that is as strong as the residuals around each harmonic, (`ORDERS`,).

    `residuals` (k,) are zero where a mean is not used, `count` are used.
    """
    even = _even(means.times, residuals, means.step)
    power = np.abs(np.fft.rfft(even)) ** 2 / count
    at = np.arange(1, ORDERS + 1) * omega / (2 * pi) * means.step * len(even)
    near, far = NEIGHBOURS
    # Not as far as a third of the way to the next harmonic.
    far = int(min(far, max(near + 3, omega / (2 * pi) * means.span / 3)))
    noise = []
    for line in np.round(at).astype(int):
        neighbours = np.concatenate([np.arange(line - far, line - near + 1), np.arange(line + near, line + far + 1)])
        neighbours = neighbours[(neighbours > 0) & (neighbours < len(power))]
        noise.append(float(power[neighbours].mean()))
    return np.array(noise)


def _motion(channel: Channel, means: _Means, middle: float, fit: _Fit) -> ShakerMotion:
    """The shaker's motion in amplitudes and phases, of a fit about the middle of a record [s]."""
    coefficients, covariance, omega = fit.coefficients, fit.covariance, fit.omega
    a, b = coefficients[1:3]
    amplitude, lag = hypot(a, b), atan2(b, a)
    covariance_block = covariance[1:3, 1:3]
    in_phase, across = np.array([a, b]) / amplitude, np.array([-b, a]) / amplitude
    amplitude_error, phase_error = (
        sqrt(in_phase @ covariance_block @ in_phase),
        sqrt(across @ covariance_block @ across) / amplitude,
    )
    harmonics = []
    for order in range(2, ORDERS + 1):
        k = 2 * order - 1
        c, s = coefficients[k : k + 2]
        size = hypot(c, s)
        # Phases are relative to the maximum of the sine, whose error turns a harmonic by its order as much.
        error = sqrt((covariance[k, k] + covariance[k + 1, k + 1]) / 2)
        phase = degrees(order * lag - atan2(s, c)) % 360
        turn = degrees(hypot(error / size, order * phase_error)) if size else 180.0
        percent = 100 * size / amplitude
        harmonics.append(MeasuredHarmonic(order, percent, phase, 100 * error / amplitude, min(turn, 180.0)))
    return ShakerMotion(
        channel,
        amplitude,
        amplitude_error,
        omega / (2 * pi),
        sqrt(covariance[-1, -1]) / (2 * pi),
        middle + lag / omega,
        phase_error,
        tuple(harmonics),
        float(coefficients[0]),
        float(np.std(fit.residuals)),
        float(1 - fit.used.mean()),
        (omega * means.times - lag) % (2 * pi),
        means.values,
        fit.design @ coefficients,
    )


def _accelerated(path: ShakerMotion) -> ShakerMotion:
    """The acceleration of a capsule of which the displacement was fitted: that of order j times -(j omega)^2.

    It is largest where the displacement is least, half a period later. There the phase of order j, which turns j times
    as fast, is less by j - 1 half turns.
    """
    omega = 2 * pi * path.frequency_hz
    error = hypot(path.amplitude_error, 2 * path.amplitude * path.frequency_error_hz / path.frequency_hz)
    harmonics = (
        replace(
            harmonic,
            percent=harmonic.order**2 * harmonic.percent,
            percent_error=harmonic.order**2 * harmonic.percent_error,
            phase_deg=(harmonic.phase_deg - 180.0 * (harmonic.order - 1)) % 360,
        )
        for harmonic in path.harmonics
    )
    return replace(
        path,
        amplitude=omega**2 * path.amplitude,
        amplitude_error=omega**2 * error,
        maximum_s=path.maximum_s + 0.5 / path.frequency_hz,
        harmonics=tuple(harmonics),
        offset=0.0,
        noise=omega**2 * path.noise,
        phases=(path.phases + pi) % (2 * pi),
    )


def shaker_findings(recording: Recording, shaker: ShakerMotion, device: Device) -> tuple[ShakerFinding, ...]:
    """Possible faults of a recorded acceleration, by comparison with the force of a scenario.

    Parameters
    ----------
    recording : Recording
    shaker : ShakerMotion
        As it was fitted.
    device : Device
        Of the scenario.
    """
    lone = _lone(recording, shaker) if shaker.channel.place is HeardPlace.CAPSULE else ()
    return (*_of_unit(shaker, device), *lone, *_clipping(shaker))


def _of_unit(shaker: ShakerMotion, device: Device) -> Iterator[ShakerFinding]:
    """Findings that the record fits the scenario only with a factor: of another unit, or of a reversed axis."""
    name, stated = shaker.channel.name, float(device.amplitude_n) / float(device.capsule_mass_kg)
    ratio = stated / shaker.amplitude
    factor = next((unit_factor for unit_factor in FACTORS if abs(ratio / unit_factor - 1) < SAME_FACTOR), 1.0)
    axial_gravity = float(device.gravity_m_s2) * sin(np.deg2rad(float(device.inclination_deg)))
    reversed_ = (axial_gravity > 1 and abs(shaker.offset * factor + axial_gravity) < TILTED * axial_gravity) or _turned(
        shaker, device
    )
    if factor != 1:
        signed = -factor if reversed_ else factor
        yield ShakerFinding(ShakerDoubt.FACTOR, name, signed, recorded=shaker.amplitude, stated=stated)
        return
    if not 1 / NO_FACTOR < ratio < NO_FACTOR:
        yield ShakerFinding(ShakerDoubt.FORCE, name, ratio, recorded=shaker.amplitude, stated=stated)
    if reversed_:
        yield ShakerFinding(ShakerDoubt.REVERSED, name, -1.0, recorded=shaker.amplitude, stated=stated)


def _turned(shaker: ShakerMotion, device: Device) -> bool:
    """Whether the record has the scenario's even harmonics with the other sign, as of a sensor with a reversed axis.

    Reversed, a force is its mirror image, which half a period later has the same odd harmonics.
    """
    measured = {harmonic.order: harmonic for harmonic in shaker.harmonics if harmonic.significant}
    off = [
        (measured[harmonic.order].phase_deg - degrees(atan2(-harmonic.sine, harmonic.cosine))) % 360
        for harmonic in device.harmonics
        if harmonic.order % 2 == 0 and harmonic.order in measured
    ]
    return bool(off) and all(abs(harmonic - 180) < TURNED_DEG for harmonic in off)


def _lone(recording: Recording, shaker: ShakerMotion) -> Iterator[ShakerFinding]:
    """Findings of single samples that are much farther from the fitted motion than all others."""
    values = shaker.channel.values
    times = recording.times
    off = np.abs(values - shaker.at(times))
    most = np.argsort(-off, kind="stable")[: MOST_LONE + 1]
    least = LEAST_FAR * shaker.amplitude
    count = next((k for k in range(1, len(most)) if off[most[k - 1]] > FAR * max(off[most[k]], least / FAR)), 0)
    for row in sorted(most[:count].tolist()):
        numbers = float(off[row]), float(times[row]), float(values[row]), float(off[most[count]])
        yield ShakerFinding(ShakerDoubt.LONE, shaker.channel.name, *numbers)


def _clipping(shaker: ShakerMotion) -> Iterator[ShakerFinding]:
    """A finding if a signal stays at its largest or least value for longer than a crest does."""
    values = shaker.channel.values
    steps = np.abs(np.diff(values[:100_000]))
    step = float(steps[steps > 0].min(initial=np.inf))
    cut = 0
    for rail, inward in ((float(values.max()), -1.0), (float(values.min()), 1.0)):
        at_rail = values == rail
        near_rail = np.count_nonzero((inward * (values - rail) > 0) & (inward * (values - rail) < 1.5 * step))
        runs = at_rail[2:] & at_rail[1:-1] & at_rail[:-2]
        begun = np.count_nonzero(runs & ~np.concatenate([[False], runs[:-1]]))
        if begun > 1 and np.count_nonzero(at_rail) > FULLER * near_rail:
            cut += int(np.count_nonzero(at_rail))
    if cut:
        yield ShakerFinding(ShakerDoubt.CLIPPED, shaker.channel.name, cut / len(values))
