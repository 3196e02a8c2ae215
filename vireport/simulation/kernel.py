"""Event search: from one impact to the next, without missing one and without stalling.

It turns starts and dimensionless groups into rows of impacts; it knows no periodic motions. Between two zeros of Z''
(phases with cosine -gbar) Z' is monotone, so on such a piece the motion, seen with the right sign, is a concave
function y with at most one peak: either y passes its upper wall before the peak, or it can only leave through the lower
one. So every crossing is bracketed before it is computed.

Most flights end in one of the first two pieces, with room to spare where they pass a wall by. These are followed by
formulas without branches, which take numbers and arrays alike: many balls at once are followed in lockstep, with the
operations, and so the impacts, of a single one. Other flights are left to the search.

Three things can go wrong with an impact, and each has its function: the ball may only just reach a wall (`_peak`: a
graze), it may bounce infinitely often in a finite time (`_settle`: chatter), and it may drift for thousands of periods
before it meets a wall (`_idle_periods`).

Each harmonic of the force adds a term to a flight; the zeros of Z'' are then arguments. Where `overtones` or
`harmonics` is None the force is a sine, and the compiler leaves out the rest. Under a recorded force a flight goes
through one cubic after another, on each of which it is a polynomial of five numbers, where others have four.

A ball with friction has separate searches, from stop to stop: between stops friction is a constant.

The functions are plain Python, some hundred times slower than compiled by `compiled`, and equal to rounding. They stay
in one file and import nothing of this package, because numba's cache watches no other file for changes. They take
numbers and tuples, some of them ten, where records would be natural: the interpreter would make a record in each step
of each search, and a run without the compiler consists of little else.
"""

from __future__ import annotations

from math import acos, cos, inf, nan, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

# How the search ended: impacts used up, at rest on the bottom, no membrane ever reached again, held by friction off it,
# or stopped by friction too often.
RUNNING, REST, FREE, HELD, CREEPING = 0, 1, 2, 3, 4
# Columns of `rows` (a row is an impact, the first one the start) and of `summary`.
WALL, PHASE, FLIGHT, VELOCITY, SETTLING, RIDING = 0, 1, 2, 3, 4, 5
IMPACTS, EVALUATIONS, STATUS = 0, 1, 2

TURN, PER_PI, PER_PI2, EPS = 2 * pi, 1 / pi, 1 / (pi * pi), 2.2e-16
PI_HEAD, PI_TAIL = 3.1415926535897896, 3.675178358715236e-15  # pi: the products of the first with 1 and 2 are exact
ROUND = 6755399441055744.0  # added and taken away again, it rounds a number to a whole one
STEP_TOL = 1.4e-17  # a fourth-order step d leaves about d^4 / min(|y'|, 1)^3: kept below 1/16 ulp of the time
CHATTER_TOL = 1e-15  # neglected third order of a completed chatter [t_c], well under the 1e-13 promised
FALLING_CHATTER = 1e-17  # rebound velocity down to which hops are followed whose restitution still grows
CLEAR = 1e-14  # distance from a wall at the end of a piece that rounding does not make or take away
CHATTER_SPEED = 0.05  # above this rebound velocity the criterion cannot hold and is not evaluated
FAST_STEPS, MAX_STEPS = 20, 200  # of a root search: first bracketed fourth-order ones, then bisection
MAX_PERIODS = 100_000  # examined in one flight; `_idle_periods` leaves fewer than ten in every case tried
# Stops that a ball with friction may make in all, and so many more for each impact: beyond, it creeps. Other balls stop
# a few times in a flight.
MAX_STOPS, STOPS_PER_IMPACT = 4_000, 8
# Number of trajectories that are followed together: their data stay in the processor's first cache. Fewer than FEW are
# followed one after the other.
LANES, FEW = 256, 8
USUAL = 3.0  # pairs of sine and cosine of a usual impact, those of the next flight included
# A flight is described by its beginning. In the functions below y is its displacement from there, or minus that.
FlightRow = tuple[float, float, float, float]  # Z'+, gbar, cosine and sine of the phase at the start
Quintic = tuple[float, float, float, float, float]  # Z' to Z''''' at the start, where Z'' is a cubic
Leg = FlightRow | Quintic
Node = tuple[float, float, float]  # a time, and displacement and velocity there
Flight = tuple[Any, Any, Any, Any]  # a flight row, as numbers or arrays
Hit = tuple[float, float, float, float, float]  # see `_next_impact`
Pair = tuple[float, float]
Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Bools = NDArray[np.bool_]
# Harmonics of the force in a flight: order, cosine and sine of each at its beginning; and a sign, -1 where y is -Z.
Overtones = tuple[Array, float] | None
ORDER, COSINE, SINE = 0, 1, 2
# Columns of `drive`: a row is a cubic of Z'', by its value and derivatives at its beginning, and does not change sign.
LENGTH, PULL, RATE, BEND, JERK, CONCAVE = 0, 1, 2, 3, 4, 5


def pick(condition: Any, yes: Any, no: Any) -> Any:
    """Return one of two numbers, or tuples of them, by a condition; elementwise of arrays."""
    if condition is True:
        return yes
    return no if condition is False else np.where(condition, yes, no)[()]  # a number of NumPy's stays one


def root(square: Any) -> Any:
    """Return the square root of a number, or elementwise of an array."""
    return np.sqrt(square) if isinstance(square, np.ndarray) else sqrt(square)


def _series(q: Any) -> tuple[Any, Any]:
    """Return (1 - cos x)/x^2 and (x - sin x)/x^3 for q = x^2, |x| up to pi/2.

    They are Taylor's series, economised by Chebyshev's polynomials to 8 terms each. The errors are at most 6.5e-18 and
    3.5e-19.
    """
    q2 = q * q
    q4 = q2 * q2
    rise = (0.5 - q * 0.04166666666666634) + q2 * (0.0013888888888860709 - q * 2.4801587292446213e-05)
    cut = (2.755731776732053e-07 - q * 2.0876630867422994e-09) + q2 * (
        1.1464689885720029e-11 - q * 4.6276759850181716e-14
    )
    lag = (0.16666666666666666 - q * 0.008333333333333316) + q2 * (0.00019841269841254974 - q * 2.7557319219163234e-06)
    end = (2.5052107616996182e-08 - q * 1.6058977312464087e-10) + q2 * (
        7.643970296798572e-13 - q * 2.7314447669863995e-15
    )
    return rise + q4 * cut, lag + q4 * end


def _octant_series(q: Any) -> tuple[Any, Any]:
    """Return `_series` for |x| up to pi/4, by 7 and 6 terms, with errors of at most 2e-19 and 2.1e-17."""
    q2 = q * q
    q4 = q2 * q2
    rise = (0.5 - q * 0.04166666666666664) + q2 * (0.0013888888888880775 - q * 2.480158729369345e-05)
    cut = (2.7557315566339707e-07 - q * 2.08758867376999e-09) + q2 * 1.136799863356103e-11
    lag = (0.16666666666666666 - q * 0.008333333333330948) + q2 * (0.0001984126983675857 - q * 2.755731610255057e-06)
    end = 2.5051131844614107e-08 - q * 1.5918129266803394e-10
    return rise + q4 * cut, lag + q4 * end


def _rough_series(q: Any) -> tuple[Any, Any]:
    """Return `_series` by 4 terms each, with errors of at most 7.7e-8 and 7.1e-9."""
    rise = (0.4999999231313572 - q * 0.041665669160306484) + q * q * (0.0013868610768898 - q * 2.3476086600425923e-05)
    lag = (0.16666665963821187 - q * 0.008333242135096939) + q * q * (0.000198227394886311 - q * 2.6347563918117813e-06)
    return rise, lag


def _alternating(k: Any) -> Any:
    """Return 1 for an even whole number, -1 for an odd one."""
    half = 0.5 * k
    return 1.0 - 4.0 * abs(half - ((half + ROUND) - ROUND))


