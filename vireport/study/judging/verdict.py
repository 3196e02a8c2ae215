"""The verdict of a study as data: whether there is stable motion, where, with what margin, and at what voltage.

Each question has a status and the numbers that answer it; `opening` chooses what is said of them. A reader who stops
after that must not have been misled.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import Enum, IntEnum, StrEnum
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import brief
from vireport.design.margins import Margin
from vireport.design.point import DesignPoint, StableInterval
from vireport.design.solution import Solution
from vireport.motions.points import Point
from vireport.motions.stability import Stability
from vireport.physics.motion import Symmetry
from vireport.scenario.parameters import DRIVING, DesignInput, Parameter
from vireport.study.judging.alerts import is_near_critical
from vireport.study.judging.evidence import Criterion, Evidence, unmet_criteria
from vireport.study.judging.findings import findings, with_results
from vireport.study.judging.impacts import other_motions
from vireport.study.judging.least_margin import MarginToUse, margin_to_use
from vireport.study.judging.stretch import severity_of
from vireport.text.alerts import Severity
from vireport.text.formatting import Exactness
from vireport.text.requirements import Question

if TYPE_CHECKING:
    from vireport.design.compliant.own_stiffness import OwnStiffness, StabilityEnd
    from vireport.design.switched_on import SwitchedOn
    from vireport.motions.families import Family
    from vireport.physics.device import Shaker
    from vireport.physics.energy import MembraneStretch
    from vireport.physics.word import Word
    from vireport.study.checks.crosscheck import CrossCheck

ANY_MARGIN = "margin_any_percent"
"""The requirement that is judged by rigid impacts, and of which a reader may think that it holds for what is used."""

Numbers = TypeVar("Numbers", covariant=True)


class Status(StrEnum):
    """What an answer means for the design."""

    GOOD = "good"
    CAUTION = "caution"
    BAD = "bad"
    NEUTRAL = "neutral"


class Weight(IntEnum):
    """How much a conclusion weighs, what weighs most first.

    Of two with the same weight, the one whose question comes first weighs more.
    """

    CONTRADICTED = 1
    NO_MOTION = 2
    NOT_MET = 3
    IMPOSSIBLE = 4
    ANOTHER_MOTION = 5
    NOT_EVERY_DEVICE = 6
    MARGIN = 7
    MODEL = 8
    DIGITS = 9
    NOTHING = 10


class Conclusion(Enum):
    """What can hold against a device, with its status, in a few words, and with its weight; or that nothing does."""

    NOT_VERIFIED = Status.CAUTION, "Not verified", Weight.CONTRADICTED
    NOT_STABLE = Status.BAD, "Not stable", Weight.NO_MOTION
    NOT_SETTABLE = Status.BAD, "Stable only in a range too narrow to be set", Weight.NO_MOTION
    NOT_MET = Status.BAD, "Requirements not met", Weight.NOT_MET
    MORE_ENERGY_THAN_LOST = (
        *(Status.BAD, "Stable, but with more electrical energy than the impacts lose"),
        Weight.IMPOSSIBLE,
    )
    BREAKDOWN = Status.BAD, "Stable, but above the breakdown field", Weight.IMPOSSIBLE
    OTHER_MOTION = Status.CAUTION, "Stable, but not 1:1", Weight.ANOTHER_MOTION
    NOT_COMPLIANT = (
        *(Status.CAUTION, "Stable by rigid impacts, but not with the membranes' own stiffness"),
        Weight.ANOTHER_MOTION,
    )
    NOT_FROM_REST = Status.CAUTION, "Stable, but not reached from rest", Weight.ANOTHER_MOTION
    FROM_REST_UNKNOWN = Status.CAUTION, "Stable, not known whether reached from rest", Weight.ANOTHER_MOTION
    COMPLIANT_UNKNOWN = (
        *(Status.CAUTION, "Stable by rigid impacts, not known with the membranes' own stiffness"),
        Weight.NOT_EVERY_DEVICE,
    )
    MARGIN_UNKNOWN = Status.CAUTION, "Stable, margin not known", Weight.MARGIN
    MARGIN_SHORT = Status.CAUTION, "Stable, margin to use less than required", Weight.MARGIN
    MARGIN_SMALL = Status.CAUTION, "Stable, margin small", Weight.MARGIN
    MARGIN_RIGID = Status.CAUTION, "Stable, margin known for rigid membranes only", Weight.MARGIN
    BOUNCING_NEAR_END = Status.CAUTION, "Stable on the bottom, margin small", Weight.MARGIN
    STRETCHED_FAR = Status.CAUTION, "Stable, but a membrane stretches farther than demonstrated", Weight.MODEL
    END_UNKNOWN = (
        *(Status.CAUTION, "Stable, but not to the same end with the membranes' own stiffness"),
        Weight.DIGITS,
    )
    NOT_BOUNCING = Status.CAUTION, "No stable bouncing known", Weight.NO_MOTION
    STABLE = Status.GOOD, "Stable", Weight.NOTHING
    BOUNCING = Status.GOOD, "Stable on the bottom", Weight.NOTHING

    @property
    def status(self) -> Status:
        """What the answer means for the design."""
        return self.value[0]

    @property
    def word(self) -> str:
        """The conclusion in a few words."""
        return self.value[1]

    @property
    def weight(self) -> Weight:
        """Weight of the conclusion among others."""
        return self.value[2]

    @property
    def fails(self) -> bool:
        """Whether the device is known not to do what it is designed for, so that something must be changed."""
        return self.status is Status.BAD or self in (Conclusion.OTHER_MOTION, Conclusion.NOT_FROM_REST)


class AddedConclusion(Struct, frozen=True):
    """What an addition can hold against a device.

    Attributes
    ----------
    name : str
        In lower case that of the macro which says it, and with ``lacks_`` before it of that for a comparison.
    status : Status
    word : str
        The conclusion in a few words.
    weight : Weight
    words : str
        The file of words that has these macros.
    """

    name: str
    status: Status
    word: str
    weight: Weight
    words: str


AnyConclusion = Conclusion | AddedConclusion


class Fact(Struct, Generic[Numbers], frozen=True, eq=False):
    """The answer to a question as data; the status is neutral where there is nothing to judge."""

    question: str
    status: Status
    data: Numbers

    __repr__ = brief


class AddedAnswer(Fact[Numbers], frozen=True, eq=False, kw_only=True):
    """The answer of an addition to a question of its own, or to one of the core beside the core's answer.

    Attributes
    ----------
    name : str
        By which the verdict has it.
    concludes : AddedConclusion or None
        What it holds against the device. It counts where no requirement is held beside a question of its own: then the
        requirement stands for it. Beside a question of the core it counts always, and the core's answer is none that is
        good.
    """

    name: str
    concludes: AddedConclusion | None = None


AnyFact = TypeVar("AnyFact", bound=Fact[Any])


class StableMotions(Struct, frozen=True, eq=False):
    """The stable motions at the design point or, where there is none, somewhere in the sweep.

    Attributes
    ----------
    types : tuple of Stability
        Of the stable 1:1 motions, each once; empty where there is none.
    count, admissible : int
        Stable and admissible 1:1 motions at the design point; 0 without one.
    mirrored : bool
        Whether the stable ones are two mirror images of each other.
    instead : tuple of Word
        Where no 1:1 motion is stable, the others that are known to be; above a table, that from rest first.
    other_words : tuple of Word
        Other motions that are stable at the design point beside a 1:1 motion.
    narrow : tuple of StableInterval
        Where 1:1 motion is stable only in ranges that no device can be set into, around the design point or, without
        one, in the sweep: these. It then counts as none.
    """

    types: tuple[Stability, ...]
    count: int
    admissible: int
    mirrored: bool
    instead: tuple[Word, ...]
    other_words: tuple[Word, ...]
    narrow: tuple[StableInterval, ...] = ()


class NearestEnd(Struct, frozen=True, eq=False):
    """The nearest end of the stable motions at the design point.

    Attributes
    ----------
    end : Margin or None
        A pitchfork at which another motion takes over is one; None where they end nowhere.
    unresolved : tuple of DesignInput
        Along these an end may be nearer: rounding does not resolve it.
    handover : Margin or None
        The nearest pitchfork at which another motion takes over, where that is not the nearest end.
    lost : Margin or None
        The nearest end of stable motion altogether, where another motion takes over at the nearest end.
    symmetric : bool
        Whether the first stable motion is its own mirror image.
    compliant : StabilityEnd or None
        The end with the membranes' own stiffness too; None where contacts are short.
    to_use : MarginToUse or None
        The least of all known margins, which a designer acts on; None where there is no end.
    required : float or None
        The margin that is required of rigid impacts, as a share.
    """

    end: Margin | None
    unresolved: tuple[DesignInput, ...]
    handover: Margin | None
    lost: Margin | None
    symmetric: bool
    compliant: StabilityEnd | None
    to_use: MarginToUse | None
    required: float | None = None

    __repr__ = brief

    @property
    def short(self) -> bool:
        """Whether less is left to use than is required of rigid impacts, which may well leave it."""
        if self.required is None or self.to_use is None:
            return False
        return self.to_use.gone or (self.to_use.relative is not None and self.to_use.relative < self.required)

    @property
    def not_known(self) -> bool:
        """Whether an end may be nearer, or none is known with the membranes' own stiffness."""
        return bool(self.unresolved) or (self.compliant is not None and self.compliant.compliant is None)


