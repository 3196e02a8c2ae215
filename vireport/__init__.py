"""Periodic motions, stability and voltage of vibro-impact energy harvesters.

::

    from vireport import load, analyse

    study = analyse(load("examples/inclined.yaml"))
    for point in study.solution.critical_points:
        print(point.label, point.event, point.sweep_value)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vireport.base import NumericalError, ScenarioError, UsageError, VireportError, __version__
    from vireport.bench import explore
    from vireport.comparison import Comparison, compare, compare_figure, diff
    from vireport.figures import figure_2, figure_4, figure_7, pictures
    from vireport.scenario import load, loads
    from vireport.study import Study, analyse, recheck, recheck_disturbances, results

_ROOMS = {
    "vireport.base": ("NumericalError", "ScenarioError", "UsageError", "VireportError", "__version__"),
    "vireport.scenario": ("load", "loads"),
    "vireport.study": ("Study", "analyse", "recheck", "recheck_disturbances", "results"),
    "vireport.figures": ("figure_2", "figure_4", "figure_7", "pictures"),
    "vireport.comparison": ("Comparison", "compare", "compare_figure", "diff"),
    "vireport.bench": ("explore",),
}
"""Where each public name is imported from when it is first asked for, so that `import vireport` costs nothing."""

__all__ = [
    "Comparison",
    "NumericalError",
    "ScenarioError",
    "Study",
    "UsageError",
    "VireportError",
    "__version__",
    "analyse",
    "compare",
    "compare_figure",
    "diff",
    "explore",
    "figure_2",
    "figure_4",
    "figure_7",
    "load",
    "loads",
    "pictures",
    "recheck",
    "recheck_disturbances",
    "results",
]


if not TYPE_CHECKING:  # so that a checker of types takes no name for any object

    def __getattr__(name: str) -> object:
        for room, names in _ROOMS.items():
            if name in names:
                return getattr(import_module(room), name)
        raise AttributeError(f"module 'vireport' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
