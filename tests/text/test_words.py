"""The words of templates: every branch of them is said here by some results, and by no name that is not there."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from math import inf
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from branches import branches_taken, macros_of
from conftest import EXAMPLES, solved, toleranced
from jinja2 import nodes
from jinja2.meta import find_undeclared_variables
from msgspec.structs import replace
from pages import read_back

from vireport import analyse, load
from vireport.comparison.ranking import RANK_BY, RANKING_COLUMNS, Merit
from vireport.design.effects import Effect, Shift, Shifts, Unmoved
from vireport.design.from_rest import Destination, FromRest
from vireport.design.measured import MeasuredShare
from vireport.design.outcomes_from_rest import OutcomeRange
from vireport.design.plane import Plane
from vireport.design.solution import Solution
from vireport.design.switched_on import SwitchedOn
from vireport.figures.captions import FILES, Circles, Extent, MeasuredPoints
from vireport.map.cells.cells import AxisName
from vireport.measurement.flights import Unknown
from vireport.measurement.identification import NoFit, Open, Unfit
from vireport.measurement.inspection import InspectedClock
from vireport.measurement.misfit import BetterFit, Hidden
from vireport.motions.events import Event
from vireport.motions.stability import Stability
from vireport.motions.switching import Limits
from vireport.physics.energy import ElectricalCycle
from vireport.physics.word import Word
from vireport.report.changes.quantities import MEASURED_QUANTITIES
from vireport.report.markdown import FILTERS as MARKDOWN_FILTERS
from vireport.report.templates import FILTERS
from vireport.scenario.blocks import LeftOut
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.opening import opening_of
from vireport.study.judging.verdict import Conclusion, verdict_of
from vireport.study.plan import Addition, Task
from vireport.text.folders import ROOTS, TEMPLATES
from vireport.text.formatting import OF_A_MODEL, ROUGHLY, rounded_text
from vireport.text.templates import Words, environment_of

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


@pytest.mark.parametrize(
    "file", sorted(file for root in ROOTS for file in root.rglob("*.j2")), ids=lambda file: file.stem
)
def test_a_template_has_no_name_that_nothing_defines(file: Path) -> None:
    source = file.read_text(encoding="utf-8")
    environment = environment_of(None)
    environment.filters |= MARKDOWN_FILTERS if file.name.endswith(".md.j2") else FILTERS
    tree = environment.parse(source)
    # What is set in a branch counts as undeclared, though it is used in that branch alone.
    own = {name.name for name in tree.find_all(nodes.Name) if name.ctx != "load"}
    own |= {macro.name for macro in tree.find_all(nodes.Macro)}
    names = find_undeclared_variables(tree) - own
    assert names <= (
        set() if "/templates/words/" in file.as_posix() else OF_BENCH if file.parent.name == "bench" else FROM_OUTSIDE
    )


def thing(**of: object) -> SimpleNamespace:
    return SimpleNamespace(**of)


@pytest.fixture(scope="module")
def taken() -> Iterator[Callable[[], tuple[set[str], set[str]]]]:
    """The branches of the words, and those that were taken."""
    with branches_taken() as told:
        yield told


def said(words: str, macro: str, *given: object) -> str:
    return Words(words)(macro, *given)


def check(**given: object) -> SimpleNamespace:
    """A simulation that found every stable motion again, and some other motions."""
    others = tuple(thing(count=count, name=name) for count, name in ((4, "BBT"), (3, "BTBT"), (2, "chaos"), (1, "B")))
    usual = {"passed": True, "orbits": 9, "misses": (), "velocity_difference": 1e-14, "phase_difference": 2e-14}
    usual |= {
        "trials": 20,
        "arrivals": 15,
        "share": (0.75, 0.5, 0.9),
        "elsewhere": (),
        "motions": others,
        "values": [0],
    }
    return thing(**usual | given, others=others)


def followed(*words: str) -> SimpleNamespace:
    """Families of motions that are stable wherever it is asked."""
    families = [thing(word=Word.of(*word.split(), *([3] if "3" in word else []))) for word in words]
    for family, word in zip(families, words, strict=True):
        family.word = Word.of(word.rstrip("3"), 3 if word.endswith("3") else 1)
        family.settable, family.settable_at = True, lambda value: True
    return thing(families=families, stable_at=lambda value: [(family, None) for family in families])


def required(passed: bool, question: str = "MARGIN") -> SimpleNamespace:
    from vireport.text.requirements import Question

    limit = thing(text="at least 5 %", value=5.0)
    return thing(
        passed=passed,
        names_motions=question == "MOTION",
        question=Question[question],
        title="Margin",
        limit=limit,
        key="margin_any_percent",
    )


def compliant(**changed: object) -> Evidence:
    """What the membranes' own stiffness makes of the inclined capsule, changed as a whole or at its ends."""
    point, names = thing(label="B1", event=thing(words="period doubling")), ("compliant", "compliant_margin", "why")
    values = {"rigid": 0.62946, "moved": 0.04791, "compliant": 0.58155, "compliant_margin": 0.0799, "absence": None}
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
    given = {"left": 0.01, "stable": True, "computed": True, "relative": 0.04, "size": -0.05, "speed_m_s": None} | of
    given = {"absence": None} | given
    effect = thing(left_out=LeftOut[left_out], size=given["size"], speed_m_s=given["speed_m_s"])
    return thing(effect=effect, **given)


def film(**given: float) -> dict[str, float]:
    values = {"thickness_m": 1e-3, "relative_permittivity": 4.7, "breakdown_field_v_m": 1e9} | given
    return {f"device__membrane__{key}": value for key, value in values.items()}


HERE = {"sweep__to": 0.62, "device__length_m": 0.6}
"""A sweep of the inclined capsule without stable 1:1 motion, and a design point in it."""


def switched_on(end: Destination = Destination.ONE_TO_ONE, settles: int | None = 17) -> Evidence:
    """The inclined capsule with what it comes to when it is switched on."""
    motion = {Destination.ONE_TO_ONE: ("BT", 1), Destination.REST_CYCLE: ("B~", 3)}.get(end, ("", 0))
    return Evidence(solved("inclined"), switched_on=SwitchedOn(FromRest(end, *motion, settles)))


def nowhere_stable(**found: list[FromRest]) -> Evidence:
    """A sweep without stable 1:1 motion and without a design point, and what it comes to in stretches of it."""
    parts = {key: tuple(OutcomeRange(0.6, 0.61, end) for end in ends) for key, ends in found.items()}
    return Evidence(solved("inclined", sweep__to=0.62, device__length_m=None), switched_on=SwitchedOn(None, **parts))


