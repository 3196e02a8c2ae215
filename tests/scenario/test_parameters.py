"""How an input is printed: each form has one place."""

from __future__ import annotations

import pytest

from vireport.scenario.parameters import DesignInput, Named
from vireport.text.formatting import ROUGHLY

LENGTH, INCLINATION, RESTITUTION = DesignInput.LENGTH, DesignInput.INCLINATION, DesignInput.RESTITUTION


@pytest.mark.parametrize(
    ("varied", "label", "head"),
    [
        (LENGTH, "length s [m]", "length [m]"),
        (INCLINATION, "inclination β [°]", "inclination [°]"),
        (RESTITUTION, "restitution r [–]", "restitution"),
    ],
)
def test_an_axis_has_symbol_and_unit_and_a_column_the_unit(varied: Named, label: str, head: str) -> None:
    assert (varied.label, varied.head) == (label, head)


def test_a_place_is_stated_or_of_a_model() -> None:
    assert LENGTH.place(0.123456) == "s = 0.123456 m"
    assert LENGTH.place(0.123456, ROUGHLY) == "s = 0.12 m"
    assert INCLINATION.place(0.0) == "β = 0°"


@pytest.mark.parametrize(("distance", "text"), [(0.0123, "+0.012 m"), (-0.0123, "−0.012 m"), (0.0, "0 m")])
def test_a_distance_has_its_sign(distance: float, text: str) -> None:
    assert LENGTH.signed(distance, ROUGHLY) == text
