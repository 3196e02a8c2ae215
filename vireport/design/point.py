"""The design point: all its 1:1 motions, the margins to where they end, and the ranges of stable motion around it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.distortion import Distortion, distortions
from vireport.design.lines import line_of, mirrored, reach
from vireport.design.margins import SAME_POINT, Margin, margin_at, margins_of, nearest_first
from vireport.design.speed_law import constant, motions_under_law
from vireport.motions.branches import Branch
from vireport.motions.diagram import BifurcationDiagram
from vireport.motions.events import Event
from vireport.motions.level_curve import plane_of
from vireport.motions.one_to_one import Motions, motions_of
from vireport.motions.points import Point, place_at, place_of
from vireport.motions.pointwise import find_motions
from vireport.motions.polish import in_decimals
from vireport.motions.sweep import NO_TOLERANCE, Sweep, settable
from vireport.physics.device import NO_GRAVITY, Device
from vireport.physics.energy import Conversion, Voltages
from vireport.physics.groups import Restitutions, SpeedLaw
from vireport.physics.motion import Symmetry
from vireport.scenario.parameters import DesignInput, Parameter, ScalarInput
from vireport.text.formatting import OF_A_MODEL, Exactness, apart, exact, quantity, rounded_text

Floats = NDArray[np.float64]

DOUBLE_ROOT = 1e-7
"""Error of q [-] and phase [rad] of a motion on a fold: the root of rounding, and room."""

ADJOINING = 1e-12
"""Relative gap between two stable ranges up to which it is rounding."""


class StableInterval(Struct, frozen=True, eq=False):
    """A range of an input over which there is stable 1:1 motion, and the critical points at its ends.

    Attributes
    ----------
    parameter : ScalarInput
        The swept parameter, or the input that is varied around a design point.
    start, end : float
    start_point, end_point : Point or None
        None where it is the sweep, or what the input can be, that ends.
    off : tuple of float
        The tolerance of the input, in its unit and in per cent; zeros where none is stated.
    """

    parameter: ScalarInput
    start: float
    end: float
    start_point: Point | None
    end_point: Point | None
    off: tuple[float, float] = NO_TOLERANCE

    def __repr__(self) -> str:
        return f"<StableInterval {self.text()}>"

    @property
    def ends(self) -> tuple[tuple[float, Point | None], tuple[float, Point | None]]:
        """Both ends, each with the critical point there."""
        return (self.start, self.start_point), (self.end, self.end_point)

    def end_texts(self, error: Exactness = OF_A_MODEL) -> tuple[str, str]:
        """Both ends as text: a critical point with the digits that its error leaves, the end of a sweep as stated."""
        texts = zip(apart((self.start, self.end), error), self.ends, strict=True)
        start, end = (exact(value) if point is None else text for text, (value, point) in texts)
        return self.parameter.with_unit(start), self.parameter.with_unit(end)

    def text(self, error: Exactness = OF_A_MODEL) -> str:
        """The range as text, strict at a critical point."""
        low, high = ("≤" if point is None else "<" for _, point in self.ends)
        start, end = self.end_texts(error)
        return f"{start} {low} {self.parameter.symbol} {high} {end}"

    @property
    def settable(self) -> bool:
        """Whether the range is wide enough for a device to be set into it."""
        return settable(self.start, self.end, self.off)

    def holds(self, value: float) -> bool:
        """Whether a value of the input is in the range."""
        return self.start <= value <= self.end


class DesignPoint(Struct, frozen=True, eq=False):
    """The design point and all 1:1 motions there, admissible or not.

    Attributes
    ----------
    parameter : Parameter
        The swept parameter, or the length where nothing is swept.
    value : float
        Its value at the design point, in its unit.
    motions : Motions
        Zero or more, stable ones first.
    families : tuple of Symmetry
        Symmetry of each motion.
    errors : tuple of ndarray
        Error bounds of q - 1/2 and of the phase [rad] of each motion.
    margins : tuple of Margin
        Nearest first: to the ends of the stable motions in every input, whatever is swept, to the pitchforks at which
        another motion takes over from them, and to the other critical points of the sweep.
    unresolved_inputs : tuple of DesignInput
        Inputs along which rounding does not resolve where the stable motions end.
    stable_ranges : tuple of StableInterval
        For each input, the range up to the first of these ends on either side.
    distortions : tuple of Distortion or None
        The least harmonics of the force that end a stable motion, see `with_distortions`; () where no motion is
        stable, None where they were not looked for.
    voltages_by_motion : Voltages or None
        Voltages of every motion, stable or not; None where no energy is evaluated.
    conversion_by_motion : Conversion or None
        Conversion of every motion, stable or not; None where the scenario states no dielectric of the membrane.
    lost : int
        Motions that are not followed to a restitution that falls with speed, see `speed_law.UnderLaw`.
    """

    parameter: Parameter
    value: float
    motions: Motions
    families: tuple[Symmetry, ...]
    errors: tuple[Floats, Floats]
    margins: tuple[Margin, ...]
    unresolved_inputs: tuple[DesignInput, ...]
    stable_ranges: tuple[StableInterval, ...]
    distortions: tuple[Distortion, ...] | None = None
    voltages_by_motion: Voltages | None = None
    conversion_by_motion: Conversion | None = None
    lost: int = 0

    def __repr__(self) -> str:
        stable = dict.fromkeys(self.motions.select(self.motions.stable_mask).words)
        count = int(self.motions.admissible_mask.sum())
        parts = [
            f"{count} motion{'s' * (count != 1)}, {' and '.join(stable) or 'none stable'}" if count else "no motion"
        ]
        if self.u_ave_v is not None:
            parts.append(f"U_ave {quantity(self.u_ave_v, 'V')}")
        parts += [f"nearest end: {self.nearest.text}"] if self.nearest is not None else []
        return f"<DesignPoint {self.parameter.place(self.value)}: {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        """The motions and the margins, for a notebook."""
        from html import escape  # only here: it reads the names of all characters

        from vireport.text.tables import html_table

        motions, volts = self.motions, self.voltages_by_motion
        numbers = (motions.q, motions.phi_bottom, motions.velocity_bottom, motions.velocity_top)
        gained = np.full(len(motions), np.nan) if volts is None else volts.average_v
        rows = [
            (
                words,
                "yes" if motions.admissible_mask[row] else "no",
                *(rounded_text(float(column[row])) for column in numbers),
                quantity(float(gained[row]), "V"),
            )
            for row, words in enumerate(motions.words)
        ]
        heads = ("Type", "Admissible", "q", "φ bottom [rad]", "Ż bottom [y_c]", "Ż top [y_c]", "U_ave")
        margins = [(margin.parameter.quantity, margin.text) for margin in self.limits()]
        ends = html_table(("Input", "Nearest ends of stable motion"), margins) if margins else ""
        return f"<p>{escape(repr(self)[1:-1])}</p>\n{html_table(heads, rows)}\n{ends}"

    @property
    def u_ave_v(self) -> float | None:
        """Mean voltage of the stable motion, U_ave of Eq. (5.1) [V]; the least of several stable motions.

        Requirements, rankings and the best design count this voltage, whichever motion the device comes to; mirror
        images generate the same. None where no motion is stable, or no energy is evaluated.
        """
        volts, stable = self.voltages_by_motion, self.motions.stable_mask
        return None if volts is None or not stable.any() else float(volts.average_v[stable].min())

    def endings(self, *kinds: Event) -> list[Margin]:
        """The margins to the ends of stable motions, nearest first; only of the kinds that are listed, if any."""
        return [margin for margin in self.limits(*kinds) if margin.ends_stability]

    def limits(self, *kinds: Event) -> list[Margin]:
        """The margins to where the design point's own motions end, whether or not another takes over, and to `endings`.

        Requirements are on these limits, as a motion that takes over has other voltages than the one designed.
        """
        ends = (margin for margin in self.margins if margin.ends_stability or margin.taken_over)
        return [margin for margin in ends if not kinds or margin.event in kinds]

    @property
    def nearest(self) -> Margin | None:
        """The nearest of the `limits`, None where there is none."""
        return next(iter(self.limits()), None)

    @property
    def nearest_ends(self) -> dict[DesignInput, Margin]:
        """The nearest of the `limits` in each input that has one."""
        nearest: dict[DesignInput, Margin] = {}
        for end in sorted(self.limits(), key=lambda end: abs(end.distance)):
            nearest.setdefault(end.parameter, end)
        return nearest


def design_point(device: Device, diagram: BifurcationDiagram | None, margins: bool = True) -> DesignPoint:
    """Find every motion at a design point, and how far the stable ones are from their ends.

    Parameters
    ----------
    device : Device
        With all four parameters.
    diagram : BifurcationDiagram or None
        Diagram of a sweep through the design point, whose critical points get margins too.
    margins : bool
        Whether to follow the stable motions to their ends, which takes several times as long as to find them.
    """
    chosen = diagram.sweep.parameter if diagram is not None else Parameter.LENGTH
    value = float(device.value_of(chosen))
    (motions, families, errors), lost = _solved_at(device, chosen)
    solved = chosen, value, motions, families, errors
    if not margins:
        return DesignPoint(*solved, (), (), (), lost=lost)
    ends = margins_of(device, motions)
    distances = list(ends.margins) if diagram is not None else _labelled(ends.margins)
    # A critical point of the sweep at which a stable motion ends is one point with that end, and has one label; all
    # others get margins too, as where the type of stability changes.
    for point in diagram.critical_points if diagram is not None else ():
        same = [k for k, margin in enumerate(distances) if _same_motion(margin, point, chosen)]
        for k in same:
            distances[k] = replace(distances[k], point=replace(distances[k].point, label=point.label))
        if all(distances[k].parameter.sweepable is not chosen for k in same):
            distances.append(margin_at(device, DesignInput(chosen), point))
    distances = nearest_first(distances)
    stable = _stable_ranges(device, distances, ends.unresolved) if motions.stable_mask.any() else ()
    return DesignPoint(*solved, tuple(distances), ends.unresolved, stable, lost=lost)


def with_distortions(device: Device, point: DesignPoint) -> DesignPoint:
    """A design point with the least harmonics of the force that end a stable motion of it.

    The search takes as long as all margins of the design point.
    """
    nearest = next((margin for margin in point.margins if margin.ends_stability), None)
    return replace(point, distortions=distortions(device, point.motions, nearest))


def _labelled(margins: Sequence[Margin]) -> list[Margin]:
    """Margins with labels, numbered along each input and kind of event, where no sweep has labels for them."""
    counts: dict[tuple[DesignInput, str], int] = {}
    named = []
    for margin in sorted(margins, key=lambda margin: (margin.parameter, margin.sweep_value)):
        key = margin.parameter, margin.event.letter
        counts[key] = counts.get(key, 0) + 1
        named.append(replace(margin, point=replace(margin.point, label=f"{margin.event.letter}{counts[key]}")))
    return named


def _same_motion(margin: Margin, other: Point, swept: Parameter) -> bool:
    """Whether the end of a stable motion and a critical point of a sweep are one motion, or mirror images."""
    point = margin.point
    a, b = point.closed, other.closed
    if swept.bounces and (
        margin.parameter.sweepable is not swept or abs(point.sweep_value - other.sweep_value) > SAME_POINT
    ):
        return False  # with other restitutions
    alike = abs(point.d - other.d) <= SAME_POINT * other.d
    alike &= abs(point.gbar - other.gbar) <= SAME_POINT * max(other.gbar, NO_GRAVITY)
    return point.event is other.event and alike and abs(abs(a.u) - abs(b.u)) <= SAME_POINT


def _stable_ranges(
    device: Device, margins: list[Margin], unresolved: tuple[DesignInput, ...]
) -> tuple[StableInterval, ...]:
    """For each input the range up to the first end of a stable motion on either side, or to the input's limit."""
    ranges = []
    for varied in DesignInput:
        if varied in unresolved:
            continue
        ends = [margin for margin in margins if margin.ends_stability and margin.parameter is varied]
        below = min(
            (margin for margin in ends if margin.distance < 0), key=lambda margin: -margin.distance, default=None
        )
        above = min(
            (margin for margin in ends if margin.distance > 0), key=lambda margin: margin.distance, default=None
        )
        low, high = reach(device, varied)
        ranges.append(
            StableInterval(
                varied,
                below.sweep_value if below is not None else low,
                above.sweep_value if above is not None else high,
                below.point if below is not None else None,
                above.point if above is not None else None,
            )
        )
    return tuple(ranges)


