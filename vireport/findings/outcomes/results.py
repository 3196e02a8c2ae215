"""What other starts come to as plain data, for results.json, within what it has of switching on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vireport.findings.outcomes.outcomes import Outcomes
from vireport.motions.families import Claim
from vireport.study.results import finite

if TYPE_CHECKING:
    from vireport.findings.outcomes.attracting import AttractingMotion, AttractingMotions
    from vireport.findings.outcomes.basin import Basins
    from vireport.findings.outcomes.windows import Window
    from vireport.findings.outcomes.withstood import Withstood

SHOCK = (
    *("least_jump_m_s", "after", "after_s", "sign", "leads_to"),
    *("searched_to_m_s", "tried", "reason"),
)
"""What results.json has of the least shock."""

AFTER_SHOCK = "recovery_periods", "recovery_s", "recovery_error_bound_periods", "recovery_reason"
"""What the core has of switching on that stands behind the shocks."""


def outcomes_data(block: Mapping[str, Any], outcomes: Outcomes) -> dict[str, Any]:
    """The block of the core with what other starts come to; null is what was not computed."""
    start, ramp, window = block["from_rest"], outcomes.ramp, outcomes.window
    withstood, attracting, basins = outcomes.withstood, outcomes.attracting, outcomes.basins
    from_rest = {
        **{name: value for name, value in start.items() if name != "along_sweep"},
        "share_of_switch_on_phases": outcomes.share,
        "ramp_that_reaches_1_1": ramp and {"periods": ramp.periods, "longest_tried": ramp.longest},
        "window": window and _window(window),
        "along_sweep": start["along_sweep"],
    }
    return {
        **{name: value for name, value in block.items() if name not in AFTER_SHOCK},
        "from_rest": from_rest,
        "shock": _shock(withstood),
        **{name: block[name] for name in AFTER_SHOCK},
        "jitter": withstood and _jitter(withstood),
        "coexistence": attracting and _coexistence(attracting),
        "basin": basins and _basin(basins),
    }


def _window(window: Window) -> dict[str, Any]:
    """The window of an outcome, and what comes beyond either end."""
    ends = {"from": window.low, "to": window.high}
    return (
        {"parameter": window.parameter}
        | {name: edge.value for name, edge in ends.items()}
        | {f"{name}_outcome": edge.beyond and edge.beyond.destination for name, edge in ends.items()}
        | {f"{name}_word": edge.beyond and edge.beyond.word for name, edge in ends.items()}
        | {f"{name}_periods": edge.beyond and edge.beyond.periods for name, edge in ends.items()}
        | {f"{name}_accumulates": edge.accumulates for name, edge in ends.items()}
        | {"claim": Claim.SEARCHED}  # samples tell of no edge that it is the nearest
    )


def _shock(withstood: Withstood | None) -> dict[str, Any] | None:
    """The least shock, or why it is not known; None where nothing was looked for."""
    if withstood is None or withstood.shock is None:
        unknown = withstood.shock_unknown if withstood is not None else ""
        return dict.fromkeys(SHOCK) | {"reason": unknown} if unknown else None
    least = withstood.shock
    out = least.jump is not None
    values = (
        *(withstood.jump_m_s, _membrane(withstood.after_bottom) if out else None),
        *(withstood.delay_s if out else None, least.sign if out else None, least.leads_to and least.leads_to.name),
        *(withstood.searched_to_m_s, least.tried, None),
    )
    return dict(zip(SHOCK, values, strict=True))


def _membrane(bottom: bool) -> str:
    return "bottom" if bottom else "top"


def _jitter(withstood: Withstood) -> dict[str, Any] | None:
    """The spread at the impacts, or why none is given; None where it was not asked for."""
    if withstood.jitter is None:
        return None
    spread = withstood.spread
    columns: dict[str, float | None] = {}
    for of in withstood.spreads:
        columns |= {f"phase_{of.membrane}_deg": of.phase_deg, f"velocity_{of.membrane}_m_s": of.velocity_m_s}
        if of.voltage_v is not None:
            columns |= {f"u_{of.membrane}_v": of.voltage_v, f"u_{of.membrane}_mean_v": of.mean_voltage_v}
    return {
        "phase_deg": withstood.phase_deg,
        "velocity_m_s": withstood.velocity_m_s,
        **columns,
        "relative_error": None if spread is None else spread.error,
        "valid": spread is not None,
        "valid_up_to_m_s": finite(withstood.valid_up_to_m_s),
        "valid_up_to_restitution": finite(withstood.valid_up_to_restitution),
        "reason": withstood.jitter_unknown or None,
    }


def _coexistence(attracting: AttractingMotions) -> dict[str, Any]:
    """The stable motions of any word: shares of starts, whether reached from rest, and the least shock of each."""
    return {
        "starts": attracting.starts,
        "share_of_others": attracting.others,
        "motions": [_attracting(row, attracting) for row in attracting.motions],
    }


def _attracting(row: AttractingMotion, attracting: AttractingMotions) -> dict[str, Any]:
    motion, shock = row.motion, row.shock
    data = {
        "name": row.name,
        "word": motion and motion.word.letters,
        "periods": motion and motion.word.periods,
        "velocity": motion and motion.velocity.tolist(),
        "phase_rad": motion and motion.phase.tolist(),
        "share_of_starts": row.share,
        "reached_from_rest": row.from_rest,
        "least_jump_m_s": None, "after": None, "after_impact": None, "after_s": None, "sign": None, "leads_to": None,
        "searched_to_m_s": None if shock is None else shock.searched_to * attracting.velocity_unit,
        "reason": row.unknown or None,
    }  # fmt: skip
    if shock is not None and shock.jump is not None:
        data["least_jump_m_s"] = shock.jump * attracting.velocity_unit
        data |= {"after": _membrane(shock.motion.word.walls[shock.impact] > 0), "after_impact": shock.impact + 1}
        data |= {"after_s": shock.delay * attracting.time_unit, "sign": shock.sign}
        data["leads_to"] = shock.leads_to and shock.leads_to.name
    return data


def _basin(basins: Basins) -> dict[str, Any]:
    """The share of the section of impacts that leads to each motion."""
    names = "name", "share", "low_95", "high_95"
    attractors = [dict(zip(names, row, strict=True)) for row in basins.shares]
    return {"impacts": basins.impacts, "velocity_up_to_m_s": basins.fastest_m_s, "attractors": attractors}
