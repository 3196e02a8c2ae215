"""The motion with the membranes' own stiffness in every report: against the independent integration of it."""

from __future__ import annotations

import numpy as np
import pytest
from adaptive_contacts import contact, lap, linearised, mismatch
from conftest import first, solved
from msgspec.structs import replace

from vireport import analyse, load
from vireport.design.compliant.descent import Missing
from vireport.design.compliant.model import compliant_model
from vireport.design.compliant.own_stiffness import own_stiffness
from vireport.design.compliant.return_map import SUBSTEPS, bounce, return_trip
from vireport.design.point import design_point
from vireport.motions.events import Event
from vireport.physics.forcing import Harmonic
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM, TOP
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.verdict import verdict_of
from vireport.study.plan import FORMATS
from vireport.study.results import own_stiffness_data

ALL = len(SUBSTEPS)

GONE = ("device.restitution=0.3", "inclination_deg=45", "sweep.from=0.2", "sweep.to=4")
"""A capsule whose stable range ends at a fold, above it; with the membranes' own stiffness the fold comes sooner."""


@pytest.fixture(scope="module")
def inclined():
    solution = solved("inclined")
    return solution, own_stiffness(solution)


def random_contact(solution, rng: np.random.Generator):
    """A model, a wall, and velocity and phase of a touch, of any restitution that is followed."""
    device = solution.device.with_values({"restitution": rng.uniform(0.1, 0.99)})
    model = compliant_model(device, Parameter.LENGTH, 0.7, solution.membrane, 10 ** rng.uniform(-2, 4))
    membrane = replace(model.membrane, exponent=rng.uniform(1.2, 3))
    wall = int(rng.choice([BOTTOM, TOP]))
    model = replace(model, membrane=membrane, gbar=rng.uniform(-1, 1))
    return model, wall, wall * rng.uniform(0.5, 2), rng.uniform(0, 2 * np.pi)


def errors_by_columns(model, wall: int, velocity: float, phase: float) -> list[float]:
    """Relative error of a contact with 4, 6, 8 and all columns, against the adaptive integration."""
    slow, errors = contact(model, wall, velocity, phase), []
    for columns in (4, 6, 8, ALL):
        fast, _ = bounce(model, wall, velocity, phase, columns)
        pairs = ((fast.duration, slow.duration), (fast.leaving, slow.leaving), (fast.deflection, slow.deflection))
        errors.append(max(abs(value / exact - 1) for value, exact in pairs))
    return errors


@pytest.mark.parametrize(
    ("restitution", "factor", "speed", "phase"),
    [
        (0.5, 1.0, 1.0, 0.7),
        (0.9, 1.0, 0.6, 0.7),
        # The forces pull the ball off so fast that the membrane, which cannot pull, lets it go before it is flat again.
        (0.2, 1.0, 1.5, 0.7),
        (0.2, 1.0, 1.0, 3.0),
        (0.1, 1.0, 1.0, 0.7),
        (0.5, 1e4, 1.0, 0.7),
        (0.5, 0.01, 1.0, 0.7),
    ],
)
def test_a_contact_converges_to_that_of_the_adaptive_integration(restitution, factor, speed, phase) -> None:
    """Also where the ball is nearly elastic, let go early, or the contact takes a quarter of the period."""
    solution = solved("inclined")
    device = solution.device.with_values({"restitution": restitution})
    model = compliant_model(device, Parameter.LENGTH, 0.7, solution.membrane, factor)
    for wall in (BOTTOM, TOP):
        four, six, eight, finest = errors_by_columns(model, wall, wall * speed, phase)
        assert four < 1e-3
        assert six < 3e-5
        assert eight < 2e-6
        assert finest < 1e-8


@pytest.mark.slow
def test_random_contacts_converge_to_the_stated_accuracy() -> None:
    rng, let_go = np.random.default_rng(4), 0
    for _ in range(60):
        model, wall, velocity, phase = random_contact(solved("inclined"), rng)
        _, six, eight, finest = errors_by_columns(model, wall, velocity, phase)
        assert six < 2e-4
        assert eight < max(0.3 * six, 1e-6)
        assert finest < 2e-7
        # Faster than the membrane comes after it, with the damping D/v that gives r.
        let_go += abs(bounce(model, wall, velocity, phase, 8)[0].leaving) > abs(velocity) * model.restitution_at(wall)
    assert let_go > 20


