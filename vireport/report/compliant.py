"""The section on compliant membranes: whether the rigid model is good enough, and how solvers cope with stiff ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import cast

from vireport.gate import capital
from vireport.report.pages import Block, Figure, Paragraph, Subheading, Table, numbers, texts
from vireport.text import (
    ABSENT,
    percent,
    quantity,
    significant,
)
from vireport.trust import (
    FAIR_MARGIN,
    GOOD_MARGIN,
    GRADES,
    WRONG,
    Compliance,
    CompliantOrbit,
    Convergence,
    Outcome,
    Rigid,
    Rung,
    SolverRun,
    factor_text,
    findings,
    phase_shift,
    setting_text,
)

SHORT = {
    Outcome.SOLVED: "",
    Outcome.WRONG: "wrong",
    Outcome.MISSED: "missed",
    Outcome.STEP: "no step",
    Outcome.OVERFLOW: "overflow",
    Outcome.BUDGET: "gave up",
}
"""Ways to fail, short enough for a cell."""

MULTIPLE = 2.0
"""From there on a share is told as a multiple."""


def compliant(made: Compliance, figure: Figure | None = None) -> Iterator[Block]:
    """The verdict, what moves from the rigid model, its rate, and what solvers make of the equation.

    Parameters
    ----------
    made : Compliance
    figure : Figure, optional
        That of `compliant_figure`.
    """
    yield Paragraph(verdict(made))
    if made.own is None:
        return
    yield Paragraph(
        "The rigid impact is the limit of a contact with the force K δ^h. Here the ball meets membranes with that "
        "force and the damping of Hunt and Crossley, which gives each contact the restitution of the scenario where "
        "no other force acts; gravity and the forcing act on during the contact. The motion followed is "
        f"{cast(Rigid, made.rigid).chosen}."
    )
    if made.own.orbit is not None:
        yield Table(
            "Rigid and compliant membranes",
            (*texts("Quantity"), *numbers("Rigid", "Compliant", "Shift")),
            tuple(_compared(made, made.own.orbit)),
            "Velocities are those at the touch. A rigid impact has no deflection: the value is that of (5.5). The "
            "voltages by the deflections take the damping into account, which (5.5) does not.",
        )
        yield Table(
            "Is the rigid model good enough?",
            (*texts("Criterion"), *numbers("Shift", "Good up to", "With care up to"), *texts("Answer")),
            tuple(_judged(made)),
            "The shift of a critical point is over its distance from the motion, which is the margin.",
        )
    yield from _ladder(made)
    if figure is not None:
        yield figure
    if made.runs:
        yield Subheading("Solvers on the stiff equation")
        yield from _solvers(made)


def plain_text(made: Compliance) -> list[str]:
    """The same in lines for a terminal: the verdict, the rates and the findings on the solvers."""
    lines = [verdict(made)]
    if made.own is not None and made.own.orbit is not None:
        rows = tuple(_compared(made, made.own.orbit))
        rows = (("", "rigid", "compliant", "shift"), *rows)
        first, *others = (max(len(row[k]) for row in rows) for k in range(4))
        lines += [
            f"  {row[0]:<{first}}  {'  '.join(f'{cell:>{w}}' for cell, w in zip(row[1:], others, strict=True))}"
            for row in rows
        ]
    lines += [f"  {_rate(made, one)}" for one in made.convergence if one.exponent is not None]
    lines += [f"  {finding}" for finding in findings(made)]
    return [line.replace("*", "") for line in lines]


def verdict(made: Compliance) -> str:
    """Whether rigid impacts are good enough here, and which criterion says so."""
    own = made.own
    if own is None:
        return f"Rigid and compliant membranes were not compared: {made.reason}."
    if own.orbit is None:
        lost = _told(own.reason)
        return f"The rigid model is not good enough here: on the compliant membranes the motion is {lost}."
    if not own.orbit.stable:
        return "The rigid model is not good enough here: on the compliant membranes the motion is no longer stable."
    share = max(own.orbit.bottom.duration, own.orbit.top.duration) / 2
    head = f"Contacts last up to {percent(share, 2)} of the forcing period. "
    if made.critical is not None and own.critical_value is None:
        return (
            f"{head}The rigid model is not good enough here: followed from stiff membranes to softer ones, "
            f"{made.critical.label} is {_told(own.reason)}."
        )
    if made.grade == 0:
        return f"{head}The rigid model is good enough here by all criteria."
    why = "; ".join(moved(made, grade=made.grade or 0))
    return f"{head}The rigid model is {GRADES[made.grade or 0]} here: {why}."


def moved(made: Compliance, grade: int) -> Iterator[str]:
    """By how much the quantities move that a grade is given for, in words."""
    for c in made.criteria:
        if c.grade == grade:
            if made.critical is not None and c.name == made.critical.label:
                yield f"{c.name} moves by {margins(c.shift)} to it, {_side(made)} the motion"
            else:
                yield f"{c.name} shifts by {percent(c.shift, signed=True)}"


def margins(share: float) -> str:
    """Print a share of the margin: in per cent, or as a multiple."""
    size = abs(share)
    return f"{percent(size)} of the margin" if size < MULTIPLE else f"{float(f'{size:.2g}'):g} times the margin"


def _side(made: Compliance) -> str:
    """To which side of its rigid value the critical point moves."""
    at, value = made.critical.point.sweep_value, made.own.critical_value  # type: ignore[union-attr]
    return "towards" if (cast(float, value) - at) * (made.design_value - at) > 0 else "away from"


def _told(reason: str) -> str:
    """A reason, with what it says after a colon in brackets."""
    what, colon, why = reason.partition(": ")
    return f"{what} ({why.replace(': ', ', ')})" if colon else reason


def _judged(made: Compliance) -> Iterator[tuple[str, ...]]:
    """Each criterion: shift, limits and answer; a critical point that is lost has no shift."""
    for c in made.criteria:
        name, shift = _criterion(made, c.name), percent(c.shift, 3, signed=True)
        yield name, shift, percent(c.good), percent(c.fair), capital(GRADES[c.grade])
    if made.critical is not None and made.own is not None and made.own.critical_value is None:
        name = _criterion(made, made.critical.label)
        yield name, "lost", percent(GOOD_MARGIN), percent(FAIR_MARGIN), capital(GRADES[2])


def _criterion(made: Compliance, name: str) -> str:
    label = made.critical.label if made.critical is not None else None
    return f"{name} over the margin to it" if name == label else capital(name)


def _compared(made: Compliance, orbit: CompliantOrbit) -> Iterator[tuple[str, str, str, str]]:
    rigid, (length, _, _) = cast(Rigid, made.rigid), made.units
    alone = made.alone
    for name, touch, speed, phase in (
        ("bottom", orbit.bottom, rigid.velocity_bottom, rigid.phase_bottom),
        ("top", orbit.top, rigid.velocity_top, rigid.phase_top),
    ):
        shift = phase_shift(touch.phase, phase)
        share = touch.velocity / speed - 1
        yield (
            f"Velocity, {name} [y_c]",
            significant(speed, 5),
            significant(touch.velocity, 5),
            percent(share, 3, signed=True),
        )
        yield f"Phase, {name} [rad]", significant(phase, 5), significant(touch.phase, 5), significant(shift, 3)
        yield f"Contact over forcing period, {name}", "0 %", percent(touch.duration / 2, 3), ABSENT
        if alone is not None:
            low = alone.elastic_deflection[0 if name == "bottom" else 1]
            depth = touch.deflection
            yield (
                f"Deflection, {name}", quantity(length * float(low), "m", 3),
                quantity(length * depth, "m", 3), percent(depth / float(low) - 1, 2, signed=True),
            )  # fmt: skip
        yield (
            f"Restitution with the forcing, {name}",
            significant(made.restitution, 4),
            significant(touch.restitution, 4),
            percent(touch.restitution / made.restitution - 1, 2, signed=True),
        )
    if made.critical is not None and made.own is not None:
        swept, at, value = made.varied, made.critical.point.sweep_value, made.own.critical_value
        moved = ABSENT if value is None else percent(value / at - 1, 3, signed=True)
        found = "lost" if value is None else swept.show(value, 6)
        yield f"{made.critical.label}, {swept.symbol}", swept.show(at, 6), found, moved
    if made.volts is not None:
        v = made.volts
        for name, volts in (("velocities", v.by_velocity), ("deflections", v.by_deflection)):
            moved = percent(volts / v.rigid - 1, 3, signed=True)
            yield f"U_ave by the {name}", quantity(v.rigid, "V", 4), quantity(volts, "V", 4), moved


def _ladder(made: Compliance) -> Iterator[Block]:
    label = made.critical.label if made.critical is not None else "critical point"
    columns = ("K times", "Contact over period", "Velocity", "Phase [rad]", label)
    rows = tuple(
        (factor_text(rung.factor), _share(rung), *(significant(one.distances[k], 3) for one in made.convergence))
        for k, rung in enumerate(made.rungs)
    )
    fitted = (*("Exponent of K", ABSENT), *(significant(one.exponent, 4) for one in made.convergence))
    theory = ("Expected", ABSENT, *(significant(-made.order, 4) for _ in made.convergence))
    yield Table(
        "Distance from the rigid model",
        numbers(*columns),
        (*rows, fitted, theory),
        "Of velocity and phase at the bottom and of the critical point: relative, but for the phase. The exponents are "
        "fitted to the stiffest membranes; a contact lasts in proportion to K^(−1/(h+1)), and everything should come "
        "near at that rate.",
    )
    for rung in made.rungs:
        if rung is not made.own and rung.reason and (rung.orbit is None or made.critical is not None):
            what = "the motion" if rung.orbit is None else label
            yield Paragraph(f"With K times {factor_text(rung.factor)}, {what} is {_told(rung.reason)}.")


def _share(rung: Rung) -> str:
    if rung.orbit is None:
        return ABSENT
    return percent(max(rung.orbit.bottom.duration, rung.orbit.top.duration) / 2, 3)


def _rate(made: Compliance, one: Convergence) -> str:
    name = made.critical.label if one.quantity == "critical value" and made.critical is not None else one.quantity
    found, expected = significant(one.exponent, 4), significant(-made.order, 4)
    return f"{capital(name)} tends to its rigid value as K^({found}); expected K^({expected})"


def _solvers(made: Compliance) -> Iterator[Block]:
    yield Paragraph(
        "Each solver takes the whole equation over one period in one go, without being told of the contacts. It starts "
        "on the accurate motion, so that the distance from it at the end is the error. "
        f"An error of {significant(WRONG, 2)} or more is called wrong."
    )
    for finding in findings(made):
        yield Paragraph(finding)
    factors = sorted({run.factor for run in made.runs})
    columns = (*texts("Solver"), *numbers("Setting", *(f"K times {factor_text(f)}" for f in factors)))
    cells = {(run.solver, run.setting, run.factor): run for run in made.runs}
    settings = list(dict.fromkeys((run.solver, run.setting) for run in made.runs))

    def rows(show: Callable[[SolverRun], str]) -> tuple[tuple[str, ...], ...]:
        return tuple(
            (name, setting_text(name, setting), *(show(cells[name, setting, f]) for f in factors))
            for name, setting in settings
        )

    yield Table(
        "Error at the end of the period", columns, rows(_error),
        "Dimensionless distance in (Z, Z\u2032). The setting is the relative tolerance, of RK4 the number of steps. "
        "Wrong: it arrived elsewhere. Gave up: too many evaluations.",
    )  # fmt: skip
    yield Table(
        "Evaluations, and run time in ms",
        columns,
        rows(_work),
        "Times are medians on the machine that made this report.",
    )


def _error(run: SolverRun) -> str:
    failed = SHORT[run.outcome]
    shown = "" if run.error is None else significant(run.error, 2)
    return " ".join(filter(None, (shown, failed)))


def _work(run: SolverRun) -> str:
    return f"{run.evaluations} / {significant(1e3 * run.seconds, 2)}"
