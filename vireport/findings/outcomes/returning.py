"""The ends of many starts: the motion that they were knocked out of, another one, rest, or none of these.

A start has returned once it is in the core of a stable motion, a neighbourhood that the map takes into itself. So the
ends of most starts are known after a few impacts, long before they have settled.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from math import ceil, log, pi

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.findings.outcomes.deviations import flight_matrices, growth, lap_matrix, stationary
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import wrapped
from vireport.simulation.attractors import Attractor, find_attractor
from vireport.simulation.cycles import releases, same_release
from vireport.simulation.events import COLUMNS, as_starts, check_model, follow_impacts, start_of
from vireport.simulation.kernel import CREEPING, FREE, HELD, PHASE, REST, RIDING, TURN, VELOCITY, WALL
from vireport.text.formatting import percent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

WIDEST = 0.25
"""Half width in time [t_c] and velocity [y_c] of the largest core that is tried."""

DIRECTIONS, SHELLS = 12, (1.0, 0.5)
"""Starts around an impact from which the map has to lead inwards, at so many shares of a core's size."""

SHRUNK = 25
"""Times that a core that the map leads out of is made half as wide."""

FIRST, MOST = 16, 512
"""Impacts followed before starts are looked at, at first and at most."""

PATIENCE, SLOWEST = 60.0, 500.0
"""Periods until a start counts as one that returns to no known motion: so many, and ten times the periods in which the
slowest known motion is approached by a factor e; and the most there may be."""

LINGERS, LONGEST = 1e-9, 8000
"""Distance from an unstable motion from which a start may have to part before it returns; impacts waited at most."""

NEAREST = 0.99
"""Modulus of the larger multiplier up to which a core is looked for: beyond it is tiny, and a minute is not enough."""

BUDGET = 20_000
"""Impacts until a motion counts as one that is not periodic."""

REPRESENTATIVES = 3
"""Of starts that end in no known motion: how many are followed for long, each time that there are some."""


class Elsewhere(IntEnum):
    """Ends of starts that come to no motion with a core, as numbers below zero; cores are numbered from 0."""

    UNKNOWN = -1
    RESTS = -2
    DRIFTS = -3


class Core(Struct, frozen=True, eq=False):
    """A neighbourhood of the impacts of a stable motion from which the map leads ever nearer to them.

    Attributes
    ----------
    motion : Motion
    forms : ndarray (N, 2, 2)
        For each impact, the quadratic form of deviations of time [t_c] and velocity [y_c] whose value falls from impact
        to impact.
    level : float
        Largest value of the form in the core.
    patience : int
        Impacts within which a start that returns is expected in the core.
    """

    motion: Motion
    forms: Floats
    level: float
    patience: int

    def holds(self, rows: Floats) -> NDArray[np.bool_]:
        """Which impacts, rows of the simulation (n, 6), are in the core."""
        inside = np.zeros(len(rows), dtype=bool)
        for i, wall in enumerate(self.motion.word.walls):
            values = _values(self.forms[i], _deviations(self.motion, i, rows))
            inside |= (rows[:, WALL] == wall) & (values <= self.level)
        return inside


def core_of(groups: Groups[float], motion: Motion, compiled: bool = False) -> Core:
    """Find the core of a stable motion: the largest one tried that the simulated map takes into itself.

    Raises
    ------
    ValueError
        Where the motion is not stable.
    NumericalError
        Where the motion is nearly unstable: its larger multiplier has a modulus above `NEAREST`.

    Notes
    -----
    With V_i = 1 + A_i' V_(i+1) A_i, repeated after a period, the value of V falls by the square of the deviation in
    each flight of the linearised map. The core is so small that it falls on the simulated map as well, from a ring of
    starts around each impact, after two periods: evidence, not proof.
    """
    matrices = flight_matrices(groups, motion)
    lap, gathered = np.eye(2), np.zeros((2, 2))
    # V at the first impact: first the sum of the squares of deviations within a period; `stationary` adds the periods
    # after it.
    for matrix in matrices:
        gathered += lap.T @ lap
        lap = matrix @ lap
    slowest = growth(lap)
    if slowest >= 1:
        raise ValueError("only a stable motion has a core")
    if slowest > NEAREST:
        raise NumericalError(
            f"the motion is so near a point where it becomes unstable that disturbances fade by only "
            f"{percent(1 - slowest)} in a period: what returns to it cannot be told in reasonable time "
            f"(allowed: {percent(1 - NEAREST)} or more)"
        )
    forms = [stationary(lap.T, gathered)]
    # The other forms follow backwards from the first impact of the next period.
    for matrix in matrices[:0:-1]:
        forms.insert(0, np.eye(2) + matrix.T @ forms[0] @ matrix)
    forms = [forms[-1], *forms[:-1]]
    # Along axis i the level line of a form x' V x reaches to the root of level times (V^-1)_ii.
    stretch = max(float(np.linalg.inv(form).diagonal().max()) for form in forms)
    level = WIDEST**2 / stretch
    for _ in range(SHRUNK):
        if _leads_inwards(groups, motion, forms, level, compiled):
            break
        level /= 4
    periods = min(PATIENCE - 10 / log(slowest) if slowest > 0 else PATIENCE, SLOWEST)
    return Core(motion, np.array(forms), level, ceil(periods) * len(matrices))


