"""Do the intervals of `vireport identify` hold the truth? Records whose truth is known, in six regimes of motion.

    python benchmarks/intervals.py --seconds 500 --records 501 chaos    as often as needed, by regime or all
    python benchmarks/intervals.py --table

Each record is an own motion of the independent simulation: 100 to 600 impacts from an own random start, times with
independent normal errors of 0.02 to 0.5 ms, and in turn no, 1 % and 5 % of the impacts missed (with 0.5 % false ones).
What is asked is what `vireport identify` is asked, and an interval counts only where it would be given: where the model
is not rejected. Outcomes are kept in a file, from which an interrupted study goes on; seeds are of regime and number,
so that a record can be made again.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
import zlib
from collections import Counter
from pathlib import Path

import numpy as np
from record import record
from scipy.special import stdtrit
from slices import options, pursued

from vireport import load
from vireport.measurement.adjustment import Inquiry
from vireport.measurement.flights import ClockedDevice, MeasuredImpacts, Unknown
from vireport.measurement.identification import Fitted, Unidentifiable, fit
from vireport.measurement.misfit import judged, tested
from vireport.physics.device import Device
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.events import Impact, check_model, check_start, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, WALL

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
OUTCOMES = Path(__file__).resolve().parent / "intervals.jsonl"

EACH = Unknown.RESTITUTION_BOTTOM, Unknown.RESTITUTION_TOP
BOTH = (Unknown.RESTITUTION,)
REGIMES = {
    "1:1 referenced": ("inclined", (), 200, EACH, "BT"),
    "1:1 equal": ("horizontal", ("device.restitution=0.8", "device.length_m=0.4"), 100, (*BOTH, Unknown.PHASE), "BT"),
    "2:1": ("inclined", ("device.length_m=0.3",), 200, (*EACH, Unknown.PHASE), "BBT"),
    "chaos": ("inclined", ("device.length_m=0.42",), 100, (*EACH, Unknown.PHASE), ""),
    "horizontal": ("horizontal", ("device.length_m=0.2",), 200, (*EACH, Unknown.PHASE), ""),
    "transient": ("inclined", (), 0, (*EACH, Unknown.PHASE), ""),
}
"""Example, what is set over it, impacts that are skipped, what is identified, and the word of a regime that has one."""

MISSED, FALSE = (0.0, 0.01, 0.05), (0.0, 0.005, 0.005)
COUNTED = "missed", "missed_found", "missed_told", "lost", "false", "false_found", "false_told"
JITTER_S, IMPACTS = (2e-5, 5e-4), (100, 601)


def device_of(regime: str) -> Device:
    example, over, *_ = REGIMES[regime]
    return Device.of(load(EXAMPLES / f"{example}.yaml", over).scenario)


def truth(regime: str, device: Device, rng: np.random.Generator, impacts: int):
    """Times [s] and membranes of a motion from a random start, and the force's phase at time 0."""
    *_, skipped, _, word = REGIMES[regime]
    groups = device.groups(Parameter.LENGTH, device.length_m)
    model = check_model(groups)[0]
    while True:
        start = Impact(1, float(rng.uniform(0.5, 1.5)), float(rng.uniform(0, 2 * np.pi)))
        rows, _ = follow_one(model, check_start(start, float(groups.d)), impacts + skipped, compiled=False)
        rows = rows[1 + skipped :]
        letters = "".join("B" if wall > 0 else "T" for wall in rows[:, WALL])
        if len(rows) < impacts or (word and len(word) * letters.count(word) < len(letters) - 2 * len(word)):
            continue  # at rest, or another motion than that of the regime
        own = np.concatenate([[0.0], np.cumsum(rows[1:, FLIGHT])])
        if np.abs(np.exp(1j * (rows[0, PHASE] + np.pi * own - rows[:, PHASE])) - 1).max() > 1e-6:
            continue  # the ball rests in between, which no flight is
        if own[-1] < impacts / 10:
            continue  # it chatters all the time, at the largest restitution that falls with speed
        own /= 2 * device.frequency_hz
        return own + 0.1 / device.frequency_hz, rows[:, WALL], float(rows[0, PHASE] - 2 * np.pi * 0.1)


def made(regime: str, k: int):
    """Record k of a regime: device, times, membranes, phase at time 0, and which impacts were missed, which false."""
    rng = np.random.default_rng([zlib.crc32(regime.encode()), k])
    device = device_of(regime)
    jitter, impacts = np.exp(rng.uniform(*np.log(JITTER_S))), int(rng.integers(*IMPACTS))
    exact, walls, phase = truth(regime, device, rng, impacts)
    if Unknown.PHASE not in REGIMES[regime][3]:
        exact, phase = exact + (phase % (2 * np.pi)) / (2 * np.pi * device.frequency_hz), 0.0
    heard = rng.random(impacts) >= MISSED[k % 3]
    times = (exact + jitter * rng.standard_normal(impacts))[heard]
    more = rng.uniform(exact[0], exact[-1], int(rng.binomial(impacts, FALSE[k % 3])))
    times, walls = np.append(times, more), np.append(walls[heard], rng.choice([-1.0, 1.0], len(more)))
    real = np.append(np.ones(int(heard.sum()), dtype=bool), np.zeros(len(more), dtype=bool))
    order = np.argsort(times)
    return device, times[order], walls[order], phase, float(jitter), exact[~heard], real[order]


