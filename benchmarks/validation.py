"""What others have published beside what this program computes: the tables of docs/validation.md.

python benchmarks/validation.py
"""

from __future__ import annotations

import sys

from msgspec.structs import asdict
from record import processor_time, record

from vireport.paper.validation import RESULTS, ValidationRow, validation_table
from vireport.text.tables import plain_table


def main() -> int:
    rows, sources = [], []
    for source, results in RESULTS:
        seconds, of_source = processor_time(lambda results=results: list(results()), repeats=1)
        rows += [ValidationRow(source, what, numbers) for what, numbers in of_source]
        sources.append(asdict(source) | {"seconds": seconds})
    table = validation_table(rows)
    print(f"{table.caption}\n\n{plain_table(table)}")
    record("validation", sources=sources, rows=table.rows, agreeing=sum(row.agrees for row in rows))
    return not all(row.agrees for row in rows)


if __name__ == "__main__":
    sys.exit(main())
