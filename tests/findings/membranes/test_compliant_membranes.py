"""Compliant membranes: against the whole equation in SI units, the rigid limit, and what solvers make of stiff ones."""

from __future__ import annotations

import json
from math import hypot, pi

import numpy as np
import pytest
from msgspec.structs import replace
from scipy.integrate import solve_ivp

from vireport import analyse, loads
from vireport.base.encoding import json_text
from vireport.base.errors import NumericalError
from vireport.design.compliant.descent import FINEST, CompliantMotion, Rigid, descend, motion_to_follow
from vireport.design.compliant.model import compliant_model
from vireport.design.compliant.return_map import SUBSTEPS, bounce
from vireport.design.point import design_point
from vireport.findings.membranes.compliance import Compliance, compliance
from vireport.findings.membranes.figure import picture
from vireport.findings.membranes.finding import FINDING
from vireport.findings.membranes.results import ComplianceData, compliance_data
from vireport.findings.membranes.solvers import RunOutcome, period_of, run_once
from vireport.findings.membranes.tables import comparison_with_rigid, solvers_on_stiff_membranes, verdict
from vireport.physics.contact import damping_number
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.scenario.loading import load
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM
from vireport.study.plan import ALL_FORMATS, Task, plan
from vireport.study.reading import read_record
from vireport.text.tables import plain_text

ALL = len(SUBSTEPS)
MASS = 0.0041
K_STEEP = 1e8


@pytest.fixture(scope="module")
def study(study_of):
    return study_of("inclined")


@pytest.fixture(scope="module")
def rigid(study):
    m = study.solution.design.motions
    return np.array([m.velocity_bottom[0], m.phi_bottom[0]])


@pytest.fixture(scope="module")
def models(study):
    return {
        factor: compliant_model(
            study.solution.device,
            Parameter.LENGTH,
            study.solution.device.length_m,
            study.solution.membrane,
            factor,
        )
        for factor in (1.0, 1e4, 1e6, K_STEEP)
    }


def followed(device: Device, membrane: Membrane, factor: float, row: int = 0) -> CompliantMotion:
    """A motion of a device with K times a factor, followed from the rigid one."""
    m = design_point(device, None).motions
    numbers = (m.velocity_bottom, m.velocity_top, m.phi_bottom, m.phi_top, 2 * device.period_ratio * m.q)
    rigid = Rigid(Parameter.LENGTH, device.length_m, "", *(float(values[row]) for values in numbers))
    (reached,) = descend(motion_to_follow(device, membrane, rigid), [factor], FINEST)
    return reached.motion


@pytest.fixture(scope="module")
def orbits(study, models):
    return {factor: followed(study.solution.device, study.solution.membrane, factor) for factor in models}


@pytest.fixture(scope="module")
def effects(study) -> Compliance:
    return compliance(study.solution, ladder=(1, 1e4, 1e6, 1e8), repeats=1)


def test_return_map_is_the_whole_equation_in_si_units(study, orbits) -> None:
    """Independent of scaling, flight and splitting: m, K, F, g and seconds, in one go."""
    device, membrane, orbit = study.solution.device, study.solution.membrane, orbits[1.0]
    length_unit = device.amplitude_n / (4 * device.capsule_mass_kg * device.frequency_hz**2)
    speed = orbit.bottom.velocity * device.amplitude_n / (2 * device.capsule_mass_kg * device.frequency_hz)
    g = 9.8 * np.sin(np.radians(45.0))
    damping = damping_number(device.restitution)
    top_speed = -orbit.top.velocity * speed / orbit.bottom.velocity
    half, omega = device.length_m / 2, 2 * pi * device.frequency_hz

    def rates(t: float, state: np.ndarray) -> tuple[float, float]:
        z, v = state
        a = g + device.amplitude_n / device.capsule_mass_kg * np.cos(omega * t + orbit.bottom.phase)
        a -= membrane.stiffness / MASS * max(z - half, 0) ** membrane.exponent * (1 + damping / speed * v)
        a += membrane.stiffness / MASS * max(-half - z, 0) ** membrane.exponent * (1 - damping / top_speed * v)
        return v, a

    period = 1 / device.frequency_hz
    run = solve_ivp(rates, (0, period), [half, speed], method="DOP853", rtol=1e-12, atol=1e-14, max_step=period / 500)
    assert run.y[0, -1] == pytest.approx(half, abs=1e-9)
    assert run.y[1, -1] == pytest.approx(speed, rel=1e-8)
    assert (run.y[0].max() - half) / length_unit == pytest.approx(orbit.bottom.deflection, rel=1e-4)


def test_orbit_repeats_and_tends_to_the_rigid_one(orbits, rigid, models) -> None:
    epsilon = {factor: orbit.bottom.duration for factor, orbit in orbits.items()}
    for factor, orbit in orbits.items():
        assert orbit.residual < 1e-8
        assert orbit.stable
        shift = hypot(orbit.bottom.velocity - rigid[0], orbit.bottom.phase - rigid[1])
        assert shift < 0.6 * epsilon[factor]  # 0.37 of a contact's duration on every rung
        assert shift > 0.1 * epsilon[factor]
    assert hypot(orbits[K_STEEP].bottom.velocity - rigid[0], orbits[K_STEEP].bottom.phase - rigid[1]) < 1e-4