def outcome(regime: str, k: int) -> dict:
    """What `identify` says of a record, held against the truth."""
    device, times, walls, phase, jitter, missed, real = made(regime, k)
    unknowns = REGIMES[regime][3]
    origin = float(times[0]) if Unknown.PHASE in unknowns else 0.0
    guess = ClockedDevice(device.with_values({DesignInput.RESTITUTION: 0.6}))
    given = Inquiry(guess, unknowns), MeasuredImpacts.undoubted(times - origin, walls)
    said = {"regime": regime, "k": k, "jitter_s": jitter, "impacts": len(times), "missed": len(missed)}
    begin = time.process_time()
    try:
        found = fit(*given)
        if not isinstance(found, Fitted):
            judged(found, *given)
            return said | {"outcome": "rejected", "why": found.failure.name, "p": None}
        misfit, _ = tested(found, set(unknowns))
    except Unidentifiable as refused:
        left = refused.left_open
        kinds = {
            "open combination": left.combination, "several answers": left.answers, "too short": left.impacts,
            "unstable": left.unstable, "no fit": left.failed,
        }  # fmt: skip
        why = next(name for name, is_so in kinds.items() if is_so)
        return said | {"outcome": why, "seconds": time.process_time() - begin}
    said["seconds"] = time.process_time() - begin
    if not misfit.accepted:
        return said | {"outcome": "rejected", "why": str(misfit.alternative), "p": misfit.p_value}
    own = found.adjusted
    true = ClockedDevice(device, phase + 2 * np.pi * device.frequency_hz * origin)
    away = np.array([own.model.value_of(x) - true.value_of(x) for x in unknowns])
    turn = np.array([x is Unknown.PHASE for x in unknowns])
    away[turn] = (away[turn] + np.pi) % (2 * np.pi) - np.pi
    errors = np.array([own.deviation_of(x) for x in unknowns])
    told = np.array([gap.missed_s for gap in found.gaps if gap.missed_s is not None])
    gone = np.setdiff1d(np.arange(len(times)), found.screened.kept)
    return said | {
        "outcome": "answered",
        "off": (away / errors).tolist(),
        "held": (np.abs(away / errors) < stdtrit(own.freedom, 0.975)).tolist(),
        "timing": own.timing_error_s / jitter,
        "p": misfit.p_value,
        "missed_found": int(sum(np.abs(missed - origin - t).min(initial=1) < 20 * jitter for t in told)),
        "missed_told": len(told),
        "lost": found.lost,
        "false": int((~real).sum()),
        "false_found": int((~real[gone]).sum()),
        "false_told": len(gone),
    }


def table(outcomes: list[dict]) -> list[dict]:
    """Counts of each regime and share of missed impacts."""
    rows = []
    for regime in REGIMES:
        for level, share in [*enumerate(MISSED), (None, None)]:
            mine = [x for x in outcomes if x["regime"] == regime and (level is None or x["k"] % 3 == level)]
            told = [x["outcome"] for x in mine]
            answers = [x for x in mine if x["outcome"] == "answered"]
            if not answers:
                continue
            held, off = np.array([x["held"] for x in answers]), np.array([x["off"] for x in answers])
            rows.append(
                {
                    "regime": regime, "level": share, "records": len(mine), "answered": len(answers),
                    "rejected": sum(x["outcome"] == "rejected" for x in mine),
                    "refused": dict(Counter(told) - Counter(x for x in told if x in ("answered", "rejected"))),
                    "unknowns": list(REGIMES[regime][3]),
                    "coverage": held.mean(axis=0).tolist(),
                    "bias": off.mean(axis=0).tolist(), "spread": off.std(axis=0).tolist(),
                    "largest": np.abs(off).max(axis=0).tolist(),
                    "timing": float(np.mean([x["timing"] for x in answers])),
                    **{name: sum(x[name] for x in answers) for name in COUNTED},
                    "seconds": float(np.mean([x["seconds"] for x in mine])),
                }
            )  # fmt: skip
    return rows


def main() -> None:
    asked = options(__doc__, 501, "of each regime", OUTCOMES)
    asked.add_argument("regimes", nargs="*", metavar="REGIME", help=", ".join(REGIMES))
    given = asked.parse_args()
    every = [(r, k) for k in range(given.records) for r in given.regimes or REGIMES]
    known = pursued(given, every, outcome, ("regime", "k"))
    rows = table(known)
    for row in rows:
        cover, bias, spread = (" ".join(f"{x:+.3f}" for x in row[name]) for name in ("coverage", "bias", "spread"))
        share = "all" if row["level"] is None else f"{row['level']:.0%}"
        found = ", ".join(f"{name} {row[name]}" for name in COUNTED)
        print(
            f"{row['regime']:<15}{share:>4} {row['answered']:>4}/{row['records']:<4} rejected {row['rejected']:<3} "
            f"cover {cover}  bias {bias}  spread {spread} timing {row['timing']:.3f} "
            f"{found} {row['seconds']:.2f} s {row['refused'] or ''}"
        )
    if given.table:
        totals, levels = ([row for row in rows if (row["level"] is None) is over_all] for over_all in (True, False))
        shares = [{name: row[name] for name in ("regime", "level", "coverage")} for row in levels]
        record("intervals", jitter_s=JITTER_S, impacts=[IMPACTS[0], IMPACTS[1] - 1], intervals=totals, shares=shares)


if __name__ == "__main__":
    main()
