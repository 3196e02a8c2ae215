"""Cross-check of the analytic solution by the simulation: whether it ends on the same motions, and where else.

The simulation does not use the formulae of the solution: that both agree is evidence.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.base.shares import share_interval
from vireport.design.solution import Solution
from vireport.motions.diagram import BifurcationDiagram
from vireport.motions.one_to_one import Motions, motions_of
from vireport.motions.pointwise import find_motions
from vireport.physics.device import Device
from vireport.physics.groups import Groups, map_restitution
from vireport.physics.numbers import wrapped
from vireport.scenario.blocks import Direction, SimulationBlock
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import Attractor, Diagram, Outcome, attractors, diagram, find_attractor, motion_name
from vireport.simulation.events import BOTTOM, Impact, start_of
from vireport.simulation.starts import random_starts, start_speed
from vireport.simulation.trajectories import Portrait as Portrait
from vireport.simulation.trajectories import portrait
from vireport.study.checks.hysteresis import Hysteresis, follow_sweep
from vireport.text.formatting import OF_A_MODEL

if TYPE_CHECKING:
    from vireport.base.progress import Progress

Floats = NDArray[np.float64]

ASIDE = 1e-6
"""Relative change of the velocity by which a simulation starts beside the orbit that it is to end on."""

SEED = 20190301
"""Seed of the starting states: each value of the swept parameter has its own, equal in every run."""

SAME_ORBIT = 1e-6
"""Distance, in phase [rad] and velocity [y_c], up to which a simulated cycle is one of the analytic orbits."""


class Miss(Struct, frozen=True):
    """A stable admissible motion on which the simulation did not end."""

    sweep_value: float
    outcome: str


class MotionCount(Struct, frozen=True):
    """A kind of motion, and how many simulated starts end in it.

    Attributes
    ----------
    outcome : Outcome
    word : str
        "" where it is not periodic.
    period : int
        In forcing periods; 0 where it is not periodic.
    count : int
        Number of starts that end in it.
    low, high : float
        Least and largest value of the swept parameter at which a start does.
    """

    outcome: Outcome
    word: str
    period: int
    count: int
    low: float
    high: float

    @property
    def name(self) -> str:
        """Name of the motion: its word and period, or its outcome where it has no word."""
        return motion_name(self.outcome, self.word, self.period)

    @property
    def stays(self) -> bool:
        """Whether the ball rests on a membrane for a part of the motion, or for ever."""
        return self.outcome in (Outcome.STICKING, Outcome.REST, Outcome.HELD)


class CrossCheck(Struct, frozen=True, eq=False):
    """What the simulation found along a sweep, or at a design point.

    Attributes
    ----------
    parameter : str
        The parameter that is varied (``length_m`` where nothing is swept).
    values, d, gbar : ndarray (n,)
        Values of the parameter, and of the groups, at which it was simulated.
    restitution : float
    start_speed : ndarray (n,)
        Largest velocity of the random starts at each value [y_c].
    ends : tuple of tuples of Attractor
        For each value, what each start leads to.
    orbits : int
        Number of stable admissible motions that were checked.
    velocity_difference, phase_difference : float
        Largest differences between such a motion and the one simulated from next to it [y_c, rad].
    misses : tuple of Miss
        Stable motions that the simulation left.
    tolerance : float
        Difference up to which both agree.
    trials, arrivals : int
        Starts at values with a stable admissible motion, and how many of them lead to a 1:1 motion.
    motions : tuple of MotionCount
        What all starts lead to, most frequent first.
    elsewhere : tuple of MotionCount
        What the trials lead to that do not come to a 1:1 motion.
    diagram : Diagram or None
        Its index refers to `values`.
    hysteresis : Hysteresis or None
        The motions of a slow sweep, in which each value goes on from the last state.
    portraits, displacements : tuple of Portrait
        For figures 3 and 6.
    """

    parameter: Parameter
    values: Floats
    groups: Groups[Floats]
    start_speed: Floats
    ends: tuple[tuple[Attractor, ...], ...]
    orbits: int
    velocity_difference: float
    phase_difference: float
    misses: tuple[Miss, ...]
    tolerance: float
    trials: int
    arrivals: int
    motions: tuple[MotionCount, ...]
    elsewhere: tuple[MotionCount, ...]
    diagram: Diagram | None
    hysteresis: Hysteresis | None
    portraits: tuple[Portrait, ...]
    displacements: tuple[Portrait, ...]

    __repr__ = brief

    @property
    def passed(self) -> bool:
        """Whether every stable admissible motion was found again, within the tolerance."""
        return not self.misses and max(self.velocity_difference, self.phase_difference) <= self.tolerance

    @property
    def step(self) -> float:
        """Distance of neighbouring values, in the unit of the swept parameter."""
        return float(np.ptp(self.values)) / max(len(self.values) - 1, 1)

    def attractors(self) -> Iterator[tuple[float, Attractor]]:
        """Values of the parameter with the attractors there, from random starts and from the slow sweep."""
        for value, ends in zip(self.values, self.ends, strict=True):
            yield from ((float(value), end) for end in ends)
        for course in self.hysteresis.courses.values() if self.hysteresis is not None else ():
            yield from ((stage.value, stage.attractor) for stage in course.stages)

    @property
    def share(self) -> tuple[float, float, float] | None:
        """Share of the starts that reach a 1:1 motion, with its 95 % interval; None where there is none to reach.

        The share is the mean over the values that have a stable motion. The starts are independent, so that the
        number that reach it varies no more than a binomial one, and the interval holds the mean at least as often.
        """
        return share_interval(self.arrivals, self.trials) if self.trials else None


def crosscheck(
    solution: Solution, block: SimulationBlock, progress: Progress | None = None, seed: int = SEED
) -> CrossCheck:
    """Simulate along a sweep, or at a design point, and compare with the analytic motions.

    Parameters
    ----------
    solution : Solution
        The analytic solution. Where nothing is swept, the motions of the design point are checked.
    block : SimulationBlock
        The block `simulation` of the scenario.
    progress : callable, optional
        Called with each step as it begins.
    seed : int
        Of the random starts.
    """
    say = progress or (lambda what: None)
    device, parameter = solution.device, solution.parameter
    values, orbits = _simulated_values(solution, block.samples)
    groups = _of_each(device.groups(parameter, values), len(values))
    speed = start_speed(groups.restitution, [_fastest(motions) for motions in orbits])
    starts = random_starts(groups.d, speed, block.starts, seed)
    say(f"simulating {len(values) * block.starts} starts")
    ends = attractors(groups, starts, block.impacts)
    say("checking the stable motions")
    checked = [
        _check(motions, _row(groups, i), device.period_ratio) for i, motions in enumerate(orbits) if motions is not None
    ]
    pairs = [pair for group, _ in checked for pair in group]
    n = device.period_ratio
    stable = [i for i, motions in enumerate(orbits) if motions is not None and motions.stable_mask.any()]
    at_stable = [(values[i], end) for i in stable for end in ends[i]]
    elsewhere = [(value, end) for value, end in at_stable if not is_one_to_one(end, n)]
    portraits = [_portrait(device, parameter, value, block.starts, seed) for value in block.portraits]
    displacements = [_portrait(device, parameter, value, block.starts, seed) for value in block.displacement]
    slowly = None
    if block.follow is not Direction.NONE and solution.sweep is not None:
        say("following the motion from value to value")
        slowly = follow_sweep(solution.sweep, values.tolist(), block)
    return CrossCheck(
        parameter=parameter,
        values=values,
        groups=groups,
        start_speed=speed,
        ends=tuple(ends),
        orbits=sum(len(agreeing) + len(missed) for agreeing, missed in checked),
        velocity_difference=max((pair[0] for pair in pairs), default=0.0),
        phase_difference=max((pair[1] for pair in pairs), default=0.0),
        misses=tuple(miss for _, misses in checked for miss in misses),
        tolerance=block.tolerance,
        trials=len(at_stable),
        arrivals=len(at_stable) - len(elsewhere),
        motions=_counted([(value, end) for value, row in zip(values, ends, strict=True) for end in row]),
        elsewhere=_counted(elsewhere),
        diagram=diagram(ends) if block.diagram else None,
        hysteresis=slowly,
        portraits=tuple(portraits),
        displacements=tuple(displacements),
    )


def _of_each(groups: Groups[Any], count: int) -> Groups[Any]:
    """Groups with arrays of `count` elements, one for each value of the parameter."""
    return groups.map_numbers(lambda group: np.asarray(group) * np.ones(count))


def _row(groups: Groups[Floats], index: int) -> Groups[float]:
    """The groups at the value with an index."""
    return groups.map_numbers(lambda group: float(group[index]))


def _simulated_values(solution: Solution, samples: int) -> tuple[Floats, list[Motions | None]]:
    """Values of the parameter at which to simulate, evenly over a sweep, and the analytic motions there."""
    if solution.diagram is not None:
        values = np.linspace(solution.diagram.sweep.start, solution.diagram.sweep.end, samples)
        return values, orbits_at(solution.diagram, values)
    return np.array([float(solution.device.length_m)]), [solution.design.motions if solution.design else None]


def _portrait(device: Device, parameter: Parameter, value: float, count: int, seed: int) -> Portrait:
    groups = device.groups(parameter, value).as_floats()
    starts = [start_of(row) for row in random_starts(groups.d, start_speed(groups.restitution), count, seed)[0]]
    return portrait(groups, starts, parameter.place(value, OF_A_MODEL))


def _fastest(motions: Motions | None) -> float:
    """Velocity of the fastest impact of admissible motions [y_c], 0 where there is none."""
    if motions is None:
        return 0.0
    # Starts reach as fast as the fastest motion, stable or not, or its basin might not be sampled.
    speeds = np.maximum(motions.velocity_bottom, -motions.velocity_top)[motions.admissible_mask]
    return float(speeds.max(initial=0.0))


def _counted(ends: Iterable[tuple[float, Attractor]]) -> tuple[MotionCount, ...]:
    """Count the motions that starts end in, most frequent first."""
    values: dict[tuple[Outcome, str, int], list[float]] = {}
    for value, end in ends:
        values.setdefault((end.outcome, end.word, end.period), []).append(float(value))
    counts = (MotionCount(*kind, len(at), min(at), max(at)) for kind, at in values.items())
    return tuple(sorted(counts, key=lambda motion: (-motion.count, motion.name)))


def orbits_at(diagram: BifurcationDiagram, values: Floats) -> list[Motions | None]:
    """The analytic motions at values of the swept parameter, all at once."""
    sweep = diagram.sweep
    groups = _of_each(sweep.device.groups(sweep.parameter, values), len(values))
    # One restitution for all values: motions are then found five times as fast.
    device = sweep.device
    bounces = sweep.parameter.bounces
    restitution = groups.restitution if bounces else device.restitution
    shared = groups._replace(restitution=restitution, harmonics=device.harmonics)
    everywhere = find_motions(shared, device.period_ratio)
    at_values: list[Motions | None] = [None] * len(values)
    for i in np.unique(everywhere.cell):
        orbit = everywhere.orbit.select(everywhere.cell == i)
        if bounces:
            orbit = replace(
                orbit, restitution=map_restitution(groups.restitution, itemgetter(np.full(len(orbit.u), i)))
            )
        motions = motions_of(sweep, orbit)
        motions.sweep_value[:], motions.d[:], motions.gbar[:] = values[i], groups.d[i], groups.gbar[i]
        at_values[i] = motions
    return at_values


def _check(motions: Motions, groups: Groups[float], n: int) -> tuple[list[tuple[float, float]], list[Miss]]:
    """Simulate from next to each stable motion: differences of velocity [y_c] and phase [rad], and missed motions."""
    differences, misses = [], []
    for i in np.nonzero(motions.stable_mask)[0]:
        # From beside the motion: started on it, an unstable one would be confirmed as well, as long as rounding keeps
        # the ball there.
        start = Impact(BOTTOM, float(motions.velocity_bottom[i]) * (1 + ASIDE), float(motions.phi_bottom[i]))
        end = find_attractor(groups, start)
        if not is_one_to_one(end, n):
            misses.append(Miss(float(motions.sweep_value[i]), end.word or end.outcome.value))
            continue
        velocity, phase = difference(end, motions, int(i))
        # There may be several stable 1:1 motions: ending on another one is no agreement.
        if max(velocity, phase) > SAME_ORBIT:
            misses.append(Miss(float(motions.sweep_value[i]), f"another {end.word} motion"))
            continue
        differences.append((velocity, phase))
    return differences, misses


def is_one_to_one(attractor: Attractor, n: int) -> bool:
    """Whether an attractor is periodic with one impact on each membrane per n forcing periods."""
    return attractor.cycle is not None and attractor.word == "BT" and attractor.period == n


def difference(attractor: Attractor, motions: Motions, i: int) -> tuple[float, float]:
    """Largest differences of velocity [y_c] and phase [rad] at the two impacts of simulated and analytic motion."""
    cycle = attractor.cycle
    if cycle is None:
        return np.inf, np.inf
    bottom, top = int(np.argmax(cycle.wall == BOTTOM)), int(np.argmax(cycle.wall != BOTTOM))
    velocities = [cycle.velocity[bottom] - motions.velocity_bottom[i], cycle.velocity[top] - motions.velocity_top[i]]
    phases = [cycle.phase[bottom] - motions.phi_bottom[i], cycle.phase[top] - motions.phi_top[i]]
    return float(max(map(abs, velocities))), float(max(abs(wrapped(phase)) for phase in phases))
