"""Maps over several parameters: what is wrong in their files, and their pictures."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("pyarrow")

import pyarrow.parquet as pq
from map_texts import TEXT, written_map
from matplotlib.axes import Axes

from vireport.map.cells.cells import MapPlan, map_plan
from vireport.map.cells.figures import map_pictures
from vireport.map.cells.findings import findings_of
from vireport.map.cells.run import run_map
from vireport.scenario.loading import loads_map


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return written_map(tmp_path)


def drawn(plan: MapPlan, result: Path, name: str) -> Axes:
    """The axes of a heat map."""
    pictures = map_pictures(plan, result, findings_of(plan, result))
    return next(picture.figure.axes[0] for picture in pictures if picture.name == name)


@pytest.mark.slow
def test_pictures_show_the_cells(file: Path) -> None:
    """The colour of the picture at a cell is that of its type."""
    from PIL import Image

    from vireport.map.cells.figures import TYPES

    out = file.parent / "out"
    summary = run_map(str(file), out, workers=1)
    assert all(str(out / f"map-{name}.png") in summary for name in ("stability", "margin", "voltage"))
    axes = drawn(map_plan(loads_map(TEXT)), out / "map.parquet", "map-stability")
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
    shown = []
    for k in range(2):
        run_map(str(file), file.parent / f"out{k}", workers=1)
        shown.append([(file.parent / f"out{k}" / name).read_bytes() for name in names])
    assert shown[0] == shown[1]


def test_samples_are_not_drawn(file: Path) -> None:
    text = re.sub(", count: ..", "", TEXT).replace("map:", "map:\n  sampling: sobol\n  samples: 64")
    file.write_text(text, encoding="utf-8")
    summary = run_map(str(file), file.parent / "out", workers=1)
    sentence, fact, written = summary.splitlines()
    assert sentence.startswith("1:1 motion is stable at ")
    assert fact.startswith("Unstable only: ")
    assert written.startswith("wrote ")
    assert "heat maps are drawn of a grid" in written
    assert not list((file.parent / "out").glob("*.png"))


@pytest.mark.slow
def test_pictures_show_what_switching_on_leads_to(file: Path) -> None:
    """A stable motion that is not reached has the colour of what is reached instead."""
    pytest.importorskip("numba")
    from PIL import Image

    from vireport.figures.sweeps import OUTCOMES

    text = TEXT.replace("map:", "map:\n  from_rest: true\n  shock: true").replace("count: 20", "count: 8")
    file.write_text(text.replace("count: 25", "count: 10"), encoding="utf-8")
    out = file.parent / "out"
    summary = run_map(str(file), out, workers=1)
    assert all(str(out / f"map-{name}.png") in summary for name in ("from-rest", "shock"))
    rows = pq.read_table(out / "map.parquet").to_pylist()
    axes = drawn(map_plan(loads_map(file.read_text())), out / "map.parquet", "map-from-rest")
    picture = Image.open(out / "map-from-rest.png").convert("RGB")
    right = 0
    for row in rows:
        x, y = axes.transData.transform((row["inclination_deg"], row["length_m"]))
        right += (
            "#{:02X}{:02X}{:02X}".format(*picture.getpixel((round(x), round(picture.height - y))))
            == OUTCOMES[row["from_rest"]][1]
        )
    assert right > 0.85 * len(rows)
    assert len({row["from_rest"] for row in rows}) > 2
