"""The acceptance table: each requirement of a scenario with its limit, the value it is held against, and the outcome.

Each requirement is a row of `REQUIREMENTS`: its keys, its title, the kind and unit of its limit, and the function that
judges it. It is met only where that is certain: what an error bound leaves open, what a failed cross-check puts in
doubt and what cannot be evaluated is not met, and says why.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum, StrEnum
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from vireport.base import NumericalError
from vireport.design import (
    DesignPoint,
    Solution,
    StableInterval,
    motions_at,
    stable_ranges,
)
from vireport.motions import (
    CRITICAL,
    BifurcationDiagram,
    Event,
    Sweep,
    impact_velocities,
    solve,
)
from vireport.physics import (
    UNIT,
    Dielectric,
    Membrane,
    Voltages,
    deflection,
    generated_voltage,
    voltages,
)
from vireport.scenario import Loaded, Parameter, Requirements

if TYPE_CHECKING:
    from vireport.checks import CrossCheck
    from vireport.design import Tolerances
    from vireport.membranes import Compliance
    from vireport.motions import Atlas, Family, Motion

Floats = NDArray[np.float64]

Remark = tuple[str, ...]
"""Parts of a sentence; an input among them is its key in a text and its symbol and unit on a page."""

DIGITS = 6
"""Significant digits of a value; more where it would look like a limit that it is not."""

ROUNDING = 1e-12
"""Relative error up to which the end of a stable range is taken to be known where no error bound is stated."""

SHAKER_ERROR = 10 * UNIT
"""Relative rounding of what the shaker must do: of at most ten operations."""

FOLLOWED_ERROR = 1e-9
"""Relative error of what an impact of a motion that is followed comes to: its velocity is known to some 1e-12, and that
grows with less than its tenth power."""

DISAGREEMENT = "the simulation does not agree with the solution"
"""Why nothing is met where the cross-check fails."""


class Question(StrEnum):
    """What every reader asks."""

    ACCEPTED = "Are the requirements met?"
    MOTION = "Is there stable motion?"
    WHERE = "Where is the 1:1 motion stable?"
    MARGIN = "With what margin?"
    TOLERANCES = "Do all devices within the tolerances work?"
    REACHED = "Which starts reach it?"
    VOLTAGE = "What voltage?"
    SHAKER = "What must the shaker do?"
    RIGID = "Is the rigid model good enough?"
    SIMULATED = "Does the simulation agree?"


class LimitKind(Enum):
    """How a value is held against a limit; the value is the text of the limit."""

    AT_LEAST = "at least {0:.12g} {unit}"
    AT_MOST = "at most {0:.12g} {unit}"
    RANGE = "from {0:.12g} to {1:.12g} {unit}"
    AGREEMENT = "every stable orbit found again to {0:.12g}"
    WORDS = "only {words}"


@dataclass(frozen=True, slots=True, eq=False)
class Limit:
    """What is required: a number or the ends of a range, ascending, with their unit, or the words of motions."""

    kind: LimitKind
    numbers: tuple[float, ...]
    unit: str
    words: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The limit in words, with its unit."""
        return self.kind.value.format(*self.numbers, unit=self.unit, words=" or ".join(self.words))

    @property
    def value(self) -> float:
        """The number of the limit; of a range, its width."""
        return self.numbers[-1] - self.numbers[0] if self.kind is LimitKind.RANGE else self.numbers[0]


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What a requirement comes to.

    Attributes
    ----------
    value : float or None
        None where there is none, or what is required is not known. Of a range, how much of it is covered.
    text : str
        The value, with its unit, or what there is instead.
    margin : float or None
        How far the value is on the right side of the limit, in the limit's unit, negative on the wrong one; of a
        range, how far stable motion goes beyond it.
    passed : bool
    remark : tuple of str
        Where the value comes from, or why the requirement is not met.
    error_bound : float
        Of the value, and so of the margin; a requirement that it leaves undecided is not met.
    """

    value: float | None
    text: str
    margin: float | None
    passed: bool
    remark: Remark = ()
    error_bound: float = 0.0

    @property
    def why(self) -> str:
        """The remark as a sentence, parameters by their keys."""
        return "".join(self.remark)


@dataclass(frozen=True, slots=True, eq=False)
class Criterion:
    """A line of the acceptance table.

    `key` is the first where two belong together; `question` whose answer in the verdict it is held beside; `line` that
    in the scenario's file, None where the limit was set over the file.
    """

    key: str
    title: str
    question: Question
    limit: Limit
    outcome: Outcome
    line: int | None

    @property
    def passed(self) -> bool:
        """Whether the requirement is met."""
        return self.outcome.passed

    @property
    def margin_text(self) -> str:
        """The margin with its sign and unit, "" where there is none."""
        margin = self.outcome.margin
        if margin is None:
            return ""
        digits = max(3, len(f"{abs(margin):.0f}")) if abs(margin) < 1e6 else 3
        return f"{margin:+.{digits}g} {self.limit.unit}".rstrip()

    def to_dict(self) -> dict[str, Any]:
        """The line as results.json has it."""
        limit, outcome = self.limit, self.outcome
        return {
            "key": self.key,
            "title": self.title,
            "limit": limit.text,
            "limit_value": limit.value if limit.numbers else None,
            "unit": limit.unit,
            "value": outcome.value,
            "value_text": outcome.text,
            "margin": outcome.margin,
            "passed": outcome.passed,
            "why": outcome.why,
            "error_bound": outcome.error_bound,
            "line": self.line,
        }


@dataclass(frozen=True, eq=False)
class Evidence:
    """What is known of a scenario: all that requirements, alerts and the verdict are judged by.

    `criteria` are the requirements that were judged already, `required` those that are being judged.
    """

    solution: Solution
    crosscheck: CrossCheck | None = None
    compliance: Compliance | None = None
    tolerances: Tolerances | None = None
    atlas: Atlas | None = None
    criteria: tuple[Criterion, ...] = ()
    required: Requirements = field(default_factory=Requirements)

    @cached_property
    def stable(self) -> list[tuple[Family, Motion]]:
        """The stable motions that are known at the design point, with their families.

        Raises
        ------
        NumericalError
            Where none were followed there.
        """
        design, sweep = self.solution.design, self.solution.sweep
        if self.atlas is None or design is None or sweep is None:
            raise NumericalError("no motions were followed")
        if not min(sweep.start, sweep.end) <= design.value <= max(sweep.start, sweep.end):
            raise NumericalError("the design point is not within the sweep, along which motions are followed")
        return self.atlas.stable_at(design.value)

    @property
    def only_one_to_one(self) -> bool:
        """Whether no motion but 1:1 is to be judged: no other is allowed, or stable at the design point."""
        one_to_one = "BT", self.solution.device.period_ratio
        return not self.required.allowed or all(
            (family.word.letters, family.word.periods) == one_to_one for family, _ in self.stable
        )

    @property
    def design(self) -> DesignPoint:
        """The design point, with stable motion there.

        Raises
        ------
        NumericalError
            Where there is none.
        """
        design = self.solution.design
        if design is None or not design.motions.stable.any():
            raise NumericalError("there is no stable 1:1 motion at the design point")
        return design

    @cached_property
    def impacts(self) -> tuple[Floats, Floats, Floats]:
        """Velocities at the bottom and at the top [m/s] and frequencies [Hz] of the stable motions.

        At the design point where there is one, else along the sweep; empty where no motion is stable.
        """
        solution = self.solution
        groups = [branch.motions for branch in solution.branches]
        columns = [(np.empty(0),) * 3]
        for motions in groups if solution.design is None else [solution.design.motions]:
            stable = motions.stable
            bottom, top = impact_velocities(solution.device, solution.parameter, motions)
            frequency = solution.device.at(solution.parameter, motions.sweep_value)[Parameter.FREQUENCY]
            columns.append((bottom[stable], top[stable], np.broadcast_to(frequency, len(stable))[stable]))
        bottom, top, frequency = (np.concatenate(column) for column in zip(*columns, strict=True))
        return bottom, top, frequency


@dataclass(frozen=True, slots=True, eq=False)
class Requirement:
    """A row of the table of what can be required.

    Attributes
    ----------
    keys : tuple of str
        Of the scenario's block; two where they are the ends of a range.
    title : str
    question : Question
        Which answer of the verdict it is about.
    kind : LimitKind
    unit : str or None
        None for that of the swept parameter.
    judge : callable
        Holds the results against the limit. May raise NumericalError, which then is the remark.
    """

    keys: tuple[str, ...]
    title: str
    question: Question
    kind: LimitKind
    unit: str | None
    judge: Callable[[Evidence, Limit], Outcome]

    def limit(self, results: Evidence) -> Limit | None:
        """What the scenario requires; None where it does not."""
        if self.kind is LimitKind.WORDS:
            allowed = results.required.allowed
            return Limit(self.kind, (), "", allowed) if allowed else None
        given = [getattr(results.required, key) for key in self.keys]
        if self.kind is LimitKind.AGREEMENT:
            given = [results.crosscheck.tolerance if given[0] and results.crosscheck is not None else None]
        if None in given:
            return None
        return Limit(
            self.kind, tuple(sorted(given)), _unit(results.solution.parameter) if self.unit is None else self.unit
        )


def assess(loaded: Loaded, evidence: Evidence) -> tuple[Criterion, ...]:
    """Hold results against what their scenario requires; () where that is nothing."""
    required = loaded.scenario.requirements
    if required is None:
        return ()
    results = replace(evidence, required=required)
    criteria = []
    for requirement in REQUIREMENTS:
        limit = requirement.limit(results)
        if limit is not None:
            lines = (loaded.line_of(f"requirements.{key}") for key in requirement.keys)
            line = next((line for line in lines if line is not None), None)
            outcome = _outcome(results, requirement, limit)
            what = requirement.keys[0], requirement.title, requirement.question
            criteria.append(Criterion(*what, limit, outcome, line))
    return tuple(criteria)


def _outcome(results: Evidence, requirement: Requirement, limit: Limit) -> Outcome:
    """Judge a requirement; one that cannot be judged, or rests on a solution in doubt, is not met."""
    try:
        outcome = requirement.judge(results, limit)
    except NumericalError as error:
        return Outcome(None, "not known", None, False, (str(error),))
    if outcome.passed and results.crosscheck is not None and not results.crosscheck.passed:
        return replace(outcome, passed=False, remark=(DISAGREEMENT,))
    return outcome


def unmet(criteria: Sequence[Criterion]) -> str:
    """Name what is not met, without a full stop; "" where all is."""
    failed = [criterion for criterion in criteria if not criterion.passed]
    if not failed:
        return ""
    names = "; ".join(f"{criterion.title} ({criterion.limit.text})" for criterion in failed)
    count = f"{len(failed)} of {len(criteria)} requirement{'s' if len(criteria) != 1 else ''}"
    return f"{count} {'is' if len(failed) == 1 else 'are'} not met: {names}"


def held(value: float, limit: Limit, remark: Remark = (), bound: float = 0.0) -> Outcome:
    """Hold a number, known to within a bound, against a limit that it must reach or must not exceed."""
    required = limit.value
    margin = value - required if limit.kind is LimitKind.AT_LEAST else required - value
    if margin >= 0 > margin - bound:
        remark = (f"not decided: known to within {bound:.1g} {limit.unit} only; ", *remark)
    return Outcome(value, f"{_apart(value, required)} {limit.unit}", margin, margin - bound >= 0, remark, bound)


def _apart(value: float, limit: float) -> str:
    """Print a number with as many digits as it takes to tell it from the limit that it is not."""
    for digits in range(DIGITS, 18):
        text = f"{value:.{digits}g}"
        if value == limit or float(text) != limit:
            return text
    return repr(value)


def _unit(parameter: Parameter) -> str:
    return "deg" if parameter is Parameter.INCLINATION else parameter.unit


def _swept(results: Evidence) -> BifurcationDiagram:
    if results.solution.diagram is None:
        raise NumericalError("there is no sweep")
    return results.solution.diagram


def _stable_over_inclinations(results: Evidence, limit: Limit) -> Outcome:
    """Judged by the scenario's own sweep where that is of the inclination and goes as far, else by another."""
    diagram, (low, high) = results.solution.diagram, limit.numbers
    if diagram is not None and diagram.sweep.parameter is Parameter.INCLINATION:
        start, end = sorted((diagram.sweep.start, diagram.sweep.end))
        if start <= low and high <= end:
            return _covered(diagram, limit)
    return _covered(solve(Sweep(results.solution.device, Parameter.INCLINATION, 0.0, 90.0)), limit)


