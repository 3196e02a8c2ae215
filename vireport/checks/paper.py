"""The numbers that the paper prints, as it prints them, beside those computed here for the same scenario.

Three sweeps, a motion on each, and the slips in the text. Our numbers are computed on the spot. Where they differ from
the print by more than the rounding of all its digits leaves open, the row says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import floor, pi
from typing import Literal

import numpy as np

from vireport.design import Solution, around_length
from vireport.motions import (
    FARTHEST,
    Event,
    Point,
    Stability,
    Sweep,
    Symmetry,
    find_motions,
    motions_of,
    orbits,
    place_at,
)
from vireport.scenario import Parameter
from vireport.text import ABSENT, significant

PAPER = (
    "Serdukova, Kuske, Yurchenko: Stability and bifurcation analysis of the period-T motion of a vibroimpact "
    "energy harvester, Nonlinear Dynamics (2019)"
)

RESTITUTION, CAPSULE_MASS, FREQUENCY, GRAVITY = 0.5, 0.1245, 2.0, 9.8
"""Of all figures of the paper."""

NODE, FOCUS, UNSTABLE = Stability.STABLE_NODE, Stability.STABLE_FOCUS, Stability.UNSTABLE_NODE


@dataclass(frozen=True, slots=True)
class PrintedMotion:
    """A motion of Fig. 3 as its caption prints it; numbers are texts, for their digits count."""

    figure: str
    d: str
    velocity: str
    phi: str
    q: str
    length_m: str


@dataclass(frozen=True, slots=True)
class PrintedPhase:
    """A critical point that the paper gives by the phase at one of its impacts, as printed."""

    kind: Event
    letter: str
    printed: str
    impact: Literal["bottom", "top"]


@dataclass(frozen=True, slots=True)
class PrintedTypes:
    """A block of Table 1: types from small d to large on the branch that has a critical point of that kind."""

    family: Symmetry
    kind: Event
    words: tuple[Stability, ...]


@dataclass(frozen=True, slots=True)
class Misprint:
    """A slip in the paper's text: where it is, what it should say, and why."""

    place: str
    printed: str
    meant: str
    why: str


