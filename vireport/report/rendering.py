"""Sets a report model as HTML and as PDF, through Jinja templates; knows nothing of what the report says.

A user's folder of templates replaces ours file by file. Nothing unescaped gets onto a page: HTML is escaped
by Jinja, and for Typst every expression that is not marked as source becomes a string literal.
"""

from __future__ import annotations

import os
import re
from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import typst
from jinja2 import (
    Environment,
    FileSystemLoader,
    StrictUndefined,
    TemplateError,
    TemplateNotFound,
    TemplateSyntaxError,
)
from markupsafe import Markup, escape

from vireport.errors import UsageError, VireportError
from vireport.report.pages import Figure, ReportModel

_PACKAGE = Path(__file__).resolve().parent.parent
TEMPLATES = _PACKAGE / "templates" if (_PACKAGE / "templates").is_dir() else _PACKAGE.parent / "templates"
"""Our own templates, with equations.json and math.woff2: inside an installed package, or at the root of a checkout."""

HTML, PDF = "report.html.j2", "report.typ.j2"

_RICH = re.compile(
    r"\*(?P<symbol>[^*\s][^*]*)\*"
    r"|(?<!\w)(?P<base>[^\W\d_])_(?P<index>[A-Za-z0-9]{1,5})\b"
    r"|(?<=\*)_(?P<suffix>[A-Za-z0-9]{1,5})\b"
)
_TIED = re.compile(r"(?<=\d) (?=(?:%|×|[nµmkMG]?(?:m|V|N|g|Hz|s|m/s)(?!\w)))|(?<=×) (?=10)")
"""Spaces at which no line may end."""


OFFLINE = dict.fromkeys(("ALL_PROXY", "all_proxy", "HTTPS_PROXY", "https_proxy"), "http://127.0.0.1:1")
OFFLINE |= {"NO_PROXY": "", "no_proxy": ""}
"""Environment in which Typst, which would download packages that a template names, reaches no network."""

_UNUSUAL = re.compile("[^\\x00-\u04ff\u1e00-\u22ff]")
"""Characters of which it is not known beforehand that the fonts of the PDF have them."""


class RenderError(VireportError):
    """A template that cannot be set."""

    @property
    def lines(self) -> tuple[str, ...]:
        """What the library says, with the place that it shows."""
        return tuple(str(self).split("\n"))


class Source(str):
    """Typst source, as opposed to text."""


def render_html(model: ReportModel, templates: Path | None = None) -> bytes:
    """Set a report as one HTML file that needs nothing else.

    Parameters
    ----------
    model : ReportModel
    templates : Path, optional
        A folder whose templates come before ours.

    Raises
    ------
    RenderError
        Where a template fails, with the line.
    """
    from vireport.figures import in_page

    page = _fill(_html_environment(_folder(templates)), HTML, model)
    return in_page(page, model.pictures, model.live, TEMPLATES).encode("utf-8")


def render_pdf(model: ReportModel, templates: Path | None = None, standards: Iterable[str] = ()) -> bytes:
    """Set a report as PDF.

    Parameters
    ----------
    model : ReportModel
    templates : Path, optional
        A folder whose templates come before ours.
    standards : iterable of str
        That the PDF has to conform to, e.g. "ua-1".

    Raises
    ------
    RenderError
        Where a template fails, with the line.
    """
    source = _fill(_typst_environment(_folder(templates)), PDF, model)
    if unusual := "".join(sorted(set(_UNUSUAL.findall(source)))):
        lacking = [f"\\u{{{ord(letter):x}}}" for letter in _not_in_fonts(unusual)]
        source = _fill(_typst_environment(_folder(templates)), PDF, model, lacking=lacking)
    with _offline(), TemporaryDirectory(prefix="vireport-") as root:
        for section in model.sections:
            for block in section.blocks:
                if isinstance(block, Figure):
                    (Path(root) / f"{block.name}.svg").write_bytes(block.svg)
        compiler = typst.Compiler(root=root, ignore_system_fonts=True)
        try:
            pdf = compiler.compile(
                source.encode("utf-8"),
                format="pdf",
                pdf_standards=list(standards),  # type: ignore[arg-type]
                timestamp=model.provenance.epoch,
            )
        except typst.TypstError as error:
            raise RenderError(f"{PDF}: {_diagnostic(error)}") from error
    if not isinstance(pdf, bytes):
        raise RenderError(f"{PDF}: no single file came out of it")
    return pdf


def _not_in_fonts(letters: str) -> list[str]:
    """Those of some characters that none of the fonts has which are used."""
    apart = " ".join(f"#{string(letter)};" for letter in letters)
    head = '#set document(title: "x")\n#set text(font: "Libertinus Serif", lang: "en")\n'
    try:
        # Conformance to PDF/UA is what makes Typst say which ones.
        typst.Compiler(ignore_system_fonts=True).compile(
            f"{head}{apart}".encode(), format="pdf", pdf_standards=["ua-1"], timestamp=0
        )
    except typst.TypstError as error:
        return [letter for letter in letters if f'the text `"{letter}"`' in error.diagnostic]
    return []


