"""What each table and sentence of a report should show, from results.json and the definitions.

A table of the report is held by a row of `TABLES`: its caption and a function that gives, of each row, what should
stand under each head. One that has only words is named in `WORDS_ONLY`. A table that is in neither fails the tests.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cached_property
from math import floor, hypot, inf, log10, pi, sqrt
from typing import Any

from definitions import STANDARD_GRAVITY, SWEPT, SYMBOLS, Device, contact_time, device_of, mean
from shown import ANYTHING, Amount, Below, Bound, Row, Said

WORDS_OF = {
    "period_doubling": "period doubling", "fold": "fold", "pitchfork": "pitchfork", "grazing": "grazing",
    "node_focus": "node to focus",
}  # fmt: skip
UNBOUNDED = (0.0, 90.0, 0.99)
"""Ends of inputs beyond which no value is allowed, or looked at."""


class Results:
    """The data of results.json, and the device of its scenario."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.data, self.scenario = data, data["scenario"]
        self.device: Device = device_of(data["scenario"])
        self.design, self.points = data["design_point"], data["critical_points"]
        self.sweep = self.scenario["sweep"]
        self.parameter: str = self.sweep["parameter"] if self.sweep else "length_m"

    @property
    def symbol(self) -> str:
        return SYMBOLS[self.parameter][1]

    @property
    def unit(self) -> str:
        return SYMBOLS[self.parameter][2]

    @cached_property
    def stable(self) -> list[int]:
        """Rows of the stable motions at the design point."""
        x = self.design
        if x is None:
            return []
        return [k for k, word in enumerate(x["stability"]) if x["admissible"][k] and word.startswith("stable")]

    def speeds(self, velocities: tuple[float, float], value: float) -> tuple[float, float]:
        """Impact speeds at bottom and top in m/s, at a value of the swept parameter."""
        unit = self.device.at(self.parameter, value).velocity_unit
        return unit * velocities[0], -unit * velocities[1]

    @cached_property
    def design_speeds(self) -> list[tuple[float, float]]:
        x = self.design
        return [self.speeds((x["velocity_bottom"][k], x["velocity_top"][k]), x["sweep_value"][k]) for k in self.stable]

    @cached_property
    def contact_share(self) -> float:
        """Longest contact of stable motions over the forcing period; 0 without a ball mass, and without restitution."""
        device = self.device
        if device.ball_mass_kg is None or not device.restitution:
            return 0.0
        here = [(self.design["sweep_value"][0], speeds) for speeds in self.design_speeds]
        rows = here or [
            (branch["sweep_value"][k], self.speeds((bottom, top), branch["sweep_value"][k]))
            for branch in self.data["branches"]
            for k, (bottom, top) in enumerate(zip(branch["velocity_bottom"], branch["velocity_top"], strict=True))
            if branch["admissible"][k] and branch["stability"][k].startswith("stable")
        ]
        h, stiffness = device.membrane["exponent"], device.membrane["stiffness"]
        unit, ends = (
            (device.reduced_kg / stiffness) ** (1 / (h + 1)),
            (device.restitution_bottom, device.restitution_top),
        )
        return max(
            (
                unit * contact_time(h, r) * speed ** ((1 - h) / (1 + h)) * device.at(self.parameter, value).frequency_hz
                for value, speeds in rows
                for r, speed in zip(ends, speeds, strict=True)
                if speed > 0
            ),
            default=0.0,
        )

    def ends(self) -> Iterator[tuple[str, float, float, tuple[float, float]]]:
        """The ends of the stable ranges: why, where, d, and the velocities of the motions there."""
        for part in self.data["stable_range"]:
            for end in ("from", "to"):
                value, why = part[end], part[f"{end}_reason"]
                for branch in self.data["branches"]:
                    if branch["mirror_of"] is None:
                        for k, at in enumerate(branch["sweep_value"]):
                            if at == value and self._stable_beside(branch, k, part):
                                yield why, value, branch["d"][k], (
                                    branch["velocity_bottom"][k], branch["velocity_top"][k],
                                )  # fmt: skip

    @staticmethod
    def _stable_beside(branch: dict[str, Any], row: int, part: dict[str, Any]) -> bool:
        beside = [k for k in (row - 1, row + 1) if 0 <= k < len(branch["d"])]
        return any(
            branch["stability"][k].startswith("stable")
            and branch["admissible"][k]
            and part["from"] <= branch["sweep_value"][k] <= part["to"]
            for k in beside
        )

    def places(self) -> list[tuple[str, float, float, float, float]]:
        """Where voltages are given: what it is, the swept parameter, d and both impact speeds."""
        x = self.design
        rows = [
            ("Design point", x["sweep_value"][k], x["d"][k], *speeds)
            for k, speeds in zip(self.stable, self.design_speeds, strict=True)
        ]
        for why, value, d, velocities in self.ends():
            name = "End of the sweep" if why == "end of the sweep" else f"{why}, end of the stable range"
            rows.append((name, value, d, *self.speeds(velocities, value)))
        return rows

    @cached_property
    def ending(self) -> list[dict[str, Any]]:
        """The margins at which stable motion ends or another takes over, the nearest first."""
        margins = [x for x in self.design["margins"] if x["ends_stability"] or x["taken_over"]] if self.design else []
        return sorted(margins, key=lambda margin: inf if margin["relative"] is None else abs(margin["relative"]))


def swept(x: Results, value: float, digits: int = 3, unit: bool = True) -> Amount:
    """A value of the swept parameter."""
    return in_input(x.parameter, value, digits, unit)


def in_input(parameter: str, value: float, digits: int = 3, unit: bool = True) -> Amount:
    return Amount(value, SYMBOLS[parameter][2] if unit else "", digits)


def number(value: float | None, digits: int = 3) -> Amount:
    return Amount(value, "", digits)


def percentage(fraction: float, digits: int = 2) -> Amount:
    return Amount(100 * fraction, "%", digits)


def compliant_end(x: Results, parameter: str, value: float) -> dict[str, Any] | None:
    """What the membranes' own stiffness makes of an end of stable motion; None where contacts are short."""
    ends = x.data["own_stiffness"]["ends"] if x.data["own_stiffness"] is not None else ()
    return next((end for end in ends if (end["parameter"], end["rigid"]) == (parameter, value)), None)


def gone(x: Results) -> bool:
    """Whether the motion at the design point is lost, or not stable, with the membranes' own stiffness."""
    own = x.data["own_stiffness"]
    if own is None or not own["at_design_point"]:
        return False
    of = own["motion"]
    return own["missing"] == "lost" if of is None else abs(of["trace"]) >= 1 + of["determinant"]


def model_digits(x: Results) -> int:
    """How many digits of a number what long contacts, soft membranes and neglected effects move leaves: 3 to 6.

    Three where nothing is known of that: as many as an error of a per cent leaves.
    """
    if not x.contact_share:
        return 3
    ends = x.data["own_stiffness"]["ends"] if x.data["own_stiffness"] is not None else ()
    effects = x.data["effects"]["rows"] if x.data["effects"] is not None else ()
    moved = [end["compliant"] / end["rigid"] - 1 for end in ends if end["compliant"] is not None]
    moved += [row["moved_relative"] for row in effects if row["moved_relative"] is not None]
    return min(max(1 - floor(log10(2 * max(4 * x.contact_share, *map(abs, moved), 5e-7))), 3), 3)


def digits_of(x: Results, parameter: str, value: float, most: int) -> int:
    """How many digits of a value are shown: of a critical point what is left, `most` at least of what is given."""
    return model_digits(x) if _critical(x, parameter, value) else most


def _critical(x: Results, parameter: str, value: float) -> bool:
    of_sweep = [point["sweep_value"] for point in x.points] if parameter == x.parameter else []
    around = [of["sweep_value"] for of in x.design["margins"] if of["parameter"] == parameter] if x.design else []
    beyond = [part.get(f"{end}_beyond_sweep") for part in x.data["stable_range"] for end in ("from", "to")]
    return value in of_sweep + around + [of["sweep_value"] for of in beyond if of is not None]


# Requirements: of each key what its value should be, in the unit of its limit.


def _worst(x: Results, of: Callable[[float, float], float], least: bool) -> float:
    return (min if least else max)(of(*speeds) for speeds in x.design_speeds)


def power_w(x: Results, bottom: float, top: float) -> float:
    """Both energies of a period over its time."""
    return (x.device.energy(bottom) + x.device.energy(top)) / x.device.period_s


def field(x: Results, *speeds: float) -> float:
    """U_imp over the thickness [V/m], the higher of both."""
    of = x.device.membrane
    return (max(map(x.device.gain, speeds)) + of["bias_voltage_v"]) / of["thickness_m"]


def breakdown(x: Results, *speeds: float) -> float:
    return field(x, *speeds) / x.device.membrane["breakdown_field_v_m"]


