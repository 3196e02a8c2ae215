"""The stable manifold of an unstable motion, a line that bounds basins: grown backwards by explicit steps.

Turns a motion into pieces of the line on the sections of impacts, and these into lines in the plane of time and size of
a shock. Backwards the map stretches the line and draws neighbouring points towards it, so that points interpolated
linearly between two others are on it after a few impacts.
"""

from __future__ import annotations

from collections import deque
from math import ceil, log, pi
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.findings.outcomes.deviations import lap_matrix
from vireport.findings.outcomes.impact_map import Arrivals, backwards
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import ARRAYS

Floats = NDArray[np.float64]

BEGINNING, FIRST_POINTS = 1e-3, 12
"""Length in time [t_c] or velocity [y_c] of the straight line that it begins with on either side, and points there."""

HALVINGS, FINEST = 14, 1e-7
"""Times that points are put in between two others, and how close they may come: there the line breaks where one flight
meets a membrane that the next one passes."""

PERIODS, MOST_PERIODS = 1, 40
"""Periods that the line is followed back from where it is about as long as the motion's own velocities, and in all."""

MOST_POINTS = 20_000
"""Points on one section at which it is followed no further."""

BREAK = 4.0
"""Gap between two points of one line, in spacings, from which they are not joined."""


class ManifoldPiece(Struct, frozen=True, eq=False):
    """A continuous part of the manifold: flights that begin on one membrane and end on one, as arrays (n,).

    Attributes
    ----------
    start_wall : int
        The membrane on which the flights begin: 1 bottom, -1 top.
    start_time, end_time : ndarray
        [t_c], the forcing phase being pi times that; the clocks of flights may differ by whole forcing periods.
    after, before : ndarray
        Relative velocity just after the impact that begins a flight, and just before the one that ends it [y_c].
    """

    start_wall: int
    start_time: Floats
    end_time: Floats
    after: Floats
    before: Floats


class ShockLine(NamedTuple):
    """A part of the manifold in the plane of shocks to a motion.

    Attributes
    ----------
    time : ndarray (n,)
        Of the shock, since the motion's first impact [t_c].
    jump : ndarray (n,)
        Of the relative velocity [y_c].
    """

    time: Floats
    jump: Floats


class _Line(NamedTuple):
    """Points of the manifold just before impacts, and the number of the continuous part that each belongs to."""

    wall: Floats
    time: Floats
    before: Floats
    part: Floats

    def at(self, rows: NDArray[np.bool_]) -> _Line:
        return _Line(*(column[rows] for column in self))


def stable_manifold(
    groups: Groups[float], companion: Motion, fastest: float, spacing: float = 0.02
) -> tuple[ManifoldPiece, ...]:
    """Follow the stable manifold of an unstable motion backwards from it; () where it has none that is a line.

    Parameters
    ----------
    groups : Groups
        Of the device; r must not be zero.
    companion : Motion
        With one multiplier inside the unit circle and one outside.
    fastest : float
        Velocity before an impact up to which the line is wanted [y_c].
    spacing : float
        Distance of neighbouring points in time [t_c] and velocity [y_c].
    """
    values, vectors = np.linalg.eig(lap_matrix(groups, companion))
    inside = int(np.argmin(np.abs(values)))
    contraction = abs(values[inside])
    if not (np.isreal(values).all() and 0 < contraction < 1 < abs(values[1 - inside])):
        return ()
    direction = vectors[:, inside].real / np.abs(vectors[:, inside]).max()
    # The eigenvector is the tangent. The line curves little away from it over so short a length; this deviation, as any
    # from the line, shrinks with every period back by the multiplier outside the unit circle.
    distance = BEGINNING * np.linspace(0, 1, FIRST_POINTS)
    offset = np.concatenate([distance, -distance])
    line = _Line(
        np.full(len(offset), float(companion.word.walls[0])),
        companion.time[0] + offset * direction[0],
        companion.velocity[0] + offset * direction[1],
        np.repeat([0.0, 1.0], FIRST_POINTS),
    )
    count = len(companion.word)
    # Backwards the line grows by the inverse of the multiplier inside, from its beginning to velocities of order 1.
    periods = min(PERIODS + ceil(log(BEGINNING) / log(contraction)), MOST_PERIODS)
    # Each image of the line a period back contains the one before: the last images have all of it.
    images: deque[list[ManifoldPiece]] = deque(maxlen=count)
    for _ in range(periods * count):
        line, begun = _refined(groups, line, fastest, spacing)
        pieces, line = _cut(groups, line, begun, fastest, spacing)
        images.append(pieces)
        if not 0 < len(line.time) <= MOST_POINTS:
            break
    return tuple(piece for image in images for piece in image)


