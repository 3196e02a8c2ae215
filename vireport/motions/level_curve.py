"""The level curve of a sweep on the surface of motions: cut into strands, evaluated on them, and sampled.

Read from `curve_of` on: where a sweep has motions at all, the strands of its curve, the motions on these with the
functions that are zero at events, and the samples between which nothing is missed.

Above each q a level a sin(phi) + b cos(phi) = c has two motions where |c| < (a^2 + b^2)^(1/2), one where they meet,
none beyond. So a sweep's motions lie above the intervals of q where that holds, on an upper and a lower sheet that
join smoothly at each end that is a meeting. One parameter w runs over both: q = middle - half cos(w), upper sheet
for 0 < w < pi, lower for pi < w < 2 pi. Where the force has harmonics there are more sheets, see `contour`.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.records import brief
from vireport.motions.bounces import Bounces
from vireport.motions.conditions import Condition
from vireport.motions.contour import Contour, contours, places
from vireport.motions.events import Event
from vireport.motions.level_plane import EDGE, ContourPlane, SweptPlane
from vireport.motions.orbits import Orbits, coefficients, orbits_above, rubbing
from vireport.motions.roots import bracketed_root, golden_minimum, may_hide_zeros
from vireport.motions.stability import discriminant, lap_decay, return_trace
from vireport.motions.sweep import Level, Sweep
from vireport.physics.device import FINEST_D
from vireport.physics.forcing import SINE, Harmonic
from vireport.physics.groups import Restitution, by_wall
from vireport.scenario.parameters import Parameter

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

TINIEST_FEATURE = -18
"""Decade of u down to which existence is looked for next to the symmetric line; `physics.NO_GRAVITY` lies above."""

EXISTENCE_SECTIONS = 60
"""Golden sections that locate an extremum of the margin of existence to the last bit."""

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

SHORTEST_STEP, SHORTEST_STEP_OUTSIDE = 1e-13, 1e-9
"""Steps of w that are not refined: inside the sweep, and outside, where nothing is drawn."""

MOST_SAMPLES = 200_000
"""Number of samples at which a curve is given up: none that rounding resolves takes a twentieth of that."""

PASSES = 60
"""Largest number of bisections of a first step: enough to come from 1/96 of a strand down to rounding."""

COLUMNS: tuple[Condition, ...] = (
    Condition(Event.PERIOD_DOUBLING),
    Condition(Event.NODE_FOCUS, sign=-1),
    Condition(Event.NODE_FOCUS),
    Condition(Event.FOLD),
    Condition(Event.GRAZING),
    Condition(Event.ZERO_VELOCITY, (0,)),
    Condition(Event.ZERO_VELOCITY, (1,)),
    Condition(Event.SWEEP_END, sign=-1),
    Condition(Event.SWEEP_END),
)
"""Conditions of events on a strand: the columns of `LevelCurve.event_values` are zero where they hold. A trace of
1 + r^4 is a fold here; `points` tells a pitchfork from it."""

TRACED, MEETING, GRAZING, VALIDITY = slice(0, 4), 3, 4, slice(5, None)
"""Places in `COLUMNS`: conditions on the trace, among them the fold; grazing; conditions positive for a motion."""


class Strand(Struct, frozen=True, eq=False):
    """One smooth piece of the level curve.

    Attributes
    ----------
    low, high : float
        Ends of its interval of u = q - 1/2; equal on the symmetric line, where w is the phase itself.
    start, end : float
        Range of the parameter w [rad].
    closed : bool
        Whether the end is the start.
    """

    low: float
    high: float
    start: float
    end: float
    closed: bool

    @property
    def sheet(self) -> float:
        """The sheet, 1 upper or -1 lower, of a strand over all q from 0 to 1; 0 for a strand that changes sheets."""
        if self.low != -EDGE or self.high != EDGE:
            return 0.0
        return 1.0 if self.start == 0 else -1.0

    @property
    def symmetric(self) -> bool:
        """Whether this is the symmetric line u = 0 of a horizontal capsule."""
        return self.low == self.high

    @property
    def samples(self) -> int:
        """Number of samples before refinement."""
        return FIRST_SAMPLES

    def crossings(self) -> list[float]:
        """Parameters w at which u = low + (high - low) sin^2(w/2) is zero."""
        if not self.low < 0 < self.high:
            return []
        middle = 2 * np.arcsin(np.sqrt(-self.low / (self.high - self.low)))
        return [w for w in (-middle, middle, 2 * np.pi - middle) if self.start < w < self.end]


Strands: TypeAlias = list[Strand | Contour]
"""The pieces of a level curve; contours where the force has harmonics, but for the symmetric line."""


class LevelCurve(Struct, frozen=True, eq=False):
    """The motions of a sweep as a curve: its strands, and the range of the sweep in which they are looked at.

    Attributes
    ----------
    sweep : Sweep
    plane : SweptPlane
        The plane in which the curve lies.
    strands : list of Strand or Contour
    bounds : tuple of float
        Range of the sweep's coordinate that is looked at: what the scenario sweeps, as far as there can be motions and
        rounding resolves them.
    """

    sweep: Sweep
    plane: SweptPlane
    strands: Strands
    bounds: tuple[float, float]

    __repr__ = brief

    @property
    def level(self) -> Level:
        """The level of the surface that the sweep holds."""
        return self.plane.level

    def restitution(self, orbit: Orbits) -> Any:
        """The restitution of motions: the device's, or of each motion in a sweep over a restitution."""
        return self.plane.r if orbit.restitution is None else orbit.restitution

    @property
    def speed(self) -> float:
        """An upper scale of the impact velocities of all motions on the level [y_c], to divide a drawn axis by."""
        if self.level.d is not None:
            return float(1 + self.level.d / self.plane.n + self.level.value * self.plane.n)
        most = float(max(by_wall(self.plane.r)))
        return 1 + (1 + most) / (1 - most) / float(np.pi)

    def at(self, which: Ints | int, w: Floats) -> Orbits:
        """Motions at parameters `w` on the strands with the numbers `which` (one number, or one for each w)."""
        return evaluate(self.plane, self.strands, which, w)

    def event_values(self, orbit: Orbits) -> Floats:
        """Functions that are zero where the conditions of `COLUMNS` hold, (len, columns).

        The column of grazing is NaN: the gap costs most, and the caller evaluates it only where it is needed. The last
        four are positive on what may be a motion.
        """
        r, (low, high) = self.restitution(orbit), self.bounds
        coordinate = self.sweep.coordinate(orbit)
        with np.errstate(all="ignore"):
            trace = return_trace(orbit, r)
        unknown = np.full(trace.shape, np.nan)
        # Without restitution Delta = tr^2 touches zero and never falls below it: no motion is a focus.
        decay = lap_decay(r)
        bounces = decay > 0
        traced = [
            np.where(bounces, condition.excess(trace, decay), unknown)
            if condition.event is Event.NODE_FOCUS
            else condition.excess(trace, decay)
            for condition in COLUMNS[TRACED]
        ]
        in_sweep = (coordinate - low) / (high - low), (high - coordinate) / (high - low)
        return np.array([*traced, unknown, orbit.velocity_bottom, -orbit.velocity_top, *in_sweep]).T

    def sampled(self) -> Samples:
        """Sample every strand, finer wherever the drawn curve bends, jumps, or may enter the sweep unseen.

        Raises
        ------
        NumericalError
            If rounding does not resolve the curve.
        """
        which = np.repeat(np.arange(len(self.strands)), [strand.samples for strand in self.strands] or 0)
        w = np.concatenate([np.linspace(s.start, s.end, s.samples) for s in self.strands] or [np.empty(0)])
        samples = _samples(self, which, w)
        active = np.ones(max(len(w) - 1, 0), dtype=bool)
        # Active are all steps at first, then only the halves of those whose middle was off the chord: a step that was
        # straight or not relevant once is not looked at again, so that later passes cost little.
        for _ in range(PASSES):
            same = samples.which[1:] == samples.which[:-1]
            index = np.nonzero(active & same & (_relevant(samples) | _jumps(samples)))[0]
            if not index.size:
                break
            if len(samples.w) > MOST_SAMPLES:
                raise NumericalError(
                    f"the motions from {self.sweep.parameter} = {self.sweep.start:g} to {self.sweep.end:g} are not "
                    "resolved in double precision: their curve bends on every scale (narrow the sweep, or use a "
                    "restitution further from 1)"
                )
            middle = _samples(self, samples.which[index], (samples.w[index] + samples.w[index + 1]) / 2)
            coarse = _coarse(samples, index, middle)
            order = np.argsort(np.concatenate([np.arange(len(samples.w)), index + 0.5]), kind="stable")
            halves = np.zeros(len(samples.w), dtype=bool)
            halves[index] = coarse
            active = np.concatenate([halves, coarse])[order][:-1]
            both = [(getattr(samples, name), getattr(middle, name)) for name in Samples.__struct_fields__]
            samples = Samples(*(np.concatenate(pair)[order] for pair in both))
        return samples


