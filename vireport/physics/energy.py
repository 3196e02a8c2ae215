"""Voltage and energy generated at an impact, from the impact velocity and the membrane.

An impact deflects the membrane (`deflection`, Eq. (5.5)), which then meets the ball at an angle (`contact_cosine`,
(5.4)) and has a larger area (`area_growth`, (5.3)); from the area follow the voltage (`generated_voltage`, (5.2)) and,
with a dielectric, the energy (`conversion`). SI units throughout. Takes plain arrays, so that analytic motions and
simulated ones go through the same formulae.
"""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.physics.device import Device
from vireport.physics.groups import Restitutions, by_wall
from vireport.physics.numbers import ARRAYS, Arithmetic, ContinuousFunctions, magnitude
from vireport.scenario.blocks import CapsuleMotion, MembraneBlock, Scenario
from vireport.scenario.parameters import LARGEST, SMALLEST
from vireport.text.formatting import quantity

Floats = NDArray[np.float64]

VACUUM_PERMITTIVITY = 8.8541878188e-12
"""epsilon_0 [F/m], CODATA 2022."""

INSIDE = 1e-12
"""Relative allowance on a stiffness, mass or radius that just keeps a deflection within the radius: above the rounding
of (5.5)."""


class Dielectric(Struct, frozen=True):
    """Electrical properties of the material of a membrane.

    Attributes
    ----------
    thickness_m : float
        Of the undeformed membrane [m].
    relative_permittivity : float
        [-].
    breakdown_field_v_m : float
        Field that the material withstands [V/m].
    """

    thickness_m: float
    relative_permittivity: float
    breakdown_field_v_m: float


class Membrane(Struct, frozen=True):
    """A dielectric membrane and the ball that strikes it.

    Attributes
    ----------
    stiffness : float
        K of the force K delta^h [N/m^h].
    exponent : float
        h [-].
    active_radius_m : float
        Rc of the membrane [m].
    ball_radius_m : float
        rb, smaller than Rc [m].
    bias_voltage_v : float
        Uin, the voltage applied [V].
    ball_mass_kg : float
        m [kg].
    dielectric : Dielectric or None
        None where only voltages are evaluated.
    free_capsule_kg : float
        M of a free capsule, whose membranes recoil with it; infinite where its motion is prescribed.
    """

    stiffness: float
    exponent: float
    active_radius_m: float
    ball_radius_m: float
    bias_voltage_v: float
    ball_mass_kg: float
    dielectric: Dielectric | None = None
    free_capsule_kg: float = inf

    @property
    def reduced_mass_kg(self) -> float:
        """Mass in the kinetic energy of the relative motion, m/(1 + m/M); m for a prescribed motion of the capsule."""
        return self.ball_mass_kg / (1 + self.ball_mass_kg / self.free_capsule_kg)

    def of_device(self, device: Device[Any]) -> Membrane:
        """The membrane struck by the ball of a device, on its capsule; the device must state the ball's mass."""
        free = device.capsule_mass_kg if device.recoils else inf
        return replace(self, ball_mass_kg=device.ball_mass_kg, free_capsule_kg=free)

    @staticmethod
    def of(scenario: Scenario) -> Membrane | None:
        """The membrane of a scenario and the ball that strikes it; None if it does not state the ball's mass."""
        mass, block = scenario.device.ball_mass_kg, scenario.device.membrane or MembraneBlock()
        if mass is None:
            return None
        return Membrane(
            block.stiffness,
            block.exponent,
            block.active_radius_m,
            block.ball_radius_m,
            block.bias_voltage_v,
            mass,
            _dielectric_of(block),
            scenario.device.capsule_mass_kg if scenario.device.capsule is CapsuleMotion.FREE else inf,
        )


def _dielectric_of(block: MembraneBlock) -> Dielectric | None:
    """The dielectric of a membrane; None if the scenario does not state all its properties."""
    thickness, permittivity, breakdown = block.thickness_m, block.relative_permittivity, block.breakdown_field_v_m
    if thickness is None or permittivity is None or breakdown is None:
        return None
    return Dielectric(thickness, permittivity, breakdown)


def deflection(speed: Floats, membrane: Membrane) -> Floats:
    """Largest deflection of the membrane [m], where its work K delta^(h+1)/(h+1) equals the ball's energy, Eq. (5.5).

    On a free capsule that is the energy of the relative motion.

    Parameters
    ----------
    speed : ndarray
        Relative velocity at the impact, of either sign [m/s].
    membrane : Membrane
    """
    power = membrane.exponent + 1
    scale = (power * membrane.reduced_mass_kg / (2 * membrane.stiffness)) ** (1 / power)
    return np.asarray(scale * magnitude(speed) ** (2 / power))


