"""The command `vireport verify`."""

import typer

from vireport.base.encoding import json_text
from vireport.base.errors import UsageError
from vireport.base.files import require_writable
from vireport.cli import options
from vireport.cli.declared import CommandPanel, DeclaredCommand
from vireport.cli.inputs import read_scenario
from vireport.cli.options import figure_width_mm, recorded, refuse
from vireport.cli.outcome import CommandOutcome, deliver, progress, tell_lacking


def verify(
    context: typer.Context,
    scenario: options.ScenarioIfAny = None,
    extremes: options.Extremes = False,
    every: options.EveryRun = False,
    set_: options.Set = None,
    output: options.Folder = None,
    json: options.Json = False,
    figure_width: options.FigureWidth = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Measure the error of every method against its run time, and compare compliant with rigid membranes.

    Files, the figures and accuracy.json, are written with -o only.
    """
    from vireport.study.plan import Task, refuse_special, require_reference

    if scenario is None and not extremes:
        raise UsageError("Missing argument 'SCENARIO' (only --extremes has a device of its own)")
    if scenario is None and set_:
        raise UsageError("--set needs a scenario to set it over")
    loaded = None if scenario is None else read_scenario(scenario, set_)[0]
    if loaded is not None:
        refuse_special(loaded.scenario, f"vireport verify{' --extremes' * extremes}")
    require_reference()
    if extremes or loaded is None:
        refuse(context, "--extremes prints the cases", "output", "figure_width", "every")
        from vireport.verify.catalogue import run_catalogue
        from vireport.verify.results import cases_data
        from vireport.verify.rows import as_text, exit_status

        with progress(quiet, verbose) as say:
            outcomes = run_catalogue(loaded, say)
        code, failure = exit_status(outcomes)
        data, text = (f"{json_text(cases_data(outcomes))}\n", "") if json else ("", as_text(outcomes, verbose))
        deliver(CommandOutcome(data, text, failure=failure, exit_code=code), quiet=quiet)
        return
    if output is None:
        refuse(context, "figures are written to a folder, give --output", "figure_width")
    from vireport.verify import outputs

    if output is not None:
        require_writable(output, outputs.NAMES, force)
    width_mm = figure_width_mm(figure_width, (Task.PNG,))
    loaded = outputs.with_accuracy_block(loaded)
    tell_lacking(loaded, outputs.FORMATS, quiet)
    with progress(quiet, verbose) as say:
        study = outputs.measured_study(loaded, say)
        files = outputs.files(study, recorded(context), width_mm) if output is not None else {}
    printed = outputs.data(study, recorded(context)) if json else ""
    text = "" if json else outputs.text(study, verbose, every)
    deliver(CommandOutcome(printed, text, files, stale=outputs.NAMES), output, quiet)


COMMAND = DeclaredCommand("verify", verify, CommandPanel.MEASURED)
