"""What compliant membranes change against rigid impacts: the numbers side by side, rates, and whether it matters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import CriticalPoint
from vireport.physics import (
    Contact,
    Membrane,
    deflection,
    generated_voltage,
)
from vireport.scenario import Parameter
from vireport.trust.compliant_orbits import CompliantOrbit
from vireport.trust.penalty import SolverRun

Floats = NDArray[np.float64]

GRADES = ("good enough", "to be used with care", "not good enough")
"""Answers, by the grade of a criterion."""

FITTED = 3
"""Rungs, the stiffest, from which a rate of convergence is taken: the softer ones still have terms of higher order."""

FLOOR = 1e-8
"""Relative distance from the rigid model below which rounding and differences would have a part in a rate."""

GOOD_SPEED, FAIR_SPEED = 0.01, 0.05
"""Relative shift of an impact velocity: what a careful experiment resolves, and what any does."""

GOOD_VOLTAGE, FAIR_VOLTAGE = 0.05, 0.2
"""Relative shift of U_ave, which grows with a high power of the velocity."""

GOOD_MARGIN, FAIR_MARGIN = 0.1, 0.5
"""Shift of the critical point over the design point's distance from it."""


@dataclass(frozen=True, slots=True)
class Rigid:
    """The motion with rigid impacts that is followed.

    Attributes
    ----------
    parameter, value : str, float
        Where it is.
    chosen : str
        Why this one, in words.
    velocity_bottom, velocity_top, phase_bottom, phase_top : float
        As in `Motions`.
    """

    parameter: Parameter
    value: float
    chosen: str
    velocity_bottom: float
    velocity_top: float
    phase_bottom: float
    phase_top: float


@dataclass(frozen=True, slots=True)
class Rung:
    """The compliant model at one stiffness.

    Attributes
    ----------
    factor : float
        Times K.
    orbit : CompliantOrbit or None
        None where the motion is lost.
    critical_value : float or None
        Of the varied parameter at the critical point that is followed.
    reason : str
        Why something is None, or "".
    """

    factor: float
    orbit: CompliantOrbit | None
    critical_value: float | None
    reason: str


@dataclass(frozen=True, slots=True)
class Convergence:
    """How one quantity approaches its rigid value.

    Attributes
    ----------
    quantity : str
        ``velocity``, ``phase`` or ``critical value``.
    distances : tuple of float or None
        From the rigid value on each rung: relative, but for the phase [rad].
    exponent : float or None
        Of K, fitted to the stiffest rungs; None where there are fewer than two above rounding.
    """

    quantity: str
    distances: tuple[float | None, ...]
    exponent: float | None


@dataclass(frozen=True, slots=True)
class Criterion:
    """One question of whether the rigid model is good enough.

    Attributes
    ----------
    name : str
    shift : float
        Relative to what is named.
    good, fair : float
        Sizes up to which it is good, or usable with care.
    """

    name: str
    shift: float
    good: float
    fair: float

    @property
    def grade(self) -> int:
        """0 good, 1 usable with care, 2 not good enough."""
        return int(abs(self.shift) > self.good) + int(abs(self.shift) > self.fair)


@dataclass(frozen=True, slots=True)
class Volts:
    """U_ave [V] by the rigid velocities, by those of the compliant motion, and by its deflections."""

    rigid: float
    by_velocity: float
    by_deflection: float


@dataclass(frozen=True, slots=True)
class Compliance:
    """What compliant membranes change, and how solvers cope.

    Attributes
    ----------
    reason : str
        Why there is nothing to compare, or "".
    rigid : Rigid or None
    critical : CriticalPoint or None
        Of the rigid model, the one that is followed.
    varied : str
        The parameter that varies towards it.
    design_value : float
        Of that parameter, where the motion is.
    order : float
        1/(h+1), the rate expected.
    restitution, periods : float, int
        r, and n, the forcing periods that the motion takes.
    alone : Contact or None
        Contacts at the rigid velocities, bottom and top, without gravity and forcing, dimensionless.
    units : tuple of float
        x_c [m], y_c [m/s], t_c [s].
    rungs : tuple of Rung
        By ascending stiffness.
    convergence : tuple of Convergence
    volts : Volts or None
        With the scenario's own stiffness.
    runs : tuple of SolverRun
    criteria : tuple of Criterion
    """

    reason: str = ""
    rigid: Rigid | None = None
    critical: CriticalPoint | None = None
    varied: Parameter = Parameter.LENGTH
    design_value: float = 0.0
    order: float = 0.0
    restitution: float = 0.0
    periods: int = 1
    alone: Contact | None = None
    units: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rungs: tuple[Rung, ...] = ()
    convergence: tuple[Convergence, ...] = ()
    volts: Volts | None = None
    runs: tuple[SolverRun, ...] = ()
    criteria: tuple[Criterion, ...] = ()

    @property
    def own(self) -> Rung | None:
        """The rung with the scenario's stiffness."""
        return next((rung for rung in self.rungs if rung.factor == 1), None)

    @property
    def grade(self) -> int | None:
        """The worst of the criteria; 2 where the motion or critical point is lost; None where nothing is compared."""
        if self.own is None:
            return None
        if self.own.orbit is None or not self.own.orbit.stable:
            return 2
        if self.critical is not None and self.own.critical_value is None:
            return 2
        return max(criterion.grade for criterion in self.criteria)


