"""A ball under kicks, one after the other and from scratch: flights are scanned, nothing is shared."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from numba import njit

STEP, HALVINGS, NEAR, LAST = 0.02, 45, 0.015, 240
"""Of the scan along a flight [t_c]; of an interval; distance at which a ball is back; impacts until it is not."""


@njit
def place(t, wall, after, phase, d, g):
    covered = (after - sin(phase) / pi) * t + g * t * t / 2 - (cos(pi * t + phase) - cos(phase)) / pi**2
    return wall * d / 2 + covered


@njit
def fly(wall, after, phase, d, g):
    """The next impact: membrane, velocity before it, phase, duration; no membrane after a hundred units of time."""
    t = STEP
    while abs(place(t, wall, after, phase, d, g)) < d / 2 and t < 100:
        t += STEP
    if t >= 100:
        return 0, 0.0, 0.0, t
    low, high = t - STEP + 1e-12, t
    onto = 1 if place(t, wall, after, phase, d, g) > 0 else -1
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if abs(place(middle, wall, after, phase, d, g)) < d / 2:
            low = middle
        else:
            high = middle
    velocity = after + g * high + (sin(pi * high + phase) - sin(phase)) / pi
    return onto, velocity, (phase + pi * high) % (2 * pi), high


@njit
def is_near(wall, velocity, phase, walls, velocities, phases):
    for i in range(len(walls)):
        late = (phase - phases[i] + pi) % (2 * pi) - pi
        if wall == walls[i] and abs(late) < pi * NEAR and abs(velocity - velocities[i]) < NEAR:
            return True
    return False


@njit
def comes_back(wall, after, phase, d, g, bottom, top, walls, velocities, phases):
    for _ in range(LAST):
        if wall * after > 0:
            velocity = after
        else:
            wall, velocity, phase, _ = fly(wall, after, phase, d, g)
            if wall == 0:
                return False
            if is_near(wall, velocity, phase, walls, velocities, phases):
                return True
        after = -(bottom if wall > 0 else top) * velocity
    return False


@njit
def times_until_escape(count, kick, random, d, g, bottom, top, walls, velocities, phases):
    """Times [forcing periods] until balls leave a motion, of which they come from the first impact."""
    times = np.zeros(count)
    for i in range(count):
        wall, phase, age = walls[0], phases[0], 0.0
        after = -(bottom if wall > 0 else top) * velocities[0]
        while True:
            if wall * after > 0:  # back onto the membrane: one more impact at once, not kicked
                after *= -(bottom if wall > 0 else top)
            wall, velocity, phase, duration = fly(wall, after, phase, d, g)
            age += duration / 2
            after = -(bottom if wall > 0 else top) * velocity + kick * random.normal()
            if not comes_back(wall, after, phase, d, g, bottom, top, walls, velocities, phases):
                break
        times[i] = age
    return times
