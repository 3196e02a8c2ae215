"""Records whose truth is known: impacts as the simulation has them."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct

from vireport import load
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import Impact, check_model, check_start, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, VELOCITY, WALL

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


class Truth(Struct, frozen=True):
    """Impacts as they were, and the force's phase at time 0."""

    times: Any
    walls: Any
    phase: float


def device_of(name: str, **over: Any) -> Device:
    given = {path.replace("__", "."): value for path, value in over.items()}
    return Device.of(load(EXAMPLES / f"{name}.yaml", given).scenario)


def truth(device: Device, impacts: int, skipped: int = 0, start: Impact | None = None) -> Truth:
    """The impacts of a device after some that are skipped, time 0 being shortly before the first."""
    groups = device.groups(Parameter.LENGTH, device.length_m)
    model = check_model(groups)[0]
    row = check_start(start or Impact(1, 1.0, 0.3), float(groups.d))
    rows, _ = follow_one(model, row, impacts + skipped, compiled=False)
    rows = rows[1 + skipped :]
    own = np.concatenate([[0.0], np.cumsum(rows[1:, FLIGHT])]) / (2 * device.frequency_hz)
    delay = 0.1 / device.frequency_hz
    return Truth(own + delay, rows[:, WALL], float(rows[0, PHASE] - 2 * np.pi * 0.1))


def slow_sweep(device: Device, lengths: Any, impacts: int, start: Impact) -> tuple[Truth, Any]:
    """Impacts while the length is changed in steps, each held for some impacts, and the length at each.

    Time 0 is a maximum of the force.
    """
    times, walls, held = [], [], []
    now, state = start.phase / (2 * np.pi * device.frequency_hz), start
    for length in lengths:
        groups = device.groups(Parameter.LENGTH, length)
        rows, _ = follow_one(
            check_model(groups)[0], check_start(state, float(groups.d)), impacts, impacts + 1, compiled=False
        )
        rows = rows[-impacts:]
        own = now + np.cumsum(rows[:, FLIGHT]) / (2 * device.frequency_hz)
        times.append(own)
        walls.append(rows[:, WALL])
        held.append(np.full(impacts, length))
        now, state = own[-1], Impact(int(rows[-1, WALL]), float(rows[-1, VELOCITY]), float(rows[-1, PHASE]))
    return Truth(np.concatenate(times), np.concatenate(walls), 0.0), np.concatenate(held)


def in_force_time(known: Truth, device: Device) -> Truth:
    """The same on a clock whose time 0 is a maximum of the force."""
    shift = (known.phase % (2 * np.pi)) / (2 * np.pi * device.frequency_hz)
    return Truth(known.times + shift, known.walls, 0.0)


def word(known: Truth) -> str:
    return "".join("B" if wall > 0 else "T" for wall in known.walls)


__all__ = ["Truth", "device_of", "in_force_time", "pairwise", "slow_sweep", "truth", "word"]
