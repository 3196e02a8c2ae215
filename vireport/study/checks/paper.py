"""The numbers that the paper prints, as it prints them, beside those computed here for the same scenario.

Three sweeps, a motion on each, and the slips in the text, which the report's template words. Our numbers are computed
on the spot. Where they differ from the print by more than the rounding of all its digits leaves open, the row says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from math import floor, pi
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.design.point import around_length
from vireport.design.solution import Solution
from vireport.motions.events import Event
from vireport.motions.one_to_one import motions_of
from vireport.motions.orbits import orbits
from vireport.motions.points import Point, place_at
from vireport.motions.pointwise import find_motions
from vireport.motions.stability import Stability
from vireport.motions.sweep import Sweep
from vireport.physics.motion import Symmetry
from vireport.scenario.parameters import Parameter
from vireport.text.formatting import OF_A_MODEL, Exactness

PAPER = (
    "Serdukova, Kuske, Yurchenko: Stability and bifurcation analysis of the period-T motion of a vibroimpact "
    "energy harvester, Nonlinear Dynamics (2019)"
)

RESTITUTION, CAPSULE_MASS, FREQUENCY, GRAVITY = 0.5, 0.1245, 2.0, 9.8
"""Restitution [-], capsule mass [kg], frequency [Hz] and gravity [m/s^2] of all figures of the paper."""

NODE, FOCUS, UNSTABLE = Stability.STABLE_NODE, Stability.STABLE_FOCUS, Stability.UNSTABLE_NODE


class PrintedMotion(Struct, frozen=True):
    """A motion of Fig. 3 as its caption prints it; numbers are texts, for their digits count."""

    figure: str
    d: str
    velocity: str
    phi: str
    q: str
    length_m: str


class PrintedPhase(Struct, frozen=True):
    """A critical point that the paper gives by the phase at one of its impacts, as printed."""

    kind: Event
    letter: str
    printed: str
    impact: Literal["bottom", "top"]


class PrintedTypes(Struct, frozen=True):
    """A block of Table 1: types from small d to large on the branch that has a critical point of that kind."""

    family: Symmetry
    kind: Event
    words: tuple[Stability, ...]


class Misprint(StrEnum):
    """A slip in the paper's text."""

    GRAVITY = "gravity"
    """(3.10) has g where (3.4) and (3.6) have ḡ."""
    EIGENVALUE = "eigenvalue"
    """Section 4 has the 2 of Im λ under the root, which contradicts (4.3)."""
    FIGURE_1 = "figure_1"
    """Table 1 and Fig. 4 refer to the sketch of the device."""
    SADDLE_NODE = "saddle_node"
    """Section 4 calls C1 a saddle-node, which is a pitchfork."""
    PERIOD_4 = "period_4"
    """Section 3 refers to Figure 2 for phase portraits that are in Figure 3."""


class PaperCase(Struct, frozen=True):
    """One of the paper's three sweeps.

    Attributes
    ----------
    held : tuple of (str, float)
        The other of length and force, and its value.
    letters : tuple of str
        Critical points that have a letter but no number.
    """

    name: Literal["horizontal", "inclined", "forcing"]
    inclination_deg: float
    parameter: Parameter
    held: tuple[str, float]
    phases: tuple[PrintedPhase, ...]
    letters: tuple[str, ...]
    types: tuple[PrintedTypes, ...]
    motion: PrintedMotion
    misprints: tuple[Misprint, ...]


SLIPS = Misprint.GRAVITY, Misprint.EIGENVALUE, Misprint.FIGURE_1
"""Slips that bear on every case."""

CASES = (
    PaperCase(
        name="horizontal",
        inclination_deg=0.0,
        parameter=Parameter.LENGTH,
        held=("amplitude_n", 3.0),
        phases=(
            PrintedPhase(Event.PITCHFORK, "C1", "3.66", "top"),
            PrintedPhase(Event.PERIOD_DOUBLING, "B1", "3.02", "top"),
        ),
        letters=("A1", "A2", "A3"),
        types=(
            PrintedTypes(Symmetry.SYMMETRIC, Event.PITCHFORK, (UNSTABLE, NODE, FOCUS)),
            PrintedTypes(Symmetry.ASYMMETRIC, Event.PERIOD_DOUBLING, (UNSTABLE, NODE, FOCUS, NODE)),
        ),
        motion=PrintedMotion("Fig. 3(a, b)", "0.3688", "0.7153", "0.5924", "0.5", "0.56"),
        misprints=(*SLIPS, Misprint.SADDLE_NODE),
    ),
    PaperCase(
        name="inclined",
        inclination_deg=45.0,
        parameter=Parameter.LENGTH,
        held=("amplitude_n", 3.0),
        phases=(PrintedPhase(Event.PERIOD_DOUBLING, "B1", "0.49", "bottom"),),
        letters=(),
        types=(PrintedTypes(Symmetry.ASYMMETRIC, Event.PERIOD_DOUBLING, (UNSTABLE, NODE)),),
        motion=PrintedMotion("Fig. 3(c, d)", "0.4604", "1.004", "0.5635", "0.587", "0.69"),
        misprints=SLIPS,
    ),
    PaperCase(
        name="forcing",
        inclination_deg=45.0,
        parameter=Parameter.AMPLITUDE,
        held=("length_m", 0.75),
        phases=(PrintedPhase(Event.PERIOD_DOUBLING, "B1", "0.22", "bottom"),),
        letters=(),
        types=(PrintedTypes(Symmetry.ASYMMETRIC, Event.PERIOD_DOUBLING, (UNSTABLE, NODE)),),
        motion=PrintedMotion("Fig. 3(e, f)", "0.2814", "0.726", "0.2101", "0.6507", "0.75"),
        misprints=(*SLIPS, Misprint.PERIOD_4),
    ),
)

