"""Changes since a baseline: what moved is found, what is rounding is not."""

from __future__ import annotations

import copy
import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from vireport import analyse, diff, load
from vireport.comparison.baseline import diff_json, diff_markdown, diff_text, read_baseline
from vireport.comparison.changes import Change
from vireport.errors import UsageError
from vireport.study.study import Study

EXAMPLES = Path(__file__).parent.parent / "examples"


@cache
def study(*overrides: str, name: str = "inclined") -> Study:
    return analyse(load(EXAMPLES / f"{name}.yaml", overrides))


@cache
def _results(name: str) -> str:
    return json.dumps(study(name=name).to_dict())


def results(name: str = "inclined") -> dict[str, Any]:
    return json.loads(_results(name))


def of(group: str, changes: tuple[Change, ...]) -> list[Change]:
    return [change for change in changes if change.group == group]


@pytest.mark.parametrize("name", ["horizontal", "inclined", "inclined-forcing", "design-point"])
def test_nothing_has_changed_since_the_same_scenario(name: str) -> None:
    assert diff(results(name), study(name=name)) == ()
    assert diff_text(()) == "No change beyond tolerance since the baseline."


def test_a_moved_critical_point_is_found_and_rounding_is_not() -> None:
    baseline = results()
    b1 = baseline["critical_points"][0]
    b1["sweep_value"] *= 1 + 1e-9
    assert diff(baseline, study()) == ()
    b1["sweep_value"] *= 1.001
    (change,) = diff(baseline, study())
    assert change.group == "critical point"
    assert change.after == pytest.approx(0.629457141, rel=1e-8)
    assert change.change == pytest.approx(-0.001, rel=1e-2)
    assert "B1" in change.sentence
    b1["error_bound"] = 0.01
    assert diff(baseline, study()) == ()
    b1["error_bound"] = 0.0
    assert diff(baseline, study(), relative=0.01) == ()


def test_a_changed_scenario_tells_cause_and_effect() -> None:
    changes = diff(results(), study("device.restitution=0.52"))
    assert [(x.what, x.before, x.after) for x in of("scenario", changes)] == [("device.restitution", 0.5, 0.52)]
    (moved,) = of("critical point", changes)
    (start,) = of("stable range", changes)
    assert moved.after == start.after == study("device.restitution=0.52").solution.critical_points[0].point.sweep_value
    (margin,) = of("margin", changes)
    assert margin.before == pytest.approx(-9.2216, abs=1e-4)
    assert {x.unit for x in of("voltage", changes)} == {"V"}
    assert len(of("voltage", changes)) == 3


def test_a_point_that_appears_does_not_rename_the_others() -> None:
    wide = study("sweep.from=0.02", "sweep.to=0.75", name="horizontal")
    changes = diff(results("horizontal"), wide)
    before = {(x["kind"], round(x["d"], 9)) for x in results("horizontal")["critical_points"]}
    now = {(x.kind, round(x.point.d, 9)) for x in wide.solution.critical_points}
    assert before < now
    assert len(of("critical point", changes)) == len(now - before)
    assert all(x.before is None for x in of("critical point", changes))
    assert not of("margin", changes)


def test_what_vanishes_is_told() -> None:
    changes = diff(results(), study("inclination_deg=60"))
    assert [x.after for x in of("design point", changes)] == ["none"]
    (gone,) = of("critical point", changes)
    assert gone.after is None
    assert "gone" in gone.sentence
    assert [(x.before is not None, x.after) for x in of("stable range", changes)] == [(True, None)]
    assert {x.what.split()[0] for x in of("alert", changes)} >= {"VR001", "VR003"}
    assert all(x.after is None for x in of("voltage", changes))


def test_another_swept_parameter_is_compared_in_d() -> None:
    changes = diff(results(), study("sweep.parameter=amplitude_n", "sweep.from=3", "sweep.to=6"))
    (moved,) = [x for x in of("critical point", changes) if "B1" in x.what]
    assert moved.unit == ""
    assert moved.what.endswith(", d")
    assert moved.before == pytest.approx(0.4179595416, rel=1e-9)


def test_a_requirement_that_is_not_met_any_more_is_told() -> None:
    baseline, now = results(), copy.deepcopy(study().to_dict())
    baseline["requirements"] = {"passed": True, "criteria": [{"key": "u_ave_at_least_v", "passed": True}]}
    now["requirements"] = {"passed": False, "criteria": [{"key": "u_ave_at_least_v", "passed": False}]}
    from vireport.comparison.changes import changes

    (change,) = changes(baseline, now, 1e-6)
    assert change.sentence == "requirements.u_ave_at_least_v: met to not met."


def test_texts_have_the_numbers() -> None:
    changes = diff(results(), study("device.restitution=0.52"))
    text = diff_text(changes, "old.json")
    assert text.startswith(f"{len(changes)} changes since old.json:")
    assert "0.629457 m to 0.624644 m" in text
    table = diff_markdown(changes, "old|.json")
    assert "old\\|.json" in table
    lines = [line for line in table.splitlines() if line.startswith("|")]
    assert len(lines) == len(changes) + 2
    data = json.loads(diff_json(changes))
    assert data["changed"] is True
    assert [x["after"] for x in data["changes"]] == [x.after for x in changes]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "is no JSON"),
        ("[]", "a block of keys"),
        ('{"schema_version": 1}', "scenario, branches, critical_points, .* missing"),
    ],
)
def test_what_is_no_baseline_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "old.json"
    path.write_text(text)
    with pytest.raises(UsageError, match=message):
        read_baseline(path)


def test_a_baseline_is_read_or_refused_with_what_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text(json.dumps(results()))
    assert diff(read_baseline(path), study()) == ()
    with pytest.raises(UsageError, match="cannot be read"):
        read_baseline(tmp_path / "none.json")
    later = results() | {"schema_version": 99}
    with pytest.raises(UsageError, match="schema_version 99"):
        diff(later, study())
    broken = results()
    del broken["critical_points"][0]["kind"]
    with pytest.raises(UsageError, match="'kind' is missing"):
        diff(broken, study())
