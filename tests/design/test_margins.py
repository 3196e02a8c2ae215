"""Margins of random devices in every input: against the printed equations in 40 digits, a search by independent
solving, and the simulation."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from itertools import cycle, islice, product
from typing import Any

import numpy as np
import pytest
from conftest import first
from mpmath import mp, mpf
from msgspec.structs import replace
from strategies import random_sweeps

from vireport import analyse, loads
from vireport.base.errors import NumericalError
from vireport.cli.outputs import results_outcome
from vireport.design import margins
from vireport.design.margins import Margin
from vireport.design.point import design_point, ending_beyond
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.orbits import orbits
from vireport.motions.pointwise import find_motions
from vireport.motions.stability import UNSTABLE, classify
from vireport.motions.sweep import Sweep
from vireport.motions.turning import touches
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.groups import Groups, Restitutions, by_wall
from vireport.physics.motion import Symmetry
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DRIVING, DesignInput, Parameter
from vireport.study.checks import reference

NEAR = 0.06
"""Distance in q and radians within which a motion is the one that ends nearby."""

PARTS = int(os.environ.get("VIREPORT_PARTS", "3"))
"""Of the random devices in 40 digits, each but the first with 8; 26 are 201 devices, in three minutes."""

JUMP = 0.3
"""The same of one motion at two of many values: more than it moves, less than to another."""


def stable_devices(count: int, seed: int) -> list[tuple[Device, Any]]:
    """Random devices with stable motion, every other one a free capsule, and their design points."""

    def all_of_them() -> Iterator[tuple[Device, Any]]:
        kinds = cycle([CapsuleMotion.FREE, CapsuleMotion.PRESCRIBED])
        kind = next(kinds)
        for part in range(100):
            for sweep in random_sweeps(100, seed + part):
                mass = 0.2 * sweep.device.capsule_mass_kg
                device = replace(sweep.device, capsule=kind, ball_mass_kg=mass)
                design = design_point(device, None)
                if design.motions.stable_mask.any():
                    kind = next(kinds)
                    yield device, design

    return list(islice(all_of_them(), count))


Place = tuple[float, float]
"""q - 1/2 and phase of a motion."""


def moved(device: Device, varied: DesignInput, value: float) -> Device:
    return device.with_values({varied: value})


def stable_along(device: Device, varied: DesignInput, values: Sequence[float]) -> list[list[Place]]:
    """The stable motions where an input has each of some values, from the zeros of one function of q."""
    devices = [moved(device, varied, float(value)) for value in values]
    d, gbar, bottom, top = np.array([x.groups(*at_length(x)).numbers for x in devices], dtype=float).T
    r = bottom if np.array_equal(bottom, top) else Restitutions(bottom, top)
    motions = find_motions(Groups(d, gbar, r), device.period_ratio)
    stable = motions.admissible & (classify(motions.trace, (bottom * top)[motions.cell]) != UNSTABLE)
    places: list[list[Place]] = [[] for _ in devices]
    for cell, u, phi in zip(motions.cell[stable], motions.orbit.u[stable], motions.orbit.phi[stable], strict=True):
        places[cell].append((float(u), float(phi)))
    return places


def at_length(device: Device) -> tuple[Parameter, float]:
    return Parameter.LENGTH, device.length_m


def stable_near(device: Device, varied: DesignInput, value: float, near: Place, within: float) -> list[Place]:
    return [place for place in stable_along(device, varied, [value])[0] if apart(place, near) < within]


def apart(one: tuple[float, float], other: tuple[float, float]) -> float:
    return abs(one[0] - other[0]) + abs((one[1] - other[1] + np.pi) % (2 * np.pi) - np.pi)


def ends(design: Any, varied: DesignInput) -> tuple[Margin | None, Margin | None]:
    """The nearest end of stable motion below and above the design point."""
    own = [ending for ending in design.endings() if ending.parameter is varied]
    below = min((ending for ending in own if ending.distance < 0), key=lambda ending: -ending.distance, default=None)
    return below, min(
        (ending for ending in own if ending.distance > 0), key=lambda ending: ending.distance, default=None
    )


def goes_on(device: Device, varied: DesignInput, to: float) -> bool:
    """Whether every stable motion of the design point is there all the way, by a search at many values."""
    at = float(device.value_of(varied))
    values = np.geomspace(at, to, 401) if min(at, to) > 0 else np.linspace(at, to, 401)
    first_places, *along = stable_along(device, varied, values)
    for place in first_places:
        followed = place
        for places in along:
            near = min(places, key=lambda other: apart(other, followed), default=None)
            if near is None or apart(near, followed) > JUMP:
                return False
            followed = near
    return True


@pytest.mark.parametrize("part", first(1, range(4)))
def test_stable_motion_goes_on_up_to_the_end_and_not_beyond(part: int) -> None:
    """A search among all solutions at many values finds the motion up to just before the end, and not just after."""
    for device, design in stable_devices(1 if part == 0 else 6, 1000 * part):
        assert not design.unresolved_inputs
        for varied, end in ((v, e) for v in DesignInput for e in ends(design, v) if e is not None):
            place, little = (end.point.closed.u, end.point.closed.phi_bottom), 1e-6 * end.distance
            assert goes_on(device, varied, end.sweep_value - little), (device, end)
            assert stable_near(device, varied, end.sweep_value - little, place, NEAR), (device, end)
            assert not stable_near(device, varied, end.sweep_value + little, place, 0.3 * NEAR), (device, end)


@pytest.mark.parametrize("part", first(1, range(4)))
def test_where_nothing_ends_stable_motion_goes_on(part: int) -> None:
    for device, design in stable_devices(2 if part == 0 else 6, 1000 * part):
        for varied in (DesignInput.INCLINATION, *RESTITUTIONS):
            low, high = (0.0, 90.0) if varied is DesignInput.INCLINATION else (1e-3, 0.99)
            for end, limit in zip(ends(design, varied), (low, high), strict=True):
                at = float(device.value_of(varied))
                if end is None and not (limit - at) * (1 if limit == high else -1) <= 0:
                    assert goes_on(device, varied, limit), (device, varied)


def restitution(varied: DesignInput, of: dict[str, Any]) -> Any:
    """The restitution of both membranes or of each: that of both together is their mean, and keeps their difference."""
    both, bottom, top = (of[name.value] for name in RESTITUTIONS)
    if varied is DesignInput.RESTITUTION:
        bottom, top = both + (bottom - top) / 2, both - (bottom - top) / 2
    elif "moved" in of:
        bottom = bottom if varied is DesignInput.RESTITUTION_BOTTOM else bottom + of["moved"]
        top = top if varied is DesignInput.RESTITUTION_TOP else top + of["moved"]
    return bottom if bottom == top else Restitutions(bottom, top)


def exact_end(device: Device, inputs: dict[str, Any], end: Margin) -> Any:
    """The value of an input at which motion ends, in 40 digits by the printed equations; `inputs` are the others."""
    n, point = device.period_ratio, end.point.closed
    symmetric = end.point.symmetry is Symmetry.SYMMETRIC
    r0 = moved(device, end.parameter, end.sweep_value).restitution
    orbit = orbits(np.array([point.u]), np.array([point.phi_bottom]), r0, n)
    near = touches(orbit, orbit.flights(r0))
    grazing = end.event is Event.GRAZING
    at_rest = grazing and end.point.rest is not None

    def equations(x: list[Any]) -> list[Any]:
        of = inputs | {end.parameter.value: x[3]}
        force, r = of["amplitude_n"], restitution(end.parameter, of)
        d = 4 * of["capsule_mass_kg"] * of["length_m"] * of["frequency_hz"] ** 2 / force
        held_up = of["capsule_mass_kg"] + (mpf(device.ball_mass_kg) if device.recoils else 0)
        gbar = held_up * mpf(device.gravity_m_s2) * mp.sin(mp.pi * of["inclination_deg"] / 180) / force
        state = (reference.symmetric_velocity(x[1], r), x[1], mpf(0)) if symmetric else (x[0], x[1], x[2])
        closed = reference.periodicity(state, d, gbar, r, n)
        if symmetric:
            closed = [x[0] - state[0], x[2], closed[0]]
        if at_rest:
            bottom = end.point.rest == 0
            return [*closed, state[0] if bottom else reference.velocity_top(state, gbar, r, n)]
        if not grazing:
            bottom, top = by_wall(r)
            border = (-1 if end.event is Event.PERIOD_DOUBLING else 1) * (1 + (bottom * top) ** 2)
            return [*closed, reference.trace(state, gbar, r, n) - border]
        start, speed, phase, _ = list(reference.flights(state, d, gbar, r, n))[0 if near[0].upward else 1]
        z, rate = reference.flight(x[4], start, speed, phase, gbar)
        return [*closed, rate, z - (start if near[0].at_start else -start)]

    guess = [point.velocity_bottom, point.phi_bottom, point.u, end.sweep_value]
    time = [near[0].time] if grazing and not at_rest else []
    return reference.newton(equations, [*guess, *time])[3]


@pytest.mark.parametrize("part", first(1, range(PARTS)))
def test_ends_and_their_derivatives_in_40_digits(part: int) -> None:
    for device, design in stable_devices(1 if part == 0 else 3, 1000 * part):
        for end in design.limits()[:: 3 if part == 0 else 1]:
            with reference.precise():
                inputs = {name.value: mpf(float(device.value_of(name))) for name in DesignInput}
                exact = exact_end(device, inputs, end)
                assert abs(exact - mpf(end.sweep_value)) <= end.point.error_bound, (device, end)
                assert abs(exact - inputs[end.parameter.value] - mpf(end.distance)) <= end.error_bound
                for name, derivative in end.derivatives.items():
                    if derivative is None:
                        breaking = name in ("inclination_deg", *RESTITUTIONS[1:])
                        horizontal = breaking and not design.motions.gbar.any()
                        assert horizontal or end.event is Event.PITCHFORK
                        continue
                    if name is DesignInput.INCLINATION and end.point.symmetry is Symmetry.SYMMETRIC:
                        assert derivative == 0  # an inclination to either side does the same
                        continue
                    if name in RESTITUTIONS[1:] and end.point.symmetry is Symmetry.SYMMETRIC:
                        # The equations of symmetric motions have one restitution. Mirrored, either does the same.
                        if end.parameter not in RESTITUTIONS:
                            both = end.derivatives[DesignInput.RESTITUTION]
                            assert derivative == pytest.approx(both / 2, rel=1e-12)
                        continue
                    step = mpf(10) ** -15 * (inputs[name.value] or 1)  # of 40 digits, one side is enough
                    key = "moved" if name is DesignInput.RESTITUTION else name.value
                    ahead = exact_end(device, inputs | {key: inputs.get(key, 0) + step}, end)
                    scale = float(abs(exact / (inputs[name.value] or 1)))
                    expected = float((ahead - exact) / step)
                    assert derivative == pytest.approx(expected, rel=1e-8, abs=1e-9 * scale), (device, end, name)


@pytest.mark.slow
def test_horizontal_capsules_hand_their_stability_over() -> None:
    """An asymmetric motion becomes the symmetric one, or the reverse, at a pitchfork at which stable motion goes on."""
    device = Device(0.1245, 0.5, 9.8, 0.35, 3.0, 2.0, 0.0)
    for length, other in ((0.35, 0.5), (0.5, 0.35)):
        below, above = ends(design_point(moved(device, DesignInput.LENGTH, length), None), DesignInput.LENGTH)
        again = ends(design_point(moved(device, DesignInput.LENGTH, other), None), DesignInput.LENGTH)
        assert below.sweep_value == pytest.approx(0.28170667362150886, rel=1e-15)
        assert [below.sweep_value, above.sweep_value] == pytest.approx(
            [ending.sweep_value for ending in again], rel=1e-15
        )
    diagram = solve(Sweep(device, Parameter.LENGTH, 0.2, 3.0))
    values = [point.sweep_value for point in diagram.critical_points]
    assert min(abs(value - above.sweep_value) for value in values) < 1e-15


TAKEN_OVER = Device(0.17773325, 0.45996, 9.8, 5.042418, 20.930283, 1.8435747, 0.0)
"""A horizontal capsule whose symmetric motion hands its stability over long before stable motion ends."""


def passing(device: Device, varied: DesignInput) -> Margin:
    """The pitchfork at which another motion takes over, if one input varies."""
    (margin,) = [x for x in design_point(device, None).limits() if x.taken_over and x.parameter is varied]
    return margin


def exact_pitchfork(inputs: dict[str, Any], varied: str) -> Any:
    """The value of an input at which a symmetric motion has its pitchfork, in 40 digits.

    The symmetric motion has v = 2 sin(phi)/[pi (1 - r)], d = (1 + r) v/2 - 2 cos(phi)/pi^2, and half a period, from
    one impact to the mirror image of the next, the trace 2 r - (1 + r) cos(phi)/v and the determinant r^2. That an
    asymmetric change is kept makes its multiplier -1.
    """

    def equations(x: list[Any]) -> list[Any]:
        of, (phi, velocity) = inputs | {varied: x[2]}, x[:2]
        r, force = of["restitution"], of["amplitude_n"]
        d = 4 * of["capsule_mass_kg"] * of["length_m"] * of["frequency_hz"] ** 2 / force
        return [
            mp.pi * (1 - r) * velocity - 2 * mp.sin(phi),
            (1 + r) * velocity / 2 - 2 * mp.cos(phi) / mp.pi**2 - d,
            2 * r - (1 + r) * mp.cos(phi) / velocity + 1 + r**2,
        ]

    return reference.newton(equations, [mpf("0.5"), mpf("0.6"), inputs[varied] / 2])[2]


@pytest.mark.parametrize("varied", [DesignInput.LENGTH, DesignInput.FREQUENCY, DesignInput.AMPLITUDE])
def test_a_pitchfork_ends_the_symmetric_motion_of_a_design(varied: DesignInput) -> None:
    margin, names = passing(TAKEN_OVER, varied), [x for x in TAKEN_OVER.inputs if x != "inclination_deg"]
    with reference.precise():
        inputs = {name.value: mpf(TAKEN_OVER.value_of(name)) for name in names}
        exact = exact_pitchfork(inputs, varied.value)
        assert abs(exact - mpf(margin.sweep_value)) <= margin.error_bound
        for name in names:
            if name is not varied:
                step = mpf(10) ** -15 * inputs[name.value]
                ahead, behind = (
                    exact_pitchfork(inputs | {name.value: inputs[name.value] + sign * step}, varied.value)
                    for sign in (1, -1)
                )
                assert margin.derivatives[name] == pytest.approx(float((ahead - behind) / (2 * step)), rel=1e-12)
    for breaking in (DesignInput.INCLINATION, *RESTITUTIONS[1:]):  # of which the border has a cusp
        assert margin.derivatives[breaking] is None
    assert (margin.event, margin.ends_stability) == (Event.PITCHFORK, False)


def test_both_the_pitchfork_and_the_end_of_stable_motion_are_margins() -> None:
    below = [x for x in design_point(TAKEN_OVER, None).limits() if x.parameter == "length_m" and x.distance < 0]
    assert [(x.event, x.taken_over, x.ends_stability) for x in below] == [
        (Event.PITCHFORK, True, False),
        (Event.GRAZING, False, True),
    ]
    assert [x.relative for x in below] == pytest.approx([-0.5583266982353049, -0.6815182484296297], rel=1e-14)


@pytest.mark.slow
def test_the_simulated_motion_is_symmetric_on_one_side_of_the_pitchfork_only() -> None:
    from vireport.simulation.attractors import find_attractor
    from vireport.simulation.events import BOTTOM, Impact

    margin = passing(TAKEN_OVER, DesignInput.LENGTH)
    point = margin.point.closed
    for share, symmetric in ((1.02, True), (0.98, False)):
        at = moved(TAKEN_OVER, DesignInput.LENGTH, share * margin.sweep_value)
        start = Impact(BOTTOM, 1.001 * point.velocity_bottom, point.phi_bottom)
        attractor = find_attractor(at.groups(*at_length(at)).as_floats(), start)
        assert attractor.word == "BT"
        # Both impacts are equally fast on either side, the flights differ.
        bottom, top = attractor.cycle.phase
        assert bool(abs(abs(bottom - top) - np.pi) < 1e-6) is symmetric, (bottom, top)


@pytest.mark.parametrize("length", first(1, [0.45, 0.5]))
def test_a_requirement_is_of_the_nearer_one(length: float, example) -> None:
    """In frequency, of which d is the square, to the pitchfork and not to the end of stable motion."""
    nearest = 100 * abs((0.39673442 / length) ** 0.5 - 1)
    for limit, met in ((0.999 * nearest, True), (1.001 * nearest, False)):
        over = [f"device.length_m={length}", f"requirements.margin_any_percent={limit}"]
        study = analyse(loads(example("horizontal").read_text(), overrides=over), ["json"])
        (criterion,) = [x for x in study.criteria if x.key == "margin_any_percent"]
        assert criterion.passed is met
        assert "pitchfork" in str(criterion.outcome.why)


def test_a_stable_range_is_followed_beyond_the_sweep() -> None:
    device = Device(0.1245, 0.5, 9.8, 0.70, 3.0, 2.0, 45.0)
    wide = {
        point.label: point.sweep_value for point in solve(Sweep(device, Parameter.LENGTH, 0.5, 2.0)).critical_points
    }
    above = ending_beyond(device, Parameter.LENGTH, 0.75, 1.0)
    below = ending_beyond(device, Parameter.LENGTH, 0.65, -1.0)
    assert above is not None
    assert below is not None
    assert (above.event, below.event) == (Event.FOLD, Event.PERIOD_DOUBLING)
    assert above.sweep_value == pytest.approx(wide["C1"], rel=1e-15)
    assert below.sweep_value == pytest.approx(wide["B1"], rel=1e-15)
    assert ending_beyond(device, Parameter.INCLINATION, 30.0, -1.0) is None
    assert ending_beyond(device, Parameter.LENGTH, 0.6, 1.0) is None


SCENARIO = """schema_version: 1
device: {{capsule_mass_kg: {mass!r}, restitution: {r!r}, length_m: {length!r}}}
excitation: {{amplitude_n: {force!r}, frequency_hz: {frequency!r}}}
inclination_deg: {angle!r}
gravity_m_s2: 9.8
requirements: {{margin_any_percent: 8, margin_period_doubling_percent: 5, acceleration_at_most_g: 3}}
"""


def judged(device: Device, parameter: Parameter | None) -> tuple[Any, ...]:
    """What a scenario without a sweep, or with one, says of margins and requirements, and its exit code."""
    text = SCENARIO.format(
        mass=device.capsule_mass_kg, r=device.restitution, length=device.length_m, force=device.amplitude_n,
        frequency=device.frequency_hz, angle=device.inclination_deg,
    )  # fmt: skip
    if parameter is not None:
        value = float(getattr(device, parameter))
        start, end = (0, 90) if parameter is Parameter.INCLINATION else (value / 1.3, value * 1.2)
        text += f"sweep: {{parameter: {parameter.value}, from: {start!r}, to: {end!r}}}\n"
    loaded = loads(text)
    study, exit_code = analyse(loaded, ["json"]), results_outcome(loaded, "", ["json"]).exit_code
    design = study.solution.design
    margins = [
        (ending.parameter, ending.event, ending.sweep_value, ending.distance, ending.error_bound)
        for ending in design.endings()
    ]
    fact = study.verdict.margin
    outcomes = [
        (criterion.key, criterion.passed, criterion.outcome.value, criterion.outcome.margin)
        for criterion in study.criteria
    ]
    return (
        margins,
        outcomes,
        study.verdict.status,
        study.verdict.word,
        fact and fact.data.to_use.relative,
        exit_code,
    )


@pytest.mark.slow
@pytest.mark.parametrize("part", first(1, range(3)))
def test_no_sweep_changes_margins_verdict_or_exit_code(part: int) -> None:
    """Over nine scenarios, each alone and along all parameters, the first along one of them."""
    for sweep in random_sweeps(4, 77 + part)[: 1 if part == 0 else 4]:
        alone = judged(sweep.device, None)
        for parameter in list(DRIVING)[: 1 if part == 0 else None]:
            assert judged(sweep.device, parameter) == alone, (sweep.device, parameter)


def apart_at_bottom(attractor: Any, velocity: float, phi: float) -> float:
    """How far the bottom impact of a simulated cycle is from a motion's, in velocity and phase."""
    row = int(np.argmax(attractor.cycle.wall))
    return apart((attractor.cycle.velocity[row], attractor.cycle.phase[row]), (velocity, phi))


