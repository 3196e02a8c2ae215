"""Where Jinja templates are looked for, which file and line of one is wrong, and the words that are plain text.

Words are macros: what a verdict, a figure or a table says, in one file for each. A terminal, a notebook and every
page take them from there, so that a user's folder of templates rewords all of these.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any
from zlib import crc32

import jinja2
from jinja2 import (
    Environment,
    FileSystemBytecodeCache,
    FileSystemLoader,
    StrictUndefined,
    TemplateError,
    TemplateNotFound,
    TemplateSyntaxError,
    pass_context,
)
from jinja2.bccache import Bucket

from vireport.base.errors import RenderError
from vireport.text.folders import ROOTS
from vireport.text.formatting import (
    OF_A_MODEL,
    ROUGHLY,
    apart,
    capital,
    error_bound,
    exact,
    measured,
    percent,
    quantity,
    rounded_text,
    span,
    stated_text,
    words,
)
from vireport.text.patterns import Phrase

FILTERS: dict[str, Callable[..., object]] = {
    "apart": apart,
    "capital": capital,
    "error_bound": error_bound,
    "given": stated_text,
    "exact": exact,
    "measured": measured,
    "percent": percent,
    "quantity": quantity,
    "shown": rounded_text,
    "span": lambda ends, error=OF_A_MODEL, power=0: span(ends[0], ends[1], error, power),
}
"""What templates make text of numbers with."""

_BLANKS = re.compile(r"[ \n]+")
"""Spaces and ends of lines, but not spaces that do not break."""


class _Folders(FileSystemLoader):
    """Folders of templates; where one is not UTF-8, the mistake says the line."""

    def get_source(self, environment: Environment, template: str) -> Any:
        try:
            return super().get_source(environment, template)
        except UnicodeDecodeError as error:
            line = error.object.count(b"\n", 0, error.start) + 1
            what = f"has the byte 0x{error.object[error.start]:02X}, which is not UTF-8"
            raise TemplateSyntaxError(what, line, template) from error


class _Compiled(FileSystemBytecodeCache):
    """Templates as an earlier run compiled them, in Jinja's folder of the user among the temporary files.

    To compile them takes a seventh of a report's time. What is read there is of the very text of a template, and of the
    same version of Jinja; where nothing can be read or written, they are compiled.
    """

    def load_bytecode(self, bucket: Bucket) -> None:
        try:
            super().load_bytecode(bucket)
        except Exception:  # of a file that is none of Jinja's
            bucket.reset()

    def dump_bytecode(self, bucket: Bucket) -> None:
        with suppress(OSError):
            super().dump_bytecode(bucket)


def environment_of(
    templates: Path | None, finalize: Callable[[object], str] = str, keep_trailing_newline: bool = False
) -> Environment:
    """How templates are read: from a user's folder first, if there is one, and with every name defined.

    Parameters
    ----------
    templates : Path or None
        The user's folder.
    finalize : callable
        What the value of an expression becomes on the page.
    keep_trailing_newline : bool
        As Jinja has it.
    """

    def phrased(value: object) -> Any:
        return value.words(templates) if isinstance(value, Phrase) else value

    # Given the context, it is called when a template is filled, also for what is constant: compiled templates then
    # depend on none of our code.
    @pass_context
    def written(_: object, value: object) -> str:
        return finalize(phrased(value))

    read_as: dict[str, Any] = {
        "keep_trailing_newline": keep_trailing_newline,
        "trim_blocks": True,
        "lstrip_blocks": True,
        "optimized": False,  # no template is rendered so often that it pays
    }
    compiled = None
    with suppress(OSError, RuntimeError):  # no folder, or not one of this user alone
        compiled = _Compiled(pattern=f"vireport-{crc32(repr((jinja2.__version__, read_as)).encode()):x}-%s.cache")
    environment = Environment(
        loader=_Folders([*([] if templates is None else [templates]), *ROOTS]),
        undefined=StrictUndefined,
        finalize=written,
        bytecode_cache=compiled,
        **read_as,
    )
    environment.filters |= FILTERS | {"words": lambda text: words(phrased(text))}
    environment.globals["roughly"] = ROUGHLY
    return environment


@contextmanager
def mistakes_named(name: str, templates: Path | None) -> Iterator[None]:
    """Name file and line where a template fails while it is filled.

    Parameters
    ----------
    name : str
        The template that is begun with.
    templates : Path or None
        The user's folder, whose templates are code and may fail in any way; ours raise what they raise.

    Raises
    ------
    RenderError
        If one fails.
    """
    try:
        yield
    except RenderError:
        raise  # of words within a page
    except TemplateError as error:
        reason = f"no template {error.name!r}" if isinstance(error, TemplateNotFound) else error.message
        raise RenderError(f"{_place(error, name, templates)}: {reason}") from error
    except Exception as error:
        if templates is None:
            raise
        raise RenderError(f"{_place(error, name, templates)}: {type(error).__name__}: {error}") from error


def _place(error: Exception, name: str, templates: Path | None) -> str:
    """File and line of a mistake in a template: its own, or those of the last template in the traceback."""
    line = getattr(error, "lineno", None)
    if line is not None:
        return f"{getattr(error, 'name', None) or name}:{line}"
    place, trace = name, error.__traceback__
    while trace is not None:
        file = Path(trace.tb_frame.f_code.co_filename)
        if file.suffix == ".j2":
            roots = ROOTS if templates is None else (templates, *ROOTS)
            folder = next(root for root in roots if file.is_relative_to(root))
            place = f"{file.relative_to(folder)}:{trace.tb_lineno}"
        trace = trace.tb_next
    return place


class Words:
    """The words of one file of macros, as plain text on one line.

    What pages set in type may be marked: a symbol, as in ``*x*``, a subscript, as in ``x_c``, what is strong, as in
    ``**x**``, a link, as in ``[text](place)``, and a reference to a figure, as in ``@figure-2``.

    Parameters
    ----------
    name : str
        Of the file: ``opening`` for ``words/opening.j2``, ``figures/device`` for one in a folder.
    templates : Path, optional
        A folder whose templates come before ours.
    """

    def __init__(self, name: str, templates: Path | None = None) -> None:
        self.file, self.templates = f"words/{name}.j2", templates

    def __call__(self, macro: str, *values: object) -> str:
        """What a macro says of what it is given.

        Raises
        ------
        RenderError
            If there is no such macro, or it fails.
        """
        environment = _environment(self.templates)
        with mistakes_named(self.file, self.templates):
            module = environment.get_template(self.file).module
            if not hasattr(module, macro):
                raise RenderError(f"{self.file}: has no macro {macro!r}")
            try:
                text: str = getattr(module, macro)(*values)
            except Exception:
                environment.handle_exception()  # raises it with the template's lines, not those of its code
            return _BLANKS.sub(" ", text).strip(" ")


@cache
def _environment(templates: Path | None) -> Environment:
    return environment_of(templates)