def plane_of(sweep: Sweep) -> SweptPlane:
    """The plane of the 1:1 motions of a sweep, its kind chosen by the force and the parameter that varies."""
    device = sweep.device
    kind = ContourPlane if device.harmonics else SweptPlane
    if sweep.parameter.bounces:
        kind = Bounces
    return kind(sweep.level, device.restitution, device.period_ratio, device.harmonics)


def curve_of(sweep: Sweep) -> LevelCurve:
    """Find the level curve of a sweep; it has no strands where the sweep is beyond all motions."""
    plane, device = plane_of(sweep), sweep.device
    if sweep.parameter.bounces:
        return LevelCurve(sweep, plane, find_strands(plane), sweep.coordinate_range)
    ends = [device.groups(sweep.parameter, value) for value in (sweep.start, sweep.end)]
    least = min(float(end.d) for end in ends), min(float(end.gbar) for end in ends)
    largest = largest_groups(device.restitution, device.period_ratio, device.harmonics)
    if device.rubs:
        most = max(float(end.friction) for end in ends)
        largest = largest_with_friction(largest, most, device.restitution, device.period_ratio)
    # Beyond the largest groups there is no motion: no curve is sought in a sweep that lies there.
    low, high = sweep.coordinate_range
    if any(group > most for group, most in zip(least, largest, strict=True)):
        return LevelCurve(sweep, plane, [], (low, high))
    strands = find_strands(plane)
    # A sweep over decades is bounded on the scale of the motions, or else its ends are lost in rounding.
    if sweep.parameter is Parameter.INCLINATION:
        return LevelCurve(sweep, plane, strands, (low, min(high, largest[1])))
    return LevelCurve(sweep, plane, strands, (max(low, min(device.finest(FINEST_D), high / 2)), min(high, largest[0])))


