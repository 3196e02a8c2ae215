"""The motion with the membranes' own stiffness in every report: against the slow, independent integration of it."""

from __future__ import annotations

import re

import numpy as np
import pytest
from conftest import first, solved
from msgspec.structs import replace

from vireport import analyse, load
from vireport.compliant import compliant_model, own_stiffness, own_stiffness_data
from vireport.compliant.own_stiffness import Missing
from vireport.compliant.return_map import SUBSTEPS, bounce, return_trip
from vireport.design import design_point
from vireport.gate import Evidence, Question, verdict_of
from vireport.membranes import compliance
from vireport.membranes.compliant_motion import BOTTOM, TOP, contact, lap, linearised
from vireport.motions import Event
from vireport.physics import Harmonic
from vireport.scenario import Parameter
from vireport.study import FORMATS

ALL = len(SUBSTEPS)

GONE = ("device.restitution=0.3", "inclination_deg=45", "sweep.from=0.2", "sweep.to=4")
"""A capsule whose stable range ends at a fold, above it; with the membranes' own stiffness the fold comes sooner."""


@pytest.fixture(scope="module")
def inclined():
    solution = solved("inclined")
    return solution, own_stiffness(solution)


def test_a_contact_is_that_of_the_adaptive_integration() -> None:
    """Also where the ball is nearly elastic, strongly damped, or the contact takes a quarter of the period."""
    solution = solved("inclined")
    device, membrane = solution.device, solution.membrane
    contacts = ((0.5, 1.0, 1.0), (0.9, 1.0, 0.6), (0.2, 1.0, 1.5), (0.35, 1.0, 1.0), (0.5, 1e4, 1.0), (0.5, 0.01, 1.0))
    for restitution, factor, speed in contacts:
        one = device.with_values({"restitution": restitution})
        model = compliant_model(one, Parameter.LENGTH, 0.7, membrane, factor)
        for wall in (BOTTOM, TOP):
            fast = bounce(model, wall, wall * speed, 0.7, ALL)
            slow = contact(model, wall, wall * speed, 0.7)
            assert fast.duration == pytest.approx(slow.duration, rel=2e-5)
            assert fast.leaving == pytest.approx(slow.leaving, rel=2e-5)
            assert fast.deflection == pytest.approx(slow.deflection, rel=2e-5)


def test_a_force_with_harmonics_drives_contacts_and_flights() -> None:
    """The return map and its derivatives against the adaptive integration, and rigid membranes as the limit."""
    harmonics = (Harmonic.of(2, 5.0, 45.0), Harmonic.of(5, 20.0, 300.0))
    solution = solved("inclined")
    device = replace(solution.device, harmonics=harmonics)
    model = compliant_model(device, Parameter.LENGTH, 0.7, solution.membrane)
    fast, slow = return_trip(model, 1.0, 0.5, (0.9, 0.8), ALL), lap(model, 1.0, 0.5)
    assert fast.velocity == pytest.approx(slow.velocity, abs=2e-6)
    assert fast.time == pytest.approx(slow.time, abs=2e-6)
    assert fast.jacobian == pytest.approx(linearised(model, np.array([1.0, 0.5])), abs=2e-5)
    design = design_point(device.with_values({"length_m": 0.7}), None)
    velocity, phase = float(design.motions.velocity_bottom[0]), float(design.motions.phi_bottom[0])
    up = float(2 * design.motions.q[0])
    off = []
    for factor in (1e8, 1e10):
        stiff = compliant_model(device, Parameter.LENGTH, 0.7, solution.membrane, factor)
        off.append(abs(return_trip(stiff, velocity, phase, (up, 2 - up), ALL).velocity - velocity))
    # Contacts shorten with K^(-1/(h + 1)), h = 2.6.
    assert off[1] < 1e-2
    assert off[0] / off[1] == pytest.approx(100 ** (1 / 3.6), rel=0.05)


def test_the_return_map_and_its_derivatives_are_those_of_the_adaptive_integration(inclined) -> None:
    solution, found = inclined
    model = compliant_model(solution.device, Parameter.LENGTH, solution.device.length_m, solution.membrane)
    x = found.motion.velocity_bottom, found.motion.phase_bottom
    fast = return_trip(model, *x, (0.9, 0.8), ALL)
    slow = lap(model, *x)
    assert fast.velocity == pytest.approx(slow.velocity, abs=2e-6)
    assert fast.time == pytest.approx(slow.time, abs=2e-6)
    assert fast.jacobian == pytest.approx(linearised(model, np.array(x)), abs=2e-5)


@pytest.mark.slow
def test_motion_and_end_are_those_of_the_accuracy_block_to_their_stated_error(inclined) -> None:
    solution, found = inclined
    slow = compliance(solution, (1,), repeats=1)
    orbit, motion = slow.own.orbit, found.motion
    assert abs(motion.velocity_bottom - orbit.bottom.velocity) < motion.error < 1e-4
    assert abs(motion.phase_bottom - orbit.bottom.phase) < motion.error
    assert motion.velocity_top == pytest.approx(orbit.top.velocity, abs=1e-6)
    assert motion.trace == pytest.approx(orbit.trace, abs=1e-4)
    assert motion.contact_share == pytest.approx(orbit.longest_contact / 2, rel=1e-4)
    (swept,) = found.swept_ends
    assert swept.point.event is Event.PERIOD_DOUBLING
    assert abs(swept.compliant - slow.own.critical_value) < swept.error < 1e-4
    assert (f"{swept.rigid:.3f}", f"{swept.compliant:.3f}") == ("0.629", "0.582")
    assert swept.rigid_margin == pytest.approx(0.6934 / 0.6934 - swept.rigid / 0.6934)
    assert swept.compliant_margin == pytest.approx(1 - swept.compliant / 0.6934)