def impact_speed(depth_m: Floats | float, membrane: Membrane) -> Floats:
    """Relative speed of the impact that deflects a membrane by some depth [m/s], the inverse of `deflection`."""
    power = membrane.exponent + 1
    scale = (2 * membrane.stiffness / (power * membrane.reduced_mass_kg)) ** 0.5
    return np.asarray(scale * np.asarray(depth_m) ** (power / 2))


def contact_cosine(delta: Floats, membrane: Membrane) -> tuple[Floats, Floats]:
    """Cosine of the angle alpha at which the membrane leaves the ball, Eq. (5.4), and 1 - cos(alpha).

    As printed, the cosine is a difference of nearly equal terms for small deflections. The same triangle gives
    sin(alpha) = delta (2 rb - delta)/(Rc rb + (rb - delta) t), t^2 = Rc^2 + (delta - rb)^2 - rb^2, for delta < rb,
    which keeps every digit.

    The membrane is a cone from its rim, tangent to the ball, and a cap on the ball. That shape exists at every depth,
    as the ball is smaller than the rim.
    """
    ball, active = membrane.ball_radius_m, membrane.active_radius_m
    depth = delta - ball
    reach = np.sqrt((active - ball) * (active + ball) + depth * depth)
    square = active * active + depth * depth
    cosine = (active * reach - ball * depth) / square
    # Two forms of the sine: for a deflection below rb the numerator of the second one cancels, and 1 - cos, which the
    # voltage of a gentle impact depends on, would keep no digits. At rb and above nothing cancels.
    shallow = depth.real < 0
    sine = np.where(
        shallow,
        delta * (2 * ball - delta) / (active * ball + magnitude(depth) * reach),
        (depth * reach + active * ball) / square,
    )
    return cosine, np.where(cosine.real > 0.5, sine * sine / (1 + cosine), 1 - cosine)


def generated_voltage(speed: Floats, membrane: Membrane) -> Floats:
    """Voltage gained at an impact, U_imp - Uin [V], Eqs. (5.2)-(5.5).

    Parameters are those of `deflection`.

    Notes
    -----
    With x = A/(pi Rc^2) - 1 the gain is Uin x (2 + x): no digits are lost for gentle impacts.
    """
    growth = area_growth(deflection(speed, membrane), membrane)
    return np.asarray(membrane.bias_voltage_v * growth * (2 + growth))


def area_growth(delta: Floats, membrane: Membrane) -> Floats:
    """Areal strain A/(pi Rc^2) - 1 of a membrane deflected by some depth [m], Eq. (5.3).

    With c = cos(alpha) it is (1-c)[1 - (rb/Rc)^2 (1-c)]/c.
    """
    cosine, versine = contact_cosine(delta, membrane)
    ratio = (membrane.ball_radius_m / membrane.active_radius_m) ** 2
    return np.asarray(versine * (1 - ratio * versine) / cosine)


class MembraneStretch(Struct, frozen=True):
    """Stretch of a membrane at its largest deflection, by Eqs. (5.2)-(5.5).

    Attributes
    ----------
    depth_m : float
        Largest deflection [m].
    depth_ratio : float
        Largest deflection over the active radius [-].
    area_ratio : float
        A/A0, area at that deflection over the flat one [-].
    peak_v : float
        U_imp [V].
    """

    depth_m: float
    depth_ratio: float
    area_ratio: float
    peak_v: float

    def thickness_at(self, field_v_m: float) -> float:
        """Thickness of the undeformed membrane at which U_imp gives some electric field [m]."""
        return self.peak_v / field_v_m


def stretch_of(depth_m: float, membrane: Membrane) -> MembraneStretch:
    """Stretch and voltage of a membrane at a given deflection.

    Parameters
    ----------
    depth_m : float
        Deflection [m].
    membrane : Membrane
    """
    area = 1 + float(area_growth(np.asarray(depth_m), membrane))
    return MembraneStretch(depth_m, depth_m / membrane.active_radius_m, area, membrane.bias_voltage_v * area * area)


class Voltages(Struct, frozen=True, eq=False):
    """Voltages that the impacts of 1:1 motions generate, arrays of one length.

    Attributes
    ----------
    bottom_v, top_v : ndarray
        U_imp - Uin at the impact on either membrane [V].
    average_v : ndarray
        U_ave, the mean over the impacts, Eq. (5.1) [V].
    deflection_m : ndarray
        Larger deflection of the two impacts [m].
    """

    bottom_v: Floats
    top_v: Floats
    average_v: Floats
    deflection_m: Floats

    def __repr__(self) -> str:
        ends = (quantity(float(end(self.average_v)), "V") for end in (np.min, np.max)) if self.average_v.size else ()
        return f"<Voltages of {self.average_v.size} motions: U_ave {' to '.join(ends) or 'of none'}>"


