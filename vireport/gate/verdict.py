"""The answer in a sentence: whether there is stable motion, where, with what margin, and at what voltage.

Turns a study into words; a reader who stops after them must not have been misled.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from vireport.design import (
    DesignPoint,
    Margin,
    Solution,
    StableInterval,
)
from vireport.gate.alerts import MOST_MOTIONS, NEAR_CRITICAL
from vireport.gate.requirements import (
    Criterion,
    Evidence,
    Question,
    unmet,
)
from vireport.motions import (
    Event,
    Stability,
    Sweep,
    Symmetry,
)
from vireport.scenario import DesignInput, Parameter
from vireport.text import (
    capital,
    percent,
    quantity,
    significant,
)

if TYPE_CHECKING:
    from vireport.checks import CrossCheck, MotionCount
    from vireport.design import Tolerances
    from vireport.membranes import Grade
    from vireport.motions import Atlas
    from vireport.physics import Word

OUTSIDE = "outside the membrane model"

FIXED_D = (DesignInput.INCLINATION, DesignInput.RESTITUTION)
"""Inputs that d does not depend on."""

SWEEP_END = "end of the sweep"
"""What ends a stable range that no critical point ends."""


class Status(StrEnum):
    """What an answer means for the design."""

    GOOD = "good"
    CAUTION = "caution"
    BAD = "bad"
    NEUTRAL = "neutral"


@dataclass(frozen=True, slots=True)
class Fact:
    """A question and the answer.

    The status is neutral where there is nothing to judge; `short` is the answer as the headline has it, or "".
    """

    question: str
    answer: str
    detail: str
    status: Status
    short: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What a study comes to.

    The status is that of the motion, at the design point where one is given; the word says it in a few words, and the
    headline in one or two sentences of plain text. `instead` says what the ball does at the design point, or without
    one somewhere in the sweep, if no 1:1 motion is stable there and others are known that are; it has no full stop, and
    is "" else.
    """

    status: Status
    word: str
    headline: str
    facts: tuple[Fact, ...]
    instead: str = ""


def range_text(part: StableInterval) -> str:
    """Print a stable range as an inequality, strict at a critical point."""
    low, high = ("≤" if point is None else "<" for _, point in part.ends)
    parameter = part.parameter
    return f"{parameter.show(part.start)} {low} {parameter.symbol} {high} {parameter.show(part.end)}"


def verdict_of(evidence: Evidence) -> Verdict:
    """Judge what was found out about a scenario; without criteria nothing is required."""
    solution, crosscheck, tolerances = evidence.solution, evidence.crosscheck, evidence.tolerances
    compliance, criteria = evidence.compliance, evidence.criteria
    instead = _instead(solution, evidence.atlas)
    motion = _motion(solution, instead)
    stable = motion.status is Status.GOOD
    design = solution.design if stable else None
    around = _around(design) if design is not None else None
    where = _where(solution, solution.sweep, motion.status) if solution.sweep is not None else around
    margin = _margin(solution, design) if design is not None else None
    tolerated = _tolerated(tolerances) if tolerances is not None else None
    reached = _reached(crosscheck) if stable else None
    voltage = _voltage(solution)
    accepted = _accepted(criteria) if criteria else None
    if instead and any(criterion.passed for criterion in _judged(Question.MOTION, criteria)):
        motion = replace(motion, status=Status.GOOD)
    if instead and where is not None and where.status is Status.BAD:
        where = replace(where, status=Status.NEUTRAL)
    rigid = _rigid(compliance.grade) if compliance is not None and compliance.grade is not None else None
    simulated = _simulated(crosscheck) if crosscheck is not None else None
    headline = _headline(solution, motion, where, (margin, tolerated, reached, voltage, simulated))
    if simulated is not None and simulated.status is Status.BAD:
        headline = f"Not verified: the simulation does not agree with the solution. {headline}"
    if missed := unmet(criteria):
        headline = f"{missed}. {headline}"
    shaker = _shaker(solution) if _judged(Question.SHAKER, criteria) else None
    facts = (accepted, motion, where, margin, tolerated, reached, voltage, shaker, rigid, simulated)
    margin_word = "small" if solution.design is None or not solution.design.unresolved else "not known"
    asked = None if _judged(Question.TOLERANCES, criteria) else tolerances
    status, word = _status(motion, margin, margin_word, asked, accepted, rigid, simulated)
    return Verdict(status, word, headline, tuple(_held(fact, criteria) for fact in facts if fact is not None), instead)


