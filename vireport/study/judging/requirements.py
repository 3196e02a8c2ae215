"""The table of requirements: each is a row, by which a run and a search for the best design judge alike.

A row has the key under which a scenario requires it, the question that it answers, and its quantity. How it limits and
what it needs is declared with the key (`scenario.Demand`), words are in `words/requirements.json`. A requirement is met
only where that is certain: one that an error bound leaves open, that a failed cross-check puts in doubt or that cannot
be evaluated is not met, and says why.

A quantity judges one design by a run's results. For many designs at once, as arrays, it gives the exact value, or only
which designs surely fail; the others are then judged one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache, cached_property
from math import inf
from operator import itemgetter
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.effects import Effect
from vireport.motions.events import CRITICAL, Event
from vireport.physics.device import Shaker
from vireport.physics.numbers import ARRAYS, ROUNDED, UNIT
from vireport.scenario.blocks import (
    DEMANDS,
    UNIT_OF_SWEPT,
    LeftOut,
    RequirementsBlock,
    Scenario,
    unit_of,
)
from vireport.scenario.demands import Demand, LimitKind
from vireport.scenario.keys import names_in_order, value_at
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.judging.designs import Designs, keeps_motion
from vireport.study.judging.evidence import Criterion, Evidence, Judgement, Limit, held_against
from vireport.study.judging.findings import findings, with_results
from vireport.study.judging.impacts import Impacts, at_design, followed, largest, spread
from vireport.study.judging.ranges import (
    may_be_stable_over_inclinations,
    may_be_stable_over_range,
    may_change_little,
    stable_over_inclinations,
    stable_over_range,
    u_ave_difference,
    unit_of_swept,
)
from vireport.text.formatting import OF_INPUTS, percent, rounded_text, stated_text
from vireport.text.patterns import OnPage, Phrase
from vireport.text.requirements import Question, Remark

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

LOCATED_SHARE = 1e-9
"""Of an input, to which the end of a motion with something that the model leaves out is located in doubles."""

SHAKER_ERROR = 10 * UNIT
"""Relative rounding of what the shaker must do: of at most ten operations."""


class OfMotions(Struct, frozen=True, eq=False):
    """A number of each stable motion at the design point, of which the worst counts; exact for arrays of designs.

    Attributes
    ----------
    of : callable
        The number, in the kind of number whose functions are its second argument.
    grows : bool
        Whether the number grows with the speeds of the impacts, with the ball's mass and with the frequency, so that it
        can be bounded over boxes of designs.
    """

    of: Callable[[Impacts, Any], Any]
    grows: bool = False

    def judgement(self, results: Evidence, limit: Limit) -> Judgement:
        """Hold the worst of the stable motions against a limit."""
        if results.only_one_to_one:
            number = self.of(at_design(results), ROUNDED)
            values, bound = number.value.tolist(), float(number.error.max())
            worst = Remark.LEAST if limit.is_least else Remark.LARGEST
            why = worst.said(count=len(values)) if len(values) > 1 else ""
            return held_against(_worst(values, limit), limit, why, bound)
        families, numbers = zip(*((family, self.of(x, ROUNDED)) for family, x in followed(results)), strict=True)
        values = [float(number.value) for number in numbers]
        value, bound = _worst(values, limit), max(float(number.error) for number in numbers)
        return held_against(value, limit, Remark.OF_MOTION.said(motion=families[values.index(value)].name), bound)

    def slack(self, designs: Designs, limit: Limit) -> Floats:
        """Distance of designs from a limit, over it: positive if met, negative if not, NaN without stable motion."""
        return np.asarray(_slack(designs.worst(self.of(designs.impacts, ARRAYS), limit.is_least), limit))

    def may_meet(self, designs: Designs, limit: Limit) -> Mask:
        """Which designs meet a limit; without stable motion none does."""
        return np.asarray(self.slack(designs, limit) >= 0)  # false of NaN


class OfShaker(Struct, frozen=True, eq=False):
    """A demand on the shaker, as a number that never falls with the force and never grows with mass or frequency.

    For a free capsule it depends on the ball's mass, the length and the inclination as well, and may not be monotonic.

    Attributes
    ----------
    of : callable
        The number.
    error : float
        Its relative rounding error.
    """

    of: Callable[[Shaker], Any]
    error: float = SHAKER_ERROR

    def judgement(self, results: Evidence, limit: Limit) -> Judgement:
        """Hold the demand at the design point, or else over the sweep, against a limit."""
        value = self.of(results.solution.shaker)
        return held_against(value, limit, bound=self.error * value)

    def slack(self, designs: Designs, limit: Limit) -> Floats:
        """Distance of designs from a limit, over it: positive if met, negative if not."""
        value = self.of(designs.device.shaker(Parameter.LENGTH, designs.device.length_m))
        return np.broadcast_to(_slack(value, limit), designs.count)

    def may_meet(self, designs: Designs, limit: Limit) -> Mask:
        """Which designs meet a limit."""
        return np.asarray(self.slack(designs, limit) >= 0)


def _worst(values: list[float], limit: Limit) -> float:
    return min(values) if limit.is_least else max(values)


def _slack(value: Any, limit: Limit) -> Any:
    ratio = value / limit.value
    return ratio - 1 if limit.is_least else 1 - ratio


def _place(varied: DesignInput, value: float, results: Evidence) -> OnPage:
    """Where the nearest end of stable motion is: by symbol and unit on a page, by the key in data."""
    text = rounded_text(value, results.exactness)
    return OnPage(f"{varied.marked} = {varied.with_unit(text)}", in_data=f"{varied} = {text}")


class OfMargin(Struct, frozen=True, eq=False):
    """Distance of the nearest end of the stable motion, of some kinds, along any input; met where there is no end.

    A pitchfork at which another motion takes over ends it as well.
    """

    kinds: tuple[Event, ...]

    def judgement(self, results: Evidence, limit: Limit) -> Judgement:
        """Hold the least relative distance against a limit in per cent."""
        if results.solution.on_table:
            return self._on_bottom(results, limit)
        design, device = results.design, results.solution.device
        if design.unresolved_inputs:
            raise NumericalError(Remark.ENDS_UNRESOLVED.said(inputs=", ".join(design.unresolved_inputs)))
        ends = design.limits(*self.kinds)
        nearest = next((end for end in ends if end.relative is not None), None)
        if nearest is None:
            return Judgement(None, Remark.NO_END.said(), None, True)
        place = _place(nearest.parameter, nearest.sweep_value, results)
        bound = nearest.error_bound / float(device.value_of(nearest.parameter))
        return held_against(100 * nearest.size, limit, Remark.END.said(event=nearest.name, place=place), 100 * bound)

    def _on_bottom(self, results: Evidence, limit: Limit) -> Judgement:
        """Hold the distance of the nearest end of a motion on a table against a limit in per cent."""
        if not results.bottom:
            raise NumericalError(Remark.NO_MOTION.said())
        if lost := [x.varied for x in results.bottom if Event.LOST in (x.below, x.above)]:
            raise NumericalError(Remark.ENDS_UNRESOLVED.said(inputs=", ".join(lost)))
        end = next((end for end in results.ends_on_bottom if end.event in self.kinds), None)
        if end is None or end.relative is None:
            return Judgement(None, Remark.NO_END.said(), None, True)
        place = _place(end.varied, end.value, results)
        why = Remark.END.said(event=f"{results.bottom[0].name}, {end.event.words}", place=place)
        return held_against(100 * end.size, limit, why, 100 * LOCATED_SHARE)

    def may_meet(self, designs: Designs, limit: Limit) -> Mask:
        """Which designs may have the margin; all others surely have not."""
        return keeps_motion(designs, limit.value / 100)


class OfRun(Struct, frozen=True, eq=False):
    """A required quantity that is known of one design only, by a run.

    Attributes
    ----------
    judgement : callable
        Holds the results against the limit. It may raise NumericalError, whose text becomes the remark.
    before_run : callable or None
        Tells which of many designs may meet the limit; all others surely do not. None where only a run tells.
    dear : bool
        Whether a run takes half a second or more for it, so that it is judged last in a search.
    """

    judgement: Callable[[Evidence, Limit], Judgement]
    before_run: Callable[[Designs, Limit], Mask] | None = None
    dear: bool = False

    def may_meet(self, designs: Designs, limit: Limit) -> Mask:
        """Which designs may meet a limit, before they are run."""
        return np.ones(designs.count, dtype=bool) if self.before_run is None else self.before_run(designs, limit)


Quantity = OfMotions | OfShaker | OfMargin | OfRun


class Requirement(Struct, frozen=True, eq=False, dict=True):
    """A row of the table of what can be required.

    Attributes
    ----------
    key : str
        Key of the block `requirements`, the first of several that belong together; its pattern is the title.
    question : str
        The question of the verdict that it is about.
    quantity : Quantity
    file : str
        File of the patterns with its title.
    """

    key: str
    question: str
    quantity: Quantity
    file: str = Remark.file

    @property
    def title(self) -> Phrase:
        """Name of the requirement in words."""
        return Phrase(self.file, self.key)

    @cached_property
    def demand(self) -> Demand:
        """The demand that the requirement's key is declared with."""
        return next(demand for demand, keys in DEMANDS.items() if self.key in keys)

    @property
    def dear(self) -> bool:
        """Whether the requirement is judged last in a search, as it takes a run long."""
        return isinstance(self.quantity, OfRun) and self.quantity.dear

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of the scenario's block that give the limit."""
        return DEMANDS[self.demand]

    def limit(self, scenario: Scenario) -> Limit | None:
        """The limit that a scenario sets; None where it does not require this."""
        required, kind = scenario.requirements, self.demand.kind
        if required is None:
            return None
        if kind is LimitKind.WORDS:
            return Limit(kind, (), "", required.allowed) if required.allowed else None
        stated = [getattr(required, key) for key in self.keys]
        if kind is LimitKind.HELD:
            return Limit(kind, (), "") if stated[0] else None
        if kind is LimitKind.AGREEMENT and stated[0]:
            stated = [None if scenario.simulation is None else scenario.simulation.tolerance]
        usual = None in stated and self._usual_holds(scenario)
        if usual:
            stated = [self.demand.usual]
        if None in stated:
            return None
        unit = unit_of(RequirementsBlock.model_fields[self.key])
        unit = unit_of_swept(scenario.parameter) if unit == UNIT_OF_SWEPT else unit
        return Limit(kind, tuple(sorted(stated)), unit, usual=usual)

    def _usual_holds(self, scenario: Scenario) -> bool:
        """Whether there is a usual limit, and the scenario evaluates its quantity."""
        at_design = scenario.value_of(scenario.parameter) is not None
        return (
            self.demand.usual is not None
            and at_design
            and all(value_at(scenario, need) is not None for need in self.demand.needs)
        )


