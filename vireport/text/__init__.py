"""Numbers as text."""

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

__all__ = [
    "ABSENT",
    "MINUS",
    "MOST_DIGITS",
    "PREFIXES",
    "TIMES",
    "bounded",
    "error_bound",
    "exact",
    "percent",
    "quantity",
    "scaled",
    "significant",
    "words",
]