def around_length(device: Device) -> Sweep:
    """A sweep over the length through a design point, whose motions are on its level."""
    return Sweep(device, Parameter.LENGTH, device.length_m / 2, device.length_m * 2)


SolvedMotions = tuple[Motions, tuple[Symmetry, ...], tuple[Floats, Floats]]
"""Motions at a design point, their families, and the errors of u and of the phase."""


def motions_at(device: Device, parameter: Parameter) -> SolvedMotions:
    """Find all 1:1 motions at a design point, their families, and the error bounds of u and of the phase.

    Their `sweep_value` is the value of `parameter`. Where the restitution falls with speed they are the motions that
    come from those with constant restitutions.
    """
    return _solved_at(device, parameter)[0]


def _solved_at(device: Device, parameter: Parameter) -> tuple[SolvedMotions, int]:
    """`motions_at`, and how many motions are lost on the way from constant restitutions."""
    lost, restitution = 0, device.restitution
    if isinstance(restitution, SpeedLaw):
        places, restitution, lost = _under_law(device)
    else:
        places = _in_closed_form(device)
    sweep = around_length(device)
    at_u, at_phi, error_u, error_phi = (np.array([row[k] for row in places], dtype=float) for k in range(1, 5))
    orbit = replace(plane_of(sweep), r=restitution).orbits(at_u, at_phi)
    motions = motions_of(sweep, orbit, restitution)
    motions.sweep_value[:] = device.value_of(parameter)
    # All are at one d, which the closed form gives each but for its rounding.
    motions.d[:] = device.groups(Parameter.LENGTH, device.length_m).d
    np.minimum(motions.wall_gap, motions.d, out=motions.wall_gap)
    order = np.lexsort((-motions.velocity_bottom, ~motions.stable_mask))
    families = tuple(Symmetry.SYMMETRIC if places[i].symmetric else Symmetry.ASYMMETRIC for i in order)
    return (motions.select(order), families, (error_u[order], error_phi[order])), lost


