"""What is said of a ball on a vibrating table: `examples/bouncing-ball.yaml`, by numbers in print and by simulation."""

from __future__ import annotations

from collections.abc import Callable
from math import asin, degrees, hypot, pi, radians, sin
from pathlib import Path

import pytest
from conftest import study

from vireport.comparison.ranking import rank_studies
from vireport.motions.events import Event
from vireport.physics.reach import reach
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.judging.opening import opening_of
from vireport.study.judging.verdict import Conclusion
from vireport.study.study import Study
from vireport.text.said import Said

ROOT = Path(__file__).parents[3]

RESTITUTION, GRAVITY = 0.5, 9.81
ONSET = pi * (1 - RESTITUTION) / (1 + RESTITUTION)
DOUBLING = hypot(ONSET, 2 * (1 + RESTITUTION**2) / (1 + RESTITUTION) ** 2)
"""Gamma where the motion with one impact a period begins, and where its period doubles: Luck and Mehta (1993)."""

ALERTS_ON_1_1 = {"VR001", "VR003"}


def table(force: float | None = None, *over: str) -> Study:
    """The example, with a design point or without one, and with other keys."""
    return study("bouncing-ball", *(() if force is None else (f"excitation.amplitude_n={force}",)), *over)


def opening(ball: Study) -> list[str]:
    """The sentence and the other lines, with plain spaces."""
    worded = opening_of(ball.verdict, ball.alerts).worded()
    return [line.replace("\u00a0", " ") for line in worded.text]


@pytest.mark.slow
def test_along_a_sweep_a_table_has_a_good_verdict_and_the_range_in_print() -> None:
    ball = table()
    assert ball.verdict.conclusion is Conclusion.BOUNCING
    assert [conclusion.status for conclusion in ball.verdict.conclusions] == ["good"]
    assert not ALERTS_ON_1_1 & {alert.code for alert in ball.alerts}
    assert ball.verdict.where is not None
    (part,) = ball.verdict.where.data
    assert (part.start, part.end) == pytest.approx((ONSET * GRAVITY, DOUBLING * GRAVITY), rel=1e-12)
    sentence, *others = opening(ball)
    assert sentence == "The ball bounces on the bottom: B every forcing period, for 10.3 N < F < 15.0 N."
    assert "The top is out of the ball’s reach, as if there were none." in others
    assert "Stable force amplitude: 10.3 N to 15.0 N (from fold to period doubling)" in others
    assert others[0].startswith("Also stable in the sweep: BB, BBB, ")
    assert ball.atlas is not None
    assert all("T" not in family.word.letters for family in ball.atlas.families)


@pytest.mark.slow
def test_at_a_design_point_it_says_what_is_stable_and_what_comes_from_rest() -> None:
    sentence, *others = opening(table(12.0))
    possible, by_itself = "B every forcing period", "comes to rest every forcing period (B~)"
    assert sentence == f"The ball can bounce on the bottom, {possible}; from rest it {by_itself}."
    assert "From rest: on the bottom (the ball comes to rest every forcing period (B~))" in others


@pytest.mark.parametrize(
    ("over", "conclusion", "sentence"),
    [
        (
            {"force": 15.5},
            Conclusion.BOUNCING,
            "The ball can bounce on the bottom, BB every 2 forcing periods; from rest it comes to rest every forcing "
            "period (B~).",
        ),
        (
            {"force": 17.5},
            Conclusion.NOT_BOUNCING,
            "No motion of the ball on the bottom is known to be stable; from rest it comes to rest every 8 forcing "
            "periods (BBBBBBBBB~).",
        ),
        (
            {"force": 26.0, "restitution": 0.15},
            Conclusion.BOUNCING,
            "The ball bounces on the bottom, and starts by itself: B every forcing period.",
        ),
    ],
)
def test_without_a_sweep_it_is_the_same(over, conclusion, sentence) -> None:
    more = [f"device.restitution={over['restitution']}"] if "restitution" in over else []
    ball = table(over["force"], "sweep=", *more)
    assert ball.verdict.conclusion is conclusion
    assert ball.verdict.where is None
    assert opening(ball)[0] == sentence
    assert not ALERTS_ON_1_1 & {alert.code for alert in ball.alerts}


@pytest.mark.slow
def test_below_the_onset_nothing_is_stable() -> None:
    ball = table(None, "sweep.to=10")
    assert ball.verdict.conclusion is Conclusion.NOT_BOUNCING
    assert opening(ball)[0] == "No motion of the ball on the bottom is known to be stable."


def test_a_comparison_says_it_in_a_few_words_and_ranks_what_is_stable_first() -> None:
    irregular, stable = rank_studies({"17.5 N": table(17.5, "sweep="), "15.5 N": table(15.5, "sweep=")})[::-1]
    assert [(x.name, x.rank, x.stable) for x in (stable, irregular)] == [("15.5 N", 1, True), ("17.5 N", 2, False)]
    said = [Said(f"lacks_{name}", (), "compare").words() for name in ("bouncing", "not_bouncing")]
    assert said == ["stable on the bottom", "no stable bouncing known"]


