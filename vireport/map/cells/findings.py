"""Summary of a finished map in numbers: counts of cells by their motions, and where each quantity is largest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq  # type: ignore[import-untyped]
from msgspec import Struct

from vireport.design.from_rest import Destination
from vireport.map.cells.cells import Floats, MapPlan
from vireport.map.cells.disturbed import DESTINATIONS
from vireport.map.cells.evaluation import CODES
from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.stability import STABILITIES, Stability, lap_decay
from vireport.physics.device import RESTITUTIONS


class MapQuantity(StrEnum):
    """Quantities whose largest value in a map is sought, by their columns."""

    MARGIN = "multiplier_margin"
    VOLTAGE = "u_ave_v"
    SHOCK = "least_jump_m_s"


class LargestValue(Struct, frozen=True):
    """The largest value of a quantity among the cells with a stable motion, and the values of the axes there."""

    value: float
    inputs: tuple[float, ...]


class MapFindings(Struct, frozen=True, eq=False):
    """Counts of the cells of a map, and largest values.

    Attributes
    ----------
    cells : int
        Number of all cells.
    stability : Counter of Stability
        Cells by the type of their motion; None where there is no motion.
    from_rest : Counter of Destination
        Cells by what they come to from rest; empty where that was not computed.
    missed : int
        Cells with a stable 1:1 motion that is not reached from rest.
    largest : dict of MapQuantity to LargestValue
        The margin is a share of its largest possible value; of several cells the first.
    """

    cells: int
    stability: Counter[Stability | None]
    from_rest: Counter[Destination]
    missed: int
    largest: dict[MapQuantity, LargestValue]

    @property
    def stable(self) -> int:
        """Cells with a stable motion."""
        return sum(self.stability[kind] for kind in STABILITIES if kind.attracts)

    @property
    def with_motion(self) -> int:
        """Cells with a motion, stable or not."""
        return self.cells - self.stability[None]


def findings_of(plan: MapPlan, result: Path) -> MapFindings:
    """Read a finished map piece by piece, and count.

    Parameters
    ----------
    plan : MapPlan
    result : Path
        The finished map.
    """
    stability: Counter[Stability | None] = Counter()
    from_rest: Counter[Destination] = Counter()
    largest: dict[MapQuantity, LargestValue] = {}
    missed = 0
    for columns in _pieces(plan, result):
        code = columns["stability"]
        stability.update({kind: int((code == kind.code).sum()) for kind in STABILITIES})
        stability[None] += int(np.isnan(code).sum())
        stable = np.isin(code, [kind.code for kind in STABILITIES if kind.attracts])
        if plan.from_rest:
            reached = columns["from_rest"]
            from_rest.update({kind: int((reached == k).sum()) for k, kind in enumerate(DESTINATIONS)})
            missed += int((stable & (reached != DESTINATIONS.index(Destination.ONE_TO_ONE))).sum())
        columns[MapQuantity.MARGIN] = columns[MapQuantity.MARGIN] / largest_margin(restitution_at(plan, columns))
        for quantity in quantities_of(plan):
            values = np.where(stable, columns[quantity], np.nan)
            if np.isnan(values).all():
                continue
            row = int(np.nanargmax(values))
            if quantity not in largest or values[row] > largest[quantity].value:
                inputs = tuple(float(columns[name][row]) for name in plan.names)
                largest[quantity] = LargestValue(float(values[row]), inputs)
    return MapFindings(plan.cells, stability, from_rest, missed, largest)


def quantities_of(plan: MapPlan) -> list[MapQuantity]:
    """The quantities that a map has."""
    available = {MapQuantity.VOLTAGE: plan.membrane is not None, MapQuantity.SHOCK: plan.shock}
    return [quantity for quantity in MapQuantity if available.get(quantity, True)]


def restitution_at(plan: MapPlan, axes: dict[str, Floats]) -> Any:
    """Restitution of both membranes or of each, at values of the axes: numbers or arrays."""
    return plan.device.with_values({name: axes[name] for name in RESTITUTIONS if name in plan.names}).restitution


def largest_margin(restitution: Any) -> Any:
    """The margin of a motion whose trace is 0: 1 + (r_bottom r_top)^2."""
    return TRACE_LEVELS[Event.FOLD](lap_decay(restitution))


def coded(column: Any, name: str) -> Floats:
    """The places in `CODES` of a column of words; NaN where there is none."""
    code = np.array([float(CODES[name].index(word)) for word in column.dictionary.to_pylist()] + [np.nan])
    return np.asarray(code[column.indices.fill_null(len(code) - 1).to_numpy()])


def pieces_of(result: Path, names: list[str]) -> Iterator[dict[str, Floats]]:
    """Some columns of a finished map, piece by piece: numbers, and words by their places in `CODES`."""
    with open(result, "rb") as opened, pq.ParquetFile(opened) as file:
        for batch in file.iter_batches(columns=names):
            columns = {name: batch.column(name) for name in names}
            yield {
                name: coded(column, name) if name in CODES else column.to_numpy(zero_copy_only=False)
                for name, column in columns.items()
            }


def _pieces(plan: MapPlan, result: Path) -> Iterator[dict[str, Floats]]:
    names = [*plan.names, "stability", *quantities_of(plan)]
    names += ["deflection_m"] if plan.membrane is not None else []
    return pieces_of(result, names + (["from_rest"] if plan.from_rest else []))
