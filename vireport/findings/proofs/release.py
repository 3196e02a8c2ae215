"""The trajectory of a ball that a membrane releases from rest, proved in ball arithmetic to enter a trapping region.

Neighbouring trajectories part by a factor of some million in ten impacts before they settle: the precision is raised
until enough of it is left at each impact. The scenario's doubles are taken as exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np
from msgspec.structs import replace

from vireport.findings.proofs.trap import Trap
from vireport.physics.affine import AFFINE_ROUNDING
from vireport.physics.device import Device
from vireport.physics.flight import Flight
from vireport.physics.groups import Groups
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM, check_model, follow_one
from vireport.simulation.kernel import FLIGHT, RIDING, SETTLING, TURN, WALL
from vireport.study.checks.confinement import stays_between
from vireport.study.checks.enclosures import Ball, BallOps, UnprovedError, ball, precision, prove

PRECISIONS = (256, 512, 1024, 2048)
"""Bits of the arithmetic, tried in this order."""

MOST_IMPACTS = 600
"""Impacts after which a ball that is in no region is given up."""


def reaches(
    device: Device, traps: Sequence[Trap], bits: Sequence[int] = PRECISIONS, wall: int = BOTTOM
) -> tuple[Trap, int, int]:
    """Prove that a ball that a membrane releases from rest enters one of some trapping regions.

    Parameters
    ----------
    device : Device
        With gbar below 1.
    traps : sequence of Trap
    bits : sequence of int
        Precisions tried one after the other.
    wall : int
        The membrane on which the ball lies: 1 bottom, -1 top.

    Returns
    -------
    trap : Trap
        The first region that the ball enters.
    impacts : int
        Number of impacts until then.
    bits : int
        Precision with which that is proved.

    Raises
    ------
    UnprovedError
        If that is not proved, with the reason.
    """
    for precision_bits in bits:
        try:
            with precision(precision_bits):
                return *_followed(device, traps, wall), precision_bits
        except UnprovedError as failure:
            reason = failure
    raise reason


def _followed(device: Device, traps: Sequence[Trap], wall: int) -> tuple[Trap, int]:
    """The first region that the released ball enters, and impacts until then, in the current precision.

    Raises
    ------
    UnprovedError
    """
    ops, at = BallOps(), (Parameter.LENGTH, device.length_m)
    groups, doubles = device.groups(*at, ops), device.groups(*at).as_floats()
    # Regions are proved for groups within a rounding of the doubles: the balls must be within it.
    for exactly, double in zip(groups.numbers, doubles.numbers, strict=True):
        if not abs(exactly - ball(double)) <= ball(AFFINE_ROUNDING) * abs(double):
            raise UnprovedError("rounding has moved the device by more than its regions allow for")
    # The ball is released at rest, in one exactly known state: no set is followed, only a point with a tiny error.
    # The pressing acceleration vanishes as the force falls at the bottom, and as it rises at the top.
    time, after = wall * (-groups.gbar).acos() / ops.pi, 0 * groups.gbar
    for impacts in range(1, MOST_IMPACTS + 1):
        before, end = _flight(groups, doubles, wall, time, after)
        wall, time = end, time + before.duration
        velocity = before.direction * before.speed(before.duration, (time).sin_pi(), ops.pi)
        for trap in traps:
            if wall == trap.motion.word.walls[0] and _holds(trap, time, velocity):
                return trap, impacts
        after = groups.after(wall, velocity)
        # A ball that contains 0 may be an impact or a miss.
        if not after * wall < 0:
            raise UnprovedError("an impact is too slow to be told from none")
    raise UnprovedError(f"it is not there after {MOST_IMPACTS} impacts")


def _flight(groups: Groups[Ball], doubles: Groups[float], wall: int, time: Ball, after: Ball) -> tuple[Flight, int]:
    """Enclose the flight that begins with an impact, and prove at which membrane it ends.

    Parameters
    ----------
    groups, doubles : Groups
        In balls and in doubles.
    wall : int
        The membrane that is left.
    time, after : Ball
        Of the impact [t_c], and velocity just after it [y_c]; zero of a ball that is released from rest.

    Raises
    ------
    UnprovedError
        If another impact, or none, is not ruled out.
    """
    ops, at_rest = BallOps(), bool(after == 0)
    phase = float(np.mod(pi * float(time.mid()), TURN)) % TURN
    start = (float(wall), 0.0, -float(after.mid()) / doubles.restitution_at(wall), phase)
    rows, _ = follow_one(check_model(doubles)[0], start, 1, compiled=False)
    if len(rows) < 2 or (not at_rest and rows[0, SETTLING] + rows[0, RIDING] > 0):
        raise UnprovedError("the ball comes to rest on a membrane, after infinitely many impacts")
    end, guess = int(rows[1, WALL]), float(rows[1, FLIGHT])
    sine, cosine = time.sin_cos_pi()
    way = Flight(-wall, after, sine, cosine, None, groups.gbar, groups.d)
    target = groups.d if end != wall else 0 * groups.d

    def missed(x: list[Ball]) -> list[Ball]:
        (t,) = x
        return [way.covered(t, way.turned(ops.sin(ops.pi * t), ops.cos(ops.pi * t))[1], ops.pi) - target]

    way = replace(way, duration=prove(missed, [guess], [guess]).box[0])
    arrival = way.speed(way.duration, (time + way.duration).sin_pi(), ops.pi)
    if not (arrival > 0 if end != wall else arrival < 0):
        raise UnprovedError("an impact is too slow to be told from none")
    # The ball leaves the membrane where the pressing acceleration is zero.
    if not stays_between(way, (None, True) if at_rest else None, end == wall):
        raise UnprovedError("an impact before the one that the simulation says is not ruled out")
    return way, end


def _holds(trap: Trap, time: Ball, velocity: Ball) -> bool:
    """Whether a state before an impact is surely in a region: |M x| <= radius for all of the ball."""
    whole = 2 * round((float(time.mid()) - float(trap.motion.time[0])) / 2)
    late, fast = time - whole - ball(float(trap.motion.time[0])), velocity - ball(float(trap.motion.velocity[0]))
    (a, b), (_, c) = ([ball(entry) for entry in row] for row in trap.metric.tolist())
    first, second = a * late + b * fast, c * fast
    return bool(first * first + second * second <= ball(trap.radius) ** 2)
