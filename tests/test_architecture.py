"""The shape of the package: what imports what, and what is not imported when it is not needed."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from conftest import first

import vireport
from vireport.base import EXTRAS, install_command

ROOT = Path(__file__).resolve().parent.parent


def test_the_package_lists_its_public_names() -> None:
    assert dir(vireport) == vireport.__all__
    assert all(getattr(vireport, name) for name in vireport.__all__)


def imported_by(*arguments: str) -> set[str]:
    """Modules loaded when the command line has run."""
    code = (
        "import sys; from vireport.__main__ import entry\n"
        "try: entry()\n"
        "finally: print('\\n'.join(sys.modules), file=sys.stderr)"
    )
    run = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return set(run.stderr.split("\n"))


DRAWING = {"matplotlib", "typst", "markdownify", "scipy", "numba", "mpmath", "flint", "rich"}
HEAVY = DRAWING | {"jinja2"}


def test_json_imports_nothing_heavy(example) -> None:
    loaded = imported_by("run", str(example("inclined")), "--json")
    assert "numpy" in loaded
    assert not loaded & (HEAVY | {"vireport.atlas"})


@pytest.mark.parametrize(
    "arguments", first(2, [["run", "--help"], ["schema"], ["--help"], ["--version"], ["explain"], ["init", "-"]])
)
def test_help_imports_no_physics(arguments: list[str]) -> None:
    assert not imported_by(*arguments) & (HEAVY | {"numpy"})


def test_validate_imports_no_physics(example) -> None:
    assert not imported_by("validate", str(example("inclined"))) & (HEAVY | {"numpy"})


@pytest.mark.slow
def test_a_report_never_imports_pyplot(example, tmp_path: Path) -> None:
    loaded = imported_by("run", str(example("inclined")), "-o", str(tmp_path / "out"))
    assert "matplotlib" in loaded
    assert not loaded & {"matplotlib.pyplot", "scipy", "numba", "mpmath", "flint"}


def test_csv_alone_draws_nothing(example, tmp_path: Path) -> None:
    loaded = imported_by("run", str(example("inclined")), "-o", str(tmp_path / "out"), "--format", "csv")
    assert not loaded & DRAWING


@pytest.mark.slow
@pytest.mark.parametrize(("format_", "needless"), [("svg", {"typst"}), ("png", set())])
def test_figures_alone_need_no_page(format_: str, needless: set[str], example, tmp_path: Path) -> None:
    loaded = imported_by("run", str(example("inclined")), "-o", str(tmp_path / "out"), "--format", format_)
    assert "matplotlib" in loaded
    assert not loaded & (needless | {"bs4", "markdownify"})


def test_an_install_command_names_an_extra_that_brings_the_package() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for package, extra in EXTRAS.items():
        assert any(re.match(rf"{package.split('.')[0]}\b", requirement) for requirement in extras[extra]), package
        assert f"vireport[{extra}]" in install_command(package)
