"""Impacts in raw signals: when each began, on which membrane, with its standard error from the noise.

Hum and offset, which are slow against an impact, are removed by a causal filter, so that nothing precedes an impact. An
impact is where the signal exceeds the noise, and the signal shortly before: so a ringing impact counts once, and a
second impact during its ringing separately. An impact began where the straight line through its first rise crosses
zero, which does not depend on its strength.
"""

from __future__ import annotations

from enum import Enum, auto
from math import ceil, sqrt

import numpy as np
from msgspec import Struct

from vireport.base.errors import UsageError
from vireport.base.progress import Progress, WorkStep
from vireport.measurement.flights import Array, Indices
from vireport.measurement.recordings import ROUNDED, Channel, HeardPlace, Recording
from vireport.measurement.records import FEWEST

WAIT = 0.005
"""Periods of the force by which impacts must be apart not to be taken for the ringing of the one before; twice that at
worst. What is slower than its inverse is filtered away."""

SLOW = 0.5
"""Over `WAIT`: cycles that last longer in periods of the force are filtered away."""

MOST_OF_BAND = 0.1
"""Of the sampling rate: the highest frequency below which is filtered away."""

OUT_OF_NOISE = 7.0
"""Standard deviations of the noise: of 1e8 normal samples, none."""

OUT_OF_RINGING = 3.0
"""Over what was there a wait earlier: ringing falls, and two tones of it together rise less."""

FIRST_SWING = 0.35
"""Over the highest: lower ones before it belong to the sensor, or to the ringing of the impact before."""

SEEN = 5.0
"""Standard deviations of the noise: the least first swing of what stands out of it later."""

TURNED = 0.3
"""Share by which a signal falls back behind a peak that is one."""

RISE = 0.25, 0.75
"""Shares of the first peak between which the line is laid."""

STEPS_OF_RISE, STEPS_OF_SIGN = 3.0, 1.5
"""Samples in the part of a rise that the line is laid through below which sampling is slow, and below which no sign
is known."""

EVEN_SO, FEW = 0.03, 0.6
"""Steps by which a time is off without noise, as a rise is not straight and begins between samples: tried on pulses
that ring and on halves of a sine. The second is over the cube of the steps in the rise."""

OF_UNEQUAL = 4.0
"""Error of a time over the standard deviation of unequal steps, of which filters know nothing: tried on the same pulses
at steps that differ by a tenth to a half."""

FINE, OUTSIDE = 16, 24
"""Points of a rise that a signal is resampled to where it has fewer, and samples on both sides that are used for it."""

DITHER, SEED, MOST_ERRORS = 3.0, 0, 0.9
"""Independent normal errors that are added to times, over those that come of sampling. These depend on where samples
lie, and so on one another: alone they would be taken for motion, by tests and by intervals. What is added also makes
the errors of that share of the impacts alike, as those are that a fit takes them for: where half a rise is now one
sample and now two, some errors are six times others, and a fit took them for impacts that were missed. The seed makes
equal records give equal times."""

SMOOTHED = 4.0
"""Part of a rise over which a signal is averaged that was sampled far faster than it rises."""

ALONE = 0.5
"""Of two channels at once: share of the other's strength below which one only hears through the device."""

FEWEST_SAMPLES = 100
"""In a period of the force, for an impact to be timed."""

FEWEST_FOR_SIGN = 1000
"""In a period of the force, where the sign of an impact tells its membrane. With fewer the filter cannot be set between
an impact and what is slower: of pulses that ring or are halves of a sine, of 4 to 100 samples, half of the rise was one
sample, or later swings were taken for impacts."""

FOLDED = 0.1
"""Share of the power of impacts in the last tenth below half of the sampling rate beyond which more lies beyond it."""

WINDOW, MOST_WINDOWS = 256, 200
"""Samples of a spectrum, and of how many impacts it is the mean."""


class Doubt(Enum):
    """Kinds of faults of a recording, certain or possible."""

    CLIPPED = auto()
    SLOW = auto()
    FOLDED = auto()
    OFFSET = auto()
    BOTH = auto()
    GAPS = auto()
    UNEVEN = auto()
    UNEQUAL = auto()
    MISSING = auto()
    REPEATED = auto()


class RecordFinding(Struct, frozen=True):
    """A fault of a recording: its kind, its channel ("" of all), its size, and where the first one is [s]."""

    doubt: Doubt
    channel: str
    value: float
    at_s: float | None = None