def efficiency(x: Results, *speeds: float) -> float:
    """Energy gained over energy lost at the impacts."""
    return sum(map(x.device.energy, speeds)) / x.device.lost(*speeds)


REQUIRED: dict[str, tuple[str, str, str, Callable[[Results], float]]] = {
    "u_ave_at_least_v": (
        "Uave", "V", "at least",
        lambda x: _worst(x, lambda *speeds: mean([x.device.gain(speed) for speed in speeds]), True),
    ),
    "u_bottom_top_difference_at_most_v": (
        "Difference of voltage between the ends", "V", "at most",
        lambda x: _worst(x, lambda bottom, top: abs(x.device.gain(bottom) - x.device.gain(top)), False),
    ),
    "deflection_at_most_m": (
        "Deflection", "m", "at most", lambda x: _worst(x, lambda *speeds: x.device.deflection(max(speeds)), False),
    ),
    "power_at_least_mw": (
        "Mean electrical power", "mW", "at least", lambda x: 1e3 * _worst(x, lambda *s: power_w(x, *s), True),
    ),
    "efficiency_at_most_percent": (
        "Electrical efficiency", "%", "at most", lambda x: 100 * _worst(x, lambda *s: efficiency(x, *s), False),
    ),
    "deflection_at_most_percent": (
        "Deflection over the membrane's radius", "%", "at most",
        lambda x: 100
        * _worst(x, lambda *s: x.device.deflection(max(s)) / x.device.membrane["active_radius_m"], False),
    ),
    "area_ratio_at_most": (
        "Area of a membrane over that when it is flat", "times", "at most",
        lambda x: _worst(x, lambda *s: sqrt(x.device.gain(max(s)) / x.device.membrane["bias_voltage_v"] + 1), False),
    ),
    "field_at_most_percent": (
        "Electric field over breakdown field", "%", "at most",
        lambda x: 100 * _worst(x, lambda *speeds: breakdown(x, *speeds), False),
    ),
    "yield_at_least_percent": (
        "Yield within the tolerances", "%", "at least",
        lambda x: 100.0 if x.data["tolerances"]["answer"] == "proved" else 100 * x.data["tolerances"]["yield"]["share"],
    ),
    "margin_any_percent": (
        "Margin to the end of stable motion", "%", "at least", lambda x: 100 * abs(x.ending[0]["relative"]),
    ),
    "margin_period_doubling_percent": (
        "Margin to period doubling", "%", "at least",
        lambda x: 100 * min(abs(of["relative"]) for of in x.ending if of["kind"] == "period_doubling"),
    ),
    "acceleration_at_most_g": (
        "Acceleration of the shaker", "g", "at most", lambda x: x.device.acceleration / STANDARD_GRAVITY,
    ),
    "stroke_at_most_m": ("Stroke of the shaker", "m", "at most", lambda x: x.device.stroke),
    "force_at_most_n": ("Force of the shaker", "N", "at most", lambda x: x.device.amplitude_n),
    "withstands_distortion_percent": (
        "Distortion withstood", "%", "at least",
        lambda x: min(of["percent"] for of in x.design["distortion"] if of["percent"] is not None),
    ),
    "margin_with_effects_percent": (
        "Margin with neglected effects", "%", "at least",
        lambda x: 100 * min(of["least_margin"] for of in x.data["effects"]["rows"] if of["least_margin"] is not None),
    ),
    "survives_shock_m_s": (
        "Shock withstood", "m/s", "at least", lambda x: x.data["disturbances"]["shock"]["least_jump_m_s"],
    ),
    "phase_jitter_at_most_deg": (
        "Spread of the phases", "deg", "at most", lambda x: x.data["disturbances"]["jitter"]["phase_deg"],
    ),
}  # fmt: skip


VOLTAGE_LIMITS = tuple(REQUIRED)[:8]
"""Requirements on voltage and energy."""


def of_unit(value: float | None, unit: str, digits: int = 3) -> Amount:
    """A number in the unit of a limit, mW among them."""
    return Amount(1e-3 * value, "W", digits) if unit == "mW" and value is not None else Amount(value, unit, digits)


def by_default(x: Results) -> dict[str, float]:
    """Limits that hold though the scenario gives none: no more energy than the impacts lose, where it is evaluated."""
    evaluated = bool(x.design_speeds) and x.scenario["device"]["membrane"]["thickness_m"] is not None
    given = x.scenario["requirements"]["efficiency_at_most_percent"]
    return {"efficiency_at_most_percent": 100.0} if evaluated and given is None else {}


def judged(x: Results) -> Iterator[tuple[str, str, str, float, float, float, bool]]:
    """Of each requirement key, title, unit, limit, value, margin and whether it is met."""
    for key, limit in (x.scenario["requirements"] | by_default(x)).items():
        if key in REQUIRED and limit is not None:
            title, unit, kind, of = REQUIRED[key]
            value = of(x)
            margin = value - limit if kind == "at least" else limit - value
            yield key, title, unit, limit, value, margin, margin >= 0


def requirements(x: Results) -> list[Row]:
    rows: dict[str, Row] = {}
    for key, title, unit, limit, value, margin, met in judged(x):
        rows[key] = {
            "Requirement": title,
            "Outcome": "✓ met" if met else "✗ NOT MET",
            "Limit": Said(f"{REQUIRED[key][2]} {{}}", of_unit(limit, unit)),
            "Value": Said("{}", of_unit(value, unit)),
            "Margin": Said("{}{}", "+" if margin >= 0 else "−", of_unit(abs(margin), unit, 3)),
            "In the scenario": "by default" if key in by_default(x) else "set by --set",
        }
    given = x.scenario["requirements"]
    if given["stable_from"] is not None:
        low, high = given["stable_from"], given["stable_to"]
        (part,) = [of for of in x.data["stable_range"] if of["from"] <= low and high <= of["to"]]
        sides = {"from": low - part["from"], "to": part["to"] - high}
        inside = [room for end, room in sides.items() if part[f"{end}_reason"] != "end of the sweep"]
        rows["stable_from"] = {
            "Requirement": "Stable 1:1 motion over the range",
            "Outcome": "✓ met",
            "Limit": Said("from {} to {}", number(low), swept(x, high)),
            "Value": Said("stable from {} to {}", number(part["from"]), swept(x, part["to"])),
            "Margin": Said("+{}", swept(x, min(inside), 3)),
            "In the scenario": "set by --set",
        }
    if given["crosscheck_passed"]:
        found = x.data["simulation"]
        largest, limit = max(found["velocity_difference"], found["phase_difference_rad"]), found["tolerance"]
        rows["crosscheck_passed"] = {
            "Requirement": "Simulation agrees",
            "Outcome": "✓ met" if found["passed"] else "✗ NOT MET",
            "Limit": ANYTHING,
            "Value": Said("largest difference {}", number(largest, 2)),
            "Margin": Said("+{}", number(limit - largest, 3)),
            "In the scenario": "set by --set",
        }
    return [rows[criterion["key"]] for criterion in x.data["requirements"]["criteria"]]


def remarks(x: Results) -> list[Row]:
    rows = []
    for criterion in x.data["requirements"]["criteria"]:
        if criterion["why"]:
            title = criterion["title"].replace("U_ave", "Uave")
            rows.append({"Requirement": title, "Remark": _remark(x, criterion["key"])})
    return rows


def _remark(x: Results, key: str) -> Any:
    if key in ("margin_any_percent", "margin_period_doubling_percent"):
        end = next(of for of in x.ending if key == "margin_any_percent" or of["kind"] == "period_doubling")
        parameter = end["parameter"]
        return Said(
            "{} at {} = {}", _name(end).capitalize().replace("doubling b", "doubling B"), SYMBOLS[parameter][1],
            Amount(end["sweep_value"], SYMBOLS[parameter][2], 3),
        )  # fmt: skip
    if key == "crosscheck_passed":
        found = x.data["simulation"]
        count = found["orbits_checked"]
        return Said("{} of {} stable motions found again", number(count - len(found["misses"])), number(count))
    return ANYTHING


# Margins and the design point.


def _name(point: dict[str, Any]) -> str:
    return f"{WORDS_OF[point['kind']]} {point['label'] or ''}".rstrip()


def _ended(x: Results, parameter: str, value: float) -> str:
    """What ends a range of an input: the critical point there, by label and kind."""
    for margin in x.design["margins"]:
        if margin["parameter"] == parameter and margin["sweep_value"] == value:
            return ", ".join(filter(None, (margin["label"], WORDS_OF[margin["kind"]])))
    return "its limit" if value in UNBOUNDED else "nothing"


