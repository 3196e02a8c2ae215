"""The accuracy study: its reference against published digits, its methods against their orders, its failures shown."""

from __future__ import annotations

import json
from functools import partial
from itertools import pairwise
from math import inf, isfinite, radians, sin

import numpy as np
import pytest
from mpmath import mp, mpf
from msgspec.structs import replace

from vireport.base.encoding import json_text
from vireport.base.errors import NumericalError
from vireport.base.timing import Machine, Spread
from vireport.figures.captions import alt_text
from vireport.findings.accuracy.benchmark import (
    Benchmark,
    BenchmarkProblem,
    Guess,
    MethodTask,
    SolvedMotion,
    benchmark_of,
)
from vireport.findings.accuracy.figure import error_facts, figure_accuracy
from vireport.findings.accuracy.finding import FINDING
from vireport.findings.accuracy.flights import (
    Budget,
    FlightModel,
    explicit,
    integrated,
    runge_kutta,
    simulated,
)
from vireport.findings.accuracy.methods import (
    CLOSED,
    EXPLICIT,
    METHOD_NAMES,
    METHODS,
    PRINTED,
    RK4,
    SIMULATED,
    SIMULATED_TRANSIENT,
    WHOLE,
    Knob,
    Method,
    find_root,
    settle,
    shoot,
    shoot_critical,
)
from vireport.findings.accuracy.results import AccuracyData, accuracy_data
from vireport.findings.accuracy.tables import measurements, ranking
from vireport.findings.accuracy.workprecision import (
    ACCURACIES,
    MethodRun,
    WorkPrecision,
    compare,
    measure,
)
from vireport.motions.events import Event
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.physics.groups import Groups
from vireport.scenario.loading import load
from vireport.scenario.parameters import Parameter
from vireport.study.checks import reference
from vireport.study.checks.reference import reference_orbit, reference_voltage
from vireport.study.plan import Task
from vireport.study.reading import read_record
from vireport.study.study import analyse
from vireport.text.tables import plain_text

INCLINED = Device(0.1245, 0.5, 9.8, None, 3.0, 2.0, 45.0)
HORIZONTAL = Device(0.1245, 0.5, 9.8, None, 5.0, 2.0, 0.0)
MODEL = FlightModel(Groups(0.4604, 0.1245 * 9.8 * sin(radians(45)) / 3, 0.5), 1)


def length(device: Device, d: float) -> float:
    return d * device.amplitude_n / (4 * device.capsule_mass_kg * device.frequency_hz**2)


def ample() -> Budget:
    return Budget(10_000_000)


@pytest.fixture(scope="module")
def inclined(study_of) -> Benchmark:
    return benchmark_of(study_of("inclined").solution)


def coarse(method: Method) -> Method:
    """A few cheap settings of a method."""
    kept = {Knob.STEPS: 8, Knob.RTOL: 9}.get(method.knob, len(method.settings))
    return replace(method, settings=method.settings[:kept])


@pytest.fixture(scope="module")
def work(inclined) -> WorkPrecision:
    """A few cheap runs of each kind of method, each timed once."""
    return compare(inclined, [coarse(method) for method in METHODS if not method.name.endswith(("Radau", "LSODA"))], 1)


@pytest.fixture(scope="module")
def target() -> BenchmarkProblem:
    """The motion of the paper's Fig. 3 (c)-(d), at the printed d."""
    s = length(INCLINED, 0.4604)
    sweep = Sweep(replace(INCLINED, length_m=s), Parameter.LENGTH, 0.5, 0.8)
    return BenchmarkProblem(sweep, True, None, False, Guess(0.5727, 1.008, 0.589, s))


def test_reference_orbit_has_the_known_digits() -> None:
    orbit = reference_orbit(INCLINED, Parameter.LENGTH, (1.0, 0.57, 0.59, length(INCLINED, 0.4604)))
    known = {"velocity": 1.00400474, "phase": 0.56672469, "q": 0.58606105}
    for name, value in known.items():
        assert abs(getattr(orbit, name) - value) < 1e-8
    with reference.precise():
        state = orbit.velocity, orbit.phase, orbit.q - mpf(1) / 2
        d, gbar = reference.groups(INCLINED, Parameter.LENGTH, orbit.value)
        residuals = reference.periodicity(state, d, gbar, mpf(INCLINED.restitution), INCLINED.period_ratio)
        assert max(map(abs, residuals)) < mpf(10) ** -40


