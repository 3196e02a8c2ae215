"""Tolerances: nothing is proved that is not so, next to nothing that is so is left open, and the yield is right."""

from __future__ import annotations

import json
import operator
from itertools import product
from math import erf, sqrt

import numpy as np
import pytest
from conftest import first
from mpmath import mp, mpf
from msgspec.structs import replace
from scipy.stats import binom
from strategies import random_sweeps

from vireport import (
    analyse,
    load,
    loads,
    recheck,
)
from vireport.base.errors import UsageError
from vireport.base.records import plain
from vireport.cli.app import main
from vireport.design.devices import devices_off, stable_motions
from vireport.design.point import design_point
from vireport.findings.tolerances.proof import Leaf, prove_again, prove_region
from vireport.findings.tolerances.region import Region, region_of
from vireport.findings.tolerances.results import TolerancesData, worst_scenario
from vireport.physics.affine import AFFINE, Affine
from vireport.physics.device import Device
from vireport.physics.groups import Groups
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.events import BOTTOM, check_model, follow_impacts
from vireport.simulation.kernel import PHASE, VELOCITY
from vireport.study.reading import read_record

PAPER = ("horizontal", "inclined", "inclined-forcing", "design-point")
BINARY = (operator.add, operator.sub, operator.mul, operator.truediv)
UNARY = ("sin", "cos", "sinc", "square", "inverse")
SYMBOLS = 10


def random_numbers(rng: np.random.Generator, count: int) -> Affine:
    centre = rng.uniform(-3, 3, count)
    return Affine(centre, rng.normal(size=(SYMBOLS, count)) * 10.0 ** rng.uniform(-6, -1.5, count), np.zeros(count))


def at(x: Affine, symbols: np.ndarray) -> list[mpf]:
    """The values of numbers without a radius, at values of the symbols, exactly."""
    return [
        mpf(float(c)) + sum(mpf(float(a)) * mpf(float(s)) for a, s in zip(x.linear[:, i], symbols[:, i], strict=True))
        for i, c in enumerate(x.centre)
    ]


def escapes(seed: int, count: int = 20) -> int:
    """How many results of random operations are not where affine arithmetic has them, by 40-digit arithmetic."""
    rng, ops, outside = np.random.default_rng(seed), AFFINE, 0
    a, b = random_numbers(rng, count), random_numbers(rng, count)
    symbols = rng.choice([-1.0, 1.0, 0.3, -0.7], (SYMBOLS, count))
    with mp.workdps(40), np.errstate(all="ignore"):
        x, exact, other = a, at(a, symbols), at(b, symbols)
        for _ in range(6):
            if rng.random() < 0.5:
                operation = BINARY[rng.integers(len(BINARY))]
                x, exact = operation(x, b), [operation(p, q) for p, q in zip(exact, other, strict=True)]
            else:
                name = UNARY[rng.integers(len(UNARY))]
                image = {"square": x**2, "inverse": 1 / x}.get(name) or getattr(ops, name)(x)
                true = {"sinc": mp.sincpi, "square": lambda y: y * y, "inverse": lambda y: 1 / y}.get(name)
                true = true or getattr(mp, name)
                x, exact = image, [true(p) for p in exact]
            for i in np.flatnonzero(np.isfinite(x.radius)):
                linear = Affine(x.centre[[i]], x.linear[:, [i]], np.zeros(1))
                outside += abs(exact[i] - at(linear, symbols[:, [i]])[0]) > x.radius[i]
                outside += not x.lower[i] <= exact[i] <= x.upper[i]
    return outside


@pytest.mark.parametrize("seed", first(3, range(16)))
def test_affine_arithmetic_encloses_random_operations(seed: int) -> None:
    assert escapes(seed) == 0


@pytest.mark.parametrize("name", ["sin", "inverse", "__mul__"])
def test_a_wrong_sign_in_a_derivative_escapes(name: str, monkeypatch) -> None:
    right = getattr(Affine, name)

    def wrong(*arguments):
        x = right(*arguments)
        return Affine(x.centre, -x.linear, x.radius)

    monkeypatch.setattr(Affine, name, wrong)
    assert any(escapes(seed) for seed in range(3))


def device(example, name: str) -> Device:
    return Device.of(load(example(name)).scenario)


