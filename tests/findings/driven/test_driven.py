"""A recorded acceleration driven through a device: against the periodic motion, and against what is counted by hand."""

from __future__ import annotations

import json
from collections import Counter
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from branches import say_every_branch
from conftest import EXAMPLES, first, solved
from msgspec.structs import replace
from pages import Page
from scipy.io import savemat

from vireport import UsageError, analyse, load
from vireport.base.errors import VireportError
from vireport.base.reading import ReadingPlace
from vireport.base.records import plain
from vireport.cli.app import main
from vireport.design.solution import solution_of, stable_motion
from vireport.findings.driven.driven import Driven, driven_by
from vireport.findings.driven.finding import FINDING
from vireport.findings.driven.means import NoInterval, batched
from vireport.findings.driven.results import DrivenData, driven_data
from vireport.measurement.shaker import ShakerDoubt, ShakerFinding
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.scenario.loading import Loaded
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.verdict import Status, Weight, verdict_of
from vireport.study.reading import read_record
from vireport.text.templates import Words

RATE = 100.0
FILM = "device.membrane={thickness_m: 1e-3, relative_permittivity: 4.7, breakdown_field_v_m: 1e8}"


def naming(folder: Path, record: str, *over: str) -> Loaded:
    """The example with a record in a folder."""
    loaded = load(EXAMPLES / "driven.yaml", (FILM, f"excitation.record={record}", *over))
    return replace(loaded, place=ReadingPlace(str(folder)))


def recorded(folder: Path, seconds: float = 60.0, newton: float = 3.0, rate: float = RATE, **more: Any) -> Path:
    """A sine that is the scenario's force, with noise, harmonics or an offset."""
    t = np.arange(int(seconds * rate)) / rate
    x = 2 * np.pi * 2.0 * t + 0.4
    values = newton / 0.1245 * (np.cos(x) + more.get("second", 0.0) * np.cos(2 * x + 1.0))
    values += more.get("offset", 0.0) + more.get("noise", 0.0) * np.random.default_rng(3).standard_normal(len(t))
    savemat(folder / "shaker.mat", {"acceleration_m_s2": values, "sampling_rate_hz": rate})
    return folder


def drive(folder: Path, *over: str, record: str = "shaker.mat") -> Driven:
    loaded = naming(folder, record, *over)
    return driven_by(loaded, Device.of(loaded.scenario), Membrane.of(loaded.scenario))


@pytest.mark.parametrize("more", [{}, {"second": 0.03}, {"offset": 6.93}], ids=["sine", "harmonic", "offset"])
def test_a_periodic_record_gives_the_periodic_motion(tmp_path: Path, more: dict[str, float]) -> None:
    found = drive(recorded(tmp_path, 50.0, **more))
    predicted = found.predicted
    assert found.share_of_1_1 == 1.0
    assert found.rests == 0.0
    assert len(found.device.harmonics) == ("second" in more)
    for name in ("speed_bottom_m_s", "speed_top_m_s", "impacts_per_s", "voltage_per_s", "power_mw"):
        assert getattr(found, name).value == pytest.approx(getattr(predicted, name), rel=2e-5), name
    design, row = stable_motion(solution_of(found.device, None, None, True))
    bottom = found.phases[found.walls > 0][-8:]
    assert bottom == pytest.approx(float(design.motions.phi_bottom[row]) % (2 * np.pi), abs=1e-4)
    assert found.shaker.offset == pytest.approx(more.get("offset", 0.0), abs=1e-6)


