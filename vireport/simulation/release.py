"""Phases at which the bottom membrane releases a ball at rest, and the phases in which it is pressed down before."""

from __future__ import annotations

from itertools import pairwise
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
        For gbar > 1, where it never does.
    """
    return acos(-gbar)


class Press(NamedTuple):
    """An interval of the forcing period in which a ball at rest is pressed onto the bottom membrane.

    Attributes
    ----------
    release : float
        Forcing phase at which it leaves [rad].
    share : float
        Length of the interval, which ends with the release, over the forcing period [-].
    free : float
        Length of the interval without pressure that follows [rad].
    """

    release: float
    share: float
    free: float


def presses(groups: Groups[float]) -> list[Press]:
    """The intervals in which a ball at rest is pressed down: one in a period for a sine, none where it never leaves.

    Parameters
    ----------
    groups : Groups
        Groups of the device, as numbers; with friction the ball is let go later.

    Returns
    -------
    list of Press
        By ascending phase of release.
    """
    gravity = groups.gravity(LEAVING)
    if not groups.harmonics:
        if gravity >= 1:
            return []
        release = release_phase(gravity)
        return [Press(release, release / pi, TURN - 2 * release)]
    stretches = _stretches(groups)
    pairs = zip(stretches, [*stretches[1:], *stretches[:1]], strict=True)
    return sorted(Press(free.begin, pressed.length / TURN, free.length) for pressed, free in pairs if pressed.pressed)


class _Stretch(NamedTuple):
    """Forcing phases between two zeros of the acceleration of a ball at rest [rad], and whether it is pressed there."""

    begin: float
    length: float
    pressed: bool


def _stretches(groups: Groups[float]) -> list[_Stretch]:
    """The stretches of a period in which a ball at rest is pressed down and in which it is free, by turns.

    Invariant: they fill the period, each begins where the one before ends, and neighbours differ: where the
    acceleration only touches zero, one stretch goes on. Empty where it has one sign throughout the period.
    """
    phases = unaccelerated(groups.gravity(LEAVING), groups.harmonics)
    joined: list[_Stretch] = []
    for begin, end in pairwise([*phases, *(phase + TURN for phase in phases[:1])]):
        length = end - begin
        pressed = groups.pull(groups.wave(begin + length / 2, FLOATS).force, LEAVING) > 0
        if joined and joined[-1].pressed == pressed:
            joined[-1] = joined[-1]._replace(length=joined[-1].length + length)
        else:
            joined.append(_Stretch(begin, length, pressed))
    if len(joined) > 1 and joined[0].pressed == joined[-1].pressed:  # over the end of the period
        last = joined.pop()
        joined[0] = last._replace(length=last.length + joined[0].length)
    return joined if len(joined) > 1 else []
