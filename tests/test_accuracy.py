"""The accuracy study: its reference against published digits, its methods against their orders, its failures shown."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import isfinite, radians, sin

import pytest
from mpmath import mp, mpf

from vireport import reference
from vireport.errors import NumericalError
from vireport.figures.accuracy import figure_accuracy, words
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.reference import reference_critical, reference_orbit, reference_voltage
from vireport.report.accuracy import accuracy
from vireport.scenario.parameters import Parameter
from vireport.trust import accuracy_text
from vireport.trust.contenders import (
    CLOSED,
    EXPLICIT,
    NAMES,
    PRINTED,
    RK4,
    SETTLING,
    SIMULATED,
    WHOLE,
    Contender,
    contenders,
)
from vireport.trust.integrators import Budget, Case, LeftMotion, explicit, integrated, runge_kutta, simulated
from vireport.trust.methods import settle, shoot
from vireport.trust.quasinewton import quasi_newton
from vireport.trust.timing import Machine, Spread
from vireport.trust.workprecision import ACCURACIES, MethodRun, WorkPrecision, compare
from vireport.trust.yardstick import yardstick

pytest.importorskip("scipy")

INCLINED = Device(0.1245, 0.5, 9.8, None, 3.0, 2.0, 45.0)
HORIZONTAL = Device(0.1245, 0.5, 9.8, None, 5.0, 2.0, 0.0)
CASE = Case(0.4604, 0.1245 * 9.8 * sin(radians(45)) / 3, 0.5, 1)
GUESS = (0.5727, 1.008)


def length(device: Device, d: float) -> float:
    return d * device.amplitude_n / (4 * device.capsule_mass_kg * device.frequency_hz**2)


def ample() -> Budget:
    return Budget(10_000_000)


@pytest.fixture(scope="module")
def inclined(study_of):
    solution = study_of("inclined").solution
    stick = yardstick(solution)
    return stick, contenders(solution, stick.orbit, stick.critical, stick.point.label)[0]


@pytest.fixture(scope="module")
def work(inclined) -> WorkPrecision:
    """A few cheap runs of each kind of method, each timed once."""
    stick, tried = inclined
    kept = {RK4: (2, 4, 5, 6), "SciPy RK45": (0, 2, 4), "SciPy DOP853": (0, 2, 4)}
    chosen = [
        replace(one, settings=tuple(one.settings[k] for k in kept.get(one.name, range(len(one.settings)))))
        for one in tried
        if not one.name.endswith(("Radau", "LSODA"))
    ]
    return compare(stick, chosen, (("SciPy Radau", "left out"),), 1)


def test_reference_orbit_has_the_known_digits() -> None:
    orbit = reference_orbit(INCLINED, Parameter.LENGTH, length(INCLINED, 0.4604), (1.0, 0.57, 0.59))
    known = {"velocity": 1.00400474, "phase": 0.56672469, "q": 0.58606105}
    for name, value in known.items():
        assert abs(getattr(orbit, name) - value) < 1e-8
    with reference.precise():
        state = orbit.velocity, orbit.phase, orbit.q - mpf(1) / 2
        d, gbar = reference.groups(INCLINED, Parameter.LENGTH, orbit.value)
        residuals = reference.periodicity(state, d, gbar, mpf(INCLINED.restitution), INCLINED.period_ratio)
        assert max(map(abs, residuals)) < mpf(10) ** -40


def test_reference_does_not_depend_on_the_guess() -> None:
    one, two = (
        reference_orbit(INCLINED, Parameter.LENGTH, length(INCLINED, 0.4604), guess)
        for guess in ((1.0, 0.57, 0.59), (1.01, 0.56, 0.58))
    )
    assert abs(one.velocity - two.velocity) < mpf(10) ** -40
    assert abs(one.phase - two.phase) < mpf(10) ** -40


@pytest.mark.parametrize(
    ("device", "kind", "guess", "d"),
    [
        (INCLINED, "period_doubling", (0.95, 0.5, 0.6, 0.42), 0.4179595416),
        (HORIZONTAL, "pitchfork", (0.6, 0.48, 0.5, 0.264), 0.2634315843),
    ],
)
def test_reference_critical_point_has_the_known_digits(device, kind, guess, d) -> None:
    *motion, near = guess
    point = reference_critical(device, Parameter.LENGTH, kind, (*motion, length(device, near)))
    assert abs(point.value / length(device, 1.0) - d) < 1e-10


def test_reference_refuses_a_guess_that_leads_nowhere() -> None:
    with pytest.raises(NumericalError, match=r"settle|degenerate"):
        reference_orbit(INCLINED, Parameter.LENGTH, length(INCLINED, 50.0), (1.0, 0.57, 0.59))


def test_reference_voltage_of_a_ball_at_rest_is_zero() -> None:
    membrane = Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041)
    orbit = reference_orbit(INCLINED, Parameter.LENGTH, length(INCLINED, 0.4604), (1.0, 0.57, 0.59))
    still = replace(orbit, velocity=mpf(0), velocity_top=mpf(0))
    assert abs(reference_voltage(still, membrane)) < mpf(10) ** -40


def test_reference_voltage_has_forty_digits() -> None:
    membrane = Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041)
    orbit = reference_orbit(INCLINED, Parameter.LENGTH, length(INCLINED, 0.4604), (1.0, 0.57, 0.59))
    with mp.workdps(50):
        volts = []
        for velocity in (orbit.velocity, orbit.velocity_top):
            k, h, rc, rb = (mpf(x) for x in (4.0847e5, 2.6, 6.3e-3, 5.0e-3))
            delta = ((h + 1) * mpf(0.0041) * (orbit.velocity_unit * velocity) ** 2 / (2 * k)) ** (1 / (h + 1))
            alpha = mp.atan2(delta - rb, rc) + mp.atan2(rb, mp.sqrt(rc**2 + (delta - rb) ** 2 - rb**2))
            stretch = 2 * (rb / rc) ** 2 * (1 - mp.cos(alpha)) + (1 - (rb / rc * mp.sin(alpha)) ** 2) / mp.cos(alpha)
            volts.append(2000 * (stretch**2 - 1))
        assert abs(reference_voltage(orbit, membrane) / (sum(volts) / 2) - 1) < mpf(10) ** -40


@pytest.mark.parametrize("flight", [explicit, simulated])
def test_exact_flights_find_the_orbit(flight) -> None:
    if flight is simulated:
        pytest.importorskip("numba")
    found = shoot(flight(1e-15), CASE, GUESS, ample())
    exact = reference_orbit(INCLINED, Parameter.LENGTH, length(INCLINED, 0.4604), (1.0, 0.57, 0.59))
    assert abs(found.velocity - exact.velocity) < 1e-13
    assert abs(found.phase - exact.phase) < 1e-13
    assert abs(found.q - exact.q) < 1e-13


def test_exact_flights_agree_flight_by_flight() -> None:
    pytest.importorskip("numba")
    for phase in (0.2, 0.5, 0.9, 1.4):
        one, two = (method(0.0).fly(CASE, 1, 1.3, phase, ample()) for method in (explicit, simulated))
        assert one == pytest.approx(two, rel=0, abs=1e-14)


def test_transient_converges_with_its_tolerance() -> None:
    pytest.importorskip("numba")
    exact = shoot(explicit(1e-15), CASE, GUESS, ample())
    errors = [abs(settle(CASE, GUESS, 10.0**-k, ample()).velocity - exact.velocity) for k in (4, 7, 10)]
    assert errors[0] > 100 * errors[1] > 1e4 * errors[2]


def test_runge_kutta_is_of_order_four() -> None:
    exact = shoot(explicit(1e-15), CASE, GUESS, ample())
    coarse, fine = (abs(shoot(runge_kutta(k), CASE, GUESS, ample()).phase - exact.phase) for k in (32, 128))
    assert 3.7 < (coarse / fine) ** 0.5 / 2**0.0 / 4.0 < 4.6


def test_a_missed_impact_is_told_from_one_that_is_not_there() -> None:
    # The ball rises beyond the top membrane and is back within a step of a period.
    case = Case(0.05, 0.9, 0.5, 1)
    with pytest.raises(NumericalError, match="missed the impact at the top") as caught:
        runge_kutta(1.0).fly(case, 1, 1.0, 0.0, ample())
    assert not isinstance(caught.value, LeftMotion)
    assert explicit(0.0).fly(case, 1, 1.0, 0.0, ample())[1] < 0
    with pytest.raises(LeftMotion, match="returns to the bottom"):
        explicit(0.0).fly(replace(case, d=5.0), 1, 0.1, 0.0, ample())


def test_a_spent_budget_ends_a_method() -> None:
    with pytest.raises(NumericalError, match="budget of 100 evaluations"):
        shoot(integrated("RK45")(1e-9), CASE, GUESS, Budget(100))


def test_the_iteration_knows_no_units() -> None:
    def residual(scale):
        return lambda x: [scale * (x[0] ** 2 + x[1] - 0.3), x[0] - 0.5 * x[1] - 0.1]

    one, two = (quasi_newton(residual(scale), [0.4, 0.3], 1e-7, 1e-13, 1e-13) for scale in (1.0, 1e3))
    assert one == pytest.approx(two, rel=0, abs=1e-12)
    assert residual(1.0)(one) == pytest.approx([0.0, 0.0], abs=1e-13)


def test_the_iteration_refuses_a_singular_problem() -> None:
    with pytest.raises(NumericalError, match="singular"):
        quasi_newton(lambda x: [1.0, x[0]], [0.4, 0.3], 1e-7, 1e-13, 1e-13)


def test_closed_form_reaches_rounding(work) -> None:
    for name in (CLOSED, WHOLE, PRINTED):
        for task in ("orbit", "critical"):
            least = min(run.error for run in work.runs if (run.method, run.task) == (name, task))
            assert least < 1e-13, (name, task)


def test_every_quantity_has_an_error_in_every_good_run(work) -> None:
    for run in work.runs:
        keys = {one.key for one in work.quantities if one.task == run.task}
        assert run.failed or set(run.errors) == keys
        assert run.failed or all(isfinite(error) for error in run.errors.values())
    assert {one.key for one in work.quantities} == {"velocity", "phase", "voltage", "critical"}


@pytest.mark.parametrize("method", [RK4, "SciPy RK45", "SciPy DOP853"])
def test_finer_settings_are_more_accurate(work, method: str) -> None:
    errors = [run.error for run in work.runs if (run.method, run.task) == (method, "orbit")]
    assert all(fine < coarse for coarse, fine in pairwise(errors))


def test_fitted_orders_are_those_of_theory(work) -> None:
    orders = {(one.method, one.task, one.against): one for one in work.orders}
    for task in ("orbit", "critical"):
        one = orders[RK4, task, "step"]
        assert one.theory == (4.0,)
        assert one.fitted == pytest.approx(4.0, abs=0.5)
    assert orders[SETTLING, "orbit", "tolerance"].fitted == pytest.approx(1.0, abs=0.1)


def test_errors_and_counts_do_not_change_from_run_to_run(inclined) -> None:
    stick, tried = inclined
    some = [replace(one, settings=one.settings[:2]) for one in tried if one.name in (CLOSED, EXPLICIT, "SciPy LSODA")]
    one, two = (compare(stick, some, (), 1) for _ in range(2))
    told = [[(run.errors, run.evaluations, run.failed) for run in each.runs] for each in (one, two)]
    assert told[0] == told[1]


def test_failures_are_shown(inclined) -> None:
    stick, _ = inclined

    def missing(setting: float, budget: Budget):
        raise NumericalError("missed the impact at the top")

    def wrong(setting: float, budget: Budget) -> float:
        return 2.0 * stick.critical.guess.value

    def spending(setting: float, budget: Budget):
        budget.spend(11)

    one = Contender("SciPy RK45", "rtol", (1e-3, 1e-6), missing, wrong, 10)
    two = Contender("SciPy Radau", "rtol", (1e-3, 1e-6), spending, None, 10)
    found = compare(stick, (one, two), (), 1)
    reasons = [row[-1] for row in accuracy_text.failures(found)]
    assert reasons[:2] == ["missed the impact at the top"] * 2
    assert all("found something else" in reason for reason in reasons[2:4])
    assert reasons[4:] == ["budget of 10 evaluations reached", "not tried: a coarser setting spent the budget"]
    assert all(one.method == "" for one in found.fastest(1e-6))
    assert "missed the impact at the top" in accuracy_text.plain(found, every=True)
    figure_accuracy(found)


def ranked(*runs: tuple[str, float, float]) -> WorkPrecision:
    """A study of runs of given method, error and time."""
    made = tuple(MethodRun(m, "rtol", 1e-3, "orbit", {"phase": e}, Spread(t, t, t), 1) for m, e, t in runs)
    return WorkPrecision("", None, made, (), (), Machine("", 1, "", "", ()), 1)


def test_the_soonest_method_and_its_factors(inclined) -> None:
    stick, _ = inclined
    orbit_only = replace(stick, quantities=stick.quantities[:1])
    study = replace(
        ranked(("a", 1e-7, 2.0), ("a", 1e-10, 6.0), ("b", 1e-8, 4.0), ("c", 1e-3, 1.0), (WHOLE, 0.0, 0.1)),
        yardstick=orbit_only,
    )
    (coarse,), (fine,) = study.fastest(1e-6), study.fastest(1e-9)
    assert (coarse.method, coarse.factors, coarse.short) == ("a", (("b", 2.0),), ("c",))
    assert (fine.method, fine.factors, fine.short) == ("a", (), ("b", "c"))


def test_report_and_figure_name_every_method(work) -> None:
    blocks = list(accuracy(work))
    tables = {block.caption: block for block in blocks if block.kind == "table"}
    methods = {run.method for run in work.runs}
    assert methods == {CLOSED, WHOLE, PRINTED, EXPLICIT, SIMULATED, SETTLING, RK4, "SciPy RK45", "SciPy DOP853"} & {
        *NAMES
    }
    assert {row[0] for row in tables["Time to an accuracy: the motion"].rows} == methods
    assert {row[0] for row in tables["Time to an accuracy: B1 (period doubling)"].rows} == methods - {SETTLING}
    for table in tables.values():
        assert all(len(row) == len(table.columns) for row in table.rows)
    said = " ".join(block.text for block in blocks if block.kind == "paragraph")
    assert said.count("soonest by") == 2 * len(ACCURACIES)
    assert "only numbers of this section that differ from run to run" in said
    assert "SciPy Radau" in " ".join(row[0] for row in tables["Runs that failed"].rows)
    assert all(method in words(work)[3] for method in methods)
    assert len(figure_accuracy(work).axes) == len(work.quantities)


def test_what_is_not_installed_is_left_out_with_the_reason(inclined, monkeypatch) -> None:
    import sys

    from vireport.trust import contenders as module

    stick, _ = inclined
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    monkeypatch.setitem(sys.modules, "scipy.integrate", None)
    tried, absent = contenders(stick.solution, stick.orbit, stick.critical, "B1")
    assert {one.name for one in tried} == {CLOSED, WHOLE, PRINTED, EXPLICIT, RK4}
    assert {name for name, _ in absent} == set(NAMES) - {one.name for one in tried}
    assert all("pip install 'vireport[" in reason for _, reason in absent)
    monkeypatch.setitem(sys.modules, "mpmath", None)
    monkeypatch.delitem(sys.modules, "vireport.reference")
    with pytest.raises(NumericalError, match=r"mpmath: pip install 'vireport\[accuracy\]'"):
        yardstick(stick.solution)


def test_nothing_to_compare_is_said(tmp_path) -> None:
    from vireport import analyse, load
    from vireport.trust.workprecision import measure

    scenario = tmp_path / "none.yaml"
    scenario.write_text(
        "schema_version: 1\ndevice: {capsule_mass_kg: 0.1245, restitution: 0.5}\n"
        "excitation: {amplitude_n: 3.0, frequency_hz: 2.0}\ninclination_deg: 45.0\n"
        "sweep: {parameter: length_m, from: 0.3, to: 0.35}\n",
        encoding="utf-8",
    )
    found = measure(analyse(load(scenario)).solution, 1)
    assert found.nothing
    assert found.runs == ()
    assert "no stable" in accuracy_text.plain(found)
    assert [block.kind for block in accuracy(found)] == ["paragraph"]
