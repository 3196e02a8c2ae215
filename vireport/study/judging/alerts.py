"""Alerts that results raise: what a reader must know before acting on the numbers.

`CAUSES` has for each alert of the catalogue (`vireport.text.alerts`) the function that finds its cause in the results,
as numbers; its words are in `words/alerts.json`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import log10
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from vireport.base.records import plain
from vireport.design.sensitivity import input_error, mass_elasticity, restitution_effect
from vireport.motions.error_bounds import undecided
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.physics.forcing import peaks
from vireport.physics.groups import by_wall
from vireport.physics.motion import Symmetry
from vireport.physics.reach import is_table
from vireport.scenario.blocks import Scenario
from vireport.scenario.parameters import Parameter
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.findings import with_results
from vireport.study.judging.impacts import other_motions
from vireport.study.judging.stretch import (
    DEMONSTRATED,
    STATED_FIELD_V_M,
    contact_at_radius,
    severity_of,
    stretch_at_design,
)
from vireport.study.result_records import AlertData
from vireport.text.alerts import CATALOGUE, AlertCode, Explanation, Sentence, Severity
from vireport.text.formatting import Exactness, percent
from vireport.text.patterns import Phrase

if TYPE_CHECKING:
    from vireport.design.followed import FollowedMotion
    from vireport.design.from_rest import FromRest
    from vireport.measurement.shaker import ShakerFinding

NEAR_CRITICAL = 0.02
"""Share of the design value within which a critical point is near: what masses and lengths are commonly made to. The
same share of the length is near a membrane."""

ROUGH = 1e-12
"""Relative error bound above which a critical point is called rough."""

ILL_CONDITIONED = 1e-9
"""Change of q or phase by one rounding of the inputs, above which digits are missing that a reader would trust."""

LONG_CONTACT = 0.01
"""Share of the forcing period above which a contact is long: shifts are of that size, and critical points move more."""

SENSITIVE = 2.0
"""Relative change of the velocity over that of the restitution; 1/(1-r) alone gives 1 for r = 0.5."""

HEAVY = 0.5
"""Relative change of U_ave over that of the ball's mass above which a mass known to 10 % is not enough for 5 %."""


LONGEST_M = 20.0
"""Length above which millimetres are more likely; the largest wave energy converters are shorter."""

HEAVIEST_BALL = 0.5
"""Mass of the ball over the capsule's, above which the capsule certainly feels it; published devices have up to 0.2."""

SAME_NUMBER = 1e-3
"""Relative difference up to which a value is a common angle in radians, or a round frequency in radians per second: as
it would be typed with four digits."""

FEW_DIGITS = 4
"""Digits below which a frequency in radians per second is only told by a round number of one digit of hertz: one of two
digits is too often near by chance."""

STRONGEST_GRAVITY = 50.0
"""Above what any planet has [m/s^2]."""

MEMBRANE_LENGTHS = ("ball_radius_m", "active_radius_m")
"""Lengths of a membrane's geometry."""

MOST_MOTIONS = 3
"""Other motions that are named."""


class Alert(Struct, frozen=True, eq=False):
    """An alert that results raise, with sentences on its causes that have the numbers."""

    code: AlertCode
    severity: Severity
    title: Phrase
    cause: Phrase
    remedy: Phrase

    def words(self, templates: Path | None = None) -> str:
        """The text of the alert for a terminal."""
        return f"{self.code}: {self.cause.words(templates)} {self.remedy.words(templates)}"

    def __repr__(self) -> str:
        return f"<Alert {self.code}, {self.severity}: {self.title}>"

    @property
    def data(self) -> AlertData:
        """The alert as results.json has it."""
        return AlertData(
            code=self.code,
            severity=self.severity,
            title=str(self.title),
            cause=str(self.cause),
            remedy=str(self.remedy),
        )

    def to_dict(self) -> dict[str, str]:
        """The alert as results.json has it, as plain data."""
        data: dict[str, str] = plain(self.data)
        return data


