"""Results for machines: the records of results.json, and branches.csv, by the names that scripts rely on.

Numbers are written so that they read back exactly. There is no NaN and no Infinity: what was not computed is null,
and `left_out` says why.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import isfinite
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET
from msgspec.structs import asdict, replace

from vireport.base.encoding import json_text
from vireport.base.errors import UsageError
from vireport.base.records import keyed, plain
from vireport.design.bounds import Floats
from vireport.design.distortion import Distortion
from vireport.design.margins import Margin
from vireport.design.point import DesignPoint, StableInterval
from vireport.design.solution import Solution
from vireport.motions.branches import Branch
from vireport.motions.diagram import TableRow
from vireport.motions.error_bounds import NO_BOUND, rounded_up, undecided
from vireport.motions.events import Event
from vireport.motions.families import Claim
from vireport.motions.one_to_one import Motions
from vireport.motions.points import Point
from vireport.physics.device import Shaker
from vireport.physics.energy import Conversion, Fitting, Membrane, Voltages
from vireport.physics.groups import Groups, Restitutions
from vireport.study.families import family_rows
from vireport.study.judging.stretch import STATED_FIELD_V_M
from vireport.study.provenance import Provenance
from vireport.study.result_records import (
    SCHEMA_VERSION,
    BasinShares,
    Bounds,
    BranchData,
    CoexistingData,
    CompliantEndData,
    CompliantMotionData,
    CountedMotion,
    CourseData,
    CriticalPointData,
    DesignData,
    DistortionData,
    DisturbancesData,
    EffectRow,
    EffectsData,
    EndBeyondSweep,
    FittingData,
    FollowData,
    FollowedData,
    FollowedRange,
    FromRestData,
    HarmonicSlopes,
    JumpData,
    KindOfMotion,
    LoopData,
    MarginData,
    MissData,
    MotionRow,
    MultipliersData,
    OnBottomData,
    OneToOneData,
    OutcomeRangeData,
    OwnStiffnessData,
    Results,
    SampleData,
    ShakerData,
    SimulationData,
    SomeNumbers,
    StableRangeData,
    StageData,
    StartEnd,
    StretchData,
    TableRowData,
    VertexData,
)
from vireport.text.foreign import inert_cell

if TYPE_CHECKING:
    from vireport.design.compliant.own_stiffness import OwnStiffness
    from vireport.design.effects import Shifts
    from vireport.design.followed import FollowedMotion
    from vireport.design.switched_on import SwitchedOn
    from vireport.motions.families import Atlas, Family, Mark
    from vireport.simulation.attractors import Attractor
    from vireport.simulation.following import Course, Jump
    from vireport.study.checks.crosscheck import CrossCheck, MotionCount
    from vireport.study.checks.hysteresis import Hysteresis
    from vireport.study.coexistence import Coexisting

SWEEP_END = "end of the sweep"
"""What ends a stable range that no critical point ends."""

DIFFERENCE = 2e-15
"""Error of a difference between two computed velocities (of the order of 1) or phases: their rounding."""


def analytic_results(solution: Solution, scenario: dict[str, object], no_distortion: str | None = None) -> Results:
    """Results of the analytic theory alone: branches, points, design point, ranges and Table 1.

    Parameters
    ----------
    solution : Solution
    scenario : dict
        The scenario as it was understood, as plain data.
    no_distortion : str or None
        Why the harmonics that end stable motion were not sought; None where they were.
    """
    bounds = solution.bounds.branches
    return Results(
        schema_version=SCHEMA_VERSION,
        scenario=scenario,
        branches=[_branch(*row) for row in zip(solution.branches, bounds, strict=True)],
        critical_points=[_critical(point) for point in solution.critical_points],
        design_point=_design(solution.design, solution.bounds.design, no_distortion),
        stable_range=[
            replace(_range(part, SWEEP_END), from_beyond_sweep=_beyond(below), to_beyond_sweep=_beyond(above))
            for part, (below, above) in zip(solution.stable_ranges, solution.beyond, strict=True)
        ],
        shaker=_shaker(solution.shaker),
        fits_membrane=_fitting(solution.fitting),
        stretch=_stretch(solution),
        table_1=[_table_row(row, bounds[row.branch - 1]) for row in solution.table],
        alerts=[],
    )


def branches_csv(solution: Solution, atlas: Atlas | None = None) -> bytes:
    """Every motion of every branch as a row of a table, by the names of results.json; then those of the families."""
    head: list[str] = []
    rows: list[list[object]] = []
    for columns in _motions_by_branch(solution):
        head = list(columns)
        rows += [list(row) for row in zip(*columns.values(), strict=True)]
    families = list(family_motions(atlas, solution.membrane))
    head = list(dict.fromkeys([*head, *(families[0] if families else ())]))
    rows = [row + [None] * (len(head) - len(row)) for row in rows]
    rows += [[motion.get(name) for name in head] for motion in families]
    return csv_bytes(head, rows) if head else b""


def motion_rows(solution: Solution) -> Iterator[MotionRow]:
    """Every motion of every branch as a dict, by the names of branches.csv; without a sweep those of the design point.

    The motions of a design point alone are on no branch.
    """
    design, bounds = solution.design, solution.bounds.design
    tables = _motions_by_branch(solution)
    if solution.sweep is None and design is not None and bounds is not None:
        alone = [None] * len(design.motions)
        data = _motions(design.motions, design.voltages_by_motion, alone, bounds)
        tables = iter([{"branch": alone, "family": list(design.families), **_table(data)}])
    for columns in tables:
        for row in zip(*columns.values(), strict=True):
            yield dict(zip(columns, row, strict=True))


def _motions_by_branch(solution: Solution) -> Iterator[dict[str, list[Any]]]:
    """The motions of each branch, as the columns of branches.csv."""
    for branch, bounds in zip(solution.branches, solution.bounds.branches, strict=True):
        count, data = len(branch.motions), _branch(branch, bounds)
        yield {"branch": [data.number] * count, "family": [data.family] * count, **_table(data)}


def _table(data: BranchData) -> dict[str, list[object]]:
    """Columns of a branch with a value for each motion, by their names."""
    return {name: column for name, column in keyed(data).items() if name in data.columns}


def family_motions(atlas: Atlas | None, membrane: Membrane | None) -> Iterator[MotionRow]:
    """Every impact of every motion of the families as a dict, by the names of branches.csv."""
    if atlas is not None:
        for family in atlas.families:
            yield from family_rows(family, membrane)


def json_bytes(data: Mapping[str, object], provenance: Provenance) -> bytes:
    """Serialise plain data as JSON, one top-level key a line: the version of the format first, the provenance last.

    Floats read back exactly; what is not finite is null.
    """
    whole = {"schema_version": SCHEMA_VERSION, **data, "provenance": provenance}
    lines = (f"{json_text(key)}: {json_text(value)}" for key, value in whole.items())
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode()


def csv_bytes(head: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    """A table as CSV: floats read back exactly, booleans are ``true`` and ``false``, None is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(inert_cell, head))
    writer.writerows([_cell(value) for value in row] for row in rows)
    return text.getvalue().encode()


