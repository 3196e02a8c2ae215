"""What a reader must know before acting on the numbers: alerts with a code, a cause with its numbers, and a remedy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from vireport.study import Study

NEAR_CRITICAL = 0.02
"""Share of the design value within which a critical point is near: what masses and lengths are commonly made to."""


ROUGH = 1e-12
"""Relative error bound above which a critical point is called rough."""


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


def alerts(study: Study) -> tuple[Alert, ...]:
    """Collect the alerts of a study, warnings first."""
    found = [
        *_simulation_alerts(study),
        *_motion_alerts(study),
        *_accuracy_alerts(study),
        *_design_alerts(study),
        *_energy_alerts(study),
    ]
    return tuple(sorted(found, key=lambda alert: (alert.severity != "warning", alert.code)))


def _motion_alerts(study: Study) -> Iterator[Alert]:
    if study.solution is None:
        return
    if not study.stable_ranges:
        yield Alert(
            "VR001",
            "warning",
            "No stable 1:1 motion",
            "Nowhere in the sweep is there an admissible 1:1 motion that attracts the motions nearby.",
            "Widen the sweep, or change length, force, frequency or inclination.",
        )
    discarded = [
        (part, branch) for branch in study.solution.branches for part in branch.segments() if not part.admissible
    ]
    if discarded:
        depth = -min(float(branch.motions.wall_gap[part.first : part.last + 1].min()) for part, branch in discarded)
        stable = any(part.stability.startswith("stable") for part, _ in discarded)
        yield Alert(
            "VR002",
            "note",
            "Solutions that are not motions were left out",
            f"{_count(len(discarded))} of the algebraic solution would pass through a membrane, by up to {depth:.3g} "
            f"of the length unit x_c{', some with eigenvalues that would call them stable' if stable else ''}. "
            "They are listed in the results as not admissible, and neither drawn nor counted.",
            "Nothing to do; the grazing points show where the motions end.",
        )


def _simulation_alerts(study: Study) -> Iterator[Alert]:
    check = study.crosscheck
    if check is None:
        return
    if not check.passed:
        yield Alert(
            "VR020",
            "warning",
            "Simulation and solution do not agree",
            f"Of {check.orbits} stable orbits the simulation left {len(check.misses)}; on the others the difference "
            f"reaches {max(check.velocity_difference, check.phase_difference):.2g} (tolerance {check.tolerance:.2g}).",
            "Do not act on the verdict. Look where the differences are; near a critical point widen the tolerance, and "
            "report anything else.",
        )
    others = {word: count for word, count in check.words.items() if word != "BT"}
    if others and check.trials and check.reached < check.trials:
        names = ", ".join(list(others)[:3])
        yield Alert(
            "VR021",
            "note",
            "Other motions coexist with the stable 1:1 motion",
            f"{check.trials - check.reached} of {check.trials} starts where a stable 1:1 motion exists end elsewhere "
            f"({names}).",
            "See that the device is started within reach of the 1:1 motion.",
        )


def _count(stretches: int) -> str:
    return "One stretch" if stretches == 1 else f"{stretches} stretches"


def _accuracy_alerts(study: Study) -> Iterator[Alert]:
    points = study.solution.critical_points if study.solution else ()
    rough = [c for c in points if c.point.error_bound > ROUGH * abs(c.point.sweep_value)]
    if rough:
        yield Alert(
            "VR006",
            "warning",
            "A critical point is known only roughly",
            f"{', '.join(c.label for c in rough)}: so nearly degenerate that it was bracketed, not polished; the error "
            "bound says how well.",
            "Use it only as far as its error bound allows.",
        )


def _design_alerts(study: Study) -> Iterator[Alert]:
    design = study.design
    if design is None:
        return
    count = int(design.motions.stable.sum())
    if not count:
        yield Alert(
            "VR003",
            "warning",
            "The design point has no stable 1:1 motion",
            f"At {design.parameter} = {design.value:.6g} there are {len(design.motions)} solutions, none of them "
            "admissible and stable.",
            "Move the design point into a stable range.",
        )
    elif count > 1 and not (design.families.count("asymmetric") == 2 and count == 2 and study.horizontal):
        yield Alert(
            "VR004",
            "note",
            "Several stable motions coexist at the design point",
            f"{count} stable 1:1 motions exist there; which one is reached depends on the start.",
            "Check the start, or move to where there is one.",
        )
    near = [
        m for m in design.margins if m.ends_stability and m.relative is not None and abs(m.relative) < NEAR_CRITICAL
    ]
    if near:
        nearest = near[0]
        yield Alert(
            "VR005",
            "warning",
            "The design point is near the end of stable motion",
            f"{nearest.label} ({nearest.kind.replace('_', ' ')}) is {100 * (nearest.relative or 0):+.2f} % away in "
            f"{nearest.parameter}.",
            "Keep a larger margin: manufacturing tolerances and the unknown restitution may carry the device across.",
        )


def _energy_alerts(study: Study) -> Iterator[Alert]:
    if study.membrane is None:
        return
    radius = study.membrane.active_radius_m
    depth, volts = 0.0, 0.0
    for branch, voltage in zip(study.solution.branches if study.solution else (), study.voltages, strict=False):
        inside = branch.motions.admissible
        depth = max(depth, float(np.max(voltage.deflection_m, where=inside, initial=0.0)))
        volts = max(volts, float(np.max(np.maximum(voltage.bottom_v, voltage.top_v), where=inside, initial=0.0)))
    if study.design is not None and study.design_voltages is not None and len(study.design.motions):
        depth = max(depth, float(study.design_voltages.deflection_m.max()))
        volts = max(volts, float(np.maximum(study.design_voltages.bottom_v, study.design_voltages.top_v).max()))
    if depth > radius:
        yield Alert(
            "VR010",
            "warning",
            "The membrane model is outside its geometry",
            f"The impacts press the membrane up to {1e3 * depth:.3g} mm deep, {depth / radius:.2g} times its active "
            f"radius of {1e3 * radius:.3g} mm. "
            f"The formulae still evaluate, to {volts:.3g} V above a bias of {study.membrane.bias_voltage_v:.4g} V, but "
            "the cone-and-cap shape of Eqs. (5.3)-(5.5) "
            "cannot hold there: read the voltages as a ranking, not as volts.",
            "Use a lighter ball, a stiffer or larger membrane, or gentler forcing; or measure the membrane's force law "
            "at such depths.",
        )
