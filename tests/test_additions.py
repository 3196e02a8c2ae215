"""Each addition can be taken out, and the rest stands."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from vireport.base.additions import ADDITIONS, AdditionRow, complete

ROOT = Path(__file__).resolve().parent.parent
WALLS = (
    *("tests/test_architecture.py", "tests/scenario/test_scenario.py", "tests/study/test_export.py"),
    "tests/study/judging/test_requirements.py::test_every_key_of_the_block_is_required_by_one_row",
)
"""Tests that are run without each addition; `tools/take_out.py` without more words runs all quick ones."""


@pytest.mark.slow
@pytest.mark.parametrize("name", ADDITIONS)
def test_without_an_addition_the_rest_stands(name: str) -> None:
    command = [sys.executable, str(ROOT / "tools" / "take_out.py"), name, *WALLS]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_needs_an_addition_is_left_out_with_it() -> None:
    rows = {"a": AdditionRow(("a",), ()), "b": AdditionRow(("b",), (), after=("a",))}
    rows["c"] = AdditionRow(("c",), (), after=("b",))
    assert complete(rows) == rows
    assert list(complete({name: row for name, row in rows.items() if name != "b"})) == ["a"]
    assert not complete({name: row for name, row in rows.items() if name != "a"})
