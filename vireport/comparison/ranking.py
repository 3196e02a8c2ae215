"""Which scenario of a comparison is best, and why: requirements, stable motion, margin and voltage, in this order.

Before the margin come outcome from rest, recovery and least shock, where they are asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import plain
from vireport.comparison.results import RankedData
from vireport.design.margins import Margin
from vireport.design.point import DesignPoint
from vireport.physics.device import Device
from vireport.report.changes.sentences import NOTHING, listed
from vireport.scenario.parameters import DesignInput
from vireport.study.judging.evidence import unmet_criteria
from vireport.study.judging.opening import margin_said
from vireport.study.judging.verdict import AddedConclusion, AnyConclusion, Conclusion
from vireport.study.study import Study
from vireport.text.foreign import visible
from vireport.text.formatting import ABSENT, percent, quantity, rounded_text
from vireport.text.said import Said, spoken, words_of
from vireport.text.tables import Table, numbers, texts, worded_table
from vireport.text.templates import Words

_said = words_of("compare")

if TYPE_CHECKING:
    from vireport.findings.outcomes.outcomes import Outcomes
    from vireport.findings.outcomes.withstood import Withstood

RANKED_DIGITS = 9
"""Significant digits in which two scenarios differ if one is to be better than the other."""

IMPACTS_PER_PERIOD = 2
"""Impacts of a 1:1 motion in one of its periods."""


class Merit(StrEnum):
    """What scenarios are ranked by, what matters most first, some only where asked for; more of each is better."""

    REQUIREMENTS = "requirements"
    STABILITY = "stability"
    FROM_REST = "from_rest"
    RECOVERY = "recovery"
    SHOCK = "shock"
    MARGIN = "margin"
    RANGE = "range"
    VOLTAGE = "voltage"
    RATE = "rate"


RANK_BY = {"from-rest": Merit.FROM_REST, "recovery": Merit.RECOVERY, "shock": Merit.SHOCK}
"""What scenarios are ranked by only where it is asked for, by its name on the command line."""

ALWAYS = tuple(merit for merit in Merit if merit not in RANK_BY.values())
VOLTAGES = Merit.VOLTAGE, Merit.RATE
FIRST = Merit.REQUIREMENTS, Merit.STABILITY
"""What no other merit makes up for."""

HEADS = "head_scenario", "head_rank", "head_verdict"
"""What the first columns of the ranking are called: macros."""

RANKING_COLUMNS = (Merit.REQUIREMENTS, *RANK_BY.values(), Merit.MARGIN, Merit.VOLTAGE, Merit.RATE, Merit.RANGE)
"""Columns of the ranking, in which a wide one comes last."""


class Ranked(Struct, frozen=True, eq=False):
    """A scenario and its place among those that it is compared with.

    Attributes
    ----------
    name : str
    rank : int
        From 1; the same for scenarios that differ in no merit.
    study : Study
    margin : Margin or None
        To the nearest end of stable motion over all inputs by rigid impacts; None where the design point has no stable
        motion, or it ends nowhere, or its end is not known.
    merits : mapping of Merit to float or None
        Requirements not met, as a negative number; 1 for stable motion that no simulation contradicts, else 0; 1 where
        1:1 motion is reached from rest, else 0; forcing periods until 1 % of a small disturbance is left, as a negative
        number; least shock found [m/s] of the stable 1:1 motions, or else of what is reached from rest, at most what
        was tried in every scenario without one; margin to use [1], 0 where nothing is left, infinite where stable
        motion ends nowhere; width of the widest stable range, where there is no margin; U_ave [V] and voltage per
        second [V/s] of the stable motion at the design point, of several the least.
    order : tuple of Merit
        The merits that scenarios are ranked by, the most important first.
    """

    name: str
    rank: int
    study: Study
    margin: Margin | None
    merits: Mapping[Merit, float | None]
    order: tuple[Merit, ...] = ALWAYS

    def __repr__(self) -> str:
        return f"<Ranked {self.rank}: {visible(self.name)}, {self.study.verdict.word}>"

    @property
    def stable(self) -> bool:
        """Whether there is stable motion, at the design point where there is one."""
        return bool(self.merits[Merit.STABILITY])

    @property
    def key(self) -> tuple[float, ...]:
        """The merits, rounded; of two scenarios the one with the larger key is better."""
        # Scenarios without a margin, or without a voltage, come after all that have one.
        values = (self.merits[merit] for merit in self.order)
        return tuple(-inf if value is None else float(f"{value:.{RANKED_DIGITS}g}") for value in values)

    @property
    def passed(self) -> int:
        """Requirements that are met."""
        return len(self.study.criteria) - len(unmet_criteria(self.study.criteria))

    def show(self, merit: Merit, templates: Path | None = None) -> str:
        """Print a merit with its unit, or a dash where there is none."""
        return str(spoken(self.said(merit), templates))

    def said(self, merit: Merit) -> str | Said:
        """A merit with its unit, to be said within a sentence or a table; a dash where there is none."""
        value = self.merits[merit]
        if merit is Merit.REQUIREMENTS:
            count = len(self.study.criteria)
            return _said("of_them", self.passed, count) if count else ABSENT
        if merit is Merit.RANGE:
            return "; ".join(self.study.verdict.inequalities) or ABSENT
        if merit in RANK_BY.values():
            return self._disturbed(merit, value)
        if merit is Merit.MARGIN:
            return self.room[0]
        if value is None:
            return ABSENT
        return quantity(value, "V/s" if merit is Merit.RATE else "V", self.study.verdict.exactness)

    @property
    def room(self) -> tuple[str | Said, str | Said]:
        """The margin to use, and what limits it; dashes where there is no stable motion at a design point."""
        return (margin_said(self.study.verdict) if self.stable else None) or (ABSENT, ABSENT)

    def _disturbed(self, merit: Merit, value: float | None) -> str | Said:
        """What becomes of the motion as the device is switched on, or bumped."""
        switched_on, withstood = self.study.switched_on, _withstood(self.study)
        if merit is Merit.FROM_REST:
            return (
                switched_on.from_rest.name if switched_on is not None and switched_on.from_rest is not None else ABSENT
            )
        if value is None:
            return ABSENT
        if merit is Merit.RECOVERY:
            return _said("periods", rounded_text(-value))
        if withstood is not None and withstood.jump_m_s is not None:
            return quantity(withstood.jump_m_s, "m/s")
        return _said("more_than", quantity(_withstands_all(self.study) or 0.0, "m/s"))

    @property
    def data(self) -> RankedData:
        """The scenario as compare.json has it; an unlimited margin is null, and `margin_limited` false."""
        rigid, verdict = _rigid_room(self.study), self.study.verdict
        use = verdict.margin.data.to_use if verdict.margin is not None else None
        switched_on, withstood = self.study.switched_on, _withstood(self.study)
        return RankedData(
            scenario=self.name,
            rank=self.rank,
            verdict=verdict.word,
            conclusions=[conclusion.name.lower() for conclusion in verdict.conclusions],
            requirements_met=self.passed,
            requirements=len(self.study.criteria),
            stable=self.stable,
            margin_to_use=None if use is None else use.data,
            smallest_margin=rigid if rigid is not None and isfinite(rigid) else None,
            margin_limited=None if rigid is None else isfinite(rigid),
            margin_parameter=None if self.margin is None else str(self.margin.parameter),
            margin_kind=None if self.margin is None else str(self.margin.event),
            u_ave_v=self.merits[Merit.VOLTAGE],
            u_per_second_v=self.merits[Merit.RATE],
            from_rest=None
            if switched_on is None or switched_on.from_rest is None
            else switched_on.from_rest.destination,
            recovery_periods=None
            if switched_on is None or switched_on.recovery is None
            else switched_on.recovery.periods,
            least_jump_m_s=None if withstood is None else withstood.jump_m_s,
            stable_range=[[part.start, part.end] for part in self.study.solution.stable_ranges],
        )

    def to_dict(self) -> dict[str, Any]:
        """The scenario as plain data."""
        data: dict[str, Any] = plain(self.data)
        return data


def rank_studies(studies: Mapping[str, Study], merits: Sequence[Merit] = ()) -> tuple[Ranked, ...]:
    """Rank scenarios, given by their names, the best first; those that differ in no merit stay in their order.

    Merits that are asked for come after stable motion and before the margin.
    """
    order = (*FIRST, *merits, *(merit for merit in ALWAYS if merit not in FIRST))
    swept = {study.solution.sweep.parameter for study in studies.values() if study.solution.sweep is not None}
    # Scenarios that withstand all shocks tried do not differ by how far these were: the least such size counts.
    tried = min((size for study in studies.values() if (size := _withstands_all(study)) is not None), default=inf)
    unranked = [
        Ranked(name, 1, study, *_merits(study, len(swept) == 1, tried), order) for name, study in studies.items()
    ]
    ranked = [replace(scenario, rank=1 + sum(other.key > scenario.key for other in unranked)) for scenario in unranked]
    return tuple(sorted(ranked, key=lambda scenario: scenario.rank))


def _impacts_per_second(device: Device) -> float:
    return IMPACTS_PER_PERIOD * float(device.frequency_hz or 0.0) / device.period_ratio


def _withstood(study: Study) -> Withstood | None:
    """What the motion in use withstands: the stable 1:1 motions or, where there are none, what is reached from rest."""
    outcomes: Outcomes | None = study.findings.get("outcomes")
    return None if outcomes is None else outcomes.withstood_in_use


def _withstands_all(study: Study) -> float | None:
    """Size up to which shocks were tried, where none leads out [m/s]."""
    withstood = _withstood(study)
    return None if withstood is None or withstood.jump_m_s is not None else withstood.searched_to_m_s


def _merits(study: Study, alike: bool, tried: float) -> tuple[Margin | None, dict[Merit, float | None]]:
    """Find the margin and the merits of a scenario.

    `alike` says whether all sweeps are of one parameter, `tried` is the size of shocks that counts for scenarios that
    withstand all shocks tried [m/s].
    """
    solution, stable = study.solution, bool(study.verdict.motion.data.types)
    runs = stable or (solution.on_table and bool(study.verdict.motion.data.instead))
    design = solution.design
    margin = _room(design)[0] if design is not None and stable else None
    room = _room_to_use(study) if stable else None
    # Metres and newtons have no order: ranges of different parameters are compared by their width over their middle.
    widths = [
        (part.end - part.start) / (1.0 if alike else (part.start + part.end) / 2) for part in solution.stable_ranges
    ]
    voltage = None if design is None else design.u_ave_v
    switched_on, withstood = study.switched_on, _withstood(study)
    shock = _withstands_all(study)
    if withstood is not None and withstood.jump_m_s is not None:
        shock = withstood.jump_m_s
    per_second = _impacts_per_second(solution.device)
    return margin, {
        Merit.REQUIREMENTS: float(-len(unmet_criteria(study.criteria))),
        Merit.STABILITY: float(runs and Conclusion.NOT_VERIFIED not in study.verdict.conclusions),
        Merit.FROM_REST: None
        if switched_on is None or switched_on.from_rest is None
        else float(switched_on.from_rest.is_one_to_one),
        Merit.RECOVERY: None if switched_on is None or switched_on.recovery is None else -switched_on.recovery.periods,
        Merit.SHOCK: None if shock is None else min(shock, tried),
        Merit.MARGIN: room,
        Merit.RANGE: max(widths, default=None) if room is None else None,
        Merit.VOLTAGE: voltage,
        Merit.RATE: None if voltage is None else per_second * voltage,
    }


def _room_to_use(study: Study) -> float | None:
    """The margin to use as a share: 0 where nothing is left, infinite where there is no end, None where not known."""
    margin = study.verdict.margin
    if margin is None or margin.data.unresolved:
        return None
    use = margin.data.to_use
    if use is None or (use.relative is None and not use.gone):
        return inf
    return 0.0 if use.gone else use.relative


def _rigid_room(study: Study) -> float | None:
    """The margin by rigid impacts; see `_room`."""
    design = study.solution.design
    return _room(design)[1] if design is not None and study.verdict.motion.data.types else None


def held_against(conclusion: AnyConclusion) -> Said:
    """A conclusion in a few words, as they stand in the column of verdicts and before names."""
    file = conclusion.words if isinstance(conclusion, AddedConclusion) else "compare"
    return Said(f"lacks_{conclusion.name.lower()}", (), file)


def _room(design: DesignPoint) -> tuple[Margin | None, float | None]:
    """Find the nearest end of stable motion and its relative distance, infinite where there is no end."""
    # An end that rounding does not resolve may be nearer than all known ends.
    if design.unresolved_inputs:
        return None, None
    end = next((end for end in design.limits() if end.relative is not None), None)
    return end, inf if end is None else end.size


def remarks(ranked: Sequence[Ranked]) -> Iterator[Said]:
    """Say which scenarios cannot be compared in margin or voltage."""
    for macro, concerned in (
        ("no_design_point", [scenario for scenario in ranked if scenario.study.solution.design is None]),
        ("no_ball_mass", [scenario for scenario in ranked if scenario.study.solution.membrane is None]),
    ):
        if 0 < len(concerned) < len(ranked):
            yield _said(macro, listed([scenario.name for scenario in concerned]))


def ranking_table(ranked: Sequence[Ranked], templates: Path | None = None) -> Table:
    """Set the ranking with the numbers that it rests on."""
    order = ranked[0].order
    merits = [merit for merit in RANKING_COLUMNS if merit in order]
    filled = [merit for merit in merits if any(scenario.said(merit) != ABSENT for scenario in ranked)]
    # Of devices that strike equally often it is the same multiple of the mean voltage.
    if len({_impacts_per_second(scenario.study.solution.device) for scenario in ranked}) == 1:
        filled = [merit for merit in filled if merit is not Merit.RATE]
    heads = [_said(f"head_{merit}") for merit in filled]
    rows = [[*map(scenario.said, filled)] for scenario in ranked]
    if Merit.MARGIN in filled:
        after = filled.index(Merit.MARGIN) + 1
        heads.insert(after, _said("head_limited_by"))
        for row, scenario in zip(rows, ranked, strict=True):
            row.insert(after, scenario.room[1])
    scenario_head, rank_head, *other_heads = spoken([*map(_said, HEADS), *heads], templates)
    columns = (*texts(scenario_head), *numbers(rank_head), *texts(*other_heads))
    against = [[held_against(of) for of in scenario.study.verdict.conclusions] for scenario in ranked]
    cells = tuple(
        (scenario.name, str(scenario.rank), _said("verdict", held).words(templates), *spoken(row, templates))
        for scenario, held, row in zip(ranked, against, rows, strict=True)
    )
    requested = [_said(f"by_{merit}") for merit in order if merit in RANK_BY.values()]
    note = _said("ranked_by_rate" if Merit.RATE in filled else "ranked_by", requested)
    return Table(_said("ranking").words(templates), columns, cells, note.words(templates))


def margins_table(ranked: Sequence[Ranked], templates: Path | None = None) -> Table | None:
    """Set the nearest end of stable motion along each input; None where no scenario has stable motion."""
    designs = [(scenario.name, scenario.study.solution.design) for scenario in ranked]
    rows = tuple(
        (name, *spoken(list(_ends(design)), templates))
        for name, design in designs
        if design is not None and design.motions.stable_mask.any()
    )
    if not rows:
        return None
    say, heads = Words("compare", templates), [f"{varied.quantity} {varied.symbol}" for varied in DesignInput]
    return worded_table(say, "margins", f"t{'n' * len(heads)}", rows, heads, note=say("distances"))


def _ends(design: DesignPoint) -> Iterator[str | Said]:
    """Print the nearest end of stable motion along each input, with the letter of its kind."""
    for varied in DesignInput:
        nearest = design.nearest_ends.get(varied)
        if varied in design.unresolved_inputs:
            yield _said("not_known")
        elif nearest is None:
            yield NOTHING
        elif nearest.relative is None:  # the design value is zero, as the inclination of a horizontal capsule is
            yield f"{varied.signed(nearest.distance)} {nearest.event.letter}"
        else:
            yield f"{percent(nearest.relative, signed=True)} {nearest.event.letter}"
