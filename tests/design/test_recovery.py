"""How long disturbances last: the time and its error bound against the raw map in 50 digits, and none at an event."""

from __future__ import annotations

from math import log
from types import SimpleNamespace

import mpmath as mp
import numpy as np
import pytest
from conftest import EXAMPLES
from exact_device import ExactDevice
from msgspec.structs import replace

from vireport import analyse, load
from vireport.design.recovery import NoRecovery, Recovery, recovery_of
from vireport.design.solution import Solution, solution_of
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Restitutions, SpeedLaw
from vireport.physics.numbers import UNIT
from vireport.scenario.blocks import CapsuleMotion

PAPER = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0)


def any_device(rng: np.random.Generator, kind: int) -> Device:
    """A device of a kind: constant restitution, two, a law, each with or without harmonics, recoil and friction."""
    bottom, top = rng.uniform(0.2, 0.85, 2).tolist()
    laws = bottom, Restitutions(bottom, top), SpeedLaw(bottom, top, rng.uniform(-0.3, -0.01), rng.uniform(0.5, 6.0))
    device = Device(0.1245, laws[kind % 3], 9.8, rng.uniform(0.3, 1.2), 3.0, 2.0, rng.uniform(1, 60))
    if kind // 3 % 2:
        device = replace(device, harmonics=(Harmonic.of(2, 3.0, 200.0), Harmonic.of(3, 2.0, 10.0)))
    if kind // 6 % 2:
        device = replace(device, capsule=CapsuleMotion.FREE, ball_mass_kg=0.0041)
    if kind // 12 % 2 and kind % 3 < 2:
        device = replace(device, friction=rng.uniform(0.01, 0.1))
    return device


def exact_periods(solution: Solution, row: int) -> tuple[mp.mpf, mp.mpf]:
    """Periods until 1 % is left by the raw map, and the determinant, of a motion in 50 digits."""
    m, exact = solution.design.motions, ExactDevice(solution.device)
    trace, determinant = exact.map_of(*exact.nearest(m, row))
    assert abs(trace - m.trace[row]) <= solution.bounds.design["trace"][row]
    largest = max(abs((trace + sign * mp.sqrt(mp.mpc(trace**2 - 4 * determinant))) / 2) for sign in (-1, 1))
    return mp.log(mp.mpf(1) / 100) / mp.log(largest), determinant


@pytest.mark.parametrize("count", [4, pytest.param(72, marks=pytest.mark.slow)])
def test_bounds_of_recovery_and_determinant_hold_and_are_not_wild(count: int) -> None:
    rng, held, kind = np.random.default_rng(41), 0, 0
    while held < count:
        kind += 1
        solution = solution_of(any_device(rng, kind), None, None, design=True)
        known = solution.design.motions.stable_mask
        if np.count_nonzero(known) != 1:
            continue
        (row,), recovery = np.flatnonzero(known), recovery_of(solution)
        assert isinstance(recovery, Recovery)
        with mp.workdps(50):
            periods, determinant = exact_periods(solution, row)
            assert abs(periods - mp.mpf(recovery.periods)) <= recovery.error_bound < 1e-6 * recovery.periods
            off = abs(determinant - mp.mpf(float(solution.design.motions.determinant[row])))
            assert off <= solution.bounds.design["determinant"][row] < 1e-14 * determinant
        held += 1


@pytest.mark.parametrize("restitution", [0.5, 0.7208833646629711, 0.75])
def test_a_focus_recovers_by_the_restitution_alone(restitution: float) -> None:
    """Its multipliers have the modulus r^2, so that only logarithms are rounded: to no bound of zero."""
    level = replace(PAPER, restitution=restitution, length_m=0.4 if restitution > 0.6 else 0.5, inclination_deg=0.0)
    recovery = recovery_of(solution_of(level, None, None, design=True))
    assert recovery.periods == pytest.approx(log(0.01) / log(restitution**2), rel=1e-13)
    with mp.workdps(50):
        off = abs(mp.log(mp.mpf(1) / 100) / mp.log(mp.mpf(restitution) ** 2) - mp.mpf(recovery.periods))
    assert off < recovery.error_bound < 1e-12 * recovery.periods


def test_no_recovery_is_stated_where_the_end_of_stability_is_within_the_error() -> None:
    margin = next(m for m in solution_of(PAPER, None, None, design=True).design.margins if m.event == "period_doubling")
    at = PAPER.with_values({margin.parameter: margin.sweep_value})
    assert recovery_of(solution_of(at, None, None, design=True)) is NoRecovery.AT_EVENT


@pytest.mark.parametrize("side", [-1, 1])
def test_rounding_of_the_modulus_alone_may_put_a_motion_at_its_event(side: int) -> None:
    """Next to the trace of a fold or period doubling, here known without error; 1000 roundings off the bound holds."""
    solution = solution_of(PAPER, None, None, design=True)
    stable = solution.design.motions.select(solution.design.motions.stable_mask)
    exact = {name: np.zeros(1) for name in solution.bounds.design}
    for roundings, states_it in ((1, False), (4, False), (1000, True)):
        trace = side * (1 + stable.decay**2) * (1 - roundings * UNIT)
        near = SimpleNamespace(motions=replace(stable, trace=np.array([trace])))
        found = recovery_of(SimpleNamespace(design=near, bounds=SimpleNamespace(design=exact), device=PAPER))
        assert isinstance(found, Recovery) is states_it
        if states_it:
            with mp.workdps(50):
                modulus = (abs(trace) + mp.sqrt(mp.mpf(trace) ** 2 - 4 * mp.mpf(stable.decay) ** 2)) / 2
                periods = mp.log(mp.mpf(1) / 100) / mp.log(modulus)
                assert abs(periods - mp.mpf(found.periods)) < found.error_bound < found.periods / 50


def test_results_say_why_there_is_no_recovery() -> None:
    loaded = load(EXAMPLES / "design-point.yaml", {"device.length_m": 0.5})
    found = analyse(loaded, ("json",)).to_dict()["disturbances"]
    assert (found["recovery_periods"], found["recovery_reason"]) == (None, NoRecovery.NOT_STABLE)