def sine_and_cosine(phase: Any) -> tuple[Any, Any]:
    """Return sine and cosine of a phase in [0, 2 pi], each to 1.3 times EPS, relatively.

    The nearest right angles, k, are taken away: their first part exactly, as phase and product are within a factor 2,
    and their last with one rounding of what is left, x, which is at most pi/4. So x, and near zero its sine, is off by
    a rounding u = EPS/2. x - x q lag and 1 - q rise round once; what they take away is at most 0.10 of the first and
    0.42 of the second, and off by less than 6 u. The sum is below 1.6 u and, x counted with at most x tan x = 0.79,
    2.5 u for sine and cosine; measured against 40 digits are 2.3e-16.
    """
    k = (phase * (2.0 * PER_PI) + ROUND) - ROUND
    x = (phase - k * (0.5 * PI_HEAD)) - k * (0.5 * PI_TAIL)
    q = x * x
    rise, lag = _octant_series(q)
    sine, cosine = x - (x * q) * lag, 1.0 - q * rise
    sine, cosine = pick((k == 1.0) | (k == 3.0), (cosine, sine), (sine, cosine))
    return pick((k > 1.5) & (k < 3.5), -sine, sine), pick((k > 0.5) & (k < 2.5), -cosine, cosine)


def _half_turned(t: Any, rough: bool = False) -> tuple[Any, Any, Any, Any, Any]:
    """Return x = pi t less half turns, with sine and cosine of pi t, and `_series` of x.

    What is left of t is exact. x is off by 1.4 roundings, and at most pi/2: sine and cosine are off by at most 2 EPS,
    or where they are `rough` by 2e-7.
    """
    k = (t + ROUND) - ROUND
    sign, x = _alternating(k), pi * (t - k)
    q = x * x
    rise, lag = _rough_series(q) if rough else _series(q)
    return x, sign * x - (sign * x * q) * lag, sign - (sign * q) * rise, rise, lag


def _moved(t: Any, flight: Flight, wall: Any, rough: bool = False) -> Flight:
    """Return the `_state` of a flight under a sine, as numbers or arrays.

    Up to t = 1/2 the terms that cancel in a short flight, g/2 and c (1 - cos x)/x^2, are added before anything else is.
    With `rough`, sine and cosine are rough.
    """
    v, g, c, s = flight
    x, sine, cosine, rise, lag = _half_turned(t, rough)
    short, impulse = t < 0.5, s * PER_PI
    turned = pick(short, x * x * rise, 1.0 - cosine)
    long = (t * (v + 0.5 * g * t) - (impulse * t + wall)) + ((c * PER_PI2) * turned + (s * PER_PI2) * sine)
    y = pick(short, t * (v + t * (0.5 * g + (c * rise - s * (x * lag)))) - wall, long)
    y1 = (v + g * t) + ((c * PER_PI) * sine - impulse * turned)
    return y, y1, g + (c * cosine - s * sine), -pi * (c * sine + s * cosine)


def _quintic(t: float, flight: Quintic, wall: float) -> FlightRow:
    """Return y - wall, y', y'' and y''' at t where y'' is a cubic."""
    v, a, b, c, e = flight
    y = t * (v + t * (a * (1 / 2) + t * (b * (1 / 6) + t * (c * (1 / 24) + t * e * (1 / 120))))) - wall
    y1 = v + t * (a + t * (b * (1 / 2) + t * (c * (1 / 6) + t * e * (1 / 24))))
    return y, y1, a + t * (b + t * (c * (1 / 2) + t * e * (1 / 6))), b + t * (c + t * e * (1 / 2))


def _state(t: float, flight: Leg, overtones: Overtones, wall: float) -> FlightRow:
    """Return y - wall, y', y'' and y''' at t.

    y = v t + g t^2/2 + [c (1 - cos pi t) - s (pi t - sin pi t)]/pi^2 is (2.12) freed of its cancellation:
    short flights are as accurate, relatively, as long ones. A harmonic of order j has j t for t, over j^2.
    """
    if len(flight) == 5:
        return _quintic(t, flight, wall)
    y, y1, y2, y3 = _moved(t, flight, wall)
    if overtones is not None:
        parts, sign = overtones
        for k in range(len(parts)):
            j, c, s = float(parts[k, ORDER]), sign * float(parts[k, COSINE]), sign * float(parts[k, SINE])
            x, sine, cosine, rise, lag = _half_turned(j * t)
            rise, lag = pick(j * t < 0.5, (x * x * rise, x * x * x * lag), (1.0 - cosine, pi * (j * t) - sine))
            y += (c * rise - s * lag) * PER_PI2 / (j * j)
            y1 += (c * sine - s * rise) * PER_PI / j
            y2 += c * cosine - s * sine
            y3 -= pi * j * (c * sine + s * cosine)
    return y, y1, y2, y3


def _snap_of_overtones(t: float, overtones: Overtones) -> float:
    """Return y'''' at t less pi^2 (g - y''), which is 0 where the force is a sine."""
    snap = 0.0
    if overtones is not None:
        parts, sign = overtones
        for k in range(len(parts)):
            j, c, s = float(parts[k, ORDER]), float(parts[k, COSINE]), float(parts[k, SINE])
            value = c * cos(j * pi * t) - s * sin(j * pi * t)
            snap -= sign * pi * pi * (j * j - 1.0) * value
    return snap


def _by_snap(d: float, t: float, flight: Leg, overtones: Overtones, y2: float) -> float:
    """Return d y''''/3 at t, where y'' is known."""
    if len(flight) == 5:
        return d * (flight[3] + t * flight[4]) * (1 / 3)
    snap = d * pi * pi * (flight[1] - y2) * (1 / 3)
    if overtones is not None:
        snap += d * _snap_of_overtones(t, overtones) * (1 / 3)
    return snap


def _size(t: float, flight: Leg) -> float:
    """A bound of the errors that rounding, and sine and cosine that are off by 2 EPS, make of y(t), over EPS."""
    if len(flight) == 5:
        return abs(flight[0] * t) + 0.5 * abs(flight[1]) * t * t
    return abs(flight[0] * t) + 0.5 * abs(flight[1]) * t * t + min(t * t, 0.5 + abs(t))


def _turned(flight: Leg) -> Leg:
    """The description of a flight in which y stands for -Z, so that a convex piece becomes concave."""
    if len(flight) == 5:
        return -flight[0], -flight[1], -flight[2], -flight[3], -flight[4]
    return -flight[0], -flight[1], -flight[2], -flight[3]


def _hop(flight: Leg, end: float) -> float:
    """Time of a short hop from the lower wall, by its expansion in the speed as in `_settle`; inf where it is long."""
    v, brake = flight[0], -flight[1]
    if len(flight) == 5:
        turn = (4 / 3) * flight[2]
    else:
        brake, turn = -(flight[1] + flight[2]), -((4 / 3) * pi * flight[3])
    square = brake * brake
    return v * (2.0 + turn * v / square) / brake if 8.0 * v < brake * end and square > 0.0 else inf


def _signed(overtones: Overtones) -> Overtones:
    """Parts of the harmonics with their signs changed, for a flight in which y is -Z."""
    if overtones is None:
        return None
    return overtones[0], -overtones[1]


def _correction(f: Any, y1: Any, y2: Any, y3: Any) -> Any:
    """Householder's step of third order to a zero of f, by derivatives that cost no further sine or cosine."""
    square, bent = y1 * y1, f * y2
    steep = y1 * (square - bent) + f * f * y3 * (1 / 6)
    return -f * (square - 0.5 * bent) / pick(steep == 0.0, 1.0, steep)


