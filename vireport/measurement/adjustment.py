"""Maximum likelihood of impacts whose times all have errors: the true times are unknowns, as the parameters are.

The errors e of the measured times have the least sum e^2 with which all equations c(times - e, parameters) = 0 hold:
condition adjustment with unknowns (Gauss and Helmert). Each equation has three times, so that the matrix of the normal
equations has five diagonals, and the run time is proportional to the record. An average of the restitutions of single
impacts would be biased: the error of a time is in the numerator and the denominator of neighbouring ones.
"""

from __future__ import annotations

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import NumericalError
from vireport.measurement.flights import (
    RESTITUTIONS,
    Array,
    ClockedDevice,
    Equations,
    Mask,
    MeasuredImpacts,
    Unknown,
    equations,
)

MOST_STEPS = 20
LARGEST_STEP = 0.3
"""Share of a flight by which a time moves in a step at most."""

SLACK = 0.01
"""By how much an equation may fail, over what the timing error makes of it. Where a chaotic motion nearly touches a
motion that goes another way, the equations hold at no times that are near the measured ones, or at two: without any
slack the steps halve for ever, and one such place in thousands of impacts outweighs all others."""

SETTLED = 1e-3
"""Change over its standard error below which steps end."""

LEAST_SHARE = 1e-3
"""Singular value of a combination of unknowns, over the largest, up to which a record leaves it open: what the noise of
its times makes of a periodic motion is less, and an impact in a thousand that differs is more."""

ROUNDING = 1e-14
"""Error of a time over the length of a record that is no error of its measurement."""


class Prior(Struct, frozen=True):
    """A value of an input that is known from elsewhere than the record, with its standard deviation, in its unit."""

    unknown: Unknown
    value: float
    deviation: float


class Inquiry(Struct, frozen=True):
    """A device with inputs that are to be identified, and the priors of others.

    Attributes
    ----------
    model : ClockedDevice
        The device of the scenario; unknowns begin with its values.
    unknowns : tuple of Unknown
        The phase of the force comes last, where the record's clock has no reference to it.
    priors : tuple of Prior
        For further inputs, which are known with a tolerance.
    """

    model: ClockedDevice
    unknowns: tuple[Unknown, ...]
    priors: tuple[Prior, ...] = ()

    @property
    def fitted(self) -> tuple[Unknown, ...]:
        """All that is fitted: the unknowns, and then the inputs with priors."""
        return (*self.unknowns, *(prior.unknown for prior in self.priors))

    def begun_with(self, model: ClockedDevice) -> Inquiry:
        """The inquiry with the same unknowns that begins with another model."""
        return replace(self, model=model)


class Weights:
    """The covariance M = L L' of the equations' values for independent errors of times as in `Equations.spread`."""

    def __init__(self, system: Equations) -> None:
        from scipy.linalg import LinAlgError, cholesky_banded  # type: ignore[import-untyped]

        b, k = system.by_error, system.impacts
        m = len(k)
        band = np.zeros((3, m))
        band[0] = (1 + SLACK**2) * np.einsum("ij,ij->i", b, b)
        # Equations of neighbouring impacts share two times, those of the next but one share one.
        for apart in (1, 2):
            if m > apart:
                steps = k[apart:] - k[:-apart]
                near, far = steps == 1, steps == 2
                shared = near * (b[:-apart, 1] * b[apart:, 0] + b[:-apart, 2] * b[apart:, 1])
                band[apart, : m - apart] = shared + far * b[:-apart, 2] * b[apart:, 0]
        try:
            self.factor = cholesky_banded(band, lower=True, check_finite=False)
        except (LinAlgError, ValueError) as error:
            raise NumericalError("the equations of the impacts depend on one another") from error
        if not np.isfinite(self.factor).all():
            raise NumericalError("the equations of the impacts are not finite")

    def whitened(self, columns: Array) -> Array:
        """L^-1 times columns (m,) or (m, k), which makes errors of the equations' values independent and alike."""
        from scipy.linalg.lapack import dtbtrs  # type: ignore[import-untyped]

        flat = columns.reshape(len(columns), -1)
        solved, _ = dtbtrs(self.factor, flat, uplo="L")
        return np.asarray(solved).reshape(columns.shape)

    def returned(self, columns: Array) -> Array:
        """L'^-1 times columns (m,) or (m, k), which takes whitened values back to the equations."""
        from scipy.linalg.lapack import dtbtrs

        solved, _ = dtbtrs(self.factor, columns.reshape(len(columns), -1), uplo="L", trans="T")
        return np.asarray(solved).reshape(columns.shape)


