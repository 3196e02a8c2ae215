"""Time of a motion with three impacts, with stability, admissibility and voltages, and of a whole atlas.

    python benchmarks/atlas.py

The peer of the motions is SciPy's root finder on the conditions, from the neighbouring motion, one at a time. The atlas
has two. Simulation, at as many values of the sweep as a family has points, from eight starts each, finds the stable
motions only. Pseudo-arclength continuation with SciPy's root finder on the same conditions is compared with that of the
atlas, along its families, without the search for them. Both evaluate the trace, find where it passes a border between
types of motion, and check each motion's admissibility, by the same function. SciPy's is given where a family begins,
the length of each step, and so its end; that of the atlas chooses its steps, refuses those that are too long, and finds
what ends a family. Times are of the processor, on one core.
"""

from __future__ import annotations

import os

from vireport.physics.groups import Groups

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from pathlib import Path

import numpy as np
from record import processor_time, record
from scipy.optimize import brentq, root

from vireport import load, loads
from vireport.motions.atlas.families import atlas
from vireport.motions.atlas.surface import candidates_above
from vireport.motions.events import TRACE_LEVELS
from vireport.motions.families import Atlas, Family
from vireport.motions.paths import Curve, Trail, completed, follow
from vireport.motions.periodicity import residuals, trace
from vireport.motions.switching import Limits
from vireport.physics.device import Device
from vireport.physics.energy import Membrane, generated_voltage
from vireport.simulation.attractors import attractors
from vireport.simulation.starts import random_starts, start_speed
from vireport.study.study import sweep_of

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
COUNT, BLOCK, SEED = 200_000, 4096, 20190301
STARTS, MOST_PERIODS = 8, 4
"""Starts of the simulation at each value."""

LEAST_STEP, ARRIVED, LOCATED = 1e-9, 0.01, 1e-11
"""Of the arclength: steps that are taken, the distance from the end of a family, and the tolerance of an event as a
share of its step, the same as that of the atlas."""

THREE = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5}
excitation: {amplitude_n: 5, frequency_hz: 2.5}
inclination_deg: 30
sweep: {parameter: length_m, from: 0.26, to: 0.34}
"""
"""A stable 2:1 motion, from one end to the other."""


def three_impacts() -> dict[str, float]:
    """Microseconds a motion with three impacts, in closed form and by SciPy."""
    scenario = loads(THREE).scenario
    sweep, membrane = sweep_of(scenario), Membrane.of(scenario)
    unit = float(Device.of(scenario).velocity_unit(sweep.parameter, sweep.start))
    families = atlas(sweep, Limits(3, 1)).families
    family = max((f for f in families if f.word.letters == "BBT"), key=lambda f: len(f.x))
    rows, count = np.linspace(0, len(family.x) - 1, COUNT), len(family.word)
    x = np.stack([np.interp(rows, np.arange(len(family.x)), column) for column in family.x.T])
    flights = np.diff(x[count:-1], axis=0)

    def closed_form() -> None:
        for i in range(0, COUNT, BLOCK):
            motions = candidates_above(family.word, flights[:, i : i + BLOCK], family.curve.model.r)
            generated_voltage(unit * motions.velocity, membrane), motions.trace, motions.admissible

    ours = processor_time(closed_form)[0] / COUNT
    peer = scipy_time(family, x[:, :: COUNT // 200])
    return {"us_per_motion": 1e6 * ours, "us_scipy": 1e6 * peer, "ratio": peer / ours}


def scipy_time(family: Family, x: np.ndarray) -> float:
    """Seconds a motion by SciPy's root finder at values of the coordinate, from the neighbour, with its trace."""
    model, word, guess = family.curve.model, family.word, x[:-1, 0]

    def follow() -> None:
        y = guess
        for coordinate in x[-1]:
            y = root(lambda y, c=coordinate: residuals(word, [*y, c], model), y, tol=1e-12).x
            trace(word, [*y.tolist(), coordinate], model)

    return processor_time(follow)[0] / x.shape[1]


