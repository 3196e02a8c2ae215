"""Where the search for the most likely parameters begins: a fit that a few wrong impacts hardly move.

Each equation counts on its own, over the standard deviation that the timing error gives it, and the less the further
it is off. The phase of the force, where it is not known, is tried around the circle.
"""

from __future__ import annotations

from math import cos, pi

import numpy as np

from vireport.measurement.adjustment import Prior, with_known
from vireport.measurement.flights import RESTITUTIONS, Array, ClockedDevice, Mask, Unknown, equations
from vireport.measurement.screening import MANY, MOST, typical

PHASES = 72
FIRST = 40
"""Impacts that are fitted first; then twice as many, and so on: a clock that is a little off turns the phase far."""

MOST_STARTS = 8
ALIKE = 3.0
"""Ratio of timing errors up to which two fits of the first impacts are both pursued."""
CLOSE = 0.03
"""Difference of phase [rad] or restitution up to which they are the same."""

ENOUGH = 5000
"""Impacts from which the most likely parameters are found in a few steps."""

STEPS = 12
LEAST_MOVED = 1e-2
"""Singular value over the largest of combinations that are moved: noise drives others to the end of their range."""

HUBER, TUNING = 1.345, 4.685
"""Of Huber's and of Tukey's weights, in standard deviations: 95 % efficient without outliers."""

CLOCK = {Unknown.FREQUENCY, Unknown.DRIFT}
"""With which the phase turns away from a first guess in a long record."""


