"""What a device does under a recorded motion of its shaker as plain data, for results.json."""

from __future__ import annotations

from typing import Any

from vireport.base.records import plain
from vireport.findings.driven.driven import Driven
from vireport.study.results import shaker_finding_data

DRIVEN_MEANS = "impacts_per_s", "speed_bottom_m_s", "speed_top_m_s", "voltage_per_s", "power_mw"
"""Means along a record, by their names in results.json and of `Driven`."""


def driven_data(driven: Driven) -> dict[str, Any]:
    """What the device does under a recorded motion of its shaker, beside the periodic motion that is predicted."""
    recording, shaker, device = driven.recording, driven.shaker, driven.device
    means = {name: getattr(driven, name) for name in DRIVEN_MEANS}
    return {
        "record": recording.name,
        "samples": recording.samples,
        "sampling_rate_hz": 1 / recording.step_s,
        "from_s": driven.settled_s,
        "to_s": recording.end_s,
        "excitation": {
            "amplitude_n": float(device.amplitude_n),
            "frequency_hz": float(device.frequency_hz),
            "offset_m_s2": shaker.offset,
            "harmonics": [plain(row) for row in shaker.harmonics if row.significant],
        },
        "impacts": len(driven.times_s),
        "periods": driven.periods,
        "words": [{"word": row.letters, "share": row.share} for row in driven.words],
        "share_at_rest": driven.rests,
        **{
            name: mean and {"value": mean.value, "from": mean.low, "to": mean.high, "reason": mean.why}
            for name, mean in means.items()
        },
        "deepest_m": driven.deepest_m,
        "predicted": driven.predicted and plain(driven.predicted),
        "findings": [shaker_finding_data(row) for row in driven.doubts],
    }
