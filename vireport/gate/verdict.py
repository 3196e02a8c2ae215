"""The answer in a sentence: whether there is stable motion, where, with what margin, and at what voltage.

Turns a study into words; a reader who stops after them must not have been misled.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from vireport.analysis import (
    CriticalKind,
    DesignPoint,
    Family,
    Margin,
    Solution,
    Stability,
)
from vireport.gate.alerts import NEAR_CRITICAL
from vireport.gate.criteria import Criterion, unmet
from vireport.gate.wording import capital, range_text
from vireport.scenario import Parameter
from vireport.text import (
    percent,
    quantity,
    significant,
)

if TYPE_CHECKING:
    from vireport.trust import Compliance, CrossCheck


Status = Literal["good", "caution", "bad", "neutral"]

MOTION, WHERE, MARGIN, VOLTAGE = "Is there stable motion?", "Where?", "With what margin?", "What voltage?"
SIMULATED = "Does the simulation agree?"
RIGID = "Is the rigid model good enough?"
ACCEPTED = "Are the requirements met?"
NOT_KNOWN, NOT_VERIFIED = "Not known", "Not verified"
OUTSIDE = "outside the membrane model"


@dataclass(frozen=True, slots=True)
class Fact:
    """A question that every reader has, and its answer.

    Attributes
    ----------
    question, answer, detail : str
    status : str
        ``good``, ``caution``, ``bad``, or ``neutral`` where there is nothing to judge.
    short : str
        The answer as the headline has it, or "".
    """

    question: str
    answer: str
    detail: str
    status: Status
    short: str = ""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a study comes to.

    Attributes
    ----------
    status : str
        ``good``, ``caution`` or ``bad``: of the motion, at the design point where one is given.
    word : str
        The status in a few words.
    headline : str
        One or two sentences of plain text.
    facts : tuple of Fact
        Motion, range, margin, voltage, as far as they apply.
    """

    status: Status
    word: str
    headline: str
    facts: tuple[Fact, ...]


def verdict_of(
    solution: Solution,
    crosscheck: CrossCheck | None,
    compliance: Compliance | None,
    criteria: tuple[Criterion, ...],
) -> Verdict:
    """Judge what was found out about a scenario.

    Parameters
    ----------
    solution : Solution
    crosscheck : CrossCheck or None
    compliance : Compliance or None
    criteria : tuple of Criterion
        What the scenario requires; () where nothing is required.
    """
    motion = _motion(solution)
    status: Status = motion.status
    word = "Stable" if status == "good" else "Not stable"
    facts = [motion]
    if solution.sweep is not None or status == "good":
        facts.append(_where(solution))
    if solution.design is not None and status == "good":
        margin = _margin(solution, solution.design)
        facts.append(margin)
        if margin.status == "caution":
            status, word = (
                "caution",
                f"Stable, margin {'not known' if margin.answer == NOT_KNOWN else 'small'}",
            )
    facts.append(_voltage(solution))
    headline = _headline(solution, facts)
    if compliance is not None and compliance.grade is not None:
        facts.append(_rigid(compliance))
        if facts[-1].status == "bad" and status == "good":
            status, word = "caution", "Stable, by a rigid model that is not good enough"
    if crosscheck is not None:
        facts.append(_simulated(crosscheck))
        if not crosscheck.passed:
            status, word = "caution", NOT_VERIFIED
            headline = f"Not verified: the simulation does not agree with the solution. {headline}"
    if criteria:
        facts.insert(0, _accepted(criteria))
        if missed := unmet(criteria):
            headline = f"{missed}. {headline}"
            if status != "bad" and word != NOT_VERIFIED:
                status, word = "bad", "Requirements not met"
    return Verdict(status, word, headline, tuple(facts))


def _rigid(made: Compliance) -> Fact:
    from vireport.trust import GRADES

    grade = made.grade or 0
    statuses: tuple[Status, ...] = ("good", "caution", "bad")
    detail = "See the section on compliant membranes"
    return Fact(RIGID, f"It is {GRADES[grade]}", detail, statuses[grade])


