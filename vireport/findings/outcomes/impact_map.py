"""The map from impact to impact of many states at once, forwards and backwards.

Each is one flight of the simulation. Where a flight begins its velocity is given, so restitution plays no part in it:
the search is asked with r = 1, by which the ball leaves a membrane as fast as it is said to have come.
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.simulation.events import check_model, follow_impacts
from vireport.simulation.kernel import FLIGHT, TURN, VELOCITY, WALL

Floats = NDArray[np.float64]


class Arrivals(NamedTuple):
    """The impacts that end flights, as arrays (n,).

    Attributes
    ----------
    wall : ndarray
        1 bottom, -1 top; 0 where no membrane is ever met.
    time : ndarray
        Of the impact [t_c], by the clock of the flight's beginning.
    velocity : ndarray
        Relative velocity there [y_c]: just before the impact that ends a flight, or just after the one that began it,
        where it is followed backwards.
    """

    wall: Floats
    time: Floats
    velocity: Floats


def forwards(groups: Groups[float], wall: ArrayLike, time: Floats, after: Floats, compiled: bool = False) -> Arrivals:
    """Follow flights that leave membranes to their ends.

    Parameters
    ----------
    groups : Groups
        Of the device.
    wall : array_like
        The membranes left.
    time, after : ndarray (n,)
        When [t_c], the forcing phase being pi times that, and velocity just after [y_c], away from the membrane.
    compiled : bool
        Whether to compile the search, where numba is there.
    """
    starts = np.zeros((len(time), 4))
    starts[:, 0], starts[:, 2], starts[:, 3] = wall, -after, np.mod(pi * time, TURN) % TURN
    model = np.repeat(check_model(groups._replace(restitution=1.0)), len(time), axis=0)
    rows, summary = follow_impacts(model, starts, 1, 1, compiled=compiled)
    strikes = summary[:, 0] == 1
    last = rows[:, -1]
    return Arrivals(np.where(strikes, last[:, WALL], 0.0), time + last[:, FLIGHT], last[:, VELOCITY])


def backwards(groups: Groups[float], wall: ArrayLike, time: Floats, before: Floats) -> Arrivals:
    """Follow flights that end at membranes back to where they began.

    Z(-t) obeys (2.8) with the phase negated, so this is the flight forwards with phase and velocity negated, and the
    sines of harmonics, which are odd. The impact before had the velocity that is returned over -r.

    Parameters are those of `forwards`, with the velocity just before the impact.
    """
    harmonics = tuple(Harmonic(harmonic.order, harmonic.cosine, -harmonic.sine) for harmonic in groups.harmonics)
    mirrored = forwards(groups._replace(harmonics=harmonics), wall, -time, -before, compiled=True)
    return Arrivals(mirrored.wall, -mirrored.time, -mirrored.velocity)
