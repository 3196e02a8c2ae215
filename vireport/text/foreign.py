"""Text that is not ours: what stands in files and their names, and what libraries say."""

from __future__ import annotations

import re

_PICTOGRAPHS = "\\u2190-\\u2bff\\U0001f000-\\U0001faff"
_JOINS = re.compile(f"[\\u00a0\\u202f]|(?<=[{_PICTOGRAPHS}\\ufe0f])\\u200d(?=[{_PICTOGRAPHS}])")
"""Spaces at which no line ends, and what makes one pictograph of two: Python calls them unprintable."""

LONGEST = 4096
"""Characters that are shown, unless fewer are asked for: any path has fewer."""


def visible(text: str, most: int = LONGEST) -> str:
    r"""Text on one line that a terminal and the log of a CI system take as text, cut where it is long.

    Control characters, line breaks and all that is not printed become escapes, as do the bytes of a file's name that is
    not UTF-8, and the marks of a job's commands (``::error::``, ``##[error]``).

    Examples
    --------
    >>> print(visible("a\x1b[31m\nb"), visible("::error::x"), visible("rather long", 9))
    a\x1b[31m\nb :\x3aerror:\x3ax rather...
    """
    cut = text if len(text) <= most else f"{text[: most - 3]}..."
    if not without_joins(cut).isprintable():
        cut = "".join(map(_escaped, cut))
    return cut.replace("::", ":\\x3a").replace("##[", "#\\x23[")


def without_joins(text: str) -> str:
    r"""Text without the spaces at which no line ends, and what joins pictographs; elsewhere a joiner stays.

    Examples
    --------
    >>> without_joins("5\xa0mm"), len(without_joins("\U0001f469\u200d\U0001f52c")), len(without_joins("a\u200db"))
    ('5mm', 2, 3)
    """
    return _JOINS.sub("", text)


def _escaped(letter: str) -> str:
    if letter.isprintable():
        return letter
    if "\udc80" <= letter <= "\udcff":  # how Python writes a byte that is not UTF-8
        return f"\\x{ord(letter) - 0xDC00:02x}"
    return letter.encode("unicode_escape", "surrogatepass").decode("ascii")


def inert_cell(text: str) -> str:
    """Text of a table that a spreadsheet takes as text, and never as a formula.

    Examples
    --------
    >>> inert_cell("=HYPERLINK(0)"), inert_cell("d = 1")
    ("'=HYPERLINK(0)", 'd = 1')
    """
    return f"'{text}" if text.startswith(("=", "+", "-", "@", "\t", "\r")) else text


def unmarked(text: str) -> str:
    """Text of which nothing but U_ave has a mark of the words of reports: x_c is no subscript and *x* no symbol.

    Examples
    --------
    >>> len(unmarked("x_2.yaml")), unmarked("U_ave of *a*")
    (9, 'U_ave of ∗a∗')
    """
    # A word joiner, which has no width, and another asterisk keep them from that.
    return re.sub(r"(?<!\w)([^\W\d_])_(?!ave\b)", "\\1\u2060_", text.replace("*", "\u2217"))
