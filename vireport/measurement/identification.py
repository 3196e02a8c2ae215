"""Identification of a device from measured impacts: the most likely inputs with covariance, or why there are none.

A strictly periodic record holds few numbers, however long it is: for 1:1 motion one if its clock has no reference to
the force, two if it has. What a record leaves open is found from the information that the fitted motion, free of noise,
has on the unknowns.
"""

from __future__ import annotations

from enum import Enum, auto
from math import log, pi

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import NumericalError
from vireport.base.progress import Progress, counted
from vireport.measurement.adjustment import LEAST_SHARE, Adjusted, Inquiry, adjusted
from vireport.measurement.flights import (
    RESTITUTIONS,
    Array,
    ClockedDevice,
    Indices,
    MeasuredImpacts,
    Unknown,
    dimensionless,
    equations,
    velocities,
)
from vireport.measurement.screening import MANY, Gap, Screened, screened, typical, whole, without_flights
from vireport.measurement.start import same_start, starts
from vireport.physics.numbers import ARRAYS
from vireport.scenario.parameters import Parameter

ROUNDS = 5
"""Of screening and fitting, after which they agree or do not."""

LEAST_EQUATIONS = 8
"""More than there are unknowns, for a standard error to mean something."""

WIDEST = 0.05
"""Standard error of a combination over its scale beyond which errors do not spread linearly."""

LARGEST_TIMING_ERROR = 0.005
"""In periods of the force, beyond which impacts do not follow the model: errors have been tried up to 0.001."""

AS_GOOD = 1.5
"""Ratio of timing errors up to which two fits explain a record as well."""

MOST_GAPS = 0.06
"""Share of flights that no single missed impact explains beyond which the model does not fit."""

EXACT = 1e-9
"""Timing error in periods of the force below which times are exact, and what is left is rounding."""

MOST_THROUGH = 0.02
"""Share of flights through a membrane up to which these are impacts that were missed, and the model may fit."""

LARGEST_INNOVATION = 5.0
"""Standard deviations; of a million normal errors half a one is beyond."""

GLANCE = 1000
"""Impacts that a model is looked for in where only a good fit is of interest."""

SAMPLES = 24
"""Parts of a flight at whose ends the ball must be between the membranes."""

LONGEST_PATTERN = 24
"""Impacts of a motion that is looked for as one that repeats itself."""

MOST_GROWN = log(1e4)
"""Logarithm of the growth of a deviation up to which a motion may happen to stay near one that repeats itself: chaos
that hardly is one does so for hundreds of impacts."""


class Unfit(Enum):
    """Why no motion of the device fits a record."""

    NO_MOTION = auto()
    SCATTER = auto()
    GAPS = auto()
    RESTITUTION = auto()
    PATH = auto()


class NoFit(Struct, frozen=True):
    """Why a record was not explained, with the number that shows it: a time [s], a share or a restitution."""

    failure: Unfit
    value: float


class Open(Struct, frozen=True):
    """Why a record does not determine the unknowns.

    Attributes
    ----------
    combination : tuple of (Unknown, float)
        Changes of unknowns, in their units, that together leave all impact times unchanged; empty where there are
        several separate answers, or too few impacts.
    answers : tuple of tuple of (Unknown, float)
        Separate values of the unknowns that explain the record equally well.
    impacts : int
        Number of impacts that are needed; 0 where more of the same motion do not help.
    unstable : bool
        Whether all fits are unstable motions, which do not last.
    failed : NoFit or None
        Why no fit was found, where the search rather than the model may have failed.
    """

    combination: tuple[tuple[Unknown, float], ...] = ()
    answers: tuple[tuple[tuple[Unknown, float], ...], ...] = ()
    impacts: int = 0
    unstable: bool = False
    failed: NoFit | None = None


class Unidentifiable(NumericalError):
    """A record that does not determine the unknowns that are to be identified."""

    def __init__(self, left_open: Open) -> None:
        super().__init__("the record does not hold what is asked for")
        self.left_open = left_open