def _cell(value: object) -> object:
    if isinstance(value, bool):
        return str(value).lower()
    return inert_cell(value) if isinstance(value, str) else repr(value) if isinstance(value, float) else value


COLUMNS = {
    "phi_bottom": "phi_bottom_rad",
    "phi_top": "phi_top_rad",
    "admissible_mask": "admissible",
    "bottom_v": "u_bottom_v",
    "top_v": "u_top_v",
    "average_v": "u_ave_v",
}
"""Names in results.json of what is called otherwise in Python."""


DIMENSIONLESS = (
    *("sweep_value", "d", "gbar", "q", "phi_bottom", "phi_top", "velocity_bottom", "velocity_top"),
    *("trace", "determinant", "discriminant"),
)
"""The numbers of motions, by their names in `Motions`."""


def _columns(record: Motions | Voltages, names: Iterable[str]) -> dict[str, list[object]]:
    """Arrays of a record, by their names in results.json."""
    return {COLUMNS.get(name, name): getattr(record, name).tolist() for name in names}


def motion_columns(motions: Motions, voltages: Voltages | None) -> dict[str, Any]:
    """Columns of results.json on 1:1 motions and their voltages, by name."""
    numbers, types = _columns(motions, DIMENSIONLESS), {"stability": motions.words}
    gained = {} if voltages is None else _columns(voltages, voltages.__struct_fields__)
    return {**numbers, **types, **_columns(motions, ("admissible_mask", "wall_gap")), **gained}


