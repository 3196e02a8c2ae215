"""Names, symbols and units that the verdict and the report share."""

from __future__ import annotations

from dataclasses import dataclass

from vireport.analysis.design import StableInterval
from vireport.physics.device import Parameter
from vireport.study.study import Study
from vireport.text.formatting import significant

SWEEP_END = "end of the sweep"
"""What ends a stable range that no critical point ends."""

KINDS = {
    "period_doubling": "period doubling",
    "fold": "fold",
    "pitchfork": "pitchfork",
    "node_focus": "node to focus",
    "grazing": "grazing",
}
"""Kinds of critical points, for the reader."""


@dataclass(frozen=True, slots=True)
class Swept:
    """How a parameter that can be swept is called.

    Attributes
    ----------
    name, symbol, unit : str
    """

    name: str
    symbol: str
    unit: str

    def value(self, value: float, digits: int = 6) -> str:
        """Print a value with its unit."""
        return self.with_unit(significant(value, digits))

    def with_unit(self, number: str) -> str:
        """Put the unit behind a printed number."""
        return f"{number}°" if self.unit == "°" else f"{number} {self.unit}"


SWEPT: dict[Parameter, Swept] = {
    "length_m": Swept("length", "s", "m"),
    "amplitude_n": Swept("force amplitude", "F", "N"),
    "frequency_hz": Swept("frequency", "f", "Hz"),
    "inclination_deg": Swept("inclination", "β", "°"),
}


def range_text(part: StableInterval, digits: int = 6) -> str:
    """Print a stable range as an inequality, strict at a critical point."""
    swept = SWEPT[part.parameter]
    low, high = ("≤" if reason == SWEEP_END else "<" for reason in (part.start_reason, part.end_reason))
    return f"{swept.value(part.start, digits)} {low} {swept.symbol} {high} {swept.value(part.end, digits)}"


def kind_of(study: Study, parameter: Parameter, label: str) -> str:
    """What kind of point a label stands for where a parameter is varied; the label if that is not known."""
    if study.design is not None:
        for margin in study.design.margins:
            if (margin.parameter, margin.label) == (parameter, label):
                return KINDS[margin.kind]
    for point in study.solution.critical_points if study.solution else ():
        if point.label == label:
            return KINDS[point.kind]
    return label


def capital(text: str) -> str:
    """Begin with a capital letter, unless with the path of a key; leave the rest alone."""
    first = text.partition(" ")[0]
    return text if "_" in first else text[:1].upper() + text[1:]
