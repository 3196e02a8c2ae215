"""Proved critical points: against 40-digit arithmetic and the published digits, and nothing proved that is not so."""

from __future__ import annotations

import json
from decimal import Decimal

import numpy as np
import pytest
from conftest import first
from mpmath import mpf
from msgspec.structs import replace
from pages import Page
from strategies import random_sweeps

from vireport import analyse, load, loads
from vireport.base.encoding import json_text
from vireport.motions.diagram import solve
from vireport.motions.events import CRITICAL, Event
from vireport.motions.orbits import orbits
from vireport.scenario.parameters import Parameter
from vireport.study.checks import reference
from vireport.study.checks.forty_digits import critical_motion

pytest.importorskip("flint")

from flint import arb
from pages import render_html

from vireport.findings.certificates.finding import certify_text
from vireport.findings.certificates.proofs import certify, certify_point
from vireport.findings.certificates.results import Certificate
from vireport.report.context import Report
from vireport.study.checks.confinement import stays_between
from vireport.study.checks.enclosures import (
    BallOps,
    ball,
    precision,
)
from vireport.study.provenance import provenance_of
from vireport.study.reading import read_record

pytestmark = pytest.mark.usefixtures("forty_digits")

NARROW = Decimal("1e-20")
SCENARIOS = {
    "horizontal": ("horizontal", []),
    "inclined": ("inclined", []),
    "forcing": ("inclined-forcing", []),
    "frequency": ("inclined", ["sweep.parameter=frequency_hz", "sweep.from=1.5", "sweep.to=3"]),
    "inclination": (
        "inclined",
        ["sweep.parameter=inclination_deg", "sweep.from=0", "sweep.to=90", "device.length_m=0.4"],
    ),
    "two periods": ("inclined", ["period_ratio=2", "sweep.from=0.3", "sweep.to=3"]),
    "three periods, horizontal": ("horizontal", ["period_ratio=3", "sweep.from=0.4", "sweep.to=3"]),
    "nearly horizontal": ("inclined", ["inclination_deg=1e-10", "sweep.from=0.1", "sweep.to=3"]),
    "no restitution": ("inclined", ["device.restitution=0", "sweep.from=0.01", "sweep.to=5"]),
    "hardly any restitution": ("inclined", ["device.restitution=1e-9", "sweep.from=0.01", "sweep.to=5"]),
}


@pytest.fixture(scope="module")
def case(example):
    cases: dict[str, object] = {}

    def get(name: str):
        if name not in cases:
            file, overrides = SCENARIOS[name]
            study = analyse(loads(example(file).read_text(), overrides=overrides))
            cases[name] = study, certify(study.solution.diagram)
        return cases[name]

    return get


def contains(bounds, value) -> bool:
    return mpf(bounds[0]) <= value <= mpf(bounds[1])


@pytest.mark.parametrize("name", first(2, SCENARIOS))
def test_every_critical_point_is_proved(case, name: str) -> None:
    study, certificates = case(name)
    assert [c.label for c in certificates] == [p.label for p in study.solution.critical_points]
    assert certificates
    for certificate, critical in zip(certificates, study.solution.critical_points, strict=True):
        assert certificate.proved, certificate
        assert not certificate.beyond or critical.rest is not None
        assert certificate.bound_holds
        assert certificate.admissible is True
        assert certificate.mirror_proved is not False
        for name in ("sweep_value", "d", "gbar", "q", "phi_bottom_rad", "velocity_bottom"):
            low, high = map(Decimal, getattr(certificate, name))
            assert 0 <= high - low < NARROW * max(1, abs(high))


@pytest.mark.parametrize("name", first(4, [name for name in SCENARIOS if name != "no restitution"]))
def test_enclosures_hold_the_values_of_40_digits(case, name: str) -> None:
    study, certificates = case(name)
    for certificate, critical in zip(certificates, study.solution.critical_points, strict=True):
        if critical.event == "node_focus" and study.solution.device.restitution < 1e-6:
            continue  # the reference does not tell the ends of so short a range of foci apart
        value = critical_motion(critical, study.solution.sweep.device, study.solution.sweep.parameter)[3]
        assert contains(certificate.sweep_value, value), certificate
        d, gbar = reference.groups(study.solution.device, study.solution.sweep.parameter, value)
        # The reference's own rounding, and what Newton's method has left.
        room = mpf(10) ** -30
        assert mpf(certificate.d[0]) - room <= d <= mpf(certificate.d[1]) + room
        assert mpf(certificate.gbar[0]) - room <= gbar <= mpf(certificate.gbar[1]) + room


