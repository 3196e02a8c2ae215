"""The four inputs of a device that can be swept, varied, and measured margins in."""

from __future__ import annotations

from enum import StrEnum

from vireport.text import significant

# The dimensionless groups are products of up to six of the quantities, e.g. d = s M omega^2/(pi^2 F), and the
# theory squares and cubes them. With every quantity in this range those products stay clear of 1e-308 and
# 1e308, where double precision ends; the range itself is wider than that of anything built, from MEMS to wave
# power.
SMALLEST, LARGEST = 1e-15, 1e15


class Parameter(StrEnum):
    """An input that can be swept; the value is its key in a scenario.

    Attributes
    ----------
    path : str
        Where it stands in a scenario.
    quantity, symbol, unit : str
        Name for the reader, the paper's symbol, and the symbol of the unit.
    limits : tuple of float
        The smallest and the largest value that is allowed.
    """

    path: str
    quantity: str
    symbol: str
    unit: str
    limits: tuple[float, float]

    def __new__(
        cls,
        key: str,
        path: str = "",
        quantity: str = "",
        symbol: str = "",
        unit: str = "",
        limits: tuple[float, float] = (SMALLEST, LARGEST),
    ) -> Parameter:
        """Make the member whose value is `key`."""
        member = str.__new__(cls, key)
        member._value_ = key
        member.path, member.quantity, member.symbol, member.unit = path, quantity, symbol, unit
        member.limits = limits
        return member

    LENGTH = "length_m", "device.length_m", "length", "s", "m"
    AMPLITUDE = "amplitude_n", "excitation.amplitude_n", "force amplitude", "F", "N"
    FREQUENCY = "frequency_hz", "excitation.frequency_hz", "frequency", "f", "Hz"
    INCLINATION = "inclination_deg", "inclination_deg", "inclination", "β", "°", (0.0, 90.0)

    def show(self, value: float, digits: int = 6) -> str:
        """Print a value of the parameter with its unit."""
        return self.with_unit(significant(value, digits))

    def with_unit(self, number: str) -> str:
        """Put the unit behind a printed number."""
        return f"{number}°" if self is Parameter.INCLINATION else f"{number} {self.unit}"
