"""What a device does under a recorded motion of its shaker as records of results.json."""

from __future__ import annotations

from msgspec import UNSET, UnsetType
from msgspec.structs import asdict

from vireport.base.records import ResultsBlock
from vireport.findings.driven.driven import Driven
from vireport.findings.driven.means import Mean, NoInterval
from vireport.measurement.shaker import MeasuredHarmonic, ShakerDoubt, ShakerFinding

MAY_LACK = "speed_bottom_m_s", "speed_top_m_s", "voltage_per_s", "power_mw"
"""Means that are null where there is no impact, or nothing to evaluate."""


class FittedForce(ResultsBlock, frozen=True, kw_only=True):
    """The force that fits a record best: a sine and its harmonics.

    Attributes
    ----------
    amplitude_n, frequency_hz : N, Hz
        the best sine
    offset_m_s2 : m/s²
        constant part, which is removed
    harmonics
        those that exceed the noise
    """

    amplitude_n: float
    frequency_hz: float
    offset_m_s2: float
    harmonics: list[MeasuredHarmonic]


class WordShareData(ResultsBlock, frozen=True, kw_only=True):
    """How often a word was seen along a record.

    Attributes
    ----------
    word
        impacts of a period up to rotation; empty where there is none
    share : 1
        share of the periods
    """

    word: str
    share: float


class MeanData(ResultsBlock, frozen=True, kw_only=True):
    """A mean along a record, with its interval.

    Attributes
    ----------
    value, from_, to
        mean, and its 95 % interval, null where `reason` says why
    reason
        why there is no interval, `short` or `drifts`; else null
    """

    value: float
    from_: float | None
    to: float | None
    reason: NoInterval | None


class PredictedMeans(ResultsBlock, frozen=True, kw_only=True):
    """The same means of the stable 1:1 motion under the force that fits a record best.

    Attributes
    ----------
    speed_bottom_m_s, speed_top_m_s, impacts_per_s, voltage_per_s, power_mw
        as numbers; the last two null where they are not evaluated
    """

    speed_bottom_m_s: float
    speed_top_m_s: float
    impacts_per_s: float
    voltage_per_s: float | None
    power_mw: float | None


class ShakerFindingData(ResultsBlock, frozen=True, kw_only=True):
    """What may be wrong with a record.

    Attributes
    ----------
    kind
        `factor` by which its amplitude fits the scenario, another `amplitude`, a `reversed` axis, a `lone_sample` far
        from all others, or `clipped`
    channel
        of the record
    value
        the factor, or of another `amplitude` and of a `reversed` axis the ratio of both; how far a lone sample is
        from what is fitted [m/s²]; share of the samples that are clipped
    at_s : s
        when; of a lone sample
    recorded_m_s2 : m/s²
        amplitude of the record, or value of the lone sample; absent where it is clipped
    others_within_m_s2 : m/s²
        how far all others are from what is fitted at most; of a lone sample
    scenario_m_s2 : m/s²
        amplitude of the scenario; absent of a lone sample, and where it is clipped
    """

    kind: ShakerDoubt
    channel: str
    value: float
    at_s: float | UnsetType = UNSET
    recorded_m_s2: float | UnsetType = UNSET
    others_within_m_s2: float | UnsetType = UNSET
    scenario_m_s2: float | UnsetType = UNSET


class DrivenData(ResultsBlock, frozen=True, kw_only=True):
    """What a device does under a recorded motion of its shaker, beside the periodic motion that is predicted.

    Attributes
    ----------
    record, samples, sampling_rate_hz : –, –, Hz
        the file, as the scenario names it, and its size
    from_s, to_s : s
        on the record's clock, the time from which the motion is evaluated, and the end of the record
    excitation
        the force that fits best
    impacts, periods
        numbers of impacts and of periods of the 1:1 motion, n forcing periods each, that are evaluated
    words
        the impacts of a period, the most frequent first
    share_at_rest : 1
        share of periods in which the ball comes to rest
    impacts_per_s, speed_bottom_m_s, speed_top_m_s : 1/s, m/s, m/s
        means; speeds null where there is no impact
    voltage_per_s, power_mw : V/s, mW
        means; null where they are not evaluated. Power is the upper bound of [electrical energy](#electrical-energy)
    deepest_m : m
        largest deflection of a membrane; null where it is not evaluated
    predicted
        the same means of the stable 1:1 motion under the best sine and harmonics; null where there is none
    findings
        what may be wrong with the record, as alert VR018 says it
    reading
        as what the file was read, in words
    resampling_error : 1
        share of the amplitude by which samples may be wrong that were put on an even clock; null where they were on one
    """

    record: str
    samples: int
    sampling_rate_hz: float
    from_s: float
    to_s: float
    excitation: FittedForce
    impacts: int
    periods: int
    words: list[WordShareData]
    share_at_rest: float
    impacts_per_s: MeanData
    speed_bottom_m_s: MeanData | None
    speed_top_m_s: MeanData | None
    voltage_per_s: MeanData | None
    power_mw: MeanData | None
    deepest_m: float | None
    predicted: PredictedMeans | None
    findings: list[ShakerFindingData]
    reading: str = ""
    resampling_error: float | None = None


def driven_data(driven: Driven) -> DrivenData:
    """What the device does under a recorded motion of its shaker."""
    recording, shaker, device = driven.recording, driven.shaker, driven.device
    means = {name: mean if (mean := getattr(driven, name)) is None else _mean(mean) for name in MAY_LACK}
    return DrivenData(
        record=recording.name,
        samples=recording.samples,
        sampling_rate_hz=1 / recording.step_s,
        from_s=driven.settled_s,
        to_s=recording.end_s,
        excitation=FittedForce(
            amplitude_n=float(device.amplitude_n),
            frequency_hz=float(device.frequency_hz),
            offset_m_s2=shaker.offset,
            harmonics=[row for row in shaker.harmonics if row.significant],
        ),
        impacts=len(driven.times_s),
        periods=driven.periods,
        words=[WordShareData(word=row.letters, share=row.share) for row in driven.words],
        share_at_rest=driven.rests,
        impacts_per_s=_mean(driven.impacts_per_s),
        **means,
        deepest_m=driven.deepest_m,
        predicted=None if driven.predicted is None else PredictedMeans(**asdict(driven.predicted)),
        findings=[_doubt(row) for row in driven.doubts],
        reading=recording.reading,
        resampling_error=driven.resampled,
    )


def _mean(mean: Mean) -> MeanData:
    return MeanData(value=mean.value, from_=mean.low, to=mean.high, reason=mean.why)


def _doubt(row: ShakerFinding) -> ShakerFindingData:
    """What may be wrong with a record, with the numbers that its kind has."""
    lone, clipped = row.doubt is ShakerDoubt.LONE, row.doubt is ShakerDoubt.CLIPPED
    return ShakerFindingData(
        kind=row.doubt,
        channel=row.channel,
        value=row.value,
        at_s=row.at_s if lone else UNSET,
        recorded_m_s2=UNSET if clipped else row.recorded,
        others_within_m_s2=row.stated if lone else UNSET,
        scenario_m_s2=UNSET if lone or clipped else row.stated,
    )
