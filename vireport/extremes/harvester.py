"""The harvester that the extreme cases are built around: its device, its membranes, and scenarios made of them."""

from __future__ import annotations

from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.encoding import json_text
from vireport.base.records import plain
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.energy import Membrane
from vireport.physics.groups import Groups
from vireport.scenario.loading import Loaded, loads
from vireport.scenario.parameters import Parameter
from vireport.study.plan import Task
from vireport.study.study import Study, analyse

WIDE = (0.02, 3.0)
"""Range of d in which 1:1 motions begin and end."""

SweepRange = tuple[Parameter, float, float]
"""Parameter that is swept, and the ends of its range."""


class Harvester(Struct, frozen=True):
    """A device with membranes.

    Attributes
    ----------
    device : Device
        With all its parameters and the ball's mass given.
    membrane : Membrane
        That of this device.
    span : tuple of float
        Sweep of the length, as factors of the device's.
    """

    device: Device
    membrane: Membrane
    span: tuple[float, float]

    @property
    def groups(self) -> Groups[float]:
        """The groups of the device."""
        return self.device.groups(Parameter.LENGTH, self.device.length_m).as_floats()

    def with_device(self, **changes: Any) -> Harvester:
        """A harvester with other values of the device."""
        device = replace(self.device, **changes)
        return replace(self, device=device, membrane=self.membrane.of_device(device))

    def with_groups(self, d: float | None = None, gbar: float | None = None) -> Harvester:
        """A harvester with these groups: the force gives gbar, at 90 degrees where the capsule was horizontal."""
        changed, (own_d, own_gbar, *_) = self, self.groups
        if gbar is not None:
            changed = changed if own_gbar > 0 else changed.with_device(inclination_deg=90.0)
            weight = changed.groups[1] * changed.device.amplitude_n
            changed = changed.with_device(amplitude_n=float(weight / gbar))
        return changed.with_device(length_m=changed.length(own_d if d is None else d))

    def length(self, d: float) -> float:
        """The length at which the device has this d [m]."""
        device = self.device
        return float(d * device.amplitude_n / (4 * device.capsule_mass_kg * device.frequency_hz**2))

    def scenario(self, sweep: SweepRange | None) -> Loaded:
        """The device as a scenario; ScenarioError where that is invalid."""
        device, membrane = self.device, plain(self.membrane)
        own = RESTITUTIONS[:1] if device.alike else RESTITUTIONS[1:]
        for said_by_device in ("ball_mass_kg", "free_capsule_kg"):
            membrane.pop(said_by_device)
        membrane |= membrane.pop("dielectric") or {}
        tree: dict[str, Any] = {
            "schema_version": 1,
            "inclination_deg": device.inclination_deg,
            "gravity_m_s2": device.gravity_m_s2,
            "period_ratio": device.period_ratio,
            "excitation": {"amplitude_n": device.amplitude_n, "frequency_hz": device.frequency_hz},
            "device": {
                "capsule_mass_kg": device.capsule_mass_kg,
                "ball_mass_kg": device.ball_mass_kg,
                "capsule": device.capsule,
                **{told: device.value_of(told) for told in own},
                "length_m": device.length_m,
                "membrane": membrane,
            },
        }
        if sweep is not None:
            tree["sweep"] = {"parameter": sweep[0], "from": sweep[1], "to": sweep[2]}
        return loads(json_text(tree), "extreme case")

    def study(self, sweep: SweepRange | None = None) -> Study:
        """Everything that a run finds out about the device, and about a sweep."""
        return analyse(self.scenario(sweep), (Task.JSON,))

    def over(self, d: tuple[float, float] = WIDE) -> Study:
        """The study with the length swept over a range of d."""
        return self.study((Parameter.LENGTH, self.length(d[0]), self.length(d[1])))


PAPER = Harvester(
    Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0, ball_mass_kg=0.0041),
    Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041),
    (0.59 / 0.6934, 0.75 / 0.6934),
)
"""That of the paper's Fig. 3 (c)-(d), and the sweep of its Fig. 2 (d)-(f)."""


def harvester_of(loaded: Loaded | None) -> Harvester:
    """That of a scenario, in the middle of its sweep where it gives no design point; the paper's for None."""
    if loaded is None:
        return PAPER
    scenario, device = loaded.scenario, Device.of(loaded.scenario)
    span = PAPER.span
    if scenario.sweep is not None:
        parameter, ends = Parameter(scenario.sweep.parameter), (scenario.sweep.from_, scenario.sweep.to)
        if device.value_of(parameter) is None:
            device = device.with_values({parameter: sum(ends) / 2})
        if parameter is Parameter.LENGTH:
            span = ends[0] / device.length_m, ends[1] / device.length_m
    membrane = Membrane.of(scenario)
    if membrane is None:
        mass = PAPER.membrane.ball_mass_kg / PAPER.device.capsule_mass_kg * device.capsule_mass_kg
        device = replace(device, ball_mass_kg=float(mass))
        membrane = PAPER.membrane.of_device(device)
    return Harvester(device, membrane, span)
