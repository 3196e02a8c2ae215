"""What the membranes' own stiffness makes of a design: its motion, and where that ends, beside the rigid answers.

The comparison of `compliance` follows the motion over many stiffnesses and tries solvers on it, in seconds. Here only
the scenario's own stiffness counts, and the return map is that of `return_map`: a few hundredths of a second, so that
a report of a device with long contacts always has it.
"""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from enum import StrEnum
from math import copysign, inf, pi
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.base import NumericalError, brief
from vireport.compliant.descent import MULTIPLIER, Floats, Rigid, descend, rigid_motion
from vireport.compliant.model import CompliantModel, compliant_model, free_flight
from vireport.compliant.return_map import SUBSTEPS, ReturnTrip, return_trip
from vireport.design import Solution
from vireport.motions import Event, Point
from vireport.physics import Device, Membrane, by_wall
from vireport.scenario import Parameter, ScalarInput
from vireport.simulation import BOTTOM, TOP

COARSE, ROUGH = 3, 6
"""Columns of the extrapolation while a correction is larger than `NEAR`, and then; the last one is made with all."""

NEAR = 0.03
"""Relative correction after which the next one is about as small as the error of the coarse columns, 1e-3."""

CLOSE = 1e-5
"""Last relative correction of what is followed: by slopes right to a few per cent, so that a tenth of it is left."""

MOST_STEPS = 12
"""Of the iteration; three to six are usual."""

DIFFERENCE = 1e-6
"""Relative step of the forward differences of the Jacobian, itself exact, of the return map."""

LEAST_RESTITUTION = 0.2
"""Least r that is followed: the contact has ever more parts, and lasts ever longer, as it goes to 0."""

FAR = 0.5
"""Relative change of an unknown beyond which another motion was found than the one that is followed."""

SAME_TIME = 1e-6
"""Difference of a flight time from that of the event search, over the period, up to which both found one touch."""


FEWEST, MOST = 3, 6
"""Significant digits of an end of stable motion, as far as what the membranes' stiffness moves it by justifies them."""


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


TOO_LOSSY = Absence(Missing.NOT_FOLLOWED, f"restitutions below {LEAST_RESTITUTION} are not followed")
"""Of a ball that is damped so strongly that no contact of it is integrated to the stated error."""


class OwnMotion(Struct, frozen=True, eq=False):
    """The motion with the membranes' own stiffness, dimensionless as in `Motions`; velocities and phases at the touch.

    Attributes
    ----------
    velocity_bottom, velocity_top, phase_bottom, phase_top : float
    contact_share : float
        Longest contact over the forcing period.
    trace, determinant : float
        Of the linearised return map.
    error : float
        Estimate of the velocity's and the phase's error.
    """

    velocity_bottom: float
    velocity_top: float
    phase_bottom: float
    phase_top: float
    contact_share: float
    trace: float
    determinant: float
    error: float

    @property
    def stable(self) -> bool:
        """Whether both multipliers are inside the unit circle."""
        return abs(self.trace) < 1 + self.determinant and self.determinant < 1


class StabilityEnd(Struct, frozen=True, eq=False):
    """An end of stable motion with rigid membranes and with their own stiffness.

    Attributes
    ----------
    parameter : DesignInput or Parameter
        That varies.
    point : Point
        With rigid membranes.
    design_value : float or None
        Of the input, None where no design point is given.
    swept : bool
        Whether it ends a stable range of the sweep.
    compliant : float or None
        Value of the input; None where there is none, or none is known.
    error : float
        Estimate of the error of that value.
    absence : Absence or None
        Why there is none.
    """

    parameter: ScalarInput
    point: Point
    design_value: float | None
    swept: bool
    compliant: float | None
    error: float
    absence: Absence | None

    __repr__ = brief

    @property
    def rigid(self) -> float:
        """Value of the input with rigid membranes."""
        return self.point.sweep_value

    @property
    def moved(self) -> float:
        """Distance between the two; 0 where there is but one."""
        return 0.0 if self.compliant is None else abs(self.compliant - self.rigid)

    @property
    def digits(self) -> int:
        """Significant digits worth showing of either: one more than those in which they agree, and one to compare."""
        if not self.moved:
            return FEWEST if self.compliant is None else MOST
        justified = Decimal(self.rigid).adjusted() - Decimal(self.moved).adjusted() + 2
        return max(FEWEST, min(MOST, justified))

    @property
    def rigid_margin(self) -> float | None:
        """Distance of the design point from the end with rigid membranes, over its value, positive."""
        return self._margin(self.rigid)

    @property
    def compliant_margin(self) -> float | None:
        """With the membranes' own stiffness: negative where the end is on the other side of the design point."""
        return None if self.compliant is None else self._margin(self.compliant)

    def _margin(self, end: float) -> float | None:
        at = self.design_value
        return None if not at else copysign(1.0, self.rigid - at) * (end - at) / abs(at)