class StableVoltages(Struct, frozen=True, eq=False):
    """What the stable 1:1 motions generate by the paper's formulae, at the design point or without one over the sweep.

    Attributes
    ----------
    least_v, most_v : float
        U_ave.
    stretch : MembraneStretch
        Of the membrane that is pressed in deepest.
    at_design : bool
    severity : Severity or None
        Of the alert on that.
    efficiency, field_share : float or None
        Most electrical energy over what the impacts lose, and highest field over the breakdown field, at the design
        point; None where the membrane's dielectric or the design point is not given.
    """

    least_v: float
    most_v: float
    stretch: MembraneStretch
    at_design: bool
    severity: Severity | None
    efficiency: float | None
    field_share: float | None

    @property
    def impossible(self) -> bool:
        """Whether more electrical energy is gained than the impacts lose, which contradicts the restitution."""
        return self.efficiency is not None and self.efficiency > 1

    @property
    def breaks_down(self) -> bool:
        """Whether the field exceeds what the membrane withstands."""
        return self.field_share is not None and self.field_share > 1

    @property
    def contradictory(self) -> bool:
        """Whether no device can have this."""
        return self.impossible or self.breaks_down

    @property
    def status(self) -> Status:
        """What voltage and deflection mean for the design."""
        return Status.BAD if self.contradictory else STRETCHED[self.severity]


