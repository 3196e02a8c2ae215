"""Numbers as text, tables of them, and text in Markdown."""

from vireport.text.formatting import (
    ABSENT,
    MINUS,
    MOST_DIGITS,
    PREFIXES,
    TIMES,
    bounded,
    capital,
    error_bound,
    exact,
    percent,
    quantity,
    scaled,
    significant,
    words,
)
from vireport.text.markdown import markdown_table, markdown_text
from vireport.text.tables import Column, Table, broken, html_table, numbers, plain_table, plain_text, texts

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
    "capital",
    "error_bound",
    "exact",
    "html_table",
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
    "words",
]
