"""The electrical cycle of the impacts at the design point, in the plane of charge and voltage, with its words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vireport.figures.captions import pictured
from vireport.figures.layout import Entry, blank, finished, letter_of, prefix, round_ticks, title
from vireport.figures.style import DASHED, Color, Look, Picture, sheet, style
from vireport.figures.ticks import set_ticks
from vireport.physics.energy import ElectricalCycle, Membrane, cycle_of
from vireport.study.plan import Task
from vireport.study.study import Study
from vireport.text.formatting import OF_A_MODEL, PREFIXES, Exactness, quantity

PLACES = "bottom", "top"

HEIGHT = 2.9
"""Height of the panels with their ticks and labels [in]."""

WIDTH = 2.7
"""Width of a panel, for the choice of ticks [in]."""

ROOM = 1.12
"""Ends of the axes over the largest charge and voltage."""

CHARGED: Look = {"color": Color.GREY, "linewidth": 1.2}
ISOLATED: Look = {"color": Color.VERMILION, "linewidth": 1.8}
DISCHARGED: Look = {"color": Color.BLUE, "linewidth": 1.2}
LIMIT: Look = {"color": Color.BLACK, "linewidth": 0.9, "linestyle": DASHED}
STAGES: tuple[Entry, ...] = (
    ("charged to the bias, stretched", CHARGED),
    ("isolated, until it is flat", ISOLATED),
    ("discharged, flat", DISCHARGED),
)
AREA: Look = {"color": Color.LIGHT, "alpha": 0.5, "linewidth": 0}
BREAKDOWN = "breakdown"


def picture(study: Study, templates: Path | None = None) -> Picture | None:
    """The figure with its words; None where there is no stable motion at the design point."""
    cycles, membrane = cycles_at_design(study), study.solution.membrane
    if not cycles or membrane is None:
        return None
    facts = {
        "cycles": tuple(zip(PLACES, cycles, strict=True)),
        "bias_v": membrane.bias_voltage_v,
        "breakdown_v": _breakdown_v(membrane),
        "exactness": study.evidence.exactness,
    }
    return pictured(Task.FIGURE_CYCLE, facts, figure_cycle(cycles, membrane, study.evidence.exactness), templates)


def cycles_at_design(study: Study) -> tuple[ElectricalCycle, ...]:
    """The cycles at the bottom and at the top of the stable motion that gains most; () where there is none."""
    design, membrane = study.solution.design, study.solution.membrane
    if (
        design is None
        or design.conversion_by_motion is None
        or design.voltages_by_motion is None
        or not design.motions.stable_mask.any()
    ):
        return ()
    if membrane is None or membrane.dielectric is None:
        return ()
    row = int(np.argmax(np.where(design.motions.stable_mask, design.conversion_by_motion.power_mw, -np.inf)))
    gains = design.voltages_by_motion.bottom_v[row], design.voltages_by_motion.top_v[row]
    return tuple(cycle_of(float(gain), membrane, membrane.dielectric) for gain in gains)


def figure_cycle(cycles: tuple[ElectricalCycle, ...], membrane: Membrane, exactness: Exactness = OF_A_MODEL) -> Figure:
    """The cycle of an impact on either membrane, to one scale, with its area."""
    powers = prefix([np.array([x.charge_c for x in cycles])]), prefix([np.array([x.peak_v for x in cycles])])
    limit = _breakdown_v(membrane)
    with style():
        figure, panels = blank(1, 2, sharex=True, sharey=True)
        highest = tuple(ROOM * max(values) for values in zip(*((x.charge_c, x.peak_v) for x in cycles), strict=True))
        for k, (axes, cycle, where) in enumerate(zip(panels[0], cycles, PLACES, strict=True)):
            _draw(axes, cycle, powers)
            area = quantity(cycle.area_j, "J", exactness)
            title(axes, f"({letter_of(k)}) impact on the {where}: area {area}", 2)
            axes.set_xlabel(f"charge [{PREFIXES[powers[0]]}C]")
            if limit is not None and limit < highest[1]:
                axes.axhline(limit / 10.0 ** powers[1], **LIMIT)
        ends = [high / 10.0**power for high, power in zip(highest, powers, strict=True)]
        panels[0, 0].set(xlim=(0, ends[0]), ylim=(0, ends[1]), ylabel=f"voltage [{PREFIXES[powers[1]]}V]")
        set_ticks(panels[0, 0].xaxis, *round_ticks(0.0, ends[0], min(WIDTH, sheet().across / 2)))
        set_ticks(panels[0, 0].yaxis, *round_ticks(0.0, ends[1], WIDTH))
        broken: list[Entry] = [(BREAKDOWN, LIMIT)] if limit is not None and limit < highest[1] else []
        return finished(figure, HEIGHT, [], [STAGES, broken])


def _draw(axes: Axes, cycle: ElectricalCycle, powers: tuple[int, int]) -> None:
    charge, volts = (values / 10.0**power for values, power in zip(cycle.corners, powers, strict=True))
    axes.fill(charge, volts, **AREA)
    for k, (_, look) in enumerate(STAGES):
        axes.plot(charge[k : k + 2], volts[k : k + 2], **look)


def _breakdown_v(membrane: Membrane) -> float | None:
    """Voltage of the flat membrane at which its material breaks down."""
    material = membrane.dielectric
    return None if material is None else material.breakdown_field_v_m * material.thickness_m
