"""Panels are placed so that what is around them is in the figure and clear of their neighbours, and is not far off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from figure_cases import assert_readable, boxes_of
from matplotlib.axes import Axes

from vireport.figures.layout import blank, finished, letter_panels, title
from vireport.figures.style import style

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
        top = axes.secondary_xaxis("top")
        top.set_xticks([0.0, 0.5, 1.0], ["0", "half", "all"])
        top.set_xlabel("remark\nlength s [m]")
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
