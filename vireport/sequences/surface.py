"""Motions with three impacts, searched for over all of their flight times.

At given flight times the conditions are linear and homogeneous in the velocities, the sine and cosine of the phase,
gbar and d. With three impacts they leave one solution for each pair of flight times, without iteration; a sweep is a
curve in the plane of both, on which a sign changes.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from vireport.physics import flight
from vireport.sequences.equations import Model
from vireport.sequences.motions import Motion, Sequence

Floats = NDArray[np.float64]

CELLS = 60
"""Cells of the grid along one forcing period: families that are smaller than a cell can be missed."""

ROWS = 8
"""Rows of the grid at a time, few enough for the processor's cache."""

AROUND = 0.1
"""Velocity of the wrong sign [y_c] that the corner of a cell may have in which there is a motion."""

CELL = 2 / CELLS
"""Side of a cell [t_c]."""


def three_impacts(model: Model, sequence: Sequence, low: float, high: float) -> Iterator[Motion]:
    """Solutions close to those of a sweep, in every cell that its curve passes, as starts for Newton's method.

    Parameters
    ----------
    model : Model
    sequence : Sequence
        Of three impacts.
    low, high : float
        Range of the coordinate.
    """
    count = CELLS * sequence.periods
    share = (np.arange(count) + 0.5) / count
    for row in range(0, count, ROWS):
        first, second = np.meshgrid(share[row : row + ROWS + 1], share[: count - row], indexing="ij")
        time = 2 * sequence.periods * np.stack([0 * first, first, first + second])
        velocity, sine, cosine, gbar, d = _solution(sequence, time, model.r)
        coordinate = d if model.slope[0] else gbar
        held = model.groups(coordinate)
        value = gbar - held[1] if model.slope[0] else d - held[0]
        sound = (np.array(sequence.walls)[:, None, None] * velocity > -AROUND).all(axis=0) & (first + second < 1)
        sound &= np.abs(coordinate - (low + high) / 2) < high - low
        crossing = np.zeros_like(sound)
        for here, there in ((np.s_[:-1, :], np.s_[1:, :]), (np.s_[:, :-1], np.s_[:, 1:])):
            crossing[here] |= sound[here] & sound[there] & (value[here] * value[there] <= 0)
        for i, j in np.argwhere(crossing):
            start = float(np.arctan2(sine[i, j], cosine[i, j])) / np.pi
            start -= 2 * np.floor(start / 2)
            yield Motion(sequence, velocity[:, i, j], start + time[:, i, j], float(coordinate[i, j]))


def _solution(sequence: Sequence, time: Floats, r: float) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Velocities, sine and cosine of the phase at the first impact, gbar and d, for the times since it (3, ...)."""
    count, walls = len(sequence), sequence.walls
    ends = [*time[1:], time[0] + 2 * sequence.periods]
    zero, one = np.zeros_like(time[0]), np.ones_like(time[0])
    velocities, rows = [], []
    for of_sine, of_cosine, gbar in ((one, zero, zero), (zero, one, zero), (zero, zero, one)):
        phases = [np.pi * t for t in (*time, time[0])]
        sines = [of_sine * np.cos(p) + of_cosine * np.sin(p) for p in phases]
        cosines = [of_cosine * np.cos(p) - of_sine * np.sin(p) for p in phases]
        flights = [end - start for start, end in zip(time, ends, strict=True)]
        gains = [flight.velocity(flights[i], 0.0, sines[i], sines[i + 1], gbar) for i in range(count)]
        velocity = [sum((-r) ** (count - 1 - i) * gain for i, gain in enumerate(gains)) / (1 - (-r) ** count)]
        for gain in gains[:-1]:
            velocity.append(gain - r * velocity[-1])
        velocities.append(velocity)
        after = (flight.reflect(v, r) for v in velocity)
        ends_of = zip(flights, after, sines, cosines, cosines[1:], strict=False)
        rows.append([flight.displacement(*of, gbar) for of in ends_of])
    ways = [(walls[(i + 1) % count] - walls[i]) // 2 for i in range(count)]
    columns = [*rows, [-way * one for way in ways]]
    kernel = np.stack([(-1) ** i * _determinant(*(columns[k] for k in range(4) if k != i)) for i in range(4)])
    with np.errstate(invalid="ignore", divide="ignore"):  # where flight times leave more than one solution
        kernel /= np.hypot(kernel[0], kernel[1])
    velocity = np.einsum("b...,bi...->i...", kernel[:3], np.array(velocities))
    sign = np.sign(kernel[3])
    return sign * velocity, *(sign * part for part in kernel)


def _determinant(a: list[Floats], b: list[Floats], c: list[Floats]) -> Floats:
    """Of the matrices with these columns."""
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
