"""Random devices, sweeps and scenarios: seeded generators, and strategies for Hypothesis."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from hypothesis import strategies as st

from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.scenario.parameters import DRIVING, Parameter

restitutions = st.sampled_from([0.0, 1e-12, 1e-3, 0.5, 0.999, 1 - 1e-6]) | st.floats(0, 1 - 1e-6)
inclinations = st.sampled_from([0.0, 1e-9, 0.01, 45.0, 89.999999, 90.0]) | st.floats(0, 90)
shares = st.floats(-0.499, 0.499)
"""q - 1/2."""
phases = st.floats(0, 6.28)


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers evenly spread over decades."""
    return st.floats(low, high).map(lambda power: float(10**power))


def random_sweeps(count: int, seed: int) -> list[Sweep]:
    """Sweeps over the whole range of restitution and inclination and all four parameters, some horizontal."""
    rng = np.random.default_rng(seed)
    sweeps = []
    for i in range(count):
        parameter = DRIVING[i % 4]
        inclination = 0.0 if i % 11 == 0 else float(rng.uniform(0.5, 90.0))
        mass, frequency = float(10 ** rng.uniform(-2, 0.5)), float(10 ** rng.uniform(-0.3, 1.5))
        gbar = float(10 ** rng.uniform(-2, 0.1))
        force = mass * 9.8 * float(np.sin(np.radians(inclination or 30.0))) / gbar
        length = float(10 ** rng.uniform(-1.0, 0.2)) * force / (4 * mass * frequency**2)
        values = dict(zip(DRIVING, (length, force, frequency, inclination), strict=True))
        if parameter is Parameter.INCLINATION:
            start, end = sorted(rng.uniform(0.0, 90.0, 2))
        else:
            start, end = values[parameter] * rng.uniform(0.3, 0.9), values[parameter] * rng.uniform(1.1, 3.0)
        device = Device(mass, float(rng.uniform(0.05, 0.95)), 9.8, **values)
        sweeps.append(Sweep(device, parameter, float(start), float(end)))
    return sweeps


def sweep_grid() -> list[Sweep]:
    """Sweeps of every parameter with every n, inclination and restitution of a list, in a shuffled order.

    Those over the inclination begin at 0, next to it, or inside, and end at 90 degrees or before.
    """
    rng = np.random.default_rng(20190301)
    sweeps = []
    for parameter, n, k, r in product(DRIVING, (1, 2, 3), range(5), (0.02, 0.5, 0.98)):
        mass, frequency = float(10 ** rng.uniform(-2, 0.5)), float(10 ** rng.uniform(-0.3, 1.5))
        force = mass * 9.8 / float(10 ** rng.uniform(-1.5, 0))
        length = float(10 ** rng.uniform(-0.8, 0.2)) * n * force / (4 * mass * frequency**2)
        values = dict(zip(DRIVING, (length, force, frequency, (0.0, 1e-9, 1e-3, 30.0, 90.0)[k]), strict=True))
        if parameter is Parameter.INCLINATION:
            inside = rng.uniform(1.0, 80.0, 2).tolist()
            start, end = ((0.0, inside[0]), (0.0, 90.0), (1e-3, 90.0), (inside[0], 90.0), sorted(inside))[k]
        else:
            start, end = values[parameter] * rng.uniform(0.3, 0.9), values[parameter] * rng.uniform(1.1, 3.0)
        device = Device(mass, r, 9.8, **values, period_ratio=n)
        sweeps.append(Sweep(device, parameter, float(start), float(end)))
    return [sweeps[i] for i in rng.permutation(len(sweeps))]


