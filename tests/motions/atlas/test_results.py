"""Families of motions in a study: results.json, voltages, the figure and the section of the report."""

from __future__ import annotations

import csv
import json
from html import unescape

import numpy as np
import pytest
from msgspec.structs import replace
from pages import render_html

from vireport import analyse, loads
from vireport.base.errors import ScenarioError, UsageError
from vireport.motions import families
from vireport.motions.atlas.portraits import portrait_of
from vireport.motions.generation import generation, ladder
from vireport.motions.switching import Limits
from vireport.physics.energy import generated_voltage
from vireport.report.context import Report
from vireport.report.tables import RunTables
from vireport.study.provenance import provenance_of
from vireport.study.results import branches_csv
from vireport.study.study import Study

TEXT = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5}
excitation: {amplitude_n: 5, frequency_hz: 2.5}
inclination_deg: 30
sweep: {parameter: length_m, from: 0.24, to: 0.42}
motions: {impacts: 3, periods: 1}
"""

ENDS = ("begins_with", 0), ("ends_with", -1)


@pytest.fixture(scope="module")
def followed():
    """A study, and what was told while it was made."""
    told = []
    return analyse(loads(TEXT), progress=told.append), told


@pytest.fixture(scope="module")
def study(followed):
    return followed[0]


def families_shown(study):
    *_, table = RunTables(study).motions()
    return table.rows


@pytest.mark.slow
def test_each_family_is_told_as_it_is_followed(followed):
    study, told = followed
    words = {step.rpartition(" ")[2] for step in told}
    assert {family.word.letters for family in study.atlas.families} <= words | {"BT"}  # which is a closed form


def test_results_hold_every_family_with_its_ends_and_voltages(study):
    data = json.loads(json.dumps(study.to_dict()))
    families = {family["number"]: family for family in data["families"]}
    assert {family["word"] for family in families.values()} >= {"BT", "BBT"}
    for family in families.values():
        low, high = family["from"], family["to"]
        assert 0.24 <= low < high <= 0.42
        assert all(low <= part["from"] < part["to"] <= high for part in family["stable_range"])
        assert len(family["sweep_value"]) == len(family["velocity"]) == len(family["stable"]) == len(family["d"])
        np.testing.assert_allclose(np.mod(np.pi * np.array(family["time"]), 2 * np.pi), family["phase_rad"])
        real, imaginary = (np.array(family["multipliers"][part], dtype=float) for part in ("real", "imaginary"))
        np.testing.assert_allclose(real.sum(axis=1), np.array(family["trace"], dtype=float), rtol=1e-12)
        product = np.prod(real + 1j * imaginary, axis=1)
        np.testing.assert_allclose(product[~np.isnan(product)], family["determinant"])
        size = np.hypot(real, imaginary).max(axis=1)
        off = np.abs(size - 1) > 1e-9  # from where stability changes
        assert off.any()
        assert (np.array(family["stable"])[off] == (size[off] < 1)).all()
        assert np.max(family["error_bounds"]["velocity"]) < 1e-10
        for end in (family["begins_with"], family["ends_with"]):
            assert (end["label"] is None) == (end["kind"] == "sweep_end")
            assert all(number in families for number in end["families"])
        for point in family["critical_points"]:
            assert point["error_bound"] < 1e-15
        for given in family["generation"]:
            assert given["u_ave_v"] == pytest.approx(np.mean(given["u_impacts_v"]))
            assert given["impacts_per_s"] == 2.5 * len(family["word"])
            assert given["u_per_second_v"] == pytest.approx(2.5 * sum(given["u_impacts_v"]))
    labels = {p["label"]: p["sweep_value"] for f in families.values() for p in f["critical_points"]}
    for point in data["critical_points"]:
        assert point["kind"] == "node_focus" or labels[point["label"]] == point["sweep_value"]


@pytest.mark.slow
def test_a_family_that_is_not_followed_to_its_end_says_so_and_how_far_it_was(monkeypatch):
    monkeypatch.setattr("vireport.motions.paths.MOST_POINTS", 6)
    study = analyse(loads(TEXT))
    ends = [(f[end], f["sweep_value"][row]) for f in study.to_dict()["families"] for end, row in ENDS]
    lost = [(end["sweep_value"], last) for end, last in ends if end["kind"] == "not_followed"]
    assert lost
    assert all(told == last for told, last in lost)
    cells = [cell for row in families_shown(study) for cell in row]
    assert sum(cell.startswith("not followed beyond 0.") for cell in cells) == len(lost)


def test_the_table_of_motions_ends_with_a_row_for_each_impact_of_the_families(study):
    lines = branches_csv(study.solution, study.atlas).decode().splitlines()
    count = sum(len(branch.motions.d) for branch in study.solution.branches)
    # The 1:1 motions come first, as they are without families.
    alone = branches_csv(study.solution).decode().splitlines()
    assert [line.rstrip(",") for line in lines[1 : 1 + count]] == [line.rstrip(",") for line in alone[1:]]
    assert lines[0].startswith(alone[0] + ",word,")
    assert len({len(row) for row in csv.reader(lines)}) == 1
    rows = list(csv.DictReader(lines))[count:]
    assert len(rows) == sum(family.velocity.size for family in study.atlas.families) == len(study.rows()) - count
    (family,) = [f for f in study.atlas.families if f.word.letters == "BBT" and f.stable_runs]
    mine = [row for row in rows if row["family_number"] == str(family.number)]
    assert {row["q"] for row in mine} == {""}
    assert {row["critical_point"] for row in mine} == {""} | {
        mark.point.label for mark in family.marks if mark.point and mark.point.label
    }
    assert [row["wall"] for row in mine[:3]] == ["bottom", "bottom", "top"]
    assert [float(row["velocity"]) for row in mine] == family.velocity.ravel().tolist()
    assert [row["stable"] == "true" for row in mine[::3]] == family.stable_mask.tolist()
    unit = float(study.solution.device.velocity_unit("length_m", 0.0))
    for row in mine[:3]:
        volts = generated_voltage(np.array([unit * float(row["velocity"])]), study.solution.membrane)
        assert float(row["u_v"]) == pytest.approx(float(volts[0]))


def test_families_of_1_1_motions_generate_what_the_branches_do(study):
    branch = max(
        study.solution.branches, key=lambda branch: branch.motions.sweep_value[branch.motions.stable_mask].max()
    )
    (family,) = [f for f in study.atlas.families if f.word.letters == "BT" and f.stable_mask[-1]]
    volts = generation(family, study.solution.membrane).average_v
    order = np.argsort(branch.motions.sweep_value)
    value, average = branch.motions.sweep_value[order], branch.voltages_by_motion.average_v[order]
    np.testing.assert_allclose(volts, np.interp(family.sweep_value, value, average), rtol=1e-3)


def test_the_table_has_every_family_with_its_range(study):
    rows = [(row[0], *map(float, row[3].split(" to "))) for row in families_shown(study)]
    families = [(f.word.letters, f.sweep_value.min(), f.sweep_value.max()) for f in study.atlas.families]
    for (word, *ends), (same, *own) in zip(sorted(rows), sorted(families), strict=True):
        assert word == same
        assert ends == [float(f"{end:.3g}") for end in own]


def test_the_ladder_has_the_best_of_each_word(study):
    membrane = study.solution.membrane
    rungs = {(rung.word.letters, rung.word.periods): rung for rung in ladder(study.atlas.families, membrane)}
    assert {("BT", 1), ("BBT", 1)} <= rungs.keys()
    assert list(rungs.values()) == sorted(rungs.values(), key=lambda rung: -rung.per_second_v)
    for (word, periods), rung in rungs.items():
        families = [f for f in study.atlas.families if (f.word.letters, f.word.periods) == (word, periods)]
        volts = [generation(f, membrane).impacts_v[row] for f in families for row in np.flatnonzero(f.stable_mask)]
        assert rung.average_v == pytest.approx(max(map(np.mean, volts)))
        assert rung.per_second_v == pytest.approx(max(map(np.sum, volts)) * 2.5 / periods)
        assert rung.impacts_per_s == (2.5 * len(word) / periods,) * 2
        assert any(low <= rung.average_at <= high for low, high in rung.ranges)


DOUBLED = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5, length_m: 0.69}
excitation: {amplitude_n: 3}
inclination_deg: 45
sweep: {parameter: frequency_hz, from: 1.9, to: 1.92}
motions: {impacts: 4, periods: 2}
"""


