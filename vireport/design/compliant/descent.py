"""Continuation of a motion, or of an end of stable motion, from rigid membranes to compliant ones.

A contact lasts in proportion to epsilon = K^(-1/(h+1)), so that everything approaches the rigid model at that rate:
epsilon is the continuation parameter, 0 where membranes are rigid. At each epsilon Newton's method solves for a fixed
point of the return map, or for one with the multiplier of a critical point.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from math import inf, pi

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.records import ResultsBlock
from vireport.design.compliant.model import CompliantModel, compliant_model, free_flight
from vireport.design.compliant.return_map import SUBSTEPS, Bounce, ReturnTrip, return_trip
from vireport.design.solution import Solution, stable_motion
from vireport.motions.events import Event
from vireport.motions.points import Point
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.scenario.parameters import Parameter, ScalarInput
from vireport.simulation.events import BOTTOM, TOP
from vireport.text.formatting import ROUGHLY, rounded_text

Floats = NDArray[np.float64]

SHORTEST = 1 / 8
"""Share of the way in epsilon below which no smaller step is tried where a motion is lost."""

MULTIPLIER = {Event.PERIOD_DOUBLING: -1.0, Event.FOLD: 1.0}
"""Multiplier at each kind of critical point that is followed, the preferred kind first."""

COARSE, ROUGH = 3, 6
"""Columns of the extrapolation while a correction is larger than `NEAR`, and afterwards."""

REPORTED = (8,)
"""Columns of the last corrections in every report."""

FINEST = (8, 11, len(SUBSTEPS))
"""Columns of the last corrections on a ladder of stiffnesses, where the distance from the rigid model is of interest,
which vanishes far up the ladder."""

NEAR = 0.03
"""Relative correction after which the next one is about as small as the error of the coarse columns, 1e-3."""

CLOSE = 1e-5
"""Last relative correction with the rough columns: the slopes are right to a few per cent, so that a tenth is left."""

SETTLED = 0.01
"""Last correction with more columns over the sum of all: what is left is the error of the columns."""

UNRESOLVED = 3e-4
"""Correction by the last columns, relative for the velocity, in [rad] for the phase, from which the extrapolation does
not converge: other forces are some ten times the membrane's, as where a ball touches a very soft one slowly."""

MOST_STEPS = 12
"""Largest number of steps of the iteration; three to six are usual."""

DIFFERENCE = 1e-6
"""Relative step of forward differences of the return map's Jacobian, which is exact itself."""

FAR = 0.5
"""Relative change of an unknown beyond which a solution is another motion than the one that is followed."""

SAME_TIME = 1e-6
"""Difference of a flight time from the event search's, over the period, up to which both end in the same touch."""

ARITHMETIC = np.linalg.LinAlgError, OverflowError, ZeroDivisionError
"""Errors of an iteration that diverges."""

LEADS_NOWHERE = "the iteration on the return map leads to no motion nearby"


class Missing(StrEnum):
    """Why a rigid motion, or an end of stable motion, has no compliant counterpart."""

    LOST = "lost"
    """No counterpart exists: the ball touches a membrane on its way, or the motion ends at a fold before the design."""
    NOT_FOUND = "not found"
    """The iteration leads to no counterpart nearby; there may be one."""
    NOT_FOLLOWED = "not followed"
    """The motion or end is of a kind that is not followed."""


class Absence(Struct, frozen=True):
    """Why there is no compliant counterpart: the kind, and the reason in words."""

    missing: Missing
    reason: str


class _TouchedBefore(NumericalError):
    """The ball touches a membrane on its way, so that the solution of the return map is no motion."""


class Rigid(ResultsBlock, frozen=True):
    """The motion with rigid impacts that is followed to compliant membranes.

    Attributes
    ----------
    parameter, value
        the swept parameter, or the length, and its value, at which the motion is
    chosen
        why this one, in words
    velocity_bottom, velocity_top : F π/(M ω)
        Z' just before the impact
    phase_bottom, phase_top : rad
        phase of the force there
    time_up : half a forcing period
        of the flight from the bottom to the top
    """

    parameter: Parameter
    value: float
    chosen: str
    velocity_bottom: float
    velocity_top: float
    phase_bottom: float
    phase_top: float
    time_up: float