def test_the_error_of_a_phase_is_in_radians_whatever_its_turns(inclined) -> None:
    exact = inclined.exact
    for turns in (-1, 0, 3):
        answer = SolvedMotion(
            float(exact["phase"]) + 2e-3 + 2 * np.pi * turns, float(exact["velocity"]) * 1.001, -0.5, 0.6
        )
        errors = inclined.errors(answer)
        assert errors["phase"] == pytest.approx(2e-3, abs=1e-14)
        assert errors["velocity"] == pytest.approx(1e-3, rel=1e-9)


@pytest.mark.slow
def test_methods_find_a_motion_between_unlike_membranes(example) -> None:
    """Each of its own equations or flights, against 40 digits; with the membranes exchanged none would."""
    over = {"device.restitution": None, "device.restitution_bottom": 0.475, "device.restitution_top": 0.525}
    benchmark = benchmark_of(analyse(load(example("inclined"), over), (Task.JSON,)).solution)
    assert benchmark.point.event is Event.PERIOD_DOUBLING
    named = (CLOSED, WHOLE, PRINTED, EXPLICIT, SIMULATED, SIMULATED_TRANSIENT, "SciPy DOP853")
    finest = [replace(method, settings=method.settings[-1:]) for method in METHODS if method.knob is not Knob.STEPS]
    runs = compare(benchmark, [method for method in finest if method.name in named], 1).runs
    assert len(runs) == 2 * len(named) - 1  # the transient finds no critical point
    for run in runs:
        assert run.error < 1e-12, (run.method, run.task, run.failed)


def test_reference_does_not_depend_on_the_guess() -> None:
    left, right = (
        reference_orbit(INCLINED, Parameter.LENGTH, (*guess, length(INCLINED, 0.4604)))
        for guess in ((1.0, 0.57, 0.59), (1.01, 0.56, 0.58))
    )
    assert abs(left.velocity - right.velocity) < mpf(10) ** -40
    assert abs(left.phase - right.phase) < mpf(10) ** -40


@pytest.mark.parametrize(
    ("device", "kind", "guess", "d"),
    [
        (INCLINED, "period_doubling", (0.95, 0.5, 0.6, 0.42), 0.4179595416),
        (HORIZONTAL, "pitchfork", (0.6, 0.48, 0.5, 0.264), 0.2634315843),
    ],
)
def test_reference_critical_point_has_the_known_digits(device, kind, guess, d) -> None:
    *motion, near = guess
    point = reference_orbit(device, Parameter.LENGTH, (*motion, length(device, near)), kind)
    assert abs(point.value / length(device, 1.0) - d) < 1e-10


def test_reference_refuses_a_guess_that_leads_nowhere() -> None:
    with pytest.raises(NumericalError, match=r"settle|degenerate"):
        reference_orbit(INCLINED, Parameter.LENGTH, (1.0, 0.57, 0.59, length(INCLINED, 50.0)))


def test_reference_voltage_of_a_ball_at_rest_is_zero() -> None:
    membrane = Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041)
    orbit = reference_orbit(INCLINED, Parameter.LENGTH, (1.0, 0.57, 0.59, length(INCLINED, 0.4604)))
    still = replace(orbit, velocity=mpf(0), velocity_top=mpf(0))
    assert abs(reference_voltage(still, membrane)) < mpf(10) ** -40


def test_reference_voltage_has_forty_digits() -> None:
    membrane = Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041)
    orbit = reference_orbit(INCLINED, Parameter.LENGTH, (1.0, 0.57, 0.59, length(INCLINED, 0.4604)))
    with mp.workdps(50):
        volts = []
        for velocity in (orbit.velocity, orbit.velocity_top):
            k, h, rc, rb = (mpf(x) for x in (4.0847e5, 2.6, 6.3e-3, 5.0e-3))
            delta = ((h + 1) * mpf(0.0041) * (orbit.velocity_unit * velocity) ** 2 / (2 * k)) ** (1 / (h + 1))
            alpha = mp.atan2(delta - rb, rc) + mp.atan2(rb, mp.sqrt(rc**2 + (delta - rb) ** 2 - rb**2))
            stretch = 2 * (rb / rc) ** 2 * (1 - mp.cos(alpha)) + (1 - (rb / rc * mp.sin(alpha)) ** 2) / mp.cos(alpha)
            volts.append(2000 * (stretch**2 - 1))
        assert abs(reference_voltage(orbit, membrane) / (sum(volts) / 2) - 1) < mpf(10) ** -40


