"""Layout of the figures: ticks are round and fit, panels are clear of their neighbours, names lie on nothing."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees

import numpy as np
import pytest
from figure_cases import assert_readable, boxes_of
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vireport.figures.alongside import Paper, around, covered, near_bar
from vireport.figures.labels import Label, write_labels
from vireport.figures.layout import (
    Entry,
    blank,
    finished,
    folded,
    letter_panels,
    round_ticks,
    tick_labels,
    title,
    widened,
    write_along_top,
)
from vireport.figures.style import sheet, style


def test_round_ticks() -> None:
    assert round_ticks(0.26, 0.75, 6.0) == ([0.3, 0.4, 0.5, 0.6, 0.7], ["0.3", "0.4", "0.5", "0.6", "0.7"])
    assert round_ticks(-0.07, 1.0, 6.0)[1] == ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]
    assert len(round_ticks(0.26, 0.75, 1.0)[0]) < 5
    # Three ticks have no room, and the middle one alone would not tell how long the axis is.
    assert round_ticks(-0.166, 0.166, 1.21) == ([-0.1, 0.1], ["−0.1", "0.1"])
    values, texts = round_ticks(0.4604176, 0.46042424, 4.0)
    assert len(set(texts)) == len(texts) >= 3
    assert [float(text) for text in texts] == pytest.approx(values, rel=1e-12)


def test_tick_labels_have_as_many_digits_as_tell_them_apart() -> None:
    assert tick_labels([0.0, 0.5, 1.0]) == ["0", "0.5", "1.0"]
    assert tick_labels([-0.25, 0.0]) == ["−0.25", "0"]
    assert tick_labels([1e-7, 2e-7]) == ["1 × 10⁻⁷", "2 × 10⁻⁷"]
    assert tick_labels([3e8, 3.5e8]) == ["3 × 10⁸", "3.5 × 10⁸"]


def test_uneven_ticks_are_round_and_apart() -> None:
    def place(value: np.ndarray) -> np.ndarray:
        return (1.494 / value - 0.249) / (0.498 - 0.249)

    assert round_ticks(3.0, 6.0, 6.0, place)[0] == [3, 3.5, 4, 4.5, 5, 5.5, 6]
    values, _ = round_ticks(0.5, 60.0, 6.0, lambda value: (1 / value - 1 / 60) / (2 - 1 / 60))
    assert {0.5, 1, 2, 5} <= set(values)


def test_a_range_that_is_next_to_nothing_is_widened() -> None:
    low, high = widened(0.5, 0.5 + 1e-15, 0.1)
    assert 1e-7 < high - low < 1e-5
    assert widened(0.0, 0.0, 0.0) == (-0.5, 0.5)
    assert widened(1.0, 2.0, 0.1) == (0.9, 2.1)


def test_labels_keep_clear_of_curves_markers_and_each_other() -> None:
    x = np.linspace(0, 1, 200)
    with style():
        figure, ((axes,),) = blank(1)
        axes.plot(x, x**2, zorder=2.5)
        axes.plot([0.5, 0.52], [0.25, 0.52**2], "o", zorder=4)
        finished(figure, 3.0, [], [])
        points = [Label(name, np.array([at]), np.array([at**2])) for name, at in (("A1", 0.5), ("A2", 0.52))]
        write_labels(axes, [*points, Label("A3", np.array([9.0]), np.array([9.0]))])
    assert [text.get_text() for text in axes.texts] == ["A1", "A2"]
    assert_clear(figure)


def test_points_that_coincide_share_a_label_and_a_text_of_the_panel_stays_legible() -> None:
    with style():
        figure, ((axes,),) = blank(1)
        finished(figure, 3.0, [], [])
        axes.text(0.515, 0.5, "BT", transform=axes.transAxes, va="center")
        names = ("B1", 0.5), ("A1", 0.5 + 1e-4), ("C1", 0.3)
        write_labels(axes, [Label(name, np.array([x]), np.array([0.5])) for name, x in names])
        assert [text.get_text() for text in axes.texts] == ["BT", "B1, A1", "C1"]
        word, label = (text.get_window_extent() for text in axes.texts[:2])
    assert not word.overlaps(label)


def assert_clear(figure: Figure) -> None:
    boxes = dict(boxes_of(figure))
    assert not boxes["A1"].overlaps(boxes["A2"])
    (axes,) = figure.axes
    for line in axes.lines:
        pixels = line.get_transform().transform(line.get_xydata())
        assert not any(boxes[name].count_contains(pixels) for name in ("A1", "A2"))


def test_a_line_parts_no_number_from_its_unit_nor_an_equation_from_its_sign() -> None:
    text = "impact on the bottom: area 8.16 mJ, d = 0.281, reached at 4.3 % of all cells"
    for letters in range(12, 40):
        lines = folded(text, letters).splitlines()
        assert " ".join(lines) == text
        assert max(map(len, lines)) <= letters
        assert not any(line.endswith(("8.16", "4.3", " d", "=")) for line in lines), lines


@pytest.mark.parametrize(("names", "lines"), [([10, 10, 10], [3]), ([16, 16, 16, 16, 16, 4, 4, 4, 12], [4, 5])])
def test_a_legend_takes_as_few_lines_as_its_entries_fill(names: list[int], lines: list[int]) -> None:
    """Long entries make no columns for short ones, which would then take a line more."""
    entries: list[Entry] = [("n" * count, {"color": "black"}) for count in names]
    with style():
        figure = finished(blank(1)[0], 2.0, [], [entries])
    figure.canvas.draw()
    texts = figure.texts
    assert [line.get_label() for line in figure.artists] == [name for name, _ in entries]
    places = sorted((-text.get_window_extent().y0, text.get_window_extent().x0, text.get_text()) for text in texts)
    assert [name for _, _, name in places] == [name for name, _ in entries]
    rows = [round(y) for y, _, _ in places]
    assert [rows.count(y) for y in dict.fromkeys(rows)] == lines
    assert max(text.get_window_extent().x1 for text in texts) <= 1.01 * figure.bbox.x1  # pixels round each letter


Panels = np.ndarray


def large_numbers(panels: Panels) -> None:
    """Ticks so large that a factor of all stands over the panel, and ticks at the very ends of the axes."""
    for axes in panels.ravel():
        axes.plot([0.0, 1.0], [0.0, 4e9])
        axes.set(xlim=(0, 1), xticks=[0, 1], xlabel="share", ylabel="speed [m/s]")
        axes.set_xticklabels(["a long beginning", "a long end"])


def titles(panels: Panels) -> None:
    """Titles of two lines, and ticks of very different widths."""
    for k, axes in enumerate(panels.ravel()):
        axes.set(ylim=(0, 10.0**k), ylabel="|Ż|", xlabel="t")
        axes.set_yticks([0, 10.0**k], ["0", f"{10.0**k:.{k}f}"])
        title(axes, f"({k}) a title that takes two lines in a narrow panel, at least", panels.shape[1])


def axis_on_top(panels: Panels) -> None:
    """A second axis along the top, with a title over it."""
    for axes in panels[0]:
        write_along_top(axes, [0.0, 0.5, 1.0], ["0", "half", "all"], "remark\nlength s [m]")
        axes.set_title("a scenario", weight="bold")
    for axes in panels.ravel():
        axes.set(xlim=(-0.1, 1.1), ylim=(-0.1, 1.1))
    letter_panels(panels[:, 0], 0)


def beyond_the_frame(panels: Panels) -> None:
    """Names at the ends of curves, outside the frame."""
    for axes in panels.ravel():
        axes.annotate("bottom of it", (1.0, 0.5), xytext=(5, 0), textcoords="offset points", annotation_clip=False)


@pytest.mark.parametrize("fill", [large_numbers, titles, axis_on_top, beyond_the_frame])
@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (2, 2)])
def test_what_is_around_panels_is_clear(fill: Callable[[Panels], None], rows: int, columns: int) -> None:
    with style():
        figure, panels = blank(rows, columns)
        fill(panels)
        finished(figure, 2.2 * rows, [], [])
    assert_readable(figure)
    # Nor is there more room than that takes: something is near each edge of the figure.
    width, height = figure.canvas.get_width_height()
    boxes = np.array([box.extents for _, box in boxes_of(figure)])
    frames = np.array([axes.get_window_extent().extents for axes in figure.axes])
    drawn = np.concatenate([boxes, frames])
    near = 0.15 * figure.dpi
    assert drawn[:, 0].min() < near
    assert drawn[:, 1].min() < near
    assert drawn[:, 2].max() > width - near
    assert drawn[:, 3].max() > height - near


def test_a_bar_of_colours_is_beside_its_panel_and_in_the_figure() -> None:
    with style():
        figure, panels = blank(1)
        axes: Axes = panels[0, 0]
        image = axes.imshow([[0.0, 300000.0], [200000.0, 400000.0]], aspect="auto")
        bar = figure.colorbar(image, ax=axes, label="voltage [V]")
        finished(figure, 3.0, [], [])
    assert_readable(figure)
    figure.canvas.draw()
    label, frame, panel = (x.get_window_extent() for x in (bar.ax.yaxis.label, bar.ax, axes))
    assert panel.x1 < frame.x0 < frame.x1 < label.x0 < label.x1 <= figure.bbox.x1
    assert label.x1 > figure.bbox.x1 - 0.25 * figure.dpi


def test_panels_above_one_another_have_the_same_sides_whatever_their_ticks() -> None:
    with style():
        figure, panels = blank(2, sharex="col")
        panels[0, 0].set(ylim=(0, 1), yticks=[0, 1], ylabel="share")
        panels[1, 0].set(ylim=(0, 1e5), yticks=[0, 1e5], ylabel="voltage [V]", xlabel="t")
        finished(figure, 4.0, [], [], aligned=panels[:, 0])
    figure.canvas.draw()
    upper, lower = (axes.get_window_extent() for axes in panels[:, 0])
    assert (upper.x0, upper.x1) == (lower.x0, lower.x1)
    assert upper.height == pytest.approx(lower.height)
    ends = [axes.yaxis.label.get_window_extent().x1 for axes in panels[:, 0]]
    assert ends[0] == pytest.approx(ends[1], abs=0.5)


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
    assert paper.write("fold of BT", paper.near_curve(line, "fold of BT"))
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
    assert paper.write("period doubling", paper.near_curve(line, "period doubling"))
    assert abs(only(paper)[1] - 2) > 0.5
    for x in np.arange(0.0, 4.0, 0.3):
        paper.draw([[x, 0.0], [x, 30.0]])
    assert not paper.write("fold of BBT", paper.near_curve(line, "fold of BBT"))
    assert not paper.write(
        "too long a name for a short curve", paper.near_curve([[1.0, 5.0], [1.2, 5.0]], "too long a name")
    )


def test_a_name_crosses_thin_lines_only_where_there_is_no_other_place(paper) -> None:
    line = np.array([[0.0, 15.0], [4.0, 15.0]])
    paper.draw(line)
    for x in (1.8, 2.0, 2.2):
        paper.draw([[x, 0.0], [x, 30.0]], thin=True)
    assert paper.write("fold of BT", paper.near_curve(line, "fold of BT"))
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
    (x, y, _), *_ = near_bar(at, np.array([3.0, 2.0]), "+1 m")
    assert x == pytest.approx(2.5)
    assert y > 2.0
    apart = [np.hypot(x - 2.0, y - 2.0) for x, y, _ in around(at, "a")]
    assert apart[0] < apart[-1]
    assert degrees(next(iter(around(at, "a")))[2]) == 0
