"""Changes since a baseline: what moved is found, what is rounding is not."""

from __future__ import annotations

import copy
import io
import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from conftest import EXAMPLES, study
from pages import Page, squeeze
from pypdf import PdfReader

from vireport import diff
from vireport.base.errors import UsageError
from vireport.cli.app import main
from vireport.report.changes.baseline import read_baseline
from vireport.report.changes.diff_outputs import changes_table, diff_json, diff_markdown, diff_text
from vireport.report.changes.table import ComparisonRow


@cache
def _results(name: str) -> str:
    return json.dumps(study(name).to_dict())


def results(name: str = "inclined") -> dict[str, Any]:
    return json.loads(_results(name))


def of(group: str, rows: tuple[ComparisonRow, ...]) -> list[ComparisonRow]:
    return [change for change in rows if change.group == group]


@pytest.mark.parametrize("name", ["horizontal", "inclined", "inclined-forcing", "design-point"])
def test_nothing_has_changed_since_the_same_scenario(name: str) -> None:
    assert diff(results(name), study(name)) == ()
    assert diff_text(()) == "No change beyond tolerance since the baseline."


@pytest.mark.slow
def test_a_sweep_without_a_design_point_is_compared_as_well() -> None:
    swept = study("inclined", "device.length_m=")
    assert swept.solution.design is None
    assert diff(swept.to_dict(), swept) == ()
    (moved,) = of(
        "critical point", diff(swept.to_dict(), study("inclined", "device.length_m=", "device.restitution=0.52"))
    )
    assert moved.after == study("inclined", "device.restitution=0.52").solution.critical_points[0].sweep_value


def test_a_moved_critical_point_is_found_and_rounding_is_not() -> None:
    baseline = results()
    b1 = baseline["critical_points"][0]
    b1["sweep_value"] *= 1 + 1e-9
    assert diff(baseline, study("inclined")) == ()
    b1["sweep_value"] *= 1.001
    (change,) = diff(baseline, study("inclined"))
    assert change.group == "critical point"
    assert change.after == pytest.approx(0.629457141, rel=1e-8)
    assert change.change == pytest.approx(-0.001, rel=1e-2)
    assert "B1" in change.sentence
    b1["error_bound"] = 0.01
    assert diff(baseline, study("inclined")) == ()
    b1["error_bound"] = 0.0
    assert diff(baseline, study("inclined"), relative=0.01) == ()


def test_a_changed_scenario_tells_cause_and_effect() -> None:
    rows = diff(results(), study("inclined", "device.restitution=0.52"))
    assert [(x.quantity, x.before, x.after) for x in of("scenario", rows)] == [("device.restitution", 0.5, 0.52)]
    (moved,) = of("critical point", rows)
    (start,) = of("stable range", rows)
    assert (
        moved.after
        == start.after
        == study("inclined", "device.restitution=0.52").solution.critical_points[0].sweep_value
    )
    before = {x.quantity: x.before for x in of("margin", rows)}
    for symbol, share in (("s", -9.2216), ("f", -4.7223)):
        name = f"margin from the design point to the period doubling below, in {symbol}"
        assert before[name] == pytest.approx(share, abs=1e-4)
    assert {x.unit for x in of("voltage", rows)} == {"V"}
    assert len(of("voltage", rows)) == 3


def test_a_point_that_appears_does_not_rename_the_others() -> None:
    wide = study("horizontal", "sweep.from=0.02", "sweep.to=0.75")
    rows = diff(results("horizontal"), wide)
    before = {(x["kind"], round(x["d"], 9)) for x in results("horizontal")["critical_points"]}
    now = {(x.event, round(x.d, 9)) for x in wide.solution.critical_points}
    assert before < now
    assert len(of("critical point", rows)) == len(now - before)
    assert all(x.before is None for x in of("critical point", rows))
    assert not of("margin", rows)


def test_a_point_that_is_gone_is_told_apart_from_one_that_has_its_label_now() -> None:
    baseline = results()
    b1 = baseline["critical_points"][0]
    baseline["critical_points"].insert(0, b1 | {"sweep_value": 0.6, "d": 0.4})
    for point in (b1, *(x for x in baseline["design_point"]["margins"] if x["label"] == "B1")):
        point["label"] = "B2"
    (gone,) = diff(baseline, study("inclined"))
    assert gone.quantity == "B1 of the baseline, period doubling of the asymmetric motion, s"
    assert (gone.before, gone.after) == (0.6, None)


def test_what_vanishes_is_told() -> None:
    rows = diff(results(), study("inclined", "inclination_deg=60"))
    assert [x.after for x in of("design point", rows)] == ["none"]
    (gone,) = of("critical point", rows)
    assert gone.after is None
    assert "gone" in gone.sentence
    ends = [0.6294571410117573, 0.75]
    assert [(x.before, x.after) for x in of("stable range", rows)] == [(pytest.approx(end), None) for end in ends]
    assert {x.quantity.split()[0] for x in of("alert", rows)} >= {"VR001", "VR003"}
    assert all(x.after is None for x in of("voltage", rows))


