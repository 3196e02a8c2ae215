"""A few equations in as many unknowns, from a guess: MINPACK by way of SciPy, and what counts as solved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.base.errors import NumericalError

Floats = NDArray[np.float64]

ROUGHLY = 100.0
"""Residual, over the irregularity of the equations, at which a standstill of the iteration is that irregularity."""

MOST_EVALUATIONS = 100
"""Before a search is given up; five to fifteen are usual."""


def find_root(
    equations: Callable[[Floats], Any],
    guess: Sequence[float] | Floats,
    stop: float,
    noise: float,
    jacobian: bool = False,
) -> Floats:
    """Solve equations(x) = 0 near a guess.

    With a Jacobian, by Newton's steps kept within a trust region (Levenberg and Marquardt); without, by Powell's hybrid
    method with one Jacobian from forward differences and Broyden's updates.

    Parameters
    ----------
    equations : callable
        Array of unknowns, all of the order of one, to as many residuals; with `jacobian`, to residuals and Jacobian.
    guess : sequence of float
    stop : float
        Relative correction after which the next x is the solution.
    noise : float
        Size of what is irregular in the residuals, where no correction gets smaller.
    jacobian : bool
        Whether the equations give their Jacobian too.

    Raises
    ------
    NumericalError
        If the corrections do not settle where the equations hold.
    """
    from scipy.optimize import root  # type: ignore[import-untyped]

    if jacobian:
        # No test but that of the correction: the sum of squares may go on falling.
        options = {"xtol": stop, "ftol": 0.0, "maxiter": MOST_EVALUATIONS}
        result = root(equations, guess, jac=True, method="lm", options=options)
    else:
        result = root(equations, guess, method="hybr", options={"xtol": stop, "maxfev": MOST_EVALUATIONS})
    residual = float(np.max(np.abs(result.fun)))
    if not residual <= max(ROUGHLY * noise, stop if result.success else 0.0):
        raise NumericalError(f"Newton's method did not settle: residual {residual:.1g} after {result.nfev} evaluations")
    return np.asarray(result.x, dtype=float)
