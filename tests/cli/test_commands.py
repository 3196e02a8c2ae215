"""The commands beside `run`, as their users meet them: exit codes, streams and files."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from bad_scenarios import SEVERAL
from PIL import Image

from vireport.cli.app import main
from vireport.text.foreign import visible

MAP = Path(__file__).resolve().parents[2] / "examples" / "maps" / "map.yaml"
SLOW = pytest.mark.slow
CELLS = "4,800 cells over inclination_deg x device.length_m"


@pytest.fixture
def quick(monkeypatch) -> None:
    """Of the accuracy study only the closed form, so that it takes no time."""
    from vireport.findings.accuracy import workprecision

    monkeypatch.setattr(workprecision, "METHODS", workprecision.METHODS[:2])


@pytest.mark.slow
def test_accuracy_prints_its_study_and_writes_it(quick, example, tmp_path: Path, capsys) -> None:
    text = "".join(row for row in example("inclined").read_text().splitlines(True) if "ball_mass" not in row)
    (tmp_path / "massless.yaml").write_text(text)
    folder = tmp_path / "out"
    assert main(["verify", str(tmp_path / "massless.yaml"), "-o", str(folder), "--figure-width", "86mm", "-v"]) == 0
    out = capsys.readouterr().out
    assert "closed form" in out
    assert "device.ball_mass_kg is not given" in out
    accuracy = json.loads((folder / "accuracy.json").read_text())
    errors = [
        e for run in accuracy["accuracy"]["runs"] if run["method"] == "closed form" for e in run["errors"].values()
    ]
    assert min(errors) < 1e-15
    assert accuracy["compliant"] is None
    with Image.open(folder / "figure-accuracy.png") as figure:
        assert figure.width == int(86 / 25.4 * 150)
    assert not (folder / "figure-stiffness.png").exists()


def test_a_width_of_figures_needs_a_folder_and_is_that_of_a_paper(example, tmp_path: Path, capsys) -> None:
    scenario = str(example("inclined"))
    assert main(["verify", scenario, "--figure-width", "86mm"]) == 2
    assert "give --output" in capsys.readouterr().err
    assert main(["verify", scenario, "-o", str(tmp_path / "out"), "--figure-width", "20mm"]) == 2
    assert "60 to 250 mm" in capsys.readouterr().err


@pytest.mark.slow
def test_a_report_has_the_section_where_the_scenario_asks_for_it(quick, example, tmp_path: Path) -> None:
    asked = ["--set", "accuracy.repeats=1", "--set", "accuracy.compliant_membrane=false"]
    folder = tmp_path / "out"
    assert main(["run", str(example("inclined")), *asked, "-o", str(folder), "--format", "html,json,png", "-q"]) == 0
    page = (folder / "report.html").read_text()
    assert "Each method finds the stable 1:1 motion at" in page
    assert "Without a guess, every motion and critical point of the sweep together take" in page
    assert "accuracy.compliant_membrane is false" in page or "compliant_membrane is false" in page
    assert (folder / "figure-accuracy.png").exists()
    results = json.loads((folder / "results.json").read_text())
    assert results["accuracy"]["quantities"]
    assert results["compliant"] is None


def test_certify_prints_enclosures_and_keeps_them(example, tmp_path: Path, capsys) -> None:
    pytest.importorskip("flint")
    code = main(["run", str(example("inclined")), "--certify", "-o", str(tmp_path), "--format", "json"])
    assert code == 0
    assert "0.6294571410117573492782814" in capsys.readouterr().out
    (certificate,) = json.loads((tmp_path / "results.json").read_text())["certificates"]
    assert certificate["proved"]
    assert certificate["bound_holds"]


def test_proofs_that_are_taken_out_are_no_option(example, monkeypatch, capsys) -> None:
    monkeypatch.setattr("vireport.cli.commands.ADDITIONS", {})
    assert main(["run", str(example("inclined")), "--json", "--certify"]) == 2
    assert capsys.readouterr().err == "vireport: error: No such option: --certify\n"


def test_certify_without_a_sweep_says_that_there_is_nothing(example, tmp_path: Path, capsys) -> None:
    pytest.importorskip("flint")
    main(["run", str(example("design-point")), "--certify", "-o", str(tmp_path), "--format", "json"])
    assert "no sweep" in capsys.readouterr().out


@pytest.fixture
def earlier(example, tmp_path: Path, capsys) -> Callable[[str], str]:
    """The file of a name that a run of the inclined example writes."""

    def written(name: str) -> str:
        form = Path(name).suffix[1:]
        assert main(["run", str(example("inclined")), "-o", str(tmp_path), "--format", form, "-q"]) == 0
        return str(tmp_path / name)

    return written


@pytest.mark.parametrize("name", ["results.json", *(pytest.param(f"report.{x}", marks=SLOW) for x in ("html", "pdf"))])
def test_what_has_changed_since_an_earlier_run_by_the_exit_code(name: str, earlier, example, tmp_path, capsys) -> None:
    scenario, old = str(example("inclined")), earlier(name)
    longer = [scenario, "--set", "device.restitution=0.51"]
    assert main(["compare", old, scenario, "--exit-code"]) == 0
    assert main(["compare", old, *longer, "--exit-code", "--markdown"]) == 1
    assert "B1" in capsys.readouterr().out
    assert main(["compare", old, *longer, "--exit-code", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["changed"]
    assert main(["run", *longer, "--baseline", old, "-o", str(tmp_path / "out"), "--format", "csv"]) == 0
    assert "device.restitution: 0.5 to 0.51 (+2 %)" in capsys.readouterr().out
    assert main(["compare", str(tmp_path / "absent.json"), scenario, "--exit-code"]) == 2


def test_two_earlier_runs_are_compared_by_the_results_that_they_wrote(
    earlier, tmp_path: Path, monkeypatch, capsys
) -> None:
    monkeypatch.setattr("vireport.study.study.analyse", lambda *_: pytest.fail("it was solved"))
    data = json.loads(Path(earlier("results.json")).read_text())
    (tmp_path / "old.json").write_text(json.dumps(data))
    data["critical_points"][0]["sweep_value"] *= 1.01
    (tmp_path / "new.json").write_text(json.dumps(data))
    files = [str(tmp_path / name) for name in ("old.json", "new.json")]
    assert main(["compare", files[0], files[0], "--exit-code"]) == 0
    assert main(["compare", *files, "--exit-code"]) == 1
    assert "B1" in capsys.readouterr().out


def test_a_comparison_solves_an_earlier_run_again_and_says_what_is_not_the_same(earlier, tmp_path, capsys) -> None:
    old = Path(earlier("results.json"))
    data = json.loads(old.read_text())
    data["critical_points"][0]["sweep_value"] *= 1.01
    (tmp_path / "other.json").write_text(json.dumps(data))
    assert main(["compare", str(old), str(tmp_path / "other.json"), "--json"]) == 0
    out, err = capsys.readouterr()
    first, second = json.loads(out)["scenarios"]
    assert first["scenario"] == second["scenario"] == data["scenario"]
    same, different, *_ = err.splitlines()
    assert same == f"identical to the results in {old}"
    assert different.startswith(f"not identical to the results in {tmp_path / 'other.json'}")


def test_compare_writes_its_files(example, tmp_path: Path) -> None:
    files = [str(example("inclined")), str(example("design-point"))]
    assert main(["compare", *files, "-o", str(tmp_path), "--format", "json,csv", "-q"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"compare.json", "compare.csv"}
    assert main(["compare", files[0]]) == 2


@pytest.mark.parametrize("alone", [True, False])
def test_extremes_by_its_exit_code(alone: bool, monkeypatch, capsys) -> None:
    from vireport.base.errors import NumericalError
    from vireport.verify import catalogue
    from vireport.verify.rows import Case

    def refused():
        raise NumericalError("a reason")

    row = Case("test", "made up", refused, refusal="reason" if alone else "other")
    monkeypatch.setattr(catalogue, "catalogue", lambda loaded=None: (row,))
    assert main(["verify", "--extremes"]) == (0 if alone else 1)
    told = capsys.readouterr().out
    assert ("FAILED  test: made up: refused: a reason" in told) == (not alone)
    assert ("All 1 extreme cases" in told) == alone
    assert main(["verify", "--extremes", "-v"]) == (0 if alone else 1)
    assert "test: made up: refused: a reason" in capsys.readouterr().out
    assert main(["verify", "--extremes", "--set", "inclination_deg=1"]) == 2


def test_extremes_of_which_none_applies_are_no_pass(monkeypatch, capsys) -> None:
    from vireport.verify import catalogue
    from vireport.verify.rows import Case, CaseFinding, NotThereError

    def absent():
        raise NotThereError("no such point")

    right, not_there = Case("test", "right", lambda: CaseFinding("")), Case("test", "absent", absent)
    for cases, code in (([right, right], 0), ([right, not_there], 0), ([not_there], 3)):
        monkeypatch.setattr(catalogue, "catalogue", lambda loaded=None, cases=cases: cases)
        assert main(["verify", "--extremes"]) == code
        assert ("case" in capsys.readouterr().err) == (code != 0)


def test_explain(capsys) -> None:
    assert main(["explain", "vr010"]) == 0
    assert capsys.readouterr().out.startswith("VR010 (note or warning)")
    assert main(["explain", "VR999"]) == 2


@pytest.mark.slow
def test_sweep_writes_a_map(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    text = MAP.read_text().replace("count: 60", "count: 5").replace("count: 80", "count: 4")
    (tmp_path / "map.yaml").write_text(text)
    arguments = ["map", str(tmp_path / "map.yaml"), "-o", str(tmp_path / "m"), "-q"]
    assert main([*arguments, "--no-figures", "--workers", "1"]) == 0
    first = (tmp_path / "m" / "map.parquet").read_bytes()
    assert main([*arguments, "--no-figures"]) == 0
    assert (tmp_path / "m" / "map.parquet").read_bytes() == first


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ("length_m", "does not name two inputs"),
        ("length_m,lenght_m", "unknown input 'lenght_m'; did you mean 'length_m'? (allowed: length_m, amplitude_n"),
        ("length_m,length_m", "length_m is named twice"),
        ("length_m=1..0.3,restitution", "length_m: 1..0.3 is no range of it (allowed: ascending, from"),
        ("length_m=a..b,restitution", "'a..b' is no range (such as"),
        ("restitution=0.2..1.2,length_m", "restitution: 0.2..1.2 is no range of it"),
        ("length_m,amplitude_n", "device.restitution is 1 (allowed: above 0 and up to 0.999999, or as one of"),
    ],
)
def test_a_chart_says_what_is_wrong_with_its_inputs(over: str, message: str, example, capsys) -> None:
    assert main(["map", str(example("inclined")), "--over", over, "--set", "device.restitution=1"]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("over", "pair"),
    [
        ("restitution,restitution_top", "restitution and restitution_top overlap"),
        ("capsule_mass_kg,restitution", "are a restitution and the mass of a free capsule (allowed: at most one"),
    ],
)
def test_a_chart_needs_an_input_that_can_be_swept(over: str, pair: str, example, capsys) -> None:
    assert main(["map", str(example("inclined")), "--over", over, "--set", "device.capsule=free"]) == 2
    assert pair in capsys.readouterr().err


@pytest.mark.parametrize("bad", SEVERAL, ids=lambda bad: bad.name)
def test_mistakes_as_data_are_those_that_are_told(bad, tmp_path: Path, capfd) -> None:
    path = tmp_path / "broken.yaml"
    path.write_bytes(bad.text if isinstance(bad.text, bytes) else bad.text.encode("utf-8", "surrogatepass"))
    assert main(["check", str(path), "--json"]) == 2
    out, err = capfd.readouterr()
    assert err == ""
    told = json.loads(out)
    assert (told["valid"], told["kind"]) == (False, None)
    assert main(["check", str(path)]) == 2
    parts = [(f"{of['file']}:{of['line']}", of["path"], of["message"]) for of in told["mistakes"]]
    assert capfd.readouterr().err.splitlines() == [visible(": ".join(filter(None, part))) for part in parts]


def test_a_mistake_on_the_command_line_is_in_no_file(example, capsys) -> None:
    assert main(["check", str(example("inclined")), "--json", "--set", "inclination_deg=100"]) == 2
    ((mistake,),) = [json.loads(capsys.readouterr().out)["mistakes"]]
    assert (mistake["file"], mistake["line"], mistake["path"]) == (None, None, "inclination_deg")
    assert "a number from 0 to 90" in mistake["message"]


@pytest.mark.parametrize(("file", "kind"), [(MAP, "map"), (MAP.parents[1] / "inclined.yaml", "scenario")])
def test_a_valid_file_as_data(file: Path, kind: str, capsys) -> None:
    assert main(["check", str(file), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["valid"], told["kind"], told["mistakes"], told["alerts"]) == (True, kind, [], [])
    cells = {"step": "cells", "runs": True, "what": CELLS, "why": "the file has a map block"}
    assert (told["steps"] == [cells]) == (kind == "map")


def test_a_file_that_is_not_there_is_no_mistake_in_it(capsys) -> None:
    assert main(["check", "nowhere.yaml", "--json"]) == 2
    out, err = capsys.readouterr()
    assert (out, err) == ("", "vireport: error: nowhere.yaml: no such file\n")


def test_a_plan_as_data_has_what_results_say_of_it(example, study_of, capsys) -> None:
    assert main(["check", str(example("inclined")), "--json"]) == 0
    steps = json.loads(capsys.readouterr().out)["steps"]
    assert {step["step"]: step["runs"] for step in steps}["branches"] is True
    left_out = [{key: step[key] for key in ("step", "what", "why")} for step in steps if not step["runs"]]
    assert left_out == study_of("inclined").to_dict()["left_out"]
