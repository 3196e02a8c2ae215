"""How far the nearest end of stable motion moves by what the model leaves out, against devices that have it."""

from __future__ import annotations

import json
from math import cos, pi, sin

import numpy as np
import pytest
from msgspec.structs import replace

from vireport import analyse, load
from vireport.design import Effect, Shift, Unmoved, design_point, shifts
from vireport.design.effects import _least_margin, _Origin
from vireport.design.lines import stable_ones
from vireport.motions import Event, Sweep, solve
from vireport.physics import Device, Harmonic, Restitutions
from vireport.scenario import CapsuleMotion, DesignInput, LeftOut, Parameter

PAPER = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0, ball_mass_kg=0.0041)
FREE = replace(PAPER, capsule=CapsuleMotion.FREE)


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
    assert design.motions.stable.sum() == 2
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


def test_without_gravity_the_worse_of_two_phases_counts() -> None:
    """The opposite ones are mirror images of them."""
    level = replace(PAPER, inclination_deg=0.0, length_m=0.3)
    turned = (Harmonic(2, 0.02, 0.0), Harmonic(2, 0.0, 0.02), Harmonic(2, -0.02, 0.0), Harmonic(2, 0.0, -0.02))
    least = [_least_margin(replace(level, harmonics=(own,)), origin(level)) for own in turned]
    assert least[:2] == pytest.approx(least[2:], rel=1e-9)
    assert of(level)[LeftOut.SECOND_HARMONIC].left == pytest.approx(min(least), rel=1e-9)
    assert min(least) < 0.9 * max(least)


def test_a_margin_can_be_required_to_hold_with_them(example) -> None:
    mass = {"device.ball_mass_kg": 0.0041}
    for changes, least, passed, worst in (
        ({}, 1.0, True, "restitution bottom -5 %"),
        ({}, 1.01, False, "restitution bottom -5 %"),
        ({"effects": [{"effect": "capsule"}]}, 3.2, True, "capsule"),
        ({"effects": [{"effect": "restitution_bottom", "percent": -10}]}, 0.1, False, "restitution bottom -10 %"),
    ):
        required = {"requirements": {"margin_with_effects_percent": least}}
        (line,) = analyse(load(example("inclined"), mass | changes | required), ()).criteria
        assert (line.passed, line.outcome.why) == (passed, f"with {worst}")


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
    assert not rubbed.known
    assert rubbed.value is None
    assert rubbed.least == pytest.approx(0.155, abs=1e-3)  # up to where it stops motion is known to be stable
    assert found.worst is free


def test_friction_does_not_apply_where_there_is_none() -> None:
    assert LeftOut.FRICTION not in of(replace(PAPER, inclination_deg=90.0, amplitude_n=6.0))
    assert LeftOut.FRICTION not in of(replace(PAPER, restitution=0.0))
