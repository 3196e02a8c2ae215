"""Error bounds of results: they hold against 40 digits, and are not wildly pessimistic."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from exact import motion_near, quantities, residuals, unknowns
from strategies import random_sweeps

from vireport import reference
from vireport.analysis import Motions, Sweep, design_point, eigenvalues, solve
from vireport.analysis.design import around_length
from vireport.analysis.error_bounds import motion_bounds, voltage_bounds
from vireport.physics import Membrane, voltages
from vireport.reference import mp, mpf
from vireport.scenario import Parameter
from vireport.simulation.cycles import growth_bound
from vireport.trust.crosscheck import orbits_at

COLUMNS = ("q", "phi_bottom", "velocity_bottom", "velocity_top", "d", "gbar", "sweep_value", "trace", "phi_top")
STEP = mpf(10) ** -25


def across(sweep: Sweep, x: list[Any]) -> tuple[Any, Any]:
    """The direction across the curve of motions, in q and phase."""
    base = mp.matrix(residuals(sweep, x))
    columns = []
    for i in range(4):
        step = STEP * (abs(x[3]) if i == 3 else 1)
        columns.append((mp.matrix(residuals(sweep, [*x[:i], x[i] + step, *x[i + 1 :]])) - base) / step)
    tangent = [
        (-1) ** i * mp.det(mp.matrix([[columns[k][row] for k in range(4) if k != i] for row in range(3)]))
        for i in range(4)
    ]
    return -tangent[1], tangent[2]


def exact_row(sweep: Sweep, m: Motions, row: int) -> dict[str, Any]:
    """The exact motion next to a row: straight across the curve."""
    given = [mpf(x) for x in unknowns(m, row)]
    near = motion_near(sweep, given)
    normal = across(sweep, near)

    def aside(x: list[Any]) -> list[Any]:
        return [((x[2] - given[2]) * normal[1] - (x[1] - given[1]) * normal[0]) / mp.norm(mp.matrix(normal))]

    return quantities(sweep, motion_near(sweep, near, aside))


def error(found: float, exact: Any, name: str) -> float:
    away = mpf(float(found)) - exact
    if name.startswith("phi"):
        away = mp.fmod(away + 3 * mp.pi, 2 * mp.pi) - mp.pi
    return float(abs(away))


@pytest.fixture(autouse=True)
def forty_digits():
    with reference.precise():
        yield


@pytest.mark.slow
def test_bounds_of_branches_hold_and_are_not_wild() -> None:
    ratios, parameters = [], set()
    for sweep in random_sweeps(44, seed=11):
        parameters.add(sweep.parameter)
        rng = np.random.default_rng(5)
        for branch in solve(sweep).branches:
            bounds = motion_bounds(sweep, branch.motions)
            for i in sorted({0, len(branch.motions) - 1, *rng.integers(0, len(branch.motions), 3).tolist()}):
                if min(branch.motions.velocity_bottom[i], -branch.motions.velocity_top[i]) < 1e-9:
                    continue  # the reference divides by the velocities
                exact = exact_row(sweep, branch.motions, i)
                for name in COLUMNS:
                    away, bound = error(getattr(branch.motions, name)[i], exact[name], name), bounds[name][i]
                    assert away <= bound, (sweep, branch.number, i, name, away, bound)
                    if away > 0 and np.isfinite(bound):
                        ratios.append(bound / away)
    assert parameters == set(Parameter)
    assert len(ratios) > 1000
    assert np.median(ratios) < 1e3


@pytest.mark.slow
def test_bounds_at_design_points_hold() -> None:
    ratios = []
    for device in (sweep.device for sweep in random_sweeps(80, seed=12)):
        design, sweep = design_point(device, None), around_length(device)
        bounds = motion_bounds(sweep, design.motions, given=design.errors)
        for i in range(len(design.motions)):
            start = unknowns(design.motions, i)[:3]
            length = mpf(float(device.length_m))
            x = reference.newton(lambda x, sweep=sweep, length=length: residuals(sweep, [*x, length]), start)
            exact = quantities(sweep, [*x, length])
            for name in COLUMNS:
                if name != "sweep_value":
                    away, bound = error(getattr(design.motions, name)[i], exact[name], name), bounds[name][i]
                    assert away <= bound, (device, i, name, away, bound)
                    if away > 0:
                        ratios.append(bound / away)
    assert len(ratios) > 200
    assert np.median(ratios) < 1e3


def test_bounds_of_voltages_hold_and_are_not_wild() -> None:
    rng = np.random.default_rng(3)
    ratios = []
    for _ in range(300):
        active = float(10 ** rng.uniform(-4, 0))
        membrane = Membrane(
            float(10 ** rng.uniform(2, 9)),
            float(rng.uniform(1, 5)),
            active,
            active * float(rng.uniform(0.05, 0.95)),
            2000.0,
            float(10 ** rng.uniform(-4, 0)),
        )
        unit = np.array([float(10 ** rng.uniform(-2, 2))])
        velocity = rng.uniform(0.01, 2.0, 2)
        bounds = voltage_bounds(([velocity[0]], [-velocity[1]]), (np.zeros(1), np.zeros(1)), unit, membrane)
        found = voltages(unit * velocity[0], -unit * velocity[1], membrane)
        bottom, top = (reference.voltage(mpf(unit[0]) * mpf(v), membrane)[1] for v in velocity)
        for name, exact in (("bottom_v", bottom), ("top_v", top), ("average_v", (bottom + top) / 2)):
            away = float(abs(mpf(float(getattr(found, name)[0])) - exact))
            assert away <= bounds[name][0], (membrane, unit, velocity, name)
            if away > 0:
                ratios.append(bounds[name][0] / away)
    assert np.median(ratios) < 1e3


def test_bounds_of_simulated_multipliers_hold(study_of) -> None:
    """Against the eigenvalues of the analytic motion; both have their bound."""
    study = study_of("simulated")
    check = study.crosscheck
    compared = 0
    for motions, d, gbar, found in zip(
        orbits_at(study.solution.diagram, check.values), check.d, check.gbar, check.found, strict=True
    ):
        for end in found:
            if end.word != "BT" or end.period != 1:
                continue
            large, small = eigenvalues(motions.trace[motions.stable], check.restitution)
            modulus = np.maximum(np.abs(large), np.abs(small))
            modulus = np.where(motions.discriminant[motions.stable] < 0, check.restitution**2, modulus)
            away = np.min(np.abs(modulus - end.cycle.growth))
            assert away <= growth_bound(float(d), float(gbar), check.restitution, end.cycle) + 1e-12
            compared += 1
    assert compared > 20