def _simulated(check: CrossCheck) -> Fact:
    if not check.orbits:
        return Fact(SIMULATED, "Nothing to compare", "There is no stable 1:1 motion at the values simulated", "neutral")
    largest = significant(max(check.velocity_difference, check.phase_difference), 2)
    if check.passed:
        detail = f"It ends on all {check.orbits} stable orbits tried; largest difference {largest}"
        return Fact(SIMULATED, "Yes", detail, "good")
    detail = (
        f"It leaves {len(check.misses)} of {check.orbits} stable orbits; largest difference on the others {largest}"
    )
    return Fact(SIMULATED, "No", detail, "bad")


def _accepted(criteria: tuple[Criterion, ...]) -> Fact:
    met, count = sum(one.passed for one in criteria), len(criteria)
    detail = f"{met} of {count}: see the acceptance table"
    return Fact(ACCEPTED, "Yes", detail, "good") if met == count else Fact(ACCEPTED, "No", detail, "bad")


def _motion(solution: Solution) -> Fact:
    design = solution.design
    if design is None:
        found = {part.stability for branch in solution.branches for part in branch.segments() if part.stable}
        kinds = ", ".join(word for word in Stability if word in found)
        if kinds:
            return Fact(MOTION, "Yes", f"{capital(kinds)} in the sweep", "good")
        return Fact(MOTION, "No", "No admissible 1:1 motion in the sweep attracts the motions nearby", "bad")
    at, stable = _design_words(solution), design.motions.stable
    count, admissible = int(stable.sum()), int(design.motions.admissible.sum())
    if not count:
        detail = f"{admissible} admissible 1:1 motion{'s' * (admissible != 1)} at {at}, none of them stable"
        detail = detail if admissible else f"No admissible 1:1 motion at {at}"
        return Fact(MOTION, "No", detail, "bad", "no stable motion")
    found = {Stability(design.motions.words[row]) for row in np.nonzero(stable)[0]}
    kinds = ", ".join(word for word in Stability if word in found)
    others = f"; {count} stable motions coexist" if count > 1 else ""
    if count == 2 and solution.horizontal and _mirrored(design):
        others = "; two mirror images"
    return Fact(MOTION, "Yes", f"{capital(kinds)} at {at}{others}", "good", kinds)


def _mirrored(design: DesignPoint) -> bool:
    """Whether the stable motions are asymmetric ones, which come in pairs where the capsule is horizontal."""
    pairs = zip(design.families, design.motions.stable, strict=True)
    return all(family is Family.ASYMMETRIC for family, stable in pairs if stable)


def _design_words(solution: Solution) -> str:
    """The design point: the swept value, or all four where nothing is swept."""
    names = (solution.parameter,) if solution.sweep is not None else tuple(Parameter)
    values = ((name, float(getattr(solution.device, name))) for name in names)
    return ", ".join(f"{swept.symbol} = {swept.show(value)}" for swept, value in values)


def _where(solution: Solution) -> Fact:
    sweep = solution.sweep
    if sweep is None:
        parts = solution.design.stable if solution.design else ()
        answer = f"{len(parts)} range{'s' * (len(parts) != 1)}"
        return Fact(WHERE, answer, "; ".join(map(range_text, parts)), "good")
    parts, swept = solution.stable_ranges, sweep.parameter
    ends = f"{swept.show(sweep.start)} to {swept.show(sweep.end)}"
    if not parts:
        return Fact(WHERE, "Nowhere", f"in the sweep of {swept.quantity} from {ends}", "bad")
    reasons = [
        f"{swept.show(value)}: {point.kind.words} {point.label}"
        for part in parts
        for value, point in part.ends
        if point is not None
    ]
    ended = f"Ends at {'; '.join(reasons)}" if reasons else "Throughout the sweep"
    return Fact(WHERE, "; ".join(map(range_text, parts)), f"{ended}. Sweep of {swept.quantity}: {ends}", "good")


