"""The inputs of a device: those that can be swept, and those that a design point has margins in."""

from __future__ import annotations

from enum import StrEnum
from typing import Self

from vireport.text.formatting import OF_A_MODEL, Exactness, rounded_text, stated_text

# The dimensionless groups are products of up to six of the quantities, e.g. d = s M omega^2/(pi^2 F), and the
# theory squares and cubes them. With every quantity in this range those products stay clear of 1e-308 and
# 1e308, where double precision ends; the range itself is wider than that of anything built, from MEMS to wave
# power.
SMALLEST, LARGEST = 1e-15, 1e15

LARGEST_RESTITUTION = 1 - 1e-6
"""Largest restitution of a sweep or margin: beyond it motions draw together as 1 - r, and are not resolved."""


class Named:
    """A quantity with a name, a symbol and a unit, and the one form of printing it in each kind of place."""

    quantity: str
    symbol: str
    unit: str

    @property
    def label(self) -> str:
        """The name with symbol and unit, for an axis of a figure."""
        return f"{self.quantity} {self.symbol} [{self.unit or '–'}]"

    @property
    def head(self) -> str:
        """The name with the unit, if there is one, for a column of a table."""
        return f"{self.quantity} [{self.unit}]" if self.unit else self.quantity

    def with_unit(self, number: str) -> str:
        """Put the unit behind a printed number."""
        return f"{number}°" if self.unit == "°" else f"{number} {self.unit}".rstrip()

    def show(self, value: float, error: float | Exactness = OF_A_MODEL) -> str:
        """Print a value that a model gives, with its unit."""
        return self.with_unit(rounded_text(value, error))

    def stated(self, value: float) -> str:
        """Print a value that a scenario states, with its unit."""
        return self.with_unit(stated_text(value))

    def place(self, value: float, error: float | Exactness | None = None) -> str:
        """Print a place, as s = 0.5 m: a value that a scenario states or, with an error, a value of a model."""
        return f"{self.symbol} = {self.stated(value) if error is None else self.show(value, error)}"

    def signed(self, distance: float, error: float | Exactness = OF_A_MODEL) -> str:
        """Print a distance with its sign and unit."""
        return f"{'+' if distance > 0 else ''}{self.show(distance, error)}"


class ScalarInput(Named, StrEnum):
    """An input of a device; the value is its key in a scenario.

    Attributes
    ----------
    path : str
        Path of its key in a scenario.
    quantity, symbol, unit : str
        Name for the reader, the paper's symbol, and the symbol of the unit.
    limits : tuple of float
        The smallest and the largest value that is allowed.
    """

    path: str
    limits: tuple[float, float]

    def __new__(
        cls,
        key: str,
        path: str = "",
        quantity: str = "",
        symbol: str = "",
        unit: str = "",
        limits: tuple[float, float] = (SMALLEST, LARGEST),
    ) -> Self:
        """Make the member whose value is `key`."""
        member = str.__new__(cls, key)
        member._value_ = key
        member.path, member.quantity, member.symbol, member.unit = path, quantity, symbol, unit
        member.limits = limits
        return member

    @property
    def marked(self) -> str:
        """The symbol with the marks of the words of reports."""
        base, _, index = self.symbol.partition("_")
        return f"*{base}*_{index}" if index else f"*{base}*"


_LENGTH = "length_m", "device.length_m", "length", "s", "m"
_AMPLITUDE = "amplitude_n", "excitation.amplitude_n", "force amplitude", "F", "N"
_FREQUENCY = "frequency_hz", "excitation.frequency_hz", "frequency", "f", "Hz"
_INCLINATION = "inclination_deg", "inclination_deg", "inclination", "β", "°", (0.0, 90.0)


_RESTITUTION = "restitution", "device.restitution", "restitution", "r", "", (0.0, LARGEST_RESTITUTION)
_RESTITUTION_BOTTOM = (
    "restitution_bottom",
    "device.restitution_bottom",
    "restitution at the bottom",
    "r_bottom",
    "",
    (0.0, LARGEST_RESTITUTION),
)
_RESTITUTION_TOP = (
    "restitution_top",
    "device.restitution_top",
    "restitution at the top",
    "r_top",
    "",
    (0.0, LARGEST_RESTITUTION),
)


class Parameter(ScalarInput):
    """An input that can be swept: one of `DRIVING`, or a restitution.

    `RESTITUTION` moves that of both membranes together; the other two restitutions belong to one membrane each.
    """

    LENGTH = _LENGTH
    AMPLITUDE = _AMPLITUDE
    FREQUENCY = _FREQUENCY
    INCLINATION = _INCLINATION
    RESTITUTION = _RESTITUTION
    RESTITUTION_BOTTOM = _RESTITUTION_BOTTOM
    RESTITUTION_TOP = _RESTITUTION_TOP

    @property
    def bounces(self) -> bool:
        """Whether the parameter is a restitution, which leaves the groups d and gbar as they are."""
        return self not in DRIVING

    @property
    def moves_d(self) -> bool:
        """Whether the group d varies with the parameter; motions are then ordered and drawn by d."""
        return self in (Parameter.LENGTH, Parameter.AMPLITUDE, Parameter.FREQUENCY)

    @property
    def keeps_symmetry(self) -> bool:
        """Whether a horizontal capsule that is its own mirror image stays so where the parameter varies."""
        return self not in (Parameter.INCLINATION, Parameter.RESTITUTION_BOTTOM, Parameter.RESTITUTION_TOP)


DRIVING = Parameter.LENGTH, Parameter.AMPLITUDE, Parameter.FREQUENCY, Parameter.INCLINATION
"""The inputs by which a sweep moves the groups d and gbar."""


class DesignInput(ScalarInput):
    """An input that a design point has margins in: one that can be swept, the capsule's mass, or a restitution.

    `RESTITUTION` moves that of both membranes together; the other two restitutions belong to one membrane each.
    """

    LENGTH = _LENGTH
    AMPLITUDE = _AMPLITUDE
    CAPSULE_MASS = "capsule_mass_kg", "device.capsule_mass_kg", "capsule mass", "M", "kg"
    FREQUENCY = _FREQUENCY
    INCLINATION = _INCLINATION
    RESTITUTION = _RESTITUTION
    RESTITUTION_BOTTOM = _RESTITUTION_BOTTOM
    RESTITUTION_TOP = _RESTITUTION_TOP

    @property
    def sweepable(self) -> Parameter | None:
        """The input as a parameter of a sweep; None where it cannot be swept."""
        return next((parameter for parameter in Parameter if parameter.value == self.value), None)
