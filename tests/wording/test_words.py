"""The words of templates: every branch of them is said here by some results, and by no name that is not there."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import pytest
from conftest import EXAMPLES, solved, toleranced
from jinja2 import nodes
from jinja2.compiler import CodeGenerator
from jinja2.meta import find_undeclared_variables
from msgspec.structs import replace

from vireport import analyse, load
from vireport.chart.words import Naming
from vireport.design import MeasuredShare, Solution, Unmoved
from vireport.disturbances import (
    Destination,
    Disturbances,
    Edge,
    FromRest,
    Met,
    Nearby,
    NoRecovery,
    OutcomeRange,
    Ramp,
    Recovery,
    Window,
)
from vireport.figures.captions import FILES, Circles, Extent, MeasuredShown, Strip
from vireport.gate import Evidence, Status, WordedVerdict, verdict_of
from vireport.maps.cells import AxisName
from vireport.measurement import BetterFit, NoFit, Open, Unfit, Unknown
from vireport.membranes import Grade
from vireport.motions import Event, Limits
from vireport.physics import ElectricalCycle, Word
from vireport.report.markdown import FILTERS as MARKDOWN_FILTERS
from vireport.report.templates import FILTERS
from vireport.scenario import DesignInput, LeftOut, Parameter
from vireport.study import Task
from vireport.wording import TEMPLATES, Words, environment_of
from vireport.wording import templates as wording

TAKEN_OVER = {
    "device__capsule_mass_kg": 0.17773325,
    "device__restitution": 0.45996,
    "device__length_m": 5.042418,
    "excitation__amplitude_n": 20.930283,
    "excitation__frequency_hz": 1.8435747,
    "inclination_deg": 0.0,
}
"""A device whose symmetric motion comes to a fold before its pitchfork, on the other side."""

HANDOVER = {
    "event": Event.PITCHFORK,
    "name": "pitchfork",
    "label": "",
    "relative": -0.1,
    "distance": -4.5,
    "ends_stability": False,
    "taken_over": True,
}
"""A pitchfork at which another motion takes over."""

WORDS = sorted((TEMPLATES / "words").rglob("*.j2"))
FROM_OUTSIDE = {"report", "macros"}
"""Names that sections take from the template that includes them."""

OF_BENCH = {"title", "start"}
"""Names that the page of the bench takes from its server."""


@pytest.mark.parametrize("file", sorted(TEMPLATES.rglob("*.j2")), ids=lambda file: str(file.relative_to(TEMPLATES)))
def test_a_template_has_no_name_that_nothing_defines(file: Path) -> None:
    source = file.read_text(encoding="utf-8")
    environment = environment_of(None)
    environment.filters |= MARKDOWN_FILTERS if file.name.endswith(".md.j2") else FILTERS
    tree = environment.parse(source)
    # What is set in a branch counts as undeclared, though it is used in that branch alone.
    own = {name.name for name in tree.find_all(nodes.Name) if name.ctx != "load"}
    own |= {macro.name for macro in tree.find_all(nodes.Macro)}
    names = find_undeclared_variables(tree) - own
    assert names <= (set() if file in WORDS else OF_BENCH if file.parent.name == "bench" else FROM_OUTSIDE)


def thing(**of: object) -> SimpleNamespace:
    return SimpleNamespace(**of)


class Branches(CodeGenerator):
    """Compiles templates so that each branch tells that it was taken."""

    def visit_Template(self, node: nodes.Template, frame: object = None) -> None:
        for k, branch in enumerate(node.find_all((nodes.If, nodes.For, nodes.CondExpr))):
            place = f"{self.name}:{branch.lineno}:{k}"
            if isinstance(branch, nodes.CondExpr):
                branch.expr1 = self.told(f"{place} true", branch.expr1)
                branch.expr2 = branch.expr2 and self.told(f"{place} false", branch.expr2)
            else:
                branch.body.insert(0, nodes.ExprStmt(self.told(f"{place} true"), lineno=branch.lineno))
                if branch.else_:
                    branch.else_.insert(0, nodes.ExprStmt(self.told(f"{place} false"), lineno=branch.lineno))
        super().visit_Template(node, frame)

    def told(self, branch: str, value: nodes.Expr | None = None) -> nodes.Call:
        self.environment.branches.add(branch)
        given = [nodes.Const(branch), value or nodes.Const(None)]
        return nodes.Call(nodes.EnvironmentAttribute("taken"), given, [], None, None).set_lineno(0)


@pytest.fixture(scope="module")
def taken() -> Iterator[Callable[[], tuple[set[str], set[str]]]]:
    """The branches of the words, and those that were taken."""
    environment, told = environment_of(None), set()
    environment.bytecode_cache = None  # where other runs would find templates that tell

    def tell(branch: str, value: object) -> object:
        told.add(branch)
        return value

    environment.branches, environment.taken, environment.code_generator_class = set(), tell, Branches
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wording, "_environment", lambda templates: environment)
        yield lambda: (environment.branches, told)


def said(words: str, macro: str, *given: object) -> str:
    return Words(words)(macro, *given)


def check(**given: object) -> SimpleNamespace:
    """A simulation that found every stable motion again, and some other motions."""
    others = tuple(thing(count=count, name=name) for count, name in ((4, "BBT"), (3, "BTBT"), (2, "chaos"), (1, "B")))
    usual = {"passed": True, "orbits": 9, "misses": (), "velocity_difference": 1e-14, "phase_difference": 2e-14}
    usual |= {"trials": 20, "reached": 15, "share": (0.75, 0.5, 0.9), "elsewhere": (), "motions": others, "values": [0]}
    return thing(**usual | given, others=others)


def followed(*words: str) -> SimpleNamespace:
    """Families of motions that are stable wherever it is asked."""
    families = [thing(word=Word.of(*word.split(), *([3] if "3" in word else []))) for word in words]
    for family, word in zip(families, words, strict=True):
        family.word = Word.of(word.rstrip("3"), 3 if word.endswith("3") else 1)
        family.settable, family.settable_at = True, lambda value: True
    return thing(families=families, stable_at=lambda value: [(family, None) for family in families])


def required(passed: bool, question: str = "MARGIN") -> SimpleNamespace:
    from vireport.gate import Question

    limit = thing(text="at least 5 %")
    return thing(
        passed=passed,
        names_motions=question == "MOTION",
        question=Question[question],
        title="Margin",
        limit=limit,
        key="margin_any_percent",
    )


def tolerances(proved: bool, worst: object = None, provable: bool = True, stable: int = 48) -> SimpleNamespace:
    return thing(
        proved=proved, worst=worst, provable=provable, sampled=thing(stable=stable, samples=64, low=0.7, high=0.8)
    )


def compliant(**changed: object) -> Evidence:
    """What the membranes' own stiffness makes of the inclined capsule, changed as a whole or at its ends."""
    point, names = thing(label="B1", event=thing(words="period doubling")), ("compliant", "compliant_margin", "why")
    values = {"rigid": 0.62946, "digits": 3, "compliant": 0.58155, "compliant_margin": 0.0799, "absence": None}
    of_end = {name: changed.pop(name) for name in names if name in changed}
    of_end |= {"absence": of_end.pop("why", None)}
    end = thing(parameter=Parameter.LENGTH, point=point, **values | of_end)
    usual = {"motion": thing(stable=True, contact_share=0.025), "absence": None, "margin_gone": False, "ends": (end,)}
    usual |= {"swept_ends": (end, end) if changed.pop("two", False) else (end,), "end_of": lambda *_: end}
    return Evidence(solved("inclined"), own_stiffness=thing(**usual | changed))


@cache
def distorted() -> Solution:
    """The inclined example with a second harmonic of its force."""
    force = {"excitation.harmonics": [{"order": 2, "percent": 2.0, "phase_deg": 225.0}]}
    return analyse(load(EXAMPLES / "inclined.yaml", force), ("json",)).solution


LENGTH_END = thing(event=Event.PERIOD_DOUBLING, distance=-0.02, parameter=DesignInput.LENGTH)
FIXED, FREE = thing(recoils=False, harmonics=()), thing(recoils=True, harmonics=())


def shift(left_out: str = "RESTITUTION_BOTTOM", **of: object) -> SimpleNamespace:
    """A shift of the nearest end by something that the model leaves out."""
    given = {"left": 0.01, "stable": True, "known": True, "relative": 0.04, "size": -0.05, "speed_m_s": None} | of
    given = {"absence": None} | given
    effect = thing(left_out=LeftOut[left_out], size=given["size"], speed_m_s=given["speed_m_s"])
    return thing(effect=effect, **given)


def film(**given: float) -> dict[str, float]:
    values = {"thickness_m": 1e-3, "relative_permittivity": 4.7, "breakdown_field_v_m": 1e9} | given
    return {f"device__membrane__{key}": value for key, value in values.items()}


HERE = {"sweep__to": 0.62, "device__length_m": 0.6}
"""A sweep of the inclined capsule without stable 1:1 motion, and a design point in it."""


def switched_on(end: Destination = Destination.ONE_TO_ONE, settles: int | None = 17, **given: object) -> Evidence:
    """The inclined capsule with what it comes to when it is switched on."""
    motion = {Destination.ONE_TO_ONE: ("BT", 1), Destination.REST_CYCLE: ("B~", 3)}.get(end, ("", 0))
    found = Disturbances(FromRest(end, *motion, settles), **given)
    return Evidence(solved("inclined"), disturbances=found)


def nowhere_stable(**found: list[FromRest]) -> Evidence:
    """A sweep without stable 1:1 motion and without a design point, and what it comes to in stretches of it."""
    parts = {key: tuple(OutcomeRange(0.6, 0.61, end) for end in ends) for key, ends in found.items()}
    return Evidence(solved("inclined", sweep__to=0.62, device__length_m=None), disturbances=Disturbances(None, **parts))


def withstood(**given: object) -> Evidence:
    """The inclined capsule with what its motion withstands: least shock, of 0.1234 m/s at the bottom, and jitter."""
    usual = {"shock": None, "shock_unknown": "", "jump_m_s": 0.1234, "searched_to_m_s": 1.5, "after_bottom": True}
    usual |= {"delay_s": 0.0, "jitter": None, "spread": None, "jitter_unknown": "", "jitter_m_s": 0.012}
    usual |= {"jitter_restitution": 0.0, "valid_up_to_restitution": None}
    usual |= {"phase_deg": 1.234, "velocity_m_s": 0.0234, "valid_up_to_m_s": 0.00356}
    return Evidence(solved("inclined"), withstood=thing(**usual | given))


SHOCK = thing(tried=9000, sign=1, leads_to=thing(name="B~ every 3 forcing periods"))
RESTING = Edge(0.6912, FromRest(Destination.REST_CYCLE, "B~", 3, 0), accumulates=True)
LENGTH_WINDOW = Window(Parameter.LENGTH, 0.7, RESTING, Edge(0.75, None, accumulates=False))


