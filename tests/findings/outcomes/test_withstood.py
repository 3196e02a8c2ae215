"""What a design point withstands, in SI units: against its dimensionless parts, and where nothing can be said."""

from __future__ import annotations

import json
from functools import cache
from importlib import import_module
from math import pi

import numpy as np
import pytest
from conftest import solved
from devices import of
from msgspec.structs import replace

from vireport import analyse, loads
from vireport.base.errors import UsageError
from vireport.base.records import plain
from vireport.cli.app import main
from vireport.design.switched_on import SwitchedOn
from vireport.findings.outcomes.jitter import jitter as jitter_of
from vireport.findings.outcomes.outcomes import Outcomes
from vireport.findings.outcomes.results import disturbances_with_outcomes
from vireport.findings.outcomes.shock import MotionsByStability, least_shock
from vireport.findings.outcomes.steps import JITTER, SHOCK
from vireport.findings.outcomes.withstood import withstood_by
from vireport.study.plan import plan, refuse_undecidable
from vireport.study.results import switched_on_data

TEXT = """\
schema_version: 1
device: {{capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5, length_m: 0.75}}
excitation: {{amplitude_n: {force}, frequency_hz: 2}}
inclination_deg: 45
disturbances: {{jitter_m_s: {kick}}}
requirements: {{survives_shock_m_s: {shock}, phase_jitter_at_most_deg: 1, recovers_within_periods: 1e6}}
"""


@cache
def judged(force: float, kick: float = 1e-3, shock: float = 1.0):
    """Disturbances as results.json has them, and the acceptance table by its keys."""
    data = analyse(loads(TEXT.format(force=force, kick=kick, shock=shock)), ("json",)).to_dict()
    return data["disturbances"], {line["key"]: line for line in data["requirements"]["criteria"]}


@pytest.mark.slow
def test_the_least_shock_is_that_of_the_motion_in_metres_per_second() -> None:
    """The unit of velocity is F/(2 M f)."""
    found, lines = judged(3.6)
    shock, unit = found["shock"], 3.6 / (2 * 0.1245 * 2)
    assert shock["least_jump_m_s"] == pytest.approx(0.1693971999264 * unit, rel=1e-9)
    assert (shock["after"], shock["after_s"], shock["sign"]) == ("bottom", 0.0, 1)
    assert shock["leads_to"] == "B~ every 3 forcing periods"
    assert shock.get("proved_m_s") is shock["reason"] is None
    assert lines["survives_shock_m_s"]["passed"]
    assert lines["survives_shock_m_s"]["value"] == shock["least_jump_m_s"]
    assert not judged(3.6, kick=2e-3, shock=1.23)[1]["survives_shock_m_s"]["passed"]
    json.dumps(found, allow_nan=False)


def test_where_nothing_leads_out_the_largest_that_was_tried_counts() -> None:
    """What is required is looked for further out than the largest impact velocity."""
    solution = solved("inclined", device__length_m=0.6934)
    usual, further = (withstood_by(solution, True, least_m_s=least) for least in (None, 20.0))
    assert usual.jump_m_s is further.jump_m_s is None
    fastest = max(np.abs(usual.shock.motion.velocity)) * usual.velocity_unit
    assert usual.searched_to_m_s == pytest.approx(fastest)
    assert further.searched_to_m_s >= 20.0
    # The unit of velocity is F/(2 M f).
    assert replace(usual, shock=replace(usual.shock, jump=0.17)).jump_m_s == pytest.approx(0.17 * 3 / (2 * 0.1245 * 2))


@pytest.mark.slow
def test_jitter_is_told_per_membrane_and_grows_with_the_kicks() -> None:
    found, lines = judged(3.6)
    jitter = found["jitter"]
    assert jitter["valid"]
    assert jitter["reason"] is None
    assert jitter["phase_deg"] == max(jitter["phase_bottom_deg"], jitter["phase_top_deg"])
    assert jitter["velocity_m_s"] == max(jitter["velocity_bottom_m_s"], jitter["velocity_top_m_s"])
    assert judged(3.6, kick=2e-3, shock=1.23)[0]["jitter"]["phase_deg"] == pytest.approx(
        2 * jitter["phase_deg"], rel=1e-9
    )
    assert lines["phase_jitter_at_most_deg"]["value"] == jitter["phase_deg"]
    device = of(solved("inclined", device__length_m=0.75, excitation__amplitude_n=3.6).device)
    bare = jitter_of(device.groups, device.stable[0], 1e-3 / device.unit)
    assert jitter["phase_bottom_deg"] == pytest.approx(bare.phase_rad[0] * 180 / pi)
    assert jitter["velocity_top_m_s"] == pytest.approx(bare.velocity[1] * 3.6 / (2 * 0.1245 * 2))


