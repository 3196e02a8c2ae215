"""One simulated motion in full: its impacts, its path, and the portrait that figures 3 and 6 show.

Turns d, gbar, r and a start into impacts. It shares the closed-form flight and the impact law with the
analytic solution and nothing else, so that where both agree the agreement is evidence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from vireport.physics import flight
from vireport.simulation.attractors import Attractor, attractors
from vireport.simulation.events import BOTTOM, Impact, Start, check_model, check_start, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, VELOCITY, WALL

Array = NDArray[np.float64]

# Periods of a periodic motion that a portrait shows; impacts of another one, and how many of them it leaves out before.
PERIODS_SHOWN, IMPACTS_SHOWN, LEFT_OUT = 2, 12, 2000


@dataclass(frozen=True, slots=True)
class Stick:
    """Infinitely many impacts that die out, and the ride on the membrane that follows.

    Parameters
    ----------
    after : int
        Index of the last impact computed one by one; -1 if it is the start.
    wall : int
        BOTTOM or TOP.
    settling : float
        Time from that impact until the hops have died out [t_c].
    riding : float
        Time from then to the release [t_c]; inf at rest.
    """

    after: int
    wall: int
    settling: float
    riding: float


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Impacts that follow a start.

    Parameters
    ----------
    d, gbar, r : float
        Distance of the membranes, gravity and restitution [-].
    start : Impact or InFlight
        Where it began; not among the impacts.
    wall, phase, flight, velocity : array (n,)
        Of each impact: BOTTOM or TOP, forcing phase in [0, 2 pi) [rad], time since the impact (or the release
        from a membrane) before [t_c], velocity just before [y_c].
    sticks : tuple of Stick
        Chatter completed and rides, in order.
    """

    d: float
    gbar: float
    r: float
    start: Start
    wall: NDArray[np.int8]
    phase: Array
    flight: Array
    velocity: Array
    sticks: tuple[Stick, ...]


def simulate(d: float, gbar: float, r: float, start: Start, impacts: int) -> Trajectory:
    """Follow the ball for a number of impacts, or until it rests or never meets a membrane again.

    Between impacts Z'' = gbar + cos(pi t + phi) (2.8), at an impact Z'+ = -r Z'- (2.10), and the next impact
    is the first at either membrane: maps P1 to P4 (2.13). A touch is an impact of velocity zero. Chatter is
    completed in closed form once what that neglects is below 1e-15 t_c; the ball then rides until the
    membrane would have to pull, the bottom one while gbar + cos > 0 and the top one while it is negative.

    Parameters
    ----------
    d, gbar, r : float
        Distance of the membranes, gravity and restitution [-]; d > 0, gbar >= 0, 0 <= r <= 1.
    start : Impact or InFlight
        State to begin with.
    impacts : int
        How many to compute, at least 1.

    Returns
    -------
    Trajectory
        With all its impacts.
    """
    if impacts < 1:
        raise ValueError(f"impacts must be at least 1, not {impacts}")
    rows, _ = follow_one(check_model(d, gbar, r)[0], check_start(start, d), impacts)
    after = rows[1:]
    wall = after[:, WALL].astype(np.int8)
    phase, elapsed, velocity = (after[:, i].copy() for i in (PHASE, FLIGHT, VELOCITY))
    for array in (wall, phase, elapsed, velocity):
        array.setflags(write=False)
    return Trajectory(d, gbar, r, start, wall, phase, elapsed, velocity, _sticks(rows))


def _sticks(rows: Array) -> tuple[Stick, ...]:
    """Rides in the rows; row 0 is the start."""
    held = np.flatnonzero(rows[:, RIDING] + rows[:, SETTLING] > 0)
    return tuple(Stick(int(i) - 1, int(rows[i, WALL]), float(rows[i, SETTLING]), float(rows[i, RIDING])) for i in held)


def path(trajectory: Trajectory, samples: int = 40) -> tuple[Array, Array, Array]:
    """Time, position and velocity along a trajectory, from (2.11) and (2.12), to draw it.

    Parameters
    ----------
    trajectory : Trajectory
        What to draw.
    samples : int
        Points in each flight, its two ends included. The velocity jumps where a time occurs twice.

    Returns
    -------
    time, position, velocity : array
        In t_c, x_c and y_c.
    """
    start = trajectory.start
    on_wall = isinstance(start, Impact)
    z = start.wall * trajectory.d / 2 if isinstance(start, Impact) else start.position
    speed = flight.reflect(start.velocity, trajectory.r) if on_wall else start.velocity
    phase, clock = start.phase, 0.0
    held = {stick.after: stick for stick in trajectory.sticks}
    pieces: list[tuple[Array, Array, Array]] = []
    for i in range(len(trajectory.wall)):
        if i - 1 in held:
            stick = held[i - 1]
            clock += stick.settling + stick.riding
            phase, speed = phase + pi * (stick.settling + stick.riding), 0.0
        t = np.linspace(0.0, trajectory.flight[i], samples)
        s, c, now = np.sin(phase), np.cos(phase), phase + pi * t
        position = z + flight.displacement(t, speed, s, c, np.cos(now), trajectory.gbar)
        pieces.append((clock + t, position, flight.velocity(t, speed, s, np.sin(now), trajectory.gbar)))
        clock += trajectory.flight[i]
        z, phase = trajectory.wall[i] * trajectory.d / 2, trajectory.phase[i]
        speed = flight.reflect(trajectory.velocity[i], trajectory.r)
    if not pieces:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    times, positions, velocities = (np.concatenate(column) for column in zip(*pieces, strict=True))
    return times, positions, velocities


@dataclass(frozen=True, slots=True, eq=False)
class Portrait:
    """A simulated motion in full.

    Attributes
    ----------
    label : str
        What it is simulated at, as the caller calls it.
    d, gbar, r : float
        The groups, and the restitution.
    attractor : Attractor
        What the motion is.
    phase : float
        Forcing phase at time zero, at an impact on the bottom where there is one [rad].
    time, position, velocity : ndarray
        Dimensionless; the velocity jumps where a time occurs twice.
    """

    label: str
    d: float
    gbar: float
    r: float
    attractor: Attractor
    phase: float
    time: Array
    position: Array
    velocity: Array


def portrait(d: float, gbar: float, r: float, starts: Sequence[Start], label: str = "") -> Portrait:
    """Follow the periodic motion that the first of some starts leads to which leads to one, or else any motion.

    Parameters
    ----------
    d, gbar, r : float
        Distance of the membranes, gravity and restitution [-].
    starts : sequence of Impact or InFlight
        At least one.
    label : str
        See `Portrait`.
    """
    reached = attractors([d], gbar, r, starts)[0]
    start: Start
    shown = next((end for end in reached if end.cycle is not None and not end.cycle.sticks), reached[0])
    if shown.cycle is not None and not shown.cycle.sticks:
        first = int(np.argmax(shown.cycle.wall == BOTTOM))
        wall = int(shown.cycle.wall[first])
        start = Impact(wall, float(shown.cycle.velocity[first]), float(shown.cycle.phase[first]))
        count = PERIODS_SHOWN * len(shown.cycle.wall)
    else:
        settled = simulate(d, gbar, r, starts[0], LEFT_OUT)
        count = IMPACTS_SHOWN
        start = starts[0]
        if len(settled.wall):
            start = Impact(int(settled.wall[-1]), float(settled.velocity[-1]), float(settled.phase[-1]))
    time, position, velocity = path(simulate(d, gbar, r, start, count))
    return Portrait(label, d, gbar, r, shown, start.phase, time, position, velocity)
