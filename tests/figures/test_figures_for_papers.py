"""Figures as wide as the column or the page of a paper: all of them readable, in fonts that a journal takes."""

from __future__ import annotations

import re
from functools import cache
from io import BytesIO
from itertools import product

import pytest
from conftest import first
from figure_cases import ROOT, assert_readable, boxes_of, study_of, texts_of
from matplotlib.text import Text
from pypdf import PdfReader

from vireport import figure_2, figure_4, figure_7
from vireport.base import UsageError
from vireport.cli import main
from vireport.figures import pictures
from vireport.scenario import load
from vireport.study import Study, analyse

WIDTHS = 86, 178
"""A column and a page of a paper [mm]."""

LEGIBLE = 6.0
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


@pytest.mark.slow
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", SCENARIOS)
def test_every_figure_is_readable_at_the_width_of_a_paper(name: str, width: int) -> None:
    drawn = pictures(study(name), width_mm=width)
    assert len(drawn) >= 3
    for picture in drawn:
        assert picture.figure.get_figwidth() * 25.4 == pytest.approx(width)
        assert_readable(picture.figure)
        assert min(text.get_size() for text in of_horizontal_type(picture.figure)) >= LEGIBLE


@pytest.mark.parametrize(("name", "width"), first(1, product(["horizontal", "inclined-forcing"], WIDTHS), True))
def test_figures_of_a_sweep_are_readable_and_leave_what_is_held_to_the_caption(name: str, width: int) -> None:
    for draw in (figure_2, figure_4, figure_7):
        figure = draw(study_of(name), width_mm=width)
        assert_readable(figure)
        held = [text for text in texts_of(figure) if text.startswith(("F = ", "s = ", "β = "))]
        assert held == []
        assert [text for text in texts_of(draw(study_of(name))) if text.startswith(("F = ", "s = "))] != []


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
    first, second = (
        next(p for p in pictures(study_of("horizontal"), width_mm=86) if p.name == "figure-2") for _ in range(2)
    )
    assert first.pdf == second.pdf
    png = first.png
    assert (first.png, first.width) == (png, second.width)
    (page,) = PdfReader(BytesIO(first.pdf)).pages
    assert float(page.mediabox.width) / 72 * 25.4 == pytest.approx(86, abs=0.01)
    assert "/Type3" not in first.pdf.decode("latin-1")
    assert re.search(r"/FontFile2", first.pdf.decode("latin-1"))
    assert "impact velocity" in page.extract_text()
    assert "CreationDate" not in first.pdf.decode("latin-1")


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
        (("--figure-width", "86", "--json"), "draws no figure"),
    ],
)
def test_what_is_no_width_is_told_before_work_begins(options, message, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(ROOT / "examples" / "inclined.yaml"), *options]) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