NARROW = {"device__length_m": 0.61, "excitation__amplitude_n": 6.9375, "tolerances__length_percent": 10.0}
"""At which 1:1 motion is stable from 0.6083 to 0.6125 m."""

OPENINGS: dict[str, Callable[[], Evidence]] = {
    "swept": lambda: Evidence(solved("inclined")),
    "throughout": lambda: Evidence(solved("inclined", sweep__from=0.65)),
    "two ends": lambda: Evidence(solved("inclined", sweep__to=1.6)),
    "too narrow to be set": lambda: Evidence(toleranced(**NARROW, sweep__to=2.0)),
    "too narrow without a design point": lambda: Evidence(
        toleranced(**NARROW | {"device__length_m": None}, sweep__to=0.615)
    ),
    "nothing that some starts do not find": lambda: Evidence(
        solved("inclined", device__length_m=0.6),
        switched_on=SwitchedOn(
            FromRest(Destination.REST_CYCLE, "B~", 8, 0), by_starts=(thing(name="B every 2 forcing periods"),)
        ),
    ),
    "without a design point": lambda: Evidence(solved("inclined", device__length_m=None)),
    "nothing in the sweep, and from rest": lambda: nowhere_stable(
        sampled=[FromRest(Destination.OTHER_MOTION, "BBT", 1), FromRest(Destination.CHAOTIC)]
    ),
    "others in the sweep": lambda: Evidence(
        solved("inclined", sweep__to=0.62, device__length_m=None), atlas=followed("BB")
    ),
    "an allowed motion": lambda: Evidence(
        solved("inclined", **HERE), atlas=followed("BBT"), criteria=(required(True, "MOTION"),)
    ),
    "one point": lambda: Evidence(solved("design-point")),
    "reached from rest": lambda: switched_on(),
    "reached from rest, not known when": lambda: switched_on(settles=None),
    "not reached from rest": lambda: switched_on(Destination.REST_CYCLE),
    "undecided from rest": lambda: switched_on(Destination.UNDECIDED, None),
    "handover above a nearer end": lambda: Evidence(
        two_ends({"event": Event.FOLD, "distance": -1.0}, {**HANDOVER, "distance": 4.5})
    ),
    "less margin to use than required": lambda: replace(
        affected(LeftOut.RESTITUTION_BOTTOM, -0.05, value=0.65, event=Event.FOLD, moved=0.02, relative=0.03, left=0.04),
        criteria=(required(passed=True),),
    ),
    "two motions": lambda: Evidence(solved("horizontal", inclination_deg=1.0, device__length_m=0.36)),
    "another beside": lambda: Evidence(solved("inclined"), atlas=followed("BT", "BBT")),
    "light ball": lambda: Evidence(solved("inclined", device__ball_mass_kg=1e-7)),
    "no ball mass": lambda: Evidence(solved("inclined", device__ball_mass_kg=None)),
    "more energy than is lost": lambda: Evidence(solved("inclined", **film(bias_voltage_v=6000.0))),
    "beyond breakdown": lambda: Evidence(solved("inclined", **film(breakdown_field_v_m=1e7))),
    "a pair of valid voltages": lambda: Evidence(
        solved("horizontal", inclination_deg=1.0, device__length_m=0.36, device__ball_mass_kg=1e-7)
    ),
    "compliant, unstable": lambda: compliant(motion=thing(stable=False, contact_share=0.02), margin_gone=True),
    "compliant, not found": lambda: compliant(motion=None, absence=thing(missing="not found", reason="at K: no root")),
    "compliant, a lost end": lambda: compliant(
        compliant=None, compliant_margin=None, why=thing(missing="lost", reason="it falls back")
    ),
    "compliant, no margin": lambda: compliant(compliant_margin=-0.01),
    "unresolved": lambda: Evidence(
        at_design(solved("inclined"), unresolved_inputs=(DesignInput.LENGTH, DesignInput.RESTITUTION))
    ),
    "endless": lambda: Evidence(at_design(solved("inclined"), margins=())),
    "an unlabelled end of grazing": lambda: Evidence(
        with_end(solved("inclined"), event=Event.GRAZING, label="", distance=1.5, relative=None)
    ),
    "ends on both sides": lambda: Evidence(
        two_ends({"distance": -0.6, "relative": -0.013}, {"distance": 1.7, "relative": 0.038})
    ),
    "an end on the other side that is far": lambda: Evidence(
        two_ends({"distance": 0.6, "relative": 0.013}, {"distance": -1.9, "relative": -0.042})
    ),
    "recoil that leaves little": lambda: affected(LeftOut.CAPSULE, left=0.011),
    "a membrane that leaves nothing": lambda: affected(LeftOut.RESTITUTION_TOP, 0.05, left=-0.02),
    "friction that ends it": lambda: affected(LeftOut.FRICTION, 0.05, absence=Unmoved.NOT_STABLE),
    "requirements": lambda: Evidence(
        solved("inclined"), criteria=(required(False), required(False), required(True, "SHAKER"))
    ),
    "simulated": lambda: Evidence(solved("inclined"), check(orbits=1)),
    "contradicted": lambda: Evidence(solved("inclined"), check(passed=False, misses=(1, 2), share=None)),
}


def at_design(solution, **changed: object):
    return replace(solution, design=replace(solution.design, **changed))


def affected(left_out: LeftOut, size: float = 0.0, **of: object) -> Evidence:
    """The inclined capsule with one neglected effect."""
    solution = solved("inclined")
    (end, *_), shift = solution.design.limits(), Shift(Effect(left_out, size), **of)
    return Evidence(solution, effects=Shifts(end, (shift,)))


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
    relative = of.get("relative")
    return thing(size=abs(relative) if isinstance(relative, float) else inf, **end | of)


@pytest.mark.parametrize("name", OPENINGS)
def test_an_opening_is_worded(name: str, taken) -> None:
    worded = opening_of(verdict_of(OPENINGS[name]())).worded()
    text = [line.replace("\u00a0", " ") for line in worded.text]
    states = [worded.status, *(status for status, _ in worded.facts), *(tile.status for tile in worded.tiles)]
    assert read_back("words, openings", [" ".join(state.name for state in states), *text], name) == []
    assert len(worded.sentence.split()) <= 15
    numbers = [part for tile in worded.tiles for part in (tile.value, tile.remark) if any(map(str.isdigit, part))]
    assert [number for number in numbers if any(number in line for line in worded.text[: 1 + len(worded.facts)])] == []
    assert len(worded.facts) <= 4
    assert len(worded.tiles) <= 4
    for line in text:
        assert not re.search(r" [.,;]|\.\.|,,|\bnan\b|\binf\b|{", line)


