"""Sets a report as PDF and HTML, which Typst makes of one source that Jinja templates give, and a summary as Markdown.

Jinja and Typst are imported where one of these is asked for; figures alone need neither.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterator, Set
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Literal, cast

from vireport.base.errors import RenderError
from vireport.text.folders import TEMPLATES

if TYPE_CHECKING:
    import typst

    from vireport.report.templates import AnyReport

PAPERS = {"a4": "a4", "letter": "us-letter"}
"""Paper of a PDF, by its name on the command line, as Typst names it."""

OFFLINE = dict.fromkeys(("ALL_PROXY", "all_proxy", "HTTPS_PROXY", "https_proxy"), "http://127.0.0.1:1")
OFFLINE |= {"NO_PROXY": "", "no_proxy": ""}
"""Environment in which Typst, which would download packages that a template names, reaches no network."""

_UNUSUAL = re.compile("[^\\x00-\u04ff\u1e00-\u22ff✓✗⟨⟩]")
"""Characters of which it is not known beforehand that the fonts of the PDF have them."""

_MATHS = re.compile(r"<math.*?</math>", re.DOTALL)
_ACCENTS = str.maketrans({"\u0307": "\u02d9", "\u0308": "\u00a8", "\u0304": "\u00af"})
"""Combining characters, which browsers set beside the letter under them, and those with a width of their own."""


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
    report: AnyReport,
    formats: Set[str],
    paper: str = "a4",
    meanwhile: Callable[[], dict[str, bytes]] = dict,
    on_pages: Collection[str] = (),
) -> dict[str, bytes]:
    """Set a report and its figures as files, by their names; `formats` are any of html, pdf, png, svg and figure-pdf.

    Typst sets the PDF while Python draws the other files.

    Parameters
    ----------
    report : AnyReport
    formats : set of str
    paper : str
        A key of `PAPERS`.
    meanwhile : callable
        Makes further files while Typst is at work.
    on_pages : collection of str
        Names of figures that are no files.

    Raises
    ------
    UsageError
        If there is no such folder.
    RenderError
        Where a template fails, with the line.
    """
    files = dict[str, bytes]()
    with _offline(), _styled(report), ThreadPoolExecutor(max_workers=1) as executor:
        # Matplotlib is made for one thread, which is this one: the other takes drawings that are made already.
        vectors = report.pictures if formats & {"html", "pdf", "svg"} else {}
        drawings = {f"{name}.svg": picture.svg for name, picture in vectors.items()}
        source = _filled(report) if formats & {"html", "pdf"} else ""
        pdf = executor.submit(_compiled, report, source, _of_paper(report, paper)) if "pdf" in formats else None
        if "html" in formats:
            files["report.html"] = _page(report, source)
        alone = {name: picture for name, picture in report.pictures.items() if name not in on_pages}
        for name, picture in alone.items():
            if "png" in formats:
                files[f"{name}.png"] = picture.png
            if "figure-pdf" in formats:
                files[f"{name}.pdf"] = picture.pdf
        others = meanwhile()
        if pdf is not None:
            files["report.pdf"] = pdf.result()
    return files | (drawings if "svg" in formats else {}) | others


def _styled(report: AnyReport) -> AbstractContextManager[None]:
    """The look of the figures of a report, so that it is not looked up for each drawing."""
    if not report.pictures:
        return nullcontext()
    from vireport.figures.style import style

    return style()


def _filled(report: AnyReport) -> str:
    from vireport.report.templates import fill

    return fill(report)


def _page(report: AnyReport, source: str) -> bytes:
    page = _compiled(report, source, _of_page(report)).decode("utf-8")
    return _MATHS.sub(lambda match: match[0].translate(_ACCENTS), page).encode("utf-8")


def _of_paper(report: AnyReport, paper: str) -> dict[str, str]:
    """What the template of a PDF reads, by its names: the drawings and the paper."""
    drawings = {f"{name}.svg": picture.printed.decode("utf-8") for name, picture in report.pictures.items()}
    return drawings | {"output": "pdf", "paper": PAPERS[paper]}


def _of_page(report: AnyReport) -> dict[str, str]:
    """What the template of an HTML page reads, by its names: the drawings and their style."""
    inputs = {"output": "html", "paper": ""}
    if not report.pictures:
        return inputs
    from vireport.figures.style import figure_css

    drawings = {f"{name}.page.svg": picture.inline for name, picture in report.pictures.items()}
    return {"figures.css": figure_css(), **drawings, **inputs}


def render_markdown(report: AnyReport) -> bytes:
    """Set a summary as Markdown, for a pull request or the page of a job; see `render_files`."""
    from vireport.report.markdown import fill_markdown

    return fill_markdown(report).encode("utf-8")


def _compiled(report: AnyReport, source: str, inputs: dict[str, str]) -> bytes:
    """Compile a filled template by Typst with what it reads, among it whether the `output` is html or pdf.

    Characters that a PDF's fonts lack become numbers.
    """
    import typst

    output = cast(Literal["html", "pdf"], inputs["output"])
    unusual = "".join(sorted(set(_UNUSUAL.findall(source)))) if output == "pdf" else ""
    lacking = "".join(f"\\u{{{ord(letter):x}}}" for letter in _not_in_fonts(unusual))
    # What a template reads is passed to Typst as it is: no file has to be written that a full disk refuses, or that a
    # process which is killed leaves behind.
    compiler = typst.Compiler(root=TEMPLATES, ignore_system_fonts=True, sys_inputs=inputs | {"lacking": lacking})
    try:
        file = compiler.compile(source.encode("utf-8"), format=output, timestamp=report.provenance.epoch)
    except typst.TypstError as error:
        raise RenderError(_diagnostic(error, report, source)) from error
    if not isinstance(file, bytes):
        raise RenderError(f"{report.template}: no single file came out of it")
    return file


def _not_in_fonts(letters: str) -> list[str]:
    """The characters among some that none of the fonts in use has."""
    if not letters:
        return []
    import typst

    from vireport.report.templates import string

    apart = " ".join(f"#{string(letter)};" for letter in letters)
    head = '#set document(title: "x")\n#set text(font: "Libertinus Serif", lang: "en")\n'
    try:
        # Conformance to PDF/UA is what makes Typst say which ones.
        typst.Compiler(root=TEMPLATES, ignore_system_fonts=True).compile(
            f"{head}{apart}".encode(), format="pdf", pdf_standards=["ua-1"], timestamp=0
        )
    except typst.TypstError as error:
        return [letter for letter in letters if f'the text `"{letter}"`' in error.diagnostic]
    return []


_PLACE = re.compile(r"\S*__typst_py_bytes__\.typ:(\d+):(\d+)")
_EXCERPT = re.compile(r"^ *\d* (?=[│┌])", re.MULTILINE)
"""What stands before an excerpt of the filled page: the number of its line."""


def _diagnostic(error: typst.TypstError, report: AnyReport, source: str) -> str:
    """What Typst says, with templates and their lines instead of those of the filled page; that at fault comes first.

    That is the user's, where one of theirs is among those that lead to the mistake.
    """
    _, _, text = (error.diagnostic.strip() or error.message).rpartition("issues/5512 for more information\n\n")
    text = re.sub(r"failed to download package.*", "packages are not loaded from the network", text)
    text = text.removeprefix("error: ").replace(f"{TEMPLATES}{os.sep}", "")
    places, templates = _template_places(report, source), report.templates
    named = [places(int(line), int(column)) for line, column in _PLACE.findall(text)]
    theirs = [place for place in named if templates and (templates / place.rpartition(":")[0]).is_file()]
    text = _EXCERPT.sub("  ", _PLACE.sub(lambda match: places(int(match[1]), int(match[2])), text))
    head = next(iter([*theirs, *named]), report.template)
    return "\n".join(shorten(line) for line in f"{head}: {text}".splitlines())


def _template_places(report: AnyReport, source: str) -> Callable[[int, int], str]:
    """What gives template and line of a place in a filled page; the template begun with where that is not known."""
    from vireport.report.templates import TemplatePlaces

    try:
        places = TemplatePlaces(report, source)
    except Exception:  # a user's template may fail where texts are marked
        return lambda line, column: report.template
    return lambda line, column: places.at(line, column) or report.template


def shorten(line: str, most: int = 160) -> str:
    """Cut a line of a message to so many characters."""
    return line if len(line) <= most else f"{line[: most - 1]}…"
