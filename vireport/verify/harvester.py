"""The harvester that the extreme cases are built around: its device, and scenarios made of it."""

from __future__ import annotations

from msgspec import Struct
from msgspec.structs import replace

from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.energy import Membrane
from vireport.physics.groups import Groups
from vireport.scenario.blocks import Scenario
from vireport.scenario.json_schema import init_text
from vireport.scenario.loading import Loaded, load, loads
from vireport.scenario.parameters import Parameter
from vireport.scenario.writing import device_tree
from vireport.study.plan import Task
from vireport.study.study import Study, analyse

WIDE = (0.02, 3.0)
"""Range of d in which 1:1 motions begin and end."""

BALL = "device.ball_mass_kg"

BALL_SHARE = 0.0041 / 0.1245
"""Mass of the ball over that of the capsule, of the paper's device: where a scenario does not give it."""

SPAN = (0.59 / 0.6934, 0.75 / 0.6934)
"""Sweep of the length over the device's, of the paper's Fig. 2 (d)-(f)."""

SweepRange = tuple[Parameter, float, float]
"""Parameter that is swept, and the ends of its range."""


class Harvester(Struct, frozen=True):
    """The device around which extreme cases are built, and the scenario that it comes from.

    Attributes
    ----------
    scenario : Scenario
        That the device was taken from, with a design point and the ball's mass.
    device : Device
        As it is, or with other values.
    span : tuple of float
        Sweep of the length, as factors of the device's.
    """

    scenario: Scenario
    device: Device
    span: tuple[float, float]

    @property
    def membrane(self) -> Membrane:
        """The membrane that the ball of the device strikes."""
        membrane = Membrane.of(self.scenario)
        assert membrane is not None
        return membrane.of_device(self.device)

    @property
    def groups(self) -> Groups[float]:
        """The groups of the device."""
        return self.device.groups(Parameter.LENGTH, self.device.length_m).as_floats()

    def with_device(self, **changes: object) -> Harvester:
        """A harvester with other values of the device."""
        return replace(self, device=replace(self.device, **changes))

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

    def study(self, sweep: SweepRange | None = None) -> Study:
        """Everything that a run finds out about the device, and about a sweep; ScenarioError where it is invalid."""
        device = self.device
        values = {BALL: device.ball_mass_kg, "gravity_m_s2": device.gravity_m_s2}
        values |= {varied.path: None for varied in RESTITUTIONS}
        values |= {varied.path: device.value_of(varied) for varied in device.inputs}
        tree = device_tree(self.scenario, values)
        if sweep is not None:
            tree["sweep"] = {"parameter": sweep[0], "from": sweep[1], "to": sweep[2]}
        return analyse(load(tree), (Task.JSON,))

    def over(self, d: tuple[float, float] = WIDE) -> Study:
        """The study with the length swept over a range of d."""
        return self.study((Parameter.LENGTH, self.length(d[0]), self.length(d[1])))


def harvester_of(loaded: Loaded | None) -> Harvester:
    """The harvester of a scenario, in the middle of its sweep where it gives no design point.

    For None that of the paper's Fig. 3 (c)-(d).
    """
    if loaded is None:
        loaded = loads(init_text(), "the paper's", {"device.length_m": 0.6934})
    scenario, device = loaded.scenario, Device.of(loaded.scenario)
    values, span = {}, SPAN
    if scenario.sweep is not None:
        parameter, ends = Parameter(scenario.sweep.parameter), (scenario.sweep.from_, scenario.sweep.to)
        if device.value_of(parameter) is None:
            values[parameter.path] = sum(ends) / 2
        if parameter is Parameter.LENGTH:
            length = device.length_m or sum(ends) / 2
            span = ends[0] / length, ends[1] / length
    if device.ball_mass_kg is None:
        values[BALL] = BALL_SHARE * device.capsule_mass_kg
    scenario_read = load(device_tree(scenario, values)).scenario
    return Harvester(scenario_read, Device.of(scenario_read), span)