FREQUENCY = thing(quantity="frequency", show=lambda value, error: f"{value:g} Hz")
ANGLE = thing(quantity="inclination", show=lambda value, error: f"{rounded_text(value, error)}°")
PLACED = thing(place=lambda end: "1.91 Hz", end_text=lambda part, side: ("1.5 Hz", "2.5 Hz")[side], inequality=str)
PART = thing(parameter=FREQUENCY, start_point=thing(event=Event.FOLD), end_point=thing(event=Event.GRAZING))
MISSED = thing(
    title="U_ave", limit=thing(text="at least 900 V"), outcome=thing(text="800 V"), margin_text="-100 V", key="u_ave"
)


def test_what_is_ranked_has_its_words() -> None:
    named = set(macros_of("compare"))
    assert named >= {f"lacks_{conclusion.name.lower()}" for conclusion in Conclusion}
    assert named >= {f"best_{merit}" for merit in Merit}
    assert named >= {f"head_{merit}" for merit in RANKING_COLUMNS} | {f"by_{merit}" for merit in RANK_BY.values()}


def test_every_measured_quantity_has_its_words() -> None:
    assert set(macros_of("quantities")) >= {name for name, _ in MEASURED_QUANTITIES}


def test_every_conclusion_has_its_sentence() -> None:
    given: dict[Conclusion, tuple[object, ...]] = {Conclusion.NOT_BOUNCING: ()}
    given |= dict.fromkeys((Conclusion.BOUNCING, Conclusion.BOUNCING_NEAR_END), (thing(name="B every forcing period"),))
    sentences = [said("opening", one.name.lower(), *given.get(one, ("It runs",))) for one in Conclusion]
    assert len(set(sentences)) == len(Conclusion)
    assert max(len(sentence.split()) for sentence in sentences) <= 14


LENGTH = Parameter.LENGTH
HELD = ["F = 3 N", "r = 0.5"]
ALONG = {
    "held": HELD,
    "range": "s from 0.5 m to 0.6 m",
    "swept": LENGTH,
    "ranges": [],
    "points": [],
    "exactness": OF_A_MODEL,
    "kinds": [],
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
    "kinds": [Event.NODE_FOCUS, Event.PERIOD_DOUBLING],
    "doubled": ["BTBT"],
    "mirrored": True,
    "simulated": Circles(8, 1, False),
    "from_rest": 0.862,
}

SPEEDS = [Extent("speed", 0.5, 1.2345, where="bottom"), Extent("phase", 1e-9, 3.0, where="top")]
VALUES = [Extent("discriminant", -1.0, 2e9), Extent("eigenvalues", 0.5, 0.5)]
POINTS = [thing(label=label, sweep_value=value) for label, value in (("B1", 0.55), ("C1", 0.58))]
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
STABLE_B = thing(name="B every forcing period", stable_ranges=[(0.5, 0.6), (0.7, 0.8)])
ON_TABLE = ALONG | {"families": 3, "stable": [], "simulated": 0}
DIAGRAM = {"held": HELD, "swept": LENGTH, "simulated": 9, "groups": [], "still": []}
GROUPS = [{"word": "BT", "found": 3, "low": 0.5, "high": 0.55}, {"word": "BBT", "found": 1, "low": 0.6, "high": 0.6}]
END = thing(name="fold C1", parameter=DesignInput.FREQUENCY, sweep_value=1.9)
CYCLES = {
    "cycles": (("bottom", ElectricalCycle(1.5e-6, 2e3, 5e3)), ("top", ElectricalCycle(1.2e-6, 2e3, 6e3))),
    "bias_v": 2e3,
    "breakdown_v": 8e3,
    "exactness": OF_A_MODEL,
}

ANSWER = {
    "swept": LENGTH,
    "ranges": ["0.5 m < s", "s < 0.6 m"],
    "ends": [(thing(event=Event.PERIOD_DOUBLING, label="B1"), "0.55 m")],
    "speeds": [(5.76, 6.31), (3.45, 4.0)],
    "exactness": OF_A_MODEL,
}
FIGURES: list[tuple[str, dict[str, object]]] = [
    ("figure_answer_caption", ANSWER),
    ("figure_answer_alt", ANSWER),
    ("figure_answer_alt", ANSWER | {"ranges": [], "ends": []}),
    ("figure_2_caption", {**ALONG}),
    ("figure_2_caption", {**WITH_ALL, "unit_m_s": 6.0241, "level": True}),
    ("figure_4_caption", {**ALONG, "largest": 87.12, "mirrored": True}),
    ("figure_2_caption", {**ALONG, "simulated": Circles(8, 2, True)}),
    ("figure_4_caption", {**ALONG, "largest": 2e6}),
    ("figure_4_caption", ALONG),
    ("figure_7_caption", ALONG),
    ("figure_2_alt", {**ALONG, "from_rest": 0.623}),
    ("figure_2_alt", ALONG),
    (
        "figure_2_alt",
        {
            **ALONG,
            "extents": [(True, SPEEDS), (False, SPEEDS[:1])],
            "points": POINTS,
            "simulated": Circles(8, 2, False),
        },
    ),
    ("figure_4_alt", {**ALONG, "extents": [(True, VALUES)], "ranges": ["a < s", "s < b"]}),
    (
        "figure_7_alt",
        {**ALONG, "extents": [(True, [Extent("average", 1.0, 2e5, "V")])], "simulated": Circles(8, 2, False)},
    ),
    ("figure_7_alt", {**ALONG, "extents": [(True, [Extent("average", 4.0, 4.0, "V")])]}),
    ("figure_3_caption", MOTIONS),
    ("figure_6_caption", {"held": [], "motions": [PERIODIC, {**CHAOTIC, "lyapunov": None}], "measured": 0}),
    ("figure_portraits_caption", MOTIONS),
    ("figure_3_alt", MOTIONS),
    ("figure_6_alt", {"held": HELD, "motions": [{**PERIODIC, "growth": None}, {**CHAOTIC, "lyapunov": 0.1234}]}),
    ("figure_portraits_alt", {"held": HELD, "motions": [{**PERIODIC, "speeds": [0.1 * k for k in range(1, 9)]}]}),
    ("figure_diagram_caption", DIAGRAM),
    ("figure_diagram_alt", DIAGRAM),
    ("figure_diagram_alt", {**DIAGRAM, "groups": GROUPS, "still": ["at rest", "sticking"]}),
    ("figure_diagram_alt", {**DIAGRAM, "simulated": 1, "groups": GROUPS[1:]}),
    ("figure_hysteresis_caption", {"held": HELD, "swept": LENGTH, "jumps": 0, "loops": [], "measured": ""}),
    ("figure_hysteresis_caption", {"held": HELD, "swept": LENGTH, "jumps": 0, "loops": [], "measured": SEEN}),
    ("figure_atlas_caption", FAMILIES | {"measured": SEEN}),
    ("figure_2_caption", ALONG | {"measured": SEEN}),
    ("figure_4_caption", ALONG | {"measured": SEEN}),
    ("figure_2_alt", ALONG | {"measured": SEEN}),
    ("figure_4_alt", ALONG | {"measured": SEEN}),
    ("figure_3_caption", MOTIONS | {"measured": 1}),
    (
        "figure_hysteresis_alt",
        {"swept": LENGTH, "jumps": 1, "loops": [thing(low=0.2, high=0.3), thing(low=0.4, high=0.5)]},
    ),
    ("figure_atlas_caption", FAMILIES),
    ("figure_atlas_caption", {**FAMILIES, "simulated": True}),
    ("figure_atlas_caption", {**FAMILIES, "found": 30}),
    ("figure_ladder_caption", {**FAMILIES, "found": 30}),
    ("figure_atlas_alt", FAMILIES),
    ("figure_atlas_alt", {**FAMILIES, "stable": []}),
    ("figure_table_caption", ON_TABLE),
    ("figure_table_caption", ON_TABLE | {"simulated": 2}),
    ("figure_table_alt", ON_TABLE),
    ("figure_table_alt", ON_TABLE | {"simulated": 2, "stable": [STABLE_B, STABLE_B]}),
    ("figure_ladder_caption", FAMILIES),
    ("figure_ladder_alt", {**FAMILIES, "best": None}),
    (
        "figure_ladder_alt",
        {"swept": LENGTH, "best": thing(word=Word.of("BBT"), per_second_v=1234.0), "exactness": OF_A_MODEL},
    ),
    ("figure_device_caption", {"motion": "", "other": False}),
    ("figure_device_caption", {"motion": "stable node", "other": False}),
    ("figure_device_caption", {"motion": "BBT", "other": True}),
    ("figure_device_alt", {"dimensions": HELD, "motion": ""}),
    ("figure_device_alt", {"dimensions": HELD, "motion": "BT", "at_top": [0.25, 0.5]}),
    ("figure_device_alt", {"dimensions": HELD, "motion": "B", "at_top": []}),
    ("figure_margins_caption", {"end": END, "exactness": ROUGHLY}),
    ("figure_margins_alt", {"end": END, "shifts": [(LENGTH, 0.5), (Parameter.AMPLITUDE, -0.25)]}),
    ("figure_cycle_caption", CYCLES),
    ("figure_cycle_alt", CYCLES),
]


