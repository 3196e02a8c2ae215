"""The time of one rest cycle in as many digits as it takes, from the model alone: for laps that lose fifty of them."""

from __future__ import annotations

import numpy as np
from mpmath import acos, ceil, cos, mp, mpf, pi, sin

SLOW, STEP = 1e-8, 1e-3


def periods(d: float, gbar: float, r: float, digits: int, most: int = 200) -> int | None:
    """Forcing periods from a release on the bottom to the next rest there; None if that takes more impacts than `most`.

    Crossings are looked for in doubles, which are as near to the ball's true way as each flight begins, and solved for
    by Newton's method in all digits.
    """
    with mp.workdps(digits):
        d, g, r = mpf(d), mpf(gbar), mpf(r)
        release = t = acos(-g) / pi
        wall, v = 1, mpf(0)
        for _ in range(most):
            phase, pull = pi * t, wall * (g + cos(pi * t))
            left = 2 * abs(v) / (pull * (1 - r)) if v else mpf(0)
            if 0 < abs(v) < SLOW and pull > 0 and pi * left < 1e-6 * pull:
                return int(ceil((t + left - release) / 2)) if wall > 0 else None

            def away(s, phase=phase, wall=wall, v=v):
                drift = v + g * s / 2 - sin(phase) / pi
                return -wall * (drift * s - (cos(phase + pi * s) - cos(phase)) / pi**2)

            def speed(s, phase=phase, v=v):
                return v + g * s + (sin(phase + pi * s) - sin(phase)) / pi

            low, high, far = bracket(float(phase % (2 * pi)), wall, float(v), float(g), float(d), away, speed)
            s = high
            for _ in range(60):
                past = away(s) - far
                low, high = (low, s) if (past >= 0) == bool(far) else (s, high)
                step = s + past / (wall * speed(s))
                s, before = step if low <= step <= high else (low + high) / 2, s
                if abs(s - before) < mpf(10) ** (3 - digits):
                    break
            t, v, wall = t + s, -r * speed(s), -wall if far else wall
    return None


def bracket(phase: float, wall: int, v: float, g: float, d: float, away, speed):
    """Two moments between which the ball comes to a membrane, and how far that is from the one it has left."""
    first = max(1e-14, 1e-3 * abs(v)) if v else 1e-6
    grid = np.concatenate([np.geomspace(first, STEP, 400)[:-1], STEP * np.arange(1, 8000)])
    z = (v + g * grid / 2 - np.sin(phase) / np.pi) * grid - (np.cos(phase + np.pi * grid) - np.cos(phase)) / np.pi**2
    y = -wall * z
    hits = (int(k) for k in np.flatnonzero((y <= 0) | (y >= d)) if not 0 < away(mpf(grid[k])) < d)
    k = next(hits)
    high = mpf(grid[k])
    turns = (y[1 : k - 1] - y[: k - 2]) * (y[2:k] - y[1 : k - 1]) < 0
    for i in np.flatnonzero(turns & (np.minimum(y[1 : k - 1], d - y[1 : k - 1]) < 1e-5)) + 1:
        turn = mp.findroot(speed, mpf(grid[i]), verify=False)
        if not 0 < away(turn) < d:
            k, high = int(i), turn
            break
    return mpf(grid[k - 1]), high, d if away(high) >= d else 0
