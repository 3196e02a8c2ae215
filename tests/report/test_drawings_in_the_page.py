"""The figures in an HTML page: all of what is drawn, as elements of it, and one script that its policy allows."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from hashlib import sha256

import pytest
from bs4 import BeautifulSoup
from pages import tidy

from vireport.figures import pictures
from vireport.report import Report, render_html
from vireport.study import Study, provenance_of, with_pages


def report_of(study: Study) -> Report:
    origin = with_pages(provenance_of(study.loaded, "vireport run test.yaml"), drawn=True)
    return Report(study, {picture.name: picture for picture in pictures(study)}, origin)


def elements(drawing: str) -> list[tuple[str, dict[str, str], str]]:
    """The elements of a drawing in their order: name, attributes, text of its own."""
    shown = []
    for element in BeautifulSoup(drawing, "html.parser").find_all(True):
        attributes = {name: tidy(str(value)) for name, value in element.attrs.items() if name != "xmlns"}
        shown.append((element.name, attributes, tidy("".join(element.find_all(string=True, recursive=False)))))
    return shown


@pytest.fixture(scope="module")
def drawn(study_of) -> tuple[Report, str]:
    """A report with figures along a sweep, and its page."""
    report = report_of(study_of("horizontal"))
    return report, render_html(report).decode()


def test_the_page_has_every_element_that_is_drawn_and_its_text(drawn) -> None:
    report, page = drawn
    assert "<img" not in page
    drawings: dict[str, str] = {}
    for drawing in re.findall("<svg .*?</svg>", page, re.DOTALL):
        name = re.search('data-figure="(.*?)"', drawing)[1]
        drawings[name] = drawings.get(name, "") + drawing
    assert drawings.keys() == report.pictures.keys()
    for name, picture in report.pictures.items():
        group, *inside = elements(picture.inline)
        assert group == ("g", {}, "")
        assert elements(drawings[name]) == inside
        assert [x[1]["class"] for x in inside if x[0] == "svg"] == [
            f"['figure', '{kind}']" for kind in ("wide", "narrow")
        ]


def test_no_two_things_of_a_page_have_the_same_identifier(drawn) -> None:
    _, page = drawn
    identifiers = re.findall(' id="([^"]*)"', page)
    assert len(set(identifiers)) == len(identifiers)
    assert set(re.findall(r'(?:href="|url\()#([^")]*)', page)) <= set(identifiers)


def test_the_policy_of_a_page_allows_the_script_that_is_in_it(drawn) -> None:
    _, page = drawn
    *_, (_, data), (attributes, script) = re.findall(r"<script([^>]*)>(.*?)</script>", page, re.DOTALL)
    assert attributes == ""
    assert json.loads(data)["swept"] == "s"
    digest = b64encode(sha256(script.encode()).digest()).decode()
    assert f"default-src 'none'; script-src 'sha256-{digest}'; img-src data:" in page
    assert len(page) < 720_000


def test_without_a_motion_nothing_runs(study_of) -> None:
    page = render_html(report_of(study_of("design-point", "inclination_deg=80", "device.length_m=0.05"))).decode()
    assert "<svg " in page
    assert re.findall(r"<script([^>]*)>", page) == [
        f' type="application/json" id="{name}-data"' for name in ("scenario", "results")
    ]
    assert "script-src" not in page
