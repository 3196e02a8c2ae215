"""Proofs about the stable motions at a design point: what comes to them, also from rest, and which shocks die out."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import ROUND_FLOOR, Context
from enum import StrEnum

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.progress import Progress
from vireport.base.records import brief
from vireport.design.from_rest import Destination, FromRest
from vireport.design.solution import Solution
from vireport.design.switched_on import SwitchedOn
from vireport.findings.outcomes.manifold import on_shocks, stable_manifold
from vireport.findings.outcomes.returning import core_of, endings
from vireport.findings.outcomes.shock import LeastShock
from vireport.findings.outcomes.withstood import Withstood, motions_by_stability
from vireport.findings.proofs.following import Goal
from vireport.findings.proofs.section import Section, proved_section, section_again
from vireport.findings.proofs.survived import Survived, survived, survived_again
from vireport.findings.proofs.trap import Trap, proved_trap, trap_of
from vireport.physics.device import Device
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM
from vireport.simulation.starts import start_speed

BEYOND = 1.03
"""How far cells of shocks reach, over the least on the sampled stable manifold of an unstable motion."""

DIGITS = 4
"""Significant digits of a proved bound, which is rounded down to them."""


class Unproved(StrEnum):
    """Reasons why no proof is tried."""

    NO_MOTION = "no 1:1 motion is stable"
    NO_GRAVITY = "gravity along the capsule was neglected, so that the device computed is not the scenario's"
    NO_REBOUND = "the ball does not bounce"
    NO_REGION = "no region around the motion is proved to attract what is in it"
    RAMP = "the amplitude is ramped up, and what is proved is about a force that is there at once"
    RESTS = "the ball comes to rest on a membrane again and again, and reaches no motion without rest"
    AT_REST = "the ball stays at rest"
    NOT_PERIODIC = "no periodic motion is known that it comes to"


REFUSED = {
    Destination.REST_CYCLE: Unproved.RESTS,
    Destination.AT_REST: Unproved.AT_REST,
    Destination.CHAOTIC: Unproved.NOT_PERIODIC,
    Destination.UNDECIDED: Unproved.NOT_PERIODIC,
}
"""Reasons for which the simulated destination of the ball from rest is not proved."""


class Arrival(Struct, frozen=True, eq=False):
    """A proof, or why there is none, that a ball at rest on the bottom membrane comes to a motion.

    Attributes
    ----------
    trap : Trap or None
        The region that the ball comes into; None where that is not proved.
    impacts : int
        Number of impacts until then.
    bits : int
        Precision of the arithmetic.
    reason : str
        Why it is not proved, or "".
    """

    trap: Trap | None = None
    impacts: int = 0
    bits: int = 0
    reason: str = ""

    @property
    def proved(self) -> bool:
        """Whether the ball is proved to come to a motion."""
        return self.trap is not None

    @property
    def name(self) -> str:
        """Name of the motion that the ball comes to; "" where nothing is proved."""
        return "" if self.trap is None else self.trap.motion.word.name


class Proved(Struct, frozen=True, eq=False):
    """Proofs about the stable 1:1 motions at a design point.

    Attributes
    ----------
    velocity_unit : float
        y_c [m/s].
    arrival : Arrival
    sections : tuple of Section
        The impacts that come to each stable motion with a region, and to another motion that is reached from rest.
    shocks : tuple of Survived
        The shocks that each stable motion survives; () where nothing is proved of them.
    unproved : str
        Why nothing is proved of shocks, or "".
    """

    velocity_unit: float
    arrival: Arrival
    sections: tuple[Section, ...] = ()
    shocks: tuple[Survived, ...] = ()
    unproved: str = ""

    __repr__ = brief

    @property
    def jump_m_s(self) -> float | None:
        """Size up to which every jump of the relative velocity dies out [m/s], rounded down; None without a proof."""
        least = min((shocks.jump for shocks in self.shocks), default=0.0)
        return rounded_down(least * self.velocity_unit) if least > 0 else None

    @property
    def cells(self) -> int:
        """Cells of shocks that are proved."""
        return sum(shocks.cells for shocks in self.shocks)


def rounded_down(value: float) -> float:
    """A positive bound with `DIGITS` significant digits, below one that is exact to rounding."""
    return float(Context(prec=DIGITS, rounding=ROUND_FLOOR).create_decimal_from_float(value * (1 - 1e-14)))


def proved_of(
    solution: Solution,
    switched_on: SwitchedOn,
    withstood: Withstood | None,
    compiled: bool,
    progress: Progress | None = None,
) -> Proved | None:
    """Prove as much as possible of the motions at the design point; None without a design point.

    Parameters
    ----------
    solution : Solution
    switched_on : SwitchedOn
        Tells what the ball comes to from rest.
    withstood : Withstood or None
        Has the least shock that leads out: no bound can exceed it.
    compiled : bool
        Whether to compile the simulation, which says where to look, where numba is there.
    progress : callable, optional
        Called with each long step as it begins.
    """
    design, device = solution.design, solution.device.of_sine("a proof of disturbances")
    if design is None:
        return None
    unit = float(device.velocity_unit(Parameter.LENGTH, device.length_m))
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    refused = _refused(device, groups)
    if refused is not None:
        return Proved(unit, Arrival(reason=refused), unproved=refused)
    # Unstable motions are on the borders of basins: their stable manifolds say how far proofs about shocks can reach.
    motions, companions = map(list, motions_by_stability(design, device))
    traps = [trap_of(groups, motion, compiled) for motion in motions]
    say = progress or (lambda _: None)
    say("proving that the motion is reached from rest")
    regions = [trap for trap in traps if trap is not None]
    end = Unproved.RAMP if switched_on.ramp_periods else switched_on.from_rest
    arrival = _arrival(device, groups, end, regions, compiled)
    say("proving which share of all impacts comes to the motion")
    sections = _sections(device, groups, [*traps, arrival.trap], compiled)
    if not motions or None in traps:
        return Proved(unit, arrival, sections, unproved=Unproved.NO_REGION if motions else Unproved.NO_MOTION)
    say("proving which shocks the motion survives")
    least = withstood.shock if withstood is not None else None
    farthest = _farthest(groups, motions, companions, least, compiled)
    shocks = (survived(Goal(groups, trap, compiled=compiled), farthest) for trap in regions)
    return Proved(unit, arrival, sections, tuple(shocks))


def _sections(
    device: Device, groups: Groups[float], traps: Sequence[Trap | None], compiled: bool
) -> tuple[Section, ...]:
    """The shares of the section that are proved to come into each of some regions."""
    # The motion that is reached from rest may be one of the stable ones: its region counts once.
    regions = list(dict.fromkeys(trap for trap in traps if trap is not None))
    fastest = max((float(np.abs(trap.motion.velocity).max()) for trap in regions), default=0.0)
    # All sections reach as far as random starts do, so that shares can be compared with what is simulated.
    farthest = float(start_speed(groups.restitution, fastest))
    return tuple(
        proved_section(Goal(groups, trap, _released_into(device, groups, trap, compiled), compiled), farthest)
        for trap in regions
    )


def _released_into(device: Device, groups: Groups[float], trap: Trap, compiled: bool) -> set[int]:
    """The membranes, 1 bottom and -1 top, from which a released ball is proved to come into a region."""
    if groups.gbar >= 1:
        return set()
    pressed = np.array([[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, np.pi]])
    try:
        ends = endings(groups, pressed, [core_of(groups, trap.motion, compiled)], compiled=compiled)
    except NumericalError:  # too near a critical point to be simulated to its end: not tried
        return set()
    # Simulated first: a proof in ball arithmetic is tried only where it can succeed.
    simulated = [wall for wall, end in zip((1, -1), ends.tolist(), strict=True) if end == 0]
    return {wall for wall in simulated if _release(device, [trap], wall).proved}


def _farthest(
    groups: Groups[float], motions: list[Motion], companions: list[Motion], least: LeastShock | None, compiled: bool
) -> float:
    """Size of shocks up to which a bound may be possible [y_c], so that no effort goes into larger ones.

    A shock onto the stable manifold of an unstable motion leads there, even where shocks on both sides of it return.
    """
    if least is not None and least.jump is not None:
        return least.jump
    fastest = max(float(np.abs(motion.velocity).max()) for motion in motions)
    if not compiled:  # the manifold takes a hundred thousand flights, and a bound that is too large costs effort only
        return fastest
    on = (
        float(np.abs(line.jump).min())
        for companion in companions
        for piece in stable_manifold(groups, companion, 2 * fastest)
        for motion in motions
        for line in on_shocks(groups, motion, piece)
    )
    return min([fastest, *(BEYOND * jump for jump in on)])


def _refused(device: Device, groups: Groups[float]) -> Unproved | None:
    """Why nothing can be proved of a device, whatever its motions; None where proofs may succeed."""
    if groups.gbar == 0 and device.inclination_deg != 0:
        return Unproved.NO_GRAVITY
    if any(groups.restitution_at(wall) == 0 for wall in (1, -1)):
        return Unproved.NO_REBOUND
    return None


def _arrival(
    device: Device, groups: Groups[float], end: FromRest | Unproved | None, traps: list[Trap], compiled: bool
) -> Arrival:
    """Prove that the ball from rest comes to the motion that it reaches in the simulation, or say why not."""
    if end is None or isinstance(end, Unproved):
        return Arrival(reason=end or Unproved.NOT_PERIODIC)
    if (refused := REFUSED.get(end.destination)) is not None:
        return Arrival(reason=refused)
    # For a motion of another word there is no region yet: it is sought here.
    if end.destination is Destination.OTHER_MOTION:
        traps = [trap for trap in [_other(groups, end, compiled)] if trap is not None]
    if not traps:
        return Arrival(reason=Unproved.NO_REGION)
    return _release(device, traps)


def _release(device: Device, traps: list[Trap], wall: int = BOTTOM) -> Arrival:
    """Prove that a ball that a membrane releases comes into one of some regions."""
    from vireport.findings.proofs.release import reaches
    from vireport.study.checks.enclosures import UnprovedError

    try:
        return Arrival(*reaches(device, traps, wall=wall))
    except UnprovedError as failure:
        return Arrival(reason=str(failure))


def _other(groups: Groups[float], end: FromRest, compiled: bool) -> Trap | None:
    """A trapping region about the motion of another word that is reached from rest; None where none is proved."""
    return None if end.cycle is None else trap_of(groups, end.cycle.motion(groups.d), compiled)


class ProvedRegion(Struct, frozen=True, eq=False):
    """A claimed trapping region: its motion, metric and radius, see `Trap`."""

    motion: Motion
    metric: NDArray[np.float64]
    radius: float


class Rechecked(Struct, frozen=True):
    """What the proofs of a results.json prove, verified again.

    Attributes
    ----------
    from_rest : bool
        Whether the ball is proved to come into one of the regions when the device is switched on from rest.
    proved_m_s : float
        Size up to which every jump of the relative velocity dies out [m/s], rounded down; 0 without a proof.
    shares : tuple of float
        Share of the section of impacts that comes to each motion [1], a lower bound.
    switch_on : tuple of float
        Share of the moments of switching on that leads to each motion [1], a lower bound.
    """

    from_rest: bool
    proved_m_s: float
    shares: tuple[float, ...] = ()
    switch_on: tuple[float, ...] = ()


class ClaimedSection(Struct, frozen=True, eq=False):
    """A claimed proof about the section: region, largest velocity [y_c], cells and moments, see `Section`."""

    region: ProvedRegion
    fastest: float
    halved: NDArray[np.intp]
    moments: NDArray[np.intp]


def prove_again(
    device: Device,
    from_rest: ProvedRegion | None,
    shocks: list[tuple[ProvedRegion, float, NDArray[np.intp]]],
    sections: Sequence[ClaimedSection] = (),
) -> Rechecked:
    """Go through claimed proofs once more.

    Parameters
    ----------
    device : Device
    from_rest : ProvedRegion or None
        The region that the ball from rest is claimed to enter.
    shocks : list of (ProvedRegion, float, ndarray)
        Regions, with the largest size [y_c] and the codes of the cells of each.
    sections : sequence of ClaimedSection

    Raises
    ------
    ValueError
        If there are not as many cells as it takes.
    """
    device.of_sine("a proof of disturbances")
    at = Parameter.LENGTH, device.length_m
    groups, unit = device.groups(*at).as_floats(), float(device.velocity_unit(*at))
    if _refused(device, groups) is not None:
        return Rechecked(False, 0.0)

    def again(region: ProvedRegion) -> Trap | None:
        """The region, proved once more."""
        return proved_trap(groups, region.motion, region.metric, region.radius, compiled=False)

    # A claim that is not proved again counts as no claim.
    start = None if from_rest is None else again(from_rest)
    from_rest_proved = start is not None and _release(device, [start]).proved
    bounds = []
    for region, largest, halved in shocks:
        trap = again(region)
        bounds.append(0.0 if trap is None else survived_again(Goal(groups, trap, compiled=False), largest, halved))
    shares = []
    for claimed in sections:
        trap = again(claimed.region)
        if trap is None:
            shares.append((0.0, 0.0))
            continue
        goal = Goal(groups, trap, _released_into(device, groups, trap, compiled=False), compiled=False)
        shares.append(section_again(goal, claimed.fastest, claimed.halved, claimed.moments))
    least = min(bounds, default=0.0)
    survives = rounded_down(least * unit) if least > 0 else 0.0
    return Rechecked(from_rest_proved, survives, tuple(x for x, _ in shares), tuple(x for _, x in shares))
