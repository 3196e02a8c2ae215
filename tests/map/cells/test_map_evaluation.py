"""Which values each cell of a map has, and what is known of it: what a scenario at them says, without a NaN."""

from __future__ import annotations

import random
from importlib import import_module
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from map_texts import HELD, TEXT, all_cells, plan_of, sampled, undisturbed_result
from msgspec.structs import replace
from scipy.stats import qmc

from vireport import analyse, loads
from vireport.base.errors import NumericalError
from vireport.findings.outcomes.shock import SCAN, MotionsByStability
from vireport.findings.outcomes.withstood import least_of
from vireport.map.cells.cells import MapPlan, cell_values, map_plan
from vireport.map.cells.evaluation import evaluate
from vireport.map.cells.run import run_map
from vireport.motions.pointwise import find_motions
from vireport.physics.device import Device
from vireport.physics.groups import Groups
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import check_model, follow_impacts
from vireport.simulation.kernel import VELOCITY


def whole(plan: MapPlan) -> pa.Table:
    return evaluate(plan, np.arange(plan.cells))


@pytest.mark.slow
def test_results_do_not_depend_on_the_chunks() -> None:
    plan = plan_of(TEXT)
    together = whole(plan).to_pylist()
    assert [row for k in range(plan.chunks) for row in evaluate(plan, plan.numbers(k)).to_pylist()] == together
    assert evaluate(plan, np.array([400, 7])).to_pylist() == [together[400], together[7]]


@pytest.mark.slow
def test_every_cell_is_what_a_scenario_says() -> None:
    table = whole(plan_of(TEXT)).to_pylist()
    compared = 0
    for row in random.Random(1).sample(table, 8):
        text = HELD.replace("restitution", f"length_m: {row['length_m']!r}, restitution")
        study = analyse(loads(f"{text}inclination_deg: {row['inclination_deg']!r}\n"), ("json",))
        motions, volts = study.solution.design.motions, study.solution.design.voltages_by_motion
        assert row["motions"] == motions.admissible_mask.sum()
        assert row["stable"] == motions.stable_mask.sum()
        if not row["motions"]:
            assert row["stability"] is row["q"] is row["u_ave_v"] is None
            continue
        compared += 1
        same = np.flatnonzero(motions.admissible_mask & (np.abs(motions.q - row["q"]) < 1e-9))
        i = int(same[np.argmin(np.abs(motions.phi_bottom[same] - row["phi_bottom_rad"]))])
        assert row["stability"] == motions.words[i]
        assert bool(row["stable"]) == bool(motions.stable_mask[i])
        for name in ("velocity_bottom", "velocity_top", "trace", "wall_gap"):
            assert row[name] == pytest.approx(getattr(motions, name)[i], rel=1e-9, abs=1e-9)
        assert row["u_ave_v"] == pytest.approx(volts.average_v[i], rel=1e-9)
        margin = 1 + 0.5**4 - abs(motions.trace[i])
        assert row["multiplier_margin"] == pytest.approx(margin, rel=1e-9, abs=1e-9)
    assert compared > 3


@pytest.mark.slow
def test_stability_changes_where_the_paper_says() -> None:
    text = HELD + "map:\n  axes:\n    - {path: inclination_deg, values: [0, 45]}\n    - {path: device.length_m, "
    d = np.array([0.18705, 0.18706, 0.4179, 0.4180])  # either side of B1: horizontal, and at 45 degrees
    values = ", ".join(repr(float(x)) for x in d * 3 / (4 * 0.1245 * 4))
    rows = whole(plan_of(f"{text}values: [{values}]}}\n")).to_pylist()
    assert [rows[k]["stability"] for k in (0, 1)] == ["unstable node", "stable node"]
    assert [rows[k]["stability"] for k in (6, 7)] == ["unstable node", "stable node"]
    assert rows[6]["period_doubling_margin"] < 0 < rows[7]["period_doubling_margin"]


