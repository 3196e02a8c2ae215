"""How far effects that the model neglects would move the nearest end of stable motion.

With each effect a design is another device. Along the input in which the design is nearest to an end of stable motion,
the stable motions of that device are followed to where they end, as those of the design are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from math import copysign, hypot, inf

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import NumericalError
from vireport.base.records import brief
from vireport.design.distortion import with_friction
from vireport.design.distortion import with_harmonic as followed_with
from vireport.design.lines import (
    LINES,
    Ending,
    Followed,
    Line,
    endings,
    line_of,
    mirrored,
    model_on_line,
    reach,
    stable_ones,
    value_at,
)
from vireport.design.margins import Margin
from vireport.design.point import DesignPoint
from vireport.design.sensitivity import UNSURE
from vireport.design.speed_law import constant, falling, with_law
from vireport.motions.events import Event
from vireport.motions.pointwise import find_motions
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic, with_harmonic
from vireport.physics.groups import Groups, stated
from vireport.physics.numbers import FLOATS
from vireport.scenario.blocks import CapsuleMotion, EffectBlock, LeftOut
from vireport.scenario.parameters import DesignInput, Parameter

RETREATS = 0.0, 0.02, 0.05, 0.1, 0.2
"""Shares of the design value by which a device is moved away from the end, until it has stable motion to follow."""

LOCATED = 1e-12
"""Relative difference of the values of two ends, located in doubles, below which they are the same."""


SECOND = 2
"""Order of the harmonic that is tried."""

SAME_DEVICE = 4
"""Decimals of the groups up to which two phases of a harmonic make one device."""

ALIKE = 0.25
"""Relative difference of the faster impact's speed up to which two ends may be one; 5 % of restitution makes 5 %."""


class Effect(Struct, frozen=True):
    """A physical effect that the model neglects, of an assumed size.

    Attributes
    ----------
    left_out : LeftOut
    size : float
        Relative change of a restitution, share of a harmonic in the force, exponent of a restitution that falls with
        speed, or coefficient of friction; 0 for an effect without a size.
    speed_m_s : float or None
        Speed of impact at which a restitution that falls with speed is as stated [m/s]; None for the mean speed of the
        design's motion.
    """

    left_out: LeftOut
    size: float = 0.0
    speed_m_s: float | None = None

    @staticmethod
    def requested(blocks: Sequence[EffectBlock] | None) -> tuple[Effect, ...]:
        """The effects that a scenario asks for; the usual ones where it names none."""
        if blocks is None:
            return USUAL
        sizes = ((block.percent or 0.0) / 100 + (block.exponent or 0.0) for block in blocks)  # it has one of the two
        return tuple(Effect(block.effect, size, block.speed_m_s) for block, size in zip(blocks, sizes, strict=True))


class Unmoved(StrEnum):
    """Reasons for which an end of stable motion has no counterpart with an effect."""

    NOT_STABLE = "no stable motion is found with it"
    ENDLESS = "stable motion does not end in this direction with it"
    NOT_FOLLOWED = "stable motion is not followed to its end with it"
    STOPS = "with it the ball stops between two impacts, where its motion is not followed"
    NO_MOTION = "no 1:1 motion is stable at the design point"
    NO_END = "no end of the stable motion is known"


class Shift(Struct, frozen=True):
    """The nearest end of stable motion with an effect, and how far that has moved it.

    Attributes
    ----------
    effect : Effect
    value : float or None
        Value of the input at the end; None where there is no end, or it was not located.
    event : Event or None
        The event at the end.
    moved : float or None
        The value less the one without the effect.
    relative : float or None
        `moved` over the value without the effect.
    left : float or None
        The margin that is left, over the design value: negative where the end has passed the design point.
    absence : Unmoved or None
        Why there is no end.
    least : float or None
        The least margin in any input over its design value, 0 without stable motion and infinite without an end; None
        where only the nearest end was followed, or it was not located. A stop of a ball with friction counts as an end.
    """

    effect: Effect
    value: float | None = None
    event: Event | None = None
    moved: float | None = None
    relative: float | None = None
    left: float | None = None
    absence: Unmoved | None = None
    least: float | None = None

    __repr__ = brief

    @property
    def room(self) -> float:
        """The margin that is left; infinite where there is no end, minus infinity where there is no stable motion."""
        endless = inf if self.absence in (Unmoved.ENDLESS, Unmoved.NOT_FOLLOWED) else -inf
        return endless if self.left is None else self.left

    @property
    def computed(self) -> bool:
        """Whether the design point was solved with the effect, so that its stable motion, or none, is certain."""
        return self.absence is not Unmoved.STOPS

    @property
    def stable(self) -> bool:
        """Whether the design point was shown to have stable motion with the effect."""
        return self.room > 0


