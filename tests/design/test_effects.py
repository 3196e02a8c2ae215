"""How far the nearest end of stable motion moves by what the model leaves out, against devices that have it."""

from __future__ import annotations

import json
from math import cos, pi, sin

import numpy as np
import pytest
from exact_device import ExactDevice
from mpmath import mp
from msgspec.structs import replace

from vireport import analyse, load
from vireport.design.effects import Effect, Shift, Unmoved, _ends, _least_margin, _Origin, shifts
from vireport.design.lines import Line, model_on_line, stable_ones
from vireport.design.point import design_point
from vireport.design.speed_law import falling, with_law
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.periodicity import residuals
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Restitutions, SpeedLaw
from vireport.physics.numbers import FLOATS
from vireport.scenario.blocks import CapsuleMotion, LeftOut
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import BOTTOM, Impact

PAPER = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0, ball_mass_kg=0.0041)
FREE = replace(PAPER, capsule=CapsuleMotion.FREE)


LAW = {"effect": "restitution_exponent", "exponent": -0.1}


def of(device: Device, *effects: Effect) -> dict[LeftOut, Shift]:
    found = shifts(device, design_point(device, None), *([effects] if effects else []))
    return {shift.effect.left_out: shift for shift in found.rows}


def origin(device: Device) -> _Origin:
    return _Origin(device, stable_ones(device, design_point(device, None).motions))


def doubling(device: Device) -> float:
    points = solve(Sweep(device, Parameter.FREQUENCY, 1.5, 2.4)).critical_points
    return next(point.sweep_value for point in points if point.event is Event.PERIOD_DOUBLING)


def test_the_papers_device_has_the_shifts_that_were_derived_apart_from_this() -> None:
    """By another method, in 45 digits: B1 in frequency, and what is left of the 4.7 % to it."""
    found = of(PAPER)
    expected = {
        LeftOut.RESTITUTION_BOTTOM: (3.9, 1.0),
        LeftOut.RESTITUTION_TOP: (-3.8, 8.3),
        LeftOut.CAPSULE: (1.55, 3.2),
        LeftOut.SECOND_HARMONIC: (2.6, 2.2),
        LeftOut.FRICTION: (0.7, 4.0),
        LeftOut.RESTITUTION_SPEED: (1.8, 3.0),
    }
    assert list(found) == list(expected)
    for left_out, (moved, left) in expected.items():
        assert 100 * found[left_out].relative == pytest.approx(moved, abs=0.05)
        assert 100 * found[left_out].left == pytest.approx(left, abs=0.05)
        assert found[left_out].event is Event.PERIOD_DOUBLING
        assert found[left_out].stable
    end = shifts(PAPER, design_point(PAPER, None)).end
    assert (end.parameter, 100 * end.relative) == (DesignInput.FREQUENCY, pytest.approx(-4.722, abs=1e-3))


@pytest.mark.slow
def test_the_ends_are_those_of_the_changed_devices() -> None:
    found, before = of(PAPER), doubling(PAPER)
    changed = {
        LeftOut.RESTITUTION_BOTTOM: replace(PAPER, restitution=Restitutions(0.475, 0.5)),
        LeftOut.RESTITUTION_TOP: replace(PAPER, restitution=Restitutions(0.5, 0.475)),
        LeftOut.CAPSULE: FREE,
        LeftOut.FRICTION: replace(PAPER, friction=0.05),
    }
    for left_out, device in changed.items():
        after, shift = doubling(device), found[left_out]
        assert shift.value == pytest.approx(after, rel=1e-14)
        assert shift.moved == pytest.approx(after - before, rel=1e-12)
        assert shift.relative == pytest.approx(after / before - 1, rel=1e-12)
        assert shift.left == pytest.approx(1 - after / 2, rel=1e-12)


def test_a_free_capsule_has_the_way_back() -> None:
    forth, back = of(PAPER)[LeftOut.CAPSULE], of(FREE)[LeftOut.CAPSULE]
    assert (1 + forth.relative) * (1 + back.relative) == pytest.approx(1, rel=1e-12)
    assert back.left == pytest.approx(0.0472, abs=1e-4)
    level = replace(PAPER, inclination_deg=0.0, length_m=0.3)
    assert of(level)[LeftOut.CAPSULE].moved == 0
    assert LeftOut.CAPSULE not in of(replace(PAPER, ball_mass_kg=None))


