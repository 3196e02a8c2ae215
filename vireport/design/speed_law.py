"""Motions of a design whose restitution falls with speed, followed from motions with a constant restitution.

The exponent of the law grows from nothing. For constant restitutions all solutions are known. With the law, those that
come from them are found, and the motion that the device comes to when it is switched on; others, which only the law
has, are not looked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.lines import Followed, Line, continued, mirrored, model_on_line
from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions
from vireport.motions.paths import Curve, PathPoint, follow
from vireport.motions.polish import FARTHEST, Solved, in_decimals, solve_motion
from vireport.motions.switching import Limits, neighbours, off
from vireport.physics import flight
from vireport.physics.device import Device
from vireport.physics.groups import Groups, Restitutions, SpeedLaw, stated
from vireport.physics.motion import SAME, Motion
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter

Floats = NDArray[np.float64]

BEHIND = 0.01
"""Exponent on the other side of zero, as room for a curve that begins at exponent 0."""

AT_LIMIT = 1e-6
"""Relative distance from the largest restitution of a law below which an impact has it: there the law bends."""

PATIENCE = 4096
"""Number of impacts after which a ball from rest is not followed any longer: 26 ms, in the mean of 25 devices."""


class Solutions(Curve, frozen=True, eq=False, dict=True):
    """A curve of solutions of a word's equations: motions, and solutions that pass through a membrane in flight.

    On the way they need not be motions: a solution that is none at one exponent may be one at another.
    """

    def margins(self, x: Floats) -> list[float]:
        """Distances to both ends of the range, and velocities: all positive for a solution that is followed on."""
        return [float(x[-1]) - self.low, self.high - float(x[-1]), *self._speeds(x)]

    def is_motion(self, x: Floats) -> bool:
        """Whether the ball stays between the membranes in flight."""
        return min((turn.gap for turn in self.turns(x)), default=1.0) > 0


class Falling(Struct, frozen=True, eq=False):
    """A device whose restitution falls ever faster with speed, a `Variation` of its groups by minus the exponent.

    Attributes
    ----------
    origin : Groups
        Groups with the law.
    """

    origin: Groups[Any]

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images."""
        return self.origin.horizontal

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """The groups at minus an exponent of the law."""
        law: SpeedLaw = self.origin.restitution
        return self.origin._replace(restitution=replace(law, exponent=-varied[0]))

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """The derivatives of `Groups.numbers` by minus the exponent: (6, 1), of harmonics and friction zeros more."""
        slopes = np.zeros((len(self.origin.numbers), 1))
        slopes[-2 if self.origin.friction is None else -3] = -1.0
        return slopes


def constant(device: Device) -> Device:
    """The device with the constant restitutions that its law states."""
    bottom, top = stated(device.restitution)
    return replace(device, restitution=bottom if bottom == top else Restitutions(bottom, top))


def with_law(device: Device, stable: Sequence[Followed]) -> list[Followed]:
    """Continue the stable motions of a device's `constant` restitutions to its law, and keep those that stay stable.

    Parameters
    ----------
    device : Device
        With all inputs, its restitution a `SpeedLaw`.
    stable : sequence of Followed
        Stable motions with constant restitutions.
    """
    model = Falling(model_on_line(Line.LENGTHS, device, FLOATS).origin)
    most = -float(device.restitution.exponent)
    return continued(model, (-BEHIND, most), stable, device.period_ratio, mirrored(device))


class UnderLaw(Struct, frozen=True, eq=False):
    """The 1:1 motions of a device whose restitution falls with speed, as far as they are found.

    Attributes
    ----------
    motions : tuple of Solved
        The motions in decimals, with minus the exponent as the number that varies.
    restitutions : Restitutions
        Restitutions that the law gives at the impacts of each motion, as arrays.
    lost : int
        Number of motions that are not followed up to the law, because of rounding or as the law takes the restitution
        of an impact to its largest value, where it bends.
    """

    motions: tuple[Solved, ...]
    restitutions: Restitutions
    lost: int


