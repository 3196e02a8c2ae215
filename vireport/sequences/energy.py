"""What the impacts of a family generate, each, on average, and in a second."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vireport.physics import Membrane, generated_voltage
from vireport.scenario import Parameter
from vireport.sequences.families import Family

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Generation:
    """What the motions of a family generate.

    Attributes
    ----------
    impacts_v : ndarray (n, N)
        U_imp - Uin of each impact of each motion [V], Eqs. (5.2)-(5.5).
    average_v : ndarray (n,)
        U_ave, the mean over the impacts, Eq. (5.1) [V].
    impacts_per_s : ndarray (n,)
        N f/k [1/s].
    """

    impacts_v: Floats
    average_v: Floats
    impacts_per_s: Floats

    @property
    def per_second_v(self) -> Floats:
        """Sum of U_imp - Uin over the impacts of a second [V/s]."""
        return self.average_v * self.impacts_per_s


def generation(family: Family, membrane: Membrane) -> Generation:
    """Evaluate Eqs. (5.1)-(5.5) for the motions of a family."""
    sweep = family.sweep
    unit = np.broadcast_to(sweep.device.velocity_unit(sweep.parameter, family.sweep_value), len(family.sweep_value))
    impacts = generated_voltage(unit[:, None] * family.velocity, membrane)
    return Generation(impacts, impacts.mean(axis=1), impact_rate(family))


def impact_rate(family: Family) -> Floats:
    """Impacts in a second of the motions of a family, N f/k, (n,) [1/s]."""
    at = family.sweep.device.at(family.sweep.parameter, family.sweep_value)
    frequency = np.broadcast_to(at[Parameter.FREQUENCY], len(family.x))
    return np.asarray(len(family.sequence) / family.sequence.periods * frequency)
