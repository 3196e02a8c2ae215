"""The paper's numbers beside ours: the right ones, computed, and only where the scenario is the paper's."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from conftest import first

from vireport.physics.motion import Symmetry
from vireport.scenario.loading import load
from vireport.study.checks.paper import CASES, Agreement, Misprint, compare_with_paper
from vireport.study.study import analyse

# What is in print, what 40-digit arithmetic gives, and whether they agree.
OURS = {
    "horizontal": {
        ("C1", "", "point_phase"): ("3.66", "3.6239406", False),
        ("B1", "", "point_phase"): ("3.02", "3.0251434", True),
        ("Fig. 3(a, b)", "0.3688", "velocity"): ("0.7153", "0.71526064", True),
        ("Fig. 3(a, b)", "0.3688", "phase"): ("0.5924", "0.59651698", False),
        ("Fig. 3(a, b)", "0.3688", "position"): ("0.1844", "0.1844", True),
        ("Fig. 3(a, b)", "0.3688", "share"): ("0.5", "0.5", True),
        ("Section 4, foci", "", "modulus"): ("0.25", "0.25", True),
        ("A1", "", "point_d"): ("", "0.2079356188", None),
        ("A2", "", "point_d"): ("", "0.2438848418", None),
        ("A3", "", "point_d"): ("", "0.3100633410", None),
        ("B1", "", "point_d"): ("", "0.1870532313", None),
        ("C1", "", "point_d"): ("", "0.2634315843", None),
    },
    "inclined": {
        ("B1", "", "point_phase"): ("0.49", "0.49789027", True),
        ("B1", "", "point_d"): ("", "0.4179595416", None),
        ("Fig. 3(c, d)", "0.4604", "velocity"): ("1.004", "1.00400474", True),
        ("Fig. 3(c, d)", "0.4604", "phase"): ("0.5635", "0.56672469", False),
        ("Fig. 3(c, d)", "0.4604", "share"): ("0.587", "0.58606105", False),
    },
    "inclined-forcing": {
        ("B1", "", "point_phase"): ("0.22", "0.20515501", False),
        ("B1", "", "point_d"): ("", "0.2792918143", None),
        ("Fig. 3(e, f)", "0.2814", "velocity"): ("0.726", None, True),
        ("Fig. 3(e, f)", "0.2814", "phase"): ("0.2101", None, True),
        ("Fig. 3(e, f)", "0.2814", "share"): ("0.6507", None, True),
        ("Fig. 3(g, h)", "0.2545", "velocity"): ("0.715", "0.71494944", True),
        ("Fig. 3(g, h)", "0.2545", "phase"): ("0.2355", "0.23545139", True),
        ("Fig. 3(g, h)", "0.2545", "force"): ("5.87", "5.87033399", True),
        ("Section 3, F = 3 N", "", "gravity"): ("0.29", "0.28758033", True),
        ("Section 3, F = 6 N", "", "gravity"): ("0.14", "0.14379016", True),
    },
}


@pytest.mark.parametrize("name", OURS)
def test_both_columns(name: str, study_of) -> None:
    compared = compare_with_paper(study_of(name).solution)
    assert compared is not None
    rows = {(row.of, row.d, row.quantity): row for row in compared.rows}
    for quantity, (printed, ours, agrees) in OURS[name].items():
        assert rows[quantity].printed == printed
        assert rows[quantity].agrees is agrees, rows[quantity]
        if ours is not None:
            assert rows[quantity].ours == pytest.approx(float(ours), rel=6e-8)
    assert all(row.agrees for row in compared.types)


@pytest.mark.parametrize(("name", "gbar"), [("horizontal", 0.0), ("inclined", None), ("inclined-forcing", None)])
def test_our_motion_satisfies_the_equations_at_the_printed_d(name: str, gbar: float | None, study_of) -> None:
    study = study_of(name)
    figure = compare_with_paper(study.solution).case.motions[0].figure
    rows = {row.quantity: row for row in compare_with_paper(study.solution).rows if row.of == figure}
    velocity, phi, q = (rows[quantity].ours for quantity in ("velocity", "phase", "share"))
    d = float(rows["velocity"].d)
    force = 3.0 if name != "inclined-forcing" else 4 * 0.1245 * 0.75 * 4 / d
    gbar = 0.1245 * 9.8 * sin(pi / 4) / force if gbar is None else gbar
    r, up, down = 0.5, 2 * q, 2 - 2 * q
    a = pi * up
    at_top = gbar * 2 / (1 + r) - velocity
    # (3.3) and (3.4), the flight from the bottom to the top, as they stand.
    assert at_top == pytest.approx(-r * velocity + gbar * up + (sin(a + phi) - sin(phi)) / pi, abs=2e-7)
    fallen = -r * velocity * up + gbar / 2 * up**2 - (cos(a + phi) - cos(phi)) / pi**2 - sin(phi) / pi * up
    assert -d == pytest.approx(fallen, abs=2e-7)
    # (3.6), the flight back.
    back = -r * at_top * down + gbar / 2 * down**2 - (cos(phi) - cos(a + phi)) / pi**2 - sin(a + phi) / pi * down
    assert d == pytest.approx(back, abs=2e-7)


def test_a_number_agrees_to_its_digits_cut_off_or_within_the_rounding_of_d(study_of) -> None:
    """Each row is told as what it is, by the numbers alone."""
    seen = set()
    for name in OURS:
        for row in compare_with_paper(study_of(name).solution).rows:
            seen.add(row.agreement)
            if row.agreement is Agreement.NOT_PRINTED:
                assert row.printed == ""
                continue
            unit = 10.0 ** -len(row.printed.partition(".")[2])
            beyond = row.ours - float(row.printed)
            assert row.gap == abs(beyond)
            if row.agreement is Agreement.TO_ALL_DIGITS:
                assert abs(beyond) <= 0.5 * unit + 1e-15
            elif row.agreement is Agreement.CUT_OFF:
                assert 0.5 * unit - 1e-15 <= beyond < unit
            else:
                assert abs(beyond) > 0.5 * unit
                assert (row.agreement is Agreement.ROUNDING_OF_D) <= bool(row.d)
    assert seen >= {Agreement.TO_ALL_DIGITS, Agreement.ROUNDING_OF_D, Agreement.DIFFERS, Agreement.NOT_PRINTED}


def test_the_flight_times_of_the_period_4_motion_are_those_of_another_one(study_of) -> None:
    rows = [row for row in compare_with_paper(study_of("inclined-forcing").solution).rows if row.quantity == "flight"]
    assert [(row.printed, row.agrees) for row in rows] == [(time, False) for time in ("0.92", "1.09", "0.91", "1.08")]
    ours = [row.ours for row in rows]
    assert ours == pytest.approx([1.21314450, 0.74949244, 1.42446031, 0.61290275], abs=1e-8)
    assert sum(ours) == pytest.approx(4.0, abs=1e-12)  # two forcing periods


@pytest.mark.parametrize(
    "override",
    first(
        2,
        [
            "device.capsule=free",
            "device.friction=0.05",
            "device.restitution=0.6",
            "gravity_m_s2=9.81",
            "excitation.amplitude_n=3.1",
            "inclination_deg=44",
            "period_ratio=3",
            "excitation.harmonics=[{order: 2, percent: 1.3, phase_deg: 0}]",
        ],
    ),
)
def test_another_device_is_not_compared(override: str, example) -> None:
    assert compare_with_paper(analyse(load(example("inclined"), [override])).solution) is None


def test_a_design_point_is_compared_where_it_is_the_papers(example) -> None:
    path = example("design-point")
    assert compare_with_paper(analyse(load(path)).solution) is None
    compared = compare_with_paper(analyse(load(path, ["device.length_m=0.6934"])).solution)
    assert compared is not None
    assert [row.agrees for row in compared.rows] == [True, True, False, False, True]


def test_a_sweep_that_misses_the_motion_leaves_it_out(example) -> None:
    study = analyse(load(example("inclined"), ["sweep.to=0.64", "device.length_m="]))
    rows = compare_with_paper(study.solution).rows
    assert any(row.of == "B1" for row in rows)
    assert not any(row.d for row in rows)


def test_slips_of_the_text() -> None:
    for case in CASES:
        assert case.misprints[:3] == (Misprint.GRAVITY, Misprint.EIGENVALUE, Misprint.FIGURE_1)
    assert [Misprint.SADDLE_NODE in case.misprints for case in CASES] == [True, False, False]


def test_the_voltage_grows_faster_above_c1_and_falls_where_the_force_is_swept(study_of) -> None:
    """What Section 5 says of Fig. 7, and docs/paper.md repeats."""
    slopes = {}
    for branch in study_of("horizontal").solution.branches:
        stable, volts = branch.motions.stable_mask, branch.voltages_by_motion.average_v
        d, at = branch.motions.d[stable], volts[stable]
        order = np.argsort(d)
        if branch.mirror_of is None and stable.any():
            near = 0.26 if branch.symmetry is Symmetry.ASYMMETRIC else 0.27
            low, high = np.interp([near - 0.002, near + 0.002], d[order], at[order])
            slopes[branch.symmetry] = (high - low) / 0.004
    assert slopes[Symmetry.SYMMETRIC] > 1.5 * slopes[Symmetry.ASYMMETRIC] > 0
    for name, sign in (("inclined", 1), ("inclined-forcing", -1)):
        (branch,) = (x for x in study_of(name).solution.branches if x.motions.stable_mask.any())
        stable = branch.motions.stable_mask
        steps = np.diff(branch.voltages_by_motion.average_v[stable]) / np.diff(branch.motions.d[stable])
        assert (sign * steps > 0).all()