def _conversion(conversion: Conversion | None) -> dict[str, SomeNumbers]:
    """What motions convert; null beyond the range of doubles."""
    columns = {} if conversion is None else plain(conversion)
    return {name: [x if isfinite(x) else None for x in column.tolist()] for name, column in columns.items()}


def _fitting(fitting: Fitting | None) -> FittingData | None:
    if fitting is None:
        return None
    return FittingData(
        ball_mass_at_most_kg=fitting.ball_mass_kg,
        stiffness_at_least=fitting.stiffness,
        active_radius_at_least_m=fitting.active_radius_m,
    )


def _stretch(solution: Solution) -> StretchData | None:
    """How far the deepest impact of the stable motions stretches a membrane; null beyond the range of doubles."""
    stretch, membrane = solution.stretch, solution.membrane
    if stretch is None or membrane is None:
        return None
    field = STATED_FIELD_V_M if membrane.dielectric is None else membrane.dielectric.breakdown_field_v_m
    return StretchData(
        deflection_m=finite(stretch.depth_m),
        deflection_over_radius=finite(stretch.depth_ratio),
        area_ratio=finite(stretch.area_ratio),
        u_imp_v=finite(stretch.peak_v),
        thickness_needed_m=finite(stretch.thickness_at(field)),
        at_field_v_m=finite(field),
    )


def _bounds(bounds: dict[str, Floats]) -> Bounds:
    """Error bounds by the names of the columns, and why some are null."""
    columns = rounded_up(np.stack(list(bounds.values())))
    named: Bounds = {COLUMNS.get(name, name): column for name, column in zip(bounds, columns, strict=True)}
    return {**named, "null_means": NO_BOUND} if any(None in column for column in columns) else named


def _labels(family: Family) -> list[str]:
    """For each motion of a branch the label of the critical point it is; where it is none, its event in brackets."""
    labels = [""] * len(family.x)
    for mark in family.marks:
        if mark.point is not None:
            labels[mark.row] = mark.point.label or f"({mark.point.event})"
    return labels


def _end_of_branch(end: Mark) -> str:
    """What a branch begins or ends with, in words."""
    if end.event is Event.ZERO_VELOCITY and end.point is not None:
        return end.point.detail
    return {Event.SWEEP_END: SWEEP_END, Event.CLOSED: "closed curve"}.get(end.event) or end.event.words


def _motions(
    motions: Motions, voltages: Voltages | None, labels: Sequence[str | None], bounds: dict[str, Floats]
) -> BranchData:
    """A branch without name and ends; `labels` are those of the critical points among its motions."""
    return BranchData(
        **motion_columns(motions, voltages),
        critical_point=list(labels),
        admissible_undecided=undecided(motions, bounds).tolist(),
        error_bounds=_bounds(bounds),
    )


def _branch(branch: Branch, bounds: dict[str, Floats]) -> BranchData:
    labels = [label or None for label in _labels(branch.family)]
    return replace(
        _motions(branch.motions, branch.voltages_by_motion, labels, bounds),
        number=branch.number,
        family=branch.symmetry,
        mirror_of=branch.mirror_of,
        ends=[_end_of_branch(end) for end in branch.family.ends],
    )


def _one_to_one(point: Point) -> OneToOneData:
    """The 1:1 motion of a critical point, with its error bounds."""
    closed = point.closed
    return OneToOneData(
        q=0.5 + closed.u,
        phi_bottom_rad=closed.phi_bottom,
        velocity_bottom=closed.velocity_bottom,
        velocity_top=closed.velocity_top,
        error_bounds=_point_bounds(point),
    )