def _crossing(flight: Leg, overtones: Overtones, wall: float, rising: float, ends: Pair, t: float, base: float) -> Node:
    """Time of the one crossing of y = wall between the ends, velocity there, evaluations; t is a guess.

    Steps are of fourth order, as y''' is free once y is known; one that leaves the bracket is bisected
    instead.
    """
    low, high = ends
    for step in range(1, MAX_STEPS):
        f, y1, y2, y3 = _state(t, flight, overtones, wall)
        low, high = (t, high) if f * rising < 0.0 else (low, t)
        d = _correction(f, y1, y2, y3)
        if low <= t + d <= high:
            m, scale = abs(y1), t + base
            m = m if m < 1.0 else 1.0
            done = d * d * d * d <= STEP_TOL * scale * m * m * m or abs(d) <= 0.5 * EPS * scale
            if not done and step > 4:  # near grazing: stop at what rounding makes of y
                done = abs(f) <= EPS * (_size(t, flight) + abs(wall))
            if done:
                snap = _by_snap(d, t, flight, overtones, y2)
                return t + d, y1 + d * (y2 + 0.5 * d * (y3 + snap)), float(step)
        t = t + d if low < t + d < high and step < FAST_STEPS else 0.5 * (low + high)
    return t, y1, float(MAX_STEPS)


def _parabola(flat: Node, other: Node, wall: float) -> float:
    """First guess of a crossing: parabola with value and slope of the flatter end and value of the other."""
    t0, y0, slope = flat
    span = other[0] - t0
    square, rise = span * span, other[1] - y0 - slope * span
    bend = rise / square if square > 0.0 else 0.0
    if bend == 0.0:
        return nan
    inside = slope * slope - 4.0 * bend * (y0 - wall)
    root = sqrt(inside) if inside > 0.0 else 0.0
    # Of the two roots the one on the side of the other end.
    return t0 + ((root - slope) if (bend > 0.0) == (span > 0.0) else (-slope - root)) / (2.0 * bend)


def _peak(flight: Leg, overtones: Overtones, wall: float, start: Node, end: Node) -> tuple[bool, float, float, float]:
    """Whether concave y, rising at the start and falling at the end, reaches the wall in between.

    Two tangents bound the peak from above, any value of y from below: the search for the zero of Z' ends once
    either decides. Touching counts as an impact, of velocity zero. Also returned are a time when y is past the
    wall, a guess of the crossing before it, and the number of evaluations.
    """
    t0, y0, p0 = start
    t1, y1, p1 = end
    m = t0 + (t1 - t0) * p0 / (p0 - p1)
    for step in range(MAX_STEPS):
        top = (y1 - y0 + p0 * t0 - p1 * t1) / (p0 - p1)
        if y0 + p0 * (top - t0) < wall:
            return False, m, m, float(step)
        y, p, q, j = _state(m, flight, overtones, wall)
        if y >= 0.0:  # a touch counts: rounding cannot tell it from an impact
            guess = m - sqrt(2.0 * y / abs(q)) if q != 0.0 else -inf
            if p > 0.1 or m - guess > 0.3 * (m - start[0]):  # not near the peak: its curvature says little
                guess = _parabola((m, y + wall, p), start, wall)
            return True, m, guess, step + 1.0
        t0, y0, p0 = (m, y + wall, p) if p > 0.0 else (t0, y0, p0)
        t1, y1, p1 = (t1, y1, p1) if p > 0.0 else (m, y + wall, p)
        steep = q * q - 0.5 * p * j
        d = -p * q / steep if steep != 0.0 else inf
        if abs(d) <= 0.5 * EPS * abs(m):
            break
        m = m + d if t0 < m + d < t1 and step < FAST_STEPS else 0.5 * (t0 + t1)
    return False, m, m, step + 1.0


def _piece(
    sign: float, flight: Leg, overtones: Overtones, walls: Pair, start: Node, end: Node, base: float
) -> FlightRow:
    """First impact on a piece where `sign` Z is concave: wall (0: none), time, velocity, evaluations."""
    path, turned = flight, overtones
    (lower, upper), (a, ya, pa), (b, yb, pb) = walls, start, end
    # From here on y is concave: what is convex is turned upside down.
    if sign < 0.0:
        path, turned = _turned(flight), _signed(overtones)
        lower, upper, ya, pa, yb, pb = -upper, -lower, -ya, -pa, -yb, -pb
    high, guess, evaluations, strikes_upper = b, a, 0.0, False
    if yb >= upper and pb >= 0.0:
        strikes_upper = True
        guess = _parabola((b, yb, pb), (a, ya, pa), upper)
    elif pa > 0.0 and pb < 0.0:
        strikes_upper, high, guess, evaluations = _peak(path, turned, upper, (a, ya, pa), (b, yb, pb))
    if not strikes_upper:
        if yb > lower:
            return 0.0, 0.0, 0.0, evaluations
        high = b
        guess = _hop(path, b) if overtones is None and a == 0.0 and ya == lower else inf
        if guess == inf:
            guess = _parabola((a, ya, pa), (b, yb, pb), lower)
    guess = guess if a < guess < high else 0.5 * (a + high)
    wall, rising = (upper, 1.0) if strikes_upper else (lower, -1.0)
    t, speed, steps = _crossing(path, turned, wall, rising, (a, high), guess, base)
    return rising * sign, t, sign * speed, evaluations + steps


def _node(t: float, flight: FlightRow, end: Pair) -> Node:
    """Displacement (2.12) and velocity (2.11) after t, where cosine and sine of the phase are known."""
    v, g, c, s = flight
    if t >= 0.5:
        z = t * (v + 0.5 * g * t - s * PER_PI) + (c - end[0]) * PER_PI2
        return t, z, v + g * t + (end[1] - s) * PER_PI
    z, speed, _, _ = _state(t, flight, None, 0.0)
    return t, z, speed


def _breakpoint(phase: float, gbar: float, turn: float) -> Node:
    """Pieces of a flight under a sine: sign that makes Z concave now, time to the next zero of Z'', and to another one.

    The zeros are `turn` = arccos(-gbar) and its mirror image. With gbar >= 1 there is none: half periods serve as
    pieces, and Z is convex on all of them.
    """
    if gbar >= 1.0:
        return -1.0, 1.0, 1.0
    if phase < turn:
        return -1.0, (turn - phase) * PER_PI, 2.0 * (1.0 - turn * PER_PI)
    if phase < TURN - turn:
        return 1.0, (TURN - turn - phase) * PER_PI, 2.0 * turn * PER_PI
    return -1.0, (TURN + turn - phase) * PER_PI, 2.0 * (1.0 - turn * PER_PI)


def _idle_periods(t: float, flight: FlightRow, walls: Pair, reach: float) -> float:
    """Whole forcing periods after t in which no wall can be reached, since Z is its mean motion +- reach/pi^2."""
    v, g, c, s = flight
    mean = t * (v - s * PER_PI + 0.5 * g * t) + c * PER_PI2
    room = min(walls[1] - mean, mean - walls[0]) - reach * PER_PI2
    if room <= 0.0:
        return 0.0
    drift = abs(v - s * PER_PI + g * t)
    fastest = drift + sqrt(drift * drift + 2.0 * g * room)
    return float(np.floor(room / fastest)) if fastest > 0.0 else inf


def _next_impact(flight: FlightRow, phase: float, turn: Pair, walls: Pair) -> Hit:
    """First impact of a flight: whole periods, time beyond them, wall (0: never), velocity, evaluations.

    `walls` are top <= 0 <= bottom as seen from the start. A flight longer than two periods starts anew from
    the same phase, so that no sine is ever taken of a large argument.
    """
    v, g, c, s = flight
    sign, first, gap = _breakpoint(phase, g, turn[0])
    if g < 1.0:
        flip, middle, last = -sign, (-g, -sign * turn[1]), (-g, sign * turn[1])
    else:
        flip, middle, last = sign, (-c, -s), (c, s)
    ends = (first, first + gap)
    node, now, gate = (0.0, 0.0, v), flight, walls
    periods, evaluations = 0.0, 0.0
    for window in range(MAX_PERIODS):
        for half in (0, 1):
            end = _node(ends[half], now, middle if half == 0 else last)
            wall, t, hit, steps = _piece(sign if half == 0 else flip, now, None, gate, node, end, periods)
            evaluations += steps
            if wall != 0.0:
                return periods, t, wall, hit, evaluations
            node = end
        # Both pieces are searched: one period. Those in which the mean motion keeps clear of the walls are skipped.
        idle = _idle_periods(ends[1], now, gate, 1.0)
        if g == 0.0 and v == s * PER_PI and (window > 0 or idle > 0.0):
            break  # no drift: every period repeats this one
        # Times stay between one and two periods after the new origin: none is a small difference.
        periods += idle if window == 0 else 1.0 + idle
        ends = (first + 2.0, first + gap + 2.0)
        shift = 2.0 * periods * (v - s * PER_PI + g * periods)
        now, gate = (v + 2.0 * g * periods, g, c, s), (walls[0] - shift, walls[1] - shift)
        node = _node(first + gap, now, last)
    return periods, 0.0, 0.0, 0.0, evaluations


