"""The simulation beside the analytic solution: whether it ends where the formulae say, and where else it ends.

The simulation knows nothing of the formulae; this module is the only place where both meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import BifurcationDiagram, Motions, Solution, find_motions, motions_of
from vireport.physics import Device
from vireport.scenario import Parameter, Simulation
from vireport.simulation import BOTTOM, Attractor, Diagram, Impact, attractors, diagram, find_attractor, portrait
from vireport.simulation import Portrait as Portrait

if TYPE_CHECKING:
    from vireport.progress import Progress

Floats = NDArray[np.float64]

ASIDE = 1e-6
"""Relative change of the velocity by which a simulation starts beside the orbit that it is to end on."""

SEED = 20190301
"""Of the starting states, which are the same in every run."""

NORMAL_95 = 1.959963984540054
"""Quantile of the normal distribution for a two-sided interval of 95 %."""

REACHED = 1e-6
"""Distance, in phase [rad] and velocity [y_c], up to which a simulated cycle is one of the analytic orbits."""


@dataclass(frozen=True, slots=True)
class Miss:
    """A stable admissible orbit on which the simulation did not end."""

    sweep_value: float
    found: str


@dataclass(frozen=True, slots=True, eq=False)
class CrossCheck:
    """What the simulation found along a sweep, or at a design point.

    Attributes
    ----------
    parameter : str
        The one that is varied (``length_m`` where nothing is swept).
    values, d, gbar : ndarray (n,)
        Where it was simulated.
    restitution : float
    found : tuple of tuples of Attractor
        For each value, what each start leads to.
    orbits : int
        Stable admissible orbits that were checked.
    velocity_difference, phase_difference : float
        Largest ones between an orbit and the cycle simulated beside it [y_c, rad].
    misses : tuple of Miss
        Orbits that the simulation left.
    tolerance : float
        Up to which both agree.
    trials, reached : int
        Starts where there is a stable admissible orbit, and those of them that lead to one.
    diagram : Diagram or None
        Its index refers to `values`.
    portraits, displacements : tuple of Portrait
        For figures 3 and 6.
    """

    parameter: Parameter
    values: Floats
    d: Floats
    gbar: Floats
    restitution: float
    found: tuple[tuple[Attractor, ...], ...]
    orbits: int
    velocity_difference: float
    phase_difference: float
    misses: tuple[Miss, ...]
    tolerance: float
    trials: int
    reached: int
    diagram: Diagram | None
    portraits: tuple[Portrait, ...]
    displacements: tuple[Portrait, ...]

    @property
    def passed(self) -> bool:
        """Whether every orbit was found again, within the tolerance."""
        return not self.misses and max(self.velocity_difference, self.phase_difference) <= self.tolerance

    @property
    def share(self) -> tuple[float, float, float] | None:
        """Share of the starts that reach a 1:1 orbit, with its 95 % interval; None where there is none to reach."""
        return wilson(self.reached, self.trials) if self.trials else None

    @property
    def words(self) -> dict[str, int]:
        """How many starts end in each motion, by its word or its kind, most frequent first."""
        names = [attractor.word or attractor.outcome.value for row in self.found for attractor in row]
        return dict(sorted(((name, names.count(name)) for name in set(names)), key=lambda item: (-item[1], item[0])))


def wilson(hits: int, trials: int) -> tuple[float, float, float]:
    """Share of hits, and the ends of its 95 % confidence interval, by Wilson's score."""
    share, z2 = hits / trials, NORMAL_95**2
    centre = (share + z2 / (2 * trials)) / (1 + z2 / trials)
    half = NORMAL_95 * sqrt(share * (1 - share) / trials + z2 / (4 * trials**2)) / (1 + z2 / trials)
    return share, max(centre - half, 0.0) if hits else 0.0, min(centre + half, 1.0) if hits < trials else 1.0


def crosscheck(solution: Solution, asked: Simulation, progress: Progress | None = None) -> CrossCheck:
    """Simulate along a sweep, or at a design point, and compare with the analytic motions.

    Parameters
    ----------
    solution : Solution
        Of the analytic side. Where nothing is swept, the motions of the design point are checked.
    asked : Simulation
        The scenario's block.
    progress : callable, optional
        Called with each step as it begins.
    """
    say = progress or (lambda what: None)
    device, parameter = solution.device, solution.parameter
    orbits: list[Motions | None]
    if solution.diagram is not None:
        values = np.linspace(solution.diagram.sweep.start, solution.diagram.sweep.end, asked.samples)
        orbits = orbits_at(solution.diagram, values)
    else:
        values = np.array([float(device.length_m)])
        orbits = [solution.design.motions if solution.design is not None else None]
    d, gbar = (np.asarray(x) * np.ones(len(values)) for x in device.groups(parameter, values))
    starts = starting_states(orbits, device.restitution, asked.starts)
    say(f"simulating {len(values) * len(starts)} starts")
    found = attractors(d, gbar, device.restitution, starts, asked.impacts)
    say("checking the stable motions")
    checked = [_check(motions, d[i], gbar[i], device) for i, motions in enumerate(orbits) if motions is not None]
    pairs = [pair for group, _ in checked for pair in group]
    trials, reached = _basin(orbits, found, device.period_ratio)
    portraits = [_portrait(device, parameter, value, starts) for value in asked.portraits]
    displacements = [_portrait(device, parameter, value, starts) for value in asked.displacement]
    drawn = diagram(d, gbar, device.restitution, starts, asked.impacts) if asked.diagram else None
    return CrossCheck(
        parameter=parameter,
        values=values,
        d=d,
        gbar=gbar,
        restitution=device.restitution,
        found=tuple(found),
        orbits=sum(len(agreeing) + len(missed) for agreeing, missed in checked),
        velocity_difference=max((pair[0] for pair in pairs), default=0.0),
        phase_difference=max((pair[1] for pair in pairs), default=0.0),
        misses=tuple(miss for _, misses in checked for miss in misses),
        tolerance=asked.tolerance,
        trials=trials,
        reached=reached,
        diagram=drawn,
        portraits=tuple(portraits),
        displacements=tuple(displacements),
    )


