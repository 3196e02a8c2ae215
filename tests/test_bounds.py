"""Error bounds of results: they hold against 40 digits, and are not wildly pessimistic."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf
from reference import DIGITS, Case, newton, random_sweeps

from vireport.analysis.bounds import motion_bounds, voltage_bounds
from vireport.analysis.design import design_point
from vireport.analysis.diagram import solve
from vireport.analysis.motions import Motions
from vireport.analysis.orbits import Orbits, coefficients, orbits
from vireport.analysis.stability import eigenvalues, trace_and_determinant
from vireport.analysis.sweep import Sweep
from vireport.physics.energy import Membrane, voltages
from vireport.physics.rounding import Rounded, RoundedOps
from vireport.scenario.parameters import Parameter
from vireport.simulation.cycles import growth_bound
from vireport.trust.crosscheck import orbits_at

COLUMNS = ("q", "phi_bottom", "velocity_bottom", "velocity_top", "d", "gbar", "sweep_value", "trace", "phi_top")
MEMBRANE = Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041)


def normal(case: Case, x: list[mpf]) -> tuple[mpf, mpf]:
    """Across the curve of motions, in q and phase."""
    period, h = 2 * case.sweep.device.period_ratio, mpf(10) ** (-DIGITS // 2)
    base = mp.matrix(case.residuals(x))
    columns = []
    for i in range(4):
        y = list(x)
        step = h * (abs(y[i]) or 1)
        y[i] += step
        columns.append((mp.matrix(case.residuals(y)) - base) / step)
    minors = [
        (-1) ** i * mp.det(mp.matrix([[columns[k][row] for k in range(4) if k != i] for row in range(3)]))
        for i in range(4)
    ]
    return -minors[1], minors[2] / period


def exact_row(case: Case, m: Motions, i: int) -> dict[str, mpf]:
    """The exact motion next to a row: straight across the curve."""
    n = case.sweep.device.period_ratio
    q, phase = mpf(0.5) + mpf(float(m.u[i])), mpf(float(m.phi_bottom[i]))
    x = [mpf(float(m.velocity_bottom[i])), phase, 2 * n * q, mpf(float(m.sweep_value[i]))]
    x = newton(case.residuals, x)
    across = normal(case, x)

    def square(x: list[mpf]) -> list[mpf]:
        aside = (x[2] / (2 * n) - q) * across[1] - (x[1] - phase) * across[0]
        return [*case.residuals(x), aside / mp.norm(mp.matrix(across))]

    return quantities(case, newton(square, x))


def quantities(case: Case, x: list[mpf]) -> dict[str, mpf]:
    from reference import groups

    d, gbar = groups(case.sweep.device, case.sweep.parameter, x[3])
    n = case.sweep.device.period_ratio
    return {
        "velocity_bottom": x[0],
        "phi_bottom": x[1],
        "q": x[2] / (2 * n),
        "sweep_value": x[3],
        "velocity_top": case.velocity_top(x),
        "d": d,
        "gbar": gbar,
        "trace": case.trace(x),
        "phi_top": mp.fmod(x[1] + mp.pi * x[2], 2 * mp.pi),
    }


def error(found: float, exact: mpf, name: str) -> float:
    away = mpf(float(found)) - exact
    if name.startswith("phi"):
        away = mp.fmod(away + 3 * mp.pi, 2 * mp.pi) - mp.pi
    return float(abs(away))


@pytest.fixture(autouse=True)
def digits():
    with mp.workdps(DIGITS):
        yield


def test_bounds_of_branches_hold_and_are_not_wild() -> None:
    ratios = []
    for sweep in random_sweeps(44, seed=11):
        rng = np.random.default_rng(5)
        for branch in solve(sweep).branches:
            bounds = motion_bounds(sweep, branch.motions)
            for i in sorted({0, len(branch.motions) - 1, *rng.integers(0, len(branch.motions), 3).tolist()}):
                if min(branch.motions.velocity_bottom[i], -branch.motions.velocity_top[i]) < 1e-9:
                    continue  # the reference divides by the velocities
                exact = exact_row(Case(sweep), branch.motions, i)
                for name in COLUMNS:
                    away, bound = error(getattr(branch.motions, name)[i], exact[name], name), bounds[name][i]
                    assert away <= bound, (sweep, branch.number, i, name, away, bound)
                    if away > 0 and np.isfinite(bound):
                        ratios.append(bound / away)
    assert len(ratios) > 1000
    assert np.median(ratios) < 1e3


def test_bounds_at_design_points_hold() -> None:
    ratios = []
    for sweep in random_sweeps(80, seed=12):
        design = design_point(sweep.device, None) if sweep.device.length_m else None
        if design is None or not len(design.motions):
            continue
        by_length = Sweep(sweep.device, Parameter.LENGTH, sweep.device.length_m / 2, sweep.device.length_m * 2)
        bounds = motion_bounds(by_length, design.motions, given=design.errors)
        m, n = design.motions, sweep.device.period_ratio
        for i in range(len(m)):
            case = Case(by_length)

            def fixed(x: list[mpf], case: Case = case) -> list[mpf]:
                return case.residuals([*x, mpf(case.sweep.device.length_m)])

            start = [float(m.velocity_bottom[i]), float(m.phi_bottom[i]), 2 * n * (0.5 + float(m.u[i]))]
            x = newton(fixed, start)
            exact = quantities(case, [*x, mpf(sweep.device.length_m)])
            for name in COLUMNS:
                if name != "sweep_value":
                    away, bound = error(getattr(m, name)[i], exact[name], name), bounds[name][i]
                    assert away <= bound, (sweep, i, name, away, bound)
                    if away > 0:
                        ratios.append(bound / away)
    assert len(ratios) > 200
    assert np.median(ratios) < 1e3


def exact_voltage(speed: mpf, membrane: Membrane) -> mpf:
    """Equations (5.2)-(5.5) as printed."""
    h, k = mpf(membrane.exponent), mpf(membrane.stiffness)
    rc, rb = mpf(membrane.active_radius_m), mpf(membrane.ball_radius_m)
    delta = ((h + 1) * mpf(membrane.ball_mass_kg) / (2 * k)) ** (1 / (h + 1)) * speed ** (2 / (h + 1))
    t = mp.sqrt(rc**2 + (delta - rb) ** 2 - rb**2)
    cosine = (rc * t - rb * (delta - rb)) / (rc**2 + (delta - rb) ** 2)
    ratio = 1 + (1 - cosine) * (1 - (rb / rc) ** 2 * (1 - cosine)) / cosine
    return mpf(membrane.bias_voltage_v) * (ratio**2 - 1)


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
        unit = float(10 ** rng.uniform(-2, 2))
        velocity = rng.uniform(0.01, 2.0, 2)
        u = np.array([unit])
        bounds = voltage_bounds(([velocity[0]], [-velocity[1]]), (np.zeros(1), np.zeros(1)), u, membrane)
        found = voltages(u * velocity[0], -u * velocity[1], membrane)
        exact = [exact_voltage(mpf(unit) * mpf(float(v)), membrane) for v in velocity]
        for name, value in (("bottom_v", exact[0]), ("top_v", exact[1]), ("average_v", (exact[0] + exact[1]) / 2)):
            away = float(abs(mpf(float(getattr(found, name)[0])) - value))
            assert away <= bounds[name][0], (membrane, unit, velocity, name)
            if away > 0:
                ratios.append(bounds[name][0] / away)
    assert np.median(ratios) < 1e3


def test_the_arithmetic_bounds_its_own_rounding() -> None:
    """Every quantity of the surface of motions at random doubles, against 40 digits of the same formulae."""
    rng = np.random.default_rng(8)
    for _ in range(200):
        u, phi, r, n = (
            float(rng.uniform(-0.49, 0.49)),
            float(rng.uniform(0, 6.28)),
            float(rng.uniform(0, 0.99)),
            int(rng.integers(1, 4)),
        )
        carried = orbits(Rounded(u), Rounded(phi), Rounded(r), n, RoundedOps())
        exact = orbits(mpf(u), mpf(phi), mpf(r), n, mp)
        for name in Orbits.__slots__:
            x, y = getattr(carried, name), getattr(exact, name)
            assert abs(mpf(float(x.value)) - y) <= mpf(float(x.error)), name
        trace, true = (trace_and_determinant(o, s)[0] for o, s in ((carried, Rounded(r)), (exact, mpf(r))))
        assert abs(mpf(float(trace.value)) - true) <= mpf(float(trace.error))


def test_a_division_by_what_may_be_zero_has_no_bound() -> None:
    assert (Rounded(1.0) / Rounded(1e-20, 1e-18)).error == np.inf
    k = coefficients(Rounded(0.1, 0.5), Rounded(0.5), 1, RoundedOps())
    assert k.gbar_sine.error > 1


def test_all_parameters_were_swept() -> None:
    assert {sweep.parameter for sweep in random_sweeps(44, seed=11)} == set(Parameter)


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