def test_a_capsule_whose_top_is_reached_is_none() -> None:
    ball = table(12.0, "sweep=", "device.length_m=0.02")
    assert not ball.solution.on_table
    assert ball.verdict.conclusion is Conclusion.NOT_FROM_REST
    assert ball.verdict.motion.data.types


@pytest.mark.slow
def test_its_page_has_the_numbers_of_the_example() -> None:
    page = " ".join((ROOT / "docs" / "bouncing-ball.md").read_text(encoding="utf-8").split())
    ball = table()
    assert ball.atlas is not None
    families = {
        (family.word.letters, family.word.periods): family.stable_ranges for family in ball.atlas.families[::-1]
    }
    (first,), (second,), (beside,) = (families[word] for word in [("B", 1), ("BB", 2), ("BB", 1)])
    third = next(part for part in families["BBBB", 4] if part[0] == pytest.approx(second[1]))
    doublings = [part[1] / GRAVITY for part in (first, second, third)]
    for value in (first[0] / GRAVITY, *doublings, *(end / GRAVITY for end in beside)):
        assert f"{value:.4f}" in page
    assert f"ratio {(doublings[1] - doublings[0]) / (doublings[2] - doublings[1]):.1f};" in page
    assert f"{opening(ball)[0]}" in page
    height = max(reach(ball.solution.device.groups(Parameter.AMPLITUDE, force)) * x_c(force) for force in (9.5, 18.0))
    assert f"The bound, {100 * height:.0f} cm for the example" in page


def x_c(force: float) -> float:
    """The unit of length of the example, F pi^2/(M omega^2) [m]."""
    return force * pi**2 / (20 * pi) ** 2


@pytest.mark.parametrize(("r", "gamma"), [(0.15, 2.45), (0.5, 1.2), (0.5, 2.13), (0.8, 1.05), (0.8, 0.8), (0.8, 0.3)])
def test_motions_with_one_impact_are_known_without_a_sweep_and_end_where_print_says(r: float, gamma: float) -> None:
    """Every number of periods with a stable motion is found, and no other, whatever the ball comes to from rest."""
    ball = table(gamma * GRAVITY, "sweep=", f"device.restitution={r}")
    assert ball.switched_on is not None
    onset, width = pi * (1 - r) / (1 + r), 2 * (1 + r**2) / (1 + r) ** 2
    ranges = {periods: (periods * onset, hypot(periods * onset, width)) for periods in range(1, 20)}
    expected = {periods: ends for periods, ends in ranges.items() if ends[0] < gamma < ends[1]}
    of_any_start = (*ball.switched_on.by_starts, ball.switched_on.motion_from_rest)
    single = {x.motion.word.periods: x for x in of_any_start if x is not None and x.motion.word.letters == "B"}
    assert single.keys() == expected.keys()
    for periods, motion in single.items():
        assert (motion.low / GRAVITY, motion.high / GRAVITY) == pytest.approx(expected[periods], rel=1e-12)
        assert [event.value for event in (motion.below, motion.above)] == ["fold", "period_doubling"]
        assert float(motion.motion.velocity[0]) == pytest.approx(2 * periods / gamma / (1 + r), rel=1e-12)
    names = [word.name for word in ball.verdict.motion.data.instead]
    assert {motion.name for motion in single.values()} <= {*names}
    assert bool(names) == (ball.verdict.conclusion is not Conclusion.NOT_BOUNCING)
    assert not names[1:] or f"Also stable here: {', '.join(names[1:])}." in opening(ball)


def gamma_at(restitution: float) -> tuple[float, float]:
    """Gamma where the motion with one impact a period begins and where its period doubles, Luck and Mehta (1993)."""
    onset = pi * (1 - restitution) / (1 + restitution)
    return onset, hypot(onset, 2 * (1 + restitution**2) / (1 + restitution) ** 2)