def test_a_margin_of_another_family_is_told_from_that_which_is_gone() -> None:
    rows = diff(results("horizontal"), study("horizontal", "inclination_deg=5"))
    above = "margin from the design point to the fold above, in s"
    gone, new = (
        next(row for row in rows if row.quantity == f"{above}, of the {family} motion")
        for family in ("symmetric", "asymmetric")
    )
    assert (gone.before, gone.after) == (pytest.approx(164.705001043), None)
    assert new.before is None
    assert len({row.quantity for row in rows}) == len(rows)


def test_another_swept_parameter_is_compared_in_d() -> None:
    rows = diff(results(), study("inclined", "sweep.parameter=amplitude_n", "sweep.from=3", "sweep.to=6"))
    (moved,) = [x for x in of("critical point", rows) if "B1" in x.quantity]
    assert moved.unit == "1"
    assert moved.quantity.endswith(", d")
    assert moved.before == pytest.approx(0.4179595416, rel=1e-9)
    assert [x.quantity for x in of("stable range", rows)] == ["stable range from, d", "stable range to, d"]


def test_what_a_sweep_of_the_inclination_cannot_have_in_d_is_not_gone() -> None:
    rows = diff(results(), study("inclined", "sweep.parameter=inclination_deg", "sweep.from=0", "sweep.to=80"))
    assert not of("stable range", rows)
    assert not of("margin", rows)
    assert len(of("critical point", rows)) == 2


def test_what_error_bounds_leave_open_is_no_change() -> None:
    baseline = results()
    baseline["stable_range"][0]["from"] *= 1.001
    baseline["design_point"]["margins"][0]["relative"] *= 1.001
    assert {x.group for x in diff(baseline, study("inclined"))} == {"stable range", "margin"}
    baseline["stable_range"][0]["from_error_bound"] = 0.01
    baseline["design_point"]["margins"][0]["error_bound"] = 0.01
    assert diff(baseline, study("inclined")) == ()


def test_a_requirement_that_is_not_met_any_more_is_told() -> None:
    baseline, now = results(), copy.deepcopy(study("inclined").to_dict())
    baseline["requirements"] = {"passed": True, "criteria": [{"key": "u_ave_at_least_v", "passed": True}]}
    now["requirements"] = {"passed": False, "criteria": [{"key": "u_ave_at_least_v", "passed": False}]}
    (change,) = diff(baseline, now)
    assert change.sentence == "requirements.u_ave_at_least_v: met to not met."


def test_texts_have_the_numbers() -> None:
    rows = diff(results(), study("inclined", "device.restitution=0.52"))
    text = diff_text(rows, "old.json")
    assert text.startswith(f"{len(rows)} changes since old.json:")
    assert "0.629 m to 0.625 m" in text
    table = diff_markdown(rows, "old|.json")
    assert "old\\|.json" in table
    lines = [line for line in table.splitlines() if line.startswith("|")]
    assert len(lines) == len(rows) + 2
    data = json.loads(diff_json(rows))
    assert data["changed"] is True
    assert [x["after"] for x in data["changes"]] == [x.after for x in rows]
    assert set(data["changes"][0]) == {"group", "what", "before", "after", "unit", "change"}


def test_numbers_are_told_with_the_digits_in_which_they_differ() -> None:
    baseline = results()
    baseline["critical_points"][0]["sweep_value"] *= 1 + 2e-6
    (change,) = diff(baseline, study("inclined"))
    ((_, _, before, after, _),) = changes_table([change]).rows
    assert before != after
    assert before.startswith("0.62945")


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
    assert diff(read_baseline(path), study("inclined")) == ()
    with pytest.raises(UsageError, match="cannot be read"):
        read_baseline(tmp_path / "none.json")
    later = results() | {"schema_version": 99}
    with pytest.raises(UsageError, match="schema_version 99"):
        diff(later, study("inclined"))
    broken = results()
    del broken["critical_points"][0]["kind"]
    with pytest.raises(UsageError, match=r"critical_points\[0\]\.kind: is missing"):
        diff(broken, study("inclined"))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), 10**400, -(10**400)])
def test_a_baseline_of_numbers_that_are_none_is_refused(value, tmp_path: Path, capsys) -> None:
    path, data = tmp_path / "results.json", results()
    data["branches"][0]["velocity_bottom"][3] = value
    path.write_text(json.dumps(data))
    assert main(["compare", "--exit-code", str(path), str(EXAMPLES / "inclined.yaml")]) == 2
    err = capsys.readouterr().err
    assert "branches[0].velocity_bottom[3]" in err
    assert "finite" in err


