"""What it costs to say what a device does from rest, which shock its motion stands, and what shocks lead to.

    python benchmarks/disturbances.py

From rest, interpreted as a run without numba is, the peer is the simulation's own search for an attractor, from the
same state: it does not know the motions that the ball may come to. Of the least shock and of the plane the peer
simulates a regular grid of shocks, all of them, with the same compiled flights; the least shock is then known to the
grid's spacing only. Times are of the processor, on one core.

What a run without a `disturbances:` block takes longer for what it tells of them is the time of that step in processes
of its own, in the median. What a run without the step imports or computes too is there before the clock starts. The
limits are 20 ms with --json and 50 ms of a report. Differences of whole runs scatter by more than the step takes; and
of instructions the loops of the simulation have twice as many in a millisecond as the rest of a run.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")  # as the command sets it before the imports

import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from record import processor_time, record

from vireport import load
from vireport.design.solution import solution_of
from vireport.design.switched_on import switched_on_at_once
from vireport.findings.escape.least_kicks import least_kicks
from vireport.findings.escape.lifetimes import ReturnGrid, lifetime
from vireport.findings.outcomes.returning import core_of, patient
from vireport.findings.outcomes.withstood import motions_by_stability, shocks_around, withstood_by
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import attractors, find_attractor
from vireport.simulation.events import BOTTOM, Impact, InFlight, check_start
from vireport.study.study import sweep_of

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
FORCED = {"inclined": (), "horizontal": (), "inclined-forcing": ("excitation.amplitude_n=3.6",)}
"""Examples, and what is set over them: at 3.6 N the device comes to rest again and again."""

BUDGET, GRID, KEPT = 4000, 64, 400
"""Impacts of the search for an attractor; points of the peer's grid along either axis, and impacts of each."""

GROWTH = (
    ("inclined", "inclined"),
    ("horizontal", "horizontal"),
    ("inclined-forcing", "inclined-forcing, which settles slowly"),
    ("hysteresis", "hysteresis: another motion, which is solved", "simulation="),
    ("inclined-forcing", "inclined-forcing at 3.6 N: a rest cycle", "excitation.amplitude_n=3.6"),
    ("inclined-forcing", "inclined-forcing at 6.9375 N: chaos", "excitation.amplitude_n=6.9375", "sweep.to=7"),
    ("inclined-forcing", "inclined-forcing at 0.8 N: at rest", "excitation.amplitude_n=0.8", "sweep.from=0.7"),
)
"""Examples that are run with and without, what they are called, and what is set: one at least of each outcome. Without
its block of simulation, as Valgrind takes minutes for what the compiler does."""

RUN = """
import sys
from importlib import import_module
from time import perf_counter
from vireport.__main__ import entry
from vireport.study import study

step = study._switched_on

def timed(known, say):
    for name in {before}:
        import_module(name)
    known.solution.bounds  # are in results.json anyway
    begun = perf_counter()
    found = step(known, say)
    print("took", 1e3 * (perf_counter() - begun), file=sys.stderr)
    return found

study._switched_on = timed if {before} else lambda known, say: known
sys.argv = ["vireport", "run", *sys.argv[1:]]
entry()
print("modules", *[name for name in sys.modules if name.startswith("vireport.")], file=sys.stderr)
"""

RUNS = 15

RATIO, ESCAPES = 4.0, 400
"""Q over the variance of the kicks, at which a motion lasts some 1,000 periods, and escapes by which that is known to
5 %."""


