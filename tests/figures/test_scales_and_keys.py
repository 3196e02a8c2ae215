"""The axes and legends that are drawn as one artist each are those that Matplotlib draws."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vireport.figures import style
from vireport.figures.keys import Key
from vireport.figures.scales import Scale, align_names, put_ticks, scaled

NEAR = 0.02
"""By how much a place may differ [px]: of what lies on the edge of a pixel."""


def panels(own: bool, logarithmic: bool) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(4, 4), dpi=150)
    FigureCanvasAgg(figure)
    axes_of = list(figure.subplots(2, 1, sharex="col"))
    if own:
        for axes in axes_of:
            scaled(axes)
    upper, lower = axes_of
    upper.set(xlim=(0.1, 1.3), ylim=(0.0, 3e-7), ylabel="a power of ten")
    lower.set(ylim=(-1200.0, 40.0), ylabel="wide labels", xlabel="below")
    if logarithmic:
        lower.set(yscale="log", ylim=(8e-6, 2.0))
    put_ticks(lower.xaxis, [0.2, 0.8, 1.2], ["0.2", "0.8", "1.2"])
    top = upper.secondary_xaxis("top")
    put_ticks(top.xaxis, [0.3, 0.9], ["0.3", "0.9"])
    top.set_xlabel("above")
    if own:
        Scale(top.xaxis)
        align_names(axes_of)
    else:
        figure.align_ylabels(axes_of)
    return figure, [upper, lower, top]


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_scale_is_what_matplotlib_draws(logarithmic: bool) -> None:
    with style():  # by which Matplotlib chooses how many ticks there are
        theirs, own = (panels(own, logarithmic) for own in (False, True))
        for figure, _ in (theirs, own):
            figure.tight_layout()
            figure.canvas.draw()
        compare(theirs, own)


def compare(theirs: tuple[Figure, list[Axes]], own: tuple[Figure, list[Axes]]) -> None:
    for side in ("left", "right", "bottom", "top", "hspace"):
        assert getattr(own[0].subplotpars, side) == pytest.approx(getattr(theirs[0].subplotpars, side), abs=1e-4)
    renderer: Any = own[0].canvas.get_renderer()
    checked = 0
    for axes, their in zip(own[1], theirs[1], strict=True):
        for scale in (artist for artist in axes.get_children() if isinstance(artist, Scale)):
            axis: Any = their.xaxis if scale.along == 0 else their.yaxis
            for name in ("label", "offsetText"):
                assert getattr(scale.axis, name).get_text() == getattr(axis, name).get_text()
                if not getattr(axis, name).get_text():
                    continue
                places = [getattr(of, name).get_window_extent(renderer).get_points() for of in (scale.axis, axis)]
                assert np.abs(places[0] - places[1]).max() < NEAR
            low, high = sorted(axis.get_view_interval())
            shown = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
            labels = [t.label2 if axes is own[1][2] else t.label1 for t in shown]
            labels = [label for label in labels if label.get_visible() and label.get_text()]
            boxes = scale.boxes(renderer)
            assert [text for text, _ in boxes] == [label.get_text() for label in labels]
            for (_, box), label in zip(boxes, labels, strict=True):
                assert np.abs(box.get_points() - label.get_window_extent(renderer).get_points()).max() < 1.0
                checked += 1
    assert checked >= 10


ENTRIES = [
    ("a line", {"color": "#0072B2", "linewidth": 2.0}),
    ("another, longer", {"color": "#D55E00", "linestyle": "--"}),
    ("a mark", {"linestyle": "none", "marker": "o", "color": "#000000"}),
    ("in two\nlines", {"color": "#767676"}),
    ("the last", {"color": "#009E73"}),
]


@pytest.mark.parametrize(("count", "columns"), [(3, 3), (4, 2), (5, 3), (1, 1)])
def test_a_key_is_what_matplotlib_draws(count: int, columns: int) -> None:
    entries = ENTRIES[:count]
    with style():
        figure = Figure(figsize=(6, 3), dpi=150)
        canvas = FigureCanvasAgg(figure)
        ordered = [entry for k in range(columns) for entry in entries[k::columns]]
        lines, names = [Line2D([], [], **look) for _, look in ordered], [name for name, _ in ordered]
        theirs = figure.legend(lines, names, ncols=columns, loc="upper left", bbox_to_anchor=(0.1, 0.9))
        canvas.draw()
        width = theirs.get_window_extent().width * 72 / 150
        key = Key(figure, entries, 8.0, width + 1.0)
        key.place(0.1, 0.9)
        canvas.draw()
    box = theirs.get_window_extent()
    assert np.abs(key.get_window_extent().get_points() - box.get_points()).max() < NEAR
    known = {text.get_text(): text for text in theirs.get_texts()}
    for text in key.get_texts():
        own, their = (each.get_window_extent().get_points() for each in (text, known[text.get_text()]))
        assert np.abs(own - their).max() < NEAR
    handles = dict(zip(names, theirs.legend_handles, strict=True))
    for (name, _), line in zip(entries, key.legend_handles, strict=True):
        their: Any = handles[name]
        drawn = [each.get_transform().transform(each.get_xydata()) for each in (line, their)]
        assert np.abs(drawn[0] - drawn[1]).max() < NEAR
