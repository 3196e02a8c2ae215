"""Pages say what is kept of them in `read/`: every sentence, head and number, and the words in figures.

What is kept was read and compared with results.json once; `test_shown.py` compares the numbers of other scenarios.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

import pytest
from conftest import EXAMPLES
from jinja2 import nodes
from msgspec.structs import replace
from pages import KEPT, kept_lines, lines_of, read_back, render_html, tidy, without_numbers
from test_shown import DRAWN, LONG, OPENED, SIMULATED, pictures_of, results_of, search, study_of

from vireport.comparison.comparison import Comparison, compare
from vireport.comparison.figures import compare_pictures
from vireport.comparison.outputs import comparison_provenance, terminal_summary
from vireport.comparison.pages import ComparisonReport
from vireport.figures.curves import simulated_points
from vireport.figures.pictures import pictures
from vireport.figures.style import Sheet, drawn_for
from vireport.optimise import outputs
from vireport.report.context import Report
from vireport.report.markdown import FILTERS as MARKDOWN_FILTERS
from vireport.report.rendering import render_markdown
from vireport.report.templates import FILTERS
from vireport.scenario.loading import load
from vireport.study.plan import Task
from vireport.study.provenance import provenance_of
from vireport.study.study import Study, analyse
from vireport.text.folders import ROOTS
from vireport.text.templates import environment_of

WHOLE = "length swept, with everything"
RUNS = [WHOLE, *(name for name in OPENED if name not in LONG and name != WHOLE)]
SLOW_RUNS = [name for name in OPENED if name in LONG]
EXAMPLE_RUNS: dict[str, tuple[str, dict[str, object]]] = {
    "driven": ("driven", {}),
    "horizontal": ("horizontal", {}),
    "measured-sweep": ("measured-sweep", {}),
    "stiff-membrane, proved and tried": ("stiff-membrane", {"accuracy.repeats": 1}),
    "a free capsule with friction": ("inclined", {"device.capsule": "free", "device.friction": 0.05}),
    "wide tolerances": (
        "inclined",
        {"tolerances.length_percent": 9.0, "tolerances.restitution": 0.08, "tolerances.samples": 64},
    ),
    "a restitution that falls with speed": (
        "design-point",
        {"device.restitution_exponent": -0.1, "device.restitution_speed_m_s": 5.0},
    ),
    "harmonics and other motions": (
        "inclined",
        {
            "excitation.harmonics": [{"order": 2, "percent": 1.3, "phase_deg": 225}],
            "motions.impacts": 3,
            "motions.periods": 1,
            "simulation.samples": 3,
            "simulation.starts": 3,
            "simulation.portraits": [0.61],
        },
    ),
    "a ball on a table": ("bouncing-ball", {"excitation.amplitude_n": 12.0, "sweep.from": 10.0, "sweep.to": 14.0}),
}
"""Runs that say what the scenarios of `test_shown.py` do not."""

COMPARED = WHOLE, "an end that is not followed, and more energy than is lost", "distorted"
"""Of different examples."""


def kept_of(name: str) -> str:
    """The file of a scenario of `test_shown.py`."""
    return f"run, {name}"


def new_of(name: str, said: list[str]) -> list[str]:
    """What a run says that those before it do not, whatever their numbers."""
    every = [*RUNS, *SLOW_RUNS, *EXAMPLE_RUNS]
    before = every[: every.index(name)]
    known = {without_numbers(line) for other in before for line in kept_lines(kept_of(other))}
    return [line for line in dict.fromkeys(said) if without_numbers(line) not in known and re.search("[A-Za-z]", line)]


@pytest.mark.parametrize("name", [*RUNS, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW_RUNS)])
def test_a_run_says_what_is_kept(name: str) -> None:
    study, drawn = study_of(name), pictures_of(name) if name in DRAWN else {}
    said = lines_of(render_html(Report(study, drawn, provenance_of(study.loaded, "vireport run x.yaml"))))
    assert read_back(kept_of(name), said if name == WHOLE else new_of(name, said)) == []


@cache
def study_of_example(name: str) -> Study:
    file, overrides = EXAMPLE_RUNS[name]
    loaded = load(EXAMPLES / f"{file}.yaml", overrides)
    return analyse(loaded, (Task.HTML, *(["certificates"] if "proved" in name else [])))


TIMED = re.compile(r"\d [µm]s\b|good guess|machine|fastest|^\|.*\d")
"""Lines that differ from run to run where run times are measured."""


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLE_RUNS)
def test_a_run_of_an_example_says_what_is_kept(name: str) -> None:
    study = study_of_example(name)
    drawn = {picture.name: picture for picture in pictures(study, simulated_points(study))}
    said = lines_of(render_html(Report(study, drawn, provenance_of(study.loaded, "vireport run x.yaml"))))
    steady = [line for line in new_of(name, said) if study.scenario.accuracy is None or not TIMED.search(line)]
    assert read_back(kept_of(name), steady) == []


@pytest.mark.slow
def test_of_many_families_a_page_says_how_many_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vireport.motions.families.MOST_PRINTED", 1)
    study = study_of("a slow sweep, simulated")
    said = lines_of(render_html(Report(study, {}, provenance_of(study.loaded, "vireport run x.yaml"))))
    assert len(study.atlas.families) == 3
    assert [line[:33] for line in said if "results.json and branches.csv have all" in line] == [
        "Of 3 families 1 are in the tables"
    ]


def test_a_summary_says_what_is_kept() -> None:
    study = study_of(WHOLE)
    report = Report(study, {}, provenance_of(study.loaded, "vireport run x.yaml"), template="summary.md.j2")
    assert read_back("summary", render_markdown(report).decode().splitlines()) == []


def compared(names: Sequence[str]) -> tuple[Comparison, list[str]]:
    both = compare([study_of(name) for name in names])
    with drawn_for(Sheet.of(None)):
        drawn = {picture.name: picture for picture in compare_pictures(both)}
    report = ComparisonReport(both, drawn, comparison_provenance(both, "vireport compare a.yaml b.yaml"))
    return both, lines_of(render_html(report))


def test_a_comparison_says_what_is_kept() -> None:
    both, said = compared(COMPARED)
    assert read_back("comparison", said) == []
    assert read_back("comparison, terminal", terminal_summary(both, tables=True).splitlines()) == []
    margins = {name: results_of(of).data["margin_to_use"] for name, of in zip(both.by_name, COMPARED, strict=True)}
    assert {scenario.name: scenario.to_dict()["margin_to_use"] for scenario in both.ranking} == margins


def test_of_a_design_beside_itself_no_more_voltage_is_told() -> None:
    both = compare([study_of(WHOLE), study_of(WHOLE)])
    assert read_back("comparison, twice the same, terminal", terminal_summary(both).splitlines()) == []


@pytest.mark.slow
@pytest.mark.parametrize("names", [(WHOLE, SIMULATED), (WHOLE, WHOLE)], ids=["other sweeps", "twice the same"])
def test_other_comparisons_say_what_is_kept(names: tuple[str, str], request: pytest.FixtureRequest) -> None:
    known = set(map(without_numbers, kept_lines("comparison")))
    said = map(without_numbers, compared(names)[1])
    lines = [line for line in said if line not in known and re.search(r"[a-z]{2}[.,]? [a-z]{2}", line)]
    assert read_back(f"comparison, {request.node.callspec.id}", lines) == []


def beyond_a_run(said: Sequence[str]) -> list[str]:
    """What stands on a page but not on that of a run, which is kept whole, but for other numbers."""
    known = set(map(without_numbers, kept_lines(kept_of(WHOLE))))
    return [line for line in said if without_numbers(line) not in known]


def test_the_report_on_the_best_design_says_what_is_kept() -> None:
    result = search()
    study = result.best.study
    parts, drawn = outputs.section(result)
    pictures, opens = {picture.name: picture for picture in drawn}, outputs.opening(result, study)
    report = Report(study, pictures, provenance_of(study.loaded, "vireport optimise x.yaml"), None, parts, opens=opens)
    assert read_back("best design", beyond_a_run(lines_of(render_html(report)))) == []
    others = {"yielding": 0.25, "candidates": 12, "elsewhere": 2, "bound": None, "step": 0.0}
    tried = replace(result, evidence=replace(result.evidence, **others))
    assert read_back("best design, other evidence", outputs.text(tried, study, tables=True).splitlines()) == []
    assert read_back("best design, terminal", outputs.text(result, study, tables=True).splitlines()) == []
    tight = replace(result, evidence=replace(result.evidence, bound=result.best.value))
    assert "is better by more than 0.00" in tidy(outputs.text(tight, study, tables=True))  # a bound is rounded upwards


JOINED = re.compile(r'"\s*\n\s*f?"')
"""Where a long text of a test goes on in the next line."""

SET_UP = re.compile(r"\$.*?\$|^\s*#?(let|set|show|import|include|if|metadata)\b.*$", re.DOTALL | re.MULTILINE)
"""What is no text in a template for pages."""

MARKUP = re.compile(r'[][#*_"\\~{}]|^=+ |<[\w-]+>$|@[\w-]+')
"""Between pieces of text in one."""

MARKS = re.compile(r"\||\*+(?:_\w+)?")
"""Between pieces of text in a file of words: bars, and symbols with their indices."""

TEXTS = [
    file
    for root in ROOTS
    for file in sorted(root.rglob("*.j2"))
    if file.name not in ("_page.typ.j2", "_macros.typ.j2", "page.html.j2")
]


@cache
def texts_of_the_tests() -> str:
    kept = [file.read_text(encoding="utf-8") for file in KEPT.glob("*.txt")]
    tests = [JOINED.sub("", file.read_text(encoding="utf-8")) for file in KEPT.parent.rglob("*.py")]
    return alike(" ".join([*kept, *tests]).replace(r"\u00a0", " "))


def alike(text: str) -> str:
    """A text as it is looked for: without numbers and kinds of spaces, quotes and dashes."""
    return without_numbers(tidy(text.replace("’", "'").replace("--", "–")))


def pieces(file: Path) -> Iterator[str]:
    """Texts of two words and more that a template has between its names and its markup."""
    environment, plain = environment_of(None), not file.name.endswith(".typ.j2")
    environment.filters |= MARKDOWN_FILTERS if file.name.endswith(".md.j2") else FILTERS
    for node in environment.parse(file.read_text(encoding="utf-8")).find_all((nodes.TemplateData, nodes.Const)):
        text = node.data if isinstance(node, nodes.TemplateData) else node.value
        for line in (text if plain else SET_UP.sub("\n", text)).split("\n") if isinstance(text, str) else ():
            for part in MARKS.split(line) if plain else MARKUP.split(line):
                if re.search(r"[a-z]{2}\W* [a-z]", part, re.IGNORECASE):
                    yield alike(part)


@pytest.mark.parametrize("file", TEXTS, ids=lambda file: file.stem)
def test_every_sentence_of_a_template_stands_in_a_test(file: Path) -> None:
    """The few that no run here comes to stand in `read/of rarer runs.txt`: their words are held, and not more."""
    assert [piece for piece in pieces(file) if piece not in texts_of_the_tests()] == []
