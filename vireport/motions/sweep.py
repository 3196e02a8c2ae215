"""One parameter of a device that varies, and what stays constant meanwhile: a level on the surface of motions.

`Sweep` is the parameter with its range; `Level` the condition on d and gbar that holds over the sweep. Motions are
ordered by the sweep's coordinate: d, or gbar where the inclination varies, or the restitution that varies.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.base.errors import UsageError
from vireport.base.records import brief
from vireport.motions.orbits import (
    Friction,
    Orbits,
)
from vireport.physics.device import FINEST_D, FINEST_GBAR, Device, moved, value_in
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitution
from vireport.physics.numbers import ARRAYS, Arithmetic, ExactFunctions
from vireport.scenario.parameters import Parameter

NO_TOLERANCE = 0.0, 0.0
"""The tolerance [unit of the input, %] of an input for which the scenario states none."""

FINEST_SETTING = 1e-6
"""Width of a range, over its value, below which no device can be set into it, where no tolerance is stated."""

FINEST_SHARE = 0.1
"""Least width of a range over the tolerance, where one is stated: of devices that lie anywhere within it, one in 20 is
in the range."""


def settable(start: float, end: float, off: tuple[float, float] = NO_TOLERANCE) -> bool:
    """Whether a range of an input is wide enough for a device to be set into it.

    Parameters
    ----------
    start, end : float
        Ends of the range, in the unit of the input, in either order.
    off : tuple of float
        The tolerance of the input, in its unit and in per cent of its value, of which the larger holds; zeros where
        none is stated.
    """
    value, (fixed, percent) = max(abs(start), abs(end)), off
    finest = FINEST_SHARE * max(fixed, value * percent / 100) or FINEST_SETTING * value
    return abs(end - start) >= finest


class Held(Enum):
    """The group, or ratio of groups, that a sweep holds constant."""

    GBAR = "gbar"
    """Held in a sweep over the length or the frequency, and in any sweep of a horizontal capsule."""
    RATIO = "d/gbar"
    """Held in a sweep over the force."""
    D = "d"
    """Held in a sweep over the inclination."""
    BOTH = "d and gbar"
    """Held in a sweep over a restitution."""


class Level(Struct, frozen=True, eq=False):
    """The linear condition on (gbar, d) that holds over a sweep, hence a curve on the surface of motions.

    Attributes
    ----------
    held : Held
        The group or ratio that is constant.
    value : array_like
        Its value; where both groups are constant, that of gbar.
    friction : Friction or None
        Friction over the sweep as a function of the groups; None for a ball without friction.
    d : array_like or None
        Its value where both groups are constant, else None.
    varied : Parameter or None
        The restitution that varies where both groups are constant, else None.
    """

    held: Held
    value: Any
    friction: Friction | None = None
    d: Any = None
    varied: Parameter | None = None

    @property
    def horizontal(self) -> bool:
        """Whether gbar is zero over the whole sweep."""
        return self.held in (Held.GBAR, Held.BOTH) and bool(self.value == 0)

    @property
    def holds_d(self) -> bool:
        """Whether d is constant over the sweep."""
        return self.held in (Held.D, Held.BOTH)

    def symmetric(self, r: Restitution, harmonics: Sequence[Harmonic]) -> bool:
        """Whether the device and its mirror image are the same over the whole sweep.

        Parameters
        ----------
        r : array_like or Restitutions
            Restitution of the device; it may be the one that varies.
        harmonics : sequence of Harmonic
            Harmonics of the force.
        """
        kept = self.varied is None or self.varied.keeps_symmetry
        return self.horizontal and kept and Groups(0.0, 0.0, r, tuple(harmonics)).symmetric

    def restitution(self, r: Restitution, coordinate: Arithmetic) -> Any:
        """The restitution at a value of the sweep's coordinate, from that of the device."""
        return r if self.varied is None else moved(r, self.varied, coordinate)

    def groups(self, orbit: Any) -> tuple[Any, Any]:
        """Return d and gbar of motions on the level, as arrays; a group that the sweep holds has its exact value."""
        # The closed form rounds the group that the sweep holds. Its value is known exactly, and what is derived from it
        # (the unit of velocity, the sweep's value) should not differ from motion to motion.
        d, gbar = np.array(orbit.d, dtype=float), np.array(orbit.gbar, dtype=float)
        if self.held is Held.D:
            d[:] = self.value
        elif self.held is not Held.RATIO:
            gbar[:] = self.value
        if self.d is not None:
            d[:] = self.d
        return d, gbar


def level_residual(level: Level, orbit: Orbits) -> Any:
    """Difference of a motion from the level of one group: gbar, d - ratio gbar, or d less the value held."""
    if level.held is Held.GBAR:
        return orbit.gbar - level.value
    if level.held is Held.RATIO:
        return orbit.d - level.value * orbit.gbar
    return orbit.d - level.value