PUBLISHED = {
    ("inclined", "B1"): ".4179595416",
    ("forcing", "B1"): ".2792918143",
    ("horizontal", "C1"): ".2634315843",
    ("horizontal", "A1"): ".2079356188",
    ("horizontal", "A2"): ".2438848418",
    ("horizontal", "A3"): ".3100633410",
    ("horizontal", "B1"): ".1870532313",
}


@pytest.mark.parametrize(("place", "digits"), PUBLISHED.items())
def test_enclosures_hold_the_published_digits(case, place: tuple[str, str], digits: str) -> None:
    certificate = next(c for c in case(place[0])[1] if c.label == place[1])
    for bound in certificate.d:
        assert round(Decimal(bound), 10) == Decimal(f"0{digits}")


@pytest.mark.slow
@pytest.mark.parametrize("count", first(1, [6, 24]))
def test_random_sweeps_are_proved(count: int) -> None:
    proved = 0
    for sweep in random_sweeps(count, seed=99):
        solution = solve(sweep)
        for critical in solution.critical_points:
            certificate = certify_point(sweep, critical)
            assert certificate.proved or certificate.reason, (sweep, critical)
            if certificate.proved:
                proved += 1
                assert certificate.bound_holds
                assert contains(certificate.sweep_value, critical_motion(critical, sweep.device, sweep.parameter)[3]), (
                    sweep,
                    critical,
                )
    assert proved > 5 * count / 4


@pytest.mark.parametrize("name", first(3, ["horizontal", "inclined", "forcing", "two periods"]))
@pytest.mark.parametrize("moved", ["u", "phi_bottom"])
def test_a_wrong_point_is_not_proved_at_its_place(case, name: str, moved: str) -> None:
    study, _ = case(name)
    for critical in study.solution.critical_points:
        if moved == "u" and critical.symmetry == "symmetric":
            continue  # there q = 1/2 is known, and no unknown
        wrong = replace(critical.closed, **{moved: getattr(critical.closed, moved) + 1e-6})
        certificate = certify_point(study.solution.sweep, replace(critical, one_to_one=wrong, mirror=None))
        assert not certificate.proved
        assert certificate.reason
        assert certificate.sweep_value is None


@pytest.mark.parametrize("name", ["horizontal", "inclined", "frequency"])
def test_a_false_condition_is_not_proved(case, name: str) -> None:
    study, _ = case(name)
    for critical in study.solution.critical_points:
        for event in set(CRITICAL) - {Event.PITCHFORK, Event.STOP, critical.event}:
            if critical.event is Event.PITCHFORK and event is Event.FOLD:
                continue  # one condition
            certificate = certify_point(study.solution.sweep, replace(critical, event=event, mirror=None))
            assert not certificate.proved, (critical, event)


def test_a_false_error_bound_is_found_out(case) -> None:
    study, _ = case("inclined")
    critical = study.solution.critical_points[0]
    beside = replace(critical, sweep_value=critical.sweep_value * (1 + 1e-12))
    certificate = certify_point(study.solution.sweep, beside)
    assert certificate.proved
    assert not certificate.bound_holds
    assert "but the error bound stated is not proved to hold for B1" in certify_text((certificate,), Parameter.LENGTH)
    certificate = certify_point(study.solution.sweep, replace(critical, d=critical.d * (1 + 1e-12)))
    assert certificate.beyond == ("d",)
    assert "B1 (d)" in certify_text((certificate,), Parameter.LENGTH)
    tight = replace(critical, error_bound=1e-20)
    assert not certify_point(study.solution.sweep, tight).bound_holds


def test_a_mirror_image_that_is_none_is_found_out(case) -> None:
    study, _ = case("horizontal")
    critical = next(p for p in study.solution.critical_points if p.mirror is not None)
    wrong = replace(critical.mirror, one_to_one=replace(critical.mirror.closed, u=-0.99 * critical.closed.u))
    assert certify_point(study.solution.sweep, replace(critical, mirror=wrong)).mirror_proved is False


@pytest.mark.slow
def test_the_side_is_that_of_the_branch(case) -> None:
    # The type of motion beside a critical point, from the samples of its branch.
    for name in ("horizontal", "inclined", "forcing", "frequency", "inclination", "two periods"):
        study, certificates = case(name)
        checked = 0
        for certificate in certificates:
            if certificate.kind in ("fold", "grazing"):
                assert certificate.side == ""
                continue
            word, place = certificate.side.split()
            for branch in study.solution.branches:
                m, rows = branch.motions, {point.label: row for row, point in branch.family.critical_points.items()}
                row = rows.get(certificate.label, 0)
                if row in (0, len(m) - 1):
                    continue
                for beside in (row - 1, row + 1):
                    above = bool(m.sweep_value[beside] > m.sweep_value[row])
                    inside = word in m.words[beside].replace("unstable", "")
                    assert inside == (above == (place == "above")), (name, certificate.label)
                    checked += 1
        assert checked