class Shifts(Struct, frozen=True, eq=False):
    """Shifts of the nearest end of stable motion of a design by each effect.

    Attributes
    ----------
    end : Margin or None
        The nearest end; None where there is none.
    rows : tuple of Shift
        With each effect that applies to the device.
    absence : Unmoved or None
        Why there is no end.
    """

    end: Margin | None
    rows: tuple[Shift, ...] = ()
    absence: Unmoved | None = None

    __repr__ = brief

    @property
    def worst(self) -> Shift | None:
        """The effect that leaves the least margin."""
        computed = (shift for shift in self.rows if shift.computed)
        return min(computed, key=lambda shift: shift.room, default=None)


def _of_restitution(varied: DesignInput) -> Callable[[Device, float, Margin], Sequence[Device]]:
    """The function that changes a device's restitution at one membrane, see `CHANGES`."""

    def changed(device: Device, size: float, _: Margin) -> Sequence[Device]:
        """The device with that restitution, relatively changed by a size."""
        value = float(device.value_of(varied))
        return [device.with_values({varied: value * (1 + size)})] if value else ()

    return changed


def _of_capsule(device: Device, _: float, __: Margin) -> Sequence[Device]:
    """The device with the other motion of its capsule: free instead of prescribed, or the other way round."""
    if device.ball_mass_kg is None:
        return ()
    other = CapsuleMotion.PRESCRIBED if device.recoils else CapsuleMotion.FREE
    return [replace(device, capsule=other)]


def _of_harmonic(device: Device, size: float, end: Margin) -> Sequence[Device]:
    """Devices with a second harmonic at the phase that moves the end fastest, or at four phases if that is unknown."""
    slopes = end.by_harmonics.get(SECOND)
    parts = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]
    if mirrored(device):
        parts = parts[:2]  # the opposite ones are mirror images of these, and so are the motions
    if slopes is not None and (steepest := hypot(*slopes)) > 0:
        towards = -copysign(1.0, end.distance) / steepest
        parts = [(towards * slopes[0], towards * slopes[1])]
    more = (Harmonic(SECOND, size * cosine, size * sine) for cosine, sine in parts)
    return [replace(device, harmonics=with_harmonic(device.harmonics, amplitude)) for amplitude in more]


def _of_friction(device: Device, size: float, _: Margin) -> Sequence[Device]:
    """The device with more friction; none if a restitution is zero, or if the capsule is upright, without friction."""
    rubbed = replace(device, friction=device.friction + size)
    return [rubbed] if rubbed.rubs and min(stated(device.restitution)) > 0 else ()


CHANGES: Mapping[LeftOut, Callable[[Device, float, Margin], Sequence[Device]]] = {
    LeftOut.RESTITUTION_BOTTOM: _of_restitution(DesignInput.RESTITUTION_BOTTOM),
    LeftOut.RESTITUTION_TOP: _of_restitution(DesignInput.RESTITUTION_TOP),
    LeftOut.CAPSULE: _of_capsule,
    LeftOut.SECOND_HARMONIC: _of_harmonic,
    LeftOut.FRICTION: _of_friction,
}
"""Functions from a device, the size of an effect and the nearest end to the devices with that effect, of which the
worst counts; none where it does not apply."""

USUAL = (
    Effect(LeftOut.RESTITUTION_BOTTOM, -UNSURE),
    Effect(LeftOut.RESTITUTION_TOP, -UNSURE),
    Effect(LeftOut.CAPSULE),
    Effect(LeftOut.SECOND_HARMONIC, 0.02),
    Effect(LeftOut.FRICTION, 0.05),
    Effect(LeftOut.RESTITUTION_SPEED, -0.1),
)
"""Effects that are tried on every design."""