def convergence_of(made: Compliance) -> tuple[Convergence, ...]:
    """Distances from the rigid model on all rungs, and the rates at which they vanish."""
    rigid, critical = cast(Rigid, made.rigid), made.critical
    orbits = [rung.orbit for rung in made.rungs]
    velocity = [None if o is None else abs(o.bottom.velocity / rigid.velocity_bottom - 1) for o in orbits]
    phase = [None if o is None else abs(phase_shift(o.bottom.phase, rigid.phase_bottom)) for o in orbits]
    value = [
        abs(rung.critical_value / critical.point.sweep_value - 1)
        if critical is not None and rung.critical_value is not None
        else None
        for rung in made.rungs
    ]
    factors = np.array([rung.factor for rung in made.rungs])
    return tuple(
        Convergence(name, tuple(distances), _exponent(factors, distances))
        for name, distances in (("velocity", velocity), ("phase", phase), ("critical value", value))
    )


def _exponent(factors: Floats, distances: Sequence[float | None]) -> float | None:
    """Slope of log(distance) over log(K) on the stiffest rungs."""
    known = [(f, e) for f, e in zip(factors, distances, strict=True) if e is not None and e > FLOOR][-FITTED:]
    if len(known) < 2:
        return None
    x, y = np.log(np.array(known)).T
    return float(np.polyfit(x, y, 1)[0])


def phase_shift(phase: float, reference: float) -> float:
    """Difference of two phases [rad], in [-pi, pi)."""
    return float((phase - reference + np.pi) % (2 * np.pi) - np.pi)


def volts_of(made: Compliance, membrane: Membrane) -> Volts | None:
    """U_ave with the scenario's own stiffness, Eq. (5.1)."""
    own = made.own
    if own is None or own.orbit is None:
        return None
    rigid, (length, unit, _) = cast(Rigid, made.rigid), made.units
    touches = own.orbit.bottom, own.orbit.top
    depth = length * np.array([touch.deflection for touch in touches])
    # The velocity that would press the membrane as deep by (5.5): depth grows as its power 2/(h+1).
    as_fast = (depth / deflection(np.array(1.0), membrane)) ** ((membrane.exponent + 1) / 2)
    speeds = (
        unit * np.array([rigid.velocity_bottom, rigid.velocity_top]),
        unit * np.array([touch.velocity for touch in touches]),
        as_fast,
    )
    return Volts(*(float(generated_voltage(speed, membrane).mean()) for speed in speeds))


def criteria_of(made: Compliance) -> tuple[Criterion, ...]:
    """The questions on which the rigid model is judged, with the scenario's own stiffness."""
    own = made.own
    if own is None or own.orbit is None or made.volts is None:
        return ()
    rigid, volts = cast(Rigid, made.rigid), made.volts
    found = [
        Criterion(
            "velocity at the bottom", own.orbit.bottom.velocity / rigid.velocity_bottom - 1, GOOD_SPEED, FAIR_SPEED
        ),
        Criterion("velocity at the top", own.orbit.top.velocity / rigid.velocity_top - 1, GOOD_SPEED, FAIR_SPEED),
        Criterion("U_ave by the velocities", volts.by_velocity / volts.rigid - 1, GOOD_VOLTAGE, FAIR_VOLTAGE),
    ]
    if made.critical is not None and own.critical_value is not None:
        at = made.critical.point.sweep_value
        if margin := abs(made.design_value - at):
            found.append(Criterion(made.critical.label, (own.critical_value - at) / margin, GOOD_MARGIN, FAIR_MARGIN))
    return tuple(found)
