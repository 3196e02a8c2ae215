"""What README.md and docs/ say is true: Python runs, scenarios and commands are valid, links lead somewhere."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from runpy import run_path
from textwrap import dedent

import pytest
from markdown_it import MarkdownIt

from vireport import (
    analyse,
    compare,
    diff,
    load,
    loads,
    results,
)
from vireport.base.errors import EXTRAS
from vireport.base.records import ResultsBlock
from vireport.cli.app import program
from vireport.optimise.problem import problem_of
from vireport.scenario.json_schema import init_text, schema
from vireport.scenario.loading import loads_map
from vireport.study.provenance import provenance_of
from vireport.text.alerts import AlertCode
from vireport.text.folders import ROOTS

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
DOCS = sorted((ROOT / "docs").glob("*.md"))
PAGES = [README, *DOCS, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
NOT_TYPED = (
    r"<!-- (?:keys|names|heads).*? -->\n(?:\|.*\n)*",
    r"(?s)^ *```\w*\n.*?^ *```$",
    r"^ {4}.*$",
    r"^\|.*\{\{.*\n",
    r"(?s)<!--.*?-->|\{%.*?%\}",
    r"(?<=\])\([^)]*\)",
)
"""Tables that are made, code and output, remarks and instructions of templates, and addresses of links."""
SENTENCE_END = re.compile(r"(?<=[.!?])[\")*]* +(?=[A-Z`*\[])")
COMMANDS = program()

every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def blocks(page: Path, language: str) -> list[str]:
    return [code for name, code in FENCED.findall(text_of(page)) if name == language]


def words(text: str) -> list[str]:
    return [word for word in text.split() if re.search(r"\w", word)]


def typed(page: Path) -> str:
    """What a person typed of a page: no code, no output, no table that is made, no address of a link."""
    template = ROOT / "tools" / f"{page.name}.j2"
    text = text_of(template if template.is_file() else page).partition("<!-- blocks of additions")[0]
    for made in NOT_TYPED:
        text = re.sub(made, "", text, flags=re.MULTILINE)
    return re.sub(r"(?s)\{\{.*?\}\}", "1", text)


def prose(text: str) -> list[str]:
    """Paragraphs and items of lists, without headings, tables and pictures."""
    parts = re.split(r"\n\s*\n|\n(?=\s*(?:-|\d+\.) )", text)
    return [" ".join(part.split()) for part in parts if part.strip() and part.lstrip()[0] not in "|#!"]


def rendered(page: Path) -> str:
    """A page in HTML."""
    return MarkdownIt().enable("table").render(text_of(page))


def anchors(page: Path) -> set[str]:
    """Names that GitHub gives to the headings of a page."""
    headings = re.findall(r"^#+ (.+)$", FENCED.sub("", text_of(page)), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading).strip().lower().replace(" ", "-") for heading in headings}


def commands() -> list[tuple[str, str]]:
    """Command lines in indented blocks, with the page that they are on."""
    command = re.compile(r"^    (\S*vireport .*|.* && \S*vireport .*)$", re.MULTILINE)
    return [(page.name, line) for page in PAGES for line in command.findall(text_of(page))]


def test_the_python_of_the_readme_prints_what_matters(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(ROOT)
    (code,) = blocks(README, "python")
    exec(compile(code, "README.md", "exec"), {})
    out = capsys.readouterr().out
    assert out.startswith("It runs, and starts by itself, with margin.\nStable length: above 0.629 m;")
    assert "B1 period doubling at 0.629 m" in out
    assert "stable node: U_ave = 926 V" in out


@pytest.mark.parametrize("page", DOCS, ids=lambda page: page.name)
def test_the_python_of_the_docs_runs(page: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(ROOT)
    for code in blocks(page, "python"):
        exec(compile(code, page.name, "exec"), {})
        assert capsys.readouterr().out


def test_the_first_run_prints_what_the_readme_says(study_of) -> None:
    lines = study_of("stiff-membrane").opening.worded().lines
    assert "\n".join(f"    {line}" for line in lines) in text_of(README)


@pytest.mark.slow
def test_comparisons_print_what_the_docs_say(study_of, example) -> None:
    page = text_of(ROOT / "docs" / "compare.md")
    (sentence,) = re.findall(r"^    (Stable range .*)$", page, re.MULTILINE)
    variants = compare(example("inclined"), vary={"inclination_deg": [0, 45]})
    assert sentence in [difference.sentence for difference in variants.differences]
    ((count, shown),) = re.findall(r"^    (\d+) changes since .*\n((?:      .*\n)+)", page, re.MULTILINE)
    study = study_of("inclined")
    longer = analyse(load(example("inclined"), ["device.length_m=0.7"]), ("json",))
    changes = diff(results(study, provenance_of(study.loaded, "")), longer)
    assert len(changes) == int(count)
    printed = [f"{change.group}: {change.sentence}" for change in changes]
    assert set(re.findall(r"^ +(\w+: .*)$", shown, re.MULTILINE)) <= set(printed)


@pytest.mark.slow
def test_impacts_of_the_examples_are_as_deep_as_the_docs_say(study_of) -> None:
    ((depth, radii),) = re.findall(r"some (\d+) mm deep, (\d) times its radius", text_of(ROOT / "docs" / "model.md"))
    for solution in (study_of(name).solution for name in ("horizontal", "inclined", "inclined-forcing")):
        assert solution.deepest_m == pytest.approx(float(depth) / 1000, rel=0.2)
        assert solution.deepest_m / solution.membrane.active_radius_m == pytest.approx(float(radii), rel=0.25)


@pytest.mark.slow
def test_stretch_and_thickness_of_the_examples_are_as_the_docs_say(study_of) -> None:
    text = text_of(ROOT / "docs" / "model.md")
    (areas,) = re.findall(r"grows ([\d.]+), ([\d.]+) and ([\d.]+) times at the design points", text)
    (needed,) = re.findall(
        r"at 100 MV/m the voltages of these design points need ([\d.]+), ([\d.]+) and ([\d.]+)", text
    )
    for name, area, thickness in zip(("horizontal", "inclined", "inclined-forcing"), areas, needed, strict=True):
        stretch = study_of(name).solution.stretch
        assert (f"{stretch.area_ratio:.1f}", f"{1e3 * stretch.thickness_at(1e8):.2f}") == (area, thickness)


def test_measured_figures_are_those_that_the_benchmarks_wrote() -> None:
    run = subprocess.run([sys.executable, ROOT / "tools" / "make_docs.py", "--check"], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout


def test_scenarios_are_valid() -> None:
    (scenario,) = blocks(README, "yaml")
    assert loads(scenario).scenario.sweep is not None
    for page in DOCS:
        for block in blocks(page, "yaml"):
            if "map:" in block:
                assert loads_map(block).block.axes
            else:
                assert loads(block if "schema_version:" in block else scenario + block)


def test_the_lines_for_the_shortest_device_complete_a_new_scenario() -> None:
    lines = re.findall(r"^    (?:requirements|design): .*$", text_of(README), re.MULTILINE)
    problem = problem_of(loads(f"{init_text()}\n{dedent(chr(10).join(lines))}\n"))
    required = problem.loaded.scenario.requirements
    assert (required.margin_any_percent, required.margin_with_effects_percent, required.reached_from_rest) == (
        5,
        5,
        True,
    )
    assert problem.objective.path == "device.length_m"
    assert problem.sign < 0


@every_page
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r'(?:href|src)="([^"]+)"', rendered(page)):
        if target.startswith("https://"):
            continue
        file, _, anchor = target.partition("#")
        path = (page.parent / file).resolve() if file else page
        assert path.is_file(), target
        assert not anchor or anchor in anchors(path), target


@every_page
def test_sources_that_are_named_exist(page: Path) -> None:
    folders = ("vireport", "templates", "tools", "tests", "benchmarks")
    files = [f"/{path.relative_to(ROOT).as_posix()}" for folder in folders for path in (ROOT / folder).rglob("*.*")]
    for name in re.findall(r"[\w/-]+\.(?:py|css|(?:html|typ)\.j2)\b", text_of(page)):
        assert any(file.endswith(f"/{name}") for file in files), name


def test_every_page_of_the_docs_can_be_reached_from_the_readme() -> None:
    for page in DOCS:
        assert f"](docs/{page.name})" in text_of(README)


def test_every_example_is_listed() -> None:
    listed = text_of(ROOT / "docs" / "examples.md")
    for pattern in ("*.yaml", "*.ipynb", "*.csv", "ci/*.yaml", "maps/*.yaml"):
        for file in (ROOT / "examples").glob(pattern):
            assert f"](../{file.relative_to(ROOT).as_posix()})" in listed


@pytest.mark.slow
def test_pictures_are_those_that_are_drawn_now() -> None:
    check = [sys.executable, ROOT / "tools" / "make_pictures.py", "--check", "horizontal-figure-2"]
    run = subprocess.run(check, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


def test_every_picture_is_shown() -> None:
    shown = "".join(map(text_of, PAGES))
    for picture in (ROOT / "examples" / "pictures").iterdir():
        assert f"examples/pictures/{picture.name})" in shown, picture.name


@every_page
def test_tables_are_whole(page: Path) -> None:
    """A table is a head, a rule and rows with as many cells each; an empty line would end it."""
    tables = re.findall(r"(?:^\|.*\n)+", text_of(page), re.MULTILINE)
    assert rendered(page).count("<table>") == len(tables)
    for table in tables:
        rows = [re.split(r"(?<!\\)\|", row)[1:-1] for row in table.splitlines()]
        assert len(rows) > 2, table
        assert all(re.fullmatch(r":?-+:?", cell.strip()) for cell in rows[1]), table
        assert {len(row) for row in rows} == {len(rows[0])}, table


def test_every_command_and_exit_code_stands_in_a_table() -> None:
    for name in COMMANDS.commands:
        for page in (README, ROOT / "docs" / "commands.md"):
            assert re.search(rf"^\| `vireport {name}\b", text_of(page), re.MULTILINE), name
    for code in (0, 1, 2, 3, 130):
        assert re.search(rf"^\| {code} \|", text_of(ROOT / "docs" / "commands.md"), re.MULTILINE), code


@pytest.mark.parametrize(("page", "line"), commands())
def test_commands_are_understood(page: str, line: str) -> None:
    """Each exists with its options, and its files are there where they are examples."""
    words = shlex.split(re.split(r"&&", line)[-1])
    assert words[0].endswith("vireport"), line
    arguments = words[1:] if words[1] in COMMANDS.commands else ["run", *words[1:]]
    COMMANDS.commands[arguments[0]].make_context(arguments[0], arguments[1:])
    assert all((ROOT / word).is_file() for word in words if word.startswith("examples/") and ">" not in line), line


def test_the_two_commands_are_those_that_are_tested() -> None:
    first, second = re.findall(r"^    (python3 .*|\./test\.sh)$", text_of(README), re.MULTILINE)
    assert (
        first == "python3 -m venv .venv && .venv/bin/pip install . && .venv/bin/vireport examples/stiff-membrane.yaml"
    )
    assert second == "./test.sh"
    assert (ROOT / "test.sh").stat().st_mode & 0o100


def named(page: str) -> set[str]:
    """What stands as code on a page of the docs."""
    return {word for code in re.findall(r"`([^`\n]+)`", text_of(ROOT / "docs" / page)) for word in code.split(", ")}


def test_every_key_of_a_scenario_is_documented() -> None:
    def paths(node: dict, path: str = "") -> Iterator[str]:
        for name, key in node.get("properties", {}).items():
            here = f"{path}{name}"
            references = [part["$ref"] for part in [key, *key.get("anyOf", [])] if "$ref" in part]
            if not references:
                yield here
            for reference in references:
                yield from paths(whole["$defs"][reference.rpartition("/")[2]], f"{here}.")

    whole = schema()
    # All signals have the same keys for their columns.
    keys = {re.sub(r"^record\.columns\.\w+\.", "record.columns.time_s.", path) for path in paths(whole)}
    assert {"sweep.from", "device.membrane.exponent", "requirements.crosscheck_passed"} <= keys
    assert keys <= named("scenario.md")


def test_every_block_of_the_results_is_documented(study_of) -> None:
    study = study_of("inclined")
    assert set(results(study, provenance_of(study.loaded, ""))) <= named("results.md")


def test_every_template_and_name_of_a_report_is_described() -> None:
    page = text_of(ROOT / "docs" / "templates.md")
    files = {file.relative_to(root).as_posix() for root in ROOTS for file in root.glob("**/[a-z]*.j2")}
    assert set(re.findall(r"^\| `(\S+\.j2)` \| [A-Z].+ \|$", page, re.MULTILINE)) == files - {"bench/page.html.j2"}
    for name in ("study", "say(words, macro, values)", "at_design()", "nearest", "regions()", "cells()", "ranking()"):
        assert re.search(rf"^\| `{re.escape(name)}` \| [A-Z].+ \|$", page, re.MULTILINE), name
    assert not re.search(r"^\| `_|^\| `\S+` \| +\|$", page, re.MULTILINE)


def test_a_key_of_the_results_that_nothing_describes_is_a_mistake() -> None:
    tool = run_path(str(ROOT / "tools" / "make_docs.py"))
    page = "".join(map(text_of, DOCS))
    assert list(tool["undescribed"](page)) == []

    class Damped(ResultsBlock):
        """A record.

        Attributes
        ----------
        loss, heat : J
            Energy | work,
            in words.
        work
            What is done.
        """

        loss: float
        from_: float
        work: float | None

    mistakes = [
        "Damped: Attributes do not say what it is: from",
        "Damped: is not a key: heat",
        "Damped: Attributes do not say when it is null: work",
    ]
    assert list(tool["undescribed"](page + "<!-- keys of damper: Damped -->\n")) == mistakes
    assert list(tool["undescribed"](page)) == [*mistakes, "Damped: no page of docs/ has a table of its keys"]
    made = tool["with_tables"]("Before.\n\n<!-- keys of damper: Damped -->\n| old |\n\nAfter.\n")
    assert made.endswith(
        "<!-- keys of damper: Damped -->\n| key | content | unit |\n| --- | --- | --- |\n"
        "| **of `damper`:** | A record. | |\n| `loss`, `heat` | Energy \\| work, in words. | J |\n"
        "| `work` | What is done. | |\n\nAfter.\n"
    )
    pages = {tool["RESULTS"]: "Results.\n", tool["RESULTS"].with_name("other.md"): page}
    listed = pages | {tool["RESULTS"]: f"Results.\n{tool['MARK']}"}
    assert tool["with_additions"](pages) == listed[tool["RESULTS"]]  # of records of the core none is added
    Damped.__module__ = "vireport.findings.damper.results"
    added = f"{listed[tool['RESULTS']]}\n## A record\n\n<!-- keys of Damped -->\n"
    assert tool["with_additions"](listed) == tool["with_additions"](pages) == added


def test_alerts_that_are_named_exist() -> None:
    for page in PAGES:
        assert set(re.findall(r"\bVR\d{3}\b", text_of(page))) <= set(AlertCode)


def test_the_packages_are_those_of_the_import_contract() -> None:
    contract, *_ = tomllib.loads(text_of(ROOT / "pyproject.toml"))["tool"]["importlinter"]["contracts"]
    layers = [package for layer in contract["layers"] for package in layer.split(" | ")]
    assert re.findall(r"^\| `(\w+)` \| .+\. \|$", text_of(ROOT / "CONTRIBUTING.md"), re.MULTILINE) == layers


def test_extras_that_are_named_exist() -> None:
    extras = tomllib.loads(text_of(ROOT / "pyproject.toml"))["project"]["optional-dependencies"]
    sources = [*PAGES, *(ROOT / "vireport").rglob("*.py")]
    named = {name for path in sources for name in re.findall(r"(?:vireport|\.)\[([a-z,]+)\]'", text_of(path))}
    assert {name for names in named for name in names.split(",")} | set(EXTRAS.values()) <= set(extras)
    assert "certify" in named


@pytest.mark.parametrize(("page", "most"), [("README.md", 700), ("CONTRIBUTING.md", 1200)])
def test_what_is_read_first_is_read_in_minutes(page: str, most: int) -> None:
    assert len(words(text_of(ROOT / page))) <= most


def test_the_docs_are_short_and_so_are_their_sentences() -> None:
    texts = [typed(page) for page in DOCS]
    assert sum(len(words(text)) for text in texts) <= 22_000
    paragraphs = [paragraph for text in texts for paragraph in prose(text)]
    assert [paragraph for paragraph in paragraphs if len(words(paragraph)) > 90] == []
    sentences = [sentence for paragraph in paragraphs for sentence in SENTENCE_END.split(paragraph)]
    assert len(sentences) > 1000
    assert sum(len(words(sentence)) > 25 for sentence in sentences) <= 0.05 * len(sentences)