Cause = Callable[[Evidence], Iterable[Sentence]]
"""The cause of an alert: sentences of its row in the catalogue, with numbers; none where nothing raises it."""


def _no_stable_motion(results: Evidence) -> Iterator[Sentence]:
    solution = results.solution
    if solution.diagram is not None and not solution.stable_ranges and not solution.on_table:
        yield Sentence("nowhere")
        disturbances = results.switched_on
        if disturbances is not None and disturbances.sampled:
            swept = results.solution.parameter
            starts = [
                Sentence("each", {"symbol": swept.symbol, "value": swept.stated(x.start), "motion": x.outcome.name})
                for x in disturbances.sampled
            ]
            yield Sentence("from_rest", {"each": starts})
            blocks = dict.fromkeys(_block_for(end, results) for end in results.from_rest_along)
            if missing := [Sentence("block", {"block": block}) for block in blocks if block is not None]:
                yield Sentence("shown_by", {"blocks": missing})


def _inadmissible(results: Evidence) -> Iterator[Sentence]:
    branches = results.solution.branches
    discarded = [(part, branch) for branch in branches for part in branch.family.segments if not part.admissible]
    if not discarded:
        return
    if results.solution.device.rubs:
        yield Sentence("turns", {"count": len(discarded)})
        return
    depth = -min(float(branch.motions.wall_gap[part.first : part.last + 1].min()) for part, branch in discarded)
    stable = "_stable" if any(part.stability.attracts for part, _ in discarded) else ""
    count = len(discarded)
    yield Sentence(f"{'one' if count == 1 else 'several'}{stable}", {"count": count, "depth": depth})


def _design_not_stable(results: Evidence) -> Iterator[Sentence]:
    design = results.solution.design
    if design is None or design.motions.stable_mask.any():
        return
    if results.required_motions_met or results.solution.on_table:
        return  # the stable motion there is an allowed one, or no motion can be 1:1
    count = len(design.motions)
    place = design.parameter.place(design.value)
    yield Sentence({0: "none", 1: "one"}.get(count, "several"), {"place": place, "count": count})
    if results.solution.device.law is not None:
        yield Sentence("lost" if design.lost else "by_law", {"count": design.lost})
    stable = results.atlas.stable_at(design.value) if results.atlas is not None else []
    if stable:
        yield Sentence("instead", {"others": ", ".join(dict.fromkeys(family.name for family, _ in stable))})
    if results.from_rest is not None:
        end = results.from_rest
        yield Sentence("from_rest", {"motion": end.name})
        if block := _block_for(end, results):
            yield Sentence("shown_by", {"block": block})
        if end.is_one_to_one and results.solution.device.rubs:
            yield Sentence("stops", {})
    if results.motion_from_rest is not None:
        yield Sentence("followed", _followed(results.motion_from_rest, results.exactness))
    for followed in results.by_starts:
        yield Sentence("by_starts", {"motion": followed.name, **_followed(followed, results.exactness)})


def _followed(followed: FollowedMotion, error: Exactness) -> dict[str, str]:
    """The type of a motion and its stable range."""
    low, high = (followed.varied.show(value, error) for value in (followed.low, followed.high))
    ends = {"below": followed.ends[0], "above": followed.ends[1]}
    return {"type": followed.stability, "symbol": followed.varied.symbol, "low": low, "high": high} | ends


def _block_for(end: FromRest, results: Evidence) -> str | None:
    """The block that a scenario lacks and that would show the motion that a ball comes to.

    Families are followed only of motions of few impacts, without rests and without friction; all else needs simulation.
    """
    cycle = end.cycle
    if cycle is not None and not cycle.sticks and not results.solution.device.rubs:
        from vireport.motions.atlas.families import LOOKED_FOR

        if len(end.word) <= LOOKED_FOR:
            return "motions" if results.atlas is None else None
    return "simulation" if results.crosscheck is None else None