def of_figure(macro: str, *given: object) -> str:
    name = macro.rpartition("_")[0].replace("_", "-")
    return said(f"figures/{FILES[Task(name)] if name in set(Task) else name.removeprefix('figure-')}", macro, *given)


def test_figures_are_worded_as_is_kept(taken) -> None:
    titles = dict.fromkeys(f"{macro.rpartition('_')[0]}_title" for macro, _ in FIGURES)
    lines = [f"{title}: {of_figure(title)}" for title in titles]
    lines += [f"{macro}: {of_figure(macro, x)}" for macro, x in FIGURES]
    assert read_back("words, figures", lines) == []


B1 = thing(label="B1", event=Event.PERIOD_DOUBLING)


def record(**of: object) -> SimpleNamespace:
    """A record that shows no motion, but for what is said of it."""
    known = {"unfit": None, "left_open": None, "measured": None, "motion": None, "referenced": False, "impacts": 9}
    return thing(**known | of)


class AnyPlane(Plane, frozen=True, eq=False):
    """A plane of which it is known whether there are sweeps across it."""

    swept: bool = True


PLANE = AnyPlane((DesignInput.INCLINATION, DesignInput.LENGTH), np.array([0.0, 0.3]), np.array([90.0, 1.0]))
UNSWEPT = AnyPlane(PLANE.inputs, PLANE.low, PLANE.high, swept=False)


def charted(**of: object) -> SimpleNamespace:
    """What the words of a chart are told by."""
    known = {
        "plane": PLANE,
        "limits": Limits(4, 2),
        "loci": [0, 0],
        "meetings": [0],
        "design": thing(),
        "not_followed": 0,
    }
    return thing(**known | of)


BAND = {"word": "BBT", "varied": 0, "least": 1e-5, "most": 0.08, "settable": True}
CHARTED = [
    ("regions", ("length [m]", "restitution")),
    ("regions_note", (False,)),
    ("regions_note", (True,)),
    ("bands", ()),
    ("bands_note", ()),
    ("band_name", (thing(word="BBT", settable=True),)),
    ("band_name", (thing(word="BBT", settable=False),)),
    ("unmeasured", (["BBT", "BTT"],)),
    ("curves", ()),
    ("curves_note", ()),
    ("no_curves", ()),
    ("left_out", ()),
    ("lacks_motions", (thing(impacts=4, periods=2),)),
    ("lacks_words", ()),
    ("lacks_curves", (True,)),
    ("lacks_curves", (False,)),
    ("lacks_narrow", (0.0083,)),
    ("lacks_ends", (1,)),
    ("lacks_ends", (2,)),
    ("lacks_from_rest", ()),
    ("motion", ("BT", 1, True)),
    ("motion", ("BBT", 2, False)),
    ("motion", ("BBT", 0, False)),
    ("stable_unresolved", ()),
    ("stable_none", ()),
    ("stable", (["BT", "BBT"],)),
    ("meaning_unresolved", ()),
    ("meaning_none", (Limits(4, 1),)),
    ("meaning_none", (Limits(4, 2),)),
    ("meaning_one_to_one", (["BT"],)),
    ("meaning", (["BT", "BBT"],)),
    ("others_in_table", ()),
    ("others", ()),
    ("nothing", ()),
    ("band_alike", ()),
    ("band", (["BB", "BBT"],)),
    ("heading", (PLANE,)),
    ("up", ()),
    ("down", ()),
    ("handover", ()),
    ("meeting_in_table", ()),
    ("meeting", ()),
    ("narrow_note", ([], [], PLANE.inputs)),
    ("narrow_note", ([thing(**BAND)], [], PLANE.inputs)),
    ("narrow_note", ([thing(**BAND), thing(**BAND | {"least": 0.08})], ["BB"], PLANE.inputs)),
    ("narrow_note", ([thing(**BAND | {"settable": False})], ["BB", "B"], PLANE.inputs)),
    ("caption", (charted(), True, [])),
    ("caption", (charted(plane=UNSWEPT), True, [])),
    ("caption", (charted(), True, [])),
    ("caption", (charted(), False, [])),
    ("caption", (charted(), True, ["F = 3 N", "r = 0.5"])),
    ("caption", (charted(design=None), True, [])),
    ("summary", (charted(),)),
    ("summary", (charted(plane=UNSWEPT, not_followed=1),)),
    ("summary", (charted(loci=[0], meetings=[0, 0]),)),
    ("summary", (charted(not_followed=2),)),
    ("share", ("BT (1:1)", 0.5)),
    ("alt", (PLANE, ["BT (1:1) in 50 % of it", "BBT in 5 % of it"], ["It ends.", "It does not."])),
    ("word_without_design", ()),
    ("word_not_resolved", ()),
    ("word_not_stable", ()),
    ("word_other_motion", ()),
    ("word_not_judged", ()),
    ("opening_without_design", ()),
    ("opening_not_resolved", ()),
    ("opening_not_stable", (Limits(4, 2),)),
    ("opening_other_motion", ("BBT",)),
    ("opening_not_judged", ("BT",)),
    ("opening_region", ("bT (1:1)", 0.5)),
    ("opening_endless", ("BT", Parameter.LENGTH)),
    ("opening_end", ("BT", Parameter.INCLINATION, "up", "51.6°", "+15 %", "period doubling")),
    ("points", (["length [m]", "inclination [°]"],)),
    ("points_note", ()),
    ("point", (Event.CUSP,)),
    ("point_with_grazing", (Event.FOLD,)),
    ("two_grazings", ()),
    ("end_sweep_end", ()),
    ("end_closed", ()),
    ("end", (Event.CUSP,)),
]
"""What is said of charts, by macro."""

