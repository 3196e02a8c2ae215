"""Critical points of a sweep with proofs: ball arithmetic encloses each and shows that it exists and is the only one.

The formulae are those that the results come from, evaluated with balls instead of doubles: the motion through
(q, phase), the trace of DP, and the touch of a membrane. What is proved is about the equations and a scenario's
doubles, each taken as the exact number that it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.findings.certificates.results import PRECISIONS, Certificate
from vireport.motions.conditions import Condition
from vireport.motions.diagram import BifurcationDiagram
from vireport.motions.events import Event
from vireport.motions.orbits import Orbits, orbits
from vireport.motions.points import OneToOne, Point
from vireport.motions.stability import lap_decay, return_trace
from vireport.motions.sweep import Held, Level, Sweep, level_residual
from vireport.motions.turning import touches
from vireport.physics.device import NO_GRAVITY
from vireport.physics.groups import Restitution, by_wall, map_restitution
from vireport.physics.motion import Symmetry
from vireport.physics.numbers import ExactFunctions, Functions
from vireport.scenario.parameters import Parameter
from vireport.study.checks.confinement import stays_between
from vireport.study.checks.enclosures import (
    Ball,
    BallOps,
    Root,
    UnprovedError,
    ball,
    bounds,
    gradients,
    precision,
    prove,
)

PLACE = 1e-12
"""Distance (in q, relative to q - 1/2; and in phase) from a point as printed at which what is proved is another one."""

WIDEST = 1e-24
"""Relative radius of the swept value's enclosure above which more bits are taken."""

AT_REST = 1e-12
"""Impact velocity of a polished point below which the impact is one that loses its velocity."""

SHORTEST_FOCUS = 1e-9
"""r^2 down to which the trace at a stated point, in doubles, tells which end of a range of foci it is."""

BRACKETED = 1e-12
"""Relative error bound of a stated swept value above which its polish did not settle."""

FIRST_TRIES = 6
"""Turning points tried as the one that touches a membrane, the nearest first."""

STATED = "u", "phi", "d", "gbar", "velocity_bottom", "velocity_top"
"""The numbers of a point that have error bounds, by their names in `Orbits`."""


def certify(diagram: BifurcationDiagram | None) -> tuple[Certificate, ...]:
    """Prove the critical points of a sweep, in their order.

    Parameters
    ----------
    diagram : BifurcationDiagram or None
        Without a sweep there is nothing to prove.

    Notes
    -----
    A proof that fails is a certificate that says why, never an exception.
    """
    if diagram is None:
        return ()
    diagram.sweep.driven("a proof of critical points").device.of_sine("a proof of critical points")
    return tuple(certify_point(diagram.sweep, critical) for critical in diagram.critical_points)


def certify_point(sweep: Sweep, critical: Point) -> Certificate:
    """Prove one critical point of a sweep, and its mirror image if it has one."""
    if _neglects_gravity(sweep):
        reason = "gravity along the capsule was neglected, so that the equations solved are not the scenario's"
        return Certificate(critical.label, critical.event, False, reason)
    certificate = _certificate(sweep, critical, critical)
    if critical.mirror is None:
        return certificate
    mirror = _certificate(sweep, critical, critical.mirror)
    return replace(certificate, mirror_proved=mirror.proved and mirror.bound_holds)


def _neglects_gravity(sweep: Sweep) -> bool:
    """Whether the capsule of a sweep counts as horizontal though it is slightly inclined."""
    ops = BallOps()
    return sweep.level_in(ops).horizontal and bool(ops.sin_degrees(ball(sweep.device.inclination_deg)) != 0)


def _certificate(sweep: Sweep, critical: Point, point: Point) -> Certificate:
    """Try all candidates with more and more bits; where all fail, the failure of the first, most likely one counts."""
    reason = "no turning point of the ball is near a membrane"
    candidates = list(_candidates(sweep, critical.event, point.closed))
    # More bits are slower, and needed only where conditions nearly coincide.
    for bits in PRECISIONS:
        reasons = []
        for candidate in candidates:
            try:
                with precision(bits):
                    symmetric = critical.symmetry is Symmetry.SYMMETRIC
                    proof = _prove(sweep, point.closed, symmetric, candidate)
                    return _stated(critical, point, proof, bits)
            except UnprovedError as failure:
                reasons.append(str(failure))
        reason = reasons[0] if reasons else reason
    if point.error_bound > BRACKETED * abs(point.sweep_value):
        reason = f"the point is only bracketed, not polished, and {reason}"
    return Certificate(critical.label, critical.event, False, reason)


