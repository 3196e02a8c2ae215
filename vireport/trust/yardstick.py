"""What the accuracy study measures on: a motion and a critical point of the scenario, their 40 digits, and the guess.

Turns a study into the tasks that every method is given and into the errors of what it finds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vireport.analysis import (
    CriticalKind,
    CriticalPoint,
    DesignPoint,
    Family,
    Motions,
    Solution,
    Sweep,
    design_point,
)
from vireport.physics import voltages
from vireport.trust.closedform import Guess, Wanted
from vireport.trust.contenders import device_at
from vireport.trust.methods import Found

if TYPE_CHECKING:
    from vireport.reference import ReferenceOrbit

PHASE_OFF, Q_OFF = 6e-3, 3e-3
"""By how much the guess of the phase [rad] and of q is off the reference."""

VELOCITY_OFF, VALUE_OFF = 4e-3, -3e-3
"""By which share the guess of the velocity and of the swept value is off the reference."""

NEAREST = 0.2
"""Share of the distance to the next motion at the same parameters by which the guess is off at the most: beyond,
methods would rightly go there."""

KINDS = (CriticalKind.PERIOD_DOUBLING,), (CriticalKind.PITCHFORK, CriticalKind.FOLD)
"""Kinds of critical points that are taken, the first that there is."""

SHOWN = 20
"""Digits of a reference that are kept as text."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number that the methods are to find.

    Attributes
    ----------
    key : str
        ``velocity``, ``phase``, ``voltage`` or ``critical``.
    task : str
        ``orbit`` or ``critical``: what has to be solved for it.
    reference : str
        Its value to `SHOWN` digits: y_c, rad, V, or the unit of the swept parameter.
    relative : bool
        Whether errors are relative; those of the phase are in rad.
    """

    key: str
    task: str
    reference: str
    relative: bool


@dataclass(frozen=True, slots=True, eq=False)
class Yardstick:
    """The tasks, and the truth they are measured against.

    Attributes
    ----------
    value : float
        Of the swept parameter, where the motion is.
    orbit : Wanted
        The motion, and the guess.
    critical : Wanted or None
    point : CriticalPoint or None
    quantities : tuple of Quantity
    truth : dict
        40-digit numbers by the key of the quantity.
    off : float
        Share of `PHASE_OFF` and the others by which the guess is off.
    solution : Solution
    """

    value: float
    orbit: Wanted
    critical: Wanted | None
    point: CriticalPoint | None
    quantities: tuple[Quantity, ...]
    truth: dict[str, Any]
    off: float
    solution: Solution

    def errors(self, found: Found | float) -> dict[str, float]:
        """Errors of what a method found, by the key of the quantity."""
        truth = self.truth
        if not isinstance(found, Found):
            return {"critical": _relative(found, truth["critical"])}
        turned = float(found.phase - truth["phase"])
        result = {
            "velocity": _relative(found.velocity, truth["velocity"]),
            # Turns are taken off the difference, which has few digits to lose.
            "phase": abs(turned - 2 * np.pi * round(turned / (2 * np.pi))),
        }
        membrane = self.solution.membrane
        if "voltage" in truth and membrane is not None:
            sweep = self.orbit.sweep
            unit = sweep.device.velocity_unit(sweep.parameter, self.value)
            bottom, top = np.array(unit * found.velocity), np.array(unit * found.velocity_top)
            result["voltage"] = _relative(float(voltages(bottom, top, membrane).average_v), truth["voltage"])
        return result


def yardstick(solution: Solution) -> Yardstick | None:
    """Choose the motion and the critical point of a solution, and compute both to 40 digits.

    The motion is the stable admissible one at the design point, or else in the middle of the first stable range of the
    sweep; None where there is neither. The critical point is the first period doubling of the sweep, or else the
    first fold or pitchfork.

    Raises
    ------
    NumericalError
        If mpmath is missing, or a reference does not settle.
    """
    chosen = _chosen(solution)
    if chosen is None:
        return None
    from vireport.reference import digits, reference_critical, reference_orbit, reference_voltage

    design, row = chosen
    sweep, motions = _sweep_through(solution, design), design.motions
    exact = reference_orbit(
        sweep.device,
        sweep.parameter,
        design.value,
        (float(motions.velocity_bottom[row]), float(motions.phi_bottom[row]), float(motions.q[row])),
    )
    symmetric = design.families[row] is Family.SYMMETRIC
    off = min(1.0, NEAREST * _alone(motions, row) / PHASE_OFF)
    orbit = Wanted(sweep, "orbit", symmetric, replace(_aside(exact, symmetric, off), value=design.value))
    truth: dict[str, Any] = {"velocity": exact.velocity, "phase": exact.phase}
    if solution.membrane is not None:
        truth["voltage"] = reference_voltage(exact, solution.membrane)
    point, critical = _critical_point(solution), None
    if point is not None:
        p, line = point.point, point.family is Family.SYMMETRIC
        there = reference_critical(
            sweep.device, sweep.parameter, point.kind, (p.velocity_bottom, p.phi, 0.5 + p.u, p.sweep_value)
        )
        critical, truth["critical"] = Wanted(sweep, point.kind, line, _aside(there, line, off)), there.value
    quantities = tuple(
        Quantity(key, "critical" if key == "critical" else "orbit", digits(number, SHOWN), key != "phase")
        for key, number in truth.items()
    )
    return Yardstick(design.value, orbit, critical, point, quantities, truth, off, solution)


def _chosen(solution: Solution) -> tuple[DesignPoint, int] | None:
    """A design point, and the row of its stable motion."""
    design = solution.design
    if (design is None or not design.motions.stable.any()) and solution.stable_ranges:
        part = solution.stable_ranges[0]
        device = device_at(solution.device, part.parameter, (part.start + part.end) / 2)
        design = design_point(device, solution.diagram)
    if design is None or not design.motions.stable.any():
        return None
    return design, int(np.argmax(design.motions.stable))


def _sweep_through(solution: Solution, design: DesignPoint) -> Sweep:
    """The solution's sweep, or one over the length through a design point, with a device that has all parameters."""
    device = device_at(solution.device, design.parameter, design.value)
    if solution.sweep is not None:
        return replace(solution.sweep, device=device)
    return Sweep(device, design.parameter, design.value / 2, design.value * 2)


def _critical_point(solution: Solution) -> CriticalPoint | None:
    return next((point for kinds in KINDS for point in solution.critical_points if point.kind in kinds), None)


def _alone(motions: Motions, row: int) -> float:
    """Distance of a motion to the nearest other one, in phase [rad] and velocity [y_c]."""
    turned = (motions.phi_bottom - motions.phi_bottom[row] + np.pi) % (2 * np.pi) - np.pi
    distance = np.maximum(np.abs(turned), np.abs(motions.velocity_bottom - motions.velocity_bottom[row]))
    return float(np.min(np.delete(distance, row), initial=np.inf))


def _aside(orbit: ReferenceOrbit, symmetric: bool, off: float) -> Guess:
    """The reference, wrong in its second or third digit where `off` is 1."""
    return Guess(
        phase=float(orbit.phase) + off * PHASE_OFF,
        velocity=float(orbit.velocity) * (1 + off * VELOCITY_OFF),
        q=0.5 if symmetric else float(orbit.q) + off * Q_OFF,
        value=float(orbit.value) * (1 + off * VALUE_OFF),
    )


def _relative(found: float, truth: Any) -> float:
    """Relative error, formed in the digits of the truth."""
    return float(abs((found - truth) / truth)) if truth else abs(found)
