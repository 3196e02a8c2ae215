"""What a best design is looked for in: the designs that there are, what they are judged by, and their scenarios.

A design is a point t of the unit cube, 0 and 1 in each coordinate being the ends of the range of an input.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, cast

import numpy as np
import yaml
from numpy.typing import NDArray

from vireport.base import UsageError
from vireport.design import DesignPoint
from vireport.gate import MARGINS
from vireport.motions import CRITICAL, Event
from vireport.physics import (
    Conversion,
    Device,
    Membrane,
    Voltages,
    conversion,
    magnitude,
    voltages,
)
from vireport.scenario import (
    Design,
    DesignInput,
    DesignPath,
    Loaded,
    Objective,
    loads,
    to_dict,
)
from vireport.study import (
    Study,
    Task,
    analyse,
    device_of,
    membrane_of,
)

Floats = NDArray[np.float64]

U_DIFFERENCE, DEFLECTION, FIELD = "u_difference", "deflection", "field"

SHAKER = ACCELERATION, STROKE, FORCE = "acceleration_g", "stroke_m", "force_n"
"""Quantities of `physics.Shaker`, by their names there."""

LIMITS = {
    "u_ave_at_least_v": (Objective.U_AVE, True),
    "u_bottom_top_difference_at_most_v": (U_DIFFERENCE, False),
    "deflection_at_most_m": (DEFLECTION, False),
    "power_at_least_mw": (Objective.POWER, True),
    "field_at_most_percent": (FIELD, False),
    "acceleration_at_most_g": (ACCELERATION, False),
    "stroke_at_most_m": (STROKE, False),
    "force_at_most_n": (FORCE, False),
}
"""Requirements that every cell of a grid is judged by: their quantity, and whether it is to be at least the limit."""

NEEDED = {
    "sweep": ("stable_from", "u_ave_difference_at_most_v", "word", "words"),
    "simulation": ("crosscheck_passed",),
    "accuracy": (),
}
"""Blocks without which some requirements cannot be judged; where none of them is asked for, designs go without."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A search for the best design.

    Attributes
    ----------
    loaded : Loaded
        The scenario.
    design : Design
        What it says of the search.
    margins : tuple of (tuple of Event, float)
        The margins required, as shares, to critical points of some kinds.
    limits : tuple of (str, bool, float)
        Quantities, whether they are to be at least a limit, and the limit.
    tolerated : float
        Share of the tolerances at all corners of which a design must have stable motion.
    """

    loaded: Loaded
    design: Design
    margins: tuple[tuple[tuple[Event, ...], float], ...]
    limits: tuple[tuple[str, bool, float], ...]
    tolerated: float = 0.0

    @property
    def objective(self) -> Objective:
        """What shall be as large as possible."""
        return self.design.maximise

    @property
    def paths(self) -> tuple[DesignPath, ...]:
        """The inputs that vary."""
        return tuple(varied.path for varied in self.design.vary)

    @property
    def given(self) -> list[float]:
        """What these are in the scenario."""
        data = to_dict(self.loaded.scenario)
        return [float(cast(Any, reduce(dict.__getitem__, path.split("."), data))) for path in self.paths]

    @property
    def widths(self) -> Floats:
        """Widths of their ranges."""
        return np.array([abs(varied.to - varied.from_) for varied in self.design.vary])

    @property
    def share(self) -> float:
        """The margin required to critical points of any kind; 0 where none is."""
        return max((share for kinds, share in self.margins if len(kinds) == len(CRITICAL)), default=0.0)

    def half_widths(self, device: Device) -> dict[DesignInput, Any]:
        """By how much each input is off at the corners, in its unit, for devices as arrays."""
        tolerances = self.loaded.scenario.tolerances
        if tolerances is None or not self.tolerated:
            return {}
        off = {varied: tolerances.off(varied) for varied in DesignInput}
        return {
            varied: self.tolerated * np.maximum(fixed, getattr(device, varied) * percent / 100)
            for varied, (fixed, percent) in off.items()
            if fixed or percent
        }

    def with_margin(self, share: float) -> Problem:
        """The same search with another margin required to critical points of any kind."""
        others = tuple((kinds, other) for kinds, other in self.margins if len(kinds) < len(CRITICAL))
        return replace(self, margins=(*others, (CRITICAL, share)))

    def values(self, t: Floats) -> Floats:
        """Values of the inputs at designs (..., inputs); exact at the ends."""
        low, high = (np.array([f(v.from_, v.to) for v in self.design.vary]) for f in (min, max))
        return np.asarray(np.where(t == 1, high, low + (high - low) * t))

    def at(self, t: Floats) -> tuple[Device, Membrane | None]:
        """Device and membrane of designs (cells, inputs), the inputs as arrays; of a design (inputs,), as numbers."""
        device, membrane = device_of(self.loaded.scenario), membrane_of(self.loaded.scenario)
        for path, column in zip(self.paths, self.values(t).T, strict=True):
            name = path.rpartition(".")[2]
            changed: dict[str, Any] = {name: column if column.ndim else float(column)}
            if hasattr(device, name):
                device = device.with_values(changed)
            elif hasattr(membrane, name):
                membrane = replace(cast(Membrane, membrane), **changed)
            elif membrane is not None and membrane.dielectric is not None:
                membrane = replace(membrane, dielectric=replace(membrane.dielectric, **changed))
        return device, membrane

    def scenario_text(self, t: Floats, lean: bool = False) -> str:
        """The scenario of a design, as YAML; a `lean` one has only what its requirements are judged by."""
        data = to_dict(self.loaded.scenario)
        data["design"] = None
        for path, value in zip(self.paths, self.values(t), strict=True):
            *blocks, key = path.split(".")
            reduce(dict.__getitem__, blocks, data)[key] = float(value)
        required = data["requirements"] or {}
        for block, keys in NEEDED.items() if lean else ():
            if all(required.get(key) is None for key in keys):
                data[block] = None
        return str(yaml.safe_dump(_present(data), sort_keys=False, allow_unicode=True))

    def study(self, t: Floats) -> Study:
        """The results of a design as a run has them, held against all that is required.

        Further kinds of requirement join here: whatever a run judges, a best design has met.
        """
        return analyse(loads(self.scenario_text(t, lean=True), self.loaded.document.name), (Task.JSON,))

    def value_of(self, study: Study) -> float:
        """The objective in the results of a design: the least of its stable motions."""
        design, period = cast(DesignPoint, study.solution.design), study.solution.device.period_s
        if self.objective is Objective.MARGIN:
            return 100 * smallest_margin(design)
        m = design.motions
        columns = quantities(m.velocity_bottom, m.wall_gap, design.voltages, design.conversion, period)
        return float(columns[self.objective][m.stable].min())


def problem_of(loaded: Loaded) -> Problem:
    """The search that a scenario asks for.

    Raises
    ------
    UsageError
        If it asks for none, or requires another motion than 1:1.
    """
    scenario = loaded.scenario
    if scenario.design is None:
        name = loaded.document.name
        raise UsageError(f"{name}: has no design block (give one: what may vary, and what to maximise)")
    allowed = () if scenario.requirements is None else scenario.requirements.allowed
    if allowed and not {"BT", "TB"} & set(allowed):
        raise UsageError(
            f"{loaded.document.name}: requirements: {', '.join(allowed)} cannot be required of a best design, which is "
            "looked for among 1:1 motions only (allow BT as well, or require no word)"
        )
    given = {} if scenario.requirements is None else to_dict(scenario.requirements)
    margins = tuple((kinds, given[key] / 100) for key, (_, kinds) in MARGINS.items() if given.get(key) is not None)
    limits = tuple((*of, given[key]) for key, of in LIMITS.items() if given.get(key) is not None)
    proved = scenario.tolerances is not None and given.get("yield_at_least_percent") in (None, 100)
    return Problem(loaded, scenario.design, margins, limits, float(proved))


def quantities(
    bottom: Floats, gap: Floats, volts: Voltages | None, converted: Conversion | None, period_s: Any
) -> dict[str, Floats]:
    """What objectives and limits are of, for motions as arrays."""
    columns: dict[str, Floats] = {Objective.VELOCITY_BOTTOM: bottom, Objective.WALL_GAP: gap}
    if volts is not None:
        both = volts.bottom_v + volts.top_v
        columns |= {Objective.U_AVE: volts.average_v, Objective.VOLTAGE_RATE: both / period_s}
        columns |= {Objective.U_BOTTOM: volts.bottom_v, Objective.U_TOP: volts.top_v}
        columns |= {U_DIFFERENCE: magnitude(volts.bottom_v - volts.top_v), DEFLECTION: volts.deflection_m}
    if converted is not None:
        columns |= {Objective.POWER: converted.power_mw, Objective.EFFICIENCY: converted.efficiency}
    return columns


def of_impacts(
    bottom: Floats, top: Floats, gap: Floats, unit: Any, membrane: Membrane | None, r: Any, period_s: Any
) -> dict[str, Floats]:
    """The `quantities` of impacts with dimensionless velocities, `unit` [m/s], and the field over its limit [%].

    All may be arrays, and numbers of the membrane too.
    """
    if membrane is None:
        return quantities(bottom, gap, None, None, period_s)
    speeds = unit * bottom, unit * top
    volts, dielectric = voltages(*speeds, membrane), membrane.dielectric
    if dielectric is None:
        return quantities(bottom, gap, volts, None, period_s)
    converted = conversion((volts.bottom_v, volts.top_v), speeds, membrane, dielectric, r, period_s)
    columns = quantities(bottom, gap, volts, converted, period_s)
    return columns | {FIELD: 100 * converted.field_v_m / dielectric.breakdown_field_v_m}


def smallest_margin(design: DesignPoint) -> float:
    """Least relative distance to an end of stable motion; infinite where it ends in no input."""
    return min((abs(one.relative) for one in design.endings() if one.relative is not None), default=np.inf)


def design_input(path: DesignPath) -> DesignInput | None:
    """The same input among those that have margins; None of one on which no motion depends."""
    return next((varied for varied in DesignInput if varied.path == path), None)


def _present(data: dict[str, Any]) -> dict[str, Any]:
    """Plain data without what is absent."""
    kept = {key: value for key, value in data.items() if value is not None}
    return {key: _present(value) if isinstance(value, dict) else value for key, value in kept.items()}
