"""Results that are read: every mistake is told with its path and type; what earlier or newer versions wrote is read."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from functools import cache
from math import inf, nan
from pathlib import Path
from typing import Any

import pytest
from conftest import EXAMPLES, study
from msgspec import Struct

from vireport import diff
from vireport.base.errors import UsageError
from vireport.cli.app import main
from vireport.study.reading import read_record, read_results

KINDS = "period_doubling, fold, pitchfork, node_focus, grazing, stop_in_flight, zero_velocity, sweep_end, closed_curve"


@cache
def written(name: str = "inclined") -> str:
    return json.dumps(study(name).to_dict())


def spoilt(path: str, value: object, data: dict[str, Any] | None = None) -> dict[str, Any]:
    """Results with another value at a path."""
    data = json.loads(written()) if data is None else data
    *folders, last = (
        int(part) if part.isdigit() else part for part in path.replace("[", ".").replace("]", "").split(".")
    )
    place: Any = data
    for part in folders:
        place = place[part]
    place[last] = value
    return data


MISTAKES = {
    "overrides": ("x", "expected a list, got a text"),
    "branches[0].q[3]": ("0.5", "expected a number or null, got a text"),
    "branches[1].admissible[0]": (1, "expected true or false, got the number 1"),
    "branches[0].mirror_of": (1.5, "expected a whole number or null, got the number 1.5"),
    "critical_points[0].sweep_value": (None, "expected a number, got null"),
    "critical_points[0].mirror": ([], "expected a block of keys or null, got a list"),
    "design_point.margins[0].kind": ("bend", f"expected one of {KINDS}"),
    "design_point.margins[0].derivatives.amplitude_n": (True, "expected a number or null, got true"),
    "design_point.error_bounds.q[0]": ({}, "expected a number or null, got a block of keys"),
    "design_point.velocity_top": ([0.1], "1 values, where stability has 2"),
    "stable_range[0].from": ([], "expected a number, got a list"),
    "alerts[0].title": (3, "expected a text, got the number 3"),
    "scenario.sweep.parameter": ("colour", "expected one of length_m, "),
    "scenario.excitation.amplitude_n": (None, "is missing"),
}


@pytest.mark.parametrize("path", MISTAKES)
def test_a_mistake_is_told_with_its_path_and_both_types(path: str) -> None:
    value, message = MISTAKES[path]
    with pytest.raises(UsageError) as error:
        read_results(spoilt(path, value), "old.json")
    (line,) = error.value.lines
    assert line.startswith(f"old.json: {path}: {message}")


class Counted(Struct):
    count: int


@pytest.mark.parametrize("value", [nan, inf, 1.5])
def test_what_is_no_whole_number_is_a_mistake(value: float) -> None:
    with pytest.raises(UsageError, match=rf"^x: proof\.count: expected a whole number, got the number {value}$"):
        read_record({"count": value}, Counted, "x", "proof")


def test_every_mistake_has_a_line_up_to_twenty(tmp_path: Path, capsys) -> None:
    data = json.loads(written())
    for k in range(4):
        spoilt(f"branches[0].q[{k}]", "x", data)
    del data["critical_points"][0]["label"]
    path = tmp_path / "results.json"
    for count, arguments in (
        (5, ["run", str(EXAMPLES / "inclined.yaml"), "-o", str(tmp_path), "--baseline", str(path)]),
        (5, ["run", str(path), "--json"]),
        (21, ["compare", str(path), str(EXAMPLES / "inclined.yaml"), "--exit-code"]),
    ):
        if count > 20:
            data["branches"][0]["gbar"] = ["x"] * 100
        path.write_text(json.dumps(data))
        assert main(arguments) == 2
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == count
        assert all("results.json: " in line for line in lines)
        column = "q" if count == 5 else "gbar"
        assert f"branches[0].{column}[1]: expected a number or null, got a text" in "".join(lines)
        assert ("critical_points[0].label: is missing" in "".join(lines)) == (count == 5)
        assert ("and more (mend these first)" in lines[-1]) == (count > 20)


def without_later_keys(data: dict[str, Any]) -> None:
    """Take out what the first version did not write."""
    for point in data["critical_points"]:
        for key in ("mirror", "branch", "detail", "error_bounds"):
            del point[key]
    for key in ("margins_unresolved", "distortion", "distortion_reason", "admissible_undecided"):
        del data["design_point"][key]
    for part in data["stable_range"]:
        for key in ("settable", "from_error_bound", "to_error_bound", "from_beyond_sweep", "to_beyond_sweep"):
            del part[key]
    for key in set(data) - {"schema_version", "scenario", "branches", "critical_points", "stable_range"}:
        if key not in ("design_point", "alerts"):
            del data[key]


def with_newer_keys(data: dict[str, Any]) -> None:
    """Add what no version has written yet."""
    data["temperatures"] = [{"k": 293.0}]
    data["design_point"]["colour"] = "blue"
    data["critical_points"][0]["kinds"] = ["fold"]


@pytest.mark.parametrize("change", [without_later_keys, with_newer_keys])
def test_what_other_versions_wrote_is_read(change: Callable[[dict[str, Any]], None]) -> None:
    data = json.loads(written())
    change(data)
    now = {row.group for row in diff(data, study("inclined"))}
    assert now <= {"disturbances"}
    assert len(read_results(copy.deepcopy(data), "old.json").critical_points) == len(data["critical_points"])
