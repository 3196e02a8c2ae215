"""The outcome of switching a device on, the stable motions that this shows, and how fast they recover.

A start that a motion attracts need not have settled on it: its impacts nearly repeat, and Newton's method on the
simulated map then finds the motion and its multipliers.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.base.records import brief
from vireport.design.followed import FollowedMotion, followed_motion
from vireport.design.from_rest import Destination, FromRest, StartingDevice, Target, from_rest
from vireport.design.recovery import NoRecovery, Recovery, recovery_of
from vireport.design.solution import Solution
from vireport.physics.groups import Groups
from vireport.physics.motion import SAME, Motion
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.cycles import SimulatedMotion, attracting
from vireport.simulation.events import check_model
from vireport.simulation.follower import Trajectory
from vireport.simulation.starts import even_starts, start_speed

if TYPE_CHECKING:
    from vireport.design.outcomes_from_rest import OutcomeRange


class SwitchedOn(Struct, frozen=True, eq=False):
    """The outcome of switching a device on; what was not computed is None.

    Attributes
    ----------
    from_rest : FromRest or None
        The outcome at the design point; None without a design point.
    recovery : Recovery or None
        Recovery of the slowest stable 1:1 motion at the design point.
    no_recovery : NoRecovery or None
        Why there is no recovery, where there is a design point.
    motion_from_rest : FollowedMotion or None
        The periodic motion of another word, without rests, that it comes to, followed along the swept parameter, or the
        length where there is no sweep (above a table the force); of a device that is switched on at once only where no
        1:1 motion is stable.
    by_starts : tuple of FollowedMotion
        Where neither a 1:1 motion is stable nor such a motion reached: stable ones that a few starts come to. Above a
        table those with one impact are the first, by their formulae, whatever the device comes to from rest.
    sampled : tuple of OutcomeRange
        The outcomes at a few values of a sweep in which no 1:1 motion is stable, where there is neither a design point
        nor `over_sweep`.
    over_sweep : tuple of OutcomeRange
        The outcomes along the whole sweep, where an addition has looked for them.
    ramp_periods : float
        Forcing periods in which the amplitude rises, by an addition to the study; 0 where the whole force sets in at
        once.
    """

    from_rest: FromRest | None
    recovery: Recovery | None = None
    no_recovery: NoRecovery | None = None
    motion_from_rest: FollowedMotion | None = None
    by_starts: tuple[FollowedMotion, ...] = ()
    sampled: tuple[OutcomeRange, ...] = ()
    over_sweep: tuple[OutcomeRange, ...] = ()
    ramp_periods: float = 0.0

    __repr__ = brief

    @property
    def outcomes_over_sweep(self) -> tuple[FromRest, ...]:
        """The outcomes at values of the sweep, each once, in the order of the sweep."""
        outcomes: list[FromRest] = []
        for stretch in (*self.over_sweep, *self.sampled):
            if all(stretch.outcome.kind != other.kind for other in outcomes):
                outcomes.append(stretch.outcome)
        return tuple(outcomes)


def switched_on_at_once(solution: Solution, compiled: bool = False) -> SwitchedOn:
    """What a device comes to when the force sets in at full amplitude; takes some milliseconds.

    Parameters
    ----------
    solution : Solution
    compiled : bool
        Whether to compile the simulation.
    """
    if solution.design is None:
        return SwitchedOn(None, sampled=_sampled(solution, compiled))
    device = starting_device(solution)
    return switched_on(solution, from_rest(device, compiled), compiled, follow=not device.targets)


def starting_device(solution: Solution) -> StartingDevice:
    """The device of a solution for starts from rest, with the stable 1:1 motions of its design point as targets."""
    device, design = solution.device, solution.design
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    return StartingDevice(groups, Target.of(design.motions) if design is not None else (), device.period_ratio)


def switched_on(solution: Solution, end: FromRest, compiled: bool, follow: bool = True) -> SwitchedOn:
    """The record of a device with a design point, from its outcome `end` from rest.

    Parameters
    ----------
    solution : Solution
    end : FromRest
    compiled : bool
        Whether to compile the simulation.
    follow : bool
        Whether a motion of another word that it comes to is followed.
    """
    recovered = recovery_of(solution)
    recovery, no_recovery = (recovered, None) if isinstance(recovered, Recovery) else (None, recovered)
    motion = _motion_from_rest(solution, end) if follow else None
    device = starting_device(solution)
    others = _on_bottom(solution, device.groups, motion) if solution.on_table else ()
    if not device.targets and motion is None:
        others = _by_starts(solution, device.groups, compiled, others)
    return SwitchedOn(end, recovery, no_recovery, motion, others)


def _motion_from_rest(solution: Solution, end: FromRest) -> FollowedMotion | None:
    """The motion of another word that the device comes to, solved by its equations and followed."""
    cycle = end.cycle
    if solution.device.rubs:  # the equations of other words know no stops in flight
        return None
    if end.destination is not Destination.OTHER_MOTION or cycle is None:
        return None
    return _followed(solution, cycle.motion(0.0))


def _on_bottom(
    solution: Solution, groups: Groups[float], from_rest: FollowedMotion | None
) -> tuple[FollowedMotion, ...]:
    """The stable motions with one impact above a table, but that which the device comes to from rest."""
    from vireport.motions.atlas.one_impact import stable_on_table

    candidates = (_followed(solution, motion) for motion in stable_on_table(groups))
    motions = (followed for followed in candidates if followed is not None)
    return tuple(x for x in motions if from_rest is None or x.motion.distance(from_rest.motion) > SAME)


def _by_starts(
    solution: Solution, groups: Groups[float], compiled: bool, before: tuple[FollowedMotion, ...]
) -> tuple[FollowedMotion, ...]:
    """The motions `before`, and stable ones that some starts come to; not compiled, these only if there are none."""
    if solution.device.rubs or (before and not compiled):
        return before
    motions = [*before]
    for cycle in cycles_by_starts(groups, compiled):
        motion = cycle.motion(0.0)
        if cycle.sticks or any(motion.distance(other.motion, solution.horizontal) < SAME for other in motions):
            continue
        followed = _followed(solution, motion)
        motions += [followed] if followed is not None else []
        if motions and not compiled:
            break
    return tuple(motions)


def _followed(solution: Solution, motion: Motion) -> FollowedMotion | None:
    """A motion of the design point, known to some digits, solved by its equations and followed."""
    unswept = Parameter.AMPLITUDE if solution.on_table else Parameter.LENGTH
    swept = solution.sweep.parameter if solution.sweep is not None else unswept
    return followed_motion(solution.device, motion, DesignInput(swept))


def _sampled(solution: Solution, compiled: bool) -> tuple[OutcomeRange, ...]:
    """The outcomes at a few values of a sweep in which no 1:1 motion is stable."""
    sweep = solution.sweep
    if sweep is None or solution.stable_ranges:
        return ()
    from vireport.design.outcomes_from_rest import outcomes_at, sampled

    return sampled(sweep.start, sweep.end, partial(outcomes_at, solution.device, sweep.parameter, compiled=compiled))


FEW = 6, 48
"""Number of starts and of impacts of each without the compiler, some 4 ms in all: of 246 random devices with a stable
motion of another word they found it in 173, and as many random starts in 145 to 172."""

MANY = 64, 256
"""Number of starts and of impacts of each with the compiler."""


def cycles_by_starts(groups: Groups[float], compiled: bool) -> Iterator[SimulatedMotion]:
    """Periodic motions without rests that attract starts in flight, in the order in which they are met, and repeatedly.

    Parameters
    ----------
    groups : Groups
        Groups of the device, as numbers.
    compiled : bool
        Whether to compile the simulation, where numba is there, and to try more starts.
    """
    model, (count, impacts) = check_model(groups)[0], MANY if compiled else FEW
    for start in even_starts(groups.d, start_speed(groups.restitution), count):
        ball = Trajectory.begun(model, start.tolist(), impacts, compiled=compiled)
        if ball.moving and (cycle := attracting(ball)) is not None:
            yield cycle
