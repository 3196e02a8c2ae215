"""All 1:1 motions at many design points at once, without a guess: found, evaluated and sorted out.

Turns arrays of d and gbar at one restitution into flat arrays of motions, a design point having none, one or several.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.admissibility import wall_gap
from vireport.analysis.orbits import Orbits, coefficients, orbits
from vireport.analysis.phase_forms import Grid, Points, Tables, forms, grid_of, tables_of
from vireport.analysis.scan import zeros
from vireport.analysis.stability import trace_and_determinant
from vireport.analysis.strands import reach

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

BLOCK_POINTS = 8192
"""Design points whose zeros are finished at once."""

SCALES = (1.0, 1e-2, 1e-6, 1e-15)
"""Lower ends of the ranges of gbar that share a grid; the last is `model.NO_GRAVITY`. The finer a capsule's
inclination, the nearer to u = 0 its grid has to begin."""

HORIZONTAL = len(SCALES)
"""In the place of a range of gbar: no gravity along the capsule, and odd n."""

FEWEST_SHARING = 64
"""Design points with one restitution, on average, from which it pays to tabulate what they share."""

AT_SYMMETRY = 1e-13
"""|u| below which a zero that is left after the symmetric family was divided out is a pitchfork, a symmetric motion."""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """Motions of many design points, ordered by design point and then by q; arrays of one length.

    Attributes
    ----------
    cell : ndarray of int
        Which design point.
    orbit : Orbits
        With velocity_bottom > 0 > velocity_top, and the design point's own gbar and d.
    trace : ndarray
        Of DP, Eq. (4.3).
    wall_gap : ndarray
        See `admissibility.wall_gap`; a solution with a gap of zero or less is no motion.
    """

    cell: Ints
    orbit: Orbits
    trace: Floats
    wall_gap: Floats

    @property
    def admissible(self) -> NDArray[np.bool_]:
        """Whether the ball stays between the membranes."""
        return np.asarray(self.wall_gap > 0)


def find_motions(d: Floats, gbar: Floats, r: float | Floats, n: int) -> Found:
    """Every 1:1 motion at each of many design points, admissible or not.

    Parameters
    ----------
    d, gbar : ndarray, shape (cells,)
        The dimensionless groups; d > 0, gbar zero or above `model.NO_GRAVITY`.
    r : float or ndarray
        Restitution coefficient, 0 <= r < 1. Points that share one take a fifth of the time.
    n : int
        Forcing periods per motion, the same for all.
    """
    each = np.broadcast_to(np.asarray(r, dtype=float), d.shape)
    groups: list[tuple[Ints, float | None]]
    one = np.ndim(r) == 0  # then without np.unique, which imports numpy.ma and takes longer than a design point
    shared, place = (np.atleast_1d(r), np.zeros(len(d))) if one else np.unique(each, return_inverse=True)
    if len(shared) > 1 and len(shared) * FEWEST_SHARING > len(d):
        groups = [(np.arange(len(d)), None)]
    else:
        groups = [(np.flatnonzero(place == k), float(value)) for k, value in enumerate(shared)]
    parts = [_evaluated(np.empty(0, dtype=np.intp), np.empty(0), np.empty(0), d, gbar, each, n)]
    for cells, value in groups:
        for chosen, points in _portions(cells, d, gbar, each, n, value):
            which, u, phi = zeros(points)
            if points.grid.divided:
                which, u, phi = _with_symmetric(which, u, phi, points)
            parts.append(_evaluated(chosen[which], u, phi, d, gbar, each, n))
    orbit = Orbits(*(np.concatenate([getattr(p.orbit, f.name) for p in parts]) for f in fields(Orbits)))
    cell, trace, gap = (np.concatenate([getattr(p, name) for p in parts]) for name in ("cell", "trace", "wall_gap"))
    order = np.lexsort((orbit.phi, orbit.u, cell))
    return Found(cell[order], _picked(orbit, order), trace[order], gap[order])


def _portions(
    cells: Ints, d: Floats, gbar: Floats, r: Floats, n: int, shared: float | None
) -> Iterator[tuple[Ints, Points]]:
    """Cut design points into portions that fit the cache, each on the grid that its gbar needs."""
    if shared is not None:
        largest_d, largest_gbar = reach(shared, n)
        cells = cells[(d[cells] <= largest_d) & (gbar[cells] <= largest_gbar)]
    kind = np.searchsorted(-np.array(SCALES), -gbar[cells]) if n % 2 else np.zeros(len(cells), dtype=np.intp)
    kind[(gbar[cells] == 0) & (n % 2 == 1)] = HORIZONTAL
    for scale in range(HORIZONTAL + 1):
        same = cells[kind == scale]
        for first in range(0, same.size, BLOCK_POINTS):
            chosen = same[first : first + BLOCK_POINTS]
            grid = _grid(float(r[chosen].max()), n, scale)
            tables = None if shared is None else _tables(shared, n, scale)
            yield chosen, Points(grid, d[chosen], gbar[chosen], r[chosen], tables)


@lru_cache(maxsize=64)
def _grid(r: float, n: int, scale: int) -> Grid:
    """The grid for one range of gbar, and for restitutions up to `r`.

    Next to u = 0 and for odd n, a gbar + b d = Delta is a balance of gbar a(0) with terms that grow as u: no zero is
    nearer to u = 0 than where the largest of these would do.
    """
    if scale == HORIZONTAL:
        return grid_of(n, None)
    if n % 2 == 0:
        return grid_of(n, 1.0)
    step = 1e-6
    at, beside = forms(np.array(0.0), r, n), forms(np.array(step), r, n)
    growth = (abs(beside.delta) + reach(r, n)[0] * np.hypot(beside.sine_d, beside.cosine_d)) / step
    return grid_of(n, float(SCALES[scale] * np.hypot(at.sine_gbar, at.cosine_gbar) / growth))


@lru_cache(maxsize=64)
def _tables(r: float, n: int, scale: int) -> Tables:
    return tables_of(_grid(r, n, scale), r)


def _with_symmetric(which: Ints, u: Floats, phi: Floats, points: Points) -> tuple[Ints, Floats, Floats]:
    """Add the symmetric motions of a horizontal capsule: d_sine sin + d_cosine cos = d at u = 0 has two phases."""
    k = coefficients(np.zeros_like(points.d), points.r, points.grid.n)
    ratio = points.d / np.hypot(k.d_sine, k.d_cosine)
    here = np.flatnonzero(ratio <= 1)
    middle, reach = np.arctan2(k.d_sine, k.d_cosine)[here], np.arccos(ratio[here])
    own = np.abs(u) > AT_SYMMETRY
    return (
        np.concatenate([which[own], here, here]),
        np.concatenate([u[own], np.zeros(2 * here.size)]),
        np.concatenate([phi[own], middle + reach, middle - reach]),
    )


def _evaluated(cell: Ints, u: Floats, phi: Floats, d: Floats, gbar: Floats, r: Any, n: int) -> Found:
    """What is known of solutions, those that are none by the sign of a velocity left out."""
    orbit = orbits(u, phi, r[cell], n)
    right = (orbit.velocity_bottom > 0) & (orbit.velocity_top < 0)
    orbit, cell = _picked(orbit, right), cell[right]
    orbit = replace(orbit, gbar=gbar[cell], d=d[cell])
    return Found(cell, orbit, np.asarray(trace_and_determinant(orbit, r[cell])[0]), wall_gap(orbit, r[cell], n))


def _picked(orbit: Orbits, index: Any) -> Orbits:
    return Orbits(*(np.asarray(getattr(orbit, field.name))[index] for field in fields(Orbits)))