def _judged(question: str, criteria: tuple[Criterion, ...]) -> list[Criterion]:
    """The criteria that an answer is held against."""
    return [criterion for criterion in criteria if criterion.question == question]


def _held(fact: Fact, criteria: tuple[Criterion, ...]) -> Fact:
    """An answer beside which a requirement is not met is not a good one."""
    missed = any(not criterion.passed for criterion in _judged(fact.question, criteria))
    return replace(fact, status=Status.BAD) if missed else fact


def _shaker(solution: Solution) -> Fact:
    shaker = solution.shaker
    answer = f"{significant(shaker.acceleration_g, 3)} g, stroke {quantity(shaker.stroke_m, 'm', 3)}"
    force = quantity(shaker.force_n, "N", 3)
    detail = f"Amplitudes of acceleration {quantity(shaker.acceleration_m_s2, 'm/s²', 3)} and force {force}"
    return Fact(Question.SHAKER, answer, detail, Status.GOOD)


def _status(
    motion: Fact,
    margin: Fact | None,
    margin_word: str,
    tolerances: Tolerances | None,
    accepted: Fact | None,
    rigid: Fact | None,
    simulated: Fact | None,
) -> tuple[Status, str]:
    """What weighs most: a contradicted solution, no motion, a requirement, the tolerances, the margin, the model.

    A required yield stands for the tolerances.
    """

    def bad(fact: Fact | None) -> bool:
        return fact is not None and fact.status is Status.BAD

    if bad(simulated):
        return Status.CAUTION, "Not verified"
    if bad(motion):
        return Status.BAD, "Not stable"
    if bad(accepted):
        return Status.BAD, "Requirements not met"
    if motion.status is Status.CAUTION:
        return Status.CAUTION, "Stable, but not 1:1"
    if tolerances is not None and not tolerances.proved:
        some = "not for every device within the tolerances"
        return Status.CAUTION, f"Stable, but {some if tolerances.worst is not None else 'tolerances not decided'}"
    if margin is not None and margin.status is Status.CAUTION:
        return Status.CAUTION, f"Stable, margin {margin_word}"
    if bad(rigid):
        return Status.CAUTION, "Stable, by a rigid model that is not good enough"
    return Status.GOOD, "Stable"


def _rigid(grade: Grade) -> Fact:
    status = (Status.GOOD, Status.CAUTION, Status.BAD)[grade]
    return Fact(Question.RIGID, f"It is {grade.words}", "See the section on compliant membranes", status)


def _tolerated(found: Tolerances) -> Fact:
    sampled = found.sampled
    interval = f"95 % interval {percent(sampled.low)} to {percent(sampled.high)}"
    detail = f"{sampled.stable} of {sampled.samples} random devices have stable motion ({interval})"
    if found.proved:
        short = "stable for every device within the tolerances"
        return Fact(Question.TOLERANCES, "Yes", "It is proved for every one", Status.GOOD, short)
    answer = "No" if found.worst is not None else "Not decided"
    short = f"stable for {percent(sampled.stable / sampled.samples)} of the devices within the tolerances"
    return Fact(Question.TOLERANCES, answer, detail, Status.CAUTION, short)


