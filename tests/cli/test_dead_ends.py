"""What the command line says where nothing works: what to do, and what was probably meant."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest
from conftest import first

from vireport import load
from vireport.cli.app import main
from vireport.optimise.problem import problem_of

MAP = str(Path(__file__).parents[2] / "examples" / "maps" / "map.yaml")
INCLINED = str(Path(__file__).parents[2] / "examples" / "inclined.yaml")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["check", INCLINED, "--set", "restitution=0.5"], "did you mean 'device.restitution'?"),
        (["check", INCLINED, "--set", "device.restitution=60"], "if it is 60 %, write 0.60"),
        (["maps", "x.yaml"], "did you mean 'map'?"),
        (["explain", "nothing"], "period doubling"),
        (["explain", "VR10"], "did you mean 'VR010'?"),
        (["explain", "pitch-fork"], "did you mean 'pitchfork'?"),
        ([INCLINED, "run"], f"the command comes first: vireport run {INCLINED}"),
        ([INCLINED, "plan", "--json"], f"the command comes first: vireport plan {INCLINED} --json"),
        (["run", INCLINED, "--set", "device.length_m", "0.7"], "with '=': --set device.length_m=0.7"),
        (["run", INCLINED, "spare"], "what has spaces needs quotes"),
        (["map", INCLINED, "--over", "length,restitution"], "unknown input 'length'; did you mean 'length_m'?"),
        (["map", INCLINED, "--over", "angle,restitution"], "did you mean 'inclination_deg'?"),
        (["map", INCLINED], "has no map block"),
        (["map", MAP, "--json"], "(--over draws curves): leave out --json"),
        (
            ["map", INCLINED, "--over", "length_m,restitution", "--no-figures"],
            "computes no cells: leave out --no-figures",
        ),
        (["compare", INCLINED, "--vary", "inclination_deg=1,2", "--exit-code"], "leave out --vary"),
        (["compare", INCLINED, "--vary", "inclination_deg=1,2", "--markdown"], "leave out --markdown"),
        (["compare", INCLINED, "--exit-code"], "--exit-code takes two files, got 1"),
        (["verify"], "Missing argument 'SCENARIO'"),
        (["verify", "--extremes", "-o", "x"], "--extremes prints the cases: leave out --output"),
        (["init", "x.yaml", "--schema"], "leave out x.yaml"),
    ],
)
def test_what_was_probably_meant_is_suggested(arguments: list[str], said: str, capsys) -> None:
    assert main(arguments) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", [["my file.yaml"], ["run", "my file.yaml", "--json"], ["compare", INCLINED, "my file.yaml"]]
)
def test_a_name_with_spaces_is_quoted(words: list[str], tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my file.yaml").write_text("")
    assert main(" ".join(words).split(" ")) == 2
    quoted = shlex.join(["vireport", *words])
    assert capsys.readouterr().err.startswith(f"vireport: error: a name with spaces needs quotes: {quoted}\n")


def test_what_was_swapped_is_said(tmp_path: Path, capsys) -> None:
    results = str(tmp_path / "results.json")
    assert main(["run", INCLINED, "-o", str(tmp_path), "--format", "json", "-q"]) == 0
    assert main(["compare", INCLINED, results, "--exit-code"]) == 2
    assert f"were they swapped? (vireport compare {results} {INCLINED} --exit-code)" in capsys.readouterr().err


def test_a_search_without_its_block_is_shown_one_that_will_do(tmp_path: Path, capsys) -> None:
    assert main(["optimise", INCLINED]) == 2
    said, *block = capsys.readouterr().err.splitlines()
    assert "has no design block" in said
    (tmp_path / "x.yaml").write_text("\n".join([Path(INCLINED).read_text(), *block]))
    scenario = load(tmp_path / "x.yaml").scenario
    (varied,) = scenario.design.vary
    assert varied.from_ < scenario.device.length_m < varied.to
    problem_of(load(tmp_path / "x.yaml"))


def test_a_term_is_explained(capsys) -> None:
    assert main(["explain", "period doubling"]) == 0
    assert "goes through -1" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("length", "outcome", "word", "periods", "block"),
    first(
        1,
        [
            (0.6, "other_motion", "BTBT", 2, "motions"),
            (0.35, "other_motion", "BBTBBTBBTBBTBT", 6, "simulation"),
            (0.1, "rest_cycle", "B~T", 1, "simulation"),
            (0.45, "chaotic", "", 0, "simulation"),
        ],
        unpacked=True,
    ),
)
def test_without_stable_motion_the_ball_is_simulated_from_rest(
    length: float, outcome: str, word: str, periods: int, block: str, capsys
) -> None:
    assert main(["run", INCLINED, "--json", "--set", f"device.length_m={length}"]) == 0
    results = json.loads(capsys.readouterr().out)
    found = results["disturbances"]["from_rest"]
    assert (found["outcome"], found["word"] or "", found["periods"] or 0) == (outcome, word, periods)
    (alert,) = [alert for alert in results["alerts"] if alert["code"] == "VR003"]
    assert (word or "chaotic") in alert["cause"]
    assert f"A block '{block}:' shows it." in alert["cause"]


@pytest.mark.slow
def test_without_stable_motion_in_a_sweep_the_ball_is_simulated_from_rest_at_some_of_its_values(
    tmp_path: Path, capsys
) -> None:
    """A length that is swept, and none given: what each value comes to is what a device of that length comes to."""
    unstable = ["--set", "sweep.from=0.25", "--set", "sweep.to=0.4", "--set", "excitation.amplitude_n=5"]
    swept = ["run", INCLINED, *unstable, "--set", "device.length_m=", "--format", "json,markdown", "-o", str(tmp_path)]
    assert main(swept) == 0
    assert capsys.readouterr().out.startswith("It does not run: no 1:1 motion is stable.\n")
    summary = " ".join((tmp_path / "summary.md").read_text().replace("\\~", "~").split())
    results = json.loads((tmp_path / "results.json").read_text())
    parts = results["disturbances"]["from_rest"]["along_sweep"]
    assert [(part["from"], part["to"]) for part in parts] == [
        (pytest.approx(value),) * 2 for value in (0.25, 0.2875, 0.325, 0.3625, 0.4)
    ]
    assert [part["word"] for part in parts] == ["B~T", "BBBBT", "BBBT", None, "BBT"]
    for part in parts[::2]:
        assert main(["run", INCLINED, *unstable, "--json", "--set", f"device.length_m={part['from']}"]) == 0
        own = json.loads(capsys.readouterr().out)["disturbances"]["from_rest"]
        assert {key: own[key] for key in ("outcome", "word", "periods")} == {
            key: part[key] for key in ("outcome", "word", "periods")
        }
        outcome = f"{part['word']} every forcing period" if part["outcome"] == "other_motion" else ""
        assert f"s = {part['from']:.4g} m: {outcome or ('rest every' if part['word'] else 'chaotic')}" in summary
    assert "A block 'simulation:' or 'motions:' shows it." in summary
    for end in ("rest every forcing period (B~T)", "BBBBT every forcing period"):
        assert f"Switched on from rest, somewhere in the sweep the ball comes to {end}." in summary


def test_where_a_motion_is_stable_in_a_sweep_nothing_is_simulated_from_rest_without_a_design_point(capsys) -> None:
    assert main(["run", INCLINED, "--json", "--set", "device.length_m="]) == 0
    assert json.loads(capsys.readouterr().out)["disturbances"] is None


def test_a_ball_that_never_leaves_the_membrane_is_said_to_rest(capsys) -> None:
    """Gravity along the capsule exceeds the largest acceleration of the capsule."""
    over = ["--set", "excitation.amplitude_n=0.5", "--set", "sweep="]
    assert main(["run", INCLINED, "--json", *over]) == 0
    assert json.loads(capsys.readouterr().out)["disturbances"]["from_rest"]["outcome"] == "at_rest"


WRONG_UNITS = (
    "device.length_m=650",
    "device.ball_mass_kg=5.2",
    "excitation.frequency_hz=9.425",
    "inclination_deg=0.524",
)


@pytest.mark.parametrize("swept", [True, False], ids=["swept", "design point"])
def test_a_check_asks_of_values_in_another_unit_what_a_run_asks(swept, capsys) -> None:
    over = [word for setting in WRONG_UNITS for word in ("--set", setting)]
    over += ["--set", "sweep.from=600", "--set", "sweep.to=700"] if swept else ["--set", "sweep="]
    assert main(["run", INCLINED, "--json", *over]) == 0
    raised = [alert for alert in json.loads(capsys.readouterr().out)["alerts"] if alert["code"] == "VR015"]
    assert main(["check", INCLINED, "--json", *over]) == 0
    assert json.loads(capsys.readouterr().out)["alerts"] == raised
    assert main(["check", INCLINED, *over]) == 0
    valid, told, *steps = capsys.readouterr().out.splitlines()
    assert valid.endswith(": valid scenario")
    assert len(steps) > 10
    assert told == f"VR015: {raised[0]['cause']} {raised[0]['remedy']}"
    meant = ("which is 0.65 m?", "is it 5.2 g?", "which is 1.5 Hz?", "which is 30 degrees?")
    assert all(what in told for what in (*meant, *(["which is 0.6 m?", "which is 0.7 m?"] if swept else [])))


@pytest.mark.slow
def test_where_nothing_works_the_terminal_says_so_and_the_summary_what_to_do(tmp_path: Path, capsys) -> None:
    run = ["run", INCLINED, "--format", "json,markdown", "-o", str(tmp_path)]
    assert main([*run, "--set", "device.length_m=300"]) == 0
    sentence, numbers, fact, unit = capsys.readouterr().out.splitlines()
    assert sentence == "It does not run: no 1:1 motion is stable."
    assert "From rest: not 1:1" in numbers
    assert unit.startswith("VR015: device.length_m = 300: metres, or is it 300 mm")
    assert fact == "Move the length into a stable range."
    summary = " ".join((tmp_path / "summary.md").read_text().split())
    opening, _, alerts = summary.partition("## Alerts")
    assert "the ball comes to rest every 8 forcing periods" in opening
    assert "VR015: A value may be in another unit." in opening
    assert "Move the design point into a stable range" in alerts
    assert "300 mm, which is 0.3 m?" in alerts
    assert main([*run, "--set", "device.length_m=", "--set", "sweep.to=0.61"]) == 0
    assert "Stable length: none" in capsys.readouterr().out.splitlines()[1]
    assert "Widen the sweep" in (tmp_path / "summary.md").read_text()


@pytest.mark.slow
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_slow_sweep_of_a_ball_that_never_bounces(capsys) -> None:
    assert main(["run", INCLINED, "--json", "--set", "device.restitution=0", "--set", "simulation.follow=both"]) == 0
    assert json.loads(capsys.readouterr().out)["simulation"]["follow"] is not None


def test_a_value_in_another_unit_is_asked_about_on_the_terminal(tmp_path: Path, capsys) -> None:
    point = str(Path(INCLINED).with_name("design-point.yaml"))
    run = ["run", point, "--set", "device.length_m=300", "--format", "json"]
    assert main([*run, "-o", str(tmp_path / "out")]) == 0
    assert "VR015: device.length_m = 300: metres, or is it 300 mm" in capsys.readouterr().out
