"""States of the ball in flight from which simulations start: random ones, and ones that are spread evenly."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vireport.physics.groups import Restitution, SpeedLaw, stated
from vireport.simulation.kernel import TURN

Array = NDArray[np.float64]

# Largest velocity of a start over that of the fastest motion: motions are approached from above as well.
BEYOND = 1.5
# Towards r = 1 the velocity that the forcing sustains has no limit; starts take it at this 1-r at least.
LEAST_LOSS = 0.1
# Multiples of numbers that fractions approximate badly fill a cube evenly: powers of 1/x, x^4 = x + 1.
STEPS = 0.8191725133961645, 0.6710436067037893, 0.5497004779019703


def start_speed(r: Restitution | SpeedLaw, fastest: ArrayLike = 0.0) -> Array:
    """Largest velocity of random starts [y_c].

    It is half as much again as the larger of `fastest` and 2/(pi (1-r)), the largest impact velocity that the forcing
    sustains without gravity, from (3.9) with q = 1/2; 1-r counts as 0.1 at least.

    Parameters
    ----------
    r : array_like, Restitutions or SpeedLaw
        Restitution coefficient; the larger of two counts, and for a law those that it states.
    fastest : array_like
        Impact velocity of the fastest motion that starts shall reach [y_c].
    """
    largest = np.maximum(*stated(r))
    sustained = 2 / (pi * np.maximum(1 - np.asarray(largest, dtype=float), LEAST_LOSS))
    speed: Array = BEYOND * np.maximum(fastest, sustained)
    return speed


def random_starts(d: ArrayLike, speed: ArrayLike, count: int, seed: int | Sequence[int]) -> Array:
    """Draw states in flight, independent of one another and from parameter to parameter.

    Position (between the membranes), velocity (up to `speed` in either direction) and forcing phase (over a period)
    are each uniform, so that the share of the starts that reach a motion is the share of this part of the state space.

    Parameters
    ----------
    d : array_like (n,)
        Distance of the membranes [x_c].
    speed : array_like
        Largest velocity, see `start_speed` [y_c]; one, or one for each d.
    count : int
        Number of starts at each d.
    seed : int or sequence of int
        Of the random numbers; the same seed gives the same starts.

    Returns
    -------
    array (n, count, 4)
        Rows of wall (0: none), position [x_c], velocity [y_c] and phase [rad].
    """
    distance = np.atleast_1d(np.asarray(d, dtype=float))[:, None]
    position, velocity, phase = np.moveaxis(np.random.default_rng(seed).random((len(distance), count, 3)), -1, 0)
    largest = np.broadcast_to(np.asarray(speed, dtype=float), distance.shape[:1])[:, None]
    return _placed(position, velocity, phase, distance, largest)


def even_starts(d: float, speed: ArrayLike, count: int) -> Array:
    """States in flight, a sequence of low discrepancy that evenly fills the set from which `random_starts` draws.

    A few of them find more attractors than as many random ones. They need no generator, which takes longer to import
    than a few hundred impacts do.

    Parameters
    ----------
    d : float
        Distance of the membranes [x_c].
    speed : array_like
        Largest velocity, see `start_speed` [y_c].
    count : int
        Number of starts.

    Returns
    -------
    array (count, 4)
        Rows of wall (0: none), position [x_c], velocity [y_c] and phase [rad].
    """
    position, velocity, phase = (0.5 + np.outer(STEPS, np.arange(1, count + 1))) % 1
    return _placed(position, velocity, phase, d, speed)


def _placed(position: Array, velocity: Array, phase: Array, distance: ArrayLike, speed: ArrayLike) -> Array:
    """Rows of starts in flight from shares, 0 to 1, of the ranges of position, velocity and phase."""
    columns = (position - 0.5) * np.asarray(distance), (2 * velocity - 1) * np.asarray(speed), TURN * phase
    return np.stack([np.zeros_like(phase), *columns], axis=-1)
