"""What the first page says is what the results have: sizes, sides, the motions that are meant, and what weighs most."""

from __future__ import annotations

import re
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import solved, toleranced
from msgspec.structs import replace

from vireport.design.solution import Solution
from vireport.physics.contact import contacts
from vireport.study.judging.alerts import CAUSES
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.opening import margin_said, opening_of
from vireport.study.judging.verdict import Conclusion, Status, Verdict, verdict_of
from vireport.text.alerts import CATALOGUE, AlertCode, Severity
from vireport.text.requirements import Question
from vireport.text.templates import Words

MOTION = SimpleNamespace(count=5, name="BBT every forcing period", stays=False)


NARROW = {"device__length_m": 0.61, "excitation__amplitude_n": 6.9375, "tolerances__length_percent": 10.0}
"""1:1 motion of the inclined example is then stable from 0.6083 to 0.6125 m, and devices are off by 10 %."""


def said(solution, **given: object) -> Verdict:
    """The verdict on a solution with nothing else known, or with something found."""
    return verdict_of(Evidence(solution, **given))


def tile(solution, name: str) -> list[str]:
    """Label, number and remark of the first tile of a kind on the first page of a solution."""
    tiles = opening_of(said(solution)).tiles
    chosen = next(tile for tile in tiles if tile.said.macro.startswith(f"tile_{name}"))
    return Words("opening")(chosen.said.macro, *chosen.said.values).replace("\u00a0", " ").split(" | ")


def fact(verdict: Verdict, question: Question):
    return next(fact for fact in verdict.answers.values() if fact.question == question)


def cause(code: str, evidence: Evidence) -> str:
    known = next(known for known in CATALOGUE if known.code == code)
    return str(known.cause(CAUSES[known.code](evidence)))


def check(**given: object) -> SimpleNamespace:
    """A simulation that found something."""
    usual = {"passed": True, "orbits": 9, "misses": (), "velocity_difference": 1e-14, "phase_difference": 2e-14}
    usual |= {"trials": 20, "arrivals": 15, "share": (0.75, 0.5, 0.9), "elsewhere": (), "motions": (), "values": [0]}
    return SimpleNamespace(**usual | {"tolerance": 1e-9} | given)


@pytest.fixture(scope="module")
def tilted():
    """Two stable motions, of which one ends a little above the design point."""
    return solved("horizontal", inclination_deg=1.0, device__length_m=0.36)


@pytest.fixture(scope="module")
def mirrored():
    """Two stable motions that are mirror images."""
    return solved("horizontal", device__length_m=0.36)


def test_stable_motion_elsewhere_in_the_sweep_is_good_where_the_design_point_has_it(study_of: Callable) -> None:
    """From B1, 0.6295 m, on; a cause for caution where the design point is in none of the ranges."""
    assert fact(said(study_of("inclined").solution), Question.WHERE).status == "good"
    assert fact(said(solved("inclined", device__length_m=0.6)), Question.WHERE).status == "caution"


def test_the_margin_is_that_of_the_nearest_end_with_its_side(study_of: Callable, tilted) -> None:
    for solution, near in (
        (study_of("inclined").solution, False),
        (tilted, True),  # by the restitution of one membrane
        (solved("inclined", device__length_m=0.632), True),
    ):
        first = min((x for x in solution.design.endings() if x.relative), key=lambda x: abs(x.relative))
        margin, side = fact(said(solution), Question.MARGIN), "above" if first.distance > 0 else "below"
        label, value, remark = tile(solution, "margin")
        size, quantity = re.fullmatch(r"([\d.]+)\s%\sin\s(.+)", value).groups()
        assert float(size) == pytest.approx(100 * abs(first.relative), rel=0.03)
        assert (label, quantity) == ("Margin to use", first.parameter.quantity)
        assert f"{first.sweep_value:.3g}" in remark
        assert (margin.status == "caution") is near
        warned = cause("VR005", Evidence(solution))
        told = re.search(r"ends ([\d.]+) % (above|below)", warned) if warned else None
        assert told is None or float(told[1]) == float(f"{100 * abs(first.relative):.2g}")
        assert told is None or told[2] == side
        assert bool(warned) is near
    assert side == "below"
    assert said(solution).word == "Stable, margin small"


def test_a_symmetric_motion_is_taken_over_from_at_the_pitchfork_in_between(study_of: Callable, mirrored) -> None:
    nearest = fact(said(study_of("horizontal").solution), Question.MARGIN).data
    assert (nearest.end.label, nearest.end.taken_over, nearest.symmetric) == ("C1", True, True)
    assert nearest.end.sweep_value == pytest.approx(1.69, rel=3e-3)
    assert (nearest.lost.label, round(nearest.lost.relative, 2)) == ("B1", -0.29)
    handed = fact(said(mirrored), Question.MARGIN).data
    assert handed.handover is not None or handed.end.taken_over
    assert not handed.symmetric


