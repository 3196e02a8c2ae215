"""1:1 motions as rows of numbers: phases, velocities, stability and gap, and the value of the swept parameter."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.motions.orbits import Orbits
from vireport.motions.stability import (
    STABILITIES,
    UNSTABLE,
    Stability,
    classify,
    determinant_of,
    discriminant,
    lap_decay,
    return_trace,
)
from vireport.motions.sweep import Sweep
from vireport.motions.turning import wall_gap
from vireport.physics.device import Device
from vireport.physics.forcing import wave
from vireport.physics.groups import Groups, Restitutions, by_wall, map_restitution
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter

Floats = NDArray[np.float64]

SAMPLES = 80
"""Number of samples of a flight, enough to draw a smooth curve."""


class Motions(Struct, frozen=True, eq=False):
    """Motions with one bottom and one top impact, as arrays of equal length (dimensionless but for `sweep_value`).

    Attributes
    ----------
    sweep_value : ndarray
        The swept parameter, in its unit.
    d, gbar : ndarray
        The dimensionless groups.
    q : ndarray
        Share of the period that the ball takes from the bottom to the top.
    u : ndarray
        q - 1/2, to full relative accuracy, which q does not give where u is small.
    phi_bottom, phi_top : ndarray
        Forcing phase at the impacts [rad], in [0, 2 pi).
    velocity_bottom, velocity_top : ndarray
        Relative velocity just before the impacts; positive at the bottom, negative at the top.
    trace, discriminant : ndarray
        Trace of DP and Delta = tr^2 - 4 det, Eq. (4.3).
    stability : ndarray of int
        Codes of `Stability`.
    wall_gap : ndarray
        Distance of the nearest turning point to a membrane, see `turning.wall_gap`.
    admissible_mask : ndarray of bool
        Whether the ball stays between the membranes: the gap is positive.
    restitution : float or Restitutions
        r, on which the type of stability rests: of both membranes, or of each; arrays over the motions where
        it falls with speed.
    """

    sweep_value: Floats
    d: Floats
    gbar: Floats
    q: Floats
    u: Floats
    phi_bottom: Floats
    phi_top: Floats
    velocity_bottom: Floats
    velocity_top: Floats
    trace: Floats
    discriminant: Floats
    stability: NDArray[np.int8]
    wall_gap: Floats
    admissible_mask: NDArray[np.bool_]
    restitution: Any

    def __len__(self) -> int:
        """Return the number of motions."""
        return len(self.d)

    def __repr__(self) -> str:
        admissible, stable = int(self.admissible_mask.sum()), int(self.stable_mask.sum())
        return f"<Motions: {len(self)}, {admissible} admissible, {stable} stable>"

    @property
    def decay(self) -> Any:
        """Root of the determinant of DP, see `lap_decay`: a number, or an array over the motions."""
        decay = lap_decay(self.restitution)
        return decay if np.ndim(decay) else float(decay)

    @property
    def determinant(self) -> Floats:
        """Determinant of DP: r^4 for every motion, Eq. (A.3), or the square of `decay`."""
        return np.full(len(self), determinant_of(self.restitution))

    def select(self, index: Any) -> Motions:
        """The motions picked by an index or mask, or in another order."""
        names = (name for name in self.__struct_fields__ if name != "restitution")
        restitution = map_restitution(self.restitution, lambda r: r[index] if np.ndim(r) else r)
        return replace(self, **{name: getattr(self, name)[index] for name in names}, restitution=restitution)

    def mirrored(self) -> Motions:
        """The mirror images, which a horizontal capsule with membranes that are alike has."""
        return replace(
            self,
            # From u, which has the digits that q lost; and 0 - u, as -u would make the zero of symmetric motions
            # negative.
            q=0.5 - self.u,
            u=0.0 - self.u,
            phi_bottom=np.mod(self.phi_top + np.pi, 2 * np.pi),
            phi_top=np.mod(self.phi_bottom + np.pi, 2 * np.pi),
            velocity_bottom=-self.velocity_top,
            velocity_top=-self.velocity_bottom,
        )

    def motion(self, row: int, n: int) -> Motion:
        """The motion of a row, which takes n forcing periods, by its impacts; its coordinate is the swept value."""
        start, up = self.phi_bottom[row] / pi, 2 * n * (0.5 + self.u[row])
        velocity = np.array([self.velocity_bottom[row], self.velocity_top[row]])
        return Motion(Word((1, -1), n), velocity, np.array([start, start + up]), float(self.sweep_value[row]))

    @property
    def words(self) -> list[Stability]:
        """Table 1's type of each motion, in its words."""
        return [STABILITIES[code] for code in self.stability]

    @property
    def stable_mask(self) -> NDArray[np.bool_]:
        """Whether each motion is admissible and attracts those nearby."""
        return np.asarray(self.admissible_mask & (self.stability != UNSTABLE))

    @property
    def drawn_row(self) -> int | None:
        """Row of the first stable motion, else of the first admissible one; None if none is admissible."""
        if not self.admissible_mask.any():
            return None
        return int(np.argmax(self.admissible_mask * (1 + self.stable_mask)))