class _Place(NamedTuple):
    """A motion at a design point by u and the phase at the bottom, with error bounds, and whether it is symmetric."""

    symmetric: bool
    u: float
    phi: float
    error_u: float
    error_phi: float

    @staticmethod
    def rounded(symmetric: bool, u: float, phi: float) -> _Place:
        """A place that was solved for in decimals, whose errors are roundings to doubles."""
        return _Place(symmetric, u, phi, float(np.spacing(abs(u))), float(np.spacing(phi)))


def _in_closed_form(device: Device) -> list[_Place]:
    """Every motion of a device with constant restitutions."""
    sweep = around_length(device)
    plane, groups = plane_of(sweep), device.groups(Parameter.LENGTH, device.length_m)
    guesses = find_motions(groups._replace(d=np.array([groups.d]), gbar=np.array([groups.gbar])), device.period_ratio)
    rows = []
    for k, gap in enumerate(guesses.wall_gap):
        orbit = guesses.orbit.select([k])
        symmetric = mirrored(device) and bool(orbit.u[0] == 0)
        try:
            u, phi = place_at(sweep, device.length_m, orbit, symmetric)
        except NumericalError:
            if gap > 0:  # on a fold, to rounding: two motions in one
                place = float(orbit.u[0]), float(np.mod(orbit.phi[0], 2 * np.pi))
                rows.append(_Place(symmetric, *place, DOUBLE_ROOT, DOUBLE_ROOT))
            continue  # else a solution that passes through a membrane, where the equations degenerate
        # What hardly strikes a membrane in doubles may, to its last digit, strike it from behind.
        exact = plane.orbits(u, phi)
        if exact.velocity_bottom > 0 > exact.velocity_top:
            rows.append(_Place.rounded(symmetric, u, phi))
    return rows