@contextmanager
def _offline() -> Iterator[None]:
    """Keep the network out of reach for as long as Typst is at work."""
    before = {name: os.environ.get(name) for name in OFFLINE}
    os.environ.update(OFFLINE)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def pieces(text: str) -> Iterator[tuple[str, str]]:
    """Split a text into plain stretches, symbols and subscripts, with numbers tied to their units.

    Examples
    --------
    >>> list(pieces("at *d* > x_c"))
    [('plain', 'at '), ('symbol', 'd'), ('plain', ' > '), ('symbol', 'x'), ('sub', 'c')]
    """
    text = _TIED.sub("\u00a0", text)
    end = 0
    for match in _RICH.finditer(text):
        if match.start() > end:
            yield "plain", text[end : match.start()]
        end = match.end()
        if match["suffix"]:
            yield "sub", match["suffix"]
            continue
        yield "symbol", match["symbol"] or match["base"]
        if match["index"]:
            yield "sub", match["index"]
    if end < len(text):
        yield "plain", text[end:]


def string(text: str) -> Source:
    r"""Write a text as a Typst string literal.

    Examples
    --------
    >>> print(string('a "b" #c'))
    "a \"b\" #c"
    """
    quoted = text.replace("\\", "\\\\").replace('"', '\\"')
    return Source('"' + re.sub(r"[\x00-\x1f\x7f]", lambda match: f"\\u{{{ord(match[0]):x}}}", quoted) + '"')


def _folder(templates: Path | None) -> Path | None:
    if templates is not None and not templates.is_dir():
        raise UsageError(f"{templates}: no such folder of templates")
    return templates


def _environment(templates: Path | None, **options: Any) -> Environment:
    return Environment(
        loader=_loader(templates), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, **options
    )


@cache
def _loader(templates: Path | None) -> _Templates:
    return _Templates([TEMPLATES] if templates is None else [templates, TEMPLATES])


class _Templates(FileSystemLoader):
    """Folders of templates, which say the place where one is not UTF-8."""

    def get_source(self, environment: Environment, template: str) -> Any:
        try:
            return super().get_source(environment, template)
        except UnicodeDecodeError as error:
            line = error.object.count(b"\n", 0, error.start) + 1
            what = f"has the byte 0x{error.object[error.start]:02X}, which is not UTF-8"
            raise TemplateSyntaxError(what, line, template) from error


@cache
def _html_environment(templates: Path | None) -> Environment:
    environment = _environment(templates, autoescape=True)
    environment.filters |= {"rich": _rich_html, "base64": _base64, "markup": Markup}
    environment.globals["math_font"] = _base64((TEMPLATES / "math.woff2").read_bytes())
    return environment


@cache
def _typst_environment(templates: Path | None) -> Environment:
    environment = _environment(templates, finalize=_literal)
    environment.filters |= {"rich": _rich_typst, "string": string, "source": Source}
    return environment


def _literal(value: Any) -> str:
    """What an expression in a Typst template becomes: a string that is text, unless it is source."""
    return value if isinstance(value, Source) else f"#{string(str(value))};"


def _base64(data: bytes) -> str:
    return b64encode(data).decode("ascii")


def _rich_html(text: str) -> Markup:
    tags = {"symbol": "<i>{}</i>", "sub": "<sub>{}</sub>", "plain": "{}"}
    return Markup("".join(tags[style].format(escape(part)) for style, part in pieces(text)))


def _rich_typst(text: str) -> Source:
    calls = {"symbol": "#emph({});", "sub": "#sub({});", "plain": "#{};"}
    return Source("".join(calls[style].format(string(part)) for style, part in pieces(text)))


def _fill(environment: Environment, name: str, model: ReportModel, lacking: Sequence[str] = ()) -> str:
    try:
        return environment.get_template(name).render(report=model, lacking=lacking)
    except TemplateError as error:
        reason = f"no template {error.name!r}" if isinstance(error, TemplateNotFound) else error.message
        raise RenderError(f"{_place(error, name)}: {reason}") from error
    except Exception as error:
        if environment.loader is _loader(None):
            raise
        # A user's template is code, and may fail in any way.
        raise RenderError(f"{_place(error, name)}: {type(error).__name__}: {error}") from error


def _diagnostic(error: typst.TypstError) -> str:
    """What Typst says about the filled template, without our temporary folder and the ends of long lines."""
    text = re.sub(r"\S*__typst_py_bytes__\.typ", f"{PDF}, filled", error.diagnostic.strip() or error.message)
    text = re.sub(r"[^\s(]*/vireport-\w+/", "", text)
    text = re.sub(r"failed to download package.*", "packages are not loaded from the network", text)
    return "\n".join(shorten(line) for line in text.splitlines())


def shorten(line: str, most: int = 160) -> str:
    """Cut a line of a message."""
    return line if len(line) <= most else f"{line[: most - 1]}…"


def _place(error: Exception, name: str) -> str:
    """File and line of a mistake in a template: its own, or those of the last template in the traceback."""
    line = getattr(error, "lineno", None)
    if line is not None:
        return f"{getattr(error, 'name', None) or name}:{line}"
    place, trace = name, error.__traceback__
    while trace is not None:
        file = Path(trace.tb_frame.f_code.co_filename)
        if file.suffix not in (".py", "") or file.name == name:
            place = f"{file.name}:{trace.tb_lineno}"
        trace = trace.tb_next
    return place
