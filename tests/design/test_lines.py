"""The ends of motions along lines through random devices: they do not depend on the steps in which they are sought."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from vireport.design.lines import LINES, Ending, LineCurve, endings, stable_ones
from vireport.design.point import motions_at
from vireport.motions.events import Event
from vireport.motions.paths import follow
from vireport.physics.device import Device
from vireport.physics.groups import Restitutions
from vireport.scenario.parameters import Parameter

SEED = 11
FINER = 4


def ends(device: Device) -> list[Ending]:
    motions, _, _ = motions_at(device, Parameter.LENGTH)
    return list(endings(device, stable_ones(device, motions), LINES, (-1.0, 1.0)))


def random_devices(count: int) -> Iterator[Device]:
    """Level ones first, and of two restitutions every third; of stable motion all."""
    rng, seen = np.random.default_rng(SEED), 0
    while seen < count:
        bottom, top, angle = rng.uniform(0.1, 0.8), rng.uniform(0.1, 0.8), rng.uniform(0, 80)
        restitution = Restitutions(bottom, top) if seen % 3 == 2 else bottom
        length, frequency = rng.uniform(0.1, 0.8), rng.uniform(1.6, 2.6)
        device = Device(0.1245, restitution, 9.8, length, 3.0, frequency, angle if seen else 0.0)
        if motions_at(device, Parameter.LENGTH)[0].stable_mask.any():
            seen += 1
            yield device


def held_ends(monkeypatch: pytest.MonkeyPatch, count: int) -> int:
    seen = 0
    for device in random_devices(count):
        told = ends(device)
        with monkeypatch.context() as steps:
            for name in ("first", "longest", "sharpest", "settled"):
                steps.setattr(LineCurve, name, getattr(LineCurve, name) / FINER)
            finer = ends(device)
        assert [end.event for end in told] == [end.event for end in finer], device
        for end, other in zip(told, finer, strict=True):
            assert end.line is other.line
            assert end.taken_over == other.taken_over
            assert end.x == pytest.approx(other.x, abs=1e-7), (device, end)
        seen += len(told)
    return seen


def test_ends_do_not_depend_on_the_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    assert held_ends(monkeypatch, 2) > 20


@pytest.mark.slow
def test_ends_of_more_devices_do_not_depend_on_the_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    assert held_ends(monkeypatch, 9) > 100


TURNING = (
    Device(0.1245, 0.3657640880740683, 9.81, 0.8354480339969297, 4.852949262040307, 1.5159982739012532, 0.0),
    Device(0.1245, 0.6957795029060694, 9.81, 0.2571634302896306, 7.715089560454782, 4.0017407668972735, 0.0),
    Device(0.1245, 0.8502570689635839, 9.81, 0.03760646546741743, 5.268833479293994, 8.208726049392073, 0.0),
)


@pytest.mark.parametrize("device", TURNING)
def test_asymmetric_motions_end_where_they_turn_back_as_their_own_image(
    monkeypatch: pytest.MonkeyPatch, device: Device
) -> None:
    """In these steps the search for the pitchfork stops farther from the symmetric motion than elsewhere."""
    for name, step in {"first": 0.03, "longest": 0.2, "sharpest": 0.4}.items():
        monkeypatch.setattr(LineCurve, name, step)
    motions, _, _ = motions_at(device, Parameter.LENGTH)
    for sign in (-1.0, 1.0):
        own = list(endings(device, stable_ones(device, motions), LINES, (sign,)))
        assert own
        assert all(end.x[-1] * sign > 0 for end in own)


def test_a_way_that_begins_where_families_meet_ends_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the least force of a level capsule no motion leaves by gravity: rounding alone takes steps of some 1e-7."""
    points = []

    def counted(*asked):
        trail = follow(*asked)
        points.append((len(trail.points), trail.events[-1][1]))
        return trail

    monkeypatch.setattr("vireport.design.lines.follow", counted)
    device = Device(0.1245, 0.5870953356082458, 9.8, 0.6574888584808883, 1.056082590675376, 2.0, 0.0)
    assert ends(device)
    assert Event.LOST in [event for _, event in points]
    assert max(count for count, _ in points) < 100
