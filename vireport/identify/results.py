"""What a record says of a device as records of identified.json."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import UNSET, UnsetType, field
from msgspec.structs import asdict

from vireport.base.records import ResultsBlock
from vireport.design.measured import HeldHarmonics, MeasuredShare
from vireport.identify.opening import IdentifiedRecord
from vireport.measurement.flights import Unknown
from vireport.measurement.identification import Fitted
from vireport.measurement.inquiry import IdentifiedInput
from vireport.measurement.inspection import InspectedClock, InspectedColumn
from vireport.measurement.misfit import Misfit
from vireport.measurement.picking import Picked
from vireport.measurement.screening import Gap
from vireport.measurement.shaker import MeasuredHarmonic, ShakerMotion
from vireport.measurement.signals import Signals
from vireport.motions.events import Event
from vireport.scenario.parameters import DesignInput
from vireport.study.judging.alerts import record_alerts
from vireport.study.result_records import AlertData, Range
from vireport.text.templates import Words

SWAPPED = "swapped_membranes"
"""What is wrong where it is no key of a scenario."""

DISTORTION = "harmonics"
"""What a record may not show of `excitation`."""


class InspectedData(ResultsBlock, frozen=True, kw_only=True):
    """What is in a file of signals.

    Attributes
    ----------
    file, reading
        its name, and as what it was read, in words
    samples
        their number
    columns, clock
        its columns, and its times; the latter null where it has neither times nor a rate
    record
        the `record:` block to be pasted into a scenario
    """

    file: str
    reading: str
    samples: int
    columns: tuple[InspectedColumn, ...]
    clock: InspectedClock | None
    record: str


class IdentifiedInputData(ResultsBlock, frozen=True, kw_only=True):
    """An input identified from a record, with its standard error and 95 % interval.

    Attributes
    ----------
    name, unit
        key of the input, and its unit; `force_phase_rad` is the phase at `phase_at_s`
    value, standard_error : `unit`
        its value, and the standard error
    from_, to : `unit`
        95 % interval
    """

    name: Unknown
    unit: str
    value: float
    standard_error: float
    from_: float
    to: float


class HiddenData(ResultsBlock, frozen=True, kw_only=True):
    """An input that may be wrong by much and would hardly show, as restitutions make up for it.

    Attributes
    ----------
    name, unit
        the input, and its unit
    off : `unit`
        by how much it may be wrong either way for no test to reject the model
    moves : 1
        by how much each restitution that is identified is then wrong, with the sign where the input is too large
    """

    name: Unknown
    unit: str
    off: float
    moves: dict[str, float]


class MisfitData(ResultsBlock, frozen=True, kw_only=True):
    """Whether the model fits a record, and what the record cannot tell.

    Attributes
    ----------
    statistic, p_value
        of the strictest test, the latter times the number of tests; null where nothing was left to test
    accepted, reason
        whether no test rejects the model, and why in words
    alternative
        the input that, otherwise than the scenario says, makes the model fit, or `swapped_membranes`; null where
        nothing does
    alternative_value, alternative_standard_error
        value of that input, and its standard error, in its unit; null where it is none
    untested
        what might be wrong and would not show in this record: inputs, `swapped_membranes` or `harmonics`
    hidden
        inputs that may be wrong by much
    flights_left_out
        number of flights that the model has left out and the alternative explains, where it is these that reject the
        model; else null
    """

    statistic: float | None
    p_value: float | None
    accepted: bool
    reason: str
    alternative: str | None
    alternative_value: float | None
    alternative_standard_error: float | None
    untested: list[str]
    hidden: list[HiddenData]
    flights_left_out: int | None


class NearestEndData(ResultsBlock, frozen=True, kw_only=True):
    """The nearest end of stable motion of an identified device.

    Attributes
    ----------
    parameter, unit
        the input that varies, and its unit
    kind
        of the critical point
    value, distance : `unit`
        the input at the end, and its signed distance from the device
    """

    parameter: DesignInput
    unit: str
    kind: Event
    value: float
    distance: float


class HeldHarmonicsData(ResultsBlock, frozen=True, kw_only=True):
    """The error of an end of stable motion that is left out as harmonics of the force are held at their values.

    Attributes
    ----------
    nearest_end
        of stable motion; null where none was located
    standard_error
        of its `value` by the errors of the harmonics; null without `--record`, or where there are no derivatives
    """

    nearest_end: NearestEndData | None
    standard_error: float | None


class ChannelData(ResultsBlock, frozen=True, kw_only=True):
    """A channel from which impacts were picked.

    Attributes
    ----------
    name, impacts
        its name, and the number of its impacts
    noise
        standard deviation of the filtered signal between impacts, in the channel's unit
    rise_samples
        samples in the part of a rise that times are taken from: the median
    standard_error_s : s
        of the times of all channels: the median
    """

    name: str
    impacts: int
    noise: float
    rise_samples: float
    standard_error_s: float


class EstimateData(ResultsBlock, frozen=True, kw_only=True):
    """A value that was estimated, with its standard error.

    Attributes
    ----------
    value, standard_error : as in the scenario
        the value, and its standard error
    """

    value: float
    standard_error: float


class JudgedHarmonic(MeasuredHarmonic, frozen=True, kw_only=True):
    """A harmonic of the force in a record, and whether it is more than noise.

    Attributes
    ----------
    above_noise
        whether it is more than the noise
    """

    above_noise: bool = field(name="significant")


class RecordedForce(ResultsBlock, frozen=True, kw_only=True):
    """The force by the acceleration or displacement of the capsule in a record.

    Attributes
    ----------
    amplitude_n, frequency_hz
        of the sine
    maximum_s : s
        a time at which the force has its maximum
    phase_error_rad : rad
        standard error of the phase there
    offset_m_s2, noise_m_s2 : m/s²
        constant part of the acceleration, and standard deviation of what is not fitted
    harmonics
        those of orders 2 to 8
    """

    amplitude_n: EstimateData
    frequency_hz: EstimateData
    maximum_s: float
    phase_error_rad: float
    offset_m_s2: float
    noise_m_s2: float
    harmonics: list[JudgedHarmonic]


class RecordData(ResultsBlock, frozen=True, kw_only=True):
    """Raw signals, and what was picked from them.

    Attributes
    ----------
    samples, sampling_rate_hz : –, Hz
        number of samples, and their rate
    from_s, to_s : s
        times of the first and the last sample
    channels
        those of impacts
    impacts
        number of impacts on both membranes
    excitation
        the force; null without a channel of the capsule's motion
    findings
        what may be wrong with the record, in words
    reading
        as what the file was read, in words
    """

    samples: int
    sampling_rate_hz: float
    from_s: float
    to_s: float
    channels: list[ChannelData]
    impacts: int
    excitation: RecordedForce | None
    findings: list[str]
    reading: str = ""


class IdentifiedData(ResultsBlock, frozen=True, kw_only=True):
    """What a record says of a device: identified.json without its version and provenance.

    Attributes
    ----------
    identified
        the inputs; empty where the model does not fit
    covariance
        of these inputs, in their order
    phase_at_s : s
        time of the record at which the phase is given; null where the phase is known
    timing_error_s : s
        standard deviation of the errors of the times; null where the model does not fit
    time_step_s : s
        the step that times are rounded to, where that is the larger part of their errors; else null
    missed, false : s
        times of missed impacts, and of rows that are not impacts
    left_out : s
        stretches that no single missed impact explains
    misfit
        whether the model fits
    scenario
        the text of `identified.yaml` without its `measured:` block; null where there is none
    devices
        random devices that fit; null where their share is not known
    held_harmonics
        for a force with harmonics, how far they leave the nearest end of stable motion open; else null
    record
        the raw signals; absent without `--record`
    alerts
        what may be wrong with them, as in [results.json](results.md#requirements-and-alerts); absent without
    """

    identified: list[IdentifiedInputData]
    covariance: list[list[float]]
    phase_at_s: float | None
    timing_error_s: float | None
    time_step_s: float | None
    missed: list[float]
    false: list[float]
    left_out: list[Range]
    misfit: MisfitData
    scenario: str | None
    devices: MeasuredShare | None
    held_harmonics: HeldHarmonicsData | None
    record: RecordData | UnsetType = UNSET
    alerts: list[AlertData] | UnsetType = UNSET


def identified_data(identified: IdentifiedRecord, scenario: str | None, words: Words) -> IdentifiedData:
    """What a record says of a device.

    Parameters
    ----------
    identified : IdentifiedRecord
    scenario : str or None
        That of the device, as text.
    words : Words
        Those of the package.
    """
    answer, signals, held = identified.answer, identified.signals, identified.held
    fitted = answer.fit if isinstance(answer.fit, Fitted) else None
    origin, count = answer.origin_s, len(answer.identified)
    gaps: Iterable[Gap] = fitted.gaps if fitted else ()
    mass_kg = float(answer.inquiry.model.device.capsule_mass_kg)
    return IdentifiedData(
        identified=[_input(item) for item in answer.identified],
        covariance=fitted.adjusted.covariance[:count, :count].tolist() if fitted and count else [],
        phase_at_s=origin if Unknown.PHASE in answer.inquiry.unknowns else None,
        timing_error_s=answer.timing_error_s,
        time_step_s=None if answer.rounding is None else answer.rounding.step_s,
        missed=[gap.missed_s + origin for gap in gaps if gap.missed_s is not None],
        false=[time + origin for time in fitted.false] if fitted else [],
        left_out=[Range(from_=x.start_s + origin, to=x.end_s + origin) for x in gaps if x.missed_s is None],
        misfit=_misfit(answer.misfit, words),
        scenario=scenario,
        devices=identified.share,
        held_harmonics=None if held is None else _held(held),
        record=UNSET if signals is None else _record(signals, mass_kg, words),
        alerts=UNSET if signals is None else [alert.data for alert in record_alerts(signals.doubts)],
    )


def _input(item: IdentifiedInput) -> IdentifiedInputData:
    return IdentifiedInputData(
        name=item.unknown,
        unit=item.unknown.unit or "1",
        value=item.value,
        standard_error=item.error,
        from_=item.low,
        to=item.high,
    )


def _misfit(misfit: Misfit, words: Words) -> MisfitData:
    instead = misfit.explanation
    return MisfitData(
        statistic=misfit.statistic,
        p_value=misfit.p_value,
        accepted=misfit.accepted,
        reason=words("reason", misfit),
        alternative=None if instead is None else SWAPPED if instead.swapped else instead.unknown,
        alternative_value=instead.value if instead is not None and instead.unknown else None,
        alternative_standard_error=instead.standard_error if instead is not None and instead.unknown else None,
        untested=[
            *misfit.untested,
            *([SWAPPED] if misfit.swapped_untested else []),
            *([DISTORTION] if misfit.distortion_untested else []),
        ],
        hidden=[
            HiddenData(name=item.unknown, unit=item.unknown.unit, off=item.off, moves=dict(item.moves))
            for item in misfit.hidden
        ],
        flights_left_out=misfit.by_flights or None,
    )


def _held(held: HeldHarmonics) -> HeldHarmonicsData:
    end = held.end
    return HeldHarmonicsData(
        nearest_end=None
        if end is None
        else NearestEndData(
            parameter=end.parameter,
            unit=end.parameter.unit,
            kind=end.event,
            value=end.sweep_value,
            distance=end.distance,
        ),
        standard_error=held.error,
    )


def _record(signals: Signals, mass_kg: float, words: Words) -> RecordData:
    picked, shaker = signals.picked, signals.shaker
    recording = picked.recording
    return RecordData(
        samples=recording.samples,
        sampling_rate_hz=1 / recording.step_s,
        from_s=recording.start_s,
        to_s=recording.end_s,
        channels=_channels(picked),
        impacts=len(picked.times),
        excitation=None if shaker is None else _force(shaker, mass_kg),
        findings=[words("finding", finding) for finding in picked.findings],
        reading=recording.reading,
    )


def _channels(picked: Picked) -> list[ChannelData]:
    return [
        ChannelData(
            name=heard.channel.name,
            impacts=len(heard.times),
            noise=heard.noise,
            rise_samples=heard.rise_samples,
            standard_error_s=picked.middle_error_s,
        )
        for heard in picked.heard
    ]


def _force(shaker: ShakerMotion, mass_kg: float) -> RecordedForce:
    return RecordedForce(
        amplitude_n=EstimateData(value=mass_kg * shaker.amplitude, standard_error=mass_kg * shaker.amplitude_error),
        frequency_hz=EstimateData(value=shaker.frequency_hz, standard_error=shaker.frequency_error_hz),
        maximum_s=shaker.maximum_s,
        phase_error_rad=shaker.phase_error,
        offset_m_s2=shaker.offset,
        noise_m_s2=shaker.noise,
        harmonics=[JudgedHarmonic(**asdict(row), above_noise=row.significant) for row in shaker.harmonics],
    )
