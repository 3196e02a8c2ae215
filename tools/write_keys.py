"""Writes what follows from the keys of a scenario: the JSON Schema that the examples name, and tables of the pages.

    python tools/write_keys.py

Blocks of additions that docs/scenario.md does not describe are set behind the others there, with what their keys mean.
"""

from __future__ import annotations

import json
from pathlib import Path

from vireport.base.encoding import json_text
from vireport.scenario.blocks import Scenario
from vireport.scenario.json_schema import keys, schema
from vireport.scenario.keys import added_keys

ROOT = Path(__file__).resolve().parent.parent
SCHEMA, PAGE = ROOT / "examples" / "scenario.schema.json", ROOT / "docs" / "scenario.md"
MARK = "<!-- blocks of additions, by tools/write_keys.py -->\n"


def section(name: str) -> str:
    """What the page says of the block of an addition."""
    declared = keys(Scenario)
    rows = [(path, key) for path, key in declared.items() if path.startswith(f"{name}.")]
    said = (f"| `{path}` | {key['description']} | {json_text(key.get('default'))} |" for path, key in rows)
    table = "\n".join(("| key | meaning | default |", "|---|---|---|", *said))
    return f"\n## {declared[name]['title']}\n\n{declared[name]['description']}\n\n{table}\n"


def main() -> None:
    """Write the files anew."""
    SCHEMA.write_text(json.dumps(schema(), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    before = PAGE.read_text(encoding="utf-8").partition(MARK)[0]
    sections = (section(name) for name in added_keys() if f"| `{name}." not in before)
    PAGE.write_text("".join((before, MARK, *sections)), encoding="utf-8")


if __name__ == "__main__":
    main()
