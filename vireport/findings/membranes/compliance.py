"""How far the rigid-impact model is from compliant membranes.

The motion is followed from the rigid one, where the membranes are infinitely stiff, down a ladder of
stiffnesses to the scenario's own. The duration of a contact is proportional to epsilon = K^(-1/(h+1)), so that all
quantities should approach the rigid model at that rate. What the scenario's own membranes change is one table of
quantities, each rigid and compliant; some of them have limits up to which the rigid model is good enough.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from enum import IntEnum, StrEnum
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.progress import WorkStep, portion
from vireport.base.records import ResultsBlock, brief
from vireport.design.compliant.descent import (
    FINEST,
    MULTIPLIER,
    Absence,
    CompliantMotion,
    Continued,
    Rigid,
    descend,
    end_to_follow,
    motion_to_follow,
    rigid_motion,
)
from vireport.design.compliant.model import CompliantModel, compliant_model
from vireport.design.compliant.own_stiffness import LEAST_RESTITUTION, TOO_LOSSY
from vireport.design.compliant.return_map import Bounce
from vireport.design.solution import Solution
from vireport.findings.membranes.solvers import SolverRun, period_of, run_ladder
from vireport.motions.points import Point
from vireport.physics.contact import contacts
from vireport.physics.device import Device
from vireport.physics.energy import Membrane, deflection, generated_voltage
from vireport.physics.groups import by_wall
from vireport.physics.numbers import wrapped
from vireport.scenario.parameters import Parameter
from vireport.text.alerts import Sentence

if TYPE_CHECKING:
    from vireport.base.progress import Progress

MOTIONS_SHARE = 0.1
"""Share of the time that motions and critical points take, as measured; the solvers take the rest."""

FITTED = 3
"""Rungs, the stiffest, from which a rate of convergence is taken: the softer ones still have terms of higher order."""

FLOOR = 1e-8
"""Relative distance from the rigid model below which rounding and differences would have a part in a rate."""

SPEED_LIMITS = 0.01, 0.05
"""Relative shift of an impact velocity: what a careful experiment resolves, and what any does."""

VOLTAGE_LIMITS = 0.05, 0.2
"""Relative shift of U_ave, which grows with a high power of the velocity."""

MARGIN_LIMITS = 0.1, 0.5
"""Shift of the critical point over the design point's distance from it."""


class StiffnessRung(ResultsBlock, frozen=True):
    """The compliant model with the membrane's stiffness times a factor.

    Attributes
    ----------
    factor : 1
        by which K is multiplied
    orbit
        the motion; null where it is lost
    critical_value : as in the scenario
        of `varied`, at the critical point that is followed; null where it is lost, or there is none
    reason
        why one is null; else empty
    """

    factor: float
    orbit: CompliantMotion | None
    critical_value: float | None
    reason: str

    @classmethod
    def of(cls, factor: float, motion: Continued | Absence, critical: Continued | Absence | None) -> StiffnessRung:
        """The rung from the motion and the critical point followed to it; `reason` tells the first that is lost."""
        lost = [followed.reason for followed in (motion, critical) if isinstance(followed, Absence)]
        return cls(
            factor,
            motion.motion if isinstance(motion, Continued) else None,
            float(critical.x[-1]) if isinstance(critical, Continued) else None,
            "there is no period doubling and no fold to follow" if not lost and critical is None else "".join(lost[:1]),
        )


class Convergence(ResultsBlock, frozen=True):
    """How one quantity approaches its rigid value.

    Attributes
    ----------
    quantity
        `velocity`, `phase` or `critical value`
    distances : 1, rad
        from the rigid value on each rung, relative but for the phase; null as there
    exponent : 1
        of K, fitted to the stiffest rungs; null where there are fewer than two above rounding
    """

    quantity: str
    distances: tuple[float | None, ...]
    exponent: float | None


