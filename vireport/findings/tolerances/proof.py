"""Whether every device within a box of tolerances has a stable 1:1 motion: proved, refuted, or left open.

The inputs act through a few factors alone: M/F and s f^2, whose product gives d; sin(beta), which with M/F gives gbar;
and r, with the difference of the r of each membrane from it. No two factors share an input, so that a box of inputs is
a box of factors, and nothing is lost. For a free capsule gbar has (M + m)/F instead, and the factors are 1/F and M. A
box of factors is halved until each part is proved:

- Krawczyk's operator maps a tube about a linear prediction of the motion's (q, phase) into itself, for every device in
  the part: by Brouwer's theorem each has a motion in the tube;
- its impact velocities have the right signs, its trace is between -(1 + r^4) and 1 + r^4 (Jury's conditions, with the
  determinant r^4 < 1, or (r_b r_t)^2), and the ball is between the membranes at every time of both flights.

All parts of one generation are evaluated at once in affine arithmetic. Between parts, the motion proved need not be the
same one: what is proved is that every device has some stable motion.
"""

from __future__ import annotations

from enum import IntEnum
from operator import itemgetter
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.base.boxes import Boxes
from vireport.base.records import brief
from vireport.design.devices import Floats, Ints, Mask, stable_motions
from vireport.findings.tolerances.region import OTHER_SYMBOLS, Region
from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.orbits import Orbits
from vireport.motions.stability import lap_decay, return_trace
from vireport.physics.affine import AFFINE, AFFINE_ROUNDING, Affine, between
from vireport.physics.flight import Flight
from vireport.physics.groups import Groups, by_wall, map_restitution

TIME = -1
"""The symbol of time; those before it and after the factors' are of how far the motion is from its prediction."""

MOST_BOXES = 40_000
"""Boxes looked at before the rest is left open: some ten seconds."""

DEEPEST = 48
"""Generations after which the rest is left open: next to a device on the border no box ever is small enough."""

BLOCK = 4096
"""Parts evaluated at once: their numbers stay in the processor's cache."""

PROBE = 2.0**-20
"""Width of the tube in which derivatives are taken."""

TUBES = 5
"""Tubes tried, each wider than what Krawczyk's operator made of the one before."""

SLACK = 1.25
"""Width of a tube over what Krawczyk's operator made of the one before."""

THINNEST = 1e-13
"""Least width of a tube, of the size of rounding."""

BORDER = 1e-9
"""Gap and distance of the trace from its border up to which a device is not said to fail: rounding is far less."""

TIME_PARTS, HALVINGS = 8, 7
"""Parts of a flight for each forcing period, and how often one is halved before it is left open."""


def prove(region: Region, boxes: Boxes, guess: Floats) -> tuple[Mask, Floats]:
    """Prove that every device in each of some boxes has a stable motion near a guess.

    Parameters
    ----------
    region : Region
    boxes : Boxes
        In shares of the region, (factors, k).
    guess : ndarray, shape (3, k)
        q - 1/2, phase [rad] and velocity [y_c] at the bottom of a motion in the middle of each box.

    Returns
    -------
    proved : ndarray of bool, shape (k,)
    moved : ndarray, shape (factors, k)
        Size of the change of the motion when each factor moves from the middle of a box to its end.

    Raises
    ------
    UsageError
        If the force has harmonics, which the proof does not cover.
    """
    n = region.design.of_sine("a proof over tolerances").period_ratio
    with np.errstate(all="ignore"):  # an undefined number is not finite, and proves nothing
        groups = region.groups(boxes.low, boxes.high)
        mapped, orbit, moved = _tube(groups, n, guess)
        r = groups.restitution
        trace, border = return_trace(orbit, r), TRACE_LEVELS[Event.FOLD](lap_decay(r))
        lossy = np.logical_and.reduce([of_wall.upper < 1 for of_wall in by_wall(r)])
        proved = mapped & lossy & ((border - trace).lower > 0) & ((border + trace).lower > 0)
        proved &= (orbit.velocity_bottom.lower > 0) & (orbit.velocity_top.upper < 0)
        rows = np.flatnonzero(proved)
        if rows.size:
            for way in orbit.select(rows).flights(map_restitution(r, itemgetter(rows))):
                proved[rows] &= _stays_between(way, n, len(rows))
    return proved, moved