@pytest.mark.slow
def test_rates_are_those_of_each_frequency_and_of_all_periods():
    """Where the frequency is swept, each motion has its own, and the unit of velocity with it."""
    study = analyse(loads(DOUBLED))
    data = study.to_dict()["families"]
    assert {("BT", 1), ("BTBT", 2)} <= {(family["word"], family["periods"]) for family in data if any(family["stable"])}
    for family in data:
        f, periods = np.array(family["sweep_value"]), family["periods"]
        np.testing.assert_allclose(family["impacts_per_s"], len(family["word"]) * f / periods)
        speeds = 3.0 / (2 * 0.1245 * f[:, None]) * np.array(family["velocity"])
        volts = generated_voltage(speeds, study.solution.membrane)
        np.testing.assert_allclose(family["u_impacts_v"], volts)
        np.testing.assert_allclose(family["u_per_second_v"], volts.sum(axis=1) * f / periods)
    for rung in ladder(study.atlas.families, study.solution.membrane):
        own = [x for x in data if (x["word"], x["periods"]) == (rung.word.letters, rung.word.periods)]
        value, average, rate = (
            np.concatenate([np.array(x[key])[x["stable"]] for x in own])
            for key in ("sweep_value", "u_ave_v", "u_per_second_v")
        )
        assert (rung.average_v, rung.average_at) == (average.max(), value[average.argmax()])
        assert (rung.per_second_v, rung.per_second_at) == pytest.approx((rate.max(), value[rate.argmax()]))


