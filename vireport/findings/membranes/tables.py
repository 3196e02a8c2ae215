"""Tables of the comparison with compliant membranes, for the report and for the terminal.

Verdict, captions, heads and notes are those of ``words/compliant.j2``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.findings.membranes.compliance import Compared, Compliance, Convergence, Unit
from vireport.findings.membranes.solvers import FIXED, RunOutcome, SolverRun
from vireport.scenario.parameters import Parameter
from vireport.text.formatting import ABSENT, ROUGHLY, capital, factor_text, percent, quantity, rounded_text
from vireport.text.tables import Table, worded_table

if TYPE_CHECKING:
    from vireport.text.templates import Words

SHORT = {
    RunOutcome.SOLVED: "",
    RunOutcome.WRONG: "wrong",
    RunOutcome.MISSED: "missed",
    RunOutcome.STEP: "no step",
    RunOutcome.OVERFLOW: "overflow",
    RunOutcome.BUDGET: "gave up",
}
"""Ways to fail, short enough for a cell."""


def verdict(comparison: Compliance, templates: Path | None = None) -> str:
    """The sentence on whether rigid impacts are good enough, and which criterion decides that.

    Parameters
    ----------
    comparison : Compliance
    templates : Path, optional
        A folder whose ``words/compliant.j2`` replaces the package's own, as for the tables.
    """
    judged = ((compared, compared.criterion) for compared in comparison.quantities)
    moved = [compared for compared, of in judged if of is not None and of.grade == comparison.grade]
    return _words(templates)("verdict", comparison, moved)


def comparison_with_rigid(comparison: Compliance, templates: Path | None = None) -> Iterator[Table]:
    """Tables of the shifts from the rigid model, and of the rates at which they vanish with K."""
    if comparison.unscaled is None:
        return
    say = _words(templates)
    if comparison.quantities:
        rows = (_compared_row(compared, say) for compared in comparison.quantities)
        yield worded_table(say, "compared", "tnnnnnt", rows, note=say("compared_note"))
    yield _ladder(comparison, say)


def _words(templates: Path | None) -> Words:
    from vireport.text.templates import Words

    return Words("compliant", templates)


def lost(comparison: Compliance, templates: Path | None = None) -> Iterator[tuple[float, str, str]]:
    """Factors of K other than 1 at which the motion or the critical point is lost: factor, which of both, and why."""
    # A loss with the scenario's own K is told by verdict and table.
    say, label = _words(templates), comparison.critical.label if comparison.critical is not None else ""
    for rung in comparison.rungs:
        if rung is not comparison.unscaled and rung.reason and (rung.orbit is None or label):
            what = say("what_is_lost", "" if rung.orbit is None else label)
            yield rung.factor, what, say("why", rung.reason)


def solvers_on_stiff_membranes(comparison: Compliance, templates: Path | None = None) -> Iterator[Table]:
    """Tables of solvers on the equation with compliant membranes: errors, evaluations and times."""
    if not comparison.runs:
        return
    say, factors = _words(templates), sorted({run.factor for run in comparison.runs})
    kinds, at = f"tn{'n' * len(factors)}", [factor_text(factor) for factor in factors]
    runs = {(run.solver, run.setting, run.factor): run for run in comparison.runs}
    ladder = dict.fromkeys((run.solver, run.setting) for run in comparison.runs)

    def rows(show: Callable[[SolverRun], str]) -> tuple[tuple[str, ...], ...]:
        return tuple(
            (
                solver,
                str(int(setting)) if solver == FIXED else factor_text(setting),  # a number of steps, or a tolerance
                *(show(runs[solver, setting, f]) for f in factors),
            )
            for solver, setting in ladder
        )

    yield worded_table(say, "errors", kinds, rows(_error), at, note=say("errors_note"))
    work = rows(lambda run: f"{run.evaluations} / {rounded_text(1e3 * run.seconds, ROUGHLY)}")
    yield worded_table(say, "times", kinds, work, at, note=say("times_note"))


def quantity_label(comparison: Compliance, convergence: Convergence) -> str:
    """Name of a quantity that converges to its rigid value; for the critical value, the label of the point."""
    if convergence.quantity == "critical value" and comparison.critical is not None:
        return comparison.critical.label
    return convergence.quantity


def _compared_row(compared: Compared, say: Words) -> tuple[str, ...]:
    unit, c = compared.unit, compared.criterion
    name = say("quantity", compared.name, unit if unit in (Unit.VELOCITY, Unit.PHASE) else "")
    shift = rounded_text(compared.shift, ROUGHLY) if unit is Unit.PHASE else percent(compared.shift, signed=True)
    limits = ("", "", "") if c is None else (percent(c.good), percent(c.fair), capital(c.grade.words))
    compliant = say("lost") if compared.compliant is None else _with_unit(compared.compliant, unit)
    return name, _with_unit(compared.rigid, unit), compliant, shift, *limits


def _with_unit(value: float, unit: Unit | Parameter) -> str:
    if isinstance(unit, Parameter):
        return unit.show(value)
    if unit is Unit.SHARE:
        return percent(value)
    if unit in (Unit.VOLTAGE, Unit.DEPTH):
        return quantity(value, unit)
    return rounded_text(value)


def _ladder(comparison: Compliance, say: Words) -> Table:
    """Distances from the rigid model on all rungs, and the fitted exponents."""
    label = comparison.critical.label if comparison.critical is not None else ""
    rows = [
        (
            factor_text(rung.factor),
            ABSENT if rung.orbit is None else percent(rung.orbit.contact_share),
            *(rounded_text(quantity.distances[k], ROUGHLY) for quantity in comparison.convergence),
        )
        for k, rung in enumerate(comparison.rungs)
    ]
    rows.append((say("exponent"), ABSENT, *(rounded_text(quantity.exponent) for quantity in comparison.convergence)))
    rows.append((say("expected"), ABSENT, *(rounded_text(-comparison.order) for _ in comparison.convergence)))
    return worded_table(say, "distance", "nnnnn", rows, label, note=say("distance_note"))


def _error(run: SolverRun) -> str:
    return " ".join(filter(None, ("" if run.error is None else rounded_text(run.error, ROUGHLY), SHORT[run.outcome])))
