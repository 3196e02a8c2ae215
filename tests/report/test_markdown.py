"""Summaries in Markdown: what is text in the page stays text, and tables are tables to a parser."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import EXAMPLES
from markdown_it import MarkdownIt

from vireport.cli import main
from vireport.report.markdown import as_markdown

PARSER = MarkdownIt("gfm-like", {"linkify": False})


@pytest.mark.parametrize("text", ["# a", "1. a", "2) a", "- a", "+ a", "*a*", "_a_ `b`", "[a](b)", "a | b", "<i>$x$"])
def test_text_is_no_markup(text: str) -> None:
    inert = text.replace("<", "&lt;")
    page = f"<main><p>{inert}</p><table><tr><th>x</th></tr><tr><td>{inert}</td></tr></table></main>"
    shown = PARSER.render(as_markdown(page))
    assert f"<p>{inert}</p>".replace(">$", "&gt;$") in shown
    assert f"<td>{inert}</td>".replace(">$", "&gt;$") in shown


def test_a_summary_has_the_sections_of_the_report(tmp_path: Path) -> None:
    assert main(["run", str(EXAMPLES / "ci/failing.yaml"), "-o", str(tmp_path), "--format", "markdown", "-q"]) == 1
    text = (tmp_path / "summary.md").read_text(encoding="utf-8")
    page = PARSER.render(text)
    assert re.findall("<h2>(.*?)</h2>", page)[1:] == [
        *("Verdict", "Acceptance", "Remarks on the requirements", "Key numbers", "Alerts")
    ]
    assert page.count("<table>") == 3
    assert "\n|" not in page
    assert "<p><strong>Warning VR010: The membrane model is outside its geometry.</strong>" in page


def test_templates_of_a_user_reword_it(tmp_path: Path) -> None:
    (tmp_path / "summary.typ.j2").write_text('{% include "_page.typ.j2" %}\n= Ours\n*{{ report.verdict.word }}*')
    run = ["run", str(EXAMPLES / "design-point.yaml"), "--templates", str(tmp_path), "--format", "markdown", "-q"]
    assert main([*run, "-o", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out/summary.md").read_bytes() == b"## Ours\n\n**Stable, but outside the membrane model**\n"
