"""Impacts of many starts at once: the event search of `kernel` behind arrays, on one core or several.

It turns starts (on a membrane or between them) into rows of impacts. It knows no periodic motion, and imports the
compiler only with the first impact.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, lru_cache
from itertools import pairwise
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import install_command
from vireport.physics import flight
from vireport.physics.forcing import Harmonic, unaccelerated, wave
from vireport.physics.groups import Groups, SpeedLaw
from vireport.simulation import kernel
from vireport.simulation.compiled import compiled_rubbed_search, compiled_search
from vireport.simulation.kernel import (
    PHASE,
    TURN,
    VELOCITY,
    WALL,
)

if TYPE_CHECKING:
    from vireport.physics.cubics import Cubics

BOTTOM, TOP = 1, -1
COLUMNS = 6
# Counts of numbers in a row: of flights and constant restitutions; with exponent and speed of a law of restitution, all
# of a device whose force is a sine; and of each harmonic, which follow. Last comes friction, if there is any.
CONSTANT, OF_SINE, OF_HARMONIC = 4, 6, 3
# Parts per core: enough to even out slow and fast parameters.
PARTS = 8
# Without the compiler an impact takes about this long [s]; a job that may take longer than the other says so [s].
INTERPRETED_IMPACT, LONG = 1e-5, 5.0
# Number of devices whose zeros of the acceleration are remembered: a ball that is followed block by block needs them
# before each block, and they take as long as some hundred impacts.
REMEMBERED = 64

Array = NDArray[np.float64]


class Impact(Struct, frozen=True):
    """A start on a membrane, at the moment of an impact.

    Parameters
    ----------
    wall : int
        BOTTOM (+1, at Z = d/2) or TOP (-1, at Z = -d/2).
    velocity : float
        Relative velocity Z' just before the impact [y_c]: not below zero at the bottom, not above at the top.
    phase : float
        Forcing phase at the impact [rad].
    """

    wall: int
    velocity: float
    phase: float


class InFlight(Struct, frozen=True):
    """Start strictly between the membranes.

    Parameters
    ----------
    position : float
        Relative position Z [x_c], with ``|Z| < d/2``.
    velocity : float
        Relative velocity Z' [y_c].
    phase : float
        Forcing phase [rad].
    """

    position: float
    velocity: float
    phase: float


Start = Impact | InFlight


def wrapped(phase: float) -> float:
    """Phase reduced to [0, 2 pi)."""
    reduced = phase % TURN
    return reduced if reduced < TURN else 0.0


def check_model(groups: Groups[Any]) -> Array:
    """Dimensionless groups as rows of an array, broadcast and checked.

    Parameters
    ----------
    groups : Groups
        Of n devices, as arrays (n,) or numbers.

    Returns
    -------
    array (n, 6 + 3 h), with friction (n, 6 + 3 h + 1)
        A row is d, gbar, the restitutions at the bottom and at the top, the exponent of the speed with which they fall
        and the speed at which they are stated (0 and 1 if constant), order, cosine and sine of each of h harmonics, and
        the friction, if there is any.

    Raises
    ------
    ValueError
        If the groups describe no device, or friction together with restitutions that fall with speed.
    """
    parts = [number for harmonic in groups.harmonics for number in (harmonic.order, harmonic.cosine, harmonic.sine)]
    law = (0.0, 1.0) if groups.law is None else (groups.law.exponent, groups.law.speed)
    rubbing = () if groups.friction is None else (groups.friction,)
    if rubbing and groups.law is not None:
        raise ValueError("friction and restitutions that fall with speed are not simulated together")
    numbers = *groups.numbers[:CONSTANT], *law, *parts, *rubbing
    model = np.stack(np.broadcast_arrays(*np.atleast_1d(*numbers)), axis=-1).astype(float)
    if not np.isfinite(model).all():
        raise ValueError("d, gbar and r must be finite")
    plain, (exponent, speed) = model[:, :CONSTANT], model[:, CONSTANT:OF_SINE].T
    if (plain[:, 0] <= 0).any() or (plain[:, 1:] < 0).any() or (plain[:, 2:] > 1).any():
        raise ValueError("need d > 0, gbar >= 0 and 0 <= r <= 1")
    if (exponent <= -1).any() or (exponent > 0).any() or (speed <= 0).any():
        raise ValueError("need restitutions that fall with the speed to a power above -1, stated at a speed above 0")
    if groups.friction is not None and (model[:, -1] < 0).any():
        raise ValueError("need friction >= 0")
    return np.ascontiguousarray(model)


def groups_of(model: Array) -> Groups[float]:
    """Dimensionless groups from a row of `check_model`."""
    d, gbar, bottom, top, exponent, speed = map(float, model[:OF_SINE])
    groups = Groups.of(d, gbar, bottom, top)._replace(harmonics=harmonics_of(model), friction=friction_of(model))
    return groups._replace(restitution=SpeedLaw(bottom, top, exponent, speed)) if exponent else groups


def rebounds(model: Array, wall: Array, velocity: Array) -> tuple[Array, Array]:
    """Restitutions r(|v|) of impacts, and derivatives of r(|v|) |v| by |v|, see `flight.restitution_at_speed`.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    wall, velocity : array (n,)
        Membranes, and velocities before the impacts [y_c].
    """
    exponent, speed = model[CONSTANT:OF_SINE]
    r = np.where(wall > 0, model[2], model[3])
    return flight.restitution_at_speed(r, np.abs(velocity) / speed, exponent) if exponent else (r, r)


def harmonics_of(model: Array) -> tuple[Harmonic, ...]:
    """Harmonics of the force from a row of `check_model`."""
    numbers = model[OF_SINE : len(model) - rubs(model)].reshape(-1, OF_HARMONIC).tolist()
    return tuple(Harmonic(int(order), a, b) for order, a, b in numbers)


def rubs(model: Array) -> bool:
    """Whether `check_model` has made an array, or a row of it, for a ball with friction."""
    return bool((model.shape[-1] - OF_SINE) % OF_HARMONIC)


def friction_of(model: Array) -> float | None:
    """The group friction, see `Groups`, from a row of `check_model`; None for a ball without it."""
    return float(model[-1]) if rubs(model) else None


def zeros_of_pull(model: Array, way: int = 0) -> Array:
    """Forcing phases of the zeros of Z'', between which the search has concave or convex pieces of a flight.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    way : int
        Sign of Z', for a ball with friction that moves.

    Returns
    -------
    array (m, 2)
        Ascending phases [rad], and the sign that makes Z concave from there to the next. At least one: where Z'' has
        no zero, any phase cuts the period.
    """
    groups = groups_of(model)
    phases = np.array(unaccelerated(groups.gravity(way), groups.harmonics) or [0.0])
    middle = phases + np.diff(phases, append=phases[0] + TURN) / 2
    pull = groups.pull(wave(np.sin(middle), np.cos(middle), groups.harmonics).force, way)
    return np.column_stack([phases, np.where(pull > 0, -1.0, 1.0)])


def _forced(model: Array) -> tuple[Array, Array] | tuple[None, None]:
    """Harmonics (n, h, 3) and zeros of Z'' (n, m, 2) of rows of `check_model`, without friction; None for a sine."""
    if model.shape[1] == OF_SINE:
        return None, None
    return np.ascontiguousarray(model[:, OF_SINE:].reshape(len(model), -1, 3)), _zeros(model, (0,))[:, 0].copy()


def search_data(model: Array) -> tuple[Array, Array, Array]:
    """Arrays that the search of a ball with friction takes, from rows of `check_model`.

    Returns
    -------
    plain : array (n, 5)
        d, gbar, restitutions at the bottom and at the top, friction.
    harmonics : array (n, h, 3)
    zeros : array (n, 2, m, 2)
        Zeros of Z'', on the way up and on the way down, see `zeros_of_pull`.
    """
    harmonics = model[:, OF_SINE:-1].reshape(len(model), -1, OF_HARMONIC)
    plain = np.column_stack([model[:, :CONSTANT], model[:, -1]])
    return plain, np.ascontiguousarray(harmonics), _zeros(model, (-1, 1))


def _zeros(model: Array, ways: tuple[int, ...]) -> Array:
    """The zeros of Z'' of rows of `check_model` for each of w signs of Z', filled up to the same number, (n, w, m, 2).

    A ball that is followed block by block has one row, whose zeros are remembered; of many, equal rows are solved once.
    """
    if len(model) == 1:
        return _zeros_of_row(model.tobytes(), ways).copy()
    _, first, which = np.unique(model[:, 1:], axis=0, return_index=True, return_inverse=True)
    return _zeros_of_rows(model[first], ways)[which.ravel()]


@lru_cache(REMEMBERED)
def _zeros_of_row(row: bytes, ways: tuple[int, ...]) -> Array:
    """`_zeros` of one row, by its bytes, which can be a key of the cache."""
    return _zeros_of_rows(np.frombuffer(row)[None], ways)


def _zeros_of_rows(rows: Array, ways: tuple[int, ...]) -> Array:
    """`_zeros` of rows, each solved."""
    zeros = [[zeros_of_pull(row, way) for way in ways] for row in rows]
    most = max(len(phases) for of_row in zeros for phases in of_row)
    return np.stack([np.stack([_filled(phases, most) for phases in of_row]) for of_row in zeros])


def _filled(zeros: Array, count: int) -> Array:
    """Zeros of Z'', filled up to a number by phases that are no zeros: all rows of an array have as many."""
    last, sign = zeros[-1]
    # What is added cuts the last piece without a change of sign: it stays concave or convex, as it was.
    more = count - len(zeros)
    return np.vstack([zeros, *((last + (TURN - last) * k / (more + 1), sign) for k in range(1, more + 1))])


def check_start(start: Start, d: float) -> tuple[float, float, float, float]:
    """A start as the row (wall, position, velocity, phase) of the search; ValueError if it is impossible.

    The wall is 0 for a start in flight, the position 0 for a start at an impact; the phase is in [0, 2 pi).
    """
    if not (isfinite(start.velocity) and isfinite(start.phase)):
        raise ValueError(f"start is not finite: {start}")
    if isinstance(start, InFlight):
        if not abs(start.position) < 0.5 * d:
            raise ValueError(f"position {start.position} is not strictly between the membranes, |Z| < {0.5 * d}")
        return 0.0, start.position, start.velocity, wrapped(start.phase)
    if start.wall not in (BOTTOM, TOP):
        raise ValueError(f"wall must be {BOTTOM} (bottom) or {TOP} (top), not {start.wall}")
    if start.wall * start.velocity < 0:
        raise ValueError(f"velocity {start.velocity} before the impact points away from the wall it hits")
    return float(start.wall), 0.0, start.velocity, wrapped(start.phase)


def start_of(row: Array) -> Start:
    """The start that a row of `check_start` stands for."""
    wall, position, velocity, phase = map(float, row)
    return Impact(int(wall), velocity, phase) if wall else InFlight(position, velocity, phase)


def start_rows(starts: Sequence[Start] | Array, d: Array) -> Array:
    """Rows of `check_start` (n, m, 4) for m starts at each of n distances d of the membranes [x_c].

    Parameters
    ----------
    starts : sequence of Impact or InFlight, or array (n, m, 4)
        Starts for all distances; or rows for each distance.
    d : array (n,)

    Raises
    ------
    ValueError
        If a start is impossible, there is none, or there are starts for another number of distances.
    """
    if isinstance(starts, np.ndarray):
        by_parameter, count = [list(map(start_of, of_parameter)) for of_parameter in starts], starts.shape[1]
    else:
        by_parameter, count = [list(starts)] * len(d), len(starts)
    if count == 0:
        raise ValueError("at least one start is needed")
    if len(by_parameter) != len(d):
        raise ValueError(f"starts for {len(by_parameter)} parameters, of which there are {len(d)}")
    rows = [
        [check_start(start, float(distance)) for start in of_parameter]
        for of_parameter, distance in zip(by_parameter, d, strict=True)
    ]
    return np.array(rows).reshape(len(d), count, 4)


def follow_impacts(
    model: Array, starts: Array, impacts: int, keep: int | None = None, workers: int = 1, compiled: bool = True
) -> tuple[Array, Array]:
    """Follow each start for a number of impacts, or to its end.

    Parameters
    ----------
    model : array (n, 6 + 3 h)
        From `check_model`.
    starts : array (n, 4)
        Rows of `check_start`.
    impacts : int
        Number of impacts after which a trajectory is cut.
    keep : int, optional
        Rows kept of each trajectory, the last ones; all by default.
    workers : int
        Number of threads. The result does not depend on it.
    compiled : bool
        Whether to compile the search, where numba is there. A few thousand impacts are faster without.

    Returns
    -------
    rows : array (n, keep, 6)
        In order of time, the last impact last; where fewer happened, the rows before the start are NaN.
    summary : array (n, 3)
        Number of impacts, number of sine-cosine pairs evaluated, and the status of `kernel`, such as RUNNING or REST.
    """
    rubbed, count = rubs(model), len(model)
    search = _search(rubbed, compiled, count * impacts)
    keep = impacts + 1 if keep is None else min(keep, impacts + 1)
    rows, summary = np.full((count, keep, COLUMNS), np.nan), np.zeros((count, 3))
    plain, harmonics, zeros = search_data(model) if rubbed else (_plain(model), *_forced(model))
    laws = _laws(model)

    def run(part: slice) -> None:
        """Follow some of the starts."""
        forced = [None if column is None else column[part] for column in (harmonics, zeros)]
        arguments = (*forced,) if rubbed else (None if laws is None else laws[part], *forced, None)
        with np.errstate(all="ignore"):  # the compiled search raises no flags, the interpreted one must not
            search(plain[part], starts[part], impacts, rows[part], summary[part], *arguments)

    if workers > 1 and count > 1:
        from concurrent.futures import ThreadPoolExecutor

        edges = np.linspace(0, count, min(count, PARTS * workers) + 1).astype(int)
        run(slice(0, 0))  # compile once, not in each thread
        with ThreadPoolExecutor(workers) as pool:
            list(pool.map(run, [slice(a, b) for a, b in pairwise(edges)]))
    else:
        run(slice(0, count))
    return _ordered(rows, summary[:, 0]), summary


def follow_recorded(
    model: Array, start: Sequence[float], cubics: Cubics, impacts: int, compiled: bool = True
) -> tuple[Array, Array]:
    """Follow one start under a force that was recorded, from the beginning of the record to its end.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`, whose force is not used.
    start : sequence of float
        A row of `check_start`; its phase is that of a sine of the force's frequency.
    cubics : Cubics
        The relative acceleration as it was recorded.
    impacts : int
        Number of impacts after which the trajectory is cut.
    compiled : bool
        As in `follow_impacts`.

    Returns
    -------
    rows : array (n + 1, 6)
        The start and the impacts, in order of time.
    summary : array (3,)
        As in `follow_impacts`; the status says whether at the end of the record the ball lies on a membrane or flies.

    Raises
    ------
    ValueError
        If the model has friction.
    """
    if rubs(model):
        raise ValueError("friction is not simulated with a recorded force")
    search, rows = _search(False, compiled, len(cubics.rows)), np.full((1, impacts + 1, COLUMNS), np.nan)
    models, starts, summary = model[None], np.array([start], dtype=float), np.zeros((1, 3))
    with np.errstate(all="ignore"):
        search(_plain(models), starts, impacts, rows, summary, _laws(models), None, None, cubics.rows)
    return rows[0, : int(summary[0, 0]) + 1], summary[0]


def _search(rubbed: bool, compiled: bool, steps: int) -> Callable[..., None]:
    """The function of `kernel` that follows starts, with friction or without, compiled where that is possible.

    It warns where so many impacts, or pieces of a recorded force, take long in the interpreter.
    """
    search = None
    if compiled:
        search = compiled_rubbed_search() if rubbed else compiled_search()
    if compiled and search is None and steps * INTERPRETED_IMPACT > LONG:
        _say_that_it_is_slow()
    return search or (kernel.follow_rubbed_starts if rubbed else kernel.follow_starts)


def _plain(model: Array) -> Array:
    """The columns d, gbar and both restitutions of rows of `check_model`, as the search without friction takes them."""
    return np.ascontiguousarray(model[:, :CONSTANT])


def _laws(model: Array) -> Array | None:
    """Laws of restitution of rows of `check_model`, see `kernel.follow_starts`; None where all are constant."""
    if not model[:, CONSTANT].any():
        return None
    # A constant restitution among others is one that does not fall, and may be as large as 1.
    most = np.where(model[:, CONSTANT] == 0, 1.0, flight.LARGEST_RESTITUTION)
    return np.column_stack([model[:, CONSTANT:OF_SINE], most])


@cache
def _say_that_it_is_slow() -> None:
    """Warn that the simulation runs without a compiler, once in a process."""
    from logging import getLogger

    getLogger(__name__).warning(
        "the simulation is interpreted, some hundred times slower than compiled, as the package numba is missing: %s",
        install_command("numba"),
    )


def follow_one(
    model: Array, start: Sequence[float], impacts: int, keep: int | None = None, compiled: bool = True
) -> tuple[Array, Array]:
    """Follow a single start as `follow_impacts` does, and leave out the rows that did not happen.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    start : sequence of float
        A row of `check_start`.
    impacts, keep, compiled
        As in `follow_impacts`.

    Returns
    -------
    rows : array (n, 6)
    summary : array (3,)
    """
    rows, summary = follow_impacts(model[None], np.array([start], dtype=float), impacts, keep, compiled=compiled)
    happened = int(summary[0, 0]) + 1
    return rows[0, max(0, rows.shape[1] - happened) :], summary[0]


def as_start(row: Array) -> tuple[float, float, float, float]:
    """The row of `check_start` from which a ball continues after an impact, a row of `kernel`."""
    return float(row[WALL]), 0.0, float(row[VELOCITY]), float(row[PHASE])


def as_starts(rows: Array) -> Array:
    """Rows of `check_start` (n, 4) from which balls continue, each after its impact, rows of `kernel` (n, 6)."""
    return np.stack([rows[:, WALL], np.zeros(len(rows)), rows[:, VELOCITY], rows[:, PHASE]], axis=1)


def _ordered(rows: Array, count: Array) -> Array:
    """Rows in the order of time, of rings in which impact i of a trajectory was written to row i mod keep."""
    keep = rows.shape[1]
    last = count.astype(int)[:, None]
    place = (last + 1 + np.arange(keep)) % keep
    if np.array_equal(place[:, 0], np.zeros(len(rows))):
        return rows
    ordered: Array = np.take_along_axis(rows, place[:, :, None], axis=1)
    return ordered
