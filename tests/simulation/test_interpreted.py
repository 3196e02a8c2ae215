"""The event search without numba: the same impacts, slower; and with it, compiled only when it is needed."""

from __future__ import annotations

import logging
import subprocess
import sys
from math import pi

import numpy as np
import pytest
from conftest import first
from mpmath import mp, mpf

from vireport.physics.groups import Groups
from vireport.simulation import events, kernel
from vireport.simulation.attractors import Outcome, find_attractor
from vireport.simulation.events import BOTTOM, Impact, check_model, follow_impacts
from vireport.simulation.kernel import EPS, REST, RUNNING, TURN, sine_and_cosine

CHAOS = (0.2545, 0.3, 0.5)


@pytest.fixture
def without_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search as it is where numba is missing."""
    monkeypatch.setattr(events, "compiled_search", lambda: None)


def random_models(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Devices and starts of all sizes, with membranes alike or not, at rest, in flight, chattering and grazing."""
    restitutions = rng.choice([0, 0.5, 1], (2, count))
    model = np.column_stack([10 ** rng.uniform(-3, 3, count), rng.choice([0, 1e-9, 0.3, 1, 1.5], count), *restitutions])
    wall = rng.choice([1.0, -1.0, 0.0], count)
    velocity = np.where(wall == 0, rng.choice([-1, 1], count), wall) * 10 ** rng.uniform(-9, 3, count)
    velocity[::7] = 0.0
    position = np.where(wall == 0, model[:, 0] * rng.uniform(-0.49, 0.49, count), 0.0)
    return check_model(Groups.of(*model.T)), np.column_stack([wall, position, velocity, rng.uniform(0, 2 * pi, count)])


def test_interpreted_impacts_are_the_compiled_ones() -> None:
    """To rounding: sine and cosine may come from another library, and a flight between touches may grow it."""
    model, starts = random_models(np.random.default_rng(1), 400)
    (compiled, summary), (rows, ends) = (follow_impacts(model, starts, 3, compiled=c) for c in (True, False))
    same = (rows == compiled) | (np.isnan(rows) & np.isnan(compiled))
    close = np.isclose(rows, compiled, rtol=1e-9, atol=1e-9, equal_nan=True)
    assert same.mean() > 0.5
    assert close.all(axis=(1, 2)).mean() > 0.98
    assert (summary[:, 2] == ends[:, 2]).mean() > 0.98


@pytest.mark.parametrize(("count", "compiled"), [(300, True), (40, False)])
def test_many_balls_at_once_have_the_impacts_of_each_alone_to_the_last_bit(count: int, compiled: bool) -> None:
    rng = np.random.default_rng(2)
    extreme, starts = random_models(rng, count)
    usual = check_model(Groups.of(rng.uniform(0.2, 0.6, count), rng.uniform(0, 0.4, count), 0.5, 0.7))
    model = np.where(rng.random(count)[:, None] < 0.5, extreme, usual)
    starts[:, 1] = np.where(starts[:, 0] == 0, 0.3 * model[:, 0] * np.sign(starts[:, 1]), 0.0)
    rows, summary = follow_impacts(model, starts, 30, 7, compiled=compiled)
    for i in range(count):
        alone, end = follow_impacts(model[i : i + 1], starts[i : i + 1], 30, 7, compiled=compiled)
        assert np.array_equal(rows[i], alone[0], equal_nan=True)
        assert np.array_equal(summary[i], end[0])
    assert set(summary[:, 2]) >= {RUNNING, REST}


def test_most_impacts_are_not_left_to_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    rng, count, searched = np.random.default_rng(3), 20, []
    model = check_model(Groups.of(rng.uniform(0.2, 0.6, count), rng.uniform(0, 0.4, count), 0.5, 0.7))
    starts = np.stack([np.ones(count), np.zeros(count), *rng.uniform(0.5, [[1.5], [6.2]], (2, count))], axis=1)
    search = kernel._next_impact
    monkeypatch.setattr(kernel, "_next_impact", lambda *flight: searched.append(flight) or search(*flight))
    follow_impacts(model, starts, 40, 1, compiled=False)
    assert len(searched) < 0.3 * 40 * count  # nine tenths where a term of the approach is off by a hundredth


def test_sine_and_cosine_are_exact_to_what_their_docstring_says() -> None:
    phases = np.concatenate([np.random.default_rng(3).uniform(0, TURN, 4000), np.linspace(0, TURN, 17)])
    computed = sine_and_cosine(phases)
    with mp.workdps(40):
        for i, phase in enumerate(phases):
            for value, exact in zip(computed, (mp.sin(mpf(float(phase))), mp.cos(mpf(float(phase)))), strict=True):
                assert abs(mpf(float(value[i])) - exact) <= 1.3 * EPS * abs(exact) + 4e-31


@pytest.mark.usefixtures("without_numba")
def test_an_orbit_is_found_without_the_compiler() -> None:
    attractor = find_attractor(Groups(0.4604, 0.1245 * 9.8 * np.sin(np.radians(45)) / 3, 0.5), Impact(BOTTOM, 1.0, 0.5))
    assert (attractor.outcome, attractor.word) == (Outcome.PERIODIC, "BT")
    assert attractor.cycle.velocity[0] == pytest.approx(1.00400474, abs=0.6e-8)


@pytest.mark.usefixtures("without_numba")
def test_a_long_interpreted_job_says_so_once(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    model, starts = check_model(Groups(*np.array([CHAOS] * 2).T)), np.array([[1.0, 0.0, 0.7, 0.2]] * 2)
    with caplog.at_level(logging.WARNING):
        follow_impacts(model, starts, 10)
        assert not caplog.records
        monkeypatch.setattr(events, "LONG", 1e-5)
        follow_impacts(model, starts, 10)
        follow_impacts(model, starts, 10)
    assert [record.message.count("pip install 'vireport[simulation]'") for record in caplog.records] == [1]


@pytest.mark.parametrize(
    "impacts",
    first(1, ["", "follow_one(np.array([0.5, 0.3, 0.5, 0.5, 0.0, 1.0]), [1.0, 0.0, 0.7, 0.2], 10, compiled=False)"]),
)
def test_the_compiler_is_not_paid_for_unless_it_is_asked_for(impacts: str) -> None:
    imported = "import sys, numpy as np; from vireport.simulation.events import *"
    code = f"{imported}\n{impacts}\nsys.exit('numba' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
