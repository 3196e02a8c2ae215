"""A user's words: said wherever the package's own would be, and named with their line where they are wrong."""

from __future__ import annotations

import json
from html import unescape
from pathlib import Path
from types import SimpleNamespace

import pytest
from conftest import study
from pages import Page

from vireport import analyse, diff, load
from vireport.base.errors import RenderError
from vireport.cli.app import main
from vireport.motions.diagram import TableRow
from vireport.motions.events import Event
from vireport.motions.stability import Stability
from vireport.physics.motion import Symmetry
from vireport.report.changes.diff_outputs import changes_table, diff_text, rerun_text
from vireport.report.printed import misprints_table, numbers_table, types_table
from vireport.study.checks.paper import (
    CASES,
    Agreement,
    ComparedRow,
    ComparedTypes,
    PaperComparison,
    PrintedPhase,
    PrintedQuantity,
)
from vireport.text.folders import TEMPLATES
from vireport.text.requirements import Remark
from vireport.text.templates import Words

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "ci" / "failing.yaml"


def reworded(folder: Path, **changes: tuple[str, str]) -> Path:
    """A folder of words in which something is said in another way."""
    (folder / "words" / "figures").mkdir(parents=True)
    for name, (before, after) in changes.items():
        text = (TEMPLATES / "words" / f"{name}.j2").read_text(encoding="utf-8")
        assert before in text
        (folder / "words" / f"{name}.j2").write_text(text.replace(before, after), encoding="utf-8")
    return folder


@pytest.mark.slow
def test_the_opening_is_reworded_on_the_terminal_and_in_files(tmp_path: Path, capsys) -> None:
    folder = reworded(tmp_path / "own", opening=("starts by itself", "gets going by itself"))
    files = ["--format", "markdown,junit,json", "-o", str(tmp_path / "out")]
    assert main(["run", str(EXAMPLE), "--templates", str(folder), *files]) == 1
    said = capsys.readouterr().out
    for text in (said, (tmp_path / "out" / "junit.xml").read_text()):
        assert "It runs, and gets going by itself, but does not meet" in text
        assert "starts by itself" not in text
    assert analyse(load(EXAMPLE)).opening.worded(folder).sentence in said.splitlines()


@pytest.mark.slow
def test_the_facts_the_word_and_captions_are_reworded(tmp_path: Path) -> None:
    folder = reworded(
        tmp_path / "own",
        opening=("Requirements not met, ", "Not as required, "),
        **{"figures/sweep": ("Stable 1:1 motion for", "Steady for")},
    )
    text = (folder / "words" / "opening.j2").read_text()
    before = "{% macro word(verdict) %}{{ verdict.word }}"
    assert before in text
    (folder / "words" / "opening.j2").write_text(text.replace(before, f"{before}, in our words"))
    files = ["--format", "html,markdown,svg", "-o", str(tmp_path / "out"), "-q"]
    assert main(["run", str(EXAMPLE), "--templates", str(folder), *files]) == 1
    page, summary, figure = ((tmp_path / "out" / x).read_text() for x in ("report.html", "summary.md", "figure-2.svg"))
    for text in (page, summary):
        assert "Not as required, 4 of 9: " in text
        assert "Requirements not met, in our words" in text
    for text in (page, figure):
        assert "Steady for 0.629 m < s" in unescape(text).replace("\u00a0", " ")


