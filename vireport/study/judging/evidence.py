"""The evidence that a scenario is judged by, and the lines of its acceptance table: limits, judgements and reasons."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.records import brief, plain
from vireport.design.followed import followed_on_bottom, motion_ends
from vireport.design.point import DesignPoint
from vireport.design.sensitivity import contact_share
from vireport.design.solution import Solution
from vireport.motions.one_to_one import impact_velocities
from vireport.physics.groups import by_wall
from vireport.physics.word import Word
from vireport.scenario.blocks import RequirementsBlock
from vireport.scenario.demands import LimitKind
from vireport.scenario.parameters import Parameter
from vireport.study.result_records import CriterionData
from vireport.text.formatting import OF_A_MODEL, Exactness, apart, rounded_text
from vireport.text.patterns import Phrase
from vireport.text.requirements import Question, Remark

if TYPE_CHECKING:
    from vireport.design.compliant.own_stiffness import OwnStiffness
    from vireport.design.effects import Shifts
    from vireport.design.followed import FollowedMotion, MotionEnd
    from vireport.design.from_rest import FromRest
    from vireport.design.switched_on import SwitchedOn
    from vireport.motions.families import Atlas, Family
    from vireport.physics.motion import Motion
    from vireport.study.checks.crosscheck import CrossCheck

Floats = NDArray[np.float64]

END_MOVED = 4.0
"""What an end of stable motion moves by with the membranes' own stiffness, over its value and over the share of the
forcing period that contacts take: 3 and 4 for the lengths of the examples. Velocities and phases move by less."""

FINEST = 5e-7
"""Least relative error of numbers that are shown: no device is made, or measured, to more than six digits."""


class Limit(Struct, frozen=True, eq=False):
    """The limit of a requirement: a number or the ends of a range, ascending, with their unit, or the words of motions.

    `usual` is true where the scenario does not give the limit.
    """

    kind: LimitKind
    numbers: tuple[float, ...]
    unit: str
    words: tuple[str, ...] = ()
    usual: bool = False

    @property
    def text(self) -> str:
        """The limit in words, with its unit."""
        return self.kind.value.format(*self.numbers, unit=self.unit, words=" or ".join(self.words))

    @property
    def value(self) -> float:
        """The number of the limit; of a range, its width."""
        return self.numbers[-1] - self.numbers[0] if self.kind is LimitKind.RANGE else self.numbers[0]

    @property
    def is_least(self) -> bool:
        """Whether the least of several values is held against the limit; else the largest is."""
        return self.kind is LimitKind.AT_LEAST


class Judgement(Struct, frozen=True, eq=False):
    """The judgement of a requirement.

    Attributes
    ----------
    value : float or None
        The value that is judged; for a range, how much of it is covered. None where it is not known or is no number.
    text : str or Phrase
        The value with its unit, or what there is instead.
    margin : float or None
        How far the value is on the right side of the limit, in the limit's unit, negative on the wrong one; of a
        range, how far stable motion goes beyond it.
    passed : bool
    why : str or Phrase
        Where the value comes from, or why the requirement is not met; "" for no remark.
    error_bound : float
        Error bound of the value, and so of the margin; a requirement that it leaves undecided is not met.
    """

    value: float | None
    text: str | Phrase
    margin: float | None
    passed: bool
    why: str | Phrase = ""
    error_bound: float = 0.0


class Criterion(Struct, frozen=True, eq=False):
    """A line of the acceptance table.

    `key` is the requirement's key, the first of two that belong together; `question` is the question of the verdict to
    which it belongs. `line` is the line of the scenario's file; None for a limit by an override, or a usual one.
    """

    key: str
    title: Phrase
    question: str
    limit: Limit
    outcome: Judgement
    line: int | None

    def __repr__(self) -> str:
        outcome = "met" if self.passed else "not met"
        return f"<Criterion {self.title}, {self.limit.text}: {self.outcome.text}, {outcome}>"

    @property
    def passed(self) -> bool:
        """Whether the requirement is met."""
        return self.outcome.passed

    @property
    def names_motions(self) -> bool:
        """Whether the requirement says which motions may be stable, so that another motion than 1:1 is acceptable."""
        return self.limit.kind is LimitKind.WORDS

    @property
    def by_formulae(self) -> bool:
        """Whether the requirement limits voltages, energies or deflections, which are by the paper's formulae."""
        return self.question == Question.VOLTAGE

    @property
    def margin_text(self) -> str:
        """The margin with its sign and unit, "" where there is none."""
        margin = self.outcome.margin
        if margin is None:
            return ""
        return f"{'+' if margin >= 0 else ''}{rounded_text(margin)} {self.limit.unit}".rstrip()

    @property
    def data(self) -> CriterionData:
        """The line as results.json has it."""
        limit, outcome = self.limit, self.outcome
        return CriterionData(
            key=self.key,
            title=str(self.title),
            limit=limit.text,
            limit_value=limit.value if limit.numbers else None,
            unit=limit.unit,
            by_default=limit.usual,
            value=outcome.value,
            value_text=str(outcome.text),
            margin=outcome.margin,
            passed=outcome.passed,
            why=str(outcome.why),
            error_bound=outcome.error_bound,
            line=self.line,
        )

    def to_dict(self) -> dict[str, Any]:
        """The judged requirement as results.json has it, as plain data."""
        data: dict[str, Any] = plain(self.data)
        return data


