"""Valid scenarios of every decade: an answer without NaN that holds its invariants, or a refusal that says why.

`EXAMPLES=20000 pytest tests/test_any_scenario.py` tries as many, at random.
"""

from __future__ import annotations

import json
import os

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vireport import analyse, loads
from vireport.analysis.motions import Motions
from vireport.analysis.orbits import orbits
from vireport.analysis.stability import trace_and_determinant
from vireport.errors import NumericalError
from vireport.scenario.parameters import Parameter
from vireport.study.provenance import provenance_of
from vireport.study.results import results_json

EXAMPLES = int(os.environ.get("EXAMPLES", "0"))

restitutions = st.sampled_from([0.0, 1e-12, 1e-3, 0.5, 0.999, 1 - 1e-6]) | st.floats(0, 1 - 1e-6)
inclinations = st.sampled_from([0.0, 1e-9, 0.01, 45.0, 89.999999, 90.0]) | st.floats(0, 90)


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda power: float(10**power))


@st.composite
def devices(draw) -> dict[str, float]:
    """A device of any size; half of them with dimensionless groups for which there is something to find."""
    capsule, frequency, beta = draw(decades(-14, 14)), draw(decades(-14, 14)), draw(inclinations)
    if draw(st.booleans()):
        force, length = draw(decades(-14, 14)), draw(decades(-14, 14))
    else:
        gbar, d = draw(decades(-6, 1)), draw(decades(-3, 1))
        frequency = draw(decades(-3, 3))
        capsule = draw(decades(-6, 6))
        force = float(np.clip(capsule * 9.8 * np.sin(np.radians(max(beta, 1e-3))) / gbar, 1e-14, 1e14))
        length = float(np.clip(d * force / (4 * capsule * frequency**2), 1e-14, 1e14))
    return {"capsule": capsule, "force": force, "frequency_hz": frequency, "inclination_deg": beta, "length_m": length}


@st.composite
def scenarios(draw) -> dict:
    device = draw(devices())
    values = {
        "length_m": device["length_m"],
        "amplitude_n": device["force"],
        "frequency_hz": device["frequency_hz"],
        "inclination_deg": device["inclination_deg"],
    }
    tree = {
        "schema_version": 1,
        "period_ratio": draw(st.sampled_from([1, 1, 1, 2, 3, 7])),
        "gravity_m_s2": 9.8,
        "inclination_deg": values["inclination_deg"],
        "device": {
            "capsule_mass_kg": device["capsule"],
            "restitution": draw(restitutions),
            "length_m": values["length_m"],
        },
        "excitation": {"amplitude_n": values["amplitude_n"], "frequency_hz": values["frequency_hz"]},
    }
    if draw(st.booleans()):
        tree["device"]["ball_mass_kg"] = max(device["capsule"] * draw(decades(-6, -0.1)), 1e-15)
        if draw(st.booleans()):
            active = draw(decades(-6, 3))
            tree["device"]["membrane"] = {
                "stiffness": draw(decades(-3, 12)),
                "exponent": draw(st.floats(0.1, 8)),
                "active_radius_m": active,
                "ball_radius_m": active * draw(st.floats(0.001, 0.999)),
            }
    if draw(st.integers(0, 3)):
        parameter = draw(st.sampled_from(Parameter))
        width = 1 + draw(decades(-6, 2))
        ends = [float(np.clip(x, 1e-15, 1e15)) for x in (values[parameter] / width, values[parameter] * width)]
        if parameter == "inclination_deg":
            ends = [draw(st.floats(0, 44)), draw(st.floats(45, 90))]
        if draw(st.booleans()):
            ends.reverse()
        tree["sweep"] = {"parameter": parameter, "from": ends[0], "to": ends[1]}
    return tree


@settings(max_examples=EXAMPLES or 200, derandomize=not EXAMPLES)
@given(scenarios())
def test_any_scenario_is_answered_or_refused(tree: dict) -> None:
    loaded = loads(json.dumps(tree))
    try:
        study = analyse(loaded, ("json",))
    except NumericalError:
        return
    json.loads(results_json(study, provenance_of(loaded, "")))  # has no NaN and no infinity, or it raises
    n, bounds = loaded.scenario.period_ratio, study.solution.bounds
    for branch, bound in zip(study.solution.branches, bounds.branches, strict=True):
        check(branch.motions, bound, n)
    if study.solution.design is not None:
        check(study.solution.design.motions, bounds.design, n)
    designs = () if study.solution.design is None else (study.solution.design,)
    for found in (one.voltages for one in (*study.solution.branches, *designs)):
        if found is not None:
            for name in ("bottom_v", "top_v", "average_v", "deflection_m"):
                assert np.all(np.isfinite(getattr(found, name)) & (getattr(found, name) >= 0)), name


def check(m: Motions, bound: dict[str, np.ndarray], n: int) -> None:
    for name in Motions.__slots__:
        assert np.all(np.isfinite(getattr(m, name))), name
    assert all(np.all(b >= 0) for b in bound.values())
    # What is no motion anyway may end a hair beyond where an impact loses its velocity.
    slack = np.where(m.admissible, 1e-14, 1e-9)
    assert np.all(m.velocity_bottom >= -bound["velocity_bottom"] - slack)
    assert np.all(m.velocity_top <= bound["velocity_top"] + slack)
    assert np.all((m.d > 0) & (m.q >= 0) & (m.q <= 1) & (m.wall_gap <= m.d))
    assert not np.any(m.admissible & (m.wall_gap <= 0))
    r = m.restitution
    assert np.all(np.abs(m.trace[m.stable]) <= 1 + r**4 + bound["trace"][m.stable])
    # det DP = r^4, and the impacts take what gravity gives: (3.8).
    fast = np.minimum(m.velocity_bottom, -m.velocity_top) > 1e-2
    determinant = trace_and_determinant(orbits(m.u[fast], m.phi_bottom[fast], r, n), r)[1]
    assert np.all(np.abs(determinant - r**4) <= 1e-6 * np.maximum(m.trace[fast] ** 2, 1.0))
    rise = 2 * n / (1 + r)
    room = bound["velocity_bottom"] + bound["velocity_top"] + rise * (bound["gbar"] + 1e-15 * m.gbar) + 1e-15
    assert np.all(np.abs(m.velocity_bottom + m.velocity_top - rise * m.gbar) <= room)