STRETCHED = {None: Status.GOOD, Severity.NOTE: Status.NEUTRAL, Severity.WARNING: Status.CAUTION}
"""What the alert on deep deflections means for the answer on voltages, by its severity."""


class Verdict(Struct, frozen=True, eq=False):
    """The answers and criteria that a study comes to.

    An answer is None where its question does not arise.

    Attributes
    ----------
    conclusion : Conclusion or AddedConclusion
    evidence : Evidence
        What it was judged by.
    accepted : Fact of tuple of Criterion, or None
    motion : Fact of StableMotions
    where : Fact of tuple of StableInterval, or None
        Along the sweep; without one of each input around the design point, that with the nearest end first.
    margin : Fact of NearestEnd, or None
    from_rest : Fact of SwitchedOn, or None
        Where the 1:1 motion is stable at a design point.
    reached : Fact of CrossCheck or None, or None
        A fact of None where nothing was simulated, and stability is that against small disturbances; no fact where
        the device was nevertheless followed from rest.
    voltage : Fact of StableVoltages or None
    shaker : Fact of Shaker, or None
    own_stiffness : Fact of OwnStiffness, or None
    simulated : Fact of CrossCheck, or None
    added : mapping of str to AddedAnswer
        Those of additions, by their names, in the order of the additions' rows.
    conclusions : tuple of Conclusion or AddedConclusion
        All that hold, what weighs most first: `conclusion`, and what would be one without it.
    """

    conclusion: AnyConclusion
    evidence: Evidence
    accepted: Fact[tuple[Criterion, ...]] | None
    motion: Fact[StableMotions]
    where: Fact[tuple[StableInterval, ...]] | None
    margin: Fact[NearestEnd] | None
    from_rest: Fact[SwitchedOn] | None
    reached: Fact[CrossCheck | None] | None
    voltage: Fact[StableVoltages | None]
    shaker: Fact[Shaker] | None
    own_stiffness: Fact[OwnStiffness] | None
    simulated: Fact[CrossCheck] | None
    added: Mapping[str, AddedAnswer[Any]] = {}
    conclusions: tuple[AnyConclusion, ...] = ()

    def __repr__(self) -> str:
        return f"<Verdict {self.word}>"

    if not TYPE_CHECKING:  # so that a checker of types takes no name for any attribute

        def __getattr__(self, name: str) -> Any:
            """The answer of the addition of that name, None where its question does not arise."""
            if name in findings():
                return self.added.get(name)
            raise AttributeError(f"a Verdict has no attribute {name!r}")

    @property
    def status(self) -> Status:
        """The status of the conclusion."""
        return self.conclusion.status

    @property
    def word(self) -> str:
        """The conclusion in a few words."""
        return self.conclusion.word

    @property
    def fails(self) -> bool:
        """Whether any conclusion holds for which the design must be changed."""
        return any(isinstance(conclusion, Conclusion) and conclusion.fails for conclusion in self.conclusions)

    @property
    def answers(self) -> dict[str, Fact[object]]:
        """The answers by their names above, in the order in which a reader asks."""
        named: dict[str, Fact[object] | None] = {
            "accepted": self.accepted,
            "motion": self.motion,
            "where": self.where,
            "margin": self.margin,
            "own_stiffness": self.own_stiffness,
            "from_rest": self.from_rest,
            "reached": self.reached,
            "voltage": self.voltage,
            "shaker": self.shaker,
            "simulated": self.simulated,
        }
        return {name: fact for name, fact in named.items() if fact is not None} | dict(self.added)

    @property
    def design_point(self) -> Iterator[tuple[Parameter, float]]:
        """The design point: the parameter that is swept and its value, or all four where nothing is swept."""
        solution = self.evidence.solution
        for parameter in (solution.parameter,) if solution.sweep is not None else DRIVING:
            yield parameter, float(solution.device.value_of(parameter))

    @property
    def ends_of_ranges(self) -> list[tuple[float, Point]]:
        """The critical points that end the stable ranges of the sweep, each with its value."""
        parts = self.evidence.solution.settable_ranges
        return [(value, point) for part in parts for value, point in part.ends if point is not None]

    @property
    def exactness(self) -> Exactness:
        """How exact all numbers are that the model of rigid impacts gives."""
        return self.evidence.exactness

    def place(self, end: Margin) -> str:
        """Where an end of stable motion is, as text."""
        return end.parameter.show(end.sweep_value, self.exactness)

    def end_text(self, part: StableInterval, side: int) -> str:
        """The lower end of a stable range as text, or the upper one for a `side` of 1."""
        return part.end_texts(self.exactness)[side]

    def inequality(self, part: StableInterval) -> str:
        """A stable range as text, strict at a critical point."""
        return part.text(self.exactness)

    @property
    def inequalities(self) -> list[str]:
        """The stable ranges of the sweep as texts."""
        return [self.inequality(part) for part in self.evidence.solution.settable_ranges]