def _covered(diagram: BifurcationDiagram, limit: Limit) -> Outcome:
    """Whether one stable range holds a range of the parameter, and ends outside of it for certain."""
    (low, high), unit = limit.numbers, limit.unit
    shared = [part for part in stable_ranges(diagram) if min(part.end, high) > max(part.start, low)]
    if not shared:
        return Outcome(0.0, "nowhere", None, False, ("there is no stable 1:1 motion in the range",))
    widest = max(shared, key=lambda part: min(part.end, high) - max(part.start, low))
    sides = list(_beyond(diagram, widest, low, high))
    margins = [margin for margin, _, _ in sides if margin is not None]
    broken = "; ".join(f"stable motion ends at {end:.9g} {unit} ({what})" for _, end, what in sides if what)
    ranges = ", ".join(f"{part.start:.{DIGITS}g} to {part.end:.{DIGITS}g} {unit}" for part in shared)
    width = sum(min(part.end, high) - max(part.start, low) for part in shared)
    why = broken or ("" if margins else "stable motion ends nowhere in the range looked at")
    return Outcome(width, f"stable from {ranges}", min(margins, default=None), not broken, (why,))


def _beyond(
    diagram: BifurcationDiagram, part: StableInterval, low: float, high: float
) -> Iterator[tuple[float | None, float, str]]:
    """For either end of a stable range: how far it is outside of `low` to `high`, where it is, what is in the way.

    Where the range goes up to the end of the sweep, how far it goes is not known: there is no distance.
    """
    swept = diagram.sweep.start, diagram.sweep.end
    for (value, point), beyond in zip(part.ends, (low - part.start, part.end - high), strict=True):
        if point is not None:
            bound = point.error_bound
            known = f"{point.event.words}, known to within {bound:.1g} {_unit(diagram.sweep.parameter)}"
            yield beyond, value, "" if beyond > bound else known
        elif value in swept and beyond >= 0:
            yield None, value, ""
        else:
            yield beyond, value, "" if beyond > ROUNDING * abs(value) else "end of what is known"


