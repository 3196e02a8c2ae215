"""Results for machines: results.json and branches.csv, by the names that scripts rely on.

Numbers are written so that they read back exactly. There is no NaN and no Infinity: what was not computed is null,
and `left_out` says why.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import asdict
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from vireport.analysis import (
    NO_BOUND,
    Branch,
    CriticalPoint,
    DesignPoint,
    Margin,
    Motions,
    PolishedMotion,
    StableInterval,
    TableRow,
    rounded_up,
)
from vireport.physics import Voltages
from vireport.scenario import to_dict
from vireport.study.provenance import Provenance, provenance_of
from vireport.study.study import Study

if TYPE_CHECKING:
    from vireport.gate import Criterion
    from vireport.simulation import Attractor
    from vireport.trust import CrossCheck, MotionCount

SCHEMA_VERSION = 1

DIFFERENCE = 2e-15
"""Error of a difference between two computed velocities (of the order of 1) or phases: their rounding."""


def results(study: Study, provenance: Provenance) -> dict[str, Any]:
    """Return the results of a study as plain data, ready for JSON.

    Parameters
    ----------
    study : Study
    provenance : Provenance
        Where the results came from.
    """
    solution = study.solution
    bounds = solution.bounds.branches
    return {
        "schema_version": SCHEMA_VERSION,
        "scenario": to_dict(study.scenario),
        "branches": [_branch(*row) for row in zip(solution.branches, bounds, strict=True)],
        "critical_points": [_critical(point) for point in solution.critical_points],
        "design_point": _design(solution.design, solution.bounds.design),
        "stable_range": [_range(part) for part in solution.stable_ranges],
        "table_1": [_table_row(row, bounds[row.branch - 1]) for row in solution.table],
        "simulation": None if study.crosscheck is None else _simulation(study.crosscheck),
        **_measured(study),
        "requirements": _requirements(study.criteria) if study.scenario.requirements is not None else None,
        "alerts": [alert.to_dict() for alert in study.alerts],
        "left_out": [{"step": step.task, "what": step.what, "why": step.why} for step in study.plan.left_out],
        "provenance": {**asdict(provenance), "libraries": dict(provenance.libraries)},
    }


def results_json(study: Study, provenance: Provenance) -> bytes:
    """Serialise `results`, one top-level key a line."""
    data = results(study, provenance)
    lines = (f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}" for key, value in data.items())
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode()


def branches_csv(study: Study) -> bytes:
    """Every motion of every branch as a row of a table, by the names of results.json."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    header: list[str] | None = None
    for branch in study.solution.branches:
        columns = {**_motions(branch.motions), **_voltages(branch.voltages), "critical_point": branch.labels}
        if header is None:
            header = ["branch", "family", *columns]
            writer.writerow(header)
        writer.writerows(
            [branch.number, branch.family, *(_cell(value) for value in row)]
            for row in zip(*columns.values(), strict=True)
        )
    return text.getvalue().encode()


def _cell(value: Any) -> Any:
    return repr(value) if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else value


def _motions(motions: Motions) -> dict[str, list[Any]]:
    return {
        "sweep_value": motions.sweep_value.tolist(),
        "d": motions.d.tolist(),
        "gbar": motions.gbar.tolist(),
        "q": motions.q.tolist(),
        "phi_bottom_rad": motions.phi_bottom.tolist(),
        "phi_top_rad": motions.phi_top.tolist(),
        "velocity_bottom": motions.velocity_bottom.tolist(),
        "velocity_top": motions.velocity_top.tolist(),
        "trace": motions.trace.tolist(),
        "determinant": motions.determinant.tolist(),
        "discriminant": motions.discriminant.tolist(),
        "stability": motions.words,
        "admissible": motions.admissible.tolist(),
        "wall_gap": motions.wall_gap.tolist(),
    }


def _voltages(voltages: Voltages | None) -> dict[str, list[float]]:
    if voltages is None:
        return {}
    return {
        "u_bottom_v": voltages.bottom_v.tolist(),
        "u_top_v": voltages.top_v.tolist(),
        "u_ave_v": voltages.average_v.tolist(),
        "deflection_m": voltages.deflection_m.tolist(),
    }


COLUMNS = {
    "phi_bottom": "phi_bottom_rad",
    "phi_top": "phi_top_rad",
    "bottom_v": "u_bottom_v",
    "top_v": "u_top_v",
    "average_v": "u_ave_v",
}
"""Names in results.json of what is called otherwise in Python."""