def largest_with_friction(largest: tuple[float, float], friction: float, r: Restitution, n: int) -> tuple[float, float]:
    """Largest d and gbar of any motion with friction.

    Parameters
    ----------
    largest : tuple of float
        d and gbar without friction, see `largest_groups`.
    friction : float
        Largest friction f over the sweep [-].
    r : float or Restitutions
    n : int
        Forcing periods per motion.
    """
    u = np.linspace(-EDGE, EDGE, 4096 * n + 1)
    rubbed = rubbing(coefficients(u, r, n), u, r, n)
    d, gbar = (1.001 * friction * float(np.abs(part).max()) for part in (rubbed.d, rubbed.gbar))
    return largest[0] + d, largest[1] + gbar


@lru_cache(maxsize=64)
def largest_groups(r: Any, n: int, harmonics: tuple[Harmonic, ...]) -> tuple[float, float]:
    """Largest d and gbar of any motion, enlarged by 0.1 %; upper bounds of these where the force has harmonics."""
    if harmonics:
        parts = [(part.share, *largest_groups(r, part.order * n, ()), part.order) for part in (SINE, *harmonics)]
        return sum(p * d / j**2 for p, d, _, j in parts), sum(p * gbar for p, _, gbar, _ in parts)
    k = coefficients(np.linspace(-EDGE, EDGE, 4096 * n + 1), r, n)
    # Over all phases a sin(phi) + b cos(phi) is (a^2 + b^2)^(1/2) at most.
    d, gbar = np.hypot(k.d_sine, k.d_cosine), np.hypot(k.gbar_sine, k.gbar_cosine)
    return 1.001 * float(d.max()), 1.001 * float(gbar.max())


