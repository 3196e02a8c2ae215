"""The report of a map: every number on its page against the rows of the map, and the verdict of the design point."""

from __future__ import annotations

import re
from collections import Counter
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from conftest import first

pytest.importorskip("pyarrow")

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from map_texts import HELD, TEXT, sampled
from pages import HtmlTable, Page, lines_of, read_back
from pypdf import PdfReader
from shown import Amount, Cell, Row, Said, table_faults

from vireport.base.errors import RenderError, ScenarioError
from vireport.cli.app import main
from vireport.map.cells.cells import map_plan
from vireport.map.cells.evaluation import CODES
from vireport.map.cells.findings import MapQuantity, findings_of
from vireport.map.cells.report import map_design
from vireport.map.cells.run import run_map
from vireport.map.outputs import MapOutput
from vireport.motions.stability import STABILITIES
from vireport.scenario.loading import loads, loads_map
from vireport.study.plan import Task
from vireport.study.study import analyse

DESIGN = HELD.replace("restitution: 0.5}", "restitution: 0.5, length_m: 0.7}") + "inclination_deg: 45\n"
MAP = DESIGN + TEXT.removeprefix(HELD)
R4 = 0.5**4


def reported(folder: Path, text: str, **asked: Any) -> tuple[Page, list[dict[str, Any]]]:
    """The page of a map, and its rows."""
    file, out = folder / "map.yaml", folder / "out"
    file.write_text(text, encoding="utf-8")
    summary = run_map(str(file), out, workers=1, output=MapOutput((Task.HTML,), **asked)).splitlines()
    assert len(summary) <= 4  # the answer in three lines, and what was written
    assert summary[-1].startswith("wrote ")
    return Page((out / "report.html").read_bytes()), pq.read_table(out / "map.parquet").to_pylist()


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> tuple[Page, list[dict[str, Any]]]:
    return reported(tmp_path_factory.mktemp("map"), MAP)


def wrong(table: HtmlTable, expected: list[Row]) -> list[str]:
    head, *rows = table.rows
    return list(table_faults(head, rows, expected))


def share(part: float) -> Said:
    return Said("{}", Amount(100 * part, "%", 2))


def by_type(rows: list[dict[str, Any]]) -> list[Row]:
    counts = Counter(row["stability"] for row in rows)
    names = {"Stable node": "stable node", "Stable focus": "stable focus", "Unstable node": "unstable node"}
    return [
        {"Motion": name, "Cells": f"{counts[word]:,}", "Part of all": share(counts[word] / len(rows))}
        for name, word in [*names.items(), ("None", None)]
    ]


def largest(rows: list[dict[str, Any]], name: str, column: str, said: Any) -> Row:
    stable = [row for row in rows if row["stability"] in ("stable node", "stable focus") and row[column] is not None]
    best = max(stable, key=lambda row: row[column])
    places: dict[str, Cell] = {"at inclination": Amount(best["inclination_deg"], "°", 3)}
    return {"Quantity": name, "Largest": said(best[column]), **places, "at length": Amount(best["length_m"], "m", 3)}


def percent_of_largest(value: float) -> Said:
    return Said("{}", Amount(100 * value / (1 + R4), "%", 2))


def volts(value: float) -> Said:
    return Said("{}", Amount(value, "V", 3))


def margin_and_voltage(rows: list[dict[str, Any]]) -> list[Row]:
    return [
        largest(rows, "Stability margin", "multiplier_margin", percent_of_largest),
        largest(rows, "Average voltage", "u_ave_v", volts),
    ]


LARGEST = "Largest values among the cells with a stable motion"
CELLS = "Cells by the 1:1 motion that they have, a stable one before others"


@pytest.mark.slow
def test_the_numbers_of_its_cells_are_those_of_its_rows(plain) -> None:
    page, rows = plain
    assert wrong(page.tables[CELLS], by_type(rows)) == []
    assert wrong(page.tables[LARGEST], margin_and_voltage(rows)) == []


