"""The level curve of a sweep as a contour in the plane of q and phase, where two sheets over q do not give it.

For a force with harmonics the level above each q is a trigonometric polynomial in the phase, of the highest order H of
the force: 2H phases at most, whose number changes with q, where a sine has two sheets in closed form. The same holds
for a sweep over a restitution, see `bounces`.

So the height above the level is sampled on a grid, far below its shortest wavelength and, next to q = 1/2 and to the
edges, in every decade down to rounding (marching squares). Where the signs differ at the ends of an edge of the grid,
the curve crosses it; these points are located to the last bit and joined from cell to cell. A closed curve inside a
cell crosses no edge: it goes round an extremum, which is looked for next to the extrema of the grid. Between two points
of a strand the curve is located on the normal of their chord.

Read from `contours` on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.motions.level_plane import EDGE, ContourPlane
from vireport.motions.roots import bracketed_root

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

PER_PERIOD, PHASES = 128, 48
"""Steps of q for each forcing period of the motion, and of the phase, for each order of the force."""

TINIEST, COARSEST = -18, -2
"""Decades of u next to q = 1/2 and to the edges that have separate steps."""

ON_MIDDLE = 10.0**TINIEST
"""|u| up to which a point is on q = 1/2."""

PER_DECADE = 4
"""Steps in each of these decades."""

NEAREST = 1e-11
"""Distance of two points of a contour up to which only one of them is kept."""

STEEP = 0.5
"""Largest angle between the curve and the chord of two points [rad]; where it is larger, the curve is followed from one
point to the other in short steps."""

SMALLEST, LARGEST_PART = 1e-13, 0.25
"""Least and largest step in which a curve is followed between two points, as a share of their chord."""

TURNED = 0.2
"""Largest change of the curve's direction in a step in which it is followed [rad]."""

MOST_STEPS = 400
"""Largest number of steps within one chord, or around a closed curve inside a cell."""

CORRECTIONS, SETTLED = 40, 4e-16
"""Newton steps onto the curve, of which four are usual, and the step, over the size of the place, that ends them."""

FREE, ROUNDING = 5, 1e-9
"""Number of Newton steps after which a step of this share of the chord ends them too: rounding keeps it from
shrinking."""

OFF_CURVE = 1e-9
"""Height above the level at which a place is not on the curve."""

EXTREMUM_STEPS = 40
"""Newton steps to an extremum of the level, of which six are usual."""


class Contour(Struct, frozen=True, eq=False):
    """One smooth piece of a level curve, as a sequence of points; its parameter w is i at point i.

    Attributes
    ----------
    u, phi : ndarray
        Places of the points, in order. The phase [rad] is continuous, beyond 2 pi too. The last point of a closed curve
        is the first one, whole turns later.
    closed : bool
    """

    u: Floats
    phi: Floats
    closed: bool

    @property
    def start(self) -> float:
        """Parameter of the curve at its beginning."""
        return 0.0

    @property
    def end(self) -> float:
        """Parameter of the last point."""
        return float(len(self.u) - 1)

    @property
    def symmetric(self) -> bool:
        """False: the symmetric line of a horizontal capsule is a `Strand`, never a contour."""
        return False

    @property
    def samples(self) -> int:
        """Number of samples before refinement: its points."""
        return len(self.u)

    def crossings(self) -> list[float]:
        """Parameters w of the points at which the contour crosses q = 1/2."""
        # The finest cells of the grid are around q = 1/2: a curve that crosses it has a point with |u| <= ON_MIDDLE.
        return [float(i) for i in np.flatnonzero(np.abs(self.u[1:-1]) <= ON_MIDDLE) + 1]


def contours(surface: ContourPlane) -> list[Contour]:
    """Find every piece of the level curve over 0 < q < 1.

    Raises
    ------
    NumericalError
        If the curve bends too sharply to be followed from one point to the next.
    """
    u, phi = _grid(surface)
    values = surface.on_grid(u, phi)
    chains = [_thinned(chain) for chain in _chains(surface, u, phi, values)]
    chains += _hidden(surface, u, phi, values)
    return [_refined(surface, part) for whole in chains for part in _within(surface, whole)]


