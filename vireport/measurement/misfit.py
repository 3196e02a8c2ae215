"""Tests of whether a model fits a record, against named alternatives, and what a record cannot test.

The errors of the times are known only from the record itself, so that their size is no test. The tests are that they
are independent of one another, and uncorrelated with the effect of any wrong input. Every alternative has one parameter
more. By how much it reduces the sum of squares, over what is left, has an F distribution if the model is true.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.progress import Progress, WorkStep
from vireport.measurement.adjustment import LEAST_SHARE, Adjusted, Inquiry
from vireport.measurement.flights import RESTITUTIONS, Array, ClockedDevice, MeasuredImpacts, Unknown, equations
from vireport.measurement.identification import (
    AS_GOOD,
    Fitted,
    NoFit,
    Open,
    Unfit,
    Unidentifiable,
    exact_below,
    fit,
)
from vireport.physics.forcing import Harmonic
from vireport.scenario.parameters import Parameter

LEVEL = 0.01
"""Probability at which a true model is rejected, by any of the tests."""

LAGS = 4
"""Impacts over which errors are held against one another."""

ABOUT = 1.05
"""Ratio of timing errors up to which two alternatives explain as much."""

LEAST_CORRELATION = 0.04
"""Correlation of errors with those of neighbouring impacts up to which standard errors are right to some per cent: that
the equations are not linear makes smaller ones, which a record of 100,000 impacts would show."""

SURELY = 3.0
"""Standard errors beyond which a value has a sign."""

FEWER = 0.5
"""Ratio of timing errors below which another model explains what the scenario's does not."""

FLIGHTS_EXPLAINED = 2
"""Flights that a fit leaves out and another does not, from which the other is right: of impacts that were missed both
leave out the same."""

ALTERNATIVES = (
    Unknown.EXPONENT,
    Unknown.FREQUENCY,
    Unknown.DRIFT,
    Unknown.LENGTH,
    Unknown.AMPLITUDE,
    Unknown.INCLINATION,
)
"""What may be wrong, the likeliest first."""


MAY_HIDE, HARDLY = (Unknown.LENGTH, Unknown.AMPLITUDE, Unknown.INCLINATION), 0.02
"""Inputs that are measured with a ruler and a scale, and the share of their scale up to which it is not said that one
may be wrong unseen: they are known better, as a rule."""


class BetterFit(Struct, frozen=True):
    """A model that fits a record better than the scenario's.

    Attributes
    ----------
    swapped : bool
        Whether it is the scenario's model with bottom and top exchanged.
    unknown : Unknown or None
        The input that has another value; None for exchanged membranes.
    value, standard_error : float
        Value of that input and its standard error, in its unit, if no other input is wrong.
    timing_error_s : float
        Timing error of the better fit [s].
    others : tuple of Unknown
        Other inputs that would each, alone, fit about as well.
    restitutions : tuple of (Unknown, float)
        The restitutions that were fitted with an exponent, at `speed_m_s`; () for any other unknown.
    speed_m_s : float
        Speed at which the restitutions are stated [m/s].
    clock_off : float
        Relative amount by which the record's clock runs fast, if the frequency is what the scenario says.
    clock_accepted : float
        Largest such amount, of either sign, that the test of the frequency accepts. Both are 0 for other unknowns.
    """

    swapped: bool
    unknown: Unknown | None
    value: float
    standard_error: float
    timing_error_s: float
    others: tuple[Unknown, ...] = ()
    restitutions: tuple[tuple[Unknown, float], ...] = ()
    speed_m_s: float = 0.0
    clock_off: float = 0.0
    clock_accepted: float = 0.0


class Hidden(Struct, frozen=True):
    """An input that may be wrong by much and would hardly show, as fitted unknowns compensate for it.

    Attributes
    ----------
    unknown : Unknown
    off : float
        Largest error of either sign, in its unit, with which no test rejects the model.
    moves : tuple of (Unknown, float)
        Error of each fitted restitution then, with the sign for an input that is too large.
    """

    unknown: Unknown
    off: float
    moves: tuple[tuple[Unknown, float], ...]


