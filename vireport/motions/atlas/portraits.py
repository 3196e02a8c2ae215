"""Portraits of periodic motions from their closed form, stable or not, like those of simulated motions."""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING

import numpy as np

from vireport.motions.periodicity import Model, residuals, trace
from vireport.physics.motion import Motion, multipliers
from vireport.simulation.attractors import Attractor, Outcome
from vireport.simulation.cycles import SimulatedMotion
from vireport.simulation.events import check_model
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, VELOCITY, WALL
from vireport.simulation.trajectories import Portrait, path

if TYPE_CHECKING:
    from vireport.simulation.trajectories import Portrait


def portrait_of(model: Model, motion: Motion, label: str) -> Portrait:
    """The portrait of a motion over its period, in closed form.

    Parameters
    ----------
    model : Model
        Groups over the sweep.
    motion : Motion
        Stable or not.
    label : str
        See `Portrait`.
    """
    word, count = motion.word, len(motion.word)
    x = [*motion.velocity.tolist(), *motion.time.tolist(), motion.coordinate]
    flight = np.diff(motion.time, prepend=motion.time[-1] - 2 * word.periods)
    at_rest = not motion.velocity.all()  # where the trace has a pole
    groups = model.groups(motion.coordinate).as_floats()
    determinant = model.determinant(word.walls, x[-1])
    larger, smaller = multipliers(nan if at_rest else trace(word, x, model), determinant).tolist()
    d, gbar, *_ = groups
    rows = np.zeros((count + 1, RIDING + 1))
    for column, values in ((WALL, word.walls), (PHASE, motion.phase), (FLIGHT, flight), (VELOCITY, motion.velocity)):
        rows[:, column] = np.append(values, values[0])
    residual = max(map(abs, residuals(word, x, model)))
    cycle = SimulatedMotion(word.canonical().letters, rows[:-1], residual, (larger, smaller))
    attractor = Attractor(Outcome.PERIODIC, cycle, nan if at_rest else cycle.lyapunov, 0.0, count)
    drawn = path(check_model(groups)[0], rows)
    return Portrait(label, d, gbar, model.r, attractor, float(motion.phase[0]), *drawn, groups.harmonics)