def voltages(speed_bottom: Floats, speed_top: Floats, membrane: Membrane) -> Voltages:
    """Evaluate Eqs. (5.1)-(5.5) for motions with one impact on each membrane.

    Parameters
    ----------
    speed_bottom, speed_top : ndarray
        Relative velocities at the impacts, of either sign [m/s].
    membrane : Membrane
    """
    bottom = generated_voltage(speed_bottom, membrane)
    top = generated_voltage(speed_top, membrane)
    # (5.5) grows with the speed: the deeper deflection is that of the faster impact.
    faster = np.maximum(magnitude(speed_bottom), magnitude(speed_top))
    return Voltages(bottom, top, (bottom + top) / 2, deflection(faster, membrane))


class Conversion(Struct, frozen=True, eq=False):
    """Electrical energy that motions with one impact on each membrane convert, numbers or arrays of one shape.

    Attributes
    ----------
    energy_bottom_j, energy_top_j : array_like
        Electrical energy gained at either impact [J].
    power_mw : array_like
        Mean power: the energy of both impacts over the period of the motion [mW].
    efficiency : array_like
        The energy of both impacts over the kinetic energy that is lost at them [-].
    field_v_m : array_like
        Highest electric field in either membrane [V/m].
    """

    energy_bottom_j: Any
    energy_top_j: Any
    power_mw: Any
    efficiency: Any
    field_v_m: Any

    __repr__ = brief


def flat_capacitance(membrane: Membrane, dielectric: Dielectric) -> Any:
    """C0 = epsilon_0 epsilon_r pi Rc^2/k of the undeformed membrane of thickness k [F]."""
    flat = np.pi * membrane.active_radius_m**2
    return VACUUM_PERMITTIVITY * dielectric.relative_permittivity * flat / dielectric.thickness_m


class ElectricalCycle(Struct, frozen=True):
    """The cycle of a membrane at an impact in the plane of charge and voltage: a triangle from the origin.

    It is charged at its largest area up to the bias, then isolated until it is flat, then discharged.

    Attributes
    ----------
    charge_c : float
        Charge that the membrane holds while it is isolated [C].
    bias_v, peak_v : float
        Voltage before and after it is flat again, Uin and U_imp [V].
    """

    charge_c: float
    bias_v: float
    peak_v: float

    @property
    def corners(self) -> tuple[Floats, Floats]:
        """Charges [C] and voltages [V] on the way round, back to the first."""
        return np.array([0.0, 1, 1, 0]) * self.charge_c, np.array([0.0, self.bias_v, self.peak_v, 0.0])

    @property
    def area_j(self) -> float:
        """Electrical energy that is gained, the integral of the voltage over the charge on the way round [J]."""
        charge, volts = self.corners
        return float(-np.sum((volts[1:] + volts[:-1]) / 2 * np.diff(charge)))


def cycle_of(gain: float, membrane: Membrane, dielectric: Dielectric) -> ElectricalCycle:
    """The cycle of an impact that gains U_imp - Uin, Eq. (5.2); `conversion` derives it.

    Parameters
    ----------
    gain : float
        U_imp - Uin [V].
    membrane : Membrane
    dielectric : Dielectric
    """
    peak = membrane.bias_voltage_v + gain
    return ElectricalCycle(float(flat_capacitance(membrane, dielectric)) * peak, membrane.bias_voltage_v, peak)


class Strikes(NamedTuple):
    """Impacts on the membranes, by what their energy conversion depends on.

    Attributes
    ----------
    gains : sequence of array_like
        U_imp - Uin of each impact, Eq. (5.2) [V].
    speeds : sequence of array_like
        Relative velocity just before it, of either sign [m/s].
    restitution : array_like or Restitutions
        r < 1 of the membranes, or of each impact.
    """

    gains: Any
    speeds: Any
    restitution: Any


