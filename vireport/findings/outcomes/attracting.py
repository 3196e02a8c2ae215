"""The coexisting stable motions of a design point: the share of starts that come to each, and the least shock of each.

Motions of any word: the 1:1 motions, those of families that were followed, and what the device comes to from rest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf

import numpy as np
from msgspec import Struct

from vireport.base.errors import NumericalError
from vireport.base.records import brief
from vireport.design.from_rest import Destination, FromRest
from vireport.design.lines import mirrored
from vireport.design.solution import Solution
from vireport.design.switched_on import SwitchedOn
from vireport.findings.outcomes.deviations import is_smooth
from vireport.findings.outcomes.returning import Core, Elsewhere, core_of, endings, patient
from vireport.findings.outcomes.shock import SCAN, LeastShock, MotionsByStability, least_shock
from vireport.findings.outcomes.withstood import Withstood, motions_by_stability
from vireport.motions.families import Atlas
from vireport.physics.groups import Groups
from vireport.physics.motion import SAME, Motion
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM
from vireport.simulation.starts import random_starts, start_speed

STARTS = 2000
"""Random starts: a share is then known to within some 2 %, in some hundredths of a second."""

SEED = 20240229
"""Of these, in every run the same."""


class AttractingMotion(Struct, frozen=True, eq=False):
    """A stable motion, and what leads to it and out of it.

    Attributes
    ----------
    motion : Motion or None
        None where the ball comes to rest on a membrane, once in every period or for good.
    name : str
        Its word and period.
    share : float or None
        Share of the random starts that come to it; None where that cannot be told, next to a critical point.
    from_rest : bool or None
        Whether the device comes to it when switched on; None where it is not told from others of the same word.
    shock : LeastShock or None
        The least shock that leads out of it; None where it is not known.
    unknown : str
        Why share and shock are not known; "" otherwise.
    """

    motion: Motion | None
    name: str
    share: float | None
    from_rest: bool | None
    shock: LeastShock | None = None
    unknown: str = ""

    __repr__ = brief


class AttractingMotions(Struct, frozen=True, eq=False):
    """All stable motions known at a design point.

    Attributes
    ----------
    motions : tuple of AttractingMotion
    starts : int
        Number of random states in flight, see `random_starts`.
    others : float or None
        Share of the starts that comes to none of the motions; None where one of these cannot be recognised.
    velocity_unit : float
        y_c [m/s].
    time_unit : float
        t_c [s].
    """

    motions: tuple[AttractingMotion, ...]
    starts: int
    others: float | None
    velocity_unit: float
    time_unit: float

    __repr__ = brief

    @property
    def recognised(self) -> list[Motion]:
        """The motions for which the share of starts that come to them is known."""
        return [motion.motion for motion in self.motions if motion.motion is not None and motion.share is not None]

    @property
    def motions_from_rest(self) -> list[AttractingMotion]:
        """The motions that the device comes to from rest; empty where the ball comes to rest."""
        return [motion for motion in self.motions if motion.from_rest and motion.motion is not None]

    def withstood(self, chosen: Sequence[AttractingMotion]) -> Withstood | None:
        """The least shock of some of the motions; None where none is chosen."""
        if not chosen:
            return None
        shocks = [motion.shock for motion in chosen if motion.shock is not None]
        if len(shocks) < len(chosen):
            unknown = next(motion.unknown for motion in chosen if motion.shock is None)
            return Withstood(self.velocity_unit, self.time_unit, shock_unknown=unknown)
        least = min(shocks, key=lambda shock: inf if shock.jump is None else shock.jump)
        return Withstood(self.velocity_unit, self.time_unit, least)


def attracting_motions(
    solution: Solution,
    switched_on: SwitchedOn,
    atlas: Atlas | None = None,
    withstood: Withstood | None = None,
    least_m_s: float | None = None,
) -> AttractingMotions | None:
    """Compare the stable motions of a design point, by compiled code: shares of starts, and least shocks.

    Parameters
    ----------
    solution : Solution
    switched_on : SwitchedOn
        What the device comes to from rest.
    atlas : Atlas, optional
        Where the design point is within the sweep, its stable motions are compared too, and its unstable ones may be
        companions.
    withstood : Withstood, optional
        The least shock of the 1:1 motions, which is not looked for again.
    least_m_s : float, optional
        Shock that must be withstood [m/s], as for `withstood_by`.

    Returns
    -------
    AttractingMotions or None
        None without a design point, and where no attracting motion is known.
    """
    design, device = solution.design, solution.device.constant_restitution("the other stable motion")
    if design is None:
        return None
    at = Parameter.LENGTH, device.length_m
    groups = device.groups(*at).as_floats()
    stable, unstable = _both_kinds(solution, switched_on, atlas)
    cores, why = list[Core](), dict[int, str]()
    for k, motion in enumerate(stable):
        try:
            cores.append(core_of(groups, motion, compiled=True))
        except (NumericalError, ValueError) as error:  # too near a critical point, or a ball that does not bounce
            why[k] = str(error)
    # A start that passes next to an unstable motion lingers there: without patience it would count as going elsewhere.
    cores = patient(groups, cores, unstable)
    fastest = max((float(np.abs(motion.velocity).max()) for motion in stable), default=0.0)
    speed = start_speed(groups.restitution, fastest)
    ends = endings(groups, random_starts(groups.d, speed, STARTS, SEED)[0], cores)
    # Ends of starts are places among the cores, where motions without a core are missing.
    place = {k: row for row, k in enumerate(k for k in range(len(stable)) if k not in why)}
    unit, time_unit = float(device.velocity_unit(*at)), 0.5 / float(device.frequency_hz)
    least = 0.0 if least_m_s is None else least_m_s / unit
    recognised, end = [core.motion for core in cores], switched_on.from_rest

    def arrives() -> list[bool]:
        # At phase 0 the sine presses the ball down, and all moments at which it does so lead to the same outcome.
        (last,) = endings(groups, np.array([[float(BOTTOM), 0.0, 0.0, 0.0]]), cores).tolist()
        return [place.get(k) == last for k in range(len(stable))]

    rested = _from_rest(stable, end, None if switched_on.ramp_periods else arrives)
    attracting = []
    for k, motion in enumerate(stable):
        share = float(np.mean(ends == place[k])) if k in place else None
        shock, unknown = None, why.get(k, "")
        if share is not None:
            # The full search goes before the coarser scan: else the report would have two least shocks of one motion.
            stated = withstood.shock if withstood is not None else None
            if stated is not None and stated.motion.distance(motion) == 0:
                shock = stated
            else:
                shock, unknown = _shock(groups, motion, MotionsByStability(recognised, unstable), least)
        attracting.append(AttractingMotion(motion, motion.word.name, share, rested[k], shock, unknown))
    rests = float(np.mean(ends == Elsewhere.RESTS))
    resting = end is not None and end.destination in (Destination.REST_CYCLE, Destination.AT_REST)
    if rests or resting:
        name = end.name if end is not None and resting else "rest"
        attracting.append(AttractingMotion(None, name, rests, resting))
    if not attracting:
        return None
    # Where one of the motions has no core, starts that seem to go elsewhere may well come to it.
    shares = sum(attracted.share or 0.0 for attracted in attracting)
    elsewhere = None if why else max(1 - shares, 0.0)
    return AttractingMotions(tuple(attracting), STARTS, elsewhere, unit, time_unit)


def _both_kinds(solution: Solution, switched_on: SwitchedOn, atlas: Atlas | None) -> tuple[list[Motion], list[Motion]]:
    """The stable motions at the design point, and the unstable ones, each once."""
    design, device = solution.design, solution.device.constant_restitution("the other stable motion")
    if design is None:
        return [], []
    stable, unstable = map(list, motions_by_stability(design, device))
    flat = mirrored(device)

    def add(to: list[Motion], motion: Motion) -> None:
        # A family stands for its mirror image as well, which has a basin of its own.
        for image in (motion, motion.mirrored()) if flat else (motion,):
            if all(image.distance(other) > SAME for other in to):
                to.append(image)

    if atlas is not None and min(ends := (atlas.sweep.start, atlas.sweep.end)) <= design.value <= max(ends):
        for _, motion in atlas.stable_at(design.value):
            add(stable, motion)
        for _, motion in atlas.at(design.value):
            if is_smooth(motion) and all(motion.distance(earlier) > SAME for earlier in stable):
                add(unstable, motion)
    from_rest = (switched_on.motion_from_rest,) if switched_on.motion_from_rest is not None else ()
    for followed in (*from_rest, *switched_on.by_starts):
        add(stable, followed.motion)
    return stable, unstable


def _from_rest(
    stable: Sequence[Motion], end: FromRest | None, arrives: Callable[[], list[bool]] | None
) -> list[bool | None]:
    """Which of the motions the device comes to when it is switched on.

    Of several with one word, those at which a ball from rest `arrives`; with a ramp that is open: None.
    """
    if end is None or not end.is_motion:
        return [False] * len(stable)
    word = Word.of(end.word, end.periods).canonical()
    alike = [motion.word.canonical() == word for motion in stable]
    # The word tells which motion it is, unless several have the same: then a start must be followed.
    if sum(alike) <= 1:
        return list[bool | None](alike)
    if arrives is None:
        return [None if same_word else False for same_word in alike]
    return [same_word and arrives_there for same_word, arrives_there in zip(alike, arrives(), strict=True)]


def _shock(
    groups: Groups[float], motion: Motion, neighbours: MotionsByStability, least: float
) -> tuple[LeastShock | None, str]:
    """The least shock of a motion, or why it is not known."""
    try:
        # Next to chaos each shock that leads out is followed for thousands of impacts: a full search took ten minutes.
        shock = least_shock(groups, motion, neighbours, effort=SCAN)
        if shock.jump is None and least >= shock.searched_to:
            shock = least_shock(groups, motion, neighbours, least * (1 + 1e-9), SCAN)
        return shock, ""
    except (NumericalError, ValueError) as error:
        return None, str(error)