def verdict_of(evidence: Evidence) -> Verdict:
    """Judge what was found out about a scenario; without criteria nothing is required."""
    solution, criteria = evidence.solution, evidence.criteria
    motions = stable_motions(evidence)
    stable = bool(motions.types)
    design = solution.design if stable else None
    from_rest = _from_rest(evidence) if design is not None else None
    verdict = Verdict(
        Conclusion.STABLE,
        evidence,
        accepted=_accepted(criteria),
        motion=_motion(motions, evidence),
        where=_where(evidence, design, motions),
        margin=_margin(design, evidence) if design is not None else None,
        from_rest=from_rest,
        reached=_of_starts(evidence.crosscheck) if stable and not (from_rest and evidence.crosscheck is None) else None,
        voltage=_voltage(evidence) if not motions.narrow else Fact(Question.VOLTAGE, Status.NEUTRAL, None),
        shaker=Fact(Question.SHAKER, Status.GOOD, solution.shaker) if judged_by(Question.SHAKER, criteria) else None,
        own_stiffness=_own_stiffness(evidence.own_stiffness) if not motions.narrow else None,
        simulated=_simulated(evidence.crosscheck),
        added=_added(evidence),
    )
    conclusions = _conclusions(verdict)
    added = {name: _held(answer, criteria) for name, answer in verdict.added.items()}
    doubted = {answer.question for answer in verdict.added.values() if answer.concludes is not None}
    of_the_core = {name: fact for name, fact in verdict.answers.items() if name not in added}
    held = {name: _held(_no_better(fact, doubted), criteria) for name, fact in of_the_core.items()}
    return replace(verdict, conclusion=conclusions[0], conclusions=conclusions, added=added, **held)