SYMMETRIC = 1e-9
"""Largest |q - 1/2| of what is meant to be the symmetric motion."""


class PrintedQuantity(StrEnum):
    """What of a critical point or of the motion of Fig. 3 is compared."""

    POINT_PHASE = "point_phase"
    POINT_D = "point_d"
    VELOCITY = "velocity"
    PHASE = "phase"
    SHARE = "share"
    LENGTH = "length"


class Agreement(StrEnum):
    """How a number of ours stands to the print."""

    TO_ALL_DIGITS = "to_all_digits"
    CUT_OFF = "cut_off"
    """The printed value agrees to all its digits if the print was cut off rather than rounded."""
    ROUNDING_OF_D = "rounding_of_d"
    """The printed value agrees within what the rounding of the printed d leaves open."""
    DIFFERS = "differs"
    NOT_PRINTED = "not_printed"


class ComparedRow(Struct, frozen=True):
    """A number of the paper's, and ours.

    Attributes
    ----------
    quantity : PrintedQuantity
    of : str
        Letter of the critical point, or figure of the motion.
    printed : str
        "" where the paper gives the letter only.
    ours : float
    agreement : Agreement
    d : str
        As printed for the motion, "" for a critical point.
    phase : PrintedPhase or None
        What a phase of a critical point is the phase of.
    mirrored : bool
        Whether it is one of the mirror image.
    """

    quantity: PrintedQuantity
    of: str
    printed: str
    ours: float
    agreement: Agreement
    d: str = ""
    phase: PrintedPhase | None = None
    mirrored: bool = False

    @property
    def agrees(self) -> bool | None:
        """Whether ours agrees with the print; None where there is nothing to compare."""
        return None if self.agreement is Agreement.NOT_PRINTED else self.agreement is not Agreement.DIFFERS

    @property
    def error(self) -> float | Exactness:
        """What ours is rounded by: one digit more is told than is printed."""
        return _half(self.printed) / 10 if self.printed else OF_A_MODEL

    @property
    def gap(self) -> float:
        """The distance of ours from the print."""
        return abs(self.ours - float(self.printed))


class ComparedTypes(Struct, frozen=True):
    """The types of motion along a branch, from small d to large: as Table 1 prints them, and ours."""

    family: Symmetry
    printed: tuple[Stability, ...]
    ours: tuple[Stability, ...]

    @property
    def agrees(self) -> bool:
        """Whether they are the same."""
        return self.printed == self.ours


class PaperComparison(Struct, frozen=True):
    """The paper beside a solution: its numbers, the types of motion along the branches, and the slips in the text."""

    case: str
    rows: tuple[ComparedRow, ...]
    types: tuple[ComparedTypes, ...]
    misprints: tuple[Misprint, ...]


def compare_with_paper(solution: Solution) -> PaperComparison | None:
    """Set the paper's numbers beside ours; None where the scenario is not one of the paper's."""
    for case in CASES:
        if _is_case(solution, case):
            rows = (*_critical_rows(solution, case), *_motion_rows(solution, case))
            return PaperComparison(case.name, rows, tuple(_type_rows(solution, case)), case.misprints) if rows else None
    return None


def _is_case(solution: Solution, case: PaperCase) -> bool:
    device, sweep = solution.device, solution.sweep
    held, value = case.held
    same = (
        device.capsule_mass_kg == CAPSULE_MASS
        and device.restitution == RESTITUTION
        and device.frequency_hz == FREQUENCY
        and device.gravity_m_s2 == GRAVITY
        and device.period_ratio == 1
        and device.inclination_deg == case.inclination_deg
        and getattr(device, held) == value
    )
    if not same or sweep is not None:
        return same and sweep is not None and sweep.parameter is case.parameter
    return _rounds_to(float(device.groups(Parameter.LENGTH, device.length_m)[0]), case.motion.d)


def _decimals(printed: str) -> int:
    return len(printed.partition(".")[2])


def _half(printed: str) -> float:
    """Half a unit of the last digit printed."""
    return 0.5 * 10.0 ** -_decimals(printed)


