"""A figure that is laid out and drawn once: its pixels are those that Matplotlib would draw by itself."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from vireport.figures.layout import blank, finished
from vireport.figures.style import Color, Picture, style
from vireport.figures.vector import png


def picture(*, pixels: bool = False) -> Picture:
    """Two panels with lines, markers, a clipped curve, a filled area, texts and mathematics, or an image in one."""
    x = np.linspace(0.0, 1.0, 50)
    with style():
        figure, panels = blank(2, sharex=True)
        for k, axes in enumerate(panels[:, 0]):
            axes.plot(x, 10.0**k * x, color=Color.BLUE, marker="D", markevery=7, linewidth=2.0)
            axes.plot(x, 1e3 * x, color=Color.VERMILION, linestyle="--")
            axes.axvspan(0.2, 0.4, color=Color.FILL_A, alpha=0.5)
            axes.set(xlim=(-0.1, 1.1), ylim=(-0.5, 1.2 * 10.0**k), ylabel="speed |Ż| [m/s]")
            axes.text(0.5, 0.5 * 10.0**k, r"$\lambda^2$ and a word", rotation=30)
        if pixels:
            panels[0, 0].imshow([[0.0, 1.0]], extent=(0.5, 0.8, 0.2, 0.6), aspect="auto")
        panels[-1, 0].set_xlabel("length [m]")
        finished(
            figure, 4.0, [("A line over it", Color.BLACK)], [[("speed", {"color": Color.BLUE})]], aligned=panels[:, 0]
        )
    return Picture("figure-x", "Title", "Caption.", "Text.", figure)


def grey(png: bytes) -> np.ndarray:
    return np.asarray(Image.open(BytesIO(png)).convert("L"), float)


@pytest.mark.parametrize("pixels", [False, True])
def test_pixels_are_those_that_matplotlib_draws(pixels: bool) -> None:
    shown = picture(pixels=pixels)
    with style():
        theirs = grey(png(shown.figure))
    ours = grey(shown.png)
    assert ours.shape == theirs.shape
    assert theirs.std() > 20
    # Texts stand where they were laid out, to a fraction of a pixel.
    apart = np.abs(ours - theirs)
    assert apart.mean() < 1.5
    rows, columns = (side // 8 * 8 for side in apart.shape)
    blocks = (ours - theirs)[:rows, :columns].reshape(rows // 8, 8, columns // 8, 8).mean(axis=(1, 3))
    assert np.abs(blocks).max() < 25


def test_labels_of_axes_are_in_one_line_beside_their_ticks() -> None:
    """Also where the ticks of one panel are wider than those of another."""
    figure = picture().figure
    figure.canvas.draw()
    top, bottom = (axes.yaxis.label.get_window_extent() for axes in figure.axes)
    assert top.x1 == pytest.approx(bottom.x1, abs=0.5)
    ticks = [text.get_window_extent().x0 for axes in figure.axes for text in axes.get_yticklabels() if text.get_text()]
    assert 2 < min(ticks) - top.x1 < 15
    assert min(top.x0, bottom.x0) > 0


def test_the_label_of_a_colour_bar_is_beside_its_ticks() -> None:
    with style():
        figure, panels = blank(1)
        image = panels[0, 0].imshow([[0.0, 30.0], [20.0, 40.0]], aspect="auto")
        bar = figure.colorbar(image, ax=panels[0, 0], label="margin [%]")
        finished(figure, 3.0, [], [])
    figure.canvas.draw()
    label = bar.ax.yaxis.label.get_window_extent()
    ticks = [text.get_window_extent().x1 for text in bar.ax.get_yticklabels() if text.get_text()]
    assert 2 < label.x0 - max(ticks) < 15
