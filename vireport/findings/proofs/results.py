"""Proofs about disturbances as records of results.json, and their verification from these records alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from msgspec import field
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.base.records import ResultsBlock
from vireport.findings.proofs.proved import ClaimedSection, Proved, ProvedRegion, Rechecked, prove_again
from vireport.findings.proofs.trap import Trap
from vireport.physics.device import Device
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.scenario.loading import load
from vireport.study.reading import read_record
from vireport.study.result_records import DisturbancesData, ShockData
from vireport.study.results import results_block


class RegionData(ResultsBlock, frozen=True, kw_only=True):
    """A region that a motion attracts: |M x| <= `radius` about its first impact, M being `metric`.

    Attributes
    ----------
    word, periods, time, velocity
        the motion, and its impacts
    metric, radius
        the ellipse |M x| ≤ `radius` with M in `metric`, where x are the deviations of time and velocity at its first
        impact
    contraction
        bounds the norm of the return map there
    """

    word: str
    periods: int
    time: list[float]
    velocity: list[float]
    metric: list[list[float]]
    radius: float
    contraction: float | None = None


class ArrivalData(ResultsBlock, frozen=True, kw_only=True):
    """The region that the ball enters from rest, after how many impacts, or why that is not proved.

    Attributes
    ----------
    region, impacts, bits
        number from 0 of the region that the ball enters, after how many impacts, in an arithmetic of how many bits;
        null where that is not proved
    reason
        why it is not proved; else null
    """

    region: int | None
    impacts: int | None = None
    bits: int | None = None
    reason: str | None = None


class ProvedShocks(ResultsBlock, frozen=True, kw_only=True):
    """The largest shocks that are proved to die out, and what became of each cell.

    Attributes
    ----------
    region
        number of the region
    largest : y_c
        size up to which `cells` reach
    cells
        how many are proved
    halved
        what became of each cell, generation by generation: −1 proved, −2 undecided, 0 halved along the moment, 1
        along the jump
    """

    region: int
    largest: float
    cells: int | None = None
    halved: list[int]


class ProvedSectionData(ResultsBlock, frozen=True, kw_only=True):
    """The share of a section of impacts, and of the moments of switching on, that is proved to lead to a motion.

    Attributes
    ----------
    region, name
        number of the region, and the motion
    velocity_up_to_m_s, velocity_up_to : m/s, y_c
        velocity just before impact up to which impacts on the bottom membrane are uniform, as they are in phase
    share, share_of_switch_on_phases : 1
        lower bounds of the shares of these impacts, and of the moments of switching on, that provably lead to it
    cells
        number of cells of the section that are proved
    halved, moments
        what became of each cell of the section (0 halved along the time, 1 along the velocity), and of the moments
    """

    region: int
    name: str = ""
    velocity_up_to_m_s: float | None = None
    velocity_up_to: float
    share: float | None = None
    share_of_switch_on_phases: float | None = None
    cells: int | None = None
    halved: list[int]
    moments: list[int]


class ProofData(ResultsBlock, frozen=True, kw_only=True):
    """What it takes to check the proofs once more; regions are named by their numbers from 0.

    Attributes
    ----------
    regions
        those that a motion attracts
    from_rest
        the start from rest
    shocks
        for each stable motion
    shocks_reason
        why there are none; else null
    sections
        for each stable motion
    """

    regions: list[RegionData]
    from_rest: ArrivalData
    shocks: list[ProvedShocks]
    shocks_reason: str | None = None
    sections: list[ProvedSectionData] = field(default_factory=list)


def disturbances_with_proofs(block: DisturbancesData, proved: Proved | None) -> DisturbancesData:
    """The block on disturbances with what is proved: of the start from rest, of shocks, and with what it takes."""
    from_rest, shock = block.from_rest, block.shock or None
    if from_rest is not None:
        from_rest = replace(from_rest, proved=None if proved is None else proved.arrival.proved)
    if shock is not None or proved is not None:
        shock = replace(shock or ShockData(), proved_m_s=None if proved is None else proved.jump_m_s)
    return replace(block, from_rest=from_rest, shock=shock, proof=None if proved is None else proof_data(proved))


def proof_data(proved: Proved) -> ProofData:
    """Records of proofs, as much as it takes to check them: regions, and cells of shocks and of the section."""
    arrival, sections = proved.arrival, proved.sections
    claimed = (*(shocks.trap for shocks in proved.shocks), *(section.trap for section in sections), arrival.trap)
    # Several proofs may share a region: it is written once, and referred to by its number.
    regions = list(dict.fromkeys(trap for trap in claimed if trap is not None))
    return ProofData(
        regions=[_region(trap) for trap in regions],
        from_rest=ArrivalData(
            region=None if arrival.trap is None else regions.index(arrival.trap),
            impacts=arrival.impacts or None,
            bits=arrival.bits or None,
            reason=arrival.reason or None,
        ),
        shocks=[
            ProvedShocks(region=k, largest=shocks.largest, cells=shocks.cells, halved=shocks.halved.tolist())
            for k, shocks in enumerate(proved.shocks)
        ],
        shocks_reason=proved.unproved or None,
        sections=[
            ProvedSectionData(
                region=regions.index(section.trap),
                name=section.name,
                velocity_up_to_m_s=section.fastest * proved.velocity_unit,
                velocity_up_to=section.fastest,
                share=section.share,
                share_of_switch_on_phases=section.switch_on,
                cells=section.cells,
                halved=section.halved.tolist(),
                moments=section.moments.tolist(),
            )
            for section in sections
        ],
    )


def _region(trap: Trap) -> RegionData:
    """A trapping region as results.json has it."""
    motion = trap.motion
    return RegionData(
        word=motion.word.letters,
        periods=motion.word.periods,
        time=motion.time.tolist(),
        velocity=motion.velocity.tolist(),
        metric=trap.metric.tolist(),
        radius=trap.radius,
        contraction=trap.contraction,
    )


def recheck_disturbances(data: Mapping[str, Any]) -> Rechecked:
    """Verify the proofs of `disturbances.prove`: what reaches the motion, also from rest, and which shocks die out.

    Parameters
    ----------
    data : mapping
        Content of a results.json. Nothing that it claims of regions and cells is taken for granted.

    Returns
    -------
    Rechecked
        What is proved: `from_rest`, `proved_m_s` [m/s], `shares` and `switch_on` [1].

    Raises
    ------
    UsageError
        If the results have no such proof, or not all of its cells.
    NumericalError
        If the package for ball arithmetic is not installed.
    """
    recorded = results_block(data, "disturbances").get("proof")
    if recorded is None:
        raise UsageError("these results have no proof of disturbances (allowed: those of a scenario that asks for it)")
    proof = read_record(recorded, ProofData, "results", "disturbances.proof")
    try:
        regions = [
            ProvedRegion(
                Motion(Word.of(of.word, of.periods), np.array(of.velocity), np.array(of.time), 0.0),
                np.array(of.metric),
                of.radius,
            )
            for of in proof.regions
        ]
        start = proof.from_rest.region
        shocks = [(regions[of.region], of.largest, np.array(of.halved, dtype=np.intp)) for of in proof.shocks]
        sections = [
            ClaimedSection(
                regions[of.region],
                of.velocity_up_to,
                np.array(of.halved, dtype=np.intp),
                np.array(of.moments, dtype=np.intp),
            )
            for of in proof.sections
        ]
        device = Device.of(load(data["scenario"]).scenario)
        return prove_again(device, None if start is None else regions[start], shocks, sections)
    except (ValueError, LookupError) as error:
        raise UsageError(f"disturbances.proof: {error}") from error
