"""Figures as wide as the column or the page of a paper: all of them readable, in fonts that a journal takes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import cache
from io import BytesIO
from itertools import product
from pathlib import Path

import pytest
import yaml
from conftest import SHORTEST, WITHOUT, first
from figure_cases import ROOT, assert_readable, boxes_of, study_of, texts_of
from matplotlib.text import Text
from msgspec.structs import replace
from pypdf import PdfReader

from vireport import figure_2, figure_4, figure_7
from vireport.base.errors import UsageError
from vireport.cli.app import main
from vireport.comparison.comparison import Comparison, compare
from vireport.comparison.figures import compare_figure, compare_pictures
from vireport.figures.pictures import pictures
from vireport.figures.style import Picture, Sheet, drawn_for
from vireport.map.cells.cells import map_plan
from vireport.map.cells.figures import map_pictures
from vireport.map.cells.findings import findings_of
from vireport.map.cells.report import map_design
from vireport.map.cells.run import run_map
from vireport.map.chart.chart import Chart, loci_over, with_regions
from vireport.map.chart.figure import picture as chart_picture
from vireport.map.chart.meetings import Meeting
from vireport.map.chart.over import plane_of
from vireport.map.chart.regions import NarrowBand
from vireport.motions.events import Event
from vireport.motions.switching import Limits
from vireport.optimise.outputs import picture_front
from vireport.optimise.problem import problem_of
from vireport.optimise.search import SearchResult, optimise
from vireport.physics.device import Device
from vireport.scenario.loading import load, load_map
from vireport.study.study import Study, analyse

WIDTHS = 86, 178
"""A column and a page of a paper [mm]."""

LEGIBLE = 6.5
"""Size of type that journals ask for at least [pt]."""

SCENARIOS = {
    "simulated": {},
    "hysteresis": {},
    "inclined": {"disturbances": {"basin": True}, "sweep": None},
}


@cache
def study(name: str) -> Study:
    return analyse(load(ROOT / "examples" / f"{name}.yaml", SCENARIOS[name]))


def of_horizontal_type(figure) -> list[Text]:
    return [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]


@cache
def compared() -> Comparison:
    return compare([ROOT / "examples" / "inclined.yaml"], ["inclination_deg=0,30,45"])


def mapped(folder: Path) -> tuple[Picture, ...]:
    """All heat maps of a map, with its design point."""
    text = (ROOT / "examples" / "maps" / "map.yaml").read_text(encoding="utf-8")
    text = text.replace("count: 60", "count: 12").replace("count: 80", "count: 16")
    (folder / "map.yaml").write_text(f"{text}  from_rest: true\n  shock: true\n", encoding="utf-8")
    run_map(str(folder / "map.yaml"), folder, workers=1, draw=False)
    loaded = load_map(folder / "map.yaml")
    plan, result = map_plan(loaded), folder / "map.parquet"
    return map_pictures(plan, result, findings_of(plan, result), map_design(loaded.design, plan))


@cache
def one_to_one() -> Chart:
    """A chart of 1:1 motions, with the design point and its margins."""
    loaded = load(ROOT / "examples" / "inclined.yaml")
    plane = plane_of(loaded.scenario, "restitution=0.4..0.6,length_m=0.55..0.75")
    return with_regions(loci_over(plane, Limits(2, 1), cuts=0), Device.of(loaded.scenario))


def charted(_: Path) -> list[Picture]:
    return [chart_picture(one_to_one())]


@cache
def best() -> SearchResult:
    design, required = map(yaml.safe_load, (SHORTEST, WITHOUT))
    loaded = load(ROOT / "examples" / "best-design.yaml", {"design": design, "requirements": required})
    return optimise(problem_of(loaded))


def searched(_: Path) -> list[Picture]:
    """What margin costs."""
    return [picture_front(best())]


DRAWN: dict[str, tuple[int, Callable[[Path], Iterable[Picture]]]] = {
    "comparison": (4, lambda _: compare_pictures(compared())),
    "map": (5, mapped),
    "chart": (1, charted),
    "optimise": (1, searched),
}
"""What else is drawn than the figures of a run, and how many figures at least."""


@pytest.mark.slow
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", [*SCENARIOS, *DRAWN])
@pytest.mark.usefixtures("short_front")
def test_every_figure_is_readable_at_the_width_of_a_paper(name: str, width: int, tmp_path: Path) -> None:
    least, draw = DRAWN.get(name, (3, lambda _: pictures(study(name))))
    with drawn_for(Sheet.of(width)):
        drawn = list(draw(tmp_path))
    assert len(drawn) >= least
    for picture in drawn:
        assert picture.figure.get_figwidth() * 25.4 == pytest.approx(width)
        assert_readable(picture.figure)
        assert min(text.get_size() for text in of_horizontal_type(picture.figure)) >= LEGIBLE


@pytest.mark.parametrize(("name", "width"), first(0, product(["horizontal", "inclined-forcing"], WIDTHS), True))
def test_figures_of_a_sweep_are_readable_and_leave_what_is_held_to_the_caption(name: str, width: int) -> None:
    for draw in (figure_2, figure_4, figure_7):
        figure = draw(study_of(name), width_mm=width)
        assert_readable(figure)
        held = [text for text in texts_of(figure) if text.startswith(("F = ", "s = ", "β = "))]
        assert held == []


@pytest.mark.slow
def test_a_caller_s_font_and_size_are_used_and_then_forgotten() -> None:
    own = {"font.family": "DejaVu Serif", "font.size": 7.0}
    figure = figure_2(study_of("horizontal"), width_mm=86, style=own)
    labels = [text for text in of_horizontal_type(figure) if text.get_text() == "length s [m]"]
    assert [(text.get_fontname(), text.get_size()) for text in labels] == [("DejaVu Serif", 7.0)]
    assert_readable(figure)
    again = figure_2(study_of("horizontal"))
    assert {text.get_fontname() for text in of_horizontal_type(again)} == {"DejaVu Sans"}
    assert boxes_of(again)[0][1].height > boxes_of(figure)[0][1].height


@pytest.mark.slow
def test_a_figure_as_pdf_has_its_width_and_truetype_fonts_and_the_same_bytes() -> None:
    first, second, untouched = (
        next(p for p in pictures(study_of("horizontal"), width_mm=86) if p.name == "figure-2") for _ in range(3)
    )
    assert first.pdf == second.pdf
    assert first.png == untouched.png  # a PDF leaves the figure as it was
    (page,) = PdfReader(BytesIO(first.pdf)).pages
    assert float(page.mediabox.width) / 72 * 25.4 == pytest.approx(86, abs=0.01)
    assert "/Type3" not in first.pdf.decode("latin-1")
    assert re.search(r"/FontFile2", first.pdf.decode("latin-1"))
    assert "impact velocity" in page.extract_text()
    assert "CreationDate" not in first.pdf.decode("latin-1")


@pytest.mark.slow
def test_a_comparison_in_a_column_has_as_many_scenarios_beside_one_another_as_fit() -> None:
    wide, narrow = (compare_figure(compared(), "figure-2", width_mm=width) for width in (178, 86))
    titles = [
        [[text for text in texts_of(figure) if text.startswith("inclination ")] for figure in figures]
        for figures in (wide, narrow)
    ]
    assert [list(map(len, own)) for own in titles] == [[3], [2, 1]]
    (own,) = compare_figure(compared(), "figure-7", width_mm=178, style={"font.size": 7.0})
    assert {text.get_size() for text in of_horizontal_type(own) if text.get_text() == "generated voltage U [kV]"} == {
        7.0
    }


@pytest.mark.slow
def test_a_chart_in_a_column_refers_to_no_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its points have no numbers, and what is stable in narrow bands stands in the caption."""
    whole = one_to_one()
    # On the edge of the region, as where another curve ends on it; charts that have such points take a minute.
    locus = next(locus for locus in whole.loci if locus.event is Event.PERIOD_DOUBLING)
    motion, inputs = locus.path.motion(locus.x[1]), tuple(locus.inputs[1])
    meeting = Meeting((Event.PERIOD_DOUBLING, Event.GRAZING), motion, inputs, (0.0, 0.0))
    narrow = NarrowBand("BBT", 0, 1e-5, 1e-5, settable=True)
    monkeypatch.setattr("vireport.map.chart.chart.narrow_bands", lambda *_: (narrow,))
    drawn = replace(whole, meetings=(meeting,))
    page = chart_picture(drawn)
    with drawn_for(Sheet.of(86)):
        column = chart_picture(drawn)
    note = "Stable as well in bands too narrow to be seen"
    for picture, headed in ((page, True), (column, False)):
        texts = " ".join(texts_of(picture.figure))
        assert ("point of the table" in texts) is headed
        assert "design point" in texts
        assert ("BBT" in picture.caption) is not headed
        assert (note in picture.caption) is not headed
    assert_readable(column.figure)
    assert column.figure.get_figwidth() * 25.4 == pytest.approx(86)


