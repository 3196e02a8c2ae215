"""How far a design point is, in every input, from where its stable motions end.

Where a stable motion ends along a line (see `lines`) is solved for in decimals together with the position on the line,
from which the values of the inputs follow exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import cos, inf, log, nan, pi, sin
from typing import Any

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.lines import LINES, Ending, Line, endings, mirrored, model_on_line, stable_ones, value_at
from vireport.motions.conditions import Condition, held_at_once, stopped
from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions
from vireport.motions.periodicity import Varied, linearised
from vireport.motions.points import Point, one_to_one, point_of, solve_one_to_one
from vireport.motions.polish import DECIMALS, Solved, in_decimals
from vireport.physics.device import Device, carried
from vireport.physics.forcing import Harmonic, force_rate, wave
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word
from vireport.scenario.parameters import DesignInput
from vireport.text.formatting import OF_A_MODEL, percent

Floats = NDArray[np.float64]

SAME_POINT = 1e-9
"""Relative difference of two values below which two critical points are one."""

LARGEST_SHARE = 1e100
"""Largest relative margin; beyond it the design value is as good as zero."""


OPEN = 8e-7
"""Error of a position, over 1 + |position|, where an end is located but does not settle in decimals."""

INPUTS = tuple(DesignInput)


class Margin(Struct, frozen=True, eq=False):
    """Distance from the design point to a critical point, when one input varies.

    Attributes
    ----------
    parameter : DesignInput
    point : Point
        Its label is that of the scenario's sweep, "" where it does not lie on it; without a sweep it is only unique
        within one input. It lies on families only if it is one of the sweep's critical points.
    distance : float
        The input's value at the critical point less the design value.
    relative : float or None
        The distance over the design value; None where that is zero, or next to it.
    ends_stability : bool
        Whether a stable motion of the design point ends here, or one that took over from it, and none takes over.
    taken_over : bool
        Whether a stable motion of the design point ends here, and another takes over its stability.
    error_bound : float
        Bound of the error of the value, with the rounding of `distance`.
    derivatives : dict
        Derivatives of the value by each other input, in their units. None where there is none: by the inclination at a
        pitchfork, where the border has a cusp, and at ends of two mirror images or in two mirrored flights, which
        inclination parts. `by_harmonics` has those by cosine and sine of a harmonic, by its order.
    """

    parameter: DesignInput
    point: Point
    distance: float
    relative: float | None
    ends_stability: bool
    error_bound: float
    derivatives: dict[DesignInput, float | None]
    taken_over: bool = False
    by_harmonics: dict[int, tuple[float, float] | None] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<Margin to {self.text}>"

    @property
    def text(self) -> str:
        """The critical point and its place as text, with the distance in per cent or, where there is none, its unit."""
        away = self.parameter.signed(self.distance) if self.relative is None else percent(self.relative, signed=True)
        return f"{self.name} at {self.parameter.place(self.sweep_value, OF_A_MODEL)} ({away})"

    @property
    def size(self) -> float:
        """The relative distance without its sign; infinite where there is none, as of a design value of zero."""
        return inf if self.relative is None else abs(self.relative)

    @property
    def event(self) -> Event:
        """Event at which stable motion ends, or another takes over."""
        return self.point.event

    @property
    def label(self) -> str:
        """Label of the critical point."""
        return self.point.label

    @property
    def name(self) -> str:
        """Event and label of the critical point."""
        return f"{self.event.words} {self.label}".rstrip()

    @property
    def sweep_value(self) -> float:
        """Value of the input at the critical point, in its unit."""
        return self.point.sweep_value


class Margins(Struct, frozen=True, eq=False):
    """Margins of stable motions, and the inputs along which their ends are not resolved.

    Attributes
    ----------
    margins : tuple of Margin
        Margins to where motions end and to where another takes over, nearest first; one for two mirror images that end
        together.
    unresolved : tuple of DesignInput
        Inputs along which rounding does not resolve a motion up to its end.
    """

    margins: tuple[Margin, ...]
    unresolved: tuple[DesignInput, ...]


def margin_at(device: Device, parameter: DesignInput, point: Point) -> Margin:
    """Measure how far a critical point of one input is from a device's value of it.

    Returns
    -------
    Margin
        Without derivatives, and not said to end a stable motion.
    """
    value = float(device.value_of(parameter))
    distance = point.sweep_value - value
    relative = distance / value if abs(distance) < LARGEST_SHARE * value else None
    # The difference of two doubles of different size is rounded once more.
    error = point.error_bound + float(np.spacing(abs(distance)))
    return Margin(parameter, point, distance, relative, False, error, {})


def nearest_first(margins: Iterable[Margin]) -> list[Margin]:
    """Order margins by their relative distance, those without one last; equal ones by their inputs and values."""

    def key(margin: Margin) -> tuple[float, int, float]:
        # Rounded to twelve digits, so that margins equal but for rounding keep the order of their inputs.
        return float(f"{margin.size:.12g}"), INPUTS.index(margin.parameter), margin.sweep_value

    return sorted(margins, key=key)


def margins_of(
    device: Device, motions: Motions, lines: Sequence[Line] = LINES, signs: tuple[float, ...] = (-1.0, 1.0)
) -> Margins:
    """Find where the stable motions of a design point end, in every input and both directions.

    Parameters
    ----------
    device : Device
        With all four parameters.
    motions : Motions
        At the design point.
    lines : sequence of Line
        Lines along which they are followed.
    signs : tuple of float
        Directions of the position on the lines, 1 or -1.
    """
    margins: list[Margin] = []
    unresolved: list[DesignInput] = []
    for end in endings(device, stable_ones(device, motions), lines, signs):
        if end.event is Event.LOST:
            unresolved += end.inputs
        elif end.event is not Event.SWEEP_END:
            margins += _margins_at(device, end)
    return Margins(tuple(nearest_first(margins)), tuple(dict.fromkeys(unresolved)))


def _margins_at(device: Device, end: Ending) -> list[Margin]:
    """Margins to the end of a motion on a line, one in each input that moves the device along it."""
    ended = {"ends_stability": not end.taken_over, "taken_over": end.taken_over}
    # A margin is a difference: next to an end the digits that doubles leave would cancel.
    with in_decimals():
        try:
            solved, rests, touches = solved_end(
                lambda ops: model_on_line(end.line, device, ops), device.period_ratio, end.event, end.x, end.symmetric
            )
        except (NumericalError, ArithmeticError):
            bracketed = {varied: margin_at(device, varied, _bracketed(device, varied, end)) for varied in end.inputs}
            return [
                replace(margin, derivatives={other: None for other in DesignInput if other is not varied}, **ended)
                for varied, margin in bracketed.items()
            ]
        normal, margins = normal_of(_in_doubles(solved), solved.groups.as_floats(), end.event, rests), []
        event = Event.GRAZING if end.event is Event.ZERO_VELOCITY else end.event
        for varied in end.inputs:
            value = value_at(device, varied, solved.x[-1], solved.groups, DECIMALS)
            margin = margin_at(device, varied, point_of(solved, event, value, rests, touches))
            derivatives, by_harmonics = _derivatives(device, varied, margin.point, normal)
            if mirrored(device) and end.line.keeps_symmetry:
                # Tilted to either side, a fold of symmetric motions moves alike; other ends come in pairs that part.
                derivatives[DesignInput.INCLINATION] = 0.0 if end.symmetric and event is Event.FOLD else None
                if not (end.symmetric and event is Event.FOLD):
                    derivatives |= {DesignInput.RESTITUTION_BOTTOM: None, DesignInput.RESTITUTION_TOP: None}
                    by_harmonics |= {order: None for order in by_harmonics if order % 2 == 0}
            margins.append(replace(margin, derivatives=derivatives, by_harmonics=by_harmonics, **ended))
        return margins


def end_motion(n: int, x: Floats) -> Motion:
    """A 1:1 motion of n forcing periods from unknowns x on a line: two velocities, two times and the position."""
    return Motion(Word((1, -1), n), x[:2], x[2:4], float(x[-1]))


def _in_doubles(solved: Solved) -> Motion:
    """A motion that was solved for in decimals, rounded to doubles."""
    count = len(solved.word)
    velocity, time = (np.array([float(x) for x in solved.x[k : k + count]]) for k in (0, count))
    return Motion(solved.word, velocity, time, float(solved.x[-1]))


def resting(event: Event, x: Floats, symmetric: bool) -> tuple[int, ...]:
    """Numbers of the impacts, 0 bottom and 1 top, whose velocity vanishes where a 1:1 motion ends."""
    if event is not Event.ZERO_VELOCITY:
        return ()
    return (0, 1) if symmetric else (int(np.argmin(np.abs(x[:2]))),)


def solved_end(
    grouped: Callable[[Any], Varied], n: int, event: Event, x: Floats, symmetric: bool
) -> tuple[Solved, tuple[int, ...], tuple[int, ...]]:
    """Solve for the end of a motion on a line, in decimals.

    Parameters
    ----------
    grouped : callable
        Groups along the line, as for `motions.solve_one_to_one`; within `in_decimals`.
    n : int
        Forcing periods per motion.
    event : Event
    x : ndarray
        Velocities and times of its impacts, and the position on the line: a guess.
    symmetric : bool
        Whether the motion there is symmetric.

    Returns
    -------
    solved : Solved
        The motion at its end, with touches of a membrane as impacts.
    rests, touches : tuple of int
        Its impacts without velocity, and the touches among them.

    Raises
    ------
    NumericalError
        If it does not settle.
    """
    rests = resting(event, x, symmetric)
    solved, touches = solve_one_to_one(grouped, end_motion(n, x), Condition(event, rests), symmetric)
    return solved, (*rests, *touches), touches


def _bracketed(device: Device, varied: DesignInput, end: Ending) -> Point:
    """The critical point at the end of a motion in doubles, with the bracket of its search as error bounds."""
    n, position, line = device.period_ratio, float(end.x[-1]), model_on_line(end.line, device, FLOATS)
    motion, (d, gbar, *_) = end_motion(n, end.x), line.at((position,))
    u = 0.0 if end.symmetric else float(end.x[3] - end.x[2]) / (2 * n) - 0.5
    numbers = {"u": u, "phi_bottom": pi * float(end.x[2]), "d": float(d), "gbar": float(gbar)}
    numbers |= {"velocity_bottom": float(end.x[0]), "velocity_top": float(end.x[1])}
    # A root that does not settle has the digits that halving the path gave: its bracket is stated as the error,
    # instead of a digit that may be wrong.
    left_open = OPEN * (1 + abs(position))
    bounds = {name: left_open * (1 + abs(x)) for name, x in numbers.items()}
    value, *ends = (
        float(value_at(device, varied, at, line.at((at,)), FLOATS))
        for at in (position, position - left_open, position + left_open)
    )
    event = Event.GRAZING if end.event is Event.ZERO_VELOCITY else end.event
    error = max(abs(other - value) for other in ends)
    return Point(event, motion, numbers["d"], numbers["gbar"], value, error, one_to_one(n, numbers, bounds))


HARMONICS = tuple(Harmonic(order, 0.0, 0.0) for order in (2, 3))
"""Harmonics by which ends of motions are differentiated."""


def differentiated(harmonics: Sequence[Harmonic], more: Sequence[Harmonic] = HARMONICS) -> tuple[Harmonic, ...]:
    """The harmonics of a force, and those of `more` whose order it does not have."""
    return *harmonics, *(harmonic for harmonic in more if harmonic.order not in {other.order for other in harmonics})


class VariedGroups:
    """Groups whose numbers are themselves the variables: a `Variation` with the identity for slopes."""

    def __init__(self, groups: Groups[Any]) -> None:
        self.like = groups

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """Groups with other numbers, in the order of `Groups.numbers`."""
        return self.like.with_numbers(varied)

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """The derivatives of `Groups.numbers` by themselves."""
        return np.eye(len(self.like.numbers))


def normal_of(
    motion: Motion,
    groups: Groups[float],
    event: Event,
    rests: tuple[int, ...],
    more: Sequence[Harmonic] = HARMONICS,
) -> Floats:
    """Normal, in `Groups.numbers`, of the surface on which motions end in this way; NaN where it has none.

    The numbers include those of the harmonics `more`, even where the force does not have them.

    The conditions R(y; d, gbar, r_b, r_t, ...) = 0 of such a motion, y its velocities and times, are one more than the
    unknowns. By the implicit function theorem a vector w with w R_y = 0 gives the normal w R_(d, gbar, ...): it is
    orthogonal to every change that leaves the conditions fulfilled.

    Parameters
    ----------
    motion : Motion
        At its end, with its touches as impacts.
    groups : Groups
        Groups at that end.
    event : Event
    rests : tuple of int
        Impacts without velocity, touches included.
    more : sequence of Harmonic
        Further harmonics by which conditions are differentiated.
    """
    groups = groups._replace(harmonics=differentiated(groups.harmonics, more))
    if event is Event.PITCHFORK:
        return _pitchfork_normal(motion, groups)
    # Where two touches mirror each other either can be taken: with both as impacts each would be a condition.
    motion = motion.without_impacts(rests[1:] if len(motion.word) > 2 else ())
    x = np.concatenate([motion.velocity, motion.time, groups.numbers])
    condition = Condition(event, rests[:1])
    if event is Event.STOP:
        condition = stopped(motion.word, x.tolist(), groups)
    if event is Event.GRAZING and not rests:
        condition = held_at_once(motion.time, groups)
    _, gradient = condition.linearised(motion.word, x, groups, np.eye(len(groups.numbers)))
    gradients = np.vstack([linearised(motion.word, x, VariedGroups(groups))[1], gradient])
    if not np.isfinite(gradients).all():
        return np.full(len(groups.numbers), np.nan)
    unknowns = 2 * len(motion.word)
    # Rows are scaled before the null vector is taken: conditions in times and in velocities differ by orders of
    # magnitude, and the smallest singular value would be that of the units.
    scale = np.max(np.abs(gradients), axis=1, keepdims=True)
    rows = gradients / np.where(scale == 0, 1.0, scale)
    # One more condition than unknowns: the last left singular vector is w.
    weight = np.linalg.svd(rows[:, :unknowns])[0][:, -1]
    return np.asarray(weight @ rows[:, unknowns:])


def _pitchfork_normal(motion: Motion, groups: Groups[float]) -> Floats:
    """Normal, see `normal_of`, of the surface on which symmetric motions of a horizontal capsule have a pitchfork.

    Notes
    -----
    Half a period is a map of itself, followed by its mirror image. With the force a, its impulse S and its path C at
    the impacts of velocity v, 2 S = pi (1-r) v and d = n (1+r) v/2 - 2 C/pi^2. The map has the trace 2 r - (1+r) n a/v
    and the determinant r^2: an asymmetric change is kept where a multiplier is -1, (1+r) v = n a. As in `normal_of`, a
    combination of the three conditions has no derivative by v and by the phase. Its derivative by the restitution of
    both membranes stands for those by each; the border has a cusp in gbar, in the difference of both restitutions and
    in even harmonics, which part the images. With friction f, 2 S = pi [(1-r) v + n f], and a multiplier is -1 where
    (1+r) v = n [a + f (1-r)/(1+r)].

    Where the restitution falls with speed, r is that of the impact, and s = (1 + exponent) r is d(r v)/dv:
    (1+s) and (1-s) are the derivatives of (1+r) v and (1-r) v by v. The half map then has the trace
    r + s - (1+s) n a/v and the determinant r s, so that a multiplier is -1 under the same condition.
    """
    velocity, phase = float(motion.velocity[0]), pi * float(motion.time[0])
    r, slope = map(float, groups.rebound(1, velocity))
    n = motion.word.periods
    sine, cosine = sin(phase), cos(phase)
    force_wave, rate = wave(sine, cosine, groups.harmonics), force_rate(sine, cosine, groups.harmonics)
    rows = np.array([[pi * (1 - slope), 1 + slope], [-2 * force_wave.force, -n * rate]])
    impulse, force = np.linalg.solve(rows, [n * (1 + slope) / 2, 2 * force_wave.impulse / pi**2])
    normal = [1.0, 0.0, float(velocity * (force - pi * impulse - n / 2)), 0.0]
    for harmonic in groups.harmonics:
        s, c = sin(harmonic.order * phase), cos(harmonic.order * phase)
        of_cosine = -2 * impulse * s / harmonic.order - n * force * c + 2 * c / (pi * harmonic.order) ** 2
        of_sine = 2 * impulse * c / harmonic.order - n * force * s + 2 * s / (pi * harmonic.order) ** 2
        normal += [float(of_cosine), float(of_sine)] if harmonic.order % 2 else [nan, nan]
    if groups.law is not None:
        law = groups.law.map_numbers(float)
        stated, exponent, speed = law.bottom, law.exponent, law.speed
        by_r = normal[2]
        normal[2] = by_r * r / stated
        normal += [by_r * r * log(velocity / speed), -by_r * exponent * r / speed]
    if groups.friction is not None:
        normal[2] += float(2 * force * n * groups.friction / (1 + r) ** 2)
        normal.append(float(n * (pi * impulse - force * (1 - r) / (1 + r))))
    return np.array(normal)


def _derivatives(
    device: Device, varied: DesignInput, point: Point, normal: Floats
) -> tuple[dict[DesignInput, float | None], dict[int, tuple[float, float] | None]]:
    """Derivatives of the value of an input at which a motion ends: by the other inputs, and by harmonics of the force.

    Parameters
    ----------
    device : Device
    varied : DesignInput
    point : Point
        The critical point.
    normal : ndarray
        Normal of the surface of such points, in `Groups.numbers`, see `normal_of`.
    """
    at = device.with_values({varied: point.sweep_value})
    slopes = {name: float(normal[:4] @ np.array(at.slopes(name, point.d, point.gbar))) for name in DesignInput}
    orders = differentiated(device.harmonics)
    harmonics, more = np.split(normal[4:], [2 * len(orders)])
    if at.law is not None:
        slopes = {name: slope + float(more[1]) * at.law_slope(name) for name, slope in slopes.items()}
    if at.rubs:
        slopes = {name: slope + float(more[-1]) * at.friction_slope(name) for name, slope in slopes.items()}
    by_varied = slopes.pop(varied)
    # Where inputs overlap, the other moves the value itself as well.
    derivatives = {
        name: (-slope / by_varied if by_varied else inf) + carried(varied, name) for name, slope in slopes.items()
    }
    by_harmonics = {}
    for harmonic, parts in zip(orders, harmonics.reshape(-1, 2), strict=True):
        cosine, sine = (float(-part / by_varied) if by_varied else inf for part in parts)
        by_harmonics[harmonic.order] = (cosine, sine) if np.isfinite([cosine, sine]).all() else None
    return {name: slope if np.isfinite(slope) else None for name, slope in derivatives.items()}, by_harmonics
