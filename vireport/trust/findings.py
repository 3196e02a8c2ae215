"""What the runs of solvers on stiff membranes say of them, in sentences."""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose, log10
from typing import cast

from vireport.text import (
    TIMES,
    significant,
    words,
)
from vireport.trust.compliance import Compliance
from vireport.trust.compliant_orbits import CompliantOrbit
from vireport.trust.penalty import EXPLICIT, FIXED, Outcome, SolverRun

USEFUL = 1e-4
"""Error at which solvers are compared: a hundredth of what is called wrong."""


def findings(made: Compliance) -> Iterator[str]:
    """What the runs say on explicit and implicit methods, from their numbers."""
    factors = sorted({run.factor for run in made.runs})
    if not factors:
        return
    last = factors[-1]
    for name, setting in dict.fromkeys((run.solver, run.setting) for run in made.runs):
        runs = [run for run in made.runs if (run.solver, run.setting) == (name, setting)]
        failed = [run for run in runs if run.outcome is not Outcome.SOLVED]
        if failed:
            told = setting_text(name, setting)
            kind = f"{told} steps per period" if name == FIXED else f"tolerance {told}"
            yield f"{name} with {kind} fails {'; '.join(_ways(made, failed))}."
    fixed = [run for run in made.runs if run.solver == FIXED and run.outcome is Outcome.SOLVED]
    if fixed:
        least = min(_contact_steps(made, run) for run in fixed)
        yield (
            f"{FIXED}, of fixed step, was right with {significant(least, 2)} steps or more in the shorter contact: "
            f"the steps it needs per period grow as K^{significant(made.order, 3)}."
        )
    if len(factors) > 1:
        grown = {name: _growth(made, name, factors[0], last) for name in EXPLICIT if name != FIXED}
        told = " and ".join(f"{significant(g, 2)} ({name})" for name, g in grown.items() if g is not None)
        shorter = float(f"{(last / factors[0]) ** made.order:.2g}")
        if told:
            yield (
                f"From K times {factor_text(factors[0])} to {factor_text(last)} the evaluations of adaptive explicit "
                f"methods grow at the most by a factor of {told}; steps of one length would have to become "
                f"{shorter:g} times as short. They stay viable: the contact is "
                "short, but no harder in its own time. Accuracy limits the step there, for implicit methods too, and "
                "not stability."
            )
    good = [run for run in made.runs if run.factor == last and run.error is not None and run.error <= USEFUL]
    if good:
        told = ", ".join(f"{run.solver} {significant(1e3 * run.seconds, 2)} ms" for run in _quickest(good))
        yield f"Quickest to an error below {factor_text(USEFUL)} at K times {factor_text(last)}: {told}."


def _ways(made: Compliance, failed: list[SolverRun]) -> Iterator[str]:
    """At which stiffnesses a solver fails in which way."""
    for outcome in dict.fromkeys(run.outcome for run in failed):
        same = [run for run in failed if run.outcome is outcome]
        at = ", ".join(factor_text(run.factor) for run in same)
        yield f"at K times {at}: {outcome.value}{_in_contact(made, same[0])}"


def _quickest(runs: list[SolverRun]) -> list[SolverRun]:
    """The quickest run of each solver, the quickest of all first."""
    best: dict[str, SolverRun] = {}
    for run in sorted(runs, key=lambda run: run.seconds):
        best.setdefault(run.solver, run)
    return list(best.values())


def _in_contact(made: Compliance, run: SolverRun) -> str:
    return f" ({significant(_contact_steps(made, run), 2)} steps in the shorter contact)" if run.solver == FIXED else ""


def _contact_steps(made: Compliance, run: SolverRun) -> float:
    """How many steps of a fixed-step run fall into the shorter contact."""
    orbit = cast(CompliantOrbit, next(rung.orbit for rung in made.rungs if rung.factor == run.factor))
    return run.setting * min(orbit.bottom.duration, orbit.top.duration) / (2 * made.periods)


def _growth(made: Compliance, name: str, first: float, last: float) -> float | None:
    """Largest growth of the evaluations from the softest to the stiffest membrane; None where a run failed."""
    runs = [run for run in made.runs if run.solver == name and run.factor in (first, last)]
    if any(run.outcome is not Outcome.SOLVED for run in runs):
        return None
    work = {(run.setting, run.factor): run.evaluations for run in runs}
    return max(work[setting, last] / work[setting, first] for setting, factor in work if factor == first)


def setting_text(solver: str, setting: float) -> str:
    """A tolerance, or a number of steps."""
    return str(int(setting)) if solver == FIXED else factor_text(setting)


def factor_text(value: float) -> str:
    """A power of ten, or the number."""
    power = round(log10(value))
    if power and isclose(value, 10.0**power, rel_tol=1e-12) and abs(power) > 1:
        return words(f"1e{power:+03d}").removeprefix(f"1 {TIMES} ")
    return significant(value, 3)