def _several_stable(results: Evidence) -> Iterator[Sentence]:
    solution, design = results.solution, results.solution.design
    count = int(design.motions.stable_mask.sum()) if design is not None else 0
    if design is None or count < 2:
        return
    if count == 2 and solution.horizontal and design.families.count(Symmetry.ASYMMETRIC) == 2:
        return  # mirror images of each other
    yield Sentence("count", {"count": count})


def is_near_critical(relative: float | None) -> bool:
    """Whether the end of a motion is near, by its distance over the design value, which is None for a value of zero."""
    return relative is not None and abs(relative) < NEAR_CRITICAL


def _near_critical(results: Evidence) -> Iterator[Sentence]:
    for margin in results.solution.design.limits() if results.solution.design is not None else ():
        if is_near_critical(margin.relative):
            side = "below" if margin.distance < 0 else "above"
            yield Sentence(
                f"passes_{side}" if margin.taken_over else side,
                {
                    "share": percent(margin.size),
                    "quantity": margin.parameter.quantity,
                    "name": margin.name,
                },
            )
            return


def _rough(results: Evidence) -> Iterator[Sentence]:
    points = results.solution.critical_points
    rough = [c.label for c in points if c.error_bound > ROUGH * abs(c.sweep_value)]
    if rough:
        yield Sentence("one" if len(rough) == 1 else "several", {"labels": ", ".join(rough)})


def _near_grazing(results: Evidence) -> Iterator[Sentence]:
    if results.solution.design is None:
        return
    motions = results.solution.design.motions
    gap, d = motions.wall_gap, motions.d
    near = motions.stable_mask & (gap < d) & (gap < NEAR_CRITICAL * d)
    if near.any():
        yield Sentence("turns", {"percent": 100 * float(np.min((gap / d)[near]))})


def _ill_conditioned(results: Evidence) -> Iterator[Sentence]:
    if results.solution.design is None:
        return
    motions = results.solution.design.motions
    error = float(np.max(input_error(results.solution.device, motions)[motions.admissible_mask], initial=0.0))
    if error > ILL_CONDITIONED:
        yield Sentence("moves", {"error": error})


def _sensitive_to_restitution(results: Evidence) -> Iterator[Sentence]:
    if results.solution.design is None:
        return
    effect = restitution_effect(results.solution.device, results.solution.design.motions)
    if effect is not None and effect.lost_at is not None:
        yield Sentence("lost", {"restitution": effect.lost_at})
    elif effect is not None and effect.elasticity > SENSITIVE:
        yield Sentence("changes", {"percent": effect.elasticity})


def _deep_deflection(results: Evidence) -> Iterator[Sentence]:
    membrane, stretch = results.solution.membrane, stretch_at_design(results)
    severity = severity_of(stretch)
    if membrane is None or stretch is None or severity is None:
        return
    numbers = {
        "depth_mm": 1e3 * stretch.depth_m,
        "times": stretch.depth_ratio,
        "radius_mm": 1e3 * membrane.active_radius_m,
        "area": stretch.area_ratio,
    }
    if severity is Severity.WARNING:
        yield Sentence("far", numbers | {"limit": DEMONSTRATED})
    else:
        yield Sentence("deep", numbers)
    if membrane.dielectric is None:
        needed = 1e3 * stretch.thickness_at(STATED_FIELD_V_M)
        stated = {"field_mv_m": STATED_FIELD_V_M / 1e6, "peak_kv": stretch.peak_v / 1e3, "thickness_mm": needed}
        yield Sentence("thickness", stated)
    yield from _no_amplitude(results)


def _no_amplitude(results: Evidence) -> Iterator[Sentence]:
    """The cause of an alert where contacts of the membrane are long at every deflection within its radius."""
    share = contact_at_radius(results)
    if share is not None and share > LONG_CONTACT:
        yield Sentence("no_amplitude", {"percent": 100 * share})


