"""The analytic solution of a scenario: its sweep, its design point, and the voltages of both."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.bounds import Bounds, bounds_of
from vireport.design.lines import mirrored
from vireport.design.point import (
    DesignPoint,
    StableInterval,
    design_point,
    ending_beyond,
    stable_ranges,
)
from vireport.motions.branches import Branch
from vireport.motions.diagram import BifurcationDiagram, TableRow, solve, table
from vireport.motions.one_to_one import Motions, impact_velocities
from vireport.motions.points import Point
from vireport.motions.sweep import Sweep
from vireport.physics.device import RESTITUTIONS, Device, Shaker
from vireport.physics.energy import (
    Fitting,
    Membrane,
    MembraneStretch,
    Strikes,
    Voltages,
    conversion,
    fitting,
    stretch_of,
    voltages,
)
from vireport.physics.reach import is_table
from vireport.scenario.blocks import TolerancesBlock
from vireport.scenario.parameters import DesignInput, Parameter

Floats = NDArray[np.float64]

SMALLEST_LOSS = 1e-6
"""1 - r below which motions are not resolved: they draw together as 1 - r, and det DP = r^4 comes too near to 1."""


class Solution(Struct, frozen=True, eq=False, dict=True):
    """The 1:1 motions of a device along a sweep and at a design point.

    Attributes
    ----------
    device : Device
    membrane : Membrane or None
        None where no energy is evaluated.
    diagram : BifurcationDiagram or None
        None where nothing is swept.
    design : DesignPoint or None
        None where the scenario states no design point.
    """

    device: Device
    membrane: Membrane | None
    diagram: BifurcationDiagram | None
    design: DesignPoint | None

    def __repr__(self) -> str:
        parts = []
        if self.sweep is not None:
            labels = " ".join(point.label for point in self.critical_points)
            ranges = " and ".join(part.text() for part in self.stable_ranges)
            parts += [f"{len(self.branches)} branches", f"critical points {labels or 'none'}"]
            parts.append(f"stable for {ranges}" if ranges else "nowhere stable")
        if self.design is not None:
            parts.append(repr(self.design)[1:-1])
        return f"<Solution: {', '.join(parts)}>"

    @property
    def sweep(self) -> Sweep | None:
        """The sweep; None of a design point alone."""
        return self.diagram.sweep if self.diagram is not None else None

    @property
    def parameter(self) -> Parameter:
        """The parameter that is varied; the length where none is."""
        return self.diagram.sweep.parameter if self.diagram is not None else Parameter.LENGTH

    @property
    def branches(self) -> tuple[Branch, ...]:
        """Every branch of motions along the sweep."""
        return self.diagram.branches if self.diagram is not None else ()

    @property
    def critical_points(self) -> tuple[Point, ...]:
        """Critical points of the sweep, where the type of motion changes."""
        return self.diagram.critical_points if self.diagram is not None else ()

    @cached_property
    def stable_ranges(self) -> tuple[StableInterval, ...]:
        """Where along the sweep there is stable admissible motion."""
        return stable_ranges(self.diagram) if self.diagram is not None else ()

    @property
    def settable_ranges(self) -> tuple[StableInterval, ...]:
        """The stable ranges that are wide enough for a device to be set into."""
        return tuple(part for part in self.stable_ranges if part.settable)

    @cached_property
    def beyond(self) -> tuple[tuple[Point | None, ...], ...]:
        """Ends of each stable range, below and above, outside the sweep, if it went on.

        None where it ends within the sweep, or nowhere that rounding resolves.
        """
        return tuple(
            tuple(
                None if point is not None else ending_beyond(self.device, self.parameter, value, sign, self.design)
                for (value, point), sign in zip(part.ends, (-1.0, 1.0), strict=True)
            )
            for part in self.stable_ranges
        )

    @cached_property
    def table(self) -> tuple[TableRow, ...]:
        """The rows of Table 1 for the sweep."""
        return table(self.diagram) if self.diagram is not None else ()

    @cached_property
    def bounds(self) -> Bounds:
        """Error bounds of all motions and voltages."""
        return bounds_of(self.device, self.membrane, self.diagram, self.design)

    @cached_property
    def shaker(self) -> Shaker:
        """The demands on the shaker at the design point or, without one, the largest along the sweep."""
        if self.sweep is None or self.design is not None:
            return self.device.shaker(self.parameter, float(self.device.value_of(self.parameter)))
        ends = [self.device.shaker(self.parameter, end) for end in (self.sweep.start, self.sweep.end)]
        return Shaker(*(max(getattr(end, name) for end in ends) for name in Shaker.__struct_fields__))

    @cached_property
    def on_table(self) -> bool:
        """Whether the device is a ball on a table, along the sweep and at the design point: no motion is 1:1."""
        ends = () if self.sweep is None else (self.sweep.start, self.sweep.end)
        return is_table(self.device, self.parameter, ends)

    @property
    def horizontal(self) -> bool:
        """Whether gravity has no part along the capsule anywhere, and n is odd: motions then have mirror images."""
        return mirrored(self.device) and self.parameter.keeps_symmetry

    @property
    def deepest_m(self) -> float:
        """Deepest deflection of a membrane in any motion along the sweep or solution at the design point [m]."""
        return max((float(np.max(depth, initial=0.0)) for depth in self._evaluated()), default=0.0)

    @property
    def within_membrane(self) -> bool:
        """Whether no deflection exceeds the membrane's active radius."""
        return self.membrane is None or self.deepest_m <= self.membrane.active_radius_m

    @property
    def fitting(self) -> Fitting | None:
        """Values that bring the deepest deflection within the membrane's active radius; None where it is within."""
        return None if self.membrane is None or self.within_membrane else fitting(self.membrane, self.deepest_m)

    @cached_property
    def stable_voltages(self) -> tuple[Floats, Floats]:
        """U_ave [V] and deflection [m] of the stable motions, at the design point or, without one, over the sweep."""
        if self.design is not None:
            stable, voltages = self.design.motions.stable_mask, self.design.voltages_by_motion
            return (
                (np.empty(0),) * 2 if voltages is None else (voltages.average_v[stable], voltages.deflection_m[stable])
            )
        volts, depths = [np.empty(0)], [np.empty(0)]
        for branch in self.branches:
            for part in branch.family.segments:
                if part.stable and branch.voltages_by_motion is not None:
                    volts.append(branch.voltages_by_motion.average_v[part.first : part.last + 1])
                    depths.append(branch.voltages_by_motion.deflection_m[part.first : part.last + 1])
        return np.concatenate(volts), np.concatenate(depths)

    @cached_property
    def stretch(self) -> MembraneStretch | None:
        """Stretch of a membrane at the deepest deflection of `stable_voltages`; None without a stable motion."""
        _, depths = self.stable_voltages
        return stretch_of(float(depths.max()), self.membrane) if depths.size and self.membrane is not None else None

    def _evaluated(self) -> Iterator[Floats]:
        """Deflections of the admissible motions of the branches, and of the design point's solutions."""
        for branch in self.branches:
            if (voltages := branch.voltages_by_motion) is not None:
                yield voltages.deflection_m[branch.motions.admissible_mask]
        if self.design is not None and (voltages := self.design.voltages_by_motion) is not None:
            yield voltages.deflection_m


