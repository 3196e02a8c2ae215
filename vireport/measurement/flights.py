"""Equations that measured impacts must satisfy: one for each impact between two flights, with its derivatives.

Two impact times and the phase of the force determine a flight: Eq. (2.12) for the position gives the velocity u just
after its first impact, and Eq. (2.11) for the velocity then gives W just before its last. So the flights before and
after an impact give its restitution, for every motion: c = u + r W = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from math import pi
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.physics import flight
from vireport.physics.device import Device
from vireport.physics.groups import Groups
from vireport.physics.numbers import ARRAYS
from vireport.scenario.parameters import DesignInput, Parameter

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]


class Unknown(StrEnum):
    """Quantities that are identified from impacts, or tried as explanations of a misfit; inputs by their keys."""

    RESTITUTION = DesignInput.RESTITUTION.value
    RESTITUTION_BOTTOM = DesignInput.RESTITUTION_BOTTOM.value
    RESTITUTION_TOP = DesignInput.RESTITUTION_TOP.value
    LENGTH = DesignInput.LENGTH.value
    AMPLITUDE = DesignInput.AMPLITUDE.value
    CAPSULE_MASS = DesignInput.CAPSULE_MASS.value
    FREQUENCY = DesignInput.FREQUENCY.value
    INCLINATION = DesignInput.INCLINATION.value
    PHASE = "force_phase_rad"
    EXPONENT = "restitution_exponent"
    DRIFT = "clock_drift_per_s"

    @property
    def design_input(self) -> DesignInput | None:
        """The input of the device with the same key; None of the force's phase, the exponent and the clock's drift."""
        return DesignInput(self.value) if self.value in set(DesignInput) else None

    @property
    def unit(self) -> str:
        """Symbol of its unit, "" where it has none."""
        varied = self.design_input
        return (
            varied.unit if varied is not None else {"force_phase_rad": "rad", "clock_drift_per_s": "1/s"}.get(self, "")
        )


RESTITUTIONS = Unknown.RESTITUTION, Unknown.RESTITUTION_BOTTOM, Unknown.RESTITUTION_TOP
"""The unknown of both membranes together, of the bottom and of the top one."""


class ClockedDevice(Struct, frozen=True):
    """A device, and how the clock of a record is related to the phase of the force.

    Attributes
    ----------
    device : Device
        With all inputs, constant restitutions and no friction.
    phase : float
        Phase of the force at time 0 of the record [rad].
    exponent : float
        Exponent with which the restitution depends on speed [-].
    speed : float
        Speed at which restitutions are stated where they depend on it [y_c].
    drift : float
        Rate at which the clock's rate changes [1/s]: a time t of the clock is taken as t + drift t^2/2.
    """

    device: Device
    phase: float = 0.0
    exponent: float = 0.0
    speed: float = 1.0
    drift: float = 0.0

    def value_of(self, unknown: Unknown) -> float:
        """The value of an unknown, in its unit."""
        varied = unknown.design_input
        if varied is not None:
            return float(self.device.value_of(varied))
        return {Unknown.PHASE: self.phase, Unknown.EXPONENT: self.exponent, Unknown.DRIFT: self.drift}[unknown]

    def with_values(self, unknowns: tuple[Unknown, ...], values: Array) -> ClockedDevice:
        """The model with other values of some unknowns."""
        new = dict(zip(unknowns, map(float, values), strict=True))
        inputs = {varied: new[x] for x in unknowns if (varied := x.design_input) is not None}
        return replace(
            self,
            device=self.device.with_values(inputs),
            phase=new.get(Unknown.PHASE, self.phase),
            exponent=new.get(Unknown.EXPONENT, self.exponent),
            drift=new.get(Unknown.DRIFT, self.drift),
        )

    def scale_of(self, unknown: Unknown, span_s: float) -> float:
        """A change of an unknown, in its unit, that changes a record of a length [s] strongly.

        It makes unknowns of different units comparable: 1 for restitutions and exponent, the value itself for lengths,
        forces and masses, one radian for an angle, and for frequency and drift the change that turns the force's phase
        by a radian between the ends of the record.
        """
        turn = 2 * pi * self.device.frequency_hz * span_s
        match unknown:
            case Unknown.INCLINATION:
                return 180 / pi
            case Unknown.FREQUENCY:
                return self.device.frequency_hz / turn
            case Unknown.DRIFT:
                return 2 / (turn * span_s)
            case Unknown.LENGTH | Unknown.AMPLITUDE | Unknown.CAPSULE_MASS:
                return self.value_of(unknown)
        return 1.0


class MeasuredImpacts(Struct, frozen=True, eq=False):
    """Measured impacts in the order of time, and which flights between them are known to be single ones.

    Attributes
    ----------
    times : Array (n,)
        Ascending [s].
    walls : Array (n,)
        1 at the bottom, -1 at the top.
    flown : Mask (n - 1,)
        Whether neighbours are the ends of one flight, with no impact missed between them.
    relative : Array (n,) or None
        Standard errors of the times relative to a common one; None where they are equal.
    """

    times: Array
    walls: Array
    flown: Mask
    relative: Array | None = None

    @classmethod
    def undoubted(cls, times: Array, walls: Array, relative: Array | None = None) -> MeasuredImpacts:
        """Impacts between which none was missed."""
        return cls(times, walls, np.ones(max(len(times) - 1, 0), dtype=np.bool_), relative)

    def __len__(self) -> int:
        return len(self.times)

    @property
    def span_s(self) -> float:
        """Time from the first to the last [s]."""
        return float(self.times[-1] - self.times[0])

    @property
    def errors(self) -> Array:
        """Standard errors of the times relative to a common one, (n,)."""
        return np.ones(len(self)) if self.relative is None else self.relative

    def rows(self, kept: Indices, flown: Mask | None = None) -> MeasuredImpacts:
        """Some of the impacts, and which of the flights between them are single ones; all by default."""
        relative = None if self.relative is None else self.relative[kept]
        some = MeasuredImpacts.undoubted(self.times[kept], self.walls[kept], relative)
        return some if flown is None else replace(some, flown=flown)

    def first(self, count: int) -> MeasuredImpacts:
        """The first `count` impacts."""
        few = np.arange(min(count, len(self)))
        return self.rows(few, self.flown[: max(len(few) - 1, 0)])

    def at(self, times: Array) -> MeasuredImpacts:
        """The same impacts at other times [s]."""
        return replace(self, times=times)

    def exchanged(self) -> MeasuredImpacts:
        """The same impacts with bottom and top exchanged."""
        return replace(self, walls=-self.walls)


class Equations(Struct, frozen=True, eq=False):
    """The impact law at some impacts, with derivatives by times and unknowns.

    Attributes
    ----------
    impacts : Indices (m,)
        Row of the impact to which each equation belongs.
    value : Array (m,)
        c = u + r W [y_c].
    by_time : Array (m, 3)
        Derivatives by the times of the impact before it, of its own and of the one after it [y_c/s].
    before, after : Array (m,)
        Velocity just before the impact and just after it [y_c].
    by_unknown : Array (m, p)
        Derivatives by some unknowns.
    relative : Array (m, 3) or None
        Standard errors of the three times relative to the common one; None where they are equal.
    """

    impacts: Indices
    value: Array
    by_time: Array
    before: Array
    after: Array
    by_unknown: Array
    relative: Array | None = None

    @property
    def by_error(self) -> Array:
        """Derivatives by the errors of the three times, each in its relative standard error, (m, 3) [y_c/s]."""
        return self.by_time if self.relative is None else self.by_time * self.relative

    @property
    def spread(self) -> Array:
        """Standard deviation of each value for a timing error of 1 s [y_c/s]."""
        return np.asarray(np.sqrt(np.einsum("ij,ij->i", self.by_error, self.by_error)))


def velocities(model: ClockedDevice, times: Array, walls: Array) -> tuple[Array, Array]:
    """Velocities at both ends of the flights between impacts: just after the first, just before the last [y_c].

    Parameters
    ----------
    model : ClockedDevice
    times : Array (n,)
        Of the impacts [s].
    walls : Array (n,)
        1 at the bottom, -1 at the top.

    Returns
    -------
    Array (n - 1,), Array (n - 1,)
    """
    groups = model.device.groups(Parameter.LENGTH, model.device.length_m)
    flights = _flown(groups, model.phase, dimensionless(model, times), walls)
    return flights.after, flights.before


class _Flights(Struct, frozen=True, eq=False):
    """Flights between impacts: velocities just after the first and just before the last of the two, forces at both."""

    after: Array
    before: Array
    force: Array
    force_end: Array
    duration: Array


def _flown(groups: Groups[Any], phase: Any, times: Array, walls: Array) -> _Flights:
    """Flights between impacts at dimensionless times; for several phases of the force (p, 1), one row for each."""
    duration = times[1:] - times[:-1]
    first, last = (groups.wave(pi * t + phase, ARRAYS) for t in (times[:-1], times[1:]))
    # The ball starts from one membrane and arrives at the same one, or a distance d away.
    across = (walls[1:] - walls[:-1]) * groups.d / 2
    # The initial velocity adds to a flight from rest the distance that it lacks, Eq. (2.12).
    covered = flight.displacement(duration, 0.0, first.impulse, first.path, last.path, groups.gbar)
    after = (across - covered) / duration
    before = flight.velocity(duration, after, first.impulse, last.impulse, groups.gbar)
    return _Flights(after, before, first.force, last.force, duration)


def _by_time(flights: _Flights, gbar: float, first: Indices, slope: Any) -> Array:
    """Derivatives of c = u + r W by the times of an impact and its two neighbours: (m, 3), or (p, m, 3) for p phases.

    From those of a flight's velocities by its two times, Eqs. (2.11), (2.12).

    Parameters
    ----------
    flights : _Flights
    gbar : float
    first : Indices (m,)
        The flight that each impact begins; the one before ends with it.
    slope : float or Array
        Derivative of r W by W.
    """
    # An impact ends one flight and begins the next: its time is in both.
    last = first - 1
    u, w, duration = flights.after, flights.before, flights.duration
    return np.stack(
        [
            slope * (u[..., last] / duration[last]),
            slope * (gbar + flights.force_end[..., last] - w[..., last] / duration[last])
            + (u[..., first] / duration[first] + gbar + flights.force[..., first]),
            -w[..., first] / duration[first],
        ],
        axis=-1,
    )


def around_phases(
    model: ClockedDevice, impacts: MeasuredImpacts, phases: Array, profile: Callable[[Array, Array], Any]
) -> Array:
    """Timing error that the equation of each impact alone implies, at many phases of the force: (p, m) [s].

    Parameters
    ----------
    model : ClockedDevice
        Its exponent is ignored.
    impacts : MeasuredImpacts
    phases : Array (p,)
        Of the force at time 0 [rad].
    profile : callable
        Gives the restitutions (p, m) from those of single impacts, -u/W (p, m), and their membranes (m,).
    """
    groups = model.device.groups(Parameter.LENGTH, model.device.length_m)
    t, walls = dimensionless(model, impacts.times), impacts.walls
    flights = _flown(groups, phases[:, None], t, walls)
    first = _between(impacts)
    u, w = flights.after[:, first], flights.before[:, first - 1]
    with np.errstate(all="ignore"):
        # A ball that does not move towards the membrane it strikes has no restitution.
        single = np.where(walls[first] * w > 0, -u / w, np.nan)
    r = profile(single, walls[first])
    by_time = _by_time(flights, float(groups.gbar), first, r)
    spread = np.sqrt(np.einsum("ijk,ijk->ij", by_time, by_time)) * (2 * model.device.frequency_hz)
    return np.asarray(np.abs(u + r * w) / spread)


def dimensionless(model: ClockedDevice, t: Any) -> Any:
    """Times [s] of the record's clock in units of t_c = 1/(2 f), its drift taken out."""
    return 2 * model.device.frequency_hz * (t + model.drift * t * t / 2)