def _leaves(sign: Any, d: Any, start: Any, end: Any, near: Any) -> tuple[Any, Any, Any]:
    """Whether a piece on which `sign` z is concave ends beyond the upper wall, or the lower one, and is sure to.

    z is between 0 and d at the start. It is sure if both ends are clear of the walls, by `near`, and the crest, which
    is below the tangents at both, reaches no wall. Nodes are times, places and velocities.
    """
    (a, ya, pa), (b, yb, pb) = start, end
    upper = pick(sign > 0.0, d, 0.0)
    ya, yb, pa, pb = sign * ya - upper, sign * yb - upper, sign * pa, sign * pb
    up, down, clear = yb > near, yb + d < -near, (yb < -near) & (yb + d > near)
    low = (pa <= 0.0) | (pb >= 0.0) | (pa * yb - pb * ya + pa * pb * (a - b) < near * (pb - pa))
    return up, down & low, up | (low & (down | clear))


def _bracket(
    wall: Any, v: Any, phase: Any, s: Any, c: Any, r: Any, device: Any
) -> tuple[Any, Any, Any, Any, Flight, Any]:
    """Bracket the next impact of a ball that flies off a wall, where it is found without a further sine.

    It is in one of the first two pieces in most flights. Positions are counted from the wall left, the other wall being
    at d; s and c are sine and cosine of the phase. Returned are whether this is sure to be the first impact, a guess of
    its time, the ends of the bracket, the flight, and the position of the wall.
    """
    d, g, turn, swing = device
    v = r * abs(v)
    early, late = phase < turn, phase >= TURN - turn
    convex, zero = early | late, pick(early, turn, pick(late, TURN + turn, TURN - turn))
    first, sign = (zero - phase) * PER_PI, pick(convex, -1.0, 1.0)
    second = first + 2.0 * pick(convex, 1.0 - turn * PER_PI, turn * PER_PI)
    g, c, s, sign, swing = -wall * g, -wall * c, -wall * s, -wall * sign, -wall * sign * swing * PER_PI
    # At the zeros of Z'' the cosine is -g, and the sine known.
    mean, path = v - s * PER_PI, (c + g) * PER_PI2
    start = 0.0 * v, 0.0 * v, v
    middle = first, first * (mean + 0.5 * g * first) + path, mean + g * first - swing
    end = second, second * (mean + 0.5 * g * second) + path, mean + g * second + swing
    near = CLEAR * (1.0 + d + v)
    up, down, sure = _leaves(sign, d, start, middle, near)
    later_up, later_down, later_sure = _leaves(-sign, d, middle, end, near)
    soon = up | down
    sure = sure & (soon | (later_sure & (later_up | later_down))) & (v > CHATTER_SPEED) & (swing != 0.0)
    up, sign = pick(soon, up, later_up), pick(soon, sign, -sign)
    start, end = pick(soon, start, middle), pick(soon, middle, end)
    far, low, high = (sign > 0.0) == up, start[0], end[0]
    # The parabola through both ends has the slope of the flatter one.
    a, y, slope = pick(up, end, start)
    b, other, _ = pick(up, start, end)
    span, target = b - a, pick(far, d, 0.0)
    slope = sign * slope * span
    bend = sign * (other - y) - slope
    inside = slope * slope - 4.0 * bend * (sign * (y - target))
    t = a + (slope + root(abs(inside))) * (span / pick(bend == 0.0, 1.0, -2.0 * bend))
    return sure, t, low, high, (v, g, c, s), target


def _approach(t: Any, flight: Any, wall: Any) -> Any:
    """Return a better time of impact; `_arrive` refuses one that leads astray.

    A rough state will do: the error that it adds is of the size of the error that the step leaves.
    """
    return t + _correction(*_moved(t, flight, wall, True))


def _arrive(t: Any, low: Any, high: Any, flight: Any, wall: Any, phase: Any) -> tuple[Any, Any, Any, Any]:
    """Take the last step to an impact; return whether it is exact to rounding then, its time, velocity and phase.

    From `low` to `high` there is one crossing towards the wall.
    """
    f, y1, y2, y3 = _moved(t, flight, wall)
    e = _correction(f, y1, y2, y3)
    m = pick(abs(y1) < 1.0, abs(y1), 1.0)
    square = e * e
    exact = (square * square <= STEP_TOL * t * (m * m * m)) | (abs(e) <= 0.5 * EPS * t)
    t, speed = t + e, y1 + e * (y2 + 0.5 * e * (y3 + e * (pi * pi) * (flight[1] - y2) * (1 / 3)))
    phase = phase + pi * t
    phase = pick(phase >= TURN, phase - TURN, phase)
    ahead = ((speed > 0.0) == (wall > 0.0)) & (speed != 0.0)
    return exact & ahead & (low <= t) & (t <= high) & (phase < TURN), t, speed, phase


STRAIGHT = (
    _series, _octant_series, _rough_series, _alternating, sine_and_cosine, _half_turned, _moved, _correction, _leaves,
    _bracket, _approach, _arrive,
)  # fmt: skip
"""Functions without branches, which take numbers and arrays alike."""


def _fill_parts(phase: float, harmonics: Array, parts: Array) -> None:
    """Fill `parts` with order, cosine and sine of each harmonic, phases counted from where the flight begins."""
    for k in range(len(harmonics)):
        j, a, b = float(harmonics[k, 0]), float(harmonics[k, 1]), float(harmonics[k, 2])
        cosine, sine = cos(j * phase), sin(j * phase)
        parts[k, ORDER], parts[k, COSINE], parts[k, SINE] = j, a * cosine + b * sine, a * sine - b * cosine


def _next_zero(phase: float, zeros: Array) -> int:
    """Index of the first zero of Z'' after a phase; the number of zeros if that is the first of the next period."""
    for k in range(len(zeros)):
        if phase < zeros[k, 0]:
            return k
    return len(zeros)


def _next_impact_with_harmonics(
    flight: FlightRow, overtones: Overtones, phase: float, zeros: Array, walls: Pair
) -> Hit:
    """First impact of a flight as `_next_impact`, under a force with harmonics.

    Rows of `zeros` are the zeros of Z'', each a phase and the sign that makes Z concave from there on.
    """
    v, g, c, s = flight
    count, following = len(zeros), _next_zero(phase, zeros)
    # Impulse, path and amplitude of all harmonics together, as a sine alone has s, c and 1: for the mean motion.
    impulse, path, reach = s, c, 1.0
    if overtones is not None:
        parts = overtones[0]
        for k in range(len(parts)):
            j = parts[k, ORDER]
            impulse += parts[k, SINE] / j
            path += parts[k, COSINE] / (j * j)
            reach += sqrt(parts[k, SINE] * parts[k, SINE] + parts[k, COSINE] * parts[k, COSINE]) / (j * j)
    node, now, gate = (0.0, 0.0, v), flight, walls
    periods, evaluations, late = 0.0, 0.0, 0.0
    for window in range(MAX_PERIODS):
        for i in range(count):
            k, lap = following + i, 0.0
            if k >= count:
                k, lap = k - count, TURN
            t = (float(zeros[k, 0]) + lap - phase) * PER_PI + late
            z, speed, _, _ = _state(t, now, overtones, 0.0)
            end = (t, z, speed)
            wall, t, hit, steps = _piece(float(zeros[k - 1, 1]), now, overtones, gate, node, end, periods)
            evaluations += steps
            if wall != 0.0:
                return periods, t, wall, hit, evaluations
            node = end
        idle = _idle_periods(node[0], (now[0], g, path, impulse), gate, reach)
        if g == 0.0 and v == impulse * PER_PI and (window > 0 or idle > 0.0):
            break  # no drift, as in `_next_impact`
        periods += idle if window == 0 else 1.0 + idle
        shift = 2.0 * periods * (v - impulse * PER_PI + g * periods)
        now, gate = (v + 2.0 * g * periods, g, c, s), (walls[0] - shift, walls[1] - shift)
        t, late = node[0] - late, 2.0
        z, speed, _, _ = _state(t, now, overtones, 0.0)
        node = (t, z, speed)
    return periods, 0.0, 0.0, 0.0, evaluations