def nearby(others: str, *values: str) -> Nearby:
    """What 4 other moments lead to, and lengths in cm: the motion of the design point at 69.34 cm where it is "=X"."""
    untold = FromRest(Destination.UNDECIDED)
    here, there = FromRest(Destination.ONE_TO_ONE, "BT", 1, 17), FromRest(Destination.REST_CYCLE, "B~", 3, 0)
    moments = tuple(here if each == "=" else there for each in others)
    met = tuple(Met(float(at[1:]) / 100, 0.4, {"=": here, "!": there, "?": untold}[at[0]]) for at in values)
    return Nearby(0.5928, moments, Parameter.LENGTH, 0.6934, met, here)


NARROW = {"device__length_m": 0.61, "excitation__amplitude_n": 6.9375, "tolerances__length_percent": 10.0}
"""At which 1:1 motion is stable from 0.6083 to 0.6125 m."""

VERDICTS: dict[str, tuple[Callable[[], Evidence], list[str]]] = {
    "swept": (
        lambda: Evidence(solved("inclined")),
        ["Stable 1:1 motion for 0.629 m < s ≤ 0.75 m.", "Ends at 0.629 m: period doubling B1. Sweep of length:"],
    ),
    "throughout": (lambda: Evidence(solved("inclined", sweep__from=0.65)), ["Throughout the sweep. Sweep of length:"]),
    "a doubtful record": (
        lambda: Evidence(solved("inclined"), record_doubts=(object(),)),
        ["the record of the shaker is doubtful (VR018)."],
    ),
    "two ends": (
        lambda: Evidence(solved("inclined", sweep__to=1.6)),
        ["Ends at 0.629 m: period doubling B1; 1.43 m: fold C1. Sweep"],
    ),
    "too narrow to be set": (
        lambda: Evidence(toleranced(**NARROW, sweep__to=2.0)),
        [
            "At the design point s = 0.61 m: only in a range of length too narrow to be set.",
            "None that can be set Only in a range of length too narrow to be set",
            "The ball keeps striking each membrane once in every forcing period (a 1:1 motion) only in a range of",
            "no stable 1:1 motion that can be set to evaluate it for",
        ],
    ),
    "too narrow without a design point": (
        lambda: Evidence(toleranced(**NARROW | {"device__length_m": None}, sweep__to=0.615)),
        ["No stable 1:1 motion in the sweep that can be set.", "Only in a range of length too narrow to be set"],
    ),
    "too narrow without a sweep": (
        lambda: Evidence(toleranced(**NARROW, sweep=None)),
        ["Stable 1:1 motion: only in a range of length too narrow to be set."],
    ),
    "nothing that some starts do not find": (
        lambda: Evidence(
            solved("inclined", device__length_m=0.6),
            disturbances=Disturbances(
                FromRest(Destination.REST_CYCLE, "B~", 8, 0), by_starts=(thing(name="B every 2 forcing periods"),)
            ),
        ),
        ["from rest the ball comes to rest every 8 forcing periods (B~); some starts in flight come to B every 2"],
    ),
    "elsewhere in the sweep": (
        lambda: Evidence(solved("inclined", device__length_m=0.6)),
        [
            "Stable 1:1 motion for 0.629 m < s ≤ 0.75 m. At the design point s = 0.6 m: no stable 1:1 motion.",
            "2 admissible 1:1 motions at s = 0.6 m, none of them stable",
            "Along the sweep the 1:1 motion is stable for 0.629 m",
        ],
    ),
    "without a design point": (
        lambda: Evidence(solved("inclined", device__length_m=None)),
        ["Stable node in the sweep", "By the paper's formulae, over the stable range; deflection up to "],
    ),
    "nothing in the sweep": (
        lambda: Evidence(solved("inclined", sweep__to=0.62, device__length_m=None)),
        ["No admissible 1:1 motion in the sweep attracts", "Nowhere", "in the sweep of length from 0.59 m to 0.62 m"],
    ),
    "nothing in the sweep, and from rest": (
        lambda: nowhere_stable(sampled=[FromRest(Destination.OTHER_MOTION, "BBT", 1), FromRest(Destination.CHAOTIC)]),
        [
            "From rest, at 2 values in it: BBT every forcing period; chaotic, or not periodic within the budget.",
            "motions nearby; from rest, at 2 values in it: BBT",
            "By simulation, from rest, at 2 values in it: BBT every forcing period; chaotic, or not periodic within "
            "the budget. Alert VR001 says at which, what shows it, and what to do.",
        ],
    ),
    "nothing in the sweep, and from rest along it": (
        lambda: nowhere_stable(along=[FromRest(Destination.OTHER_MOTION, "B" * k + "T", 1) for k in range(2, 8)] * 2),
        [
            "from rest, at 201 values in it: BBT every forcing period; BBBT every",
            "BBBBBBT every forcing period; and others, 6 in all",
            "The [table of outcomes](disturbances) says where, and alert VR001 what to do.",
        ],
    ),
    "others in the sweep": (
        lambda: Evidence(solved("inclined", sweep__to=0.62, device__length_m=None), atlas=followed("BB")),
        ["Somewhere in the sweep the ball strikes only the bottom membrane, twice per forcing period", "Not 1:1"],
    ),
    "others at the design point": (
        lambda: Evidence(solved("inclined", **HERE), atlas=followed("BBT", "BTBT3", "T", 10 * "B" + "T")),
        [
            "No stable 1:1 motion in the sweep. At the design point s = 0.6 m: no stable 1:1 motion; the ball strikes "
            "the "
            "bottom membrane twice and the top once per forcing period (BBT), or the ball strikes each membrane twice "
            "in "
            "3 forcing periods (BTBT), or the ball strikes only the top membrane, once per forcing period, or",
            "the bottom membrane 10 times and the top once",
            "There the ball strikes",
        ],
    ),
    "others at the design point that are not reached from rest": (
        lambda: Evidence(
            solved("inclined", **HERE), atlas=followed("BBT"), disturbances=Disturbances(FromRest(Destination.CHAOTIC))
        ),
        [
            "once per forcing period (BBT); from rest the ball moves in a way that is chaotic, or not periodic within",
            "at s = 0.6 m; from rest the ball moves in a way that is chaotic",
            "die out (@figure-2). By simulation, from rest it moves in a way that is chaotic, or not periodic within",
        ],
    ),
    "many others": (
        lambda: Evidence(solved("inclined", **HERE), atlas=followed("BBT", "BTBT3", "T", "BTT", "BB")),
        ["once and the top twice per forcing period (BTT), or in other ways, 5 in all"],
    ),
    "an allowed motion": (
        lambda: Evidence(solved("inclined", **HERE), atlas=followed("BBT"), criteria=(required(True, "MOTION"),)),
        ["Are the requirements met? Yes 1 of 1: see the acceptance table"],
    ),
    "no motion at all": (
        lambda: Evidence(solved("inclined", device__length_m=0.1, sweep__from=0.08, sweep__to=0.15)),
        ["No admissible 1:1 motion at s = 0.1 m", "There is no stable 1:1 motion to evaluate it for"],
    ),
    "one point": (
        lambda: Evidence(solved("design-point")),
        [
            "Stable 1:1 motion: stable node at s = 0.7 m, F = 3 N, f = 2 Hz, β = 45°.",
            "One input varied at a time. Likewise",
        ],
    ),
    "a least shock": (
        lambda: withstood(shock=SHOCK),
        [
            "withstands bumps below 0.123 m/s",
            "Which bumps does it withstand? Below 0.123 m/s A jump of the relative velocity by that much towards the "
            "bottom, just after an impact at the bottom, leads to B~ every 3 forcing periods; of 9000 tried none "
            "smaller leads out: evidence, not proof",
        ],
    ),
    "shocks that are proved": (
        lambda: replace(withstood(shock=SHOCK), proved=thing(jump_m_s=0.1221)),
        ["out: evidence, not proof; proved of all up to 0.1221 m/s"],
    ),
    "reached from rest, as is proved": (
        lambda: replace(switched_on(), proved=thing(arrival=thing(proved=True))),
        ["Yes, after 17 periods Proved, for the ball pressed down when the force sets in"],
    ),
    "a later shock": (
        lambda: withstood(shock=thing(**vars(SHOCK) | {"sign": -1}), delay_s=0.0123, after_bottom=False),
        ["towards the top, 12.3 ms after an impact at the top, leads to"],
    ),
    "no shock leads out": (
        lambda: withstood(shock=SHOCK, jump_m_s=None),
        [
            "withstands all bumps tried, up to 1.5 m/s",
            "All tried, up to 1.5 m/s Of 9000 jumps",
            "none leads out: evidence, not proof",
        ],
    ),
    "a shock not known": (
        lambda: withstood(shock_unknown="the motion is too near"),
        ["which bumps it withstands is not known", "Which bumps does it withstand? Not known The motion is too near"],
    ),
    "jitter": (
        lambda: withstood(jitter=1, spread=1),
        ["How much does it jitter? 1.2° and 0.023 m/s Standard deviations", "with one of 0.012 m/s of the velocity"],
    ),
    "jitter of two sources": (
        lambda: withstood(jitter=1, spread=1, jitter_restitution=0.0123),
        ["just after each and one of 0.0123 of the restitution from impact to impact"],
    ),
    "jitter of the restitution": (
        lambda: withstood(jitter=1, spread=1, jitter_m_s=0.0, jitter_restitution=0.0123),
        ["at the impacts, with one of 0.0123 of the restitution from impact to impact"],
    ),
    "too much jitter": (
        lambda: withstood(jitter=1, jitter_unknown="the kicks are too large"),
        ["Not known The kicks are too large: figures are given up to one of 0.0036 m/s of the velocity"],
    ),
    "no jitter at all": (
        lambda: withstood(jitter=1, jitter_unknown="the kicks are too large", valid_up_to_m_s=0.0),
        ["there are figures for none, so near a critical point"],
    ),
    "reached from rest": (
        lambda: switched_on(recovery=Recovery(30.84, 15.42, 1e-9)),
        [
            "reached from rest after 17 periods; U_ave",
            "Yes, after 17 periods 1 % of a small disturbance is left after 30.8 periods (15.4 s)",
            "Switched on from rest, the device reaches this motion after 17 periods.",
        ],
    ),
    "reached from rest, at the very end of stability": (
        lambda: switched_on(no_recovery=NoRecovery.AT_EVENT),
        ["How long a small disturbance lasts is not known: within its error bound the motion is at"],
    ),
    "reached from rest, not known when": (
        lambda: switched_on(settles=None),
        ["reached from rest; U_ave", "Is it reached from rest? Yes", "reaches this motion. Along"],
    ),
    "around it, tried": (
        lambda: switched_on(nearby=nearby("==!=", "!60", "=65", "=70", "=75", "!80")),
        [
            "after 17 periods. The outcome from rest is the same from the 59 % of the switch-on moments that press the "
            "ball down and from 3 of 4 others tried, and at 3 values of s tried, 0.65 m to 0.75 m, but not at 0.6 m or "
            "0.8 m. Along the",
        ],
    ),
    "at one value beside it": (
        lambda: switched_on(nearby=nearby("==", "=69", "!70")),
        ["from 2 of 2 others tried, and at 1 value of s tried, 0.69 m, but not at 0.7 m. Along"],
    ),
    "nowhere beside it": (
        lambda: switched_on(nearby=nearby("!!", "!69", "?70")),
        ["from 0 of 2 others tried, but not at s = 0.69 m or 0.7 m (not settled soon). Along"],
    ),
    "only below a sweep": (lambda: switched_on(nearby=nearby("=", "=71")), ["and from 1 of 1 others tried. Along"]),
    "reached by a ramp": (
        lambda: switched_on(settles=1, ramp_periods=20.0, share=1.0),
        [
            "Yes, after 1 period With the amplitude ramped up over 20 periods; 1:1 motion is reached from 100 % of",
            "Switched on from rest, with the amplitude ramped up over 20 periods, "
            "the device reaches this motion after 1 period",
        ],
    ),
    "not reached from rest": (
        lambda: switched_on(Destination.REST_CYCLE, share=0.2247, ramp=Ramp(10, 80), window=LENGTH_WINDOW),
        [
            "not reached from rest: rest every 3 forcing periods (B~)",
            "No: rest every 3 forcing periods (B~) 1:1 motion is reached from "
            "22 % of the moments at which the force may set in; a ramp over 10 periods reaches it from every moment",
            "so it is for s from 0.6912 m to 0.75 m (the nearest change found)",
            "Switched on from rest, "
            "the device does not reach this motion:** it comes to rest every 3 forcing periods (B~).",
        ],
    ),
    "not stable, and from rest": (
        lambda: Evidence(solved("inclined", **HERE), disturbances=Disturbances(FromRest(Destination.CHAOTIC))),
        [
            "no stable 1:1 motion; from rest the ball moves in a way that is chaotic, or not periodic within",
            "By simulation, from rest it moves in a way that is chaotic, or not periodic within the budget; alert",
        ],
    ),
    "no ramp helps": (
        lambda: switched_on(Destination.CHAOTIC, None, ramp=Ramp(None, 80)),
        ["No ramp tried, up to 80 periods, reaches it from every moment"],
    ),
    "undecided from rest": (
        lambda: switched_on(Destination.UNDECIDED, None),
        [
            "not known whether it is reached from rest",
            "Not known A motion that rounding does not tell",
            "is not known: rounding decides it",
        ],
    ),
    "one unstable point": (
        lambda: Evidence(solved("design-point", device__length_m=0.5)),
        ["No stable 1:1 motion: 1 admissible 1:1 motion at s = 0.5 m, F = 3 N"],
    ),
    "two periods": (lambda: Evidence(solved("horizontal", period_ratio=3)), ["1:1 motion of 3 forcing periods"]),
    "handover": (
        lambda: Evidence(solved("horizontal")),
        [
            "below the design point; two asymmetric motions take over from the symmetric one; stable motion ends",
            "stable motion ends at f = 1.42 Hz (period doubling B1, 29 % below)",
            "from the symmetric one, with other flight times and voltages), 15 % away in frequency. No motion takes",
            "small disturbances spiral around it as they decay",
        ],
    ),
    "handover beyond a nearer end": (
        lambda: Evidence(solved("design-point", **TAKEN_OVER)),
        ["at f = 1.23 Hz (pitchfork C1, 34 % below) two asymmetric motions take over"],
    ),
    "handover above a nearer end": (
        lambda: Evidence(two_ends({"event": Event.FOLD, "distance": -1.0}, {**HANDOVER, "distance": 4.5})),
        ["(pitchfork, 10 % above) two asymmetric motions take over"],
    ),
    "grazing beyond a handover": (
        lambda: Evidence(two_ends(HANDOVER, {"event": Event.GRAZING, "name": "grazing", "distance": 9.0})),
        ["stable motion ends at β = 46.5° (grazing, 10 % above)", "a grazing point, 10 % away."],
    ),
    "handover without an end": (
        lambda: Evidence(
            with_end(
                solved("design-point"),
                relative=-0.1,
                event=Event.PITCHFORK,
                label="",
                name="pitchfork",
                distance=-4.5,
                ends_stability=False,
                taken_over=True,
            )
        ),
        [", and stable motion ends nowhere"],
    ),
    "mirror images": (
        lambda: Evidence(solved("horizontal", device__length_m=0.36)),
        [
            "the symmetric motion takes over from the asymmetric ones",
            "; two mirror images",
            "2 stable 1:1 motions coexist there, mirror images of each other",
        ],
    ),
    "two motions": (
        lambda: Evidence(solved("horizontal", inclination_deg=1.0, device__length_m=0.36)),
        ["; 2 stable motions coexist", "2 stable 1:1 motions coexist there."],
    ),
    "another beside": (
        lambda: Evidence(solved("inclined"), atlas=followed("BT", "BBT")),
        ["without oscillating about it); BBT is stable there too."],
    ),
    "others beside": (
        lambda: Evidence(solved("inclined"), atlas=followed("BBT", "BBBT")),
        ["; BBT, BBBT are stable there too."],
    ),
    "light ball": (
        lambda: Evidence(solved("inclined", device__ball_mass_kg=1e-7)),
        ["By the paper's formulae, at the design point; deflection up to 1.005 mm"],
    ),
    "no ball mass": (
        lambda: Evidence(solved("inclined", device__ball_mass_kg=None)),
        ["Not evaluated device.ball_mass_kg is not given"],
    ),
    "more energy than is lost": (
        lambda: Evidence(solved("inclined", **film(bias_voltage_v=6000.0))),
        [
            "Stable, but with more electrical energy than the impacts lose",
            " by the paper's formulae, more electrical energy than the impacts lose (efficiency ",
            " times as large. More electrical energy than the impacts lose (efficiency ",
            "**No device does this:** more electrical energy than the impacts lose (efficiency ",
            "; alert VR010 says what is open at its deflection of 3.0 times the membrane's radius.",
        ],
    ),
    "beyond breakdown": (
        lambda: Evidence(solved("inclined", **film(breakdown_field_v_m=1e7))),
        [
            "Stable, but above the breakdown field",
            " times as large. A field ",
            " times the breakdown field.",
            "**No device does this:** a field ",
        ],
    ),
    "a pair of voltages": (
        lambda: Evidence(solved("horizontal", inclination_deg=1.0, device__length_m=0.36)),
        ["What voltage? U_ave = 27.86 kV to 28.02 kV By the paper's formulae"],
    ),
    "a pair of valid voltages": (
        lambda: Evidence(solved("horizontal", inclination_deg=1.0, device__length_m=0.36, device__ball_mass_kg=1e-7)),
        ["U_ave = 29.79 V to 29.95 V"],
    ),
    "compliant": (
        lambda: compliant(),
        [
            "Stable 1:1 motion for 0.629 m < s",
            "margin 4.7 % (compliant 8.0 %) in frequency, to period doubling B1; B1 in s: rigid 0.629 m, compliant",
            "And with compliant membranes? B1 in s: rigid 0.629 m, compliant 0.582 m With their own stiffness contacts",
            "4.7 % away in frequency by the model of rigid impacts, and 8.0 % with the membranes' own stiffness.",
        ],
    ),
    "compliant, unstable": (
        lambda: compliant(motion=thing(stable=False, contact_share=0.02), margin_gone=True),
        [
            "The motion is not stable",
            "**With the membranes' own stiffness the motion is not stable.**",
            "rigid impacts, but",
        ],
    ),
    "compliant, no motion": (
        lambda: compliant(motion=None, absence=thing(missing="lost", reason="a: b"), margin_gone=True),
        ["The motion is lost A, b", "stiffness the motion is lost.**", "not stable with the membranes' own stiffness"],
    ),
    "compliant, not found": (
        lambda: compliant(motion=None, absence=thing(missing="not found", reason="at K: no root")),
        [
            "not known with the membranes' own stiffness",
            "not found with the membranes' own stiffness",
            "The motion is not found At K, no root",
            "stiffness the motion is not found.**",
        ],
    ),
    "compliant, unstable amid the sweep": (
        lambda: compliant(motion=thing(stable=False, contact_share=0.02)),
        ["not stable amid that range with the membranes' own stiffness"],
    ),
    "compliant, no ends": (
        lambda: compliant(swept_ends=(), ends=(), end_of=lambda *_: None),
        ["The motion stays stable", "Stable 1:1 motion for 0.629 m < s"],
    ),
    "compliant, a lost end": (
        lambda: compliant(compliant=None, compliant_margin=None, why=thing(missing="lost", reason="it falls back")),
        [
            "compliant lost",
            "margin 4.7 % (compliant lost)",
            "; with the membranes' own stiffness it is lost.",
            "of a period. B1 is lost: it falls back",
        ],
    ),
    "compliant, an end without a margin": (
        lambda: compliant(compliant_margin=None),
        ["margin 4.7 % (compliant not known)", "; with the membranes' own stiffness it is not known."],
    ),
    "compliant, two ends": (
        lambda: compliant(two=True),
        ["B1 in s: rigid 0.629 m, compliant 0.582 m; B1 in s: rigid 0.629 m"],
    ),
    "compliant, no margin": (
        lambda: compliant(compliant_margin=-0.01),
        ["margin 4.7 % (compliant −1 %)", "; with the membranes' own stiffness that margin is gone."],
    ),
    "unresolved": (
        lambda: Evidence(
            at_design(solved("inclined"), unresolved_inputs=(DesignInput.LENGTH, DesignInput.RESTITUTION))
        ),
        ["margin not known", "does not resolve where stable motion ends along length, restitution"],
    ),
    "endless": (
        lambda: Evidence(at_design(solved("inclined"), margins=())),
        ["no critical point near", "Stable motion ends nowhere along any input"],
    ),
    "an unlabelled end of grazing": (
        lambda: Evidence(with_end(solved("inclined"), event=Event.GRAZING, label="", distance=1.5, relative=None)),
        [
            "Its nearest end is a grazing point (beyond it the ball touches a membrane in another way), 1.5° away in "
            "inclination",
            "above the design point",
        ],
    ),
    "no range around": (
        lambda: Evidence(at_design(solved("design-point"), stable_ranges=())),
        ["Where is the 1:1 motion stable? Not known No stable range is resolved"],
    ),
    "proved": (
        lambda: Evidence(solved("inclined"), tolerances=tolerances(True)),
        ["stable for every device within the tolerances", "Yes It is proved for every one"],
    ),
    "refuted": (
        lambda: Evidence(solved("inclined"), tolerances=tolerances(False, object())),
        ["stable for 75 % of the devices within", "work? No 48 of 64 random devices", "(95 % interval 70 % to 80 %)"],
    ),
    "open": (lambda: Evidence(solved("inclined"), tolerances=tolerances(False)), ["work? Not decided 48 of 64"]),
    "sampled alone": (
        lambda: Evidence(solved("inclined"), tolerances=tolerances(False, provable=False, stable=64)),
        ["stable for all 64 random devices within", "Not decided 64 of 64", "; of a force with harmonics no proof"],
    ),
    "rigid": (
        lambda: Evidence(solved("inclined"), compliance=thing(grade=Grade.CARE)),
        ["Is the rigid model good enough? It is to be used with care See the section"],
    ),
    "requirements": (
        lambda: Evidence(solved("inclined"), criteria=(required(False), required(False), required(True, "SHAKER"))),
        [
            "2 of 3 requirements are not met: Margin (at least 5 %); Margin (at least 5 %). Stable",
            "Are the requirements met? No 1 of 3",
            "What must the shaker do? 2.46 g, stroke 305 mm Amplitudes of acceleration 24.1 m/s² and force 3 N",
            "not met: [Margin](requirement-margin_any_percent), [Margin](requirement-margin_any_percent). The ball",
        ],
    ),
    "a free capsule": (
        lambda: Evidence(solved("inclined", device__capsule="free"), criteria=(required(True, "SHAKER"),)),
        ["2.48 g, stroke at most 318 mm Largest acceleration between impacts 24.3 m/s², amplitude of the force 3 N"],
    ),
    "a force with harmonics": (
        lambda: Evidence(distorted(), criteria=(required(True, "SHAKER"),)),
        ["; a further second harmonic of 1.", "Largest acceleration 24.4 m/s², largest force 3.04 N"],
    ),
    "one requirement": (
        lambda: Evidence(solved("inclined"), criteria=(required(False),)),
        ["1 of 1 requirement is not met: Margin", "1 of 1 requirement is not met: [Margin]"],
    ),
    "simulated": (
        lambda: Evidence(solved("inclined"), check(orbits=1)),
        ["reached from 75 % of 20 starts (95 % interval 50 % to 90 %)", "Yes It ends on the one stable orbit tried"],
    ),
    "simulated along the sweep": (
        lambda: Evidence(solved("inclined"), check(values=[0, 1], elsewhere=check().others)),
        [
            "over the sweep reached from 75 %",
            "15 of 20 random starts (95 % interval 50 % to 90 %); the others: 40 % BBT, 30 % BTBT, 20 % chaos, others",
            "It ends on all 9 stable orbits tried",
            "Of 20 random starts, 75 % reach it; 20 % end in BBT, 15 % end in BTBT, 10 % end in chaos (B and T are",
        ],
    ),
    "contradicted": (
        lambda: Evidence(solved("inclined"), check(passed=False, misses=(1, 2), share=None)),
        [
            "Not verified: the simulation does not agree with the solution. Stable",
            "No It departs from 2 of 9 stable orbits; largest difference on the others 2 × 10⁻¹⁴",
            "**Not verified:** the simulation",
        ],
    ),
    "nothing to compare": (
        lambda: Evidence(solved("inclined", **HERE), check(orbits=0, values=[0, 1], share=None)),
        ["Nothing to compare There is no stable 1:1 motion at the values simulated; simulated starts over the sweep"],
    ),
    "nothing to compare at one value": (
        lambda: Evidence(solved("inclined", device__length_m=0.6), check(orbits=0, motions=check().others[:1])),
        [
            "; simulated starts end in motions other than 1:1: 100 % BBT",
            "Of 20 random starts at values where it is, 75 %",
        ],
    ),
}


