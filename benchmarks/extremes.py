"""Largest errors of the answers in the catalogue of extreme cases.

python benchmarks/extremes.py
"""

from __future__ import annotations

from record import record

from vireport.extremes.catalogue import run_catalogue, table_data, table_text


def main() -> None:
    """Print and record the catalogue."""
    outcomes = run_catalogue()
    print(table_text(outcomes))
    kept = ("group", "case", "verdict", "error", "bound")
    record("extremes", cases=[{key: case[key] for key in kept} for case in table_data(outcomes)])


if __name__ == "__main__":
    main()