def motions_under_law(device: Device, constant_ones: Motions) -> UnderLaw:
    """The 1:1 motions that come from the solutions of a device's `constant` restitutions, to the last digit.

    Each solution, stable or not, motion or not, is followed while the exponent grows, and so are the two that part from
    a symmetric one at a pitchfork. A further motion to which the device comes from rest is added, with those joined to
    it. Other motions that only the law has are missed.

    Parameters
    ----------
    device : Device
        With all inputs, its restitution a `SpeedLaw`.
    constant_ones : Motions
        At the design point with constant restitutions.

    Raises
    ------
    NumericalError
        If the law takes the restitution of an impact to its limit in a motion that is stable.
    """
    most, flat = -float(device.restitution.exponent), mirrored(device)
    word = Word.of("BT", device.period_ratio)
    # At exponent 0 the law is the constant restitutions: their solutions are where the curves begin.
    curve = Solutions(word, Falling(model_on_line(Line.LENGTHS, device, FLOATS).origin), -BEHIND, most, 1.0, ())
    starts = []
    for row in range(len(constant_ones)):
        x = curve.vector(constant_ones.motion(row, device.period_ratio))
        x[-1] = 0.0
        starts.append((_towards(curve, x, 1.0), flat and bool(constant_ones.u[row] == 0)))
    ends, lost = _followed(device, curve, starts)
    # Curves of the law alone do not reach exponent 0. One of them matters most: that to which the device comes.
    for x in _from_rest(curve, flat):
        motion = curve.motion(x)
        if _new(motion, ends) and not _at_limit(device, curve, x):
            symmetric = flat and motion.distance(motion.mirrored()) < SAME
            joined, _ = _followed(device, curve, [(_towards(curve, x, -1.0), symmetric)])
            ends.append((motion, symmetric))
            ends += [end for end in joined if _new(end[0], ends)]
    with in_decimals():
        solved = tuple(_solved(device, motion, symmetric) for motion, symmetric in ends)
        bottom, top = (
            np.array([float(solution.groups.rebound(wall, solution.x[i])[0]) for solution in solved])
            for i, wall in enumerate(word.walls)
        )
    return UnderLaw(solved, Restitutions(bottom, top, 1 - most), lost)


_End = tuple[Motion, bool]
"""A solution with the law, and whether it is symmetric."""


def _towards(curve: Curve, x: Floats, sign: float) -> PathPoint:
    """A point to follow a curve from, in the direction in which its coordinate grows (1) or falls (-1)."""
    way = curve.tangent(x)
    return PathPoint(curve, x, way if way[-1] * sign > 0 else -way)


def _new(motion: Motion, ends: Sequence[_End]) -> bool:
    """Whether a motion differs from all of some solutions."""
    return all(motion.distance(other) > SAME for other, _ in ends)


def _followed(device: Device, curve: Solutions, starts: list[tuple[PathPoint, bool]]) -> tuple[list[_End], int]:
    """The solutions with the law at the ends of curves from some starts, and the number of those lost on the way."""
    ends: list[_End] = []
    lost = 0
    # The list grows on the way by the asymmetric motions that begin at pitchforks.
    while starts:
        start, symmetric = starts.pop(0)
        trail = follow(curve, start)
        for at, event in trail.events:
            if event is Event.PITCHFORK and symmetric:
                starts += [(neighbour, False) for neighbour in _parted(curve, trail.points[at].x)]
        x, event = trail.points[-1].x, trail.events[-1][1]
        if event is Event.SWEEP_END and x[-1] < curve.high / 2:
            continue  # it has merged with another at a fold
        # At its limit the law bends, and its derivatives jump: what is solved for there may be no motion of the device.
        limited = _at_limit(device, curve, x)
        lost += event is Event.LOST or (limited and curve.is_motion(x))
        if event is Event.SWEEP_END and not limited and _new(curve.motion(x), ends):
            ends.append((curve.motion(x), symmetric))
    return ends, lost


