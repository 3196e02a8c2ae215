"""What analysis and simulation share: the device and its units, flight and impact law, membranes, kinds of numbers."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.physics import flight
from vireport.physics.affine import AFFINE, AFFINE_ROUNDING, Affine, between
from vireport.physics.contact import SMALLEST_RESTITUTION, contacts, damping_number, law_of
from vireport.physics.device import (
    FINEST_D,
    FINEST_GBAR,
    GROUP_ERROR,
    MOVES,
    NO_GRAVITY,
    RESTITUTIONS,
    Device,
    Shaker,
    carried,
    moved,
    value_in,
)
from vireport.physics.energy import (
    Conversion,
    Dielectric,
    ElectricalCycle,
    Fitting,
    Membrane,
    Voltages,
    contact_cosine,
    conversion,
    conversion_of_word,
    cycle_of,
    deflection,
    energy_gained,
    fitting,
    generated_voltage,
    voltages,
)
from vireport.physics.flight import Flight
from vireport.physics.forcing import (
    SINE,
    Harmonic,
    Wave,
    force_rate,
    peaks,
    unaccelerated,
    unaccelerated_by,
    wave,
    with_harmonic,
)
from vireport.physics.groups import Groups, Restitutions, SpeedLaw, by_wall, each, stated
from vireport.physics.numbers import (
    ARRAYS,
    DIGITS,
    FLOATS,
    FUNCTION,
    IMAGINARY_STEP,
    ROUNDED,
    UNIT,
    DecimalOps,
    DoubleOps,
    Rounded,
    infinite_where_undefined,
    magnitude,
    wrapped,
)
from vireport.physics.voltage_bounds import voltage_bounds
from vireport.physics.word import Word, word_name

if TYPE_CHECKING:
    from vireport.physics.cubics import Cubics
else:
    __getattr__ = deferred(__name__, "cubics")

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
    "IMAGINARY_STEP",
    "MOVES",
    "NO_GRAVITY",
    "RESTITUTIONS",
    "ROUNDED",
    "SINE",
    "SMALLEST_RESTITUTION",
    "UNIT",
    "Affine",
    "Conversion",
    "Cubics",
    "DecimalOps",
    "Device",
    "Dielectric",
    "DoubleOps",
    "ElectricalCycle",
    "Fitting",
    "Flight",
    "Groups",
    "Harmonic",
    "Membrane",
    "Restitutions",
    "Rounded",
    "Shaker",
    "SpeedLaw",
    "Voltages",
    "Wave",
    "Word",
    "between",
    "by_wall",
    "carried",
    "contact_cosine",
    "contacts",
    "conversion",
    "conversion_of_word",
    "cycle_of",
    "damping_number",
    "deflection",
    "each",
    "energy_gained",
    "fitting",
    "flight",
    "force_rate",
    "generated_voltage",
    "infinite_where_undefined",
    "law_of",
    "magnitude",
    "moved",
    "peaks",
    "stated",
    "unaccelerated",
    "unaccelerated_by",
    "value_in",
    "voltage_bounds",
    "voltages",
    "wave",
    "with_harmonic",
    "word_name",
    "wrapped",
]