def _point_bounds(point: Point) -> dict[str, float | None]:
    closed = point.closed
    q = max(closed.bounds["u"], float(np.spacing(0.5 + closed.u)))
    phi = {"phi_bottom_rad": closed.bounds["phi_bottom"], "phi_top_rad": closed.bounds["phi_top"]}
    exact = {name: closed.bounds[name] for name in ("d", "gbar", "velocity_bottom", "velocity_top")}
    return {"sweep_value": point.error_bound, "q": q, **phi, **exact}


def _critical(point: Point) -> CriticalPointData:
    return CriticalPointData(
        label=point.label,
        kind=point.event,
        family=point.symmetry,
        sweep_value=point.sweep_value,
        error_bound=point.error_bound,
        d=point.d,
        gbar=point.gbar,
        **asdict(_one_to_one(point)),
        phi_top_rad=point.closed.phi_top,
        mirror=None if point.mirror is None else _one_to_one(point.mirror),
        branch=point.families[0],
        detail=point.detail,
    )


def _design(
    design: DesignPoint | None, bounds: dict[str, Floats] | None, no_distortion: str | None
) -> DesignData | None:
    if design is None or bounds is None:
        return None
    r = design.motions.restitution
    by_law = r if isinstance(r, Restitutions) and np.ndim(r.bottom) else None
    data = DesignData(
        parameter=design.parameter,
        value=design.value,
        family=list(design.families),
        **motion_columns(design.motions, design.voltages_by_motion),
        admissible_undecided=undecided(design.motions, bounds).tolist(),
        error_bounds=_bounds(bounds),
        margins=[margin_data(margin) for margin in design.margins],
        margins_unresolved=list(design.unresolved_inputs),
        stable_range=[_range(part, LIMIT_OF_INPUT) for part in design.stable_ranges],
        distortion=None if design.distortions is None else [_distortion(least) for least in design.distortions],
        distortion_reason=no_distortion,
        restitution_bottom=UNSET if by_law is None else by_law.bottom.tolist(),
        restitution_top=UNSET if by_law is None else by_law.top.tolist(),
        claim=UNSET if by_law is None else Claim.FOLLOWED,
        not_followed=UNSET if by_law is None else design.lost,
    )
    return replace(data, **_conversion(design.conversion_by_motion))


def _distortion(distortion: Distortion) -> DistortionData:
    limited = distortion.share is not None
    return DistortionData(
        order=distortion.order,
        percent=None if distortion.share is None else 100 * distortion.share,
        phase_deg=distortion.phase_deg if limited else None,
        kind=distortion.event,
        error_bound_percent=None if distortion.error_bound is None else 100 * distortion.error_bound,
        searched_to_percent=100 * distortion.searched_to,
    )


def margin_data(margin: Margin) -> MarginData:
    """A margin of the design point, by the names of results.json."""
    return MarginData(
        parameter=margin.parameter,
        label=margin.label,
        kind=margin.event,
        family=margin.point.symmetry,
        sweep_value=margin.sweep_value,
        distance=margin.distance,
        relative=margin.relative,
        unit=margin.parameter.unit,
        percent=None if margin.relative is None else 100 * margin.relative,
        ends_stability=margin.ends_stability,
        taken_over=margin.taken_over,
        error_bound=margin.error_bound,
        derivatives={str(varied): slope for varied, slope in margin.derivatives.items()},
        derivatives_by_harmonic={
            str(order): None if slopes is None else HarmonicSlopes(cosine=slopes[0] / 100, sine=slopes[1] / 100)
            for order, slopes in margin.by_harmonics.items()
        },
    )


def switched_on_data(switched: SwitchedOn) -> DisturbancesData:
    """What the device does when it is switched on, and how fast it recovers; null is what was not computed."""
    end, recovery = switched.from_rest, switched.recovery
    from_rest = FromRestData(
        outcome=None if end is None else end.destination,
        word=None if end is None else end.word or None,
        periods=None if end is None else end.periods or None,
        reason=None if end is None or end.decided else end.name,
        settles_after_periods=None if end is None else end.settles_after,
        ramp_periods=switched.ramp_periods,
        motion=None if switched.motion_from_rest is None else _followed(switched.motion_from_rest),
        along_sweep=[
            OutcomeRangeData(
                from_=part.start,
                to=part.end,
                outcome=part.outcome.destination,
                word=part.outcome.word or None,
                periods=part.outcome.periods or None,
            )
            for part in (*switched.over_sweep, *switched.sampled)
        ],
    )
    return DisturbancesData(
        from_rest=from_rest,
        found_by_starts=[_followed(motion) for motion in switched.by_starts],
        recovery_periods=None if recovery is None else recovery.periods,
        recovery_s=None if recovery is None else recovery.seconds,
        recovery_error_bound_periods=None if recovery is None else recovery.error_bound,
        recovery_reason=switched.no_recovery,
    )


