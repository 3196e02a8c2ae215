"""Records of optimise.json: what is written, with the names that scripts rely on."""

from __future__ import annotations

from vireport.base.records import ResultsBlock
from vireport.scenario.blocks import Objective
from vireport.study.result_records import AlertData, CriterionData


class SearchedDesign(ResultsBlock, frozen=True, kw_only=True):
    """A design of a search.

    Attributes
    ----------
    inputs
        the inputs that vary, by their paths
    value : `unit`
        the objective; null where it is beyond the range of doubles
    margin_percent : %
        smallest margin in any input; null where stable motion ends nowhere
    at_limit
        inputs at an end of their range, `upper` or `lower`
    requirements, alerts
        as of [results.json](results.md#requirements-and-alerts); `line` is null
    """

    inputs: dict[str, float]
    value: float | None
    margin_percent: float | None
    at_limit: dict[str, str]
    requirements: list[CriterionData]
    alerts: list[AlertData]


class SearchEvidenceData(ResultsBlock, frozen=True, kw_only=True):
    """What a search says of all designs.

    Attributes
    ----------
    cells
        numbers of cells along each input
    stable, within_limits
        cells with a stable motion, and those of them that meet the limits that every cell is judged by
    tolerated
        those of the latter with stable motion at all corners of the tolerances, or of the share that the required
        yield takes; null where neither counts
    no_cell_tolerates_percent : %
        if there are none, a share of the tolerances at which there are none either; else null
    yield_takes_percent : %
        share of the tolerances at whose corners the best design has stable motion, so that it reaches the required
        yield; null where none below 100 % is required, or it is not reached
    judged
        number of designs judged
    candidates, candidates_judged
        cells that could be better, or could meet the requirements if no known design does, and how many of them were
        judged, none of which meets the requirements
    best_cell : `unit`
        best value of a cell that meets all requirements; null without a best design
    largest_step : `unit`
        largest difference between neighbouring cells near the best design
    no_cell_has_margin_percent : %
        a margin that no cell within the limits has; null where it was not looked for
    proved_bound : `unit`
        value that no design in the ranges that meets the requirements exceeds, proved; null where none is known
    cells_elsewhere
        parts of the grid that may hold a better design and were not refined from
    """

    cells: list[int]
    stable: int
    within_limits: int
    tolerated: int | None
    no_cell_tolerates_percent: float | None
    yield_takes_percent: float | None
    judged: int
    candidates: int
    candidates_judged: int
    best_cell: float | None
    largest_step: float
    no_cell_has_margin_percent: float | None
    proved_bound: float | None
    cells_elsewhere: int


class OptimiseData(ResultsBlock, frozen=True, kw_only=True):
    """What a search for the best design comes to: optimise.json without its version and provenance.

    Attributes
    ----------
    objective, sense, unit
        what is made largest or smallest (`maximise` or `minimise`), and its unit
    limits_by_default
        what is required by default, by the keys of requirements
    best
        the best design, before it was rounded; null where none meets the requirements
    built
        the best design, rounded; null where none is
    nearest
        without a best design, the one whose worst requirement is nearest to being met; else null
    front
        the best designs for rising margins
    evidence
        what is known of other designs
    """

    objective: Objective
    sense: str
    unit: str
    limits_by_default: dict[str, float | bool]
    best: SearchedDesign | None
    built: SearchedDesign | None
    nearest: SearchedDesign | None
    front: list[SearchedDesign]
    evidence: SearchEvidenceData
