"""Critical points of a sweep and vertices of an atlas, solved for to the last digit, with error bounds.

The guess is a motion in doubles, from a level curve or a path. At a grazing point, where a turning point of the ball
comes to touch a membrane and a family ends, the touch is solved for as an impact of velocity zero.

Read from `solved_on` on: the motions at the very ends of the sweep, the critical points of a piece of a level curve,
and what both rest on, `solve_one_to_one`; `polished` is the same for motions of any word.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from decimal import Decimal
from functools import partial
from math import atan2, cos, inf, pi, remainder, sin
from sys import float_info
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.records import brief
from vireport.motions.conditions import Condition, Equation, held_at_once, stopped
from vireport.motions.events import Event
from vireport.motions.level_curve import LevelCurve
from vireport.motions.orbits import Orbits
from vireport.motions.periodicity import Varied, model_of, trace
from vireport.motions.pieces import INSET, Piece
from vireport.motions.polish import DECIMALS, FARTHEST, Solved, in_decimals, solve_motion
from vireport.motions.sweep import Sweep
from vireport.motions.turning import near_touch
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion, Symmetry
from vireport.physics.numbers import ARRAYS, FLOATS, DecimalOps, DoubleOps, ExactFunctions
from vireport.physics.word import Word
from vireport.text.formatting import rounded_text

Floats = NDArray[np.float64]

BRACKET = 1e-6
"""Distance in w to either side of an event at which motions bound it where Newton's method in decimals fails."""

BRACKETED = "u", "phi", "d", "gbar", "velocity_bottom", "velocity_top"
"""Numbers of an event that was only bracketed, by the names of `Orbits`."""

BRACKET_ROUNDING = 1e-12
"""Relative rounding of the numbers of an event that was only bracketed."""

TURN_STEP = 1e-4
"""Step of w over which a turn of the sweep's coordinate is distinguished from its going on."""

AT_ONCE = 1e-9
"""Time since an impact [t_c] below which a touch counts as the moment in which the membrane begins to hold the ball:
the relative error of the expansion goes with the time, and the error of the acceleration with its square."""

DETAILS = {
    (Event.PERIOD_DOUBLING, None): "lambda = -1",
    (Event.FOLD, None): "lambda = 1, two motions meet",
    (Event.PITCHFORK, None): "lambda = 1, stability passes from the symmetric motion to two asymmetric ones, or back",
    (Event.NODE_FOCUS, None): "Delta = 0, the type changes between node and focus",
    (Event.GRAZING, None): "a turning point of the ball touches a membrane",
    (Event.STOP, None): "friction stops the ball between two impacts, and the motion is followed no farther",
    (Event.ZERO_VELOCITY, 0): "the impact at the bottom loses its velocity",
    (Event.ZERO_VELOCITY, 1): "the impact at the top loses its velocity",
}
"""What happens to a 1:1 motion at an event, by the impact that has no velocity."""


class OneToOne(Struct, frozen=True):
    """A 1:1 motion in the variables of the closed form.

    Attributes
    ----------
    u : float
        q - 1/2.
    phi_bottom, phi_top : float
        Phase at the impacts [rad], in [0, 2 pi).
    velocity_bottom, velocity_top : float
        Relative velocity just before the impacts [y_c].
    bounds : dict
        Error bounds of these numbers and of d and gbar, by their names.
    """

    u: float
    phi_bottom: float
    phi_top: float
    velocity_bottom: float
    velocity_top: float
    bounds: dict[str, float]

    __repr__ = brief


