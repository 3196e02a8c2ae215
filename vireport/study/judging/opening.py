"""The opening of a report as data: a sentence that answers whether the device works, up to four facts, four numbers.

Python chooses what is said, and `templates/words/opening.j2` says it: each name here is that of a macro there. Page,
PDF, terminal, bench and notebook begin with the same opening.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from math import inf, isclose
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.base.records import brief
from vireport.motions.events import Event
from vireport.scenario.blocks import LeftOut
from vireport.study.judging.alerts import NEAR_CRITICAL, Alert, is_near_critical
from vireport.study.judging.evidence import unmet_criteria
from vireport.study.judging.findings import findings
from vireport.study.judging.least_margin import LimitedBy, MarginToUse
from vireport.study.judging.verdict import AddedConclusion, Conclusion, StableVoltages, Status, Verdict, judged_by
from vireport.text.alerts import AlertCode, Severity
from vireport.text.requirements import Question
from vireport.text.said import Said

if TYPE_CHECKING:
    from vireport.design.from_rest import FromRest
    from vireport.design.point import StableInterval
    from vireport.study.checks.reproduction import Reproduction

MOST_FACTS = 4
"""Facts of an opening: what a reader takes in at a glance."""

MOST_ENDINGS = 2
"""What the ball comes to from rest over a sweep, of which so much is said."""

GRAVITY = {Status.BAD: 0, Status.CAUTION: 1, Status.GOOD: 2, Status.NEUTRAL: 3}
"""Order of facts, the gravest first."""

ALIKE = 1e-6
"""Relative difference of voltages that counts as none: those of mirror images differ by rounding."""

SAID_OTHERWISE = {
    AlertCode.NO_STABLE_MOTION,
    AlertCode.DESIGN_NOT_STABLE,
    AlertCode.SEVERAL_STABLE_MOTIONS,
    AlertCode.NEAR_CRITICAL_POINT,
    AlertCode.DEEP_DEFLECTION,
    AlertCode.LONG_CONTACT,
    AlertCode.BREAKDOWN,
    AlertCode.MORE_ENERGY_THAN_LOST,
    AlertCode.SIMULATION_DISAGREES,
    AlertCode.COEXISTING_MOTIONS,
}
"""Alerts of which a fact or a tile has the substance."""


class Statement(Struct, frozen=True, eq=False):
    """A fact or a number of an opening, and what it means for the design."""

    status: Status
    said: Said

    __repr__ = brief


class FactPlace(Enum):
    """Where the facts of an addition stand among those of the core, of which the gravest are said."""

    AFTER_MOTION = "after those on the motion, and on how it is reached"
    AFTER_MARGIN = "after those on its margin"
    LAST = "last, but for how many starts come to it"


class WordedTile(Struct, frozen=True):
    """A number of an opening in words."""

    status: Status
    label: str
    value: str
    remark: str


class WordedOpening(Struct, frozen=True):
    """The opening of a report or of the terminal, in words.

    Attributes
    ----------
    status : Status
    word : str
        The conclusion in a few words, for titles and tables.
    sentence : str
    facts : tuple of (Status, str)
    tiles : tuple of WordedTile
    """

    status: Status
    word: str
    sentence: str
    facts: tuple[tuple[Status, str], ...] = ()
    tiles: tuple[WordedTile, ...] = ()

    @property
    def lines(self) -> list[str]:
        """The opening for a terminal: the sentence, the numbers of the tiles, and the gravest fact."""
        numbers = "; ".join(f"{tile.label}: {tile.value}" for tile in self.tiles)
        return [line for line in (self.sentence, numbers, *(text for _, text in self.facts[:1])) if line]

    @property
    def text(self) -> list[str]:
        """The whole opening, a line each."""
        numbers = [f"{tile.label}: {tile.value} ({tile.remark})" for tile in self.tiles]
        return [self.sentence, *(text for _, text in self.facts), *numbers]


class Opening(Struct, frozen=True, eq=False):
    """What a report opens with.

    Attributes
    ----------
    status : Status
    word : Said
        The conclusion in a few words.
    sentence : Said
    facts : tuple of Statement
        The gravest first, at most `MOST_FACTS`.
    tiles : tuple of Statement
        Their macros give what each is, the number, and what to know about it.
    """

    status: Status
    word: Said
    sentence: Said
    facts: tuple[Statement, ...] = ()
    tiles: tuple[Statement, ...] = ()

    __repr__ = brief

    def worded(self, templates: Path | None = None) -> WordedOpening:
        """Word the sentence, facts and tiles of the opening.

        Parameters
        ----------
        templates : Path, optional
            A folder whose words come before the package's own.

        Raises
        ------
        RenderError
            Where a macro fails, with the line.
        """
        return WordedOpening(
            self.status,
            self.word.words(templates),
            self.sentence.words(templates),
            tuple((fact.status, fact.said.words(templates)) for fact in self.facts),
            tuple(WordedTile(tile.status, *tile.said.parts(templates)) for tile in self.tiles),
        )


def gravest(facts: Iterable[Statement]) -> tuple[Statement, ...]:
    """Take as many facts as an opening has, the gravest first."""
    return tuple(sorted(facts, key=lambda fact: GRAVITY[fact.status])[:MOST_FACTS])


def opening_of(verdict: Verdict, alerts: Iterable[Alert] = (), again: Reproduction | None = None) -> Opening:
    """Choose what a report opens with.

    Parameters
    ----------
    verdict : Verdict
    alerts : iterable of Alert
        Warnings that no answer of the verdict contains are put among the facts.
    again : Reproduction or None
        Whether the simulation found the stable motion again.
    """
    facts, tiles = gravest(_facts(verdict, alerts, again)), tuple(_tiles(verdict, again))
    return Opening(verdict.status, Said("word", (verdict,)), _sentence(verdict), facts, tiles)


def _fact(status: Status, name: str, *values: object) -> Statement:
    return Statement(status, Said(name, values))


def _sentence(verdict: Verdict) -> Said:
    """The sentence of the conclusion, or the sentence on the sweep without a design point."""
    conclusion, solution = verdict.conclusion, verdict.evidence.solution
    if solution.design is None and conclusion is Conclusion.STABLE:
        return Said("stable_in_sweep", (verdict, *solution.settable_ranges[:1]))
    if conclusion is Conclusion.STABLE and not verdict.motion.data.types:
        return Said("stable_as_required", (Said(_running(verdict)),))
    if conclusion in (Conclusion.BOUNCING, Conclusion.NOT_BOUNCING):
        return _bouncing(verdict)
    if conclusion is Conclusion.BOUNCING_NEAR_END:
        return Said("bouncing_near_end", verdict.motion.data.instead[:1])
    margin = verdict.margin.data.to_use if verdict.margin is not None else None
    if conclusion is Conclusion.MARGIN_SMALL and margin is not None and margin.gone:
        return Said("margin_gone", (Said(_running(verdict)),))
    file = conclusion.words if isinstance(conclusion, AddedConclusion) else "opening"
    return Said(conclusion.name.lower(), (Said(_running(verdict)),), file)


def _bouncing(verdict: Verdict) -> Said:
    """The sentence on a ball on a table: its first stable motion, and where that is or whether the ball starts so."""
    words, end = verdict.motion.data.instead[:1], verdict.evidence.from_rest
    if verdict.evidence.solution.design is None and verdict.where is not None and words:
        return Said("bouncing_in_sweep", (*words, verdict.inequality(verdict.where.data[0])))
    name = "bouncing" if words else "not_bouncing"
    if end is None or not end.decided:
        return Said(name, words)
    if words and (end.word, end.periods) == (words[0].letters, words[0].periods):
        return Said("bouncing_by_itself", words)
    return Said(f"{name}_from_rest", (*words, _ending(end)))


def _running(verdict: Verdict) -> str:
    """The phrase on how the device runs with which most sentences begin."""
    if verdict.evidence.solution.design is None:
        return "runs_somewhere"
    followed = verdict.from_rest is not None and verdict.from_rest.data.from_rest is not None
    return "runs_by_itself" if followed and verdict.evidence.is_reached_from_rest else "runs"


def _facts(verdict: Verdict, alerts: Iterable[Alert], again: Reproduction | None) -> Iterator[Statement]:
    yield from _of_requirements(verdict)
    yield from _of_simulation(verdict, again)
    added = [finding.facts(verdict) for finding in findings().values()]
    yield from _of_motion(verdict)
    yield from _at(FactPlace.AFTER_MOTION, added)
    yield from _of_margin(verdict)
    yield from _at(FactPlace.AFTER_MARGIN, added)
    yield from _of_voltage(verdict)
    for alert in alerts:
        if alert.severity is not Severity.NOTE and alert.code not in SAID_OTHERWISE:
            yield _fact(Status.CAUTION, "alert", alert)
    yield from _at(FactPlace.LAST, added)
    if verdict.reached is not None and verdict.reached.data is not None:
        yield _fact(verdict.reached.status, "starts_reach_it", verdict.reached.data)


def _at(place: FactPlace, added: Iterable[Mapping[FactPlace, Iterable[Statement]]]) -> Iterator[Statement]:
    """The facts of additions at one place."""
    return (fact for facts in added for fact in facts.get(place, ()))


def _of_requirements(verdict: Verdict) -> Iterator[Statement]:
    if verdict.accepted is None:
        return
    missed = [criterion for criterion in verdict.accepted.data if not criterion.passed]
    if not missed and verdict.margin is not None and verdict.margin.data.short:
        yield _fact(Status.CAUTION, "requirements_met_rigidly", verdict.accepted.data)
        return
    name = "requirements_missed" if missed else "requirements_met"
    yield _fact(verdict.accepted.status, name, verdict.accepted.data, missed)


def _of_simulation(verdict: Verdict, again: Reproduction | None) -> Iterator[Statement]:
    check = verdict.evidence.crosscheck
    if check is not None and not check.passed:
        yield _fact(Status.BAD, "simulation_departs", check)
    elif check is not None and not check.orbits and check.motions:
        yield _fact(Status.NEUTRAL, "starts_end_in", check.motions[0], sum(motion.count for motion in check.motions))
    elif verdict.motion.data.types and again is not None and again.decided and not again.passed:
        yield _fact(Status.BAD, "not_reproduced", again)


def _of_motion(verdict: Verdict) -> Iterator[Statement]:
    """Which motion the ball has, and whether it gets there from rest."""
    motion, evidence = verdict.motion.data, verdict.evidence
    end = evidence.from_rest
    if motion.types and evidence.solution.design is not None:
        if end is None or evidence.is_reached_from_rest:
            yield _fact(Status.GOOD, "strikes_each", verdict)
        if motion.other_words:
            yield _fact(Status.NEUTRAL, "others_coexist", motion.other_words)
        return
    if motion.types:
        yield _fact(Status.GOOD, "strikes_each", verdict)
        return
    on_table = evidence.solution.on_table
    if on_table and motion.instead[1:]:
        name = "others_in_sweep" if evidence.solution.design is None else "others_on_table"
        yield _fact(Status.NEUTRAL, name, motion.instead[1:])
    elif motion.instead and not on_table:
        yield _fact(verdict.motion.status, "strikes_instead", motion.instead)
    if evidence.from_rest_along:
        status = Status.NEUTRAL if on_table else Status.CAUTION
        yield from (
            _fact(status, "comes_from_rest_over_sweep", _ending(x)) for x in evidence.from_rest_along[:MOST_ENDINGS]
        )
    if on_table:
        yield _fact(Status.NEUTRAL, "never_at_the_top")
    elif parts := evidence.solution.settable_ranges:
        yield _fact(Status.CAUTION, "stable_elsewhere", parts[0])
    elif motion.narrow:
        yield _fact(Status.CAUTION, "range_is_narrow", motion.narrow[0])
    elif not motion.instead:
        yield _fact(Status.CAUTION, "look_elsewhere")


def _ending(end: FromRest) -> Said:
    """What a ball that comes to no 1:1 motion does, as the end of a sentence."""
    name = f"ends_{end.destination.name.lower()}"
    return Said(name if end.word else f"{name}_without_period", (end,))


def _of_margin(verdict: Verdict) -> Iterator[Statement]:
    """What to change for more margin; how large it is, a tile says."""
    compliant, nearest = verdict.evidence.own_stiffness, verdict.margin.data if verdict.margin is not None else None
    end = nearest.compliant if nearest is not None else None
    if compliant is not None and compliant.motion is None:
        yield _fact(Status.CAUTION, "contacts_long")
    elif compliant is not None and (compliant.margin_gone or (end is not None and end.absence is not None)):
        yield _fact(Status.CAUTION, "contacts_last", compliant.motion)
    if nearest is None:
        return
    if nearest.unresolved:
        yield _fact(Status.CAUTION, "margin_not_resolved", nearest.unresolved)
    use = nearest.to_use
    if use is None or not (use.small or nearest.short):
        return
    if use.limited_by is LimitedBy.COMPLIANT and use.relative is None:
        return
    checks = [_check(use, verdict.evidence.solution.device.recoils)] if use.limited_by is LimitedBy.EFFECT else []
    if use.relative is None:
        yield _fact(Status.CAUTION, "lost_by_effect", *checks)
    else:
        yield _fact(Status.CAUTION, f"margin_small_{use.limited_by}", _way(verdict, use), *checks)


def _way(verdict: Verdict, use: MarginToUse) -> Said:
    """In which direction a design gains margin: away from the nearest end, unless the one on the other side is near."""
    design = verdict.evidence.solution.design
    assert design is not None
    beyond = (
        other.size
        for other in design.limits()
        if other.parameter is use.end.parameter and other.distance * use.end.distance < 0
    )
    if min(beyond, default=inf) < 2 * NEAR_CRITICAL:
        return Said("change_another", (use,))
    return Said("increase" if use.end.distance < 0 else "reduce", (use,))


def margin_said(verdict: Verdict) -> tuple[Said, Said] | None:
    """The margin to use, and what limits it; None where there is no stable motion at a design point.

    As texts of cells, after a macro for each case.
    """
    if verdict.margin is None:
        return None
    nearest = verdict.margin.data
    use, device = nearest.to_use, verdict.evidence.solution.device
    if nearest.unresolved:
        return Said("room_not_known"), Said("limited_by_rounding")
    if use is None:
        return Said("room_endless"), Said("limited_by_nothing")
    name = "room_gone" if use.gone else "room_absolute" if use.relative is None else "room"
    if use.limited_by is LimitedBy.EFFECT:
        return Said(name, (use,)), Said("limited_by_effect", (_effect(use, device.recoils),))
    limited_by = "rigid_only" if nearest.not_known and use.limited_by is LimitedBy.RIGID else use.limited_by
    return Said(name, (use,)), Said(f"limited_by_{limited_by}")


def _effect(use: MarginToUse, recoils: bool) -> Said:
    """A neglected effect as a noun, with its size."""
    assert use.shift is not None
    effect = use.shift.effect
    form = "_more" if effect.left_out.varied is not None and effect.size > 0 else ""
    return Said(f"with_{_left_out(use, recoils)}{form}", (abs(effect.size),))


def _check(use: MarginToUse, recoils: bool) -> Said:
    """How to know better what a neglected effect does; the input that is to be changed is not named again."""
    assert use.shift is not None
    named = use.relative is not None and use.parameter is use.shift.effect.left_out.varied
    return Said("check_it" if named else f"check_{_left_out(use, recoils)}")


def _left_out(use: MarginToUse, recoils: bool) -> str:
    """A neglected effect, as the end of a macro's name."""
    assert use.shift is not None
    left_out = use.shift.effect.left_out
    return f"{left_out.name.lower()}{'_prescribed' if left_out is LeftOut.CAPSULE and recoils else ''}"


