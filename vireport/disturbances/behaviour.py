"""What the device does when it is switched on and disturbed, gathered for one scenario."""

from __future__ import annotations

from functools import partial
from math import fsum
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import brief
from vireport.design.followed import FollowedMotion, followed_motion
from vireport.design.from_rest import Destination, FromRest, Target, from_rest
from vireport.design.recovery import NoRecovery, Recovery, recovery_of
from vireport.design.solution import Solution
from vireport.disturbances.moments import RAMPS, outcome_of, outcomes_by_moment, ramp_that_helps
from vireport.physics.groups import Groups
from vireport.physics.motion import SAME
from vireport.scenario.blocks import DisturbancesBlock
from vireport.scenario.parameters import DesignInput, Parameter

if TYPE_CHECKING:
    from vireport.design.outcomes_from_rest import OutcomeRange
    from vireport.disturbances.windows import Edge, Window
    from vireport.simulation.cycles import SimulatedMotion

WIDEST = 0.5
"""How far from the design value it is looked for where a window ends, over that value, where no sweep says how far."""

UNTOLD = 1e-5
"""Distance, over the value, from where a motion ceases to be stable within which disturbances die out too slowly."""

NARROW = 0.02
"""Share of the design value within which the end of a window is near: what masses and lengths are commonly made to."""


class Ramp(Struct, frozen=True):
    """The amplitude raised from zero, where switching on at once does not reach the motion.

    Attributes
    ----------
    periods : int or None
        The fewest forcing periods of those tried from which 1:1 motion is reached whenever the force sets in.
    longest : int
        The most that were tried.
    """

    periods: int | None
    longest: int


class Disturbances(Struct, frozen=True, eq=False):
    """What a device does when it is switched on and disturbed; what was not computed is None.

    Attributes
    ----------
    from_rest : FromRest or None
        What it comes to at the design point that is switched on; None where none is given.
    ramp_periods : float
        Forcing periods in which its amplitude then rises.
    share : float or None
        Share of the moments at which the force may set in from which a 1:1 motion is reached.
    ramp : Ramp or None
        Where switching on at once does not reach it, though one is stable.
    window : Window or None
        How far the outcome stays around the design point.
    over_sweep : tuple of OutcomeRange
        The outcomes along the sweep.
    recovery : Recovery or None
        Of the slowest stable 1:1 motion at the design point.
    no_recovery : NoRecovery or None
        Why it has none, where there is a design point.
    reached : FollowedMotion or None
        The periodic motion of another word, without rests, that it comes to, followed along the swept parameter, or the
        length where there is no sweep; without a block only where no 1:1 motion is stable.
    by_starts : tuple of FollowedMotion
        Where neither a 1:1 motion is stable nor such a motion reached: stable ones that a few starts come to.
    sampled : tuple of OutcomeRange
        The outcomes at a few values of a sweep in which no 1:1 motion is stable, where there is neither a design point
        nor `over_sweep`.
    """

    from_rest: FromRest | None
    ramp_periods: float = 0.0
    share: float | None = None
    ramp: Ramp | None = None
    window: Window | None = None
    over_sweep: tuple[OutcomeRange, ...] = ()
    recovery: Recovery | None = None
    no_recovery: NoRecovery | None = None
    reached: FollowedMotion | None = None
    by_starts: tuple[FollowedMotion, ...] = ()
    sampled: tuple[OutcomeRange, ...] = ()

    __repr__ = brief

    @property
    def values_over_sweep(self) -> int:
        """Values along the sweep at which the outcome was looked for, before edges were located."""
        from vireport.disturbances.windows import ALONG

        return ALONG if self.over_sweep else len(self.sampled)

    @property
    def outcomes_over_sweep(self) -> tuple[FromRest, ...]:
        """The outcomes at these values, each once, in the order of the sweep."""
        outcomes: list[FromRest] = []
        for stretch in (*self.over_sweep, *self.sampled):
            if all(stretch.outcome.kind != other.kind for other in outcomes):
                outcomes.append(stretch.outcome)
        return tuple(outcomes)

    @property
    def narrow(self) -> bool:
        """Whether the outcome changes within what devices are commonly made to."""
        window = self.window
        nearest = window.nearest if window is not None else None
        return window is not None and nearest is not None and window.distance(nearest) < NARROW * abs(window.value)


