"""The bench in a cell of a notebook."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.base.errors import UsageError, install_command
from vireport.bench.session import opened
from vireport.scenario.loading import Loaded
from vireport.study.study import Study

if TYPE_CHECKING:
    from vireport.bench.widget import BenchWidget


def explore(source: str | Path | Loaded | Study) -> BenchWidget:
    """Open a scenario in a cell of a notebook, with sliders that change the design and its results.

    Parameters
    ----------
    source : str, Path, Loaded or Study
        Path of a scenario file, or a result of `load` or `analyse`.

    Returns
    -------
    BenchWidget
        The bench; its `loaded` is the scenario as changed so far, for `analyse`.

    Raises
    ------
    UsageError, ScenarioError
        If the file cannot be read, is a map, or cannot be used; and where the package anywidget is missing.
    """
    if find_spec("anywidget") is None:
        raise UsageError(f"the bench in a notebook needs the package anywidget: {install_command('anywidget')}")
    session = opened(source.loaded if isinstance(source, Study) else source)
    from vireport.bench.widget import BenchWidget

    return BenchWidget(session)
