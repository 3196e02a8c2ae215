"""What was measured of methods and solvers as plain data, for results.json and accuracy.json."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from vireport.trust import Compliance, CompliantOrbit, WorkPrecision


DIVERGED = 1e300
"""Size beyond which a number means that something overflowed; JSON has no infinity."""


def accuracy_data(work: WorkPrecision) -> dict[str, Any]:
    """Errors and times of every method and setting. Times differ from run to run; nothing else does."""
    return {
        "nothing": work.nothing or None,
        "value": work.yardstick.value if work.yardstick is not None else None,
        "repeats": work.repeats,
        **{name: plain(getattr(work, name)) for name in ("machine", "quantities", "runs", "orders")},
        "left_out": [{"method": method, "why": why} for method, why in work.absent],
    }


def compliance_data(made: Compliance) -> dict[str, Any]:
    """The compliant motion beside the rigid one, and every run of a solver."""
    names = ("rigid", "varied", "design_value", "order", "rungs", "convergence", "volts", "runs")
    return {
        "nothing": made.reason or None,
        "grade": made.grade,
        **{name: plain(getattr(made, name)) for name in names},
        "error_bounds": [None if rung.orbit is None else _rung_bound(rung.orbit) for rung in made.rungs],
        "criteria": [{**plain(one), "grade": one.grade} for one in made.criteria],
    }


def _rung_bound(orbit: CompliantOrbit) -> float:
    """Relative error of a compliant motion: tolerance and residual over the distance of a multiplier from 1."""
    from vireport.trust import TOLERANCE

    return 10 * (TOLERANCE + orbit.residual) / min(abs(1 - multiplier) for multiplier in orbit.multipliers)


def plain(value: Any) -> Any:
    """Dataclasses, arrays and tuples as dictionaries, lists and numbers; null for what is not finite."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, float):
        return value if abs(value) < DIVERGED else None
    return value