def ranges_around(x: Results) -> list[Row]:
    rows = []
    alike = x.scenario["device"]["restitution_bottom"] is None
    for part in x.design["stable_range"]:
        parameter, ends = part["parameter"], (part["from"], part["to"])
        if alike and parameter in ("restitution_bottom", "restitution_top"):
            continue
        quantity, symbol, unit = SYMBOLS[parameter]
        at = getattr(x.device, parameter)
        name = f"{quantity[0].upper()}{quantity[1:]} {symbol}{f' [{unit}]' if unit else ''}"
        row = {"Input": name, "Design": number(at, 8)}
        for title, value, mark in zip(("From", "To"), ends, ("", " 2"), strict=True):
            room = (value - at) / at if at else None
            row[title] = number(value, digits_of(x, parameter, value, 3))
            row[f"ended by{mark}"] = _ended(x, parameter, value)
            row[f"room{mark}"] = (
                number(None) if room is None
                else Said("{}{}", "+" if room > 0 else "−" if room < 0 else "", percentage(abs(room)))
            )  # fmt: skip
        rows.append(row)
    return rows


def distortions(x: Results) -> list[Row]:
    digits = model_digits(x)
    return [
        {
            "Harmonic": number(found["order"]),
            "amplitude": "none" if found["kind"] is None else Amount(found["percent"], "%", digits),
            "phase": "—" if found["kind"] is None else Amount(found["phase_deg"], "deg", 3),
            "ends in": "—" if found["kind"] is None else WORDS_OF[found["kind"]],
        }
        for found in x.design["distortion"]
    ]


def what_is_left(x: Results) -> list[Row]:
    """The nearest end of stable motion and the margin to it: by itself, and with each effect that is left out."""
    of = x.data["effects"]
    parameter, end = of["parameter"], of["sweep_value"]
    at = getattr(x.device, parameter)
    unit, digits = f" [{SYMBOLS[parameter][2]}]" if SYMBOLS[parameter][2] else "", digits_of(x, parameter, end, 3)
    known: list[tuple[str, float | None, str | float]] = [("Rigid membranes", end, abs(end / at - 1))]
    for shift in of["rows"]:
        none = {True: "no end", False: "no stable motion", None: "not known: the ball stops on its way"}
        moved = shift["sweep_value"] is not None
        left = margin_left(x, shift) if moved else none[shift["stable"]]
        known.append((effect_of(x, shift), shift["sweep_value"], left))
    return [
        {
            "With": name,
            "Ends at": "—" if value is None else Amount(value, unit.strip(" []"), digits),
            "Margin left": left if isinstance(left, str) else Said(
                "{}{}", "−" if left < 0 else "", percentage(abs(left))
            ),
        }
        for name, value, left in known
    ]  # fmt: skip


def margin_left(x: Results, shift: dict[str, Any]) -> float:
    """How far the design is from an end that has moved, on the side on which it was."""
    of, value = x.data["effects"], shift["sweep_value"]
    if value is None:
        return inf if shift["stable"] else -inf
    at = own = getattr(x.device, of["parameter"])
    if shift["effect"] == of["parameter"]:  # the design is moved itself
        own *= 1 + shift["change"]
    return (1 - value / own) if of["sweep_value"] < at else (value / own - 1)


def effect_of(x: Results, shift: dict[str, Any]) -> str:
    other = "Capsule prescribed instead of free" if x.device.free else "Capsule free instead of prescribed"
    names = {"membrane_stiffness": "The membranes' own stiffness", "capsule": other}
    names["second_harmonic"] = "A second harmonic of 2 % in the force"
    names["restitution_exponent"] = "Restitution as the speed to the power −0.1"
    names["friction"] = "Friction of 0.05 between ball and capsule"
    for membrane in ("bottom", "top"):
        size = 100 * (shift["change"] or 0.0)
        names[f"restitution_{membrane}"] = f"Restitution at the {membrane} {'−' if size < 0 else ''}{abs(size):g} %"
    return names[shift["effect"]]


def motions_at_design(x: Results) -> list[Row]:
    of = x.design
    columns = {
        "q": "q", "φB": "phi_bottom_rad", "φT": "phi_top_rad", "ŻB": "velocity_bottom", "ŻT": "velocity_top",
        "Tr": "trace",
    }  # fmt: skip
    return [
        {
            "Motion": of["family"][k].capitalize(),
            "Type": of["stability"][k],
            "Admissible": "yes" if of["admissible"][k] else "no",
            **{title: number(of[key][k], model_digits(x)) for title, key in columns.items()},
            "Δ": number(of["trace"][k] ** 2 - 4 * x.device.determinant, model_digits(x)),
        }
        for k in range(len(of["q"]))
    ]


# Voltage and energy.


def voltages(x: Results) -> list[Row]:
    return [
        {
            "Stable motion": name,
            x.symbol: Amount(value, x.unit, digits_of(x, x.parameter, value, 8)),
            "d": number(d, model_digits(x)),
            "VB": Amount(bottom, "m/s", model_digits(x)),
            "VT": Amount(top, "m/s", model_digits(x)),
            "bottom": Amount(x.device.gain(bottom), "V", model_digits(x)),
            "top": Amount(x.device.gain(top), "V", model_digits(x)),
            "Uave": Amount(mean([x.device.gain(bottom), x.device.gain(top)]), "V", model_digits(x)),
            "δ": Amount(x.device.deflection(max(bottom, top)), "m", model_digits(x)),
        }
        for name, value, d, bottom, top in x.places()
    ]


def mass_effects(x: Results) -> list[Row]:
    _, _, _, bottom, top = x.places()[0]
    own = x.device.ball_mass_kg
    names = {"0.5 m": own / 2, "m, this scenario": own, "2 m": 2 * own}
    names["0.2 M, as in published code for this device"] = 0.2 * x.device.capsule_mass_kg
    rows = []
    for name, mass in names.items():
        device = x.device.at("ball_mass_kg", mass)
        depth = device.deflection(max(bottom, top))
        rows.append(
            {
                "Ball mass": name,
                "": Amount(1e3 * mass, "g", 3),
                "δ": Amount(depth, "m", model_digits(x)),
                "δ/Rc": number(depth / device.membrane["active_radius_m"], 3),
                "Uave": Amount(mean([device.gain(bottom), device.gain(top)]), "V", model_digits(x)),
            }
        )
    return rows


def energy(x: Results) -> list[Row]:
    rows, digits = [], model_digits(x)
    for bottom, top in x.design_speeds:
        gained = x.device.energy(bottom) + x.device.energy(top)
        rows.append(
            {
                "bottom": Amount(x.device.energy(bottom), "J", digits),
                "top": Amount(x.device.energy(top), "J", digits),
                "mean power at most": Amount(gained / x.device.period_s, "W", digits),
                "efficiency": percentage(gained / x.device.lost(bottom, top), digits),
                "field over breakdown": percentage(breakdown(x, bottom, top), digits),
            }
        )
    return rows


# The sweep.


def points(x: Results) -> list[Row]:
    rows, digits = [], model_digits(x)
    for point in x.points:
        value = point["sweep_value"]
        place = {x.symbol: Amount(value, x.unit, digits), "± bound": Bound(point["error_bound"])}
        if x.data["own_stiffness"] is not None:
            end, shown = compliant_end(x, x.parameter, value), digits_of(x, x.parameter, value, 3)
            of_compliant = "—" if end is None else end["missing"] or Amount(end["compliant"], x.unit, shown)
            place = {f"{x.symbol} rigid": Amount(value, x.unit, shown), f"{x.symbol} compliant": of_compliant}
        for mirrored in (False, True)[: 1 + (point["mirror"] is not None)]:
            motion = point["mirror"] if mirrored else point
            top = (point["phi_bottom_rad"] + pi) % (2 * pi) if mirrored else point["phi_top_rad"]
            happens = "its mirror image" if mirrored else f"{point['family']}: {WORDS_OF[point['kind']]}"
            rows.append(
                {"Point": point["label"], "What happens": happens}
                | place
                | {
                    "d": number(x.device.at(x.parameter, value).d, digits),
                    "q": number(motion["q"], digits),
                    "φB": number(motion["phi_bottom_rad"], digits),
                    "φT": number(top, digits),
                    "ŻB": _or_zero(motion["velocity_bottom"], digits),
                    "ŻT": _or_zero(motion["velocity_top"], digits),
                }
            )
    return rows


def _or_zero(value: float, digits: int) -> Amount:
    return number(0.0 if abs(value) < 1e-13 else value, digits)


def table_1(x: Results) -> list[Row]:
    place = {point["label"]: point["sweep_value"] for point in x.points}
    rows = []
    for of in x.data["table_1"]:
        start, end, word = of["start_label"], of["end_label"], of["stability"]
        symbol = "d"
        interval = (
            f"{start} < {symbol} < {end}" if start and end else f"{symbol} < {end}" if end
            else f"{symbol} > {start}" if start else "throughout"
        )  # fmt: skip
        for label, side in ((start, "sweep_start"), (end, "sweep_end")):
            assert not label or abs(place[label] - of[side]) <= 1e-9 * abs(place[label])
        row = {
            "Motion": of["family"].capitalize(),
            "Branch": str(of["branch"]),
            "Interval": interval,
            "Type": word,
            "Criteria": f"Δ {'>' if 'node' in word else '<'} 0 and |λi| {'<' if word.startswith('stable') else '>'} 1",
        }
        for label, value, of_d, of_swept, unit in (
            (start, of["sweep_start"], "d from", f"{x.symbol} from", x.unit), (end, of["sweep_end"], "to", "to 2", "")
        ):  # fmt: skip
            digits = digits_of(x, x.parameter, place[label], 8) if label else 8
            of = number(x.device.at(x.parameter, value).d, model_digits(x))
            row |= {of_d: of, of_swept: Amount(value, unit, digits)}
        rows.append(row)
    return rows


