"""results.json and branches.csv: the names and the exactness that scripts rely on."""

from __future__ import annotations

import csv
import io
import json
import math

import numpy as np
import pytest
from exact import error_of, exact_row
from mpmath import mpf

from vireport.study.checks import reference
from vireport.study.checks.forty_digits import critical_motion
from vireport.study.provenance import provenance_of
from vireport.study.results import branches_csv
from vireport.study.study import results_json

ARRAYS = [
    *("sweep_value", "d", "gbar", "q", "phi_bottom_rad", "phi_top_rad", "velocity_bottom", "velocity_top"),
    *("trace", "determinant", "discriminant", "stability", "admissible", "wall_gap"),
]
ENERGY = ["u_bottom_v", "u_top_v", "u_ave_v"]
CRITICAL = [
    *("label", "kind", "family", "sweep_value", "d", "gbar"),
    *("q", "phi_bottom_rad", "velocity_bottom", "error_bound"),
]


@pytest.fixture(params=["horizontal", "inclined", "inclined-forcing"])
def study(request, study_of):
    return study_of(request.param)


def parse(study) -> dict:
    def refuse(name: str):
        raise AssertionError(f"{name} is not JSON")

    return json.loads(results_json(study, provenance_of(study.loaded, "test")), parse_constant=refuse)


def test_names_of_the_contract(study) -> None:
    results = parse(study)
    assert {
        "schema_version",
        "scenario",
        "branches",
        "critical_points",
        "design_point",
        "stable_range",
        "provenance",
    } <= set(results)
    for branch in results["branches"]:
        assert branch["family"] in ("symmetric", "asymmetric")
        assert len({len(branch[key]) for key in ARRAYS + ENERGY}) == 1
        assert set(branch["stability"]) <= {"stable node", "stable focus", "unstable node"}
    for point in results["critical_points"]:
        assert set(CRITICAL) <= set(point)
    assert {"version", "scenario_sha256", "python", "libraries", "command"} <= set(results["provenance"])


def test_numbers_read_back_exactly(study) -> None:
    for branch, row in zip(study.solution.branches, parse(study)["branches"], strict=True):
        np.testing.assert_array_equal(row["sweep_value"], branch.motions.sweep_value)
        np.testing.assert_array_equal(row["velocity_top"], branch.motions.velocity_top)
        np.testing.assert_array_equal(row["trace"], branch.motions.trace)


NAMES = {
    **{name: name for name in ARRAYS},
    "phi_bottom_rad": "phi_bottom",
    "phi_top_rad": "phi_top",
    "u_bottom_v": "bottom_v",
    "u_top_v": "top_v",
    "u_ave_v": "average_v",
    "deflection_m": "deflection_m",
}
"""Columns of results.json, and the names of the exact numbers."""


def test_numbers_are_within_the_bounds_written_beside_them(study) -> None:
    """By their names, against 40 digits."""
    errors: dict[str, float] = {}
    for branch, data in zip(study.solution.branches, parse(study)["branches"], strict=True):
        for row in np.linspace(0, len(branch.motions) - 1, 4).astype(int):
            with reference.precise():
                exact = exact_row(study.solution.sweep, branch.motions, row, study.solution.membrane)
                for column, bounds in data["error_bounds"].items():
                    if column == "null_means" or bounds[row] is None:
                        continue
                    errors[column] = error_of(data[column][row], exact[NAMES[column]], column)
                    assert errors[column] <= bounds[row], (branch.number, row, column)
    assert set(errors) == set(NAMES) - {"stability", "admissible"}


def test_stable_ranges_and_margins_are_within_the_bounds_written_beside_them(study) -> None:
    results, sweep = parse(study), study.solution.sweep
    with reference.precise():
        exact = {
            point.label: critical_motion(point, sweep.device, sweep.parameter)[3]
            for point in study.solution.critical_points
        }
        for part in results["stable_range"]:
            for end in ("from", "to"):
                reason = part[f"{end}_reason"]
                value = exact[reason] if reason in exact else mpf(part[end])
                assert reason in exact or part[end] in (sweep.start, sweep.end)
                assert abs(mpf(part[end]) - value) <= part[f"{end}_error_bound"]
        swept = results["design_point"]["parameter"]
        margins = [
            margin for margin in results["design_point"]["margins"] if margin["parameter"] == swept and margin["label"]
        ]
        assert len(margins) >= len(exact)
        for margin in margins:
            away = mpf(margin["distance"]) - (exact[margin["label"]] - mpf(results["design_point"]["value"]))
            assert 0 < abs(away) <= margin["error_bound"]


