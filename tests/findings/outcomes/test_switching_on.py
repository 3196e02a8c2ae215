"""Moments, ramps and windows of switching on, against a simulator of the tests' own, and against facts of the model."""

from __future__ import annotations

from math import acos, pi

import numpy as np
import pytest
from conftest import first, solved
from rest_devices import PAPER, device_of, found
from rest_simulator import outcome

from vireport import analyse, loads
from vireport.design.from_rest import Destination, FromRest, StartingDevice, Target
from vireport.design.outcomes_from_rest import outcomes_at
from vireport.design.point import motions_at
from vireport.findings.outcomes.moments import PHASES, RAMPS, outcomes_by_moment, ramped, unpressed
from vireport.findings.outcomes.outcomes import switched_on_by
from vireport.findings.outcomes.windows import over_sweep, window, window_of
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions
from vireport.physics.numbers import ARRAYS, FLOATS
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import attractors
from vireport.simulation.events import BOTTOM, Impact
from vireport.simulation.release import presses


def test_switching_on_while_the_ball_is_pressed_down_is_one_trajectory() -> None:
    groups = PAPER.with_values({Parameter.AMPLITUDE: 3.6}).groups(Parameter.LENGTH, 0.75).as_floats()
    ((_, share, _),) = presses(groups)
    assert share == pytest.approx(acos(-groups.gbar) / pi)
    reached = attractors(groups, [Impact(BOTTOM, 0.0, share * pi * part) for part in (0.0, 0.3, 0.999)])[0]
    assert {(end.word, end.period) for end in reached} == {("B~", 3)}
    parts = outcomes_by_moment(StartingDevice(groups), 0.0, False)
    assert sum(part for part, _ in parts) == pytest.approx(1)
    assert parts[0][0] == pytest.approx(share)


def test_a_force_with_harmonics_presses_and_leaves_the_ball_as_its_pull_says() -> None:
    """Shares of the period, releases and the moments between, against the sign of the pull at many phases."""
    rng, several = np.random.default_rng(11), 0
    x = 2 * pi * (np.arange(200_000) + 0.5) / 200_000
    for _ in range(30):
        harmonics = tuple(Harmonic.of(j, rng.uniform(0, 50), rng.uniform(0, 360)) for j in (2, 3, 5))
        groups = Groups(0.5, rng.uniform(0, 0.9), 0.5, harmonics)
        pressed = groups.pull(groups.wave(x, ARRAYS).force) > 0
        told = presses(groups)
        assert sum(each.share for each in told) == pytest.approx(pressed.mean(), abs=1e-4)
        assert sum(each.free for each in told) == pytest.approx(2 * pi * (1 - pressed.mean()), abs=1e-3)
        assert len(told) == np.count_nonzero(pressed & ~np.roll(pressed, -1))
        for each in told:
            before, after = (groups.pull(groups.wave(each.release + off, FLOATS).force) for off in (-1e-6, 1e-6))
            assert before > 0 > after
        free = np.array(unpressed(told, PHASES))
        assert (groups.pull(groups.wave(free, ARRAYS).force) < 0).all()
        several += len(told) > 1
    assert several > 5


def test_intervals_of_pressure_and_without_it_follow_one_another_and_fill_the_period() -> None:
    """Also where the acceleration of a ball at rest only touches zero, as of cos x + cos(2x)/2 at half the force."""
    rng = np.random.default_rng(5)
    forces = [(), *((Harmonic.of(2, 50.0, phase),) for phase in (0.0, 180.0))]
    forces += [tuple(Harmonic.of(j, rng.uniform(0, 60), rng.uniform(0, 360)) for j in (2, 3)) for _ in range(20)]
    for harmonics in forces:
        for gravity in (0.5, rng.uniform(0, 0.7)):
            intervals = presses(Groups(0.5, gravity, 0.5, harmonics))
            assert intervals
            assert intervals == sorted(intervals)
            assert sum(2 * pi * press.share + press.free for press in intervals) == pytest.approx(2 * pi)
            for press, following in zip(intervals, [*intervals[1:], *intervals[:1]], strict=True):
                begin = following.release - 2 * pi * following.share
                assert np.exp(1j * (press.release + press.free)) == pytest.approx(np.exp(1j * begin), abs=1e-9)


