"""The catalogue of extreme cases: each answered within its bound, or refused with the reason."""

from vireport.extremes.catalogue import exit_status, run_catalogue, table_data, table_text

__all__ = [
    "exit_status",
    "run_catalogue",
    "table_data",
    "table_text",
]