def disturbances_of(
    solution: Solution,
    block: DisturbancesBlock | None,
    compiled: bool = False,
    windows: bool = False,
) -> Disturbances:
    """Find out what a device does when it is switched on and disturbed.

    Parameters
    ----------
    solution : Solution
    block : DisturbancesBlock or None
        Without one, only what takes some milliseconds: the outcome from rest at once, and the recovery.
    compiled : bool
        Whether to compile the simulation.
    windows : bool
        Whether to find how far the outcome stays, around the design point and along the sweep.
    """
    design, device = solution.design, solution.device
    strip = _along(solution, compiled) if windows else ()
    if design is None:
        return Disturbances(None, over_sweep=strip, sampled=() if strip else _sampled(solution, compiled))
    groups, targets = device.groups(Parameter.LENGTH, device.length_m).as_floats(), Target.of(design.motions)
    recovered, ratio = recovery_of(solution), device.period_ratio
    recovery, no_recovery = (recovered, None) if isinstance(recovered, Recovery) else (None, recovered)
    if block is None:
        end = from_rest(groups, targets, ratio, compiled)
        reached = None if targets else _reached(solution, end)
        others = _by_starts(solution, groups, compiled) if not targets and reached is None else ()
        return Disturbances(end, recovery=recovery, no_recovery=no_recovery, reached=reached, by_starts=others)
    device.constant_restitution("what it does when the force sets in at any moment")
    outcomes = outcomes_by_moment(groups, targets, ratio, block.ramp_periods, compiled)
    end = outcome_of(outcomes)
    ramp = None
    if targets and not end.reached:
        ramp = Ramp(ramp_that_helps(groups, targets, ratio, compiled), RAMPS[-1])
    around = _window(solution, compiled) if windows else None
    share = min(fsum(part for part, outcome in outcomes if outcome.reached), 1.0)
    reached = _reached(solution, end)
    others = _by_starts(solution, groups, compiled) if not targets and reached is None else ()
    return Disturbances(end, block.ramp_periods, share, ramp, around, strip, recovery, no_recovery, reached, others)


def _reached(solution: Solution, end: FromRest) -> FollowedMotion | None:
    """The motion of another word that the device comes to, as its equations have it."""
    cycle = end.cycle
    if solution.device.rubs:  # the equations of other words know no stops in flight
        return None
    return _followed(solution, cycle) if end.destination is Destination.OTHER_MOTION and cycle is not None else None


def _by_starts(solution: Solution, groups: Groups[float], compiled: bool) -> tuple[FollowedMotion, ...]:
    """The stable motions that some starts come to; without the compiler the first that is found."""
    if solution.device.rubs:
        return ()
    from vireport.design.by_starts import cycles_by_starts

    motions: list[FollowedMotion] = []
    for cycle in cycles_by_starts(groups, compiled):
        motion = cycle.motion(0.0)
        if cycle.sticks or any(motion.distance(other.motion, solution.horizontal) < SAME for other in motions):
            continue
        followed = _followed(solution, cycle)
        motions += [followed] if followed is not None else []
        if motions and not compiled:
            break
    return tuple(motions)


def _followed(solution: Solution, cycle: SimulatedMotion) -> FollowedMotion | None:
    """A motion that was simulated, as its equations have it."""
    swept = solution.sweep.parameter if solution.sweep is not None else Parameter.LENGTH
    return followed_motion(solution.device, cycle.motion(0.0), DesignInput(swept))


def _along(solution: Solution, compiled: bool) -> tuple[OutcomeRange, ...]:
    sweep = solution.sweep
    if sweep is None:
        return ()
    from vireport.design.outcomes_from_rest import outcomes_at
    from vireport.disturbances.windows import over_sweep

    return over_sweep(sweep.start, sweep.end, partial(outcomes_at, solution.device, sweep.parameter, compiled=compiled))


def _sampled(solution: Solution, compiled: bool) -> tuple[OutcomeRange, ...]:
    """The outcomes at a few values of a sweep in which no 1:1 motion is stable: what the ball does instead."""
    sweep = solution.sweep
    if sweep is None or solution.stable_ranges:
        return ()
    from vireport.design.outcomes_from_rest import outcomes_at, sampled

    return sampled(sweep.start, sweep.end, partial(outcomes_at, solution.device, sweep.parameter, compiled=compiled))


def _window(solution: Solution, compiled: bool) -> Window | None:
    """The window along the input that is swept or, without a sweep, that in which stable motion ends first."""
    design, sweep = solution.design, solution.sweep
    ends = design.limits() if design is not None else []
    if sweep is None and not ends:
        return None
    varied = sweep.parameter if sweep is not None else ends[0].parameter
    value = float(solution.device.value_of(varied))
    low, high = sorted((sweep.start, sweep.end)) if sweep is not None else (value, value)
    if not low < value < high:
        low, high = max(value * (1 - WIDEST), varied.limits[0]), min(value * (1 + WIDEST), varied.limits[1])
    from vireport.design.outcomes_from_rest import outcomes_at
    from vireport.disturbances.windows import window

    window_around = window(varied, value, low, high, partial(outcomes_at, solution.device, varied, compiled=compiled))
    stability_ends = [value + end.distance for end in ends if end.parameter == varied]
    return replace(
        window_around, low=_at_end(window_around.low, stability_ends), high=_at_end(window_around.high, stability_ends)
    )


def _at_end(edge: Edge, ends: list[float]) -> Edge:
    """An edge beyond which simulation does not tell, moved to the end of the stable motion that makes it so."""
    if edge.beyond is None or edge.beyond.decided:
        return edge
    return next((replace(edge, value=end) for end in ends if abs(end - edge.value) <= UNTOLD * abs(end)), edge)
