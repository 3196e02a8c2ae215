"""`vireport identify` as its users meet it: the example and its truth, files, exit codes, and the device it gives."""

from __future__ import annotations

import json
import re
import shutil
import wave
from pathlib import Path

import numpy as np
import pytest
from msgspec import convert
from pages import Page, lines_of, read_back
from pypdf import PdfReader

from vireport import load
from vireport.cli.app import main
from vireport.identify.results import IdentifiedData

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SCENARIO, IMPACTS = str(EXAMPLES / "measured.yaml"), str(EXAMPLES / "measured-impacts.csv")
FEW = "--format", "html"
PICKED = "What was picked. 43 impacts picked from prototype.wav."
TRUTH = {"restitution_bottom": 0.52, "restitution_top": 0.47}


def text_of(page: Path) -> str:
    return Page(page.read_bytes()).text


def silenced(folder: Path) -> str:
    """The example's record of raw signals, without a voltage after two seconds."""
    with (
        wave.open(str(EXAMPLES / "records" / "prototype.wav")) as whole,
        wave.open(str(folder / "few.wav"), "wb") as few,
    ):
        few.setparams(whole.getparams())
        samples = np.frombuffer(whole.readframes(whole.getnframes()), np.int16).reshape(-1, 2).copy()
        quiet = samples[: whole.getframerate() // 50, 0]  # before the first impact: the noise alone
        late = samples[2 * whole.getframerate() :, 0]
        late[:] = np.resize(quiet, len(late))
        few.writeframes(samples.tobytes())
    shutil.copy(EXAMPLES / "records" / "prototype.wav.yaml", folder / "few.wav.yaml")
    return str(folder / "few.wav")


def identified(capsys, *arguments: str) -> dict:
    assert main(["identify", SCENARIO, "--impacts", IMPACTS, "--json", *arguments]) == 0
    results = json.loads(capsys.readouterr().out)
    assert convert(results, IdentifiedData).misfit.accepted == results["misfit"]["accepted"]
    return results


@pytest.mark.slow
def test_the_example_is_identified_with_its_truth(capsys, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    assert main(["identify", SCENARIO, "--impacts", IMPACTS, "--clock", "force", "-o", str(folder), *FEW]) == 0
    printed = capsys.readouterr().out.splitlines()
    page = (EXAMPLES.parent / "docs" / "identify.md").read_text()
    assert len(printed) == 3
    assert all(line in page for line in printed)
    results = json.loads((folder / "identified.json").read_text())
    assert results == identified(capsys, "--clock", "force") | {"provenance": results["provenance"]}
    for row in results["identified"]:
        assert row["from"] < TRUTH[row["name"]] < row["to"]
        assert row["standard_error"] < 2e-4
    assert results["timing_error_s"] == pytest.approx(1e-4, rel=0.1)
    assert len(results["missed"]) == 7
    assert len(results["false"]) == 1
    assert results["misfit"]["accepted"]
    scenario = load(folder / "identified.yaml").scenario
    # Beside the scenario is the record, which it shows.
    record = "measured:\n- impacts: impacts.csv\n  force_maximum_s: 0.0\n"
    assert (folder / "identified.yaml").read_text() == results["scenario"] + record
    assert (folder / "impacts.csv").read_bytes() == Path(IMPACTS).read_bytes()
    for row in results["identified"]:
        assert getattr(scenario.device, row["name"]) == row["value"]
        assert getattr(scenario.tolerances, row["name"]) == pytest.approx(row["to"] - row["value"])
    assert scenario.tolerances.length_m == 0.0002


@pytest.mark.slow
def test_its_report_begins_as_others_do_and_says_nothing_twice(tmp_path: Path) -> None:
    (tmp_path / "words").mkdir()
    (tmp_path / "words" / "words").mkdir()
    words = (EXAMPLES.parent / "vireport" / "identify" / "templates" / "words" / "identify.j2").read_text()
    (tmp_path / "words" / "words" / "identify.j2").write_text(words.replace("The record fits: ", "It fits: "))
    folder, given = tmp_path / "out", ["identify", SCENARIO, "--impacts", IMPACTS, "--clock", "force"]
    paged = ["--templates", str(tmp_path / "words"), "--paper", "letter", "-o", str(folder)]
    assert main([*given, *paged, "-q"]) == 0
    data = {"identified.json", "identified.yaml", "impacts.csv"}
    assert {path.name for path in folder.iterdir()} == data | {"report.html", "report.pdf", "figure-impacts.png"}
    assert [float(x) for x in PdfReader(folder / "report.pdf").pages[0].mediabox] == [0, 0, 612, 792]
    printed = text_of(folder / "report.html")
    assert printed.index("Identified from measured-impacts.csv") < printed.index("It fits: restitution 0.51996 at the")
    assert printed.index("Errors of the impact times. Measured less fitted times of 393 impacts.") > printed.index("µs")
    assert printed.count("restitution at the bottom 0.519962 0.000036 0.519891 0.520033") == 1
    assert printed.count("101 µs") == printed.count("7 missed, 1 false") == printed.count("0.77") == 1
    assert len(re.findall("of 4096|4,096", printed)) == 1
    assert main([*given, "-o", str(tmp_path / "few"), "-q", "--format", "svg"]) == 0
    assert {path.name for path in (tmp_path / "few").iterdir()} == data | {"figure-impacts.svg"}


@pytest.mark.slow
def test_the_report_of_raw_signals_has_their_figure_also_where_nothing_is_identified(tmp_path: Path, capsys) -> None:
    given = ["identify", SCENARIO, "--record", str(EXAMPLES / "records" / "prototype.wav"), "--format", "html"]
    assert main([*given, "-o", str(tmp_path / "a"), "-q"]) == 0
    printed = text_of(tmp_path / "a" / "report.html")
    assert printed.index("Errors of the impact times.") < printed.index("43 impacts picked") < printed.index(PICKED)
    assert "prototype.wav: WAV: 2 channels, 44,000 samples at 250 us" in printed  # of no folder
    assert printed.count("voltage_v is sampled slowly") == 1
    assert ", scaled to the median standard error. Where" in printed
    given[3] = silenced(tmp_path)
    assert main([*given, "-o", str(tmp_path / "b")]) == 3
    assert capsys.readouterr().out.startswith("The record does not determine what is asked for.")
    printed = text_of(tmp_path / "b" / "report.html")
    refused = printed.index("The record is too short: at least 12 impacts")
    assert (
        printed.index("The record does not determine what is asked for.") < refused < printed.index("What was picked.")
    )
    assert printed.index("What was picked. 8 impacts picked from") > printed.index("8 impacts picked: 8 in voltage_v")
    assert "Errors of the impact times" not in printed


@pytest.mark.slow
def test_all_numbers_are_printed_where_they_are_asked_for(capsys, tmp_path: Path) -> None:
    given = ["identify", SCENARIO, "--impacts", IMPACTS, "--clock", "force", "-o", str(tmp_path), "-v"]
    assert main(given) == 0
    page = (EXAMPLES.parent / "docs" / "identify.md").read_text()
    printed = capsys.readouterr().out.splitlines()
    assert "Identified, with 95 % intervals" in printed
    assert all(line.strip() in page for line in printed)


@pytest.mark.slow
def test_the_identified_device_names_no_other_record(capsys) -> None:
    found = identified(capsys, "--clock", "force", "--set", "excitation.record=records/shaker.wav")
    assert found["misfit"]["accepted"]
    assert "record:" not in found["scenario"]


@pytest.mark.slow
def test_the_identified_device_runs(capsys, tmp_path: Path) -> None:
    (tmp_path / "identified.yaml").write_text(identified(capsys, "--clock", "force")["scenario"])
    assert main(["run", str(tmp_path / "identified.yaml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["design_point"]["stability"]


def test_a_record_that_fits_is_told_as_is_kept(capsys, tmp_path: Path) -> None:
    head, *rows = Path(IMPACTS).read_text().splitlines(True)
    (tmp_path / "few.csv").write_text(head + "".join(rows[:120]))
    given = ["identify", SCENARIO, "--impacts", str(tmp_path / "few.csv"), "--clock", "force", *FEW, "-v"]
    assert main([*given, "-o", str(tmp_path / "out")]) == 0
    assert read_back("identify, terminal", capsys.readouterr().out.splitlines()) == []
    assert read_back("identify", lines_of((tmp_path / "out" / "report.html").read_bytes())) == []
    results = json.loads((tmp_path / "out" / "identified.json").read_text())
    assert [row["from"] < TRUTH[row["name"]] < row["to"] for row in results["identified"]] == [True, True]


def test_a_record_that_contradicts_the_model_gives_no_interval(capsys, tmp_path: Path) -> None:
    swapped = Path(IMPACTS).read_text().replace("top", "x").replace("bottom", "top").replace("x", "bottom")
    (tmp_path / "swapped.csv").write_text(swapped)
    arguments = ["identify", SCENARIO, "--impacts", str(tmp_path / "swapped.csv"), "--clock", "force", *FEW]
    assert main([*arguments, "-o", str(tmp_path / "out")]) == 1
    sentence, numbers, fact = capsys.readouterr().out.splitlines()
    assert sentence == "The record contradicts the model: bottom and top are exchanged."
    assert numbers.startswith("Identified: nothing; Fit: none; Impacts: 394; What fits: bottom and top exchanged")
    assert fact == "With bottom and top exchanged the model fits: exchange them in the record, or the sensors."
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["identified.json", "report.html"]
    assert read_back("identify, contradicted", lines_of((tmp_path / "out" / "report.html").read_bytes())) == []
    results = json.loads((tmp_path / "out" / "identified.json").read_text())
    assert results["identified"] == results["covariance"] == []
    assert convert(results, IdentifiedData).misfit.alternative == "swapped_membranes"
    assert results["scenario"] is None


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--impacts", "/nowhere.csv"], 2, "/nowhere.csv cannot be read"),
        (["--impacts", IMPACTS, "--free", "mass"], 2, "--free: unknown 'mass' (allowed: restitution, "),
        (["--impacts", IMPACTS, "--free", "restitution", "--free", "restitution_top"], 2, "allowed: it alone"),
        (["--impacts", IMPACTS, "--set", "device.friction=0.1", "--set", "tolerances="], 2, "of a ball with friction"),
        (["--impacts", IMPACTS, "--json", "-o", "x"], 2, "--json prints the result"),
        (
            [
                "--impacts",
                IMPACTS,
                "--set",
                "device.restitution_exponent=-0.1",
                "--set",
                "tolerances=",
                "--set",
                "device.restitution_speed_m_s=2",
            ],
            2,
            "of a restitution that falls with speed",
        ),
        (["--impacts", SCENARIO], 2, "no column is known by its name"),
    ],
)
def test_what_is_malformed_is_refused_and_nothing_written(
    arguments, code, message, capsys, tmp_path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["identify", SCENARIO, *arguments]) == code
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_record_that_does_not_hold_the_answer_is_refused(capsys, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    head, *rows = Path(IMPACTS).read_text().splitlines(True)
    Path("few.csv").write_text(head + "".join(rows[:8]))
    assert main(["identify", SCENARIO, "--impacts", "few.csv"]) == 3
    assert "the record is too short: at least 13 impacts" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["few.csv"]