def _of_voltage(verdict: Verdict) -> Iterator[Statement]:
    volts = verdict.voltage.data
    if volts is None:
        return
    if volts.impossible:
        yield _fact(Status.BAD, "takes_more_energy", volts)
    if volts.breaks_down:
        yield _fact(Status.BAD, "breaks_down", volts)
    if volts.severity is not None and not volts.contradictory:
        name = "extrapolated" if volts.field_share is not None else "extrapolated_thickness"
        yield _fact(volts.status, name, volts.stretch)


def _tile(status: Status, name: str, *values: object) -> Statement:
    return Statement(status, Said(f"tile_{name}", values))


def _tiles(verdict: Verdict, again: Reproduction | None) -> Iterator[Statement]:
    if (where := _where(verdict)) is not None:
        yield where
    if (margin := _margin(verdict)) is not None:
        yield margin
    if (rest := _from_rest(verdict, again)) is not None:
        yield rest
    yield _voltage(verdict)


def _where(verdict: Verdict) -> Statement | None:
    """Where the motion is stable: along the sweep, or in the input with the nearest end."""
    if verdict.where is None:
        return None
    parts, solution = verdict.where.data, verdict.evidence.solution
    if solution.sweep is None:
        if not parts:
            return None
        return _tile(verdict.where.status, range_name(parts[0], "of_input"), verdict, parts[0])
    if not parts:
        return _tile(verdict.where.status, "nowhere", solution.sweep)
    if len(parts) > 1:
        return _tile(verdict.where.status, "ranges", verdict, parts)
    return _tile(verdict.where.status, range_name(parts[0], "of_sweep"), verdict, parts[0])


