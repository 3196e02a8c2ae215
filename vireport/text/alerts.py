"""All words of alerts: what they mean, what to do, and the sentences that say with numbers what raises one.

`vireport.study.judging` finds where they are raised, and the numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from enum import StrEnum
from textwrap import fill
from typing import Any, NamedTuple

from msgspec import Struct

from vireport.base.errors import UsageError
from vireport.text.patterns import filled
from vireport.text.terms import TERMS

EXPLANATION_WIDTH = 100
"""Columns of a line of explanation."""


class AlertCode(StrEnum):
    """What alerts are known by, outside of this package too."""

    NO_STABLE_MOTION = "VR001"
    INADMISSIBLE_SOLUTIONS = "VR002"
    DESIGN_NOT_STABLE = "VR003"
    SEVERAL_STABLE_MOTIONS = "VR004"
    NEAR_CRITICAL_POINT = "VR005"
    ROUGH_CRITICAL_POINT = "VR006"
    NEAR_GRAZING = "VR007"
    ILL_CONDITIONED = "VR008"
    SENSITIVE_TO_RESTITUTION = "VR009"
    DEEP_DEFLECTION = "VR010"
    LONG_CONTACT = "VR011"
    SENSITIVE_TO_BALL_MASS = "VR012"
    NOT_RIGID = "VR013"
    ADMISSIBILITY_UNDECIDED = "VR014"
    IMPLAUSIBLE_INPUT = "VR015"
    BREAKDOWN = "VR016"
    MORE_ENERGY_THAN_LOST = "VR017"
    RECORD_DOUBTFUL = "VR018"
    SIMULATION_DISAGREES = "VR020"
    COEXISTING_MOTIONS = "VR021"
    CHATTER = "VR022"


class Severity(StrEnum):
    """Whether the numbers cannot be, whether a reader should not act on them as they are, or what else they tell.

    With an error no verdict is good.
    """

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"

    @property
    def rank(self) -> int:
        """Its place among all, the gravest first."""
        return list(Severity).index(self)


class Sentence(NamedTuple):
    """A sentence by its name in a row of the catalogue, and what its pattern takes.

    A number or a text is printed as the pattern says. A list of sentences is printed as phrases, with the format of its
    field between them.
    """

    name: str
    values: Mapping[str, Any] = {}


class _Phrases(tuple[str, ...]):
    """Phrases of one sentence; its pattern has what stands between them as the format of the field."""

    def __format__(self, between: str) -> str:
        return between.join(self)


class Explanation(Struct, frozen=True, eq=False):
    """What an alert is known by, why it matters, what to do, and the patterns of the sentences on its cause.

    `severity` is that of the alert, unless one of its sentences is `milder`.
    """

    code: AlertCode
    severity: Severity
    title: str
    meaning: str
    remedy: str
    cause: Mapping[str, str]
    milder: Mapping[str, Severity] = {}

    @property
    def severities(self) -> str:
        """All that it may have, the mildest first."""
        return " or ".join([*dict.fromkeys(self.milder.values()), self.severity])

    def severity_of(self, sentences: Iterable[Sentence]) -> Severity:
        """The severity of an alert with these sentences."""
        return next((self.milder[name] for name, _ in sentences if name in self.milder), self.severity)

    def worded(self, sentences: Iterable[Sentence]) -> str:
        """The cause with its numbers."""
        return " ".join(map(self._worded, sentences))

    def _worded(self, sentence: Sentence) -> str:
        values = {
            name: _Phrases(map(self._worded, value)) if isinstance(value, list) else value
            for name, value in sentence.values.items()
        }
        return filled(self.cause[sentence.name], values)


NO_AMPLITUDE = (
    "With this membrane no amplitude gives both short contacts and shallow dents: where an impact presses it in by its "
    "radius, the contact lasts {percent:roughly} % of a period, and at less depth no shorter."
)
"""Said where contacts are long or deflections large."""

CATALOGUE = (
    Explanation(
        AlertCode.NO_STABLE_MOTION,
        Severity.WARNING,
        "No stable 1:1 motion",
        "Nowhere in the sweep is there a motion with one impact on each membrane per period that stays between the "
        "membranes and attracts the motions nearby. The device does something else there: other impact sequences, "
        "chaos, or rest. A block 'motions:' shows which other motions are stable there, a block 'simulation:' what the "
        "ball does from any start.",
        "Widen the sweep, or change length, force, frequency or inclination.",
        {
            "nowhere": "Nowhere in the sweep is there an admissible 1:1 motion that attracts the motions nearby.",
            "from_rest": "By simulation, a ball that lies on the bottom membrane when the shaking begins comes to: "
            "{each:; }.",
            "shown_by": "A block {blocks: or } shows it.",
            "each": "{symbol} = {value}: {motion}",
            "block": "'{block}:'",
        },
    ),
    Explanation(
        AlertCode.INADMISSIBLE_SOLUTIONS,
        Severity.NOTE,
        "Solutions that are not motions were left out",
        "The periodicity conditions describe only the ends of each flight. Some of their solutions pass through a "
        "membrane in between, even where their eigenvalues indicate stability. They are in the results, marked as not "
        "admissible, and neither drawn nor counted.",
        "Nothing to do; the grazing points show where the motions end.",
        {
            "one": "One stretch of the algebraic solution would pass through a membrane, by up to {depth} of the "
            "length unit x_c. It is listed in the results as not admissible, and neither drawn nor counted.",
            "one_stable": "One stretch of the algebraic solution would pass through a membrane, by up to {depth} "
            "of the length unit x_c, although its eigenvalues indicate stability. It is listed in the results as "
            "not admissible, and neither drawn nor counted.",
            "several": "{count} stretches of the algebraic solution would pass through a membrane, by up to "
            "{depth} of the length unit x_c. They are listed in the results as not admissible, and neither "
            "drawn nor counted.",
            "several_stable": "{count} stretches of the algebraic solution would pass through a membrane, by up to "
            "{depth} of the length unit x_c, some with eigenvalues that indicate stability. They are listed "
            "in the results as not admissible, and neither drawn nor counted.",
            "turns": "In {count} of the stretches of the algebraic solution the ball would turn back between two "
            "impacts, and friction with it: these are no motions. A block 'simulation:' shows what the ball does "
            "there, with its stops.",
        },
    ),
    Explanation(
        AlertCode.DESIGN_NOT_STABLE,
        Severity.WARNING,
        "The design point has no stable 1:1 motion",
        "Of all 1:1 solutions at the design point none is both admissible and stable, and no other motion is required. "
        "A block 'motions:' with a 'sweep:' shows which motions are stable, a block 'simulation:' what the ball does "
        "from any start.",
        "Move the design point into a stable range, or require the word of a motion that is stable there.",
        {
            "none": "At {place}, there is no solution.",
            "one": "At {place}, the one solution is not admissible and stable.",
            "several": "At {place}, none of the {count} solutions is admissible and stable.",
            "by_law": "The restitution falls with speed: only motions that continue solutions of a constant one, "
            "and the one that the device comes to from rest, were sought. There may be others.",
            "lost": "The restitution falls with speed: only motions that continue solutions of a constant one, "
            "and the one that the device comes to from rest, were sought. {count} solutions "
            "could not be followed so far, and there may be other motions.",
            "instead": "Stable there: {others}.",
            "from_rest": "By simulation, a ball that lies on the bottom membrane when the shaking begins comes to: "
            "{motion}.",
            "shown_by": "A block '{block}:' shows it.",
            "stops": "In that motion friction stops the ball between two impacts; the equations of 1:1 motions are "
            "those of a ball that moves on.",
            "followed": "Solved by its equations, that motion is a {type} from {symbol} = {low} ({below}) to "
            "{high} ({above}).",
            "by_starts": "Some starts in flight come to {motion}: by its equations a {type} from {symbol} = {low} "
            "({below}) to {high} ({above}).",
        },
    ),
    Explanation(
        AlertCode.SEVERAL_STABLE_MOTIONS,
        Severity.NOTE,
        "Several stable motions coexist at the design point",
        "More than one stable 1:1 motion exists there, with different velocities and voltages; which one the device "
        "settles on depends on how it is started.",
        "Check how the device is started, or choose a design point with only one stable motion.",
        {
            "count": "{count} stable 1:1 motions exist there; which one is reached depends on the start.",
        },
    ),
    Explanation(
        AlertCode.NEAR_CRITICAL_POINT,
        Severity.WARNING,
        "The design point is near the end of stable motion",
        "A period doubling, fold, pitchfork or grazing point that ends the stable range is closer than 2 % of the "
        "design value, which is what masses and lengths are commonly made to. Transients are long there, too.",
        "Keep a larger margin: manufacturing tolerances and the unknown restitution may carry the device across.",
        {
            "below": "Stable motion ends {share} below the design point in {quantity}: {name}.",
            "above": "Stable motion ends {share} above the design point in {quantity}: {name}.",
            "passes_below": "Stability passes to another motion, with other voltages, {share} below the design "
            "point in {quantity}: {name}.",
            "passes_above": "Stability passes to another motion, with other voltages, {share} above the design "
            "point in {quantity}: {name}.",
        },
    ),
    Explanation(
        AlertCode.ROUGH_CRITICAL_POINT,
        Severity.WARNING,
        "A critical point is known only roughly",
        "Two conditions nearly coincide there (next to a point of codimension two, or at a restitution within rounding "
        "of 0), so that it was bracketed rather than polished. Its error bound says how well.",
        "Use it only as far as its error bound allows.",
        {
            "one": "{labels}: so nearly degenerate that it was bracketed, not polished; the error bound says how well.",
            "several": "{labels}: so nearly degenerate that they were bracketed, not polished; the error bounds say "
            "how well.",
        },
    ),
    Explanation(
        AlertCode.NEAR_GRAZING,
        Severity.WARNING,
        "The design point is near grazing",
        "In a flight the ball turns within 2 % of the capsule's length of a membrane without touching it. A small "
        "change makes it touch there; such an impact has no velocity, the return map has an infinite slope, and "
        "stability is lost at once rather than gradually.",
        "Change length or force so that the ball turns farther from the membrane, or does not turn at all.",
        {
            "turns": "The ball turns {percent:roughly} % of the length from a membrane without touching it.",
        },
    ),
    Explanation(
        AlertCode.ILL_CONDITIONED,
        Severity.WARNING,
        "Numbers at the design point are ill-conditioned",
        "One rounding of the inputs, in their sixteenth digit, moves the motion in its ninth or before: it is next to "
        "a fold or pitchfork, or the restitution is next to 1. What is known of the inputs decides how much holds.",
        "Move away from the fold, or use a restitution further from 1; do not act on the digits beyond.",
        {
            "moves": "A single rounding of the length or the inclination moves q or the phase by {error:roughly}.",
        },
    ),
    Explanation(
        AlertCode.SENSITIVE_TO_RESTITUTION,
        Severity.WARNING,
        "The result is sensitive to the restitution",
        "The restitution coefficient is rarely known to better than a few per cent. Within 5 % of the value given the "
        "stable motion of the design point is lost, or its impact velocity changes by more than twice as much as the "
        "restitution does.",
        "Measure the restitution; study the design with its least and largest value (--set device.restitution=...).",
        {
            "lost": "At a restitution of {restitution:given} a stable motion of the design point is lost.",
            "changes": "1 % of restitution changes the impact velocity by {percent:roughly} %.",
        },
    ),
    Explanation(
        AlertCode.DEEP_DEFLECTION,
        Severity.WARNING,
        "A membrane is pressed in deeper than its radius",
        "A stable motion deflects a membrane by more than its active radius. The cone-and-cap shape of (5.3) and (5.4) "
        "holds at every depth, and voltages are given by the paper's formulae. What is open there: the force K delta^h "
        "of (5.5) is extrapolated, as the range in which it was fitted is not published, and the material must stand "
        "the stretch and the field. Above an area ratio of 5.9 this is a warning: an areal strain of 488 % has been "
        "demonstrated for a dielectric elastomer (Huang et al., Appl. Phys. Lett. 100 (2012) 041911).",
        "Measure the membrane's force and largest stretch at such depths. Where the scenario has its thickness, "
        "permittivity and breakdown field, field and energy are judged. A lighter ball, a stiffer or larger membrane "
        "or gentler forcing make the deflection smaller.",
        {
            "deep": "The impacts press the membrane in up to {depth_mm} mm, {times:roughly} times its active radius of "
            "{radius_mm:given} mm, and its area grows {area} times. The force K delta^h is extrapolated beyond the "
            "radius.",
            "far": "The impacts press the membrane in up to {depth_mm} mm, {times:roughly} times its active radius of "
            "{radius_mm:given} mm, and its area grows {area} times, more than the {limit:roughly} times demonstrated "
            "for a dielectric elastomer. The force K delta^h is extrapolated beyond the radius.",
            "thickness": "At a breakdown field of {field_mv_m:given} MV/m its {peak_kv} kV need a thickness of "
            "{thickness_mm:roughly} mm; the scenario gives none.",
            "no_amplitude": NO_AMPLITUDE,
        },
        {"deep": Severity.NOTE},
    ),
    Explanation(
        AlertCode.LONG_CONTACT,
        Severity.WARNING,
        "The contact is long for the rigid model",
        "The ball is in contact with a membrane for more than 1 % of the forcing period, while the model takes impacts "
        "as instantaneous. Velocities and phases then shift by about as much, and critical points by more.",
        "Act on the compliant ends and margins beside the rigid ones; vireport verify, or an accuracy block in the "
        "scenario, computes that motion in detail. Or use a stiffer membrane or a lighter ball.",
        {
            "share": "A contact takes some {percent:roughly} % of the forcing period with the membrane's own "
            "stiffness, by an estimate without gravity and forcing.",
            "no_amplitude": NO_AMPLITUDE,
        },
    ),
    Explanation(
        AlertCode.SENSITIVE_TO_BALL_MASS,
        Severity.NOTE,
        "The voltage is sensitive to the ball's mass",
        "U_ave changes by more than half the share by which the mass of the ball does. The paper does not give that "
        "mass; published values for this device differ by a factor of six.",
        "Weigh the ball. Velocities, stability and critical points depend on its mass only in a free capsule.",
        {
            "changes": "1 % of ball mass changes U_ave by up to {percent:roughly} %.",
        },
    ),
    Explanation(
        AlertCode.NOT_RIGID,
        Severity.WARNING,
        "The rigid model is not good enough here",
        "With the membrane's own stiffness the impact velocity moves by more than 5 %, U_ave by more than 20 % or the "
        "critical point by more than half the margin, or the motion or the critical point is lost.",
        "Act on the values with compliant membranes; the section on them has the shifts.",
        {
            "moves": "The membrane's own stiffness moves {shifts:, }.",
            "percent": "{name} by {percent:+roughly} %",
            "margins": "{name} by {margins:roughly} times the margin to it",
            "point_lost": "With the membrane's own stiffness {label} is lost.",
            "motion_lost": "With the membrane's own stiffness the stable motion is lost.",
        },
    ),
    Explanation(
        AlertCode.ADMISSIBILITY_UNDECIDED,
        Severity.WARNING,
        "Whether a solution at the design point is a motion is undecided",
        "The ball turns so near a membrane that rounding decides whether it stays clear of it or would pass through: "
        "the design point is a grazing point as far as double precision can tell.",
        "Do not act on whether it is called admissible; change length or force so that the ball turns farther from "
        "the membrane.",
        {
            "gap": "The gap between the ball's turning point and a membrane is {gap:roughly} of the length unit x_c, "
            "with an error bound of {bound:roughly}: undecided within rounding.",
        },
    ),
    Explanation(
        AlertCode.IMPLAUSIBLE_INPUT,
        Severity.WARNING,
        "A value may be in another unit",
        "A value of the scenario is allowed, but unlikely: a capsule or membrane of more than 20 m, a ball of "
        "more than half the capsule's mass, which the capsule would feel, an inclination that is a common angle in "
        "radians, a frequency that is a round number of hertz in radians per second, or gravity above 50 m/s^2.",
        "Compare the value with its unit, which stands in its key; if it is intended, nothing needs to be done.",
        {
            "length": "{path} = {value:given}: metres, or is it {value:given} mm, which is {meant:given} m?",
            "mass": "{path} = {value:given}: {times} times the capsule's {capsule:given} kg, or is it {value:given} g?",
            "angle": "{path} = {value:given}: degrees, or is it {value:given} rad, which is {meant} degrees?",
            "frequency": "{path} = {value:given}: hertz, or is it {value:given} rad/s, which is {meant:given} Hz?",
            "gravity": "{path} = {value:given}: m/s^2, or is it {value:given} cm/s^2, which is {meant:given} m/s^2?",
        },
    ),
    Explanation(
        AlertCode.BREAKDOWN,
        Severity.ERROR,
        "The electric field exceeds the breakdown field",
        "A membrane that is charged at its largest deflection and isolated has its highest field, U_imp over its "
        "thickness, when it is flat again. In a stable motion of the design point that is above the field that the "
        "material withstands: the membrane would be destroyed before the energy and power given could be taken.",
        "Lower the bias voltage, use a thicker membrane, or limit the deflection.",
        {
            "field": "The field reaches {highest} V/m, {times} times the breakdown field of {limit} V/m.",
        },
    ),
    Explanation(
        AlertCode.MORE_ENERGY_THAN_LOST,
        Severity.ERROR,
        "More electrical energy than the impacts lose",
        "What a membrane gains electrically is taken from the ball, as part of the kinetic energy that the restitution "
        "coefficient says is lost. In a stable motion of the design point the cycle of constant charge gains more than "
        "that: with these membranes the restitution cannot be what is given. The electrical force would stop the ball, "
        "and the motion, its stability and its voltages would be others.",
        "Measure the restitution with the bias voltage on, and give that; or lower the bias voltage, or use a thicker "
        "membrane, until the efficiency is well below 100 %.",
        {
            "gains": "The impacts gain {gained_mj} mJ in a period and lose {lost_mj} mJ: an efficiency of "
            "{percent} %, which contradicts the restitution of {restitution:given}.",
            "gains_apart": "The impacts gain {gained_mj} mJ in a period and lose {lost_mj} mJ: an efficiency "
            "of {percent} %, which contradicts the restitutions of {bottom:given} and {top:given}.",
            "gains_other": "The impacts of {motion} gain more than they lose: an efficiency of {percent} %.",
        },
    ),
    Explanation(
        AlertCode.RECORD_DOUBTFUL,
        Severity.WARNING,
        "The record of the shaker is doubtful",
        "The recorded acceleration has another amplitude than the force of the scenario gives its capsule, or the "
        "other sign, or samples that are no motion of a shaker: single ones far from all others, or many at the end of "
        "the instrument's range. What is driven or identified by it rests on these.",
        "Compare unit, axis and range of the sensor with the record, and record again or give the force that was set.",
        {
            "factor": "{channel} has an amplitude of {recorded} m/s^2, and the scenario's force gives the capsule "
            "{given} m/s^2: it fits times {factor}, {unit}.",
            "in_g": "as an acceleration in g would",
            "of_g": "as one in m/s^2 would that was taken for one in g",
            "thousand": "as one would that is a thousandth of what it says",
            "thousandth": "as one in mm/s^2 would",
            "force": "{channel} has an amplitude of {recorded} m/s^2, and the scenario's force gives the capsule "
            "{given} m/s^2, {ratio} times that.",
            "reversed": "{channel} fits the scenario times -1: its axis points to the bottom.",
            "lone": "At {at_s:given} s {channel} has one sample of {recorded} m/s^2: {off} m/s^2 from the "
            "shaker's motion, and all others within {given:roughly} m/s^2.",
            "clipped": "{channel} is cut off: {percent:roughly} % of its samples are at the end of its range.",
        },
    ),
    Explanation(
        AlertCode.SIMULATION_DISAGREES,
        Severity.WARNING,
        "Simulation and solution do not agree",
        "A simulation begun beside a stable motion did not end on it, or ended off it by more than the tolerance. One "
        "of the two is wrong there.",
        "Do not act on the verdict. Look where the differences are; near a critical point widen the tolerance, and "
        "report anything else.",
        {
            "left": "Of {orbits} stable orbits the simulation left {missed}; on the others the difference reaches "
            "{largest:roughly} (tolerance {tolerance:roughly}).",
        },
    ),
    Explanation(
        AlertCode.COEXISTING_MOTIONS,
        Severity.NOTE,
        "Other motions coexist with the stable 1:1 motion",
        "Where a stable 1:1 motion exists, some simulated starts end on something else.",
        "Start the device within reach of the 1:1 motion.",
        {
            "elsewhere": "{count} of {trials} starts where a stable 1:1 motion exists end elsewhere ({others:, }).",
            "motion": "{count} in {name}",
        },
    ),
    Explanation(
        AlertCode.CHATTER,
        Severity.NOTE,
        "Chatter nearby",
        "The ball can fall into infinitely many ever smaller impacts on one membrane and then ride on it: simulated "
        "starts end so, or gravity alone holds it on the bottom (gbar of 1 or more). Such a motion generates little, "
        "and a fixed-step simulation stalls in it or steps through the membrane.",
        "Start the device with enough velocity; less inclination or more force if it is gravity.",
        {
            "starts": "{held} of {total} simulated starts end in chatter or at rest.",
            "gravity": "gbar reaches {gbar}: a ball at rest on the bottom membrane stays there.",
        },
    ),
)
"""All alerts, in the order of their codes."""


def explanation(code: str | None = None) -> str:
    """Text on one alert or one term, or on all alerts.

    Raises
    ------
    UsageError
        If there is neither such a code nor such a term.
    """
    if code is None:
        return "\n".join(map(_explained, CATALOGUE))
    entry = next((entry for entry in CATALOGUE if entry.code == code.strip().upper()), None)
    if entry is not None:
        return _explained(entry)
    words = " ".join(code.lower().replace("-", " ").replace("_", " ").split())
    term = next((term for term in TERMS if term.lower().replace("_", " ") == words), None)
    if term is None:
        number = re.fullmatch(r"(?:vr)?0*(\d{1,3})", words.replace(" ", ""))
        close = [f"VR{int(number[1]):03}"] if number else get_close_matches(words, TERMS, 1)
        if close and close[0] in (*AlertCode, *TERMS):
            raise UsageError(f"there is no alert and no term {code!r}; did you mean '{close[0]}'?")
        allowed = ", ".join([*AlertCode, *TERMS])
        raise UsageError(f"there is no alert and no term {code!r} (allowed: {allowed})")
    return f"{term}\n{fill(TERMS[term], EXPLANATION_WIDTH, initial_indent='  ', subsequent_indent='  ')}\n"


def _explained(entry: Explanation) -> str:
    paragraphs = (f"Cause: {entry.meaning}", f"Remedy: {entry.remedy}")
    lines = [fill(text, EXPLANATION_WIDTH, initial_indent="  ", subsequent_indent="  ") for text in paragraphs]
    return "\n".join([f"{entry.code} ({entry.severities}): {entry.title}", *lines, ""])
