"""The dimensionless model of the ball between two compliant membranes.

Z'' = gbar + cos(pi t + phi) - k delta^h (1 + lambda delta') at the bottom membrane, where delta = Z - d/2 > 0, and the
mirror image of the last term at the top one; harmonics of the force add to the cosine. The membranes move with the
capsule; k = K x_c^h M/(m F). For each contact lambda is set from its impact velocity so that the contact alone would
have the restitution coefficient r (`physics.contact`). For a free capsule gbar and m are those of the relative motion,
see `Device`. The flights between contacts have a closed form, as in the simulation.
"""

from __future__ import annotations

from math import inf, pi
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import NumericalError
from vireport.physics.contact import contacts
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import check_model, follow_one
from vireport.simulation.kernel import FLIGHT, VELOCITY, WALL


class CompliantModel(Struct, frozen=True, eq=False):
    """The dimensionless model of a device with compliant membranes.

    Attributes
    ----------
    d, gbar : float
        As in `Device.groups`.
    membrane : Membrane
        With the dimensionless stiffness k and mass 1, so that `contacts` works in dimensionless numbers.
    restitution : float or Restitutions
        r of a contact alone, on both membranes or on each.
    period : float
        2n, the time after which the motion repeats [t_c].
    length_unit, velocity_unit : float
        x_c [m], y_c [m/s].
    harmonics : tuple of Harmonic
        Harmonics of the force.
    """

    d: float
    gbar: float
    membrane: Membrane
    restitution: Any
    period: float
    length_unit: float
    velocity_unit: float
    harmonics: tuple[Harmonic, ...] = ()

    def restitution_at(self, wall: int) -> float:
        """Restitution coefficient of a contact with a membrane without other forces."""
        return float(Groups(self.d, self.gbar, self.restitution).restitution_at(wall))


def compliant_model(
    device: Device, parameter: Parameter, value: float, membrane: Membrane, factor: float = 1.0
) -> CompliantModel:
    """Make a device with compliant membranes dimensionless.

    Parameters
    ----------
    device : Device
    parameter : Parameter
        Parameter whose value differs from the device's.
    value : float
        In the parameter's unit.
    membrane : Membrane
    factor : float
        Stiffness over that of the membrane.
    """
    at = device.at(parameter, float(value))
    d, gbar, restitution, harmonics, _ = device.groups(parameter, float(value)).as_floats()
    speed = float(device.velocity_unit(parameter, float(value)))
    length, h = speed / (2 * at[Parameter.FREQUENCY]), membrane.exponent  # x_c = y_c t_c, with t_c = 1/(2 f)
    # Force K delta^h over the mass m of the relative motion, in units of F/M: x_c^h K M/(m F).
    per_ball = length**h * device.capsule_mass_kg / (membrane.reduced_mass_kg * at[Parameter.AMPLITUDE])
    stiffness = factor * membrane.stiffness * per_ball
    scaled = replace(membrane, stiffness=stiffness, ball_mass_kg=1.0, free_capsule_kg=inf)
    return CompliantModel(d, gbar, scaled, restitution, 2.0 * device.period_ratio, length, speed, harmonics)


class ContactUnits(Struct, frozen=True, eq=False):
    """Units of time and depth for one contact, in which contacts of all stiffnesses look alike.

    Attributes
    ----------
    time, depth : float
        Duration [t_c] and largest deflection [x_c] of the contact without other forces.
    spring : float
        Force of the membrane at a depth of 1, in these units.
    damping : float
        lambda in these units.
    pull : float
        An acceleration Z'' = 1 in these units, positive towards the membrane.
    speed : float
        Speed at the touch, in these units, towards the membrane.
    """

    time: float
    depth: float
    spring: float
    damping: float
    pull: float
    speed: float


def contact_units(model: CompliantModel, wall: int, velocity: float) -> ContactUnits:
    """Units of a contact with a membrane that is struck with a velocity Z' [y_c]."""
    # The contact without other forces: what gravity and the forcing do meanwhile is a correction to it.
    alone = contacts(np.array(velocity), model.membrane, model.restitution_at(wall))
    time, depth = float(alone.duration), float(alone.deflection)
    # By logarithms: the depth to the power h - 1 may vanish where its product with K does not.
    stiffness = float(np.exp(np.log(model.membrane.stiffness) + (model.membrane.exponent - 1) * np.log(depth)))
    return ContactUnits(
        time,
        depth,
        spring=stiffness * time * time,
        damping=float(alone.damping) * depth / time,
        pull=wall * time * time / depth,
        speed=wall * velocity * time / depth,
    )


def free_flight(model: CompliantModel, wall: int, leaving: float, phase: float) -> tuple[float, int, float]:
    """Fly from a membrane to the first touch of either one: return time of flight [t_c], wall and Z' there [y_c].

    The event search of the simulation misses no touch; in it the ball leaves as from an impact without loss.

    Parameters
    ----------
    model : CompliantModel
    wall : int
        The membrane that is left.
    leaving : float
        Z' at the departure, away from the wall [y_c].
    phase : float
        Forcing phase at the departure [rad].

    Raises
    ------
    NumericalError
        If no membrane is touched within two periods of the motion.
    """
    start = float(wall), 0.0, -leaving, phase % (2 * pi)
    # With restitution 1 the ball leaves an impact in the search with just the velocity of the departure.
    rows, _ = follow_one(check_model(Groups(model.d, model.gbar, 1.0, model.harmonics))[0], start, 1, compiled=False)
    if len(rows) < 2 or rows[1, FLIGHT] > 2 * model.period:
        raise NumericalError("no membrane is touched within two periods")
    return float(rows[1, FLIGHT]), int(rows[1, WALL]), float(rows[1, VELOCITY])
