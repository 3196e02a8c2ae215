"""From raw signals to impacts and the shaker's motion, which takes the place of the scenario's force."""

from __future__ import annotations

from math import hypot, pi, sin

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.base.progress import Progress
from vireport.measurement.adjustment import Inquiry, Prior
from vireport.measurement.flights import Unknown
from vireport.measurement.picking import Picked, picked
from vireport.measurement.recordings import HeardPlace, Recording, read_recording
from vireport.measurement.records import Record
from vireport.measurement.shaker import TILTED, ShakerFinding, ShakerMotion, shaker_findings, shaker_motion
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.scenario.blocks import LayoutBlock
from vireport.scenario.parameters import DesignInput

OF_SHAKER = Unknown.AMPLITUDE, Unknown.FREQUENCY
"""Inputs that the capsule's acceleration tells."""


class Signals(Struct, frozen=True, eq=False):
    """Impacts and the shaker's motion, from the raw signals of one recording.

    Attributes
    ----------
    picked : Picked
    shaker : ShakerMotion or None
        None where neither acceleration nor displacement was recorded.
    doubts : tuple of ShakerFinding
        Possible faults of the acceleration, by comparison with the scenario.
    """

    picked: Picked
    shaker: ShakerMotion | None
    doubts: tuple[ShakerFinding, ...] = ()

    @property
    def record(self) -> Record:
        """The impacts as a record, from which a device is identified."""
        beginnings = self.picked
        maximum = self.shaker.maximum_s if self.shaker is not None else None
        return Record(
            beginnings.recording.name,
            beginnings.times,
            beginnings.walls,
            force_maximum_s=maximum,
            errors=beginnings.errors,
        )


def read_signals(
    path: str, inquiry: Inquiry, say: Progress = lambda what: None, keys: LayoutBlock | None = None
) -> Signals:
    """Read raw signals, pick their impacts and fit the shaker's motion.

    Parameters
    ----------
    path : str
    inquiry : Inquiry
        Of the scenario, for the frequency that is expected.
    say : callable
        Called with each step as it begins.
    keys : LayoutBlock, optional
        How the file is read.

    Raises
    ------
    UsageError, ScenarioError
        If the file is malformed, or impacts or the shaker's motion cannot be had of it.
    """
    recording = read_recording(path, keys=keys)
    device = inquiry.model.device
    frequency = float(device.frequency_hz)
    shaker = shaker_of(recording, device, say)
    if shaker is None:
        return Signals(picked(recording, frequency, say), None)
    doubts = shaker_findings(recording, shaker, device)
    return Signals(picked(recording, shaker.frequency_hz, say), shaker, doubts)


def shaker_of(recording: Recording, device: Device, say: Progress = lambda what: None) -> ShakerMotion | None:
    """Fit the shaker's motion to the capsule's acceleration or else displacement in a recording; None without either.

    Parameters
    ----------
    recording : Recording
    device : Device
        For the frequency that is expected, and gravity along the capsule.
    say : callable
        Called with each step as it begins.

    Raises
    ------
    UsageError
        If the capsule is free, or the sensor points the other way, or as `shaker_motion`.
    """
    channels = recording.of(HeardPlace.CAPSULE) or recording.of(HeardPlace.DISPLACEMENT)
    if not channels:
        return None
    say("fitting the shaker's motion")
    if device.recoils:
        raise UsageError(
            f"{recording.name}: the motion of a free capsule is not that of its force (allowed: "
            "device.capsule: prescribed; or the record without this signal)"
        )
    (channel,) = channels
    shaker = shaker_motion(recording, channel, float(device.frequency_hz))
    _require_upright(f"{recording.name}: {channel.name}", shaker, device)
    return shaker


def shaken(device: Device, shaker: ShakerMotion) -> Device:
    """The device with the force of a shaker's motion as it was measured, and those harmonics that are significant."""
    driven = device.with_values({DesignInput(x.value): value for x, value in _values(shaker, device.capsule_mass_kg)})
    # What is not significant is noise of the sensor, and would be taken for a force.
    harmonics = tuple(Harmonic.of(h.order, h.percent, h.phase_deg) for h in shaker.harmonics if h.significant)
    return replace(driven, harmonics=harmonics)


def _require_upright(name: str, shaker: ShakerMotion, device: Device) -> None:
    """Refuse a sensor of constant accelerations that shows gravity with the wrong sign.

    Raises
    ------
    UsageError
    """
    axial_gravity = float(device.gravity_m_s2) * sin(np.deg2rad(float(device.inclination_deg)))
    if axial_gravity > 1 and abs(shaker.offset + axial_gravity) < TILTED * axial_gravity:
        raise UsageError(
            f"{name}: its mean of {shaker.offset:.4g} m/s² is that of gravity times -1: the sensor points "
            "to the bottom (allowed: positive towards the top, so that at rest it shows gravity positive)"
        )


def with_shaker(inquiry: Inquiry, shaker: ShakerMotion, delay_s: float) -> Inquiry:
    """An identification in which force, frequency and harmonics are the measured ones, with their errors as priors.

    Parameters
    ----------
    inquiry : Inquiry
    shaker : ShakerMotion
    delay_s : float
        By how much the times of all impacts may be off against it.

    Raises
    ------
    UsageError
        If an input that the acceleration gives is an unknown.
    """
    if of_shaker := [x for x in OF_SHAKER if x in inquiry.unknowns]:
        raise UsageError(f"--free: {of_shaker[0]} is measured by the record's acceleration (leave one of them out)")
    device = inquiry.model.device
    mass = float(device.capsule_mass_kg)
    model = replace(inquiry.model, device=shaken(device, shaker), phase=0.0)
    measured = {Unknown.AMPLITUDE: mass * shaker.amplitude_error, Unknown.FREQUENCY: shaker.frequency_error_hz}
    # What the scenario says of the same input, of the sensor's calibration for one, is uncertain on its own.
    deviations = {prior.unknown: prior.deviation for prior in inquiry.priors}
    values = dict(_values(shaker, mass))
    priors = [prior for prior in inquiry.priors if prior.unknown not in OF_SHAKER]
    priors += [Prior(x, values[x], hypot(error, deviations.get(x, 0.0))) for x, error in measured.items()]
    # Times are counted from a maximum of the force, so that its phase is 0, up to how well that maximum is known and
    # by how much all impacts are heard later.
    priors.append(Prior(Unknown.PHASE, 0.0, hypot(shaker.phase_error, 2 * pi * shaker.frequency_hz * delay_s)))
    return Inquiry(model, tuple(x for x in inquiry.unknowns if x is not Unknown.PHASE), tuple(priors))


def _values(shaker: ShakerMotion, mass_kg: float) -> tuple[tuple[Unknown, float], ...]:
    """Force amplitude [N] on a capsule and frequency [Hz] of a shaker's motion."""
    return (Unknown.AMPLITUDE, mass_kg * shaker.amplitude), (Unknown.FREQUENCY, shaker.frequency_hz)
