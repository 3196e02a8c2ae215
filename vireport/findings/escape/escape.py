"""How long the stable 1:1 motions of a design point last under random kicks, and what they come to then."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from enum import StrEnum
from math import exp, hypot, inf, log, sqrt

import numpy as np
from msgspec import Struct

from vireport.base.errors import NumericalError
from vireport.base.records import brief
from vireport.base.shares import NORMAL_95
from vireport.design.solution import Solution
from vireport.findings.escape.least_kicks import KickedPath, LeastKicks, edge_rows, least_kicks
from vireport.findings.escape.lifetimes import ESCAPES, Lifetime, ReturnGrid, lifetime
from vireport.findings.outcomes.returning import Core, Recogniser, patient
from vireport.findings.outcomes.shock import MotionsByStability
from vireport.findings.outcomes.withstood import disturbed_design
from vireport.physics.groups import Groups, by_wall
from vireport.physics.motion import Motion

BUDGET, LEVEL_BUDGET = 8_000_000, 3_000_000
"""Most impacts that are simulated with the kicks of the scenario, and with the larger kicks of each level; a million
takes some 0.4 s on one core. A motion that would need more is judged by the law for small kicks."""

LEVELS, LEVEL_ESCAPES, LAST = range(1, 9), 400, 4
"""Values of Q/sigma^2 at which the motion is simulated (levels), escapes that are waited for at each, and how many of
the last levels give the offset of the law."""

SOME_TENS, ENOUGH = 20.0, 3
"""Forcing periods that a motion must last at a level for the law to hold nearly, and fewest levels for its offset."""

LONGEST = 700.0
"""Logarithm of a number of periods that is beyond any use, and near the largest that a double has."""

SEED = 20261129
"""Seed of the kicks, the same in every run."""


class Unlimited(StrEnum):
    """Why no number of periods is given."""

    BEYOND_USE = "it lasts longer than any number of periods that is of use"
    NO_WAY_OUT = "no kick that was tried leads out of the motion, and no ball left it"
    TOO_LONG = "too few balls left the motion in the impacts that were simulated, and no law for small kicks is known"
    NO_BOUNCE = "a ball that does not bounce leaves a membrane with no velocity"


class SmallKickLaw(Struct, frozen=True):
    """The law for small kicks, ln T = a + Q/sigma^2, with T in forcing periods.

    Attributes
    ----------
    exponent : float
        Q [y_c^2].
    offset, error : float
        a, and its standard error: that of a fit of a + b sigma^2 to ln T - Q/sigma^2, and the term b sigma^2 at the
        smallest kicks of the levels, by which these are not small enough.
    """

    exponent: float
    offset: float
    error: float

    def log_periods(self, kick: float) -> float:
        """Logarithm of the mean time under kicks of a standard deviation [y_c], in forcing periods."""
        return self.offset + self.exponent / kick**2


class MotionEscape(Struct, frozen=True, eq=False):
    """How long one motion lasts under kicks.

    Attributes
    ----------
    motion : Motion
    kick : float
        Standard deviation of the kicks [y_c].
    way : LeastKicks or None
        The least kicks that lead out; None where none were found.
    levels : tuple of Lifetime
        Simulated with larger kicks, for the law; the kicks fall from level to level.
    law : SmallKickLaw or None
        None where too few levels last long enough.
    simulated : Lifetime or None
        With the kicks themselves; None where that takes too long.
    ends : tuple of (str, float)
        What the balls that left come to, with shares, the largest first; of `simulated` or else of the last level.
    checked, wrong : int
        Impacts that the grid says to return and that were followed to check it, and how many of them do not return.
    unknown : str
        Why nothing was found out; "" otherwise.
    """

    motion: Motion
    kick: float
    way: LeastKicks | None = None
    levels: tuple[Lifetime, ...] = ()
    law: SmallKickLaw | None = None
    simulated: Lifetime | None = None
    ends: tuple[tuple[str, float], ...] = ()
    checked: int = 0
    wrong: int = 0
    unknown: str = ""

    __repr__ = brief

    @property
    def path(self) -> KickedPath | None:
        """The sequence with the least kicks that lead out; None where none is confirmed."""
        return None if self.way is None else self.way.path

    @property
    def extrapolated(self) -> bool:
        """Whether the number of periods is by the law for small kicks."""
        return self.simulated is None and self.law is not None

    @property
    def log_periods(self) -> float:
        """Logarithm of the mean number of forcing periods; inf where that is not known, or beyond any use."""
        if self.simulated is not None:
            return log(self.simulated.mean) if self.simulated.mean < inf else inf
        return inf if self.law is None else self.law.log_periods(self.kick)

    @property
    def periods(self) -> float | None:
        """Mean number of forcing periods; None with the `reason`."""
        return None if self.reason else exp(self.log_periods)

    @property
    def interval(self) -> tuple[float | None, float | None]:
        """The ends of the 95 % interval of `periods`, each None where it is not known or beyond any use."""
        if self.simulated is not None:
            low, high = self.simulated.interval
            return low, None if high == inf else high
        if self.law is None or self.reason:
            return None, None
        half = NORMAL_95 * self.law.error
        return exp(self.log_periods - half), exp(min(self.log_periods + half, LONGEST))

    @property
    def reason(self) -> str:
        """Why there is no number of periods; "" where there is one."""
        if self.unknown:
            return self.unknown
        if self.law is not None and self.simulated is None:
            return Unlimited.BEYOND_USE if self.log_periods > LONGEST else ""
        if self.log_periods < inf:
            return ""
        return Unlimited.NO_WAY_OUT if self.way is None else Unlimited.TOO_LONG

    @property
    def shape(self) -> Lifetime | None:
        """The simulation that tells how the times are distributed: `simulated`, or else the last of the levels."""
        return self.simulated or (self.levels[-1] if self.levels else None)


class Escape(Struct, frozen=True, eq=False):
    """How long the stable 1:1 motions of a design point last.

    Attributes
    ----------
    motions : tuple of MotionEscape
        At least one.
    kick_m_s, velocity_unit : float
        Standard deviation of the kicks, and y_c [m/s].
    frequency_hz : float
    """

    motions: tuple[MotionEscape, ...]
    kick_m_s: float
    velocity_unit: float
    frequency_hz: float

    __repr__ = brief

    @property
    def shortest(self) -> MotionEscape:
        """The motion that lasts least; one whose time is unknown counts as lasting least."""
        return min(self.motions, key=lambda of: -inf if of.unknown else of.log_periods)

    @property
    def drawn(self) -> MotionEscape | None:
        """The motion that lasts least of those with a law for small kicks; None where there is none."""
        known = [of for of in self.motions if of.law is not None]
        return min(known, key=lambda of: of.log_periods, default=None)

    def time_s(self, periods: float) -> float:
        """Convert a number of forcing periods to a time [s]."""
        return periods / self.frequency_hz


def escape_of(solution: Solution, kick_m_s: float) -> Escape | None:
    """Find out how long the stable 1:1 motions of the design point last under kicks; None where there are none.

    Parameters
    ----------
    solution : Solution
    kick_m_s : float
        Standard deviation of the velocity that is added just after each impact [m/s].
    """
    disturbed = disturbed_design(solution, "how long a motion lasts under kicks")
    if disturbed is None:
        return None
    device, groups, unit, motions = disturbed
    lasting = tuple(escape_from(groups, motion, motions, kick_m_s / unit) for motion in motions.stable)
    return Escape(lasting, kick_m_s, unit, float(device.frequency_hz))


def escape_from(groups: Groups[float], motion: Motion, motions: MotionsByStability, kick: float) -> MotionEscape:
    """Find out how long a motion lasts under kicks, by simulation or by the law for small kicks.

    Parameters
    ----------
    groups : Groups
        Of the device; without friction.
    motion : Motion
        Stable.
    motions : MotionsByStability
        This one, and others of the device.
    kick : float
        Standard deviation of the kicks [y_c].
    """
    try:
        recognise, cores = _recognised(groups, motion, motions)
    except (NumericalError, ValueError) as error:
        return MotionEscape(motion, kick, unknown=str(error))
    way = least_kicks(groups, cores)
    path = None if way is None else way.path
    exponent = kick**2 if path is None else path.exponent
    grid = ReturnGrid(groups, cores, max(kick, sqrt(exponent / LEVELS[0])))
    levels = () if path is None else tuple(_levels(grid, exponent))
    law = _law(exponent, levels)
    simulated = None
    if law is None or law.log_periods(kick) < log(BUDGET / (ESCAPES * len(motion.word) / motion.word.periods)):
        # Where nothing was seen to lead out, a long wait is for nothing.
        simulated = lifetime(grid, kick, SEED, LEVEL_BUDGET if way is None else BUDGET)
    shown = simulated or levels[-1]
    return MotionEscape(
        motion, kick, way, levels, law, simulated, _ends(recognise, shown.left), grid.checked, grid.wrong
    )


def exponent_of(groups: Groups[float], motion: Motion, motions: MotionsByStability) -> float | None:
    """Q of the law for small kicks of a stable motion [y_c^2]; None where no kicks were found that lead out of it.

    Raises
    ------
    NumericalError
        Where the motion is too near a critical point, see `core_of`.
    ValueError
        If a coefficient of restitution is zero: the ball does not bounce.
    """
    way = least_kicks(groups, _recognised(groups, motion, motions)[1])
    return None if way is None or way.path is None else way.path.exponent


def _recognised(groups: Groups[float], motion: Motion, motions: MotionsByStability) -> tuple[Recogniser, list[Core]]:
    """A recogniser of the motions that kicks lead to, and the cores of those it knows, first that of the motion."""
    if 0 in by_wall(groups.restitution):
        raise ValueError(Unlimited.NO_BOUNCE)
    recognise = Recogniser(groups, [motion, *(other for other in motions.stable if other is not motion)])
    # Motions that kicks lead to are learnt beforehand, so that a ball on one is recognised after a few impacts.
    recognise(edge_rows(groups, motion))
    return recognise, patient(groups, recognise.cores, motions.unstable)


def _levels(grid: ReturnGrid, exponent: float) -> Iterator[Lifetime]:
    """Lifetimes under larger kicks, level by level, as long as they are simulated in a short time."""
    for number, ratio in enumerate(LEVELS):
        level = lifetime(grid, sqrt(exponent / ratio), SEED + number + 1, LEVEL_BUDGET, LEVEL_ESCAPES)
        if level.late < LEVEL_ESCAPES and len(level.staying):
            break
        yield level
        # Lifetimes, and so the impacts to simulate, grow by a factor e from level to level.
        if exp(1) * level.impacts > LEVEL_BUDGET:
            break


def _law(exponent: float, levels: Sequence[Lifetime]) -> SmallKickLaw | None:
    """Fit the law to the levels at which the motion lasts long enough; None where they are fewer than `ENOUGH`."""
    used = [level for level in levels if level.mean >= SOME_TENS][-LAST:]
    if len(used) < ENOUGH:
        return None
    variance = np.array([level.kick**2 for level in used])
    left, weight = [np.log([level.mean for level in used]) - exponent / variance], 1 / np.array([x.error for x in used])
    columns = weight[:, None] * np.stack([np.ones(len(used)), variance / variance[-1]], axis=1)
    covariance = np.linalg.inv(columns.T @ columns)
    offset, slope = covariance @ columns.T @ (weight * left[0])
    return SmallKickLaw(exponent, float(offset), hypot(sqrt(covariance[0, 0]), float(slope)))


def _ends(recognise: Recogniser, left: np.ndarray) -> tuple[tuple[str, float], ...]:
    """Names of the motions and states that impacts, rows of `check_start`, lead to, with shares, the largest first."""
    if not len(left):
        return ()
    counted = Counter(recognise(left).tolist())
    names: Counter[str] = Counter()
    for place, count in counted.items():
        name = recognise.outcomes[place].name
        if place == 0:
            name = "the motion itself, later than was waited for"
        elif name == recognise.outcomes[0].name:  # the mirror image, for example
            name = f"another {name}"
        names[name] += count
    return tuple((name, count / len(left)) for name, count in names.most_common())