def _tube(groups: Groups[Affine], n: int, guess: Floats) -> tuple[Mask, Orbits, Floats]:
    """Prove with Krawczyk's operator that a tube, linear in the shares, holds a motion of every device of a box.

    Returns where that is proved, the motions in the tube, and by how much each factor moves them.
    """
    factors = len(groups.d.linear) - OTHER_SYMBOLS
    width, slopes = np.full_like(guess, PROBE), np.zeros((len(guess), factors, guess.shape[1]))
    # The linear parts of the residuals in a narrow tube are their derivatives, by the motion and by the factors: no
    # formula for the Jacobian is needed, and a wrong one would only leave boxes open.
    _, residual = _residual(guess, slopes, width, groups, n)
    jacobian = np.stack([g.linear[factors:TIME] / PROBE for g in residual])
    singular = np.linalg.det(jacobian.T) == 0
    inverse = np.linalg.inv(np.where(singular[:, None, None], np.eye(3), jacobian.T)).T
    # dx/dp = -(df/dx)^-1 df/dp: the tube follows the motion to first order, and need only hold the curvature. With a
    # box about a fixed point instead, 1.5 to 3 % of three inputs of an inclined capsule stay wholly unproved, which a
    # tube proves in two parts.
    slopes = -_applied(inverse, [g.linear[:factors] for g in residual])
    guess = guess - _applied(inverse, [g.centre for g in residual])
    width = np.zeros_like(guess)
    for _ in range(TUBES):
        orbit, residual = _residual(guess, slopes, width, groups, n)
        linear = _applied(inverse, [g.linear for g in residual])
        linear[:, factors:TIME] -= np.eye(3)[:, :, None] * width[:, None]  # the identity less Y times the Jacobian
        rest = _applied(np.abs(inverse), [g.radius + AFFINE_ROUNDING * (np.abs(g.centre) + g.reach) for g in residual])
        image = np.abs(_applied(inverse, [g.centre for g in residual])) + np.abs(linear).sum(axis=1) + rest
        mapped = np.asarray((image * (1 + AFFINE_ROUNDING) < width).all(axis=0))
        if mapped.all():
            break
        width = np.where(mapped, width, SLACK * image + THINNEST)
    return mapped, orbit, 2 * np.pi * np.abs(slopes[0]) + np.abs(slopes[1])


def _applied(matrix: Floats, vectors: list[Floats]) -> Floats:
    """Matrices of shape (3, 3, k) times vectors of shape (3, ..., k)."""
    return np.asarray(np.einsum("ijk,j...k->i...k", matrix, np.stack(vectors)))