MAP = thing(named=(AxisName("inclination", "β", "°"), AxisName("length", "s", "m")), shape=(60, 80))
MAP.plane = Plane(MAP.named, np.array([0.0, 0.2]), np.array([90.0, 0.9]))
CELLS = thing(cells=4800, stable=2093, with_motion=4730, missed=240, outside=946)
MAPPED = {"plan": MAP, "held": ["F = 3 N", "r = 0.5"], "findings": CELLS, "marked": thing(), "curves": True}
MAPPED |= {"outcomes": [("1:1", 3600), ("chaotic", 1200)]}
ON_MAPS = [
    *(("title", (f"map-{name}",)) for name in ("stability", "margin", "voltage", "from-rest", "shock")),
    ("heading", ("map-stability",)),
    ("heading", ("map-margin",)),
    ("heading", ("map-voltage",)),
    ("heading", ("map-from-rest",)),
    ("heading", ("map-shock",)),
    ("curves", ()),
    ("over", (MAP,)),
    ("design_point", ()),
    ("margins", ("BT", "s = 0.7 m", True)),
    ("margins_note", ()),
    ("end", (Event.FOLD,)),
    ("handover", (Event.PITCHFORK,)),
    ("motion_name", ()),
    ("missed", (CELLS,)),
    ("caption", ("map-stability", MAPPED)),
    ("caption", ("map-stability", MAPPED | {"marked": None, "curves": False})),
    ("alt", ("map-margin", MAPPED)),
    ("alt", ("map-from-rest", MAPPED)),
    ("word", ()),
    ("headline", (MAP, CELLS)),
    ("only_unstable", (CELLS,)),
    ("give_design", ()),
    *(("quantity", (name,)) for name in ("multiplier_margin", "u_ave_v", "least_jump_m_s")),
    ("value", ("multiplier_margin", 0.5234)),
    ("value", ("u_ave_v", 52690.0)),
    ("value", ("least_jump_m_s", 0.12345)),
    ("caption", ("map-from-rest", MAPPED)),
    ("of_design", ("β = 45°, s = 0.7 m",)),
    ("cells", ()),
    ("kind", (None,)),
    ("kind", (Stability.STABLE_NODE,)),
    ("largest", (["length [m]"],)),
    ("largest_note", (False,)),
    ("largest_note", (True,)),
    ("from_rest", ()),
    ("left_out", ()),
    ("lacks_motions", ()),
    ("lacks_figures", ()),
    ("lacks_from_rest", ()),
    ("lacks_shock", ()),
    ("lacks_voltage", ()),
]
"""What is said of maps, by macro."""

