"""The numbers that the paper prints, beside those computed here, where a scenario is one of the paper's.

Ours are computed on the spot. Where they differ from the print by more than the rounding of all its digits
leaves open, the row says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import floor, pi
from typing import cast

import numpy as np

from vireport.analysis import (
    CriticalPoint,
    Solution,
    Sweep,
    polish,
    value_condition,
)
from vireport.scenario import Parameter
from vireport.text import (
    ABSENT,
    significant,
)
from vireport.trust.paper_cases import CAPSULE_MASS, CASES, FREQUENCY, GRAVITY, RESTITUTION, Case, Misprint

SYMMETRIC = 1e-9
"""Largest |q - 1/2| of what is meant to be the symmetric motion."""

LETTER_ONLY = "the paper gives the letter only"


@dataclass(frozen=True, slots=True)
class Comparison:
    """The paper beside a solution.

    Attributes
    ----------
    case : str
    rows, types : tuple of ComparedRow
        Numbers, and the types of motion along the branches.
    misprints : tuple of Misprint
    """

    case: str
    rows: tuple[ComparedRow, ...]
    types: tuple[ComparedRow, ...]
    misprints: tuple[Misprint, ...]


@dataclass(frozen=True, slots=True)
class ComparedRow:
    """A number of the paper's, and ours.

    Attributes
    ----------
    quantity, printed, ours, remark : str
    agrees : bool or None
        None where there is nothing to compare.
    """

    quantity: str
    printed: str
    ours: str
    remark: str
    agrees: bool | None


def comparison(solution: Solution) -> Comparison | None:
    """Set the paper's numbers beside ours; None where the scenario is not one of the paper's.

    Parameters
    ----------
    solution : Solution
    """
    for case in CASES:
        if _is_case(solution, case):
            rows = (*_critical_rows(solution, case), *_motion_rows(solution, case))
            return Comparison(case.name, rows, tuple(_type_rows(solution, case)), case.misprints) if rows else None
    return None


def _is_case(solution: Solution, case: Case) -> bool:
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
        return same and sweep is not None and sweep.parameter == case.parameter
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


def _critical_rows(solution: Solution, case: Case) -> Iterator[ComparedRow]:
    points = solution.critical_points
    for phase in case.phases:
        found = [
            (abs(ours - float(phase.printed)), ours, mirrored, point)
            for point in points
            if point.kind == phase.kind
            for ours, mirrored in _phases(point, phase.impact)
        ]
        if not found:
            continue
        _, ours, mirrored, point = min(found, key=lambda each: each[0])
        where = f"phase at the {phase.impact} impact{' of the mirror image' if mirrored else ''}"
        kind = "the paper's saddle-node is a pitchfork" if phase.kind == "pitchfork" else ""
        yield _row(f"{phase.letter}: *φ*", phase.printed, ours, "; ".join(filter(None, (where, kind))))
        yield _letter_row(phase.letter, point)
    for point in points:
        if point.label in case.letters:
            yield _letter_row(point.label, point)


def _letter_row(letter: str, point: CriticalPoint) -> ComparedRow:
    return ComparedRow(f"{letter}: *d*", ABSENT, significant(point.point.d, 10), LETTER_ONLY, None)


def _phases(point: CriticalPoint, impact: str) -> Iterator[tuple[float, bool]]:
    """Phases at an impact: of the motion, and of its mirror image, half a period from the other impact."""
    yield (point.point.phi if impact == "bottom" else point.phi_top), False
    if point.mirror is not None:
        other = point.phi_top if impact == "bottom" else point.point.phi
        yield (other + pi) % (2 * pi), True


def _motion_rows(solution: Solution, case: Case) -> Iterator[ComparedRow]:
    """The motion of Fig. 3: ours at the printed d, compared within what the rounding of d leaves open."""
    printed, half, d = case.motion, _half(case.motion.d), float(case.motion.d)
    sweep, guess = _sweep(solution), _guess(solution, d)
    value = float(sweep.value(d, None))
    if guess is None or not min(sweep.start, sweep.end) <= value <= max(sweep.start, sweep.end):
        return
    points = [
        polish(
            sweep,
            *guess,
            value_condition(sweep, float(sweep.value(at, None))),
            symmetric=case.inclination_deg == 0 and abs(guess[0]) < SYMMETRIC,
        )
        for at in (d, d - half, d + half)
    ]
    head = f"{printed.figure}, *d* = {printed.d}: "
    yield _motion_row(f"{head}*Ż*_B", printed.velocity, [point.velocity_bottom for point in points])
    yield _motion_row(f"{head}*φ*", printed.phi, [point.phi for point in points])
    yield _motion_row(f"{head}*q*", printed.q, [0.5 + point.u for point in points])
    if case.parameter is Parameter.LENGTH:
        yield _row(f"{head}*s* [m]", printed.length_m, value, "take *d*, which has more digits")


def _motion_row(quantity: str, printed: str, ours: list[float]) -> ComparedRow:
    """Compare a printed number with ours at the printed d, and at the ends of what that d may stand for."""
    middle, *ends = ours
    row = _row(quantity, printed, middle)
    if not row.agrees and min(ends) - _half(printed) <= float(printed) <= max(ends) + _half(printed):
        return replace(row, remark="within the rounding of that *d*", agrees=True)
    return row


def _sweep(solution: Solution) -> Sweep:
    """The solution's sweep, or one around its design point."""
    if solution.sweep is not None:
        return solution.sweep
    length = cast(float, solution.device.length_m)
    return Sweep(solution.device, Parameter.LENGTH, length / 2, length * 2)


def _guess(solution: Solution, d: float) -> tuple[float, float] | None:
    """About u and phase of a solution's stable motion at a d, between the rows of a branch around it."""
    motions = [branch.motions for branch in solution.branches]
    if solution.diagram is None and solution.design is not None:
        motions = [solution.design.motions]
    found = []
    for x in motions:
        stable = np.nonzero(x.stable)[0]
        if stable.size:
            nearest = int(np.argmin(np.abs(x.d[stable] - d)))
            rows = stable[max(nearest - 2, 0) : nearest + 3]
            weights = _weights(x.d[rows], d)
            u, phi = weights @ (x.q[rows] - 0.5), weights @ np.unwrap(x.phi_bottom[rows])
            found.append((abs(float(x.d[stable[nearest]]) - d), float(u), float(phi)))
    return min(found)[1:] if found else None


def _weights(nodes: np.ndarray, at: float) -> np.ndarray:
    """Weights of Lagrange's interpolation; of the nearest node alone where two coincide."""
    gaps = nodes[:, None] - nodes[None, :] + np.eye(len(nodes))
    if not gaps.all():
        return np.asarray(np.arange(len(nodes)) == np.argmin(np.abs(nodes - at)), dtype=float)
    shares = (at - nodes[None, :]) / gaps
    np.fill_diagonal(shares, 1.0)
    return np.asarray(shares.prod(axis=1))


def _type_rows(solution: Solution, case: Case) -> Iterator[ComparedRow]:
    points = solution.critical_points
    for types in case.types:
        branch = next((point.branch for point in points if point.kind == types.kind), None)
        ours = tuple(row.stability for row in solution.table if row.branch == branch)
        if ours:
            agrees = ours == types.words
            remark = "" if agrees else "the sweep, or grazing, cuts the row"
            name = f"{types.family.capitalize()}, *d* rising"
            yield ComparedRow(name, ", ".join(types.words), ", ".join(ours), remark, agrees)
