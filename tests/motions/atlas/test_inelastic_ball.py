"""The completely inelastic ball on a vibrating table (Mehta and Luck): where it rests, and where its period doubles.

An impact takes all of its velocity. With Gamma, the amplitude of the table's acceleration over g, it comes back after
n periods from where sin(phi) = n pi/Gamma, and leaves at once only if the table falls faster than it there: where
-Gamma cos(phi) > 1, so that Gamma^2 > 1 + n^2 pi^2. Its period doubles at Gamma^2 = n^2 pi^2 + 4.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from conftest import first

from vireport.motions.events import Event
from vireport.motions.families import Atlas
from vireport.motions.paths import Curve
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.scenario.loading import loads
from vireport.study.study import analyse

GRAVITY = 9.81


def atlas(low: float, high: float, restitution: float = 0.0, **more: int) -> Atlas:
    """The motions of a ball of 1 kg on a table for values of Gamma, the ceiling far above."""
    limits = {"impacts": 3, "periods": 2} | more
    text = f"""schema_version: 1
device: {{capsule_mass_kg: 1.0, length_m: 300.0, restitution: {restitution}}}
excitation: {{frequency_hz: 1.0}}
gravity_m_s2: {GRAVITY}
inclination_deg: 90
motions: {limits}
sweep: {{parameter: amplitude_n, from: {low * GRAVITY}, to: {high * GRAVITY}}}
"""
    found = analyse(loads(text), ("json",)).atlas
    assert found is not None
    return found


@pytest.mark.parametrize("n", first(1, [1, 2]))
@pytest.mark.parametrize("down", [False, True])
def test_onset_and_doubling_are_those_of_the_formulae(n: int, down: bool) -> None:
    onset, doubling = sqrt(1 + (n * pi) ** 2), sqrt((n * pi) ** 2 + 4)
    ends = (onset - 0.2, doubling + 0.1)
    found = atlas(*(ends[::-1] if down else ends), impacts=2, periods=2 * n)
    (family,) = (own for own in found.families if own.word.letters == "B" and own.word.periods == n)
    values = {mark.event: mark.point.sweep_value / GRAVITY for mark in family.marks if mark.point is not None}
    assert values[Event.GRAZING] == pytest.approx(onset, rel=1e-14)
    assert values[Event.PERIOD_DOUBLING] == pytest.approx(doubling, rel=1e-14)
    assert set(values) == {Event.GRAZING, Event.PERIOD_DOUBLING}


@pytest.mark.parametrize("n", first(1, [1, 2]))
def test_the_family_begins_at_the_onset_and_there_is_none_just_below(n: int) -> None:
    """There a solution passes through the table by less than 1e-15: only the acceleration tells that the ball rests."""
    onset = sqrt(1 + (n * pi) ** 2)
    found = atlas(onset - 1e-5, onset + 1e-5, impacts=1, periods=n)
    (family,) = (own for own in found.families if own.word.periods == n)
    assert family.sweep_value.min() / GRAVITY == pytest.approx(onset, rel=1e-14)


def test_no_word_is_made_of_the_ball_that_rests() -> None:
    """Below the onset the ball rests between its leaps, and no motion of impacts alone is there."""
    assert not atlas(pi + 0.01, sqrt(1 + pi**2) - 1e-9).families


@pytest.mark.slow
def test_a_little_restitution_changes_little() -> None:
    for restitution in (0.0, 1e-12):
        (family, *_) = atlas(3.2, 3.6, restitution, impacts=1, periods=1).families
        assert family.word.letters == "B"
        assert family.sweep_value.min() / GRAVITY == pytest.approx(sqrt(1 + pi**2), abs=1e-5)


@pytest.mark.parametrize(("gamma", "admitted"), [(1 - 1e-9, False), (1 + 1e-9, True)])
def test_the_acceleration_after_the_impact_decides(gamma: float, admitted: bool) -> None:
    gamma *= sqrt(1 + pi**2)
    (family,) = atlas(3.2, 3.6, impacts=1, periods=1).families
    curve: Curve = family.curve
    gbar, phase = 1 / gamma, pi - np.arcsin(pi / gamma)
    d = float(family.x[0, -1]) * float(family.sweep_value[0]) / (gamma * GRAVITY)
    motion = Motion(Word((1,), 1), np.array([2 * gbar]), np.array([phase / pi]), d)
    assert curve.admits(curve.vector(motion)) is admitted