def _breakdown(results: Evidence) -> Iterator[Sentence]:
    design, membrane = results.solution.design, results.solution.membrane
    if design is None or design.conversion_by_motion is None or membrane is None or membrane.dielectric is None:
        return
    highest = float(np.max(design.conversion_by_motion.field_v_m[design.motions.stable_mask], initial=0.0))
    highest = max([highest, *(float(impacts.field_v_m.value) for _, impacts in other_motions(results))])
    limit = membrane.dielectric.breakdown_field_v_m
    if highest > limit:
        yield Sentence("field", {"highest": highest, "times": highest / limit, "limit": limit})


def _more_energy_than_lost(results: Evidence) -> Iterator[Sentence]:
    design = results.solution.design
    if design is None or design.conversion_by_motion is None:
        return
    for motion, impacts in other_motions(results):
        if (share := float(impacts.efficiency.value)) > 1:
            yield Sentence("gains_other", {"motion": motion, "percent": 100 * share})
    if not design.motions.stable_mask.any():
        return
    converted, stable = design.conversion_by_motion, design.motions.stable_mask
    worst = int(np.argmax(np.where(stable, converted.efficiency, -np.inf)))
    efficiency = float(converted.efficiency[worst])
    if efficiency > 1:
        gained = float(converted.energy_bottom_j[worst] + converted.energy_top_j[worst])
        numbers = {"gained_mj": 1e3 * gained, "lost_mj": 1e3 * gained / efficiency, "percent": 100 * efficiency}
        # Where restitutions fall with speed, those of the impacts of this motion.
        bottom, top = (float(np.ravel(r)[0]) for r in by_wall(design.motions.select([worst]).restitution))
        if bottom == top:
            yield Sentence("gains", {**numbers, "restitution": bottom})
        else:
            yield Sentence("gains_apart", {**numbers, "bottom": bottom, "top": top})


def _long_contact(results: Evidence) -> Iterator[Sentence]:
    share = results.contact_share
    if share is not None and share > LONG_CONTACT:
        yield Sentence("share", {"percent": 100 * share})
        if severity_of(stretch_at_design(results)) is None:  # else the alert on deep deflections says so
            yield from _no_amplitude(results)


def _sensitive_to_ball_mass(results: Evidence) -> Iterator[Sentence]:
    membrane, (bottom, top, _) = results.solution.membrane, results.impacts
    if membrane is None or not bottom.size:
        return
    elasticity = mass_elasticity(bottom, top, membrane)
    if elasticity > HEAVY:
        yield Sentence("changes", {"percent": elasticity})


def _admissibility_undecided(results: Evidence) -> Iterator[Sentence]:
    solution, design = results.solution, results.solution.design
    if design is None or solution.bounds.design is None:
        return
    open_rows = np.flatnonzero(undecided(design.motions, solution.bounds.design))
    if open_rows.size:
        gap, bound = design.motions.wall_gap, solution.bounds.design["wall_gap"]
        yield Sentence("gap", {"gap": float(gap[open_rows[0]]), "bound": float(bound[open_rows[0]])})


def _simulation_disagrees(results: Evidence) -> Iterator[Sentence]:
    check = results.crosscheck
    if check is None or check.passed:
        return
    largest = max(check.velocity_difference, check.phase_difference)
    numbers = {"orbits": check.orbits, "missed": len(check.misses), "largest": largest, "tolerance": check.tolerance}
    yield Sentence("left", numbers)


def _coexisting(results: Evidence) -> Iterator[Sentence]:
    check = results.crosscheck
    if check is None or not check.elsewhere:
        return
    named = check.elsewhere[:MOST_MOTIONS]
    others = [Sentence("motion", {"count": motion.count, "name": motion.name}) for motion in named]
    yield Sentence("elsewhere", {"count": check.trials - check.arrivals, "trials": check.trials, "others": others})


def _chatter(results: Evidence) -> Iterator[Sentence]:
    check, device, sweep = results.crosscheck, results.solution.device, results.solution.sweep
    held = sum(motion.count for motion in check.motions if motion.stays) if check is not None else 0
    if check is not None and held:
        yield Sentence("starts", {"held": held, "total": sum(motion.count for motion in check.motions)})
        return
    at = (sweep.parameter, (sweep.start, sweep.end)) if sweep is not None else (Parameter.LENGTH, (device.length_m,))
    parameter, values = at
    gbar = max(device.groups(parameter, value)[1] for value in values)
    if gbar >= peaks(device.harmonics).lift:
        yield Sentence("gravity", {"gbar": gbar})