class Grade(IntEnum):
    """How good the rigid model is for a device, in order: a motion has the worst grade of its criteria."""

    GOOD = 0
    CARE = 1
    INSUFFICIENT = 2

    @property
    def words(self) -> str:
        """How good the rigid model is, in a sentence."""
        return ("good enough", "to be used with care", "not good enough")[self]

    @property
    def contradicts(self) -> bool:
        """Whether the compliant membranes contradict the rigid model."""
        return self is Grade.INSUFFICIENT


class ModelCriterion(ResultsBlock, frozen=True):
    """Whether the rigid model is good enough by one quantity.

    Attributes
    ----------
    name
        the quantity, in words
    shift : 1
        from its rigid value: relative, of a critical point over the margin to it
    good, fair : 1
        sizes of the shift up to which the rigid model is good, or fair to use
    grade
        as of the block, by this quantity alone
    """

    name: str
    shift: float
    good: float
    fair: float
    grade: Grade

    @classmethod
    def of(cls, name: str, shift: float, good: float, fair: float) -> ModelCriterion:
        """Grade the rigid model by the size of a shift."""
        size = abs(shift)
        grade = Grade.INSUFFICIENT if size > fair else Grade.CARE if size > good else Grade.GOOD
        return cls(name, shift, good, fair, grade)


class Unit(StrEnum):
    """Unit of a quantity; the first two are the dimensionless units of the model."""

    VELOCITY = "y_c"
    PHASE = "rad"
    SHARE = "of the forcing period"
    RATIO = "1"
    DEPTH = "m"
    VOLTAGE = "V"


class Compared(Struct, frozen=True):
    """A quantity of the motion with rigid and with the scenario's own membranes.

    Attributes
    ----------
    unit : Unit or Parameter
        For a critical point and the margin to it, the parameter that varies.
    compliant : float or None
        None where the critical point is lost.
    criterion : ModelCriterion or None
        None where the rigid model is not judged by this quantity.
    """

    name: str
    unit: Unit | Parameter
    rigid: float
    compliant: float | None
    criterion: ModelCriterion | None = None

    @property
    def of_margin(self) -> bool:
        """Whether the quantity is judged by its shift over the margin to a critical point."""
        return isinstance(self.unit, Parameter)

    @property
    def shift(self) -> float | None:
        """Shift from the rigid value: relative, or in rad for a phase; None where there is no compliant value."""
        if self.compliant is None or not self.rigid:
            return None
        return _shift(self.compliant, self.rigid, self.unit is Unit.PHASE)


class Volts(ResultsBlock, frozen=True):
    """Mean voltage of both impacts with the scenario's own stiffness.

    Attributes
    ----------
    rigid, by_velocity, by_deflection : V
        by the rigid velocities, by those of the compliant motion, and by its deflections
    """

    rigid: float
    by_velocity: float
    by_deflection: float


