"""What is compared of a scenario: settings, requirements, motions, stable ranges, margins, voltages and alerts.

All is taken from the records of results.json, so that a study and the results of an earlier run are the same here. A
place along the sweep is given in the swept parameter and in d, which scenarios with different sweeps share.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping
from enum import StrEnum
from functools import cached_property
from math import pi
from typing import Any, Literal

from msgspec import Struct, convert
from msgspec.structs import asdict, replace

from vireport.base.records import brief, plain
from vireport.base.shares import NORMAL_95
from vireport.design.recovery import NoRecovery
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.scenario.parameters import Parameter, ScalarInput
from vireport.study.judging.findings import findings
from vireport.study.result_records import (
    BranchData,
    DesignData,
    MarginData,
    MeasuredData,
    MeasuredImpact,
    Results,
    ScenarioKeys,
    StableRangeData,
)
from vireport.text.formatting import OF_A_MODEL, OF_INPUTS, ROUGHLY, Exactness, rounded_text
from vireport.text.said import Said, words_of

SAMPLED = 1e-5
"""Relative difference up to which extremes of a curve are the same: they are taken of its samples."""

NOT_COMPARED = ("schema_version", "title")
"""Keys of a scenario that have no part in its results."""

SAME_VOLTAGE = 1e-9
"""Relative difference up to which two motions, such as mirror images, have one voltage."""

_said = words_of("quantities")

Text = str | Said
"""A text of a scenario or a file, or a macro of `templates/words/quantities.j2`."""

NO_SWEEP, NO_DESIGN, NO_MASS, HELD = map(_said, ("no_sweep", "no_design_point", "no_ball_mass", "holds_d"))
NO_STABLE, NO_STABLE_AT_DESIGN = _said("no_motion"), _said("no_motion_at_design")

Along = ScalarInput | Literal["d"]
"""What places are given in."""


class QuantityGroup(StrEnum):
    """Kinds of what is compared, what matters most to a design first."""

    SCENARIO = "scenario"
    REQUIREMENT = "requirement"
    DESIGN_POINT = "design point"
    DISTURBANCES = "disturbances"
    MEASURED = "measured"
    STABLE_RANGE = "stable range"
    MARGIN = "margin"
    VOLTAGE = "voltage"
    CRITICAL_POINT = "critical point"
    ALERT = "alert"

    @property
    def exactness(self) -> Exactness:
        """How exact its numbers are where no study says so: inputs are as given."""
        return OF_INPUTS if self is QuantityGroup.SCENARIO else OF_A_MODEL


class ComparedQuantity(Struct, frozen=True):
    """A quantity of one scenario: a number that was computed, or a statement, such as a setting or an alert.

    Attributes
    ----------
    group : QuantityGroup
        How much it matters is its place among the groups.
    subject : str or Said
        What it is.
    value : float, or of a statement what JSON can have
        None where the scenario does not have the quantity.
    unit : str
        Of a number, "1" where it has none; "" for a statement.
    symbol : str
        What stands for the number, or "".
    axis : ScalarInput, "d" or None
        Along which it is a place, or a distance.
    family : str
        Of the motion that a margin's critical point is of, where the subject does not say it.
    code : str
        Of an alert, by which it is the same where its title is worded otherwise.
    bound : float
        Error bound of the value.
    scale : float
        Size that a relative tolerance is a share of, where that is larger than the value.
    tolerance : float
        Relative difference that is none, whatever is asked for.
    note : str or Said
        Why there is no value, or a remark.
    finding : bool
        Whether that there is none says something of the device, and not only of what was asked for.
    comparable : bool
        Whether the scenario could have it: False where its sweep is of something else.
    missing : str or Said
        What is said of scenarios that do not have it, before their names.
    """

    group: QuantityGroup
    subject: Text
    value: Any = None
    unit: str = ""
    symbol: str = ""
    axis: Along | None = None
    family: str = ""
    code: str = ""
    bound: float = 0.0
    scale: float = 0.0
    tolerance: float = 0.0
    note: Text = ""
    finding: bool = False
    comparable: bool = True
    missing: Text = ""

    __repr__ = brief

    @property
    def identity(self) -> Hashable:
        """Key of the quantity, equal in two scenarios that both have it."""
        return self.group, self.code or self.subject, self.axis, self.family

    @property
    def is_statement(self) -> bool:
        """Whether it is stated in words or by the scenario, and no number that was computed."""
        return not self.unit

    def with_family(self) -> ComparedQuantity:
        """Put the family into the name, for where another family has a quantity that reads the same."""
        return replace(self, subject=_said("of_family", self.subject, self.family))

    @property
    def name(self) -> Text:
        """The quantity in words, with the symbol that tells it from the same in another unit."""
        return _said("in_symbol", self.subject, self.symbol) if self.symbol else self.subject


STABLE_MOTIONS = ComparedQuantity(
    QuantityGroup.DESIGN_POINT, _said("stable_motions"), unit="1", missing=_said("none_for")
)

RECOVERY = ComparedQuantity(QuantityGroup.DISTURBANCES, _said("recovery"), unit="forcing periods")

LEAST_SHOCK = ComparedQuantity(QuantityGroup.DISTURBANCES, _said("least_shock"), unit="m/s")

DESIGN_VOLTAGE = ComparedQuantity(
    QuantityGroup.VOLTAGE,
    _said("design_voltage"),
    unit="V",
    missing=_said("no_motion_there_for"),
)
"""Voltage at the design point; of several stable motions it is the least, as in requirements."""


class ComparedScenario(Struct, frozen=True, eq=False, dict=True):
    """The quantities of one scenario.

    Attributes
    ----------
    results : Results
    numbered : bool
        Whether the stable ranges have numbers, as they need where any scenario has several.
    measured : MeasuredData or None
        The 1:1 motion that was measured at the design point of this scenario, or else of the first that has one.
    """

    results: Results
    numbered: bool
    measured: MeasuredData | None = None

    @cached_property
    def scenario(self) -> ScenarioKeys:
        """The scenario as it was understood, as far as comparisons read it."""
        return scenario_keys(self.results)

    @cached_property
    def device(self) -> Device:
        """The device, whose swept parameter may be None."""
        scenario = self.scenario
        keys = asdict(scenario) | asdict(scenario.device) | asdict(scenario.excitation)
        keys["harmonics"] = tuple(
            Harmonic.of(harmonic.order, harmonic.percent, harmonic.phase_deg) for harmonic in keys["harmonics"]
        )
        return Device(**{name: keys[name] for name in Device.__struct_fields__})

    @property
    def swept(self) -> Parameter | None:
        """The parameter that is swept."""
        return None if self.scenario.sweep is None else self.scenario.sweep.parameter

    def d(self, parameter: Parameter, value: float) -> float:
        """The group d where a parameter has a value."""
        return float(self.device.groups(parameter, value)[0])

    @cached_property
    def quantities(self) -> Mapping[Hashable, ComparedQuantity]:
        """All that is compared, by its identity."""
        return {quantity.identity: quantity for quantity in _quantities(self)}

    def quantity(self, of: ComparedQuantity) -> ComparedQuantity:
        """Find what this scenario has of a quantity of some scenario, or why it has none."""
        same = self.quantities.get(of.identity)
        if same is not None:
            return same
        if of.is_statement:
            return replace(of, value=None)
        note, finding, comparable = self._absence(of)
        return replace(of, value=None, note=note, finding=finding, comparable=comparable, bound=0.0, scale=0.0)

    def _absence(self, of: ComparedQuantity) -> tuple[Text, bool, bool]:
        """Tell why there is none, whether that is a finding, and whether the scenario could have it."""
        design = self.results.design_point
        others = any(quantity.group is of.group and quantity.axis == of.axis for quantity in self.quantities.values())
        held = self.swept is not None and not self.swept.moves_d and of.axis == "d"
        if of.group is QuantityGroup.MEASURED:
            return NO_STABLE_AT_DESIGN if is_computed(of) else _said("nothing_measured"), False, True
        if of.group is QuantityGroup.MARGIN:
            if design is None or others:
                return NO_DESIGN if design is None else _said("ends_no_range"), False, True
            if held:
                return HELD, False, False
            return _said("no_end") if any(are_stable(design)) else NO_STABLE_AT_DESIGN, False, True
        if self.swept is None:
            return NO_SWEEP, False, True
        if of.axis not in (self.swept, "d"):
            return _said("sweeps", self.swept.quantity), False, False
        if of.group is QuantityGroup.CRITICAL_POINT:
            return _said("no_point"), True, True
        if held:
            return HELD, False, False
        return _said("no_further_range") if others else NO_STABLE, True, True


def compared_scenarios(results: Mapping[str, Results]) -> dict[str, ComparedScenario]:
    """Take what is compared from the results of several scenarios, by their names."""
    numbered = any(len(data.stable_range) > 1 for data in results.values())
    measured = {name: _measured_at_design(data) for name, data in results.items()}
    first = next((by_value for by_value in measured.values() if by_value is not None), None)
    return {name: ComparedScenario(data, numbered, measured[name] or first) for name, data in results.items()}


def _measured_at_design(results: Results) -> MeasuredData | None:
    """The first 1:1 motion that was measured at the design point, if one was."""
    design, measured = results.design_point, results.measured
    if design is None or not measured:
        return None
    kind = "BT", scenario_keys(results).period_ratio
    return next((at for at in measured if (at.word, at.periods) == kind and at.sweep_value == design.value), None)


def are_stable(motions: BranchData | DesignData) -> list[bool]:
    """Tell which motions of a branch or of a design point are stable and admissible."""
    rows = zip(motions.stability, motions.admissible, strict=True)
    return [admissible and stability.attracts for stability, admissible in rows]


def _quantities(scenario: ComparedScenario) -> Iterator[ComparedQuantity]:
    """Read all that is compared; of two quantities of one identity the later one counts."""
    design = scenario.results.design_point
    yield from _stated(scenario.results)
    yield _stable_at_design(design)
    if scenario.swept is not None:
        yield from _critical_points(scenario, scenario.swept)
        yield from _stable_ranges(scenario, scenario.swept)
    if design is not None:
        # Of two motions that end in one way on one side the nearer margin counts, and so comes last.
        yield from reversed(list(_margins(scenario, design.margins)))
    yield from _disturbances(scenario.results)
    yield from _of_additions(scenario.results)
    yield from _measured(scenario)
    yield from _voltages(scenario)


def _stated(results: Results) -> Iterator[ComparedQuantity]:
    """Read what results say that is no number they computed: settings, the types of motions, alerts, requirements."""
    for path, value in _settings(results.scenario):
        yield ComparedQuantity(QuantityGroup.SCENARIO, path, value)
    if (design := results.design_point) is not None:
        motions = zip(design.family, design.stability, are_stable(design), strict=True)
        names = sorted(f"{family} {word}" for family, word, stable in motions if stable)
        yield ComparedQuantity(QuantityGroup.DESIGN_POINT, _said("stable_motion"), ", ".join(names) or "none")
    for alert in results.alerts:
        subject = f"{alert.code} {alert.title}"
        yield ComparedQuantity(QuantityGroup.ALERT, subject, alert.severity, code=alert.code)
    for criterion in results.requirements.criteria if results.requirements is not None else ():
        outcome = "met" if criterion.passed else "not met"
        yield ComparedQuantity(QuantityGroup.REQUIREMENT, f"requirements.{criterion.key}", outcome)


STANDARD_ERRORS = "standard errors"
"""Unit of a difference from what was measured."""

DIMENSIONLESS_VELOCITY = "velocity"
"""Which differs by as many standard errors as that in m/s."""

MEASURED_QUANTITIES = (
    ("velocity_m_s", "m/s"),
    (DIMENSIONLESS_VELOCITY, "1"),
    ("phase_rad", "rad"),
    ("flight_t_c", "1"),
)
"""Names in results.json, which macros have as well, and units, of what is compared of each measured impact."""


def scenario_keys(results: Results) -> ScenarioKeys:
    """What comparisons read of the scenario of results."""
    return convert(results.scenario, ScenarioKeys)


def is_computed(of: ComparedQuantity) -> bool:
    """Whether a quantity of an impact is the one that is computed, which takes no record."""
    return isinstance(of.subject, Said) and of.subject.macro == "computed"


def _measured(scenario: ComparedScenario) -> Iterator[ComparedQuantity]:
    """Read the 1:1 motion that was measured at the design point, what is computed there, and how far they differ.

    A scenario without a record is held against that of the first one that has one.
    """
    records, at_design = scenario.measured, _measured_at_design(scenario.results)
    if records is None:
        return
    for side, impact in enumerate(records.impacts):
        computed = _computed_impact(scenario, side, impact)
        for name, unit in MEASURED_QUANTITIES:
            named = _said(name), impact.membrane
            of = ComparedQuantity(QuantityGroup.MEASURED, _said("measured", *named), unit=unit)
            value, error = getattr(impact, name), getattr(impact, f"{name}_standard_error")
            if at_design is not None:
                # Two that differ by less than their intervals of 95 % do not differ.
                note = _said("standard_error", rounded_text(error, ROUGHLY))
                yield replace(of, value=value, note=note, bound=NORMAL_95 * error)
            if computed is None:
                continue
            yield replace(of, subject=_said("computed", *named), value=computed[name])
            off = value - computed[name]
            if name == "phase_rad":
                off = (off + pi) % (2 * pi) - pi
            if error > 0 and name != DIMENSIONLESS_VELOCITY:
                difference = replace(of, subject=_said("measured_less_computed", *named), unit=STANDARD_ERRORS)
                remark = "" if at_design is not None else _said("of_another_record")
                yield replace(difference, value=off / error, note=remark)


def _computed_impact(scenario: ComparedScenario, side: int, impact: MeasuredImpact) -> dict[str, float] | None:
    """An impact of the stable 1:1 motion at the design point; of several of that nearest to the measured one."""
    design = scenario.results.design_point
    if design is None or not any(stable := are_stable(design)):
        return None
    bottom = design.velocity_bottom, design.phi_bottom_rad
    velocities, phases = bottom if side == 0 else (design.velocity_top, design.phi_top_rad)
    rows = [k for k, attracts in enumerate(stable) if attracts]
    row = min(rows, key=lambda k: abs(velocities[k] - impact.velocity))
    unit = float(scenario.device.velocity_unit(design.parameter, design.value))
    q, ratio = design.q[row], scenario.scenario.period_ratio
    return {
        "velocity_m_s": unit * velocities[row],
        "velocity": velocities[row],
        "phase_rad": phases[row],
        "flight_t_c": 2 * ratio * (q if side == 0 else 1 - q),
    }


def _settings(scenario: Mapping[str, object], path: str = "") -> Iterator[tuple[str, object]]:
    """Read the values of a scenario by their dotted paths, but for what is not given, or has no part in results."""
    for key, value in scenario.items():
        if isinstance(value, list) and value and isinstance(value[0], Mapping):
            value = {str(k): row for k, row in enumerate(value)}
        if isinstance(value, Mapping):
            yield from _settings(value, f"{path}{key}.")
        elif value is not None and f"{path}{key}" not in NOT_COMPARED:
            yield f"{path}{key}", value


def _stable_at_design(design: DesignData | None) -> ComparedQuantity:
    """Count the stable motions at the design point."""
    if design is None:
        return replace(STABLE_MOTIONS, note=NO_DESIGN)
    words = [word for word, stable in zip(design.stability, are_stable(design), strict=True) if stable]
    if not words:
        return replace(STABLE_MOTIONS, note=NO_STABLE, finding=True)
    return replace(STABLE_MOTIONS, value=float(len(words)), note=" and ".join(dict.fromkeys(words)))


def _disturbances(results: Results) -> Iterator[ComparedQuantity]:
    """Read what the device comes to from rest, how fast it recovers, and the least shock, as far as it was computed."""
    disturbances = results.disturbances
    if disturbances is None:
        return
    start, shock = disturbances.from_rest, disturbances.shock or None
    if start is not None and start.outcome is not None:
        words = start.outcome.replace("_1_1", " 1:1 motion").replace("_", " ")
        word = f" ({start.word} every {start.periods} periods)" if start.outcome == "other_motion" else ""
        yield ComparedQuantity(QuantityGroup.DISTURBANCES, _said("from_rest"), words + word)
    if disturbances.recovery_periods is not None:
        bound = disturbances.recovery_error_bound_periods or 0.0
        yield replace(RECOVERY, value=disturbances.recovery_periods, bound=bound)
    else:
        at_event = disturbances.recovery_reason == NoRecovery.AT_EVENT
        yield replace(RECOVERY, note=str(NoRecovery.AT_EVENT) if at_event else NO_STABLE_AT_DESIGN)
    if shock is not None and shock.least_jump_m_s is not None:
        yield replace(LEAST_SHOCK, value=shock.least_jump_m_s)
    elif shock is not None and shock.searched_to_m_s is not None:
        yield replace(LEAST_SHOCK, note=_said("no_shock_up_to", rounded_text(shock.searched_to_m_s)))


def _of_additions(results: Results) -> Iterator[ComparedQuantity]:
    """Read what additions have to be compared."""
    blocks = plain(results.added)
    for name, finding in findings().items():
        for of in finding.compared(blocks):
            subject = Said(of.name, (), name)
            yield ComparedQuantity(QuantityGroup.DISTURBANCES, subject, of.value, of.unit, bound=of.bound, note=of.note)


def bound_in_d(d: float, value: float, bound: float) -> float:
    """Bound the error of d by that of a swept value."""
    # d = 4 M s f^2/F, Eq. (2.5): a relative error of the frequency counts twice, one of a length or a force once.
    return 2 * bound * abs(d / value) if value else 0.0


def _place(group: QuantityGroup, subject: Said, axis: Along, missing: str) -> ComparedQuantity:
    unit, symbol = ("1", "d") if axis == "d" else (axis.unit, axis.symbol)
    return ComparedQuantity(group, subject, unit=unit, symbol=symbol, axis=axis, missing=_said(missing))


def _critical_points(scenario: ComparedScenario, swept: Parameter) -> Iterator[ComparedQuantity]:
    held = "" if swept.moves_d else HELD
    for point in scenario.results.critical_points:
        value, d, bound = point.sweep_value, point.d, point.error_bound
        subject = _said("critical_point", point.label, point.kind.words, point.family)
        in_swept, in_d = (_place(QuantityGroup.CRITICAL_POINT, subject, axis, "no_point_for") for axis in (swept, "d"))
        yield replace(in_swept, value=value, bound=bound)
        yield replace(in_d, value=d, bound=bound_in_d(d, value, bound), note=held)


def _stable_ranges(scenario: ComparedScenario, swept: Parameter) -> Iterator[ComparedQuantity]:
    """Read the ends of stable ranges, the lower one first: where d falls as the value grows, they change places."""
    ranges = [_ends(part) for part in scenario.results.stable_range]
    places: list[tuple[Along, list[list[tuple[float, str, float]]]]] = [(swept, ranges)]
    if swept.moves_d:
        ends_in_d = [
            [(d := scenario.d(swept, value), note, bound_in_d(d, value, bound)) for value, note, bound in ends]
            for ends in ranges
        ]
        places.append(("d", ends_in_d))
    for axis, ends_along in places:
        for number, ends in enumerate(sorted(map(sorted, ends_along)), 1):
            numbered, which = ("numbered_", (number,)) if scenario.numbered else ("", ())
            missing = "no_such_range_for" if scenario.numbered else "no_range_for"
            for word, (value, note, bound) in zip(("from", "to"), ends, strict=True):
                subject = _said(f"{numbered}range_{word}", *which)
                place = _place(QuantityGroup.STABLE_RANGE, subject, axis, missing)
                yield replace(place, value=value, note=note, bound=bound)


def _ends(part: StableRangeData) -> list[tuple[float, str, float]]:
    """Value, reason and error bound of both ends of a stable range."""
    return [
        (part.from_, part.from_reason, part.from_error_bound or 0.0),
        (part.to, part.to_reason, part.to_error_bound or 0.0),
    ]


def _margins(scenario: ComparedScenario, margins: Iterable[MarginData]) -> Iterator[ComparedQuantity]:
    """Read the distances [%] to the critical points that end the stable motions of the design point, nearest first."""
    swept = scenario.swept
    for margin in margins:
        varied, kind, critical = margin.parameter, margin.kind.words, margin.sweep_value
        design = critical - margin.distance
        if not margin.ends_stability or margin.relative is None:
            continue
        shares: list[tuple[Along, float]] = [(varied, margin.relative)]
        if swept is not None and varied.sweepable is swept and swept.moves_d:
            d = scenario.d(swept, design)
            shares.append(("d", (scenario.d(swept, critical) - d) / d))
        for axis, share in shares:
            side, symbol = "below" if share < 0 else "above", "d" if axis == "d" else axis.symbol
            yield ComparedQuantity(
                QuantityGroup.MARGIN,
                _said(f"margin_{side}", kind, symbol),
                100 * share,
                "%",
                axis=axis,
                family=margin.family,
                bound=100 * margin.error_bound / abs(design),
                # A margin is a ratio less 1. The critical and the design value may both be off by the tolerance, and a
                # margin of 0.2 % by 500 times as much of itself.
                scale=200 * abs(critical / design),
            )


def _voltages(scenario: ComparedScenario) -> Iterator[ComparedQuantity]:
    evaluated = scenario.scenario.device.ball_mass_kg is not None
    yield _design_voltage(scenario.results.design_point, evaluated)
    volts = list(_stable_voltages(scenario.results.branches)) if evaluated else []
    for word, choose in (("highest", max), ("lowest", min)):
        extreme = ComparedQuantity(
            QuantityGroup.VOLTAGE,
            _said(f"{word}_voltage"),
            unit="V",
            tolerance=SAMPLED,
            missing=_said("no_motion_for"),
        )
        if scenario.swept is None or not evaluated:
            yield replace(extreme, note=NO_SWEEP if scenario.swept is None else NO_MASS)
        elif volts:
            yield replace(extreme, value=choose(volts))
        else:
            yield replace(extreme, note=_said("no_motion_in_sweep"), finding=True)


def _design_voltage(design: DesignData | None, evaluated: bool) -> ComparedQuantity:
    if design is None or not evaluated:
        return replace(DESIGN_VOLTAGE, note=NO_DESIGN if design is None else NO_MASS)
    u_ave_v, bounds = design.u_ave_v or [], design.error_bounds.get("u_ave_v") or [None] * len(design.stability)
    motions = zip(u_ave_v, bounds, are_stable(design), strict=True)
    volts = [(u, float(bound or 0.0)) for u, bound, stable in motions if stable and u is not None]
    if not volts:
        return replace(DESIGN_VOLTAGE, note=NO_STABLE_AT_DESIGN, finding=True)
    (lowest, bound), (highest, _) = min(volts), max(volts)
    several = highest - lowest > SAME_VOLTAGE * highest
    return replace(DESIGN_VOLTAGE, value=lowest, note=_said("least_of", len(volts)) if several else "", bound=bound)


def _stable_voltages(branches: Iterable[BranchData]) -> Iterator[float]:
    """Read U_ave of the stable motions of branches, and of the critical points beside them, where stability ends."""
    for branch in branches:
        stable = are_stable(branch)
        labels = branch.critical_point or [None] * len(stable)
        for k, (u, label) in enumerate(zip(branch.u_ave_v or (), labels, strict=True)):
            if u is not None and (stable[k] or (label and any(stable[max(k - 1, 0) : k + 2]))):
                yield u