class Heard(Struct, frozen=True, eq=False):
    """The impacts that were picked from one channel.

    Attributes
    ----------
    channel : Channel
    noise : float
        Standard deviation of the filtered signal between impacts, in the channel's unit.
    times, errors : Array (n,)
        Times at which the impacts begin, and their standard errors [s].
    sampled : Array (n,)
        The part of the standard errors that is due to sampling [s].
    sizes : Array (n,)
        Heights of the first peaks, with their signs, in the channel's unit.
    rise_samples : float
        Median number of samples in the part of a rise that times are taken from.
    clipped : int
        Number of impacts at which the channel is clipped.
    high_share : float
        Share of the power of impacts just below half of the sampling rate.
    """

    channel: Channel
    noise: float
    times: Array
    errors: Array
    sampled: Array
    sizes: Array
    rise_samples: float
    clipped: int
    high_share: float

    @property
    def least(self) -> float:
        """The least height that is picked, in the channel's unit."""
        return OUT_OF_NOISE * self.noise

    @property
    def middle_size(self) -> float:
        """Median height of the first peaks of impacts, in the channel's unit."""
        return float(np.median(np.abs(self.sizes)))


class Picked(Struct, frozen=True, eq=False):
    """The impacts that were picked from all channels of a recording.

    Attributes
    ----------
    recording : Recording
    frequency_hz : float
        Frequency of the force, which sets the filter.
    heard : tuple of Heard
    times, walls, errors : Array (n,)
        Of impacts: times and standard errors [s], and 1 at the bottom, -1 at the top.
    findings : tuple of RecordFinding
    """

    recording: Recording
    frequency_hz: float
    heard: tuple[Heard, ...]
    times: Array
    walls: Array
    errors: Array
    findings: tuple[RecordFinding, ...]

    @property
    def middle_error_s(self) -> float:
        """Median standard error of the times [s]."""
        return float(np.median(self.errors))

    @property
    def delay_s(self) -> float:
        """Systematic error common to all times, as the shape of a rise is not known [s]."""
        return max(beginnings.rise_samples for beginnings in self.heard) * self.recording.step_s


def picked(recording: Recording, frequency_hz: float, say: Progress = lambda what: None) -> Picked:
    """Pick the impacts of a recording: their times, membranes and standard errors.

    Parameters
    ----------
    recording : Recording
    frequency_hz : float
        Frequency of the force, which sets the filter.
    say : callable
        Called with each channel as it begins.

    Raises
    ------
    UsageError
        If impacts cannot be timed or do not stand out.
    """
    sources = recording.of(HeardPlace.BOTTOM, HeardPlace.TOP, HeardPlace.EITHER) or recording.of(HeardPlace.CAPSULE)
    # Before filters are loaded, which takes a second.
    _require_samples(recording, frequency_hz, by_sign=len(sources) == 1)
    heard = []
    for k, channel in enumerate(sources):
        say(WorkStep(f"picking impacts from {channel.name}", k / len(sources)))
        heard.append(_heard(recording, channel, frequency_hz))
    times, walls, errors, both = _merged(heard, 2 * WAIT / frequency_hz)
    if len(times) < FEWEST:
        raise UsageError(
            f"{recording.name}: {len(times)} impact{'s' * (len(times) != 1)} stand out of the noise (at least {FEWEST} "
            "are needed, and some tens to be of use)"
        )
    findings = [finding for beginnings in heard for finding in _findings(beginnings)]
    if both:
        findings.append(RecordFinding(Doubt.BOTH, "", both))
    if len(recording.stretches) > 1:
        gaps = len(recording.stretches) - 1
        findings.append(RecordFinding(Doubt.GAPS, "", gaps, recording.stretches[1].start_s))
    if not recording.even:
        findings.append(RecordFinding(Doubt.UNEQUAL, "", recording.step_s))
    elif recording.uneven_s > ROUNDED * recording.step_s:
        findings.append(RecordFinding(Doubt.UNEVEN, "", recording.uneven_s))
    for flaw in recording.flaws:
        findings.append(RecordFinding(Doubt[flaw.kind.name], flaw.signal, flaw.count, flaw.at_s))
    return Picked(recording, frequency_hz, tuple(heard), times, walls, errors, tuple(findings))


def _require_samples(recording: Recording, frequency_hz: float, by_sign: bool) -> None:
    """Refuse a recording with too few samples in a period of the force; `by_sign` if one channel has both membranes.

    Raises
    ------
    UsageError
    """
    samples = 1 / (recording.step_s * frequency_hz)
    least = FEWEST_FOR_SIGN if by_sign else FEWEST_SAMPLES
    if round(samples) >= least:
        return
    what = "tell the membrane by the sign of an impact" if by_sign else "time impacts"
    other = "a channel for each membrane" if by_sign else "another excitation.frequency_hz"
    raise UsageError(
        f"{recording.name}: {samples:.3g} samples in a period of the force are too few to {what} (allowed: {least} and "
        f"more, thousands for use; or {other})"
    )


