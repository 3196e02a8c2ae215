"""Many designs at once: their objective, and their slacks, positive where a limit is met."""

from __future__ import annotations

from itertools import product
from operator import itemgetter

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.design.devices import devices_off, factor_of
from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.stability import lap_decay
from vireport.optimise.problem import Problem, objectives
from vireport.physics.groups import map_restitution
from vireport.physics.numbers import magnitude
from vireport.scenario.parameters import DesignInput
from vireport.study.judging.designs import Designs, extreme

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

OF_MOTION = 2
"""Slacks in front of those of the limits: of stability, and of the gap to a membrane."""

AT_FOLD = 2.5
"""Power of a trace's distance from a fold, which itself goes with the root of the inputs' distance. With more than 2 a
search that takes the power for linear nears the fold from inside; beyond it there is no motion to return by."""


class CellValues(Struct, frozen=True, eq=False):
    """Stability, objective and slacks of many designs, arrays with a row for each.

    Attributes
    ----------
    stable : ndarray of bool
        Whether there is a stable motion.
    value : ndarray
        The signed objective, that of the worst stable motion; NaN where there is none, or where it is a margin.
    slack : ndarray, shape (cells, OF_MOTION + limits)
        Distance of each quantity from its limit, over the limit, in the worst stable motion; negative where the limit
        is not met. The first two are for stability and the gap to a membrane.
    """

    stable: Mask
    value: Floats
    slack: Floats


def evaluate(problem: Problem, t: Floats) -> CellValues:
    """Evaluate designs t, shape (cells, inputs), by the closed form, as exactly as doubles allow.

    Complex ones give derivatives, see `motions.differentiated_motions`.
    """
    designs = problem.designs(t)
    with np.errstate(all="ignore"):
        orbit = designs.motions.orbit.select(designs.rows)
        gap = np.minimum(designs.motions.wall_gap[designs.rows], orbit.d)
        columns = objectives(orbit.velocity_bottom, gap, *designs.generated, designs.period_s)
        slack = [designs.worst(part[designs.rows], True) for part in _slack(designs)]
        slack += [quantity.slack(designs, limit) for quantity, limit in problem.limits]
    # A margin has no value here: it needs critical points, which are followed for single designs only.
    nothing = np.full_like(slack[0], np.nan)
    number = problem.of_inputs(designs.device, t)
    if number is not None:
        value = np.broadcast_to(problem.sign * number, designs.count)
    else:
        chosen = columns.get(problem.objective)
        value = nothing if chosen is None else designs.worst(problem.sign * chosen, True)
    # `worst` gives NaN where a design has no stable motion, which is the one test of it for all columns.
    stable = np.isfinite(slack[0])
    value = np.where(stable, value, np.nan)
    return CellValues(stable, value, np.where(stable[:, None], np.stack(slack, axis=1), np.nan))


def corner_slack(problem: Problem, t: Floats, share: float = 1.0) -> Floats:
    """How far the devices at the corners of the tolerances are from the end of stable motion, shape (cells, corners).

    That is the lesser of the slacks of stability and gap, as in `CellValues`, of the motion for which it is largest;
    negative where no motion is stable, NaN without a motion. If not all corners have stable motion, not every device
    within the tolerances has.

    Parameters
    ----------
    problem : Problem
    t : ndarray, shape (cells, inputs)
        May be complex, see `evaluate`.
    share : float
        Share of the tolerances.
    """
    designs = problem.designs(t)
    widths = problem.half_widths(designs)
    of_factor = factor_of(designs.device)
    factors = sorted({of_factor[varied] for varied in widths})
    ends = np.array(list(product((-share, share), repeat=len(factors)))).T if widths else np.empty((0, 0))
    slack = []
    for end in ends.T:
        # Inputs of one factor move d or gbar alike, and the force moves them the other way: the corners are those of
        # a few factors instead of six inputs.
        steps = np.array([end[factors.index(of_factor[x])] * (-1 if x is DesignInput.AMPLITUDE else 1) for x in widths])
        corner = replace(designs, device=devices_off(designs.device, widths, np.tile(steps[:, None], len(t))))
        with np.errstate(all="ignore"):
            # One stable motion is enough for a device to work: the best of its motions counts, each by the worse of
            # its slacks.
            slack.append(extreme(np.minimum(*_slack(corner)), corner.motions.cell, len(t), np.maximum))
    return np.stack(slack, axis=1) if slack else np.empty((len(t), 0))


def _slack(designs: Designs) -> tuple[Floats, Floats]:
    """Slacks of motions: how far they are from losing their stability, and from grazing.

    The first is by the trace over 1 + r^4, with a power of its distance from a fold, see `AT_FOLD`; the second is the
    gap over d.
    """
    motions = designs.motions
    share = motions.trace / TRACE_LEVELS[Event.FOLD](
        lap_decay(map_restitution(designs.restitution, itemgetter(motions.cell)))
    )
    to_fold = (1 - share) * magnitude(1 - share) ** (AT_FOLD - 1)
    return np.minimum(1 + share, to_fold), motions.wall_gap / motions.orbit.d
