"""The outcomes of balls that start from rest, at several values of an input or in many devices."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from operator import itemgetter

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.design.from_rest import FromRest, StartingDevice, from_rest, targets_of
from vireport.motions.pointwise import PointwiseMotions, find_motions
from vireport.motions.stability import lap_decay
from vireport.physics.device import Device
from vireport.physics.groups import Groups, map_restitution
from vireport.scenario.parameters import Parameter, ScalarInput
from vireport.simulation.kernel import TURN

Floats = NDArray[np.float64]

OutcomesAt = Callable[[Floats], Iterable[FromRest]]
"""A function from values of an input to the outcomes there, each computed when it is drawn."""

SAMPLED = 5
"""Number of values of a sweep at which a ball is always followed from rest if no 1:1 motion is stable: 40 ms each
without the compiler."""


class OutcomeRange(Struct, frozen=True):
    """An interval of the sweep with one outcome of switching on, as far as the values tried show.

    Attributes
    ----------
    start, end : float
        Ends of the interval; equal where a single value was tried.
    outcome : FromRest
    """

    start: float
    end: float
    outcome: FromRest


def groups_at(device: Device, varied: ScalarInput, values: Floats) -> Groups[Floats]:
    """The groups of a device at each of some values of an input."""
    several = device.with_values({varied: values})
    groups = several.groups(Parameter.LENGTH, several.length_m)
    return groups.map_numbers(lambda group: np.broadcast_to(np.asarray(group, dtype=float), values.shape))


def outcomes_at(device: Device, varied: ScalarInput, values: Floats, compiled: bool) -> Iterator[FromRest]:
    """The outcomes of a device that starts from rest at each of some values of an input, one after the other."""
    # The 1:1 motions of all values together take hardly longer than those of one. Balls are followed one by one: who
    # looks for the first change of the outcome stops there.
    groups = groups_at(device, varied, values)
    return outcomes_of(groups, find_motions(groups, device.period_ratio), device.period_ratio, compiled)


def outcomes_of(groups: Groups[Floats], motions: PointwiseMotions, ratio: int, compiled: bool) -> Iterator[FromRest]:
    """The motions or states in which the balls of many devices end from rest, one after the other.

    Parameters
    ----------
    groups : Groups
        Arrays of one length.
    motions : PointwiseMotions
        The 1:1 motions of these devices.
    ratio : int
        Forcing periods of a 1:1 motion.
    compiled : bool
        Whether to compile the simulation, where numba is there.
    """
    stable = motions.stable(groups.restitution)
    orbit, cell, trace = motions.orbit.select(stable), motions.cell[stable], motions.trace[stable]
    phase, decay = np.mod(orbit.phi, TURN), lap_decay(map_restitution(groups.restitution, itemgetter(cell)))
    targets = targets_of(phase, orbit.velocity_bottom, trace, motions.wall_gap[stable], decay)
    for i in range(len(groups.d)):
        one = groups.map_numbers(itemgetter(i)).as_floats()
        yield from_rest(StartingDevice(one, [targets[k] for k in np.flatnonzero(cell == i)], ratio), compiled)


def sampled(start: float, end: float, outcomes: OutcomesAt) -> tuple[OutcomeRange, ...]:
    """The outcomes at a few values of a sweep, its ends among them."""
    values = np.linspace(start, end, SAMPLED)
    return tuple(map(OutcomeRange, values.tolist(), values.tolist(), outcomes(values)))