def test_an_end_that_the_ball_does_not_reach_is_lost() -> None:
    """The doubled motion of the horizontal capsule falls back on the same membrane first."""
    found = own_stiffness(solved("horizontal"))
    (swept,) = found.swept_ends
    assert swept.compliant is None
    assert "falls back" in swept.absence.reason
    assert swept.absence.missing is Missing.LOST
    assert found.motion.stable
    assert own_stiffness_data(found)["ends"][0]["missing"] == "lost"


@pytest.mark.slow
def test_the_slow_solver_loses_the_same_end() -> None:
    own = compliance(solved("horizontal"), (1,), repeats=1).own
    assert own.critical_value is None
    assert "falls back" in own.reason


@pytest.mark.parametrize(("length", "lost"), first(1, [(0.8678, True), (0.75, False)], unpacked=True))
def test_a_margin_that_the_own_stiffness_takes_is_a_caution(length: float, lost: bool, example) -> None:
    study = analyse(load(example("inclined"), [*GONE, f"device.length_m={length}"]))
    rigid = verdict_of(Evidence(study.solution, disturbances=study.disturbances))
    end = study.verdict.margin.data.compliant
    assert end.point.event is Event.FOLD
    assert end.rigid_margin > 0
    assert (end.compliant_margin < 0) == lost
    assert study.own_stiffness.margin_gone == lost
    said = next(fact for fact in study.verdict.facts if fact.question == Question.OWN_STIFFNESS)
    if lost:
        assert rigid.word != study.verdict.word == "Stable by rigid impacts, but not with the membranes' own stiffness"
        assert study.verdict.status == said.status == "caution"
        assert said.answer == "The motion is lost"
        assert "compliant −" in study.verdict.headline
    else:
        assert said.status == "neutral"
        assert study.verdict.word == rigid.word


def test_a_range_whose_end_is_lost_is_not_called_good(example) -> None:
    """Also where nothing else is wrong: here the membrane is wide enough for its deflection."""
    wide = load(example("horizontal"), ["device.membrane.active_radius_m=0.05"])
    assert analyse(wide).verdict.word == "Stable, margin known for rigid membranes only"  # a pitchfork
    study = analyse(load(example("horizontal"), ["device.membrane.active_radius_m=0.05", "device.length_m="]))
    assert study.solution.within_membrane
    assert study.verdict.status == "caution"
    assert study.verdict.word == "Stable, but not to the same end with the membranes' own stiffness"
    assert "B1 in s: rigid 0.282 m, compliant lost" in study.verdict.headline


def test_what_is_not_found_is_not_called_lost(example) -> None:
    """A ball that is so heavy that the contact lasts as long as its flight: the iteration leads nowhere."""
    study = analyse(load(example("inclined"), ["device.membrane.stiffness=20"]))
    found = study.own_stiffness
    assert found.motion is None
    assert found.absence.missing is Missing.NOT_FOUND
    assert not found.margin_gone
    assert study.verdict.status == "caution"
    assert study.verdict.word == "Stable by rigid impacts, not known with the membranes' own stiffness"


def test_what_is_not_followed_is_said(example) -> None:
    """Restitutions below the least one, and ends of other kinds than the two that are followed."""
    study = analyse(
        load(example("inclined"), ["device.restitution=0.15", "inclination_deg=20", "sweep.from=0.1", "sweep.to=4"])
    )
    found = study.own_stiffness
    assert found.motion is None
    assert {end.absence.missing for end in found.ends} == {found.absence.missing} == {Missing.NOT_FOLLOWED}
    assert study.verdict.status == "caution"
    assert "not followed with the membranes' own stiffness" in study.verdict.headline
    said = next(fact for fact in study.verdict.facts if fact.question == Question.OWN_STIFFNESS)
    assert said.detail == "Restitutions below 0.2 are not followed"


def test_ends_of_a_sweep_are_compliant_though_the_design_point_is_not_stable(example) -> None:
    """B1 passes over a design point at which the rigid motion is not stable."""
    study = analyse(load(example("inclined"), ["device.length_m=0.6"]))
    (end,) = study.own_stiffness.ends
    assert end.compliant < 0.6 < end.rigid
    assert (end.rigid_margin, end.compliant_margin) == (None, None)
    assert not study.own_stiffness.margin_gone
    assert "0.629 m < s" in study.verdict.headline
    assert "rigid 0.629 m, compliant 0.582 m" in study.verdict.headline


@pytest.mark.slow
def test_where_contacts_are_long_whatever_is_written(example) -> None:
    """Results that hung on the formats would make a report and --json of one scenario differ."""
    for name, there in (("inclined", True), ("stiff-membrane", False)):
        data, page = (
            analyse(load(example(name)), formats).to_dict()["own_stiffness"] for formats in (["json"], FORMATS)
        )
        assert data == page
        assert (data is not None) == there
    light = analyse(load(example("inclined"), ["device.ball_mass_kg="]))
    assert light.own_stiffness is None


def test_the_newcomers_device_stays_within_its_membrane(example) -> None:
    study = analyse(load(example("stiff-membrane")))
    design = study.solution.design
    stable, membrane = design.motions.stable_mask, study.solution.membrane
    assert study.solution.within_membrane
    assert design.conversion_by_motion.efficiency[stable].max() < 1
    assert design.conversion_by_motion.field_v_m[stable].max() < membrane.dielectric.breakdown_field_v_m
    assert study.verdict.status == "good"
    assert re.search(r"U_ave = [\d.]+ V\.$", study.verdict.headline)
    assert {alert.severity for alert in study.alerts} <= {"note"}
