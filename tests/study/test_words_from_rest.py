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
    end, design = study.switched_on.from_rest, study.solution.design
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


def over(amplitude_n: float, start: float, end: float) -> dict[str, object]:
    """A capsule that comes from rest to BBTT about 3 N, which nothing from other values leads to."""
    fourth = [{"order": 4, "percent": 2.6, "phase_deg": 45.7}]
    told = scenario(0.0948, 0.616, 0.552, 10.13, fourth)
    return told | {
        "excitation": {"amplitude_n": amplitude_n, "frequency_hz": 2.0, "harmonics": fourth},
        "sweep": {"parameter": "amplitude_n", "from": start, "to": end},
    }


@pytest.mark.slow
def test_the_design_point_need_not_be_among_the_values_looked_at_over_the_sweep() -> None:
    """These are 0.55, 1.55, 2.55, 3.55 N, ...: a stable family from 2.97 N on is seen from the design point alone."""
    assert listed(over(3.0, 0.55, 20.55))


@pytest.mark.slow
def test_words_from_rest_over_the_sweep_are_there_whatever_the_design_point_does() -> None:
    study = analyse(over(4.0, 2.0, 4.0), ("json",))
    assert not study.switched_on.from_rest.is_motion
    assert Word.of("BBTT", 1) in {family.word.canonical() for family, _ in study.atlas.stable_at(3.0)}


@pytest.mark.slow
def test_of_random_devices() -> None:
    rng, found = np.random.default_rng(4), 0
    while found < 3:
        order, bottom = int(rng.integers(2, 6)), rng.uniform(0.2, 0.7)
        parts = [{"order": order, "percent": rng.uniform(1, 10), "phase_deg": rng.uniform(-180, 180)}]
        top = bottom * rng.uniform(0.8, 1.2)
        found += listed(scenario(rng.uniform(0.02, 0.4), bottom, top, rng.uniform(0.5, 20), parts))
