"""Raw signals whose truth is known: what impacts of given times and strengths make of channels with noise and hum."""

from __future__ import annotations

from typing import Any

import numpy as np

from vireport.measurement.recordings import Channel, HeardPlace, Recording, Unbroken

RATE = 48_000.0


def ringing(t: Any, frequency: float = 2500.0, decay: float = 1.5e-3) -> Any:
    """A pulse that rings, of height 1 or a little less."""
    after = np.maximum(t, 0)
    return np.where(t > 0, np.sin(2 * np.pi * frequency * after) * np.exp(-after / decay), 0)


def contact(t: Any, length: float = 5e-3) -> Any:
    """A membrane's voltage while the ball is on it."""
    return np.where((t > 0) & (t < length), np.sin(np.pi * t / length), 0)


def signal(times: Any, sizes: Any, seconds: float, pulse: Any = ringing, rate: float = RATE, long: float = 0.03) -> Any:
    """The sum of a pulse at each time."""
    values = np.zeros(int(seconds * rate))
    for time, size in zip(times, sizes, strict=True):
        first = int(np.ceil(time * rate))
        rows = np.arange(first, min(len(values), first + int(long * rate)))
        values[rows] += size * pulse(rows / rate - time)
    return values


def clock(values: Any, rate: float = RATE) -> Any:
    return np.arange(len(values)) / rate


def hum(values: Any, size: float, rate: float = RATE) -> Any:
    return size * np.sin(2 * np.pi * 50.02 * clock(values, rate) + 1)


def recording(rate: float = RATE, **channels: Any) -> Recording:
    """A recording of channels by their names."""
    places = {"bottom": HeardPlace.BOTTOM, "top": HeardPlace.TOP, "acceleration": HeardPlace.CAPSULE}
    places |= {"displacement": HeardPlace.DISPLACEMENT}
    own = tuple(
        Channel(name, places.get(name.partition("_")[0], HeardPlace.EITHER), np.asarray(values, dtype=float))
        for name, values in channels.items()
    )
    return Recording("x.csv", 1 / rate, (Unbroken(0, len(own[0].values), 0.0),), own)