class Misfit(Struct, frozen=True):
    """The verdict on whether a model fits a record, and what the record cannot tell.

    Attributes
    ----------
    statistic : float or None
        Statistic of the test with the smallest probability: F of an alternative, or the Ljung-Box statistic.
    p_value : float or None
        That probability times the number of tests. Both are None where nothing was left to test.
    accepted : bool
        Whether no test rejects the model.
    alternative : Unknown or None
        The alternative of that test; None for the test of correlation between errors of neighbouring impacts.
    failure : NoFit or None
        Why there was no fit to test.
    explanation : BetterFit or None
        A model that fits instead, if there is one.
    untested : tuple of Unknown
        Inputs that might be wrong and would not show in this record.
    swapped_untested : bool
        Whether exchanged membranes would not show.
    distortion_untested : bool
        Whether a second harmonic of the force that the scenario does not say would not show.
    hidden : tuple of Hidden
        Inputs that may be wrong by much and would hardly show.
    by_flights : int
        Number of flights that were left out and that `explanation` explains, if these reject the model; else 0.
    """

    statistic: float | None
    p_value: float | None
    accepted: bool
    alternative: Unknown | None = None
    failure: NoFit | None = None
    explanation: BetterFit | None = None
    untested: tuple[Unknown, ...] = ()
    swapped_untested: bool = False
    distortion_untested: bool = False
    hidden: tuple[Hidden, ...] = ()
    by_flights: int = 0


def judged(
    fitted: Fitted | NoFit, inquiry: Inquiry, impacts: MeasuredImpacts, say: Progress = lambda what: None
) -> Misfit:
    """Test a fit of a record, and look for a better model where it fails.

    Parameters
    ----------
    fitted : Fitted or NoFit
        As `fit` returned it.
    inquiry, impacts, say
        As of `fit`.

    Raises
    ------
    Unidentifiable
        If the search may have failed rather than the model.
    """
    say(WorkStep("testing the model", 0.0))
    if isinstance(fitted, NoFit):
        instead = _explanation(np.inf, inquiry, impacts, ALTERNATIVES)
        searched = fitted.failure in (Unfit.NO_MOTION, Unfit.GAPS) or Unknown.PHASE in inquiry.unknowns
        if instead is None and searched:
            raise Unidentifiable(Open(failed=fitted))  # it may be the search that failed, and not the model
        return Misfit(None, None, False, failure=fitted, explanation=instead)
    said, likely = tested(fitted, {*inquiry.fitted})
    error = fitted.adjusted.timing_error_s
    if said.accepted:
        instead = _of_flights_left_out(fitted, inquiry, impacts) if fitted.lost >= FLIGHTS_EXPLAINED else None
        if instead is not None:
            flights = fitted.lost
            return replace(said, accepted=False, alternative=instead.unknown, explanation=instead, by_flights=flights)
        unseen = _exchanged(inquiry, impacts, max(AS_GOOD * error, exact_below(inquiry.model))) is not None
        return replace(said, swapped_untested=unseen)
    return replace(said, explanation=_explanation(error, inquiry, impacts, likely))


def tested(fitted: Fitted, fitted_unknowns: set[Unknown]) -> tuple[Misfit, tuple[Unknown, ...]]:
    """Test a fit against the alternatives that were not fitted; the verdict, and the alternatives that are likely."""
    tests, untested, hidden = _tests(fitted, fitted_unknowns)
    unseen = _hides_distortion(fitted)
    if not tests:
        return Misfit(None, None, True, untested=untested, distortion_untested=unseen), ()
    # The smallest probability counts as often as there are tests (Bonferroni), so that the level holds for all.
    tests = sorted(tests, key=lambda test: test[0])
    p, statistic, alternative = tests[0]
    p = min(1.0, p * len(tests))
    if p >= LEVEL:
        return Misfit(statistic, p, True, untested=untested, distortion_untested=unseen, hidden=hidden), ()
    likely = tuple(x for entry, _, x in tests if x and entry * len(tests) < LEVEL)
    return Misfit(statistic, p, False, alternative, untested=untested), likely


