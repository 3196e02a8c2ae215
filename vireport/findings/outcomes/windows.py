"""Where along an input the outcome of switching on stays the same: around the design point, and along the sweep.

Edges are sharp, and at many of them infinitely many others accumulate: the record of an edge says so.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from math import sqrt
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import brief
from vireport.design.from_rest import FromRest
from vireport.design.outcomes_from_rest import OutcomeRange, OutcomesAt, outcomes_at
from vireport.design.solution import Solution
from vireport.scenario.parameters import ScalarInput

EDGE = 1e-9
"""Width to which the edges of a window are found, over the value."""

GOLDEN = (1 + sqrt(5)) / 2
"""By this the places of such values are shifted each time: never again to the same."""

COARSE = 64
"""Values between the design point and either end of what is looked through for an edge."""

FINER = 16
"""Parts of an interval with an edge, of which the one with the nearest is taken in its stead."""

DEEP = 1e-4
"""An interval this narrow, over the value, that still has several edges is one where edges accumulate."""

INSIDE, NEAREST, ROUNDS, CLEAN = 64, 1e-8, 24, 4
"""Values between an edge and the design point at which it is looked for a nearer one, spread evenly, and as many ever
closer to the edge, down to this share of the way; how often anew, and how often in a row in vain where edges
accumulate. There they are the narrower the nearer they are, and the first samples pass them over: by as much as a
hundred windows at s = 0.95 m. Samples cannot prove an edge to be the nearest."""

WIDEST = 0.5
"""How far from the design value it is looked for where a window ends, over that value, where no sweep says how far."""

UNTOLD = 1e-5
"""Distance, over the value, from where a motion ceases to be stable within which disturbances die out too slowly."""

SWEEP_VALUES = 201
"""Values along a sweep, between which edges are then located."""

STRIP_EDGE = 1e-6
"""Width to which an edge along a sweep is located, over the sweep."""


class Edge(Struct, frozen=True):
    """Where the outcome of switching on changes, on the way from the design point.

    Attributes
    ----------
    value : float
        Last value of the input that was found with the outcome of the design point.
    beyond : FromRest or None
        The outcome just beyond; None where it does not change in the range searched.
    accumulates : bool
        Whether infinitely many edges accumulate there.
    """

    value: float
    beyond: FromRest | None
    accumulates: bool


class Window(Struct, frozen=True):
    """The interval of an input around the design point in which the outcome of switching on stays.

    Attributes
    ----------
    parameter : ScalarInput
    value : float
        At the design point.
    low, high : Edge
    """

    parameter: ScalarInput
    value: float
    low: Edge
    high: Edge

    __repr__ = brief

    @property
    def nearest(self) -> Edge | None:
        """The edge nearer to the design point, of those that were found; None where none was."""
        edges = [edge for edge in (self.low, self.high) if edge.beyond is not None]
        return min(edges, key=self.distance, default=None)

    def distance(self, edge: Edge) -> float:
        """Distance of an edge from the design point, in the unit of the input."""
        return abs(edge.value - self.value)


def window(parameter: ScalarInput, value: float, low: float, high: float, outcomes: OutcomesAt) -> Window:
    """Find the interval of an input around a design point in which the outcome of switching on stays the same.

    Parameters
    ----------
    parameter : ScalarInput
    value : float
        At the design point.
    low, high : float
        Ends of the range that is searched.
    outcomes : callable
        From values of the input to the outcomes there.
    """
    (outcome,) = outcomes(np.array([value]))
    centre = _Centre(value, outcome, outcomes)
    return Window(parameter, value, *(_edge(centre, end) for end in (low, high)))


class _Centre(NamedTuple):
    """The design point within a window, with its outcome, and the function that finds outcomes at other values."""

    value: float
    outcome: FromRest
    outcomes: OutcomesAt


def _edge(centre: _Centre, end: float) -> Edge:
    """The edge nearest to a design point on the way to an end, as far as samples tell."""
    value, around, outcomes = centre
    edge, clean = _first_edge(centre, value, end, COARSE), 0
    limit = edge.value  # where edges accumulate: the nearer to it, the closer together they are
    for turn in range(ROUNDS):
        if edge.value == value:
            break  # none is nearer
        shares = (np.arange(INSIDE) + (turn / GOLDEN) % 1) / INSIDE
        values = edge.value + (value - edge.value) * np.append(shares, NEAREST**shares)
        if clean:  # as many again in every decade of the distance to the limit
            nearest = max((edge.value - limit) / (value - limit), NEAREST)
            shares = np.append(shares, (shares + 0.5 / INSIDE) % 1)
            values = np.append(values, limit + (value - limit) * nearest**shares)
        # On the way out from the design point, so that the first one that differs is the nearest.
        values = np.sort(values)[:: 1 if value < end else -1]
        first = next((k for k, outcome in enumerate(outcomes(values)) if outcome.kind != around.kind), None)
        if first is None:
            clean += 1
            if not edge.accumulates or clean == CLEAN:
                break
            continue
        clean = 0
        near = float(values[first - 1]) if first else value
        edge = replace(_first_edge(centre, near, float(values[first]), FINER), accumulates=True)
    return edge


def _first_edge(centre: _Centre, near: float, end: float, parts: int) -> Edge:
    """The first edge between samples on the way from a value to an end, refined."""
    (value, around, outcomes), far = centre, end
    beyond: FromRest | None = None
    accumulates = False
    while near != far:
        values = np.linspace(near, far, parts + 1)[1:]
        ahead = enumerate(outcomes(values))
        first, changed = next(((k, outcome) for k, outcome in ahead if outcome.kind != around.kind), (-1, None))
        if changed is None:
            if beyond is None:
                return Edge(end, None, False)
            break  # the far end had another outcome before: the ends are equal to rounding
        # Where the outcome returns within so short an interval beyond an edge, there are further edges nearer still.
        narrow = abs(far - near) < DEEP * abs(value)
        accumulates = accumulates or (narrow and any(outcome.kind == around.kind for _, outcome in ahead))
        near, far, beyond = float(values[first - 1]) if first else near, float(values[first]), changed
        if abs(far - near) <= EDGE * max(abs(value), abs(end - value)):
            break
        parts = FINER
    return Edge(near, beyond, accumulates)


def over_sweep(start: float, end: float, outcomes: OutcomesAt) -> tuple[OutcomeRange, ...]:
    """The ranges of a sweep with one outcome each, by 201 values and bisection between those that differ."""
    # Evenly, as it is not known where outcomes change. A range narrower than the spacing may be passed over.
    values = np.linspace(min(start, end), max(start, end), SWEEP_VALUES)
    sampled = tuple(outcomes(values))
    pairs = zip(pairwise(values.tolist()), pairwise(sampled), strict=True)
    brackets = [(*ends, before) for ends, (before, after) in pairs if before.kind != after.kind]
    edges = np.array([bracket[:2] for bracket in brackets], dtype=float).reshape(-1, 2)
    kinds = [before.kind for *_, before in brackets]
    # All edges at once: one outcome of many takes 0.6 ms, a single one 3 ms, as their 1:1 motions are found together.
    while len(edges) and (edges[:, 1] - edges[:, 0]).max() > STRIP_EDGE * (values[-1] - values[0]):
        middle = edges.mean(axis=1)
        same = np.array([outcome.kind == kind for outcome, kind in zip(outcomes(middle), kinds, strict=True)])
        edges = np.where(same[:, None], np.stack([middle, edges[:, 1]], 1), np.stack([edges[:, 0], middle], 1))
    places = [float(values[0]), *edges.mean(axis=1).tolist(), float(values[-1])]
    firsts = [0, *(i + 1 for i, (a, b) in enumerate(pairwise(sampled)) if a.kind != b.kind)]
    return tuple(OutcomeRange(*ends, sampled[first]) for ends, first in zip(pairwise(places), firsts, strict=True))


def window_of(solution: Solution, compiled: bool) -> Window | None:
    """The window along the input that is swept or, without a sweep, that in which stable motion ends first."""
    design, sweep = solution.design, solution.sweep
    ends = design.limits() if design is not None else []
    if sweep is None and not ends:
        return None
    varied = sweep.parameter if sweep is not None else ends[0].parameter
    value = float(solution.device.value_of(varied))
    low, high = sorted((sweep.start, sweep.end)) if sweep is not None else (value, value)
    # A sweep that does not contain the design point gives no range around it: as without a sweep, one is chosen.
    if not low < value < high:
        low, high = max(value * (1 - WIDEST), varied.limits[0]), min(value * (1 + WIDEST), varied.limits[1])
    window_around = window(varied, value, low, high, partial(outcomes_at, solution.device, varied, compiled=compiled))
    stability_ends = [value + end.distance for end in ends if end.parameter == varied]
    return replace(
        window_around, low=_at_end(window_around.low, stability_ends), high=_at_end(window_around.high, stability_ends)
    )


def _at_end(edge: Edge, ends: list[float]) -> Edge:
    """An edge beyond which the simulation gives no outcome, moved to the end of stable motion that causes this."""
    if edge.beyond is None or edge.beyond.decided:
        return edge
    return next((replace(edge, value=end) for end in ends if abs(end - edge.value) <= UNTOLD * abs(end)), edge)