class Point(Struct, frozen=True, eq=False):
    """A motion at which an event occurs, to the last digit of a double.

    Attributes
    ----------
    event : Event
        `GRAZING` also where an impact has no velocity, which is a touch of the motion without it.
    motion : Motion
        Correctly rounded, with its touches as impacts of velocity zero.
    d, gbar : float
        Correctly rounded.
    sweep_value, error_bound : float
        The swept parameter, in its unit. The bound is inf where the conditions do not settle in decimals, as where
        several events coincide.
    one_to_one : OneToOne or None
        The motion without its touches, where that is a 1:1 motion.
    label : str
        Letter of the event and number in the order of the sweep; "" for a point that is not listed.
    families : tuple of int
        Numbers of the families that it lies on, ascending.
    mirror : Point or None
        The mirror image, for a point on one of two branches that are images of each other.
    """

    event: Event
    motion: Motion
    d: float
    gbar: float
    sweep_value: float
    error_bound: float
    one_to_one: OneToOne | None = None
    label: str = ""
    families: tuple[int, ...] = ()
    mirror: Point | None = None

    def __repr__(self) -> str:
        named = f"Point {self.label}".rstrip()
        return f"<{named}: {self.event.words} at {rounded_text(self.sweep_value)}, d = {rounded_text(self.d)}>"

    @property
    def closed(self) -> OneToOne:
        """The 1:1 motion in the variables of the closed form.

        Raises
        ------
        TypeError
            If this is a point of families of another word.
        """
        if self.one_to_one is None:
            raise TypeError(f"{self.motion.word.letters} is no 1:1 motion")
        return self.one_to_one

    @property
    def symmetry(self) -> Symmetry:
        """Whether a 1:1 motion is its own mirror image."""
        return Symmetry.SYMMETRIC if self.closed.u == 0 else Symmetry.ASYMMETRIC

    @property
    def rest(self) -> int | None:
        """The impact of a 1:1 motion with velocity zero: 0 at the bottom (or both), 1 at the top, None for neither."""
        closed = self.closed
        return 0 if closed.velocity_bottom == 0 else 1 if closed.velocity_top == 0 else None

    @property
    def detail(self) -> str:
        """Name of the event of a 1:1 motion in words."""
        return DETAILS[self.event if self.rest is None else Event.ZERO_VELOCITY, self.rest]


class SolvedPiece(Struct, frozen=True, eq=False):
    """A piece of a level curve with the motions on it that are solved for in decimals, by their rows.

    Attributes
    ----------
    piece : Piece
    orbit : Orbits
        All motions of the piece in doubles; where an impact has no velocity, the motion just before.
    ends : dict
        The motions at the very ends of the sweep, where these cut the piece, by the rows 0 and -1.
    points : dict
        The critical points, with their mirror images.
    """

    piece: Piece
    orbit: Orbits
    ends: dict[int, SweepEnd]
    points: dict[int, Point]


def solved_on(curve: LevelCurve, piece: Piece) -> SolvedPiece:
    """Solve for the ends of the sweep and the critical points on a piece of a level curve."""
    at_events = curve.at(piece.strand, piece.w)
    orbit = _before_rest(curve, piece, at_events)
    ends = _sweep_ends(curve, piece, orbit)
    points = {
        row: _point(curve, piece, row, condition, at_events)
        for row, condition in piece.conditions.items()
        if condition.event is not Event.SWEEP_END
    }
    return SolvedPiece(piece, orbit, ends, points)


def _before_rest(curve: LevelCurve, piece: Piece, orbit: Orbits) -> Orbits:
    """The motions of a piece, those with an impact of velocity zero replaced by the motions just before."""
    # At an impact of velocity zero the trace is infinite and the ball rests at a membrane: the row has the trace just
    # before, and the exact numbers of its point.
    at_rest = [row for row, at in piece.conditions.items() if at.event is Event.ZERO_VELOCITY]
    if not at_rest:
        return orbit
    w, inner = piece.w.copy(), [1 if row == 0 else row - 1 for row in at_rest]
    w[at_rest] += INSET * (piece.w[inner] - piece.w[at_rest])
    return curve.at(piece.strand, w)


def _point(curve: LevelCurve, piece: Piece, row: int, condition: Condition, orbit: Orbits) -> Point:
    """The critical point at a row of a piece, with its mirror image where it has one; `orbit` has all its motions."""
    event = Event.GRAZING if condition.event is Event.ZERO_VELOCITY else condition.event
    if condition.event is Event.GRAZING and curve.level.friction is not None:
        event, condition = Event.STOP, Condition(Event.STOP)
    if event is Event.FOLD and piece.symmetric and not _turns(curve, piece, row):
        event = Event.PITCHFORK
    try:
        return _polished(curve, piece, event, condition, orbit.select([row]))
    except (NumericalError, ArithmeticError):
        near = curve.at(piece.strand, piece.w[row] + BRACKET * np.array([0.0, -1.0, 1.0]))
        return _bracketed(curve, piece, event, condition, near)