def test_multipliers_tend_to_those_of_the_rigid_motion(study, orbits, models, rigid) -> None:
    m = study.solution.design.motions
    assert orbits[K_STEEP].determinant == pytest.approx(study.solution.device.restitution**4, rel=2e-4)
    assert orbits[K_STEEP].trace == pytest.approx(float(m.trace[0]), abs=1e-3)
    shifts = [abs(orbits[factor].trace - float(m.trace[0])) for factor in (1e4, 1e6, K_STEEP)]
    assert shifts[1] / shifts[2] == pytest.approx(100 ** (1 / 3.6), rel=0.03)


@pytest.mark.slow
def test_unlike_membranes_tend_to_the_rigid_motion_each_with_its_own_restitution(example) -> None:
    over = {"device.restitution": None, "device.restitution_bottom": 0.475, "device.restitution_top": 0.525}
    solution = analyse(load(example("inclined"), over), (Task.JSON,)).solution
    m, device = solution.design.motions, solution.device
    steep = compliant_model(device, Parameter.LENGTH, device.length_m, solution.membrane, 1e6)
    orbit = followed(device, solution.membrane, 1e6)
    assert orbit.bottom.velocity == pytest.approx(m.velocity_bottom[0], rel=1e-3)
    assert orbit.top.velocity == pytest.approx(m.velocity_top[0], rel=1e-3)
    assert (orbit.bottom.restitution, orbit.top.restitution) == pytest.approx((0.475, 0.525), rel=1e-3)
    assert orbit.determinant == pytest.approx((0.475 * 0.525) ** 2, rel=2e-3)
    assert orbit.trace == pytest.approx(m.trace[0], rel=1e-2)
    # The whole equation in one go, whose damping is of each membrane's own restitution.
    run = run_once(period_of(steep, orbit), 1e6, "DOP853", 1e-10)
    assert run.outcome is RunOutcome.SOLVED
    assert run.error < 1e-8


@pytest.mark.slow
def test_a_motion_of_two_forcing_periods_tends_to_the_rigid_one(study) -> None:
    device = replace(study.solution.device, period_ratio=2, length_m=1.654)
    motions = design_point(device, None).motions
    (row,) = np.flatnonzero(motions.stable_mask)
    orbit = followed(device, study.solution.membrane, K_STEEP, row)
    assert orbit.bottom.velocity == pytest.approx(motions.velocity_bottom[row], abs=1e-3)
    assert orbit.bottom.phase == pytest.approx(motions.phi_bottom[row], abs=5e-3)
    assert orbit.top.phase == pytest.approx(motions.phi_top[row], abs=5e-3)


@pytest.mark.slow
def test_ladder_converges_at_the_rate_of_the_contact_time(effects) -> None:
    assert effects.order == pytest.approx(1 / 3.6)
    for rate in effects.convergence:
        assert rate.exponent == pytest.approx(-effects.order, rel=0.01), rate.quantity
    durations = [rung.orbit.bottom.duration for rung in effects.rungs]
    assert durations[-1] / durations[-2] == pytest.approx(100**-effects.order, rel=2e-3)


@pytest.mark.slow
def test_own_membrane_moves_the_period_doubling_more_than_the_motion(study, effects) -> None:
    """The paper's K: contacts of two per cent of the period, velocities within 5 %, B1 far off."""
    own = effects.unscaled
    assert own.orbit.bottom.duration / 2 == pytest.approx(0.0209, abs=1e-4)
    assert own.orbit.bottom.velocity / effects.rigid.velocity_bottom - 1 == pytest.approx(0.01024, abs=1e-5)
    assert own.critical_value == pytest.approx(0.581545, abs=1e-6)
    assert effects.critical.sweep_value == pytest.approx(0.629457, abs=1e-6)
    assert effects.volts.rigid == pytest.approx(study.solution.design.voltages_by_motion.average_v[0])
    assert effects.volts.by_deflection < effects.volts.rigid < effects.volts.by_velocity
    assert effects.grade == 2
    assert "B1" in verdict(effects)
    assert [criterion.name for criterion in effects.criteria] == [
        "velocity at the bottom",
        "velocity at the top",
        "U_ave by the velocities",
        "B1",
    ]
    rows = {quantity.name: quantity for quantity in effects.quantities}
    for wall, phase in (("bottom", effects.rigid.phase_bottom), ("top", effects.rigid.phase_top)):
        assert rows[f"phase at the {wall}"].compliant == pytest.approx(phase, abs=0.1)
    assert rows["margin to B1"].compliant == pytest.approx(0.6934 - own.critical_value)
    assert rows["margin to B1"].criterion.shift == pytest.approx(-rows["margin to B1"].shift)
    assert "−7.6 %" in plain_text(comparison_with_rigid(effects))