@st.composite
def sweeps(draw: Any) -> Sweep:
    """A sweep with gbar and d over many decades, in either direction."""
    r, beta, n = (
        draw(restitutions.filter(lambda r: r <= 0.999)),
        draw(inclinations),
        draw(st.sampled_from([1, 1, 1, 2, 3, 5])),
    )
    gbar, d = draw(decades(-4, 2)), draw(decades(-5, 3))
    mass, frequency = draw(decades(-6, 6)), draw(decades(-6, 6))
    force = mass * 9.8 * float(np.sin(np.radians(max(beta, 5.0)))) / gbar
    values = dict(zip(DRIVING, (d * force / (4 * mass * frequency**2), force, frequency, beta), strict=True))
    parameter = draw(st.sampled_from(DRIVING))
    start, end = draw(_ends(parameter, values[parameter], 1 + draw(decades(-3, 1.5))))
    return Sweep(Device(mass, r, 9.8, **values, period_ratio=n), parameter, start, end)


@st.composite
def _ends(draw: Any, parameter: Parameter, value: float, factor: float) -> tuple[float, float]:
    """Both ends of a sweep around a value, in either order."""
    ends = value / factor, value * factor
    if parameter is Parameter.INCLINATION:
        ends = draw(st.floats(0, 44)), draw(st.floats(45, 90))
    return ends if draw(st.booleans()) else ends[::-1]


@st.composite
def solvable_trees(draw: Any) -> dict[str, Any]:
    """Scenarios as plain data, of any size; half of them with groups for which there is something to find."""
    capsule, frequency, beta = draw(decades(-14, 14)), draw(decades(-14, 14)), draw(inclinations)
    gravity = draw(st.just(9.8) | decades(-10, 3))
    if draw(st.booleans()):
        force, length = draw(decades(-14, 14)), draw(decades(-14, 14))
    else:
        gbar, d = draw(decades(-6, 1)), draw(decades(-3, 1))
        frequency, capsule = draw(decades(-3, 3)), draw(decades(-6, 6))
        force = float(np.clip(capsule * gravity * np.sin(np.radians(max(beta, 1e-3))) / gbar, 1e-14, 1e14))
        length = float(np.clip(d * force / (4 * capsule * frequency**2), 1e-14, 1e14))
    device = {"capsule_mass_kg": capsule, "restitution": draw(restitutions), "length_m": length}
    tree = {
        "schema_version": 1,
        "period_ratio": draw(st.sampled_from([1, 1, 1, 2, 3, 7, 20])),
        "gravity_m_s2": gravity,
        "inclination_deg": beta,
        "device": device,
        "excitation": {"amplitude_n": force, "frequency_hz": frequency},
    }
    if draw(st.booleans()):
        device["ball_mass_kg"] = max(capsule * draw(decades(-6, -0.1)), 1e-15)
        if draw(st.booleans()):
            active = draw(decades(-6, 3))
            device["membrane"] = {
                "stiffness": draw(decades(-3, 12)),
                "exponent": draw(st.floats(0.1, 8)),
                "active_radius_m": active,
                "ball_radius_m": active * draw(st.floats(0.001, 0.999)),
            }
    if draw(st.integers(0, 3)):
        parameter = draw(st.sampled_from(DRIVING))
        value = dict(zip(DRIVING, (length, force, frequency, beta), strict=True))[parameter]
        ends = draw(_ends(parameter, value, 1 + draw(decades(-6, 2))) | _anywhere(parameter))
        low, high = (x if parameter is Parameter.INCLINATION else float(np.clip(x, 1e-15, 1e15)) for x in ends)
        tree["sweep"] = {"parameter": parameter.value, "from": low, "to": high}
        if low != high and draw(st.booleans()):
            tree["requirements"] = {"stable_from": min(low, high), "stable_to": max(low, high)}
    if draw(st.booleans()):
        tree["simulation"] = {"starts": draw(st.integers(1, 3)), "impacts": 200}
        if "sweep" in tree:
            tree["simulation"]["samples"] = draw(st.integers(2, 5))
            tree.get("requirements", {})["crosscheck_passed"] = True
    return tree


def _anywhere(parameter: Parameter) -> st.SearchStrategy[tuple[float, float]]:
    """Both ends of a sweep anywhere in the limits of its parameter."""
    end = inclinations
    if parameter is not Parameter.INCLINATION:
        end = decades(*(float(np.log10(limit)) for limit in parameter.limits))
    return st.tuples(end, end).filter(lambda ends: abs(ends[1] - ends[0]) > 1e-8 * max(ends))
