"""Samples of a level curve, as finely as a drawing shows: refined by bisection in the planes that are drawn."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.admissibility import wall_gap
from vireport.analysis.kinds import StrandEvent
from vireport.analysis.orbits import Level, Orbits
from vireport.analysis.stability import discriminant, trace_and_determinant
from vireport.analysis.strands import Strand, evaluate, find_strands, reach
from vireport.analysis.sweep import Sweep
from vireport.errors import NumericalError

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

FIRST_SAMPLES = 97
"""Samples of a strand before refinement; odd, so that the symmetric motion q = 1/2 is one of them."""

SMOOTHNESS = 8e-4
"""Largest distance of the curve from the drawn polyline, as a share of the axes: about half a pixel."""

LONGEST_CHORD = 0.05
"""Longest step of the polyline as a share of the axes, so that no feature of that size hides between two samples."""

SURFACE = slice(3, 6)
"""Columns of `Samples.drawn` that say where on the surface of motions a sample is, by its phase and q."""

LONGEST_JUMP = 0.05
"""Longest step on the surface itself (of phase over 2 pi, and q)."""

MOST_SAMPLES = 200_000
"""Samples at which a curve is given up: none that rounding resolves takes a twentieth of that."""

PASSES = 60
"""Bisections of one first step: enough to come from 1/96 of a strand down to rounding."""

VALIDITY = slice(StrandEvent.BOTTOM_REST, None)
"""Columns of `event_values` that are positive on what may be a motion."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A level curve ready to be evaluated.

    Attributes
    ----------
    sweep : Sweep
    level : Level
    strands : list of Strand
    bounds : tuple of float
        Range of the sweep's coordinate that is asked for.
    """

    sweep: Sweep
    level: Level
    strands: list[Strand]
    bounds: tuple[float, float]

    @property
    def r(self) -> float:
        """Restitution coefficient."""
        return float(self.sweep.device.restitution)

    @property
    def n(self) -> int:
        """Forcing periods per motion."""
        return self.sweep.device.period_ratio

    @property
    def horizontal(self) -> bool:
        """Whether gravity has no part along the capsule and n is odd: motions then have mirror images."""
        return self.level.horizontal and self.n % 2 == 1

    def at(self, which: Ints, w: Floats) -> Orbits:
        """Motions at parameters `w` of the strands `which`."""
        return evaluate(self.strands, which, w, self.level, self.r, self.n)

    def event_values(self, orbit: Orbits, with_gap: object = True) -> Floats:
        """Functions whose zeros are the events of `StrandEvent`; the last four are positive on what may be a motion.

        The gap costs most; it is NaN outside the mask `with_gap` and where there can be no motion.
        """
        r, (low, high) = self.r, self.bounds
        coordinate = self.sweep.coordinate(orbit)
        validity = [
            orbit.velocity_bottom,
            -orbit.velocity_top,
            (coordinate - low) / (high - low),
            (high - coordinate) / (high - low),
        ]
        with np.errstate(all="ignore"):
            trace = trace_and_determinant(orbit, r)[0]
        one, two = 1 + r**4, 2 * r * r
        gap = np.full(trace.shape, np.nan)
        inside = (np.min(validity, axis=0) > 0) & with_gap
        if inside.any():
            gap[inside] = wall_gap(select(orbit, inside), r, self.n)
        # Without restitution Delta = tr^2 touches zero and never falls below it: no motion is a focus.
        foci = [trace + two, trace - two] if r > 0 else [np.full(trace.shape, np.nan)] * 2
        return np.stack([trace + one, *foci, trace - one, gap, *validity], axis=-1)


def curve_of(sweep: Sweep) -> Curve:
    """Find the level curve of a sweep."""
    level = sweep.level
    device = sweep.device
    groups = [device.groups(sweep.parameter, value) for value in (sweep.start, sweep.end)]
    nearest = (min(float(group[k]) for group in groups) for k in range(2))
    beyond = any(x > most for x, most in zip(nearest, reach(device.restitution, device.period_ratio), strict=True))
    strands = [] if beyond else find_strands(level, device.restitution, device.period_ratio)
    return Curve(sweep, level, strands, sweep.coordinate_range)


def select(orbit: Orbits, index: Any) -> Orbits:
    """The motions picked by an index or mask."""
    return Orbits(*(np.asarray(getattr(orbit, field.name))[index] for field in fields(Orbits)))


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Parameters along the strands, in order, and what was evaluated there.

    Attributes
    ----------
    which, w : ndarray
        Strand and parameter of each sample.
    valid : ndarray of bool
        Inside the sweep, with impact velocities of the right sign.
    validity : ndarray
        The least of the functions that decide it.
    drawn : ndarray, shape (len, columns)
        The sample in the planes that are drawn, each axis scaled to 1.
    """

    which: Ints
    w: Floats
    validity: Floats
    drawn: Floats


