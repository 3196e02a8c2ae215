"""What analysis and simulation share: the device and its units, flight and impact law, membranes, kinds of numbers."""

from vireport.physics import flight
from vireport.physics.affine import AFFINE_ROUNDING, Affine, AffineOps, between
from vireport.physics.contact import SMALLEST_RESTITUTION, contacts, damping_number, law_of
from vireport.physics.device import FINEST_D, FINEST_GBAR, GROUP_ERROR, NO_GRAVITY, Device, Shaker
from vireport.physics.energy import (
    Conversion,
    Dielectric,
    Fitting,
    Membrane,
    Voltages,
    contact_cosine,
    conversion,
    deflection,
    fitting,
    generated_voltage,
    voltages,
)
from vireport.physics.numbers import ARRAYS, COMPLEX, DIGITS, FLOATS, FUNCTION, UNIT, DecimalOps, Rounded, RoundedOps

__all__ = [
    "AFFINE_ROUNDING",
    "ARRAYS",
    "COMPLEX",
    "DIGITS",
    "FINEST_D",
    "FINEST_GBAR",
    "FLOATS",
    "FUNCTION",
    "GROUP_ERROR",
    "NO_GRAVITY",
    "SMALLEST_RESTITUTION",
    "UNIT",
    "Affine",
    "AffineOps",
    "Conversion",
    "DecimalOps",
    "Device",
    "Dielectric",
    "Fitting",
    "Membrane",
    "Rounded",
    "RoundedOps",
    "Shaker",
    "Voltages",
    "between",
    "contact_cosine",
    "contacts",
    "conversion",
    "damping_number",
    "deflection",
    "fitting",
    "flight",
    "generated_voltage",
    "law_of",
    "voltages",
]