def at_design(solution, **changed: object):
    return replace(solution, design=replace(solution.design, **changed))


def with_end(solution, **of: object):
    """A solution whose stable motion ends at one point only."""
    return at_design(solution, margins=(margin_with(of),))


def two_ends(*ends: dict[str, object]):
    """A solution of symmetric motions with two margins."""
    solution = solved("design-point", inclination_deg=0.0)
    return at_design(solution, margins=tuple(margin_with({"relative": 0.1, "label": ""} | end) for end in ends))


def margin_with(of: dict[str, object]) -> SimpleNamespace:
    end = {
        "parameter": DesignInput.INCLINATION,
        "point": thing(d=0.5),
        "ends_stability": True,
        "taken_over": False,
        "sweep_value": 46.5,
        "name": "grazing point",
    }
    return thing(**end | of)


@pytest.mark.parametrize("name", VERDICTS)
def test_a_verdict_is_worded(name: str, taken) -> None:
    make, parts = VERDICTS[name]
    verdict = verdict_of(make())
    worded = verdict.worded()
    facts = [f"{fact.question} {fact.answer} {fact.detail}" for fact in worded.facts]
    paragraphs = [said("verdict", "paragraph", verdict, picture) for picture in ("figure-2", "")]
    text = "\n".join([worded.word, worded.headline, *facts, *paragraphs])
    for part in parts:
        assert part in text
    assert worded.headline.endswith(".")
    assert worded.word == verdict.conclusion.word
    assert ("(@figure-2)" in text) == ("able for" in paragraphs[0] or "There the ball" in text or "Somewhere" in text)
    for text in (worded.headline, *facts, *paragraphs):
        assert not re.search(r" [ .,;]|\.\.|,,|\bnan\b|<|{", text.replace(" < ", " "))