def range_name(part: StableInterval, what: str) -> str:
    """Whether a range ends below, above, at both ends or at neither, as the beginning of a macro's name."""
    ends = (part.start_point is not None, part.end_point is not None)
    form = {(True, False): "above", (False, True): "below", (True, True): "between", (False, False): "throughout"}[ends]
    return f"{form}_{what}"


def _margin_on_bottom(verdict: Verdict) -> Statement | None:
    """How far the nearest end of the motion on a table is; None where none is known at a design point."""
    evidence = verdict.evidence
    if not evidence.bottom:
        return None
    if any(Event.LOST in (followed.below, followed.above) for followed in evidence.bottom):
        return _tile(Status.CAUTION, "margin_unresolved", evidence.bottom)
    end = next(iter(evidence.ends_on_bottom), None)
    missed = unmet_criteria(judged_by(Question.MARGIN, evidence.criteria))
    if end is None:
        return _tile(Status.BAD if missed else Status.GOOD, "margin_endless")
    status = Status.BAD if missed else Status.CAUTION if is_near_critical(end.relative) else Status.GOOD
    return _tile(status, "margin_on_bottom", end, evidence.bottom[0], evidence.exactness)


def _margin(verdict: Verdict) -> Statement | None:
    if verdict.margin is None:
        return _margin_on_bottom(verdict)
    nearest, status = verdict.margin.data, verdict.margin.status
    use = nearest.to_use
    if nearest.unresolved:
        return _tile(status, "margin_unresolved", nearest)
    if use is None:
        return _tile(status, "margin_endless")
    if use.limited_by is LimitedBy.EFFECT:
        effect = _effect(use, verdict.evidence.solution.device.recoils)
        return _tile(status, "margin_none_effect" if use.gone else "margin_effect", use, effect)
    if use.limited_by is LimitedBy.COMPLIANT:
        return _tile(status, "margin_none_soft" if use.gone else "margin_soft", use)
    if nearest.not_known:
        return _tile(status, "margin_rigid_only", verdict, use)
    return _tile(status, "margin_absolute" if use.relative is None else "margin", verdict, use)