@pytest.mark.slow
def test_derivatives_are_those_of_the_map_where_the_membrane_lets_go() -> None:
    solution = solved("inclined")
    model = compliant_model(solution.device.with_values({"restitution": 0.2}), Parameter.LENGTH, 0.7, solution.membrane)
    (_, jacobian), step = bounce(model, TOP, -1.5, 0.7, ALL), 1e-4

    def ends(velocity: float, phase: float) -> np.ndarray:
        end = contact(model, TOP, velocity, phase)
        return np.array([end.leaving, phase + np.pi * end.duration])

    faster, later = ends(-1.5 + step, 0.7) - ends(-1.5 - step, 0.7), ends(-1.5, 0.7 + step) - ends(-1.5, 0.7 - step)
    assert jacobian == pytest.approx(np.stack([faster, later], axis=1) / (2 * step), abs=1e-6)


def test_derivatives_of_contacts_are_those_of_the_numbers_that_the_same_steps_give() -> None:
    """By central differences; of random contacts, from which the membrane lets the ball go early, or does not."""
    rng, let_go = np.random.default_rng(8), 0
    for _ in range(20):
        model, wall, velocity, phase = random_contact(solved("inclined"), rng)
        (end, jacobian), step, columns = bounce(model, wall, velocity, phase, ALL), 1e-3, []

        def ends(speed: float, angle: float, model=model, wall=wall) -> np.ndarray:
            after, _ = bounce(model, wall, speed, angle, ALL)
            return np.array([after.leaving, angle + np.pi * after.duration])

        for speed, angle in ((step, 0.0), (0.0, step)):
            after, before = (ends(velocity + sign * speed, phase + sign * angle) for sign in (1, -1))
            columns.append((after - before) / (2 * step))
        assert jacobian == pytest.approx(np.stack(columns, axis=1), abs=1e-6 * np.abs(jacobian).max())
        let_go += abs(end.leaving) > abs(velocity) * model.restitution_at(wall)
    assert 3 < let_go < 17


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
    x = found.motion.bottom.velocity, found.motion.bottom.phase
    fast = return_trip(model, *x, (0.9, 0.8), ALL)
    slow = lap(model, *x)
    assert fast.velocity == pytest.approx(slow.velocity, abs=2e-6)
    assert fast.time == pytest.approx(slow.time, abs=2e-6)
    assert fast.jacobian == pytest.approx(linearised(model, np.array(x)), abs=2e-5)


def distances(solution, found) -> list[tuple[float, float]]:
    """By how much motion and period doublings are off, by a Newton step on the reference, and the stated errors."""
    device = solution.device.with_values({found.rigid.parameter: found.rigid.value})
    pairs = []

    def model_where(**values: float):
        changed = device.with_values(values)
        return compliant_model(changed, Parameter.LENGTH, changed.length_m, solution.membrane)

    def exact_map(model, x: np.ndarray) -> np.ndarray:
        flights = found.rigid.time_up, model.period - found.rigid.time_up
        return return_trip(model, *x, flights, 8).jacobian

    def doubling(jacobian: np.ndarray) -> float:
        return float(1 + np.trace(jacobian) + np.linalg.det(jacobian))

    if found.motion is not None:
        x, model = np.array([found.motion.bottom.velocity, found.motion.bottom.phase]), model_where()
        step = np.linalg.solve(exact_map(model, x) - np.eye(2), mismatch(model, x))
        pairs.append((float(np.max(np.abs(step))), found.motion.error))
    for end in found.ends:
        if end.compliant is not None and end.point.event is Event.PERIOD_DOUBLING:
            x, conditions = np.array([end.point.closed.velocity_bottom, end.point.closed.phi_bottom]), []
            for value in (end.compliant * 1.001, end.compliant):
                model = model_where(**{end.parameter: value})
                for _ in range(6):
                    x = x - np.linalg.solve(exact_map(model, x) - np.eye(2), mismatch(model, x))
                conditions.append(doubling(exact_map(model, x)))
            slope = (conditions[0] - conditions[1]) / (0.001 * end.compliant)
            pairs.append((abs(doubling(linearised(model, x)) / slope), end.error))
    return pairs


def test_a_motion_is_that_of_the_adaptive_integration_to_its_stated_error(inclined) -> None:
    solution, found = inclined
    ((distance, error),) = distances(solution, replace(found, ends=()))
    assert 1e-9 < distance < error < 1e-5