def _tests(
    fitted: Fitted, fitted_unknowns: set[Unknown]
) -> tuple[list[tuple[float, float, Unknown | None]], tuple[Unknown, ...], tuple[Hidden, ...]]:
    """Test a fit against all alternatives that were not fitted themselves.

    Each tests that one further unknown changes nothing (an F test of a regression with one column more, which is
    orthogonal to what was fitted); the last one that errors of neighbouring impacts are not correlated (Ljung and Box).

    Returns
    -------
    tests : list of (float, float, Unknown or None)
        Probability, statistic and alternative.
    untested : tuple of Unknown
        Alternatives that change nothing in this record.
    hidden : tuple of Hidden
        Alternatives that change little.
    """
    from scipy.special import chdtrc, fdtrc  # type: ignore[import-untyped]

    adjustment, explained = fitted.adjusted, fitted.explained
    model = replace(adjustment.model, speed=float(np.median(np.abs(adjustment.equations.before))))
    possible = tuple(x for x in ALTERNATIVES if x not in fitted_unknowns)
    columns = equations(model, explained, possible).by_unknown
    scales = np.array([model.scale_of(x, explained.span_s) for x in possible])
    white = np.zeros((len(adjustment.innovations), len(possible)))
    white[: len(columns)] = adjustment.weights.whitened(columns * scales)
    rest = _beyond_fitted(adjustment, white)
    size, rest_size = np.linalg.norm(white, axis=0), np.linalg.norm(rest, axis=0)
    distinguishable = rest_size > LEAST_SHARE * np.maximum(size, 1e-300)
    untested = tuple(x for x, tells in zip(possible, distinguishable, strict=True) if not tells)
    if adjustment.timing_error_s < exact_below(model):
        return [], untested, ()
    # What an alternative takes from the sum of squares is the squared projection on its column beyond what was fitted.
    square = adjustment.cost
    tests: list[tuple[float, float, Unknown | None]] = []
    hidden: list[Hidden] = []
    for x, column, length, scale, change in zip(possible, rest.T, rest_size, scales, white.T, strict=True):
        if x in untested:
            continue
        off = _accepted_up_to(adjustment.freedom) * adjustment.timing_error_s / length
        if x in MAY_HIDE and off > HARDLY:
            # The error of an input is at most its whole value, or 90 degrees.
            off = min(off, 90.0 / scale if x is Unknown.INCLINATION else 1.0)
            hidden.append(Hidden(x, float(off * scale), _made_up_for(adjustment, off * change)))
        less = float(column @ adjustment.innovations / length) ** 2
        freedom = adjustment.freedom - 1
        f = less / max((square - less) / freedom, 1e-300)
        tests.append((float(fdtrc(1, freedom, f)), f, x))
    left = adjustment.innovations[: len(columns)]
    count = len(left)
    correlated = [float(left[k:] @ left[:-k]) / float(left @ left) for k in range(1, LAGS + 1)]
    q = count * (count + 2) * sum(r * r / (count - k) for k, r in enumerate(correlated, 1))
    if max(map(abs, correlated)) > LEAST_CORRELATION:
        tests.append((float(chdtrc(LAGS, q)), q, None))
    return tests, untested, tuple(hidden)


def _made_up_for(adjustment: Adjusted, change: Array) -> tuple[tuple[Unknown, float], ...]:
    """Changes of the fitted restitutions that compensate for a change of the whitened residuals."""
    moved = -adjustment.scales * np.linalg.lstsq(adjustment.scaled_design, change, rcond=None)[0]
    return tuple((x, float(by)) for x, by in zip(adjustment.unknowns, moved, strict=True) if x in RESTITUTIONS)


def _accepted_up_to(freedom: int) -> float:
    """Number of standard errors by which an input may be off without its test rejecting the model."""
    from scipy.special import fdtri

    # The level is shared by as many tests as there can be.
    return float(np.sqrt(fdtri(1, freedom, 1 - LEVEL / (len(ALTERNATIVES) + 1))))


def _beyond_fitted(adjustment: Adjusted, white: Array) -> Array:
    """The part of whitened columns (m, k) that is orthogonal to all changes of fitted unknowns."""
    basis = (
        np.linalg.qr(adjustment.scaled_design)[0] if adjustment.scaled_design.shape[1] else np.zeros((len(white), 0))
    )
    # Twice, as columns that are nearly within what was fitted lose their digits the first time.
    rest = white - basis @ (basis.T @ white)
    return np.asarray(rest - basis @ (basis.T @ rest))


def _hides_distortion(fitted: Fitted) -> bool:
    """Whether the effect of some second harmonic of the force could be compensated by the fitted unknowns."""
    adjustment, explained = fitted.adjusted, fitted.explained
    device, base = adjustment.model.device, equations(adjustment.model, explained).value
    white = np.zeros((len(adjustment.innovations), 2))
    for k, (cosine, sine) in enumerate(((1.0, 0.0), (0.0, 1.0))):
        harmonics = (*device.harmonics, Harmonic(2, cosine, sine))
        # Flights, and with them the equations, are linear in the force.
        more = equations(replace(adjustment.model, device=replace(device, harmonics=harmonics)), explained).value - base
        white[: len(base), k] = adjustment.weights.whitened(more)
    rest = _beyond_fitted(adjustment, white)
    return bool(np.linalg.norm(rest, 2) == 0 or np.linalg.norm(rest, -2) <= LEAST_SHARE * np.linalg.norm(white, 2))


