"""What a run does, and what it leaves out with the reason, where the membranes are not alike."""

from __future__ import annotations

import pytest

from vireport.base import UsageError
from vireport.scenario import load
from vireport.study import Task, analyse, plan, refuse_unlike

UNLIKE = {"device.restitution": None, "device.restitution_bottom": 0.475, "device.restitution_top": 0.5}


def test_one_restitution_of_both_is_the_same_as_the_same_of_each(example) -> None:
    """To the last bit, but for the scenario itself."""
    path = example("inclined")
    one, each = (
        analyse(load(path, over), (Task.JSON,))
        for over in ({}, {**UNLIKE, "device.restitution_bottom": 0.5})
    )  # fmt: skip
    first, second = (study.to_dict() for study in (one, each))
    for of_input in ("scenario", "overrides"):
        assert first.pop(of_input) != second.pop(of_input)
    assert first == second


def test_steps_that_know_one_restitution_are_left_out_with_the_reason(example) -> None:
    scenario = load(example("horizontal"), {**UNLIKE, "accuracy.repeats": 1}).scenario
    why = {step.task: step.why for step in plan(scenario).left_out}
    assert why[Task.SYMMETRIC] == "the restitutions of both membranes differ: no motion is symmetric"
    for task in (Task.ACCURACY, Task.COMPLIANT, Task.FIGURE_ACCURACY):
        assert why[task] == "it knows one restitution of both membranes, and here they differ"
    assert not {Task.BRANCHES, Task.DESIGN, Task.FROM_REST, Task.OWN_STIFFNESS} & set(why)


def test_commands_that_know_one_restitution_refuse_two(example) -> None:
    unlike = load(example("inclined"), UNLIKE).scenario
    with pytest.raises(UsageError, match="vireport accuracy knows one restitution of both membranes"):
        refuse_unlike(unlike, "vireport accuracy")
    refuse_unlike(load(example("inclined"), {**UNLIKE, "device.restitution_bottom": 0.5}).scenario, "vireport accuracy")
