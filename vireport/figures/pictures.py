"""Which figures a study has, each drawn and with its words."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from vireport.figures import answer, atlas, cycle, device, diagram, hysteresis, margins
from vireport.figures.captions import caption_facts, held, pictured
from vireport.figures.curves import PairedImpacts
from vireport.figures.portraits import portraits_picture
from vireport.figures.style import Picture, Sheet, drawn_for
from vireport.figures.style import style as styled
from vireport.figures.sweeps import figure_2, figure_4, figure_7
from vireport.motions.atlas.portraits import portrait_of
from vireport.motions.families import Atlas
from vireport.motions.periodicity import model_of
from vireport.physics.numbers import ARRAYS
from vireport.study.judging.findings import with_results
from vireport.study.plan import Task
from vireport.study.study import Study, require_study
from vireport.text.formatting import OF_A_MODEL

if TYPE_CHECKING:
    from vireport.study.measured import DrawnImpacts

SAME_VALUE = 1e-9
"""Relative difference of two values of the swept parameter that are one."""


def pictures(
    study: Study,
    simulated: PairedImpacts | None = None,
    templates: Path | None = None,
    *,
    width_mm: float | None = None,
    style: Mapping[str, object] | None = None,
) -> tuple[Picture, ...]:
    """Draw all figures of the report of a study, in the order of their names.

    Parameters
    ----------
    study : Study
    simulated : PairedImpacts, optional
        Motions from a simulation, drawn over the analytic ones.
    templates : Path, optional
        A folder of templates whose words come before those of the package.
    width_mm : float, optional
        Width of a column of a paper [mm], 60 to 250; constant inputs are then left to the captions.
    style : mapping, optional
        Settings of Matplotlib, such as ``{"font.size": 8}``.

    Returns
    -------
    tuple of Picture
        Each with `svg`, `png` and `pdf`, its title, caption and alternative text.

    Raises
    ------
    UsageError
        For another width.
    """
    require_study(study)
    with drawn_for(Sheet.of(width_mm, style)), styled():
        drawn = [*_along_sweep(study, simulated, templates), *_simulated(study, templates), *_atlas(study, templates)]
        drawn += _design(study, templates)
        for finding, result in with_results(study.findings):
            drawn += finding.pictures(result, study, templates)
    return tuple(sorted(drawn, key=lambda picture: picture.name))


def _along_sweep(study: Study, simulated: PairedImpacts | None, templates: Path | None) -> Iterator[Picture]:
    if study.plan.runs(Task.FIGURE_ANSWER) and (first := answer.picture(study, templates)) is not None:
        yield first
    if study.solution.on_table:
        return
    drawings: dict[Task, Callable[[], Figure]] = {
        Task.FIGURE_2: lambda: figure_2(study, simulated),
        Task.FIGURE_4: lambda: figure_4(study),
        Task.FIGURE_7: lambda: figure_7(study, simulated),
    }
    for name, draw in drawings.items():
        if study.plan.runs(name):
            yield pictured(name, caption_facts(study, name, simulated), draw(), templates)


def _simulated(study: Study, templates: Path | None) -> Iterator[Picture]:
    """What comes from simulation alone."""
    check = study.crosscheck
    if check is None:
        return
    others, block = held(study, check.parameter), study.scenario.simulation
    values = ((), ()) if block is None else (block.portraits, block.displacement)
    drawn = ((Task.FIGURE_3, check.portraits), (Task.FIGURE_6, check.displacements))
    for (name, motions), places in zip(drawn, values, strict=True):
        if study.plan.runs(name):
            mass_ratio = float(study.solution.device.mass_ratio)
            measured = [_measured_near(study, value) for value in places] if study.measured else []
            yield portraits_picture(motions, others, name, templates, mass_ratio, measured)
    if study.plan.runs(Task.FIGURE_DIAGRAM) and check.diagram is not None:
        yield diagram.picture(study, check.diagram, check.values, check.groups.d, templates)
    if study.plan.runs(Task.FIGURE_HYSTERESIS) and check.hysteresis is not None:
        yield hysteresis.picture(study, check.hysteresis, templates)


def _measured_near(study: Study, value: float) -> DrawnImpacts | None:
    """The impacts that were measured at a value of the swept parameter, the first of several records."""
    near = (at for at in study.measured if isclose(at.value, value, rel_tol=SAME_VALUE) and at.measured is not None)
    return next((at.drawn_impacts for at in near), None)


def _atlas(study: Study, templates: Path | None) -> Iterator[Picture]:
    """The families of motions of all impact sequences."""
    families, membrane = study.atlas, study.solution.membrane
    if families is None:
        return
    if study.plan.runs(Task.FIGURE_2) and study.solution.on_table and families.families:
        yield atlas.impacts_picture(study, families, templates)
    if study.plan.runs(Task.FIGURE_ATLAS):
        yield atlas.picture(study, families, templates)
    if study.plan.runs(Task.FIGURE_LADDER) and membrane is not None:
        yield atlas.ladder_picture(study, families, membrane, templates)
    if study.plan.runs(Task.FIGURE_PORTRAITS) and study.scenario.motions is not None:
        yield from _named(study, families, study.scenario.motions.portraits, templates)


def _named(study: Study, families: Atlas, names: tuple[str, ...], templates: Path | None) -> Iterator[Picture]:
    """The motions that a scenario names, as far as there are such."""
    model, swept = model_of(families.sweep, ARRAYS), families.sweep.parameter
    named = ((name, families.named(name)) for name in names)
    chosen = ((f"{name}, {swept.place(at[0], OF_A_MODEL)}", at[1]) for name, at in named if at is not None)
    portraits = [portrait_of(model, motion, label) for label, motion in chosen]
    if portraits:
        yield portraits_picture(portraits, held(study), templates=templates)


def _design(study: Study, templates: Path | None) -> Iterator[Picture]:
    """The device, what moves the nearest end of its stable motion, and the electrical cycle of its impacts."""
    if study.plan.runs(Task.FIGURE_DEVICE):
        yield device.picture(study, templates)
    if study.plan.runs(Task.FIGURE_MARGINS) and (drawn := margins.picture(study, templates)) is not None:
        yield drawn
    if study.plan.runs(Task.FIGURE_CYCLE) and (cycles := cycle.picture(study, templates)) is not None:
        yield cycles
