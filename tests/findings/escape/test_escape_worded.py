"""What is said of lifetimes, refused and required: on the first page, in the section, in results and in mistakes."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from tests.findings.escape.test_lifetimes import of_times
from tests.findings.outcomes.devices import case
from tests.pages import Page, render_html
from vireport import ScenarioError, UsageError, analyse, diff, load, loads
from vireport.base.errors import NumericalError
from vireport.base.records import plain
from vireport.findings.escape.escape import Escape, MotionEscape, SmallKickLaw, Unlimited
from vireport.findings.escape.figure import figure_escape, picture
from vireport.findings.escape.finding import FIGURE, FINDING
from vireport.findings.escape.judging import judged_lifetime
from vireport.findings.escape.least_kicks import KickedPath, LeastKicks
from vireport.findings.escape.results import escape_data
from vireport.report.context import Report
from vireport.scenario.demands import AT_LEAST
from vireport.study.judging.evidence import Evidence, Limit
from vireport.study.plan import AddedTask
from vireport.study.provenance import provenance_of
from vireport.study.study import Study
from vireport.text.templates import Words

ROOT = Path(__file__).resolve().parents[3]
DEVICE = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 0.75}
excitation: {amplitude_n: 3.6, frequency_hz: 2}
inclination_deg: 45
"""
MOTION = case().stable[0]
WAY = LeastKicks(KickedPath(np.array([1, -1, 1, -1]), np.arange(4.0), np.array([0.06, 0.08])), 0.15)
LEVEL = replace(of_times([*np.linspace(1, 400, 300).tolist()], [400.0] * 700, 18.0), kick=0.05)
LAW = SmallKickLaw(0.005, 2.5, 0.1)


def escape(of: MotionEscape, *others: MotionEscape) -> Escape:
    return Escape((of, *others), 0.2, 4.0, 2.0)


def lasting(**of: object) -> MotionEscape:
    return replace(MotionEscape(MOTION, 0.05), **of)


SIMULATED = lasting(simulated=LEVEL, law=LAW, way=WAY, levels=(LEVEL,), ends=(("chaotic", 0.75), ("at rest", 0.25)))
EXTRAPOLATED = lasting(kick=0.02, law=LAW, way=WAY, levels=(replace(LEVEL, kick=0.06), LEVEL), ends=(("chaotic", 1.0),))
BEYOND = lasting(kick=0.001, law=LAW, way=WAY, levels=(LEVEL,))
STAYS = lasting(simulated=of_times([], [5000.0] * 100))
UNKNOWN = lasting(unknown="it is too near")


def said(macro: str, *of: object) -> str:
    return Words("escape")(macro, *of).replace("\u00a0", " ")


def test_the_first_page_says_how_long_it_lasts() -> None:
    assert said("lasts", escape(SIMULATED)) == (
        "Random kicks of 0.2 m/s end the motion after 1100 periods (9.4 min) on average."
    )
    assert said("lasts", escape(EXTRAPOLATED)) == (
        "Random kicks of 0.2 m/s end the motion after 3300000 periods (19 days) on average, an extrapolation."
    )
    assert said("lasts", escape(BEYOND)) == (
        "Random kicks of 0.2 m/s do not end the motion in any time that is of use."
    )
    assert said("lasts", escape(STAYS)) == ("Random kicks of 0.2 m/s do not end the motion in 140000 periods or more.")
    assert said("lasts", escape(SIMULATED, UNKNOWN)) == "How long the motion lasts under random kicks is not known."


def test_times_have_units_that_are_read() -> None:
    times = [said("time", seconds) for seconds in (60.0, 600.0, 36000.0, 864000.0, 315576000.0)]
    assert times == ["60 s", "10 min", "10 h", "10 days", "10 years"]


KICKS = (
    "Under independent normal kicks of 0.2 m/s (standard deviation) to the velocity just after each impact, the motion "
)


