"""The problem of a search for the best design: all designs, what they are judged by, and their scenarios.

A design is a point t of the unit cube, 0 and 1 in each coordinate being the ends of the range of an input.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from itertools import product
from typing import Any, cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import UsageError
from vireport.design.point import DesignPoint
from vireport.motions.events import CRITICAL, Event
from vireport.physics.device import Device, Shaker
from vireport.physics.energy import Conversion, Membrane, Voltages
from vireport.physics.reach import is_table
from vireport.scenario.blocks import (
    DEMANDS,
    DesignBlock,
    DesignPath,
    Objective,
    RequirementsBlock,
    to_dict,
)
from vireport.scenario.demands import LimitKind, Need
from vireport.scenario.keys import value_at
from vireport.scenario.loading import Loaded, loads
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.scenario.writing import as_yaml
from vireport.study.judging.designs import Designs, keeps_motion
from vireport.study.judging.evidence import Limit
from vireport.study.judging.requirements import OfMargin, OfMotions, OfRun, OfShaker, Requirement, required, spared
from vireport.study.plan import refuse_undecidable
from vireport.study.study import Study, analyse
from vireport.text.requirements import Question

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

USUAL: dict[str, tuple[float | bool, tuple[str, ...]]] = {
    "reached_from_rest": (True, ("word", "words")),
    "efficiency_at_most_percent": (100.0, ()),
    "field_at_most_percent": (100.0, ()),
}
"""What is required unless the requirements say otherwise: the values, of limits in per cent, and what else says it.

A device that is switched on comes to its motion: a run calls none good that does not. No energy beyond what the impacts
lose, no field beyond breakdown. Without these a search ends beyond at least one: there the formulae go on rising, and
no device does."""

OF_SHAKER: dict[Objective, Callable[[Shaker], Any]] = {
    Objective.ACCELERATION: lambda shaker: shaker.acceleration_g,
    Objective.STROKE: lambda shaker: shaker.stroke_m,
}
"""Objectives that motions have no part in."""

AT_LIMIT = 1e-6
"""Share of a range within which a design is at its end."""

ASIDE, USUAL_LENGTH_M = 0.5, 0.7
"""Of the range of the length in an example of a design block: to either side of the design's, or of a usual one."""


