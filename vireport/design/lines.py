"""The lines in (d, gbar, r_b, r_t) on which inputs move a device, and where the motions that are followed there end.

Length and frequency move a device along a line of constant gbar, the force along a ray from the origin, and so does the
mass of a capsule that does not recoil. The inclination moves it along gbar, restitutions along r of both membranes
together or of one alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import Enum
from math import inf, log
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.motions.conditions import Condition
from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions
from vireport.motions.paths import Curve, PathPoint, follow
from vireport.motions.periodicity import Variation
from vireport.motions.switching import Limits, neighbours, off
from vireport.physics.device import FINEST_D, NO_GRAVITY, RESTITUTIONS, Device
from vireport.physics.groups import Groups, Restitution, Restitutions, SpeedLaw, map_restitution, stated
from vireport.physics.motion import Motion
from vireport.physics.numbers import FLOATS, Arithmetic, DecimalOps, DoubleOps
from vireport.scenario.parameters import DesignInput, Parameter

Floats = NDArray[np.float64]

HIGHEST_RESTITUTION = 0.99
"""Restitution up to which margins are looked for; no pair of materials has more."""

LOSES_STABILITY = frozenset({Event.PERIOD_DOUBLING, Event.FOLD, Event.PITCHFORK})
"""Events at which a motion goes on, but not as a stable one."""

HANDOVERS = 4
"""Largest number of pitchforks at which one motion takes over from another; no device has shown more than two."""


class Line(Enum):
    """Lines through a design point in (d, gbar, r_b, r_t), by the inputs that move a device along them.

    The position is 0 at the design point. Along the first four lines it is the logarithm of the factor of d, along the
    others the change of gbar, or of r at both membranes or one. The frequency has a line to itself where restitutions
    fall with speed, as it also changes the unit of that speed.
    """

    LENGTHS = DesignInput.LENGTH, DesignInput.FREQUENCY
    FREQUENCIES = (DesignInput.FREQUENCY,)
    FORCES = (DesignInput.AMPLITUDE,)
    MASSES = (DesignInput.CAPSULE_MASS,)
    GRAVITY = (DesignInput.INCLINATION,)
    RESTITUTION = (DesignInput.RESTITUTION,)
    RESTITUTION_BOTTOM = (DesignInput.RESTITUTION_BOTTOM,)
    RESTITUTION_TOP = (DesignInput.RESTITUTION_TOP,)

    @property
    def keeps_symmetry(self) -> bool:
        """Whether a device that is symmetric stays so on the line."""
        return self not in (Line.GRAVITY, Line.RESTITUTION_BOTTOM, Line.RESTITUTION_TOP)

    @staticmethod
    def sense(varied: DesignInput) -> float:
        """1 where an input grows with the position on its line, -1 where it falls."""
        return -1.0 if varied is DesignInput.AMPLITUDE else 1.0


LINES = tuple(Line)


class LineModel(Struct, frozen=True, eq=False):
    """How the groups of a device change along a line through it, in a kind of number.

    Attributes
    ----------
    line : Line
    origin : Groups
        Groups at the design point.
    ops
        Functions of the kind of number.
    capsule_share
        M over the mass that gravity acts on, `Device.supported_kg`.
    rubbed : tuple
        The coefficient of friction, and gbar of the upright device.
    """

    line: Line
    origin: Groups[Any]
    ops: DoubleOps | DecimalOps
    capsule_share: Any
    rubbed: tuple[Any, Any] = (0, 0)

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images everywhere on the line: no gravity along the capsule, and equal ends."""
        return self.origin.horizontal and self.line.keeps_symmetry

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """Groups of the device at a position on the line."""
        (position,), (d, gbar, r, harmonics, _) = varied, self.origin
        match self.line:
            case Line.LENGTHS:
                d = d * self.ops.exp(position)
            case Line.FREQUENCIES:
                d, r = d * self.ops.exp(position), _counted(r, self.ops.exp(position / 2))
            case Line.FORCES:
                grown = self.ops.exp(position)
                d, gbar, r = d * grown, gbar * grown, _counted(r, grown)
            case Line.MASSES:
                grown = self.ops.exp(position)
                d, gbar, r = d * grown, gbar * (1 + self.capsule_share * (grown - 1)), _counted(r, grown)
            case Line.GRAVITY:
                gbar = gbar + position
            case Line.RESTITUTION if not isinstance(r, SpeedLaw):
                r = map_restitution(r, lambda restitution: restitution + position)
            case _:
                bottom, top = stated(r)
                bottom = bottom if self.line is Line.RESTITUTION_TOP else bottom + position
                top = top if self.line is Line.RESTITUTION_BOTTOM else top + position
                r = replace(r, bottom=bottom, top=top) if isinstance(r, SpeedLaw) else Restitutions(bottom, top)
        return Groups(d, gbar, r, harmonics, self._friction(position))

    def _friction(self, position: Any) -> Any:
        """Friction at a position; it changes on the lines of force, mass and inclination."""
        friction = self.origin.friction
        if friction is None:
            return None
        match self.line:
            case Line.FORCES:
                return friction * self.ops.exp(position)
            case Line.MASSES:
                return friction * (1 + self.capsule_share * (self.ops.exp(position) - 1))
            case Line.GRAVITY:
                gbar = self.origin.gbar + position
                return self.rubbed[0] * self.ops.sqrt(self.rubbed[1] * self.rubbed[1] - gbar * gbar)
        return friction

    def _friction_slope(self, position: Any) -> Any:
        """Derivative of `_friction` by the position."""
        friction = self._friction(position)
        match self.line:
            case Line.FORCES:
                return friction
            case Line.MASSES:
                return self.capsule_share * self.origin.friction * self.ops.exp(position)
            case Line.GRAVITY:
                # Upright, friction vanishes with an infinite slope, which Newton's steps are spared.
                return -(self.rubbed[0] ** 2) * (self.origin.gbar + position) / friction if friction else 0.0
        return 0.0

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """Derivatives of `Groups.numbers` by the position, shape (4, 1), with further rows as below.

        Harmonics add zeros, a law of restitution zero for its exponent and the derivative of its speed; the last row is
        of friction, if there is any.
        """
        d, gbar, r, harmonics, friction = self.at(varied)
        slopes = [0.0] * (4 + 2 * len(harmonics))
        if isinstance(r, SpeedLaw):
            share = {Line.FREQUENCIES: 0.5, Line.FORCES: 1.0, Line.MASSES: 1.0}.get(self.line, 0.0)
            slopes += [0.0, share * r.speed]
        if friction is not None:
            slopes.append(self._friction_slope(varied[0]))
        match self.line:
            case Line.LENGTHS | Line.FREQUENCIES:
                slopes[0] = d
            case Line.FORCES:
                slopes[:2] = d, gbar
            case Line.MASSES:
                slopes[:2] = d, self.capsule_share * self.origin.gbar * self.ops.exp(varied[0])
            case Line.GRAVITY:
                slopes[1] = 1.0
            case Line.RESTITUTION:
                slopes[2:4] = 1.0, 1.0
            case Line.RESTITUTION_BOTTOM:
                slopes[2] = 1.0
            case Line.RESTITUTION_TOP:
                slopes[3] = 1.0
        return np.array(slopes)[:, None]


