"""Probability that a measured device has stable 1:1 motion, by devices drawn from the covariance of its inputs."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, sqrt

import numpy as np
from msgspec import Struct

from vireport.base.records import ResultsBlock
from vireport.base.shares import share_interval
from vireport.design.devices import DEVIATIONS, Floats, devices_off, sample_steps, stable_motions
from vireport.design.margins import Margin
from vireport.design.point import design_point
from vireport.measurement.identification import Fitted
from vireport.measurement.inquiry import Identification
from vireport.measurement.shaker import ShakerMotion
from vireport.physics.device import Device
from vireport.physics.groups import stated
from vireport.scenario.blocks import Distribution
from vireport.scenario.parameters import LARGEST_RESTITUTION, DesignInput

SAMPLES, FEWER = 4096, 1024
"""Numbers of devices for the share that is stated, and for trying a further measurement; powers of two."""

SURE = 0.99
"""Share of devices with stable motion from which a device is said to have it; below 1 - SURE it is said not to."""

HALVINGS = 8
"""How often the standard error of an input is halved in search of the one that a further measurement needs."""


class MeasuredShare(ResultsBlock, frozen=True):
    """The share of devices with stable 1:1 motion among those that a measurement allows.

    Attributes
    ----------
    stable, samples
        devices with stable motion, and all
    low, high : 1
        95 % interval of their share by Clopper and Pearson
    costly
        the input whose error costs most, where stability cannot be said; else null
    needed
        standard error with which that input would have to be measured for it to be said, in its unit; null where it
        would not do alone
    """

    stable: int
    samples: int
    low: float
    high: float
    costly: DesignInput | None = None
    needed: float | None = None

    @property
    def share(self) -> float:
        """Share of stable devices among the samples."""
        return self.stable / self.samples

    @property
    def said(self) -> bool:
        """Whether stability can be stated: nearly all devices have stable motion, or nearly none."""
        return not 1 - SURE < self.share < SURE


class HeldHarmonics(Struct, frozen=True, eq=False):
    """The error of an end of stable motion that is left out because harmonics are held at their measured values.

    Attributes
    ----------
    end : Margin or None
        Margin to the nearest end of stable motion; None where none was located.
    error : float or None
        Standard error of the end from the errors of the harmonics, in the unit of its input; None where these were not
        measured, or there are no derivatives.
    """

    end: Margin | None
    error: float | None


def measured_share(device: Device, inputs: Sequence[DesignInput], covariance: Floats) -> MeasuredShare:
    """Estimate the share of stable devices among those that a measurement allows, and what to measure better.

    Parameters
    ----------
    device : Device
        The device as identified; harmonics of its force are held.
    inputs : sequence of DesignInput
        The k inputs that are uncertain.
    covariance : ndarray, shape (k, k)
        Covariance of their normal errors, in their units.
    """
    count = _stable(device, inputs, covariance, SAMPLES)
    _, low, high = share_interval(count, SAMPLES)
    share = MeasuredShare(count, SAMPLES, low, high)
    if share.said:
        return share
    # What remains if an input had no error.
    gains = [
        abs(_stable(device, inputs, _measured(covariance, k, 0.0), FEWER) / FEWER - 0.5) for k in range(len(inputs))
    ]
    best = int(np.argmax(gains))
    return MeasuredShare(count, SAMPLES, low, high, inputs[best], _needed(device, inputs, covariance, best))


def share_that_fits(answer: Identification) -> MeasuredShare | None:
    """Estimate the share of stable devices among those that a record of impacts allows; None without a fit.

    Parameters
    ----------
    answer : Identification
    """
    if not answer.misfit.accepted or not isinstance(answer.fit, Fitted):
        return None
    fitted = answer.fit.adjusted
    rows = [k for k, x in enumerate(fitted.unknowns) if x.design_input is not None]
    inputs = [x.design_input for x in fitted.unknowns if x.design_input is not None]
    device = fitted.model.device
    # Beyond what inputs can be, a restitution of 0 or 1 for one, devices have no meaning.
    if not inputs or not np.isfinite(fitted.covariance).all():
        return None
    for row, varied in zip(rows, inputs, strict=True):
        low, high = varied.limits
        # An angle beyond its limits is another within them.
        reach = 0.0 if varied is DesignInput.INCLINATION else 3 * float(np.sqrt(fitted.covariance[row, row]))
        if not (low <= device.value_of(varied) - reach and device.value_of(varied) + reach <= high):
            return None
    return measured_share(device, inputs, fitted.covariance[np.ix_(rows, rows)])


def held_harmonics(answer: Identification, shaker: ShakerMotion | None) -> HeldHarmonics | None:
    """Propagate the errors of measured harmonics, which are held, to the nearest end of stable motion.

    None of a sine, and where nothing is identified.

    Parameters
    ----------
    answer : Identification
    shaker : ShakerMotion or None
        The motion of the shaker as measured.
    """
    if not answer.misfit.accepted or not isinstance(answer.fit, Fitted):
        return None
    device = answer.fit.adjusted.model.device
    if not device.harmonics:
        return None
    end = design_point(device, None).nearest if _has_theory(device) else None
    if end is None or shaker is None:
        return HeldHarmonics(end, None)
    # The parts of one harmonic, of cosine and sine, are off independently and alike.
    slopes_of = [
        (harmonic, end.by_harmonics.get(harmonic.order)) for harmonic in shaker.harmonics if harmonic.significant
    ]
    moved = [harmonic.percent_error / 100 * hypot(*slopes) for harmonic, slopes in slopes_of if slopes is not None]
    return HeldHarmonics(end, sqrt(sum(x * x for x in moved)) if len(moved) == len(slopes_of) else None)


def _has_theory(device: Device) -> bool:
    """Whether a device as it was fitted can be solved: errors of times may make a restitution of 1 a larger one."""
    inputs = ((float(device.value_of(varied)), varied.limits) for varied in device.inputs)
    lossy = all(r <= LARGEST_RESTITUTION for r in stated(device.restitution))
    return lossy and all(low <= value <= high for value, (low, high) in inputs)


def _stable(device: Device, inputs: Sequence[DesignInput], covariance: Floats, samples: int) -> int:
    """Number of devices with stable motion in a sample drawn from a covariance."""
    values, vectors = np.linalg.eigh(covariance)
    steps = DEVIATIONS * sample_steps(len(inputs), Distribution.NORMAL, samples)
    off = vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * steps)
    cell, _ = stable_motions(devices_off(device, dict.fromkeys(inputs, 1.0), off))
    return len(np.unique(cell))


def _measured(covariance: Floats, k: int, error: float) -> Floats:
    """Covariance of the inputs after input k was measured once more, with a standard error."""
    column = covariance[:, k]
    return np.asarray(covariance - np.outer(column, column) / (covariance[k, k] + error**2))


def _needed(device: Device, inputs: Sequence[DesignInput], covariance: Floats, k: int) -> float | None:
    """Standard error with which input k must be measured once more for stability to be stated; None if none will do."""
    error = float(np.sqrt(covariance[k, k]))
    for _ in range(HALVINGS):
        share = _stable(device, inputs, _measured(covariance, k, error), FEWER) / FEWER
        if not 1 - SURE < share < SURE:
            return error
        error /= 2
    return None
