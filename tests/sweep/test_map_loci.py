"""Curves on a map along which motions change: where they double, meet or graze."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from map_texts import TEXT, plan_of

from vireport.analysis import find_motions
from vireport.scenario import Parameter
from vireport.sweep.loci import loci_of

pytestmark = pytest.mark.slow  # the curves take some seconds


def motions_at(plan, x: float, y: float):
    """All motions at two values of the axes."""
    device = replace(plan.device, **dict(zip(plan.names, (x, y), strict=True)))
    d, gbar = device.groups(Parameter.LENGTH, device.length_m)
    return find_motions(np.array([float(d)]), np.array([float(gbar)]), 0.5, 1)


@pytest.fixture(scope="module")
def curves():
    plan = plan_of(TEXT)
    return plan, loci_of(plan)


def points_on(loci, kind: str) -> list[tuple[float, float]]:
    return [(x, y) for locus in loci if locus.kind == kind for x, y in zip(locus.x, locus.y, strict=True)]


def test_multipliers_are_minus_one_where_periods_double(curves) -> None:
    plan, loci = curves
    points = points_on(loci, "period_doubling")
    assert len(points) > 100
    for x, y in points[::7]:
        assert np.abs(motions_at(plan, x, y).trace + (1 + 0.5**4)).min() < 1e-6


@pytest.mark.parametrize("kind", ["fold", "grazing"])
def test_motions_appear_across_the_other_curves(curves, kind: str) -> None:
    plan, loci = curves
    points = [(x, y) for x, y in points_on(loci, kind) if x > 0.5]
    assert len(points) > 20
    for x, y in points[::5]:
        sides = [motions_at(plan, x, y * (1 + k * 1e-7)) for k in (-1, 1)]
        if kind == "fold":
            assert abs(len(sides[0].cell) - len(sides[1].cell)) == 2
        else:
            assert abs(int(sides[0].admissible.sum()) - int(sides[1].admissible.sum())) == 1


def test_curves_pass_through_the_paper_s_points(curves) -> None:
    _, loci = curves
    metres = 3 / (4 * 0.1245 * 4)
    doubling = [locus for locus in loci if locus.kind == "period_doubling"]
    long = max(doubling, key=lambda locus: len(locus.x))
    assert np.interp(45.0, long.x, long.y) == pytest.approx(0.4179595416 * metres, rel=1e-4)
    assert long.y[0] == pytest.approx(0.1870532313 * metres, rel=1e-9)
    fold = max((locus for locus in loci if locus.kind == "fold"), key=lambda locus: len(locus.x))
    assert fold.y[0] == pytest.approx(0.2634315843 * metres, rel=1e-9)


def test_curves_are_joined_without_jumps(curves) -> None:
    _, loci = curves
    for locus in loci:
        assert (np.diff(locus.x) > 0).all()
        assert np.abs(np.diff(locus.y)).max() < 0.03