class Problem(Struct, frozen=True):
    """A search for the best design.

    Attributes
    ----------
    loaded : Loaded
        The scenario.
    design : Design
        The block of the scenario on the search.
    required : tuple of (Requirement, Limit)
        The requirements of the scenario, with those that `USUAL` adds.
    margins : tuple of (tuple of Event, float)
        The margins required, as shares, to critical points of some kinds.
    tolerated : float
        Share of the tolerances at whose corners a design must have stable motion.
    usual : tuple of (Requirement, Limit)
        The requirements that the scenario does not set.
    """

    loaded: Loaded
    design: DesignBlock
    required: tuple[tuple[Requirement, Limit], ...]
    margins: tuple[tuple[tuple[Event, ...], float], ...]
    tolerated: float = 0.0
    usual: tuple[tuple[Requirement, Limit], ...] = ()

    @property
    def objective(self) -> Objective:
        """The quantity to be made as large or as small as possible."""
        return self.design.objective

    @property
    def sign(self) -> float:
        """1 where the objective is to be large, -1 where small: the search maximises the sign times the objective."""
        return 1.0 if self.design.maximise is not None else -1.0

    @property
    def limits(self) -> list[tuple[OfMotions | OfShaker, Limit]]:
        """The requirements that arrays of designs are judged by, exactly, with their limits."""
        pairs = ((requirement.quantity, limit) for requirement, limit in self.required)
        return [(quantity, limit) for quantity, limit in pairs if isinstance(quantity, OfMotions | OfShaker)]

    @property
    def most_efficient(self) -> float | None:
        """The efficiency that no design may exceed, as a share; None where it is not limited."""
        block = self.loaded.scenario.requirements
        percent = None if block is None else block.efficiency_at_most_percent
        return None if percent is None else percent / 100

    @property
    def starts_by_itself(self) -> bool:
        """Whether the device must come to its motion when it is switched on."""
        return any(row.question is Question.FROM_REST and limit.kind is LimitKind.HELD for row, limit in self.required)

    @property
    def names_words(self) -> bool:
        """Whether words are required of the stable motions."""
        return any(requirement.demand.kind is LimitKind.WORDS for requirement, _ in self.required)

    @property
    def is_costly(self) -> bool:
        """Whether a run of a design follows its motions, simulates it, or proves that all within tolerances work."""
        demands = [requirement.demand for requirement, _ in self.required]
        followed = self.names_words or any(Need.SIMULATION in demand.needs for demand in demands)
        return followed or self.loaded.scenario.tolerances is not None

    def may_meet(self, t: Floats, share: float) -> Mask:
        """Which designs (cells, inputs) may have a margin, and meet what only a run judges; all others do not.

        For a yield, which takes long to refute, stable motion at the corners of the tolerances stands: see `may_yield`.
        """
        designs = self.designs(t)
        kept = keeps_motion(designs, share) if share > 0 else np.ones(len(t), dtype=bool)
        return self._refuted(designs, kept, of_yield=False)

    def may_yield(self, t: Floats) -> Mask:
        """Which designs may reach a required yield; all others do not."""
        return self._refuted(self.designs(t), np.ones(len(t), dtype=bool), of_yield=True)

    def _refuted(self, designs: Designs, kept: Mask, of_yield: bool) -> Mask:
        """The designs that are kept once those are sorted out that surely fail a requirement that only a run judges."""
        for requirement, limit in self.required:
            judged_by = requirement.quantity
            if not isinstance(judged_by, OfRun) or judged_by.before_run is None:
                continue
            if of_yield == (Need.TOLERANCES in requirement.demand.needs):
                rows = np.flatnonzero(kept)
                kept[rows] = judged_by.may_meet(designs.select(rows), limit)
        return kept

    @property
    def paths(self) -> tuple[DesignPath, ...]:
        """Paths of the inputs that vary, in the order of the scenario."""
        return tuple(varied.path for varied in self.design.vary)

    @property
    def stated(self) -> list[float]:
        """The values that the scenario states of the inputs that vary."""
        data = to_dict(self.loaded.scenario) | {"measured": None}  # of another device
        return [float(cast(Any, reduce(dict.__getitem__, path.split("."), data))) for path in self.paths]

    def at_limits(self, t: Floats) -> Iterator[tuple[DesignPath, bool]]:
        """The inputs that are at an end of their range, which could be wider, and whether it is the upper one."""
        for varied, share in zip(self.design.vary, t.tolist(), strict=True):
            low, high = sorted((varied.from_, varied.to))
            least, most = varied.path.limits
            if share <= AT_LIMIT and low > least:
                yield varied.path, False
            elif share >= 1 - AT_LIMIT and high < most:
                yield varied.path, True

    @property
    def widths(self) -> Floats:
        """Widths of the ranges of the inputs that vary, each in its unit."""
        return np.array([abs(varied.to - varied.from_) for varied in self.design.vary])

    @property
    def share(self) -> float:
        """The margin required to critical points of any kind; 0 where none is."""
        return max((share for kinds, share in self.margins if len(kinds) == len(CRITICAL)), default=0.0)

    def half_widths(self, designs: Designs) -> dict[DesignInput, Any]:
        """Deviation of each input at the corners of the tolerances, in its unit."""
        return {varied: self.tolerated * off for varied, off in designs.half_widths.items()} if self.tolerated else {}

    def with_margin(self, share: float) -> Problem:
        """Return the search with another margin required to critical points of any kind, as a share."""
        others = tuple((kinds, other) for kinds, other in self.margins if len(kinds) < len(CRITICAL))
        return replace(self, margins=(*others, (CRITICAL, share)))

    def values(self, t: Floats) -> Floats:
        """Values of the inputs at designs (..., inputs); exact at the ends."""
        low, high = (np.array([f(v.from_, v.to) for v in self.design.vary]) for f in (min, max))
        return np.asarray(np.where(t == 1, high, low + (high - low) * t))

    def at(self, t: Floats) -> tuple[Device, Membrane | None]:
        """Device and membrane of designs (cells, inputs), the inputs as arrays; of a design (inputs,), as numbers."""
        device, membrane = Device.of(self.loaded.scenario), Membrane.of(self.loaded.scenario)
        for path, column in zip(self.paths, self.values(t).T, strict=True):
            name = path.rpartition(".")[2]
            changed: dict[str, object] = {name: column if column.ndim else float(column)}
            if hasattr(device, name):
                device = device.with_values(changed)
                membrane = membrane and membrane.of_device(device)
            elif hasattr(membrane, name):
                membrane = replace(cast(Membrane, membrane), **changed)
            elif membrane is not None and membrane.dielectric is not None:
                membrane = replace(membrane, dielectric=replace(membrane.dielectric, **changed))
        return device, membrane

    def designs(self, t: Floats) -> Designs:
        """Designs (cells, inputs) with their motions."""
        return Designs(self.loaded.scenario, *self.at(t), len(t))

    def scenario_text(self, t: Floats, lean: bool = False) -> str:
        """The scenario of a design, as YAML; a `lean` one has only what its requirements are judged by."""
        data = to_dict(self.loaded.scenario) | {"measured": None}  # of another device
        data["design"] = None
        for path, value in zip(self.paths, self.values(t), strict=True):
            *blocks, key = path.split(".")
            reduce(dict.__getitem__, blocks, data)[key] = float(value)
        data |= dict.fromkeys(spared(self.required)) if lean else {}
        return as_yaml(data)

    def study(self, t: Floats) -> Study:
        """The results of a design as a run has them, held against all that is required.

        Raises
        ------
        ScenarioError, NumericalError
            Where a run would end with it.
        """
        return analyse(loads(self.scenario_text(t, lean=True), self.loaded.document.name), ())

    def starts(self, t: Floats) -> bool | None:
        """Whether a design comes from rest to its 1:1 motion; None where only a run tells.

        That is where words are required, and where it is switched on as a block of disturbances says.
        """
        if self.names_words or value_at(self.loaded.scenario, "disturbances") is not None:
            return None
        return next(self.designs(t[None]).from_rest()).is_one_to_one

    def value_of(self, study: Study, t: Floats) -> float:
        """The signed objective of a design t (inputs,), by its results: that of its worst stable motion."""
        design, period = cast(DesignPoint, study.solution.design), study.solution.device.period_s
        if self.objective is Objective.MARGIN:
            return 100 * smallest_margin(design)
        if (number := self.of_inputs(self.at(t)[0], t)) is not None:
            return self.sign * float(number)
        m = design.motions
        columns = objectives(
            m.velocity_bottom, m.wall_gap, design.voltages_by_motion, design.conversion_by_motion, period
        )
        return float((self.sign * columns[self.objective][m.stable_mask]).min())

    def of_inputs(self, device: Device, t: Floats) -> Any:
        """The objective of designs t (..., inputs) where it is an input or what the shaker must do; else None."""
        if self.objective.path is not None:
            return self.values(t)[..., self.paths.index(self.objective.path)]
        if self.objective in OF_SHAKER:
            return OF_SHAKER[self.objective](device.shaker(Parameter.LENGTH, device.length_m))
        return None


