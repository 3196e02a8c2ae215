"""The motion of the report, found again by the interpreted simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from strategies import random_sweeps

from vireport import analyse
from vireport.checks import reproduce
from vireport.checks.reproduction import MOST_PERIODS
from vireport.design import solution_of


@pytest.mark.parametrize(("name", "periods"), [("inclined", 154), ("horizontal", 17), ("design-point", 141)])
def test_the_examples_are_reproduced(example, name: str, periods: int) -> None:
    found = reproduce(analyse(example(name), ["json"]).solution)
    assert (found.periods, found.needed) == (periods, periods)
    assert found.passed
    assert max(found.velocity_difference, found.phase_difference) < 2e-12


def test_random_devices_are_reproduced_unless_it_takes_too_long() -> None:
    found = [reproduce(solution_of(sweep.device, None, None, True)) for sweep in random_sweeps(30, 5)]
    stable = [one for one in found if one is not None]
    assert len(stable) > 7
    assert all(one.passed for one in stable if one.decided)
    assert sum(not one.decided for one in stable) <= 1
    assert all(one.periods == min(one.needed, MOST_PERIODS) for one in stable)


@pytest.mark.parametrize("wrong", ["d", "gbar", "velocity_bottom", "phi_bottom"])
def test_a_wrong_motion_is_not_reproduced(example, wrong: str) -> None:
    solution = analyse(example("inclined"), ["json"]).solution
    motions = solution.design.motions
    shifted = replace(motions, **{wrong: getattr(motions, wrong) + 1e-7})
    found = reproduce(replace(solution, design=replace(solution.design, motions=shifted)))
    assert found.decided
    assert not found.passed


def test_an_unstable_design_is_reproduced_amid_the_stable_range(example) -> None:
    solution = analyse(example("inclined"), ["json"]).solution
    none_stable = replace(solution.design.motions, stability=np.full_like(solution.design.motions.stability, 2))
    found = reproduce(replace(solution, design=replace(solution.design, motions=none_stable)))
    part = solution.stable_ranges[0]
    assert found.value == (part.start + part.end) / 2
    assert found.passed