def _settle_with_harmonics(
    wall: float, flight: FlightRow, overtones: Overtones, phase: float, r: float, zeros: Array
) -> tuple[bool, float, float]:
    """Whether the ball settles on the wall as in `_settle`, under a force with harmonics; inf if it rides for ever."""
    v = flight[0]
    if abs(v) > CHATTER_SPEED:
        return False, 0.0, 0.0
    count, following = len(zeros), _next_zero(phase, zeros)
    sign, left = zeros[following - 1, 1], inf
    for i in range(count):
        k, lap = following + i, 0.0
        if k >= count:
            k, lap = k - count, TURN
        if zeros[k, 1] != sign:
            left = (float(zeros[k, 0]) + lap - phase) * PER_PI
            break
    if v == 0.0 or sign * wall > 0.0:
        return sign * wall < 0.0, 0.0, left
    _, _, pull, rate = _state(0.0, flight, overtones, 0.0)
    bend = pi * pi * abs(flight[1] - pull) + abs(_snap_of_overtones(0.0, overtones))
    return _summed(abs(v), r, wall * pull, -wall * rate, bend, left)


def _summed(v: float, r: float, press: float, jerk: float, bend: float, left: float) -> tuple[bool, float, float]:
    """Whether the infinitely many hops to come can be summed, the time they take, and the time of the ride then.

    Parameters are the speed just after an impact, r, the acceleration that presses the ball onto the wall, the rate at
    which that falls, a bound of its second derivative, and the time until it vanishes; see `_settle`.
    """
    square = press * press
    if press <= 0.0 or square == 0.0 or r == 1.0:
        return False, 0.0, 0.0
    w = v / (1.0 - r)
    time = 2.0 * w / press * (1.0 + 2.0 * jerk * w / (3.0 * square))
    settled = w * w * w * (4.0 * jerk * jerk / press + 2.0 * bend) <= CHATTER_TOL * (square * square)
    return settled and time < left, time, left - time


def _quintic_at(v: float, row: Array, since: float) -> Quintic:
    """A flight with velocity v that begins some time `since` the beginning of a row of the drive."""
    pull, rate, bend, jerk = float(row[PULL]), float(row[RATE]), float(row[BEND]), float(row[JERK])
    a = pull + since * (rate + since * (bend * (1 / 2) + since * jerk * (1 / 6)))
    return v, a, rate + since * (bend + since * jerk * (1 / 2)), bend + since * jerk, jerk


def _next_impact_recorded(v: float, drive: Array, place: int, since: float, walls: Pair) -> tuple[Hit, int, float]:
    """First impact of a flight as `_next_impact`, under a recorded force; also its row of the drive and the time in it.

    The flight begins in row `place`, at `since` its beginning. In each row it begins anew where the ball is then: no
    distance is a difference of what a whole record adds up to.
    """
    time, gone, evaluations = 0.0, 0.0, 0.0
    for k in range(place, len(drive)):
        left = float(drive[k, LENGTH]) - since
        if left > 0.0:
            flight = _quintic_at(v, drive[k], since)
            y, speed, _, _ = _state(left, flight, None, 0.0)
            gate, concave = (walls[0] - gone, walls[1] - gone), float(drive[k, CONCAVE])
            wall, t, hit, steps = _piece(concave, flight, None, gate, (0.0, 0.0, v), (left, y, speed), time)
            evaluations += steps + 1.0
            if wall != 0.0:
                return (0.0, time + t, wall, hit, evaluations), k, since + t
            time, gone, v = time + left, gone + y, speed
        since = 0.0
    return (0.0, time, 0.0, v, evaluations), len(drive), 0.0


def _settle_recorded(
    wall: float, v: float, r: float, drive: Array, place: int, since: float
) -> tuple[bool, float, float, int]:
    """Whether the ball settles on the wall as in `_settle`, under a recorded force; also the row that lets it go.

    The time that it rides is inf where it lies on the wall up to the end of the record.
    """
    if abs(v) > CHATTER_SPEED or place == len(drive):
        return False, 0.0, 0.0, place
    sign, left, after = float(drive[place, CONCAVE]), float(drive[place, LENGTH]) - since, place + 1
    while after < len(drive) and drive[after, CONCAVE] == sign:
        left, after = left + float(drive[after, LENGTH]), after + 1
    if after == len(drive):
        left = inf
    if v == 0.0 or sign * wall > 0.0:
        return sign * wall < 0.0, 0.0, left, after
    _, a, b, c, _ = _quintic_at(v, drive[place], since)
    settles, time, riding = _summed(abs(v), r, wall * a, -wall * b, abs(c), left)
    return settles, time, riding, after


def _released(phase: float, zeros: Array) -> float:
    """The zero of Z'' that a phase is up to rounding: so every release there is at exactly the same phase."""
    nearest, away = phase, inf
    for k in range(len(zeros)):
        off = abs(phase - zeros[k, 0]) % TURN
        off = min(off, TURN - off)
        if off < away:
            nearest, away = float(zeros[k, 0]), float(off)
    return nearest


def _settle(wall: float, flight: FlightRow, phase: float, r: float, turn: float) -> tuple[bool, float, float]:
    """Whether the ball settles on the wall now, the time of its infinitely many last hops, and the time it then rides.

    With the pressing acceleration A, its rate of decrease J and w = v/(1-r) all hops together take
    2w/A + 4J w^2/(3A^3) + O(w^3): one flight expanded, and summed over hops that lose both speed and A. The
    neglected order is below w^3 (4J^2/A + 2|K|)/A^4, K being the next derivative. Chatter is completed analytically
    once that is below `CHATTER_TOL` and the hops end before A vanishes; until then hops are followed one by one.
    """
    v, g, c, s = flight
    if abs(v) > CHATTER_SPEED:
        return False, 0.0, 0.0
    sign, left, _ = _breakpoint(phase, g, turn)
    if v == 0.0 or sign * wall > 0.0:
        return sign * wall < 0.0, 0.0, left
    return _summed(abs(v), r, wall * (g + c), wall * pi * s, pi * pi * abs(c), left)


def _phase_after(phase: float, t: float) -> float:
    """The forcing phase in [0, 2 pi) a time t after it was `phase`."""
    phase += pi * t
    while phase >= TURN:  # at most twice, but for a record: cheaper than a remainder
        phase -= TURN
    return phase


def _falling(stated: float, speed: float, law: Array) -> float:
    """The restitution at a speed by a law: its exponent, the speed at which it is `stated`, and its largest value."""
    if speed > 0.0:
        return min(float(law[2]), float(stated * (speed / law[1]) ** law[0]))
    return float(law[2])


