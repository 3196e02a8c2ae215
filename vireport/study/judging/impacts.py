"""Quantities of impacts that requirements limit: for one design with error bounds, or for many designs."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from itertools import combinations
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.point import DesignPoint
from vireport.physics.energy import (
    Conversion,
    Dielectric,
    Membrane,
    Strikes,
    Voltages,
    conversion,
    conversion_of_word,
    deflection,
    generated_voltage,
    voltages,
)
from vireport.physics.groups import Restitution, by_wall
from vireport.physics.numbers import Arithmetic, ContinuousFunctions, Rounded
from vireport.scenario.parameters import Parameter
from vireport.study.judging.evidence import Evidence

if TYPE_CHECKING:
    from vireport.motions.families import Family

Floats = NDArray[np.float64]

FOLLOWED_ERROR = 1e-9
"""Relative error of what an impact of a motion that is followed comes to: its velocity is known to some 1e-12, and that
grows with less than its tenth power."""


class Impacts(Struct, frozen=True, eq=False):
    """Quantities of the impacts of motions, in SI units, in any kind of number (see `physics.numbers`).

    Attributes
    ----------
    gains : tuple
        U_imp - Uin at each impact of a period, Eq. (5.2) [V]; () where no energy is evaluated.
    average_v : array_like or None
        U_ave, their mean, Eq. (5.1) [V].
    deflection_m : array_like or None
        Largest deflection of a membrane, Eq. (5.5) [m].
    active_radius_m, bias_voltage_v : array_like or None
        Active radius [m] and bias voltage [V] of the membrane.
    power_mw : array_like or None
        Mean electrical power [mW]; this and the following are None where the membrane's dielectric is not given.
    efficiency : array_like or None
        Electrical efficiency [-].
    field_v_m, breakdown_field_v_m : array_like or None
        Highest electric field in a membrane, and the one that it withstands [V/m].
    """

    gains: tuple[Any, ...] = ()
    average_v: Any = None
    deflection_m: Any = None
    active_radius_m: Any = None
    bias_voltage_v: Any = None
    power_mw: Any = None
    efficiency: Any = None
    field_v_m: Any = None
    breakdown_field_v_m: Any = None


def largest(values: tuple[Any, ...], ops: ContinuousFunctions) -> Any:
    """The largest of some quantities of impacts, in the kind of number whose functions `ops` are."""
    return reduce(ops.maximum, values)


def spread(values: tuple[Any, ...], ops: ContinuousFunctions) -> Any:
    """The largest less the least of some quantities of impacts, as the largest difference of any two.

    The difference of the two extremes would have a larger bound: each extreme has the error of any of the impacts.
    """
    return largest(tuple(ops.distance(*pair) for pair in combinations(values, 2)), ops)


def generated(
    speeds: tuple[Any, Any], membrane: Membrane | None, restitution: Restitution, period_s: Arithmetic
) -> tuple[Voltages | None, Conversion | None]:
    """Voltages and converted energy of impacts with speeds [m/s] at the bottom and at the top, in arrays.

    Each is None where the membrane does not have the numbers for it; these may be arrays, too.
    """
    if membrane is None:
        return None, None
    volts = voltages(*speeds, membrane)
    if membrane.dielectric is None:
        return volts, None
    gains = volts.bottom_v, volts.top_v
    return volts, conversion(Strikes(gains, speeds, restitution), membrane, membrane.dielectric, period_s)


def impacts_of(volts: Voltages | None, converted: Conversion | None, membrane: Membrane | None) -> Impacts:
    """The quantities of impacts of 1:1 motions, from their voltages and converted energy."""
    if volts is None or membrane is None:
        return Impacts()
    of_membrane = membrane.active_radius_m, membrane.bias_voltage_v
    gained = (volts.bottom_v, volts.top_v), volts.average_v, volts.deflection_m, *of_membrane
    if converted is None:
        return Impacts(*gained)
    withstood = cast(Dielectric, membrane.dielectric).breakdown_field_v_m
    return Impacts(*gained, converted.power_mw, converted.efficiency, converted.field_v_m, withstood)


def at_design(results: Evidence) -> Impacts:
    """The impacts of the stable 1:1 motions at the design point, with error bounds.

    Raises
    ------
    NumericalError
        Where there is no such motion.
    """
    solution, design = results.solution, results.design
    motions, bounds = design.motions, cast(dict[str, Floats], solution.bounds.design)

    def bounded(values: Any, name: str) -> Rounded:
        return Rounded(values[motions.stable_mask], bounds[name][motions.stable_mask])

    def all_bounded(record: Any) -> Any:
        names = record.__struct_fields__
        return type(record)(*(bounded(getattr(record, name), name) for name in names))

    volts = None if design.voltages_by_motion is None else all_bounded(design.voltages_by_motion)
    converted = None if design.conversion_by_motion is None else all_bounded(design.conversion_by_motion)
    return impacts_of(volts, converted, solution.membrane)


def followed(results: Evidence) -> Iterator[tuple[Family, Impacts]]:
    """The impacts of each stable motion that is known at the design point, whatever its word, with bounds.

    Raises
    ------
    NumericalError
        Where none were followed there.
    """
    solution = results.solution
    device, parameter = solution.device, solution.parameter
    for family, motion in results.stable:
        value = cast(DesignPoint, solution.design).value
        speeds = np.abs(float(device.velocity_unit(parameter, value)) * motion.velocity)
        restitution = np.where(np.array(motion.word.walls) > 0, *by_wall(device.restitution))
        period_s = motion.word.periods / float(device.at(parameter, value)[Parameter.FREQUENCY])
        yield family, _followed(speeds, solution.membrane, restitution, period_s)


def _followed(speeds: Floats, membrane: Membrane | None, restitution: Floats, period_s: float) -> Impacts:
    def bounded(value: Any) -> Rounded:
        return Rounded(float(value), FOLLOWED_ERROR * float(value))

    if membrane is None:
        return Impacts()
    gains, deepest = generated_voltage(speeds, membrane), deflection(speeds, membrane).max()
    of_membrane = membrane.active_radius_m, membrane.bias_voltage_v
    gained = tuple(map(bounded, gains)), bounded(gains.mean()), bounded(deepest), *of_membrane
    if (dielectric := membrane.dielectric) is None:
        return Impacts(*gained)
    converted = conversion_of_word(Strikes(gains, speeds, restitution), membrane, dielectric, period_s)
    power, efficiency, field = map(bounded, converted)
    return Impacts(*gained, power, efficiency, field, dielectric.breakdown_field_v_m)


def other_motions(results: Evidence) -> list[tuple[str, Impacts]]:
    """Quantities of the stable motions other than 1:1 that are known at the design point, with their names.

    Only where the membrane's dielectric is given.
    """
    solution = results.solution
    if results.atlas is None or solution.membrane is None or solution.membrane.dielectric is None:
        return []
    one_to_one = "BT", solution.device.period_ratio
    try:
        families = list(followed(results))
    except NumericalError:  # the design point is not within the sweep
        return []
    return [(x.name, impacts) for x, impacts in families if (x.word.letters, x.word.periods) != one_to_one]