class OwnStiffness(Struct, frozen=True, eq=False):
    """The motion and the ends of stable motion with the membranes' own stiffness.

    Attributes
    ----------
    rigid : Rigid
        The motion that is followed from rigid membranes.
    at_design : bool
        Whether that is at the design point.
    motion : OwnMotion or None
        None where there is none, or none is known.
    absence : Absence or None
        Why there is none.
    ends : tuple of StabilityEnd
        Those of the sweep's stable ranges, by ascending value, and then the nearest one to the design point.
    """

    rigid: Rigid
    at_design: bool
    motion: OwnMotion | None
    absence: Absence | None
    ends: tuple[StabilityEnd, ...]

    __repr__ = brief

    @property
    def margin_gone(self) -> bool:
        """Whether the motion at the design point is known to be not stable, or not there, although the rigid one is."""
        lost = self.absence is not None and self.absence.missing is Missing.LOST
        return self.at_design and (lost or (self.motion is not None and not self.motion.stable))

    @property
    def swept_ends(self) -> tuple[StabilityEnd, ...]:
        """The ends of the sweep's stable ranges."""
        return tuple(end for end in self.ends if end.swept)

    def end_of(self, parameter: ScalarInput, point: Point) -> StabilityEnd | None:
        """The end that a critical point is when an input varies, None where it was not followed."""
        same = (end for end in self.ends if end.parameter == parameter and end.rigid == point.sweep_value)
        return next(same, None)


def own_stiffness(solution: Solution) -> OwnStiffness | None:
    """Follow the stable motion and its ends from rigid membranes to the scenario's own.

    None where no ball mass is given or no 1:1 motion is stable.
    """
    solution.device.plain_ball("what long contacts change")
    membrane, chosen = solution.membrane, rigid_motion(solution)
    if membrane is None or chosen is None:
        return None
    rigid, device = chosen
    at_design = solution.design is not None and bool(solution.design.motions.stable_mask.any())
    ends = tuple(
        _end(device, membrane, varied, point, at_design, swept) for varied, point, swept in _rigid_ends(solution)
    )
    if min(by_wall(device.restitution)) < LEAST_RESTITUTION:
        return OwnStiffness(rigid, at_design, None, TOO_LOSSY, ends)
    try:
        followed = _Followed(device, membrane, rigid.parameter, None, rigid.time_up)
        start = np.array([rigid.velocity_bottom, rigid.phase_bottom])
        motion, absence = _motion(followed, *_descended(followed, start)), None
    except NumericalError as error:
        motion, absence = None, _absence(error)
        # Two motions that meet at a fold are not there beyond it.
        passed = [end for end in ends if end.point.event is Event.FOLD and (end.compliant_margin or 0.0) < 0]
        if at_design and passed:
            absence = Absence(Missing.LOST, "it ends at a fold before the design point")
    return OwnStiffness(rigid, at_design, motion, absence, ends)


def _absence(error: NumericalError) -> Absence:
    return Absence(Missing.LOST if isinstance(error, _TouchedBefore) else Missing.NOT_FOUND, str(error))


def _rigid_ends(solution: Solution) -> Iterator[tuple[ScalarInput, Point, bool]]:
    """Ends of the sweep's stable ranges, and of the design point the nearest limit and the nearest end of stability."""
    swept = [point for part in solution.stable_ranges for _, point in part.ends if point is not None]
    for point in swept:
        yield solution.parameter, point, True
    if solution.design is not None and solution.design.motions.stable_mask.any():
        nearest = [
            margin for margins in (solution.design.limits(), solution.design.endings()) for margin in margins[:1]
        ]
        for margin in {margin.point: margin for margin in nearest}.values():
            if not any(margin.point is point for point in swept):
                yield margin.parameter, margin.point, False


