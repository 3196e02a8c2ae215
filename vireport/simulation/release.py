"""When a ball that lies on the bottom membrane is pressed onto it, and at which phase it leaves."""

from __future__ import annotations

from math import acos, pi
from typing import NamedTuple

from vireport.physics.forcing import unaccelerated
from vireport.physics.groups import Groups
from vireport.physics.numbers import FLOATS
from vireport.simulation.kernel import TURN

LEAVING = -1
"""Sign of the relative velocity of a ball that leaves the bottom membrane."""


def release_phase(gbar: float) -> float:
    """Forcing phase at which a ball leaves the bottom membrane: the first zero of the pressing acceleration [rad].

    Raises
    ------
    ValueError
        For gbar >= 1, where it never does.
    """
    return acos(-gbar)


class Press(NamedTuple):
    """When a ball at rest is pressed onto the bottom membrane.

    Attributes
    ----------
    release : float
        Forcing phase at which it leaves [rad].
    share : float
        Of the forcing period, up to there.
    free : float
        For how long it is not pressed from there on [rad].
    """

    release: float
    share: float
    free: float


def presses(groups: Groups[float]) -> list[Press]:
    """When a ball at rest is pressed down, once a period of a sine; none where it never leaves."""
    gravity = groups.gravity(LEAVING)  # friction holds the ball back on its way
    if not groups.harmonics:
        if gravity >= 1:
            return []
        release = release_phase(gravity)
        return [Press(release, release / pi, TURN - 2 * release)]
    phases = unaccelerated(gravity, groups.harmonics)
    following = [*phases[1:], phases[0] + TURN] if phases else []
    lengths = [b - a for a, b in zip(phases, following, strict=True)]
    middles = [a + length / 2 for a, length in zip(phases, lengths, strict=True)]
    pressed = [groups.pull(groups.wave(x, FLOATS).force, LEAVING) > 0 for x in middles]
    releases = [k for k in range(len(phases)) if pressed[k - 1] and not pressed[k]]
    # Where the acceleration only touches zero it goes on as before: stretches of one sign are joined.
    found = []
    for number, k in enumerate(releases):
        since = releases[number - 1] - (len(phases) if number == 0 else 0)
        before = [j % len(phases) for j in range(since, k)]
        until = releases[(number + 1) % len(releases)] + (len(phases) if number + 1 == len(releases) else 0)
        after = [j % len(phases) for j in range(k, until)]
        share = sum(lengths[j] for j in before if pressed[j]) / TURN
        found.append(Press(phases[k], share, sum(lengths[j] for j in after if not pressed[j])))
    return found
