"""A chart as files, JSON and text."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import isfinite
from typing import Any

from vireport.chart.chart import Chart
from vireport.chart.meetings import Meeting
from vireport.chart.network import FollowedLocus
from vireport.motions import Event
from vireport.scenario import DesignInput
from vireport.study import Provenance, json_bytes
from vireport.text import (
    Table,
    bounded,
    error_bound,
    exact,
    markdown_of,
    markdown_text,
    numbers,
    plain_text,
    texts,
)

NAMES = "figure-chart.png", "figure-chart.svg", "chart.json", "chart.md"
"""Files that a chart is written to."""

SHOWN = 1e-8
"""Relative error below which no digit of a point is printed on a terminal."""

NOTE = (
    "Two grazings: two touches in one motion. Degenerate grazing: period doublings and folds of the motion with the "
    "further impact begin. Cusp: two curves of folds end together. Degenerate period doubling: it changes from soft "
    "to hard, and a curve of folds begins."
)


def files(chart: Chart, provenance: Provenance) -> dict[str, bytes]:
    """The files of a chart by their names."""
    from vireport.chart.figure import picture

    drawn = picture(chart, caption_of(chart))
    contents = drawn.png, drawn.svg, chart_json(chart, provenance), markdown(chart).encode()
    return dict(zip(NAMES, contents, strict=True))


def caption_of(chart: Chart) -> str:
    """What the figure of a chart shows."""
    x, y = (varied.quantity for varied in chart.plane.inputs)
    kinds = ", ".join(dict.fromkeys(locus.event.words for locus in chart.loci))
    alone = "" if chart.plane.swept else ", of 1:1 motions alone"
    return f"Chart of {y} against {x}{alone}: {counted(chart)}{kinds and f'; the curves are of {kinds}'}."


def text(chart: Chart) -> str:
    """What a chart comes to, for a terminal."""
    return plain_text(_parts(chart, _points)) + "\n"


def markdown(chart: Chart) -> str:
    """The same in Markdown, with all digits and the error bounds."""
    parts = _parts(chart, _exact_points)
    said = "\n\n".join(markdown_text(part) if isinstance(part, str) else markdown_of(part) for part in parts)
    return f"{said.rstrip()}\n"


def _parts(chart: Chart, table: Callable[[Chart], Table]) -> Iterator[str | Table]:
    plane, limits, lost = chart.plane, chart.limits, chart.not_followed
    ranges = " and ".join(
        f"{varied.quantity} from {low:g} to {varied.show(high)}"
        for varied, low, high in zip(plane.inputs, plane.low, plane.high, strict=True)
    )
    crossed = "sweep" if plane.swept else "line"
    said = f" {lost} end{'s' * (lost != 1)} of curves could not be followed further." if lost else ""
    yield (
        f"Over {ranges}: {counted(chart)}, of motions with at most {limits.impacts} impacts in {limits.periods} "
        f"forcing periods. Curves that neither cross a {crossed} that was followed nor meet another are missed.{said}"
    )
    if chart.meetings:
        yield table(chart)


def _points(chart: Chart) -> Table:
    """The points of codimension two, to the digits that are justified, and to eight at the most."""
    rows = (
        [bounded(x, max(bound, SHOWN * abs(x)) if isfinite(bound) else SHOWN * abs(x)) for x, bound in _inputs(point)]
        for point in chart.meetings
    )
    heads = [_head(varied) for varied in chart.plane.inputs]
    return _table(chart, heads, rows, f"{NOTE} chart.json has all digits and the error bounds.")


def _exact_points(chart: Chart) -> Table:
    """The same to the last digit, with error bounds."""
    rows = (
        [x for value, bound in _inputs(point) for x in (exact(value), error_bound(bound) if isfinite(bound) else "")]
        for point in chart.meetings
    )
    return _table(chart, [column for varied in chart.plane.inputs for column in (_head(varied), "±")], rows, NOTE)


def _table(chart: Chart, heads: Sequence[str], rows: Iterable[Sequence[str]], note: str) -> Table:
    named = tuple(
        (str(number), name_of(point), point.word, *cells)
        for number, (point, cells) in enumerate(zip(chart.meetings, rows, strict=True), 1)
    )
    return Table("Points of codimension two", (*texts("No.", "What", "Motion"), *numbers(*heads)), named, note)


def _head(varied: DesignInput) -> str:
    return f"{varied.quantity} [{varied.unit}]" if varied.unit else varied.quantity


def _inputs(point: Meeting) -> list[tuple[float, float]]:
    return list(zip(map(float, point.inputs), map(float, point.error_bound), strict=True))


def counted(chart: Chart) -> str:
    """How many curves and points a chart has."""
    curves, points = len(chart.loci), len(chart.meetings)
    return f"{curves} curve{'s' * (curves != 1)} and {points} point{'s' * (points != 1)} where they meet, end or turn"


def name_of(point: Meeting) -> str:
    """What happens at a point."""
    own, other = point.events
    if other is not Event.GRAZING:
        return other.words
    if own is Event.GRAZING:
        return "two grazings"
    return own.words if own is Event.DEGENERATE_GRAZING else f"{own.words} with grazing"


def chart_json(chart: Chart, provenance: Provenance) -> bytes:
    """A chart as JSON, one top-level key a line."""
    plane = chart.plane
    return json_bytes(
        {
            "inputs": [
                {"name": varied.value, "unit": varied.unit, "from": float(low), "to": float(high)}
                for varied, low, high in zip(plane.inputs, plane.low, plane.high, strict=True)
            ],
            "limits": {"impacts": chart.limits.impacts, "periods": chart.limits.periods},
            "loci": [_locus(locus) for locus in chart.loci],
            "points": [_point(point) for point in chart.meetings],
            "sweeps": [
                {
                    "along": plane.inputs[cut.line.varied].value,
                    "at": cut.line.other,
                    "stable": [{"from": low, "to": high, "words": list(words)} for low, high, words in cut.stable],
                }
                for cut in chart.cuts
            ],
        },
        provenance,
    )


def _locus(locus: FollowedLocus) -> dict[str, Any]:
    return {
        "kind": locus.event.value,
        "word": locus.word,
        "periods": locus.path.word.periods,
        "begins_with": locus.events[0][1].value,
        "ends_with": locus.events[-1][1].value,
        "values": locus.inputs.tolist(),
        "bounds_stability": locus.bounds_stability.tolist(),
    }


def _point(point: Meeting) -> dict[str, Any]:
    return {
        "kinds": [event.value for event in point.events],
        "word": point.word,
        "periods": point.motion.word.periods,
        "values": list(point.inputs),
        "error_bounds": [bound if isfinite(bound) else None for bound in point.error_bound],
        "velocity": point.motion.velocity.tolist(),
        "phase_rad": point.motion.phase.tolist(),
    }
