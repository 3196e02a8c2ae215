"""The program: a line of the command line, run to its exit code.

Exit codes: 0 done; 1 done, but a requirement of the scenario is not met; 2 usage, or an invalid scenario; 3 the
numbers could not be had or written, or an internal error; 130 interrupted, 143 ended by SIGTERM.
"""

import os
from functools import cache
from pathlib import Path
from shlex import join
from traceback import format_exc
from typing import Any, cast

import typer
from typer.main import get_command

from vireport.base import interrupts
from vireport.base.errors import ScenarioError, UsageError, VireportError
from vireport.base.version import __version__
from vireport.cli.commands import BUILDERS, app
from vireport.cli.group import OLD_NAMES, PROGRAM, Commands, Program
from vireport.cli.outcome import RED, tell

COMPLETION = "_VIREPORT_COMPLETE"
"""Set by a shell that completes a line of the program, as Typer has it."""


@cache
def program() -> Program:
    """The program with its commands."""
    group: Any = get_command(app)
    group.commands = Commands(BUILDERS)
    return cast(Program, group)


def main(arguments: list[str]) -> int:
    """Run the command line on `arguments` and return the exit code."""
    if COMPLETION in os.environ:
        program()(prog_name=PROGRAM)  # says how the words go on, and ends the process
    try:
        code = _run(arguments)
    except KeyboardInterrupt as error:
        return _interrupted(str(error) or "no file was written")
    except VireportError as error:
        if interrupts.received():
            return _interrupted()
        first, *others = error.lines
        if isinstance(error, UsageError) and (meant := _meant(arguments)):
            first, others = meant, []
        tell([first if isinstance(error, ScenarioError) else f"vireport: error: {first}", *others], RED)
        return error.exit_code
    except BaseException:  # those of extension modules, too, that are no Exception
        if interrupts.received():  # it may have come where a library makes another error of it
            return _interrupted()
        fault = "internal error: this is a fault of ours; please report it with the lines above"
        tell([*format_exc().splitlines(), f"vireport {__version__}: {fault}"])
        return VireportError.exit_code
    return _interrupted("all was done") if interrupts.received() else code


def _run(arguments: list[str]) -> int:
    """Run a command and return its exit code; what the command raises is raised."""
    # The two steps of a call of the group, which has exit codes of its own for an interrupt and for a broken pipe.
    try:
        with program().make_context(PROGRAM, [*arguments]) as context:
            program().invoke(context)
    except typer.Exit as stop:
        return stop.exit_code
    except SystemExit as stop:  # Typer ends the process once it has shown or installed the script of completion
        return stop.code if isinstance(stop.code, int) else 0
    except typer.TyperException as refused:
        interrupts.check()  # one that came while the arguments were read: nothing was done
        command, *_ = OLD_NAMES.get(arguments[0], [arguments[0]])
        name = command if command in program().commands else "run"
        said = _meant(arguments) or refused.format_message()
        if said.startswith("Got unexpected extra"):
            said += "; what has spaces needs quotes"
        tell([f"{PROGRAM}: error: {said}", f"{PROGRAM} {name} --help lists the options"], RED)
        return refused.exit_code
    return 0


def _meant(arguments: list[str]) -> str:
    """What a line that was refused was probably to be; "" where there is no telling."""
    for k, word in enumerate(arguments[:-1]):
        for end in range(k + 2, len(arguments) + 1):
            if _is_file(path := " ".join(arguments[k:end])):
                return f"a name with spaces needs quotes: {join([PROGRAM, *arguments[:k], path, *arguments[end:]])}"
        key, value = [*arguments, ""][k + 1 : k + 3]
        if word == "--set" and "=" not in key and value and not value.startswith("-") and not _is_file(value):
            return f"a value is set with '=': --set {key}={value}"
    return ""


def _is_file(path: str) -> bool:
    try:
        return Path(path).is_file()
    except (OSError, ValueError):  # too long a name, or a zero byte in it
        return False


def _interrupted(what: str = "") -> int:
    tell([f"vireport: interrupted{what and f' ({what})'}"], RED)
    return interrupts.exit_code()