class Sweep(Struct, frozen=True):
    """A range of one parameter of a device, all other parameters constant.

    Attributes
    ----------
    device : Device
        Its value of the parameter is not used.
    parameter : Parameter
        The parameter that varies.
    start, end : float
        Range that is swept, in the parameter's unit, in either order.
    off : tuple of float
        The tolerance of the parameter, in its unit and in per cent; zeros where none is stated.
    """

    device: Device
    parameter: Parameter
    start: float
    end: float
    off: tuple[float, float] = NO_TOLERANCE

    __repr__ = brief

    @property
    def level(self) -> Level:
        """The level of the surface of motions that the sweep holds."""
        level = self.level_in(ARRAYS)
        friction = None if level.friction is None else level.friction.map_numbers(float)
        return Level(
            level.held, float(level.value), friction, level.d if level.d is None else float(level.d), level.varied
        )

    def level_in(self, ops: ExactFunctions) -> Level:
        """The level of the sweep in a kind of number.

        Raises
        ------
        UsageError
            If the inclination varies and the ball has friction: then no combination of the groups is constant.
        """
        # Over the force both groups are largest, and best resolved, at its lower end.
        at = min(self.start, self.end) if self.parameter is Parameter.AMPLITUDE else self.start
        d, gbar, *_, rubbed = self.device.groups(self.parameter, at, ops)
        if self.parameter.bounces:
            return Level(Held.BOTH, gbar, None if rubbed is None else Friction(rubbed), d, self.parameter)
        if self.parameter is Parameter.INCLINATION:
            if rubbed is not None:
                raise UsageError("of a ball with friction motions along a sweep of the inclination are not known")
            return Level(Held.D, d)
        # Both groups go with 1/F, so that a sweep over the force holds their ratio; in a horizontal capsule it holds
        # gbar = 0.
        if self.parameter is Parameter.AMPLITUDE and gbar != 0:
            return Level(Held.RATIO, d / gbar, None if rubbed is None else Friction(0, rubbed / gbar))
        friction = None
        if rubbed is not None:
            friction = Friction(0, 0, rubbed / d) if self.parameter is Parameter.AMPLITUDE else Friction(rubbed)
        return Level(Held.GBAR, gbar, friction)

    def driven(self, what: str) -> Sweep:
        """The sweep itself, if it does not vary a restitution.

        Parameters
        ----------
        what : str
            What requires a constant restitution, for the message.

        Raises
        ------
        UsageError
            If it is one over a restitution.
        """
        if self.parameter.bounces:
            allowed = "allowed: length_m, amplitude_n, frequency_hz or inclination_deg"
            raise UsageError(f"along a sweep of {self.parameter} {what} is not known ({allowed})")
        return self

    @property
    def coordinate_range(self) -> tuple[float, float]:
        """Range of the coordinate that orders the sweep, see `coordinate_of`, ascending."""
        ends = self.coordinate_of(self.start), self.coordinate_of(self.end)
        return min(ends), max(ends)

    @property
    def unresolved(self) -> str:
        """Reason why double precision does not resolve the sweep, as a sentence; "" if it does."""
        device, (least, most) = self.device, sorted((self.start, self.end))
        if self.parameter.bounces:
            return device.with_values({self.parameter: most}).unresolved
        over_gbar = self.parameter is Parameter.INCLINATION
        if over_gbar:
            reason = device.too_short(self.parameter, most)
        else:  # d and gbar are largest at the least force, d at the largest length and frequency
            at = self.parameter, least if self.parameter is Parameter.AMPLITUDE else most
            reason = device.too_short(*at) or device.too_light(*at)
        low, high = self.coordinate_range
        finest = device.finest(FINEST_GBAR if over_gbar else FINEST_D)
        if not reason and high - low < finest:
            name = f"gbar = {device.weighed} g sin(beta)/F" if over_gbar else "d = s/x_c"
            reason = (
                f"over the sweep {name} only varies from {low:.6g} to {high:.6g}, which rounding does not resolve "
                f"(allowed: a range of at least {finest:.3g})"
            )
        return reason

    def coordinate_of(self, value: Arithmetic, ops: ExactFunctions = ARRAYS) -> Any:
        """The coordinate at a value of the parameter: d, gbar where the inclination varies, or a restitution itself."""
        if self.parameter.bounces:
            return ops.exact(value)
        d, gbar, *_ = self.device.groups(self.parameter, value, ops)
        return gbar if self.parameter is Parameter.INCLINATION else d

    def coordinate(self, orbit: Any) -> Any:
        """The coordinate of motions on the level."""
        if self.parameter.bounces:
            return value_in(orbit.restitution, self.parameter)
        return orbit.gbar if self.parameter is Parameter.INCLINATION else orbit.d

    def value(self, coordinate: Arithmetic, ops: ExactFunctions = ARRAYS) -> Any:
        """The parameter at a value of the coordinate; see `Device.value`."""
        if self.parameter.bounces:
            return coordinate
        return self.device.value(self.parameter, coordinate, coordinate, ops)
