"""Comparing scenarios: the numbers of the paper side by side, figures on shared axes, sentences that name both."""

from __future__ import annotations

import csv
import io
import json
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from conftest import EXAMPLES, first, sentences, study
from matplotlib.figure import Figure
from msgspec import UNSET
from msgspec.structs import replace
from pages import Page, render_html
from PIL import Image

import vireport
from vireport import analyse, compare_figure, load, loads
from vireport.base.errors import NumericalError, ScenarioError, UsageError
from vireport.base.records import plain
from vireport.cli.outputs import PageSettings
from vireport.comparison.comparison import Comparison, compare, left_out
from vireport.comparison.figures import compare_pictures
from vireport.comparison.outputs import comparison_provenance, render_comparison, terminal_summary
from vireport.comparison.pages import ComparisonReport
from vireport.comparison.ranking import Merit, Ranked, rank_studies, ranking_table
from vireport.comparison.results import CompareData
from vireport.comparison.variants import variants
from vireport.design.solution import solution_of
from vireport.figures.overlay import SCENARIO_COLORS
from vireport.findings.outcomes.outcomes import Outcomes
from vireport.findings.outcomes.withstood import withstood_by
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.report.changes.quantities import STANDARD_ERRORS, ComparedScenario, QuantityGroup, compared_scenarios
from vireport.report.changes.sentences import listed
from vireport.report.changes.table import NO_DIFFERENCE, ComparisonRow, axes_of, comparison_rows
from vireport.report.rendering import render_markdown
from vireport.scenario.parameters import DesignInput
from vireport.study.judging.least_margin import margin_to_use
from vireport.study.judging.verdict import Conclusion
from vireport.study.measured import measured_data, measured_of
from vireport.study.reading import read_record
from vireport.study.result_records import Results
from vireport.study.results import analytic_results
from vireport.study.study import Study
from vireport.text.said import Said, spoken

THREE = ("horizontal", "inclined", "inclined-forcing")
PAPER_PANELS = {"figure-2": (3, 3), "figure-4": (2, 3), "figure-7": (1, 3)}


@cache
def three() -> Comparison:
    return compare([study(name) for name in THREE])


@cache
def inclinations() -> Comparison:
    return compare(EXAMPLES / "inclined.yaml", vary={"inclination_deg": [0, 5, 15, 30, 45]})


def room(scenario: Ranked) -> list[str]:
    """The margin to use, and what limits it."""
    return spoken([*scenario.room])


def row_of(comparison: Comparison, start: str, end: str = "") -> ComparisonRow:
    (row,) = [x for x in comparison.quantities if x.quantity.startswith(start) and x.quantity.endswith(end)]
    return row


# Numbers


def test_the_papers_critical_points_stand_side_by_side_in_d() -> None:
    b1 = row_of(three(), "B1, period doubling", ", d")
    np.testing.assert_allclose(b1.values, [0.1870532313, 0.4179595416, 0.2792918143], rtol=1e-9)
    assert b1.change == pytest.approx(1 - 0.1870532313 / 0.4179595416, rel=1e-8)
    c1 = row_of(three(), "C1, pitchfork", ", d")
    assert c1.values == (pytest.approx(0.2634315843, rel=1e-9), None, None)
    assert c1.differs
    assert c1.change is None


def test_swept_values_are_compared_only_where_the_same_parameter_is_swept() -> None:
    in_s = row_of(three(), "B1, period doubling", ", s")
    assert in_s.unit == "m"
    assert in_s.values[:2] == (pytest.approx(0.281707, abs=1e-6), pytest.approx(0.629457, abs=1e-6))
    assert in_s.values[2] is None
    assert in_s.notes[2] == "sweeps the force amplitude"
    assert not [x for x in three().quantities if x.quantity.endswith(", F")]
    over_angles = compare([study("inclined", "sweep.parameter=inclination_deg", "sweep.from=0", "sweep.to=80",
                                 f"excitation.amplitude_n={force}") for force in (3.0, 3.2)])  # fmt: skip
    assert {x.unit for x in over_angles.quantities if x.group == "critical point"} == {"°"}


def test_d_stands_beside_the_swept_value_where_it_is_another_multiple_of_it() -> None:
    heavier = compare([study("inclined"), study("inclined", "excitation.amplitude_n=3.3")])
    length, d = row_of(heavier, "B1", ", s"), row_of(heavier, "B1", ", d")
    ratio = np.divide(d.values, length.values)
    assert ratio[0] == pytest.approx(1.1 * ratio[1], rel=1e-9)


def test_a_free_capsule_is_compared_with_a_prescribed_one() -> None:
    both = compare([study("design-point"), study("design-point", "device.capsule=free")])
    assert sorted(scenario.rank for scenario in both.ranking) == [1, 2]


def test_a_scenario_is_no_different_from_itself() -> None:
    same = compare([study("horizontal"), analyse(load(EXAMPLES / "horizontal.yaml"))])
    assert same.differences == ()
    assert same.settings == ()
    assert same.names == ("horizontal", "horizontal (2)")
    assert all(x.change in (0.0, None) for x in same.quantities)


def test_what_matters_comes_first_and_of_it_what_only_some_have_and_what_changed_most() -> None:
    groups = [x.group for x in three().quantities]
    assert list(dict.fromkeys(groups)) == [
        *("design point", "disturbances", "stable range", "margin", "voltage", "critical point"),
    ]
    assert groups == sorted(groups, key=list(QuantityGroup).index)
    changes = [x.change for x in three().differences if x.group == "critical point"]
    assert changes[:6] == [None] * 6  # A1, A2, A3, C1, G1, G2
    assert changes[6:] == sorted(changes[6:], reverse=True)


# Ranking


def facts(comparison) -> list[str]:
    return [text for _, text in comparison.opening.worded().facts]


