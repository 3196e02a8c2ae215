"""Planes of outcomes by quadtree, the stable manifold that bounds their colours, basins, and their figures."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from devices import case
from figure_cases import ROOT, texts_of
from matplotlib.colors import to_rgb

from vireport.design.from_rest import Destination
from vireport.figures.pictures import pictures
from vireport.findings.outcomes.basin import basins_of
from vireport.findings.outcomes.figures import LEAST, MANIFOLD, RETURNING
from vireport.findings.outcomes.manifold import on_shocks, stable_manifold
from vireport.findings.outcomes.plane import shock_plane
from vireport.findings.outcomes.returning import Recogniser, core_of, endings
from vireport.findings.outcomes.shock import shocked
from vireport.physics.device import Device
from vireport.physics.motion import Motion
from vireport.physics.numbers import wrapped
from vireport.scenario.loading import load
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import Outcome, find_attractor
from vireport.simulation.events import BOTTOM, Impact, check_model, follow_impacts, start_of
from vireport.simulation.kernel import PHASE, VELOCITY, WALL
from vireport.simulation.starts import random_starts
from vireport.study.study import analyse


def passes(groups, companion: Motion, starts: np.ndarray, impacts: int = 12) -> np.ndarray:  # type: ignore[no-untyped-def]
    """Least distance from a motion's first impact on the way from each start."""
    rows, _ = follow_impacts(np.repeat(check_model(groups), len(starts), axis=0), starts, impacts)
    off = np.maximum(
        np.abs(wrapped(rows[..., PHASE] - companion.phase[0])) / pi, np.abs(rows[..., VELOCITY] - companion.velocity[0])
    )
    return np.where(rows[..., WALL] == companion.word.walls[0], off, np.inf)[:, 1:].min(axis=1)


def test_few_points_of_the_quadtree_are_wrong() -> None:
    """Against every point of the grid; those that are wrong lie in thin bands."""
    device = case(3.6)
    groups, (motion,) = device.groups, device.stable
    plane = shock_plane(groups, [motion], 0.8, 65)
    assert [each.outcome for each in plane.outcomes] == [Outcome.PERIODIC, Outcome.STICKING]
    assert plane.evaluated < 0.5 * plane.outcome.size
    core = core_of(groups, motion)
    period = motion.time[1] - motion.time[0]
    later = plane.x >= period
    found = np.empty_like(plane.outcome)
    for impact in (0, 1):
        own = later == bool(impact)
        delay, jump = (each.ravel() for each in np.meshgrid(plane.x[own] - period * impact, plane.y))
        found[:, own] = (endings(groups, shocked(groups, motion, impact, delay, jump), [core]) != 0).reshape(65, -1)
    assert np.mean(found != plane.outcome) < 0.012
    assert plane.share(0) == pytest.approx(0.96, abs=0.02)
    # no shock is none
    assert not plane.outcome[32].any()


@pytest.mark.slow
def test_the_plane_of_a_symmetric_motion_is_its_own_image() -> None:
    """Half a period later with the jump the other way."""
    device = case(3.0836, 0.4808, 0.0, 0.7421)
    plane = shock_plane(device.groups, device.stable[:1], 0.3, 65)
    later = np.roll(plane.outcome[::-1, :-1], 32, axis=1)
    assert 0.1 < plane.share(0) < 0.9
    assert np.mean((later == 0) == (plane.outcome[:, :-1] == 0)) > 0.97


@pytest.mark.slow
def test_the_manifold_leads_to_the_companion() -> None:
    """Impacts on it, and shocks on its line in the plane of shocks, pass the unstable motion; other starts do not.

    On the way there an error of drawing grows 48-fold in a period.
    """
    device = case(3.6)
    groups, motion, companion = device.groups, device.stable[0], device.unstable[0]
    pieces = stable_manifold(groups, companion, 1.5)
    assert 2000 < sum(len(piece.after) for piece in pieces) < 40_000
    wall, time, after = (
        np.concatenate([np.broadcast_to(getattr(piece, name), len(piece.after)) for piece in pieces])[::20]
        for name in ("start_wall", "start_time", "after")
    )
    starts = np.stack([wall, 0 * wall, -after / groups.restitution, np.mod(pi * time, 2 * pi)], axis=1)
    assert np.median(passes(groups, companion, starts)) < 0.02
    assert np.median(passes(groups, companion, random_starts(groups.d, 1.5, 200, 1)[0])) > 0.1
    lines = [line for piece in pieces for line in on_shocks(groups, motion, piece)]
    times, jumps = (np.concatenate([line[k] for line in lines])[::10] for k in (0, 1))
    begins = motion.time - motion.time[0]
    for impact, end in enumerate((begins[1], 2.0)):
        own = (times >= begins[impact]) & (times < end)
        rows = shocked(groups, motion, impact, times[own] - begins[impact], jumps[own])
        assert np.median(passes(groups, companion, rows)) < 0.02