def _residual(
    guess: Floats, slopes: Floats, width: Floats, groups: Groups[Affine], n: int
) -> tuple[Orbits, tuple[Affine, Affine, Affine]]:
    """The motions in a tube of (q - 1/2, phase, velocity), and by how much they miss Eqs. (3.9), (3.10) and (3.11).

    The equations as they are, not solved for the velocity, gbar and d as in `vireport.motions.orbits`: the division
    by K(q) would widen the enclosures where r is not small. gbar/2 stands in (3.10), where g/2 is printed.
    """
    factors, count = slopes.shape[1:]
    symbols = np.zeros((len(guess), factors + OTHER_SYMBOLS, count))
    symbols[:, :factors] = slopes
    symbols[range(3), range(factors, factors + 3)] = width
    u, phi, velocity = (Affine(*parts, np.zeros_like(parts[0])) for parts in zip(guess, symbols, strict=True))
    ops, period = AFFINE, 2 * n
    top = phi + ops.pi * period * u  # less n half turns, which are a sign
    sin_phi, cos_phi, sin_top, cos_top = ops.sin(phi), ops.cos(phi), (-1) ** n * ops.sin(top), (-1) ** n * ops.cos(top)
    up, down = n + period * u, n - period * u
    d, gbar, (bottom, at_top) = groups.d, groups.gbar, by_wall(groups.restitution)
    # With unlike membranes, an impact at the bottom transfers as much momentum as one at the top that is faster by this
    # factor.
    share: Any = 1 if bottom is at_top else (1 + bottom) / (1 + at_top)
    orbit = Orbits(
        *(u, phi, sin_phi, cos_phi, sin_top, cos_top, up, down, velocity),
        velocity_top=period * gbar / (1 + at_top) - (velocity if bottom is at_top else share * velocity),
        gbar=gbar,
        d=d,
    )
    r = bottom
    return orbit, (
        (r - share) * velocity - (sin_top - sin_phi) / ops.pi + gbar * (period / (1 + at_top) - up),
        (r * up - down) * velocity + period * sin_phi / ops.pi - 2 * n * period * u * gbar,
        (cos_top - cos_phi) / (ops.pi * ops.pi)
        + up * down * (2 * (1 + r) * velocity - period * gbar) / (2 * period)
        - d,
    )


def _stays_between(way: Flight, n: int, count: int) -> Mask:
    """Whether the ball is proved to stay between the membranes in a flight of each of `count` boxes.

    The flight is cut into parts, and open ones are halved. Next to the impacts, where the distance to one membrane is
    zero, the sign of the velocity or of the acceleration decides: the counterpart in affine arithmetic of
    `vireport.study.checks.confinement`. In `findings.proofs.flights` the ball may also begin off a membrane or touch
    one, and the touches are located.
    """
    ops, parts = AFFINE, TIME_PARTS * n
    inside = np.ones(count, dtype=bool)
    row, place = np.repeat(np.arange(count), parts), np.tile(np.arange(parts), count)
    for _ in range(HALVINGS):
        # Time is an error symbol like the others, so that its occurrences in several terms of the position cancel.
        part = way.select(row)
        time = part.duration * between(place / parts, (place + 1) / parts, TIME, len(part.d.linear))
        angle = ops.pi * time
        sine, cosine = part.turned(ops.sin(angle), ops.cos(angle))
        covered, speed, away = part.covered(time, cosine, ops.pi), part.speed(time, sine, ops.pi), part.pressing(cosine)
        left = part.d - covered
        forward, first, last = speed.lower > 0, place == 0, place == parts - 1
        clear = (covered.lower > 0) | (first & (forward | (away.lower > 0)))
        clear &= (left.lower > 0) | (last & (forward | (away.upper < 0)))
        inside[row[(covered.upper < 0) | (left.upper < 0)]] = False
        still = ~clear & inside[row]
        row, place, parts = np.repeat(row[still], 2), (2 * place[still, None] + np.arange(2)).ravel(), 2 * parts
        if not row.size:
            return inside
    inside[row] = False
    return inside


class Leaf(IntEnum):
    """State of a box that is not halved; a halved box has the number of the factor along which it is cut instead."""

    PROVED = -1
    OPEN = -2


class Proof(Struct, frozen=True, eq=False):
    """The boxes into which a region was cut, as much as is needed to prove it again.

    Attributes
    ----------
    halved : ndarray of int
        For each box, beginning with the region's faces and generation by generation, the factor along which it was
        halved, or a `Leaf`.
    motions : ndarray, shape (3, boxes)
        q - 1/2, phase [rad] and velocity [y_c] at the bottom of a motion in the middle of each proved box, in order.
    open_share : float
        Share of the region's volume in (d, gbar, r) that is not proved.
    failing : ndarray or None, shape (factors,)
        Shares of the region's factors at which a device has no stable motion; None where none was found.
    """

    halved: Ints
    motions: Floats
    open_share: float
    failing: Floats | None

    __repr__ = brief

    @property
    def boxes(self) -> int:
        """Number of boxes that are proved."""
        return len(self.motions.T)