@pytest.mark.slow
def test_the_largest_margin_to_use_is_best_and_numbers_are_those_of_the_studies() -> None:
    ranked = inclinations().ranking
    rooms = [place.merits[Merit.MARGIN] for place in ranked]
    assert rooms == sorted(rooms, reverse=True)
    for place in ranked:
        design, use = place.study.solution.design, margin_to_use(place.study.verdict.evidence)
        assert place.merits[Merit.MARGIN] == (0.0 if use.gone else use.relative)
        assert place.merits[Merit.MARGIN] <= min(
            abs(end.relative) for end in design.limits() if end.relative is not None
        )
        assert place.to_dict()["margin_to_use"]["relative"] == use.relative
        assert place.merits[Merit.VOLTAGE] == design.voltages_by_motion.average_v[0]
        assert (
            place.merits[Merit.RATE] == 2 * 2.0 * design.voltages_by_motion.average_v[0]
        )  # two impacts a period of 2 Hz
    whole = json.loads(json.dumps(inclinations().to_dict(), allow_nan=False))
    assert plain(read_record(whole, CompareData, "compare.json")) == whole
    data = whole["ranking"]
    assert [row["rank"] for row in data] == [1, 2, 3, 4, 5]
    (row,) = [row for row in data if row["scenario"] == "inclination 45°"]
    assert row["smallest_margin"] == pytest.approx(0.04722322153840652, rel=1e-9)
    assert (row["margin_parameter"], row["margin_kind"]) == ("frequency_hz", "period_doubling")
    assert row["margin_to_use"]["limited_by"] == "effect"
    assert 0 < row["margin_to_use"]["relative"] < row["smallest_margin"] / 4


def test_a_rigid_margin_does_not_win_over_a_larger_margin_to_use() -> None:
    """By rigid impacts alone the device with soft membranes would come first."""
    ranked = three().ranking
    shown = {x.name: room(x) for x in ranked}
    assert shown["inclined"][1] == "a bottom membrane that rebounds 5 % less"
    table = ranking_table(ranked)
    titles = [column.title for column in table.columns]
    assert titles[titles.index("Margin to use") + 1] == "Limited by"
    assert [row[titles.index("Limited by")] for row in table.rows] == [room(x)[1] for x in ranked]
    assert [row[titles.index("Margin to use")] for row in table.rows] == [room(x)[0] for x in ranked]


def test_two_that_are_amber_for_different_reasons_both_say_both() -> None:
    """A small margin is the first conclusion of one; that its membrane stretches far is said of it all the same."""
    pair = compare([study("inclined"), study("inclined-forcing")], names=("near", "far"))
    small, far = Conclusion.MARGIN_SMALL, Conclusion.STRETCHED_FAR
    assert [(small in x.study.verdict.conclusions, far in x.study.verdict.conclusions) for x in pair.ranking] == [
        (True, False), (True, True),
    ]  # fmt: skip
    assert "Margin small: all; stretched farther than demonstrated: far." in facts(pair)
    rows = {row[0]: row[2] for row in ranking_table(pair.ranking).rows}
    assert rows == {"near": "Margin small", "far": "Margin small; stretched farther than demonstrated"}


@pytest.mark.slow
def test_a_comparison_of_five_opens_in_few_words_and_numbers() -> None:
    five = compare(EXAMPLES / "inclined.yaml", vary={"device.length_m": [0.6, 0.65, 0.6934, 0.7, 0.75]})
    worded = five.opening.worded()
    assert worded.sentence == "Best: length 0.75 m, with the largest margin to use."
    first, second = five.ranking[:2]
    assert [text for _, text in worded.facts] == [
        "Not stable: length 0.6 m.",
        "Margin small: length 0.7 m, 0.6934 m and 0.65 m.",
        f"Margin to use of the next, length 0.7 m: {room(second)[0]}.",
    ]
    assert [tile.label for tile in worded.tiles] == ["Stable length", "Margin to use", "From rest", "Mean voltage"]
    assert worded.tiles[1].value == room(first)[0]
    assert len(worded.sentence.split()) <= 15
    (drawn,) = [picture for picture in compare_pictures(five) if picture.name == "figure-variants"]
    report = ComparisonReport(five, {drawn.name: drawn}, comparison_provenance(five, ""))
    page = Page(re.sub(rb"<svg.*?</svg>", b"", render_html(report), flags=re.S))  # ticks and legends are no sentences
    first_page = page.text[page.text.index(worded.sentence) : page.text.index("Ranking, the best first")]
    assert len(first_page.split()) <= 150
    assert len(re.findall(r"\d+(?:[.:]\d+)?", first_page)) <= 25
    assert terminal_summary(five).splitlines() == worded.lines
    assert worded.lines[2] == "Not stable: length 0.6 m."


def test_requirements_come_before_stability_and_stability_before_margin() -> None:
    strict = study("inclined", "requirements.margin_any_percent=10")
    unstable = study("inclined", "inclination_deg=60")
    ranked = compare([strict, unstable, study("inclined")], names=("strict", "unstable", "plain")).ranking
    assert [(scenario.name, scenario.rank) for scenario in ranked] == [("plain", 1), ("unstable", 2), ("strict", 3)]
    two = compare([unstable, study("inclined")], names=("unstable", "plain"))
    assert two.headline == "Best: plain; the next, unstable, is not stable."
    assert facts(two)[0] == "Not stable: unstable."


@pytest.mark.slow
def test_a_motion_that_no_device_can_be_set_to_is_no_stable_one() -> None:
    """1:1 motion from 0.6083 to 0.6125 m, with lengths off by 10 %: the verdict says so, and ranking follows it."""
    narrow = ["device.length_m=0.61", "excitation.amplitude_n=6.9375", "tolerances.length_percent=10"]
    studies = {name: analyse(load(EXAMPLES / "inclined.yaml", over)) for name, over in (("a", narrow), ("b", []))}
    assert studies["a"].verdict.conclusion is Conclusion.NOT_SETTABLE
    best, other = rank_studies(studies)
    assert [(row.name, row.stable) for row in (best, other)] == [("b", True), ("a", False)]
    assert other.to_dict()["margin_to_use"] is None


def test_scenarios_are_ranked_by_the_requirements_that_they_miss_and_the_sentence_says_so() -> None:
    margin, volts = "requirements.margin_any_percent=4", "requirements.u_ave_at_least_v=1"
    few = study("inclined", "requirements.margin_any_percent=4")
    more = study("inclined", margin, volts, "requirements.acceleration_at_most_g=0.1")
    pair = compare([more, few], names=("more", "few"))
    assert [(x.name, x.passed, len(x.study.criteria)) for x in pair.ranking] == [("few", 1, 1), ("more", 2, 3)]
    assert pair.headline == "Best: few, with the fewest requirements missed."
    assert "Requirements missed: 0 of 1; by the next, more, 1 of 3." in facts(pair)
    free = compare([more, study("inclined")], names=("more", "free"))
    assert "Requirements missed: 0 of 0; by the next, more, 1 of 3." in facts(free)