def said(before: list[str], arguments: list[str], word: str) -> list[str]:
    """What a run says behind a word: with the step and these modules imported before it, or without the step."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-c", RUN.format(before=before), *arguments]
    told = subprocess.run(command, capture_output=True, check=True, env=environment, text=True).stderr
    return next(line for line in told.splitlines() if line.startswith(word)).split()[1:]


def growth_ms(name: str, *arguments: str) -> float:
    """What the step adds to a run."""
    line = [str(EXAMPLES / f"{name}.yaml"), *arguments]
    before = said([], line, "modules")
    return statistics.median([float(said(before, line, "took")[0]) for _ in range(RUNS + 1)][1:])


def solved(name: str, changes: tuple[str, ...]):
    scenario = load(EXAMPLES / f"{name}.yaml", changes).scenario
    return solution_of(Device.of(scenario), Membrane.of(scenario), sweep_of(scenario), True)


def by_grid(solution, shock) -> float:
    """Simulate a regular grid of shocks to a motion; the least of those that do not return."""
    device, motion = solution.device, shock.motion
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    least = shock.searched_to if shock.jump is None else 2 * shock.jump
    times, jumps = 2 * motion.word.periods * np.arange(GRID) / GRID, np.linspace(-least, least, GRID)
    starts = []
    for time in times:
        k = int(np.searchsorted(motion.time - motion.time[0], time, side="right")) - 1
        delay, wall = time - (motion.time[k] - motion.time[0]), motion.word.walls[k]
        phase, after = np.pi * motion.time[k], float(groups.after(wall, motion.velocity[k]))
        now = phase + np.pi * delay
        position = wall * groups.d / 2 + after * delay + groups.gbar * delay**2 / 2
        position -= (np.cos(now) - np.cos(phase)) / np.pi**2 + np.sin(phase) * delay / np.pi
        velocity = after + groups.gbar * delay + (np.sin(now) - np.sin(phase)) / np.pi
        inside = float(np.clip(position, *(np.array([-1, 1]) * (1 - 1e-9) * groups.d / 2)))
        starts += [InFlight(inside, velocity + jump, now % (2 * np.pi)) for jump in jumps]
    rows = np.stack([check_start(start, groups.d) for start in starts])
    (ends,) = attractors(groups, rows[None], KEPT, workers=1)
    returned = np.array([end.cycle is not None and end.word == motion.word.letters for end in ends])
    away = np.abs(np.tile(jumps, len(times)))[~returned]
    return float(away.min()) if len(away) else np.inf


def lifetime_row() -> dict[str, float]:
    """What it takes to find a lifetime of some 1,000 periods to 5 %, once the least kicks and the table are there."""
    solution = solved("inclined-forcing", FORCED["inclined-forcing"])
    groups = solution.device.groups(Parameter.LENGTH, solution.device.length_m).as_floats()
    motions = motions_by_stability(solution.design, solution.device)
    cores = patient(groups, [core_of(groups, motion, compiled=True) for motion in motions.stable], motions.unstable)
    least_kicks(groups, cores)  # compiled
    least_s, way = processor_time(lambda: least_kicks(groups, cores), 3)
    kick = (way.path.exponent / RATIO) ** 0.5
    whole_s, found = processor_time(lambda: lifetime(ReturnGrid(groups, cores, kick), kick, 1, 10**8, ESCAPES), 3)
    print(
        f"mean time {found.mean:.0f} periods to {100 * found.error:.1f} % in {whole_s:.2f} s, {found.impacts} impacts; "
        f"least kicks {least_s:.2f} s"
    )
    return {"periods": found.mean, "error": found.error, "lifetime_s": whole_s, "least_kicks_s": least_s}


def main() -> None:
    """Print and record the table."""
    rows = []
    for name, changes in FORCED.items():
        solution = solved(name, changes)
        groups = solution.device.groups(Parameter.LENGTH, solution.device.length_m).as_floats()
        rest = Impact(BOTTOM, 0.0, 0.0)
        ours, found = processor_time(lambda solution=solution: switched_on_at_once(solution), 9)
        switched_on_at_once(solution, compiled=True)  # compiled
        compiled, _ = processor_time(lambda solution=solution: switched_on_at_once(solution, compiled=True), 9)
        peer, _ = processor_time(lambda groups=groups, rest=rest: find_attractor(groups, rest, BUDGET, compiled=False))
        withstood_by(solution, shocks=True)  # compiled
        shock_s, withstood = processor_time(lambda solution=solution: withstood_by(solution, shocks=True))
        shock = withstood.shock
        knocked = groups, [shock.motion], shock
        plane_s, (plane, _) = processor_time(lambda knocked=knocked: shocks_around(*knocked))
        grid_s, least = processor_time(lambda solution=solution, shock=shock: by_grid(solution, shock), 1)
        row = {
            "scenario": name, "outcome": found.from_rest.name, "from_rest_ms": 1e3 * ours,
            "from_rest_compiled_ms": 1e3 * compiled,
            "simulation_ms": 1e3 * peer,
            "shock_s": shock_s, "jump_m_s": withstood.jump_m_s, "plane_s": plane_s, "plane_points": len(plane.x) ** 2,
            "grid_s": grid_s, "grid_points": GRID**2, "ratio": peer / ours,
            "plane_ratio": grid_s / (GRID**2) / (plane_s / len(plane.x) ** 2),
        }  # fmt: skip
        rows.append(row)
        print(
            f"{name:<18} from rest {1e3 * ours:.1f} ms, compiled {1e3 * compiled:.1f} ms, "
            f"simulation {1e3 * peer:.1f} ms; shock {shock_s:.2f} s, "
            f"plane {plane_s:5.2f} s, {GRID} x {GRID} shocks simulated {grid_s:5.2f} s: "
            f"{least * withstood.velocity_unit:.4g} against {withstood.jump_m_s} m/s"
        )
    growth = []
    with tempfile.TemporaryDirectory() as folder:
        for example, name, *changes in GROWTH:
            own = [word for change in changes for word in ("--set", change)]
            json, report = growth_ms(example, *own, "--json"), growth_ms(example, *own, "-o", folder)
            growth.append({"scenario": name, "json_growth_ms": json, "report_growth_ms": report})
            print(f"{name:<45} --json {json:+.1f} ms, report {report:+.1f} ms", flush=True)
    record("disturbances", grid=GRID, disturbances=rows, growth=growth, lifetime=lifetime_row())


if __name__ == "__main__":
    main()
