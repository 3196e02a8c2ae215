"""How far the rigid-impact model is from compliant membranes, and what stiff membranes do to solvers.

The compliant motion (see `compliant`) is followed from the rigid one, where the membranes are infinitely stiff, down
a ladder of stiffnesses to the scenario's own. A contact lasts in proportion to epsilon = K^(-1/(h+1)), so everything
should approach the rigid model at that rate. On each rung the equation is also given to solvers as it is (`penalty`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import (
    BifurcationDiagram,
    CriticalKind,
    CriticalPoint,
    Solution,
    Sweep,
    design_point,
    solve,
)
from vireport.errors import NumericalError
from vireport.physics import (
    Device,
    Membrane,
    contacts,
    law_of,
)
from vireport.scenario import Parameter
from vireport.trust.compliance import Compliance, Rigid, Rung, convergence_of, criteria_of, volts_of
from vireport.trust.compliant import compliant_model
from vireport.trust.compliant_orbits import find_critical, find_orbit
from vireport.trust.penalty import SolverRun, problem, runs

if TYPE_CHECKING:
    from vireport.progress import Progress

Floats = NDArray[np.float64]

LADDER = (1.0, 1e2, 1e4, 1e6, 1e8)
"""Factors of the stiffness."""

SHORTEST = 1 / 8
"""Share of the way in epsilon below which no smaller step is tried where a motion is lost."""

MULTIPLIER = {CriticalKind.PERIOD_DOUBLING: -1.0, CriticalKind.FOLD: 1.0}
"""Of the critical points that are followed, the preferred kind first."""


def compliance(
    solution: Solution, ladder: Sequence[float] = LADDER, repeats: int = 3, progress: Progress | None = None
) -> Compliance:
    """Compare the rigid model with compliant membranes, and try solvers on them.

    Parameters
    ----------
    solution : Solution
    ladder : sequence of float
        Positive factors of K; 1 is added where it is missing.
    repeats : int
        Of each run, for its median time.
    progress : callable, optional
        Told each long step as it begins.
    """
    tell = progress or (lambda _: None)
    membrane = solution.membrane
    if membrane is None:
        return Compliance("the contact needs the ball's mass: device.ball_mass_kg is not given")
    chosen = chosen_motion(solution)
    if chosen is None:
        return Compliance("there is no stable 1:1 motion whose impacts could be compared")
    rigid, device = chosen
    try:
        law_of(membrane.exponent, device.restitution)
    except NumericalError as error:
        return Compliance(str(error), rigid)
    varied, critical = followed(solution, device)
    factors = sorted({1.0, *(float(factor) for factor in ladder)})
    tell("compliant membranes: periodic motions")
    orbits = _descend(factors, membrane.exponent, _orbit_at(device, membrane, rigid))
    tell("compliant membranes: critical points")
    values = _descend(factors, membrane.exponent, _critical_at(device, varied, membrane, critical))
    rungs = tuple(
        Rung(factor, orbit, None if value is None else float(value[-1]), why or why_not)
        for factor, (orbit, why), (value, why_not) in zip(factors, orbits, values, strict=True)
    )
    found: list[SolverRun] = []
    for rung in rungs:
        if rung.orbit is not None:
            tell(f"compliant membranes: solvers at K times {rung.factor:g}")
            model = compliant_model(device, rigid.parameter, rigid.value, membrane, rung.factor)
            found += runs(problem(model, rung.orbit), rung.factor, repeats)
    model = compliant_model(device, varied, float(getattr(device, varied)), membrane)
    made = Compliance(
        rigid=rigid,
        critical=critical,
        varied=varied,
        design_value=float(getattr(device, varied)),
        order=1 / (membrane.exponent + 1),
        restitution=device.restitution,
        periods=device.period_ratio,
        alone=contacts(np.array([rigid.velocity_bottom, rigid.velocity_top]), model.membrane, model.restitution),
        units=(model.length_unit, model.velocity_unit, model.time_unit),
        rungs=rungs,
        runs=tuple(found),
    )
    made = replace(made, convergence=convergence_of(made), volts=volts_of(made, membrane))
    return replace(made, criteria=criteria_of(made))


def chosen_motion(solution: Solution) -> tuple[Rigid, Device] | None:
    """The motion that is followed, and the device that has it: at the design point, or amid the first stable range."""
    design, device = solution.design, solution.device
    chosen = "the stable motion at the design point"
    if design is None or not design.motions.stable.any():
        if not solution.stable_ranges:
            return None
        part = solution.stable_ranges[0]
        device = replace(device, **device.at(part.parameter, (part.start + part.end) / 2))
        design = design_point(device, solution.diagram)
        chosen = "the stable motion in the middle of the first stable range"
    rows = np.flatnonzero(design.motions.stable)
    if not len(rows):
        return None
    m, row = design.motions, rows[0]
    numbers = (float(a[row]) for a in (m.velocity_bottom, m.velocity_top, m.phi_bottom, m.phi_top))
    return Rigid(design.parameter, design.value, chosen, *numbers), device


def followed(solution: Solution, device: Device) -> tuple[Parameter, CriticalPoint | None]:
    """The critical point that is followed, with the parameter that varies: the nearest period doubling, or fold."""
    if solution.diagram is not None:
        return solution.parameter, _nearest(solution.diagram, device, solution.parameter)
    for kind in MULTIPLIER:
        for margin in solution.design.margins if solution.design else ():
            if margin.kind == kind:
                own = float(getattr(device, margin.parameter))
                ends = own - margin.distance / 2, own + 2 * margin.distance
                sweep = Sweep(device, margin.parameter, max(min(ends), own / 2), max(ends))
                return margin.parameter, _nearest(solve(sweep), device, margin.parameter)
    return Parameter.LENGTH, None


def _nearest(diagram: BifurcationDiagram, device: Device, parameter: Parameter) -> CriticalPoint | None:
    own = float(getattr(device, parameter))
    for kind in MULTIPLIER:
        points = [point for point in diagram.critical_points if point.kind is kind]
        if points:
            return min(points, key=lambda point: abs(point.point.sweep_value - own))
    return None


Solver = Callable[[float, Floats | None], tuple[Any, Floats]]
"""(factor, guess) -> what is found, and its unknowns; without a factor the rigid values (None, unknowns)."""


def _orbit_at(device: Device, membrane: Membrane, rigid: Rigid) -> Solver:
    def at(factor: float, guess: Floats | None) -> tuple[Any, Floats]:
        if guess is None:
            return None, np.array([rigid.velocity_bottom, rigid.phase_bottom])
        model = compliant_model(device, rigid.parameter, rigid.value, membrane, factor)
        orbit = find_orbit(model, guess)
        turns = np.round((guess[1] - orbit.bottom.phase) / (2 * np.pi))
        return orbit, np.array([orbit.bottom.velocity, orbit.bottom.phase + 2 * np.pi * turns])

    return at


def _critical_at(device: Device, varied: Parameter, membrane: Membrane, critical: CriticalPoint | None) -> Solver:
    def at(factor: float, guess: Floats | None) -> tuple[Any, Floats]:
        if critical is None:
            raise NumericalError("there is no period doubling and no fold to follow")
        if guess is None:
            point = critical.point
            return None, np.array([point.velocity_bottom, point.phi, point.sweep_value])
        x = find_critical(device, varied, membrane, factor, guess, MULTIPLIER[critical.kind])
        return x, x

    return at


def _descend(factors: Sequence[float], exponent: float, at: Solver) -> list[tuple[Any, str]]:
    """Follow something from rigid membranes down to each factor, extrapolating in epsilon; what is found, or why not.

    Once it is lost it stays lost on the softer rungs.
    """
    found: list[tuple[Any, str]] = []
    try:
        start = at(0.0, None)[1]
    except NumericalError as error:
        return [(None, str(error))] * len(factors)
    (e0, x0), (e1, x1) = (0.0, start), (0.0, start)
    lost = ""
    for factor in sorted(factors, reverse=True):
        goal, made = float(factor ** (-1 / (exponent + 1))), None
        step = goal - e1
        while not lost and made is None:
            aim = min(e1 + step, goal)
            slope = (x1 - x0) / (e1 - e0) if e1 > e0 else np.zeros_like(x1)
            try:
                result, x = at(factor if aim == goal else aim ** -(exponent + 1), x1 + slope * (aim - e1))
            except NumericalError as error:
                step /= 2
                if step < SHORTEST * goal:
                    lost = f"lost at about K times {max(aim, 1e-300) ** -(exponent + 1):.2g}: {error}"
                continue
            (e0, x0), (e1, x1) = (e1, x1), (aim, x)
            made = result if aim == goal else None
        found.append((made, lost))
    return found[::-1]