def required(scenario: Scenario) -> Iterator[tuple[Requirement, Limit]]:
    """What a scenario requires, in the order of the acceptance table."""
    for requirement in requirements():
        limit = requirement.limit(scenario)
        if limit is not None:
            yield requirement, limit


SPARED = "sweep", "simulation", "motions", "accuracy"
"""Blocks that many designs of one scenario are judged without, where no requirement needs them."""


def spared(pairs: Iterable[tuple[Requirement, Limit]]) -> set[str]:
    """The blocks of a scenario, of `SPARED`, that no requirement needs in order to be judged."""
    demands = [requirement.demand for requirement, _ in pairs]
    needed = {need.partition(".")[0] for demand in demands for need in demand.needs}
    followed = {"motions"} if any(demand.kind is LimitKind.WORDS for demand in demands) else set()
    return set(SPARED) - needed - followed


def assess(loaded: Loaded, evidence: Evidence) -> tuple[Criterion, ...]:
    """Hold results against the requirements of their scenario; () where it has none."""
    if loaded.scenario.requirements is None:
        return ()
    results = replace(evidence, required=loaded.scenario.requirements)
    criteria = []
    for requirement, limit in required(loaded.scenario):
        judgement = _judgement(results, requirement, limit)
        if limit.usual and judgement.value is None:
            continue  # a usual limit of a quantity that is not known
        lines = (loaded.line_of(f"requirements.{key}") for key in requirement.keys)
        line = next((line for line in lines if line is not None), None)
        what = requirement.key, requirement.title, requirement.question
        criteria.append(Criterion(*what, limit, judgement, line))
    return tuple(criteria)