def find_strands(plane: SweptPlane) -> Strands:
    """Find every strand of the level over 0 < q < 1."""
    strands: Strands = []
    # With gbar = 0 both coefficients of gbar vanish at u = 0, where every phase is a motion: a line apart from the rest
    # of the level, of which u is divided out in `SweptPlane.terms`.
    if plane.mirrors:
        strands.append(Strand(0.0, 0.0, -np.pi, np.pi, closed=True))
    if isinstance(plane, ContourPlane):
        return [*strands, *contours(plane)]
    for low, high in _existence(plane):
        if low == -EDGE and high == EDGE:
            strands += [Strand(low, high, 0.0, np.pi, False), Strand(low, high, np.pi, 2 * np.pi, False)]
        elif high == EDGE:
            strands.append(Strand(low, high, -np.pi, np.pi, False))
        else:
            strands.append(Strand(low, high, 0.0, 2 * np.pi, low != -EDGE))
    return strands


def _existence(plane: SweptPlane) -> list[tuple[float, float]]:
    """Find the intervals of u in which the level has motions, where the margin (a^2 + b^2)^(1/2) - |c| is positive.

    The margin is sampled far below its shortest wavelength 1/(2n) and, next to u = 0 and to the edges, where d
    vanishes, in every decade down to rounding. Extrema that come close to zero without crossing it are refined first;
    then its zeros are located to the last bit.
    """

    def margin(u: Floats) -> Floats:
        a, b, c = plane.terms(coefficients(u, plane.r, plane.n), u)
        return np.asarray(np.hypot(a, b) - np.abs(c))

    even = np.linspace(-EDGE, EDGE, 256 * plane.n + 1)
    decades = 10.0 ** np.arange(TINIEST_FEATURE, -2, 0.25)
    near_edge = EDGE - decades[decades > 1e-12]
    grid = np.sort(np.concatenate([even, decades, -decades, near_edge, -near_edge]))
    values = margin(grid)
    index = np.nonzero(may_hide_zeros(values))[0] + 1
    # Without this, intervals of motions narrower than a step of the grid are lost.
    if index.size:
        sign = np.sign(values[index])
        extra = golden_minimum(lambda u: sign * margin(u), grid[index - 1], grid[index + 1], EXISTENCE_SECTIONS)
        order = np.argsort(np.concatenate([grid, extra]), kind="stable")
        grid, values = np.concatenate([grid, extra])[order], np.concatenate([values, margin(extra)])[order]
    inside = values > 0
    flips = np.nonzero(inside[1:] != inside[:-1])[0]
    roots = bracketed_root(margin, grid[flips], grid[flips + 1])
    ends = np.concatenate([[-EDGE] if inside[0] else [], roots, [EDGE] if inside[-1] else []])
    return [(float(ends[i]), float(ends[i + 1])) for i in range(0, len(ends), 2)]


def evaluate(plane: SweptPlane, strands: Strands, which: Ints | int, w: Floats) -> Orbits:
    """Motions at parameters `w` on the strands with the numbers `which` (one number, or one for each w)."""
    which = np.broadcast_to(which, w.shape)
    if isinstance(plane, ContourPlane):
        u, phi = places(strands, which, w, plane)
        return plane.orbits(u, np.mod(phi, 2 * np.pi))
    sheets = [strand for strand in strands if isinstance(strand, Strand)]  # all of them
    low = np.array([s.low for s in sheets])[which]
    width = np.array([s.high - s.low for s in sheets])[which]
    half_angle = w / 2
    near_low = width * np.sin(half_angle) ** 2
    near_high = width * np.cos(half_angle) ** 2
    # Measured from the nearer end, so that u keeps its relative accuracy where the sheets meet.
    u = np.where(near_low <= near_high, low + near_low, low + width - near_high)
    terms = coefficients(u, plane.r, plane.n)
    a, b, c = plane.terms(terms, u)
    norm = np.hypot(a, b)
    ratio = np.clip(c / np.where(norm == 0, 1.0, norm), -1.0, 1.0)
    # Two sheets and not one phase that is followed along q: arccos alone gives phases on the upper one only, and at an
    # end of the interval, where both meet, the phase as a function of q has an infinite slope; w does not.
    # An open strand ends on one sheet, at an edge where the two do not meet: there w must not be taken modulo 2 pi.
    sheet_number = np.array([s.sheet for s in sheets])[which]
    turned = np.where(np.array([s.closed for s in sheets])[which], np.mod(w, 2 * np.pi), w)
    sheet = np.where(sheet_number != 0, sheet_number, np.where((turned < 0) | (turned > np.pi), -1.0, 1.0))
    # a sin(phi) + b cos(phi) = (a^2 + b^2)^(1/2) cos(phi - arctan2(a, b)) = c: two phases, one on either sheet.
    phi = np.arctan2(a, b) + sheet * np.arccos(ratio)
    phi = np.where(width == 0, w, phi)
    return orbits_above(terms, plane.dynamics, u, np.mod(phi, 2 * np.pi))


