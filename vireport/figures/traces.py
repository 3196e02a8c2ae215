"""What of simulated motions is drawn, as plain arrays: flights, impacts, displacements, and the words of motions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vireport.text import significant

if TYPE_CHECKING:
    from vireport.simulation import Diagram, Portrait

Floats = NDArray[np.float64]
Curve = tuple[Floats, Floats]
Rows = NDArray[np.intp]

AT_WALL = 1e-9
"""Share of d within which a position is on a membrane."""

RIDE = 1e-4
"""Time from which a ball that leaves a membrane later than it came has ridden on it [t_c]."""

LEAST_MOTION = 1e-6
"""Velocity up to which nothing is seen to move [y_c]."""

SAMPLES = 160
"""Of the capsule's motion in a forcing period."""

MOST_WORDS = 8
"""Kinds of motion that a diagram tells apart."""

LONGEST_WORD = 14
"""Letters of a word that is written in full."""


def moves(portrait: Portrait) -> bool:
    """Whether there is motion to be drawn: not where the ball rests."""
    return len(portrait.time) > 1 and bool(np.abs(portrait.velocity).max() > LEAST_MOTION)


def arrivals(portrait: Portrait) -> Rows:
    """Samples at which the ball has come to a membrane: an impact each, before its rebound."""
    ends = _breaks(portrait)
    last = len(portrait.time) - 1
    return np.append(ends, last) if last >= 0 and _on_wall(portrait)[last] else ends


def rebounds(portrait: Portrait) -> Rows:
    """The arrivals after which the motion goes on."""
    return _breaks(portrait)


def bottom(portrait: Portrait) -> NDArray[np.bool_]:
    """For each sample, whether it is nearer to the bottom membrane, Z = +d/2."""
    return portrait.position > 0


def flights(portrait: Portrait) -> list[NDArray[np.intp]]:
    """Samples of each flight."""
    return np.split(np.arange(len(portrait.time)), _breaks(portrait) + 1)


def rides(portrait: Portrait) -> Rows:
    """The arrivals after which the ball rides on the membrane."""
    ends = _breaks(portrait)
    return ends[portrait.time[ends + 1] - portrait.time[ends] > RIDE]


def periods(time: Floats) -> Floats:
    """Time in forcing periods, of which one is 2 t_c."""
    return time / 2


def capsule(portrait: Portrait, time: Floats) -> Floats:
    """Displacement of the capsule's centre X [x_c] that solves X'' = cos(pi t + phi) without drift."""
    return np.asarray(-np.cos(np.pi * time + portrait.phase) / np.pi**2)


def ball(portrait: Portrait) -> Curve:
    """Time and displacement x = X - Z of the ball [t_c, x_c], on the membrane where it rides."""
    time, position = portrait.time, portrait.position
    for i in rides(portrait)[::-1]:
        between = even_times(float(time[i]), float(time[i + 1]))
        time, position = np.insert(time, i + 1, between), np.insert(position, i + 1, np.full(len(between), position[i]))
    return time, capsule(portrait, time) - position


def even_times(start: float, end: float) -> Floats:
    """Times from a start to an end [t_c], dense enough for a smooth curve."""
    return np.linspace(start, end, int(np.ceil(SAMPLES * (end - start) / 2)) + 2)


def motion_words(portrait: Portrait) -> str:
    """What a motion is: its word and its period, or its kind."""
    found = portrait.attractor
    if found.cycle is None:
        return found.outcome.value
    every = "every forcing period" if found.period == 1 else f"every {found.period} forcing periods"
    return f"{short(found.word)}, {every}"


def setting(portrait: Portrait) -> str:
    """The parameters of a portrait."""
    return f"{portrait.label}, d = {significant(portrait.d, 4)}, ḡ = {significant(portrait.gbar, 4)}"


def short(word: str) -> str:
    """A word, a long one as its repeated part or its beginning.

    Examples
    --------
    >>> short("BTBT"), short("BT" * 16), short("B" * 17 + "T")
    ('BTBT', '(BT)×16', 'BBBBBBBBBBBBBB… (18)')
    """
    if len(word) <= LONGEST_WORD:
        return word
    unit = next(word[:k] for k in range(1, len(word) + 1) if word[:k] * (len(word) // k) == word)
    if len(unit) <= LONGEST_WORD:
        return f"({unit})×{len(word) // len(unit)}"
    return f"{word[:LONGEST_WORD]}… ({len(word.replace('~', ''))})"


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Points of a diagram that belong to one kind of motion.

    Attributes
    ----------
    name : str
    points : ndarray of bool
        Which of the diagram's.
    values : ndarray of int
        Values of the swept parameter at which it was found.
    """

    name: str
    points: NDArray[np.bool_]
    values: NDArray[np.int64]


def periodic_groups(diagram: Diagram, most: int) -> tuple[list[Group], Group | None]:
    """The words of a diagram, those found at most values first, and what is left over beyond `most`."""
    words = [_group(diagram, short(name), [k]) for k, name in enumerate(diagram.labels) if is_word(name)]
    words = sorted((group for group in words if len(group.values)), key=lambda group: (-len(group.values), group.name))
    if len(words) <= most:
        return words, None
    points = np.logical_or.reduce([group.points for group in words[most:]])
    return words[:most], Group("other", points, np.unique(diagram.index[points]))


def irregular(diagram: Diagram) -> Group:
    """The points of motions that are not periodic."""
    return _group(diagram, "not periodic", [k for k, name in enumerate(diagram.labels) if not is_word(name)])


def is_word(label: str) -> bool:
    """Whether a label of a diagram is a word of impacts."""
    return bool(label) and set(label) <= set("BT~")


def _group(diagram: Diagram, name: str, labels: Iterable[int]) -> Group:
    points = np.isin(diagram.label, list(labels))
    return Group(name, points, np.unique(diagram.index[points]))


def _on_wall(portrait: Portrait) -> NDArray[np.bool_]:
    return np.asarray(np.abs(portrait.position) >= portrait.d * (0.5 - AT_WALL))


def _breaks(portrait: Portrait) -> Rows:
    """Samples after which another flight begins."""
    if len(portrait.time) < 2:
        return np.empty(0, dtype=np.intp)
    wall, step = _on_wall(portrait), np.diff(portrait.time)
    side = np.sign(portrait.position)
    stays = wall[1:] & wall[:-1] & (side[1:] == side[:-1])
    return np.flatnonzero(stays & ((step == 0) | (step > RIDE)))
