"""Critical points of 1:1 motions: from where one is in the closed form to the last digit of a double.

Grazing, where a turning point of the ball comes to touch a membrane and a branch of motions ends, is the touch as an
impact of velocity zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi, sqrt
from typing import Any

import numpy as np

from vireport.motions.conditions import Condition
from vireport.motions.events import Event
from vireport.motions.motion import Motion
from vireport.motions.one_to_one import Motions
from vireport.motions.orbits import Orbits
from vireport.motions.periodicity import Grouped
from vireport.motions.points import place_of, solved_on_sweep
from vireport.motions.polish import DECIMALS, Equation, Solved, in_decimals, solve_motion
from vireport.motions.sweep import Sweep
from vireport.motions.turning import touches
from vireport.physics import ARRAYS, Groups, Word

SHORT = 1e-3
"""Time since the impact, below which a touch is a ball that comes back before it has left. It is found from its
expansion, for in doubles the distance covered is lost against the length of the capsule."""

AT_ONCE = 1e-9
"""Time since the impact, below which a touch is as good as the moment in which the membrane begins to hold the ball:
the expansion is off by a share of the time, so what it says of the acceleration by the square of that."""

Solve = Callable[[Motion, Equation], Solved]
"""Solves the conditions of a motion and an equation, next to a motion."""


def motion_of(orbit: Orbits, n: int, coordinate: float) -> Motion:
    """The motion of numbers of the closed form, or of arrays of length one.

    Parameters
    ----------
    orbit : Orbits
    n : int
        Forcing periods per motion.
    coordinate : float
        What varies.
    """
    start, up = (float(np.ravel(column)[0]) for column in (orbit.phi, orbit.time_up))
    velocity = np.ravel([orbit.velocity_bottom, orbit.velocity_top])
    return Motion(Word((1, -1), n), velocity, np.array([start / pi, start / pi + up]), coordinate)


def motion_at(motions: Motions, row: int, n: int) -> Motion:
    """A row of 1:1 motions, in n forcing periods, by its impacts; what varies is the swept value."""
    start, up = motions.phi_bottom[row] / pi, 2 * n * (0.5 + motions.u[row])
    velocity = np.array([motions.velocity_bottom[row], motions.velocity_top[row]])
    return Motion(Word((1, -1), n), velocity, np.array([start, start + up]), float(motions.sweep_value[row]))


def at_condition(condition: Condition, word: Word) -> Equation:
    """The equation of a condition for the motions of a word."""
    return lambda x, groups, ops: condition.value(word, x, groups, ops)


def at_value(sweep: Sweep, value: float) -> Equation:
    """The equation that the swept parameter has a value."""
    asked = {ops: sweep.coordinate_of(value, ops) for ops in (DECIMALS, ARRAYS)}
    return lambda x, groups, ops: x[-1] - asked[ops]


def solve_one_to_one(
    grouped: Callable[[Any], Grouped],
    orbit: Orbits,
    r: float,
    n: int,
    coordinate: float,
    condition: Condition,
    symmetric: bool,
) -> tuple[Solved, tuple[int, ...]]:
    """Solve for a 1:1 motion at which a condition holds; within `in_decimals`.

    Parameters
    ----------
    grouped : callable
        As for `polish.solve_motion`.
    orbit : Orbits
        The motion as far as it is known (arrays of length one).
    r : float
        Restitution coefficient there.
    n : int
        Forcing periods per motion.
    coordinate : float
        What varies there.
    condition : Condition
        The impacts in `rests` are 0 for the bottom and 1 for the top; not needed for grazing.
    symmetric : bool
        Whether the motion is its own mirror image.

    Returns
    -------
    Solved
    tuple of int
        The impacts of it that are touches.

    Raises
    ------
    NumericalError
        If it does not settle.
    """
    motion = motion_of(orbit, n, coordinate)

    def solve(guess: Motion, equation: Equation) -> Solved:
        return solve_motion(grouped, guess, equation, symmetric)

    if condition.event is Event.GRAZING:
        return _solve_grazing(solve, motion, orbit, r, symmetric)
    return solve(motion, at_condition(condition, motion.word)), ()


def _solve_grazing(
    solve: Solve, motion: Motion, orbit: Orbits, r: float, symmetric: bool
) -> tuple[Solved, tuple[int, ...]]:
    """Solve for a 1:1 motion that grazes, from the turning point that is nearest to a membrane.

    A ball that touches again shortly after an impact has v t = a t^2/2 + j t^3/6 and v = a t + j t^2/2, which give the
    acceleration a = (-8 j v/3)^(1/2) towards the wall that it leaves, and t = -3 a/(2 j).
    """
    nearest = next(iter(touches(orbit, r)), None)
    if nearest is not None and not (nearest.time < SHORT and nearest.at_start):
        return _solve_touch(solve, motion, nearest.upward, nearest.at_start, nearest.time, symmetric)
    flights = orbit.flights(r)
    pressed = [float(abs(way.pressing(way.cosine)[0])) for way in flights]
    upward = nearest.upward if nearest is not None else pressed[0] < pressed[1]
    way, leaves = flights[0 if upward else 1], 0 if upward else 1
    jerk = -float(way.jerk(way.sine)[0])
    acceleration = sqrt(max(-8 * jerk * abs(float(way.velocity[0])) / 3, 0.0))
    wall = motion.word.walls[leaves]

    def pressing(x: Sequence[Any], groups: Groups[Any], ops: Any) -> Any:
        return wall * (groups[1] + ops.cos(ops.pi * x[2 + leaves])) - ops.exact(acceleration)

    solved, elapsed = solve(motion, pressing), -1.5 * acceleration / jerk if acceleration else 0.0
    if elapsed < AT_ONCE:  # for r = 0 the ball starts at rest, and touches where the membrane begins to hold it
        return solved, ()
    velocity, time = (np.array([float(v) for v in part]) for part in (solved.x[:2], solved.x[2:4]))
    near = Motion(motion.word, velocity, time, float(solved.x[-1]))
    return _solve_touch(solve, near, upward, True, elapsed, symmetric)


def _solve_touch(
    solve: Solve, motion: Motion, upward: bool, at_start: bool, elapsed: float, symmetric: bool
) -> tuple[Solved, tuple[int, ...]]:
    """Solve for a motion that touches a membrane, a time after an impact: that of the wall left, or the other one."""
    # Of a symmetric motion the touch half a period later comes with it.
    for after in (1, 0) if symmetric else (0 if upward else 1,):
        wall = motion.word.walls[after] if at_start else -motion.word.walls[after]
        motion = motion.with_impact(after, wall, float(motion.time[after]) + elapsed)
    # Not all that have next to no velocity: for r = 0 and a small inclination the impacts themselves have as little.
    put_in = (1, 3) if symmetric else (1 if upward else 2,)
    return solve(motion, at_condition(Condition(Event.GRAZING, put_in), motion.word)), put_in


def place_at(sweep: Sweep, value: float, orbit: Orbits, symmetric: bool, reach: float) -> tuple[float, float]:
    """Place of the motion at a value of the swept parameter: q - 1/2 and phase, correctly rounded.

    Parameters
    ----------
    sweep : Sweep
    value : float
    orbit : Orbits
        The motion as far as it is known.
    symmetric : bool
        Whether the motion is its own mirror image.
    reach : float
        How far from it the motion may be.

    Raises
    ------
    NumericalError
        If it does not settle.
    """
    n = sweep.device.period_ratio
    with in_decimals():
        motion = motion_of(orbit, n, float(np.ravel(sweep.coordinate(orbit))[0]))
        return place_of(solved_on_sweep(sweep, motion, at_value(sweep, value), symmetric, reach=reach))
