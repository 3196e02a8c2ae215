"""A number of the model is spelled alike wherever it stands: each critical point and each end of a margin."""

from __future__ import annotations

import re
from collections.abc import Iterator
from decimal import Decimal
from io import BytesIO

import pytest
from conftest import EXAMPLES
from msgspec.structs import replace
from pages import Page, render_html, render_pdf
from pypdf import PdfReader

from vireport.bench.answers import study_answer
from vireport.comparison.comparison import compare
from vireport.comparison.outputs import comparison_provenance, terminal_summary
from vireport.comparison.pages import ComparisonReport
from vireport.figures.pictures import pictures
from vireport.map.chart.outputs import markdown as chart_markdown
from vireport.map.chart.outputs import text as chart_text
from vireport.map.chart.over import chart_of
from vireport.report.ci_formats import github, junit
from vireport.report.context import Report
from vireport.report.markdown import fill_markdown
from vireport.scenario.loading import load
from vireport.study.provenance import provenance_of
from vireport.study.study import Study, analyse
from vireport.text.formatting import rounded_text

REQUIRED = ["requirements.margin_any_percent=1", "requirements.margin_period_doubling_percent=2"]
NUMBER = re.compile(r"(?<![\d.])\d+\.\d+(?![\d.])")


def known(study: Study) -> dict[str, float]:
    """Where motions change: critical points, and the ends of the design point's margins in each input."""
    solution = study.solution
    points = {f"{point.label} in {solution.parameter}": point.sweep_value for point in solution.critical_points}
    return points | {f"{end.name} in {end.parameter}": end.sweep_value for end in solution.design.margins}


def spellings(text: str, value: float) -> set[str]:
    """The numbers of a text that are this one to three digits and more."""
    found = set()
    for number in NUMBER.findall(text):
        last, digits = Decimal(number).as_tuple().exponent, len(number.replace(".", "").lstrip("0"))
        if digits >= 3 and abs(Decimal(number) - Decimal(value)) <= Decimal(1).scaleb(last) * Decimal("0.50001"):
            found.add(number)
    return found


def outputs_of_a_run(study: Study) -> Iterator[tuple[str, str]]:
    drawn = {picture.name: picture for picture in pictures(study, None)}
    report = Report(study, drawn, provenance_of(study.loaded, "vireport run x.yaml"))
    page = Page(render_html(report))
    yield "HTML", page.text
    yield "captions", " ".join(f"{picture.caption} {picture.alt}" for picture in drawn.values())
    yield "Markdown", fill_markdown(replace(report, template="summary.md.j2"))
    yield "JUnit", junit(study).decode()
    yield "annotations", github(study)
    yield "terminal", " ".join(study.opening.worded().text)
    yield "notebook", study._repr_html_()
    yield "PDF", " ".join(sheet.extract_text() for sheet in PdfReader(BytesIO(render_pdf(report))).pages)


def outputs_of_others(study: Study) -> Iterator[tuple[str, str]]:
    both = compare([study, analyse(load(EXAMPLES / "stiff-membrane.yaml"), ("json",))])
    yield "comparison on a terminal", terminal_summary(both, tables=True)
    report = ComparisonReport(both, {}, comparison_provenance(both, "vireport compare a.yaml b.yaml"))
    yield "comparison", Page(render_html(report)).text
    few = ["motions={impacts: 2, periods: 1}"]
    chart = chart_of(load(EXAMPLES / "inclined.yaml", few), "length_m=0.6..0.75,frequency_hz=1.8..2.2", lambda _: None)
    yield "chart on a terminal", chart_text(chart, tables=True)
    yield "chart in Markdown", chart_markdown(chart)


@pytest.mark.slow
def test_a_critical_point_has_one_spelling_in_all_outputs() -> None:
    study = analyse(load(EXAMPLES / "inclined.yaml", REQUIRED))
    outputs = dict([*outputs_of_a_run(study), *outputs_of_others(study)])
    expected = {name: rounded_text(value, study.verdict.exactness) for name, value in known(study).items()}
    assert expected["B1 in length_m"] == "0.629"
    wrong = [
        f"{name} is {others} in {where}"
        for where, text in outputs.items()
        for name, value in known(study).items()
        if (others := spellings(text, value) - {expected[name]})
    ]
    assert not wrong, "\n".join(wrong)
    for where in ("HTML", "PDF", "Markdown", "terminal", "captions", "comparison", "chart on a terminal", "notebook"):
        assert "0.629" in outputs[where], where
    assert study_answer(study)["digits"] == 3


def test_a_run_has_one_spelling_of_its_ends_where_it_opens() -> None:
    study = analyse(load(EXAMPLES / "inclined.yaml"), ("json",))
    told = " ".join(
        [*study.opening.worded().text, study._repr_html_(), repr(study.solution), repr(study.solution.design)]
    )
    for name, value in known(study).items():
        assert spellings(told, value) <= {rounded_text(value, study.verdict.exactness)}, name
