"""Numbers as text, tables of them, text in Markdown, and text that is not ours."""

from vireport.text.foreign import inert_cell, visible
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
from vireport.text.tables import Column, Table, broken, numbers, plain_table, plain_text, texts

__all__ = [
    "ABSENT",
    "MINUS",
    "MOST_DIGITS",
    "PREFIXES",
    "TIMES",
    "Column",
    "Table",
    "bounded",
    "broken",
    "error_bound",
    "exact",
    "inert_cell",
    "markdown_table",
    "markdown_text",
    "numbers",
    "percent",
    "plain_table",
    "plain_text",
    "quantity",
    "scaled",
    "significant",
    "texts",
    "visible",
    "words",
]