def _from_rest(verdict: Verdict, again: Reproduction | None) -> Statement | None:
    evidence = verdict.evidence
    end = evidence.from_rest
    if end is None:
        return None
    agrees = "agrees" if again is not None and again.passed else "alone"
    status = verdict.from_rest.status if verdict.from_rest is not None else Status.CAUTION
    if evidence.is_reached_from_rest and end.settles_after is not None:
        return _tile(status, f"settles_{agrees}", verdict, end)
    if evidence.is_reached_from_rest:
        return _tile(status, "reached", end)
    if evidence.solution.on_table and end.decided:
        return _tile(Status.NEUTRAL, "bounces", _ending(end))
    return _tile(status, "elsewhere", _ending(end)) if end.decided else _tile(status, "undecided")


def _voltage(verdict: Verdict) -> Statement:
    volts = verdict.voltage.data
    if verdict.evidence.solution.membrane is None:
        return _tile(Status.NEUTRAL, "voltage_not_evaluated")
    if volts is None:
        return _tile(Status.NEUTRAL, "voltage_none")
    return _tile(verdict.voltage.status, _voltage_name(volts), verdict, volts)


def _voltage_name(volts: StableVoltages) -> str:
    if volts.contradictory:
        return "voltage_contradicted"
    form = "voltage" if isclose(volts.least_v, volts.most_v, rel_tol=ALIKE) else "voltages"
    return form if volts.severity is None else f"{form}_extrapolated"
