"""The shape of the package: what imports what, and what is not imported when it is not needed."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest
import yaml
from conftest import first

import vireport
from vireport.base.additions import ADDITIONS, adding
from vireport.base.errors import EXTRAS, install_command

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = sorted(
    str(path.parent.relative_to(ROOT / "vireport"))
    for depth in ("*", "*/*")
    for path in (ROOT / "vireport").glob(f"{depth}/__init__.py")
)

IMPORT = re.compile(r"^[ \t]*(?:from (vireport[\w.]*) import (\([^)]*\)|[^\n]*)|import (vireport[\w.]*))", re.MULTILINE)
"""Of imports alone; to parse all files of the project for them takes seconds."""

CLASS = re.compile(r"^class ([a-zA-Z]\w*)", re.MULTILINE)


@cache
def text_of(file: Path) -> str:
    return file.read_text(encoding="utf-8")


@cache
def imports(file: Path) -> list[tuple[str, str]]:
    """Each name that a file imports of vireport, and from where."""
    found = []
    for module, names, plain in IMPORT.findall(text_of(file)):
        listed = re.sub(r"#.*", "", names).strip("() \n").split(",")
        found += [(module or plain, name.split(" as ")[0].strip()) for name in listed if plain or name.strip()]
    return found


@cache
def files_in(folder: str) -> list[Path]:
    return sorted((ROOT / folder).rglob("*.py"))


def test_no_public_class_name_stands_for_two_things() -> None:
    places: dict[str, list[str]] = {}
    for file in (ROOT / "vireport").rglob("*.py"):
        for name in CLASS.findall(text_of(file)):
            places.setdefault(name, []).append(str(file.relative_to(ROOT)))
    assert not {name: files for name, files in places.items() if len(files) > 1}


def test_what_a_module_keeps_to_itself_is_imported_nowhere() -> None:
    """A name with an underscore is of one module; tests alone may look inside."""
    for file in files_in("vireport"):
        inner = [name for _, name in imports(file) if name.startswith("_") and not name.endswith("__")]
        assert not inner, (str(file.relative_to(ROOT)), inner)


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_imports_nothing_by_itself(package: str) -> None:
    """A name is imported from the module that defines it, so that a run loads the modules that it needs."""
    tree = ast.parse(text_of(ROOT / "vireport" / package / "__init__.py"))
    assert len(tree.body) == 1
    assert ast.get_docstring(tree)


def test_additions_are_reached_by_name_in_four_places_at_most() -> None:
    """The contract of imports does not see them there; all else that an addition brings, these places pass on."""
    by_name = re.compile(r"\bdeclared\(\"|\bdeclaration\(|\.packages\b|import_module\(f")
    home = ROOT / "vireport" / "base" / "additions.py"
    files = [file for file in files_in("vireport") if file != home]
    places = [str(file.relative_to(ROOT)) for file in files for _ in by_name.findall(text_of(file))]
    assert "vireport/study/judging/findings.py" in places
    assert len(places) <= 4, places


def test_the_package_lists_its_public_names() -> None:
    assert dir(vireport) == vireport.__all__
    assert all(getattr(vireport, name) for name in vireport.__all__)


def test_checkers_of_types_are_told_of_every_public_name() -> None:
    """What is imported when it is first asked for is unknown to them; a marker says that the package has types."""
    tree = ast.parse(text_of(ROOT / "vireport" / "__init__.py"))
    (told,) = [node.body for node in tree.body if isinstance(node, ast.If) and isinstance(node.test, ast.Name)]
    assert sorted(alias.name for node in told for alias in node.names) == sorted(vireport.__all__)
    assert (ROOT / "vireport" / "py.typed").exists()


def imported_by(*arguments: str) -> set[str]:
    """Modules loaded when the command line has run."""
    code = (
        "import sys; from vireport.__main__ import entry\n"
        "try: entry()\n"
        "finally: print('\\n'.join(sys.modules), file=sys.stderr)"
    )
    run = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return set(run.stderr.split("\n"))


DRAWING = {"matplotlib", "typst", "scipy", "numba", "mpmath", "flint", "rich"}
HEAVY = DRAWING | {"jinja2"}
DEFERRED = {
    "vireport.findings.outcomes.moments",
    "vireport.findings.outcomes.windows",
    "vireport.study.judging.requirements",
    "vireport.study.judging.verdict",
    "vireport.scenario.hints",
    "vireport.scenario.json_schema",
    "vireport.scenario.messages",
    "vireport.simulation.following",
    "vireport.text.tables",
    "vireport.findings.tolerances.tolerances",
}
"""Modules of our own that a scenario without blocks for them does without."""


@pytest.mark.slow
def test_json_imports_nothing_heavy(example) -> None:
    loaded = imported_by("run", str(example("inclined")), "--json")
    assert "numpy" in loaded
    assert not loaded & (HEAVY | {"vireport.motions.atlas"} | DEFERRED)


@pytest.mark.parametrize(
    "arguments",
    first(1, [["run", "--help"], ["init", "--schema"], ["--help"], ["--version"], ["explain"], ["init", "-"]]),
)
def test_help_imports_no_physics(arguments: list[str]) -> None:
    assert not imported_by(*arguments) & (HEAVY | {"numpy"})


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [["explain"], ["map", "--help"], ["sweep", "--help"]])
def test_of_the_commands_of_additions_only_the_one_asked_for_is_imported(arguments: list[str]) -> None:
    own = {f"vireport.{ADDITIONS[name].packages[0]}.command" for name in adding("command")}
    assert imported_by(*arguments) & own == ({"vireport.map.command"} if "--help" in arguments else set())


@pytest.mark.slow
def test_a_check_imports_nothing_heavy(example) -> None:
    assert not imported_by("check", str(example("inclined")), "--json") & HEAVY
    # What is left out is said in words of the templates.
    assert imported_by("check", str(example("inclined"))) & HEAVY == {"jinja2"}


@pytest.mark.slow
def test_a_report_never_imports_pyplot(example, tmp_path: Path) -> None:
    loaded = imported_by("run", str(example("inclined")), "-o", str(tmp_path / "out"))
    assert "matplotlib" in loaded
    assert not loaded & {"matplotlib.pyplot", "scipy", "numba", "mpmath", "flint"}


@pytest.mark.slow
def test_csv_alone_draws_nothing(example, tmp_path: Path) -> None:
    loaded = imported_by("run", str(example("inclined")), "-o", str(tmp_path / "out"), "--format", "csv")
    assert not loaded & DRAWING


@pytest.mark.slow
@pytest.mark.parametrize("format_", ["svg", "png"])
def test_figures_alone_need_no_page(format_: str, example, tmp_path: Path) -> None:
    loaded = imported_by("run", str(example("inclined")), "-o", str(tmp_path / "out"), "--format", format_)
    assert "matplotlib" in loaded
    assert "typst" not in loaded


def test_an_install_command_names_an_extra_that_brings_the_package() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for package, extra in EXTRAS.items():
        assert any(re.match(rf"{package.split('.')[0]}\b", requirement) for requirement in extras[extra]), package
        assert f"vireport[{extra}]" in install_command(package)


def test_every_dependency_has_its_reason() -> None:
    project = tomllib.loads(text_of(ROOT / "pyproject.toml"))["project"]
    required = [*project["dependencies"], *(x for extra in project["optional-dependencies"].values() for x in extra)]
    names = {re.split(r"[^\w-]", requirement)[0] for requirement in required} - {project["name"]}
    rows = text_of(ROOT / "CONTRIBUTING.md").partition("## Dependencies")[2].partition("## Style")[0].splitlines()[6:]
    assert {name for row in rows if row for name in row.split("|")[1].strip().split(", ")} == names


def test_names_of_files_are_such_as_every_system_has() -> None:
    """Windows cannot check out others, and `uv build` takes none of them from the sdist."""
    folders = (ROOT / name for name in ("vireport", "templates", "tests", "examples", "docs", "tools", "benchmarks"))
    names = [path.name for folder in folders for path in folder.rglob("*")]
    assert [name for name in names if re.search(r'[<>:"\\|?*]', name)] == []


def test_what_is_cited_is_this_version() -> None:
    cited = yaml.safe_load(text_of(ROOT / "CITATION.cff"))
    project = tomllib.loads(text_of(ROOT / "pyproject.toml"))["project"]
    assert cited["version"] == vireport.__version__
    assert f"\n## [{cited['version']}] - {cited['date-released']}\n" in text_of(ROOT / "CHANGELOG.md")
    assert (cited["title"], cited["abstract"]) == (project["name"], project["description"])
    assert (cited["license"], cited["keywords"]) == (project["license"], project["keywords"])
    assert cited["authors"][0]["name"].removeprefix("The ") in text_of(ROOT / "LICENSE")
    (paper,) = cited["references"]
    told = " ".join(text_of(ROOT / "README.md").split())
    names = [f"{author['given-names']} {author['family-names']}" for author in paper["authors"]]
    assert all(name in told for name in (*names, paper["title"], f"{paper['journal']} ({paper['year']})"))
