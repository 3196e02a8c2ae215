"""Changes since a baseline as text, as a table, as Markdown and as JSON, and whether a report run again is the same."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from vireport.base.encoding import json_text
from vireport.report.changes.baseline import RELATIVE, diff
from vireport.report.changes.results import ChangeData, ChangesData
from vireport.report.changes.sentences import before_and_after
from vireport.report.changes.table import ComparisonRow
from vireport.study.reading import LONGEST_TEXT
from vireport.study.study import Study
from vireport.text.foreign import visible
from vireport.text.formatting import ABSENT, exact, percent
from vireport.text.said import Said, spoken, words_of
from vireport.text.tables import Table, markdown_of, numbers, texts

_said = words_of("changes")

OF_ONE_RUN = ("provenance", "overrides", "line", "left_out", "machine", "seconds")
"""Keys that are not compared value by value: where results come from, what formats leave out, and measured times."""

NAMED_PATHS = 5
"""Values that are named one by one."""


def diff_text(changed: Sequence[ComparisonRow], baseline: str | None = None, templates: Path | None = None) -> str:
    """Write the changes in lines of plain text, grouped; without a newline at the end.

    Parameters
    ----------
    changed : sequence of ComparisonRow
    baseline : str, optional
        Name of the file that they are changes of.
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    count = _count(changed, None if baseline is None else visible(baseline)).words(templates)
    lines = (f"  {_said('in_group', row.group, row.said).words(templates)}" for row in changed)
    return "\n".join([f"{count}:" if changed else f"{count}.", *lines])


def changes_table(
    changed: Sequence[ComparisonRow], baseline: str | None = None, templates: Path | None = None
) -> Table:
    """Set the changes as a table, grouped, whose caption counts them; it has no rows where there are none."""
    rows = tuple(
        (
            row.group,
            spoken(row.name, templates),
            *spoken(before_and_after(row.values, row.unit, row.group.exactness), templates),
            ABSENT if row.change is None else percent(row.change, signed=True),
        )
        for row in changed
    )
    group, what, *values = _said("heads").parts(templates)
    caption, note = _count(changed, baseline), _said("tolerance", exact(RELATIVE))
    return Table(caption.words(templates), (*texts(group, what), *numbers(*values)), rows, note.words(templates))


def diff_markdown(changed: Sequence[ComparisonRow], baseline: str | None = None, templates: Path | None = None) -> str:
    """Write the changes as a Markdown table, for a comment on a pull request."""
    return markdown_of(changes_table(changed, baseline, templates))


def diff_json(changed: Sequence[ComparisonRow], relative: float = RELATIVE) -> bytes:
    """Write the changes as JSON."""
    changes = [
        ChangeData(
            group=row.group,
            what=row.quantity,
            before=row.before,
            after=row.after,
            unit="" if row.unit == "1" else row.unit,
            change=row.change,
        )
        for row in changed
    ]
    data = ChangesData(changed=bool(changed), tolerance=relative, changes=changes)
    return (json_text(data, indent=1) + "\n").encode()


def _count(changed: Sequence[ComparisonRow], baseline: str | None) -> Said:
    """How many changes there are since a baseline."""
    since = _said("the_baseline") if baseline is None else baseline
    if len(changed) > 1:
        return _said("changes", len(changed), since)
    return _said("one_change" if changed else "no_change", since)


def rerun_text(baseline: Mapping[str, object], study: Study, name: str, templates: Path | None = None) -> str:
    """Say whether a study gives the very results of an earlier run, or what differs; without a newline at the end.

    Raises
    ------
    UsageError
        As `diff` does.
    """
    paths, file = list(unequal(baseline, json.loads(json_text(study.to_dict())))), visible(name)
    if not paths:
        return _said("identical", file).words(templates)
    named = [visible(path, LONGEST_TEXT) for path in paths[:NAMED_PATHS]]
    if len(paths) == 1:
        different = _said("one_not_identical", file, named)
    else:
        different = _said("not_identical", file, len(paths), named + ["..."] * (len(paths) > NAMED_PATHS))
    changed = diff(baseline, study, relative=0.0)
    changes = [diff_text(changed, name, templates)] if changed else []
    return "\n".join([different.words(templates), *changes])


def unequal(old: object, new: object, path: str = "") -> Iterator[str]:
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
