"""What can be compared of one scenario: motions, critical points, stable ranges, margins and voltages.

All is taken from the data of results.json, so that a study and the results of an earlier run are the same here. A
place along the sweep is given in the swept parameter and in d, which scenarios with different sweeps share.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Literal

from vireport.motions import Event, Stability
from vireport.physics import Device
from vireport.scenario import DesignInput, Parameter, ScalarInput

SAMPLED = 1e-5
"""Relative difference up to which extremes of a curve are the same: they are taken of its samples."""

SAME_INPUT = 1e-12
"""Relative difference up to which a value of the scenario is the same: it is read from a text, and only rounding is
forgiven."""

NOT_COMPARED = ("schema_version", "title")
"""Keys of a scenario that have no part in its results."""

SAME_VOLTAGE = 1e-9
"""Relative difference up to which two motions, such as mirror images, have one voltage."""

NO_SWEEP, NO_DESIGN, NO_MASS = "no sweep", "no design point", "device.ball_mass_kg is not given"
NO_STABLE, HELD = "no stable 1:1 motion", "the sweep holds d"

Axis = ScalarInput | Literal["d"]
"""What places are given in."""


class Group(StrEnum):
    """Kinds of what is compared, what matters most to a design first."""

    SCENARIO = "scenario"
    REQUIREMENT = "requirement"
    DESIGN_POINT = "design point"
    STABLE_RANGE = "stable range"
    MARGIN = "margin"
    VOLTAGE = "voltage"
    CRITICAL_POINT = "critical point"
    ALERT = "alert"


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number that scenarios can have.

    Attributes
    ----------
    group : Group
    subject : str
        What it is, in words.
    unit : str
        "1" where it has none.
    axis : ScalarInput, "d" or None
        Along which it is a place, or a distance.
    symbol : str
        What stands for the number, or "".
    missing : str
        What is said of scenarios that do not have it, before their names.
    family : str
        Of the motion that a margin's critical point is of, where the subject does not say it.
    tolerance : float
        Relative difference that is none, whatever is asked for.
    """

    group: Group
    subject: str
    unit: str
    axis: Axis | None = None
    symbol: str = ""
    missing: str = ""
    family: str = ""
    tolerance: float = 0.0

    @property
    def name(self) -> str:
        """What it is, with the symbol that tells it from the same in another unit."""
        return f"{self.subject}, {self.symbol}" if self.symbol else self.subject


@dataclass(frozen=True, slots=True)
class Entry:
    """A quantity of one scenario.

    Attributes
    ----------
    value : float or None
    note : str
        Why there is none, or a remark.
    finding : bool
        Whether that there is none says something of the device, and not only of what was asked for.
    comparable : bool
        Whether the scenario could have it: False where its sweep is of something else.
    bound : float
        Error bound of the value.
    scale : float
        Size that a relative tolerance is a share of, where that is larger than the value's.
    """

    value: float | None
    note: str = ""
    finding: bool = False
    comparable: bool = True
    bound: float = 0.0
    scale: float = 0.0


Items = Iterator[tuple[Quantity, Entry]]


