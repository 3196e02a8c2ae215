"""Families of motions in a study: results.json, voltages, the figure and the section of the report."""

from __future__ import annotations

import json

import numpy as np
import pytest

from vireport import analyse, loads
from vireport.errors import ScenarioError, UsageError
from vireport.sequences import Limits, generation
from vireport.study import json_bytes

TEXT = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5}
excitation: {amplitude_n: 5, frequency_hz: 2.5}
inclination_deg: 30
sweep: {parameter: length_m, from: 0.24, to: 0.42}
motions: {impacts: 3, periods: 1}
"""


@pytest.fixture(scope="module")
def study():
    return analyse(loads(TEXT))


def test_results_hold_every_family_with_its_ends_and_voltages(study):
    data = json.loads(json_bytes(study.to_dict()))
    families = {family["number"]: family for family in data["families"]}
    assert {family["word"] for family in families.values()} >= {"BT", "BBT"}
    for family in families.values():
        low, high = family["from"], family["to"]
        assert 0.24 <= low < high <= 0.42
        assert all(low <= part["from"] < part["to"] <= high for part in family["stable_range"])
        assert len(family["sweep_value"]) == len(family["velocity"]) == len(family["stable"]) == len(family["d"])
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


def test_families_of_1_1_motions_generate_what_the_branches_do(study):
    branch = max(study.solution.branches, key=lambda branch: branch.motions.sweep_value[branch.motions.stable].max())
    (family,) = [f for f in study.atlas.families if f.sequence.word == "BT" and f.stable[-1]]
    volts = generation(family, study.solution.membrane).average_v
    order = np.argsort(branch.motions.sweep_value)
    value, average = branch.motions.sweep_value[order], branch.voltages.average_v[order]
    np.testing.assert_allclose(volts, np.interp(family.sweep_value, value, average), rtol=1e-3)


def test_motions_at_a_value_are_found_with_their_families(study):
    words = {family.sequence.word for family, _ in study.atlas.at(0.3)}
    assert {"BT", "BBT"} <= words
    for family, motion in study.atlas.at(0.3):
        assert family.sequence == motion.sequence
        assert study.solution.sweep.value(*family.curve.model.groups(motion.coordinate)) == pytest.approx(0.3)


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
    assert claims == {"B": "complete", "BT": "complete", "BBT": "complete", "BTT": "complete", None: "followed"}


@pytest.mark.slow
def test_figure_and_section_name_the_words(study):
    from vireport.figures import pictures
    from vireport.report.motions import families_table

    (picture,) = [picture for picture in pictures(study) if picture.name == "figure-atlas"]
    (axes,) = picture.figure.axes
    solid = [line for line in axes.lines if line.get_linewidth() == 1.8 and len(line.get_xdata())]
    assert solid
    labels = {text.get_text() for text in axes.texts}
    assert {vertex.label for vertex in study.atlas.vertices} <= labels
    assert "BBT" in picture.caption
    table = families_table(study, study.atlas)
    assert [row[0] for row in table.rows].count("BBT") == sum(
        family.sequence.word == "BBT" for family in study.atlas.families
    )
