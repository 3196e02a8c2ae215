"""The device whose inputs the tests vary, and its requirements without the limits that a search takes by itself."""

import json

DEVICE = """\
schema_version: 1
device:
  capsule_mass_kg: 0.1245
  ball_mass_kg: 0.0041
  restitution: 0.5
  length_m: 0.7
  membrane: {thickness_m: 1.0e-3, relative_permittivity: 4.7, breakdown_field_v_m: 1.0e+8}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 45
"""

UNLIMITED = {
    "reached_from_rest": False,
    "efficiency_at_most_percent": 1e9,
    "field_at_most_percent": 1e9,
}
"""What takes the place of what is required by default: the impacts of this device are beyond some of the limits."""


def unlimited(required: str = "") -> str:
    """Requirements, as pairs of key and value, beside which the limits of physics do not hold."""
    open_limits = (f"{key}: {json.dumps(limit)}" for key, limit in UNLIMITED.items() if f"{key}:" not in required)
    return ", ".join((*([required] if required else []), *open_limits))
