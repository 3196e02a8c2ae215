"""Data of a study that are drawn along its sweep, as plain arrays: stretches of motions, critical points, simulations.

Only admissible motions are among them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.design.solution import Solution
from vireport.motions.branches import Branch
from vireport.motions.one_to_one import Motions
from vireport.motions.points import Point
from vireport.motions.stability import Stability
from vireport.motions.sweep import Sweep
from vireport.physics.energy import Voltages, deflection, generated_voltage
from vireport.study.study import Study, require_study

if TYPE_CHECKING:
    from vireport.simulation.attractors import Attractor
    from vireport.simulation.cycles import SimulatedMotion

Floats = NDArray[np.float64]
DrawnCurve = tuple[Floats, Floats]
ImpactPairs = tuple[tuple[Floats, Floats], tuple[Floats, Floats], tuple[Floats, Floats]]
"""Impact velocity, phase and half the flight time, each at the bottom and at the top."""

TURN = 2 * np.pi

ROUNDING = 1e-9
"""Distance from a full turn that is rounding [rad]."""

CUT_DISTANCE = 0.15
"""Distance from the nearest curve at which the circle of phases is cut where it cannot be at 0 [rad]."""

NO_PARTNER = np.nan
"""Stands where an impact has no partner on the other membrane."""


class PairedImpacts(Struct, frozen=True, eq=False):
    """Impacts of motions of any word, each on the bottom beside the one on the top that follows it.

    Attributes
    ----------
    sweep_value, d : ndarray of shape (n,)
        Values of the swept parameter and of d.
    velocity, phase, flight : ndarray of shape (2, n)
        At the bottom and at the top: velocity just before the impact, with its sign [y_c]; phase in [0, 2 pi) [rad];
        half the flight time. NaN where an impact has no partner on the other membrane.
    voltages : Voltages or None
    """

    sweep_value: Floats
    d: Floats
    velocity: Floats
    phase: Floats
    flight: Floats
    voltages: Voltages | None = None

    def pairs(self, cut: float = 0.0) -> tuple[Floats, Floats, Floats]:
        """What figure 2 shows of them, the phases from `cut` on [rad]."""
        return np.abs(self.velocity), cut + (self.phase - cut) % TURN, self.flight


class Doubled(Struct, frozen=True, eq=False):
    """Neighbouring motions of a branch that arises by period doubling, with each of their pairs of impacts.

    Attributes
    ----------
    impacts : PairedImpacts
        Those of one pair after those of another.
    pairs : int
    stable : bool
    """

    impacts: PairedImpacts
    pairs: int
    stable: bool


class Stretch(Struct, frozen=True, eq=False):
    """Neighbouring admissible motions of a branch with the same type of stability.

    Attributes
    ----------
    branch : Branch
    rows : slice
        Rows of the branch. At an end there may be the grazing motion, where the admissible ones end.
    stable, focus : bool
        Whether the motions are stable; whether their multipliers are complex.
    """

    branch: Branch
    rows: slice
    stable: bool
    focus: bool


class DrawnPoint(Struct, frozen=True, eq=False):
    """A critical point where it is drawn: on its branch, and on the mirror image of that.

    Attributes
    ----------
    point : Point
    places : tuple of (Branch, int)
        Branches and rows.
    """

    point: Point
    places: tuple[tuple[Branch, int], ...]


def swept_solution(study: Study) -> tuple[Solution, Sweep]:
    """The solution and the sweep of a study.

    Raises
    ------
    UsageError
        If it is no study.
    ValueError
        If the study has no sweep.
    """
    require_study(study)
    if study.solution.sweep is None:
        raise ValueError("figures are drawn along a sweep, and this study has none (give its scenario a sweep block)")
    return study.solution, study.solution.sweep


def stretches(solution: Solution) -> list[Stretch]:
    """The admissible motions of a solution, unstable stretches first, so that stable ones are drawn over them."""
    parts = [
        Stretch(branch, slice(part.first, part.last + 1), part.stable, part.stability is Stability.STABLE_FOCUS)
        for branch in solution.branches
        for part in branch.family.segments
        if part.admissible
    ]
    return sorted(parts, key=lambda part: part.stable)


def events(solution: Solution) -> list[DrawnPoint]:
    """The critical points with the rows at which they stand."""
    places: dict[Point, list[tuple[Branch, int]]] = {point: [] for point in solution.critical_points}
    for branch in solution.branches:
        for row, point in branch.family.critical_points.items():
            places[point].append((branch, row))
    return [DrawnPoint(point, tuple(rows)) for point, rows in places.items() if rows]


def doubled(study: Study) -> list[Doubled]:
    """The motions that arise from 1:1 motions by period doublings, with their mirror images where there are any."""
    atlas, solution = study.atlas, study.solution
    if atlas is None:
        return []
    pieces, horizontal = [], atlas.sweep.level.horizontal
    for family in atlas.doubled(solution.device.period_ratio):
        # From an impact on the top on, it is the mirror image that is counted from the bottom.
        first = np.arange(0, len(family.word), 1 if horizontal else 2)
        sides = np.stack([first, (first + 1) % len(family.word)], axis=1)
        turned = (first % 2)[:, None]
        after = np.diff(family.time, axis=1, append=family.time[:, :1] + 2 * family.word.periods)
        of_pairs = (
            (1 - 2 * turned) * family.velocity[:, sides],
            (family.phase[:, sides] + np.pi * turned) % TURN,
            after[:, sides] / 2,
        )
        # A row for each pair of each motion: all first pairs, then all second ones, so that each is a curve.
        for part in family.segments:
            rows, size = slice(part.first, part.last + 1), part.last + 1 - part.first
            velocity, phase, flight = (x[rows].transpose(2, 1, 0).reshape(2, -1) for x in of_pairs)
            value, d = (np.tile(x[rows], len(first)) for x in (family.sweep_value, family.d))
            voltages = _paired_voltages(solution, value, velocity, np.tile(np.arange(size), len(first)))
            impacts = PairedImpacts(value, d, velocity, phase, flight, voltages)
            pieces.append(Doubled(impacts, len(first), part.stable))
    return sorted(pieces, key=lambda piece: piece.stable)


def impact_pairs(motions: Motions, period_ratio: int, cut: float = 0.0) -> ImpactPairs:
    """The quantities of motions that figure 2 shows, at the bottom and at the top.

    The magnitude of the impact velocity, the phase from `cut` on [rad], and half the flight time, which is the time in
    periods.
    """
    q, n = motions.q, period_ratio
    return (
        (np.abs(motions.velocity_bottom), np.abs(motions.velocity_top)),
        (cut + (motions.phi_bottom - cut) % TURN, cut + (motions.phi_top - cut) % TURN),
        (n * q, n * (1 - q)),
    )


def phase_cut(parts: Iterable[Stretch]) -> float:
    """Where to cut the circle of phases [rad], so that no curve of phases is torn: at 0, or as near to it as can be.

    Where the curves fill the circle it is cut at 0.
    """
    arcs = []
    for part in parts:
        motions = part.branch.motions
        for phi in (motions.phi_bottom, motions.phi_top):
            angles = np.unwrap(phi[part.rows])
            arcs.append((angles.min(), angles.max()))
    # The free place that is nearest to 0 is 0 itself, on either side of it, or next to an end of a curve.
    places = [-ROUNDING, ROUNDING, *(low - CUT_DISTANCE for low, _ in arcs), *(high + CUT_DISTANCE for _, high in arcs)]
    free = [at for at in places if all((at - low) % TURN > high - low for low, high in arcs)]
    return float(min(((at + np.pi) % TURN - np.pi for at in free), key=abs, default=-ROUNDING))


def voltage_curves(voltages: Voltages | None) -> list[Floats]:
    """The voltages that figure 7 shows: the average, and those at the bottom and at the top; () without voltages."""
    return [] if voltages is None else [voltages.average_v, voltages.bottom_v, voltages.top_v]


def phase_curve(phi: Floats) -> Floats:
    """A curve of phases without jumps, its middle where it is."""
    # A curve may end at the cut, where rounding decides on which side; its middle is away from it.
    angles, middle = np.unwrap(phi), len(phi) // 2
    return np.asarray(angles + (phi[middle] - angles[middle]))


def joined(parts: Sequence[DrawnCurve]) -> DrawnCurve:
    """Curves as one, with NaN between them."""
    x, y = (np.concatenate([np.append(part[k], np.nan) for part in parts]) for k in (0, 1))
    return x[:-1], y[:-1]


def simulated_points(study: Study) -> PairedImpacts | None:
    """The motions of drawn branches that the simulation of a sweep found, once at each value; None where there is none.

    These are the 1:1 motions, and what comes of their period doublings where that is known. Others would be points
    without a curve; the bifurcation diagram has all. An impact on the bottom shares a row with the impact on the top
    that follows it.
    """
    check, ratio = study.crosscheck, study.solution.device.period_ratio
    if study.solution.sweep is None:
        return None
    settled = settled_cycles(study)
    families = () if study.atlas is None else study.atlas.doubled(ratio)
    drawn = {("BT", ratio), *((family.word.letters, family.word.periods) for family in families)}
    settled = [end for end in settled if (end[2].word, end[2].period) in drawn]
    if check is None and not settled:
        return None
    rows: list[tuple[float, float, Floats]] = []
    motion: list[int] = []
    for k, (value, d, cycle) in enumerate(settled):
        impacts = list(_paired(cycle))
        motion += [k] * len(impacts)
        rows += [(value, d, impact) for impact in impacts]
    values, distances = np.array([row[:2] for row in rows]).reshape(-1, 2).T
    velocity, phase, flight = np.moveaxis(np.array([row[2] for row in rows]).reshape(-1, 2, 3), 0, -1).swapaxes(0, 1)
    voltages = _paired_voltages(study.solution, values, velocity, np.array(motion, dtype=np.intp))
    return PairedImpacts(values, distances, velocity, phase, flight, voltages)


def settled_cycles(study: Study) -> list[tuple[float, float, SimulatedMotion]]:
    """The motions that the simulation of a sweep came to, once at each value: the value, d and the cycle.

    Without random starts they are those that a ball from rest comes to.
    """
    check = study.crosscheck
    if check is None:
        return [(end.value, end.d, end.motion) for end in study.attractors_from_rest if end.motion is not None]
    return [
        (float(value), float(d), cycle)
        for value, d, attractors in zip(check.values, check.groups.d, check.ends, strict=True)
        for cycle in _distinct(attractors)
    ]


def _distinct(attractors: Sequence[Attractor]) -> list[SimulatedMotion]:
    """The cycles among some attractors, each once; those that stick are left to the bifurcation diagram."""
    # Starts that end on one motion share its cycle.
    cycles = {id(attractor.cycle): attractor.cycle for attractor in attractors if attractor.cycle is not None}
    return [cycle for cycle in cycles.values() if not cycle.sticks]


def _paired(cycle: SimulatedMotion) -> Iterator[Floats]:
    """Velocity, phase and half the flight time of a bottom impact of a cycle, and of the top one that follows it."""
    at_bottom = cycle.wall > 0
    impact = np.stack([cycle.velocity, cycle.phase, np.roll(cycle.flight, -1) / 2], axis=1)
    nothing = np.full(3, NO_PARTNER)
    for i, bottom in enumerate(at_bottom):
        after = (i + 1) % len(at_bottom)
        if bottom:
            yield np.stack([impact[i], nothing if at_bottom[after] else impact[after]])
        elif not at_bottom[i - 1]:
            yield np.stack([nothing, impact[i]])


def _paired_voltages(solution: Solution, values: Floats, velocity: Floats, motion: NDArray[np.intp]) -> Voltages | None:
    """Voltages of impacts in pairs; the average is over all impacts of a motion, as in Eq. (5.1)."""
    if solution.membrane is None:
        return None
    unit = np.asarray(solution.device.velocity_unit(solution.parameter, values))
    both = np.stack([generated_voltage(unit * side, solution.membrane) for side in velocity])
    # Not over the pairs: one without a partner has one impact, the others have two.
    impacts = np.bincount(motion, np.sum(~np.isnan(both), axis=0))
    average = (np.bincount(motion, np.nansum(both, axis=0)) / impacts)[motion]
    speeds = unit * np.nanmax(np.abs(velocity), axis=0, initial=0.0)
    return Voltages(both[0], both[1], average, deflection(speeds, solution.membrane))