class Adjusted(Struct, frozen=True, eq=False):
    """Impacts and parameters that fit together exactly, nearest to what was measured.

    Attributes
    ----------
    model : ClockedDevice
    unknowns : tuple of Unknown
    errors : Array (n,)
        Errors of the measured times [s].
    covariance : Array (p, p)
        Covariance of the unknowns, in their units.
    information : Array (p, p)
        Information of the record alone on the unknowns, for a timing error of 1 s whatever the actual one is.
    freedom : int
        Degrees of freedom: number of equations less that of fitted unknowns.
    timing_error_s : float
        Standard deviation of the errors [s]; for unequal ones the common factor of their standard deviations.
    equations : Equations
        At the adjusted times.
    innovations : Array (m + q,)
        What each equation adds to those before it, over its standard deviation: independent, with standard deviation
        `timing_error_s`. Then what each prior adds.
    scaled_design : Array (m + q, p)
        Derivatives of the innovations by the unknowns over their scales.
    scales : Array (p,)
        See `ClockedDevice.scale_of`.
    weights : Weights
        Of the equations.
    settled : bool
        Whether further steps would change nothing.
    """

    model: ClockedDevice
    unknowns: tuple[Unknown, ...]
    errors: Array
    covariance: Array
    information: Array
    freedom: int
    timing_error_s: float
    equations: Equations
    innovations: Array
    scaled_design: Array
    scales: Array
    weights: Weights
    settled: bool

    @property
    def cost(self) -> float:
        """Sum of squares of the errors [s^2]."""
        return float(self.innovations @ self.innovations)

    def deviation_of(self, unknown: Unknown) -> float:
        """Standard error of an unknown, in its unit."""
        k = self.unknowns.index(unknown)
        return float(np.sqrt(self.covariance[k, k]))


