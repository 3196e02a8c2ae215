"""What a device does under a recorded motion of its shaker as plain data, for results.json."""

from __future__ import annotations

from typing import Any

from vireport.base.records import plain
from vireport.findings.driven.driven import Driven
from vireport.study.results import shaker_finding_data

DRIVEN_MEANS = "impacts_per_s", "speed_bottom_m_s", "speed_top_m_s", "voltage_per_s", "power_mw"
"""Means along a record, by their names in results.json and of `Driven`."""


def driven_data(found: Driven) -> dict[str, Any]:
    """What the device does under a recorded motion of its shaker, beside the periodic motion that is predicted."""
    recording, shaker, device = found.recording, found.shaker, found.device
    means = {name: getattr(found, name) for name in DRIVEN_MEANS}
    return {
        "record": recording.name,
        "samples": recording.samples,
        "sampling_rate_hz": 1 / recording.step_s,
        "from_s": found.settled_s,
        "to_s": recording.end_s,
        "excitation": {
            "amplitude_n": float(device.amplitude_n),
            "frequency_hz": float(device.frequency_hz),
            "offset_m_s2": shaker.offset,
            "harmonics": [plain(own) for own in shaker.harmonics if own.significant],
        },
        "impacts": len(found.times_s),
        "periods": found.periods,
        "words": [{"word": own.letters, "share": own.share} for own in found.words],
        "share_at_rest": found.rests,
        **{
            name: mean and {"value": mean.value, "from": mean.low, "to": mean.high, "reason": mean.why}
            for name, mean in means.items()
        },
        "deepest_m": found.deepest_m,
        "predicted": found.predicted and plain(found.predicted),
        "findings": [shaker_finding_data(own) for own in found.doubts],
    }
