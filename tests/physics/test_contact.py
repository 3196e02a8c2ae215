"""One contact with Hunt-Crossley damping: restitution, duration and depth, against many digits and the equation."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from conftest import first
from scipy.integrate import solve_ivp

from vireport.base.errors import NumericalError
from vireport.physics.contact import SMALLEST_RESTITUTION, contacts, damping_number, law_of
from vireport.physics.energy import Membrane, deflection

MASS = 0.0041
MEMBRANE = Membrane(4.0847e5, 2.6, 6.3e-3, 5e-3, 2000.0, MASS)


def membrane(exponent: float, stiffness: float = 4.0847e5, mass: float = MASS) -> Membrane:
    return Membrane(stiffness, exponent, 6.3e-3, 5e-3, 2000.0, mass)


def integrated(exponent: float, restitution: float, speed: float) -> tuple[float, float, float]:
    """Duration, departure speed and depth of m x'' = -K x^h (1 + lambda x') in SI units, by the equation alone."""
    k = 4.0847e5
    damping = damping_number(restitution) / speed
    scale = float(contacts(np.array(speed), membrane(exponent), 1.0).duration)

    def force(x: float, v: float) -> float:
        return -k / MASS * max(x, 0.0) ** exponent * (1 + damping * v)

    settings = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-18}

    def turned(t: float, state: np.ndarray) -> float:
        return state[1]

    turned.terminal = True
    loading = solve_ivp(lambda t, s: (s[1], force(*s)), (0, 10 * scale), [0, speed], events=turned, **settings)
    depth = float(loading.y[0, -1])
    rebound = solve_ivp(
        lambda t, s: (s[1], force(*s)), (0, scale / 10), [depth, 0.0], first_step=scale * 1e-4, **settings
    )
    x, v = rebound.y[:, -1]
    # The last part with x as the variable: the departure is x = 0, exactly.
    end = solve_ivp(lambda x, s: (1 / s[1], force(x, s[1]) / s[1]), (x, 0), [0.0, v], **settings).y[:, -1]
    return float(loading.t[-1] + scale / 10 + end[0]), -float(end[1]), depth


@pytest.mark.parametrize(("h", "r", "speed"), [(2.6, 0.5, 6.0), (1.0, 0.2, 0.01), (1.5, 0.9, 3.0), (5.0, 0.05, 50.0)])
def test_contact_gives_the_restitution_its_duration_and_its_depth(h: float, r: float, speed: float) -> None:
    duration, leaving, depth = integrated(h, r, speed)
    closed = contacts(np.array(speed), membrane(h), r)
    assert leaving / speed == pytest.approx(r, abs=1e-10)
    assert duration == pytest.approx(float(closed.duration), rel=1e-9)
    assert depth == pytest.approx(float(closed.deflection), rel=1e-11)


@pytest.mark.parametrize("r", [0.03, 0.5, 0.95, 1 - 1e-6, 1 - 1e-12])
def test_damping_number_solves_its_equation_in_sixty_digits(r: float) -> None:
    with mp.workdps(60):
        exact = mp.mpf(r)
        low, high = mp.mpf(10) ** -20, (1 + exact) / exact
        for _ in range(120):
            w = (low + high) / 2
            d = -mp.expm1(-w) / exact
            low, high = (w, high) if mp.log1p(d) + w < (1 + exact) * d else (low, w)
        assert damping_number(r) == pytest.approx(float(d), rel=2e-15)


def test_damping_number_has_its_limits() -> None:
    assert damping_number(1.0) == 0
    assert damping_number(1 - 1e-7) / 1e-7 == pytest.approx(1.5, rel=1e-6)
    for r in (0.01, SMALLEST_RESTITUTION):
        assert damping_number(r) * r == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize(("h", "r"), first(2, [(2.6, 0.5), (0.4, 0.9), (7.0, 0.1), (2.6, 1.0)], unpacked=True))