@pytest.mark.slow
def test_the_margins_of_its_design_point_are_where_stable_motion_ends(plain) -> None:
    page, _ = plain
    table = page.tables["Where stable 1:1 motion ends, from β = 45°, s = 0.7 m"]
    ends = {"inclination": "inclination_deg", "length": "device.length_m"}
    given = {"inclination": (45.0, "°"), "length": (0.7, "m")}
    margins = analyse(loads(DESIGN, "x"), (Task.JSON,)).solution.design.margins
    known = {name: [end.sweep_value for end in margins if end.parameter.quantity == name] for name in ends}
    expected: list[Row] = []
    for name, shown, *_ in table.rows[1:]:
        told = float(re.sub(r"[^\d.].*", "", shown))
        value = min(known[name], key=lambda end: abs(end - told))
        assert value == pytest.approx(told, rel=5e-3)
        distance, unit = value - given[name][0], given[name][1]
        inside, outside = (value - distance * 1e-5, value + distance * 1e-5)
        for at, stable in ((inside, True), (outside, False)):
            design = analyse(loads(DESIGN, "x", {ends[name]: at}), (Task.JSON,)).solution.design
            assert bool(design.motions.stable_mask.any()) is stable
        sign = "+" if distance > 0 else "−"
        expected.append(
            {
                "Input": name,
                "Ends at": Said("{}", Amount(value, unit, 3)),
                "Distance": Said(sign + "{}", Amount(abs(distance), unit)),
                "of the design value": Said(sign + "{}", Amount(100 * abs(distance) / given[name][0], "%", 2)),
                "Event": "fold" if value > 1 and name == "length" else "period doubling",
            }
        )
    assert [row["Input"] for row in expected] == ["inclination", "length", "length"]
    assert wrong(table, expected) == []


def test_its_verdict_is_that_of_a_run_of_the_design_point(plain) -> None:
    page, _ = plain
    study = analyse(loads(DESIGN), (Task.JSON,))
    opening = study.opening.worded()
    assert opening.sentence in page.text
    assert all(tile.value in page.text for tile in opening.tiles)
    assert study.alerts
    unsaid = [alert.code for alert in study.alerts if f"{alert.code}: " not in page.text]
    assert unsaid == []
    assert "The answer is that of the design point, β = 45°, s = 0.7 m" in page.text
    assert page.text.count("Bars: the nearer end along either axis.") == 1
    assert read_back("map", lines_of(page.data)) == []


@pytest.mark.slow
def test_a_design_point_off_the_map_is_told_and_not_drawn(tmp_path: Path) -> None:
    page, _ = reported(tmp_path, MAP.replace("length_m: 0.7", "length_m: 1.2"))
    assert "The design point, β = 45°, s = 1.2 m, is off the map." in page.text
    assert "Bars: the nearer end" not in page.text


def test_without_a_design_point_it_says_what_the_cells_hold(tmp_path: Path) -> None:
    page, rows = reported(tmp_path, sampled("sobol", 64))
    counts = Counter(row["stability"] for row in rows)
    stable = counts["stable node"] + counts["stable focus"]
    shares = stable, counts["unstable node"], counts[None]
    stable_at, *others = (Amount(100 * part / 64, "%", 2) for part in shares)
    assert Said("1:1 motion is stable at {} of 64 cells.", stable_at).faults(page.text) == ""
    assert Said("Unstable only: {}; no 1:1 motion: {}.", *others).faults(page.text) == ""
    assert "Figures Heat maps are drawn of a grid over two parameters" in page.text
    assert wrong(page.tables[CELLS], by_type(rows)) == []
    assert read_back("map, sampled", lines_of(page.data)) == []


@pytest.mark.slow
def test_it_counts_what_switching_on_leads_to(tmp_path: Path) -> None:
    pytest.importorskip("numba")
    text = MAP.replace("map:", "map:\n  from_rest: true\n  shock: true").replace("count: 20", "count: 8")
    page, rows = reported(tmp_path, text.replace("count: 25", "count: 10"))
    counts = Counter(row["from_rest"] for row in rows).most_common()
    table = page.tables["What the device of each cell comes to that is switched on from rest"]
    names = {"reaches_1_1": "1:1", "other_motion": "Another motion", "rest_cycle": "Rest cycle", "chaotic": "Chaotic"}
    expected: list[Row] = [
        {"Outcome": names[word], "Cells": str(count), "Part of all": share(count / len(rows))} for word, count in counts
    ]
    assert wrong(table, expected) == []
    missed = [
        row for row in rows if row["stability"] in ("stable node", "stable focus") and row["from_rest"] != "reaches_1_1"
    ]
    said = Said(
        "Stable 1:1 motion is not reached from rest at {} of the cells.", Amount(100 * len(missed) / len(rows), "%", 2)
    )
    assert said.faults(page.text) == ""
    shock = largest(rows, "Least shock", "least_jump_m_s", lambda value: Said("{}", Amount(value, "m/s", 3)))
    assert wrong(page.tables[LARGEST], [*margin_and_voltage(rows), shock]) == []


