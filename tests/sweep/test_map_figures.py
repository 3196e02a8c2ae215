"""Maps over several parameters: what is wrong in their files, and their pictures."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("pyarrow")

import pyarrow.parquet as pq

from vireport.errors import ScenarioError
from vireport.scenario import loads_map
from vireport.sweep import run_map

HELD = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
"""
BLOCK = """\
map:
  chunk_cells: 60
  axes:
    - {path: inclination_deg, from: 0, to: 90, count: 20}
    - {path: device.length_m, from: 0.2, to: 0.9, count: 25}
"""
TEXT = HELD + BLOCK


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "map.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


def mistakes(text: str) -> list[str]:
    with pytest.raises(ScenarioError) as caught:
        loads_map(text, "m")
    return [f"{one.line}:{one.path}" for one in caught.value.mistakes]


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("from: 0,", "", ["7:map.axes.0"]),
        ("count: 20", "count: 2.5", ["7:map.axes.0.count"]),
        ("count: 20", "count: 20, values: [1, 2]", ["7:map.axes.0.from"]),
        ("to: 90", "to: 91", ["7:map.axes.0.to"]),
        ("inclination_deg", "device.length_m", ["7:map.axes.0.from", "8:map.axes.1.path"]),
        ("inclination_deg", "device.capsule_mass_kg", ["7:map.axes.0.path"]),
        ("device.length_m, from: 0.2, to: 0.9", "device.ball_mass_kg, from: 0.2, to: 0.9", None),
        ("restitution: 0.5", "restitution: 1.5", ["2:device.restitution"]),
        ("chunk_cells: 60", "sampling: sobol\n  samples: 100", None),
        ("chunk_cells: 60", "sampling: list", None),
        ("chunk_cells: 60", "simulate: {starts: 0}", ["5:map.simulate.starts"]),
        ("chunk_cells: 60", "samples: 60", ["5:map.samples"]),
        ("chunk_cells: 60", "chunks: 60", ["5:map.chunks"]),
        (BLOCK, "", ["1:map"]),
        ("map:", "sweep: {parameter: length_m, from: 1, to: 2}\nmap:", ["4:sweep"]),
    ],
)
def test_mistakes_are_found_with_line_and_path(old: str, new: str, found: list[str] | None) -> None:
    assert old in TEXT
    got = mistakes(TEXT.replace(old, new))
    assert got
    if found is not None:
        assert sorted(got) == sorted(found)


def test_all_mistakes_at_once() -> None:
    text = TEXT.replace("restitution: 0.5", "restitution: x").replace("to: 90", "to: 95").replace("0.9", "-1")
    assert mistakes(text) == ["2:device.restitution", "7:map.axes.0.to", "8:map.axes.1.to"]


@pytest.mark.slow
def test_pictures_show_the_cells(file: Path) -> None:
    """The colour of the picture at a cell is that of its type."""
    from PIL import Image

    from vireport.sweep.cells import map_plan
    from vireport.sweep.figures import TYPES, map_figures

    out = file.parent / "out"
    summary = run_map(str(file), out, workers=1)
    assert all(str(out / f"map-{name}.png") in summary for name in ("stability", "margin", "voltage"))
    axes = map_figures(map_plan(loads_map(TEXT)), out / "map.parquet")["map-stability"].axes[0]
    picture = Image.open(out / "map-stability.png").convert("RGB")
    rows = pq.read_table(out / "map.parquet").to_pylist()
    right = 0
    for row in rows:
        x, y = axes.transData.transform((row["inclination_deg"], row["length_m"]))
        pixel = picture.getpixel((round(x), round(picture.height - y)))
        wanted = TYPES[row["stability"]][1] if row["stability"] else "#FFFFFF"
        right += "#{:02X}{:02X}{:02X}".format(*pixel) == wanted
    assert right > 0.85 * len(rows)  # the others lie under a curve


@pytest.mark.slow
def test_pictures_are_the_same_in_every_run(file: Path) -> None:
    text = TEXT.replace("count: 20", "count: 4").replace("device.length_m, from: 0.2, to: 0.9", "RESTITUTION")
    file.write_text(
        text.replace("RESTITUTION", "device.restitution, from: 0.3, to: 0.6").replace(
            "restitution: 0.5}", "restitution: 0.5, length_m: 0.5}"
        ),
        encoding="utf-8",
    )
    names = ("map-stability.png", "map-margin.png", "map-voltage.png")
    found = []
    for k in range(2):
        run_map(str(file), file.parent / f"out{k}", workers=1)
        found.append([(file.parent / f"out{k}" / name).read_bytes() for name in names])
    assert found[0] == found[1]


def test_samples_are_not_drawn(file: Path) -> None:
    text = re.sub(", count: ..", "", TEXT).replace("map:", "map:\n  sampling: sobol\n  samples: 64")
    file.write_text(text, encoding="utf-8")
    summary = run_map(str(file), file.parent / "out", workers=1)
    assert "heat maps are drawn of a grid" in summary
    assert not list((file.parent / "out").glob("*.png"))
