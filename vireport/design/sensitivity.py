"""Sensitivity of results at a design point to the inputs that are least well measured: restitution and ball mass."""

from __future__ import annotations

from operator import itemgetter

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.design.margins import VariedGroups
from vireport.design.point import motions_at
from vireport.motions.one_to_one import Motions
from vireport.motions.orbits import Dynamics, Friction, orbits_of
from vireport.motions.periodicity import linearised
from vireport.motions.pointwise import find_motions
from vireport.motions.stability import UNSTABLE, classify, lap_decay
from vireport.physics.contact import SMALLEST_RESTITUTION, contacts
from vireport.physics.device import Device
from vireport.physics.energy import Membrane, voltages
from vireport.physics.groups import by_wall, map_restitution, stated
from vireport.scenario.parameters import DesignInput, Parameter

Floats = NDArray[np.float64]

UNSURE = 0.05
"""Relative error of a restitution that was measured with care."""

SMALL = 1e-4
"""Relative change of an input for the difference that gives an elasticity."""

ROUNDING = float(np.finfo(float).eps)
"""Smallest relative change of an input, one rounding."""


class RestitutionEffect(Struct, frozen=True, eq=False):
    """The effect of a relative change of the restitution by `UNSURE` on the stable motions of a design point.

    Attributes
    ----------
    lost_at : float or None
        Restitution, of both membranes together, at which a stable motion is lost.
    elasticity : float
        Largest relative change of an impact velocity over that of the restitution, where none is lost.
    """

    lost_at: float | None
    elasticity: float


def restitution_effect(device: Device, motions: Motions) -> RestitutionEffect | None:
    """Follow the stable motions of a design point to a smaller and a larger restitution.

    Parameters
    ----------
    device : Device
        With all four parameters.
    motions : Motions
        At the design point.

    Returns
    -------
    RestitutionEffect or None
        None where there is no stable motion, or no restitution to change.
    """
    r = device.value_of(DesignInput.RESTITUTION)
    rows = np.flatnonzero(motions.stable_mask)
    if not rows.size or r == 0:
        return None
    # The closed form needs a restitution below 1, and a law one above 0: the change goes at most halfway to either.
    least, largest = min(stated(device.restitution)), max(stated(device.restitution))
    highest = (1 + largest) / 2 - (largest - r)
    changed = np.array([max(r * (1 - UNSURE), r - least / 2), min(r * (1 + UNSURE), highest)])
    elasticity = 0.0
    for other, velocities in zip(changed, _stable_velocities(device, changed), strict=True):
        if velocities.size < rows.size:
            return RestitutionEffect(float(other), 0.0)
        for before in motions.velocity_bottom[rows]:
            # Motions are not numbered alike at another restitution: each is paired with the nearest by its velocity.
            change = np.min(np.abs(velocities - before)) / before
            elasticity = max(elasticity, float(change / abs(other / r - 1)))
    return RestitutionEffect(None, elasticity)


def _stable_velocities(device: Device, restitutions: Floats) -> list[Floats]:
    """Velocities [y_c] at the bottom impact of the stable motions, for each of some restitutions of both membranes."""
    if device.law is not None:
        others = (device.with_values({DesignInput.RESTITUTION: float(r)}) for r in restitutions)
        motions_by_device = (motions_at(other, Parameter.LENGTH)[0] for other in others)
        return [motions.velocity_bottom[motions.stable_mask] for motions in motions_by_device]
    moved = device.with_values({DesignInput.RESTITUTION: restitutions}).restitution
    groups = device.groups(Parameter.LENGTH, device.length_m)
    moved_groups = groups._replace(
        d=np.full(2, groups.d), gbar=np.full(2, groups.gbar), restitution=moved, harmonics=device.harmonics
    )
    motions = find_motions(moved_groups, device.period_ratio)
    velocities = []
    for k in range(len(restitutions)):
        of_device = motions.cell == k
        decay = lap_decay(map_restitution(moved, itemgetter(k)))
        stable = classify(motions.trace[of_device], float(decay)) != UNSTABLE
        velocities.append(motions.orbit.velocity_bottom[of_device][stable & motions.admissible[of_device]])
    return velocities


