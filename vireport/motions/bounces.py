"""1:1 motions at one d and gbar: for every (q, phase) exactly one pair of restitutions has a motion there.

Flights do not depend on the membranes: duration, distance d and gravity give the velocities at both ends. The quotient
of the velocities after and before an impact is -r. So, with the impulse I and the path P of the force at the impacts,
e = d + (P_b - P_t)/pi^2, and gravity g_u up and g_d down (gbar, and friction),

    after the bottom   a_b = -e/Tu - g_u Tu/2 + I_b/pi        before the top      w_t = -e/Tu + g_u Tu/2 + I_t/pi
    after the top      a_t =  e/Td - g_d Td/2 + I_t/pi        before the bottom   w_b =  e/Td + g_d Td/2 + I_b/pi

and r_b = -a_b/w_b, r_t = -a_t/w_t. A sweep over a restitution is the curve on which one quantity is held constant:

- over r_b it holds r_t, or the other way round: a_t + r_t w_t = 0, linear in sine and cosine of the phase;
- over both it holds D = r_b - r_t: a_b w_t - a_t w_b + D w_b w_t = 0, of the second degree in sine and cosine.

Harmonics multiply these degrees. No membrane is in the formulae, so they have no digits to lose where r is near 1, as
the surface of `orbits` has.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec import Struct

from vireport.motions.level_plane import ContourPlane
from vireport.motions.orbits import Orbits
from vireport.physics.forcing import SINE
from vireport.physics.groups import Restitutions, by_wall
from vireport.physics.numbers import ARRAYS, IMAGINARY_STEP, Arithmetic, ContinuousFunctions, DoubleOps
from vireport.scenario.parameters import Parameter

FARTHEST_BELOW = -0.5
"""Restitution below which a part of the level is not followed: motions have 0 and more, and are not near it."""

SERIES = 1e-3
"""|x| below which sin(pi x)/(pi x) is its series: as a quotient it keeps no digits of an imaginary step."""


class _Stepped(DoubleOps):
    """Functions of arrays of doubles with an imaginary step, for derivatives that are exact."""

    @staticmethod
    def sinc(x: Any) -> Any:
        """sin(pi x)/(pi x), also exact in the imaginary part."""
        square = (np.pi * x) ** 2
        return np.where(np.abs(x) < SERIES, 1 - square / 6 * (1 - square / 20 * (1 - square / 42)), np.sinc(x))


STEPPED = _Stepped(np)


class Passed(Struct, frozen=True):
    """Impulse I and path P of the force at the impacts of motions, as sums and differences, over its amplitude.

    Attributes
    ----------
    impulses : array_like
        (I_b + I_t)/pi.
    difference : array_like
        (I_t - I_b)/pi.
    path : array_like
        (P_b - P_t)/pi^2.
    per_u : array_like or None
        `impulses` divided by u, for planes with mirror images, where it vanishes with u.
    """

    impulses: Any
    difference: Any
    path: Any
    per_u: Any

    @property
    def at_bottom(self) -> Any:
        """Impulse of the force at the bottom impact, I_b/pi."""
        return (self.impulses - self.difference) / 2

    @property
    def at_top(self) -> Any:
        """Impulse of the force at the top impact, I_t/pi."""
        return (self.impulses + self.difference) / 2


class Bounces(ContourPlane, frozen=True, eq=False):
    """The plane of q and phase for a sweep over a restitution: height above the level, and the motions on it."""

    @property
    def order(self) -> int:
        """Highest order of the phase in the level."""
        highest = super().order
        return 2 * highest if self.level.varied is Parameter.RESTITUTION else highest

    @property
    def sharp(self) -> bool:
        """Whether the level may have features of any size next to q = 1/2: not where u is divided out."""
        return not self.mirrors

    @property
    def unresolved(self) -> str:
        """Message for the user of a sweep whose level cannot be followed."""
        return (
            f"the motions along a sweep of {self.level.varied} are not resolved next to where two families meet "
            "(change the length or inclination_deg by a per mille)"
        )

    def within(self, u: Arithmetic, phi: Arithmetic) -> tuple[Any, float]:
        """The lesser restitution at places on the level, positive for motions, and the value below which none are near.

        For a nearly horizontal capsule the level of both restitutions has a piece with r near -1, which nearly crosses
        the piece with the motions: it must be left out before the curve is followed.
        """
        return np.min(np.broadcast_arrays(*by_wall(self.orbits(u, phi).restitution)), axis=0), FARTHEST_BELOW

    @property
    def _gravities(self) -> tuple[Any, Any]:
        """Gravity plus friction in the flight up, g_u, and in the flight down, g_d."""
        gbar = self.level.value
        if self.level.friction is None:
            return gbar, gbar
        return gbar + self.level.friction.constant, gbar - self.level.friction.constant

    def value(self, u: Arithmetic, phi: Arithmetic, ops: ContinuousFunctions = ARRAYS) -> Any:
        """The height above the level at places of one shape.

        The height is the condition of the sweep for the velocities at a place, times Tu Td for one restitution, times
        (Tu Td)^2 for both: a polynomial in I, P and the times, without a pole at Tu = 0 or Td = 0. Where motions have
        mirror images it is divided by u, whose zeros are the symmetric motions. For a horizontal capsule with membranes
        that are alike and no friction it is divided by (w_t - a_t) Tu Td too, which is zero for r = -1.
        """
        passed = self._passed(u, phi, ops, self.mirrors)
        if self.level.varied is not Parameter.RESTITUTION:
            return self._above_other(u, passed)
        return self._above_difference_over_u(u, passed) if self.mirrors else self._above_difference(u, passed)

    def _times(self, u: Arithmetic) -> tuple[Any, Any]:
        """The flight times Tu and Td at q = 1/2 + u."""
        return self.n + 2 * self.n * u, self.n - 2 * self.n * u

    def _above_other(self, u: Arithmetic, passed: Passed) -> Any:
        """The height in a sweep over one restitution: (a + r w) Tu Td at the other membrane, whose r is constant."""
        (up, down), (bottom, top), (of_up, of_down) = self._times(u), by_wall(self.r), self._gravities
        reach, both = self.level.d + passed.path, up * down
        if self.level.varied is Parameter.RESTITUTION_BOTTOM:
            pulled = top * of_up * up / 2 - of_down * down / 2 + (1 + top) * passed.at_top
            return reach * (up - top * down) + both * pulled
        pulled = bottom * of_down * down / 2 - of_up * up / 2 + (1 + bottom) * passed.at_bottom
        return reach * (bottom * up - down) + both * pulled

    # In a sweep over both restitutions, with S = a_b + a_t and J = (I_t - I_b)/pi: a flight adds its gravity and its
    # impulse to the velocity, w_t = a_b + g_u Tu + J and w_b = a_t + g_d Td - J. Put into a_b w_t - a_t w_b, that is
    #     S (a_b - a_t + J) + g_u a_b Tu - g_d a_t Td.
    # For a nearly horizontal capsule S and g are as small as u and gbar. As a difference of products the height would
    # lose these digits; here every sum of large terms that cancel is taken from formulae in which they have.

    def _above_difference(self, u: Arithmetic, passed: Passed) -> Any:
        """The height in a sweep over both restitutions: (a_b w_t - a_t w_b + D w_b w_t) (Tu Td)^2, D = r_b - r_t."""
        (up, down), (bottom, top), (of_up, of_down) = self._times(u), by_wall(self.r), self._gravities
        gbar, period, rubbed = self.level.value, 2 * self.n, (of_up - of_down) / 2
        reach, both = self.level.d + passed.path, up * down
        # S Tu Td: of a_b Tu Td and a_t Td Tu the distance and the gravity cancel but for u.
        total = 2 * period * u * reach + both * (passed.impulses - period * (gbar / 2 + rubbed * u))
        if self.level.horizontal and self.level.friction is None and bottom is top:
            return total
        after_bottom, after_top = self._departures(u, passed)
        # a_b Tu + a_t Td, of which the large parts cancel where u and gbar are small.
        added = passed.impulses * self.n - period * u * (passed.difference + period * rubbed)
        added = added - gbar * (up * up + down * down) / 2
        parted = after_bottom * down - after_top * up + passed.difference * both  # (a_b - a_t + J) Tu Td
        # With friction f gravity is gbar + f up and gbar - f down.
        above = total * parted + both * both * (gbar * (after_bottom - after_top) + rubbed * added)
        if bottom is top:
            return above
        before_top, before_bottom = after_bottom + of_up * up * up, after_top + of_down * down * down
        before_top, before_bottom = before_top + passed.difference * up, before_bottom - passed.difference * down
        return above + (bottom - top) * both * before_bottom * before_top

    def _above_difference_over_u(self, u: Arithmetic, passed: Passed) -> Any:
        """`_above_difference` over u, for motions that have mirror images.

        Their gbar and D are 0, and S and a_b Tu + a_t Td vanish with u. As `per_u` has the quotient of the impulses,
        nothing is divided, and u = 0 is a place like any other.
        """
        (up, down), (of_up, of_down) = self._times(u), self._gravities
        period, rubbed = 2 * self.n, (of_up - of_down) / 2
        reach, both = self.level.d + passed.path, up * down
        total = 2 * period * reach + both * (passed.per_u - period * rubbed)  # S Tu Td / u
        if self.level.friction is None:
            return total
        after_bottom, after_top = self._departures(u, passed)
        parted = after_bottom * down - after_top * up + passed.difference * both
        added = period * (passed.per_u / 2 - passed.difference - period * rubbed)  # (a_b Tu + a_t Td)/u
        return total * parted + both * both * rubbed * added

    def _departures(self, u: Arithmetic, passed: Passed) -> tuple[Any, Any]:
        """The velocity after each impact times the flight that follows, a_b Tu and a_t Td."""
        (up, down), (of_up, of_down), reach = self._times(u), self._gravities, self.level.d + passed.path
        return (
            passed.at_bottom * up - reach - of_up * up * up / 2,
            passed.at_top * down + reach - of_down * down * down / 2,
        )

    def _passed(self, u: Arithmetic, phi: Arithmetic, ops: ContinuousFunctions, divided: bool = False) -> Passed:
        """Impulse and path of the force at both impacts; with `divided` also the sum of impulses over u."""
        # The phase that passes is a = pi n (1 + 2u). Sums and differences are formed by half angles of 2 pi n u, with
        # all digits where u is small.
        impulses = difference = path = per_u = 0
        for harmonic in (SINE, *self.harmonics):
            order, turns = harmonic.order, harmonic.order * self.n
            half = ops.pi * turns * u
            sin_half, cos_half = ops.sin(half), ops.cos(half)
            small, large, sin_a = 2 * sin_half * sin_half, 2 * cos_half * cos_half, 2 * sin_half * cos_half
            plus, minus, sin_a = (small, large, -sin_a) if turns % 2 else (large, small, sin_a)  # 1 + cos a, 1 - cos a
            sine, cosine = ops.sin(order * phi), ops.cos(order * phi)
            sines, cosines = sine * plus + cosine * sin_a, cosine * plus - sine * sin_a  # of both ends, added
            onward, less = cosine * sin_a - sine * minus, cosine * minus + sine * sin_a  # sine gained, cosine lost
            impulses = impulses + (harmonic.cosine * sines - harmonic.sine * cosines) / order
            difference = difference + (harmonic.cosine * onward + harmonic.sine * less) / order
            path = path + (harmonic.cosine * less - harmonic.sine * onward) / (order * order)
            if divided:
                wave = 2 * ops.pi * turns
                plus, sin_a = wave * ops.sinc(turns * u) * sin_half, -wave * ops.sinc(2 * turns * u)
                sines, cosines = sine * plus + cosine * sin_a, cosine * plus - sine * sin_a
                per_u = per_u + (harmonic.cosine * sines - harmonic.sine * cosines) / order
        return Passed(
            impulses / ops.pi, difference / ops.pi, path / (ops.pi * ops.pi), per_u / ops.pi if divided else None
        )

    def on_grid(self, u: Any, phi: Any) -> Any:
        """The height above the level at all pairs of a u and a phase, shape (len(u), len(phi))."""
        return np.asarray(self.value(u[:, None], phi[None, :]))

    def gradient(self, u: Arithmetic, phi: Arithmetic) -> tuple[Any, Any, Any]:
        """The height and its derivatives by u and by the phase."""
        by_u, by_phi = self.value(u + 1j * IMAGINARY_STEP, phi, STEPPED), self.value(u, phi + 1j * IMAGINARY_STEP)
        return by_u.real, by_u.imag / IMAGINARY_STEP, by_phi.imag / IMAGINARY_STEP

    def slopes(self, u: Arithmetic, phi: Arithmetic, step: Arithmetic) -> tuple[Any, Any]:
        """Derivatives of the height by u and by the phase, exact whatever the step."""
        return self.gradient(u, phi)[1:]

    def orbits(self, u: Arithmetic, phi: Arithmetic, ops: ContinuousFunctions = ARRAYS) -> Orbits:
        """Evaluate the motions at places on the level, with their restitutions."""
        sin_phi, cos_phi = ops.sin(phi), ops.cos(phi)
        half = ops.pi * self.n * u
        sin_half, cos_half = ops.sin(half), ops.cos(half)
        way = (-1) ** self.n  # half turns
        cos_a, sin_a = way * (1 - 2 * sin_half * sin_half), way * 2 * sin_half * cos_half
        passed = self._passed(u, phi, ops)
        up, down = self._times(u)
        reach, (of_up, of_down) = self.level.d + passed.path, self._gravities
        after_bottom, before_top = (
            passed.at_bottom - reach / up - of_up * up / 2,
            passed.at_top - reach / up + of_up * up / 2,
        )
        after_top = passed.at_top + reach / down - of_down * down / 2
        before_bottom = passed.at_bottom + reach / down + of_down * down / 2
        zero = 0 * (u + phi)
        return Orbits(
            u=u,
            phi=phi,
            sin_phi=sin_phi,
            cos_phi=cos_phi,
            sin_top=sin_phi * cos_a + cos_phi * sin_a,
            cos_top=cos_phi * cos_a - sin_phi * sin_a,
            time_up=up,
            time_down=down,
            velocity_bottom=before_bottom,
            velocity_top=before_top,
            gbar=zero + self.level.value,
            d=zero + self.level.d,
            harmonics=self.harmonics,
            friction=None if self.level.friction is None else zero + self.level.friction.constant,
            restitution=self._restitution(zero, (after_bottom, before_bottom), (after_top, before_top)),
        )

    def _restitution(self, zero: Arithmetic, at_bottom: tuple[Any, Any], at_top: tuple[Any, Any]) -> Any:
        """The restitutions from the velocities (after, before) at either impact; a constant one is that of the device.

        Parameters
        ----------
        zero : array_like
            Zero in the shape of the motions.
        at_bottom, at_top : tuple of array_like
            Velocity just after and just before the impact [y_c].
        """
        bottom, top = by_wall(self.r)
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.level.varied is Parameter.RESTITUTION_BOTTOM:
                return Restitutions(-at_bottom[0] / at_bottom[1], zero + top)
            if self.level.varied is Parameter.RESTITUTION_TOP:
                return Restitutions(zero + bottom, -at_top[0] / at_top[1])
            # On the level both impacts give the same mean; weighted by the squares of their velocities it is defined
            # where one of these vanishes.
            part = (bottom - top) / 2
            lost = (at_bottom[0] + part * at_bottom[1]) * at_bottom[1] + (at_top[0] - part * at_top[1]) * at_top[1]
            mean = -lost / (at_bottom[1] * at_bottom[1] + at_top[1] * at_top[1])
        return mean if bottom is top else Restitutions(mean + part, mean - part)
