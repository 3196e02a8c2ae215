"""All words of requirements of the core: titles, questions, and what is remarked on what they come to.

`vireport.study.judging` finds which is said, and the numbers.
"""

from __future__ import annotations

from enum import StrEnum

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


TITLES = {
    "stable_from": ("Stable 1:1 motion over the range", Question.WHERE),
    "inclination_from_deg": ("Stable 1:1 motion over the inclinations", Question.WHERE),
    "margin_period_doubling_percent": ("Margin to period doubling", Question.MARGIN),
    "margin_grazing_percent": ("Margin to grazing", Question.MARGIN),
    "margin_any_percent": ("Margin to the end of stable motion", Question.MARGIN),
    "word": ("Stable motion at the design point", Question.MOTION),
    "reached_from_rest": ("Reached from rest", Question.FROM_REST),
    "recovers_within_periods": ("Recovery from small disturbances", Question.FROM_REST),
    "margin_with_effects_percent": ("Margin with what is left out", Question.MARGIN),
    "withstands_distortion_percent": ("Distortion that is withstood", Question.MARGIN),
    "u_ave_at_least_v": ("U_ave", Question.VOLTAGE),
    "u_ave_difference_at_most_v": ("Difference of U_ave over the stable range", Question.VOLTAGE),
    "u_bottom_top_difference_at_most_v": ("Difference of voltage between the ends", Question.VOLTAGE),
    "deflection_at_most_m": ("Deflection", Question.VOLTAGE),
    "deflection_at_most_percent": ("Deflection over the membrane's radius", Question.VOLTAGE),
    "area_ratio_at_most": ("Area of a membrane over that when it is flat", Question.VOLTAGE),
    "power_at_least_mw": ("Mean electrical power", Question.VOLTAGE),
    "efficiency_at_most_percent": ("Electrical efficiency", Question.VOLTAGE),
    "field_at_most_percent": ("Electric field over breakdown field", Question.VOLTAGE),
    "acceleration_at_most_g": ("Acceleration of the shaker", Question.SHAKER),
    "stroke_at_most_m": ("Stroke of the shaker", Question.SHAKER),
    "force_at_most_n": ("Force of the shaker", Question.SHAKER),
    "crosscheck_passed": ("Simulation agrees", Question.SIMULATED),
}
"""Title of each requirement, and the question of the verdict that it is held beside, by its first key."""


class Remark(Pattern):
    """What stands where there is no value, where a value comes from, and why a requirement is not met."""

    ONE_IS_NOT_MET = "1 of {total} requirements is not met: {names}"
    SOME_ARE_NOT_MET = "{count} of {total} requirements are not met: {names}"
    THE_ONE_IS_NOT_MET = "1 of 1 requirement is not met: {names}"

    NOT_KNOWN = "not known"
    UNDECIDED = "not decided: known to within {error:bound} {unit} only; {remark}"
    DISAGREEMENT = "the simulation does not agree with the solution"
    NO_DESIGN_POINT = "there is no design point"
    NO_SWEEP = "there is no sweep"
    NOT_STABLE = "there is no stable 1:1 motion at the design point"
    LEAST = "the least of {count} stable motions"
    LARGEST = "the largest of {count} stable motions"
    OF_MOTION = "of {motion}"

    NOT_FOLLOWED = "no motions were followed"
    BESIDE_SWEEP = "the design point is not within the sweep, along which motions are followed"
    NO_MOTION = "no stable motion is known at the design point"
    NOT_ALLOWED = "stable there, and not allowed: {motions}"
    REACHES = "from rest the device reaches it"
    REACHES_AFTER = "from rest the device reaches it after {periods} periods"
    COMES_TO = "from rest the device comes to {motion}"
    AFTER = "after {periods} periods"
    STARTS = "{count} of {total} random starts at {place}"
    STARTS_TOO = "so do {starts}"
    STARTS_TO = "to {words} come {starts}"

    STABLE_NOWHERE = "nowhere"
    NOT_IN_RANGE = "there is no stable 1:1 motion in the range"
    NOT_OVER_RANGE = "there is no stable 1:1 motion over all of the range that is required"
    NOT_IN_SWEEP = "there is no stable 1:1 motion in the sweep"
    STABLE_FROM = "stable from {ranges}"
    ENDS_AT = "stable motion ends at {value} {unit} ({event})"
    EVENT = "{event}, known to within {error:bound} {unit}"
    END_OF_KNOWN = "end of what is known"
    ENDS_NOWHERE = "stable motion ends nowhere in the range looked at"
    U_AVE = "U_ave from {range} V"

    NO_END = "none in any input"
    END = "{event} at {input} = {value}"
    ENDS_UNRESOLVED = "rounding does not resolve where stable motion ends along {inputs}"
    WITH_EFFECT = "with {effect}"
    WITH_EFFECT_OF = "with {effect} {size}"
    EFFECT_OPEN = "{effect}: {reason}"
    NO_EFFECT = "none of the effects applies to the device"
    NO_DISTORTION = "none ends stable motion up to there"
    DISTORTION = "of order {order}, at {phase} degrees: found by rays, not proved"

    NO_SIMULATION = "there is no simulation"
    NO_ORBIT = "there was no stable orbit to compare"
    AGAIN = "{count} of {total} stable orbits found again"
    DIFFERENCE = "largest difference {difference:roughly}"
