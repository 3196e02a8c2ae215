"""The error bounds of a study's numbers, gathered: for each branch, for the design point, for ranges and margins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vireport.analysis.bounds import Floats, motion_bounds, voltage_bounds
from vireport.analysis.branches import Branch
from vireport.analysis.design import DesignPoint
from vireport.analysis.diagram import BifurcationDiagram
from vireport.analysis.motions import Motions
from vireport.analysis.sweep import Sweep
from vireport.physics import Device, Membrane
from vireport.scenario import Parameter

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


def bounds_of(
    device: Device, membrane: Membrane | None, diagram: BifurcationDiagram | None, design: DesignPoint | None
) -> Bounds:
    """Bound the errors of every motion and voltage along a sweep and at a design point."""
    branches = diagram.branches if diagram is not None else ()
    along = tuple(_along(device, membrane, diagram.sweep, branch) for branch in branches) if diagram is not None else ()
    if design is None:
        return Bounds(along, None)
    length = device.length_m
    around = Sweep(device, Parameter.LENGTH, length / 2, length * 2)
    at = _of(device, membrane, around, design.motions, design.errors)
    at["sweep_value"] = np.zeros(len(design.motions))
    return Bounds(along, at)


def _along(device: Device, membrane: Membrane | None, sweep: Sweep, branch: Branch) -> dict[str, Floats]:
    """Bounds of a branch; at its critical points at least those of the points, which may only have been bracketed."""
    found = _of(device, membrane, sweep, branch.motions, None)
    for row in range(len(branch.motions)):
        critical = branch.critical_point(row)
        if critical is None:
            continue
        bounds = {**critical.point.bounds, "sweep_value": critical.point.error_bound}
        for name in ("sweep_value", "d", "gbar", "velocity_bottom", "velocity_top"):
            found[name][row] = max(found[name][row], bounds[name])
        found["q"][row] = max(found["q"][row], bounds["u"])
        found["phi_bottom"][row] = max(found["phi_bottom"][row], bounds["phi"])
    return found


def _of(
    device: Device, membrane: Membrane | None, sweep: Sweep, motions: Motions, given: tuple[Floats, Floats] | None
) -> dict[str, Floats]:
    found = motion_bounds(sweep, motions, given)
    if membrane is None:
        return found
    value = motions.sweep_value if given is None else device.length_m
    unit = np.asarray(device.velocity_unit(sweep.parameter, value)) * np.ones(len(motions))
    velocities = motions.velocity_bottom, motions.velocity_top
    errors = found["velocity_bottom"], found["velocity_top"]
    return {**found, **voltage_bounds(velocities, errors, unit, membrane)}


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