@dataclass(frozen=True, eq=False)
class Quantities:
    """The quantities of one scenario.

    Attributes
    ----------
    device : Device
    swept : Parameter or None
    start : float
        Of the sweep.
    stable_at_design : bool or None
        Whether a motion at the design point is stable; None where there is no design point.
    entries : mapping of Quantity to Entry
    """

    device: Device
    swept: Parameter | None
    start: float
    stable_at_design: bool | None
    entries: Mapping[Quantity, Entry]

    def entry(self, quantity: Quantity) -> Entry:
        """The quantity, or why there is none."""
        return self.entries.get(quantity) or self._absence(quantity.group, quantity.axis)

    def _absence(self, group: Group, axis: Axis | None) -> Entry:
        others = any(quantity.group is group and quantity.axis == axis for quantity in self.entries)
        if group is Group.MARGIN and self.stable_at_design is None:
            return Entry(None, NO_DESIGN)
        if group is Group.MARGIN and others:
            return Entry(None, "does not end the stable range")
        if self.swept is not None and axis not in (self.swept, "d") and group is not Group.MARGIN:
            return Entry(None, f"sweeps the {self.swept.quantity}", comparable=False)
        if self.swept is Parameter.INCLINATION and axis == "d" and group is not Group.CRITICAL_POINT:
            return Entry(None, HELD, comparable=False)
        if group is Group.MARGIN:
            stable = "no critical point ends the stable range"
            return Entry(None, stable if self.stable_at_design else f"{NO_STABLE} at the design point")
        if self.swept is None:
            return Entry(None, NO_SWEEP)
        if group is Group.CRITICAL_POINT:
            return Entry(None, "none in the sweep", finding=True)
        return Entry(None, "no further stable range" if others else NO_STABLE, finding=True)


def quantities_of(members: Mapping[str, Mapping[str, Any]]) -> dict[str, Quantities]:
    """Take the quantities from the results of several scenarios, whose stable ranges have numbers if any has several.

    Parameters
    ----------
    members : mapping of str to mapping
        Results as results.json has them, by the names of the scenarios.

    Raises
    ------
    KeyError, TypeError, ValueError
        Where something is missing, or is not what results.json has.
    """
    several = any(len(results["stable_range"]) > 1 for results in members.values())
    return {name: _quantities(results, several) for name, results in members.items()}


def _quantities(results: Mapping[str, Any], several: bool) -> Quantities:
    scenario, design = results["scenario"], results["design_point"]
    sweep = scenario.get("sweep")
    swept, start = (Parameter(sweep["parameter"]), float(sweep["from"])) if sweep else (None, 0.0)
    device = _device(scenario)
    items = [
        _stable_motions(design),
        *(_critical_points(results["critical_points"], swept) if swept else ()),
        *(_stable_ranges(results["stable_range"], swept, device, several) if swept else ()),
        # Of two motions that end in one way on one side, the nearer counts: it comes last.
        *(reversed(list(_margins(design["margins"], device, swept))) if design is not None else ()),
        *_voltages(results, swept),
    ]
    return Quantities(device, swept, start, None if design is None else any(_stable(design)), dict(items))


def _stable_motions(design: Mapping[str, Any] | None) -> tuple[Quantity, Entry]:
    """How many stable motions there are at the design point."""
    subject = "stable 1:1 motions at the design point"
    quantity = Quantity(Group.DESIGN_POINT, subject, "1", missing="none in")
    if design is None:
        return quantity, Entry(None, NO_DESIGN)
    words = [word for word, stable in zip(design["stability"], _stable(design), strict=True) if stable]
    if not words:
        return quantity, Entry(None, NO_STABLE, finding=True)
    return quantity, Entry(float(len(words)), " and ".join(dict.fromkeys(words)))


def _critical_points(points: Sequence[Mapping[str, Any]], swept: Parameter) -> Items:
    for point in points:
        kind, value, d = Event(point["kind"]).words, float(point["sweep_value"]), float(point["d"])
        bound = float(point["error_bound"])
        held = HELD if swept is Parameter.INCLINATION else ""
        # d goes with the square of a frequency, and with the first power of a length or of the inverse of a force.
        in_d = Entry(d, held, bound=2 * bound / abs(value) * d if value else 0.0)
        along: tuple[tuple[Axis, Entry], ...] = ((swept, Entry(value, bound=bound)), ("d", in_d))
        for axis, entry in along:
            subject = f"{point['label']}, {kind} of the {point['family']} motion"
            yield _place(Group.CRITICAL_POINT, subject, axis, "none in the sweep of"), entry


