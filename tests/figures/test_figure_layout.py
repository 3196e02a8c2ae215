"""Ticks and labels of the figures: round numbers that fit, and labels that stay clear of what is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from figure_cases import boxes_of
from matplotlib.figure import Figure

from vireport.figures.labels import Label, write_labels
from vireport.figures.layout import Entry, blank, finished, folded, round_ticks, tick_labels, widened
from vireport.figures.style import style


def test_round_ticks() -> None:
    assert round_ticks(0.26, 0.75, 6.0) == ([0.3, 0.4, 0.5, 0.6, 0.7], ["0.3", "0.4", "0.5", "0.6", "0.7"])
    assert round_ticks(-0.07, 1.0, 6.0)[1] == ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]
    assert len(round_ticks(0.26, 0.75, 1.0)[0]) < 5
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
    texts = [text for legend in figure.legends for text in legend.get_texts()]
    assert sorted(text.get_text() for text in texts) == sorted(name for name, _ in entries)
    places = sorted((-text.get_window_extent().y0, text.get_window_extent().x0, text.get_text()) for text in texts)
    assert [name for _, _, name in places] == [name for name, _ in entries]
    rows = [round(y) for y, _, _ in places]
    assert [rows.count(y) for y in dict.fromkeys(rows)] == lines
    assert max(text.get_window_extent().x1 for text in texts) <= 1.01 * figure.bbox.x1  # pixels round each letter