@pytest.mark.slow
def test_the_simulation_stays_on_one_side_and_leaves_on_the_other() -> None:
    from vireport.simulation.attractors import find_attractor
    from vireport.simulation.events import BOTTOM, Impact

    tried = 0
    for (device, design), varied in product(stable_devices(12, 5), DesignInput):
        for end in ends(design, varied):
            if end is None or end.event is Event.PITCHFORK:
                continue
            place, tried = (end.point.closed.u, end.point.closed.phi_bottom), tried + 1
            for share, stays in ((-1e-3, True), (1e-3, False)):
                value = end.sweep_value + share * end.distance
                at = moved(device, varied, value)
                d, gbar, *_ = at.groups(Parameter.LENGTH, at.length_m).as_floats()
                u, phi = stable_near(device, varied, value, place, 0.3)[0] if stays else place
                velocity = float(orbits(u, phi, at.restitution, 1).velocity_bottom)
                attractor = find_attractor(Groups(d, gbar, at.restitution), Impact(BOTTOM, velocity * (1 + 1e-6), phi))
                same = attractor.word == "BT" and apart_at_bottom(attractor, velocity, phi) < 0.1
                assert same == stays, (device, varied, end, attractor)
    assert tried > 60


def test_an_end_that_is_not_polished_is_known_to_its_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    def never_settles(*_: Any) -> Any:
        raise NumericalError("did not settle")

    device = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0)
    exact = design_point(device, None).margins
    monkeypatch.setattr(margins, "solve_one_to_one", never_settles)
    rough = design_point(device, None).margins
    assert len(rough) == len(exact) > 5
    for one, other in zip(rough, exact, strict=True):
        assert (one.parameter, one.event) == (other.parameter, other.event)
        bound = one.point.error_bound
        assert abs(one.sweep_value - other.sweep_value) <= bound < 1e-4 * abs(other.sweep_value)


def test_ends_by_grazing_are_polished() -> None:
    touching = set()
    for device in (sweep.device for sweep in random_sweeps(6, seed=77)):
        for end in design_point(device, None).margins:
            if end.event is Event.GRAZING and end.point.rest is None:
                touching.add(end.parameter)
                assert end.point.error_bound < 1e-12 * abs(end.sweep_value), (device, end)
    assert touching > {DesignInput.LENGTH, DesignInput.RESTITUTION}


def test_the_nearest_end_of_all_and_in_each_input(example) -> None:
    design = analyse(example("design-point")).solution.design
    ends = design.limits()
    assert design.nearest is ends[0]
    assert {end.parameter for end in ends} == design.nearest_ends.keys()
    assert len(ends) > len(design.nearest_ends)
    for end in ends:
        assert abs(design.nearest_ends[end.parameter].distance) <= abs(end.distance)
        assert end.size == (np.inf if end.relative is None else abs(end.relative))
