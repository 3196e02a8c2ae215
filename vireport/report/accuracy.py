"""The section on accuracy and run time: what was measured, what each method reaches and how soon, and what failed."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.gate import capital
from vireport.report.pages import Block, Paragraph, Subheading, Table, numbers, texts
from vireport.trust import (
    ACCURACIES,
    WorkPrecision,
    about_times,
    factor_head,
    factor_rows,
    failure_rows,
    order_rows,
    power,
    reference_rows,
    setup,
    summary_rows,
    task_name,
    verdicts,
    without_guess,
)

MOST_FAILURES = 24
"""Rows of the table of failures; the command line gives them all."""


def accuracy(work: WorkPrecision) -> Iterator[Block]:
    """Blocks of the section; the diagram is to stand after the first two."""
    yield Paragraph(setup(work))
    if work.yardstick is None:
        return
    yield Table(
        "Quantities in 40-digit arithmetic, and the errors of the closed form",
        (*texts("Quantity"), *numbers("Reference", "Closed form", "Whole sweep, no guess")),
        tuple(reference_rows(work)),
        "Errors are relative, and in rad for the phase.",
    )
    for task in work.tasks:
        yield Table(
            f"Time to an accuracy: {task_name(work, task)}",
            (
                *texts("Method"),
                *numbers(*(f"to {power(a)}" for a in ACCURACIES), "Least error", "Evaluations", "Failed"),
            ),
            tuple(summary_rows(work, task)),
            "Median and quartiles of the fastest run with no larger error of any quantity; a dash where there is none. "
            "Least error and evaluations are of the most accurate run. The whole sweep needs no guess, and finds "
            "everything.",
        )
    yield Subheading("Which method is the soonest")
    for accuracy_wanted in ACCURACIES:
        yield Paragraph(" ".join(verdicts(work, accuracy_wanted)))
    yield Table(
        "How many times the time of the soonest",
        (*texts("Method"), *numbers(*factor_head(work))),
        tuple(factor_rows(work)),
        "All from the guess. A dash: the accuracy is not reached.",
    )
    if said := list(without_guess(work)):
        yield Paragraph(" ".join(said))
    if orders := tuple(order_rows(work)):
        yield Table(
            "Orders of convergence",
            (*texts("Method", "Of", "Against"), *numbers("Range", "Fitted", "Theory")),
            orders,
            "Least squares of the logarithms over the runs with an error below 3 % and above rounding. Against "
            "evaluations, the order is that of the method, as far as the interpolant on which SciPy finds the impact "
            "lets it be. LSODA varies its order.",
        )
    lost = list(failure_rows(work))
    if lost:
        more = len(lost) - MOST_FAILURES
        yield Table(
            "Runs that failed",
            texts("Method", "Task", "Setting", "Reason"),
            tuple((name, capital(task), setting, reason) for name, task, setting, reason in lost[:MOST_FAILURES]),
            f"and {more} more" if more > 0 else "",
        )
    yield Paragraph(about_times(work))
