"""What docstrings show as examples is what comes of them."""

from __future__ import annotations

import doctest
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FILES = [path for path in sorted((ROOT / "vireport").rglob("*.py")) if ">>> " in path.read_text(encoding="utf-8")]
"""Those with examples: to look for them in every module took each process of the tests a second."""


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_an_example_gives_what_it_shows(file: Path) -> None:
    found = doctest.testmod(import_module(".".join(file.relative_to(ROOT).with_suffix("").parts)))
    assert found.attempted
    assert not found.failed
