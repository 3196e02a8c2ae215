"""A recorded force as the cubic spline of its samples, cut where the relative acceleration is zero.

Between two samples the relative acceleration is a cubic in time, its integrals the velocity and the position of the
ball in the capsule. A piece on which it does not change its sign makes the position convex or concave, which is what a
search for impacts needs to miss none.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FEWEST_SAMPLES = 4
"""Samples that a spline without knots next to its ends needs."""

REAL = 1e-9
"""Imaginary part of a root, over the step, up to which it counts as a time: a cut too many does no harm."""


class Cubics(Struct, frozen=True, eq=False):
    """The relative acceleration Z'' in pieces on which it is a cubic and has one sign (dimensionless).

    Attributes
    ----------
    rows : ndarray, shape (m, 6)
        Of each piece, one after another: its length in time; Z'' and its three derivatives at its beginning; and the
        sign that makes Z concave, -1 where Z'' is positive.
    """

    rows: Floats

    @property
    def duration(self) -> float:
        """Time from the first sample to the last."""
        return float(self.rows[:, 0].sum())

    @staticmethod
    def of(samples: Floats, step: float, gbar: float) -> Cubics:
        """The cubics of the spline through samples at equal steps.

        The spline has no knot at the second sample and the last but one: so its error is of the fourth order in the
        step up to its ends.

        Parameters
        ----------
        samples : ndarray, shape (n,)
            Acceleration of the capsule (dimensionless, as all arguments are).
        step : float
            Time from a sample to the next.
        gbar : float
            Gravity along the capsule, which is added.

        Raises
        ------
        ValueError
            If there are fewer than four samples.
        """
        if len(samples) < FEWEST_SAMPLES:
            raise ValueError(f"{len(samples)} samples (at least {FEWEST_SAMPLES} are needed)")
        from scipy.interpolate import CubicSpline  # type: ignore[import-untyped]

        spline = CubicSpline(step * np.arange(len(samples)), np.asarray(samples, dtype=float) + gbar)
        third, second, first, value = spline.c
        plain = np.column_stack([np.full(len(value), step), value, first, 2 * second, 6 * third])
        return Cubics(_of_one_sign(plain))


def shifted(row: Floats, since: float) -> Floats:
    """Value and three derivatives of a cubic a time later, from those at its beginning."""
    value, rate, bend, jerk = row
    return np.array(
        [
            value + since * (rate + since * (bend / 2 + since * jerk / 6)),
            rate + since * (bend + since * jerk / 2),
            bend + since * jerk,
            jerk,
        ]
    )


def _of_one_sign(plain: Floats) -> Floats:
    """Pieces cut where their cubics are zero, as rows of `Cubics`.

    Parameters
    ----------
    plain : ndarray, shape (m, 5)
        Length in time, and value and three derivatives at the beginning, of each piece.
    """
    step, value, rate, bend, jerk = plain.T
    # A cubic lies between its Bernstein coefficients: if these have one sign, it has no zero. So roots are needed for a
    # few pieces only.
    end, end_rate = value + step * (rate + step * (bend / 2 + step * jerk / 6)), rate + step * (bend + step * jerk / 2)
    hull = np.stack([value, value + step * rate / 3, end - step * end_rate / 3, end])
    unclear = np.flatnonzero((hull.min(axis=0) <= 0) & (hull.max(axis=0) >= 0))
    cut = {k: _cut(plain[k]) for k in unclear.tolist()}
    counts = np.ones(len(plain), dtype=int)
    counts[unclear] = [len(cut[k]) for k in unclear.tolist()]
    rows = np.repeat(plain, counts, axis=0)
    beginnings = np.cumsum(counts) - counts
    for k, parts in cut.items():
        rows[beginnings[k] : beginnings[k] + counts[k]] = parts
    half = rows[:, 0] / 2
    # The sign at the middle is that of the whole piece, as it was cut at all zeros.
    middle = rows[:, 1] + half * (rows[:, 2] + half * (rows[:, 3] / 2 + half * rows[:, 4] / 6))
    return np.column_stack([rows, np.where(middle > 0, -1.0, 1.0)])


def _cut(row: Floats) -> Floats:
    """The parts of a piece between the zeros of its cubic, as rows of the same five numbers."""
    step, (value, rate, bend, jerk) = row[0], row[1:]
    roots = np.roots([jerk * step**3 / 6, bend * step**2 / 2, rate * step, value])
    times = np.sort(roots.real[np.abs(roots.imag) < REAL]) * step
    edges = np.concatenate([[0.0], times[(times > 0) & (times < step)], [step]])
    edges = edges[np.concatenate([[True], np.diff(edges) > 0])]
    return np.array([[b - a, *shifted(row[1:], a)] for a, b in pairwise(edges.tolist())])
