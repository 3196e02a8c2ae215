"""What analysis and simulation share: the device and its units, flight and impact law, membranes, kinds of numbers."""

from vireport.physics import flight
from vireport.physics.affine import AFFINE, AFFINE_ROUNDING, Affine, between
from vireport.physics.contact import SMALLEST_RESTITUTION, contacts, damping_number, law_of
from vireport.physics.device import FINEST_D, FINEST_GBAR, GROUP_ERROR, NO_GRAVITY, RESTITUTIONS, Device, Shaker
from vireport.physics.energy import (
    Conversion,
    Dielectric,
    ElectricalCycle,
    Fitting,
    Membrane,
    Voltages,
    contact_cosine,
    conversion,
    cycle_of,
    deflection,
    fitting,
    generated_voltage,
    voltages,
)
from vireport.physics.flight import Flight
from vireport.physics.groups import Groups, Restitutions, by_wall, each
from vireport.physics.numbers import (
    ARRAYS,
    DIGITS,
    FLOATS,
    FUNCTION,
    ROUNDED,
    UNIT,
    DecimalOps,
    Rounded,
    infinite_where_undefined,
    magnitude,
    wrapped,
)
from vireport.physics.voltage_bounds import voltage_bounds
from vireport.physics.word import Word, word_name

__all__ = [
    "AFFINE",
    "AFFINE_ROUNDING",
    "ARRAYS",
    "DIGITS",
    "FINEST_D",
    "FINEST_GBAR",
    "FLOATS",
    "FUNCTION",
    "GROUP_ERROR",
    "NO_GRAVITY",
    "RESTITUTIONS",
    "ROUNDED",
    "SMALLEST_RESTITUTION",
    "UNIT",
    "Affine",
    "Conversion",
    "DecimalOps",
    "Device",
    "Dielectric",
    "ElectricalCycle",
    "Fitting",
    "Flight",
    "Groups",
    "Membrane",
    "Restitutions",
    "Rounded",
    "Shaker",
    "Voltages",
    "Word",
    "between",
    "by_wall",
    "contact_cosine",
    "contacts",
    "conversion",
    "cycle_of",
    "damping_number",
    "deflection",
    "each",
    "fitting",
    "flight",
    "generated_voltage",
    "infinite_where_undefined",
    "law_of",
    "magnitude",
    "voltage_bounds",
    "voltages",
    "word_name",
    "wrapped",
]
