"""The crosshair of a page: what its script knows is what is drawn and what the results say."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import EXAMPLES, first
from figure_cases import curves, study_of, vertices
from scipy.integrate import solve_ivp

from vireport.figures import live_data, pictures
from vireport.scenario import load
from vireport.study import Task, analyse


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


MADE: dict[str, tuple[str, dict]] = {
    "a sweep": ("inclined-forcing", {}),
    "a sine": ("design-point", {}),
    "harmonics": (
        "design-point",
        {"excitation.harmonics": [{"order": o, "percent": 3, "phase_deg": 50 * o} for o in (2, 3)]},
    ),
    "friction, two restitutions, every second period": (
        "design-point",
        {
            "device.friction": 0.03,
            "device.restitution": None,
            "device.restitution_bottom": 0.52,
            "device.restitution_top": 0.47,
        },
    ),
    "a law": ("design-point", {"device.restitution_exponent": -0.1, "device.restitution_speed_m_s": 2.0}),
}


@pytest.mark.parametrize("name", MADE)
def test_the_ball_flies_as_the_page_moves_it(name: str) -> None:
    """From the impact on either membrane by the equation of motion to the other, where it arrives as the page says."""
    example, over = MADE[name]
    study = analyse(load(EXAMPLES / f"{example}.yaml", over | {"simulation": None, "accuracy": None}), (Task.HTML,))
    data = json.loads(live_data(study, pictures(study)))
    flights = 0
    for branch in data["branches"]:
        known = branch["columns"]
        for row in {0, len(known["d"]) // 2, len(known["d"]) - 1}:
            q, d = known["q"][row], known["d"][row]
            for start, end, wall, share in (("bottom", "top", 1, q), ("top", "bottom", -1, 1 - q)):
                gravity, phase = known[f"gravity_{start}"][row], known[f"phi_{start}_rad"][row]

                def fall(t: float, state: list[float], gravity: float = gravity, phase: float = phase) -> list[float]:
                    x = np.pi * t + phase
                    return [state[1], gravity + sum(c * np.cos(k * x) + b * np.sin(k * x) for k, c, b in data["force"])]

                begin, long = [wall * d / 2, known[f"after_{start}"][row]], 2 * data["n"] * share
                z, speed = solve_ivp(fall, (0, long), begin, rtol=1e-9, atol=1e-11).y[:, -1]
                assert z == pytest.approx(-wall * d / 2, abs=2e-4)
                assert speed == pytest.approx(known[f"velocity_{end}"][row], abs=2e-4)
                flights += 1
    assert flights >= 2 * len(data["branches"])


@pytest.mark.parametrize("name", first(1, ["horizontal", "inclined-forcing"]))
def test_it_begins_at_the_design_point(name: str) -> None:
    study = study_of(name)
    data, design = json.loads(live_data(study, pictures(study))), study.solution.design
    branch, row = data["start"]
    shown = data["branches"][branch]
    assert shown["words"][row] == design.motions.words[0]
    values = np.array(shown["columns"]["sweep_value"])
    assert row == np.argmin(abs(values - design.value))
    assert shown["columns"]["q"][row] == pytest.approx(design.motions.q[0], abs=1e-3)
    assert shown["outside"] == list(range(len(values)))  # the paper's own voltages are outside the membrane's shape


def test_where_there_is_no_motion_there_is_nothing_to_read() -> None:
    assert live_data(study_of("empty"), pictures(study_of("empty"))) == ""
