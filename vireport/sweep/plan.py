"""What a map computes, derived from its file before anything is computed."""

from __future__ import annotations

import math

from vireport.analysis import SMALLEST_LOSS
from vireport.errors import NumericalError
from vireport.scenario import LoadedMap, Map
from vireport.study import (
    device_of,
    membrane_of,
)
from vireport.sweep.cells import MapPlan

CHUNK_CELLS = 32_768
"""Cells of a chunk: some tenths of a second of work, beside which starting and storing it is little."""

CHUNK_IMPACTS = 4_000_000
"""Impacts of a chunk that is simulated: a few seconds of work."""


def map_plan(loaded: LoadedMap) -> MapPlan:
    """Derive the plan of a map from its file.

    Raises
    ------
    NumericalError
        If the restitution is outside the theory.
    """
    scenario, block = loaded.scenario, loaded.block
    if 1 - scenario.device.restitution < SMALLEST_LOSS:
        raise NumericalError(
            f"device.restitution: {scenario.device.restitution!r} means impacts with hardly any loss, for which the "
            f"criteria of stability do not apply (allowed in a map: at most 1 - {SMALLEST_LOSS:g})"
        )
    if block.sampling == "grid":
        cells = math.prod(len(axis.values) if axis.values else (axis.count or 0) for axis in block.axes)
    elif block.sampling == "list":
        cells = len(block.axes[0].values or ())
    else:
        cells = block.samples or 0
    return MapPlan(
        device=device_of(scenario),
        membrane=membrane_of(scenario),
        axes=block.axes,
        sampling=block.sampling,
        seed=block.seed,
        cells=cells,
        chunk_cells=block.chunk_cells or _chunk_cells(block),
        simulate=block.simulate,
    )


def _chunk_cells(block: Map) -> int:
    if block.simulate is None:
        return CHUNK_CELLS
    return max(CHUNK_IMPACTS // (block.simulate.starts * block.simulate.impacts), 1)
