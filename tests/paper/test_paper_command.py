"""`vireport paper`: the paper's figures, Table 1 and printed numbers, and what an override changes of them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from figure_cases import assert_readable
from matplotlib.text import Text
from pages import lines_of, read_back, render_html

from vireport.cli.app import main
from vireport.figures.style import Picture, Sheet, drawn_for
from vireport.paper.figures import paper_pictures
from vireport.paper.opening import paper_opening
from vireport.paper.outputs import paper_provenance
from vireport.paper.page import PaperReport
from vireport.paper.reproduction import EXAMPLES, FILES, ReproducedPaper, reproduce_paper
from vireport.paper.results import paper_data
from vireport.study.judging.verdict import Status

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def paper() -> ReproducedPaper:
    return reproduce_paper()


@pytest.fixture(scope="module")
def drawn(paper: ReproducedPaper) -> dict[str, Picture]:
    return {picture.name: picture for picture in paper_pictures(paper)}


def test_of_31_printed_results_22_are_confirmed_and_9_are_misprints(paper: ReproducedPaper) -> None:
    data = paper_data(paper)
    assert (data.confirmed, data.misprints, data.not_printed) == (22, 9, 7)
    assert len(data.numbers) == 38
    assert paper.printed == 31
    assert [(row.panels, row.of, row.quantity) for row in data.numbers if row.agreement == "differs"] == [
        ("(a)–(c)", "C1", "point_phase"),
        ("(a)–(c)", "Fig. 3(a, b)", "phase"),
        ("(d)–(f)", "Fig. 3(c, d)", "phase"),
        ("(d)–(f)", "Fig. 3(c, d)", "share"),
        ("(g)–(i)", "B1", "point_phase"),
        *[("(g)–(i)", "Fig. 3(g, h)", "flight")] * 4,
    ]


def test_every_interval_of_table_1_has_its_numbers_and_the_printed_type(paper: ReproducedPaper) -> None:
    assert paper.intervals == (11, 11)
    rows = {(row.panels, row.family, row.from_point, row.to_point): row for row in paper_data(paper).table_1}
    assert len(rows) == 11
    row = rows["(a)–(c)", "asymmetric", "A1", "A2"]
    assert (row.d_from, row.d_to) == pytest.approx((0.2079356188, 0.2438848418), abs=1e-10)
    assert (row.stability, row.criteria) == ("stable focus", "Delta < 0 and |lambda_i| < 1")


def test_the_simulation_comes_to_the_solved_motions_from_the_printed_values(paper: ReproducedPaper) -> None:
    assert 0 < paper.simulation_difference < 1e-12
    assert [portrait.attractor.word for portrait in paper.portraits] == ["BT", "BT", "BT", "BTBT"]
    # (b) of Fig. 6 is an asymmetric motion of the horizontal capsule, in the interval of Table 1 that ends at C1.
    horizontal = paper.displacements[1]
    assert horizontal.gbar == 0
    assert 0.2438848418 < horizontal.d < 0.2634315843
    speeds = abs(horizontal.attractor.cycle.velocity)
    assert horizontal.attractor.cycle.flight[0] != pytest.approx(horizontal.attractor.cycle.flight[1], rel=0.05)
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-9)  # equally fast, as in every motion without gravity


def test_the_figures_are_readable_in_a_column(paper: ReproducedPaper) -> None:
    """Names of curves that have no room are left out; those of critical points stay."""
    with drawn_for(Sheet.of(86)):
        column = {picture.name: picture.figure for picture in paper_pictures(paper)}
    for figure in column.values():
        assert_readable(figure)
    texts = {text.get_text() for text in column["figure-4"].findobj(Text)}
    assert {"A1", "B1", "C1", "G1", "G2"} <= texts
    assert not [text for text in texts if text.startswith(("symmetric", "asymmetric"))]


def test_the_figures_have_the_papers_panels(drawn: dict[str, Picture]) -> None:
    assert list(drawn) == ["figure-2", "figure-3", "figure-4", "figure-6", "figure-7"]
    letters = {
        name: sorted({text.get_text()[:3] for axes in picture.figure.axes for text in titles_of(axes)})
        for name, picture in drawn.items()
    }
    panels = {"figure-2": 9, "figure-3": 8, "figure-4": 6, "figure-6": 4, "figure-7": 3}
    assert letters == {name: [f"({chr(97 + k)})" for k in range(count)] for name, count in panels.items()}


def titles_of(axes):
    texts = [*axes.texts, axes.title, axes._left_title]
    return [text for text in texts if text.get_text().startswith("(") and text.get_text()[2:3] == ")"]


def test_a_report_says_what_is_kept(paper: ReproducedPaper, drawn: dict[str, Picture]) -> None:
    said = lines_of(render_html(PaperReport(paper, drawn, paper_provenance(paper, "vireport paper"))))
    assert read_back("paper", [line for line in said if "e-16" not in line]) == []


def test_an_override_changes_what_stays_as_printed() -> None:
    changed = reproduce_paper(["device.restitution=0.45"])
    opening = paper_opening(changed).worded()
    assert opening.status is Status.NEUTRAL
    same = len(changed.agreeing(True))
    assert opening.sentence.startswith(f"With device.restitution=0.45, {same} of the 31 results that the paper prints")
    assert 0 < len(changed.agreeing(True)) < 22
    assert any(text.startswith("Not as printed: ") for _, text in opening.facts)
    assert opening.tiles[0].label == "As printed"


@pytest.mark.parametrize("override", ["device.restitution=0.9", "period_ratio=3"])
def test_without_its_motions_the_paper_has_little_left(override: str) -> None:
    opening = paper_opening(reproduce_paper([override])).worded()
    assert opening.sentence.endswith("are of motions that are not there.")
    assert any("intervals of Table 1 are not of the type that it prints" in text for _, text in opening.facts)


def test_the_command_writes_figures_report_and_numbers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["paper", "-o", str(tmp_path / "out")]) == 0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    figures = {f"figure-{number}.png" for number in (2, 3, 4, 6, 7)}
    assert names == {"report.html", "report.pdf", "paper.json"} | figures
    said = capsys.readouterr()
    assert "of an earlier run" not in said.err
    assert said.out.startswith(
        "Of the 31 results that the paper prints, 22 are confirmed and 9 are misprints; 7 critical"
    )
    whole = json.loads((tmp_path / "out" / "paper.json").read_text())
    assert main(["paper", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert {key: value for key, value in printed.items() if key != "provenance"} == {
        key: value for key, value in whole.items() if key != "provenance"
    }
    assert all((EXAMPLES / file).is_file() for file in FILES.values())
