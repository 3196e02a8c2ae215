"""Summaries in Markdown: what is text stays text, and tables are tables to a parser."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from conftest import EXAMPLES
from markdown_it import MarkdownIt
from pages import Page, squeeze

from vireport.cli.app import main
from vireport.report.markdown import fill_markdown
from vireport.text.tables import Table, numbers

PARSER = MarkdownIt("gfm-like", {"linkify": False})


TEXTS = "{{ report.text }}\n\nOf {{ report.text }}\n\n| x |\n| --- |\n| {{ report.text }} |\n"


@pytest.mark.parametrize("text", ["# a", "1. a", "2) a", "- a", "+ a", "*a*", "_a_ `b`", "[a](b)", "a | b", "<i>$x$"])
def test_text_is_no_markup(text: str, tmp_path: Path) -> None:
    (tmp_path / "summary.md.j2").write_text(TEXTS)
    shown = PARSER.render(fill_markdown(SimpleNamespace(template="summary.md.j2", text=text, templates=tmp_path)))
    inert = text.replace("<", "&lt;").replace(">", "&gt;")
    for part in (f"<p>{inert}</p>", f"<p>Of {inert}</p>", f"<td>{inert}</td>"):
        assert part in shown


def test_marks_of_our_own_words_are_set_and_what_is_within_them_is_text(tmp_path: Path) -> None:
    (tmp_path / "summary.md.j2").write_text("{{ report.text | rich }}\n\n{{ report.table | table }}\n")
    text = "1. *d* and *r_top* of **all `a`**, [B1 < 2](point-B1), U_ave, @figure-2 and @a/b"
    rows = Table("Of *d* | <b>", numbers("U_ave"), (("*q* | <i>",),), "Note of *d*")
    report = SimpleNamespace(template="summary.md.j2", text=text, table=rows, templates=tmp_path)
    shown = PARSER.render(fill_markdown(report))
    u_ave = "<em>U</em><sub>ave</sub>"
    said = f"<p>1. <em>d</em> and <em>r_top</em> of <strong>all `a`</strong>, B1 &lt; 2, {u_ave}, figure-2 and @a/b</p>"
    assert said in shown.replace("\u2060", "")
    assert "@a" not in shown
    assert "<p><strong>Of <em>d</em> | &lt;b&gt;</strong></p>" in shown
    assert f'<th style="text-align:right">{u_ave}</th>' in shown
    assert '<td style="text-align:right"><em>q</em> | &lt;i&gt;</td>' in shown
    assert "<p>Note of <em>d</em></p>" in shown


def test_a_summary_has_the_sections_of_the_report(tmp_path: Path) -> None:
    assert main(["run", str(EXAMPLES / "ci/failing.yaml"), "-o", str(tmp_path), "--format", "markdown", "-q"]) == 1
    text = (tmp_path / "summary.md").read_text(encoding="utf-8")
    page = PARSER.render(text)
    assert re.findall("<h2>(.*?)</h2>", page)[1:] == ["Acceptance", "Remarks on the requirements", "Alerts"]
    assert page.count("<table>") == 3
    assert "\n|" not in page
    assert "| Margin to period doubling | ✗ NOT MET | at least 5 % | 1.21 % | −3.79 % | failing.yaml:30 |" in text
    assert "<p><strong>Note VR010: A membrane is pressed in deeper than its radius.</strong>" in page


@pytest.mark.slow
def test_a_summary_says_what_the_page_says(tmp_path: Path) -> None:
    run = ["run", str(EXAMPLES / "ci/failing.yaml"), "-o", str(tmp_path), "--format", "html,markdown", "-q"]
    assert main(run) == 1
    page = Page((tmp_path / "report.html").read_bytes())
    tables = re.findall("<table>.*?</table>", PARSER.render((tmp_path / "summary.md").read_text()), re.DOTALL)
    tiles, requirements, remarks = (Page(tables[k].encode()).all_tables[0] for k in range(3))
    assert requirements.rows == page.tables["Requirements"].rows
    assert remarks.rows == page.tables["Where the values come from"].rows
    said = [squeeze("".join(row)) for row in tiles.rows[1:]]
    shown = squeeze(re.sub("[✓✗!]", "", page.text))  # without the signs of outcomes
    assert len(said) == 4
    assert [fact for fact in said if fact not in shown] == []


def test_templates_of_a_user_reword_it(tmp_path: Path) -> None:
    (tmp_path / "summary.md.j2").write_text("## Ours\n\n**{{ report.verdict.word }}**\n")
    run = ["run", str(EXAMPLES / "design-point.yaml"), "--templates", str(tmp_path), "--format", "markdown", "-q"]
    assert main([*run, "-o", str(tmp_path / "out")]) == 0
    summary = (tmp_path / "out/summary.md").read_text(encoding="utf-8")
    assert summary.startswith("## Ours\n\n**Stable, margin small**\n\n<!-- vireport ")