def _margin(results: Evidence, limit: Limit, kinds: tuple[Event, ...]) -> Outcome:
    """Distance of the nearest end of stable motion, of some kinds, in whichever input; without one it is met."""
    design, device = results.design, results.solution.device
    if design.unresolved:
        names = ", ".join(design.unresolved)
        raise NumericalError(f"rounding does not resolve where stable motion ends along {names}")
    measured = [(abs(one.relative), one) for one in design.endings(*kinds) if one.relative is not None]
    if not measured:
        return Outcome(None, "none in any input", None, True)
    relative, nearest = measured[0]
    remark = (f"{nearest.name} at ", nearest.parameter, f" = {nearest.sweep_value:.9g}")
    bound = nearest.error_bound / float(getattr(device, nearest.parameter))
    return held(100 * relative, limit, remark, 100 * bound)


def _at_design(results: Evidence, limit: Limit, columns: tuple[str, ...], scale: float = 1.0) -> Outcome:
    """Hold the worst of the stable motions at the design point against a limit.

    What is held is a column of `Voltages` or `Conversion` times `scale`, or the distance of two, whose errors add up.
    """
    design, bounds = results.design, cast(dict[str, Floats], results.solution.bounds.design)
    holder = design.conversion if hasattr(design.conversion, columns[0]) else design.voltages
    stable, (first, *second) = design.motions.stable, (getattr(holder, name) for name in columns)
    values = scale * (np.abs(first - second[0]) if second else first)[stable]
    least = limit.kind is LimitKind.AT_LEAST
    which = (f"the {'least' if least else 'largest'} of {len(values)} stable motions",) if len(values) > 1 else ()
    bound = scale * sum(float(bounds[name][stable].max()) for name in columns)
    return held(float(values.min() if least else values.max()), limit, which, bound)


