"""The device in SI units, and the conversion between it and its dimensionless groups, in both directions.

No other module mixes the two kinds of quantity. The formulae serve every kind of number; see `numbers`.
"""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from math import cos, pi, radians, sin
from typing import Any, Generic

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray
from typing_extensions import TypeVar

from vireport.base.errors import UsageError
from vireport.physics.forcing import Harmonic, peaks
from vireport.physics.groups import Groups, Restitution, Restitutions, SpeedLaw, by_wall, map_restitution, stated
from vireport.physics.numbers import ARRAYS, UNIT, Arithmetic, ExactFunctions
from vireport.scenario.blocks import CapsuleMotion, Scenario
from vireport.scenario.keys import value_at
from vireport.scenario.parameters import DRIVING, DesignInput, Parameter, ScalarInput

NO_GRAVITY = 1e-15
"""gbar up to which gravity is lost in rounding: q - 1/2 ~ gbar could not be distinguished from zero. Within a sweep it
counts as zero; a scenario that holds such a gbar is refused (`Device.too_light`), as its folds would be elsewhere."""

FINEST_D, FINEST_GBAR = 1e-10, 1e-12
"""Least d or range of d, and least range of gbar, that are resolved, times (1-r)/n: positions are sums of terms of size
n/(1-r) in the length unit, and gbar keeps its digits next to zero."""

GROUP_ERROR = 12 * UNIT
"""Relative error of d or gbar as computed in doubles: the rounding of at most six products and of a sine."""


RESTITUTIONS = DesignInput.RESTITUTION, DesignInput.RESTITUTION_BOTTOM, DesignInput.RESTITUTION_TOP
"""Inputs that are restitutions: of both membranes together, and of each alone."""

MOVES: dict[str, tuple[float, float]] = dict(zip(RESTITUTIONS, ((1.0, 1.0), (1.0, 0.0), (0.0, 1.0)), strict=True))
"""Derivatives of the restitutions at the bottom and at the top by each of `RESTITUTIONS`."""

Quantity = TypeVar("Quantity", float, NDArray[np.float64], default=float)
"""A number of one device, or an array with a number for each of many."""

STANDARD_GRAVITY = 9.80665
"""g_n [m/s^2], the unit g of accelerations, whatever gravity a scenario states."""


class Shaker(Struct, frozen=True):
    """Demands on the shaker that drives the capsule, a mass M under a force of amplitude F; numbers or arrays.

    A free capsule recoils as well, see `Device.shaker`. Where the force has harmonics, the largest size stands for the
    amplitude of a sine.

    Attributes
    ----------
    acceleration_m_s2 : array_like
        Amplitude F/M; of a free capsule the largest between impacts, [F + m g (sin(beta) + mu_f cos(beta))]/M.
    velocity_m_s : array_like
        Amplitude F/(M omega), without the recoil.
    stroke_m : array_like
        Displacement from end to end, 2 F/(M omega^2); of a free capsule at most, (2 F/omega^2 + m s)/(M + m).
    force_n : array_like
        Amplitude F.
    """

    acceleration_m_s2: Any
    velocity_m_s: Any
    stroke_m: Any
    force_n: Any

    @property
    def acceleration_g(self) -> Any:
        """Amplitude of the acceleration over standard gravity [g]."""
        return self.acceleration_m_s2 / STANDARD_GRAVITY


