"""Screening of measured impacts: rows that are no impacts, and flights in which impacts were missed.

An impact that was missed makes one flight of two: both equations that need it fail. One that was none makes two flights
of one: three fail. An equation has failed where it is beyond `FAILED` standard deviations of the timing error.
"""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.measurement.flights import Array, ClockedDevice, Equations, Indices, Mask, MeasuredImpacts, equations

FAILED = 6.0
MOST, MANY = 0.8, 0.6
"""Shares of the equations that agree in a fit, and that must agree for it to be looked at further."""

SHORTEST = 10.0
"""Timing errors between two impacts up to which nothing can be said of the flight."""

PLACES = 100
"""Times within a flight at which a missed impact is tried, before the best is refined."""


class Gap(Struct, frozen=True):
    """A stretch of a record whose flights are not used.

    Attributes
    ----------
    start_s, end_s : float
        Times of the impacts at its ends [s].
    missed_s : float or None
        Time of the one missed impact that explains it; None where none does.
    """

    start_s: float
    end_s: float
    missed_s: float | None


class Screened(Struct, frozen=True, eq=False):
    """The result of screening a record: rows that are impacts, and flights between them that are single ones.

    Attributes
    ----------
    kept : Indices (n,)
        Rows of the record that are impacts.
    flown : Mask (n - 1,)
        Whether there was no other impact between one of these and the next.
    gaps : tuple of Gap
    """

    kept: Indices
    flown: Mask
    gaps: tuple[Gap, ...]

    def same_as(self, other: Screened) -> bool:
        """Whether both keep the same impacts and the same flights of a record."""
        return np.array_equal(self.kept, other.kept) and np.array_equal(self.flown, other.flown)


def whole(count: int) -> Screened:
    """The screening of a record of so many impacts of which nothing is doubted."""
    return Screened(np.arange(count), np.ones(count - 1, dtype=bool), ())


def typical(system: Equations, share: float = MOST) -> float:
    """Timing error that most equations of a record agree on [s]: robust, from a quantile of their residuals.

    A smaller share than usual would not do for a fit: of the four equations of a 3:1 motion three can always hold.
    """
    size = np.abs(system.value) / system.spread
    if not len(size):
        return np.inf
    k = min(int(share * len(size)), len(size) - 1)
    return float(np.partition(size, k)[k]) / NormalDist().inv_cdf((1 + share) / 2)


def screened(model: ClockedDevice, impacts: MeasuredImpacts, timing_error_s: float) -> Screened:
    """Find impacts that were missed and rows that are none, of a record with a timing error [s]."""
    kept = _without_false(model, impacts, timing_error_s)
    left = impacts.rows(kept)
    t, flown = left.times, left.flown.copy()
    system = equations(model, left)
    stretches = []
    # A missed impact spoils the equations at both its ends: runs of two, and of more where misses are neighbours.
    for run in _runs(system.impacts[np.abs(system.value) > FAILED * timing_error_s * system.spread]):
        every = np.arange(run[0], run[-1])
        if len(run) == 1:  # at an end of the record, or next to what is hardly beyond the noise: one of its flights
            every = np.array([run[0] if run[0] + 2 >= len(t) else run[0] - 1])
        flown[every[::2]] = False
        stretches.append((every, len(run) % 2 == 1 and len(run) > 1))
    doubted = [k for every, _ in stretches for k in every[::2]]
    missed = _missed(model, replace(left, flown=flown), doubted, timing_error_s)
    gaps: list[Gap] = []
    for every, odd in stretches:
        single = every[::2]
        if odd or any(missed[k] is None for k in single):
            # Not one missed impact in every other flight: nothing is known of any of them.
            flown[every] = False
            gaps += [Gap(float(t[k]), float(t[k + 1]), None) for k in every]
        else:
            gaps += [Gap(float(t[k]), float(t[k + 1]), missed[k]) for k in single]
    result = Screened(kept, flown, tuple(gaps))
    # Of two rows at one time, one is none: the flight between them has any velocity, and keeps to any equation.
    close = np.flatnonzero(np.diff(t) < SHORTEST * timing_error_s * np.maximum(left.errors[1:], left.errors[:-1]))
    around = np.unique(np.clip(close[:, None] + np.arange(-1, 2), 0, len(flown) - 1))
    around = around[flown[around]]
    return without_flights(result, impacts.times, around) if len(around) else result


def without_flights(screening: Screened, times: Array, flights: Indices) -> Screened:
    """A screening without some more flights, by their first impacts; of `times` [s] of all rows."""
    flown = screening.flown.copy()
    flown[flights] = False
    kept_times = times[screening.kept]
    more = tuple(Gap(float(kept_times[k]), float(kept_times[k + 1]), None) for k in flights)
    return Screened(screening.kept, flown, (*screening.gaps, *more))


