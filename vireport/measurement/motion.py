"""The motion that a record shows: velocities, phases and flight times of its impacts, its word, and their errors.

Velocities at both ends of a flight follow from its two times and the force's phase, Eqs. (2.11), (2.12): no restitution
is needed. The errors of the times, of fitted unknowns, and of the inputs are propagated linearly, with their
correlations.
"""

from __future__ import annotations

from enum import IntEnum
from math import pi

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.progress import Progress
from vireport.measurement.adjustment import Adjusted, Inquiry, Prior
from vireport.measurement.flights import (
    RESTITUTIONS,
    Array,
    ClockedDevice,
    Indices,
    MeasuredImpacts,
    Unknown,
    dimensionless,
)
from vireport.measurement.flights import velocities as velocities_of
from vireport.measurement.identification import Fitted, NoFit, Unidentifiable, exact_below, fit, growth_rates
from vireport.measurement.inquiry import BOTH_MEMBRANES, tolerance_priors
from vireport.measurement.records import Record
from vireport.physics.device import Device
from vireport.physics.word import Word
from vireport.scenario.blocks import TolerancesBlock
from vireport.scenario.parameters import Parameter

LONGEST_WORD = 24
"""Impacts of a motion that is looked for as one that repeats itself."""

SAME = 7.0
"""Timing errors up to which an impact is as late as the one a period before it: five of the difference of two."""

LEAST_REPEATS = 6
"""Periods of a motion that must be alike before it is said to repeat itself."""

HIDDEN = 0.2
"""Standard errors of a mean up to which what is left of a transient may move it."""

STEADY = 3.0
"""Standard errors up to which the first half of what repeats itself is as the second: else it still settles."""

STEP = 1e-6
"""Of the differences that derivatives are taken by: of times in periods, of unknowns over their scales."""


class Quantity(IntEnum):
    """Quantities of an impact: velocities just before and just after it, its forcing phase, the flight after it."""

    BEFORE = 0
    AFTER = 1
    PHASE = 2
    FLIGHT = 3
    BEFORE_SI = 4
    AFTER_SI = 5


class ForceMaximum(Struct, frozen=True):
    """A time of the record's clock at which the force has a maximum, with its standard error [s]."""

    time_s: float
    error_s: float = 0.0


class MeasuredMotion(Struct, frozen=True, eq=False):
    """A periodic motion in a record, as the mean of its periods.

    Attributes
    ----------
    word : Word
        Its impacts, as the alphabetically first of the rotations.
    from_s : float
        Time of the record from which the motion repeats itself [s].
    impacts : int
        Number of impacts that are averaged.
    values : Array (6, N)
        A row for each `Quantity`: [y_c], [y_c], [rad] (not reduced to a turn), [t_c], [m/s], [m/s].
    restitutions : Array (2,)
        Of the bottom and of the top membrane: as fitted to the record, or as the scenario has them.
    covariance : Array (6 N + 2, 6 N + 2)
        Covariance of the values, row by row, and of the restitutions.
    """

    word: Word
    from_s: float
    impacts: int
    values: Array
    restitutions: Array
    covariance: Array

    @property
    def errors(self) -> Array:
        """Standard errors of the values, (6, N)."""
        count = self.values.size
        return np.asarray(np.sqrt(np.diag(self.covariance)[:count]).reshape(self.values.shape))


class Measured(Struct, frozen=True, eq=False):
    """The impacts of a record with their velocities and phases, and the motion that they repeat.

    Attributes
    ----------
    times : Array (n,)
        Of the impacts, without rows that are none, on the record's clock [s].
    walls : Array (n,)
        1 at the bottom, -1 at the top.
    values, errors : Array (6, n)
        A row for each `Quantity` with its standard errors; NaN where a flight is not known.
    motion : MeasuredMotion or None
        None where the impacts do not repeat themselves.
    timing_error_s : float
    missed, false : int
        Impacts that were missed, and rows that are none.
    fitted : tuple of Unknown
        The unknowns that were fitted to the record; inputs with priors are fitted as well.
    """

    times: Array
    walls: Array
    values: Array
    errors: Array
    motion: MeasuredMotion | None
    timing_error_s: float
    missed: int
    false: int
    fitted: tuple[Unknown, ...]