@pytest.mark.slow
def test_its_files_are_the_same_in_every_run_and_whole(tmp_path: Path, capsys) -> None:
    file = tmp_path / "map.yaml"
    file.write_text(MAP.replace("count: 20", "count: 6").replace("count: 25", "count: 5"), encoding="utf-8")
    runs = []
    for k in range(2):
        assert main(["map", str(file), "-o", str(tmp_path / f"out{k}"), "--workers", "1", "-q"]) == 0
        runs.append({path.name: path.read_bytes() for path in (tmp_path / f"out{k}").iterdir()})
    assert runs[0] == runs[1]
    heat = {f"map-{name}.png" for name in ("stability", "margin", "voltage")}
    assert set(runs[0]) == {".lock", "map.parquet", "map.parquet.sha256", "report.html", "report.pdf", *heat}
    pdf = PdfReader(BytesIO(runs[0]["report.pdf"]))
    assert pdf.attachments["scenario.yaml"] == [file.read_bytes()]
    assert "by the paper’s formulae" in pdf.pages[0].extract_text().replace("'", "’")


def test_what_is_wrong_with_the_design_point_is_told_before_the_cells_are_computed(tmp_path: Path) -> None:
    text = MAP.replace("length_m: 0.7", "length_m: -0.7")
    assert loads_map(text).block.axes[1].from_ == 0.2
    with pytest.raises(ScenarioError, match="length_m"):
        reported(tmp_path, text)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--format", "png,junit"), "vireport map has no junit"),
        (("--no-figures", "--format", "html"), "writes the cells alone"),
        (("--no-figures", "--figure-width", "86mm"), "writes the cells alone"),
        (("--figure-width", "86mm"), "figures of a report are as wide as its page"),
        (("--figure-width", "5mm", "--format", "svg"), "60 to 250 mm wide"),
    ],
)
def test_options_that_do_not_go_together_are_refused_before_any_work(options, message, tmp_path, capsys) -> None:
    file = tmp_path / "map.yaml"
    file.write_text(MAP, encoding="utf-8")
    assert main(["map", str(file), "-o", str(tmp_path / "out"), *options]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("file", "source", "place"),
    first(
        0,
        [
            ("words/map.j2", "{% macro title(name) %}\n{{ x.nothing }}{% endmacro %}", "words/map.j2"),
            ("map.typ.j2", "{{ report.nothing }}", "map.typ.j2:1: "),
        ],
        unpacked=True,
    ),
)
def test_a_wrong_name_in_a_template_is_told_with_its_place(file: str, source: str, place: str, tmp_path: Path) -> None:
    own = tmp_path / "own"
    (own / file).parent.mkdir(parents=True)
    (own / file).write_text(source, encoding="utf-8")
    text = MAP.replace("count: 20", "count: 3").replace("count: 25", "count: 3")
    with pytest.raises(RenderError, match=place):
        reported(tmp_path, text, templates=own)


@pytest.mark.parametrize(("length", "inside"), [(0.19, False), (0.2, True), (0.91, False)])
def test_a_design_point_is_inside_where_every_axis_has_its_value(length: float, inside: bool) -> None:
    loaded = loads_map(MAP.replace("length_m: 0.7", f"length_m: {length}"))
    found = map_design(loaded.design, map_plan(loaded))
    assert found is not None
    assert (found.inputs, found.inside) == ((45.0, length), inside)


def test_a_map_that_is_read_in_pieces_is_counted_as_a_whole(tmp_path: Path) -> None:
    """The largest value stands in the second piece, and is that of a cell with a stable motion."""
    plan = map_plan(loads_map(TEXT.replace("map:", "map:\n  from_rest: true")))
    count, rng = 70_000, np.random.default_rng(1)
    words = {name: rng.integers(-1, len(CODES[name]), count) for name in ("stability", "from_rest")}
    names = "inclination_deg", "length_m", "multiplier_margin", "u_ave_v"
    numbers = {name: rng.uniform(0, 1, count) for name in names}
    numbers["u_ave_v"][69_000] = 2.0
    words["stability"][69_000] = 0
    numbers["deflection_m"] = rng.uniform(0, 2 * plan.membrane.active_radius_m, count)
    coded = {
        name: pa.DictionaryArray.from_arrays(pa.array(code, pa.int8(), mask=code < 0), pa.array(map(str, CODES[name])))
        for name, code in words.items()
    }
    pq.write_table(pa.table(numbers | coded), tmp_path / "map.parquet")
    found = findings_of(plan, tmp_path / "map.parquet")
    stable = np.isin(words["stability"], [0, 1])
    assert {kind: found.stability[kind] for kind in (*STABILITIES, None)} == {
        kind: int((words["stability"] == code).sum()) for code, kind in [*enumerate(STABILITIES), (-1, None)]
    }
    assert found.missed == int((stable & (words["from_rest"] != 0)).sum())
    best = found.largest[MapQuantity.VOLTAGE]
    assert (best.value, best.inputs) == (2.0, (numbers["inclination_deg"][69_000], numbers["length_m"][69_000]))
    assert found.largest[MapQuantity.MARGIN].value == numbers["multiplier_margin"][stable].max() / (1 + R4)
