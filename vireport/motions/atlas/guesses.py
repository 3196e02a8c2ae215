"""Motions of a word that the user names, at one value of a sweep, from many random guesses."""

from __future__ import annotations

import numpy as np

from vireport.motions.paths import Curve
from vireport.motions.periodicity import Model, linearised
from vireport.physics.motion import SAME, Motion
from vireport.physics.word import Word

TRIED = 1000
"""Number of guesses for a word: 22 to 250 of 1000 came to the stable motion of a word of three to eight impacts, on
four devices, in one to three seconds."""

LEAST_FLIGHT = 0.02
"""Shortest flight of a guess [t_c]: for shorter ones the velocities are such as no motion has."""

STEPS, CLOSE = 60, 1e-4
"""Evaluations by which a guess is improved, and the largest residual from which Newton's method begins."""


def motions_of(word: Word, model: Model, low: float, high: float, coordinate: float) -> list[Motion]:
    """Search for motions of a word at one value of the coordinate of a sweep; some may be missed.

    Parameters
    ----------
    word : Word
        Of any number of impacts.
    model : Model
        Groups over the sweep.
    low, high : float
        Range of the coordinate.
    coordinate : float
        Where the motions are looked for.

    Returns
    -------
    list of Motion
        Without repetitions and mirror images, and without several periods of a shorter motion.
    """
    from scipy.optimize import least_squares  # type: ignore[import-untyped]

    curve, count, motions = Curve.over_sweep(word, model, low, high), len(word), list[Motion]()

    def conditions(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values, matrix = linearised(word, np.append(x, coordinate), model)
        return values, matrix[:, :-1]

    rng = np.random.default_rng(0)  # the same motions in every run
    for time in np.sort(rng.uniform(0.0, 2.0 * word.periods, (TRIED, count))):
        if np.diff(time, append=time[0] + 2.0 * word.periods).min() < LEAST_FLIGHT:
            continue
        # At fixed times the conditions are linear in the velocities, half as many: their least squares complete the
        # guess.
        values, matrix = conditions(np.append(np.zeros(count), time))
        velocity = np.linalg.lstsq(matrix[:, :count], -values, rcond=None)[0]
        # Newton's method alone comes to a motion of eight impacts from one guess in a thousand, this from one in fifty.
        near = least_squares(
            lambda x: conditions(x)[0],
            np.append(velocity, time),
            jac=lambda x: conditions(x)[1],
            method="lm",
            max_nfev=STEPS,
        )
        x = curve.at(np.append(near.x, coordinate), coordinate) if np.abs(near.fun).max() < CLOSE else None
        if x is None or not curve.admits(x):
            continue
        motion = curve.motion(x)
        repeated = any(motion.distance(other, mirror=model.horizontal) < SAME for other in motions)
        if not repeated and motion.primitive() is motion:
            motions.append(motion)
    return motions