def _within(surface: ContourPlane, strand: Contour) -> Iterator[Contour]:
    """The parts of a contour next to which there may be motions."""
    # Far from motions the curve may be unresolved, or cross another piece: such parts are left out before refinement.
    measure, below = surface.within(strand.u, strand.phi)
    near = measure > below
    if near.all():
        yield strand
        return
    u, phi = strand.u, strand.phi
    if strand.closed:
        first, turn = int(np.argmin(near)), phi[-1] - phi[0]
        u, phi = np.concatenate([u[first:-1], u[: first + 1]]), np.concatenate([phi[first:-1], phi[: first + 1] + turn])
        measure = np.concatenate([measure[first:-1], measure[: first + 1]])
    # A step that goes from motions to where none are near is kept as well.
    steps = ((measure[1:] > below) & (measure[:-1] > below)) | (np.maximum(measure[1:], measure[:-1]) > 0)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steps, [False]]).astype(np.int8)))
    for begin, end in edges.reshape(-1, 2).tolist():
        yield Contour(u[begin : end + 1], phi[begin : end + 1], False)


def places(strands: Sequence[Any], which: Ints, w: Floats, surface: ContourPlane) -> tuple[Floats, Floats]:
    """Places (u, phi) on the curve at parameters `w` of the strands with the numbers `which`, to the last bit.

    A strand that is no contour is the symmetric line, on which u is zero and the parameter is the phase.
    """
    u, phi = np.zeros(len(w)), np.array(w, dtype=float)
    for k in np.unique(which):
        if isinstance(strand := strands[k], Contour):
            on_strand = which == k
            u[on_strand], phi[on_strand] = _places_on(strand, w[on_strand], surface)
    return u, phi


def _places_on(strand: Contour, w: Floats, surface: ContourPlane) -> tuple[Floats, Floats]:
    """Places on the curve at parameters of one contour: between two points, on the normal of their chord."""
    last = len(strand.u) - 1
    turns, shifted = np.zeros_like(w), w
    if strand.closed:
        turns = np.floor(w / last)
        shifted = w - turns * last
    i = np.clip(np.floor(shifted).astype(np.intp), 0, last - 1)
    share = shifted - i
    u = strand.u[i] + share * (strand.u[i + 1] - strand.u[i])
    phi = strand.phi[i] + share * (strand.phi[i + 1] - strand.phi[i])
    # A point of the strand itself stays as it was located.
    off = (share > 0) & (share < 1)
    chord = strand.u[i + 1] - strand.u[i], strand.phi[i + 1] - strand.phi[i]
    u[off], phi[off] = _corrected(surface, u[off], phi[off], (-chord[1][off], chord[0][off]))
    return np.clip(u, -EDGE, EDGE), phi + turns * (strand.phi[-1] - strand.phi[0])