def relative(design: Device, share: float, **units: float) -> Region:
    """All inputs off by a share of their value, some by a number of their unit."""
    widths = {varied: share * float(design.value_of(varied)) for varied in design.inputs}
    return region_of(design, {**widths, **{DesignInput(key): width for key, width in units.items()}})


CORNERS = np.array(list(product([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0], [0.0]))).T
"""Of devices whose membranes are off alike: the last two factors are what each has of its own."""


def keeps(region: Region) -> bool:
    """Whether the corners have stable motions; of a horizontal capsule the symmetric one."""
    cell, orbit = stable_motions(region.devices(CORNERS))
    if region.design.inclination_deg == 0:
        cell = cell[orbit.u == 0]
    return len(set(cell)) == CORNERS.shape[1]


def largest(design: Device) -> float:
    """A share of all inputs beyond which some device within it has no stable motion."""
    low, high = 0.0, 0.5
    for _ in range(25):
        middle = (low + high) / 2
        low, high = (middle, high) if keeps(relative(design, middle)) else (low, middle)
    return high


@pytest.mark.parametrize("name", first(0, ["inclined-forcing", "horizontal", "inclined", "design-point"]))
def test_nearly_the_largest_box_is_proved(name: str, example) -> None:
    design = device(example, name)
    share = largest(design)
    proof = prove_region(relative(design, 0.95 * share))
    assert (proof.halved != Leaf.OPEN).all()
    assert proof.failing is None
    assert prove_again(relative(design, 0.95 * share), proof.halved, proof.motions) == 1
    beyond = relative(design, 1.0001 * share)
    assert prove_again(beyond, proof.halved, proof.motions) < 1
    proof = prove_region(beyond)
    assert proof.failing is not None or Leaf.OPEN in proof.halved


def test_corners_of_a_region_are_the_extremes_of_all_devices(example) -> None:
    """As far as d and gbar go, by all combinations of the ends of the inputs."""
    design = replace(device(example, "design-point"), inclination_deg=30.0)
    widths = {varied: (k + 1) / 100 * float(design.value_of(varied)) for k, varied in enumerate(design.inputs)}
    ends = devices_off(design, widths, np.array(list(product([-1.0, 1.0], repeat=len(widths)))).T)
    corners = region_of(design, widths).devices(CORNERS)
    for one, other in zip(*(x.groups(Parameter.LENGTH, x.length_m)[:3] for x in (ends, corners)), strict=True):
        assert (one.min(), one.max()) == pytest.approx((other.min(), other.max()), rel=1e-14)


