"""What the report on the paper opens with: how many of its results are confirmed, misprints, or not printed at all.

The macros that say it are in `vireport/paper/templates/words/reproduction.j2`.
"""

from __future__ import annotations

from collections.abc import Iterator

from vireport.paper.reproduction import ReproducedPaper
from vireport.report.printed import place_of, symbol_of
from vireport.study.judging.opening import Opening, Statement, gravest
from vireport.study.judging.verdict import Status
from vireport.text.said import words_of

_said = words_of("reproduction")

SIMULATED_ALIKE = 1e-9
"""Difference in velocity [y_c] and phase [rad] up to which the simulation comes to the solved motion."""


def paper_opening(paper: ReproducedPaper) -> Opening:
    """Choose what the report on the paper opens with."""
    confirmed, differing, silent = (len(paper.agreeing(agrees)) for agrees in (True, False, None))
    printed, gone = paper.printed, paper.printed - confirmed - differing
    facts = gravest([*_differing(paper), *_table_1(paper), *_simulated(paper)])
    if paper.overrides:
        return Opening(
            Status.NEUTRAL,
            _said("word_changed"),
            _said("changed_and_gone" if gone else "changed", list(paper.overrides), confirmed, printed, gone),
            facts,
            (Statement(Status.NEUTRAL, _said("tile_same", confirmed, printed)), *_tiles(paper)),
        )
    tiles = (
        Statement(Status.GOOD, _said("tile_confirmed", confirmed, printed)),
        Statement(Status.CAUTION, _said("tile_misprints", differing)),
        Statement(Status.NEUTRAL, _said("tile_silent", silent)),
        *_tiles(paper),
    )
    sentence = _said("sentence", confirmed, printed, differing, silent)
    return Opening(Status.GOOD, _said("word", confirmed, printed), sentence, facts, tiles)


def _differing(paper: ReproducedPaper) -> Iterator[Statement]:
    """The numbers that differ from the print, each kind of a place once."""
    places = [
        (symbol_of(row), place_of(row, one.case.panels))
        for one in paper.compared
        for row in one.rows
        if row.agrees is False
    ]
    names = [_said("of_place", symbol, place) for symbol, place in dict.fromkeys(places)]
    if names:
        yield Statement(Status.CAUTION, _said("differing" if paper.overrides else "misprinted", names))


def _table_1(paper: ReproducedPaper) -> Iterator[Statement]:
    alike, printed = paper.intervals
    if alike == printed:
        yield Statement(Status.GOOD, _said("table_1_holds", printed))
    else:
        yield Statement(Status.CAUTION, _said("table_1_differs", printed - alike, printed))


def _simulated(paper: ReproducedPaper) -> Iterator[Statement]:
    difference = paper.simulation_difference
    if difference is None:
        yield Statement(Status.CAUTION, _said("not_simulated"))
    elif difference > SIMULATED_ALIKE:
        yield Statement(Status.BAD, _said("simulated_otherwise", difference))
    else:
        yield Statement(Status.GOOD, _said("simulated", difference))


def _tiles(paper: ReproducedPaper) -> Iterator[Statement]:
    alike, printed = paper.intervals
    status = Status.GOOD if alike == printed else Status.CAUTION
    yield Statement(status, _said("tile_table_1", alike, printed))
