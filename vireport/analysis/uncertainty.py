"""The error bounds of a study's numbers, gathered: for each branch, for the design point, for ranges and margins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vireport.analysis.bounds import Floats, motion_bounds, voltage_bounds
from vireport.analysis.branches import Branch
from vireport.analysis.motions import Motions
from vireport.physics.device import Sweep

if TYPE_CHECKING:
    from vireport.study.study import Study

NO_BOUND = "diverges, or loses all its digits, where an impact has no velocity or two branches meet"
"""Why there is no bound."""


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """Error bounds, by the names of `Motions` and `energy.Voltages`; infinite where there is none.

    Attributes
    ----------
    branches : tuple of dict
        For each branch an array for each of its columns.
    design : dict or None
        For the motions at the design point.
    """

    branches: tuple[dict[str, Floats], ...]
    design: dict[str, Floats] | None


def bounds_of(study: Study) -> Bounds:
    """Bound the errors of every motion and voltage of a study."""
    branches = study.solution.branches if study.solution else ()
    sweep, design = study.sweep, study.design
    along = () if sweep is None else tuple(_along(study, sweep, branch) for branch in branches)
    if design is None:
        return Bounds(along, None)
    length = study.device.length_m
    around = Sweep(study.device, "length_m", length / 2, length * 2)
    at = _of(study, around, design.motions, design.errors)
    at["sweep_value"] = np.zeros(len(design.motions))
    return Bounds(along, at)


def _along(study: Study, sweep: Sweep, branch: Branch) -> dict[str, Floats]:
    """Bounds of a branch; at its critical points at least those of the points, which may only have been bracketed."""
    found = _of(study, sweep, branch.motions, None)
    points = {c.label: c.point for c in study.solution.critical_points} if study.solution else {}
    for row, label in enumerate(branch.event):
        if label in points:
            bounds = {**points[label].bounds, "sweep_value": points[label].error_bound}
            for name in ("sweep_value", "d", "gbar", "velocity_bottom", "velocity_top"):
                found[name][row] = max(found[name][row], bounds[name])
            found["q"][row] = max(found["q"][row], bounds["u"])
            found["phi_bottom"][row] = max(found["phi_bottom"][row], bounds["phi"])
    return found


def _of(study: Study, sweep: Sweep, motions: Motions, given: tuple[Floats, Floats] | None) -> dict[str, Floats]:
    found = motion_bounds(sweep, motions, given)
    mass = study.scenario.device.ball_mass_kg
    if study.membrane is None or mass is None:
        return found
    value = motions.sweep_value if given is None else study.device.length_m
    unit = np.asarray(study.device.velocity_unit(sweep.parameter, value)) * np.ones(len(motions))
    velocities = motions.velocity_bottom, motions.velocity_top
    errors = found["velocity_bottom"], found["velocity_top"]
    return {**found, **voltage_bounds(velocities, errors, unit, mass, study.membrane)}


def shown(bound: Floats) -> list[list[float | None]]:
    """Rows of bounds as they are written: rounded up to two digits, None where there is none."""
    usable = np.isfinite(bound) & (bound > 0)
    safe = np.where(usable, bound, 1.0)
    power = 1 - np.floor(np.log10(safe))
    # A quotient by an exact power of ten is the double nearest to the two digits, and is written as such.
    up = np.where(power > 0, 10.0 ** np.clip(power, 0, 300), 1.0)
    down = np.where(power < 0, 10.0 ** np.clip(-power, 0, 300), 1.0)
    rounded = np.ceil(safe * up / down * (1 + 1e-12)) / up * down
    written = np.where(usable & (safe > 1e-290), rounded, bound)
    if np.isfinite(written).all():
        return list(written.tolist())
    return [[x if x < np.inf else None for x in row] for row in written.tolist()]