class Compliance(Struct, frozen=True):
    """What compliant membranes change, and how ODE solvers cope with them.

    Attributes
    ----------
    reason : str
        Why there is nothing to compare, or "".
    rigid : Rigid or None
    critical : Point or None
        The critical point of the rigid model that is followed.
    varied : Parameter
        The parameter that varies towards it.
    design_value : float
        Value of that parameter where the motion is, in its unit.
    order : float
        1/(h+1), the expected exponent of 1/K.
    rungs : tuple of StiffnessRung
        By ascending stiffness.
    convergence : tuple of Convergence
    volts : Volts or None
        With the scenario's own stiffness.
    quantities : tuple of Compared
        With the scenario's own stiffness; empty where the motion is lost.
    runs : tuple of SolverRun
    """

    reason: str = ""
    rigid: Rigid | None = None
    critical: Point | None = None
    varied: Parameter = Parameter.LENGTH
    design_value: float = 0.0
    order: float = 0.0
    rungs: tuple[StiffnessRung, ...] = ()
    convergence: tuple[Convergence, ...] = ()
    volts: Volts | None = None
    quantities: tuple[Compared, ...] = ()
    runs: tuple[SolverRun, ...] = ()

    __repr__ = brief

    @property
    def unscaled(self) -> StiffnessRung | None:
        """The rung with the scenario's own stiffness."""
        return next((rung for rung in self.rungs if rung.factor == 1), None)

    @property
    def criteria(self) -> tuple[ModelCriterion, ...]:
        """The criteria that the rigid model is judged by."""
        return tuple(compared.criterion for compared in self.quantities if compared.criterion is not None)

    @property
    def grade(self) -> Grade | None:
        """The worst grade of the criteria; a lost motion or critical point is the worst. None without a comparison."""
        rung = self.unscaled
        if rung is None:
            return None
        # A lost motion has no shift to be graded, and is worse than any shift.
        if rung.orbit is None or not rung.orbit.stable:
            return Grade.INSUFFICIENT
        if self.critical is not None and rung.critical_value is None:
            return Grade.INSUFFICIENT
        return max(criterion.grade for criterion in self.criteria)


def compliance(
    solution: Solution, ladder: Sequence[float], repeats: int = 3, progress: Progress | None = None
) -> Compliance:
    """Compare the rigid model of a device with its compliant membranes, and try solvers on them.

    Parameters
    ----------
    solution : Solution
    ladder : sequence of float
        Positive factors of K; 1 is added where it is missing.
    repeats : int
        Repetitions of each run, for its median time.
    progress : callable, optional
        Called with each long step as it begins.
    """
    say = progress or (lambda _: None)
    solution.device.of_sine("the ladder of stiffnesses")
    membrane = solution.membrane
    if membrane is None:
        return Compliance("the contact needs the ball's mass: device.ball_mass_kg is not given")
    motion_and_device = rigid_motion(solution)
    if motion_and_device is None:
        return Compliance("there is no stable 1:1 motion whose impacts could be compared")
    rigid, device = motion_and_device
    if min(by_wall(device.restitution)) < LEAST_RESTITUTION:
        return Compliance(TOO_LOSSY.reason, rigid)
    varied, critical = _critical_point(solution, device)
    factors = sorted({1.0, *(float(factor) for factor in ladder)})
    # From the stiffest rung down: there the rigid motion is near enough to start from, and each rung gives the start of
    # the next softer one. Directly from rigid to soft membranes one may come to another motion, or to none.
    say(WorkStep("compliant membranes: periodic motions", 0.0))
    orbits = descend(motion_to_follow(device, membrane, rigid), factors, FINEST)
    say("compliant membranes: critical points")
    values: Sequence[Continued | Absence | None] = [None] * len(factors)
    if critical is not None:
        values = descend(end_to_follow(device, membrane, varied, critical), factors, FINEST)
    rungs = tuple(StiffnessRung.of(*row) for row in zip(factors, orbits, values, strict=True))
    model_at = partial(compliant_model, device, rigid.parameter, rigid.value, membrane)
    comparison = Compliance(
        rigid=rigid,
        critical=critical,
        varied=varied,
        design_value=float(device.value_of(varied)),
        order=1 / (membrane.exponent + 1),
        rungs=rungs,
        convergence=tuple(_convergence(rigid, critical, rungs)),
        runs=tuple(_solver_runs(model_at, rungs, repeats, portion(say, MOTIONS_SHARE, 1.0))),
    )
    if comparison.unscaled is None or comparison.unscaled.orbit is None:
        return comparison
    orbit, model = comparison.unscaled.orbit, model_at()
    volts = _volts(rigid, orbit, model, membrane)
    quantities = (*_motion_rows(rigid, orbit, model), *_voltage_rows(volts), *_critical_rows(comparison))
    return replace(comparison, volts=volts, quantities=quantities)


