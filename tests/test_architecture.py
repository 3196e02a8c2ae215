"""The shape of the package: what imports what, and what is not imported when it is not needed."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import vireport

PACKAGE = Path(vireport.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))


@pytest.mark.parametrize("module", MODULES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_nothing_but_the_command_line_prints(module: Path) -> None:
    calls = [
        node.lineno
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
    ]
    assert not calls or module.parent == PACKAGE / "cli" or module.stem == "__main__"


def imported_by(*arguments: str) -> set[str]:
    """Modules loaded when the command line has run."""
    code = (
        "import sys; from vireport.__main__ import entry\n"
        "try: entry()\n"
        "finally: print('\\n'.join(sys.modules), file=sys.stderr)"
    )
    run = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return set(run.stderr.split("\n"))


HEAVY = {"matplotlib", "jinja2", "typst", "scipy", "numba", "mpmath", "rich"}


def test_json_imports_nothing_heavy(example) -> None:
    loaded = imported_by("run", str(example("inclined")), "--json")
    assert "numpy" in loaded
    assert not loaded & HEAVY


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["schema"], ["explain"], ["init", "-"], ["run", "--help"]]
)
def test_help_imports_no_physics(arguments: list[str]) -> None:
    assert not imported_by(*arguments) & (HEAVY | {"numpy"})


def test_validate_imports_no_physics(example) -> None:
    assert not imported_by("validate", str(example("inclined"))) & (HEAVY | {"numpy"})


def test_a_report_never_imports_pyplot(example, tmp_path: Path) -> None:
    loaded = imported_by("run", str(example("inclined")), "-o", str(tmp_path / "out"))
    assert "matplotlib" in loaded
    assert not loaded & {"matplotlib.pyplot", "scipy", "numba", "mpmath"}


def test_csv_alone_draws_nothing(example, tmp_path: Path) -> None:
    loaded = imported_by("run", str(example("inclined")), "-o", str(tmp_path / "out"), "--format", "csv")
    assert not loaded & HEAVY
