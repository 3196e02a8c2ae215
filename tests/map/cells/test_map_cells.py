"""Which values each cell of a map has: by its number alone, evenly, and the same however the map is divided."""

from __future__ import annotations

import numpy as np
import pytest
from map_texts import TEXT, all_cells, plan_of, sampled
from msgspec.structs import replace
from scipy.stats import qmc

from vireport.base.errors import NumericalError
from vireport.map.cells.cells import cell_values, map_plan

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


@pytest.mark.parametrize(("sampling", "drawn"), [("sobol", qmc.Sobol), ("latin_hypercube", qmc.LatinHypercube)])
def test_points_are_those_of_scipy_in_any_order(sampling: str, drawn: type) -> None:
    plan = plan_of(sampled(sampling, 512, seed=3))
    low, high = BOX
    expected = low + (high - low) * drawn(2, rng=np.random.default_rng(3)).random(512)
    assert np.array_equal(np.column_stack(all_cells(plan)), expected)
    for numbers in (np.array([511, 3, 4, 5, 100]), np.array([0]), np.arange(511, 400, -1)):
        assert np.array_equal(np.column_stack(cell_values(plan, numbers)), expected[numbers])


@pytest.mark.parametrize(("sampling", "samples", "bins"), [("sobol", 256, 64), ("latin_hypercube", 1000, 1000)])
def test_samples_fill_their_box_evenly(sampling: str, samples: int, bins: int) -> None:
    for column in unit_points(plan_of(sampled(sampling, samples))).T:
        counts = np.histogram(column, bins=bins, range=(0, 1))[0]
        assert counts.min() == counts.max()


@pytest.mark.parametrize("samples", [1, 17, 4097])
def test_a_latin_hypercube_has_one_point_in_each_stratum(samples: int) -> None:
    for column in unit_points(plan_of(sampled("latin_hypercube", samples))).T:
        assert sorted(np.floor(column * samples)) == list(range(samples))


def test_another_seed_gives_other_points() -> None:
    for sampling in ("sobol", "latin_hypercube"):
        first, other = (unit_points(plan_of(sampled(sampling, 64, seed))) for seed in (0, 1))
        assert not np.isclose(first, other).any()


def test_the_example_is_a_map(example) -> None:
    from vireport.scenario.loading import load_map

    assert map_plan(load_map(example("maps/map"))).shape == (60, 80)