class _Followed(Struct, frozen=True, eq=False):
    """Something on the return map: the motion of a device or, with a multiplier, where it has that one.

    Its unknowns are velocity and phase at the bottom and, with a multiplier, the value of the input that varies.
    `time_up` is the time of the rigid motion from bottom to top [t_c].
    """

    device: Device
    membrane: Membrane
    varied: ScalarInput
    multiplier: float | None
    time_up: float

    def returned(self, x: Floats, factor: float, columns: int) -> tuple[Floats, ReturnTrip, CompliantModel]:
        """What vanishes where it is, with the trip and the model there."""
        device = self.device if self.multiplier is None else self.device.with_values({self.varied: float(x[2])})
        model = compliant_model(device, Parameter.LENGTH, device.length_m, self.membrane, factor)
        flights = self.time_up, model.period - self.time_up
        trip = return_trip(model, float(x[0]), float(x[1]), flights, columns)
        values = [trip.velocity - x[0], pi * (trip.time - model.period)]
        if self.multiplier is not None:
            values.append(np.linalg.det(trip.jacobian - self.multiplier * np.eye(2)))
        return np.array(values), trip, model

    def found(self, factor: float, guess: Floats) -> tuple[tuple[Floats, Floats], Floats]:
        """Where it is, and the slopes of what vanishes there, from a guess, as `descend` asks for it."""
        try:
            x, slopes = self._found(factor, guess, COARSE)
        except NumericalError:
            # With contacts that are nearly as long as the flights the coarse columns may lead astray.
            x, slopes = self._found(factor, guess, ROUGH)
        return (x, slopes), x

    def _found(self, factor: float, guess: Floats, coarse: int) -> tuple[Floats, Floats]:
        x, scale, columns, slopes = guess, np.maximum(np.abs(guess), 0.1), coarse, np.empty(0)
        way = np.full(len(guess), inf)
        for _ in range(MOST_STEPS):
            before, columns = columns, coarse if np.max(np.abs(way)) > NEAR else ROUGH
            try:
                values, trip, _ = self.returned(x, factor, columns)
                if self.multiplier is None:
                    slopes = trip.jacobian - np.eye(2)
                elif not slopes.size:
                    slopes = self._differences(x, values, factor, columns)
                elif columns == before:
                    # Broyden's update: what the last step has left is what the slopes did not know. With slopes taken
                    # anew at each step an end takes three times as long.
                    slopes = slopes + np.outer(values, way / scale) / (way @ way)
                after = x - np.linalg.solve(slopes, values)
            except (np.linalg.LinAlgError, OverflowError, ZeroDivisionError) as error:
                raise NumericalError("the iteration on the return map leads to no motion nearby") from error
            # A root far away is a motion of another family, which must not pass for the one that is followed.
            if not np.all(np.abs(after - guess) < FAR * scale):
                break
            x, way = after, (after - x) / scale
            if np.max(np.abs(way)) < CLOSE and columns == ROUGH:
                return x, slopes
        raise NumericalError("the iteration on the return map leads to no motion nearby")

    def _differences(self, x: Floats, values: Floats, factor: float, columns: int) -> Floats:
        """Derivatives of what vanishes, by forward differences."""
        steps = np.diag(DIFFERENCE * np.maximum(np.abs(x), 0.1))
        stepped = (self.returned(x + step, factor, columns)[0] - values for step in steps)
        return np.stack([change / step.sum() for change, step in zip(stepped, steps, strict=True)], axis=1)