def problem_of(loaded: Loaded) -> Problem:
    """The search that a scenario asks for.

    Raises
    ------
    UsageError
        If it asks for none, requires another motion than 1:1, or its ball is one on a table.
    """
    scenario = loaded.scenario
    design = scenario.design
    if design is None:
        sweep = scenario.sweep
        _refuse_table(
            loaded, [Device.of(scenario)], scenario.parameter, () if sweep is None else (sweep.from_, sweep.to)
        )
        name, length = loaded.document.name, scenario.device.length_m or USUAL_LENGTH_M
        raise UsageError(
            f"{name}: has no design block, which says what may vary and what to maximise (these lines, for example):",
            "design:",
            f"  maximise: {Objective.MARGIN if scenario.device.ball_mass_kg is None else Objective.U_AVE}",
            "  vary:",
            f"    - {{path: {DesignPath.LENGTH}, from: {length * (1 - ASIDE):.3g}, to: {length * (1 + ASIDE):.3g}}}",
        )
    allowed = () if scenario.requirements is None else scenario.requirements.allowed
    if allowed and not {"BT", "TB"} & set(allowed):
        raise UsageError(
            f"{loaded.document.name}: requirements: {', '.join(allowed)} cannot be required of a best design, which is "
            "looked for among 1:1 motions only (allow BT as well, or require no word)"
        )
    refuse_undecidable(scenario)
    loaded, usual = _with_usual(loaded)
    scenario, required_keys = loaded.scenario, tuple(required(loaded.scenario))
    margins = tuple(
        (row.quantity.kinds, limit.value / 100) for row, limit in required_keys if isinstance(row.quantity, OfMargin)
    )
    least = value_at(scenario, "requirements.yield_at_least_percent")
    proved = scenario.tolerances is not None and least in (None, 100)
    limits = tuple((row, limit) for row, limit in required_keys if row.key in usual)
    problem = Problem(loaded, design, required_keys, margins, float(proved), limits)
    corners = np.array(list(product((0.0, 1.0), repeat=len(design.vary))))
    _refuse_table(loaded, [problem.at(t)[0] for t in corners], Parameter.LENGTH)
    return problem


