"""Judge the least yield that is required, for one design by a run and for many designs at once."""

from __future__ import annotations

from enum import auto
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.shares import share_interval
from vireport.design.devices import devices_off, sample_steps
from vireport.study.judging.designs import BORDER, Designs
from vireport.study.judging.evidence import Evidence, Judgement, Limit, held_against
from vireport.text.patterns import Pattern

if TYPE_CHECKING:
    from vireport.findings.tolerances.tolerances import Tolerances


class YieldRemark(Pattern, file="tolerances"):
    """Sentences on where a yield comes from, and why the requirement is not met."""

    NO_TOLERANCES = auto()
    PROVED = auto()
    COUNTED = auto()


Mask = NDArray[np.bool_]

FEW_SAMPLES = 64
"""Devices by which designs are judged first that lack a yield by far."""

AT_ONCE = 2048
"""Devices whose motions are looked for at once: of a design alone, most of the time goes into calls on short arrays."""


def judged_yield(results: Evidence, limit: Limit) -> Judgement:
    """Judge the share of the devices within the tolerances that work; it is exact only where all are proved to."""
    if "tolerances" not in results.findings:
        raise NumericalError(YieldRemark.NO_TOLERANCES.said())
    tolerances: Tolerances = results.findings["tolerances"]
    if tolerances.proved:
        return held_against(100.0, limit, YieldRemark.PROVED.said())
    sampled = tolerances.sampled
    share = 100 * sampled.stable / sampled.samples
    counted = YieldRemark.COUNTED.said(count=sampled.stable, total=sampled.samples)
    return held_against(share, limit, counted, share - 100 * sampled.low)


def may_yield(designs: Designs, limit: Limit) -> Mask:
    """Which designs may reach a yield, by as few as suffice of the same random devices that a run takes."""
    block, kept = designs.scenario.tolerances, np.ones(designs.count, dtype=bool)
    if block is None:
        return kept
    steps = sample_steps(len(designs.half_widths), block.distribution, block.samples)
    enough = (k for k in range(block.samples) if 100 * share_interval(k, block.samples)[1] >= limit.value)
    most = block.samples - next(enough, block.samples)  # all samples, where only the proof is enough
    # Whole Sobol sequences are balanced, not their beginnings: only a count that no further device can mend refutes.
    failed, first = np.zeros(designs.count, dtype=np.intp), 0
    while first < block.samples:
        last = min(max(2 * first, FEW_SAMPLES), block.samples)
        rows, several = np.flatnonzero(kept), max(AT_ONCE // (last - first), 1)
        for some in (rows[k : k + several] for k in range(0, len(rows), several)):
            around = designs.select(np.repeat(some, last - first))
            device = devices_off(around.device, around.half_widths, np.tile(steps[:, first:last], len(some)))
            works = replace(around, device=device).has_motion(BORDER)
            failed[some] += np.count_nonzero(~works.reshape(len(some), -1), axis=1)
        kept, first = failed <= most, last
    return kept
