"""What a run does, and what it leaves out with the reason, where the membranes are not alike."""

from __future__ import annotations

from vireport.scenario.loading import load
from vireport.study.plan import Task, plan
from vireport.study.study import analyse

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


def test_the_symmetric_family_alone_is_left_out_of_a_run_and_why(example) -> None:
    scenario = load(example("horizontal"), {**UNLIKE, "accuracy.repeats": 1}).scenario
    why = {step.task: step.why for step in plan(scenario).left_out}
    assert why[Task.SYMMETRIC] == "the restitutions of both membranes differ: no motion is symmetric"
    of_both = {Task.BRANCHES, Task.DESIGN, Task.FROM_REST, Task.OWN_STIFFNESS, "accuracy", "compliant"}
    assert not of_both & set(why)