def input_error(device: Device, motions: Motions) -> Floats:
    """Larger error of q [-] and phase [rad] of each motion of a design point from one rounding of d and gbar, (n,).

    By the inverse of the derivatives of (d, gbar) with respect to (q, phase), which are singular on a fold.
    """
    if device.law is not None:
        return _input_error_of_law(device, motions)
    r, n, u, phi = device.restitution, device.period_ratio, motions.u, motions.phi_bottom
    harmonics, rubbed = device.harmonics, device.groups(Parameter.LENGTH, device.length_m).friction
    friction = None if rubbed is None else Friction(rubbed)
    largest = max(by_wall(r))
    step = SMALL * (1 - largest) / (1 + largest)

    def slopes(du: float, dphi: float) -> tuple[Floats, Floats]:
        places = (u + du, phi + dphi), (u - du, phi - dphi)
        ahead, behind = (orbits_of(Dynamics(r, n, harmonics, friction), *place) for place in places)
        return (ahead.d - behind.d) / (2 * step), (ahead.gbar - behind.gbar) / (2 * step)

    (d_u, gbar_u), (d_phi, gbar_phi) = slopes(step, 0.0), slopes(0.0, step)
    # The determinant vanishes on a fold; the error is then cut off at 1, which says that no digit is right.
    determinant = np.maximum(np.abs(d_u * gbar_phi - d_phi * gbar_u), ROUNDING)
    # Solved by the cofactors of the 2x2 matrix, in absolute values: roundings have either sign.
    of_d, of_gbar = ROUNDING * motions.d, ROUNDING * motions.gbar
    in_u = (np.abs(gbar_phi) * of_d + np.abs(d_phi) * of_gbar) / determinant
    in_phi = (np.abs(gbar_u) * of_d + np.abs(d_u) * of_gbar) / determinant
    return np.asarray(np.minimum(np.maximum(in_u, in_phi), 1.0))


def _input_error_of_law(device: Device, motions: Motions) -> Floats:
    """`input_error` where restitutions fall with speed, by the derivatives of the motions' equations."""
    n, groups = device.period_ratio, device.groups(Parameter.LENGTH, device.length_m).as_floats()
    errors = []
    for row in range(len(motions)):
        motion = motions.motion(row, n)
        x = np.concatenate([motion.velocity, motion.time, groups.numbers])
        _, matrix = linearised(motion.word, x, VariedGroups(groups))
        unknowns = 2 * len(motion.word)
        try:
            moved = np.linalg.solve(
                matrix[:, :unknowns], matrix[:, unknowns : unknowns + 2] * ROUNDING * np.array(groups[:2])
            )
        except np.linalg.LinAlgError:
            errors.append(1.0)
            continue
        *_, bottom, top = moved
        errors.append(max(float(np.abs(top - bottom).sum()) / (2 * n), float(np.abs(bottom).sum()) * np.pi))
    return np.asarray(np.minimum(errors, 1.0))


def mass_elasticity(speed_bottom: Floats, speed_top: Floats, membrane: Membrane) -> float:
    """Largest relative change of U_ave over that of the ball's mass, at impact velocities [m/s] of some motions."""
    # By a difference, whose error is of the size of the change: the elasticity is told to a digit or two.
    heavier = replace(membrane, ball_mass_kg=membrane.ball_mass_kg * (1 + SMALL))
    base, more = (voltages(speed_bottom, speed_top, either).average_v for either in (membrane, heavier))
    usable = base > 0
    return float(np.max((more[usable] / base[usable] - 1) / SMALL, initial=0.0))


def contact_share(speeds: Floats, membrane: Membrane, r: float, frequency_hz: Floats) -> float | None:
    """Longest contact of impacts at some speeds [m/s] over the forcing period; None where r has no contact law.

    The slower the impact, the longer its contact.
    """
    moving = speeds > 0
    if r < SMALLEST_RESTITUTION or not moving.any():
        return None
    return float(np.max(contacts(speeds[moving], membrane, r).duration * frequency_hz[moving]))
