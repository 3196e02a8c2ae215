"""All 1:1 motions of period T = 2n, in closed form, as one smooth surface over (q, phase).

Equations (3.9)-(3.11) are linear in the velocity, the sine and cosine of the phase, gbar and d. Solved for the
velocity, gbar and d instead of for the phase, they have exactly one solution for *every* pair (q, phase): their
determinant is K(q) = -T^2 (1+r) [(q - 1/2)^2 + ((1-r)/(2(1+r)))^2], which vanishes for no r < 1. So no guess is
needed, no motion is lost, and neither q = 1/(1+r), where (3.10) divides by zero, nor q = 1/2 is special. A sweep is
a level curve on that surface.

Where the membranes are not alike, r_b at the bottom and r_t at the top, momentum over the period and the two flights
give the same with a = (1-r)/(2(1+r)) of either: K(q) = -T^2 (1+r_b) [(q - 1/2)^2 + a_b a_t], and a_t - a_b =
(r_b - r_t)/[(1+r_b)(1+r_t)] is added to u in gbar.

A harmonic of order j in the force has the surface of a sine with j omega and j n periods: the same gbar, 1/j of its
velocity and 1/j^2 of its d. Surfaces are added, as the equations are linear in the force and K(q)/T^2 is the same for
all orders; above each q the sum is a trigonometric polynomial in the phase.

Dry friction, while Z' keeps its sign in each flight, acts as more or less gravity: it is gbar + f up and gbar - f down.
The equations are linear in f, too: to gbar, velocity and d above each q it adds f times functions of q, see `Friction`.

Throughout, u = q - 1/2 stands for q, because the nearly symmetric motions of a nearly horizontal capsule live at u
~ gbar, where q itself has no digits left. The formulae serve every kind of number, see `vireport.physics.numbers`.

Read `coefficients` (the linear system), then `Orbits` (what a motion is), then `orbits_above` (the sum over the
harmonics, and friction).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from vireport.physics import flight
from vireport.physics.flight import Flight
from vireport.physics.forcing import Harmonic, Wave, wave
from vireport.physics.groups import Restitution, Restitutions, by_wall, map_restitution
from vireport.physics.numbers import ARRAYS, Arithmetic, Functions


class Coefficients(Struct, frozen=True, eq=False):
    """The surface above one value of q: each quantity is `*_sine` sin(phi) + `*_cosine` cos(phi).

    Attributes
    ----------
    sin_a, cos_a : array_like
        Sine and cosine of the phase a = pi Tu that passes from the bottom to the top impact [-].
    time_up, time_down : array_like
        Tu = T q and Td = T (1-q) [t_c].
    determinant : array_like
        K(q) < 0 of the linear system [t_c^2].
    gbar_sine, gbar_cosine, velocity_sine, velocity_cosine, d_sine, d_cosine : array_like
        Coefficients of gbar, of the velocity at the bottom impact, and of d.
    """

    sin_a: Any
    cos_a: Any
    time_up: Any
    time_down: Any
    determinant: Any
    gbar_sine: Any
    gbar_cosine: Any
    velocity_sine: Any
    velocity_cosine: Any
    d_sine: Any
    d_cosine: Any


def coefficients(u: Arithmetic, r: Restitution, n: int, ops: Functions = ARRAYS) -> Coefficients:
    """Solve the linear system (3.9)-(3.11) for the velocity, gbar and d at q = 1/2 + u.

    Parameters
    ----------
    u : array_like
        q - 1/2, strictly between -1/2 and 1/2 [-].
    r : float or Restitutions
        Restitution coefficient, 0 <= r < 1 [-]: of both membranes, or of each.
    n : int
        Forcing periods per motion, T = 2n, Eq. (3.14).
    ops
        Functions of the kind of number: `sin`, `cos` and `pi`.

    Notes
    -----
    As printed, (3.10) contains g/2; gbar/2 is meant. The printed form divides by r Tu - Td, this one by K(q).
    For odd n both coefficients of gbar vanish with u; they are written so that this happens without cancellation.
    """
    pi = ops.pi
    period = 2 * n
    # The phase that passes on the way up is a = pi (n + 2 n u): sin(a) and 1 - cos(a) follow from the half of 2 pi n u,
    # with all digits where u is small.
    half = pi * n * u
    sin_half, cos_half = ops.sin(half), ops.cos(half)
    twice = 2 * sin_half
    versine, sin_theta = twice * sin_half, twice * cos_half
    bottom, top = by_wall(r)
    jump, loss = 1 + bottom, 1 - bottom
    jump_top, loss_top = (jump, loss) if bottom is top else (1 + top, 1 - top)
    twice_jump, shift = 2 * jump, period * u
    p = jump * u - loss / 2
    p_top = p if bottom is top else jump_top * u - loss_top / 2
    # A sum of squares, with no difference in it: K(q) keeps its digits for every r < 1.
    determinant = -period * period * (jump * u * u + loss * loss_top / (4 * jump_top))
    if n % 2:
        sin_a, cos_a_less_one = -sin_theta, versine - 2
        gbar_sine = versine * p - twice_jump * u
    else:
        sin_a, cos_a_less_one = sin_theta, -versine
        gbar_sine = cos_a_less_one * p - loss
    if isinstance(r, Restitutions):
        gbar_sine = gbar_sine - (bottom - top) / jump_top
    scale = period / (pi * determinant)
    gbar_sine, gbar_cosine = scale * gbar_sine, scale * sin_a * p
    scale = scale * period
    velocity_sine = scale * (u * cos_a_less_one + p_top / jump_top)
    velocity_cosine = scale * u * sin_a
    reach = period * (1 - 4 * u * u) / 8  # Tu Td/(2T)
    return Coefficients(
        sin_a=sin_a,
        cos_a=1 + cos_a_less_one,
        time_up=n + shift,
        time_down=n - shift,
        determinant=determinant,
        gbar_sine=gbar_sine,
        gbar_cosine=gbar_cosine,
        velocity_sine=velocity_sine,
        velocity_cosine=velocity_cosine,
        d_sine=reach * (twice_jump * velocity_sine - period * gbar_sine) - sin_a / (pi * pi),
        d_cosine=reach * (twice_jump * velocity_cosine - period * gbar_cosine) + cos_a_less_one / (pi * pi),
    )


class Friction(Struct, frozen=True, eq=False):
    """Dry friction f over a sweep as a function of the groups: `constant` + `by_gbar` gbar + `by_d` d.

    It is constant over a sweep of length or frequency. Over a sweep of the force it is proportional to gbar, or to d
    where the capsule is horizontal.

    Attributes
    ----------
    constant, by_gbar, by_d : array_like
        Over the amplitude of the force [-]. The whole number 0 marks a term that is absent: it costs nothing and adds
        no rounding.
    """

    constant: Any
    by_gbar: Any = 0
    by_d: Any = 0

    def map_numbers(self, function: Callable[[Any], Any]) -> Friction:
        """Apply a function to the coefficients; an absent one, the whole number 0, stays absent."""
        numbers = (self.constant, self.by_gbar, self.by_d)
        return Friction(*(number if type(number) is int else function(number) for number in numbers))

    def at(self, gbar: Arithmetic, d: Arithmetic) -> Any:
        """Friction at values of both groups."""
        return self.constant + self.by_gbar * gbar + self.by_d * d


class Rubbing(Struct, frozen=True, eq=False):
    """Derivatives by friction f at one value of q: of gbar, of the velocity at the bottom impact, and of d."""

    gbar: Any
    velocity: Any
    d: Any


def rubbing(k: Coefficients, u: Arithmetic, r: Restitution, n: int) -> Rubbing:
    """Solve the linear system (3.9)-(3.11) for unit friction in the place of the force.

    Parameters
    ----------
    k : Coefficients
        Of a sine at the same u.
    u : array_like
        q - 1/2 [-].
    r : array_like or Restitutions
    n : int
        Forcing periods per motion.

    Notes
    -----
    With G for gbar/f, gravity is G + 1 during Tu and G - 1 during Td. Both flights and the impacts between them give
    (1 + r_t) K G = T^2 [(1 + r_b r_t) u + (r_b - r_t) (1/4 - u^2)], for the velocity V at the bottom
    (1 + r_t) K V = Tu Td (Tu - r_t Td), and d = Tu Td/(2T) [2 (1 + r_b) V - T (G + 2 u)].
    """
    bottom, top = by_wall(r)
    period, scale = 2 * n, (1 + top) * k.determinant
    both = (1 + bottom * top) * u
    if bottom is not top:
        both = both + (bottom - top) * (1 - 4 * u * u) / 4
    gbar = period * period * both / scale
    flights = k.time_up * k.time_down
    velocity = flights * (k.time_up - top * k.time_down) / scale
    return Rubbing(gbar, velocity, flights / (2 * period) * (2 * (1 + bottom) * velocity - period * (gbar + 2 * u)))


def of_order(k: Coefficients, order: int) -> Coefficients:
    """Coefficients of sin(order phi) and cos(order phi) for a harmonic, from those of a sine with `order` n periods."""
    # In the time unit t_c/order the harmonic is a sine: velocities scale by 1/order, lengths by its square, and
    # accelerations (gbar) not at all.
    square = order * order
    return replace(
        k,
        velocity_sine=k.velocity_sine / order,
        velocity_cosine=k.velocity_cosine / order,
        d_sine=k.d_sine / square,
        d_cosine=k.d_cosine / square,
    )


def turned(sine: Arithmetic, cosine: Arithmetic, harmonic: Harmonic) -> tuple[Any, Any]:
    """Coefficients for the force A cos(order x) + B sin(order x) of a harmonic, from those for cos(order x)."""
    return harmonic.cosine * sine + harmonic.sine * cosine, harmonic.cosine * cosine - harmonic.sine * sine


class Orbits(Struct, frozen=True, eq=False):
    """Periodic motions with one bottom and one top impact, as numbers or arrays of one shape (dimensionless).

    Attributes
    ----------
    u : array_like
        q - 1/2, with q the share of the period that the ball travels from bottom to top.
    phi : array_like
        Forcing phase at the bottom impact [rad].
    sin_phi, cos_phi, sin_top, cos_top : array_like
        Sines and cosines of the phase at the bottom and at the top impact.
    time_up, time_down : array_like
        Flight times from bottom to top and back [t_c].
    velocity_bottom, velocity_top : array_like
        Relative velocities just before the impacts [y_c]; positive at the bottom and negative at the top in a motion.
    gbar, d : array_like
        Gravity and length for which this is a motion.
    harmonics : tuple of Harmonic
        Harmonics of the force, the same for all motions; empty for a sine.
    friction : array_like or None
        f of each motion; None for a ball without friction.
    restitution : array_like or Restitutions, or None
        Restitution of each motion, in a sweep over a restitution; None where all have the device's.
    """

    u: Any
    phi: Any
    sin_phi: Any
    cos_phi: Any
    sin_top: Any
    cos_top: Any
    time_up: Any
    time_down: Any
    velocity_bottom: Any
    velocity_top: Any
    gbar: Any
    d: Any
    harmonics: tuple[Harmonic, ...] = ()
    friction: Any = None
    restitution: Any = None

    def select(self, index: Any) -> Orbits:
        """The motions picked by an index or mask."""
        friction = None if self.friction is None else self.friction[index]
        restitution = None if self.restitution is None else map_restitution(self.restitution, lambda r: r[index])
        numbers = {name: getattr(self, name)[index] for name in ORBIT_NUMBERS}
        return replace(self, **numbers, friction=friction, restitution=restitution)

    @property
    def waves(self) -> tuple[Wave, Wave]:
        """The force at the bottom and at the top impact."""
        return wave(self.sin_phi, self.cos_phi, self.harmonics), wave(self.sin_top, self.cos_top, self.harmonics)

    @property
    def gravities(self) -> tuple[Any, Any]:
        """Gravity plus friction in the flight from the bottom up, and in the flight back down; see `Groups.gravity`."""
        if self.friction is None:
            return self.gbar, self.gbar
        return self.gbar + self.friction, self.gbar - self.friction

    def flights(self, r: Restitution) -> tuple[Flight, Flight]:
        """The flights from the bottom to the top and back, for the restitution r of `coefficients`."""
        at_bottom, at_top = by_wall(r)
        bottom, top = flight.reflect(self.velocity_bottom, at_bottom), flight.reflect(self.velocity_top, at_top)
        begun, back = self.waves
        up, down = self.gravities
        return (
            Flight(-1, bottom, begun.impulse, begun.path, self.time_up, up, self.d),
            Flight(1, top, back.impulse, back.path, self.time_down, down, self.d),
        )


ORBIT_NUMBERS = tuple(name for name in Orbits.__struct_fields__ if name not in ("harmonics", "friction", "restitution"))
"""Names of the fields of `Orbits` that are numbers or arrays."""


class Dynamics(Struct, frozen=True, eq=False):
    """Restitution, period, harmonics and friction: all that 1:1 motions depend on besides d and gbar.

    Attributes
    ----------
    r : array_like or Restitutions
        Restitution coefficient, 0 <= r < 1 [-].
    n : int
        Forcing periods per motion.
    harmonics : tuple of Harmonic
        Harmonics of the force; empty for a sine.
    friction : Friction or None
        None for a ball without friction.
    """

    r: Any
    n: int
    harmonics: tuple[Harmonic, ...] = ()
    friction: Friction | None = None


def orbits(u: Arithmetic, phi: Arithmetic, r: Restitution, n: int, ops: Functions = ARRAYS) -> Orbits:
    """Evaluate the one 1:1 motion with q = 1/2 + u and this phase, for a force that is a sine and without friction.

    Parameters are those of `orbits_of`, with the restitution r and n forcing periods for `dynamics`.
    """
    return orbits_of(Dynamics(r, n), u, phi, ops)


def orbits_of(dynamics: Dynamics, u: Arithmetic, phi: Arithmetic, ops: Functions = ARRAYS) -> Orbits:
    """Evaluate the one 1:1 motion with q = 1/2 + u and this phase, and the gbar and d that it belongs to.

    Parameters
    ----------
    dynamics : Dynamics
    u : array_like
        q - 1/2, strictly between -1/2 and 1/2 [-].
    phi : array_like
        Forcing phase at the bottom impact [rad].
    ops
        Functions of the kind of number of all these.
    """
    return orbits_above(coefficients(u, dynamics.r, dynamics.n, ops), dynamics, u, phi, ops)


def orbits_above(
    c: Coefficients, dynamics: Dynamics, u: Arithmetic, phi: Arithmetic, ops: Functions = ARRAYS
) -> Orbits:
    """Evaluate `orbits_of` where the coefficients `c` of the sine at these u have been computed before.

    Source: the velocity at the top is (3.8).
    """
    r, n, friction = dynamics.r, dynamics.n, dynamics.friction
    sin_phi, cos_phi = ops.sin(phi), ops.cos(phi)
    gbar = c.gbar_sine * sin_phi + c.gbar_cosine * cos_phi
    velocity = c.velocity_sine * sin_phi + c.velocity_cosine * cos_phi
    d = c.d_sine * sin_phi + c.d_cosine * cos_phi
    for harmonic in dynamics.harmonics:
        k = of_order(coefficients(u, r, harmonic.order * n, ops), harmonic.order)
        sine, cosine = ops.sin(harmonic.order * phi), ops.cos(harmonic.order * phi)
        gbar = gbar + _at_phase(turned(k.gbar_sine, k.gbar_cosine, harmonic), sine, cosine)
        velocity = velocity + _at_phase(turned(k.velocity_sine, k.velocity_cosine, harmonic), sine, cosine)
        d = d + _at_phase(turned(k.d_sine, k.d_cosine, harmonic), sine, cosine)
    rubbed, gained = None, gbar
    if friction is not None:
        unit = rubbing(c, u, r, n)
        # f = c + a gbar + b d depends on the very gbar and d to which it adds f times `unit`: linear in f, so solved by
        # one division, not iterated.
        rubbed = friction.at(gbar, d) / (1 - friction.by_gbar * unit.gbar - friction.by_d * unit.d)
        gbar, velocity, d = gbar + rubbed * unit.gbar, velocity + rubbed * unit.velocity, d + rubbed * unit.d
        gained = gbar + 2 * u * rubbed
    # Over the period gravity adds T gbar to the velocity, and each impact takes off (1 + r) times its velocity: that is
    # (3.8). Friction adds f during Tu and takes it off during Td.
    bottom, top = by_wall(r)
    taken = velocity if bottom is top else velocity * ((1 + bottom) / (1 + top))
    return Orbits(
        u=u,
        phi=phi,
        sin_phi=sin_phi,
        cos_phi=cos_phi,
        sin_top=sin_phi * c.cos_a + cos_phi * c.sin_a,
        cos_top=cos_phi * c.cos_a - sin_phi * c.sin_a,
        time_up=c.time_up,
        time_down=c.time_down,
        velocity_bottom=velocity,
        velocity_top=2 * n * gained / (1 + top) - taken,
        gbar=gbar,
        d=d,
        harmonics=dynamics.harmonics,
        friction=rubbed,
    )


def _at_phase(pair: tuple[Any, Any], sine: Arithmetic, cosine: Arithmetic) -> Any:
    """Value of a sin + b cos for a pair of coefficients (a, b)."""
    return pair[0] * sine + pair[1] * cosine
