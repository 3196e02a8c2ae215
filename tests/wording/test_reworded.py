"""A user's words: said wherever the package's own would be, and named with their line where they are wrong."""

from __future__ import annotations

from html import unescape
from pathlib import Path

import pytest

from vireport import analyse, load
from vireport.base.errors import RenderError
from vireport.checks.paper import Agreement, ComparedRow, ComparedTypes, Misprint, PrintedPhase, PrintedQuantity
from vireport.cli.app import main
from vireport.motions.events import Event
from vireport.motions.stability import Stability
from vireport.physics.motion import Symmetry
from vireport.report.templates import fill
from vireport.wording.templates import TEMPLATES, Words

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


def test_a_macro_that_is_not_there_is_named() -> None:
    with pytest.raises(RenderError, match=r"words/opening.j2: has no macro 'none_such'"):
        Words("opening")("none_such")


class Compared:
    """What the section on the paper knows."""

    template = "sections/paper.typ.j2"
    paper_title = "Paper"

    def __init__(self, rows: list[ComparedRow], types: list[ComparedTypes]) -> None:
        self.paper, self.case, self.rows, self.types = self, "inclined", rows, types
        self.misprints = tuple(Misprint)


def test_each_row_of_the_papers_numbers_is_worded() -> None:
    phase = PrintedPhase(Event.PITCHFORK, "C1", "3.66", "top")
    rows = [
        ComparedRow(PrintedQuantity.POINT_PHASE, "C1", "3.66", 3.62, Agreement.DIFFERS, phase=phase, mirrored=True),
        ComparedRow(PrintedQuantity.POINT_D, "C1", "", 0.25, Agreement.NOT_PRINTED),
        ComparedRow(PrintedQuantity.LENGTH, "Fig. 3", "0.69", 0.69, Agreement.TO_ALL_DIGITS, "0.46"),
        ComparedRow(PrintedQuantity.SHARE, "Fig. 3", "0.58", 0.589, Agreement.CUT_OFF, "0.46"),
        ComparedRow(PrintedQuantity.PHASE, "Fig. 3", "0.58", 0.59, Agreement.ROUNDING_OF_D, "0.46"),
    ]
    nodes = (Stability.UNSTABLE_NODE, Stability.STABLE_NODE)
    types = [ComparedTypes(Symmetry.SYMMETRIC, nodes, nodes), ComparedTypes(Symmetry.ASYMMETRIC, nodes, nodes[:1])]
    text = fill(Compared(rows, types), None)
    for part in (
        '#"by 0.04";; phase at the #"top"; impact#" of the mirror image";#"; the paper\'s saddle-node is a pitch',
        "[the paper gives the letter only]",
        '#"to the digits printed";; take _d_, which has more digits]',
        '[#"the print is cut off, not rounded";]',
        '[#"within the rounding of that ";#emph("d");]',
        '[#"differs: the sweep, or grazing, cuts the row";]',
        '[#"agrees";]',
        '#"Figure 2 (g) and (h)"',
    ):
        assert part in text
    assert "Types of motion along the branches" not in fill(Compared(rows, []), None)
