"""A chart as files, JSON and text."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vireport.map.chart.chart import Chart
from vireport.map.chart.design import ChartedDesign
from vireport.map.chart.meetings import Meeting
from vireport.map.chart.network import FollowedLocus
from vireport.map.chart.opening import chart_opening
from vireport.map.chart.plane import DevicePlane
from vireport.map.chart.regions import ChartRegion, StableMotion
from vireport.map.chart.report import ChartReport
from vireport.map.chart.tables import points_table
from vireport.map.chart.words import naming
from vireport.map.design import alerts_of
from vireport.map.outputs import MapOutput, drawn, page_files
from vireport.motions.events import Event
from vireport.physics.motion import Motion
from vireport.scenario.loading import Loaded
from vireport.study.judging.alerts import named_alerts
from vireport.study.plan import FIGURE_FORMATS, Task
from vireport.study.provenance import Provenance
from vireport.study.results import json_bytes
from vireport.text.tables import Table, markdown_of, markdown_text, plain_text
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.figures.style import Picture


def files(chart: Chart, loaded: Loaded, output: MapOutput) -> dict[str, bytes]:
    """The files of a chart by their names; only what they need is imported.

    Parameters
    ----------
    chart : Chart
    loaded : Loaded
        The scenario.
    output : MapOutput
        With formats among those of `CHART_FILES`.
    """
    contents, wanted = dict[str, bytes](), {*output.formats}
    if wanted & {Task.HTML, Task.PDF, *FIGURE_FORMATS}:
        from vireport.map.chart.figure import picture

        contents |= page_files(report_of(chart, loaded, output, lambda: [picture(chart, output.templates)]), output)
    if Task.JSON in wanted:
        contents["chart.json"] = chart_json(chart, output.provenance(loaded, {}))
    if Task.MARKDOWN in wanted:
        contents["chart.md"] = markdown(chart, output.templates).encode()
    return contents


def report_of(
    chart: Chart, loaded: Loaded, output: MapOutput, draw: Callable[[], Iterable[Picture]] = tuple
) -> ChartReport:
    """What the page of a chart knows, with the pictures that are drawn."""
    pictures = drawn(output, draw)
    return ChartReport(loaded, pictures, output.provenance(loaded, pictures), output.templates, chart=chart)


def text(chart: Chart, templates: Path | None = None, tables: bool = False) -> str:
    """What a chart comes to, for a terminal: the answer, and with `tables` all that is known."""
    opening = chart_opening(chart, naming(chart, templates)).worded(templates)
    facts = [fact for _, fact in opening.facts[1:]]
    rest = plain_text([*facts, *_parts(chart, templates)]) if tables else ""
    return "\n\n".join(filter(None, ("\n".join(opening.lines), rest))) + "\n"


def markdown(chart: Chart, templates: Path | None = None) -> str:
    """What a chart comes to, in Markdown."""
    opening = chart_opening(chart, naming(chart, templates)).worded(templates)
    parts = [opening.sentence, *(fact for _, fact in opening.facts), *_parts(chart, templates)]
    said = "\n\n".join(markdown_text(part) if isinstance(part, str) else markdown_of(part) for part in parts)
    return f"{said.rstrip()}\n"


def _parts(chart: Chart, templates: Path | None) -> Iterator[str | Table]:
    """The alerts, what was found and what was not, and the points of codimension two."""
    if alerts := alerts_of(chart.design):
        yield named_alerts(alerts)
    yield Words("chart", templates)("summary", chart)
    if chart.meetings:
        yield points_table(chart, templates)


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
            "loci": [_locus(locus, edges) for locus, edges in zip(chart.loci, chart.regions.edges, strict=True)],
            "points": [_point(point) for point in chart.meetings],
            "regions": [_region(region) for region in chart.regions.every],
            "narrow_bands": [
                {
                    "word": band.word,
                    "along": plane.inputs[band.varied].value,
                    "least": band.least,
                    "most": band.most,
                    "settable": band.settable,
                }
                for band in chart.narrow
            ],
            "design_point": None if chart.design is None else _design(chart.design, plane),
            "alerts": [alert.to_dict() for alert in alerts_of(chart.design)],
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


def _locus(locus: FollowedLocus, edges: NDArray[np.bool_]) -> dict[str, Any]:
    return {
        "kind": locus.event.value,
        "word": locus.word,
        "periods": locus.path.word.periods,
        "begins_with": locus.events[0][1].value,
        "ends_with": locus.events[-1][1].value,
        "values": locus.inputs.tolist(),
        "bounds_stability": locus.bounds_stability.tolist(),
        "parts_regions": edges.reshape(len(locus.x) - 1, -1).any(axis=1).tolist(),
        "symmetric": locus.symmetric,
        "condition": _condition(locus),
        "start": _start(locus),
    }


def _condition(locus: FollowedLocus) -> dict[str, Any]:
    """What holds on a locus besides the equations of motion: a trace over the determinant's root, and the touches."""
    condition, event = locus.path.condition, locus.event
    walls = [locus.path.word.walls[i] for i in condition.rests]
    levels = {Event.PERIOD_DOUBLING: "-(1 + D)", Event.FOLD: "1 + D", Event.PITCHFORK: "1 + D"}
    levels[Event.NODE_FOCUS] = "2 sqrt(D)" if condition.sign > 0 else "-2 sqrt(D)"
    return {
        "trace": levels.get(event),
        "touches": list(condition.rests),
        "membranes": ["bottom" if wall > 0 else "top" for wall in walls],
    }


def _start(locus: FollowedLocus) -> dict[str, Any]:
    """The motion in the middle of a locus, with its touches as impacts without velocity."""
    x = locus.x[len(locus.x) // 2]
    motion = locus.path.motion(x)
    return {"values": x[-2:].tolist(), "d": motion.coordinate, **_impacts(motion)}


def _impacts(motion: Motion) -> dict[str, Any]:
    """A motion by its impacts, in dimensionless velocities and times."""
    return {
        "impacts": motion.word.letters,
        "periods": motion.word.periods,
        "velocity": motion.velocity.tolist(),
        "time": motion.time.tolist(),
        "phase_rad": motion.phase.tolist(),
    }


def _region(region: ChartRegion) -> dict[str, Any]:
    return {
        "values": list(region.inputs),
        "share": region.share,
        "stable": None if region.motions is None else [_stable(motion) for motion in region.motions],
    }


def _stable(stable: StableMotion) -> dict[str, Any]:
    return {
        "word": stable.word.letters,
        "asymmetric": stable.asymmetric,
        **_impacts(stable.motion),
        "trace": stable.trace,
        "determinant": stable.decay**2,
    }


def _design(design: ChartedDesign, plane: DevicePlane) -> dict[str, Any]:
    return {
        "values": list(design.inputs),
        "stable": None if design.motions is None else [_stable(motion) for motion in design.motions],
        "margins": [
            {
                "along": plane.inputs[end.axis].value,
                "kind": end.event.value,
                "value": end.value,
                "distance": end.distance,
                "relative": end.relative,
                "error_bound": end.error_bound if end.error_bound is not None and isfinite(end.error_bound) else None,
                "taken_over": end.taken_over,
                "stable_beyond": None if end.beyond is None else [_stable(motion) for motion in end.beyond],
            }
            for end in design.margins
        ],
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
