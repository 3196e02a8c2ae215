"""The crosshair of a page: what its script knows is what is drawn and what the results say."""

from __future__ import annotations

import json

import pytest
from conftest import first
from figure_cases import curves, study_of, vertices

from vireport.figures import live_data, pictures


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


def test_without_a_sweep_there_is_nothing_to_read() -> None:
    assert live_data(study_of("empty"), pictures(study_of("empty"))) == ""
