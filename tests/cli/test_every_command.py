"""Every command on random scenarios with every block: an answer or a sentence, never a traceback, and strict JSON."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from any_scenario import COMMANDS, Calls, random_tree
from conftest import first

SEED = 20261128

ASKED = int(os.environ.get("SCENARIOS", 0))
"""So many scenarios are run through every command, some 20 s of processor time each; by default 48 through a few."""

COSTLY = 9, 13, 14, 25, 27, 30, 38, 45
"""Scenarios of which a run, or its chart, takes 5 to 30 s of processor time; by default they are only checked."""

PER_TEST = 4
"""Scenarios of one test: the tests are spread over processes."""

HEAVY = "report", "certify", "verify", "charted", "compared", "map"
"""Commands that take seconds: one of them on every fourth scenario."""

LIGHT = tuple(command for command in COMMANDS if command not in HEAVY)
"""The others: one of them on each scenario, after the check of it and its plan."""


@pytest.mark.parametrize("batch", first(0, range((ASKED or 48) // PER_TEST)))
def test_every_command_ends_with_an_answer_or_a_sentence(
    batch: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for number in range(batch * PER_TEST, (batch + 1) * PER_TEST):
        folder = tmp_path / str(number)
        folder.mkdir()
        calls = Calls(random_tree(np.random.default_rng([SEED, number])), folder)
        chosen = set(COMMANDS) if ASKED else {"check", "checked"}
        if number not in COSTLY:
            chosen.add(LIGHT[number % len(LIGHT)])
        if number % PER_TEST == 0:
            chosen.add(HEAVY[batch % len(HEAVY)])
        for command in sorted(chosen):
            calls.ended(command, capfd)


def test_the_light_commands_refuse_or_answer_a_few_scenarios(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    codes = set()
    for number in range(12):
        calls = Calls(random_tree(np.random.default_rng([SEED, 1000 + number])), tmp_path)
        codes |= {calls.ended(command, capfd)[0] for command in ("check", "checked")}
    assert codes <= {0, 2}
