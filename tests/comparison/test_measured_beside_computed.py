"""Computed motions held against measured ones, in standard errors, of the scenario with a record and of others."""

from __future__ import annotations

from types import MappingProxyType

import pytest
from conftest import EXAMPLES
from msgspec import UNSET

from vireport import load
from vireport.design.solution import solution_of
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.report.changes.quantities import STANDARD_ERRORS, ComparedScenario, QuantityGroup, compared_scenarios
from vireport.report.changes.table import NO_DIFFERENCE, axes_of, comparison_rows
from vireport.study.measured import measured_data, measured_of
from vireport.study.result_records import Results
from vireport.study.results import solution_data

KNOWN = {"device.restitution": None, "device.restitution_bottom": 0.52, "device.restitution_top": 0.47}
RECORD = [{"impacts": "measured-impacts.csv", "force_maximum_s": 0.0}]


def results(**over: object) -> Results:
    """What a comparison reads of a design point."""
    given = {path.replace("__", "."): value for path, value in over.items()}
    loaded = load(EXAMPLES / "measured.yaml", KNOWN | given)
    solution = solution_of(Device.of(loaded.scenario), Membrane.of(loaded.scenario), None, True, None)
    measured = measured_data(measured_of(loaded)) if loaded.scenario.measured else UNSET
    settings = loaded.scenario.model_dump(mode="json", by_alias=True)
    return Results(schema_version=1, scenario=settings, **solution_data(solution), alerts=[], measured=measured)


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
