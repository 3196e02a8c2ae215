"""The step of compliant membranes in the plan of a run, where it runs and where it is left out."""

from __future__ import annotations

from vireport import loads
from vireport.study.plan import ALL_FORMATS, plan

SCENARIO = """\
schema_version: 1
device: {capsule_mass_kg: 0.1, ball_mass_kg: 0.004, restitution: 0.5, length_m: 0.7}
excitation: {amplitude_n: 3, frequency_hz: 2}
inclination_deg: 45
accuracy: {}
"""


def test_the_step_of_an_addition_is_known_by_its_name_running_or_left_out() -> None:
    with_ball = plan(loads(SCENARIO).scenario, ALL_FORMATS)
    without = plan(loads(SCENARIO.replace("ball_mass_kg: 0.004, ", "")).scenario, ALL_FORMATS)
    running = with_ball.running("compliant")
    assert running is not None
    assert running.what == "the motion with compliant membranes, and solvers on stiff ones"
    assert (with_ball.reason("compliant"), without.running("compliant")) == (None, None)
    assert without.reason("compliant") == "device.ball_mass_kg is not given"
