"""What is proved of a stable motion, attacked: by random states in its regions and cells, and where it is false."""

from __future__ import annotations

import copy
import json
from functools import cache
from math import pi
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf
from msgspec.structs import replace

from vireport import analyse, loads, recheck_disturbances
from vireport.base.errors import UsageError
from vireport.design.point import motions_at
from vireport.findings.outcomes.deviations import lap_matrix
from vireport.findings.outcomes.shock import shocked
from vireport.findings.proofs.cells import Cells, generations
from vireport.findings.proofs.flights import (
    ERRORS,
    FIRST,
    SECOND,
    SYMBOLS,
    TIME,
    ImpactSets,
    Sets,
    after_impact,
    enclosed,
    exact,
    impacts_past_a_touch,
    merged,
    middles,
    next_impacts,
    simulated,
    simulated_past,
)
from vireport.findings.proofs.following import Goal, come_in, patience
from vireport.findings.proofs.itineraries import RETURNS, follow_cells, settles
from vireport.findings.proofs.proved import Arrival, Proved, ProvedRegion, prove_again, rounded_down
from vireport.findings.proofs.release import PRECISIONS, reaches
from vireport.findings.proofs.section import (
    Section,
    _arrives,
    _Covered,
    _first_cells,
    _first_moments,
    proved_section,
    section_again,
)
from vireport.findings.proofs.survived import MOMENTS, SIZES, survived, survived_again
from vireport.findings.proofs.trap import Trap, lap_derivative, norm_bound, proved_trap, trap_of
from vireport.physics import flight
from vireport.physics.affine import Affine, between
from vireport.physics.device import Device
from vireport.physics.groups import Groups, Restitutions
from vireport.physics.motion import Motion
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import check_model, follow_impacts
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, TURN, VELOCITY, WALL
from vireport.study.checks.enclosures import UnprovedError

TEXT = """\
schema_version: 1
device: {{capsule_mass_kg: 0.1245, restitution: 0.5, length_m: {length}}}
excitation: {{amplitude_n: {force}, frequency_hz: 2}}
inclination_deg: {beta}
disturbances: {{prove: true}}
"""


def device(force: float = 3.6, length: float = 0.75, beta: float = 45.0, restitution: Any = 0.5) -> Device:
    return Device(0.1245, restitution, 9.8, length, force, 2.0, beta)


@cache
def stable(
    force: float = 3.6, length: float = 0.75, beta: float = 45.0, restitution: Any = 0.5
) -> tuple[Groups, Motion, Trap]:
    """A device with its first stable motion, and the region about that."""
    of = device(force, length, beta, restitution)
    found, _, _ = motions_at(of, Parameter.LENGTH)
    groups, row = of.groups(Parameter.LENGTH, length).as_floats(), int(np.flatnonzero(found.stable_mask)[0])
    motion = found.motion(row, 1)
    trap = trap_of(groups, motion, True)
    assert trap is not None
    return groups, motion, trap


def followed(groups: Groups, wall: int, time: np.ndarray, velocity: np.ndarray, impacts: int) -> np.ndarray:
    """Impacts of many starts on one membrane, (n, impacts + 1, 6)."""
    starts = np.zeros((len(time), 4))
    starts[:, 0], starts[:, 2], starts[:, 3] = wall, velocity, np.mod(pi * time, TURN) % TURN
    return follow_impacts(np.repeat(check_model(groups), len(time), axis=0), starts, impacts)[0]


def size(trap: Trap, late: np.ndarray, fast: np.ndarray) -> np.ndarray:
    return np.linalg.norm(trap.metric @ np.stack([late, fast]), axis=0)