LENGTH = Parameter.LENGTH
HELD = ["F = 3 N", "r = 0.5"]
ALONG = {
    "held": HELD,
    "range": "s from 0.5 m to 0.6 m",
    "swept": LENGTH,
    "ranges": [],
    "points": [],
    "extents": [],
    "mirrored": False,
    "level": False,
    "doubled": [],
    "from_rest": None,
    "unit_m_s": None,
    "largest": None,
    "ball_mass_kg": 0.0041,
    "bias_v": 2000.0,
    "simulated": None,
    "measured": "",
}
"""What figures 2, 4 and 7 show where there is nothing to be said."""

WITH_ALL = ALONG | {
    "doubled": ["BTBT"],
    "mirrored": True,
    "simulated": Circles(8, 1, False),
    "from_rest": Strip(0.862, 0),
}

SPEEDS = [Extent("speed", 0.5, 1.2345, where="bottom"), Extent("phase", 1e-9, 3.0, where="top")]
VALUES = [Extent("discriminant", -1.0, 2e9), Extent("eigenvalues", 0.5, 0.5)]
POINTS = [(thing(label=label, sweep_value=value), 6) for label, value in (("B1", 0.55), ("C1", 0.58))]
PERIODIC = {
    "panels": ["a", "b"],
    "setting": "s = 0.5 m",
    "motion": "BT, every forcing period",
    "lyapunov": None,
    "cycle": thing(residual=1e-13),
    "speeds": [0.5, 0.25],
    "phase": 1.5,
    "growth": 0.25,
}
CHAOTIC = {"panels": ["c", "d"], "setting": "s = 0.6 m", "motion": "chaotic", "cycle": None}
MOTIONS = {"held": HELD, "motions": [PERIODIC], "measured": 0}
SEEN = "points: measured"
FAMILIES = {"held": HELD, "swept": LENGTH, "simulated": False, "measured": "", "families": 3, "found": 3, "vertices": 2}
FAMILIES["stable"] = ["BT", "BBT"]
DIAGRAM = {"held": HELD, "swept": LENGTH, "simulated": 9, "groups": [], "still": []}
GROUPS = [
    {"word": "BT", "found": 3, "low": 0.5, "high": 0.55},
    {"word": "BBT", "found": 1, "low": 0.6, "high": 0.6},
]
END = thing(name="fold C1", parameter=DesignInput.FREQUENCY, sweep_value=1.9)
CYCLES = {
    "cycles": (("bottom", ElectricalCycle(1.5e-6, 2e3, 5e3)), ("top", ElectricalCycle(1.2e-6, 2e3, 6e3))),
    "bias_v": 2e3,
    "breakdown_v": 8e3,
}
ERRORS = {
    "panels": [("a", "error of the phase φ [rad]"), ("b", "relative error of |Ż| [–]")],
    "smallest": "10⁻¹⁷",
    "accuracy": "10⁻⁶",
    "methods": [
        ("RK4", [("the motion", "2 ms", 1e-9), ("B1", "", 1e-4)]),
        ("closed form", [("the motion", "1 µs", 1e-15)]),
    ],
}
STIFF = {"wrong": 0.01, "order": 0.2778, "failed": [], "exponents": []}