def follow_start(
    model: Array,
    start: Array,
    impacts: int,
    rows: Array,
    summary: Array,
    laws: Array | None,
    which: int,
    harmonics: Array | None,
    zeros: Array | None,
    drive: Array | None,
) -> None:
    """Follow one start; see `follow_starts`. Its law is row `which` of the laws: numba knows no row of None."""
    d, g, r_bottom, r_top = float(model[0]), float(model[1]), float(model[2]), float(model[3])
    wall, z, v, phase = float(start[0]), float(start[1]), float(start[2]), float(start[3])
    turn = (acos(-g), sqrt((1.0 - g) * (1.0 + g))) if g < 1.0 else (pi, 0.0)
    device = (d, g, turn[0], turn[1])
    walls, flight = (-0.5 * d - z, 0.5 * d - z), 0.0
    evaluations, status, row, count, kept = 1.0, RUNNING, 0, 0, len(rows)
    parts = np.empty((0 if harmonics is None else len(harmonics), 3))
    place, since, after = 0, 0.0, 0
    while True:
        rows[row, WALL], rows[row, PHASE], rows[row, FLIGHT] = wall, phase, flight
        rows[row, VELOCITY], rows[row, SETTLING], rows[row, RIDING] = v, 0.0, 0.0
        r = r_bottom if wall > 0.0 else r_top
        if laws is not None:
            r = _falling(r, abs(v), laws[which])
        s, c = sine_and_cosine(phase)
        if harmonics is None and drive is None and wall != 0.0 and count < impacts:
            sure, t, low, high, path, target = _bracket(wall, v, phase, s, c, r, device)
            if sure:
                t = _approach(t, path, target)
                sure, t, speed, ahead = _arrive(t, low, high, path, target, phase)
            if sure:
                flight, v, phase, evaluations = t, -wall * speed, ahead, evaluations + USUAL
                wall = -wall if target > 0.0 else wall
                count, row = count + 1, row + 1 if row + 1 < kept else 0
                continue
        if harmonics is not None:
            _fill_parts(phase, harmonics, parts)
        if wall != 0.0:
            walls = (-d, 0.0) if wall > 0.0 else (0.0, d)
            v = -r * v  # (2.10)
            if drive is not None:
                settles, settling, riding, after = _settle_recorded(wall, v, r, drive, place, since)
                for_ever = riding == inf
            elif harmonics is None or zeros is None:
                settles, settling, riding = _settle(wall, (v, g, c, s), phase, r, turn[0])
                for_ever = g >= 1.0
            else:
                settles, settling, riding = _settle_with_harmonics(wall, (v, g, c, s), (parts, 1.0), phase, r, zeros)
                for_ever = riding == inf
            if laws is not None:
                # Hops to come are summed with one restitution: the largest, or so late that it makes no difference.
                settles = settles and (r == laws[which, 2] or abs(v) <= FALLING_CHATTER)
            if settles:
                rows[row, SETTLING], rows[row, RIDING] = settling, inf if for_ever else riding
                if for_ever:
                    status = REST
                    break
                # It is released at rest, at a zero of Z'' that is known exactly: what came before is forgotten.
                if drive is not None:
                    phase, v, place, since = _phase_after(phase, settling + riding), 0.0, after, 0.0
                elif harmonics is None or zeros is None:
                    phase, s, c, v = turn[0] if wall > 0.0 else TURN - turn[0], wall * turn[1], -g, 0.0
                else:
                    phase, v = _released(phase + pi * (settling + riding), zeros), 0.0
                    s, c = sine_and_cosine(phase)
                    _fill_parts(phase, harmonics, parts)
        if count == impacts:
            break
        row = row + 1 if row + 1 < kept else 0
        if drive is not None:
            (periods, t, wall, v, steps), place, since = _next_impact_recorded(v, drive, place, since, walls)
        elif harmonics is None or zeros is None:
            periods, t, wall, v, steps = _next_impact((v, g, c, s), phase, turn, walls)
        else:
            periods, t, wall, v, steps = _next_impact_with_harmonics((v, g, c, s), (parts, 1.0), phase, zeros, walls)
        evaluations += steps + 1.0
        if wall == 0.0:
            status = FREE
            break
        if wall * v < 0.0:
            v = 0.0  # an impact of 1e-100 y_c, say, whose velocity rounding has turned: the ball only touches
        flight = 2.0 * periods + t
        phase = _phase_after(phase, t)
        count += 1
    summary[IMPACTS], summary[EVALUATIONS], summary[STATUS] = count, evaluations, status


def note(count: int, lanes: Ints, ball: Array, flight: Array, row: int, rows: Array) -> None:
    """Write the impacts of some balls to a row of each, as `note_each` but on whole arrays."""
    which = lanes[:count]
    rows[which, row, WALL], rows[which, row, PHASE], rows[which, row, FLIGHT] = (
        ball[0, :count],
        ball[2, :count],
        flight[:count],
    )
    rows[which, row, VELOCITY], rows[which, row, SETTLING], rows[which, row, RIDING] = ball[1, :count], 0.0, 0.0


def note_each(count: int, lanes: Ints, ball: Array, flight: Array, row: int, rows: Array) -> None:
    """Write the impacts of some balls to a row of each."""
    for i in range(count):
        out = rows[lanes[i], row]
        out[WALL], out[PHASE], out[FLIGHT] = ball[0, i], ball[2, i], flight[i]
        out[VELOCITY], out[SETTLING], out[RIDING] = ball[1, i], 0.0, 0.0


def advance(count: int, ball: Array, device: Array, aim: Array, sure: Bools, flight: Array) -> None:
    """Bring some balls to their next impacts where these are `sure`, as `advance_each` but on whole arrays."""
    wall, v, phase = ball[:, :count]
    bottom, top, *rest = device[:, :count]
    r, (s, c) = pick(wall > 0.0, bottom, top), sine_and_cosine(phase)
    flying, t, low, high, path, target = _bracket(wall, v, phase, s, c, r, rest)
    arrived, t, speed, phase = _arrive(_approach(t, path, target), low, high, path, target, phase)
    sure[:count], flight[:count] = flying & arrived, t
    onto = pick(target > 0.0, -wall, wall), -wall * speed, phase
    ball[:, :count] = pick(sure[:count], onto, ball[:, :count])


def advance_each(count: int, ball: Array, device: Array, aim: Array, sure: Bools, flight: Array) -> None:
    """Bring some balls to their next impacts where these are `sure`.

    Each loop is short enough for several balls to be on their way in the processor, and has no branch.
    """
    for i in range(count):
        aim[0, i], aim[1, i] = sine_and_cosine(ball[2, i])
    for i in range(count):
        r, s, c = pick(ball[0, i] > 0.0, device[0, i], device[1, i]), aim[0, i], aim[1, i]
        rest = device[2, i], device[3, i], device[4, i], device[5, i]
        sure[i], t, low, high, path, target = _bracket(ball[0, i], ball[1, i], ball[2, i], s, c, r, rest)
        aim[0, i], aim[1, i], aim[2, i], aim[3, i] = t, low, high, target
        aim[4, i], aim[5, i], aim[6, i], aim[7, i] = path
    for i in range(count):
        path = aim[4, i], aim[5, i], aim[6, i], aim[7, i]
        aim[0, i] = _approach(aim[0, i], path, aim[3, i])
    for i in range(count):
        path, target = (aim[4, i], aim[5, i], aim[6, i], aim[7, i]), aim[3, i]
        arrived, t, speed, phase = _arrive(aim[0, i], aim[1, i], aim[2, i], path, target, ball[2, i])
        arrived = arrived & sure[i]
        sure[i], flight[i], wall = arrived, t, ball[0, i]
        ball[0, i] = pick(arrived & (target > 0.0), -wall, wall)
        ball[1, i], ball[2, i] = pick(arrived, -wall * speed, ball[1, i]), pick(arrived, phase, ball[2, i])


OF_ARRAYS = pick, root, note, advance
"""Functions on whole arrays that compiled code replaces by loops."""


