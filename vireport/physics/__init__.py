"""What analysis and simulation share: the device and its units, flight and impact law, membranes, kinds of numbers."""

from vireport.physics import flight
from vireport.physics.contact import SMALLEST_RESTITUTION, Contact, contacts, damping_number, law_of
from vireport.physics.decimals import DIGITS, DecimalOps
from vireport.physics.device import FINEST_D, FINEST_GBAR, NO_GRAVITY, Device, Number
from vireport.physics.energy import Membrane, Voltages, contact_cosine, deflection, generated_voltage, voltages
from vireport.physics.flight import acceleration, displacement, velocity
from vireport.physics.rounding import FUNCTION, UNIT, Rounded, RoundedOps

__all__ = [
    "DIGITS",
    "FINEST_D",
    "FINEST_GBAR",
    "FUNCTION",
    "NO_GRAVITY",
    "SMALLEST_RESTITUTION",
    "UNIT",
    "Contact",
    "DecimalOps",
    "Device",
    "Membrane",
    "Number",
    "Rounded",
    "RoundedOps",
    "Voltages",
    "acceleration",
    "contact_cosine",
    "contacts",
    "damping_number",
    "deflection",
    "displacement",
    "flight",
    "generated_voltage",
    "law_of",
    "velocity",
    "voltages",
]
