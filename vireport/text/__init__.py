"""Numbers as text, and text in Markdown."""

from vireport.text.formatting import (
    ABSENT,
    MINUS,
    MOST_DIGITS,
    PREFIXES,
    TIMES,
    bounded,
    error_bound,
    exact,
    percent,
    quantity,
    scaled,
    significant,
    words,
)
from vireport.text.markdown import markdown_table, markdown_text

__all__ = [
    "ABSENT",
    "MINUS",
    "MOST_DIGITS",
    "PREFIXES",
    "TIMES",
    "bounded",
    "error_bound",
    "exact",
    "markdown_table",
    "markdown_text",
    "percent",
    "quantity",
    "scaled",
    "significant",
    "words",
]
