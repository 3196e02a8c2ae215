"""Sets a report as PDF and HTML: Jinja templates give one Typst source, of which Typst makes both.

A user's folder of templates replaces ours file by file. No text gets onto a page as markup: every expression that is
not marked as source becomes a string literal of Typst.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Set
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import cache, lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Literal, Protocol

import jinja2
import typst
from jinja2 import (
    Environment,
    FileSystemBytecodeCache,
    FileSystemLoader,
    StrictUndefined,
    TemplateError,
    TemplateNotFound,
    TemplateSyntaxError,
)
from jinja2.bccache import Bucket

from vireport.errors import UsageError, VireportError
from vireport.gate import range_text
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
from vireport.trust import factor_text

if TYPE_CHECKING:
    from vireport.figures import Picture
    from vireport.study import Provenance

_PACKAGE = Path(__file__).resolve().parent.parent
TEMPLATES = _PACKAGE / "templates" if (_PACKAGE / "templates").is_dir() else _PACKAGE.parent / "templates"
"""Our own templates: inside an installed package, or at the root of a checkout."""

PAPERS = {"a4": "a4", "letter": "us-letter"}
"""Paper of a PDF, by its name on the command line, as Typst names it."""

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

OFFLINE = dict.fromkeys(("ALL_PROXY", "all_proxy", "HTTPS_PROXY", "https_proxy"), "http://127.0.0.1:1")
OFFLINE |= {"NO_PROXY": "", "no_proxy": ""}
"""Environment in which Typst, which would download packages that a template names, reaches no network."""

_UNUSUAL = re.compile("[^\\x00-\u04ff\u1e00-\u22ff✓✗⟨⟩]")
"""Characters of which it is not known beforehand that the fonts of the PDF have them."""

_MATHS = re.compile(r"<math.*?</math>", re.DOTALL)
_ACCENTS = str.maketrans({"\u0307": "\u02d9", "\u0308": "\u00a8", "\u0304": "\u00af"})
"""Combining characters, which browsers set beside the letter under them, and those with a width of their own."""


class RenderError(VireportError):
    """A template that cannot be set."""

    @property
    def lines(self) -> tuple[str, ...]:
        """What the library says, with the place that it shows."""
        return tuple(str(self).split("\n"))


class Document(Hashable, Protocol):
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


def render_files(
    report: Document, formats: Set[str], templates: Path | None = None, paper: str = "a4"
) -> dict[str, bytes]:
    """Set a report and its figures as files, by their names; `formats` are any of html, pdf, png and svg.

    Typst works beside Python: at the image of a figure while the next one is drawn, at the PDF while at the page. The
    other parameters and the errors are those of `render_pdf`.
    """
    files, images = dict[str, bytes](), dict[str, Future[bytes]]()
    with _offline(), ThreadPoolExecutor(max_workers=1) as beside:
        # Matplotlib is made for one thread, which is this one.
        drawings = {}
        for name, picture in report.pictures.items():
            drawings[f"{name}.svg"] = picture.svg
            if "png" in formats:
                images[f"{name}.png"] = beside.submit(getattr, picture, "png")
        source = _fill(report, templates) if formats & {"html", "pdf"} else ""
        pdf = beside.submit(_compiled, report, source, "pdf", paper=PAPERS[paper]) if "pdf" in formats else None
        if "html" in formats:
            files["report.html"] = _page(report, source)
        if pdf is not None:
            files["report.pdf"] = pdf.result()
        files |= {name: image.result() for name, image in images.items()}
    return files | (drawings if "svg" in formats else {})


@_offline()
def render_html(report: Document, templates: Path | None = None) -> bytes:
    """Set a report as one HTML file that needs nothing else.

    Parameters
    ----------
    report : Document
    templates : Path, optional
        A folder whose templates come before ours.

    Raises
    ------
    UsageError
        If there is no such folder.
    RenderError
        Where a template fails, with the line.
    """
    return _page(report, _fill(report, templates))


def _page(report: Document, source: str) -> bytes:
    from vireport.figures import in_page

    page = _compiled(report, source, "html").decode("utf-8")
    page = _MATHS.sub(lambda found: found[0].translate(_ACCENTS), page)
    return in_page(page, report.pictures.values(), report.live, TEMPLATES).encode("utf-8")


@_offline()
def render_markdown(report: Document, templates: Path | None = None) -> bytes:
    """Set a summary as Markdown, for a pull request or the page of a job; its parameters are those of `render_html`."""
    from vireport.report.markdown import as_markdown

    return as_markdown(_compiled(report, _fill(report, templates), "html").decode("utf-8")).encode("utf-8")


@_offline()
def render_pdf(
    report: Document, templates: Path | None = None, standards: Iterable[str] = (), paper: str = "a4"
) -> bytes:
    """Set a report as PDF.

    Parameters
    ----------
    report : Document
    templates : Path, optional
        A folder whose templates come before ours.
    standards : iterable of str
        That the PDF has to conform to, e.g. "ua-1".
    paper : str
        A key of `PAPERS`.

    Raises
    ------
    UsageError
        If there is no such folder.
    RenderError
        Where a template fails, with the line.
    """
    return _compiled(report, _fill(report, templates), "pdf", standards, PAPERS[paper])


def _compiled(
    report: Document, source: str, output: Literal["html", "pdf"], standards: Iterable[str] = (), paper: str = ""
) -> bytes:
    """What Typst makes of a filled template; in a PDF, characters that its fonts lack are given by their numbers."""
    unusual = "".join(sorted(set(_UNUSUAL.findall(source)))) if output == "pdf" else ""
    lacking = "".join(f"\\u{{{ord(letter):x}}}" for letter in _not_in_fonts(unusual))
    inputs = {"output": output, "lacking": lacking, "paper": paper}
    with TemporaryDirectory(prefix="vireport-") as root:
        for picture in report.pictures.values():
            (Path(root) / f"{picture.name}.svg").write_bytes(picture.svg)
        compiler = typst.Compiler(root=root, ignore_system_fonts=True, sys_inputs=inputs)
        try:
            file = compiler.compile(
                source.encode("utf-8"),
                format=output,
                pdf_standards=list(standards),  # type: ignore[arg-type]
                timestamp=report.provenance.epoch,
            )
        except typst.TypstError as error:
            raise RenderError(f"{report.template}: {_diagnostic(error, report.template)}") from error
    if not isinstance(file, bytes):
        raise RenderError(f"{report.template}: no single file came out of it")
    return file


def _not_in_fonts(letters: str) -> list[str]:
    """Those of some characters that none of the fonts has which are used."""
    if not letters:
        return []
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
    >>> print(rich("at *d* > x_c"))
    #"at ";#emph("d");#" > ";#emph("x");#sub("c");
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
        bytecode_cache=_Bytecode(str(TEMPLATES / "__pycache__")) if templates is None else None,
        optimized=False,  # no template is rendered so often that it pays
        finalize=_literal,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= FILTERS
    return environment


class _Bytecode(FileSystemBytecodeCache):
    """What our templates are compiled to, kept beside them where and when Python keeps its own bytecode.

    It is valid for the source of a template, for Jinja as it is installed, and for this module, with the environment.
    """

    def get_source_checksum(self, source: str) -> str:
        compilers = (str(os.stat(file).st_mtime_ns) for file in (jinja2.__file__, __file__))
        return super().get_source_checksum("".join((source, *compilers)))

    def dump_bytecode(self, bucket: Bucket) -> None:
        if not sys.dont_write_bytecode:
            with suppress(OSError):
                os.makedirs(self.directory, exist_ok=True)
                super().dump_bytecode(bucket)


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
def _fill(report: Document, templates: Path | None) -> str:
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


def _diagnostic(error: typst.TypstError, template: str) -> str:
    """What Typst says about the filled template, without our temporary folder and the ends of long lines."""
    _, _, text = (error.diagnostic.strip() or error.message).rpartition("issues/5512 for more information\n\n")
    text = re.sub(r"\S*__typst_py_bytes__\.typ", f"{template}, filled", text)
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
        if file.suffix == ".j2":
            shown = file.relative_to(file.parents[1]) if file.parent.name == SECTIONS else file.name
            place = f"{shown}:{trace.tb_lineno}"
        trace = trace.tb_next
    return place
