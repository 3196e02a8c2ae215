"""What other starts come to as records of results.json, within its block `disturbances`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from msgspec import UNSET, UnsetType
from msgspec.structs import replace

from vireport.base.records import ResultsBlock
from vireport.findings.outcomes.outcomes import Outcomes
from vireport.motions.families import Claim
from vireport.study.result_records import DisturbancesData, ShockData
from vireport.study.results import finite

if TYPE_CHECKING:
    from vireport.findings.outcomes.attracting import AttractingMotion, AttractingMotions
    from vireport.findings.outcomes.basin import Basins
    from vireport.findings.outcomes.windows import Window
    from vireport.findings.outcomes.withstood import Withstood


class RampData(ResultsBlock, frozen=True, kw_only=True):
    """The shortest ramp tried that reaches a stable 1:1 motion, and the longest tried.

    Attributes
    ----------
    periods
        forcing periods of the shortest ramp tried that reaches it from every moment tried; null if none does
    longest_tried
        forcing periods of the longest ramp tried
    """

    periods: float | None
    longest_tried: float


class WindowData(ResultsBlock, frozen=True, kw_only=True):
    """The window of an outcome, and what comes beyond either end.

    Attributes
    ----------
    parameter, from_, to
        the swept input, or the length, and the ends of the interval. They are located to 1e-9 of the value, or some
        1e-6 where a motion other than 1:1 loses its stability
    from_outcome, to_outcome, from_word, to_word, from_periods, to_periods
        the outcomes beyond; null if the outcome did not change in the range searched
    from_accumulates, to_accumulates
        whether infinitely many edges accumulate there
    claim
        `searched`: the edges are the nearest that were seen, and nearer ones are not excluded
    """

    parameter: str
    from_: float
    to: float
    from_outcome: str | None
    to_outcome: str | None
    from_word: str | None
    to_word: str | None
    from_periods: int | None
    to_periods: int | None
    from_accumulates: bool
    to_accumulates: bool
    claim: str


class JitterData(ResultsBlock, frozen=True, kw_only=True):
    """The spread at the impacts, or why none is given.

    Attributes
    ----------
    phase_deg, velocity_m_s : degrees, m/s
        standard deviations of the phase at the impacts and of the velocity just before them, the larger of both
        membranes; null where linear theory does not hold
    phase_bottom_deg, phase_top_deg, velocity_bottom_m_s, velocity_top_m_s, u_bottom_v, u_top_v : degrees, m/s, V
        the same for each membrane, and of the voltage gained; absent where these are null, voltages also without
        `ball_mass_kg`
    u_bottom_mean_v, u_top_mean_v : V
        mean of that voltage, to second order in the kicks; absent as that
    relative_error : 1
        relative error of these values: how far mean, covariance and skewness of the spread by the map itself are from
        linear theory; at most 5 %; null where linear theory does not hold
    valid, reason
        whether these values are given, and if not, why (else null): linear theory does not hold, or restitutions
        below 0 or above 1 would be less than 3 standard deviations away
    valid_up_to_m_s, valid_up_to_restitution : m/s, 1
        largest standard deviations for which they are given, at the same ratio of both sources; 0 if there are none;
        null where this source is not given
    """

    phase_deg: float | None
    velocity_m_s: float | None
    phase_bottom_deg: float | UnsetType | None = UNSET
    velocity_bottom_m_s: float | UnsetType | None = UNSET
    u_bottom_v: float | UnsetType | None = UNSET
    u_bottom_mean_v: float | UnsetType | None = UNSET
    phase_top_deg: float | UnsetType | None = UNSET
    velocity_top_m_s: float | UnsetType | None = UNSET
    u_top_v: float | UnsetType | None = UNSET
    u_top_mean_v: float | UnsetType | None = UNSET
    relative_error: float | None
    valid: bool
    valid_up_to_m_s: float | None
    valid_up_to_restitution: float | None
    reason: str | None


class AttractingData(ResultsBlock, frozen=True, kw_only=True):
    """A stable motion of any word: its share of starts, whether it is reached from rest, and its least shock.

    Attributes
    ----------
    name, word, periods
        the motion; word and periods are null for rest
    velocity, phase_rad : F π/(M ω), rad
        at its impacts; null for rest
    share_of_starts : 1
        share of the starts that reach it; null where returns are undecided
    reached_from_rest
        null if, with a ramp, it is open which of several motions of one word is reached
    least_jump_m_s, after, after_s, sign, leads_to, searched_to_m_s
        the least shock out of that motion, as of `shock`; for other words than BT a quarter as many jumps are tried.
        Null for rest
    after_impact
        number in the word, from 1, of the impact before it; null without a jump
    reason
        why no shock is given; else null
    """

    name: str
    word: str | None
    periods: int | None
    velocity: list[float] | None
    phase_rad: list[float] | None
    share_of_starts: float | None
    reached_from_rest: bool | None
    least_jump_m_s: float | None = None
    after: str | None = None
    after_impact: int | None = None
    after_s: float | None = None
    sign: int | None = None
    leads_to: str | None = None
    searched_to_m_s: float | None
    reason: str | None


class CoexistenceData(ResultsBlock, frozen=True, kw_only=True):
    """The stable motions of any word, and the share of starts that reaches none of them.

    Attributes
    ----------
    starts
        number of random [starts](scenario.md#simulation) followed
    share_of_others : 1
        share of them that reaches none of these motions; null if a motion is too near a critical point for its
        returns to be decided
    motions
        each of them
    """

    starts: int
    share_of_others: float | None
    motions: list[AttractingData]


class BasinShare(ResultsBlock, frozen=True, kw_only=True):
    """The share of a section of impacts that leads to a motion, with its interval of 95 %.

    Attributes
    ----------
    name
        the motion
    share, low_95, high_95 : 1
        share of the impacts that leads to it, and its 95 % interval (Clopper and Pearson); null where returns are
        undecided
    """

    name: str
    share: float | None
    low_95: float | None
    high_95: float | None


class BasinData(ResultsBlock, frozen=True, kw_only=True):
    """The shares of the section of impacts on the bottom membrane.

    Attributes
    ----------
    impacts
        number of random impacts, uniform in phase and velocity
    velocity_up_to_m_s : m/s
        largest velocity
    attractors
        share that leads to each motion
    """

    impacts: int
    velocity_up_to_m_s: float
    attractors: list[BasinShare]


def disturbances_with_outcomes(block: DisturbancesData, outcomes: Outcomes) -> DisturbancesData:
    """The block on disturbances with what other starts come to; what was not computed is null."""
    ramp, window, from_rest = outcomes.ramp, outcomes.window, block.from_rest
    withstood, attracting, basins = outcomes.withstood, outcomes.attracting, outcomes.basins
    if from_rest is not None:
        from_rest = replace(
            from_rest,
            share_of_switch_on_phases=outcomes.share,
            ramp_that_reaches_1_1=None if ramp is None else RampData(periods=ramp.periods, longest_tried=ramp.longest),
            window=None if window is None else _window(window),
        )
    return replace(
        block,
        from_rest=from_rest,
        shock=_shock(withstood),
        jitter=None if withstood is None else _jitter(withstood),
        coexistence=None if attracting is None else _coexistence(attracting),
        basin=None if basins is None else _basin(basins),
    )


def _window(window: Window) -> WindowData:
    low, high = window.low, window.high
    below, above = low.beyond, high.beyond
    return WindowData(
        parameter=window.parameter,
        from_=low.value,
        to=high.value,
        from_outcome=None if below is None else below.destination,
        to_outcome=None if above is None else above.destination,
        from_word=None if below is None else below.word,
        to_word=None if above is None else above.word,
        from_periods=None if below is None else below.periods,
        to_periods=None if above is None else above.periods,
        from_accumulates=low.accumulates,
        to_accumulates=high.accumulates,
        claim=Claim.SEARCHED,  # samples cannot show that an edge is the nearest
    )


def _shock(withstood: Withstood | None) -> ShockData | None:
    """The least shock, or why it is not known; None where nothing was looked for."""
    if withstood is None or withstood.shock is None:
        unknown = withstood.shock_unknown if withstood is not None else ""
        return ShockData(reason=unknown) if unknown else None
    least = withstood.shock
    out = least.jump is not None
    return ShockData(
        least_jump_m_s=withstood.jump_m_s,
        after=_membrane(withstood.after_bottom) if out else None,
        after_s=withstood.delay_s if out else None,
        sign=least.sign if out else None,
        leads_to=None if least.leads_to is None else least.leads_to.name,
        searched_to_m_s=withstood.searched_to_m_s,
        tried=least.tried,
    )


def _membrane(bottom: bool) -> str:
    return "bottom" if bottom else "top"


def _jitter(withstood: Withstood) -> JitterData | None:
    """The spread at the impacts, or why none is given; None where it was not asked for."""
    if withstood.jitter is None:
        return None
    spread = withstood.spread
    columns: dict[str, Any] = {}
    for of in withstood.spreads:
        columns |= {f"phase_{of.membrane}_deg": of.phase_deg, f"velocity_{of.membrane}_m_s": of.velocity_m_s}
        if of.voltage_v is not None:
            columns |= {f"u_{of.membrane}_v": of.voltage_v, f"u_{of.membrane}_mean_v": of.mean_voltage_v}
    return JitterData(
        phase_deg=withstood.phase_deg,
        velocity_m_s=withstood.velocity_m_s,
        **columns,
        relative_error=None if spread is None else spread.error,
        valid=spread is not None,
        valid_up_to_m_s=finite(withstood.valid_up_to_m_s),
        valid_up_to_restitution=finite(withstood.valid_up_to_restitution),
        reason=withstood.jitter_unknown or None,
    )


def _coexistence(attracting: AttractingMotions) -> CoexistenceData:
    """The stable motions of any word: shares of starts, whether reached from rest, and the least shock of each."""
    return CoexistenceData(
        starts=attracting.starts,
        share_of_others=attracting.others,
        motions=[_attracting(row, attracting) for row in attracting.motions],
    )


def _attracting(row: AttractingMotion, attracting: AttractingMotions) -> AttractingData:
    motion, shock = row.motion, row.shock
    data = AttractingData(
        name=row.name,
        word=None if motion is None else motion.word.letters,
        periods=None if motion is None else motion.word.periods,
        velocity=None if motion is None else motion.velocity.tolist(),
        phase_rad=None if motion is None else motion.phase.tolist(),
        share_of_starts=row.share,
        reached_from_rest=row.from_rest,
        searched_to_m_s=None if shock is None else shock.searched_to * attracting.velocity_unit,
        reason=row.unknown or None,
    )
    if shock is None or shock.jump is None:
        return data
    return replace(
        data,
        least_jump_m_s=shock.jump * attracting.velocity_unit,
        after=_membrane(shock.motion.word.walls[shock.impact] > 0),
        after_impact=shock.impact + 1,
        after_s=shock.delay * attracting.time_unit,
        sign=shock.sign,
        leads_to=None if shock.leads_to is None else shock.leads_to.name,
    )


def _basin(basins: Basins) -> BasinData:
    """The share of the section of impacts that leads to each motion."""
    return BasinData(
        impacts=basins.impacts,
        velocity_up_to_m_s=basins.fastest_m_s,
        attractors=[
            BasinShare(name=name, share=share, low_95=low, high_95=high) for name, share, low, high in basins.shares
        ],
    )
