"""Jitter of a stable motion: how far small random kicks at every impact spread its phases, velocities and voltages.

Linear theory, a discrete Lyapunov equation, and an estimate of its error: by how much the mean, the covariance and the
skewness of the spread by the map itself differ. The error grows with the square of the kicks at first, and faster than
the spread towards a critical point.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from itertools import product
from math import ceil, hypot, inf, log, log2, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.findings.outcomes.deviations import chained, flight_matrices, growth, kick_effects, spread_by, stationary
from vireport.findings.outcomes.impact_map import forwards
from vireport.physics.energy import Membrane, generated_voltage
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import IMAGINARY_STEP

Floats = NDArray[np.float64]

TOLERANCE = 0.05
"""Largest error of a standard deviation, as a share of it, up to which linear theory is taken."""

HALVINGS = 40
"""Of kicks that are too large, until linear theory holds: the trace is then within rounding of its critical value."""

LEAST_KICK = 1e-5
"""Velocity [y_c] from which the neglected terms are found for smaller kicks too: theirs would be lost in rounding."""

FLATTEST = 1e-14
"""Ratio of the variances along the axes of a spread below which the smaller one is rounding."""

ROUNDS, SETTLED = 12, 0.01
"""Rounds in which the moments of a spread come to repeat themselves, and the change of its error at which they do."""

REFINED, NEARLY = 8, 0.97
"""How often it is looked how far kicks may grow, and the share of `TOLERANCE` that is near enough to it."""

BEYOND = 2.0
"""What fourth cumulants, which are not taken into account, may add to an error, over its square."""

MOMENTS = ("k,ka,kb->ab", 2), ("k,ka,kb,kc->abc", 3)
"""Sums that give covariance and third cumulants, and how many deviations are multiplied in each."""

WITHIN = 3.0
"""Standard deviations on either side of the restitution coefficient that must lie between 0 and 1."""


class Unsettled(StrEnum):
    """Why no jitter is given, or is not to be relied on."""

    UNSTABLE = "the motion is not stable"
    TOO_LARGE = "the kicks are too large for linear theory"
    IMPOSSIBLE = "the restitution would leave the range from 0 to 1"


class Jitter(Struct, frozen=True, eq=False):
    """Stationary spread of the impacts about a motion under random kicks (dimensionless unless said otherwise).

    Attributes
    ----------
    motion : Motion
    covariance : ndarray (N, 2, 2)
        Of time [t_c] and velocity just before [y_c] at each impact, by linear theory.
    mean : ndarray (N, 2)
        By how much kicks shift the means of these, to second order.
    error : float
        Relative error of the standard deviations, by the moments up to the third of the map itself.
    valid_up_to : float
        Factor by which both kinds of kicks may grow until that error is `TOLERANCE`, or the restitution may leave the
        range from 0 to 1; at least 1.
    """

    motion: Motion
    covariance: Floats
    mean: Floats
    error: float
    valid_up_to: float

    @property
    def phase_rad(self) -> Floats:
        """Standard deviation of the forcing phase at each impact, (N,) [rad]."""
        return np.asarray(pi * np.sqrt(self.covariance[:, 0, 0]))

    @property
    def velocity(self) -> Floats:
        """Standard deviation of the velocity just before each impact, (N,) [y_c]."""
        return np.asarray(np.sqrt(self.covariance[:, 1, 1]))

    def voltage_v(self, membrane: Membrane, velocity_unit: float) -> Floats:
        """Standard deviation of the voltage gained at each impact, to first order in that of the velocity, (N,) [V].

        Parameters
        ----------
        membrane : Membrane
        velocity_unit : float
            y_c [m/s].
        """
        speed = velocity_unit * np.abs(self.motion.velocity)
        stepped: Any = speed + 1j * IMAGINARY_STEP
        slope = generated_voltage(stepped, membrane).imag / IMAGINARY_STEP
        return np.asarray(np.abs(slope) * velocity_unit * self.velocity)

    def mean_voltage_v(self, membrane: Membrane, velocity_unit: float) -> Floats:
        """Mean of the voltage gained at each impact, to second order in the kicks, (N,) [V]; parameters as above."""
        # The voltage is no polynomial of the velocity, but near one: for a spread of a tenth, five nodes miss the mean
        # by 1e-11 of it, for a fifth by 5e-8. The voltage of the mean velocity alone is 0.15 % and 0.6 % too small.
        nodes, weights = np.polynomial.hermite_e.hermegauss(5)
        velocity = (self.motion.velocity + self.mean[:, 1])[:, None] + self.velocity[:, None] * nodes
        gained = generated_voltage(velocity_unit * np.abs(velocity), membrane)
        return np.asarray(gained @ (weights / weights.sum()))


class NoJitter(Struct, frozen=True):
    """The reason why no jitter is given, instead of numbers that would be wrong.

    Attributes
    ----------
    reason : Unsettled
    valid_up_to : float
        Factor, below 1, by which both kinds of kicks would have to shrink; 0 where none that was tried is small enough.
    """

    reason: Unsettled
    valid_up_to: float


class _Moments(NamedTuple):
    """Mean (2,), covariance (2, 2) and third cumulants (2, 2, 2) of deviations at an impact."""

    mean: Floats
    covariance: Floats
    skewness: Floats


def jitter(groups: Groups[float], motion: Motion, kick: float, restitution_scatter: float = 0.0) -> Jitter | NoJitter:
    """Find the stationary spread of a motion's impacts under random kicks, or refuse to.

    Parameters
    ----------
    groups : Groups
        Of the device.
    motion : Motion
    kick : float
        Standard deviation of the velocity added just after each impact [y_c].
    restitution_scatter : float
        Standard deviation of the restitution coefficient from impact to impact [-].

    Returns
    -------
    Jitter or NoJitter

    Raises
    ------
    ValueError
        Where a standard deviation is negative or not finite.

    Notes
    -----
    Deviations x of time and velocity go from impact to impact as A x + b k, with the flight's Jacobian A and what a
    velocity k just after the impact does to the next one, b. With independent kicks of variance
    sigma^2 + (sigma_r Z')^2 the covariance obeys S = A S A' + b b' (sigma^2 + (sigma_r Z')^2) from impact to impact,
    and repeats itself after a period.

    Neglected are quadratic and higher terms of the map. Their first effect on S is of order sigma^4. It comes from the
    shift of the mean, the skewness of the spread, and the map's curvature, and is found with the simulated map itself
    on a Gauss-Hermite rule: a first round from the linear spread gives mean and third cumulants, a second one what is
    added to S in a period. Without the skewness it would have the wrong sign next to a period doubling. With kicks that
    have errors of some per cent the next orders count as well, so rounds go on until the moments repeat themselves.
    What is left out then are fourth cumulants.
    """
    if not (0 <= kick < inf and 0 <= restitution_scatter < inf):
        raise ValueError(f"standard deviations must be finite and not negative: {kick}, {restitution_scatter}")
    matrices, effects = flight_matrices(groups, motion), kick_effects(groups, motion)
    lap = chained(matrices)
    if growth(lap) >= 1:
        return NoJitter(Unsettled.UNSTABLE, 0.0)
    kicks = kick**2 + (restitution_scatter * motion.velocity) ** 2
    sources = kicks[:, None, None] * effects[:, :, None] * effects[:, None, :]
    spreads = spread_by(matrices, sources)
    if not kicks.any():
        return Jitter(motion, spreads, np.zeros((len(matrices), 2)), 0.0, inf)
    room = _room(groups, motion, restitution_scatter)
    # Kicks may be so small that what is neglected is lost in rounding: the error is then found for larger kicks and
    # divided by the square of the factor, as it grows with the square at first.
    enlarged = max(0, ceil(log2(LEAST_KICK / sqrt(float(kicks.max())))))

    def off(factor: float) -> tuple[float, Floats]:
        spread = factor * kick, factor * restitution_scatter
        return _neglected(groups, motion, spread, lap, factor**2 * spreads)

    # Downwards from the largest: the first factor at which linear theory holds bounds how far kicks may grow.
    for power in range(enlarged, -HALVINGS, -1):
        factor = 2.0**power
        error, mean = off(factor)
        if error <= TOLERANCE:
            holds = min(_farthest(lambda times: off(times)[0], factor, error), room)
            if power < 0:
                # Twice as much was too large in the step before: no more can hold, whatever a power law says.
                return NoJitter(Unsettled.TOO_LARGE, min(holds, 2 * factor))
            if room < 1:
                return NoJitter(Unsettled.IMPOSSIBLE, holds)
            shifts = mean / factor**2
            return Jitter(motion, spreads, shifts, error / factor**2, holds)
    return NoJitter(Unsettled.TOO_LARGE, 0.0)


def _farthest(error_at: Callable[[float], float], factor: float, error: float) -> float:
    """The factor of the kicks up to which the error stays below `TOLERANCE`, from a factor at which it does."""
    aim, beyond, over = (1 + NEARLY) / 2 * TOLERANCE, inf, inf
    for _ in range(REFINED):
        if not 0 < error < NEARLY * TOLERANCE:
            break
        if beyond == inf:
            ahead = factor * sqrt(aim / error)  # it grows with the square
        elif over == inf:
            # Where nodes of the rule come to other membranes there is no error by which to go on.
            ahead = (factor + beyond) / 2
        else:
            # Next to a critical point it grows faster than with the square: by the power that both ends show.
            ahead = factor * (beyond / factor) ** (log(aim / error) / log(over / error))
        error_ahead = error_at(ahead)
        if error_ahead <= TOLERANCE:
            factor, error = ahead, error_ahead
        else:
            beyond, over = ahead, error_ahead
    return factor if error else inf


def _room(groups: Groups[float], motion: Motion, restitution_scatter: float) -> float:
    """Factor by which the scatter of the restitution may grow until values below 0 or above 1 are more than rare."""
    if restitution_scatter == 0:
        return inf
    coefficients = [groups.restitution_at(wall) for wall in motion.word.walls]
    return float(min(min(r, 1 - r) for r in coefficients) / (WITHIN * restitution_scatter))


def _neglected(
    groups: Groups[float],
    motion: Motion,
    spread: tuple[float, float],
    lap: Floats,
    linear: Floats,
) -> tuple[float, Floats]:
    """Relative error of the linear standard deviations, and shifts of the means at each impact, (N, 2).

    The error is inf where other membranes are met, or where the moments do not settle.
    """
    start = _Moments(np.zeros(2), linear[0], np.zeros((2, 2, 2)))
    passed = _through_a_period(groups, motion, spread, start)
    if passed is None:
        return inf, np.zeros(0)
    first = _repeated(lap, start, passed[-1])
    # The first period gives mean and skewness of the linear spread; what these add to the covariance shows from the
    # second one on.
    moments = first._replace(covariance=linear[0])
    scale = np.diagonal(linear, axis1=1, axis2=2)
    means, errors = np.zeros(0), [inf]
    for _ in range(ROUNDS):
        passed = _through_a_period(groups, motion, spread, moments)
        if passed is None:
            return inf, np.zeros(0)
        if not means.size:  # to second order in the kicks
            means = np.array([moments.mean, *(after.mean for after in passed[:-1])])
        moments = _repeated(lap, moments, passed[-1])
        covariances = np.array([moments.covariance, *(after.covariance for after in passed[:-1])])
        variances = np.diagonal(covariances, axis1=1, axis2=2)
        if not (variances > 0).all():
            return inf, np.zeros(0)
        errors.append(float(np.abs(np.sqrt(variances / scale) - 1).max()))
        if abs(errors[-1] - errors[-2]) <= SETTLED * errors[-1]:
            # Neither the first term nor the repeated moments are the whole error: the larger of both counts.
            error = max(errors[1], errors[-1])
            return error * (1 + BEYOND * error), means
    return inf, np.zeros(0)


def _repeated(lap: Floats, moments: _Moments, after: _Moments) -> _Moments:
    """Moments that come nearer to repeating themselves after a period, by a Newton step with linear theory."""
    # In a period linear theory multiplies deviations by A, and so each factor of their products.
    cubed = np.kron(lap, np.kron(lap, lap))
    mean = moments.mean + np.linalg.solve(np.eye(2) - lap, after.mean - moments.mean)
    skewed = np.linalg.solve(np.eye(8) - cubed, (after.skewness - moments.skewness).ravel())
    covariance = moments.covariance + stationary(lap, after.covariance - moments.covariance)
    return _Moments(mean, covariance, moments.skewness + skewed.reshape(2, 2, 2))


def _rule() -> tuple[Floats, Floats, Floats]:
    """Nodes (n, 3) and weights (n,) for three standard normal numbers, and third Hermite tensors of the first two.

    Five nodes each are exact up to the ninth degree; the kicks, of which only the fourth power matters, have three.
    """
    deviation, kick = np.polynomial.hermite_e.hermegauss(5), np.polynomial.hermite_e.hermegauss(3)
    nodes = np.array(list(product(deviation[0], deviation[0], kick[0])))
    weights = np.array([a * b * c for a, b, c in product(deviation[1], deviation[1], kick[1])])
    x, eye = nodes[:, :2], np.eye(2)
    tensor = np.einsum("ka,kb,kc->kabc", x, x, x)
    for indices in ("ka,bc->kabc", "kb,ac->kabc", "kc,ab->kabc"):
        tensor -= np.einsum(indices, x, eye)
    return nodes, weights / weights.sum(), tensor


def _through_a_period(
    groups: Groups[float], motion: Motion, spread: tuple[float, float], moments: _Moments
) -> list[_Moments] | None:
    """Moments after each flight of one period of the simulated map with kicks; None where a flight ends elsewhere."""
    passed: list[_Moments] = []
    nodes, weights, tensor = _rule()
    durations, walls, count = motion.durations, motion.word.walls, len(motion.word)
    mean, covariance, skewness = moments
    for i, wall in enumerate(walls):
        j = (i + 1) % count
        sizes = np.linalg.eigvalsh(covariance)
        # A spread that is a line, as with zero restitution, has no density to be corrected.
        if sizes[0] <= FLATTEST * sizes[1]:
            return None
        # Edgeworth's density: the normal one, to which the nodes belong, with the third cumulants as a first correction
        # of their weights.
        root = np.linalg.cholesky(covariance)
        inverse = np.linalg.inv(root)
        standard = np.einsum("ai,bj,ck,ijk->abc", inverse, inverse, inverse, skewness)
        share = weights * (1 + np.einsum("kabc,abc->k", tensor, standard) / 6)
        late, faster = (mean + nodes[:, :2] @ root.T).T
        before = motion.velocity[i] + faster
        kicks = nodes[:, 2] * np.array([hypot(spread[0], spread[1] * v) for v in before.tolist()])
        after = np.asarray(groups.after(wall, before)) + kicks
        # A node that comes from the wrong side, or does not leave, belongs to another word.
        if (wall * after >= 0).any() or (wall * before <= 0).any():
            return None
        ends = forwards(groups, wall, motion.time[i] + late, after)
        if (ends.wall != walls[j]).any():
            return None
        # By the flight's clock: the times of the motion begin anew with each period.
        off = np.stack([ends.time - motion.time[i] - durations[i], ends.velocity - motion.velocity[j]], axis=1)
        mean = np.asarray(share @ off, dtype=float)
        off = off - mean
        covariance, skewness = (
            np.asarray(np.einsum(indices, share, *(off,) * n), dtype=float) for indices, n in MOMENTS
        )
        passed.append(_Moments(mean, covariance, skewness))
    return passed