def _stable_ranges(parts: Sequence[Mapping[str, Any]], swept: Parameter, device: Device, several: bool) -> Items:
    def in_d(value: float, note: str, bound: float) -> tuple[float, str, float]:
        d = _d(device, swept, value)
        return d, note, 2 * bound / abs(value) * d if value else 0.0

    ranges = [[_end(part, end) for end in ("from", "to")] for part in parts]
    places: list[tuple[Axis, list[list[tuple[float, str, float]]]]] = [(swept, ranges)]
    if swept is not Parameter.INCLINATION:
        places.append(("d", [[in_d(*end) for end in ends] for ends in ranges]))
    for axis, along in places:
        for number, ends in enumerate(sorted(map(sorted, along)), 1):
            which, missing = "stable range", "no stable range in"
            if several:
                which, missing = f"stable range {number}", "no such stable range in"
            for word, (value, note, bound) in zip(("from", "to"), ends, strict=True):
                yield _place(Group.STABLE_RANGE, f"{which} {word}", axis, missing), Entry(value, note, bound=bound)


def _place(group: Group, subject: str, axis: Axis, missing: str) -> Quantity:
    unit, symbol = ("1", "d") if axis == "d" else (axis.unit, axis.symbol)
    return Quantity(group, subject, unit, axis, symbol, missing)


def _end(part: Mapping[str, Any], end: str) -> tuple[float, str, float]:
    """Value, reason and error bound of one end of a stable range."""
    return float(part[end]), str(part[f"{end}_reason"]), float(part.get(f"{end}_error_bound") or 0.0)


def _margins(margins: Sequence[Mapping[str, Any]], device: Device, swept: Parameter | None) -> Items:
    """Distances to the critical points that end the stable motions of the design point, in per cent, nearest first."""
    for margin in margins:
        varied, kind = DesignInput(margin["parameter"]), Event(margin["kind"]).words
        critical = float(margin["sweep_value"])
        design = critical - float(margin["distance"])
        if not margin["ends_stability"] or margin["relative"] is None:
            continue
        shares: list[tuple[Axis, float]] = [(varied, float(margin["relative"]))]
        if swept is not None and varied.sweepable is swept and swept is not Parameter.INCLINATION:
            d = _d(device, swept, design)
            shares.append(("d", (_d(device, swept, critical) - d) / d))
        for axis, share in shares:
            symbol, side = "d" if axis == "d" else axis.symbol, "below" if share < 0 else "above"
            subject = f"margin from the design point to the {kind} {side}, in {symbol}"
            quantity = Quantity(Group.MARGIN, subject, "%", axis, family=margin["family"])
            # The critical value and the design value may both be off; what is compared is their ratio, less 1.
            bound, ratio = 100 * float(margin["error_bound"]) / abs(design), abs(critical / design)
            yield quantity, Entry(100 * share, bound=bound, scale=200 * ratio)


def _voltages(results: Mapping[str, Any], swept: Parameter | None) -> Items:
    evaluated = results["scenario"]["device"].get("ball_mass_kg") is not None
    subject, missing = "U_ave of the stable motion at the design point", "no stable motion there in"
    yield Quantity(Group.VOLTAGE, subject, "V", missing=missing), _design_voltage(results["design_point"], evaluated)
    volts = list(_stable_voltages(results["branches"])) if evaluated else []
    for word, choose in (("highest", max), ("lowest", min)):
        entry = Entry(None, f"{NO_STABLE} in the sweep", finding=True)
        if swept is None or not evaluated:
            entry = Entry(None, NO_SWEEP if swept is None else NO_MASS)
        elif volts:
            entry = Entry(choose(volts))
        subject, missing = f"{word} U_ave over the stable range", "no stable motion in"
        yield Quantity(Group.VOLTAGE, subject, "V", missing=missing, tolerance=SAMPLED), entry