def _refined(groups: Groups[float], line: _Line, fastest: float, spacing: float) -> tuple[_Line, Arrivals]:
    """Add points to a line until their images a flight back are close to one another; the line, and the images."""
    begun = backwards(groups, *line[:3])
    for _ in range(HALVINGS):
        apart, alike, inside = _steps(groups, line, begun, fastest)
        steps = np.maximum(np.abs(np.diff(line.time)), np.abs(np.diff(line.before)))
        # Two points a flight back on unlike membranes have a break between them, which no number of points closes:
        # `FINEST` ends the search for it.
        needed = (line.part[1:] == line.part[:-1]) & inside & (~alike | (apart > spacing)) & (steps > FINEST)
        if not needed.any() or len(line.time) > MOST_POINTS:
            break
        at = np.flatnonzero(needed)
        time, before = ((column[at] + column[at + 1]) / 2 for column in (line.time, line.before))
        between = _Line(line.wall[at], time, before, line.part[at])
        more = backwards(groups, *between[:3])
        line = _Line(*(np.insert(old, at + 1, new) for old, new in zip(line, between, strict=True)))
        begun = Arrivals(*(np.insert(old, at + 1, new) for old, new in zip(begun, more, strict=True)))
    return line, begun


def _steps(
    groups: Groups[float], line: _Line, begun: Arrivals, fastest: float
) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Between neighbours: distance of the impacts before, whether these are on one membrane, and whether one counts."""
    speed = _before(groups, begun)
    apart = np.maximum(np.abs(np.diff(begun.time)), np.abs(np.diff(speed)))
    wanted = (begun.wall != 0) & (np.abs(speed) <= fastest)
    return apart, begun.wall[1:] == begun.wall[:-1], wanted[1:] | wanted[:-1]


def _before(groups: Groups[float], begun: Arrivals) -> Floats:
    """Velocities [y_c] just before the impacts that begin flights, from those just after them."""
    r = np.array([groups.restitution_at(1) if wall > 0 else groups.restitution_at(-1) for wall in begun.wall.tolist()])
    return np.asarray(-begun.velocity / r)


def _cut(
    groups: Groups[float], line: _Line, begun: Arrivals, fastest: float, spacing: float
) -> tuple[list[ManifoldPiece], _Line]:
    """The pieces of a line whose images a flight back are continuous, and the line of these images."""
    apart, alike, _ = _steps(groups, line, begun, fastest)
    speed = _before(groups, begun)
    wanted = (begun.wall != 0) & (np.abs(speed) <= fastest) & (begun.wall * speed > 0)
    # Some gaps stay wider than the spacing: the halvings end before, where the line is stretched most.
    joined = alike & (apart <= BREAK * spacing) & (line.part[1:] == line.part[:-1]) & wanted[1:] & wanted[:-1]
    part = np.concatenate([[0.0], np.cumsum(~joined)])
    back = _Line(begun.wall, begun.time, speed, part).at(wanted)
    pieces = []
    for rows in np.split(np.arange(len(part)), np.flatnonzero(~joined) + 1):
        if len(rows) > 1:
            columns = (begun.time, line.time, begun.velocity, line.before)
            pieces.append(ManifoldPiece(int(begun.wall[rows[0]]), *(column[rows] for column in columns)))
    return pieces, back


def on_shocks(groups: Groups[float], motion: Motion, piece: ManifoldPiece) -> list[ShockLine]:
    """The lines that a piece of the manifold makes in the plane of time and size of a shock to a motion.

    Notes
    -----
    Without friction, two flights under the same forcing differ by a linear function of time. Where it is zero, a jump
    by its slope takes the ball from one to the other: no search is needed.
    """
    lines: list[ShockLine] = []
    begins = float(motion.time[0])
    for wall, start, duration, velocity in zip(
        motion.word.walls, motion.time.tolist(), motion.durations.tolist(), motion.velocity.tolist(), strict=True
    ):
        after = float(groups.after(wall, velocity))
        # Clocks agree up to whole forcing periods, of which a few let the flights overlap.
        soonest = 2 * np.ceil((start - float(piece.end_time.max())) / 2)
        latest = start + duration - float(piece.start_time.min())
        for shift in np.arange(soonest, latest, 2.0).tolist():
            begun, finish = piece.start_time + shift, piece.end_time + shift
            low, high = np.maximum(begun, start), np.minimum(finish, start + duration)
            position, speed = _state(groups, low, piece.start_wall, begun, piece.after)
            undisturbed, undisturbed_speed = _state(
                groups, low, wall, np.full(len(low), start), np.full(len(low), after)
            )
            jump = speed - undisturbed_speed
            with np.errstate(divide="ignore", invalid="ignore"):
                time = low - (position - undisturbed) / jump
            # Where the flights have the same velocity (jump 0) they never cross: the time is NaN.
            crosses = (low <= high) & (time >= low) & (time <= high)
            for rows in np.split(np.arange(len(crosses)), np.flatnonzero(np.diff(crosses)) + 1):
                if crosses[rows[0]] and len(rows) > 1:
                    lines.append(ShockLine(time[rows] - begins, jump[rows]))
    return lines


def _state(groups: Groups[float], time: Floats, wall: int, start: Floats, after: Floats) -> tuple[Floats, Floats]:
    """Position and velocity [y_c] at some times [t_c] of flights that begin on a membrane."""
    elapsed, begun, now = time - start, groups.wave(pi * start, ARRAYS), groups.wave(pi * time, ARRAYS)
    covered, speed = groups.flown(elapsed, after, begun, now, -wall)
    return np.asarray(wall * groups.d / 2 + covered), np.asarray(speed)