def test_motions_at_a_value_are_found_with_their_families(study):
    words = {family.word.letters for family, _ in study.atlas.at(0.3)}
    assert {"BT", "BBT"} <= words
    for family, motion in study.atlas.at(0.3):
        assert family.word == motion.word
        assert study.solution.sweep.value(motion.coordinate) == pytest.approx(0.3)


def test_a_name_stands_for_a_vertex_or_the_middle_of_a_words_widest_stable_range(study):
    vertex = study.atlas.vertices[0]
    assert study.atlas.named(vertex.label) == (vertex.sweep_value, vertex.motion)
    value, motion = study.atlas.named("BBT")
    widest = max((x for f in study.atlas.families if f.word.letters == "BBT" for x in f.stable_ranges), key=np.ptp)
    assert motion.word.letters == "BBT"
    assert value == pytest.approx(np.mean(widest), abs=0.1 * np.ptp(widest))
    assert study.atlas.named("TBB")[0] == value
    assert study.atlas.named("BBBB") is None


@pytest.mark.parametrize("name", ["BBT", "BT", "G1"])
def test_the_path_of_a_motion_is_between_the_membranes_and_closes(study, name):
    _, motion = study.atlas.named(name)
    family = study.atlas.families[0]
    shown = portrait_of(family.curve.model, motion, name)
    assert shown.time[-1] == pytest.approx(2 * motion.word.periods)
    assert np.abs(shown.position).max() == pytest.approx(shown.d / 2, abs=1e-9)
    assert shown.position[-1] == pytest.approx(shown.position[0])
    assert shown.velocity[0] == pytest.approx(-0.5 * shown.velocity[-1])
    # It solves Z'' = gbar + cos: differences of the velocity within the first flight.
    t, v = shown.time[:40], shown.velocity[:40]
    middle = (t[1:] + t[:-1]) / 2
    np.testing.assert_allclose(np.diff(v) / np.diff(t), shown.gbar + np.cos(np.pi * middle + shown.phase), atol=1e-3)
    assert len(shown.attractor.cycle.wall) == len(motion.word)


def test_without_the_block_no_family_is_followed():
    study = analyse(loads(TEXT.replace("motions: {impacts: 3, periods: 1}\n", "")))
    assert study.atlas is None
    assert study.to_dict()["families"] is None
    assert any(step["step"] == "motions" for step in study.to_dict()["left_out"])


