"""What the paper prints, as it prints it: three sweeps, a motion on each, and the slips in the text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vireport.scenario import Parameter

PAPER = (
    "Serdukova, Kuske, Yurchenko: Stability and bifurcation analysis of the period-T motion of a vibroimpact "
    "energy harvester, Nonlinear Dynamics (2019)"
)

RESTITUTION, CAPSULE_MASS, FREQUENCY, GRAVITY = 0.5, 0.1245, 2.0, 9.8
"""Of all figures of the paper."""

NODE, FOCUS, UNSTABLE = "stable node", "stable focus", "unstable node"


@dataclass(frozen=True, slots=True)
class Printed:
    """A motion of Fig. 3 as its caption prints it; numbers are texts, for their digits count.

    Attributes
    ----------
    figure, d, velocity, phi, q, length_m : str
    """

    figure: str
    d: str
    velocity: str
    phi: str
    q: str
    length_m: str


@dataclass(frozen=True, slots=True)
class Phase:
    """A critical point that the paper gives by a phase.

    Attributes
    ----------
    kind : str
        As in `CriticalPoint`.
    letter, printed : str
    impact : str
        ``bottom`` or ``top``: the impact whose phase it is.
    """

    kind: str
    letter: str
    printed: str
    impact: Literal["bottom", "top"]


@dataclass(frozen=True, slots=True)
class Types:
    """A block of Table 1.

    Attributes
    ----------
    family : str
    kind : str
        Of a critical point on that branch.
    words : tuple of str
        Types from small d to large.
    """

    family: str
    kind: str
    words: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Misprint:
    """A slip in the paper's text.

    Attributes
    ----------
    place, printed, meant, why : str
    """

    place: str
    printed: str
    meant: str
    why: str


@dataclass(frozen=True, slots=True)
class Case:
    """One of the paper's three sweeps.

    Attributes
    ----------
    name : str
    inclination_deg : float
    parameter : str
    held : tuple of (str, float)
        The other of length and force.
    phases : tuple of Phase
    letters : tuple of str
        Critical points that have a letter but no number.
    types : tuple of Types
    motion : Printed
    misprints : tuple of Misprint
    """

    name: str
    inclination_deg: float
    parameter: Parameter
    held: tuple[str, float]
    phases: tuple[Phase, ...]
    letters: tuple[str, ...]
    types: tuple[Types, ...]
    motion: Printed
    misprints: tuple[Misprint, ...]


SLIPS = (
    Misprint("(3.10)", "*g*/2", "*ḡ*/2", "(3.4) and (3.6), of which it is made, have ḡ"),
    Misprint(
        "Section 4, Im *λ*",
        "√([4 Det − Tr²]/2)",
        "√(4 Det − Tr²)/2",
        "(4.3); only so is |λ| = √Det = r², as the paper says in the same sentence",
    ),
    Misprint("Table 1; caption of Fig. 4", "Figure 1", "Figure 2", "Figure 1 is the sketch of the device"),
)
"""Slips that bear on every case."""

CASES = (
    Case(
        name="horizontal capsule, F = 3 N, length swept",
        inclination_deg=0.0,
        parameter=Parameter.LENGTH,
        held=("amplitude_n", 3.0),
        phases=(Phase("pitchfork", "C1", "3.66", "top"), Phase("period_doubling", "B1", "3.02", "top")),
        letters=("A1", "A2", "A3"),
        types=(
            Types("symmetric", "pitchfork", (UNSTABLE, NODE, FOCUS)),
            Types("asymmetric", "period_doubling", (UNSTABLE, NODE, FOCUS, NODE)),
        ),
        motion=Printed("Fig. 3(a, b)", "0.3688", "0.7153", "0.5924", "0.5", "0.56"),
        misprints=(
            *SLIPS,
            Misprint(
                "Section 4, C1",
                "saddle-node",
                "pitchfork",
                "the symmetric motion is on both sides of C1 and passes its stability to two asymmetric ones",
            ),
        ),
    ),
    Case(
        name="capsule at 45°, F = 3 N, length swept",
        inclination_deg=45.0,
        parameter=Parameter.LENGTH,
        held=("amplitude_n", 3.0),
        phases=(Phase("period_doubling", "B1", "0.49", "bottom"),),
        letters=(),
        types=(Types("asymmetric", "period_doubling", (UNSTABLE, NODE)),),
        motion=Printed("Fig. 3(c, d)", "0.4604", "1.004", "0.5635", "0.587", "0.69"),
        misprints=SLIPS,
    ),
    Case(
        name="capsule at 45°, s = 0.75 m, force swept",
        inclination_deg=45.0,
        parameter=Parameter.AMPLITUDE,
        held=("length_m", 0.75),
        phases=(Phase("period_doubling", "B1", "0.22", "bottom"),),
        letters=(),
        types=(Types("asymmetric", "period_doubling", (UNSTABLE, NODE)),),
        motion=Printed("Fig. 3(e, f)", "0.2814", "0.726", "0.2101", "0.6507", "0.75"),
        misprints=(
            *SLIPS,
            Misprint(
                "Section 3, period 4",
                "Figure 2 (g) and (h)",
                "Figure 3 (g) and (h)",
                "the phase portraits are in Figure 3",
            ),
        ),
    ),
)