def conversion(
    strikes: Strikes,
    membrane: Membrane,
    dielectric: Dielectric,
    period_s: Arithmetic,
    ops: ContinuousFunctions = ARRAYS,
) -> Conversion:
    """Evaluate the energy conversion of motions with one impact on each membrane.

    Parameters
    ----------
    strikes : Strikes
        Pairs, the impact on the bottom first.
    membrane : Membrane
    dielectric : Dielectric
        Of the membrane.
    period_s : array_like
        Of the motion [s].
    ops
        Functions of the kind of number, see `numbers`.

    Source: the cycle is that of Koh et al., see below; the equations of the paper are (5.1)-(5.5).

    Notes
    -----
    An incompressible membrane of area A has the capacitance C = C0 (A/(pi Rc^2))^2, C0 = epsilon_0 epsilon_r pi Rc^2/k
    with the thickness k. Charged to Uin at its largest area and then isolated, it has the voltage U_imp of (5.2) when
    it is flat again, and has gained the energy of a cycle of constant charge,

        C Uin^2/2 (C/C0 - 1) = C0 U_imp (U_imp - Uin)/2,

    the area of the cycle in the plane of voltage and charge (Koh et al., IEEE/ASME Trans. Mechatronics 16 (2011)
    33-41). The field is highest then, U_imp/k: on the way the thickness grows as 1/A, and the voltage faster. Leakage,
    the circuit's losses and the electrical force on the membrane, which r stands for, are not included. An impact on a
    membrane of the heavy capsule takes m V^2 (1 - r^2)/2 from the ball, and one of a free capsule m/(1 + mu) for m from
    both.
    """
    gains, speeds, restitution = strikes
    bottom, top = (energy_gained(gain, membrane, dielectric) for gain in gains)
    squares = [speed * speed for speed in speeds]
    if isinstance(restitution, Restitutions):
        # As a product 1 - r^2 keeps its digits next to r = 1.
        shares = [(1 - r) * (1 + r) for r in by_wall(restitution)]
        spent = membrane.reduced_mass_kg / 2 * (shares[0] * squares[0] + shares[1] * squares[1])
    else:
        lost = membrane.reduced_mass_kg * (1 - restitution) * (1 + restitution) / 2
        spent = lost * (squares[0] + squares[1])
    field = (ops.maximum(*gains) + membrane.bias_voltage_v) / dielectric.thickness_m
    return Conversion(bottom, top, 1e3 / period_s * (bottom + top), (bottom + top) / spent, field)


def energy_gained(gain: Arithmetic, membrane: Membrane, dielectric: Dielectric) -> Any:
    """Electrical energy gained at an impact with a gain of voltage U_imp - Uin [V]: C0 U_imp (U_imp - Uin)/2 [J]."""
    return flat_capacitance(membrane, dielectric) / 2 * gain * (gain + membrane.bias_voltage_v)


def conversion_of_word(
    strikes: Strikes, membrane: Membrane, dielectric: Dielectric, period_s: float
) -> tuple[float, float, float]:
    """Mean power [mW], efficiency [-] and highest field [V/m] of one motion with any impacts, see `conversion`.

    Parameters
    ----------
    strikes : Strikes
        Arrays over the impacts of a period.
    membrane : Membrane
    dielectric : Dielectric
    period_s : float
        Of the motion [s].
    """
    gains, speeds, restitution = strikes
    gained = float(energy_gained(gains, membrane, dielectric).sum())
    lost = membrane.reduced_mass_kg / 2 * float(((1 - restitution) * (1 + restitution) * speeds * speeds).sum())
    return (
        1e3 * gained / period_s,
        gained / lost,
        (float(gains.max()) + membrane.bias_voltage_v) / dielectric.thickness_m,
    )


class Fitting(Struct, frozen=True, eq=False):
    """Ball mass, stiffness and active radius that limit the deflection to the radius, each with the others as they are.

    Attributes
    ----------
    ball_mass_kg : float or None
        Largest ball mass [kg]; None outside a scenario's range, as below.
    stiffness : float or None
        Least K [N/m^h].
    active_radius_m : float or None
        Least Rc [m].
    """

    ball_mass_kg: float | None
    stiffness: float | None
    active_radius_m: float | None


def fitting(membrane: Membrane, deepest_m: float) -> Fitting:
    """Solve (5.5) for the ball mass, stiffness and radius that keep a deflection within the membrane's active radius.

    The velocity of the impact stays as it is. By (5.5) delta^(h+1) is proportional to m/K, m the reduced mass, and does
    not depend on Rc.

    Parameters
    ----------
    membrane : Membrane
    deepest_m : float
        Largest deflection, above the active radius [m].
    """
    # Of extreme scenarios the power over- or underflows: what comes out is beyond the range of scenarios, and None.
    with np.errstate(over="ignore", under="ignore"):
        factor = float(np.power(deepest_m / membrane.active_radius_m, membrane.exponent + 1)) * (1 + INSIDE)
    lighter = membrane.reduced_mass_kg / factor
    ball = lighter / (1 - lighter / membrane.free_capsule_kg)  # the inverse of `reduced_mass_kg`
    values = ball, membrane.stiffness * factor, deepest_m * (1 + INSIDE)
    return Fitting(*(value if SMALLEST <= value <= LARGEST else None for value in values))
