"""The command `vireport identify`."""

from pathlib import Path
from typing import Annotated

import typer

from vireport.base.errors import UsageError
from vireport.base.files import require_writable
from vireport.cli import options
from vireport.cli.declared import CommandPanel, DeclaredCommand, formats_of
from vireport.cli.formats import FIGURES, PAGES, CommandFormats, format_option
from vireport.cli.inputs import read_scenario
from vireport.cli.options import default_folder, recorded, refuse_files_beside_json
from vireport.cli.outcome import deliver, progress

IDENTIFY = CommandFormats(
    "identify", (*PAGES, *FIGURES), (*PAGES, "png"), "identified.json, identified.yaml and impacts.csv"
)


def identify(
    context: typer.Context,
    scenario: options.ScenarioIfAny = None,
    impacts: options.Impacts = None,
    record: options.Record = None,
    inspect: options.Inspected = None,
    clock: options.Clock = None,
    free: options.Free = None,
    set_: options.Set = None,
    output: options.Folder = None,
    json: options.Json = False,
    format_: Annotated[list[str] | None, format_option(IDENTIFY)] = None,
    templates: options.Templates = None,
    paper: options.Paper = options.PaperSize.A4,
    force: options.Force = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Identify restitutions and other inputs from measured impacts or raw signals, and test whether the model fits.

    The exit code is 1 if the impacts contradict the model, and 3 if they do not determine what is asked for.
    """
    refuse_files_beside_json(context, "result")
    if inspect is not None:
        from vireport.identify import inspected

        if scenario is None and set_:
            raise UsageError("--set needs a scenario to set it over")
        keys = None if scenario is None else read_scenario(scenario, set_)[0].scenario.record
        folder = output or default_folder(inspect, "-inspected")
        if not json:
            require_writable(folder, (inspected.PICTURE,), force)
        deliver(inspected.outcome(inspect, keys, json), folder, quiet)
        return
    if scenario is None:
        raise UsageError("Missing argument 'SCENARIO' (only --inspect needs none)")
    loaded, _ = read_scenario(scenario, set_)
    from vireport.cli.outputs import file_names
    from vireport.identify import outputs

    if (impacts is None) == (record is None):
        raise UsageError("either --impacts or --record is needed (allowed: one of them)")
    command, folder = recorded(context), output or default_folder(scenario, "-identified")
    formats = formats_of(IDENTIFY, format_)
    if not json:
        names = (*outputs.DATA, *file_names(formats, outputs.IDENTIFY_FILES))
        if impacts is not None and Path(impacts).resolve() == (folder / outputs.RECORD).resolve():
            names = tuple(name for name in names if name != outputs.RECORD)  # it is written as it is
        require_writable(folder, names, force)
    request = outputs.Request(loaded, impacts, record, clock is not None, tuple(free or ()), command)
    with progress(quiet, verbose) as say:
        outcome = outputs.outcome(request, outputs.Pages(formats, templates, paper, json, verbose), say)
    deliver(outcome, folder, quiet)


COMMAND = DeclaredCommand("identify", identify, CommandPanel.MEASURED, (IDENTIFY,))
