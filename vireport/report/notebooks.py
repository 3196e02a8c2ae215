"""What studies and comparisons show of themselves in a notebook, and as plain data for scripts.

A study cannot import what judges it and what writes it; its methods come here for both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from vireport.gate.verdict import verdict_of
from vireport.study.provenance import provenance_of
from vireport.study.results import results
from vireport.study.study import Study
from vireport.text.formatting import ABSENT, bounded, percent, significant
from vireport.text.wording import KINDS, SWEPT, capital

if TYPE_CHECKING:
    from vireport.comparison.comparison import Comparison

ENDS = "ends"
"""The one list of a branch that is not of its motions."""

MOST_ROWS = 20
"""Differences shown in a notebook; `Comparison.rows` has all."""


def study_dict(study: Study) -> dict[str, Any]:
    """The results of a study as plain data: results.json without its provenance."""
    data = results(study, provenance_of(study.loaded, ""))
    del data["provenance"]
    return data


def study_rows(study: Study) -> list[dict[str, Any]]:
    """Every motion of every branch as a dict, by the names of branches.csv."""
    return [row for branch in study_dict(study)["branches"] for row in _branch_rows(branch)]


def _branch_rows(branch: dict[str, Any]) -> Iterator[dict[str, Any]]:
    columns = {name: values for name, values in branch.items() if isinstance(values, list) and name != ENDS}
    for row in zip(*columns.values(), strict=True):
        yield {"branch": branch["number"], "family": branch["family"], **dict(zip(columns, row, strict=True))}


def study_html(study: Study) -> str:
    """The verdict and the critical points of a study, for a notebook."""
    verdict = verdict_of(study)
    title = study.scenario.title or study.loaded.document.name
    parts = [f"<p><strong>{escape(title)}: {escape(verdict.word)}.</strong> {escape(verdict.headline)}</p>"]
    points = study.solution.critical_points if study.solution else ()
    if points and study.sweep is not None:
        swept = SWEPT[study.sweep.parameter]
        rows = [
            (
                one.label,
                KINDS[one.kind],
                one.family,
                bounded(one.point.sweep_value, one.point.error_bound),
                significant(one.point.d, 9),
            )
            for one in points
        ]
        parts.append(_table(("Point", "Kind", "Motion", f"{swept.symbol} [{swept.unit}]", "d"), rows))
    return "\n".join(parts)


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
    table = _table(("Quantity", *comparison.names, "Apart"), rows) if rows else ""
    more = f"<p>{len(found) - len(rows)} more differ.</p>" if len(found) > len(rows) else ""
    return f"<p><strong>{escape(lead)}</strong></p>\n{table}{more}"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
