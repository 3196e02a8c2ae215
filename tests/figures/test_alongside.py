"""Names in a plane of curves: they lie on nothing, and along what they name."""

from __future__ import annotations

from math import degrees

import numpy as np
import pytest
from matplotlib.axes import Axes

from vireport.figures.alongside import Paper, around, beside, covered
from vireport.figures.layout import blank
from vireport.figures.style import sheet, style

SIZE = (4.0, 3.0)


@pytest.fixture
def paper() -> Paper:
    """A panel of 4 by 3 inches, from 0 to 4 and from 0 to 30."""
    with style():
        axes: Axes = blank(1)[1][0, 0]
        axes.set(xlim=(0.0, 4.0), ylim=(0.0, 30.0))
        return Paper(axes, SIZE)


def only(paper: Paper) -> tuple[str, float, float, float]:
    """The one name that is written: where [in], and at which angle."""
    (text,) = paper.axes.texts
    x, y = np.array(text.get_position()) * SIZE
    return text.get_text(), x, y, text.get_rotation()


@pytest.mark.parametrize(("ends", "angle"), [((5.0, 25.0), 26.57), ((25.0, 5.0), -26.57), ((15.0, 15.0), 0.0)])
def test_a_name_along_a_curve_has_its_slope_and_stands_beside_its_middle(paper, ends, angle) -> None:
    line = np.array([[0.0, ends[0]], [4.0, ends[1]]])
    paper.draw(line)
    cloud = np.concatenate(paper.solid)
    assert paper.write("fold of BT", paper.along(line, "fold of BT"))
    text, x, y, turned = only(paper)
    assert (text, turned % 360) == ("fold of BT", pytest.approx(angle % 360, abs=0.01))
    off = np.hypot(*(cloud - (x, y)).T).min()
    assert sheet().small / 144 < off < 0.25
    assert abs(x - 2) < 0.25
    assert not covered((x, y, np.radians(turned)), np.array([0.3, sheet().small / 144]), cloud)


def test_a_name_goes_where_no_other_curve_is_and_has_no_place_where_they_are_all_over(paper) -> None:
    line = np.array([[0.0, 15.0], [4.0, 15.0]])
    paper.draw(line)
    paper.draw([[2.0, 0.0], [2.0, 30.0]])
    assert paper.write("period doubling", paper.along(line, "period doubling"))
    assert abs(only(paper)[1] - 2) > 0.5
    for x in np.arange(0.0, 4.0, 0.3):
        paper.draw([[x, 0.0], [x, 30.0]])
    assert not paper.write("fold of BBT", paper.along(line, "fold of BBT"))
    assert not paper.write(
        "too long a name for a short curve", paper.along([[1.0, 5.0], [1.2, 5.0]], "too long a name")
    )


def test_a_name_crosses_thin_lines_only_where_there_is_no_other_place(paper) -> None:
    line = np.array([[0.0, 15.0], [4.0, 15.0]])
    paper.draw(line)
    for x in (1.8, 2.0, 2.2):
        paper.draw([[x, 0.0], [x, 30.0]], thin=True)
    assert paper.write("fold of BT", paper.along(line, "fold of BT"))
    assert abs(only(paper)[1] - 2) > 0.5


def test_a_design_point_has_its_name_and_each_margin_beside_its_bar(paper) -> None:
    assert paper.mark((2.0, 20.0), [(3.0, 20.0), (2.0, 8.0)], ["+1 m", "−12°"], "design point")
    places = {text.get_text(): np.array(text.get_position()) * SIZE for text in paper.axes.texts}
    assert places["+1 m"] == pytest.approx((2.5, 2.0), abs=0.25)
    assert places["+1 m"][1] > 2.0
    assert places["−12°"][1] == pytest.approx(1.4, abs=0.1)
    assert places["−12°"][0] < 2.0
    assert np.hypot(*(places["design point"] - (2.0, 2.0))) < 0.8


def test_the_parts_of_an_area_have_its_name_where_it_fits(paper) -> None:
    area = np.zeros((100, 100), dtype=bool)
    area[:40], area[60:], area[:5, :5] = True, True, False
    assert paper.name(area, "BT")
    assert sorted(round(text.get_position()[0], 1) for text in paper.axes.texts) == pytest.approx([0.2, 0.8], abs=0.11)
    assert not paper.name(area[:, :3], "a long name for narrow cells")
    paper.axes.texts[0].remove()
    assert paper.name(area, "BBT", every=False)
    assert [text.get_text() for text in paper.axes.texts].count("BBT") == 1


def test_places_are_the_nearest_first() -> None:
    at = np.array([2.0, 2.0])
    (x, y, _), *_ = beside(at, np.array([3.0, 2.0]), "+1 m")
    assert x == pytest.approx(2.5)
    assert y > 2.0
    apart = [np.hypot(x - 2.0, y - 2.0) for x, y, _ in around(at, "a")]
    assert apart[0] < apart[-1]
    assert degrees(next(iter(around(at, "a")))[2]) == 0