class Samples(Struct, frozen=True, eq=False):
    """Samples on the strands, in order, with the numbers that decide where they are refined.

    Attributes
    ----------
    which, w : ndarray
        Strand and parameter of each sample.
    validity : ndarray
        The least of the functions that are positive on what may be a motion.
    drawn : ndarray, shape (len, columns)
        The sample in the planes that are drawn, each axis scaled to 1.
    """

    which: Ints
    w: Floats
    validity: Floats
    drawn: Floats


def _samples(curve: LevelCurve, which: Ints, w: Floats) -> Samples:
    """Evaluate samples: their validity, and where they are in the planes that are drawn."""
    orbit = curve.at(which, w)
    events = curve.event_values(orbit)
    r = curve.restitution(orbit)
    decay = lap_decay(r)
    trace = COLUMNS[0].trace(events[:, 0], decay)
    low, high = curve.bounds
    speed = curve.speed
    with np.errstate(all="ignore"):
        root = np.sqrt(np.abs(np.clip(discriminant(trace, decay), -4.0, 4.0)))
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


def _coarse(samples: Samples, index: Ints, middle: Samples) -> NDArray[np.bool_]:
    """Whether the halves of the steps at `index`, whose middles are given, have to be halved again."""
    # By the distance of the middle from the chord, not by the length of steps: a straight piece is exact as one line of
    # any length, and next to a fold equal steps would cut the corner.
    chord = samples.drawn[index + 1] - samples.drawn[index]
    bend = middle.drawn - samples.drawn[index] - chord / 2
    coarse = (np.linalg.norm(bend, axis=1) > SMOOTHNESS) | (np.linalg.norm(chord, axis=1) > LONGEST_CHORD)
    seen = (middle.validity > 0) | (samples.validity[index] > 0) | (samples.validity[index + 1] > 0)
    coarse &= np.abs(middle.w - samples.w[index]) > np.where(seen, SHORTEST_STEP, SHORTEST_STEP_OUTSIDE)
    # A step that jumps along the surface is never left alone: what lies in between may be in the sweep though its
    # ends are not.
    return np.asarray(coarse | (np.linalg.norm(chord[:, SURFACE], axis=1) > LONGEST_JUMP))


def _jumps(samples: Samples) -> NDArray[np.bool_]:
    """Which steps are long on the surface of motions, in the sweep or not."""
    return np.asarray(np.linalg.norm(np.diff(samples.drawn[:, SURFACE], axis=0), axis=1) > LONGEST_JUMP)


def _relevant(samples: Samples) -> NDArray[np.bool_]:
    """Which steps touch a valid sample, leap over the sweep, or may hide a rise of the validity above zero."""
    # All three are needed: a strand may enter the sweep and leave it again between two samples that are both outside.
    v, beyond_middle = samples.validity, samples.drawn[:, 0] > 0.5
    touches = (v[1:] > 0) | (v[:-1] > 0) | (beyond_middle[1:] != beyond_middle[:-1])
    inner = v[1:-1]
    rise = 2 * inner - np.minimum(v[:-2], v[2:])  # a peak as far above the sample as the lower neighbour is below it
    hopeful = (inner < 0) & (inner >= v[:-2]) & (inner >= v[2:]) & (rise > 0)
    touches[:-1] |= hopeful
    touches[1:] |= hopeful
    return np.asarray(touches)