def _implausible(results: Evidence) -> Iterator[Sentence]:
    solution = results.solution
    sweep = solution.sweep
    swept = None if sweep is None else (sweep.parameter, sweep.start, sweep.end)
    yield from _doubts(solution.device, solution.membrane, swept)


def _doubts(
    device: Device, membrane: Membrane | None, swept: tuple[Parameter, float, float] | None
) -> Iterator[Sentence]:
    """Sentences on implausible inputs and ends of a sweep, and what may have been meant."""
    values = {f"device.{name}": getattr(membrane, name, None) for name in ("ball_mass_kg",)}
    values |= {f"device.membrane.{name}": getattr(membrane, name, None) for name in MEMBRANE_LENGTHS}
    values |= {varied.path: device.value_of(varied) for varied in device.inputs} | {"gravity_m_s2": device.gravity_m_s2}
    values_set = [(path, path, value) for path, value in values.items() if value is not None]
    parameter, *ends = swept if swept is not None else (Parameter.LENGTH,)
    on_table = is_table(device, parameter, tuple(ends))
    if swept is not None:
        values_set += [(f"sweep.{key}", parameter.path, end) for key, end in zip(("from", "to"), ends, strict=True)]
    for path, kind, value in values_set:
        doubt = _doubt(kind, float(value), float(device.capsule_mass_kg))
        if doubt is not None:
            name = "table" if kind == Parameter.LENGTH.path and on_table else doubt.name
            yield Sentence(name, {"path": path, "value": float(value), **doubt.values})


def _doubt(path: str, value: float, capsule: float) -> Sentence | None:
    """The sentence on an implausible value of an input, and what may have been meant; None for a plausible one."""
    match path.rpartition(".")[2]:
        case "length_m" | "ball_radius_m" | "active_radius_m" if value > LONGEST_M:
            return Sentence("length", {"meant": value / 1e3})
        case "ball_mass_kg" if value >= HEAVIEST_BALL * capsule:
            return Sentence("mass", {"times": value / capsule, "capsule": capsule})
        case "inclination_deg":
            turns = value / (np.pi / 12)
            if 0.5 < turns < 6.5 and abs(turns - round(turns)) < SAME_NUMBER * turns:
                return Sentence("angle", {"meant": 15 * round(turns)})
        case "frequency_hz":
            cycles = value / (2 * np.pi)
            digits = next(k for k in range(1, 18) if float(f"{value:.{k}g}") == value)
            short = float(f"{cycles:.{max(digits - 2, 1)}g}" if digits < FEW_DIGITS else f"{cycles:.2g}")
            if digits > 2 and abs(cycles - short) < SAME_NUMBER * cycles:
                return Sentence("frequency", {"meant": short})
        case "gravity_m_s2" if value > STRONGEST_GRAVITY:
            return Sentence("gravity", {"meant": value / 100})
    return None


def doubted(doubt: ShakerFinding) -> Sentence:
    """The sentence of an alert on a finding of a recorded acceleration."""
    numbers = {"channel": doubt.channel, "recorded": doubt.recorded, "given": doubt.stated}
    match doubt.doubt.name:
        case "FACTOR":
            (size, unit), sign = FACTOR_WORDS[round(log10(abs(doubt.value)))], "-" if doubt.value < 0 else ""
            return Sentence("factor", numbers | {"factor": sign + size, "unit": [Sentence(unit)]})
        case "FORCE":
            return Sentence("force", numbers | {"ratio": doubt.value})
        case "LONE":
            return Sentence("lone", numbers | {"at_s": doubt.at_s, "off": doubt.value})
        case "CLIPPED":
            return Sentence("clipped", numbers | {"percent": 100 * doubt.value})
        case _:
            return Sentence("reversed", numbers)