def test_more_than_sixteen_impacts_are_refused_with_the_reason():
    with pytest.raises(UsageError, match="4116 of sixteen"):
        Limits(17, 4)
    with pytest.raises(ScenarioError, match="too large: sequences double"):
        loads(TEXT.replace("impacts: 3", "impacts: 17"))


def test_results_say_what_is_claimed_of_each_word(study):
    motions = study.to_dict()["motions"]
    assert (motions["impacts"], motions["periods"]) == (3, 1)
    claims = {row["word"]: row["claim"] for row in motions["completeness"]}
    complete = ("B", "BB", "BBB", "BT", "BBT", "BTT", "T", "TT", "TTT")
    assert claims == dict.fromkeys(complete, "complete") | {None: "followed"}


@pytest.mark.slow
def test_figure_and_section_name_the_words(study):
    from vireport.figures.pictures import pictures

    drawn = {picture.name: picture for picture in pictures(study)}
    picture, rungs = drawn["figure-atlas"], drawn["figure-ladder"].figure.axes
    assert [axes.get_ylabel() for axes in rungs] == ["mean Uₐᵥₑ [kV]", "per second [kV/s]", "impacts [1/s]"]
    (rate,) = {y for line in rungs[2].lines if line.get_linewidth() == 1.8 for y in np.unique(line.get_ydata())} - {5.0}
    assert rate == 7.5  # of BBT, 2.5 Hz
    (axes,) = picture.figure.axes
    solid = [line for line in axes.lines if line.get_linewidth() == 1.8 and len(line.get_xdata())]
    assert solid
    labels = {label for text in axes.texts for label in text.get_text().split(", ")}
    on_stable = [
        (mark.point.label, np.ptp(family.d[first : last + 1]) / abs(np.diff(study.atlas.sweep.coordinate_range)[0]))
        for family in study.atlas.families
        for first, last in family.stable_runs
        for mark in family.marks
        if mark.point is not None and mark.point.label and first <= mark.row <= last
    ]
    vertices = {vertex.label for vertex in study.atlas.vertices}
    seen = {label for label, width in on_stable if width > 0.002}
    assert vertices & labels == seen < {label for label, _ in on_stable}
    assert "BBT" in picture.alt


def test_report_and_results_say_from_how_many_impacts_on_families_are_left_out(study):
    assert study.to_dict()["motions"]["followed_impacts"] == 3
    said = "all families met are followed up to 2 impacts a period, of longer ones only a part"
    assert "of longer ones only a part" not in section(study)
    cut = replace(study, atlas=replace(study.atlas, followed=2))
    assert said in section(cut)
    assert cut.to_dict()["motions"]["followed_impacts"] == 2


@pytest.mark.slow
def test_pages_show_the_families_that_can_be_set_then_the_shortest_words_and_results_have_all(study, monkeypatch):
    from vireport.figures.pictures import pictures

    every = study.to_dict()
    assert study.atlas.printed_families == study.atlas.families
    assert "results.json and branches.csv have all" not in section(study)
    monkeypatch.setattr(families, "MOST_PRINTED", 2)
    monkeypatch.setattr(families, "settable", lambda low, high, off: high - low > 0.01)
    assert [family.number for family in study.atlas.printed_families] == [1, 3]  # 2 is stable over 0.003 m
    monkeypatch.setattr(families, "MOST_PRINTED", 3)
    assert [family.number for family in study.atlas.printed_families] == [1, 2, 3]
    assert study.to_dict() == every
    carried = study.to_dict(printed=True)
    assert carried["families"] == every["families"][:3]
    assert carried["motions"] == every["motions"]
    assert carried["motions"]["families_found"] == len(every["families"]) == 4
    assert "Of 4 families 3 are in the tables" in section(study)
    assert len(families_shown(study)) == 3
    drawn = {picture.name: picture for picture in pictures(study)}
    for name in ("figure-atlas", "figure-ladder"):
        assert "Drawn are 3 of 4 families" in drawn[name].caption
    assert drawn["figure-atlas"].alt.partition(". ")[2].startswith("3 families")


def section(study: Study) -> str:
    """The report as text."""
    page = render_html(Report(study, {}, provenance_of(study.loaded, "run"))).decode()
    return unescape(page).replace("\u00a0", " ")
