"""Fills the templates of summaries in Markdown, for pull requests and the pages of jobs.

No text gets into one as markup, a mention or a link: every expression that is not marked as source is inert there.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from jinja2 import Environment
from msgspec.structs import replace

from vireport.report.templates import AnyReport, Source, Typesetting, fill_in, marked
from vireport.text.foreign import visible
from vireport.text.tables import Table, markdown_of, markdown_text
from vireport.text.templates import environment_of

_OPENING = re.compile(r"^(\d*)([-+#.)]+)(?=\s|$)")
"""What would begin a list or a heading at the start of a line."""

_BLANK_LINES = re.compile(r"\n{3,}")


def inert(value: object) -> str:
    r"""Write what an expression in a template becomes: text that Markdown does not read as markup, unless it is source.

    Examples
    --------
    >>> print(inert("*a* of 1. b"), inert("1. b"))
    \*a\* of 1. b 1\. b
    """
    return value if isinstance(value, Source) else _begun(_fragment(str(value)))


def rich(text: str) -> Source:
    r"""Write a text with our own marks as Markdown; a summary has neither the figures nor the places of a report.

    Examples
    --------
    >>> print(rich("if *d* of [B1](point-B1) < x_c"))
    if *d* of B1 &lt; *x*<sub>c</sub>
    """
    return Source(_begun(marked(text, MARKDOWN)))


def _begun(text: str) -> str:
    """Markdown at the start of a line, which begins no list and no heading."""
    return _OPENING.sub(r"\1\\\2", text)


def _fragment(text: str) -> str:
    """A part of a sentence, with the spaces at its ends."""
    before, after = (" " if end[:1].isspace() else "" for end in (text, text[::-1]))
    marked = markdown_text(text)
    return f"{before}{marked}{after}" if marked else before


MARKDOWN: Typesetting = Typesetting(
    text=_fragment,
    strong=lambda text: f"**{_fragment(text)}**",
    link=lambda text, place: marked(text, MARKDOWN),
    anchor=lambda text, place: marked(text, MARKDOWN),
    figure=_fragment,
    symbol=lambda text: f"*{_fragment(text)}*",
    index=lambda text: f"<sub>{_fragment(text)}</sub>",
)
"""What the marks of our own words become."""


def code(text: str) -> Source:
    """Write a text as code, between more backticks than it has in a row.

    Examples
    --------
    >>> print(code("run a"), code("run `a`"))
    `run a` `` run `a` ``
    """
    visible_text = visible(" ".join(text.split()))
    most = max(map(len, re.findall("`+", visible_text)), default=0)
    fence, space = "`" * (most + 1), " " if most else ""
    return Source(f"{fence}{space}{visible_text}{space}{fence}")


def table(of: Table, source: str = "") -> Source:
    """Write a table with its caption and its note; lines of the scenario are linked where its address is not ""."""

    def link(text: str, place: str) -> str:
        label, line = marked(text, MARKDOWN), place.removeprefix("line-")
        return f"[{label}]({source}#L{line})" if source and line != place else label

    def written(text: str) -> str:
        return _begun(marked(text, replace(MARKDOWN, link=link)))

    note = f"\n{written(of.note)}\n" if of.note else ""
    return Source(f"{markdown_of(of, written)}{note}")


FILTERS: dict[str, Callable[..., str]] = {"code": code, "rich": rich, "source": Source, "table": table}
"""What templates make Markdown of texts and tables with, beside what all templates do so."""


@cache
def _environment(templates: Path | None) -> Environment:
    environment = environment_of(templates, finalize=inert, keep_trailing_newline=True)
    environment.filters |= FILTERS
    return environment


def fill_markdown(report: AnyReport) -> str:
    """The Markdown of a report whose template is one of a summary.

    Raises
    ------
    UsageError
        If there is no such folder of templates.
    RenderError
        Where a template fails, with the line.
    """
    text = fill_in(_environment, report)
    return f"{_BLANK_LINES.sub(chr(10) * 2, text).strip()}\n"