def _at_rest(curve: LevelCurve, condition: Condition) -> tuple[int, ...]:
    """The impacts (0 bottom, 1 top) that have no velocity where a condition holds."""
    # Without gravity along the capsule an impact loses its velocity together with the other, by momentum (3.8).
    return (0, 1) if curve.level.horizontal and condition.rests else condition.rests


def _turns(curve: LevelCurve, piece: Piece, row: int) -> bool:
    """Whether the sweep's coordinate has an extremum at a row of a piece: a fold, not a pitchfork."""
    x = curve.sweep.coordinate(curve.at(piece.strand, piece.w[row] + TURN_STEP * np.array([-1.0, 0.0, 1.0])))
    return bool((x[0] - x[1]) * (x[2] - x[1]) > 0)


def _polished(curve: LevelCurve, piece: Piece, event: Event, condition: Condition, orbit: Orbits) -> Point:
    """A critical point solved for in decimals, from the motion as it was located (arrays of length one).

    Raises
    ------
    NumericalError
        If the corrections do not settle.
    """
    sweep, rests, coordinate = curve.sweep, _at_rest(curve, condition), float(curve.sweep.coordinate(orbit)[0])
    with in_decimals():
        motion = motion_of(orbit, curve.plane.n, coordinate)
        solved, touches = solve_one_to_one(partial(model_of, sweep), motion, condition, piece.symmetric)
        value, at_rest = sweep.value(solved.x[-1], DECIMALS), (*rests, *touches)
        point = point_of(solved, event, value, at_rest, touches)
        if not piece.mirrored:
            return point
        # Its bottom impact is the image of the top one.
        top = next(i for i, wall in enumerate(solved.word.walls) if wall == -1 and i not in touches)
        resting, touching = (tuple((i - top) % len(solved.word) for i in impacts) for impacts in (at_rest, touches))
        return replace(point, mirror=point_of(solved.mirrored(top), event, value, resting, touching))


def _bracketed(curve: LevelCurve, piece: Piece, event: Event, condition: Condition, orbit: Orbits) -> Point:
    """A critical point that does not settle in decimals: as it was located, bounded by motions on both sides."""
    rests = _at_rest(curve, condition)
    point = _between(curve, orbit, event, rests)
    if not piece.mirrored:
        return point
    image = curve.plane.orbits(-orbit.u, np.arctan2(orbit.sin_top, orbit.cos_top) + np.pi)
    return replace(point, mirror=_between(curve, image, event, rests))  # without gravity along it both rest, or none


def _between(curve: LevelCurve, orbit: Orbits, event: Event, rests: tuple[int, ...]) -> Point:
    """A point whose numbers are those of the first motion of `orbit`, and whose bounds are the spread of all three."""
    sweep, n = curve.sweep, curve.plane.n

    def spread(values: Floats) -> float:
        return float(np.max(np.abs(values - values[0])) + BRACKET_ROUNDING * abs(values[0]))

    value = np.asarray(sweep.value(sweep.coordinate(orbit)), dtype=float)
    columns = {"phi_bottom" if name == "phi" else name: np.asarray(getattr(orbit, name)) for name in BRACKETED}
    numbers, bounds = {k: float(x[0]) for k, x in columns.items()}, {k: spread(x) for k, x in columns.items()}
    for name in (("velocity_bottom", "velocity_top")[rest] for rest in rests):
        numbers[name] = bounds[name] = 0.0  # by the condition, not what the bracket leaves of it
    motion = motion_of(orbit.select([0]), n, float(sweep.coordinate(orbit)[0]))
    closed = one_to_one(n, numbers, bounds)
    return Point(event, motion, numbers["d"], numbers["gbar"], float(value[0]), spread(value), closed)


class SweepEnd(Struct, frozen=True, eq=False):
    """The motion at an end of the sweep that cuts a piece of the curve.

    Attributes
    ----------
    value : float
        The swept parameter at this end.
    place : (float, float) or None
        q - 1/2 and phase of the motion, correctly rounded; None on a fold, where it does not settle in decimals.
    image_phase : float or None
        Phase of its mirror image, if it has one.
    """

    value: float
    place: tuple[float, float] | None = None
    image_phase: float | None = None


