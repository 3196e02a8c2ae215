"""The tutorial, followed word by word."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
def test_every_command_of_the_tutorial_prints_what_it_shows() -> None:
    run = subprocess.run([sys.executable, ROOT / "tools" / "follow_tutorial.py"], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