def _margin(solution: Solution, design: DesignPoint) -> Fact:
    limits = [margin for margin in design.margins if margin.ends_stability]
    if not design.stable:
        short = "margin not known, outside the sweep"
        return Fact(MARGIN, NOT_KNOWN, "The design point lies outside the sweep", "caution", short)
    if not limits:
        detail = "No critical point ends the stable range within what was searched"
        return Fact(MARGIN, "Not limited", detail, "good", "no critical point near")
    first = limits[0]
    swept = first.parameter
    relative = None if first.relative is None else abs(first.relative)
    size = percent(relative) if relative is not None else swept.show(abs(first.distance), 3)
    point = f"{first.kind.words} {first.label}"
    side = "below" if first.distance < 0 else "above"
    detail = f"{capital(point)} at {swept.symbol} = {swept.show(first.sweep_value)}, {side} the design point"
    detail += _handover(design, first)
    near = relative is not None and relative < NEAR_CRITICAL
    where = f" in {swept.symbol}" if solution.sweep is None else ""
    short = f"margin {size}{where} to {point}"
    return Fact(MARGIN, f"{size} in {swept.symbol}", detail, "caution" if near else "good", short)


def _handover(design: DesignPoint, limit: Margin) -> str:
    """The pitchfork, if any, that a symmetric motion meets before its stable range ends."""
    if not limit.distance or not design.families or design.families[0] is not Family.SYMMETRIC:
        return ""
    swept = limit.parameter
    for margin in design.margins:
        within = 0 < margin.distance / limit.distance < 1
        if margin.parameter == limit.parameter and margin.kind is CriticalKind.PITCHFORK and within:
            place = f"{swept.symbol} = {swept.show(margin.sweep_value)}"
            return f"; before it, at {place} ({margin.label}), two asymmetric motions take over from the symmetric one"
    return ""


def _voltage(solution: Solution) -> Fact:
    if solution.membrane is None:
        return Fact(VOLTAGE, "Not evaluated", "device.ball_mass_kg is not given", "neutral")
    volts, depths, place = _stable_voltages(solution)
    if not volts.size:
        return Fact(VOLTAGE, "None", "There is no stable motion to evaluate it for", "neutral")
    ends = dict.fromkeys(quantity(float(end), "V") for end in (volts.min(), volts.max()))
    answer = f"U_ave = {' to '.join(ends)}"
    depth, radius = float(depths.max()), solution.membrane.active_radius_m
    deep = quantity(depth, "m", 3)
    if depth <= radius:
        detail = f"{place}; deflection up to {deep}, inside the membrane model"
        return Fact(VOLTAGE, answer, detail, "good", answer)
    excess = f"deflection {deep}, {significant(depth / radius, 2)} times the active radius"
    detail = f"{place}. {capital(OUTSIDE)} ({excess}): a ranking, not volts"
    return Fact(VOLTAGE, answer, detail, "caution", f"{answer} ({OUTSIDE})")


def _stable_voltages(solution: Solution) -> tuple[np.ndarray, np.ndarray, str]:
    """U_ave and deflection of the stable motions at the design point or in the sweep, and where that is."""
    design = solution.design
    if design is not None and (x := design.voltages) is not None:
        stable = design.motions.stable
        return x.average_v[stable], x.deflection_m[stable], "At the design point"
    volts, depths = [np.empty(0)], [np.empty(0)]
    for branch in solution.branches:
        for part in branch.segments():
            if part.stable and (x := branch.voltages) is not None:
                volts.append(x.average_v[part.first : part.last + 1])
                depths.append(x.deflection_m[part.first : part.last + 1])
    return np.concatenate(volts), np.concatenate(depths), "Over the stable range"


def _headline(solution: Solution, facts: list[Fact]) -> str:
    """One sentence on the motion, and one on the design point and the voltage."""
    motion, *rest = facts
    n = solution.device.period_ratio
    name = "1:1 motion" if n == 1 else f"1:1 motion of {n} forcing periods"
    shorts = [fact.short for fact in rest if fact.short]
    if solution.sweep is None:
        detail = motion.detail[:1].lower() + motion.detail[1:]
        lead = f"{'Stable' if motion.status == 'good' else 'No stable'} {name}: {detail}"
    else:
        where = next((fact for fact in rest if fact.question == WHERE and fact.status == "good"), None)
        lead = f"Stable {name} for {where.answer}" if where else f"No stable {name} in the sweep"
        if solution.design is not None:
            shorts.insert(0, f"at the design point {_design_words(solution)}: {motion.short}")
    return f"{lead}. {capital(', '.join(shorts))}." if shorts else f"{lead}."
