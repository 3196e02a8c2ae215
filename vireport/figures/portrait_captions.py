"""Captions and alternative texts of the figures that come from simulation alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from string import ascii_lowercase
from typing import TYPE_CHECKING

import numpy as np

from vireport.figures.captions import conditions
from vireport.figures.traces import (
    MOST_WORDS,
    Floats,
    Group,
    irregular,
    is_word,
    motion_words,
    periodic_groups,
    setting,
)
from vireport.study import Study
from vireport.text import significant

if TYPE_CHECKING:
    from vireport.simulation import Diagram, Portrait

PORTRAIT_TITLES = {
    "figure-3": "Phase portraits and time series",
    "figure-6": "Displacement of the capsule and the ball",
    "figure-diagram": "Bifurcation diagram by simulation",
}

ABOUT = {
    "figure-3": "Simulated motions. Left: relative velocity Ż over relative position Z = X − x, with the bottom "
    "membrane at Z = +d/2 and the top one at −d/2; right: the same velocity over time. Dashed: Ż → −r Ż at an impact. "
    "Circles, blue: impacts on the bottom; triangles, green: on the top, both just before the rebound. Units: "
    "F/(4 M f²) of length and F/(2 M f) of velocity.",
    "figure-6": "Simulated motions. Blue: ends of the capsule X ± d/2, thick at the bottom; red: the ball x, which "
    "touches them at the impacts (circles: bottom, triangles: top). X is taken without drift; "
    "unit F/(4 M f²).",
}

MOST_SPEEDS = 6
"""Impact velocities that are told one by one."""


def portrait_caption(name: str, portraits: Sequence[Portrait], held: str) -> str:
    """The caption of figure 3 or 6: what is drawn, and each motion in numbers.

    Parameters
    ----------
    name : str
    portraits : sequence of Portrait
    held : str
        The parameters that they share, in words.
    """
    return " ".join([ABOUT[name], *([f"{held}."] if held else []), *_motions(name, portraits)])


def portrait_alt(name: str, portraits: Sequence[Portrait]) -> str:
    """A description of figure 3 or 6 for those who do not see it."""
    kind = "phase portrait and time series" if name == "figure-3" else "displacement of capsule and ball over time"
    if not portraits:
        return f"Empty: no {kind} was asked for."
    return " ".join(
        [f"Line charts, {kind} of {_count(len(portraits), 'simulated motion')}.", *_motions(name, portraits)]
    )


def diagram_caption(study: Study, diagram: Diagram, values: Floats) -> str:
    """The caption of the diagram: what is drawn, and at how many values each motion was found."""
    about = (
        "Velocity |Ż| of every impact of the motions that the simulation ends on, by the word of the motion: B and T "
        "are the impacts of a period on the bottom and on the top, ~ chatter that ends in sticking. Filled: bottom; "
        "open: top. Thin lines: the stable 1:1 motion by the formulae."
    )
    level = ["Where both impacts are equally fast, filled markers cover open ones."]
    return " ".join(
        [about, *(level if study.solution.horizontal else []), f"{conditions(study)}.", *_found(study, diagram, values)]
    )


def diagram_alt(study: Study, diagram: Diagram, values: Floats) -> str:
    """A description of the diagram for those who do not see it."""
    swept = study.solution.sweep.parameter.quantity if study.solution.sweep else "swept parameter"
    return " ".join(
        [f"Scatter chart of impact velocities over the {swept}, by simulation.", *_found(study, diagram, values)]
    )


def _motions(name: str, portraits: Sequence[Portrait]) -> Iterator[str]:
    """Each motion in numbers, with the letters of its panels."""
    letters = [letter * (k + 1) for k in range(3) for letter in ascii_lowercase]
    for k, portrait in enumerate(portraits):
        panels = f"{letters[2 * k]}, {letters[2 * k + 1]}" if name == "figure-3" else letters[k]
        yield f"({panels}) {setting(portrait)}: {motion_words(portrait)}{_numbers(portrait)}."


def _numbers(portrait: Portrait) -> str:
    """Impact velocities, the phase of the first impact, how well the motion repeats and how fast it attracts."""
    cycle, found = portrait.attractor.cycle, portrait.attractor
    if cycle is None:
        finite = np.isfinite(found.lyapunov)
        return f", Lyapunov exponent {significant(found.lyapunov, 3)} per forcing period" if finite else ""
    first = int(np.argmax(cycle.wall > 0))
    speeds = np.abs(np.roll(cycle.velocity, -first))
    if len(speeds) <= MOST_SPEEDS:
        told = f"|Ż| = {', '.join(significant(float(speed), 5) for speed in speeds)}"
    else:
        low, high = (significant(float(end), 4) for end in (speeds.min(), speeds.max()))
        told = f"{len(speeds)} impacts, |Ż| from {low} to {high}"
    text = f", {told}, φ = {significant(float(cycle.phase[first]), 5)} rad, residual {significant(cycle.residual, 2)}"
    return text if cycle.sticks else f"{text}, largest |λ| = {significant(cycle.growth, 3)}"


def _found(study: Study, diagram: Diagram, values: Floats) -> Iterator[str]:
    """At how many values each motion was found, and where."""
    words, other = periodic_groups(diagram, MOST_WORDS)
    groups = [group for group in (*words, *([other] if other else []), irregular(diagram)) if len(group.values)]
    if not groups:
        yield "No motion was found that has impacts."
        return
    told = "; ".join(_where(study, group, values) for group in groups)
    yield f"Motions at {_count(len(values), 'value')}: {told}."
    others = [label for label in diagram.labels if not is_word(label) and "periodic" not in label]
    if others:
        yield f"From some starts the ball ends {', or '.join(others)}, which has no impacts."


def _where(study: Study, group: Group, values: Floats) -> str:
    low, high = float(values[group.values].min()), float(values[group.values].max())
    swept = study.solution.sweep.parameter if study.solution.sweep else None
    if swept is None:
        return group.name
    span = swept.with_unit(significant(low, 4))
    if high > low:
        span = f"{significant(low, 4)} to {swept.with_unit(significant(high, 4))}"
    return f"{group.name} at {len(group.values)} ({swept.symbol} = {span})"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"
