"""Branch switching: the families that meet at a vertex, and the first motion of each next to it.

At a grazing point the neighbouring word has an impact of velocity zero; at a period doubling two periods of the motion
are one of the doubled word; at a pitchfork the symmetric motion meets two that are mirror images of each other. Read
from `openings` on.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain, combinations
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import UsageError
from vireport.base.records import ResultsBlock
from vireport.motions.events import Event
from vireport.motions.paths import Curve, Path, PathPoint
from vireport.motions.turning import Turn
from vireport.physics.motion import AT_ZERO, SAME_TOUCH, Motion
from vireport.physics.word import Word

Floats = NDArray[np.float64]

STEPS_OFF = 1e-3, 1e-4, 1e-5
"""Arclengths from a vertex to the first motion of a family, in the order in which they are tried: far enough for the
families to differ, and near enough for no event before it."""


MOST = 16
"""Largest number of impacts and of periods of a motion: of sixteen impacts there are 4116 words, of one more about
twice as many."""


class Limits(ResultsBlock, frozen=True, eq=True):
    """Largest numbers of impacts and of forcing periods of the motions that are followed.

    Attributes
    ----------
    impacts, periods
        these numbers
    """

    impacts: int
    periods: int

    def __post_init__(self) -> None:
        """Refuse limits of impacts and periods that are out of range.

        Raises
        ------
        UsageError
            If a motion might have more impacts than that, or take more periods.
        """
        for most, what in ((self.impacts, "impacts"), (self.periods, "forcing periods")):
            if not 1 <= most <= MOST:
                raise UsageError(
                    f"motions of up to {most} {what} are too many to follow (allowed: 1 to {MOST}): the words of "
                    "N impacts double with each impact, 4116 of sixteen"
                )

    def admit(self, word: Word) -> bool:
        """Whether motions of a word are within the limits."""
        return len(word) <= self.impacts and word.periods <= self.periods


def touching(motion: Motion, turns: Iterable[Turn]) -> Motion:
    """A motion at a grazing point, with every touch among its turning points as an impact of velocity zero."""
    velocity = motion.velocity.copy()
    velocity[list(motion.rests)] = 0.0
    motion, rests = replace(motion, velocity=velocity), motion.time[list(motion.rests)]
    # Backwards: an impact that is put in moves the numbers of all that follow.
    for turn in reversed(list(turns)):
        if abs(turn.gap) < AT_ZERO and not turn.held and not (np.abs(rests - turn.time) < SAME_TOUCH).any():
            motion = motion.with_impact(turn.after, turn.wall, turn.time)
    return motion


class Beginning(NamedTuple):
    """The beginning of a family at a vertex of the atlas.

    Attributes
    ----------
    event : Event or None
        Event with which the family begins; None where it passes through the vertex.
    curve : Curve
        Curve of its motions.
    vertex, first : PathPoint
        The vertex as a point of that curve, and the first motion next to it.
    """

    event: Event | None
    curve: Curve
    vertex: PathPoint
    first: PathPoint


class VertexOpening(NamedTuple):
    """The families of one word that may begin at a vertex, with the impacts of the word."""

    impacts: int
    families: Iterator[Beginning]


def neighbours(curve: Curve, motion: Motion, event: Event, limits: Limits) -> Iterator[Beginning]:
    """All families that meet at a vertex; parameters are those of `openings`."""
    return chain.from_iterable(opening.families for opening in openings(curve, motion, event, limits))


def openings(curve: Curve, motion: Motion, event: Event, limits: Limits) -> Iterator[VertexOpening]:
    """Candidates for families that begin at a vertex, word by word, the fewest impacts first.

    Parameters
    ----------
    curve : Curve
        Curve of the family that the vertex lies on.
    motion : Motion
        Motion at the vertex; at a grazing point with its touches as impacts, see `touching`.
    event : Event
        Of the vertex.
    limits : Limits
        Of the motions.

    Yields
    ------
    VertexOpening
        Nothing is solved for before the first of its families is drawn: at a grazing point the number of words doubles
        with each period, 8,800 for one impact and one touch in up to sixteen periods.
    """
    if event in (Event.GRAZING, Event.ZERO_VELOCITY):
        yield from _at_grazing(curve, motion, limits)
    elif event is Event.PERIOD_DOUBLING:
        yield VertexOpening(2 * len(motion.word), _doubled(curve, motion))
    elif event is Event.PITCHFORK:
        yield VertexOpening(len(motion.word), _at_pitchfork(curve, motion))


def _doubled(curve: Curve, motion: Motion) -> Iterator[Beginning]:
    """The families at a period doubling: of the doubled word, and the one whose period doubles."""
    # lambda = -1 of one period is lambda = 1 of two: as a motion of the doubled word it is a crossing of families, of
    # which one repeats itself after half the impacts.
    twice = motion.times(2)
    side = replace(curve, word=twice.word)
    x = side.vector(twice)
    away = _across(side, x, mirror=False)
    yield from (Beginning(Event.PERIOD_DOUBLING, side, *pair) for pair in off(side, x, away))
    x = curve.vector(motion)
    yield from (Beginning(None, curve, *pair) for pair in off(curve, x, curve.tangent(x)))


def _at_pitchfork(curve: Curve, motion: Motion) -> Iterator[Beginning]:
    """The families at a pitchfork: the two asymmetric ones, and the symmetric one."""
    x = curve.vector(motion)
    away = _across(curve, x, mirror=True)
    yield from (Beginning(Event.PITCHFORK, curve, *pair) for pair in off(curve, x, away))
    yield from (Beginning(None, curve, *pair) for pair in off(curve, x, _across(curve, x, mirror=True, kept=True)))


def _at_grazing(curve: Curve, motion: Motion, limits: Limits) -> Iterator[VertexOpening]:
    """Candidates at a grazing point: in one or several periods, each touch may be an impact or not."""
    rests, size = motion.rests, len(motion.word)
    removals = list(chain.from_iterable(combinations(rests, count) for count in range(len(rests) + 1)))
    most = min(limits.periods // motion.word.periods, limits.impacts // (size - len(rests)))
    choices = []
    for choice in _unrepeated(len(removals), most):
        removed = [i + period * size for period, which in enumerate(choice) for i in removals[which]]
        choices.append((len(choice) * size - len(removed), len(choice), removed))
    for impacts, count, removed in sorted(choices):
        if impacts <= limits.impacts:
            yield VertexOpening(impacts, _touched(curve, motion, count, removed))


def _unrepeated(letters: int, longest: int) -> Iterator[tuple[int, ...]]:
    """Sequences of numbers below `letters` that are less than all their rotations (Lyndon words).

    So every motion comes once, not from each of its periods, and no sequence repeats a shorter one.

    Source: J.-P. Duval, Theoretical Computer Science 60 (1988) 255.
    """
    # The next word in order is the last one repeated up to the longest, without largest letters at its end, and with
    # the letter before these raised by one.
    word = [-1]
    while word and longest:
        word[-1] += 1
        yield tuple(word)
        word = (word * longest)[:longest]
        while word and word[-1] == letters - 1:
            word.pop()


def _touched(curve: Curve, motion: Motion, count: int, removed: list[int]) -> Iterator[Beginning]:
    """The families that begin where some of the touches in a number of periods are no impacts.

    Parameters
    ----------
    curve : Curve
    motion : Motion
        With its touches as impacts.
    count : int
        Number of its periods.
    removed : list of int
        Touches in these periods that are no impacts.
    """
    without = motion.times(count).without_impacts(removed).representative(curve.model.horizontal)
    side = replace(curve, word=without.word)
    begins = Event.GRAZING if len(removed) == count * len(motion.rests) else Event.ZERO_VELOCITY
    x = side.vector(without)
    tangent = side.tangent(x)
    yield from (Beginning(begins, side, *pair) for way in (tangent, -tangent) for pair in off(side, x, way))


def off(path: Path, x: Floats, direction: Floats) -> Iterator[tuple[PathPoint, PathPoint]]:
    """A vertex as a point of a path and the first motion next to it, if there is one within the range.

    Parameters
    ----------
    path : Path
    x : ndarray
        Unknowns of the vertex.
    direction : ndarray
        Unit vector, in unknowns over their scale.
    """
    for step in STEPS_OFF:
        y = path.solved(x + step * path.scale * direction, direction)
        if y is not None and path.admits(y):
            first = path.point(y, direction)
            if path.leaves(x, first) or step == STEPS_OFF[-1]:
                yield PathPoint(path, x, direction), first
                return


def _image(vector: Floats, mirror: bool) -> Floats:
    """A change of the unknowns with the impacts counted half a period later; with `mirror`, of the mirror image."""
    count = len(vector) // 2
    velocity, time = np.roll(vector[:count], count // 2), np.roll(vector[count:-1], count // 2)
    return np.concatenate([-velocity if mirror else velocity, time, vector[-1:]])


def _across(curve: Curve, x: Floats, mirror: bool, kept: bool = False) -> Floats:
    """Direction from a crossing of two families in which a motion loses its symmetry, or with `kept` keeps it.

    Parameters
    ----------
    curve : Curve
    x : ndarray
        Unknowns of the motion at which the families cross.
    mirror : bool
        Whether the symmetry is that of the mirror image; else that of two equal halves.
    kept : bool
    """
    # Where two families cross the derivatives have a kernel of two dimensions, which the symmetry maps onto itself. The
    # decomposition gives any two vectors of it, in general directions of neither family: the part that the symmetry
    # reverses, or keeps, is the direction wanted.
    kernel, sign = np.linalg.svd(curve.linearised(x)[1])[2][-2:], 1 if kept else -1
    parts = (vector + sign * _image(vector, mirror) for vector in kernel)
    direction = max(parts, key=lambda part: float(np.linalg.norm(part)))
    return np.asarray(direction / np.linalg.norm(direction))