def _solver_runs(
    model_at: Callable[[float], CompliantModel], rungs: Sequence[StiffnessRung], repeats: int, say: Progress
) -> Iterator[SolverRun]:
    """Run every solver on every rung that has a motion; `model_at` gives the equation for a factor of K."""
    for k, rung in enumerate(rungs):
        if rung.orbit is not None:
            say(WorkStep(f"compliant membranes: solvers at K times {rung.factor:g}", k / len(rungs)))
            yield from run_ladder(period_of(model_at(rung.factor), rung.orbit), rung.factor, repeats)


def _critical_point(solution: Solution, device: Device) -> tuple[Parameter, Point | None]:
    """The parameter that varies, and the critical point that is followed: the nearest period doubling, or else fold."""
    design_value = float(device.value_of(solution.parameter))
    # Grazing has no multiplier by which it could be followed.
    for kind in MULTIPLIER:
        points = [point for point in solution.critical_points if point.event is kind]
        if points:
            return solution.parameter, min(points, key=lambda point: abs(point.sweep_value - design_value))
        if solution.diagram is None and solution.design is not None:
            for margin in solution.design.endings(kind):
                # The restitution is a property of the membranes: along it the ladder would compare other membranes.
                if (varied := margin.parameter.sweepable) is not None and not varied.bounces:
                    return varied, margin.point
    return solution.parameter, None


def _convergence(rigid: Rigid, critical: Point | None, rungs: Sequence[StiffnessRung]) -> Iterator[Convergence]:
    """Distances from the rigid model on all rungs, and the rates at which they vanish as K grows."""

    def of_touches(shift: Callable[[Bounce], float]) -> list[float | None]:
        return [None if rung.orbit is None else shift(rung.orbit.bottom) for rung in rungs]

    at = critical.sweep_value if critical is not None else 1.0
    shifts = {
        "velocity": of_touches(lambda touch: _shift(touch.velocity, rigid.velocity_bottom)),
        "phase": of_touches(lambda touch: _shift(touch.phase, rigid.phase_bottom, phase=True)),
        "critical value": [None if rung.critical_value is None else rung.critical_value / at - 1 for rung in rungs],
    }
    for name, signed in shifts.items():
        values = tuple(None if shift is None else abs(shift) for shift in signed)
        # The stiffest rungs above the noise of the iteration: softer ones have terms of higher order.
        fitted = [(r.factor, e) for r, e in zip(rungs, values, strict=True) if e is not None and e > FLOOR][-FITTED:]
        exponent = None
        if len(fitted) >= 2:
            # A power of K is a straight line of the logarithms: its slope should be -1/(h+1).
            x, y = np.log(np.array(fitted)).T
            exponent = float(np.polyfit(x, y, 1)[0])
        yield Convergence(name, values, exponent)


def _shift(value: float, rigid: float, phase: bool = False) -> float:
    """Relative shift from the rigid value; of phases the difference [rad], in [-pi, pi)."""
    return float(wrapped(value - rigid)) if phase else value / rigid - 1


def _volts(rigid: Rigid, orbit: CompliantMotion, model: CompliantModel, membrane: Membrane) -> Volts:
    """U_ave with the scenario's own stiffness, Eq. (5.1)."""
    touches = orbit.bottom, orbit.top
    depth = model.length_unit * np.array([touch.deflection for touch in touches])
    speeds = (
        model.velocity_unit * np.array([rigid.velocity_bottom, rigid.velocity_top]),
        model.velocity_unit * np.array([touch.velocity for touch in touches]),
        # The velocity that would deflect the membrane as far by (5.5), where the deflection grows as v^(2/(h+1)).
        (depth / deflection(np.array(1.0), membrane)) ** ((membrane.exponent + 1) / 2),
    )
    return Volts(*(float(generated_voltage(speed, membrane).mean()) for speed in speeds))


