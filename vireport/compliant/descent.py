"""From rigid membranes, which are infinitely stiff, to compliant ones: what is followed, and how.

A contact lasts in proportion to epsilon = K^(-1/(h+1)), so that everything approaches the rigid model at that rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from math import inf, pi

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.compliant.model import CompliantModel, compliant_model, free_flight
from vireport.compliant.return_map import SUBSTEPS, Bounce, ReturnTrip, return_trip
from vireport.design.solution import Solution, stable_motion
from vireport.motions.events import Event
from vireport.motions.points import Point
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.scenario.parameters import Parameter, ScalarInput
from vireport.simulation.events import BOTTOM, TOP
from vireport.text.formatting import ROUGHLY, shown

Floats = NDArray[np.float64]

SHORTEST = 1 / 8
"""Share of the way in epsilon below which no smaller step is tried where a motion is lost."""

MULTIPLIER = {Event.PERIOD_DOUBLING: -1.0, Event.FOLD: 1.0}
"""Multiplier at each kind of critical point that is followed, the preferred kind first."""

COARSE, ROUGH = 3, 6
"""Columns of the extrapolation while a correction is larger than `NEAR`, and then."""

REPORTED = (8,)
"""Columns of the last corrections in every report."""

FINEST = (8, 11, len(SUBSTEPS))
"""Columns of the last corrections on a ladder of stiffnesses: far up it, nothing but the distance from the rigid model
is of interest, which vanishes."""

NEAR = 0.03
"""Relative correction after which the next one is about as small as the error of the coarse columns, 1e-3."""

CLOSE = 1e-5
"""Last relative correction with the rough columns: by slopes right to a few per cent, so that a tenth of it is left."""

SETTLED = 0.01
"""Last correction with the columns that follow, over what they have corrected: the rest is their error."""

UNRESOLVED = 3e-4
"""Correction by the last columns, of the velocity relative, of the phase [rad], from which the extrapolation does not
converge: the other forces are ten times that of the membrane or so, as where a ball touches a very soft one slowly."""

MOST_STEPS = 12
"""Of the iteration; three to six are usual."""

DIFFERENCE = 1e-6
"""Relative step of the forward differences of the Jacobian, itself exact, of the return map."""

FAR = 0.5
"""Relative change of an unknown beyond which another motion was found than the one that is followed."""

SAME_TIME = 1e-6
"""Difference of a flight time from that of the event search, over the period, up to which both found one touch."""

ARITHMETIC = np.linalg.LinAlgError, OverflowError, ZeroDivisionError
"""What an iteration raises that has gone astray."""

LEADS_NOWHERE = "the iteration on the return map leads to no motion nearby"


class Missing(StrEnum):
    """Why there is no compliant motion or end beside the rigid one."""

    LOST = "lost"
    """There is none: the ball touches a membrane on its way, or the motion ends at a fold before the design point."""
    NOT_FOUND = "not found"
    """The iteration leads to none nearby; there may be one."""
    NOT_FOLLOWED = "not followed"
    """It is of a kind that is not looked for."""


class Absence(Struct, frozen=True):
    """Which it is of `Missing`, and what was met."""

    missing: Missing
    reason: str


class _TouchedBefore(NumericalError):
    """The ball touches a membrane on its way, so that what the return map leads to is no motion."""


class Rigid(Struct, frozen=True, eq=False):
    """The motion with rigid impacts that is followed: where it is, why this one, and its numbers as in `Motions`.

    Attributes
    ----------
    parameter : Parameter
    value : float
    chosen : str
    velocity_bottom, velocity_top : float
        Z' just before the impact [y_c].
    phase_bottom, phase_top : float
        Forcing phase there [rad].
    time_up : float
        Of the flight from the bottom to the top [t_c].
    """

    parameter: Parameter
    value: float
    chosen: str
    velocity_bottom: float
    velocity_top: float
    phase_bottom: float
    phase_top: float
    time_up: float


class CompliantMotion(Struct, frozen=True):
    """A periodic motion with one contact on each membrane, dimensionless.

    Attributes
    ----------
    bottom, top : Bounce
    flight_down : float
        Time from leaving the top to touching the bottom [t_c].
    residual : float
        By which the state fails to repeat.
    trace, determinant : float
        Of the linearised return map from touch to touch of the bottom.
    error : float
        Estimate of the velocity's and the phase's error.
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
        return abs(self.trace) < 1 + self.determinant and self.determinant < 1

    @property
    def contact_share(self) -> float:
        """Longest contact over the forcing period."""
        return max(self.bottom.duration, self.top.duration) / 2


class Reached(Struct, frozen=True, eq=False):
    """What is followed, with the stiffness asked for.

    Attributes
    ----------
    x, errors : ndarray
        Velocity and phase at the bottom and, of an end, the value of the input that varies; estimates of their errors.
    motion : CompliantMotion
    """

    x: Floats
    errors: Floats
    motion: CompliantMotion


