"""Results for the cells of a map, as tables without NaN: what does not exist is null."""

from __future__ import annotations

from collections import Counter
from operator import itemgetter
from typing import Any

import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]
from msgspec.structs import replace

from vireport.map.cells.cells import (
    Floats,
    Ints,
    MapPlan,
    cell_values,
)
from vireport.map.cells.disturbed import DESTINATIONS, escape_columns, from_rest_columns, shock_columns
from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.pointwise import PointwiseMotions, find_motions
from vireport.motions.stability import STABILITIES, UNSTABLE, classify, lap_decay
from vireport.physics.energy import Membrane, voltages
from vireport.physics.groups import Groups, map_restitution
from vireport.scenario.map_file import MapSimulationBlock
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import attractors
from vireport.simulation.starts import random_starts, start_speed

DECIMALS = 9
"""Decimals of the impact velocity up to which two motions are as fast: mirror images differ by rounding alone."""

SEED = 20190301
"""Seed of the starts of the simulation, together with the number of the cell: they do not depend on the chunks."""

CODED = pa.dictionary(pa.int8(), pa.string())

CODES: dict[str, tuple[str, ...]] = {"stability": STABILITIES, "from_rest": DESTINATIONS}
"""What the codes of such columns stand for."""

AXIS_UNITS = {
    "inclination_deg": "deg",
    Parameter.LENGTH: "m",
    "amplitude_n": "N",
    "frequency_hz": "Hz",
    "restitution": "1",
    "restitution_bottom": "1",
    "restitution_top": "1",
    "ball_mass_kg": "kg",
}

CELL = (
    ("d", pa.float64(), "1"),
    ("gbar", pa.float64(), "1"),
    ("motions", pa.int16(), "1"),
    ("stable", pa.int16(), "1"),
)
"""Known of every cell: the groups, how many admissible 1:1 motions there are, and how many of them are stable."""

MOTION = (
    ("stability", CODED, ""),
    ("q", pa.float64(), "1"),
    ("phi_bottom_rad", pa.float64(), "rad"),
    ("velocity_bottom", pa.float64(), "y_c"),
    ("velocity_top", pa.float64(), "y_c"),
    ("trace", pa.float64(), "1"),
    ("multiplier_margin", pa.float64(), "1"),
    ("period_doubling_margin", pa.float64(), "1"),
    ("fold_margin", pa.float64(), "1"),
    ("wall_gap", pa.float64(), "x_c"),
)
"""Columns of the motion of a cell, null where there is none: a stable one first, then the fastest at the bottom.

With multipliers l1 and l2 the margins are (1 + l1)(1 + l2) = 1 + r^4 + tr, zero at a period doubling,
(1 - l1)(1 - l2) = 1 + r^4 - tr, zero at a fold or pitchfork, and the smaller of both, positive where the motion is
stable.
"""


FROM_REST = (
    ("from_rest", CODED, ""),
    ("from_rest_word", pa.string(), ""),
    ("from_rest_periods", pa.int16(), "1"),
    ("settles_after_periods", pa.int32(), "1"),
)
ESCAPE = (("escape_q_m2_s2", pa.float64(), "m2/s2"),)
SHOCK = ("least_jump_m_s", pa.float64(), "m/s"), ("jump_searched_to_m_s", pa.float64(), "m/s")


def schema_of(plan: MapPlan) -> pa.Schema:
    """Columns of a map, with their units."""
    columns = [(name, pa.float64(), AXIS_UNITS[name]) for name in plan.names]
    columns += [*CELL, *MOTION]
    if plan.membrane is not None:
        columns += [("u_ave_v", pa.float64(), "V"), ("deflection_m", pa.float64(), "m")]
    if plan.simulate is not None:
        columns += [("word", pa.string(), ""), ("basin_share", pa.float64(), "1")]
    columns += [*(FROM_REST if plan.from_rest else ()), *(SHOCK if plan.shock else ())]
    columns += ESCAPE if plan.escape else ()
    return pa.schema([pa.field(name, kind, metadata={"unit": unit} if unit else None) for name, kind, unit in columns])


def evaluate(plan: MapPlan, numbers: Ints) -> pa.Table:
    """Compute some cells of a map: motions, voltages and whatever else the plan contains.

    Parameters
    ----------
    plan : MapPlan
    numbers : ndarray of int, shape (n,)
        Numbers of the cells.

    Returns
    -------
    pyarrow.Table
        One row for each cell; the columns are those of `schema_of`.
    """
    values = dict(zip(plan.names, cell_values(plan, numbers), strict=True))
    count = len(numbers)
    device = plan.device.with_values(values)
    device_groups = device.groups(Parameter.LENGTH, device.length_m)
    groups = device_groups.map_numbers(lambda group: np.broadcast_to(np.asarray(group, dtype=float), count))
    columns: dict[str, Any] = {**values, "d": groups.d, "gbar": groups.gbar}
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # what is not finite is null in the table
        motions = find_motions(groups, plan.device.period_ratio)
        columns |= _motions(motions, groups.restitution, count)
        unit = device.velocity_unit(Parameter.LENGTH, None)
        if plan.membrane is not None:
            columns |= _voltages(plan.membrane, values.get("ball_mass_kg"), unit, columns)
    if plan.simulate is not None:
        columns |= _simulated(plan.simulate, numbers, groups, motions, plan.device.period_ratio)
    if plan.from_rest:
        columns |= from_rest_columns(groups, motions, plan.device.period_ratio)
    if plan.shock:
        columns |= shock_columns(groups, motions, plan.device.period_ratio, unit)
    if plan.escape:
        columns |= escape_columns(groups, motions, plan.device.period_ratio, unit)
    schema = schema_of(plan)
    return pa.Table.from_arrays([_column(columns[field.name], field) for field in schema], schema=schema)


