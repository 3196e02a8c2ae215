"""The catalogue of extreme cases: each answered within its bound, or refused with the reason."""

from vireport.extremes.catalogue import run_catalogue, shortcoming, table_data, table_text

__all__ = [
    "run_catalogue",
    "shortcoming",
    "table_data",
    "table_text",
]