@dataclass(frozen=True, slots=True)
class PaperCase:
    """One of the paper's three sweeps.

    Attributes
    ----------
    held : tuple of (str, float)
        The other of length and force, and its value.
    letters : tuple of str
        Critical points that have a letter but no number.
    """

    name: str
    inclination_deg: float
    parameter: Parameter
    held: tuple[str, float]
    phases: tuple[PrintedPhase, ...]
    letters: tuple[str, ...]
    types: tuple[PrintedTypes, ...]
    motion: PrintedMotion
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
    PaperCase(
        name="horizontal capsule, F = 3 N, length swept",
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
    PaperCase(
        name="capsule at 45°, F = 3 N, length swept",
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
        name="capsule at 45°, s = 0.75 m, force swept",
        inclination_deg=45.0,
        parameter=Parameter.AMPLITUDE,
        held=("length_m", 0.75),
        phases=(PrintedPhase(Event.PERIOD_DOUBLING, "B1", "0.22", "bottom"),),
        letters=(),
        types=(PrintedTypes(Symmetry.ASYMMETRIC, Event.PERIOD_DOUBLING, (UNSTABLE, NODE)),),
        motion=PrintedMotion("Fig. 3(e, f)", "0.2814", "0.726", "0.2101", "0.6507", "0.75"),
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

SYMMETRIC = 1e-9
"""Largest |q - 1/2| of what is meant to be the symmetric motion."""

LETTER_ONLY = "the paper gives the letter only"


@dataclass(frozen=True, slots=True)
class PaperComparison:
    """The paper beside a solution: its numbers, the types of motion along the branches, and the slips in the text."""

    case: str
    rows: tuple[ComparedRow, ...]
    types: tuple[ComparedRow, ...]
    misprints: tuple[Misprint, ...]


@dataclass(frozen=True, slots=True)
class ComparedRow:
    """A number of the paper's, and ours; `agrees` is None where there is nothing to compare."""

    quantity: str
    printed: str
    ours: str
    remark: str
    agrees: bool | None


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


def _row(quantity: str, printed: str, ours: float, remark: str = "") -> ComparedRow:
    """Compare a printed number with ours at the printed digits."""
    agrees, verdict = True, "to the digits printed"
    if not _rounds_to(ours, printed):
        shift = 10 ** _decimals(printed)
        agrees = floor(ours * shift) == round(float(printed) * shift)
        gap = significant(abs(ours - float(printed)), 2)
        verdict = "the print is cut off, not rounded" if agrees else f"by {gap}"
    remarks = "; ".join(filter(None, (verdict, remark)))
    return ComparedRow(quantity, printed, significant(ours, 8), remarks, agrees)


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
        where = f"phase at the {phase.impact} impact{' of the mirror image' if mirrored else ''}"
        kind = "the paper's saddle-node is a pitchfork" if phase.kind is Event.PITCHFORK else ""
        yield _row(f"{phase.letter}: *φ*", phase.printed, ours, "; ".join(filter(None, (where, kind))))
        yield _letter_row(phase.letter, point)
    for point in points:
        if point.label in case.letters:
            yield _letter_row(point.label, point)


def _letter_row(letter: str, point: Point) -> ComparedRow:
    return ComparedRow(f"{letter}: *d*", ABSENT, significant(point.d, 10), LETTER_ONLY, None)


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
    value = float(sweep.value(d, None))
    if not min(sweep.start, sweep.end) <= value <= max(sweep.start, sweep.end):
        return
    guess = _stable_motion(sweep, value)
    if guess is None:
        return
    horizontal = case.inclination_deg == 0 and abs(guess[0]) < SYMMETRIC
    near = orbits(np.array([guess[0]]), np.array([guess[1]]), sweep.device.restitution, sweep.device.period_ratio)
    places = [
        place_at(sweep, float(sweep.value(at, None)), near, horizontal, FARTHEST) for at in (d, d - half, d + half)
    ]
    speeds = [
        float(orbits(*place, sweep.device.restitution, sweep.device.period_ratio).velocity_bottom) for place in places
    ]
    head = f"{printed.figure}, *d* = {printed.d}: "
    yield _motion_row(f"{head}*Ż*_B", printed.velocity, speeds)
    yield _motion_row(f"{head}*φ*", printed.phi, [phi for _, phi in places])
    yield _motion_row(f"{head}*q*", printed.q, [0.5 + u for u, _ in places])
    if case.parameter is Parameter.LENGTH:
        yield _row(f"{head}*s* [m]", printed.length_m, value, "take *d*, which has more digits")


def _motion_row(quantity: str, printed: str, ours: list[float]) -> ComparedRow:
    """Compare a printed number with ours at the printed d, and at the ends of what that d may stand for."""
    middle, *ends = ours
    row = _row(quantity, printed, middle)
    if not row.agrees and min(ends) - _half(printed) <= float(printed) <= max(ends) + _half(printed):
        return replace(row, remark="within the rounding of that *d*", agrees=True)
    return row


def _stable_motion(sweep: Sweep, value: float) -> tuple[float, float] | None:
    """U and phase of the first stable motion at a value of the swept parameter."""
    d, gbar = (np.array([group], dtype=float) for group in sweep.device.groups(sweep.parameter, value))
    motions = motions_of(sweep, sweep.level, find_motions(d, gbar, sweep.device.restitution, 1).orbit)
    stable = np.flatnonzero(motions.stable)
    return (float(motions.q[stable[0]]) - 0.5, float(motions.phi_bottom[stable[0]])) if stable.size else None


def _type_rows(solution: Solution, case: PaperCase) -> Iterator[ComparedRow]:
    points = solution.critical_points
    for types in case.types:
        branch = next((point.families[0] for point in points if point.event is types.kind), None)
        ours = tuple(row.stability for row in solution.table if row.branch == branch)
        if ours:
            agrees = ours == types.words
            remark = "" if agrees else "the sweep, or grazing, cuts the row"
            name = f"{types.family.capitalize()}, *d* rising"
            yield ComparedRow(name, ", ".join(types.words), ", ".join(ours), remark, agrees)