def _judgement(results: Evidence, requirement: Requirement, limit: Limit) -> Judgement:
    """Judge a requirement; one that cannot be judged, or rests on a solution in doubt, is not met."""
    try:
        judgement = requirement.quantity.judgement(results, limit)
    except NumericalError as error:
        return Judgement(None, Remark.NOT_KNOWN.said(), None, False, error.args[0])
    if judgement.passed and results.crosscheck is not None and not results.crosscheck.passed:
        return replace(judgement, passed=False, why=Remark.DISAGREEMENT.said())
    return judgement


def _words(results: Evidence, limit: Limit) -> Judgement:
    """Judge whether all stable motions known at the design point are allowed, and one of them is reached from rest."""
    mirror, allowed = results.solution.horizontal, results.allowed
    names = dict.fromkeys(family.name for family, _ in results.stable)
    others = dict.fromkeys(
        family.name for family, _ in results.stable if family.word.canonical(mirror).letters not in allowed
    )
    if not names:
        raise NumericalError(Remark.NO_MOTION.said())
    why = [Remark.NOT_ALLOWED.said(motions=", ".join(others))] if others else []
    end, starts_by_itself = results.from_rest, results.is_reached_from_rest
    if end is not None:
        settles = Remark.REACHES if end.settles_after is None else Remark.REACHES_AFTER
        why.append((settles if starts_by_itself else Remark.COMES_TO).said(motion=end.name, periods=end.settles_after))
    if (starts := _share_of_starts(results)) is not None:
        # The share of starts is that of the required words, not of what the device comes to.
        share = Remark.STARTS_TOO if starts_by_itself else Remark.STARTS_TO
        why.append(share.said(words=" or ".join(limit.words), starts=starts))
    remark = Remark.TOGETHER.said(remarks=why) if why else ""
    return Judgement(None, ", ".join(names), None, starts_by_itself and not others, remark)