class CompliantMotion(ResultsBlock, frozen=True):
    """A periodic motion with one contact on each membrane, dimensionless.

    Attributes
    ----------
    bottom, top
        the contacts
    flight_down : half a forcing period
        time from leaving the top to touching the bottom
    residual : F π/(M ω), rad
        difference of the state after a period
    trace, determinant : 1
        of the linearised return map from touch to touch of the bottom
    error : F π/(M ω), rad
        estimate of the velocity's and the phase's error
    """

    bottom: Bounce
    top: Bounce
    flight_down: float
    residual: float
    trace: float
    determinant: float
    error: float

    @property
    def stable(self) -> bool:
        """Whether both multipliers are inside the unit circle."""
        # Jury's criterion for the roots of z^2 - trace z + determinant.
        return abs(self.trace) < 1 + self.determinant and self.determinant < 1

    @property
    def contact_share(self) -> float:
        """Longest contact over the forcing period."""
        return max(self.bottom.duration, self.top.duration) / 2


class Continued(Struct, frozen=True, eq=False):
    """A motion, or an end of stable motion, at a stiffness to which it was followed.

    Attributes
    ----------
    x, errors : ndarray
        Velocity [y_c] and phase [rad] at the bottom and, for an end, the input that varies; estimates of their errors.
    motion : CompliantMotion
    """

    x: Floats
    errors: Floats
    motion: CompliantMotion


def rigid_motion(solution: Solution) -> tuple[Rigid, Device] | None:
    """The stable rigid motion that is followed to compliant membranes, and the device that has it; None without one."""
    chosen = stable_motion(solution)
    if chosen is None:
        return None
    design, row = chosen
    where = "at the design point" if design is solution.design else "in the middle of the first stable range"
    m = design.motions
    time_up = 2 * solution.device.period_ratio * m.q
    numbers = (float(a[row]) for a in (m.velocity_bottom, m.velocity_top, m.phi_bottom, m.phi_top, time_up))
    rigid = Rigid(design.parameter, design.value, f"the stable motion {where}", *numbers)
    return rigid, solution.device.with_values({design.parameter: design.value})