def _added(evidence: Evidence) -> dict[str, AddedAnswer[object]]:
    """The answers of additions, by their names."""
    answers = (
        answer for finding, result in with_results(evidence.findings) for answer in finding.answers(result, evidence)
    )
    return {answer.name: answer for answer in answers}


def judged_by(question: str, criteria: tuple[Criterion, ...]) -> list[Criterion]:
    """The criteria that an answer is held against."""
    return [criterion for criterion in criteria if criterion.question == question]


def _held(fact: AnyFact, criteria: tuple[Criterion, ...]) -> AnyFact:
    """An answer beside which a requirement is not met is not a good one."""
    return replace(fact, status=Status.BAD) if unmet_criteria(judged_by(fact.question, criteria)) else fact


def _no_better(fact: AnyFact, doubted: set[str]) -> AnyFact:
    """A good answer beside which an addition holds something against the device is a caution."""
    good = fact.status is Status.GOOD and fact.question in doubted
    return replace(fact, status=Status.CAUTION) if good else fact


def _conclusions(verdict: Verdict) -> tuple[AnyConclusion, ...]:
    """What holds against a design, what weighs most first; `STABLE` where nothing does."""
    criteria, order = verdict.evidence.criteria, list[str](Question)
    conclusions: list[tuple[str, AnyConclusion]] = list(_of_the_core(verdict))
    for answer in verdict.added.values():
        if answer.concludes is not None and (answer.question in order or not judged_by(answer.question, criteria)):
            conclusions.append((answer.question, answer.concludes))

    def place(row: tuple[str, AnyConclusion]) -> tuple[int, int]:
        question, conclusion = row
        return conclusion.weight, order.index(question) if question in order else len(order)

    nothing = Conclusion.BOUNCING if verdict.evidence.solution.on_table else Conclusion.STABLE
    return tuple(conclusion for _, conclusion in sorted(conclusions, key=place)) or (nothing,)