class Candidate(Struct, frozen=True):
    """A possible condition of a critical point.

    Attributes
    ----------
    condition : Condition
    touch : Touch or None
        For a touch of a membrane, a guess of where it is; without a time, the touch is at the moment at which the
        membrane that was left begins to hold the ball.
    """

    condition: Condition
    touch: Touching | None = None

    @property
    def rest(self) -> int | None:
        """The impact that has no velocity: 0 for the bottom, 1 for the top, None where both have one."""
        return self.condition.rests[0] if self.condition.rests else None


class Touching(Struct, frozen=True):
    """A touch of a membrane: whether in the upward flight, whether of the membrane left, a guess of its time [t_c]."""

    upward: bool
    at_start: bool
    time: float | None


Equations = Callable[[list[Any]], list[Any]]
"""q - 1/2 and phase, or the phase alone of a symmetric motion, and the time of a touch -> residuals, as many."""


def _orbit_at(sweep: Sweep, x: Sequence[Any], symmetric: bool, ops: ExactFunctions) -> Orbits:
    """The motion from its first unknowns: q - 1/2 and phase [rad], or the phase alone of a symmetric motion."""
    r, n = map_restitution(sweep.device.restitution, ops.exact), sweep.device.period_ratio
    return orbits(0 * by_wall(r)[0], x[0], r, n, ops) if symmetric else orbits(x[0], x[1], r, n, ops)


def _equations(sweep: Sweep, candidate: Candidate, symmetric: bool, ops: ExactFunctions) -> Equations:
    """The equations for the unknowns in the closed form: the level of the sweep, and the condition.

    Among the symmetric motions of a horizontal capsule, u = 0 takes the place of the level.
    """
    r, level, own_equation_count = (
        map_restitution(sweep.device.restitution, ops.exact),
        sweep.level_in(ops),
        1 if symmetric else 2,
    )

    def residuals(x: list[Any]) -> list[Any]:
        orbit = _orbit_at(sweep, x, symmetric, ops)
        held = [] if symmetric else [level_residual(level, orbit)]
        return [*held, *_residuals(candidate, orbit, x[own_equation_count:], r, ops)]

    return residuals


def _residuals(candidate: Candidate, orbit: Orbits, more: Sequence[Any], r: Restitution, ops: Functions) -> list[Any]:
    """Residuals of the condition of a critical point, zero where it holds."""
    touch = candidate.touch
    if touch is None:
        if candidate.rest is not None:
            return [orbit.velocity_top if candidate.rest else orbit.velocity_bottom]
        return [candidate.condition.excess(return_trace(orbit, r), lap_decay(r))]
    way = orbit.flights(r)[0 if touch.upward else 1]
    if not more:
        return [-way.pressing(way.cosine)]
    (t,) = more
    sine, cosine = way.turned(ops.sin(ops.pi * t), ops.cos(ops.pi * t))
    covered = way.covered(t, cosine, ops.pi)
    # Divided by the time, the distance to the membrane left is not zero at the start of the flight as well.
    return [way.speed(t, sine, ops.pi), covered / t if touch.at_start else covered - orbit.d]


def _candidates(sweep: Sweep, event: Event, point: OneToOne) -> Iterator[Candidate]:
    r, n = sweep.device.restitution, sweep.device.period_ratio
    orbit = orbits(np.array([point.u]), np.array([point.phi_bottom]), r, n)
    if event is Event.NODE_FOCUS:
        yield Candidate(Condition(event, sign=-1 if return_trace(orbit, r)[0] < 0 else 1))
    elif event is not Event.GRAZING:
        yield Candidate(Condition(event))
    else:
        # With hardly any gravity both velocities are small; the smaller one is that of the grazing impact.
        speeds = sorted([(abs(point.velocity_bottom), 0), (abs(point.velocity_top), 1)])
        resting = [rest for speed, rest in speeds if speed < AT_REST]
        for rest in resting:
            yield Candidate(Condition(Event.ZERO_VELOCITY, (rest,)))
        if not resting:
            yield from (Candidate(Condition(event), touch) for touch in _touching(orbit, r))


def _touching(orbit: Orbits, r: Restitution) -> Iterator[Touching]:
    """Possible touches: turning points near a membrane, the nearest first, then touches shortly after an impact."""
    flights = orbit.flights(r)
    for _, time, upward, at_start in touches(orbit, flights)[:FIRST_TRIES]:
        yield Touching(upward, at_start, time)
    for upward, way, left in zip((True, False), flights, by_wall(r), strict=True):
        acceleration, jerk = float(way.pressing(way.cosine)[0]), float(way.jerk(way.sine)[0])
        if left == 0:
            # The ball leaves at rest, and touches where the membrane begins to hold it.
            yield Touching(upward, True, None)
        elif acceleration * jerk < 0:
            yield Touching(upward, True, -1.5 * acceleration / jerk)