def _motion_rows(rigid: Rigid, orbit: CompliantMotion, model: CompliantModel) -> Iterator[Compared]:
    """The quantities of the impacts on each membrane, with rigid and with compliant membranes."""
    (r_bottom, r_top), length = by_wall(model.restitution), model.length_unit
    # The rigid deflection is that of (5.5), without damping. A part of its shift is that damping takes energy on the
    # way in: for h = 2.6 the deflection is 3 % less with r = 0.9, 16 % with r = 0.5.
    for name, touch, speed, phase, r in (
        ("bottom", orbit.bottom, rigid.velocity_bottom, rigid.phase_bottom, r_bottom),
        ("top", orbit.top, rigid.velocity_top, rigid.phase_top, r_top),
    ):
        at, depth = f"at the {name}", float(contacts(np.array(speed), model.membrane, r).elastic_deflection)
        criterion = ModelCriterion.of(f"velocity {at}", _shift(touch.velocity, speed), *SPEED_LIMITS)
        yield Compared(f"velocity {at}", Unit.VELOCITY, speed, touch.velocity, criterion)
        yield Compared(f"phase {at}", Unit.PHASE, phase, touch.phase)
        # A forcing period is 2 t_c; a rigid contact takes no time.
        yield Compared(f"contact over forcing period {at}", Unit.SHARE, 0.0, touch.duration / 2)
        yield Compared(f"deflection {at}", Unit.DEPTH, length * depth, length * touch.deflection)
        # Gravity and the force accelerate the ball while it is on the membrane: it does not leave with r times its
        # speed of impact, though the damping is the one that gives r without them.
        yield Compared(f"restitution with the forcing {at}", Unit.RATIO, r, touch.restitution)


def _voltage_rows(volts: Volts) -> Iterator[Compared]:
    name = "U_ave by the velocities"
    criterion = ModelCriterion.of(name, _shift(volts.by_velocity, volts.rigid), *VOLTAGE_LIMITS)
    yield Compared(name, Unit.VOLTAGE, volts.rigid, volts.by_velocity, criterion)
    yield Compared("U_ave by the deflections", Unit.VOLTAGE, volts.rigid, volts.by_deflection)


def _critical_rows(comparison: Compliance) -> Iterator[Compared]:
    """The critical point and the margin to it, judged by the shift over that margin."""
    if comparison.critical is None or comparison.unscaled is None:
        return
    # The shift is divided by the margin, not by the value: a per mille of a length can be half of the margin.
    label, at, value = comparison.critical.label, comparison.critical.sweep_value, comparison.unscaled.critical_value
    varied, side = comparison.varied, 1 if comparison.design_value > at else -1
    # Positive as long as the critical point stays on its side of the design, wherever stable motion is.
    margin = side * (comparison.design_value - at)
    yield Compared(f"{label}, {varied.symbol}", varied, at, value)
    # A design at the critical point has no margin to compare a shift with.
    if value is None or not margin:
        return
    criterion = ModelCriterion.of(label, (value - at) / margin, *MARGIN_LIMITS)
    yield Compared(f"margin to {label}", varied, margin, side * (comparison.design_value - value), criterion)


def moved_or_lost(comparison: Compliance) -> Iterator[Sentence]:
    """Sentences on what the real stiffness of the membranes shifts too far, or else on the motion that it ends."""
    shifts = [
        Sentence("margins", {"name": criterion.name, "margins": abs(criterion.shift)})
        if compared.of_margin
        else Sentence("percent", {"name": criterion.name, "percent": 100 * criterion.shift})
        for compared in comparison.quantities
        if (criterion := compared.criterion) is not None and criterion.grade.contradicts
    ]
    if shifts:
        yield Sentence("moves", {"shifts": shifts})
        return
    rung, critical = comparison.unscaled, comparison.critical
    if critical is not None and rung is not None and rung.orbit is not None and rung.orbit.stable:
        yield Sentence("point_lost", {"label": critical.label})
    else:
        yield Sentence("motion_lost")
