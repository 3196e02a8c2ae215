"""The design point of a map: the scenario at the values that its file gives beside the axes, as a run answers it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.map.cells.cells import MapPlan
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DesignInput
from vireport.study.plan import Task
from vireport.study.study import Study, analyse

if TYPE_CHECKING:
    from vireport.design.margins import Margin


class MapDesign(Struct, frozen=True, eq=False):
    """The design point of a map.

    Attributes
    ----------
    study : Study
        What a run finds of it.
    inputs : tuple of float
        Its values along the axes.
    inside : bool
        Whether these are within the ends of all axes.
    """

    study: Study
    inputs: tuple[float, ...]
    inside: bool

    def ends(self, names: tuple[str, ...]) -> Iterator[tuple[int, Margin]]:
        """Along which axis, and how far away, its motion ends or another takes over: the nearest either way."""
        design, seen = self.study.solution.design, set[tuple[str, bool]]()
        for margin in design.limits() if design is not None and design.motions.stable_mask.any() else ():
            key = margin.parameter.value, margin.distance > 0
            if key[0] in names and key not in seen:
                seen.add(key)
                yield names.index(key[0]), margin


def map_design(loaded: Loaded | None, plan: MapPlan) -> MapDesign | None:
    """Solve the scenario at the design point of a map; None where it has none.

    Parameters
    ----------
    loaded : Loaded or None
        `LoadedMap.design`.
    plan : MapPlan

    Raises
    ------
    NumericalError
        As a run of it.
    """
    if loaded is None:
        return None
    study = analyse(loaded, (Task.JSON,))
    device, mass = study.solution.device, study.scenario.device.ball_mass_kg
    values = {each.value: device.value_of(each) for each in DesignInput} | {"ball_mass_kg": mass}
    inputs = tuple(float(values[name]) for name in plan.names)
    inside = all(low <= value <= high for value, (low, high) in zip(inputs, plan.ends, strict=True))
    return MapDesign(study, inputs, inside)
