"""The amplitude of the force ramped up from zero, with the event search for a constant amplitude.

Each half wave of the force, between two of its zeros, has the amplitude that a linear ramp has at its middle: the force
is continuous, and within a half wave all is the model of the simulation in the units of that amplitude.
"""

from __future__ import annotations

from math import cos, floor, inf, nextafter, pi, sin

import numpy as np

from vireport.design.from_rest import State
from vireport.physics.forcing import wave
from vireport.physics.groups import Groups
from vireport.simulation.events import BOTTOM, check_model, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, TURN, VELOCITY, WALL

BLOCK = 32
"""Impacts simulated at once within a half wave."""


def ramped(groups: Groups[float], phase: float, periods: float, compiled: bool = False) -> State:
    """State of a ball that lay on the bottom membrane, when the amplitude has been ramped up.

    Parameters
    ----------
    groups : Groups
        Of the device at full amplitude, as numbers.
    phase : float
        Forcing phase at which the force sets in [rad].
    periods : float
        Forcing periods that the ramp takes, above 0; from its end to the next zero of the force is added.
    compiled : bool
        Whether to compile the simulation, where numba is there.
    """
    state: State = (float(BOTTOM), 0.0, 0.0, phase)
    elapsed, now = 0.0, phase / pi
    # A forcing period is 2 t_c.
    while elapsed < 2 * periods:
        zero = floor(now - 0.5) + 1.5  # the next of the zeros of the force, which are at odd multiples of 1/2
        amplitude = min((elapsed + (zero - now) / 2) / (2 * periods), 1.0)
        state = _half_wave(groups, state, amplitude, zero - now, compiled)
        elapsed, now = elapsed + zero - now, zero
        # From the zero and not from what was added up: rounding would put the next half wave on the wrong side of it.
        state = (*state[:3], (zero % 2) * pi)
    return state


def _half_wave(groups: Groups[float], state: State, amplitude: float, duration: float, compiled: bool) -> State:
    """State after a time [t_c] with a constant amplitude, over that at the end of the ramp."""
    d, gbar, r, harmonics, friction = groups
    # In units of a smaller amplitude all that does not grow with it is larger: length, gravity, friction, the state.
    rubbing = None if friction is None else friction / amplitude
    groups = Groups(d / amplitude, gbar / amplitude, r, harmonics, rubbing)
    model = check_model(groups)[0]
    wall, position, velocity, phase = state
    start = wall, position / amplitude, velocity / amplitude, phase
    clock, count = 0.0, BLOCK
    while True:
        rows, _ = follow_one(model, start, count, compiled=compiled)
        held = rows[:, SETTLING] + rows[:, RIDING]
        times = clock + np.concatenate([[0.0], np.cumsum(held[:-1] + rows[1:, FLIGHT])])
        past = times > duration
        # Fewer impacts than were asked for: the ball stays on a membrane, or meets none again.
        if past.any() or len(rows) <= count:
            break
        row = rows[-1]
        clock, start = float(times[-1]), (float(row[WALL]), 0.0, float(row[VELOCITY]), float(row[PHASE]))
    last = int(np.argmax(past)) - 1 if past.any() else len(rows) - 1
    row, left = rows[last], duration - float(times[last])
    hit = float(row[WALL])
    if left <= 0 and hit:
        return hit, 0.0, float(row[VELOCITY]) * amplitude, phase
    if held[last] >= left and held[last] > 0:
        return hit, 0.0, 0.0, phase  # at rest, or in hops that are too low to tell
    if friction is not None:
        from vireport.simulation.stops import moved_on

        z, v = moved_on(model, row, start[1], left)
        return 0.0, _inside(z * amplitude, d), v * amplitude, phase % TURN
    moved = float(held[last])
    place = hit * model[0] / 2 if hit else start[1]
    before = float(row[VELOCITY])
    speed = 0.0 if moved else float(groups.after(int(hit), before)) if hit else before
    angle, t = float(row[PHASE]) + pi * moved, left - moved
    begun, end = (wave(sin(x), cos(x), harmonics) for x in (angle, angle + pi * t))
    covered, v = groups.flown(t, speed, begun, end)
    return 0.0, _inside((place + covered) * amplitude, d), v * amplitude, phase % TURN


def _inside(position: float, d: float) -> float:
    """A position between the membranes, which rounding may have put on one."""
    most = nextafter(d / 2, -inf)
    return min(max(position, -most), most)
