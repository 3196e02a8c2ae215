"""The four inputs of a device that can be swept, varied, and measured margins in."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from vireport.text import significant


class Parameter(StrEnum):
    """An input that can be swept; the value is its key in a scenario."""

    LENGTH = "length_m"
    AMPLITUDE = "amplitude_n"
    FREQUENCY = "frequency_hz"
    INCLINATION = "inclination_deg"

    @property
    def path(self) -> str:
        """Where it stands in a scenario."""
        return _ABOUT[self].path

    @property
    def quantity(self) -> str:
        """Name for the reader."""
        return _ABOUT[self].quantity

    @property
    def symbol(self) -> str:
        """The paper's symbol."""
        return _ABOUT[self].symbol

    @property
    def unit(self) -> str:
        """Symbol of the unit."""
        return _ABOUT[self].unit

    def show(self, value: float, digits: int = 6) -> str:
        """Print a value of the parameter with its unit."""
        return self.with_unit(significant(value, digits))

    def with_unit(self, number: str) -> str:
        """Put the unit behind a printed number."""
        return f"{number}°" if self is Parameter.INCLINATION else f"{number} {self.unit}"


class _About(NamedTuple):
    path: str
    quantity: str
    symbol: str
    unit: str


_ABOUT = {
    Parameter.LENGTH: _About("device.length_m", "length", "s", "m"),
    Parameter.AMPLITUDE: _About("excitation.amplitude_n", "force amplitude", "F", "N"),
    Parameter.FREQUENCY: _About("excitation.frequency_hz", "frequency", "f", "Hz"),
    Parameter.INCLINATION: _About("inclination_deg", "inclination", "β", "°"),
}