def test_a_law_of_the_speed_moves_the_end_as_the_raw_maps_say() -> None:
    """For both membranes one law, which is the given restitution at the mean impact speed of the design's motion."""
    design = design_point(PAPER, None)
    row = np.flatnonzero(design.motions.stable_mask)[0]
    unit = 3.0 / (2 * 0.1245 * 2.0)
    mean = unit * (design.motions.velocity_bottom[row] - design.motions.velocity_top[row]) / 2
    end = shifts(PAPER, design).end.point
    near = *end.motion.velocity, *end.motion.time
    for exponent, stated in ((-0.02, None), (-0.1, None), (-0.1, 5.3), (-0.2, None)):
        (shift,) = shifts(PAPER, design, (Effect(LeftOut.RESTITUTION_SPEED, exponent, stated),)).rows
        law = SpeedLaw(0.5, 0.5, exponent, stated or mean)
        with mp.workdps(40):
            exact = ExactDevice(replace(PAPER, restitution=law, frequency_hz=shift.value))
            near = tuple(mp.findroot(exact.missed, near))
            trace, determinant = exact.map_of(*near)
        assert abs(trace + 1 + determinant) < 1e-8
        assert shift.event is Event.PERIOD_DOUBLING


@pytest.mark.parametrize("length", [0.64, pytest.param(0.632, marks=pytest.mark.slow)])
def test_an_end_that_passes_the_design_point_leaves_less_than_nothing(length: float) -> None:
    """The motion is followed from where it is stable still, back to the end: the same as a sweep has there."""
    device = replace(PAPER, length_m=length)
    shift = of(device)[LeftOut.RESTITUTION_BOTTOM]
    after = doubling(replace(device, restitution=Restitutions(0.475, 0.5)))
    assert shift.value == pytest.approx(after, rel=1e-13)
    assert shift.left == pytest.approx(1 - after / 2, rel=1e-11)
    assert shift.left < 0
    assert not shift.stable
    found = shifts(device, design_point(device, None))
    assert found.worst == shift


@pytest.mark.slow
def test_the_motion_that_ends_is_followed_and_not_another_one() -> None:
    """Of two stable motions one ends at a fold in the restitution that is off, and is gone; the other goes on."""
    device = replace(PAPER, inclination_deg=5.0, length_m=0.33)
    design = design_point(device, None)
    end = shifts(device, design).end
    assert design.motions.stable_mask.sum() == 2
    assert (end.parameter, end.event) == (DesignInput.RESTITUTION_BOTTOM, Event.FOLD)
    shift = of(device)[LeftOut.RESTITUTION_BOTTOM]
    assert (shift.value, shift.moved) == (pytest.approx(end.sweep_value, rel=1e-13), pytest.approx(0, abs=1e-13))
    assert shift.left == pytest.approx(1 - end.sweep_value / 0.475, rel=1e-11)


def test_so_large_an_effect_that_nothing_is_stable() -> None:
    effect = Effect(LeftOut.RESTITUTION_BOTTOM, -0.8)
    shift = of(PAPER, effect)[effect.left_out]
    assert (shift.value, shift.left, shift.stable, shift.absence) == (None, None, False, Unmoved.NOT_STABLE)
    # Where there is no restitution, none is less.
    assert effect.left_out not in of(replace(PAPER, restitution=Restitutions(0.0, 0.6)), effect)


def test_motions_of_a_law_fulfil_its_equations() -> None:
    for device in (FREE, replace(PAPER, restitution=Restitutions(0.495, 0.5))):
        motions = design_point(device, None).motions
        law = falling(device, motions, -0.1)
        ((motion, u),) = with_law(law, stable_ones(device, motions))
        line = model_on_line(Line.LENGTHS, law, FLOATS)
        assert np.abs(residuals(motion.word, [*motion.velocity, *motion.time, 0.0], line)).max() < 1e-10
        assert abs(u - motions.u[motions.stable_mask][0]) < 0.05