def _words(results: Evidence, limit: Limit) -> Outcome:
    """Every stable motion that is known at the design point is an allowed one, in whatever number of periods."""
    from vireport.physics import Word

    mirror = results.solution.horizontal
    allowed = {Word.of(word).canonical(mirror).letters for word in limit.words}
    names = dict.fromkeys(family.name for family, _ in results.stable)
    others = dict.fromkeys(
        family.name for family, _ in results.stable if family.word.canonical(mirror).letters not in allowed
    )
    if not names:
        raise NumericalError("no stable motion is known at the design point")
    why = (f"stable there, and not allowed: {', '.join(others)}",) if others else ()
    return Outcome(None, ", ".join(names), None, not others, why)


def _by_impacts(
    results: Evidence,
    limit: Limit,
    columns: tuple[str, ...],
    of: Callable[[Floats, Membrane], Floats],
    over: Callable[[Floats], float],
) -> Outcome:
    """As for the 1:1 motion; where others are allowed, the worst of those that are stable, by their impacts."""
    if results.only_one_to_one:
        return _at_design(results, limit, columns)
    solution, design = results.solution, cast(DesignPoint, results.solution.design)
    unit = float(solution.device.velocity_unit(design.parameter, design.value))
    each = [of(unit * motion.velocity, cast(Membrane, solution.membrane)) for _, motion in results.stable]
    values = [float(over(own)) for own in each]
    value = (min if limit.kind is LimitKind.AT_LEAST else max)(values)
    remark = (f"of {results.stable[values.index(value)][0].name}",)
    return held(value, limit, remark, FOLLOWED_ERROR * max(float(own.max()) for own in each))