def _simulated(check: CrossCheck) -> Fact:
    largest = significant(max(check.velocity_difference, check.phase_difference), 2)
    orbits, missed = check.orbits, len(check.misses)
    if not check.passed:
        detail = f"It leaves {missed} of {orbits} stable orbits; largest difference on the others {largest}"
        return Fact(Question.SIMULATED, "No", detail, Status.BAD)
    if not orbits:
        where = " over the sweep" if len(check.values) > 1 else ""
        ends = f"simulated starts{where} end in motions other than 1:1: {_shares(check.motions)}"
        detail = f"There is no stable 1:1 motion at the values simulated; {ends}"
        return Fact(Question.SIMULATED, "Nothing to compare", detail, Status.NEUTRAL, ends)
    tried = f"all {orbits} stable orbits" if orbits != 1 else "the one stable orbit"
    detail = f"It ends on {tried} tried; largest difference {largest}"
    return Fact(Question.SIMULATED, "Yes", detail, Status.GOOD)


def _reached(check: CrossCheck | None) -> Fact:
    """How many of the simulated starts end on the stable motion; without a simulation its stability is a local one."""
    if check is None or check.share is None:
        detail = "Small disturbances of the motion die out; from which starts it is reached was not simulated"
        return Fact(Question.REACHED, "Not simulated", detail, Status.NEUTRAL, "local stability only")
    share, low, high = map(percent, check.share)
    interval = f"95 % interval {low} to {high}"
    others = f"; the others: {_shares(check.elsewhere)}" if check.elsewhere else ""
    detail = f"{check.reached} of {check.trials} random starts ({interval}){others}"
    status = Status.CAUTION if check.elsewhere else Status.GOOD
    where = "over the sweep " if len(check.values) > 1 else ""
    short = f"{where}reached from {share} of {check.trials} starts ({interval})"
    return Fact(Question.REACHED, share, detail, status, short)


def _shares(motions: tuple[MotionCount, ...]) -> str:
    """The motions that starts end in, the most frequent ones by name, each with its share of them."""
    total = sum(motion.count for motion in motions)
    named = [f"{percent(motion.count / total)} {motion.name}" for motion in motions[:MOST_MOTIONS]]
    return ", ".join([*named, *(["others"] if len(motions) > MOST_MOTIONS else [])])


def _accepted(criteria: tuple[Criterion, ...]) -> Fact:
    met, count = sum(criterion.passed for criterion in criteria), len(criteria)
    answer, status = ("Yes", Status.GOOD) if met == count else ("No", Status.BAD)
    return Fact(Question.ACCEPTED, answer, f"{met} of {count}: see the acceptance table", status)


TIMES = "once", "twice", "three times", "four times", "five times", "six times", "seven times", "eight times"
"""How often, by the number less one."""


def _instead(solution: Solution, atlas: Atlas | None) -> str:
    """What the ball does at the design point, or in the sweep, if no 1:1 motion is stable, as far as families say."""
    design = solution.design
    if atlas is None or (solution.stable_ranges if design is None else design.motions.stable.any()):
        return ""
    if design is None:
        families = [family for family in atlas.families if family.stable_runs]
    else:
        families = [family for family, _ in atlas.stable_at(design.value)]
    return ", or ".join(dict.fromkeys(_strikes(family.word) for family in families))


def _strikes(word: Word) -> str:
    """How often the ball strikes which membrane."""
    bottom, top = (_times(word.walls.count(wall)) for wall in (1, -1))
    often = "per forcing period" if word.periods == 1 else f"in {word.periods} forcing periods"
    if not bottom or not top:
        return f"the ball strikes only the {'bottom' if bottom else 'top'} membrane, {bottom or top} {often}"
    both = "each membrane " + bottom if bottom == top else f"the bottom membrane {bottom} and the top {top}"
    return f"the ball strikes {both} {often} ({word.letters})"


def _times(count: int) -> str:
    return "" if not count else TIMES[count - 1] if count <= len(TIMES) else f"{count} times"