def test_a_margin_that_is_not_known_is_not_told_as_a_number() -> None:
    def unresolved(restitution: float) -> Study:
        known = study("design-point", f"device.restitution={restitution}")
        design = replace(known.solution.design, unresolved_inputs=(DesignInput.LENGTH,))
        return replace(known, solution=replace(known.solution, design=design))

    pair = compare([unresolved(0.5), unresolved(0.52)], names=("first", "second"))
    assert pair.headline == "Best: first, with the highest voltage at equal margin."
    assert room(pair.ranking[0]) == ["not known", "rounding hides the end"]
    (told,) = [fact for fact in facts(pair) if fact.startswith("Mean voltage")]
    volts = [x.show(Merit.VOLTAGE) for x in pair.ranking]
    assert told == f"Mean voltage of the next, second: {volts[1]}."


def test_what_has_nothing_left_to_use_has_no_less_than_nothing() -> None:
    """However far beyond the end an effect moves it: those are alike in margin."""
    studies = [study("inclined", f"device.length_m={length}") for length in (0.635, 0.632)]
    uses = [x.verdict.margin.data.to_use for x in studies]
    assert all(use.gone and use.relative < 0 for use in uses)
    ranked = compare(studies, names=("longer", "shorter")).ranking
    assert [scenario.merits[Merit.MARGIN] for scenario in ranked] == [0.0, 0.0]
    for scenario in ranked:  # by rigid impacts some is left, as a share of the value
        nearest = scenario.study.solution.design.limits()[0]
        assert scenario.data.smallest_margin == pytest.approx(abs(nearest.distance / 2.0))  # of the frequency, 2 Hz


def test_voltage_that_costs_margin_is_told() -> None:
    assert [scenario.name for scenario in three().ranking] == ["horizontal", "inclined", "inclined-forcing"]
    assert three().headline == "Best: horizontal, by its margin with rigid membranes."
    (told,) = [fact for fact in facts(three()) if fact.startswith("The highest mean voltage")]
    most, first = three().ranking[2], three().ranking[0]
    more = most.merits[Merit.VOLTAGE] / first.merits[Merit.VOLTAGE] - 1
    volts = most.show(Merit.VOLTAGE)
    assert told == f"The highest mean voltage is that of inclined-forcing: {volts} (+{100 * more:.0f} %), margin none."


def test_a_comparison_opens_with_a_sentence_and_the_tables_are_told_where_they_are_asked_for() -> None:
    varied = compare(EXAMPLES / "inclined.yaml", vary={"inclination_deg": [0, 15, 60]})
    assert facts(varied)[0] == "Not stable: inclination 60°."
    assert "Ranking" not in terminal_summary(varied)
    first, _, rest = terminal_summary(varied, tables=True).partition("Ranking, the best first")
    assert first.strip().splitlines() == varied.opening.worded().lines
    assert "quantities differ:" in rest
    page = ComparisonReport(varied, {}, comparison_provenance(varied, ""), None, "comparison-summary.md.j2")
    assert "Not stable: inclination 60°." in render_markdown(page).decode()


@pytest.mark.parametrize(
    ("vary", "names"),
    [
        ("inclination_deg=7.5,30", ["inclination 7.5°", "inclination 30°"]),
        ("excitation.amplitude_n=3.0,3.2", ["force amplitude 3.0 N", "force amplitude 3.2 N"]),
        ("device.membrane.bias_voltage_v=1000,2000", ["bias voltage 1000 V", "bias voltage 2000 V"]),
        ("device.restitution=0.4,0.5", ["restitution 0.4", "restitution 0.5"]),
        ("sweep.to=0.7,0.75", ["to = 0.7", "to = 0.75"]),
    ],
)
def test_variants_are_named_by_what_is_varied_with_its_unit(vary: str, names: list[str]) -> None:
    assert [one.name for one in variants([EXAMPLES / "inclined.yaml"], [vary], None, (), False)] == names


@pytest.mark.slow
def test_the_voltages_of_a_scenario_without_stable_motion_do_not_flatten_those_of_the_others() -> None:
    pair = compare([study("inclined"), study("inclined", "inclination_deg=60")], names=("stable", "unstable"))
    overlay = compare_pictures(pair)[0]
    speeds, volts = (panel.get_ylim() for panel in overlay.figure.axes)
    stable = study("inclined").solution.design.voltages_by_motion.average_v[0] / 1e3
    least = min(branch.voltages_by_motion.average_v.min() / 1e3 for branch in pair.studies[1].solution.branches)
    assert least < 0.8 * stable < volts[0] < stable < volts[1] < 1.2 * stable
    assert speeds[0] < 4 < speeds[1]
    assert "No voltages where there is no stable motion: unstable" in overlay.caption