def _followed(followed: FollowedMotion) -> FollowedData:
    """A stable motion of any word, by the names of the families, and how far it is one."""
    motion = followed.motion
    errors = {
        "velocity": followed.velocity_error,
        "phase_rad": followed.phase_error,
        "time": followed.time_error,
    }
    return FollowedData(
        word=motion.word.letters,
        ratio=motion.word.ratio,
        periods=motion.word.periods,
        stability=followed.stability,
        velocity=motion.velocity.tolist(),
        phase_rad=motion.phase.tolist(),
        time=motion.time.tolist(),
        trace=followed.trace,
        multipliers=MultipliersData(
            real=[multiplier.real for multiplier in followed.multipliers],
            imaginary=[multiplier.imag for multiplier in followed.multipliers],
        ),
        error_bounds={name: rounded_up(bound[None])[0] for name, bound in errors.items()},
        stable_range=_followed_range(followed),
    )


def _followed_range(followed: FollowedMotion) -> FollowedRange:
    return FollowedRange(
        parameter=followed.varied,
        from_=followed.low,
        to=followed.high,
        from_reason=followed.below,
        to_reason=followed.above,
    )


def on_bottom_data(ranges: tuple[FollowedMotion, ...]) -> OnBottomData:
    """A stable motion on a table, and its range in each input along which it was followed."""
    word = ranges[0].motion.word
    return OnBottomData(
        word=word.letters, periods=word.periods, stable_ranges=[_followed_range(followed) for followed in ranges]
    )


def effects_data(shifts: Shifts) -> EffectsData:
    """Where the nearest end of stable motion would be with each of the neglected effects."""
    end = shifts.end
    return EffectsData(
        parameter=None if end is None else end.parameter,
        label=None if end is None else end.label,
        kind=None if end is None else end.event,
        sweep_value=None if end is None else end.sweep_value,
        relative=None if end is None else end.relative,
        reason=shifts.absence,
        rows=[
            EffectRow(
                effect=shift.effect.left_out,
                change=shift.effect.size or None,
                speed_m_s=shift.effect.speed_m_s,
                sweep_value=shift.value,
                kind=shift.event,
                moved=shift.moved,
                moved_relative=shift.relative,
                margin_left=shift.left,
                least_margin=finite(shift.least),
                stable=shift.stable if shift.computed else None,
                reason=shift.absence,
            )
            for shift in shifts.rows
        ],
    )


def own_stiffness_data(answer: OwnStiffness) -> OwnStiffnessData:
    """The compliant motion and its ends."""
    motion = answer.motion
    return OwnStiffnessData(
        parameter=answer.rigid.parameter,
        value=answer.rigid.value,
        at_design_point=answer.at_design,
        margin_gone=answer.margin_gone,
        motion=None
        if motion is None
        else CompliantMotionData(
            velocity_bottom=motion.bottom.velocity,
            velocity_top=motion.top.velocity,
            phi_bottom_rad=motion.bottom.phase,
            phi_top_rad=motion.top.phase,
            contact_share=motion.contact_share,
            trace=motion.trace,
            determinant=motion.determinant,
            stable=motion.stable,
            error_estimate=motion.error,
        ),
        missing=None if answer.absence is None else answer.absence.missing,
        reason=None if answer.absence is None else answer.absence.reason,
        ends=[
            CompliantEndData(
                parameter=end.parameter,
                label=end.point.label or None,
                kind=end.point.event,
                of_sweep=end.swept,
                design_value=end.design_value,
                rigid=end.rigid,
                compliant=end.compliant,
                error_estimate=None if end.compliant is None else end.error,
                missing=None if end.absence is None else end.absence.missing,
                reason=None if end.absence is None else end.absence.reason,
                rigid_margin=end.rigid_margin,
                compliant_margin=end.compliant_margin,
            )
            for end in answer.ends
        ],
    )


