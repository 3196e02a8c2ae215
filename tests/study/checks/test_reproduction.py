"""The motion of the report, found again by the interpreted simulation."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import first
from msgspec.structs import replace
from strategies import random_sweeps

from vireport import analyse
from vireport.design.solution import solution_of
from vireport.study.checks.reproduction import MOST_PERIODS, reproduce


@pytest.mark.parametrize(("name", "periods"), [("inclined", 154), ("horizontal", 17), ("design-point", 141)])
def test_the_examples_are_reproduced(example, name: str, periods: int) -> None:
    reproduction = reproduce(analyse(example(name), ["json"]).solution)
    assert (reproduction.periods, reproduction.needed) == (periods, periods)
    assert reproduction.passed
    assert max(reproduction.velocity_difference, reproduction.phase_difference) < 2e-12


@pytest.mark.slow
@pytest.mark.parametrize("count", first(1, [6, 16]))
def test_random_devices_are_reproduced_unless_it_takes_too_long(count: int) -> None:
    reproductions = [reproduce(solution_of(sweep.device, None, None, True)) for sweep in random_sweeps(count, 5)]
    stable = [reproduction for reproduction in reproductions if reproduction is not None]
    assert len(stable) >= count // 4
    assert all(reproduction.passed for reproduction in stable if reproduction.decided)
    assert sum(not reproduction.decided for reproduction in stable) <= 1
    assert all(reproduction.periods == min(reproduction.needed, MOST_PERIODS) for reproduction in stable)


@pytest.mark.parametrize("wrong", ["d", "gbar", "velocity_bottom", "phi_bottom"])
def test_a_wrong_motion_is_not_reproduced(example, wrong: str) -> None:
    solution = analyse(example("inclined"), ["json"]).solution
    motions = solution.design.motions
    shifted = replace(motions, **{wrong: getattr(motions, wrong) + 1e-7})
    reproduction = reproduce(replace(solution, design=replace(solution.design, motions=shifted)))
    assert reproduction.decided
    assert not reproduction.passed


def test_an_unstable_design_is_reproduced_amid_the_stable_range(example) -> None:
    solution = analyse(example("inclined"), ["json"]).solution
    none_stable = replace(solution.design.motions, stability=np.full_like(solution.design.motions.stability, 2))
    reproduction = reproduce(replace(solution, design=replace(solution.design, motions=none_stable)))
    part = solution.stable_ranges[0]
    assert reproduction.value == (part.start + part.end) / 2
    assert reproduction.passed
