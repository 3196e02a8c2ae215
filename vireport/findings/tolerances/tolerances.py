"""Whether every device within tolerances works, the worst one where not all do, the yield, and ranges of results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import partial
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import brief
from vireport.base.shares import share_interval
from vireport.design.devices import Floats, Mask, devices_off, sample_steps, stable_motions
from vireport.findings.tolerances.proof import BORDER, Leaf, Proof, prove_region
from vireport.findings.tolerances.region import Region, region_of
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.energy import Membrane, voltages
from vireport.scenario.blocks import Distribution, TolerancesBlock
from vireport.scenario.parameters import DesignInput, Parameter

BISECTIONS = 40
"""Halvings of the way from the design to a device that fails."""

PERCENTILES = {"least": 0, "percentile_5": 5, "median": 50, "percentile_95": 95, "largest": 100}
"""What is said of the range of a quantity."""


class Answer(StrEnum):
    """Whether every device within the tolerances has a stable 1:1 motion; the value is its name in results.json."""

    PROVED = "proved"
    REFUTED = "refuted"
    UNDECIDED = "undecided"


class Failure(Struct, frozen=True):
    """A device within the tolerances that has no stable 1:1 motion: a corner of them, or a random one.

    Attributes
    ----------
    values : dict
        Values of its inputs.
    share : float
        Share of the way from the design to this device at which stable motion ends; 0 where the design has none.
    """

    values: dict[DesignInput, float]
    share: float


class Yield(Struct, frozen=True):
    """How many of the samples have a stable 1:1 motion, and the 95 % interval of that share by Clopper and Pearson."""

    distribution: Distribution
    stable: int
    samples: int
    low: float
    high: float


class Tolerances(Struct, frozen=True, eq=False):
    """Whether every device within tolerances has stable 1:1 motion, how many have, and the ranges of its numbers.

    Attributes
    ----------
    region : Region
        The devices within the tolerances.
    answer : Answer
    proof : Proof or None
        None where the design or a corner fails, so that no proof was sought, and where no proof is available.
    worst : Failure or None
        The failing device towards which stable motion ends first.
    sampled : Yield
    ranges : dict
        `PERCENTILES` over all stable motions of the samples: of `velocity_bottom_m_s`, `velocity_top_m_s` and, where
        energy is evaluated, `u_ave_v`. Empty where there are none.
    """

    region: Region
    answer: Answer
    proof: Proof | None
    worst: Failure | None
    sampled: Yield
    ranges: dict[str, dict[str, float]]

    __repr__ = brief

    def of_worst(self, varied: DesignInput) -> float | None:
        """The value of an input in the worst device, for both restitutions their mean; None without a worst device."""
        if self.worst is None:
            return None
        values = self.worst.values
        bottom, top = (values.get(restitution, 0.0) for restitution in RESTITUTIONS[1:])
        return values.get(varied, (bottom + top) / 2)

    @property
    def toleranced_of_worst(self) -> dict[DesignInput, float]:
        """Values in the worst device of inputs with a tolerance, be it only that of both restitutions; {} without."""
        ranges, values = self.region.ranges, self.worst.values if self.worst is not None else {}
        both = RESTITUTIONS if RESTITUTIONS[0] in ranges else ()
        return {varied: value for varied, value in values.items() if varied in ranges or varied in both}

    @property
    def provable(self) -> bool:
        """Whether a proof is available: for a sine force only. For any other the answer is never `PROVED`."""
        return not self.region.design.harmonics

    @property
    def proved(self) -> bool:
        """Whether every device is proved to have a stable 1:1 motion."""
        return self.answer is Answer.PROVED


def half_widths(device: Device, block: TolerancesBlock) -> dict[DesignInput, float]:
    """The tolerance of each input that has one, in its unit."""
    widths = {varied: block.half_width(varied, float(device.value_of(varied))) for varied in DesignInput}
    return {varied: width for varied, width in widths.items() if width}


def assess_tolerances(
    device: Device,
    half_widths: Mapping[DesignInput, float],
    membrane: Membrane | None,
    distribution: Distribution,
    samples: int,
) -> Tolerances:
    """Decide whether every device within tolerances has a stable 1:1 motion, and estimate how many do.

    Parameters
    ----------
    device : Device
        The design, with all four parameters.
    half_widths : mapping
        By how much each input may be off, in its unit.
    membrane : Membrane or None
    distribution : Distribution
        Of the inputs within their tolerances, independent of one another.
    samples : int
        Number of random devices for the yield, a power of two.
    """
    region, proof = region_of(device, half_widths), None
    # The design and the corners are tried first: where one fails there is nothing to prove.
    worst = _worst(region.devices, region.design_shares, np.hstack([region.design_shares, region.corners]))
    if worst is None and not device.harmonics:
        proof = prove_region(region)
        # The proof may find a failing device that is no corner; stable motion ends on the way to it from the design.
        if proof.failing is not None:
            worst = _worst(region.devices, region.design_shares, proof.failing[:, None])
    steps = sample_steps(len(half_widths), distribution, samples)
    drawn = partial(devices_off, device, half_widths)
    sampled, ranges, failing = _sampled(drawn(steps), membrane, distribution)
    if worst is None and failing.any():
        worst = _worst(drawn, np.zeros((len(steps), 1)), steps[:, failing])
    proved = proof is not None and Leaf.OPEN not in proof.halved
    answer = Answer.REFUTED if worst is not None else Answer.PROVED if proved else Answer.UNDECIDED
    return Tolerances(region, answer, proof, worst, sampled, ranges)


Devices = Callable[[Floats], Device]
"""Devices by their places within the tolerances, shape (factors or inputs, k)."""


def _works(devices: Devices, places: Floats) -> Mask:
    """Which devices have a stable motion, or one on the border of stability."""
    cell, _ = stable_motions(devices(places), BORDER)
    return np.isin(np.arange(places.shape[1]), cell)


def _worst(devices: Devices, design: Floats, places: Floats) -> Failure | None:
    """The failing device towards which stable motion ends first on the way from the design; None where none fails."""
    places = places[:, ~_works(devices, places)]
    if not places.size:
        return None
    low, high = np.zeros(places.shape[1]), np.ones(places.shape[1])
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        # Along the straight line from the design, which works, to each device that fails: which ends first is the
        # worst, in shares of the tolerances and so without units.
        works = _works(devices, design + middle * (places - design))
        low, high = np.where(works, middle, low), np.where(works, high, middle)
        first = low <= high.min()
        low, high, places = low[first], high[first], places[:, first]
    nearest = int(high.argmin())
    device = devices(places[:, [nearest]])
    values = {varied: float(device.value_of(varied)[0]) for varied in device.inputs}
    return Failure(values, float(low[nearest]))


def _sampled(
    devices: Device, membrane: Membrane | None, distribution: Distribution
) -> tuple[Yield, dict[str, dict[str, float]], Mask]:
    """The yield of random devices, the percentiles over their stable motions, and which devices have none."""
    cell, orbit = stable_motions(devices)
    failing = np.ones(np.size(devices.length_m), dtype=bool)
    failing[cell] = False
    stable, samples = int(np.count_nonzero(~failing)), len(failing)
    _, low, high = share_interval(stable, samples)
    sampled = Yield(distribution, stable, samples, low, high)
    if not stable:
        return sampled, {}, failing
    unit = devices.velocity_unit(Parameter.LENGTH, devices.length_m)[cell]
    bottom, top = unit * orbit.velocity_bottom, unit * orbit.velocity_top
    values = {"velocity_bottom_m_s": bottom, "velocity_top_m_s": top}
    if membrane is not None:
        if devices.recoils:
            of_cell: Any = devices.capsule_mass_kg
            membrane = replace(membrane, free_capsule_kg=of_cell[cell])
        values["u_ave_v"] = voltages(bottom, top, membrane).average_v
    ranges = {
        name: {key: float(np.percentile(column, percent)) for key, percent in PERCENTILES.items()}
        for name, column in values.items()
    }
    return sampled, ranges, failing