def measured(
    device: Device,
    record: Record,
    tolerances: TolerancesBlock | None,
    maximum: ForceMaximum | None,
    say: Progress = lambda what: None,
) -> Measured | NoFit:
    """Evaluate velocities, phases and the motion of a device from a record of its impacts.

    Both restitutions are fitted to the record, so that nothing depends on those of the scenario, and without a
    reference to the force also its phase. Where a record does not determine all of these, as a periodic one without
    reference, only the phase is fitted, with the restitutions of the scenario.

    Parameters
    ----------
    device : Device
        As it was when the impacts were recorded.
    record : Record
    tolerances : TolerancesBlock or None
        Tolerances of the device's inputs.
    maximum : ForceMaximum or None
        A time of the record's clock at which the force is largest; None where that is not known.
    say : callable
        Called with each step as it begins.

    Raises
    ------
    Unidentifiable
        If the record is too short, or fits several motions.
    """
    origin = float(record.times[0]) if maximum is None else maximum.time_s
    impacts = MeasuredImpacts.undoubted(record.times - origin, record.walls, record.relative)
    questions = [BOTH_MEMBRANES] if maximum is not None else [(*BOTH_MEMBRANES, Unknown.PHASE), (Unknown.PHASE,)]
    for unknowns in questions:
        priors = tolerance_priors(tolerances, device, unknowns)
        if maximum is not None and maximum.error_s > 0:
            priors = (*priors, Prior(Unknown.PHASE, 0.0, 2 * pi * float(device.frequency_hz) * maximum.error_s))
        try:
            fitted = fit(Inquiry(ClockedDevice(device), unknowns, priors), impacts, say)
        except Unidentifiable:
            if unknowns == questions[-1]:
                raise
            continue
        return fitted if isinstance(fitted, NoFit) else _read(fitted, unknowns, origin)
    raise AssertionError("there is a question")


def _read(fitted: Fitted, unknowns: tuple[Unknown, ...], origin_s: float) -> Measured:
    """Quantities of all impacts of a fitted record with their errors, and the motion that they repeat."""
    adjustment, impacts = fitted.adjusted, fitted.kept
    values, by_time = _values(adjustment.model, impacts), _by_time(adjustment.model, impacts)
    around = np.pad(impacts.errors, 1, mode="edge")
    by_time *= np.stack([around[:-2], around[1:-1], around[2:]], axis=1)  # by errors, each in its own standard error
    by_unknown = _by_unknown(adjustment, impacts)
    # The effect of the times of a single impact on the unknowns fitted to all is neglected.
    variance = adjustment.timing_error_s**2 * np.einsum("qkj,qkj->qk", by_time, by_time)
    variance += np.einsum("qkp,pr,qkr->qk", by_unknown, adjustment.covariance, by_unknown)
    motion = None
    if (repeating := _repeating(fitted)) is not None:
        motion = _mean(adjustment, repeating, impacts, (values, by_time, by_unknown))
        motion = replace(motion, from_s=motion.from_s + origin_s)
    return Measured(
        impacts.times + origin_s,
        impacts.walls,
        values,
        np.sqrt(variance),
        motion,
        adjustment.timing_error_s,
        sum(gap.missed_s is not None for gap in fitted.gaps),
        len(fitted.false),
        unknowns,
    )


def _values(model: ClockedDevice, impacts: MeasuredImpacts) -> Array:
    """All quantities of all impacts, (6, n); NaN where a flight is not known."""
    values = np.full((len(Quantity), len(impacts)), np.nan)
    t, flown = dimensionless(model, impacts.times), impacts.flown
    after, before = velocities_of(model, impacts.times, impacts.walls)
    values[Quantity.BEFORE, 1:] = np.where(flown, before, np.nan)
    values[Quantity.AFTER, :-1] = np.where(flown, after, np.nan)
    values[Quantity.PHASE] = model.phase + pi * t
    values[Quantity.FLIGHT, :-1] = np.where(flown, np.diff(t), np.nan)
    unit = float(model.device.velocity_unit(Parameter.LENGTH, model.device.length_m))
    values[Quantity.BEFORE_SI] = unit * values[Quantity.BEFORE]
    values[Quantity.AFTER_SI] = unit * values[Quantity.AFTER]
    return values


def _by_time(model: ClockedDevice, impacts: MeasuredImpacts) -> Array:
    """Derivatives of the quantities of each impact by the times of the one before it, its own and the next, (6, n, 3).

    Where a quantity does not depend on a time the derivative is 0, even if the quantity is not known.
    """
    step = STEP / float(model.device.frequency_hz)
    place = np.arange(len(impacts))
    by_time = np.zeros((len(Quantity), len(impacts), 3))
    # The quantities of an impact depend on three successive times: every third time is moved at once.
    for first in range(3):
        moved = step * (place % 3 == first)
        later, earlier = (impacts.at(impacts.times + way * moved) for way in (1, -1))
        change = _values(model, later) - _values(model, earlier)
        for offset in range(3):
            of_wall = (place + offset - 1) % 3 == first
            by_time[:, of_wall, offset] = change[:, of_wall] / (2 * step)
    return by_time


