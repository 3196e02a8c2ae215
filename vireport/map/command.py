"""The command `vireport map`."""

from collections.abc import Callable
from functools import partial
from typing import Annotated

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
    formats = formats_of(MAP if over is None else MAP_OVER, format_)
    if over is None:
        refuse(context, "cells go to a file, however many they are (--over draws curves)", "json")
        if not figures:
            refuse(context, "--no-figures writes the cells alone", "format_", "figure_width")
    else:
        refuse(context, "--over draws curves, and computes no cells", "scheduler", "workers", "figures")
        refuse_files_beside_json(context, "chart")
    from vireport.cli.outputs import file_names
    from vireport.map.outputs import CELL_FILES, CHART_FILES, MapOutput

    width_mm = figure_width_mm(figure_width, formats)
    settings = MapOutput(formats, recorded(context), templates, paper, width_mm)
    names = file_names(formats, CELL_FILES if over is None else CHART_FILES)
    folder = output or default_folder(file, "" if over is None else "-chart")
    if over is None:
        require_writable(folder, names if figures else (), force)
        from vireport.map.cells.run import run_map

        compute = partial(
            run_map, file, folder, scheduler, workers, draw=figures, output=settings, overrides=set_ or ()
        )
        _cells(compute, quiet, verbose)
        return
    loaded, _ = read_scenario(file, set_)
    from vireport.map.chart import outputs as charts
    from vireport.map.chart.over import chart_of

    if not json:
        require_writable(folder, names, force)
    with progress(quiet, verbose) as say:
        result = chart_of(loaded, over, portion(say, 0.0, 1.0 if json else CHARTED_SHARE))
        if json:
            deliver(CommandOutcome(charts.chart_json(result, settings.provenance(loaded, {}))))
            return
        say(WorkStep("setting the report", CHARTED_SHARE))
        files = charts.files(result, loaded, settings)
    others = file_names([task for task in CHART_FILES if task not in formats], CHART_FILES)
    text = charts.text(result, templates, verbose)
    deliver(CommandOutcome(text=text, files=files, stale=names, other_files=others), folder, quiet)


def _cells(compute: Callable[..., str], quiet: bool, verbose: bool) -> None:
    """Compute a map file, or what is missing of it, with progress."""
    try:
        with progress(quiet, verbose) as say:

            def show(done: int, total: int) -> None:
                say(WorkStep("computing cells", done / total, f"{done:,} of {total:,}"))

            summary = compute(progress=show)
        interrupts.check()
    except KeyboardInterrupt:
        raise KeyboardInterrupt("what is computed so far is kept: run the same command again to go on") from None
    deliver(CommandOutcome(summary=summary), quiet=quiet)


COMMAND = DeclaredCommand("map", map_, CommandPanel.SEVERAL, (MAP, MAP_OVER))
