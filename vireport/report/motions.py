"""The table of families of motions of other impact sequences, and what they generate."""

from __future__ import annotations

from vireport.motions.events import Event
from vireport.motions.families import Atlas, Family, Mark
from vireport.motions.generation import generation
from vireport.motions.sweep import settable
from vireport.study.study import Study
from vireport.text.formatting import Exactness, rounded_text, span
from vireport.text.tables import Table, numbers, texts


def families_table(study: Study, atlas: Atlas) -> Table:
    """Those families that are shown, stable ones first, with the voltage in the middle of the longest stable range."""
    swept = atlas.sweep.parameter
    order = sorted(atlas.printed_families, key=lambda family: not family.stable_runs)
    rows = tuple((*_row(family, study.evidence.exactness), *_voltage(study, family)) for family in order)
    columns = (
        *texts("Word", "n:m"),
        *numbers("Periods", f"{swept.symbol} [{swept.unit}]", "Stable"),
        *texts("Begins", "Ends"),
        *(numbers("U_ave [V]", "[V/s]") if study.solution.membrane is not None else ()),
    )
    title = "Families of motions, with voltages in the middle of the longest stable range, or of the family"
    return Table(title if study.solution.membrane is not None else "Families of motions", columns, rows)


def _row(family: Family, exactness: Exactness) -> tuple[str, ...]:
    parts = (
        span(*part, exactness) + ("" if settable(*part, family.sweep.off) else " (too narrow to be set)")
        for part in family.stable_ranges
    )
    stable = ", ".join(parts) or "nowhere"
    whole = span(float(family.sweep_value.min()), float(family.sweep_value.max()), exactness)
    word, ends = family.word, (_end(family, mark) for mark in family.ends)
    return (word.letters, word.ratio, str(word.periods), whole, stable, *ends)


def _end(family: Family, mark: Mark) -> str:
    if mark.event is Event.LOST:
        return f"not followed beyond {rounded_text(float(family.sweep_value[mark.row]))}"
    return mark.point.label if mark.point is not None and mark.point.label else mark.event.replace("_", " ")


def _voltage(study: Study, family: Family) -> tuple[str, ...]:
    """U_ave and voltage per second in the middle of the longest stable run, else of the family."""
    membrane = study.solution.membrane
    if membrane is None:
        return ()
    first, last = max(family.stable_runs, key=lambda run: run[1] - run[0], default=(0, len(family.x) - 1))
    whole, row = generation(family, membrane), (first + last) // 2
    exactness = study.evidence.exactness
    return rounded_text(float(whole.average_v[row]), exactness), rounded_text(float(whole.per_second_v[row]), exactness)
