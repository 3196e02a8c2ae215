"""Starting values of the fit: robust ones, which a few wrong impacts hardly move.

Each equation counts on its own, over the standard deviation that the timing error gives it, and the less the further
it is off. The phase of the force, where it is not known, is tried around the circle.
"""

from __future__ import annotations

from math import cos, pi

import numpy as np

from vireport.measurement.adjustment import Inquiry, within
from vireport.measurement.flights import (
    RESTITUTIONS,
    Array,
    ClockedDevice,
    Mask,
    MeasuredImpacts,
    Unknown,
    around_phases,
    equations,
)
from vireport.measurement.screening import MANY, MOST, typical

PHASES = 240
MOST_TRIED = 6
"""Phases that are looked at more closely, of each part of a record and each measure of agreement."""

FIRST = 40
"""Impacts that are fitted first; then twice as many, and so on: a clock that is a little off turns the phase far."""

MOST_STARTS = 8
ALIKE = 3.0
"""Ratio of timing errors up to which two fits of the first impacts are both pursued."""
CLOSE = 0.03
"""Difference of phase [rad] or restitution up to which they are the same."""

ENOUGH = 5000
"""Impacts from which the most likely parameters are found in a few steps."""

STEPS = 14
CLOSE_ENOUGH = 1e-5
"""Change of an unknown over its scale from which steps end: the most likely values are then few steps away."""

LEAST_MOVED = 1e-2
"""Singular value over the largest of combinations that are moved: noise drives others to the end of their range."""

HUBER, TUNING = 1.345, 4.685
"""Of Huber's and of Tukey's weights, in standard deviations: 95 % efficient without outliers."""

CLOCK = {Unknown.FREQUENCY, Unknown.DRIFT}
"""With which the phase turns away from a first guess in a long record."""