class ProvedPoint(Struct, frozen=True):
    """A proved critical point, with all numbers evaluated over its box.

    Attributes
    ----------
    orbit : Orbits
        Of balls.
    value : ball
        The swept value.
    root : Root
    time : ball or None
        Time of the touch since its flight began [t_c].
    slope : int
        Sign of the trace's slope along the sweep, 0 where none is proved.
    negative : bool
        Whether the trace is proved to be negative.
    admissible : bool or None
    """

    orbit: Orbits
    value: Ball
    root: Root
    slope: int
    negative: bool
    admissible: bool | None


def _prove(sweep: Sweep, point: OneToOne, symmetric: bool, candidate: Candidate) -> ProvedPoint:
    """Prove a point, or say by an `UnprovedError` why not."""
    ops, r, n = BallOps(), map_restitution(sweep.device.restitution, ball), sweep.device.period_ratio
    root = _root(sweep, point, symmetric, candidate)
    (time,) = root.box[1 if symmetric else 2 :] or [None]
    # Where a condition fixes a number exactly, its enclosure by the formulae still has a width: a velocity of zero
    # would have no sign, and a fixed level would seem to vary.
    orbit = _simplified(_orbit_at(sweep, root.box, symmetric, ops), sweep.level_in(ops), candidate.rest, r, n)
    _check_signs(orbit, candidate.rest)
    if time is not None and not 0 < time < (
        orbit.time_up if candidate.touch and candidate.touch.upward else orbit.time_down
    ):
        raise UnprovedError("the touch of the membrane is not within the flight")
    value = sweep.value(sweep.coordinate(orbit), ops)
    if not value.is_finite():
        raise UnprovedError("no value of the swept parameter is proved to give the groups of the motion")
    # Negated: a ball that is not finite fulfils no comparison.
    if not value.rad() <= WIDEST * abs(value):
        raise UnprovedError("the enclosure of the swept value stays wide")
    event = candidate.condition.event
    grazing = event in (Event.GRAZING, Event.ZERO_VELOCITY)
    blurred = event is Event.NODE_FOCUS and not lap_decay(r) > SHORTEST_FOCUS
    return ProvedPoint(
        orbit=orbit,
        value=value,
        root=root,
        slope=0 if grazing or blurred else _slope(sweep, root.box, symmetric),
        negative=not grazing and bool(return_trace(orbit, r) < 0),
        admissible=_admissible(orbit, r, candidate.touch, time, symmetric),
    )


def _root(sweep: Sweep, point: OneToOne, symmetric: bool, candidate: Candidate) -> Root:
    """The one solution near a point of the candidate's condition and the level; its unknowns are q, phase, and more."""
    # For a symmetric motion of a device that is not symmetric, q - 1/2 is rounding about zero, and no scale.
    unknowns = [
        ("q", point.u, abs(point.u) if abs(point.u) > NO_GRAVITY**2 else 1.0),
        ("phase", point.phi_bottom, 1.0),
    ][1 if symmetric else 0 :]
    start, scale = [x for _, x, _ in unknowns], [size for _, _, size in unknowns]
    system = _equations(sweep, candidate, symmetric, BallOps())
    more = [] if candidate.touch is None or candidate.touch.time is None else [candidate.touch.time]
    root = prove(system, [*start, *more], [*scale, *(abs(t) or 1.0 for t in more)])
    for (name, stated, size), x in zip(unknowns, root.box, strict=False):
        # The test proves a solution in its box, not that it is the point that was printed.
        if not abs(x - ball(stated)) <= PLACE * size:
            raise UnprovedError(f"the {name} that solves the equations is not the one stated")
    return root


def _simplified(orbit: Orbits, level: Level, rest: int | None, r: Restitution, n: int) -> Orbits:
    """A motion with the numbers that its conditions fix put in exactly; the velocity at the top follows by (3.8)."""
    gbar = level.value if level.held is Held.GBAR else orbit.gbar
    d = level.value if level.held is Held.D else orbit.d
    at_bottom, at_top = by_wall(r)
    bottom, nothing = orbit.velocity_bottom, 0 * gbar
    if rest is not None:
        bottom = nothing if rest == 0 else 2 * n * gbar / (1 + at_bottom)
    if at_bottom is at_top:
        top = 2 * n * gbar / (1 + at_top) - bottom
    else:
        top = (2 * n * gbar - (1 + at_bottom) * bottom) / (1 + at_top)
    top = nothing if rest == 1 else top
    return replace(orbit, gbar=gbar, d=d, velocity_bottom=bottom, velocity_top=top)