def finite(value: float | None) -> float | None:
    """A number, None where it is not finite."""
    return value if value is not None and isfinite(value) else None


def _shaker(shaker: Shaker) -> ShakerData:
    # Of a free capsule some of the numbers are NumPy's.
    return ShakerData(
        acceleration_amplitude_g=float(shaker.acceleration_g),
        acceleration_amplitude_m_s2=float(shaker.acceleration_m_s2),
        velocity_amplitude_m_s=float(shaker.velocity_m_s),
        stroke_m=float(shaker.stroke_m),
        force_amplitude_n=float(shaker.force_n),
    )


LIMIT_OF_INPUT = "limit of the input"
"""What ends the range of an input that no critical point ends."""


def _range(part: StableInterval, otherwise: str) -> StableRangeData:
    """A stable range; `otherwise` is what ends it where no critical point does."""
    return StableRangeData(
        parameter=part.parameter,
        from_=part.start,
        to=part.end,
        from_reason=_reason(part.start_point, otherwise),
        to_reason=_reason(part.end_point, otherwise),
        from_error_bound=part.start_point.error_bound if part.start_point else 0.0,
        to_error_bound=part.end_point.error_bound if part.end_point else 0.0,
        settable=part.settable,
    )


def _reason(point: Point | None, otherwise: str) -> str:
    """Why a stable range ends: the label or name of its critical point, or `otherwise`."""
    return otherwise if point is None else point.label or point.event.words


def _beyond(point: Point | None) -> EndBeyondSweep | None:
    """Where a stable range would end if the sweep went on; null where it ends within it, or nowhere."""
    if point is None:
        return None
    return EndBeyondSweep(
        sweep_value=point.sweep_value, kind=point.event, d=point.d, gbar=point.gbar, error_bound=point.error_bound
    )


def _table_row(row: TableRow, bounds: dict[str, Floats]) -> TableRowData:
    """A row of Table 1, its ends with the bounds they have on their branch."""
    ends = {"start": row.first_row, "end": row.last_row}
    names = [f"{name}_{end}" for end in ends for name, _ in DIRECTIONS]
    errors = rounded_up(np.array([[bounds[key][i] for i in ends.values() for _, key in DIRECTIONS]]))
    return TableRowData(
        family=row.symmetry,
        branch=row.branch,
        start_label=row.start_point.label if row.start_point else "",
        end_label=row.end_point.label if row.end_point else "",
        criteria=row.criteria,
        stability=row.stability,
        d_start=row.d_start,
        d_end=row.d_end,
        sweep_start=row.sweep_start,
        sweep_end=row.sweep_end,
        error_bounds=dict(zip(names, errors[0], strict=True)),
    )


DIRECTIONS = (("d", "d"), ("sweep", "sweep_value"))
"""What a row of Table 1 gives of its ends, and the column it is from."""


def simulation_data(
    check: CrossCheck, coexisting: Iterable[Coexisting], ending: Callable[[Jump], Point | None]
) -> SimulationData:
    """What the simulation found, with the motions that coexist and the point at which the one before a jump ends."""
    share = check.share
    return SimulationData(
        passed=check.passed,
        orbits_checked=check.orbits,
        velocity_difference=check.velocity_difference,
        phase_difference_rad=check.phase_difference,
        error_bounds={"velocity_difference": DIFFERENCE, "phase_difference_rad": DIFFERENCE},
        tolerance=check.tolerance,
        misses=[MissData(sweep_value=miss.sweep_value, outcome=miss.outcome) for miss in check.misses],
        basin=None
        if share is None
        else BasinShares(
            trials=check.trials,
            reached=check.arrivals,
            share=share[0],
            low_95=share[1],
            high_95=share[2],
            elsewhere=[_motion_count(motion) for motion in check.elsewhere],
        ),
        motions=[_motion_count(motion) for motion in check.motions],
        samples=[
            SampleData(
                sweep_value=float(value),
                d=float(check.groups.d[i]),
                start_velocity_at_most=float(speed),
                ends=[_end(attractor, check.groups.map_numbers(itemgetter(i)).as_floats()) for attractor in ends],
            )
            for i, (value, speed, ends) in enumerate(zip(check.values, check.start_speed, check.ends, strict=True))
        ],
        follow=None if check.hysteresis is None else _follow(check.hysteresis, coexisting, ending),
    )