def _descended(followed: _Followed, rigid: Floats) -> tuple[Floats, Floats]:
    """Follow from rigid membranes to the scenario's own: where it is, and what the highest order corrected there.

    Raises
    ------
    NumericalError
        If it is lost, or the ball touches a membrane in between.
    """
    ((found, reason),) = descend([1.0], followed.membrane.exponent, rigid, followed.found)
    if found is None:
        raise NumericalError(reason)
    start, slopes = found
    values, trip, model = followed.returned(start, 1.0, len(SUBSTEPS))
    x = start - np.linalg.solve(slopes, values)
    # The map goes from membrane to membrane by roots near those of the rigid motion; that the ball touches none before
    # is for the event search of the simulation to say.
    departures = (
        (BOTTOM, trip.bottom, float(start[1]), trip.flights[0]),
        (TOP, trip.top, trip.phase_top, trip.flights[1]),
    )
    for wall, contact, phase, expected in departures:
        time, reached, _ = free_flight(model, wall, contact.leaving, phase + pi * contact.duration)
        if reached == wall or abs(time - expected) > SAME_TIME * model.period:
            raise _TouchedBefore("the ball falls back on the same membrane: not a motion with one impact on each")
    return x, np.abs(x - start)


def _motion(followed: _Followed, x: Floats, corrected: Floats) -> OwnMotion:
    """The numbers of a motion that was found."""
    _, trip, _ = followed.returned(x, 1.0, len(SUBSTEPS))
    return OwnMotion(
        velocity_bottom=float(x[0]),
        velocity_top=trip.velocity_top,
        phase_bottom=float(x[1] % (2 * pi)),
        phase_top=trip.phase_top % (2 * pi),
        contact_share=max(trip.bottom.duration, trip.top.duration) / 2,
        trace=float(np.trace(trip.jacobian)),
        determinant=float(np.linalg.det(trip.jacobian)),
        error=float(np.max(corrected)),
    )


def _end(
    device: Device, membrane: Membrane, varied: ScalarInput, point: Point, at_design: bool, swept: bool
) -> StabilityEnd:
    """Follow an end of stable motion from rigid membranes to the scenario's own."""
    closed, design_value = point.closed, float(device.value_of(varied)) if at_design else None
    absence = TOO_LOSSY if min(by_wall(device.restitution)) < LEAST_RESTITUTION else None
    if point.event not in MULTIPLIER:
        absence = Absence(Missing.NOT_FOLLOWED, f"a {point.event.words} is not followed")
    if absence is not None:
        return StabilityEnd(varied, point, design_value, swept, None, 0.0, absence)
    start = np.array([closed.velocity_bottom, closed.phi_bottom, point.sweep_value])
    time_up = 2 * device.period_ratio * (0.5 + closed.u)
    try:
        x, corrected = _descended(_Followed(device, membrane, varied, MULTIPLIER[point.event], time_up), start)
    except NumericalError as error:
        return StabilityEnd(varied, point, design_value, swept, None, 0.0, _absence(error))
    return StabilityEnd(varied, point, design_value, swept, float(x[2]), float(corrected[2]), None)


def own_stiffness_data(found: OwnStiffness) -> dict[str, Any]:
    """The motion and its ends with the membranes' own stiffness, as plain data for JSON."""
    motion = found.motion
    return {
        "parameter": found.rigid.parameter,
        "value": found.rigid.value,
        "at_design_point": found.at_design,
        "margin_gone": found.margin_gone,
        "motion": None
        if motion is None
        else {
            "velocity_bottom": motion.velocity_bottom,
            "velocity_top": motion.velocity_top,
            "phi_bottom_rad": motion.phase_bottom,
            "phi_top_rad": motion.phase_top,
            "contact_share": motion.contact_share,
            "trace": motion.trace,
            "determinant": motion.determinant,
            "stable": motion.stable,
            "error_estimate": motion.error,
        },
        **_absence_data(found.absence),
        "ends": [
            {
                "parameter": end.parameter,
                "label": end.point.label or None,
                "kind": end.point.event,
                "of_sweep": end.swept,
                "design_value": end.design_value,
                "rigid": end.rigid,
                "compliant": end.compliant,
                "error_estimate": None if end.compliant is None else end.error,
                **_absence_data(end.absence),
                "rigid_margin": end.rigid_margin,
                "compliant_margin": end.compliant_margin,
            }
            for end in found.ends
        ],
    }


def _absence_data(absence: Absence | None) -> dict[str, Any]:
    return {
        "missing": None if absence is None else absence.missing,
        "reason": None if absence is None else absence.reason,
    }
