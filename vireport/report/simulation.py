"""The section on the simulation: whether it ends where the formulae say, and where else it ends."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from vireport.report.pages import Block, Paragraph
from vireport.scenario import Parameter
from vireport.study import Study
from vireport.text import Table, numbers, significant, texts
from vireport.trust import CrossCheck, MotionCount

Floats = NDArray[np.float64]

MOST_ROWS = 12
"""Of a table that could grow with the samples."""

NOTE = "B and T are impacts on the bottom and on the top in one period; a tilde marks chatter that ends in sticking."


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
        f"random start{'s' * (starts != 1)} at each and from beside each stable orbit. The simulation knows the "
        "flight and the impact law, and nothing of the equations of the periodic motions."
    )
    yield Paragraph(
        "A start is the ball in flight: its position uniform between the membranes, its velocity uniform up to "
        f"{_span(check.start_speed)} of the unit y_c in either direction, the forcing phase uniform. Each value has "
        "its own starts, independent of all others and the same in every run. The largest velocity is half as much "
        "again as that of the fastest admissible 1:1 motion at the value, or as 2/(π (1 − r)), which the forcing "
        "sustains without gravity, if that is larger; 1 − r counts as 0.1 at least."
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
    yield _ends_table("Where the starts end", check.motions, swept, NOTE)
    if check.elsewhere:
        yield _ends_table("Where starts end that do not reach a stable 1:1 motion", check.elsewhere, swept)


def _span(speeds: Floats) -> str:
    """Least and largest of some velocities, or the one that they are."""
    return " to ".join(dict.fromkeys(significant(float(end), 3) for end in (speeds.min(), speeds.max())))


def _ends_table(title: str, motions: tuple[MotionCount, ...], swept: Parameter, note: str = "") -> Table:
    total = sum(motion.count for motion in motions)
    rows = tuple(
        (
            motion.name,
            str(motion.count),
            f"{significant(100 * motion.count / total, 3)} %",
            " to ".join(dict.fromkeys(swept.show(end) for end in (motion.low, motion.high))),
        )
        for motion in motions[:MOST_ROWS]
    )
    more = len(motions) - len(rows)
    notes = " ".join(text for text in (f"And {more} more." if more else "", note) if text)
    return Table(title, (*texts("Motion"), *numbers("Starts", "Share", f"At {swept.symbol}")), rows, notes)


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
            "Starts that reach the 1:1 motion, where there is a stable one",
            f"{check.reached} of {check.trials}: {share} % (95 % interval {low} % to {high} %)",
        )