@pytest.mark.parametrize(("force", "least", "most"), [(3.0, 1.0, 1.0), (3.6, 0.2, 0.26), (4.5, 1.0, 1.0)])
def test_the_share_of_switch_on_moments_is_that_of_starts_simulated_one_by_one(force, least, most) -> None:
    """A ball that is not pressed down when the force sets in leaves at another phase than one that comes to rest: where
    it rests for the first time it has not come back to where it began."""
    device = PAPER.with_values({Parameter.AMPLITUDE: force})
    groups = device.groups(Parameter.LENGTH, 0.75).as_floats()
    motions, _, _ = motions_at(device, Parameter.LENGTH)
    outcomes = outcomes_by_moment(StartingDevice(groups, Target.of(motions)), 0.0, True)
    told = sum(part for part, end in outcomes if end.is_one_to_one)
    starts = [Impact(BOTTOM, 0.0, phase) for phase in 2 * pi * (np.arange(100) + 0.5) / 100]
    simulated = np.mean([end.word == "BT" for end in attractors(groups, starts)[0]])
    assert least - 1e-12 <= told <= most + 1e-12
    assert told == pytest.approx(simulated, abs=0.03)


@pytest.mark.slow
def test_a_ramp_helps_where_switching_on_at_once_does_not() -> None:
    """At 3.6 N, 3 periods for nearly all moments, 20 for all."""
    solution = solved("inclined-forcing", excitation__amplitude_n=3.6, sweep=None)
    from vireport.findings.outcomes.keys import DisturbancesBlock

    (rest, at_once), (_, short), (ramped, long) = (
        switched_on_by(solution, DisturbancesBlock(ramp_periods=periods), compiled=True) for periods in (0.0, 3.0, 20.0)
    )
    assert not rest.from_rest.is_one_to_one
    assert 0.1 < at_once.share < 0.4
    assert 0.7 < short.share < 1
    assert long.share == pytest.approx(1)
    assert ramped.from_rest.is_one_to_one
    assert long.ramp is None
    assert at_once.ramp.periods in RAMPS
    assert 3 < at_once.ramp.periods <= 20


@pytest.mark.parametrize("restitution", first(1, [0.5, Restitutions(0.55, 0.4)]))
def test_a_ramp_is_the_motion_under_a_force_of_as_many_half_waves(restitution) -> None:
    """Integrated with the amplitude of each half wave, from the state before it, by small steps."""
    groups, phase, periods = Groups(0.4, 0.3, restitution), 1.0, 3
    wall, position, velocity, end = ramped(groups, phase, periods)
    h, t, elapsed = 5e-5, phase / pi, 0.0
    z, v, amplitude, half = groups.d / 2, 0.0, 0.0, None
    while True:
        current = np.floor(t - 0.5)
        if current != half:
            if elapsed >= 2 * periods - 1e-9:
                break
            half, until = current, current + 1.5
            amplitude = min((elapsed + (until - t) / 2) / (2 * periods), 1)
        step = min(h, until - t) if until - t > 1e-12 else h
        force = groups.gbar + amplitude * np.cos(pi * (t + step / 2))
        z, v = z + v * step + force * step * step / 2, v + force * step
        if abs(z) > groups.d / 2:
            z = np.copysign(groups.d / 2, z)
            v = -groups.restitution_at(int(np.sign(z))) * v if v * z > 0 else v
        t, elapsed = t + step, elapsed + step
    if wall:
        assert abs(abs(z) - groups.d / 2) < 1e-3
    else:
        assert (z, v) == pytest.approx((position, velocity), abs=5e-3)
    assert np.cos(end) == pytest.approx(0, abs=1e-9)