@pytest.mark.slow
def test_a_comparison_is_reworded_on_the_terminal_on_its_page_and_in_its_data(tmp_path: Path, capsys) -> None:
    folder = reworded(
        tmp_path / "own",
        compare=("{% macro lacks_not_met() %}requirements missed", "{% macro lacks_not_met() %}not as required"),
        changes=("({{ share }} apart)", "(they differ by {{ share }})"),
        quantities=("highest U_ave", "greatest U_ave"),
    )
    text = (folder / "words" / "compare.j2").read_text()
    for before, after in (
        ("Ranking, the best first", "The best first"),
        ("quantities differ", "numbers are not alike"),
        ("All scenarios on one axis", "All of them on one axis"),
        ("A dash: ", "No number: "),
    ):
        assert before in text
        text = text.replace(before, after)
    (folder / "words" / "compare.j2").write_text(text)
    scenarios = [str(EXAMPLE), str(EXAMPLE.parents[1] / "design-point.yaml"), str(EXAMPLE.parents[1] / "inclined.yaml")]
    files = ["--format", "html,json,markdown", "-o", str(tmp_path / "out"), "-v"]
    assert main(["compare", *scenarios, "--templates", str(folder), *files]) == 0
    terminal = capsys.readouterr().out
    page, summary, data = (
        unescape((tmp_path / "out" / name).read_text()) for name in ("report.html", "summary.md", "compare.json")
    )
    for text in (terminal, page, summary):
        assert "The best first" in text
        assert "Not as required" in text
        assert "Ranking, the best first" not in text
        assert "equirements missed: failing" not in text
    assert "numbers are not alike:" in terminal
    assert "All of them on one axis" in page
    assert "No number: " in page
    said = [row["sentence"] for row in json.loads(data)["quantities"] if row["differs"]]
    assert any(" (they differ by " in sentence for sentence in said)
    assert any(sentence.startswith("Greatest U_ave over the stable range: ") for sentence in said)
    quantities = Page((tmp_path / "out" / "report.html").read_bytes()).text
    assert "Greatest U" in quantities
    assert "Highest U" not in quantities
    names = [row["quantity"] for row in json.loads(data)["quantities"]]
    assert "highest U_ave over the stable range" in names  # by which other programs find it
    assert not any(" apart)" in sentence for sentence in said)
    assert set(said) <= set(terminal.splitlines())


def test_changes_are_reworded_as_text_and_as_a_table(tmp_path: Path) -> None:
    folder = reworded(
        tmp_path, changes=("{{ count }} changes since {{ baseline }}", "{{ count }} news of {{ baseline }}")
    )
    text = (folder / "words" / "changes.j2").read_text()
    (folder / "words" / "changes.j2").write_text(
        text.replace(": gone, was ", ": no more, once ").replace("Now", "Today")
    )
    changed = diff(study("design-point").to_dict(), study("design-point", "device.length_m=0.6"))
    text = (
        (TEMPLATES / "words" / "quantities.j2")
        .read_text()
        .replace("margin from the design point", "margin of the design")
    )
    (folder / "words" / "quantities.j2").write_text(text)
    table = changes_table(changed, templates=folder)
    lines = diff_text(changed, "old.json", folder).splitlines()
    assert lines[0] == f"{len(changed)} news of old.json:"
    assert table.caption == f"{len(changed)} news of the baseline"
    assert [column.title for column in table.columns] == ["Group", "What", "Before", "Today", "Change"]
    assert [line for line in lines if ": no more, once " in line]
    assert [line for line in lines if line.startswith("  margin: margin of the design to the ")]
    assert [row for row in table.rows if row[1].startswith("margin of the design to the ")]
    assert not [row for row in table.rows if row[1].startswith("margin from the design point to the ")]
    assert [row for row in changed if row.quantity.startswith("margin from the design point to the ")]
    assert ": gone, was " in diff_text(changed)


def test_an_earlier_run_that_is_not_the_same_is_reworded(tmp_path: Path) -> None:
    folder = reworded(tmp_path, changes=("not identical to the results in", "unlike the results in"))
    before, now = study("design-point").to_dict(), study("design-point")
    before["design_point"]["q"][0] += 0.25
    assert rerun_text(before, now, "old.json", folder) == "unlike the results in old.json: 1 value (design_point.q[0])"
    before["design_point"]["u_ave_v"] = [u + 1 for u in before["design_point"]["u_ave_v"]]
    first, count, *_ = rerun_text(before, now, "old.json").splitlines()
    values = len(now.to_dict()["design_point"]["u_ave_v"]) + 1
    assert first.startswith(
        f"not identical to the results in old.json: {values} values (design_point.q[0], design_point"
    )
    assert count == "1 change since old.json:"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{% macro word(verdict) %}\n{{ verdict.nothing }}{% endmacro %}", "words/opening.j2:2: "),
        ("\n{% macro %}", "words/opening.j2:2: "),
        ("a", "words/opening.j2: has no macro 'word'"),
        ("{% macro word(verdict) %}{{ 1 / 0 }}{% endmacro %}", "words/opening.j2:1: ZeroDivisionError: "),
        (b"\n\n\xff", "words/opening.j2:3: has the byte 0xFF"),
    ],
)
def test_words_that_fail_are_named_with_their_line_and_nothing_is_written(
    text: str | bytes, message: str, tmp_path: Path, capsys
) -> None:
    (tmp_path / "words").mkdir()
    (tmp_path / "words" / "opening.j2").write_bytes(text if isinstance(text, bytes) else text.encode())
    if isinstance(text, str) and "verdict.nothing" in text:
        ours = (TEMPLATES / "words" / "opening.j2").read_text(encoding="utf-8")
        (tmp_path / "words" / "opening.j2").write_text(f"{text}{ours.replace('macro word(', 'macro _word(')}")
    out = tmp_path / "out"
    assert main(["run", str(EXAMPLE), "--templates", str(tmp_path), "-o", str(out), "--format", "html"]) == 3
    assert capsys.readouterr().err.startswith(f"vireport: error: {message}")
    assert not out.exists()


