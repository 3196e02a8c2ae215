"""The map from impact to impact of many states at once, forwards and backwards.

Each state is followed for one flight of the simulation. The velocity at its beginning is given, so restitution plays no
part: the search is called with r = 1, so that the ball leaves the membrane as fast as it is said to have come.
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
        The membrane: 1 bottom, -1 top; 0 where none is ever met.
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
        The membranes that the ball leaves.
    time, after : ndarray (n,)
        Time [t_c], the forcing phase being pi times that, and velocity just after it [y_c], away from the membrane.
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

    Z(-t) obeys (2.8) with the phase negated, so this is the flight forwards with phase, velocity and the sines of
    harmonics, which are odd, negated. Just before the impact that began it, the velocity was the returned one over -r.

    Parameters are those of `forwards`, with the velocity just before the impact that ends the flight.
    """
    harmonics = tuple(Harmonic(harmonic.order, harmonic.cosine, -harmonic.sine) for harmonic in groups.harmonics)
    mirrored = forwards(groups._replace(harmonics=harmonics), wall, -time, -before, compiled=True)
    return Arrivals(mirrored.wall, -mirrored.time, -mirrored.velocity)