def _field(results: Evidence, limit: Limit) -> Outcome:
    """Judged over the breakdown field."""
    dielectric = cast(Dielectric, cast(Membrane, results.solution.membrane).dielectric)
    percent = 100 / dielectric.breakdown_field_v_m
    return _at_design(results, limit, ("field_v_m",), percent)


def _shaker(results: Evidence, limit: Limit, name: str, error: float = SHAKER_ERROR) -> Outcome:
    """What the shaker must do, by its name in `physics.Shaker`, and the relative error of that."""
    value = getattr(results.solution.shaker, name)
    return held(value, limit, bound=error * value)


def _u_ave_difference(results: Evidence, limit: Limit) -> Outcome:
    """Largest less least U_ave of the stable motions over the range that is required, or over all stable ranges."""
    solution, required, diagram = results.solution, results.required, _swept(results)
    low, high, samples = -np.inf, np.inf, [np.empty(0)]
    if required.stable_from is not None and required.stable_to is not None:
        low, high = sorted((required.stable_from, required.stable_to))
        if not _covered(diagram, Limit(LimitKind.RANGE, (low, high), "")).passed:
            raise NumericalError("there is no stable 1:1 motion over all of the range that is required")
        samples += [_u_ave_at(solution, value) for value in (low, high)]
    bound = 0.0
    for branch, bounds in zip(diagram.branches, solution.bounds.branches, strict=True):
        volts = cast(Voltages, branch.voltages)
        for first, last in branch.stable_runs():
            rows = slice(first, last + 1)
            sampled = volts.average_v[rows]
            value, u_ave = with_peaks(branch.motions.sweep_value[rows], sampled)
            samples.append(u_ave[(value >= low) & (value <= high)])
            # A summit between samples is off by less than it stands above them.
            summit = max(float(u_ave.max() - sampled.max()), float(sampled.min() - u_ave.min()))
            bound = max(bound, summit + float(bounds["average_v"][rows].max()))
    u_ave = np.concatenate(samples)
    if not u_ave.size:
        raise NumericalError("there is no stable 1:1 motion in the sweep")
    least, most = float(u_ave.min()), float(u_ave.max())
    return held(most - least, limit, (f"U_ave from {least:.6g} to {most:.6g} V",), 2 * bound)


def _u_ave_at(solution: Solution, value: float) -> Floats:
    """U_ave of the stable motions at a value of the swept parameter."""
    device = solution.device.with_values({solution.parameter: value})
    motions, _, _ = motions_at(device, solution.parameter)
    velocities = impact_velocities(device, solution.parameter, motions)
    return voltages(*velocities, cast(Membrane, solution.membrane)).average_v[motions.stable]