def adjusted(inquiry: Inquiry, impacts: MeasuredImpacts) -> Adjusted:
    """Find the most likely unknowns, and the errors of the times with which all equations hold.

    Gauss-Newton steps on unknowns and times together: the times are eliminated, as each equation has three of them.

    Parameters
    ----------
    inquiry : Inquiry
    impacts : MeasuredImpacts
        As measured.

    Raises
    ------
    NumericalError
        If the equations depend on one another.
    """
    model, unknowns, priors = inquiry.model, inquiry.fitted, inquiry.priors
    times, shares, span = impacts.times, impacts.errors, impacts.span_s
    scales = np.array([model.scale_of(x, span) for x in unknowns])
    true = times.copy()
    stated = np.array([[p.value, p.deviation] for x in unknowns for p in priors if p.unknown is x]).reshape(-1, 2)
    where = np.array([i for i, x in enumerate(unknowns) for p in priors if p.unknown is x], dtype=int)
    observed = {prior.unknown for prior in priors}
    square, done = 0.0, False
    for step in range(MOST_STEPS):
        system = equations(model, impacts.at(true), unknowns)
        weights = Weights(system)
        around = system.impacts[:, None] + np.arange(-1, 2)
        # The equations at the measured times, linearised at the times of this step and not at the measured ones, so
        # that the iteration converges to the exact conditions.
        misclosure = system.value + np.einsum("ij,ij->i", system.by_time, (times - true)[around])
        white, columns = weights.whitened(misclosure), weights.whitened(system.by_unknown * scales)
        freedom = len(misclosure) - len(unknowns) + len(where)
        if step == 0:
            # The weight of priors needs a variance of the times; before a fit there is only this estimate.
            square = float(white @ white) / max(freedom, 1)
        # A prior is one more observation of an unknown, with a weight.
        values = np.array([model.value_of(x) for x in unknowns])
        weight = np.sqrt(square) / stated[:, 1] if len(stated) else np.empty(0)
        more = np.zeros((len(where), len(unknowns)))
        more[np.arange(len(where)), where] = weight * scales[where]
        rest = weight * (values[where] - stated[:, 0]) if len(stated) else np.empty(0)
        design, right = np.vstack([columns, more]), np.concatenate([white, rest])
        inverse, move = _solved(design, right, np.array([x not in observed for x in unknowns]))
        left = right + design @ move
        square = float(left @ left) / max(freedom, 1)
        # The least errors that close the equations: the transposed conditions times their multipliers.
        errors = np.zeros_like(times)
        np.add.at(errors, around, system.by_error * weights.returned(left[: len(white)])[:, None])
        errors *= shares
        target = times - errors
        flights = np.diff(true)
        allowed = LARGEST_STEP * np.minimum(np.append(flights, np.inf), np.concatenate([[np.inf], flights]))
        move_of_times = target - true
        moved = np.clip(move_of_times, -allowed, allowed)
        # A step of the unknowns beyond 0.2 of their scales leaves the range in which the conditions are linear.
        limit = max(1.0, float(np.abs(move).max(initial=0.0)) / 0.2)
        true, values = true + moved / limit, values + scales * move / limit
        values = within(unknowns, values)
        model = model.with_values(unknowns, values)
        error = float(np.sqrt(square))
        # With exact times only rounding is left, below which no step settles.
        rounding = error < ROUNDING * span
        settled = np.abs(move) <= SETTLED * np.sqrt(square * np.diag(inverse)) + 1e-13
        times_settled = np.abs(move_of_times / shares).max() <= SETTLED * error + ROUNDING * span
        done = bool(limit == 1 and times_settled and (settled.all() or rounding))
        if done:
            break
    covariance = square * inverse * np.outer(scales, scales)
    information = columns.T @ columns / np.outer(scales, scales)
    return Adjusted(
        model,
        unknowns,
        times - true,
        covariance,
        information,
        freedom,
        error,
        system,
        left,
        design,
        scales,
        weights,
        done,
    )


def _solved(design: Array, right: Array, free: Mask) -> tuple[Array, Array]:
    """Inverse of the normal matrix and step of least squares, restricted to what the record determines.

    Parameters
    ----------
    design : Array (m, p)
        Derivatives of the residuals by the unknowns over their scales.
    right : Array (m,)
        The residuals.
    free : Mask (p,)
        Unknowns without priors: only combinations of these may be left open, along which no step is taken.
    """
    # Combinations of free unknowns that the record leaves open are projected out, so that no step goes along them.
    ways = np.eye(len(free))
    if free.any():
        _, s, v = np.linalg.svd(design[:, free], full_matrices=False)
        kept = np.zeros((len(free), int(np.sum(s > LEAST_SHARE * s[0]))))
        kept[free] = v[: kept.shape[1]].T
        ways = np.hstack([kept, ways[:, ~free]])
    normal = design @ ways
    size = np.linalg.norm(normal, axis=0)
    size[size == 0] = 1.0
    inverse = ways / size @ np.linalg.pinv((normal / size).T @ (normal / size), hermitian=True) @ (ways / size).T
    return inverse, -inverse @ (design.T @ right)


def within(unknowns: tuple[Unknown, ...], values: Array) -> Array:
    """Values of unknowns clipped to where the equations have a meaning: lengths, forces and masses above 0."""
    positive = {Unknown.LENGTH, Unknown.AMPLITUDE, Unknown.CAPSULE_MASS, Unknown.FREQUENCY}
    limits = [
        (-0.5, 1.5) if x in RESTITUTIONS else (1e-12, np.inf) if x in positive else (-np.inf, np.inf) for x in unknowns
    ]
    low, high = np.array(limits).reshape(-1, 2).T
    return np.clip(values, low, high)
