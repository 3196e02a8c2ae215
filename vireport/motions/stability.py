"""The linearised return map of a motion, and Table 1's types of motion.

The return map of a 1:1 motion is DP = DP2 DP1, the Jacobians of both flights. det DP = r^4 exactly, or (r_b r_t)^2, so
the trace decides the type; near Delta = 0 rounded eigenvalues would have lost half their digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.orbits import Orbits
from vireport.physics.groups import Restitution, Restitutions, by_wall
from vireport.physics.numbers import Arithmetic

Floats = NDArray[np.float64]


class Stability(StrEnum):
    """Type of a motion, as in Table 1.

    There is no unstable focus: ``|lambda| = r^2 < 1`` where the eigenvalues are complex. Arrays hold `code` instead of
    members.
    """

    STABLE_NODE = "stable node"
    STABLE_FOCUS = "stable focus"
    UNSTABLE_NODE = "unstable node"

    @property
    def code(self) -> int:
        """Index that stands for the type in an array."""
        return STABILITIES.index(self)

    @property
    def attracts(self) -> bool:
        """Whether motions nearby approach a motion of this type."""
        return self is not Stability.UNSTABLE_NODE

    @property
    def criteria(self) -> str:
        """Criterion of the type, as in Table 1."""
        return (
            f"Delta {'<' if self is Stability.STABLE_FOCUS else '>'} 0 and |lambda_i| {'<' if self.attracts else '>'} 1"
        )


STABILITIES = tuple(Stability)
"""The types by their codes."""

NODE, FOCUS, UNSTABLE = (kind.code for kind in STABILITIES)


Jacobian = tuple[Any, Any, Any, Any]
"""Entries of a 2 by 2 matrix, row by row."""


def flight_jacobian(
    duration: Any, velocities: tuple[Any, Any], accelerations: tuple[Any, Any], r: Restitution, slope: Any = None
) -> Jacobian:
    """Jacobian of a flight map (time, velocity) -> (next time, next velocity), row by row.

    Parameters
    ----------
    duration : array_like
        Flight time [t_c].
    velocities : tuple of array_like
        Just before the impact that begins the flight, and just before the one that ends it [y_c]; the latter not zero.
    accelerations : tuple of array_like
        gbar + cos(phase) at the two impacts [-].
    r : float
        Restitution coefficient of the impact that begins the flight [-].
    slope : float, optional
        -dZ'+/dZ'- of that impact, where it is not r.

    Source: Eqs. (A.1) and (A.2), whose denominators are minus the velocity that ends the flight, by (3.8).
    """
    (velocity_before, velocity_end), (acceleration_start, acceleration_end) = velocities, accelerations
    time_time = (acceleration_start * duration - r * velocity_before) / velocity_end
    slope = r if slope is None else slope
    time_velocity = slope * duration / velocity_end
    return (
        time_time,
        time_velocity,
        time_time * acceleration_end - acceleration_start,
        time_velocity * acceleration_end - slope,
    )


def flight_jacobians(orbit: Orbits, r: Restitution) -> tuple[Jacobian, Jacobian]:
    """Jacobians DP1 of the flight from the bottom to the top impact of a 1:1 motion, and DP2 of the flight back."""
    at_bottom, at_top = orbit.waves
    r_bottom, r_top = by_wall(r)
    slope_bottom, slope_top = r.slopes if isinstance(r, Restitutions) else (r, r)
    if orbit.friction is None:
        bottom, top = orbit.gbar + at_bottom.force, orbit.gbar + at_top.force
        back, down = top, bottom
    else:
        upward, downward = orbit.gravities
        bottom, top = upward + at_bottom.force, upward + at_top.force
        back, down = downward + at_top.force, downward + at_bottom.force
    return (
        flight_jacobian(
            orbit.time_up, (orbit.velocity_bottom, orbit.velocity_top), (bottom, top), r_bottom, slope_bottom
        ),
        flight_jacobian(orbit.time_down, (orbit.velocity_top, orbit.velocity_bottom), (back, down), r_top, slope_top),
    )


def lap_decay(r: Restitution) -> Any:
    """The root of det DP of a 1:1 motion: r^2, or r_b r_t where the membranes are not alike.

    For restitutions that fall with speed it is (r_b s_b r_t s_t)^(1/2), s the `Restitutions.slopes`.

    Source: Eq. (A.3).
    """
    bottom, top = by_wall(r)
    if isinstance(r, Restitutions) and type(r.slope) is not int:
        return r.slope * (bottom * top)
    return bottom * top


def determinant_of(r: Any) -> Any:
    """Det DP of a 1:1 motion: r^4, Eq. (A.3), or the square of `lap_decay`."""
    return lap_decay(r) ** 2 if isinstance(r, Restitutions) else r**4


def return_trace(orbit: Orbits, r: Restitution) -> Any:
    """Trace of DP = DP2 DP1 of Eq. (4.2), whose determinant is the square of `lap_decay`, (A.3)."""
    return product_trace(flight_jacobians(orbit, r))


def lap_jacobian(flights: Sequence[Jacobian]) -> Jacobian:
    """Product of the Jacobians of flights, the first flight on the right."""
    first = flights[0]
    # Written out, not as matrices: the entries may be decimals, balls, or numbers that carry their error.
    for a, b, c, d in flights[1:]:
        e, f, g, h = first
        first = a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h
    return first


def product_trace(flights: Sequence[Jacobian]) -> Any:
    """Trace of the product of the Jacobians of flights, the first flight on the right."""
    if len(flights) == 1:
        return flights[0][0] + flights[0][3]
    (e, f, g, h), (a, b, c, d) = lap_jacobian(flights[:-1]), flights[-1]
    return a * e + b * g + c * f + d * h


def discriminant(trace: Arithmetic, decay: Arithmetic) -> Any:
    """Delta = tr^2 - 4 det of Eq. (4.3), as the product (tr - 2 decay)(tr + 2 decay) that keeps its digits near zero.

    `decay` is the root of the determinant, as in `TRACE_LEVELS`: r^2 of a 1:1 motion.
    """
    focus = TRACE_LEVELS[Event.NODE_FOCUS](decay)
    return (trace - focus) * (trace + focus)


def eigenvalues(trace: Arithmetic, decay: float) -> tuple[Any, Any]:
    """Real eigenvalues, or their real part where Delta < 0, Eq. (4.3); larger first.

    The eigenvalue whose formula would cancel is taken from the product lambda_1 lambda_2 = decay^2.

    Notes
    -----
    The paper prints Im(lambda) = sqrt([4 Det - Tr^2]/2); the 2 stands outside the root.
    """
    trace = np.asarray(trace, dtype=float)
    root = np.sqrt(np.maximum(discriminant(trace, decay), 0.0))
    large = (trace + np.copysign(root, trace)) / 2
    safe = np.where(root > 0, large, 1.0)
    small = np.where(root > 0, decay * decay / safe, large)
    return np.maximum(large, small), np.minimum(large, small)


def classify(trace: Any, decay: Any) -> NDArray[np.int8]:
    """Table 1's types of motions as codes of `Stability`, from ``|tr|`` against 2 decay and 1 + decay^2."""
    # By the trace itself: next to Delta = 0 rounded eigenvalues are real or complex by chance.
    size, focus, edge = np.abs(trace), TRACE_LEVELS[Event.NODE_FOCUS](decay), TRACE_LEVELS[Event.FOLD](decay)
    return np.where(size < focus, FOCUS, np.where(size < edge, NODE, UNSTABLE)).astype(np.int8)
