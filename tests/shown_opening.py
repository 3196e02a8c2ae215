"""What the first page of a report should say: its sentence, its facts and its numbers, from the data of results.json.

What is said is decided here once more, from the numbers of `definitions.py`: a wrong number, word, order or sign fails.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, sqrt
from typing import Any

from definitions import SYMBOLS, mean
from msgspec import Struct
from shown import Amount, Said
from shown_tables import (
    VOLTAGE_LIMITS,
    WORDS_OF,
    Results,
    asked,
    breakdown,
    compliant_end,
    digits_of,
    efficiency,
    gone,
    in_input,
    margin_left,
    model_digits,
    number,
    percentage,
    stable_speeds,
)

SMALL = 0.02
"""What masses and lengths are commonly made to: a smaller margin is one to be careful of."""

DEMONSTRATED = 5.9
"""Area over flat area to which a dielectric elastomer was stretched (Koh and others, 2011)."""

GRAVITY = {"bad": 0, "caution": 1, "good": 2, "neutral": 3}
MARKS = {"bad": "✗", "caution": "!", "good": "✓", "neutral": "i"}

NOUNS = {
    "restitution_bottom": "a bottom membrane that rebounds {} less",
    "restitution_top": "a top membrane that rebounds {} less",
    "second_harmonic": "a second harmonic of {} in the force",
    "friction": "friction of {} on the ball",
    "restitution_exponent": "a rebound that weakens with speed",
}
"""What the model neglects, as part of a sentence."""

MEASURED = {
    "restitution_bottom": "measure the restitution at the bottom",
    "restitution_top": "measure the restitution at the top",
    "second_harmonic": "measure the harmonics of the force",
    "friction": "measure the friction of the ball",
    "restitution_exponent": "measure the restitution at several speeds",
}
"""How to know what is neglected."""

CONTACTS = "Contacts last {} of a period: take stiffer membranes or a lighter ball."

TOLD = ("VR001", "VR003", "VR004", "VR005", "VR010", "VR011", "VR016", "VR017", "VR020", "VR021")
"""Alerts of which facts and tiles have the substance."""


class Expected(Struct, frozen=True):
    """A fact, or the words of a tile, with its status."""

    status: str
    parts: tuple[Said, ...]


def fact(status: str, text: str, *amounts: Amount | str) -> Expected:
    return Expected(status, (Said(text, *amounts),))


class Opening:
    """What the first page should say of a scenario."""

    def __init__(self, x: Results) -> None:
        self.x, self.speeds = x, stable_speeds(x)
        self.rest: dict[str, Any] | None = (x.data["disturbances"] or {}).get("from_rest") if x.design else None
        self.missed = [title for _, title, met in asked(x) if not met]
        self.instead = self._stable_words() if not self.speeds else []
        membrane = x.device.membrane
        fastest = max((max(pair) for pair in self.speeds), default=0.0)
        known = x.device.ball_mass_kg is not None and fastest > 0
        self.depth = x.device.deflection(fastest) if known else 0.0
        self.deep = known and self.depth > membrane["active_radius_m"]
        self.area = sqrt(x.device.gain(fastest) / membrane["bias_voltage_v"] + 1) if known else 1.0
        self.film = known and bool(x.stable) and membrane["thickness_m"] is not None
        self.field = max((breakdown(x, *pair) for pair in x.design_speeds), default=0.0) if self.film else 0.0
        self.efficiency = max((efficiency(x, *pair) for pair in x.design_speeds), default=0.0) if self.film else 0.0
        self.use = margin_to_use(x)

    @property
    def starts(self) -> bool:
        return self.rest is not None and self.rest["outcome"] == "reaches_1_1"

    @property
    def rigid_only(self) -> bool:
        """Whether contacts are long, and the nearest end is not known with the membranes' own stiffness."""
        if not self.x.ending:
            return False
        soft = compliant_end(self.x, self.x.ending[0]["parameter"], self.x.ending[0]["sweep_value"])
        return soft is not None and soft["compliant"] is None

    @property
    def small(self) -> bool:
        return self.use is not None and self.use[1] < SMALL

    @property
    def short(self) -> bool:
        """Whether less margin is left to use than is required of rigid impacts."""
        required = (self.x.scenario["requirements"] or {}).get("margin_any_percent")
        return required is not None and self.use is not None and 100 * self.use[1] < required

    def _stable_words(self) -> list[str]:
        """Words of the families that are stable at the design point."""
        at = getattr(self.x.device, self.x.parameter)
        found = [
            of["word"] for of in self.x.data["families"] or ()
            if at is not None and any(part["from"] < at < part["to"] for part in of["stable_range"])
        ]  # fmt: skip
        return sorted(set(found))

    def sentence(self) -> str:
        x = self.x
        runs = "It runs in part of the sweep" if x.design is None else "It runs"
        if self.starts:
            runs += ", and starts by itself"
        answer = x.data["tolerances"]["answer"] if x.data["tolerances"] is not None else "proved"
        lost = [end for end in (x.data["own_stiffness"] or {"ends": ()})["ends"] if end["compliant"] is None]
        for holds, said in {
            "It does not run: no 1:1 motion is stable.": not self.speeds and not self.instead,
            f"{runs}, but does not meet its requirements.": bool(self.missed),
            "No device does this: its voltage takes more energy than the impacts lose.": self.efficiency > 1,
            f"{runs}, but its voltage breaks the membranes down.": self.field > 1,
            "It runs, but not as a 1:1 motion.": not self.speeds,
            "It runs with rigid membranes, but not with membranes as soft as these.": gone(x),
            "It can run, but does not start by itself.": x.design is not None and not self.starts,
            f"{runs}, but not every device within the tolerances does.": answer == "refuted",
            f"{runs}; for every device within the tolerances that is not decided.": answer != "proved",
            f"{runs}; the margin with soft membranes is not known.": self.rigid_only,
            f"{runs}; the margin to use is less than required.": self.short,
            f"{runs}; no margin is left to use.": self.small and self.use is not None and self.use[1] <= 0,
            f"{runs}; the margin is small.": self.small,
            f"{runs}; a membrane stretches farther than has been demonstrated.": self.area > DEMONSTRATED,
            f"{runs}; where that ends with soft membranes is not known.": bool(lost),
        }.items():
            if said:
                return holds
        return f"{runs}, with margin."

    def facts(self) -> list[Expected]:
        return sorted(self._facts(), key=lambda of: GRAVITY[of.status])[:4]

    def _facts(self) -> Iterator[Expected]:
        x = self.x
        if x.data["requirements"] is not None:
            count = len(x.data["requirements"]["criteria"])
            order = [of["title"].replace("U_ave", "Uave") for of in x.data["requirements"]["criteria"]]
            missed = sorted(self.missed, key=order.index)
            if missed:
                yield fact("bad", f"Requirements not met, {len(missed)} of {count}: {'; '.join(missed)}.")
            elif self.short:
                said = f"All requirements are met ({count}), the margin by rigid impacts only: "
                yield fact("caution", f"{said}margin_with_effects_percent requires more.")
            else:
                yield fact("good", f"All requirements are met ({count}).")
        if (of := x.data["simulation"]) is not None and not of["orbits_checked"]:
            total = sum(motion["count"] for motion in of["motions"])
            most = max(of["motions"], key=lambda motion: motion["count"])
            often = "forcing period" if most["period"] == 1 else f"{most['period']} forcing periods"
            said = f"Of {total} simulated starts {most['count']} end in {most['word']} every {often}."
            yield fact("neutral", said)
        yield from self._motion()
        yield from self._margin()
        yield from self._tolerances()
        yield from self._voltage()
        for alert in x.data["alerts"]:
            if alert["severity"] != "note" and alert["code"] not in TOLD:
                yield fact("caution", f"{alert['code']}: {alert['title'].replace('U_ave', 'Uave')}.")
        yield from self._disturbances()

    def _voltage(self) -> Iterator[Expected]:
        if self.efficiency > 1:
            share = Amount(100 * self.efficiency, "%", 3)
            yield fact("bad", "Lower the bias voltage: it takes {} of the energy that the impacts lose.", share)
        if self.field > 1:
            said = "The field is {} times the breakdown field: take a thicker membrane."
            yield fact("bad", said, number(self.field, 3))
        if self.deep and max(self.field, self.efficiency) <= 1:
            do = "test them at that stretch" if self.film else "state the thickness to check field and energy"
            said = f"The ball presses the membranes {{}} deep and stretches them to {{}} times their area: {do}."
            status = "caution" if self.area > DEMONSTRATED else "neutral"
            yield fact(status, said, Amount(self.depth, "m", 2), number(self.area, 2))

    def _motion(self) -> Iterator[Expected]:
        each = "The ball strikes each membrane once per period"
        if self.speeds:
            if self.x.design is None or self.starts:
                yield fact("good", f"{each}.")
            elif self.x.scenario["disturbances"] is None:
                yield fact(
                    "caution", "A force that rises slowly may start it: add disturbances: to the scenario to know."
                )
            else:
                if (ramp := self.rest["ramp_that_reaches_1_1"]) is not None:
                    said = f"Raise the force over {ramp['periods']} periods: then it starts at every moment tried."
                    yield fact("caution", said)
            return
        if self.instead:
            yield fact("caution", f"Stable instead of 1:1: {', '.join(self.instead)}.")
        else:
            yield fact("caution", "Change another input: vireport map shows where 1:1 motion is stable.")

    def ending(self) -> str:
        """What the ball comes to from rest, where that is no 1:1 motion."""
        of = self.rest
        if of["outcome"] == "rest_cycle" and not of["word"]:
            return "keeps coming to rest, at irregular times"
        often = "forcing period" if of["periods"] == 1 else f"{of['periods']} forcing periods"
        if of["outcome"] == "rest_cycle":
            return f"comes to rest every {often} ({of['word']})"
        return f"comes to {of['word']} every {often}"

    def _margin(self) -> Iterator[Expected]:
        if gone(self.x):
            motion = self.x.data["own_stiffness"]["motion"]
            if motion is None:
                yield fact("caution", "Contacts are long: take stiffer membranes or a lighter ball.")
            else:
                yield fact("caution", CONTACTS, percentage(motion["contact_share"]))
        if self.rigid_only and (own := self.x.data["own_stiffness"])["motion"] is not None:
            yield fact("caution", CONTACTS, percentage(own["motion"]["contact_share"]))
        if self.use is None or not (self.small or self.short) or gone(self.x):
            return
        parameter, room, limit, shift = self.use
        ways = {"rigid": "", "compliant": ", or take stiffer membranes"}
        if limit == "effect":
            recoil = "does not recoil" if self.x.device.free else "recoils"
            check = MEASURED.get(shift["effect"], f"compute with a capsule that {recoil}")
            if room == -inf:
                yield fact("caution", f"{check[0].upper()}{check[1:]}: stable motion depends on it.")
                return
            ways["effect"] = f", or {'measure it' if shift['effect'] == parameter else check}"
        yield fact("caution", f"{self.way(parameter)} for more margin{ways[limit]}.")

    def way(self, parameter: str) -> str:
        """Away from the nearest end, unless there is one on the other side that is near, too."""
        at, quantity = getattr(self.x.device, parameter), SYMBOLS[parameter][0]
        near = self.x.ending[0]["sweep_value"] - at
        others = (end["sweep_value"] - at for end in self.x.ending if end["parameter"] == parameter)
        if any(other * near < 0 and abs(other) < 2 * SMALL * at for other in others):
            return f"Change another input than the {quantity}"
        return f"{'Increase' if near < 0 else 'Reduce'} the {quantity}"

    def noun(self, shift: dict[str, Any]) -> tuple[str, list[Amount]]:
        """A neglected effect as part of a sentence, and its size."""
        if shift["effect"] == "capsule":
            return f"a capsule that {'does not recoil' if self.x.device.free else 'recoils'}", []
        noun, size = NOUNS[shift["effect"]], abs(shift["change"])
        amount = number(size, 2) if shift["effect"] == "friction" else percentage(size)
        return noun, [amount] * noun.count("{}")

    def place(self, end: dict[str, Any]) -> Amount:
        parameter, value = end["parameter"], end["sweep_value"]
        return in_input(parameter, value, digits_of(self.x, parameter, value, 3))

    def _tolerances(self) -> Iterator[Expected]:
        of = self.x.data["tolerances"]
        if of is None:
            return
        count, stable = of["yield"]["samples"], of["yield"]["stable"]
        if of["answer"] == "proved":
            yield fact("good", "Every device within the tolerances keeps this motion: proved.")
        elif stable == count:
            said = f"All {count} devices tried within the tolerances keep it (at least {{}} do)."
            yield fact("caution", said, percentage(of["yield"]["low_95"]))
        elif stable:
            yield fact("caution", f"Of {count} devices tried within the tolerances, {stable} keep it.")
        else:
            yield fact("caution", f"None of {count} devices tried within the tolerances keeps it.")

    def _disturbances(self) -> Iterator[Expected]:
        found = self.x.data["disturbances"] or {"shock": None, "jitter": None}
        limits = self.x.scenario["requirements"] or {}
        if self.speeds and (of := found["shock"]) is not None and of["least_jump_m_s"] is not None:
            least = limits.get("survives_shock_m_s")
            status = "neutral" if least is None else "good" if of["least_jump_m_s"] >= least else "bad"
            yield fact(status, "It withstands bumps below {}.", Amount(of["least_jump_m_s"], "m/s", 2))
        if self.speeds and (of := found["jitter"]) is not None and of["valid"]:
            spread = Amount(of["phase_deg"], "°", 2), Amount(of["velocity_m_s"], "m/s", 2)
            most = limits.get("phase_jitter_at_most_deg")
            status = "bad" if most is not None and of["phase_deg"] > most else "neutral"
            yield fact(status, "Random kicks spread the impacts by {} and {}.", *spread)
        basin = (self.x.data["simulation"] or {"basin": None})["basin"]
        if self.speeds and basin is not None:
            said = f"{basin['reached']} of {basin['trials']} random starts come to this motion."
            yield fact("caution" if basin["elsewhere"] else "good", said)

    def tiles(self) -> Iterator[Expected]:
        if (where := self._where()) is not None:
            yield where
        if self.speeds and self.x.design is not None:
            yield self._margin_tile()
        if self.rest is not None:
            yield self._rest_tile()
        yield self._voltage_tile()

    def _where(self) -> Expected | None:
        x = self.x
        label = Said(f"Stable {SYMBOLS[x.parameter][0]}")
        if x.sweep is None:
            if not self.speeds:
                return None
            parameter = x.ending[0]["parameter"]
            part = next(of for of in x.design["stable_range"] if of["parameter"] == parameter)
            kinds = {"": ""} | {_label(of): WORDS_OF[of["kind"]] for of in x.design["margins"]}
            label = Said(f"Stable {SYMBOLS[parameter][0]}")
            return Expected("good", (label, *_between(x, parameter, part, kinds)))
        if not x.data["stable_range"]:
            ends = (in_input(x.parameter, x.sweep[end]) for end in ("from", "to"))
            return Expected("neutral" if self.instead else "bad", (label, Said("none"), Said("{} to {} swept", *ends)))
        (part,) = x.data["stable_range"]
        kinds = {of["label"]: WORDS_OF[of["kind"]] for of in x.points}
        return Expected("good" if self.speeds else "caution", (label, *_between(x, x.parameter, part, kinds)))

    def _margin_tile(self) -> Expected:
        parameter, room, limit, shift = self.use
        missed = {key for key, _, met in asked(self.x) if not met}
        held = any(key.startswith(("margin_", "withstands")) for key in missed)
        status = "bad" if held else "caution" if self.small or self.short or self.rigid_only else "good"
        value = Said("none") if room <= 0 else Said(f"{{}} in {SYMBOLS[parameter][0]}", percentage(room))
        if limit == "effect":
            noun, sizes = self.noun(shift)
            remark = Said(f"with {noun}", *sizes)
        elif limit == "compliant":
            remark = Said("with soft membranes")
        elif self.rigid_only:
            return Expected(status, (Said("Margin, rigid membranes"), value, Said("with soft ones not known")))
        else:
            remark = Said("ends at {}", self.place(self.x.ending[0]))
        return Expected(status, (Said("Margin to use"), value, remark))

    def _rest_tile(self) -> Expected:
        label = Said("From rest")
        if not self.starts:
            return Expected("caution", (label, Said("not 1:1"), Said(f"the ball {self.ending()}")))
        count, alone = self.rest["settles_after_periods"], self.x.data["simulation"] is not None
        after = Amount(count / self.x.device.frequency_hz, "s", 2)
        remark = Said("{} until it has settled" if alone else "{}; a simulation agrees", after)
        return Expected("good", (label, Said("{} periods", number(count)), remark))

    def _voltage_tile(self) -> Expected:
        label, x = Said("Mean voltage"), self.x
        if x.device.ball_mass_kg is None:
            return Expected("neutral", (label, Said("not evaluated"), Said("needs device.ball_mass_kg")))
        if not self.speeds:
            return Expected("neutral", (label, Said("none"), Said("no stable 1:1 motion")))
        volts = [mean([x.device.gain(v) for v in pair]) for pair in self.speeds]
        if max(self.field, self.efficiency) > 1:
            remark = Said("by the paper’s formulae: {}", Amount(max(volts), "V", 3))
            return Expected("bad", (label, Said("impossible"), remark))
        status = "good" if not self.deep else "caution" if self.area > DEMONSTRATED else "neutral"
        if any(key in VOLTAGE_LIMITS for key, _, met in asked(x) if not met):
            status = "bad"
        remark = Said(f"by the paper’s formulae{', extrapolated' if self.deep else ''}")
        if max(volts) < min(volts) * (1 + 1e-6):
            return Expected(status, (label, Said("{}", Amount(volts[0], "V", model_digits(x))), remark))
        ends = Amount(min(volts), "V", 3), Amount(max(volts), "V", 3)
        return Expected(status, (label, Said("{} to {}", *ends), remark))


