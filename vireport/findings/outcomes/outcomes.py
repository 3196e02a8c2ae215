"""What starts come to other than a ball at rest with the whole force at once, gathered for one scenario."""

from __future__ import annotations

from functools import partial
from math import fsum
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import brief
from vireport.design.solution import Solution
from vireport.design.switched_on import SwitchedOn, starting_device, switched_on
from vireport.findings.outcomes.keys import DisturbancesBlock
from vireport.scenario.keys import block_of, value_at
from vireport.scenario.parameters import Parameter

if TYPE_CHECKING:
    from vireport.design.outcomes_from_rest import OutcomeRange
    from vireport.findings.outcomes.attracting import AttractingMotions
    from vireport.findings.outcomes.basin import Basins
    from vireport.findings.outcomes.windows import Window
    from vireport.findings.outcomes.withstood import Withstood
    from vireport.study.study import Study

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


class Outcomes(Struct, frozen=True, eq=False):
    """What starts other than a ball at rest come to; what was not computed is None.

    Attributes
    ----------
    share : float or None
        Share of the moments at which the force may set in from which a 1:1 motion is reached.
    ramp : Ramp or None
        Where switching on at once does not reach it, though one is stable.
    window : Window or None
        How far around the design point the outcome stays the same.
    withstood : Withstood or None
        The least shock and the jitter of the stable 1:1 motions at the design point.
    attracting : AttractingMotions or None
        The stable motions of the design point, of any word, beside one another.
    basins : Basins or None
        Which impacts on the bottom membrane lead to which motion at the design point.
    """

    share: float | None = None
    ramp: Ramp | None = None
    window: Window | None = None
    withstood: Withstood | None = None
    attracting: AttractingMotions | None = None
    basins: Basins | None = None

    __repr__ = brief

    @property
    def narrow(self) -> bool:
        """Whether the outcome changes within common manufacturing tolerances."""
        window = self.window
        nearest = window.nearest if window is not None else None
        return window is not None and nearest is not None and window.distance(nearest) < NARROW * abs(window.value)

    @property
    def values_over_sweep(self) -> int:
        """Values along a sweep at which the outcome is looked for, before edges are located."""
        from vireport.findings.outcomes.windows import SWEEP_VALUES

        return SWEEP_VALUES

    @property
    def withstood_in_use(self) -> Withstood | None:
        """What the stable 1:1 motions withstand or, where there are none, the motion that is reached from rest."""
        # Without a stable 1:1 motion there is still something that the user's device does, and that shocks can end.
        if self.withstood is not None or self.attracting is None:
            return self.withstood
        return self.attracting.withstood(self.attracting.motions_from_rest)


def switched_on_by(
    solution: Solution, block: DisturbancesBlock, compiled: bool = False, windows: bool = False
) -> tuple[SwitchedOn, Outcomes]:
    """Switch a device with a design point on as a block says, at any moment.

    Parameters
    ----------
    solution : Solution
    block : DisturbancesBlock
    compiled : bool
        Whether to compile the simulation.
    windows : bool
        Whether to find how far the outcome stays, around the design point and along the sweep.
    """
    from vireport.findings.outcomes.moments import RAMPS, outcome_of, outcomes_by_moment, ramp_that_helps

    solution.device.constant_restitution("what it does when the force sets in at any moment")
    device = starting_device(solution)
    outcomes = outcomes_by_moment(device, block.ramp_periods, compiled)
    end, ramp, around = outcome_of(outcomes), None, None
    if device.targets and not end.is_one_to_one:
        # Only then: each length is tried at 32 moments, and eight lengths take 256 balls.
        ramp = Ramp(ramp_that_helps(device, compiled), RAMPS[-1])
    if windows:
        from vireport.findings.outcomes.windows import window_of

        around = window_of(solution, compiled)
    # What is left of 1 has the roundings of the shares of several releases: all together may exceed it.
    share = min(fsum(part for part, outcome in outcomes if outcome.is_one_to_one), 1.0)
    strip = outcomes_along(solution, compiled) if windows else ()
    answer = replace(switched_on(solution, end, compiled), over_sweep=strip, ramp_periods=block.ramp_periods)
    return answer, Outcomes(share, ramp, around)


def outcomes_along(solution: Solution, compiled: bool) -> tuple[OutcomeRange, ...]:
    """The outcomes of switching on along the sweep; () where there is none."""
    sweep = solution.sweep
    if sweep is None:
        return ()
    from vireport.design.outcomes_from_rest import outcomes_at
    from vireport.findings.outcomes.windows import over_sweep

    return over_sweep(sweep.start, sweep.end, partial(outcomes_at, solution.device, sweep.parameter, compiled=compiled))


def with_shocks(outcomes: Outcomes, study: Study, shocks: bool) -> Outcomes:
    """Add the least shock that the stable 1:1 motions withstand, where it is asked for."""
    from vireport.findings.outcomes.withstood import withstood_by

    block = block_of(study.scenario, "disturbances", DisturbancesBlock)
    kicks = (block.jitter_m_s or 0.0, block.jitter_restitution or 0.0) if block is not None else (0.0, 0.0)
    return replace(outcomes, withstood=withstood_by(study.solution, shocks, *kicks, required_shock(study)))


def with_coexistence(outcomes: Outcomes, study: Study) -> Outcomes:
    """Add the stable motions of the design point, where the device has been switched on."""
    from vireport.findings.outcomes.attracting import attracting_motions

    if study.switched_on is None:
        return outcomes
    inputs = study.solution, study.switched_on, study.atlas, outcomes.withstood
    return replace(outcomes, attracting=attracting_motions(*inputs, required_shock(study)))


def with_basins(outcomes: Outcomes, study: Study) -> Outcomes:
    """Add the basins on the section of impacts, where the stable motions are known."""
    from vireport.findings.outcomes.basin import basins_of

    if outcomes.attracting is None:
        return outcomes
    device = study.solution.device
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    attracting = outcomes.attracting
    return replace(outcomes, basins=basins_of(groups, attracting.recognised, attracting.velocity_unit))


def required_shock(study: Study) -> float | None:
    """The shock that must be survived [m/s]; None where none is required."""
    least: float | None = value_at(study.scenario, "requirements.survives_shock_m_s")
    return least
