"""Curves on a map along which motions change: where they double, meet or graze."""

from __future__ import annotations

import numpy as np
import pytest
from map_texts import TEXT, plan_of
from msgspec.structs import replace

from vireport.figures.captions import held_by
from vireport.map.cells.figures import loci_of
from vireport.motions.pointwise import find_motions
from vireport.physics.groups import Groups
from vireport.scenario.parameters import Parameter

pytestmark = pytest.mark.slow  # the curves take some seconds


def motions_at(plan, x: float, y: float):
    """All motions at two values of the axes."""
    device = replace(plan.device, **dict(zip(plan.names, (x, y), strict=True)))
    d, gbar, *_ = device.groups(Parameter.LENGTH, device.length_m)
    return find_motions(Groups(np.array([float(d)]), np.array([float(gbar)]), 0.5), 1)


def curves_of(plan):
    """The curves on a map."""
    return loci_of(plan, plan.plane)


@pytest.fixture(scope="module")
def curves():
    plan = plan_of(TEXT)
    return plan, curves_of(plan)


def points_on(loci, kind: str) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for locus in loci if locus.event == kind for x, y in locus.points]


@pytest.mark.parametrize(("kind", "trace"), [("period_doubling", -(1 + 0.5**4)), ("node_focus", 2 * 0.5**2)])
def test_the_trace_has_its_value_on_a_curve(curves, kind: str, trace: float) -> None:
    plan, loci = curves
    points = [(x, y) for x, y in points_on(loci, kind) if x > 0.5]
    assert len(points) > 100
    for x, y in points[::29]:
        assert min(np.abs(np.abs(motions_at(plan, x, y).trace) - abs(trace)).min(), 1) < 1e-4


@pytest.mark.parametrize("kind", ["fold", "grazing"])
def test_motions_appear_across_the_other_curves(curves, kind: str) -> None:
    plan, loci = curves
    points = [(x, y) for x, y in points_on(loci, kind) if x > 0.5]
    assert len(points) > 20
    for x, y in points[::5]:
        sides = [motions_at(plan, x, y * (1 + k * 1e-4)) for k in (-1, 1)]
        if kind == "fold":
            assert abs(len(sides[0].cell) - len(sides[1].cell)) == 2
        else:
            assert abs(int(sides[0].admissible.sum()) - int(sides[1].admissible.sum())) == 1


def test_curves_pass_through_the_paper_s_points(curves) -> None:
    _, loci = curves
    metres = 3 / (4 * 0.1245 * 4)
    doubling = [locus.points for locus in loci if locus.event == "period_doubling"]
    assert any(np.abs(points - (45.0, 0.4179595416 * metres)).min(axis=0).max() < 0.4 for points in doubling)
    ends = np.concatenate([points[[0, -1]] for points in doubling])
    assert np.abs(ends[:, 1] - 0.1870532313 * metres).min() < 1e-8
    folds = np.concatenate([locus.points[[0, -1]] for locus in loci if locus.event == "fold"])
    assert np.abs(folds[:, 1] - 0.2634315843 * metres).min() < 1e-8


def test_curves_over_both_restitutions_are_those_of_the_margins_there() -> None:
    text = TEXT.replace("inclination_deg, from: 0, to: 90", "device.restitution_bottom, from: 0.3, to: 0.7")
    text = text.replace("device.length_m, from: 0.2, to: 0.9", "device.restitution_top, from: 0.3, to: 0.7")
    text = text.replace("restitution: 0.5", "length_m: 0.6934")
    plan = plan_of(text.replace("excitation:", "inclination_deg: 45\nexcitation:"))
    doubling = [locus.points for locus in curves_of(plan) if locus.event == "period_doubling"]
    assert len(doubling) == 1
    # The two ends of stable motion of the paper's device, restitution 0.5: margins in either of the two.
    for place in ((0.46701430324607485, 0.5), (0.5, 0.5312846582185935)):
        assert np.abs(doubling[0] - place).max(axis=1).min() < 2e-3
    assert held_by(plan.device, plan.names) == ["s = 0.6934 m", "F = 3 N", "f = 2 Hz", "β = 45°", "M = 0.1245 kg"]
    assert held_by(plan.device, plan.names[:1])[-1] == "r_top = 0.3"


def test_over_the_balls_mass_curves_are_straight() -> None:
    text = TEXT.replace("inclination_deg, from: 0, to: 90", "device.ball_mass_kg, from: 0.004, to: 0.02")
    loci = curves_of(plan_of(text.replace("excitation:", "inclination_deg: 45\nexcitation:")))
    assert {"period_doubling", "grazing"} <= {locus.event for locus in loci}
    for locus in loci:
        np.testing.assert_array_equal(locus.points[:, 0], [0.004, 0.02])
        assert locus.points[0, 1] == locus.points[1, 1]


@pytest.mark.parametrize(
    ("change", "kinds"),
    [
        (("restitution: 0.5", "restitution: 0"), {"grazing", "fold"}),
        (("inclination_deg, from: 0, to: 90", "device.restitution, from: 0, to: 0.99"), {"grazing", "pitchfork"}),
    ],
)
def test_a_grazing_without_touch_or_impact_begins_no_curve(change: tuple[str, str], kinds: set[str]) -> None:
    text = TEXT.replace(*change)
    if "path: inclination_deg" not in text:
        text = text.replace("excitation:", "inclination_deg: 0\nexcitation:")
    loci = curves_of(plan_of(text))
    assert kinds <= {locus.event for locus in loci}
