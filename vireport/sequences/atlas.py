"""Every family of motions that is reached along a sweep, joined where families meet.

Families are the edges of a graph, and what begins or ends them its vertices. Each start is followed to both ends of its
family; at each event the families that meet there are starts again, until none is new.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import chain, product
from math import asin, pi

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import BifurcationDiagram, CriticalKind, Held, Sweep, solve
from vireport.progress import Progress
from vireport.sequences.continuation import Curve, Event, Strand, completed, follow
from vireport.sequences.equations import Model
from vireport.sequences.exclusion import FINEST, MOST_CELLS, Cells, Exclusion
from vireport.sequences.families import Atlas, Claim, Completeness, Family, Mark, Vertex
from vireport.sequences.motions import SAME, Motion, Sequence
from vireport.sequences.polish import PolishedPoint, polished
from vireport.sequences.search import four_impacts, side_of
from vireport.sequences.surface import Motions, onto_sweep
from vireport.sequences.switching import Beginning, Limits, at_rest, neighbours, touching

Floats = NDArray[np.float64]

SAMPLES_OF_ONE = 9
"""Values of the coordinate at which motions with one impact are looked for; each is in closed form."""

NEAR, SQUARES = 1 / 256, 2.0**16
"""Side of squares of flight times [t_c] by which motions are near to those of a family: in the same one or beside; and
more than there are of them in a row."""

REACH = 4
"""Sides of a cell over which a motion is looked for from its centre."""

MEETINGS = Event.PERIOD_DOUBLING, Event.FOLD, Event.PITCHFORK, Event.GRAZING, Event.ZERO_VELOCITY
"""Events that are vertices."""


def atlas(
    sweep: Sweep,
    limits: Limits,
    simulated: Iterable[Motion] = (),
    progress: Progress | None = None,
    finest: float = FINEST,
) -> Atlas:
    """Find and follow the families of motions along a sweep.

    Parameters
    ----------
    sweep : Sweep
    limits : Limits
        Motions beyond them are left out.
    simulated : iterable of Motion
        Found otherwise, as further starts.
    progress : callable, optional
        Called with what is followed next.
    finest : float
        Side of the cells of flight times that are looked through last [t_c], from `FINE` down.
    """
    low, high = (float(end) for end in sweep.coordinate_range)
    model = Model(sweep.level, float(sweep.device.restitution))
    search = _Search(solve(sweep), model, low, high, limits, progress, finest)
    for motion in chain(_starts(search), simulated):
        search.explore(motion)
    return search.atlas()


def _starts(search: _Search) -> Iterator[Motion]:
    """The motions that are known in closed form: 1:1, one on each admissible stretch, and with one impact."""
    for k in range(1, search.limits.periods + 1):
        for branch in search.one_to_one(k).branches if search.limits.impacts > 1 else ():
            for part in branch.segments() if branch.mirror_of is None else ():
                m, i = branch.motions, (part.first + part.last) // 2
                if part.admissible and m.admissible[i]:
                    time = m.phi_bottom[i] / pi + np.array([0.0, 2 * k * m.q[i]])
                    velocity = np.array([m.velocity_bottom[i], m.velocity_top[i]])
                    yield Motion(Sequence((1, -1), k), velocity, time, float(search.sweep.coordinate(m)[i]))
        for c in np.linspace(search.low, search.high, SAMPLES_OF_ONE):
            yield from _with_one_impact(search.model, k, float(c))
        for sequence in search.sequences(3, k):
            yield from search.three_impacts(sequence)
    for k in range(1, search.limits.periods + 1):
        for sequence in search.sequences(4, k):
            yield from search.four_impacts(sequence)


def _with_one_impact(model: Model, k: int, coordinate: float) -> Iterator[Motion]:
    """Motions with one impact on the bottom in k forcing periods: (2.11) and (2.12) over the one flight."""
    _, gbar = model.groups(coordinate)
    sine = pi * k * gbar * (1 - model.r) / (1 + model.r)
    if gbar > 0 and sine < 1:
        for phase in (asin(sine), pi - asin(sine)):
            velocity = np.array([2 * k * gbar / (1 + model.r)])
            yield Motion(Sequence((1,), k), velocity, np.array([phase / pi]), coordinate)


@dataclass(slots=True)
class _Meeting:
    """A vertex while the search goes on; `motion` has its touches as impacts."""

    event: Event
    curve: Curve
    motion: Motion
    families: set[int] = field(default_factory=set)


@dataclass(slots=True)
class _Search:
    diagram: BifurcationDiagram
    model: Model
    low: float
    high: float
    limits: Limits
    progress: Progress | None
    finest: float
    families: list[Family] = field(default_factory=list)
    events: dict[int, list[tuple[int, Event]]] = field(default_factory=dict)
    meetings: list[_Meeting] = field(default_factory=list)
    at_event: dict[tuple[int, int], _Meeting] = field(default_factory=dict)
    queue: deque[Beginning] = field(default_factory=deque)
    undecided: list[Cells] = field(default_factory=list)

    @property
    def sweep(self) -> Sweep:
        """What is swept."""
        return self.diagram.sweep

    def one_to_one(self, periods: int) -> BifurcationDiagram:
        """The 1:1 motions along the sweep that take a number of forcing periods."""
        if periods == self.sweep.device.period_ratio:
            return self.diagram
        return solve(replace(self.sweep, device=replace(self.sweep.device, period_ratio=periods)))

    def sequences(self, count: int, periods: int) -> list[Sequence]:
        """Those with so many impacts, on both membranes, that none is another or its mirror image counted otherwise."""
        found = {
            self.representative(Sequence(walls, periods))
            for walls in product((1, -1), repeat=count)
            if abs(sum(walls)) < count <= self.limits.impacts
        }
        return sorted(found, key=lambda sequence: sequence.word)

    def representative(self, sequence: Sequence) -> Sequence:
        """The one of a sequence's rotations and, in a horizontal capsule, mirror images that stands for all."""
        images = (sequence, sequence.mirrored()) if self.model.level.horizontal else (sequence,)
        return min((image.canonical() for image in images), key=lambda image: image.word)

    def explore(self, motion: Motion) -> None:
        """Follow the family of a motion, and all that it is joined to."""
        motion = self.model.representative(motion)
        curve = self._curve(motion.sequence)
        x = curve.nearest(curve.vector(motion)) if self.limits.admit(motion.sequence) else None
        if x is not None:
            start = curve.point(x, curve.tangent(x))
            self.queue.append((None, curve, start, start))
        while self.queue:
            begins, curve, vertex, first = self.queue.popleft()
            if self._wanted(curve, first.x):
                if self.progress is not None:
                    self.progress(f"following motions of other impact sequences: {curve.sequence.word}")
                strand = follow(curve, first)
                if begins is None:
                    self._add(curve, completed(curve, first, strand))
                else:
                    events = [(0, begins), *((i + 1, event) for i, event in strand.events)]
                    self._add(curve, Strand([vertex, *strand.points], events))

    def _curve(self, sequence: Sequence) -> Curve:
        return Curve(sequence, self.model, self.low, self.high)

    def _wanted(self, curve: Curve, x: Floats) -> bool:
        """Whether a solution is a motion within the limits that lies on no family yet."""
        if not self.limits.admit(curve.sequence) or not curve.admits(x):
            return False
        motion = curve.motion(x)
        if motion.primitive() is not motion:
            return False
        known = (one for family in self._alike(motion) for one in family.at(float(x[-1])))
        return not any(self._same(motion, one) for one in known)

    def three_impacts(self, sequence: Sequence) -> Iterator[Motion]:
        """Motions that lie on no family known; each must be explored before the next is asked for."""
        exclusion = Exclusion(self.model, self.low, self.high, sequence)
        cells, level = exclusion.cells(), self.model.level
        while len(cells):
            cells = cells[~self._near(sequence, cells.centre)]
            starts, flights = onto_sweep(cells.motions, cells.centre, level, REACH * cells.side)
            inside = (starts.coordinate(level) > self.low) & (starts.coordinate(level) < self.high)
            rows = np.flatnonzero(starts.admissible & inside)
            yield from self._unknown(starts[rows], flights[:, rows])
            cells = cells[~self._near(sequence, cells.centre)]
            if cells.side <= self.finest or len(cells) > MOST_CELLS:
                break
            cells = exclusion.halved(cells)
        self.undecided.append(cells)

    def four_impacts(self, sequence: Sequence) -> Iterator[Motion]:
        """The same with four impacts, as far as a search over a grid finds them."""
        yield from self._unknown(*four_impacts(self.model, self.low, self.high, sequence))

    def _unknown(self, motions: Motions, flights: Floats) -> Iterator[Motion]:
        rows = np.flatnonzero(~self._near(motions.sequence, flights))
        while rows.size:
            yield motions.motion(int(rows[0]), self.model.level)
            rows = rows[1:][~self._near(motions.sequence, flights[:, rows[1:]])]

    def _near(self, sequence: Sequence, flights: Floats) -> NDArray[np.bool_]:
        """Which flight times are near to those of motions of a family, or of their images."""
        images = (_images(family, sequence, self.model.level.horizontal) for family in self.families)
        squares = [_squares(image) for image in chain.from_iterable(images)]
        return np.isin(_codes(flights), np.concatenate([np.empty(0), *squares]))

    def _same(self, one: Motion, other: Motion) -> bool:
        return one.distance(other, mirror=self.model.level.horizontal) < SAME

    def _alike(self, motion: Motion) -> Iterator[Family]:
        """Families whose word the motion has, or its mirror image where there is one."""
        words = {motion.sequence.canonical()}
        if self.model.level.horizontal:
            words.add(motion.sequence.mirrored().canonical())
        return (family for family in self.families if family.sequence.canonical() in words)

    def _add(self, curve: Curve, strand: Strand) -> None:
        """Take up a family, and what it meets."""
        x = np.array([point.x for point in strand.points])
        trace = np.array([point.trace for point in strand.points])
        number = len(self.families) + 1
        values = np.asarray(self.sweep.value(*(np.broadcast_to(g, len(x)) for g in self.model.groups(x[:, -1]))))
        self.families.append(Family(number, self.sweep, curve, x, trace, values, ()))
        self.events[number] = strand.events
        for row, event in strand.events:
            meeting = self._meeting(curve.motion(x[row]), event) if event in MEETINGS else None
            if meeting is not None:
                meeting.families.add(number)
                self.at_event[number, row] = meeting

    def _meeting(self, motion: Motion, event: Event) -> _Meeting | None:
        """The vertex at an event, a new one with starts of what else comes to it; None where no motion is left."""
        curve = self._curve(motion.sequence)
        if event in (Event.GRAZING, Event.ZERO_VELOCITY):
            motion, event = touching(motion, self.model.turns(motion)), Event.GRAZING
        motion = self.model.representative(motion.primitive())
        if len(at_rest(motion)) == len(motion.sequence):
            return None
        for meeting in self.meetings:
            if meeting.event is event and self._same(meeting.motion, motion):
                return meeting
        curve = self._curve(motion.sequence)
        self.meetings.append(_Meeting(event, curve, motion))
        self.queue.extend(neighbours(curve, motion, event, self.limits))
        return self.meetings[-1]

    def atlas(self) -> Atlas:
        """What was found, with its events solved for in decimals."""
        order = sorted(self.families, key=lambda f: (len(f.sequence), f.sequence.word, f.sequence.periods, f.number))
        numbers = {family.number: k for k, family in enumerate(order, 1)}
        points = [
            (meeting, polished(self.sweep, meeting.curve, meeting.motion, meeting.event)) for meeting in self.meetings
        ]
        points.sort(key=lambda pair: (pair[1].sweep_value, len(pair[0].motion.sequence)))
        labels = self._labels(points)
        vertices = {
            id(meeting): Vertex(label, meeting.event, point, tuple(sorted(numbers[i] for i in meeting.families)))
            for (meeting, point), label in zip(points, labels, strict=True)
        }
        marked = (self._marked(family, numbers[family.number], vertices) for family in order)
        return Atlas(self.sweep, self.limits, tuple(marked), tuple(vertices.values()), tuple(self._completeness()))

    def _completeness(self) -> Iterator[Completeness]:
        """What is claimed of the words that are looked for."""
        if not self.model.level.horizontal:
            yield Completeness("B", Claim.COMPLETE if self.model.level.held is Held.GBAR else Claim.SEARCHED)
        if self.limits.impacts > 1:
            yield Completeness("BT", Claim.COMPLETE)
        for sequence in self.sequences(3, self.limits.periods):
            cells = [cells for cells in self.undecided if cells.motions.sequence.word == sequence.word]
            resolution = NEAR + max(part.side for part in cells) / 2
            yield Completeness(sequence.word, Claim.COMPLETE, resolution, max(part.share for part in cells))
        for sequence in self.sequences(4, self.limits.periods):
            yield Completeness(sequence.word, Claim.SEARCHED, side_of(sequence) / 2)

    def _labels(self, points: list[tuple[_Meeting, PolishedPoint]]) -> Iterator[str]:
        """Labels of vertices along the sweep: critical points of the 1:1 motions keep those that they have."""
        known = list(self.diagram.critical_points)
        one_to_one = Sequence((1, -1), self.sweep.device.period_ratio)
        counts = Counter(critical.kind.letter for critical in known)
        for meeting, point in points:
            letter, critical = CriticalKind(meeting.event).letter, None
            if any(self.families[number - 1].sequence == one_to_one for number in meeting.families):
                near = SAME * abs(point.sweep_value)
                at = [
                    x for x in known if x.kind.letter == letter and abs(x.point.sweep_value - point.sweep_value) < near
                ]
                critical = next(iter(at), None)
            if critical is None:
                counts[letter] += 1
                yield f"{letter}{counts[letter]}"
            else:
                known.remove(critical)
                yield critical.label

    def _marked(self, family: Family, number: int, vertices: dict[int, Vertex]) -> Family:
        """A family with its events, the coordinate of each as it was solved for."""
        marks = []
        for row, event in self.events[family.number]:
            meeting = self.at_event.get((family.number, row))
            vertex = vertices[id(meeting)] if meeting is not None else None
            point = vertex.point if vertex is not None else None
            if event is Event.NODE_FOCUS:
                point = polished(self.sweep, family.curve, family.curve.motion(family.x[row]), event)
            if event is Event.SWEEP_END:
                ends = self.sweep.start, self.sweep.end
                family.sweep_value[row] = min(ends, key=lambda end: abs(end - float(family.sweep_value[row])))
            if point is not None:
                family.sweep_value[row] = point.sweep_value
            marks.append(Mark(row, event, vertex, point))
        return replace(family, number=number, marks=tuple(marks))