def _exchanged(
    inquiry: Inquiry, impacts: MeasuredImpacts, within_s: float, explaining: bool = False
) -> BetterFit | None:
    """The fit with bottom and top exchanged; None where its timing error would exceed `within_s` [s].

    If it is to be `explaining`, it must leave nothing but noise as well.
    """
    try:
        swapped = fit(inquiry, impacts.exchanged(), within_s=within_s)
    except Unidentifiable:
        return None
    if isinstance(swapped, NoFit) or swapped.adjusted.timing_error_s > within_s:
        return None
    if explaining and not _explains(swapped, None, inquiry):
        return None
    return BetterFit(True, None, 0.0, 0.0, swapped.adjusted.timing_error_s)


def _explanation(
    error: float, inquiry: Inquiry, impacts: MeasuredImpacts, likely: tuple[Unknown, ...]
) -> BetterFit | None:
    """The model that explains a record to its noise: with exchanged membranes, or with another value of an input.

    `error` is the timing error of the scenario's model [s], `likely` are the inputs that are tried.
    """
    exchanged = _exchanged(inquiry, impacts, FEWER * error, True)
    if exchanged is not None:
        return exchanged
    return _best(
        better for better in _explaining(inquiry, impacts, likely) if better[1].adjusted.timing_error_s < error
    )


def _of_flights_left_out(fitted: Fitted, inquiry: Inquiry, impacts: MeasuredImpacts) -> BetterFit | None:
    """The model that explains flights which an accepted fit has left out as if impacts were missing there.

    Without these, only the periodic motion at the end of a record may be left, to which wrong inputs can be fitted.
    """
    most = fitted.lost - FLIGHTS_EXPLAINED
    return _best(other for other in _explaining(inquiry, impacts, ALTERNATIVES) if other[1].lost <= most)


def _explaining(
    inquiry: Inquiry, impacts: MeasuredImpacts, likely: tuple[Unknown, ...]
) -> Iterator[tuple[BetterFit, Fitted]]:
    """The fits with another value of one input each that leave nothing but the noise of the record."""
    model = inquiry.model
    stated = replace(model, speed=float(np.median(np.abs(equations(model, impacts).before))))
    for x in likely:
        if x in inquiry.fitted:
            continue
        try:
            other = fit(Inquiry(stated, (*inquiry.unknowns, x), inquiry.priors), impacts)
        except Unidentifiable:
            continue
        if isinstance(other, Fitted) and _explains(other, x, inquiry):
            adjustment = other.adjusted
            better = BetterFit(
                False, x, adjustment.model.value_of(x), adjustment.deviation_of(x), adjustment.timing_error_s
            )
            if x is Unknown.FREQUENCY:
                better = _of_clock(better, float(model.device.frequency_hz), adjustment.freedom)
            if x is Unknown.EXPONENT:
                better = _stated(better, adjustment.model, inquiry.unknowns)
            yield better, other


def _best(fits: Iterable[tuple[BetterFit, Fitted]]) -> BetterFit | None:
    """The fit that leaves out the fewest flights, of these the one with the least error, and what fits as well."""
    # Flights left out weigh more than the error, which is small if whatever does not fit is left out.
    candidates = list(fits)
    if not candidates:
        return None
    best, fitted = min(candidates, key=lambda pair: (pair[1].lost, pair[0].timing_error_s))
    others = tuple(
        better.unknown
        for better, other in candidates
        if better is not best
        and better.unknown
        and other.lost == fitted.lost
        and better.timing_error_s < ABOUT * best.timing_error_s
    )
    return replace(best, others=others)


def _of_clock(better: BetterFit, stated_hz: float, freedom: int) -> BetterFit:
    """A better fit by another frequency, with the error of the record's clock that would explain it instead."""
    accepted = _accepted_up_to(freedom) * better.standard_error / better.value
    return replace(better, clock_off=stated_hz / better.value - 1, clock_accepted=accepted)


def _explains(other: Fitted, alternative: Unknown | None, inquiry: Inquiry) -> bool:
    """Whether a fit leaves nothing but the noise of the record, by the tests that reject the scenario's model.

    If it leaves more, the cause is another one, for which it compensates in part: a harmonic of the force, friction.
    """
    adjustment = other.adjusted
    if alternative is Unknown.EXPONENT and adjustment.model.exponent > SURELY * adjustment.deviation_of(alternative):
        return False  # no restitution grows with speed
    explained_by = {*inquiry.fitted, *([] if alternative is None else [alternative])}
    return tested(other, explained_by)[0].accepted


def _stated(better: BetterFit, model: ClockedDevice, unknowns: tuple[Unknown, ...]) -> BetterFit:
    """A better fit by an exponent of the restitution, with the restitutions and the speed that state its law."""
    unit = float(model.device.velocity_unit(Parameter.LENGTH, model.device.length_m))
    values = tuple((x, model.value_of(x)) for x in unknowns if x in RESTITUTIONS)
    return replace(better, restitutions=values, speed_m_s=model.speed * unit)
