"""From raw signals to a device: the whole command on a record of the simulation, against the truth behind it."""

from __future__ import annotations

import json
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES, first
from msgspec import convert
from msgspec.structs import replace
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat, wavfile
from sounds import RATE, clock, hum, ringing, signal
from synthetic import device_of, truth

from vireport import load
from vireport.cli.app import main
from vireport.design.devices import devices_off, stable_motions
from vireport.design.point import design_point
from vireport.identify.results import IdentifiedData
from vireport.measurement.records import read_record
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic, with_harmonic
from vireport.scenario.parameters import DesignInput

SCENARIO, IMPACTS = str(EXAMPLES / "measured.yaml"), str(EXAMPLES / "measured-impacts.csv")
TRUTH = {"restitution_bottom": 0.52, "restitution_top": 0.47}


@cache
def signals(harmonics: tuple[tuple[int, float, float], ...] = ()) -> dict[str, Any]:
    """Raw signals of the example's device: both membranes, hum, noise, and the acceleration."""
    rng = np.random.default_rng(1)
    device = device_of("measured").with_values({DesignInput(key): value for key, value in TRUTH.items()})
    device = replace(device, harmonics=tuple(Harmonic.of(*own) for own in harmonics))
    known = truth(device, 60)
    times = known.times + 3.2
    seconds = float(times[-1]) + 0.3
    sizes = rng.uniform(0.2, 1.0, len(times))
    channels = {}
    for name, wall in (("bottom_voltage_v", 1), ("top_voltage_v", -1)):
        values = signal(times, sizes * np.where(known.walls == wall, 1.0, 0.1), seconds)
        channels[name] = values + hum(values, 0.05) + 3e-3 * rng.standard_normal(len(values))
    x = 2 * np.pi * device.frequency_hz * (clock(values) - 3.2) + known.phase
    force = np.cos(x) + sum(percent / 100 * np.cos(k * x + np.radians(at)) for k, percent, at in harmonics)
    struck = signal(times, -60 * known.walls * sizes, seconds, lambda t: ringing(t, 700.0, 3e-3))
    noise = 0.3 * rng.standard_normal(len(values))
    channels["acceleration_m_s2"] = device.amplitude_n / device.capsule_mass_kg * force + struck + noise + 0.2
    return channels | {"sampling_rate_hz": RATE}


CR_ONLY = {
    "every row wrong": ("time_s,voltage_v", "{0:.3f},{0}x", 1),
    "no units": ("time,voltage", "{0:.3f},0.1", 2),
    "slow for signs": ("time_s,voltage_v", "{0:.3f},{1}", 1),
}