def _motion(solution: Solution, instead: str) -> Fact:
    design = solution.design
    if design is None:
        types = {part.stability for branch in solution.branches for part in branch.segments() if part.stable}
        kinds = ", ".join(word for word in Stability if word in types)
        if kinds:
            return Fact(Question.MOTION, "Yes", f"{capital(kinds)} in the sweep", Status.GOOD)
        if instead:
            short = f"somewhere in it {instead}"
            return Fact(Question.MOTION, "Not 1:1", f"Somewhere in the sweep {instead}", Status.CAUTION, short)
        return Fact(
            Question.MOTION, "No", "No admissible 1:1 motion in the sweep attracts the motions nearby", Status.BAD
        )
    at, stable = _design_words(solution), design.motions.stable
    count, admissible = int(stable.sum()), int(design.motions.admissible.sum())
    if not count:
        if instead:
            short = f"no stable 1:1 motion; {instead}"
            return Fact(Question.MOTION, "Not 1:1", f"{capital(instead)} at {at}", Status.CAUTION, short)
        detail = f"{admissible} admissible 1:1 motion{'s' * (admissible != 1)} at {at}, none of them stable"
        detail = detail if admissible else f"No admissible 1:1 motion at {at}"
        return Fact(Question.MOTION, "No", detail, Status.BAD, "no stable 1:1 motion")
    types = {Stability(design.motions.words[row]) for row in np.nonzero(stable)[0]}
    kinds = ", ".join(word for word in Stability if word in types)
    others = f"; {count} stable motions coexist" if count > 1 else ""
    if mirror_images(solution, design):
        others = "; two mirror images"
    return Fact(Question.MOTION, "Yes", f"{capital(kinds)} at {at}{others}", Status.GOOD, kinds)


def mirror_images(solution: Solution, design: DesignPoint) -> bool:
    """Whether the stable motions are two mirror images: asymmetric ones, where the capsule is horizontal."""
    stable = [family for family, stable in zip(design.families, design.motions.stable, strict=True) if stable]
    return solution.horizontal and stable == [Symmetry.ASYMMETRIC] * 2


def _design_words(solution: Solution) -> str:
    """The design point: the swept value, or all four where nothing is swept."""
    names = (solution.parameter,) if solution.sweep is not None else tuple(Parameter)
    values = ((name, float(getattr(solution.device, name))) for name in names)
    return ", ".join(f"{swept.symbol} = {swept.show(value)}" for swept, value in values)


def _around(design: DesignPoint) -> Fact:
    """The stable range of each input around the design point, the one with the nearest end first."""
    nearest = [limit.parameter for limit in design.endings()[:1]]
    parts = [*map(range_text, sorted(design.stable, key=lambda part: part.parameter not in nearest))]
    if not parts:
        return Fact(Question.WHERE, "Not known", "No stable range is resolved", Status.NEUTRAL)
    others = f". Likewise {'; '.join(parts[1:])}" if len(parts) > 1 else ""
    detail = f"One input varied at a time{others}"
    return Fact(Question.WHERE, parts[0], detail, Status.GOOD)


def _where(solution: Solution, sweep: Sweep, of_motion: Status) -> Fact:
    parts, swept = solution.stable_ranges, sweep.parameter
    ends = f"{swept.show(sweep.start)} to {swept.show(sweep.end)}"
    if not parts:
        return Fact(Question.WHERE, "Nowhere", f"in the sweep of {swept.quantity} from {ends}", Status.BAD)
    reasons = [
        f"{swept.show(value)}: {point.event.words} {point.label}"
        for part in parts
        for value, point in part.ends
        if point is not None
    ]
    ended = f"Ends at {'; '.join(reasons)}" if reasons else "Throughout the sweep"
    detail = f"{ended}. Sweep of {swept.quantity}: {ends}"
    status = Status.GOOD if of_motion is Status.GOOD else Status.CAUTION  # the design point is in none of them
    return Fact(Question.WHERE, "; ".join(map(range_text, parts)), detail, status)