def test_one_command_maps_six_parameters() -> None:
    axes = {
        "device.ball_mass_kg": [0.004, 0.005],
        "inclination_deg": [0, 45],
        "device.length_m": [0.5, 0.7],
        "excitation.amplitude_n": [3, 4],
        "excitation.frequency_hz": [1.9, 2.0],
        "device.restitution": [0, 0.5],
    }
    lines = "".join(f"    - {{path: {path}, values: {values}}}\n" for path, values in axes.items())
    table = whole(plan_of(f"{HELD}map:\n  axes:\n{lines}"))
    assert len(table) == 64
    frame = table.to_pandas()
    frame = frame[frame.motions > 0]
    assert 10 < len(frame) < 60
    # Eq. (5.5), each cell with its own mass and its own unit of velocity.
    speed = np.maximum(frame.velocity_bottom, -frame.velocity_top) * frame.amplitude_n / (0.249 * frame.frequency_hz)
    depth = (3.6 * frame.ball_mass_kg / (2 * 4.0847e5) * speed**2) ** (1 / 3.6)
    np.testing.assert_allclose(frame.deflection_m, depth, rtol=1e-12)


def test_simulation_of_a_cell_agrees_with_its_stability() -> None:
    pytest.importorskip("numba")
    text = HELD + "map:\n  simulate: {starts: 8, impacts: 400}\n  axes:\n    - {path: inclination_deg, values: [45]}\n"
    rows = whole(plan_of(text + "    - {path: device.length_m, values: [0.6, 0.6934]}\n")).to_pylist()
    assert [row["stable"] for row in rows] == [0, 1]
    assert rows[0]["basin_share"] == 0
    assert rows[0]["word"] != "BT"
    assert rows[1]["basin_share"] > 0.5
    assert rows[1]["word"] == "BT"


FREE = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 0.75, capsule: free}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 45
map:
  axes:
    - {path: device.ball_mass_kg, values: [0.001, 0.0041, 0.03]}
    - {path: excitation.amplitude_n, values: [2.5, 3.0]}
"""


@pytest.mark.slow
def test_the_ball_weighs_on_a_free_capsule() -> None:
    """Its mass is in gbar, so that the heaviest one has no stable motion, and in the energy that deflects membranes."""
    for row in whole(plan_of(FREE)).to_pylist():
        m, force = row["ball_mass_kg"], row["amplitude_n"]
        assert row["gbar"] == pytest.approx((0.1245 + m) * 9.8 * np.sin(np.pi / 4) / force, rel=1e-14)
        given = {"device.ball_mass_kg": m, "excitation.amplitude_n": force, "device.capsule": "free"}
        study = analyse(loads(PRESCRIBED, overrides=[f"{key}={value}" for key, value in given.items()]), ())
        design = study.solution.design
        assert row["stable"] == np.count_nonzero(design.motions.stable_mask)
        if row["stable"]:
            assert row["u_ave_v"] == pytest.approx(design.voltages_by_motion.average_v[0], rel=1e-12)
    kinds = {row["ball_mass_kg"]: row["stable"] for row in whole(plan_of(FREE)).to_pylist() if row["amplitude_n"] == 3}
    assert kinds == {0.001: 1, 0.0041: 1, 0.03: 0}


PRESCRIBED = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5, length_m: 0.75}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 45
"""

SHARED = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.5}
excitation: {amplitude_n: 2.0, frequency_hz: 2.0}
map:
  simulate: {starts: 32, impacts: 300}
  axes:
    - {path: inclination_deg, values: [55.0]}
    - {path: device.length_m, from: 0.829, to: 0.82901, count: 32}