@pytest.mark.slow
def test_a_window_ends_where_the_outcome_changes() -> None:
    device = PAPER.with_values({Parameter.AMPLITUDE: 3.6})

    def outcomes(values):
        return outcomes_at(device, Parameter.AMPLITUDE, values, False)

    around = window(Parameter.AMPLITUDE, 3.6, 3.595, 3.612, outcomes)
    assert around.low.beyond is None
    assert around.low.value == 3.595
    edge, step = around.high.value, 4e-9
    before, after = outcomes(np.array([edge - step, edge + step]))
    assert (before.destination, before.periods) == ("rest_cycle", 3)
    assert after.kind != before.kind != around.high.beyond.kind
    assert around.nearest is around.high


def test_most_windows_end_at_the_nearest_of_edges_that_accumulate() -> None:
    """Bands of another outcome, each 2 % as wide as it is far from where they accumulate; samples miss some."""
    here, there = FromRest(Destination.ONE_TO_ONE, "BT", 1), FromRest(Destination.REST_CYCLE, "B~", 3)
    found = 0
    for shift in np.linspace(0, 0.5, 20, endpoint=False):
        far = 0.2 * 10 ** -(np.arange(6, 20) / 2 + shift)

        def outcomes(values, far=far):
            off = 1.2 - np.asarray(values)
            other = (np.abs(off[:, None] / far - 1) < 0.01).any(axis=1) | (off <= 0)
            return [there if changed else here for changed in other]

        around = window(Parameter.LENGTH, 1.0, 0.9, 1.3, outcomes)
        assert outcomes([around.high.value]) == [here]
        found += abs(around.high.value - 1.2 + 1.01 * far[0]) < 2e-9
    assert found >= 14


def window_by_the_own_simulator(device: Device, varied: Parameter, reach: float = 0.2) -> int:
    """Edges of a window that are right to 1e-9 of the value: on them the outcome is still that of the design point, and
    on the next value looked at it is not. Those are left out at which the simulation does not tell what is beyond, and
    those at which another motion than 1:1 loses its stability, which next to them takes for ever to show. Where edges
    accumulate the one given may be that of a stretch so narrow that 64 bits and 80 do not agree that it is there."""
    value, seen = float(getattr(device, varied)), {}

    def outcomes(values):
        told = list(outcomes_at(device, varied, values, True))
        seen.update(zip(values.tolist(), told, strict=True))
        return told

    def own(at: float):
        one = device.with_values({varied: at})
        return outcome(*one.groups(Parameter.LENGTH, one.length_m).as_floats()[:3], impacts=250)

    around, held = window(varied, value, value * (1 - reach), value * (1 + reach), outcomes), 0
    here = seen[value]
    told = here.destination, "" if "~" in here.word else here.word, here.periods
    for side, edge in ((-1, around.low), (1, around.high)):
        if edge.beyond is None or not (edge.beyond.decided and here.periods):
            continue
        beyond = min((at for at in seen if (at - edge.value) * side > 0), key=lambda at: abs(at - edge.value))
        assert abs(beyond - edge.value) <= 1.01e-9 * value
        inside, outside = own(edge.value), own(beyond)
        if inside is not None:
            assert inside == told, (device, varied, side)
            assert outside != told or edge.accumulates, (device, varied, side)
            held += 1
    return held


@pytest.mark.slow
def test_an_edge_of_a_window_is_right_on_both_sides() -> None:
    """Where a rest cycle ends, its last hops are cut off by the release."""
    assert window_by_the_own_simulator(PAPER.with_values({Parameter.AMPLITUDE: 3.6}), Parameter.AMPLITUDE, 0.002) == 1


