"""Voltage generated at an impact, from the impact velocity and the membrane.

SI units throughout. Takes plain arrays, so that analytic motions and simulated ones go through the same formulae.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Membrane:
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
    """

    stiffness: float
    exponent: float
    active_radius_m: float
    ball_radius_m: float
    bias_voltage_v: float
    ball_mass_kg: float


def deflection(speed: Floats, membrane: Membrane) -> Floats:
    """Largest deflection of the membrane [m], where its work K delta^(h+1)/(h+1) equals the ball's energy, Eq. (5.5).

    Parameters
    ----------
    speed : ndarray
        Relative speed at the impact [m/s].
    membrane : Membrane
    """
    power = membrane.exponent + 1
    scale = (power * membrane.ball_mass_kg / (2 * membrane.stiffness)) ** (1 / power)
    return np.asarray(scale * np.abs(speed) ** (2 / power))


def contact_cosine(delta: Floats, membrane: Membrane) -> tuple[Floats, Floats]:
    """Cosine of the angle alpha at which the membrane leaves the ball, Eq. (5.4), and 1 - cos(alpha).

    As printed, the cosine is a difference of nearly equal terms for small deflections. The same triangle gives
    sin(alpha) = delta (2 rb - delta)/(Rc rb + (rb - delta) t), t^2 = Rc^2 + (delta - rb)^2 - rb^2, for delta < rb,
    which keeps every digit.
    """
    ball, active = membrane.ball_radius_m, membrane.active_radius_m
    depth = delta - ball
    reach = np.sqrt((active - ball) * (active + ball) + depth * depth)
    square = active * active + depth * depth
    cosine = (active * reach - ball * depth) / square
    shallow = depth < 0
    sine = np.where(
        shallow,
        delta * (2 * ball - delta) / (active * ball + np.abs(depth) * reach),
        (depth * reach + active * ball) / square,
    )
    return cosine, np.where(cosine > 0.5, sine * sine / (1 + cosine), 1 - cosine)


def generated_voltage(speed: Floats, membrane: Membrane) -> Floats:
    """Voltage gained at an impact, U_imp - Uin [V], Eqs. (5.2)-(5.5).

    Parameters are those of `deflection`.

    Notes
    -----
    With c = cos(alpha), (5.3) is A/(pi Rc^2) = 1 + x, x = (1-c)[1 - (rb/Rc)^2 (1-c)]/c, and the gain Uin x (2 + x):
    no digits are lost for gentle impacts. The formulae go on beyond a deflection of Rc, where the membrane's
    geometry does not.
    """
    cosine, versine = contact_cosine(deflection(speed, membrane), membrane)
    ratio = (membrane.ball_radius_m / membrane.active_radius_m) ** 2
    stretch = versine * (1 - ratio * versine) / cosine
    return np.asarray(membrane.bias_voltage_v * stretch * (2 + stretch))


@dataclass(frozen=True, slots=True, eq=False)
class Voltages:
    """What the impacts of motions generate, arrays of one length.

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
    faster = np.maximum(np.abs(speed_bottom), np.abs(speed_top))
    return Voltages(bottom, top, (bottom + top) / 2, deflection(faster, membrane))