def test_a_free_capsule_has_its_mass_for_itself(example) -> None:
    """Its d has M/F and its gbar (M + m)/F, which no one factor counts: all devices are in, and all are proved."""
    design = replace(device(example, "inclined"), length_m=0.85, capsule=CapsuleMotion.FREE, ball_mass_kg=0.03)
    region = relative(design, 0.01)
    ends = devices_off(design, region_widths(region), np.array(list(product([-1.0, 1.0], repeat=6))).T)
    corners = region.devices(region.corners)
    for one, other in zip(*(x.groups(Parameter.LENGTH, x.length_m)[:3] for x in (ends, corners)), strict=True):
        assert (one.min(), one.max()) == pytest.approx((other.min(), other.max()), rel=1e-14)
    low, high = region.faces[0].low, region.faces[0].high
    boxes, rng = region.groups(low, high), np.random.default_rng(5)
    for _ in range(40):
        inside = low + (high - low) * rng.random(low.shape)
        some = region.devices(inside).groups(Parameter.LENGTH, region.devices(inside).length_m)
        for group, box in zip(some[:3], boxes[:3], strict=True):
            assert ((box.lower <= group) & (group <= box.upper)).all()
    # Every device of the region has the groups of one on a face: 1/F scaled up, s f^2 and sin(beta) scaled down.
    x = region.devices(rng.random((region.factors, 500)))
    scale = np.minimum.reduce(
        [
            x.amplitude_n / region.end[DesignInput.AMPLITUDE],
            x.length_m * x.frequency_hz**2
            / (region.start[DesignInput.LENGTH] * region.start[DesignInput.FREQUENCY] ** 2),
            np.sin(np.radians(x.inclination_deg)) / np.sin(np.radians(region.start[DesignInput.INCLINATION])),
        ]
    )  # fmt: skip
    moved = replace(x, amplitude_n=x.amplitude_n / scale, length_m=x.length_m / scale)
    moved = replace(moved, inclination_deg=np.degrees(np.arcsin(np.sin(np.radians(x.inclination_deg)) / scale)))
    for one, other in zip(*(y.groups(Parameter.LENGTH, y.length_m)[:2] for y in (x, moved)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13)
    proof = prove_region(region)
    assert proof.open_share == 0
    assert prove_again(region, proof.halved, proof.motions) == 1
    only_mass = region_of(design, {DesignInput.CAPSULE_MASS: 0.001})
    assert prove_region(only_mass).open_share == 0


def region_widths(region: Region) -> dict[DesignInput, float]:
    return {varied: (high - low) / 2 for varied, (low, high) in region.ranges.items()}


@pytest.mark.parametrize("tilt", [0.5, pytest.param(5.0, marks=pytest.mark.slow)])
def test_a_horizontal_capsule_may_be_tilted_to_either_side(tilt: float, example) -> None:
    design = device(example, "horizontal")
    region = relative(design, 0.05, inclination_deg=tilt)
    assert region.ranges[DesignInput.INCLINATION] == (0, tilt)
    assert (prove_region(region).halved != Leaf.OPEN).all()


def test_an_upright_capsule_may_be_tilted_to_either_side(example) -> None:
    region = region_of(replace(device(example, "inclined"), inclination_deg=89.5), {DesignInput.INCLINATION: 2.0})
    assert region.ranges[DesignInput.INCLINATION] == (87.5, 90)
    off = devices_off(region.design, {DesignInput.INCLINATION: 2.0}, np.array([[-1.0, 0.0, 1.0]]))
    assert off.inclination_deg.tolist() == [87.5, 89.5, 88.5]


@pytest.mark.parametrize(
    "case", first(0, [("inclined", slice(1)), *((name, slice(k % 2, 6, 2)) for k, name in enumerate(PAPER[1:]))])
)
def test_no_box_across_the_end_of_stable_motion_is_proved(case: tuple[str, slice], example) -> None:
    """The ends are known to 40 digits; from one millionth beyond them down to a thousandth of a billionth."""
    name, inputs = case
    design = device(example, name)
    nearest: dict[DesignInput, float] = {}
    for end in design_point(design, None).endings():
        if end.relative is not None and abs(end.relative) < 0.5:
            nearest.setdefault(end.parameter, abs(end.distance))
    assert len(nearest) >= 4
    for varied, distance in list(nearest.items())[inputs]:
        for beyond in (1e-6, 1e-12):
            proof = prove_region(region_of(design, {varied: distance * (1 + beyond)}))
            assert proof.failing is not None or Leaf.OPEN in proof.halved
        assert (prove_region(region_of(design, {varied: distance * (1 - 1e-6)})).halved != Leaf.OPEN).all()


@pytest.mark.slow
def test_a_tenth_of_the_margin_is_proved_for_random_devices() -> None:
    count = 0
    for i, sweep in enumerate(random_sweeps(80, 5)):
        design = replace(sweep.device, period_ratio=(1, 1, 2, 3)[i % 4])
        margins = [
            abs(ending.relative) for ending in design_point(design, None).endings() if ending.relative is not None
        ]
        if margins:
            proof = prove_region(relative(design, 0.1 * min(margins)))
            assert proof.failing is None
            assert Leaf.OPEN not in proof.halved
            count += 1
    assert count > 15


@pytest.mark.parametrize("case", first(1, [("design-point", 500), *((name, 20_000) for name in PAPER)]))
def test_random_devices_in_proved_boxes_are_stable(case: tuple[str, int], example) -> None:
    """Their motions are found by another route; simulated from beside, the ball comes nearer to them."""
    name, count = case
    design = device(example, name)
    share = 0.9 * largest(design)
    assert (prove_region(relative(design, share)).halved != Leaf.OPEN).all()
    rng = np.random.default_rng(7)
    widths = {varied: share * float(design.value_of(varied)) for varied in design.inputs}
    devices = devices_off(design, widths, rng.uniform(-1, 1, (len(widths), count)))
    cell, orbit = stable_motions(devices)
    cell, which = np.unique(cell, return_index=True)
    assert len(cell) == count
    if count > 1000:
        pytest.importorskip("numba")
        which = which[: count // 5]
        orbit, r = orbit.select(which), np.asarray(devices.restitution)[: count // 5]
        model = check_model(Groups(orbit.d, orbit.gbar, r))
        speed, phase = orbit.velocity_bottom, np.mod(orbit.phi, 2 * np.pi)
        starts = np.stack([np.full_like(speed, BOTTOM), 0 * speed, speed * (1 + 1e-5), phase], axis=1)
        rows, _ = follow_impacts(model, starts, 400, 1, workers=2)
        off = np.angle(np.exp(1j * (rows[:, -1, PHASE] - phase)))
        assert np.hypot(rows[:, -1, VELOCITY] / speed - 1, off).max() < 1e-5


def tolerances(example, name: str = "design-point", **keys: object) -> dict:
    """What results.json says of them."""
    study = analyse(load(example(name), {f"tolerances.{key}": value for key, value in keys.items()}), ["json"])
    return json.loads(json.dumps(study.to_dict()))["tolerances"]


def test_what_is_proved_is_proved_again_from_the_results(example) -> None:
    study = analyse(
        load(example("design-point"), {"tolerances.length_percent": 9, "tolerances.restitution": 0.02}), ["json"]
    )
    data = json.loads(json.dumps(study.to_dict()))
    outcome = data["tolerances"]
    assert (outcome["answer"], outcome["open_share"], outcome["worst"]) == ("proved", 0, None)
    assert outcome["boxes"] > 1
    assert plain(read_record(outcome, TolerancesData, "results")) == outcome
    assert recheck(data) == 1
    proof = outcome["proof"]
    outcome["proof"] = proof | {key: [] for key in ("u", "phi_bottom_rad", "velocity_bottom")}
    with pytest.raises(UsageError, match="not complete"):
        recheck(data)
    for forged in (int(Leaf.PROVED), int(Leaf.OPEN), -3):
        outcome["proof"] = proof | {"halved": [forged, *proof["halved"][1:]]}
        assert recheck(data) < 1
    outcome["proof"] = {"halved": [1, 0.5], "u": ["x"], "phi_bottom_rad": []}
    with pytest.raises(UsageError) as error:
        recheck(data)
    assert error.value.lines == (
        "results: tolerances.proof.halved[1]: expected a whole number, got the number 0.5",
        "results: tolerances.proof.u[0]: expected a number, got a text",
        "results: tolerances.proof.velocity_bottom: is missing",
    )
    with pytest.raises(UsageError, match="no proof"):
        recheck({**data, "tolerances": None})


def test_the_worst_device_names_no_record_from_the_folder_of_another_scenario(example) -> None:
    study = analyse(load(example("driven"), {"tolerances.length_percent": 30}), ())
    assert study.scenario.excitation.record is not None
    worst = loads(worst_scenario(study.scenario, study.tolerances.worst)).scenario
    assert (worst.excitation.record, worst.device.length_m) == (None, pytest.approx(0.49))


def test_the_worst_device_is_a_scenario_without_stable_motion(example, tmp_path) -> None:
    keys = [f"tolerances.{key}" for key in ("length_percent=8", "frequency_percent=2", "amplitude_percent=1")]
    out = tmp_path / "out"
    over = [word for key in keys for word in ("--set", key)]
    assert main([str(example("design-point")), "-o", str(out), "--format", "json", *over]) == 0
    outcome = json.loads((out / "results.json").read_text())["tolerances"]
    text = (out / "worst.yaml").read_text()
    assert outcome["answer"] == "refuted"
    assert plain(read_record(outcome, TolerancesData, "results")) == outcome
    assert text.startswith(outcome["worst"]["scenario"])  # what made the file stands below it
    worst = loads(text).scenario
    assert (worst.device.length_m, worst.excitation.frequency_hz) == pytest.approx((0.644, 1.96))
    assert worst.excitation.amplitude_n == pytest.approx(3.03)
    assert not analyse(loads(text)).solution.design.motions.stable_mask.any()
    design, share = device(example, "design-point"), outcome["worst"]["share"]
    widths = {DesignInput.LENGTH: 0.056, DesignInput.FREQUENCY: 0.04, DesignInput.AMPLITUDE: 0.03}
    for factor, stable in ((0.9999, True), (1.0001, False)):
        steps = np.array([[-factor * share], [-factor * share], [factor * share]])
        near = devices_off(design, widths, steps)
        assert bool(len(stable_motions(near)[0])) == stable


def test_a_design_without_stable_motion_is_its_own_worst_device(example) -> None:
    study = analyse(load(example("design-point"), {"tolerances.length_percent": 1, "device.length_m": 0.6}), ["json"])
    assert study.tolerances.worst.share == pytest.approx(0, abs=1e-9)
    assert study.tolerances.worst.values[DesignInput.LENGTH] == 0.6


@pytest.mark.slow
def test_the_yield_of_one_input_is_what_its_margin_says(example) -> None:
    design = device(example, "design-point")
    (end,) = [
        ending
        for ending in design_point(design, None).endings()
        if ending.parameter is DesignInput.LENGTH and ending.distance < 0
    ]
    edge = -end.relative / 0.12
    for distribution, exact in (
        ("uniform", (1 + edge) / 2),
        ("normal", 0.5 + erf(3 * edge / sqrt(2)) / erf(3 / sqrt(2)) / 2),
    ):
        shares = tolerances(example, length_percent=12, distribution=distribution)["yield"]
        assert shares["share"] == pytest.approx(exact, abs=5e-4)
        assert shares["low_95"] < exact < shares["high_95"]
        # Clopper and Pearson: at either end the count, or one farther off, has a probability of 2.5 %.
        count, trials = round(shares["share"] * shares["samples"]), shares["samples"]
        assert binom.sf(count - 1, trials, shares["low_95"]) == pytest.approx(0.025, rel=1e-6)
        assert binom.cdf(count, trials, shares["high_95"]) == pytest.approx(0.025, rel=1e-6)


@pytest.mark.slow
def test_a_pitchfork_between_the_ends_is_left_open(example) -> None:
    """The motion there has a multiplier of exactly 1: it is neither stable nor far from it."""
    outcome = tolerances(example, "horizontal", length_percent=30)
    assert outcome["answer"] == "undecided"
    assert 0 < outcome["open_share"] < 1e-5
    assert outcome["yield"]["share"] == 1


@pytest.mark.slow
def test_ranges_are_those_of_velocity_and_voltage(example) -> None:
    """Of one input both are monotone: the ends are those at the ends of the tolerance."""
    ranges = tolerances(example, length_percent=1)["ranges"]
    ends = []
    for length in (0.693, 0.707):
        solution = analyse(load(example("design-point"), {"device.length_m": length}), ["json"]).solution
        speed = solution.design.motions.velocity_bottom[0] * solution.device.velocity_unit(Parameter.LENGTH, length)
        ends.append((speed, solution.design.voltages_by_motion.average_v[0]))
    for (low, high), key in zip(np.sort(np.transpose(ends)), ("velocity_bottom_m_s", "u_ave_v"), strict=True):
        span = high - low
        assert low <= ranges[key]["least"] <= low + 1e-3 * span
        assert high - 1e-3 * span <= ranges[key]["largest"] <= high
        for share, name in ((0.05, "percentile_5"), (0.5, "median"), (0.95, "percentile_95")):
            assert ranges[key][name] == pytest.approx(low + share * span, abs=5e-3 * span)


@pytest.mark.slow
def test_the_yield_is_required_with_its_interval(example) -> None:
    def passed(**keys: object) -> bool:
        over = {key.replace("__", "."): value for key, value in keys.items()}
        (criterion,) = analyse(load(example("design-point"), over), ["json"]).criteria
        return criterion.passed

    required = "requirements__yield_at_least_percent"
    assert passed(tolerances__length_percent=1, **{required: 100})
    assert not passed(tolerances__length_percent=10.1, **{required: 99.95})  # 99.89 %
    assert passed(tolerances__length_percent=12, **{required: 91})
    assert not passed(tolerances__length_percent=12, **{required: 91.5})  # within the interval


def test_without_tolerances_nothing_is_computed_and_the_plan_says_so(example) -> None:
    study = analyse(load(example("inclined"), ["device.length_m=", "tolerances.restitution=0.1"]), ["json"])
    assert study.tolerances is None
    assert "device.length_m is not given" in [step.why for step in study.plan.left_out if step.task == "tolerances"]
    study = analyse(load(example("design-point")), ["json"])
    assert "the scenario has no tolerances block" in [step.why for step in study.plan.left_out]
