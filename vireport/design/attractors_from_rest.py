"""The motions that a ball from rest comes to at values over a sweep, where a few hundred impacts show them.

The simulation is not compiled, as the compiler takes longer to start than all of it. A ball that has not settled after
some 500 impacts is left undecided; `from_rest` follows it on.
"""

from __future__ import annotations

import numpy as np
from msgspec import Struct

from vireport.base.records import brief
from vireport.design.from_rest import Destination, FromRest, rested
from vireport.motions.sweep import Sweep
from vireport.physics.groups import Groups
from vireport.simulation.attractors import STOPPED
from vireport.simulation.cycles import SimulatedMotion, attracting
from vireport.simulation.events import BOTTOM, check_model
from vireport.simulation.follower import Trajectory
from vireport.simulation.release import presses

VALUES = 21
"""Number of values over a sweep, its ends included: 30 to 60 ms for the paper's sweeps, 150 ms where all is chaotic."""

BLOCKS = 96, 160, 256
"""Numbers of impacts in blocks, after each of which it is tested whether the last impacts nearly repeat."""


class AttractorFromRest(Struct, frozen=True, eq=False):
    """The motion or state that a ball from rest ends in, at one value of an input.

    Attributes
    ----------
    value : float
        Value of the input, in its unit.
    d : float
        The group d there.
    end : FromRest
        Undecided where the ball has not settled.
    """

    value: float
    d: float
    end: FromRest

    __repr__ = brief

    @property
    def motion(self) -> SimulatedMotion | None:
        """The periodic motion without rests that it comes to."""
        return self.end.cycle if self.end.is_motion else None


def attractors_from_rest(sweep: Sweep) -> tuple[AttractorFromRest, ...]:
    """The ends of balls that lie on the bottom membrane when the force sets in, at ascending values over a sweep."""
    ratio, attractors = sweep.device.period_ratio, []
    low, high = sorted((sweep.start, sweep.end))
    for value in np.linspace(low, high, VALUES).tolist():
        groups = sweep.device.groups(sweep.parameter, value).as_floats()
        attractors.append(AttractorFromRest(value, groups.d, _end(groups, ratio)))
    return tuple(attractors)


def _end(groups: Groups[float], ratio: int) -> FromRest:
    """The end of a ball from its first release, where no stable motion is known beforehand."""
    release = next((press.release for press in presses(groups)), None)
    if release is None:
        return FromRest(Destination.AT_REST)
    start, released = (float(BOTTOM), 0.0, 0.0, release), True
    for impacts in BLOCKS:
        ball = Trajectory.begun(check_model(groups)[0], start, impacts, compiled=False)
        if not ball.moving:
            return FromRest.without_cycle(STOPPED[ball.status][0])
        if (rest := rested(ball, ratio, released)) is not None:
            return rest[0]
        if (cycle := attracting(ball)) is not None:
            return FromRest.on(cycle, ratio)
        # From where the ball is: its earlier impacts are too far from what attracts it to be looked at again.
        start, released = ball.last, False
    return FromRest(Destination.UNDECIDED)
