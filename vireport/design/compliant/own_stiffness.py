"""The stable motion of a design with the stiffness of its membranes, and the ends of that motion.

The rigid motion is followed to the scenario's stiffness by the return map of `return_map`, in a few hundredths of a
second, so that every report of a device with long contacts has it. The comparison of `compliance` follows the motion
over many stiffnesses and tries solvers on it, in seconds.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import copysign
from typing import NamedTuple

from msgspec import Struct

from vireport.base.records import brief
from vireport.design.compliant.descent import (
    MULTIPLIER,
    REPORTED,
    Absence,
    CompliantMotion,
    Missing,
    Rigid,
    descend,
    end_to_follow,
    motion_to_follow,
    rigid_motion,
)
from vireport.design.solution import Solution
from vireport.motions.events import Event
from vireport.motions.points import Point
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.physics.groups import by_wall
from vireport.scenario.parameters import ScalarInput

LEAST_RESTITUTION = 0.1
"""Least restitution that is followed: as it goes to 0, a contact needs ever more parts and lasts ever longer."""

TOO_LOSSY = Absence(Missing.NOT_FOLLOWED, f"restitutions below {LEAST_RESTITUTION} are not followed")
"""The absence of a motion whose ball is damped so strongly that its contacts are not integrated to the stated error."""


class RigidEnd(NamedTuple):
    """An end of stable motion with rigid membranes, to be followed to compliant ones.

    Attributes
    ----------
    parameter : DesignInput or Parameter
        The input that varies.
    point : Point
        The critical point.
    swept : bool
        Whether it ends a stable range of the sweep.
    """

    parameter: ScalarInput
    point: Point
    swept: bool


class StabilityEnd(Struct, frozen=True, eq=False):
    """An end of stable motion with rigid membranes and its counterpart with compliant ones.

    Attributes
    ----------
    parameter : DesignInput or Parameter
        The input that varies.
    point : Point
        The critical point with rigid membranes.
    design_value : float or None
        Value of the input at the design point; None without a design point.
    swept : bool
        Whether it ends a stable range of the sweep.
    compliant : float or None
        Value of the input at the counterpart; None where there is none, or none is known.
    error : float
        Estimate of the error of that value, in the unit of the input.
    absence : Absence or None
        Why there is no counterpart.
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
        """Distance in the input between the rigid and the compliant end; 0 where there is no compliant one."""
        return 0.0 if self.compliant is None else abs(self.compliant - self.rigid)

    @property
    def rigid_margin(self) -> float | None:
        """Distance of the design point from the end with rigid membranes, over its value, positive."""
        return self._margin(self.rigid)

    @property
    def compliant_margin(self) -> float | None:
        """The margin with compliant membranes: negative where the end is on the other side of the design point."""
        return None if self.compliant is None else self._margin(self.compliant)

    def _margin(self, end: float) -> float | None:
        at = self.design_value
        # Positive where the end is on the side of the design point on which the rigid one is.
        return None if not at else copysign(1.0, self.rigid - at) * (end - at) / abs(at)


class OwnStiffness(Struct, frozen=True, eq=False):
    """The stable motion and its ends with membranes of the scenario's stiffness.

    Attributes
    ----------
    rigid : Rigid
        The motion that is followed from rigid membranes.
    at_design : bool
        Whether that motion is at the design point.
    motion : CompliantMotion or None
        Its compliant counterpart; None where there is none, or none is known.
    absence : Absence or None
        Why there is no counterpart.
    ends : tuple of StabilityEnd
        The ends of the sweep's stable ranges, ascending, and then those nearest to the design point.
    """

    rigid: Rigid
    at_design: bool
    motion: CompliantMotion | None
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
        """The end at a critical point when an input varies; None where it was not followed."""
        same = (end for end in self.ends if end.parameter == parameter and end.rigid == point.sweep_value)
        return next(same, None)


def own_stiffness(solution: Solution) -> OwnStiffness | None:
    """Follow the stable motion and its ends from rigid membranes to those of the scenario.

    None without a ball mass, or if no 1:1 motion is stable.

    Raises
    ------
    UsageError
        If the ball has friction or a restitution that depends on speed, which long contacts are not computed with.
    """
    solution.device.plain_ball("what long contacts change")
    membrane, chosen = solution.membrane, rigid_motion(solution)
    if membrane is None or chosen is None:
        return None
    rigid, device = chosen
    at_design = solution.design is not None and bool(solution.design.motions.stable_mask.any())
    # The ends first: where the motion is lost, a fold that has passed the design point says why.
    ends = tuple(_end(device, membrane, end, at_design) for end in _rigid_ends(solution))
    if min(by_wall(device.restitution)) < LEAST_RESTITUTION:
        return OwnStiffness(rigid, at_design, None, TOO_LOSSY, ends)
    (followed,) = descend(motion_to_follow(device, membrane, rigid), [1.0], REPORTED)
    if not isinstance(followed, Absence):
        return OwnStiffness(rigid, at_design, followed.motion, None, ends)
    # Two motions that meet at a fold are not there beyond it.
    passed = [end for end in ends if end.point.event is Event.FOLD and (end.compliant_margin or 0.0) < 0]
    if at_design and passed:
        followed = Absence(Missing.LOST, "it ends at a fold before the design point")
    return OwnStiffness(rigid, at_design, None, followed, ends)


def _rigid_ends(solution: Solution) -> Iterator[RigidEnd]:
    """Ends of the sweep's stable ranges, and the design point's nearest limit and nearest end of stability."""
    swept = [point for part in solution.stable_ranges for _, point in part.ends if point is not None]
    for point in swept:
        yield RigidEnd(solution.parameter, point, True)
    if solution.design is not None and solution.design.motions.stable_mask.any():
        nearest = [
            margin for margins in (solution.design.limits(), solution.design.endings()) for margin in margins[:1]
        ]
        # The nearest limit may be the nearest end of stability, and an end of the sweep's range as well: once each.
        for margin in {margin.point: margin for margin in nearest}.values():
            if not any(margin.point is point for point in swept):
                yield RigidEnd(margin.parameter, margin.point, False)


def _end(device: Device, membrane: Membrane, end: RigidEnd, at_design: bool) -> StabilityEnd:
    """Follow an end of stable motion from rigid membranes to those of the scenario."""
    varied, point, swept = end
    design_value = float(device.value_of(varied)) if at_design else None
    absence = TOO_LOSSY if min(by_wall(device.restitution)) < LEAST_RESTITUTION else None
    if point.event not in MULTIPLIER:
        absence = Absence(Missing.NOT_FOLLOWED, f"a {point.event.words} is not followed")
    if absence is not None:
        return StabilityEnd(varied, point, design_value, swept, None, 0.0, absence)
    (followed,) = descend(end_to_follow(device, membrane, varied, point), [1.0], REPORTED)
    if isinstance(followed, Absence):
        return StabilityEnd(varied, point, design_value, swept, None, 0.0, followed)
    return StabilityEnd(varied, point, design_value, swept, float(followed.x[2]), float(followed.errors[2]), None)
