"""What pages and terminals show is what results.json and the definitions say: in tables and in sentences.

`shown_tables.py` and `shown_figures.py` have what is held, `definitions.py` the formulae, `shown.py` reads. Scenarios
differ in all numbers: V_B and V_T, both membranes, force and frequency; several periods, with and without a design
point.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES
from definitions import mean
from matplotlib.figure import Figure
from matplotlib.text import Text
from msgspec.structs import replace
from pages import Page, render_html, tidy
from shown import Amount, Said, plain, table_faults, terminal_tables
from shown_figures import (
    answer_faults,
    captions,
    cycle_faults,
    legend_of,
    motion_faults,
    path_faults,
    stability_faults,
    voltage_faults,
)
from shown_opening import Opening, margin_faults, opening_faults
from shown_tables import (
    TABLES,
    WORDS_ONLY,
    Results,
    along_the_sweep,
    compared,
    differing_settings,
    inputs_faults,
    nearest_ends,
    number,
    of_margins,
    of_tolerances,
    power_w,
    printed_faults,
    ranking,
    sentences,
    types_faults,
)

from vireport.comparison.comparison import Comparison, compare
from vireport.comparison.outputs import comparison_provenance, terminal_summary
from vireport.comparison.pages import ComparisonReport
from vireport.figures.captions import alt_text, caption_facts, pictured
from vireport.figures.curves import simulated_points
from vireport.figures.pictures import pictures
from vireport.figures.style import Picture
from vireport.map.chart.outputs import markdown as chart_markdown
from vireport.map.chart.outputs import text as chart_text
from vireport.map.chart.over import plane_of
from vireport.motions.events import Event
from vireport.motions.switching import Limits
from vireport.optimise import outputs
from vireport.optimise.grid import JudgedDesign
from vireport.optimise.problem import problem_of
from vireport.optimise.search import SearchEvidence, SearchResult
from vireport.report.context import Report
from vireport.report.templates import fill
from vireport.scenario.loading import load
from vireport.study.judging.opening import opening_of
from vireport.study.plan import Task
from vireport.study.provenance import provenance_of
from vireport.study.study import Study, analyse, results_json

DIELECTRIC = {
    f"device.membrane.{key}": value
    for key, value in {"thickness_m": 0.47e-3, "relative_permittivity": 4.3, "breakdown_field_v_m": 1.07e8}.items()
}


def required(**limits: object) -> dict[str, object]:
    return {f"requirements.{key}": limit for key, limit in limits.items()}


SCENARIOS: dict[str, tuple[str, dict[str, object]]] = {
    "no stable motion but one that some starts find": (
        "inclined",
        {"device.length_m": 1.1, "excitation.amplitude_n": 2.0, "sweep": None},
    ),
    "length swept, with everything": (
        "inclined",
        {
            "device.ball_mass_kg": 0.0037, "device.restitution": 0.52, "device.length_m": 0.68,
            "excitation.frequency_hz": 2.1, "excitation.amplitude_n": 3.3, "inclination_deg": 31.0,
            "sweep.from": 0.40, "sweep.to": 0.8, "device.membrane.active_radius_m": 6.1e-3,
            "tolerances.length_percent": 1.5, "tolerances.restitution": 0.02, "tolerances.samples": 64,
            "tolerances.distribution": "normal", **DIELECTRIC,
            **required(
                stable_from=0.5, stable_to=0.7, margin_any_percent=40, u_ave_at_least_v=30000,
                u_bottom_top_difference_at_most_v=100, deflection_at_most_m=0.0185, power_at_least_mw=1.0,
                area_ratio_at_most=4.5, field_at_most_percent=150,
                yield_at_least_percent=90, acceleration_at_most_g=2.5,
                stroke_at_most_m=0.4, force_at_most_n=3.5,
            ),
        },
    ),
    "three forcing periods, no sweep, valid voltages": (
        "design-point",
        {
            "period_ratio": 3, "inclination_deg": 5, "device.length_m": 4.1, "device.ball_mass_kg": 2.2e-6,
            "tolerances.length_percent": 6, "tolerances.frequency_hz": 0.02, "tolerances.samples": 64, **DIELECTRIC,
            **required(power_at_least_mw=1e-5, stroke_at_most_m=0.2, u_ave_at_least_v=5, field_at_most_percent=4),
        },
    ),
    "horizontal, no design point, other sequences": (
        "horizontal",
        {"motions.impacts": 3, "motions.periods": 2, "device.length_m": None, "sweep.from": 0.2,
         "sweep.to": 0.45, "device.ball_mass_kg": 0.0039, "simulation.samples": 12, "simulation.starts": 8},
    ),
    "a slow sweep, simulated": (
        "hysteresis",
        {"simulation.samples": 9, "simulation.starts": 4, "motions.impacts": 3, "motions.periods": 1},
    ),
    "frequency swept": (
        "inclined",
        {"sweep.parameter": "frequency_hz", "sweep.from": 1.5, "sweep.to": 3, "device.length_m": 0.7,
         "device.ball_mass_kg": 2e-6, "excitation.frequency_hz": 1.93},
    ),
    "force swept, simulated": (
        "inclined-forcing",
        {"simulation.samples": 4, "simulation.starts": 5, "excitation.amplitude_n": 4.1, "sweep.from": 2.6,
         "simulation.diagram": True, "simulation.portraits": [4.1], "simulation.displacement": [4.1],
         "disturbances.jitter_m_s": 0.013, "disturbances.basin": True, "disturbances.jitter_restitution": 0.0021,
         **required(survives_shock_m_s=0.9, phase_jitter_at_most_deg=3, withstands_distortion_percent=6),
         **required(margin_with_effects_percent=3),
         "device.capsule": "free",
         **required(crosscheck_passed=True, margin_period_doubling_percent=20, force_at_most_n=3.8),
         **required(stroke_at_most_m=0.6)},
    ),
    "no stable 1 to 1 motion, and another one from rest": (
        "design-point",
        {"inclination_deg": 45, "device.length_m": 0.31, "device.restitution": 0.49, "disturbances.prove": True},
    ),
    "two stable motions, and a field above breakdown": (
        "design-point",
        {"inclination_deg": 5, "device.length_m": 0.33, "device.ball_mass_kg": 1e-4, **DIELECTRIC,
         "device.membrane.breakdown_field_v_m": 9e6},
    ),
    "membranes that are not alike": (
        "inclined",
        {"device.restitution": None, "device.restitution_bottom": 0.47, "device.restitution_top": 0.54,
         "device.length_m": 0.72, "sweep.from": 0.55, "device.ball_mass_kg": 3e-6, "tolerances.samples": 64,
         "tolerances.restitution_bottom": 0.004, "tolerances.restitution_top_percent": 1, **DIELECTRIC},
    ),
}  # fmt: skip

SIMULATED = "force swept, simulated"
LONG = {
    SIMULATED,
    "a slow sweep, simulated",
    "horizontal, no design point, other sequences",
    "no stable 1 to 1 motion, and another one from rest",
}
"""Scenarios that take a second or more."""


def cases(names: Iterable[str]) -> list[Any]:
    return [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in names]


DISTORTED: tuple[str, dict[str, object]] = (
    "design-point",
    {
        "tolerances.length_percent": 0.9,
        "tolerances.samples": 64,
        "excitation.harmonics": [
            {"order": 2, "percent": 1.3, "phase_deg": 225},
            {"order": 3, "percent": 0.7, "phase_deg": 40},
        ],
    },
)


RESTITUTION_ALONE = [{"effect": "restitution_top", "percent": -1.0}]
OPENINGS: dict[str, tuple[str, dict[str, object]]] = {
    "rigid impacts limit the margin": (
        "design-point", {"device.ball_mass_kg": 2e-6, "device.length_m": 0.645, "effects": RESTITUTION_ALONE}
    ),
    "soft membranes limit the margin": ("design-point", {"device.length_m": 1.35, "effects": RESTITUTION_ALONE}),
    "soft membranes end the motion": ("design-point", {"device.length_m": 1.42, "effects": RESTITUTION_ALONE}),
    "an end that is not followed, and more energy than is lost": (
        "horizontal",
        {"sweep": None, "effects": RESTITUTION_ALONE, **DIELECTRIC, "device.membrane.relative_permittivity": 70.0,
         "device.membrane.breakdown_field_v_m": 1e9, "device.membrane.thickness_m": 0.5e-3},
    ),
    "no ball mass, stable throughout": (
        "inclined", {"device.ball_mass_kg": None, "sweep.from": 0.66, "device.length_m": 0.7}
    ),
}  # fmt: skip
"""First pages that the others have none of."""


@cache
def study_of(name: str) -> Study:
    example, overrides = {**SCENARIOS, **OPENINGS, "distorted": DISTORTED}[name]
    with pytest.MonkeyPatch.context() as patch:  # a proof that ends early has as many numbers to show
        patch.setattr("vireport.findings.proofs.section.MOST_FLIGHTS", 6000)
        patch.setattr("vireport.findings.proofs.section.HALVINGS", 1)
        return analyse(load(EXAMPLES / f"{example}.yaml", overrides))


@cache
def results_of(name: str) -> Results:
    study = study_of(name)
    return Results(json.loads(results_json(study, provenance_of(study.loaded, "vireport run x.yaml"))))


@cache
def page_of(name: str) -> Page:
    study = study_of(name)
    return Page(render_html(Report(study, {}, provenance_of(study.loaded, "vireport run x.yaml"))))


@cache
def pictures_of(name: str) -> dict[str, Picture]:
    return {picture.name: picture for picture in pictures(study_of(name), None)}


def matching(caption: str, captions: Any) -> str | None:
    return next((pattern for pattern in captions if re.fullmatch(pattern, caption)), None)


@pytest.mark.parametrize("name", cases(SCENARIOS))
def test_every_table_shows_what_results_and_definitions_say(name: str) -> None:
    results, wrong = results_of(name), []
    for table in page_of(name).all_tables:
        if (held := matching(table.caption, TABLES)) is not None:
            expected = TABLES[held](results)
            wrong += [f"{table.caption}: {fault}" for fault in table_faults(table.rows[0], table.rows[1:], expected)]
        elif table.caption == "Values, and where they come from":
            wrong += list(inputs_faults(results, table.rows[1:]))
        elif table.caption == "Numbers":
            wrong += list(printed_faults(table.rows[1:]))
        elif table.caption.startswith("Types of motion along"):
            wrong += list(types_faults(results, table.rows[1:]))
        else:
            assert matching(table.caption, WORDS_ONLY), f"{table.caption} is held by no row of TABLES"
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", cases(SCENARIOS))
def test_every_sentence_has_the_numbers_of_the_results(name: str) -> None:
    text = page_of(name).text
    wrong = [fault for said in sentences(results_of(name)) if (fault := said.faults(text))]
    assert '#"' not in text, "what a template has set is set once more, as text"
    assert not wrong, "\n".join(wrong)


def test_what_tolerances_of_a_distorted_force_come_to_is_told_with_its_own_numbers() -> None:
    """The other quantities of such a force are no definitions of a sine."""
    results, page = results_of("distorted"), page_of("distorted")
    assert not [fault for said in of_tolerances(results) if (fault := said.faults(page.text))]


OPENED = *SCENARIOS, *OPENINGS, "distorted"


@pytest.mark.parametrize("name", cases(OPENED))
def test_the_first_page_says_what_the_results_come_to(name: str) -> None:
    x, page = results_of(name), page_of(name)
    assert page.headings[0] == Opening(x).sentence()
    wrong = [*opening_faults(x, page.said, page.tiles), *margin_faults(x)]
    assert not wrong, "\n".join(wrong)


def test_a_simulation_is_said_to_agree_only_where_one_does() -> None:
    study = study_of("frequency swept")
    for again, remark in (
        (study.reproduction, "24 s; a simulation agrees"),
        (SimpleNamespace(passed=False, decided=False), "24 s until it has settled"),
        (None, "24 s until it has settled"),
    ):
        tiles = opening_of(study.verdict, study.alerts, again).worded().tiles
        assert [tidy(tile.remark) for tile in tiles if tile.label == "From rest"] == [remark]


@pytest.mark.slow
def test_the_first_page_of_the_scenarios_has_each_kind_of_fact_and_of_number() -> None:
    """A margin by rigid impacts, by soft membranes and by an effect, and none left; ranges with each kind of end."""
    limits = {(use["limited_by"], use["gone"]) for x in map(results_of, OPENED) if (use := x.data["margin_to_use"])}
    assert {("rigid", False), ("compliant", False), ("effect", False), ("effect", True)} <= limits
    said = " ".join(text for name in OPENED for _, *texts in page_of(name).tiles for text in texts)
    for words in (
        "the whole sweep",
        "not evaluated",
        "above ",
        "below ",
        "from period doubling to fold",
        "swept",
        "not 1:1",
        "impossible",
        "extrapolated",
    ):
        assert words in said


DRAWN = [name for name in SCENARIOS if not name.startswith("horizontal")]
"""Scenarios whose figures are drawn: each kind of figure is among them."""


@pytest.mark.parametrize("name", cases(DRAWN))
def test_curves_show_what_their_legends_and_the_results_say(name: str) -> None:
    x, drawn = results_of(name), pictures_of(name)
    held = {"figure-2": motion_faults, "figure-4": stability_faults, "figure-7": voltage_faults}
    held |= {"figure-answer": answer_faults} if x.sweep else {}
    held |= {"figure-device": path_faults, "figure-cycle": cycle_faults} if x.stable else {}
    wrong = [
        f"{figure}: {fault}" for figure, faults in held.items() if figure in drawn
        for fault in faults(x, drawn[figure].figure)
    ]  # fmt: skip
    if "figure-2" in drawn and "figure-7" in drawn:
        sides = [
            {words.split(", ")[-1]: look.get_color() for words, look in legend_of(drawn[figure].figure).items()}
            for figure in ("figure-2", "figure-7")
        ]
        assert [sides[0][side] for side in ("bottom", "top")] == [sides[1][side] for side in ("bottom", "top")]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", cases(DRAWN))
def test_captions_have_the_numbers_of_the_results(name: str) -> None:
    x, drawn = results_of(name), pictures_of(name)
    texts = {figure: f"{picture.caption} {picture.alt}" for figure, picture in drawn.items()}
    wrong = [f"{figure}: {fault}" for figure, said in captions(x) if (fault := said.faults(texts[figure]))]
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
def test_speeds_of_starts_that_are_alike_in_all_scenarios_are_told_where_they_differ() -> None:
    simulated = study_of(SIMULATED)
    check = simulated.crosscheck
    speeds = replace(check, start_speed=np.linspace(1.234, 2.346, len(check.start_speed)))
    of = replace(simulated, crosscheck=speeds)
    report = Report(of, {}, provenance_of(of.loaded, "vireport run x.yaml --quiet"))
    assert "uniform up to 1.23 to 2.35 of the unit" in plain(re.sub(r'#?"([^"]*)";?', r"\1", fill(report)))


@pytest.mark.slow
@pytest.mark.parametrize("name", OPENED)
def test_no_number_has_the_digits_that_rounding_leaves(name: str) -> None:
    """Of 0.2 M, 24.900000000000002; the scenario as given and sums of files stand as they are."""
    text = " ".join(cell for table in page_of(name).all_tables for row in table.rows for cell in row)
    assert re.findall(r"\d*\.\d{10,}", text) == []


@pytest.mark.slow
def test_each_held_caption_is_of_a_figure() -> None:
    held = {figure for name in DRAWN for figure, _ in captions(results_of(name))}
    names = "3", "4", "6", "answer", "atlas", "cycle", "device", "diagram", "hysteresis", "ladder"
    assert held == {f"figure-{name}" for name in names}


@pytest.mark.slow
def test_each_held_table_is_on_a_page() -> None:
    captions = [table.caption for name in SCENARIOS for table in page_of(name).all_tables]
    assert [pattern for pattern in TABLES if not any(re.fullmatch(pattern, caption) for caption in captions)] == []


COMPARED = {"inclined": "length swept, with everything", "inclined-forcing": SIMULATED}


@cache
def comparison() -> tuple[Comparison, Page, dict[str, Results]]:
    both = compare([study_of(name) for name in COMPARED.values()])
    report = ComparisonReport(both, {}, comparison_provenance(both, "vireport compare a.yaml b.yaml"))
    return both, Page(render_html(report)), {name: results_of(of) for name, of in COMPARED.items()}


@pytest.mark.slow
def test_a_comparison_shows_what_the_results_of_its_scenarios_say() -> None:
    both, page, named = comparison()
    wrong = []
    for caption, expected in {
        "Ranking, the best first": ranking(named),
        "Margins in each input, by rigid impacts": nearest_ends(named),
    }.items():
        table = page.tables[caption]
        wrong += [f"{caption}: {fault}" for fault in table_faults(table.rows[0], table.rows[1:], expected)]
    (table,) = [table for table in terminal_tables(terminal_summary(both, tables=True)) if table.head[0] == "Scenario"]
    wrong += [f"terminal: {fault}" for fault in table_faults(table.head, table.rows, ranking(named))]
    text = plain(terminal_summary(both, tables=True))
    wrong += [fault for said in compared(named) if (fault := said.faults(text))]
    assert not wrong, "\n".join(wrong)


def test_a_ranking_has_the_least_voltage_of_several_motions_and_counts_impacts_by_their_period() -> None:
    named = {
        "a": "two stable motions, and a field above breakdown",
        "b": "three forcing periods, no sweep, valid voltages",
    }
    text = terminal_summary(compare([study_of(name) for name in named.values()]), tables=True)
    (table,) = [table for table in terminal_tables(text) if table.head[0] == "Scenario"]
    column, wrong = {title: k for k, title in enumerate(table.head)}, []
    shown = sorted((row[column["Mean voltage"]], row[column["Per second"]]) for row in table.rows)
    expected = []
    for name in named.values():
        x = results_of(name)
        average = min(mean([x.device.gain(v) for v in speeds]) for speeds in x.design_speeds)
        rate = 2 * x.device.frequency_hz / x.device.period_ratio * average
        expected.append((Amount(average, "V", 3), Amount(rate, "V/s", 3)))
    for cells, amounts in zip(shown, expected, strict=True):
        wrong += [
            fault for cell, of in zip(cells, amounts, strict=True) if (fault := Said("{}", of).faults(cell, True))
        ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
def test_a_comparison_shows_its_values_in_the_columns_of_their_scenarios() -> None:
    both, page, named = comparison()
    expected, shown, wrong = differing_settings(named), {}, []
    for table in (table for table in page.all_tables if table.caption.startswith("Values that are not")):
        for key, *cells in table.rows[1:]:
            shown |= {(name, key): cell for name, cell in zip(table.rows[0][1:], cells, strict=True)}
    assert shown.keys() == expected.keys()
    for place, value in expected.items():
        if isinstance(value, float | int) and not isinstance(value, bool):
            wrong += [
                f"{place}: {fault}" for fault in [Said("{}", number(value, 15)).faults(shown[place], True)] if fault
            ]
        elif value is None or isinstance(value, str):
            assert shown[place] == (value or "—")
    rows = {row["quantity"]: row for row in json.loads(json.dumps(both.to_dict()))["quantities"]}
    head, *lines = page.tables["Voltages and critical points"].rows
    assert head[1:-1] == list(named)
    for quantity, *cells, apart in lines:
        name = re.sub(r" \[[^\]]*\]$", "", quantity).casefold()
        plain = name.replace("_", "").replace("\u2060", "")  # no subscripts
        row = next(row for key, row in rows.items() if key.replace("_", "").casefold() == plain)
        for value, cell in zip(row["values"], cells, strict=True):
            if value is not None:
                wrong += [fault for fault in [Said("{}", number(value)).faults(cell.split(" (")[0], True)] if fault]
        if row["change"]:
            (least, most), size = sorted(row["values"]), max(map(abs, row["values"]))
            share = Amount(100 * (most - least) / size, "%", 2)
            wrong += [fault for fault in [Said("{}", share).faults(apart, True)] if fault]
    assert not wrong, "\n".join(wrong)


@cache
def search() -> SearchResult:
    """As a search might end: two inputs, three designs, and evidence with numbers that are all different."""
    overrides = {
        "device.length_m": 0.69, "design.maximise": "power_mw", "design.vary": [
            {"path": "device.length_m", "from": 0.2, "to": 1.2},
            {"path": "excitation.frequency_hz", "from": 1, "to": 4},
        ], **DIELECTRIC, **required(margin_any_percent=5, stroke_at_most_m=0.35),
    }  # fmt: skip
    problem = problem_of(load(EXAMPLES / "design-point.yaml", overrides))
    designs = []
    for t in (np.array([0.7, 0.4]), np.array([0.7, 0.33]), np.array([0.55, 0.4])):  # more margin costs power here
        study = problem.study(t)
        designs.append(JudgedDesign(t, study, problem.value_of(study, t)))
    designs.sort(key=lambda design: design.margin)
    front = sorted(designs, key=lambda design: -design.value)
    evidence = SearchEvidence(
        (17, 19), 119, 105, judged=7, candidates=3, candidates_judged=3, best_cell=0.93 * front[0].value,
        step=0.11 * front[0].value, widest=0.231, bound=1.0123456 * front[0].value,
    )  # fmt: skip
    return SearchResult(problem, front[0], None, tuple(designs), evidence)


def of_design(design: JudgedDesign) -> Results:
    study = design.study
    return Results(json.loads(results_json(study, provenance_of(study.loaded, "vireport optimise x.yaml"))))


def test_the_best_design_is_told_with_its_own_numbers() -> None:
    result = search()
    text = plain(outputs.text(result, result.best.study, tables=True))
    best, evidence = of_design(result.best), result.evidence
    power = power_w(best, *best.design_speeds[0])
    said = [
        Said("Mean electrical power: {};", Amount(power, "W", 3)),
        Said("has a margin of 24 %."),  # 23.1 %, rounded up
    ]
    wrong = [fault for of in said if (fault := of.faults(text))]
    share = float(re.search(r"better by more than ([\d.]+) %", text)[1]) / 100
    assert evidence.bound <= result.best.value * (1 + share) <= evidence.bound * 1.002  # rounded, and so upwards
    tables = {table.caption: table for table in terminal_tables(outputs.text(result, result.best.study, tables=True))}
    table = tables["The best design"]
    rows = [
        {"Input": "device.length_m", "Value": number(best.device.length_m, 8), "In the scenario": number(0.69),
         "From": number(0.2), "To": number(1.2), "At its limit": "no"},
        {"Input": "excitation.frequency_hz", "Value": number(best.device.frequency_hz, 8),
         "In the scenario": number(2.0), "From": number(1.0), "To": number(4.0), "At its limit": "no"},
    ]  # fmt: skip
    wrong += table_faults(table.head, table.rows, rows)
    table, rows, before = (
        tables["What margin costs: the largest mean electrical power for each smallest margin"],
        [],
        None,
    )
    for design in result.front:
        of = of_design(design)
        margin, power = 100 * abs(of.ending[0]["relative"]), power_w(of, *of.design_speeds[0])
        # Where margin costs nothing, as a limit holds both values, the table has 0.
        fall = 0.0 if before is None else max(before[1] - power, 0.0)
        cost = "" if before is None else Amount(fall / (margin - before[0]), "W", 3)
        row = {"margin": Amount(margin, "%", 2), "mean electrical power": Amount(power, "W"), "cost of 1 %": cost}
        rows.append(
            row
            | {"device.length_m": number(of.device.length_m), "excitation.frequency_hz": number(of.device.frequency_hz)}
        )
        before = margin, power
    wrong += table_faults(table.head, table.rows, rows)
    picture, (first, *_, last) = outputs.picture_front(result), rows
    wrong += [
        fault
        for of in (Said("from {} to {}.", number(first["margin"].value, 2), Amount(last["margin"].value, "%", 2)),)
        if (fault := of.faults(picture.caption))
    ]
    falls = Said("goes from {} to {}.", *(Amount(row["mean electrical power"].value, "W", 3) for row in (first, last)))
    wrong += [fault for fault in [falls.faults(picture.alt)] if fault]
    (line,) = [line for line in picture.figure.axes[0].lines if line.get_marker() == "o"]
    expected = [(row["margin"].value, 1e3 * row["mean electrical power"].value) for row in rows]
    assert np.column_stack(line.get_data()) == pytest.approx(np.array(expected), rel=1e-9)
    (required_margin,) = [line for line in picture.figure.axes[0].lines if line.get_linestyle() == "--"]
    assert set(required_margin.get_xdata()) == {5.0}
    costs = [1e3 * row["cost of 1 %"].value for row in rows[1:]]
    legend = " ".join(text.get_text() for text in picture.figure.findobj(Text))
    wrong += [
        fault
        for of in (Said("costs {} to {} mW", number(min(costs), 3), number(max(costs), 3)),)
        if (fault := of.faults(legend))
    ]
    assert not wrong, "\n".join(wrong)


def test_json_of_the_best_design_has_its_own_numbers() -> None:
    result = search()
    provenance = provenance_of(result.best.study.loaded, "vireport optimise x.yaml")
    data = json.loads(outputs.optimise_json(result, result.best.study, provenance))
    for entry, design in zip([data["best"], *data["front"]], [result.best, *result.front], strict=True):
        of = of_design(design)
        assert entry["value"] == pytest.approx(1e3 * power_w(of, *of.design_speeds[0]), rel=1e-11)
        assert entry["margin_percent"] == pytest.approx(100 * abs(of.ending[0]["relative"]), rel=1e-11)
        assert entry["inputs"] == pytest.approx(
            {"device.length_m": of.device.length_m, "excitation.frequency_hz": of.device.frequency_hz}, rel=1e-15
        )
    assert data["nearest"] is None
    expected = {
        "cells": [17, 19], "stable": 119, "within_limits": 105, "tolerated": None, "no_cell_tolerates_percent": None,
        "yield_takes_percent": None, "judged": 7, "candidates": 3, "candidates_judged": 3,
        "best_cell": result.evidence.best_cell, "largest_step": result.evidence.step,
        "no_cell_has_margin_percent": pytest.approx(23.1), "proved_bound": result.evidence.bound, "cells_elsewhere": 0,
    }  # fmt: skip
    assert data["evidence"] == expected


def test_a_chart_shows_its_points_in_the_columns_of_its_inputs() -> None:
    plane = plane_of(load(EXAMPLES / "inclined.yaml").scenario, "inclination_deg=3..90,length_m=0.3..1")
    meetings = [
        SimpleNamespace(events=events, word=word, inputs=inputs)
        for events, word, inputs in (
            ((Event.GRAZING, Event.GRAZING), "BT", (31.2512345678901, 0.6875)),
            ((Event.PERIOD_DOUBLING, Event.GRAZING), "BBT", (12.5, 0.4375)),
        )
    ]
    chart: Any = SimpleNamespace(
        plane=plane,
        limits=Limits(4, 3),
        not_followed=2,
        meetings=meetings,
        loci=[SimpleNamespace(event=Event.FOLD)] * 5,
        regions=SimpleNamespace(sets=(), every=()),
        design=None,
    )
    text = chart_text(chart, tables=True)
    assert "Over inclination from 3 to 90° and length from 0.3 to 1 m: 5 curves and 2 points" in plain(text)
    assert "at most 4 impacts in 3 forcing periods" in plain(text)
    assert "2 ends of curves could not be followed" in plain(text)
    (table,) = terminal_tables(text)
    assert table.head == ["No.", "What", "Motion", "inclination [°]", "length [m]"]
    head, _, *rows = [line for line in chart_markdown(chart).splitlines() if line.startswith("|")]
    assert cells_of(head) == table.head
    named = zip(table.rows, rows, meetings, ("two grazings", "period doubling with grazing"), strict=True)
    for shown, written, point, what in named:
        assert cells_of(written) == shown
        assert shown[1:3] == [what, point.word]
        assert [float(cell) for cell in shown[3:]] == pytest.approx(point.inputs, rel=5e-3)
        assert max(len(cell.replace(".", "").lstrip("0")) for cell in shown[3:]) <= 3


def cells_of(row: str) -> list[str]:
    """The cells of a row in Markdown, which keeps brackets from being links."""
    return [cell.strip().replace("\\", "") for cell in row.strip("|").split("|")]


@pytest.mark.parametrize("name", cases(["length swept, with everything", "frequency swept", SIMULATED]))
def test_captions_of_figures_along_the_sweep_have_the_numbers_of_the_results(name: str) -> None:
    study, wrong = study_of(name), []
    for figure, said in along_the_sweep(results_of(name)):
        shown = caption_facts(study, Task(figure), simulated_points(study))
        text = f"{pictured(Task(figure), shown, Figure).caption} {alt_text(Task(figure), shown)}"
        wrong += [f"{figure}: {fault}" for fault in [said.faults(text)] if fault]
        if figure == "figure-2":
            assert ("equally fast" in text) is (results_of(name).device.inclination_deg == 0)
    assert not wrong, "\n".join(wrong)


def test_the_figures_of_a_design_point_have_the_numbers_of_the_results() -> None:
    name = "three forcing periods, no sweep, valid voltages"
    x, drawn = results_of(name), pictures_of(name)
    text = f"{drawn['figure-margins'].caption} {drawn['figure-margins'].alt}"
    wrong = [fault for said in of_margins(x) if (fault := said.faults(text))]
    assert not wrong, "\n".join(wrong)
    end, bars = x.ending[0], [bar.get_width() for bar in drawn["figure-margins"].figure.axes[0].patches]
    shifts = [slope * getattr(x.device, key) / end["sweep_value"] for key, slope in end["derivatives"].items()]
    expected = sorted((shift for shift in shifts if shift), key=abs, reverse=True)
    assert bars == pytest.approx(expected, rel=1e-9)
    device = drawn["figure-device"]
    assert Said("s = {}", Amount(x.device.length_m, "m", 3)).faults(device.alt) == ""
