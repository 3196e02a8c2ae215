"""What a chart opens with: what a run says of its design point and how near its ends are, or else what is stable where.

The macros that say it are in `templates/words/chart.j2`.
"""

from __future__ import annotations

from collections.abc import Iterator

from vireport.map.chart.chart import Chart
from vireport.map.chart.words import Naming
from vireport.map.design import exactness_of
from vireport.study.judging.alerts import is_near_critical
from vireport.study.judging.opening import Opening, Statement, gravest
from vireport.study.judging.verdict import Status
from vireport.text.formatting import percent
from vireport.text.said import words_of

_said = words_of("chart")

MOST_KINDS = 3
"""Kinds of regions that are told of a chart without a design point."""


def chart_opening(chart: Chart, named: Naming) -> Opening:
    """Choose what a chart opens with: of a stable 1:1 motion, or a table, that is what a run says of the design point.

    Parameters
    ----------
    chart : Chart
    named : Naming
        How its motions are named.
    """
    design = chart.design
    if design is None:
        regions = gravest(_regions(chart, named))
        return Opening(Status.NEUTRAL, _said("word_without_design"), _said("opening_without_design"), regions)
    run = None if design.study is None else design.study.opening
    if design.motions is None:
        return Opening(Status.CAUTION, _said("word_not_resolved"), _said("opening_not_resolved"))
    on_table = design.study is not None and design.study.solution.on_table
    if not design.motions and not on_table:
        facts = () if run is None else run.facts
        return Opening(Status.BAD, _said("word_not_stable"), _said("opening_not_stable", chart.limits), facts)
    ends, name = list(design_ends(chart, named)), named.of(design.motions[0].kind) if design.motions else None
    if design.motions and not (on_table or design.motions[0].one_to_one):
        sentence = _said("opening_other_motion", name)
        return Opening(Status.CAUTION, _said("word_other_motion"), sentence, gravest(ends))
    if run is None:
        return Opening(Status.CAUTION, _said("word_not_judged"), _said("opening_not_judged", name), gravest(ends))
    # The ends along the axes are what a chart is of: they stand before what a run says of the same weight.
    return Opening(run.status, run.word, run.sentence, gravest([*ends, *run.facts]), run.tiles)


def _regions(chart: Chart, named: Naming) -> Iterator[Statement]:
    """Statements on what is stable in the largest parts of a chart."""
    for region_set in chart.regions.sets[:MOST_KINDS]:
        what = named.long(region_set.kinds, chart.limits)
        yield Statement(Status.NEUTRAL, _said("opening_region", what, region_set.share))


def design_ends(chart: Chart, named: Naming) -> Iterator[Statement]:
    """Where the first stable motion of the design point ends along both inputs, the nearest end of each."""
    design = chart.design
    if design is None or not design.motions:
        return
    name = named.of(design.motions[0].kind)
    for k, varied in enumerate(chart.plane.inputs):
        end = design.nearest(k)
        if end is None:
            yield Statement(Status.NEUTRAL, _said("opening_endless", name, varied))
            continue
        status = Status.CAUTION if is_near_critical(end.relative) else Status.NEUTRAL
        away = varied.signed(end.distance) if end.relative is None else percent(end.relative, signed=True)
        side = _said("up" if end.distance > 0 else "down")
        why = _said("handover") if end.taken_over else end.event.words
        value = varied.show(end.value, exactness_of(design))
        yield Statement(status, _said("opening_end", name, varied, side, value, away, why))