PATTERNS = {
    "alerts": {"VR005.title": "Close to its end", "VR005.remedy": "Leave more room.", "cause": "{sentences:; }"},
    "requirements": {
        "deflection_at_most_m": "Dent",
        "end": "at {place} there is {event}",
        "some_are_not_met": "{count} of {total} missed: {unmet: and }",
    },
}


def with_patterns(folder: Path, **files: object) -> Path:
    """A folder of words with patterns."""
    (folder / "words").mkdir(parents=True)
    for name, patterns in files.items():
        text = patterns if isinstance(patterns, str) else json.dumps(patterns)
        (folder / "words" / f"{name}.json").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.slow
def test_requirements_and_alerts_are_reworded_but_for_data(tmp_path: Path, capsys) -> None:
    folder, out = with_patterns(tmp_path / "own", **PATTERNS), tmp_path / "out"
    formats = ["--format", "html,markdown,json,github", "-o", str(out)]
    assert main(["run", str(EXAMPLE), "--templates", str(folder), *formats]) == 1
    said = capsys.readouterr()
    assert "; Dent.\n" in said.err
    page, summary = Page((out / "report.html").read_bytes()).text, (out / "summary.md").read_text()
    for text in (page, summary.replace("*", "")):
        text = text.replace("\u00a0", " ")
        assert "Requirements not met, 4 of 9: " in text
        assert "; Dent." in text
        assert "At f = 1.98 Hz there is period doubling B1" in text
        assert "VR005: Close to its end." in text
        assert "Leave more room." in text
    data = json.loads((out / "results.json").read_text())
    assert data["alerts"][0]["title"] == "The design point is near the end of stable motion"
    whys = [line["why"] for line in data["requirements"]["criteria"]]
    assert whys.count("period doubling B1 at frequency_hz = 1.98") == 2
    assert main(["run", str(EXAMPLE), "--templates", str(folder), "--format", "markdown", "-o", str(out), "-q"]) == 1
    assert "4 of 9 missed: Stable 1:1 motion over the inclinations (from 40 to 50 deg) and " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("patterns", "message"),
    [
        ({"dent": "Dent"}, "dent: is the name of no pattern"),
        ({"end": "at {place}"}, "end: must be a text whose places are: {event}, {place}"),
        ({"end": "at {place} {event} {again}"}, "end: must be a text whose places are: {event}, {place}"),
        ({"no_end": 3}, "no_end: must be a text whose places are: none"),
        ({"no_end": "}"}, "no_end: Single '}' encountered in format string"),
        ({"end": "{event:given} at {place}"}, "end: Invalid format specifier 'given'"),
        ('{\n"end": "a",\n}', "Expecting property name enclosed in double quotes: line 3 column 1"),
        ("[]", "is not an object that has a pattern by each name"),
    ],
)
def test_patterns_that_fail_are_named(patterns: object, message: str, tmp_path: Path) -> None:
    folder = with_patterns(tmp_path, requirements=patterns)
    said = Remark.END.said(event="grazing", place="here")
    with pytest.raises(RenderError) as refused:
        said.words(folder)
    assert str(refused.value).startswith("words/requirements.json: " + message)
    assert str(said) == "grazing at here"


def test_a_pattern_that_fails_leaves_no_report(tmp_path: Path, capsys) -> None:
    folder, out = with_patterns(tmp_path / "own", alerts={"VR005.titel": "Near"}), tmp_path / "out"
    assert main(["run", str(EXAMPLE), "--templates", str(folder), "-o", str(out), "--format", "markdown"]) == 3
    assert "error: words/alerts.json: VR005.titel: is the name of no pattern" in capsys.readouterr().err
    assert not out.exists()


def test_changed_patterns_are_read_again(tmp_path: Path) -> None:
    folder, said = with_patterns(tmp_path, requirements={"no_end": "never"}), Remark.NO_END.said()
    assert said.words(folder) == "never"
    (folder / "words" / "requirements.json").write_text("{}")
    assert said.words(folder) == "none in any input"


