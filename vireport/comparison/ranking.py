"""Which scenario of a comparison is best, and why: requirements, stable motion, margin and voltage, in this order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf, isfinite
from typing import Any

from vireport.comparison.differences import listed
from vireport.design import DesignPoint, Margin
from vireport.scenario import DesignInput
from vireport.study import Study
from vireport.text import (
    ABSENT,
    AlertCode,
    Table,
    numbers,
    percent,
    quantity,
    texts,
)

DIGITS = 9
"""Significant digits in which two scenarios differ if one is to be better than the other."""

IMPACTS = 2
"""Of a 1:1 motion in one of its periods."""


class Merit(StrEnum):
    """What scenarios are ranked by, what matters most first; more is better."""

    REQUIREMENTS = "requirements"
    STABILITY = "stability"
    MARGIN = "smallest margin"
    RANGE = "stable range"
    VOLTAGE = "mean voltage"
    RATE = "voltage per second"


HEADS = {
    Merit.REQUIREMENTS: "Requirements",
    Merit.MARGIN: "Smallest margin",
    Merit.VOLTAGE: "Mean voltage",
    Merit.RATE: "Per second",
    Merit.RANGE: "Stable range",
}
"""Of the columns of merits that the verdict does not say."""


@dataclass(frozen=True, slots=True, eq=False)
class Ranked:
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
        Requirements not met, as a negative number; 1 for stable motion that no simulation contradicts, else 0; smallest
        margin [1], infinite where stable motion ends nowhere; width of the widest stable range, where there is no
        margin; U_ave [V] and voltage per second [V/s] of the stable motion at the design point, of several the least.
    """

    name: str
    rank: int
    study: Study
    margin: Margin | None
    merits: Mapping[Merit, float | None]

    @property
    def stable(self) -> bool:
        """Whether there is stable motion, at the design point where there is one."""
        return bool(self.merits[Merit.STABILITY])

    @property
    def passed(self) -> int:
        """Requirements that are met."""
        return sum(criterion.passed for criterion in self.study.criteria)

    def show(self, merit: Merit) -> str:
        """Print a merit with its unit; a dash where there is none."""
        value = self.merits[merit]
        if merit is Merit.REQUIREMENTS:
            return f"{self.passed} of {len(self.study.criteria)}" if self.study.criteria else ABSENT
        if merit is Merit.RANGE:
            return "; ".join(part.inequality for part in self.study.solution.stable_ranges) or ABSENT
        if value is None:
            design = self.study.solution.design
            return "not known" if merit is Merit.MARGIN and design is not None and design.unresolved else ABSENT
        if merit is Merit.MARGIN:
            size = percent(value) if isfinite(value) else "not limited"
            return f"{size} in {self.margin.parameter.quantity}" if self.margin is not None else size
        return quantity(value, "V/s" if merit is Merit.RATE else "V")

    def to_dict(self) -> dict[str, Any]:
        """Plain data, ready for JSON; an unlimited margin is null, and `margin_limited` false."""
        room = self.merits[Merit.MARGIN]
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
            "stable_range": [[part.start, part.end] for part in self.study.solution.stable_ranges],
        }


def ranking(names: Sequence[str], studies: Sequence[Study]) -> tuple[Ranked, ...]:
    """Rank scenarios, the best first, those that differ in no merit in their order."""
    swept = {study.solution.sweep.parameter for study in studies if study.solution.sweep is not None}
    rows = [(name, study, *_merits(study, len(swept) == 1)) for name, study in zip(names, studies, strict=True)]
    keys = [_key(merits) for *_, merits in rows]
    ranks = [1 + sum(other > key for other in keys) for key in keys]
    ranked = [
        Ranked(name, rank, study, margin, merits)
        for rank, (name, study, margin, merits) in zip(ranks, rows, strict=True)
    ]
    return tuple(sorted(ranked, key=lambda one: one.rank))


def _key(merits: Mapping[Merit, float | None]) -> tuple[float, ...]:
    return tuple(-inf if merits[x] is None else float(f"{merits[x]:.{DIGITS}g}") for x in Merit)