def test_the_section_says_what_the_number_is() -> None:
    assert said("lasting", escape(SIMULATED), SIMULATED) == (
        KICKS + "lasts 1100 periods (9.4 min) on average until it would no longer return by itself, "
        "with a 95 % interval from 1000 to 1300 periods."
    )
    assert said("lasting", escape(EXTRAPOLATED), EXTRAPOLATED) == (
        KICKS + "lasts 3300000 periods (19 days) on average until it would no longer return by itself, with a "
        "95 % interval from 2700000 to 4000000 periods. This is an extrapolation, by the law for small kicks."
    )
    assert said("lasting", escape(BEYOND), BEYOND) == (
        KICKS + "lasts longer than any number of periods that is of use, by the law for small kicks: the logarithm of "
        "that number is 5000."
    )
    assert said("lasting", escape(STAYS), STAYS) == (
        KICKS + "lasts 140000 periods or more on average (95 %): no kick that was tried leads out of the motion, "
        "and no ball left it."
    )
    assert said("lasting", escape(UNKNOWN), UNKNOWN) == (
        "How long the motion lasts under random kicks is not known: it is too near."
    )
    assert "the motion that strikes the bottom at 3.70 m/s lasts" in said(
        "lasting", escape(SIMULATED, SIMULATED), SIMULATED
    )


def test_the_section_says_what_it_comes_to_and_how_the_times_are_distributed() -> None:
    assert said("ends", SIMULATED) == (
        "What it comes to instead: chaotic (75 %), at rest (25 %). After the first 18 periods the times are "
        "exponential, as far as 287 escapes tell (chi-square test, *p* = 0.97)."
    )
    assert said("ends", replace(SIMULATED, checked=4000, wrong=3)).endswith(
        "*p* = 0.97). Of 4000 impacts that were taken to return and followed after all, 3 did not: the mean time may "
        "be shorter."
    )
    assert said("ends", EXTRAPOLATED).startswith(
        "What it comes to instead with the smallest kicks that were simulated: chaotic (100 %). After"
    )
    ageing = np.sort(2 + 30 * np.random.default_rng(1).weibull(1.3, 2000)).tolist()
    assert said("ends", replace(SIMULATED, simulated=of_times(ageing, []))).endswith(
        "(25 %). The times are not exponential, even after the first 2 periods (chi-square test, *p* < 0.001)."
    )
    somewhat = np.sort(2 + 30 * np.random.default_rng(4).weibull(1.15, 300)).tolist()
    assert "(chi-square test, *p* = 0.0065)." in said("ends", replace(SIMULATED, simulated=of_times(somewhat, [])))
    assert said("ends", replace(SIMULATED, simulated=of_times([3.0], [9.0]))).endswith(
        "Too few stay for the distribution of the times to be tested."
    )


def test_the_section_gives_the_law() -> None:
    least = (
        "The least kicks that lead out, one after each of several impacts, have half a sum of squares of *Q* = "
        "0.08 m²/s²; the least single one after an impact, 0.6 m/s, has 0.18 m²/s²."
    )
    assert said("law", escape(SIMULATED), SIMULATED) == (
        f"{least} So for small kicks ln *T* = *a* + *Q*/σ², where *T* is the mean number of periods; simulations with "
        "larger kicks give *a* = 2.5 with a standard error of 0.1."
    )
    assert said("law", escape(SIMULATED), replace(SIMULATED, law=None)) == (
        f"{least} Too few simulations with larger kicks last long enough for a law of small kicks."
    )


def test_the_figure_shows_the_kicks_of_the_scenario_or_says_where_they_are() -> None:
    task = AddedTask(FIGURE, "")
    shown = picture(escape(EXTRAPOLATED), task)
    assert shown.caption == (
        "Mean number of forcing periods *T* until random kicks of standard deviation σ lead out of the motion. Points: "
        "simulations, with 95 % intervals; line: the law for small kicks, ln *T* = *a* + *Q*/σ², dashed where it is an "
        "extrapolation. The kicks of the scenario, 0.2 m/s, are marked."
    )
    assert shown.alt == (
        "Chart of the logarithm of the mean number of periods against the inverse square of the kicks: 2 simulations "
        "from 1100 to 1100 periods along a straight line, and the kicks of the scenario at ln T = 15."
    )
    beyond = picture(escape(BEYOND), task)
    assert beyond.caption.endswith("The kicks of the scenario, 0.2 m/s, are beyond the axis, at ln *T* = 5000.")
    (axes,) = figure_escape(EXTRAPOLATED, 4.0).axes
    law, further = (line.get_xydata() for line in axes.lines[:2])
    assert law[0] == pytest.approx([1 / (0.06 * 4) ** 2, 2.5 + 0.005 / 0.06**2])
    assert further[1] == pytest.approx([1 / (0.02 * 4) ** 2, 2.5 + 0.005 / 0.02**2])
    assert escape(UNKNOWN, STAYS).drawn is None
    assert escape(BEYOND, EXTRAPOLATED).drawn is EXTRAPOLATED


