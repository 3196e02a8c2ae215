"""How surely a measured device has stable 1:1 motion: devices as the errors of its inputs allow, correlations kept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from vireport.base.shares import share_interval
from vireport.design.devices import Floats, devices_off, stable_motions
from vireport.design.tolerances import DEVIATIONS, sample_steps
from vireport.physics.device import Device
from vireport.scenario.blocks import Distribution
from vireport.scenario.parameters import DesignInput

SAMPLES, FEWER = 4096, 1024
"""Devices of which the share is told, and those that a further measurement is tried on; powers of two."""

SURE = 0.99
"""Share from which, or up to one less which, it can be said."""

HALVINGS = 8
"""Of the standard error that a further measurement may have, from what the input has now."""


class MeasuredShare(Struct, frozen=True):
    """The share of devices with stable 1:1 motion among those that a measurement allows.

    Attributes
    ----------
    stable, samples : int
        Devices with stable motion, and all.
    low, high : float
        Its 95 % interval by Clopper and Pearson.
    costly : DesignInput or None
        The input whose error costs most, where it cannot be said.
    needed : float or None
        Standard error with which that input would have to be measured for it to be said, in its unit; None where it
        would not do alone.
    """

    stable: int
    samples: int
    low: float
    high: float
    costly: DesignInput | None = None
    needed: float | None = None

    @property
    def share(self) -> float:
        """Of the samples."""
        return self.stable / self.samples

    @property
    def said(self) -> bool:
        """Whether it can be said: nearly all of them, or nearly none."""
        return not 1 - SURE < self.share < SURE


def measured_share(device: Device, inputs: Sequence[DesignInput], covariance: Floats) -> MeasuredShare:
    """Of devices as a measurement allows, the share with stable 1:1 motion, and what should be measured better.

    Parameters
    ----------
    device : Device
        As it was identified; harmonics of its force are held at what they are.
    inputs : sequence of DesignInput
        Those that are uncertain.
    covariance : ndarray, shape (k, k)
        Of these, in their units: normal errors, correlated as they are.
    """
    count = _stable(device, inputs, covariance, SAMPLES)
    _, low, high = share_interval(count, SAMPLES)
    found = MeasuredShare(count, SAMPLES, low, high)
    if found.said:
        return found
    # What remains where an input were known exactly.
    gains = [
        abs(_stable(device, inputs, _measured(covariance, k, 0.0), FEWER) / FEWER - 0.5) for k in range(len(inputs))
    ]
    best = int(np.argmax(gains))
    return MeasuredShare(count, SAMPLES, low, high, inputs[best], _needed(device, inputs, covariance, best))


def _stable(device: Device, inputs: Sequence[DesignInput], covariance: Floats, samples: int) -> int:
    """How many of some devices have stable motion."""
    values, vectors = np.linalg.eigh(covariance)
    steps = DEVIATIONS * sample_steps(len(inputs), Distribution.NORMAL, samples)
    off = vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * steps)
    cell, _ = stable_motions(devices_off(device, dict.fromkeys(inputs, 1.0), off))
    return len(np.unique(cell))


def _measured(covariance: Floats, k: int, error: float) -> Floats:
    """Covariance after one input was measured once more, with a standard error."""
    column = covariance[:, k]
    return np.asarray(covariance - np.outer(column, column) / (covariance[k, k] + error**2))


def _needed(device: Device, inputs: Sequence[DesignInput], covariance: Floats, k: int) -> float | None:
    """Standard error of a further measurement of an input with which it can be said."""
    error = float(np.sqrt(covariance[k, k]))
    for _ in range(HALVINGS):
        share = _stable(device, inputs, _measured(covariance, k, error), FEWER) / FEWER
        if not 1 - SURE < share < SURE:
            return error
        error /= 2
    return None