def unmet_criteria(criteria: Iterable[Criterion]) -> list[Criterion]:
    """The requirements that are not met."""
    return [criterion for criterion in criteria if not criterion.passed]


def unmet(criteria: Sequence[Criterion]) -> Phrase | None:
    """Name the criteria that are not met, without a full stop; None where all are met."""
    failed = unmet_criteria(criteria)
    if not failed:
        return None
    named = [Remark.UNMET.said(title=criterion.title, limit=criterion.limit.text) for criterion in failed]
    one = Remark.THE_ONE_IS_NOT_MET if len(criteria) == 1 else Remark.ONE_IS_NOT_MET
    remark = one if len(failed) == 1 else Remark.SOME_ARE_NOT_MET
    return remark.said(count=len(failed), total=len(criteria), unmet=named)


class Evidence(Struct, frozen=True, eq=False, dict=True):
    """The results of a scenario that requirements, alerts and the verdict are judged by.

    `switched_on` is what the device does when it is switched on, `effects` how far neglected effects move the nearest
    end. `findings` has what each addition to the study found, by its name. `criteria` are the requirements that were
    judged already, `required` those that are being judged, if any are.
    """

    solution: Solution
    crosscheck: CrossCheck | None = None
    atlas: Atlas | None = None
    own_stiffness: OwnStiffness | None = None
    criteria: tuple[Criterion, ...] = ()
    required: RequirementsBlock | None = None
    switched_on: SwitchedOn | None = None
    effects: Shifts | None = None
    findings: Mapping[str, Any] = {}

    __repr__ = brief

    @cached_property
    def stable(self) -> list[tuple[Family, Motion]]:
        """The stable motions that are known at the design point, with their families.

        Raises
        ------
        NumericalError
            Where none were followed there.
        """
        design, sweep = self.solution.design, self.solution.sweep
        if self.atlas is None or design is None or sweep is None:
            raise NumericalError(Remark.NOT_FOLLOWED.said())
        if not min(sweep.start, sweep.end) <= design.value <= max(sweep.start, sweep.end):
            raise NumericalError(Remark.BESIDE_SWEEP.said())
        return self.atlas.stable_at(design.value)

    @property
    def only_one_to_one(self) -> bool:
        """Whether no motion but 1:1 is to be judged: no other is allowed, or stable at the design point."""
        one_to_one = "BT", self.solution.device.period_ratio
        return not self.allowed or all(
            (family.word.letters, family.word.periods) == one_to_one for family, _ in self.stable
        )

    @property
    def from_rest(self) -> FromRest | None:
        """What the device comes to at the design point when it is switched on; None where that is not known."""
        return self.switched_on.from_rest if self.switched_on is not None else None

    @property
    def from_rest_along(self) -> tuple[FromRest, ...]:
        """What the device comes to from rest along a sweep without a design point; empty where that is not known."""
        if self.switched_on is None or self.solution.design is not None:
            return ()
        return self.switched_on.outcomes_over_sweep

    @property
    def motion_from_rest(self) -> FollowedMotion | None:
        """The motion of another word that the device comes to from rest, where no 1:1 motion is stable."""
        return self.switched_on.motion_from_rest if self.switched_on is not None else None

    @property
    def by_starts(self) -> tuple[FollowedMotion, ...]:
        """Stable motions that only some starts in flight come to, where no other stable motion is known."""
        return self.switched_on.by_starts if self.switched_on is not None else ()

    @cached_property
    def bottom(self) -> tuple[FollowedMotion, ...]:
        """For a ball on a table, a stable motion at the design point, followed along each input that it depends on.

        That is the motion which the device comes to from rest, if it has no rests, else the known one with the fewest
        impacts; () where none is known.
        """
        design = self.solution.design
        if design is None or not self.solution.on_table:
            return ()
        motions = [] if self.motion_from_rest is None else [self.motion_from_rest.motion]
        if not motions:
            motions = [] if self.atlas is None else [motion for _, motion in self.atlas.stable_at(design.value)]
            motions += [other.motion for other in self.by_starts]
            motions.sort(key=lambda motion: len(motion.word))
        followed = (followed_on_bottom(self.solution.device, motion) for motion in motions)
        return next(filter(None, followed), ())

    @property
    def ends_on_bottom(self) -> list[MotionEnd]:
        """The ends of the motion of `bottom` along all inputs, nearest first."""
        return motion_ends(self.solution.device, self.bottom)

    @property
    def required_motions_met(self) -> bool:
        """Whether there is a requirement on which motions may be stable, and it is met."""
        return any(criterion.names_motions and criterion.passed for criterion in self.criteria)

    @property
    def is_reached_from_rest(self) -> bool:
        """Whether the device comes from rest to the 1:1 motion or, where words are required, to one of these."""
        end = self.from_rest
        if end is None or not self.allowed:
            return end is not None and end.is_one_to_one
        return end.is_motion and self.allows(end.word)

    @cached_property
    def allowed(self) -> set[str]:
        """The required words, each in the form that stands for its rotations and mirror image."""
        words = self.required.allowed if self.required is not None else ()
        return {Word.of(word).canonical(self.solution.horizontal).letters for word in words}

    def allows(self, word: str) -> bool:
        """Whether a motion without rest has one of the words that are required."""
        return Word.of(word).canonical(self.solution.horizontal).letters in self.allowed

    @property
    def design(self) -> DesignPoint:
        """The design point, with stable motion there.

        Raises
        ------
        NumericalError
            Without a design point, or without stable motion there.
        """
        design = self.solution.design
        if design is None or not design.motions.stable_mask.any():
            raise NumericalError(Remark.NOT_STABLE.said())
        return design

    @cached_property
    def impacts(self) -> tuple[Floats, Floats, Floats]:
        """Velocities at the bottom and at the top [m/s] and frequencies [Hz] of the stable motions.

        At the design point where there is one, else along the sweep; empty where no motion is stable.
        """
        solution = self.solution
        groups = [branch.motions for branch in solution.branches]
        columns = [(np.empty(0),) * 3]
        for motions in groups if solution.design is None else [solution.design.motions]:
            stable = motions.stable_mask
            bottom, top = impact_velocities(solution.device, solution.parameter, motions)
            frequency = solution.device.at(solution.parameter, motions.sweep_value)[Parameter.FREQUENCY]
            columns.append((bottom[stable], top[stable], np.broadcast_to(frequency, len(stable))[stable]))
        bottom, top, frequency = (np.concatenate(column) for column in zip(*columns, strict=True))
        return bottom, top, frequency

    @cached_property
    def exactness(self) -> Exactness:
        """How exact all numbers are that the model of rigid impacts gives.

        Their error is the largest shift by long contacts, the real stiffness of the membranes or neglected effects, as
        far as these are known. Up to one per cent it is shown by the number of digits. Larger errors affect similar
        designs alike; pages say how large they are.
        """
        share, compliant, effects = self.contact_share, self.own_stiffness, self.effects
        if share is None:
            return OF_A_MODEL
        errors = [FINEST, END_MOVED * share]
        errors += [end.moved / abs(end.rigid) for end in compliant.ends if end.rigid] if compliant is not None else []
        errors += [abs(row.relative) for row in effects.rows if row.relative is not None] if effects is not None else []
        return Exactness(min(max(errors), OF_A_MODEL.relative))

    @cached_property
    def contact_share(self) -> float | None:
        """Longest contact of the stable motions over the forcing period, by an estimate without gravity and forcing.

        Taken along the sweep where no motion is stable at the design point. None without a ball mass, without stable
        motion, and where the restitution has no contact law.
        """
        membrane, (bottom, top, frequency) = self.solution.membrane, self.impacts
        if not bottom.size:
            bottom, top, frequency = Evidence(replace(self.solution, design=None)).impacts
        if membrane is None or not bottom.size:
            return None
        device = self.solution.device
        if device.alike and device.law is None:
            return contact_share(np.minimum(bottom, -top), membrane, device.restitution, frequency)
        if (law := device.law) is not None:
            impacts = [*((1, v) for v in bottom.tolist()), *((-1, v) for v in top.tolist())]
            shares = [
                contact_share(np.array([abs(v)]), membrane, law.at(wall, v)[0], np.array([f]))
                for (wall, v), f in zip(impacts, np.tile(frequency, 2), strict=True)
            ]
        else:
            speeds = zip((bottom, -top), by_wall(device.restitution), strict=True)
            shares = [contact_share(speed, membrane, r, frequency) for speed, r in speeds]
        return max((share for share in shares if share is not None), default=None)


def held_against(value: float, limit: Limit, why: str | Phrase = "", bound: float = 0.0) -> Judgement:
    """Hold a number, known to within a bound, against a limit that it must reach or must not exceed."""
    # Judgements have plain numbers and truth values, not those of NumPy.
    required, value, bound = limit.value, float(value), float(bound)
    margin = value - required if limit.is_least else required - value
    if margin >= 0 > margin - bound:
        why = Remark.UNDECIDED.said(error=bound, unit=limit.unit, remark=why)
    return Judgement(value, f"{apart((value, required))[0]} {limit.unit}", margin, margin - bound >= 0, why, bound)
