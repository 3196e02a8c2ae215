"""The section on the simulation: whether it ends where the formulae say, and where else it ends."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.report.pages import Block, Paragraph
from vireport.study import Study
from vireport.text import Table, numbers, significant, texts
from vireport.trust import CrossCheck

MOST_ROWS = 12
"""Of a table that could grow with the samples."""


def simulation(study: Study) -> Iterator[Block]:
    """The cross-check, the share of starts that reach the 1:1 motion, and the motions found."""
    check = study.crosscheck
    if check is None:
        return
    swept = check.parameter
    starts = len(check.found[0])
    yield Paragraph(
        f"The rigid-impact model is simulated from impact to impact at {len(check.values)} "
        f"value{'s' * (len(check.values) != 1)} of the {swept.quantity}, from {starts} "
        f"starting state{'s' * (starts != 1)} at each and from beside each stable orbit. The simulation knows the "
        "flight and the impact law, and nothing of the equations of the periodic motions."
    )
    yield Table("Simulation against solution", texts("Question", "Answer"), tuple(_answers(check)))
    if check.misses:
        rows = tuple((swept.show(miss.sweep_value, 9), miss.found) for miss in check.misses[:MOST_ROWS])
        more = len(check.misses) - len(rows)
        yield Table(
            "Orbits that the simulation left",
            (*numbers(f"{swept.symbol}"), *texts("It ended as")),
            rows,
            f"and {more} more" if more else "",
        )
    total = sum(check.words.values())
    ends = tuple(
        (word, str(count), f"{significant(100 * count / total, 3)} %")
        for word, count in list(check.words.items())[:MOST_ROWS]
    )
    yield Table(
        "Where the starts end",
        (*texts("Motion"), *numbers("Starts", "Share")),
        ends,
        "B and T are impacts on the bottom and on the top in one period; a tilde marks chatter that ends in sticking.",
    )


def _answers(check: CrossCheck) -> Iterator[tuple[str, str]]:
    yield "Stable orbits checked", str(check.orbits)
    if check.orbits:
        agreeing = check.orbits - len(check.misses)
        yield "Found again by the simulation", f"{agreeing} of {check.orbits}"
        yield "Largest difference in velocity", f"{significant(check.velocity_difference, 2)} of the unit y_c"
        yield "Largest difference in phase", f"{significant(check.phase_difference, 2)} rad"
        yield "Tolerance", significant(check.tolerance, 2)
        yield "Cross-check", "passed" if check.passed else "failed: the verdict is withheld"
    if check.share is not None:
        share, low, high = (significant(100 * x, 3) for x in check.share)
        yield (
            "Starts that reach the 1:1 motion",
            f"{check.reached} of {check.trials}: {share} % (95 % interval {low} % to {high} %)",
        )
