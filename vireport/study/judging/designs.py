"""Many designs at once: their stable motions by the closed form, quantities of these, and which designs surely fail."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.design.from_rest import FromRest
from vireport.design.lines import HIGHEST_RESTITUTION
from vireport.design.outcomes_from_rest import outcomes_of
from vireport.motions.pointwise import PointwiseMotions, differentiated_motions, find_motions
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.energy import Conversion, Dielectric, Membrane, Voltages
from vireport.physics.groups import Groups, Restitutions, by_wall, map_restitution
from vireport.physics.numbers import Arithmetic
from vireport.scenario.blocks import Scenario
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.judging.impacts import Impacts, generated, impacts_of

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

RINGS = 1.0, 0.5
"""Shares of a margin at which a motion is looked for: a device with the margin has one at each."""

DISPLACED = (
    *((DesignInput.FREQUENCY, sign) for sign in (-1, 1)),
    *((varied, -1) for varied in (DesignInput.AMPLITUDE, DesignInput.CAPSULE_MASS)),
    *((varied, sign) for varied in (DesignInput.INCLINATION, *RESTITUTIONS) for sign in (-1, 1)),
)
"""Inputs that are moved, and whither. By d = 4 M s f^2/F and gbar = M g sin(beta)/F all others lie between these,
but for a larger mass of a free capsule, of which gbar has (M + m): that is left to a run."""

BORDER = 1e-9
"""Gap and distance of the trace from its border up to which a motion is not said to be unstable: rounding is far
less."""

STEPS = 32
"""Steps of a range along which stable motion is looked for, a power of 2. What is narrower is left to a run."""


class Designs(Struct, frozen=True, eq=False, dict=True):
    """Designs that differ from a scenario in some inputs, as arrays, and their stable 1:1 motions.

    Attributes
    ----------
    scenario : Scenario
        The scenario that they vary.
    device : Device
    membrane : Membrane or None
        Device and membrane have numbers, or arrays of shape (count,); complex where derivatives are wanted, see
        `motions.differentiated_motions`.
    count : int
        Number of designs.
    """

    scenario: Scenario
    device: Device
    membrane: Membrane | None
    count: int

    def select(self, rows: Ints) -> Designs:
        """The designs with these indices."""
        membrane = None if self.membrane is None else _of_rows(self.membrane, rows)
        return replace(self, device=_of_rows(self.device, rows), membrane=membrane, count=len(rows))

    def varied(self, values: Mapping[Any, Any]) -> Designs:
        """The designs with other values of some inputs."""
        return replace(self, device=self.device.with_values(values))

    @cached_property
    def restitution(self) -> Any:
        """Restitution of the membranes of each design."""
        return map_restitution(self._groups.restitution, np.asarray)

    @cached_property
    def _groups(self) -> Groups[Any]:
        groups = self.device.groups(Parameter.LENGTH, self.device.length_m)
        kind = np.result_type(*groups.numbers, float)
        return groups.map_numbers(lambda group: np.array(np.broadcast_to(group, self.count), dtype=kind))

    @cached_property
    def motions(self) -> PointwiseMotions:
        """All motions, stable or not; with derivatives where an input is complex.

        Raises
        ------
        UsageError
            Of a restitution that falls with speed.
        """
        device, groups = self.device.constant_restitution("what many designs come to"), self._groups
        shared = max(map(np.ndim, by_wall(device.restitution))) == 0
        with np.errstate(all="ignore"):
            if np.iscomplexobj(groups.d):
                return differentiated_motions(groups, device.period_ratio)
            # A common restitution is passed as one number: motions are then found five times as fast.
            shared_groups = groups._replace(restitution=device.restitution) if shared else groups
            return find_motions(shared_groups, device.period_ratio)

    def from_rest(self) -> Iterator[FromRest]:
        """What each design comes to from rest when it is switched on at once, one by one, without the compiler.

        Raises
        ------
        UsageError
            As `motions`.
        """
        return outcomes_of(self._groups, self.motions, self.device.period_ratio, compiled=False)

    @cached_property
    def rows(self) -> Ints:
        """Which of the motions are stable."""
        return np.flatnonzero(self.motions.stable(self.restitution))

    @property
    def cell(self) -> Ints:
        """The design of each stable motion."""
        return self.motions.cell[self.rows]

    def has_motion(self, slack: float = 0.0) -> Mask:
        """Whether designs have a stable motion, or one that fails the conditions by no more than `slack`."""
        present = np.zeros(self.count, dtype=bool)
        if not self.count:
            return present
        present[self.motions.cell[self.motions.stable(self.restitution, slack)]] = True
        return present

    def of_cell(self, x: Arithmetic) -> Any:
        """A number of the designs, or an array (count,), as a number for each of their stable motions."""
        return np.broadcast_to(np.asarray(x), self.count)[self.cell]

    @property
    def half_widths(self) -> dict[DesignInput, Any]:
        """The tolerance of each input that has one, in its unit."""
        block = self.scenario.tolerances
        parts = {} if block is None else {varied: block.off(varied) for varied in DesignInput}
        return {
            varied: np.maximum(fixed, self.device.value_of(varied) * percent / 100)
            for varied, (fixed, percent) in parts.items()
            if fixed or percent
        }

    @cached_property
    def speeds(self) -> tuple[Floats, Floats]:
        """Speeds of the impacts of stable motions at the bottom and at the top [m/s]."""
        unit = self.of_cell(self.device.velocity_unit(Parameter.LENGTH, self.device.length_m))
        orbit = self.motions.orbit
        return unit * orbit.velocity_bottom[self.rows], -(unit * orbit.velocity_top[self.rows])

    @cached_property
    def period_s(self) -> Floats:
        """Period of the stable motions [s]."""
        return np.asarray(self.of_cell(self.device.period_ratio / self.device.frequency_hz))

    @cached_property
    def generated(self) -> tuple[Voltages | None, Conversion | None]:
        """Voltages and converted energy of the impacts of stable motions; None where they cannot be evaluated."""
        return generated(
            self.speeds, self._membranes, map_restitution(self.device.restitution, self.of_cell), self.period_s
        )

    @cached_property
    def _membranes(self) -> Membrane | None:
        """The membrane with an array for each number, of its stable motions."""
        return None if self.membrane is None else _of_each(self.membrane, self.of_cell)

    @cached_property
    def impacts(self) -> Impacts:
        """The impacts of stable motions with the quantities that requirements limit."""
        return impacts_of(*self.generated, self._membranes)

    def worst(self, values: Floats, least: bool) -> Floats:
        """The least or the largest of the values of stable motions for each design, (count,); NaN without one."""
        return extreme(values, self.cell, self.count, np.minimum if least else np.maximum)


def extreme(values: Floats, cell: Ints, count: int, of: np.ufunc) -> Floats:
    """Least or largest value over the motions of each design, which are ordered by design; NaN where it has none."""
    whole, first = np.full(count, np.nan, dtype=values.dtype), np.flatnonzero(np.diff(cell, prepend=-1))
    whole[cell[first]] = of.reduceat(values, first) if cell.size else values
    return whole


def _of_rows(record: Any, rows: Ints) -> Any:
    """A device or membrane with some elements of its arrays."""
    parts = {name: getattr(record, name) for name in record.__struct_fields__}
    picked = {name: x[rows] for name, x in parts.items() if isinstance(x, np.ndarray)}
    picked |= {name: _of_rows(x, rows) for name, x in parts.items() if isinstance(x, (Dielectric, Restitutions))}
    return replace(record, **picked)


def _of_each(membrane: Membrane, of_cell: Callable[[Any], Any]) -> Membrane:
    """A membrane whose numbers are arrays, one for each motion."""
    parts = {name: getattr(membrane, name) for name in Membrane.__struct_fields__}
    dielectric: Dielectric | None = parts.pop("dielectric")
    if dielectric is not None:
        dielectric = Dielectric(*(of_cell(getattr(dielectric, name)) for name in Dielectric.__struct_fields__))
    return Membrane(**{name: of_cell(x) for name, x in parts.items()}, dielectric=dielectric)


def keeps_motion(designs: Designs, share: float | Floats) -> Mask:
    """Whether designs have stable motion where any one input is off by a share, or each by its own, to either side.

    This is necessary for such a margin: where it fails, a stable motion ends on the way.
    """
    kept, share = np.ones(designs.count, dtype=bool), np.broadcast_to(share, designs.count)
    for ring in RINGS:
        for varied, sign in DISPLACED:
            rows = np.flatnonzero(kept)
            part = designs.select(rows)
            value = np.broadcast_to(part.device.value_of(varied) * (1 + sign * ring * share[rows]), len(rows))
            high = HIGHEST_RESTITUTION if varied in RESTITUTIONS else varied.limits[1]
            moved = np.flatnonzero(value <= high)  # beyond it no margin is looked for
            kept[rows[moved]] = part.select(moved).varied({varied: value[moved]}).has_motion()
    return kept


def steps_between(low: float, high: float) -> Iterator[Floats]:
    """Values of a range in batches, its ends first, then midpoints of those before: most that fails does so early.

    Values that are tried at once cost hardly more than one.
    """
    # One design takes some 3 ms for what is done only once, and 0.5 us for each further value.
    values = np.append(low + (high - low) * np.arange(STEPS) / STEPS, high)
    yield values[[0, -1]]
    step = STEPS
    while step > 1:
        yield values[step // 2 :: step]
        step //= 2


def at_each_value(designs: Designs, parameter: Parameter, values: Floats) -> Designs:
    """All designs with each of some values of a parameter, the designs together for each value."""
    rows = np.tile(np.arange(designs.count), len(values))
    return designs.select(rows).varied({parameter: np.repeat(values, designs.count)})


def may_be_stable(designs: Designs, parameter: Parameter, low: float, high: float) -> Mask:
    """Whether designs may have stable motion over all of a range of a parameter; if False they surely have not."""
    kept = np.ones(designs.count, dtype=bool)
    for values in steps_between(low, high):
        rows = np.flatnonzero(kept)
        exists = at_each_value(designs.select(rows), parameter, values).has_motion(BORDER)
        kept[rows] = exists.reshape(len(values), len(rows)).all(axis=0)
    return kept
