"""All motions at many design points at once: none missed, none invented, and the same as one by one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from vireport.motions.diagram import solve
from vireport.motions.level_curve import curve_of
from vireport.motions.orbits import orbits
from vireport.motions.pointwise import find_motions, forms
from vireport.motions.roots import bracketed_root
from vireport.motions.stability import UNSTABLE, classify
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.groups import Groups
from vireport.physics.numbers import IMAGINARY_STEP
from vireport.scenario.parameters import Parameter

DEVICE = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0)


def at(device: Device):
    """Motions at one design point."""
    d, gbar, *_ = device.groups(Parameter.LENGTH, device.length_m)
    return find_motions(Groups(np.array([float(d)]), np.array([float(gbar)]), device.restitution), device.period_ratio)


def along_the_curve(device: Device):
    """The same by other means: where the curve of all motions of this gbar, followed piece by piece, crosses this d."""
    sweep = Sweep(device, Parameter.LENGTH, device.length_m / 2, device.length_m * 2)
    curve = curve_of(sweep)
    samples, target = curve.sampled(), float(sweep.coordinate_of(device.length_m))
    low, high = curve.bounds
    beyond = samples.drawn[:, 0] > (target - low) / (high - low)
    crossing = np.flatnonzero((beyond[1:] != beyond[:-1]) & (samples.which[1:] == samples.which[:-1]))
    which = samples.which[crossing]
    ends = samples.w[crossing], samples.w[crossing + 1]
    root = bracketed_root(lambda w: np.asarray(curve.at(which, w).d - target), *ends)
    orbit = curve.at(which, root)
    return orbit.select((orbit.velocity_bottom > 0) & (orbit.velocity_top < 0))


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("r", [0.0, 0.3, 0.5, 0.95])
def test_forms_invert_the_surface(r: float, n: int) -> None:
    rng = np.random.default_rng(n)
    u, phi = rng.uniform(-0.49, 0.49, 300), rng.uniform(0, 2 * np.pi, 300)
    o, f = orbits(u, phi, r, n), forms(u, r, n)
    for gbar_part, d_part, wanted in (
        (f.sine_gbar, f.sine_d, np.sin(phi)),
        (f.cosine_gbar, f.cosine_d, np.cos(phi)),
    ):
        numerator = o.gbar * gbar_part + o.d * d_part
        size = np.abs(o.gbar * gbar_part) + np.abs(o.d * d_part) + np.abs(f.delta)
        assert (np.abs(numerator - f.delta * wanted) <= 1e-13 * size).all()


@pytest.mark.parametrize("n", [1, 3])
def test_divided_forms_are_the_forms_over_u(n: int) -> None:
    u = np.array([-0.4, -1e-3, 1e-9, 0.1, 0.3])
    whole, divided = forms(u, 0.4, n), forms(u, 0.4, n, divided=True)
    for name in ("sine_d", "cosine_d", "delta"):
        np.testing.assert_allclose(getattr(divided, name) * u, getattr(whole, name), rtol=1e-13, atol=1e-18)
        assert np.isfinite(getattr(forms(np.array([0.0]), 0.4, n, divided=True), name)).all()


def test_complex_step_is_the_derivative() -> None:
    u, h = np.array([0.123]), 1e-6
    slope = forms(u + 1j * IMAGINARY_STEP, 0.5, 1).delta.imag / IMAGINARY_STEP
    np.testing.assert_allclose(slope, (forms(u + h, 0.5, 1).delta - forms(u - h, 0.5, 1).delta) / (2 * h), rtol=1e-8)


def test_motions_of_the_paper() -> None:
    motions = at(replace(DEVICE, length_m=0.4604 * 3 / (4 * 0.1245 * 4)))
    stable = (classify(motions.trace, 0.25) != UNSTABLE) & motions.admissible
    (k,) = np.flatnonzero(stable)
    assert motions.orbit.velocity_bottom[k] == pytest.approx(1.00400474, abs=1e-8)
    assert motions.orbit.phi[k] == pytest.approx(0.56672469, abs=1e-8)
    assert 0.5 + motions.orbit.u[k] == pytest.approx(0.58606105, abs=1e-8)


@settings(max_examples=200)
@given(
    r=st.sampled_from([0.0, 0.2, 0.5, 0.8, 0.95]),
    n=st.integers(1, 3),
    force=st.sampled_from([1.5, 3.0, 20.0]),
    angle=st.one_of(st.just(0.0), st.just(90.0), st.floats(0.0, 90.0), st.floats(-13, 0).map(lambda x: 10.0**x)),
    length=st.floats(0.05, 3.0),
)
@pytest.mark.slow
def test_same_motions_as_on_the_followed_curve(r: float, n: int, force: float, angle: float, length: float) -> None:
    device = replace(
        DEVICE, restitution=r, period_ratio=n, amplitude_n=force, inclination_deg=angle, length_m=length * force * n / 3
    )
    orbit, along = at(device).orbit, along_the_curve(device)
    order, own = (np.lexsort((np.round(np.mod(o.phi, 2 * np.pi), 5), np.round(o.u, 6))) for o in (along, orbit))
    assert len(orbit.u) == len(along.u)
    # Followed only as far as a drawing needs it: digits are tested below.
    for name in ("u", "velocity_bottom", "velocity_top"):
        np.testing.assert_allclose(getattr(orbit, name)[own], getattr(along, name)[order], rtol=0, atol=1e-6)
    np.testing.assert_allclose(np.cos(orbit.phi[own] - along.phi[order]), 1.0, rtol=0, atol=1e-11)


@pytest.mark.parametrize("gbar", [0.0, 1e-15, 1e-10, 1e-4, 0.29, 0.9])
@pytest.mark.parametrize(("r", "n"), [(0.5, 1), (0.0, 2), (0.9, 3)])
def test_motions_in_forty_digits(gbar: float, r: float, n: int) -> None:
    """Newton's method in 40 digits from each motion moves it by rounding alone, times how ill-posed it is."""
    mp = pytest.importorskip("mpmath").mp
    motions = find_motions(Groups(np.linspace(0.11, 0.9, 6) * n, np.full(6, gbar), r), n)
    with mp.workdps(40):
        scale = mp.mpf(1) / max(gbar, 1e-20)
        for k, cell in enumerate(motions.cell):
            u, phi = float(motions.orbit.u[k]), float(motions.orbit.phi[k])
            d = mp.mpf(float((np.linspace(0.11, 0.9, 6) * n)[cell]))

            def off(u, phi, d=d):
                o = orbits(u, phi, mp.mpf(r), n, mp)
                return [(o.gbar - mp.mpf(gbar)) * scale, o.d - d]

            if gbar == 0 and u == 0:
                exact = [mp.mpf(0), mp.findroot(lambda x: off(mp.mpf(0), x)[1], phi)]
            else:
                exact = mp.findroot(lambda x, y: off(x, y), (mp.mpf(u), mp.mpf(phi)))
            ill_posed = 1 + 1 / abs(abs(motions.trace[k] - 1) - r**4)
            assert abs(u - exact[0]) <= 4e-15 * ill_posed * max(abs(u), 1e-3 * gbar, 0.01 * (abs(u) > 0.01))
            assert abs(phi - exact[1]) <= 4e-14 * ill_posed


