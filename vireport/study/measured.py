"""Records of measured impacts beside what is computed of the same device at the same values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from hashlib import sha256
from itertools import pairwise
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import Mistake, ScenarioError, UsageError
from vireport.base.progress import Progress
from vireport.base.records import brief
from vireport.measurement.identification import NoFit, Open, Unidentifiable
from vireport.measurement.motion import ForceMaximum, Measured, MeasuredMotion, Quantity, measured
from vireport.measurement.records import Record, Sweepable, parse_record, record_contents
from vireport.motions.stability import discriminant, flight_jacobian, lap_decay, product_trace
from vireport.physics.device import Device
from vireport.physics.groups import Restitutions
from vireport.physics.numbers import ARRAYS
from vireport.physics.word import Word
from vireport.scenario.blocks import Approach, RecordBlock, Scenario
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import Attractor, find_attractor
from vireport.simulation.cycles import SimulatedMotion
from vireport.simulation.events import Impact
from vireport.study.result_records import MeasuredData, MeasuredHysteresis, MeasuredImpact

Floats = NDArray[np.float64]

BUDGET = 20_000
"""Impacts until the motion that a measured state leads to is given up."""

STEP = 1e-5
"""Of the differences that derivatives by what was measured are taken by."""


class Computed(Struct, frozen=True, eq=False):
    """The motion that the device of the scenario comes to from the state that was measured last.

    Attributes
    ----------
    name : str
        Its word and period, or what it is.
    values : ndarray (6, N) or None
        As `MeasuredMotion.values`, where it has the word that was measured.
    differences : ndarray (6, N) or None
        Of the measured values from these, in standard errors.
    """

    name: str
    values: Floats | None = None
    differences: Floats | None = None


class Multipliers(Struct, frozen=True):
    """Trace and discriminant of the linearised return map at a measured 1:1 motion, with standard errors.

    They follow from its velocities, phases and flight times, and from its restitutions: `decay` is the root of the
    determinant.
    """

    trace: float
    trace_error: float
    discriminant: float
    discriminant_error: float
    decay: float


class DrawnImpacts(Struct, frozen=True, eq=False):
    """Impacts that figures show: the mean of each of a motion that repeats itself, or else all of them.

    Attributes
    ----------
    walls : ndarray (n,)
        1 at the bottom, -1 at the top.
    values, errors : ndarray (4, n)
        Velocities just before and just after the impacts [y_c], phase [rad] and time to the next impact [t_c], and
        their standard errors.
    repeats : bool
        Whether the motion repeats itself.
    """

    walls: Floats
    values: Floats
    errors: Floats
    repeats: bool


SHOWN = Quantity.BEFORE, Quantity.AFTER, Quantity.PHASE, Quantity.FLIGHT


class MeasuredAt(Struct, frozen=True, eq=False):
    """What was measured at one value of the swept parameter.

    Attributes
    ----------
    file, sha256 : str
        Of the record.
    value : float
        Of the swept parameter, in its unit; of the length where nothing is swept.
    direction : Approach
        In which the parameter came to it, where that is known.
    from_s, to_s : float
        Times of the first and of the last impact [s].
    impacts : int
        Rows of the record.
    referenced : bool
        Whether the clock of the record knows the force.
    outcome : Measured, NoFit or Open
        What the record shows, or why that is not known.
    time_unit : float
        t_c [s] there.
    computed : Computed or None
    multipliers : Multipliers or None
        Of a motion with one impact on either membrane.
    """

    file: str
    sha256: str
    value: float
    direction: Approach
    from_s: float
    to_s: float
    impacts: int
    referenced: bool
    outcome: Measured | NoFit | Open
    time_unit: float
    computed: Computed | None = None
    multipliers: Multipliers | None = None

    __repr__ = brief

    @property
    def measured(self) -> Measured | None:
        """What the record shows, where that is known."""
        return self.outcome if isinstance(self.outcome, Measured) else None

    @property
    def name(self) -> str:
        """The motion by its word and period; "" where there is none."""
        return self.motion.word.name if self.motion is not None else ""

    @property
    def largest_difference(self) -> float | None:
        """Largest difference from the computed motion in standard errors; None where they cannot be compared."""
        off = None if self.computed is None else self.computed.differences
        return None if off is None or not np.isfinite(off).any() else float(np.abs(off[np.isfinite(off)]).max())

    @property
    def drawn_impacts(self) -> DrawnImpacts | None:
        """What figures show of it; None where nothing is known."""
        measured_impacts, motion = self.measured, self.motion
        if measured_impacts is None:
            return None
        values, errors = (
            (measured_impacts.values, measured_impacts.errors) if motion is None else (motion.values, motion.errors)
        )
        walls = measured_impacts.walls if motion is None else np.array(motion.word.walls, dtype=float)
        return DrawnImpacts(walls, values[list(SHOWN)], errors[list(SHOWN)], motion is not None)

    @property
    def unfit(self) -> NoFit | None:
        """Why no motion of the device fits."""
        return self.outcome if isinstance(self.outcome, NoFit) else None

    @property
    def left_open(self) -> Open | None:
        """Why the record does not tell the motion."""
        return self.outcome if isinstance(self.outcome, Open) else None

    @property
    def motion(self) -> MeasuredMotion | None:
        """The motion, where the record shows one that repeats itself."""
        return self.measured.motion if self.measured is not None else None


class Branching(Struct, frozen=True):
    """A value at which the motion depended on the direction in which the swept parameter came to it.

    Attributes
    ----------
    value : float
    up, down : str
        The motions, by their words and periods.
    """

    value: float
    up: str
    down: str


def hysteresis(records: Sequence[MeasuredAt]) -> tuple[Branching, ...]:
    """The values that were measured upwards and downwards, with motions of different words."""
    names = {(at.value, at.direction): at.name for at in records if at.motion is not None}
    pairs = ((value, up, names.get((value, Approach.DOWN))) for (value, way), up in names.items() if way is Approach.UP)
    return tuple(Branching(value, up, down) for value, up, down in sorted(pairs) if down is not None and down != up)


class _Stretch(Struct, frozen=True, eq=False):
    """The impacts of a record at one value."""

    file: str
    sha256: str
    row: RecordBlock
    record: Record
    value: float
    direction: Approach


def require_records(loaded: Loaded) -> None:
    """Refuse a scenario whose records cannot be used, with every mistake in them.

    Raises
    ------
    ScenarioError
    """
    _stretches(loaded)


def measured_of(loaded: Loaded, say: Progress = lambda what: None) -> tuple[MeasuredAt, ...]:
    """What the records of a scenario show, beside what is computed.

    Parameters
    ----------
    loaded : Loaded
    say : callable
        Is told each step.

    Raises
    ------
    ScenarioError
        If a record cannot be used.
    """
    stretches = _stretches(loaded)
    rows = []
    for number, stretch in enumerate(stretches, 1):
        say(f"measured impacts, {number} of {len(stretches)}")
        rows.append(_measured_at(loaded.scenario, stretch))
    return tuple(rows)


def _stretches(loaded: Loaded) -> list[_Stretch]:
    """All records, each at one value."""
    scenario, mistakes, stretches, more = loaded.scenario, list[Mistake](), list[_Stretch](), 0
    for k, row in enumerate(scenario.measured or ()):
        path = f"measured.{k}.impacts"
        line = loaded.line_of(path) or 0
        try:
            stretches += _of_row(loaded, row)
        except UsageError as error:
            mistakes.append(Mistake(line, path, str(error)))
        except ScenarioError as error:
            mistakes += [Mistake(line, path, mistake.render(error.name)) for mistake in error.mistakes]
            more += error.more
    if mistakes:
        raise ScenarioError(loaded.document.name, mistakes, more)
    return stretches


def _of_row(loaded: Loaded, row: RecordBlock) -> Iterator[_Stretch]:
    scenario, swept = loaded.scenario, loaded.scenario.parameter
    data = record_contents(row.impacts, loaded.place)
    frequency = row.value if swept is Parameter.FREQUENCY and row.value else scenario.excitation.frequency_hz
    swept_range = None
    if scenario.sweep is not None:
        low, high = sorted((scenario.sweep.from_, scenario.sweep.to))
        swept_range = Sweepable(swept, low, high)
        frequency = frequency or low
    record = parse_record(data, row.impacts, float(frequency or 1.0), swept_range, row.record)
    digest, design = sha256(data).hexdigest(), scenario.value_of(swept)
    if record.swept is None:
        value = design if row.value is None else row.value
        if value is None:
            needed = f"its value is not known (value, a column {swept}, or {swept.path})"
            raise UsageError(f"{row.impacts}: {needed}")
        if swept_range is not None and not swept_range.holds(value):
            raise UsageError(f"{row.impacts}: the design point {value:g} is {swept_range.allowed}")
        return iter([_Stretch(row.impacts, digest, row, record, float(value), row.direction)])
    if row.value is not None or row.direction is not Approach.NONE:
        raise UsageError(f"{row.impacts} has a column {swept}: value and direction are in it (leave them out here)")
    if swept is Parameter.FREQUENCY and row.force_maximum_s is not None:
        turned = "where the frequency changes, the phase of the force is not known any more"
        raise UsageError(f"{row.impacts}: {turned} (a file for each frequency, or no force_maximum_s)")
    return _split(digest, row, record, record.swept)


def _split(digest: str, row: RecordBlock, record: Record, values: Floats) -> Iterator[_Stretch]:
    """A record with a column of the swept parameter, by its values."""
    ends = [0, *(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)]
    held = values[ends[:-1]]
    for k, (first, last) in enumerate(pairwise(ends)):
        # The first value is where the sweep starts from.
        step = 0.0 if len(held) == 1 else held[max(k, 1)] - held[max(k, 1) - 1]
        direction = Approach.NONE if step == 0 else Approach.UP if step > 0 else Approach.DOWN
        errors = None if record.errors is None else record.errors[first:last]
        part = replace(
            record, times=record.times[first:last], walls=record.walls[first:last], swept=None, errors=errors
        )
        yield _Stretch(row.impacts, digest, row, part, float(held[k]), direction)


def _measured_at(scenario: Scenario, stretch: _Stretch) -> MeasuredAt:
    row, record, swept = stretch.row, stretch.record, scenario.parameter
    device = Device.of(scenario).with_values({DesignInput(swept.value): stretch.value})
    maximum = None
    if row.force_maximum_s is not None:
        maximum = ForceMaximum(row.force_maximum_s, row.force_maximum_error_s or 0.0)
    measured_motion: Measured | NoFit | Open
    try:
        measured_motion = measured(device, record, scenario.tolerances, maximum)
    except Unidentifiable as refused:
        measured_motion = refused.left_open
    at = MeasuredAt(
        *(stretch.file, stretch.sha256, stretch.value, stretch.direction),
        *(float(record.times[0]), float(record.times[-1]), len(record.times), maximum is not None),
        *(measured_motion, 1 / (2 * float(device.frequency_hz))),
    )
    if not isinstance(measured_motion, Measured):
        return at
    computed, motion = _computed(device, measured_motion), measured_motion.motion
    if motion is None or motion.word != Word((1, -1), device.period_ratio):
        return replace(at, computed=computed)
    return replace(at, computed=computed, multipliers=_multipliers(device, motion))


def _computed(device: Device, measured_motion: Measured) -> Computed | None:
    """What the device comes to from the last state that was measured."""
    before, phase = measured_motion.values[Quantity.BEFORE], measured_motion.values[Quantity.PHASE]
    separated = np.flatnonzero(before * measured_motion.walls > 0)
    if not len(separated):
        return None
    last = separated[-1]
    start = Impact(int(measured_motion.walls[last]), float(before[last]), float(phase[last] % (2 * np.pi)))
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    attractor = find_attractor(groups, start, BUDGET, compiled=False)
    motion, cycle = measured_motion.motion, attractor.cycle
    values = None if motion is None or cycle is None else _in_order(device, attractor, cycle, motion)
    if motion is None or values is None:
        return Computed(attractor.name)
    off = motion.values - values
    off[Quantity.PHASE] = (off[Quantity.PHASE] + np.pi) % (2 * np.pi) - np.pi
    with np.errstate(divide="ignore", invalid="ignore"):
        return Computed(attractor.name, values, off / motion.errors)


def _in_order(device: Device, attractor: Attractor, cycle: SimulatedMotion, motion: MeasuredMotion) -> Floats | None:
    """The values of a cycle in the order of a measured motion of the same word; None of another one."""
    word = Word(tuple(cycle.wall.tolist()), attractor.period)
    if cycle.sticks or word.canonical() != motion.word:
        return None
    groups = device.groups(Parameter.LENGTH, device.length_m)
    unit = float(device.velocity_unit(Parameter.LENGTH, device.length_m))
    after = np.where(cycle.wall > 0, groups.after(1, cycle.velocity), groups.after(-1, cycle.velocity))
    rows = (cycle.velocity, after, cycle.phase, np.roll(cycle.flight, -1), unit * cycle.velocity, unit * after)
    values = np.stack([np.asarray(row, dtype=float) for row in rows])
    # Of the orders that give the word, that of the phases that were measured.
    orders = [np.roll(values, -first, axis=1) for first in word.firsts(motion.word)]
    phases = motion.values[Quantity.PHASE]
    return min(orders, key=lambda order: float(np.sum(1 - np.cos(order[Quantity.PHASE] - phases))))


def _multipliers(device: Device, motion: MeasuredMotion) -> Multipliers:
    """The linearised return map of a 1:1 motion as it was measured, Eqs. (A.1) to (A.4)."""
    groups = device.groups(Parameter.LENGTH, device.length_m)
    gbar = float(groups.gbar)

    def of(measured: Floats) -> Floats:
        """Trace, discriminant and root of the determinant, by the values and the restitutions."""
        (down, up), (phi_bottom, phi_top), (rise, fall) = (
            measured[2 * k : 2 * k + 2] for k in (Quantity.BEFORE, Quantity.PHASE, Quantity.FLIGHT)
        )
        r = Restitutions(*measured[-2:])
        bottom, top = (gbar + groups.wave(phi, ARRAYS).force for phi in (phi_bottom, phi_top))
        jacobian = flight_jacobian(rise, (down, up), (bottom, top), r.bottom)
        back = flight_jacobian(fall, (up, down), (top, bottom), r.top)
        trace, decay = product_trace((jacobian, back)), lap_decay(r)
        return np.array([trace, discriminant(trace, decay), decay], dtype=float)

    at = np.concatenate([motion.values.ravel(), motion.restitutions])
    value, slopes = of(at), np.empty((3, len(at)))
    for k in range(len(at)):
        step = np.zeros(len(at))
        step[k] = STEP
        slopes[:, k] = (of(at + step) - of(at - step)) / (2 * STEP)
    errors = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slopes, motion.covariance, slopes), 0.0))
    return Multipliers(float(value[0]), float(errors[0]), float(value[1]), float(errors[1]), float(value[2]))


def measured_data(records: tuple[MeasuredAt, ...]) -> list[MeasuredData]:
    """What was measured, as results.json has it."""
    return [_data(at) for at in records]


def measured_loops(records: tuple[MeasuredAt, ...]) -> list[MeasuredHysteresis]:
    """The values at which the measured motion depended on the direction, as results.json has them."""
    return [MeasuredHysteresis(sweep_value=at.value, up=at.up, down=at.down) for at in hysteresis(records)]


NAMES = {
    Quantity.BEFORE: "velocity",
    Quantity.AFTER: "velocity_after",
    Quantity.PHASE: "phase_rad",
    Quantity.FLIGHT: "flight_t_c",
    Quantity.BEFORE_SI: "velocity_m_s",
    Quantity.AFTER_SI: "velocity_after_m_s",
}
"""Of quantities in results.json."""


def _data(at: MeasuredAt) -> MeasuredData:
    from vireport.text.templates import Words

    measured_motion, motion = at.measured, at.motion
    return MeasuredData(
        file=at.file,
        sha256=at.sha256,
        sweep_value=at.value,
        direction=None if at.direction is Approach.NONE else at.direction,
        from_s=at.from_s,
        to_s=at.to_s,
        rows=at.impacts,
        clock_referenced=at.referenced,
        reason=None if motion is not None else Words("measured")("reason", at),
        timing_error_s=measured_motion.timing_error_s if measured_motion else None,
        missed=measured_motion.missed if measured_motion else None,
        false=measured_motion.false if measured_motion else None,
        word=motion.word.letters if motion else None,
        periods=motion.word.periods if motion else None,
        computed_motion=at.computed.name if at.computed else None,
        largest_difference=at.largest_difference,
        settled_from_s=motion.from_s if motion else None,
        averaged=motion.impacts if motion else None,
        impacts=[] if motion is None else [_impact(at, motion, k) for k in range(len(motion.word.walls))],
        trace=at.multipliers.trace if at.multipliers else None,
        trace_standard_error=at.multipliers.trace_error if at.multipliers else None,
    )


def _impact(at: MeasuredAt, motion: MeasuredMotion, k: int) -> MeasuredImpact:
    """One impact of a measured motion."""
    values, off = (at.computed.values, at.computed.differences) if at.computed else (None, None)
    numbers: dict[str, Any] = {}
    for quantity, name in NAMES.items():
        difference = None if off is None else float(off[quantity, k])
        numbers |= {
            name: float(motion.values[quantity, k]),
            f"{name}_standard_error": float(motion.errors[quantity, k]),
            f"{name}_computed": None if values is None else float(values[quantity, k]),
            f"{name}_difference": difference if difference is not None and np.isfinite(difference) else None,
        }
    return MeasuredImpact(membrane="bottom" if motion.word.walls[k] > 0 else "top", **numbers)
