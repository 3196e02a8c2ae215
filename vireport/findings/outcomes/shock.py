"""The least shock that knocks the ball out of a stable motion: the smallest jump of the velocity that does not die out.

Found by a search over the moment of the shock and its size. Bisection would not do, as many jumps larger than the least
one may return as well. Where the edge is the stable manifold of an unstable companion, as it mostly is, a second method
gives it to the last digit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import inf, pi
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.findings.outcomes.deviations import lap_matrix
from vireport.findings.outcomes.returning import LONGEST, Core, Elsewhere, core_of, endings, patient
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import ARRAYS, wrapped
from vireport.simulation.attractors import Attractor, find_attractor
from vireport.simulation.events import check_model, follow_impacts, start_of
from vireport.simulation.kernel import PHASE, TURN, VELOCITY, WALL
from vireport.text.formatting import rounded_text

Floats = NDArray[np.float64]

SEED = 1
"""Of the jumps that are tried at random, in every run the same."""

NEAR = 0.1
"""Distance in time [t_c] and velocity [y_c] within which a companion is passed on the edge of the basin."""

PASSAGE = 60
"""Impacts within which it is."""

SECANTS, PASSAGES = 12, 8
"""Steps of the search for a zero at one passage, and passages until the edge no longer moves."""

SETTLED = 4e-16
"""Change of a jump that is rounding [y_c]."""

WITHIN = 1e-3
"""Distance of the two ways, as a share of the jump, up to which they may have found one edge."""

JUST_BEYOND = 1e-13, 1e-9
"""How far beyond a manifold jumps are tried that must lead out if it is the edge, as a share of the jump."""

ROUNDS = 12
"""Of looking for smaller jumps below one that leads out."""

WIDER = 4.0
"""By how much the steps towards the least jump grow again where all of a step lead out."""

LONGER = 6
"""How many times as long is waited where a jump that seemed to lead out comes back later."""

BUDGET = 20_000
"""Impacts until a shock counts as one that leads to no periodic motion."""


class Effort(NamedTuple):
    """The effort of a search for the least shock: how many shocks it tries.

    Attributes
    ----------
    after : int
        Sizes just after an impact, for either sign, in each of `octaves` ranges of size.
    moments, levels : int
        Later moments within each flight, and sizes at each of these.
    octaves : int
        Ranges of size, each twice as wide as the one before but for the first two.
    zoom : int
        Sizes tried around one that leads out, in each step towards the least one.
    below : int
        Smaller ones, at random moments, of which none may lead out.
    width : float
        Width at which the zoom ends, as a share of the size.
    """

    after: int
    moments: int
    levels: int
    octaves: int
    zoom: int
    below: int
    width: float


SEARCH = Effort(100, 12, 25, 4, 128, 10_000, 1e-13)
"""What compiled code does in a tenth of a second."""

SCAN = Effort(24, 6, 12, 4, 64, 2000, 1e-9)
"""What compiled code does in some hundredths of a second, for each of many devices. Where bands are folded, half as
many tries miss the least one of every third device, by up to a seventh."""


class LeastShock(Struct, frozen=True, eq=False):
    """The smallest jump of the relative velocity that leads out of the basin of a motion (dimensionless).

    Attributes
    ----------
    motion : Motion
    jump : float or None
        Size [y_c]: smaller jumps return, and just above it some do not. None where none that leads out was found.
    sign : int
        1 towards the bottom membrane, -1 towards the top one.
    impact : int
        Index of the motion's impact after which the jump comes.
    delay : float
        Time since that impact [t_c].
    companion : Motion or None
        The unstable motion onto whose stable manifold the jump leads; None where no known one is such.
    by_search : float or None
        Size of the jump by the search alone [y_c].
    leads_to : Attractor or None
        What the device does after a jump just above it.
    searched_to : float
        Size up to which jumps were tried [y_c].
    tried : int
        Number of jumps that were tried.
    patience : int
        Impacts after which a jump that has not returned counts as one that leads out.
    """

    motion: Motion
    jump: float | None
    sign: int
    impact: int
    delay: float
    companion: Motion | None
    by_search: float | None
    leads_to: Attractor | None
    searched_to: float
    tried: int
    patience: int


class Shock(NamedTuple):
    """A jump of a signed size a time after an impact of a motion."""

    impact: int
    delay: float
    jump: float


class MotionsByStability(NamedTuple):
    """The coexisting motions of a device: stable ones, to which shocks lead, and unstable ones between their basins.

    Attributes
    ----------
    stable : sequence of Motion
        Each is recognised where a shock leads to it.
    unstable : sequence of Motion
        Companions: the edge of a basin may be the stable manifold of one of them.
    """

    stable: Sequence[Motion] = ()
    unstable: Sequence[Motion] = ()


ALONE = MotionsByStability()
"""The neighbours of a motion of whose device no other is known."""


def shocked(groups: Groups[float], motion: Motion, impact: int, delay: Floats, jump: Floats) -> Floats:
    """The states that shocks make of a motion, as rows of `check_start`, (n, 4).

    Parameters
    ----------
    groups : Groups
        Of the device.
    motion : Motion
        With friction, one in which the ball moves from membrane to membrane without turning back.
    impact : int
        Index of the motion's impact after which the shocks come.
    delay : ndarray (n,)
        Time since that impact [t_c], below the flight time. At 0 the ball still touches the membrane: a jump that
        drives it back is an impact at once.
    jump : ndarray (n,)
        Added to the relative velocity [y_c].
    """
    wall, start = motion.word.walls[impact], float(motion.time[impact])
    after = float(groups.after(wall, motion.velocity[impact]))
    phase = pi * (start + delay)
    covered, speed = groups.flown(delay, after, groups.wave(pi * start, ARRAYS), groups.wave(phase, ARRAYS), -wall)
    rows = np.zeros((len(delay), 4))
    rows[:, 1] = wall * groups.d / 2 + covered
    rows[:, 2] = speed + jump
    # The first remainder of a phase just below 0 is rounded up to a whole turn, which is refused for a start.
    rows[:, 3] = np.mod(phase, TURN) % TURN
    touching = delay == 0
    leaving = touching & (wall * rows[:, 2] < 0)
    rows[touching, 0], rows[touching, 1] = wall, 0.0
    # A start on a membrane is given by the velocity just before the impact.
    rows[leaving, 2] /= -groups.restitution_at(wall)
    return rows


def least_shock(
    groups: Groups[float],
    motion: Motion,
    neighbours: MotionsByStability = ALONE,
    searched_to: float | None = None,
    effort: Effort = SEARCH,
) -> LeastShock:
    """Find the least shock that leads out of the basin of a stable motion, at any moment of its period.

    It needs the compiled simulation: interpreted, it would take minutes.

    Parameters
    ----------
    groups : Groups
        Of the device.
    motion : Motion
        Stable.
    neighbours : MotionsByStability
        Other motions; the stable ones may include this one.
    searched_to : float, optional
        Largest size to be tried [y_c]; by default the largest impact velocity of the motion.
    effort : Effort

    Returns
    -------
    LeastShock
        Without a jump where none that was tried leads out.

    Raises
    ------
    ValueError
        Where the motion is not stable, the restitution is zero, or `searched_to` not positive.
    NumericalError
        Where the motion is so near a critical point that starts take too long to return, see `core_of`.

    Notes
    -----
    Sizes are tried in ascending ranges, most of them just after the impacts: the distance that a jump opens grows with
    time, so that a later jump has to be larger, unless the edge of the basin is folded. From the least jump that leads
    out the search descends, each step with as many sizes below it, as the jumps that lead out lie in bands that may
    accumulate at the least one. Then smaller jumps are tried at random, and the search begins anew below any that leads
    out.

    A shock on the edge leads to an unstable motion x*. With the left eigenvector l of its Jacobian that belongs to the
    multiplier outside the unit circle, l.(P^m(x) - x*) = 0 is solved for the size by secants, m being the nearest
    passage; the error is of second order in its distance, and the passage is taken nearer until the size stays.
    """
    farthest = float(np.abs(motion.velocity).max()) if searched_to is None else searched_to
    if not 0 < farthest < inf:
        raise ValueError(f"jumps can be tried up to a positive, finite size, not {farthest}")
    if any(groups.restitution_at(wall) == 0 for wall in motion.word.walls):
        raise ValueError("a ball that does not bounce leaves a membrane with no velocity: shocks need a restitution")
    stable = motion, *(other for other in neighbours.stable if other is not motion)
    cores = patient(groups, [core_of(groups, attracts, compiled=True) for attracts in stable], neighbours.unstable)
    search = _Search(groups, cores, effort)
    while True:
        leads_out, spacing = search.coarse(farthest)
        by_search, companion, exact = leads_out, None, None
        # Descents and random tries take turns: a smaller shock that was found at random may be of another band, with a
        # least one of its own.
        for _ in range(ROUNDS):
            if leads_out is None:
                break
            duration = float(search.durations[leads_out.impact])
            by_search = descended(search.leads_out, leads_out, spacing, duration, effort)
            by_search, exact, companion = search.on_manifold(by_search, neighbours.unstable)
            leads_out, spacing = search.below(exact or by_search)
        patience = search.cores[0].patience
        if by_search is None:
            return LeastShock(motion, None, 0, 0, 0.0, None, None, None, farthest, search.tried, patience)
        leads_to = search.attractor(by_search)
        if not search.returns(leads_to):
            break
        if patience >= LONGEST:
            raise NumericalError(
                f"a jump of {rounded_text(abs(by_search.jump))} velocity units takes more than {patience} impacts "
                "to return, and so may others: what returns cannot be told in reasonable time"
            )
        # The ball came back after all, from a chaotic transient longer than the patience.
        search.cores = [replace(core, patience=min(LONGER * core.patience, LONGEST)) for core in search.cores]
    least = exact or by_search
    return LeastShock(
        motion,
        abs(least.jump),
        1 if least.jump > 0 else -1,
        least.impact,
        least.delay,
        companion,
        abs(by_search.jump),
        leads_to,
        farthest,
        search.tried,
        patience,
    )


class Descent(NamedTuple):
    """Where a search for the least shock stands, of one sign and after one impact.

    Invariant: the shock of this `size` after this `delay` leads out, and no smaller one that was tried does.

    Attributes
    ----------
    size, delay : float
        Of the shock [y_c], [t_c].
    depth : float
        How far below the size the next step looks [y_c]; 0 where nothing is left to look through.
    wander : float
        How far to either side of the delay the next step looks [t_c].
    """

    size: float
    delay: float
    depth: float
    wander: float


LeadOut = Callable[[int, Floats, Floats], NDArray[np.bool_]]
"""Tells of shocks after an impact, by delays and signed jumps, which lead out."""


def descended(leads_out: LeadOut, shock: Shock, spacing: float, duration: float, effort: Effort) -> Shock:
    """The least shock near one that leads out, of the same sign and after the same impact.

    Parameters
    ----------
    leads_out : callable
    shock : Shock
        One that leads out.
    spacing : float
        Distance to the next smaller size that was tried [y_c].
    duration : float
        Flight time after the impact [t_c].
    effort : Effort
    """
    size = abs(shock.jump)
    at = Descent(size, shock.delay, min(spacing, size), duration / (effort.moments + 1))
    while at.depth > max(effort.width * at.size, SETTLED):
        at = _lower(leads_out, shock, at, duration, effort.zoom)
    return Shock(shock.impact, at.delay, float(np.sign(shock.jump)) * at.size)


def _lower(leads_out: LeadOut, shock: Shock, at: Descent, duration: float, count: int) -> Descent:
    """One step of the descent, by `count` sizes, the largest of which is that of the shock itself."""
    bottom = max(at.size - at.depth, 0.0)
    sizes = bottom + (at.size - bottom) * np.arange(1, count + 1) / count
    # Just after an impact the edge is lowest unless it is folded; from a later moment it is sought both ways.
    delays = at.delay + (at.wander * np.linspace(-1, 1, 5) if at.delay > 0 else np.zeros(1))
    delays = np.clip(delays, 0.0, duration * (1 - 1e-9))
    tried, moments = (grid.ravel() for grid in np.meshgrid(sizes, delays, indexing="ij"))
    out = np.flatnonzero(leads_out(shock.impact, moments, float(np.sign(shock.jump)) * tried))
    size, delay, at_bottom = at.size, at.delay, False
    if len(out):
        # Sizes ascend along the rows of the grid: the first shock that leads out has the smallest size.
        least = int(out[0]) // len(delays)
        rows = out[out // len(delays) == least]
        delay = float(moments[rows[np.argmin(np.abs(moments[rows] - delay))]])
        size, at_bottom = float(sizes[least]), least < count // 8
    # Below the least there may be narrow bands between the samples: the next step looks there too. Where all lead out,
    # the edge is farther down than expected: steps as small as these would take for ever.
    depth = WIDER * at.depth if at_bottom else at.depth / 8 + (size - bottom) / count
    ended = not at_bottom and depth <= (size - bottom) / count * 2
    # At a minimum within a flight the size grows with the square of the distance in time: half as far away in time is
    # as good as a fourth in size.
    return Descent(size, delay, 0.0 if ended else depth, at.wander / 2)


class _Search:
    """The search for one motion, whose core is the first."""

    def __init__(self, groups: Groups[float], cores: list[Core], effort: Effort) -> None:
        self.groups, self.cores, self.effort, self.tried = groups, cores, effort, 0
        self.motion = cores[0].motion
        self.durations = self.motion.durations

    def leads_out(self, impact: int, delay: Floats, jump: Floats) -> NDArray[np.bool_]:
        """Which shocks to the motion lead out of its basin.

        In a horizontal device one jump leaves the ball without drift, floating for ever; its neighbours return.
        """
        self.tried += len(delay)
        starts = shocked(self.groups, self.motion, impact, delay, jump)
        ends = endings(self.groups, starts, self.cores)
        return np.asarray((ends != 0) & (ends != Elsewhere.DRIFTS))

    def coarse(self, farthest: float) -> tuple[Shock | None, float]:
        """The smallest shock of a coarse grid that leads out, and the spacing of the grid [y_c]."""
        effort, edges = self.effort, [0.0, *(farthest / 2**k for k in range(self.effort.octaves - 1, -1, -1))]
        # A range is looked through after every impact before the next one: shocks of larger ranges cannot be the least.
        for low, high in pairwise(edges):
            leading_out: list[Shock] = []
            for impact, duration in enumerate(self.durations.tolist()):
                later = duration * np.arange(1, effort.moments + 1) / (effort.moments + 1)
                for delays, count in ((np.zeros(1), effort.after), (later, effort.levels)):
                    sizes = low + (high - low) * np.arange(1, count + 1) / count
                    for sign in (1.0, -1.0):
                        delay, jump = (grid.ravel() for grid in np.meshgrid(delays, sign * sizes))
                        out = np.flatnonzero(self.leads_out(impact, delay, jump))
                        leading_out += [Shock(impact, float(delay[k]), float(jump[k])) for k in out[:1]]
            if leading_out:
                # The wider of both spacings: of later moments fewer sizes are tried, and those between may lead out.
                spacing = (high - low) / min(effort.after, effort.levels)
                return min(leading_out, key=lambda shock: abs(shock.jump)), spacing
        return None, 0.0

    def on_manifold(self, near: Shock, companions: Sequence[Motion]) -> tuple[Shock, Shock | None, Motion | None]:
        """A shock at the edge by the stable manifold of a companion, if that is where the edge is.

        Returns the least shock that leads out by the search, which may be nearer to the manifold than `near`, as where
        this is the edge, shocks lead out just beyond it at all scales; the shock on the manifold; and the companion.
        """
        for companion in companions:
            jump = self._secant(near, companion)
            if jump is None or abs(jump - near.jump) > WITHIN * abs(near.jump):
                continue
            # That a shock leads to the companion does not make it the edge: jumps just beyond have to lead out.
            beyond = abs(jump) * (1 + np.geomspace(JUST_BEYOND[0], JUST_BEYOND[1], self.effort.zoom))
            delays, sign = np.full(len(beyond), near.delay), float(np.sign(jump))
            out = np.flatnonzero(self.leads_out(near.impact, delays, sign * beyond))
            if len(out):
                sizes = [float(beyond[out[0]])]
                # Nearer than that to the manifold rounding decides whether a shock leads out.
                if abs(abs(near.jump) - abs(jump)) > JUST_BEYOND[0] * abs(jump):
                    sizes.append(abs(near.jump))
                nearest = min(sizes, key=lambda size: abs(size - abs(jump)))
                return near._replace(jump=sign * nearest), near._replace(jump=jump), companion
        return near, None, None

    def _secant(self, near: Shock, companion: Motion) -> float | None:
        """Signed size of the shock that leads to a companion, by its left eigenvector; None if it passes none."""
        # With complex multipliers, or with none outside the unit circle, the stable manifold is no line, and bounds
        # nothing.
        growth, vectors = np.linalg.eig(lap_matrix(self.groups, companion).T)
        outside = int(np.argmax(np.abs(growth)))
        if not (np.isreal(growth).all() and abs(growth[outside]) > 1):
            return None
        across, model = vectors[:, outside].real, check_model(self.groups)

        def deviations(jump: float, impacts: int) -> Floats:
            start = shocked(self.groups, self.motion, near.impact, np.array([near.delay]), np.array([jump]))
            rows, _ = follow_impacts(model, start, impacts)
            off = np.stack([wrapped(rows[0, :, PHASE] - companion.phase[0]) / pi, rows[0, :, VELOCITY]], axis=1)
            off[:, 1] -= companion.velocity[0]
            # The first row is the start, which is no impact; an impact on the other membrane is no passage.
            off[(rows[0, :, WALL] != companion.word.walls[0]) | (np.arange(len(off)) == 0)] = inf
            return off

        def deviation(jump: float, passage: int) -> float:
            away = deviations(jump, passage)[-1]
            return float(away @ across) if np.isfinite(away).all() else inf

        jump, before = near.jump, inf
        for _ in range(PASSAGES):
            distance = np.abs(deviations(jump, PASSAGE)).max(axis=1)
            passage = int(np.nanargmin(distance))
            if distance[passage] > NEAR:
                return None
            # The two sizes are so close as deviations grow by the multipliers of all periods up to the passage.
            first, second = jump, jump * (1 + 1e-10)
            before_value, value = deviation(first, passage), deviation(second, passage)
            for _ in range(SECANTS):
                if value == before_value or not np.isfinite(value + before_value):
                    break
                first, second, before_value = second, second - value * (second - first) / (value - before_value), value
                value = deviation(second, passage)
                if abs(second - first) <= SETTLED:
                    break
            if not np.isfinite(second):
                return None
            jump = second
            if abs(jump - before) <= 10 * SETTLED:
                break
            before = jump
        return jump

    def below(self, least: Shock) -> tuple[Shock | None, float]:
        """A smaller shock that leads out, and the spacing of the tries: half at the same moment, half at any moment."""
        # Excludes the least shock itself and what rounding makes of it.
        count, size = self.effort.below, abs(least.jump) * (1 - 1e-12)
        random, leading_out = np.random.default_rng(SEED), []
        sizes = size * (np.arange(count // 2) + random.random(count // 2)) / (count // 2)
        delays = np.full(len(sizes), least.delay)
        for k in np.flatnonzero(self.leads_out(least.impact, delays, np.sign(least.jump) * sizes))[:1]:
            leading_out.append(least._replace(jump=float(np.sign(least.jump) * sizes[k])))
        share = count // 2 // len(self.durations)
        for impact, duration in enumerate(self.durations.tolist()):
            delays = np.where(random.random(share) < 0.5, 0.0, duration * random.random(share))
            # By the root most sizes are just below the least one, where bands accumulate.
            jumps = size * np.sqrt(random.random(share)) * random.choice([-1.0, 1.0], share)
            out = self.leads_out(impact, delays, jumps)
            leading_out += [
                Shock(impact, *pair) for pair in zip(delays[out].tolist(), jumps[out].tolist(), strict=True)
            ]
        return min(leading_out, key=lambda shock: abs(shock.jump), default=None), 8 * size / count

    def attractor(self, shock: Shock) -> Attractor:
        """The motion or state that follows a shock."""
        row = shocked(self.groups, self.motion, shock.impact, np.array([shock.delay]), np.array([shock.jump]))[0]
        return find_attractor(self.groups, start_of(row), BUDGET, compiled=True)

    def returns(self, attractor: Attractor) -> bool:
        """Whether an attractor is the motion that was knocked."""
        cycle = attractor.cycle
        if cycle is None or cycle.sticks:
            return False
        return bool(self.cores[0].holds(cycle.impacts).all())
