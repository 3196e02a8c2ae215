"""What the report on the paper opens with, for any outcome; and which changes of its scenarios are refused."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vireport.cli.app import main
from vireport.paper.opening import paper_opening
from vireport.paper.reproduction import ReproducedPaper
from vireport.report.printed import paper_section
from vireport.study.checks.paper import CASES, Agreement, ComparedRow, Misprint, PaperComparison, PrintedQuantity
from vireport.study.judging.verdict import Status

ROWS = {
    True: [ComparedRow(PrintedQuantity.SHARE, "Fig. 3(a, b)", "0.5", 0.5, Agreement.TO_ALL_DIGITS, "0.3688")],
    False: [
        ComparedRow(PrintedQuantity.FLIGHT, "Fig. 3(g, h)", printed, 1.2, Agreement.DIFFERS, "0.2545")
        for printed in ("0.92", "1.09")
    ],
    None: [],
}


def paper(overrides=(), intervals=(11, 11), difference=1e-15, printed=3):
    rows = SimpleNamespace(overrides=overrides, intervals=intervals, simulation_difference=difference, printed=printed)
    rows.agreeing = ROWS.__getitem__
    rows.compared = (PaperComparison(CASES[2], (*ROWS[True], *ROWS[False]), ()),)
    return rows


def test_of_the_paper_itself() -> None:
    opening = paper_opening(paper()).worded()
    assert (opening.status, opening.word) == (Status.GOOD, "1 of 3 confirmed")
    assert opening.sentence == (
        "Of the 3 results that the paper prints, 1 are confirmed and 2 are misprints; 0 critical points have a letter "
        "and no number."
    )
    assert opening.facts == (
        (Status.CAUTION, "Misprints: Δt of Fig. 3(g, h)."),
        (Status.GOOD, "All 11 intervals of Table 1 are of the type that it prints."),
        (
            Status.GOOD,
            "From the printed impacts an independent simulation comes to the solved motions of Fig. 3 within "
            "1 × 10⁻¹⁵.",
        ),
    )
    assert [(tile.label, tile.value) for tile in opening.tiles] == [
        ("Confirmed", "1 of 3"),
        ("Misprints", "2"),
        ("Not printed", "0"),
        ("Table 1", "11 of 11"),
    ]


def test_of_a_changed_device() -> None:
    opening = paper_opening(paper(("device.restitution=0.45", "gravity_m_s2=9.81"), (9, 11))).worded()
    assert (opening.status, opening.word) == (Status.NEUTRAL, "Changed scenarios")
    assert opening.sentence == (
        "With device.restitution=0.45, gravity_m_s2=9.81, 1 of the 3 results that the paper prints stay as they are."
    )
    assert [text for _, text in opening.facts][:2] == [
        "Not as printed: Δt of Fig. 3(g, h).",
        "2 of the 11 intervals of Table 1 are not of the type that it prints.",
    ]
    tile = opening.tiles[0]
    assert (tile.label, tile.value, tile.remark) == ("As printed", "1 of 3", "with the changes")


def test_results_of_motions_that_a_changed_device_has_not_are_counted() -> None:
    opening = paper_opening(paper(("device.restitution=0.9",), printed=31)).worded()
    assert opening.sentence == (
        "With device.restitution=0.9, 1 of the 31 results that the paper prints stay as they are; 28 are of motions "
        "that are not there."
    )


@pytest.mark.parametrize(
    ("difference", "status", "said"),
    [
        (
            0.02,
            Status.BAD,
            "From the printed impacts the simulation comes to motions that differ from the solved ones of Fig. 3 by "
            "0.02.",
        ),
        (None, Status.CAUTION, "From the printed impacts the simulation comes to no motion with two impacts a period."),
    ],
)
def test_a_simulation_that_does_not_come_to_the_motions_is_told(difference, status, said) -> None:
    assert (status, said) in paper_opening(paper(difference=difference)).worded().facts


@pytest.mark.parametrize(("faster", "later", "difference"), [(0.1, 0.01, 0.1), (-0.1, -0.2, 0.2), (0.01, 6.2, 0.0832)])
def test_the_simulation_differs_by_the_velocity_or_the_phase_that_differs_most(faster, later, difference) -> None:
    cycle = SimpleNamespace(word="BT", wall=np.array([-1, 1]), velocity=np.array([0.0, 1 + faster]))
    cycle.phase = np.array([0.0, 0.1 + later])
    cycles = [cycle, None, SimpleNamespace(word="BTBT"), None]
    rows = tuple(
        ComparedRow(quantity, CASES[0].motions[0].figure, "1", ours, Agreement.DIFFERS)
        for quantity, ours in ((PrintedQuantity.VELOCITY, 1.0), (PrintedQuantity.PHASE, 0.1))
    )
    portraits = tuple(SimpleNamespace(attractor=SimpleNamespace(cycle=of)) for of in cycles)
    compared = (PaperComparison(CASES[0], rows, ()),)
    assert ReproducedPaper((), compared, portraits, ()).simulation_difference == pytest.approx(difference, abs=1e-4)


def test_letters_that_stand_in_several_panels_are_told_apart() -> None:
    points = [
        ComparedRow(PrintedQuantity.POINT_PHASE, "B1", "0.22", 0.205, Agreement.DIFFERS, phase=CASES[2].phases[0])
    ] * 2
    changed = paper()
    changed.compared = tuple(PaperComparison(case, tuple(points), ()) for case in CASES[1:])
    facts = paper_opening(changed).worded().facts
    assert facts[0] == (Status.CAUTION, "Misprints: φ of B1 of Fig. 2(d)–(f); φ of B1 of Fig. 2(g)–(i).")


def test_a_section_says_which_of_the_papers_scenarios_it_is_of() -> None:
    leads = [paper_section(PaperComparison(case, (), ()))[0] for case in CASES]
    assert [lead.partition("(2019): ")[2].partition(". ")[0] for lead in leads] == [
        "horizontal capsule, F = 3 N, length swept",
        "capsule at 45°, F = 3 N, length swept",
        "capsule at 45°, s = 0.75 m, force swept",
    ]
    assert [len(paper_section(PaperComparison(case, (), ()))) for case in CASES] == [3, 3, 3]
    assert Misprint.PERIOD_4 in CASES[2].misprints


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (
            ("sweep.parameter=inclination_deg", "sweep.from=0", "sweep.to=10"),
            "the paper's sweep of Fig. 2(a)–(c) is needed",
        ),
        (("device.friction=0.1",), "vireport paper is available without friction only"),
    ],
)
def test_another_kind_of_device_or_sweep_is_refused(overrides, said, capsys) -> None:
    assert main(["paper", *(word for override in overrides for word in ("--set", override))]) == 2
    assert said in capsys.readouterr().err