def _of_the_core(verdict: Verdict) -> Iterator[tuple[Question, Conclusion]]:
    """What answers of the core hold against a design, with their questions."""
    compliant, margin, evidence = verdict.own_stiffness, verdict.margin, verdict.evidence
    if _has(verdict.accepted, Status.BAD):
        yield Question.ACCEPTED, Conclusion.NOT_MET
    if _has(verdict.motion, Status.BAD):
        yield Question.MOTION, Conclusion.NOT_SETTABLE if verdict.motion.data.narrow else Conclusion.NOT_STABLE
    if _has(verdict.motion, Status.CAUTION):
        yield Question.MOTION, Conclusion.NOT_BOUNCING if evidence.solution.on_table else Conclusion.OTHER_MOTION
    if any(is_near_critical(end.relative) for end in evidence.ends_on_bottom):
        yield Question.MARGIN, Conclusion.BOUNCING_NEAR_END
    if margin is not None and margin.status is Status.CAUTION:
        if margin.data.not_known:
            yield Question.MARGIN, Conclusion.MARGIN_UNKNOWN if margin.data.unresolved else Conclusion.MARGIN_RIGID
        else:
            yield Question.MARGIN, Conclusion.MARGIN_SHORT if margin.data.short else Conclusion.MARGIN_SMALL
    if compliant is not None and compliant.data.margin_gone:
        yield Question.OWN_STIFFNESS, Conclusion.NOT_COMPLIANT
    unsaid = margin is None or not margin.data.not_known
    if compliant is not None and compliant.data.motion is None:
        yield Question.OWN_STIFFNESS, Conclusion.COMPLIANT_UNKNOWN
    elif _has(compliant, Status.CAUTION) and unsaid:
        yield Question.OWN_STIFFNESS, Conclusion.END_UNKNOWN
    if _has(verdict.from_rest, Status.CAUTION):
        end = evidence.from_rest
        decided = end is not None and end.decided
        conclusion = Conclusion.NOT_FROM_REST if decided else Conclusion.FROM_REST_UNKNOWN
        yield Question.FROM_REST, conclusion
    yield from ((Question.VOLTAGE, conclusion) for conclusion in _of_voltage(verdict))
    if _has(verdict.simulated, Status.BAD):
        yield Question.SIMULATED, Conclusion.NOT_VERIFIED


def _of_voltage(verdict: Verdict) -> Iterator[Conclusion]:
    """What voltages hold against a design: those of the 1:1 motion, or else of another motion."""
    generated = verdict.voltage.data
    if generated is not None and generated.status is Status.BAD:
        yield Conclusion.MORE_ENERGY_THAN_LOST if generated.impossible else Conclusion.BREAKDOWN
    elif (contradiction := _of_other_motions(verdict.evidence)) is not None:
        yield contradiction
    if generated is not None and generated.severity is Severity.WARNING:
        yield Conclusion.STRETCHED_FAR


def _of_other_motions(evidence: Evidence) -> Conclusion | None:
    """What no device can have, but another stable motion of the design point would: that is no better of any word."""
    if evidence.atlas is None:
        return None
    others = [impacts for _, impacts in other_motions(evidence)]
    if any(impacts.efficiency.value > 1 for impacts in others):
        return Conclusion.MORE_ENERGY_THAN_LOST
    exceeded = any(impacts.field_v_m.value > impacts.breakdown_field_v_m for impacts in others)
    return Conclusion.BREAKDOWN if exceeded else None


def _has(fact: Fact[object] | None, status: Status) -> bool:
    return fact is not None and fact.status is status


def _accepted(criteria: tuple[Criterion, ...]) -> Fact[tuple[Criterion, ...]] | None:
    if not criteria:
        return None
    return Fact(Question.ACCEPTED, Status.BAD if unmet_criteria(criteria) else Status.GOOD, criteria)


def _motion(motions: StableMotions, evidence: Evidence) -> Fact[StableMotions]:
    """Whether a motion is stable: a 1:1 motion, or one that is required; another than that is a caution.

    Above a table any other is good, and a caution that none is known.
    """
    on_table = evidence.solution.on_table
    if motions.types or (motions.instead and (on_table or evidence.required_motions_met)):
        return Fact(Question.MOTION, Status.GOOD, motions)
    if on_table:
        return Fact(Question.MOTION, Status.CAUTION, motions)
    return Fact(Question.MOTION, Status.CAUTION if motions.instead else Status.BAD, motions)


