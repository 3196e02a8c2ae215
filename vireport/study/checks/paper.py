"""The numbers that the paper prints, as it prints them, beside those computed here for the same scenario.

Three sweeps, the motions on them, and the slips in the text, which templates word. Our numbers are computed on the
spot. Where they differ from the print by more than the rounding of all its digits leaves open, the row says so.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum
from math import floor, pi
from typing import Literal, NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.design.point import around_length
from vireport.design.solution import Solution
from vireport.motions.diagram import TableRow
from vireport.motions.events import Event
from vireport.motions.one_to_one import motions_of
from vireport.motions.orbits import orbits
from vireport.motions.points import Point, place_at
from vireport.motions.pointwise import find_motions
from vireport.motions.stability import Stability, determinant_of
from vireport.motions.sweep import Sweep
from vireport.physics.motion import Symmetry
from vireport.physics.numbers import wrapped
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import BOTTOM, Impact
from vireport.text.formatting import OF_A_MODEL, Exactness

PAPER = (
    "Serdukova, Kuske, Yurchenko: Stability and bifurcation analysis of the period-T motion of a vibroimpact "
    "energy harvester, Nonlinear Dynamics (2019)"
)

RESTITUTION, CAPSULE_MASS, FREQUENCY, GRAVITY = 0.5, 0.1245, 2.0, 9.8
"""Restitution [-], capsule mass [kg], frequency [Hz] and gravity [m/s^2] of all figures of the paper."""

NODE, FOCUS, UNSTABLE = Stability.STABLE_NODE, Stability.STABLE_FOCUS, Stability.UNSTABLE_NODE


class PrintedMotion(Struct, frozen=True):
    """A motion of Fig. 3 as the paper prints it; numbers are texts, for their digits count.

    Attributes
    ----------
    figure : str
    d : str
        The printed input with most digits: our motion is the one at this d.
    velocity, position, phi : str
        Just before the impact on the bottom: velocity [y_c], position [x_c], and phase of the force [rad].
    swept : tuple of str
        Length [m] or force [N], in the caption and in the text.
    q : str
        Share of the period from the bottom to the top; "" for a motion with more than two impacts.
    flights : tuple of str
        Times from impact to impact [t_c] of a motion with more than two impacts; () for one with two.
    """

    figure: str
    d: str
    velocity: str
    position: str
    phi: str
    swept: tuple[str, ...]
    q: str = ""
    flights: tuple[str, ...] = ()


class PrintedPhase(Struct, frozen=True):
    """A critical point that the paper gives by the phase at one of its impacts, as printed."""

    kind: Event
    letter: str
    printed: str
    impact: Literal["bottom", "top"]


class PrintedTypes(Struct, frozen=True):
    """A block of Table 1: types from small to large d on the branch that has a critical point of a kind."""

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
    name : str
    panels : str
        Those of Fig. 2.
    held : tuple of (str, float)
        The other of length and force, and its value.
    letters : tuple of str
        Critical points that have a letter but no number.
    gravity : tuple of (float, str)
        Values of the swept parameter for which the text prints the group gbar.
    modulus : str
        Modulus of complex multipliers, as the text prints it; "" where the sweep has none.
    """

    name: Literal["horizontal", "inclined", "forcing"]
    panels: str
    inclination_deg: float
    parameter: Parameter
    held: tuple[str, float]
    phases: tuple[PrintedPhase, ...]
    letters: tuple[str, ...]
    types: tuple[PrintedTypes, ...]
    motions: tuple[PrintedMotion, ...]
    misprints: tuple[Misprint, ...]
    gravity: tuple[tuple[float, str], ...] = ()
    modulus: str = ""

    @property
    def results(self) -> int:
        """Number of results that the paper prints for the sweep."""
        of_motions = sum(3 + bool(x.q) + len(x.flights) + len(x.swept) for x in self.motions)
        return len(self.phases) + of_motions + len(self.gravity) + bool(self.modulus)