def _by_unknown(adjustment: Adjusted, impacts: MeasuredImpacts) -> Array:
    """Derivatives of the quantities of each impact by what was fitted, (6, n, p)."""
    model, columns = adjustment.model, []
    for x, scale in zip(adjustment.unknowns, adjustment.scales, strict=True):
        if x in RESTITUTIONS:
            columns.append(np.zeros((len(Quantity), len(impacts))))
            continue
        step, value = STEP * float(scale), model.value_of(x)
        ends = (model.with_values((x,), np.array([value + way * step])) for way in (1, -1))
        above, below = (_values(end, impacts) for end in ends)
        columns.append((above - below) / (2 * step))
    return np.stack(columns, axis=-1)


class _Repeating(Struct, frozen=True, eq=False):
    """Impacts that repeat themselves: their word, the first of them, and each one's place in the word."""

    word: Word
    rows: Indices
    places: Indices


def _repeating(fitted: Fitted) -> _Repeating | None:
    """The end of a record over which its impacts repeat themselves as a stable motion, with the fewest of them."""
    adjustment, impacts = fitted.adjusted, fitted.kept
    times, walls = impacts.times, impacts.walls.astype(int)
    frequency = float(adjustment.model.device.frequency_hz)
    same = SAME * np.maximum(adjustment.timing_error_s * impacts.errors, exact_below(adjustment.model))
    lost = np.concatenate([[0], np.cumsum(~impacts.flown)])
    rates, of_rates = growth_rates(fitted), adjustment.equations.impacts
    for count in range(1, min(LONGEST_WORD, len(times) // LEAST_REPEATS) + 1):
        first = np.flatnonzero(lost[count:] == lost[:-count])
        if len(first) < LEAST_REPEATS * count:
            continue
        # Impacts that repeat after `count` of them take a whole number of forcing periods for these.
        off = times[first + count] - times[first]
        periods = round(float(np.median(off[-LEAST_REPEATS * count :])) * frequency)
        differs = (np.abs(off - periods / frequency) > np.maximum(same[first], same[first + count])) | (
            walls[first + count] != walls[first]
        )
        start = int(first[np.flatnonzero(differs)[-1]]) + 1 if differs.any() else 0
        if periods < 1 or int(np.sum(first >= start)) < LEAST_REPEATS * count:
            continue
        # Chaotic motion comes near periodic ones and stays for some periods, but these are unstable.
        decay = -float(rates[of_rates >= start].mean())
        if not decay > 0:
            continue
        start += _dying(decay, count, len(times) - start)
        return _steady(fitted, lost, (start, count, periods))
    return None


def _dying(decay: float, count: int, impacts: int) -> int:
    """Impacts to leave out until a transient no longer shows in the mean of those that follow.

    A deviation that changes by `SAME` timing errors in a period is up to 1/(1 - rho) times as large as its change,
    where rho is the share of it that is left after a period of `count` impacts, and decays within 1/decay impacts.
    Where it decays so slowly that little would be left, half of the impacts are kept, and have to be steady.
    """
    largest = SAME / -np.expm1(-decay * count) / decay
    wanted = int(np.ceil(max(np.log(largest / (HIDDEN * np.sqrt(impacts))), 0.0) / decay))
    return min(wanted, impacts // 2)


def _steady(fitted: Fitted, lost: Indices, tail: tuple[int, int, int]) -> _Repeating | None:
    """The steady part of impacts that repeat themselves: without those in which a transient still shows.

    Parameters
    ----------
    fitted : Fitted
    lost : Indices (n,)
        Number of unknown flights before each impact.
    tail : tuple of int
        The first impact, and impacts and forcing periods after which it repeats.

    Returns
    -------
    _Repeating or None
        None where too little is left.
    """
    start, count, periods = tail
    impacts = fitted.kept
    times, walls = impacts.times, impacts.walls.astype(int)
    errors = fitted.adjusted.timing_error_s * impacts.errors
    period = periods / float(fitted.adjusted.model.device.frequency_hz)
    # Each impact is assigned to the one of the first whole period with its phase, so that missed ones do no harm.
    whole = next(k for k in range(start, len(times) - count) if lost[k + count] == lost[k])
    letters = Word(tuple(walls[whole : whole + count].tolist()), periods)
    canonical = letters.canonical()
    turned = letters.firsts(canonical)[0]
    begun = times[whole : whole + count]
    # A quarter is cut off at a time until both halves have the same means: a transient makes them differ.
    while True:
        rows = np.arange(start, len(times))
        apart = (times[rows, None] - begun + period / 2) % period - period / 2
        apart[walls[rows, None] != walls[whole : whole + count]] = np.inf
        places = np.argmin(np.abs(apart), axis=1)
        off = apart[np.arange(len(rows)), places]
        if len(rows) < LEAST_REPEATS * count:
            return None
        middle = (times[start] + times[-1]) / 2
        early, late = times[rows] < middle, times[rows] >= middle
        halves = [(early & (places == k), late & (places == k)) for k in range(count)]
        if any(not half.any() for pair in halves for half in pair):
            return None
        apart_by = [abs(off[a].mean() - off[b].mean()) for a, b in halves]
        spread = [np.hypot(*(np.linalg.norm(errors[rows[half]]) / half.sum() for half in pair)) for pair in halves]
        rounding = np.spacing(times[-1]) * 8
        if all(difference <= STEADY * error + rounding for difference, error in zip(apart_by, spread, strict=True)):
            return _Repeating(canonical, rows, (places - turned) % count)
        start += max(len(rows) // 4, 1)


def _mean(
    adjustment: Adjusted, repeating: _Repeating, impacts: MeasuredImpacts, cycle: tuple[Array, Array, Array]
) -> MeasuredMotion:
    """The mean of each impact of a motion, with the covariance of all."""
    values, by_time, by_unknown = cycle
    count, n, p = len(repeating.word), len(impacts), len(adjustment.unknowns)
    turn, shape = 2 * pi, (len(Quantity), count)
    means = np.empty(shape)
    of_times, of_unknowns = np.zeros((*shape, n)), np.zeros((*shape, p))
    for place in range(count):
        rows = repeating.rows[repeating.places == place]
        for quantity in Quantity:
            chosen = rows[np.isfinite(values[quantity, rows])]
            seen = values[quantity, chosen]
            if quantity is Quantity.PHASE:  # the same impact has the same phase but for whole turns
                seen = seen[0] + (seen - seen[0] + pi) % turn - pi
            means[quantity, place] = seen.mean()
            for offset in range(3):
                near = chosen + offset - 1
                inside = (near >= 0) & (near < n)
                share = by_time[quantity, chosen, offset][inside] / len(chosen)
                np.add.at(of_times[quantity, place], near[inside], share)
            of_unknowns[quantity, place] = by_unknown[quantity, chosen].mean(axis=0)
    # The restitutions, as far as they were fitted.
    bottom, top = (adjustment.model.value_of(x) for x in RESTITUTIONS[1:])
    chosen_unknowns = np.zeros((2, p))
    for k, x in enumerate(adjustment.unknowns):
        chosen_unknowns[0, k] = x in (RESTITUTIONS[0], RESTITUTIONS[1])
        chosen_unknowns[1, k] = x in (RESTITUTIONS[0], RESTITUTIONS[2])
    flat_times = np.vstack([of_times.reshape(-1, n), np.zeros((2, n))])
    flat_unknowns = np.vstack([of_unknowns.reshape(-1, p), chosen_unknowns])
    covariance = _covariance(adjustment, flat_times, flat_unknowns)
    means[Quantity.PHASE] %= turn
    from_s = float(impacts.times[repeating.rows[0]])
    return MeasuredMotion(repeating.word, from_s, len(repeating.rows), means, np.array([bottom, top]), covariance)


def _covariance(adjustment: Adjusted, of_times: Array, of_unknowns: Array) -> Array:
    """Covariance (k, k) of quantities, by derivatives by errors of times (k, n) and by fitted unknowns (k, p)."""
    square = adjustment.timing_error_s**2
    if square == 0:
        return np.zeros((len(of_times), len(of_times)))
    # Fitted unknowns move by -inverse design' (L^-1 B e), with e the errors of the times and of each prior.
    gain = (adjustment.covariance / square / adjustment.scales) @ adjustment.scaled_design.T
    m = len(adjustment.equations.impacts)
    on_equations = adjustment.weights.returned(np.ascontiguousarray(gain[:, :m].T))
    moved = np.zeros((of_times.shape[1], gain.shape[0]))
    around = adjustment.equations.impacts[:, None] + np.arange(-1, 2)
    np.add.at(moved, around, -adjustment.equations.by_error[:, :, None] * on_equations[:, None, :])
    # A time affects a quantity directly, and through the unknowns that are fitted to the times.
    whole = of_times + of_unknowns @ moved.T
    priors = of_unknowns @ gain[:, m:]
    return np.asarray(square * (whole @ whole.T + priors @ priors.T))
