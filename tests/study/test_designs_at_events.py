"""Designs at the very values of events, as results.json prints them: ordinary inputs, of every kind of device."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from conftest import first

from vireport.cli.app import main
from vireport.scenario.parameters import DesignInput

TOUCHING = 48
"""A device at the very length at which its motion touches a membrane, with a capsule whose recoil does not move it."""


def device_tree(number: int) -> dict[str, Any]:
    """A scenario of a kind of device: of restitution, force, capsule and inclination, by its number."""
    rng = np.random.default_rng([20261128, number])
    inclination = 0.0 if number % 4 == 0 else float(rng.uniform(5, 80))
    force, mass = 3.0 * float(rng.uniform(0.8, 1.6)), 0.1245
    d = float(rng.uniform(0.2, 0.45)) if number % 4 == 0 else float(rng.uniform(0.3, 0.6))
    device: dict[str, Any] = {"capsule_mass_kg": mass, "ball_mass_kg": 0.0041, "length_m": d * force / (4 * mass * 4)}
    if number % 3 == 1:
        device |= {"restitution_bottom": float(rng.uniform(0.3, 0.7)), "restitution_top": float(rng.uniform(0.3, 0.7))}
    else:
        device["restitution"] = float(rng.uniform(0.3, 0.7))
    if number % 5 == 2:
        device["capsule"] = "free"
    if number % 7 == 3:
        device["friction"] = float(rng.uniform(0.01, 0.06))
    elif number % 6 == 5:
        device |= {"restitution_exponent": -0.1, "restitution_speed_m_s": 3.0}
    drive: dict[str, Any] = {"amplitude_n": force, "frequency_hz": 2.0}
    if number % 4 == 3 or number % 8 == 4:
        drive["harmonics"] = [{"order": 2 + number % 2, "percent": 5.0, "phase_deg": float(rng.uniform(0, 360))}]
    tree: dict[str, Any] = {"schema_version": 1, "device": device, "excitation": drive, "inclination_deg": inclination}
    tree["requirements"] = {"recovers_within_periods": 40, "acceleration_at_most_g": 30}
    if "restitution_exponent" not in device:
        length = device["length_m"]
        tree["sweep"] = {"parameter": "length_m", "from": 0.6 * length, "to": 1.5 * length}
    return tree


def events_of(results: dict[str, Any]) -> dict[tuple[str, str], float]:
    """For each kind of event and input a value at which it happens, as it is printed."""
    points = [(point["kind"], "length_m", point["sweep_value"]) for point in results["critical_points"]]
    margins = [(own["kind"], own["parameter"], own["sweep_value"]) for own in results["design_point"]["margins"]]
    kinds: dict[str, tuple[str, float]] = {}
    for kind, varied, value in [*points, *margins]:
        kinds.setdefault(kind, (varied, value))
    return {(kind, varied): value for kind, (varied, value) in kinds.items()}


def overrides(device: dict[str, Any], varied: str, value: float) -> list[str]:
    """What puts an input at a value; of two restitutions their mean is moved."""
    if not varied.startswith("restitution"):
        return [f"{DesignInput(varied).path}={value!r}"]
    bottom, top = (device.get(f"restitution_{end}", device.get("restitution")) for end in ("bottom", "top"))
    if varied == "restitution" and bottom == top:
        return [f"device.restitution={value!r}"]
    half = (bottom - top) / 2
    ends = {"restitution": (value + half, value - half), "restitution_bottom": (value, top)}
    bottom, top = ends.get(varied, (bottom, value))
    return ["device.restitution=", f"device.restitution_bottom={bottom!r}", f"device.restitution_top={top!r}"]


@pytest.mark.parametrize("number", first(1, [TOUCHING, *range(TOUCHING), *range(TOUCHING + 1, 60)]))
def test_a_design_at_an_event_has_results(number: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scenario.yaml"
    file.write_text(yaml.safe_dump(device_tree(number)))
    assert main(["run", str(file), "--json"]) in (0, 1)
    found = events_of(json.loads(capfd.readouterr().out))
    for (kind, varied), value in found.items():
        over = overrides(device_tree(number)["device"], varied, value)
        code = main(["run", str(file), "--json", *(f"--set={one}" for one in over)])
        out, err = capfd.readouterr()
        assert code in (0, 1), (number, kind, over, err)
        results = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
        told = results["disturbances"]
        assert (told["recovery_periods"] is None) is (told["recovery_reason"] is not None), (number, kind, over)
        assert (told["recovery_periods"] is None) is (told["recovery_error_bound_periods"] is None)


@pytest.mark.slow
def test_these_devices_have_events_of_every_kind(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    kinds: set[str] = set()
    for number in range(12):
        file = tmp_path / "scenario.yaml"
        file.write_text(yaml.safe_dump(device_tree(number)))
        main(["run", str(file), "--json"])
        kinds |= {kind for kind, _ in events_of(json.loads(capfd.readouterr().out))}
    assert kinds >= {"period_doubling", "fold", "pitchfork", "grazing", "node_focus"}
