"""What can be changed on the bench: the numbers and choices of a scenario, each with the ends of its slider."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from math import inf

from msgspec import Struct
from pydantic.fields import FieldInfo

from vireport.design.lines import HIGHEST_RESTITUTION
from vireport.physics.device import RESTITUTIONS
from vireport.scenario.blocks import (
    CapsuleMotion,
    MembraneBlock,
    RequirementsBlock,
    Scenario,
    key_of,
    keys_left_out,
    percent_key,
    unit_of,
)
from vireport.scenario.keys import names_in_order, value_at
from vireport.scenario.parameters import LARGEST, DesignInput, ScalarInput

STIFFEST_FRICTION = 0.3
"""Upper end of the slider of the coefficient of friction: that of rubber on steel is never looked for."""

SPAN = 2.0
"""Times by which a slider goes beyond the value that it begins with, to either side."""

LARGEST_SHARE = 50.0
"""Upper end of a number in per cent whose key has no lower one."""


class Group(StrEnum):
    """What controls belong together; the value is the heading of their group."""

    DEVICE = "Device"
    FORCE = "Force"
    MEMBRANE = "Membranes"
    REQUIRED = "Required"
    TOLERANCES = "Tolerances"


class Control(Struct, frozen=True):
    """A number of a scenario that can be changed.

    Attributes
    ----------
    path : str
        Where it stands in a scenario, as for ``--set``.
    group : Group
    title, symbol, unit, meaning : str
        As the key is declared; the symbol is the paper's, "" where it has none.
    start, end : float
        Of the slider, within what the key allows.
    slider : bool
        Whether it has one: requirements and tolerances are typed.
    """

    path: str
    group: Group
    title: str
    symbol: str
    unit: str
    meaning: str
    start: float
    end: float
    slider: bool = True


SYMBOLS = {varied.path: varied.symbol for varied in DesignInput} | {
    "device.ball_mass_kg": "m",
    "device.friction": "μ",
    "gravity_m_s2": "g",
    "device.membrane.stiffness": "K",
    "device.membrane.exponent": "h",
}

DEVICE = (
    "device.length_m",
    "inclination_deg",
    *(varied.path for varied in RESTITUTIONS),
    "device.capsule_mass_kg",
    "device.ball_mass_kg",
    "device.friction",
)
FORCE = "excitation.amplitude_n", "excitation.frequency_hz"

CHOICES = {"device.capsule": tuple(CapsuleMotion)}
"""Keys with a choice of words."""


def controls_of(scenario: Scenario) -> tuple[Control, ...]:
    """Everything of a scenario that can be changed, in the order of the page.

    Keys that a scenario is without are there as well, where it may have them: the ball's mass, each restitution, and
    what can be required of the 1:1 motions.
    """
    return tuple(_control(scenario, path, group) for path, group in _paths(scenario))


def values_of(scenario: Scenario) -> dict[str, object]:
    """The values behind all controls and choices, by their paths, None where one is not given; and the harmonics."""
    values = {path: value_at(scenario, path) for path in (*(path for path, _ in _paths(scenario)), *CHOICES)}
    return {**values, "excitation.harmonics": [harmonic.model_dump() for harmonic in scenario.excitation.harmonics]}


def ends_of(scenario: Scenario, varied: ScalarInput) -> tuple[float, float]:
    """From where to where an input is moved: the ends of its slider."""
    return _ends(varied.path, key_of(varied.path), value_at(scenario, varied.path), scenario)


def _paths(scenario: Scenario) -> Iterator[tuple[str, Group]]:
    """The keys that have a control, with the group of each."""
    yield from ((path, Group.DEVICE) for path in DEVICE)
    yield from ((path, Group.FORCE) for path in FORCE)
    if scenario.device.membrane is not None:
        yield from ((f"device.membrane.{name}", Group.MEMBRANE) for name in MembraneBlock.model_fields)
    for name in names_in_order(RequirementsBlock):
        if _is_number(RequirementsBlock.model_fields[name]):
            yield f"requirements.{name}", Group.REQUIRED
    if "tolerances" not in keys_left_out(Scenario):
        yield from ((f"tolerances.{percent_key(varied)}", Group.TOLERANCES) for varied in DesignInput)


def _is_number(key: FieldInfo) -> bool:
    return key.annotation in (float, float | None)


def _control(scenario: Scenario, path: str, group: Group) -> Control:
    key, value, typed = key_of(path), value_at(scenario, path), group in (Group.REQUIRED, Group.TOLERANCES)
    start, end = _ends(path, key, value, scenario)
    what = key.title or "", SYMBOLS.get(path, ""), unit_of(key), key.description or ""
    return Control(path, group, *what, start, end, not typed)


def _ends(path: str, key: FieldInfo, value: float | None, scenario: Scenario) -> tuple[float, float]:
    """The ends of a slider: of what the key allows, where that is a range, else around the value that it begins with.

    A swept parameter has those of the sweep, widened to hold the design point.
    """
    if path == "device.friction":
        return 0.0, STIFFEST_FRICTION
    bounds = {
        name: getattr(rule, name) for rule in key.metadata for name in ("ge", "gt", "le", "lt") if hasattr(rule, name)
    }
    low, high = bounds.get("ge", bounds.get("gt", -inf)), bounds.get("le", bounds.get("lt", inf))
    if any(path == varied.path for varied in RESTITUTIONS):
        high = HIGHEST_RESTITUTION
    sweep = scenario.sweep
    if sweep is not None and sweep.parameter.path == path:
        held = [sweep.from_, sweep.to] if value is None else [sweep.from_, sweep.to, value]
        return min(held), max(held)
    if "ge" in bounds and high < LARGEST:
        return low, high
    about = value if value is not None else float((key.examples or [LARGEST_SHARE])[0])
    return max(low, about / SPAN), min(high, about * SPAN)