ACCELERATION = {
    False: ("Acceleration amplitude of the capsule", "F/M"),
    True: ("Largest acceleration of the capsule between impacts", "(F + m g sin β)/M"),
}
STROKE = {
    False: ("Stroke of the capsule, end to end", "2F/(Mω²)"),
    True: ("Stroke of the capsule, at most", "(2F/ω² + m s)/(M + m)"),
}
"""What the shaker must do, and of a free capsule."""


def what_follows(x: Results) -> list[Row]:
    columns: dict[str, float] = {}
    if x.sweep:
        columns = {"from": x.sweep["from"], "to": x.sweep["to"]}
    if getattr(x.device, x.parameter) is not None:
        columns = {"at the design point": getattr(x.device, x.parameter), **columns}
    quantities: tuple[tuple[str, str, str, Callable[[Device], float]], ...] = (
        ("Unit of length", "xc", "m", lambda at: at.length_unit),
        ("Unit of velocity", "yc", "m/s", lambda at: at.velocity_unit),
        ("Unit of time", "tc", "s", lambda at: 1 / (2 * at.frequency_hz)),
        ("Dimensionless length", "d = s/xc", "", lambda at: at.d),
        ("Dimensionless gravity", "ḡ", "", lambda at: at.gbar),
        (*ACCELERATION[x.device.free], "m/s²", lambda at: at.acceleration),
        ("the same over 9.80665 m/s²", "", "g", lambda at: at.acceleration / STANDARD_GRAVITY),
        (*STROKE[x.device.free], "m", lambda at: at.stroke),
        ("Force amplitude on the capsule", "F", "N", lambda at: at.amplitude_n),
    )
    return [
        {
            "Quantity": name,
            "Symbol": symbol,
            **{title: number(of(x.device.at(x.parameter, value)), model_digits(x)) for title, value in columns.items()},
            "Unit": unit,
        }
        for name, symbol, unit, of in quantities
    ]


UNITS = {
    "_kg": "kg", "_m": "m", "_n": "N", "_hz": "Hz", "_deg": "°", "_v": "V", "_m_s2": "m/s²", "_v_m": "V/m", "_g": "g",
    "_percent": "%", "_mw": "mW", "_m_s": "m/s", "_periods": "periods", "area_ratio_at_most": "times",
}  # fmt: skip
"""Units by the ends of the keys that have them; the longest counts."""

SYMBOLS_OF_KEYS = {
    "device.capsule_mass_kg": "M", "device.ball_mass_kg": "m", "device.restitution": "r", "device.length_m": "s",
    "device.restitution_bottom": "rbottom", "device.restitution_top": "rtop",
    "excitation.amplitude_n": "F", "inclination_deg": "β", "gravity_m_s2": "g", "period_ratio": "n",
}  # fmt: skip


def inputs_faults(x: Results, rows: list[list[str]]) -> Iterator[str]:
    """The table of inputs: every value that the scenario has, by its key."""
    given = dict(_leaves(x.scenario))
    for _, symbol, value, unit, _, key in rows:
        asked = given[key]
        ending = max((end for end in UNITS if key.endswith(end)), key=len, default="")
        if symbol != SYMBOLS_OF_KEYS.get(key, symbol):
            yield f"{key} has the symbol {symbol}"
        if isinstance(asked, float | int) and not isinstance(asked, bool):
            if wrong := Said("{}", Amount(float(asked), "", 15)).faults(value, whole=True):
                yield f"{key}: {wrong}"
            swept_unit = x.unit if key.startswith("sweep.") or key.endswith(("stable_from", "stable_to")) else ""
            if unit != (UNITS[ending] if ending else swept_unit) and key not in NO_UNIT:
                yield f"{key} is shown in {unit!r}"


def printed_faults(rows: list[list[str]]) -> Iterator[str]:
    """The numbers of the paper beside ours: they agree where they differ by less than one in the last digit printed."""
    for quantity, printed, computed, told, _ in rows:
        if printed != "—":
            unit = 10.0 ** -len(printed.partition(".")[2])
            agrees = abs(float(computed.replace("−", "-")) - float(printed.replace("−", "-"))) < unit
            if len(computed.replace(".", "")) < len(printed.replace(".", "")):
                yield f"{quantity}: {computed} is shown as computed to fewer digits than the paper has"
            if told == "agrees" and not agrees and "d = " not in quantity:
                yield f"{quantity}: {printed} beside {computed} is said to agree"
        elif told:
            yield f"{quantity}: nothing is printed, and it {told}"


def types_faults(x: Results, rows: list[list[str]]) -> Iterator[str]:
    """Table 1 of the paper beside ours: intervals and types are those of results.json, and agree where it is said."""
    ours = {(row["Motion"], row["Interval"]): of for row, of in zip(table_1(x), x.data["table_1"], strict=True)}
    for motion, interval, low, high, printed, computed, told in rows:
        of = ours.get((motion.split(",")[0], interval))
        if of is not None:
            for side, text in ((of["d_start"], low), (of["d_end"], high)):
                if wrong := Said("{}", number(side, model_digits(x))).faults(text, whole=True):
                    yield f"{motion}, {interval}: {wrong}"
        if computed != ("—" if of is None else of["stability"]):
            yield f"{motion}, {interval}: {computed} is shown as computed, and results.json has {of}"
        if (told == "agrees") is not (printed == computed):
            yield f"{motion}: {printed} beside {computed}, and {told!r}"


NO_UNIT = ("device.membrane.stiffness", "simulation.samples")


