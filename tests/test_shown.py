"""What pages and terminals show is what results.json and the definitions say: by table, row and column, and in sentences.

`shown_tables.py` has what is held, `definitions.py` the formulae, `shown.py` reads. Scenarios differ in all numbers:
V_B and V_T, both membranes, force and frequency; several periods, with and without a design point.
"""

from __future__ import annotations

import json
import re
from functools import cache
from typing import Any

import pytest
from conftest import EXAMPLES
from pages import Page
from shown import table_faults
from shown_tables import ELSEWHERE, TABLES, WORDS_ONLY, Results, headline, inputs_faults, sentences

from vireport.report import Report, render_html
from vireport.scenario import load
from vireport.study import Study, analyse, provenance_of, results_json

DIELECTRIC = {
    f"device.membrane.{key}": value
    for key, value in {"thickness_m": 0.47e-3, "relative_permittivity": 4.3, "breakdown_field_v_m": 1.07e8}.items()
}


def required(**limits: object) -> dict[str, object]:
    return {f"requirements.{key}": limit for key, limit in limits.items()}


SCENARIOS: dict[str, tuple[str, dict[str, object]]] = {
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
                field_at_most_percent=150, yield_at_least_percent=90, acceleration_at_most_g=2.5,
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
         "device.ball_mass_kg": 0.0039, "simulation.samples": 12, "simulation.starts": 8},
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
        {"simulation.samples": 4, "simulation.starts": 5, "excitation.amplitude_n": 3.9, "sweep.from": 2.6,
         **required(crosscheck_passed=True, margin_period_doubling_percent=20, force_at_most_n=3.8)},
    ),
}  # fmt: skip


@cache
def study_of(name: str) -> Study:
    example, overrides = SCENARIOS[name]
    return analyse(load(EXAMPLES / f"{example}.yaml", overrides))


@cache
def results_of(name: str) -> Results:
    study = study_of(name)
    return Results(json.loads(results_json(study, provenance_of(study.loaded, "vireport run x.yaml"))))


@cache
def page_of(name: str) -> Page:
    study = study_of(name)
    return Page(render_html(Report(study, {}, provenance_of(study.loaded, "vireport run x.yaml"))))


def matching(caption: str, captions: Any) -> str | None:
    return next((pattern for pattern in captions if re.fullmatch(pattern, caption)), None)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_table_shows_what_results_and_definitions_say(name: str) -> None:
    results, wrong = results_of(name), []
    for table in page_of(name).all_tables:
        if (held := matching(table.caption, TABLES)) is not None:
            expected = TABLES[held](results)
            wrong += [f"{table.caption}: {fault}" for fault in table_faults(table.rows[0], table.rows[1:], expected)]
        elif table.caption == "Values, and where they come from":
            wrong += list(inputs_faults(results, table.rows[1:]))
        else:
            assert matching(table.caption, (*WORDS_ONLY, *ELSEWHERE)), f"{table.caption} is held by no row of TABLES"
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_sentence_has_the_numbers_of_the_results(name: str) -> None:
    text = page_of(name).text
    wrong = [fault for said in sentences(results_of(name)) if (fault := said.faults(text))]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_headline_has_the_numbers_of_the_results(name: str) -> None:
    text = study_of(name).verdict.headline
    wrong = [fault for said in headline(results_of(name)) if (fault := said.faults(text))]
    assert not wrong, "\n".join(wrong)


def test_each_held_table_is_on_a_page() -> None:
    captions = [table.caption for name in SCENARIOS for table in page_of(name).all_tables]
    assert [pattern for pattern in TABLES if not any(re.fullmatch(pattern, caption) for caption in captions)] == []