def _merits(study: Study, alike: bool) -> tuple[Margin | None, dict[Merit, float | None]]:
    """The margin and the merits of a scenario; `alike` says whether all sweeps are of one parameter."""
    solution, check = study.solution, study.crosscheck
    design = solution.design
    stable = bool(design.motions.stable.any()) if design is not None else bool(solution.stable_ranges)
    margin, room = _room(design) if design is not None and stable else (None, None)
    # Ranges of different parameters are compared by their width over their middle.
    widths = [
        (part.end - part.start) / (1.0 if alike else (part.start + part.end) / 2) for part in solution.stable_ranges
    ]
    voltage = None
    if design is not None and stable and design.voltages is not None:
        voltage = float(design.voltages.average_v[design.motions.stable].min())
    per_second = IMPACTS * float(solution.device.frequency_hz or 0.0) / solution.device.period_ratio
    return margin, {
        Merit.REQUIREMENTS: float(sum(criterion.passed for criterion in study.criteria) - len(study.criteria)),
        Merit.STABILITY: float(stable and (check is None or check.passed)),
        Merit.MARGIN: room,
        Merit.RANGE: max(widths, default=None) if room is None else None,
        Merit.VOLTAGE: voltage,
        Merit.RATE: None if voltage is None else per_second * voltage,
    }


def _room(design: DesignPoint) -> tuple[Margin | None, float | None]:
    """The nearest end of stable motion and its relative distance, as far as it has one."""
    if design.unresolved:
        return None, None
    ends = [(one, abs(one.relative)) for one in design.endings() if one.relative is not None]
    return ends[0] if ends else (None, inf)


def headline(ranked: Sequence[Ranked]) -> str:
    """Which scenario is best and why, what is traded for it, and which cannot be compared."""
    return " ".join((_best(ranked), *_traded(ranked), *_remarks(ranked)))


def _best(ranked: Sequence[Ranked]) -> str:
    first = ranked[0]
    names = [one.name for one in ranked if one.rank == 1]
    following = ranked[len(names)] if len(names) < len(ranked) else None
    reasons = [_reason(first, following) if following is not None else "margin and voltage are the same"]
    if not any(one.stable for one in ranked):
        lead = f"No scenario has stable 1:1 motion {_where(first)}."
        return lead if following is None else f"{lead} Of them {listed(names)} ranks first: {reasons[0]}."
    if first.stable:
        reasons.insert(0, f"there is stable 1:1 motion {_where(first)}")
    if first.study.criteria and (following is None or _decisive(first, following) is not Merit.REQUIREMENTS):
        reasons.insert(0, f"{first.show(Merit.REQUIREMENTS)} requirements are met")
    *others, last = reasons
    why = f"{', '.join(others)}, and {last}" if others else last
    return f"{listed(names)} {'is best' if len(names) == 1 else 'are equally good'}: {why}."


def _where(one: Ranked) -> str:
    return "in the sweep" if one.study.solution.design is None else "at the design point"


def _decisive(one: Ranked, other: Ranked) -> Merit:
    """The merit that puts one scenario before another."""
    pairs = zip(Merit, _key(one.merits), _key(other.merits), strict=True)
    return next(merit for merit, x, y in pairs if x != y)


def _reason(one: Ranked, following: Ranked) -> str:
    """What puts a scenario before the following one, with the numbers of both."""
    merit = _decisive(one, following)
    if merit is Merit.STABILITY:
        return f"there is none in {following.name}"
    what = {
        Merit.REQUIREMENTS: "more requirements are met",
        Merit.MARGIN: "the smallest margin is the largest",
        Merit.RANGE: "the stable range is the widest",
        Merit.VOLTAGE: f"of those with a margin of {one.show(Merit.MARGIN)} the mean voltage is the highest",
        Merit.RATE: f"of those with a margin of {one.show(Merit.MARGIN)} the impacts are the most frequent",
    }[merit]
    return f"{what} ({one.show(merit)}; next {following.name}, {following.show(merit)})"


