"""Map files of the tests, their plans, and the result where nothing disturbs the run."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vireport.map.cells.cells import MapPlan, cell_values, map_plan
from vireport.map.cells.run import run_map
from vireport.map.cells.store import Store
from vireport.scenario.loading import loads_map

HELD = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
"""
TEXT = f"""\
{HELD}map:
  chunk_cells: 60
  axes:
    - {{path: inclination_deg, from: 0, to: 90, count: 20}}
    - {{path: device.length_m, from: 0.2, to: 0.9, count: 25}}
"""
CHUNKS = 9


def plan_of(text: str) -> MapPlan:
    return map_plan(loads_map(text))


def store_in(folder: Path, text: str = TEXT) -> Store:
    loaded = loads_map(text)
    return Store(folder, map_plan(loaded), loaded.sha256, loaded.text)


def written_map(folder: Path) -> Path:
    path = folder / "map.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


def result(folder: Path) -> bytes:
    return (folder / "map.parquet").read_bytes()


@cache
def undisturbed_result() -> bytes:
    with TemporaryDirectory() as folder:
        run_map(str(written_map(Path(folder))), Path(folder) / "out", workers=1, draw=False)
        return result(Path(folder) / "out")


def sampled(sampling: str, samples: int, seed: int = 0) -> str:
    """The map with points in the place of its grid."""
    head = f"map:\n  sampling: {sampling}\n  samples: {samples}\n  seed: {seed}"
    return re.sub(", count: ..", "", TEXT).replace("map:", head)


def all_cells(plan: MapPlan) -> list[np.ndarray]:
    """Values along each axis at every cell, chunk by chunk."""
    chunks = (cell_values(plan, plan.numbers(k)) for k in range(plan.chunks))
    return [np.concatenate(parts) for parts in zip(*chunks, strict=True)]
