"""What an identification opens with: the sentence, what to do, and the numbers, for each way a record may answer."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import SimpleNamespace as Thing

import numpy as np
import pytest
from msgspec.structs import replace
from pages import read_back

from vireport.design.measured import MeasuredShare
from vireport.identify.opening import IdentifiedRecord, identified_opening, open_opening
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
GRAVITY = Status.BAD, Status.CAUTION, Status.GOOD, Status.NEUTRAL
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
    own: Identification,
    signals: object = None,
    share: MeasuredShare | None = ALL,
    held: object = None,
    unused: tuple[str, ...] = (),
) -> WordedOpening:
    record = Thing(times=range(394), unused=unused)
    return identified_opening(IdentifiedRecord(own, record, signals, share, held)).worded()


def better(unknown: Unknown | None, value: float = 0.42, **of: object) -> Misfit:
    known = replace(BetterFit(unknown is None, unknown, value, 1.2e-4, 1e-4), **of)
    return replace(CONTRADICTED, alternative=Unknown.LENGTH, explanation=known)


def contradicted(misfit: Misfit, found: NoFit | None = None) -> WordedOpening:
    return opened(answer(misfit, found=found), share=None)


def clock_off(off: float) -> Misfit:
    return better(Unknown.FREQUENCY, clock_off=off, clock_accepted=1e-6, others=(Unknown.LENGTH,))


LENGTH = Unknown.LENGTH.design_input
MOVES = (Unknown.RESTITUTION_BOTTOM, 0.018), (Unknown.RESTITUTION_TOP, -0.067)
WEAK = Hidden(Unknown.LENGTH, 0.09, MOVES), Hidden(Unknown.AMPLITUDE, 0.3, MOVES[:1])
BY_FLIGHTS = replace(better(Unknown.LENGTH), p_value=0.5, by_flights=9)
ROUNDED = Rounding(1e-3, 9.0)
OPENINGS: dict[str, Callable[[], WordedOpening]] = {
    "fits": lambda: opened(answer()),
    "one restitution": lambda: opened(answer(unknowns=(Unknown.RESTITUTION, Unknown.PHASE))),
    "a length": lambda: opened(answer(unknowns=(Unknown.LENGTH,))),
    "a restitution and a length": lambda: opened(answer(unknowns=(Unknown.RESTITUTION, Unknown.LENGTH))),
    "many inputs": lambda: opened(answer(unknowns=(*BOTH_MEMBRANES, Unknown.LENGTH))),
    "not tested, both": lambda: opened(answer(replace(FITS, p_value=None))),
    "not tested, a length": lambda: opened(answer(replace(FITS, p_value=None), (Unknown.LENGTH,))),
    "not tested, many": lambda: opened(answer(replace(FITS, p_value=None), (*BOTH_MEMBRANES, Unknown.LENGTH))),
    "some devices are not stable": lambda: opened(answer(), share=MeasuredShare(4093, 4096, 0.99, 1.0)),
    "few devices are stable": lambda: opened(answer(), share=MeasuredShare(3, 4096, 0.0, 0.01)),
    "a needed error": lambda: opened(answer(), share=MeasuredShare(64, 128, 0.4, 0.6, LENGTH, 0.00012)),
    "a costly error": lambda: opened(answer(), share=MeasuredShare(64, 128, 0.4, 0.6, LENGTH)),
    "clipped signals": lambda: opened(answer(), signals(RecordFinding(Doubt.CLIPPED, "voltage_v", 3.0))),
    "hardly shown": lambda: opened(answer(replace(FITS, hidden=WEAK, distortion_untested=True))),
    "flights left out explain it": lambda: opened(answer(BY_FLIGHTS)),
    "not shown, and rounded times that repeat themselves": lambda: opened(
        answer(replace(FITS, untested=(Unknown.LENGTH,), swapped_untested=True), rounding=ROUNDED),
        signals(RecordFinding(Doubt.OFFSET, "sound_pa", 0.3)),
    ),
    "stated errors": lambda: opened(answer(found=fitted(relative=np.ones(3)))),
    "flights left out": lambda: opened(answer(found=fitted((*GAPS, replace(GAPS[0], missed_s=None))))),
    "a column not used": lambda: opened(answer(), unused=("voltage_v",)),
    "exchanged": lambda: contradicted(better(None)),
    "another length": lambda: contradicted(better(Unknown.LENGTH)),
    "another frequency": lambda: contradicted(better(Unknown.FREQUENCY)),
    "a drifting clock": lambda: contradicted(better(Unknown.DRIFT)),
    "falls with speed": lambda: contradicted(
        better(Unknown.EXPONENT, -0.1, restitutions=((Unknown.RESTITUTION_TOP, 0.47),), speed_m_s=2.0)
    ),
    "grows with speed": lambda: contradicted(better(Unknown.EXPONENT, 0.1)),
    "a fast clock": lambda: contradicted(clock_off(3e-5)),
    "a slow clock": lambda: contradicted(clock_off(-3e-5)),
    "unexplained": lambda: contradicted(replace(CONTRADICTED, alternative=Unknown.LENGTH)),
    "errors that are alike": lambda: contradicted(CONTRADICTED),
    **{
        f"no fit: {failure.name}": partial(contradicted, replace(CONTRADICTED, failure=none), none)
        for failure in Unfit
        for none in (NoFit(failure, 1.25),)
    },
    "not determined": lambda: open_opening("only an unstable periodic motion fits", signals()).worded(),
}


def lines_of(opening: WordedOpening) -> list[str]:
    tiles = (f"{tile.status.name} {tile.label} | {tile.value} | {tile.remark}" for tile in opening.tiles)
    facts = (f"{status.name} {text}" for status, text in opening.facts)
    return [f"{opening.status.name} {opening.word}", opening.sentence, *tiles, *facts]


def test_every_answer_of_a_record_opens_as_is_kept() -> None:
    """Of each what the first one does not say."""
    lines = usual = lines_of(OPENINGS["fits"]())
    for name, make in OPENINGS.items():
        lines = [*lines, "", name, *(line for line in lines_of(make()) if line not in usual)]
    assert read_back("identify, openings", lines) == []


@pytest.mark.parametrize("name", OPENINGS)
def test_the_gravest_comes_first_and_three_lines_are_printed(name: str) -> None:
    opening = OPENINGS[name]()
    assert len(opening.lines) <= 3
    assert opening.status is min([opening.status, *(status for status, _ in opening.facts)], key=GRAVITY.index)
    assert [status for status, _ in opening.facts] == sorted((s for s, _ in opening.facts), key=GRAVITY.index)
