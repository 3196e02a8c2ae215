"""Identification of a device from a record of impacts: from the scenario and its tolerances to the answer."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np
from msgspec import Struct

from vireport.base.errors import UsageError
from vireport.base.progress import Progress, portion
from vireport.measurement.adjustment import Inquiry, Prior
from vireport.measurement.flights import RESTITUTIONS, ClockedDevice, MeasuredImpacts, Unknown
from vireport.measurement.identification import Fitted, NoFit, Unfit, Unidentifiable, exact_below, fit
from vireport.measurement.misfit import Misfit, judged
from vireport.measurement.records import Record
from vireport.measurement.rounding import Rounding, rounding_of
from vireport.physics.device import Device
from vireport.scenario.blocks import Distribution, Scenario, TolerancesBlock
from vireport.scenario.parameters import DRIVING, DesignInput

FREE = (
    *RESTITUTIONS,
    Unknown.LENGTH,
    Unknown.AMPLITUDE,
    Unknown.FREQUENCY,
    Unknown.INCLINATION,
)
"""Unknowns that can be identified."""

CONFIDENCE = 0.95
"""Of the intervals."""

FITTING_SHARE = 0.6
"""Share of the time of an answer that fitting takes, as measured; testing the model takes the rest."""

FAR_ABOVE = 2.0
"""Timing error over that of rounding from which times are as good as not rounded."""

BOTH_MEMBRANES = Unknown.RESTITUTION_BOTTOM, Unknown.RESTITUTION_TOP


class IdentifiedInput(Struct, frozen=True):
    """The value of an input identified from a record, its standard error and 95 % interval, in its unit."""

    unknown: Unknown
    value: float
    error: float
    low: float
    high: float

    @property
    def half(self) -> float:
        """Half the width of the 95 % interval, in the unit of the input."""
        return (self.high - self.low) / 2


class Identification(Struct, frozen=True, eq=False):
    """The result of an identification from a record of impacts.

    Attributes
    ----------
    inquiry : Inquiry
    fit : Fitted or NoFit
        The fitted device and impacts, with times counted from `origin_s`, or why there is none.
    misfit : Misfit
    origin_s : float
        Time on the record's clock from which the force's phase is counted [s].
    rounding : Rounding or None
        The step that times are rounded to, if rounding is the larger part of their errors; else None.
    """

    inquiry: Inquiry
    fit: Fitted | NoFit
    misfit: Misfit
    origin_s: float
    rounding: Rounding | None = None

    @property
    def identified(self) -> tuple[IdentifiedInput, ...]:
        """The inputs that are identified; () where the model does not fit."""
        if not self.misfit.accepted or not isinstance(self.fit, Fitted):
            return ()
        from scipy.special import stdtrit  # type: ignore[import-untyped]

        adjusted = self.fit.adjusted
        wide = float(stdtrit(adjusted.freedom, (1 + CONFIDENCE) / 2))
        inputs = []
        for unknown in self.inquiry.unknowns:
            value, error = adjusted.model.value_of(unknown), adjusted.deviation_of(unknown)
            value = value % (2 * np.pi) if unknown is Unknown.PHASE else value
            inputs.append(IdentifiedInput(unknown, value, error, value - wide * error, value + wide * error))
        return tuple(inputs)

    @property
    def timing_error_s(self) -> float | None:
        """Timing error of each impact, without what was added to rounded times that repeat [s]; None without a fit."""
        if not isinstance(self.fit, Fitted):
            return None
        added = 1.0 if self.rounding is None else sqrt(self.rounding.repeated)
        return self.fit.adjusted.timing_error_s / added


def inquiry_of(scenario: Scenario, free: Sequence[str], referenced: bool) -> Inquiry:
    """Set up an identification: the device of a scenario, the unknowns, and priors from its tolerances.

    Parameters
    ----------
    scenario : Scenario
    free : sequence of str
        Keys of the unknowns; both restitutions where there are none.
    referenced : bool
        Whether time 0 of the record is a maximum of the force.

    Raises
    ------
    UsageError
        If an unknown cannot be identified, unknowns exclude one another, an input is missing, or the ball has friction
        or a restitution that depends on speed.
    """
    unknown = [key for key in free if key not in FREE]
    if unknown:
        raise UsageError(f"--free: unknown {', '.join(map(repr, unknown))} (allowed: {', '.join(FREE)})")
    unknowns = tuple(dict.fromkeys(map(Unknown, free))) or BOTH_MEMBRANES
    if Unknown.RESTITUTION in unknowns and set(BOTH_MEMBRANES) & set(unknowns):
        raise UsageError("--free: restitution is that of both membranes (allowed: it alone, or those of each)")
    device = Device.of(scenario).plain_ball("the identification from impacts")
    missing = [parameter.path for parameter in DRIVING if getattr(device, parameter) is None]
    if missing:
        raise UsageError(f"{missing[0]} is not given: the device of the record is one design point (give its value)")
    priors = tolerance_priors(scenario.tolerances, device, unknowns)
    return Inquiry(ClockedDevice(device), unknowns if referenced else (*unknowns, Unknown.PHASE), priors)


def tolerance_priors(block: TolerancesBlock | None, device: Device, unknowns: tuple[Unknown, ...]) -> tuple[Prior, ...]:
    """Priors of the inputs that are not identified, from their tolerances as standard deviations."""
    if block is None:
        return ()
    # A prior of the mean of both restitutions would constrain those that are identified, and vice versa.
    taken = set(unknowns) | (set(RESTITUTIONS) if set(RESTITUTIONS) & set(unknowns) else set())
    normal = block.distribution is Distribution.NORMAL
    priors = []
    for varied in DesignInput:
        if Unknown(varied.value) in taken or varied not in device.inputs:
            continue
        value = float(device.value_of(varied))
        half = block.half_width(varied, value)
        # A tolerance is three standard deviations of a normal distribution, or root 3 of them for a uniform one.
        if half > 0:
            priors.append(Prior(Unknown(varied.value), value, half / (3 if normal else sqrt(3))))
    return tuple(priors)


def answered(inquiry: Inquiry, record: Record, referenced: bool, say: Progress = lambda what: None) -> Identification:
    """Identify the unknowns from a record, and test whether the model fits it.

    Parameters
    ----------
    inquiry : Inquiry
    record : Record
    referenced : bool
        Whether time 0 of the record is a maximum of the force.
    say : callable
        Called with each step as it begins.

    Raises
    ------
    Unidentifiable
        If the record does not determine the unknowns.
    """
    origin = record.force_maximum_s
    if origin is None:
        origin = 0.0 if referenced else float(record.times[0])
    fitting = portion(say, 0.0, FITTING_SHARE)
    impacts = MeasuredImpacts.undoubted(record.times - origin, record.walls, record.relative)
    rounding = rounding_of(record.times)
    if rounding is not None and rounding.error_s < exact_below(inquiry.model):
        rounding = None
    try:
        fitted = fit(inquiry, impacts, fitting)
    except Unidentifiable:
        if rounding is None:
            raise
        fitted = NoFit(Unfit.NO_MOTION, np.inf)
    # Rounding matters only where it is the larger part of the timing error: then the fit begins again, with times whose
    # errors are independent.
    if rounding is not None:
        if isinstance(fitted, Fitted) and fitted.adjusted.timing_error_s > FAR_ABOVE * rounding.error_s:
            rounding = None
        else:
            impacts = impacts.at(rounding.independent(impacts.times))
            fitted = fit(inquiry, impacts, fitting)
    misfit = judged(fitted, inquiry, impacts, portion(say, FITTING_SHARE, 1.0))
    return Identification(inquiry, fitted, misfit, origin, rounding)