@pytest.mark.slow
def test_fixed_steps_fail_where_contacts_fall_between_them(effects) -> None:
    runs = {(run.setting, run.factor): run for run in effects.runs if run.solver == "RK4"}
    assert runs[300, 1].outcome is RunOutcome.SOLVED
    assert runs[300, 1e8].outcome is not RunOutcome.SOLVED
    assert runs[3000, 1e8].outcome is not RunOutcome.SOLVED
    assert runs[30000, 1e6].outcome is RunOutcome.SOLVED
    assert runs[30000, 1].error < 1e-3 * runs[3000, 1].error


@pytest.mark.slow
def test_adaptive_explicit_methods_survive_the_ladder(effects) -> None:
    for name in ("RK45", "DOP853"):
        runs = {(run.setting, run.factor): run for run in effects.runs if run.solver == name}
        assert all(run.outcome is RunOutcome.SOLVED for run in runs.values())
        assert runs[1e-10, 1e8].evaluations < 3 * runs[1e-10, 1].evaluations
        assert runs[1e-10, 1e8].error < 1e-5


def test_a_membrane_that_is_never_met_is_missed(models, orbits) -> None:
    """Without the force a run reaches the end, and is not taken for a solution."""
    period = period_of(models[1.0], orbits[1.0])
    apart = replace(period, model=replace(period.model, d=100.0))
    run = run_once(apart, 1.0, "RK45", 1e-7)
    assert run.outcome is RunOutcome.MISSED
    assert run.error is not None


def test_fixed_steps_are_of_the_fourth_order(models, orbits) -> None:
    period = period_of(models[1.0], orbits[1.0])
    coarse, fine = (run_once(period, 1.0, "RK4", steps).error for steps in (1000, 2000))
    assert coarse / fine == pytest.approx(16, rel=0.1)


def test_overflow_of_a_fixed_step_is_told(models, orbits) -> None:
    run = run_once(period_of(models[K_STEEP], orbits[K_STEEP]), K_STEEP, "RK4", 300)
    assert run.outcome is RunOutcome.OVERFLOW
    assert run.error is None
    assert run.steps < 300


def test_strongly_compliant_membranes_are_a_result(study) -> None:
    soft = replace(study.solution, membrane=replace(study.solution.membrane, stiffness=1e-6))
    effects = compliance(soft, ladder=(1,), repeats=1)
    assert effects.unscaled.orbit is None
    assert "followed to about K times" in effects.unscaled.reason
    assert effects.grade == 2
    assert "not good enough" in verdict(effects)
    written = json.loads(json_text(compliance_data(effects)))
    assert written["rungs"][0]["orbit"] is None
    assert read_record(written, ComplianceData, "accuracy.json", "compliant").grade == 2


def test_what_cannot_be_compared_says_why(example) -> None:
    text = example("inclined").read_text(encoding="utf-8")
    without = "\n".join(line for line in text.splitlines() if "ball_mass_kg" not in line)
    assert "mass" in compliance(analyse(loads(without)).solution, ladder=(1,)).reason
    inelastic = text.replace("restitution: 0.5", "restitution: 0.0").replace("0.6934", "0.2")
    effects = compliance(analyse(loads(inelastic)).solution, ladder=(1,))
    assert effects.reason
    assert effects.grade is None
    assert effects.reason in verdict(effects)


def test_no_motion_without_a_bounce(models) -> None:
    soft = replace(models[1.0], membrane=replace(models[1.0].membrane, stiffness=1e-9))
    with pytest.raises(NumericalError, match="stays on the membrane"):
        bounce(soft, BOTTOM, 1e-3, 0.0, ALL)


@pytest.mark.slow
def test_figure_and_words_tell_of_failures_and_rates(effects) -> None:
    _, step = FINDING.steps()
    drawn = picture(effects, step.task)
    figure = drawn.figure
    assert len(figure.axes) == 2
    assert "RK4" in drawn.alt
    assert "−0.278" in drawn.caption
    tables = {table.caption: table for table in (*comparison_with_rigid(effects), *solvers_on_stiff_membranes(effects))}
    ladder = tables["Distance from the rigid model"]
    assert ladder.rows[-1][-1] == "−0.278"
    assert any("overflow" in cell for row in tables["Error at the end of the period"].rows for cell in row)


SCENARIO = """\
schema_version: 1
device: {capsule_mass_kg: 0.1, ball_mass_kg: 0.004, restitution: 0.5, length_m: 0.7}
excitation: {amplitude_n: 3, frequency_hz: 2}
inclination_deg: 45
accuracy: {}
"""


def test_the_step_of_an_addition_is_known_by_its_name_running_or_left_out() -> None:
    with_ball = plan(loads(SCENARIO).scenario, ALL_FORMATS)
    without = plan(loads(SCENARIO.replace("ball_mass_kg: 0.004, ", "")).scenario, ALL_FORMATS)
    running = with_ball.running("compliant")
    assert running is not None
    assert running.what == "the motion with compliant membranes, and solvers on stiff ones"
    assert (with_ball.reason("compliant"), without.running("compliant")) == (None, None)
    assert without.reason("compliant") == "device.ball_mass_kg is not given"