FACTOR_WORDS = {
    1: ("9.81", "in_g"),
    -1: ("1/9.81", "of_g"),
    3: ("1000", "thousand"),
    -3: ("1/1000", "thousandth"),
}
"""A factor by which a record is off, and the sentence on its unit, by the factor's power of ten."""


CAUSES: dict[AlertCode, Cause] = {
    AlertCode.NO_STABLE_MOTION: _no_stable_motion,
    AlertCode.INADMISSIBLE_SOLUTIONS: _inadmissible,
    AlertCode.DESIGN_NOT_STABLE: _design_not_stable,
    AlertCode.SEVERAL_STABLE_MOTIONS: _several_stable,
    AlertCode.NEAR_CRITICAL_POINT: _near_critical,
    AlertCode.ROUGH_CRITICAL_POINT: _rough,
    AlertCode.NEAR_GRAZING: _near_grazing,
    AlertCode.ILL_CONDITIONED: _ill_conditioned,
    AlertCode.SENSITIVE_TO_RESTITUTION: _sensitive_to_restitution,
    AlertCode.DEEP_DEFLECTION: _deep_deflection,
    AlertCode.LONG_CONTACT: _long_contact,
    AlertCode.SENSITIVE_TO_BALL_MASS: _sensitive_to_ball_mass,
    AlertCode.ADMISSIBILITY_UNDECIDED: _admissibility_undecided,
    AlertCode.IMPLAUSIBLE_INPUT: _implausible,
    AlertCode.BREAKDOWN: _breakdown,
    AlertCode.MORE_ENERGY_THAN_LOST: _more_energy_than_lost,
    AlertCode.SIMULATION_DISAGREES: _simulation_disagrees,
    AlertCode.COEXISTING_MOTIONS: _coexisting,
    AlertCode.CHATTER: _chatter,
}


def causes_of(code: AlertCode, evidence: Evidence) -> Iterator[Sentence]:
    """Sentences on what raises an alert, from the findings of the core and of additions."""
    if code in CAUSES:
        yield from CAUSES[code](evidence)
    for finding, result in with_results(evidence.findings):
        yield from finding.causes(result, evidence).get(code, ())


def alerts(evidence: Evidence) -> tuple[Alert, ...]:
    """Collect the alerts that results raise, the gravest first."""
    causes = ((entry, tuple(causes_of(entry.code, evidence))) for entry in CATALOGUE)
    raised = [_raised(entry, sentences) for entry, sentences in causes if sentences]
    return tuple(sorted(raised, key=lambda alert: (alert.severity.rank, alert.code)))


def named_alerts(raised: Iterable[Alert], templates: Path | None = None) -> str:
    """Alerts by their codes and titles, for a terminal."""
    return f"Alerts: {'; '.join(f'{alert.code} {alert.title.words(templates)}' for alert in raised)}."


def input_alerts(scenario: Scenario) -> tuple[Alert, ...]:
    """The alerts that the values of a scenario raise before anything is computed, in the form of those of results."""
    sweep = scenario.sweep
    swept = None if sweep is None else (sweep.parameter, sweep.from_, sweep.to)
    return _alone(AlertCode.IMPLAUSIBLE_INPUT, _doubts(Device.of(scenario), Membrane.of(scenario), swept))


def record_alerts(doubts: Iterable[ShakerFinding]) -> tuple[Alert, ...]:
    """The alerts that a recorded acceleration raises by itself, in the form of the alerts of results."""
    return _alone(AlertCode.RECORD_DOUBTFUL, map(doubted, doubts))


def _alone(code: AlertCode, sentences: Iterable[Sentence]) -> tuple[Alert, ...]:
    """One alert with its sentences; none where there are none."""
    entry, said = next(entry for entry in CATALOGUE if entry.code is code), tuple(sentences)
    return (_raised(entry, said),) if said else ()


def _raised(entry: Explanation, sentences: tuple[Sentence, ...]) -> Alert:
    return Alert(entry.code, entry.severity_of(sentences), entry.title, entry.cause(sentences), entry.remedy)
