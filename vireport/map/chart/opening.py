"""What a chart opens with: what a run says of its design point and how near its ends are, or else what is stable where.

The macros that say it are in `templates/words/chart.j2`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from vireport.map.chart.chart import Chart
from vireport.map.chart.words import Naming, words_given
from vireport.study.judging.alerts import NEAR_CRITICAL
from vireport.study.judging.opening import Opening, Statement, gravest
from vireport.study.judging.verdict import Status
from vireport.text.said import words_of

_said = words_of("chart")

MOST_KINDS = 3
"""Kinds of regions that are told of a chart without a design point."""


def chart_opening(chart: Chart, named: Naming) -> Opening:
    """Choose what a chart opens with.

    Parameters
    ----------
    chart : Chart
        With its regions.
    named : Naming
        How its motions are named.
    """
    words, design, run = words_given(chart, named), chart.design, chart.run
    word = _said("word", words)
    if design is None:
        return Opening(Status.NEUTRAL, word, _said("opening_without_design"), gravest(_regions(words, chart)))
    if design.motions is None:
        return Opening(Status.CAUTION, word, _said("opening_not_resolved"))
    if not design.motions:
        return Opening(
            Status.BAD, word, _said("opening_not_stable", chart.limits), () if run is None else run.opening.facts
        )
    ends = list(_ends(chart, named))
    if run is None or not design.motions[0].one_to_one:
        return Opening(
            Status.CAUTION, word, _said("opening_other_motion", named.of(design.motions[0].kind)), gravest(ends)
        )
    near = any(fact.status is Status.CAUTION for fact in ends) and run.verdict.status is Status.GOOD
    status = Status.CAUTION if near else run.verdict.status
    # The ends along the axes are what a chart is of: they stand before what a run says of the same weight.
    return Opening(status, word, run.opening.sentence, gravest([*ends, *run.opening.facts]), run.opening.tiles)


def _regions(words: dict[str, Any], chart: Chart) -> Iterator[Statement]:
    """What is stable in the largest parts of a chart."""
    for region_set in words["sets"][:MOST_KINDS]:
        what = words["named"].long(region_set.kinds, chart.limits)
        yield Statement(Status.NEUTRAL, _said("opening_region", what, region_set.share))


def _ends(chart: Chart, named: Naming) -> Iterator[Statement]:
    """Where the motion of the design point ends along both inputs, the nearest end of each."""
    design = chart.design
    assert design is not None
    assert design.motions
    name = named.of(design.motions[0].kind)
    for k, varied in enumerate(chart.plane.inputs):
        end = design.nearest(k)
        if end is None:
            yield Statement(Status.NEUTRAL, _said("opening_endless", name, varied))
        else:
            near = end.relative is not None and abs(end.relative) < NEAR_CRITICAL
            away = _said("away_absolute" if end.relative is None else "away", end, varied)
            how = "opening_handover" if end.taken_over else "opening_end"
            said = _said(how, name, varied, end, varied.show(end.value, chart.exactness), away)
            yield Statement(Status.CAUTION if near else Status.NEUTRAL, said)