def _follow_together(parameters: Array, starts: Array, impacts: int, rows: Array, summary: Array) -> None:
    """Follow some starts in lockstep under a sine, each exactly as `follow_start` does; see `follow_starts`.

    An impact that is not a usual one is left to `follow_start`, from one impact to the next.
    """
    count, kept = len(parameters), rows.shape[1]
    lanes, ball, device = np.arange(count), np.empty((3, count)), np.empty((6, count))
    aim, sure, flight = np.empty((8, count)), np.empty(count, np.bool_), np.zeros(count)
    steps, begin, pair, end = np.zeros(count), np.empty(4), np.empty((2, 6)), np.empty(3)
    for i in range(count):
        ball[0, i], ball[1, i], ball[2, i] = starts[i, 0], starts[i, 2], starts[i, 3]
        d, g = float(parameters[i, 0]), float(parameters[i, 1])
        device[0, i], device[1, i], device[2, i], device[3, i] = parameters[i, 2], parameters[i, 3], d, g
        device[4, i], device[5, i] = (acos(-g), sqrt((1.0 - g) * (1.0 + g))) if g < 1.0 else (pi, 0.0)
    for done in range(impacts + 1):
        row, lockstep = done % kept, done < impacts and count >= FEW
        note(count, lanes, ball, flight, row, rows)
        if lockstep:
            advance(count, ball, device, aim, sure, flight)
        going = 0
        for i in range(count):
            which = lanes[i]
            if not (lockstep and sure[i]):
                begin[0], begin[1], begin[2], begin[3] = ball[0, i], starts[which, 1], ball[1, i], ball[2, i]
                follow_start(parameters[which], begin, min(impacts - done, 1), pair, end, None, i, None, None, None)
                rows[which, row, SETTLING], rows[which, row, RIDING] = pair[0, SETTLING], pair[0, RIDING]
                ball[0, i], ball[1, i], ball[2, i], flight[i] = (
                    pair[1, WALL],
                    pair[1, VELOCITY],
                    pair[1, PHASE],
                    pair[1, FLIGHT],
                )
                steps[which] += end[EVALUATIONS] - 1.0 - USUAL * end[IMPACTS]
                if end[IMPACTS] == 0.0:
                    summary[which, IMPACTS], summary[which, STATUS] = done, end[STATUS]
                    summary[which, EVALUATIONS] = 1.0 + steps[which] + USUAL * done
                    continue
            if going < i:
                lanes[going], flight[going] = which, flight[i]
                for k in range(6):
                    device[k, going] = device[k, i]
                for k in range(3):
                    ball[k, going] = ball[k, i]
            going += 1
        count = going


def follow_starts(
    parameters: Array,
    starts: Array,
    impacts: int,
    rows: Array,
    summary: Array,
    laws: Array | None,
    harmonics: Array | None,
    zeros: Array | None,
    drive: Array | None,
) -> None:
    """Follow each start for a number of impacts or to its end.

    `parameters` (n, 4) are d, gbar, and r at the bottom and at the top; `starts` (n, 4) wall (+1 bottom, -1 top,
    0 in flight), position (used in flight), velocity (before the impact, if on a wall) and phase in [0, 2 pi).
    For restitutions that fall with speed `laws` (n, 3) are the exponent, the speed at which they are stated, and their
    largest value; None for constant ones.
    For a force with harmonics `harmonics` (n, h, 3) are order, cosine and sine of each, and `zeros` (n, m, 2) the zeros
    of Z'' ascending, each with the sign that makes Z concave from there on; both are None for a sine.
    For a recorded force `drive` (m, 6) are the cubics of Z'' one after another: every start is followed from the
    beginning of the first to the end of the last, with the phase of a sine of its frequency. Else it is None.
    Filled: `rows` (n, k, 6), where row i mod k holds impact i and 0 is the start, and `summary` (n, 3).
    """
    if laws is None and harmonics is None and drive is None and len(parameters) >= FEW:
        for i in range(0, len(parameters), LANES):
            k = i + LANES
            _follow_together(parameters[i:k], starts[i:k], impacts, rows[i:k], summary[i:k])
        return
    for i in range(len(parameters)):
        if harmonics is None or zeros is None:
            follow_start(parameters[i], starts[i], impacts, rows[i], summary[i], laws, i, None, None, drive)
        else:
            follow_start(parameters[i], starts[i], impacts, rows[i], summary[i], laws, i, harmonics[i], zeros[i], drive)


def _pull(phase: float, g: float, harmonics: Array) -> float:
    """The relative acceleration at a phase without friction."""
    pull = g + cos(phase)
    for k in range(len(harmonics)):
        j, a, b = float(harmonics[k, 0]), float(harmonics[k, 1]), float(harmonics[k, 2])
        pull += a * cos(j * phase) + b * sin(j * phase)
    return pull


def _exit(phase: float, zeros: Array, sign: float) -> Pair:
    """Time to the first zero of Z'' after which Z is concave (sign 1) or convex (-1), inf if none, and its phase."""
    count, following = len(zeros), _next_zero(phase, zeros)
    for i in range(count):
        k, lap = following + i, 0.0
        if k >= count:
            k, lap = k - count, TURN
        if zeros[k, 1] == sign:
            return (float(zeros[k, 0]) + lap - phase) * PER_PI, float(zeros[k, 0])
    return inf, phase


def _halt(flight: FlightRow, overtones: Overtones, high: float) -> Pair:
    """Time of the one zero of y', which falls through it before `high`, and the evaluations."""
    low, t = 0.0, 0.5 * high
    for step in range(1, MAX_STEPS):
        _, y1, y2, y3 = _state(t, flight, overtones, 0.0)
        low, high = (t, high) if y1 > 0.0 else (low, t)
        steep = y2 * y2 - 0.5 * y1 * y3
        d = -y1 * y2 / steep if steep != 0.0 else inf
        if (abs(d) <= 0.5 * EPS * t and low <= t + d <= high) or high - low <= EPS * high:
            break
        t = t + d if low < t + d < high and step < FAST_STEPS else 0.5 * (low + high)
    return t, float(step)


def _onward(
    way: float, v: float, phase: float, g: float, harmonics: Array, parts: Array, zeros: Array, room: float
) -> tuple[bool, float, float, float, float, float]:
    """Follow a ball with friction that slips one way, Z' having the sign `way`, until it strikes the wall or stops.

    Parameters are its velocity, the phase, the gravity with friction on this way, the zeros of Z'' with it, and the
    distance to the wall. Returned: whether it strikes, time, distance, velocity and phase there, and the evaluations.
    Between two zeros of Z'' the velocity is monotone: so it stops where its signs differ, and only there. Each zero is
    a new beginning, whose phase is known.
    """
    time, gone, evaluations = 0.0, 0.0, 0.0
    for _ in range(MAX_PERIODS):
        _fill_parts(phase, harmonics, parts)
        k, lap = _next_zero(phase, zeros), 0.0
        if k == len(zeros):
            k, lap = 0, TURN
        after = float(zeros[k, 0])
        end, left = (after + lap - phase) * PER_PI, room - gone
        flight, overtones = (way * v, way * g, way * cos(phase), way * sin(phase)), (parts, way)
        y, y1, _, _ = _state(end, flight, overtones, 0.0)
        stops = y1 < 0.0
        evaluations += 1.0
        if stops:
            end, steps = _halt(flight, overtones, end)
            y, y1, _, _ = _state(end, flight, overtones, 0.0)
            evaluations += steps
        if y >= left:
            t, speed, steps = _crossing(
                flight, overtones, left, 1.0, (0.0, end), end * left / y if y > 0.0 else end, time
            )
            return True, time + t, room, way * max(speed, 0.0), phase + pi * t, evaluations + steps
        time, gone = time + end, gone + y
        if stops:
            return False, time, gone, 0.0, phase + pi * end, evaluations
        v, phase = way * y1, after
    return False, time, gone, 0.0, phase, evaluations


def turned(phase: float) -> float:
    """A phase of at most a few turns reduced to [0, 2 pi)."""
    while phase >= TURN:
        phase -= TURN
    return phase


def begins(v: float, phase: float, model: Array, harmonics: Array) -> float:
    """Sign of the first way of a ball with friction in flight: of its velocity or, at rest, of the acceleration, or 0.

    Parameters are those of `next_way`.
    """
    if v != 0.0:
        return 1.0 if v > 0.0 else -1.0
    pull = _pull(phase, float(model[1]), harmonics)
    return 0.0 if abs(pull) <= model[4] else 1.0 if pull > 0.0 else -1.0


