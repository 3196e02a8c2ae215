"""Error bounds of results: they hold against 40 digits, and are not wildly pessimistic."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import first
from exact import error_of, exact_at, exact_row
from mpmath import mp, mpf
from msgspec.structs import replace
from strategies import random_sweeps, sweep_grid

from vireport.design.bounds import bounds_of, voltage_bounds
from vireport.design.point import around_length, design_point, stable_ranges
from vireport.design.solution import Solution, solution_of
from vireport.motions.branches import Branch
from vireport.motions.diagram import solve
from vireport.motions.error_bounds import one_to_one_bounds, undecided
from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions, impact_velocities
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.energy import Conversion, Dielectric, Membrane, Voltages, voltages
from vireport.physics.groups import Groups
from vireport.physics.numbers import Rounded
from vireport.scenario.parameters import DRIVING, Parameter
from vireport.simulation.cycles import growth_bound
from vireport.study.checks import reference
from vireport.study.checks.crosscheck import orbits_at
from vireport.study.checks.forty_digits import critical_motion

pytestmark = pytest.mark.usefixtures("forty_digits")

MEMBRANE = Membrane(4.0847e5, 2.6, 6.3e-3, 5e-3, 2000.0, 0.0041)
DIELECTRIC = replace(MEMBRANE, dielectric=Dielectric(1e-3, 4.7, 1e8))
DEVICE = Device(0.1245, 0.5, 9.8, 0.75, 3.0, 2.0, 45.0)
OF_IMPACTS = Voltages.__struct_fields__
CONVERTED = Conversion.__struct_fields__


def exact_conversion(device: Device, exact: dict[str, Any]) -> dict[str, Any]:
    """Energies (C - C0) U_imp Uin/2 at constant charge, and what follows from them, from an exact motion."""
    bias, kappa, frequency = mpf(2000), mpf(1e-3), mpf(device.frequency_hz)
    flat = mpf(8.8541878188e-12) * mpf(4.7) * mp.pi * mpf(6.3e-3) ** 2 / kappa
    peaks = [exact[name] + bias for name in ("bottom_v", "top_v")]
    bottom, top = (flat * (peak / bias - 1) * peak * bias / 2 for peak in peaks)
    unit = mpf(device.amplitude_n) / (2 * mpf(device.capsule_mass_kg) * frequency)
    squares = exact["velocity_bottom"] ** 2 + exact["velocity_top"] ** 2
    lost = mpf(MEMBRANE.ball_mass_kg) / 2 * (1 - mpf(device.restitution) ** 2) * unit**2 * squares
    power = 1000 * (bottom + top) * frequency / device.period_ratio
    values = bottom, top, power, (bottom + top) / lost, max(peaks) / kappa
    return dict(zip(CONVERTED, values, strict=True))


def ends_of_sweep(branch: Branch) -> set[int]:
    """Rows at which it is the sweep that cuts a branch."""
    return {mark.row for mark in branch.family.marks if mark.event is Event.SWEEP_END}


def ratios_of(solution: Solution, chosen: int) -> dict[str, list[float]]:
    """Bound over error of every number of the first, the last and some other rows, by the names of the numbers.

    At an end of the sweep the exact motion is the one of that end.
    """
    sweep, ratios = solution.sweep, {}
    rng = np.random.default_rng(5)
    for branch, bounds in zip(solution.branches, solution.bounds.branches, strict=True):
        m, ends = branch.motions, ends_of_sweep(branch)
        for row in sorted({0, len(m) - 1, *rng.integers(0, len(m), chosen).tolist()}):
            if row in ends:
                assert m.sweep_value[row] in (sweep.start, sweep.end)
                exact = exact_at(sweep, m, row, float(m.sweep_value[row]), MEMBRANE)
            else:
                exact = exact_row(sweep, m, row, MEMBRANE)
            for name, bound in bounds.items():
                stored = getattr(branch.voltages_by_motion if name in OF_IMPACTS else m, name)[row]
                away = error_of(stored, exact[name], name)
                assert away <= bound[row], (sweep, branch.number, row, name, away, bound[row])
                if away > 0 and np.isfinite(bound[row]):
                    ratios.setdefault(name, []).append(bound[row] / away)
    return ratios


@pytest.mark.parametrize("batch", first(0, range(0, 30, 4)))
def test_bounds_of_branches_hold_and_are_not_wild(batch: int) -> None:
    together: dict[str, list[float]] = {}
    for sweep in sweep_grid()[6 * batch : 6 * batch + 6]:
        for name, ratios in ratios_of(solution_of(sweep.device, MEMBRANE, sweep, design=False), 3).items():
            together.setdefault(name, []).extend(ratios)
    for name, ratios in together.items():
        assert np.median(ratios) < 1e4, name


@pytest.mark.slow
def test_bounds_of_random_branches_hold() -> None:
    parameters = set()
    for sweep in random_sweeps(22, seed=11):
        if any(ratios_of(solution_of(sweep.device, MEMBRANE, sweep, design=False), 3)):
            parameters.add(sweep.parameter)
    assert parameters == set(DRIVING)


@pytest.mark.parametrize("parameter", [Parameter.AMPLITUDE, Parameter.FREQUENCY])
@pytest.mark.parametrize("inclination", [1e-3, 1e-9])
def test_bounds_hold_at_the_ends_of_sweeps_next_to_horizontal(parameter: Parameter, inclination: float) -> None:
    """There the end of the sweep is found to a few digits along the curve; the row has all of them."""
    start, end = (3.0, 6.0) if parameter is Parameter.AMPLITUDE else (1.4, 2.0)
    device = replace(DEVICE, inclination_deg=inclination)
    solution = solution_of(device, MEMBRANE, Sweep(device, parameter, start, end), design=False)
    assert sum(len(ends_of_sweep(branch)) for branch in solution.branches) >= 4
    assert ratios_of(solution, 0)["average_v"]
    for branch, bounds in zip(solution.branches, solution.bounds.branches, strict=True):
        ends = sorted(ends_of_sweep(branch))
        assert (bounds["average_v"][ends] < 1e-11 * branch.voltages_by_motion.average_v[ends]).all()


@pytest.mark.parametrize("parameter", DRIVING)
def test_bounds_hold_where_the_stated_value_is_not_that_of_the_motion(parameter: Parameter) -> None:
    """So it is at an end of the sweep that could not be solved for; voltages are those at the stated value."""
    at = float(getattr(DEVICE, parameter))
    diagram = solve(Sweep(DEVICE, parameter, 0.9 * at, 1.1 * at))
    shifted = []
    for branch in diagram.branches:
        motions = replace(branch.motions, sweep_value=branch.motions.sweep_value * (1 + 1e-9))
        volts = voltages(*impact_velocities(DEVICE, parameter, motions), MEMBRANE)
        shifted.append(replace(branch, motions=motions, voltages_by_motion=volts))
    moved = replace(diagram, branches=tuple(shifted))
    bounds = bounds_of(DEVICE, MEMBRANE, moved, None).branches
    for branch, bound in zip(moved.branches, bounds, strict=True):
        row = len(branch.motions) // 2
        exact = exact_row(moved.sweep, branch.motions, row, MEMBRANE)
        for name, values in bound.items():
            stored = getattr(branch.voltages_by_motion if name in OF_IMPACTS else branch.motions, name)[row]
            assert error_of(stored, exact[name], name) <= values[row], (branch.number, row, name)


def test_a_number_that_passes_zero_has_a_bound() -> None:
    """The discriminant, where the type changes between node and focus."""
    device = replace(DEVICE, inclination_deg=0.0)
    solution = solution_of(device, MEMBRANE, Sweep(device, Parameter.LENGTH, 0.3, 0.75), design=False)
    zeros = []
    for branch, bounds in zip(solution.branches, solution.bounds.branches, strict=True):
        for row in range(len(branch.motions)):
            point = branch.family.critical_points.get(row)
            if point is not None and point.event is Event.NODE_FOCUS:
                zeros.append(bounds["discriminant"][row])
                assert abs(branch.motions.discriminant[row]) <= zeros[-1] < 1e-10
    assert len(zeros) >= 3


@pytest.mark.parametrize("length", [0.35, 0.75])
def test_an_inclination_of_zero_has_bounds(length: float) -> None:
    device = replace(DEVICE, length_m=length)
    solution = solution_of(device, MEMBRANE, Sweep(device, Parameter.INCLINATION, 0.0, 30.0), design=False)
    ratios_of(solution, 0)
    flat = 0
    for branch, bounds in zip(solution.branches, solution.bounds.branches, strict=True):
        rows = branch.motions.sweep_value == 0
        flat += int(rows.sum())
        assert all(np.isfinite(bound[rows]).all() for bound in bounds.values())
    assert flat >= 2


@pytest.mark.parametrize("seed", first(1, range(12, 17)))
def test_bounds_at_design_points_hold(seed: int) -> None:
    together: dict[str, list[float]] = {}
    for device in (sweep.device for sweep in random_sweeps(8, seed)):
        solution, sweep = solution_of(device, DIELECTRIC, None, design=True), around_length(device)
        design, bounds = solution.design, solution.bounds.design
        for row in range(len(design.motions)):
            exact = exact_at(sweep, design.motions, row, float(device.length_m), MEMBRANE)
            exact |= exact_conversion(device, exact)
            for name, bound in bounds.items():
                columns = design.voltages_by_motion if name in OF_IMPACTS else design.motions
                stored = getattr(design.conversion_by_motion if name in CONVERTED else columns, name)[row]
                away = error_of(stored, exact[name], name)
                assert away <= bound[row], (device, row, name, away, bound[row])
                if away > 0:
                    together.setdefault(name, []).append(bound[row] / away)
    assert set(together) >= {"wall_gap", "discriminant", "average_v", "deflection_m", *CONVERTED}
    for name, ratios in together.items():
        assert np.median(ratios) < 1e4, name


@pytest.mark.parametrize("share", first(2, [0.0, 1e-12, 1e-3, 2.0]))
def test_bounds_of_voltages_hold_and_are_not_wild(share: float) -> None:
    """Of impacts whose speed is known to a share: the exact speed may be anywhere up to it."""
    rng = np.random.default_rng(3)
    ratios = []
    for _ in range(60):
        active = float(10 ** rng.uniform(-4, 0))
        membrane = Membrane(
            float(10 ** rng.uniform(2, 9)),
            float(rng.uniform(1, 5)),
            active,
            active * float(rng.uniform(0.05, 0.95)),
            2000.0,
            float(10 ** rng.uniform(-4, 0)),
        )
        speeds = float(10 ** rng.uniform(-2, 2)) * rng.uniform(0.01, 2.0, 2)
        bounds = voltage_bounds(*(Rounded(np.array([v]), np.array([share * v])) for v in speeds), membrane)
        volts = voltages(speeds[:1], -speeds[1:], membrane)
        for sign in (-1, 0, 1) if share else (0,):
            impacts = [reference.voltage(abs(mpf(v) * (1 + sign * mpf(share))), membrane) for v in speeds]
            (deep_bottom, bottom), (deep_top, top) = impacts
            exact = {"bottom_v": bottom, "top_v": top, "average_v": (bottom + top) / 2}
            for name, value in {**exact, "deflection_m": max(deep_bottom, deep_top)}.items():
                away = float(abs(mpf(float(getattr(volts, name)[0])) - value))
                assert away <= bounds[name][0], (membrane, speeds, name)
                if away > 0 and sign == np.sign(share):
                    ratios.append(bounds[name][0] / away)
    assert np.median(ratios) < 1e3


@pytest.mark.parametrize("device", first(0, [DEVICE, *(sweep.device for sweep in random_sweeps(3, seed=8)[1:])]))
def test_bounds_of_margins_and_stable_ranges_hold(device: Device) -> None:
    errors = []
    for parameter in DRIVING:
        at = float(getattr(device, parameter))
        low, high = (0.0, 90.0) if parameter is Parameter.INCLINATION else (at / 4, at * 4)
        diagram = solve(Sweep(device, parameter, low, high))
        swept = (margin for margin in design_point(device, diagram).margins if margin.parameter.sweepable is parameter)
        for margin in swept:
            value = critical_motion(margin.point, diagram.sweep.device, diagram.sweep.parameter)[3]
            errors.append(float(abs(mpf(margin.distance) - (value - mpf(at)))))
            assert errors[-1] <= margin.error_bound
        for part in stable_ranges(diagram):
            for value, point in part.ends:
                if point is None:
                    assert value in (low, high)
                else:
                    errors.append(
                        float(
                            abs(mpf(value) - critical_motion(point, diagram.sweep.device, diagram.sweep.parameter)[3])
                        )
                    )
                    assert errors[-1] <= point.error_bound
    assert np.count_nonzero(errors) > 10


@pytest.mark.slow
def test_admissible_is_undecided_where_rounding_decides() -> None:
    device = replace(DEVICE, inclination_deg=14.0)
    diagram = solve(Sweep(device, Parameter.LENGTH, 0.15, 0.5))
    touching = (x for x in diagram.critical_points if x.event is Event.GRAZING and x.rest is None)
    length = float(next(touching).sweep_value)
    open_count = wrong = 0
    for k in (*range(-12, 13), -1e9, 1e9):
        point = replace(device, length_m=length * (1 + k * 2.2e-16))
        design, sweep = design_point(point, diagram), around_length(point)
        bounds = one_to_one_bounds(sweep, design.motions, solved=design.errors)
        is_open = undecided(design.motions, bounds)
        for row in range(len(design.motions)):
            if abs(design.motions.wall_gap[row]) > 1e-3:
                assert not is_open[row]
                continue
            gap = exact_at(sweep, design.motions, row, float(point.length_m), MEMBRANE)["wall_gap"]
            open_count += bool(is_open[row])
            wrong += bool(design.motions.admissible_mask[row]) != (gap > 0)
            assert is_open[row] or bool(design.motions.admissible_mask[row]) == (gap > 0), (k, row)
            assert abs(k) < 1e9 or not is_open[row]
    assert open_count > 5
    assert wrong > 0


@pytest.mark.slow
def test_bounds_of_simulated_multipliers_hold(study_of) -> None:
    """Against the multiplier of the exact motion at the same d and gbar."""
    study = study_of("simulated")
    check, r = study.crosscheck, study.solution.device.restitution
    errors = []
    for motions, d, gbar, ends in zip(
        orbits_at(study.solution.diagram, check.values), check.groups.d, check.groups.gbar, check.ends, strict=True
    ):
        exact = [multiplier(motions, row, d, gbar, r) for row in np.flatnonzero(motions.stable_mask)]
        for end in ends:
            if end.word == "BT" and end.period == 1:
                errors.append(min(float(abs(modulus - mpf(end.cycle.growth))) for modulus in exact))
                assert errors[-1] <= growth_bound(Groups(float(d), float(gbar), r), end.cycle)
    assert np.count_nonzero(errors) > 20


def multiplier(motions: Motions, row: int, d: float, gbar: float, r: float) -> Any:
    """Modulus of the larger multiplier of the exact motion near a row."""
    near = [mpf(float(getattr(motions, name)[row])) for name in ("velocity_bottom", "phi_bottom", "u")]
    state = reference.motion(near, mpf(float(d)), mpf(float(gbar)), mpf(r), 1)
    trace = reference.trace(state, mpf(float(gbar)), mpf(r), 1)
    discriminant = trace**2 - 4 * mpf(r) ** 4
    return mpf(r) ** 2 if discriminant < 0 else (abs(trace) + mp.sqrt(discriminant)) / 2