@pytest.mark.parametrize("angle", [0.0, 1e-6, 1e-3, 5.0, 12.0])
def test_two_motions_appear_at_a_fold(angle: float) -> None:
    device = replace(DEVICE, inclination_deg=angle)
    points = solve(Sweep(device, Parameter.LENGTH, 0.05, 1.2)).critical_points
    folds = [point for point in points if point.event in ("fold", "pitchfork")]
    assert folds
    for fold in folds:
        for share in (1e-3, 1e-6, 1e-8, 1e-10):
            counts = [len(at(replace(device, length_m=fold.sweep_value * (1 + k * share))).cell) for k in (-1, 1)]
            gap = device.groups(Parameter.LENGTH, device.length_m)[1] ** (2 / 3)
            if share > gap or share < 1e-3 * gap or angle == 0:  # not between both folds of an imperfect pitchfork
                assert abs(counts[0] - counts[1]) == 2


@pytest.mark.parametrize("gbar", [1e-15, 1e-12, 1e-9, 1e-6])
def test_nearly_horizontal_capsules_keep_every_motion(gbar: float) -> None:
    d = np.linspace(0.19, 0.26, 50)  # between B1 and C1: a symmetric motion and two others stand side by side
    level, tilted = find_motions(Groups(d, np.zeros(50), 0.5), 1), find_motions(Groups(d, np.full(50, gbar), 0.5), 1)
    assert (np.bincount(level.cell) == np.bincount(tilted.cell)).all()
    beside = np.abs(level.orbit.u) < 1e-9
    assert beside.sum() >= 50
    np.testing.assert_allclose(tilted.orbit.u[beside], 0.0, rtol=0, atol=1e3 * gbar)
    np.testing.assert_allclose(tilted.orbit.u, level.orbit.u, rtol=0, atol=1e3 * gbar + 1e-12)
    np.testing.assert_allclose(tilted.trace, level.trace, rtol=1e6 * gbar + 1e-9, atol=1e6 * gbar + 1e-9)


