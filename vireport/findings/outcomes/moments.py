"""What a ball at rest comes to by the moment at which the force sets in, at once or with an amplitude that rises.

While the amplitude rises, each half wave of the force, between two of its zeros, has the amplitude that a linear ramp
has at its middle: the force is continuous, and within a half wave the model of the simulation holds in the units of
that amplitude.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import cos, floor, inf, nextafter, pi, sin

import numpy as np

from vireport.design.from_rest import Destination, FromRest, StartingDevice, State, pressed_outcomes, started
from vireport.physics.forcing import wave
from vireport.physics.groups import Groups
from vireport.simulation.events import BOTTOM, check_model, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, TURN, VELOCITY, WALL
from vireport.simulation.release import Press, presses
from vireport.simulation.stops import moved_on

PHASES = 32
"""Moments at which the force sets in, evenly over its period, where the outcome depends on that moment."""

RAMPS = (1, 2, 3, 5, 10, 20, 40, 80)
"""Forcing periods in which the amplitude is ramped up, tried where switching on at once does not reach the motion."""


def outcomes_by_moment(
    device: StartingDevice, ramp_periods: float, compiled: bool
) -> tuple[tuple[float, FromRest], ...]:
    """What a ball comes to that lies on the bottom membrane, for moments at which the force sets in over its period.

    Parameters
    ----------
    ramp_periods : float
        Forcing periods in which the amplitude rises, see `ramped`; 0 where it is there at once.

    Returns
    -------
    tuple of (float, FromRest)
        Shares of the moments and their outcomes. Without a ramp, the moments at which the ball is pressed down come
        first, one entry for each release; the others are 32 evenly spaced ones.
    """
    if not ramp_periods:
        pressed = presses(device.groups)
        outcomes = pressed_outcomes(device, compiled)
        if not pressed:
            return ((1.0, FromRest(Destination.AT_REST)),)
        starts: Iterable[State] = ((float(BOTTOM), 0.0, 0.0, phase) for phase in unpressed(pressed, PHASES))
        share_of_one = (1 - sum(share for share, _ in outcomes)) / PHASES
    else:
        outcomes, share_of_one = [], 1 / PHASES
        # A force that rises from nothing lets the ball lie at first, whenever it sets in: all moments are alike.
        phases = TURN * (np.arange(PHASES) + 0.5) / PHASES
        starts = (ramped(device.groups, float(phase), ramp_periods, compiled) for phase in phases)
    return (*outcomes, *((share_of_one, started(start, device, compiled)) for start in starts))


def unpressed(pressed: Sequence[Press], count: int) -> list[float]:
    """So many forcing phases evenly spaced over the times in which a ball at rest is not pressed down [rad]."""
    ends = np.cumsum([press.free for press in pressed])
    begins = ends - [press.free for press in pressed]
    places = ends[-1] * (np.arange(count) + 0.5) / count
    # Rounding of the sums may leave the last places behind the last end.
    which = np.minimum(np.searchsorted(ends, places), len(pressed) - 1)
    phases: list[float] = (np.array([press.release for press in pressed])[which] + (places - begins[which])).tolist()
    return phases


def ramp_that_helps(device: StartingDevice, compiled: bool) -> int | None:
    """The fewest forcing periods of `RAMPS`, over which the amplitude rises, with which all moments lead to 1:1 motion.

    None where none of them does.
    """
    for periods in RAMPS:
        phases = TURN * (np.arange(PHASES) + 0.5) / PHASES
        starts = (ramped(device.groups, float(phase), periods, compiled) for phase in phases)
        if all(started(start, device, compiled).is_one_to_one for start in starts):
            return periods
    return None


def outcome_of(outcomes: Sequence[tuple[float, FromRest]]) -> FromRest:
    """The outcome that stands for several moments: the first or, with a ramp, one that misses 1:1 or the slowest.

    Without a ramp the first one is that of all moments in which the ball is pressed down.
    """
    # With a ramp all moments have equal shares; without one the first entry has all moments of a release.
    if len({part for part, _ in outcomes}) > 1:
        return outcomes[0][1]
    missed = (outcome for _, outcome in outcomes if not outcome.is_one_to_one)
    return next(missed, max((outcome for _, outcome in outcomes), key=lambda outcome: outcome.settles_after or 0))


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
        # Computed from the zero, not from the sum of times: rounding would put the next half wave on its wrong side.
        state = (*state[:3], (zero % 2) * pi)
    return state


def _half_wave(groups: Groups[float], state: State, amplitude: float, duration: float, compiled: bool) -> State:
    """State after a time [t_c] with a constant amplitude, over that at the end of the ramp."""
    d, gbar, r, harmonics, friction = groups
    # In units of a smaller amplitude, whatever does not scale with it is larger: length, gravity, friction, the state.
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
