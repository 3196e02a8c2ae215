"""Are mistakes in a record or a scenario named by `vireport identify`? Chaotic records, each with one mistake.

    python benchmarks/mistakes.py --seconds 500 --records 100        as often as needed
    python benchmarks/mistakes.py --table

Records are those of `intervals.py` (inclined and horizontal chaos in turn, 0 to 5 % missed), with a clock that is
referenced to the force, and without. The mistakes: membranes exchanged, times in milliseconds, a frequency that is off
by 0.01 to 1 %, a clock whose rate drifts by 1e-6 to 1e-4 per second, and a restitution that falls with speed, with
exponents from -0.02 to -0.2. How often nothing is found where nothing is wrong is counted as well.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections import Counter
from pathlib import Path

import numpy as np
from intervals import EACH, FALSE, IMPACTS, JITTER_S, MISSED, device_of, truth
from msgspec.structs import replace
from record import record
from slices import options, pursued

from vireport.base.errors import ScenarioError
from vireport.measurement.adjustment import Inquiry
from vireport.measurement.flights import ClockedDevice, MeasuredImpacts, Unknown
from vireport.measurement.identification import Unidentifiable, fit
from vireport.measurement.misfit import judged
from vireport.measurement.records import parse_record
from vireport.physics.groups import SpeedLaw
from vireport.scenario.parameters import DesignInput, Parameter

OUTCOMES = Path(__file__).resolve().parent / "mistakes.jsonl"
MISTAKES = "none", "membranes", "milliseconds", "frequency", "drift", "exponent"
EXPECTED = {"frequency": Unknown.FREQUENCY, "drift": Unknown.DRIFT, "exponent": Unknown.EXPONENT}


def outcome(mistake: str, referenced: bool, k: int) -> dict:
    """What is said of record k with a mistake."""
    rng = np.random.default_rng([MISTAKES.index(mistake), referenced, k])
    regime = ("chaos", "horizontal")[k % 2]
    device = device_of(regime)
    jitter, impacts = float(np.exp(rng.uniform(*np.log(JITTER_S)))), int(rng.integers(*IMPACTS))
    sign, size = rng.choice([-1.0, 1.0]), rng.uniform()
    given, wrong = device, 0.0
    if mistake == "exponent":
        wrong = -0.02 * 10**size
        speed = float(0.5 * device.velocity_unit(Parameter.LENGTH, device.length_m))
        device = replace(device, restitution=SpeedLaw(0.5, 0.5, wrong, speed))
    times, walls, phase = truth(regime, device, rng, impacts)
    if referenced:
        times, phase = times + (phase % (2 * np.pi)) / (2 * np.pi * device.frequency_hz), 0.0
    heard = rng.random(impacts) >= MISSED[k % 3]
    times = (times + jitter * rng.standard_normal(impacts))[heard]
    more = rng.uniform(times[0], times[-1], int(rng.binomial(impacts, FALSE[k % 3])))
    times, walls = np.append(times, more), np.append(walls[heard], rng.choice([-1.0, 1.0], len(more)))
    order = np.argsort(times)
    times, walls = times[order], walls[order]
    said = {"mistake": mistake, "referenced": bool(referenced), "k": k, "size": wrong}
    begin = time.process_time()
    if mistake == "milliseconds":
        rows = "".join(
            f"{t!r},{'bottom' if w > 0 else 'top'}\n" for t, w in zip((1e3 * times).tolist(), walls, strict=True)
        )
        try:
            parse_record(f"time_s,membrane\n{rows}".encode(), "x", given.frequency_hz)
        except ScenarioError as refused:
            return said | {"outcome": "named" if "milliseconds" in str(refused.lines) else "rejected"}
        return said | {"outcome": "accepted"}
    true = 0.0
    if mistake == "membranes":
        walls = -walls
    elif mistake == "frequency":
        true, wrong = float(given.frequency_hz), sign * 1e-4 * 100**size
        given = given.with_values({DesignInput.FREQUENCY: true * (1 + wrong)})
    elif mistake == "drift":
        true = wrong = sign * 1e-6 * 100**size
        begun = 0.0 if referenced else times[0]
        times = begun + (np.sqrt(1 + 2 * wrong * (times - begun)) - 1) / wrong
    elif mistake == "exponent":
        true = wrong
    said["size"] = wrong
    origin = 0.0 if referenced else float(times[0])
    unknowns = EACH if referenced else (*EACH, Unknown.PHASE)
    guess = ClockedDevice(given.with_values({DesignInput.RESTITUTION: 0.6}))
    asked = Inquiry(guess, unknowns), MeasuredImpacts.undoubted(times - origin, walls)
    try:
        misfit = judged(fit(*asked), *asked)
    except Unidentifiable:
        return said | {"outcome": "refused", "seconds": time.process_time() - begin}
    said["seconds"], said["p"] = time.process_time() - begin, misfit.p_value
    better = misfit.explanation
    if misfit.accepted:
        return said | {"outcome": "accepted", "untested": misfit.swapped_untested and mistake == "membranes"}
    if better is None:
        return said | {"outcome": "rejected"}
    right = better.swapped if mistake == "membranes" else better.unknown == EXPECTED.get(mistake)
    if not right:
        return said | {"outcome": "misnamed", "as": "membranes" if better.swapped else better.unknown}
    if not better.swapped:
        said["off"] = (better.value - true) / better.standard_error
    return said | {"outcome": "named"}


def main() -> None:
    given = options(__doc__, 100, "of each mistake, with and without reference", OUTCOMES).parse_args()
    every = [(m, r, k) for k in range(given.records) for m in MISTAKES for r in (True, False)]
    known = pursued(given, every, outcome, ("mistake", "referenced", "k"))
    rows = []
    for mistake in MISTAKES:
        for referenced in (True, False):
            mine = [x for x in known if (x["mistake"], x["referenced"]) == (mistake, referenced)]
            if mine:
                counts = dict(Counter(x["outcome"] for x in mine))
                rows.append({"mistake": mistake, "referenced": referenced, "records": len(mine), **counts})
                print(rows[-1])
    if given.table:
        record("mistakes", mistakes=rows)


if __name__ == "__main__":
    main()
