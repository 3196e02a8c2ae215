"""A simulator of its own, in 80 bits and from the model alone: Z'' = gbar + cos(pi t), Z' -> -r Z' at Z = +-d/2.

It follows the ball from the release on the bottom membrane. Flights are sampled and crossings bisected; hops of less
than 0.01 are power series, so that none is too low. It is rest where the pressing acceleration changes by less than a
thousandth in all hops that are left.
"""

from __future__ import annotations

from functools import partial

import numpy as np

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
SLOW, SHORT, TERMS = LONG(1e-7), LONG(0.01), 14
FALLING = np.linspace(LONG(1), LONG(0), 100)
LAST = (1.5, 8.0)
"""How far a flight is sampled, and how far if it does not end before [t_c]."""
NEARLY = 1e3
"""How many times as far apart as what repeats the impacts may be that do so in the end."""
GRIDS = {last: SHORT * np.arange(1, int(last / SHORT)) for last in LAST}


def crossing(value, slope, low: LONG, high: LONG) -> tuple[LONG, LONG]:
    """Where a value changes sign between two moments, enclosed to the last bits: by Newton's steps, else by halves."""
    rising = value(high) > 0
    at = (low + high) / 2
    for _ in range(80):
        now = value(at)
        low, high = (low, at) if (now > 0) == rising else (at, high)
        steep = slope(at)
        # A step beyond the root by what rounding leaves, so that both ends move.
        step = -now / steep * (1 + LONG(1e-3)) if steep != 0 else LONG("inf")
        after = at + step
        at = after if low < after < high else (low + high) / 2
        if high - low <= 4 * np.spacing(high) or at in (low, high):
            break
    return low, high


def follow(d: float, gbar: float, r: float, impacts: int) -> tuple[list[tuple[int, LONG, LONG]], int | None]:
    """Impacts (wall, time, speed) from the release, and the forcing periods to the next release, None before it.

    It ends as soon as they repeat to 1e-12.
    """
    d, g, r = LONG(d), LONG(gbar), LONG(r)
    release = np.arccos(-g) / PI
    t, wall, v, found = release, 1, LONG(0), []

    def moved(now, s):
        start, end = PI * now, PI * (now + s)
        drift = v + g * s / 2 - np.sin(start) / PI
        return drift * s - (np.cos(end) - np.cos(start)) / (PI * PI)

    def speed(now, s):
        return v + g * s + (np.sin(PI * (now + s)) - np.sin(PI * now)) / PI

    def pull(now, s):
        return g + np.cos(PI * (now + s))

    def beyond(now, side, end, s):
        return side * moved(now, s) - end

    def outward(now, side, s):
        return side * speed(now, s)

    for turn in range(impacts):
        if turn % 64 == 63 and len(found) > 70 and repeated(found, 1e-12) is not None:
            return found, None
        while v != 0 and (landed := hop(g, wall, t, abs(v))):
            t, v = t + landed[0], r * landed[1]
            found.append((wall, t, landed[1]))
            v = -wall * v
            if rests(g, wall, t, abs(v), r):
                if wall < 0:
                    raise ArithmeticError("rest on the top")
                return found, int(np.ceil((t - release) / 2))
        for last in LAST:
            grid = GRIDS[last]
            z, s = moved(t, grid), speed(t, grid)
            away = -wall * z  # distance from the membrane left: from 0 to d
            turns = np.flatnonzero(s[:-1] * s[1:] < 0) + 1
            hit = np.flatnonzero((away[1:] <= 0) | (away[1:] >= d)) + 1
            ends = [int(hit[0])] if len(hit) else []
            for k in turns:
                if ends and k > ends[0]:
                    break
                low, _ = crossing(partial(speed, t), partial(pull, t), grid[k - 1], grid[k])
                top = -wall * moved(t, low)
                if top >= d or top <= 0:
                    grid, ends = np.insert(grid, k, low), [int(k)]
                    away = np.insert(away, k, top)
                    break
            if ends:
                break
        else:
            raise ArithmeticError("a long flight")
        k = ends[0]
        other = away[k] >= d
        end = d if other else LONG(0)
        _, high = crossing(partial(beyond, t, -wall, end), partial(outward, t, -wall), grid[k - 1], grid[k])
        before = speed(t, high)
        t, wall = t + high, -wall if other else wall
        found.append((wall, t, before))
        v = -r * before
    return found, None