def with_peaks(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Add to the samples of a smooth curve the summits of the parabolas through three of them, where they have one."""
    moved = np.concatenate([[True], np.diff(x) != 0])
    x, y = x[moved], y[moved]
    if len(x) < 3:
        return x, y
    step, slope = np.diff(x), np.diff(y) / np.diff(x)
    top = np.nonzero(np.sign(slope[1:]) * np.sign(slope[:-1]) < 0)[0]
    before, after = step[top], step[top + 1]
    tangent = (slope[top] * after + slope[top + 1] * before) / (before + after)
    curvature = 2 * (slope[top + 1] - slope[top]) / (before + after)
    middle_x, middle_y = x[top + 1], y[top + 1]
    return (
        np.concatenate([x, middle_x - tangent / curvature]),
        np.concatenate([y, middle_y - tangent * tangent / (2 * curvature)]),
    )


def _yield(results: Evidence, limit: Limit) -> Outcome:
    """The share of the devices within the tolerances that work; known exactly only where it is proved to be all."""
    found = results.tolerances
    if found is None:
        raise NumericalError("there are no tolerances")
    if found.proved:
        return held(100.0, limit, ("every device within the tolerances is proved to have stable motion",))
    sampled = found.sampled
    share = 100 * sampled.stable / sampled.samples
    counted = (f"{sampled.stable} of {sampled.samples} random devices have stable motion",)
    return held(share, limit, counted, share - 100 * sampled.low)


def _agreement(results: Evidence, limit: Limit) -> Outcome:
    check = results.crosscheck
    if check is None:
        raise NumericalError("there is no simulation")
    again = (f"{check.orbits - len(check.misses)} of {check.orbits} stable orbits found again",)
    if not check.orbits:
        return Outcome(None, *again, None, False, ("there was no stable orbit to compare",))
    difference = max(check.velocity_difference, check.phase_difference)
    return Outcome(difference, f"largest difference {difference:.2g}", limit.value - difference, check.passed, again)


MARGINS = {
    "margin_period_doubling_percent": ("Margin to period doubling", (Event.PERIOD_DOUBLING,)),
    "margin_grazing_percent": ("Margin to grazing", (Event.GRAZING,)),
    "margin_any_percent": ("Margin to the end of stable motion", CRITICAL),
}
"""Titles of the margins, and the kinds of critical point that they are to, by their keys."""

AT_LEAST, AT_MOST, RANGE, AGREEMENT, WORDS = LimitKind
_, MOTION, WHERE, MARGIN, TOLERANCES, _, VOLTAGE, SHAKER, _, SIMULATED = Question

U_AVE = partial(_by_impacts, columns=("average_v",), of=generated_voltage, over=np.mean)
END_DIFFERENCE = partial(_by_impacts, columns=("bottom_v", "top_v"), of=generated_voltage, over=np.ptp)
DEFLECTION = partial(_by_impacts, columns=("deflection_m",), of=deflection, over=np.max)
POWER = partial(_at_design, columns=("power_mw",))
ACCELERATION, STROKE = (partial(_shaker, name=name) for name in ("acceleration_g", "stroke_m"))
FORCE = partial(_shaker, name="force_n", error=0.0)  # as it is given

REQUIREMENTS = (
    Requirement(
        ("stable_from", "stable_to"),
        "Stable 1:1 motion over the range",
        WHERE,
        RANGE,
        None,
        lambda results, limit: _covered(_swept(results), limit),
    ),
    Requirement(
        ("inclination_from_deg", "inclination_to_deg"),
        "Stable 1:1 motion over the inclinations",
        WHERE,
        RANGE,
        "deg",
        _stable_over_inclinations,
    ),
    *(
        Requirement((key,), title, MARGIN, AT_LEAST, "%", partial(_margin, kinds=kinds))
        for key, (title, kinds) in MARGINS.items()
    ),
    Requirement(("word", "words"), "Stable motion at the design point", MOTION, WORDS, "", _words),
    Requirement(("u_ave_at_least_v",), "U_ave", VOLTAGE, AT_LEAST, "V", U_AVE),
    Requirement(
        ("u_ave_difference_at_most_v",),
        "Difference of U_ave over the stable range",
        VOLTAGE,
        AT_MOST,
        "V",
        _u_ave_difference,
    ),
    Requirement(
        ("u_bottom_top_difference_at_most_v",),
        "Difference of voltage between the ends",
        VOLTAGE,
        AT_MOST,
        "V",
        END_DIFFERENCE,
    ),
    Requirement(("deflection_at_most_m",), "Deflection", VOLTAGE, AT_MOST, "m", DEFLECTION),
    Requirement(("power_at_least_mw",), "Mean electrical power", VOLTAGE, AT_LEAST, "mW", POWER),
    Requirement(("field_at_most_percent",), "Electric field over breakdown field", VOLTAGE, AT_MOST, "%", _field),
    Requirement(("yield_at_least_percent",), "Yield within the tolerances", TOLERANCES, AT_LEAST, "%", _yield),
    Requirement(("acceleration_at_most_g",), "Acceleration of the shaker", SHAKER, AT_MOST, "g", ACCELERATION),
    Requirement(("stroke_at_most_m",), "Stroke of the shaker", SHAKER, AT_MOST, "m", STROKE),
    Requirement(("force_at_most_n",), "Force of the shaker", SHAKER, AT_MOST, "N", FORCE),
    Requirement(("crosscheck_passed",), "Simulation agrees", SIMULATED, AGREEMENT, "", _agreement),
)
"""All that can be required, in the order of the acceptance table."""
