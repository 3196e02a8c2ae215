"""A word that the device comes to from rest is one of the families, and stable at the design point."""

from __future__ import annotations

import numpy as np
import pytest

from vireport import analyse
from vireport.physics.word import Word

LIMITS = {"impacts": 4, "periods": 2}
FIFTH = [{"order": 5, "percent": 7.0, "phase_deg": -25.0}]


def scenario(
    length_m: float, bottom: float, top: float, angle: float, harmonics: list[dict[str, float]]
) -> dict[str, object]:
    """A capsule in which forces from 2 to 4 N are looked at."""
    return {
        "schema_version": 1,
        "device": {
            "capsule_mass_kg": 0.1245,
            "ball_mass_kg": 0.0041,
            "length_m": length_m,
            "restitution_bottom": bottom,
            "restitution_top": top,
        },
        "excitation": {"amplitude_n": 3.0, "frequency_hz": 2.0, "harmonics": harmonics},
        "inclination_deg": angle,
        "sweep": {"parameter": "amplitude_n", "from": 2.0, "to": 4.0},
        "motions": LIMITS,
    }


def listed(told: dict[str, object]) -> bool:
    """Whether the word that it comes to from rest is stable there, of those that have one within the limits."""
    study = analyse(told, ("json",))
    end, design = study.disturbances.from_rest, study.solution.design
    if not end.is_motion or len(end.word) > LIMITS["impacts"] or end.periods > LIMITS["periods"]:
        return False
    word = Word.of(end.word, end.periods)
    images = {word.canonical(), word.canonical(mirror=True)}
    stable = {family.word.canonical() for family, _ in study.atlas.stable_at(design.value)}
    assert images & stable, (end.name, told)
    return True


@pytest.mark.slow
def test_of_a_distorted_force_and_membranes_that_differ() -> None:
    """It strikes the bottom three times; nothing that is followed from the 1:1 motions leads there."""
    assert listed(scenario(0.2, 0.5, 0.56, 5.0, FIFTH))


@pytest.mark.slow
def test_of_random_devices() -> None:
    rng, found = np.random.default_rng(4), 0
    while found < 6:
        order, bottom = int(rng.integers(2, 6)), rng.uniform(0.2, 0.7)
        parts = [{"order": order, "percent": rng.uniform(1, 10), "phase_deg": rng.uniform(-180, 180)}]
        top = bottom * rng.uniform(0.8, 1.2)
        found += listed(scenario(rng.uniform(0.02, 0.4), bottom, top, rng.uniform(0.5, 20), parts))