def _counted(r: Restitution | SpeedLaw, grown: Arithmetic) -> Any:
    """A restitution in a unit of velocity that is `grown` times smaller: a law states its speed in that unit."""
    return replace(r, speed=r.speed * grown) if isinstance(r, SpeedLaw) else r


def line_of(varied: DesignInput, device: Device) -> Line:
    """The line on which an input moves a device."""
    if varied is DesignInput.FREQUENCY and device.law is not None:
        return Line.FREQUENCIES
    return next(line for line in Line if varied in line.value)


def model_on_line(line: Line, device: Device, ops: DoubleOps | DecimalOps) -> LineModel:
    """The groups along a line through a device with all inputs, in a kind of number."""
    groups = device.groups(Parameter.LENGTH, device.length_m, ops)
    share = ops.exact(device.capsule_mass_kg) / ops.exact(device.supported_kg)
    rubbed: tuple[Any, Any] = 0, 0
    if device.rubs:
        upright = replace(device, inclination_deg=90.0).groups(Parameter.LENGTH, device.length_m, ops)
        rubbed = ops.exact(device.friction), upright.gbar
    return LineModel(line, groups.as_floats() if ops is FLOATS else groups, ops, share, rubbed)


def value_at(
    device: Device, varied: DesignInput, position: Any, groups: Groups[Any], ops: DoubleOps | DecimalOps
) -> Any:
    """Value of an input at a position on its line, where the device has the `groups`, in its unit."""
    value = ops.exact(device.value_of(varied))
    match varied:
        # d grows with s f^2: along one line, the frequency changes by half as much in the logarithm as the length.
        case DesignInput.FREQUENCY:
            return value * ops.exp(position / 2)
        case DesignInput.AMPLITUDE:
            return value * ops.exp(-position)
        case DesignInput.INCLINATION:
            return device.value(Parameter.INCLINATION, groups[0], groups[1], ops)
        case DesignInput.RESTITUTION | DesignInput.RESTITUTION_BOTTOM | DesignInput.RESTITUTION_TOP:
            return value + position
        case _:
            return value * ops.exp(position)