FIGURES: list[tuple[str, dict[str, object], str]] = [
    ("figure_2_caption", {**ALONG}, ". F = 3 N, r = 0.5; s from 0.5 m to 0.6 m."),
    (
        "figure_2_caption",
        {**WITH_ALL, "unit_m_s": 6.0241, "level": True},
        "; F/(2 M f) = 6.024 m/s; both impacts of a motion are equally fast; thin: motions that come of period "
        "doublings "
        "(BTBT); each asymmetric motion is drawn with its mirror image, in which bottom and top are "
        "exchanged; circles: 8 impacts of periodic motions at 1 "
        "value "
        "of the swept parameter, by simulation; strip: what switching on from rest leads to, 1:1 motion on 86 % of the "
        "sweep.",
    ),
    (
        "figure_4_caption",
        {**ALONG, "largest": 87.12, "mirrored": True},
        "|λ| reaches 87.1; mirror images share one",
    ),
    ("figure_4_caption", {**ALONG, "largest": 2e6}, "0.6 m; |λ| exceeds 10000."),
    ("figure_4_caption", ALONG, "the real part that they share where Δ < 0. F = 3 N"),
    ("figure_7_caption", ALONG, "; m = 4.1 g, U_in = 2 kV."),
    (
        "figure_7_caption",
        {**ALONG, "simulated": Circles(8, 2, True)},
        "circles: voltages of 8 impacts of periodic motions that a ball from rest comes to at 2 values of the swept",
    ),
    (
        "figure_2_alt",
        {**ALONG, "from_rest": Strip(13, 21)},
        "Strip: what switching on from rest leads to, 1:1 motion at 13 of 21 values.",
    ),
    (
        "figure_2_alt",
        ALONG,
        "Three line charts over s from 0.5 m to 0.6 m, empty: there is no admissible 1:1",
    ),
    (
        "figure_2_alt",
        {
            **ALONG,
            "extents": [(True, SPEEDS), (False, SPEEDS[:1])],
            "points": POINTS,
            "simulated": Circles(8, 2, False),
        },
        "0.6 m. There is no stable admissible 1:1 motion in the sweep. Stable motions: impact speed at the bottom 0.5 "
        "to "
        "1.23, phase at the top about 0 to 3. Unstable motions: impact speed at the bottom 0.5 to 1.23. Critical "
        "points, "
        "at s: B1 0.55 m; C1 0.58 m. Circles: 8 impacts of periodic motions at 2 values of the swept parameter, by",
    ),
    (
        "figure_4_alt",
        {**ALONG, "extents": [(True, VALUES)], "ranges": ["a < s", "s < b"]},
        "0.6 m. Stable 1:1 motion for a < s and for s < b. Stable motions: discriminant about 0 to more than 10000, "
        "eigenvalues or their real parts 0.5.",
    ),
    (
        "figure_7_alt",
        {**ALONG, "extents": [(True, [Extent("average", 1.0, 2e5, "V")])], "simulated": Circles(8, 2, False)},
        "Stable motions: average voltage about 0 to 200 kV. Circles: voltages of 8 impacts",
    ),
    ("figure_7_alt", {**ALONG, "extents": [(True, [Extent("average", 4.0, 4.0, "V")])]}, "average voltage 4 V."),
    ("figure_3_caption", MOTIONS, ", F = 3 N, r = 0.5. (a, b) s = 0.5 m: BT, every forcing period."),
    (
        "figure_6_caption",
        {"held": [], "motions": [PERIODIC, {**CHAOTIC, "lyapunov": None}], "measured": 0},
        "X without drift. (a, b) s = 0.5 m: BT, every forcing period; (c, d) s = 0.6 m: chaotic.",
    ),
    ("figure_portraits_caption", MOTIONS, "Solved motions over their period"),
    (
        "figure_3_alt",
        MOTIONS,
        "time series of 1 simulated motion. (a, b) s = 0.5 m: BT, every forcing period, |Ż| = 0.5, 0.25, φ = 1.5 rad, "
        "residual 1 × 10⁻¹³, largest |λ| = 0.25.",
    ),
    (
        "figure_6_alt",
        {"held": HELD, "motions": [{**PERIODIC, "growth": None}, {**CHAOTIC, "lyapunov": 0.1234}]},
        "of 2 simulated motions. (a, b) s = 0.5 m: BT, every forcing period, |Ż| = 0.5, 0.25, φ = 1.5 rad, residual "
        "1 × 10⁻¹³; (c, d) s = 0.6 m: chaotic, Lyapunov exponent 0.123 per forcing period.",
    ),
    (
        "figure_portraits_alt",
        {"held": HELD, "motions": [{**PERIODIC, "speeds": [0.1 * k for k in range(1, 9)]}]},
        "path of 1 motion. (a, b) s = 0.5 m: BT, every forcing period, 8 impacts, |Ż| from 0.1 to 0.8, φ = 1.5",
    ),
    ("figure_diagram_caption", DIAGRAM, "F = 3 N, r = 0.5. 9 values of the swept parameter were simulated."),
    ("figure_diagram_alt", DIAGRAM, "over the length, by simulation. No motion was found that has impacts."),
    (
        "figure_diagram_alt",
        {**DIAGRAM, "groups": GROUPS, "still": ["at rest", "sticking"]},
        "Motions at 9 values: BT at 3 (s = 0.5 to 0.55 m); BBT at 1 (s = 0.6 m); from some starts the ball ends at "
        "rest, or "
        "sticking, which has no impacts.",
    ),
    (
        "figure_diagram_alt",
        {**DIAGRAM, "simulated": 1, "groups": GROUPS[1:]},
        "Motions at 1 value: BBT at 1 (s = 0.6",
    ),
    (
        "figure_hysteresis_caption",
        {"held": HELD, "swept": LENGTH, "jumps": 0, "loops": [], "measured": ""},
        "r = 0.5. No jumps.",
    ),
    (
        "figure_hysteresis_caption",
        {"held": HELD, "swept": LENGTH, "jumps": 0, "loops": [], "measured": SEEN},
        "light bands: hysteresis; points: measured; F = 3 N",
    ),
    ("figure_atlas_caption", FAMILIES | {"measured": SEEN}, "comes or goes; points: measured; F = 3 N"),
    ("figure_2_caption", ALONG | {"measured": SEEN}, "; points: measured."),
    ("figure_4_caption", ALONG | {"measured": SEEN}, "; points: measured."),
    ("figure_2_alt", ALONG | {"measured": SEEN}, " Points: measured."),
    ("figure_4_alt", ALONG | {"measured": SEEN}, " Points: measured."),
    ("figure_3_caption", MOTIONS | {"measured": 1}, "r = 0.5; diamonds: measured impacts, with 95 % error bars."),
    (
        "figure_hysteresis_alt",
        {"swept": LENGTH, "jumps": 1, "loops": [thing(low=0.2, high=0.3), thing(low=0.4, high=0.5)]},
        "over the length. 1 jump; the motion depends on the direction at s = 0.2 to 0.3 m; s = 0.4 to 0.5 m.",
    ),
    ("figure_atlas_caption", FAMILIES, "comes or goes; F = 3 N, r = 0.5."),
    (
        "figure_atlas_caption",
        {**FAMILIES, "simulated": True},
        "; light discs: periodic motions that the simulation fo",
    ),
    (
        "figure_atlas_caption",
        {**FAMILIES, "found": 30},
        "r = 0.5. Drawn are 3 of 30 families, first those with stable motions that a device can be set to, then",
    ),
    ("figure_ladder_caption", {**FAMILIES, "found": 30}, "Drawn are 3 of 30 families"),
    ("figure_atlas_alt", FAMILIES, "3 families that meet at 2 points; stable motions are BT, BBT."),
    ("figure_atlas_alt", {**FAMILIES, "stable": []}, "2 points; none is stable."),
    ("figure_ladder_caption", FAMILIES, "by the word of the motion. F = 3 N, r = 0.5."),
    ("figure_ladder_alt", {**FAMILIES, "best": None}, "voltage and impacts over the length."),
    (
        "figure_ladder_alt",
        {"swept": LENGTH, "best": thing(word=Word.of("BBT"), per_second_v=1234.0)},
        "the length. BBT generates most, up to 1.234 kV/s.",
    ),
    ("figure_device_caption", {"motion": "", "other": False}, "between its membranes, not to scale across."),
    ("figure_device_caption", {"motion": "stable node", "other": False}, "membrane in one period: stable node."),
    ("figure_device_caption", {"motion": "BBT", "other": True}, "membrane in one period: the stable motion BBT."),
    ("figure_device_alt", {"dimensions": HELD, "motion": ""}, "between two membranes: F = 3 N, r = 0.5."),
    (
        "figure_device_alt",
        {"dimensions": HELD, "motion": "BT", "at_top": [0.25, 0.5]},
        "r = 0.5. Line chart of the ball's distance from the bottom over one period: it meets the top after 0.25 and "
        "0.5 of it.",
    ),
    ("figure_device_alt", {"dimensions": HELD, "motion": "B", "at_top": []}, "period: it does not meet the top."),
    (
        "figure_margins_caption",
        {"end": END, "digits": 2},
        "The nearest end of stable motion is the fold C1 at f = 1.9 Hz. The bars",
    ),
    (
        "figure_margins_alt",
        {"end": END, "shifts": [(LENGTH, 0.5), (Parameter.AMPLITUDE, -0.25)]},
        "moves the fold C1 in frequency by: length 0.5 %, force amplitude −0.25 %.",
    ),
    (
        "figure_shocks_caption",
        {
            "motion": "BBT",
            "points": 257,
            "returned": 0.9972,
            "largest_m_s": 2.448,
            "least_m_s": 1.224,
            "manifold": True,
        },
        "by up to 2.45 m/s in the motion BBT, at 257 moments of the period and of 257 sizes; positive is towards the "
        "bottom. 99.7 % of them return to the motion. The least that leads out, 1.22 m/s, is marked. Shocks on the "
        "line lead onto",
    ),
    (
        "figure_shocks_caption",
        {"motion": "BT", "points": 257, "returned": 1.0, "largest_m_s": 2.448, "least_m_s": None, "manifold": False},
        "100 % of them return to the motion.",
    ),
    (
        "figure_shocks_alt",
        {"outcomes": [("BT every forcing period", 0.75), ("aperiodic", 0.0), ("rest", 0.25)]},
        "coloured by outcome: BT every forcing period 75 %; rest 25 %.",
    ),
    (
        "figure_basin_caption",
        {"fastest_m_s": 13.81, "points": 257, "marked": True},
        "just before it, up to 13.8 m/s; 257 × 257 points. Dots: the impacts of the stable motions.",
    ),
    ("figure_basin_caption", {"fastest_m_s": 13.81, "points": 257, "marked": False}, "up to 13.8 m/s; 257 × 257"),
    (
        "figure_basin_alt",
        {"shares": [("BT every forcing period", 0.853, 0.84, 0.86), ("rest", 0.147, 0.14, 0.16)]},
        "coloured by outcome: BT every forcing period 85 %; rest 15 %.",
    ),
    (
        "figure_cycle_caption",
        CYCLES,
        "up to the bias of 2 kV, isolated until it is flat again, and discharged. The area is the electrical energy "
        "that the impact gains, an upper bound as nothing leaks and no load is fed; the membrane breaks down at 8 kV.",
    ),
    (
        "figure_cycle_alt",
        CYCLES,
        "Impact on the bottom: 1.5 µC isolated from 2 kV to 5 kV, area 2.25 mJ; Impact on the top: 1.2 µC isolated "
        "from 2 kV to 6 kV, area 2.4 mJ.",
    ),
    (
        "figure_driven_caption",
        {"impacts": 1080, "every": 1, "share": 0.9875, "predicted": True},
        "98.75 % of the periods have one impact on each membrane. Lines: the speeds of the periodic motion under that "
        "sine.",
    ),
    (
        "figure_driven_caption",
        {"impacts": 20001, "every": 3, "share": 0.5, "predicted": False},
        "50 % of the periods have one impact on each membrane. Of 20001 impacts one in 3 is drawn.",
    ),
    ("figure_driven_alt", {"impacts": 1080}, "of the relative speed and of the phase of 1080 impacts on the bottom"),
    (
        "figure_accuracy_caption",
        ERRORS,
        "(a) error of the phase φ [rad], (b) relative error of |Ż| [–]; down and to the left is better.",
    ),
    (
        "figure_accuracy_alt",
        ERRORS,
        "2 line charts of error over run time, both logarithmic. RK4: the motion 2 ms to 10⁻⁶, least error 1 × 10⁻⁹; "
        "B1 not "
        "to 10⁻⁶, least error 0.0001. closed form: the motion 1 µs to 10⁻⁶, least error 1 × 10⁻¹⁵.",
    ),
    ("figure_stiffness_caption", STIFF, "exceeds 0.01 and at the top"),
    ("figure_stiffness_caption", STIFF, "the slope expected, −0.278 (dashed); no exponent could be fitted."),
    (
        "figure_stiffness_alt",
        {**STIFF, "failed": ["RK4", "DOP853"], "exponents": [("velocity", -0.277), ("B1", -0.28)]},
        "Some runs of RK4, DOP853 failed. Fitted exponents: velocity −0.277, B1 −0.28.",
    ),
    ("figure_stiffness_alt", STIFF, "No run failed. No exponent could be fitted."),
]