def rigid_motion(solution: Solution) -> tuple[Rigid, Device] | None:
    """The motion that is followed, and the device that has it."""
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
    """Something on the return map: the motion of a device or, with a multiplier, where it has that one.

    Its unknowns are velocity and phase at the bottom and, with a multiplier, the value of the input that varies.

    Attributes
    ----------
    start : ndarray
        The unknowns with rigid membranes.
    time_up : float
        Of the rigid motion from the bottom to the top [t_c].
    """

    device: Device
    membrane: Membrane
    varied: ScalarInput
    multiplier: float | None
    start: Floats
    time_up: float

    def near(self, factor: float, guess: Floats) -> tuple[Floats, Floats]:
        """Where it is at K times a factor to about `CLOSE`, and the slopes of what vanishes there, from a guess."""
        try:
            return self._near(factor, guess, COARSE)
        except NumericalError:
            # With contacts that are nearly as long as the flights the coarse columns may lead astray.
            return self._near(factor, guess, ROUGH)

    def reached(self, factor: float, near: Floats, slopes: Floats, stages: Sequence[int]) -> Reached:
        """Correct what is near with ever more columns, and look whether the ball goes that way.

        Raises
        ------
        NumericalError
            If the ball touches a membrane in between, or its contacts cannot be resolved.
        """
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
        errors = np.abs(x - before) + np.abs(way)
        if not max(errors[0] / abs(x[0]), errors[1]) < UNRESOLVED:
            raise NumericalError("its contacts are too slow and soft to be followed")
        self._look_between(trip, model)
        trace, determinant = float(np.trace(trip.jacobian)), float(np.linalg.det(trip.jacobian))
        residual, error = float(np.max(np.abs(values[:2]))), float(np.max(errors[:2]))
        motion = CompliantMotion(trip.bottom, trip.top, trip.flights[1], residual, trace, determinant, error)
        return Reached(x, errors, motion)

    def _look_between(self, trip: ReturnTrip, model: CompliantModel) -> None:
        # The map goes from membrane to membrane by roots near those of the rigid motion; that the ball touches none
        # before is for the event search of the simulation to say.
        for wall, contact, expected in zip((BOTTOM, TOP), (trip.bottom, trip.top), trip.flights, strict=True):
            time, other, _ = free_flight(model, wall, contact.leaving, contact.phase + pi * contact.duration)
            if other == wall or abs(time - expected) > SAME_TIME * model.period:
                raise _TouchedBefore("the ball falls back on the same membrane: not a motion with one impact on each")

    def _returned(self, x: Floats, factor: float, columns: int) -> tuple[Floats, ReturnTrip, CompliantModel]:
        """What vanishes where it is, with the trip and the model there."""
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
        """Derivatives of what vanishes: exact for a motion; of an end, those before the step that led here, updated."""
        if self.multiplier is None:
            return trip.jacobian - np.eye(2)
        if not np.all(np.isfinite(way)):
            return slopes
        # Broyden's update: what the last step has left is what the slopes did not know. With slopes taken anew at each
        # step an end takes three times as long.
        weighed = way / np.maximum(np.abs(self.start), 0.1) ** 2
        return np.asarray(slopes + np.outer(values, weighed) / (way @ weighed))

    def _differences(self, x: Floats, values: Floats, factor: float, columns: int) -> Floats:
        """Derivatives of what vanishes, by forward differences."""
        steps = np.diag(DIFFERENCE * np.maximum(np.abs(x), 0.1))
        stepped = (self._returned(x + step, factor, columns)[0] - values for step in steps)
        return np.stack([change / step.sum() for change, step in zip(stepped, steps, strict=True)], axis=1)


def motion_to_follow(device: Device, membrane: Membrane, rigid: Rigid) -> Continuation:
    """The stable motion of a device."""
    start = np.array([rigid.velocity_bottom, rigid.phase_bottom])
    return Continuation(device, membrane, rigid.parameter, None, start, rigid.time_up)


def end_to_follow(device: Device, membrane: Membrane, varied: ScalarInput, point: Point) -> Continuation:
    """A critical point of one of the kinds of `MULTIPLIER`, where an input varies."""
    closed = point.closed
    start = np.array([closed.velocity_bottom, closed.phi_bottom, point.sweep_value])
    time_up = 2 * device.period_ratio * (0.5 + closed.u)
    return Continuation(device, membrane, varied, MULTIPLIER[point.event], start, time_up)


def descend(followed: Continuation, factors: Sequence[float], stages: Sequence[int]) -> list[Reached | Absence]:
    """Follow something from rigid membranes down to K times each factor, extrapolating in epsilon.

    Parameters
    ----------
    followed : Continuation
    factors : sequence of float
        Ascending.
    stages : sequence of int
        Columns of the last corrections.
    """
    exponent = followed.membrane.exponent
    (e0, x0), (e1, x1) = (0.0, followed.start), (0.0, followed.start)
    rungs: list[Reached | Absence] = []
    lost: Absence | None = None
    for factor in reversed(factors):
        # epsilon = K^(-1/(h+1)) goes as the duration of a contact, in which the shift from the rigid motion is of
        # first order: straight lines in epsilon extrapolate well down to its zero.
        goal = float(factor ** (-1 / (exponent + 1)))
        step, slopes = goal - e1, np.empty(0)
        while lost is None and e1 != goal:
            aim = min(e1 + step, goal)
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
                    lost = Absence(Missing.NOT_FOUND, f"followed to about K times {shown(stiffness, ROUGHLY)}: {error}")
                continue
            (e0, x0), (e1, x1) = (e1, x1), (aim, x)
        rungs.append(lost if lost is not None else _reached(followed, factor, x1, slopes, stages))
    return rungs[::-1]


def _reached(
    followed: Continuation, factor: float, near: Floats, slopes: Floats, stages: Sequence[int]
) -> Reached | Absence:
    try:
        return followed.reached(factor, near, slopes, stages)
    except NumericalError as error:
        return Absence(Missing.LOST if isinstance(error, _TouchedBefore) else Missing.NOT_FOUND, str(error))
    except ARITHMETIC:
        return Absence(Missing.NOT_FOUND, LEADS_NOWHERE)
