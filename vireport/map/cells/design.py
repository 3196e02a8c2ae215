"""The design point of a map of cells: the scenario at the values that its file gives beside the axes."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.map.cells.cells import MapPlan
from vireport.map.design import MapDesign, MapMargin, nearest_either_way
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DesignInput
from vireport.study.plan import Task
from vireport.study.study import Study, analyse


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
    values = {varied.value: device.value_of(varied) for varied in DesignInput} | {"ball_mass_kg": mass}
    inputs = tuple(float(values[name]) for name in plan.names)
    inside = all(low <= value <= high for value, (low, high) in zip(inputs, plan.ends, strict=True))
    return MapDesign(inputs, nearest_either_way(_ends(study, plan.names)), study, inside)


def _ends(study: Study, names: tuple[str, ...]) -> Iterator[MapMargin]:
    """Where the stable motions of a design point end along the axes of a map, or others take over."""
    design = study.solution.design
    for end in design.limits() if design is not None and design.motions.stable_mask.any() else ():
        if end.parameter.value in names:
            axis = names.index(end.parameter.value)
            yield MapMargin(axis, end.event, end.sweep_value, end.distance, end.error_bound, end.taken_over)