@pytest.mark.parametrize(("newton", "doubted"), [(3.0, False), (3.0 / 9.81, True)])
def test_no_verdict_on_a_record_in_another_unit_is_good(tmp_path: Path, newton: float, doubted: bool, capsys) -> None:
    recorded(tmp_path, 30.0, newton, noise=0.01)
    path = tmp_path / "scenario.yaml"
    stiff = "membrane: {stiffness: 3.5e+7}, restitution: 0.5"
    text = (EXAMPLES / "driven.yaml").read_text().replace("records/shaker.wav", "shaker.mat")
    path.write_text(text.replace("restitution: 0.5", stiff.replace(", ", "\n  ")))
    study = analyse(load(path))
    assert study.verdict.status is Status.CAUTION
    assert ("VR018" in " ".join(study.opening.worded().text)) is doubted
    assert [alert.code for alert in study.alerts if alert.code == "VR018"] == ["VR018"] * doubted
    assert [own["kind"] for own in study.to_dict()["driven"]["findings"]] == ["factor"] * doubted
    assert main(["run", str(path), "--format", "csv", "-o", str(tmp_path / "out")]) == 0
    assert ("multiplied by 9.81 it fits, as an acceleration in g would." in capsys.readouterr().out) is doubted


def test_counts_and_rates_are_those_of_the_impacts(tmp_path: Path) -> None:
    """A force under which the motion is no periodic one, counted once more from the impacts alone."""
    found = drive(recorded(tmp_path, 125.0, noise=0.5), "device.length_m=0.4")
    assert 0 < found.share_of_1_1 < 1
    frequency = found.device.frequency_hz
    end = found.settled_s + found.periods / frequency
    assert end <= found.recording.end_s < end + 1 / frequency
    assert found.settled_s == pytest.approx(20.0, abs=1 / frequency)
    edges = found.settled_s + np.arange(found.periods + 1) / frequency
    seen: Counter[str] = Counter()
    for low, high in pairwise(edges):
        mine = (found.times_s >= low) & (found.times_s < high)
        letters = "".join("B" if wall > 0 else "T" for wall in found.walls[mine])
        seen[min([letters[k:] + letters[:k] for k in range(len(letters))] or [""])] += 1
    shares = {own.letters: round(own.share * found.periods) for own in found.words}
    assert sum(shares.values()) + round(found.rests * found.periods) == found.periods
    assert all(count <= seen[letters] for letters, count in shares.items())
    assert found.impacts_per_s.value == pytest.approx(len(found.times_s) * frequency / found.periods, rel=0.1)
    assert found.impacts_per_s.low < found.impacts_per_s.value < found.impacts_per_s.high
    low, high = found.speed_top_m_s.low, found.speed_top_m_s.high
    assert low < found.speeds_m_s[found.walls < 0].mean() < high
    assert driven_data(found).deepest_m == found.deepest_m > 0


def test_a_heavy_ball_never_leaves_the_bottom(tmp_path: Path) -> None:
    found = drive(recorded(tmp_path, newton=0.5), "excitation.amplitude_n=0.5")
    assert len(found.times_s) == 0
    assert [own.letters for own in found.words] == [""]
    assert found.speed_bottom_m_s is None
    assert found.impacts_per_s.value == 0.0
    assert found.predicted is None


def test_intervals_cover_the_mean() -> None:
    """Sums over parts of a sequence with a memory of a few steps, whose mean is 1 to each unit of size."""
    covered, rng = 0, np.random.default_rng(5)
    for _ in range(400):
        kicks = rng.standard_normal(30 * 20 + 50)
        memory = np.convolve(kicks, 0.6 ** np.arange(20))[50 : 50 + 30 * 20]
        own = batched((1 + memory).reshape(30, 20).sum(axis=1), np.full(30, 20.0))
        covered += own.low is None or own.low < 1 < own.high
    assert 0.92 < covered / 400 < 0.985


def test_no_interval_is_given_where_it_would_say_too_little() -> None:
    assert batched(np.arange(5.0), np.ones(5)).why is NoInterval.SHORT
    assert batched(np.arange(20.0), np.ones(20)).why is NoInterval.DRIFTS
    still = batched(np.full(20, 3.0), np.ones(20))
    assert (still.value, still.low, still.high) == (3.0, 3.0, 3.0)


@pytest.fixture(scope="module")
def ran(tmp_path_factory) -> Path:
    """A run of the example."""
    folder = tmp_path_factory.mktemp("driven")
    assert main(["run", str(EXAMPLES / "driven.yaml"), "--format", "html,json", "-o", str(folder)]) == 0
    return folder


