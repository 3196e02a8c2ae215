"""The path of ball and capsule over a period, of which the device's figure and the bench draw."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import study

from vireport.design.point import motions_at
from vireport.motions.one_to_one import ball_path
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import Parameter

PAPER = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0)


@pytest.mark.parametrize("name", ["horizontal", "inclined"])
def test_the_ball_flies_from_membrane_to_membrane_and_comes_back(name: str) -> None:
    solution = study(name).solution
    motions, n = solution.design.motions, solution.device.period_ratio
    row = int(np.argmax(motions.stable_mask))
    path = ball_path(solution.device, solution.parameter, motions, row)
    time, distance = path.time, path.distance
    half = len(time) // 2
    assert distance[[0, half - 1, half, -1]] == pytest.approx([0, 1, 1, 0], abs=1e-12)
    assert time[[0, half - 1, half, -1]] == pytest.approx([0, n * motions.q[row], n * motions.q[row], n])
    assert ((distance > -1e-12) & (distance < 1 + 1e-12)).all()
    arriving = -motions.d[row] * np.diff(distance)[[half - 2, -1]] / (2 * np.diff(time)[[half - 2, -1]])
    assert arriving == pytest.approx([motions.velocity_top[row], motions.velocity_bottom[row]], rel=0.05)


@pytest.mark.parametrize(
    "device",
    [
        PAPER,
        Device(*(0.1245, 0.5, 9.8, 0.7, 3.0, 2.0, 45.0), harmonics=(Harmonic.of(2, 2.0, 40.0),)),
        Device(*(0.1245, 0.5, 9.8, 0.75, 3.0, 2.0, 45.0), capsule=CapsuleMotion.FREE, ball_mass_kg=0.012),
    ],
    ids=["sine", "harmonic", "free"],
)
def test_the_capsule_is_moved_by_the_force_and_by_the_ball_where_it_is_free(device: Device) -> None:
    motions, *_ = motions_at(device, Parameter.LENGTH)
    row = int(np.argmax(motions.stable_mask))
    path, mu = ball_path(device, Parameter.LENGTH, motions, row), device.mass_ratio
    gravity = float(device.groups(Parameter.LENGTH, device.length_m).gbar) / (1 + mu)
    half = len(path.time) // 2
    for flight in (slice(0, half), slice(half, None)):
        time, z = 2 * path.time[flight], float(motions.d[row]) * (0.5 - path.distance[flight])
        x, step = path.capsule[flight], time[1] - time[0]
        phase = np.pi * time + motions.phi_bottom[row]
        force = np.cos(phase) + sum(
            own.cosine * np.cos(own.order * phase) + own.sine * np.sin(own.order * phase) for own in device.harmonics
        )
        # X'' = cos + mu gbar and x'' = -gbar, with x = X - Z, see `Device`.
        assert np.diff(x, 2) / step**2 == pytest.approx(force[1:-1] + mu * gravity, abs=2e-3)
        assert np.diff(x - z, 2) / step**2 == pytest.approx(np.full(len(time) - 2, -gravity), abs=2e-3)
    assert path.capsule[0] == pytest.approx(path.capsule[-1], abs=1e-12)
