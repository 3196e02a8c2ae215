"""Alerts that results raise: what a reader must know before acting on the numbers.

`CAUSES` has for each alert of the catalogue (`vireport.text.alerts`) the function that finds its cause in the results.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import cast

import numpy as np

from vireport.design import (
    Solution,
    contact_share,
    input_error,
    mass_elasticity,
    restitution_effect,
)
from vireport.gate.requirements import Evidence, Question
from vireport.motions import Symmetry, undecided
from vireport.physics import Fitting
from vireport.scenario import DesignInput, Parameter
from vireport.text import CATALOGUE, AlertCode, Severity

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


LONGEST_M = 20.0
"""Length above which millimetres are more likely; the largest wave energy converters are shorter."""

HEAVIEST_BALL = 0.5
"""Mass of the ball over the capsule's, above which the capsule certainly feels it; published devices have up to 0.2."""

SAME_NUMBER = 1e-3
"""Relative difference up to which a value is a common angle in radians, or a round frequency in radians per second: as
it would be typed with four digits."""

FEW_DIGITS = 4
"""Digits below which a frequency in radians per second is only told by a round number of one digit of hertz: one of two
digits is too often near by chance."""

STRONGEST_GRAVITY = 50.0
"""Above what any planet has [m/s^2]."""

MEMBRANE_LENGTHS = ("ball_radius_m", "active_radius_m")
"""Lengths of a membrane's geometry."""

LAST_DIGIT = 5e-4
"""Relative rounding of a number that is printed with four digits."""

MOST_MOTIONS = 3
"""Other motions that are named."""


@dataclass(frozen=True, slots=True, eq=False)
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
    if any(criterion.question is Question.MOTION and criterion.passed for criterion in results.criteria):
        return None  # what is stable there is a motion that was asked for
    count = len(design.motions)
    which = {0: "there is no solution", 1: "the one solution is not admissible and stable"}
    none = f"none of the {count} solutions is admissible and stable"
    others = (
        dict.fromkeys(f.name for f, _ in results.atlas.stable_at(design.value)) if results.atlas is not None else ()
    )
    instead = f" Stable there: {', '.join(others)}." if others else ""
    return f"At {design.parameter.symbol} = {design.parameter.show(design.value)}, {which.get(count, none)}.{instead}"


def _several_stable(results: Evidence) -> str | None:
    solution, design = results.solution, results.solution.design
    count = int(design.motions.stable.sum()) if design is not None else 0
    if design is None or count < 2:
        return None
    if count == 2 and solution.horizontal and design.families.count(Symmetry.ASYMMETRIC) == 2:
        return None  # mirror images of each other
    return f"{count} stable 1:1 motions exist there; which one is reached depends on the start."


def _near_critical(results: Evidence) -> str | None:
    for margin in results.solution.design.endings() if results.solution.design is not None else ():
        if margin.relative is not None and abs(margin.relative) < NEAR_CRITICAL:
            side = "below" if margin.relative < 0 else "above"
            size = f"{100 * abs(margin.relative):.2f} % {side} the design point"
            return f"Stable motion ends {size} in {margin.parameter.quantity}: {margin.name}."
    return None


def _rough(results: Evidence) -> str | None:
    points = results.solution.critical_points
    rough = [c.label for c in points if c.error_bound > ROUGH * abs(c.sweep_value)]
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
        f"cannot hold there: read the voltages as a ranking, not as volts. {_what_fits(solution)}"
    ).rstrip()


def _what_fits(solution: Solution) -> str:
    """What would bring the deflection within the geometry, rounded to the side that does."""
    known, less, more = cast(Fitting, solution.fitting), 1 - LAST_DIGIT, 1 + LAST_DIGIT
    mass, stiffness, radius = known.ball_mass_kg, known.stiffness, known.active_radius_m
    ways = [
        *([f"a ball of at most {1e3 * less * mass:.4g} g"] if mass is not None else []),
        *([f"a stiffness of at least {more * stiffness:.4g} N/m^h"] if stiffness is not None else []),
        *([f"an active radius of at least {1e3 * more * radius:.4g} mm"] if radius is not None else []),
    ]
    return f"The deflection would fit with any one of: {'; '.join(ways)}." if ways else ""


def _breakdown(results: Evidence) -> str | None:
    design, membrane = results.solution.design, results.solution.membrane
    if design is None or design.conversion is None or membrane is None or membrane.dielectric is None:
        return None
    highest = float(np.max(design.conversion.field_v_m[design.motions.stable], initial=0.0))
    limit = membrane.dielectric.breakdown_field_v_m
    if highest <= limit:
        return None
    return f"The field reaches {highest:.3g} V/m, {highest / limit:.3g} times the breakdown field of {limit:.3g} V/m."


def longest_contact(solution: Solution) -> float | None:
    """Longest contact of the stable motions over the forcing period, by an estimate without gravity and forcing.

    None without a ball mass, without stable motion, and where the restitution has no contact law.
    """
    membrane, (bottom, top, frequency) = solution.membrane, Evidence(solution).impacts
    if membrane is None or not bottom.size:
        return None
    return contact_share(np.minimum(bottom, -top), membrane, solution.device.restitution, frequency)


