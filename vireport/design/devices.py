"""Devices whose inputs are off by multiples of their tolerances, and which of them have stable motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.motions.orbits import Orbits
from vireport.motions.pointwise import find_motions
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.groups import Restitution, Restitutions, by_wall, map_restitution
from vireport.physics.numbers import Arithmetic, magnitude
from vireport.scenario.blocks import Distribution
from vireport.scenario.parameters import DesignInput, Parameter

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

SEED = 0
"""Seed of the random devices, fixed so that equal inputs give an equal yield."""

DEVIATIONS = 3.0
"""Number of standard deviations of a normal distribution in a tolerance; devices beyond it are sorted out."""

FACTOR_OF = {
    DesignInput.CAPSULE_MASS: 0,
    DesignInput.AMPLITUDE: 0,
    DesignInput.LENGTH: 1,
    DesignInput.FREQUENCY: 1,
    DesignInput.INCLINATION: 2,
    DesignInput.RESTITUTION: 3,
    DesignInput.RESTITUTION_BOTTOM: 4,
    DesignInput.RESTITUTION_TOP: 5,
}
"""Index of the one factor of the groups that each input is part of: a box of inputs is a box of factors.

The factors are M/F, s f^2, sin(beta), r, and what the bottom's and the top's restitution have beyond r: d is the
product of the first two, gbar of the first and the third.
"""

OF_FREE_CAPSULE = FACTOR_OF | {DesignInput.CAPSULE_MASS: len(set(FACTOR_OF.values()))}
"""Index of the factor that each input of a free capsule is part of: gbar has (M + m)/F where d has M/F, so that M is a
separate factor."""


def factor_of(device: Device) -> Mapping[DesignInput, int]:
    """Indices of the factors that the inputs of a device are part of."""
    return OF_FREE_CAPSULE if device.recoils else FACTOR_OF


def stable_motions(devices: Device, slack: float = 0.0) -> tuple[Ints, Orbits]:
    """Find all stable admissible motions of devices, whose inputs are arrays (k,).

    Parameters
    ----------
    devices : Device
    slack : float
        Amount by which the trace [-] and the gap [x_c] of a motion may miss their limits.

    Returns
    -------
    ndarray of int (m,)
        Number of the device of each motion.
    Orbits
        The m motions.
    """
    groups = devices.groups(Parameter.LENGTH, devices.length_m)
    motions = find_motions(groups, devices.period_ratio)
    stable = motions.stable(map_restitution(groups.restitution, np.asarray), slack)
    return motions.cell[stable], motions.orbit.select(stable)


def devices_off(device: Device, half_widths: Mapping[DesignInput, Any], steps: Floats) -> Device:
    """Devices whose inputs are off by multiples of their tolerances, shape (tolerances, k).

    The inputs of the device, and the tolerances, may be arrays (k,).
    """
    tolerated = (varied for varied in DesignInput if varied not in RESTITUTIONS)
    changed = {varied: np.broadcast_to(getattr(device, varied), steps.shape[1]) for varied in tolerated}
    restitution = map_restitution(device.restitution, lambda r: np.broadcast_to(r, steps.shape[1]))
    for (varied, width), step in zip(half_widths.items(), steps, strict=True):
        if varied in changed:
            changed[varied] = changed[varied] + width * step
        else:
            restitution = _moved(restitution, varied, width * step)
    # Below 0 and beyond 90 degrees the capsule is the mirror image of one between, see `region_of`.
    inclination = magnitude(changed[DesignInput.INCLINATION])
    changed[DesignInput.INCLINATION] = np.minimum(inclination, 180 - inclination)
    return replace(device.with_values(changed), restitution=restitution)


def _moved(restitution: Restitution, varied: DesignInput, off: Arithmetic) -> Any:
    """A restitution that differs by `off` at both membranes or at one."""
    if varied is DesignInput.RESTITUTION:
        return map_restitution(restitution, lambda r: r + off)
    bottom, top = by_wall(restitution)
    if varied is DesignInput.RESTITUTION_BOTTOM:
        return Restitutions(bottom + off, top)
    return Restitutions(bottom, top + off)


def sample_steps(inputs: int, distribution: Distribution, samples: int) -> Floats:
    """Draw deviations of the inputs of random devices, over their tolerances: (inputs, samples), from -1 to 1.

    Scrambled Sobol points vary less than independent ones, for which the interval of a yield holds.
    """
    from scipy.special import ndtr, ndtri  # type: ignore[import-untyped]
    from scipy.stats import qmc  # type: ignore[import-untyped]

    # A power of two of them is balanced in every input, which is why no other number of samples is allowed.
    points = qmc.Sobol(inputs, rng=np.random.default_rng(SEED)).random(samples).T
    if distribution is Distribution.NORMAL:
        # The normal distribution cut off at the tolerance: between its tails the points are spread evenly in
        # probability.
        below = ndtr(-DEVIATIONS)
        return np.asarray(ndtri(below + points * (1 - 2 * below)) / DEVIATIONS)
    return np.asarray(2 * points - 1)
