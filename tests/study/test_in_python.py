"""What a user of Python and of notebooks meets: short records, rows, the voltage that counts, messages for mistakes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import Struct

import vireport
from vireport import ScenarioError, Study, UsageError, VireportError, analyse, compare, load, loads
from vireport.base.records import brief
from vireport.study.provenance import provenance_of
from vireport.study.study import results_json

LONGEST = 600
"""Characters of what a console shows of a record: some five lines."""

DEEPEST = 5
"""Attributes from a study to a record that a user looks at."""

ARRAYS_SHOWN = "array(["


def public(record: Struct) -> Iterator[str]:
    """Names of the fields and properties of a record."""
    yield from record.__struct_fields__
    for kind in type(record).__mro__:
        yield from (name for name, of in vars(kind).items() if isinstance(of, property | cached_property))


def met(value: Any, seen: dict[int, Any], depth: int = 0) -> Iterator[Struct]:
    """Every record that is met from a value on, by public attributes, of a list the first three."""
    if isinstance(value, tuple | list | dict):
        for part in list(value.values() if isinstance(value, dict) else value)[:3]:
            yield from met(part, seen, depth)
    elif isinstance(value, Struct) and id(value) not in seen and depth <= DEEPEST:
        seen[id(value)] = value
        yield value
        for name in public(value):
            if not name.startswith("_"):
                try:
                    part = getattr(value, name)
                except (TypeError, ValueError, VireportError):  # such as the closed form of a motion that has none
                    continue
                yield from met(part, seen, depth + 1)


def require_short(value: Any) -> set[str]:
    kinds = set()
    for record in met(value, {}):
        shown = repr(record)
        assert len(shown) <= LONGEST, (type(record), shown)
        assert "\n" not in shown, type(record)
        assert shown.count(ARRAYS_SHOWN) <= 2, (type(record), shown)
        kinds.add(type(record).__name__)
    return kinds


def test_no_record_of_a_study_fills_the_console(study_of: Callable[..., Study]) -> None:
    met_ones = require_short(study_of("inclined"))
    assert met_ones >= {
        "Study",
        "Solution",
        "DesignPoint",
        "Motions",
        "Voltages",
        "Branch",
        "Family",
        "Point",
        "Margin",
    }
    assert met_ones >= {"StableInterval", "Verdict", "Evidence", "Alert", "Plan", "Loaded", "Shifts"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "over"),
    [
        ("simulated", {"simulation.samples": 3, "simulation.starts": 2}),
        ("measured", {}),
        ("driven", {}),
        ("inclined", {"motions.impacts": 3, "tolerances.length_percent": 1, "disturbances.basin": True}),
        ("ci/failing", {}),
    ],
)
def test_no_record_of_a_study_with_further_blocks_does(name: str, over: dict[str, object], example) -> None:
    assert "Study" in require_short(analyse(load(example(name), over)))


def test_no_record_of_a_comparison_does(study_of: Callable[..., Study]) -> None:
    found = require_short(compare([study_of("inclined"), study_of("design-point")]))
    assert {"Comparison", "ComparisonRow", "Ranked"} <= found


def test_records_say_what_they_are_with_units(study_of: Callable[..., Study]) -> None:
    study = study_of("inclined")
    solution, design = study.solution, study.solution.design
    end = "period doubling B1 at f = 1.91 Hz (−4.7 %)"
    assert repr(design) == f"<DesignPoint s = 0.6934 m: 2 motions, stable node, U_ave 42.8 kV, nearest end: {end}>"
    assert repr(design.margins[0]) == f"<Margin to {end}>"
    assert repr(design.motions) == "<Motions: 2, 2 admissible, 1 stable>"
    assert repr(design.voltages_by_motion) == "<Voltages of 2 motions: U_ave 16.3 kV to 42.8 kV>"
    assert repr(solution.stable_ranges) == "(<StableInterval 0.629 m < s ≤ 0.75 m>,)"
    assert repr(solution.critical_points) == "(<Point B1: period doubling at 0.629, d = 0.418>,)"
    assert repr(solution.branches[1]).endswith("63 motions, s = 0.59 to 0.75 m, stable for 0.629 to 0.75 m>")
    assert repr(solution.branches[0]).endswith("nowhere stable>")
    assert "2 branches, critical points B1, stable for 0.629 m < s ≤ 0.75 m, DesignPoint s" in repr(solution)
    assert repr(study.plan).startswith(f"<Plan: {sum(step.runs for step in study.plan.steps)} steps run, ")
    assert repr(study.loaded).startswith("<Loaded ")
    assert repr(load(study.loaded.document.name, {"device.restitution": 0.6})).endswith(" with device.restitution=0.6>")
    (deep,) = (alert for alert in study.alerts if alert.code == "VR010")
    assert repr(deep) == "<Alert VR010, note: A membrane is pressed in deeper than its radius>"
    nothing = analyse(load(study.loaded.document.name, {"sweep": None, "device.length_m": 0.05}), ("json",))
    assert repr(nothing.solution) == "<Solution: DesignPoint s = 0.05 m: no motion>"
    horizontal = study_of("horizontal").solution.design
    assert "nearest end: pitchfork C1" in repr(horizontal)
    flat = [margin for margin in horizontal.margins if margin.relative is None]
    assert flat
    assert all(repr(margin).endswith("°)>") for margin in flat)


def test_a_scenario_shows_the_keys_that_are_given(study_of: Callable[..., Study]) -> None:
    shown = repr(study_of("inclined").scenario)
    assert "restitution=0.5" in shown
    assert "restitution_bottom" not in shown
    assert "None" not in shown


def test_brief_leaves_out_what_is_not_there_and_tells_arrays_by_their_shape() -> None:
    class Inner(Struct):
        x: int = 1

    class Kind(Enum):
        ONE = "first"

    class Outer(Struct):
        numbers: Any
        inner: Inner
        parts: tuple[Inner, ...]
        kind: Kind
        text: str
        share: float
        nothing: None = None
        empty: tuple[int, ...] = ()

    record = Outer(np.zeros((2, 3)), Inner(), (Inner(),), Kind.ONE, 50 * "a", 1 / 3)
    text = f"'{40 * 'a'}...'"
    assert brief(record) == (
        f"Outer(numbers=float64[2, 3], inner=Inner(...), parts=tuple[1], kind=ONE, text={text}, share=0.333333)"
    )


def test_a_notebook_shows_the_motions_and_margins_of_a_design_point(study_of: Callable[..., Study]) -> None:
    design = study_of("inclined").solution.design
    shown = design._repr_html_()
    assert shown.count("<tr>") == 1 + len(design.motions) + 1 + len(design.limits())
    assert "<td>stable node</td><td>yes</td><td>0.586</td>" in shown
    assert "<td>42.8 kV</td>" in shown
    plan = study_of("inclined").plan
    assert plan._repr_html_().count("<tr>") == 1 + len(plan.steps)


def test_without_a_sweep_rows_are_the_motions_of_the_design_point(study_of: Callable[..., Study]) -> None:
    alone, swept = study_of("design-point"), study_of("inclined")
    rows, design = alone.rows(), alone.to_dict()["design_point"]
    assert list(rows[0]) == list(swept.rows()[0])
    assert len(rows) == len(design["q"]) == 2
    for name in ("sweep_value", "q", "velocity_top", "stability", "admissible", "u_ave_v", "admissible_undecided"):
        assert [row[name] for row in rows] == design[name]
    assert [row["family"] for row in rows] == design["family"]
    assert {row["branch"] for row in rows} == {row["critical_point"] for row in rows} == {None}


def test_rows_of_a_sweep_are_those_of_results_json(study_of: Callable[..., Study]) -> None:
    study = study_of("horizontal")
    rows = study.rows()
    for branch in study.to_dict()["branches"]:
        mine = [row for row in rows if row["branch"] == branch["number"]]
        for name in ("sweep_value", "phi_top_rad", "u_ave_v", "critical_point", "admissible"):
            assert [row[name] for row in mine] == branch[name]


def test_the_voltage_of_a_design_is_that_of_its_stable_motion(study_of: Callable[..., Study], example) -> None:
    study = study_of("inclined")
    design = study.to_dict()["design_point"]
    ((row, _),) = [(k, word) for k, word in enumerate(design["stability"]) if word.startswith("stable")]
    assert study.solution.design.u_ave_v == design["u_ave_v"][row] != min(design["u_ave_v"])


def test_of_several_stable_motions_the_voltage_is_the_least_and_of_none_there_is_none(example) -> None:
    # Two asymmetric motions, no mirror images of each other, as the membranes are not alike.
    parts = {"restitution": None, "restitution_bottom": 0.499, "restitution_top": 0.501, "length_m": 0.3}
    over = {"sweep": None} | {f"device.{key}": value for key, value in parts.items()}
    design = analyse(load(example("horizontal"), over), ("json",)).solution.design
    assert design.motions.stable_mask.tolist() == [True, True, False]
    first, second, _ = design.voltages_by_motion.average_v
    assert first > second == design.u_ave_v
    none = analyse(load(example("inclined"), {"device.length_m": 0.6}), ("json",)).solution.design
    assert len(none.motions) > 0
    assert not none.motions.stable_mask.any()
    assert none.u_ave_v is None
    without_mass = analyse(load(example("inclined"), {"device.ball_mass_kg": None}), ("json",)).solution.design
    assert without_mass.motions.stable_mask.any()
    assert without_mass.u_ave_v is None


SCENARIO = {
    "schema_version": 1,
    "device": {"capsule_mass_kg": 0.1245, "ball_mass_kg": 0.0041, "restitution": 0.5, "length_m": 0.6934},
    "excitation": {"amplitude_n": 3.0, "frequency_hz": 2.0},
    "inclination_deg": 45.0,
}


def test_a_dict_is_a_scenario() -> None:
    loaded = load(SCENARIO)
    assert loaded.scenario == loads(json.dumps(SCENARIO)).scenario
    assert load(SCENARIO, {"device.length_m": 0.7}).scenario.device.length_m == 0.7
    study = analyse(SCENARIO, ("json",))
    assert study.solution.design.u_ave_v == pytest.approx(42836.16, rel=1e-6)
    assert loads(study.loaded.document.text).scenario == study.scenario
    assert results_json(study, provenance_of(study.loaded, "test"))


def test_numbers_of_numpy_are_numbers_of_a_scenario() -> None:
    device = SCENARIO["device"] | {"length_m": np.float64(0.7), "restitution": np.float32(0.5)}
    loaded = load(SCENARIO | {"device": device, "inclination_deg": np.int64(45)})
    assert (loaded.scenario.device.length_m, loaded.scenario.inclination_deg) == (0.7, 45)
    compared = compare(SCENARIO, vary={"inclination_deg": np.arange(30, 60, 15)})
    assert compared.names == ("inclination 30°", "inclination 45°")
    assert repr(compared).startswith("<Comparison of inclination 30°, inclination 45°: Best: inclination 30°")


def test_mistakes_in_a_dict_are_told_as_those_of_a_file() -> None:
    wrong = SCENARIO | {"device": SCENARIO["device"] | {"lenght_m": 0.7, "restitution": float("nan")}}
    with pytest.raises(ScenarioError) as refused:
        analyse(wrong)
    text = str(refused.value)
    assert "device.lenght_m: unknown key; did you mean 'length_m'?" in text
    assert "device.restitution: " in text
    assert len(refused.value.lines) == 2


@pytest.mark.parametrize("value", [Path("x"), {1, 2}, object(), 1j])
def test_what_a_scenario_cannot_hold_is_refused(value: object) -> None:
    with pytest.raises(UsageError, match=r"cannot hold a value of type \w+ \(allowed in a scenario: texts, numbers"):
        load(SCENARIO | {"title": value})
    with pytest.raises(UsageError, match="cannot hold a value of type"):
        load(SCENARIO, {"title": value})


def test_a_dict_that_holds_itself_is_refused() -> None:
    circle = dict(SCENARIO)
    circle["device"] = circle
    with pytest.raises(UsageError, match="allowed in a scenario"):
        load(circle)


NO_SOURCES = [None, [], ["a.yaml"], 3, b"examples/inclined.yaml", object()]


@pytest.mark.parametrize("value", NO_SOURCES, ids=lambda value: type(value).__name__)
def test_what_is_no_scenario_is_told_what_is(value: object) -> None:
    for function in (load, analyse):
        with pytest.raises(UsageError, match=r"from a value of type \w+ \(allowed: the path of a YAML file"):
            function(value)


def test_text_in_place_of_a_file_is_sent_to_loads() -> None:
    for text in ("schema_version: 1\ndevice:\n", ""):
        with pytest.raises(UsageError, match=r"is no name of a file \(the text of a scenario is for loads\)"):
            analyse(text)
    for value in (None, SCENARIO, ["a"], 3):
        with pytest.raises(UsageError, match=r"text of a scenario cannot be of type \w+ \(allowed: str, bytes\)"):
            loads(value)


def test_a_study_or_a_loaded_scenario_in_the_wrong_place(study_of: Callable[..., Study], example) -> None:
    study = study_of("inclined")
    with pytest.raises(UsageError, match=r"solved already \(use it as it is"):
        analyse(study)
    with pytest.raises(UsageError, match="from a value of type Loaded"):
        load(study.loaded)
    with pytest.raises(UsageError, match="is a folder, not a scenario file"):
        analyse(example("inclined").parent)


@pytest.mark.parametrize("value", [None, "examples/inclined.yaml", {}, 3], ids=lambda value: type(value).__name__)
def test_what_is_no_study_is_told_what_is(value: object, study_of: Callable[..., Study]) -> None:
    study = study_of("inclined")
    calls: list[Callable[[Any], Any]] = [
        *(vireport.figure_2, vireport.figure_4, vireport.figure_7, vireport.pictures),
        lambda x: vireport.results(x, provenance_of(study.loaded, "test")),
        lambda x: vireport.diff(study.to_dict(), x),
    ]
    for call in calls:
        with pytest.raises(
            UsageError,
            match=r"a Study is needed, not a value of type \w+ \(allowed: what analyse gives|is no results.json of",
        ):
            call(value)
    with pytest.raises(UsageError, match="a Comparison is needed"):
        vireport.compare_figure(value, "figure-2")
    for recheck in (vireport.recheck, vireport.recheck_disturbances):
        with pytest.raises(UsageError, match="allowed: the content of a results"):
            recheck(value)


@pytest.mark.parametrize("items", [None, 3, b"a", [None, None]], ids=lambda value: type(value).__name__)
def test_what_cannot_be_compared_is_told(items: object) -> None:
    with pytest.raises(UsageError, match="allowed: the path of a YAML file"):
        compare(items)


def test_values_to_vary_must_be_a_list() -> None:
    for values in (5, "0, 45", None):
        with pytest.raises(
            UsageError, match=r"--vary inclination_deg: .* is no list of values \(such as \[1, 2, 3\]\)"
        ):
            compare(SCENARIO, vary={"inclination_deg": values})


def test_a_figure_that_a_comparison_does_not_have(study_of: Callable[..., Study]) -> None:
    compared = compare([study_of("inclined"), study_of("horizontal")])
    with pytest.raises(UsageError, match=r"no figure 'figure_2' .*allowed: figure-2, figure-4, figure-7"):
        vireport.compare_figure(compared, "figure_2")
