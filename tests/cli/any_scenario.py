"""Scenarios of every kind of device with every block, and every command on them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from vireport import load
from vireport.base.encoding import json_answer, json_text
from vireport.base.errors import ScenarioError, VireportError
from vireport.bench.answers import margins_answer, plane_answer, study_answer
from vireport.bench.changes import changes
from vireport.bench.session import first, loaded_of, opened, refusal, start_data
from vireport.cli.app import main
from vireport.physics.device import Device
from vireport.scenario.loading import loads
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import Impact, check_model, check_start, follow_one
from vireport.simulation.kernel import FLIGHT, WALL
from vireport.study.plan import Task
from vireport.study.study import analyse

DRIVEN = "length_m", "amplitude_n", "frequency_hz", "inclination_deg"
INPUTS = (*DRIVEN, "restitution", "capsule_mass_kg")
PATHS = {
    "length_m": "device.length_m",
    "capsule_mass_kg": "device.capsule_mass_kg",
    "restitution": "device.restitution",
}
PATHS |= {"amplitude_n": "excitation.amplitude_n", "frequency_hz": "excitation.frequency_hz"}


def random_tree(rng: np.random.Generator) -> dict[str, Any]:
    """A valid scenario: one drawn at random without the keys that do not go together."""
    while True:
        tree = _drawn(rng)
        while "excitation" in tree:
            try:
                loads(json.dumps(tree))
                return tree
            except ScenarioError as error:
                taken = [_without(tree, mistake.path) for mistake in error.mistakes]
                if not any(taken):
                    break


def _without(tree: dict[str, Any], path: str) -> bool:
    """Whether a key could be taken out of a scenario."""
    *blocks, key = path.partition("[")[0].split(".")
    for block in blocks:
        tree = tree.get(block, {}) if isinstance(tree, dict) else {}
    return isinstance(tree, dict) and tree.pop(key, None) is not None


def _drawn(rng: np.random.Generator) -> dict[str, Any]:
    """A scenario as plain data: a device at which there is mostly something to find, and each block now and then."""

    def some(share: float) -> bool:
        return bool(rng.random() < share)

    def number(low: float, high: float) -> float:
        return float(np.round(rng.uniform(low, high), 6))

    mass, inclination, frequency = number(0.03, 0.6), 0.0 if some(0.25) else number(0.5, 90), number(0.6, 15)
    if some(0.05):
        inclination = 90.0
    slope = np.sin(np.radians(inclination or 40.0))
    force = float(np.round(mass * 9.8 * slope / 10 ** rng.uniform(-1.5, 0.15), 6))
    length = float(10 ** rng.uniform(-1, 0.5 if some(0.9) else 1.5) * force / (4 * mass * frequency**2))
    device: dict[str, Any] = {"capsule_mass_kg": mass, "length_m": length}
    if some(0.3):
        device |= {"restitution_bottom": number(0.1, 0.95), "restitution_top": number(0.1, 0.95)}
    else:
        device["restitution"] = number(0.1, 0.95) if some(0.85) else float(rng.choice([0.0, 1e-12, 0.999, 1.0]))
    if some(0.7):
        device["ball_mass_kg"] = mass * number(0.001, 0.2)
        if some(0.3):
            device["capsule"] = "free"
        if some(0.4):
            device["membrane"] = {"thickness_m": number(2e-4, 2e-3), "relative_permittivity": 4.7}
            device["membrane"]["breakdown_field_v_m"] = 1e8
    if some(0.25):
        device["friction"] = number(0.001, 0.15)
    elif some(0.2):
        device |= {"restitution_exponent": number(-0.3, -0.01), "restitution_speed_m_s": number(0.3, 6)}
    drive: dict[str, Any] = {"amplitude_n": force, "frequency_hz": frequency}
    if some(0.3):
        orders = rng.choice(np.arange(2, 6), int(rng.integers(1, 4)), replace=False).tolist()
        drive["harmonics"] = [
            {"order": int(order), "percent": number(0.1, 20), "phase_deg": number(-180, 180)} for order in orders
        ]
    tree: dict[str, Any] = {"schema_version": 1, "device": device, "excitation": drive, "inclination_deg": inclination}
    if some(0.1):
        tree["period_ratio"] = int(rng.integers(2, 4))
    if some(0.6):
        swept = str(rng.choice([*DRIVEN, "restitution"] if some(0.4) else DRIVEN))
        if swept == "inclination_deg":
            low, high = 0.0 if some(0.3) else number(0, 30), number(31, 90)
        elif swept == "restitution":
            low, high = number(0, 0.4), number(0.5, 0.99)
        else:
            value = {"length_m": length, "amplitude_n": force, "frequency_hz": frequency}[swept]
            low, high = value * number(0.4, 0.95), value * number(1.05, 2)
        tree["sweep"] = {"parameter": swept, "from": high if some(0.2) else low, "to": low if some(0.2) else high}
        if tree["sweep"]["from"] == tree["sweep"]["to"]:
            tree["sweep"] |= {"from": low, "to": high}
        if some(0.3):
            place = tree if swept == "inclination_deg" else device if swept in device else drive
            place.pop(swept, None)
    tree |= _blocks(tree, some, number, rng)
    return tree


def _blocks(
    tree: dict[str, Any], some: Callable[[float], bool], number: Callable[[float, float], float], rng: Any
) -> dict[str, Any]:
    blocks: dict[str, Any] = {}
    if some(0.25):
        blocks["motions"] = {"impacts": int(rng.integers(1, 4)), "periods": int(rng.integers(1, 3))}
    if some(0.35):
        wanted = {"ramp_periods": number(0, 20), "jitter_m_s": number(1e-4, 0.05)}
        wanted |= {"jitter_restitution": 0.02, "basin": some(0.2), "prove": some(0.15)}
        blocks["disturbances"] = {key: value for key, value in wanted.items() if some(0.5)}
    if some(0.25):
        off = {f"{name}_percent": number(0.01, 3) for name in (*INPUTS, "restitution_top") if some(0.3)}
        if off:
            blocks["tolerances"] = {**off, "samples": 64, "distribution": "normal" if some(0.3) else "uniform"}
    if some(0.2):
        blocks["simulation"] = {"samples": 3, "starts": 1, "impacts": 200, "diagram": some(0.2)}
        blocks["simulation"]["follow"] = "both" if some(0.2) else "none"
    if some(0.1):
        blocks["accuracy"] = {"repeats": 1, "ladder": [1, 100]}
    if some(0.6):
        wanted = {
            "margin_any_percent": number(0.1, 8),
            "margin_with_effects_percent": number(0.1, 3),
            "reached_from_rest": True,
            "recovers_within_periods": number(5, 60),
            "withstands_distortion_percent": 3,
            "survives_shock_m_s": 0.1,
            "phase_jitter_at_most_deg": 5,
            "u_ave_at_least_v": 1000,
            "deflection_at_most_percent": 200,
            "power_at_least_mw": 0.1,
            "yield_at_least_percent": 99,
            "acceleration_at_most_g": 3,
            "stroke_at_most_m": 0.4,
            "force_at_most_n": 5,
            "word": "BT",
        }
        blocks["requirements"] = {key: value for key, value in wanted.items() if some(0.3)}
    if some(0.1):
        effects = [{"effect": "second_harmonic", "percent": 2}, {"effect": "restitution_exponent", "exponent": -0.1}]
        blocks["effects"] = [effect for effect in effects if some(0.6)]
    if some(0.2):
        path, value = PATHS["length_m"], tree["device"].get("length_m", 0.5)
        blocks["design"] = {"maximise": str(rng.choice(["margin_percent", "u_ave_v"])), "cells": 200}
        blocks["design"]["vary"] = [{"path": path, "from": 0.7 * value, "to": 1.4 * value}]
    return {key: value for key, value in blocks.items() if value}


class Refused(Exception):
    """What a command says of a scenario that it cannot take: no fault."""


class Calls:
    """Every command on one scenario, by its name.

    Parameters
    ----------
    tree : dict
    folder : Path
        For its files.
    """

    def __init__(self, tree: dict[str, Any], folder: Path) -> None:
        self.tree, self.folder = tree, folder
        self.file = self._written("scenario.yaml", tree)

    def _written(self, name: str, tree: dict[str, Any]) -> str:
        path = self.folder / name
        path.write_text(yaml.safe_dump(tree, sort_keys=False))
        return str(path)

    def _length(self) -> float:
        return float(self.tree["device"].get("length_m", 0.5))

    def _impacts(self) -> str:
        """A record of the device's impacts, as simulated, with some noise."""
        device, rng = Device.of(load(self.file).scenario), np.random.default_rng(1)
        if None in (device.length_m, device.amplitude_n, device.frequency_hz, device.inclination_deg):
            raise Refused
        groups = device.groups(Parameter.LENGTH, device.length_m)
        start = check_start(Impact(1, 0.5, 0.3), float(groups.d))
        rows = follow_one(check_model(groups)[0], start, 120, compiled=False)[0][20:]
        times = np.cumsum(rows[:, FLIGHT]) / (2 * device.frequency_hz) + rng.normal(0, 1e-5, len(rows))
        walls = ["bottom" if wall > 0 else "top" for wall in rows[:, WALL]]
        path = self.folder / "impacts.csv"
        lines = "".join(f"{t},{w}\n" for t, w in zip(times.tolist(), walls, strict=True))
        path.write_text(f"time_s,membrane\n{lines}")
        return str(path)

    def _answers(self) -> Iterator[Any]:
        """What the page of explore is answered."""
        known = opened(self.file)
        yield start_data(known)
        yield first(known, {})
        loaded = loaded_of(known, {})
        yield margins_answer(loaded)
        length = self._length()
        try:
            yield plane_answer(loaded, ("inclination_deg", "length_m"), ((0.0, 90.0), (0.5 * length, 2 * length)))
        except VireportError as error:
            yield refusal(error)
        study = analyse(loaded, (Task.JSON,))
        yield study_answer(study)
        yield [changes(study)]

    def explore(self) -> tuple[int, str]:
        """The answers, of which each is JSON both ways."""
        try:
            for answer in self._answers():
                assert _strict(json_text(answer)) == _strict(json_answer(answer).decode())
        except VireportError as error:
            return error.exit_code, str(error)
        return 0, ""

    def arguments(self, command: str) -> list[str]:
        """The arguments of a command."""
        file, out, length = self.file, str(self.folder / command), self._length()
        if command in ("changes", "baseline"):
            earlier = self.folder / "results.json"
            if not earlier.exists():
                changed = self._written("earlier.yaml", self.tree | {"gravity_m_s2": 9.81})
                if main(["run", changed, "-o", str(self.folder), "--format", "json", "-q"]) > 1:
                    raise Refused
            if command == "changes":
                return ["compare", str(earlier), file, "--exit-code", "--json"]
            return ["run", file, "-o", out, "--format", "json,markdown", "--baseline", str(earlier)]
        if command == "identify":
            return ["identify", file, "--impacts", self._impacts(), "--json"]
        if command == "map":
            axes = [{"path": PATHS["length_m"], "from": 0.7 * length, "to": 1.4 * length, "count": 4}]
            axes += [{"path": "inclination_deg", "from": 5, "to": 60, "count": 3}]
            kept = {key: value for key, value in self.tree.items() if key not in ("sweep", "design", "accuracy")}
            path = self._written("map.yaml", kept | {"map": {"axes": axes}})
            return ["map", path, "-o", out, "--workers", "1", "--format", "html"]
        return {
            "check": ["check", file, "--json"],
            "checked": ["check", file],
            "run": ["run", file, "--json"],
            "report": ["run", file, "-o", out],
            "certify": ["run", file, "--json", "--certify"],
            "compare": ["compare", file, "--vary", f"gravity_m_s2=9.8,{9.0}", "--json", "--rank-by", "recovery"],
            "compared": ["compare", file, "--vary", "inclination_deg=0,30", "-o", out],
            "chart": [
                "chart",
                file,
                "--over",
                f"length_m={0.6 * length}..{1.8 * length},inclination_deg=0..60",
                "--json",
            ],
            "charted": ["map", file, "--over", "restitution,length_m", "-o", out, "--format", "html,json"],
            "optimise": ["optimise", file, "--json"],
            "verify": ["verify", file, "--json", "--set", "accuracy={repeats: 1, ladder: [1, 100]}"],
        }[command]

    def ended(self, command: str, capfd: Any) -> tuple[int, str]:
        """Run a command, and hold that it ends with an answer or a sentence; its exit code and what it says."""
        try:
            if command == "explore":
                return self.explore()
            arguments = self.arguments(command)
        except Refused:
            return 2, ""
        capfd.readouterr()
        code = main(arguments)
        out, err = capfd.readouterr()
        assert "Traceback" not in err, (arguments, err)
        assert "internal error" not in err, (arguments, err)
        assert code in (0, 1, 2, 3), (arguments, code)
        if code > 1:
            assert (out + err).strip(), (arguments, code)
        elif "--json" in arguments:
            _strict(out)
        for path in self.folder.rglob("*.json"):
            _strict(path.read_text())
        return code, err


COMMANDS = (
    *("run", "check", "checked", "report", "compare", "changes", "chart", "explore", "identify", "baseline", "map"),
    *("optimise", "certify", "charted", "verify", "compared"),
)


def _strict(text: str) -> Any:
    """Data of JSON without the numbers that it does not have."""

    def refuse(name: str) -> None:
        raise ValueError(f"{name} is no JSON")

    return json.loads(text, parse_constant=refuse)
