"""Mirror images of 1:1 motions of a horizontal capsule: each is a motion, and nothing there is rounding."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import first
from msgspec.structs import replace

from vireport.motions.branches import Branch
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.level_curve import plane_of
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import by_wall
from vireport.physics.motion import Symmetry
from vireport.scenario.parameters import Parameter

HORIZONTAL = Device(
    capsule_mass_kg=0.1245, restitution=0.5, gravity_m_s2=9.8, length_m=0.5554, amplitude_n=3.0, frequency_hz=2.0,
    inclination_deg=0.0,
)  # fmt: skip
ODD = (Harmonic.of(3, 10.0, 30.0),)
KINDS = {
    "sine": Sweep(HORIZONTAL, Parameter.LENGTH, 0.2, 0.9),
    "odd harmonic": Sweep(replace(HORIZONTAL, harmonics=ODD), Parameter.LENGTH, 0.2, 0.9),
    "friction": Sweep(replace(HORIZONTAL, friction=0.02), Parameter.AMPLITUDE, 1.5, 9.0),
    "three periods": Sweep(replace(HORIZONTAL, period_ratio=3), Parameter.FREQUENCY, 2.0, 9.0),
    "restitution": Sweep(replace(HORIZONTAL, length_m=0.35), Parameter.RESTITUTION, 0.2, 0.8),
}

TOUCHING = [(0.35, 20.0, -40.0), (0.65, 28.0, 35.0), (0.65, 20.0, 120.0), (0.35, 12.0, 35.0), (0.35, 12.0, 120.0)]
"""Restitution, and percent and phase of the third harmonic, with which a sample is at the end to rounding."""


def with_images(sweep: Sweep) -> list[tuple[Branch, Branch]]:
    branches = solve(sweep).branches
    return [(branches[image.mirror_of - 1], image) for image in branches if image.mirror_of is not None]


@pytest.mark.parametrize("kind", KINDS)
def test_the_image_of_a_branch_is_a_branch_of_motions(kind: str) -> None:
    sweep = KINDS[kind]
    pairs = with_images(sweep)
    assert pairs
    for branch, image in pairs:
        assert branch.symmetry is image.symmetry is Symmetry.ASYMMETRIC
        m = image.motions
        orbit = plane_of(sweep).orbits(m.u, m.phi_bottom)
        np.testing.assert_allclose(m.velocity_bottom, orbit.velocity_bottom, rtol=0, atol=1e-11)
        np.testing.assert_allclose(m.velocity_top, orbit.velocity_top, rtol=0, atol=1e-11)
        np.testing.assert_allclose(np.exp(1j * m.phi_top), orbit.cos_top + 1j * orbit.sin_top, rtol=0, atol=1e-11)
        np.testing.assert_allclose(sweep.coordinate(m), sweep.coordinate(orbit), rtol=1e-11)
        np.testing.assert_allclose(m.q + branch.motions.q, 1.0, rtol=0, atol=1e-15)
        assert by_wall(m.restitution)[0] is by_wall(m.restitution)[1]
        assert [mark.event for mark in image.family.marks] == [mark.event for mark in branch.family.marks]


@pytest.mark.parametrize("kind", KINDS)
def test_the_image_of_a_critical_point_is_within_its_bounds(kind: str) -> None:
    sweep = KINDS[kind]
    points = [point for point in solve(sweep).critical_points if point.symmetry is Symmetry.ASYMMETRIC]
    assert points
    for point in points:
        assert point.mirror is not None
        own, image = point.closed, point.mirror.closed
        assert image.u == pytest.approx(-own.u, abs=own.bounds["u"] + image.bounds["u"])
        for name, other in (("phi_bottom", "phi_top"), ("phi_top", "phi_bottom")):
            late = getattr(image, name) - getattr(own, other)
            off = abs(np.angle(-np.exp(1j * late)))
            assert off <= own.bounds[other] + image.bounds[name] + 1e-15
        for name, other in (("velocity_bottom", "velocity_top"), ("velocity_top", "velocity_bottom")):
            bound = own.bounds[other] + image.bounds[name]
            assert getattr(image, name) == pytest.approx(-getattr(own, other), abs=bound)
        assert point.mirror.motion.distance(point.motion, mirror=True) < 1e-14
        assert point.mirror.motion.word.walls[0] == 1
        assert 0 <= point.mirror.motion.time[0] < 2


@pytest.mark.parametrize(
    ("restitution", "percent", "phase"), [(0.9, 1.34, 119.3), (0.7, 3.91, 318.3), (0.97, 15.57, 288.8)]
)
def test_next_to_the_pitchfork_no_fold_is_told_that_is_rounding(
    restitution: float, percent: float, phase: float
) -> None:
    """There tr - 1 - r^4 goes with u^2, below its own rounding where |u| is less than some 1e-7."""
    device = replace(HORIZONTAL, restitution=restitution, harmonics=(Harmonic.of(3, percent, phase),))
    diagram = solve(Sweep(device, Parameter.FREQUENCY, 1.0, 9.0))
    assert any(point.event is Event.PITCHFORK for point in diagram.critical_points)
    folds = [point for point in diagram.critical_points if point.event is Event.FOLD]
    assert not [point for point in folds if 0 < abs(point.closed.u) < 1e-6]


def test_folds_that_are_near_the_pitchfork_are_told() -> None:
    device = replace(HORIZONTAL, restitution=0.6530363217, harmonics=(Harmonic.of(3, 32.0, 128.6858),))
    diagram = solve(Sweep(device, Parameter.LENGTH, 0.05, 1.5))
    met = [(point.event, point.closed.u) for point in diagram.critical_points if point.event.letter == "C"]
    assert [event for event, _ in met] == [Event.FOLD, Event.PITCHFORK, Event.FOLD]
    assert [u for _, u in met] == pytest.approx([0.0438051453, 0.0, 0.1727794454], abs=1e-9)


@pytest.mark.parametrize("beyond", [1e-10, 1e-8, 1e-6, 1e-3])
@pytest.mark.parametrize("harmonics", [(), ODD])
def test_a_sweep_that_ends_next_to_the_pitchfork_has_both_images_from_there(harmonics, beyond: float) -> None:
    device = replace(HORIZONTAL, harmonics=harmonics)
    whole = solve(Sweep(device, Parameter.LENGTH, 0.2, 0.9))
    pitchfork = next(point for point in whole.critical_points if point.event is Event.PITCHFORK)
    # The asymmetric motions are those of shorter capsules.
    sweep = Sweep(device, Parameter.LENGTH, pitchfork.sweep_value * (1 - beyond), 1.2 * pitchfork.sweep_value)
    ((branch, image),) = with_images(sweep)
    assert {mark.event for mark in branch.family.marks} == {Event.PITCHFORK, Event.SWEEP_END}
    assert branch.motions.u[[0, -1]].min() == 0 == image.motions.u[[0, -1]].max()
    assert (branch.motions.u >= 0).all()
    assert (image.motions.u <= 0).all()


@pytest.mark.parametrize(("restitution", "percent", "phase"), first(1, TOUCHING, unpacked=True))
def test_a_motion_at_rest_that_touches_on_its_way_is_told_of_both_images(
    restitution: float, percent: float, phase: float
) -> None:
    """Three periods of the motion of one that loses its velocities: at q = 5/6 all impacts but two are touches."""
    device = replace(HORIZONTAL, restitution=restitution, period_ratio=3, harmonics=(Harmonic.of(3, percent, phase),))
    diagram = solve(Sweep(device, Parameter.LENGTH, 0.13, 0.9))
    at_rest = [point for point in diagram.critical_points if point.rest is not None]
    assert [point.closed.u for point in at_rest] == pytest.approx([0.0, 1 / 3], abs=1e-15)
    assert at_rest[0].sweep_value == pytest.approx(at_rest[1].sweep_value, rel=1e-15)
    images = [branch for branch in diagram.branches if branch.mirror_of in at_rest[1].families]
    marked = [mark.point for branch in images for mark in branch.family.marks if mark.event is Event.ZERO_VELOCITY]
    assert marked == [at_rest[1]]
