"""A map has Q of the law for small kicks of each cell, the same as a run."""

from __future__ import annotations

import numpy as np
import pytest

from tests.findings.escape.test_lifetimes import cores_of
from tests.findings.outcomes.devices import case
from vireport.findings.escape.least_kicks import least_kicks
from vireport.map.cells.cells import map_plan
from vireport.map.cells.evaluation import evaluate
from vireport.scenario.loading import loads_map

pytest.importorskip("numba")
pytest.importorskip("pyarrow")

MAP = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 0.75}
excitation: {frequency_hz: 2.0}
map:
  escape: true
  sampling: list
  axes:
    - {path: inclination_deg, values: [45, 45, 45, 45]}
    - {path: excitation.amplitude_n, values: [0.8, 2.2, 3.0, 5.348]}
"""
"""Too weak, with a way out, without one, and too near the period doubling."""


@pytest.mark.slow
def test_cells_have_the_exponent_of_a_run() -> None:
    plan = map_plan(loads_map(MAP))
    assert plan.needs_numba
    table = evaluate(plan, np.arange(4))
    weak, leaving, staying, critical = table["escape_q_m2_s2"].to_pylist()
    device = case(force=2.2)
    way = least_kicks(device.groups, cores_of(device))
    assert leaving == pytest.approx(way.path.exponent * device.unit**2, rel=1e-3)
    assert [weak, staying, critical] == [None, None, None]
    assert table.schema.field("escape_q_m2_s2").metadata == {b"unit": b"m2/s2"}
    assert (
        "escape_q_m2_s2" not in evaluate(map_plan(loads_map(MAP.replace("true", "false"))), np.arange(1)).column_names
    )
