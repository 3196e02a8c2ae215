"""What a comparison shows of itself in a notebook."""

from __future__ import annotations

from html import escape

from vireport.comparison.comparison import Comparison
from vireport.gate import capital
from vireport.study import html_table
from vireport.text import (
    ABSENT,
    percent,
    significant,
)

MOST_ROWS = 20
"""Differences shown in a notebook; `Comparison.rows` has all."""


def comparison_html(comparison: Comparison) -> str:
    """What differs between scenarios, the largest first, for a notebook."""
    found = comparison.differences
    lead = f"{len(found)} of {len(comparison.quantities)} quantities differ."
    rows = []
    for one in found[:MOST_ROWS]:
        unit = "" if one.unit == "1" else f" [{one.unit}]"
        cells = [ABSENT if value is None else significant(value) for value in one.values]
        apart = "only some" if one.change is None else percent(one.change) if one.change else "type"
        rows.append((f"{capital(one.quantity)}{unit}", *cells, apart))
    table = html_table(("Quantity", *comparison.names, "Apart"), rows) if rows else ""
    more = f"<p>{len(found) - len(rows)} more differ.</p>" if len(found) > len(rows) else ""
    return f"<p><strong>{escape(lead)}</strong></p>\n{table}{more}"