def _bounds(bounds: dict[str, Any]) -> dict[str, Any]:
    """Error bounds by the names of the columns, and why some are null."""
    columns = rounded_up(np.stack(list(bounds.values())))
    found: dict[str, Any] = {COLUMNS.get(name, name): column for name, column in zip(bounds, columns, strict=True)}
    return {**found, "null_means": NO_BOUND} if any(None in column for column in found.values()) else found


def _branch(branch: Branch, bounds: dict[str, Any]) -> dict[str, Any]:
    return {
        "number": branch.number,
        "family": branch.family,
        "mirror_of": branch.mirror_of,
        "ends": list(branch.ends),
        **_motions(branch.motions),
        **_voltages(branch.voltages),
        "critical_point": [label or None for label in branch.labels],
        "error_bounds": _bounds(bounds),
    }


def _point(point: PolishedMotion) -> dict[str, Any]:
    return {
        "q": 0.5 + point.u,
        "phi_bottom_rad": point.phi,
        "velocity_bottom": point.velocity_bottom,
        "velocity_top": point.velocity_top,
        "error_bounds": _point_bounds(point),
    }


def _point_bounds(point: PolishedMotion) -> dict[str, Any]:
    q = max(point.bounds["u"], float(np.spacing(0.5 + point.u)))
    phi = {"phi_bottom_rad": point.bounds["phi"], "phi_top_rad": point.bounds["phi_top"]}
    exact = {name: point.bounds[name] for name in ("d", "gbar", "velocity_bottom", "velocity_top")}
    return {"sweep_value": point.error_bound, "q": q, **phi, **exact}


def _critical(critical: CriticalPoint) -> dict[str, Any]:
    point = critical.point
    return {
        "label": critical.label,
        "kind": critical.kind,
        "family": critical.family,
        "sweep_value": point.sweep_value,
        "error_bound": point.error_bound,
        "d": point.d,
        "gbar": point.gbar,
        **_point(point),
        "phi_top_rad": critical.phi_top,
        "mirror": None if critical.mirror is None else _point(critical.mirror),
        "branch": critical.branch,
        "detail": critical.change,
    }


def _table_row(row: TableRow, bounds: dict[str, Any]) -> dict[str, Any]:
    """A row of Table 1, its ends with the bounds they have on their branch."""
    found = {
        "family": row.family,
        "branch": row.branch,
        "start_label": row.start_point.label if row.start_point else "",
        "end_label": row.end_point.label if row.end_point else "",
        "criteria": row.criteria,
        "stability": row.stability,
        "d_start": row.d_start,
        "d_end": row.d_end,
        "sweep_start": row.sweep_start,
        "sweep_end": row.sweep_end,
    }
    ends = {"start": row.first_row, "end": row.last_row}
    names = [f"{name}_{end}" for end in ends for name, _ in DIRECTIONS]
    errors = rounded_up(np.array([[bounds[key][i] for i in ends.values() for _, key in DIRECTIONS]]))
    return {**found, "error_bounds": dict(zip(names, errors[0], strict=True))}


DIRECTIONS = (("d", "d"), ("sweep", "sweep_value"))
"""What a row of Table 1 gives of its ends, and the column it is from."""


def _design(design: DesignPoint | None, bounds: dict[str, Any] | None) -> dict[str, Any] | None:
    if design is None or bounds is None:
        return None
    return {
        "parameter": design.parameter,
        "value": design.value,
        "family": list(design.families),
        **_motions(design.motions),
        **_voltages(design.voltages),
        "error_bounds": _bounds(bounds),
        "margins": [_margin(margin) for margin in design.margins],
        "stable_range": [_range(part) for part in design.stable],
    }


def _margin(margin: Margin) -> dict[str, Any]:
    return {
        "parameter": margin.parameter,
        "label": margin.label,
        "kind": margin.kind,
        "family": margin.point.family,
        "sweep_value": margin.sweep_value,
        "distance": margin.distance,
        "relative": margin.relative,
        "ends_stability": margin.ends_stability,
        "error_bound": margin.error_bound,
    }


