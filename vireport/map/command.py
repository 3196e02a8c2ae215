"""The command `vireport map`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from vireport.base import interrupts
from vireport.base.files import require_writable
from vireport.base.progress import WorkStep, portion
from vireport.cli import options
from vireport.cli.declared import CommandPanel, DeclaredCommand, formats_of
from vireport.cli.formats import FIGURES, PAGES, CommandFormats, format_option
from vireport.cli.inputs import read_scenario
from vireport.cli.options import default_folder, figure_width_mm, recorded, refuse, refuse_files_beside_json
from vireport.cli.outcome import CommandOutcome, deliver, progress

MAP = CommandFormats("map", (*PAGES, *FIGURES), (*PAGES, "png"), "the cells")
MAP_OVER = CommandFormats(
    "map --over", (*PAGES, *FIGURES, "json", "markdown"), (*PAGES, "png", "svg", "json", "markdown")
)

CHARTED_SHARE = 0.9
"""Share of the time of exact curves that they take, as measured; their report takes the rest."""


def map_(
    context: typer.Context,
    file: options.ScenarioOrMap,
    over: options.Over = None,
    set_: options.Set = None,
    scheduler: options.Scheduler = None,
    workers: options.Workers = None,
    output: options.Folder = None,
    json: options.Json = False,
    format_: Annotated[list[str] | None, format_option(MAP, MAP_OVER)] = None,
    figures: options.Figures = True,
    templates: options.Templates = None,
    paper: options.Paper = options.PaperSize.A4,
    figure_width: options.FigureWidth = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Map what is stable over two or more inputs: cells of a map block, or with --over the exact boundaries.

    Cells go to files as they are computed; an interrupted run is resumed where it stopped.
    """
    command, formats = recorded(context), formats_of(MAP if over is None else MAP_OVER, format_)
    if over is None:
        refuse(context, "cells go to a file, however many they are (--over draws curves)", "json")
        if not figures:
            refuse(context, "--no-figures writes the cells alone", "format_", "figure_width")
        from vireport.map.cells.outputs import MapOutput

        settings = MapOutput(formats, command, templates, paper, figure_width_mm(figure_width, formats))
        _cells(
            file,
            set_ or (),
            output or default_folder(file),
            scheduler,
            workers,
            figures,
            settings,
            force,
            quiet,
            verbose,
        )
        return
    refuse(context, "--over draws curves, and computes no cells", "scheduler", "workers", "figures")
    refuse_files_beside_json(context, "chart")
    loaded, _ = read_scenario(file, set_)
    from vireport.cli.outputs import file_names
    from vireport.map.chart import outputs as charts
    from vireport.map.chart.over import chart_of
    from vireport.study.provenance import provenance_of

    width_mm, names = figure_width_mm(figure_width, formats), file_names(formats, charts.CHART_FILES)
    folder = output or default_folder(file, "-chart")
    if not json:
        require_writable(folder, names, force)
    with progress(quiet, verbose) as say:
        result = chart_of(loaded, over, portion(say, 0.0, 1.0 if json else CHARTED_SHARE))
        if not json:
            say(WorkStep("setting the report", CHARTED_SHARE))
            files = charts.files(result, loaded, formats, command, templates, paper, width_mm)
    if json:
        deliver(CommandOutcome(charts.chart_json(result, provenance_of(loaded, command))))
        return
    other_files = file_names([task for task in charts.CHART_FILES if task not in formats], charts.CHART_FILES)
    outcome = CommandOutcome(
        text=charts.text(result, templates, verbose), files=files, stale=names, other_files=other_files
    )
    deliver(outcome, folder, quiet)


def _cells(
    file: str, over: Sequence[str], folder: Path, scheduler: str | None, workers: int | None, figures: bool,
    value: Any, force: bool, quiet: bool, verbose: bool,
) -> None:  # fmt: skip
    """Compute a map file, or what is missing of it."""
    from vireport.cli.outputs import file_names
    from vireport.map.cells.outputs import MAP_FILES
    from vireport.map.cells.run import run_map

    require_writable(folder, file_names(value.formats, MAP_FILES) if figures else (), force)
    try:
        with progress(quiet, verbose) as say:

            def show(done: int, total: int) -> None:
                say(WorkStep("computing cells", done / total, f"{done:,} of {total:,}"))

            summary = run_map(file, folder, scheduler, workers, show, figures, value, over)
        interrupts.check()
    except KeyboardInterrupt:
        raise KeyboardInterrupt("what is computed so far is kept: run the same command again to go on") from None
    deliver(CommandOutcome(summary=summary), quiet=quiet)


COMMAND = DeclaredCommand("map", map_, CommandPanel.SEVERAL, (MAP, MAP_OVER))
