"""What `vireport portrait` prints and draws: the motions behind a point of a diagram, solved anew from its results."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

from vireport.atlas import portrait_of
from vireport.base import NumericalError, UsageError, json_text
from vireport.cli.outcome import CommandOutcome
from vireport.motions import Family, Motion, Sweep
from vireport.physics import Membrane
from vireport.scenario import loads
from vireport.study import families_of, motion_data, sweep_of
from vireport.text import (
    Table,
    numbers,
    plain_text,
    significant,
    texts,
)

NAMES = ("figure-portraits.png",)
"""Files that may be written."""

MOST_DRAWN = 8
"""Most motions that one figure shows."""

SAME = 1e-9
"""Difference of velocity and time up to which a motion was found twice, from both sides of a sample."""

FoundMotion = tuple[dict[str, Any], Family, Motion]


def portrait_outcome(results: Mapping[str, Any], name: str, at: str, as_json: bool) -> CommandOutcome:
    """The motions at a value of the swept parameter, the stable ones first, or the one nearest to a velocity.

    Parameters
    ----------
    results : mapping
        Content of a results.json.
    name : str
        Of the file, for messages.
    at : str
        ``VALUE`` or ``VALUE,VELOCITY``.
    as_json : bool
        Whether data are asked for, and no figure.

    Raises
    ------
    UsageError
        If the results have no diagram, or not this point.
    NumericalError
        If no motion is there.
    """
    scenario = loads(json_text(results["scenario"])).scenario
    sweep = sweep_of(scenario)
    if sweep is None:
        raise UsageError(f"{name}: has no diagram (allowed: results of a scenario with a sweep)")
    value, velocity = _point(at, sweep)
    swept = sweep.parameter
    place = f"{swept.symbol} = {swept.show(value)}"
    try:
        families = families_of(results, sweep)
        motions = [(motion_data(f, x, value, Membrane.of(scenario)), f, x) for f, x in _at(families, sweep, value)]
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(f"{name}: its motions cannot be read ({error!r}); run its scenario again") from error
    if velocity is not None:
        motions = sorted(motions, key=lambda row: float(np.abs(np.abs(row[2].velocity) - velocity).min()))[:1]
    if not motions:
        raise NumericalError(f"{name}: none of its motions is at {place}")
    motions.sort(key=lambda row: not row[0]["stability"].attracts)
    if as_json:
        return CommandOutcome(f"{json_text({'sweep_value': value, 'motions': [data for data, *_ in motions]})}\n")
    drawn = motions[:MOST_DRAWN]
    counted = f"{len(motions)} motion{'s' * (len(motions) != 1)} at {place}"
    summary = counted if len(drawn) == len(motions) else f"{counted}, of which the first {len(drawn)} are drawn"
    return CommandOutcome(plain_text([_table(motions, place)]) + "\n", {NAMES[0]: _png(drawn, sweep, place)}, summary)


def _point(at: str, sweep: Sweep) -> tuple[float, float | None]:
    """Value of the swept parameter and impact velocity, if one is given."""
    low, high = sorted((sweep.start, sweep.end))
    try:
        value, *velocity = (float(part) for part in at.split(","))
    except ValueError:
        value, velocity = float("nan"), []
    if len(velocity) > 1 or not all(map(isfinite, (value, *velocity))) or not low <= value <= high:
        allowed = f"{sweep.parameter} from {low:g} to {high:g}, and after a comma an impact velocity"
        raise UsageError(f"--at: got '{at}' (allowed: {allowed})")
    return value, abs(velocity[0]) if velocity else None


def _at(families: list[Family], sweep: Sweep, value: float) -> list[tuple[Family, Motion]]:
    """The motions of the families at a value, each once."""
    # Rounding may put a value at an end of the sweep beyond it, where families end.
    coordinate = float(np.clip(sweep.coordinate_of(value), *sweep.coordinate_range))
    motions: list[tuple[Family, Motion]] = []
    for family in families:
        for motion in family.at(coordinate):
            if all(motion.distance(other) > SAME for _, other in motions):
                motions.append((family, motion))
    return motions


def _table(motions: list[FoundMotion], place: str) -> Table:
    columns = (*texts("Word", "n:m"), *numbers("Periods"), *texts("Stability", "|Z'| [y_c]"), *numbers("phi [rad]"))
    volts = "u_ave_v" in motions[0][0]
    rows = tuple(
        (
            *(data["word"], data["ratio"], str(data["periods"]), data["stability"]),
            ", ".join(significant(abs(v), 6) for v in data["velocity"]),
            significant(data["phase_rad"][0], 6),
            *((significant(data["u_ave_v"], 5), significant(data["u_per_second_v"], 5)) if volts else ()),
        )
        for data, *_ in motions
    )
    note = "Velocities of the impacts in the order of the word, phase of the first."
    return Table(f"Motions at {place}", columns + (numbers("U_ave [V]", "[V/s]") if volts else ()), rows, note)


def _png(drawn: list[FoundMotion], sweep: Sweep, place: str) -> bytes:
    from vireport.figures import held_by, portraits_picture

    shown = [portrait_of(family.model, motion, place) for _, family, motion in drawn]
    return portraits_picture(shown, held_by(sweep.device, (sweep.parameter,))).png