def pressing(g: LONG, wall: int, t: LONG) -> list[LONG]:
    """The acceleration towards a membrane, and its derivatives."""
    sine, cosine = np.sin(PI * t), np.cos(PI * t)
    turns = [cosine, -sine, -cosine, sine] * (TERMS // 4 + 1)
    return [wall * (g + cosine), *(wall * PI**n * turns[n] for n in range(1, TERMS))]


def hop(g: LONG, wall: int, t: LONG, u: LONG) -> tuple[LONG, LONG] | None:
    """Duration of a hop that leaves a membrane with a speed, and the speed on landing; None if it is long."""
    powers, orders = np.array(pressing(g, wall, t)), np.arange(1, TERMS + 1).astype(LONG)
    fall = powers / np.cumprod(orders)  # speed gained towards the membrane: sum of fall s^order

    mean = (fall / (orders + 1))[::-1]
    slope = (fall * orders / (orders + 1))[::-1]

    def short(s: LONG) -> LONG:
        """By how much the ball is past the membrane, over the time."""
        return s * np.polyval(mean, s) - u

    least = min(SHORT, u / (abs(powers[0]) + 4))
    grid = SHORT * (least / SHORT) ** FALLING
    past = np.flatnonzero(short(grid) >= 0)
    if not len(past):
        return None
    _, high = crossing(short, partial(np.polyval, slope), grid[max(past[0] - 1, 0)], grid[past[0]])
    return high, high * np.polyval(fall[::-1], high) - u


def rests(g: LONG, wall: int, t: LONG, u: LONG, r: LONG) -> bool:
    """Whether all hops that are left end while the ball is pressed as now."""
    a, fall, bend = pressing(g, wall, t)[:3]
    if u > SLOW or a <= 0:
        return False
    left = 2 * u / (a * (1 - r))
    return bool(abs(fall) * left + abs(bend) * left * left < a / 1000)


def outcome(d: float, gbar: float, r: float, impacts: int = 400) -> tuple[str, str, int] | None:
    """What the ball comes to: kind, word and forcing periods; None where that is not seen."""
    try:
        found, periods = follow(d, gbar, r, impacts)
    except ArithmeticError:
        return None
    return ("rest_cycle", "", periods) if periods is not None else repeated(found, 1e-6)


def repeated(found: list[tuple[int, LONG, LONG]], close: float) -> tuple[str, str, int] | None:
    """The motion that the last impacts are, if they repeat so closely.

    Not seen is one that they nearly repeat: on a slow approach from either side in turn they are nearer to twice it.
    """
    wall = np.array([row[0] for row in found])
    time, speed = (np.array([row[k] for row in found], dtype=LONG) for k in (1, 2))
    for length in range(1, 33):
        late = (time[-1] - time[-1 - length]) / 2
        same = (wall[-2 * length :] == np.roll(wall[-2 * length :], length)).all()
        apart = np.abs(speed[-length:] - speed[-2 * length : -length]).max()
        nearly = same and apart < NEARLY * close and abs(late - np.round(late)) < NEARLY * 1e-6
        if nearly and not (apart < close and abs(late - np.round(late)) < 1e-6):
            return None
        if nearly:
            letters = "".join("B" if each > 0 else "T" for each in wall[-length:])
            word = min(letters[i:] + letters[:i] for i in range(length))
            return ("reaches_1_1" if (word, round(late)) == ("BT", 1) else "other_motion"), word, round(float(late))
    return None
