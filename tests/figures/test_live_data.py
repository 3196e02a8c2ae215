"""The figures within a page: what the script knows is what is drawn and what the results say."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from hashlib import sha256

import pytest
from conftest import first
from figure_cases import ROOT, curves, study_of, vertices

from vireport.figures import (
    Picture,
    in_page,
    live_data,
    pictures,
)

TEMPLATES = ROOT / "templates"
PAGE = "<html><head><meta content=\"default-src 'none'; img-src data:\"></head><body><p>&lt;</p>{}<p></p></body></html>"


def image(picture: Picture) -> str:
    return f'<img src="data:image/svg+xml;base64,{b64encode(picture.svg).decode()}" alt="x" width="3">'


@pytest.mark.parametrize("name", first(1, ["horizontal", "inclination"]))
def test_the_crosshair_is_where_the_motion_is_drawn(name: str) -> None:
    study = study_of(name)
    drawn = [picture for picture in pictures(study) if picture.name in ("figure-2", "figure-4")]
    data = json.loads(live_data(study, drawn))
    for picture, panels in zip(drawn, (3, 2), strict=True):
        height = picture.figure.get_figheight() * 72
        on_curves = []
        for axes in picture.figure.axes[:panels]:
            points = axes.transData.transform(sorted(vertices(curves(axes)))) * 72 / picture.figure.dpi
            on_curves.append({(round(x, 1), round(height - y, 1)) for x, y in points.tolist()})
        for branch in data["branches"]:
            across, *down = branch["places"][picture.name]
            assert len(across) == len(branch["columns"]["d"]) == len(branch["words"])
            for k, curve in enumerate(down):
                panel = on_curves[k // 2 if picture.name == "figure-2" else min(k, 1)]
                assert all(y is None or (x, y) in panel for x, y in zip(across, curve, strict=True))
    labels = {label for branch in data["branches"] for label in branch["labels"].values()}
    assert labels == {point.label for point in study.solution.critical_points}


def test_a_page_gets_its_figures_and_one_script_that_its_policy_allows() -> None:
    study = study_of("horizontal")
    drawn = pictures(study)
    page = in_page(PAGE.format("".join(map(image, drawn))), drawn, live_data(study, drawn), TEMPLATES)
    assert "<img" not in page
    assert page.count("<svg ") == len(drawn)
    inert, script = re.findall(r"<script[^>]*>(.*?)</script>", page, re.DOTALL)
    assert json.loads(inert)["r"] == 0.5
    digest = b64encode(sha256(script.encode()).digest()).decode()
    assert f"default-src 'none'; script-src 'sha256-{digest}'; img-src data:" in page
    assert len(page) < 600_000


def test_without_a_sweep_nothing_runs() -> None:
    drawn = pictures(study_of("empty"))
    assert live_data(study_of("empty"), drawn) == ""
    page = in_page(PAGE.format(image(drawn[0])), drawn, "", TEMPLATES)
    assert "<svg " in page
    assert "<script" not in page
    assert "script-src" not in page