def _images(family: Family, sequence: Sequence, mirror: bool) -> Iterator[Floats]:
    """All flight times but the last of a family's motions, counted so that they have a sequence; with their mirror."""
    own, count = family.sequence, len(sequence) // len(family.sequence)
    whole = Sequence(count * own.walls, count * own.periods)
    time = family.x[:, len(own) : -1]
    flights = np.tile(np.diff(time, axis=1, append=time[:, :1] + 2 * own.periods).T, (count, 1))
    for i in range(len(whole)):
        if sequence in ((whole.rotated(i), whole.mirrored().rotated(i)) if mirror else (whole.rotated(i),)):
            yield np.roll(flights, -i, axis=0)[:-1]


def _squares(flights: Floats) -> Floats:
    """Squares of the space of flight times that a line through points passes, and all beside."""
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(flights, axis=1)).max(axis=0))])
    fine = np.append(np.arange(0, way[-1], NEAR / 2), way[-1])
    line = np.stack([np.interp(fine, way, flight) for flight in flights])
    steps = np.array(list(product((-NEAR, 0, NEAR), repeat=len(line)))).T
    return np.unique(_codes(line[:, :, None] + steps[:, None, :]))


def _codes(flights: Floats) -> Floats:
    """A number for the square that flight times lie in."""
    return np.asarray(np.tensordot(SQUARES ** np.arange(len(flights)), np.floor(flights / NEAR), axes=1))