def stable_motions(evidence: Evidence) -> StableMotions:
    """The stable motions at the design point or, without one, in the sweep; none where no device can be set to them."""
    solution, design = evidence.solution, evidence.solution.design
    narrow = _narrow(solution)
    if design is None:
        types = {part.stability for branch in solution.branches for part in branch.family.segments if part.stable}
        count = admissible = 0
    else:
        stable = design.motions.stable_mask
        types = {Stability(design.motions.words[row]) for row in np.nonzero(stable)[0]}
        count, admissible = int(stable.sum()), int(design.motions.admissible_mask.sum())
    ordered = tuple(kind for kind in Stability if kind in types)
    words = _known_words(evidence)
    one_to_one = "BT", solution.device.period_ratio
    other_words = tuple(word for word in words if (word.letters, word.periods) != one_to_one)
    mirrored = design is not None and mirror_images(solution, design)
    if types and not narrow:
        return StableMotions(ordered, count, admissible, mirrored, (), other_words if design is not None else ())
    # Without a design point a range may be too short for a sample on it: then the 1:1 motion is somewhere stable.
    instead = words if design is not None or not solution.stable_ranges else ()
    return StableMotions((), count, admissible, mirrored, instead, (), narrow)


def _narrow(solution: Solution) -> tuple[StableInterval, ...]:
    """The ranges of stable motion, where each is too narrow for a device to be set into; () where one is not."""
    design = solution.design
    if design is not None:
        return tuple(part for part in design.stable_ranges if not part.settable)
    return () if solution.settable_ranges else solution.stable_ranges


def _known_words(evidence: Evidence) -> tuple[Word, ...]:
    """The words of the stable motions that are known at the design point, or without one where the sweep can be set.

    Above a table that of the motion from rest is the first.
    """
    solution, end = evidence.solution, evidence.from_rest
    words = [family.word for family in _known_families(evidence)]
    if solution.on_table:
        followed = (evidence.motion_from_rest, *evidence.by_starts)
        words += [other.motion.word for other in followed if other is not None]
        words.sort(key=lambda word: end is None or (word.letters, word.periods) != (end.word, end.periods))
    return tuple(dict.fromkeys(words))


def _known_families(evidence: Evidence) -> list[Family]:
    """The families whose stable motions are known at the design point, or without one where the sweep can be set."""
    atlas, design = evidence.atlas, evidence.solution.design
    if atlas is None:
        return []
    if design is None:
        return [family for family in atlas.families if family.settable]
    return [family for family, _ in atlas.stable_at(design.value) if family.settable_at(design.value)]


def mirror_images(solution: Solution, design: DesignPoint) -> bool:
    """Whether the stable motions are two mirror images: asymmetric ones, where the capsule is horizontal."""
    stable = [family for family, stable in zip(design.families, design.motions.stable_mask, strict=True) if stable]
    return solution.horizontal and stable == [Symmetry.ASYMMETRIC] * 2


def _where(
    evidence: Evidence, design: DesignPoint | None, motions: StableMotions
) -> Fact[tuple[StableInterval, ...]] | None:
    solution = evidence.solution
    if solution.on_table:
        if evidence.atlas is None:
            return None
        families = (family for family in _known_families(evidence) if family.word in motions.instead[:1])
        parts = tuple(part for family in families for part in _ranges(family) if part.settable)
        return Fact(Question.WHERE, Status.GOOD if parts else Status.NEUTRAL, parts)
    if solution.sweep is not None:
        parts = solution.settable_ranges
        if not parts:
            return Fact(Question.WHERE, Status.NEUTRAL if motions.instead else Status.BAD, ())
        # Where no motion is stable at the design point, it is in none of the ranges.
        return Fact(Question.WHERE, Status.GOOD if motions.types else Status.CAUTION, parts)
    if design is None:
        return None
    nearest = design.nearest.parameter if design.nearest is not None else None
    parts = tuple(sorted(design.stable_ranges, key=lambda part: part.parameter is not nearest))
    return Fact(Question.WHERE, Status.GOOD if parts else Status.NEUTRAL, parts)