def within(trap: Trap, count: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Random deviations in a region, more of them near its border."""
    angle, radius = TURN * random.random(count), trap.radius * random.random(count) ** 0.25
    late, fast = np.linalg.inv(trap.metric) @ (radius * np.stack([np.cos(angle), np.sin(angle)]))
    return late, fast


def mapped(groups: Groups, trap: Trap, late: np.ndarray, fast: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    motion = trap.motion
    rows = followed(groups, motion.word.walls[0], motion.time[0] + late, motion.velocity[0] + fast, len(motion.word))
    last = rows[:, -1]
    assert (last[:, WALL] == motion.word.walls[0]).all()
    ahead = (last[:, PHASE] - pi * motion.time[0] + pi) % TURN - pi
    return ahead / pi, last[:, VELOCITY] - motion.velocity[0]


@pytest.mark.parametrize(
    ("force", "length", "beta"),
    [
        (3.6, 0.75, 45.0),
        pytest.param(5.2, 0.75, 45.0, marks=pytest.mark.slow),
        pytest.param(5.0, 0.5554, 0.0, marks=pytest.mark.slow),
    ],
)
def test_what_is_in_a_region_comes_nearer_to_the_motion_and_to_one_another(force, length, beta) -> None:
    (groups, _, trap), random = stable(force, length, beta), np.random.default_rng(1)
    assert 0 < trap.contraction < 1
    late, fast = within(trap, 2000, random)
    there = mapped(groups, trap, late, fast)
    assert (size(trap, *there) <= trap.contraction * size(trap, late, fast) + trap.off + 1e-12).all()
    apart = size(trap, np.diff(late), np.diff(fast))
    assert (size(trap, np.diff(there[0]), np.diff(there[1])) <= trap.contraction * apart + 1e-12).all()


def test_no_region_about_an_unstable_motion_contracts() -> None:
    """Beyond B1, in any metric: not in one that suits a stable motion of the same device, nor in the plain one."""
    beyond = device(5.5)
    found, _, _ = motions_at(beyond, Parameter.LENGTH)
    groups = beyond.groups(Parameter.LENGTH, 0.75).as_floats()
    metrics = np.eye(2), stable(5.2)[2].metric
    for row in np.flatnonzero(found.admissible_mask & ~found.stable_mask):
        motion = found.motion(int(row), 1)
        assert trap_of(groups, motion, True) is None
        for metric in metrics:
            for radius in (1e-1, 1e-3, 1e-6):
                assert proved_trap(groups, motion, metric, radius, True) is None


def test_the_size_of_a_set_bounds_that_of_all_its_states() -> None:
    """In the metric, whichever way the set lies; it is inside only before an impact on the motion's own membrane."""
    _, motion, trap = stable(3.6)
    random, count = np.random.default_rng(9), 400
    inverse, symbols = np.linalg.inv(trap.metric), np.zeros((2, SYMBOLS, count))
    middle = inverse @ (trap.radius * random.uniform(-1, 1, (2, count)))
    symbols[:, [FIRST, SECOND]] = 0.3 * trap.radius * random.uniform(-1, 1, (2, 2, count)) * np.abs(inverse).sum()
    time, velocity = (Affine(x, y, np.zeros(count)) for x, y in zip(middle, symbols, strict=True))
    largest = trap.size(time, velocity)
    for x in CORNERS:
        late, fast = middle + np.einsum("s,csk->ck", x, symbols[:, [FIRST, SECOND]])
        assert (size(trap, late, fast) <= largest).all()
    assert (largest >= size(trap, *middle)).all()
    at = time + float(motion.time[0]) + 4.0, velocity + float(motion.velocity[0])
    walls = np.full(count, motion.word.walls[0])
    assert (trap.holds(walls, *at) == (largest <= trap.radius)).mean() > 0.99
    assert 0 < trap.holds(walls, *at).mean() < 1
    assert not trap.holds(-walls, *at).any()


def test_derivatives_of_a_region_are_those_of_the_flights_also_of_membranes_that_differ() -> None:
    groups, motion, trap = stable(3.6, restitution=Restitutions(0.55, 0.42))
    time, velocity = (exact(np.array([value])) for value in (motion.time[0], motion.velocity[0]))
    found = np.array([[float(entry.centre[0]) for entry in lap_derivative(groups, motion, time, velocity, True)]])
    assert found.reshape(2, 2) == pytest.approx(lap_matrix(groups, motion), rel=1e-9)
    assert np.linalg.det(lap_matrix(groups, motion)) == pytest.approx((0.55 * 0.42) ** 2, rel=1e-9)
    assert trap.contraction >= np.linalg.norm(trap.metric @ found.reshape(2, 2) @ np.linalg.inv(trap.metric), 2)


def test_a_norm_bounds_that_of_every_matrix_that_is_enclosed() -> None:
    random, metric = np.random.default_rng(10), np.array([[1.7, -0.6], [0.0, 0.8]])
    entries = [
        Affine(x, y, np.zeros(30))
        for x, y in zip(*(random.normal(size=(4, *n, 30)) for n in ((), (SYMBOLS,))), strict=True)
    ]
    largest = 0.0
    for x in random.choice([-1.0, 1.0], (60, SYMBOLS)):
        matrices = np.stack([entry.centre + x @ entry.linear for entry in entries], axis=1).reshape(-1, 2, 2)
        largest = max(largest, np.linalg.norm(metric @ matrices @ np.linalg.inv(metric), 2, axis=(1, 2)).max())
    assert largest <= norm_bound(metric, entries) < 2 * largest


def test_tiles_cover_the_region_and_overlap(monkeypatch: pytest.MonkeyPatch) -> None:
    groups, motion, trap = stable(3.6)
    tiles: list[Affine] = []

    def unproved(of: Groups, about: Motion, time: Affine, velocity: Affine, compiled: bool) -> None:
        tiles.extend([time, velocity])

    monkeypatch.setattr("vireport.findings.proofs.trap.lap_derivative", unproved)
    assert proved_trap(groups, motion, trap.metric, trap.radius, True) is None
    about = np.array([motion.time[0], motion.velocity[0]])[:, None]
    middles = trap.metric @ (np.stack([tile.centre for tile in tiles]) - about)
    sides = trap.metric @ np.stack([[tile.linear[k, 0] for k in (FIRST, SECOND)] for tile in tiles])
    assert sides == pytest.approx(sides[0, 0] * np.eye(2), abs=1e-12)
    points = trap.metric @ np.stack(within(trap, 4000, np.random.default_rng(11)))
    apart = np.abs(points[:, :, None] - middles[:, None]).max(axis=0)
    assert (apart.min(axis=1) <= sides[0, 0]).all()
    steps = np.diff(np.unique(np.round(middles[0] / trap.radius, 9))) * trap.radius
    assert (steps < 2 * sides[0, 0] * (1 - 1e-7)).all()


def sets_of(groups: Groups, wall, time, velocity, widths) -> Sets:
    """Rectangles of time and velocity before impacts, as the sets that begin the next flights."""
    count = len(time)
    linear = np.zeros((2, SYMBOLS, count))
    linear[0, FIRST], linear[1, SECOND] = widths
    at = Affine(time, linear[0], np.zeros(count)), Affine(velocity, linear[1], np.zeros(count))
    return after_impact(enclosed(groups), ImpactSets(np.ones(count, dtype=bool), wall, *at, at[0]), slice(None))


def encloses(found: Affine, corner: tuple[float, float], value: np.ndarray) -> np.ndarray:
    """Whether a value is what a number can be where its first two symbols are given."""
    known = found.centre + corner[0] * found.linear[FIRST] + corner[1] * found.linear[SECOND]
    return np.abs(value - known) <= np.abs(found.linear[2:]).sum(axis=0) + found.radius + 1e-12


CORNERS = [*np.random.default_rng(4).uniform(-1, 1, (20, 2)), (1, 1), (-1, 1), (1, -1), (-1, -1)]


def first_impacts(groups: Groups, wall, time, velocity) -> np.ndarray:
    """The impact that follows each of many states before impacts on either membrane, (n, 6)."""
    rows = [followed(groups, side, time, velocity, 1)[:, -1] for side in (1, -1)]
    return np.where(wall[:, None] > 0, *rows)


def check_next_impacts(groups: Groups, wall, time, velocity, widths) -> tuple[np.ndarray, list[int]]:
    """Every state of a set, wherever its flight ends: same membrane, time and velocity within the enclosure.

    Where some states of a set touch a membrane, each is in one of the two enclosures. Which sets are proved, and how
    often a state was in either enclosure of such a set.
    """
    sets = sets_of(groups, wall, time, velocity, widths)
    guesses = simulated(groups, middles(groups, sets), True)
    ends = next_impacts(enclosed(groups), sets, guesses)
    failing = np.flatnonzero(~ends.proved)
    past = simulated_past(groups, sets[failing], guesses[failing], True)
    touch, beyond, touching = impacts_past_a_touch(enclosed(groups), sets[failing], past)
    told, own = [0, 0], np.flatnonzero(ends.proved)
    for kind in (ends[own], beyond, touching):  # no state of a set depends on a time within its flight
        assert not any(number.linear[TIME].any() for number in (kind.time, kind.velocity, kind.duration))
    for corner in CORNERS:
        last = first_impacts(groups, wall, time + corner[0] * widths[0], velocity + corner[1] * widths[1])
        assert (last[own, WALL] == ends.wall[own]).all()
        assert encloses(ends.duration[own], corner, last[own, FLIGHT]).all()
        assert encloses(ends.velocity[own], corner, last[own, VELOCITY]).all()
        last, holds = last[failing[touch]], []
        for k, kind in enumerate((beyond, touching)):
            holds.append((last[:, WALL] == kind.wall) & encloses(kind.duration, corner, last[:, FLIGHT]))
            holds[-1] &= encloses(kind.velocity, corner, last[:, VELOCITY])
            told[k] += int(holds[-1].sum())
        assert (holds[0] | holds[1]).all()
    return ends.proved, told


def test_enclosures_of_next_impacts_hold_what_is_simulated() -> None:
    groups, random, count = Groups(0.415, 0.24, 0.5), np.random.default_rng(2), 1500
    wall, time = random.choice([1, -1], count), 2 * random.random(count)
    velocity, widths = wall * (0.05 + random.random(count)), 10 ** random.uniform(-4, -1.3, (2, count))
    proved, told = check_next_impacts(groups, wall, time, velocity, widths)
    assert proved.mean() > 0.5
    assert min(told) > 50


@pytest.mark.slow
@pytest.mark.parametrize("d", [0.2, 0.415, 1.2])
def test_no_set_is_proved_of_which_states_come_to_different_impacts(d: float) -> None:
    """Sets that a membrane cuts in two: some states touch it on the way, others do not; and sets that arrive slowly."""
    groups, random, count = Groups(d, 0.24, Restitutions(0.6, 0.3)), np.random.default_rng(5), 20_000
    wall, time = random.choice([1, -1], count), 2 * random.random(count)
    velocity, widths = wall * (0.02 + random.random(count)), 10 ** random.uniform(-3, -1, (2, count))
    widths[1] = np.minimum(widths[1], 0.9 * np.abs(velocity))
    rows = [first_impacts(groups, wall, time + x * widths[0], velocity + y * widths[1]) for x, y in CORNERS]
    sides, flights, speeds = (np.stack([row[:, column] for row in rows]) for column in (WALL, FLIGHT, VELOCITY))
    apart = np.diff(np.sort(flights, axis=0), axis=0).max(axis=0)
    cut = (np.ptp(sides, axis=0) > 0) | (apart > 0.3)
    torn, slow = (np.flatnonzero(kind)[:1500] for kind in (cut, ~cut & (np.abs(speeds).min(axis=0) < 0.1)))
    assert min(len(torn), len(slow)) > 100
    proved, told = check_next_impacts(groups, wall[torn], time[torn], velocity[torn], widths[:, torn])
    assert not proved.any()
    assert min(told) > 50
    proved, _ = check_next_impacts(groups, wall[slow], time[slow], velocity[slow], widths[:, slow])
    assert 0 < proved.mean() < 1


def test_enclosures_after_shocks_hold_what_is_simulated() -> None:
    """Shocks of any size at any moment, also such as throw the ball back onto the membrane it has left."""
    groups, motion, _ = stable(3.6)
    random, count = np.random.default_rng(6), 3000
    model, proved = np.repeat(check_model(groups), count, axis=0), []
    for impact, duration in enumerate(motion.durations):
        wall, widths = motion.word.walls[impact], 10 ** random.uniform(-4, -1, (2, count))
        share, jump = random.uniform(0.1, 0.9, count) ** 2, random.uniform(-1, 1, count)
        widths[0] = np.minimum(widths[0], 0.9 * share)
        since = between(share - widths[0], share + widths[0], FIRST, SYMBOLS) * duration
        added = between(jump - widths[1], jump + widths[1], SECOND, SYMBOLS)
        time, after = (exact(np.full(count, x)) for x in (motion.time[impact], -0.5 * motion.velocity[impact]))
        sets = Sets(np.full(count, wall), time, after + added, added * since * float(wall), since)
        guesses = simulated(groups, shocked(groups, motion, impact, share * duration, jump), True)
        ends = next_impacts(enclosed(groups), sets, guesses)
        own = np.flatnonzero(ends.proved)
        proved.append((len(own) / count, np.mean(ends.wall[own] == wall)))
        sides = []
        for corner in CORNERS:
            delay, jumps = (share + corner[0] * widths[0]) * duration, jump + corner[1] * widths[1]
            last = follow_impacts(model, shocked(groups, motion, impact, delay, jumps), 1)[0][:, -1]
            sides.append(last[:, WALL])
            last = last[own]
            assert (last[:, WALL] == ends.wall[own]).all()
            assert encloses(ends.duration[own], corner, delay[own] + last[:, FLIGHT]).all()
            assert encloses(ends.velocity[own], corner, last[:, VELOCITY]).all()
        torn = np.ptp(sides, axis=0) > 0
        assert torn.sum() > 20
        assert not ends.proved[torn].any()
    assert np.min(proved) > 0.05


def test_a_merged_set_holds_the_one_it_is_made_of() -> None:
    """By how far either reaches in any direction: a box of roundings beside two sides that are nearly parallel."""
    random = np.random.default_rng(7)
    linear, radius = random.normal(size=(2, SYMBOLS, 200)), np.abs(random.normal(size=(2, 200)))
    linear[:, TIME], linear[1, 3] = 0.0, linear[0, 3] * linear[1, 2] / linear[0, 2] * (1 + 1e-9)
    merged_set = merged(*(Affine(np.zeros(200), own, rest) for own, rest in zip(linear, radius, strict=True)))
    for angle in np.linspace(0, pi, 60):
        way = np.array([np.cos(angle), np.sin(angle)])
        before = np.abs(np.einsum("c,csk->sk", way, linear)).sum(axis=0) + np.abs(way) @ radius
        now = np.abs(np.einsum("c,csk->sk", way, [each.linear for each in merged_set])).sum(axis=0)
        assert (before <= now * (1 + 1e-12)).all()


def test_a_merged_set_holds_the_one_it_is_made_of_to_the_last_bit() -> None:
    """By its own two coordinates, which no state of the set before exceeds."""
    random = np.random.default_rng(8)
    linear, radius = random.normal(size=(2, SYMBOLS, 60)), np.abs(random.normal(size=(2, 60)))
    linear[:, TIME] = 0.0
    whole = merged(*(Affine(np.zeros(60), own, rest) for own, rest in zip(linear, radius, strict=True)))
    axes = np.stack([each.linear[ERRORS] for each in whole])
    with mp.workdps(40):
        for k in range(60):
            (a, b), (c, d) = ([mpf(x) for x in row] for row in axes[:, :, k])
            for row in ((d, -b), (-c, a)):
                own = [*linear[:, ERRORS, k].T, (radius[0, k], 0.0), (0.0, radius[1, k])]
                assert sum(abs(row[0] * mpf(x) + row[1] * mpf(y)) for x, y in own) <= abs(a * d - b * c)


def test_the_groups_of_a_device_are_enclosed() -> None:
    """d = 4 M s f^2/F and gbar = M g sin(beta)/F, whose doubles are rounded."""
    random = np.random.default_rng(9)
    with mp.workdps(40):
        for mass, length, force, frequency, beta in random.uniform(0.1, 10, (50, 5)):
            of = Device(mass, 0.5, 9.8, length, force, frequency, beta)
            found = enclosed(of.groups(Parameter.LENGTH, length).as_floats())
            d = 4 * mpf(mass) * mpf(length) * mpf(frequency) ** 2 / mpf(force)
            gbar = mpf(mass) * mpf(9.8) * mp.sin(mp.radians(mpf(beta))) / mpf(force)
            for number, value in ((found.d, d), (found.gbar, gbar)):
                assert abs(value - mpf(number.centre[0])) <= mpf(number.radius[0]) < 1e-13 * value


def test_an_impact_that_is_not_the_next_one_is_not_proved_to_be_it() -> None:
    """Far from the other membrane, of a flight that goes on through the one it has left, the next return is guessed."""
    groups, random, count = Groups(3.0, 0.24, 0.5), np.random.default_rng(10), 600
    time, before, elapsed = 2 * random.random(count), 0.02 + random.random(count), np.linspace(0, 6, 1501)[1:, None]
    sets = sets_of(groups, np.ones(count, dtype=int), time, before, np.full((2, count), 1e-6))
    cosines = np.cos(pi * time), np.cos(pi * (time + elapsed))
    height = -flight.displacement(elapsed, -0.5 * before, np.sin(pi * time), *cosines, groups.gbar)
    returns = np.diff(np.sign(height), axis=0) < 0
    for turn, proved in ((1, True), (2, False)):
        met = np.cumsum(returns, axis=0) == turn
        own = np.flatnonzero(met.any(axis=0))
        assert len(own) > 20
        guesses = np.stack([np.ones(len(own)), elapsed[met[:, own].argmax(axis=0), 0], np.zeros(len(own))], axis=1)
        found = next_impacts(enclosed(groups), sets[own], guesses).proved
        assert found.mean() > 0.5 if proved else not found.any()


def test_a_shock_back_onto_the_membrane_is_not_proved_to_pass_it() -> None:
    """Gravity above the largest acceleration: thrown up at the top, and a little way through it, it would come down."""
    groups, random, count = Groups(0.5, 1.3, 0.5), np.random.default_rng(11), 100
    time, elapsed = random.uniform(0, 0.3, count), np.linspace(0, 3, 3001)[1:, None]
    for up, proved in ((False, True), (True, False)):
        jump = random.uniform(0.4, 0.45, count) * (-1 if up else 1)
        since = between(np.full(count, 0.0046), np.full(count, 0.0054), FIRST, SYMBOLS)
        added, after = exact(jump), exact(np.full(count, 0.3))
        sets = Sets(np.full(count, -1), exact(time), after + added, added * since * -1.0, since)
        cosines = np.cos(pi * time), np.cos(pi * (time + elapsed))
        fallen = flight.displacement(elapsed, 0.3 + jump, np.sin(pi * time), *cosines, groups.gbar) - 0.005 * jump
        arrival = elapsed[(fallen > groups.d).argmax(axis=0), 0] - 0.005
        found = next_impacts(
            enclosed(groups), sets, np.stack([np.ones(count), arrival, np.zeros(count)], axis=1)
        ).proved
        assert found.mean() > 0.5 if proved else not found.any()


def test_an_impact_shortly_after_the_next_one_is_not_proved_to_be_it() -> None:
    """The ball passes the other membrane slowly as its acceleration turns, comes back, and passes it again."""
    for gbar, lasts, slow in ((0.24, 0.9, 0.002), (0.24, 0.7, 0.001), (0.1, 1.1, 0.002), (0.4, 0.8, 0.001)):
        turn = TURN - np.arccos(-gbar)
        start = turn / pi - lasts
        after = -slow - gbar * lasts - (np.sin(turn) - np.sin(pi * start)) / pi
        elapsed = np.linspace(0, lasts + 0.3, 200_001)[1:]
        waves = np.sin(pi * start), np.cos(pi * start), np.cos(pi * (start + elapsed))
        height = flight.displacement(elapsed, after, *waves, gbar)
        d = float(np.interp(lasts, elapsed, height))
        sets = Sets(np.array([-1]), *(exact(np.array([x])) for x in (start, after, 0.0, 0.0)))
        first, later = elapsed[:-1][np.diff(np.sign(height - d)) > 0]
        assert first < lasts < later < 7 / 6 * first
        for guess, proved in ((first, True), (later, False)):
            found = next_impacts(enclosed(Groups(d, gbar, 0.5)), sets, np.array([[1.0, guess, 0.0]]))
            assert found.proved.tolist() == [proved]


def test_an_impact_before_the_flight_begins_is_not_proved_to_be_its_end() -> None:
    """After a shock the ball moves as if it had passed the membrane a little before; gravity throws it back."""
    gbar, since, d, count, random = 1.3, 1.0, 3.0, 40, np.random.default_rng(12)
    time, lowest, depth = (random.uniform(*ends, count) for ends in ((0, 2), (0.3, 0.4), (0.0005, 0.002)))
    after = -gbar * lowest - (np.sin(pi * (time + lowest)) - np.sin(pi * time)) / pi

    def moved(elapsed: np.ndarray) -> np.ndarray:
        waves = np.sin(pi * time), np.cos(pi * time), np.cos(pi * (time + elapsed))
        return flight.displacement(elapsed, after, *waves, gbar)

    offset, elapsed = -depth - moved(lowest), np.linspace(0, 4, 8001)[:, None]
    sets = Sets(np.full(count, -1), *(exact(x) for x in (time, after, offset, np.full(count, since))))
    height = offset + moved(elapsed)
    for wall, beyond, proved in ((-1, height < 0, False), (1, height > d, True)):
        guesses = np.stack([np.full(count, wall), elapsed[beyond.argmax(axis=0), 0] - since, np.zeros(count)], axis=1)
        assert (next_impacts(enclosed(Groups(d, gbar, 0.5)), sets, guesses).proved == proved).all()


def test_of_sets_that_arrive_slowly_every_state_that_is_proved_arrives() -> None:
    """Begun at distances so different that the last ones of a set turn back just before, or just after, they arrive."""
    groups, random, count, d = Groups(0.13, 0.0, 0.5), np.random.default_rng(13), 4000, 0.13

    def moved(elapsed: np.ndarray, start: np.ndarray, after: np.ndarray) -> np.ndarray:
        waves = np.sin(pi * start), np.cos(pi * start), np.cos(pi * (start + elapsed))
        return flight.displacement(elapsed, after, *waves, groups.gbar)

    begun, elapsed = np.stack([random.uniform(0, 2, count), random.uniform(0, 1.2, count)]), np.linspace(0, 3, 1501)
    arrives = moved(elapsed[1:, None], *begun) > d
    begun, arrival = begun[:, arrives.any(axis=0)], elapsed[1 + arrives.argmax(axis=0)[arrives.any(axis=0)]]
    start, after = begun
    phase = pi * (start + arrival)
    speed = after + groups.gbar * arrival + (np.sin(phase) - np.sin(pi * start)) / pi
    bend = groups.gbar + np.cos(phase)
    width = random.uniform(0.2, 0.65, len(arrival)) * speed**2 / np.abs(bend)
    own = np.flatnonzero((speed > 0.005) & (bend < -0.02) & (width < 0.9 * d))
    (start, after), arrival, width, count = begun[:, own], arrival[own], width[own], len(own)
    linear = np.zeros((SYMBOLS, count))
    linear[FIRST] = width
    offset = Affine(np.zeros(count), linear, np.zeros(count))
    sets = Sets(np.full(count, -1), exact(start), exact(after), offset, exact(np.zeros(count)))
    found = next_impacts(enclosed(groups), sets, np.stack([np.ones(count), arrival, np.zeros(count)], axis=1))
    proved = np.flatnonzero(found.proved)
    assert 30 < len(proved) < count / 2
    last = found.duration[proved]
    rest = np.abs(last.linear[SECOND:]).sum(axis=0) + last.radius
    for share in np.linspace(-1, 1, 9):
        middle, short = last.centre + share * last.linear[FIRST], d - share * width[proved]
        assert (moved(middle - rest, *begun[:, own[proved]]) <= short + 1e-12).all()
        assert (moved(middle + rest, *begun[:, own[proved]]) >= short - 1e-12).all()


def test_a_touch_is_as_fast_as_its_membrane_may_be_approached() -> None:
    """While a state of a set may touch, whether before or after it would turn."""
    groups, random, count = Groups(0.2, 0.24, Restitutions(0.6, 0.3)), np.random.default_rng(14), 4000
    wall, time = random.choice([1, -1], count), 2 * random.random(count)
    velocity, widths = wall * (0.02 + random.random(count)), 10 ** random.uniform(-3, -1, (2, count))
    widths[1] = np.minimum(widths[1], 0.9 * np.abs(velocity))
    sets = sets_of(groups, wall, time, velocity, widths)
    past = simulated_past(groups, sets, simulated(groups, middles(groups, sets), True), True)
    own, _, touching = impacts_past_a_touch(enclosed(groups), sets, past)
    assert len(own) > 100
    fastest = np.abs(touching.velocity.centre) + touching.velocity.radius
    rest = np.abs(touching.duration.linear[2:]).sum(axis=0) + touching.duration.radius
    elapsed = touching.duration.centre + np.linspace(-1, 1, 41)[:, None] * rest
    restitution = np.where(wall[own] > 0, 0.6, 0.3)
    sine = np.sin(pi * time[own])
    moving = flight.velocity(
        elapsed, -restitution * velocity[own], sine, np.sin(pi * (time[own] + elapsed)), groups.gbar
    )
    assert ((touching.wall * moving).max(axis=0) <= fastest + 1e-12).all()


def test_a_region_about_another_place_says_how_far_the_motion_is_from_its_middle() -> None:
    """Or is none: within its radius there must be room for that distance."""
    groups, motion, trap = stable(5.2)
    found = []
    for way in np.linspace(0, pi, 4, endpoint=False):
        for share in (1e-3, 0.9):
            late, fast = share * trap.radius * np.linalg.inv(trap.metric) @ [np.cos(way), np.sin(way)]
            beside = replace(motion, time=motion.time + late, velocity=np.add(motion.velocity, [fast, 0.0]))
            found.append((share, proved_trap(groups, beside, trap.metric, trap.radius, True)))
    assert {share for share, aside in found if aside is not None} >= {1e-3}
    for share, aside in found:
        assert aside is None or share * trap.radius <= aside.off * (1 + 1e-9) <= trap.radius


def test_every_shock_up_to_the_bound_is_in_a_cell_that_is_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a proof by chance, that of cells of small jumps in the end."""
    groups, _, trap = stable(3.6)
    random, told = np.random.default_rng(8), []

    class Chance:
        def __init__(self, *_: object) -> None:
            pass

        def prove(self, cells):
            least = np.minimum(np.abs(cells.low[1]), np.abs(cells.high[1]))
            holds = (random.random(len(least)) < 0.7) | ((least < 0.02) & (len(told) > 0))
            told.append(cells[holds])
            return holds, random.integers(0, 2, len(least)), 100_000

    monkeypatch.setattr("vireport.findings.proofs.survived.MotionFlights", Chance)
    found = survived(Goal(groups, trap), 0.05)
    assert 0.02 <= found.jump < 0.05
    assert found.cells == sum(len(cells.impact) for cells in told)
    low, high = (np.concatenate([getattr(cells, end) for cells in told], axis=1) for end in ("low", "high"))
    assert (low < high).all()
    after = np.concatenate([cells.impact for cells in told])
    for impact in range(len(trap.motion.word)):
        shocks = np.array([[1.0], [found.jump]]) * random.uniform([[0.0], [-1.0]], 1.0, (2, 4000))
        inside = (low[:, :, None] <= shocks[:, None]) & (shocks[:, None] <= high[:, :, None])
        assert (inside.all(axis=0) & (after == impact)[:, None]).any(axis=0).all()


def attack(groups: Groups, trap: Trap, jump: float, count: int, seed: int = 3) -> None:
    """Random shocks up to a size, at random moments, all of which must come into the region."""
    motion, random = trap.motion, np.random.default_rng(seed)
    for impact, duration in enumerate(motion.durations):
        delays = np.where(random.random(count) < 0.3, 0.0, duration * random.random(count))
        jumps = jump * random.choice([-1, 1], count) * random.random(count) ** 0.1
        starts = shocked(groups, motion, impact, delays, jumps)
        rows, _ = follow_impacts(np.repeat(check_model(groups), count, axis=0), starts, patience(trap) + 1)
        assert inside(trap, rows[:, 1:]).any(axis=1).all()


def test_small_shocks_are_all_proved_and_cells_on_the_edge_never() -> None:
    """The least shock at 3.6 N is 0.1694 y_c, towards the bottom, just after the bottom impact."""
    groups, motion, trap = stable(3.6)
    found = survived(Goal(groups, trap), 0.05)
    assert found.jump == 0.05
    assert found.cells == np.count_nonzero(found.halved == -1) > 100
    attack(groups, trap, found.jump, 500)
    assert survived_again(Goal(groups, trap, compiled=False), 0.05, found.halved) == 0.05
    with pytest.raises(ValueError, match="not complete"):
        survived_again(Goal(groups, trap, compiled=False), 0.05, found.halved[:-1])
    # Sets on the section just after it that hold the edge of the basin, the narrowest ones too.
    starts = shocked(groups, motion, 0, np.zeros(1), np.array([0.16939719992646393]))[0]
    for width in (1e-2, 1e-4, 1e-6, 1e-9):
        sets = sets_of(groups, np.array([1]), starts[[3]] / pi, starts[[2]], np.array([[0.0], [width]]))
        came, _, _ = come_in(Goal(groups, trap), sets, None, patience(trap))
        assert not came.any()


def settled_sets(groups: Groups, count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Random sets of slow impacts, (time, velocity, half widths), and which of them surely come to rest."""
    random = np.random.default_rng(seed)
    wall, time = random.choice([1, -1], count), 2 * random.random(count)
    velocity, widths = wall * 10 ** random.uniform(-4, -0.3, count), 10 ** random.uniform(-4, -1.5, (2, count))
    widths[1] = np.minimum(widths[1], np.abs(velocity))
    return (
        wall,
        np.stack([time, velocity]),
        widths,
        settles(enclosed(groups), sets_of(groups, wall, time, velocity, widths)),
    )


@pytest.mark.slow
@pytest.mark.parametrize("groups", [Groups(0.4, 0.24, 0.5), Groups(0.2, 0.0, Restitutions(0.8, 0.3))])
def test_what_surely_settles_comes_to_rest_before_it_is_released(groups: Groups) -> None:
    """Wherever in a set: the next impact is after a ride on that membrane. Of such as may hop over the release none."""
    wall, middle, widths, rests = settled_sets(groups, 4000, 9)
    assert 0.1 < rests.mean() < 0.6
    model = check_model(groups)
    for corner in CORNERS:
        time, velocity = middle + np.array(corner)[:, None] * widths
        starts = np.zeros((len(time), 4))
        starts[:, 0], starts[:, 2], starts[:, 3] = wall, velocity, np.mod(pi * time, TURN) % TURN
        rows, _ = follow_impacts(np.repeat(model, rests.sum(), axis=0), starts[rests], 200)
        rode = np.argmax(rows[:, :, RIDING] > 0, axis=1)
        at = np.arange(len(rows))
        assert (rows[at, rode, RIDING] > 0).all()
        assert all((row[: k + 1, WALL] == row[0, WALL]).all() for row, k in zip(rows, rode, strict=True))


def arrived(groups: Groups, trap: Trap, time: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Which impacts on the bottom membrane come into a region, simulated for a thousand impacts."""
    left, there = np.arange(len(time)), np.zeros(len(time), dtype=bool)
    starts = np.zeros((len(time), 4))
    starts[:, 0], starts[:, 2], starts[:, 3] = 1, velocity, np.mod(pi * time, TURN) % TURN
    for impacts in (16, 32, 64, 128, 256, 512):
        rows, _ = follow_impacts(np.repeat(check_model(groups), len(left), axis=0), starts, impacts)
        there[left] = inside(trap, rows).any(axis=1)
        left, last = left[~there[left]], rows[~there[left], -1]
        starts = np.zeros((len(left), 4))
        starts[:, 0], starts[:, 2], starts[:, 3] = last[:, WALL], last[:, VELOCITY], last[:, PHASE]
        if not len(left):
            break
    return there


def in_cells(cells: list[Cells], count: int, random: np.random.Generator) -> np.ndarray:
    """Random points of cells, as many in each on average as it is large, (2, count)."""
    low, high = (np.concatenate([getattr(each, end) for each in cells], axis=1) for end in ("low", "high"))
    area = (high - low)[0] * np.maximum((high - low)[1], (high[1] == low[1]).all())
    row = random.choice(low.shape[1], count, p=area / area.sum())
    # Some of them on the edges, where a cell that is proved by mistake fails first.
    place = np.clip(random.uniform(-0.2, 1.2, (2, count)), 0, 1)
    return low[:, row] + place * (high - low)[:, row]


def attack_section(groups: Groups, found: Section, count: int, seed: int = 5) -> None:
    random = np.random.default_rng(seed)
    proved = [cells[code == -1] for cells, code in generations(_first_cells(found.fastest), found.halved)]
    assert sum(len(cells) for cells in proved) == found.cells > 100
    moments = [cells[code == -1] for cells, code in generations(_first_moments(), found.moments)]
    for cells, many in ((proved, count), (moments, max(count // 10, 500))):
        for begin in range(0, many, 100_000):
            points = in_cells(cells, min(many - begin, 100_000), random)
            assert arrived(groups, found.trap, *points).all()


@pytest.mark.slow
def test_impacts_and_moments_that_are_proved_come_to_the_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 3.6 N the ball does not come there from rest: only what never rests is proved."""
    monkeypatch.setattr("vireport.findings.proofs.section.MOST_FLIGHTS", 6000)
    monkeypatch.setattr("vireport.findings.proofs.section.HALVINGS", 1)
    (groups, _, trap), fastest = stable(3.6), 1.9
    found = proved_section(Goal(groups, trap), fastest)
    assert found.share > 0.02
    attack_section(groups, found, 5000)
    claimed = Goal(groups, trap, compiled=False)
    again = section_again(claimed, fastest, found.halved, found.moments)
    assert again == pytest.approx((found.share, found.switch_on), rel=1e-12)
    # What is only claimed to be proved is not believed.
    everything = (np.full(len(cells), -1) for cells in (_first_cells(fastest), _first_moments()))
    assert max(section_again(claimed, fastest, *everything)) < 0.1
    for halved, moments in ((found.halved[:-1], found.moments), (found.halved, found.moments[:-1])):
        with pytest.raises(ValueError, match="not complete"):
            section_again(claimed, fastest, halved, moments)


@pytest.mark.parametrize(
    ("force", "length", "beta", "count"),
    [
        (3.6, 0.75, 45.0, 150),
        *(pytest.param(*case, 1000, marks=pytest.mark.slow) for case in ((3.6, 0.75, 45.0), (5.0, 0.5554, 0.0))),
    ],
)
def test_every_state_of_a_cell_takes_one_of_its_itineraries(
    force: float, length: float, beta: float, count: int
) -> None:
    """It returns in all boxes of that, in their order, and comes to the region where the itinerary arrives."""
    groups, _, trap = stable(force, length, beta)
    random, size, some = np.random.default_rng(11), 0.01, count // 50
    low = np.stack([2 * random.random(count), 1.8 * random.random(count)])
    known, _, _ = follow_cells(Goal(groups, trap), Cells(low, low + size, np.zeros(count, np.intp)))
    assert (known.cell[:count] == np.arange(count)).all()
    assert (np.isfinite(known.box).all(axis=2) == (np.arange(RETURNS) < known.returns[:, None])).all()
    assert len(known) > count + some
    assert known.returns[count:].mean() > 1.6  # those that part are followed on as well
    assert np.count_nonzero(known.arrives) > some
    assert np.count_nonzero(known.returns == RETURNS) > some
    # States on the edges of cells, too, and many of the cells that have several itineraries.
    cell = np.concatenate([np.repeat(np.arange(count), 3), np.repeat(known.cell[count:], 20)])
    share = np.clip(random.uniform(-0.2, 1.2, (2, len(cell))), 0, 1)
    time, velocity = low[:, cell] + size * share
    rows = followed(groups, 1, time, velocity, 12)
    came = arrived(groups, trap, time, velocity)
    order = np.argsort(known.cell, kind="stable")
    first = np.searchsorted(known.cell[order], np.arange(count + 1))
    parted = 0
    for state, k in enumerate(cell.tolist()):
        back = np.flatnonzero(rows[state, 1:, WALL] == 1)[:RETURNS] + 1
        late, fast = rows[state, back, PHASE] / pi, rows[state, back, VELOCITY]
        taken = []
        for i in order[first[k] : first[k + 1]]:
            box = known.box[i, : known.returns[i]]
            if len(box) > len(back) or (known.arrives[i] and not came[state]):
                continue
            near = late[: len(box)] - 2 * np.round((late[: len(box)] - box[:, :2].mean(axis=1)) / 2)
            held = (box[:, 0] <= near + 1e-12) & (near <= box[:, 1] + 1e-12)
            held &= (box[:, 2] <= fast[: len(box)] + 1e-12) & (fast[: len(box)] <= box[:, 3] + 1e-12)
            if held.all():
                taken.append(i)
        assert taken
        parted += min(taken) >= count
    assert parted > some


def test_a_box_is_known_where_all_of_it_is() -> None:
    """Also one that lasts over the end of a period."""
    random, fastest, parts = np.random.default_rng(15), 1.6, 8
    tiles = np.stack(np.meshgrid(np.arange(parts), np.arange(parts), indexing="ij")).reshape(2, -1)
    size, held = np.array([[2 / parts], [fastest / parts]]), random.random(parts**2) < 0.7
    known = _Covered(Cells(tiles * size, (tiles + 1) * size, np.zeros(parts**2, np.intp))[held], fastest)
    low = random.uniform([[0], [0]], [[4], [0.9 * fastest]], (2, 3000))
    high = low + random.uniform(1e-6, 0.4, (2, 3000)) * [[1], [fastest]]
    whole = np.ones(3000, dtype=bool)
    for share in np.stack(np.meshgrid(*[np.linspace(0, 1, 12)] * 2)).reshape(2, -1).T:
        place = np.floor((low + share[:, None] * (high - low)) / size).astype(int)
        there = place[1] < parts
        whole &= there & held.reshape(parts, parts)[place[0] % parts, np.where(there, place[1], 0)]
    assert 0.1 < whole.mean() < 0.9
    assert (known.holds(np.stack([low[0], high[0], low[1], high[1]], axis=1)) == whole).all()


@pytest.mark.slow
def test_a_ball_that_comes_to_rest_is_proved_to_arrive_only_where_that_membrane_releases_it_to_the_motion() -> None:
    groups, _, trap = stable(3.0)
    moments = _first_moments()
    nothing = _Covered(moments[np.zeros(len(moments), dtype=bool)], 1.9)
    never, top, bottom = (_arrives(Goal(groups, trap, rests), moments, nothing) for rests in ((), (-1,), (1,)))
    pressed = moments.high[0] < np.arccos(-groups.gbar) / pi
    assert bottom[pressed].all()
    assert not never[pressed].any()
    assert (top == never).all()


def switched_on_while_pressed(groups: Groups, found: Section) -> float:
    """Share of all moments that are proved and at which the ball is pressed onto the bottom membrane."""
    pressed, share = np.arccos(-groups.gbar) / pi, 0.0
    for cells, code in generations(_first_moments(), found.moments):
        down = (cells.high[0] < pressed) | (cells.low[0] > 2 - pressed)
        share += (cells.high - cells.low)[0, down & (code == -1)].sum() / 2
    return share


@pytest.mark.slow
def test_of_many_impacts_that_are_proved_none_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor of moments of switching on: nearly all at which the ball is pressed down, and others."""
    monkeypatch.setattr("vireport.findings.proofs.section.MOST_FLIGHTS", 30_000)
    groups, _, trap = stable(3.0)
    found = proved_section(Goal(groups, trap, (1,)), 1.9)
    assert found.share > 0.5
    attack_section(groups, found, 100_000)
    pressed = np.arccos(-groups.gbar) / pi
    assert 0.98 * pressed < switched_on_while_pressed(groups, found) < pressed < found.switch_on < 1


@pytest.mark.slow
def test_where_the_ball_pressed_down_comes_to_rest_other_moments_of_switching_on_are_proved(monkeypatch) -> None:
    """One in four or five at 3.6 N."""
    monkeypatch.setattr("vireport.findings.proofs.section.MOST_FLIGHTS", 20_000)
    groups, _, trap = stable(3.6)
    found = proved_section(Goal(groups, trap), 1.9)
    attack_section(groups, found, 20_000)
    assert switched_on_while_pressed(groups, found) == 0
    assert 0.15 < found.switch_on < 0.25


def test_a_ball_that_the_top_membrane_releases_is_proved_to_take_the_way_that_is_simulated() -> None:
    """Of a horizontal capsule that way is the mirror image of the one from the bottom, half a period later."""
    flat = device(5.0, 0.5554, 0.0)
    found, _, _ = motions_at(flat, Parameter.LENGTH)
    groups = flat.groups(Parameter.LENGTH, 0.5554).as_floats()
    traps = [trap_of(groups, found.motion(int(row), 1), True) for row in np.flatnonzero(found.stable_mask)]
    ends = {wall: reaches(flat, [trap for trap in traps if trap is not None], wall=wall)[0] for wall in (1, -1)}
    for wall, time in ((1, 0.5), (-1, -0.5)):
        rows = followed(groups, wall, np.array([time]), np.zeros(1), 60)
        assert inside(ends[wall], rows).any()
    np.testing.assert_allclose(
        [ends[1].motion.velocity[0], ends[1].motion.velocity[1]],
        [-ends[-1].motion.velocity[1], -ends[-1].motion.velocity[0]],
        rtol=1e-9,
    )


def proof(force: float, length: float = 0.75, beta: float = 45.0) -> dict:
    text = TEXT.format(force=force, length=length, beta=beta)
    return json.loads(json.dumps(analyse(loads(text), ("json",)).to_dict(), allow_nan=False))


@pytest.mark.slow
def test_the_bound_of_shocks_lies_below_the_least_one_found_and_stands_an_attack(monkeypatch) -> None:
    monkeypatch.setattr("vireport.findings.proofs.section.MOST_FLIGHTS", 1)  # which starts arrive is not asked here
    force = 3.6
    data = proof(force)
    found = data["disturbances"]
    assert found["from_rest"]["outcome"] == "rest_cycle"
    assert found["from_rest"]["proved"] is False
    assert "comes to rest" in found["proof"]["from_rest"]["reason"]
    least, bound = found["shock"]["least_jump_m_s"], found["shock"]["proved_m_s"]
    assert 0.97 * least < bound < least
    groups, _, trap = stable(force)
    for seed in range(2):
        attack(groups, trap, bound / (force / (2 * 0.1245 * 2)), 10_000, seed)
    # All cells claimed to be proved: none is believed.
    false = copy.deepcopy(data)
    halved = false["disturbances"]["proof"]["shocks"][0]["halved"]
    halved[:] = [-1 if code < 0 else code for code in halved]
    false["disturbances"]["proof"]["shocks"][0]["largest"] = 1.0
    assert recheck_disturbances(false).proved_m_s < 1.2 * bound


def inside(trap: Trap, rows: np.ndarray) -> np.ndarray:
    """Which impacts of simulated trajectories are in a region."""
    motion = trap.motion
    late = ((rows[..., PHASE] - pi * motion.time[0] + pi) % TURN - pi) / pi
    off = np.stack([late, rows[..., VELOCITY] - motion.velocity[0]])
    sizes = np.linalg.norm(np.tensordot(trap.metric, off, axes=1), axis=0)
    return (rows[..., WALL] == motion.word.walls[0]) & (sizes <= trap.radius)


@pytest.mark.parametrize("force", [3.0, 5.0])
def test_the_ball_from_rest_is_proved_to_take_the_way_that_is_simulated(force: float) -> None:
    """From the release point, phase arccos(-gbar) and no velocity: as many impacts to the region."""
    groups, _, trap = stable(force)
    reached, impacts, bits = reaches(device(force), [trap])
    assert reached is trap
    assert bits == PRECISIONS[0]
    release = np.arccos(-groups.gbar) / pi
    there = inside(trap, followed(groups, 1, np.array([release]), np.zeros(1), impacts)[0])
    assert there[-1]
    assert not there[:-1].any()


@pytest.mark.parametrize("force", [3.6, 4.0])
def test_a_rest_cycle_is_never_proved_to_reach_the_motion(force: float) -> None:
    with pytest.raises(UnprovedError, match="comes to rest"):
        reaches(device(force), [stable(force)[2]])


def test_too_few_bits_prove_nothing() -> None:
    with pytest.raises(UnprovedError):
        reaches(device(5.0), [stable(5.0)[2]], bits=(53,))


@pytest.mark.slow
def test_proofs_are_gone_through_again_from_results_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vireport.findings.proofs.survived.MOST_FLIGHTS", 1)
    monkeypatch.setattr("vireport.findings.proofs.section.MOST_FLIGHTS", 15_000)
    data = proof(3.0)
    found = data["disturbances"]
    assert found["from_rest"]["outcome"] == "reaches_1_1"
    assert found["from_rest"]["proved"] is True
    again = recheck_disturbances(data)
    assert (again.from_rest, again.proved_m_s) == (True, found["shock"]["proved_m_s"])
    (section,) = found["proof"]["sections"]
    assert section["name"] == "BT every forcing period"
    assert 0.1 < section["share"] < 1
    assert again.shares == pytest.approx([section["share"]], rel=1e-9)
    assert again.switch_on == pytest.approx([section["share_of_switch_on_phases"]], rel=1e-9)
    data["disturbances"]["proof"]["regions"][0]["radius"] *= 30
    again = recheck_disturbances(data)
    assert (again.from_rest, again.proved_m_s) == (False, 0.0)
    assert again.shares == again.switch_on == (0.0,)
    with pytest.raises(UsageError, match="no proof"):
        recheck_disturbances({**data, "disturbances": None})


def test_what_is_proved_of_several_motions_is_the_least_and_refused_where_gravity_is_neglected() -> None:
    at, largest = (5.0, 0.5554, 0.0), 0.01
    groups, motion, trap = stable(*at)
    found = survived(Goal(groups, trap), largest)
    both = found, replace(found, jump=0.004)
    least = {Proved(2.0, Arrival(), shocks=shocks).jump_m_s for shocks in (both, both[::-1])}
    assert least == {rounded_down(0.008)}
    region = ProvedRegion(motion, trap.metric, trap.radius)
    good, bad = (region, largest, found.halved), (replace(region, radius=30 * trap.radius), largest, found.halved)
    assert prove_again(device(*at), None, [good]).proved_m_s > 0
    for regions in ([good, bad], [bad, good]):
        assert prove_again(device(*at), None, regions).proved_m_s == 0
    # So slight an inclination that the device computed is another one.
    assert prove_again(device(*at[:2], 1e-14), None, [good]).proved_m_s == 0


@pytest.mark.slow
def test_cells_that_are_only_claimed_to_be_proved_are_not_believed() -> None:
    """All that the plane begins with, up to beyond the least shock that leads out."""
    groups, _, trap = stable(3.6)
    cells = 2 * len(trap.motion.word) * MOMENTS * (len(SIZES) - 1)
    assert 0 < survived_again(Goal(groups, trap, compiled=False), 0.3, np.full(cells, -1)) < 0.1694


def test_a_bound_is_rounded_down() -> None:
    assert rounded_down(1.2345999) == 1.234
    assert rounded_down(1.234) == 1.233
    assert rounded_down(12.0001) == 12.0