SAID: list[tuple[str, str, tuple[object, ...]]] = [
    *(
        (words, macro, ())
        for words in ("changes", "compare", "opening", "optimise", "quantities")
        for macro in macros_of(words, r"\)")
    ),
    ("opening", "word", (thing(word="Stable"),)),
    ("opening", "title_upright", ("0.7 m", "90°")),
    ("opening", "stretched_far", ("It runs",)),
    ("opening", "stable_in_sweep", (PLACED, "1 m < s")),
    ("opening", "alert", (thing(code="VR009", title="The result is sensitive"),)),
    ("opening", "not_reproduced", (thing(periods=9),)),
    ("opening", "ends_at_rest_without_period", (None,)),
    ("opening", "ends_one_to_one", (None,)),
    ("opening", "ends_other_motion_without_period", (None,)),
    ("opening", "ends_undecided_without_period", (None,)),
    ("opening", "margin_small_rigid", ("Go on",)),
    ("opening", "margin_small_effect", ("Go on", "look")),
    ("opening", "lost_by_effect", ("look closely",)),
    ("opening", "extrapolated", (thing(depth_m=0.0192, area_ratio=5.27),)),
    ("opening", "with_restitution_bottom_more", (0.05,)),
    ("opening", "with_restitution_top", (0.05,)),
    ("opening", "with_restitution_top_more", (0.05,)),
    ("opening", "with_capsule", (0.0,)),
    ("opening", "with_capsule_prescribed", (0.0,)),
    ("opening", "with_restitution_speed", (0.1,)),
    ("opening", "with_friction", (0.05,)),
    ("opening", "tile_above_of_input", (PLACED, PART)),
    ("opening", "tile_below_of_input", (PLACED, PART)),
    ("opening", "tile_throughout_of_input", (PLACED, PART)),
    ("opening", "tile_below_of_sweep", (PLACED, PART)),
    (
        "opening",
        "tile_ranges",
        (thing(inequality=lambda part: "1 Hz < f" if part is PART else "9 Hz < f"), (PART, thing(parameter=FREQUENCY))),
    ),
    ("opening", "room", (thing(relative=0.0123, parameter=FREQUENCY),)),
    ("opening", "room_absolute", (thing(parameter=ANGLE, end=thing(distance=-0.79)),)),
    ("opening", "room_gone", (None,)),
    ("opening", "limited_by_effect", ("a small effect",)),
    *(
        ("compare", f"best_{merit}", ("a", "b"))
        for merit in (
            "requirements",
            "stability",
            "from_rest",
            "recovery",
            "shock",
            "margin",
            "margin_rigid",
            "range",
            "voltage",
            "rate",
        )
    ),
    ("compare", "equally_good", ("a and b",)),
    ("compare", "word_best", ("a",)),
    ("compare", "why_requirements", ("1 of 2", "b", "2 of 2")),
    ("compare", "why_from_rest", ("BT", "b", "BBT")),
    ("compare", "why_recovery", ("9 periods", "b", "12 periods")),
    ("compare", "why_shock", ("2 m/s", "b", "1 m/s")),
    ("compare", "why_range", ("1 m < s", "b", "2 m < s")),
    ("compare", "why_voltage", ("2 kV", "b", "1 kV")),
    ("compare", "why_rate", ("2 kV/s", "b", "1 kV/s")),
    ("compare", "traded_rate", ("b", "3 kV/s", "+50 %", "none")),
    ("compare", "lacking", (["not stable: a", "margin small: b"],)),
    ("compare", "of", ("not stable", "a and b")),
    ("compare", "of_them", (3, 4)),
    ("compare", "periods", ("9",)),
    ("compare", "verdict", (["not stable", "margin small"],)),
    ("compare", "ranked_by", (["recovery", "least shock"],)),
    ("compare", "ranked_by_rate", ([],)),
    ("compare", "no_design_point", ("a and b",)),
    ("compare", "no_ball_mass", ("a and b",)),
    ("compare", "scenarios", (5,)),
    ("compare", "of_scenarios", ("Critical points", "a and b")),
    ("compare", "noted", ("1.5", "B1")),
    ("compare", "dash", ("no sweep", "a and b")),
    ("compare", "dashes", (["no sweep (a)", "no design point (b)"],)),
    ("compare", "figure_of", ("7", "a and b")),
    ("compare", "figures_of", ("2 and 4", "a")),
    ("compare", "over", ("length",)),
    ("compare", "overlay_caption", ("Over d",)),
    ("compare", "overlay_caption_remarks", ("Over d", ["not drawn: a", "no voltages: b"])),
    ("compare", "not_drawn", ("a and b",)),
    ("compare", "no_stable_voltage", ("a and b",)),
    ("compare", "stable_range", ("a", "1 m < s")),
    ("compare", "overlay_alt", (2, "Over d", ["a: 1 m < s", "b: s < 2 m"])),
    ("compare", "panels_alone", ("Velocities", ["f = 2 Hz", "(a) a: F = 3 N"])),
    ("compare", "column", ("(a)–(c)", "a", ["F = 3 N", "s from 1 m"])),
    ("compare", "panels_alt", ("2 columns", "1 panel", ["A: up.", "B: down."])),
    ("compare", "one_column", (1,)),
    ("compare", "columns", (4,)),
    ("compare", "one_panel", (1,)),
    ("compare", "panels", (3,)),
    ("compare", "column_alt", ("inclined", "Line charts.")),
    ("changes", "listed", (["a", "b"], "c")),
    ("changes", "listed_apart", (["a, b", "c"], "d")),
    ("changes", "number", ("2 m", "a and b")),
    ("changes", "number_with_note", ("2 m", "a and b", "B1")),
    ("changes", "groups", (["2 for a", "3 for b"],)),
    ("changes", "equals", ("s", "2 m for a")),
    ("changes", "from_to", ("1 m for a", "2 m for b")),
    ("changes", "symbol_from_to", ("s", "1 m for a", "2 m for b")),
    ("changes", "apart", ("1 m for a and 2 m for b", "50 %")),
    ("changes", "others", (7,)),
    ("changes", "compared", ("stable range from", "1 m for a")),
    ("changes", "compared_lacking", ("stable range from", "1 m for a", "no stable range for", "b and c")),
    ("changes", "new", ("stable range from", "1 m")),
    ("changes", "gone", ("stable range from", "1 m")),
    ("changes", "moved", ("alert", "note", "warning")),
    ("changes", "moved_by", ("stable range from", "1 m", "2 m", "+100 %")),
    ("changes", "in_group", ("stable range", "stable range from: new, 1 m.")),
    ("changes", "one_change", ("old.json",)),
    ("changes", "changes", (3, "old.json")),
    ("changes", "no_change", ("old.json",)),
    ("changes", "tolerance", ("1 × 10⁻⁶",)),
    ("changes", "identical", ("old.json",)),
    ("changes", "one_not_identical", ("old.json", ["a.b"])),
    ("changes", "not_identical", ("old.json", 3, ["a.b", "c", "d"])),
    ("quantities", "numbered_range_from", (2,)),
    ("quantities", "numbered_range_to", (2,)),
    ("quantities", "of_family", ("margin", "asymmetric")),
    ("quantities", "in_symbol", ("stable range from", "d")),
    ("quantities", "of_baseline", ("B1",)),
    ("quantities", "measured", ("impact velocity", "bottom")),
    ("quantities", "computed", ("impact velocity", "bottom")),
    ("quantities", "measured_less_computed", ("impact velocity", "top")),
    ("quantities", "no_shock_up_to", ("6.4",)),
    ("quantities", "standard_error", ("0.003",)),
    ("optimise", "best", (["length 1 m", "frequency 2 Hz"],)),
    ("optimise", "best_of_many", (["a 1", "b 2", "c 3", "d 4"],)),
    ("optimise", "limits", (["at the upper limit of length_m", "at the lower limit of frequency_hz"],)),
    ("optimise", "at_upper", ("length_m",)),
    ("optimise", "at_lower", ("length_m",)),
    ("optimise", "tile_objective", (thing(words="stroke"), "0.3 m", "small")),
    ("optimise", "shortcoming", ("no design x",)),
    ("optimise", "none_found", (["a", "b"],)),
    ("optimise", "none_of_judged", (4, 64, ["a", "b"])),
    ("optimise", "missed", (MISSED,)),
    ("optimise", "missed_by", (MISSED,)),
    ("optimise", "tolerances_open", (0.04,)),
    ("optimise", "tolerances_end", (["length 1 m", "frequency 2 Hz"], 0.4)),
    ("optimise", "does_not_repeat", (1e-3,)),
    ("optimise", "input", ("length", "1 m")),
    ("optimise", "in_unit", ("mean electrical power", "mW")),
    ("optimise", "usual_number", (MISSED, MISSED.limit)),
    ("optimise", "usual_held", (MISSED, None)),
    ("optimise", "on_grid", ("900",)),
    ("optimise", "on_grid_by", ("900", "0.2 %")),
    ("optimise", "elsewhere", (2,)),
    ("optimise", "not_judged", (7,)),
    ("optimise", "none_tolerates", ("25 %",)),
    ("optimise", "yielding", ("25 %",)),
    *(("chart", *row) for row in CHARTED),
    *(("map", *row) for row in ON_MAPS),
    *(("verify", f"word_{word}", ()) for word in ("agrees", "departs", "nothing", "pass", "fail", "none")),
    ("verify", "velocity", (B1,)),
    ("verify", "phase", (B1,)),
    ("verify", "voltage", (B1,)),
    ("verify", "critical", (B1,)),
    ("verify", "agrees", (["B1", "phase"],)),
    ("verify", "departs", (["B1", "phase"],)),
    ("verify", "nothing", ("there is no stable motion",)),
    ("verify", "soft_membranes", ("Good up to 3 m/s.",)),
    ("verify", "soft_membranes_left_out", ("numba is missing",)),
    ("verify", "failed", (["Radau 2", "RK4 1"],)),
    ("verify", "failed_of", ("Radau", 2)),
    ("verify", "not_tried", ("simulated transient", "needs numba")),
    ("verify", "tile_methods", (7, 90)),
    ("verify", "tile_worst", ("5 × 10⁻¹³", "B1")),
    ("verify", "tile_time", (0.0123,)),
    ("verify", "all_pass", (89,)),
    ("verify", "some_fail", (2, 89)),
    ("verify", "none_applies", ()),
    ("verify", "absent", (3,)),
    ("verify", "tile_cases", (81, 8)),
    ("verify", "tile_worst_case", (2.7e-14, 1e-11, "grazing: gap 0")),
    ("verify", "tile_seconds", (12.34,)),
    ("effects", "effect", (shift("RESTITUTION_BOTTOM"), FIXED)),
    ("effects", "effect", (shift("RESTITUTION_TOP"), FIXED)),
    ("effects", "effect", (shift("CAPSULE"), FIXED)),
    ("effects", "effect", (shift("CAPSULE"), FREE)),
    ("effects", "effect", (shift("FRICTION", size=0.05), thing(recoils=False, harmonics=(), friction=0.0))),
    ("effects", "effect", (shift("FRICTION", size=0.05), thing(recoils=False, harmonics=(), friction=0.1))),
    ("effects", "effect", (shift("SECOND_HARMONIC", size=0.02), FREE)),
    ("effects", "effect", (shift("SECOND_HARMONIC", size=0.02), thing(recoils=False, harmonics=(thing(),)))),
    ("effects", "effect", (shift("RESTITUTION_SPEED", size=-0.1), FREE)),
    ("effects", "effect", (shift("RESTITUTION_SPEED", size=-0.12, speed_m_s=5.0), FREE)),
    ("effects", "effect", (shift("STIFFNESS"), FREE)),
    ("effects", "left", (shift(left=-0.0317),)),
    ("effects", "left", (shift(left=None),)),
    ("effects", "left", (shift(left=None, absence=Unmoved.NOT_FOLLOWED),)),
    ("effects", "left", (shift(left=None, stable=False),)),
    ("effects", "left", (shift("FRICTION", left=None, stable=False, computed=False),)),
]