class Device(Struct, Generic[Quantity], frozen=True):
    """The harvester and its excitation in SI units: one device, or arrays of many.

    Its dynamics follow from its `groups` alone.

    Attributes
    ----------
    capsule_mass_kg, gravity_m_s2 : float or ndarray
        M [kg], g [m/s^2].
    restitution : float or ndarray, or Restitutions, or SpeedLaw
        r of both membranes, or of each where they are not alike; or its law where it falls with speed.
    length_m, amplitude_n, frequency_hz, inclination_deg : float or ndarray, or None
        s, F, omega/2 pi, beta. One of the four may be None for a device that is swept over it.
    period_ratio : int
        n, forcing periods per motion, Eq. (3.14).
    capsule : CapsuleMotion
        Whether the shaker imposes the capsule's motion, or the force drives it and it recoils from the ball.
    ball_mass_kg : float or ndarray, or None
        m; None where the scenario does not state it. A free capsule needs it.
    harmonics : tuple of Harmonic
        Harmonics of the force; empty for a sine.
    friction : float
        Coefficient mu_f of dry friction between ball and capsule.

    Notes
    -----
    On a free capsule an impact changes the velocities of both bodies, and the support carries both weights, so that
    in the mean the capsule stays where it is. Along the capsule, over F/M and with mu = m/M,

        X'' = cos(pi t + phi) + mu gbar,    x'' = -gbar,    Z'' = X'' - x'' = cos(pi t + phi) + (1 + mu) gbar,

    gbar as with a prescribed motion. At an impact momentum and the law of restitution give Z'+ = -r Z'- and
    X'+ = X'- - mu (1 + r) Z'-/(1 + mu). So the relative motion is that of a prescribed capsule, with gbar (1 + mu)
    for gbar: `supported_kg` in place of M. The kinetic energy that an impact takes from both, their momentum being
    kept, is that of the relative motion, m/(1 + mu) Z'^2 (1 - r^2)/2: see `Membrane.reduced_mass_kg`.

    The ball's weight across the capsule presses it on the wall: friction is mu_f m g cos(beta) against Z', and as much
    the other way on a free capsule. It takes mu_f M g cos(beta)/F, with M + m for M on a free one, off Z'' where Z' is
    positive.
    """

    capsule_mass_kg: Quantity
    restitution: Any
    gravity_m_s2: Quantity
    length_m: Quantity
    amplitude_n: Quantity
    frequency_hz: Quantity
    inclination_deg: Quantity
    period_ratio: int = 1
    capsule: CapsuleMotion = CapsuleMotion.PRESCRIBED
    ball_mass_kg: Any = None
    harmonics: tuple[Harmonic, ...] = ()
    friction: float = 0.0

    @staticmethod
    def of(scenario: Scenario) -> Device:
        """The device of a scenario; a swept parameter is None without a design point."""
        values: dict[str, Any] = {varied: value_at(scenario, varied.path) for varied in DesignInput}
        bottom, top = (values.pop(varied) for varied in (DesignInput.RESTITUTION_BOTTOM, DesignInput.RESTITUTION_TOP))
        if values[DesignInput.RESTITUTION] is None:
            values[DesignInput.RESTITUTION] = _restitution(bottom, top)
        exponent, speed = scenario.device.restitution_exponent, scenario.device.restitution_speed_m_s
        if exponent:
            values[DesignInput.RESTITUTION] = SpeedLaw(*by_wall(values[DesignInput.RESTITUTION]), exponent, speed)
        return Device(
            **values,
            gravity_m_s2=scenario.gravity_m_s2,
            period_ratio=scenario.period_ratio,
            capsule=scenario.device.capsule,
            ball_mass_kg=scenario.device.ball_mass_kg,
            # A harmonic of 0 % would cost time in every evaluation, and be refused where only a sine is allowed.
            harmonics=tuple(
                Harmonic.of(harmonic.order, harmonic.percent, harmonic.phase_deg)
                for harmonic in scenario.excitation.harmonics
                if harmonic.percent
            ),
            friction=scenario.device.friction,
        )

    def at(self, parameter: Parameter, value: Arithmetic) -> dict[Parameter, Any]:
        """The four parameters that drive the ball, with the value of one replaced; a restitution replaces none."""
        return {name: value if name == parameter else getattr(self, name) for name in DRIVING}

    def with_values(self, values: Mapping[Any, Any]) -> Device[Quantity]:
        """The device with other values of some inputs, which are members of `DesignInput` or `Parameter`.

        `DesignInput.RESTITUTION` moves both membranes alike: it is the mean of both, whose difference is kept.
        """
        others = {varied: value for varied, value in values.items() if varied not in RESTITUTIONS}
        restitution = self.restitution
        for varied in (varied for varied in RESTITUTIONS if varied in values):
            restitution = moved(restitution, varied, values[varied])
        return replace(self, restitution=restitution, **others)

    def of_sine(self, what: str) -> Device[Quantity]:
        """The device itself, if its force is a sine and its ball a `plain_ball`; else a UsageError naming `what`."""
        if self.harmonics:
            allowed = "allowed: a sine, without excitation.harmonics"
            raise UsageError(f"of a force with harmonics {what} is not known ({allowed})")
        return self.plain_ball(what)

    def plain_ball(self, what: str) -> Device[Quantity]:
        """The device itself, if its ball has no friction and a `constant_restitution`; else a UsageError."""
        if self.friction:
            raise UsageError(f"of a ball with friction {what} is not known (allowed: none, without device.friction)")
        return self.constant_restitution(what)

    def constant_restitution(self, what: str) -> Device[Quantity]:
        """The device itself, if its restitutions do not depend on the speed.

        Parameters
        ----------
        what : str
            What requires a constant restitution, for the message.

        Raises
        ------
        UsageError
            If they fall with speed.
        """
        if self.law is not None:
            raise UsageError(
                f"of a restitution that falls with speed {what} is not known "
                "(allowed: a constant one, without device.restitution_exponent)"
            )
        return self

    @property
    def rubs(self) -> bool:
        """Whether dry friction acts on the ball: not in an upright capsule, on whose wall the ball does not press."""
        return bool(self.friction) and not np.all(self.inclination_deg == 90)

    @property
    def law(self) -> SpeedLaw | None:
        """The law of a restitution that falls with speed, in SI units; None for a constant restitution."""
        return self.restitution if isinstance(self.restitution, SpeedLaw) else None

    @property
    def recoils(self) -> bool:
        """Whether the capsule is free, so that it recoils from the ball."""
        return self.capsule == CapsuleMotion.FREE

    @property
    def mass_ratio(self) -> Any:
        """m/M for a capsule that recoils; 0 where its motion is prescribed."""
        return self.ball_mass_kg / self.capsule_mass_kg if self.recoils else 0.0

    @property
    def supported_kg(self) -> Any:
        """Mass whose weight along the capsule is in gbar: M, and M + m for a free capsule [kg]."""
        return self.capsule_mass_kg + self.ball_mass_kg if self.recoils else self.capsule_mass_kg

    @property
    def weighed(self) -> str:
        """The symbols of the mass whose weight is in gbar, as messages print it."""
        return "(M + m)" if self.recoils else "M"

    @property
    def alike(self) -> bool:
        """Whether both membranes have one restitution: a horizontal capsule is then its own mirror image."""
        if self.law is not None:
            return bool(self.law.bottom == self.law.top)
        return not isinstance(self.restitution, Restitutions)

    @property
    def inputs(self) -> tuple[DesignInput, ...]:
        """The independent inputs of the device: one restitution if the membranes are alike, else two."""
        redundant = RESTITUTIONS[1:] if self.alike else RESTITUTIONS[:1]
        return tuple(varied for varied in DesignInput if varied not in redundant)

    def value_of(self, varied: ScalarInput) -> Any:
        """The value of an input; for the restitution of both membranes, their mean."""
        if varied not in RESTITUTIONS:
            return getattr(self, varied)
        return value_in(self.restitution, varied)

    def groups(self, parameter: Parameter, value: Arithmetic, ops: ExactFunctions = ARRAYS) -> Groups[Any]:
        """The groups at a value of a parameter: d = 4 M s f^2/F, gbar = M g sin(beta)/F, r, harmonics and friction.

        For a free capsule gbar is (M + m) g sin(beta)/F. A gbar up to `NO_GRAVITY` becomes zero.

        Parameters
        ----------
        parameter : Parameter
        value : array_like
            In the parameter's unit.
        ops
            Functions of the kind of number that the groups shall have, see `numbers`.

        Source: Eqs. (2.5), (2.6).
        """
        # In the kind of number from the first product on: a rounding before it would be no part of the error bound.
        x = {name: ops.exact(number) for name, number in self.at(parameter, value).items()}
        mass, force = ops.exact(self.capsule_mass_kg), x[Parameter.AMPLITUDE]
        d = 4 * mass * x[Parameter.LENGTH] * x[Parameter.FREQUENCY] ** 2 / force
        weight = self._supported(ops) * ops.exact(self.gravity_m_s2)
        gbar = weight * ops.sin_degrees(x[Parameter.INCLINATION]) / force
        harmonics = tuple(harmonic.exact(ops) for harmonic in self.harmonics)
        restitution = map_restitution(self.restitution, ops.exact)
        if parameter.bounces:
            restitution = moved(restitution, parameter, ops.exact(value))
        if isinstance(restitution, SpeedLaw):
            # From m/s to y_c = F/(2 M f), the unit of dimensionless velocities.
            restitution = replace(restitution, speed=2 * restitution.speed * mass * x[Parameter.FREQUENCY] / force)
        friction = None
        if self.rubs:
            across = ops.sin_degrees(90 - x[Parameter.INCLINATION])
            friction = ops.exact(self.friction) * weight * across / force
        return Groups(d, gbar * (gbar > NO_GRAVITY), restitution, harmonics, friction)

    def value(self, parameter: Parameter, d: Arithmetic, gbar: Arithmetic, ops: ExactFunctions = ARRAYS) -> Any:
        """The value of a parameter at which the device has some d and gbar, the other three parameters as they are.

        The inverse of `groups`: from gbar for the inclination, otherwise from d.

        Raises
        ------
        ValueError
            If the parameter is a restitution, which d and gbar do not depend on.
        """
        if parameter.bounces:
            raise ValueError(f"d and gbar do not say what {parameter} is")
        mass = ops.exact(self.capsule_mass_kg)
        if parameter is Parameter.INCLINATION:
            weight = self._supported(ops) * ops.exact(self.gravity_m_s2)
            return ops.arcsin_degrees(gbar * ops.exact(self.amplitude_n) / weight)
        if parameter is Parameter.LENGTH:
            return d * ops.exact(self.amplitude_n) / (4 * mass * ops.exact(self.frequency_hz) ** 2)
        if parameter is Parameter.AMPLITUDE:
            return 4 * mass * ops.exact(self.length_m) * ops.exact(self.frequency_hz) ** 2 / d
        return ops.sqrt(d * ops.exact(self.amplitude_n) / (4 * mass * ops.exact(self.length_m)))

    def _supported(self, ops: ExactFunctions) -> Any:
        """The mass whose weight along the capsule is in gbar, `supported_kg`, in a kind of number."""
        # Not from the sum of doubles: in decimals M + m must be exact.
        mass = ops.exact(self.capsule_mass_kg)
        return mass + ops.exact(self.ball_mass_kg) if self.recoils else mass

    def friction_slope(self, varied: DesignInput) -> float:
        """Derivative of `Groups.friction` by an input of a device with all inputs."""
        friction = self.friction * self.supported_kg * self.gravity_m_s2 / self.amplitude_n
        angle, value = radians(self.inclination_deg), float(self.value_of(varied))
        match varied:
            case DesignInput.INCLINATION:
                return float(-friction * sin(angle) * pi / 180)
            case DesignInput.AMPLITUDE:
                return float(-friction * cos(angle) / value)
            case DesignInput.CAPSULE_MASS:
                return float(friction * cos(angle) / self.supported_kg)
        return 0.0

    def law_slope(self, varied: DesignInput) -> float:
        """Derivative by an input of the speed at which a restitution that falls with speed is stated [y_c]."""
        value = float(self.value_of(varied))
        stated_at = float(self.restitution.speed / self.velocity_unit(Parameter.LENGTH, self.length_m))
        if varied is DesignInput.AMPLITUDE:
            return -stated_at / value
        return stated_at / value if varied in (DesignInput.CAPSULE_MASS, DesignInput.FREQUENCY) else 0.0

    def slopes(self, varied: DesignInput, d: float, gbar: float) -> tuple[float, float, float, float]:
        """Derivatives of d, gbar, r at the bottom and r at the top by an input of a device with all inputs.

        Parameters
        ----------
        varied : DesignInput
        d, gbar : float
            Groups of the device.

        See Also
        --------
        friction_slope : Derivative of friction.
        law_slope : Derivative of the speed of a law.
        """
        value = float(self.value_of(varied))
        match varied:
            case DesignInput.INCLINATION:
                upright = self.supported_kg * self.gravity_m_s2 / self.amplitude_n
                return 0.0, float(upright * cos(radians(value)) * pi / 180), 0.0, 0.0
            case DesignInput.RESTITUTION | DesignInput.RESTITUTION_BOTTOM | DesignInput.RESTITUTION_TOP:
                return 0.0, 0.0, *MOVES[varied]
            case DesignInput.AMPLITUDE:
                return -d / value, -gbar / value, 0.0, 0.0
            case DesignInput.CAPSULE_MASS:
                # gbar has M + m for a free capsule, so that dgbar/dM is over that sum.
                return d / value, gbar / float(self.supported_kg), 0.0, 0.0
            case DesignInput.FREQUENCY:
                return 2 * d / value, 0.0, 0.0, 0.0
        return d / value, 0.0, 0.0, 0.0

    def velocity_unit(self, parameter: Parameter, value: Any) -> Any:
        """The unit of velocity y_c = F/(2 M f) [m/s] where `parameter` has a value, Eq. (2.5)."""
        x = self.at(parameter, value)
        return x[Parameter.AMPLITUDE] / (2 * self.capsule_mass_kg * x[Parameter.FREQUENCY])

    def shaker(self, parameter: Parameter, value: Arithmetic) -> Shaker:
        """Demands on the shaker where `parameter` has a value, by M X'' = F cos(omega t + phi) and its harmonics.

        Source: Eq. (2.1).

        Notes
        -----
        Impacts do not move the centre of mass of ball and free capsule: with P'' = cos(pi t + phi) periodic,
        X = (P + mu Z)/(1 + mu), and Z stays between the membranes, which are d apart. This bounds the stroke of every
        motion, and is nearly its value where mu is small. A ball that is not in step with the force takes away what the
        bound adds: of a ball a third of the capsule's mass the bound may be twice the stroke.
        """
        x = self.at(parameter, value)
        force, omega = x[Parameter.AMPLITUDE], 2 * pi * x[Parameter.FREQUENCY]
        acceleration = force / self.capsule_mass_kg
        stroke = 2 * acceleration / omega**2
        velocity = acceleration / omega
        if self.harmonics:
            # Each has its largest value at another phase, which is not that of a sine.
            largest = peaks(self.harmonics)
            force, acceleration = force * largest.force, acceleration * largest.force
            velocity, stroke = velocity * largest.impulse, stroke * largest.path
        if self.recoils:
            ratio = self.mass_ratio
            stroke = (stroke + ratio * x[Parameter.LENGTH]) / (1 + ratio)
            # The rest of the ball's weight that the support carries pushes the free capsule up while the ball flies.
            sine = ARRAYS.sin_degrees(x[Parameter.INCLINATION])
            if self.rubs:
                sine = sine + self.friction * ARRAYS.sin_degrees(90 - x[Parameter.INCLINATION])
            acceleration = acceleration + ratio * self.gravity_m_s2 * sine
        return Shaker(acceleration, velocity, stroke, force)

    @property
    def period_s(self) -> float:
        """Period of the motion, n periods of the forcing [s]."""
        return float(self.period_ratio / self.frequency_hz)

    def finest(self, of: float) -> float:
        """Least d, or least range of d or gbar, that double precision resolves.

        Parameters
        ----------
        of : float
            `FINEST_D` or `FINEST_GBAR`.
        """
        # Motions take n periods, and their velocities grow as 1/(1 - r): so do their roundings.
        return of * self.period_ratio / (1 - float(max(stated(self.restitution))))

    def too_short(self, parameter: Parameter, value: Arithmetic) -> str:
        """Reason why double precision does not resolve the length where `parameter` has a value; "" if it does."""
        d = self.groups(parameter, value)[0]
        if d >= (finest := self.finest(FINEST_D)):
            return ""
        return (
            f"d = s/x_c = {d:.3g}: the capsule is so short against the forcing's displacement that its length is "
            f"lost in rounding (allowed: d of at least {finest:.3g}; a longer capsule, higher frequency or "
            "smaller force)"
        )

    def too_light(self, parameter: Parameter, value: Arithmetic) -> str:
        """Reason why double precision does not resolve gravity where `parameter` has a value; "" if it does."""
        gbar = self.groups(parameter, value)[1]
        if gbar > 0 or self.at(parameter, value)[Parameter.INCLINATION] == 0:
            return ""
        return (
            f"gbar = {self.weighed} g sin(beta)/F is positive and at most {NO_GRAVITY:g}: gravity is lost in rounding "
            "against the forcing (allowed: inclination_deg: 0, a larger inclination, or a smaller force)"
        )

    @property
    def unresolved(self) -> str:
        """Reason why double precision does not resolve a device with all four parameters; "" if it does."""
        at = Parameter.LENGTH, self.length_m
        return self.too_short(*at) or self.too_light(*at)


