"""Which values each cell of a map has: by its number alone, evenly, and the same however the map is divided."""

from __future__ import annotations

import numpy as np
import pytest
from map_texts import TEXT, all_cells, plan_of, sampled
from msgspec.structs import replace
from scipy.stats import qmc

from vireport.base import NumericalError
from vireport.maps import map_plan
from vireport.maps.cells import cell_values

BOX = np.array([[0.0, 0.2], [90.0, 0.9]])


def unit_points(plan) -> np.ndarray:
    """Points of the unit cube that the cells are."""
    return (np.column_stack(all_cells(plan)) - BOX[0]) / (BOX[1] - BOX[0])


def test_restitution_of_one_is_outside_the_theory() -> None:
    with pytest.raises(NumericalError, match="restitution"):
        plan_of(TEXT.replace("restitution: 0.5", "restitution: 1"))


def test_grid_has_every_combination_and_exact_ends() -> None:
    angle, length = all_cells(plan_of(TEXT))
    assert len(angle) == 500
    assert len(set(zip(angle, length, strict=True))) == 500
    assert (angle[0], angle[-1], length[0], length[-1]) == (0.0, 90.0, 0.2, 0.9)
    assert (length[:25] == length[25:50]).all()  # the last axis varies fastest


@pytest.mark.parametrize("sampling", ["grid", "sobol", "latin_hypercube"])
def test_cells_do_not_depend_on_the_chunks(sampling: str) -> None:
    plan = plan_of(TEXT if sampling == "grid" else sampled(sampling, 256))
    for size in (1000, 60, 7):
        for a, b in zip(all_cells(plan), all_cells(replace(plan, chunk_cells=size)), strict=True):
            assert np.array_equal(a, b)


@pytest.mark.slow
@pytest.mark.parametrize("sampling", ["sobol", "latin_hypercube"])
def test_the_last_cells_of_the_largest_map_need_none_before_them(sampling: str) -> None:
    plan = replace(plan_of(sampled(sampling, 256)), cells=2**30)
    points = np.column_stack(cell_values(plan, 2**30 - 1 - np.arange(5)))
    assert (points >= BOX[0]).all()
    assert (points <= BOX[1]).all()
    assert len(np.unique(points)) == 10


def test_sobol_points_are_those_of_scipy() -> None:
    plan = plan_of(sampled("sobol", 512, seed=3))
    expected = qmc.Sobol(2, scramble=True, rng=np.random.default_rng(3)).random(512)
    low, high = BOX
    assert np.array_equal(np.column_stack(all_cells(plan)), low + (high - low) * expected)


@pytest.mark.parametrize(("sampling", "samples", "bins"), [("sobol", 256, 64), ("latin_hypercube", 1000, 1000)])
def test_samples_fill_their_box_evenly(sampling: str, samples: int, bins: int) -> None:
    for column in unit_points(plan_of(sampled(sampling, samples))).T:
        counts = np.histogram(column, bins=bins, range=(0, 1))[0]
        assert counts.min() == counts.max()


@pytest.mark.parametrize("samples", [1, 2, 3, 5, 16, 17, 100, 4097])
def test_a_latin_hypercube_has_one_point_in_each_stratum(samples: int) -> None:
    for column in unit_points(plan_of(sampled("latin_hypercube", samples))).T:
        assert sorted(np.floor(column * samples)) == list(range(samples))


@pytest.mark.slow
def test_the_strata_of_a_latin_hypercube_are_paired_at_random() -> None:
    """Like points drawn independently: no correlation, and a tenth of the square has its share of them."""
    samples = 20_000
    seeds = [unit_points(plan_of(sampled("latin_hypercube", samples, seed))) for seed in range(4)]
    for points in seeds:
        assert abs(np.corrcoef(points.T)[0, 1]) < 4 / np.sqrt(samples)
        counts = np.histogram2d(*points.T, bins=10)[0]
        assert ((counts - samples / 100) ** 2).sum() / (samples / 100) < 160  # chi-squared, 81 degrees of freedom
        steps = np.abs(np.diff(points, axis=0)).mean(axis=0)
        assert steps == pytest.approx([1 / 3, 1 / 3], abs=0.02)
    assert not np.array_equal(seeds[0], seeds[1])


def test_the_example_is_a_map(example) -> None:
    from vireport.scenario import load_map

    assert map_plan(load_map(example("maps/map"))).shape == (60, 80)
