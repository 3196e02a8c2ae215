"""The command `vireport explore`."""

from pathlib import Path

from vireport.base.files import require_writable
from vireport.cli import options
from vireport.cli.declared import CommandPanel, DeclaredCommand
from vireport.cli.inputs import read_earlier_run
from vireport.cli.outcome import emit, tell


def explore(
    scenario: options.Scenario,
    set_: options.Set = None,
    allow_outside: options.AllowOutside = False,
    port: options.Port = 0,
    browser: options.Browser = True,
    output: options.Folder = None,
) -> None:
    """Change a design by hand in a page of the browser, with its margins and verdict. Ctrl-C ends it.

    What the page saves goes to the current folder, unless -o names another.
    """
    from vireport.bench.server import serve
    from vireport.bench.session import opened

    earlier, folder = read_earlier_run(scenario), output or Path()
    loaded = scenario if earlier is None else earlier.loaded(set_ or (), allow_outside)
    session = opened(loaded, tuple(set_ or ()), allow_outside)
    require_writable(folder)

    def begun(address: str) -> None:
        emit(f"{address}\n")
        for note in session.notes:
            tell([note])
        tell(["The page is at this address on this machine alone. Ctrl-C ends the program."])
        if browser:
            from webbrowser import open as open_page

            if not open_page(address):
                tell(["No browser could be opened: open the address by hand."])

    try:
        serve(session, folder, port, begun)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("the page keeps what is set; files that it saved are there") from None


COMMAND = DeclaredCommand("explore", explore, CommandPanel.ONE)
