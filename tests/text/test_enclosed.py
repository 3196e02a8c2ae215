"""Bounds as text: a middle and what it may be off by."""

from __future__ import annotations

from decimal import Decimal

import numpy as np

from vireport.text.enclosed import plus_minus


def test_plus_minus_holds_its_bounds() -> None:
    rng = np.random.default_rng(8)
    for low, width in zip(rng.integers(-(10**9), 10**9, 50), rng.integers(1, 10**4, 50), strict=True):
        pair = (f"{Decimal(int(low)).scaleb(-12)}", f"{Decimal(int(low + width)).scaleb(-12)}")
        middle, off = map(Decimal, plus_minus(pair).split(" ± "))
        assert middle - off <= Decimal(pair[0])
        assert middle + off >= Decimal(pair[1])