def test_stable_motions_are_counted_but_for_mirror_images(tilted, mirrored) -> None:
    assert (fact(said(tilted), Question.MOTION).data.count, fact(said(tilted), Question.MOTION).data.mirrored) == (
        2,
        False,
    )
    assert cause("VR004", Evidence(tilted)).startswith("2 stable")
    assert fact(said(mirrored), Question.MOTION).data.mirrored
    assert not cause("VR004", Evidence(mirrored))


def test_voltages_are_of_stable_motions_alone(tilted) -> None:
    for solution in (tilted, solved("design-point")):  # which has an unstable motion besides
        volts = solution.design.voltages_by_motion.average_v[solution.design.motions.stable_mask] / 1e3
        _, value, remark = tile(solution, "voltage")
        shown = [float(number) for number in re.findall(r"[\d.]+", value)]
        assert shown == pytest.approx(sorted({volts.min(), volts.max()}), rel=5e-3)
        assert remark == "by the paper’s formulae, extrapolated"
        deep = solution.design.voltages_by_motion.deflection_m[solution.design.motions.stable_mask].max()
        assert fact(said(solution), Question.VOLTAGE).data.stretch.depth_m == deep
    light = solved("design-point", device__ball_mass_kg=1e-7)
    assert tile(light, "voltage")[2] == "by the paper’s formulae"
    swept = replace(tilted, design=None)
    volts = np.concatenate([b.voltages_by_motion.average_v[b.motions.stable_mask] for b in swept.branches]) / 1e3
    swept = replace(swept, membrane=replace(swept.membrane, active_radius_m=1.0))
    numbers = [float(x) for x in re.findall(r"[\d.]+", tile(swept, "voltages")[1])]
    assert numbers == pytest.approx([volts.min(), volts.max()], rel=5e-3)


def test_the_stable_range_of_the_nearest_end_comes_first() -> None:
    point = solved("design-point")
    where, first = fact(said(point), Question.WHERE), point.design.endings()[0].parameter
    assert where.data[0].parameter == first
    assert len(where.data) == len(point.design.stable_ranges)
    assert first.quantity in tile(point, "between_of_input")[0]


def test_what_weighs_most_is_said_first(study_of: Callable) -> None:
    solution = solved("inclined", device__ball_mass_kg=1e-5)
    failed = said(solution, crosscheck=check(passed=False, misses=(1,), phase_difference=3e-3))
    assert (failed.status, failed.word) == ("caution", "Not verified")
    assert "The simulation departs from 1 of 9 stable motions" in opening_of(failed).worded().facts[0][1]


def test_starts_that_end_elsewhere_are_cautioned_against_and_counted(study_of: Callable) -> None:
    solution = study_of("inclined").solution
    for elsewhere, status in (((), "good"), ((MOTION,), "caution")):
        answer = check(elsewhere=elsewhere)
        assert fact(said(solution, crosscheck=answer), Question.STARTS).status == status
        noted = cause("VR021", Evidence(solution, answer))
        assert "elsewhere though a stable 1:1 motion exists: 5 of 20" in noted if elsewhere else not noted


def test_the_deepest_of_all_stable_motions_is_held_against_the_membrane() -> None:
    def deflections(solution: Solution) -> np.ndarray:
        segments = ((branch, part) for branch in solution.branches for part in branch.family.segments if part.stable)
        parts = [branch.voltages_by_motion.deflection_m[part.first : part.last + 1] for branch, part in segments]
        return np.concatenate(parts)

    solution = solved("inclined", device__length_m=None)
    depths = deflections(solution)
    assert depths.min() < depths.max() == said(solution).voltage.data.stretch.depth_m
    between = replace(solution.membrane, active_radius_m=float(depths.mean()))
    assert said(replace(solution, membrane=between)).voltage.status is Status.NEUTRAL
    wide = replace(solution.membrane, active_radius_m=float(depths.max()))
    assert said(replace(solution, membrane=wide)).voltage.status is Status.GOOD


def test_alerts_have_the_numbers_that_they_warn_of(study_of: Callable) -> None:
    solution = study_of("inclined").solution
    for phase, velocity in ((3e-3, 1e-14), (1e-14, 3e-3)):
        failed = check(passed=False, misses=(1,), phase_difference=phase, velocity_difference=velocity)
        assert "reaches 0.003 " in cause("VR020", Evidence(solution, failed))
    motions, unit = solution.design.motions, 3 / (2 * 0.1245 * 2)
    slowest = unit * min(np.minimum(motions.velocity_bottom, -motions.velocity_top)[motions.stable_mask])
    share = 2 * float(contacts(np.array(slowest), solution.membrane, 0.5).duration)
    assert f"some {100 * share:.2g} % of the forcing period" in cause("VR011", Evidence(solution))
    membrane = {"thickness_m": 1e-3, "relative_permittivity": 4.7, "breakdown_field_v_m": 2e7}
    charged = solved("design-point", **{f"device__membrane__{key}": value for key, value in membrane.items()})
    field = float(charged.design.conversion_by_motion.field_v_m[charged.design.motions.stable_mask].max())
    assert f"{field / 1e7:.3g} × 10⁷ V/m, {field / 2e7:.3g} times" in cause("VR016", Evidence(charged))


