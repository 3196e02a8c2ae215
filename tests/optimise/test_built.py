"""The best design as it can be built."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from design_texts import DEVICE, unlimited

from vireport.optimise import outputs
from vireport.optimise.built import LOSS, built_design
from vireport.optimise.problem import problem_of
from vireport.optimise.search import SearchResult, optimise
from vireport.scenario.loading import loads

LENGTH = "{path: device.length_m, from: 0.4, to: 1.0}"


@cache
def shortest() -> SearchResult:
    """The shortest device that has a margin of 5 %: what is shorter, also by rounding, fails that."""
    required = unlimited("margin_any_percent: 5")
    design = f"design: {{minimise: length_m, cells: 16, vary: [{LENGTH}]}}"
    return optimise(problem_of(loads(f"{DEVICE}requirements: {{{required}}}\n{design}\n")))


@pytest.mark.slow
def test_a_rounded_design_has_few_digits_meets_all_and_loses_little() -> None:
    result = shortest()
    (value,), (exact,) = (result.problem.values(point.t).tolist() for point in (result.built, result.best))
    assert value == pytest.approx(float(f"{value:.3g}"), rel=1e-14)
    # Rounded to the nearest it would be shorter, and fail, or longer: only the latter is taken.
    assert exact < value < exact * (1 + LOSS)
    assert result.built.met()
    below = result.problem.study((np.array([float(f"{exact:.3g}") - 0.001]) - 0.4) / 0.6)
    assert not all(line.passed for line in below.criteria)


@pytest.mark.slow
def test_the_sentence_and_the_table_have_the_rounded_design_and_json_has_both() -> None:
    result = shortest()
    (value,) = result.problem.values(result.built.t).tolist()
    study = outputs.run_of(result)
    told = outputs.text(result, study)
    first = told.splitlines()[0]
    assert first.startswith(f"Best: length {value:.3g} m")
    assert len(first.split()) <= 15
    assert f"{value:.3g}" in next(line for line in told.splitlines() if line.startswith("device.length_m"))
    assert "Rounded so that it still meets all requirements" in told


@pytest.mark.slow
def test_a_design_at_an_end_of_its_range_stays_there() -> None:
    result = shortest()
    at_end = result.problem.study(np.array([1.0]))
    best = type(result.best)(np.array([1.0]), at_end, result.problem.value_of(at_end, np.array([1.0])))
    built = built_design(result.problem, best)
    assert built.t.tolist() == [1.0]