SLIPS = Misprint.GRAVITY, Misprint.EIGENVALUE, Misprint.FIGURE_1
"""Slips that bear on every case."""

CASES = (
    PaperCase(
        name="horizontal",
        panels="(a)–(c)",
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
        motions=(PrintedMotion("Fig. 3(a, b)", "0.3688", "0.7153", "0.1844", "0.5924", ("0.56",), "0.5"),),
        misprints=(*SLIPS, Misprint.SADDLE_NODE),
        modulus="0.25",
    ),
    PaperCase(
        name="inclined",
        panels="(d)–(f)",
        inclination_deg=45.0,
        parameter=Parameter.LENGTH,
        held=("amplitude_n", 3.0),
        phases=(PrintedPhase(Event.PERIOD_DOUBLING, "B1", "0.49", "bottom"),),
        letters=(),
        types=(PrintedTypes(Symmetry.ASYMMETRIC, Event.PERIOD_DOUBLING, (UNSTABLE, NODE)),),
        motions=(PrintedMotion("Fig. 3(c, d)", "0.4604", "1.004", "0.2302", "0.5635", ("0.69",), "0.587"),),
        misprints=SLIPS,
    ),
    PaperCase(
        name="forcing",
        panels="(g)–(i)",
        inclination_deg=45.0,
        parameter=Parameter.AMPLITUDE,
        held=("length_m", 0.75),
        phases=(PrintedPhase(Event.PERIOD_DOUBLING, "B1", "0.22", "bottom"),),
        letters=(),
        types=(PrintedTypes(Symmetry.ASYMMETRIC, Event.PERIOD_DOUBLING, (UNSTABLE, NODE)),),
        motions=(
            PrintedMotion("Fig. 3(e, f)", "0.2814", "0.726", "0.1407", "0.2101", ("5.31", "5.309"), "0.6507"),
            PrintedMotion(
                "Fig. 3(g, h)",
                "0.2545",
                "0.715",
                "0.1272",
                "0.2355",
                ("5.87",),
                flights=("0.92", "1.09", "0.91", "1.08"),
            ),
        ),
        misprints=(*SLIPS, Misprint.PERIOD_4),
        gravity=((3.0, "0.29"), (6.0, "0.14")),
    ),
)

SYMMETRIC = 1e-9
"""Largest |q - 1/2| of what is meant to be the symmetric motion."""


class PrintedQuantity(StrEnum):
    """The quantities of a critical point, of a motion of Fig. 3 or of a sweep that are compared."""

    POINT_PHASE = "point_phase"
    POINT_D = "point_d"
    VELOCITY = "velocity"
    POSITION = "position"
    PHASE = "phase"
    SHARE = "share"
    LENGTH = "length"
    FORCE = "force"
    FLIGHT = "flight"
    GRAVITY = "gravity"
    MODULUS = "modulus"


SWEPT = {Parameter.LENGTH: PrintedQuantity.LENGTH, Parameter.AMPLITUDE: PrintedQuantity.FORCE}
"""The swept parameter, as one of the quantities."""


class Agreement(StrEnum):
    """Agreement of a computed number with the printed one."""

    TO_ALL_DIGITS = "to_all_digits"
    CUT_OFF = "cut_off"
    """The printed value agrees to all its digits if the print was cut off rather than rounded."""
    ROUNDING_OF_D = "rounding_of_d"
    """The printed value agrees within what the rounding of the printed d leaves open."""
    DIFFERS = "differs"
    NOT_PRINTED = "not_printed"