@pytest.fixture(scope="module")
def exact():
    return reference_orbit(INCLINED, Parameter.LENGTH, (1.0, 0.57, 0.59, length(INCLINED, 0.4604)))


@pytest.mark.parametrize("flight", [explicit, simulated])
def test_exact_flights_find_the_orbit(flight, target, exact) -> None:
    if flight is simulated:
        pytest.importorskip("numba")
    orbit = shoot(flight, target, 1e-10, ample())
    assert abs(orbit.velocity - exact.velocity) < 1e-13
    assert abs(orbit.phase - exact.phase) < 1e-13
    assert abs(orbit.q - exact.q) < 1e-13


def test_newton_on_the_return_map_is_quadratic(target, exact) -> None:
    """The Jacobian is the exact one: each lap doubles the digits."""
    errors = [abs(shoot(explicit, target, stop, ample()).velocity - exact.velocity) for stop in (1e-1, 1e-2, 1e-4)]
    assert errors[1] < 50 * errors[0] ** 2
    assert errors[2] < 1e-14


@pytest.mark.parametrize("name", ["horizontal", "inclined"])
def test_jacobian_of_the_conditions_at_a_critical_point_is_exact(name: str, study_of, monkeypatch) -> None:
    """Against central differences, for a lap and for the half lap of symmetric motions."""
    from vireport.findings.accuracy import methods

    critical = benchmark_of(study_of(name).solution).critical
    conditions = {}
    monkeypatch.setattr(
        methods, "find_root", lambda equations, start, *rest, **more: conditions.update(f=equations) or start
    )
    shoot_critical(explicit, critical, 1e-8, ample())
    guess, unit = critical.guess, critical.guess.value
    x, h = np.array([guess.phase, guess.velocity, guess.value / unit]), 1e-6
    _, matrix = conditions["f"](x)
    for k in range(3):
        ahead, behind = (np.array(conditions["f"](x + sign * h * np.eye(3)[k])[0]) for sign in (1, -1))
        assert matrix[:, k] == pytest.approx((ahead - behind) / (2 * h), rel=1e-6, abs=1e-7)


def test_exact_flights_agree_flight_by_flight() -> None:
    pytest.importorskip("numba")
    for phase in (0.2, 0.5, 0.9, 1.4):
        left, right = (method(0.0).fly(MODEL, 1, 1.3, phase, ample()) for method in (explicit, simulated))
        assert left == pytest.approx(right, rel=0, abs=1e-14)


def test_transient_converges_with_its_tolerance(target, exact) -> None:
    pytest.importorskip("numba")
    errors = [abs(settle(target, 10.0**-k, ample()).velocity - exact.velocity) for k in (4, 7, 10)]
    assert errors[0] > 100 * errors[1] > 1e4 * errors[2]


def test_runge_kutta_is_of_order_four(target, exact) -> None:
    rough, fine = (abs(shoot(runge_kutta, target, steps, ample()).phase - exact.phase) for steps in (32, 128))
    assert 3.7 < float(rough / fine) ** 0.25 < 4.3


def test_a_missed_impact_is_told_from_one_that_is_not_there() -> None:
    # The ball rises beyond the top membrane and is back within a step of a period.
    model = FlightModel(Groups(0.05, 0.9, 0.5), 1)
    with pytest.raises(NumericalError, match="missed the impact at the top"):
        runge_kutta(1.0).fly(model, 1, 1.0, 0.0, ample())
    assert explicit(0.0).fly(model, 1, 1.0, 0.0, ample())[1] < 0
    with pytest.raises(NumericalError, match="returns to the bottom"):
        explicit(0.0).fly(replace(model, groups=model.groups._replace(d=5.0)), 1, 0.1, 0.0, ample())


def test_a_spent_budget_ends_a_method(target) -> None:
    with pytest.raises(NumericalError, match="budget of 100 evaluations"):
        shoot(partial(integrated, "RK45"), target, 1e-9, Budget(100))


@pytest.mark.parametrize("jacobian", [True, False])
def test_the_iteration_refuses_what_has_no_solution(jacobian: bool) -> None:
    def equations(x):
        residual, matrix = [x[0] ** 2 + 0.1, x[1] - x[0]], [[2 * x[0], 0.0], [-1.0, 1.0]]
        return (residual, matrix) if jacobian else residual

    with pytest.raises(NumericalError, match="did not settle"):
        find_root(equations, [0.4, 0.3], 1e-8, 1e-13, jacobian)


