"""All 1:1 motions at many design points by a search in the plane of q and phase, for harmonics and friction.

Through every place (u, phi) of the plane, u = q - 1/2, there is one motion, and it has one gbar and one d. For a sine
`pointwise` eliminates the phase; where the force has harmonics, or the ball friction, the motions of a design point are
the places at which both gbar and d are those of the point. Times D = -(1 + r_t) K(q)/T^2 the two differences are entire
functions of u, trigonometric polynomials in phi, linear in gbar, d and f, and linear in either restitution: on a cell
of the plane a few numbers give them for every design point.

So cells are halved until each has no zero, or one at most. With bounds of the second derivatives over a cell both are
certain but for rounding: a function that is larger at the middle than it can change has no zero; nor have both where
Newton's step leads farther out of the cell than they bend; and where the Jacobian changes by less than half of itself,
there is one zero at most, to which Newton's method converges. Design points that are near one another share the first
cells.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.motions.level_plane import EDGE
from vireport.motions.orbits import Dynamics, Friction, Orbits, coefficients, of_order, orbits_of, rubbing, turned
from vireport.physics.forcing import SINE, Harmonic
from vireport.physics.groups import Groups, Restitution, Restitutions, by_wall, map_restitution
from vireport.physics.numbers import IMAGINARY_STEP, Arithmetic

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

PER_WAVE, SHARED = 8, 2
"""First cells in the shortest wavelength, in u and in phase, and halvings of the cells that design points share."""

DEEPEST = 18
"""Number of halvings after which a cell that is left has a double zero, on a fold or a pitchfork but for rounding."""

TOGETHER, PAIRS = 128, 200_000
"""Design points that share cells, and pairs of a design point and a cell that are tested at once."""

NODES = 0.0, 0.5
"""Restitutions at which the functions are evaluated; being linear in either, two values give them all."""

ALLOWANCE = 1.25
"""Factor on bounds of the second derivatives, for their change between the places at which they are evaluated."""

OVERLAP = 1e-6
"""Share of a cell by which a zero may be outside it: on the border of two cells rounding must not lose a zero."""

CHANGE = 0.5
"""Relative change of the Jacobian within a cell up to which there is one zero at most (Newton's map contracts)."""

STEPS, LAST_STEP, SETTLED = 30, 1e-8, 0.1
"""Newton steps, of which five are usual; the step, as a share of the cell, that ends them, as the next one would be
about its square; and the last step below which they have come to a zero."""

NEAR_FOLD = 4.0
"""Distance, in cells, up to which a double zero counts as one, and two of them as the same."""

ON_SYMMETRY = 1e-9
"""|u| below which a motion of a device with mirror images is symmetric: others are so near only next to a pitchfork."""


class Places(NamedTuple):
    """Places (u, phi) of the plane with the number of a design point each, as the middles of cells of some depth.

    Attributes
    ----------
    which : ndarray of int
        Design points.
    u, phi : ndarray
    depth : ndarray of int
        Halvings of the cells.
    """

    which: Ints
    u: Floats
    phi: Floats
    depth: Ints

    def select(self, index: Any) -> Places:
        """The entries picked by an index or mask."""
        return Places(*(column[index] for column in self))

    @staticmethod
    def joined(parts: Iterable[Places]) -> Places:
        """Several sets of places as one."""
        nothing = Places(np.empty(0, dtype=np.intp), np.empty(0), np.empty(0), np.empty(0, dtype=np.intp))
        return Places(*map(np.concatenate, zip(nothing, *parts, strict=True)))


class PhaseCells(NamedTuple):
    """Cells of one size, by the numbers of their rows and columns."""

    row: Ints
    column: Ints

    def select(self, index: Any) -> PhaseCells:
        """The entries picked by an index or mask."""
        return PhaseCells(self.row[index], self.column[index])

    @staticmethod
    def joined(parts: Iterable[PhaseCells]) -> PhaseCells:
        """Several sets of cells as one."""
        cells = list(parts)
        nothing = np.empty(0, dtype=np.intp)
        row = np.concatenate([nothing, *(part.row for part in cells)])
        return PhaseCells(row, np.concatenate([nothing, *(part.column for part in cells)]))

    def quarters(self) -> PhaseCells:
        """The four quarters of every cell."""
        below, right = np.divmod(np.arange(4), 2)
        return PhaseCells((2 * self.row[:, None] + below).ravel(), (2 * self.column[:, None] + right).ravel())


class Rows(NamedTuple):
    """The two functions (of gbar, of d) at some u, with their derivatives by u as imaginary parts.

    With x and y the restitutions at bottom and top less the middle ones, every coefficient is a + b x + c y + e x y:
    four numbers.

    Attributes
    ----------
    sine, cosine : ndarray, shape (2, orders, 4, len)
        Coefficients of the sines and cosines of multiples of the phase.
    flat : ndarray, shape (2, 4 or 8, len)
        Terms without the phase: D, which multiplies gbar or d, and with friction the one that multiplies f.
    """

    sine: Any
    cosine: Any
    flat: Any


class Bends(NamedTuple):
    """Bounds of the second derivatives of `terms` by u, by both and by the phase, shape (2, k, rows)."""

    by_u: Floats
    by_both: Floats
    by_phi: Floats

    def over(self, row: Ints, half: tuple[float, float]) -> Floats:
        """Bounds of the nonlinear part of the terms within cells in given rows, shape (2, k, len).

        Parameters
        ----------
        row : ndarray of int
        half : tuple of float
            Half the extent of the cells in u and in the phase.
        """
        u, phi = half
        return np.asarray(
            (self.by_u * (u * u / 2) + self.by_both * (u * phi) + self.by_phi * (phi * phi / 2))[:, :, row]
        )

    def of_pairs(self) -> Bends:
        """Bounds of rows of twice the width, the larger of each pair."""
        return Bends(*(np.maximum(bound[:, :, ::2], bound[:, :, 1::2]) for bound in self))


class Divided(NamedTuple):
    """Cells of one depth that may have zeros, after a test.

    Attributes
    ----------
    single : Places
        Middles of the cells with at most one zero.
    points : ndarray of int
        Design points of the cells that may have more.
    cells : PhaseCells
        The cells that may have more, one for each of `points`.
    """

    single: Places
    points: Ints
    cells: PhaseCells


class Tested(NamedTuple):
    """Masks of cells: `may`, a zero may be inside, and `single`, at most one is."""

    may: Mask
    single: Mask


def motions_in_plane(groups: Groups[Any], r: Restitution, n: int) -> tuple[Ints, Floats, Floats]:
    """Find the 1:1 motions of design points, admissible or not.

    Parameters
    ----------
    groups : Groups
        Arrays of shape (points,), with harmonics that are the same for all.
    r : ndarray or Restitutions
        Restitution of each design point.
    n : int
        Forcing periods per motion.

    Returns
    -------
    which : ndarray of int
        Number of the design point of each motion.
    u, phi : ndarray
        q - 1/2 and phase [rad].
    """
    plane = MotionPlane.of(groups, r, n)
    places = plane.zeros(plane.cells())
    u, phi = places.u, places.phi
    if groups.symmetric and n % 2:
        u, phi = plane.symmetric(places)
    return places.which, u, phi


class MotionPlane(Struct, frozen=True, eq=False):
    """Design points, and the two functions whose zeros are their motions.

    Attributes
    ----------
    d, gbar : ndarray
    r : ndarray or Restitutions
    friction : ndarray or None
    n : int
    harmonics : tuple of Harmonic
    middle : tuple of float
        Restitutions at the bottom and at the top, from which those of the design points are counted.
    weights : ndarray, shape (2, k, points)
        Factors of `terms` in both functions of each design point.
    """

    d: Floats
    gbar: Floats
    r: Any
    friction: Any
    n: int
    harmonics: tuple[Harmonic, ...]
    middle: tuple[float, float]
    weights: Floats

    @staticmethod
    def of(groups: Groups[Any], r: Restitution, n: int) -> MotionPlane:
        """Make the plane of motions of some design points."""
        d, gbar = groups.d, groups.gbar
        friction = None if groups.friction is None else np.broadcast_to(groups.friction, d.shape)
        # The functions are linear in either restitution: by differences from a middle one their parts stay small, and
        # their bounds narrow.
        bottom, top = by_wall(r)
        middle = [float(wall_r.min(initial=1.0) + wall_r.max(initial=0.0)) / 2 for wall_r in (bottom, top)]
        x, y = bottom - middle[0], top - middle[1]
        four = np.stack([np.ones_like(x), x, y, x * y])
        rubbed = [] if friction is None else [friction * four]
        weights = np.stack([np.concatenate([four, -group * four, *rubbed]) for group in (gbar, d)])
        return MotionPlane(d, gbar, r, friction, n, groups.same_harmonics, (middle[0], middle[1]), weights)

    @property
    def orders(self) -> Floats:
        """Orders of the sine and of the harmonics."""
        return np.array([float(harmonic.order) for harmonic in (SINE, *self.harmonics)])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the first cells."""
        highest = PER_WAVE * int(self.orders.max())
        return highest * self.n, highest

    def half(self, depth: Any) -> tuple[Any, Any]:
        """Half the extent of a cell in u and in the phase [rad] after `depth` halvings."""
        rows, columns = self.shape
        return EDGE / rows / 2.0**depth, np.pi / columns / 2.0**depth

    def middles(self, cells: PhaseCells, depth: int) -> tuple[Floats, Floats]:
        """The middles (u, phi) of cells."""
        u, phi = self.half(depth)
        return (2 * cells.row + 1) * u - EDGE, (2 * cells.column + 1) * phi

    def rows(self, u: Floats) -> Rows:
        """The coefficients of both functions at some u."""
        bottom, top = np.tile(NODES, 2)[:, None], np.repeat(NODES, 2)[:, None]
        # Four corners of the restitutions fix what is linear in both.
        r, at = Restitutions(bottom, top), u + 1j * IMAGINARY_STEP
        terms = coefficients(at, r, self.n)
        cleared = -(1 + top) * terms.determinant / (2 * self.n) ** 2
        sine, cosine, flat = [], [], [[cleared, cleared]]
        for part in (SINE, *self.harmonics):
            k = of_order(coefficients(at, r, part.order * self.n), part.order)
            both = [turned(*pair, part) for pair in ((k.gbar_sine, k.gbar_cosine), (k.d_sine, k.d_cosine))]
            sine.append([cleared * of_sine for of_sine, _ in both])
            cosine.append([cleared * of_cosine for _, of_cosine in both])
        if self.friction is not None:
            unit = rubbing(terms, at, r, self.n)
            flat.append([cleared * unit.gbar, cleared * unit.d])
        # From values at two nodes to that at the middle and the slope, of the top and of the bottom.
        of_bottom, of_top = (np.array([[1 - 2 * c, 2 * c], [-2.0, 2.0]]) for c in self.middle)
        turn = np.kron(of_top, of_bottom)
        parts = [np.einsum("mk,jqku->qjmu", turn, np.array(x)) for x in (sine, cosine, flat)]
        return Rows(parts[0], parts[1], parts[2].reshape(2, -1, len(u)))

    def bends(self, depth: int) -> Bends:
        """Bounds of the second derivatives in the rows of cells after `depth` halvings."""
        rows = self.shape[0] << depth
        at, orders = self.rows(np.linspace(-EDGE, EDGE, rows + 1)), self.orders[:, None, None]

        def rate(x: Any) -> Floats:
            return np.asarray(np.abs(np.diff(x.imag, axis=-1)) * (rows / IMAGINARY_STEP))

        by_u = np.concatenate([np.hypot(rate(at.sine), rate(at.cosine)).sum(axis=1), rate(at.flat)], axis=1)
        # A difference quotient is the mean over a row: the neighbouring rows stand for the variation within.
        wide = np.pad(by_u, ((0, 0), (0, 0), (1, 1)), mode="edge")
        by_u = np.maximum(np.maximum(wide[..., :-2], wide[..., 2:]), by_u)
        by_both = (orders * np.hypot(at.sine.imag, at.cosine.imag)).sum(axis=1) / IMAGINARY_STEP
        by_phi = (orders**2 * np.hypot(at.sine.real, at.cosine.real)).sum(axis=1)
        waves = (np.maximum(bound[..., 1:], bound[..., :-1]) for bound in (by_both, by_phi))
        filled = (np.concatenate([bound, np.zeros_like(by_u[:, 4:])], axis=1) for bound in waves)
        return Bends(*(ALLOWANCE * bound for bound in (by_u, *filled)))

    def terms(self, rows: Rows, row: Ints, phi: Floats) -> Floats:
        """The terms whose sums with `weights` are the functions at places, and their derivatives by u and by the phase.

        Parameters
        ----------
        rows : Rows
        row : ndarray of int
            Number of the u of each place in `rows`.
        phi : ndarray

        Returns
        -------
        ndarray, shape (2, 3, k, len)
        """
        angle = self.orders[:, None] * phi
        sin, cos = np.sin(angle)[:, None], np.cos(angle)[:, None]
        a, b, flat = rows.sine[..., row], rows.cosine[..., row], rows.flat[..., row]
        value = np.concatenate([(a * sin + b * cos).sum(axis=1), flat], axis=1)
        by_phi = (self.orders[:, None, None] * (a.real * cos - b.real * sin)).sum(axis=1)
        by_phi = np.concatenate([by_phi, np.zeros(flat.shape)], axis=1)
        return np.stack([value.real, value.imag / IMAGINARY_STEP, by_phi], axis=1)

    def cells(self) -> Places:
        """Divide the plane into cells with at most one zero, and return those that may have one, by design point."""
        # Rows of larger cells take the bounds of the finest ones that they hold: these are evaluated once.
        bends = [self.bends(SHARED)]
        for _ in range(SHARED):
            bends.insert(0, bends[0].of_pairs())
        shared = []
        for depth, bends_at in enumerate(bends):
            count = self.shape[0] << depth
            shared.append((self.rows((np.arange(count) + 0.5) / count - EDGE), bends_at))
        groups = _neighbours(np.stack([self.d, self.gbar, *by_wall(self.r)]), np.arange(len(self.d)))
        tested = [self._point_by_point(group, self._of_any(group, shared), shared[SHARED]) for group in groups]
        places = [divided.single for divided in tested]
        # Deeper cells belong to a design point each: cells that hold more than one zero differ from point to point.
        for depth in range(SHARED + 1, DEEPEST + 1):
            points = np.concatenate([np.empty(0, dtype=np.intp), *(divided.points for divided in tested)])
            cells = PhaseCells.joined(divided.cells for divided in tested)
            tested = [
                self._halved(points[k : k + PAIRS], cells.select(slice(k, k + PAIRS)), depth, bends[SHARED])
                for k in range(0, len(points), PAIRS)
            ]
            if not tested:
                break
            places += [divided.single for divided in tested]
        return Places.joined(places)

    def _of_any(self, group: Ints, shared: Sequence[tuple[Rows, Bends]]) -> PhaseCells:
        """The finest shared cells in which any design point of a group may have a motion."""
        # Design points that are near one another have weights in a small range: what that leaves open is added to what
        # the bend does, and a cell without a zero is then left out for all of them at once.
        low, high = self.weights[:, :, group].min(axis=2), self.weights[:, :, group].max(axis=2)
        middle, off = (low + high) / 2, (high - low) / 2
        rows, columns = self.shape
        cells = PhaseCells(*np.divmod(np.arange(rows * columns), columns))
        for depth, (sampled, bends) in enumerate(shared):
            cells, half = cells.quarters() if depth else cells, self.half(depth)
            terms = self.terms(sampled, cells.row, self.middles(cells, depth)[1])
            change = np.einsum("qk,qdkc->dqc", off, np.abs(terms))
            change = change[0] + change[1] * half[0] + change[2] * half[1]
            values = np.einsum("qk,qdkc->dqc", middle, terms)
            rest = np.einsum("qk,qkc->qc", np.abs(middle) + off, bends.over(cells.row, half))
            cells = cells.select(_tested(values, half, rest + change).may)
        return cells

    def _point_by_point(self, group: Ints, cells: PhaseCells, shared: tuple[Rows, Bends]) -> Divided:
        """Test cells for each design point of a group by itself."""
        (rows, bends), half = shared, self.half(SHARED)
        u, phi = self.middles(cells, SHARED)
        most = np.abs(self.weights[:, :, group]).max(axis=2)
        terms = self.terms(rows, cells.row, phi)
        rest = np.einsum("qk,qkc->qc", most, bends.over(cells.row, half))[:, None]
        single, points, left = [], [], []
        for part in np.array_split(group, 1 + len(group) * len(u) // PAIRS):
            values = np.einsum("qkp,qdkc->dqpc", self.weights[:, :, part], terms)
            test = _tested(values, half, rest)
            p, c = np.nonzero(test.may & test.single)
            single.append(Places(part[p], u[c], phi[c], np.full(len(p), SHARED)))
            p, c = np.nonzero(test.may & ~test.single)
            points.append(part[p])
            left.append(cells.select(c))
        return Divided(Places.joined(single), np.concatenate(points), PhaseCells.joined(left))

    def _halved(self, points: Ints, cells: PhaseCells, depth: int, bends: Bends) -> Divided:
        """Test the quarters of cells, each for its design point.

        At the greatest depth every cell that may have a zero counts as one with at most one.
        """
        points, cells, half = np.repeat(points, 4), cells.quarters(), self.half(depth)
        u, phi = self.middles(cells, depth)
        different, place = np.unique(u, return_inverse=True)
        terms = self.terms(self.rows(different), place.ravel(), phi)
        weights = self.weights[:, :, points]
        values = np.einsum("qkp,qdkp->dqp", weights, terms)
        rest = np.einsum("qkp,qkp->qp", np.abs(weights), bends.over(cells.row >> (depth - SHARED), half))
        test = _tested(values, half, rest)
        single = test.may & (test.single | (depth == DEEPEST))
        left = test.may & ~single
        places = Places(points, u, phi, np.full(len(u), depth))
        return Divided(places.select(single), points[left], cells.select(left))

    def zeros(self, cells: Places) -> Places:
        """Locate the zeros in cells that may have one, by Newton's method from the middle; every zero once."""
        (half_u, half_phi), folded = self.half(cells.depth), cells.depth == DEEPEST
        u, phi, last = cells.u.copy(), cells.phi.copy(), np.ones(len(cells.u))
        active = np.arange(len(u))
        for _ in range(STEPS):
            step_u, step_phi = self._steps(cells.which[active], u[active], phi[active])
            # No step is longer than half a cell: another cell has the zero that it would go to.
            share_u, share_phi = (
                np.clip(step / half[active], -1.0, 1.0) for step, half in ((step_u, half_u), (step_phi, half_phi))
            )
            u[active] = np.clip(u[active] + share_u * half_u[active], -EDGE, EDGE)
            phi[active] += share_phi * half_phi[active]
            last[active] = np.maximum(np.abs(share_u), np.abs(share_phi))
            active = active[last[active] > LAST_STEP]
            if not active.size:
                break
        reach = np.where(folded, NEAR_FOLD, 1 + 2 * OVERLAP)
        kept = (np.abs(u - cells.u) <= reach * half_u) & (np.abs(phi - cells.phi) <= reach * half_phi)
        # Rounding leaves a step in a small cell; where there is no zero the steps are as large as the cell.
        kept &= last < SETTLED
        return self._once(Places(cells.which, u, phi, cells.depth).select(kept & (np.abs(u) < EDGE)))

    def _steps(self, which: Ints, u: Floats, phi: Floats) -> tuple[Floats, Floats]:
        """Newton's steps in u and phase to gbar and d of the design points `which`."""
        by_u = self._at(which, u + 1j * IMAGINARY_STEP, phi)
        by_phi = self._at(which, u, phi + 1j * IMAGINARY_STEP)
        of_gbar, of_d = by_u.gbar.real - self.gbar[which], by_u.d.real - self.d[which]
        gbar_u, d_u = by_u.gbar.imag / IMAGINARY_STEP, by_u.d.imag / IMAGINARY_STEP
        gbar_phi, d_phi = by_phi.gbar.imag / IMAGINARY_STEP, by_phi.d.imag / IMAGINARY_STEP
        determinant = gbar_u * d_phi - gbar_phi * d_u
        safe = np.where(determinant == 0, 1.0, determinant)
        return (of_d * gbar_phi - of_gbar * d_phi) / safe, (of_gbar * d_u - of_d * gbar_u) / safe

    def _at(self, which: Ints, u: Arithmetic, phi: Arithmetic) -> Orbits:
        """The motions at places, with the membranes and the friction of design points."""
        friction = None if self.friction is None else Friction(self.friction[which])
        return orbits_of(Dynamics(map_restitution(self.r, itemgetter(which)), self.n, self.harmonics, friction), u, phi)

    def _once(self, places: Places) -> Places:
        """Zeros without repetition: a zero on the border of cells comes from all of them."""
        # Sorted by design point, a repeated zero is at most as many rows on as its point has zeros.
        places = places.select(np.argsort(places.which, kind="stable"))
        size = np.where(places.depth == DEEPEST, NEAR_FOLD, 2 * OVERLAP)
        near_u, near_phi = (size * half for half in self.half(places.depth))
        again = np.zeros(len(places.u), dtype=bool)
        for k in range(1, int(np.bincount(places.which).max(initial=1))):
            turn = np.mod(places.phi[k:] - places.phi[:-k] + np.pi, 2 * np.pi) - np.pi
            same = (places.which[k:] == places.which[:-k]) & (np.abs(turn) <= near_phi[k:] + near_phi[:-k])
            again[k:] |= same & (np.abs(places.u[k:] - places.u[:-k]) <= near_u[k:] + near_u[:-k])
        return places.select(~again)

    def symmetric(self, places: Places) -> tuple[Floats, Floats]:
        """Places (u, phi) with those of symmetric motions moved to u = 0 exactly, where d alone gives the phase."""
        u, phi = places.u.copy(), places.phi.copy()
        on_symmetry = np.flatnonzero((self.gbar[places.which] == 0) & (np.abs(u) < ON_SYMMETRY))
        u[on_symmetry] = 0.0
        for _ in range(2):
            at = self._at(places.which[on_symmetry], u[on_symmetry], phi[on_symmetry] + 1j * IMAGINARY_STEP)
            slope = at.d.imag / IMAGINARY_STEP
            phi[on_symmetry] -= (at.d.real - self.d[places.which[on_symmetry]]) / np.where(slope == 0, np.inf, slope)
        return u, phi


def _tested(values: Floats, half: tuple[float, float], rest: Floats) -> Tested:
    """Test cells for zeros of two functions.

    Parameters
    ----------
    values : ndarray, shape (3, 2, ...)
        At the middles of the cells: both functions, their derivatives by u, and by the phase.
    half : tuple of float
        Half the extents of the cells.
    rest : ndarray, shape (2, ...)
        Bounds of the nonlinear parts of both functions.

    Notes
    -----
    At a zero F + J x + R = 0, with x in units of `half` and |R| at most `rest`; times the adjugate of J this bounds
    both components of x. The derivatives change by twice `rest` at most: where J^-1 times that is at most `CHANGE`,
    Newton's map contracts.
    """
    (f, g), (f_u, g_u), (f_phi, g_phi) = values[0], values[1] * half[0], values[2] * half[1]
    rest_f, rest_g, wide = rest[0], rest[1], 1 + OVERLAP
    determinant = np.abs(f_u * g_phi - f_phi * g_u)
    spread_u = np.abs(g_phi) * rest_f + np.abs(f_phi) * rest_g
    spread_phi = np.abs(g_u) * rest_f + np.abs(f_u) * rest_g
    may = np.abs(f) <= (np.abs(f_u) + np.abs(f_phi)) * wide + rest_f
    may &= np.abs(g) <= (np.abs(g_u) + np.abs(g_phi)) * wide + rest_g
    may &= np.abs(f * g_phi - g * f_phi) <= determinant * wide + spread_u
    may &= np.abs(g * f_u - f * g_u) <= determinant * wide + spread_phi
    return Tested(may, 2 * np.maximum(spread_u, spread_phi) <= CHANGE * determinant)


def _neighbours(values: Floats, points: Ints) -> Iterator[Ints]:
    """Divide design points into groups of near ones, by halving them along their widest value.

    Parameters
    ----------
    values : ndarray (m, all points)
    points : ndarray of int
    """
    if len(points) <= TOGETHER:
        yield from [points] if points.size else []
        return
    value = values[:, points]
    order = points[np.argsort(value[np.ptp(value, axis=1).argmax()], kind="stable")]
    for part in np.array_split(order, 2):
        yield from _neighbours(values, part)