def filtered(recording: Recording, channel: Channel, frequency_hz: float) -> Array:
    """A channel after a causal high-pass filter, which removes what is slow against an impact."""
    from scipy.signal import butter, sosfilt, sosfilt_zi  # type: ignore[import-untyped]

    cut = min(SLOW * frequency_hz / WAIT * recording.step_s, MOST_OF_BAND)
    sections = butter(2, 2 * cut, "highpass", output="sos")
    begun = sosfilt_zi(sections)
    out = np.empty_like(channel.values)
    for stretch in recording.stretches:
        values = channel.values[stretch.first : stretch.last]
        # As if the first sample had been there for ever; slow oscillations need their time to go.
        out[stretch.first : stretch.last] = sosfilt(sections, values, zi=begun * values[0])[0]
    return out


def _heard(recording: Recording, channel: Channel, frequency_hz: float) -> Heard:
    """Pick the impacts of a channel, smoothed where it was sampled far faster than it rises.

    Raises
    ------
    UsageError
        If it is constant, or nothing stands out of its noise.
    """
    if np.ptp(channel.values) == 0:
        raise UsageError(f"{recording.name}: {channel.name} is constant: nothing is connected (allowed: a signal)")
    signal = filtered(recording, channel, frequency_hz)
    wait = max(2, round(WAIT / (frequency_hz * recording.step_s)))
    beginnings = _beginnings(recording, channel, signal, wait, 1)
    if (over := round(beginnings.rise_samples / SMOOTHED)) > 2:
        from scipy.ndimage import uniform_filter1d  # type: ignore[import-untyped]

        for stretch in recording.stretches:
            part = signal[stretch.first : stretch.last]
            part[:] = uniform_filter1d(part, over)
        beginnings = _beginnings(recording, channel, signal, wait, over)
    if channel.place in (HeardPlace.EITHER, HeardPlace.CAPSULE) and beginnings.rise_samples < STEPS_OF_SIGN:
        raise UsageError(
            f"{recording.name}: {channel.name} is sampled too slowly for the sign of an impact, which tells the "
            f"membrane: half of its rise is of one sample (allowed: some {STEPS_OF_RISE:g} samples; or a channel for "
            "each membrane)"
        )
    return beginnings


