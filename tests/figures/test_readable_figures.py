"""Every figure of every example and of the extreme sweeps can be read: no text is cut off or lies on another."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from conftest import first
from figure_cases import CASES, FIGURES, ROOT, assert_readable, figure_of, simulated_study

import vireport
from vireport import Comparison
from vireport.comparison.figures import compare_pictures
from vireport.figures.curves import simulated_points
from vireport.figures.pictures import pictures
from vireport.findings.accuracy.methods import METHODS
from vireport.scenario.loading import load_map, loads
from vireport.study.study import analyse

EXAMPLES = ("horizontal", "inclined", "inclined-forcing")


def path(name: str) -> str:
    return str(ROOT / "examples" / f"{name}.yaml")


@cache
def comparison(kind: str) -> Comparison:
    if kind == "inclinations":
        return vireport.compare([path("inclined")], vary={"inclination_deg": [0, 15, 30, 45]})
    return vireport.compare([path(name) for name in EXAMPLES])


@pytest.mark.parametrize("name", first(1, CASES))
@pytest.mark.parametrize("figure", list(FIGURES))
def test_along_a_sweep(name: str, figure: str) -> None:
    assert_readable(figure_of(name, figure))


@pytest.mark.slow
def test_from_simulation() -> None:
    study = simulated_study()
    for picture in pictures(study, simulated_points(study)):
        if picture.name != "figure-device":  # texts at an angle, which have a test of their own
            assert_readable(picture.figure)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["inclinations", "scenarios"])
def test_of_a_comparison(kind: str) -> None:
    drawn = compare_pictures(comparison(kind))
    assert len(drawn) == 1 + len(FIGURES)
    for picture in drawn:
        assert_readable(picture.figure)


@pytest.mark.slow
def test_of_what_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    quick = [method for method in METHODS if not method.name.endswith(("Radau", "LSODA"))]
    monkeypatch.setattr("vireport.findings.accuracy.workprecision.METHODS", quick)
    text = Path(path("inclined")).read_text(encoding="utf-8")
    study = analyse(loads(f"{text}\naccuracy: {{repeats: 1, ladder: [1, 100]}}\n"), ["png"])
    measured = [picture for picture in pictures(study) if picture.name in ("figure-accuracy", "figure-stiffness")]
    assert [picture.name for picture in measured] == ["figure-accuracy", "figure-stiffness"]
    for picture in measured:
        assert_readable(picture.figure)
        assert picture.caption.count(". ") <= 1


@pytest.mark.slow
def test_of_a_map(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    from vireport.map.cells.cells import map_plan
    from vireport.map.cells.figures import map_pictures
    from vireport.map.cells.findings import findings_of
    from vireport.map.cells.run import run_map

    text = (ROOT / "examples" / "maps" / "map.yaml").read_text(encoding="utf-8")
    file = tmp_path / "map.yaml"
    file.write_text(text.replace("count: 60", "count: 12").replace("count: 80", "count: 16"), encoding="utf-8")
    run_map(str(file), tmp_path / "out", workers=1, draw=False)
    finished = map_plan(load_map(file)), tmp_path / "out" / "map.parquet"
    drawn = map_pictures(*finished, findings_of(*finished))
    assert [picture.name for picture in drawn] == ["map-stability", "map-margin", "map-voltage"]
    for picture in drawn:
        assert_readable(picture.figure)