def _sweep_ends(curve: LevelCurve, piece: Piece, orbit: Orbits) -> dict[int, SweepEnd]:
    """The motions at the very ends of the sweep, where these cut a piece, by its rows 0 and -1."""
    # Solved for anew: on the strand the end has no more digits than its parameter gives to the sweep's coordinate,
    # which next to a horizontal capsule are few.
    conditions, last, sweep = piece.conditions, len(piece.w) - 1, curve.sweep
    cut = {row: at for row in (0, -1) if (at := conditions.get(row % (last + 1))) and at.event is Event.SWEEP_END}
    if not cut:
        return {}
    requested = sorted((sweep.coordinate_of(end), end) for end in (sweep.start, sweep.end))
    # Where the range of the curve was narrowed, see `curve_of`, what cuts the piece is not the end of the sweep.
    sides = {row: int(condition.sign > 0) for row, condition in cut.items()}
    ends = {row: requested[side][1] for row, side in sides.items() if curve.bounds[side] == requested[side][0]}
    return {row: _sweep_end(curve, piece, row, value, orbit) for row, value in ends.items()}


def _sweep_end(curve: LevelCurve, piece: Piece, row: int, value: float, orbit: Orbits) -> SweepEnd:
    """The motion at a value of the swept parameter, solved for from a row of a piece."""
    # Next to a fold the phase changes with the root of the coordinate: the end may be farther than `FARTHEST`, but not
    # farther than the next sample.
    reach = abs(remainder(orbit.phi[row] - orbit.phi[1 if row == 0 else -2], 2 * pi))
    with suppress(NumericalError, ArithmeticError), in_decimals():
        solved = _solved_at(curve.sweep, value, orbit.select([row]), piece.symmetric, max(reach, FARTHEST))
        image = place_of(solved.mirrored(1))[1] if piece.mirrored else None
        return SweepEnd(value, place_of(solved), image)
    return SweepEnd(value)


def solve_one_to_one(
    grouped: Callable[[Any], Varied], motion: Motion, condition: Condition, symmetric: bool
) -> tuple[Solved, tuple[int, ...]]:
    """Solve in decimals for a 1:1 motion at which a condition holds; within `in_decimals`.

    Parameters
    ----------
    grouped : callable
        As for `polish.solve_motion`.
    motion : Motion
        A guess, good to a few digits.
    condition : Condition
        The impacts in `rests` are 0 for the bottom and 1 for the top; not needed for grazing.
    symmetric : bool
        Whether the motion is symmetric.

    Returns
    -------
    Solved
    tuple of int
        Numbers of its impacts that are touches.

    Raises
    ------
    NumericalError
        If it does not settle.
    """
    touched: tuple[int, ...] = ()
    if condition.event is Event.STOP and condition.stops is None:
        groups = grouped(FLOATS).at((motion.coordinate,)).as_floats()
        condition = stopped(motion.word, [*motion.velocity.tolist(), *motion.time.tolist()], groups)
    if condition.event is Event.GRAZING:
        touch = near_touch(motion, grouped(FLOATS).at((motion.coordinate,)).as_floats())
        if touch.acceleration is not None:
            solved = solve_motion(grouped, motion, _pressing(motion.word, touch.after, touch.acceleration), symmetric)
            if touch.time < AT_ONCE:  # for r = 0 the ball starts at rest, and touches where the membrane begins to hold
                return solved, ()
            velocity, time = (np.array([float(v) for v in part]) for part in (solved.x[:2], solved.x[2:4]))
            motion = Motion(motion.word, velocity, time, float(solved.x[-1]))
        # Of a symmetric motion the touch half a period later comes with it.
        for after in (1, 0) if symmetric else (touch.after,):
            wall = motion.word.walls[after] if touch.at_start else -motion.word.walls[after]
            motion = motion.with_impact(after, wall, float(motion.time[after]) + touch.time)
        # Not all that have next to no velocity: for r = 0 and a small inclination the impacts themselves have as
        # little, and would be taken for touches.
        touched = (1, 3) if symmetric else (touch.after + 1,)
        condition = Condition(Event.GRAZING, touched)
    return solve_motion(grouped, motion, condition.equation(motion.word), symmetric), touched