class ComparedRow(Struct, frozen=True):
    """A number that the paper prints, and ours.

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
        """The error that our number is rounded by: it is shown with one digit more than the print."""
        return half_unit(self.printed) / 10 if self.printed else OF_A_MODEL

    @property
    def gap(self) -> float:
        """The distance of our number from the printed one."""
        return abs(self.ours - float(self.printed))


class ComparedTypes(Struct, frozen=True):
    """The types of motion along a branch, from small d to large: as Table 1 prints them, and our rows of that table."""

    family: Symmetry
    printed: tuple[Stability, ...]
    intervals: tuple[TableRow, ...]

    @property
    def ours(self) -> tuple[Stability, ...]:
        """The types by the solution."""
        return tuple(row.stability for row in self.intervals)

    @property
    def agrees(self) -> bool:
        """Whether they are the same."""
        return self.printed == self.ours


class PaperComparison(Struct, frozen=True):
    """The paper beside a solution: its numbers, the types of motion along the branches, and the slips in the text."""

    case: PaperCase
    rows: tuple[ComparedRow, ...]
    types: tuple[ComparedTypes, ...]


def compare_with_paper(solution: Solution) -> PaperComparison | None:
    """Set the paper's numbers beside ours; None where the scenario is not one of the paper's."""
    for case in CASES:
        if _is_case(solution, case):
            compared = compare_with_case(solution, case)
            return compared if compared.rows else None
    return None


def compare_with_case(solution: Solution, case: PaperCase) -> PaperComparison:
    """Set the numbers of one of the paper's sweeps beside those of a solution, which may be of another device."""
    motions = (row for motion in case.motions for row in _motion_rows(solution, case, motion))
    rows = (*_critical_rows(solution, case), *motions)
    # What the text says of a whole sweep needs one.
    rows += tuple(_sweep_rows(solution, case)) if solution.sweep is not None else ()
    return PaperComparison(case, rows, tuple(_type_rows(solution, case)))


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
        and not (device.recoils or device.friction or device.harmonics or device.law)
    )
    if not same or sweep is not None:
        return same and sweep is not None and sweep.parameter is case.parameter
    return _rounds_to(float(device.groups(Parameter.LENGTH, device.length_m)[0]), case.motions[0].d)


def _decimals(printed: str) -> int:
    return len(printed.partition(".")[2])


def half_unit(printed: str) -> float:
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


def _sweep_rows(solution: Solution, case: PaperCase) -> Iterator[ComparedRow]:
    """What the text prints of a sweep: the group gbar at its ends, and the modulus of complex multipliers."""
    device = solution.device
    for value, printed in case.gravity:
        gbar, of = float(device.groups(case.parameter, value).gbar), f"Section 3, {case.parameter.place(value)}"
        yield ComparedRow(PrintedQuantity.GRAVITY, of, printed, gbar, _agreement(printed, gbar))
    if case.modulus:
        modulus = float(np.sqrt(determinant_of(device.restitution)))
        agreement = _agreement(case.modulus, modulus)
        yield ComparedRow(PrintedQuantity.MODULUS, "Section 4, foci", case.modulus, modulus, agreement)


def _motion_rows(solution: Solution, case: PaperCase, printed: PrintedMotion) -> Iterator[ComparedRow]:
    """A motion of Fig. 3: ours at the printed d, compared within what the rounding of d leaves open."""
    half, d = half_unit(printed.d), float(printed.d)
    sweep = solution.sweep or around_length(solution.device)
    value = float(sweep.value(d))
    if not min(sweep.start, sweep.end) <= value <= max(sweep.start, sweep.end):
        return
    within = d, d - half, d + half
    ours = (_with_two_impacts if printed.q else _with_more_impacts)(sweep, within, printed)
    if ours is None:
        return
    yield _motion_row(PrintedQuantity.VELOCITY, printed, printed.velocity, ours.velocity)
    yield _motion_row(PrintedQuantity.POSITION, printed, printed.position, [at / 2 for at in within])
    yield _motion_row(PrintedQuantity.PHASE, printed, printed.phi, ours.phase)
    if printed.q:
        yield _motion_row(PrintedQuantity.SHARE, printed, printed.q, ours.share)
    for text, times in zip(printed.flights, ours.flights, strict=False):
        yield _motion_row(PrintedQuantity.FLIGHT, printed, text, times)
    if case.parameter is sweep.parameter:
        for text in printed.swept:
            yield _motion_row(SWEPT[sweep.parameter], printed, text, [float(sweep.value(at)) for at in within])


