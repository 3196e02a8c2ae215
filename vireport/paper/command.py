"""The command `vireport paper`."""

from typing import Annotated

import typer

from vireport.base.files import require_writable
from vireport.cli import options
from vireport.cli.declared import CommandPanel, DeclaredCommand, formats_of
from vireport.cli.formats import FIGURES, PAGES, CommandFormats, format_option
from vireport.cli.options import figure_width_mm, recorded, refuse, refuse_files_beside_json
from vireport.cli.outcome import CommandOutcome, deliver, progress

PAPER = CommandFormats("paper", (*PAGES, *FIGURES, "json"), (*PAGES, "png", "json"))


def paper(
    context: typer.Context,
    set_: options.Set = None,
    validate: options.Validate = False,
    output: options.Folder = None,
    json: options.Json = False,
    format_: Annotated[list[str] | None, format_option(PAPER)] = None,
    templates: options.Templates = None,
    paper: options.Paper = options.PaperSize.A4,
    figure_width: options.FigureWidth = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Reproduce the paper: its figures 2, 3, 4, 6 and 7, Table 1, and every printed number beside ours.

    With --set, the paper's three scenarios are changed, and the report shows what that changes.
    """
    if validate:
        refuse(context, "--validate prints a table", "set_", "output", "json", "format_", "paper", "figure_width")
        from vireport.paper.outputs import validation_outcome

        with progress(quiet, verbose) as say:
            validated = validation_outcome(templates, say)
        deliver(validated, quiet=quiet)
        return
    refuse_files_beside_json(context, "reproduction")
    from vireport.cli.outputs import PageSettings, file_names
    from vireport.paper.outputs import PAPER_FILES, PAPER_FOLDER, paper_json, paper_outcome
    from vireport.paper.reproduction import reproduce_paper

    command, formats, folder = recorded(context), formats_of(PAPER, format_), output or PAPER_FOLDER
    pages = PageSettings(formats, templates, paper, figure_width_mm(figure_width, formats))
    if not json:
        require_writable(folder, file_names(formats, PAPER_FILES), force)
    with progress(quiet, verbose) as say:
        reproduced = reproduce_paper(set_ or (), say)
        if json:
            outcome = CommandOutcome(paper_json(reproduced, command))
        else:
            outcome = paper_outcome(reproduced, pages, command, say, verbose)
    deliver(outcome, folder, quiet)


COMMAND = DeclaredCommand("paper", paper, CommandPanel.MEASURED, (PAPER,))
