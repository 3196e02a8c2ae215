"""The command `vireport optimise`."""

from typing import Annotated

import typer
from msgspec.structs import replace

from vireport.base.files import require_writable
from vireport.cli import options
from vireport.cli.declared import CommandPanel, DeclaredCommand, formats_of
from vireport.cli.formats import FIGURES, PAGES, CommandFormats, format_option
from vireport.cli.inputs import read_scenario
from vireport.cli.options import default_folder, figure_width_mm, recorded, refuse_files_beside_json
from vireport.cli.outcome import CommandOutcome, deliver, progress, tell_lacking

OPTIMISE = CommandFormats("optimise", (*PAGES, *FIGURES), (*PAGES, "png"), "best.yaml and optimise.json")


def optimise(
    context: typer.Context,
    scenario: options.Scenario,
    set_: options.Set = None,
    output: options.Folder = None,
    json: options.Json = False,
    format_: Annotated[list[str] | None, format_option(OPTIMISE)] = None,
    templates: options.Templates = None,
    paper: options.Paper = options.PaperSize.A4,
    figure_width: options.FigureWidth = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Find the best design that meets the requirements. The scenario's design block says what may vary.

    The exit code is 1 if no design meets the requirements.
    """
    refuse_files_beside_json(context, "result")
    loaded, _ = read_scenario(scenario, set_)
    from vireport.cli.outputs import BeyondStudy, PageSettings, file_names, run_files
    from vireport.optimise import outputs
    from vireport.optimise.problem import problem_of
    from vireport.optimise.search import optimise as search
    from vireport.study.provenance import provenance_of

    problem, command, formats = problem_of(loaded), recorded(context), formats_of(OPTIMISE, format_)
    settings = PageSettings(formats, templates, paper, figure_width_mm(figure_width, formats))
    provenance = provenance_of(loaded, command)
    stale = (*outputs.DATA, *file_names(formats, outputs.OPTIMISE_FILES))
    folder = output or default_folder(scenario, "-best")
    if not json:
        require_writable(folder, stale, force)
    tell_lacking(loaded, formats, quiet)
    with progress(quiet, verbose) as say:
        result = search(problem, say)
        pages = [task for task in outputs.PAGES if task in formats and result.best is not None and not json]
        say("solving the best design")
        study = outputs.run_of(result, pages, say)
        files = {} if json else outputs.files(result, study, provenance, settings)
        if study is not None and pages:
            opens, section = outputs.opening(result, study), outputs.section(result, templates)
            beyond = BeyondStudy(None, *section, opens)
            files |= run_files(study, command, replace(settings, formats=pages, width_mm=None), say, beyond)
    failure = outputs.shortcoming(result, templates)
    other_files = file_names([task for task in outputs.OPTIMISE_FILES if task not in formats], outputs.OPTIMISE_FILES)
    outcome = CommandOutcome(
        outputs.optimise_json(result, study, provenance) if json else "",
        "" if json else outputs.text(result, study, templates, verbose),
        files,
        failure=failure,
        exit_code=bool(failure),
        stale=stale,
        other_files=other_files,
    )
    deliver(outcome, folder, quiet)


COMMAND = DeclaredCommand("optimise", optimise, CommandPanel.SEVERAL, (OPTIMISE,))