@pytest.mark.slow
def test_motion_and_ends_are_those_of_the_adaptive_integration_to_their_stated_error(inclined) -> None:
    solution, found = inclined
    pairs = distances(solution, found)
    assert len(pairs) == 3
    assert all(distance < error < 1e-4 for distance, error in pairs)
    swept = found.swept_ends[0]
    assert (f"{swept.rigid:.3f}", f"{swept.compliant:.3f}") == ("0.629", "0.582")
    assert swept.rigid_margin == pytest.approx(0.6934 / 0.6934 - swept.rigid / 0.6934)
    assert swept.compliant_margin == pytest.approx(1 - swept.compliant / 0.6934)


@pytest.mark.slow
def test_stated_errors_hold_on_random_devices(example) -> None:
    """Of any restitution and exponent, with contacts that take up to a tenth of the period."""
    rng, pairs = np.random.default_rng(11), []
    for _ in range(20):
        changes = {
            "device.restitution": rng.uniform(0.12, 0.9),
            "inclination_deg": rng.uniform(0, 60),
            "device.length_m": rng.uniform(0.3, 1.2),
            "device.membrane.exponent": rng.uniform(1.5, 3),
        }
        solution = analyse(load(example("inclined"), {name: float(value) for name, value in changes.items()}), ["json"])
        solution = solution.solution
        membrane = replace(solution.membrane, stiffness=solution.membrane.stiffness * 10 ** rng.uniform(-3, 3))
        solution = replace(solution, membrane=membrane)
        found = own_stiffness(solution)
        if found is not None:
            pairs += distances(solution, found)
    assert len(pairs) > 25
    assert [pair for pair in pairs if not pair[0] < pair[1] < 2e-3] == []


def test_an_end_that_the_ball_does_not_reach_is_lost() -> None:
    """The doubled motion of the horizontal capsule falls back on the same membrane first."""
    found = own_stiffness(solved("horizontal"))
    (swept,) = found.swept_ends
    assert swept.compliant is None
    assert "falls back" in swept.absence.reason
    assert swept.absence.missing is Missing.LOST
    assert found.motion.stable
    assert own_stiffness_data(found).ends[0].missing == "lost"


@pytest.mark.parametrize(("length", "lost"), first(1, [(0.8678, True), (0.75, False)], unpacked=True))
def test_a_margin_that_the_own_stiffness_takes_is_a_caution(length: float, lost: bool, example) -> None:
    study = analyse(load(example("inclined"), [*GONE, f"device.length_m={length}"]))
    rigid = verdict_of(Evidence(study.solution, switched_on=study.switched_on))
    end = study.verdict.margin.data.compliant
    assert end.point.event is Event.FOLD
    assert end.rigid_margin > 0
    assert (end.compliant_margin < 0) == lost
    assert study.own_stiffness.margin_gone == lost
    said = study.verdict.own_stiffness
    if lost:
        assert rigid.word != study.verdict.word == "Stable by rigid impacts, but not with the membranes' own stiffness"
        assert study.verdict.status == said.status == "caution"
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


def test_a_phase_near_zero_is_known_as_well_as_any(example) -> None:
    changes = {"restitution": 0.928, "length_m": 0.2177, "capsule_mass_kg": 0.1523, "ball_mass_kg": 0.0044}
    over = {f"device.{name}": value for name, value in changes.items()}
    over |= {"excitation.amplitude_n": 1.925, "excitation.frequency_hz": 3.085, "sweep": None}
    found = own_stiffness(analyse(load(example("horizontal"), over), ["json"]).solution)
    assert min(found.motion.bottom.phase, 2 * np.pi - found.motion.bottom.phase) < 0.05
    assert found.motion.error < 1e-4


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
        load(
            example("inclined"),
            ["device.restitution=0.08", "device.length_m=0.51", "inclination_deg=20", "sweep.from=0.1", "sweep.to=4"],
        )
    )
    found = study.own_stiffness
    assert found.motion is None
    assert {end.absence.missing for end in found.ends} == {found.absence.missing} == {Missing.NOT_FOLLOWED}
    assert study.verdict.status == "caution"
    assert "not known with the membranes' own stiffness" in study.verdict.word
    assert found.absence.reason == "restitutions below 0.1 are not followed"


def test_ends_of_a_sweep_are_compliant_though_the_design_point_is_not_stable(example) -> None:
    """B1 passes over a design point at which the rigid motion is not stable."""
    study = analyse(load(example("inclined"), ["device.length_m=0.6"]))
    (end,) = study.own_stiffness.ends
    assert end.compliant < 0.6 < end.rigid
    assert (end.rigid_margin, end.compliant_margin) == (None, None)
    assert not study.own_stiffness.margin_gone


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
    assert {alert.severity for alert in study.alerts} <= {"note"}