def of_figure(macro: str, *given: object) -> str:
    return said(f"figures/{FILES[Task(macro.rpartition('_')[0].replace('_', '-'))]}", macro, *given)


@pytest.mark.parametrize(("macro", "x", "part"), FIGURES, ids=[f"{macro}-{k}" for k, (macro, *_) in enumerate(FIGURES)])
def test_a_figure_is_worded(macro: str, x: dict[str, object], part: str, taken) -> None:
    assert part in of_figure(macro, x)
    assert of_figure(f"{macro.rpartition('_')[0]}_title")


B1 = thing(label="B1", event=Event.PERIOD_DOUBLING)
ORBIT = thing(longest_contact=0.0418, stable=True)
SHARES = thing(name="BT", fastest=1.9, share=0.684021, switch_on=0.933349)
OWN = thing(orbit=ORBIT, critical_value=0.58, reason="")


def compared(name: str, shift: float, *, of_margin: bool = False, moved: float | None = -0.1) -> SimpleNamespace:
    return thing(criterion=thing(name=name, shift=shift), of_margin=of_margin, shift=moved)


def comparison(**of: object) -> SimpleNamespace:
    return thing(**{"own": OWN, "critical": B1, "grade": Grade.GOOD, "reason": "there is no ball"} | of)


def point(label: str, **of: object) -> SimpleNamespace:
    return thing(**{"label": label, "proved": True, "bound_holds": True, "mirror_proved": None, "beyond": ()} | of)


def points(*of: SimpleNamespace) -> tuple[list[SimpleNamespace]]:
    return (list(of),)


def record(**of: object) -> SimpleNamespace:
    """A record that shows no motion, but for what is said of it."""
    known = {"unfit": None, "left_open": None, "shown": None, "motion": None, "referenced": False, "impacts": 9}
    return thing(**known | of)


PLANE = thing(inputs=(DesignInput.INCLINATION, DesignInput.LENGTH), low=(0.0, 0.3), high=(90.0, 1.0), swept=True)
UNSWEPT = thing(inputs=PLANE.inputs, low=PLANE.low, high=PLANE.high, swept=False)
BT, BTBT = (2, "BT", 1, False), (4, "BTBT", 2, False)
ENDS = {
    0: thing(value=51.6, distance=6.6, relative=0.147, event=Event.PERIOD_DOUBLING, taken_over=False),
    1: thing(value=0.629, distance=-0.0639, relative=-0.0922, event=Event.PITCHFORK, taken_over=True),
}


def charted(
    motions: object = (BT,), ends: dict[int, object] = ENDS, near: bool = False, **of: object
) -> dict[str, object]:
    """What the words of a chart are told by, of motions that are stable at its design point."""
    stable = None if motions is None else [thing(kind=kind, one_to_one=kind[1] == "BT") for kind in motions]
    design = thing(inputs=(45.0, 0.6934), motions=stable, nearest=ends.get)
    known = {
        "plane": PLANE,
        "limits": Limits(4, 2),
        "loci": [0, 0],
        "meetings": [0],
        "design": design,
        "not_followed": 0,
    }
    sets = [thing(kinds=(BT,), share=0.5), thing(kinds=(BT, BTBT), share=0.2), thing(kinds=(), share=0.3)]
    named = Naming(frozenset({("BBT", False)}), Words("chart"))
    return {"chart": thing(**known | of), "sets": sets, "named": named, "near": near, "run": None}


BAND = {"word": "BBT", "varied": 0, "least": 1e-5, "most": 0.08, "settable": True}
CHARTED = [
    ("motion", ("BT", 1, True), "asymmetric BT (T)"),
    ("motion", ("BBT", 2, False), "BBT (2T)"),
    ("motion", ("BBT", 0, False), "BBT"),
    ("stable", (None,), "not resolved"),
    ("stable", ([],), "none"),
    ("stable", (["BT", "BBT"],), "BT, BBT"),
    ("stable_meaning", (None, Limits(4, 2)), "not resolved by rounding"),
    ("stable_meaning", ([], Limits(4, 1)), "no stable motion of up to 4 impacts in one forcing period"),
    ("stable_meaning", ([], Limits(4, 2)), "no stable motion of up to 4 impacts in 2 forcing periods"),
    ("stable_meaning", ([("BT", "BT", 1)], Limits(4, 2)), "BT (1:1)"),
    ("stable_meaning", ([("BT", "BT", 1), ("BBT", "BBT", 1)], Limits(4, 2)), "BT and BBT"),
    ("others", (True,), "others, see the table of regions"),
    ("others", (False,), "other motions"),
    ("meeting", (True,), "numbered: point of the table"),
    ("meeting", (False,), "where curves meet, end or turn"),
    ("narrow_note", ([], [], PLANE.inputs), ""),
    ("narrow_note", ([thing(**BAND)], [], PLANE.inputs), "to 0.08° wide in inclination."),
    ("narrow_note", ([thing(**BAND), thing(**BAND | {"least": 0.08})], ["BB"], PLANE.inputs), "; BBT, 0.08° wide in"),
    ("narrow_note", ([thing(**BAND | {"settable": False})], ["BB", "B"], PLANE.inputs), "set; BB, B, of widths not"),
    ("caption", (charted(),), "Chart of length against inclination: the words of the motions that are stable in each"),
    ("caption", (charted(plane=UNSWEPT, loci=[0], meetings=[0, 0]),), ", of 1:1 motions alone: the words of"),
    ("caption", (charted() | {"named": Naming(frozenset(), Words("chart"))},), "one at the top), of up to"),
    ("found", (charted()["chart"],), "Over inclination from 0 to 90° and length from 0.3 to 1 m: 2 curves and 1 point"),
    ("found", (charted(plane=UNSWEPT, not_followed=1)["chart"],), "neither cross a line that was followed"),
    ("found", (charted(not_followed=2)["chart"],), "2 ends of curves could not be followed further."),
    ("alt", (charted(),), "BT (1:1) in 50 % of it; BT and BTBT in 20 % of it; no stable motion of up to 4 impacts"),
    ("alt", (charted(design=None),), "in 2 forcing periods in 30 % of it."),
    ("word", (charted(design=None),), "No design point in the chart"),
    ("word", (charted(None),), "Not resolved"),
    ("word", (charted(()),), "Not stable"),
    ("word", (charted((BTBT,)),), "Stable, but not 1:1"),
    ("word", (charted(near=True),), "Stable, margin small"),
    ("word", (charted(),), "Stable"),
    ("word", (charted() | {"run": WordedVerdict(Status.CAUTION, "Stable, but amber", "It is.")},), "Stable, but amber"),
    ("word", (charted() | {"run": WordedVerdict(Status.GOOD, "Stable", "It is.")},), "Stable"),
    ("run", ({"run": WordedVerdict(Status.GOOD, "Stable", "It is.")},), "A run of it says: It is."),
    ("headline", (charted(design=None),), "no design point in the chart. BT (1:1) is stable in 50 % of it; BT and"),
    ("headline", (charted(design=None) | {"sets": charted()["sets"][2:]},), "No stable motion of up to 4 impacts in 2"),
    ("headline", (charted(None),), "rounding does not resolve the motions."),
    ("headline", (charted(()),), "no motion of up to 4 impacts in 2 forcing periods is stable."),
    ("headline", (charted(),), "In inclination BT ends at 51.6° (period doubling), a margin of +6.6° or +15 %."),
    (
        "headline",
        (charted(),),
        "In length BT hands its stability over at 0.629 m (pitchfork), a margin of −0.0639 m or",
    ),
    ("headline", (charted((BT, BTBT), {}),), "BT, BTBT are stable. In inclination no end of BT was found."),
    ("headline", (charted(ends={0: thing(**vars(ENDS[0]) | {"relative": None})}),), "a margin of +6.6°. In length"),
    ("end", (Event.SWEEP_END,), "edge of the chart"),
    ("end", (Event.CLOSED,), "closed"),
    ("end", (Event.CUSP,), "cusp"),
]
"""What is said of charts, by macro."""

MAP = thing(
    named=(AxisName("inclination", "β", "°"), AxisName("length", "s", "m")), ends=((0, 90), (0.2, 0.9)), shape=(60, 80)
)
CELLS = thing(cells=4800, stable=2093, with_motion=4730, missed=240, outside=946)
MAPPED = {"plan": MAP, "held": ["F = 3 N", "r = 0.5"], "found": CELLS, "marked": thing(), "curves": True}
MAPPED |= {"outcomes": [("1:1", 3600), ("chaotic", 1200)]}
ON_MAPS = [
    ("title", ("map-shock",), "Least shock"),
    ("heading", ("map-stability",), "Stability of the 1:1 motion; hatched: no 1:1 motion"),
    ("heading", ("map-margin",), "Stability margin: 0 % where a multiplier reaches 1 or −1; hatched: no 1:1 motion"),
    (
        "heading",
        ("map-voltage",),
        "Average voltage; generated at an impact, by the paper's formulae; hatched: no 1:1 motion",
    ),
    ("heading", ("map-from-rest",), "What the device comes to that is switched on from rest"),
    (
        "heading",
        ("map-shock",),
        "Least shock; the least jump of the velocity found that leads out of the stable",
    ),
    ("curves", (), "where any of the 1:1 motions changes or ends"),
    ("design_margins", (), "design point with its margins"),
    ("missed", (CELLS,), "not reached from rest at 5 % of the cells"),
    (
        "caption",
        ("map-stability", MAPPED),
        "Length against inclination; hatched: no 1:1 motion. 60 × 80 cells, with F",
    ),
    ("caption", ("map-stability", MAPPED), "beside a stable one. Cross: the design point, with its margins."),
    (
        "caption",
        ("map-from-rest", MAPPED | {"marked": None, "curves": False}),
        "comes to. 60 × 80 cells, with F = 3 N, r = 0.5.",
    ),
    (
        "alt",
        ("map-margin", MAPPED),
        "over inclination from 0 to 90° and length from 0.2 to 0.9 m. Stability",
    ),
    (
        "alt",
        ("map-margin", MAPPED),
        "4,800 cells (inclination × length): 43.6 % with a stable 1:1 motion, 54.9 % with",
    ),
    ("alt", ("map-from-rest", MAPPED), "from rest. 1:1: 75 %, chaotic: 25 %."),
    ("word", (), "No design point"),
    ("headline", (MAP, CELLS), "1.46 % with none. For a verdict, give"),
    ("place", (MAP, (45.0, 0.7)), "β = 45°, s = 0.7 m"),
    ("quantity", ("least_jump_m_s",), "least shock"),
    ("value", ("multiplier_margin", 0.5234), "52.34 %"),
    ("value", ("u_ave_v", 52690.0), "52.69 kV"),
    ("value", ("least_jump_m_s", 0.12345), "123.5 mm/s"),
    ("signed", (-0.0705, MAP.named[1]), "−0.0705 m"),
    ("signed", (7.37, MAP.named[0]), "+7.37°"),
]
"""What is said of maps, by macro."""