def patient(groups: Groups[float], cores: Sequence[Core], unstable: Sequence[Motion]) -> list[Core]:
    """The cores, with enough patience for a start that passes next to one of some unstable motions."""
    longest = max((_lingers(groups, motion) for motion in unstable), default=0)
    return [replace(core, patience=max(core.patience, longest)) for core in cores]


def _lingers(groups: Groups[float], motion: Motion) -> int:
    """Impacts until a start has left the neighbourhood of an unstable motion, from as near as `LINGERS`."""
    parting = growth(lap_matrix(groups, motion))
    periods = -log(LINGERS) / log(parting) if parting > 1 else LONGEST
    return min(ceil(periods) * len(motion.word), LONGEST)


def _leads_inwards(groups: Groups[float], motion: Motion, forms: list[Floats], level: float, compiled: bool) -> bool:
    angle = 2 * pi / DIRECTIONS * np.arange(DIRECTIONS)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    around = np.concatenate([share * circle for share in SHELLS])
    # Next to a period doubling a start may be farther out on the other side after one period; after two it is nearer.
    model, impacts = np.repeat(check_model(groups), len(around), axis=0), 2 * len(forms)
    walls = np.tile(motion.word.walls, 3)
    for i, form in enumerate(forms):
        # With V = L L' the solutions of L' x = y, y on a circle, are a level line of V.
        off = np.sqrt(level) * np.linalg.solve(np.linalg.cholesky(form).T, around.T).T
        before, phase = motion.velocity[i] + off[:, 1], np.mod(motion.phase[i] + pi * off[:, 0], TURN) % TURN
        # A velocity away from the membrane belongs to no impact: parts of so large a core have no map.
        if (walls[i] * before <= 0).any():
            return False
        starts = np.stack([np.full(len(off), float(walls[i])), np.zeros(len(off)), before, phase], axis=1)
        rows, _ = follow_impacts(model, starts, impacts, compiled=compiled)
        # A start that meets other membranes is beyond a grazing, where the map has another derivative: that its
        # neighbours on this side are contracted proves nothing for it.
        if (rows[:, :, WALL] != walls[i : i + impacts + 1]).any():
            return False
        if (_values(form, _deviations(motion, i, rows[:, -1])) >= _values(form, off)).any():
            return False
    return True


def _deviations(motion: Motion, impact: int, rows: Floats) -> Floats:
    """Deviations of time [t_c] and velocity [y_c] of rows of the simulation from an impact of a motion, (n, 2)."""
    late = wrapped(rows[:, PHASE] - motion.phase[impact]) / pi
    return np.stack([late, rows[:, VELOCITY] - motion.velocity[impact]], axis=1)


def _values(form: Floats, off: Floats) -> Floats:
    return np.asarray(np.einsum("ka,ab,kb->k", off, form, off))


def endings(groups: Groups[float], starts: Floats, cores: Sequence[Core], compiled: bool = True) -> Ints:
    """The motion that each start leads to, as the index of its core among `cores`, or a number of `Elsewhere`, (n,).

    Parameters
    ----------
    groups : Groups
        Of the device.
    starts : ndarray (n, 4)
        Rows of `check_start`.
    cores : sequence of Core
    compiled : bool
        Whether to compile the search, where numba is there.

    Notes
    -----
    A ball that has ridden on a membrane leaves it at a phase at which the pressing acceleration changes sign, without
    velocity: all that are released from one membrane at one phase share a future, which is followed once.
    """
    ends, rode = _followed(groups, starts, cores, compiled)
    riding = np.flatnonzero(rode[:, WALL])
    states = releases(rode[riding])
    while len(riding):
        alike = same_release(states, states[0])
        ends[riding[alike]] = _released(groups, rode[riding[0]], cores, compiled)
        riding, states = riding[~alike], states[~alike]
    return ends


def _followed(groups: Groups[float], starts: Floats, cores: Sequence[Core], compiled: bool) -> tuple[Ints, Floats]:
    """Where starts end, and (n, 6) the last impact of those that ride until a membrane releases them, 0 for others."""
    ends = np.full(len(starts), Elsewhere.UNKNOWN, dtype=np.int64)
    rode = np.zeros((len(starts), COLUMNS))
    active, states, model = np.arange(len(starts)), starts, check_model(groups)
    patience, block, used = max((core.patience for core in cores), default=MOST), FIRST, 0
    # Blocks grow: the ends of most starts are known after a few impacts, and more checks do not speed up the others.
    while len(active) and used < patience:
        rows, summary = follow_impacts(np.repeat(model, len(states), axis=0), states, block, compiled=compiled)
        # Only the last impact of a block is tested, as no start leaves a core again. Rows before a start are NaN, and a
        # ride for ever is rest, which the summary tells: neither is followed.
        last, riding = rows[:, -1], np.nan_to_num(rows[:, :, RIDING], posinf=0.0) > 0
        label = np.full(len(active), Elsewhere.UNKNOWN, dtype=np.int64)
        label[(summary[:, 2] == REST) | (summary[:, 2] == HELD)] = Elsewhere.RESTS
        label[summary[:, 2] == FREE] = Elsewhere.DRIFTS
        for k, core in enumerate(cores):
            label[core.holds(last)] = k
        rides = (label == Elsewhere.UNKNOWN) & riding.any(axis=1)
        at = np.argmax(riding[rides], axis=1)
        rode[active[rides]] = rows[rides, at]
        ends[active] = label
        stays = (label == Elsewhere.UNKNOWN) & ~rides & (summary[:, 2] != CREEPING)
        active, states = active[stays], as_starts(last[stays])
        used, block = used + block, min(2 * block, MOST)
    return ends, rode