def _share_of_starts(results: Evidence) -> Phrase | None:
    """How many random starts come to an allowed motion, at the design point or the simulated value nearest to it."""
    for finding, attracting in with_results(results.findings):
        share: Phrase | None = finding.share_of_starts(attracting, results)
        if share is not None:
            return share
    check, design = results.crosscheck, results.solution.design
    if check is None or design is None:
        return None
    row = int(np.argmin(np.abs(check.values - design.value)))
    ends = check.ends[row]
    count = sum(end.cycle is not None and not end.cycle.sticks and results.allows(end.word) for end in ends)
    place = design.parameter.place(float(check.values[row]))
    return Remark.STARTS.said(count=count, total=len(ends), place=place)


def _reached_from_rest(results: Evidence, limit: Limit) -> Judgement:
    """Judge whether the device comes from rest to an allowed motion or, where none is named, to the 1:1 motion."""
    end = results.from_rest
    if end is None:
        raise NumericalError(Remark.NO_DESIGN_POINT.said())
    passed = results.is_reached_from_rest
    after = end.settles_after if passed else None
    return Judgement(None, end.name, None, passed, "" if after is None else Remark.AFTER.said(periods=after))


def _recovery(results: Evidence, limit: Limit) -> Judgement:
    disturbances = results.switched_on
    if disturbances is None or disturbances.recovery is None:
        raise NumericalError(
            Remark.NOT_STABLE.said()
            if disturbances is None or disturbances.no_recovery is None
            else str(disturbances.no_recovery)
        )
    return held_against(disturbances.recovery.periods, limit, bound=disturbances.recovery.error_bound)