@pytest.mark.slow
def test_closed_form_reaches_rounding(work) -> None:
    for name in (CLOSED, WHOLE, PRINTED):
        for task in MethodTask:
            least = min(run.error for run in work.runs_of(name, task))
            assert least < 1e-13, (name, task)


@pytest.mark.slow
def test_every_quantity_has_an_error_in_every_good_run(work) -> None:
    for run in work.runs:
        keys = {quantity.key for quantity in work.quantities if quantity.task == run.task}
        assert run.failed or set(run.errors) == keys
        assert run.failed or all(isfinite(error) for error in run.errors.values())
    assert {quantity.key for quantity in work.quantities} == {"velocity", "phase", "voltage", "critical"}


@pytest.mark.slow
@pytest.mark.parametrize("method", [RK4, "SciPy RK45", "SciPy DOP853"])
def test_finer_settings_are_more_accurate(work, method: str) -> None:
    errors = [run.error for run in work.runs_of(method, MethodTask.ORBIT)][::4]
    assert len(errors) > 1
    assert all(fine < coarse for coarse, fine in pairwise(errors))


@pytest.mark.slow
def test_fitted_orders_are_those_of_theory(work) -> None:
    orders = {(order.method, order.task, order.against): order for order in work.orders}
    for task in MethodTask:
        measured = orders[RK4, task, "step"]
        assert measured.theory == (4.0,)
        assert measured.fitted == pytest.approx(4.0, abs=0.5)
    assert orders[SIMULATED_TRANSIENT, "orbit", "tolerance"].fitted == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_errors_and_counts_do_not_change_from_run_to_run(inclined) -> None:
    some = [
        replace(method, settings=method.settings[:2])
        for method in METHODS
        if method.name in (CLOSED, EXPLICIT, "SciPy LSODA")
    ]
    left, right = (
        [(run.errors, run.evaluations, run.failed) for run in compare(inclined, some, 1).runs] for _ in range(2)
    )
    assert left == right


def test_failures_are_shown(inclined) -> None:
    def missing(target: BenchmarkProblem, setting: float, budget: Budget):
        raise NumericalError("missed the impact at the top")

    def wrong(target: BenchmarkProblem, setting: float, budget: Budget) -> float:
        return 2.0 * target.guess.value

    def spending(target: BenchmarkProblem, setting: float, budget: Budget):
        budget.spend(11)

    failing = Method("SciPy RK45", Knob.RTOL, (1e-3, 1e-6), missing, wrong, 10)

    def fast(target: BenchmarkProblem, setting: float, budget: Budget) -> SolvedMotion:
        exact = {name: float(value) for name, value in inclined.exact.items()}
        return SolvedMotion(exact["phase"], 2 * exact["velocity"], -0.5, 0.6)

    two = Method("SciPy Radau", Knob.RTOL, (1e-3, 1e-6), spending, None, 10)
    three = Method("SciPy LSODA", Knob.RTOL, (1e-3,), fast, None, 10)
    work = compare(inclined, (failing, two, three), 1)
    reasons = [run.failed for run in work.runs]
    assert reasons[:2] == ["missed the impact at the top"] * 2
    assert all("found something else" in reason for reason in reasons[2:4])
    assert reasons[4:6] == ["budget of 10 evaluations reached", "not tried: a coarser setting spent the budget"]
    assert "found something else, 1 away" in reasons[6]
    assert work.fastest("orbit", 1e-6) == inf
    assert "missed the impact at the top" in plain_text((*measurements(work, every=True), *ranking(work)))
    figure_accuracy(work)


def test_the_fastest_run_that_is_accurate_enough() -> None:
    runs = tuple(
        MethodRun(method, Knob.RTOL, 1e-3, MethodTask.ORBIT, {"phase": error}, Spread(time, time, time), 1)
        for method, error, time in (
            ("a", 1e-7, 2.0), ("a", 1e-10, 6.0), ("b", 1e-8, 4.0), ("c", 1e-3, 1.0), (WHOLE, 0.0, 0.1)
        )
    )  # fmt: skip
    study = WorkPrecision("", None, runs, (), (), Machine("", 1, "", "", ()), 1)
    assert [study.fastest("orbit", accuracy) for accuracy in (1e-6, 1e-9, 1e-12)] == [2.0, 6.0, inf]
    assert study.best("b", "orbit", 1e-9) is None
    assert study.best("a", "orbit", 1e-6).error == 1e-7