def _pressing(word: Word, leaves: int, acceleration: float) -> Equation:
    """The equation that the ball is accelerated towards the membrane of impact `leaves` by a given amount."""
    wall, count = word.walls[leaves], len(word)

    def pressing(x: Sequence[Any], groups: Groups[Any], ops: ExactFunctions) -> Any:
        return wall * groups.pull(groups.wave(ops.pi * x[count + leaves], ops).force) - ops.exact(acceleration)

    return pressing


def point_of(
    solved: Solved, event: Event, value: Decimal, rests: Sequence[int] = (), touches: Sequence[int] = ()
) -> Point:
    """Round a motion in decimals to doubles; within `in_decimals`.

    Parameters
    ----------
    solved : Solved
    event : Event
    value : Decimal
        The swept parameter.
    rests : sequence of int
        Impacts whose velocity is zero by the condition: in decimals a rounding is left of it.
    touches : sequence of int
        Impacts among `rests` that stand for touches of a 1:1 motion.
    """
    word, count = solved.word, len(solved.word)
    velocity = np.array([float(number) for number in solved.x[:count]])
    time = np.array([float(number) for number in solved.x[count : 2 * count]])
    velocity[list(rests)] = 0.0
    d, gbar = float(solved.groups.d), float(solved.groups.gbar)
    rounded = float(value)
    error = max(abs(float(value - Decimal(rounded))), float(np.spacing(abs(rounded))))
    motion = Motion(word, velocity, time, float(solved.x[-1]))
    # A 1:1 motion that grazes has further impacts, its touches: without them it is one in the variables of the closed
    # form.
    struck = [i for i in range(count) if i not in touches]
    if [word.walls[i] for i in struck] != [1, -1]:
        return Point(event, motion, d, gbar, rounded, error)
    bottom, top = struck
    u, phi = place_of(solved, bottom, top)
    numbers = {
        "u": u,
        "phi_bottom": phi,
        "d": d,
        "gbar": gbar,
        "velocity_bottom": float(velocity[bottom]),
        "velocity_top": float(velocity[top]),
    }
    # Rounding to a double is half a spacing; a whole one also covers what the polish has left.
    bounds = {name: float(np.spacing(abs(number))) for name, number in numbers.items()}
    bounds |= {name: 0.0 for i, name in ((bottom, "velocity_bottom"), (top, "velocity_top")) if i in rests}
    return Point(event, motion, d, gbar, rounded, error, one_to_one(word.periods, numbers, bounds))


def place_of(solved: Solved, bottom: int = 0, top: int = 1) -> tuple[float, float]:
    """Place (q - 1/2, phase in [0, 2 pi)) of a 1:1 motion, correctly rounded; within `in_decimals`.

    Parameters
    ----------
    solved : Solved
    bottom, top : int
        Numbers of its impacts on the membranes; all others are touches.
    """
    # q - 1/2 is taken in decimals: next to a horizontal capsule it is as small as gbar, and q itself has none of its
    # digits.
    start, end = (solved.x[len(solved.word) + impact] for impact in (bottom, top))
    # Of a symmetric motion u is zero, not what rounding leaves of it: `Point.symmetry` rests on that.
    u = 0.0 if solved.symmetric else float((end - start) / (2 * solved.word.periods) - Decimal("0.5"))
    if u == 0 and not solved.groups.symmetric:
        u = float_info.min  # of a device without mirror images no motion is one of them: q is 1/2 to rounding
    return u, float(DECIMALS.pi * start % (2 * DECIMALS.pi))


