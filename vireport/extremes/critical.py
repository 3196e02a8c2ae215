"""The extreme cases of the critical points: each kind, two at once, and devices that stand on one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from vireport.checks import reference as exact
from vireport.design import Solution
from vireport.extremes.harvester import Harvester
from vireport.extremes.judge import (
    BOUND,
    SPACING,
    Case,
    CaseFinding,
    NotThereError,
    combined,
    count,
    distance_to,
    exact_value,
    examine,
    point_error,
)
from vireport.motions import (
    Event,
    Motions,
    Point,
    Symmetry,
    motions_of,
    sample,
)
from vireport.physics import Device, by_wall, each, wrapped
from vireport.scenario import Parameter
from vireport.study import Study

SLIGHT = 0.01
"""gbar at which the pitchfork has opened into a fold that lies apart from it."""

NEAR = 0.1
"""Distance in velocity, q and phase up to which two critical points belong together."""

MET = 1e-4
"""Distance up to which they do where their two lines are followed to within `ASIDE` of where they meet."""

TWINS = 1e-5
"""Distance up to which a motion is the one looked for: less than that of the two, 1e-9 of d inside a fold."""

ASIDE = 1e-6
"""Relative distance in gbar from a codimension-two point at which both of its lines must be found."""

BEND_STEP = 1e-4
"""Step of the phase in which the bend of a fold is taken [rad]."""

TRACES = 200_001
"""Traces computed along one strand, to count changes of its type by."""

GAP_BOUND = 2e-15
"""Absolute error of a distance to a membrane: rounding of positions, times and phases of the order of 1."""

MOST_POINTS = 3
"""Points of one kind that a device is put on."""

MEETING_GBARS = np.geomspace(0.003, 1.2, 50)
"""Values of gbar at which a period doubling next to a graze is looked for."""

CUSP_GBARS = (1e-6, 1e-9, 1e-12)
"""Values of gbar at which the fold is followed towards the pitchfork."""

CUSP_ORDER, ORDER_BOUND = 2 / 3, 0.01
"""Power of gbar with which it approaches, and how far a fitted one may be off."""

GROUP = "critical points"


def critical_cases(harvester: Harvester) -> Iterator[Case]:
    """Every case of critical points."""
    flat, slight = harvester.with_device(inclination_deg=0.0), harvester.with_groups(gbar=SLIGHT)
    for name, kind, where in (
        ("pitchfork", Event.PITCHFORK, flat),
        ("fold", Event.FOLD, slight),
        ("double eigenvalue (Delta = 0)", Event.NODE_FOCUS, slight),
        ("period doubling", Event.PERIOD_DOUBLING, slight),
        ("grazing", Event.GRAZING, slight),
    ):
        expected = "each in the sweep within its stated bound, as in 40 digits"
        check = partial(_check_points, where.device)
        yield Case(GROUP, f"{name} in a sweep", expected, partial(_points, where, kind), check)
        expected = "a device standing on it is answered"
        yield Case(GROUP, f"{name} as the design point", expected, partial(_standing, where, kind), _check_standing)
    for inside in (1e-3, 1e-4, 1e-6, 1e-9):
        for title, where in (("", harvester), (f", gbar = {SLIGHT:g}", slight)):
            expected = "the two motions that meet at the fold, as in 40 digits"
            answer = partial(_beside_folds, where, inside)
            yield Case(GROUP, f"{inside:g} inside a fold{title}", expected, answer, _check_twins)
    for gbar in (1e-4, 3e-4, 7e-4, 1e-3, 1e-2):
        expected = "every change between node and focus is found, as by 200,001 traces by (A.4)"
        where = harvester.with_groups(gbar=gbar)
        yield Case(GROUP, f"narrow range of foci, gbar = {gbar:g}", expected, where.over, _check_changes)
    expected = "to one side both are found, as in 40 digits, and to the other the graze alone"
    yield Case("two at once", "period doubling meets grazing", expected, partial(_meeting, harvester), _check_meeting)
    expected = "the folds of gbar and -gbar meet in a cusp at the pitchfork: distance ~ gbar^(2/3)"
    yield Case("two at once", "cusp at the pitchfork", expected, partial(_cusp, harvester), _check_cusp)
    for name, gap in (("0", 0.0), ("+1e-14", 1e-14), ("-1e-14", -1e-14)):
        expected = "the gap as in 40 digits, and admissible only where it is positive"
        yield Case("grazing", f"gap {name}", expected, partial(_grazing, slight, gap), _check_gaps)


def _points(harvester: Harvester, kind: Event) -> list[Point]:
    points = [point for point in harvester.over().solution.critical_points if point.event is kind]
    if not points:
        raise NotThereError(f"this device has no {kind.replace('_', ' ')} there")
    return points


def _check_points(device: Device, points: Sequence[Point]) -> CaseFinding:
    errors = [point_error(point, device, Parameter.LENGTH) for point in points]
    text = ", ".join(f"{point.label} at d = {point.d:.10g}" for point in points)
    right = all(error <= max(stated, SPACING) for error, stated in errors)
    return CaseFinding(text, max(error for error, _ in errors), 2 * SPACING, right)


def _standing(harvester: Harvester, kind: Event) -> list[Study]:
    """The device at each such point, and one spacing of doubles to either side."""
    values = [point.sweep_value for point in _points(harvester, kind)[:MOST_POINTS]]
    lengths = [length for x in values for length in (x, float(np.nextafter(x, 0)), float(np.nextafter(x, np.inf)))]
    return [harvester.with_device(length_m=length).study() for length in lengths]


def _check_standing(studies: Sequence[Study]) -> CaseFinding:
    findings = [examine(study, degenerate=True) for study in studies]
    counts = " ".join(finding.text.split()[0] for finding in findings)
    return combined(findings, f"{counts} motions at and beside the points")


def _beside_folds(harvester: Harvester, inside: float) -> list[tuple[Motions, list[Any], float]]:
    """Devices so little inside each fold: their motions, the two that must be among them, and d."""
    answers = []
    for point in _points(harvester, Event.FOLD):
        beside, states = _twins(harvester, point, inside)
        design = beside.study().solution.design
        assert design is not None
        answers.append((design.motions, states, beside.device.length_m / harvester.length(1)))
    return answers


def _check_twins(answers: Sequence[tuple[Motions, list[Any], float]]) -> CaseFinding:
    apart = [distance_to(motions, state) for motions, states, _ in answers for state in states]
    text = ", ".join(
        f"{count(len(motions), 'motion')} at d = {motions.d[0] if len(motions) else d:.6g}" for motions, _, d in answers
    )
    if max(apart) > TWINS:
        return CaseFinding(f"{text}: a motion next to a fold was not found", right=False)
    return CaseFinding(text, max(apart), BOUND)


def _twins(harvester: Harvester, point: Point, inside: float) -> tuple[Harvester, list[Any]]:
    """A device so little inside a fold, and the two motions that meet in it, in 40 digits."""
    n, p = harvester.device.period_ratio, point.closed

    def device_beside(bend: Any) -> tuple[Harvester, Any]:
        beside = harvester.with_device(length_m=point.sweep_value * (1 + inside * (1 if bend > 0 else -1)))
        return beside, exact.groups(beside.device, Parameter.LENGTH, beside.device.length_m)[0]

    with exact.precise():
        r = each(harvester.device.restitution, exact.mpf)
        gbar = exact.groups(harvester.device, Parameter.LENGTH, 1)[1]
        if point.symmetry is Symmetry.SYMMETRIC:
            beside, d = device_beside(-1)  # (1+r) Zd/2 - 2 cos(phi)/pi^2 is largest at the fold
            return beside, list(exact.symmetric_motions(d, r, n))
        fold, phase = [exact.mpf(x) for x in (p.velocity_bottom, p.u, point.d)], exact.mpf(p.phi_bottom)

        def at_phase(phase: Any) -> list[Any]:
            def closed(x: list[Any]) -> list[Any]:
                return exact.periodicity((x[0], phase, x[1]), x[2], gbar, r, n)

            return exact.newton(closed, fold, [1, 1, 1])

        bend = (at_phase(phase + BEND_STEP)[2] + at_phase(phase - BEND_STEP)[2]) / 2 - fold[2]
        beside, d = device_beside(bend)
        reach, states = BEND_STEP * exact.mp.sqrt(abs((d - fold[2]) / bend)), []
        for aside in (phase + reach, phase - reach):
            velocity, u, _ = at_phase(aside)
            states.append(exact.motion([velocity, aside, u], d, gbar, r, n))
        return beside, states


def _check_changes(study: Study) -> CaseFinding:
    """Count the changes of type by the printed trace along the whole curve, and compare with the points found."""
    counted = _counted_changes(study.solution)
    points = [p for p in study.solution.critical_points if p.event is Event.NODE_FOCUS]
    changes = sum(1 if p.mirror is None else 2 for p in points)
    errors = [point_error(p, study.solution.device, Parameter.LENGTH)[0] for p in points]
    text = f"{count(changes, 'change')} found, {counted} counted"
    return CaseFinding(text, max(errors, default=0.0), 2 * SPACING, changes == counted)


def _counted_changes(solution: Solution) -> int:
    assert solution.diagram is not None
    curve, r = solution.diagram.curve, solution.device.restitution
    bottom, top = by_wall(r)
    samples, counted = sample(curve), 0
    for k in range(len(curve.strands)):
        w = samples.w[samples.which == k]
        dense = np.interp(np.linspace(0, len(w) - 1, TRACES), np.arange(len(w)), w)  # as unevenly as the samples lie
        orbit = curve.at(np.full(TRACES, k), dense)
        within = (orbit.velocity_bottom > 0) & (orbit.velocity_top < 0)
        within &= (orbit.d >= curve.bounds[0]) & (orbit.d <= curve.bounds[1])
        orbit, place = orbit.select(within), np.flatnonzero(within)
        admissible = motions_of(curve.sweep, curve.level, orbit).admissible_mask
        orbit, place = orbit.select(admissible), place[admissible]
        trace = exact.trace((orbit.velocity_bottom, orbit.phi, orbit.u), orbit.gbar, r, curve.n, np)
        focus = np.abs(trace) < 2 * bottom * top  # written out: a count beside the one of the package
        counted += int(np.sum((focus[1:] != focus[:-1]) & (np.diff(place) == 1)))
    return counted


PointPair = tuple[Point, Point]
"""A period doubling and a graze."""

MeetingAnswer = tuple[float, list[tuple[PointPair, Device]], Study]
"""The gbar at which both meet, the pairs found beside it with their devices, and the study at that gbar."""


def _meeting(harvester: Harvester) -> MeetingAnswer:
    """Where a period doubling comes to graze, solved in 40 digits; then what is found beside it and at it."""
    pairs = [pair for gbar in MEETING_GBARS if (pair := _nearest_pair(harvester.with_groups(gbar=float(gbar))))]
    close = [pair for pair in pairs if _distance(*pair) < NEAR]
    if not close:
        raise NotThereError("no period doubling of this device meets a grazing point")
    _, grazing = min(close, key=lambda pair: _distance(*pair))
    try:
        gbar = _codimension_two(harvester, grazing)
    except ArithmeticError as error:
        raise NotThereError("no period doubling of this device meets a grazing point") from error
    if gbar <= 0:
        raise NotThereError("the period doublings of this device would meet a grazing point below gbar = 0 only")
    beside = [harvester.with_groups(gbar=gbar * factor) for factor in (1 - ASIDE, 1 + ASIDE)]
    pairs_beside = [(pair, near.device) for near in beside if (pair := _nearest_pair(near)) is not None]
    return gbar, pairs_beside, harvester.with_groups(gbar=gbar, d=grazing.d).over()


def _check_meeting(answer: MeetingAnswer) -> CaseFinding:
    gbar, pairs_beside, study = answer
    met = [(pair, device) for pair, device in pairs_beside if _distance(*pair) < MET]
    distances = [_distance(*pair) for pair, _ in met]
    errors = [point_error(point, device, Parameter.LENGTH)[0] for pair, device in met for point in pair]
    text = f"at gbar = {gbar:.12g}; {ASIDE:g} beside it they are {min(distances, default=np.inf):.1e} apart"
    one_side = CaseFinding(text, max(errors, default=0.0), right=len(distances) == 1)
    return combined((one_side, examine(study, degenerate=True)), text)


def _distance(first: Point, second: Point) -> float:
    """Between the motions at two critical points."""
    a, b = first.closed, second.closed
    turned = float(abs(wrapped(a.phi_bottom - b.phi_bottom)))
    return max(abs(a.velocity_bottom - b.velocity_bottom), abs(a.u - b.u), turned)


def _nearest_pair(harvester: Harvester) -> PointPair | None:
    """The period doubling and the graze whose motions are nearest to each other; None where there is none."""
    points = harvester.critical_points()
    doubling = [point for point in points if point.event is Event.PERIOD_DOUBLING]
    grazing = [point for point in points if point.event is Event.GRAZING and point.rest is None]
    return min(((a, b) for a in doubling for b in grazing), key=lambda pair: _distance(*pair), default=None)


def _codimension_two(harvester: Harvester, near: Point) -> float:
    """The gbar at which a motion both grazes and has lambda = -1."""
    n, p = harvester.device.period_ratio, near.closed
    with exact.precise():
        r = each(harvester.device.restitution, exact.mpf)
        bottom, top = by_wall(r)
        guess = (exact.mpf(p.velocity_bottom), exact.mpf(p.phi_bottom), exact.mpf(p.u))
        turns = exact.turning_points(guess, exact.mpf(near.d), exact.mpf(near.gbar), r, n)
        _, which, time = min(turns, key=lambda turn: abs(turn[0]))

        def residual(x: list[Any]) -> list[Any]:
            state, d, gbar, t = (x[0], x[1], x[2]), x[3], x[4], x[5]
            start, speed, phase, _ = list(exact.flights(state, d, gbar, r, n))[which]
            z, rate = exact.flight(t, start, speed, phase, gbar)
            # Written out, as all of this reference is, not read from what it judges.
            doubled = exact.trace(state, gbar, r, n) + 1 + (bottom * top) ** 2
            return [*exact.periodicity(state, d, gbar, r, n), doubled, rate, d / 2 - abs(z)]

        return float(exact.newton(residual, [*guess, near.d, near.gbar, time])[4])


def _cusp(harvester: Harvester) -> list[tuple[Point, Device]]:
    """The pitchfork, and the fold next to it at smaller and smaller gbar, each with its device."""
    flat = harvester.with_device(inclination_deg=0.0)
    pitchfork = _points(flat, Event.PITCHFORK)[0]
    points = [(pitchfork, flat.device)]
    for gbar in CUSP_GBARS:
        slight = harvester.with_groups(gbar=gbar)
        folds = _points(slight, Event.FOLD)
        points.append((min(folds, key=lambda point: abs(point.d - pitchfork.d)), slight.device))
    return points


def _check_cusp(points: Sequence[tuple[Point, Device]]) -> CaseFinding:
    """The distance from the pitchfork falls by 100 where gbar does by 1000."""
    errors = [point_error(point, device, Parameter.LENGTH)[0] for point, device in points]
    d0 = points[0][0].d
    distances = [d0 - fold.d for fold, _ in points[1:]]
    orders = [float(np.log10(a / b)) / 3 for a, b in pairwise(distances)]
    right = all(abs(order - CUSP_ORDER) < ORDER_BOUND for order in orders)
    texts = ", ".join(f"{x:.3g}" for x in distances)
    text = f"{texts} from C1 at gbar = 1e-6, 1e-9, 1e-12; order {orders[-1]:.4f}"
    return CaseFinding(text, max(errors), 4 * SPACING, right)


def _grazing(harvester: Harvester, gap: float) -> list[tuple[Motions, int, Device]]:
    """Devices whose ball passes a membrane at this distance: their motions, and which of them it is."""
    points = [p for p in _points(harvester, Event.GRAZING) if p.rest is None]
    if not points or 0 in by_wall(harvester.device.restitution):
        raise NotThereError("the ball of this device touches no membrane but the one that it is leaving")
    answers = []
    for point in points[:MOST_POINTS]:
        graze = harvester.with_device(length_m=float(exact_value(point, harvester.device, Parameter.LENGTH, gap)))
        design = graze.study().solution.design
        assert design is not None
        m, p = design.motions, point.closed
        near = int(np.argmin(np.abs(m.velocity_bottom - p.velocity_bottom) + np.abs(m.q - 0.5 - p.u)))
        answers.append((m, near, graze.device))
    return answers


def _check_gaps(answers: Sequence[tuple[Motions, int, Device]]) -> CaseFinding:
    texts, errors, right = [], [], True
    for m, near, device in answers:
        with exact.precise():
            r, n = each(device.restitution, exact.mpf), device.period_ratio
            d, gbar = exact.groups(device, Parameter.LENGTH, device.length_m)
            start = [float(m.velocity_bottom[near]), float(m.phi_bottom[near]), float(m.q[near]) - 0.5]
            true = float(exact.wall_gap(exact.motion(start, d, gbar, r, n), d, gbar, r, n))
        gap = float(m.wall_gap[near])
        errors.append(abs(gap - true))
        right = right and (abs(true) < GAP_BOUND or bool(m.admissible_mask[near]) == (true > 0))
        texts.append(f"{gap:.2e} for {true:.2e}")
    return CaseFinding(f"{', '.join(texts)} (absolute error)", max(errors), GAP_BOUND, right)