def carried(varied: DesignInput, by: DesignInput) -> float:
    """Derivative of an input by another: zero but for an input by itself, and among restitutions.

    The restitution of both membranes moves each by as much; the restitution of one moves the mean of both by half.
    """
    if varied is by:
        return 1.0
    if DesignInput.RESTITUTION in (varied, by) and varied in RESTITUTIONS and by in RESTITUTIONS:
        return 0.5 if varied is DesignInput.RESTITUTION else 1.0
    return 0.0


def _restitution(bottom: Any, top: Any) -> Any:
    """The restitution of a device with two membranes: one number if both are the same."""
    return bottom if np.ndim(bottom) == np.ndim(top) == 0 and bottom == top else Restitutions(bottom, top)


def value_in(restitution: Restitution | SpeedLaw, varied: ScalarInput) -> Any:
    """The value of one of `RESTITUTIONS` in the restitution of a device or motion; for both membranes, their mean."""
    bottom, top = stated(restitution)
    if varied == DesignInput.RESTITUTION:
        return bottom if bottom is top else (bottom + top) / 2
    return bottom if varied == DesignInput.RESTITUTION_BOTTOM else top


def moved(restitution: Restitution | SpeedLaw, varied: ScalarInput, value: Arithmetic) -> Any:
    """The restitution with another value at one membrane, or with another mean and the same difference.

    Parameters
    ----------
    restitution : array_like, Restitutions or SpeedLaw
    varied : ScalarInput
        One of `RESTITUTIONS`.
    value : array_like
    """
    if isinstance(restitution, SpeedLaw):
        bottom, top = stated(moved(_restitution(restitution.bottom, restitution.top), varied, value))
        return replace(restitution, bottom=bottom, top=top)
    bottom, top = by_wall(restitution)
    if varied == DesignInput.RESTITUTION_BOTTOM:
        return _restitution(value, top)
    if varied == DesignInput.RESTITUTION_TOP:
        return _restitution(bottom, value)
    if not isinstance(restitution, Restitutions):
        return value
    # Decimals and doubles do not mix: what the scenario states is exact in both.
    if isinstance(value, Decimal):
        bottom, top = Decimal(bottom), Decimal(top)
    half = (bottom - top) / 2
    return Restitutions(value + half, value - half)
