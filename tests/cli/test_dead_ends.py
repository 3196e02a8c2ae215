"""What the command line says where nothing works: what to do, and what was probably meant."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from vireport.cli import main

INCLINED = str(Path(__file__).parents[2] / "examples" / "inclined.yaml")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["validate", INCLINED, "--set", "restitution=0.5"], "did you mean 'device.restitution'?"),
        (["validate", INCLINED, "--set", "device.restitution=60"], "if it is 60 %, write 0.60"),
        (["map", "x.yaml"], "did you mean 'sweep'?"),
        (["explain", "nothing"], "period doubling"),
    ],
)
def test_what_was_probably_meant_is_suggested(arguments: list[str], said: str, capsys) -> None:
    assert main(arguments) == 2
    assert said in capsys.readouterr().err


def test_a_term_is_explained(capsys) -> None:
    assert main(["explain", "period doubling"]) == 0
    assert "goes through -1" in capsys.readouterr().out


@pytest.mark.parametrize(("length", "word"), [(0.6, "BTBT"), (0.35, "BBTBBTBBTBBTBT")])
def test_without_stable_motion_the_ball_is_simulated_from_rest(length: float, word: str, capsys) -> None:
    assert main(["run", INCLINED, "--json", "--set", f"device.length_m={length}"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert results["disturbances"]["from_rest"] == {
        "outcome": "other_motion",
        "word": word,
        "periods": 2 if word == "BTBT" else 6,
    }
    (alert,) = [alert for alert in results["alerts"] if alert["code"] == "VR003"]
    assert word in alert["cause"]
    assert "'motions:'" in alert["cause"]


def test_a_length_in_millimetres_is_asked_about(capsys) -> None:
    assert main(["run", INCLINED, "--json", "--set", "device.length_m=300"]) == 0
    causes = [alert["cause"] for alert in json.loads(capsys.readouterr().out)["alerts"] if alert["code"] == "VR015"]
    assert "300 mm, which is 0.3 m?" in causes[0]


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_slow_sweep_of_a_ball_that_never_bounces(capsys) -> None:
    assert main(["run", INCLINED, "--json", "--set", "device.restitution=0", "--set", "simulation.follow=both"]) == 0
    assert json.loads(capsys.readouterr().out)["simulation"]["follow"] is not None
