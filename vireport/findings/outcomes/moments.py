"""What a ball at rest comes to by the moment at which the force sets in, at once or with an amplitude that rises."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from vireport.design.from_rest import Destination, FromRest, State, Target, pressed_outcomes, started
from vireport.findings.outcomes.ramp import ramped
from vireport.physics.groups import Groups
from vireport.simulation.events import BOTTOM
from vireport.simulation.kernel import TURN
from vireport.simulation.release import Press, presses

PHASES = 32
"""Moments at which the force sets in, evenly over its period, where the outcome depends on that moment."""

RAMPS = (1, 2, 3, 5, 10, 20, 40, 80)
"""Forcing periods in which the amplitude is ramped up, tried where switching on at once does not reach the motion."""


def outcomes_by_moment(
    groups: Groups[float], targets: Sequence[Target], ratio: int, ramp_periods: float, compiled: bool
) -> tuple[tuple[float, FromRest], ...]:
    """What a ball comes to that lies on the bottom membrane, for moments at which the force sets in over its period.

    Parameters
    ----------
    ramp_periods : float
        Forcing periods in which the amplitude rises, see `ramped`; 0 where it is there at once.

    Returns
    -------
    tuple of (float, FromRest)
        Each with its share of the moments. Without a ramp those in which the ball is pressed down come first, as one
        for each release; the others are 32 evenly spaced.
    """
    if not ramp_periods:
        pressed = presses(groups)
        outcomes = pressed_outcomes(groups, targets, ratio, compiled)
        if not pressed:
            return ((1.0, FromRest(Destination.AT_REST)),)
        starts: Iterable[State] = ((float(BOTTOM), 0.0, 0.0, phase) for phase in unpressed(pressed, PHASES))
        share_of_one = (1 - sum(share for share, _ in outcomes)) / PHASES
    else:
        outcomes, share_of_one = [], 1 / PHASES
        # A force that rises from nothing lets the ball lie at first, whenever it sets in: all moments are alike.
        phases = TURN * (np.arange(PHASES) + 0.5) / PHASES
        starts = (ramped(groups, float(phase), ramp_periods, compiled) for phase in phases)
    return (*outcomes, *((share_of_one, started(start, groups, targets, ratio, compiled)) for start in starts))


def unpressed(pressed: Sequence[Press], count: int) -> list[float]:
    """So many forcing phases evenly spaced over the times in which a ball at rest is not pressed down [rad]."""
    ends = np.cumsum([press.free for press in pressed])
    begins = ends - [press.free for press in pressed]
    places = ends[-1] * (np.arange(count) + 0.5) / count
    # Rounding of the sums may leave the last places behind the last end.
    which = np.minimum(np.searchsorted(ends, places), len(pressed) - 1)
    phases: list[float] = (np.array([press.release for press in pressed])[which] + (places - begins[which])).tolist()
    return phases


def ramp_that_helps(groups: Groups[float], targets: Sequence[Target], ratio: int, compiled: bool) -> int | None:
    """The fewest forcing periods of `RAMPS` over which to raise the amplitude so that every moment leads to 1:1 motion.

    None where none of them does.
    """
    for periods in RAMPS:
        phases = TURN * (np.arange(PHASES) + 0.5) / PHASES
        starts = (ramped(groups, float(phase), periods, compiled) for phase in phases)
        if all(started(start, groups, targets, ratio, compiled).reached for start in starts):
            return periods
    return None


def outcome_of(outcomes: Sequence[tuple[float, FromRest]]) -> FromRest:
    """What to tell of several moments: the first outcome, or one of a ramp that misses the 1:1 motion, or the slowest.

    Without a ramp the first one is that of all moments in which the ball is pressed down.
    """
    if len({part for part, _ in outcomes}) > 1:
        return outcomes[0][1]
    missed = (outcome for _, outcome in outcomes if not outcome.reached)
    return next(missed, max((outcome for _, outcome in outcomes), key=lambda outcome: outcome.settles_after or 0))