def reach(device: Device, varied: DesignInput) -> tuple[float, float]:
    """The values of an input between which ends of stable motion are looked for."""
    low, high = varied.limits
    if varied in RESTITUTIONS:
        # A device with a restitution beyond the usual limit is still looked at up to half the way to 1.
        value, bottom, top = device.value_of(varied), *stated(device.restitution)
        high = max(HIGHEST_RESTITUTION, (1 + value) / 2)
        if varied is DesignInput.RESTITUTION and not device.alike:
            # Both restitutions move alike, until one is at its limit.
            high = max(HIGHEST_RESTITUTION, (1 + max(bottom, top)) / 2) - abs(bottom - top) / 2
            low += abs(bottom - top) / 2
    return low, high


def extent(line: Line, device: Device, d: float, gbar: float) -> tuple[float, float]:
    """Least and largest position on a line up to which motions are followed.

    Motions are followed until rounding hides the length, to 0 and 90 degrees of inclination, and to the limits of r.
    """
    if line is Line.GRAVITY:
        upright = device.supported_kg * device.gravity_m_s2 / device.amplitude_n
        # Beyond 0 and 90 degrees the same capsules come again, mirrored. Without gravity the inclination moves
        # nothing.
        return (-gbar, upright - gbar if device.inclination_deg != 90 else 0.0) if upright > NO_GRAVITY else (0.0, 0.0)
    (varied, *_) = line.value
    if varied in RESTITUTIONS:
        (least, most), value = reach(device, varied), device.value_of(varied)
        return least - value, most - value
    return log(device.finest(FINEST_D) / d), inf


class LineCurve(Curve, frozen=True, eq=False, dict=True):
    """The motions of one word along a line, as a curve whose points are needed only to find their ends.

    Steps may be four times as long as for a family, whose points are drawn, and bend three times as much: a third of
    the work. The same changes of trace, velocities and gaps limit them. The points have errors of about the square of
    `settled`.
    """

    first, longest, sharpest = 0.05, 0.2, 0.3
    settled, resolved = 1e-6, 1e-12


class Ending(Struct, frozen=True, eq=False):
    """The end of a stable motion of a design point on a line: where it loses stability or stops being admissible.

    Attributes
    ----------
    line : Line
    inputs : tuple of DesignInput
        The inputs that move the device along the line.
    event : Event
        `SWEEP_END` where the line ends first, `LOST` where rounding does not resolve the motion any farther.
    x : ndarray
        Velocities [y_c] and times [t_c] of the impacts, and the position.
    symmetric : bool
        Whether the motion there is symmetric.
    taken_over : bool
        Whether another motion takes over its stability there, at a pitchfork.
    """

    line: Line
    inputs: tuple[DesignInput, ...]
    event: Event
    x: Floats
    symmetric: bool
    taken_over: bool = False


def mirrored(device: Device) -> bool:
    """Whether the motions of a device have mirror images."""
    level = device.inclination_deg == 0 and device.period_ratio % 2 == 1
    return bool(level and device.alike and all(harmonic.order % 2 for harmonic in device.harmonics))


class Followed(NamedTuple):
    """A stable motion to be followed along a line, with its asymmetry u = q - 1/2, zero for a symmetric motion."""

    motion: Motion
    u: float


def stable_ones(device: Device, motions: Motions) -> list[Followed]:
    """The stable ones of a device's 1:1 motions, to be followed along lines."""
    n = device.period_ratio
    return [Followed(motions.motion(int(row), n), float(motions.u[row])) for row in np.flatnonzero(motions.stable_mask)]


def endings(
    device: Device, followed: Sequence[Followed], lines: Sequence[Line], signs: Sequence[float]
) -> Iterator[Ending]:
    """Follow stable motions of a device along lines until each stops being stable or admissible.

    A motion of a horizontal capsule ends at a pitchfork. Where another takes over its stability there, that one is
    followed on, to where stable motion ends altogether.

    Parameters
    ----------
    device : Device
        With all inputs.
    followed : sequence of Followed
        Motions of the device.
    lines : sequence of Line
    signs : sequence of float
        Directions in which the position changes, 1 or -1.
    """
    d, gbar, *_ = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    for motion, u in followed:
        for line, inputs in _inputs_by_line(lines, device, gbar).items():
            low, high = extent(line, device, d, gbar)
            # Gravity breaks the symmetry, and so does the restitution of one membrane: along such a line a motion and
            # its mirror image part, and both are followed.
            flat = mirrored(device) and line.keeps_symmetry
            if flat and u < 0:
                continue  # the mirror image of another
            curve = LineCurve(motion.word, model_on_line(line, device, FLOATS), low, high, 1.0)
            for sign in signs:
                if (low if sign < 0 else high) != 0:
                    ends = ends_on_curve(curve, motion, sign, flat and u == 0)
                    yield from (Ending(line, inputs, *end) for end in ends)


