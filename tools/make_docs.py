"""Makes what docs/ takes from elsewhere: pages from recorded figures, tables of keys, names and templates.

    python tools/make_docs.py            writes the pages
    python tools/make_docs.py --check    writes nothing; exit code 1 where it would

Figures are those that the benchmarks wrote to `benchmarks/results`, in the pages that have a template here, such as
`accuracy.md.j2`. In all pages the rows behind a comment ``<!-- keys of FromRestData, window: WindowData -->`` are the
keys of these records, by the sections ``Attributes`` of their docstrings; those of the second stand within `window`,
below a line that says so. Behind ``<!-- names of vireport.report.context.Report -->`` are the attributes and methods
of that class, and behind ``<!-- heads of *.j2 -->`` the templates that the pattern names, by the first sentences of
their docstrings and of the comments at their heads.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Iterator
from functools import cached_property
from importlib import import_module
from inspect import cleandoc, signature
from pathlib import Path
from types import FunctionType

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from msgspec.inspect import NoneType, Type, UnionType, type_info

from vireport.base.records import ResultsBlock
from vireport.study.result_records import ADDED
from vireport.text.folders import ROOTS

ROOT = Path(__file__).resolve().parent.parent
MEASURED = ROOT / "benchmarks" / "results"
TABLE = re.compile(r"(<!-- (keys|names|heads) of (.+) -->\n)(?:\|.*\n)*")
SAYS_NULL = re.compile(r"\bnull\b|\bas of\b", re.IGNORECASE)
RESULTS = ROOT / "docs" / "results.md"
MARK = "\n<!-- results of findings, by tools/make_docs.py -->\n"
"""Behind it stand, at the end of that page, tables of the records of findings that no page describes."""

OF_SCENARIOS = "Keys"
"""With what the names of records end that are blocks of a scenario: docs/scenario.md has their keys."""


def rounded(value: float, digits: int = 2) -> str:
    """Print so many significant digits: 1234.5 as 1,200, 1.2345e-9 as 1.2e-9."""
    number = float(f"{value:.{digits}g}")
    return f"{number:,.0f}" if abs(number) >= 10 ** (digits - 1) else f"{number:.{digits}g}".replace("e-0", "e-")


def span(values: Iterable[float], digits: int = 2) -> str:
    """Print the smallest and the largest value, or one where both look the same."""
    ordered = sorted(values)
    low, high = rounded(ordered[0], digits), rounded(ordered[-1], digits)
    return low if low == high else f"{low} to {high}"


def of_figures(template: Path) -> str:
    """Text of a page with figures."""
    environment = Environment(
        loader=FileSystemLoader(template.parent),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"rounded": rounded, "span": span}
    results = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in MEASURED.glob("*.json")}
    return environment.get_template(template.name).render(results)


def records() -> dict[str, type[ResultsBlock]]:
    """Every record of results.json and of the files of comparisons and searches, by its name."""
    for file in (ROOT / "vireport").rglob("results.py"):
        import_module(".".join(file.relative_to(ROOT).with_suffix("").parts))
    kinds, waiting = {}, [ResultsBlock]
    while waiting:
        for kind in waiting.pop().__subclasses__():
            waiting.append(kind)
            kinds[kind.__name__] = kind
    return {name: kind for name, kind in kinds.items() if not name.endswith(OF_SCENARIOS)}


def described(record: type[ResultsBlock]) -> Iterator[tuple[list[str], str, str]]:
    """What docstrings of a record and of its bases say: names of keys, their unit or "", and what they are."""
    files = dict(zip(record.__struct_fields__, record.__struct_encode_fields__, strict=True))
    for kind in reversed(record.__mro__):
        entries = cleandoc(kind.__doc__ or "").partition("\nAttributes\n----------\n")[2]
        for names, unit, text in re.findall(r"^(\S.*?)(?: : (.+))?\n((?: +.+\n?)+)", entries, re.MULTILINE):
            yield [files.get(name, name) for name in names.split(", ")], unit, " ".join(text.split())


def summary(record: type[ResultsBlock]) -> str:
    """First line of the docstring of a record."""
    return (record.__doc__ or "").partition("\n")[0]


def table(listed: str) -> str:
    """Rows of the keys of some records: ``Record`` or ``block: Record``, separated by commas."""
    rows = []
    for entry in listed.split(", "):
        block, _, name = entry.rpartition(": ")
        rows += [(f"**of `{block}`:**", summary(records()[name]), "")] if block else []
        for keys, unit, text in described(records()[name]):
            names = ("other blocks" if key == ADDED else f"`{key}`" for key in keys)
            rows.append((", ".join(names), text, unit))
    columns = 3 if any(unit for *_, unit in rows) else 2
    lines = [("key", "content", "unit"), ("---",) * 3, *rows]
    cells = ([cell.replace("|", "\\|") for cell in line[:columns]] for line in lines)
    return "".join(f"| {' | '.join(line)} |\n".replace("  ", " ") for line in cells)


def two_columns(head: str, rows: Iterable[tuple[str, str]]) -> str:
    """A table of names as code, with what they are."""
    lines = (f"| `{name}` | {text} |\n" for name, text in rows)
    return f"| {head} | content |\n| --- | --- |\n" + "".join(lines)


def names(place: str) -> str:
    """Rows of the public attributes and methods of a class."""
    module, _, name = place.rpartition(".")
    kind = getattr(import_module(module), name)
    texts = {name: text for keys, _, text in described(kind) for name in keys}
    for base in reversed(kind.__mro__[:-2]):
        for name, thing in vars(base).items():
            if name.startswith("_") or not isinstance(thing, FunctionType | property | cached_property):
                continue
            called = f"({', '.join([*signature(thing).parameters][1:])})" if isinstance(thing, FunctionType) else ""
            texts[f"{name}{called}"] = (thing.__doc__ or "").partition("\n")[0]
    return two_columns("name", texts.items())


def heads(pattern: str) -> str:
    """Rows of the templates that a pattern names, by the first sentences of the comments at their heads."""
    rows = {}
    for root in ROOTS:
        for file in root.glob(pattern):
            head = re.match(r"{# (.+?\.)\s", file.read_text(encoding="utf-8"), re.DOTALL)
            rows |= {file.relative_to(root).as_posix(): " ".join(head[1].split())} if head else {}
    return two_columns("file", sorted(rows.items()))


MADE = {"keys": table, "names": names, "heads": heads}


def with_tables(before: str) -> str:
    """Text of a page, its tables made anew."""
    return TABLE.sub(lambda found: found[1] + MADE[found[2]](found[3]), before)


def may_be_null(kind: Type) -> bool:
    """Whether a key of a type may be null."""
    return isinstance(kind, UnionType) and any(isinstance(one, NoneType) for one in kind.types)


def shown_in(pages: str) -> set[str]:
    """Names of the records whose keys stand in a table."""
    kinds, listed = records(), (names for _, made, names in TABLE.findall(pages) if made == "keys")
    entries = (entry for names in listed for entry in names.split(", "))
    return {base.__name__ for entry in entries for base in kinds[entry.rpartition(": ")[2]].__mro__}


def with_additions(pages: dict[Path, str]) -> str:
    """Text of the page on results, with tables of the records of findings that no page describes at its end."""
    described = pages[RESULTS].partition(MARK)[0]
    shown = shown_in("".join((pages | {RESULTS: described}).values()))
    added = (kind for kind in records().values() if kind.__module__.startswith("vireport.findings."))
    tables = (
        f"\n## {summary(kind).rstrip('.')}\n\n<!-- keys of {kind.__name__} -->\n"
        for kind in added
        if kind.__name__ not in shown
    )
    return "".join((described, MARK, *tables))


def undescribed(pages: str) -> Iterator[str]:
    """Keys that no docstring describes, or not when they are null, or that no record has; records without a table."""
    shown = shown_in(pages)
    for name, record in records().items():
        keys = [key for keys, *_ in described(record) for key in keys]
        for key in sorted(set(keys) ^ set(record.__struct_encode_fields__)):
            yield f"{name}: {'is not a key' if key in keys else 'Attributes do not say what it is'}: {key}"
        null = {field.encode_name for field in type_info(record).fields if field.required and may_be_null(field.type)}
        for names, _, text in described(record):
            if null & set(names) and not SAYS_NULL.search(f"{summary(record)} {text}"):
                yield f"{name}: Attributes do not say when it is null: {', '.join(names)}"
        if name not in shown:
            yield f"{name}: no page of docs/ has a table of its keys"


def main() -> int:
    """Write or check the pages; returns the exit code."""
    before = {page: page.read_text(encoding="utf-8") for page in sorted((ROOT / "docs").glob("*.md"))}
    listed = before | {RESULTS: with_additions(before)}
    mistakes = list(undescribed("".join(listed.values())))
    for page, text in before.items():
        template = ROOT / "tools" / f"{page.name}.j2"
        made = with_tables(of_figures(template) if template.is_file() else listed[page])
        if made == text:
            continue
        if "--check" not in sys.argv:
            page.write_text(made, encoding="utf-8")
        else:
            mistakes.append(f"{page.name} is not what it is made from: python tools/make_docs.py")
    print("\n".join(mistakes), end="\n" if mistakes else "")
    return bool(mistakes)


if __name__ == "__main__":
    sys.exit(main())
