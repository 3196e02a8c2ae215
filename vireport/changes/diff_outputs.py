"""Changes since a baseline as text, as a table, as Markdown and as JSON, and whether a report run again is the same."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from vireport.base.encoding import json_text
from vireport.changes.baseline import LONGEST_TEXT, RELATIVE, diff
from vireport.changes.messages import Message, before_and_after
from vireport.changes.table import ComparisonRow
from vireport.study.study import Study
from vireport.text.foreign import visible
from vireport.text.formatting import ABSENT, exact, percent
from vireport.text.tables import Table, markdown_of, numbers, texts

OF_ONE_RUN = ("provenance", "overrides", "line", "left_out", "machine", "seconds")
"""Keys that are not compared value by value: where results come from, what formats leave out, and measured times."""

NAMED_PATHS = 5
"""Values that are named one by one."""


def diff_text(changed: Sequence[ComparisonRow], baseline: str = "the baseline") -> str:
    """Write the changes in lines of plain text, grouped; without a newline at the end."""
    lines = (f"  {row.group}: {row.sentence}" for row in changed)
    return "\n".join([_count(changed, visible(baseline)) + (":" if changed else "."), *lines])


def changes_table(changed: Sequence[ComparisonRow], baseline: str = "the baseline") -> Table:
    """Set the changes as a table, grouped, whose caption counts them; it has no rows where there are none."""
    rows = tuple(
        (
            row.group,
            row.quantity,
            *before_and_after(row.values, row.unit, row.group.exactness),
            ABSENT if row.change is None else percent(row.change, signed=True),
        )
        for row in changed
    )
    columns = (*texts("Group", "What"), *numbers("Before", "Now", "Change"))
    return Table(_count(changed, baseline), columns, rows, Message.TOLERANCE.format(tolerance=exact(RELATIVE)))


def diff_markdown(changed: Sequence[ComparisonRow], baseline: str = "the baseline") -> str:
    """Write the changes as a Markdown table, for a comment on a pull request."""
    return markdown_of(changes_table(changed, baseline))


def diff_json(changed: Sequence[ComparisonRow], relative: float = RELATIVE) -> bytes:
    """Write the changes as JSON."""
    changes = [
        {
            "group": row.group,
            "what": row.quantity,
            "before": row.before,
            "after": row.after,
            "unit": "" if row.unit == "1" else row.unit,
            "change": row.change,
        }
        for row in changed
    ]
    data = {"changed": bool(changed), "tolerance": relative, "changes": changes}
    return (json_text(data, indent=1) + "\n").encode()


def _count(changed: Sequence[ComparisonRow], baseline: str) -> str:
    message = Message.CHANGES if changed else Message.NO_CHANGE
    return message.format(count=len(changed), s="s" * (len(changed) != 1), baseline=baseline)


def rerun_text(baseline: Mapping[str, Any], study: Study, name: str) -> str:
    """Tell whether a study gives the very results of an earlier run, or what differs; without a newline at the end.

    Raises
    ------
    UsageError
        As `diff` does.
    """
    paths = list(unequal(baseline, json.loads(json_text(study.to_dict()))))
    if not paths:
        return Message.IDENTICAL.format(baseline=visible(name))
    first = ", ".join(visible(path, LONGEST_TEXT) for path in paths[:NAMED_PATHS])
    others = ", ..." if len(paths) > NAMED_PATHS else ""
    different = Message.NOT_IDENTICAL.format(
        baseline=visible(name), count=len(paths), s="s" * (len(paths) != 1), paths=f"{first}{others}"
    )
    changed = diff(baseline, study, relative=0.0)
    return "\n".join([different, *([diff_text(changed, name)] if changed else [])])


def unequal(old: Any, new: Any, path: str = "") -> Iterator[str]:
    """Find the paths of the values of two results, as data, that are not exactly the same."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for key in dict.fromkeys([*new, *old]):
            if key not in OF_ONE_RUN:
                yield from unequal(old.get(key), new.get(key), f"{path}.{key}" if path else key)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, values in enumerate(zip(old, new, strict=True)):
            yield from unequal(*values, f"{path}[{k}]")
    elif old != new:
        yield path
