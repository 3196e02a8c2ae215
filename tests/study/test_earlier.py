"""An earlier run, from its results.json or its report: it gives the same again; tampered with, it is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from pages import render_html, render_pdf
from pypdf import PdfReader, PdfWriter

from vireport import analyse, load
from vireport.base.errors import UsageError
from vireport.cli.app import main
from vireport.report.context import Report
from vireport.scenario.blocks import to_dict
from vireport.study.earlier import earlier_run, read_earlier
from vireport.study.provenance import provenance_of

SET = ("device.restitution=0.55", "title=</script><script>alert(1)</script>")


def report(example, overrides: tuple[str, ...]) -> Report:
    study = analyse(load(example("design-point"), overrides))
    return Report(study, {}, provenance_of(study.loaded, "vireport run design-point.yaml"))


@pytest.fixture(scope="module")
def files(example) -> dict[tuple[str, bool], bytes]:
    reports = {given: report(example, SET if given else ()) for given in (True, False)}
    renders = {"report.html": render_html, "report.pdf": render_pdf}
    return {(name, given): render(reports[given]) for name, render in renders.items() for given in reports}


@pytest.fixture
def again(tmp_path: Path, capsys) -> Callable[..., tuple[int, str, str]]:
    """Exit code, standard output and standard error of running a report again."""

    def run(name: str, data: bytes, *options: str) -> tuple[int, str, str]:
        (tmp_path / name).write_bytes(data)
        code = main(["run", str(tmp_path / name), "--json", *options])
        return code, *capsys.readouterr()

    return run


def attaching(texts: dict[str, str], password: str = "") -> bytes:
    writer, file = PdfWriter(), BytesIO()
    writer.add_blank_page(100, 100)
    for name, text in texts.items():
        writer.add_attachment(name, text.encode())
    if password:
        writer.encrypt(password, algorithm="RC4-128")
    writer.write(file)
    return file.getvalue()


def attached(pdf: bytes) -> dict[str, str]:
    return {name: contents[0].decode() for name, contents in PdfReader(BytesIO(pdf)).attachments.items()}


@pytest.mark.parametrize("given", [True, False])
@pytest.mark.parametrize("name", ["report.html", "report.pdf"])
def test_a_report_run_again_gives_identical_results(name: str, given: bool, files, again) -> None:
    code, out, err = again(name, files[name, given])
    assert code == 0
    assert err.startswith("identical to the results in ")
    results = json.loads(out)
    assert results["overrides"] == (list(SET) if given else [])
    assert results["scenario"]["device"]["restitution"] == (0.55 if given else 0.5)
    assert results["provenance"]["scenario_name"] == "design-point.yaml"
    assert results["own_stiffness"]["ends"], "contacts are long here, so that a report has the compliant motion"


def test_results_are_run_again_as_a_report_is(files, again, tmp_path: Path) -> None:
    (tmp_path / "report.html").write_bytes(files["report.html", True])
    results = read_earlier(str(tmp_path / "report.html")).results
    code, out, err = again("results.json", json.dumps(results).encode())
    assert (code, err.startswith("identical to the results in ")) == (0, True), err
    assert json.loads(out)["scenario"]["device"]["restitution"] == 0.55
    assert json.loads(out)["provenance"]["scenario_name"] == "design-point.yaml"


def test_a_scenario_in_json_is_no_results(example, again, tmp_path: Path) -> None:
    scenario = to_dict(load(example("design-point")).scenario)
    code, out, err = again("scenario.json", json.dumps(scenario).encode())
    assert (code, err) == (0, "")
    assert json.loads(out)["design_point"]["stability"]
    assert earlier_run(str(tmp_path / "scenario.json")) is None


def test_both_carry_the_file_and_the_results(files, example, tmp_path: Path) -> None:
    for name in ("report.html", "report.pdf"):
        (tmp_path / name).write_bytes(files[name, True])
    page, pdf = (read_earlier(str(tmp_path / name)) for name in ("report.html", "report.pdf"))
    assert page.scenario == pdf.scenario == example("design-point").read_text(encoding="utf-8")
    assert page.results == pdf.results
    assert page.overrides == pdf.overrides == SET


@pytest.mark.slow
def test_a_run_from_a_report_writes_one_that_can_be_run_again(files, again, tmp_path: Path) -> None:
    (tmp_path / "report.html").write_bytes(files["report.html", True])
    assert main(["run", str(tmp_path / "report.html"), "-o", str(tmp_path / "out"), "--format", "pdf", "-q"]) == 0
    code, _, err = again("second.pdf", (tmp_path / "out" / "report.pdf").read_bytes())
    assert (code, err.startswith("identical")) == (0, True)


def test_what_is_set_over_a_report_differs_from_it(files, again) -> None:
    code, out, err = again("report.html", files["report.html", True], "--set", "device.length_m=0.71")
    assert code == 0
    assert json.loads(out)["overrides"] == [*SET, "device.length_m=0.71"]
    assert "scenario: device.length_m: " in err


def tampered(texts: dict[str, str], change: Callable[[dict[str, Any]], object]) -> bytes:
    results = json.loads(texts["results.json"])
    change(results)
    return attaching(texts | {"results.json": json.dumps(results)})


def test_a_changed_value_is_named_however_small_the_change(files, again) -> None:
    def change(results: dict[str, Any]) -> None:
        results["design_point"]["q"][0] *= 1 + 1e-15

    code, _, err = again("report.pdf", tampered(attached(files["report.pdf", False]), change))
    assert code == 0
    assert "not identical" in err
    assert "1 value (design_point.q[0])" in err


def test_changes_are_listed_as_diff_lists_them(files, again) -> None:
    def change(results: dict[str, Any]) -> None:
        results["alerts"] = []
        results["accuracy"] = {"runs": [{"seconds": 1.0}]}

    _, _, err = again("report.pdf", tampered(attached(files["report.pdf", False]), change))
    assert "accuracy, alerts" in err
    assert "alert: VR010" in err


def test_measured_times_and_origin_are_not_compared() -> None:
    from vireport.report.changes.diff_outputs import unequal

    old = {"runs": [{"seconds": 1.0, "errors": {"d": 1e-9}}], "provenance": {"python": "3.11"}, "line": 7}
    new = {"runs": [{"seconds": 2.0, "errors": {"d": 2e-9}}], "provenance": {"python": "3.12"}, "line": None}
    assert list(unequal(old, new)) == ["runs[0].errors.d"]


@pytest.mark.slow
def test_what_is_no_report_is_refused(files, again) -> None:
    texts = attached(files["report.pdf", False])
    newer = {"scenario.yaml": texts["scenario.yaml"].replace("schema_version: 1", "schema_version: 2")}
    cases = {
        "carries no scenario with its results": [
            attaching({}),
            attaching({"scenario.yaml": texts["scenario.yaml"]}),
            b"<!DOCTYPE html><p>Hello</p>",
        ],
        "is no JSON": [b"", b"Hello"],
        "is encrypted": [attaching(texts, "secret")],
        "is no PDF that can be read": [files["report.pdf", False][:5000], b"%PDF-1.7\n"],
        "what it carries is damaged": [
            attaching(texts | {"results.json": "["}),
            attaching(texts | {"results.json": "{}"}),
            tampered(texts, lambda results: results.update(overrides=[1])),
        ],
        "schema_version 2 is not understood": [tampered(texts, lambda results: results.update(schema_version=2))],
        "design-point.yaml:": [attaching(texts | newer)],
    }
    for message, damaged in cases.items():
        for data in damaged:
            code, out, err = again("report.pdf", data)
            assert (code, out, message in err) == (2, "", True), err
            assert "Traceback" not in err


def test_a_file_larger_than_any_report_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vireport.study.earlier.LARGEST", 1 << 20)
    (tmp_path / "report.pdf").write_bytes(b"%PDF-" + bytes(1 << 20))
    with pytest.raises(UsageError, match="is larger than 1 MiB"):
        read_earlier(str(tmp_path / "report.pdf"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["/etc/hostname", "../impacts.csv", "impacts.csv"])
def test_records_of_a_report_are_beside_it_and_nowhere_else(example, tmp_path: Path, capsys, name: str) -> None:
    """Also where the report says that its scenario was in another folder."""
    (tmp_path / "made").mkdir()
    record = example("measured").with_name("measured-impacts.csv").read_bytes()
    for place in ("made/impacts.csv", "impacts.csv"):
        (tmp_path / place).write_bytes(record)
    study = analyse(load(example("measured"), ["measured=[{impacts: measured-impacts.csv}]"]))
    written = Report(study, {}, provenance_of(study.loaded, "vireport run measured.yaml"))
    page = render_html(written).replace(b'"scenario_name":"measured.yaml"', b'"scenario_name":"../../etc/x.yaml"')
    page = page.replace(b"impacts: measured-impacts.csv", f"impacts: {name}".encode())
    (tmp_path / "made/report.html").write_bytes(page)
    code = main(["run", str(tmp_path / "made/report.html"), "--json"])
    said = capsys.readouterr()
    if name == "impacts.csv":
        assert code == 0
        assert json.loads(said.out)["measured"][0]["impacts"]
        return
    assert code == 2
    assert f"{name}: leads out of the folder of the scenario" in said.err
    assert len(said.err.splitlines()) == 1
    assert main(["run", str(tmp_path / "made/report.html"), "--json", "--allow-outside"]) == 2 * name.startswith("/etc")
