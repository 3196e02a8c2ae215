"""The problems of the accuracy study: a motion and a critical point of the scenario, their 40 digits, and the guess.

Turns a solution into the targets that every method is given, and the answers of methods into errors.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import ResultsBlock, brief
from vireport.design.point import DesignPoint, around_length
from vireport.design.solution import Solution, stable_motion
from vireport.findings.accuracy.flights import FlightModel
from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.one_to_one import Motions
from vireport.motions.points import Point
from vireport.motions.stability import lap_decay
from vireport.motions.sweep import Sweep
from vireport.physics.energy import Membrane, voltages
from vireport.physics.groups import Groups, map_restitution
from vireport.physics.motion import Symmetry
from vireport.physics.numbers import wrapped

if TYPE_CHECKING:
    from vireport.study.checks.reference import ReferenceOrbit

PHASE_OFF, Q_OFF = 6e-3, 3e-3
"""Error of the guess of the phase [rad] and of q against the reference."""

VELOCITY_OFF, VALUE_OFF = 4e-3, -3e-3
"""Relative error of the guess of the velocity and of the swept value against the reference."""

NEAREST = 0.2
"""Share of the distance to the next motion at the same parameters by which the guess is off at the most: beyond,
methods would rightly go there."""

KINDS = (Event.PERIOD_DOUBLING,), (Event.PITCHFORK, Event.FOLD)
"""Kinds of critical points that are taken, the first that there is."""

SHOWN = 20
"""Digits of a reference that are kept as text."""


class MethodTask(StrEnum):
    """The problems that every method has to solve."""

    ORBIT = "orbit"
    CRITICAL = "critical"


class Guess(Struct, frozen=True):
    """Where every method begins: phase [rad] and velocity [y_c] at the bottom impact, q, and the swept value.

    The swept value is exact for a motion, and a guess for a critical point.
    """

    phase: float
    velocity: float
    q: float
    value: float


class BenchmarkProblem(Struct, frozen=True):
    """A motion or a critical point to be found along a sweep.

    Attributes
    ----------
    sweep : Sweep
        With a device that has all its parameters.
    swept : bool
        Whether the scenario has this sweep; otherwise it is one through its design point.
    kind : Event or None
        Of the critical point (a period doubling, fold or pitchfork); None for a motion.
    symmetric : bool
        Whether it is a symmetric motion of a horizontal capsule.
    guess : Guess
    """

    sweep: Sweep
    swept: bool
    kind: Event | None
    symmetric: bool
    guess: Guess

    __repr__ = brief

    @property
    def r(self) -> Any:
        """Restitution of both membranes, or the `Restitutions` of each."""
        return map_restitution(self.sweep.device.restitution, float)

    @property
    def n(self) -> int:
        """Forcing periods of the motion."""
        return self.sweep.device.period_ratio

    @property
    def trace(self) -> float:
        """Trace of DP at the critical point. Raises ValueError where the problem is a motion."""
        if self.kind is None:
            raise ValueError("a motion that is no critical point has no trace that is known beforehand")
        return float(TRACE_LEVELS[self.kind](lap_decay(self.r)))

    def groups(self, value: float) -> Groups[float]:
        """The groups at a value of the swept parameter."""
        return self.sweep.device.groups(self.sweep.parameter, value).as_floats()

    def model(self, value: float) -> FlightModel:
        """The dimensionless model at a value of the swept parameter."""
        return FlightModel(self.groups(value), self.n)


class SolvedMotion(Struct, frozen=True):
    """A motion that a method found: phase [rad] and velocity [y_c] at the bottom, velocity at the top, share q."""

    phase: float
    velocity: float
    velocity_top: float
    q: float


class MeasuredQuantity(ResultsBlock, frozen=True):
    """A number that the methods are to find.

    Attributes
    ----------
    key
        `velocity`, `phase`, `voltage` or `critical`
    task
        what has to be solved for it, `orbit` (the motion) or `critical` (the critical point)
    reference : F π/(M ω), rad, V, or as in the scenario
        its first 20 digits, as text
    relative
        whether errors are relative; those of the phase are in rad
    """

    key: str
    task: MethodTask
    reference: str
    relative: bool


class Benchmark(Struct, frozen=True, eq=False):
    """What the methods are to find, and the exact answers.

    Attributes
    ----------
    motion, critical : BenchmarkProblem
        `critical` is None where there is no critical point.
    exact : dict
        40-digit numbers by the key of the quantity.
    offset : float
        Offset of the guess, as a share of `PHASE_OFF` and the like.
    """

    motion: BenchmarkProblem
    critical: BenchmarkProblem | None
    point: Point | None
    membrane: Membrane | None
    quantities: tuple[MeasuredQuantity, ...]
    exact: dict[str, Any]
    offset: float

    __repr__ = brief

    @property
    def value(self) -> float:
        """The swept parameter, where the motion is."""
        return self.motion.guess.value

    @property
    def guess_errors(self) -> tuple[float, float, float]:
        """Errors of the guess: of the phase [rad], and relative ones of velocity and critical value."""
        return self.offset * PHASE_OFF, self.offset * VELOCITY_OFF, self.offset * VALUE_OFF

    def errors(self, answer: SolvedMotion | float) -> dict[str, float]:
        """Errors of what a method found, by the key of the quantity."""
        if not isinstance(answer, SolvedMotion):
            return {"critical": _relative(answer, self.exact["critical"])}
        turned = float(answer.phase - self.exact["phase"])
        result = {
            "velocity": _relative(answer.velocity, self.exact["velocity"]),
            # Turns are taken off the difference, which has few digits to lose.
            "phase": abs(turned - 2 * np.pi * round(turned / (2 * np.pi))),
        }
        if self.membrane is not None:
            sweep = self.motion.sweep
            unit = sweep.device.velocity_unit(sweep.parameter, self.value)
            bottom, top = np.array(unit * answer.velocity), np.array(unit * answer.velocity_top)
            volts = float(voltages(bottom, top, self.membrane).average_v)
            result["voltage"] = _relative(volts, self.exact["voltage"])
        return result


def benchmark_of(solution: Solution) -> Benchmark | None:
    """Choose the motion and the critical point of a solution, and compute both to 40 digits.

    The motion is the stable admissible one at the design point, or else in the middle of the first stable range of the
    sweep; None where there is neither. The critical point is the first period doubling of the sweep, or else the
    first fold or pitchfork.

    Raises
    ------
    NumericalError
        If a reference does not settle.
    """
    chosen = stable_motion(solution)
    if chosen is None:
        return None
    from vireport.study.checks.reference import digits, reference_orbit, reference_voltage

    design, row = chosen
    sweep, motions = _sweep_through(solution, design), design.motions
    device, parameter, swept = sweep.device, sweep.parameter, solution.sweep is not None
    guess = [float(array[row]) for array in (motions.velocity_bottom, motions.phi_bottom, motions.q)]
    orbit = reference_orbit(device, parameter, [*guess, design.value])
    symmetric = design.families[row] is Symmetry.SYMMETRIC
    offset = min(1.0, NEAREST * _distance_to_next(motions, row) / PHASE_OFF)
    motion = BenchmarkProblem(
        sweep, swept, None, symmetric, replace(_aside(orbit, symmetric, offset), value=design.value)
    )
    exact: dict[str, Any] = {"velocity": orbit.velocity, "phase": orbit.phase}
    if solution.membrane is not None:
        exact["voltage"] = reference_voltage(orbit, solution.membrane)
    point = next((point for kinds in KINDS for point in solution.critical_points if point.event in kinds), None)
    critical = None
    if point is not None:
        p, symmetric = point.closed, point.symmetry is Symmetry.SYMMETRIC
        guess = [p.velocity_bottom, p.phi_bottom, 0.5 + p.u, point.sweep_value]
        orbit = reference_orbit(device, parameter, guess, point.event)
        critical = BenchmarkProblem(sweep, swept, point.event, symmetric, _aside(orbit, symmetric, offset))
        exact["critical"] = orbit.value
    quantities = tuple(
        MeasuredQuantity(
            key, MethodTask.CRITICAL if key == "critical" else MethodTask.ORBIT, digits(number, SHOWN), key != "phase"
        )
        for key, number in exact.items()
    )
    return Benchmark(motion, critical, point, solution.membrane, quantities, exact, offset)


def _sweep_through(solution: Solution, design: DesignPoint) -> Sweep:
    """The solution's sweep, or one over the length through a design point, with a device that has all parameters."""
    device = solution.device.of_sine("error against run time").with_values({design.parameter: design.value})
    if solution.sweep is not None:
        return replace(solution.sweep.driven("error against run time"), device=device)
    return around_length(device)


def _distance_to_next(motions: Motions, row: int) -> float:
    """Distance of a motion to the nearest other one, in phase [rad] and velocity [y_c]."""
    turned = wrapped(motions.phi_bottom - motions.phi_bottom[row])
    distance = np.maximum(np.abs(turned), np.abs(motions.velocity_bottom - motions.velocity_bottom[row]))
    return float(np.min(np.delete(distance, row), initial=np.inf))


def _aside(orbit: ReferenceOrbit, symmetric: bool, offset: float) -> Guess:
    """A guess from the reference motion, wrong in its second or third digit where `offset` is 1."""
    return Guess(
        phase=float(orbit.phase) + offset * PHASE_OFF,
        velocity=float(orbit.velocity) * (1 + offset * VELOCITY_OFF),
        q=0.5 if symmetric else float(orbit.q) + offset * Q_OFF,
        value=float(orbit.value) * (1 + offset * VALUE_OFF),
    )


def _relative(number: float, exact: Any) -> float:
    """Relative error, formed in the digits of the exact number."""
    return float(abs((number - exact) / exact)) if exact else abs(number)