class _Ours(NamedTuple):
    """Our motion at the printed d and at the ends of the range that rounds to it: numbers at these three values."""

    velocity: list[float]
    phase: list[float]
    share: list[float]
    flights: list[list[float]]


def _with_two_impacts(sweep: Sweep, within: Sequence[float], printed: PrintedMotion) -> _Ours | None:
    """The first stable 1:1 motion at values of d; None where there is none."""
    guess = _stable_motion(sweep, float(sweep.value(within[0])))
    if guess is None:
        return None
    r, n = sweep.device.restitution, sweep.device.period_ratio
    horizontal = sweep.device.inclination_deg == 0 and abs(guess[0]) < SYMMETRIC
    near = orbits(np.array([guess[0]]), np.array([guess[1]]), r, n)
    places = [place_at(sweep, float(sweep.value(at)), near, horizontal) for at in within]
    speeds = [float(orbits(*place, r, n).velocity_bottom) for place in places]
    return _Ours(speeds, [phi for _, phi in places], [0.5 + u for u, _ in places], [])


def _with_more_impacts(sweep: Sweep, within: Sequence[float], printed: PrintedMotion) -> _Ours | None:
    """The motion with as many impacts that the simulation comes to from the printed one; None where there is none."""
    start, columns = Impact(BOTTOM, float(printed.velocity), float(printed.phi)), []
    for at in within:
        groups = sweep.device.groups(sweep.parameter, float(sweep.value(at))).as_floats()
        cycle = find_attractor(groups, start, compiled=False).cycle
        if cycle is None or cycle.sticks or len(cycle.wall) != len(printed.flights):
            return None
        # Of its impacts on the bottom the one that the paper begins with.
        first = int(np.argmin(np.where(cycle.wall == BOTTOM, np.abs(wrapped(cycle.phase - start.phase)), np.inf)))
        columns.append((cycle.velocity[first], cycle.phase[first], *np.roll(cycle.flight, -first - 1)))
    velocity, phase, *flights = (list(map(float, row)) for row in zip(*columns, strict=True))
    return _Ours(velocity, phase, [], flights)


def _motion_row(quantity: PrintedQuantity, of: PrintedMotion, printed: str, ours: list[float]) -> ComparedRow:
    """Compare a printed number with ours at the printed d, and at the ends of what that d may stand for."""
    middle, *ends = ours
    row = ComparedRow(quantity, of.figure, printed, middle, _agreement(printed, middle), of.d)
    if not row.agrees and min(ends) - half_unit(printed) <= float(printed) <= max(ends) + half_unit(printed):
        return replace(row, agreement=Agreement.ROUNDING_OF_D)
    return row


def _stable_motion(sweep: Sweep, value: float) -> tuple[float, float] | None:
    """Return u = q - 1/2 and phase [rad] of the first stable motion at a value of the swept parameter, or None."""
    groups = sweep.device.groups(sweep.parameter, value).map_numbers(lambda group: np.array([group], dtype=float))
    motions = motions_of(sweep, find_motions(groups, sweep.device.period_ratio).orbit)
    stable = np.flatnonzero(motions.stable_mask)
    return (float(motions.q[stable[0]]) - 0.5, float(motions.phi_bottom[stable[0]])) if stable.size else None


def _type_rows(solution: Solution, case: PaperCase) -> Iterator[ComparedTypes]:
    points = solution.critical_points
    for types in case.types:
        branch = next((point.families[0] for point in points if point.event is types.kind), None)
        intervals = tuple(row for row in solution.table if row.branch == branch)
        if intervals:
            yield ComparedTypes(types.family, types.words, intervals)