@pytest.mark.slow
@pytest.mark.usefixtures("short_front")
@pytest.mark.parametrize(
    ("command", "figure"),
    [
        (["compare", "inclined.yaml", "--vary", "inclination_deg=0,45"], "figure-variants"),
        (["optimise", "best-design.yaml", "--set", f"design={SHORTEST}", "--set", f"requirements={WITHOUT}"], "front"),
    ],
)
def test_other_commands_draw_figures_of_a_width(command: list[str], figure: str, tmp_path, capsys) -> None:
    name, scenario, *options = command
    asked = ["-o", str(tmp_path), "--figure-width", "86mm", "--format", "svg,figure-pdf", "-q"]
    assert main([name, str(ROOT / "examples" / scenario), *options, *asked]) == 0
    width = float(re.search(r'width="([\d.]+)pt"', (tmp_path / f"{figure}.svg").read_text())[1])
    assert width / 72 * 25.4 == pytest.approx(86, abs=0.01)
    (page,) = PdfReader(tmp_path / f"{figure}.pdf").pages
    assert float(page.mediabox.width) / 72 * 25.4 == pytest.approx(86, abs=0.01)
    assert not (tmp_path / "report.html").exists()
    for refused in (["--json", "--figure-width", "86mm"], ["--figure-width", "86mm"]):
        assert main([name, str(ROOT / "examples" / scenario), *options, *refused]) == 2


