"""The devices within tolerances as a box of a few factors, with shares between 0 and 1 as coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.boxes import Boxes
from vireport.base.records import brief
from vireport.design.devices import FACTOR_OF, Floats, factor_of
from vireport.physics.affine import AFFINE, Affine, between
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.groups import Groups, Restitutions
from vireport.physics.numbers import ARRAYS
from vireport.scenario.parameters import DesignInput

OTHER_SYMBOLS = 4
"""Symbols of the affine numbers next to those of the factors: three of the motion, and that of time."""


class Region(Struct, frozen=True, eq=False):
    """The devices within the tolerances: all between two ends of each factor.

    A device of the region has a share between 0 and 1 for each factor: all inputs of the factor are that far on the way
    from their `start` to their `end`. As each factor grows with its share, none of its values is missed.

    Attributes
    ----------
    design : Device
    start, end : dict
        Values of all inputs at either end; the force is larger at `start`, so that M/F grows.
    """

    design: Device
    start: dict[DesignInput, float]
    end: dict[DesignInput, float]

    __repr__ = brief

    @property
    def factors(self) -> int:
        """Number of factors of the groups."""
        return len(set(factor_of(self.design).values()))

    @property
    def ranges(self) -> dict[DesignInput, tuple[float, float]]:
        """The least and the largest value of each input that varies, in its unit."""
        ends = {varied: (self.start[varied], self.end[varied]) for varied in DesignInput}
        return {varied: (min(pair), max(pair)) for varied, pair in ends.items() if pair[0] != pair[1]}

    @property
    def design_shares(self) -> Floats:
        """Shares of the factors at the design, shape (factors, 1)."""
        shares = np.full((self.factors, 1), 0.5)
        low, high = (ends[DesignInput.INCLINATION] for ends in (self.start, self.end))
        shares[FACTOR_OF[DesignInput.INCLINATION]] = (self.design.inclination_deg - low) / (high - low or 1.0)
        return shares

    @property
    def parts_membranes(self) -> bool:
        """Whether one membrane has a tolerance of its restitution apart from the tolerance of both."""
        return any(self.start[varied] != self.end[varied] for varied in RESTITUTIONS[1:])

    @property
    def corners(self) -> Floats:
        """Shares of the devices with all factors at an end, shape (factors, k)."""
        # Corners that differ in a factor without width would be the same device twice.
        held = [] if self.parts_membranes else [FACTOR_OF[varied] for varied in RESTITUTIONS[1:]]
        ends = [[0.0] if factor in held else [0.0, 1.0] for factor in range(self.factors)]
        return np.stack(np.meshgrid(*ends, indexing="ij")).reshape(self.factors, -1)

    def devices(self, shares: Floats) -> Device:
        """A device with an array (k,) for each input that varies, from shares of shape (factors, k)."""
        values = {}
        for varied, factor in factor_of(self.design).items():
            first, last, share = self.start[varied], self.end[varied], shares[factor]
            # Exactly the end at a share of 1, which a sum of doubles may miss.
            values[varied] = np.where(share == 1, last, first + share * (last - first))
        restitution = self._restitution(*(values.pop(varied) for varied in RESTITUTIONS))
        return replace(self.design.with_values(values), restitution=restitution)

    def _restitution(self, both: Any, bottom: Any, top: Any) -> Any:
        """The restitution of devices from that of both membranes together and those of each."""
        if self.design.alike and not self.parts_membranes:
            return both
        moved = both - self.design.value_of(DesignInput.RESTITUTION)
        return Restitutions(bottom + moved, top + moved)

    def groups(self, low: Floats, high: Floats) -> Groups[Affine]:
        """The groups of all devices in boxes of shares with ends of shape (factors, k), Eqs. (2.5), (2.6)."""
        # Inputs of one factor share a symbol, so that their effects on d and on gbar are bounded together.
        x: dict[DesignInput, Affine] = {}
        symbols = self.factors + OTHER_SYMBOLS
        for varied, factor in factor_of(self.design).items():
            first, width = self.start[varied], self.end[varied] - self.start[varied]
            x[varied] = between(first + low[factor] * width, first + high[factor] * width, factor, symbols)
        frequency, sine = x[DesignInput.FREQUENCY], AFFINE.sin(AFFINE.pi * x[DesignInput.INCLINATION] / 180)
        mass_over_force = x[DesignInput.CAPSULE_MASS] / x[DesignInput.AMPLITUDE]
        d = 4 * mass_over_force * (x[DesignInput.LENGTH] * frequency * frequency)
        restitution = self._restitution(*(x[varied] for varied in RESTITUTIONS))
        if self.design.recoils:
            mass_over_force = (x[DesignInput.CAPSULE_MASS] + self.design.ball_mass_kg) / x[DesignInput.AMPLITUDE]
        return Groups(d, self.design.gravity_m_s2 * mass_over_force * sine, restitution)

    @property
    def faces(self) -> tuple[Boxes, Floats]:
        """Boxes in shares that cover all of the region's (d, gbar, r), and their parts of the whole, (k,).

        Scaling M/F up and s f^2 and sin(beta) down by one factor leaves d and gbar as they are, until one of the three
        reaches the end of its range. So the three faces on which one of them is at that end cover all (d, gbar), with
        one dimension less and without overlap. A factor without a tolerance is at its end already. The parts are areas
        in (d, gbar). For a free capsule 1/F stands for M/F, and M takes all its values on each face.
        """
        of_factor = factor_of(self.design)
        fixed = [k for k in range(3) if all(self.start[x] == self.end[x] for x, of in of_factor.items() if of == k)]
        fixed = fixed[:1] or [0, 1, 2]
        low, high = np.zeros((self.factors, len(fixed))), np.ones((self.factors, len(fixed)))
        low[fixed, range(len(fixed))] = high[fixed, range(len(fixed))] = np.equal(fixed, 0)
        if len(fixed) == 1:
            return Boxes(low, high), np.ones(1)
        ends = self.devices(np.tile([0.0, 1.0], (self.factors, 1)))
        (mass, length, sine), (to_mass, to_length, to_sine) = np.transpose(
            [
                (1.0 if self.design.recoils else ends.capsule_mass_kg) / ends.amplitude_n,
                ends.length_m * ends.frequency_hz**2,
                ARRAYS.sin_degrees(ends.inclination_deg),
            ]
        )
        squares = (to_mass**2 - mass**2) / 2
        areas = np.array(
            [
                to_mass**2 * (to_length - length) * (to_sine - sine),
                length * squares * (to_sine - sine),
                sine * squares * (to_length - length),
            ]
        )
        return Boxes(low, high), areas / areas.sum()


def region_of(device: Device, half_widths: Mapping[DesignInput, float]) -> Region:
    """The devices whose inputs are off by no more than their tolerances.

    A capsule inclined below 0 degrees is the mirror image of one above: its bottom is the other end. One beyond 90
    degrees is one turned round. Both are represented by the equivalent inclination from 0 to 90 degrees.
    """
    start, end = {}, {}
    for varied in DesignInput:
        value, off = float(device.value_of(varied)), half_widths.get(varied, 0.0)
        low, high = value - off, value + off
        if varied is DesignInput.INCLINATION:
            low, high = max(low, 0.0), min(high, 90.0)
        start[varied], end[varied] = (high, low) if varied is DesignInput.AMPLITUDE else (low, high)
    return Region(device.plain_ball("what tolerances come to"), start, end)