def _label(margin: dict[str, Any]) -> str:
    return margin["label"] or WORDS_OF[margin["kind"]]


def _between(x: Results, parameter: str, part: dict[str, Any], kinds: dict[str, str]) -> tuple[Said, Said]:
    """A stable range and what ends it: the end of a sweep belongs to it, a critical point does not."""
    low, high = (in_input(parameter, part[end], digits_of(x, parameter, part[end], 3)) for end in ("from", "to"))
    ends = [kinds.get(part[f"{end}_reason"]) for end in ("from", "to")]
    if None not in ends:
        return Said("{} to {}", low, high), Said(f"from {ends[0]} to {ends[1]}")
    if ends[0] is not None:
        return Said("above {}", low), Said("up to {}, the end of the sweep", high)
    if ends[1] is not None:
        return Said("below {}", high), Said("from {}, the start of the sweep", low)
    return Said("{} to {}", low, high), Said("the whole sweep")


def margin_to_use(x: Results) -> tuple[str, float, str, dict[str, Any] | None] | None:
    """The least of the margins: in what input, over the design value, what limits it, and with which effect."""
    if not x.ending:
        return None
    end, of = x.ending[0], x.data["effects"]
    parameter = end["parameter"]
    at = getattr(x.device, parameter)
    choices = [(abs(end["sweep_value"] - at) / at, "rigid", parameter, None)]
    soft = compliant_end(x, parameter, end["sweep_value"])
    if gone(x):
        choices.append((-inf, "compliant", parameter, None))
    elif soft is not None and soft["compliant"] is not None:
        towards = (soft["compliant"] - at) / (end["sweep_value"] - at)
        choices.append((towards * choices[0][0], "compliant", parameter, None))
    for shift in of["rows"]:
        room = inf if shift["stable"] is None else margin_left(x, shift)
        choices.append((room, "effect", of["parameter"], shift))
    room, limit, parameter, shift = min(choices, key=lambda choice: choice[0])
    return parameter, room, limit, shift


