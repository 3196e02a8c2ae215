"""Writes what follows from the keys of files: the JSON Schema that examples name, and tables of two pages of docs/.

    python tools/write_keys.py            writes all
    python tools/write_keys.py --check    writes nothing; exit code 1 where it would

The rows behind a comment ``<!-- keys: device, excitation.harmonics.* -->`` are the keys of these blocks, each with its
meaning, what it may be and its default. Blocks of additions that docs/scenario.md does not name stand behind its other
blocks. docs/map.md has the keys of map files.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

from vireport.base.encoding import json_text
from vireport.scenario.blocks import Scenario
from vireport.scenario.json_schema import keys, schema
from vireport.scenario.keys import added_keys
from vireport.scenario.map_file import MapFile
from vireport.scenario.messages import allowed

ROOT = Path(__file__).resolve().parent.parent
SCHEMA, PAGE = ROOT / "examples" / "scenario.schema.json", ROOT / "docs" / "scenario.md"
PAGE_OF_MAPS = PAGE.with_name("map.md")
TABLE = re.compile(r"(<!-- keys: (.+) -->\n)(?:\|.*\n)*")
MARK = "<!-- blocks of additions, by tools/write_keys.py -->\n"
DECLARED = keys(MapFile) | keys(Scenario)
HEAD = "| key | meaning | what it may be | default |\n|---|---|---|---|\n"


def plain(value: object) -> str:
    """A value as one would write it in YAML: 2000.0 as 2000, "none" as none."""
    return re.sub(r'"|\.0\b', "", json_text(value))


def row(path: str) -> str:
    """The row of a key: ``effects.*.percent`` as `effects[].percent`."""
    key = DECLARED[path]
    block, _, name = path.rpartition(".")
    if name in DECLARED[block].get("required", ()):
        default = "required"
    else:
        default = "" if key.get("default") in (None, []) else f"`{plain(key['default'])}`"
    cells = f"`{path.replace('.*', '[]')}`", key["description"], allowed(key), default
    return f"| {' | '.join(cells)} |\n".replace("  ", " ")


def table(listed: str) -> str:
    """The keys of some blocks, or some keys themselves, in the order in which they are listed."""
    rows = []
    for name in listed.split(", "):
        within = [path for path in DECLARED if path.rpartition(".")[0] == name and not path.endswith(".*")]
        alone = [name] if name in DECLARED and "properties" not in DECLARED[name] else []
        rows += [row(path) for path in (*alone, *within) if "properties" not in DECLARED[path]]
    return HEAD + "".join(rows)


def section(name: str) -> str:
    """What the page says of the block of an addition."""
    block = DECLARED[name]
    return f"\n## {block['title']}\n\n{block['description']}\n\n<!-- keys: {name} -->\n{table(name)}"


def with_tables(before: str) -> str:
    """Text of a page, its tables made anew."""
    return TABLE.sub(lambda mark: mark[1] + table(mark[2]), before)


def page(before: str) -> str:
    """Text of the page on scenarios, its tables and the blocks of additions made anew."""
    described = before.partition(MARK)[0]
    sections = (section(name) for name in added_keys() if f"<!-- keys: {name}" not in described)
    return "".join((with_tables(described), MARK, *sections))


def main() -> int:
    """Write or check the files; returns the exit code."""
    made = {
        SCHEMA: json.dumps(schema(), indent=2, ensure_ascii=False) + "\n",
        PAGE: page(PAGE.read_text(encoding="utf-8")),
        PAGE_OF_MAPS: with_tables(PAGE_OF_MAPS.read_text(encoding="utf-8")),
    }
    changed = {file: text for file, text in made.items() if file.read_text(encoding="utf-8") != text}
    for file, text in changed.items():
        if "--check" in sys.argv:
            print(f"{file.name} is not what it is made from: python tools/write_keys.py")
        else:
            file.write_text(text, encoding="utf-8")
    return bool(changed and "--check" in sys.argv)


if __name__ == "__main__":
    sys.exit(main())
