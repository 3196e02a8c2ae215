"""The comparison with compliant membranes: verdict and tables, for the report and for the terminal, and findings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import isclose, log10
from typing import ClassVar, cast

from vireport.membranes.compliance import (
    Compared,
    Compliance,
    Convergence,
    Grade,
    Unit,
)
from vireport.membranes.compliant_motion import CompliantOrbit
from vireport.membranes.stiff_solvers import (
    EXPLICIT,
    FIXED,
    WRONG,
    Outcome,
    SolverRun,
)
from vireport.scenario import Parameter
from vireport.text import (
    ABSENT,
    TIMES,
    Table,
    capital,
    numbers,
    percent,
    quantity,
    significant,
    texts,
    words,
)

USEFUL = 1e-4
"""Error at which solvers are compared: a hundredth of what is called wrong."""

MULTIPLE = 2.0
"""From there on a share is printed as a multiple."""

SHORT = {
    Outcome.SOLVED: "",
    Outcome.WRONG: "wrong",
    Outcome.MISSED: "missed",
    Outcome.STEP: "no step",
    Outcome.OVERFLOW: "overflow",
    Outcome.BUDGET: "gave up",
}
"""Ways to fail, short enough for a cell."""


def verdict(comparison: Compliance) -> str:
    """Whether rigid impacts are good enough here, and which criterion says so."""
    own = comparison.own
    if own is None:
        return f"Rigid and compliant membranes were not compared: {comparison.reason}."
    if own.orbit is None:
        lost = _bracketed(own.reason)
        return f"The rigid model is not good enough here: on the compliant membranes the motion is {lost}."
    if not own.orbit.stable:
        return "The rigid model is not good enough here: on the compliant membranes the motion is no longer stable."
    head = f"Contacts last up to {percent(own.orbit.longest_contact / 2, 2)} of the forcing period. "
    if comparison.critical is not None and own.critical_value is None:
        return (
            f"{head}The rigid model is not good enough here: followed from stiff membranes to softer ones, "
            f"{comparison.critical.label} is {_bracketed(own.reason)}."
        )
    if comparison.grade in (None, Grade.GOOD):
        return f"{head}The rigid model is good enough here by all criteria."
    return f"{head}The rigid model is {comparison.grade.words} here: {'; '.join(_moved(comparison))}."


def comparison_with_rigid(comparison: Compliance) -> Iterator[Table]:
    """What moves from the rigid model, and the rate at which it tends to it."""
    if comparison.own is None:
        return
    if comparison.quantities:
        yield Table(
            "Rigid and compliant membranes",
            (
                *texts("Quantity"),
                *numbers("Rigid", "Compliant", "Shift", "Good up to", "With care up to"),
                *texts("Is the rigid model good enough?"),
            ),
            tuple(map(_compared_row, comparison.quantities)),
            "Velocities are those at the touch. A rigid impact has no deflection: the value is that of (5.5). The "
            "voltages by the deflections take the damping into account, which (5.5) does not.",
        )
    yield _ladder(comparison)


def lost(comparison: Compliance) -> Iterator[tuple[float, str, str]]:
    """Factors of K other than 1 with which the motion or the critical point is lost: factor, which of them, and why."""
    label = comparison.critical.label if comparison.critical is not None else ""
    for rung in comparison.rungs:
        if rung is not comparison.own and rung.reason and (rung.orbit is None or label):
            yield rung.factor, "the motion" if rung.orbit is None else label, _bracketed(rung.reason)


def solvers_on_stiff_membranes(comparison: Compliance) -> Iterator[Table]:
    """What solvers make of the equation as it stands: errors, evaluations and times."""
    if not comparison.runs:
        return
    factors = sorted({run.factor for run in comparison.runs})
    columns = (*texts("Solver"), *numbers("Setting", *(f"K times {factor_text(f)}" for f in factors)))
    runs = {(run.solver, run.setting, run.factor): run for run in comparison.runs}
    ladder = dict.fromkeys((run.solver, run.setting) for run in comparison.runs)

    def rows(show: Callable[[SolverRun], str]) -> tuple[tuple[str, ...], ...]:
        return tuple(
            (solver, setting_text(solver, setting), *(show(runs[solver, setting, f]) for f in factors))
            for solver, setting in ladder
        )

    yield Table(
        "Error at the end of the period",
        columns,
        rows(_error),
        "Dimensionless distance in (Z, Z\u2032). The setting is the relative tolerance, of RK4 the number of steps. "
        "Wrong: it arrived elsewhere. Gave up: too many evaluations.",
    )
    yield Table(
        "Evaluations, and run time in ms",
        columns,
        rows(lambda run: f"{run.evaluations} / {significant(1e3 * run.seconds, 2)}"),
        "Times are medians on the machine that made this report.",
    )


@dataclass(frozen=True, slots=True)
class Findings:
    """What the runs say of explicit and implicit methods.

    Attributes
    ----------
    failed : tuple
        Solver, setting, and the factors of K with the ways to fail in a word.
    first, last : float
        The least and the largest factor of K.
    steps : float or None
        Of the fixed-step method in the shorter contact, fewest with which it was right.
    growths : dict
        Of the evaluations from the first to the last factor, at the most, of adaptive explicit methods.
    shorter : float
        By how much a contact is shorter at the last factor.
    fastest : tuple
        Solvers that reach `USEFUL` at the last factor, each with its time [s], the fastest first.
    """

    wrong: ClassVar[float] = WRONG
    useful: ClassVar[float] = USEFUL
    failed: tuple[tuple[str, float, tuple[tuple[float, str], ...]], ...]
    first: float
    last: float
    steps: float | None
    growths: dict[str, float]
    shorter: float
    fastest: tuple[tuple[str, float], ...]


def findings(comparison: Compliance) -> Findings:
    """What the runs, of which there are some, come to."""
    factors = [run.factor for run in comparison.runs]
    first, last = min(factors), max(factors)
    failed: dict[tuple[str, float], list[tuple[float, str]]] = {}
    for run in comparison.runs:
        if run.outcome is not Outcome.SOLVED:
            failed.setdefault((run.solver, run.setting), []).append((run.factor, SHORT[run.outcome]))
    fixed = [run for run in comparison.runs if run.solver == FIXED and run.outcome is Outcome.SOLVED]
    growths = {name: _growth(comparison, name, first, last) for name in EXPLICIT if name != FIXED and first < last}
    good = [run for run in comparison.runs if run.factor == last and run.error is not None and run.error <= USEFUL]
    return Findings(
        tuple((*key, tuple(ways)) for key, ways in failed.items()),
        first,
        last,
        min((_contact_steps(comparison, run) for run in fixed), default=None),
        {name: growth for name, growth in growths.items() if growth is not None},
        (last / first) ** comparison.order,
        tuple((run.solver, run.seconds) for run in _fastest_of_each(good)),
    )


def quantity_label(comparison: Compliance, convergence: Convergence) -> str:
    """Name of a quantity that converges; of the critical value, the label of the point."""
    if convergence.quantity == "critical value" and comparison.critical is not None:
        return comparison.critical.label
    return convergence.quantity


def setting_text(solver: str, setting: float) -> str:
    """A tolerance, or a number of steps."""
    return str(int(setting)) if solver == FIXED else factor_text(setting)


def factor_text(value: float) -> str:
    """A power of ten, or the number."""
    power = round(log10(value))
    if power and isclose(value, 10.0**power, rel_tol=1e-12) and abs(power) > 1:
        return words(f"1e{power:+03d}").removeprefix(f"1 {TIMES} ")
    return significant(value, 3)


def _moved(comparison: Compliance) -> Iterator[str]:
    """By how much the quantities move that the grade is given for, in words."""
    for compared in comparison.quantities:
        c = compared.criterion
        if c is None or c.grade != comparison.grade:
            continue
        if not isinstance(compared.unit, Parameter):
            yield f"{c.name} shifts by {percent(c.shift, signed=True)}"
            continue
        size, side = abs(c.shift), "towards" if (compared.shift or 0.0) < 0 else "away from"
        share = f"{percent(size)} of the margin" if size < MULTIPLE else f"{float(f'{size:.2g}'):g} times the margin"
        yield f"{c.name} moves by {share} to it, {side} the motion"


def _bracketed(reason: str) -> str:
    """A reason, with what it says after a colon in brackets."""
    what, colon, why = reason.partition(": ")
    return f"{what} ({why.replace(': ', ', ')})" if colon else reason


def _compared_row(compared: Compared) -> tuple[str, ...]:
    unit, c = compared.unit, compared.criterion
    name = f"{compared.name} [{unit}]" if unit in (Unit.VELOCITY, Unit.PHASE) else compared.name
    if unit is Unit.PHASE:
        shift = significant(compared.shift, 3)
    else:
        shift = percent(compared.shift, 2 if unit in (Unit.DEPTH, Unit.RATIO) else 3, signed=True)
    limits = ("", "", "") if c is None else (percent(c.good), percent(c.fair), capital(c.grade.words))
    return capital(name), _with_unit(compared.rigid, unit), _with_unit(compared.compliant, unit), shift, *limits


def _with_unit(value: float | None, unit: Unit | Parameter) -> str:
    if value is None:
        return "lost"
    if isinstance(unit, Parameter):
        return unit.show(value, 6)
    if unit is Unit.SHARE:
        return percent(value, 3)
    if unit in (Unit.VOLTAGE, Unit.DEPTH):
        return quantity(value, unit, 4 if unit is Unit.VOLTAGE else 3)
    return significant(value, 4 if unit is Unit.RATIO else 5)


def _ladder(comparison: Compliance) -> Table:
    """Distances from the rigid model on all rungs, and the fitted exponents."""
    label = comparison.critical.label if comparison.critical is not None else "critical point"
    rows = [
        (
            factor_text(rung.factor),
            ABSENT if rung.orbit is None else percent(rung.orbit.longest_contact / 2, 3),
            *(significant(quantity.distances[k], 3) for quantity in comparison.convergence),
        )
        for k, rung in enumerate(comparison.rungs)
    ]
    rows.append(("Exponent of K", ABSENT, *(significant(quantity.exponent, 4) for quantity in comparison.convergence)))
    rows.append(("Expected", ABSENT, *(significant(-comparison.order, 4) for _ in comparison.convergence)))
    return Table(
        "Distance from the rigid model",
        numbers("K times", "Contact over period", "Velocity", "Phase [rad]", label),
        tuple(rows),
        "Of velocity and phase at the bottom and of the critical point: relative, but for the phase. The exponents are "
        "fitted to the stiffest membranes; the duration of a contact goes with the power −1/(h + 1) of K, and "
        "everything should come near at that rate.",
    )


def _error(run: SolverRun) -> str:
    return " ".join(filter(None, ("" if run.error is None else significant(run.error, 2), SHORT[run.outcome])))


def _fastest_of_each(runs: list[SolverRun]) -> list[SolverRun]:
    """The fastest run of each solver, the fastest of all first."""
    best: dict[str, SolverRun] = {}
    for run in sorted(runs, key=lambda run: run.seconds):
        best.setdefault(run.solver, run)
    return list(best.values())


def _contact_steps(comparison: Compliance, run: SolverRun) -> float:
    """How many steps of a fixed-step run fall into the shorter contact."""
    orbit = cast(CompliantOrbit, next(rung.orbit for rung in comparison.rungs if rung.factor == run.factor))
    return run.setting * min(orbit.bottom.duration, orbit.top.duration) / (2 * comparison.periods)


def _growth(comparison: Compliance, name: str, first: float, last: float) -> float | None:
    """Largest growth of the evaluations from the softest to the stiffest membrane; None where a run failed."""
    runs = [run for run in comparison.runs if run.solver == name and run.factor in (first, last)]
    if any(run.outcome is not Outcome.SOLVED for run in runs):
        return None
    work = {(run.setting, run.factor): run.evaluations for run in runs}
    return max(work[setting, last] / work[setting, first] for setting, factor in work if factor == first)
