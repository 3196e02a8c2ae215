"""What an identification opens with: whether the record fits and what it gives, what to do, and four numbers.

The macros that say it are in `vireport/identify/templates/words/identify.j2`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from msgspec import Struct

from vireport.design.measured import HeldHarmonics, MeasuredShare
from vireport.measurement.flights import Unknown
from vireport.measurement.identification import Fitted
from vireport.measurement.inquiry import BOTH_MEMBRANES, Identification, IdentifiedInput
from vireport.measurement.misfit import LEVEL, BetterFit, Hidden, Misfit
from vireport.measurement.picking import Doubt
from vireport.measurement.records import Record
from vireport.measurement.signals import Signals
from vireport.study.judging.alerts import record_alerts
from vireport.study.judging.opening import Opening, Statement, gravest
from vireport.study.judging.verdict import Status
from vireport.text.formatting import ROUGHLY, measured, rounded_text
from vireport.text.said import Said, words_of

_said = words_of("identify")

MOST_NAMED = 2
"""Inputs up to which each stands in the sentence and among the numbers."""

HARMLESS = Doubt.OFFSET, Doubt.UNEVEN, Doubt.REPEATED
"""What is wrong with a signal and was put right."""

OF_CLOCK_OR_LAW = Unknown.FREQUENCY, Unknown.DRIFT, Unknown.EXPONENT
"""What may be wrong otherwise than by a wrong input, each with words of its own."""


class IdentifiedRecord(Struct, frozen=True, eq=False):
    """The answer that a record gives, and what follows of it.

    Attributes
    ----------
    answer : Identification
    record : Record
    signals : Signals or None
        That the impacts were picked from.
    share : MeasuredShare or None
        Of devices that fit the record, those with stable motion.
    held : HeldHarmonics or None
    """

    answer: Identification
    record: Record
    signals: Signals | None
    share: MeasuredShare | None
    held: HeldHarmonics | None


def identified_opening(identified: IdentifiedRecord) -> Opening:
    """Choose what an identification opens with."""
    answer, signals, held = identified.answer, identified.signals, identified.held
    misfit, record = answer.misfit, identified.record
    tiles = (*_identified(answer), _fit(misfit, answer), _impacts(answer, len(record.times)), *_timing(answer))
    if not misfit.accepted:
        facts = gravest([*_instead(misfit), *_of_signals(signals)])
        return Opening(Status.BAD, _said("word_contradicts"), _contradiction(misfit), facts, tiles)
    every = [*_of_stability(identified.share), *_of_record(answer), *_of_signals(signals)]
    every += [Statement(Status.NEUTRAL, _said("held", held))] if held is not None else []
    every += [Statement(Status.NEUTRAL, _said("not_used", record.unused))] if record.unused else []
    facts = gravest(every)
    gravity = {fact.status for fact in (*facts, *tiles)}
    status = next((fact for fact in (Status.BAD, Status.CAUTION) if fact in gravity), Status.GOOD)
    return Opening(status, _said("word_fits"), _sentence(answer), facts, tiles)


def open_opening(why: str, signals: Signals) -> Opening:
    """Choose what raw signals open with from which nothing could be identified, as `why` says."""
    facts = gravest([Statement(Status.BAD, _said("is_open", why)), *_of_signals(signals)])
    return Opening(Status.BAD, _said("word_open"), _said("not_determined"), facts)


def _sentence(answer: Identification) -> Said:
    inputs = _inputs(answer)
    form = "fits" if answer.misfit.p_value is not None else "explains"
    if tuple(item.unknown for item in inputs) == BOTH_MEMBRANES:
        return _said(f"{form}_both", *map(_value, inputs))
    if len(inputs) > MOST_NAMED:
        return _said(f"{form}_many", len(inputs))
    return _said(f"{form}_inputs", [_said("with_value", item.unknown, _in_unit(item, _value(item))) for item in inputs])


def _inputs(answer: Identification) -> list[IdentifiedInput]:
    """The identified inputs of the device; the phase of the force is one of the record alone."""
    return [item for item in answer.identified if item.unknown is not Unknown.PHASE]


def _value(item: IdentifiedInput) -> str:
    return _rounded(item.value, item)


def _rounded(value: float, item: IdentifiedInput) -> str:
    """A value, or an end of its interval, to a digit more than half of that leaves."""
    return rounded_text(value, item.half / 2)


def _in_unit(item: IdentifiedInput, text: str) -> str:
    return f"{text} {item.unknown.unit}".rstrip()


def _contradiction(misfit: Misfit) -> Said:
    better = misfit.explanation
    if better is None:
        if misfit.failure is not None:
            return _said(f"contradicts_{misfit.failure.failure.name.lower()}")
        return _said("contradicts_correlated" if misfit.alternative is None else "contradicts_unexplained")
    if better.unknown is None:
        return _said("contradicts_swapped")
    if better.unknown in OF_CLOCK_OR_LAW:
        return _said(f"contradicts_{better.unknown.name.lower()}")
    return _said("contradicts_input", better.unknown)


def _instead(misfit: Misfit) -> Iterator[Statement]:
    """Statements of what would explain a record that contradicts the model, and what to do."""
    better = misfit.explanation
    if better is None or better.unknown is None:
        name = "exchange" if better is not None else "look_for_cause"
        if better is None and misfit.failure is not None:
            name = f"mend_{misfit.failure.failure.name.lower()}"
        yield Statement(Status.BAD, _said(name, misfit.failure))
        return
    if better.unknown is Unknown.EXPONENT:
        yield Statement(Status.BAD, _said("give_law" if better.value < 0 else "no_such_law", better))
    else:
        name = "mend_clock" if better.unknown is Unknown.DRIFT else "give_input"
        yield Statement(
            Status.BAD, _said(name, better, _of_better(better), rounded_text(better.standard_error, ROUGHLY))
        )
    if better.clock_accepted:
        yield Statement(Status.BAD, _said("clock_fast" if better.clock_off > 0 else "clock_slow", better))
    if better.others:
        yield Statement(Status.CAUTION, _said("others_fit", better.others))


def _of_better(better: BetterFit) -> str:
    return measured(better.value, better.standard_error)


def _of_stability(share: MeasuredShare | None) -> Iterator[Statement]:
    if share is None:
        return
    if not share.said:
        name = "stability_open" if share.needed is None else "stability_needs"
        yield Statement(Status.CAUTION, _said(name, share))
    elif share.share == 1:
        yield Statement(Status.GOOD, _said("all_stable", share))
    else:
        status = Status.CAUTION if share.share > 1 / 2 else Status.BAD
        yield Statement(status, _said("some_stable", share))


def _of_record(answer: Identification) -> Iterator[Statement]:
    """Statements of what an accepted fit leaves untested: hidden inputs, untested causes, rounded times."""
    misfit = answer.misfit
    unseen = misfit.untested, misfit.swapped_untested, misfit.distortion_untested
    if misfit.hidden:
        yield Statement(Status.CAUTION, _said("hidden", misfit.hidden, most_hidden(misfit.hidden)))
    if any(unseen):
        yield Statement(Status.CAUTION, _said("untested", *unseen))
    if answer.rounding is not None:
        yield Statement(Status.CAUTION, _said("rounded", answer.rounding))


def most_hidden(hidden: Sequence[Hidden]) -> list[tuple[Unknown, float]]:
    """The most by which each restitution makes up for an input that may be wrong unseen."""
    moves = [move for one in hidden for move in one.moves]
    return [(x, max(abs(by) for unknown, by in moves if unknown is x)) for x in dict(moves)]


def _of_signals(signals: Signals | None) -> Iterator[Statement]:
    """Statements on doubts about the signals that impacts were picked from."""
    if signals is None:
        return
    for alert in record_alerts(signals.doubts):
        yield Statement(Status.CAUTION, Said("alert", (alert,)))
    for finding in signals.picked.findings:
        status = Status.NEUTRAL if finding.doubt in HARMLESS else Status.CAUTION
        yield Statement(status, _said("finding", finding))
    yield Statement(Status.NEUTRAL, _said("check_picked"))


def _identified(answer: Identification) -> Iterator[Statement]:
    if not answer.misfit.accepted:
        yield Statement(Status.BAD, _said("tile_nothing"))
        return
    inputs = _inputs(answer)
    ends = [(_rounded(item.low, item), _in_unit(item, _rounded(item.high, item))) for item in inputs]
    if tuple(item.unknown for item in inputs) == BOTH_MEMBRANES:
        yield Statement(Status.GOOD, _said("tile_both", *ends))
    elif len(inputs) > MOST_NAMED:
        yield Statement(Status.GOOD, _said("tile_many", len(inputs)))
    else:
        yield Statement(Status.GOOD, _said(f"tile_{len(inputs)}", [item.unknown for item in inputs], *ends))


def _fit(misfit: Misfit, answer: Identification) -> Statement:
    if not isinstance(answer.fit, Fitted):
        return Statement(Status.BAD, _said("tile_no_fit"))
    if misfit.by_flights:
        return Statement(Status.BAD, _said("tile_flights", misfit.by_flights))
    if not misfit.accepted:
        return Statement(Status.BAD, _said("tile_rejected", LEVEL))
    if misfit.p_value is None:
        return Statement(Status.CAUTION, _said("tile_not_tested"))
    return Statement(Status.GOOD, _said("tile_fit", misfit.p_value, LEVEL))


def _impacts(answer: Identification, impacts: int) -> Statement:
    fitted = answer.fit
    if not isinstance(fitted, Fitted):
        return Statement(Status.NEUTRAL, _said("tile_impacts_alone", impacts))
    missed = sum(gap.missed_s is not None for gap in fitted.gaps)
    name = "tile_impacts_and_gaps" if fitted.lost else "tile_impacts"
    return Statement(Status.NEUTRAL, _said(name, len(fitted.impacts), missed, len(fitted.false), fitted.lost))


def _timing(answer: Identification) -> Iterator[Statement]:
    """The timing error, or what fits instead."""
    better, fitted, error = answer.misfit.explanation, answer.fit, answer.timing_error_s
    if better is not None:
        offset = "" if better.unknown is None else f"{_of_better(better)} {better.unknown.unit}".rstrip()
        yield Statement(
            Status.NEUTRAL, _said("tile_swapped" if better.unknown is None else "tile_instead", better, offset)
        )
    elif isinstance(fitted, Fitted):
        name = "tile_timing_weighted" if fitted.adjusted.equations.relative is not None else "tile_timing"
        yield Statement(Status.NEUTRAL, _said("tile_timing_rounded" if answer.rounding is not None else name, error))