def _design_voltage(design: Mapping[str, Any] | None, evaluated: bool) -> Entry:
    if design is None or not evaluated:
        return Entry(None, NO_DESIGN if design is None else NO_MASS)
    bounds = design["error_bounds"]["u_ave_v"]
    rows = zip(design["u_ave_v"], bounds, _stable(design), strict=True)
    volts = [(float(u), float(bound or 0.0)) for u, bound, stable in rows if stable]
    if not volts:
        return Entry(None, f"{NO_STABLE} at the design point", finding=True)
    (lowest, bound), highest = min(volts), max(volts)[0]
    several = highest - lowest > SAME_VOLTAGE * highest
    return Entry(lowest, f"the least of {len(volts)}" if several else "", bound=bound)


def _device(scenario: Mapping[str, Any]) -> Device:
    device, excitation = scenario["device"], scenario["excitation"]
    return Device(
        capsule_mass_kg=device["capsule_mass_kg"],
        restitution=device["restitution"],
        gravity_m_s2=scenario["gravity_m_s2"],
        length_m=device.get("length_m"),
        amplitude_n=excitation.get("amplitude_n"),
        frequency_hz=excitation.get("frequency_hz"),
        inclination_deg=scenario.get("inclination_deg"),
        period_ratio=scenario["period_ratio"],
    )


def _stable(motions: Mapping[str, Any]) -> list[bool]:
    """Which motions of a branch or of a design point are stable and admissible."""
    rows = zip(motions["stability"], motions["admissible"], strict=True)
    return [bool(admissible) and Stability(word).attracts for word, admissible in rows]


def _stable_voltages(branches: Iterable[Mapping[str, Any]]) -> Iterator[float]:
    """U_ave of the stable motions of branches, and of the critical points beside them."""
    for branch in branches:
        stable = _stable(branch)
        for k, (u, label) in enumerate(zip(branch["u_ave_v"], branch["critical_point"], strict=True)):
            if stable[k] or (label and any(stable[max(k - 1, 0) : k + 2])):
                yield float(u)


def _d(device: Device, parameter: Parameter, value: float) -> float:
    return float(device.groups(parameter, value)[0])


@dataclass(frozen=True, slots=True)
class Axes:
    """In what places are compared: along the first ones always, along the others where several scenarios have them."""

    always: tuple[Axis, ...]
    shared: tuple[Axis, ...] = ()


def axes_of(members: Iterable[Quantities], same: float) -> Axes:
    """Choose in what the places of several scenarios are compared.

    A swept parameter, where no scenario sweeps another, with d beside it only where d is not the same multiple of it
    in all of them, to a relative difference `same`. Otherwise d, and the parameters that some share. Without any sweep
    there are only margins, in all inputs.
    """
    swept = [(member.swept, member) for member in members if member.swept is not None]
    parameters = [parameter for parameter, _ in swept]
    if not swept:
        return Axes(tuple(DesignInput))
    if len(set(parameters)) > 1:
        return Axes(("d",), tuple(parameter for parameter in Parameter if parameters.count(parameter) > 1))
    parameter, at = parameters[0], swept[0][1].start
    if parameter is Parameter.INCLINATION:
        return Axes((parameter,))
    multiples = [_d(member.device, parameter, at) for _, member in swept]
    return Axes((parameter,), () if max(multiples) - min(multiples) <= same * max(multiples) else ("d",))


def settings_of(scenario: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """The values of a scenario by their dotted paths; what is not given, or has no part in results, is left out."""
    values: dict[str, Any] = {}
    for key, value in scenario.items():
        if isinstance(value, list) and value and isinstance(value[0], Mapping):
            value = {str(k): row for k, row in enumerate(value)}
        if isinstance(value, Mapping):
            values |= settings_of(value, f"{path}{key}.")
        elif value is not None and f"{path}{key}" not in NOT_COMPARED:
            values[f"{path}{key}"] = value
    return values


def same_setting(value: Any, other: Any) -> bool:
    """Whether two values of a scenario are the same but for rounding."""
    if any(isinstance(x, bool) or not isinstance(x, int | float) for x in (value, other)):
        return bool(value == other)
    return bool(abs(other - value) <= SAME_INPUT * max(abs(value), abs(other)))
