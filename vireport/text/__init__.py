"""Numbers as text, tables of them, text in Markdown, text that is not ours, and the words of alerts."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.text.alerts import CATALOGUE, AlertCode, Explanation, Sentence, Severity, explanation
from vireport.text.foreign import inert_cell, visible, without_joins
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
    factor_text,
    percent,
    quantity,
    scaled,
    significant,
    span,
    tied,
    words,
    written,
)

if TYPE_CHECKING:
    from vireport.text.tables import (
        Column,
        Table,
        html_table,
        markdown_of,
        markdown_text,
        numbers,
        plain_table,
        plain_text,
        texts,
    )
else:
    __getattr__ = deferred(__name__, "tables")

__all__ = [
    "ABSENT",
    "CATALOGUE",
    "MINUS",
    "MOST_DIGITS",
    "PREFIXES",
    "TIMES",
    "AlertCode",
    "Column",
    "Explanation",
    "Sentence",
    "Severity",
    "Table",
    "bounded",
    "capital",
    "error_bound",
    "exact",
    "explanation",
    "factor_text",
    "html_table",
    "inert_cell",
    "markdown_of",
    "markdown_text",
    "numbers",
    "percent",
    "plain_table",
    "plain_text",
    "quantity",
    "scaled",
    "significant",
    "span",
    "texts",
    "tied",
    "visible",
    "without_joins",
    "words",
    "written",
]
