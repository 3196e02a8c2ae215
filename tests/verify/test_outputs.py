"""What `vireport verify` prints: whether the solution is right, its worst error and its time; tables by -v."""

from __future__ import annotations

from importlib import import_module
from types import SimpleNamespace as Thing

import pytest
from msgspec.structs import replace

from vireport.base.timing import Spread
from vireport.cli.app import main
from vireport.findings.accuracy.benchmark import MeasuredQuantity, MethodTask
from vireport.findings.accuracy.methods import CLOSED, METHODS, WHOLE, Knob
from vireport.findings.accuracy.workprecision import MethodRun, UntriedMethod, WorkPrecision
from vireport.study.judging.opening import WordedOpening
from vireport.study.judging.verdict import Status
from vireport.verify.outputs import accuracy_opening

QUANTITIES = (
    MeasuredQuantity("velocity", MethodTask.ORBIT, "1.004", True),
    MeasuredQuantity("critical", MethodTask.CRITICAL, "0.629", True),
)
STEADY = Spread(0.01, 0.0099, 0.0101)


def of(method: str, task: MethodTask, error: float, seconds: Spread = STEADY, failed: str = "") -> MethodRun:
    key = {own.task: own.key for own in QUANTITIES}[task]
    return MethodRun(method, Knob.RTOL, 1e-3, task, {} if failed else {key: error}, seconds, 9, failed)


def work(worst: float = 5.4e-13, *more: MethodRun, **other: object) -> WorkPrecision:
    runs = (
        of(CLOSED, MethodTask.ORBIT, 1e-3),  # a coarse run, which the next one of the same method makes up for
        of(CLOSED, MethodTask.ORBIT, 1e-15),
        of(WHOLE, MethodTask.CRITICAL, worst),
        *more,
    )
    benchmark = Thing(quantities=QUANTITIES, point=Thing(label="B1"))
    return replace(WorkPrecision("", benchmark, runs, (), (), Thing(), 5), **other)


def opened(own: WorkPrecision | None) -> WordedOpening:
    plan = Thing(reason=lambda task: {"compliant": "accuracy.compliant_membrane is false"}[task])
    found = {} if own is None else {"checks": own}
    return accuracy_opening(Thing(findings=found, verdict=Thing(added={}), plan=plan)).worded()


def test_a_right_solution_is_told_in_three_lines() -> None:
    opening = opened(work())
    assert opening.status is Status.GOOD
    assert opening.lines == [
        "The solution agrees with 40-digit arithmetic in impact velocity, B1.",
        "Checked: 2 methods in 3 runs; Worst error: 5.4 × 10⁻¹³; Time: 10 ms for all motions",
        "Compliant membranes: left out (accuracy.compliant_membrane is false).",
    ]
    assert opening.tiles[1].remark == "in B1"


@pytest.mark.parametrize("error", [2e-9, float("nan")])
def test_a_wrong_number_is_named(error: float) -> None:
    opening = opened(work(error))
    assert opening.status is opening.tiles[1].status is Status.BAD
    assert opening.sentence == "The solution departs from 40-digit arithmetic in B1."


def test_methods_that_fail_and_what_is_not_tried_or_not_steady_are_told() -> None:
    failing = (of("SciPy Radau", MethodTask.ORBIT, 0.0, failed="left"),) * 2
    opening = opened(work(1e-15, *failing, absent=(UntriedMethod("simulated transient", "needs the package numba"),)))
    assert opening.facts[0] == (Status.CAUTION, "Simulated transient was not tried: it needs the package numba.")
    assert (Status.NEUTRAL, "Runs without an answer: SciPy Radau 2.") in opening.facts
    unsteady = Spread(0.02, 0.01, 0.04)
    busy = opened(work(1e-15, *(of(CLOSED, MethodTask.CRITICAL, 1e-15, unsteady) for _ in range(9))))
    assert busy.lines[2].startswith("The machine was busy")


def test_a_device_without_stable_motion_leaves_nothing_to_verify() -> None:
    opening = opened(WorkPrecision("there is no stable motion", None, (), (), (), Thing(), 5))
    assert opening.status is Status.BAD
    assert opening.sentence == "Nothing was verified: there is no stable motion."


@pytest.mark.slow
def test_tables_are_printed_where_they_are_asked_for(example, capsys, monkeypatch) -> None:
    # What is printed does not depend on how finely the slow methods are tried.
    exact = [method for method in METHODS if method.name in (CLOSED, WHOLE)]
    monkeypatch.setattr("vireport.findings.accuracy.workprecision.METHODS", exact)
    quickly = ["--set", "accuracy.compliant_membrane=false", "--set", "accuracy.repeats=1"]
    given = ["verify", str(example("inclined")), *quickly]
    assert main(given) == 0
    answer = capsys.readouterr().out.splitlines()
    assert len(answer) == 3
    for option in ("-v", "--all"):
        assert main([*given, option]) == 0
        told = capsys.readouterr().out
        assert told.startswith(f"{answer[0]}\n")
        assert "Quantities in 40-digit arithmetic" in told
        assert ("Every run: the motion" in told) == (option == "--all")


@pytest.mark.parametrize("more", [[], ["--extremes"]])
def test_errors_that_cannot_be_measured_are_refused_before_work_begins(more, example, monkeypatch, capsys) -> None:
    monkeypatch.setattr(import_module("vireport.study.plan"), "find_spec", lambda name: None)
    assert main(["verify", str(example("inclined")), *more]) == 3
    said = "vireport: error: vireport verify: the package mpmath is missing: pip install 'vireport[verify]'\n"
    assert capsys.readouterr().err == said
