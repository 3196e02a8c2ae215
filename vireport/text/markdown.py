"""Text and tables in Markdown; what a scenario or a file's name says is text there, and never markup."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from vireport.text.foreign import visible

_MARKS = re.compile(r"([\\`*_\[\]|~$])")
_LINKS = re.compile(r"@(?=\w)|#(?=\d)|:(?=//)|\bwww(?=\.)|\bmailto(?=:)", re.IGNORECASE)
"""What sites like GitHub make a link of, or a message to somebody."""
_ENTITIES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})
_RULES = {"left": "---", "right": "---:"}


def markdown_text(text: str) -> str:
    r"""Plain text on one line, with nothing in it that Markdown or HTML would read as markup, a mention or a link.

    Mentions and bare addresses are kept apart by a word joiner, U+2060, which has no width.

    Examples
    --------
    >>> markdown_text("U_ave < 2 kV")
    'U\\_ave &lt; 2 kV'
    """
    plain = visible(" ".join(text.split()))
    apart = _LINKS.sub(lambda found: f"{found[0]}\u2060", plain)
    return _MARKS.sub(r"\\\1", apart.translate(_ENTITIES))


def markdown_table(head: Sequence[str], align: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells that are Markdown already, its columns aligned ``left`` or ``right``; a newline ends it."""
    lines = [f"| {' | '.join(row)} |" for row in (head, *rows)]
    lines.insert(1, f"|{'|'.join(_RULES[side] for side in align)}|")
    return "\n".join(lines) + "\n"