class Fitted(Struct, frozen=True, eq=False):
    """A record explained by a device.

    Attributes
    ----------
    adjusted : Adjusted
    screened : Screened
    impacts : MeasuredImpacts
        All of the record, as measured.
    """

    adjusted: Adjusted
    screened: Screened
    impacts: MeasuredImpacts

    @property
    def kept(self) -> MeasuredImpacts:
        """The rows that are impacts, with the flights that are used."""
        return self.impacts.rows(self.screened.kept, self.screened.flown)

    @property
    def explained(self) -> MeasuredImpacts:
        """The impacts at the times at which the fitted device has them."""
        kept = self.kept
        return kept.at(kept.times - self.adjusted.errors)

    @property
    def false(self) -> tuple[float, ...]:
        """Times of rows that are no impacts [s]."""
        return tuple(map(float, np.delete(self.impacts.times, self.screened.kept)))

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Gaps of the record in which impacts were missed."""
        return self.screened.gaps

    @property
    def lost(self) -> int:
        """Flights that no single missed impact explains."""
        return sum(gap.missed_s is None for gap in self.gaps)


def fit(
    inquiry: Inquiry, impacts: MeasuredImpacts, say: Progress = lambda what: None, within_s: float = np.inf
) -> Fitted | NoFit:
    """Fit a device to a record of impacts: the most likely unknowns, and which rows are no impacts or were missed.

    Parameters
    ----------
    inquiry : Inquiry
    impacts : MeasuredImpacts
        As measured, with no row left out. The first guess, which gives outliers little weight, ignores their standard
        errors.
    say : callable
        Called with each step as it begins.
    within_s : float
        Timing error beyond which a fit is of no interest [s].

    Raises
    ------
    Unidentifiable
        If the record leaves some of the unknowns open.
    """
    unknowns = inquiry.unknowns
    if len(impacts) < (needed := len(unknowns) + LEAST_EQUATIONS + 2):
        raise Unidentifiable(Open(impacts=needed))
    say("finding the force's phase" if Unknown.PHASE in unknowns else "finding the restitutions")
    # Whether another model fits within an error shows in the first impacts.
    first = len(impacts) if np.isinf(within_s) else GLANCE
    alike = replace(impacts, relative=None)
    begun = starts(inquiry, alike.first(first))
    tried: list[Fitted | NoFit] = []
    for k, start in enumerate(begun):
        say(counted("fitting the impacts", k + 1, len(begun)))
        tried.append(_settled(inquiry.begun_with(start), impacts, within_s))
    fits = [fitted for fitted in tried if isinstance(fitted, Fitted)]
    if Unknown.PHASE in unknowns and (doubted := [fitted for fitted in fits if fitted.gaps or fitted.false]):
        # Missed impacts may hide another answer, or the only one, from the search: it is repeated without them.
        clean = min(doubted, key=lambda fitted: fitted.lost).screened
        more = starts(inquiry, alike.rows(clean.kept, clean.flown).first(first))
        more = [start for start in more if not any(same_start(start, other, unknowns) for other in begun)]
        tried += [_settled(inquiry.begun_with(start), impacts, within_s) for start in more]
        fits = [fitted for fitted in tried if isinstance(fitted, Fitted)]
    if not fits:
        failures = (fitted for fitted in tried if isinstance(fitted, NoFit))
        return min(failures, key=lambda failed: failed.value if failed.failure is Unfit.SCATTER else np.inf)
    return _only(fits, unknowns)


def exact_below(model: ClockedDevice) -> float:
    """Timing error below which times are exact [s], see `EXACT`."""
    return EXACT / model.device.frequency_hz


def _settled(inquiry: Inquiry, impacts: MeasuredImpacts, within_s: float) -> Fitted | NoFit:
    """Screen a record and fit it in turn until neither changes the other, or say why no fit stands.

    Parameters
    ----------
    inquiry : Inquiry
        With the model to start from.
    impacts : MeasuredImpacts
    within_s : float
        Timing error beyond which a fit is of no interest [s].
    """
    model, times = inquiry.model, impacts.times
    period = 1 / model.device.frequency_hz
    error = typical(equations(model, impacts), MANY)
    if error > min(LARGEST_TIMING_ERROR * period, 3 * within_s):
        return NoFit(Unfit.SCATTER, error)
    previous = whole(len(times))
    through = doubted = np.empty(0, dtype=np.intp)  # rows with which flights begin that are not used
    adjustment: Adjusted | None = None
    for _ in range(ROUNDS):
        # Exact times fail by rounding, which is not the same for all equations.
        now = screened(model, impacts, max(error, exact_below(model)))
        if len(flights := np.flatnonzero(now.flown & np.isin(now.kept[:-1], doubted))):
            now = without_flights(now, times, flights)
        if adjustment is not None and now.same_as(previous) and adjustment.settled:
            break
        previous = now
        # An equation needs the flights on both sides of its impact.
        count = int(np.sum(previous.flown[:-1] & previous.flown[1:]))
        if count < len(inquiry.unknowns) + LEAST_EQUATIONS:
            return NoFit(Unfit.GAPS, 1 - count / (len(times) - 2))
        kept = impacts.rows(previous.kept, previous.flown)
        try:
            adjustment = adjusted(inquiry.begun_with(model), kept)
        except NumericalError:
            return NoFit(Unfit.NO_MOTION, error)
        model = adjustment.model
        # False or missed impacts that are not recognised yet enlarge the error of the fit, in which they would hide.
        error = min(adjustment.timing_error_s, 2 * typical(equations(model, kept), MANY))
        if error > LARGEST_TIMING_ERROR * period:
            return NoFit(Unfit.SCATTER, error)
        # An impact so slow that its loss is within the noise leaves a flight through a membrane.
        through = np.union1d(through, previous.kept[_through(Fitted(adjustment, previous, impacts))]).astype(np.intp)
        if len(through) > MOST_THROUGH * len(times):
            return NoFit(Unfit.PATH, float(times[through[0]]))
        doubted = np.union1d(np.union1d(doubted, through), previous.kept[_beyond_noise(adjustment)]).astype(np.intp)
    if adjustment is None or not adjustment.settled:
        return NoFit(Unfit.NO_MOTION, error)
    fitted = Fitted(adjustment, previous, impacts)
    if (unexplained := fitted.lost / (len(times) - 1)) > MOST_GAPS:
        return NoFit(Unfit.GAPS, unexplained)
    return _impossible(adjustment) or fitted


def _impossible(adjustment: Adjusted) -> NoFit | None:
    """Why a fit with a restitution surely below 0 or above 1 is refused; None for any other fit."""
    for x in adjustment.unknowns:
        if x in RESTITUTIONS:
            value, margin = adjustment.model.value_of(x), 5 * adjustment.deviation_of(x)
            if value < -margin or value > 1 + margin:
                return NoFit(Unfit.RESTITUTION, value)
    return None


def _beyond_noise(adjustment: Adjusted) -> Indices:
    """Flights on both sides of impacts whose equations fail by more than errors of the times explain.

    Where several impacts together were missed or false, screening may let one of them pass, which would outweigh
    hundreds of good ones.
    """
    size = np.abs(adjustment.innovations[: len(adjustment.equations.impacts)])
    most = LARGEST_INNOVATION * max(1.4826 * float(np.median(size)), exact_below(adjustment.model))
    outliers = adjustment.equations.impacts[size > most]
    return np.union1d(outliers - 1, outliers).astype(np.intp)


def _through(fitted: Fitted) -> Indices:
    """Flights of a fit in which the ball is beyond a membrane, which is impossible."""
    adjustment, explained = fitted.adjusted, fitted.explained
    times, walls = explained.times, explained.walls
    device = adjustment.model.device
    groups = device.groups(Parameter.LENGTH, device.length_m)
    flown = np.flatnonzero(explained.flown)
    start, end = times[flown], times[flown + 1]
    with np.errstate(all="ignore"):  # flights that are not used may be of any length
        after, before = (speeds[flown] for speeds in velocities(adjustment.model, times, walls))
    unit = 2 * device.frequency_hz
    left = dimensionless(adjustment.model, start)
    begun = groups.wave(pi * left + adjustment.model.phase, ARRAYS)
    # A ball that is beyond a membrane for less than the timing error may not be.
    room = float(groups.d) / 2 + 6 * adjustment.timing_error_s * unit * max(np.abs(after).max(), np.abs(before).max())
    beyond = np.zeros(len(flown), dtype=bool)
    for share in np.arange(1, SAMPLES) / SAMPLES:
        t = dimensionless(adjustment.model, start + share * (end - start))
        now = groups.wave(pi * t + adjustment.model.phase, ARRAYS)
        gone, _ = groups.flown(t - left, after, begun, now)
        beyond |= np.abs(walls[flown] * groups.d / 2 + gone) > room * (1 + 1e-9)
    return flown[beyond]


def _only(fits: list[Fitted], unknowns: tuple[Unknown, ...]) -> Fitted:
    """The only fit that explains a record best, among motions that last.

    Of a motion that repeats itself only a stable one lasts.

    Raises
    ------
    Unidentifiable
        If several fits explain it equally well, all are unstable, or the record does not determine the unknowns.
    """
    least = min(fitted.adjusted.timing_error_s for fitted in fits)
    most = max(AS_GOOD * least, exact_below(fits[0].adjusted.model))
    good = [fitted for fitted in fits if fitted.adjusted.timing_error_s <= most]
    good = [fitted for k, fitted in enumerate(good) if not any(_alike(fitted, other) for other in good[:k])]
    lasting = [fitted for fitted in good if not _unstable(fitted)]
    if not lasting:  # the lasting one may have been missed
        for fitted in good:
            _require_information(fitted.adjusted, unknowns)
        raise Unidentifiable(Open(unstable=True))
    # A fit that leaves out more of the record explains less of it.
    fewest = min(fitted.lost for fitted in lasting)
    good = [fitted for fitted in lasting if fitted.lost <= 1.5 * fewest + 3]
    for fitted in good:
        _require_information(fitted.adjusted, unknowns)
    if len(good) > 1:
        raise Unidentifiable(
            Open(answers=tuple(tuple((x, fitted.adjusted.model.value_of(x)) for x in unknowns) for fitted in good))
        )
    return good[0]


def _alike(one: Fitted, other: Fitted) -> bool:
    """Whether two fits are the same but for whole turns of the phase."""
    a, b = one.adjusted, other.adjusted
    turned = np.cos(a.model.phase - b.model.phase) > 1 - 1e-5
    values = ((a.model.value_of(x), b.model.value_of(x), a.deviation_of(x)) for x in a.unknowns if x != Unknown.PHASE)
    return bool(turned) and all(abs(x - y) <= max(deviation, 1e-6 * abs(x)) for x, y, deviation in values)


def _require_information(adjustment: Adjusted, unknowns: tuple[Unknown, ...]) -> None:
    """Refuse a fit in which some combination of the unknowns is not determined by the record.

    Raises
    ------
    Unidentifiable
        With the combination.
    """
    count = len(unknowns)
    scales = adjustment.scales[:count]
    information = adjustment.information[:count, :count] * np.outer(scales, scales)
    values, vectors = np.linalg.eigh(information)
    deviation = adjustment.timing_error_s / np.sqrt(max(float(values[0]), 1e-300))
    if values[0] > LEAST_SHARE**2 * values[-1] and deviation < WIDEST:
        return
    # The eigenvector of the least eigenvalue is the change of unknowns that affects the times least.
    worst = vectors[:, 0] / vectors[np.argmax(np.abs(vectors[:, 0])), 0]
    parts = tuple((x, 0.01 * float(v * s)) for x, v, s in zip(unknowns, worst, scales, strict=True) if abs(v) > 0.02)
    raise Unidentifiable(Open(combination=parts))


def _unstable(fitted: Fitted) -> bool:
    """Whether a record repeats a pattern of impacts, within the timing error, that is unstable for the fitted device.

    It must repeat for so long that a deviation far below the timing error would have grown beyond it.
    """
    kept = fitted.kept
    walls, flown = kept.walls, kept.flown
    flights, together = np.diff(kept.times), np.cumsum(~flown)
    rates = growth_rates(fitted)
    for count in range(1, min(LONGEST_PATTERN, len(flights) - 2) + 1):
        # Only where no flight was lost between the one and the other.
        both = flown[:-count] & (together[count:] == together[:-count])
        off = np.abs(flights[count:] - flights[:-count]) > 10 * fitted.adjusted.timing_error_s
        off |= walls[count:-1] != walls[: -count - 1]
        # Ends of the stretches of flights that repeat those before them.
        ends = np.concatenate([[-1], np.flatnonzero(off | ~both), [len(off)]])
        for start in np.flatnonzero(np.diff(ends) > 2 * count):
            low, high = np.searchsorted(fitted.adjusted.equations.impacts, ends[start : start + 2] + count)
            if rates[low:high].sum() > MOST_GROWN:
                return True
    return False


def growth(fitted: Fitted) -> float:
    """Rate at which small deviations from the fitted motion grow, per impact: negative where it is stable."""
    return float(growth_rates(fitted).mean())


def growth_rates(fitted: Fitted) -> Array:
    """Logarithms of the growth of small deviations from the fitted motion at each of its equations."""
    # Deviations of the times of two impacts determine that of the third, by the linearised equation. In the long run
    # any deviation grows as the fastest one; the initial numbers are no special direction.
    last, current, rates = 0.3, 1.0, []
    for b, c, d in fitted.adjusted.equations.by_time.tolist():
        last, current = current, -(b * last + c * current) / d
        size = abs(last) + abs(current)
        last, current = last / size, current / size
        rates.append(log(size))
    return np.array(rates or [0.0])
