"""Records of results.json on how long motions last under random kicks."""

from __future__ import annotations

from vireport.base.records import ResultsBlock
from vireport.findings.escape.escape import Escape, MotionEscape
from vireport.findings.escape.lifetimes import Lifetime


class LifetimeData(ResultsBlock, frozen=True, kw_only=True):
    """The mean time under kicks of one size, simulated.

    Attributes
    ----------
    kick_m_s : m/s
        standard deviation of the kicks
    periods, low_95, high_95
        mean number of forcing periods, and its 95 % interval
    escapes, impacts
        balls that left, and impacts simulated
    p_value
        probability that escapes at a constant rate after the transient differ from one by as much as these; null of
        fewer than 50
    """

    kick_m_s: float
    periods: float
    low_95: float
    high_95: float
    escapes: int
    impacts: int
    p_value: float | None


class LawData(ResultsBlock, frozen=True, kw_only=True):
    """The law for small kicks, ln T = a + Q/σ².

    Attributes
    ----------
    q_m2_s2 : m²/s²
        Q, half the least sum of squared kicks that leads out
    a, a_standard_error
        a for T in forcing periods, from `levels`, and its standard error; null where too few levels are known
    least_shock_m_s : m/s
        least single kick just after an impact that leads out; half its square is above Q
    kicks_m_s : m/s
        the least kicks, from impact to impact, those above a thousandth of the largest
    """

    q_m2_s2: float
    a: float | None
    a_standard_error: float | None
    least_shock_m_s: float
    kicks_m_s: list[float]


class EndData(ResultsBlock, frozen=True, kw_only=True):
    """What a share of the escapes comes to.

    Attributes
    ----------
    name, share
        the motion or state, and its share
    """

    name: str
    share: float


class MotionEscapeData(ResultsBlock, frozen=True, kw_only=True):
    """How long a stable 1:1 motion lasts.

    Attributes
    ----------
    velocity, phase_rad : F π/(M ω), rad
        at its impacts
    periods, time_s : –, s
        mean number of forcing periods, and time, until the undisturbed continuation would not return; null as `reason`
        says
    low_95, high_95
        95 % interval of `periods`; where nothing left, and where no number is of use, an end is null
    log_periods
        natural logarithm of `periods`, also if that is null because it is too large
    extrapolated
        whether it is by `law`, and not simulated with these kicks
    reason
        why there is no `periods`; else null
    transient_periods
        forcing periods after which the escapes are tested for a constant rate; null where nothing was simulated
    p_value
        of that test, see `levels`: below 0.01 times are not exponential; of these kicks or, if `extrapolated`, of the
        last of `levels`; null of too few escapes
    ends
        what those that left come to; if `extrapolated`, at the last of `levels`
    law
        the law for small kicks; null where no sequence of kicks that leads out is confirmed
    levels
        simulated with larger kicks, for the law
    checked, wrong
        impacts of which a table told that they return and that were followed as well, and how many do not return
    """

    velocity: list[float]
    phase_rad: list[float]
    periods: float | None
    time_s: float | None
    low_95: float | None
    high_95: float | None
    log_periods: float | None
    extrapolated: bool
    reason: str | None
    transient_periods: float | None
    p_value: float | None
    ends: list[EndData]
    law: LawData | None
    levels: list[LifetimeData]
    checked: int
    wrong: int


class EscapeData(ResultsBlock, frozen=True, kw_only=True):
    """How long the stable 1:1 motions of the design point last under random kicks.

    Attributes
    ----------
    kick_m_s : m/s
        standard deviation of the kicks, `disturbances.jitter_m_s`
    motions
        each of the motions
    """

    kick_m_s: float
    motions: list[MotionEscapeData]


def escape_data(escape: Escape) -> EscapeData:
    """The record on how long each stable 1:1 motion lasts."""
    return EscapeData(kick_m_s=escape.kick_m_s, motions=[_motion(of, escape) for of in escape.motions])


def _motion(of: MotionEscape, escape: Escape) -> MotionEscapeData:
    low, high = of.interval
    shape, finite = of.shape, of.periods is not None or of.extrapolated
    return MotionEscapeData(
        velocity=of.motion.velocity.tolist(),
        phase_rad=of.motion.phase.tolist(),
        periods=of.periods,
        time_s=None if of.periods is None else escape.time_s(of.periods),
        low_95=low,
        high_95=high,
        log_periods=of.log_periods if finite else None,
        extrapolated=of.extrapolated,
        reason=of.reason or None,
        transient_periods=None if shape is None else shape.transient,
        p_value=None if shape is None else shape.p_value,
        ends=[EndData(name=name, share=share) for name, share in of.ends],
        law=_law(of, escape.velocity_unit),
        levels=[_lifetime(level, escape.velocity_unit) for level in of.levels],
        checked=of.checked,
        wrong=of.wrong,
    )


def _law(of: MotionEscape, unit: float) -> LawData | None:
    if of.way is None or of.path is None:
        return None
    kicks = of.path.kicks * unit
    felt = abs(kicks) > 1e-3 * abs(kicks).max()
    return LawData(
        q_m2_s2=of.path.exponent * unit**2,
        a=None if of.law is None else of.law.offset,
        a_standard_error=None if of.law is None else of.law.error,
        least_shock_m_s=of.way.shock * unit,
        kicks_m_s=kicks[felt.argmax() : len(kicks) - felt[::-1].argmax()].tolist(),
    )


def _lifetime(level: Lifetime, unit: float) -> LifetimeData:
    low, high = level.interval
    return LifetimeData(
        kick_m_s=level.kick * unit,
        periods=level.mean,
        low_95=low,
        high_95=high,
        escapes=len(level.escaped),
        impacts=level.impacts,
        p_value=level.p_value,
    )
