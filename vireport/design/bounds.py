"""Error bounds of the numbers of a solution: motions and voltages on its branches and at its design point."""

from __future__ import annotations

from typing import cast

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.design.point import DesignPoint, around_length
from vireport.motions.branches import Branch
from vireport.motions.diagram import BifurcationDiagram
from vireport.motions.error_bounds import one_to_one_bounds
from vireport.motions.one_to_one import Motions
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.energy import Dielectric, Membrane, Strikes, Voltages, conversion
from vireport.physics.numbers import ROUNDED, UNIT, Rounded, infinite_where_undefined
from vireport.physics.voltage_bounds import voltage_bounds

Floats = NDArray[np.float64]

FACTORS = 16
"""Roundings of the constant factors of an energy, a power or a field, which are computed in doubles, with room."""


class Bounds(Struct, frozen=True, eq=False):
    """Error bounds, by the names of `Motions` and `Voltages`; infinite where there is none.

    Attributes
    ----------
    branches : tuple of dict
        For each branch an array for each of its columns.
    design : dict or None
        For the motions at the design point.
    """

    branches: tuple[dict[str, Floats], ...]
    design: dict[str, Floats] | None

    __repr__ = brief


def bounds_of(
    device: Device, membrane: Membrane | None, diagram: BifurcationDiagram | None, design: DesignPoint | None
) -> Bounds:
    """Bound the errors of every motion and voltage along a sweep and at a design point."""
    sweep, branches = (diagram.sweep, diagram.branches) if diagram is not None else (None, ())
    over_sweep = tuple(_branch_bounds(membrane, sweep, branch) for branch in branches if sweep is not None)
    if design is None:
        return Bounds(over_sweep, None)
    bounds = _motion_bounds(membrane, around_length(device), design.motions, design.errors)
    if membrane is not None and design.conversion_by_motion is not None:
        bounds |= _conversion_bounds(device, membrane, design, bounds)
    return Bounds(over_sweep, bounds)


def _branch_bounds(membrane: Membrane | None, sweep: Sweep, branch: Branch) -> dict[str, Floats]:
    """Error bounds of the motions of a branch, at its critical points at least those of the points.

    A critical point may only have been bracketed.
    """
    bounds = _motion_bounds(membrane, sweep, branch.motions, None)
    for row, critical in branch.family.critical_points.items():
        labelled = {**critical.closed.bounds, "sweep_value": critical.error_bound}
        for name in ("sweep_value", "d", "gbar", "velocity_bottom", "velocity_top"):
            bounds[name][row] = max(bounds[name][row], labelled[name])
        bounds["q"][row] = max(bounds["q"][row], labelled["u"])
        bounds["phi_bottom"][row] = max(bounds["phi_bottom"][row], labelled["phi_bottom"])
    return bounds


def _motion_bounds(
    membrane: Membrane | None, sweep: Sweep, motions: Motions, solved: tuple[Floats, Floats] | None
) -> dict[str, Floats]:
    """Error bounds of motions and their voltages; `solved` are those of u and phase, where they are known."""
    bounds = one_to_one_bounds(sweep, motions, solved)
    if membrane is None:
        return bounds
    return {**bounds, **voltage_bounds(*_speeds(sweep, motions, bounds), membrane)}


def _speeds(sweep: Sweep, motions: Motions, bounds: dict[str, Floats]) -> tuple[Rounded, Rounded]:
    """Speeds of the impacts at the bottom and at the top [m/s]."""
    # The exact motion may be at another force or frequency, and so in another unit of velocity.
    value = Rounded(motions.sweep_value, bounds["sweep_value"])
    unit = sweep.device.velocity_unit(sweep.parameter, value)
    bottom = unit * Rounded(motions.velocity_bottom, bounds["velocity_bottom"])
    top = unit * Rounded(-motions.velocity_top, bounds["velocity_top"])
    return bottom, top


def _conversion_bounds(
    device: Device, membrane: Membrane, design: DesignPoint, bounds: dict[str, Floats]
) -> dict[str, Floats]:
    """Bound the errors of what a design point's motions convert, by the names of `Conversion`."""
    volts, dielectric = cast(Voltages, design.voltages_by_motion), cast(Dielectric, membrane.dielectric)
    gains = Rounded(volts.bottom_v, bounds["bottom_v"]), Rounded(volts.top_v, bounds["top_v"])
    speeds = _speeds(around_length(device), design.motions, bounds)
    with np.errstate(all="ignore"):
        strikes = Strikes(gains, speeds, design.motions.restitution)
        exact = conversion(strikes, membrane, dielectric, device.period_s, ROUNDED)
        numbers = {name: getattr(exact, name) for name in exact.__struct_fields__}
        return infinite_where_undefined(
            {name: x.error + FACTORS * UNIT * np.abs(x.value) for name, x in numbers.items()}
        )
