"""The extreme cases of the critical points: each kind, two at once, and devices that stand on one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from vireport.analysis import (
    CriticalKind,
    CriticalPoint,
    Family,
    motions_of,
    sample,
)
from vireport.extremes.checks import (
    BOUND,
    UNIT,
    Base,
    Case,
    Finding,
    NotThereError,
    count,
    exact_value,
    examine,
    point_error,
)
from vireport.scenario import Parameter

SLIGHT = 0.01
"""gbar at which the pitchfork has opened into a fold that lies apart from it."""

NEAR = 0.1
"""Distance in velocity, q and phase up to which two critical points belong together."""

TWINS = 1e-5
"""Distance up to which a motion is the one looked for: less than that of the two, 1e-9 of d inside a fold."""

ASIDE = 1e-6
"""Relative distance in gbar from a codimension-two point at which both of its lines must be found."""

TRACES = 200_001
"""Of one strand, to count changes of its type by."""

GAP_BOUND = 2e-15
"""Absolute error of a distance to a membrane: rounding of positions, times and phases of the order of 1."""


def critical_cases(base: Base) -> Iterator[Case]:
    """Every case of critical points."""
    flat, slight = base.with_device(inclination_deg=0.0), base.with_groups(gbar=SLIGHT)
    places = (
        ("pitchfork", flat),
        ("fold", slight),
        ("double eigenvalue (Delta = 0)", slight),
        ("period doubling", slight),
        ("grazing", slight),
    )
    for name, where in places:
        kind = {"double eigenvalue (Delta = 0)": "node_focus"}.get(name, name.replace(" ", "_"))
        expected = "each in the sweep within its stated bound, as in 40 digits"
        yield Case(f"{name} in a sweep", "critical points", expected, partial(_points, where, kind))
        expected = "a device standing on it is answered"
        yield Case(f"{name} as the design point", "critical points", expected, partial(_standing, where, kind))
    for inside in (1e-3, 1e-4, 1e-6, 1e-9):
        expected = "the two motions that meet at the fold, as in 40 digits"
        for title, where in (("", base), (", gbar = 0.01", slight)):
            beside = partial(_beside_fold, where, inside)
            yield Case(f"{inside:g} inside a fold{title}", "critical points", expected, beside)
    expected = "every change between node and focus is found, as by 200,001 traces by (A.4)"
    for gbar in (1e-4, 3e-4, 7e-4, 1e-3, 1e-2):
        yield Case(
            f"narrow range of foci, gbar = {gbar:g}",
            "critical points",
            expected,
            partial(_all_changes, base.with_groups(gbar=gbar)),
        )
    expected = "to one side both are found, as in 40 digits, and to the other the graze alone"
    yield Case("period doubling meets grazing", "two at once", expected, partial(_meeting, base))
    expected = "the folds of gbar and -gbar meet in a cusp at the pitchfork: distance ~ gbar^(2/3)"
    yield Case("cusp at the pitchfork", "two at once", expected, partial(_cusp, base))
    for name, gap in (("0", 0.0), ("+1e-14", 1e-14), ("-1e-14", -1e-14)):
        expected = "the gap as in 40 digits, and admissible only where it is positive"
        yield Case(f"gap {name}", "grazing", expected, partial(_gap, slight, gap))


def _found(base: Base, kind: str) -> list[CriticalPoint]:
    solution = base.over().solution
    points = [point for point in solution.critical_points if point.kind == kind]
    if not points:
        raise NotThereError(f"this device has no {kind.replace('_', ' ')} there")
    return points


def _points(base: Base, kind: str) -> Finding:
    worst, right = 0.0, True
    points = _found(base, kind)
    for point in points:
        error, stated = point_error(point, base.device, Parameter.LENGTH)
        worst, right = max(worst, error), right and error <= max(stated, UNIT)
    text = ", ".join(f"{point.label} at d = {point.point.d:.10g}" for point in points)
    return Finding(text, worst, 2 * UNIT, right)


def _standing(base: Base, kind: str) -> Finding:
    """The device at each such point, and one spacing of doubles to either side."""
    said, worst = [], 0.0
    for point in _found(base, kind)[:3]:
        value = point.point.sweep_value
        for length in (value, float(np.nextafter(value, 0)), float(np.nextafter(value, np.inf))):
            finding = examine(base.with_device(length_m=length).study(), degenerate=True)
            worst = max(worst, finding.error or 0.0)
            if not finding.right:
                return finding
            said.append(finding.text.split()[0])
    return Finding(f"{' '.join(said)} motions at and beside the points", worst, BOUND)


def _beside_fold(base: Base, inside: float) -> Finding:
    """A device with a length so little inside each fold: the two motions must be among those of its design point."""
    said, worst = [], 0.0
    for point in _found(base, "fold"):
        there, states = _twins(base, point, inside)
        found = there.study().solution.design
        assert found is not None
        m = found.motions
        for velocity, phase, u in states:
            apart = np.abs(m.velocity_bottom - float(velocity)) + np.abs(m.q - 0.5 - float(u))
            apart = apart + np.abs(np.angle(np.exp(1j * (m.phi_bottom - float(phase)))))
            worst = max(worst, float(np.min(apart, initial=np.inf)))
        said.append(
            f"{count(len(m), 'motion')} at d = {m.d[0] if len(m) else there.device.length_m / base.length(1):.6g}"
        )
    if worst > TWINS:
        return Finding(f"{', '.join(said)}: a motion next to a fold was not found", right=False)
    return Finding(", ".join(said), worst, BOUND)


def _twins(base: Base, point: CriticalPoint, inside: float) -> tuple[Base, list[Any]]:
    """A device so little inside a fold, and the two motions that meet there, in 40 digits."""
    from vireport import reference as exact

    n, p = base.device.period_ratio, point.point
    with exact.precise():
        r, gbar = exact.mpf(base.device.restitution), exact.groups(base.device, Parameter.LENGTH, 1)[1]
        fold = [exact.mpf(x) for x in (p.velocity_bottom, p.u, p.d)]
        step, phase = exact.mpf(10) ** -4, exact.mpf(p.phi)

        def at_phase(phase: Any) -> list[Any]:
            found: list[Any] = exact.newton(
                lambda x: exact.periodicity((x[0], phase, x[1]), x[2], gbar, r, n), fold, [1, 1, 1]
            )
            return found

        def device(bend: Any) -> tuple[Base, Any]:
            there = base.with_device(length_m=p.sweep_value * (1 + inside * (1 if bend > 0 else -1)))
            return there, exact.groups(there.device, Parameter.LENGTH, there.device.length_m)[0]

        if point.family is Family.SYMMETRIC:
            there, d = device(-1)  # (1+r) Zd/2 - 2 cos(phi)/pi^2 is largest there
            return there, list(exact.symmetric_motions(d, r, n))
        bend = (at_phase(phase + step)[2] + at_phase(phase - step)[2]) / 2 - fold[2]
        there, d = device(bend)
        reach, states = step * exact.mp.sqrt(abs((d - fold[2]) / bend)), []
        for aside in (phase + reach, phase - reach):
            velocity, u, _ = at_phase(aside)
            guess = [velocity, aside, u]
            states.append(exact.motion(guess, d, gbar, r, n))
        return there, states


def _all_changes(base: Base) -> Finding:
    """Count the changes of type by the printed trace along the whole curve, and compare with the points found."""
    from vireport import reference as exact

    study = base.over()
    assert study.solution.diagram is not None
    curve, r = study.solution.diagram.curve, float(base.device.restitution)
    samples = sample(curve)
    counted = 0
    for k in range(len(curve.strands)):
        w = samples.w[samples.which == k]
        dense = np.interp(np.linspace(0, len(w) - 1, TRACES), np.arange(len(w)), w)  # as unevenly as the samples lie
        orbit = curve.at(np.full(TRACES, k), dense)
        within = (orbit.velocity_bottom > 0) & (orbit.velocity_top < 0)
        within &= (orbit.d >= curve.bounds[0]) & (orbit.d <= curve.bounds[1])
        orbit = orbit.select(within)
        place = np.flatnonzero(within)
        within = motions_of(curve.sweep, curve.level, orbit).admissible
        orbit, place = orbit.select(within), place[within]
        trace = exact.trace((orbit.velocity_bottom, orbit.phi, orbit.u), orbit.gbar, r, curve.n, np)
        focus = np.abs(trace) < 2 * r * r
        counted += int(np.sum((focus[1:] != focus[:-1]) & (np.diff(place) == 1)))
    points = [p for p in study.solution.critical_points if p.kind is CriticalKind.NODE_FOCUS]
    found = sum(1 if p.mirror is None else 2 for p in points)
    error = max([point_error(p, base.device, Parameter.LENGTH)[0] for p in points], default=0.0)
    text = f"{count(found, 'change')} found, {counted} counted"
    return Finding(text, error, 2 * UNIT, found == counted)


def _meeting(base: Base) -> Finding:
    """Where a period doubling comes to graze, solved in 40 digits; then what is found beside it and there."""
    pairs = [pair for gbar in np.geomspace(0.003, 1.2, 50) if (pair := _nearest(base.with_groups(gbar=float(gbar))))]
    pairs = [pair for pair in pairs if _distance(*pair) < NEAR]
    if not pairs:
        raise NotThereError("no period doubling of this device meets a grazing point")
    _, grazing = min(pairs, key=lambda pair: _distance(*pair))
    try:
        gbar = _codimension_two(base, grazing)
    except ArithmeticError as error:
        raise NotThereError("no period doubling of this device meets a grazing point") from error
    distances = []
    worst = 0.0
    for factor in (1 - ASIDE, 1 + ASIDE):
        there = base.with_groups(gbar=gbar * factor)
        pair = _nearest(there)
        if pair is not None and _distance(*pair) < NEAR * 1e-3:
            distances.append(_distance(*pair))
            worst = max(worst, *(point_error(point, there.device, Parameter.LENGTH)[0] for point in pair))
    there = base.with_groups(gbar=gbar, d=grazing.point.d)
    standing = examine(there.over(), degenerate=True)
    text = f"at gbar = {gbar:.12g}; {ASIDE:g} beside it they are {min(distances, default=np.inf):.1e} apart"
    right = len(distances) == 1 and standing.right
    return Finding(text if standing.right else standing.text, max(worst, standing.error or 0.0), BOUND, right)


def _distance(one: CriticalPoint, two: CriticalPoint) -> float:
    """Between the motions at two critical points."""
    a, b = one.point, two.point
    turned = float(abs(np.angle(np.exp(1j * (a.phi - b.phi)))))
    return max(abs(a.velocity_bottom - b.velocity_bottom), abs(a.u - b.u), turned)


def _nearest(base: Base) -> Any:
    """The period doubling and the graze whose motions are nearest to each other; None where there is none."""
    solution = base.over().solution
    points = solution.critical_points
    doubling = [point for point in points if point.kind is CriticalKind.PERIOD_DOUBLING]
    grazing = [point for point in points if point.kind is CriticalKind.GRAZING and not point.change.at_rest]
    return min(((a, b) for a in doubling for b in grazing), key=lambda pair: _distance(*pair), default=None)


def _codimension_two(base: Base, near: CriticalPoint) -> float:
    """The gbar at which a motion both grazes and has lambda = -1."""
    from vireport import reference as exact
    from vireport.extremes.search import turning_points

    n, p = base.device.period_ratio, near.point
    with exact.precise():
        r = exact.mpf(base.device.restitution)
        guess = (exact.mpf(p.velocity_bottom), exact.mpf(p.phi), exact.mpf(p.u))
        turns = turning_points(guess, exact.mpf(p.d), exact.mpf(p.gbar), r, n)
        _, which, time = min(turns, key=lambda one: abs(one[0]))

        def residual(x: list[Any]) -> list[Any]:
            state, d, gbar, t = (x[0], x[1], x[2]), x[3], x[4], x[5]
            start, speed, phase, _ = list(exact.flights(state, d, gbar, r, n))[which]
            z, rate = exact.flight(t, start, speed, phase, gbar)
            doubled = exact.trace(state, gbar, r, n) + 1 + r**4
            return [*exact.periodicity(state, d, gbar, r, n), doubled, rate, d / 2 - abs(z)]

        return float(exact.newton(residual, [*guess, p.d, p.gbar, time])[4])


def _cusp(base: Base) -> Finding:
    """The fold at smaller and smaller gbar: its distance from the pitchfork falls by 100 where gbar does by 1000."""
    flat = base.with_device(inclination_deg=0.0)
    pitchfork = _found(flat, "pitchfork")[0]
    d0 = pitchfork.point.d
    distances, worst = [], point_error(pitchfork, flat.device, Parameter.LENGTH)[0]
    gbars = (1e-6, 1e-9, 1e-12)
    for gbar in gbars:
        slight = base.with_groups(gbar=gbar)
        fold = min(_found(slight, "fold"), key=lambda point: abs(point.point.d - d0))
        worst = max(worst, point_error(fold, slight.device, Parameter.LENGTH)[0])
        distances.append(d0 - fold.point.d)
    orders = [float(np.log10(a / b)) / 3 for a, b in pairwise(distances)]
    right = all(abs(order - 2 / 3) < 0.01 for order in orders)
    said = ", ".join(f"{x:.3g}" for x in distances)
    return Finding(f"{said} from C1 at gbar = 1e-6, 1e-9, 1e-12; order {orders[-1]:.4f}", worst, 4 * UNIT, right)


def _gap(base: Base, gap: float) -> Finding:
    """A device whose ball passes a membrane at this distance."""
    from vireport import reference as exact
    from vireport.extremes.search import wall_gap

    points = [p for p in _found(base, "grazing") if not p.change.at_rest]
    if not points or base.device.restitution == 0:
        raise NotThereError("the ball of this device touches no membrane but the one that it is leaving")
    n, said, worst, right = base.device.period_ratio, [], 0.0, True
    for point in points[:3]:
        with exact.precise():
            length = float(exact_value(point, base.device, Parameter.LENGTH, gap))
            there = base.with_device(length_m=length)
            r = exact.mpf(there.device.restitution)
            d, gbar = exact.groups(there.device, Parameter.LENGTH, length)
            motions = there.study().solution.design
            assert motions is not None
            near = np.argmin(
                np.abs(motions.motions.velocity_bottom - point.point.velocity_bottom)
                + np.abs(motions.motions.q - 0.5 - point.point.u)
            )
            m = motions.motions
            start = [float(m.velocity_bottom[near]), float(m.phi_bottom[near]), float(m.q[near]) - 0.5]
            x = exact.motion(start, d, gbar, r, n)
            true = float(wall_gap((x[0], x[1], x[2]), d, gbar, r, n))
        worst = max(worst, abs(float(m.wall_gap[near]) - true))
        right = right and (abs(true) < GAP_BOUND or bool(m.admissible[near]) == (true > 0))
        said.append(f"{float(m.wall_gap[near]):.2e} for {true:.2e}")
    return Finding(f"{', '.join(said)} (absolute error)", worst, GAP_BOUND, right)