def test_duration_is_the_quadrature_in_many_digits(h: float, r: float) -> None:
    with mp.workdps(90):
        h_, r_, cut = mp.mpf(h), mp.mpf(r), mp.mpf(10) ** -9
        d = lambda w: -mp.expm1(-w) / r_  # noqa: E731
        equation = lambda w: mp.log1p(d(w)) + w - (1 + r_) * d(w)  # noqa: E731
        guess = (1 + r) * damping_number(r) - float(np.log1p(damping_number(r)))
        damping = d(mp.findroot(equation, (guess, guess * (1 + 1e-8)), tol=mp.mpf(10) ** -170)) if r < 1 else mp.mpf(0)

        def energy(u: mp.mpf) -> mp.mpf:  # integral of s/(1 + D s) from u to 1
            if not damping:
                return (1 - u * u) / 2
            return (1 - u - mp.log((1 + damping) / (1 + damping * u)) / damping) / damping

        def part(end: mp.mpf) -> mp.mpf:
            def integrand(p: mp.mpf) -> mp.mpf:  # u = end (1 - p^(h+1)) takes the singularity at the end away
                u = end * (1 - p ** (h_ + 1))
                return abs(end) * (h_ + 1) * p**h_ / ((1 + damping * u) * energy(u) ** (h_ / (h_ + 1)))

            with mp.workdps(90):
                return mp.quad(integrand, [cut, 0.01, 0.2, 0.6, 1], maxdegree=5) + cut * integrand(cut)

        tau = (h_ + 1) ** (-h_ / (h_ + 1)) * (part(mp.mpf(1)) + part(-r_))
    assert law_of(h, r).duration == pytest.approx(float(tau), rel=1e-13)


def test_linear_spring_without_damping_takes_half_a_period() -> None:
    law = law_of(1.0, 1.0)
    assert law.duration == pytest.approx(np.pi, rel=1e-14)
    assert law.depth_ratio == 1


def test_duration_without_damping_is_a_beta_function() -> None:
    for h in (0.5, 1.5, 2.6, 20.0):
        a = 1 / (h + 1)
        exact = 2 * a * ((h + 1) / 2) ** a * float(mp.beta(a, 0.5))
        assert law_of(h, 1.0).duration == pytest.approx(exact, rel=1e-13)


def test_depth_without_damping_is_that_of_the_paper() -> None:
    speed = np.array([0.01, 1.0, 6.0, -6.0])
    contact = contacts(speed, MEMBRANE, 1.0)
    assert contact.deflection == pytest.approx(deflection(speed, MEMBRANE), rel=1e-13)
    damped = contacts(speed, MEMBRANE, 0.5)
    assert damped.elastic_deflection == pytest.approx(deflection(speed, MEMBRANE), rel=1e-13)
    assert (damped.deflection < damped.elastic_deflection).all()


def test_energy_lost_is_the_work_of_the_damping() -> None:
    r, speed = 0.5, 3.0
    damping = damping_number(r) / speed
    k, h = MEMBRANE.stiffness, MEMBRANE.exponent

    def rates(_: float, state: np.ndarray) -> tuple[float, float, float]:
        force, v = k * max(state[0], 0) ** h, state[1]
        return v, -force * (1 + damping * v) / MASS, force * damping * v * v

    run = solve_ivp(
        rates,
        (0, 1.2 * float(contacts(np.array(speed), MEMBRANE, r).duration)),
        [0, speed, 0], method="DOP853", rtol=1e-12, atol=1e-16,
    )  # fmt: skip
    assert run.y[2, -1] == pytest.approx(MASS * speed**2 * (1 - r**2) / 2, rel=1e-10)


def test_duration_scales_with_mass_stiffness_and_velocity() -> None:
    h = MEMBRANE.exponent

    def duration(speed: float, mass: float, factor: float) -> float:
        return float(contacts(np.array(speed), membrane(h, factor * MEMBRANE.stiffness, mass), 0.5).duration)

    time = duration(2.0, MASS, 1.0)
    assert duration(2.0, MASS, 1e8) / time == pytest.approx(1e8 ** (-1 / (h + 1)), rel=1e-12)
    assert duration(2.0, 7 * MASS, 1.0) / time == pytest.approx(7 ** (1 / (h + 1)), rel=1e-12)
    assert duration(20.0, MASS, 1.0) / time == pytest.approx(10 ** (-(h - 1) / (h + 1)), rel=1e-12)


def test_motion_at_rest_and_huge_ladders_stay_finite() -> None:
    contact = contacts(np.array([0.0, 1e-200, 1e100]), membrane(2.6, 1e280, 1e-12), 0.5)
    assert all(np.isfinite(a).all() for a in (contact.duration, contact.deflection, contact.damping))
    assert contact.deflection[0] == pytest.approx(0, abs=1e-100)


@pytest.mark.parametrize("r", [0.0, 1e-4, -0.5, 1.5, float("nan")])
def test_restitution_outside_the_law_is_refused(r: float) -> None:
    with pytest.raises(NumericalError, match=r"between 0\.001 and 1"):
        law_of(2.6, r)