def test_scatter_of_the_restitution_adds_to_the_kicks() -> None:
    """Either is enough for a required spread of phases, and each adds its share to the variances, also of voltages."""
    loads(TEXT.format(force=3.6, kick=1, shock=1).replace("jitter_m_s: 1", "jitter_restitution: 0.003"))
    solution = solved("inclined", device__length_m=0.75, excitation__amplitude_n=3.6)
    known = switched_on_data(SwitchedOn(None))
    kicks, scatter, both = (
        plain(disturbances_with_outcomes(known, Outcomes(withstood=withstood_by(solution, False, *given))).jitter)
        for given in ((1e-3, 0.0), (0.0, 3e-3), (1e-3, 3e-3))
    )
    for key in ("phase_bottom_deg", "velocity_top_m_s", "u_bottom_v", "u_top_v"):
        assert both[key] ** 2 == pytest.approx(kicks[key] ** 2 + scatter[key] ** 2, rel=1e-9)
    assert scatter["valid_up_to_m_s"] is kicks["valid_up_to_restitution"] is None
    assert scatter["valid_up_to_restitution"] == pytest.approx(0.01248, rel=0.01)
    assert both["valid_up_to_m_s"] / 1e-3 == pytest.approx(both["valid_up_to_restitution"] / 3e-3, rel=1e-9)
    assert abs(scatter["u_bottom_mean_v"] / kicks["u_bottom_mean_v"] - 1) < 1e-3
    assert scatter["u_bottom_mean_v"] < kicks["u_bottom_mean_v"]


@pytest.mark.slow
def test_near_a_critical_point_nothing_is_claimed() -> None:
    """At 5.348 N, B1 being at 5.34924 N."""
    found, lines = judged(5.348, kick=0.05)
    assert found["shock"]["least_jump_m_s"] is None
    assert "only 0.045 % in a period" in found["shock"]["reason"]
    assert (found["jitter"]["valid"], found["jitter"]["phase_deg"]) == (False, None)
    assert found["jitter"]["reason"] == "the kicks are too large for linear theory"
    assert 0 < found["jitter"]["valid_up_to_m_s"] < 0.05
    for key in ("survives_shock_m_s", "phase_jitter_at_most_deg"):
        assert not lines[key]["passed"]
        assert lines[key]["why"].startswith("not decided: ")


def test_where_no_motion_is_stable_requirements_are_not_met() -> None:
    found, lines = judged(6.5)
    assert found["shock"] is found["jitter"] is None
    assert lines["survives_shock_m_s"]["why"] == "there is no stable 1:1 motion at the design point"


@pytest.mark.slow
def test_without_numba_a_required_shock_is_refused_before_work_begins(monkeypatch, tmp_path, capsys) -> None:
    monkeypatch.setattr(import_module("vireport.study.plan"), "find_spec", lambda name: None)
    text = TEXT.format(force=3.6, kick=1e-3, shock=1)
    with pytest.raises(UsageError, match=r"survives_shock_m_s cannot be judged: the package numba is missing: pip"):
        refuse_undecidable(loads(text).scenario)
    (tmp_path / "a.yaml").write_text(text)
    assert main(["run", str(tmp_path / "a.yaml"), "--json"]) == 2
    assert "pip install" in capsys.readouterr().err
    study = analyse(loads(text.replace("survives_shock_m_s: 1, ", "")), ("json",))
    assert study.to_dict()["disturbances"]["shock"] is None
    assert study.outcomes.withstood.phase_deg is not None


def test_a_ball_that_does_not_bounce_has_no_least_shock() -> None:
    found = withstood_by(solved("horizontal", device__restitution=0.0, device__length_m=0.5), True)
    assert found.shock is None
    assert "need a restitution" in found.shock_unknown


@pytest.mark.slow
def test_of_two_motions_the_least_shock_counts_and_all_jumps_tried() -> None:
    """The mirror images of a horizontal capsule are alike."""
    found = withstood_by(solved("horizontal", device__length_m=0.36), True, 1e-3)
    one = least_shock_of_the_first(0.36)
    assert found.shock.jump == pytest.approx(one.jump, rel=1e-6)
    assert found.shock.tried > one.tried
    assert found.spread is not None


def least_shock_of_the_first(length: float):
    """Of the first of the stable motions alone, beside the others."""
    device = of(solved("horizontal", device__length_m=length).device)
    assert len(device.stable) == 2
    return least_shock(device.groups, device.stable[0], MotionsByStability(device.stable, device.unstable))


@pytest.mark.parametrize("key", ["survives_shock_m_s", "phase_jitter_at_most_deg", None])
def test_a_design_that_is_only_judged_has_the_steps_that_its_requirements_need(key: str | None) -> None:
    requirements = "recovers_within_periods: 1e6" + (f", {key}: 1" if key else "")
    text = TEXT.partition("requirements")[0].format(force=5, kick=1e-3)
    scenario = loads(f"{text}requirements: {{{requirements}}}\n").scenario
    steps = {"shock": SHOCK, "jitter": JITTER}
    needed = {"survives_shock_m_s": {"shock"}, "phase_jitter_at_most_deg": {"jitter"}}.get(key or "", set())
    assert {name for name, step in steps.items() if plan(scenario, ()).runs(step)} == needed
    assert {name for name, step in steps.items() if plan(scenario, ("json",)).runs(step)} == set(steps)