def _ranges(family: Family) -> Iterator[StableInterval]:
    """Where along the sweep the motions of a family are stable."""
    sweep, points = family.sweep, {mark.row: mark.point for mark in family.marks}
    for run in family.stable_runs:
        low, high = sorted(run, key=lambda row: float(family.sweep_value[row]))
        start, end = float(family.sweep_value[low]), float(family.sweep_value[high])
        yield StableInterval(sweep.parameter, start, end, points.get(low), points.get(high), sweep.off)


def _margin(design: DesignPoint, evidence: Evidence) -> Fact[NearestEnd]:
    long_contacts, end = evidence.own_stiffness, design.nearest
    handover = lost = compliant = None
    if end is not None and end.taken_over:
        lost = next(iter(design.endings()), None)
    elif end is not None:
        handover = next((margin for margin in design.margins if margin.taken_over), None)
    if long_contacts is not None and end is not None:
        compliant = long_contacts.end_of(end.parameter, end.point)
    symmetric = design.families[:1] == (Symmetry.SYMMETRIC,)
    use = margin_to_use(evidence)
    required = next((line.limit.value / 100 for line in evidence.criteria if line.key == ANY_MARGIN), None)
    nearest = NearestEnd(end, design.unresolved_inputs, handover, lost, symmetric, compliant, use, required)
    small = (use is not None and use.small) or nearest.short
    gone = long_contacts is not None and long_contacts.margin_gone
    return Fact(Question.MARGIN, Status.CAUTION if small or gone or nearest.not_known else Status.GOOD, nearest)


def _own_stiffness(compliant: OwnStiffness | None) -> Fact[OwnStiffness] | None:
    if compliant is None:
        return None
    kept = (
        compliant.motion is not None
        and compliant.motion.stable
        and all(end.compliant is not None for end in compliant.ends)
    )
    return Fact(Question.OWN_STIFFNESS, Status.NEUTRAL if kept else Status.CAUTION, compliant)


def _from_rest(evidence: Evidence) -> Fact[SwitchedOn] | None:
    """Whether the device comes from rest to the stable motion, or to another one that is required."""
    switched_on = evidence.switched_on
    if switched_on is None or switched_on.from_rest is None:
        return None
    good = switched_on.from_rest.is_one_to_one or evidence.required_motions_met
    return Fact(Question.FROM_REST, Status.GOOD if good else Status.CAUTION, switched_on)


def _of_starts(check: CrossCheck | None) -> Fact[CrossCheck | None]:
    """How many of the simulated starts end on the stable motion; without a simulation its stability is a local one."""
    if check is None or check.share is None:
        return Fact(Question.STARTS, Status.NEUTRAL, None)
    return Fact(Question.STARTS, Status.CAUTION if check.elsewhere else Status.GOOD, check)


def _voltage(evidence: Evidence) -> Fact[StableVoltages | None]:
    solution, stretch = evidence.solution, evidence.solution.stretch
    if stretch is None:
        return Fact(Question.VOLTAGE, Status.NEUTRAL, None)
    (volts, _), severity, converted = solution.stable_voltages, severity_of(stretch), _converted(solution)
    at_design = solution.design is not None
    generated = StableVoltages(float(volts.min()), float(volts.max()), stretch, at_design, severity, *converted)
    return Fact(Question.VOLTAGE, generated.status, generated)


def _converted(solution: Solution) -> tuple[float | None, float | None]:
    """Largest efficiency of the stable motions at the design point, and highest field over the breakdown field."""
    design, membrane = solution.design, solution.membrane
    if design is None or design.conversion_by_motion is None or membrane is None or membrane.dielectric is None:
        return None, None
    stable, converted = design.motions.stable_mask, design.conversion_by_motion
    field = converted.field_v_m[stable].max() / membrane.dielectric.breakdown_field_v_m
    return float(converted.efficiency[stable].max()), float(field)


def _simulated(check: CrossCheck | None) -> Fact[CrossCheck] | None:
    if check is None:
        return None
    status = Status.BAD if not check.passed else Status.GOOD if check.orbits else Status.NEUTRAL
    return Fact(Question.SIMULATED, status, check)