def shifts(
    device: Device, design: DesignPoint, effects: Sequence[Effect] = USUAL, in_any_input: bool = False
) -> Shifts:
    """Follow the nearest end of stable motion of a design with each of some effects.

    Parameters
    ----------
    device : Device
        With all four parameters.
    design : DesignPoint
        Of that device.
    effects : sequence of Effect
        The effects to follow.
    in_any_input : bool
        Whether the least margin in any input is searched for with each effect, too.

    Raises
    ------
    NumericalError
        If rounding does not resolve where stable motion ends along an input, where all inputs are followed.
    """
    end = next((margin for margin in design.endings() if margin.relative is not None), None)
    if end is None:
        return Shifts(None, absence=Unmoved.NO_END if design.motions.stable_mask.any() else Unmoved.NO_MOTION)
    rows, origin = [], _Origin(device, stable_ones(device, design.motions))
    for effect in effects:
        changed = _changed(device, design, effect, end)
        # In a level capsule its recoil changes no group: devices with the same groups have the same end.
        listed = [
            _followed(other, origin, end, effect)
            if _groups(other) != _groups(device)
            else shift_to(effect, end, end.sweep_value, end.event, float(device.value_of(end.parameter)))
            for other in changed
        ]
        if listed:
            shift = min(listed, key=lambda shift: shift.room)
            least = _least_with(origin, design, effect) if in_any_input else None
            # Up to a stop of the ball stable motion is certain; with a stop at the design point nothing is certain.
            rows.append(replace(shift, least=least if shift.computed or least else None))
    return Shifts(end, tuple(rows))


class _Origin(Struct, frozen=True, eq=False):
    """The device without effects, and its stable motions at the design point."""

    device: Device
    stable: Sequence[Followed]


def _changed(device: Device, design: DesignPoint, effect: Effect, end: Margin) -> Sequence[Device]:
    """The device with an effect, or several devices of which the worst counts, see `CHANGES`."""
    if effect.left_out is LeftOut.RESTITUTION_SPEED:
        other = falling(device, design.motions, effect.size, effect.speed_m_s)
        return () if other is None else [other]
    return CHANGES[effect.left_out](device, effect.size, end)


def _least_with(origin: _Origin, design: DesignPoint, effect: Effect) -> float:
    """The least margin in any input with an effect; for a harmonic, at the phases that are worst for each end."""
    changed = (other for end in design.limits() for other in _changed(origin.device, design, effect, end))
    differing = {tuple(np.round(_groups(other).numbers, SAME_DEVICE)): other for other in changed}
    return min(_least_margin(other, origin) for other in differing.values())


def _least_margin(device: Device, origin: _Origin) -> float:
    """The least margin of a device in any input, over its design value; 0 without motion, infinite without an end."""
    followed, shares = _followed_to(device, origin), [inf]
    if not followed:
        return 0.0
    for end in endings(device, followed, LINES, (-1.0, 1.0)):
        # A law that bends at the largest restitution is followed no farther: that counts as an end.
        if end.event is Event.LOST and device.law is None:
            raise NumericalError(f"rounding does not resolve where stable motion ends along {', '.join(end.inputs)}")
        for varied in end.inputs if end.event is not Event.SWEEP_END else ():
            value = float(device.value_of(varied))
            shares += [abs(_value(device, varied, end) - value) / value] if value else []
    return min(shares)


def _groups(device: Device) -> Groups[float]:
    """Dimensionless groups of a device with all inputs."""
    return device.groups(Parameter.LENGTH, device.length_m).as_floats()


def shift_to(effect: Effect, end: Margin, value: float, event: Event, design_value: float) -> Shift:
    """The shift of an end to a value, the input being `design_value` at the design point."""
    if abs(value - end.sweep_value) <= LOCATED * abs(value):
        value = end.sweep_value
    moved, way = value - end.sweep_value, copysign(1.0, end.distance)
    return Shift(effect, value, event, moved, moved / end.sweep_value, way * (value - design_value) / abs(design_value))