def test_a_time_is_drawn_from_quartile_to_quartile(inclined) -> None:
    errors = dict.fromkeys(("velocity", "phase", "voltage"), 1e-7)
    run = MethodRun(WHOLE, Knob.RTOL, 1e-3, MethodTask.ORBIT, errors, Spread(2.0, 1.0, 6.0), 1)
    figure = figure_accuracy(WorkPrecision("", inclined, (run,), (), (), Machine("", 1, "", "", ()), 1))
    bars = figure.axes[0].containers[0][2]
    assert bars[0].get_segments()[0].tolist() == [[1.0, 1e-7], [6.0, 1e-7]]


@pytest.mark.slow
def test_report_and_figure_name_every_method(work) -> None:
    tables = {table.caption: table for table in (*measurements(work), *ranking(work))}
    methods = {run.method for run in work.runs}
    assert methods == {*METHOD_NAMES} - {"SciPy Radau", "SciPy LSODA"}
    assert {row[0] for row in tables["Time to an accuracy: the motion"].rows} == methods
    assert {row[0] for row in tables["Time to an accuracy: B1 (period doubling)"].rows} == methods - {
        SIMULATED_TRANSIENT
    }
    for table in tables.values():
        assert all(len(row) == len(table.columns) for row in table.rows)
    factors = tables["Times over that of the fastest method"]
    assert {row[0] for row in factors.rows} == methods
    assert all("1" in column for column in list(zip(*factors.rows, strict=True))[1 : len(ACCURACIES)])
    _, step = FINDING.steps()
    assert all(method in alt_text(step.task, error_facts(work)) for method in methods)
    assert len(figure_accuracy(work).axes) == len(work.quantities)


@pytest.mark.slow
def test_what_is_not_installed_is_left_out_with_the_reason(inclined, monkeypatch) -> None:
    monkeypatch.setattr("vireport.findings.accuracy.workprecision.find_spec", lambda name: None)
    some = [replace(method, settings=method.settings[:1]) for method in METHODS[:6]]
    work = compare(inclined, some, 1)
    assert {run.method for run in work.runs} == {CLOSED, WHOLE, PRINTED, EXPLICIT}
    assert {untried.method for untried in work.absent} == {SIMULATED, SIMULATED_TRANSIENT}
    assert all("pip install 'vireport[" in untried.why for untried in work.absent)
    assert "not tried: needs the package numba" in plain_text(ranking(work))


def test_nothing_to_compare_is_said(tmp_path) -> None:
    from vireport import analyse, load

    scenario = tmp_path / "none.yaml"
    scenario.write_text(
        "schema_version: 1\ndevice: {capsule_mass_kg: 0.1245, restitution: 0.5}\n"
        "excitation: {amplitude_n: 3.0, frequency_hz: 2.0}\ninclination_deg: 45.0\n"
        "sweep: {parameter: length_m, from: 0.3, to: 0.35}\n",
        encoding="utf-8",
    )
    work = measure(analyse(load(scenario)).solution, 1)
    assert work.nothing
    assert work.runs == ()
    assert "no stable" in work.nothing
    assert not list(measurements(work))
    assert not list(ranking(work))


@pytest.mark.parametrize(("spread", "busy"), [(0.05, False), (0.5, True)])
def test_a_busy_machine_is_told_by_the_spread_of_the_repeats(work, spread: float, busy: bool) -> None:
    runs = tuple(
        replace(run, seconds=None if k % 3 == 0 else Spread(t := 1e-3 * k, t * (1 - spread / 2), t * (1 + spread / 2)))
        for k, run in enumerate(work.runs)
    )
    told = replace(work, runs=runs)
    assert told.unsteadiness == pytest.approx(spread)
    assert told.busy is busy
    data = read_record(json.loads(json_text(accuracy_data(told))), AccuracyData, "accuracy.json", "accuracy")
    assert (data.busy, data.unsteadiness) == (busy, told.unsteadiness)
    assert [run.errors for run in data.runs] == [run.errors for run in work.runs]
    once = replace(work, runs=tuple(replace(run, seconds=Spread(2.0, 2.0, 2.0)) for run in work.runs))
    assert (once.unsteadiness, once.busy) == (None, False)