@pytest.mark.parametrize("width", [59.9, 250.1, float("nan")])
def test_a_width_that_no_paper_has_is_refused(width: float) -> None:
    with pytest.raises(UsageError, match="60 to 250 mm"):
        figure_2(study_of("horizontal"), width_mm=width)


@pytest.mark.slow
def test_the_command_line_draws_them(tmp_path, capsys) -> None:
    scenario = str(ROOT / "examples" / "inclined.yaml")
    asked = ["run", scenario, "-o", str(tmp_path), "--figure-width", "8.6cm", "--format", "svg,figure-pdf", "-q"]
    assert main(asked) == 0
    assert {path.name for path in tmp_path.iterdir()} >= {"figure-2.svg", "figure-2.pdf", "figure-7.pdf"}
    width = float(re.search(r'width="([\d.]+)pt"', (tmp_path / "figure-2.svg").read_text())[1])
    assert width / 72 * 25.4 == pytest.approx(86, abs=0.01)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--figure-width", "wide", "--format", "svg"), "'wide' is no width"),
        (("--figure-width", "-86mm", "--format", "svg"), "'-86mm' is no width"),
        (("--figure-width", "86"), "figures of a report are as wide as its page"),
        (("--figure-width", "86", "--format", "svg,pdf"), "figures of a report are as wide as its page"),
        (("--figure-width", "86", "--format", "json"), "figures of a report are as wide as its page"),
        (("--figure-width", "5mm", "--format", "png"), "60 to 250 mm wide"),
        (("--figure-width", "86", "--json"), "--json prints the results and writes no file: leave out --figure-width"),
    ],
)
def test_what_is_no_width_is_told_before_work_begins(options, message, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(ROOT / "examples" / "inclined.yaml"), *options]) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