SAID: list[tuple[str, str, tuple[object, ...], str]] = [
    *(("chart", *row) for row in CHARTED),
    *(("map", *row) for row in ON_MAPS),
    ("accuracy", "task", ("orbit", None), "the motion"),
    ("verdict", "from_rest", (FromRest(Destination.OTHER_MOTION, "BBT", 1),), "; from rest the ball comes to BBT"),
    ("verdict", "comes_to", (FromRest(Destination.CHAOTIC),), "moves in a way that is chaotic, or not periodic"),
    ("accuracy", "task", ("critical", B1), "B1 (period doubling)"),
    (
        "proofs",
        "arrival",
        (thing(proved=True, name="BT every forcing period", bits=512, impacts=33),),
        "reaches BT every forcing period. Ball arithmetic of 512 bits encloses 33 impacts, up to a region in which",
    ),
    ("proofs", "arrival", (thing(proved=False, reason="the ball rests"),), "is reached from rest. The ball rests."),
    (
        "proofs",
        "sections",
        (thing(velocity_unit=6.0, sections=[SHARES, SHARES]),),
        "up to 11.4 m/s, at least 68.4 % lead to BT; so does switching on from rest at 93.3 % or more of all",
    ),
    ("proofs", "sections", (thing(sections=[]),), "Not proved: that any share of all impacts"),
    ("proofs", "shocks", (thing(jump_m_s=1.224, cells=844),), "dies out (844 cells of moments and jumps are enclosed)"),
    ("proofs", "shocks", (thing(jump_m_s=None, unproved=""),), "The smallest jumps remain open."),
    ("proofs", "shocks", (thing(jump_m_s=None, unproved="no motion"),), "that the motion survives. No motion."),
    ("accuracy", "task", ("critical", None), "the critical point"),
    ("accuracy", "busy", (0.3456,), "The machine was busy: half of the repeats of a run are spread over 35 % of their"),
    ("accuracy", "short_task", ("orbit", None), "motion"),
    ("accuracy", "short_task", ("critical", B1), "B1"),
    ("accuracy", "short_task", ("critical", None), "critical point"),
    ("accuracy", "quantity", ("voltage", None, None), "U_ave [V]"),
    ("accuracy", "quantity", ("critical", B1, LENGTH), "B1, s [m]"),
    ("accuracy", "head", ("error", "phase"), "Error, phase"),
    ("accuracy", "fastest_head", ("motion", "10⁻⁶"), "motion to 10⁻⁶"),
    ("accuracy", "fitted_over", ("10", "100", 5), "10 to 100 (5 runs)"),
    ("accuracy", "failures", (0, 5), "none"),
    ("accuracy", "failures", (2, 5), "2 of 5"),
    ("accuracy", "settings", ("10", "10"), "10"),
    ("accuracy", "settings", ("10", "30"), "10 to 30"),
    ("accuracy", "not_tried", (), "not tried"),
    ("accuracy", "not_tried", ("needs numba",), "not tried: needs numba"),
    ("certificates", "between", (None,), "undecided"),
    ("certificates", "nothing", (), "no critical points to prove"),
    ("certificates", "unproved", (thing(reason="it is degenerate"),), "not proved: it is degenerate"),
    (
        "certificates",
        "notes",
        (thing(radius=1e-10, side="stable above", admissible=True),),
        "within 1e-10, stable above",
    ),
    (
        "certificates",
        "notes",
        (thing(radius=1e-10, side="", admissible=False),),
        "alone within 1e-10, ball between the membranes: no, proved",
    ),
    ("certificates", "summary", points(), "0 of 0 critical points proved."),
    (
        "certificates",
        "summary",
        points(point("B1")),
        "1 of 1 critical point proved, each within the error bound that is stated for it.",
    ),
    ("certificates", "summary", points(point("B1", proved=False)), "0 of 1 critical point proved."),
    (
        "certificates",
        "summary",
        points(point("B1", bound_holds=False, mirror_proved=False), point("C1", mirror_proved=True, beyond=("d", "q"))),
        "2 of 2 critical points proved, but the error bound stated is not proved to hold for B1; the mirror image is "
        "not "
        "proved for B1; error bounds stated for other numbers are not proved for C1 (d, q).",
    ),
    (
        "certificates",
        "summary",
        points(point("B1", beyond=("d",)), point("C1", beyond=("q",))),
        "stated for it; error bounds stated for other numbers are not proved for B1 (d), C1 (q).",
    ),
    ("effects", "effect", (shift("RESTITUTION_BOTTOM"), FIXED), "restitution at the bottom −5 %"),
    ("effects", "effect", (shift("RESTITUTION_TOP"), FIXED), "restitution at the top −5 %"),
    ("effects", "effect", (shift("CAPSULE"), FIXED), "capsule free instead of prescribed"),
    ("effects", "effect", (shift("CAPSULE"), FREE), "capsule prescribed instead of free"),
    (
        "effects",
        "effect",
        (shift("FRICTION", size=0.05), thing(recoils=False, harmonics=(), friction=0.0)),
        "friction of 0.05 between ball and capsule",
    ),
    (
        "effects",
        "effect",
        (shift("FRICTION", size=0.05), thing(recoils=False, harmonics=(), friction=0.1)),
        "more friction of 0.05 between ball and capsule",
    ),
    ("effects", "effect", (shift("SECOND_HARMONIC", size=0.02), FREE), "a second harmonic of 2 % in the force"),
    (
        "effects",
        "effect",
        (shift("SECOND_HARMONIC", size=0.02), thing(recoils=False, harmonics=(thing(),))),
        "a further second harmonic of 2 % in the force",
    ),
    (
        "effects",
        "effect",
        (shift("RESTITUTION_SPEED", size=-0.1), FREE),
        "restitution as the speed to the power −0.1",
    ),
    (
        "effects",
        "effect",
        (shift("RESTITUTION_SPEED", size=-0.12, speed_m_s=5.0), FREE),
        "restitution as the speed to the power −0.12, as given at 5 m/s",
    ),
    ("effects", "effect", (shift("STIFFNESS"), FREE), "the membranes' own stiffness"),
    ("effects", "left", (shift(left=-0.0317),), "−3.2 %"),
    ("effects", "left", (shift(left=None),), "no end"),
    ("effects", "left", (shift(left=None, absence=Unmoved.NOT_FOLLOWED),), "not followed to its end"),
    ("effects", "left", (shift(left=None, stable=False),), "no stable motion"),
    (
        "effects",
        "left",
        (shift("FRICTION", left=None, stable=False, known=False),),
        "not known: the ball stops on its way",
    ),
    (
        "effects",
        "answer",
        (shift("CAPSULE", left=0.0324), FIXED),
        "Capsule free instead of prescribed: 3.2 % left",
    ),
    ("effects", "answer", (shift(left=None), FIXED), "Restitution at the bottom −5 %: no end"),
    ("effects", "answer", (shift(left=-0.1, stable=False), FIXED), "Restitution at the bottom −5 %: not stable"),
    (
        "effects",
        "detail",
        (shift(relative=0.0391), thing(end=thing(parameter=Parameter.FREQUENCY, relative=-0.0472))),
        "The worst of the neglected effects; the end moves by +3.9 %; without it 4.7 % in frequency",
    ),
    (
        "effects",
        "detail",
        (shift(relative=None), thing(end=thing(parameter=Parameter.FREQUENCY, relative=-0.0472))),
        "The worst of the neglected effects; without it 4.7 % in frequency",
    ),
    ("compliant", "head", ("critical",), "critical point"),
    ("compliant", "head", ("critical", "B1"), "B1"),
    ("compliant", "quantity", ("phase", "rad"), "Phase [rad]"),
    ("compliant", "quantity", ("restitution", ""), "Restitution"),
    ("compliant", "what_is_lost", ("B1",), "B1"),
    ("compliant", "what_is_lost", ("",), "the motion"),
    ("compliant", "why", ("lost at 5: no root: none",), "lost at 5 (no root, none)"),
    ("compliant", "why", ("lost",), "lost"),
    (
        "compliant",
        "verdict",
        (comparison(own=None), []),
        "Rigid and compliant membranes were not compared: there is no ball.",
    ),
    (
        "compliant",
        "verdict",
        (comparison(own=thing(orbit=None, reason="lost: no root")), []),
        "The rigid model is not good enough here: on the compliant membranes the motion is lost (no root).",
    ),
    (
        "compliant",
        "verdict",
        (comparison(own=thing(orbit=thing(stable=False))), []),
        "The rigid model is not good enough here: on the compliant membranes the motion is no longer stable.",
    ),
    (
        "compliant",
        "verdict",
        (comparison(own=thing(orbit=ORBIT, critical_value=None, reason="lost")), []),
        "Contacts last up to 2.1 % of the forcing period. The rigid model is not good enough here: followed from stiff "
        "membranes to softer ones, B1 is lost.",
    ),
    (
        "compliant",
        "verdict",
        (comparison(), []),
        "period. The rigid model is good enough here by all criteria.",
    ),
    ("compliant", "verdict", (comparison(critical=None, grade=None), []), "The rigid model is good enough here by all"),
    (
        "compliant",
        "verdict",
        (
            comparison(grade=Grade.INSUFFICIENT),
            [
                compared("U_ave", 0.25),
                compared("B1", -0.6, of_margin=True),
                compared("B1", 2.46, of_margin=True, moved=0.1),
            ],
        ),
        "The rigid model is not good enough here: U_ave shifts by +25 %; B1 moves by 60 % of the margin to it, towards "
        "the "
        "motion; B1 moves by 2.5 times the margin to it, away from the motion.",
    ),
]


def explained(unknown: Unknown | None = None, others: tuple[Unknown, ...] = ()) -> BetterFit:
    return BetterFit(unknown is None, unknown, 0.42, 1e-5, 1e-4, others)