def test_results_have_numbers_or_reasons() -> None:
    data = [plain(escape_data(escape(of)))["motions"][0] for of in (SIMULATED, EXTRAPOLATED, BEYOND, STAYS, UNKNOWN)]
    assert [row["reason"] for row in data] == [None, None, Unlimited.BEYOND_USE, Unlimited.NO_WAY_OUT, "it is too near"]
    assert [row["periods"] is None for row in data] == [False, False, True, True, True]
    assert [row["extrapolated"] for row in data] == [False, True, True, False, False]
    assert data[0]["time_s"] == pytest.approx(data[0]["periods"] / 2)
    assert data[0]["log_periods"] == pytest.approx(np.log(data[0]["periods"]))
    assert data[2]["log_periods"] == pytest.approx(5002.5)
    assert data[2]["low_95"] is None
    assert data[3]["low_95"] > 100_000 and data[3]["high_95"] is None  # noqa: PT018
    law = data[0]["law"]
    assert law["q_m2_s2"] == pytest.approx(0.08)
    assert (law["a"], law["a_standard_error"], law["least_shock_m_s"]) == (2.5, 0.1, 0.6)
    assert law["kicks_m_s"] == pytest.approx([0.24, 0.32])
    assert data[0]["levels"][0]["kick_m_s"] == pytest.approx(0.2)
    assert data[0]["ends"] == [{"name": "chaotic", "share": 0.75}, {"name": "at rest", "share": 0.25}]
    assert FINDING.results(None, None) == {}


def judged(of: MotionEscape, least: float):
    evidence = Evidence(analyse(loads(DEVICE), ("json",)).solution, findings={"escape": escape(of)})
    return judged_lifetime(evidence, Limit(AT_LEAST, (least,), "periods"))


def test_the_lower_end_is_held_against_what_is_required() -> None:
    low = SIMULATED.interval[0]
    assert judged(SIMULATED, low - 1).passed
    assert not judged(SIMULATED, low + 1).passed
    assert str(judged(SIMULATED, 10).why) == "by simulation, the lower end of the 95 % interval counts"
    assert str(judged(EXTRAPOLATED, 10).why).startswith("by the law for small kicks: an extrapolation")
    endless = judged(BEYOND, 1e15)
    assert endless.passed
    assert str(endless.text) == "longer than any number of periods that is of use"
    assert judged(STAYS, 100_000).passed
    assert str(judged(STAYS, 1e6).why) == (
        "no kick that was tried leads out of the motion, and no ball left it: the lower end of the 95 % interval"
    )
    assert not judged(STAYS, 1e6).passed
    with pytest.raises(NumericalError, match="not decided: it is too near"):
        judged(UNKNOWN, 10)


def mistakes(more: str) -> str:
    with pytest.raises(ScenarioError) as refused:
        loads(DEVICE + more)
    return str(refused.value)


def test_what_is_missing_is_said_with_its_place() -> None:
    assert "5: disturbances.escape: disturbances.jitter_m_s is not given (give it, or leave this out)" in mistakes(
        "disturbances: {escape: true}\n"
    )
    lasts = "requirements: {lasts_at_least_periods: 1e4}\n"
    assert (
        "6: requirements.lasts_at_least_periods: a lifetime needs disturbances.escape, which is not given "
        "(give it, or leave this out)"
    ) in mistakes("disturbances: {jitter_m_s: 0.1}\n" + lasts)
    assert "got -1" in mistakes("disturbances: {escape: true, jitter_m_s: 0.1}\n" + lasts.replace("1e4", "-1"))
    loads(DEVICE + "disturbances: {escape: true, jitter_m_s: 0.1}\n" + lasts)


