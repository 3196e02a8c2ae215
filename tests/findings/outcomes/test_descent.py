"""The descent to the least shock keeps its invariant, whatever leads out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from vireport.findings.outcomes.shock import QUICK, SCAN, Effort, Shock, descended

Floats = NDArray[np.float64]


class Bands:
    """Shocks that lead out: above an edge that varies with the delay, and in bands below it; notes what was tried."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.edge, self.tilt = rng.uniform(0.2, 0.6), rng.uniform(-0.3, 0.3)
        self.bands = rng.uniform(0.05, 0.9, (4, 2)) * (1, 0.03)
        self.sign, self.tried, self.out = float(rng.choice([-1.0, 1.0])), list[float](), list[float]()

    def __call__(self, impact: int, delay: Floats, jump: Floats) -> NDArray[np.bool_]:
        size = self.sign * jump
        assert impact == 1
        assert (size >= 0).all()
        assert ((delay >= 0) & (delay < 0.8)).all()
        edge = self.edge + self.tilt * delay
        out = size >= edge
        for low, width in self.bands:
            out |= (size >= low * edge) & (size <= (low + width) * edge)
        self.tried += size.tolist()
        self.out += size[out].tolist()
        return np.asarray(out)


@pytest.mark.parametrize("effort", [QUICK, SCAN])
@pytest.mark.parametrize("delay", [0.0, 0.3])
def test_the_shock_leads_out_and_no_smaller_one_that_was_tried_does(effort: Effort, delay: float) -> None:
    for seed in range(40):
        bands = Bands(seed)
        first = Shock(1, delay, bands.sign * 0.95)
        least = descended(bands, first, 0.2, 0.8, effort)
        smallest = min([*bands.out, 0.95])
        assert abs(least.jump) == pytest.approx(smallest, rel=1e-12)
        assert (least.impact, np.sign(least.jump)) == (1, bands.sign)
        again = Bands(seed)
        assert again(1, np.array([least.delay]), np.array([least.jump])).all()
        assert (delay == 0) <= (least.delay == 0)  # just after an impact it stays there
        assert len(bands.tried) < 500 * effort.zoom


@pytest.mark.parametrize("delay", [0.0, 0.3])
def test_an_edge_far_below_the_first_shock_is_found_to_its_last_digit(delay: float) -> None:
    """All of a step lead out at first, so that steps grow again."""

    def leads_out(impact: int, at: Floats, jump: Floats) -> NDArray[np.bool_]:
        return np.asarray(jump >= 0.0123)

    least = descended(leads_out, Shock(0, delay, 0.9), 1e-3, 0.8, SCAN)
    assert 0.0123 <= least.jump < 0.0123 * (1 + 1e-6)
