"""The families of motions as records, for results.json, and as rows, for branches.csv."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import isfinite

import numpy as np
from msgspec import UNSET
from numpy.typing import NDArray

from vireport.motions.error_bounds import NO_BOUND, rounded_up
from vireport.motions.events import Event
from vireport.motions.families import Atlas, Claim, Family, Mark
from vireport.motions.generation import generation, impact_rate
from vireport.motions.points import Point
from vireport.physics.energy import Membrane
from vireport.study.result_records import (
    CompletenessData,
    FamilyBounds,
    FamilyData,
    FamilyEnd,
    FamilyPoint,
    GenerationData,
    MotionRow,
    MotionsData,
    MultipliersOfFamily,
    Range,
)

Floats = NDArray[np.float64]


def motions_data(atlas: Atlas) -> MotionsData:
    """The limits of the motions, and how completely their families are found."""
    completeness = [
        CompletenessData(word=of.word, claim=of.claim, resolution=of.resolution, undecided=of.undecided)
        for of in atlas.completeness
    ]
    rest = CompletenessData(word=None, claim=Claim.FOLLOWED, resolution=None, undecided=None)
    return MotionsData(
        impacts=atlas.limits.impacts,
        periods=atlas.limits.periods,
        followed_impacts=atlas.followed,
        families_found=len(atlas.families),
        completeness=[*completeness, rest],
    )


def families_data(families: Iterable[Family], membrane: Membrane | None) -> list[FamilyData]:
    """Families, with what happens on each and, where there is a membrane, what its impacts generate."""
    return [_family(family, membrane) for family in families]


def _family(family: Family, membrane: Membrane | None) -> FamilyData:
    value, whole = family.sweep_value, None if membrane is None else generation(family, membrane)
    return FamilyData(
        number=family.number,
        word=family.word.letters,
        ratio=family.word.ratio,
        periods=family.word.periods,
        from_=float(value.min()),
        to=float(value.max()),
        begins_with=_end(family, family.ends[0]),
        ends_with=_end(family, family.ends[1]),
        stable_range=[Range(from_=low, to=high) for low, high in family.stable_ranges],
        critical_points=[_point(mark.point, mark.event) for mark in family.marks if mark.point is not None],
        generation=[] if membrane is None else _generation(family, membrane),
        determinant=family.determinant,
        stable=family.stable_mask.tolist(),
        multipliers=MultipliersOfFamily(
            real=[_finite(row) for row in family.multipliers.real],
            imaginary=[_finite(row) for row in family.multipliers.imag],
        ),
        sweep_value=value.tolist(),
        d=family.d.tolist(),
        velocity=family.velocity.tolist(),
        phase_rad=family.phase.tolist(),
        time=family.time.tolist(),
        trace=_finite(family.trace),
        impacts_per_s=impact_rate(family).tolist(),
        u_impacts_v=UNSET if whole is None else whole.impacts_v.tolist(),
        u_ave_v=UNSET if whole is None else whole.average_v.tolist(),
        u_per_second_v=UNSET if whole is None else whole.per_second_v.tolist(),
        error_bounds=_bounds(family),
    )


def _finite(values: Floats) -> list[float | None]:
    return [x if isfinite(x) else None for x in values.tolist()]


def _bounds(family: Family) -> FamilyBounds:
    bounds = family.error_bounds
    return FamilyBounds(
        sweep_value=rounded_up(bounds["sweep_value"][None])[0],
        velocity=rounded_up(bounds["velocity"]),
        phase_rad=rounded_up(bounds["phase"]),
        null_means=NO_BOUND,
    )


def family_rows(family: Family, membrane: Membrane | None) -> Iterator[MotionRow]:
    """Every impact of every motion of a family, by the names of branches.csv: first those of the 1:1 motions."""
    data, word, size = _family(family, membrane), family.word, len(family.x)
    volts, means, bounds, walls = data.u_impacts_v or None, data.u_ave_v or (), _bounds(family), word.walls
    gbar = np.broadcast_to(family.model.groups(family.x[:, -1])[1], size).tolist()
    labels = {row: point.label for row, point in family.critical_points.items()}
    for row in range(size):
        for i, wall in enumerate(walls):
            yield {
                "sweep_value": data.sweep_value[row],
                "d": data.d[row],
                "gbar": gbar[row],
                "trace": data.trace[row],
                "determinant": family.determinant,
                "admissible": True,
                **({} if volts is None else {"u_ave_v": means[row]}),
                "critical_point": labels.get(row),
                "word": word.letters,
                "family_number": family.number,
                "n": walls.count(1),
                "m": walls.count(-1),
                "periods": word.periods,
                "sample": row,
                "stable": data.stable[row],
                "impact": i,
                "wall": "bottom" if wall > 0 else "top",
                "time": data.time[row][i],
                "phase_rad": data.phase_rad[row][i],
                "velocity": data.velocity[row][i],
                **({} if volts is None else {"u_v": volts[row][i]}),
                "sweep_value_error_bound": bounds.sweep_value[row],
                "phase_rad_error_bound": bounds.phase_rad[row][i],
                "velocity_error_bound": bounds.velocity[row][i],
            }


def _end(family: Family, mark: Mark) -> FamilyEnd:
    point, value = mark.point, float(family.sweep_value[mark.row])
    label, families = (None, []) if point is None else (point.label or None, list(point.families))
    return FamilyEnd(kind=mark.event, label=label, families=families, sweep_value=value)


def _point(point: Point, event: Event) -> FamilyPoint:
    """A point as a family has it, to which grazing may be an impact that loses its velocity."""
    return FamilyPoint(
        label=point.label or None,
        kind=event,
        sweep_value=point.sweep_value,
        error_bound=point.error_bound if isfinite(point.error_bound) else None,
        d=point.d,
        gbar=point.gbar,
        word=point.motion.word.letters,
        velocity=point.motion.velocity.tolist(),
        phase_rad=point.motion.phase.tolist(),
        families=list(point.families),
    )


def _generation(family: Family, membrane: Membrane) -> list[GenerationData]:
    """At both ends and in the middle."""
    whole = generation(family, membrane)
    rows = dict.fromkeys(int(row) for row in np.linspace(0, len(family.x) - 1, 3))
    return [
        GenerationData(
            sweep_value=float(family.sweep_value[row]),
            u_impacts_v=whole.impacts_v[row].tolist(),
            u_ave_v=float(whole.average_v[row]),
            impacts_per_s=float(whole.impacts_per_s[row]),
            u_per_second_v=float(whole.per_second_v[row]),
        )
        for row in rows
    ]
