"""Alerts: what a reader must know before acting on the numbers.

Each alert is a row of `CHECKS`: its code, what it means, what to do, and the function that finds its cause in the
results.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cached_property
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import (
    Family,
    Solution,
    contact_share,
    impact_velocities,
    input_error,
    mass_elasticity,
    restitution_effect,
)
from vireport.errors import UsageError
from vireport.scenario import Parameter

if TYPE_CHECKING:
    from vireport.trust import Compliance, CrossCheck

Floats = NDArray[np.float64]

NEAR_CRITICAL = 0.02
"""Share of the design value within which a critical point is near: what masses and lengths are commonly made to. The
same share of the length is near a membrane."""

ROUGH = 1e-12
"""Relative error bound above which a critical point is called rough."""

ILL_CONDITIONED = 1e-9
"""Change of q or phase by one rounding of the inputs, above which digits are missing that a reader would trust."""

LONG_CONTACT = 0.01
"""Share of the forcing period above which a contact is long: shifts are of that size, and critical points move more."""

SENSITIVE = 2.0
"""Relative change of the velocity over that of the restitution; 1/(1-r) alone gives 1 for r = 0.5."""

HEAVY = 0.5
"""Relative change of U_ave over that of the ball's mass above which a mass known to 10 % is not enough for 5 %."""

NOT_GOOD_ENOUGH = 2
"""Grade of a rigid model that the compliant membrane contradicts."""

MOST_MOTIONS = 3
"""Other motions that are named."""

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
    OUTSIDE_MEMBRANE_GEOMETRY = "VR010"
    LONG_CONTACT = "VR011"
    SENSITIVE_TO_BALL_MASS = "VR012"
    NOT_RIGID = "VR013"
    SIMULATION_DISAGREES = "VR020"
    COEXISTING_MOTIONS = "VR021"
    CHATTER = "VR022"


