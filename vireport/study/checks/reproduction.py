"""The stable motion that a report is about, found again by the simulation from a start next to it."""

from __future__ import annotations

from math import ceil, log

import numpy as np
from msgspec import Struct

from vireport.design.solution import Solution, stable_motion
from vireport.motions.stability import eigenvalues
from vireport.physics.numbers import wrapped
from vireport.simulation.events import BOTTOM, TOP, check_model, follow_one
from vireport.simulation.kernel import PHASE, VELOCITY, WALL

ASIDE = 1e-3
"""Share of the impact velocity by which the simulation starts beside the motion."""

REPRODUCED = 1e-9
"""Distance from the motion, in velocity [y_c] and phase [rad], up to which it counts as found again."""

SMALL = 1e-3
"""What is left of `REPRODUCED` at the end, where two equal multipliers let the distance grow at first."""

MOST_PERIODS = 2000
"""Periods of the motion that are simulated at the most: a tenth of a second, interpreted."""


class Reproduction(Struct, frozen=True):
    """How near a simulation came to the analytic motion.

    Attributes
    ----------
    value : float
        Value of the swept parameter at which the motion is.
    periods : int
        Periods of the motion that were simulated, one impact on each membrane in each.
    needed : int
        Periods after which, by the multipliers, the initial distance from the motion has died out; at most
        `MOST_PERIODS` are simulated.
    velocity_difference, phase_difference : float
        At the last impact on the bottom membrane [y_c, rad].
    same_impacts : bool
        Whether the ball struck the membranes in turn all the time, once each in every period.
    """

    value: float
    periods: int
    needed: int
    velocity_difference: float
    phase_difference: float
    same_impacts: bool

    @property
    def decided(self) -> bool:
        """Whether enough periods were simulated for the initial distance to die out."""
        return self.periods == self.needed

    @property
    def passed(self) -> bool:
        """Whether the simulation came to the motion and stayed on it."""
        return self.same_impacts and max(self.velocity_difference, self.phase_difference) <= REPRODUCED


def reproduce(solution: Solution) -> Reproduction | None:
    """Simulate the stable motion of the design point, or one amid the first stable range, from a start next to it.

    The simulation is interpreted: it takes milliseconds, and gives the same numbers where numba is installed. None
    where there is no stable admissible motion.
    """
    chosen = stable_motion(solution)
    if chosen is None:
        return None
    design, row = chosen
    motions, groups = design.motions, solution.device.groups(design.parameter, design.value)
    decay = float(np.ravel(motions.select([row]).decay)[0])
    needed = _periods_to_die_out(float(motions.trace[row]), float(motions.discriminant[row]), decay)
    periods = min(needed, MOST_PERIODS)
    velocity, phase = float(motions.velocity_bottom[row]), float(motions.phi_bottom[row])
    model = check_model(groups._replace(d=motions.d[row], gbar=motions.gbar[row]))[0]
    rows, _ = follow_one(model, (BOTTOM, 0.0, velocity * (1 + ASIDE), phase), 2 * periods, compiled=False)
    return Reproduction(
        value=design.value,
        periods=periods,
        needed=needed,
        velocity_difference=abs(float(rows[-1, VELOCITY]) - velocity),
        phase_difference=abs(wrapped(float(rows[-1, PHASE]) - phase)),
        same_impacts=np.array_equal(rows[:, WALL], np.resize([BOTTOM, TOP], 2 * periods + 1)),
    )


def _periods_to_die_out(trace: float, discriminant: float, decay: float) -> int:
    """Periods in which the larger multiplier reduces the distance from the motion to a small share of `REPRODUCED`."""
    largest = decay if discriminant < 0 else max(map(abs, eigenvalues(trace, decay)))
    return 2 + ceil(log(SMALL * REPRODUCED / ASIDE) / log(max(largest, SMALL)))