def misfit(accepted: bool = False, **of: object) -> SimpleNamespace:
    usual = {"p_value": 0.5, "failure": None, "alternative": None, "explanation": None} | of
    return thing(accepted=accepted, **usual)


BOTH = (Unknown.RESTITUTION_BOTTOM, 0.01), (Unknown.LENGTH, -0.02)
SAID += [
    (
        "measured",
        "points",
        (MeasuredShown(3, ("BT", "BBT"), 1, True),),
        "at 3 values of the swept parameter, upwards",
    ),
    ("measured", "points", (MeasuredShown(1, (), 0, False),), "measured at 1 value of the swept parameter"),
    (
        "measured",
        "reason",
        (record(unfit=NoFit(Unfit.SCATTER, 0.02)),),
        "a timing error of 20 ms would be needed; v",
    ),
    (
        "measured",
        "reason",
        (record(unfit=NoFit(Unfit.RESTITUTION, 1.2)),),
        "a restitution of 1.2 would be needed; v",
    ),
    ("measured", "reason", (record(unfit=NoFit(Unfit.GAPS, 0.2)),), "too many are missed: 20 % of the flights fit no"),
    ("measured", "reason", (record(unfit=NoFit(Unfit.PATH, 0.2)),), "the impacts do not follow this device; vireport"),
    ("measured", "reason", (record(),), "no word: it does not repeat, or has not settled"),
    ("measured", "reason", (record(left_open=Open(impacts=12)),), "too short: 9 impacts, and at least 12 are needed"),
    ("measured", "reason", (record(left_open=Open(), referenced=True),), "several motions of this device explain it"),
    ("measured", "reason", (record(left_open=Open()),), "does not tell the phase of the force (give force_maximum_s)"),
    ("measured", "remarks", (record(),), "the phase of the force was fitted"),
    (
        "measured",
        "remarks",
        (record(shown=thing(missed=7, false=1), motion=thing(from_s=5.549), referenced=True),),
        "7 missed, 1 false, settled from 5.55 s",
    ),
    ("measured", "remarks", (record(shown=thing(missed=0, false=0), referenced=True),), ""),
    ("identify", "refused", (Open(impacts=12), True), "at least 12 impacts are needed"),
    ("identify", "refused", (Open(combination=BOTH), True), "at the bottom +0.01, length −0.02 m together change no"),
    ("identify", "refused", (Open(answers=(BOTH, BOTH)), False), "2 devices explain these impacts equally well: "),
    (
        "identify",
        "refused",
        (Open(unstable=True), True),
        "no device stays on one. What would help: reference the clock",
    ),
    ("identify", "refused", (Open(), False), "What would help: tap the device"),
    ("identify", "reason", (misfit(True, p_value=None),), "these impacts leave nothing over with which to test"),
    ("identify", "reason", (misfit(True),), "no test rejects the model"),
    ("identify", "reason", (misfit(alternative=Unknown.LENGTH),), "no other value of a single input explains it"),
    ("identify", "rounded", (thing(step_s=1e-3, repeated=1.0),), "are multiples of 1 ms: their rounding is taken for"),
    ("identify", "rounded", (thing(step_s=1e-3, repeated=9.0),), "repeats itself it does not average"),
    (
        "identify",
        "reason",
        (misfit(explanation=explained()),),
        "not independent, as they are where the model fits; ",
    ),
    ("identify", "reason", (misfit(explanation=explained()),), "with bottom and top exchanged the model fits"),
    (
        "identify",
        "reason",
        (misfit(alternative=Unknown.EXPONENT, explanation=explained(Unknown.LENGTH, (Unknown.DRIFT, Unknown.PHASE))),),
        "contradict the exponent of the restitution against speed; if only the length is wrong, it is 0.42 m "
        "± 0.00001, with a timing error of 100 µs; another drift of the clock, phase of the force would fit as well",
    ),
    (
        "identify",
        "reason",
        (
            misfit(
                alternative=Unknown.FREQUENCY,
                explanation=replace(explained(Unknown.FREQUENCY), clock_off=-1e-3, clock_accepted=2e-5),
            ),
        ),
        "with a timing error of 100 µs; or the record's clock is 1000 ppm slow (this record accepts up to 20 ppm)",
    ),
    (
        "identify",
        "instead",
        (replace(explained(Unknown.FREQUENCY), clock_off=3e-5, clock_accepted=2e-5),),
        "the record's clock is 30 ppm fast",
    ),
    (
        "identify",
        "reason",
        (misfit(alternative=Unknown.EXPONENT, explanation=explained(Unknown.EXPONENT)),),
        "is wrong, it is 0.42 ±",
    ),
    (
        "identify",
        "reason",
        (misfit(explanation=BetterFit(False, Unknown.EXPONENT, -0.1, 1e-3, 1e-4, (), BOTH[:1], 1.5)),),
        "device.restitution_exponent: -0.1, device.restitution_speed_m_s: 1.5, device.restitution_bottom: 0.01",
    ),
    *(
        ("identify", "reason", (misfit(failure=NoFit(Unfit[name], value)),), part)
        for name, value, part in (
            ("SCATTER", 0.02, "a timing error of 20 ms would be needed"),
            ("RESTITUTION", 1.25, "a restitution of 1.25 would be needed"),
            ("PATH", 2.5, "passes through a membrane after 2.5 s"),
            ("NO_MOTION", 0.0, "no motion fits these impacts"),
        )
    ),
    ("identify", "summary", (9, 1e-4, 0, 0, 0, False), "9 impacts, timing error 100 µs."),
    ("identify", "summary", (9, 1e-4, 0, 0, 0, True), "error 100 µs at the median of the stated errors."),
    ("identify", "summary", (9, 1e-4, 2, 1, 1, False), "2 missed, 1 false, 1 flight left out."),
    ("identify", "summary", (9, 1e-4, 2, 3, 2, False), "3 false, 2 flights left out."),
    ("identify", "untested", ((), False), ""),
    ("identify", "untested", ((Unknown.LENGTH,), True), "another length, exchanged membranes."),
    ("identify", "untested", ((), True), "are taken from the scenario: exchanged membranes."),
    ("identify", "untested", ((Unknown.LENGTH,), False), "another length."),
    ("identify", "untested", ((Unknown.LENGTH,), False, True), "another length, other harmonics of the force."),
    ("identify", "not_used", ((),), ""),
    ("identify", "not_used", (("voltage_v",),), "Read and not used: voltage_v."),
    (
        "identify",
        "heard",
        (
            thing(times=[1.0] * 300, middle_error_s=2e-5),
            [
                thing(times=[1.0] * 150, channel=thing(name=x), noise=0.01, middle_size=0.5)
                for x in ("bottom_voltage_v", "top_voltage_v")
            ],
            thing(name="x.csv", samples=96000, start_s=1.0, end_s=3.0),
        ),
        "x.csv: 96000 samples in 2 s, 300 impacts picked: 150 in bottom_voltage_v, noise 0.01, median impact 0.5; "
        "150 in top_voltage_v, noise 0.01, median impact 0.5. Their times have a standard error of 20 µs.",
    ),
    *(
        ("identify", "finding", (thing(doubt=thing(name=name), channel="sound_pa", value=value),), part)
        for name, value, part in (
            ("CLIPPED", 12, "sound_pa is clipped at 12 impacts"),
            ("SLOW", 2.0, "half a rise takes 2 samples"),
            ("FOLDED", 0.25, "has 25 % of the power of its impacts close to half"),
            ("OFFSET", 0.3, "an offset of 0.3, which was subtracted"),
            ("BOTH", 3, "3 impacts were almost equally strong in both channels"),
            ("GAPS", 2, "samples are missing at 2 places."),
            ("UNEVEN", 2e-5, "deviate by up to 20 µs from an even clock"),
        )
    ),
    (
        "identify",
        "shaker",
        (
            thing(
                amplitude=24.1,
                amplitude_error=0.01,
                frequency_hz=2.0,
                frequency_error_hz=1e-5,
                maximum_s=10.25,
                maximum_error_s=1e-4,
            ),
        ),
        "± 0.01 m/s² at 2",
    ),
    ("identify", "held", (thing(end=None),), "The harmonics of the force are held at their values."),
    (
        "identify",
        "held",
        (thing(end=LENGTH_END, error=0.00123),),
        "period doubling, is 0.02 m away in length; the errors of the harmonics move it by 0.0012 m (one standard",
    ),
    ("identify", "held", (thing(end=LENGTH_END, error=None),), "how well the harmonics are known is not said."),
    ("identify", "devices", (MeasuredShare(4096, 4096, 0.9991, 1.0),), "99.91 % or more of such devices keep"),
    (
        "identify",
        "devices",
        (MeasuredShare(4095, 4096, 0.998, 1.0),),
        "99.98 % of such devices keep stable 1:1 motion: 4095 of 4096 that were tried.",
    ),
    (
        "identify",
        "devices",
        (MeasuredShare(64, 128, 0.4, 0.6, DesignInput.LENGTH, 0.002),),
        "cannot be said: 50 % of those that fit do. The error of the length costs most: measure it to 0.002 m (",
    ),
    (
        "identify",
        "devices",
        (MeasuredShare(64, 128, 0.4, 0.6, DesignInput.RESTITUTION_TOP, 0.01),),
        "measure it to 0.01 (standard error).",
    ),
    (
        "identify",
        "devices",
        (MeasuredShare(64, 128, 0.4, 0.6, DesignInput.LENGTH),),
        "The error of the length costs most.",
    ),
    ("figures/record", "figure_record_title", ({},), "What was picked"),
    *(
        (
            "figures/record",
            f"figure_record_{part}",
            ({"impacts": 9, "name": "x.csv", "channels": count, "shaker": shaker},),
            "9 impacts",
        )
        for part in ("caption", "alt")
        for count, shaker in ((1, None), (2, thing()))
    ),
]


@pytest.mark.parametrize(
    ("words", "macro", "given", "part"), SAID, ids=[f"{x[0]}-{x[1]}-{k}" for k, x in enumerate(SAID)]
)
def test_tables_and_proofs_are_worded(words: str, macro: str, given: tuple[object, ...], part: str, taken) -> None:
    assert part in said(words, macro, *given)


def test_every_branch_of_the_words_is_said_above(taken) -> None:
    """It says all of it itself, as other tests may run elsewhere."""
    for make, _ in VERDICTS.values():
        verdict = verdict_of(make())
        verdict.worded()
        for picture in ("figure-2", ""):
            said("verdict", "paragraph", verdict, picture)
    for macro, x, _ in FIGURES:
        of_figure(macro, x)
    for words, macro, given, _ in SAID:
        said(words, macro, *given)
    branches, told = taken()
    assert branches - told == set()
    assert {branch.partition(":")[0] for branch in branches} == {str(file.relative_to(TEMPLATES)) for file in WORDS}