def _between(impacts: MeasuredImpacts) -> Indices:
    """Rows of impacts with a single flight known to be on either side."""
    return np.flatnonzero(impacts.flown[:-1] & impacts.flown[1:]) + 1


def equations(model: ClockedDevice, impacts: MeasuredImpacts, unknowns: tuple[Unknown, ...] = ()) -> Equations:
    """The equations of all impacts with a single flight known to be on either side.

    Parameters
    ----------
    model : ClockedDevice
    impacts : MeasuredImpacts
    unknowns : tuple of Unknown
        By which they are differentiated.
    """
    device, walls = model.device, impacts.walls
    groups = device.groups(Parameter.LENGTH, device.length_m)
    flights = _flown(groups, model.phase, dimensionless(model, impacts.times), walls)
    inner = _between(impacts)
    last, first = inner - 1, inner  # the flights that end and begin with the impact
    wall = walls[inner]
    bottom, top = (float(device.value_of(x)) for x in (DesignInput.RESTITUTION_BOTTOM, DesignInput.RESTITUTION_TOP))
    u, w = flights.after[first], flights.before[last]
    share = np.ones_like(w)
    if model.exponent:
        # A velocity of exactly 0 would make a negative power infinite.
        share = (np.maximum(np.abs(w), 1e-300) / model.speed) ** model.exponent
    r = np.where(wall > 0, bottom, top) * share
    slope = (1 + model.exponent) * r
    by_time = _by_time(flights, float(groups.gbar), first, slope)
    rebounds = _Rebounds(inner, w, r, slope, share, wall, by_time)
    columns = [_column(model, x, impacts, flights, rebounds) for x in unknowns]
    by_unknown = np.stack(columns, axis=1) if columns else np.empty((len(inner), 0))
    errors = None if impacts.relative is None else impacts.relative[inner[:, None] + np.arange(-1, 2)]
    return Equations(inner, u + r * w, by_time * (2 * device.frequency_hz), w, u, by_unknown, errors)