def _beginnings(recording: Recording, channel: Channel, signal: Array, wait: int, over: int) -> Heard:
    """Pick the impacts of a filtered channel.

    Parameters
    ----------
    recording : Recording
    channel : Channel
    signal : Array (n,)
        The channel filtered, and averaged over some samples.
    wait : int
        Samples by which impacts must be apart.
    over : int
        Samples that the signal is averaged over.

    Raises
    ------
    UsageError
        If nothing stands out of its noise.
    """
    from scipy.signal import find_peaks

    size = np.abs(signal)
    largest = float(size.max())
    every = max(1, len(size) // 1_000_000)
    noise = max(1.4826 * float(np.median(size[::every])), _resolution(channel.values) / sqrt(12), 1e-7 * largest)
    rows: list[tuple[float, float, float, float, int]] = []
    for stretch in recording.stretches:
        loudness = size[stretch.first : stretch.last]
        peaks, _ = find_peaks(loudness, height=OUT_OF_NOISE * noise)
        for first in _first_peaks(loudness, peaks, wait):
            row = _onset(signal[stretch.first : stretch.last], int(first), wait, noise, over)
            if row is not None:
                begun, error, height, length, place = row
                around = stretch.first + begun + np.array([-0.5, 0.0, 0.5])
                before, at, after = recording.times_of(stretch, around).tolist()
                rows.append((at, error * (after - before), height, length, stretch.first + place))
    if not rows:
        raise UsageError(
            f"{recording.name}: no impact stands out of the noise of {channel.name}: its largest value is "
            f"{largest / noise:.2g} times the noise ({OUT_OF_NOISE:g} are needed; is it the right channel, and "
            "frequency?)"
        )
    times, errors, sizes, lengths, places = map(np.array, zip(*rows, strict=True))
    sampled = recording.step_s * (EVEN_SO + FEW / lengths**3)
    errors = np.hypot(errors, sampled)
    if not recording.even:
        errors = np.hypot(errors, OF_UNEQUAL * recording.step_spread_s)
    clipped = _clipped(channel.values, places, wait)
    share = _high_share(signal, places, noise)
    return Heard(channel, noise, times, errors, sampled, sizes, float(np.median(lengths)), clipped, share)


def _resolution(values: Array) -> float:
    """Resolution of a channel: the least difference of neighbouring samples that is not zero."""
    steps = np.abs(np.diff(values[:100_000]))
    steps = steps[steps > 0]
    return float(steps.min()) if len(steps) else 0.0


def _first_peaks(size: Array, peaks: Indices, wait: int) -> Indices:
    """Peaks with which impacts begin: those that exceed the ringing in the `wait` samples before them."""
    if not len(peaks):
        return peaks
    low, high = np.maximum(peaks - 2 * wait, 0), np.maximum(peaks - wait, 1)
    before = np.maximum.reduceat(size, np.stack([low, high], axis=1).ravel())[::2]
    new = peaks[size[peaks] > OUT_OF_RINGING * before]
    return new[np.diff(new, prepend=-len(size)) > wait] if len(new) else new


def _onset(
    signal: Array, first: int, wait: int, noise: float, over: int
) -> tuple[float, float, float, float, int] | None:
    """Beginning of an impact and its standard error [samples], its first peak, and the samples of its rise.

    None where the record does not have its rise.
    """
    from scipy.signal import resample_poly

    low = max(first - 2 * wait, 0)
    part = signal[low : first + wait]
    start = first - low
    highest = float(np.abs(part[start:]).max())
    # The first swing that counts, and its end.
    early = max(start - wait, 0)
    loud = early + int(np.argmax(np.abs(part[early:]) >= max(SEEN * noise, FIRST_SWING * highest)))
    wave = whole = part if part[loud] > 0 else -part
    top = np.maximum.accumulate(wave[loud:])
    # The first peak ends where the signal falls back clearly: noise makes many smaller ones on the way up.
    fell = wave[loud:] < top - np.maximum(5 * noise, TURNED * top)
    end = int(np.argmax(fell)) if fell.any() else len(top)
    peak = loud + int(np.argmax(wave[loud : loud + end]))
    height = _vertex(wave, peak)
    rise = _rise(wave, peak, height)
    if rise is None:
        return None
    begin, stop = rise
    length, origin = float(stop - begin), begin
    fine = ceil(FINE / (stop - begin))
    if fine > 1:  # between samples a signal without what is beyond half of their rate is known
        first = max(begin - OUTSIDE, 0)
        wave = resample_poly(wave[first : peak + OUTSIDE], fine, 1, padtype="line")
        near = (peak - first) * fine
        near = near - fine + int(np.argmax(wave[near - fine : near + fine + 1]))
        rise = _rise(wave, near, float(wave[near]))
        if rise is None:
            return None
        begin, stop = rise
    x = np.arange(begin, stop + 1)
    y = wave[begin : stop + 1]
    count, middle = len(x), float(x.mean())
    spread = float(((x - middle) ** 2).sum())
    slope = float((x - middle) @ y) / spread
    if slope <= 0:
        return None
    begun = middle - float(y.mean()) / slope
    # Averaged and resampled samples are not independent: `over * fine` of them count as one.
    variance = min(over * fine, count) / slope**2 * (1 / count + (begun - middle) ** 2 / spread)
    if fine > 1:
        begun, variance, wave = first + begun / fine, variance / fine**2, whole
    # Ringing from the impact before adds to the noise.
    clear = max(origin - 2 * int(length), 0)
    ringing = float(np.abs(wave[max(clear - wait, 0) : clear]).max(initial=0.0))
    around = max(noise, ringing / sqrt(2) if ringing > 5 * noise else 0.0)
    variance *= around**2
    return low + begun, sqrt(variance), height if part[loud] > 0 else -height, length, low + origin


def _rise(wave: Array, peak: int, height: float) -> tuple[int, int] | None:
    """The samples just below and just above the part of a rise that the line is laid through; None if it is cut off."""
    below = np.flatnonzero(wave[:peak] <= RISE[0] * height)
    if not len(below):
        return None
    begin = int(below[-1])
    return begin, begin + 1 + int(np.argmax(wave[begin + 1 : peak + 1] >= RISE[1] * height))


def _vertex(wave: Array, peak: int) -> float:
    """Height of a peak between samples, by the parabola through three."""
    if not 0 < peak < len(wave) - 1:
        return float(wave[peak])
    before, at, after = wave[peak - 1 : peak + 2]
    bend = before - 2 * at + after
    return float(at - (after - before) ** 2 / (8 * bend)) if bend < 0 else float(at)


def _clipped(values: Array, places: Indices, wait: int) -> int:
    """Impacts in which a channel stays at the largest or the least value that it has."""
    low, high = float(values.min()), float(values.max())
    count = 0
    for place in places:
        at = [values[place : place + wait] == rail for rail in (low, high)]
        count += any(bool((sample[2:] & sample[1:-1] & sample[:-2]).any()) for sample in at)
    return count if count > 1 else 0


def _high_share(signal: Array, places: Indices, noise: float) -> float:
    """Share of the power of impacts in the last tenth of the band, without the noise."""
    some = places[places + WINDOW < len(signal)][:: max(1, len(places) // MOST_WINDOWS)]
    if not len(some):
        return 0.0
    rows = np.stack([signal[k : k + WINDOW] for k in some.astype(int)]) * np.hanning(2 * WINDOW)[WINDOW:]
    power = (np.abs(np.fft.rfft(rows)) ** 2).mean(axis=0) - noise**2 * (np.hanning(2 * WINDOW)[WINDOW:] ** 2).sum()
    power = np.maximum(power, 0)
    total = float(power.sum())
    return float(power[-WINDOW // 20 :].sum()) / total if total else 0.0


def _merged(heard: list[Heard], apart_s: float) -> tuple[Array, Array, Array, int]:
    """Times, walls and errors of the impacts of all channels; of two at once only the stronger one counts.

    The last number counts the pairs of which neither is clearly stronger.
    """
    times, errors, sampled = (
        np.concatenate(parts)
        for parts in zip(
            *((beginnings.times, beginnings.errors, beginnings.sampled) for beginnings in heard), strict=True
        )
    )
    times, errors = _alike(times, errors, sampled)
    strength = np.concatenate(
        [np.abs(beginnings.sizes) / np.quantile(np.abs(beginnings.sizes), 0.9) for beginnings in heard]
    )
    walls = np.concatenate([_walls(beginnings) for beginnings in heard])
    # A membrane also hears impacts on the other one through the device, weaker and at the same time.
    # Stable, so that equal times keep the order of the channels and records give equal results.
    order = np.argsort(times, kind="stable")
    times, walls, errors, strength = times[order], walls[order], errors[order], strength[order]
    if len(heard) == 1:
        return times, walls, errors, 0
    keep, both = np.ones(len(times), dtype=bool), 0
    last = 0
    for k in range(1, len(times)):
        if walls[k] != walls[last] and times[k] - times[last] < apart_s:
            weaker, stronger = (k, last) if strength[k] < strength[last] else (last, k)
            keep[weaker] = False
            both += bool(strength[weaker] > ALONE * strength[stronger])
            last = stronger
        else:
            last = k
    return times[keep], walls[keep], errors[keep], both


def _alike(times: Array, errors: Array, sampled: Array) -> tuple[Array, Array]:
    """Times and their standard errors with independent errors added, see `DITHER` [s]."""
    wanted = np.hypot(np.quantile(errors, MOST_ERRORS), DITHER * np.quantile(sampled, MOST_ERRORS))
    added = np.sqrt(np.maximum(wanted**2 - errors**2, (DITHER * sampled) ** 2))
    return times + added * np.random.default_rng(SEED).standard_normal(len(times)), np.hypot(errors, added)


def _walls(beginnings: Heard) -> Array:
    """Membranes of the impacts of a channel, 1 bottom and -1 top: by its place, or by their signs."""
    match beginnings.channel.place:
        case HeardPlace.BOTTOM:
            return np.ones(len(beginnings.times))
        case HeardPlace.TOP:
            return -np.ones(len(beginnings.times))
        case HeardPlace.CAPSULE:  # the ball pushes the capsule down where it strikes the bottom
            return -np.sign(beginnings.sizes)
        case _:  # one signal of both: from a displacement no impacts are picked
            return np.sign(beginnings.sizes)


def _findings(beginnings: Heard) -> list[RecordFinding]:
    """Possible faults of a channel, by the impacts that were picked from it."""
    name = beginnings.channel.name
    findings = []
    if beginnings.clipped:
        findings.append(RecordFinding(Doubt.CLIPPED, name, beginnings.clipped))
    if beginnings.rise_samples < STEPS_OF_RISE:
        findings.append(RecordFinding(Doubt.SLOW, name, beginnings.rise_samples))
    if beginnings.high_share > FOLDED:
        findings.append(RecordFinding(Doubt.FOLDED, name, beginnings.high_share))
    offset = float(np.median(beginnings.channel.values[:: max(1, len(beginnings.channel.values) // 1_000_000)]))
    if beginnings.channel.place is not HeardPlace.CAPSULE and abs(offset) > 0.2 * float(
        np.median(np.abs(beginnings.sizes))
    ):
        findings.append(RecordFinding(Doubt.OFFSET, name, offset))
    return findings
