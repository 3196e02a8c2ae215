"""Which scenario of a comparison is best, and why: requirements, stable motion, margin and voltage, in this order.

Before the margin come outcome from rest, recovery and least shock, where they are asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from math import inf, isfinite
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from vireport.comparison.messages import Message, listed
from vireport.design import DesignPoint, Margin
from vireport.scenario import DesignInput
from vireport.shocks import Withstood
from vireport.study import Study
from vireport.text import ABSENT, AlertCode, Table, numbers, percent, quantity, significant, texts, visible

RANKED_DIGITS = 9
"""Significant digits in which two scenarios differ if one is to be better than the other."""

IMPACTS_PER_PERIOD = 2
"""Impacts of a 1:1 motion in one of its periods."""


class Merit(StrEnum):
    """What scenarios are ranked by, what matters most first, some only where asked for; more of each is better.

    Attributes
    ----------
    head : str
        Of its column; "" for stable motion, which the verdict says.
    reason : Message
        Why the scenario that has more of it comes first.
    """

    head: str
    reason: Message

    def __new__(cls, words: str, head: str, reason: Message) -> Merit:
        """Make the member whose value is what it is in words."""
        member = str.__new__(cls, words)
        member._value_, member.head, member.reason = words, head, reason
        return member

    REQUIREMENTS = "requirements", "Requirements", Message.FEWER_MISSED
    STABILITY = "stability", "", Message.STABLE_ALONE
    FROM_REST = "reached from rest", "From rest", Message.REACHED_ALONE
    RECOVERY = "recovery", "Recovery", Message.FASTEST_RECOVERY
    SHOCK = "least shock", "Least shock", Message.LARGEST_SHOCK
    MARGIN = "smallest margin", "Smallest margin", Message.LARGEST_MARGIN
    RANGE = "stable range", "Stable range", Message.WIDEST_RANGE
    VOLTAGE = "mean voltage", "Mean voltage", Message.HIGHEST_VOLTAGE
    RATE = "voltage per second", "Per second", Message.MOST_FREQUENT


RANK_BY = {"from-rest": Merit.FROM_REST, "recovery": Merit.RECOVERY, "shock": Merit.SHOCK}
"""What scenarios are ranked by only where it is asked for, by its name on the command line."""

ALWAYS = tuple(merit for merit in Merit if merit not in RANK_BY.values())
VOLTAGES = Merit.VOLTAGE, Merit.RATE
FIRST = Merit.REQUIREMENTS, Merit.STABILITY
"""What no other merit makes up for."""

RANKING_COLUMNS = (Merit.REQUIREMENTS, *RANK_BY.values(), Merit.MARGIN, Merit.VOLTAGE, Merit.RATE, Merit.RANGE)
"""Columns of the ranking, in which a wide one comes last."""


class Ranked(Struct, frozen=True, eq=False):
    """A scenario and its place among those that it is compared with.

    Attributes
    ----------
    name : str
    rank : int
        From 1; the same for scenarios that differ in no merit.
    study : Study
    margin : Margin or None
        To the nearest end of stable motion over all inputs; None where the design point has no stable motion, or it
        ends nowhere, or where is not known.
    merits : mapping of Merit to float or None
        Requirements not met, as a negative number; 1 for stable motion that no simulation contradicts, else 0; 1 where
        1:1 motion is reached from rest, else 0; forcing periods until 1 % of a small disturbance is left, as a negative
        number; least shock found [m/s] of the stable 1:1 motions, or else of what is reached from rest, at most what
        was tried in every scenario without one; smallest margin [1],
        infinite where stable motion ends nowhere; width of the widest stable range, where there is no margin; U_ave [V]
        and voltage per second [V/s] of the stable motion at the design point, of several the least.
    order : tuple of Merit
        What it is ranked by, what matters most first.
    """

    name: str
    rank: int
    study: Study
    margin: Margin | None
    merits: Mapping[Merit, float | None]
    order: tuple[Merit, ...] = ALWAYS

    def __repr__(self) -> str:
        return f"<Ranked {self.rank}: {visible(self.name)}, {self.study.verdict.word}>"

    @property
    def stable(self) -> bool:
        """Whether there is stable motion, at the design point where there is one."""
        return bool(self.merits[Merit.STABILITY])

    @property
    def key(self) -> tuple[float, ...]:
        """The merits, rounded; of two scenarios the one with the larger key is better."""
        # What has no margin, or no voltage, comes after all that have one.
        values = (self.merits[merit] for merit in self.order)
        return tuple(-inf if value is None else float(f"{value:.{RANKED_DIGITS}g}") for value in values)

    @property
    def passed(self) -> int:
        """Requirements that are met."""
        return sum(criterion.passed for criterion in self.study.criteria)

    def show(self, merit: Merit) -> str:
        """Print a merit with its unit, or a dash where there is none."""
        value = self.merits[merit]
        if merit is Merit.REQUIREMENTS:
            count = len(self.study.criteria)
            return Message.OF_THEM.format(part=self.passed, count=count) if count else ABSENT
        if merit is Merit.RANGE:
            return "; ".join(self.study.verdict.inequalities) or ABSENT
        if merit in RANK_BY.values():
            return self._disturbed(merit, value)
        if value is None:
            design = self.study.solution.design
            return (
                Message.NOT_KNOWN
                if merit is Merit.MARGIN and design is not None and design.unresolved_inputs
                else ABSENT
            )
        if merit is not Merit.MARGIN:
            return quantity(value, "V/s" if merit is Merit.RATE else "V")
        if self.margin is None:
            return Message.NOT_LIMITED
        return Message.MARGIN_IN.format(share=percent(value), varied=self.margin.parameter.quantity)

    def _disturbed(self, merit: Merit, value: float | None) -> str:
        """Print what becomes of the motion as the device is switched on, or bumped."""
        found, withstood = self.study.disturbances, _withstood(self.study)
        if merit is Merit.FROM_REST:
            return found.from_rest.name if found is not None and found.from_rest is not None else ABSENT
        if value is None:
            return ABSENT
        if merit is Merit.RECOVERY:
            return Message.PERIODS.format(count=significant(-value, 3))
        if withstood is not None and withstood.jump_m_s is not None:
            return quantity(withstood.jump_m_s, "m/s")
        return Message.MORE_THAN.format(size=quantity(_withstands_all(self.study) or 0.0, "m/s"))

    def to_dict(self) -> dict[str, Any]:
        """Give plain data, ready for JSON; an unlimited margin is null, and `margin_limited` false."""
        room, found, withstood = self.merits[Merit.MARGIN], self.study.disturbances, _withstood(self.study)
        return {
            "scenario": self.name,
            "rank": self.rank,
            "verdict": self.study.verdict.word,
            "requirements_met": self.passed,
            "requirements": len(self.study.criteria),
            "stable": self.stable,
            "smallest_margin": room if room is not None and isfinite(room) else None,
            "margin_limited": None if room is None else isfinite(room),
            "margin_parameter": None if self.margin is None else str(self.margin.parameter),
            "margin_kind": None if self.margin is None else str(self.margin.event),
            "u_ave_v": self.merits[Merit.VOLTAGE],
            "u_per_second_v": self.merits[Merit.RATE],
            "from_rest": None if found is None or found.from_rest is None else found.from_rest.destination,
            "recovery_periods": None if found is None or found.recovery is None else found.recovery.periods,
            "least_jump_m_s": None if withstood is None else withstood.jump_m_s,
            "stable_range": [[part.start, part.end] for part in self.study.solution.stable_ranges],
        }


def rank_studies(studies: Mapping[str, Study], asked: Sequence[Merit] = ()) -> tuple[Ranked, ...]:
    """Rank scenarios, given by their names, the best first; those that differ in no merit stay in their order.

    What is asked for comes after stable motion, and before the margin.
    """
    order = (*FIRST, *asked, *(merit for merit in ALWAYS if merit not in FIRST))
    swept = {study.solution.sweep.parameter for study in studies.values() if study.solution.sweep is not None}
    # Two that stand all that was tried cannot be told apart by how far that was: what is tried in all is compared.
    tried = min((size for study in studies.values() if (size := _withstands_all(study)) is not None), default=inf)
    unranked = [
        Ranked(name, 1, study, *_merits(study, len(swept) == 1, tried), order) for name, study in studies.items()
    ]
    ranked = [replace(scenario, rank=1 + sum(other.key > scenario.key for other in unranked)) for scenario in unranked]
    return tuple(sorted(ranked, key=lambda scenario: scenario.rank))


def _withstood(study: Study) -> Withstood | None:
    """What the motion in use withstands: the stable 1:1 motions or, where there are none, what is reached from rest."""
    if study.withstood is not None or study.attracting is None:
        return study.withstood
    return study.attracting.withstood(study.attracting.reached)


def _withstands_all(study: Study) -> float | None:
    """Size up to which shocks were tried, where none leads out [m/s]."""
    withstood = _withstood(study)
    return None if withstood is None or withstood.jump_m_s is not None else withstood.searched_to_m_s


def _merits(study: Study, alike: bool, tried: float) -> tuple[Margin | None, dict[Merit, float | None]]:
    """Find the margin and the merits of a scenario.

    `alike` says whether all sweeps are of one parameter, `tried` up to which size all that stand all are known to.
    """
    solution, check = study.solution, study.crosscheck
    design = solution.design
    stable = bool(design.motions.stable_mask.any()) if design is not None else bool(solution.stable_ranges)
    margin, room = _room(design) if design is not None and stable else (None, None)
    # Metres and newtons have no order: ranges of different parameters are compared by their width over their middle.
    widths = [
        (part.end - part.start) / (1.0 if alike else (part.start + part.end) / 2) for part in solution.stable_ranges
    ]
    voltage = None if design is None else design.u_ave_v
    found, withstood = study.disturbances, _withstood(study)
    shock = _withstands_all(study)
    if withstood is not None and withstood.jump_m_s is not None:
        shock = withstood.jump_m_s
    per_second = IMPACTS_PER_PERIOD * float(solution.device.frequency_hz or 0.0) / solution.device.period_ratio
    return margin, {
        Merit.REQUIREMENTS: float(sum(criterion.passed for criterion in study.criteria) - len(study.criteria)),
        Merit.STABILITY: float(stable and (check is None or check.passed)),
        Merit.FROM_REST: None if found is None or found.from_rest is None else float(found.from_rest.reached),
        Merit.RECOVERY: None if found is None or found.recovery is None else -found.recovery.periods,
        Merit.SHOCK: None if shock is None else min(shock, tried),
        Merit.MARGIN: room,
        Merit.RANGE: max(widths, default=None) if room is None else None,
        Merit.VOLTAGE: voltage,
        Merit.RATE: None if voltage is None else per_second * voltage,
    }


def _room(design: DesignPoint) -> tuple[Margin | None, float | None]:
    """Find the nearest end of stable motion and its relative distance, infinite where there is no end."""
    # An end that rounding does not resolve may be nearer than all that are known.
    if design.unresolved_inputs:
        return None, None
    ends = [(end, abs(end.relative)) for end in design.limits() if end.relative is not None]
    return ends[0] if ends else (None, inf)


def best_and_why(ranked: Sequence[Ranked]) -> Iterator[str]:
    """Tell which scenario is best and why, what is traded for it, and which cannot be compared, in sentences."""
    yield from _best(ranked)
    yield from _traded(ranked)
    yield from _remarks(ranked)


def _best(ranked: Sequence[Ranked]) -> Iterator[str]:
    first = ranked[0]
    best = [scenario.name for scenario in ranked if scenario.rank == 1]
    following = ranked[len(best)] if len(best) < len(ranked) else None
    names, where = listed(best), _where(first)
    reasons = [Message.SAME if following is None else _reason(first, following)]
    if not any(scenario.stable for scenario in ranked):
        yield Message.NONE_STABLE.format(where=where)
        if following is not None:
            yield Message.FIRST_OF_THEM.format(names=names, s="s" * (len(best) == 1), reason=reasons[0])
        return
    if first.stable:
        reasons.insert(0, Message.STABLE.format(where=where))
    if first.study.criteria and (following is None or _decisive(first, following) is not Merit.REQUIREMENTS):
        reasons.insert(0, Message.REQUIREMENTS_MET.format(requirements=first.show(Merit.REQUIREMENTS)))
    *others, last = reasons
    why = Message.AND.format(others=", ".join(others), last=last) if others else last
    yield (Message.BEST if len(best) == 1 else Message.EQUALLY_GOOD).format(names=names, reasons=why)


def _where(scenario: Ranked) -> str:
    return Message.IN_SWEEP if scenario.study.solution.design is None else Message.AT_DESIGN_POINT


def _decisive(better: Ranked, following: Ranked) -> Merit:
    """Find the merit that puts one scenario before another."""
    pairs = zip(better.order, better.key, following.key, strict=True)
    return next(merit for merit, mine, theirs in pairs if mine != theirs)


def _reason(better: Ranked, following: Ranked) -> str:
    """Tell what puts a scenario before the following one, with the numbers of both."""
    merit = _decisive(better, following)
    mine, theirs = _told(better, merit), _told(following, merit)
    return merit.reason.format(mine=mine, next=following.name, theirs=theirs, margin=_with_margin(better))


def _told(scenario: Ranked, merit: Merit) -> str:
    """Print a merit within a reason."""
    if merit is Merit.REQUIREMENTS:
        # Those that are missed, not those that are met: 1 of 1 met comes before 3 of 4, and so does nothing required.
        count = len(scenario.study.criteria)
        return Message.OF_THEM.format(part=count - scenario.passed, count=count)
    shown = scenario.show(merit)
    return Message.NONE if shown == ABSENT else shown


def _with_margin(scenario: Ranked) -> str:
    """Print the margin of a stable motion at a design point within a sentence; it may be unlimited, or not known."""
    message = Message.WITH_OTHER_MARGIN if scenario.margin is None else Message.WITH_MARGIN
    return message.format(margin=scenario.show(Merit.MARGIN))


def _traded(ranked: Sequence[Ranked]) -> Iterator[str]:
    """Tell what gives more voltage than the best, of those as good in requirements and stability, with its margin."""
    first = ranked[0]
    rivals = [scenario for scenario in ranked if scenario.key[: len(FIRST)] == first.key[: len(FIRST)]]
    told = {first.name}
    for merit in VOLTAGES:
        top = max(rivals, key=lambda scenario: scenario.merits[merit] or 0.0)
        mine, most = first.merits[merit] or 0.0, top.merits[merit] or 0.0
        if mine > 0 and round(most / mine - 1, RANKED_DIGITS) > 0 and top.name not in told:
            told.add(top.name)
            more, margin = percent(most / mine - 1, signed=True), _with_margin(top)
            voltage = top.show(merit)
            yield Message.TRADED.format(name=top.name, merit=merit, voltage=voltage, more=more, margin=margin)


def _remarks(ranked: Sequence[Ranked]) -> Iterator[str]:
    """Tell what cannot be compared, or only with reserve."""
    for message, concerned in (
        (Message.NOT_STABLE, [scenario for scenario in ranked if not scenario.stable]),
        (Message.NO_DESIGN_POINT, [scenario for scenario in ranked if scenario.study.solution.design is None]),
        (Message.NO_BALL_MASS, [scenario for scenario in ranked if scenario.study.solution.membrane is None]),
    ):
        if 0 < len(concerned) < len(ranked):
            yield message.format(names=listed([scenario.name for scenario in concerned]))
    alerts = {scenario.name: {alert.code for alert in scenario.study.alerts} for scenario in ranked}
    deep = [name for name, codes in alerts.items() if AlertCode.DEEP_DEFLECTION in codes]
    if deep:
        names = Message.ALL if len(deep) == len(ranked) else listed(deep)
        yield Message.DEEP.format(code=AlertCode.DEEP_DEFLECTION, names=names)


def ranking_table(ranked: Sequence[Ranked]) -> Table:
    """Set the ranking with the numbers that it rests on."""
    order = ranked[0].order
    asked = [merit for merit in RANKING_COLUMNS if merit in order]
    shown = [merit for merit in asked if any(scenario.show(merit) != ABSENT for scenario in ranked)]
    extra = "".join(f"{merit}, " for merit in order if merit in RANK_BY.values())
    rows = tuple(
        (scenario.name, str(scenario.rank), scenario.study.verdict.word, *map(scenario.show, shown))
        for scenario in ranked
    )
    columns = (*texts("Scenario"), *numbers("Rank"), *texts("Verdict", *(merit.head for merit in shown)))
    return Table(Message.RANKING, columns, rows, Message.RANKED_BY.format(asked=extra))


def margins_table(ranked: Sequence[Ranked]) -> Table | None:
    """Set the nearest end of stable motion along each input; None where no scenario has stable motion."""
    designs = [(scenario.name, scenario.study.solution.design) for scenario in ranked]
    rows = tuple(
        (name, *_ends(design)) for name, design in designs if design is not None and design.motions.stable_mask.any()
    )
    if not rows:
        return None
    heads = (f"{varied.quantity} {varied.symbol}" for varied in DesignInput)
    return Table(Message.MARGINS, (*texts("Scenario"), *numbers(*heads)), rows, Message.DISTANCES)


def _ends(design: DesignPoint) -> Iterator[str]:
    """Print the nearest end of stable motion along each input, with the letter of its kind."""
    for varied in DesignInput:
        along = (end for end in design.limits() if end.parameter is varied)
        nearest = min(along, key=lambda end: abs(end.distance), default=None)
        if varied in design.unresolved_inputs:
            yield Message.NOT_KNOWN
        elif nearest is None:
            yield Message.NONE
        elif nearest.relative is None:  # the design value is zero, as the inclination of a horizontal capsule is
            yield f"{'+' if nearest.distance > 0 else ''}{varied.show(nearest.distance, 3)} {nearest.event.letter}"
        else:
            yield f"{percent(nearest.relative, signed=True)} {nearest.event.letter}"
