"""The records of paper.json, and what a reproduction of the paper gives for them."""

from __future__ import annotations

from vireport.base.records import ResultsBlock
from vireport.paper.reproduction import ReproducedPaper


class PrintedNumberData(ResultsBlock, frozen=True, kw_only=True):
    """A result that the paper prints, and ours.

    Attributes
    ----------
    panels
        panels of Fig. 2 whose sweep it belongs to
    of
        letter of a critical point, figure of a motion, or section
    quantity
        what it is
    d
        as printed for a motion; `null` elsewhere
    printed
        as text, for its digits count; `null` where the paper has a letter alone
    computed
        ours
    agreement
        `to_all_digits`, `cut_off`, `rounding_of_d`, `differs` or `not_printed`
    """

    panels: str
    of: str
    quantity: str
    d: str | None
    printed: str | None
    computed: float
    agreement: str


class IntervalData(ResultsBlock, frozen=True, kw_only=True):
    """An interval of Table 1.

    Attributes
    ----------
    panels
        panels of Fig. 2 whose sweep it belongs to
    family
        `symmetric` or `asymmetric`
    from_point, to_point
        labels of the critical points at its ends; `null` at an end of the sweep
    d_from, d_to
        ends of the interval
    stability, criteria
        type of motion by the solution, and its criterion
    """

    panels: str
    family: str
    from_point: str | None
    to_point: str | None
    d_from: float
    d_to: float
    stability: str
    criteria: str


class PaperData(ResultsBlock, frozen=True, kw_only=True):
    """The object of paper.json.

    Attributes
    ----------
    overrides
        values that replaced those of the paper's scenarios, as `path=value`
    confirmed, misprints, not_printed
        how many results agree with the print, differ from it, and have no number there
    numbers
        every result
    table_1
        the intervals of Table 1 with their numbers
    simulation_difference
        largest difference in velocity [y_c] and phase [rad] between simulated and solved motions of Fig. 3; `null`
        where the simulation comes to none
    """

    overrides: list[str]
    confirmed: int
    misprints: int
    not_printed: int
    numbers: list[PrintedNumberData]
    table_1: list[IntervalData]
    simulation_difference: float | None


def paper_data(paper: ReproducedPaper) -> PaperData:
    """The results of a reproduction as paper.json has them."""
    numbers = [
        PrintedNumberData(
            panels=one.case.panels,
            of=row.of,
            quantity=row.quantity,
            d=row.d or None,
            printed=row.printed or None,
            computed=row.ours,
            agreement=row.agreement,
        )
        for one in paper.compared
        for row in one.rows
    ]
    intervals = [
        IntervalData(
            panels=one.case.panels,
            family=types.family,
            from_point=None if row.start_point is None else row.start_point.label,
            to_point=None if row.end_point is None else row.end_point.label,
            d_from=row.d_start,
            d_to=row.d_end,
            stability=row.stability,
            criteria=row.criteria,
        )
        for one in paper.compared
        for types in one.types
        for row in types.intervals
    ]
    confirmed, misprints, silent = (len(paper.agreeing(agrees)) for agrees in (True, False, None))
    return PaperData(
        overrides=list(paper.overrides),
        confirmed=confirmed,
        misprints=misprints,
        not_printed=silent,
        numbers=numbers,
        table_1=intervals,
        simulation_difference=paper.simulation_difference,
    )