def _leaves(tree: dict[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", value


# Tolerances.


def tolerances(x: Results) -> list[Row]:
    of, rows = x.scenario["tolerances"], []
    for parameter, (quantity, symbol, unit) in SYMBOLS.items():
        at, stem = getattr(x.device, parameter), parameter.removesuffix("_m").removesuffix("_n")
        for ending in ("_kg", "_hz", "_deg"):
            stem = stem.removesuffix(ending)
        absolute, relative = of.get(parameter) or 0.0, of.get(f"{stem}_percent") or 0.0
        width = max(absolute, relative / 100 * at)
        if width:
            name = f"{quantity[0].upper()}{quantity[1:]} {symbol}{f' [{unit}]' if unit else ''}"
            rows.append({"Input": name, "From": number(at - width), "To": number(at + width)})
    if (worst := x.data["tolerances"]["worst"]) is not None:
        for row, parameter in zip(rows, (of["parameter"] for of in x.data["tolerances"]["inputs"]), strict=True):
            row["Worst device"] = number(worst["values"][parameter])
    return rows


def random_devices(x: Results) -> list[Row]:
    names = {"velocity_bottom_m_s": "ŻB [m/s]", "velocity_top_m_s": "ŻT [m/s]", "u_ave_v": "Uave [V]"}
    heads = {
        "Least": "least", "5 %": "percentile_5", "Median": "median", "95 %": "percentile_95", "Largest": "largest",
    }  # fmt: skip
    rows = []
    for key, of in x.data["tolerances"]["ranges"].items():
        assert of["least"] < of["percentile_5"] < of["median"] < of["percentile_95"] < of["largest"]
        rows.append({"Quantity": names[key], **{head: number(of[name]) for head, name in heads.items()}})
    return rows


# Motions of other sequences.


def families(x: Results) -> list[Row]:
    rows = []
    for of in sorted(x.data["families"], key=lambda of: not of["stable_range"]):
        stable = of["stable_range"]
        runs = list(_runs(of["stable"]))
        first, last = max(runs, key=lambda run: run[1] - run[0], default=(0, len(of["d"]) - 1))
        middle = (first + last) // 2
        value = of["sweep_value"][middle]
        unit = x.device.at(x.parameter, value).velocity_unit
        gains = [x.device.gain(abs(unit * velocity)) for velocity in of["velocity"][middle]]
        rate = len(gains) * x.device.at(x.parameter, value).frequency_hz / of["periods"]
        rows.append(
            {
                "Word": of["word"],
                "n:m": of["ratio"],
                "Periods": str(of["periods"]),
                x.symbol: _many(x, [{"from": min(of["sweep_value"]), "to": max(of["sweep_value"])}], ", "),
                "Stable": _many(x, stable, ", ") if stable else "nowhere",
                "Begins": _end(of["begins_with"]),
                "Ends": _end(of["ends_with"]),
                "Uave": Amount(mean(gains), "V", 3),
                "": Amount(rate * mean(gains), "V/s", 3),
            }
        )
    return rows


def _end(end: dict[str, Any]) -> Any:
    if end["kind"] == "lost":
        return Said("not followed beyond {}", number(end["sweep_value"]))
    return end["label"] or end["kind"].replace("_", " ")


def _many(x: Results, parts: list[dict[str, float]], between: str, unit: bool = False) -> Said:
    amounts = [
        amount
        for part in parts
        for amount in (number(part["from"]), swept(x, part["to"]) if unit else number(part["to"]))
    ]
    return Said(between.join(["{} to {}"] * len(parts)), *amounts)


def _runs(flags: list[bool]) -> Iterator[tuple[int, int]]:
    first = None
    for k, flag in enumerate([*flags, False]):
        if flag and first is None:
            first = k
        elif not flag and first is not None:
            yield first, k - 1
            first = None


def rungs(x: Results) -> list[Row]:
    words: dict[str, list[dict[str, Any]]] = {}
    for of in x.data["families"]:
        if any(of["stable"]):
            words.setdefault(of["word"], []).append(of)
    rows = []
    for word, members in words.items():
        volts, rates, impacts = [], [], []
        for of in members:
            for k in (k for k, stable in enumerate(of["stable"]) if stable):
                device = x.device.at(x.parameter, of["sweep_value"][k])
                mean_v = mean([x.device.gain(abs(device.velocity_unit * velocity)) for velocity in of["velocity"][k]])
                rate = len(of["velocity"][k]) * device.frequency_hz / of["periods"]
                volts.append(mean_v), rates.append(rate * mean_v), impacts.append(rate)
        parts = sorted((part for of in members for part in of["stable_range"]), key=lambda part: part["from"])
        rows.append(
            {
                "Word": word,
                "Periods": str(members[0]["periods"]),
                f"Stable at {x.symbol}": _many(x, parts, "; ", unit=True),
                "Uave": Amount(max(volts), "V", 3),
                "Per second": Amount(max(rates), "V/s", 3),
                "Impacts/s": Said("{}", number(max(impacts), 3)) if min(impacts) == max(impacts)
                else Said("{} to {}", number(min(impacts), 3), number(max(impacts), 3)),
            }
        )  # fmt: skip
    return sorted(rows, key=lambda row: -row["Per second"].value)


# Simulation.


def simulated(x: Results) -> list[Row]:
    of = x.data["simulation"]
    count = of["orbits_checked"]
    answers: dict[str, Any] = {"Stable motions checked": str(count)}
    if count:
        answers |= {
            "Found again by the simulation": f"{count - len(of['misses'])} of {count}",
            "Largest difference in velocity": Said("{} of the unit yc", number(of["velocity_difference"], 2)),
            "Largest difference in phase": Said("{}", Amount(of["phase_difference_rad"], "rad", 2)),
            "Tolerance": number(of["tolerance"], 2),
            "Cross-check": "passed" if of["passed"] else "failed: the verdict is withheld",
        }
    if (basin := of["basin"]) is not None:
        assert abs(basin["share"] - basin["reached"] / basin["trials"]) < 1e-15
        answers["Starts that reach the 1:1 motion, where there is a stable one"] = Said(
            f"{basin['reached']} of {basin['trials']}: {{}} (95 % interval {{}} to {{}})",
            *(percentage(basin[key]) for key in ("share", "low_95", "high_95")),
        )
    return [{"Question": question, "Answer": answer} for question, answer in answers.items()]


def in_detail(x: Results) -> list[Row]:
    """The motion that is simulated at the design point: the stable one of the solution, to less than the tolerance."""
    of, (k,) = x.design, x.stable
    root = sqrt(of["trace"][k] ** 2 - 4 * x.device.determinant)
    return [
        {
            "Motion": Said(f"{x.symbol} = {{}}", swept(x, of["sweep_value"][k])),
            "Impacts": "BT",
            "Periods": str(x.device.period_ratio),
            "|Ż| at each": Said("{}, {}", number(of["velocity_bottom"][k], 3), number(-of["velocity_top"][k], 3)),
            "Residual": Below(x.data["simulation"]["tolerance"]),
            "Largest |λ|": number((abs(of["trace"][k]) + root) / 2, 3),
        }
    ]


OUTCOMES = {
    "aperiodic": "chaotic, or not periodic within the budget",
    "sticking": "chatter with sticking, periodic",
    "rest": "at rest on the bottom membrane",
}


def _kind(of: dict[str, Any]) -> str:
    if of["outcome"] != "periodic":
        return OUTCOMES[of["outcome"]]
    return f"{of['word']} every {'' if of['period'] == 1 else str(of['period']) + ' '}forcing period" + "s" * (
        of["period"] != 1
    )


def _counted(x: Results, motions: list[dict[str, Any]]) -> list[Row]:
    total = sum(of["count"] for of in motions)
    return [
        {
            "Motion": _kind(of),
            "Starts": str(of["count"]),
            "Share": percentage(of["count"] / total),
            f"At {x.symbol}": Said("{}", swept(x, of["from"])) if of["from"] == of["to"]
            else Said("{} to {}", number(of["from"]), swept(x, of["to"])),
        }
        for of in motions[:12]
    ]  # fmt: skip


def jumps(x: Results) -> list[Row]:
    rows = []
    for way in ("up", "down"):
        for of in x.data["simulation"]["follow"][way]["jumps"]:
            middle, half = (of["from"] + of["to"]) / 2, abs(of["to"] - of["from"]) / 2
            vertex = of["vertex"]
            rows.append(
                {
                    "Direction": way,
                    f"At {x.symbol}": Said("{} ± {}", swept(x, middle, 3), number(half, 1)),
                    "From": _kind(of["before"]),
                    "To": _kind(of["after"]),
                    "The family before ends at": "—" if vertex is None
                    else Said(f"{vertex['label']}, {vertex['kind'].replace('_', ' ')}, {{}}",
                              swept(x, vertex["sweep_value"], 3)),
                }
            )  # fmt: skip
    return rows


def hysteresis(x: Results) -> list[Row]:
    return [
        {
            x.symbol: Said("{} to {}", number(of["from"]), swept(x, of["to"])),
            "Width": Said("{}", swept(x, of["to"] - of["from"], 3)),
            "Upwards": _kind(of["up"]),
            "Downwards": _kind(of["down"]),
        }
        for of in x.data["simulation"]["follow"]["loops"]
    ]


def coexisting(x: Results) -> list[Row]:
    heads = {"Upwards": "up", "Downwards": "down", "Random starts": "starts", "Stable as a family": "families"}

    def ranges(parts: list[list[float]]) -> Any:
        if not parts:
            return "—"
        texts = ["{}" if low == high else "{} to {}" for low, high in parts]
        values = [own for low, high in parts for own in ([number(low)] if low != high else []) + [swept(x, high)]]
        return Said("; ".join(texts), *values)

    return [
        {"Motion": _kind(of), **{head: ranges(of[key]) for head, key in heads.items()}}
        for of in x.data["simulation"]["follow"]["coexisting"]
    ]


def _outcome(of: dict[str, Any]) -> str:
    """What switching on leads to, in words, of a part of the sweep; words of more than 16 letters are not shown."""
    if not of["word"]:
        names = {
            "at_rest": "at rest on the bottom membrane",
            "chaotic": "chaotic, or not periodic within the budget",
            "undecided": "a motion that rounding hides",
            "rest_cycle": "rest again and again, at irregular times",
        }
        return names[of["outcome"]]
    often = "forcing period" if of["periods"] == 1 else f"{of['periods']} forcing periods"
    if of["outcome"] != "rest_cycle":
        return f"{of['word']} every {often}"
    return f"rest every {often}" + (f" ({of['word']})" if len(of["word"]) <= 16 else "")


def outcomes_along(x: Results) -> list[Row]:
    return [
        {f"{x.symbol} from": Amount(of["from"], x.unit, 3), "to": number(of["to"], 3), "Outcome": _outcome(of)}
        for of in x.data["disturbances"]["from_rest"]["along_sweep"]
    ]


def edges_of_outcome(x: Results) -> list[Row]:
    found = x.data["disturbances"]["from_rest"]
    window, (_, symbol, unit) = found["window"], SYMBOLS[found["window"]["parameter"]]
    return [
        {
            "Side": side,
            symbol: Amount(window[end], unit, model_digits(x)),
            "Outcome up to there": _outcome(found),
            "Outcome beyond": _outcome({name: window[f"{end}_{name}"] for name in ("outcome", "word", "periods")})
            if window[f"{end}_outcome"]
            else "no change found",
            "Edges accumulate": "yes" if window[f"{end}_accumulates"] else "no",
        }
        for side, end in (("below", "from"), ("above", "to"))
    ]


def _end_of(reason: str) -> str:
    return "followed no farther" if reason in ("sweep_end", "not_followed") else reason.replace("_", " ")


def motion_from_rest(x: Results) -> list[Row]:
    """The motion of another word, whose type follows from its trace and the restitution, Table 1 for more impacts."""
    return [_followed(x, x.data["disturbances"]["from_rest"]["motion"])]


def motions_by_starts(x: Results) -> list[Row]:
    return [_followed(x, of) for of in x.data["disturbances"]["found_by_starts"]]


def _followed(x: Results, of: dict) -> Row:
    decay, stable = x.device.restitution ** len(of["word"]), of["stable_range"]
    _, symbol, unit = SYMBOLS[stable["parameter"]]
    focus = abs(of["trace"]) < 2 * decay
    assert abs(of["trace"]) < 1 + decay**2
    return {
        "Motion": _outcome({"outcome": "other_motion", **of}),
        "Type": "stable focus" if focus else "stable node",
        f"Stable from {symbol}": Amount(stable["from"], unit, model_digits(x)),
        "to": number(stable["to"], model_digits(x)),
        "Begins with": _end_of(stable["from_reason"]),
        "Ends with": _end_of(stable["to_reason"]),
    }


def basins(x: Results) -> list[Row]:
    ends = {"share": "share", "from": "low_95", "to": "high_95"}
    return [
        {"What an impact leads to": of["name"]} | {head: Amount(100 * of[key], "%", 2) for head, key in ends.items()}
        for of in x.data["disturbances"]["basin"]["attractors"]
    ]


def attracting_motions(x: Results) -> list[Row]:
    rows = []
    for of in x.data["disturbances"]["coexistence"]["motions"]:
        shock: Said | Amount | str = "–"
        if of["least_jump_m_s"] is not None:
            shock = Amount(of["least_jump_m_s"], "m/s", 3)
        elif of["searched_to_m_s"] is not None:
            shock = Said("none up to {}", Amount(of["searched_to_m_s"], "m/s", 3))
        rows.append(
            {
                "Motion": of["name"],
                "Starts": "–" if of["share_of_starts"] is None else Amount(100 * of["share_of_starts"], "%", 2),
                "From rest": {True: "yes", False: "no", None: "–"}[of["reached_from_rest"]],
                "Least shock": shock,
                "It leads to": of["leads_to"] or "–",
            }
        )
    return rows


def spreads(x: Results) -> list[Row]:
    of = x.data["disturbances"]["jitter"]
    return [
        {
            "Impact": where,
            "phase": Amount(of[f"phase_{where}_deg"], "°", 3),
            "velocity": Amount(of[f"velocity_{where}_m_s"], "m/s", 3),
            "voltage": Amount(of[f"u_{where}_v"], "V", 3),
            "mean voltage": Amount(of[f"u_{where}_mean_v"], "V", 3),
        }
        for where in ("bottom", "top")
    ]


TABLES: dict[str, Callable[[Results], list[Row]]] = {
    "Requirements": requirements,
    "Where the values come from": remarks,
    "How far each input can go before stable motion ends": ranges_around,
    "What is left of the margin in .*": what_is_left,
    "Distortion of the force that ends stable motion": distortions,
    "1:1 motions at the design point": motions_at_design,
    "Voltages of the stable motions": voltages,
    "How Uave depends on the ball mass: .*": mass_effects,
    "Electrical energy of the stable motions at the design point: upper bounds": energy,
    "Critical points, and the motion there": points,
    "Table 1 for this scenario": table_1,
    "Around the design point: where the outcome from rest changes": edges_of_outcome,
    "Along the sweep: what switching on from rest leads to": outcomes_along,
    "Stable motions at the design point": attracting_motions,
    "Basins on the section of impacts": basins,
    "How far random kicks spread the motion": spreads,
    "The motion that the device comes to from rest": motion_from_rest,
    "Stable motions that some starts come to, but not the device from rest": motions_by_starts,
    "What follows from them": what_follows,
    "Tolerances": tolerances,
    "Stable motions of the random devices": random_devices,
    "Families of motions, with voltages .*": families,
    "Stable motions by the word of their impacts, with .*": rungs,
    "Simulation against solution": simulated,
    "Where the starts end": lambda x: _counted(x, x.data["simulation"]["motions"]),
    "Where starts end that do not .*": lambda x: _counted(x, x.data["simulation"]["basin"]["elsewhere"]),
    "Simulated motions in detail": in_detail,
    "Jumps": jumps,
    "Hysteresis": hysteresis,
    "Motions by how they are found, with their ranges of .*": coexisting,
}
"""What stands in each table, by its caption."""

WORDS_ONLY = ("Symbols: .*", "Not in this report", "Made with", "Misprints in the paper.s text")
"""Captions of tables of words, or of numbers that are no results: what was run, with what."""


# Sentences: alerts, notes below tables, proofs.


def inequality(x: Results, part: dict[str, Any], parameter: str) -> Said:
    """A stable range in words; its end belongs to it where no critical point ends it."""
    signs = [
        "≤" if part[f"{end}_reason"] in ("end of the sweep", "limit of the input") else "<" for end in ("from", "to")
    ]
    low, high = (in_input(parameter, part[end], digits_of(x, parameter, part[end], 3)) for end in ("from", "to"))
    return Said(f"{{}} {signs[0]} {SYMBOLS[parameter][1]} {signs[1]} {{}}", low, high)


def sentences(x: Results) -> Iterator[Said]:
    """What a page says in sentences below its opening, with its numbers."""
    if x.sweep:
        low, high = (swept(x, x.sweep[end]) for end in ("from", "to"))
        yield Said(f"From and to are the ends of the sweep, {x.symbol} = {{}} and {{}}.", low, high)
        for part in x.data["stable_range"]:
            for end in ("from", "to"):
                if part[end] in (x.sweep["from"], x.sweep["to"]) and (beyond := part[f"{end}_beyond_sweep"]):
                    kind, ends = WORDS_OF[beyond["kind"]], (part[end], beyond["sweep_value"])
                    yield Said(
                        f"At {{}} only the sweep ends: stable motion continues to the {kind} at {{}}.",
                        *(swept(x, value, digits_of(x, x.parameter, value, 8)) for value in ends),
                    )
    for alert in x.data["alerts"]:
        mark = {"error": "✗", "warning": "!", "note": "i"}[alert["severity"]]
        cause, remedy = (" ".join(alert[key].replace("U_ave", "Uave").split()[:2]) for key in ("cause", "remedy"))
        yield Said(f"{mark} {alert['code']}: {alert['title'].replace('U_ave', 'Uave')}. {cause}")
        yield Said(f"Remedy. {remedy}")
    if x.points and x.data["own_stiffness"] is None and x.contact_share:
        neglected = percentage(x.contact_share)
        yield Said("it does not include the contact time that the model neglects, {} of a period", neglected)
    if x.points and x.data["own_stiffness"] is not None:
        largest = max(point["error_bound"] for point in x.points)
        yield Said(
            f"s solutions of the equations of rigid impacts, in results.json, the points are known to {{}} {x.unit}.",
            Bound(largest),
        )
    if x.design is not None:
        yield from _of_design(x)
    if x.device.ball_mass_kg is not None:
        yield from _of_membrane(x)
    if x.data["requirements"] is not None:
        yield from _met(x)
    if x.data["disturbances"] is not None and x.data["disturbances"]["proof"] is not None:
        yield from _proved(x)
    if x.data["tolerances"] is not None:
        yield from of_tolerances(x)
    if x.data["families"]:
        yield from _of_families(x)
    if x.data["simulation"] is not None:
        yield from _of_simulation(x)


def asked(x: Results) -> list[tuple[str, str, bool]]:
    if x.data["requirements"] is None:
        return []
    return [(key, title, met) for key, title, *_, met in judged(x)]


def _met(x: Results) -> Iterator[Said]:
    criteria = x.data["requirements"]["criteria"]
    passed = {key: met for key, _, met in asked(x)} | {"stable_from": True, "crosscheck_passed": True}
    for criterion in criteria:
        assert criterion["passed"] is passed[criterion["key"]], criterion
    known = {key: (limit, value, margin) for key, _, _, limit, value, margin, _ in judged(x)}
    for criterion in criteria:
        told = tuple(criterion[name] for name in ("limit_value", "value", "margin"))
        for number_told, number_known in zip(told, known.get(criterion["key"], ()), strict=False):
            assert abs(number_told - number_known) <= 1e-9 * max(abs(value) for value in known[criterion["key"]])
        if criterion["key"] == "stable_from":
            given = x.scenario["requirements"]
            assert criterion["limit_value"] == given["stable_to"] - given["stable_from"]
    met, count = sum(passed[criterion["key"]] for criterion in criteria), len(criteria)
    yield Said(f"{met} of {count} requirements {'is' if met == 1 else 'are'} met.")


def _of_design(x: Results) -> Iterator[Said]:
    values = [(name, getattr(x.device, name)) for name in SWEPT]
    if x.design["q"]:
        at = ", ".join(f"{SYMBOLS[name][1]} = {{}}" for name, _ in values)
        yield Said(f"At {at}:", *(in_input(name, value, 8) for name, value in values))
        alike = x.device.restitution_bottom == x.device.restitution_top
        yield Said(
            f"Det = {'r⁴' if alike else '(rbottom rtop)²'} = {{}} for all",
            number(x.device.determinant, model_digits(x)),
        )


def stable_speeds(x: Results) -> list[tuple[float, float]]:
    """Impact speeds of the stable motions, at the design point where there is one, else along the sweep."""
    return x.design_speeds if x.design is not None else speeds_along(x)


def speeds_along(x: Results) -> list[tuple[float, float]]:
    ends = [x.speeds(velocities, value) for _, value, _, velocities in x.ends()]
    return ends + [
        x.speeds((branch["velocity_bottom"][k], branch["velocity_top"][k]), branch["sweep_value"][k])
        for branch in x.data["branches"]
        for k, word in enumerate(branch["stability"])
        if branch["admissible"][k] and word.startswith("stable")
    ]


def _of_stretch(x: Results) -> Iterator[Said]:
    """How deep the stable motions press a membrane in, and what is open there."""
    radius = x.device.membrane["active_radius_m"]
    fastest = max(max(speeds) for speeds in stable_speeds(x))
    deepest, peak = x.device.deflection(fastest), x.device.gain(fastest) + x.device.membrane["bias_voltage_v"]
    area = sqrt(peak / x.device.membrane["bias_voltage_v"])
    if deepest > radius:
        far = ", more than the 5.9 times demonstrated for a dielectric elastomer" if area > 5.9 else ""
        yield Said(
            f"press the membrane in up to {{}} mm, {{}} times its active radius of {{}} mm, and its area grows {{}} "
            f"times{far}.",
            number(1e3 * deepest, 3), number(deepest / radius, 2), number(1e3 * radius, 2), number(area, 3),
        )  # fmt: skip
        if x.device.membrane["thickness_m"] is None:
            yield Said(
                "At a breakdown field of 100 MV/m its {} kV need a thickness of {} mm;",
                number(peak / 1e3, 3), number(peak / 1e5, 2),
            )  # fmt: skip


def _of_membrane(x: Results) -> Iterator[Said]:
    device, of = x.device, x.device.membrane
    radius, h = of["active_radius_m"], of["exponent"]
    origin = "set by --set" if any("ball_mass_kg" in text for text in x.data["overrides"]) else "given by the"
    yield Said(f"The ball mass m = {{}} is {origin}", Amount(1e3 * device.ball_mass_kg, "g", 8))
    if not x.places():
        return
    yield Said("δ the larger deflection; Rc = {}.", Amount(radius, "m", 3))
    exponent = 1 / (h + 1)
    if device.free:
        yield Said("grows with the power 1/(h + 1) = {} of m/(1 + m/M). The velocities are those", number(exponent, 3))
    else:
        yield Said(
            "grows with the power 1/(h + 1) = {} of m: a ball of twice the mass goes {} times as deep",
            number(exponent, 3), number(2**exponent, 3),
        )  # fmt: skip
    if stable_speeds(x):
        yield from _of_stretch(x)
    if x.stable and of["thickness_m"] is not None:
        highest = max(field(x, *speeds) for speeds in x.design_speeds)
        if highest > of["breakdown_field_v_m"]:
            yield Said(
                "The field reaches {}, {} times the breakdown field of {}.", Amount(highest, "V/m"),
                number(highest / of["breakdown_field_v_m"], 3), Amount(of["breakdown_field_v_m"], "V/m"),
            )  # fmt: skip
    yield from _alerts(x)


def _alerts(x: Results) -> Iterator[Said]:
    codes = {alert["code"] for alert in x.data["alerts"]}
    if "VR012" in codes:
        heavier = x.device.at("ball_mass_kg", x.device.ball_mass_kg * (1 + 1e-6))
        effect = max(
            (mean([heavier.gain(v) for v in speeds]) / mean([x.device.gain(v) for v in speeds]) - 1) / 1e-6
            for speeds in stable_speeds(x)
        )
        yield Said("1 % of ball mass changes Uave by up to {}.", Amount(effect, "%", 2))
    if "VR005" in codes:
        end = x.ending[0]
        side = "below" if end["relative"] < 0 else "above"
        quantity = SYMBOLS[end["parameter"]][0]
        yield Said(
            f"Stability passes to another motion, with other voltages, {{}} {side} the design point in {quantity}: "
            f"{_name(end)}"
            if end["taken_over"]
            else f"Stable motion ends {{}} {side} the design point in {quantity}: {_name(end)}",
            percentage(abs(end["relative"])),
        )
    contact = next((alert["cause"] for alert in x.data["alerts"] if alert["code"] == "VR011"), None)
    if contact is not None:
        share = float(contact.split(" some ")[1].split(" %")[0])
        if x.points:
            yield Said("Contacts of {} of a period limit the digits shown.", Amount(share, "%", 2))


def of_tolerances(x: Results) -> Iterator[Said]:
    of = x.data["tolerances"]
    yields = of["yield"]
    share = yields["stable"] / yields["samples"]
    assert abs(share - yields["share"]) < 1e-15
    interval = [percentage(yields[key]) for key in ("low_95", "high_95")]
    yield Said(
        f"Of {yields['samples']} random devices, {yields['distribution']} within the tolerances, {yields['stable']} "
        "have one: {}, with a 95 % interval of {} to {}.",
        percentage(share), *interval,
    )  # fmt: skip
    if of["worst"] is not None:
        yield Said("stable motion ends at {} of the way from the design", percentage(of["worst"]["share"]))
    if of["proof_not_known_of"] is not None:
        end = next(row for row in x.design["margins"] if row["ends_stability"] or row["taken_over"])
        slopes = end["derivatives_by_harmonic"]
        moved = [hypot(*slopes[str(own["order"])].values()) for own in x.scenario["excitation"]["harmonics"]]
        unit = end["unit"]
        yield Said(
            f"moves the nearest end of stable motion, {end['kind'].replace('_', ' ')} at {{}}, by "
            + " and ".join(f"{{}} for order {own['order']}" for own in x.scenario["excitation"]["harmonics"])
            + ". That end is {} away.",
            Amount(end["sweep_value"], unit), *(Amount(own, unit, 2) for own in moved),
            Amount(abs(end["distance"]), unit, 3),
        )  # fmt: skip


def _of_families(x: Results) -> Iterator[Said]:
    ladder = rungs(x)
    if not ladder:
        return
    most = max(ladder, key=lambda row: row["Uave"].value)
    yield Said(f"{most['Word']} has the largest voltage per impact, up to {{}} at {x.symbol} = ", most["Uave"])
    yield Said("most per second, up to {} at", ladder[0]["Per second"])


def _of_simulation(x: Results) -> Iterator[Said]:
    of = x.data["simulation"]
    count = len(of["samples"])
    starts = len(of["samples"][0]["ends"])
    yield Said(f"at {count} values of the {SYMBOLS[x.parameter][0]}, from {starts} random starts at each")
    fastest = [sample["start_velocity_at_most"] for sample in of["samples"]]
    yield (
        Said("velocity uniform up to {} of the unit yc in", number(min(fastest), 3))
        if min(fastest) == max(fastest)
        else Said("velocity uniform up to {} to {} of the unit yc in", number(min(fastest), 3), number(max(fastest), 3))
    )


def _proved(x: Results) -> Iterator[Said]:
    """What is proved of switching on and of shocks, or why nothing is."""
    found = x.data["disturbances"]
    start, shocks = found["proof"]["from_rest"], found["proof"]["shocks"]
    if found["from_rest"]["proved"]:
        of = found["proof"]["regions"][start["region"]]
        assert (of["word"], of["periods"]) == (found["from_rest"]["word"], found["from_rest"]["periods"])
        often = "forcing period" if of["periods"] == 1 else f"{of['periods']} forcing periods"
        said = f"the ball is pressed down, the device reaches {of['word']} every {often}. "
        said += "Ball arithmetic of {} bits encloses {} impacts"
        yield Said(said, number(start["bits"]), number(start["impacts"]))
    else:
        reason = start["reason"][0].upper() + start["reason"][1:]
        yield Said(f"Not proved: that the motion is reached from rest. {reason}.")
    if (bound := found["shock"]["proved_m_s"]) is not None:
        assert bound < min(of["largest"] for of in shocks) * x.device.velocity_unit
        said = "roved: every jump of the relative velocity up to {}, at any moment and of either sign, dies out "
        said += "({} cells of moments"
        cells = sum(of["halved"].count(-1) for of in shocks)
        yield Said(said, Amount(bound, "m/s", 3), number(cells))
    else:
        yield Said("Not proved: a bound of the shocks that the motion survives.")


# Comparisons, the best design, charts and figures.


def ranking(named: dict[str, Results]) -> list[Row]:
    """The ranking of scenarios with requirements: those that miss fewer come first, then larger margins to use."""
    rows = []
    for name, x in named.items():
        criteria = x.data["requirements"]["criteria"]
        met = sum(of["passed"] for of in criteria)
        use, (part,) = x.data["margin_to_use"], x.data["stable_range"]
        average = min(mean([x.device.gain(v) for v in speeds]) for speeds in x.design_speeds)
        room = 0.0 if use["gone"] else use["relative"]
        said = Said(f"{{}} in {SYMBOLS[use['parameter']][0]}", percentage(room))
        row = {
            "Scenario": name,
            "Verdict": ANYTHING,
            "Requirements": f"{met} of {len(criteria)}",
            "Margin to use": "none" if use["gone"] else said,
            "Limited by": ANYTHING,
            "Mean voltage": Said("{}", Amount(average, "V", 3)),
            "Per second": Said("{}", Amount(2 * x.device.frequency_hz / x.device.period_ratio * average, "V/s", 3)),
            "Stable range": inequality(x, part, x.parameter),
        }
        rows.append((len(criteria) - met, -room, row))
    return [{"Rank": str(k), **row} for k, (_, _, row) in enumerate(sorted(rows, key=lambda of: of[:2]), 1)]


def nearest_ends(named: dict[str, Results]) -> list[Row]:
    """The nearest end of stable motion in each input, of scenarios as they are ranked."""
    rows = []
    for name in (row["Scenario"] for row in ranking(named)):
        x, row = named[name], {"Scenario": name}
        for parameter, (quantity, symbol, _) in SYMBOLS.items():
            end = next(of for of in x.ending if of["parameter"] == parameter)
            share = end["sweep_value"] / getattr(x.device, parameter) - 1
            letter = {"period_doubling": "B", "fold": "C", "pitchfork": "C", "grazing": "G"}[end["kind"]]
            said = Said("{}{} {}", "+" if share > 0 else "−", percentage(abs(share)), letter)
            row[f"{quantity} {symbol}"] = said
        rows.append(row)
    return rows


def differing_settings(named: dict[str, Results]) -> dict[tuple[str, str], Any]:
    """The values that two scenarios do not share, by name and key."""
    leaves = {name: dict(_leaves(x.scenario)) for name, x in named.items()}
    keys = dict.fromkeys(key for of in leaves.values() for key in of)
    return {
        (name, key): of.get(key)
        for key in keys
        if key not in ("schema_version", "title")
        for name, of in leaves.items()
        if len({str(other.get(key)) for other in leaves.values()}) > 1
    }


def compared(named: dict[str, Results]) -> Iterator[Said]:
    """What the terminal says of each quantity that differs."""
    names = list(named)

    def line(what: str, of: Callable[[Results], float], unit: str, digits: int, between: str = " and ") -> Said:
        amounts = [Amount(of(x), unit, digits) for x in named.values()]
        return Said(f"{what} {between.join(f'{{}} for {name}' for name in names)} (", *amounts)

    def average(x: Results, pick: Callable[[Any], float]) -> float:
        return pick(mean([x.device.gain(v) for v in speeds]) for speeds in speeds_along(x))

    yield line("Lowest U_ave over the stable range:", lambda x: average(x, min), "V", 3)
    yield line("Highest U_ave over the stable range:", lambda x: average(x, max), "V", 3)
    yield line("U_ave of the stable motion at the design point:", lambda x: mean(
        [x.device.gain(v) for v in x.design_speeds[0]]), "V", 3)  # fmt: skip
    for label in ("B1", "G1"):
        yield line(
            f"{label}, {'period doubling' if label == 'B1' else 'grazing'} of the asymmetric motion: d =",
            lambda x, label=label: next(
                x.device.at(x.parameter, of["sweep_value"]).d for of in x.points if of["label"] == label
            ),
            "", 3,
        )  # fmt: skip
    for parameter in ("frequency_hz", "length_m"):

        def nearest(x: Results, parameter: str = parameter) -> float:
            end = next(
                of for of in x.ending
                if (of["parameter"], of["kind"]) == (parameter, "period_doubling") and of["relative"] < 0
            )  # fmt: skip
            return 100 * (end["sweep_value"] / getattr(x.device, parameter) - 1)

        yield line(
            f"Margin from the design point to the period doubling below, in {SYMBOLS[parameter][1]}:", nearest, "%", 2
        )


def along_the_sweep(x: Results) -> Iterator[tuple[str, Said]]:
    """What the captions and the alternative texts of figures 2, 4 and 7 say, by the figure."""
    others = [key for key in SWEPT if key != x.parameter]
    held = ", ".join(f"{SYMBOLS[key][1]} = {{}}" for key in others)
    amounts = [in_input(key, getattr(x.device, key), 8) for key in others]
    names = [key for key in ("restitution", "restitution_bottom", "restitution_top") if x.scenario["device"][key]]
    amounts += [Amount(x.device.capsule_mass_kg, "kg", 8), *(number(getattr(x.device, key), 8) for key in names)]
    restitutions = ", ".join(f"{SYMBOLS[key][1]} = {{}}" for key in names)
    ends = [swept(x, x.sweep[end]) for end in ("from", "to")]
    free = ""
    if x.device.free:
        free = "m = {}, capsule free, "
        amounts.insert(-len(names), Amount(1e3 * x.device.ball_mass_kg, "g", 3))
    conditions = Said(f"{held}, M = {{}}, {free}{restitutions}; {x.symbol} from {{}} to {{}}", *amounts, *ends)
    yield "figure-2", conditions
    for figure in ("figure-2", "figure-4", "figure-7"):
        places = [f"{point['label']} {{}}" for point in x.points]
        values = [(value := of["sweep_value"], digits_of(x, x.parameter, value, 3)) for of in x.points]
        shown = (in_input(x.parameter, value, digits) for value, digits in values)
        yield figure, Said(f"Critical points, at {x.symbol}: {'; '.join(places)}.", *shown)
        ranges = [inequality(x, part, x.parameter) for part in x.data["stable_range"]]
        if ranges:
            amounts = (amount for part in ranges for amount in part.amounts)
            yield figure, Said(f"Stable 1:1 motion for {' and for '.join(part.words for part in ranges)}.", *amounts)
    if (simulated := x.data["simulation"]) is not None:
        # Starts that come to one cycle share its residual to the last digit; other words are not drawn.
        drawn = {"BT"} | {of["word"] for of in x.data["families"] or () if re.fullmatch("(BT){2,}", of["word"])}
        cycles = [
            {(end["word"], end["residual"]) for end in sample["ends"] if end["word"] in drawn}
            for sample in simulated["samples"]
        ]
        impacts = sum(len(word) for found in cycles for word, _ in found)
        counted = f"{impacts} impacts of periodic motions at {sum(map(bool, cycles))} value"
        yield "figure-2", Said(f"circles: {counted}")
        yield "figure-7", Said(f"Circles: voltages of {counted}")
    if x.parameter == "length_m":
        yield "figure-2", Said("F/(2 M f) = {}", Amount(x.device.velocity_unit, "m/s", 3))
    yield "figure-7", Said(
        "with m = {} and U_in = {}", Amount(1e3 * x.device.ball_mass_kg, "g", 3),
        Amount(x.device.membrane["bias_voltage_v"], "V", 3),
    )  # fmt: skip
    volts = [mean([x.device.gain(v) for v in speeds]) for speeds in speeds_along(x)]
    yield (
        "figure-7",
        Said("Stable motions: average voltage {} to {}.", Amount(min(volts), "V", 3), Amount(max(volts), "V", 3)),
    )
    bottom, top = zip(*speeds_along(x), strict=True)
    if x.parameter == "length_m":
        unit = x.device.velocity_unit
        yield (
            "figure-2",
            Said(
                "Stable motions: impact speed at the bottom {} to {}, impact speed at the top {} to {}, phase",
                *(number(of / unit, 3) for of in (min(bottom), max(bottom), min(top), max(top))),
            ),
        )


def of_margins(x: Results) -> Iterator[Said]:
    """What the caption and the alternative text of the figure of margins say."""
    end = x.ending[0]
    quantity, symbol, _ = SYMBOLS[end["parameter"]]
    digits = digits_of(x, end["parameter"], end["sweep_value"], 3)
    value = in_input(end["parameter"], end["sweep_value"], digits)
    yield Said(f"That is the {_name(end)} at {symbol} = {{}}.", value)
    for key, slope in end["derivatives"].items():
        shift = (slope or 0.0) * getattr(x.device, key) / end["sweep_value"]
        if shift:
            yield Said(f"{SYMBOLS[key][0]} {{}}", Amount(shift, "%", 2))
    yield Said("if another input grows by 1 %")
    yield Said(f"moves the {_name(end)} in {quantity} by:")
