"""What requirements of the core say: questions that the verdict answers, and names of remarks on what they come to.

Their words, and the titles of requirements, are in `words/requirements.json`; `vireport.study.judging` finds which is
said, and the numbers.
"""

from __future__ import annotations

from enum import StrEnum, auto

from vireport.text.patterns import Pattern


class Question(StrEnum):
    """The questions that the verdict answers, in their order; those of additions come after them."""

    ACCEPTED = "Are the requirements met?"
    MOTION = "Is there stable motion?"
    WHERE = "Where is the 1:1 motion stable?"
    MARGIN = "With what margin?"
    OWN_STIFFNESS = "And with compliant membranes?"
    FROM_REST = "Is it reached from rest?"
    STARTS = "Which starts reach it?"
    VOLTAGE = "What voltage?"
    SHAKER = "What must the shaker do?"
    SIMULATED = "Does the simulation agree?"


class Remark(Pattern, file="requirements"):
    """What stands where there is no value, where a value comes from, and why a requirement is not met."""

    ONE_IS_NOT_MET = auto()
    SOME_ARE_NOT_MET = auto()
    THE_ONE_IS_NOT_MET = auto()
    UNMET = auto()
    TOGETHER = auto()

    NOT_KNOWN = auto()
    UNDECIDED = auto()
    DISAGREEMENT = auto()
    NO_DESIGN_POINT = auto()
    NO_SWEEP = auto()
    NOT_STABLE = auto()
    LEAST = auto()
    LARGEST = auto()
    OF_MOTION = auto()

    NOT_FOLLOWED = auto()
    BESIDE_SWEEP = auto()
    NO_MOTION = auto()
    NOT_ALLOWED = auto()
    REACHES = auto()
    REACHES_AFTER = auto()
    COMES_TO = auto()
    AFTER = auto()
    STARTS = auto()
    STARTS_TOO = auto()
    STARTS_TO = auto()

    STABLE_NOWHERE = auto()
    NOT_IN_RANGE = auto()
    NOT_OVER_RANGE = auto()
    NOT_IN_SWEEP = auto()
    RANGES = auto()
    ENDS_AT = auto()
    EVENT = auto()
    END_OF_KNOWN = auto()
    ENDS_NOWHERE = auto()
    U_AVE = auto()

    NO_END = auto()
    END = auto()
    ENDS_UNRESOLVED = auto()
    WITH_EFFECT = auto()
    WITH_EFFECT_OF = auto()
    EFFECT_OPEN = auto()
    NO_EFFECT = auto()
    NO_DISTORTION = auto()
    DISTORTION = auto()

    NO_SIMULATION = auto()
    NO_ORBIT = auto()
    AGAIN = auto()
    DIFFERENCE = auto()