def test_motions_that_graze_are_undecided(study) -> None:
    for branch in parse(study)["branches"]:
        bounds = branch["error_bounds"]["wall_gap"]
        for gap, bound, is_open in zip(branch["wall_gap"], bounds, branch["admissible_undecided"], strict=True):
            assert bound is None or is_open == (abs(gap) <= bound)


def test_csv_holds_the_same_numbers(study) -> None:
    rows = list(csv.DictReader(io.StringIO(branches_csv(study.solution).decode())))
    results = parse(study)
    assert len(rows) == sum(len(branch["d"]) for branch in results["branches"])
    flat = [value for branch in results["branches"] for value in branch["q"]]
    assert [float(row["q"]) for row in rows] == flat
    assert {row["admissible"] for row in rows} <= {"true", "false"}


def test_stable_range_holds_only_admissible_stable_motions(study) -> None:
    results = parse(study)
    assert results["stable_range"]
    for part in results["stable_range"]:
        assert part["from"] < part["to"]
    values = [
        value
        for branch in results["branches"]
        for value, word, fine in zip(branch["sweep_value"], branch["stability"], branch["admissible"], strict=True)
        if fine and word.startswith("stable")
    ]
    assert all(any(p["from"] <= v <= p["to"] for p in results["stable_range"]) for v in values)


def test_sweep_ends_are_hit_exactly(study) -> None:
    sweep = study.scenario.sweep
    ends = {float(branch.motions.sweep_value[row]) for branch in study.solution.branches for row in (0, -1)}
    assert {sweep.from_, sweep.to} <= ends


def test_groups_belong_to_the_swept_value(study) -> None:
    sweep = study.solution.sweep
    for branch in study.solution.branches:
        m = branch.motions
        d, gbar, *_ = sweep.device.groups(sweep.parameter, m.sweep_value)
        np.testing.assert_allclose(m.d, d, rtol=1e-13)
        np.testing.assert_allclose(m.gbar, gbar * np.ones(len(m)), rtol=1e-12, atol=1e-16)


def test_every_value_left_out_has_its_reason(study_of) -> None:
    results = parse(study_of("design-point"))
    assert results["branches"] == []
    assert results["stable_range"] == []
    assert {entry["step"] for entry in results["left_out"]} >= {"branches", "figure-2", "critical"}
    assert all(entry["why"] for entry in results["left_out"])
    assert results["design_point"]["stable_range"]


def test_margins_point_at_the_critical_points(study) -> None:
    results = parse(study)
    design = results["design_point"]
    by_label = {point["label"]: point for point in results["critical_points"]}
    swept = [margin for margin in design["margins"] if margin["parameter"] == design["parameter"]]
    assert set(by_label) <= {margin["label"] for margin in swept}
    for margin in swept:
        if margin["label"]:
            value = by_label[margin["label"]]["sweep_value"]
            assert margin["distance"] == pytest.approx(value - design["value"])
        assert math.isclose(margin["relative"], margin["distance"] / design["value"])
        assert math.isclose(margin["percent"], 100 * margin["relative"])
    for part in results["stable_range"]:
        for end, side in (("from", -1), ("to", 1)):
            beyond = part[f"{end}_beyond_sweep"]
            assert beyond is None or side * (beyond["sweep_value"] - part[end]) > 0
            assert beyond is None or part[f"{end}_reason"] == "end of the sweep"


def test_the_shaker_moves_by_the_double_integral_of_its_acceleration(study) -> None:
    shaker, omega = parse(study)["shaker"], 4 * np.pi
    acceleration = shaker["acceleration_amplitude_m_s2"]
    assert acceleration == pytest.approx(shaker["force_amplitude_n"] / 0.1245)
    assert acceleration == pytest.approx(9.80665 * shaker["acceleration_amplitude_g"])
    assert acceleration == pytest.approx(omega * shaker["velocity_amplitude_m_s"])
    assert acceleration == pytest.approx(omega**2 * shaker["stroke_m"] / 2)


def test_a_study_is_made_of_a_path_and_shown_on_a_line(example) -> None:
    from vireport import analyse

    shown = repr(analyse(example("design-point"), ("json",)))
    assert shown.startswith(f"<Study of {example('design-point')}: Stable, margin small>")
    assert "\n" not in shown
    assert len(shown) < 400


def test_a_notebook_shows_the_verdict_and_every_critical_point(study, study_of) -> None:
    text = study._repr_html_()
    assert study.opening.worded().sentence in text
    tiles = 1 + len(study.opening.tiles)
    assert text.count("<tr>") == tiles + 1 + len(study.solution.critical_points)
    assert all(f"<td>{point.label}</td>" in text for point in study.solution.critical_points)
    assert study_of("design-point")._repr_html_().count("<tr>") == 5