def _inputs_by_line(lines: Sequence[Line], device: Device, gbar: float) -> dict[Line, tuple[DesignInput, ...]]:
    """The lines that are different for a device, with the inputs that move it along each."""
    inputs: dict[Line, tuple[DesignInput, ...]] = {line: line.value for line in lines}

    falls = device.law is not None
    if not falls:
        inputs.pop(Line.FREQUENCIES, None)
    elif Line.LENGTHS in inputs:
        inputs[Line.LENGTHS] = (DesignInput.LENGTH,)

    def same(line: Line, other: Line) -> None:
        """Make two lines one, of the inputs of both."""
        if line in inputs and other in inputs:
            inputs[line] += inputs.pop(other)

    if not device.recoils:
        same(Line.FORCES, Line.MASSES)  # by M/F alone
    if gbar == 0 and not falls:
        same(Line.LENGTHS, Line.FORCES)  # the ray from the origin is the line of gbar = 0
        same(Line.LENGTHS, Line.MASSES)
    return inputs


def continued(
    model: Variation, extent: tuple[float, float], stable: Sequence[Followed], ratio: int, flat: bool
) -> list[Followed]:
    """Continue the stable motions of a device while one of its groups grows from 0, and keep those that stay stable.

    Parameters
    ----------
    model : Variation
        How the groups depend on what grows.
    extent : tuple of float
        A position below 0, as room for a curve to begin, and the position at the end.
    stable : sequence of Followed
        The motions where it is 0.
    ratio : int
        Forcing periods of a motion.
    flat : bool
        Whether motions have mirror images all along.

    Returns
    -------
    list of Followed
        The motions that reach the end, as they are there.
    """
    left, (low, high) = [], extent
    for motion, u in stable:
        curve = LineCurve(motion.word, model, low, high, 1.0)
        *_, (event, x, symmetric, _taken_over) = ends_on_curve(curve, motion, 1.0, flat and u == 0)
        if event is Event.SWEEP_END:
            asymmetry = float(x[3] - x[2]) / (2 * ratio) - 0.5
            left.append(Followed(curve.motion(x), 0.0 if symmetric else asymmetry))
    return left


def ends_on_curve(
    curve: Curve, motion: Motion, sign: float, symmetric: bool
) -> Iterator[tuple[Event, Floats, bool, bool]]:
    """Follow a motion of a design point along a curve to its end, and past pitchforks to the end of stable motion.

    Parameters
    ----------
    curve : Curve
        Its coordinate is 0 at the design point.
    motion : Motion
    sign : float
        Direction of the coordinate, 1 or -1.
    symmetric : bool
        Whether the motion is symmetric all along.

    Yields
    ------
    Event, ndarray, bool, bool
        See `Ending`.
    """
    # Changes of the type of a stable motion alone are left out: they are a seventh of the work.
    curve = replace(curve, passed=(Condition(Event.PERIOD_DOUBLING),))
    x = curve.vector(replace(motion, coordinate=0.0))
    way = curve.tangent(x)
    start = PathPoint(curve, x, way if way[-1] * sign > 0 else -way)
    # Stability passes from symmetric to asymmetric motions at a pitchfork. The device goes on working, with other
    # voltages. Bounded, as two pitchforks could hand over to each other.
    for handovers in range(HANDOVERS):
        trail = follow(curve, start, LOSES_STABILITY)
        row, event = trail.events[-1]
        x = trail.points[row].x
        if event is not Event.PITCHFORK:
            break
        onward = _taking_over(curve, x, sign)
        if onward is None:
            yield event, x, True, False
            return
        if not handovers:
            yield event, x, True, True
        start, symmetric = onward, not symmetric
    yield event, x, symmetric, False


def _taking_over(curve: Curve, x: Floats, sign: float) -> PathPoint | None:
    """A point next to a pitchfork, on the branch that is stable beyond it; None where no branch is."""
    limits = Limits(len(curve.word), curve.word.periods)
    for _, _, vertex, first in neighbours(curve, curve.motion(x), Event.PITCHFORK, limits):
        # One of two mirror images begins to either side, and of the symmetric motions those that grow and those that
        # fall: which of them is first, rounding says.
        either = (first, *(start for _, start in off(curve, x, -vertex.tangent)))
        beyond = [asymmetric for asymmetric in either if (asymmetric.x[-1] - x[-1]) * sign > 0]
        if stable := [asymmetric for asymmetric in beyond if curve.stability(asymmetric.x).attracts]:
            return min(stable, key=lambda asymmetric: float(asymmetric.x[3] - asymmetric.x[2]))
    return None