def _follow(slowly: Hysteresis, coexisting: Iterable[Coexisting], ending: Callable[[Jump], Point | None]) -> FollowData:
    """The block of results.json on a sweep that is gone through slowly."""
    courses = {str(way): _course(course, ending) for way, course in slowly.courses.items()}
    return FollowData(
        up=courses.get("up"),
        down=courses.get("down"),
        loops=[
            LoopData(
                from_=loop.low,
                to=loop.high,
                width=loop.width,
                up=_kind(loop.up.attractor),
                down=_kind(loop.down.attractor),
            )
            for loop in slowly.loops
        ],
        coexisting=[_coexisting(motion) for motion in coexisting],
    )


def _course(course: Course, ending: Callable[[Jump], Point | None]) -> CourseData:
    """The motions at the values in their order, and the jumps between them."""
    return CourseData(
        samples=[
            StageData(
                sweep_value=stage.value,
                **asdict(_kind(stage.attractor)),
                wall=stage.impacts[:, 0].astype(int).tolist(),
                phase_rad=stage.impacts[:, 1].tolist(),
                velocity=stage.impacts[:, 2].tolist(),
            )
            for stage in course.stages
        ],
        jumps=[
            JumpData(
                from_=jump.before.value,
                to=jump.after.value,
                before=_kind(jump.before.attractor),
                after=_kind(jump.after.attractor),
                vertex=None
                if vertex is None
                else VertexData(label=vertex.label, kind=vertex.event, sweep_value=vertex.sweep_value),
            )
            for jump, vertex in ((jump, ending(jump)) for jump in course.jumps)
        ],
    )


def _kind(motion: Attractor | MotionCount | Coexisting) -> KindOfMotion:
    """What kind of motion it is; a word and a period are of periodic ones."""
    return KindOfMotion(outcome=motion.outcome.name.lower(), word=motion.word or None, period=motion.period or None)


def _coexisting(motion: Coexisting) -> CoexistingData:
    """A kind of motion, and the ranges in which it was found."""
    ranges = {str(source): [list(pair) for pair in pairs] for source, pairs in motion.ranges.items()}
    return replace(CoexistingData(**asdict(_kind(motion))), **ranges)


def _motion_count(motion: MotionCount) -> CountedMotion:
    """A kind of motion that starts end in, how many do, and between which values of the parameter."""
    return CountedMotion(**asdict(_kind(motion)), count=motion.count, from_=motion.low, to=motion.high)


def _end(attractor: Attractor, groups: Groups[float]) -> StartEnd:
    """What a start leads to; what a motion that is not periodic does not have is null."""
    from vireport.simulation.cycles import growth_bound

    cycle = attractor.cycle
    exponent = attractor.lyapunov
    bound = None if cycle is None else growth_bound(groups, cycle)
    finite = isfinite(exponent)
    # Of a motion that is not periodic the exponent is an average over a finite time: an estimate without a bound.
    rate = bound / cycle.growth / cycle.period if cycle is not None and bound is not None and finite else None
    return StartEnd(
        **asdict(_kind(attractor)),
        residual=None if cycle is None else cycle.residual,
        multiplier=None if cycle is None else cycle.growth,
        lyapunov=exponent if finite else None,
        error_bounds={"multiplier": bound, "lyapunov": rate},
    )


def results_block(data: Mapping[str, Any], name: str) -> dict[str, object]:
    """A block of results.json, {} where it is null."""
    if not isinstance(data, Mapping) or "scenario" not in data:
        raise UsageError("results are needed (allowed: the content of a results.json, as json.load gives it)")
    return data.get(name) or {}