def solution_of(
    device: Device, membrane: Membrane | None, sweep: Sweep | None, design: bool, margins: bool = True
) -> Solution:
    """Find every 1:1 motion of a device along a sweep, and at its design point.

    Parameters
    ----------
    device : Device
    membrane : Membrane or None
        For the voltages.
    sweep : Sweep or None
        A sweep of that device.
    design : bool
        Whether to evaluate the design point, for which the scenario must state all four parameters.
    margins : bool
        Whether to find how far the design point's motions are from their ends.

    Raises
    ------
    NumericalError
        If the scenario is outside the theory (restitution 1), or double precision does not resolve it.
    """
    for varied in device.inputs:
        if varied in RESTITUTIONS and 1 - device.value_of(varied) < SMALLEST_LOSS:
            raise NumericalError(
                f"{varied.path}: {device.value_of(varied)!r} means impacts with hardly any loss; for 1 periodic "
                "motions come in continua and none is asymptotically stable, so that the criteria of Table 1 do not "
                f"apply (allowed here: at most 1 - {SMALLEST_LOSS:g})"
            )
    if unresolved := sweep.unresolved if sweep is not None else device.unresolved:
        raise NumericalError(unresolved)
    diagram = solve(sweep) if sweep is not None else None
    point = design_point(device, diagram, margins) if design else None
    if membrane is None:
        return Solution(device, None, diagram, point)

    def of(parameter: Parameter, motions: Motions) -> Voltages:
        return voltages(*impact_velocities(device, parameter, motions), membrane)

    if diagram is not None:
        parameter = diagram.sweep.parameter
        branches = (replace(branch, voltages_by_motion=of(parameter, branch.motions)) for branch in diagram.branches)
        diagram = replace(diagram, branches=tuple(branches))
    if point is not None:
        volts = of(point.parameter, point.motions)
        point = replace(point, voltages_by_motion=volts)
        if membrane.dielectric is not None:
            gains, speeds = (volts.bottom_v, volts.top_v), impact_velocities(device, point.parameter, point.motions)
            with np.errstate(all="ignore"):  # beyond the range of doubles there is no number
                strikes = Strikes(gains, speeds, point.motions.restitution)
                converted = conversion(strikes, membrane, membrane.dielectric, device.period_s)
            point = replace(point, conversion_by_motion=converted)
    return Solution(device, membrane, diagram, point)


def with_tolerances(solution: Solution, tolerances: TolerancesBlock) -> Solution:
    """A solution with tolerances of its inputs, which decide the ranges that a device can be set into."""
    if (point := solution.design) is None:
        return solution
    stable = (replace(part, off=tolerances.off(DesignInput(part.parameter))) for part in point.stable_ranges)
    return replace(solution, design=replace(point, stable_ranges=tuple(stable)))


def stable_motion(solution: Solution) -> tuple[DesignPoint, int] | None:
    """The first stable motion at the design point, or amid the first stable range: its design point and row there.

    None where no motion is stable.
    """
    design = solution.design
    if (design is None or not design.motions.stable_mask.any()) and solution.stable_ranges:
        part = solution.stable_ranges[0]
        device = solution.device.with_values({solution.parameter: (part.start + part.end) / 2})
        design = design_point(device, solution.diagram)
    if design is None or not design.motions.stable_mask.any():
        return None
    return design, int(np.argmax(design.motions.stable_mask))