def _followed(device: Device, origin: _Origin, end: Margin, effect: Effect) -> Shift:
    """Shift of the nearest end of a design by an effect, by following the stable motions of the changed device.

    Parameters
    ----------
    device : Device
        The device with the effect.
    origin : _Origin
        The device without it.
    end : Margin
        The nearest end of the design.
    effect : Effect
    """
    varied, design_value = end.parameter, float(device.value_of(end.parameter))
    way, (low, high) = copysign(1.0, end.distance), reach(device, varied)
    followed: Sequence[_End] | None = None
    for retreat in RETREATS:
        value = design_value - way * retreat * abs(design_value)
        at = device.with_values({varied: value})
        if not low <= value <= high or at.unresolved:
            break
        ends = _ends(at, origin, varied, way)
        followed = ends if not retreat else followed
        if (same := next((other for other in ends or () if other.becomes_of(end)), None)) is not None:
            return shift_to(effect, end, same.value, same.event, design_value)
        if ends and ends[0].event is Event.STOP:
            # The motion may go on beyond the stop, as it does without friction: where it then ends is unknown.
            return Shift(effect, absence=Unmoved.STOPS)
    # The motion that ended there is gone, or ends otherwise: gravity and one membrane alone make a fold of a pitchfork.
    if followed is None:
        stops = effect.left_out is LeftOut.FRICTION
        return Shift(effect, absence=Unmoved.STOPS if stops else Unmoved.NOT_STABLE)
    if not followed:
        return Shift(effect, absence=Unmoved.ENDLESS)
    if followed[0].event is Event.LOST:
        return Shift(effect, absence=Unmoved.NOT_FOLLOWED)
    return shift_to(effect, end, followed[0].value, followed[0].event, design_value)


class _End(Struct, frozen=True):
    """An end of stable motion along an input, located in doubles: the size of an effect has a few digits.

    Attributes
    ----------
    value : float
        Value of the input.
    event : Event
    speed : float
        Speed of the faster impact [y_c].
    """

    value: float
    event: Event
    speed: float

    def becomes_of(self, end: Margin) -> bool:
        """Whether this end continues another one: of the same kind, with a faster impact of about the same speed."""
        closed = end.point.closed
        speed = max(abs(closed.velocity_bottom), abs(closed.velocity_top))
        return self.event is end.event and abs(self.speed - speed) <= ALIKE * speed


def _ends(device: Device, origin: _Origin, varied: DesignInput, way: float) -> Sequence[_End] | None:
    """Ends of the stable motions of a device in one direction of an input, nearest first; None without any motion.

    A motion that rounding does not let follow to its end counts as ending there, with the event `LOST`.
    """
    followed = _followed_to(device, origin)
    if not followed:
        return None
    line, ends = line_of(varied, device), []
    for end in endings(device, followed, [line], (Line.sense(varied) * way,)):
        if varied in end.inputs and end.event is not Event.SWEEP_END and not end.taken_over:
            event = Event.GRAZING if end.event is Event.ZERO_VELOCITY else end.event
            ends.append(_End(_value(device, varied, end), event, float(np.abs(end.x[:2]).max())))
    return sorted(ends, key=lambda end: way * end.value)


def _followed_to(device: Device, origin: _Origin) -> Sequence[Followed]:
    """The stable motions of a changed device."""
    # Motions of a sine are followed to a force with a harmonic twenty times as fast as they are solved for, and those
    # of a ball without friction, and of restitutions that do not fall with speed, to one with it and to those that do.
    design, falls = origin.device, device.law is not None
    base, force = constant(device) if falls else device, device.harmonics if design.harmonics else ()
    plain = replace(base, harmonics=force, friction=design.friction)
    same = plain == design
    followed = origin.stable if same else _stable_ones(plain)
    if base.friction != plain.friction:
        followed = with_friction(plain, followed, base.friction)
    for harmonic in base.harmonics if not force else ():
        followed = followed_with(replace(plain, friction=base.friction), followed, harmonic)
    return with_law(device, followed) if falls else followed


def _stable_ones(device: Device) -> Sequence[Followed]:
    """The stable motions of a device in doubles, in which they are followed."""
    n, points = device.period_ratio, _groups(device).map_numbers(lambda number: np.array([number]))
    motions = find_motions(points, n)
    rows = np.flatnonzero(motions.stable(points.restitution)).tolist()
    return [Followed(motions.motion(row, n), float(motions.orbit.u[row])) for row in rows]


def _value(device: Device, varied: DesignInput, end: Ending) -> float:
    """Value of an input, in its unit, at the end of a motion on a line."""
    position = float(end.x[-1])
    groups = model_on_line(end.line, device, FLOATS).at((position,))
    return float(value_at(device, varied, position, groups, FLOATS))
