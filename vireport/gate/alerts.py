"""What a reader must know before acting on the numbers: alerts with a code, a cause with its numbers, and a remedy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from vireport.analysis import (
    Family,
    Solution,
    contact_share,
    impact_velocities,
    input_error,
    mass_elasticity,
    restitution_effect,
)
from vireport.gate.explanations import EXPLANATIONS
from vireport.scenario import Parameter

if TYPE_CHECKING:
    from vireport.trust import Compliance, CrossCheck


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


@dataclass(frozen=True, slots=True)
class Alert:
    """One warning.

    Attributes
    ----------
    code : str
        Stable identifier.
    severity : str
        ``warning`` or ``note``.
    title, cause, remedy : str
    """

    code: str
    severity: Literal["warning", "note"]
    title: str
    cause: str
    remedy: str


def _alert(code: str, cause: str) -> Alert:
    about = EXPLANATIONS[code]
    return Alert(code, about.severity, about.title, cause, about.remedy)


def alerts(solution: Solution, crosscheck: CrossCheck | None, compliance: Compliance | None) -> tuple[Alert, ...]:
    """Collect the alerts that results raise, warnings first."""
    found = [
        *_simulation_alerts(crosscheck),
        *_chatter_alerts(solution, crosscheck),
        *_motion_alerts(solution),
        *_accuracy_alerts(solution),
        *_design_alerts(solution),
        *_conditioning_alerts(solution),
        *_energy_alerts(solution),
        *_contact_alerts(solution, compliance),
    ]
    return tuple(sorted(found, key=lambda alert: (alert.severity != "warning", alert.code)))


def _motion_alerts(solution: Solution) -> Iterator[Alert]:
    if solution.diagram is None:
        return
    if not solution.stable_ranges:
        yield _alert(
            "VR001",
            "Nowhere in the sweep is there an admissible 1:1 motion that attracts the motions nearby.",
        )
    discarded = [(part, branch) for branch in solution.branches for part in branch.segments() if not part.admissible]
    if discarded:
        depth = -min(float(branch.motions.wall_gap[part.first : part.last + 1].min()) for part, branch in discarded)
        stable = any(part.stability.attracts for part, _ in discarded)
        yield _alert(
            "VR002",
            f"{_count(len(discarded))} of the algebraic solution would pass through a membrane, by up to {depth:.3g} "
            f"of the length unit x_c{', some with eigenvalues that would call them stable' if stable else ''}. "
            "They are listed in the results as not admissible, and neither drawn nor counted.",
        )


def _simulation_alerts(check: CrossCheck | None) -> Iterator[Alert]:
    if check is None:
        return
    if not check.passed:
        yield _alert(
            "VR020",
            f"Of {check.orbits} stable orbits the simulation left {len(check.misses)}; on the others the difference "
            f"reaches {max(check.velocity_difference, check.phase_difference):.2g} (tolerance {check.tolerance:.2g}).",
        )
    others = {word: count for word, count in check.words.items() if word != "BT"}
    if others and check.trials and check.reached < check.trials:
        names = ", ".join(list(others)[:3])
        yield _alert(
            "VR021",
            f"{check.trials - check.reached} of {check.trials} starts where a stable 1:1 motion exists end elsewhere "
            f"({names}).",
        )


def _chatter_alerts(solution: Solution, check: CrossCheck | None) -> Iterator[Alert]:
    if check is not None:
        held = sum(count for word, count in check.words.items() if "~" in word or "at rest" in word)
        if held:
            yield _alert("VR022", f"{held} of {sum(check.words.values())} simulated starts end in chatter or at rest.")
            return
    device, sweep = solution.device, solution.sweep
    if sweep is not None:
        ends = [device.groups(sweep.parameter, x)[1] for x in (sweep.start, sweep.end)]
    else:
        ends = [device.groups(Parameter.LENGTH, device.length_m)[1]]
    if max(ends) >= 1:
        yield _alert("VR022", f"gbar reaches {max(ends):.3g}: a ball at rest on the bottom membrane stays there.")


def _count(stretches: int) -> str:
    return "One stretch" if stretches == 1 else f"{stretches} stretches"


def _accuracy_alerts(solution: Solution) -> Iterator[Alert]:
    rough = [c for c in solution.critical_points if c.point.error_bound > ROUGH * abs(c.point.sweep_value)]
    if rough:
        yield _alert(
            "VR006",
            f"{', '.join(c.label for c in rough)}: so nearly degenerate that it was bracketed, not polished; the error "
            "bound says how well.",
        )


def _design_alerts(solution: Solution) -> Iterator[Alert]:
    design = solution.design
    if design is None:
        return
    count = int(design.motions.stable.sum())
    if not count:
        yield _alert(
            "VR003",
            f"At {design.parameter} = {design.value:.6g} there are {len(design.motions)} solutions, none of them "
            "admissible and stable.",
        )
    elif count > 1 and not (design.families.count(Family.ASYMMETRIC) == 2 and count == 2 and solution.horizontal):
        yield _alert(
            "VR004",
            f"{count} stable 1:1 motions exist there; which one is reached depends on the start.",
        )
    near = [
        m for m in design.margins if m.ends_stability and m.relative is not None and abs(m.relative) < NEAR_CRITICAL
    ]
    if near:
        nearest = near[0]
        yield _alert(
            "VR005",
            f"{nearest.label} ({nearest.kind.replace('_', ' ')}) is {100 * (nearest.relative or 0):+.2f} % away in "
            f"{nearest.parameter}.",
        )


def _conditioning_alerts(solution: Solution) -> Iterator[Alert]:
    """Where digits of the design point, or the motion itself, hang on little."""
    if solution.design is None:
        return
    m = solution.design.motions
    close = m.stable & (m.wall_gap < m.d) & (m.wall_gap < NEAR_CRITICAL * m.d)
    if close.any():
        gap = float(np.min((m.wall_gap / m.d)[close]))
        yield _alert("VR007", f"The ball turns {100 * gap:.2g} % of the length from a membrane without touching it.")
    worst = float(np.max(input_error(solution.device, m)[m.admissible], initial=0.0))
    if worst > ILL_CONDITIONED:
        yield _alert(
            "VR008", f"A single rounding of the length or the inclination moves q or the phase by {worst:.1g}."
        )
    effect = restitution_effect(solution.device, m)
    if effect is not None and effect.lost_at is not None:
        yield _alert("VR009", f"At a restitution of {effect.lost_at:.4g} a stable motion of the design point is lost.")
    elif effect is not None and effect.elasticity > SENSITIVE:
        yield _alert("VR009", f"1 % of restitution changes the impact velocity by {effect.elasticity:.2g} %.")


def _contact_alerts(solution: Solution, compliance: Compliance | None) -> Iterator[Alert]:
    """What the ball's mass and the membrane's stiffness do to the rigid model and its voltage."""
    membrane, r = solution.membrane, solution.device.restitution
    speeds = _speeds(solution)
    if membrane is None or not speeds:
        return
    bottom, top, frequency = (np.concatenate(column) for column in zip(*speeds, strict=True))
    longest = contact_share(np.minimum(bottom, -top), membrane, r, frequency) or 0.0
    if longest > LONG_CONTACT:
        yield _alert(
            "VR011",
            f"A contact takes some {100 * longest:.2g} % of the forcing period with the membrane's own stiffness, "
            "by an estimate without gravity and forcing.",
        )
    elasticity = mass_elasticity(bottom, top, membrane)
    if elasticity > HEAVY:
        yield _alert("VR012", f"1 % of ball mass changes U_ave by up to {elasticity:.2g} %.")
    if compliance is not None and compliance.grade == 2:
        yield _alert("VR013", _beyond_rigid(compliance))


def _beyond_rigid(made: Compliance) -> str:
    """What the membrane's own stiffness does to the rigid model where that is not good enough."""
    label = made.critical.label if made.critical is not None else "the critical point"
    told = [
        f"{c.name} by {abs(c.shift):.2g} times the margin to it"
        if c.name == label
        else f"{c.name} by {100 * c.shift:+.2g} %"
        for c in made.criteria
        if c.grade == 2
    ]
    if told:
        return f"The membrane's own stiffness moves {', '.join(told)}."
    own = made.own
    followed = own is not None and own.orbit is not None and own.orbit.stable
    return f"With the membrane's own stiffness {label if followed else 'the stable motion'} is lost."