def starts(inquiry: Inquiry, impacts: MeasuredImpacts) -> list[ClockedDevice]:
    """Models to start fits from: one for each phase of the force at which the first impacts fit about as well as best.

    A periodic record may fit several.
    """
    if Unknown.PHASE not in inquiry.unknowns:
        first = _with_typical_restitutions(inquiry, impacts.first(10 * FIRST))
        return [_grown(inquiry.begun_with(first), impacts)]
    # What has not settled yet tells most of a motion that then repeats itself, and would be lost among the rest.
    longest = FIRST if {*inquiry.fitted} & CLOCK else 10 * FIRST
    parts = [impacts.first(few) for few in sorted({min(len(impacts), few) for few in (FIRST // 2, FIRST, longest)})]
    tried: list[ClockedDevice] = []
    for part in parts:
        around = _best_around(inquiry, part)
        tried += _best([_fitted(inquiry.begun_with(model), part) for model in around], inquiry.unknowns, [part])
    # All that fit one part are fitted to all, the first impacts first.
    for part in parts:
        tried = [_fitted(inquiry.begun_with(model), part) for model in tried]
    return [_grown(inquiry.begun_with(best), impacts) for best in _best(tried, inquiry.unknowns, parts)]


def _best(
    fitted: list[ClockedDevice], unknowns: tuple[Unknown, ...], parts: list[MeasuredImpacts]
) -> list[ClockedDevice]:
    """The models that fit one of the first parts of a record about as well as the best one, each once, the best first.

    Below a hundred-thousandth of a period all fit, and which is best is chance.
    """
    if not fitted:
        return []
    cost = np.array([[_spread(model, part, MANY) for part in parts] for model in fitted])
    # Of a part with hardly a flight nothing is known, and it says the same of all.
    cost = np.clip(cost, 1e-5 / fitted[0].device.frequency_hz, 1e9)
    cost /= cost.min(axis=0)
    apart: list[ClockedDevice] = []
    for k in np.argsort(cost.prod(axis=1), kind="stable"):
        if cost[k].min() <= ALIKE and not any(same_start(fitted[k], other, unknowns) for other in apart):
            apart.append(fitted[k])
    return apart[:MOST_STARTS]


def same_start(model: ClockedDevice, other: ClockedDevice, unknowns: tuple[Unknown, ...]) -> bool:
    """Whether two starts are so near that they lead to one fit: in phase, and in restitutions that are unknown."""
    turned = cos(model.phase - other.phase) > cos(CLOSE)
    values = ((model.value_of(x), other.value_of(x)) for x in unknowns if x in RESTITUTIONS)
    return turned and all(abs(a - b) < CLOSE for a, b in values)


def _spread(model: ClockedDevice, part: MeasuredImpacts, share: float = MOST) -> float:
    """Timing error that a share of the equations agrees on [s]."""
    return typical(equations(model, part), share)


def _best_around(inquiry: Inquiry, part: MeasuredImpacts) -> list[ClockedDevice]:
    """Models at the phases around which impacts fit best, with the restitutions that most of them agree on there."""
    model, phases = inquiry.model, np.arange(PHASES) * 2 * pi / PHASES
    free = [x for x in inquiry.unknowns if x in RESTITUTIONS]
    trial = [np.full(PHASES, model.value_of(x)) for x in RESTITUTIONS[1:]]

    def profile(single: Array, sides: Array) -> Array:
        """The middle of those of single impacts, for each membrane that is unknown."""
        bottom, top = trial
        for x in free:
            middle = _middle(single[:, _counts(x, sides)])
            bottom = middle if x != Unknown.RESTITUTION_TOP else bottom
            top = middle if x != Unknown.RESTITUTION_BOTTOM else top
        return np.where(sides > 0, bottom[:, None], top[:, None])

    # A phase fits where the restitutions of single impacts agree: no fit is needed to compare hundreds.
    off = around_phases(model, part, phases, profile)
    if not off.shape[1]:
        return []
    k = min(int(MOST * off.shape[1]), off.shape[1] - 1)
    # The logarithms add up near the truth even where too many impacts are missed for a share to agree.
    none = 1e-5 / model.device.frequency_hz
    costs = np.stack([np.partition(off, k)[:, k], np.log(off + none).mean(axis=1)], axis=1)
    lowest = (costs <= np.roll(costs, 1, axis=0)) & (costs <= np.roll(costs, -1, axis=0))
    chosen = {int(k) for i in (0, 1) for k in np.argsort(np.where(lowest[:, i], costs[:, i], np.inf))[:MOST_TRIED]}
    around = (model.with_values((Unknown.PHASE,), phases[k : k + 1]) for k in sorted(chosen) if lowest[k].any())
    return [_with_typical_restitutions(inquiry.begun_with(phased), part) for phased in around]


def _counts(x: Unknown, sides: Array) -> Mask:
    """Which impacts a restitution applies to, by their membranes (1 bottom, -1 top)."""
    side = {Unknown.RESTITUTION_BOTTOM: 1, Unknown.RESTITUTION_TOP: -1}.get(x, 0)
    return np.asarray((sides == side) | (side == 0))


def _middle(single: Array) -> Array:
    """Medians of rows (p, m) without NaN, within 0.01 and 0.99; 0.5 of rows without a number."""
    ordered = np.sort(single, axis=1)
    count = np.sum(np.isfinite(ordered), axis=1)
    if not single.shape[1]:
        return np.full(len(single), 0.5)
    middle = ordered[np.arange(len(single)), np.maximum(count // 2, 0)]
    return np.clip(np.where(count > 0, middle, 0.5), 0.01, 0.99)


def _with_typical_restitutions(inquiry: Inquiry, part: MeasuredImpacts) -> ClockedDevice:
    """The model with the restitutions that are unknown taken from the middle of those of single impacts."""
    model, free = inquiry.model, [x for x in inquiry.unknowns if x in RESTITUTIONS]
    if not free:
        return model
    system = equations(model, part)
    wall = part.walls[system.impacts]
    with np.errstate(all="ignore"):
        single = np.where(wall * system.before > 0, -system.after / system.before, np.nan)
    values = [float(_middle(single[None, _counts(x, wall)])[0]) for x in free]
    return model.with_values(tuple(free), np.array(values))


def _grown(inquiry: Inquiry, whole: MeasuredImpacts) -> ClockedDevice:
    """The model fitted to the first impacts, then to twice as many, up to all; or to enough, if no clock is unknown."""
    turning = bool({*inquiry.fitted} & CLOCK)
    most = len(whole) if turning else min(len(whole), ENOUGH)
    # Of a phase that does not turn away a first guess holds for many.
    count = min(FIRST if turning else 10 * FIRST, most)
    while True:
        inquiry = inquiry.begun_with(_fitted(inquiry, whole.first(count)))
        if count == most:
            return inquiry.model
        count = min(2 * count, most)


def _fitted(inquiry: Inquiry, part: MeasuredImpacts) -> ClockedDevice:
    """Least squares with Tukey's weights; along what the impacts leave open it does not move.

    On the error that most impacts keep to; where no error of most is that of many, too many were missed for it.
    """
    model = inquiry.model
    if not inquiry.fitted:
        return model
    none = 1e-5 / model.device.frequency_hz
    most = _descended(inquiry, part, MOST)
    many = max(_spread(most, part, MANY), none)
    if _spread(most, part, MOST) <= ALIKE * many and many <= ALIKE * max(_spread(model, part, MANY), none):
        return most
    # Of three impacts of a motion two can be fulfilled exactly, with the third far off: only where all else fails.
    other = _descended(inquiry, part, MANY)
    return min(most, other, key=lambda fit: _spread(fit, part, MANY))


def _descended(inquiry: Inquiry, part: MeasuredImpacts, share: float) -> ClockedDevice:
    """The best step of a descent in which errors are counted in that which a share of the equations keeps to."""
    model, every, unknowns, priors = inquiry.model, inquiry.fitted, inquiry.unknowns, inquiry.priors
    scales = np.array([model.scale_of(x, part.span_s) for x in every])
    # What the start does not know yet may make it far off everywhere: Huber's weights, as Tukey's would leave out all.
    tail = set(unknowns) <= {*RESTITUTIONS, Unknown.PHASE}
    best, least = model, np.inf
    for _ in range(STEPS):
        system = equations(model, part, every)
        error = max(typical(system, share), 1e-18)
        if error < least:
            best, least = model, error
        off = system.value / (system.spread * error)
        size = np.maximum(np.abs(off), 1e-300)
        root = np.clip(1 - (off / TUNING) ** 2, 0, None) if tail else np.sqrt(np.minimum(1.0, HUBER / size))
        values = np.array([model.value_of(x) for x in every])
        columns = system.by_unknown * scales / system.spread[:, None] * root[:, None]
        offsets = np.zeros((len(priors), len(every)))
        weight = np.array([error / prior.deviation for prior in priors])
        offsets[:, len(unknowns) :] = np.diag(weight * scales[len(unknowns) :])
        rest = weight * (values[len(unknowns) :] - [prior.value for prior in priors])
        right = -np.concatenate([system.value / system.spread * root, rest])
        move = np.linalg.lstsq(np.vstack([columns, offsets]), right, rcond=LEAST_MOVED)[0]
        move /= max(1.0, float(np.abs(move).max()) / 0.2)
        values = within(every, values + scales * move)
        for i, x in enumerate(every):
            if x in RESTITUTIONS:
                values[i] = np.clip(values[i], 0.0, 1.0)
        model = model.with_values(every, values)
        if np.abs(move).max() < CLOSE_ENOUGH:
            if tail:
                break
            tail = True
    return model if _spread(model, part, share) < least else best
