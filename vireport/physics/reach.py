"""How high a ball rises above a vibrating table: the length from which on the top of a capsule is out of its reach."""

from __future__ import annotations

from math import inf, pi, sqrt
from typing import Any

from vireport.physics.device import Device
from vireport.physics.forcing import peaks
from vireport.physics.groups import Groups, by_wall
from vireport.scenario.parameters import Parameter


def reach(groups: Groups[Any]) -> float:
    """Length of a capsule from which on its ball strikes the top a finite number of times at most, from any start.

    No periodic motion of a longer capsule has an impact on the top: in the long run the ball bounces on a table. It is
    a bound: the ball does not reach the top of some shorter capsules either.

    Parameters
    ----------
    groups : Groups
        Of one device; `d` is not used.

    Returns
    -------
    float
        In x_c; inf where gbar is not positive or a restitution is 1, and where there is friction or a restitution that
        falls with speed, for which no bound is known here.

    Notes
    -----
    Seen from outside, the ball rises at a speed v with v' = -gbar in flight, and the capsule at a speed u with
    -U <= u <= U = I/pi, I the largest impulse of the force. Its travel from end to end is 2P, P = p/pi^2 with the
    largest path p. (For a sine I = p = 1.) An impact changes v to -r v + (1 + r) u. Let s be the size of v just after
    one impact on the bottom, w just before the next one and s' just after it:

        s' <= r w + A,    A = (1 + r) U,    r that of the bottom.

    If the top is not struck between them, both impacts are at heights that differ by 2P at most, so that
    w^2 <= s^2 + 4 gbar P.

    If it is struck, the ball has climbed h = d - 2P at least: it first strikes the top at a speed a with
    a^2 <= s^2 - 2 gbar h, and leaves it at r_t a + (1 + r_t) U at most, r_t that of the top. Each further impact on
    the top follows a flight from the top, which a ball leaves at v <= u <= U, and in which v falls; so it strikes
    with v <= U and with v >= u >= -U, and leaves at (1 + 2 r_t) U at most. A ball that rests on the top leaves it
    at U at most. (None stays there: in flight, by impacts on the top and by its pressure v only falls.) In any case
    it falls from the top with r_t a + K at most, K = (1 + 2 r_t) U, by d + 2P at most:

        w^2 <= (r_t a + K)^2 + 2 gbar (h + 4P) <= s^2 + D,    D = K^2/(1 - r_t^2) + 8 gbar P,

    as (r_t a + K)^2 - a^2 is largest, K^2/(1 - r_t^2), at a = r_t K/(1 - r_t^2). This holds without impacts on the top
    as well: always

        s' <= r sqrt(s^2 + D) + A.

    The right-hand side grows with s, by less than r for 1. So in the long run s is at most its fixed point,

        S = [A + r sqrt(A^2 + (1 - r^2) D)]/(1 - r^2),

    also of a ball that lay on the bottom, which it leaves at U <= S at most. To strike the top a ball needs
    s^2 >= 2 gbar h: where S^2 < 2 gbar (d - 2P), it does so no more.
    """
    if groups.friction is not None or groups.law is not None:
        return inf
    gbar, (bottom, top) = float(groups.gbar), map(float, by_wall(groups.restitution))
    if gbar <= 0 or max(bottom, top) >= 1:
        return inf
    largest = peaks(groups.harmonics)
    speed, travel = largest.impulse / pi, largest.path / pi**2
    kicked, from_top = (1 + bottom) * speed, (1 + 2 * top) * speed
    gained = from_top**2 / (1 - top**2) + 8 * gbar * travel
    lost = 1 - bottom**2
    fastest = (kicked + bottom * sqrt(kicked**2 + lost * gained)) / lost
    return fastest**2 / (2 * gbar) + 2 * travel


def is_table(device: Device, parameter: Parameter, ends: tuple[float, ...] = ()) -> bool:
    """Whether a device is a ball on a table: at the design point and all along a sweep its top is out of `reach`.

    A harvester, which states the mass of its ball, is no table: if it cannot use one of its membranes, it has failed.

    Parameters
    ----------
    device : Device
    parameter : Parameter
        The swept parameter.
    ends : tuple of float
        Ends of the sweep, in the parameter's unit; empty without a sweep.

    Notes
    -----
    In metres `reach` grows with the force and the restitutions, and falls with frequency and inclination. So a top that
    is out of reach at both ends of a sweep is so all along it.
    """
    if device.ball_mass_kg is not None:
        return False
    design = device.value_of(parameter)
    values = ends if design is None else (*ends, design)
    return all(groups.d > reach(groups) for groups in (device.groups(parameter, value) for value in values))