"""
"""Cells as good as equal, where some starts reach the 1:1 motion and more reach others."""


def test_share_of_starts_is_that_of_the_states_in_flight() -> None:
    """Against 2,000 states drawn here, each followed until it is beside the motion of the cells or is not."""
    pytest.importorskip("numba")
    plan = plan_of(SHARED)
    rows = whole(plan).to_pylist()
    d, gbar, velocity = (rows[0][name] for name in ("d", "gbar", "velocity_bottom"))
    rng, count = np.random.default_rng(2), 2000
    fastest = 1.5 * max(velocity, -rows[0]["velocity_top"], 2 / (np.pi * 0.5))
    states = np.zeros((count, 4))
    for column, limits in ((1, (-d / 2, d / 2)), (2, (-fastest, fastest)), (3, (0, 2 * np.pi))):
        states[:, column] = rng.uniform(*limits, count)
    last = follow_impacts(np.tile(check_model(Groups(d, gbar, 0.5)), (count, 1)), states, 400, keep=2)[0]
    reached = (np.abs(last[:, -2:, VELOCITY] - velocity) < 1e-6).any(axis=1).mean()
    shares = np.array([row["basin_share"] for row in rows])
    error = np.sqrt(reached * (1 - reached) * (1 / shares.size / 32 + 1 / count))
    assert 0.1 < reached < 0.4
    assert abs(shares.mean() - reached) < 3 * error
    assert shares.std() == pytest.approx(np.sqrt(reached * (1 - reached) / 32), rel=0.3)
    assert [row["basin_share"] for row in evaluate(plan, np.array([9, 3])).to_pylist()] == [shares[9], shares[3]]


def test_result_is_read_by_pandas_without_a_nan(tmp_path: Path) -> None:
    import pandas

    path = tmp_path / "map.parquet"
    path.write_bytes(undisturbed_result())
    frame = pandas.read_parquet(path)
    assert len(frame) == 500
    assert set(frame.stability.dropna()) <= {"stable node", "stable focus", "unstable node"}
    schema = pq.read_schema(path)
    assert schema.field("length_m").metadata == {b"unit": b"m"}
    assert schema.metadata[b"map"].decode() == TEXT
    for column in pq.read_table(path).columns:
        if column.type == "double":
            assert np.isfinite(column.drop_null().to_numpy()).all()


SWITCHED = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 0.75}
excitation: {frequency_hz: 2.0}
map:
  from_rest: true
  shock: true
  sampling: list
  axes:
    - {path: inclination_deg, values: [45, 45, 45, 45, 45]}
    - {path: excitation.amplitude_n, values: [0.8, 3.2, 3.6, 5.348, 6.5]}
"""
"""Too weak to leave the membrane, reached, not reached, next to the period doubling, and beyond it."""


@pytest.mark.slow
def test_outcome_from_rest_and_least_shock_of_a_cell_are_those_of_a_run() -> None:
    pytest.importorskip("numba")
    plan = plan_of(SWITCHED)
    rows = whole(plan).to_pylist()
    assert [row["from_rest"] for row in rows] == [
        *("at_rest", "reaches_1_1", "rest_cycle", "reaches_1_1", "other_motion"),
    ]
    assert [evaluate(plan, np.array([k])).to_pylist()[0] for k in range(5)] == rows
    for row in rows[1:3]:
        text = SWITCHED.partition("map:")[0].replace("{frequency", f"{{amplitude_n: {row['amplitude_n']}, frequency")
        found = analyse(loads(text + "inclination_deg: 45\ndisturbances: {}\n"), ("json",)).to_dict()["disturbances"]
        start, shock = found["from_rest"], found["shock"]
        assert (row["from_rest_word"], row["from_rest_periods"]) == (start["word"], start["periods"])
        assert row["settles_after_periods"] == start["settles_after_periods"]
        assert row["jump_searched_to_m_s"] == pytest.approx(shock["searched_to_m_s"], rel=1e-9)
        assert row["least_jump_m_s"] == (
            None if shock["least_jump_m_s"] is None else pytest.approx(shock["least_jump_m_s"], rel=1e-9)
        )
    assert rows[2]["least_jump_m_s"] == pytest.approx(0.1693971999264 * 3.6 / (2 * 0.1245 * 2), rel=1e-9)
    assert rows[3]["stable"] == 1  # so near the period doubling that no return is told
    for row in (rows[0], rows[3], rows[4]):
        assert row["least_jump_m_s"] is row["jump_searched_to_m_s"] is None


