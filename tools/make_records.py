"""Makes the recorded signals of examples/records by simulation, with noise of a fixed seed; their truth is here.

    python tools/make_records.py

`shaker.wav` is the acceleration of a shaker alone; `prototype.wav` has the voltage of both membranes, positive at the
bottom, and the acceleration of the device of `measured.yaml` with other restitutions than it says. Beside each stand
the notes that its channels need.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace
from scipy.io import wavfile

from vireport import load
from vireport.physics.device import Device
from vireport.physics.groups import Restitutions
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import Impact, check_model, check_start, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, WALL

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"

SHAKER_RATE, SHAKER_S = 100, 300.0
AMPLITUDE_M_S2, FREQUENCY_HZ, SECOND_PERCENT, SHAKER_NOISE_M_S2 = 24.1, 2.001, 1.5, 0.15
"""Of the shaker that `shaker.wav` shows; its amplitude also wanders by 2 % with a memory of 20 s."""

WANDERS, MEMORY_S = 0.02, 20.0

PROTOTYPE_RATE, PROTOTYPE_S = 4000, 11.0
RESTITUTION_BOTTOM, RESTITUTION_TOP = 0.52, 0.47
"""Of the device that `prototype.wav` shows."""

CONTACT_S, VOLTAGE_NOISE_V, HUM_V, SENSOR_NOISE_M_S2 = 6e-3, 4e-3, 0.02, 0.1


def shaker() -> dict[str, tuple[Any, float]]:
    """The acceleration of a shaker that is not quite a sine."""
    rng = np.random.default_rng(1)
    t = np.arange(int(SHAKER_S * SHAKER_RATE)) / SHAKER_RATE
    keep = np.exp(-1 / (MEMORY_S * SHAKER_RATE))
    wander = np.zeros(len(t))
    for k, kick in enumerate(rng.standard_normal(len(t) - 1)):
        wander[k + 1] = keep * wander[k] + np.sqrt(1 - keep**2) * kick
    x = 2 * np.pi * FREQUENCY_HZ * t + 1.0
    force = np.cos(x) + SECOND_PERCENT / 100 * np.cos(2 * x)
    noise = SHAKER_NOISE_M_S2 * rng.standard_normal(len(t))
    return {"acceleration_m_s2": (AMPLITUDE_M_S2 * (1 + WANDERS * wander) * force + noise, 40.0)}


def prototype() -> dict[str, tuple[Any, float]]:
    """What the membranes and the shaker's sensor show of a device."""
    rng = np.random.default_rng(2)
    given = Device.of(load(EXAMPLES / "measured.yaml").scenario)
    device = replace(given, restitution=Restitutions(RESTITUTION_BOTTOM, RESTITUTION_TOP))
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    begin = check_start(Impact(1, 1.0, 0.3), groups.d)
    rows, _ = follow_one(check_model(groups)[0], begin, 200, compiled=False)
    rate = 2 * device.frequency_hz
    times = np.cumsum(rows[:, FLIGHT]) / rate + 0.1
    rows = rows[times < PROTOTYPE_S - 0.1]
    times = times[: len(rows)]
    t = np.arange(int(PROTOTYPE_S * PROTOTYPE_RATE)) / PROTOTYPE_RATE
    x = 2 * np.pi * device.frequency_hz * (t - times[0]) + rows[0, PHASE]
    acceleration = device.amplitude_n / device.capsule_mass_kg * np.cos(x)
    voltage = VOLTAGE_NOISE_V * rng.standard_normal(len(t)) + HUM_V * np.sin(2 * np.pi * 50 * t)
    for time, wall in zip(times, rows[:, WALL], strict=True):
        gone = (t - time) / CONTACT_S
        voltage += rng.uniform(0.7, 1.0) * wall * np.where((gone > 0) & (gone < 1), np.sin(np.pi * gone), 0)
    acceleration += SENSOR_NOISE_M_S2 * rng.standard_normal(len(t))
    return {"voltage_v": (voltage, 2.0), "acceleration_m_s2": (acceleration, 50.0)}


def write(name: str, rate: int, channels: dict[str, tuple[Any, float]]) -> None:
    """A WAV file of 16 bits, and the notes of its channels."""
    whole = [np.round(values / full * 32768).clip(-32768, 32767) for values, full in channels.values()]
    wavfile.write(EXAMPLES / "records" / name, rate, np.column_stack(whole).astype(np.int16))
    notes = "".join(f"  {channel}: {full:g}\n" for channel, (_, full) in channels.items())
    (EXAMPLES / "records" / f"{name}.yaml").write_text(f"channels:\n{notes}", encoding="utf-8")


if __name__ == "__main__":
    write("shaker.wav", SHAKER_RATE, shaker())
    write("prototype.wav", PROTOTYPE_RATE, prototype())