def test_a_horizontal_capsule_has_mirror_images() -> None:
    d = np.linspace(0.02, 1.0, 400)
    motions = find_motions(Groups(d, np.zeros(400), 0.5), 1)
    for cell in range(400):
        u = np.sort(motions.orbit.u[motions.cell == cell])
        np.testing.assert_allclose(u, -u[::-1], rtol=0, atol=1e-9)


def test_motions_solve_the_equations() -> None:
    rng = np.random.default_rng(2)
    d, gbar = rng.uniform(0.01, 2, 4000), rng.uniform(0, 1.2, 4000)
    motions = find_motions(Groups(d, gbar, 0.5), 1)
    again = orbits(motions.orbit.u, motions.orbit.phi, 0.5, 1)
    assert len(motions.cell) > 1000
    np.testing.assert_allclose(again.d, d[motions.cell], rtol=0, atol=1e-13)
    np.testing.assert_allclose(again.gbar, gbar[motions.cell], rtol=0, atol=1e-13)


def test_no_cell_depends_on_its_neighbours() -> None:
    rng = np.random.default_rng(3)
    d, gbar = rng.uniform(0.05, 1, 3000), rng.choice([0.0, 1e-9, 0.3, 0.7], 3000)
    together = find_motions(Groups(d, gbar, 0.5), 1)
    order = rng.permutation(3000)
    shuffled = find_motions(Groups(d[order], gbar[order], 0.5), 1)
    for k in range(0, 3000, 37):
        alone = find_motions(Groups(d[k : k + 1], gbar[k : k + 1], 0.5), 1)
        for other, cell in ((together, k), (shuffled, int(np.flatnonzero(order == k)[0]))):
            mine = other.cell == cell
            assert np.array_equal(other.orbit.u[mine], alone.orbit.u)
            assert np.array_equal(other.trace[mine], alone.trace)


def test_every_cell_may_have_its_own_restitution() -> None:
    rng = np.random.default_rng(4)
    r, d = rng.uniform(0, 0.99, 200), rng.uniform(0.02, 2, 200)
    gbar = rng.choice([0.0, 1e-9, 0.3, 0.8], 200)
    each = find_motions(Groups(d, gbar, r), 1)
    for k in range(200):
        alone = find_motions(Groups(d[k : k + 1], gbar[k : k + 1], float(r[k])), 1)
        mine = each.cell == k
        assert mine.sum() == len(alone.cell)
        np.testing.assert_allclose(each.orbit.u[mine], alone.orbit.u, rtol=0, atol=1e-10)


@pytest.mark.parametrize(("r", "n"), [(0.5, 1), (0.8, 3)])
def test_motions_of_nearly_the_largest_groups_are_found(r: float, n: int) -> None:
    u, phi = (part.ravel() for part in np.meshgrid(np.linspace(-0.499, 0.499, 400), np.linspace(0, 2 * np.pi, 200)))
    every = orbits(u, phi, r, n)
    right = (every.velocity_bottom > 0) & (every.velocity_top < 0) & (every.gbar > 0) & (every.d > 0)
    for group in (np.where(right, every.d, 0.0), np.where(right, every.gbar, 0.0)):
        k = np.argmin(np.abs(group - 0.9 * group.max()))
        found = find_motions(Groups(every.d[[k]], every.gbar[[k]], r), n).orbit
        off = np.abs(found.u - u[k]) + np.abs(np.sin((found.phi - phi[k]) / 2))
        assert off.min() < 1e-9


def test_where_no_motion_can_be_there_is_none() -> None:
    far = np.array([1e10, 1e-12, 1e300, 0.3])
    motions = find_motions(Groups(far, np.array([0.0, 1e-15, 1e300, 1e8]), 0.5), 1)
    assert not motions.admissible.any()
    assert not len(find_motions(Groups(np.empty(0), np.empty(0), 0.5), 1).cell)
