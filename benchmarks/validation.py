"""What others have published beside what this program computes: the tables of docs/validation.md.

python benchmarks/validation.py
"""

from __future__ import annotations

import sys

from msgspec.structs import asdict
from record import processor_time, record

from vireport.paper.reproduction import reproduce_paper
from vireport.paper.validation import RESULTS, THE_PAPER, ValidationRow, paper_rows, validation_table
from vireport.text.tables import plain_table


def main() -> int:
    rows, sources = list(paper_rows(reproduce_paper())), [asdict(THE_PAPER) | {"seconds": 0.0}]
    misprints = sum(not row.agrees for row in rows)
    for source, results in RESULTS:
        seconds, of_source = processor_time(lambda results=results: list(results()), repeats=1)
        rows += [ValidationRow(source, what, numbers) for what, numbers in of_source]
        sources.append(asdict(source) | {"seconds": seconds})
    table = validation_table(rows)
    print(f"{table.caption}\n\n{plain_table(table)}")
    agreeing = sum(row.agrees for row in rows)
    record("validation", sources=sources, rows=table.rows, agreeing=agreeing, misprints=misprints)
    return agreeing + misprints < len(rows)


if __name__ == "__main__":
    sys.exit(main())