PULLED = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5, length_m: 0.75}
excitation: {amplitude_n: 3.6, frequency_hz: 2}
inclination_deg: 45
"""


@cache
def pulled(force: float) -> Study:
    """A device whose stable motion is reached from rest at 3.2, 3.4 and 4.4 N, not at 3.6 N; at 6.5 N none is."""
    return analyse(loads(PULLED, overrides=[f"excitation.amplitude_n={force}"]), ("json",))


def test_what_is_reached_from_rest_comes_first_where_that_is_asked_for() -> None:
    names, studies = ("reached", "missed", "unstable"), [pulled(force) for force in (4.4, 3.6, 6.5)]
    usual = compare(studies, names=names).ranking
    assert [scenario.name for scenario in usual] == ["missed", "reached", "unstable"]  # by the margin
    asked = compare(studies, names=names, rank_by=("from-rest", "recovery"))
    assert [scenario.name for scenario in asked.ranking] == list(names)
    assert asked.headline == "Best: reached, reached from rest."
    assert "It starts by itself; the next, missed, comes to rest every 3 forcing periods (B~)." in facts(asked)
    table = ranking_table(asked.ranking)
    assert "reached from rest, recovery, margin to use" in table.note
    columns = dict(zip((column.title for column in table.columns), zip(*table.rows, strict=True), strict=True))
    assert columns["From rest"][:2] == ("BT every forcing period", "rest every 3 forcing periods (B~)")
    assert "Least shock" not in columns
    for scenario, shown in zip(asked.ranking[:2], columns["Recovery"], strict=False):
        found = scenario.study.to_dict()["disturbances"]
        assert shown == f"{found['recovery_periods']:.3g} periods"
        assert scenario.to_dict()["recovery_periods"] == found["recovery_periods"]
        assert scenario.to_dict()["from_rest"] == found["from_rest"]["outcome"]


def test_disturbances_that_die_out_sooner_and_larger_shocks_come_first_where_that_is_asked_for() -> None:
    pytest.importorskip("numba")
    studies = [pulled(force) for force in (3.2, 3.6, 6.5)]
    by_recovery = compare(studies, names=("slow", "fast", "unstable"), rank_by=("recovery",))
    assert [scenario.name for scenario in by_recovery.ranking] == ["fast", "slow", "unstable"]
    assert by_recovery.headline == "Best: fast; disturbances die out soonest."
    assert "A small disturbance dies out in 17.2 periods; in the next, slow, in 19.4 periods." in facts(by_recovery)
    bumped = [
        replace(each, findings={"outcomes": Outcomes(withstood=withstood_by(each.solution, True))})
        for each in (*studies, pulled(3.4))
    ]
    names = ("tough", "weak", "unstable", "tougher")
    ranking = rank_studies(dict(zip(names, bumped, strict=True)), (Merit.SHOCK,))
    assert [scenario.name for scenario in ranking] == ["tough", "tougher", "weak", "unstable"]
    tough, tougher, weak = ranking[:3]
    assert tough.show(Merit.SHOCK).startswith("more than 6.4")
    assert weak.merits[Merit.SHOCK] == weak.study.to_dict()["disturbances"]["shock"]["least_jump_m_s"]
    row = row_of(compare(bumped[:3], names=names[:3]), "least shock that leads out")
    assert row.values == (None, weak.merits[Merit.SHOCK], None)
    assert row.notes[0].startswith("none found up to 6.4")
    # What was tried farther is no more withstood.
    assert tougher.study.outcomes.withstood.searched_to_m_s > tough.study.outcomes.withstood.searched_to_m_s
    assert tougher.merits[Merit.SHOCK] == tough.merits[Merit.SHOCK]


@pytest.mark.slow
def test_where_no_1_1_motion_is_stable_that_which_is_reached_from_rest_is_ranked_by_its_least_shock() -> None:
    """At 0.3 m a motion BBT is the only one, at 0.225 m one beside another, out of which little leads."""
    pytest.importorskip("numba")
    device = "device: {{capsule_mass_kg: 0.1245, restitution: 0.5, length_m: {}}}"
    rest = "excitation: {{amplitude_n: {}, frequency_hz: {}}}\ninclination_deg: {}\ndisturbances: {{}}\n"
    texts = [
        f"schema_version: 1\n{device.format(length)}\n{rest.format(*others)}"
        for length, others in ((0.3, (3.0, 2.0, 45)), (0.225, (5.0, 2.5, 30)))
    ]
    alone, beside = (analyse(loads(text), ("json",)) for text in texts)
    assert alone.outcomes.withstood is beside.outcomes.withstood is None
    ranking = rank_studies({"beside": beside, "alone": alone}, (Merit.SHOCK,))
    assert [scenario.name for scenario in ranking] == ["alone", "beside"]
    told = [scenario.to_dict()["least_jump_m_s"] for scenario in ranking]
    known = beside.to_dict()["disturbances"]["coexistence"]["motions"]
    assert told == [None, next(each["least_jump_m_s"] for each in known if each["reached_from_rest"])]
    assert told[1] is not None
    assert ranking[0].show(Merit.SHOCK).startswith("more than")


def test_what_cannot_be_ranked_is_refused_before_anything_is_computed() -> None:
    plain, bumped = loads(PULLED), loads(f"{PULLED}disturbances: {{}}\n")
    with pytest.raises(UsageError, match="plain cannot be ranked by shock: the scenario has no disturbances block"):
        compare([bumped, plain], names=("bumped", "plain"), rank_by=("shock",))
    with pytest.raises(UsageError, match=r"'shok' \(allowed: from-rest, recovery, shock\)"):
        compare([plain, bumped], rank_by=("shok",))


def test_diff_tells_that_the_motion_is_no_longer_reached_from_rest() -> None:
    changed = vireport.diff(pulled(3.2).to_dict(), pulled(3.6))
    (row,) = [row for row in changed if row.quantity == "from rest"]
    assert (row.before, row.after) == ("reaches 1:1 motion", "rest cycle")


def test_without_a_design_point_the_widest_stable_range_is_best() -> None:
    ranges = compare([study("inclined", "device.length_m=", f"device.restitution={r}") for r in (0.5, 0.6)])
    assert [scenario.merits[Merit.RANGE] for scenario in ranges.ranking] == [
        pytest.approx(0.16),
        pytest.approx(0.120542859),
    ]
    assert ranges.headline.endswith(", with the widest stable range.")
    assert any(fact.startswith("Stable for 0.59 m ≤ s ≤ 0.75 m; the next, ") for fact in facts(ranges))


def test_a_ranking_gives_the_ends_of_a_stable_range_in_the_digits_that_the_contacts_leave() -> None:
    ranked = compare([study("inclined"), study("inclined", "device.restitution=0.6")]).ranking
    for scenario in ranked:
        assert scenario.show(Merit.RANGE) == "; ".join(scenario.study.verdict.inequalities)
    assert any("0.629 m < s" in scenario.show(Merit.RANGE) for scenario in ranked)


def test_a_scenario_without_a_design_point_comes_after_those_with_a_margin() -> None:
    mixed = compare([study("inclined", "device.length_m="), study("inclined")], names=("range", "point"))
    assert [scenario.name for scenario in mixed.ranking] == ["point", "range"]
    assert "Margin to use of the next, range: none." in facts(mixed)
    assert mixed.remarks == ("No design point, and so no margin to compare: range.",)


def test_of_two_stable_motions_the_one_with_less_voltage_counts() -> None:
    tilted = study("horizontal", "inclination_deg=1", "device.length_m=0.36")
    volts = tilted.solution.design.voltages_by_motion.average_v[tilted.solution.design.motions.stable_mask]
    assert len(volts) == 2
    assert volts.min() < 0.999 * volts.max()
    both = compare([tilted, study("horizontal")])
    (ranked,) = [x for x in both.ranking if x.study is tilted]
    assert (ranked.merits[Merit.VOLTAGE], ranked.merits[Merit.RATE]) == (volts.min(), 4 * volts.min())  # twice 2 Hz
    of = row_of(both, "U_ave of the stable motion at the design point")
    assert (of.values[0], of.notes[0]) == (volts.min(), "the least of 2")


def test_equals_share_a_rank_and_where_nothing_is_stable_nothing_is_best() -> None:
    same = compare([study("horizontal"), study("horizontal")], names=("one", "two"))
    assert [scenario.rank for scenario in same.ranking] == [1, 1]
    assert same.headline == "Equally good: one and two."
    none = compare([study("inclined", "inclination_deg=60"), study("inclined", "inclination_deg=75")])
    assert none.headline == "None is stable at its design point or in its sweep."
    steep = [study("inclined", "inclination_deg=60", *more) for more in ((), (), ("requirements.u_ave_at_least_v=1",))]
    third = compare(steep, names=("one", "two", "three"))
    assert [x.rank for x in third.ranking] == [1, 1, 3]
    assert "Requirements missed: 0 of 0; by the next, three, 1 of 1." in facts(third)


def test_sentences_have_the_scenarios_and_their_numbers() -> None:
    b1 = row_of(three(), "B1, period doubling", ", d").sentence
    assert "d = 0.187 for horizontal, 0.418 for inclined and 0.279 for inclined-forcing" in b1
    assert "55 % apart" in b1
    assert row_of(three(), "C1").sentence.endswith("d = 0.263 for horizontal; none in the sweep for inclined and "
                                                  "inclined-forcing.")  # fmt: skip
    assert "42.8 kV for inclined" in row_of(three(), "U_ave of the stable").sentence
    assert "stable focus" in row_of(three(), "stable 1:1 motions").sentence
    assert [x for x in three().differences if x.group == "design point"]  # a focus and two nodes


def test_margins_and_voltages_are_those_of_the_studies() -> None:
    margin = row_of(three(), "margin from the design point to the period doubling below", "in d")
    for value, name in zip(margin.values, THREE, strict=True):
        points = study(name).solution.critical_points
        b1 = next(x.d for x in points if x.label == "B1")
        assert value == pytest.approx(100 * (b1 / float(study(name).solution.design.motions.d[0]) - 1), rel=1e-9)
    volts = row_of(three(), "U_ave of the stable")
    assert volts.values == tuple(study(name).solution.design.voltages_by_motion.average_v[0] for name in THREE)
    highest, lowest = row_of(three(), "highest U_ave"), row_of(three(), "lowest U_ave")
    assert all(a > b for a, b in zip(highest.values, lowest.values, strict=True))


def test_margins_that_would_read_alike_name_the_family() -> None:
    """Horizontal, the fold is of the symmetric motions; inclined, it is of others."""
    names = [row.quantity for row in three().quantities]
    assert len(set(names)) == len(names)
    above = "margin from the design point to the fold above, in s"
    symmetric, asymmetric = (
        row_of(three(), f"{above}, of the {family} motion") for family in ("symmetric", "asymmetric")
    )
    assert symmetric.values == (pytest.approx(164.705001043), None, None)
    assert asymmetric.values == (None, pytest.approx(106.583365932), pytest.approx(244.163312761))
    assert asymmetric.sentence.startswith(
        "Margin from the design point to the fold above, in s, of the asymmetric motion:"
    )
    alone = compare([study("inclined"), study("inclined-forcing")])
    assert row_of(alone, above).quantity == above


def test_what_was_not_asked_for_is_no_difference() -> None:
    lacking = compare([study("inclined"), study("inclined", "device.ball_mass_kg=")])
    volts = row_of(lacking, "U_ave of the stable")
    assert volts.notes[1] == "device.ball_mass_kg is not given"
    assert not [x for x in lacking.differences if x.group == "voltage"]
    point = compare([study("design-point"), study("inclined")])
    b1 = row_of(point, "B1, period doubling of")
    assert b1.values[0] is None
    assert not b1.differs


def test_stable_ranges_have_numbers_where_a_scenario_has_several() -> None:
    tilted = compare([study("horizontal", "inclination_deg=15", f"device.restitution={r}") for r in (0.5, 0.4)])
    ranges = [study.solution.stable_ranges for study in tilted.studies]
    assert [len(parts) for parts in ranges] == [2, 1]
    assert row_of(tilted, "stable range 1 from").values == tuple(parts[0].start for parts in ranges)
    second = row_of(tilted, "stable range 2 to")
    assert second.values == (ranges[0][1].end, None)
    assert second.notes[1] == "no further stable range"


def test_losing_stable_motion_stands_at_the_top() -> None:
    lost = compare([study("inclined"), study("inclined", "inclination_deg=60")])
    assert lost.quantities[0].quantity == "stable 1:1 motions at the design point"
    assert lost.quantities[0].sentence.endswith("none for inclined, inclination 60°.")
    margins = [row.notes for row in lost.quantities if row.group is QuantityGroup.MARGIN]
    assert {notes[1] for notes in margins} == {"no stable 1:1 motion at the design point"}
    assert row_of(lost, "stable range from").notes[1] == "no stable 1:1 motion"


# Variants


@pytest.mark.slow
def test_two_varied_keys_make_a_grid() -> None:
    grid = compare(EXAMPLES / "design-point.yaml", vary=["device.restitution=0.4,0.5", "inclination_deg=30,45"])
    assert grid.names[:2] == (
        "restitution 0.4, inclination 30°",
        "restitution 0.4, inclination 45°",
    )
    pairs = [(x.scenario.device.restitution, x.scenario.inclination_deg) for x in grid.studies]
    assert pairs == [(0.4, 30), (0.4, 45), (0.5, 30), (0.5, 45)]
    assert {setting.quantity for setting in grid.settings} == {"device.restitution", "inclination_deg"}
    assert compare_pictures(grid) == ()  # no sweep, nothing to draw along
    assert left_out(grid, "figure-2") == [(name, Said("has_no_sweep", (), "compare")) for name in grid.names]


@pytest.mark.slow
def test_words_and_what_may_vary_are_settings_as_the_scenarios_have_them() -> None:
    required = study("inclined", "requirements.words=[BT]", "motions.impacts=2", "motions.periods=1")
    pair = compare([required, study("best-design")])
    written = {}
    for table in ComparisonReport(pair, {}, comparison_provenance(pair, "")).settings():
        assert [column.title for column in table.columns] == ["Key", *pair.names]
        written |= {key: values for key, *values in table.rows}
    assert written["requirements.words"] == ["BT", "\u2014"]
    assert written["design.vary.1.path"] == ["\u2014", "excitation.frequency_hz"]


def test_a_variant_is_the_scenario_with_that_value() -> None:
    varied = inclinations().studies[3]
    alone = study("inclined", "inclination_deg=30")
    assert varied.to_dict()["stable_range"] == alone.to_dict()["stable_range"]
    np.testing.assert_array_equal(varied.solution.design.motions.q, alone.solution.design.motions.q)


def test_values_with_commas_are_kept_together() -> None:
    varied = compare(EXAMPLES / "design-point.yaml", vary=["title='a, b',c"])
    assert [x.scenario.title for x in varied.studies] == ["a, b", "c"]


def test_mistakes_name_the_variant_and_all_are_told() -> None:
    with pytest.raises(ScenarioError) as failure:
        compare(EXAMPLES / "inclined.yaml", vary=["inclination_deg=15,95,120"])
    lines = str(failure.value).splitlines()
    assert len(lines) == 2
    assert "inclination_deg = 95" in lines[0]
    assert "inclination_deg = 120" in lines[1]


def test_mistakes_of_several_files_are_told_file_by_file(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / f"{name}.yaml").write_text("schema_version: 1\nnonsense: 1\n")
    with pytest.raises(ScenarioError) as failure:
        compare([tmp_path / "one.yaml", tmp_path / "two.yaml"])
    text = str(failure.value)
    assert f"{tmp_path / 'one.yaml'}:2: nonsense" in text
    assert f"{tmp_path / 'two.yaml'}:2: nonsense" in text


def test_a_scenario_outside_the_theory_is_named() -> None:
    with pytest.raises(NumericalError, match=r"restitution 1: "):
        compare(EXAMPLES / "design-point.yaml", vary=["device.restitution=0.5,1"])


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        (["inclination_deg"], "not of the form"),
        (["inclination_deg=1,,2"], "a value is missing"),
        (["inclination_deg=1,1"], "given twice"),
        (["inclination_deg=1,2", "inclination_deg=3,4"], "varied twice"),
        ([f"inclination_deg={','.join(map(str, range(60)))}"], "60 scenarios are too many"),
        (None, "at least two"),
    ],
)
def test_a_comparison_that_cannot_be_made_says_why(vary: list[str] | None, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        compare(EXAMPLES / "inclined.yaml", vary)


def test_names_are_the_files_and_never_alike() -> None:
    assert three().names == THREE
    named = compare([study("inclined"), study("horizontal")], names=("change", "change"))
    assert named.names == ("change", "change (2)")
    assert [row["scenario"] for row in named.rows()] == ["change", "change (2)"]
    with pytest.raises(UsageError, match="3 names for 2"):
        compare([study("inclined"), study("horizontal")], names=("a", "b", "c"))
    assert spoken(listed(["b = 1", "b = 2", "b = 3"])) == "b = 1, 2 and 3"
    assert spoken(listed(["a, b = 1", "a, b = 2"])) == "a, b = 1 and a, b = 2"
    assert spoken(listed(["a, b", "c", "d"])) == "a, b; c; and d"


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    for folder in ("old", "new"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "point.yaml").write_bytes((EXAMPLES / "design-point.yaml").read_bytes())
    assert compare([tmp_path / "old" / "point.yaml", tmp_path / "new" / "point.yaml"]).names == (
        "old/point",
        "new/point",
    )


# Figures


def panels(figure: Figure) -> list[list[tuple[float, float]]]:
    """Limits of the vertical axes, by rows from the top one down."""
    rows: dict[float, list[tuple[float, tuple[float, float]]]] = {}
    for axes in figure.axes:
        place = axes.get_position()
        rows.setdefault(round(place.y0, 9), []).append((place.x0, axes.get_ylim()))
    return [[y for _, y in sorted(rows[low])] for low in sorted(rows, reverse=True)]


@pytest.mark.parametrize("name", first(1, PAPER_PANELS))
def test_the_papers_figures_are_there_panel_for_panel_on_shared_axes(name: str) -> None:
    (figure,) = compare_figure(three(), name)
    limits = panels(figure)
    assert (len(limits), len(limits[0])) == PAPER_PANELS[name]
    for row in limits:
        assert len(set(row)) == 1
    rows, columns = PAPER_PANELS[name]
    grid = np.array(figure.axes).reshape(rows, columns)
    letters = [text.get_text() for axes in grid.T.ravel() for text in axes.texts if text.get_text().startswith("(")]
    assert letters == [f"({letter})" for letter in "abcdefghi"[: rows * columns]]
    assert [axes.get_title() for axes in grid[0]] == list(THREE)


@pytest.mark.slow
def test_a_column_draws_what_the_figure_of_its_scenario_draws() -> None:
    single = vireport.figure_2(study("inclined"))
    (grid,) = compare_figure(three(), "figure-2")
    column = [axes for axes in grid.axes if abs(axes.get_position().x0 - grid.axes[1].get_position().x0) < 1e-9]

    def drawn(axes: object) -> list[np.ndarray]:
        return [line.get_xydata() for line in axes.lines if 2.1 < line.get_zorder() < 3]

    for k, (one, other) in enumerate(zip(single.axes, column, strict=True)):
        assert drawn(one)
        for left, right in zip(drawn(one), drawn(other), strict=True):
            np.testing.assert_array_equal(left[:, 0], right[:, 0])
            turns = (left[:, 1] - right[:, 1]) / (2 * np.pi)  # of phases, which the grid may cut elsewhere
            np.testing.assert_allclose(turns, np.round(turns) if k == 1 else 0 * turns, rtol=0, atol=1e-12)


def test_a_row_holds_the_values_of_every_scenario() -> None:
    (figure,) = compare_figure(three(), "figure-7")
    low, high = panels(figure)[0][0]
    volts = [branch.voltages_by_motion.average_v / 1e3 for name in THREE for branch in study(name).solution.branches]
    branches = [branch for name in THREE for branch in study(name).solution.branches]
    for u, branch in zip(volts, branches, strict=True):
        admissible = u[branch.motions.admissible_mask]
        assert ((admissible > low) & (admissible < high)).all()


@pytest.mark.slow
def test_scenarios_on_one_axis_are_drawn_in_the_order_of_their_ranks() -> None:
    figure = compare_pictures(three())[0].figure
    speed, voltage = figure.axes
    for axes in (speed, voltage):
        solid = [line for line in axes.lines if line.get_linestyle() == "-" and line.get_color() == SCENARIO_COLORS[1]]
        inclined = next(line for line in solid if len(line.get_xdata()) > 2)
        x, y = inclined.get_data()
        assert (x[0], x[-1]) == (pytest.approx(0.4179595416, rel=1e-9), pytest.approx(0.498, rel=1e-9))
        design = study("inclined").solution.design
        at = float(design.motions.d[0])
        value = {speed: 6.0518, voltage: design.voltages_by_motion.average_v[0] / 1e3}[axes]
        assert np.interp(at, x, y) == pytest.approx(value, rel=1e-3)


@pytest.mark.slow
def test_five_scenarios_stand_beside_one_another_and_more_make_several_figures() -> None:
    assert [picture.name for picture in compare_pictures(inclinations())][1:] == ["figure-2", "figure-4", "figure-7"]
    six = compare(EXAMPLES / "inclined.yaml", vary={"inclination_deg": [0, 5, 15, 30, 45, 60]})
    drawn = compare_pictures(six)
    assert max(sentences(picture.caption) for picture in drawn) <= 2
    names = [picture.name for picture in drawn]
    assert names == ["figure-variants", "figure-2", "figure-2-2", "figure-4", "figure-4-2", "figure-7", "figure-7-2"]


@pytest.mark.slow
def test_captions_have_the_conditions_of_the_papers_captions() -> None:
    overlaid, two, four, seven = compare_pictures(three())
    assert [sentences(picture.caption) for picture in (overlaid, two, four, seven)] == [1, 2, 2, 2]
    assert overlaid.caption.startswith("Over d, as the sweeps are of different parameters")
    for picture, letters in ((two, "(a)–(c)"), (four, "(a)–(b)"), (seven, "(a)")):
        caption = picture.caption
        assert f". f = 2 Hz, M = 0.1245 kg, r = 0.5; {letters} horizontal: F = 3 N, β = 0°, s from 0.26 m" in caption
        assert "inclined: F = 3 N, β = 45°, s from 0.59 m to 0.75 m" in caption
        assert "inclined-forcing: s = 0.75 m, β = 45°, F from 3 N to 6 N" in caption
        assert "B1" in picture.alt
    assert "U_ave, the mean over both, by the paper's formulae, on axes" in seven.caption


# Files


def test_the_files_read_back() -> None:
    assert "0.418 for inclined" in terminal_summary(three(), tables=True)
    formats = ("json", "csv", "markdown")
    files = render_comparison(three(), "vireport compare a b c", PageSettings(formats), lambda what: None)
    assert sorted(files) == ["compare.csv", "compare.json", "summary.md"]
    assert b"| inclined-forcing | 3 | Margin small; stretched farther than demonstrated | none |" in files["summary.md"]
    data = json.loads(files["compare.json"])
    assert [x["name"] for x in data["scenarios"]] == list(THREE)
    assert data["provenance"]["command"] == "vireport compare a b c"
    for read, quantity in zip(data["quantities"], three().quantities, strict=True):
        assert read["values"] == list(quantity.values)
        assert read["sentence"] == quantity.sentence


def test_the_table_for_a_data_frame_has_a_row_for_each_scenario_with_all_its_numbers() -> None:
    files = render_comparison(three(), "vireport compare a b c", PageSettings(("csv",)), lambda what: None)
    rows = list(csv.DictReader(io.StringIO(files["compare.csv"].decode())))
    assert [row["scenario"] for row in rows] == list(THREE)
    assert [row["rank"] for row in rows] == ["1", "2", "3"]
    for quantity in three().quantities:
        shown = [row[quantity.heading] for row in rows]
        assert [float(cell) if cell else None for cell in shown] == list(quantity.values)
    for setting in three().settings:
        assert [row[setting.quantity] for row in rows] == ["" if x is None else str(x) for x in setting.values]


@pytest.mark.slow
def test_the_report_says_what_differs_and_is_the_same_every_time() -> None:
    def say(what: str) -> None:
        pass

    files = render_comparison(three(), "vireport compare", PageSettings(("html", "pdf")), say)
    again = render_comparison(
        compare([study(name) for name in THREE]), "vireport compare", PageSettings(("html", "pdf")), say
    )
    assert files == again
    page = files["report.html"].decode()
    assert "Best: horizontal, by its margin with rigid membranes." in page
    assert "The highest mean voltage is that of inclined-forcing" in page
    assert files["report.pdf"].startswith(b"%PDF-")


def test_every_quantity_that_no_other_table_has_is_in_a_table_of_whole_rows() -> None:
    report = ComparisonReport(three(), {}, comparison_provenance(three(), ""))
    (compared,) = report.quantities()
    of_a_kind = {group: sum(x.group is group for x in three().quantities) for group in QuantityGroup}
    told = QuantityGroup.VOLTAGE, QuantityGroup.CRITICAL_POINT, QuantityGroup.DISTURBANCES
    # The ranking has the voltage at the design point.
    assert len(compared.rows) == sum(of_a_kind[group] for group in told) - 1 > 8
    assert not [row for row in compared.rows if "argin" in row[0] or "design point" in row[0]]
    for table in [compared, *report.settings(), report.ranking(), report.margins(), report.alerts()]:
        assert {len(row) for row in table.rows} == {len(table.columns)}


def test_the_values_that_differ_run_down_or_across_so_that_the_table_is_narrow() -> None:
    scenarios = compare(EXAMPLES / "design-point.yaml", vary={"device.length_m": [0.7, 0.72]})
    (few,) = ComparisonReport(scenarios, {}, comparison_provenance(scenarios, "")).settings()
    assert [column.title for column in few.columns] == ["Scenario", "device.length_m"]
    assert few.rows == (("length 0.7 m", "0.7"), ("length 0.72 m", "0.72"))
    (more,) = ComparisonReport(three(), {}, comparison_provenance(three(), "")).settings()
    assert [column.title for column in more.columns] == ["Key", *THREE]
    assert ("inclination_deg", "0", "45", "45") in more.rows


def test_a_report_says_once_which_figures_lack_which_scenarios() -> None:
    pair = compare([study("inclined"), study("design-point")], names=("one", "other"))
    table = ComparisonReport(pair, {}, comparison_provenance(pair, "")).left_out()
    assert table.rows[0] == ("Figures 2, 4 and 7 of other", "It has no sweep")


def test_the_voltage_per_second_has_a_column_only_where_impacts_are_not_equally_frequent() -> None:
    def heads(*devices: Study) -> list[str]:
        return [column.title for column in ranking_table(compare(devices).ranking).columns]

    assert "Per second" not in heads(study("inclined"), study("horizontal"))
    faster = study("design-point", "excitation.frequency_hz=2.1")
    assert "Per second" in heads(study("design-point"), faster)
    assert "per second" in ranking_table(compare([study("design-point"), faster]).ranking).note


def test_without_a_ball_mass_the_figure_of_voltages_alone_is_left_out() -> None:
    massless = compare([study("inclined"), study("inclined", "device.ball_mass_kg=")], names=("one", "other"))
    assert left_out(massless, "figure-2") == []
    assert left_out(massless, "figure-7") == [("other", Said("has_no_ball_mass", (), "compare"))]


def test_figures_of_1_1_motions_leave_out_a_ball_on_a_table() -> None:
    pair = compare([study("inclined"), study("bouncing-ball", "motions.impacts=1")])
    for figure in ("figure-2", "figure-4", "figure-7"):
        ((name, why),) = left_out(pair, figure)
        assert name == "bouncing-ball"
        assert why.words(None) == "its motions are on one membrane (vireport run draws them)"


def test_a_name_is_no_markup() -> None:
    odd = compare([study("inclined"), study("horizontal")], names=("<b>*x*</b>", "a_b"))
    html = render_html(ComparisonReport(odd, {}, comparison_provenance(odd, "")))
    page = Page(html)
    assert "b" not in {tag for tag, _ in page.tags}
    assert not {b"<sub>b</sub>", b"<em>x</em>"} & set(re.findall(rb"<(?:sub|em)>.</\w+>", html))
    tables = page.all_tables
    assert len(tables) > 5
    assert all(len(row) == len(table.rows[0]) for table in tables for row in table.rows)


@pytest.mark.slow
def test_data_are_compared_without_drawing(tmp_path: Path) -> None:
    baseline = tmp_path / "results.json"
    baseline.write_text(json.dumps(study("inclined").to_dict()))
    code = (
        "import sys; from vireport.cli.app import main; two, one, baseline = sys.argv[1:]\n"
        "main(['compare', two, one, '--json']); main(['compare', '--exit-code', baseline, one, '--json'])\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    files = [str(path) for path in (EXAMPLES / "design-point.yaml", EXAMPLES / "inclined.yaml", baseline)]
    arguments = [sys.executable, "-c", code, *files]
    loaded = set(subprocess.run(arguments, capture_output=True, text=True, check=True).stderr.split())
    assert "vireport.comparison" in loaded
    assert (
        not {"matplotlib", "scipy", "vireport.figures", "vireport.report.rendering", "vireport.study.checks"} & loaded
    )


# Notebooks


def test_the_package_has_the_functions_after_their_modules_are_imported() -> None:
    from vireport import compare as first
    from vireport import diff

    assert vireport.compare is first is compare
    assert vireport.diff is diff


@pytest.mark.slow
def test_figures_show_themselves_without_pyplot() -> None:
    figure = vireport.figure_2(study("inclined"))
    files = figure._repr_png_(), vireport.pictures(study("inclined"))[0].png
    shown, written = (Image.open(io.BytesIO(file)).convert("L") for file in files)
    assert shown.size == written.size == tuple(int(size) for size in figure.get_size_inches() * figure.dpi)
    a, b = (np.asarray(image.reduce(4), dtype=float) for image in (shown, written))
    assert np.abs(a - b).mean() < 4  # edges are smoothed in two ways; an empty page makes it 10
    assert written.info["dpi"] == pytest.approx((150, 150), abs=0.1)


def test_studies_and_comparisons_show_themselves() -> None:
    titled = study("inclined", "title='<script>'")
    text = titled._repr_html_()
    assert "<script>" not in text
    assert "<td>B1</td><td>period doubling</td>" in text
    assert "Stable" in text
    assert "<td>inclined</td><td>2</td><td>Margin small</td><td>1.0 % in frequency</td>" in three()._repr_html_()


def test_rows_are_the_motions_by_the_names_of_the_files() -> None:
    from vireport.study.results import branches_csv

    rows = study("inclined").rows()
    read = list(csv.DictReader(io.StringIO(branches_csv(study("inclined").solution).decode())))
    assert len(rows) == len(read)
    assert set(read[0]) <= set(rows[0])
    assert [repr(row["u_ave_v"]) for row in rows] == [row["u_ave_v"] for row in read]
    assert "provenance" not in study("inclined").to_dict()
    json.dumps(study("inclined").to_dict(), allow_nan=False)


KNOWN = {"device.restitution": None, "device.restitution_bottom": 0.52, "device.restitution_top": 0.47}
RECORD = [{"impacts": "measured-impacts.csv", "force_maximum_s": 0.0}]


def results(**over: object) -> Results:
    """What a comparison reads of a design point."""
    given = {path.replace("__", "."): value for path, value in over.items()}
    loaded = load(EXAMPLES / "measured.yaml", KNOWN | given)
    solution = solution_of(Device.of(loaded.scenario), Membrane.of(loaded.scenario), None, True, None)
    measured = measured_data(measured_of(loaded)) if loaded.scenario.measured else UNSET
    settings = loaded.scenario.model_dump(mode="json", by_alias=True)
    return replace(analytic_results(solution, settings), measured=measured)


@pytest.fixture(scope="module")
def compared() -> MappingProxyType[str, ComparedScenario]:
    other = {"device__restitution_bottom": 0.5, "device__restitution_top": 0.5}
    return MappingProxyType(compared_scenarios({"device": results(measured=RECORD), "guess": results(**other)}))


def rows_of(compared):
    rows = comparison_rows(compared, axes_of(compared.values(), NO_DIFFERENCE))
    return {row.quantity: row for row in rows if row.group is QuantityGroup.MEASURED}


def test_measured_and_computed_stand_side_by_side_with_differences_in_standard_errors(compared):
    rows = rows_of(compared)
    known = compared["device"].results.measured[0].impacts
    for impact in known:
        where = f"impact velocity at the {impact.membrane}"
        assert rows[f"measured {where}"].values == (impact.velocity_m_s, None)
        assert rows[f"measured {where}"].notes[1] == "nothing measured there"
        own, guess = rows[f"computed {where}"].values
        assert own == pytest.approx(impact.velocity_m_s_computed, rel=1e-8)
        row = rows[f"measured less computed {where}"]
        assert row.unit == STANDARD_ERRORS
        expected = [(impact.velocity_m_s - x) / impact.velocity_m_s_standard_error for x in (own, guess)]
        assert row.values == pytest.approx(expected)
        assert abs(row.values[0]) < 4 < 50 < abs(row.values[1])
        assert row.notes[1] == "of another scenario's record"


def test_sentences_have_differences_without_a_share(compared):
    row = rows_of(compared)["measured less computed phase of the impact at the top"]
    assert row.sentence.startswith("Measured less computed phase of the impact at the top: ")
    assert row.sentence.count("standard errors") == 2
    assert "apart" not in row.sentence


def test_without_a_record_nothing_is_said():
    alone = compared_scenarios({"a": results(), "b": results(inclination_deg=44.0)})
    assert not rows_of(alone)
