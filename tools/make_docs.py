"""Makes docs/accuracy.md from `accuracy.md.j2` and the measured figures.

    python tools/make_docs.py            writes the page
    python tools/make_docs.py --check    writes nothing; exit code 1 where it would

The figures are those that the benchmarks wrote to `benchmarks/results`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results"
PAGE = ROOT / "docs" / "accuracy.md"


def rounded(value: float, digits: int = 2) -> str:
    """Print so many significant digits: 1234.5 as 1,200, 1.2345e-9 as 1.2e-9."""
    number = float(f"{value:.{digits}g}")
    return f"{number:,.0f}" if abs(number) >= 10 ** (digits - 1) else f"{number:.{digits}g}".replace("e-0", "e-")


def span(values: Iterable[float], digits: int = 2) -> str:
    """Print the smallest and the largest value, or one where both look the same."""
    ordered = sorted(values)
    low, high = rounded(ordered[0], digits), rounded(ordered[-1], digits)
    return low if low == high else f"{low} to {high}"


def page() -> str:
    """Text of docs/accuracy.md."""
    environment = Environment(
        loader=FileSystemLoader(ROOT / "tools"), undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True
    )
    environment.filters |= {"rounded": rounded, "span": span}
    results = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in RESULTS.glob("*.json")}
    return environment.get_template("accuracy.md.j2").render(results)


def main() -> int:
    """Write or check the page; returns the exit code."""
    text = page()
    if "--check" not in sys.argv:
        PAGE.write_text(text, encoding="utf-8")
    elif PAGE.read_text(encoding="utf-8") != text:
        print(f"{PAGE.name} is not what tools/accuracy.md.j2 and benchmarks/results give: python tools/make_docs.py")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
