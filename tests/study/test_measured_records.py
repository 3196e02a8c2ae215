"""Records of a scenario beside what is computed: read with every mistake in them, and told in results.json."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import EXAMPLES

from vireport import analyse, load
from vireport.base.encoding import json_text
from vireport.base.errors import ScenarioError
from vireport.cli.app import main
from vireport.design.point import motions_at
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter
from vireport.study.measured import MeasuredAt, measured_data, measured_loops, measured_of

IDENTIFIED = {"device.restitution": None, "device.restitution_bottom": 0.52, "device.restitution_top": 0.47}
SWEEP = {"parameter": "length_m", "from": 0.6, "to": 0.75}


@cache
def swept() -> tuple[MeasuredAt, ...]:
    return measured_of(load(EXAMPLES / "measured-sweep.yaml"))


@cache
def example(**over: object) -> tuple[Device, MeasuredAt]:
    """The example whose record is of known restitutions, with other values over it: its device, and what is shown."""
    record = [{"impacts": "measured-impacts.csv", "force_maximum_s": 0.0}]
    given = {path.replace("__", "."): value for path, value in over.items()}
    loaded = load(EXAMPLES / "measured.yaml", IDENTIFIED | {"sweep": SWEEP, "measured": record} | given)
    (at,) = measured_of(loaded)
    return Device.of(loaded.scenario), at


def data_of(*known: MeasuredAt) -> dict:
    records = {"measured": measured_data(known), "measured_hysteresis": measured_loops(known)}
    return json.loads(json_text(records))


def test_a_slow_sweep_shows_its_hysteresis():
    directions = [(at.value, at.direction, at.motion.word.ratio) for at in swept() if at.value in (0.223, 0.226)]
    assert directions == [(0.223, "up", "3:1"), (0.226, "up", "3:1"), (0.226, "down", "2:1"), (0.223, "down", "2:1")]
    data = data_of(*swept())
    loops = [(at["sweep_value"], at["up"][:4], at["down"][:4]) for at in data["measured_hysteresis"]]
    assert loops == [(0.223, "BBBT", "BBT "), (0.226, "BBBT", "BBT ")]
    assert [at["direction"] for at in data["measured"]] == ["up"] * 6 + ["down"] * 5


def test_every_motion_of_the_sweep_is_the_computed_one_within_its_errors():
    off = np.concatenate([at.computed.differences[:4].ravel() for at in swept()])
    assert [at.computed.name for at in swept()] == [at.name for at in swept()]
    assert np.abs(off).max() < 4.5
    assert np.mean(np.abs(off) < 1.96) > 0.9


def test_results_have_the_record_with_both_units_and_the_differences():
    device, shown = example()
    (at,) = data_of(shown)["measured"]
    assert (at["word"], at["periods"], at["missed"], at["false"], at["reason"]) == ("BT", 1, 7, 1, None)
    unit = float(device.velocity_unit(Parameter.LENGTH, 0.72))
    for impact in at["impacts"]:
        assert impact["velocity_m_s"] == pytest.approx(unit * impact["velocity"], rel=1e-12)
        assert impact["velocity_m_s_computed"] == pytest.approx(unit * impact["velocity_computed"], rel=1e-12)
        for name in ("velocity", "velocity_after", "phase_rad", "flight_t_c"):
            off = impact[name] - impact[f"{name}_computed"]
            assert impact[f"{name}_difference"] == pytest.approx(off / impact[f"{name}_standard_error"], rel=1e-6)
            assert abs(impact[f"{name}_difference"]) < 4
    motions, *_ = motions_at(device, Parameter.LENGTH)
    assert abs(motions.trace[motions.stable_mask] - at["trace"]) < 4 * at["trace_standard_error"]
    assert abs(motions.discriminant[motions.stable_mask] - shown.multipliers.discriminant) < (
        4 * shown.multipliers.discriminant_error
    )


def test_a_computed_device_with_other_restitutions_is_many_standard_errors_off():
    (_, own), (_, other) = example(), example(device__restitution_bottom=0.5, device__restitution_top=0.5)
    assert other.motion.values[:4] == pytest.approx(own.motion.values[:4], abs=1e-7)
    assert other.largest_difference > 100


@pytest.mark.slow
def test_nothing_measured_is_in_no_results_and_imports_nothing():
    code = "import sys; from vireport.study.study import analyse; d = analyse(sys.argv[1], ('json',)).to_dict(); "
    code += "print('measured' in d, *(m for m in sys.modules if m.startswith('vireport') and 'measure' in m))"
    path = str(EXAMPLES / "design-point.yaml")
    done = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False"]


def record(folder: Path, name: str, text: str) -> None:
    (folder / name).write_text(text)


def written(folder: Path, rows: str) -> Path:
    scenario = (EXAMPLES / "measured.yaml").read_text() + f"sweep: {json.dumps(SWEEP)}\nmeasured:\n{rows}"
    (folder / "scenario.yaml").write_text(scenario)
    return folder / "scenario.yaml"


def test_all_mistakes_in_all_records_are_told_at_once(tmp_path: Path, capsys):
    impacts = "0.1,bottom\n0.4,top\n0.6,bottom\n"
    record(tmp_path, "late.csv", "time_s,membrane\n0.4,bottom\n0.1,top\n0.2,top\n")
    record(tmp_path, "long.csv", "time_s,membrane,length_m\n0.1,bottom,0.7\n0.4,top,0.9\n0.6,bottom,0.7\n")
    record(tmp_path, "valued.csv", "time_s,membrane,length_m\n0.1,bottom,0.7\n0.4,top,0.7\n0.6,bottom,0.7\n")
    record(tmp_path, "milli.csv", "time_s,membrane\n100,bottom\n400,top\n600,bottom\n")
    record(tmp_path, "other.csv", f"time_s,membrane,amplitude_n\n{impacts}")
    names = "nowhere", "late", "long", "milli", "other"
    rows = [*(f"- {{impacts: {name}.csv}}\n" for name in names), "- {impacts: valued.csv, value: 0.7}\n"]
    path = written(tmp_path, "".join(rows))
    with pytest.raises(ScenarioError) as refused:
        analyse(path, ("json",))
    told = {mistake.path: mistake for mistake in refused.value.mistakes}
    messages = {
        0: "nowhere.csv cannot be read: No such file",
        1: "late.csv:3: time_s: 0.1 s is before that of line 2",
        2: "long.csv:3: length_m: got 0.9, outside the sweep (allowed: 0.6 to 0.75 m)",
        3: "The times look like milliseconds",
        4: "other.csv:1: amplitude_n: unknown column",
        5: "valued.csv has a column length_m",
    }
    for k, message in messages.items():
        mistake = told[f"measured.{k}.impacts"]
        assert message in mistake.message
        assert "allowed" in mistake.message or "leave them out" in mistake.message or k == 0
        assert path.read_text().splitlines()[mistake.line - 1] == rows[k].rstrip()
    assert main(["check", str(path)]) == 2
    assert "nowhere.csv" in capsys.readouterr().err


def test_a_record_without_a_value_is_of_the_design_point_which_must_be_known(tmp_path: Path):
    record(tmp_path, "a.csv", "time_s,membrane\n0.1,bottom\n0.4,top\n0.6,bottom\n")
    path = written(tmp_path, "- {impacts: a.csv}\n")
    (at,) = measured_of(load(path))
    assert (at.value, at.left_open.impacts) == (0.72, 11)
    with pytest.raises(ScenarioError, match="its value is not known"):
        measured_of(load(path, {"device.length_m": None}))
    with pytest.raises(ScenarioError, match=r"the design point 0\.8 is outside the sweep"):
        measured_of(load(path, {"device.length_m": 0.8}))


def test_the_phase_is_not_that_of_one_time_where_the_frequency_is_swept(tmp_path: Path):
    record(tmp_path, "a.csv", "time_s,membrane,frequency_hz\n0.1,bottom,2\n0.4,top,2\n0.6,bottom,2.1\n")
    path = written(tmp_path, "- {impacts: a.csv, force_maximum_s: 0}\n")
    swept = {"parameter": "frequency_hz", "from": 1.9, "to": 2.2}
    with pytest.raises(ScenarioError, match="where the frequency changes"):
        measured_of(load(path, {"sweep": swept}))


def test_impacts_of_another_device_are_refused_with_a_reason(tmp_path: Path):
    impacts = (EXAMPLES / "measured-impacts.csv").read_text()
    swapped = impacts.replace("top", "x").replace("bottom", "top").replace("x", "bottom")
    record(tmp_path, "swapped.csv", swapped)
    (at,) = measured_of(load(written(tmp_path, "- {impacts: swapped.csv, force_maximum_s: 0}\n")))
    assert at.motion is None
    assert at.unfit is not None
    (told,) = data_of(at)["measured"]
    assert "do not follow this device" in told["reason"]
    assert told["impacts"] == []


@pytest.fixture
def outside(tmp_path: Path, monkeypatch) -> Path:
    """A scenario whose record is in the folder above it, and a file that is none of ours beside that."""
    (tmp_path / "own").mkdir()
    record = (EXAMPLES / "measured-impacts.csv").read_bytes()
    (tmp_path / "impacts.csv").write_bytes(record)
    (tmp_path / "secret").write_text("db.example.org\n")
    text = (EXAMPLES / "measured.yaml").read_text()
    assert "measured:" not in text
    (tmp_path / "own/x.yaml").write_text(f"{text}\nmeasured: [{{impacts: ../impacts.csv}}]\n")
    monkeypatch.chdir(tmp_path / "own")
    return tmp_path / "own/x.yaml"


@pytest.mark.slow
def test_a_record_outside_of_the_folder_is_read_where_that_is_allowed(outside: Path, capsys) -> None:
    assert main(["check", "x.yaml"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert re.match(r"x\.yaml:\d+: measured\.0\.impacts: \.\./impacts\.csv: leads out of the folder", lines[0])
    assert main(["check", "x.yaml", "--allow-outside"]) == 0
    assert measured_of(load(outside, allow_outside=True))[0].impacts > 100
    with pytest.raises(ScenarioError, match="leads out of the folder"):
        measured_of(load(outside))


@pytest.mark.parametrize("name", ["secret", "../secret", "/etc/passwd", "/etc/hostname"])
def test_of_a_file_that_is_no_record_nothing_is_shown(outside: Path, capsys, name: str) -> None:
    (outside.parent / "secret").write_text("root:x:0:0\ndb.example.org\n")
    text = outside.read_text().replace("../impacts.csv", name)
    outside.write_text(text)
    for option in ([], ["--allow-outside"]):
        assert main(["check", "x.yaml", *option]) == 2
        said = capsys.readouterr().err
        assert len(said.splitlines()) == 1
        assert not any(word in said for word in ("root", "example", Path("/etc/hostname").read_text().strip()))


def test_mistakes_of_a_thousand_rows_are_counted(outside: Path, capsys) -> None:
    (outside.parent / "bad.csv").write_text("time_s,membrane\n" + "0.1,up\n" * 5000)
    outside.write_text(outside.read_text().replace("../impacts.csv", "bad.csv"))
    assert main(["check", "x.yaml", "--json"]) == 2
    told = json.loads(capsys.readouterr().out)
    assert (len(told["mistakes"]), told["more"]) == (20, 4980)
    assert main(["check", "x.yaml"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 21
    assert "bad.csv:21: membrane: 'up' is no membrane" in lines[19]
    assert lines[20] == "x.yaml: and 4980 more (mend these first)"