@pytest.mark.parametrize("tolerance", ["nan", "inf", "-1"])
def test_a_tolerance_that_hides_changes_is_refused(tolerance: str, tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text(json.dumps(results()))
    assert main(["compare", "--exit-code", str(path), str(EXAMPLES / "inclined.yaml"), "--tolerance", tolerance]) == 2


@pytest.mark.slow
def test_standard_input_is_the_baseline_or_the_scenario(tmp_path: Path, monkeypatch, capsys) -> None:
    scenario, before = EXAMPLES / "inclined.yaml", json.dumps(results()).encode()
    (tmp_path / "results.json").write_bytes(before)
    for given, arguments in (
        (before, ["-", str(scenario)]),
        (scenario.read_bytes(), [str(tmp_path / "results.json"), "-"]),
    ):
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(given)))
        assert main(["compare", "--exit-code", *arguments]) == 0
        assert "No change" in capsys.readouterr().out
    assert main(["compare", "--exit-code", "-", "-"]) == 2


def test_text_of_a_baseline_is_text(tmp_path: Path, capsys) -> None:
    data = results()
    data["alerts"].append({"code": "\x1b[2J\n::error::", "title": "x" * 9000, "severity": "note\n::warning::"})
    (tmp_path / "results.json").write_text(json.dumps(data))
    assert main(["compare", "--exit-code", str(tmp_path / "results.json"), str(EXAMPLES / "inclined.yaml")]) == 1
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert "::" not in out
    assert len(out) < 1000


@pytest.mark.parametrize(
    ("place", "value"),
    [("gravity_m_s2", 1e-320), ("gravity_m_s2", 1e308), ("excitation", {}), ("sweep", [1]), ("device", None)],
)
def test_a_baseline_of_a_scenario_that_cannot_be_is_refused_or_compared(place, value) -> None:
    data = results()
    data["scenario"][place] = value
    outcome: tuple[ComparisonRow, ...] | str
    try:
        outcome = diff(data, study("inclined"))
    except UsageError as error:
        outcome = str(error)
    assert outcome


@pytest.mark.slow
def test_a_report_tells_what_has_changed_since_a_baseline(tmp_path: Path, capsys) -> None:
    old, scenario = tmp_path / "results.json", str(EXAMPLES / "design-point.yaml")
    old.write_text(_results("design-point"))
    run = ["run", scenario, "--baseline", str(old), "--format", "html,pdf,markdown,json,junit"]
    changed = ["--set", "device.restitution=0.52"]
    files = {}
    for name, more in (("changed", changed), ("again", changed), ("same", [])):
        assert main([*run, "-o", str(tmp_path / name), *more]) == 0
        files[name] = {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()}
        told = capsys.readouterr().out
        assert ("device.restitution: 0.5 to 0.52 (+4 %)" in told) == bool(more)
        assert ("No change beyond tolerance" in told) != bool(more)
    assert files["changed"] == files["again"]
    row = ("scenario", "device.restitution", "0.5", "0.52", "+4 %")
    rows = diff(results("design-point"), study("design-point", *changed[1:]))
    table = Page(files["changed"]["report.html"]).tables[f"{len(rows)} changes since the baseline"]
    assert table.columns("Group", "What", "Before", "Now", "Change")[0] == row
    assert len(table.rows) == len(rows) + 1
    assert f"| {' | '.join(row)} |" in files["changed"]["summary.md"].decode()
    for name, words in (("changed", "".join(row)), ("same", "No change beyond tolerance since the baseline.")):
        sheets = PdfReader(io.BytesIO(files[name]["report.pdf"])).pages
        assert squeeze(words) in squeeze("".join(sheet.extract_text() for sheet in sheets))
    assert "No change beyond tolerance since the baseline." in Page(files["same"]["report.html"]).text
    assert "No change beyond tolerance since the baseline." in files["same"]["summary.md"].decode()


@pytest.mark.slow
def test_a_report_has_the_text_of_a_baseline_as_text(tmp_path: Path) -> None:
    data, hostile = results("design-point"), "<script>alert(1)</script> #panic() | `"
    data["alerts"].append({"code": "VR0", "title": hostile, "severity": "note"})
    (tmp_path / "results.json").write_text(json.dumps(data))
    run = ["run", str(EXAMPLES / "design-point.yaml"), "--baseline", str(tmp_path / "results.json")]
    assert main([*run, "-o", str(tmp_path), "--format", "html,markdown", "-q"]) == 0
    assert hostile in Page((tmp_path / "report.html").read_bytes()).text
    summary = (tmp_path / "summary.md").read_text()
    assert "<script" not in summary
    assert "#panic() \\| \\`" in summary


def test_a_run_refuses_a_bad_baseline_before_it_computes(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setattr("vireport.cli.outputs.analyse", lambda *_: pytest.fail("it has computed"))
    path, scenario = tmp_path / "results.json", str(EXAMPLES / "inclined.yaml")
    broken = results()
    del broken["critical_points"][0]["kind"]
    for text, message in (
        ("{", "is no JSON"),
        (json.dumps(broken), "results.json: critical_points[0].kind: is missing"),
    ):
        path.write_text(text)
        assert main(["run", scenario, "--baseline", str(path), "-o", str(tmp_path / "out")]) == 2
        assert message in capsys.readouterr().err
    path.write_text(json.dumps(results()))
    assert main(["run", "-", "--baseline", "-"]) == 2
    assert main(["run", scenario, "--baseline", str(path), "--json"]) == 2
    assert "vireport compare OLD NEW --exit-code" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
