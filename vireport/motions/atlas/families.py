"""The atlas of a sweep: every family of motions that the searches lead to, joined where families meet.

Families are the edges of a graph, and the points at which they begin, end or meet its vertices. From a motion its
family is followed to both ends; at every event on it the families that meet are followed in turn, until none is new.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from heapq import heappop, heappush
from itertools import chain, count, product
from typing import NamedTuple

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.progress import Progress
from vireport.motions.atlas.exclusion import (
    FINEST,
    MOST_CELLS,
    Exclusion,
    FlightTimeCells,
    fine_side,
)
from vireport.motions.atlas.four_impacts import four_impacts, side_of
from vireport.motions.atlas.one_impact import one_impact
from vireport.motions.atlas.surface import Candidates
from vireport.motions.branches import admissible_families
from vireport.motions.diagram import BifurcationDiagram, solve
from vireport.motions.events import Event
from vireport.motions.families import Atlas, Claim, Completeness, Family, Mark
from vireport.motions.paths import Curve, Trail, completed, follow
from vireport.motions.periodicity import Model
from vireport.motions.points import Point, polished
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Beginning, Limits, VertexOpening, openings, touching
from vireport.motions.turning import turns
from vireport.physics.motion import SAME, Motion
from vireport.physics.word import Word

Floats = NDArray[np.float64]

NEAR, SQUARES = 1 / 256, 2.0**16
"""Side of squares of flight times [t_c], and a number larger than that of squares in a row: a motion in the same square
as a motion of a family, or in a neighbouring one, is near to that family."""

LOOKED_FOR, MOST_OPENINGS = 4, 1000
"""Impacts up to which words are looked for and every family that meets another is followed; and how often a longer word
is tried where families meet. Words double with each impact, and with a restitution near 1 so do families: with r =
0.95, up to 10 impacts in 10 periods and lengths of 0.05 to 2 m there was no end after 16 min; bounded, it takes a
minute."""

MEETINGS = Event.PERIOD_DOUBLING, Event.FOLD, Event.PITCHFORK, Event.GRAZING, Event.ZERO_VELOCITY
"""Events that are vertices."""


class SearchEffort(Struct, frozen=True):
    """How far the search for families goes.

    Attributes
    ----------
    finest : float
        Side of the smallest cells of flight times that are searched [t_c], from `FINE` down.
    openings : int
        How often a word of more than `LOOKED_FOR` impacts is tried where families meet; the shortest come first.
    """

    finest: float = FINEST
    openings: int = MOST_OPENINGS


FULL = SearchEffort()
"""The effort of an atlas that is a result itself."""


def atlas(
    sweep: Sweep,
    limits: Limits,
    simulated: Iterable[Motion] = (),
    progress: Progress | None = None,
    effort: SearchEffort = FULL,
) -> Atlas:
    """Find and follow the families of motions of a sweep.

    Parameters
    ----------
    sweep : Sweep
    limits : Limits
        Words beyond them are left out.
    simulated : iterable of Motion
        Motions from simulations or guesses, whose families are followed as well.
    progress : callable, optional
        Called with a line of text for every family that is followed.
    effort : SearchEffort

    Raises
    ------
    UsageError
        If the sweep is over a restitution, or the ball has friction or a restitution that falls with speed.
    """
    low, high = (float(end) for end in sweep.coordinate_range)
    sweep.driven("the families of all impact sequences")
    device = sweep.device.plain_ball("the families of all impact sequences")
    model = Model(sweep.level, device.restitution, device.harmonics)
    search = _Search(solve(sweep), model, low, high, limits, progress, effort.finest, effort.openings)
    for family in _one_to_one(search):
        if not search.on_family(family.curve.motion(family.x[len(family.x) // 2])):  # nor its mirror image
            search.take(family)
    search.follow(LOOKED_FOR)
    for motion in chain(_starts(search), simulated):
        search.explore(motion)
    search.follow(limits.impacts)
    return search.atlas()


def _one_to_one(search: _Search) -> Iterator[Family]:
    """The families of 1:1 motions, from their closed form."""
    # These come before all others: a motion that a search leads to later and that lies on one of them is then known,
    # and need not be followed by steps.
    for k in range(1, search.limits.periods + 1) if search.limits.impacts > 1 else ():
        diagram = search.one_to_one(k)
        for branch in diagram.branches:
            for family in admissible_families(branch):
                if diagram is search.diagram:
                    yield family
                else:  # labels are those of the period ratio of the device alone
                    marks = (replace(mark, point=mark.point and replace(mark.point, label="")) for mark in family.marks)
                    yield replace(family, sweep=search.sweep, marks=tuple(marks))


def _starts(search: _Search) -> Iterator[Motion]:
    """Motions that the searches lead to, by number of impacts; none for a force with harmonics."""
    # Closed form, exclusion and grid are for a sine: with harmonics only the families that join the 1:1 motions, or
    # that simulations come to, are followed.
    if search.model.harmonics:
        return
    if not search.model.level.horizontal:
        for k in range(1, search.limits.periods + 1):
            single = one_impact(search.model, search.low, search.high, k)
            yield from (single.motion(i, search.model.level) for i in range(len(single.d)))
    # Words of the same impacts in all numbers of periods together: affine arithmetic on many cells costs little more
    # than on few.
    by_periods = [search.excluded(k) for k in range(1, search.limits.periods + 1)]
    for i in range(len(by_periods[0])):
        yield from search.by_exclusion(tuple(words[i] for words in by_periods))
    # Last the search over a grid, which claims least: of families with four impacts those that join others are known by
    # then.
    for k in range(1, search.limits.periods + 1):
        for word in search.words(LOOKED_FOR, k):
            yield from search.four_impacts(word)


class _Meeting(Struct):
    """A vertex while the search goes on.

    Attributes
    ----------
    event : Event
    motion : Motion
        The motion at the vertex, its touches as impacts.
    point : Point or None
        The vertex as solved for in decimals, if it has been.
    families : set of int
        Numbers of the families that meet at the vertex.
    """

    event: Event
    motion: Motion
    point: Point | None
    families: set[int] = field(default_factory=set)


class _Queued(NamedTuple):
    """An entry of the queue of a search, ordered by its first two fields.

    Attributes
    ----------
    impacts : int
        Number of impacts of the word.
    serial : int
        Number in the order of the search, different for all entries.
    families : iterator of Beginning
        Families of the word that may begin at a vertex.
    others : iterator of VertexOpening
        Further words that may begin at the vertex.
    """

    impacts: int
    serial: int
    families: Iterator[Beginning]
    others: Iterator[VertexOpening]


class _Search(Struct):
    """The state of a search: families and vertices so far, and a queue of what may begin at vertices.

    Attributes
    ----------
    diagram : BifurcationDiagram
        Of the 1:1 motions.
    model : Model
        Groups over the sweep.
    low, high : float
        Range of the coordinate.
    limits : Limits
    progress : callable or None
    finest, openings
        See `SearchEffort`; `openings` counts those that are left.
    families : list of Family
        In the order in which they were added, and of their numbers.
    of_word : dict
        The families by their words in canonical form.
    meetings : list of _Meeting
        The vertices.
    at_event : dict
        The vertex at a row of a family, by its number and the row.
    queue : list of _Queued
        A heap, the fewest impacts first.
    serial : iterator of int
        Makes entries of the queue comparable.
    undecided : list of FlightTimeCells
        Cells in which the search for a word has neither found motions nor excluded them.
    squares : dict
        For each word, the number of families considered and the codes of the squares of flight times near to them.
    """

    diagram: BifurcationDiagram
    model: Model
    low: float
    high: float
    limits: Limits
    progress: Progress | None
    finest: float
    openings: int
    families: list[Family] = field(default_factory=list)
    of_word: dict[Word, list[Family]] = field(default_factory=dict)
    meetings: list[_Meeting] = field(default_factory=list)
    at_event: dict[tuple[int, int], _Meeting] = field(default_factory=dict)
    queue: list[_Queued] = field(default_factory=list)
    serial: Iterator[int] = field(default_factory=count)
    undecided: list[FlightTimeCells] = field(default_factory=list)
    squares: dict[Word, tuple[int, Floats]] = field(default_factory=dict)

    @property
    def sweep(self) -> Sweep:
        """The sweep along which families are followed."""
        return self.diagram.sweep

    def one_to_one(self, periods: int) -> BifurcationDiagram:
        """The 1:1 motions along the sweep that take a number of forcing periods."""
        if periods == self.sweep.device.period_ratio:
            return self.diagram
        return solve(replace(self.sweep, device=replace(self.sweep.device, period_ratio=periods)))

    def words(self, impacts: int, periods: int) -> list[Word]:
        """Words with impacts on both membranes, without rotations and mirror images of others."""
        words = {
            self.representative(Word(walls, periods))
            for walls in product((1, -1), repeat=impacts)
            if abs(sum(walls)) < impacts <= self.limits.impacts
        }
        return sorted(words, key=lambda word: word.letters)

    def on_bottom(self, periods: int) -> list[Word]:
        """Words with two to four impacts on the bottom only.

        Over a period gravity adds 2 k gbar to the velocity, and the impacts take off (1 + r) times the sum of their
        velocities: there are no motions with impacts on the top only, nor in a horizontal capsule on one membrane only.
        """
        most = 0 if self.model.level.horizontal else min(LOOKED_FOR, self.limits.impacts)
        return [Word(impacts * (1,), periods) for impacts in range(2, most + 1)]

    def representative(self, word: Word) -> Word:
        """The word that stands for all rotations of a word and, in a horizontal capsule, of its mirror image."""
        images = (word, word.mirrored()) if self.model.horizontal else (word,)
        return min((image.canonical() for image in images), key=lambda image: image.letters)

    def explore(self, motion: Motion) -> None:
        """Follow the family of a motion, and the families of up to `LOOKED_FOR` impacts that it leads to."""
        motion = motion.representative(self.model.horizontal)
        curve = self._curve(motion.word)
        x = curve.nearest(curve.vector(motion)) if self.limits.admit(motion.word) else None
        if x is not None:
            start = curve.point(x, curve.tangent(x))
            self._follow(Beginning(None, curve, start, start))
        self.follow(LOOKED_FOR)

    def follow(self, longest: int) -> None:
        """Follow the families of up to `longest` impacts in the queue, and those that they lead to."""
        while self.queue and self.queue[0].impacts <= longest:
            if self.queue[0].impacts > LOOKED_FOR and not self.openings:
                return
            queued = heappop(self.queue)
            self.openings -= queued.impacts > LOOKED_FOR
            self._open(queued.others)
            for beginning in queued.families:
                self._follow(beginning)

    def _open(self, openings: Iterator[VertexOpening]) -> None:
        """Put the next word that may begin at a vertex into the queue, with the words after it."""
        # One word of each vertex is enough: they come with ascending impacts, so that the shortest of all is always in
        # the queue.
        for opening in openings:
            heappush(self.queue, _Queued(opening.impacts, next(self.serial), opening.families, openings))
            return

    def _follow(self, beginning: Beginning) -> None:
        """Follow a family from its first motion and add it, unless it is known."""
        begins, curve, vertex, first = beginning
        if not self._wanted(curve, first.x):
            return
        if self.progress is not None:
            progress = f"{len(self.families)} families found"
            self.progress(f"following motions of other impact sequences, {progress}: {curve.word.letters}")
        trail = follow(curve, first)
        if begins is None:
            self._add(curve, completed(curve, first, trail))
        else:
            events = [(0, begins), *((i + 1, event) for i, event in trail.events)]
            self._add(curve, Trail([vertex, *trail.points], events))

    def _curve(self, word: Word) -> Curve:
        """The motions of a word over the sweep."""
        return Curve.over_sweep(word, self.model, self.low, self.high)

    def _wanted(self, curve: Curve, x: Floats) -> bool:
        """Whether a solution is a motion within the limits that lies on no family yet."""
        if not self.limits.admit(curve.word) or not curve.admits(x):
            return False
        # All 1:1 motions are taken from their closed form. Next to a pitchfork a motion could not be distinguished from
        # its mirror image on a family, and one family in 3,000 stood twice.
        if sorted(curve.word.walls) == [-1, 1]:
            return False
        # Several periods of a motion solve the equations of the longer word too: it is followed as what it is.
        motion = curve.motion(x)
        if motion.primitive() is not motion:
            return False
        return not self.on_family(motion)

    def on_family(self, motion: Motion) -> bool:
        """Whether a motion or, where that is a motion too, its mirror image lies on a family."""
        near = (other for family in self._alike(motion) for other in family.at(motion.coordinate))
        return any(self._same(motion, other) for other in near)

    def excluded(self, periods: int) -> list[Word]:
        """The words in some forcing periods that are searched for by exclusion."""
        return [*self.on_bottom(periods), *self.words(3, periods)]

    def by_exclusion(self, words: tuple[Word, ...]) -> Iterator[Motion]:
        """Motions of one sequence of impacts, in several numbers of periods, that lie on no family so far.

        The family of a motion must be explored before the next motion is drawn: cells next to it are then left out.
        """
        exclusion = Exclusion(self.model, self.low, self.high, words)
        cells = exclusion.cells()
        while cells:
            cells = [part[~self._near(part.word, part.centre)] for part in cells]
            for part in filter(len, cells):
                yield from self._unknown(*exclusion.motions(part))
            cells = [part[~self._near(part.word, part.centre)] for part in cells]
            last = [part.no_larger_than(self.finest) or not 0 < len(part) <= MOST_CELLS for part in cells]
            self.undecided += [part for part, done in zip(cells, last, strict=True) if done]
            cells = [part.divided() for part, done in zip(cells, last, strict=True) if not done]
            cells = exclusion.left(cells) if cells else []

    def four_impacts(self, word: Word) -> Iterator[Motion]:
        """Motions of a word with four impacts that lie on no family so far, as far as a grid shows them."""
        yield from self._unknown(*four_impacts(self.model, self.low, self.high, word))

    def _unknown(self, motions: Candidates, flights: Floats) -> Iterator[Motion]:
        """Candidates that are not near to a family; families that are explored meanwhile are taken into account."""
        rows = np.flatnonzero(~self._near(motions.word, flights))
        while rows.size:
            yield motions.motion(int(rows[0]), self.model.level)
            rows = rows[1:][~self._near(motions.word, flights[:, rows[1:]])]

    def _near(self, word: Word, flights: Floats) -> NDArray[np.bool_]:
        """Whether flight times are near to those of motions of a family, or of their mirror images."""
        # Squares have numbers, in ascending order: so thousands of flight times are looked up at once. Infinity at the
        # end keeps every search within the array.
        count, squares = self.squares.get(word, (0, np.array([np.inf])))  # of the first `count` families
        if count < len(self.families):
            images = (_images(family, word, self.model.horizontal) for family in self.families[count:])
            squares = np.unique(np.concatenate([squares, *map(_squares, chain.from_iterable(images))]))
            self.squares[word] = len(self.families), squares
        codes = _codes(flights)
        return np.asarray(squares.take(np.searchsorted(squares, codes), mode="clip") == codes)

    def _same(self, motion: Motion, other: Motion) -> bool:
        """Whether two motions, or one and the mirror image of the other, are the same."""
        return motion.distance(other, mirror=self.model.horizontal) < SAME

    def _alike(self, motion: Motion) -> Iterator[Family]:
        """The families with the word of a motion or, where there are mirror images, of its image."""
        words = {motion.word.canonical()}
        if self.model.horizontal:
            words.add(motion.word.mirrored().canonical())
        return chain.from_iterable(self.of_word.get(word, ()) for word in words)

    def _add(self, curve: Curve, trail: Trail) -> None:
        """Add a family that was followed."""
        x = np.array([point.x for point in trail.points])
        trace = np.array([point.trace for point in trail.points])
        values = np.asarray(self.sweep.value(x[:, -1]))
        marks = tuple(Mark(row, event) for row, event in trail.events)
        self.take(Family(0, self.sweep, curve, x, trace, values, np.ones(len(x), dtype=bool), marks))

    def take(self, family: Family) -> None:
        """Add a family, and the vertices on it."""
        number = len(self.families) + 1
        self.families.append(replace(family, number=number))
        self.of_word.setdefault(family.word.canonical(), []).append(self.families[-1])
        for mark in family.marks:
            meeting = self._meeting(family, mark) if mark.event in MEETINGS else None
            if meeting is not None:
                meeting.families.add(number)
                self.at_event[number, mark.row] = meeting

    def _meeting(self, family: Family, mark: Mark) -> _Meeting | None:
        """The vertex at an event; a new one is added, and the families that may begin there are put into the queue.

        None where every impact is a touch.
        """
        motion, event = family.curve.motion(family.x[mark.row]), mark.event
        if mark.point is not None:
            motion = mark.point.motion
        if event in (Event.GRAZING, Event.ZERO_VELOCITY):
            motion, event = touching(motion, turns(motion, self.model.groups(motion.coordinate))), Event.GRAZING
        motion = motion.primitive().representative(self.model.horizontal)
        # Where every impact is a touch, the ball oscillates freely between the membranes: families of every word begin
        # at this motion, and none can be chosen.
        if len(motion.rests) == len(motion.word):
            return None
        for meeting in self.meetings:
            if meeting.event is event and self._same(meeting.motion, motion):
                return meeting
        self.meetings.append(_Meeting(event, motion, mark.point))
        if event is not Event.PERIOD_DOUBLING or self.limits.admit(motion.times(2).word):
            self._open(openings(self._curve(motion.word), motion, event, self.limits))
        return self.meetings[-1]

    def atlas(self) -> Atlas:
        """The atlas of all families so far, with their events solved for in decimals."""
        order = sorted(self.families, key=lambda f: (len(f.word), f.word.letters, f.word.periods, f.number))
        numbers = {family.number: k for k, family in enumerate(order, 1)}
        points = [(meeting, self._point(meeting)) for meeting in self.meetings]
        points.sort(key=lambda pair: (pair[1].sweep_value, len(pair[1].motion.word)))
        counts = Counter(critical.event.letter for critical in self.diagram.critical_points)
        vertices = {}
        for meeting, point in points:
            letter = point.event.letter
            counts[letter] += not point.label
            label = point.label or f"{letter}{counts[letter]}"
            families = tuple(sorted(numbers[number] for number in meeting.families))
            vertices[id(meeting)] = replace(point, label=label, families=families)
        marked = (self._marked(family, numbers[family.number], vertices) for family in order)
        followed = self.queue[0].impacts - 1 if self.queue else self.limits.impacts
        parts = tuple(marked), tuple(vertices.values()), tuple(self._completeness())
        return Atlas(self.sweep, self.limits, *parts, followed)

    def _completeness(self) -> Iterator[Completeness]:
        """The claim of completeness for every word that is looked for."""
        horizontal, numbers = self.model.level.horizontal, range(1, self.limits.impacts + 1)
        harmonics = self.model.harmonics
        closed = [] if horizontal or harmonics else ["B"]
        closed += ["BT"] if self.limits.impacts > 1 else []
        # The following words have no motions, see `on_bottom`; where motions have mirror images, the bottom stands for
        # both membranes.
        closed += [impacts * "B" for impacts in numbers if horizontal]
        closed += [impacts * "T" for impacts in numbers if not self.model.horizontal]
        yield from (Completeness(word, Claim.COMPLETE) for word in closed)
        if harmonics:
            return
        for word in self.excluded(self.limits.periods):
            cells = [cells for cells in self.undecided if cells.word.letters == word.letters]
            side = max(fine_side(word), *(part.side for part in cells))
            resolution = NEAR + side / 4  # periods, of which sides are halves
            yield Completeness(word.letters, Claim.COMPLETE, resolution, max(part.share for part in cells))
        for word in self.words(LOOKED_FOR, self.limits.periods):
            yield Completeness(word.letters, Claim.SEARCHED, side_of(word) / 2)

    def _point(self, meeting: _Meeting) -> Point:
        """The point of a vertex, solved for in decimals; a critical point of the 1:1 motions keeps its label."""
        if meeting.point is None:
            return polished(self.sweep, meeting.motion, meeting.event)
        return replace(meeting.point, motion=meeting.motion)

    def _marked(self, family: Family, number: int, vertices: dict[int, Point]) -> Family:
        """A family with its number and with the points of its events, whose swept values are put into its rows."""
        marks = []
        for mark in family.marks:
            row, point, meeting = mark.row, mark.point, self.at_event.get((family.number, mark.row))
            if meeting is not None:
                point = vertices[id(meeting)]
            else:
                if mark.event is Event.NODE_FOCUS and point is None:
                    point = polished(self.sweep, family.curve.motion(family.x[row]), mark.event)
                point = point and replace(point, families=(number,))
            if mark.event is Event.SWEEP_END:
                # The end as the scenario states it: by way of the coordinate it would come back with a rounding.
                ends = self.sweep.start, self.sweep.end
                family.sweep_value[row] = min(ends, key=lambda end: abs(end - float(family.sweep_value[row])))
            if point is not None:
                family.sweep_value[row] = point.sweep_value
            marks.append(Mark(row, mark.event, point))
        return replace(family, number=number, marks=tuple(marks))


def _images(family: Family, word: Word, mirror: bool) -> Iterator[Floats]:
    """Flight times but the last of a family's motions, counted from all impacts that give them a word.

    Parameters
    ----------
    family : Family
    word : Word
        The word of the motions, or of several periods of them.
    mirror : bool
        Whether to add the flight times of mirror images.

    Yields
    ------
    ndarray (N - 1, n)
    """
    base, count = family.word, len(word) // len(family.word)
    whole = Word(count * base.walls, count * base.periods)
    if whole.periods != word.periods or len(whole) != len(word):
        return
    time = family.x[:, len(base) : -1]
    flights = np.tile(np.diff(time, axis=1, append=time[:, :1] + 2 * base.periods).T, (count, 1))
    for image in (whole, whole.mirrored()) if mirror else (whole,):
        for i in image.firsts(word):
            yield np.roll(flights, -i, axis=0)[:-1]


def _squares(flights: Floats) -> Floats:
    """Codes of the squares of flight times that the line through points (N - 1, n) passes, and of their neighbours."""
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(flights, axis=1)).max(axis=0))])
    fine = np.append(np.arange(0, way[-1], NEAR / 2), way[-1])
    line = np.stack([np.interp(fine, way, flight) for flight in flights])
    steps = np.array(list(product((-NEAR, 0, NEAR), repeat=len(line)))).T
    return _codes(line[:, :, None] + steps[:, None, :]).ravel()


def _codes(flights: Floats) -> Floats:
    """The number of the square, see `SQUARES`, in which flight times (N - 1, ...) lie."""
    return np.asarray(np.tensordot(SQUARES ** np.arange(len(flights)), np.floor(flights / NEAR), axes=1))
