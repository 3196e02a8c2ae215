"""A simulator of its own, in 80 bits and from the model alone: Z'' = gbar + cos(pi t), Z' -> -r Z' at Z = +-d/2.

It follows the ball from the release on the bottom membrane. Flights are sampled, with a grid that begins as finely as a
hop is short, and crossings bisected; hops slower than 1e-11 on a membrane that the ball is pressed onto are rest.
"""

from __future__ import annotations

from functools import partial

import numpy as np

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
SLOW = LONG(1e-11)
LAST = (1.5, 8.0)
"""How far a flight is sampled, and how far if it does not end before [t_c]."""


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
    """Impacts (wall, time, speed) from the release, and the forcing periods to the next release, None before it."""
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

    for _ in range(impacts):
        first = (
            min(max(abs(v) / max(abs(pull(t, 0)), LONG(0.1)) / 4, LONG(1e-13)), LONG(0.005)) if v != 0 else LONG(0.01)
        )
        fine = first * LONG(1.15) ** np.arange(0, 1 + int(np.ceil(np.log(0.01 / float(first)) / np.log(1.15))))
        for last in LAST:
            grid = np.concatenate([[LONG(0)], fine, fine[-1] + LONG(0.01) * np.arange(1, int(last / 0.01))])
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
                if top >= d or (top <= 0 and k > 1):
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
        pressed = wall * (g + np.cos(PI * t))
        if abs(v) < SLOW and pressed > 0:
            if wall < 0:
                raise ArithmeticError("rest on the top")
            return found, int(np.ceil((t - release) / 2))
    return found, None


def outcome(d: float, gbar: float, r: float) -> tuple[str, str, int] | None:
    """What the ball comes to: kind, word and forcing periods; None where that is not seen."""
    return seen_within(d, gbar, r, 120, 1e-12) or seen_within(d, gbar, r, 400, 1e-6)


def seen_within(d: float, gbar: float, r: float, impacts: int, close: float) -> tuple[str, str, int] | None:
    """What the ball comes to within so many impacts, the last of which are a motion if they repeat so closely."""
    try:
        found, periods = follow(d, gbar, r, impacts)
    except ArithmeticError:
        return None
    if periods is not None:
        return "rest_cycle", "", periods
    wall = np.array([row[0] for row in found])
    time, speed = (np.array([row[k] for row in found], dtype=LONG) for k in (1, 2))
    for length in range(1, 33):
        late = (time[-1] - time[-1 - length]) / 2
        same = (wall[-2 * length :] == np.roll(wall[-2 * length :], length)).all()
        apart = np.abs(speed[-length:] - speed[-2 * length : -length]).max()
        if same and apart < close and abs(late - np.round(late)) < 1e-6:
            letters = "".join("B" if each > 0 else "T" for each in wall[-length:])
            word = min(letters[i:] + letters[:i] for i in range(length))
            return ("reaches_1_1" if (word, round(late)) == ("BT", 1) else "other_motion"), word, round(float(late))
    return None