@pytest.mark.parametrize(
    ("narrowest", "over"),
    [
        (2e-6, {}),  # a millionth of the value
        (1e-4, {"tolerances__length_m": 1e-3}),
        (4e-3, {"tolerances__length_percent": 2.0, "tolerances__length_m": 1e-3}),
        (1e-9, {"tolerances__length_m": 1e-8}),
    ],
)
def test_a_range_is_too_narrow_by_the_tolerance_or_by_a_millionth(narrowest: float, over: dict[str, float]) -> None:
    part = toleranced(sweep=None, **over).design.stable_ranges[0]
    assert part.parameter == "length_m"
    assert [replace(part, start=2 - narrowest * share, end=2.0).settable for share in (0.999, 1.001)] == [False, True]


@pytest.mark.parametrize("over", [{"sweep__to": 2.0}, {"sweep__to": 0.615, "device__length_m": None}, {"sweep": None}])
def test_no_result_of_a_range_too_narrow_to_be_set_is_on_the_first_page(over: dict) -> None:
    verdict = said(toleranced(**NARROW | over))
    assert (verdict.word, verdict.status) == ("Stable only in a range too narrow to be set", "bad")
    text = " ".join(opening_of(verdict).worded().text)
    assert ("Move the length" if over.get("sweep__to") == 2.0 else "Change another input than the length:") in text
    assert "0.608" not in text
    assert not {"margin", "own_stiffness", "shock", "from_rest", "jitter"} & set(verdict.answers)
    assert verdict.voltage.data is None
    assert said(toleranced(**NARROW | over | {"tolerances__length_percent": 1.0})).motion.status == "good"


def test_a_design_must_be_changed_where_it_is_known_to_fail_whatever_weighs_more() -> None:
    """What is not known, or a small margin, is no reason; what is hidden by another conclusion is one."""
    of = Conclusion
    reasons = {of.NOT_STABLE, of.NOT_SETTABLE, of.NOT_MET, of.MORE_ENERGY_THAN_LOST, of.BREAKDOWN}
    reasons |= {of.OTHER_MOTION, of.NOT_FROM_REST}
    assert {conclusion for conclusion in Conclusion if conclusion.fails} == reasons
    verdict = said(solved("inclined"))
    assert not verdict.fails
    assert not replace(verdict, conclusions=(of.NOT_VERIFIED, of.MARGIN_SMALL)).fails
    assert replace(verdict, conclusions=(of.NOT_VERIFIED, of.NOT_FROM_REST)).fails


def test_a_sweep_without_a_design_point_says_where_it_runs() -> None:
    opening = opening_of(said(solved("inclined", device__length_m=None)))
    assert opening.worded().sentence == "It runs for 0.629 m < s ≤ 0.75 m."


@pytest.mark.parametrize(
    ("passed", "decided", "departs"), [(False, True, True), (False, False, False), (True, True, False)]
)
def test_a_simulation_is_said_to_depart_only_where_that_is_decided(passed: bool, decided: bool, departs: bool) -> None:
    opening = opening_of(said(solved("inclined")), (), SimpleNamespace(passed=passed, decided=decided))
    assert ("not_reproduced" in [fact.said.macro for fact in opening.facts]) is departs


def test_the_margin_that_a_comparison_tells_is_a_share_where_the_design_value_is_not_0() -> None:
    known = said(solved("inclined", inclination_deg=44.0))
    room, _ = margin_said(known)
    assert room.macro == "room"
    assert room.words().replace("\u00a0", " ") == tile(solved("inclined", inclination_deg=44.0), "margin")[1]


def test_soft_membranes_are_said_not_to_be_known_only_where_they_are_not() -> None:
    known = said(solved("horizontal"))
    assert not known.margin.data.not_known
    room, limited = (part.words().replace("\u00a0", " ") for part in margin_said(known))
    assert (room, limited) == ("15 % in frequency", "rigid impacts")


def test_an_alert_whose_substance_is_a_fact_is_no_fact_as_well() -> None:
    for code, repeated in ((AlertCode.DEEP_DEFLECTION, False), (AlertCode.SENSITIVE_TO_BALL_MASS, True)):
        opening = opening_of(said(solved("inclined")), [SimpleNamespace(code=code, severity=Severity.WARNING)])
        assert ("alert" in [fact.said.macro for fact in opening.facts]) is repeated


def test_two_stable_ranges_of_a_sweep_are_both_told() -> None:
    known = said(solved("horizontal"))
    (part,) = known.where.data
    tiles = opening_of(replace(known, where=replace(known.where, data=(part, part)))).tiles
    assert tiles[0].said.macro == "tile_ranges"
