"""`vireport identify --inspect`: what is said of a file, the block to paste, and the picture."""

from __future__ import annotations

import json
from pathlib import Path

import layouts
import numpy as np
import pytest
import yaml

from vireport.cli.app import main
from vireport.identify.record_figure import drawn_rows
from vireport.identify.results import InspectedData
from vireport.measurement.inspection import inspect, record_lines
from vireport.measurement.recordings import read_recording
from vireport.scenario.blocks import LayoutBlock
from vireport.study.reading import read_record

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LAYOUTS = {layout.format: layout for layout in layouts.layouts()}


def flawed(folder: Path) -> Path:
    """An export of a phone with uneven times, a gap, a time that stands twice, a blank cell, and clipping."""
    t = np.cumsum(np.random.default_rng(0).uniform(0.8, 1.2, 2000)) * 1e-3
    x, z = np.clip(3 * np.sin(20 * t), -1.5, 1.5), 24 * np.cos(4 * np.pi * t)
    rows = [f"{a:.6f},{b:.4f},{c:.3f}" for a, b, c in zip(t, x, z, strict=True)]
    rows[100] = rows[99]
    rows[200] = rows[200].partition(",")[0] + ",,1"
    del rows[1000:1100]
    path = folder / "phone.csv"
    path.write_text('"Time (s)","Acceleration x (m/s^2)","Acceleration z (m/s^2)"\n' + "\n".join(rows) + "\n")
    return path


def test_a_file_is_shown_with_what_is_wrong_in_it(tmp_path: Path, capsys) -> None:
    assert main(["identify", "--inspect", str(flawed(tmp_path)), "-o", str(tmp_path / "out")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "phone.csv: phyphox export: 1 head line, 1,900 samples at 1 ms." in said
    assert "Number Name Unit Least Largest Mean Missing Clipped" in said
    assert "2 Acceleration x m/s2 −1.5 1.5" in said
    assert "Times: column 1, nine steps in ten within 36 % of the usual one; samples are missing before 2 (" in said
    assert "; times that stand twice: 1 (0.1 s)." in said or "; times that stand twice: 1 (1" in said
    assert 'To be pasted into the scenario: record: columns: time_s: {column: "Time", unit: s}' in said
    assert said.count("# which signal is it?") == 2
    assert (tmp_path / "out" / "figure-inspected.png").read_bytes().startswith(b"\x89PNG")


def test_an_inspection_as_data_counts_every_flaw(tmp_path: Path, capsys) -> None:
    assert main(["identify", "--inspect", str(flawed(tmp_path)), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert read_record(data, InspectedData, "inspected").columns[0].title.name == "Time"
    time, x, z = data["columns"]
    assert (data["samples"], time["missing"], x["missing"], z["missing"]) == (1900, 0, 1, 0)
    assert x["clipped"] > 500
    assert z["clipped"] < 20
    assert (x["least"], x["largest"], x["title"]["unit"]) == (-1.5, 1.5, "m/s2")
    assert data["clock"]["column"] == 1
    assert data["clock"]["step_s"] == pytest.approx(1e-3, rel=0.02)
    assert [len(data["clock"][key]) for key in ("gaps", "repeated", "back")] == [2, 1, 0]


@pytest.mark.parametrize("name", ["Tektronix TDS", "Keysight InfiniiVision", "LabVIEW LVM", "HDF5", "TDMS", "UFF 58"])
def test_the_block_that_is_printed_reads_the_file(name: str, tmp_path: Path) -> None:
    layout = LAYOUTS[name]
    path = tmp_path / layout.file
    path.write_bytes(layout.data)
    block = yaml.safe_load("\n".join(record_lines(inspect(str(path)))))["record"]
    recording = read_recording(str(path), keys=LayoutBlock.model_validate(block))
    assert recording.samples == layouts.COUNT
    assert recording.start_s == pytest.approx(layout.start)
    (voltage, *_) = recording.channels
    np.testing.assert_allclose(voltage.values, layouts.VOLTAGE, rtol=1e-12)


def test_a_file_without_times_asks_for_them(tmp_path: Path, capsys) -> None:
    (tmp_path / "x.csv").write_text("U [V];a\n" + "".join(f"{k % 7};{k % 5}\n" for k in range(100)))
    assert main(["identify", "--inspect", str(tmp_path / "x.csv"), "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "No times: the file has neither one column of times with its unit, nor a rate." in said
    assert '    voltage_v: {column: "U", unit: V}\n' in said
    assert '    # ...: {column: "a"}  # which signal, in which unit?\n' in said
    assert "  # sampling_rate_hz: 1000.0  # or time_s above" in said


def test_a_scenario_says_how_a_text_is_marked(tmp_path: Path, capsys) -> None:
    (tmp_path / "x.txt").write_text("".join(f"{k % 3},{k % 7}\n" for k in range(100)))
    scenario = str(EXAMPLES / "measured.yaml")
    command = ["identify", "--inspect", str(tmp_path / "x.txt"), "--json"]
    assert main(command) == 2
    assert "can be read in two ways" in capsys.readouterr().err
    assert main([*command, scenario, "--set", 'record.decimal=","']) == 0
    assert json.loads(capsys.readouterr().out)["columns"][0]["largest"] == 2.6
    assert main([*command, "--set", 'record.decimal=","']) == 2
    assert main(["identify"]) == 2
    assert "Missing argument 'SCENARIO' (only --inspect needs none)" in capsys.readouterr().err


def test_the_least_and_the_largest_value_of_a_long_signal_are_drawn() -> None:
    values = np.zeros(100_000)
    values[[31_415, 92_653]], values[5] = (7.0, -8.0), np.nan
    finite = np.flatnonzero(np.isfinite(values))
    rows = drawn_rows(values, finite)
    assert len(rows) == 3000
    assert {31_415, 92_653} <= set(rows.tolist())
    assert 5 not in drawn_rows(values, finite[:100])