def test_an_end_at_a_large_restitution_is_where_the_simulation_has_it() -> None:
    unlike = replace(PAPER, restitution=Restitutions(0.679, 0.69), length_m=1.069, amplitude_n=3.121)
    device, effect = replace(unlike, inclination_deg=8.6), Effect(LeftOut.RESTITUTION_SPEED, -0.1)
    design = design_point(device, None)
    found = shifts(device, design, (effect,))
    (shift,) = found.rows
    assert (found.end.parameter, shift.event) == (DesignInput.RESTITUTION_TOP, Event.PERIOD_DOUBLING)
    assert shift.value > 0.95
    law, end = falling(device, design.motions, -0.1), found.end.point.closed
    impacts = []
    for step in (-0.002, 0.002):
        groups = law.with_values({DesignInput.RESTITUTION_TOP: shift.value + step}).groups(Parameter.LENGTH, 1.069)
        start = Impact(BOTTOM, end.velocity_bottom, end.phi_bottom)
        impacts.append(len(find_attractor(groups.as_floats(), start, compiled=False).cycle.wall))
    assert impacts == [2, 4]


def test_an_end_that_is_not_followed_is_not_called_none() -> None:
    """Both restitutions come to the largest one, at which the law bends, and motions are followed no farther."""
    law = falling(PAPER, design_point(PAPER, None).motions, -0.1)
    assert [end.event for end in _ends(law, origin(PAPER), DesignInput.RESTITUTION, 1.0)] == [Event.LOST]
    shift = Shift(Effect(LeftOut.RESTITUTION_SPEED, -0.1), absence=Unmoved.NOT_FOLLOWED)
    assert shift.stable
    assert shift.room > 1


def test_a_law_needs_a_restitution_and_leaves_a_level_device_symmetric() -> None:
    effect = Effect(LeftOut.RESTITUTION_SPEED, -0.1)
    motions = design_point(PAPER, None).motions
    for r in (Restitutions(0.0, 0.6), Restitutions(0.5, 0.99)):
        assert falling(replace(PAPER, restitution=r), motions, -0.1) is None
    level = replace(PAPER, inclination_deg=0.0, length_m=0.3)
    shift, end = of(level, effect)[effect.left_out], shifts(level, design_point(level, None)).end
    assert shift.event is end.event
    # Both ends are struck alike: the restitution is as given where the motion is, and only its slope acts.
    assert 0 < abs(shift.relative) < 0.05


def smallest(device: Device) -> float:
    return min(abs(end.relative) for end in design_point(device, None).limits() if end.relative is not None)


def test_the_least_margin_in_any_input_is_that_of_the_changed_device() -> None:
    device = replace(PAPER, length_m=0.71)
    asked = (
        Effect(LeftOut.RESTITUTION_BOTTOM, -0.02),
        Effect(LeftOut.RESTITUTION_TOP, 0.03),
        Effect(LeftOut.CAPSULE),
        Effect(LeftOut.RESTITUTION_BOTTOM, -0.8),
    )
    changed = (
        replace(device, restitution=Restitutions(0.49, 0.5)),
        replace(device, restitution=Restitutions(0.5, 0.515)),
        replace(device, capsule=CapsuleMotion.FREE),
    )
    design = design_point(device, None)
    found = [shift.least for shift in shifts(device, design, asked, in_any_input=True).rows]
    assert found == [*(pytest.approx(smallest(other), rel=1e-9) for other in changed), 0.0]
    assert {shift.least for shift in shifts(device, design, asked).rows} == {None}


@pytest.mark.slow
def test_a_harmonic_is_taken_at_phases_of_which_none_is_much_worse() -> None:
    def least(phase: float) -> float:
        """At a phase of its own: for each input the nearest end that a ray of another order of steps finds."""
        sized = Harmonic(2, 0.02 * cos(phase), -0.02 * sin(phase))
        return _least_margin(replace(PAPER, harmonics=(sized,)), origin(PAPER))

    asked = (Effect(LeftOut.SECOND_HARMONIC, 0.02),)
    (shift,) = shifts(PAPER, design_point(PAPER, None), asked, in_any_input=True).rows
    assert shift.least == pytest.approx(min(map(least, np.linspace(0, 2 * pi, 40))), rel=5e-3)
    assert shift.least == pytest.approx(0.0224, abs=1e-4)


@pytest.mark.slow
def test_without_gravity_the_worse_of_two_phases_counts() -> None:
    """The opposite ones are mirror images of them."""
    level = replace(PAPER, inclination_deg=0.0, length_m=0.3)
    turned = (Harmonic(2, 0.02, 0.0), Harmonic(2, 0.0, 0.02), Harmonic(2, -0.02, 0.0), Harmonic(2, 0.0, -0.02))
    least = [_least_margin(replace(level, harmonics=(own,)), origin(level)) for own in turned]
    assert least[:2] == pytest.approx(least[2:], rel=1e-9)
    assert of(level)[LeftOut.SECOND_HARMONIC].left == pytest.approx(min(least), rel=1e-9)
    assert min(least) < 0.9 * max(least)
    asked = (Effect(LeftOut.SECOND_HARMONIC, 0.02),)
    (shift,) = shifts(level, design_point(level, None), asked, in_any_input=True).rows
    assert shift.least < 0.9 * min(least)  # at the phase that is worst for another end


