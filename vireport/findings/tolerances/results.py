"""What tolerances come to as plain data, for results.json, and what can be proved once more from that alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vireport.base.errors import UsageError
from vireport.findings.tolerances.proof import prove_again
from vireport.findings.tolerances.region import region_of
from vireport.findings.tolerances.tolerances import Failure, Tolerances, half_widths
from vireport.physics.device import Device
from vireport.scenario.blocks import Scenario
from vireport.scenario.loading import load
from vireport.scenario.writing import as_yaml, device_tree
from vireport.study.results import results_block

PROVED_MOTION = "u", "phi_bottom_rad", "velocity_bottom"
"""Names of what a proof over tolerances says of a motion; u is q - 1/2."""


def tolerances_data(tolerances: Tolerances, scenario: Scenario) -> dict[str, Any]:
    """What tolerances come to; the worst device as a scenario too."""
    sampled, proof, worst = tolerances.sampled, tolerances.proof, tolerances.worst
    return {
        "answer": tolerances.answer.value,
        "inputs": [
            {"parameter": varied, "from": low, "to": high, "unit": varied.unit}
            for varied, (low, high) in tolerances.region.ranges.items()
        ],
        "boxes": 0 if proof is None else proof.boxes,
        "open_share": None if proof is None or worst is not None else proof.open_share,
        "proof": None
        if proof is None
        else {"halved": proof.halved.tolist(), **dict(zip(PROVED_MOTION, proof.motions.tolist(), strict=True))},
        "proof_not_known_of": None if tolerances.provable else "excitation.harmonics",
        "worst": None
        if worst is None
        else {"values": dict(worst.values), "share": worst.share, "scenario": worst_scenario(scenario, worst)},
        "yield": {
            "distribution": sampled.distribution,
            "samples": sampled.samples,
            "stable": sampled.stable,
            "share": sampled.stable / sampled.samples,
            "low_95": sampled.low,
            "high_95": sampled.high,
        },
        "ranges": tolerances.ranges,
    }


def worst_scenario(scenario: Scenario, worst: Failure) -> str:
    """A scenario of the device that fails: its inputs, and nothing of what was asked of the design."""
    return as_yaml(device_tree(scenario, {varied.path: value for varied, value in worst.values.items()}))


def recheck(data: Mapping[str, Any]) -> float:
    """Go through the boxes of a proof over tolerances once more, from results alone.

    Parameters
    ----------
    data : mapping
        The content of a results.json.

    Returns
    -------
    float
        Share of the volume that is proved, 1 where every device within the tolerances is.

    Raises
    ------
    UsageError
        If the results have no proof, or not all of its boxes.
    """
    proof = results_block(data, "tolerances").get("proof")
    scenario = load(results_block(data, "scenario")).scenario
    if scenario.tolerances is None or proof is None:
        raise UsageError("these results have no proof over tolerances (allowed: those of a scenario with tolerances)")
    device = Device.of(scenario)
    try:
        boxes = np.array(proof["halved"], dtype=np.intp), np.array([proof[name] for name in PROVED_MOTION])
        return prove_again(region_of(device, half_widths(device, scenario.tolerances)), *boxes)
    except ValueError as error:
        raise UsageError(f"tolerances.proof: {error}") from error
