"""Answers of the package compared with 40 digits: the motions of a study, its branches and its critical points."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from msgspec import Struct

from vireport.motions.points import Point
from vireport.physics.device import Device
from vireport.physics.groups import map_restitution
from vireport.physics.numbers import wrapped
from vireport.scenario.parameters import Parameter
from vireport.study.checks import reference as exact
from vireport.study.checks.forty_digits import MATCH, critical_motion, motion_errors
from vireport.study.study import Study
from vireport.text.alerts import AlertCode
from vireport.text.formatting import ROUGHLY, rounded_text
from vireport.verify.rows import BOUND, CaseFinding, WrongAnswerError

SPACING = 2.220446049250313e-16
"""Spacing of doubles at 1."""

ROWS = 5
"""Motions of each branch that are compared, beside those at its critical points."""

SEED = 20190301
"""Seed of the rows that are compared, equal in every run."""


def require_finite(value: object, name: str = "result") -> None:
    """Look for NaN and inf in everything that a result holds; FloatingPointError names the place."""
    if isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind == "f"):
        if not np.isfinite(value).all():
            raise FloatingPointError(f"{name} is not finite")
    elif isinstance(value, Struct):
        for field in value.__struct_fields__:
            require_finite(getattr(value, field), f"{name}.{field}")
    elif isinstance(value, tuple | list):
        for part in value:
            require_finite(part, name)


def examine(study: Study, bound: float = BOUND, degenerate: bool = False) -> CaseFinding:
    """Compare a study with 40 digits: the motions of its design point, rows of its branches, critical points.

    Parameters
    ----------
    study : Study
    bound : float
        Of the errors relative to 1: of velocities, phases, q, swept value, and of the trace to
        (1 + |trace|)(1 + 1/v), for it is divided by the impact velocities v.
    degenerate : bool
        Whether the design point is itself a critical point. Its motions are then compared with the nearest exact ones,
        for those at the same length are far away (a double root) or do not exist.
    """
    solution, design, codes = study.solution, study.solution.design, {alert.code for alert in study.alerts}
    parts: list[object] = [design, solution.stable_ranges, solution.table, solution.critical_points]
    parts += [part for branch in solution.branches for part in (branch.motions, branch.voltages_by_motion)]
    require_finite([part for part in parts if part is not None])
    errors, texts = [0.0], []
    if design is not None:
        motions = design.motions
        errors += motion_errors(motions, range(len(motions)), solution.device, design.parameter, degenerate)
        if not degenerate:
            _require_all_motions(study)
        if not (motions.stable_mask.any() or solution.on_table) and AlertCode.DESIGN_NOT_STABLE not in codes:
            raise WrongAnswerError("no alert says that there is no stable motion")
        texts.append(f"motions: {len(motions)}")
    if solution.sweep is not None:
        rng = np.random.default_rng(SEED)
        for branch in solution.branches:
            marked = {mark.row for mark in branch.family.marks}
            inner = np.array([i for i in range(1, len(branch.motions) - 1) if i not in marked], dtype=int)
            rows = rng.permutation(inner)[:ROWS]
            errors += motion_errors(branch.motions, rows, solution.device, solution.sweep.parameter, near=True)
        if not (solution.stable_ranges or solution.on_table) and AlertCode.NO_STABLE_MOTION not in codes:
            raise WrongAnswerError("no alert says that the sweep has no stable motion")
        errors.append(point_errors(solution.critical_points, solution.device, solution.sweep.parameter))
        labels = " ".join(point.label for point in solution.critical_points) or "none"
        texts.append(f"branches: {len(solution.branches)}, critical points: {labels}")
    return CaseFinding(", ".join(texts), max(errors), bound)


def _require_all_motions(study: Study) -> None:
    """Look for motions of the design point that the reference finds without a guess and the study does not have."""
    device, design = study.solution.device, study.solution.design
    assert design is not None
    r, n, m = map_restitution(device.restitution, exact.mpf), device.period_ratio, design.motions
    with exact.precise():
        d, gbar = exact.groups(device, design.parameter, design.value)
        for state in exact.all_motions(d, gbar, r, n):
            velocity, phase, u = map(float, state)
            apart = np.abs(m.velocity_bottom - velocity) + np.abs(m.q - 0.5 - u) + np.abs(wrapped(m.phi_bottom - phase))
            if np.min(apart, initial=np.inf) > MATCH and exact.wall_gap(state, d, gbar, r, n) > 0:
                raise WrongAnswerError(
                    f"a motion at q = {rounded_text(u + 0.5)}, velocity {rounded_text(velocity)} was not found"
                )


def point_errors(points: Iterable[Point], device: Device, parameter: Parameter) -> float:
    """Largest relative error of the swept values of critical points, of which none may be beyond what is stated."""
    errors = [0.0]
    for point in points:
        value = float(critical_motion(point, device, parameter)[3])
        error, stated = (x / (abs(value) or 1.0) for x in (abs(point.sweep_value - value), point.error_bound))
        if error > max(stated, SPACING):
            raise WrongAnswerError(
                f"{point.label} is off by {rounded_text(error, ROUGHLY)}, stated {rounded_text(stated, ROUGHLY)}"
            )
        errors.append(error if stated < BOUND else 0.0)
    return max(errors)
