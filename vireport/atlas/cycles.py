"""Between simulated cycles and motions: the motion of a cycle, and the portrait of a motion as of a simulated one."""

from __future__ import annotations

from math import nan, pi
from typing import TYPE_CHECKING

import numpy as np

from vireport.motions.motion import Motion
from vireport.motions.periodicity import Model, residuals, trace
from vireport.motions.stability import multipliers
from vireport.physics.word import Word
from vireport.simulation.attractors import Attractor, Outcome
from vireport.simulation.cycles import Cycle
from vireport.simulation.events import check_model
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, VELOCITY, WALL

if TYPE_CHECKING:
    from vireport.simulation.trajectories import Portrait


def portrait_of(model: Model, motion: Motion, label: str) -> Portrait:
    """The path of a motion over its period, in closed form, whether it is stable or not.

    Parameters
    ----------
    model : Model
    motion : Motion
    label : str
        See `Portrait`.
    """
    from vireport.simulation.trajectories import Portrait, path

    word, count = motion.word, len(motion.word)
    x = [*motion.velocity.tolist(), *motion.time.tolist(), motion.coordinate]
    wall = np.array(word.walls, dtype=np.int8)
    flight = np.diff(motion.time, prepend=motion.time[-1] - 2 * word.periods)
    at_rest = not motion.velocity.all()  # where the trace has a pole
    groups = model.groups(motion.coordinate).as_floats()
    pair = multipliers(np.array([nan if at_rest else trace(word, x, model)]), model.determinant(word.walls, x[-1]))[0]
    cycle = Cycle(
        word=word.canonical().letters,
        period=word.periods,
        wall=wall,
        phase=motion.phase,
        flight=flight,
        velocity=motion.velocity,
        residual=max(map(abs, residuals(word, x, model))),
        multipliers=(complex(pair[0]), complex(pair[1])),
    )
    d, gbar, *_ = groups
    rows = np.zeros((count + 1, RIDING + 1))
    for column, values in ((WALL, wall), (PHASE, motion.phase), (FLIGHT, flight), (VELOCITY, motion.velocity)):
        rows[:, column] = np.append(values, values[0])
    attractor = Attractor(Outcome.PERIODIC, cycle, nan if at_rest else cycle.lyapunov, 0.0, count)
    drawn = path(check_model(groups)[0], rows)
    return Portrait(label, d, gbar, model.r, attractor, float(motion.phase[0]), *drawn, groups.harmonics)


def motion_of_cycle(cycle: Cycle, coordinate: float) -> Motion:
    """A periodic motion that was simulated."""
    word = Word(tuple(int(wall) for wall in cycle.wall), cycle.period)
    time = cycle.phase[0] / pi + np.concatenate([[0.0], np.cumsum(cycle.flight[1:])])
    return Motion(word, np.array(cycle.velocity), time, coordinate)