def one_to_one(n: int, numbers: dict[str, float], bounds: dict[str, float]) -> OneToOne:
    """The 1:1 motion with these numbers and bounds, completed by the phase at the top and its bound."""
    u, phi = numbers["u"], numbers["phi_bottom"]
    # The phase at the top is phi + pi T q, T = 2n, so phi + 2 pi n u and n half turns: these as a sign, as a whole turn
    # in doubles is not one, and a phase just below it would become zero, at the other end of a figure.
    moved, way = phi + 2 * pi * n * u, (-1) ** n
    phi_top = atan2(way * sin(moved), way * cos(moved)) % (2 * pi)
    rounding = (10 + 10 * n) * float(np.finfo(float).eps)
    top = {"phi_top": bounds["phi_bottom"] + 2 * np.pi * n * bounds["u"] + rounding}
    return OneToOne(u, phi, phi_top, numbers["velocity_bottom"], numbers["velocity_top"], {**bounds, **top})


def motion_of(orbit: Orbits, n: int, coordinate: float) -> Motion:
    """The impacts of a motion in closed form.

    Parameters
    ----------
    orbit : Orbits
        Numbers, or arrays of length one.
    n : int
        Forcing periods per motion.
    coordinate : float
        Coordinate of the sweep.
    """
    start, up = (float(np.ravel(column)[0]) for column in (orbit.phi, orbit.time_up))
    velocity = np.ravel([orbit.velocity_bottom, orbit.velocity_top])
    return Motion(Word((1, -1), n), velocity, np.array([start / pi, start / pi + up]), coordinate)


def _solved_at(sweep: Sweep, value: float, orbit: Orbits, symmetric: bool, reach: float) -> Solved:
    """Solve in decimals for the motion at a value of the swept parameter; within `in_decimals`.

    Parameters
    ----------
    sweep : Sweep
    value : float
        In the parameter's unit.
    orbit : Orbits
        A guess at the motion.
    symmetric : bool
        Whether the motion is symmetric.
    reach : float
        Farthest that the motion may be from the guess, in time [t_c].

    Raises
    ------
    NumericalError
        If it does not settle.
    """
    coordinates = {ops: sweep.coordinate_of(value, ops) for ops in (DECIMALS, ARRAYS)}

    def equation(x: Sequence[Any], groups: Groups[Any], ops: DoubleOps | DecimalOps) -> Any:
        return x[-1] - coordinates[ops]

    motion = motion_of(orbit, sweep.device.period_ratio, float(np.ravel(sweep.coordinate(orbit))[0]))
    return solve_motion(partial(model_of, sweep), motion, equation, symmetric, reach)


def place_at(sweep: Sweep, value: float, orbit: Orbits, symmetric: bool) -> tuple[float, float]:
    """Place (q - 1/2, phase) of the motion at a value of the swept parameter, correctly rounded.

    Parameters and errors are those of `_solved_at`.
    """
    with in_decimals():
        return place_of(_solved_at(sweep, value, orbit, symmetric, FARTHEST))


def polished(sweep: Sweep, motion: Motion, event: Event) -> Point:
    """The point of an event, solved for in decimals from the motion of any word in doubles.

    Parameters
    ----------
    sweep : Sweep
    motion : Motion
        With its touches as impacts of velocity zero; symmetric where the event is a pitchfork.
    event : Event

    Returns
    -------
    Point
        With the motion in doubles and an infinite error bound if the conditions do not settle.
    """
    model = model_of(sweep, FLOATS)
    x = [*motion.velocity.tolist(), *motion.time.tolist(), motion.coordinate]
    # Delta = tr^2 - 4 det is zero at two traces of opposite sign: the motion in doubles says which.
    sign = -1 if event is Event.NODE_FOCUS and trace(motion.word, x, model) < 0 else 1
    condition = Condition(event, motion.rests, sign)
    if event is Event.GRAZING and not motion.rests:
        condition = held_at_once(motion.time, model.groups(motion.coordinate))
    equation = condition.equation(motion.word)
    with in_decimals():
        try:
            solved = solve_motion(partial(model_of, sweep), motion, equation, event is Event.PITCHFORK)
        except (NumericalError, ArithmeticError):
            d, gbar, *_ = model.groups(motion.coordinate)
            # An infinite bound stands in the results; a point that is left out would not, and its families would
            # lose their vertex.
            return Point(event, motion, float(d), float(gbar), float(sweep.value(motion.coordinate)), inf)
        return point_of(solved, event, sweep.value(solved.x[-1], DECIMALS), motion.rests)
