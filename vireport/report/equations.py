"""The equations of the report: which of them a study used, in what order, and what is to be said about them.

The equations themselves are written once, in tools/equations.typ, of which templates/equations.json is made.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache

from vireport.analysis import Held
from vireport.report.pages import Block, Equation, Paragraph, Subheading
from vireport.report.rendering import TEMPLATES
from vireport.study import Study
from vireport.text import Table, texts

CLOSED_FORM = (
    "Closed form",
    "Solved for *ḡ* and *Ż*_B at any *q* and *φ*, with *d* from (3.11): every motion there is, without a "
    "starting guess.",
    ("determinant", "closed-gravity", "closed-velocity"),
)

GROUPS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    (
        "Model",
        "The capsule shakes with *F* cos(*ωτ*), the ball slides in it; *Z* is the capsule's position less "
        "the ball's. Impact velocities without a sign are those just before the impact.",
        (
            "groups-units",
            "groups",
            "relative-motion",
            "walls",
            "impact",
            "flight-velocity",
            "flight-position",
        ),
    ),
    (
        "Periodic motion",
        "One impact at the bottom (B) and one at the top (T) in every *n* forcing periods. Given *q*, the "
        "conditions are linear in *Ż*_B, sin *φ*, cos *φ*, *ḡ* and *d*.",
        ("times", "velocity-top", "periodic-velocity", "periodic-phase", "periodic-length"),
    ),
    CLOSED_FORM,
    (
        "Admissibility",
        "The conditions know only the ends of a flight; the ball has to stay between the membranes on the way.",
        ("admissibility",),
    ),
    (
        "Stability",
        "The flight from the top to the bottom has the same derivatives with *T*_d and the phases of the "
        "other impact. The determinant being *r*⁴, the trace decides everything.",
        ("return-map", "jacobian-time", "jacobian-velocity", "eigenvalues", "criteria"),
    ),
)
"""Subject, text, and names of the equations."""

ENERGY = (
    "Impact voltage",
    "In SI units, for each impact.",
    ("average-voltage", "impact-voltage", "membrane-area", "contact-angle", "deflection"),
)

NOTES = {
    "periodic-phase": "As printed, (3.10) has *g*/2 for *ḡ*/2, and divides by *r T*_u − *T*_d, which is zero "
    "at *q* = 1/(1 + *r*).",
    "eigenvalues": "Where *Δ* < 0: Re *λ* = Tr/2 and Im *λ* = √(4 Det − Tr²)/2; the paper prints the 2 under the root.",
    "determinant": "The determinant of the linear system; it vanishes for no *q* and no *r* < 1.",
    "contact-angle": "A factor 2 of numerator and denominator is cancelled.",
}

LEVELS = {
    Held.GBAR: "The sweep holds *ḡ*: its motions are the level curve of *ḡ*(*q*, *φ*).",
    Held.RATIO: "The sweep holds *d*/*ḡ*: its motions are the level curve of that ratio over (*q*, *φ*).",
    Held.D: "The sweep holds *d*: its motions are the level curve of *d*(*q*, *φ*).",
}

SYMBOLS = (
    ("*M*, *m*", "mass of the capsule, of the ball", "kg"),
    ("*s*", "distance between the membranes", "m"),
    ("*β*", "inclination to the horizontal", "rad"),
    ("*F*, *ω*", "amplitude and angular frequency of the force", "N, rad/s"),
    ("*r*", "coefficient of restitution", ""),
    ("*Z*, *t*", "relative position, time", "*x*_c, *t*_c"),
    ("*Ż*_B, *Ż*_T", "velocities before the bottom and the top impact", "*y*_c"),
    ("*φ*_B = *φ*, *φ*_T", "phases of the forcing at these impacts", "rad"),
    ("*q*", "share of the period that the flight from bottom to top takes", ""),
    ("*d*, *ḡ*", "the two dimensionless groups", ""),
    ("*λ*, *Δ*", "eigenvalues of *DP*, and their discriminant", ""),
)

ENERGY_SYMBOLS = (
    ("*V*, *δ*, *α*", "impact speed, deflection, angle at which membrane and ball part", "m/s, m, rad"),
    ("*K*, *h*", "of the membrane's force *K δ*ʰ", "N/mʰ, 1"),
    ("*R*_c, *r*_b", "radius of the membrane's active area, of the ball", "m"),
    ("*U*_in, *U*_imp", "bias voltage, voltage at the largest deflection", "V"),
)


def equations(study: Study) -> Iterator[Block]:
    """The equations that a study used, by subject, and the symbols in them."""
    markup = _markup()
    energy = study.solution.membrane is not None
    diagram = study.solution.diagram
    for group in (*GROUPS, ENERGY) if energy else GROUPS:
        title, text, names = group
        yield Subheading(title)
        held = diagram.curve.level.held if group is CLOSED_FORM and diagram is not None else None
        yield Paragraph(f"{text} {LEVELS[held]}" if held is not None else text)
        for name in names:
            yield Equation(name=name, note=NOTES.get(name, ""), **markup[name])
    rows = (*SYMBOLS, *ENERGY_SYMBOLS) if energy else SYMBOLS
    yield Table("Symbols", texts("Symbol", "Meaning", "Unit"), rows)


@cache
def _markup() -> dict[str, dict[str, str]]:
    """Number, words and markup of each equation, by its name."""
    equations: dict[str, dict[str, str]] = json.loads((TEMPLATES / "equations.json").read_text(encoding="utf-8"))
    return equations