def _refuse_table(
    loaded: Loaded, devices: Sequence[Device], parameter: Parameter, ends: tuple[float, ...] = ()
) -> None:
    """Refuse to look for 1:1 motions where the ball strikes the top of no device any more in the long run.

    Devices at the corners of ranges stand for all in them, as `is_table` says of a sweep.
    """
    if all(is_table(device, parameter, ends) for device in devices):
        raise UsageError(
            f"{loaded.document.name}: the ball does not reach the top, as one on a table, and a best design is looked "
            "for among 1:1 motions only (bring the top within reach; vireport map --over draws where motions on a "
            "table are stable)"
        )


def _with_usual(loaded: Loaded) -> tuple[Loaded, tuple[str, ...]]:
    """A scenario that also requires what every design must meet, and the keys that it did not give."""
    scenario = loaded.scenario
    block, membrane = scenario.requirements or RequirementsBlock(), Membrane.of(scenario)
    evaluated = {Need.DIELECTRIC: membrane is not None and membrane.dielectric is not None}
    lacking = {
        key: limit
        for key, (limit, others) in USUAL.items()
        if all(getattr(block, name) is None for name in (key, *others)) and all(evaluated[need] for need in _needs(key))
    }
    limited = block.model_copy(update=lacking) if lacking else scenario.requirements
    return replace(loaded, scenario=scenario.model_copy(update={"requirements": limited})), tuple(lacking)


def _needs(key: str) -> tuple[Need, ...]:
    return next(demand.needs for demand, keys in DEMANDS.items() if key in keys)


def objectives(
    bottom: Floats, gap: Floats, volts: Voltages | None, converted: Conversion | None, period_s: Any
) -> dict[Objective, Floats]:
    """What motions can be the best in, as arrays; but for the margin."""
    columns = {Objective.VELOCITY_BOTTOM: bottom, Objective.WALL_GAP: gap}
    if volts is not None:
        both = volts.bottom_v + volts.top_v
        columns |= {Objective.U_AVE: volts.average_v, Objective.VOLTAGE_RATE: both / period_s}
        columns |= {Objective.U_BOTTOM: volts.bottom_v, Objective.U_TOP: volts.top_v}
        columns |= {Objective.DEFLECTION: volts.deflection_m}
    if converted is not None:
        columns |= {Objective.POWER: converted.power_mw, Objective.EFFICIENCY: converted.efficiency}
    return columns


def smallest_margin(design: DesignPoint) -> float:
    """Least relative distance to an end of stable motion; infinite where it ends in no input."""
    return min((end.size for end in design.limits()), default=np.inf)


def design_input(path: DesignPath) -> DesignInput | None:
    """The input of a path among those that have margins; None for one on which no motion depends."""
    return next((varied for varied in DesignInput if varied.path == path), None)
