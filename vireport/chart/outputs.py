"""A chart as files, JSON and text."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import Any

from vireport.chart.chart import Chart
from vireport.chart.meetings import Meeting
from vireport.chart.network import FollowedLocus
from vireport.motions import Event
from vireport.study import Provenance, json_bytes
from vireport.text import (
    Table,
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

NOTE = (
    "Two grazings: two touches in one motion. Degenerate grazing: period doublings and folds of the motion with the "
    "further impact begin. Cusp: two curves of folds end together. Degenerate period doubling: it changes from soft "
    "to hard, and a curve of folds begins."
)


def files(chart: Chart, provenance: Provenance) -> dict[str, bytes]:
    """The files of a chart by their names."""
    from vireport.chart.figure import picture

    drawn = picture(chart, caption_of(chart))
    markdown = "\n\n".join(
        markdown_text(part) if isinstance(part, str) else markdown_of(part) for part in _parts(chart)
    )
    contents = drawn.png, drawn.svg, chart_json(chart, provenance), f"{markdown.rstrip()}\n".encode()
    return dict(zip(NAMES, contents, strict=True))


def caption_of(chart: Chart) -> str:
    """What the figure of a chart shows."""
    x, y = (varied.quantity for varied in chart.plane.inputs)
    kinds = ", ".join(dict.fromkeys(locus.event.words for locus in chart.loci))
    alone = "" if chart.plane.swept else ", of 1:1 motions alone"
    return f"Chart of {y} against {x}{alone}: {counted(chart)}{kinds and f'; the curves are of {kinds}'}."


def text(chart: Chart) -> str:
    """What a chart comes to, for a terminal."""
    return plain_text(_parts(chart)) + "\n"


def _parts(chart: Chart) -> Iterator[str | Table]:
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
    columns = [column for varied in plane.inputs for column in (f"{varied.quantity} [{varied.unit or '1'}]", "±")]
    rows = tuple((str(number), *_row(point)) for number, point in enumerate(chart.meetings, 1))
    if rows:
        yield Table("Points of codimension two", (*texts("No.", "What", "Motion"), *numbers(*columns)), rows, NOTE)


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


def _row(point: Meeting) -> tuple[str, ...]:
    pairs = zip(point.inputs, point.error_bound, strict=True)
    digits = [x for value, bound in pairs for x in (exact(value), error_bound(bound) if isfinite(bound) else "")]
    return name_of(point), point.word, *digits


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