def _runs(failed: Indices) -> list[Indices]:
    """Runs of consecutive impacts among those whose equations have failed."""
    return [run for run in np.split(failed, np.flatnonzero(np.diff(failed) > 1) + 1) if len(run)]


def _without_false(model: ClockedDevice, impacts: MeasuredImpacts, timing_error_s: float) -> Indices:
    """Rows that are left where each that explains all failures around it, as one that is no impact, is taken away."""
    count = len(impacts)
    system = equations(model, impacts)
    failed = system.impacts[np.abs(system.value) > FAILED * timing_error_s * system.spread]
    taken = []
    for run in _runs(failed):
        best = FAILED
        row = -1
        for k in range(max(run[0] - 1, 1), min(run[-1] + 2, count - 1)):
            near = np.array([i for i in range(run[0] - 3, run[-1] + 4) if 0 <= i < count and i != k])
            # What is next to the end of a record can be taken away without a trace: it is no evidence.
            if near.searchsorted(k) < 2 or len(near) - near.searchsorted(k) < 2:
                continue
            rest = equations(model, impacts.rows(near))
            around = (near[rest.impacts] >= run[0] - 1) & (near[rest.impacts] <= run[-1] + 1)
            worst = float((np.abs(rest.value) / rest.spread)[around].max()) / timing_error_s
            if worst < best:
                best, row = worst, k
        if row >= 0:
            taken.append(row)
    return np.setdiff1d(np.arange(count), np.array(taken, dtype=int))


def _missed(
    model: ClockedDevice, impacts: MeasuredImpacts, flights: list[int], timing_error_s: float
) -> dict[int, float | None]:
    """Time [s] of the one missed impact, on either membrane, that explains both ends of each of some flights."""
    missing: dict[int, float | None] = dict.fromkeys(flights)
    alike: dict[tuple[int, int], list[int]] = {}
    times, flown = impacts.times, impacts.flown
    for k in flights:
        low, high = max(k - 1, 0), min(k + 2, len(times) - 1)
        if (low < k and not flown[low]) or (high > k + 1 and not flown[k + 1]) or high - low < 2:
            continue
        alike.setdefault((k - low, high - k), []).append(k)
    for (before, after), some in alike.items():
        ks = np.array(some)
        around = ks[:, None] + np.arange(-before, after + 1)
        best, at = np.full(len(ks), FAILED), np.full(len(ks), np.nan)
        for wall in (1.0, -1.0):
            a, b = times[ks], times[ks + 1]
            # Each round looks between the neighbours of the best time: four leave 1e-7 of the flight.
            for _ in range(4):
                tried = a[:, None] + (b - a)[:, None] * np.linspace(0, 1, PLACES + 2)[1:-1]
                worst = _misfit(model, impacts, around, (before + 1, wall), tried) / timing_error_s
                i, row = np.argmin(worst, axis=1), np.arange(len(ks))
                a, b = tried[row, np.maximum(i - 1, 0)], tried[row, np.minimum(i + 1, PLACES - 1)]
            better = worst[row, i] < best
            best, at = np.where(better, worst[row, i], best), np.where(better, tried[row, i], at)
        missing |= {k: float(t) for k, t in zip(some, at, strict=True) if np.isfinite(t)}
    return missing


def _misfit(
    model: ClockedDevice, impacts: MeasuredImpacts, around: Indices, missed: tuple[int, float], tried: Array
) -> Array:
    """Timing error with which the equations around flights hold if an impact is put into them: (g, t) [s].

    Parameters
    ----------
    model : ClockedDevice
    impacts : MeasuredImpacts
    around : Indices (g, n)
        Rows of the impacts around each flight.
    missed : int, float
        Place of the impact among them, and its membrane. Its error is as of most.
    tried : Array (g, t)
        Its times [s].
    """
    # A small record for each time tried, one after the other, with nothing between them.
    place, wall = missed
    count, width = tried.size, around.shape[1] + 1
    rows, sides, relative = (
        np.repeat(np.insert(x[around], place, inserted, axis=1), tried.shape[1], axis=0)
        for x, inserted in ((impacts.times, 0.0), (impacts.walls, wall), (impacts.errors, 1.0))
    )
    rows[:, place] = tried.ravel()
    within = np.tile(np.arange(width) < width - 1, count)[:-1]
    with np.errstate(all="ignore"):  # between two small records there may be no time
        system = equations(model, MeasuredImpacts(rows.ravel(), sides.ravel(), within, relative.ravel()))
    worst = np.zeros(count)
    np.maximum.at(worst, system.impacts // width, np.abs(system.value) / system.spread)
    return worst.reshape(tried.shape)