@pytest.mark.parametrize("name", CR_ONLY)
def test_filters_are_not_loaded_for_a_record_that_is_refused(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    head, row, mistakes = CR_ONLY[name]
    rows = [head, *(row.format(k / 1000, 0.6 * (k % 250 == 51) + 0.3 * (k % 250 == 52)) for k in range(12_000))]
    (tmp_path / "x.csv").write_bytes("\r".join(rows).encode())
    for module in ("scipy.signal", "scipy.ndimage"):
        monkeypatch.setitem(sys.modules, module, None)
    assert main(["identify", SCENARIO, "--record", str(tmp_path / "x.csv"), "-o", str(tmp_path / "out")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == mistakes


def recorded(folder: Path, harmonics: tuple[tuple[int, float, float], ...] = ()) -> str:
    savemat(folder / "record.mat", signals(harmonics))
    return str(folder / "record.mat")


@pytest.mark.slow
def test_raw_signals_are_identified_with_the_truth_behind_them(capsys, tmp_path: Path) -> None:
    record, folder = recorded(tmp_path), tmp_path / "out"
    assert main(["identify", SCENARIO, "--record", record, "-o", str(folder), "-v"]) == 0
    assert "60 impacts picked" in " ".join(capsys.readouterr().out.split())
    assert {path.name for path in folder.iterdir()} == {
        "identified.json",
        "identified.yaml",
        "impacts.csv",
        "figure-impacts.png",
        "figure-record.png",
        "report.html",
        "report.pdf",
    }
    results = json.loads((folder / "identified.json").read_text())
    assert results["misfit"]["accepted"]
    for row in results["identified"]:
        assert abs(row["value"] - TRUTH[row["name"]]) < 3.5 * row["standard_error"]
        assert row["standard_error"] < 2e-4
    assert convert(results, IdentifiedData).record.excitation.maximum_s > 0
    measured = results["record"]["excitation"]
    for key, value in (("amplitude_n", 3.0), ("frequency_hz", 2.0)):
        assert abs(measured[key]["value"] - value) < 4 * measured[key]["standard_error"]
    assert not any(own["significant"] for own in measured["harmonics"])
    assert results["devices"]["stable"] == results["devices"]["samples"]
    scenario = load(folder / "identified.yaml").scenario
    assert scenario.excitation.amplitude_n == measured["amplitude_n"]["value"]
    assert scenario.tolerances.amplitude_n == pytest.approx(1.96 * measured["amplitude_n"]["standard_error"])
    # What was picked is a record of impacts, which says the same on a clock without the force's phase.
    again = read_record(str(folder / "impacts.csv"), 2.0)
    assert len(again.times) == 60
    assert again.unused == ()
    assert (again.errors > 0).all()


@pytest.mark.slow
def test_what_was_picked_is_shown_where_nothing_can_be_identified(capsys, tmp_path: Path) -> None:
    """Noise with pulses at random: impacts of no device."""
    rng = np.random.default_rng(2)
    times = 0.2 + np.cumsum(rng.uniform(0.1, 0.4, 40))
    values = signal(times, rng.choice([-1.0, 1.0], 40), float(times[-1]) + 0.2)
    savemat(tmp_path / "record.mat", {"voltage_v": values + hum(values, 0.01), "sampling_rate_hz": RATE})
    record = str(tmp_path / "record.mat")
    code = main(["identify", SCENARIO, "--record", record, "-o", str(tmp_path / "out"), "-v"])
    assert code in (1, 3)
    assert {"impacts.csv", "figure-record.png"} <= {path.name for path in (tmp_path / "out").iterdir()}
    assert "40 impacts picked" in " ".join(capsys.readouterr().out.split())


@pytest.mark.slow
def test_a_distorted_shaker_is_in_the_identified_scenario(capsys, tmp_path: Path) -> None:
    record = recorded(tmp_path, ((2, 4.0, 60.0),))
    assert main(["identify", SCENARIO, "--record", record, "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    (tmp_path / "identified.yaml").write_text(results["scenario"])
    excitation = load(tmp_path / "identified.yaml").scenario.excitation
    assert [own.order for own in excitation.harmonics] == [2]
    assert excitation.harmonics[0].percent == pytest.approx(4.0, abs=0.02)
    assert excitation.harmonics[0].phase_deg == pytest.approx(60.0, abs=0.3)
    for row in results["identified"]:
        assert abs(row["value"] - TRUTH[row["name"]]) < 4 * row["standard_error"]
    assert results["devices"]["stable"] == results["devices"]["samples"]
    # How far the nearest end moves with one standard error more of the cosine, and of the sine.
    held = results["held_harmonics"]
    (own,) = [own for own in results["record"]["excitation"]["harmonics"] if own["significant"]]
    device = Device.of(load(tmp_path / "identified.yaml").scenario)
    size, end = own["percent_error"] / 100, held["nearest_end"]
    at = []
    for parts in ((0.0, 0.0), (size, 0.0), (0.0, size)):
        off = replace(device, harmonics=with_harmonic(device.harmonics, Harmonic(2, *parts)))
        ends = (x.sweep_value for x in design_point(off, None).limits() if x.parameter == end["parameter"])
        at.append(min(ends, key=lambda x: abs(x - end["value"])))
    assert at[0] == pytest.approx(end["value"], rel=1e-3)
    assert held["standard_error"] == pytest.approx(np.hypot(at[1] - at[0], at[2] - at[0]), rel=1e-2)


DISTORTED = [((2, 4.0, 60.0),), ((2, 2.0, 225.0), (3, 1.0, 40.0)), ((3, 5.0, 200.0),)]


@pytest.mark.slow
@pytest.mark.parametrize("harmonics", DISTORTED)
def test_the_yield_of_a_distorted_shaker_is_that_of_the_device_behind_the_record(
    capsys, tmp_path: Path, harmonics: tuple[tuple[int, float, float], ...]
) -> None:
    """From raw signals to the yield of such devices, of which the length may be off beyond the end of stable motion."""
    record, folder = recorded(tmp_path, harmonics), tmp_path / "out"
    assert main(["identify", SCENARIO, "--record", record, "-o", str(folder), "-v"]) == 0
    assert "The harmonics of the force are held at their values." in " ".join(capsys.readouterr().out.split())
    device = device_of("measured").with_values({DesignInput(key): value for key, value in TRUTH.items()})
    device = replace(device, harmonics=tuple(Harmonic.of(*own) for own in harmonics))
    limits = design_point(device, None).limits()
    off = 1.5 * min(abs(end.distance) for end in limits if end.parameter is DesignInput.LENGTH)
    given = ["run", str(folder / "identified.yaml"), "--json", "--set", f"tolerances.length_m={off}"]
    assert main(given) == 0
    found = json.loads(capsys.readouterr().out)["tolerances"]
    assert (found["answer"], found["proof"]) == ("refuted", None)
    widths = {DesignInput(row["parameter"]): (row["to"] - row["from"]) / 2 for row in found["inputs"]}
    assert widths.keys() > {DesignInput.AMPLITUDE, DesignInput.FREQUENCY, DesignInput.RESTITUTION_TOP}
    steps = np.random.default_rng(3).uniform(-1, 1, (len(widths), 4096))
    true = len(set(stable_motions(devices_off(device, widths, steps))[0])) / 4096
    assert 0.5 < true < 0.9
    assert found["yield"]["share"] == pytest.approx(true, abs=0.02)


@pytest.mark.parametrize(
    ("arguments", "message"),
    first(
        3,
        [
            ([], "either --impacts or --record is needed (allowed: one of them)"),
            (["--impacts", IMPACTS, "--record", IMPACTS], "either --impacts or --record is needed"),
            (["--record", "RECORD", "--clock", "force"], "--clock: the record's acceleration gives the phase"),
            (
                ["--record", "RECORD", "--free", "amplitude_n"],
                "--free: amplitude_n is measured by the record's acceleration",
            ),
            (["--record", "RECORD", "--set", "excitation.frequency_hz=3"], "its strongest line is at"),
            (["--record", "RECORD", "--set", "device.capsule=free"], "the motion of a free capsule"),
            (["--record", IMPACTS], "membrane: the name is no signal with a unit"),
        ],
        unpacked=True,
    ),
)
def test_questions_that_do_not_fit_a_record_are_refused(
    capsys, tmp_path: Path, arguments: list[str], message: str
) -> None:
    given = [recorded(tmp_path) if own == "RECORD" else own for own in arguments]
    assert main(["identify", SCENARIO, *given, "-o", str(tmp_path / "out")]) == 2
    assert message in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_record_is_identified_alike_from_four_formats(tmp_path: Path, capsys) -> None:
    rate, samples = wavfile.read(EXAMPLES / "records" / "prototype.wav")
    voltage, acceleration = (samples[:, k] / 32768 * full for k, full in enumerate((2.0, 50.0)))
    text = "".join(f"{u!r},{a!r}\n" for u, a in zip(voltage.tolist(), acceleration.tolist(), strict=True))
    (tmp_path / "rig.csv").write_text(f"Logger 7\nSampling rate,{rate},Hz\n\nU (V),a\n{text}")
    named = {"U": voltage, "a": acceleration, "sampling_rate_hz": float(rate)}
    savemat(tmp_path / "rig.mat", named)
    np.savez(tmp_path / "rig.npz", **named)
    with TdmsWriter(str(tmp_path / "rig.tdms")) as writer:
        base = {"wf_increment": 1 / rate, "wf_start_offset": 0.0}
        writer.write_segment([ChannelObject("rig", name, named[name], properties=base) for name in "Ua"])
    columns = ["voltage_v={column: U, unit: V}", "acceleration_m_s2={column: a, unit: m/s2}"]
    keys = [part for column in columns for part in ("--set", f"record.columns.{column}")]
    answers = []
    files = (
        EXAMPLES / "records" / "prototype.wav",
        *(tmp_path / f"rig.{end}" for end in ("csv", "mat", "npz", "tdms")),
    )
    for record in files:
        more = [] if record.suffix == ".wav" else keys
        assert main(["identify", SCENARIO, "--record", str(record), "--json", *more]) == 0
        answer = json.loads(capsys.readouterr().out)
        assert answer["record"]["reading"].endswith("44,000 samples at 250 us")
        answers.append([answer[key] for key in ("identified", "covariance", "timing_error_s", "missed", "misfit")])
    assert all(answer == answers[0] for answer in answers)
