"""The paper's Figures 2, 3, 4, 6 and 7 with its panels and letters, by this program."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from vireport.figures.captions import about, alt_text, caption_facts, held, swept_range
from vireport.figures.curves import simulated_points
from vireport.figures.portraits import portraits_picture
from vireport.figures.style import Picture
from vireport.figures.sweeps import Drawing, drawing_of, panel_letters, sweep_figure
from vireport.paper.reproduction import ReproducedPaper
from vireport.study.checks.paper import CASES
from vireport.study.plan import Task
from vireport.text.said import words_of

_said = words_of("reproduction")


def paper_pictures(paper: ReproducedPaper, templates: Path | None = None) -> Iterator[Picture]:
    """Draw the figures in the order of their numbers.

    Parameters
    ----------
    paper : ReproducedPaper
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    drawings = [drawing_of(study, simulated_points(study)) for study in paper.studies]
    ratio = float(paper.studies[0].solution.device.mass_ratio)
    yield _over_sweeps(Task.FIGURE_2, drawings, templates)
    yield portraits_picture(paper.portraits, (), Task.FIGURE_3, templates)
    yield _over_sweeps(Task.FIGURE_4, drawings, templates)
    yield portraits_picture(paper.displacements, (), Task.FIGURE_6, templates, ratio)
    if all(study.solution.membrane is not None for study in paper.studies):
        yield _over_sweeps(Task.FIGURE_7, drawings, templates)


def _over_sweeps(figure: Task, drawings: Sequence[Drawing], templates: Path | None) -> Picture:
    """A figure with a column for each of the three sweeps, whose panels are lettered column by column."""
    titles = [_said(f"column_{case.name}").words(templates) for case in CASES]
    columns = [
        _said("column", panel_letters(figure, k), [*held(drawing.study), swept_range(drawing.study)])
        for k, drawing in enumerate(drawings)
    ]
    facts_by_column = [caption_facts(drawing.study, figure, drawing.simulated) for drawing in drawings]
    texts = [
        _said("column_alt", title, alt_text(figure, facts, templates))
        for title, facts in zip(titles, facts_by_column, strict=True)
    ]
    circles = figure is not Task.FIGURE_4 and any(drawing.simulated for drawing in drawings)
    caption = _said("caption", about(figure, templates), columns, circles)
    return Picture(
        figure,
        _said(figure.replace("-", "_")).words(templates),
        caption.words(templates),
        _said("alt", texts).words(templates),
        sweep_figure(figure, drawings, titles),
    )
