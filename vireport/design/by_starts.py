"""Motions that a few starts in flight come to: where none is known that is stable, and none is reached from rest.

A start that a motion attracts need not have settled on it: its impacts nearly repeat, and Newton's method on the
simulated map then finds the motion and its multipliers.
"""

from __future__ import annotations

from collections.abc import Iterator

from vireport.physics.groups import Groups
from vireport.simulation.cycles import SimulatedMotion, attracting
from vireport.simulation.events import check_model
from vireport.simulation.follower import Trajectory
from vireport.simulation.starts import even_starts, start_speed

FEW = 6, 48
"""Starts and impacts of each without the compiler, some 4 ms in all: at 246 random devices with such a motion
they found it at 173. As many random ones found it at 145 to 172."""

MANY = 64, 256
"""Starts and impacts of each with the compiler."""


def cycles_by_starts(groups: Groups[float], compiled: bool) -> Iterator[SimulatedMotion]:
    """Periodic motions without rests that attract starts in flight, in the order in which they are met, and repeatedly.

    Parameters
    ----------
    groups : Groups
        Of the device, as numbers.
    compiled : bool
        Whether to compile the simulation, where numba is there, and to try more starts.
    """
    model, (count, impacts) = check_model(groups)[0], MANY if compiled else FEW
    for start in even_starts(groups.d, start_speed(groups.restitution), count):
        ball = Trajectory.begun(model, start.tolist(), impacts, compiled=compiled)
        if ball.moving and (cycle := attracting(ball)) is not None:
            yield cycle