def _measured(study: Study) -> dict[str, Any]:
    """What was measured or proved where that was asked for; null where not."""
    found: dict[str, Any] = {"accuracy": None, "compliant": None, "certificates": None}
    if study.work is not None:
        from vireport.trust import accuracy_data, compliance_data

        found["accuracy"] = accuracy_data(study.work)
        found["compliant"] = None if study.compliance is None else compliance_data(study.compliance)
    if study.certificates is not None:
        found["certificates"] = [asdict(one) for one in study.certificates]
    return found


def _requirements(criteria: tuple[Criterion, ...]) -> dict[str, Any]:
    passed = all(criterion.passed for criterion in criteria)
    return {"passed": passed, "criteria": [criterion.to_dict() for criterion in criteria]}


def _simulation(check: CrossCheck) -> dict[str, Any]:
    share = check.share
    return {
        "passed": check.passed,
        "orbits_checked": check.orbits,
        "velocity_difference": check.velocity_difference,
        "phase_difference_rad": check.phase_difference,
        "error_bounds": {"velocity_difference": DIFFERENCE, "phase_difference_rad": DIFFERENCE},
        "tolerance": check.tolerance,
        "misses": [asdict(miss) for miss in check.misses],
        "basin": None
        if share is None
        else {
            "trials": check.trials,
            "reached": check.reached,
            "share": share[0],
            "low_95": share[1],
            "high_95": share[2],
            "elsewhere": [_motion_count(motion) for motion in check.elsewhere],
        },
        "motions": [_motion_count(motion) for motion in check.motions],
        "samples": [
            {
                "sweep_value": float(value),
                "d": float(d),
                "start_velocity_at_most": float(speed),
                "ends": [_end(one, float(d), float(gbar), check.restitution) for one in found],
            }
            for value, d, gbar, speed, found in zip(
                check.values, check.d, check.gbar, check.start_speed, check.found, strict=True
            )
        ],
    }


def _motion_count(motion: MotionCount) -> dict[str, Any]:
    """A kind of motion that starts end in, how many do, and between which values of the parameter."""
    return {
        "outcome": motion.outcome.name.lower(),
        "word": motion.word or None,
        "period": motion.period or None,
        "count": motion.count,
        "from": motion.low,
        "to": motion.high,
    }


def _end(attractor: Attractor, d: float, gbar: float, r: float) -> dict[str, Any]:
    """What a start leads to; what a motion that is not periodic does not have is null."""
    from vireport.simulation import growth_bound

    cycle = attractor.cycle
    exponent = attractor.lyapunov
    bound = None if cycle is None else growth_bound(d, gbar, r, cycle)
    finite = isfinite(exponent)
    # Of a motion that is not periodic the exponent is an average over a finite time: an estimate without a bound.
    rate = bound / cycle.growth / cycle.period if cycle is not None and bound is not None and finite else None
    return {
        "outcome": attractor.outcome.name.lower(),
        "word": attractor.word or None,
        "period": attractor.period or None,
        "residual": None if cycle is None else cycle.residual,
        "multiplier": None if cycle is None else cycle.growth,
        "lyapunov": exponent if finite else None,
        "error_bounds": {"multiplier": bound, "lyapunov": rate},
    }


def _range(part: StableInterval) -> dict[str, Any]:
    return {
        "parameter": part.parameter,
        "from": part.start,
        "to": part.end,
        "from_reason": _reason(part.start_point),
        "to_reason": _reason(part.end_point),
        "from_error_bound": part.start_point.point.error_bound if part.start_point else 0.0,
        "to_error_bound": part.end_point.point.error_bound if part.end_point else 0.0,
    }


def _reason(point: CriticalPoint | None) -> str:
    """What ends a stable range."""
    return point.label if point is not None else "end of the sweep"


ENDS = "ends"
"""The one list of a branch that is not of its motions."""


def study_dict(study: Study) -> dict[str, Any]:
    """The results of a study as plain data: results.json without its provenance."""
    data = results(study, provenance_of(study.loaded, ""))
    del data["provenance"]
    return data


def study_rows(study: Study) -> list[dict[str, Any]]:
    """Every motion of every branch as a dict, by the names of branches.csv."""
    return [row for branch in study_dict(study)["branches"] for row in _branch_rows(branch)]


def _branch_rows(branch: dict[str, Any]) -> Iterator[dict[str, Any]]:
    columns = {name: values for name, values in branch.items() if isinstance(values, list) and name != ENDS}
    for row in zip(*columns.values(), strict=True):
        yield {"branch": branch["number"], "family": branch["family"], **dict(zip(columns, row, strict=True))}