def _under_law(device: Device) -> tuple[list[_Place], Restitutions, int]:
    """The motions of a device whose restitution falls with speed, the restitutions of their impacts, and those lost."""
    constant_ones, *_ = motions_at(constant(device), Parameter.LENGTH)
    law = motions_under_law(device, constant_ones)
    with in_decimals():
        places = [_Place.rounded(motion.symmetric, *place_of(motion)) for motion in law.motions]
    return places, law.restitutions, law.lost


def ending_beyond(
    device: Device, parameter: Parameter, value: float, sign: float, design: DesignPoint | None = None
) -> Point | None:
    """The critical point beyond which no motion stays stable, if a parameter grows (sign 1) or falls (-1) from a value.

    None where no motion is stable there, or where one of them does not end, or is not followed to its end. Motions that
    belong to `design`, a design point of the same device, need not be followed again.
    """
    device = device.with_values({parameter: value})
    if device.unresolved:
        return None
    motions, _, _ = motions_at(device, parameter)
    varied = DesignInput(parameter)
    line = line_of(varied, device)
    ends = []
    chosen = motions.u >= 0 if mirrored(device) and parameter.keeps_symmetry else True
    rows = np.flatnonzero(motions.stable_mask & chosen)
    onward = [margin.point for margin in (design.endings() if design is not None else ()) if margin.parameter is varied]
    onward = [point for point in onward if design is not None and sign * (point.sweep_value - design.value) > 0]
    first = min(onward, key=lambda point: sign * point.sweep_value, default=None)
    if len(rows) == 1 and first is not None and sign * (first.sweep_value - value) > 0:
        return first  # the design point's stable motions are all stable here still, where only one is
    for row in rows:
        margins = margins_of(device, motions.select([row]), [line], (line.sense(varied) * sign,)).margins
        ends.append(next((end.point for end in margins if end.parameter is varied and end.ends_stability), None))
    if not ends or None in ends:
        return None
    return max((end for end in ends if end is not None), key=lambda end: sign * end.sweep_value)