def _check_signs(orbit: Orbits, rest: int | None) -> None:
    # The condition may require an impact without velocity; at q = 1/2 the other one has none either.
    bottom, top = orbit.velocity_bottom, orbit.velocity_top
    moving = bottom > 0 and top < 0
    resting = rest is not None and (bottom > 0 or bottom == 0) and (top < 0 or top == 0)
    if not (moving or resting):
        raise UnprovedError("the impact velocities do not have the signs of a motion")
    if not (orbit.d > 0 and abs(orbit.u) < 0.5):
        raise UnprovedError("the length or a flight time is not positive")


def _admissible(
    orbit: Orbits, r: Restitution, touch: Touching | None, time: Ball | None, symmetric: bool
) -> bool | None:
    """Whether the ball is proved to stay between the membranes, but for a touch; None where that is undecided."""
    inside = []
    for upward, way in zip((True, False), orbit.flights(r), strict=True):
        touching = touch is not None and (symmetric or upward == touch.upward)
        inside.append(stays_between(way, (time, touch.at_start) if touch and touching else None))
    return False if False in inside else None if None in inside else True


def _slope(sweep: Sweep, box: list[Ball], symmetric: bool) -> int:
    """Sign of d trace/d swept value along the curve; 0 where it is not proved, as at a fold."""
    ops, r = BallOps(), map_restitution(sweep.device.restitution, ball)
    level = sweep.level_in(ops)

    def functions(x: list[Any]) -> list[Any]:
        orbit = _orbit_at(sweep, x, symmetric, ops)
        held = [] if symmetric else [level_residual(level, orbit)]
        return [return_trace(orbit, r), sweep.coordinate(orbit), *held]

    slopes = gradients(functions, box[: 1 if symmetric else 2])
    if symmetric:
        (trace,), (coordinate,) = slopes
        product = trace * coordinate
    else:
        trace, coordinate, along_family = slopes
        # Along the curve (dq, dphase) is normal to the gradient of the level. Both derivatives are taken along the
        # same tangent, whose length and direction drop out of the sign of their product.
        product = _cross(along_family, trace) * _cross(along_family, coordinate)
    # The swept value grows with d (with gbar where the inclination is swept), but a swept force falls.
    rising = -1 if sweep.parameter is Parameter.AMPLITUDE else 1
    return rising * (int(product > 0) - int(product < 0))


def _cross(a: Sequence[Ball], b: Sequence[Ball]) -> Ball:
    return a[0] * b[1] - a[1] * b[0]


def _stated(critical: Point, point: Point, proof: ProvedPoint, bits: int) -> Certificate:
    """The certificate of a proved point."""
    orbit, value = proof.orbit, proof.value
    return Certificate(
        label=critical.label,
        kind=critical.event,
        proved=True,
        reason="",
        sweep_value=bounds(value),
        d=bounds(orbit.d),
        gbar=bounds(orbit.gbar),
        q=bounds(0.5 + orbit.u),
        phi_bottom_rad=bounds(orbit.phi),
        velocity_bottom=bounds(orbit.velocity_bottom),
        bits=bits,
        bound_holds=bool(abs(value - ball(point.sweep_value)) <= point.error_bound),
        radius=proof.root.radius,
        side=_side(critical.event, proof.slope, proof.negative),
        admissible=proof.admissible,
        beyond=tuple(name for name in STATED if not _holds(point, name, getattr(orbit, name))),
    )


def _holds(point: Point, name: str, proved: Ball) -> bool:
    """Whether the named number of a point is proved to be within its stated error bound."""
    group_name = "phi_bottom" if name == "phi" else name
    stated = getattr(point, name) if name in ("d", "gbar") else getattr(point.closed, group_name)
    return bool(abs(proved - ball(stated)) <= point.closed.bounds[group_name])


def _side(kind: Event, slope: int, negative: bool) -> str:
    """Which type of motion lies on which side of a critical point, where the sign of the trace's slope is known.

    A motion is stable if its trace is between -(1 + r^4) and 1 + r^4, and a focus if it is between -2 r^2 and 2 r^2,
    with r_b r_t for r^2 where the membranes are not alike.
    """
    if not slope or kind in (Event.FOLD, Event.GRAZING):
        return ""
    type_changes = kind is Event.NODE_FOCUS
    # A period doubling is at the lower bound of the trace, as is a focus with negative trace; all others are at the
    # upper one.
    inward = slope if kind is Event.PERIOD_DOUBLING or (type_changes and negative) else -slope
    return f"{'focus' if type_changes else 'stable'} {'above' if inward > 0 else 'below'}"
