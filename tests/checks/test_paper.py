"""The paper's numbers beside ours: the right ones, computed, and only where the scenario is the paper's."""

from __future__ import annotations

from math import cos, pi, sin

import pytest

from vireport.checks.paper import CASES, compare_with_paper
from vireport.scenario.loading import load
from vireport.study.study import analyse

# What is in print, what 40-digit arithmetic gives, and whether they agree.
OURS = {
    "horizontal": {
        "C1: *φ*": ("3.66", "3.6239406", False),
        "B1: *φ*": ("3.02", "3.0251434", True),
        "Fig. 3(a, b), *d* = 0.3688: *Ż*_B": ("0.7153", "0.71526064", True),
        "Fig. 3(a, b), *d* = 0.3688: *φ*": ("0.5924", "0.59651698", False),
        "Fig. 3(a, b), *d* = 0.3688: *q*": ("0.5", "0.5", True),
        "A1: *d*": ("—", "0.2079356188", None),
        "A2: *d*": ("—", "0.2438848418", None),
        "A3: *d*": ("—", "0.3100633410", None),
        "B1: *d*": ("—", "0.1870532313", None),
        "C1: *d*": ("—", "0.2634315843", None),
    },
    "inclined": {
        "B1: *φ*": ("0.49", "0.49789027", True),
        "B1: *d*": ("—", "0.4179595416", None),
        "Fig. 3(c, d), *d* = 0.4604: *Ż*_B": ("1.004", "1.00400474", True),
        "Fig. 3(c, d), *d* = 0.4604: *φ*": ("0.5635", "0.56672469", False),
        "Fig. 3(c, d), *d* = 0.4604: *q*": ("0.587", "0.58606105", False),
    },
    "inclined-forcing": {
        "B1: *φ*": ("0.22", "0.20515501", False),
        "B1: *d*": ("—", "0.2792918143", None),
        "Fig. 3(e, f), *d* = 0.2814: *Ż*_B": ("0.726", None, True),
        "Fig. 3(e, f), *d* = 0.2814: *φ*": ("0.2101", None, True),
        "Fig. 3(e, f), *d* = 0.2814: *q*": ("0.6507", None, True),
    },
}


@pytest.mark.parametrize("name", OURS)
def test_both_columns(name: str, study_of) -> None:
    compared = compare_with_paper(study_of(name).solution)
    assert compared is not None
    rows = {row.quantity: row for row in compared.rows}
    for quantity, (printed, ours, agrees) in OURS[name].items():
        assert rows[quantity].printed == printed
        assert rows[quantity].agrees is agrees, rows[quantity]
        if ours is not None:
            assert float(rows[quantity].ours) == pytest.approx(float(ours), rel=6e-8)
    assert all(row.agrees for row in compared.types)


@pytest.mark.parametrize(("name", "gbar"), [("horizontal", 0.0), ("inclined", None), ("inclined-forcing", None)])
def test_our_motion_satisfies_the_equations_at_the_printed_d(name: str, gbar: float | None, study_of) -> None:
    study = study_of(name)
    rows = [row for row in compare_with_paper(study.solution).rows if row.quantity.startswith("Fig. 3")]
    velocity, phi, q = (float(row.ours) for row in rows[:3])
    d = float(rows[0].quantity.split("= ")[1].split(":")[0])
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


def test_differences_are_stated_with_their_size(study_of) -> None:
    for name in OURS:
        for row in compare_with_paper(study_of(name).solution).rows:
            if row.agrees is False:
                size = float(row.remark.split(";")[0].removeprefix("by "))
                assert size == pytest.approx(abs(float(row.ours) - float(row.printed)), rel=0.06)


@pytest.mark.parametrize(
    "override",
    [
        "device.restitution=0.6",
        "gravity_m_s2=9.81",
        "excitation.amplitude_n=3.1",
        "inclination_deg=44",
        "period_ratio=3",
    ],
)
def test_another_device_is_not_compared(override: str, example) -> None:
    assert compare_with_paper(analyse(load(example("inclined"), [override])).solution) is None


def test_a_design_point_is_compared_where_it_is_the_papers(example) -> None:
    path = example("design-point")
    assert compare_with_paper(analyse(load(path)).solution) is None
    compared = compare_with_paper(analyse(load(path, ["device.length_m=0.6934"])).solution)
    assert compared is not None
    assert [row.agrees for row in compared.rows] == [True, False, False, True]


def test_a_sweep_that_misses_the_motion_leaves_it_out(example) -> None:
    study = analyse(load(example("inclined"), ["sweep.to=0.64", "device.length_m="]))
    rows = compare_with_paper(study.solution).rows
    assert any(row.quantity == "B1: *φ*" for row in rows)
    assert not any(row.quantity.startswith("Fig. 3") for row in rows)


def test_slips_of_the_text() -> None:
    for case in CASES:
        places = [slip.place for slip in case.misprints]
        assert places[:3] == ["(3.10)", "Section 4, Im *λ*", "Table 1; caption of Fig. 4"]
    assert any(slip.meant == "pitchfork" for slip in CASES[0].misprints)
    assert not any(slip.meant == "pitchfork" for case in CASES[1:] for slip in case.misprints)