BranchEnd = tuple[float, Point | None]
"""A swept value at which a stretch of a branch ends, and the critical point there; None where the sweep ends."""


def _end(branch: Branch, row: int) -> BranchEnd:
    """The swept value at a row of a branch, and the critical point there."""
    return float(branch.motions.sweep_value[row]), branch.family.critical_points.get(row)


def _ends(branch: Branch, first: int, last: int) -> tuple[BranchEnd, BranchEnd]:
    """The ends of a stretch of a branch, in the order of the swept value."""
    low, high = sorted((_end(branch, first), _end(branch, last)), key=_place)
    return low, high


def _place(end: BranchEnd) -> tuple[float, bool, str]:
    """Key that orders ends: by value, then critical points by their labels, and last the end of the sweep."""
    value, point = end
    return value, point is None, point.label if point is not None else ""


def stable_ranges(diagram: BifurcationDiagram) -> tuple[StableInterval, ...]:
    """Ranges of the swept parameter in which there is stable admissible 1:1 motion, ascending and disjoint."""
    parts = ((branch, part) for branch in diagram.branches for part in branch.family.segments)
    stretches = [_ends(branch, part.first, part.last) for branch, part in parts if part.stable]
    # Branches overlap, and one takes over where another ends: over the union of their stretches some motion is stable.
    merged: list[tuple[BranchEnd, BranchEnd]] = []
    for start, end in sorted(stretches, key=lambda ends: (_place(ends[0]), _place(ends[1]))):
        if merged and start[0] <= merged[-1][1][0] * (1 + ADJOINING):
            if end[0] > merged[-1][1][0]:
                merged[-1] = merged[-1][0], end
        else:
            merged.append((start, end))
    return tuple(StableInterval(diagram.sweep.parameter, a[0], b[0], a[1], b[1], diagram.sweep.off) for a, b in merged)