def _margin(solution: Solution, design: DesignPoint) -> Fact:
    if design.unresolved:
        names = ", ".join(varied.quantity for varied in design.unresolved)
        detail = f"Rounding does not resolve where stable motion ends along {names}"
        return Fact(Question.MARGIN, "Not known", detail, Status.CAUTION, "margin not known")
    limits = design.endings()
    if not limits:
        detail = "Stable motion ends nowhere along any input"
        return Fact(Question.MARGIN, "Not limited", detail, Status.GOOD, "no critical point near")
    first = limits[0]
    varied = first.parameter
    relative = None if first.relative is None else abs(first.relative)
    size = percent(relative) if relative is not None else varied.show(abs(first.distance), 3)
    side = "below" if first.distance < 0 else "above"
    detail = f"{capital(first.name)} at {varied.symbol} = {varied.show(first.sweep_value)}, {side} the design point"
    detail += _handover(design, first)
    near = relative is not None and relative < NEAR_CRITICAL
    answer = f"{size} in {varied.quantity}"
    short = f"margin {answer}, to {first.name}"
    return Fact(Question.MARGIN, answer, detail, Status.CAUTION if near else Status.GOOD, short)


def _handover(design: DesignPoint, limit: Margin) -> str:
    """The pitchfork of the sweep, if any, that a symmetric motion meets before its stable range ends."""
    if limit.parameter in FIXED_D or not design.families or design.families[0] is not Symmetry.SYMMETRIC:
        return ""
    start, end = float(design.motions.d[0]), limit.point.d
    for margin in design.margins:
        within = 0 < (margin.point.d - start) / (end - start) < 1
        if margin.event is Event.PITCHFORK and margin.parameter not in FIXED_D and within:
            place = f"{margin.parameter.symbol} = {margin.parameter.show(margin.sweep_value)}"
            return f"; before it, at {place} ({margin.label}), two asymmetric motions take over from the symmetric one"
    return ""


def _voltage(solution: Solution) -> Fact:
    if solution.membrane is None:
        return Fact(Question.VOLTAGE, "Not evaluated", "device.ball_mass_kg is not given", Status.NEUTRAL)
    volts, depths, place = _stable_voltages(solution)
    if not volts.size:
        return Fact(Question.VOLTAGE, "None", "There is no stable 1:1 motion to evaluate it for", Status.NEUTRAL)
    ends = dict.fromkeys(quantity(float(end), "V") for end in (volts.min(), volts.max()))
    answer = f"U_ave = {' to '.join(ends)}"
    depth, radius = float(depths.max()), solution.membrane.active_radius_m
    deep = quantity(depth, "m", 3)
    if depth <= radius:
        detail = f"{place}; deflection up to {deep}, inside the membrane model"
        return Fact(Question.VOLTAGE, answer, detail, Status.GOOD, answer)
    excess = f"deflection {deep}, {significant(depth / radius, 2)} times the active radius"
    detail = f"{place}. {capital(OUTSIDE)} ({excess}): a ranking, not volts"
    return Fact(Question.VOLTAGE, answer, detail, Status.CAUTION, f"{answer} ({OUTSIDE})")


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


def _headline(solution: Solution, motion: Fact, where: Fact | None, others: tuple[Fact | None, ...]) -> str:
    """One sentence on the motion, and one on the design point and what else is to be said in short."""
    n = solution.device.period_ratio
    name = "1:1 motion" if n == 1 else f"1:1 motion of {n} forcing periods"
    answers = [fact.short for fact in others if fact is not None and fact.short]
    if solution.sweep is None:
        detail = motion.detail[:1].lower() + motion.detail[1:]
        lead = f"{'Stable' if motion.status is Status.GOOD else 'No stable'} {name}: {detail}"
    else:
        somewhere = where is not None and where.status is Status.GOOD
        lead = f"Stable {name} for {where.answer}" if somewhere and where else f"No stable {name} in the sweep"
        if solution.design is None and motion.short:
            answers.insert(0, motion.short)
        if solution.design is not None:
            answers.insert(0, f"at the design point {_design_words(solution)}: {motion.short}")
    return f"{lead}. {capital(', '.join(answers))}." if answers else f"{lead}."
