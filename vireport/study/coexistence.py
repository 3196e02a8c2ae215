"""Which motions coexist along a sweep, and why one of them ends, from the slow sweep and the families of motions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import StrEnum
from itertools import groupby
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.motions.families import Atlas, Family
from vireport.motions.points import Point
from vireport.physics.word import Word
from vireport.simulation.attractors import Attractor, Outcome, motion_name
from vireport.simulation.following import Jump

if TYPE_CHECKING:
    from vireport.study.checks.crosscheck import CrossCheck

ValueRange = tuple[float, float]


class FoundBy(StrEnum):
    """How a motion was found; the value is its name in results.json."""

    UP = "up"
    DOWN = "down"
    STARTS = "starts"
    FAMILIES = "families"


class Coexisting(Struct, frozen=True):
    """A kind of motion, and the ranges of the parameter in which it was found, or is stable by its family.

    Attributes
    ----------
    outcome : Outcome
    word : str
        "" where it is not periodic; of mirror images in a horizontal capsule the alphabetically first word.
    period : int
        In forcing periods; 0 where it is not periodic.
    ranges : dict of FoundBy to list of (float, float)
        From the first to the last of successive values; of families, between the points where they become unstable.
    """

    outcome: Outcome
    word: str
    period: int
    ranges: dict[FoundBy, list[ValueRange]]

    @property
    def name(self) -> str:
        """The motion's name for the reader: its word and ratio, or how it ends."""
        return motion_name(self.outcome, self.word, self.period)


def coexisting(check: CrossCheck, atlas: Atlas | None) -> tuple[Coexisting, ...]:
    """The motions found along a sweep, from each direction, from random starts and as families; () if not followed."""
    slowly = check.hysteresis
    if slowly is None:
        return ()
    rows: dict[tuple[Outcome, str, int], dict[FoundBy, list[ValueRange]]] = {}

    def add(kind: tuple[Outcome, str, int], source: FoundBy, ranges: Iterable[ValueRange]) -> None:
        rows.setdefault(kind, {way: [] for way in FoundBy})[source].extend(ranges)

    order = sorted(range(len(check.values)), key=lambda i: float(check.values[i]))
    values = [float(check.values[i]) for i in order]
    ends_by_source = {FoundBy.STARTS: [check.ends[i] for i in order]}
    for direction, course in slowly.courses.items():
        ascending = sorted(course.stages, key=lambda stage: stage.value)
        ends_by_source[FoundBy(direction)] = [(stage.attractor,) for stage in ascending]
    for source, ends in ends_by_source.items():
        kinds = [{_kind(end, slowly.mirror) for end in kind_of_end} for kind_of_end in ends]
        for kind in set().union(*kinds):
            add(kind, source, _runs(values, [kind in kind_of_end for kind_of_end in kinds]))
    for family in atlas.families if atlas is not None else ():
        if family.stable_runs:
            word = family.word.canonical(slowly.mirror).letters
            add((Outcome.PERIODIC, word, family.word.periods), FoundBy.FAMILIES, family.stable_ranges)
    for ranges in rows.values():
        ranges[FoundBy.FAMILIES].sort()
    listed = (Coexisting(*kind, ranges) for kind, ranges in rows.items())
    return tuple(
        sorted(listed, key=lambda motion: (motion.outcome is not Outcome.PERIODIC, len(motion.word), motion.name))
    )


def ends_at(jump: Jump, atlas: Atlas, within: float) -> Point | None:
    """The nearest point to a jump, within a distance, where a family of the motion before it ceases to be stable."""
    attractor = jump.before.attractor
    if attractor.cycle is None or attractor.cycle.sticks:
        return None
    mirror = atlas.sweep.level.horizontal
    word = Word.of(attractor.word, attractor.period).canonical(mirror)
    families = (family for family in atlas.families if family.word.canonical(mirror) == word)
    vertices = (vertex for family in families for vertex in _ends(family))
    near = [vertex for vertex in vertices if abs(vertex.sweep_value - jump.value) <= within]
    return min(near, key=lambda vertex: abs(vertex.sweep_value - jump.value), default=None)


def _ends(family: Family) -> Iterator[Point]:
    """Where stable stretches of a family end within the sweep."""
    rows = {row for run in family.stable_runs for row in run}
    return (mark.point for mark in family.marks if mark.row in rows and mark.point is not None)


def _kind(attractor: Attractor, mirror: bool) -> tuple[Outcome, str, int]:
    word = attractor.word
    if attractor.outcome is Outcome.PERIODIC:
        word = Word.of(word, attractor.period).canonical(mirror).letters
    return attractor.outcome, word, attractor.period


def _runs(values: list[float], is_present: list[bool]) -> Iterator[ValueRange]:
    """The first and last value of each run of successive values at which a motion is present."""
    for present, run in groupby(zip(values, is_present, strict=True), key=lambda pair: pair[1]):
        if present:
            run_values = [value for value, _ in run]
            yield run_values[0], run_values[-1]