def sample(curve: Curve) -> Samples:
    """Sample every strand, finer wherever the drawn curve bends, jumps, or may enter the sweep unseen.

    Parameters
    ----------
    curve : Curve

    Raises
    ------
    NumericalError
        If rounding does not resolve the curve.
    """
    which = np.repeat(np.arange(len(curve.strands)), FIRST_SAMPLES)
    w = np.concatenate([np.linspace(s.start, s.end, FIRST_SAMPLES) for s in curve.strands] or [np.empty(0)])
    samples = _samples(curve, which, w)
    active = np.ones(max(len(w) - 1, 0), dtype=bool)
    for _ in range(PASSES):
        same = samples.which[1:] == samples.which[:-1]
        index = np.nonzero(active & same & (_relevant(samples) | _jumps(samples)))[0]
        if not index.size:
            break
        if len(samples.w) > MOST_SAMPLES:
            raise NumericalError(
                f"the motions from {curve.sweep.parameter} = {curve.sweep.start:g} to {curve.sweep.end:g} are not "
                "resolved in double precision: their curve bends on every scale (narrow the sweep, or use a "
                "restitution further from 1)"
            )
        middle = _samples(curve, samples.which[index], (samples.w[index] + samples.w[index + 1]) / 2)
        chord = samples.drawn[index + 1] - samples.drawn[index]
        bend = middle.drawn - samples.drawn[index] - chord / 2
        coarse = (np.linalg.norm(bend, axis=1) > SMOOTHNESS) | (np.linalg.norm(chord, axis=1) > LONGEST_CHORD)
        seen = (middle.validity > 0) | (samples.validity[index] > 0) | (samples.validity[index + 1] > 0)
        coarse &= np.abs(middle.w - samples.w[index]) > np.where(seen, 1e-13, 1e-9)
        # A step that jumps along the surface is never left alone: what lies in between may be in the sweep though its
        # ends are not.
        coarse |= np.linalg.norm(chord[:, SURFACE], axis=1) > LONGEST_JUMP
        order = np.argsort(np.concatenate([np.arange(len(samples.w)), index + 0.5]), kind="stable")
        halves = np.zeros(len(samples.w), dtype=bool)
        halves[index] = coarse
        active = np.concatenate([halves, coarse])[order][:-1]
        samples = Samples(
            *(np.concatenate([getattr(samples, f.name), getattr(middle, f.name)])[order] for f in fields(Samples))
        )
    return samples


def _samples(curve: Curve, which: Ints, w: Floats) -> Samples:
    orbit = curve.at(which, w)
    events = curve.event_values(orbit, with_gap=False)
    r, trace = curve.r, events[:, 0] - (1 + curve.r**4)
    low, high = curve.bounds
    speed = 1 + (1 + r) / (1 - r) / np.pi
    with np.errstate(all="ignore"):
        root = np.sqrt(np.abs(np.clip(discriminant(trace, r), -4.0, 4.0)))
        # The trace passes through infinity where an impact velocity vanishes; faded, the eigenvalues are continuous.
        fade = np.clip(-100 * orbit.velocity_bottom * orbit.velocity_top, -1.0, 1.0) / 3
        drawn = np.stack(
            [
                (curve.sweep.coordinate(orbit) - low) / (high - low),
                orbit.velocity_bottom / speed,
                orbit.velocity_top / speed,
                orbit.cos_phi / (2 * np.pi),
                orbit.sin_phi / (2 * np.pi),
                orbit.u,
                fade * np.clip((trace + root) / 2, -1.5, 1.5),
                fade * np.clip((trace - root) / 2, -1.5, 1.5),
            ],
            axis=-1,
        )
    return Samples(which, w, events[:, VALIDITY].min(axis=1), np.nan_to_num(drawn))


def _jumps(samples: Samples) -> NDArray[np.bool_]:
    """Steps that are long on the surface of motions, wherever they are in the sweep."""
    return np.asarray(np.linalg.norm(np.diff(samples.drawn[:, SURFACE], axis=0), axis=1) > LONGEST_JUMP)


def _relevant(samples: Samples) -> NDArray[np.bool_]:
    """Steps that touch a valid sample, leap over the sweep, or next to which the validity may rise above zero."""
    v, beyond_middle = samples.validity, samples.drawn[:, 0] > 0.5
    touches = (v[1:] > 0) | (v[:-1] > 0) | (beyond_middle[1:] != beyond_middle[:-1])
    inner = v[1:-1]
    rise = 2 * inner - np.minimum(v[:-2], v[2:])  # the peak, if it stands as far above as the lower neighbour below
    hopeful = (inner < 0) & (inner >= v[:-2]) & (inner >= v[2:]) & (rise > 0)
    touches[:-1] |= hopeful
    touches[1:] |= hopeful
    return np.asarray(touches)