def test_a_macro_that_is_not_there_is_named() -> None:
    with pytest.raises(RenderError, match=r"words/opening.j2: has no macro 'none_such'"):
        Words("opening")("none_such")


def test_each_row_of_the_papers_numbers_is_worded() -> None:
    phase = PrintedPhase(Event.PITCHFORK, "C1", "3.66", "top")
    rows = (
        ComparedRow(PrintedQuantity.POINT_PHASE, "C1", "3.66", 3.62, Agreement.DIFFERS, phase=phase, mirrored=True),
        ComparedRow(PrintedQuantity.POINT_D, "C1", "", 0.25, Agreement.NOT_PRINTED),
        ComparedRow(PrintedQuantity.LENGTH, "Fig. 3", "0.69", 0.69, Agreement.TO_ALL_DIGITS, "0.46"),
        ComparedRow(PrintedQuantity.SHARE, "Fig. 3", "0.58", 0.589, Agreement.CUT_OFF, "0.46"),
        ComparedRow(PrintedQuantity.PHASE, "Fig. 3", "0.58", 0.59, Agreement.ROUNDING_OF_D, "0.46"),
    )
    inclined = CASES[1]
    table = numbers_table([PaperComparison(inclined, rows, ())])
    assert [row[0] for row in table.rows] == [
        "C1 of Fig. 2(d)–(f): φ",
        "C1 of Fig. 2(d)–(f): d",
        "Fig. 3, d = 0.46: s [m]",
        "Fig. 3, d = 0.46: q",
        "Fig. 3, d = 0.46: φ",
    ]
    assert [row[1:3] for row in table.rows] == [
        ("3.66", "3.62"), ("—", "0.25"), ("0.69", "0.69"), ("0.58", "0.589"), ("0.58", "0.59"),
    ]  # fmt: skip
    assert [row[3:] for row in table.rows] == [
        (
            "differs",
            "by 0.04; phase at the top impact of the mirror image; the paper's saddle-node is a pitchfork",
        ),
        ("", "the paper gives the letter only"),
        ("agrees", "to the digits printed; take *d*, which has more digits"),
        ("agrees", "the print is cut off, not rounded"),
        ("agrees", "within the rounding of that *d*"),
    ]


def interval(start: str, end: str, stability: Stability) -> TableRow:
    ends = (SimpleNamespace(label=label) if label else None for label in (start, end))
    return TableRow(Symmetry.ASYMMETRIC, 1, *ends, stability, 0.2, 0.3, 0.4, 0.5, 0, 1)


def test_the_intervals_of_table_1_are_worded() -> None:
    unstable, node, focus = Stability.UNSTABLE_NODE, Stability.STABLE_NODE, Stability.STABLE_FOCUS
    rows = interval("", "B1", unstable), interval("B1", "A1", node), interval("A1", "", node), interval("", "", node)
    types = ComparedTypes(Symmetry.ASYMMETRIC, (unstable, node, focus, node, focus), rows)
    assert not types.agrees
    table = types_table([PaperComparison(CASES[2], (), (types,))])
    cut = "differs: the sweep, or grazing, cuts the row"
    assert [row[1:] for row in table.rows] == [
        ("*d* < B1", "0.2", "0.3", "unstable node", "unstable node", "agrees"),
        ("B1 < *d* < A1", "0.2", "0.3", "stable node", "stable node", "agrees"),
        ("*d* > A1", "0.2", "0.3", "stable focus", "stable node", cut),
        ("throughout", "0.2", "0.3", "stable node", "stable node", "agrees"),
        ("—", "—", "—", "stable focus", "—", cut),
    ]
    assert {row[0] for row in table.rows} == {"Asymmetric, Fig. 2(g)–(i)"}


def test_slips_of_the_papers_text_are_worded_once_and_where_they_belong() -> None:
    none = [PaperComparison(case, (), ()) for case in CASES]
    assert [row[0] for row in misprints_table(none).rows] == [
        "(3.10)", "Section 4, Im *λ*", "Table 1; caption of Fig. 4", "Section 4, C1", "Section 3, period 4",
    ]  # fmt: skip
    assert [row[1:3] for row in misprints_table(none[2:]).rows][-1] == ("Figure 2 (g) and (h)", "Figure 3 (g) and (h)")
    assert len(misprints_table(none[1:2]).rows) == 3
