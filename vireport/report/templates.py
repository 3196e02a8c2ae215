"""Fills the Jinja templates of a report, which gives Typst source.

A user's folder of templates replaces ours file by file. No text gets onto a page as markup: every expression that is
not marked as source becomes a string literal of Typst.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from jinja2 import Environment
from jinja2.ext import Extension
from jinja2.lexer import Token, TokenStream
from msgspec import Struct

from vireport.base.encoding import json_text
from vireport.base.errors import UsageError
from vireport.study.provenance import Provenance
from vireport.text.enclosed import plus_minus
from vireport.text.formatting import factor_text, tied
from vireport.text.said import BETWEEN
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words, environment_of, mistakes_named

if TYPE_CHECKING:
    from vireport.figures.style import Picture
    from vireport.study.provenance import Provenance


_RICH = re.compile(
    r"\*\*(?P<strong>[^*]+)\*\*"
    r"|\[(?P<text>(?:[^\[\]]|\[[^\[\]]*\])+)\](?:\((?P<place>[\w-]+)\)|\{#(?P<anchor>[\w-]+)\})"
    r"|@(?P<figure>figure-[a-z0-9]+)\b"
    r"|\*(?P<symbol>[^*\s][^*]*)\*"
    r"|(?<!\w)(?P<base>[^\W\d_])_(?P<index>[A-Za-z0-9]{1,6})\b"
    r"|(?<=\*)_(?P<suffix>[A-Za-z0-9]{1,6})\b"
)
_BAR = re.compile(r"\|(?=\w)")
JOINED_BAR = "|\u2060"
"""The bar before an absolute value, after which no line may end."""


class AnyReport(Hashable, Protocol):
    """A report that templates set, under the name `report`.

    Attributes
    ----------
    template : str
        The template that the report begins with.
    pictures : mapping of str to Picture
        By their names; a template has each as ``sys.inputs.at("name.svg")``.
    provenance : Provenance
    templates : Path or None
        A folder whose templates come before ours.
    """

    @property
    def template(self) -> str: ...  # noqa: D102

    @property
    def pictures(self) -> Mapping[str, Picture]: ...  # noqa: D102

    @property
    def provenance(self) -> Provenance: ...  # noqa: D102

    @property
    def templates(self) -> Path | None: ...  # noqa: D102


class Source(str):
    """Source of Typst or of Markdown, as opposed to text."""


def string(text: str) -> Source:
    r"""Write a text as a Typst string literal, in which nothing ends a string or a comment around it.

    Examples
    --------
    >>> print(string('a "b" #c */'))
    "a \"b\" #c *\u{2f}"
    """
    quoted = str(text).replace("\\", "\\\\").replace('"', '\\"')
    return Source('"' + re.sub(r"[\x00-\x1f\x7f/]", lambda match: f"\\u{{{ord(match[0]):x}}}", quoted) + '"')


class Typesetting(Struct, frozen=True):
    """What text and the marks of our own words become in a format.

    Attributes
    ----------
    text, strong, figure, symbol, index : callable
        Of what has no mark, of what is strong, of a figure's name, of a symbol and of its index.
    link : callable
        Of a text with marks, and of the place that it leads to.
    anchor : callable
        Of a text with marks, and of the name of the place that it is.
    """

    text: Callable[[str], str]
    strong: Callable[[str], str]
    link: Callable[[str, str], str]
    anchor: Callable[[str, str], str]
    figure: Callable[[str], str]
    symbol: Callable[[str], str]
    index: Callable[[str], str]


def marked(text: str, marks: Typesetting) -> Source:
    """Set a text with our own marks in some format.

    ``*x*`` is a symbol, ``x_c`` has a subscript, ``**x**`` is strong, ``[text](place)`` leads to a place,
    ``[text]{#place}`` is one, and ``@figure-2`` refers to a figure.
    """
    parts, end = [], 0
    for match in _RICH.finditer(text):
        if match.start() > end:
            parts.append(marks.text(text[end : match.start()]))
        end = match.end()
        if strong := match["strong"]:
            parts.append(marks.strong(strong))
        if place := match["place"]:
            parts.append(marks.link(match["text"], place))
        if anchor := match["anchor"]:
            parts.append(marks.anchor(match["text"], anchor))
        if figure := match["figure"]:
            parts.append(marks.figure(figure))
        if symbol := match["symbol"] or match["base"]:
            parts.append(marks.symbol(symbol))
        if index := match["index"] or match["suffix"]:
            parts.append(marks.index(index))
    return Source("".join([*parts, marks.text(text[end:])] if end < len(text) else parts))


def rich(text: str) -> Source:
    """Set a text with our own marks (`marked`) in Typst; numbers are tied to their units.

    Examples
    --------
    >>> print(rich("if *d* or x_c"), rich("[a[1].yaml](line-3)"))
    #"if ";#emph("d");#" or ";#emph("x");#sub("c"); #to("line-3")[#"a[1].yaml";];
    """
    return marked(_BAR.sub(JOINED_BAR, tied(text)), TYPST)


def _literal(value: object) -> str:
    """What an expression in a template becomes: a string that is text, unless it is source."""
    if isinstance(value, Source):
        return value
    text = _BAR.sub(JOINED_BAR, tied(str(value)))
    return f"#{string(text)};" if text else ""


TYPST = Typesetting(
    text=_literal,
    strong=lambda text: f"#strong({string(text)});",
    link=lambda text, place: f"#to({string(place)})[{rich(text)}];",
    anchor=lambda text, place: f"#anchor({string(place)})[{rich(text)}];",
    figure=lambda name: f"@{name}",
    symbol=lambda text: f"#emph({string(text)});",
    index=lambda text: f"#sub({string(text)});",
)
"""What the marks of our own words become in Typst."""


def inert_json(value: object) -> str:
    r"""Write plain data as JSON that ends no element of a page around it.

    Examples
    --------
    >>> print(inert_json({"a": "</script>"}))
    {"a": "\u003c/script>"}
    """
    return json_text(value).replace("<", "\\u003c")


def made_with(provenance: Provenance, overrides: Sequence[str] | None, templates: Path | None = None) -> Table:
    """Set what made a report, and of what.

    Parameters
    ----------
    provenance : Provenance
    overrides : sequence of str or None
        Values that replaced those of the scenario; None for several scenarios, whose hashes stand above.
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    say = Words("provenance", templates)
    scenario, digest, digests, override, command, python, libraries = say("made_of").split(BETWEEN)
    rows = [("vireport", provenance.version)]
    if overrides is None:
        rows += [(digests, provenance.scenario_sha256)]
    else:
        rows += [(scenario, provenance.scenario_name), (digest, provenance.scenario_sha256)]
        rows += [(override, text) for text in overrides]
    rows += [(command, provenance.command), (python, provenance.python)]
    rows += [(libraries, ", ".join(map(" ".join, provenance.libraries.items())))]
    rows += [("SOURCE_DATE_EPOCH", provenance.timestamp)] if provenance.timestamp else []
    return worded_table(say, "made_with", "tc", rows)


FILTERS: dict[str, Callable[..., object]] = {
    "json": inert_json,
    "made_with": made_with,
    "plus_minus": plus_minus,
    "power": factor_text,
    "rich": rich,
    "source": Source,
    "string": string,
}
"""What templates make text of numbers with, beside what all templates do so, and Typst of text."""


@cache
def _environment(templates: Path | None) -> Environment:
    environment = environment_of(
        templates,
        finalize=_literal,
        keep_trailing_newline=True,
    )
    environment.filters |= FILTERS
    return environment


def fill(report: AnyReport) -> str:
    """The Typst source of a report.

    Raises
    ------
    UsageError
        If there is no such folder of templates.
    RenderError
        Where a template fails, with the line.
    """
    return fill_in(_environment, report)


def fill_in(environment: Callable[[Path | None], Environment], report: AnyReport) -> str:
    """The template of a report with what the report holds.

    Parameters
    ----------
    environment : callable
        How templates are read, given the user's folder.
    report : AnyReport

    Raises
    ------
    UsageError
        If there is no such folder of templates.
    RenderError
        Where a template fails, with the line.
    """
    if report.templates is not None and not report.templates.is_dir():
        raise UsageError(f"{report.templates}: no such folder of templates")
    with mistakes_named(report.template, report.templates):
        return environment(report.templates).get_template(report.template).render(report=report)


class _LineMarks(Extension):
    """Puts before the text of each line of a template of Typst, and before each expression, where it stands."""

    def filter_stream(self, stream: TokenStream) -> Iterator[Token]:
        """The tokens of a template, with the marks."""
        for token in stream:
            if not (stream.name or "").endswith(".typ.j2"):
                yield token
            elif token.type == "data":
                lines = token.value.split("\n")
                marked = (f"{_mark(stream.name, token.lineno + k)}{line}" for k, line in enumerate(lines))
                yield Token(token.lineno, "data", "\n".join(marked))
            else:
                if token.type == "variable_begin":
                    yield Token(token.lineno, "data", _mark(stream.name, token.lineno))
                yield token


_MARK = re.compile("\ue000([^\ue000\ue001]*)\ue001")


def _mark(name: str | None, line: int) -> str:
    return f"\ue000{name}:{line}\ue001"


class TemplatePlaces:
    """Which template, and which line of it, the places of a filled page come from.

    The page is filled once more, with marks, as no page needs them where all is right.

    Parameters
    ----------
    report : AnyReport
    source : str
        The filled page.
    """

    def __init__(self, report: AnyReport, source: str) -> None:
        environment = _environment(report.templates).overlay(extensions=[_LineMarks], bytecode_cache=None)
        marked = environment.get_template(report.template).render(report=report)
        self._starts, self._places, end, length = [0], [report.template], 0, 0
        for match in _MARK.finditer(marked):
            length += match.start() - end
            end = match.end()
            self._starts.append(length)
            self._places.append(match[1])
        # Conditions may depend on texts that are marked: where they do, lines are looked for by what they hold.
        self._lines, self._marked = source.split("\n"), _MARK.sub("", marked).split("\n")

    def at(self, line: int, column: int) -> str:
        """``template:line`` of a line of the filled page, counted from 1, and of a column, from 0; "" if not known."""
        same = line - 1
        if self._marked != self._lines:
            text = self._lines[same]
            alike = [k for k, other in enumerate(self._marked) if other == text]
            before = self._lines[:same].count(text)
            if before >= len(alike):
                return ""
            same = alike[before]
        start = sum(len(text) + 1 for text in self._marked[:same]) + column
        return self._places[bisect_right(self._starts, start) - 1]