def followed(family: Family) -> Trail:
    """A family followed from its middle to both ends, with its events."""
    x = family.x[len(family.x) // 2]
    start = family.curve.point(x, family.curve.tangent(x))
    return completed(family.curve, start, follow(family.curve, start))


def followed_by_scipy(family: Family) -> bool:
    """Whether pseudo-arclength continuation by SciPy from the first two points of a family arrives at its end."""
    curve, (x, second) = family.curve, family.x[:2]
    ways = np.linalg.norm(np.diff(family.x, axis=0) / curve.scale, axis=1)
    along, trace_before = (second - x) / curve.scale / ways[0], family.trace[0]
    for way in ways[ways > LEAST_STEP]:
        new = moved(curve, x, along, way)
        trace_after = curve.trace(new)
        curve.admits(new)
        for level in {sign * abs(at(curve.decay(new))) for at in TRACE_LEVELS.values() for sign in (1, -1)}:
            if (trace_before - level) * (trace_after - level) < 0:
                crossing(curve, x, along, way, level)
        along = (new - x) / curve.scale
        along, x, trace_before = along / np.linalg.norm(along), new, trace_after
    return bool(np.abs((x - family.x[-1]) / curve.scale).max() < ARRIVED)


def moved(curve: Curve, x: np.ndarray, along: np.ndarray, way: float) -> np.ndarray:
    """The motion at an arclength from another one, by SciPy's root finder."""
    guess = x + way * along * curve.scale

    def conditions(y: np.ndarray) -> list[float]:
        return [*residuals(curve.word, y.tolist(), curve.model), along @ ((y - guess) / curve.scale)]

    return root(conditions, guess, tol=1e-12).x


def crossing(curve: Curve, x: np.ndarray, along: np.ndarray, way: float, level: float) -> float:
    """The arclength at which the trace is at a border between types of motion, by SciPy's root finder in a bracket."""

    def above(size: float) -> float:
        return curve.trace(moved(curve, x, along, size)) - level

    try:
        return brentq(above, 0.0, way, xtol=LOCATED * way)
    except ValueError:  # where the step ends at an impact without velocity, at which there is no trace
        return way


def simulated_words(swept_atlas: Atlas, count: int) -> set[str]:
    """Words of the motions within the limits that a simulation of as many values ends in."""
    sweep = swept_atlas.sweep
    values, r = np.linspace(sweep.start, sweep.end, count), float(sweep.device.restitution)
    groups = sweep.device.groups(sweep.parameter, values)
    d, gbar = (np.broadcast_to(x, count).astype(float) for x in (groups.d, groups.gbar))
    ends = attractors(Groups(d, gbar, r), random_starts(d, start_speed(r, [0.0] * count), STARTS, SEED))
    cycles = [end.cycle for row in ends for end in row if end.cycle is not None and not end.cycle.sticks]
    return {
        cycle.word for cycle in cycles if len(cycle.wall) <= swept_atlas.limits.impacts and cycle.period <= MOST_PERIODS
    }


def growth() -> dict[str, object]:
    """Processor time of atlases of more and more impacts, and the power of the number of families with which it grows.

    Of the example whose families become more the longer their words may be.
    """
    sweep, rows = sweep_of(load(EXAMPLES / "inclined-forcing.yaml").scenario), []
    for impacts in (4, 6, 8):
        seconds, grown = processor_time(lambda impacts=impacts: atlas(sweep, Limits(impacts, MOST_PERIODS)))
        points = sum(len(family.x) for family in grown.families)
        rows.append({"impacts": impacts, "seconds": seconds, "families": len(grown.families), "points": points})
    first, last = rows[0], rows[-1]
    exponent = np.log(last["seconds"] / first["seconds"]) / np.log(last["families"] / first["families"])
    print(f"from {first['families']} to {last['families']} families the time grows with their power {exponent:.2f}")
    return {"rows": rows, "exponent": float(exponent)}


def main() -> None:
    """Print and record the tables."""
    three = three_impacts()
    print(f"three impacts   {three['us_per_motion']:.2f} us a motion, SciPy {three['us_scipy']:.0f} us")
    rows = []
    for name in ("inclined", "horizontal", "inclined-forcing"):
        sweep = sweep_of(load(EXAMPLES / f"{name}.yaml").scenario)
        seconds, swept_atlas = processor_time(lambda sweep=sweep: atlas(sweep, Limits(6, MOST_PERIODS)))
        points = sum(len(family.x) for family in swept_atlas.families)
        count = round(points / len(swept_atlas.families))
        simulated_words(swept_atlas, 2)  # compiled
        peer, words = processor_time(
            lambda swept_atlas=swept_atlas, count=count: simulated_words(swept_atlas, count), 1
        )
        following = processor_time(
            lambda swept_atlas=swept_atlas: [followed(family) for family in swept_atlas.families]
        )[0]
        arclength, ends = processor_time(
            lambda swept_atlas=swept_atlas: [followed_by_scipy(family) for family in swept_atlas.families]
        )
        ours = {family.word.letters for family in swept_atlas.families}
        rows.append(
            {
                "scenario": name, "seconds": seconds, "families": len(swept_atlas.families), "points": points,
                "words": len(ours), "vertices": len(swept_atlas.vertices), "simulated_values": count,
                "simulation_seconds": peer, "simulation_words": len(words), "ratio": peer / seconds,
                "following_seconds": following, "arclength_seconds": arclength, "arclength_families": sum(ends),
                "arclength_ratio": arclength / following,
            }
        )  # fmt: skip
        print(
            f"{name:<18} atlas {seconds:5.2f} s, {len(swept_atlas.families)} families of {len(ours)} words, "
            f"{points} points; "
            f"simulation at {count} values {peer:6.2f} s, {len(words)} words; "
            f"following {following:.2f} s, SciPy {arclength:.2f} s, {sum(ends)} families to their end"
        )
    record("atlas", three_impacts=three, atlas=rows, growth=growth())


if __name__ == "__main__":
    main()