def test_without_numba_such_a_map_is_refused_before_it_begins(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setattr(import_module("vireport.map.cells.run"), "find_spec", lambda name: name != "numba" or None)
    (tmp_path / "map.yaml").write_text(SWITCHED, encoding="utf-8")
    with pytest.raises(NumericalError, match=r"map\.from_rest, map\.shock and map\.escape need numba: pip install"):
        run_map(str(tmp_path / "map.yaml"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_few_tries_find_the_least_shock_that_many_find() -> None:
    """Of devices in which some shock leads out; none is smaller than what many tries find, but for rounding."""
    pytest.importorskip("numba")
    rng, compared, exact = np.random.default_rng(8), 0, 0
    while compared < 8:
        force, length, angle = (float(rng.uniform(*ends)) for ends in ((3.3, 4.4), (0.6, 0.9), (35, 50)))
        device = Device(0.1245, 0.5, 9.8, length, force, 2.0, angle).groups(Parameter.LENGTH, length).as_floats()
        groups = device.map_numbers(lambda group: np.array([group]))
        motions = find_motions(groups, 1)
        rows = motions.stable(groups.restitution), motions.admissible & ~motions.stable(groups.restitution)
        stable, unstable = ([motions.motion(int(row), 1) for row in np.flatnonzero(which)] for which in rows)
        if not stable:
            continue
        few = least_of(device, MotionsByStability(stable, unstable), effort=SCAN)
        if few.jump is not None:
            many = least_of(device, MotionsByStability(stable, unstable))
            compared += 1
            assert many.jump * (1 - 1e-9) < few.jump < many.jump * 1.05
            exact += few.jump < many.jump * (1 + 1e-9)
    assert exact >= 6


BOX = np.array([[0.0, 0.2], [90.0, 0.9]])


def unit_points(plan) -> np.ndarray:
    """Points of the unit cube that the cells are."""
    return (np.column_stack(all_cells(plan)) - BOX[0]) / (BOX[1] - BOX[0])


def test_restitution_of_one_is_outside_the_theory() -> None:
    with pytest.raises(NumericalError, match="restitution"):
        plan_of(TEXT.replace("restitution: 0.5", "restitution: 1"))


def test_grid_has_every_combination_and_exact_ends() -> None:
    angle, length = all_cells(plan_of(TEXT))
    assert len(angle) == 500
    assert len(set(zip(angle, length, strict=True))) == 500
    assert (angle[0], angle[-1], length[0], length[-1]) == (0.0, 90.0, 0.2, 0.9)
    assert (length[:25] == length[25:50]).all()  # the last axis varies fastest


@pytest.mark.parametrize("sampling", ["grid", "sobol", "latin_hypercube"])
def test_cells_do_not_depend_on_the_chunks(sampling: str) -> None:
    plan = plan_of(TEXT if sampling == "grid" else sampled(sampling, 256))
    for size in (1000, 60, 7):
        for a, b in zip(all_cells(plan), all_cells(replace(plan, chunk_cells=size)), strict=True):
            assert np.array_equal(a, b)


@pytest.mark.parametrize(("sampling", "drawn"), [("sobol", qmc.Sobol), ("latin_hypercube", qmc.LatinHypercube)])
def test_points_are_those_of_scipy_in_any_order(sampling: str, drawn: type) -> None:
    plan = plan_of(sampled(sampling, 512, seed=3))
    low, high = BOX
    expected = low + (high - low) * drawn(2, rng=np.random.default_rng(3)).random(512)
    assert np.array_equal(np.column_stack(all_cells(plan)), expected)
    for numbers in (np.array([511, 3, 4, 5, 100]), np.array([0]), np.arange(511, 400, -1)):
        assert np.array_equal(np.column_stack(cell_values(plan, numbers)), expected[numbers])


@pytest.mark.parametrize(("sampling", "samples", "bins"), [("sobol", 256, 64), ("latin_hypercube", 1000, 1000)])
def test_samples_fill_their_box_evenly(sampling: str, samples: int, bins: int) -> None:
    for column in unit_points(plan_of(sampled(sampling, samples))).T:
        counts = np.histogram(column, bins=bins, range=(0, 1))[0]
        assert counts.min() == counts.max()


@pytest.mark.parametrize("samples", [1, 17, 4097])
def test_a_latin_hypercube_has_one_point_in_each_stratum(samples: int) -> None:
    for column in unit_points(plan_of(sampled("latin_hypercube", samples))).T:
        assert sorted(np.floor(column * samples)) == list(range(samples))


def test_another_seed_gives_other_points() -> None:
    for sampling in ("sobol", "latin_hypercube"):
        first, other = (unit_points(plan_of(sampled(sampling, 64, seed))) for seed in (0, 1))
        assert not np.isclose(first, other).any()


def test_the_example_is_a_map(example) -> None:
    from vireport.scenario.loading import load_map

    assert map_plan(load_map(example("maps/map"))).shape == (60, 80)
