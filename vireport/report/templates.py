"""Fills the Jinja templates of a report, which gives Typst source.

A user's folder of templates replaces ours file by file. No text gets onto a page as markup: every expression that is
not marked as source becomes a string literal of Typst.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Hashable, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from jinja2 import (
    Environment,
    FileSystemLoader,
    StrictUndefined,
    TemplateError,
    TemplateNotFound,
    TemplateSyntaxError,
)

from vireport.base import RenderError, UsageError
from vireport.gate import range_text
from vireport.membranes import factor_text
from vireport.report.certificates import plus_minus
from vireport.text import (
    bounded,
    capital,
    error_bound,
    exact,
    percent,
    quantity,
    scaled,
    significant,
    span,
    tied,
    words,
)

if TYPE_CHECKING:
    from vireport.figures import Picture
    from vireport.study import Provenance

_PACKAGE = Path(__file__).resolve().parent.parent
TEMPLATES = _PACKAGE / "templates" if (_PACKAGE / "templates").is_dir() else _PACKAGE.parent / "templates"
"""Our own templates: inside an installed package, or at the root of a checkout."""

SECTIONS = "sections"
"""Folder of templates in which the sections are."""

_RICH = re.compile(
    r"\*(?P<symbol>[^*\s][^*]*)\*"
    r"|(?<!\w)(?P<base>[^\W\d_])_(?P<index>[A-Za-z0-9]{1,5})\b"
    r"|(?<=\*)_(?P<suffix>[A-Za-z0-9]{1,5})\b"
)
_BAR = re.compile(r"\|(?=\w)")
JOINED_BAR = "|\u2060"
"""The bar before an absolute value, after which no line may end."""


class AnyReport(Hashable, Protocol):
    """What is set: the object `report` of the templates.

    Attributes
    ----------
    template : str
        The template that the report begins with.
    pictures : mapping of str to Picture
        By their names; a template has each as a file ``name.svg``.
    live : str
        What makes figures of the HTML page live, or "".
    provenance : Provenance
    """

    @property
    def template(self) -> str: ...  # noqa: D102

    @property
    def pictures(self) -> Mapping[str, Picture]: ...  # noqa: D102

    @property
    def live(self) -> str: ...  # noqa: D102

    @property
    def provenance(self) -> Provenance: ...  # noqa: D102


class Source(str):
    """Typst source, as opposed to text."""


def string(text: str) -> Source:
    r"""Write a text as a Typst string literal, in which nothing ends a string or a comment around it.

    Examples
    --------
    >>> print(string('a "b" #c */'))
    "a \"b\" #c *\u{2f}"
    """
    quoted = str(text).replace("\\", "\\\\").replace('"', '\\"')
    return Source('"' + re.sub(r"[\x00-\x1f\x7f/]", lambda match: f"\\u{{{ord(match[0]):x}}}", quoted) + '"')


def rich(text: str) -> Source:
    """Set a text with our own marks: ``*x*`` is a symbol, ``x_c`` has a subscript; numbers are tied to their units.

    Examples
    --------
    >>> print(rich("if *d* or x_c"))
    #"if ";#emph("d");#" or ";#emph("x");#sub("c");
    """
    parts, end = [], 0
    text = _BAR.sub(JOINED_BAR, tied(text))
    for match in _RICH.finditer(text):
        if match.start() > end:
            parts.append(_literal(text[end : match.start()]))
        end = match.end()
        if symbol := match["symbol"] or match["base"]:
            parts.append(f"#emph({string(symbol)});")
        if index := match["index"] or match["suffix"]:
            parts.append(f"#sub({string(index)});")
    return Source("".join([*parts, _literal(text[end:])] if end < len(text) else parts))


def _literal(value: Any) -> str:
    """What an expression in a template becomes: a string that is text, unless it is source."""
    if isinstance(value, Source):
        return value
    text = _BAR.sub(JOINED_BAR, tied(str(value)))
    return f"#{string(text)};" if text else ""


def inert_json(value: Any) -> str:
    r"""Write plain data as JSON that ends no element of a page around it.

    Examples
    --------
    >>> print(inert_json({"a": "</script>"}))
    {"a": "\u003c/script>"}
    """
    return json.dumps(value, allow_nan=False).replace("<", "\\u003c")


FILTERS: dict[str, Callable[..., str]] = {
    "bounded": bounded,
    "capital": capital,
    "error_bound": error_bound,
    "exact": exact,
    "interval": range_text,
    "json": inert_json,
    "percent": percent,
    "plus_minus": plus_minus,
    "power": factor_text,
    "quantity": quantity,
    "rich": rich,
    "scaled": scaled,
    "significant": significant,
    "source": Source,
    "span": lambda ends: span(*ends),
    "string": string,
    "words": words,
}
"""What templates make text of numbers with, and Typst of text."""


@cache
def _environment(templates: Path | None) -> Environment:
    folders = [TEMPLATES] if templates is None else [templates, TEMPLATES]
    environment = Environment(
        loader=_Templates(folders),
        undefined=StrictUndefined,
        optimized=False,  # no template is rendered so often that it pays
        finalize=_literal,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= FILTERS
    return environment


class _Templates(FileSystemLoader):
    """Folders of templates, which say the place where one is not UTF-8."""

    def get_source(self, environment: Environment, template: str) -> Any:
        try:
            return super().get_source(environment, template)
        except UnicodeDecodeError as error:
            line = error.object.count(b"\n", 0, error.start) + 1
            what = f"has the byte 0x{error.object[error.start]:02X}, which is not UTF-8"
            raise TemplateSyntaxError(what, line, template) from error


@lru_cache(maxsize=1)  # one report is set as HTML and as PDF, from the same source
def fill(report: AnyReport, templates: Path | None) -> str:
    """The Typst source of a report.

    Raises
    ------
    UsageError
        If there is no such folder of templates.
    RenderError
        Where a template fails, with the line.
    """
    if templates is not None and not templates.is_dir():
        raise UsageError(f"{templates}: no such folder of templates")
    name = report.template
    try:
        return _environment(templates).get_template(name).render(report=report)
    except TemplateError as error:
        reason = f"no template {error.name!r}" if isinstance(error, TemplateNotFound) else error.message
        raise RenderError(f"{_place(error, name)}: {reason}") from error
    except Exception as error:
        if templates is None:
            raise
        # A user's template is code, and may fail in any way.
        raise RenderError(f"{_place(error, name)}: {type(error).__name__}: {error}") from error


def _place(error: Exception, name: str) -> str:
    """File and line of a mistake in a template: its own, or those of the last template in the traceback."""
    line = getattr(error, "lineno", None)
    if line is not None:
        return f"{getattr(error, 'name', None) or name}:{line}"
    place, trace = name, error.__traceback__
    while trace is not None:
        file = Path(trace.tb_frame.f_code.co_filename)
        if file.suffix == ".j2":
            shown = file.relative_to(file.parents[1]) if file.parent.name == SECTIONS else file.name
            place = f"{shown}:{trace.tb_lineno}"
        trace = trace.tb_next
    return place
