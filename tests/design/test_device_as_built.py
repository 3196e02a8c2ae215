"""The parts of a device as it is built, alone and together: motions and ends against the raw map in 40 digits."""

from __future__ import annotations

import numpy as np
import pytest
from exact_device import held_ends, held_motions

from vireport.base.errors import NumericalError
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Restitutions, SpeedLaw
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput

PARTS = {
    "two restitutions": ("restitutions",),
    "harmonics": ("harmonics",),
    "free capsule": ("free",),
    "friction": ("friction",),
    "restitution by speed": ("law",),
    "all, with friction": ("restitutions", "harmonics", "free", "friction"),
    "all, with restitution by speed": ("law", "harmonics", "free"),
}
"""Friction and a restitution that falls with speed are not known together."""


def as_built(rng: np.random.Generator, parts: tuple[str, ...]) -> Device:
    """A random device with some parts."""
    bottom, top = rng.uniform(0.3, 0.7, 2).tolist()
    restitution: object = Restitutions(bottom, top) if "restitutions" in parts else bottom
    if "law" in parts:
        restitution = SpeedLaw(bottom, top, rng.uniform(-0.2, -0.01), rng.uniform(1.0, 6.0))
    orders = rng.choice(np.arange(2, 6), 2, replace=False).tolist()
    sizes, phases = rng.uniform(0.5, 5.0, 2).tolist(), rng.uniform(0, 360, 2).tolist()
    return Device(
        0.1245,
        restitution,
        9.8,
        rng.uniform(0.4, 1.1),
        rng.uniform(2.5, 4.5),
        rng.uniform(1.6, 2.4),
        rng.uniform(10, 60),
        capsule=CapsuleMotion.FREE if "free" in parts else CapsuleMotion.PRESCRIBED,
        ball_mass_kg=rng.uniform(0.002, 0.03),
        harmonics=tuple(map(Harmonic.of, orders, sizes, phases)) if "harmonics" in parts else (),
        friction=rng.uniform(0.01, 0.1) if "friction" in parts else 0.0,
    )


@pytest.mark.parametrize(
    ("count", "parts"),
    [
        *((2, parts) for parts in PARTS if parts.startswith("all")),
        *(pytest.param(12, parts, marks=pytest.mark.slow) for parts in PARTS),
    ],
)
def test_motions_are_those_of_the_raw_map_and_of_the_simulation(count: int, parts: str) -> None:
    rng, held, refused = np.random.default_rng(300), 0, 0
    while held < count:
        try:
            held += held_motions(as_built(rng, PARTS[parts]))
        except NumericalError:  # next to where two motions of a force with harmonics meet, which is said
            refused += 1
    assert refused <= count / 6


@pytest.mark.slow
@pytest.mark.parametrize("parts", PARTS)
def test_ends_of_stable_motion_are_those_of_the_raw_map(parts: str) -> None:
    rng, held, refused = np.random.default_rng(100), 0, 0
    while held < 4:
        try:
            held += held_ends(as_built(rng, PARTS[parts]), DesignInput)
        except NumericalError:
            refused += 1
    assert refused <= 1