def _released(groups: Groups[float], ride: Floats, cores: Sequence[Core], compiled: bool) -> int:
    """Where a ball that rides on a membrane after an impact ends; at rest if it is released twice in the same state."""
    rides = ride[None]
    while True:
        rows, _ = follow_impacts(check_model(groups), as_starts(rides[-1:]), 1, compiled=compiled)
        ends, rode = _followed(groups, as_starts(rows[:, -1]), cores, compiled)
        if not rode[0, WALL]:
            return int(ends[0])
        rides = np.concatenate([rides, rode])
        states = releases(rides)
        # A release in a state that was there before repeats all that came after it.
        if same_release(states[:-1], states[-1]).any():
            return Elsewhere.RESTS


class Recogniser:
    """Recognises the ends of starts, round by round: a motion that starts settle on is learnt for all later rounds.

    Core k belongs to the motion `outcomes[place[k]]`, in the order in which motions became known; `elsewhere` has the
    indices of the outcomes that are no motion with a core.
    """

    def __init__(self, groups: Groups[float], motions: Sequence[Motion]) -> None:
        self.groups = groups
        self.cores: list[Core] = []
        self.outcomes: list[Attractor] = []
        self.place: list[int] = []  # index of each core's motion among the outcomes
        self.elsewhere: dict[Elsewhere, int] = {}
        for motion in motions:
            self._learn(motion, self._attractor(self._on(motion)))

    def _on(self, motion: Motion) -> Floats:
        return np.array([motion.word.walls[0], 0.0, motion.velocity[0], motion.phase[0]])

    def _attractor(self, row: Floats) -> Attractor:
        return find_attractor(self.groups, start_of(row), BUDGET, compiled=True)

    def _learn(self, motion: Motion, attractor: Attractor) -> None:
        self.cores.append(core_of(self.groups, motion, compiled=True))
        self.place.append(len(self.outcomes))
        self.outcomes.append(attractor)

    def __call__(self, rows: Floats) -> Ints:
        """Index into `outcomes` for each start, a row of `check_start`, after learning motions that were not known."""
        outcome = self._outcomes(rows)
        for _ in range(REPRESENTATIVES):
            unknown = np.flatnonzero(outcome == Elsewhere.UNKNOWN)
            if not len(unknown):
                break
            attractor = self._attractor(rows[unknown[0]])
            cycle = attractor.cycle
            if cycle is None or cycle.sticks or cycle.growth > NEAREST:
                # All that does not settle, or not within the patience, is one outcome, whatever it is called.
                outcome[unknown[0]] = self._at(Elsewhere.UNKNOWN, rows[unknown[0]], attractor)
                continue
            known = [at for core, at in zip(self.cores, self.place, strict=True) if core.holds(cycle.impacts).all()]
            if known:  # it has returned, but later than the patience allows
                outcome[unknown[0]] = known[0]
                continue
            self._learn(cycle.motion(self.groups.d), attractor)
            outcome[unknown] = self._outcomes(rows[unknown])
        rest = outcome == Elsewhere.UNKNOWN
        if rest.any():
            outcome[rest] = self._at(Elsewhere.UNKNOWN, rows[rest][0])
        return outcome

    def _outcomes(self, rows: Floats) -> Ints:
        ends = endings(self.groups, rows, self.cores)
        # Ends below zero are kinds of `Elsewhere`, not indices; without a known motion there is no index at all.
        outcome = np.where(ends >= 0, np.array([*self.place, Elsewhere.UNKNOWN])[np.maximum(ends, 0)], ends)
        for kind in (Elsewhere.RESTS, Elsewhere.DRIFTS):
            of_kind = ends == kind
            if of_kind.any():
                outcome[of_kind] = self._at(kind, rows[of_kind][0])
        return outcome

    def _at(self, kind: Elsewhere, start: Floats, attractor: Attractor | None = None) -> int:
        """Index of an outcome that is no motion with a core; the first start that leads there is followed for it."""
        if kind not in self.elsewhere:
            self.elsewhere[kind] = len(self.outcomes)
            self.outcomes.append(self._attractor(start) if attractor is None else attractor)
        return self.elsewhere[kind]