@pytest.mark.slow
def test_results_have_the_record_beside_the_prediction(ran: Path) -> None:
    data = json.loads((ran / "results.json").read_text())["driven"]
    assert plain(read_record(data, DrivenData, "results", "driven")) == data
    with pytest.raises(
        UsageError, match=r"^results: driven\.speed_top_m_s\.reason: expected one of short, drifts, got"
    ):
        read_record(data | {"speed_top_m_s": {**data["speed_top_m_s"], "reason": "x"}}, DrivenData, "results", "driven")
    assert data["record"] == "records/shaker.wav"
    assert data["words"] == [{"word": "BT", "share": 1.0}]
    assert data["excitation"]["frequency_hz"] == pytest.approx(2.001, abs=1e-5)
    assert data["excitation"]["amplitude_n"] == pytest.approx(24.1 * 0.1245, rel=0.02)
    assert [own["order"] for own in data["excitation"]["harmonics"]] == [2]
    speed = data["speed_top_m_s"]
    assert speed["from"] < data["predicted"]["speed_top_m_s"] < speed["to"]


@pytest.mark.slow
def test_a_doubt_about_a_record_has_the_numbers_of_its_kind(study_of) -> None:
    doubts = (
        ShakerFinding(ShakerDoubt.LONE, "a", 30.0, 1.5, 40.0, 2.0),
        ShakerFinding(ShakerDoubt.CLIPPED, "a", 0.1),
        ShakerFinding(ShakerDoubt.REVERSED, "a", 1.02, recorded=24.0, stated=23.5),
    )
    data = plain(driven_data(replace(study_of("driven").driven, doubts=doubts)))["findings"]
    numbers = {"at_s": 1.5, "recorded_m_s2": 40.0, "others_within_m_s2": 2.0}
    assert data == [
        {"kind": "lone_sample", "channel": "a", "value": 30.0, **numbers},
        {"kind": "clipped", "channel": "a", "value": 0.1},
        {"kind": "reversed", "channel": "a", "value": 1.02, "recorded_m_s2": 24.0, "scenario_m_s2": 23.5},
    ]


@pytest.mark.parametrize(
    ("over", "message"),
    [
        (["device.friction=0.1"], "a record is not driven through a device with friction"),
        (["device.capsule=free"], "the acceleration of a free capsule is not that of its force"),
        (["excitation.record=nowhere.wav"], "cannot be read: No such file"),
        (
            ["excitation.record=driven.yaml"],
            "no column is named as a signal with its unit (allowed:",
        ),
        (["excitation.frequency_hz=3"], "its strongest line is at 2"),
        (
            ["design={maximise: u_ave_v, vary: [{path: device.length_m, from: 0.6, to: 0.8}]}"],
            "excitation.record is of one device",
        ),
    ],
)
def test_what_cannot_be_driven_is_refused(capsys, over: list[str], message: str) -> None:
    arguments = [part for own in over for part in ("--set", own)]
    assert main(["run", str(EXAMPLES / "driven.yaml"), "--json", *arguments]) == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_records_that_are_not_whole_are_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "x.mat", {"voltage_v": np.random.default_rng(0).standard_normal(500), "sampling_rate_hz": RATE})
    with pytest.raises(UsageError, match="has no acceleration"):
        drive(tmp_path, record="x.mat")
    t = np.arange(2000) / RATE
    gap = t + np.where(t > 10, 0.5, 0.0)
    savemat(tmp_path / "y.mat", {"acceleration_m_s2": 24 * np.cos(4 * np.pi * gap), "time_s": gap})
    with pytest.raises(UsageError, match=r"lacks samples before 10\.51 s"):
        drive(tmp_path, record="y.mat")