def _distortion(results: Evidence, limit: Limit) -> Judgement:
    """Judge the least harmonic that ends stable motion or, where none does, the largest that was tried."""
    distortions = results.solution.design.distortions if results.solution.design is not None else ()
    if not distortions:
        raise NumericalError(Remark.NOT_STABLE.said())
    finite = [harmonic for harmonic in distortions if harmonic.share is not None]
    if not finite:
        return held_against(100 * distortions[0].searched_to, limit, Remark.NO_DISTORTION.said())
    least = min(finite, key=lambda harmonic: harmonic.share or 0.0)
    why = Remark.DISTORTION.said(order=least.order, phase=least.phase_deg)
    return held_against(100 * (least.share or 0.0), limit, why, 100 * (least.error_bound or 0.0))


def _with_effects(results: Evidence, limit: Limit) -> Judgement:
    """Judge the least margin under any of the neglected effects; it is zero where one of them ends stable motion."""
    shifts = results.effects
    if shifts is None or shifts.end is None:
        raise NumericalError(
            Remark.NOT_STABLE.said() if shifts is None or shifts.absence is None else str(shifts.absence)
        )
    for shift in shifts.rows:
        if not shift.computed and shift.least is None:
            raise NumericalError(Remark.EFFECT_OPEN.said(effect=shift.effect.left_out, reason=shift.absence))
    least_margins = [(shift.least, shift.effect) for shift in shifts.rows if shift.least is not None]
    if not least_margins:
        raise NumericalError(Remark.NO_EFFECT.said())
    least, worst = min(least_margins, key=itemgetter(0))
    if least == inf:
        return Judgement(None, Remark.NO_END.said(), None, True)
    size = percent(worst.size, OF_INPUTS, signed=True) if worst.size else ""
    if worst.left_out is LeftOut.RESTITUTION_SPEED:
        size = stated_text(worst.size)
    worst_is = Remark.WITH_EFFECT_OF if size else Remark.WITH_EFFECT
    why = worst_is.said(effect=worst.left_out.replace("_", " "), size=size)
    return held_against(100 * least, limit, why, 100 * LOCATED_SHARE)


def _may_with_effects(designs: Designs, limit: Limit) -> Mask:
    """Which designs may keep a margin under each effect: those that keep it if a membrane has another restitution."""
    kept, device, share = np.ones(designs.count, dtype=bool), designs.device, limit.value / 100
    if device.law is not None or device.rubs:
        return kept
    for effect in Effect.requested(designs.scenario.effects):
        if (varied := effect.left_out.varied) is not None:
            rows = np.flatnonzero(kept)
            part = designs.select(rows)
            value = np.broadcast_to(part.device.value_of(varied) * (1 + effect.size), len(rows))
            kept[rows] = keeps_motion(part.varied({varied: value}), share)
    return kept


def _agreement(results: Evidence, limit: Limit) -> Judgement:
    check = results.crosscheck
    if check is None:
        raise NumericalError(Remark.NO_SIMULATION.said())
    again = Remark.AGAIN.said(count=check.orbits - len(check.misses), total=check.orbits)
    if not check.orbits:
        return Judgement(None, again, None, False, Remark.NO_ORBIT.said())
    difference = max(check.velocity_difference, check.phase_difference)
    text = Remark.DIFFERENCE.said(difference=difference)
    return Judgement(difference, text, limit.value - difference, check.passed, again)