def prove_region(region: Region) -> Proof:
    """Halve a region until each part is proved to have stable motions, or there is a device that has none."""
    boxes, share = region.faces
    generations: list[Ints] = []
    motions, left, failing = [np.empty((3, 0))], 0.0, None
    while len(boxes):
        middle = (boxes.low + boxes.high) / 2
        cell, orbit = stable_motions(region.devices(middle), BORDER)
        # First the middle of each box, which costs one solution: one device without stable motion refutes the region.
        lacking = np.setdiff1d(np.arange(len(boxes)), cell)
        failing = middle[:, lacking[0]] if lacking.size else None
        halved, centres = _halved(region, boxes, cell, np.stack([orbit.u, orbit.phi, orbit.velocity_bottom]))
        generations.append(halved)
        ahead = 2 * np.count_nonzero(halved >= 0)
        ends = failing is not None or len(generations) == DEEPEST
        if ends or sum(map(len, generations)) + ahead > MOST_BOXES:
            halved[halved != Leaf.PROVED] = Leaf.OPEN
        motions.append(centres)
        left += float(share[halved == Leaf.OPEN].sum())
        boxes, share = _halves(boxes, share, halved)
    return Proof(np.concatenate(generations), np.concatenate(motions, axis=1), left + float(share.sum()), failing)


def prove_again(region: Region, halved: Ints, motions: Floats) -> float:
    """Verify the boxes of a proof; returns the share of the region's volume that is proved, 1 if every box is.

    Parameters
    ----------
    region : Region
    halved, motions : ndarray
        As in `Proof`. That the boxes cover the region follows from how it is halved; nothing else is believed.

    Raises
    ------
    ValueError
        If there are too few boxes or motions.
    """
    boxes, share = region.faces
    done, missing, open_share = 0, False, 0.0
    while len(boxes):
        halved, generation = halved[len(boxes) :], halved[: len(boxes)]
        # The places of boxes follow from how they are halved and are not read, so that no proof can leave out a part.
        rows = np.flatnonzero(generation == Leaf.PROVED)
        guess = motions[:, done : (done := done + len(rows))]
        if len(generation) < len(boxes) or guess.shape[1] < len(rows) or generation.max() >= region.factors:
            raise ValueError("the boxes of the proof are not complete")
        holds, _ = prove(region, boxes[rows], guess)
        lacking = generation < 0
        lacking[rows] = ~holds
        missing, open_share = missing or bool(lacking.any()), open_share + float(share[lacking].sum())
        boxes, share = _halves(boxes, share, generation)
    return 1.0 if not missing else min(1 - open_share, np.nextafter(1.0, 0.0))


def _halved(region: Region, boxes: Boxes, cell: Ints, motions: Floats) -> tuple[Ints, Floats]:
    """For each box a factor to halve it along or `Leaf.PROVED`, and the motions of the proved boxes."""
    halved, centres = np.zeros(len(boxes), dtype=np.intp), np.empty((3, len(boxes)))
    for first in range(0, len(cell), BLOCK):
        which, motion = cell[first : first + BLOCK], motions[:, first : first + BLOCK]
        holds, moved = prove(region, boxes[which], motion)
        unproved = halved[which] != Leaf.PROVED  # another motion of the same box may have proved it
        halved[which[unproved]] = np.nan_to_num(moved).argmax(axis=0)[unproved]
        halved[which[holds]] = Leaf.PROVED
        centres[:, which[holds]] = motion[:, holds]
    return halved, centres[:, halved == Leaf.PROVED]


def _halves(boxes: Boxes, share: Floats, halved: Ints) -> tuple[Boxes, Floats]:
    """The next generation of boxes, both halves of each halved one, and their shares of the volume."""
    which = halved >= 0
    return boxes[which].halved(halved[which]), np.repeat(share[which] / 2, 2)