def impact_velocities(device: Device, parameter: Parameter, motions: Motions) -> tuple[Floats, Floats]:
    """Relative velocities at the bottom and at the top impact [m/s].

    Parameters
    ----------
    device : Device
    parameter : Parameter
        The swept parameter, whose values are `motions.sweep_value`.
    motions : Motions
    """
    unit = np.asarray(device.velocity_unit(parameter, motions.sweep_value))
    return unit * motions.velocity_bottom, unit * motions.velocity_top


class BallPath(Struct, frozen=True, eq=False):
    """Positions of ball and capsule over one period of a motion, as arrays of one length.

    Attributes
    ----------
    time : ndarray
        Time since a bottom impact [forcing periods]; the time of the top impact stands twice.
    distance : ndarray
        Distance of the ball from the bottom membrane over s, 1/2 - Z/d [-]: 0 at the bottom membrane, 1 at the top one.
    capsule : ndarray
        Displacement of the capsule's centre from its mean place [x_c].
    """

    time: Floats
    distance: Floats
    capsule: Floats

    __repr__ = brief


def ball_path(device: Device, parameter: Parameter, motions: Motions, row: int) -> BallPath:
    """Positions of ball and capsule over one period of a motion.

    Parameters
    ----------
    device : Device
    parameter : Parameter
        The swept parameter, whose values are `motions.sweep_value`.
    motions : Motions
    row : int
        Row of the motion.

    Source: Eq. (2.12).

    Notes
    -----
    A prescribed capsule follows P'' = cos(pi t + phi). With a free one the centre of mass of capsule and ball, which
    impacts leave alone, moves as (X + mu x)/(1 + mu) = P/(1 + mu), x = X - Z, so that X = (P + mu Z)/(1 + mu).
    """
    n, harmonics = device.period_ratio, device.harmonics
    friction = device.groups(parameter, float(motions.sweep_value[row])).friction
    d, gbar, q = (float(x[row]) for x in (motions.d, motions.gbar, motions.q))
    restitutions = Restitutions(*(float(r[row]) if np.ndim(r) else r for r in by_wall(motions.restitution)))
    groups = Groups(d, gbar, restitutions, harmonics, friction)
    flights_from = (
        (1, float(motions.phi_bottom[row]), float(motions.velocity_bottom[row]), q),
        (-1, float(motions.phi_top[row]), float(motions.velocity_top[row]), 1 - q),
    )
    mu, flights, start = device.mass_ratio, [], 0.0
    for wall, phase, velocity, share in flights_from:
        elapsed = np.linspace(0.0, 2 * n * share, SAMPLES)
        after = groups.after(wall, velocity)
        begun, then = (wave(np.sin(x), np.cos(x), harmonics) for x in (phase, np.pi * elapsed + phase))
        z = wall * d / 2 + groups.flown(elapsed, after, begun, then, -wall)[0]
        capsule = (mu * z - then.path / np.pi**2) / (1 + mu)
        flights.append((start + elapsed / 2, 0.5 - z / d, capsule))
        start += n * share
    (time_up, distance_up, capsule_up), (time_down, distance_down, capsule_down) = flights
    return BallPath(
        np.concatenate([time_up, time_down]),
        np.concatenate([distance_up, distance_down]),
        np.concatenate([capsule_up, capsule_down]),
    )


def motions_of(sweep: Sweep, orbit: Orbits, restitution: Any = None) -> Motions:
    """Evaluate stability and admissibility of motions on a sweep's level, as rows with all their numbers.

    A group that is constant over the sweep gets its exact value.

    Parameters
    ----------
    sweep : Sweep
    orbit : Orbits
    restitution : float or Restitutions, optional
        Restitution of these motions; by default that of `orbit`, or else of the device.
    """
    restitutions = sweep.device.restitution if orbit.restitution is None else orbit.restitution
    r = restitutions if restitution is None else restitution
    d, gbar = sweep.level.groups(orbit)
    # Copies: the caller puts exact numbers into single rows, and must not change the orbits.
    trace = np.array(return_trace(orbit, r))
    gap = wall_gap(orbit, r)
    return Motions(
        sweep_value=np.array(sweep.value(sweep.coordinate(orbit)), dtype=float),
        d=d,
        gbar=gbar,
        q=0.5 + np.array(orbit.u),
        u=np.array(orbit.u, dtype=float),
        phi_bottom=np.mod(orbit.phi, 2 * np.pi),
        phi_top=np.mod(np.arctan2(orbit.sin_top, orbit.cos_top), 2 * np.pi),
        velocity_bottom=np.array(orbit.velocity_bottom),
        velocity_top=np.array(orbit.velocity_top),
        trace=trace,
        discriminant=discriminant(trace, lap_decay(r)),
        stability=classify(trace, lap_decay(r)),
        wall_gap=gap,
        admissible_mask=gap > 0,
        restitution=r,
    )
