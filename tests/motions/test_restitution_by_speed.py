"""Restitutions that fall with speed: motions, their derivatives and multipliers against the raw maps in 40 digits."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from conftest import first
from msgspec.structs import replace
from raw_flights import Flights

from vireport.design.lines import LINES, Line, model_on_line
from vireport.motions.orbits import Dynamics, orbits, orbits_of
from vireport.motions.periodicity import linearised, residuals, trace, weighted_trace
from vireport.motions.polish import DECIMALS, in_decimals
from vireport.physics import flight
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions, SpeedLaw
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter

BT = Word((1, -1), 1)


def random_motions(count: int, harmonics: bool = False) -> list[tuple[np.ndarray, Groups[float]]]:
    """Motions of devices with a law, which each is the motion of with the restitutions that the law has there."""
    rng, found = np.random.default_rng(25), []
    while len(found) < count:
        u, phi, exponent = rng.uniform(-0.3, 0.3), rng.uniform(0, 2 * np.pi), rng.uniform(-0.4, 0)
        r, speed = rng.uniform(0.1, 0.9, 2), rng.uniform(0.1, 3.0)
        parts = (Harmonic(2, 0.1, -0.05), Harmonic(3, 0.02, 0.07)) if harmonics else ()
        orbit = orbits_of(Dynamics(Restitutions(*r), 1, parts), u, phi)
        if orbit.velocity_bottom > 0.05 and orbit.velocity_top < -0.05 and orbit.d > 0:
            velocity = np.array([orbit.velocity_bottom, orbit.velocity_top])
            stated = r * (np.abs(velocity) / speed) ** -exponent
            times = phi / np.pi, phi / np.pi + orbit.time_up
            law = SpeedLaw(*stated.tolist(), exponent, speed)
            groups = Groups(float(orbit.d), float(orbit.gbar), law, parts)
            found.append((np.array([*velocity, *times, 0.0]), groups))
    return found


class Fixed:
    """Groups that nothing varies, but with a derivative by each of their numbers."""

    def __init__(self, groups: Groups[float]) -> None:
        self.groups = groups

    def at(self, varied: object) -> Groups[float]:
        return self.groups

    def slopes(self, varied: object) -> np.ndarray:
        return np.eye(len(self.groups.numbers))


def beside_all(x: np.ndarray, groups: Groups[float]) -> np.ndarray:
    """The unknowns of a motion, beside as many that vary as there are numbers."""
    return np.array([*x[:4], *[0.0] * len(groups.numbers)])


@pytest.mark.parametrize("harmonics", first(1, [False, True]))
def test_motions_and_multipliers_are_those_of_the_raw_map(harmonics: bool) -> None:
    """The map is differentiated by differences in 40 digits, and knows nothing of Jacobians."""
    with mp.workdps(40):
        for x, groups in random_motions(5 if harmonics else 8, harmonics):
            exact = Flights(groups)
            bottom, top, *times = map(mp.mpf, x[:4])
            assert max(map(abs, exact.missed(bottom, top, *times))) < 1e-12
            expected, determinant = exact.map_of(bottom, top, *times)
            assert trace(BT, x.tolist(), Fixed(groups)) == pytest.approx(float(expected), rel=1e-10, abs=1e-10)
            weighted = weighted_trace(BT, x.tolist(), groups)
            assert weighted == pytest.approx(float(expected * bottom * top), rel=1e-10, abs=1e-10)
            assert groups.decay(BT.walls, x[:2].tolist()) ** 2 == pytest.approx(float(determinant), rel=1e-10)


def test_the_determinant_is_that_of_all_restitutions_and_slopes() -> None:
    for x, groups in random_motions(50):
        (r, s), (r_top, s_top) = (groups.rebound(wall, float(v)) for wall, v in zip(BT.walls, x[:2], strict=True))
        exponent = groups.restitution.exponent
        assert (s, s_top) == pytest.approx(((1 + exponent) * r, (1 + exponent) * r_top), rel=1e-15)
        assert groups.decay(BT.walls, x[:2].tolist()) == pytest.approx(r * r_top * (1 + exponent), rel=1e-14)


def test_derivatives_are_those_of_the_residuals() -> None:
    for x, groups in random_motions(40, harmonics=True):
        values, matrix = linearised(BT, beside_all(x, groups), Fixed(groups))
        assert np.abs(values).max() < 1e-13
        at = np.array([*x[:4], *groups.numbers], dtype=complex)
        for k in range(len(at)):
            stepped = at.copy()
            stepped[k] += 1e-30j
            columns = list(stepped[:, None])
            other = groups.with_numbers(columns[4:])
            moved = np.array(residuals(BT, columns[:4], Fixed(other), ops=_COMPLEX)).ravel()
            assert matrix[:, k] == pytest.approx(moved.imag / 1e-30, rel=1e-12, abs=1e-13), k


class _Complex:
    pi, sin, cos = np.pi, staticmethod(np.sin), staticmethod(np.cos)


_COMPLEX = _Complex()


def test_without_an_exponent_it_is_the_constant_restitution_to_the_last_bit() -> None:
    for x, groups in random_motions(20):
        law = replace(groups.restitution, bottom=0.43, top=0.61, exponent=0.0)
        same = groups._replace(restitution=law)
        constant = groups._replace(restitution=Restitutions(law.bottom, law.top))
        point = Fixed(same), Fixed(constant)
        (values, matrix), (others, other) = (linearised(BT, beside_all(x, m.groups), m) for m in point)
        assert (values == others).all()
        assert (matrix[:, :8] == other).all()
        assert trace(BT, x.tolist(), point[0]) == trace(BT, x.tolist(), point[1])


def test_decimals_have_the_law_to_their_last_digits() -> None:
    with in_decimals(), mp.workdps(40):
        law = SpeedLaw(0.5, 0.6, -0.1, 0.8).map_numbers(DECIMALS.exact)
        r, slope = law.at(-1, DECIMALS.exact(-1.7))
        expected = mp.mpf(0.6) * (mp.mpf(1.7) / mp.mpf(0.8)) ** mp.mpf(-0.1)
        assert abs(mp.mpf(str(r)) - expected) < mp.mpf(10) ** -27
        assert abs(mp.mpf(str(slope)) - expected * (1 + mp.mpf(-0.1))) < mp.mpf(10) ** -27


def test_a_slow_impact_has_the_largest_restitution_in_every_kind_of_number() -> None:
    law = SpeedLaw(0.5, 0.5, -0.1, 1.0)
    most = flight.LARGEST_RESTITUTION
    slowest = (0.5 / most) ** 10
    for share in (0.0, 0.5 * slowest, -1.0):
        assert law.at(1, share) == (most, most)
        assert law.at(1, np.array([share, 1.0]))[0].tolist() == [most, 0.5]
        assert law.at(1, np.array([share + 0j]))[1].tolist() == [most]
    assert law.at(1, 2 * slowest)[0] < most
    with in_decimals():
        assert float(law.map_numbers(DECIMALS.exact).at(1, DECIMALS.exact(0.0))[0]) == most


def test_a_law_is_never_taken_for_a_constant() -> None:
    groups = Groups(0.5, 0.3, SpeedLaw(0.5, 0.5, -0.1, 1.0))
    with pytest.raises(TypeError, match="without the speed"):
        groups.restitution_at(1)
    with pytest.raises(TypeError):
        orbits(0.1, 0.2, groups.restitution, 1)


@pytest.mark.parametrize("line", LINES)
def test_lines_keep_the_speed_at_which_restitutions_are_stated(line: Line) -> None:
    """In m/s: its number of y_c changes with that unit; and the slopes are the derivatives."""
    law = SpeedLaw(0.5, 0.6, -0.1, 4.9)
    device = Device(0.1245, law, 9.8, 0.6934, 3.0, 2.0, 45.0)
    along_line, step = model_on_line(line, device, FLOATS), 1e-6
    value = device.value_of(line.value[0])
    if line in (Line.LENGTHS, Line.FREQUENCIES, Line.FORCES, Line.MASSES):
        factor = {Line.FREQUENCIES: 1.02**0.5, Line.FORCES: 1 / 1.02}.get(line, 1.02)
        other, position = device.with_values({line.value[0]: value * factor}), np.log(1.02)
    else:
        other = device.with_values({line.value[0]: value + 0.02})
        position = 0.02
        if line is Line.GRAVITY:
            position = other.groups(Parameter.LENGTH, other.length_m).gbar - along_line.origin.gbar
    expected = other.groups(Parameter.LENGTH, other.length_m).as_floats()
    assert along_line.at((float(position),)).numbers == pytest.approx(expected.numbers, rel=1e-13)
    ahead, behind = (np.array(along_line.at((sign * step,)).numbers) for sign in (1, -1))
    assert along_line.slopes((0.0,))[:, 0] == pytest.approx((ahead - behind) / (2 * step), abs=1e-8)