def inverse(of: Callable[[float], float], low: float, high: float, value: float) -> float:
    """Where a function that falls between two restitutions has a value."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if of(middle) > value else (low, middle)
    return low


def test_each_input_can_go_as_far_as_print_says_before_the_motion_ends() -> None:
    ball = table(12.0, "sweep=", "inclination_deg=85")
    weight = GRAVITY * sin(radians(85))
    ranges = {x.varied: (x.low, x.high) for x in ball.evidence.bottom}
    onset, doubling = (weight * gamma for gamma in (ONSET, DOUBLING))
    assert ranges[DesignInput.AMPLITUDE] == pytest.approx((onset, doubling))
    assert ranges[DesignInput.CAPSULE_MASS] == pytest.approx((12 / doubling, 12 / onset))
    assert ranges[DesignInput.INCLINATION] == pytest.approx((degrees(asin(12 / DOUBLING / GRAVITY)), 90))
    ends = [inverse(lambda r, k=k: gamma_at(r)[k], 0.0, 0.99, 12 / weight) for k in (0, 1)]
    assert ranges[DesignInput.RESTITUTION] == pytest.approx(ends)
    assert ranges.keys() == {*DesignInput} - {
        *(DesignInput.LENGTH, DesignInput.RESTITUTION_BOTTOM, DesignInput.RESTITUTION_TOP)
    }
    assert "Margin to use: 12 % in restitution (B ends at 0.438)" in opening(ball)
    use, on_bottom = (ball.to_dict()[key] for key in ("margin_to_use", "on_bottom"))
    assert (use["parameter"], use["relative"]) == ("restitution", pytest.approx(1 - ends[0] / RESTITUTION))
    assert [on_bottom["word"], on_bottom["periods"], len(on_bottom["stable_ranges"])] == ["B", 1, 5]


def test_a_small_margin_is_said_first() -> None:
    ball = table(10.4, "sweep=")
    assert [(conclusion.name, conclusion.status) for conclusion in ball.verdict.conclusions] == [
        ("BOUNCING_NEAR_END", "caution")
    ]
    sentence, *others = opening(ball)
    assert sentence == "The ball can bounce: B every forcing period; the margin is small."
    assert "Margin to use: 0.92 % in restitution (B ends at 0.495)" in others


def test_unlike_membranes_have_the_margin_of_that_at_the_bottom() -> None:
    ball = table(12.0, "sweep=", "device.restitution=", "device.restitution_bottom=0.5", "device.restitution_top=0.3")
    ranges = {x.varied: x.low for x in ball.evidence.bottom}
    low = inverse(lambda r: gamma_at(r)[0], 0.0, 0.99, 12 / GRAVITY)
    assert ranges[DesignInput.RESTITUTION_BOTTOM] == pytest.approx(low)
    assert DesignInput.RESTITUTION not in ranges


def test_the_ball_comes_to_the_top_where_the_frequency_is_low() -> None:
    """It touches a top at 0.15 m, which is 9.3 times as high as it comes, at nearly a third of the frequency."""
    ball = table(12.0, "sweep=", "device.length_m=0.15")
    (frequency,) = (x for x in ball.evidence.bottom if x.varied is DesignInput.FREQUENCY)
    assert frequency.below is Event.GRAZING
    slower = table(12.0, "sweep=", "device.length_m=0.15", f"excitation.frequency_hz={1.01 * frequency.low}")
    assert not slower.solution.on_table


@pytest.mark.parametrize(
    ("force", "key", "limit", "passed", "text", "why"),
    [
        (12.0, "any", 12, True, "12.10 %", "B every forcing period, fold at restitution = 0.440"),
        (12.0, "any", 14, False, "12.1 %", "B every forcing period, fold at restitution = 0.440"),
        (
            12.0,
            "period_doubling",
            19,
            True,
            "19.9 %",
            "B every forcing period, period doubling at capsule_mass_kg = 0.801",
        ),
        (12.0, "grazing", 1, True, "none in any input", ""),
        (17.5, "any", 1, False, "not known", "no stable motion is known at the design point"),
    ],
)
def test_a_required_margin_is_held_against_that_of_the_motion_on_the_bottom(
    force: float, key: str, limit: float, passed: bool, text: str, why: str
) -> None:
    ball = table(force, "sweep=", f"requirements.margin_{key}_percent={limit}")
    (criterion,) = ball.criteria
    assert (criterion.passed, str(criterion.outcome.text)) == (passed, text)
    assert str(criterion.outcome.why) == why


HARMONIC = "excitation.harmonics=[{order: 2, percent: 3, phase_deg: 40}]"


@pytest.mark.slow
def test_with_harmonics_the_range_of_one_impact_is_found_once() -> None:
    """It moves by about the share of the harmonic; at a design point it is the same one."""
    along, there = table(None, HARMONIC), table(12.0, HARMONIC)
    assert along.atlas is not None
    (single,) = (family for family in along.atlas.families if family.word.letters == "B")
    assert single.stable_ranges[0] == pytest.approx((ONSET * GRAVITY, DOUBLING * GRAVITY), rel=0.04)
    assert along.verdict.where is not None
    assert there.verdict.where is not None
    assert len(along.verdict.where.data) == len(there.verdict.where.data) == 1
    (force,) = (x for x in there.evidence.bottom if x.varied is DesignInput.AMPLITUDE)
    assert (force.low, force.high) == pytest.approx(single.stable_ranges[0], rel=1e-9)


def test_a_harvester_that_cannot_reach_its_top_membrane_has_failed() -> None:
    """A ball that bounces on the bottom alone is no success of a device with two membranes."""
    harvester = study("bouncing-ball", "excitation.amplitude_n=12", "device.ball_mass_kg=0.004", "sweep=")
    assert (
        reach(harvester.solution.device.groups(Parameter.LENGTH, 0.5))
        < harvester.solution.device.groups(Parameter.LENGTH, 0.5).d
    )
    assert harvester.verdict.conclusion in (Conclusion.NOT_STABLE, Conclusion.OTHER_MOTION)
    assert harvester.verdict.status != "good"
    assert "VR003" in {alert.code for alert in harvester.alerts}