def _portrait(device: Device, parameter: Parameter, value: float, starts: Sequence[Impact]) -> Portrait:
    d, gbar = (float(x) for x in device.groups(parameter, value))
    label = f"{parameter.symbol} = {parameter.show(value)}"
    return portrait(d, gbar, float(device.restitution), starts, label)


def orbits_at(diagram: BifurcationDiagram, values: Floats) -> list[Motions | None]:
    """The analytic motions at values of the swept parameter, all at once."""
    sweep, level = diagram.sweep, diagram.curve.level
    d, gbar = (np.asarray(x) * np.ones(len(values)) for x in sweep.device.groups(sweep.parameter, values))
    everywhere = find_motions(d, gbar, sweep.device.restitution, sweep.device.period_ratio)
    found: list[Motions | None] = [None] * len(values)
    for i in np.unique(everywhere.cell):
        motions = motions_of(sweep, level, everywhere.orbit.select(everywhere.cell == i))
        motions.sweep_value[:], motions.d[:], motions.gbar[:] = values[i], d[i], gbar[i]
        found[i] = motions
    return found


def starting_states(orbits: Sequence[Motions | None], r: float, count: int) -> list[Impact]:
    """Impacts on the bottom at random velocities and phases, the same in every run.

    Velocities reach to half as much again as the fastest orbit has, or as the forcing alone gives.
    """
    rng = np.random.default_rng(SEED)
    fastest = max((float(m.velocity_bottom.max()) for m in orbits if m is not None), default=0.0)
    fastest = 1.5 * max(fastest, 2 / (np.pi * (1 - r)) if r < 0.9 else 2 / (np.pi * 0.1))
    return [Impact(BOTTOM, float(rng.uniform(0, fastest)), float(rng.uniform(0, 2 * np.pi))) for _ in range(count)]


def _check(motions: Motions, d: float, gbar: float, device: Device) -> tuple[list[tuple[float, float]], list[Miss]]:
    """Simulate from beside each stable orbit: differences of velocity and phase, and orbits not found again."""
    differences, misses = [], []
    for i in np.nonzero(motions.stable)[0]:
        start = Impact(BOTTOM, float(motions.velocity_bottom[i]) * (1 + ASIDE), float(motions.phi_bottom[i]))
        end = find_attractor(d, gbar, device.restitution, start)
        if not is_one_to_one(end, device.period_ratio):
            misses.append(Miss(float(motions.sweep_value[i]), end.word or end.outcome.value))
            continue
        velocity, phase = difference(end, motions, int(i))
        if max(velocity, phase) > REACHED:
            misses.append(Miss(float(motions.sweep_value[i]), f"another {end.word} motion"))
            continue
        differences.append((velocity, phase))
    return differences, misses


def is_one_to_one(attractor: Attractor, n: int) -> bool:
    """Whether an attractor is periodic with one impact on each membrane per n forcing periods."""
    return attractor.cycle is not None and attractor.word == "BT" and attractor.period == n


def difference(attractor: Attractor, motions: Motions, i: int) -> tuple[float, float]:
    """Largest differences of velocity and phase at the two impacts, between a simulated cycle and an analytic orbit."""
    cycle = attractor.cycle
    if cycle is None:
        return np.inf, np.inf
    bottom, top = int(np.argmax(cycle.wall == BOTTOM)), int(np.argmax(cycle.wall != BOTTOM))
    velocities = [cycle.velocity[bottom] - motions.velocity_bottom[i], cycle.velocity[top] - motions.velocity_top[i]]
    phases = [cycle.phase[bottom] - motions.phi_bottom[i], cycle.phase[top] - motions.phi_top[i]]
    around = [abs((p + np.pi) % (2 * np.pi) - np.pi) for p in phases]
    return float(max(map(abs, velocities))), float(max(around))


def _basin(orbits: Sequence[Motions | None], found: Sequence[tuple[Attractor, ...]], n: int) -> tuple[int, int]:
    """Starts at values with a stable admissible orbit, and how many of them end on a 1:1 motion."""
    rows = [row for motions, row in zip(orbits, found, strict=True) if motions is not None and motions.stable.any()]
    return sum(map(len, rows)), sum(is_one_to_one(attractor, n) for row in rows for attractor in row)
