"""The bench: a design changed by hand in a page of this machine or in a notebook, and what the program says of it."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.base import UsageError, deferred, install_command
from vireport.bench.session import Opened, opened
from vireport.scenario import Loaded
from vireport.study import Study

if TYPE_CHECKING:
    from vireport.bench.server import serve
    from vireport.bench.widget import BenchWidget
else:
    __getattr__ = deferred(__name__, "server")

__all__ = ["Opened", "explore", "opened", "serve"]


def explore(source: str | Path | Loaded | Study) -> BenchWidget:
    """Show a scenario on the bench in a cell of a notebook: sliders, and what the program says of each design.

    Parameters
    ----------
    source : str, Path, Loaded or Study
        A file, or what was loaded or found out of one.

    Returns
    -------
    BenchWidget
        Its `loaded` is the scenario as the hand has left it.

    Raises
    ------
    UsageError, ScenarioError
        If the file cannot be read, is a map, or cannot be used; and where the package anywidget is missing.
    """
    if find_spec("anywidget") is None:
        raise UsageError(f"the bench in a notebook needs the package anywidget: {install_command('anywidget')}")
    known = opened(source.loaded if isinstance(source, Study) else source)
    from vireport.bench.widget import BenchWidget

    return BenchWidget(known)