@pytest.mark.parametrize("jitter", first(1, [0.003, 0.02]))
def test_an_uneven_clock_is_made_even_with_its_error_stated(tmp_path: Path, jitter: float) -> None:
    """Within half a step it would be taken for rounding, with an acceleration that is wrong by 4 %."""
    rng = np.random.default_rng(2)
    t = np.sort(np.arange(4000) / RATE + jitter * rng.uniform(-1, 1, 4000))
    t = np.delete(t, [1000, 3000])
    values = 3.0 / 0.1245 * np.cos(4 * np.pi * t)
    lines = (f"{time:.6f},{value:.6f}\n" for time, value in zip(t, values, strict=True))
    (tmp_path / "x.csv").write_text("time_s,acceleration_m_s2\n" + "".join(lines))
    found = drive(tmp_path, record="x.csv")
    assert 0 < found.resampled < 0.05
    even = found.recording
    exact = 3.0 / 0.1245 * np.cos(4 * np.pi * even.times)
    assert (
        float(np.sqrt(np.mean((found.shaker.channel.values - exact) ** 2))) < found.resampled * found.shaker.amplitude
    )
    assert (even.even, len(even.stretches)) == (True, 1)
    assert found.share_of_1_1 == 1.0
    assert found.speed_bottom_m_s.value == pytest.approx(found.predicted.speed_bottom_m_s, rel=2e-3)


def test_too_few_samples_at_uneven_times_are_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    t = np.sort(rng.uniform(0, 400, 14000))
    lines = (f"{time:.6f},{24 * np.cos(4 * np.pi * time):.6f}\n" for time in t)
    (tmp_path / "x.csv").write_text("time_s,acceleration_m_s2\n" + "".join(lines))
    with pytest.raises(VireportError, match=r"lacks samples before|put on an even clock it would be wrong by up to"):
        drive(tmp_path, record="x.csv")


def test_times_that_were_rounded_are_driven(tmp_path: Path) -> None:
    lines = "".join(f"{k / 96:.4f},{24 * np.cos(4 * np.pi * k / 96):.5f}\n" for k in range(4000))
    (tmp_path / "x.csv").write_text(f"time_s,acceleration_m_s2\n{lines}")
    found = drive(tmp_path, record="x.csv")
    assert 0 < found.recording.uneven_s < 1e-4
    assert found.share_of_1_1 == 1.0


def test_the_report_shows_the_numbers_of_the_results(ran: Path) -> None:
    page = Page((ran / "report.html").read_bytes())
    found = json.loads((ran / "results.json").read_text())["driven"]
    rows = {row[0]: row[1:] for row in page.tables["Driven by the record, and predicted"].rows}
    speed, predicted = found["speed_top_m_s"], found["predicted"]["speed_top_m_s"]
    interval = f"{speed['value']:.3g} ({speed['from']:.3g} to {speed['to']:.3g})"
    assert rows["Mean speed at the top [m/s]"] == [interval, f"{predicted:.3g}"]
    assert rows["Periods with one impact on each membrane"] == ["100 %", "100 %"]
    assert '#"' not in page.text


FIGURES = [
    ("figure_driven_caption", {"impacts": 1080, "every": 1, "share": 0.9875, "predicted": True}),
    ("figure_driven_caption", {"impacts": 20001, "every": 3, "share": 0.5, "predicted": False}),
    ("figure_driven_alt", {"impacts": 1080}),
]


def test_every_branch_of_the_figure_is_said() -> None:
    say_every_branch(*(("figures/driven", macro, (x,)) for macro, x in FIGURES))


SAID = {
    "record_doubtful": (("It runs",), "It runs; the record of the shaker is doubtful."),
    "lacks_record_doubtful": ((), "doubtful record of the shaker"),
}


@pytest.mark.parametrize("macro", SAID)
def test_a_doubtful_record_is_worded(macro: str) -> None:
    given, text = SAID[macro]
    assert Words("driven")(macro, *given) == text


@pytest.mark.parametrize("doubts", [(), ("reversed",)])
def test_a_doubtful_record_is_the_last_of_what_is_held_against_a_device(doubts: tuple[str, ...]) -> None:
    found = SimpleNamespace(doubts=doubts)
    evidence = Evidence(solved("inclined"), findings={"driven": found})
    answers, said = list(FINDING.answers(found, evidence)), verdict_of(evidence).conclusions
    assert bool(answers) is bool(doubts)
    assert ("Stable, but the record of the shaker is doubtful" in [own.word for own in said]) is bool(doubts)
    assert max(own.weight for own in said) <= Weight.DIGITS or not doubts