def next_way(
    way: float, v: float, phase: float, model: Array, harmonics: Array, parts: Array, zeros: Array, walls: Pair
) -> tuple[float, float, float, float, float, float, float]:
    """Follow a ball with friction on one way: it slips until it strikes or stops, or is held until it is let go.

    `way` is the sign of its velocity, 0 where it is held; `walls` are top <= 0 <= bottom as seen from it. Returned are
    time (inf: held for ever), displacement, velocity and phase at the end, whether it strikes, the sign of the way that
    follows, and the evaluations. A ball that stops is held while |Z''| without friction is no larger than friction.
    """
    g, f = float(model[1]), float(model[4])
    if way == 0.0:
        # It is let go where |Z''| without friction exceeds friction: upwards or downwards, whichever comes first.
        up, first = _exit(phase, zeros[0], 1.0)
        down, second = _exit(phase, zeros[1], -1.0)
        if up < down:
            return up, 0.0, 0.0, first, 0.0, -1.0, 0.0
        return down, 0.0, 0.0, second, 0.0, 1.0, 0.0
    room, ahead = (walls[1], zeros[1]) if way > 0.0 else (-walls[0], zeros[0])
    strikes, t, y, v, phase, steps = _onward(way, v, phase, g - way * f, harmonics, parts, ahead, room)
    phase = turned(phase)
    if strikes:
        return t, way * y, v, phase, 1.0, 0.0, steps
    # A stop is a switching event of friction: the ball turns if the force overcomes it, else it sticks.
    pull = way * _pull(phase, g, harmonics)
    return t, way * y, 0.0, phase, 0.0, (-way if pull < -f else 0.0), steps


def follow_ways(
    begun: Array, walls: Array, model: Array, harmonics: Array, zeros: Array, ways: Array, ends: Ints
) -> bool:
    """Follow a ball with friction from each of some impacts to the next, way by way; False if `ways` has too few rows.

    `begun` (n, 3) has the sign of the first way, the velocity and the phase after each, `walls` (n, 2) what `next_way`
    takes. Filled are `ways` (m, 5), the sign, time, phase, velocity at the beginning and at the end of each, and `ends`
    (n,), the number of ways up to each of the next impacts.
    """
    parts, row = np.empty((len(harmonics), 3)), 0
    for i in range(len(begun)):
        way, v, phase = float(begun[i, 0]), float(begun[i, 1]), float(begun[i, 2])
        strikes, gone = 0.0, 0.0
        while strikes == 0.0:
            if row == len(ways):
                return False
            walls_from_ball = float(walls[i, 0]) - gone, float(walls[i, 1]) - gone
            t, z, end, after, strikes, onward, _ = next_way(
                way, v, phase, model, harmonics, parts, zeros, walls_from_ball
            )
            out = ways[row]
            out[0], out[1], out[2], out[3], out[4] = way, t, phase, v, end
            gone, way, v, phase, row = gone + z, onward, end, after, row + 1
        ends[i] = row
    return True


def _next_impact_rubbed(
    way: float,
    v: float,
    phase: float,
    model: Array,
    harmonics: Array,
    parts: Array,
    zeros: Array,
    walls: Pair,
    most: int,
) -> tuple[float, float, float, float, float, int, int]:
    """First impact of a ball with friction: wall (0: none), time, velocity, phase, evaluations, how it ends, and stops.

    Parameters are those of `next_way`, and how often it may stop. It ends RUNNING where it strikes; else HELD for ever,
    FREE where it goes to and fro for ever, or CREEPING where it has stopped too often.
    """
    time, gone, evaluations, before = 0.0, 0.0, 0.0, inf
    for stops in range(most):
        ends = walls[0] - gone, walls[1] - gone
        t, z, v, phase, strikes, onward, steps = next_way(way, v, phase, model, harmonics, parts, zeros, ends)
        if t == inf:
            return 0.0, time, 0.0, phase, evaluations, HELD, stops
        time, gone, evaluations = time + t, gone + z, evaluations + steps
        if strikes != 0.0:
            return way, time, v, phase, evaluations, RUNNING, stops
        if way > 0.0:
            # Where the way there and back is the same, the next one is as well.
            if abs(gone - before) <= EPS * (walls[1] - walls[0]):
                return 0.0, time, 0.0, phase, evaluations, FREE, stops
            before = gone
        way = onward
    return 0.0, time, 0.0, phase, evaluations, CREEPING, most


def _settle_rubbed(
    wall: float, v: float, phase: float, model: Array, harmonics: Array, r: float, zeros: Array
) -> tuple[bool, float, float, float]:
    """Whether a ball with friction settles now, the times of its last hops and of the ride then, and the phase after.

    Pressed with A = |Z''| without friction it slows down by A + f on its way from the wall and speeds up by A - f on
    the way back: it comes back with rho = sqrt((A - f)/(A + f)) of its velocity, and all hops together take
    v [1/(A + f) + rho/(A - f)]/(1 - r rho) for constant A. The change of A in that time is neglected where it is below
    the tolerance.
    """
    g, f = float(model[1]), float(model[4])
    press = wall * _pull(phase, g, harmonics)
    riding, after = _exit(phase, zeros[0] if wall > 0.0 else zeros[1], wall)
    if v == 0.0:
        return press > -f, 0.0, riding, after
    if abs(v) > CHATTER_SPEED or press <= f:
        return False, 0.0, 0.0, phase
    rate = 1.0
    for k in range(len(harmonics)):
        j, a, b = float(harmonics[k, 0]), float(harmonics[k, 1]), float(harmonics[k, 2])
        rate += j * sqrt(a * a + b * b)
    back = sqrt((press - f) / (press + f))
    if r * back == 1.0:
        return False, 0.0, 0.0, phase
    time = abs(v) * (1.0 / (press + f) + back / (press - f)) / (1.0 - r * back)
    settled = pi * rate * time * time <= CHATTER_TOL * (press - f)
    return settled and time < riding, time, riding - time, after


def _follow_rubbed(
    model: Array, start: Array, impacts: int, rows: Array, summary: Array, harmonics: Array, zeros: Array
) -> None:
    """Follow one start of a ball with friction; see `follow_rubbed_starts`."""
    d, r_bottom, r_top = float(model[0]), float(model[2]), float(model[3])
    wall, z, v, phase = float(start[0]), float(start[1]), float(start[2]), float(start[3])
    walls, flight, parts = (-0.5 * d - z, 0.5 * d - z), 0.0, np.empty((len(harmonics), 3))
    evaluations, status, row, count = 1.0, RUNNING, 0, 0
    left = MAX_STOPS + STOPS_PER_IMPACT * impacts
    while True:
        out = rows[row]
        row = row + 1 if row + 1 < len(rows) else 0
        out[WALL], out[PHASE], out[FLIGHT] = wall, phase, flight
        out[VELOCITY], out[SETTLING], out[RIDING] = v, 0.0, 0.0
        way = 0.0
        if wall != 0.0:
            walls, way = ((-d, 0.0) if wall > 0.0 else (0.0, d)), -wall
            r = r_bottom if wall > 0.0 else r_top
            v = -r * v  # (2.10)
            settles, settling, riding, after = _settle_rubbed(wall, v, phase, model, harmonics, r, zeros)
            if settles:
                out[SETTLING], out[RIDING] = settling, riding
                if riding == inf:
                    status = REST if wall > 0.0 else HELD
                    break
                phase, v = after, 0.0
        else:
            way = begins(v, phase, model, harmonics)
        if count == impacts:
            break
        wall, flight, v, phase, steps, status, stops = _next_impact_rubbed(
            way, v, phase, model, harmonics, parts, zeros, walls, left
        )
        evaluations += steps + 1.0
        left -= stops
        if status != RUNNING:
            break
        count += 1
    summary[IMPACTS], summary[EVALUATIONS], summary[STATUS] = count, evaluations, status


def follow_rubbed_starts(
    parameters: Array, starts: Array, impacts: int, rows: Array, summary: Array, harmonics: Array, zeros: Array
) -> None:
    """Follow each start of a ball with friction for a number of impacts or to its end, as `follow_starts` does.

    `parameters` (n, 5) have friction last. For a sine `harmonics` are empty, (n, 0, 3); `zeros` (n, 2, m, 2) are the
    zeros of Z'' on the way up, where Z' is negative, and on the way down.
    """
    for i in range(len(parameters)):
        _follow_rubbed(parameters[i], starts[i], impacts, rows[i], summary[i], harmonics[i], zeros[i])