def explained(unknown: Unknown | None = None, others: tuple[Unknown, ...] = ()) -> BetterFit:
    return BetterFit(unknown is None, unknown, 0.42, 1e-5, 1e-4, others)


def misfit(accepted: bool = False, **of: object) -> SimpleNamespace:
    usual = {"p_value": 0.5, "failure": None, "alternative": None, "explanation": None} | of
    return thing(accepted=accepted, **usual)


BOTH = (Unknown.RESTITUTION_BOTTOM, 0.01), (Unknown.LENGTH, -0.02)
SAID += [
    ("measured", "points", (MeasuredPoints(3, ("BT", "BBT"), 1, True),)),
    ("measured", "points", (MeasuredPoints(1, (), 0, False),)),
    ("measured", "reason", (record(unfit=NoFit(Unfit.SCATTER, 0.02)),)),
    ("measured", "reason", (record(unfit=NoFit(Unfit.RESTITUTION, 1.2)),)),
    ("measured", "reason", (record(unfit=NoFit(Unfit.GAPS, 0.2)),)),
    ("measured", "reason", (record(unfit=NoFit(Unfit.PATH, 0.2)),)),
    ("measured", "reason", (record(),)),
    ("measured", "reason", (record(left_open=Open(impacts=12)),)),
    ("measured", "reason", (record(left_open=Open(), referenced=True),)),
    ("measured", "reason", (record(left_open=Open()),)),
    ("measured", "remarks", (record(),)),
    ("measured", "remarks", (record(measured=thing(missed=7, false=1), motion=thing(from_s=5.549), referenced=True),)),
    ("measured", "remarks", (record(measured=thing(missed=0, false=0), referenced=True),)),
    ("identify", "refused", (Open(impacts=12), True)),
    ("identify", "refused", (Open(combination=BOTH), True)),
    ("identify", "refused", (Open(answers=(BOTH, BOTH)), False)),
    ("identify", "refused", (Open(unstable=True), True)),
    ("identify", "refused", (Open(), False)),
    ("identify", "reason", (misfit(True, p_value=None),)),
    ("identify", "reason", (misfit(True),)),
    ("identify", "reason", (misfit(alternative=Unknown.LENGTH),)),
    ("identify", "rounded", (thing(step_s=1e-3, repeated=1.0),)),
    ("identify", "rounded", (thing(step_s=1e-3, repeated=9.0),)),
    ("identify", "reason", (misfit(explanation=explained()),)),
    ("identify", "reason", (misfit(explanation=explained()),)),
    (
        "identify",
        "reason",
        (misfit(alternative=Unknown.EXPONENT, explanation=explained(Unknown.LENGTH, (Unknown.DRIFT, Unknown.PHASE))),),
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
    ),
    ("identify", "instead", (replace(explained(Unknown.FREQUENCY), clock_off=3e-5, clock_accepted=2e-5),)),
    ("identify", "reason", (misfit(alternative=Unknown.EXPONENT, explanation=explained(Unknown.EXPONENT)),)),
    (
        "identify",
        "reason",
        (misfit(explanation=BetterFit(False, Unknown.EXPONENT, -0.1, 1e-3, 1e-4, (), BOTH[:1], 1.5)),),
    ),
    *(
        ("identify", "reason", (misfit(failure=NoFit(Unfit[name], value)),))
        for name, value in (("SCATTER", 0.02), ("RESTITUTION", 1.25), ("PATH", 2.5), ("NO_MOTION", 0.0))
    ),
    ("identify", "mend_clock", (explained(Unknown.DRIFT), "0.42", "0.1")),
    ("identify", "unit_of", (Unknown.RESTITUTION,)),
    ("identify", "summary", (9, 1e-4, 0, 0, 0, False)),
    ("identify", "summary", (9, 1e-4, 0, 0, 0, True)),
    ("identify", "summary", (9, 1e-4, 2, 1, 1, False)),
    ("identify", "summary", (9, 1e-4, 2, 3, 2, False)),
    ("identify", "untested", ((), False)),
    ("identify", "untested", ((Unknown.LENGTH,), True)),
    ("identify", "untested", ((), True)),
    ("identify", "untested", ((Unknown.LENGTH,), False)),
    ("identify", "untested", ((Unknown.LENGTH,), False, True)),
    ("identify", "hidden", ((Hidden(Unknown.LENGTH, 0.0912, ()),), [])),
    (
        "identify",
        "hidden",
        (
            (Hidden(Unknown.LENGTH, 0.0912, ()), Hidden(Unknown.AMPLITUDE, 0.291, ())),
            [(Unknown.RESTITUTION_BOTTOM, 0.0178), (Unknown.RESTITUTION_TOP, 0.0668)],
        ),
    ),
    ("identify", "not_used", ((),)),
    ("identify", "not_used", (("voltage_v",),)),
    (
        "identify",
        "heard",
        (
            thing(times=[1.0] * 300, middle_error_s=2e-5),
            [
                thing(times=[1.0] * 150, channel=thing(name=x), noise=0.01, middle_size=0.5)
                for x in ("bottom_voltage_v", "top_voltage_v")
            ],
            thing(samples=96000, start_s=1.0, end_s=3.0, reading=""),
            "x.csv",
        ),
    ),
    (
        "identify",
        "heard",
        (
            thing(times=[1.0] * 150, middle_error_s=2e-5),
            [thing(times=[1.0] * 150, channel=thing(name="voltage_v"), noise=0.01, middle_size=0.5)],
            thing(samples=96000, start_s=1.0, end_s=3.0, reading="Rigol export: 2 head lines, 96,000 samples at 20 us"),
            "x.csv",
        ),
    ),
    ("identify", "read_as", (thing(reading="WAV: 2 channels, 44,000 samples at 250 us"), "x.wav")),
    ("identify", "inspected", (thing(table=thing(reading="text: 1 head line"), samples=1400), "2 ms")),
    ("identify", "inspected", (thing(table=thing(reading="text: 1 head line"), samples=1400), "")),
    ("identify", "places", ((0.1, 0.2),)),
    ("identify", "places", ((0.1, 0.2, 0.3, 0.4),)),
    ("identify", "inspected_clock", (None,)),
    *(
        ("identify", "inspected_clock", (InspectedClock(column, 1e-3, 0.0, spread, *places),))
        for column, spread, places in (
            (None, 0.0, ()),
            (1, 0.0, ()),
            (2, 0.36, ((2.1,), (0.1,), (0.2, 0.3))),
        )
    ),
    *(
        ("identify", "finding", (thing(doubt=thing(name=name), channel="sound_pa", value=value, at_s=0.25),))
        for name, value in (
            *(("CLIPPED", 12), ("SLOW", 2.0), ("FOLDED", 0.25), ("OFFSET", 0.3), ("BOTH", 3), ("GAPS", 1), ("GAPS", 2)),
            *(("UNEVEN", 2e-5), ("UNEQUAL", 1e-3), ("MISSING", 3), ("REPEATED", 2)),
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
    ),
    ("identify", "held", (thing(end=None),)),
    ("identify", "held", (thing(end=LENGTH_END, error=0.00123),)),
    ("identify", "held", (thing(end=LENGTH_END, error=None),)),
    ("identify", "devices", (MeasuredShare(4096, 4096, 0.9991, 1.0),)),
    ("identify", "devices", (MeasuredShare(4095, 4096, 0.998, 1.0),)),
    ("identify", "devices", (MeasuredShare(64, 128, 0.4, 0.6, DesignInput.LENGTH, 0.002),)),
    ("identify", "devices", (MeasuredShare(64, 128, 0.4, 0.6, DesignInput.RESTITUTION_TOP, 0.01),)),
    ("identify", "devices", (MeasuredShare(64, 128, 0.4, 0.6, DesignInput.LENGTH),)),
    ("figures/record", "figure_record_title", ({},)),
    ("identify", "heading", ("taps.csv",)),
    ("identify", "identified", ()),
    ("identify", "named_in", (Unknown.LENGTH,)),
    ("identify", "named_in", (Unknown.RESTITUTION_TOP,)),
    ("identify", "harmonics", ()),
    *(
        ("figures/impacts", f"figure_impacts_{name}", ({"impacts": 9, "name": "x.csv", "every": every} | of,))
        for name, every, of in (
            ("errors_title", 1, {}),
            ("errors_caption", 1, {"weighted": False}),
            ("errors_caption", 4, {"weighted": True}),
            ("errors_alt", 1, {}),
            ("phases_title", 1, {}),
            ("phases_caption", 1, {}),
            ("phases_alt", 1, {}),
        )
    ),
    ("left-out", "add", (["springs: for more"], "device.length_m")),
    ("left-out", "add_or_all", ([Addition.MOTIONS, "springs: for more"], "device.length_m", "motions and simulation")),
    ("left-out", "give", ([Addition.DESIGN_POINT, Addition.BALL_MASS], "device.length_m")),
    *(
        (
            "figures/record",
            f"figure_record_{part}",
            ({"impacts": 9, "name": "x.csv", "channels": count, "shaker": shaker},),
        )
        for part in ("caption", "alt")
        for count, shaker in ((1, None), (2, thing()))
    ),
]


@pytest.mark.parametrize("words", dict.fromkeys(words for words, _, _ in SAID))
def test_words_say_what_is_kept(words: str, taken) -> None:
    lines = [f"{macro}: {said(words, macro, *given)}" for of, macro, given in SAID if of == words]
    assert read_back(f"words, {words.replace('/', ' ')}", lines) == []


def test_every_branch_of_the_words_is_said_above(taken) -> None:
    """It says all of it itself, as other tests may run elsewhere."""
    for make in OPENINGS.values():
        opening_of(verdict_of(make())).worded()
    for macro, x in FIGURES:
        of_figure(macro, x)
    for words, macro, given in SAID:
        said(words, macro, *given)
    branches, told = taken()
    of_the_core = {str(file.relative_to(TEMPLATES)) for file in WORDS if file.stem != "tables"}  # read back on pages
    branches = {branch for branch in branches if branch.partition(":")[0] in of_the_core}
    assert branches - told == set()
    decided = {branch.partition(":")[0] for branch in branches}
    assert decided == of_the_core - {
        "words/paper.j2",
        "words/opening.j2",
        "words/changes.j2",
        "words/compare.j2",
        "words/optimise.j2",
        "words/provenance.j2",
        "words/quantities.j2",
        "words/verify.j2",
    }  # Python decides there