def _column(values: Any, field: pa.Field) -> pa.Array:
    """A column of a table; a number that is not finite, and a code below zero, is null."""
    kind = field.type
    if pa.types.is_dictionary(kind):
        codes = pa.array(values, kind.index_type, mask=values < 0)
        return pa.DictionaryArray.from_arrays(codes, pa.array([str(word) for word in CODES[field.name]]))
    return pa.array(values, kind, mask=~np.isfinite(values) if pa.types.is_floating(kind) else None)


def _motions(motions: PointwiseMotions, r: Any, count: int) -> dict[str, Any]:
    """Columns `motions`, `stable` and `MOTION`; NaN where there is no motion."""
    real = np.flatnonzero(motions.admissible)
    cell, trace = motions.cell[real], motions.trace[real]
    code = classify(trace, lap_decay(map_restitution(r, itemgetter(cell))))
    stable = code != UNSTABLE
    orbit = motions.orbit
    # For each cell the row of a stable motion if there is one, the fastest at the bottom. Velocities are rounded first:
    # mirror images are equal but for rounding, and which of them comes first must not depend on the machine.
    order = np.lexsort((orbit.u[real], -np.round(orbit.velocity_bottom[real], DECIMALS), ~stable, cell))
    first = np.ones(len(order), dtype=bool)
    first[1:] = cell[order][1:] != cell[order][:-1]
    best = order[first]
    at, row = cell[best], real[best]

    def column(values: Floats) -> Floats:
        whole = np.full(count, np.nan)
        whole[at] = values
        return whole

    tr, limit = trace[best], TRACE_LEVELS[Event.FOLD](lap_decay(map_restitution(r, itemgetter(at))))
    codes = np.full(count, -1, dtype=np.int8)
    codes[at] = code[best]
    return {
        "motions": np.bincount(cell, minlength=count).astype(np.int16),
        "stable": np.bincount(cell[stable], minlength=count).astype(np.int16),
        "stability": codes,
        "q": column(0.5 + orbit.u[row]),
        "phi_bottom_rad": column(np.mod(orbit.phi[row], 2 * np.pi)),
        "velocity_bottom": column(orbit.velocity_bottom[row]),
        "velocity_top": column(orbit.velocity_top[row]),
        "trace": column(tr),
        "multiplier_margin": column(limit - np.abs(tr)),
        "period_doubling_margin": column(limit + tr),
        "fold_margin": column(limit - tr),
        "wall_gap": column(motions.wall_gap[row]),
    }


def _voltages(
    membrane: Membrane, ball_mass_kg: Floats | None, unit: Floats | float, columns: dict[str, Floats]
) -> dict[str, Floats]:
    """U_ave of the motion of each cell [V], Eq. (5.1), and the larger deflection of its two impacts [m], Eq. (5.5)."""
    bottom, top = columns["velocity_bottom"], columns["velocity_top"]
    at = np.flatnonzero(np.isfinite(bottom))
    unit = np.broadcast_to(unit, len(bottom))[at]
    if ball_mass_kg is not None:
        membrane = replace(membrane, ball_mass_kg=ball_mass_kg[at])
    generated = voltages(unit * bottom[at], unit * top[at], membrane)
    whole = {name: np.full(len(bottom), np.nan) for name in ("u_ave_v", "deflection_m")}
    whole["u_ave_v"][at], whole["deflection_m"][at] = generated.average_v, generated.deflection_m
    return whole


def _simulated(
    block: MapSimulationBlock, numbers: Ints, groups: Groups[Floats], motions: PointwiseMotions, n: int
) -> dict[str, object]:
    """What most starts of each cell lead to (a word, or else the outcome), and the share that ends on 1:1 motion."""
    from vireport.study.checks.crosscheck import is_one_to_one

    fastest, orbit, real = np.zeros(len(numbers)), motions.orbit, motions.admissible
    np.maximum.at(fastest, motions.cell[real], np.maximum(orbit.velocity_bottom, -orbit.velocity_top)[real])
    cells = zip(numbers, groups.d, start_speed(groups.restitution, fastest), strict=True)
    # Seeded by the number of the cell: neither chunks nor workers nor interruptions change a result.
    starts = np.concatenate([random_starts(at, speed, block.starts, (SEED, int(k))) for k, at, speed in cells])
    words, shares = [], np.empty(len(numbers))
    for k, reached in enumerate(attractors(groups, starts, block.impacts, workers=1)):
        counts = Counter(attractor.word or attractor.outcome.value for attractor in reached)
        # Ties are broken by the word, so that the order of the starts does not matter.
        words.append(min(counts, key=lambda word: (-counts[word], word)))
        shares[k] = sum(is_one_to_one(attractor, n) for attractor in reached) / len(reached)
    return {"word": words, "basin_share": shares}
