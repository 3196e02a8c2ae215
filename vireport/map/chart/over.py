"""The plane that a chart is of, from what the command line says and what the scenario has."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

import numpy as np
from msgspec.structs import replace

from vireport.base.errors import NumericalError, UsageError
from vireport.base.progress import Progress, portion
from vireport.design.lines import HIGHEST_RESTITUTION, reach
from vireport.map.chart.chart import Chart, ChartStart, loci_over, with_regions
from vireport.map.chart.plane import DevicePlane, is_swept
from vireport.motions.atlas.families import LOOKED_FOR
from vireport.motions.switching import Limits
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.word import Word
from vireport.scenario.blocks import Scenario
from vireport.scenario.hints import for_key
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DesignInput
from vireport.study.plan import Task
from vireport.study.study import Study, analyse

LIMITS = Limits(4, 2)
"""Limits of the motions in a chart, where the scenario has no `motions` block."""

ASIDE = 0.5
"""Part of its value by which an input varies to either side, where no range is given."""

NOT_RUN = (
    *("sweep", "simulation", "motions", "accuracy", "tolerances"),
    *("disturbances", "requirements", "measured"),
)
"""Blocks of a scenario that the run of the design point is without: what they add is of no alert on the device."""

LOCI_SHARE = 0.5
"""Share of the time of a chart that its loci take, as measured; its regions take the other half."""

FORM = "such as inclination_deg=0..90,length_m=0.3..1.0; a range may be left out"


def chart_of(loaded: Loaded, over: str, progress: Progress) -> Chart:
    """Find the chart of a scenario's device over two inputs, as ``--over`` names them.

    Raises
    ------
    UsageError
        If `over` does not name two inputs, with ranges that make sense.
    """
    block = loaded.scenario.motions
    limits = LIMITS if block is None else Limits(block.impacts, block.periods)
    plane = plane_of(loaded.scenario, over)
    starts = list(_starts(loaded.scenario, plane))
    drawn = loci_over(plane, limits, portion(progress, 0.0, LOCI_SHARE), starts=starts)
    filled = with_regions(drawn, Device.of(loaded.scenario), portion(progress, LOCI_SHARE, 1.0))
    tolerances = loaded.scenario.tolerances
    if tolerances is not None:
        first, second = plane.inputs
        filled = replace(filled, tolerances=(tolerances.off(first), tolerances.off(second)))
    design = filled.design
    return filled if design is None else replace(filled, design=replace(design, study=_run_of(loaded)))


def _run_of(loaded: Loaded) -> Study | None:
    """What a run finds of the design point by itself; None where a run ends without results."""
    alone = loaded.scenario.model_copy(update=dict.fromkeys(NOT_RUN))
    try:
        return analyse(replace(loaded, scenario=alone), (Task.JSON,))
    except NumericalError:
        return None


def _starts(scenario: Scenario, plane: DevicePlane) -> Iterator[ChartStart]:
    """The motions that a scenario gives as starts of families, at their values of the swept parameter.

    Regions are filled by what is solved inside each, which knows longer words only where they join others.

    Raises
    ------
    UsageError
        Where the chart has no place for one.
    """
    device = Device.of(scenario)
    for k, row in enumerate(scenario.motions.starts if scenario.motions is not None else ()):
        path, name = f"motions.starts.{k}", scenario.parameter.value
        varied = next((n for n, of_plane in enumerate(plane.inputs) if of_plane.value == name), None)
        if varied is None:
            raise UsageError(f"--over: {path} is of {name}, which is none of the inputs (leave it out, or name {name})")
        if len(row.word) > LOOKED_FOR:
            raise UsageError(f"--over: {path}: a chart takes words of up to {LOOKED_FOR} impacts (got {row.word})")
        other = device.value_of(plane.inputs[1 - varied])
        if other is None:
            raise UsageError(f"--over: {path} needs a value of {plane.inputs[1 - varied].path} (give it one)")
        at = np.insert([float(other)], varied, row.value)
        if plane.room(at) < 0:
            raise UsageError(f"--over: {path} is not in the plane (widen its ranges, or leave it out)")
        yield ChartStart(Word.of(row.word, row.periods), varied, (float(at[0]), float(at[1])))


def plane_of(scenario: Scenario, over: str) -> DevicePlane:
    """The plane of two inputs; raises as `chart_of`."""
    parts = [part.strip() for part in over.split(",")]
    if len(parts) != 2:
        raise UsageError(f"--over: {over!r} does not name two inputs ({FORM})")
    inputs, ranges = zip(*(_axis(scenario, part) for part in parts), strict=True)
    if inputs[0] is inputs[1]:
        raise UsageError(f"--over: {inputs[0]} is named twice ({FORM})")
    Device.of(scenario).of_sine("the chart")
    if not any(is_swept(varied, Device.of(scenario).recoils) for varied in inputs):
        # Curves are found from sweeps across the plane, or from lines along the restitution of either membrane.
        restitutions = set(inputs) <= set(RESTITUTIONS)
        if restitutions and DesignInput.RESTITUTION in inputs:
            allowed = "restitution_bottom with restitution_top, or one of the three"
            raise UsageError(f"--over: {inputs[0]} and {inputs[1]} overlap (allowed: {allowed})")
        if not restitutions:
            both = "a restitution and the mass of a free capsule"
            raise UsageError(f"--over: {inputs[0]} and {inputs[1]} are {both} (allowed: at most one of the two)")
    low, high = np.array(ranges, dtype=float).T
    device = Device.of(scenario).with_values(dict(zip(inputs, low.tolist(), strict=True)))
    highest = DesignInput.RESTITUTION.limits[1]
    for varied in (varied for varied in device.inputs if varied in RESTITUTIONS and varied not in inputs):
        value = float(device.value_of(varied))
        if not 0 < value <= highest:
            allowed = f"above 0 and up to {highest:g}, or as one of the inputs"  # at 0, grazing is not followed
            raise UsageError(f"--over: {varied.path} is {value:g} (allowed: {allowed})")
    absent = [varied.path for varied in DesignInput if device.value_of(varied) is None]
    if absent:
        raise UsageError(f"--over: {absent[0]} has no value (give it one in the scenario, or name it in --over)")
    for corner in (device, device.with_values(dict(zip(inputs, high.tolist(), strict=True)))):
        if corner.inclination_deg and corner.unresolved:
            raise UsageError(f"--over: {corner.unresolved}")
    return DevicePlane((inputs[0], inputs[1]), low, high, device)


def _axis(scenario: Scenario, part: str) -> tuple[DesignInput, tuple[float, float]]:
    name, limits, text = (word.strip() for word in part.partition("="))
    varied = next((candidate for candidate in DesignInput if name in (candidate.value, candidate.path)), None)
    if varied is None:
        meant = for_key("", name, None, {x.value: x.unit.replace("°", "deg") for x in DesignInput})
        raise UsageError(f"--over: unknown input {name!r}{meant} (allowed: {', '.join(DesignInput)})")
    # Both restitutions together are their mean, and keep their difference.
    least, most = reach(Device.of(scenario), varied) if varied is DesignInput.RESTITUTION else varied.limits
    most = max(most, varied.limits[1]) if scenario.device.alike else most
    low, high = _range(varied, text) if limits else _usual_range(scenario, varied)
    if not least <= low < high <= most:
        allowed = f"ascending, from {least:g} to {most:g}"
        raise UsageError(f"--over: {varied}: {low:g}..{high:g} is no range of it (allowed: {allowed})")
    return varied, (low, high)


def _range(varied: DesignInput, text: str) -> tuple[float, float]:
    try:
        low, high = (float(end) for end in text.split(".."))
    except ValueError:
        low = high = np.nan
    if not (isfinite(low) and isfinite(high)):
        raise UsageError(f"--over: {varied}={text}: {text!r} is no range ({FORM})")
    return low, high


def _usual_range(scenario: Scenario, varied: DesignInput) -> tuple[float, float]:
    """The sweep's range, all inclinations, or half of the value to either side."""
    sweep = scenario.sweep
    if sweep is not None and sweep.parameter == varied.value:
        return min(sweep.from_, sweep.to), max(sweep.from_, sweep.to)
    if varied is DesignInput.INCLINATION:
        return varied.limits
    value = Device.of(scenario).value_of(varied)
    if value is None:
        raise UsageError(f"--over: {varied} has no value to vary around (give its range: {varied}=from..to)")
    high = (1 + ASIDE) * value
    return (1 - ASIDE) * value, min(high, HIGHEST_RESTITUTION) if varied in RESTITUTIONS else high
