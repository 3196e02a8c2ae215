"""What an identification opens with: the sentence, what to do, and the numbers, for each way a record may answer."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace as Thing

import numpy as np
import pytest
from msgspec.structs import replace

from vireport.design.measured import MeasuredShare
from vireport.identify.opening import identified_opening, open_opening
from vireport.measurement.flights import MeasuredImpacts, Unknown
from vireport.measurement.identification import Fitted, NoFit, Unfit
from vireport.measurement.inquiry import BOTH_MEMBRANES, Identification, Inquiry
from vireport.measurement.misfit import BetterFit, Hidden, Misfit
from vireport.measurement.picking import Doubt, RecordFinding
from vireport.measurement.rounding import Rounding
from vireport.measurement.screening import Gap, Screened
from vireport.study.judging.opening import WordedOpening
from vireport.study.judging.verdict import Status

VALUES = {
    Unknown.RESTITUTION: (0.5, 0.002),
    Unknown.RESTITUTION_BOTTOM: (0.52048, 0.00069),
    Unknown.RESTITUTION_TOP: (0.47066, 0.00087),
    Unknown.LENGTH: (0.720123, 0.00004),
    Unknown.FREQUENCY: (2.00001, 0.00002),
    Unknown.PHASE: (4.6854, 0.0016),
}
FITS = Misfit(7.1, 0.73, accepted=True)
CONTRADICTED = Misfit(7.1, 1e-9, accepted=False)
ALL = MeasuredShare(4096, 4096, 0.9991, 1.0)
GAPS = Gap(1.0, 2.0, 1.5), Gap(3.0, 4.0, 3.5)


def fitted(gaps: tuple[Gap, ...] = GAPS, relative: object = None) -> Fitted:
    adjusted = Thing(
        freedom=10_000,
        timing_error_s=1.01e-4,
        equations=Thing(relative=relative),
        model=Thing(value_of=lambda x: VALUES[x][0]),
        deviation_of=lambda x: VALUES[x][1],
    )
    return Fitted(
        adjusted,
        Screened(np.arange(393), np.ones(392, dtype=bool), gaps),
        MeasuredImpacts.undoubted(np.arange(394.0), np.ones(394)),
    )


def answer(
    misfit: Misfit = FITS,
    unknowns: tuple[Unknown, ...] = (*BOTH_MEMBRANES, Unknown.PHASE),
    found: Fitted | NoFit | None = None,
    rounding: Rounding | None = None,
) -> Identification:
    return Identification(Inquiry(Thing(), unknowns, ()), found or fitted(), misfit, 0.0, rounding)


def signals(*findings: RecordFinding) -> Thing:
    return Thing(doubts=(), picked=Thing(findings=findings))


def opened(
    own: Identification, signals: object = None, share: MeasuredShare | None = ALL, **of: object
) -> WordedOpening:
    given = {"held": None, "unused": ()} | of
    return identified_opening(own, 394, signals, share, **given).worded()


def tiles(opening: WordedOpening) -> dict[str, tuple[str, str]]:
    return {tile.label: (tile.value, tile.remark) for tile in opening.tiles}


def test_a_record_that_fits_says_so_with_its_numbers() -> None:
    opening = opened(answer())
    assert opening.status is Status.GOOD
    assert opening.sentence == "The record fits: restitution 0.520 at the bottom and 0.471 at the top."
    assert tiles(opening) == {
        "Restitution, bottom and top": ("0.519 to 0.522 and 0.469 to 0.472", "95 % intervals"),
        "Fit": ("p = 0.73", "no test rejects the model (at 0.01)"),
        "Impacts": ("394", "2 missed, 1 false"),
        "Timing error": ("101 µs", "of each time"),
    }
    assert opening.facts == (
        (Status.GOOD, "All 4,096 devices tried that fit the record keep stable 1:1 motion (at least 99.9 % do)."),
    )
    assert len(opening.lines) == 3


@pytest.mark.parametrize(
    ("unknowns", "sentence", "label", "value"),
    [
        ((Unknown.RESTITUTION, Unknown.PHASE), "restitution 0.5", "Restitution", "0.496 to 0.504"),
        ((Unknown.LENGTH,), "length 0.72012 m", "Length", "0.72004 to 0.72020 m"),
        (
            (Unknown.RESTITUTION, Unknown.LENGTH),
            "restitution 0.5, length 0.72012 m",
            "Restitution and length",
            "0.496 to 0.504 and 0.72004 to 0.72020 m",
        ),
    ],
)
def test_other_inputs_stand_with_their_units(unknowns, sentence: str, label: str, value: str) -> None:
    opening = opened(answer(unknowns=unknowns))
    assert opening.sentence == f"The record fits: {sentence}."
    assert tiles(opening)[label][0] == value
    untested = opened(answer(replace(FITS, p_value=None), unknowns))
    assert untested.sentence.endswith("; whether the model fits is not known.")
    assert untested.status is Status.CAUTION
    assert tiles(untested)["Fit"] == ("not tested", "nothing is left over to test the model with")


def test_many_inputs_stand_in_the_table() -> None:
    opening = opened(answer(unknowns=(*BOTH_MEMBRANES, Unknown.LENGTH)))
    assert opening.sentence == "The record fits, and gives 3 inputs."
    assert tiles(opening)["Identified"][0] == "3 inputs"


@pytest.mark.parametrize(
    ("given", "status", "fact"),
    [
        (
            {"share": MeasuredShare(4093, 4096, 0.99, 1.0)},
            Status.CAUTION,
            "Of 4,096 devices tried that fit the record, 4,093",
        ),
        (
            {"share": MeasuredShare(3, 4096, 0.0, 0.01)},
            Status.BAD,
            "Of 4,096 devices tried that fit the record, 3 keep",
        ),
        (
            {"share": MeasuredShare(64, 128, 0.4, 0.6, Unknown.LENGTH.design_input, 0.00012)},
            Status.CAUTION,
            "50 % of the devices that fit the record. Measure the length to 0.00012 m (standard error).",
        ),
        (
            {"share": MeasuredShare(64, 128, 0.4, 0.6, Unknown.LENGTH.design_input)},
            Status.CAUTION,
            "The error of the length costs most: measure it better.",
        ),
        (
            {"signals": signals(RecordFinding(Doubt.CLIPPED, "voltage_v", 3.0))},
            Status.CAUTION,
            "voltage_v is clipped at 3 impacts",
        ),
    ],
)
def test_what_is_doubtful_comes_first(given: dict, status: Status, fact: str) -> None:
    opening = opened(answer(), **given)
    assert opening.status is status
    assert opening.facts[0][0] is status
    assert fact in opening.facts[0][1]
    assert opening.lines[2] == opening.facts[0][1]


def test_what_a_record_hardly_shows_and_flights_left_out_are_told() -> None:
    moves = ((Unknown.RESTITUTION_BOTTOM, 0.018), (Unknown.RESTITUTION_TOP, -0.067))
    weak = (Hidden(Unknown.LENGTH, 0.09, moves), Hidden(Unknown.AMPLITUDE, 0.3, moves[:1]))
    opening = opened(answer(replace(FITS, hidden=weak, distortion_untested=True)))
    assert opening.status is Status.CAUTION
    assert "hardly shows a wrong length (by up to 0.09 m)" in opening.lines[2]
    assert "the restitution at the top (by up to 0.067)" in opening.lines[2]
    better = BetterFit(False, Unknown.LENGTH, 0.72, 1e-3, 1e-4)
    refused = Misfit(None, 0.5, False, alternative=Unknown.LENGTH, explanation=better, by_flights=9)
    assert tiles(opened(answer(refused)))["Fit"] == ("rejected", "it leaves out 9 flights that another value explains")


def test_what_a_record_cannot_show_and_rounding_are_told() -> None:
    hidden = replace(FITS, untested=(Unknown.LENGTH,), swapped_untested=True)
    opening = opened(
        answer(hidden, rounding=Rounding(1e-3, 9.0)), signals(RecordFinding(Doubt.OFFSET, "sound_pa", 0.3))
    )
    told = [text for status, text in opening.facts if status is Status.CAUTION]
    assert "which are taken from the scenario: another length, exchanged membranes." in told[0]
    assert "All times are multiples of 1 ms" in told[1]
    assert opening.facts[-1][0] is Status.NEUTRAL
    # What was added to rounded times that repeat themselves nine times is no error of theirs.
    assert tiles(opening)["Timing error"] == ("33.7 µs", "by the rounding of the times")
    assert tiles(opened(answer(found=fitted(relative=np.ones(3)))))["Timing error"][1].endswith("of the stated errors")
    gap = replace(GAPS[0], missed_s=None)
    assert tiles(opened(answer(found=fitted((*GAPS, gap)))))["Impacts"] == (
        "394",
        "2 missed, 1 false; flights left out: 1",
    )
    assert opened(answer(), unused=("voltage_v",)).facts[-1] == (Status.NEUTRAL, "Read and not used: voltage_v.")


def better(unknown: Unknown | None, value: float = 0.42, **of: object) -> Misfit:
    known = replace(BetterFit(unknown is None, unknown, value, 1.2e-4, 1e-4), **of)
    return replace(CONTRADICTED, alternative=Unknown.LENGTH, explanation=known)


@pytest.mark.parametrize(
    ("misfit", "sentence", "fact", "fits"),
    [
        (better(None), "bottom and top are exchanged.", "exchange them in the record", "bottom and top exchanged"),
        (
            better(Unknown.LENGTH),
            "the length is not that of the scenario.",
            "The length that fits is 0.42 ± 0.00012 m, if nothing else is wrong: measure it, and set device.",
            "length 0.42 m",
        ),
        (better(Unknown.FREQUENCY), "the frequency, or the record's clock, is off.", "excitation.frequency_hz", "Hz"),
        (better(Unknown.DRIFT), "the record's clock drifts.", "on one clock", "drift of the clock 0.42 1/s"),
        (
            better(Unknown.EXPONENT, -0.1, restitutions=((Unknown.RESTITUTION_TOP, 0.47),), speed_m_s=2.0),
            "the restitution changes with speed.",
            "device.restitution_exponent: -0.1, device.restitution_speed_m_s: 2, device.restitution_top: 0.47.",
            "−0.1",
        ),
        (better(Unknown.EXPONENT, 0.1), "the restitution changes with speed.", "have to grow with speed", "0.1"),
    ],
)
def test_a_contradiction_names_what_fits_and_what_to_do(misfit: Misfit, sentence: str, fact: str, fits: str) -> None:
    opening = opened(answer(misfit), share=None)
    assert opening.status is Status.BAD
    assert opening.sentence == f"The record contradicts the model: {sentence}"
    assert opening.facts[0][0] is Status.BAD
    assert fact in opening.facts[0][1]
    told = tiles(opening)
    assert fits in told["What fits"][0]
    assert told["What fits"][1] == "timing error 100 µs"
    assert told["Identified"][0] == "nothing"
    assert told["Fit"] == ("rejected", "p below 0.01")
    assert len(opening.lines) == 3


def test_clock_and_other_inputs_that_would_fit_are_named() -> None:
    for off, word in ((3e-5, "fast"), (-3e-5, "slow")):
        misfit = better(Unknown.FREQUENCY, clock_off=off, clock_accepted=1e-6, others=(Unknown.LENGTH,))
        facts = [text for _, text in opened(answer(misfit), share=None).facts]
        assert facts[1] == f"Or the record's clock is 30 ppm {word}: check its sampling rate."
        assert facts[2] == "Another length would fit as well."


def test_a_record_that_nothing_explains_says_what_to_look_for() -> None:
    unexplained = opened(answer(replace(CONTRADICTED, alternative=Unknown.LENGTH)), share=None)
    assert unexplained.sentence.endswith("it leaves more than the noise of the times.")
    assert "look for another harmonic of the force" in unexplained.facts[0][1]
    assert opened(answer(CONTRADICTED), share=None).sentence.endswith("errors of neighbouring impacts are alike.")
    said = set()
    for failure, value in product(Unfit, (1.25,)):
        none = NoFit(failure, value)
        opening = opened(answer(replace(CONTRADICTED, failure=none), found=none), share=None)
        said |= {opening.sentence, opening.facts[0][1]}
        assert tiles(opening)["Fit"][0] == "none"
        assert tiles(opening)["Impacts"] == ("394", "as they were recorded")
        assert "Timing error" not in tiles(opening)
    assert len(said) == 2 * len(Unfit)


def test_signals_that_determine_nothing_open_with_that() -> None:
    opening = open_opening("only an unstable periodic motion fits", signals()).worded()
    assert opening.sentence == "The record does not determine what is asked for."
    assert opening.facts[0] == (Status.BAD, "Only an unstable periodic motion fits.")
    assert "figure-record.png" in opening.facts[1][1]
