"""Simulation and solution side by side: they agree where they must, and disagreement is seen."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
from conftest import first, solved
from msgspec.structs import replace

from vireport import analyse, load, loads
from vireport.design.point import design_point
from vireport.figures.curves import _paired, _paired_voltages, simulated_points
from vireport.physics.groups import Groups
from vireport.simulation.attractors import Outcome, attractors, find_attractor
from vireport.simulation.events import BOTTOM, Impact
from vireport.simulation.starts import random_starts
from vireport.study.checks.crosscheck import crosscheck, difference, is_one_to_one, orbits_at
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.verdict import Status, verdict_of
from vireport.text.templates import Words

LIVELY = ["period_ratio=3", "device.restitution=0.9"]
"""Here starts of the horizontal example end on 1:1 motions of one and of three forcing periods."""


@pytest.fixture(scope="module")
def checked(example):
    return {
        name: analyse(loads(example(name).read_text(), overrides=["simulation.samples=41"]), ("json",))
        for name in ("horizontal", "inclined", "inclined-forcing", "design-point")
    }


@pytest.mark.parametrize("name", first(1, ["horizontal", "inclined", "inclined-forcing"]))
def test_agreement_on_the_papers_scenarios(checked, name: str) -> None:
    check = checked[name].crosscheck
    assert check.orbits > 20
    assert check.misses == ()
    assert check.velocity_difference < 1e-12
    assert check.phase_difference < 1e-12
    assert check.passed


def test_a_design_point_is_checked_too(checked) -> None:
    check = checked["design-point"].crosscheck
    assert check.orbits == 1
    assert check.passed


def test_orbits_at_are_those_of_the_design_points(checked) -> None:
    study = checked["horizontal"]
    values = np.array([0.3, 0.45, 0.6])
    for value, motions in zip(values, orbits_at(study.solution.diagram, values), strict=True):
        alone = design_point(replace(study.solution.device, length_m=float(value)), study.solution.diagram).motions
        np.testing.assert_allclose(np.sort(motions.velocity_bottom), np.sort(alone.velocity_bottom), rtol=1e-11)


def test_below_the_period_doubling_the_simulation_finds_the_doubled_motion(checked) -> None:
    check = checked["inclined-forcing"].crosscheck
    doubled = [
        attractor for value, row in zip(check.values, check.ends, strict=True) for attractor in row if value > 5.36
    ]
    assert {attractor.word for attractor in doubled} == {"BTBT"}
    assert {attractor.period for attractor in doubled} == {2}
    assert all(attractor.cycle.residual < 1e-12 for attractor in doubled)


def test_a_wrong_solution_is_found_out(checked) -> None:
    """The cross-check must be able to fail: orbits of another restitution are not those of the simulation."""
    study = checked["inclined"]
    asked = study.scenario.simulation
    wrong = replace(study.solution, device=replace(study.solution.device, restitution=0.52))
    check = crosscheck(wrong, asked)
    assert check.misses
    assert not check.passed
    opening = replace(study, crosscheck=check).opening.worded()
    assert opening.sentence.startswith("Not verified")
    assert "VR020" in {alert.code for alert in replace(study, crosscheck=check).alerts}


def test_difference_counts_phases_around_the_circle(checked) -> None:
    study = checked["inclined"]
    attractor = study.crosscheck.ends[-1][0]
    motions = orbits_at(study.solution.diagram, study.crosscheck.values[-1:])[0]
    row = int(np.nonzero(motions.stable_mask)[0][0])
    turned = replace(motions, phi_bottom=motions.phi_bottom + 2 * np.pi)
    assert difference(attractor, turned, row) == pytest.approx(difference(attractor, motions, row), abs=1e-14)


def test_difference_sees_both_impacts_and_half_a_turn(checked) -> None:
    study = checked["inclined"]
    attractor = study.crosscheck.ends[-1][0]
    motions = orbits_at(study.solution.diagram, study.crosscheck.values[-1:])[0]
    row = int(np.nonzero(motions.stable_mask)[0][0])
    for name, k, change in (
        ("velocity_bottom", 0, 1e-3),
        ("velocity_top", 0, 1e-3),
        ("phi_bottom", 1, 1e-3),
        ("phi_top", 1, 1e-3),
        ("phi_bottom", 1, np.pi),
        ("phi_top", 1, np.pi),
    ):
        moved = replace(motions, **{name: getattr(motions, name) + change})
        assert difference(attractor, moved, row)[k] == pytest.approx(change, abs=1e-11)
        assert difference(attractor, moved, row)[1 - k] < 1e-11


def test_only_the_period_asked_for_counts_as_the_motion(example) -> None:
    """A 1:1 motion of one forcing period is none of three, though its word is the same."""
    attractor = find_attractor(Groups(0.4604, 0.28, 0.5), Impact(BOTTOM, 1.0, 0.5))
    assert (attractor.word, attractor.period) == ("BT", 1)
    assert is_one_to_one(attractor, 1)
    assert not is_one_to_one(attractor, 3)
    # Here starts end on both.
    over = [*LIVELY, "device.length_m=6.4759", "sweep=", "simulation={starts: 24}"]
    check = analyse(loads(example("horizontal").read_text(), overrides=over)).crosscheck
    assert {(end.word, end.period) for end in check.ends[0]} == {("BT", 1), ("BT", 3)}
    assert check.trials == 24
    assert check.arrivals == sum(end.period == 3 for end in check.ends[0])
    assert [(motion.name, motion.count) for motion in check.elsewhere] == [
        ("BT every forcing period", 24 - check.arrivals)
    ]


@pytest.mark.parametrize(
    ("overrides", "names"),
    [
        (["excitation.amplitude_n=1"], {"B every forcing period", "B~ every forcing period"}),
        (["excitation.amplitude_n=0.5"], {"at rest on the bottom membrane"}),
        (["excitation.amplitude_n=12"], None),
    ],
)
def test_without_a_motion_the_simulation_says_what_the_device_does(example, overrides: list[str], names) -> None:
    over = ["simulation={starts: 8}", *overrides]
    study = analyse(loads(example("design-point").read_text(), overrides=over))
    check = study.crosscheck
    assert (check.orbits, check.trials, check.share, check.elsewhere) == (0, 0, None, ())
    assert sum(motion.count for motion in check.motions) == 8
    assert names is None or {motion.name for motion in check.motions} == names
    assert check.motions[0].name in " ".join(study.opening.worded().text)
    data = study.to_dict()["simulation"]
    assert data["basin"] is None
    assert [motion["count"] for motion in data["motions"]] == [motion.count for motion in check.motions]


def test_where_starts_end_that_do_not_reach_the_motion(example) -> None:
    """At 3.6 N, and from 3.95 to 4.15 N, a part of the starts stays on the bottom membrane."""
    over = ["simulation={samples: 5, starts: 64}", "sweep.from=3.6", "sweep.to=4.4"]
    study = analyse(loads(example("simulated").read_text(), overrides=over))
    check = study.crosscheck
    lost = [sum(end.outcome is Outcome.STICKING for end in row) for row in check.ends]
    assert [count > 0 for count in lost] == [True, False, True, False, False]
    assert 0.05 < lost[0] / 64 < 0.2
    assert sum(lost) == check.trials - check.arrivals == sum(motion.count for motion in check.elsewhere)
    assert all(motion.stays for motion in check.elsewhere)
    assert (min(m.low for m in check.elsewhere), max(m.high for m in check.elsewhere)) == pytest.approx((3.6, 4.0))
    assert (study.verdict.reached.status, study.verdict.reached.data) == (Status.CAUTION, check)
    said = Words("opening")("starts_reach_it", check)
    assert said == f"{check.arrivals} of {check.trials} random starts come to this motion."
    assert any("B~ every" in str(alert.cause) for alert in study.alerts if alert.code == "VR021")


def test_without_a_simulation_and_a_design_point_stability_is_called_local() -> None:
    verdict = verdict_of(Evidence(solved("inclined", device__length_m=None)))
    assert (verdict.reached.data, verdict.reached.status) == (None, Status.NEUTRAL)


@pytest.mark.slow
def test_the_interval_holds_the_share_in_95_of_100_runs(example) -> None:
    """Over 100 seeds. With the same starts at every value it would hold it in 75 of 100."""
    over = [*LIVELY, "device.length_m=", "sweep.from=6.4", "sweep.to=6.6"]
    over += ["simulation={samples: 5, starts: 8, impacts: 400}"]
    study = analyse(loads(example("horizontal").read_text(), overrides=over))
    asked = study.scenario.simulation
    many = crosscheck(study.solution, asked.model_copy(update={"starts": 2000}), seed=10**6)
    exact = many.share[0]
    assert 0.7 < exact < 0.8
    intervals = [crosscheck(study.solution, asked, seed=seed).share for seed in range(100)]
    held = sum(low <= exact <= high for _, low, high in intervals)
    assert held >= 89  # of a coverage of 95 % fewer are seen once in a hundred times


def test_overlay_lies_on_the_curves(checked) -> None:
    study = checked["inclined"]
    points = simulated_points(study)
    (doubling,) = (point for point in study.solution.critical_points if point.label == "B1")
    main = study.solution.branches[doubling.families[0] - 1].motions
    order = np.argsort(main.d)
    stable = points.d > 0.42
    expected = np.interp(points.d[stable], main.d[order], main.velocity_bottom[order])
    np.testing.assert_allclose(points.velocity[0, stable], expected, rtol=1e-3)
    assert points.voltages is not None
    assert np.isfinite(points.voltages.average_v[stable]).all()


def test_results_do_not_depend_on_the_number_of_threads(example) -> None:
    d, gbar = np.linspace(0.25, 0.5, 9), 0.28
    starts = random_starts(d, 2.0, 3, seed=1)
    alone, paired = (attractors(Groups(d, gbar, 0.5), starts, 500, workers=n) for n in (1, 2))
    assert [[a.word for a in row] for row in alone] == [[a.word for a in row] for row in paired]


@pytest.mark.slow
def test_without_a_simulation_block_neither_cross_check_nor_compiler_is_imported(example) -> None:
    code = (
        "import sys; from vireport import load, analyse\nfor file in sys.argv[1:]: analyse(load(file))\n"
        "print(*(m for m in sys.modules if 'numba' in m or m == 'vireport.study.checks.crosscheck'))"
    )
    files = [str(example(name)) for name in ("stiff-membrane", "inclined")]
    run = subprocess.run([sys.executable, "-c", code, *files], capture_output=True, text=True, check=True)
    assert not run.stdout.split()


@pytest.mark.slow
def test_the_simulated_example_writes_everything(example, tmp_path) -> None:
    run = subprocess.run(
        [sys.executable, "-m", "vireport", str(example("simulated")), "-o", str(tmp_path)],
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    names = {path.name for path in tmp_path.iterdir()}
    assert {"figure-3.png", "figure-6.png", "figure-diagram.png", "figure-2.png", "report.pdf"} <= names
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["simulation"]["passed"] is True
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "5.31, 5.87" in page  # as the scenario has them, not as Python does
    assert ">true<" in page
    assert "numba" in results["provenance"]["libraries"]
    assert results["simulation"]["basin"]["low_95"] <= results["simulation"]["basin"]["share"]


@pytest.mark.slow
def test_figure_3gh_is_the_period_4_motion(example) -> None:
    study = analyse(load(example("simulated")))
    portrait = study.crosscheck.portraits[1]
    cycle = portrait.attractor.cycle
    assert portrait.label == "F = 5.87 N"
    assert cycle.word == "BTBT"
    assert cycle.period == 2
    assert np.abs(np.abs(cycle.velocity) - 0.71495891).min() < 1e-5  # printed for d = 0.2545, which is F = 5.8699 N


def test_average_voltage_of_a_doubled_motion_is_over_its_four_impacts(checked) -> None:
    """Eq. (5.1): the mean over all impacts of a period, one number for each motion."""
    study = checked["inclined-forcing"]
    cycles = [attractor.cycle for attractors in study.crosscheck.ends for attractor in attractors]
    value, doubled = study.crosscheck.values[-1], next(cycle for cycle in cycles if cycle and cycle.word == "BTBT")
    impacts = np.array([[bottom[0], top[0]] for bottom, top in _paired(doubled)]).T
    volts = _paired_voltages(study.solution, np.full(2, value), impacts, np.zeros(2, dtype=np.intp))
    np.testing.assert_allclose(volts.average_v, np.mean([volts.bottom_v, volts.top_v]), rtol=1e-14)
    assert abs(volts.bottom_v[0] - volts.bottom_v[1]) > 100


def test_units_of_what_is_in_the_unit_of_the_parameter(example) -> None:
    from vireport.report.context import Report
    from vireport.study.provenance import provenance_of

    study = analyse(load(example("simulated")))
    rows = {row[-1]: row for row in Report(study, {}, provenance_of(study.loaded, "test")).tables.inputs().rows}
    for path in ("sweep.from", "sweep.to", "simulation.portraits", "simulation.displacement"):
        assert rows[path][3] == "N"
    assert rows["simulation.portraits"][2] == "5.31, 5.87"
