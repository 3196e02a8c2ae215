"""The sections that show motions: Table 1, critical points and the design point."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from vireport.analysis import CriticalPoint, DesignPoint, Held, PolishedMotion, StableInterval, TableRow
from vireport.physics import DIGITS
from vireport.report.pages import Block, Paragraph
from vireport.scenario import LARGEST, SMALLEST, Parameter
from vireport.study import Study
from vireport.text import ABSENT, Table, bounded, capital, error_bound, numbers, percent, significant, texts, words

NOTHING = 1e-30
"""Below this, a number is what 45-digit arithmetic leaves of an exact zero."""

MOST_MARGINS = 10
"""Margins listed; results.json has all."""


def table_1(study: Study) -> Iterator[Block]:
    """Where each family of motions is of which type."""
    if study.solution.diagram is None:
        return
    swept = study.solution.parameter
    symbol = swept.symbol if study.solution.diagram.curve.level.held is Held.D else "d"
    yield Paragraph(
        "Every 1:1 motion in the sweep whose ball stays between the membranes, by the criteria of the "
        "paper's Table 1. *Δ* and *λ*_i are those of (4.3)."
    )
    unit = f"*{swept.symbol}* [{swept.unit}]"
    columns = (
        *texts("Motion"),
        *numbers("Branch"),
        *texts("Interval", "Type", "Criteria"),
        *numbers("*d* from", "to", f"{unit} from", "to"),
    )
    yield Table(
        "Table 1 for this scenario",
        columns,
        tuple(_table_row(row, symbol) for row in study.solution.table),
        "Both ends of a row belong together: where *d* rises, the swept parameter may fall. Mirror images share a row.",
    )
    yield from _ranges("Ranges of stable 1:1 motion", study, study.solution.stable_ranges, None)
    yield from _beyond(study)


def _beyond(study: Study) -> Iterator[Block]:
    """Where stable ranges would end that only the sweep ends."""
    swept = study.solution.parameter
    for part, beyond in zip(study.solution.stable_ranges, study.solution.beyond, strict=True):
        for (value, _), point in zip(part.ends, beyond, strict=True):
            if point is not None:
                yield Paragraph(
                    f"It is the sweep that ends at {swept.show(value, 8)}: stable motion goes on from there, to the "
                    f"{point.kind.words} at {swept.show(point.point.sweep_value, 8)}."
                )


def _table_row(row: TableRow, symbol: str) -> tuple[str, ...]:
    ends = (row.d_start, row.d_end, row.sweep_start, row.sweep_end)
    return (
        capital(row.family),
        str(row.branch),
        _interval(row, symbol),
        row.stability,
        words(row.criteria),
        *(significant(end, 8) for end in ends),
    )


def _interval(row: TableRow, symbol: str) -> str:
    """An interval in letters, as the paper writes it."""
    start, end = (point.label if point is not None else "" for point in (row.start_point, row.end_point))
    if start and end:
        return f"{start} < *{symbol}* < {end}"
    if start or end:
        return f"*{symbol}* > {start}" if start else f"*{symbol}* < {end}"
    return "throughout"


def _ranges(caption: str, study: Study, parts: Sequence[StableInterval], design: DesignPoint | None) -> Iterator[Block]:
    """Stable ranges, with the room that a design point has in them."""
    if not parts:
        return
    room = numbers("room") if design is not None else ()
    columns = (
        *texts("Parameter", "Unit"),
        *(numbers("Design point") if design is not None else ()),
        *numbers("From"),
        *texts("ended by"),
        *room,
        *numbers("To"),
        *texts("ended by"),
        *room,
    )
    rows = tuple(tuple(_range_row(study, part, design is not None)) for part in parts)
    note = "Room is the distance from the design point to the end, over the design value." if room else ""
    yield Table(caption, columns, rows, note)


def _range_row(study: Study, part: StableInterval, designed: bool) -> Iterator[str]:
    varied = part.parameter
    yield f"{capital(varied.quantity)} *{varied.symbol}*"
    yield varied.unit
    at = float(getattr(study.solution.device, varied)) if designed else None
    if at is not None:
        yield significant(at, 8)
    for value, point in part.ends:
        open_ended = designed and point is None and value in (SMALLEST, LARGEST)
        yield ABSENT if open_ended else significant(value, 8)
        yield _reason(point, designed)
        if at is not None:
            yield percent((value - at) / at, signed=True) if at and not open_ended else ABSENT


def _reason(point: CriticalPoint | None, designed: bool) -> str:
    if point is None:
        return "nothing" if designed else "the sweep"
    return ", ".join(filter(None, (point.label, point.kind.words)))


def critical_points(study: Study) -> Iterator[Block]:
    """Where the motions change, to the digits that the error bound justifies."""
    if study.solution.sweep is None:
        return
    points = study.solution.critical_points
    swept = study.solution.parameter
    if not points:
        yield Paragraph("The sweep has none: along each branch, the motions stay of one type.")
        return
    yield Paragraph(
        f"Each is a zero of its own condition, found along the branch and polished in {DIGITS}-digit "
        "arithmetic. The bound covers the last correction, the rounding to double precision and the "
        "conversion to the swept unit."
    )
    where = numbers(f"*{swept.symbol}* [{swept.unit}]", "± bound", "*d*", "*ḡ*")
    yield Table(
        "Critical points: where",
        (*texts("Point", "Kind", "Motion"), *where),
        tuple(_where(point) for point in points),
        "The bound is that of the number in results.json, of which this is the print.",
    )
    state = numbers("*q*", "*φ*_B", "*φ*_T", "*Ż*_B", "*Ż*_T")
    yield Table(
        "Critical points: the motion there",
        (*texts("Point"), *state, *texts("What happens")),
        tuple(row for point in points for row in _state_rows(point)),
        "Phases in rad, velocities just before the impacts in *y*_c; B is the bottom impact, T the top one.",
    )


def _where(critical: CriticalPoint) -> tuple[str, ...]:
    point = critical.point
    return (
        critical.label,
        critical.kind.words,
        critical.family,
        bounded(point.sweep_value, point.error_bound),
        error_bound(point.error_bound),
        significant(point.d, 12),
        significant(_clean(point.gbar), 8),
    )


def _clean(value: float) -> float:
    return 0.0 if abs(value) < NOTHING else value


def _state_rows(critical: CriticalPoint) -> Iterator[tuple[str, ...]]:
    yield (critical.label, *_state(critical.point, critical.phi_top), words(critical.change))
    if critical.mirror is not None:
        # The mirror image hits the top when the motion hits the bottom, half a forcing period on.
        top = float(np.mod(critical.point.phi + np.pi, 2 * np.pi))
        yield (critical.label, *_state(critical.mirror, top), "its mirror image")


def _state(point: PolishedMotion, phi_top: float) -> tuple[str, ...]:
    velocities = _clean(point.velocity_bottom), _clean(point.velocity_top)
    return tuple(significant(value, 8) for value in (0.5 + point.u, point.phi, phi_top, *velocities))


def design_point(study: Study) -> Iterator[Block]:
    """Every motion at the design point, and what is around it."""
    design = study.solution.design
    if design is None:
        return
    determinant = significant(study.solution.device.restitution**4, 6)
    at = ((x, float(getattr(study.solution.device, x))) for x in Parameter)
    yield Paragraph(f"At {', '.join(f'*{x.symbol}* = {x.show(value, 8)}' for x, value in at)}:")
    if len(design.motions):
        yield Table(
            "1:1 motions at the design point",
            (
                *texts("Motion", "Type", "Admissible"),
                *numbers("*q*", "*φ*_B", "*φ*_T", "*Ż*_B", "*Ż*_T", "Tr", "*Δ*"),
            ),
            tuple(_motion_rows(design)),
            f"Phases in rad, velocities in *y*_c. Det = *r*⁴ = {determinant} for all.",
        )
    else:
        yield Paragraph("The equations of a 1:1 motion have no solution here.")
    yield from _ranges(
        "Stable ranges around the design point, one input varied at a time", study, design.stable, design
    )
    yield from _margins(design)


def _motion_rows(design: DesignPoint) -> Iterator[tuple[str, ...]]:
    x = design.motions
    columns = (x.q, x.phi_bottom, x.phi_top, x.velocity_bottom, x.velocity_top, x.trace, x.discriminant)
    for i, (family, word) in enumerate(zip(design.families, x.words, strict=True)):
        admissible = "yes" if x.admissible[i] else "no"
        yield (capital(family), word, admissible, *(significant(float(column[i]), 6) for column in columns))


def _margins(design: DesignPoint) -> Iterator[Block]:
    if not design.margins:
        return
    rows = []
    for margin in design.margins[:MOST_MARGINS]:
        swept = margin.parameter
        rows.append(
            (
                f"*{swept.symbol}* [{swept.unit}]".removesuffix(" []"),
                margin.label or ABSENT,
                margin.kind.words,
                margin.point.family,
                significant(margin.sweep_value, 8),
                significant(margin.distance, 6),
                percent(margin.relative, signed=True),
                "yes" if margin.ends_stability else "no",
            )
        )
    more = len(design.margins) - len(rows)
    note = "To where stable motion ends, in every input, and to the other critical points of the sweep."
    yield Table(
        "Critical points around the design point, nearest first",
        (
            *texts("Varied", "Point", "Kind", "Motion"),
            *numbers("at", "distance", "relative"),
            *texts("ends stable motion"),
        ),
        tuple(rows),
        f"{note} {more} more are in results.json." if more else note,
    )
