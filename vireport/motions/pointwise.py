"""All 1:1 motions at many design points at once, without a starting guess or a sweep.

For a given q, the equations (3.9)-(3.11) are linear in the velocity, sin(phi) and cos(phi). Cramer's rule gives the
latter two as (gbar a + d b)/Delta with functions a, b and Delta of q alone, and a motion is a zero of the scalar
function G(u) = |gbar a + d b|^2 - Delta^2, u = q - 1/2. The functions are entire for every restitution, unlike the
coefficients of the surface in `orbits`, which have poles next to the real line; so one grid of u, made once, serves all
design points. A change of sign between two samples is a zero; two or three zeros between them show in the slopes.
The general search of `plane`, which also knows harmonics and friction, takes 6 to 13 times as long.

Read `find_motions`, then `_zeros` (the search) and `forms` (the functions).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import pi
from operator import itemgetter
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.level_curve import largest_groups
from vireport.motions.orbits import Dynamics, Friction, Orbits, coefficients, orbits, orbits_of
from vireport.motions.roots import Guesses, cubic_root, secant_root
from vireport.motions.stability import lap_decay, return_trace
from vireport.motions.turning import flight_turns, wall_gap
from vireport.physics.groups import Groups, Restitution, Restitutions, by_wall, map_restitution
from vireport.physics.motion import Motion
from vireport.physics.numbers import IMAGINARY_STEP, Arithmetic
from vireport.physics.word import Word

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

SAMPLES = 96
"""Number of regular samples of G for each forcing period of the motion; half of them are in its shortest wavelength."""

PER_DECADE = 8
"""Samples of each decade of |u| next to the symmetric motion: G varies there with the logarithm of u."""

SCALES = (1.0, 1e-2, 1e-6, 1e-15)
"""Lower ends of the ranges of gbar that share a grid; the last is `physics.NO_GRAVITY`. The finer a capsule's
inclination, the nearer to u = 0 its grid has to begin."""

HORIZONTAL = len(SCALES)
"""Number of the grid for design points without gravity along the capsule, for odd n and membranes that are alike."""

BLOCK_POINTS, BLOCK_VALUES = 4096, 30_000
"""Design points whose zeros are refined at once, and samples of G in memory at once: few enough for the processor's
cache, and for freed memory to stay with the process."""

FEWEST_SHARING = 64
"""Average number of design points with one restitution from which it pays to tabulate what they share."""

DOUBTFUL = 1e-2
"""Value of an extremum between two samples, over the larger value at these, below which it may hide a pair of zeros.
The cubic through values and slopes of two samples is wrong by less than a tenth of it."""

LAST_STEP = 2e-16
"""Step of the search for a zero, as a share of u, at which it ends."""

FLAT = 1e-9
"""Step of the search for an extremum, as a share of u, at which it ends: half the digits of u give all of G there."""

AT_SYMMETRY = 1e-13
"""|u| below which a zero of G, from which the symmetric family has been divided out, is a pitchfork."""


class PointwiseMotions(Struct, frozen=True, eq=False):
    """1:1 motions of many design points, ordered by design point and then by q; arrays of one length.

    Attributes
    ----------
    cell : ndarray of int
        Number of the design point of each motion.
    orbit : Orbits
        With velocity_bottom > 0 > velocity_top, and gbar and d of the design point.
    trace : ndarray
        Trace of DP, Eq. (4.3).
    wall_gap : ndarray
        See `turning.wall_gap`; a solution with a gap of zero or less is no motion.
    """

    cell: Ints
    orbit: Orbits
    trace: Floats
    wall_gap: Floats

    def motion(self, row: int, n: int) -> Motion:
        """The motion of a row, which takes n forcing periods, by its impacts; its coordinate is d."""
        orbit = self.orbit
        start = float(np.mod(orbit.phi[row], 2 * pi)) / pi
        velocity = np.array([orbit.velocity_bottom[row], orbit.velocity_top[row]])
        time = np.array([start, start + 2 * n * (0.5 + float(orbit.u[row]))])
        return Motion(Word((1, -1), n), velocity, time, float(orbit.d[row]))

    @property
    def admissible(self) -> NDArray[np.bool_]:
        """Whether the ball stays between the membranes."""
        return np.asarray(self.wall_gap > 0)

    def stable(self, r: Restitution, slack: float = 0.0) -> Mask:
        """Whether motions are stable and admissible.

        Parameters
        ----------
        r : array_like or Restitutions
            Restitution of the design points.
        slack : float
            Amount by which the trace [-] and the gap [x_c] may miss their limits.
        """
        of_cell = map_restitution(r, lambda x: x.real[self.cell])
        decay = lap_decay(of_cell) if isinstance(of_cell, Restitutions) else of_cell**2
        within = np.abs(self.trace.real) < TRACE_LEVELS[Event.FOLD](decay) + slack
        return np.asarray(within & (self.wall_gap.real > -slack))


def find_motions(groups: Groups[Any], n: int) -> PointwiseMotions:
    """Find every 1:1 motion at each of many design points, admissible or not.

    Parameters
    ----------
    groups : Groups
        Arrays of shape (cells,), d > 0, gbar zero or above `physics.NO_GRAVITY`; the restitution, 0 <= r < 1, may be
        one number. Points that share one take a fifth of the time.
    n : int
        Forcing periods per motion, the same for all.
    """
    r = groups.restitution
    of_cells = map_restitution(r, lambda x: np.broadcast_to(np.asarray(x, dtype=float), groups.d.shape))
    points = groups._replace(restitution=of_cells)
    if groups.same_harmonics or groups.friction is not None:
        from vireport.motions.plane import motions_in_plane

        return _evaluated(*motions_in_plane(groups, of_cells, n), points, n)
    every = np.arange(len(groups.d))
    kinds: list[tuple[Ints, Any, Any]] = [(every, r, of_cells)]  # cells, their restitutions, those of all cells
    if isinstance(of_cells, Restitutions):
        # Some points may have two membranes that are alike all the same: their symmetric motions are at u = 0 exactly,
        # and only the forms for one restitution divide these out.
        alike = of_cells.bottom == of_cells.top
        common = of_cells.bottom
        kinds = [
            (every[alike], common[alike], common),
            (every[~alike], map_restitution(of_cells, itemgetter(~alike)), of_cells),
        ]
    parts = [(np.empty(0, dtype=np.intp), np.empty(0), np.empty(0))]
    for of_kind, restitution, of_all in kinds:
        # A table pays where many points share it: with few points to a restitution r is an array, with forms for each
        # point.
        shared = _different(restitution)
        if len(shared) > 1 and len(shared) * FEWEST_SHARING > len(of_kind):
            sharing: list[tuple[Ints, Any]] = [(of_kind, None)]
        else:
            sharing = [(of_kind[_is(map_restitution(of_all, itemgetter(of_kind)), value)], value) for value in shared]
        for cells, value in sharing:
            for chosen, portion in _portions(cells, points._replace(restitution=of_all), n, value):
                which, u, phi = _zeros(portion)
                if portion.divided:
                    which, u, phi = _with_symmetric(which, u, phi, portion)
                parts.append((chosen[which], u, phi))
    cell, u, phi = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return _evaluated(cell, u, phi, points, n)


def _different(r: Any) -> list[Any]:
    """The different restitutions, or pairs of them, among those of design points, ascending."""
    if not isinstance(r, Restitutions):
        return sorted(set(np.ravel(r).tolist()))
    columns = (np.ravel(of_wall).tolist() for of_wall in np.broadcast_arrays(r.bottom, r.top))
    return [Restitutions(*pair) for pair in sorted(set(zip(*columns, strict=True)))]


def _is(r: Restitution, value: Any) -> Mask:
    """Whether each design point has a given restitution, or pair of restitutions."""
    if not isinstance(r, Restitutions):
        return np.asarray(r == value)
    return np.asarray((r.bottom == value.bottom) & (r.top == value.top))


def _portions(cells: Ints, groups: Groups[Any], n: int, shared: Any) -> Iterator[tuple[Ints, Points]]:
    """Divide design points into portions that fit the cache, each with the grid of u that its gbar needs.

    Parameters
    ----------
    cells : ndarray of int
        The design points.
    groups : Groups
        Of all design points.
    n : int
        Forcing periods per motion.
    shared : float or Restitutions or None
        Restitution of all `cells`; None where they differ.

    Yields
    ------
    ndarray of int, Points
        Numbers of the design points of a portion, and their search.
    """
    d, gbar, r, *_ = groups
    if shared is not None:
        # Beyond the largest d or gbar of all motions G has no zero, and the grid would be searched for nothing.
        largest_d, largest_gbar = largest_groups(shared, n, ())
        cells = cells[(d[cells] <= largest_d) & (gbar[cells] <= largest_gbar)]
    kind = np.searchsorted(-np.array(SCALES), -gbar[cells]) if n % 2 else np.zeros(len(cells), dtype=np.intp)
    # Where the membranes are not alike, nothing can be divided out without gravity either: motions are then at u of
    # the size of the difference, which may be as small as any gbar.
    flat = HORIZONTAL - 1 if isinstance(r, Restitutions) else HORIZONTAL
    kind[(gbar[cells] == 0) & (n % 2 == 1)] = flat
    for scale in range(HORIZONTAL + 1):
        same = cells[kind == scale]
        for first in range(0, same.size, BLOCK_POINTS):
            chosen = same[first : first + BLOCK_POINTS]
            restitution = map_restitution(r, itemgetter(chosen))
            u = _grid(map_restitution(restitution, lambda x: float(x.max())), n, scale)
            tables = None if shared is None else _tables(shared, n, scale)
            yield chosen, Points(u, n, scale == HORIZONTAL, d[chosen], gbar[chosen], restitution, tables)


def _with_symmetric(which: Ints, u: Floats, phi: Floats, points: Points) -> tuple[Ints, Floats, Floats]:
    """Add the symmetric motions of horizontal capsules to those found: d_sine sin + d_cosine cos = d at u = 0."""
    k = coefficients(np.zeros_like(points.d), points.r, points.n)
    # Written d = R cos(phi - middle): two phases where d < R, one where they meet in a fold, none beyond.
    ratio = points.d / np.hypot(k.d_sine, k.d_cosine)
    symmetric = np.flatnonzero(ratio <= 1)
    middle, half = np.arctan2(k.d_sine, k.d_cosine)[symmetric], np.arccos(ratio[symmetric])
    # A pitchfork comes from both families; its motion is taken from the symmetric one, of which u = 0 is exact.
    asymmetric = np.abs(u) > AT_SYMMETRY
    return (
        np.concatenate([which[asymmetric], symmetric, symmetric]),
        np.concatenate([u[asymmetric], np.zeros(2 * symmetric.size)]),
        np.concatenate([phi[asymmetric], middle + half, middle - half]),
    )


def _evaluated(cell: Ints, u: Floats, phi: Floats, groups: Groups[Any], n: int) -> PointwiseMotions:
    """Evaluate solutions at places (u, phi) of design points, in order, without those that strike from behind."""
    d, gbar, r, _, friction = groups
    order = np.lexsort((phi, u, cell))
    cell = cell[order]
    rubbed = None if friction is None else Friction(np.broadcast_to(friction, d.shape)[cell])
    orbit = orbits_of(
        Dynamics(map_restitution(r, itemgetter(cell)), n, groups.same_harmonics, rubbed), u[order], phi[order]
    )
    # G is a sum of squares and does not know the signs of velocities: some of its zeros strike a membrane from behind.
    forward = (orbit.velocity_bottom > 0) & (orbit.velocity_top < 0)
    orbit, cell = orbit.select(forward), cell[forward]
    orbit = replace(orbit, gbar=gbar[cell], d=d[cell])
    restitution = map_restitution(r, itemgetter(cell))
    return PointwiseMotions(cell, orbit, np.asarray(return_trace(orbit, restitution)), wall_gap(orbit, restitution))


def differentiated_motions(groups: Groups[Any], n: int) -> PointwiseMotions:
    """The motions of `find_motions` with exact derivatives as imaginary parts.

    Parameters
    ----------
    groups : Groups
        Complex arrays of shape (cells,); their imaginary parts over `IMAGINARY_STEP` are derivatives by some input.
    n : int
        Forcing periods per motion.

    Returns
    -------
    PointwiseMotions
        Complex; imaginary parts over `IMAGINARY_STEP` are the derivatives by the same input.

    Raises
    ------
    ValueError
        If the force has harmonics, or the ball friction.

    Notes
    -----
    The derivatives of (u, phi) follow from d(u, phi, r) and gbar(u, phi, r) by the implicit function theorem, all
    others from the formulae. A gap has the derivative of the position at the time of the turning point, where Z' is
    zero, so that the time needs none.
    """
    if groups.harmonics or groups.friction is not None:
        raise ValueError("derivatives are of the closed form of a force that is a sine, without friction")
    motions = find_motions(groups.map_numbers(np.real), n)
    d, gbar, r, *_ = groups.map_numbers(itemgetter(motions.cell))
    u, phi, real = motions.orbit.u, motions.orbit.phi, map_restitution(r, np.real)
    # Two real derivatives, by u and by phi, and the part of d and gbar that r moves with u and phi held.
    by_u = orbits(u + 1j * IMAGINARY_STEP, phi, real, n)
    by_phi = orbits(u, phi + 1j * IMAGINARY_STEP, real, n)
    by_r = orbits(u + 0j, phi, r, n)
    of_d, of_gbar = d.imag - by_r.d.imag, gbar.imag - by_r.gbar.imag
    with np.errstate(all="ignore"):  # on a fold there is no derivative
        # Cramer's rule for [d_u d_phi; gbar_u gbar_phi] (u', phi') = (d' - d_r r', gbar' - gbar_r r'). Every imaginary
        # part carries IMAGINARY_STEP once: so does the quotient.
        determinant = (by_u.d.imag * by_phi.gbar.imag - by_phi.d.imag * by_u.gbar.imag) / IMAGINARY_STEP
        u = u + 1j * (of_d * by_phi.gbar.imag - of_gbar * by_phi.d.imag) / determinant
        phi = phi + 1j * (of_gbar * by_u.d.imag - of_d * by_u.gbar.imag) / determinant
    orbit = replace(orbits(u, phi, r, n), gbar=gbar, d=d)
    gap = d.copy()
    for impact, turn in flight_turns(motions.orbit, motions.orbit.flights(real), nearest=True):
        way = orbit.flights(r)[impact].select(turn.index)
        angle = np.pi * turn.time
        covered = way.covered(turn.time, way.turned(np.sin(angle), np.cos(angle))[1])
        np.minimum.at(gap, turn.index, np.minimum(covered, way.d - covered))
    return PointwiseMotions(motions.cell, orbit, return_trace(orbit, r), gap)


class Forms(Struct, frozen=True, eq=False):
    """Functions of u and r with sin(phi) = (gbar sine_gbar + d sine_d)/delta, and likewise for the cosine; arrays."""

    sine_gbar: Any
    sine_d: Any
    cosine_gbar: Any
    cosine_d: Any
    delta: Any


def forms(u: Arithmetic, r: Any, n: int, divided: bool = False) -> Forms:
    """Solve (3.9)-(3.11) for the phase at q = 1/2 + u, gbar and d.

    Parameters
    ----------
    u : array_like
        q - 1/2; complex where a derivative is wanted.
    r : array_like or Restitutions
        Restitution coefficient, 0 <= r < 1.
    n : int
        Forcing periods per motion.
    divided : bool
        For a horizontal capsule and odd n: all but the coefficients of gbar are divided by u, whose zero is the
        symmetric family.

    Notes
    -----
    With p = (1+r) u - (1-r)/2 and m = Tu Td/(2T), subtracting multiples of the rows leaves
    Delta = 2 (1+r) [m sin(a)/pi - u (cos(a) - 1)/pi^2]. Everything that vanishes with u does so without cancellation.
    For membranes that are not alike r is r_b, and (r_b - r_t)/(1 + r_t) is added to 2 (1+r) u.
    """
    pi, period = np.pi, 2 * n
    r, r_top = by_wall(r)
    skew = 0.0 if r is r_top else (r - r_top) / (1 + r_top)
    half = pi * n * u
    sin_half, cos_half = np.sin(half), np.cos(half)
    # sin(pi n u)/u: numpy's sinc has the limit at u = 0.
    over_u = pi * n * np.sinc(n * u) if divided else sin_half
    versine, sin_theta = 2 * sin_half * over_u, 2 * over_u * cos_half
    factor = np.ones_like(u) if divided else u
    p = (1 + r) * u - (1 - r) / 2
    reach = period * (1 - 4 * u * u) / 8
    # a = pi (n + 2 n u), so that sin(a) and cos(a) are those of 2 pi n u but for the sign (-1)^n; by the half angle 1 -
    # cos keeps its digits next to u = 0.
    if n % 2:
        sin_a, cosine_d = -sin_theta, versine * p - 2 * (1 + r) * factor
        delta = 2 * (1 + r) * (factor * (2 * cos_half * cos_half) / (pi * pi) + reach * sin_a / pi)
        cos_a_less_one = -2 * cos_half * cos_half
    else:
        sin_a, cosine_d = sin_theta, -versine * p - (1 - r)
        delta = 2 * (1 + r) * (u * versine / (pi * pi) + reach * sin_a / pi)
        cos_a_less_one = -versine
    if r is not r_top:
        cosine_d, delta = cosine_d - skew, delta - skew * cos_a_less_one / (pi * pi)
    sine_d = -p * sin_a
    if divided:
        nothing = np.zeros_like(u)
        return Forms(nothing, sine_d, nothing, cosine_d, delta)
    kappa = (1 + r) * u * u + (1 - r) * (1 - r_top) / (4 * (1 + r_top))
    p_top = p if r is r_top else (1 + r_top) * u - (1 - r_top) / 2
    sine_gbar = period * (pi * u * delta - p * (cos_a_less_one * (p_top / (1 + r_top) - 2 * u) / pi + sin_a * reach))
    inner = 2 * (1 + r) * u + cos_a_less_one * ((1 + r) * u + (1 - r) / 2)
    if r is not r_top:
        inner = inner - skew
    return Forms(sine_gbar, sine_d, -period * (reach * inner + sin_a * kappa / pi), cosine_d, delta)


@lru_cache(maxsize=64)
def _grid(r: Any, n: int, scale: int) -> Floats:
    """Ascending samples of u on which no zero of G is missed, for one range of gbar and restitutions up to `r`.

    Next to u = 0 and for odd n, a gbar + b d = Delta is a balance of gbar a(0) with terms that grow as u: no zero is
    nearer to u = 0 than where the largest of these terms balances it. Where the symmetric family is divided out, G does
    not vary there.
    """
    even = np.linspace(-0.5, 0.5, 2 * (SAMPLES * n // 2) + 1)
    spacing = float(even[1] - even[0])
    smallest = 1.0
    # The nearly symmetric motions of a nearly horizontal capsule are at u ~ gbar: of a pair at gbar = 1e-6, next to
    # their fold, the even grid alone shows neither.
    if scale == HORIZONTAL:
        smallest = spacing
    elif n % 2:
        step = 1e-6
        at, near = forms(np.array(0.0), r, n), forms(np.array(step), r, n)
        growth = (abs(near.delta) + largest_groups(r, n, ())[0] * np.hypot(near.sine_d, near.cosine_d)) / step
        smallest = float(SCALES[scale] * np.hypot(at.sine_gbar, at.cosine_gbar) / growth)
    near_edge = 0.5 - spacing * 10.0 ** np.arange(-4, 0, 0.5)
    decades = 10.0 ** np.arange(np.floor(np.log10(smallest)), np.log10(PER_DECADE * spacing), 1 / PER_DECADE)
    return np.array(sorted({*even, *decades, *-decades, *near_edge, *-near_edge}))


@lru_cache(maxsize=64)
def _tables(r: Any, n: int, scale: int) -> tuple[Floats, Floats]:
    """A, B, C, D of G = gbar^2 A + gbar d B + d^2 C - D on the grid, (4, len(grid)), and their derivatives by u."""
    f = forms(_grid(r, n, scale) + 1j * IMAGINARY_STEP, r, n, scale == HORIZONTAL)
    # G = |gbar a + d b|^2 - Delta^2 is a quadratic form in (gbar, d): its coefficients are functions of u and r alone.
    cross = 2 * (f.sine_gbar * f.sine_d + f.cosine_gbar * f.cosine_d)
    terms = np.stack([f.sine_gbar**2 + f.cosine_gbar**2, cross, f.sine_d**2 + f.cosine_d**2, f.delta**2])
    return terms.real.copy(), terms.imag / IMAGINARY_STEP


class Points(Struct, frozen=True, eq=False):
    """Design points that share a grid of u, with the function G whose zeros are their motions.

    Attributes
    ----------
    u : ndarray
        The grid, ascending.
    n : int
        Forcing periods per motion.
    divided : bool
        Whether the symmetric family is divided out, see `forms`.
    d, gbar : ndarray
        Of the design points.
    r : ndarray or Restitutions
    tables : tuple of ndarray or None
        See `_tables`; None where the restitutions differ.
    """

    u: Floats
    n: int
    divided: bool
    d: Floats
    gbar: Floats
    r: Any
    tables: tuple[Floats, Floats] | None

    def on_grid(self, part: slice) -> tuple[Floats, Floats]:
        """G and its derivative by u on the whole grid, (points, grid), for some of the points."""
        d, gbar = self.d[part], self.gbar[part]
        if self.tables is None:
            f = forms(
                self.u + 1j * IMAGINARY_STEP, map_restitution(self.r, lambda x: x[part, None]), self.n, self.divided
            )
            sine = gbar[:, None] * f.sine_gbar + d[:, None] * f.sine_d
            cosine = gbar[:, None] * f.cosine_gbar + d[:, None] * f.cosine_d
            square = sine * sine + cosine * cosine - f.delta * f.delta
            return square.real, square.imag / IMAGINARY_STEP
        # Not by a matrix product: its last bits may depend on the number of threads, and the results with them.
        factors = np.stack([gbar * gbar, gbar * d, d * d, np.full(len(d), -1.0)])
        values, slopes = (np.einsum("ki,kj->ij", factors, table) for table in self.tables)
        return values, slopes

    def value(self, which: Ints, u: Arithmetic) -> tuple[Any, Any, Any, Any]:
        """G, the numerators of sin(phi) and cos(phi), and their denominator, at a u for each of the points `which`."""
        f = forms(u, map_restitution(self.r, itemgetter(which)), self.n, self.divided)
        d, gbar = self.d[which], self.gbar[which]
        sine, cosine = d * f.sine_d, d * f.cosine_d
        if not self.divided:
            sine, cosine = gbar * f.sine_gbar + sine, gbar * f.cosine_gbar + cosine
        return sine * sine + cosine * cosine - f.delta * f.delta, sine, cosine, f.delta

    def value_and_slope(self, which: Ints, u: Floats) -> tuple[Floats, Floats]:
        """G and its derivative by u, at one u for each of the points `which`."""
        f = self.value(which, u + 1j * IMAGINARY_STEP)[0]
        return f.real, f.imag / IMAGINARY_STEP


class Brackets(Struct, frozen=True, eq=False):
    """Intervals of u of the design points `which`, with the values and slopes of G at their ends; arrays."""

    which: Ints
    low: Floats
    high: Floats
    value_low: Floats
    value_high: Floats
    slope_low: Floats
    slope_high: Floats

    def select(self, index: Mask) -> Brackets:
        """The brackets picked by an index or mask."""
        return Brackets(*(getattr(self, name)[index] for name in Brackets.__struct_fields__))

    def halves(self, u: Floats, value: Floats, slope: Floats) -> list[Brackets]:
        """The parts of each bracket below and above a u, at which G has this value and slope."""
        return [
            replace(self, high=u, value_high=value, slope_high=slope),
            replace(self, low=u, value_low=value, slope_low=slope),
        ]

    @property
    def cubic(self) -> tuple[Floats, Floats, Floats]:
        """Coefficients of x, x^2 and x^3 of the cubic through values and slopes, x from 0 to 1 over the interval."""
        rise, width = self.value_high - self.value_low, self.high - self.low
        at_low, at_high = self.slope_low * width, self.slope_high * width
        return at_low, 3 * rise - 2 * at_low - at_high, at_low + at_high - 2 * rise


def _joined(parts: list[Brackets]) -> Brackets:
    """Several sets of brackets as one."""
    return Brackets(*(np.concatenate([getattr(part, name) for part in parts]) for name in Brackets.__struct_fields__))


def _zeros(points: Points) -> tuple[Ints, Floats, Floats]:
    """Find all zeros of G: number of the design point, u to the last digit that G has, and phase [rad]."""
    b = _brackets(points)
    share, slope = cubic_root(b.value_low, b.value_high - b.value_low, b.cubic)
    phi, width = np.zeros_like(share), b.high - b.low

    def value(u: Floats, which: Ints) -> Floats:
        f, sine, cosine, delta = points.value(b.which[which], u)
        # The phase is that of (sine, cosine)/delta, of which only the sign of delta matters: it may vanish with both.
        sign = np.where(delta < 0, -1.0, 1.0)
        phi[which] = np.arctan2(sign * sine, sign * cosine)
        return np.asarray(f)

    guesses = Guesses(b.low, b.high, b.value_low, b.value_high > 0, b.low + share * width, slope / width)
    u = secant_root(value, guesses, LAST_STEP)
    return b.which, u, phi


def _brackets(points: Points) -> Brackets:
    """Bracket every zero of G by an interval of u."""
    crossing: list[Brackets] = []
    dipping: list[Brackets] = []
    doubled: list[Brackets] = []
    size = max(BLOCK_VALUES // len(points.u), 1)
    for first in range(0, len(points.d), size):
        values, slopes = points.on_grid(slice(first, first + size))
        crosses, dips, turns = _pattern(values[:, :-1], values[:, 1:], slopes[:, :-1], slopes[:, 1:])
        near = np.zeros_like(crosses)
        near[:, 1:] |= crosses[:, :-1]
        near[:, :-1] |= crosses[:, 1:]
        # An interval without a change of sign, next to one with, may hold two of three close zeros.
        near &= ~(crosses | turns)
        for where, brackets in ((crosses, crossing), (dips, dipping), (near, doubled)):
            k, i = np.divmod(np.flatnonzero(where), where.shape[1])
            ends = (values[k, i], values[k, i + 1], slopes[k, i], slopes[k, i + 1])
            brackets.append(Brackets(k + first, points.u[i], points.u[i + 1], *ends))
    plain, halves = _unfolded(points, _joined(crossing), _joined(doubled))
    crosses, dips, _ = _pattern(halves.value_low, halves.value_high, halves.slope_low, halves.slope_high)
    cut = _split(points, _joined([*dipping, halves.select(dips)]))
    return _joined([plain, halves.select(crosses), *cut])


def _pattern(low: Floats, high: Floats, slope_low: Floats, slope_high: Floats) -> tuple[Mask, Mask, Mask]:
    """Masks of intervals: G changes sign; keeps it with an extremum towards zero between; its slope changes sign."""
    positive, rising = high > 0, slope_high > 0
    crosses = positive != (low > 0)
    turns = rising != (slope_low > 0)
    return crosses, turns & (rising == positive) & ~crosses, turns


def _unfolded(points: Points, crossing: Brackets, doubled: Brackets) -> tuple[Brackets, Brackets]:
    """Separate the intervals in which G has two extrema, as next to a cusp of its zeros, and cut them between these.

    Parameters
    ----------
    points : Points
    crossing : Brackets
        Intervals in which G changes its sign.
    doubled : Brackets
        Their neighbours, in which it does not.

    Returns
    -------
    plain : Brackets
        The intervals of `crossing` without two extrema.
    halves : Brackets
        Both parts of all intervals with two.
    """
    both = _joined([crossing, doubled])
    c1, c2, c3 = both.cubic
    # At its inflection x = -c2/(3 c3) a cubic has the slope c1 + c2 x: if that has another sign than at both ends, the
    # function turns twice in between, and one change of sign may be three zeros.
    x = -c2 / np.where(c3 == 0, 1.0, 3 * c3)
    between = c1 + c2 * x
    waves = (x > 0) & (x < 1) & (between * c1 < 0) & (between * both.slope_high < 0)
    b, u = both.select(waves), (both.low + x * (both.high - both.low))[waves]
    halves = b.halves(u, *points.value_and_slope(b.which, u))
    return crossing.select(~waves[: len(crossing.which)]), _joined(halves)


def _split(points: Points, b: Brackets) -> list[Brackets]:
    """Cut intervals at the extremum of G, if G has the other sign at it; others are left out."""
    c1, c2, c3 = b.cubic
    slope_at_end = c1 + 2 * c2 + 3 * c3
    # The extremum -c1/(c2 +- root), not (-c2 +- root)/(3 c3): c3 may vanish. The slope rises through zero at that with
    # +.
    root = np.sqrt(np.maximum(c2 * c2 - 3 * c3 * c1, 0.0))
    denominator = c2 + np.where(slope_at_end > c1, root, -root)
    x = np.clip(-c1 / np.where(denominator == 0, 1.0, denominator), 0.0, 1.0)
    value = b.value_low + x * (c1 + x * (c2 + x * c3))
    near = np.sign(b.value_low) * value < DOUBTFUL * np.maximum(np.abs(b.value_low), np.abs(b.value_high))
    b, u = b.select(near), (b.low + x * (b.high - b.low))[near]
    bend = (b.slope_high - b.slope_low) / (b.high - b.low)

    def slope(u: Floats, which: Ints) -> Floats:
        return points.value_and_slope(b.which[which], u)[1]

    u = secant_root(slope, Guesses(b.low, b.high, b.slope_low, b.slope_high > 0, u, bend), FLAT)
    value = points.value(b.which, u)[0]
    across = (value > 0) != (b.value_low > 0)
    b, u, value = b.select(across), u[across], value[across]
    return b.halves(u, value, np.zeros_like(u))