def test_of_a_ball_with_friction_it_is_not_known() -> None:
    text = DEVICE.replace("length_m: 0.75", "length_m: 0.75, friction: 0.1")
    with pytest.raises(ScenarioError, match=r"disturbances\.escape: it is available without friction only"):
        loads(text + "disturbances: {escape: true, jitter_m_s: 0.1}\n")


def test_without_the_compiler_a_required_lifetime_is_refused_before_work(monkeypatch: pytest.MonkeyPatch) -> None:
    from vireport.study import plan

    scenario = loads(
        DEVICE + "disturbances: {escape: true, jitter_m_s: 0.1}\nrequirements: {lasts_at_least_periods: 1e4}\n"
    )
    assert plan.plan(scenario.scenario).runs("escape", "figure-escape")
    there = plan.find_spec
    monkeypatch.setattr(plan, "find_spec", lambda name: None if name == "numba" else there(name))
    with pytest.raises(UsageError, match=r"requirements\.lasts_at_least_periods cannot be judged: .*numba"):
        plan.refuse_undecidable(scenario.scenario)


@cache
def noisy() -> Study:
    path = ROOT / "examples" / "inclined-forcing.yaml"
    over = ("excitation.amplitude_n=3.6", "disturbances.jitter_m_s=0.2", "disturbances.escape=true")
    return analyse(load(path, [*over, "requirements.lasts_at_least_periods=1000"]), ("json",))


@pytest.mark.slow
def test_the_page_of_the_docs_says_what_a_run_says() -> None:
    study = noisy()
    page = (ROOT / "docs" / "escape.md").read_text(encoding="utf-8")
    # Within its interval, which the last bits of a machine do not move the number out of.
    number = re.compile(r"after (\d+) periods \(\d+ min\)")
    low, high = study.findings["escape"].shortest.interval
    (periods,) = number.findall(page)
    assert low < float(periods) < high
    assert number.sub("", said("lasts", study.findings["escape"])) in number.sub("", page)
    answer = study.verdict.added["escape"]
    assert answer.status == "good"
    (criterion,) = [row for row in study.criteria if row.key == "lasts_at_least_periods"]
    assert criterion.passed
    assert str(criterion.title) == "Mean time under random kicks"


@pytest.mark.slow
def test_the_same_scenario_gives_the_same_numbers() -> None:
    over = ("excitation.amplitude_n=3.6", "disturbances.jitter_m_s=0.2", "disturbances.escape=true")
    again = analyse(load(ROOT / "examples" / "inclined-forcing.yaml", over), ("json",))
    assert again.to_dict()["escape"] == noisy().to_dict()["escape"]


@pytest.mark.slow
def test_the_section_is_in_the_report() -> None:
    study = noisy()
    found = study.findings["escape"]
    drawn = {FIGURE: picture(found, AddedTask(FIGURE, ""))}
    page = Page(render_html(Report(study, drawn, provenance_of(study.loaded, "test"))))
    text = page.text.replace("\u00a0", " ")
    assert said("lasting", found, found.shortest) in text
    assert said("ends", found.shortest).replace("*", "") in text
    assert said("law", found, found.shortest).replace("*", "") in text
    assert "shows how the time grows as the kicks become smaller." in text


def test_comparisons_know_the_motion_that_lasts_least() -> None:
    def compared(*of: MotionEscape) -> list[tuple[object, ...]]:
        return [tuple(row) for row in FINDING.compared({"escape": plain(escape_data(escape(*of)))})]

    low, high = SIMULATED.interval
    periods, half = pytest.approx(SIMULATED.periods), pytest.approx((high - low) / 2)
    assert compared(EXTRAPOLATED, SIMULATED, BEYOND) == [("mean_time", periods, "forcing periods", half, "")]
    assert compared(BEYOND) == [("mean_time", None, "forcing periods", 0.0, Unlimited.BEYOND_USE)]
    assert list(FINDING.compared({})) == []


@pytest.mark.slow
def test_results_of_an_earlier_run_are_compared() -> None:
    data = noisy().to_dict()
    longer = {**data, "escape": {**data["escape"], "motions": [{**data["escape"]["motions"][0], "periods": 9000.0}]}}
    rows = diff(longer, noisy())
    (row,) = rows
    assert "mean time until random kicks lead out of the motion" in str(row)