def opening_faults(x: Results, said: list[list[str]], tiles: list[list[str]]) -> Iterator[str]:
    """What is wrong with the facts and the numbers of a first page, each with its status."""
    expected = Opening(x)
    for shown, held in zip(said, facts := expected.facts(), strict=False):
        yield from _faults(shown, held, MARKS[held.status])
    if len(said) != len(facts):
        yield f"{len(said)} facts, and not {len(facts)}"
    numbers = list(expected.tiles())
    for shown, held in zip(tiles, numbers, strict=False):
        yield from _faults(shown, held)
    if len(tiles) != len(numbers):
        yield f"{len(tiles)} numbers, and not {len(numbers)}"


def _faults(shown: list[str], held: Expected, mark: str = "") -> Iterator[str]:
    status, *texts = shown
    if status != held.status:
        yield f"{texts}: {status}, and not {held.status}"
    for text, of in zip(texts, held.parts, strict=True):
        if not text.startswith(mark):
            yield f"{text!r} has not the mark {mark}"
        if wrong := of.faults(text.removeprefix(mark), whole=True):
            yield f"{text!r}: {wrong}"


def margin_faults(x: Results) -> Iterator[str]:
    """What is wrong with `margin_to_use` of results.json."""
    told, use = x.data["margin_to_use"], margin_to_use(x)
    if use is None or told is None:
        if use is not told:
            yield f"{told}, and not {use}"
        return
    parameter, room, limit, shift = use
    expected = {"parameter": parameter, "limited_by": limit, "gone": limit != "rigid" and room <= 0}
    expected |= {key: shift and shift[key] for key in ("effect", "change")}
    if (room == -inf and told["relative"] is not None) or (room > -inf and abs(told["relative"] - room) > 1e-9):
        yield f"a margin of {told['relative']}, and not {room}"
    for key, value in expected.items():
        if told[key] != value:
            yield f"{key} is {told[key]}, and not {value}"
