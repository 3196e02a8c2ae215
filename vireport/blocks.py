"""The blocks of a scenario: which keys exist, what they mean, and the range of each.

This is the one place where a key is defined. The JSON Schema, the wording of mistakes and the commented
template are all derived from it or checked against it. Nothing here reads a file, and nothing knows what is
computed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

# The dimensionless groups are products of up to six of the quantities, e.g. d = s M omega^2/(pi^2 F), and the
# theory squares and cubes them. With every quantity in this range those products stay clear of 1e-308 and
# 1e308, where double precision ends; the range itself is wider than that of anything built, from MEMS to wave
# power.
SMALLEST, LARGEST = 1e-15, 1e15
LONGEST_TITLE = 200
LARGEST_PERIOD_RATIO = 20

_SWEPT = "Required unless it is swept; with a sweep over it, it is the design point."

SweepParameter = Literal["length_m", "amplitude_n", "frequency_hz", "inclination_deg"]

# Where each parameter that can be swept stands in the scenario.
SWEEPABLE: dict[str, str] = {
    "length_m": "device.length_m",
    "amplitude_n": "excitation.amplitude_n",
    "frequency_hz": "excitation.frequency_hz",
    "inclination_deg": "inclination_deg",
}


def _key(title: str, unit: str | None, meaning: str, example: object, **bounds: Any) -> Any:
    if unit:
        bounds["json_schema_extra"] = {"unit": unit}
    return Field(title=title, description=meaning, examples=[example], **bounds)


def _block(title: str, meaning: str, **default: Any) -> Any:
    return Field(title=title, description=meaning, **default)


def _positive(title: str, unit: str, meaning: str, example: float, **default: Any) -> Any:
    return _key(title, unit, meaning, example, ge=SMALLEST, le=LARGEST, **default)


class _Block(BaseModel):
    # Built in one go at the end of the module, not once per class.
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


class Membrane(_Block):
    """The dielectric elastomer membrane at either end of the capsule, Eqs. (5.2)-(5.5)."""

    stiffness: float = _positive(
        "Stiffness",
        "N/m^h",
        "Coefficient K of the membrane's restoring force K delta^h.",
        4.0847e5,
        default=4.0847e5,
    )
    exponent: float = _key(
        "Exponent", "1", "Exponent h of the restoring force K delta^h.", 2.6, default=2.6, gt=0.0, le=20.0
    )
    active_radius_m: float = _positive(
        "Active radius", "m", "Radius Rc of the membrane's active area.", 6.3e-3, default=6.3e-3
    )
    ball_radius_m: float = _positive(
        "Ball radius", "m", "Radius rb of the ball; smaller than active_radius_m.", 5.0e-3, default=5.0e-3
    )
    bias_voltage_v: float = _positive(
        "Bias voltage", "V", "Voltage Uin applied to the undeformed membrane.", 2000.0, default=2000.0
    )


class Device(_Block):
    """The capsule, the ball in it, and the membranes that close it."""

    capsule_mass_kg: float = _positive("Capsule mass", "kg", "Mass M of the capsule.", 0.1245)
    ball_mass_kg: float | None = _positive(
        "Ball mass",
        "kg",
        "Mass m of the ball; smaller than capsule_mass_kg. Energy and voltage are evaluated where it is "
        "given, and left out where it is not.",
        0.0041,
        default=None,
    )
    restitution: float = _key(
        "Restitution", "1", "Coefficient of restitution r of an impact on a membrane.", 0.5, ge=0.0, le=1.0
    )
    length_m: float | None = _positive(
        "Length",
        "m",
        "Distance s between the membranes. " + _SWEPT,
        0.7,
        default=None,
    )
    membrane: Membrane | None = _block(
        "Membrane",
        "Electrical and elastic data of the membranes. Left out, the defaults hold; needs ball_mass_kg.",
        default=None,
    )


class Excitation(_Block):
    """The harmonic force on the capsule, F cos(omega t)."""

    amplitude_n: float | None = _positive(
        "Force amplitude",
        "N",
        "Amplitude F of the force on the capsule. " + _SWEPT,
        3.0,
        default=None,
    )
    frequency_hz: float | None = _positive(
        "Frequency",
        "Hz",
        "Frequency omega/(2 pi) of the force. " + _SWEPT,
        2.0,
        default=None,
    )


class Sweep(_Block):
    """One parameter taken from one value to another; everything else is held."""

    parameter: SweepParameter = _key("Swept parameter", None, "The parameter that is varied.", "length_m")
    from_: float = _key(
        "From", None, "First value, in the parameter's unit; it may be the larger.", 0.59, alias="from"
    )
    to: float = _key("To", None, "Last value, in the parameter's unit; not equal to the first.", 0.75)


class Scenario(_Block):
    """A vibro-impact energy harvester, its excitation, and what is varied."""

    schema_version: int = _key("Schema version", None, "Version of this format; 1.", 1, ge=1, le=1)
    title: str | None = _key(
        "Title",
        None,
        "Free text of one line for the head of the report.",
        "Inclined harvester",
        default=None,
        min_length=1,
        max_length=LONGEST_TITLE,
    )
    device: Device = _block("Device", "The capsule, the ball in it, and the membranes.")
    excitation: Excitation = _block("Excitation", "The harmonic force on the capsule.")
    inclination_deg: float | None = _key(
        "Inclination",
        "deg",
        "Angle beta of the capsule to the horizontal. " + _SWEPT,
        45.0,
        default=None,
        ge=0.0,
        le=90.0,
    )
    gravity_m_s2: float = _positive("Gravity", "m/s^2", "Gravitational acceleration g.", 9.8, default=9.8)
    period_ratio: int = _key(
        "Period ratio",
        "1",
        "Forcing periods n that one period of the motion takes, Eq. (3.14).",
        1,
        default=1,
        ge=1,
        le=LARGEST_PERIOD_RATIO,
    )
    sweep: Sweep | None = _block(
        "Sweep", "The parameter that is varied. Left out, the design point alone is evaluated.", default=None
    )


@contextmanager
def _no_plugins() -> Iterator[None]:
    """Keep pydantic from loading third-party plugins into our models.

    Looking for them reads the metadata of every installed package (some 5 ms), and what a scenario means must
    not depend on what else is installed.
    """
    before = os.environ.get("PYDANTIC_DISABLE_PLUGINS")
    os.environ["PYDANTIC_DISABLE_PLUGINS"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYDANTIC_DISABLE_PLUGINS"]
        else:
            os.environ["PYDANTIC_DISABLE_PLUGINS"] = before


with _no_plugins():
    Scenario.model_rebuild()
