"""A stable motion of any word at a design point, and the values of an input around it at which it stays stable."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, log, pi

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.design.lines import LOSES_STABILITY, Line, extent, line_of, model_on_line, value_at
from vireport.motions.error_bounds import point_bounds
from vireport.motions.events import Event
from vireport.motions.paths import Curve, PathPoint, follow
from vireport.motions.stability import STABILITIES, Stability, classify
from vireport.physics.device import Device
from vireport.physics.motion import Motion, multipliers
from vireport.physics.numbers import FLOATS, UNIT
from vireport.scenario.parameters import DesignInput, Parameter

FARTHEST = log(10)
"""Position along lines of lengths, frequencies, forces and masses up to which motions are followed: a motion that
strikes the bottom alone exists at any greater length."""


class FollowedMotion(Struct, frozen=True, eq=False):
    """A stable motion of any word, and the range of an input over which it exists and is stable.

    Attributes
    ----------
    motion : Motion
        Solved by its equations.
    trace : float
        Trace of its return map's Jacobian.
    decay : float
        Root of the determinant of that Jacobian.
    varied : DesignInput
    velocity_error, time_error : ndarray (N,)
        Error bounds of the velocities [y_c] and times [t_c] of its impacts; inf where there is none.
    low, high : float
        Values of the input between which the motion exists and is stable, in the unit of the input.
    below, above : Event
        Events at these ends; `SWEEP_END` where it is followed no farther, `LOST` where rounding does not resolve it.
    """

    motion: Motion
    trace: float
    decay: float
    varied: DesignInput
    velocity_error: NDArray[np.float64]
    time_error: NDArray[np.float64]
    low: float
    high: float
    below: Event
    above: Event

    __repr__ = brief

    @property
    def name(self) -> str:
        """Word and period of the motion."""
        return self.motion.word.name

    @property
    def phase_error(self) -> NDArray[np.float64]:
        """Error bounds of the phases of its impacts [rad], by those of the times and four roundings."""
        return np.asarray(pi * self.time_error + 4 * UNIT * (1 + np.abs(pi * self.motion.time)))

    @property
    def stability(self) -> Stability:
        """Type of the motion's stability."""
        return STABILITIES[int(classify(self.trace, self.decay))]

    @property
    def ends(self) -> tuple[str, str]:
        """Events that end the stable motion below and above, in words."""
        return _words(self.below), _words(self.above)

    @property
    def growth(self) -> float:
        """Modulus of the larger multiplier: share of a small disturbance that is left after a period of the motion."""
        return abs(self.multipliers[0])

    @property
    def multipliers(self) -> tuple[complex, complex]:
        """Eigenvalues of the return map's Jacobian, the one of larger modulus first."""
        larger, smaller = multipliers(self.trace, self.decay**2).tolist()
        return larger, smaller


def followed_motion(device: Device, motion: Motion, varied: DesignInput) -> FollowedMotion | None:
    """Solve for a motion that another search came to, and follow it to both sides along an input.

    Parameters
    ----------
    device : Device
        With all inputs.
    motion : Motion
        At the design point, to some digits.
    varied : DesignInput

    Returns
    -------
    FollowedMotion or None
        None where the equations have no such motion, or it is not stable; and where the restitution is zero, so that
        impacts forget the velocity before: motions are then isolated, and no curve leads from one to the next.
    """
    if device.restitution == 0:
        return None
    line = line_of(varied, device)
    d, gbar, *_ = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    least, most = extent(line, device, d, gbar)
    if line in (Line.LENGTHS, Line.FREQUENCIES, Line.FORCES, Line.MASSES):
        least, most = max(least, -FARTHEST), min(most, FARTHEST)
    curve = Curve(motion.word, model_on_line(line, device, FLOATS), least, most, 1.0)
    x = curve.at(curve.vector(replace(motion, coordinate=0.0)), 0.0)
    # Without the distances to both ends: a horizontal capsule is at the least inclination.
    if x is None or min(curve.margins(x)[2:]) <= 0 or not curve.stability(x).attracts:
        return None
    way, ends = curve.tangent(x), []
    for sign in (-Line.sense(varied), Line.sense(varied)):
        # A line that ends where the design point is has nothing to be followed on that side.
        position, event = 0.0, Event.SWEEP_END
        if (least if sign < 0 else most) != 0:
            trail = follow(curve, PathPoint(curve, x, way if way[-1] * sign > 0 else -way), LOSES_STABILITY)
            row, event = trail.events[-1]
            position = float(trail.points[row].x[-1])
        value = value_at(device, varied, position, curve.model.at((position,)), FLOATS)
        ends.append((float(value), event))
    (low, below), (high, above) = ends
    bounds = point_bounds(curve, x)
    return FollowedMotion(curve.motion(x), curve.trace(x), curve.decay(x), varied, *bounds, low, high, below, above)


class MotionEnd(Struct, frozen=True):
    """Where a followed motion ends in one input.

    Attributes
    ----------
    varied : DesignInput
    value : float
        Value of the input, in its unit.
    event : Event
    relative : float or None
        Distance from the design value, over it; None where the design value is zero.
    """

    varied: DesignInput
    value: float
    event: Event
    relative: float | None

    @property
    def size(self) -> float:
        """The relative distance without its sign; inf where there is none."""
        return inf if self.relative is None else abs(self.relative)


def followed_on_bottom(device: Device, motion: Motion) -> tuple[FollowedMotion, ...]:
    """Follow a stable motion on the bottom along every input that it depends on; () where `followed_motion` has none.

    On a table it does not depend on the length nor on the restitution at the top. It does on the frequency: the ball
    comes to the top where the frequency is low.
    """
    of_top = (DesignInput.LENGTH, DesignInput.RESTITUTION_TOP)
    of_bottom = DesignInput.RESTITUTION_BOTTOM if device.alike else DesignInput.RESTITUTION
    inputs = (varied for varied in DesignInput if varied not in (*of_top, of_bottom))
    ranges = (followed_motion(device, motion, varied) for varied in inputs)
    return tuple(followed for followed in ranges if followed is not None)


def motion_ends(device: Device, ranges: Iterable[FollowedMotion]) -> list[MotionEnd]:
    """Where a motion ends by any event in the inputs along which it was followed, nearest first."""
    ends = []
    for followed in ranges:
        at = float(device.value_of(followed.varied))
        for value, event in ((followed.low, followed.below), (followed.high, followed.above)):
            if event not in (Event.SWEEP_END, Event.LOST):
                ends.append(MotionEnd(followed.varied, value, event, value / at - 1 if at else None))
    return sorted(ends, key=lambda end: end.size)


def _words(end: Event) -> str:
    """The event that ends a motion, in words."""
    return "followed no farther" if end in (Event.SWEEP_END, Event.LOST) else end.words