def test_neglected_gravity_is_said(example) -> None:
    study = analyse(load(example("inclined")))
    sweep = replace(study.solution.sweep, start=0.2, device=replace(study.solution.device, inclination_deg=1e-14))
    points = solve(sweep).critical_points
    assert points
    for certificate in (certify_point(sweep, point) for point in points):
        assert not certificate.proved
        assert "gravity" in certificate.reason


def test_nothing_to_prove_without_a_sweep(example) -> None:
    assert certify(analyse(load(example("design-point"))).solution.diagram) == ()


@pytest.mark.slow
def test_a_touch_that_coincides_with_others_is_left_undecided(example) -> None:
    # For three periods and no gravity a ball that leaves at rest comes back to rest at the walls each half period.
    text = example("horizontal").read_text()
    study = analyse(loads(text, overrides=["period_ratio=3", "sweep.from=0.2", "sweep.to=0.4"]))
    undecided = [c.admissible for c in certify(study.solution.diagram)]
    assert None in undecided
    assert "undecided" in certify_text(certify(study.solution.diagram), Parameter.LENGTH)


def test_motions_through_a_membrane_are_proved_to_be_none(example) -> None:
    # At 45 degrees a branch with |lambda| < 1 and 0.04 < d < 0.124 passes through the membrane.
    study = analyse(loads(example("inclined").read_text(), overrides=["sweep.from=0.05", "sweep.to=0.75"]))
    decided = {True: 0, False: 0}
    with precision(128):
        ops, r = BallOps(), ball(study.solution.device.restitution)
        for branch in study.solution.branches:
            m, marked = branch.motions, {mark.row for mark in branch.family.marks}
            for row in range(1, len(m) - 1, 5):
                if row in marked:
                    continue
                orbit = orbits(arb(float(m.q[row])) - 0.5, arb(float(m.phi_bottom[row])), r, 1, ops)
                proofs = [stays_between(way, None) for way in orbit.flights(r)]
                assert None not in proofs
                assert all(proofs) == bool(m.admissible_mask[row]), (branch.number, row)
                decided[all(proofs)] += 1
    assert min(decided.values()) > 10


def test_what_is_told_of_it(case) -> None:
    _, certificates = case("horizontal")
    text = certify_text(certificates, Parameter.LENGTH)
    assert "B1" in text
    assert "7 of 7 critical points proved" in text
    (first, *_) = json.loads(json_text(certificates))
    assert read_record(first, Certificate, "results.json", "certificates[0]").sweep_value == certificates[0].sweep_value
    failed = replace(certificates[0], proved=False, reason="it is degenerate", sweep_value=None)
    assert "not proved: it is degenerate" in certify_text((failed,), Parameter.LENGTH)


def test_what_the_report_says_of_it(case, study_of) -> None:
    _, certificates = case("horizontal")
    failed = replace(certificates[0], proved=False, reason="it is degenerate", sweep_value=None)
    study = replace(study_of("horizontal"), findings={"certificates": (failed, *certificates[1:])})
    page = Page(render_html(Report(study, {}, provenance_of(study.loaded, "test"))))
    assert page.tables["Critical points without a proof"].rows[1:] == [["G1", "grazing", "it is degenerate"]]
    proved = page.tables["Proved critical points"].rows[1:]
    assert [row[0] for row in proved] == [certificate.label for certificate in certificates[1:]]
    assert len(page.tables["Enclosures of the motions at the critical points"].rows) == 1 + 4 * len(proved)


def test_enclosures_hold_the_motion_of_40_digits(case) -> None:
    # Velocity, phase and q of the period doubling, from the printed maps alone.
    study, certificates = case("inclined")
    velocity, phase, u, _ = critical_motion(
        study.solution.critical_points[0], study.solution.sweep.device, study.solution.sweep.parameter
    )
    assert contains(certificates[0].velocity_bottom, velocity)
    assert contains(certificates[0].phi_bottom_rad, phase)
    assert contains(certificates[0].q, u + mpf(1) / 2)


def test_a_motion_of_the_wrong_direction_is_not_proved(case) -> None:
    # Half a period later, the equations hold with d and both velocities negative.
    study, _ = case("horizontal")
    for critical in study.solution.critical_points:
        if critical.event != "grazing":
            half_on = replace(critical.closed, phi_bottom=critical.closed.phi_bottom + np.pi)
            certificate = certify_point(study.solution.sweep, replace(critical, one_to_one=half_on, mirror=None))
            assert not certificate.proved
            assert "signs" in certificate.reason