class Continuation(Struct, frozen=True, eq=False):
    """A fixed point of the return map that is continued in the stiffness, or a critical point of such fixed points.

    The unknowns x are velocity and phase at the touch of the bottom and, for a critical point, the value of the input
    that varies. They solve P(x) - x = 0 and, for a critical point, det(DP - multiplier I) = 0.

    Attributes
    ----------
    device : Device
    membrane : Membrane
        Its stiffness is K.
    varied : ScalarInput
        The input that varies, for a critical point.
    multiplier : float or None
        Multiplier at the critical point: -1 for a period doubling, 1 for a fold; None for a motion.
    start : ndarray (2,) or (3,)
        The unknowns with rigid membranes.
    time_up : float
        Flight time of the rigid motion from the bottom to the top [t_c].
    """

    device: Device
    membrane: Membrane
    varied: ScalarInput
    multiplier: float | None
    start: Floats
    time_up: float

    def near(self, factor: float, guess: Floats) -> tuple[Floats, Floats]:
        """Solve at K times a factor, to a relative error of about `CLOSE`, from a guess.

        Returns
        -------
        x : ndarray
            The unknowns.
        slopes : ndarray
            Derivatives of the residuals by the unknowns.

        Raises
        ------
        NumericalError
            If the iteration does not converge nearby.
        """
        try:
            return self._near(factor, guess, COARSE)
        except NumericalError:
            # With contacts that are nearly as long as the flights the coarse columns may lead astray.
            return self._near(factor, guess, ROUGH)

    def corrected(self, factor: float, near: Floats, slopes: Floats, stages: Sequence[int]) -> Continued:
        """Correct a solution with ever more columns of the extrapolation, and check the flights of its ball.

        Parameters
        ----------
        factor : float
            Stiffness over K.
        near, slopes : ndarray
            As returned by `near`.
        stages : sequence of int
            Columns, ascending.

        Raises
        ------
        NumericalError
            If the ball touches a membrane in between, or its contacts cannot be resolved.
        """
        # Relative errors, but of an unknown near 0, such as a phase, over a tenth of its unit.
        x, scale, before = near, np.maximum(np.abs(near), 0.1), near
        for columns in stages:
            before, way = x, np.full(len(x), inf)
            for _ in range(MOST_STEPS):
                values, trip, model = self._returned(x, factor, columns)
                slopes = self._slopes(slopes, values, trip, way)
                way = -np.linalg.solve(slopes, values)
                x = x + way
                if np.max(np.abs(way / scale)) <= SETTLED * np.max(np.abs((x - before) / scale)):
                    break
        # What the last columns have changed bounds what more would; the last step bounds what more steps would.
        errors = np.abs(x - before) + np.abs(way)
        if not max(errors[0] / abs(x[0]), errors[1]) < UNRESOLVED:
            raise NumericalError("its contacts are too slow and soft to be followed")
        self._look_between(trip, model)
        trace, determinant = float(np.trace(trip.jacobian)), float(np.linalg.det(trip.jacobian))
        residual, error = float(np.max(np.abs(values[:2]))), float(np.max(errors[:2]))
        motion = CompliantMotion(trip.bottom, trip.top, trip.flights[1], residual, trace, determinant, error)
        return Continued(x, errors, motion)

    def _look_between(self, trip: ReturnTrip, model: CompliantModel) -> None:
        """Refuse a solution whose ball touches a membrane in flight before the touch that ends the flight.

        Raises
        ------
        NumericalError
        """
        # The map goes from membrane to membrane by roots near those of the rigid motion; that the ball touches none
        # before is for the event search of the simulation to say.
        for wall, contact, expected in zip((BOTTOM, TOP), (trip.bottom, trip.top), trip.flights, strict=True):
            time, other, _ = free_flight(model, wall, contact.leaving, contact.phase + pi * contact.duration)
            if other == wall or abs(time - expected) > SAME_TIME * model.period:
                raise _TouchedBefore("the ball falls back on the same membrane: not a motion with one impact on each")

    def _returned(self, x: Floats, factor: float, columns: int) -> tuple[Floats, ReturnTrip, CompliantModel]:
        """Residuals at some unknowns, which vanish at the solution, with the trip and the model there."""
        # Of a critical point the input is an unknown, and the groups of the device vary with it.
        device = self.device if self.multiplier is None else self.device.with_values({self.varied: float(x[2])})
        model = compliant_model(device, Parameter.LENGTH, device.length_m, self.membrane, factor)
        flights = self.time_up, model.period - self.time_up
        trip = return_trip(model, float(x[0]), float(x[1]), flights, columns)
        values = [trip.velocity - x[0], pi * (trip.time - model.period)]
        if self.multiplier is not None:
            values.append(np.linalg.det(trip.jacobian - self.multiplier * np.eye(2)))
        return np.array(values), trip, model

    def _near(self, factor: float, guess: Floats, coarse: int) -> tuple[Floats, Floats]:
        x, scale, columns, slopes = guess, np.maximum(np.abs(guess), 0.1), coarse, np.empty(0)
        way = np.full(len(guess), inf)
        for _ in range(MOST_STEPS):
            # Far from the root corrections need not be accurate: coarse columns do.
            before, columns = columns, coarse if np.max(np.abs(way / scale)) > NEAR else ROUGH
            try:
                values, trip, _ = self._returned(x, factor, columns)
                if self.multiplier is not None and not slopes.size:
                    slopes = self._differences(x, values, factor, columns)
                else:
                    slopes = self._slopes(slopes, values, trip, way if columns == before else np.full(len(x), inf))
                after = x - np.linalg.solve(slopes, values)
            except ARITHMETIC as error:
                raise NumericalError(LEADS_NOWHERE) from error
            # A root far away is a motion of another family, which must not pass for the one that is followed.
            if not np.all(np.abs(after - guess) < FAR * scale):
                break
            x, way = after, after - x
            if np.max(np.abs(way / scale)) < CLOSE and columns == ROUGH:
                return x, slopes
        raise NumericalError(LEADS_NOWHERE)

    def _slopes(self, slopes: Floats, values: Floats, trip: ReturnTrip, way: Floats) -> Floats:
        """Derivatives of the residuals: exact for a motion; for a critical point updated from the last step."""
        if self.multiplier is None:
            return trip.jacobian - np.eye(2)
        if not np.all(np.isfinite(way)):
            return slopes  # other columns than before: the change of the residuals is not that of a step
        # Broyden's update: what the last step has left is what the slopes did not know. With slopes taken anew at each
        # step an end takes three times as long.
        weighed = way / np.maximum(np.abs(self.start), 0.1) ** 2
        return np.asarray(slopes + np.outer(values, weighed) / (way @ weighed))

    def _differences(self, x: Floats, values: Floats, factor: float, columns: int) -> Floats:
        """Derivatives of the residuals by the unknowns, by forward differences."""
        steps = np.diag(DIFFERENCE * np.maximum(np.abs(x), 0.1))
        stepped = (self._returned(x + step, factor, columns)[0] - values for step in steps)
        return np.stack([change / step.sum() for change, step in zip(stepped, steps, strict=True)], axis=1)