def _traded(ranked: Sequence[Ranked]) -> Iterator[str]:
    """What gives the most voltage of those that are as good in requirements and stability, and with what margin."""
    first = ranked[0]
    rivals = [one for one in ranked if _key(one.merits)[:2] == _key(first.merits)[:2]]
    told = {first.name}
    for merit in (Merit.VOLTAGE, Merit.RATE):
        top = max(rivals, key=lambda one: one.merits[merit] or 0.0)
        mine, most = first.merits[merit] or 0.0, top.merits[merit] or 0.0
        if mine > 0 and round(most / mine - 1, DIGITS) > 0 and top.name not in told:
            told.add(top.name)
            more = percent(most / mine - 1, signed=True)
            margin = top.show(Merit.MARGIN)
            yield f"{top.name} has the highest {merit} ({top.show(merit)}, {more}) and a margin of {margin}."


def _remarks(ranked: Sequence[Ranked]) -> Iterator[str]:
    """What cannot be compared, or only with reserve."""
    some: tuple[tuple[str, Callable[[Ranked], bool]], ...] = (
        ("Not stable", lambda one: not one.stable),
        ("No design point, and so no margin to compare", lambda one: one.study.solution.design is None),
        ("No device.ball_mass_kg, and so no voltage to compare", lambda one: one.study.solution.membrane is None),
    )
    for words, holds in some:
        names = [one.name for one in ranked if holds(one)]
        if 0 < len(names) < len(ranked):
            yield f"{words}: {listed(names)}."
    outside = [one.name for one in ranked if not one.study.solution.within_membrane]
    if outside:
        whose = "all" if len(outside) == len(ranked) else listed(outside)
        code = AlertCode.OUTSIDE_MEMBRANE_GEOMETRY
        yield f"Voltages outside the membrane's geometry, for ranking only ({code}): {whose}."


def ranking_table(ranked: Sequence[Ranked]) -> Table:
    """The ranking with the numbers that it rests on."""
    shown = [merit for merit in HEADS if any(one.show(merit) != ABSENT for one in ranked)]
    rows = tuple(
        (one.name, str(one.rank), one.study.verdict.word, *(one.show(merit) for merit in shown)) for one in ranked
    )
    note = (
        "Ranked by requirements met, stable 1:1 motion, smallest margin over all inputs and voltage. Mean voltage is "
        "U_ave of the stable motion at the design point, of several the least; per second, the sum over its impacts."
    )
    columns = (*texts("Scenario"), *numbers("Rank"), *texts("Verdict", *(HEADS[merit] for merit in shown)))
    return Table("Ranking, the best first", columns, rows, note)


def margins_table(ranked: Sequence[Ranked]) -> Table | None:
    """The nearest end of stable motion along each input; None where no scenario has one."""
    designs = [(one.name, one.study.solution.design) for one in ranked]
    rows = tuple((name, *_ends(x)) for name, x in designs if x is not None and x.motions.stable.any())
    if not rows:
        return None
    note = (
        "Distance from the design point to the first point at which stable motion ends, over the design value: "
        "B period doubling, C fold or pitchfork, G grazing. From an inclination of 0° the distance is in degrees."
    )
    heads = (f"{x.quantity} {x.symbol}" for x in DesignInput)
    return Table("Margins in each input", (*texts("Scenario"), *numbers(*heads)), rows, note)


def _ends(design: DesignPoint) -> Iterator[str]:
    for varied in DesignInput:
        if varied in design.unresolved:
            yield "not known"
            continue
        end = min((x for x in design.endings() if x.parameter is varied), key=lambda x: abs(x.distance), default=None)
        if end is None:
            yield "none"
        elif end.relative is None:
            yield f"{'+' if end.distance > 0 else ''}{varied.show(end.distance, 3)} {end.event.letter}"
        else:
            yield f"{percent(end.relative, signed=True)} {end.event.letter}"
