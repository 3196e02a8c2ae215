"""Proofs about disturbances as plain data, for results.json, and checked once more from that data alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vireport.base.errors import UsageError
from vireport.findings.proofs.proved import ClaimedSection, Proved, ProvedRegion, Rechecked, prove_again
from vireport.findings.proofs.trap import Trap
from vireport.physics.device import Device
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.scenario.loading import load
from vireport.study.results import results_block


def proof_data(proved: Proved) -> dict[str, Any]:
    """Plain data of proofs, as much as it takes to check them: regions, and cells of shocks and of the section."""
    arrival, sections = proved.arrival, proved.sections
    claimed = (*(shocks.trap for shocks in proved.shocks), *(section.trap for section in sections), arrival.trap)
    # Several proofs are about one region: it is written once, and named by its number.
    regions = list(dict.fromkeys(trap for trap in claimed if trap is not None))
    return {
        "regions": [_region(trap) for trap in regions],
        "from_rest": {
            "region": None if arrival.trap is None else regions.index(arrival.trap),
            "impacts": arrival.impacts or None,
            "bits": arrival.bits or None,
            "reason": arrival.reason or None,
        },
        "shocks": [
            {"region": k, "largest": shocks.largest, "cells": shocks.cells, "halved": shocks.halved.tolist()}
            for k, shocks in enumerate(proved.shocks)
        ],
        "shocks_reason": proved.unproved or None,
        "sections": [
            {
                "region": regions.index(section.trap),
                "name": section.name,
                "velocity_up_to_m_s": section.fastest * proved.velocity_unit,
                "velocity_up_to": section.fastest,
                "share": section.share,
                "share_of_switch_on_phases": section.switch_on,
                "cells": section.cells,
                "halved": section.halved.tolist(),
                "moments": section.moments.tolist(),
            }
            for section in sections
        ],
    }


def _region(trap: Trap) -> dict[str, Any]:
    """Plain data of a trapping region."""
    motion = trap.motion
    return {
        "word": motion.word.letters,
        "periods": motion.word.periods,
        "time": motion.time.tolist(),
        "velocity": motion.velocity.tolist(),
        "metric": trap.metric.tolist(),
        "radius": trap.radius,
        "contraction": trap.contraction,
    }


def recheck_disturbances(data: Mapping[str, Any]) -> Rechecked:
    """Go once more through the proofs of what comes to the motion, from rest as well, and which shocks it survives.

    Parameters
    ----------
    data : mapping
        The content of a results.json. Of its regions and cells only what they claim is believed to be claimed.

    Raises
    ------
    UsageError
        If the results have no such proof, or not all of its cells.
    NumericalError
        If the package for ball arithmetic is not installed.
    """
    proof = results_block(data, "disturbances").get("proof")
    if proof is None:
        raise UsageError("these results have no proof of disturbances (allowed: those of a scenario that asks for it)")
    try:
        regions = [
            ProvedRegion(
                Motion(Word.of(of["word"], of["periods"]), np.array(of["velocity"]), np.array(of["time"]), 0.0),
                np.array(of["metric"]),
                float(of["radius"]),
            )
            for of in proof["regions"]
        ]
        start = proof["from_rest"]["region"]
        shocks = [
            (regions[of["region"]], float(of["largest"]), np.array(of["halved"], dtype=np.intp))
            for of in proof["shocks"]
        ]
        sections = [
            ClaimedSection(
                regions[of["region"]],
                float(of["velocity_up_to"]),
                np.array(of["halved"], dtype=np.intp),
                np.array(of["moments"], dtype=np.intp),
            )
            for of in proof.get("sections", ())
        ]
        device = Device.of(load(data["scenario"]).scenario)
        return prove_again(device, None if start is None else regions[start], shocks, sections)
    except (ValueError, LookupError) as error:
        raise UsageError(f"disturbances.proof: {error}") from error