PERIOD_DOUBLING, GRAZING = (OfMargin((kind,)) for kind in (Event.PERIOD_DOUBLING, Event.GRAZING))

U_AVE = OfMotions(lambda motions, _: motions.average_v, grows=True)
END_DIFFERENCE = OfMotions(lambda motions, ops: spread(motions.gains, ops))
DEFLECTION = OfMotions(lambda motions, _: motions.deflection_m, grows=True)
POWER = OfMotions(lambda motions, _: motions.power_mw, grows=True)
DEFLECTION_SHARE = OfMotions(lambda motions, _: 100 / motions.active_radius_m * motions.deflection_m, grows=True)
AREA_RATIO = OfMotions(
    lambda motions, ops: (1 + largest(motions.gains, ops) / motions.bias_voltage_v) ** 0.5, grows=True
)
"""By (5.2) U_imp = (A/A0)^2 Uin."""
EFFICIENCY = OfMotions(lambda motions, _: 100 * motions.efficiency)
FIELD = OfMotions(lambda motions, _: 100 / motions.breakdown_field_v_m * motions.field_v_m, grows=True)

REQUIREMENTS = (
    Requirement("stable_from", Question.WHERE, OfRun(stable_over_range, may_be_stable_over_range)),
    Requirement(
        "inclination_from_deg", Question.WHERE, OfRun(stable_over_inclinations, may_be_stable_over_inclinations)
    ),
    Requirement("margin_period_doubling_percent", Question.MARGIN, PERIOD_DOUBLING),
    Requirement("margin_grazing_percent", Question.MARGIN, GRAZING),
    Requirement("margin_any_percent", Question.MARGIN, OfMargin(CRITICAL)),
    Requirement("word", Question.MOTION, OfRun(_words)),
    Requirement("reached_from_rest", Question.FROM_REST, OfRun(_reached_from_rest)),
    Requirement("recovers_within_periods", Question.FROM_REST, OfRun(_recovery)),
    Requirement("margin_with_effects_percent", Question.MARGIN, OfRun(_with_effects, _may_with_effects, dear=True)),
    Requirement("withstands_distortion_percent", Question.MARGIN, OfRun(_distortion, dear=True)),
    Requirement("u_ave_at_least_v", Question.VOLTAGE, U_AVE),
    Requirement("u_ave_difference_at_most_v", Question.VOLTAGE, OfRun(u_ave_difference, may_change_little)),
    Requirement("u_bottom_top_difference_at_most_v", Question.VOLTAGE, END_DIFFERENCE),
    Requirement("deflection_at_most_m", Question.VOLTAGE, DEFLECTION),
    Requirement("deflection_at_most_percent", Question.VOLTAGE, DEFLECTION_SHARE),
    Requirement("area_ratio_at_most", Question.VOLTAGE, AREA_RATIO),
    Requirement("power_at_least_mw", Question.VOLTAGE, POWER),
    Requirement("efficiency_at_most_percent", Question.VOLTAGE, EFFICIENCY),
    Requirement("field_at_most_percent", Question.VOLTAGE, FIELD),
    Requirement("acceleration_at_most_g", Question.SHAKER, OfShaker(lambda shaker: shaker.acceleration_g)),
    Requirement("stroke_at_most_m", Question.SHAKER, OfShaker(lambda shaker: shaker.stroke_m)),
    Requirement("force_at_most_n", Question.SHAKER, OfShaker(lambda shaker: shaker.force_n, error=0.0)),
    Requirement("crosscheck_passed", Question.SIMULATED, OfRun(_agreement)),
)
"""All that can be required of the core."""


@cache
def requirements() -> tuple[Requirement, ...]:
    """All requirements that a scenario may set, in the order of the keys and of the acceptance table."""
    rows = (*REQUIREMENTS, *(row for finding in findings().values() for row in finding.requirements()))
    order = names_in_order(RequirementsBlock)
    return tuple(sorted(rows, key=lambda row: order.index(row.key)))