class _Rebounds(Struct, frozen=True, eq=False):
    """Impacts between two known flights, with numbers that are common to derivatives by all unknowns.

    Attributes
    ----------
    rows : Indices (m,)
    before, restitution : Array (m,)
        W [y_c] and r, so that c = u + r W.
    slope, share : Array (m,)
        Derivative of r W by W, and r over the restitution of the membrane.
    wall : Array (m,)
    by_time : Array (m, 3)
        Derivatives of c by the dimensionless times of the three impacts.
    """

    rows: Indices
    before: Array
    restitution: Array
    slope: Array
    share: Array
    wall: Array
    by_time: Array


def _column(
    model: ClockedDevice, unknown: Unknown, impacts: MeasuredImpacts, flights: _Flights, rebounds: _Rebounds
) -> Array:
    """Derivatives of the equations c = u + r W by an unknown: (m,)."""
    device, times, w = model.device, impacts.times, rebounds.before
    last, first = rebounds.rows - 1, rebounds.rows
    around = np.stack([last, first, first + 1], axis=1)

    def moved(by: Array) -> Array:
        """The change of the equations when the dimensionless times move by some amounts (n,)."""
        return np.asarray(np.einsum("ij,ij->i", rebounds.by_time, by[around]))

    # A phase of the force is the same change of all times; a drift of the clock one that grows with their squares.
    if unknown is Unknown.PHASE:
        return np.asarray(rebounds.by_time.sum(axis=1) / pi)
    if unknown is Unknown.DRIFT:
        return moved(device.frequency_hz * times * times)
    if unknown is Unknown.EXPONENT:
        return np.asarray(rebounds.restitution * w * np.log(np.maximum(np.abs(w), 1e-300) / model.speed))
    varied, groups = DesignInput(unknown.value), device.groups(Parameter.LENGTH, device.length_m)
    by_d, by_gbar, by_bottom, by_top = device.slopes(varied, float(groups.d), float(groups.gbar))
    # d and gbar are in the velocities of both flights, by (2.12); the restitution is in c alone.
    sides, duration, slope = impacts.walls[1:] - impacts.walls[:-1], flights.duration, rebounds.slope
    column = np.where(rebounds.wall > 0, by_bottom, by_top) * rebounds.share * w
    # One unit more of distance adds 1/duration to both velocities of a flight across; one unit of gravity takes half
    # the duration off the first velocity, and adds as much to the last.
    column = column + by_d / 2 * (sides[first] / duration[first] + slope * sides[last] / duration[last])
    column = column + by_gbar / 2 * (slope * duration[last] - duration[first])
    if varied is DesignInput.FREQUENCY:
        column = column + moved(dimensionless(model, times) / device.frequency_hz)
    return np.asarray(column)
