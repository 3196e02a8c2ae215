"""How far the exact motion can be from each motion of a family as it was computed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vireport.motions.paths import Curve
from vireport.motions.periodicity import Model, residuals
from vireport.motions.sweep import Level
from vireport.physics import GROUP_ERROR, ROUNDED, Rounded

Floats = NDArray[np.float64]

NEAR = 0.1
"""Kantorovich's beta L eta up to which there is an exact motion close by; his theorem needs 0.5."""


def error_bounds(curve: Curve, model: Model, x: Floats) -> Floats:
    """Bound the distance of motions to an exact one next to them.

    The residuals, with bounds of their rounding, are taken through the least change that makes up for them. By the
    theorem of Newton and Kantorovich an exact motion is within twice that, where the conditions are regular enough.

    Parameters
    ----------
    curve : Curve
    model : Model
        Of the sweep that it is of.
    x : ndarray (n, 2N + 1)
        Velocities, times and coordinate of each motion.

    Returns
    -------
    ndarray (n, 2N + 1)
        For each of these; infinite where families cross. The exact motion belongs to the scenario's numbers as given.
    """
    word, level = curve.word, model.level
    if not level.horizontal:
        level = Level(level.held, Rounded(level.value, 2 * GROUP_ERROR * abs(level.value)))
    known = Model(level, Rounded(model.r))
    left = residuals(word, [Rounded(column) for column in x.T], known, ROUNDED)
    most = np.stack([np.abs(value.value) + value.error for value in left], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, sizes, v = np.linalg.svd(np.stack([curve.linearised(row)[1] for row in x]), full_matrices=False)
        change = np.abs(np.einsum("nki,nk,njk->nij", v, 1 / sizes, u)) @ most[..., None]
        # Second derivatives of a flight: of its phases, pi, over at most the period, and of its accelerations.
        _, gbar, _ = model.groups(np.abs(x[:, -1]))
        bend = 2 * np.pi * (1 + 2 * word.periods) * (2 + gbar) * np.sqrt(2 * len(word))
        eta = np.linalg.norm(change, axis=1)[:, 0]
        near = bend * eta / sizes[:, -1]
        bounds = change[..., 0] + (2 * near * eta)[:, None]
    bounds[:, -1] *= curve.width
    return np.where((near < NEAR)[:, None], bounds, np.inf)