def motion_to_follow(device: Device, membrane: Membrane, rigid: Rigid) -> Continuation:
    """The continuation of a stable motion of a device with rigid membranes."""
    start = np.array([rigid.velocity_bottom, rigid.phase_bottom])
    return Continuation(device, membrane, rigid.parameter, None, start, rigid.time_up)


def end_to_follow(device: Device, membrane: Membrane, varied: ScalarInput, point: Point) -> Continuation:
    """The continuation of a critical point, of one of the kinds of `MULTIPLIER`, where an input varies."""
    closed = point.closed
    start = np.array([closed.velocity_bottom, closed.phi_bottom, point.sweep_value])
    time_up = 2 * device.period_ratio * (0.5 + closed.u)
    return Continuation(device, membrane, varied, MULTIPLIER[point.event], start, time_up)


def descend(followed: Continuation, factors: Sequence[float], stages: Sequence[int]) -> list[Continued | Absence]:
    """Follow a motion or a critical point from rigid membranes down to K times each factor, by steps in epsilon.

    Each step predicts by a straight line in epsilon and corrects by Newton's method; one that fails is halved.

    Parameters
    ----------
    followed : Continuation
    factors : sequence of float
        Ascending.
    stages : sequence of int
        Columns of the last corrections.

    Returns
    -------
    list of Continued or Absence
        One for each factor; below a factor at which the motion is lost, all are absences.
    """
    exponent = followed.membrane.exponent
    (e0, x0), (e1, x1) = (0.0, followed.start), (0.0, followed.start)
    rungs: list[Continued | Absence] = []
    lost: Absence | None = None
    for factor in reversed(factors):
        # epsilon = K^(-1/(h+1)) goes as the duration of a contact, in which the shift from the rigid motion is of
        # first order: straight lines in epsilon extrapolate well down to its zero.
        goal = float(factor ** (-1 / (exponent + 1)))
        step, slopes = goal - e1, np.empty(0)
        while lost is None and e1 != goal:
            aim = min(e1 + step, goal)
            # The first step has one point only, the rigid motion.
            slope = (x1 - x0) / (e1 - e0) if e1 > e0 else np.zeros_like(x1)
            at = factor if aim == goal else aim ** -(exponent + 1)
            try:
                x, slopes = followed.near(at, x1 + slope * (aim - e1))
            except NumericalError as error:
                # The motion may be there though the guess was too far off: only when steps of almost nothing fail is
                # it lost, and stays so with the softer membranes.
                step /= 2
                if step < SHORTEST * goal:
                    stiffness = max(aim, 1e-300) ** -(exponent + 1)
                    lost = Absence(
                        Missing.NOT_FOUND, f"followed to about K times {rounded_text(stiffness, ROUGHLY)}: {error}"
                    )
                continue
            (e0, x0), (e1, x1) = (e1, x1), (aim, x)
        rungs.append(lost if lost is not None else _corrected(followed, factor, x1, slopes, stages))
    return rungs[::-1]


def _corrected(
    followed: Continuation, factor: float, near: Floats, slopes: Floats, stages: Sequence[int]
) -> Continued | Absence:
    """The corrected solution at K times a factor, or why there is none."""
    try:
        return followed.corrected(factor, near, slopes, stages)
    except NumericalError as error:
        return Absence(Missing.LOST if isinstance(error, _TouchedBefore) else Missing.NOT_FOUND, str(error))
    except ARITHMETIC:
        return Absence(Missing.NOT_FOUND, LEADS_NOWHERE)