def _from_rest(curve: Solutions, flat: bool) -> Iterator[Floats]:
    """The 1:1 motions that a ball released by the bottom membrane comes to, as unknowns of a curve."""
    from vireport.simulation.attractors import find_attractor
    from vireport.simulation.events import BOTTOM, Impact
    from vireport.simulation.release import presses

    groups = curve.model.at((curve.high,))
    for press in presses(groups):
        cycle = find_attractor(groups, Impact(BOTTOM, 0.0, press.release), PATIENCE, compiled=False).cycle
        if cycle is None or cycle.sticks:
            continue
        motion = cycle.motion(curve.high).canonical()
        for image in (motion, motion.mirrored().canonical()) if flat else (motion,):
            x = curve.at(curve.vector(image), curve.high) if image.word == curve.word else None
            if x is not None:
                yield x


def _parted(curve: Curve, x: Floats) -> Iterator[PathPoint]:
    """Points on the branches of asymmetric motions next to a pitchfork, of both mirror images."""
    for begins, _, vertex, first in neighbours(curve, curve.motion(x), Event.PITCHFORK, Limits(2, curve.word.periods)):
        if begins is Event.PITCHFORK:
            yield first
            yield from (neighbour for _, neighbour in off(curve, x, -vertex.tangent))


def _at_limit(device: Device, curve: Solutions, x: Floats) -> bool:
    """Whether the law takes the restitution of an impact of a motion to its limit, where it bends.

    Raises
    ------
    NumericalError
        If it does in a motion that is stable.
    """
    groups = curve.groups(x)
    for wall, velocity in zip(curve.word.walls, x, strict=False):
        r, slope = groups.rebound(wall, float(velocity))
        if r == slope or r > (1 - AT_LIMIT) * flight.LARGEST_RESTITUTION:
            if not (curve.stability(x).attracts and curve.is_motion(x)):
                return True
            speed = abs(velocity) * float(device.velocity_unit(Parameter.LENGTH, device.length_m))
            raise NumericalError(
                f"device.restitution_exponent: got {device.restitution.exponent:.6g}, with which the restitution of an "
                f"impact at {speed:.3g} m/s, of a stable motion, would be {flight.LARGEST_RESTITUTION} or more "
                "(allowed: an exponent nearer to 0, or a restitution that is stated at a lower speed)"
            )
    return False


def _solved(device: Device, motion: Motion, symmetric: bool) -> Solved:
    """A motion with the law of restitution, solved for in decimals."""
    exponent = device.restitution.exponent
    return solve_motion(
        lambda ops: Falling(model_on_line(Line.LENGTHS, device, ops).origin),
        motion,
        lambda x, groups, ops: x[-1] + ops.exact(exponent),
        symmetric,
        FARTHEST,
    )


def falling(device: Device, motions: Motions, exponent: float, speed_m_s: float | None = None) -> Device | None:
    """A device with restitutions that fall with the speed of the impact, equal to its constant ones at one speed.

    Parameters
    ----------
    device : Device
        With all inputs, its restitutions constant.
    motions : Motions
        Motions of the design point; the first stable one counts.
    exponent : float
        Exponent of the law, for both membranes alike.
    speed_m_s : float, optional
        Speed at which the restitutions are the device's [m/s]; by default the mean of both impacts of the motion.

    Returns
    -------
    Device or None
        None where restitutions fall with speed already, where one is zero, which has no law, or as large as the largest
        that a law gives, or where no motion is stable.

    Notes
    -----
    Both membranes have one speed: if alike they stay alike, and the bottom, which is struck faster, has the smaller r.
    """
    rows, bottom_top = np.flatnonzero(motions.stable_mask), stated(device.restitution)
    if not rows.size or device.law is not None or min(bottom_top) == 0 or max(bottom_top) >= flight.LARGEST_RESTITUTION:
        return None
    if speed_m_s is None:
        row = int(rows[0])
        mean = (abs(float(motions.velocity_bottom[row])) + abs(float(motions.velocity_top[row]))) / 2
        speed_m_s = mean * float(device.velocity_unit(Parameter.LENGTH, device.length_m))
    return replace(device, restitution=SpeedLaw(*bottom_top, exponent, speed_m_s))
