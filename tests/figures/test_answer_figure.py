"""The figure of a report's first page names its curves, also where no motion is stable, and has two heights."""

from __future__ import annotations

import re

import pytest
from figure_cases import ROOT, assert_readable, texts_of

from vireport.figures.answer import HEIGHT, HIGHER, picture
from vireport.figures.style import Picture
from vireport.scenario.loading import load
from vireport.study.plan import Task
from vireport.study.study import analyse


def drawn(*overrides: str) -> Picture:
    shown = picture(analyse(load(ROOT / "examples" / "inclined.yaml", overrides), (Task.PDF,)))
    assert shown is not None
    return shown


@pytest.mark.parametrize("overrides", [(), ("sweep.from=0.59", "sweep.to=0.62", "device.length_m=0.6")])
def test_both_curves_are_named_where_they_end(overrides: tuple[str, ...]) -> None:
    figure = drawn(*overrides).figure
    assert {"bottom", "top"} <= set(texts_of(figure))
    assert_readable(figure)


def test_a_pdf_has_it_higher_and_the_figure_is_as_it_was_afterwards() -> None:
    shown = drawn()

    def size(svg: bytes) -> tuple[float, float]:
        width, height = re.search(rb'width="([\d.]+)pt" height="([\d.]+)pt"', svg).groups()
        return float(width) / 72, float(height) / 72

    before = shown.svg
    width, height = size(before)
    assert size(shown.printed) == pytest.approx((width, height + HIGHER))
    assert height == pytest.approx(HEIGHT, abs=0.1)
    # The panel takes what is more, what is around it stays as it is.
    again = drawn()
    assert again.printed == shown.printed
    assert again.svg == before
    assert again.png == shown.png