def _long_contact(results: Evidence) -> str | None:
    share = longest_contact(results.solution)
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
    if compliance is None or compliance.grade is None or not compliance.grade.contradicts:
        return None
    if not results.impacts[0].size:
        return None
    label = compliance.critical.label if compliance.critical is not None else "the critical point"
    shifts = [
        f"{criterion.name} by {abs(criterion.shift):.2g} times the margin to it"
        if isinstance(compared.unit, Parameter)
        else f"{criterion.name} by {100 * criterion.shift:+.2g} %"
        for compared in compliance.quantities
        if (criterion := compared.criterion) is not None and criterion.grade.contradicts
    ]
    if shifts:
        return f"The membrane's own stiffness moves {', '.join(shifts)}."
    own = compliance.own
    followed = own is not None and own.orbit is not None and own.orbit.stable
    return f"With the membrane's own stiffness {label if followed else 'the stable motion'} is lost."


def _admissibility_undecided(results: Evidence) -> str | None:
    solution, design = results.solution, results.solution.design
    if design is None or solution.bounds.design is None:
        return None
    open_rows = np.flatnonzero(undecided(design.motions, solution.bounds.design))
    if not open_rows.size:
        return None
    gap, bound = (float(x[open_rows[0]]) for x in (design.motions.wall_gap, solution.bounds.design["wall_gap"]))
    return (
        f"The gap between the ball's turning point and a membrane is {gap:.2g} of the length unit x_c, with an error "
        f"bound of {bound:.2g}: undecided within rounding."
    )


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


def _implausible(results: Evidence) -> str | None:
    solution = results.solution
    sweep, device = solution.sweep, solution.device
    values = {f"device.{name}": getattr(solution.membrane, name, None) for name in ("ball_mass_kg",)}
    values |= {f"device.membrane.{name}": getattr(solution.membrane, name, None) for name in MEMBRANE_LENGTHS}
    values |= {varied.path: getattr(device, varied) for varied in DesignInput} | {"gravity_m_s2": device.gravity_m_s2}
    asked = [(path, value) for path, value in values.items() if value is not None]
    if sweep is not None:
        asked += [(f"sweep.{end}", value) for end, value in (("from", sweep.start), ("to", sweep.end))]
    kind = {"sweep.from": sweep.parameter.path, "sweep.to": sweep.parameter.path} if sweep is not None else {}
    questions = []
    for path, value in asked:
        question = _doubt(kind.get(path, path), float(value), float(device.capsule_mass_kg))
        if question:
            questions.append(f"{path} = {value:.6g}: {question}?")
    return " ".join(questions) or None


def _doubt(path: str, value: float, capsule: float) -> str:
    """What may have been meant by a value that can hardly be meant as it stands, or ""."""
    match path.rpartition(".")[2]:
        case "length_m" | "ball_radius_m" | "active_radius_m" if value > LONGEST_M:
            return f"metres, or is it {value:.6g} mm, which is {value / 1e3:.6g} m"
        case "ball_mass_kg" if value >= HEAVIEST_BALL * capsule:
            return f"{value / capsule:.3g} times the capsule's {capsule:.6g} kg, or is it {value:.6g} g"
        case "inclination_deg":
            turns = value / (np.pi / 12)
            if 0.5 < turns < 6.5 and abs(turns - round(turns)) < SAME_NUMBER * turns:
                return f"degrees, or is it {value:.6g} rad, which is {15 * round(turns)} degrees"
        case "frequency_hz":
            cycles = value / (2 * np.pi)
            digits = next(k for k in range(1, 18) if float(f"{value:.{k}g}") == value)
            short = float(f"{cycles:.{max(digits - 2, 1)}g}" if digits < FEW_DIGITS else f"{cycles:.2g}")
            if digits > 2 and abs(cycles - short) < SAME_NUMBER * cycles:
                return f"hertz, or is it {value:.6g} rad/s, which is {short:g} Hz"
        case "gravity_m_s2" if value > STRONGEST_GRAVITY:
            return f"m/s^2, or is it {value:.6g} cm/s^2, which is {value / 100:.6g} m/s^2"
    return ""


CAUSES: dict[AlertCode, Cause] = {
    AlertCode.NO_STABLE_MOTION: _no_stable_motion,
    AlertCode.INADMISSIBLE_SOLUTIONS: _inadmissible,
    AlertCode.DESIGN_NOT_STABLE: _design_not_stable,
    AlertCode.SEVERAL_STABLE_MOTIONS: _several_stable,
    AlertCode.NEAR_CRITICAL_POINT: _near_critical,
    AlertCode.ROUGH_CRITICAL_POINT: _rough,
    AlertCode.NEAR_GRAZING: _near_grazing,
    AlertCode.ILL_CONDITIONED: _ill_conditioned,
    AlertCode.SENSITIVE_TO_RESTITUTION: _sensitive_to_restitution,
    AlertCode.OUTSIDE_MEMBRANE_GEOMETRY: _outside_geometry,
    AlertCode.LONG_CONTACT: _long_contact,
    AlertCode.SENSITIVE_TO_BALL_MASS: _sensitive_to_ball_mass,
    AlertCode.NOT_RIGID: _not_rigid,
    AlertCode.ADMISSIBILITY_UNDECIDED: _admissibility_undecided,
    AlertCode.IMPLAUSIBLE_INPUT: _implausible,
    AlertCode.BREAKDOWN: _breakdown,
    AlertCode.SIMULATION_DISAGREES: _simulation_disagrees,
    AlertCode.COEXISTING_MOTIONS: _coexisting,
    AlertCode.CHATTER: _chatter,
}


def alerts(evidence: Evidence) -> tuple[Alert, ...]:
    """Collect the alerts that results raise, warnings first."""
    raised = [
        Alert(known.code, known.severity, known.title, cause, known.remedy)
        for known in CATALOGUE
        if (cause := CAUSES[known.code](evidence)) is not None
    ]
    return tuple(sorted(raised, key=lambda alert: (alert.severity is not Severity.WARNING, alert.code)))
