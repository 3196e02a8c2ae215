"""Tables of the report of a run: numbers of a study, and the words of words/tables.j2."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from pathlib import Path, PurePath
from typing import Literal

import numpy as np
from msgspec import Struct

from vireport.design.followed import FollowedMotion
from vireport.design.point import DesignPoint
from vireport.motions.events import Event
from vireport.motions.families import Family, Mark
from vireport.motions.generation import generation, ladder
from vireport.motions.points import Point
from vireport.motions.stability import determinant_of
from vireport.motions.sweep import settable
from vireport.physics.device import RESTITUTIONS
from vireport.physics.groups import by_wall
from vireport.report.voltages import voltage_tables
from vireport.scenario.blocks import UNIT_OF_SWEPT, inputs, set_in_type
from vireport.scenario.parameters import LARGEST, SMALLEST, DesignInput
from vireport.study.study import Study
from vireport.text.foreign import unmarked
from vireport.text.formatting import (
    ABSENT,
    Exactness,
    capital,
    error_bound,
    exact,
    percent,
    quantity,
    rounded_text,
    span,
    stated_text,
    words,
    written,
)
from vireport.text.patterns import Phrase
from vireport.text.said import spoken
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words

SYMBOLS = {varied.path: varied.marked for varied in DesignInput} | {
    "device.ball_mass_kg": "*m*",
    "device.membrane.stiffness": "*K*",
    "device.membrane.exponent": "*h*",
    "device.membrane.active_radius_m": "*R*_c",
    "device.membrane.ball_radius_m": "*r*_b",
    "device.membrane.bias_voltage_v": "*U*_in",
    "device.membrane.thickness_m": "*κ*",
    "device.membrane.relative_permittivity": "*ε*_r",
    "excitation.frequency_hz": "*f* = *ω*/2π",
    "gravity_m_s2": "*g*",
    "period_ratio": "*n*",
}

OF_LAW = "device.restitution_exponent"
"""An input of which nothing is told where it is 0: the restitution then is what the row above it says."""

NOT_A_QUANTITY = ("schema_version", "title")

EFFECTS = ("device.capsule", "device.friction", "excitation.harmonics")
"""Inputs by which the model has one more effect, and none unless they are given."""

NOTHING = 1e-30
"""Below this, a number is what 45-digit arithmetic leaves of an exact zero."""


class RunTables(Struct, frozen=True, eq=False):
    """The tables that a report has of a study.

    Attributes
    ----------
    study : Study
    templates : Path or None
        A folder whose words come before ours.
    """

    study: Study
    templates: Path | None = None

    @property
    def _say(self) -> Words:
        return Words("tables", self.templates)

    @property
    def _exactness(self) -> Exactness:
        return self.study.evidence.exactness

    def _printed(self, *values: float | None) -> Iterator[str]:
        return (rounded_text(value if value is None else float(value), self._exactness) for value in values)

    def inputs(self) -> Table:
        """The values that were given or count by default, in the order of the format."""
        solution, say = self.study.solution, self._say
        unused, rows = [path for path in EFFECTS if self._origin(path) == "default"], []
        for entry in inputs(self.study.scenario):
            if entry.path not in (*NOT_A_QUANTITY, *unused) and (entry.value or entry.path != OF_LAW):
                unit = solution.parameter.unit if entry.unit == UNIT_OF_SWEPT else set_in_type(entry.unit)
                chosen = solution.sweep is not None and entry.path.rpartition(".")[2] == solution.parameter
                symbol, origin = SYMBOLS.get(entry.path, ""), say("origin", self._origin(entry.path), chosen)
                rows.append((entry.title, symbol, written(entry.value), unit, origin, entry.path))
        return worded_table(say, "inputs", "ttnttc", rows, note=say("unused", unused) if unused else "")

    def _origin(self, path: str) -> Literal["given", "default", "override"]:
        """Whether a value was given, and where, or is a default."""
        loaded = self.study.loaded
        return "override" if loaded.is_set_over(path) else "given" if path in loaded.stated_keys else "default"

    def margins(self) -> Iterator[Table]:
        """How far the design point is from where stable motion ends, and what neglected effects leave of it."""
        design, effects, say = self.study.solution.design, self.study.effects, self._say
        soft, device = self.study.own_stiffness is not None, self.study.solution.device
        if bottom := self.study.evidence.bottom:
            yield worded_table(say, "ranges", "tnntnntn", self._bottom(bottom), note=say("bottom_note", bottom[0]))
        if design is not None and design.stable_ranges:
            yield worded_table(say, "ranges", "tnntnntn", self._ranges(design), note=say("ranges_note", soft))
        if effects is not None and effects.end is not None:
            end, of_effects = effects.end, Words("effects", self.templates)
            rows = [(say("rigid"), *self._printed(end.sweep_value), percent(end.relative and abs(end.relative)))]
            rows += [
                (capital(of_effects("effect", x, device)), *self._printed(x.value), of_effects("left", x))
                for x in effects.rows
            ]
            yield worded_table(say, "effects", "tnn", rows, end, note=say("effects_note"))
        if design is not None and design.distortions:
            rows = [
                (str(x.order), say("none_found"), ABSENT, ABSENT)
                if x.share is None or x.event is None
                else (str(x.order), *self._printed(100 * x.share, x.phase_deg), x.event.words)
                for x in design.distortions
            ]
            note = say("distortions_note", design.distortions[0].searched_to, device, soft)
            yield worded_table(say, "distortions", "tnnt", rows, note=note)

    def _ranges(self, design: DesignPoint) -> Iterator[tuple[str, ...]]:
        """The stable range of each input around the design point; of both restitutions only where they differ."""
        device = self.study.solution.device
        for part in design.stable_ranges:
            if not device.alike or part.parameter not in RESTITUTIONS[1:]:
                at = float(device.value_of(part.parameter))
                ends = (cell for value, point in part.ends for cell in self._end(value, point, at))
                yield self._say("head_in_words", part.parameter), stated_text(at), *ends

    def _bottom(self, ranges: tuple[FollowedMotion, ...]) -> Iterator[tuple[str, ...]]:
        """The range of each input over which a motion on a table stays stable."""
        for followed in ranges:
            at = float(self.study.solution.device.value_of(followed.varied))
            limited, cells = followed.varied in (*RESTITUTIONS, DesignInput.INCLINATION), list[str]()
            ends = zip((followed.low, followed.high), (followed.below, followed.above), followed.ends, strict=True)
            for value, event, ended_by in ends:
                what = self._say("limit") if limited and event is Event.SWEEP_END else ended_by
                cells += [*self._printed(value), what, _room(value, at)]
            yield self._say("head_in_words", followed.varied), stated_text(at), *cells

    def _end(self, value: float, point: Point | None, at: float) -> tuple[str, str, str]:
        """Where a stable range ends, what ends it, and the room that the value of the design has."""
        room = _room(value, at)
        if point is not None:
            return rounded_text(value, self._exactness), ", ".join(filter(None, (point.label, point.event.words))), room
        unknown = value in (SMALLEST, LARGEST)
        return (ABSENT, self._say("nothing"), ABSENT) if unknown else (exact(value), self._say("limit"), room)

    def design_point(self) -> Iterator[Table]:
        """Every 1:1 motion at the design point, and the motions of other words that the device comes to."""
        solution, others, say = self.study.solution, self.study.switched_on, self._say
        design, device = solution.design, solution.device
        if design is not None and len(design.motions):
            x = design.motions
            columns = (x.q, x.phi_bottom, x.phi_top, x.velocity_bottom, x.velocity_top, x.trace, x.discriminant)
            cells = zip(design.families, x.words, x.admissible_mask, *columns, strict=True)
            rows = [
                (capital(name), word, say("yes" if admissible else "no"), *self._printed(*numbers))
                for name, word, admissible, *numbers in cells
            ]
            if device.law is None:
                note = say("same_determinant", device, *self._printed(determinant_of(device.restitution)))
            else:
                pairs = zip(*by_wall(x.restitution), strict=True)
                note = say("determinants", device.law, [say("pair", *self._printed(*pair)) for pair in pairs])
            yield worded_table(say, "design_point", "tttnnnnnnn", rows, note=note)
        if others is not None and others.by_starts:
            note = say("on_bottom_note" if solution.on_table else "by_starts_note")
            yield self._followed("by_starts", others.by_starts, note)
        if others is not None and others.motion_from_rest is not None:
            from_rest = others.motion_from_rest
            note = say("from_rest_note", from_rest, *self._printed(from_rest.growth))
            yield self._followed("from_rest", (from_rest,), note)

    def _followed(self, macro: str, motions: tuple[FollowedMotion, ...], note: str) -> Table:
        rows = [(x.name, x.stability, *self._printed(x.low, x.high), *x.ends) for x in motions]
        return worded_table(self._say, macro, "ttnntt", rows, motions[0], note=note)

    def critical_points(self) -> Table:
        """The motions at the critical points, each followed by its mirror image where it has one."""
        solution, soft, say = self.study.solution, self.study.own_stiffness is not None, self._say
        rows = []
        for x in solution.critical_points:
            name = f"[{x.label}]{{#point-{x.label}}}"
            rows.append((name, say("happens", x), *self._state(x, x, x.closed.phi_top)))
            if x.mirror is not None:
                # The mirror image hits the top when the motion hits the bottom, half a forcing period on.
                top = float(np.mod(x.closed.phi_bottom + pi, 2 * pi))
                rows.append((x.label, say("mirrored"), *self._state(x, x.mirror, top)))
        contact, bound = self.study.evidence.contact_share, error_bound(self.largest_bound)
        share = "" if contact is None else percent(contact)
        note = say("critical_points_note", share, solution.parameter.with_unit(bound), soft)
        return worded_table(say, "critical_points", "ttnnnnnnnn", rows, solution.parameter, soft, note=note)

    @property
    def largest_bound(self) -> float:
        """Largest error bound of the critical points [unit of the swept parameter]."""
        return max(x.error_bound for x in self.study.solution.critical_points)

    def _state(self, critical: Point, motion: Point, phi_top: float) -> Iterator[str]:
        """Where a critical point is and how well that is known, or where it is with soft membranes; and its motion."""
        closed, soft = motion.closed, self.study.own_stiffness
        velocities = (0.0 if abs(x) < NOTHING else x for x in (closed.velocity_bottom, closed.velocity_top))
        yield from self._printed(critical.sweep_value)
        if soft is None:
            yield error_bound(critical.error_bound)
        elif (end := soft.end_of(self.study.solution.parameter, critical)) is not None and end.compliant is not None:
            yield from self._printed(end.compliant)
        else:
            yield ABSENT if end is None or end.absence is None else end.absence.missing
        yield from self._printed(critical.d, 0.5 + closed.u, closed.phi_bottom, phi_top, *velocities)

    def voltages(self) -> Iterator[Table]:
        """Voltages of the stable motions, what the ball mass does to them, and the energy that they convert."""
        return voltage_tables(self.study.solution, self._exactness, self._say)

    def motions(self) -> Iterator[Table]:
        """The motions of other impact sequences."""
        return motion_tables(self.study, self._say)

    def requirements(self) -> Table:
        """What the scenario requires, and whether it is met."""
        say, rows, name = self._say, [], unmarked(PurePath(self.study.loaded.document.name).name)
        for x in self.study.criteria:
            numbers = map(self._set, (x.limit.text, x.outcome.text, x.margin_text or ABSENT))
            title, verdict = f"[{self._set(x.title)}]{{#requirement-{x.key}}}", say("met" if x.passed else "not_met")
            rows.append((title, verdict, *numbers, say("stated", x, name)))
        return worded_table(say, "requirements", "tttttt", rows, note=say("requirements_note"))

    def remarks(self) -> Table:
        """Where the values come from that requirements are held against."""
        explained = (x for x in self.study.criteria if x.outcome.why)
        rows = [(f"[{self._set(x.title)}](requirement-{x.key})", capital(self._set(x.outcome.why))) for x in explained]
        return worded_table(self._say, "remarks", "tt", rows)

    def _set(self, text: str | Phrase) -> str:
        """A text of what is judged, typeset."""
        return words(spoken(text, self.templates))


def motion_tables(study: Study, say: Words) -> Iterator[Table]:
    """What stable motions of each impact sequence generate at most, if there are any, and the families that are shown.

    Of families stable ones come first, with the voltage in the middle of the longest stable range.
    """
    atlas, membrane, exactness = study.atlas, study.solution.membrane, study.evidence.exactness
    if atlas is None:
        return
    swept, rows, volts = atlas.sweep.parameter, [], "nn" if membrane is not None else ""
    for rung in ladder(atlas.printed_families, membrane):
        ranges = "; ".join(swept.with_unit(span(*part, exactness)) for part in rung.ranges)
        most = (quantity(rung.average_v, "V", exactness), f"{quantity(rung.per_second_v, 'V', exactness)}/s")
        impacts = " to ".join(dict.fromkeys(map(rounded_text, rung.impacts_per_s)))
        rows.append((rung.word.letters, str(rung.word.periods), ranges, *(most if volts else ()), impacts))
    if rows:
        yield worded_table(say, "ladder", f"tnt{volts}n", rows, swept, bool(volts))
    order = sorted(atlas.printed_families, key=lambda family: not family.stable_runs)
    rows = [(*_row(family, exactness, say), *_voltage(study, family)) for family in order]
    yield worded_table(say, "families", f"ttnnntt{volts}", rows, swept, bool(volts))


def _row(family: Family, exactness: Exactness, say: Words) -> tuple[str, ...]:
    ranges = ((span(*part, exactness), settable(*part, family.sweep.off)) for part in family.stable_ranges)
    stable = ", ".join(part if wide else say("too_narrow", part) for part, wide in ranges) or say("nowhere")
    whole = span(float(family.sweep_value.min()), float(family.sweep_value.max()), exactness)
    word, ends = family.word, (_end(family, mark, say) for mark in family.ends)
    return (word.letters, word.ratio, str(word.periods), whole, stable, *ends)


def _end(family: Family, mark: Mark, say: Words) -> str:
    if mark.event is Event.LOST:
        return say("lost", rounded_text(float(family.sweep_value[mark.row])))
    return mark.point.label if mark.point is not None and mark.point.label else mark.event.replace("_", " ")


def _voltage(study: Study, family: Family) -> tuple[str, ...]:
    """U_ave and voltage per second in the middle of the longest stable run, else of the family."""
    membrane = study.solution.membrane
    if membrane is None:
        return ()
    first, last = max(family.stable_runs, key=lambda run: run[1] - run[0], default=(0, len(family.x) - 1))
    whole, row = generation(family, membrane), (first + last) // 2
    exactness = study.evidence.exactness
    return rounded_text(float(whole.average_v[row]), exactness), rounded_text(float(whole.per_second_v[row]), exactness)


def _room(value: float, at: float) -> str:
    """How far a value is from that of the design, over it, as text."""
    return percent((value - at) / at if at else None, signed=True)