@pytest.mark.slow
def test_edges_of_four_windows_are_right_on_both_sides() -> None:
    devices = [(PAPER.with_values({Parameter.AMPLITUDE: force}), Parameter.AMPLITUDE) for force in (2.2, 4.0)]
    devices += [
        (PAPER.with_values({Parameter.AMPLITUDE: 3.0, Parameter.LENGTH: length}), Parameter.LENGTH)
        for length in (0.93, 1.1)
    ]
    rng, swept = np.random.default_rng(7), (Parameter.LENGTH, Parameter.AMPLITUDE, Parameter.FREQUENCY)
    while len(devices) < 120:
        device = device_of(rng.uniform(0.1, 0.6), rng.uniform(0.05, 0.8), rng.uniform(0.3, 0.7))
        told, parameter = found(device, True), swept[len(devices) % 3]
        if told.is_one_to_one or (told.destination is Destination.REST_CYCLE and told.periods):
            devices.append((device, parameter))
    windows = 0
    for device, parameter in devices:
        windows += window_by_the_own_simulator(device, parameter) > 0
        if windows == 4:
            break
    assert windows == 4


@pytest.mark.slow
def test_a_window_ends_with_the_stable_motion() -> None:
    """At B1, next to which the simulation takes for ever."""
    solution = solved("inclined-forcing", excitation__amplitude_n=5.345, sweep__from=5.342, sweep__to=5.36)
    edge = window_of(solution, True).high
    (end,) = (point for point in solution.critical_points if point.label == "B1")
    assert edge.value == pytest.approx(end.sweep_value, rel=1e-12)


def test_the_stretches_of_a_sweep_join_and_have_the_outcome_that_is_told(monkeypatch) -> None:
    monkeypatch.setattr("vireport.findings.outcomes.windows.SWEEP_VALUES", 9)

    def outcomes(values):
        return outcomes_at(PAPER, Parameter.AMPLITUDE, values, False)

    stretches = over_sweep(3.55, 3.7, outcomes)
    assert [part.start for part in stretches[1:]] == [part.end for part in stretches[:-1]]
    assert (stretches[0].start, stretches[-1].end) == (3.55, 3.7)
    assert len(stretches) > 1
    values = np.linspace(3.55, 3.7, 9)
    for value, own in zip(values, outcomes(values), strict=True):
        (part,) = [part for part in stretches if part.start <= value <= part.end]
        assert part.outcome.kind == own.kind


@pytest.mark.slow
def test_the_verdict_is_not_green_where_the_motion_is_not_reached_from_rest() -> None:
    text = """
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 0.75}
excitation: {amplitude_n: 3.6, frequency_hz: 2.0}
inclination_deg: 45.0
requirements: {reached_from_rest: true, recovers_within_periods: 20}
"""
    study = analyse(loads(text), ("json",))
    verdict = study.verdict
    assert (verdict.status, verdict.word) == ("bad", "Requirements not met")
    assert [line.passed for line in study.criteria] == [False, True]
    bare = analyse(loads(text.partition("requirements")[0]), ("json",))
    assert (bare.verdict.status, bare.verdict.word) == ("caution", "Stable, but not reached from rest")
    assert bare.to_dict()["disturbances"]["from_rest"]["periods"] == 3
    ramped = analyse(loads(text + "disturbances: {ramp_periods: 20}\n"), ("json",))
    assert [line.passed for line in ramped.criteria] == [True, True]
    assert ramped.verdict.status != "bad"


RESTING = """
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 1.1}
excitation: {amplitude_n: 2.0, frequency_hz: 2.0}
inclination_deg: 45.0
"""
"""A device without stable 1:1 motion that comes to rest every 8 periods, while a third of the starts bounce on for ever
at the bottom alone."""


@pytest.mark.slow
def test_a_motion_that_starts_find_stands_beside_the_rest_cycle_with_its_share_and_shock() -> None:
    found = analyse(loads(RESTING + "disturbances: {}\n"), ("json",)).outcomes.attracting
    motion, rest = found.motions
    assert (motion.name, motion.from_rest, rest.motion, rest.from_rest) == (
        "B every 2 forcing periods",
        False,
        None,
        True,
    )
    assert 0.05 < motion.share < 0.95
    assert motion.share + rest.share == pytest.approx(1, abs=0.05)
    assert motion.shock.jump > 0
