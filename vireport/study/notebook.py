"""What a study shows of itself in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from vireport.study.study import Study
from vireport.text import (
    bounded,
    significant,
)


def study_html(study: Study) -> str:
    """The verdict and the critical points of a study, for a notebook."""
    verdict = study.verdict
    title = study.scenario.title or study.loaded.document.name
    parts = [f"<p><strong>{escape(title)}: {escape(verdict.word)}.</strong> {escape(verdict.headline)}</p>"]
    points, swept = study.solution.critical_points, study.solution.parameter
    if points:
        rows = [
            (
                one.label,
                one.kind.words,
                one.family,
                bounded(one.point.sweep_value, one.point.error_bound),
                significant(one.point.d, 9),
            )
            for one in points
        ]
        parts.append(html_table(("Point", "Kind", "Motion", f"{swept.symbol} [{swept.unit}]", "d"), rows))
    return "\n".join(parts)


def html_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in HTML, its text inert."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
