"""Tables of the motions of other impact sequences: what each sequence generates, and all families."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.motions.events import Event
from vireport.motions.families import Family, Mark
from vireport.motions.generation import generation, ladder
from vireport.motions.sweep import settable
from vireport.study.study import Study
from vireport.text.formatting import Exactness, quantity, rounded_text, span
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words


def motion_tables(study: Study, say: Words) -> Iterator[Table]:
    """What stable motions of each impact sequence generate at most, if there are any, and the families that are shown.

    Of families stable ones come first, with the voltage in the middle of the longest stable range.
    """
    atlas, membrane, exactness = study.atlas, study.solution.membrane, study.evidence.exactness
    if atlas is None:
        return
    swept, rows, volts = atlas.sweep.parameter, [], "nn" if membrane is not None else ""
    for rung in ladder(atlas.printed_families, membrane):
        ranges = "; ".join(swept.with_unit(span(*part, exactness)) for part in rung.ranges)
        most = (quantity(rung.average_v, "V", exactness), f"{quantity(rung.per_second_v, 'V', exactness)}/s")
        impacts = " to ".join(dict.fromkeys(map(rounded_text, rung.impacts_per_s)))
        rows.append((rung.word.letters, str(rung.word.periods), ranges, *(most if volts else ()), impacts))
    if rows:
        yield worded_table(say, "ladder", f"tnt{volts}n", rows, swept, bool(volts))
    order = sorted(atlas.printed_families, key=lambda family: not family.stable_runs)
    rows = [(*_row(family, exactness, say), *_voltage(study, family)) for family in order]
    yield worded_table(say, "families", f"ttnnntt{volts}", rows, swept, bool(volts))


def _row(family: Family, exactness: Exactness, say: Words) -> tuple[str, ...]:
    ranges = ((span(*part, exactness), settable(*part, family.sweep.off)) for part in family.stable_ranges)
    stable = ", ".join(part if wide else say("too_narrow", part) for part, wide in ranges) or say("nowhere")
    whole = span(float(family.sweep_value.min()), float(family.sweep_value.max()), exactness)
    word, ends = family.word, (_end(family, mark, say) for mark in family.ends)
    return (word.letters, word.ratio, str(word.periods), whole, stable, *ends)


def _end(family: Family, mark: Mark, say: Words) -> str:
    if mark.event is Event.LOST:
        return say("lost", rounded_text(float(family.sweep_value[mark.row])))
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