def test_the_line_comes_as_near_as_the_least_shock() -> None:
    """0.1694 just after the bottom impact, and nowhere nearer."""
    device = case(3.6)
    motion = device.stable[0]
    pieces = stable_manifold(device.groups, device.unstable[0], 1.5, 0.01)
    lines = [line for piece in pieces for line in on_shocks(device.groups, motion, piece)]
    sizes, times = np.abs(np.concatenate([line.jump for line in lines])), np.concatenate([line.time for line in lines])
    assert sizes.min() == pytest.approx(0.1694, abs=0.003)
    assert times[sizes.argmin()] < 0.05


def test_a_grid_must_be_one_that_can_be_halved() -> None:
    device = case(3.6)
    for points in (16, 18, 100, 9):
        with pytest.raises(ValueError, match="power of 2"):
            shock_plane(device.groups, device.stable, 0.5, points)


def test_a_motion_that_attracts_has_no_line() -> None:
    device = case(3.6)
    assert stable_manifold(device.groups, device.stable[0], 1.5) == ()


def test_points_and_shares_are_those_of_impacts_followed_one_by_one() -> None:
    device = case(3.6)
    found = basins_of(device.groups, device.stable, device.unit, 33)
    plane, rng = found.plane, np.random.default_rng(3)
    assert {of.outcome for of in plane.outcomes} == {Outcome.PERIODIC, Outcome.STICKING}
    for row, column in rng.integers(0, 33, (30, 2)).tolist():
        start = Impact(BOTTOM, float(plane.y[row]), float(plane.x[column]))
        assert find_attractor(device.groups, start).name == plane.outcomes[plane.outcome[row, column]].name
    shares = {name: (low, high) for name, _, low, high in found.shares}
    assert found.impacts == sum(found.hits) == 4000
    low, high = shares["BT every forcing period"]
    assert low < 0.853 < high
    assert high - low < 0.03
    assert plane.share(0) == pytest.approx(0.853, abs=0.03)
    # The motion's own impact lies in its basin.
    motion = device.stable[0]
    at = np.argmin(np.abs(plane.y - motion.velocity[0])), np.argmin(np.abs(plane.x - motion.phase[0]))
    assert plane.outcome[at] == 0


def test_where_no_motion_is_known_all_that_is_met_is_learnt() -> None:
    device = Device(3.155, 0.46, 9.8, 0.0446, 3.0, 2.0, 54.8)
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    recognise = Recogniser(groups, ())
    rows = np.array([(BOTTOM, 0.0, velocity, phase) for velocity in (0.2, 1.0) for phase in (0.3, 3.0)])
    found = recognise(rows)
    alone = [find_attractor(groups, start_of(row), 100_000, compiled=False).outcome for row in rows]
    assert [recognise.outcomes[k].outcome for k in found] == alone


NOT_REACHED = "excitation.amplitude_n=3.6", "disturbances={}"


@pytest.mark.slow
def test_the_plane_of_shocks_shows_what_was_found() -> None:
    """At 3.6 N, where the device does not come to the motion from rest and some shocks lead back there."""
    study = analyse(load(ROOT / "examples" / "inclined-forcing.yaml", NOT_REACHED), ["png"])
    assert study.switched_on.from_rest.destination is Destination.REST_CYCLE
    (drawn,) = [picture for picture in pictures(study) if picture.name == "figure-shocks"]
    axes, withstood = drawn.figure.axes[0], study.outcomes.withstood
    (image,) = axes.images
    pixels = np.asarray(image.get_array())
    returned = np.isclose(pixels, to_rgb(RETURNING)).all(axis=2)
    assert f"{100 * returned.mean():.1f} % of them return" in drawn.caption
    least = withstood.jump_m_s
    assert f"The least that leads out, {least:.2f} m/s" in drawn.caption
    rows = np.linspace(*image.get_extent()[2:], len(pixels))
    assert returned[np.abs(rows) < 0.99 * least].all()
    assert not returned.all()
    (arrow,) = [line for line in axes.lines if line.get_color() == LEAST["color"]]
    assert abs(arrow.get_ydata()[1]) == pytest.approx(least, rel=1e-12)
    manifold = [line for line in axes.lines if line.get_color() == MANIFOLD["color"]]
    nearest = min(np.abs(line.get_ydata()).min() for line in manifold)
    assert nearest == pytest.approx(least, rel=0.02)
    assert {"least shock", "BT every forcing period"} <= set(texts_of(drawn.figure))
