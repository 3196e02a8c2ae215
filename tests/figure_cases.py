"""What the tests of the figures share: easy and extreme sweeps, the paper's simulated motions, readers of figures."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from vireport.figures.pictures import pictures
from vireport.figures.style import Picture
from vireport.figures.sweeps import figure_2, figure_4, figure_7
from vireport.physics.device import Device
from vireport.scenario.loading import load
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM, Impact
from vireport.simulation.trajectories import Portrait, portrait
from vireport.study.study import Study, analyse

ROOT = Path(__file__).resolve().parent.parent
FIGURES = {"figure-2": figure_2, "figure-4": figure_4, "figure-7": figure_7}

SWEPT = ("device.length_m=",)

# name: (example, overrides)
CASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "horizontal": ("horizontal", ()),
    "inclined": ("inclined", ()),
    "inclined-forcing": ("inclined-forcing", ()),
    "wide": ("inclined", ("sweep.from=0.01", "sweep.to=3")),
    "horizontal-wide": ("horizontal", ("sweep.from=0.01", "sweep.to=3")),
    "forcing-wide": ("inclined-forcing", ("inclination_deg=0", "sweep.from=0.5", "sweep.to=60")),
    "frequency": ("inclined", ("sweep.parameter=frequency_hz", "sweep.from=1.5", "sweep.to=3")),
    "inclination": ("inclined", ("sweep.parameter=inclination_deg", "sweep.from=0", "sweep.to=90")),
    "empty": ("inclined", ("inclination_deg=80", "sweep.from=0.02", "sweep.to=0.1", "device.length_m=0.05")),
    "narrow": ("inclined", ("sweep.from=0.6934", "sweep.to=0.69341")),
    "lively": ("inclined", ("device.restitution=0.9", "inclination_deg=10", "sweep.from=0.05", "sweep.to=2")),
    "slow": ("inclined", ("period_ratio=3", "inclination_deg=5", "sweep.from=0.26", "sweep.to=6")),
    "small": ("horizontal", (*SWEPT, "sweep.from=2.6e-7", "sweep.to=7.5e-7", "excitation.amplitude_n=3e-6")),
    "large": ("horizontal", (*SWEPT, "sweep.from=2.6e8", "sweep.to=7.5e8", "excitation.amplitude_n=3e9")),
    "next": ("inclined", ("sweep.from=0.6934", "sweep.to=0.69340001")),
}  # fmt: skip

QUICK = ("horizontal", "inclined", "inclined-forcing")


def cases(*names: str) -> list[Any]:
    """Sweeps by their names, those marked as slow that few quick tests need."""
    return [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in names]


# The paper's motions; name: (inclination, force, d, word, period)
PAPER = {
    "horizontal": (0.0, 3.0, 0.3688, "BT", 1),
    "inclined": (45.0, 3.0, 0.4604, "BT", 1),
    "forced": (45.0, 5.31, 0.28135593, "BT", 1),
    "doubled": (45.0, 5.87, 0.25451448, "BTBT", 2),
}

# Motions that are not the paper's: irregular, resting, and sticking to a membrane.
OTHERS = {"chaotic": (10.0, 3.0, 0.1), "rest": (90.0, 1.2, 0.3), "sticking": (45.0, 3.0, 0.1)}

M, G, FREQUENCY = 0.1245, 9.8, 2.0

DESCENDER = 0.2
"""Share of the size of type that the box of a text has below its foot, which is empty under capitals and digits."""


@cache
def study_of(name: str) -> Study:
    example, overrides = CASES[name]
    return analyse(load(ROOT / "examples" / f"{example}.yaml", overrides))


@cache
def figure_of(name: str, figure: str) -> Figure:
    return FIGURES[figure](study_of(name))


@cache
def pictures_of(name: str) -> tuple[Picture, ...]:
    return pictures(study_of(name))


@cache
def simulated_study() -> Study:
    return analyse(load(ROOT / "examples" / "simulated.yaml", ("simulation.samples=31",)))


@cache
def motion(name: str) -> Portrait:
    angle, force, d = (PAPER | OTHERS)[name][:3]
    device = Device(
        capsule_mass_kg=M, restitution=0.5, gravity_m_s2=G, length_m=None, amplitude_n=force,
        frequency_hz=FREQUENCY, inclination_deg=angle, period_ratio=1,
    )  # fmt: skip
    starts = [Impact(BOTTOM, 0.7, 0.4)]
    length = d * force / (4 * M * FREQUENCY**2)
    groups = device.groups(Parameter.LENGTH, length).as_floats()
    return portrait(groups, starts, f"s = {Parameter.LENGTH.show(length)}")


def curves(axes: Axes) -> list[Line2D]:
    """The lines of a panel that show motions: neither markers, nor guides, bounds or leaders."""
    return [line for line in axes.lines if 2.1 < line.get_zorder() < 3 and line.get_linestyle() != "None"]


def vertices(lines: list[Line2D]) -> set[tuple[float, float]]:
    return {(float(x), float(y)) for line in lines for x, y in zip(*line.get_data(), strict=True) if x == x}


def rows(study: Study, admissible: bool) -> list[tuple[int, int]]:
    """Branches and rows inside stretches, without the ends that two stretches share."""
    return [
        (branch.number - 1, row)
        for branch in study.solution.branches
        for part in branch.family.segments
        if part.admissible == admissible
        for row in range(part.first + 1, part.last)
    ]


def labels(axes: Axes) -> list[str]:
    """The labels of critical points on a panel, those that are written as one by themselves."""
    texts = [text.get_text() for text in axes.texts]
    return [label for text in texts if text[:1] in "ABCG" for label in text.split(", ")]


def texts_of(figure: Figure) -> list[str]:
    """Every text of a figure that is shown."""
    return [text for text, _ in boxes_of(figure)]


def boxes_of(figure: Figure) -> list[tuple[str, Bbox]]:
    """Every text of a figure that is drawn, with the box of its ink [px]."""
    drawn: list[Text] = []

    def record(text: Text, renderer: RendererAgg) -> None:
        if text.get_visible() and text.get_text().strip():
            drawn.append(text)
        draw(text, renderer)

    draw = Text.draw
    with mock.patch.object(Text, "draw", record):
        figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    return [(text.get_text(), _ink(text, renderer)) for text in drawn]


def _ink(text: Text, renderer: RendererAgg) -> Bbox:
    box, below = text.get_window_extent(renderer), DESCENDER * text.get_size() / 72 * text.figure.dpi
    if text.get_rotation() == 90:
        return Bbox.from_extents(box.x0, box.y0, box.x1 - below, box.y1)
    return Bbox.from_extents(box.x0, box.y0 + below, box.x1, box.y1)


def of_look(axes: Axes, look: dict) -> list[np.ndarray]:
    """Points of the lines of a panel that have a look."""
    lines = [line for line in axes.lines if line.get_color() == look["color"] and line.get_zorder() == look["zorder"]]
    lines = [line for line in lines if line.get_marker() == look.get("marker", "None")]
    if "linewidth" in look:
        lines = [line for line in lines if line.get_linewidth() == look["linewidth"]]
    return [np.column_stack(line.get_data()) for line in lines]


def _slanted(figure: Figure) -> set[str]:
    return {text.get_text() for text in figure.findobj(Text) if text.get_rotation() % 90}


def assert_readable(figure: Figure) -> None:
    """No text of a figure leaves it, and none lies on another; boxes of slanted ones are larger than these."""
    boxes = [(text, box) for text, box in boxes_of(figure) if text not in _slanted(figure)]
    width, height = figure.canvas.get_width_height()
    for i, (text, box) in enumerate(boxes):
        assert box.x0 >= 0, text
        assert box.y0 >= 0, text
        assert box.x1 <= width, text
        assert box.y1 <= height, text
        assert [other for other, place in boxes[i + 1 :] if box.overlaps(place)] == [], text