def _corrected(surface: ContourPlane, u: Floats, phi: Floats, normal: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Points of the curve on the straight lines through given places, by Newton's method.

    Parameters
    ----------
    surface : ContourPlane
    u, phi : ndarray
        Places near the curve.
    normal : tuple of ndarray
        Direction of the line through each, as long as the chord that it is normal to.

    Raises
    ------
    NumericalError
        If a place does not come onto the curve.
    """
    size = np.hypot(*normal)
    across = normal[0] / size, normal[1] / size
    active, u, phi = np.arange(len(u)), u.copy(), phi.copy()
    for count in range(CORRECTIONS):
        if not active.size:
            break
        value, by_u, by_phi = surface.gradient(u[active], phi[active])
        slope = by_u * across[0][active] + by_phi * across[1][active]
        # Never farther than the chord is long: a step that is, is one to another piece.
        step = np.clip(-value / np.where(slope == 0, np.inf, slope), -size[active], size[active])
        moved = step * across[0][active], step * across[1][active]
        # Rounding leaves of a step what it leaves of either coordinate, or of the height.
        rounded = SETTLED * (np.abs(across[0][active] * u[active]) + np.abs(across[1][active] * phi[active]))
        u[active], phi[active] = np.clip(u[active] + moved[0], -EDGE, EDGE), phi[active] + moved[1]
        settled = (np.abs(step) <= rounded) | ((count > FREE) & (np.abs(step) <= ROUNDING * size[active]))
        active = active[~settled]
    # At an edge, or where both derivatives vanish, steps do not settle although the place is on the curve.
    if active.size and np.abs(surface.value(u[active], phi[active])).max() > OFF_CURVE:
        raise NumericalError(surface.unresolved)
    return u, phi


def _grid(surface: ContourPlane) -> tuple[Floats, Floats]:
    """Grid lines of u and of the phase on which the surface is sampled."""
    highest = surface.order
    even = np.linspace(-EDGE, EDGE, PER_PERIOD * surface.n * highest + 1)
    decades = 10.0 ** np.arange(TINIEST, COARSEST, 1 / PER_DECADE)
    near_edge = EDGE - decades[decades > 1e-12]
    # Beside u = 0: there the surface may vanish for all phases, and no sign would say on which side the curve is.
    middle = decades if surface.sharp else decades[:1]
    u = np.sort(np.concatenate([even[even != 0], middle, -middle, near_edge, -near_edge]))
    count = PHASES * highest
    return u, 2 * np.pi * (np.arange(count) + 0.5) / count


def _chains(surface: ContourPlane, u: Floats, phi: Floats, values: Floats) -> Iterator[Contour]:
    """Join the points at which the curve crosses edges of the grid, from cell to cell."""
    at = _crossings(surface, u, phi, values > 0)
    links: dict[int, list[int]] = {edge: [] for edge in at}
    for first, second in _joints(surface, u, phi, values > 0):
        links[first].append(second)
        links[second].append(first)
    seen: set[int] = set()
    ends = [edge for edge, joined in links.items() if len(joined) == 1]
    for begin in [*ends, *links]:
        if begin in seen or not links[begin]:
            continue
        chain = _walked(begin, links, seen)
        closed = len(chain) > 2 and begin in links[chain[-1]]
        points = np.array([at[edge] for edge in ([*chain, begin] if closed else chain)])
        yield Contour(points[:, 0], np.unwrap(points[:, 1]), closed)


def _crossings(
    surface: ContourPlane, u: Floats, phi: Floats, above: NDArray[np.bool_]
) -> dict[int, tuple[float, float]]:
    """The place (u, phi) at which the curve crosses an edge of the grid, by the number of the edge.

    Edges in the direction of u are numbered first, by the corner at their lower end; then those in the direction of the
    phase.
    """
    rows, columns = above.shape
    edges = np.flatnonzero(above[:-1] != above[1:])
    row, column = np.divmod(edges, columns)
    crossed = bracketed_root(lambda x: surface.value(x, phi[column]), u[row], u[row + 1])
    at = dict(zip(edges.tolist(), zip(crossed.tolist(), phi[column].tolist(), strict=True), strict=True))
    edges, step = np.flatnonzero(above != np.roll(above, -1, axis=1)), phi[1] - phi[0]
    row, column = np.divmod(edges, columns)
    crossed = bracketed_root(lambda x: surface.value(u[row], x), phi[column], phi[column] + step)
    numbers = (edges + rows * columns).tolist()
    return at | dict(zip(numbers, zip(u[row].tolist(), crossed.tolist(), strict=True), strict=True))


def _walked(begin: int, links: dict[int, list[int]], seen: set[int]) -> list[int]:
    """Numbers of the edges that are linked from one edge on, in order; they are added to those `seen`."""
    chain = [begin]
    seen.add(begin)
    while onward := [edge for edge in links[chain[-1]] if edge not in seen]:
        chain.append(onward[0])
        seen.add(onward[0])
    return chain


def _joints(surface: ContourPlane, u: Floats, phi: Floats, above: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Pairs of edges between which the curve crosses a cell, by their numbers in `_crossings`."""
    rows, columns = above.shape
    shift, right = rows * columns, np.roll(above, -1, axis=1)
    corners = above[:-1].astype(int) + above[1:] + right[:-1] + right[1:]
    for cell in np.flatnonzero((corners > 0) & (corners < 4)).tolist():
        i, k = divmod(cell, columns)
        next_column = (k + 1) % columns
        left, onward, low, high = i * columns + k, i * columns + next_column, shift + cell, shift + cell + columns
        crossed = [
            edge
            for edge, differ in (
                (left, above[i, k] != above[i + 1, k]),
                (onward, above[i, next_column] != above[i + 1, next_column]),
                (low, above[i, k] != above[i, next_column]),
                (high, above[i + 1, k] != above[i + 1, next_column]),
            )
            if differ
        ]
        if len(crossed) == 2:
            yield crossed[0], crossed[1]
        else:
            # A saddle: the corners with the sign of its middle are on one side.
            middle = _saddle(surface, (u[i] + u[i + 1]) / 2, phi[k] + (phi[1] - phi[0]) / 2)
            if middle == above[i, k]:
                yield onward, low
                yield left, high
            else:
                yield left, low
                yield onward, high


def _saddle(surface: ContourPlane, u: float, phi: float) -> bool:
    """Whether the height at the saddle point next to a place is positive."""
    # The height at the middle of the cell would not do: next to where two families meet its sign is not the saddle's.
    place = _stationary(surface, np.array([u]), np.array([phi]))
    return bool(surface.value(*place)[0] > 0)


def _stationary(surface: ContourPlane, u: Floats, phi: Floats) -> tuple[Floats, Floats]:
    """Stationary places of the height next to given ones, by Newton's method with differences of the gradient.

    A place at which the method diverges stays as it was.
    """
    du, dphi = np.maximum(1e-6 * np.abs(u), 1e-12), 1e-6
    first = u, phi
    for _ in range(EXTREMUM_STEPS):
        _, by_u, by_phi = surface.gradient(u, phi)
        _, ahead_u, ahead_phi = surface.gradient(u + du, phi)
        _, _, later_phi = surface.gradient(u, phi + dphi)
        uu, up, pp = (ahead_u - by_u) / du, (ahead_phi - by_phi) / du, (later_phi - by_phi) / dphi
        determinant = uu * pp - up * up
        safe = np.where(determinant == 0, 1.0, determinant)
        step = (by_u * pp - by_phi * up) / safe, (by_phi * uu - by_u * up) / safe
        u, phi = np.clip(u - step[0], -EDGE, EDGE), phi - step[1]
        if max(np.abs(step[0]).max(initial=0.0), np.abs(step[1]).max(initial=0.0)) < 1e-12:
            break
    lost = ~(np.isfinite(u) & np.isfinite(phi))
    return np.where(lost, first[0], u), np.where(lost, first[1], phi)


def _hidden(surface: ContourPlane, u: Floats, phi: Floats, values: Floats) -> list[Contour]:
    """Find the closed curves that cross no edge of the grid, around extrema of the height."""
    # Such a curve changes no sign on the grid. It goes round an extremum of the other sign, next to a sample that is
    # nearer to zero than its eight neighbours.
    inner, size = values[1:-1], np.abs(values)
    nearest = np.ones_like(inner, dtype=bool)
    for i in (-1, 0, 1):
        for k in (-1, 0, 1):
            if (i, k) != (0, 0):
                other = np.roll(values, -k, axis=1)[1 + i : len(u) - 1 + i]
                nearest &= (other * inner > 0) & (np.abs(other) >= size[1:-1])
    rows, columns = np.nonzero(nearest)
    if not rows.size:
        return []
    rows = rows + 1
    at_u, at_phi = _stationary(surface, u[rows], phi[columns])
    step = phi[1] - phi[0]
    within = (at_u > u[rows - 1]) & (at_u < u[rows + 1]) & (np.abs(at_phi - phi[columns]) < step)
    across = within & (surface.value(at_u, at_phi) * values[rows, columns] < 0)
    loops = []
    for k in np.flatnonzero(across).tolist():
        ends, place_phi = (at_u[[k]], u[[rows[k] + 1]]), at_phi[[k]]

        def above(x: Floats, place_phi: Floats = place_phi) -> Floats:
            return np.asarray(surface.value(x, place_phi))

        begin = bracketed_root(above, *ends)
        loops.append(_around(surface, float(begin[0]), float(at_phi[k]), float(abs(begin[0] - at_u[k]))))
    return loops


def _around(surface: ContourPlane, u: float, phi: float, reach: float) -> Contour:
    """The small closed curve through a place with the half width `reach` in u, as points a tenth of that apart."""
    # Measured by its extents in u and in the phase, the curve is round: steps on it are then of one size.
    points, place = [(u, phi)], np.array([u, phi])
    _, by_u, by_phi = (float(x[0]) for x in surface.gradient(np.array([u]), np.array([phi])))
    wide = np.array([reach, _extent(surface, u, phi, reach)])
    way = np.array([-by_phi * wide[1], by_u * wide[0]])
    for count in range(MOST_STEPS):
        way /= np.linalg.norm(way)
        guess = place + 0.1 * wide * way
        place, way = _next_to(surface, guess, wide, way)
        points.append((float(place[0]), float(place[1])))
        back = (np.array(points[0]) - place) / wide
        if count > 8 and np.linalg.norm(back) < 0.11:
            break
    points.append(points[0])
    whole = np.array(points)
    return Contour(whole[:, 0], whole[:, 1], True)


def _extent(surface: ContourPlane, u: float, phi: float, reach: float) -> float:
    """Half width in the phase of the small closed curve whose half width in u is `reach`, by its curvature."""
    centre = np.array([u - reach]), np.array([phi])
    small = 1e-4
    by = [surface.gradient(centre[0], centre[1] + sign * small)[2] for sign in (-1, 1)]
    bend = abs(float((by[1] - by[0])[0])) / (2 * small)
    depth = abs(float(surface.value(*centre)[0]))
    return min(float(np.sqrt(2 * depth / bend)) if bend else 1.0, 1.0)


def _next_to(
    surface: ContourPlane, guess: Floats, wide: Floats, way: Floats, side: float = 0.0
) -> tuple[Floats, Floats]:
    """The point of the curve on the normal of `way` through a guess, and the direction of the curve there.

    Parameters
    ----------
    surface : ContourPlane
    guess : ndarray (2,)
        u and phase.
    wide : ndarray (2,)
        Scales of u and phase, by which directions are measured.
    way : ndarray (2,)
        Unit vector of the direction in which the curve is followed.
    side : float
        The direction returned has the height growing to this side, 1 or -1; with 0 it is the one nearer to `way`.
    """
    normal = np.array([-way[1], way[0]])
    for _ in range(CORRECTIONS):
        value, by_u, by_phi = (float(x[0]) for x in surface.gradient(guess[:1], guess[1:]))
        slope = by_u * wide[0] * normal[0] + by_phi * wide[1] * normal[1]
        step = np.clip(-value / slope, -0.2, 0.2) if slope else 0.0
        guess = guess + step * wide * normal
        if abs(step) < 1e-15:
            break
    onward = np.array([-by_phi * wide[1], by_u * wide[0]])
    onward /= np.linalg.norm(onward) or 1.0
    return guess, onward * (side or (1.0 if onward @ way > 0 else -1.0))


def _thinned(strand: Contour) -> Contour:
    """A contour without points so near to others that only rounding decides in which direction the next one is."""
    places, kept = np.column_stack([strand.u, strand.phi]).tolist(), [0]
    on_middle = (np.abs(strand.u) <= ON_MIDDLE).tolist()
    for i, (u, phi) in enumerate(places[1:], 1):
        before = places[kept[-1]]
        if max(abs(u - before[0]), abs(phi - before[1])) > NEAREST:
            kept.append(i)
        elif len(kept) > 1 and not on_middle[kept[-1]] and (on_middle[i] or i == len(places) - 1):
            kept[-1] = i  # what a curve is cut at, or ends at, stays
    if kept[-1] != len(places) - 1:
        kept.append(len(places) - 1)
    return Contour(strand.u[kept], strand.phi[kept], strand.closed)


def _refined(surface: ContourPlane, strand: Contour) -> Contour:
    """A contour with further points where the curve bends away from a chord."""
    # A chord from which the curve turns by more than `STEEP` may hide a bend, or a second piece of the curve nearby,
    # onto which Newton's method on the normal of the chord would jump.
    _, by_u, by_phi = surface.gradient(strand.u, strand.phi)
    du, dphi = np.diff(strand.u), np.diff(strand.phi)
    size = np.hypot(du, dphi)
    defined = size > 0
    # The height grows to the same side of the curve everywhere: so its direction has a sign, and at a sharp bend only
    # this sign shows that the curve goes on before it comes back.
    ways = np.column_stack([-by_phi, by_u])
    ways /= np.maximum(np.linalg.norm(ways, axis=1), np.finfo(float).tiny)[:, None]
    tangent = np.column_stack([du, dphi])
    if np.sum(ways[:-1] * tangent) + np.sum(ways[1:] * tangent) < 0:
        ways = -ways
    with np.errstate(all="ignore"):
        turned = [np.sum(way * tangent, axis=1) / size for way in (ways[:-1], ways[1:])]
    bent = defined & ~(np.minimum(*turned) > np.cos(STEEP))
    if not bent.any() and defined.all():
        return strand
    points = [(float(strand.u[0]), float(strand.phi[0]))]
    for i, (first, second) in enumerate(pairwise(zip(strand.u.tolist(), strand.phi.tolist(), strict=True))):
        if defined[i] and bent[i]:
            points += _walk(surface, np.array(first), np.array(second), ways[i])
        if defined[i]:
            points.append(second)
    whole = np.array(points)
    return Contour(whole[:, 0], whole[:, 1], strand.closed)


def _walk(surface: ContourPlane, first: Floats, second: Floats, way: Floats) -> list[tuple[float, float]]:
    """Points on the curve between two of its points, followed in short steps.

    Parameters
    ----------
    surface : ContourPlane
    first, second : ndarray (2,)
        u and phase of the two points.
    way : ndarray (2,)
        Unit vector of the curve at the first one.

    Raises
    ------
    NumericalError
        If the second point is not reached: the curve bends so sharply that part of it would be left out.
    """
    size = float(np.hypot(*(second - first)))
    place, points, step = first, list[tuple[float, float]](), LARGEST_PART * size
    _, by_u, by_phi = (float(x[0]) for x in surface.gradient(first[:1], first[1:]))
    side = 1.0 if way @ (-by_phi, by_u) > 0 else -1.0
    for _ in range(MOST_STEPS):
        back = second - place
        left = float(np.hypot(*back))
        # The second point is reached only in the direction of the curve: across a thin loop its other side is as near.
        if left <= 1.5 * step and back @ way > np.cos(TURNED) * left:
            return points
        new, onward = _next_to(surface, place + step * way, np.ones(2), way, side)
        turned = float(np.arccos(np.clip(onward @ way, -1.0, 1.0)))
        off = float(np.hypot(*(new - place - step * way)))
        if (turned > TURNED or off > 0.5 * step) and step > SMALLEST * size:
            step /= 2
            continue
        place, way = new, onward
        points.append((float(place[0]), float(place[1])))
        step = min(1.5 * step, LARGEST_PART * size)
    raise NumericalError(surface.unresolved)
