"""Each addition can be taken out, and the rest stands."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from vireport.base.additions import ADDITIONS

ROOT = Path(__file__).resolve().parent.parent
WALLS = (
    *("tests/test_architecture.py", "tests/scenario/test_scenario.py", "tests/study/test_export.py"),
    "tests/gate/test_requirements.py::test_every_key_of_the_block_is_required_by_one_row",
)
"""Tests that are run without each addition; `tools/take_out.py` without more words runs all quick ones."""


@pytest.mark.slow
@pytest.mark.parametrize("name", ADDITIONS)
def test_without_an_addition_the_rest_stands(name: str) -> None:
    command = [sys.executable, str(ROOT / "tools" / "take_out.py"), name, *WALLS]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
