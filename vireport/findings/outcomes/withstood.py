"""What the stable 1:1 motions of a design point withstand: the least shock of them all, and the largest jitter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import NumericalError
from vireport.base.records import brief
from vireport.design.point import DesignPoint
from vireport.design.solution import Solution
from vireport.findings.outcomes.deviations import is_smooth
from vireport.findings.outcomes.jitter import Jitter, NoJitter, jitter
from vireport.findings.outcomes.manifold import ShockLine, on_shocks, stable_manifold
from vireport.findings.outcomes.plane import OutcomePlane, shock_plane
from vireport.findings.outcomes.shock import SEARCH, Effort, LeastShock, MotionsByStability, least_shock
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.physics.groups import Groups, by_wall
from vireport.physics.motion import Motion
from vireport.scenario.parameters import Parameter

ROOM = 2.0
"""How far a plane of shocks reaches, over the least one."""


class ImpactSpread(NamedTuple):
    """How far kicks spread one impact of a motion: standard deviations, and the mean of the voltage.

    Attributes
    ----------
    membrane : str
        ``bottom`` or ``top``.
    phase_deg, velocity_m_s : float
        Of the forcing phase, and of the velocity just before.
    voltage_v, mean_voltage_v : float or None
        Of the voltage gained; None without a ball mass.
    """

    membrane: str
    phase_deg: float
    velocity_m_s: float
    voltage_v: float | None
    mean_voltage_v: float | None


class Withstood(Struct, frozen=True, eq=False):
    """What the stable 1:1 motions at the design point withstand; what was not computed is None.

    Attributes
    ----------
    velocity_unit : float
        y_c [m/s].
    time_unit : float
        t_c [s].
    shock : LeastShock or None
        Of the motion that withstands least.
    shock_unknown : str
        Why there is none, though it was asked for; "" otherwise.
    jitter_m_s, jitter_restitution : float
        Standard deviations of the velocity just after each impact [m/s] and of the restitution coefficient from impact
        to impact; 0 where none was asked for.
    jitter : Jitter or NoJitter or None
        Of the motion whose phases spread most, or that has none.
    membrane : Membrane or None
        By which velocities give voltages.
    """

    velocity_unit: float
    time_unit: float
    shock: LeastShock | None = None
    shock_unknown: str = ""
    jitter_m_s: float = 0.0
    jitter_restitution: float = 0.0
    jitter: Jitter | NoJitter | None = None
    membrane: Membrane | None = None

    __repr__ = brief

    @property
    def jump_m_s(self) -> float | None:
        """Size of the least shock [m/s]; None where none leads out of those that were tried."""
        return None if self.shock is None or self.shock.jump is None else self.shock.jump * self.velocity_unit

    @property
    def searched_to_m_s(self) -> float | None:
        """Size up to which shocks were tried [m/s]."""
        return None if self.shock is None else self.shock.searched_to * self.velocity_unit

    @property
    def after_bottom(self) -> bool:
        """Whether the least shock comes after an impact at the bottom, not at the top."""
        return self.shock is not None and self.shock.motion.word.walls[self.shock.impact] > 0

    @property
    def delay_s(self) -> float:
        """Time of the least shock since that impact [s]."""
        return 0.0 if self.shock is None else self.shock.delay * self.time_unit

    @property
    def jitter_unknown(self) -> str:
        """Why the requested jitter was not computed; "" where it was, or none was requested."""
        return self.jitter.reason if isinstance(self.jitter, NoJitter) else ""

    @property
    def spread(self) -> Jitter | None:
        """The jitter, where there is one."""
        return self.jitter if isinstance(self.jitter, Jitter) else None

    @property
    def phase_deg(self) -> float | None:
        """Largest standard deviation of the phase of an impact [deg]."""
        return None if self.spread is None else float(np.degrees(self.spread.phase_rad.max()))

    @property
    def velocity_m_s(self) -> float | None:
        """Largest standard deviation of the velocity before an impact [m/s], of the same motion."""
        return None if self.spread is None else float(self.spread.velocity.max()) * self.velocity_unit

    @property
    def spreads(self) -> list[ImpactSpread]:
        """The spread of each impact, in the order of the motion."""
        spread, unit = self.spread, self.velocity_unit
        if spread is None:
            return []
        columns = [
            ["bottom" if wall > 0 else "top" for wall in spread.motion.word.walls],
            *(np.degrees(spread.phase_rad).tolist(), (spread.velocity * unit).tolist()),
        ]
        volts = [[None] * len(columns[0])] * 2
        if self.membrane is not None:
            volts = [of(self.membrane, unit).tolist() for of in (spread.voltage_v, spread.mean_voltage_v)]
        return [ImpactSpread(*row) for row in zip(*columns, *volts, strict=True)]

    @property
    def valid_up_to_m_s(self) -> float | None:
        """Standard deviation of the kicks up to which linear theory holds, the ratio to that of r kept [m/s]."""
        return self.jitter.valid_up_to * self.jitter_m_s if self.jitter is not None and self.jitter_m_s else None

    @property
    def valid_up_to_restitution(self) -> float | None:
        """Standard deviation of the restitution coefficient up to which linear theory holds [-]."""
        scatter = self.jitter_restitution
        return self.jitter.valid_up_to * scatter if self.jitter is not None and scatter else None


def withstood_by(
    solution: Solution,
    shocks: bool,
    jitter_m_s: float = 0.0,
    jitter_restitution: float = 0.0,
    least_m_s: float | None = None,
) -> Withstood | None:
    """Find out what the stable 1:1 motions at the design point withstand; None where there are none.

    Parameters
    ----------
    solution : Solution
    shocks : bool
        Whether to look for the least shock, by compiled code.
    jitter_m_s, jitter_restitution : float
        Standard deviations of the velocity just after each impact [m/s], and of the restitution coefficient from impact
        to impact; 0 for none.
    least_m_s : float, optional
        Shock that must be withstood [m/s]: where none leads out up to the largest impact velocity, it is looked
        further, up to this one.
    """
    disturbed = disturbed_design(solution, "what shocks lead to")
    if disturbed is None:
        return None
    device, groups, unit, motions = disturbed
    shock, unknown = None, ""
    if shocks:
        try:
            shock = least_of(groups, motions, None if least_m_s is None else least_m_s / unit)
        except (NumericalError, ValueError) as error:  # too near a critical point, or a ball that does not bounce
            unknown = str(error)
    # A motion that has no jitter counts as the one that spreads most: no spread of another may stand for it.
    spreads: list[Jitter | NoJitter] = []
    if jitter_m_s or jitter_restitution:
        spreads = [jitter(groups, motion, jitter_m_s / unit, jitter_restitution) for motion in motions.stable]
    largest, period = max(spreads, key=_size, default=None), 0.5 / float(device.frequency_hz)
    return Withstood(unit, period, shock, unknown, jitter_m_s, jitter_restitution, largest, solution.membrane)


class DisturbedDesign(NamedTuple):
    """A design point with a stable 1:1 motion: its device with groups and y_c [m/s], and its motions."""

    device: Device
    groups: Groups[float]
    velocity_unit: float
    motions: MotionsByStability


def disturbed_design(solution: Solution, purpose: str) -> DisturbedDesign | None:
    """The design point whose stable 1:1 motions are disturbed; None where it has none.

    Raises
    ------
    UsageError
        If the restitution falls with speed; `purpose` is what is not available then.
    """
    design, device = solution.design, solution.device.constant_restitution(purpose)
    if design is None or not design.motions.stable_mask.any():
        return None
    # Only 1:1 motions, whatever the sweep: their companions are known from the same equations without following any.
    at = Parameter.LENGTH, device.length_m
    groups, unit = device.groups(*at).as_floats(), float(device.velocity_unit(*at))
    return DisturbedDesign(device, groups, unit, motions_by_stability(design, device))


def shocks_around(
    groups: Groups[float], motions: Sequence[Motion], least: LeastShock
) -> tuple[OutcomePlane, list[ShockLine]]:
    """The plane of shocks to a motion, and the shocks that lead onto an unstable motion.

    Parameters
    ----------
    groups : Groups
        Of the device.
    motions : sequence of Motion
        The stable ones that are known, among them that of the least shock.
    least : LeastShock
        The plane reaches up to `ROOM` times it, or as far as it was searched.

    Raises
    ------
    NumericalError
        If a stable motion is so near a critical point that its returns are not told.
    """
    others = [motion for motion in motions if motion.distance(least.motion) > 0]
    largest = least.searched_to if least.jump is None else ROOM * least.jump
    plane = shock_plane(groups, [least.motion, *others], largest)
    # Backwards in time friction does not tell when a ball that stands began to.
    if least.companion is None or 0 in by_wall(groups.restitution) or groups.friction is not None:
        return plane, []
    fastest = float(np.abs(least.motion.velocity).max()) + largest
    pieces = stable_manifold(groups, least.companion, fastest)
    return plane, [line for piece in pieces for line in on_shocks(groups, least.motion, piece)]


def motions_by_stability(design: DesignPoint, device: Device) -> MotionsByStability:
    """The admissible motions at the design point, of the unstable ones those whose neighbourhood is known."""
    motions = design.motions
    stable, unstable = (
        [motions.motion(int(row), device.period_ratio) for row in np.flatnonzero(rows)]
        for rows in (motions.stable_mask, motions.admissible_mask & ~motions.stable_mask)
    )
    return MotionsByStability(stable, list(filter(is_smooth, unstable)))


def least_of(
    groups: Groups[float],
    motions: MotionsByStability,
    least: float | None = None,
    effort: Effort = SEARCH,
) -> LeastShock:
    """The least shock of several motions, each searched as far as the others.

    Parameters
    ----------
    groups : Groups
        Of the device.
    motions : MotionsByStability
        At least one of them stable.
    least : float, optional
        Shock that must be withstood [y_c]; searched that far only where none leads out up to the impact velocity.
    effort : Effort

    Raises
    ------
    ValueError, NumericalError
        As `least_shock`.
    """
    # All as far as the fastest: one that is searched less far could have a smaller shock than the least that is found.
    usual = max(float(np.abs(motion.velocity).max()) for motion in motions.stable)
    # Searched further only where nothing leads out: the same number of shocks in a wider range are farther apart. By a
    # hair more than is required, lest the range fall short of it when it is converted back to m/s.
    further = [least * (1 + 1e-9)] if least is not None and least >= usual else []
    for farthest in [usual, *further]:
        shocks = [least_shock(groups, motion, motions, farthest, effort) for motion in motions.stable]
        least_one = min(shocks, key=lambda shock: np.inf if shock.jump is None else shock.jump)
        if least_one.jump is not None:
            break
    return replace(least_one, tried=sum(shock.tried for shock in shocks))


def _size(of: Jitter | NoJitter) -> float:
    return float(of.phase_rad.max()) if isinstance(of, Jitter) else np.inf