class Severity(StrEnum):
    """Whether an alert keeps a reader from acting on the numbers, or only tells more about them."""

    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Alert:
    """An alert that results raise; the cause has its numbers."""

    code: AlertCode
    severity: Severity
    title: str
    cause: str
    remedy: str

    def to_dict(self) -> dict[str, str]:
        """The alert as results.json has it."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Evidence:
    """The results that alerts are found in."""

    solution: Solution
    crosscheck: CrossCheck | None
    compliance: Compliance | None

    @cached_property
    def impacts(self) -> tuple[Floats, Floats, Floats]:
        """Velocities at the bottom and at the top [m/s] and frequencies [Hz] of the stable motions.

        At the design point where there is one, else along the sweep; empty where no motion is stable.
        """
        solution = self.solution
        groups = [branch.motions for branch in solution.branches]
        columns = [(np.empty(0),) * 3]
        for motions in groups if solution.design is None else [solution.design.motions]:
            stable = motions.stable
            bottom, top = impact_velocities(solution.device, solution.parameter, motions)
            frequency = solution.device.at(solution.parameter, motions.sweep_value)[Parameter.FREQUENCY]
            columns.append((bottom[stable], top[stable], np.broadcast_to(frequency, len(stable))[stable]))
        bottom, top, frequency = (np.concatenate(column) for column in zip(*columns, strict=True))
        return bottom, top, frequency


Cause = Callable[[Evidence], str | None]
"""The cause of an alert with its numbers; None where the results do not raise it."""


def _no_stable_motion(results: Evidence) -> str | None:
    if results.solution.diagram is None or results.solution.stable_ranges:
        return None
    return "Nowhere in the sweep is there an admissible 1:1 motion that attracts the motions nearby."


def _inadmissible(results: Evidence) -> str | None:
    branches = results.solution.branches
    discarded = [(part, branch) for branch in branches for part in branch.segments() if not part.admissible]
    if not discarded:
        return None
    depth = -min(float(branch.motions.wall_gap[part.first : part.last + 1].min()) for part, branch in discarded)
    stable = any(part.stability.attracts for part, _ in discarded)
    stretches = "One stretch" if len(discarded) == 1 else f"{len(discarded)} stretches"
    return (
        f"{stretches} of the algebraic solution would pass through a membrane, by up to {depth:.3g} "
        f"of the length unit x_c{', some with eigenvalues that would call them stable' if stable else ''}. "
        "They are listed in the results as not admissible, and neither drawn nor counted."
    )


def _design_not_stable(results: Evidence) -> str | None:
    design = results.solution.design
    if design is None or design.motions.stable.any():
        return None
    return (
        f"At {design.parameter} = {design.value:.6g} there are {len(design.motions)} solutions, none of them "
        "admissible and stable."
    )


def _several_stable(results: Evidence) -> str | None:
    solution, design = results.solution, results.solution.design
    count = int(design.motions.stable.sum()) if design is not None else 0
    if design is None or count < 2:
        return None
    if count == 2 and solution.horizontal and design.families.count(Family.ASYMMETRIC) == 2:
        return None  # mirror images of each other
    return f"{count} stable 1:1 motions exist there; which one is reached depends on the start."


def _near_critical(results: Evidence) -> str | None:
    for margin in results.solution.design.margins if results.solution.design is not None else ():
        if margin.ends_stability and margin.relative is not None and abs(margin.relative) < NEAR_CRITICAL:
            share = f"{100 * margin.relative:+.2f} %"
            return f"{margin.label} ({margin.kind.words}) is {share} away in {margin.parameter}."
    return None


def _rough(results: Evidence) -> str | None:
    points = results.solution.critical_points
    rough = [c.label for c in points if c.point.error_bound > ROUGH * abs(c.point.sweep_value)]
    if not rough:
        return None
    return (
        f"{', '.join(rough)}: so nearly degenerate that it was bracketed, not polished; the error bound says how well."
    )


def _near_grazing(results: Evidence) -> str | None:
    if results.solution.design is None:
        return None
    motions = results.solution.design.motions
    gap, d = motions.wall_gap, motions.d
    near = motions.stable & (gap < d) & (gap < NEAR_CRITICAL * d)
    if not near.any():
        return None
    share = float(np.min((gap / d)[near]))
    return f"The ball turns {100 * share:.2g} % of the length from a membrane without touching it."


def _ill_conditioned(results: Evidence) -> str | None:
    if results.solution.design is None:
        return None
    motions = results.solution.design.motions
    error = float(np.max(input_error(results.solution.device, motions)[motions.admissible], initial=0.0))
    if error <= ILL_CONDITIONED:
        return None
    return f"A single rounding of the length or the inclination moves q or the phase by {error:.1g}."


def _sensitive_to_restitution(results: Evidence) -> str | None:
    if results.solution.design is None:
        return None
    effect = restitution_effect(results.solution.device, results.solution.design.motions)
    if effect is not None and effect.lost_at is not None:
        return f"At a restitution of {effect.lost_at:.4g} a stable motion of the design point is lost."
    if effect is not None and effect.elasticity > SENSITIVE:
        return f"1 % of restitution changes the impact velocity by {effect.elasticity:.2g} %."
    return None


def _outside_geometry(results: Evidence) -> str | None:
    solution, membrane = results.solution, results.solution.membrane
    if membrane is None or solution.within_membrane:
        return None
    depth, radius = solution.deepest_m, membrane.active_radius_m
    return (
        f"The impacts press the membrane up to {1e3 * depth:.3g} mm deep, {depth / radius:.2g} times its active "
        f"radius of {1e3 * radius:.3g} mm. "
        f"The formulae still evaluate, to {solution.highest_v:.3g} V above a bias of {membrane.bias_voltage_v:.4g} V, "
        "but the cone-and-cap shape of Eqs. (5.3)-(5.5) "
        "cannot hold there: read the voltages as a ranking, not as volts."
    )


def _long_contact(results: Evidence) -> str | None:
    membrane, (bottom, top, frequency) = results.solution.membrane, results.impacts
    if membrane is None or not bottom.size:
        return None
    slowest = np.minimum(bottom, -top)
    share = contact_share(slowest, membrane, results.solution.device.restitution, frequency)
    if share is None or share <= LONG_CONTACT:
        return None
    return (
        f"A contact takes some {100 * share:.2g} % of the forcing period with the membrane's own stiffness, "
        "by an estimate without gravity and forcing."
    )


def _sensitive_to_ball_mass(results: Evidence) -> str | None:
    membrane, (bottom, top, _) = results.solution.membrane, results.impacts
    if membrane is None or not bottom.size:
        return None
    elasticity = mass_elasticity(bottom, top, membrane)
    return f"1 % of ball mass changes U_ave by up to {elasticity:.2g} %." if elasticity > HEAVY else None


def _not_rigid(results: Evidence) -> str | None:
    compliance = results.compliance
    if compliance is None or not results.impacts[0].size or compliance.grade != NOT_GOOD_ENOUGH:
        return None
    label = compliance.critical.label if compliance.critical is not None else "the critical point"
    shifts = [
        f"{criterion.name} by {abs(criterion.shift):.2g} times the margin to it"
        if criterion.name == label
        else f"{criterion.name} by {100 * criterion.shift:+.2g} %"
        for criterion in compliance.criteria
        if criterion.grade == NOT_GOOD_ENOUGH
    ]
    if shifts:
        return f"The membrane's own stiffness moves {', '.join(shifts)}."
    own = compliance.own
    followed = own is not None and own.orbit is not None and own.orbit.stable
    return f"With the membrane's own stiffness {label if followed else 'the stable motion'} is lost."


def _simulation_disagrees(results: Evidence) -> str | None:
    check = results.crosscheck
    if check is None or check.passed:
        return None
    return (
        f"Of {check.orbits} stable orbits the simulation left {len(check.misses)}; on the others the difference "
        f"reaches {max(check.velocity_difference, check.phase_difference):.2g} (tolerance {check.tolerance:.2g})."
    )


def _coexisting(results: Evidence) -> str | None:
    check = results.crosscheck
    if check is None or not check.elsewhere:
        return None
    others = ", ".join(f"{motion.count} in {motion.name}" for motion in check.elsewhere[:MOST_MOTIONS])
    return (
        f"{check.trials - check.reached} of {check.trials} starts where a stable 1:1 motion exists end elsewhere "
        f"({others})."
    )


def _chatter(results: Evidence) -> str | None:
    check, device, sweep = results.crosscheck, results.solution.device, results.solution.sweep
    if check is not None:
        held = sum(motion.count for motion in check.motions if motion.stays)
        if held:
            total = sum(motion.count for motion in check.motions)
            return f"{held} of {total} simulated starts end in chatter or at rest."
    at = (sweep.parameter, (sweep.start, sweep.end)) if sweep is not None else (Parameter.LENGTH, (device.length_m,))
    parameter, values = at
    gbar = max(device.groups(parameter, value)[1] for value in values)
    return f"gbar reaches {gbar:.3g}: a ball at rest on the bottom membrane stays there." if gbar >= 1 else None


@dataclass(frozen=True, slots=True)
class Check:
    """An alert that results can raise: what raises it and why it matters, what to do, and how its cause is found."""

    code: AlertCode
    severity: Severity
    title: str
    meaning: str
    remedy: str
    cause: Cause


CHECKS = (
    Check(
        AlertCode.NO_STABLE_MOTION,
        Severity.WARNING,
        "No stable 1:1 motion",
        "Nowhere in the sweep is there a motion with one impact on each membrane per period that stays between the "
        "membranes and attracts the motions nearby. The device does something else there: other impact sequences, "
        "chaos, or rest.",
        "Widen the sweep, or change length, force, frequency or inclination.",
        _no_stable_motion,
    ),
    Check(
        AlertCode.INADMISSIBLE_SOLUTIONS,
        Severity.NOTE,
        "Solutions that are not motions were left out",
        "The periodicity conditions know only the ends of each flight. Some of their solutions pass through a membrane "
        "in between; the eigenvalues may even call them stable. They are in the results, marked as not admissible, "
        "and neither drawn nor counted.",
        "Nothing to do; the grazing points show where the motions end.",
        _inadmissible,
    ),
    Check(
        AlertCode.DESIGN_NOT_STABLE,
        Severity.WARNING,
        "The design point has no stable 1:1 motion",
        "Of all solutions at the design point none is both admissible and stable.",
        "Move the design point into a stable range.",
        _design_not_stable,
    ),
    Check(
        AlertCode.SEVERAL_STABLE_MOTIONS,
        Severity.NOTE,
        "Several stable motions coexist at the design point",
        "More than one stable 1:1 motion exists there, with different velocities and voltages; which one the device "
        "settles on depends on how it is started.",
        "Check the start, or move to where there is one.",
        _several_stable,
    ),
    Check(
        AlertCode.NEAR_CRITICAL_POINT,
        Severity.WARNING,
        "The design point is near the end of stable motion",
        "A period doubling, fold, pitchfork or grazing point that ends the stable range is closer than 2 % of the "
        "design value, which is what masses and lengths are commonly made to. Transients are long there, too.",
        "Keep a larger margin: manufacturing tolerances and the unknown restitution may carry the device across.",
        _near_critical,
    ),
    Check(
        AlertCode.ROUGH_CRITICAL_POINT,
        Severity.WARNING,
        "A critical point is known only roughly",
        "Two conditions nearly coincide there (next to a point of codimension two, or at a restitution within rounding "
        "of 0), so that it was bracketed rather than polished. Its error bound says how well.",
        "Use it only as far as its error bound allows.",
        _rough,
    ),
    Check(
        AlertCode.NEAR_GRAZING,
        Severity.WARNING,
        "The design point is near grazing",
        "In a flight the ball turns within 2 % of the capsule's length of a membrane without touching it. A small "
        "change makes it touch there; such an impact has no velocity, the return map has an infinite slope, and "
        "stability is lost at once rather than gradually.",
        "Change length or force so that the ball turns farther from the membrane, or does not turn at all.",
        _near_grazing,
    ),
    Check(
        AlertCode.ILL_CONDITIONED,
        Severity.WARNING,
        "Numbers at the design point are ill-conditioned",
        "One rounding of the inputs, in their sixteenth digit, moves the motion in its ninth or before: it is next to "
        "a fold or pitchfork, or the restitution is next to 1. What is known of the inputs decides how much holds.",
        "Move away from the fold, or use a restitution further from 1; do not act on the digits beyond.",
        _ill_conditioned,
    ),
    Check(
        AlertCode.SENSITIVE_TO_RESTITUTION,
        Severity.WARNING,
        "The result is sensitive to the restitution",
        "The restitution coefficient is rarely known to better than a few per cent. Within 5 % of the value given the "
        "stable motion of the design point is lost, or its impact velocity changes by more than twice as much as the "
        "restitution does.",
        "Measure the restitution; study the design with its least and largest value (--set device.restitution=...).",
        _sensitive_to_restitution,
    ),
    Check(
        AlertCode.OUTSIDE_MEMBRANE_GEOMETRY,
        Severity.WARNING,
        "The membrane model is outside its geometry",
        "The deflection of (5.5) exceeds the active radius of the membrane. The cone-and-cap shape of (5.3) and (5.4) "
        "cannot hold there, though the formulae still evaluate, to voltages that no membrane would survive.",
        "Use a lighter ball, a stiffer or larger membrane, or gentler forcing; or measure the membrane's force law "
        "at such depths.",
        _outside_geometry,
    ),
    Check(
        AlertCode.LONG_CONTACT,
        Severity.WARNING,
        "The contact is long for the rigid model",
        "The ball is in contact with a membrane for more than 1 % of the forcing period, while the model takes impacts "
        "as instantaneous. Velocities and phases then shift by about as much, and critical points by more.",
        "See how far things move with the membrane's own stiffness: vireport accuracy, or an accuracy block in the "
        "scenario, solves that motion. Or use a stiffer membrane or a lighter ball.",
        _long_contact,
    ),
    Check(
        AlertCode.SENSITIVE_TO_BALL_MASS,
        Severity.NOTE,
        "The voltage is sensitive to the ball's mass",
        "U_ave changes by more than half the share by which the mass of the ball does. The paper does not give that "
        "mass; published values for this device differ by a factor of six.",
        "Weigh the ball. Velocities, stability and critical points do not depend on it.",
        _sensitive_to_ball_mass,
    ),
    Check(
        AlertCode.NOT_RIGID,
        Severity.WARNING,
        "The rigid model is not good enough here",
        "With the membrane's own stiffness the impact velocity moves by more than 5 %, U_ave by more than 20 % or the "
        "critical point by more than half the margin, or the motion or the critical point is lost.",
        "Act on the values with compliant membranes; the section on them has the shifts.",
        _not_rigid,
    ),
    Check(
        AlertCode.SIMULATION_DISAGREES,
        Severity.WARNING,
        "Simulation and solution do not agree",
        "A simulation begun beside a stable motion did not end on it, or ended off it by more than the tolerance. One "
        "of the two is wrong there.",
        "Do not act on the verdict. Look where the differences are; near a critical point widen the tolerance, and "
        "report anything else.",
        _simulation_disagrees,
    ),
    Check(
        AlertCode.COEXISTING_MOTIONS,
        Severity.NOTE,
        "Other motions coexist with the stable 1:1 motion",
        "Where a stable 1:1 motion exists, some simulated starts end on something else.",
        "See that the device is started within reach of the 1:1 motion.",
        _coexisting,
    ),
    Check(
        AlertCode.CHATTER,
        Severity.NOTE,
        "Chatter nearby",
        "The ball can fall into infinitely many ever smaller impacts on one membrane and then ride on it: simulated "
        "starts end so, or gravity alone holds it on the bottom (gbar of 1 or more). Such a motion generates little, "
        "and a fixed-step simulation stalls in it or steps through the membrane.",
        "Start the device with enough velocity; less inclination or more force if it is gravity.",
        _chatter,
    ),
)
"""All alerts, in the order of their codes."""


def alerts(solution: Solution, crosscheck: CrossCheck | None, compliance: Compliance | None) -> tuple[Alert, ...]:
    """Collect the alerts that results raise, warnings first."""
    evidence = Evidence(solution, crosscheck, compliance)
    causes = ((check, check.cause(evidence)) for check in CHECKS)
    raised = [
        Alert(check.code, check.severity, check.title, cause, check.remedy)
        for check, cause in causes
        if cause is not None
    ]
    return tuple(sorted(raised, key=lambda alert: (alert.severity is not Severity.WARNING, alert.code)))


def explanation(code: str | None = None) -> str:
    """Text on one alert, or on all of them.

    Raises
    ------
    UsageError
        If there is no such code.
    """
    if code is None:
        return "\n".join(map(_explained, CHECKS))
    check = next((check for check in CHECKS if check.code == code.strip().upper()), None)
    if check is None:
        raise UsageError(f"there is no alert {code!r} (allowed: {', '.join(AlertCode)})")
    return _explained(check)


def _explained(check: Check) -> str:
    paragraphs = (f"Cause: {check.meaning}", f"Remedy: {check.remedy}")
    lines = [fill(text, EXPLANATION_WIDTH, initial_indent="  ", subsequent_indent="  ") for text in paragraphs]
    return "\n".join([f"{check.code} ({check.severity}): {check.title}", *lines, ""])
