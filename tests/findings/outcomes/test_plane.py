"""Planes of outcomes by quadtree, and the stable manifold that bounds their colours."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from devices import case

from vireport.findings.outcomes.manifold import on_shocks, stable_manifold
from vireport.findings.outcomes.plane import shock_plane
from vireport.findings.outcomes.returning import core_of, endings
from vireport.findings.outcomes.shock import shocked
from vireport.physics.motion import Motion
from vireport.physics.numbers import wrapped
from vireport.simulation.attractors import Outcome
from vireport.simulation.events import check_model, follow_impacts
from vireport.simulation.kernel import PHASE, VELOCITY, WALL
from vireport.simulation.starts import random_starts


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