def starts(
    model: ClockedDevice,
    times: Array,
    walls: Array,
    unknowns: tuple[Unknown, ...],
    priors: tuple[Prior, ...] = (),
    flown: Mask | None = None,
) -> list[ClockedDevice]:
    """Models to begin with: one for each phase of the force around which the first impacts fit about as well as best.

    A periodic record may fit several. `flown` says between which impacts none was missed, where that is known.
    """
    if flown is None:
        flown = np.ones(len(times) - 1, dtype=np.bool_)
    if Unknown.PHASE not in unknowns:
        few = min(len(times), 10 * FIRST)
        first = _with_typical_restitutions(model, times[:few], walls[:few], flown, unknowns)
        return [_grown(first, times, walls, flown, unknowns, priors)]
    every = {*with_known(unknowns, priors)}
    # What has not settled yet tells most of a motion that then repeats itself, and would be lost among the rest.
    parts = [
        min(len(times), FIRST // 2),
        min(len(times), FIRST),
        min(len(times), FIRST if every & CLOCK else 10 * FIRST),
    ]
    fitted: list[ClockedDevice] = []
    for few in dict.fromkeys(parts):
        own, sides = times[:few], walls[:few]
        around = [
            _with_typical_restitutions(model.with_values((Unknown.PHASE,), np.array([x])), own, sides, flown, unknowns)
            for x in np.arange(PHASES) * 2 * pi / PHASES
        ]
        # The logarithms add up near the truth even where too many impacts are missed for a share to agree.
        costs = np.array([[_spread(one, own, sides, flown), _mean_logarithm(one, own, sides, flown)] for one in around])
        lowest = ((costs <= np.roll(costs, 1, axis=0)) & (costs <= np.roll(costs, -1, axis=0))).any(axis=1)
        for k in np.flatnonzero(lowest):
            one = around[k]
            for part in parts:
                one = _fitted(one, times[:part], walls[:part], flown, unknowns, priors)
            fitted.append(one)
    # Over the best of each part; below a hundred-thousandth of a period all fit, and which is best is chance.
    cost = np.array([[_spread(one, times[:few], walls[:few], flown, MANY) for few in parts] for one in fitted])
    cost = np.maximum(cost, 1e-5 / model.device.frequency_hz)
    cost /= cost.min(axis=0)
    apart: list[ClockedDevice] = []
    for k in np.argsort(cost.prod(axis=1), kind="stable"):
        if cost[k].min() <= ALIKE and not any(_same(fitted[k], other, unknowns) for other in apart):
            apart.append(fitted[k])
    return [_grown(own, times, walls, flown, unknowns, priors) for own in apart[:MOST_STARTS]]


def _same(one: ClockedDevice, other: ClockedDevice, unknowns: tuple[Unknown, ...]) -> bool:
    """Whether two fits are one, up to what may yet be refined."""
    turned = cos(one.phase - other.phase) > cos(CLOSE)
    values = ((one.value_of(x), other.value_of(x)) for x in unknowns if x in RESTITUTIONS)
    return turned and all(abs(a - b) < CLOSE for a, b in values)


def _spread(model: ClockedDevice, times: Array, walls: Array, flown: Mask, share: float = MOST) -> float:
    """Timing error that a share of the equations agrees on [s]."""
    return typical(equations(model, times, walls, flown[: len(times) - 1]), share)


def _mean_logarithm(model: ClockedDevice, times: Array, walls: Array, flown: Mask) -> float:
    """Mean logarithm of the timing error that each equation alone would need."""
    own = equations(model, times, walls, flown[: len(times) - 1])
    return float(np.log(np.abs(own.value) / own.spread + 1e-5 / model.device.frequency_hz).mean())


def _with_typical_restitutions(
    model: ClockedDevice, times: Array, walls: Array, flown: Mask, unknowns: tuple[Unknown, ...]
) -> ClockedDevice:
    """The model with the restitutions that are unknown taken from the middle of those of single impacts."""
    free = [x for x in unknowns if x in RESTITUTIONS]
    if not free:
        return model
    own = equations(model, times, walls, flown[: len(times) - 1])
    wall = walls[own.impacts]
    with np.errstate(all="ignore"):
        r = -own.after / own.before
    values = []
    for x in free:
        side = {Unknown.RESTITUTION_BOTTOM: 1, Unknown.RESTITUTION_TOP: -1}.get(x, 0)
        usable = np.isfinite(r) & (wall * own.before > 0) & ((wall == side) | (side == 0))
        values.append(float(np.clip(np.median(r[usable]), 0.01, 0.99)) if usable.any() else 0.5)
    return model.with_values(tuple(free), np.array(values))


def _grown(
    model: ClockedDevice,
    times: Array,
    walls: Array,
    flown: Mask,
    unknowns: tuple[Unknown, ...],
    priors: tuple[Prior, ...],
) -> ClockedDevice:
    """The model fitted to the first impacts, then to twice as many, up to all; or to enough, if no clock is unknown."""
    every = {*with_known(unknowns, priors)}
    most = len(times) if every & CLOCK else min(len(times), ENOUGH)
    count = min(FIRST, most)
    while True:
        model = _fitted(model, times[:count], walls[:count], flown, unknowns, priors)
        if count == most:
            return model
        count = min(2 * count, most)


def _fitted(
    model: ClockedDevice,
    times: Array,
    walls: Array,
    flown: Mask,
    unknowns: tuple[Unknown, ...],
    priors: tuple[Prior, ...],
) -> ClockedDevice:
    """Least squares with Tukey's weights; along what the impacts leave open it does not move."""
    every = with_known(unknowns, priors)
    if not every:
        return model
    scales = np.array([model.scale_of(x, float(times[-1] - times[0])) for x in every])
    flown = flown[: len(times) - 1]
    for step in range(STEPS):
        own = equations(model, times, walls, flown, every)
        error = max(typical(own), 1e-18)
        off = own.value / (own.spread * error)
        # Huber's weights first: Tukey's would leave out what the first guess is far from.
        size = np.maximum(np.abs(off), 1e-300)
        root = (
            np.sqrt(np.minimum(1.0, HUBER / size)) if step < STEPS // 2 else np.clip(1 - (off / TUNING) ** 2, 0, None)
        )
        values = np.array([model.value_of(x) for x in every])
        columns = own.by_unknown * scales / own.spread[:, None] * root[:, None]
        known = np.zeros((len(priors), len(every)))
        weight = np.array([error / prior.deviation for prior in priors])
        known[:, len(unknowns) :] = np.diag(weight * scales[len(unknowns) :])
        rest = weight * (values[len(unknowns) :] - [prior.value for prior in priors])
        right = -np.concatenate([own.value / own.spread * root, rest])
        move = np.linalg.lstsq(np.vstack([columns, known]), right, rcond=LEAST_MOVED)[0]
        move /= max(1.0, float(np.abs(move).max()) / 0.2)
        values = values + scales * move
        for i, x in enumerate(every):
            if x in RESTITUTIONS:
                values[i] = np.clip(values[i], 0.0, 1.0)
        model = model.with_values(every, values)
        if np.abs(move).max() < 1e-13:
            break
    return model
