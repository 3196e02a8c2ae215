"""Numbers that a person reads are printed by one module: nothing else rounds a result for itself."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE, TEMPLATES = ROOT / "vireport", ROOT / "templates"

ROUNDS = re.compile(r"\.(\d+|\{\w+\}|\{.*\})?[efgEFG%]$|^[efgEFG]$")
"""A format that sets a number of digits."""

OF_INPUTS = "quote an input, or what is allowed"
TELL_NO_RESULT = {
    "text/formatting.py": "print numbers",
    "scenario/": OF_INPUTS,
    "measurement/": f"refuse records: {OF_INPUTS}",
    "findings/driven/driven.py": f"refuse records: {OF_INPUTS}",
    "map/chart/over.py": OF_INPUTS,
    "map/": f"{OF_INPUTS}, memory and times",
    "figures/style.py": OF_INPUTS,
    "figures/layout.py": "ticks at even steps",
    "bench/answers.py": OF_INPUTS,
    "physics/contact.py": OF_INPUTS,
    "physics/device.py": f"refuse devices: {OF_INPUTS}",
    "study/measured.py": OF_INPUTS,
    "study/plan.py": "times that a run takes",
    "cli/outcome.py": "times that a run takes",
    "findings/membranes/compliance.py": "what is being worked at",
    "design/solution.py": OF_INPUTS,
    "design/speed_law.py": OF_INPUTS,
    "motions/": "why a solver has ended",
    "findings/accuracy/methods.py": "why a solver has ended",
    "findings/accuracy/tables.py": "times and counts of docs/accuracy.md",
    "study/checks/paper.py": "compare with as many decimals as are in print",
    "verify/": "name cases by their inputs",
    "optimise/problem.py": "lines to be copied into a scenario",
    "identify/outputs.py": "a file of data",
    "base/records.py": "a record in Python",
}
"""Modules that set digits of numbers, and what for; none of a number that a study comes to."""

MAY_ROUND = re.compile(r"[:.\d}%][efgEFG%](?:\}|\W|$)", re.MULTILINE)
"""What a module has in it that sets digits: others need not be read closely."""

OF_STRING = re.compile(r"%\.?\d*[efg](?!\w)|\{\d?:[^{}]*\.\d+[efg]\}")
"""A format in a string that is filled in later."""


def formats_of(path: Path) -> Iterator[tuple[int, str]]:
    """Line and format of all numbers that a module sets digits of, but for those that it reads back as numbers."""
    text = path.read_text(encoding="utf-8")
    if not MAY_ROUND.search(text):
        return
    tree = ast.parse(text)
    read_back = {
        id(part)
        for call in ast.walk(tree)
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "float"
        for part in ast.walk(call)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr) and id(node) not in read_back:
            for value in node.values:
                if isinstance(value, ast.FormattedValue) and value.format_spec is not None:
                    form = ast.unparse(value.format_spec)[2:-1]
                    if ROUNDS.search(form):
                        yield value.lineno, form
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and (form := OF_STRING.search(node.value)):
            yield node.lineno, form[0]


@pytest.mark.slow
def test_no_module_prints_a_result_with_digits_of_its_own() -> None:
    used, stray = set(), []
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE).as_posix()
        allowed = next((beginning for beginning in TELL_NO_RESULT if name.startswith(beginning)), None)
        found = list(formats_of(path))
        if found and allowed:
            used.add(allowed)
        elif found:
            stray += [f"{name}:{line} {form}" for line, form in found]
    assert not stray, f"print these by vireport.text.formatting: {stray}"
    assert used == {name for name in TELL_NO_RESULT if (PACKAGE / name).exists()}  # an addition may be taken out


@pytest.mark.parametrize("pattern", [r'"%[^"]*[efg]" *\| *format', r"\| *round\b"])
def test_no_template_prints_a_number_with_digits_of_its_own(pattern: str) -> None:
    """A number that is rounded and stays one goes on to a filter of `formatting`."""
    found = [
        f"{path.relative_to(ROOT)}: {match[0]}"
        for folder in (TEMPLATES, PACKAGE)
        for path in sorted(folder.rglob("*.j2"))
        for match in re.finditer(f"{pattern}[^}}]*", path.read_text(encoding="utf-8"))
        if not match[0].endswith("| float -%") and "| float" not in match[0]
    ]
    assert found == []


def test_the_page_of_the_bench_rounds_in_one_module() -> None:
    """Elsewhere what a hand sets is rounded, which then is an input; and places in a drawing."""
    for path in sorted((TEMPLATES / "bench").glob("*.js")):
        if path.name == "elements.js":
            continue
        text = path.read_text(encoding="utf-8")
        rounded = len(re.findall(r"toPrecision|toFixed|toLocaleString", text))
        inputs = len(re.findall(r"Number\((?:[^;]|\n)*?\.toPrecision", text))
        places = len(re.findall(r"scale\.[xy]\([^)]*\)\.toFixed", text))
        assert rounded == inputs + places, path.name
