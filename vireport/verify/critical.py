"""Extreme cases of the critical points: each kind, and devices that stand on one or next to it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions, motions_of
from vireport.motions.points import Point
from vireport.physics.groups import by_wall, map_restitution
from vireport.physics.numbers import wrapped
from vireport.scenario.parameters import Parameter
from vireport.study.checks import reference as exact
from vireport.study.checks.forty_digits import critical_motion, motion_errors
from vireport.text.formatting import rounded_text
from vireport.verify.compared import SPACING, examine, point_errors
from vireport.verify.harvester import Harvester
from vireport.verify.rows import Case, CaseFinding, NotThereError, WrongAnswerError

SLIGHT = 0.01
"""gbar at which the pitchfork has opened into a fold that lies apart from it."""

TRACES = 200_001
"""Traces computed along one strand, to count changes of its type by."""

GAP_BOUND = 2e-15
"""Absolute error of a distance to a membrane: rounding of positions, times and phases of the order of 1."""

MOST_POINTS = 3
"""Points of one kind that a device is put on."""

KINDS = (
    ("pitchfork", Event.PITCHFORK),
    ("fold", Event.FOLD),
    ("double eigenvalue (Delta = 0)", Event.NODE_FOCUS),
    ("period doubling", Event.PERIOD_DOUBLING),
    ("grazing", Event.GRAZING),
)


def critical_rows(harvester: Harvester) -> Iterator[Case]:
    """Every case of critical points."""
    group, h = "critical points", harvester
    flat, slight = h.with_device(inclination_deg=0.0), h.with_groups(gbar=SLIGHT)
    for name, kind in KINDS:
        where = flat if kind is Event.PITCHFORK else slight
        yield Case(group, name, partial(_standing, where, kind))
    for inside in (1e-3, 1e-4, 1e-6, 1e-9):
        yield Case(group, f"{inside:g} inside a fold", partial(_next_to_folds, h, inside))
        yield Case(group, f"{inside:g} inside a fold, gbar = {SLIGHT:g}", partial(_next_to_folds, slight, inside))
    for gbar in (1e-4, 3e-4, 7e-4, 1e-3, 1e-2):
        case = f"narrow range of foci, gbar = {gbar:g}"
        yield Case(group, case, partial(_changes_of_type, h.with_groups(gbar=gbar)))
    for name, gap in (("0", 0.0), ("+1e-14", 1e-14), ("-1e-14", -1e-14)):
        yield Case("grazing", f"gap {name}", partial(_grazing, slight, gap))


def _points(harvester: Harvester, kind: Event) -> list[Point]:
    points = [point for point in harvester.over().solution.critical_points if point.event is kind]
    if not points:
        raise NotThereError(f"this device has no {kind.replace('_', ' ')} there")
    return points


def _standing(harvester: Harvester, kind: Event) -> CaseFinding:
    """The device at each point of a kind in a sweep, and one spacing of doubles to either side."""
    points = _points(harvester, kind)
    errors, counts = [point_errors(points, harvester.device, Parameter.LENGTH)], []
    for point in points[:MOST_POINTS]:
        s = point.sweep_value
        for length in (s, float(np.nextafter(s, 0)), float(np.nextafter(s, np.inf))):
            finding = examine(harvester.with_device(length_m=length).study(), degenerate=True)
            errors.append(finding.error or 0.0)
            counts.append(finding.text.removeprefix("motions: "))
    labels = ", ".join(point.label for point in points)
    return CaseFinding(f"{' '.join(counts)} motions at and beside {labels}", max(errors))


def _nearest(motions: Motions, point: Point) -> np.ndarray:
    """Distances of motions to that of a critical point, in velocity, phase and q."""
    p = point.closed
    apart = np.abs(motions.velocity_bottom - p.velocity_bottom) + np.abs(motions.q - 0.5 - p.u)
    return np.asarray(apart + np.abs(wrapped(motions.phi_bottom - p.phi_bottom)))


def _next_to_folds(harvester: Harvester, inside: float) -> CaseFinding:
    """Devices so little to either side of each fold: on one there are the two motions that meet in it."""
    errors, within = [0.0], 10 * np.sqrt(inside)
    for point in _points(harvester, Event.FOLD):
        counts = []
        for length in (point.sweep_value * (1 - inside), point.sweep_value * (1 + inside)):
            design = harvester.with_device(length_m=float(length)).study().solution.design
            assert design is not None
            rows = np.flatnonzero(_nearest(design.motions, point) < within)
            counts.append(len(rows))
            errors += motion_errors(design.motions, rows, harvester.device, Parameter.LENGTH)
        if abs(counts[1] - counts[0]) != 2:
            raise WrongAnswerError(f"{counts[0]} and {counts[1]} motions next to the fold {point.label}")
    return CaseFinding("two motions, and none", max(errors))


def _changes_of_type(harvester: Harvester) -> CaseFinding:
    """Every change between node and focus, counted by the printed trace along the whole curve."""
    solution = harvester.over().solution
    assert solution.diagram is not None
    curve, (bottom, top), counted = solution.diagram.curve, by_wall(harvester.device.restitution), 0
    samples = curve.sampled()
    for k in range(len(curve.strands)):
        w = samples.w[samples.which == k]
        dense = np.interp(np.linspace(0, len(w) - 1, TRACES), np.arange(len(w)), w)  # as unevenly as the samples lie
        orbit = curve.at(np.full(TRACES, k), dense)
        within = (orbit.velocity_bottom > 0) & (orbit.velocity_top < 0)
        within &= (orbit.d >= curve.bounds[0]) & (orbit.d <= curve.bounds[1])
        orbit, place = orbit.select(within), np.flatnonzero(within)
        admissible = motions_of(curve.sweep, orbit).admissible_mask
        orbit, place = orbit.select(admissible), place[admissible]
        state = orbit.velocity_bottom, orbit.phi, orbit.u
        trace = exact.trace(state, orbit.gbar, harvester.device.restitution, curve.plane.n, np)
        focus = np.abs(trace) < 2 * bottom * top
        counted += int(np.sum((focus[1:] != focus[:-1]) & (np.diff(place) == 1)))
    points = [point for point in solution.critical_points if point.event is Event.NODE_FOCUS]
    changes = sum(1 if point.mirror is None else 2 for point in points)
    if changes != counted:
        raise WrongAnswerError(f"{changes} changes found, {counted} counted")
    return CaseFinding(f"{changes} changes", point_errors(points, harvester.device, Parameter.LENGTH), 2 * SPACING)


def _grazing(harvester: Harvester, gap: float) -> CaseFinding:
    """Devices whose ball passes a membrane at this distance: the gap, and whether the motion is one."""
    points = [point for point in _points(harvester, Event.GRAZING) if point.rest is None]
    if not points or 0 in by_wall(harvester.device.restitution):
        raise NotThereError("the ball of this device touches no membrane but the one that it is leaving")
    texts, errors = [], []
    for point in points[:MOST_POINTS]:
        length = float(critical_motion(point, harvester.device, Parameter.LENGTH, gap)[3])
        design = harvester.with_device(length_m=length).study().solution.design
        assert design is not None
        m, near = design.motions, int(np.argmin(_nearest(design.motions, point)))
        with exact.precise():
            r, n = map_restitution(harvester.device.restitution, exact.mpf), harvester.device.period_ratio
            d, gbar = exact.groups(harvester.device, Parameter.LENGTH, length)
            start = [float(m.velocity_bottom[near]), float(m.phi_bottom[near]), float(m.q[near]) - 0.5]
            true = float(exact.wall_gap(exact.motion(start, d, gbar, r, n), d, gbar, r, n))
        errors.append(abs(float(m.wall_gap[near]) - true))
        if abs(true) >= GAP_BOUND and bool(m.admissible_mask[near]) != (true > 0):
            raise WrongAnswerError(f"{point.label}: admissible is wrong at a gap of {rounded_text(true)}")
        texts.append(f"{rounded_text(float(m.wall_gap[near]))} for {rounded_text(true)}")
    return CaseFinding(f"{', '.join(texts)} (absolute error)", max(errors), GAP_BOUND)