def _rounds_to(value: float, printed: str) -> bool:
    return f"{value:.{_decimals(printed)}f}" == f"{float(printed):.{_decimals(printed)}f}"


def _agreement(printed: str, ours: float) -> Agreement:
    """Compare a printed number with ours at the printed digits."""
    if _rounds_to(ours, printed):
        return Agreement.TO_ALL_DIGITS
    shift = 10 ** _decimals(printed)
    cut_off = floor(ours * shift) == round(float(printed) * shift)
    return Agreement.CUT_OFF if cut_off else Agreement.DIFFERS


def _critical_rows(solution: Solution, case: PaperCase) -> Iterator[ComparedRow]:
    points = solution.critical_points
    for phase in case.phases:
        candidates = [
            (abs(ours - float(phase.printed)), ours, mirrored, point)
            for point in points
            if point.event is phase.kind
            for ours, mirrored in _phases(point, phase.impact)
        ]
        if not candidates:
            continue
        _, ours, mirrored, point = min(candidates, key=lambda candidate: candidate[0])
        quantity, agreement = PrintedQuantity.POINT_PHASE, _agreement(phase.printed, ours)
        yield ComparedRow(quantity, phase.letter, phase.printed, ours, agreement, phase=phase, mirrored=mirrored)
        yield _letter_row(phase.letter, point)
    for point in points:
        if point.label in case.letters:
            yield _letter_row(point.label, point)


def _letter_row(letter: str, point: Point) -> ComparedRow:
    return ComparedRow(PrintedQuantity.POINT_D, letter, "", point.d, Agreement.NOT_PRINTED)


def _phases(point: Point, impact: str) -> Iterator[tuple[float, bool]]:
    """Phases at an impact: of the motion, and of its mirror image, half a period from the other impact."""
    yield (point.closed.phi_bottom if impact == "bottom" else point.closed.phi_top), False
    if point.mirror is not None:
        other = point.closed.phi_top if impact == "bottom" else point.closed.phi_bottom
        yield (other + pi) % (2 * pi), True


def _motion_rows(solution: Solution, case: PaperCase) -> Iterator[ComparedRow]:
    """The motion of Fig. 3: ours at the printed d, compared within what the rounding of d leaves open."""
    printed, half, d = case.motion, _half(case.motion.d), float(case.motion.d)
    sweep = solution.sweep or around_length(solution.device)
    value = float(sweep.value(d))
    if not min(sweep.start, sweep.end) <= value <= max(sweep.start, sweep.end):
        return
    guess = _stable_motion(sweep, value)
    if guess is None:
        return
    horizontal = case.inclination_deg == 0 and abs(guess[0]) < SYMMETRIC
    near = orbits(np.array([guess[0]]), np.array([guess[1]]), sweep.device.restitution, sweep.device.period_ratio)
    places = [place_at(sweep, float(sweep.value(at)), near, horizontal) for at in (d, d - half, d + half)]
    speeds = [
        float(orbits(*place, sweep.device.restitution, sweep.device.period_ratio).velocity_bottom) for place in places
    ]
    yield _motion_row(PrintedQuantity.VELOCITY, printed, printed.velocity, speeds)
    yield _motion_row(PrintedQuantity.PHASE, printed, printed.phi, [phi for _, phi in places])
    yield _motion_row(PrintedQuantity.SHARE, printed, printed.q, [0.5 + u for u, _ in places])
    if case.parameter is Parameter.LENGTH:
        yield _motion_row(PrintedQuantity.LENGTH, printed, printed.length_m, [value])


def _motion_row(quantity: PrintedQuantity, of: PrintedMotion, printed: str, ours: list[float]) -> ComparedRow:
    """Compare a printed number with ours at the printed d, and at the ends of what that d may stand for, if given."""
    middle, *ends = ours
    row = ComparedRow(quantity, of.figure, printed, middle, _agreement(printed, middle), of.d)
    if not row.agrees and ends and min(ends) - _half(printed) <= float(printed) <= max(ends) + _half(printed):
        return replace(row, agreement=Agreement.ROUNDING_OF_D)
    return row


def _stable_motion(sweep: Sweep, value: float) -> tuple[float, float] | None:
    """U and phase of the first stable motion at a value of the swept parameter."""
    groups = sweep.device.groups(sweep.parameter, value).map_numbers(lambda group: np.array([group], dtype=float))
    motions = motions_of(sweep, find_motions(groups, 1).orbit)
    stable = np.flatnonzero(motions.stable_mask)
    return (float(motions.q[stable[0]]) - 0.5, float(motions.phi_bottom[stable[0]])) if stable.size else None


def _type_rows(solution: Solution, case: PaperCase) -> Iterator[ComparedTypes]:
    points = solution.critical_points
    for types in case.types:
        branch = next((point.families[0] for point in points if point.event is types.kind), None)
        ours = tuple(row.stability for row in solution.table if row.branch == branch)
        if ours:
            yield ComparedTypes(types.family, types.words, ours)