@pytest.mark.slow
def test_a_margin_can_be_required_to_hold_with_them(example) -> None:
    mass = {"device.ball_mass_kg": 0.0041}
    for changes, least, passed, worst in (
        ({}, 1.0, True, "restitution bottom −5 %"),
        ({}, 1.01, False, "restitution bottom −5 %"),
        ({"effects": [{"effect": "capsule"}]}, 3.2, True, "capsule"),
        ({"effects": [{"effect": "restitution_bottom", "percent": -10}]}, 0.1, False, "restitution bottom −10 %"),
        ({"effects": [{**LAW, "speed_m_s": 5.0}]}, 2.99, False, "restitution exponent −0.1"),
    ):
        required = {"requirements": {"margin_with_effects_percent": least}}
        (line,) = analyse(load(example("inclined"), mass | changes | required), ()).criteria
        assert (line.passed, str(line.outcome.why)) == (passed, f"with {worst}")


def test_a_run_has_them_and_says_why_not(example) -> None:
    data = analyse(load(example("inclined")), ("json",)).to_dict()["effects"]
    assert json.loads(json.dumps(data)) == data
    assert (data["parameter"], data["label"], data["reason"]) == ("frequency_hz", "B1", None)
    rows = {row["effect"]: row for row in data["rows"]}
    assert list(rows) == [
        "restitution_bottom",
        "restitution_top",
        "capsule",
        "second_harmonic",
        "friction",
        "restitution_exponent",
        "membrane_stiffness",
    ]
    own = analyse(load(example("inclined")), ("json",)).own_stiffness
    end = next(end for end in own.ends if end.parameter == "frequency_hz")
    assert rows["membrane_stiffness"]["sweep_value"] == end.compliant
    assert rows["membrane_stiffness"]["margin_left"] == pytest.approx(end.compliant_margin, rel=1e-12)
    short = load(example("inclined"), {"device.length_m": 0.6, "sweep.to": 0.62})
    none = analyse(short, ("json",)).to_dict()["effects"]
    assert (none["rows"], none["reason"]) == ([], "no 1:1 motion is stable at the design point")
    assert analyse(load(example("inclined")), ()).effects is None


def test_friction_of_three_sizes_moves_the_end_as_derived_apart_from_this() -> None:
    effects = tuple(Effect(LeftOut.FRICTION, size) for size in (0.02, 0.05, 0.1))
    rows = shifts(PAPER, design_point(PAPER, None), effects).rows
    for row, moved, left in zip(rows, (0.3, 0.7, 1.4), (4.5, 4.0, 3.4), strict=True):
        assert 100 * row.relative == pytest.approx(moved, abs=0.05)
        assert 100 * row.left == pytest.approx(left, abs=0.06)
        assert row.event is Event.PERIOD_DOUBLING
    rubbed = replace(PAPER, friction=0.05)
    more = shifts(rubbed, design_point(rubbed, None), effects[1:2]).rows[0]
    assert more.value == pytest.approx(rows[2].value, rel=1e-9)  # 0.05 and 0.05 more are 0.1


def test_where_friction_stops_the_ball_on_its_way_the_end_is_not_known() -> None:
    """Level, the ball turns long before it grazes: with the least friction it stops there, and may go on."""
    level = replace(PAPER, inclination_deg=0.0, length_m=0.5554)
    found = shifts(level, design_point(level, None), (Effect(LeftOut.FRICTION, 0.02), Effect(LeftOut.CAPSULE)), True)
    rubbed, free = found.rows
    assert not rubbed.computed
    assert rubbed.value is None
    assert rubbed.least == pytest.approx(0.155, abs=1e-3)  # up to where it stops motion is known to be stable
    assert found.worst is free


def test_friction_does_not_apply_where_there_is_none() -> None:
    assert LeftOut.FRICTION not in of(replace(PAPER, inclination_deg=90.0, amplitude_n=6.0))
    assert LeftOut.FRICTION not in of(replace(PAPER, restitution=0.0))