def _speeds(solution: Solution) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Impact velocities [m/s] and frequencies [Hz] of the stable motions, at the design point where there is one."""
    if solution.design is not None:
        sets, parameter = [solution.design.motions], solution.design.parameter
    else:
        sets, parameter = [branch.motions for branch in solution.branches], solution.parameter
    found = []
    for m in sets:
        value = m.sweep_value[m.stable]
        if value.size:
            bottom, top = (velocity[m.stable] for velocity in impact_velocities(solution.device, parameter, m))
            frequency = np.asarray(solution.device.at(parameter, value)[Parameter.FREQUENCY]) * np.ones(value.size)
            found.append((bottom, top, frequency))
    return found


def _energy_alerts(solution: Solution) -> Iterator[Alert]:
    membrane = solution.membrane
    if membrane is None:
        return
    depth, volts = solution.deepest_m, solution.highest_v
    radius = membrane.active_radius_m
    if depth > radius:
        yield _alert(
            "VR010",
            f"The impacts press the membrane up to {1e3 * depth:.3g} mm deep, {depth / radius:.2g} times its active "
            f"radius of {1e3 * radius:.3g} mm. "
            f"The formulae still evaluate, to {volts:.3g} V above a bias of {membrane.bias_voltage_v:.4g} V, but "
            "the cone-and-cap shape of Eqs. (5.3)-(5.5) "
            "cannot hold there: read the voltages as a ranking, not as volts.",
        )
