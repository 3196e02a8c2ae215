"""Periodic motions, stability and voltage of vibro-impact energy harvesters.

    from vireport import load, analyse

    study = analyse(load("examples/inclined.yaml"))
    for point in study.solution.critical_points:
        print(point.label, point.kind, point.point.sweep_value)

The names below are imported when they are first used, so that `import vireport` costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vireport.baseline import diff
    from vireport.compare_figures import compare_figure
    from vireport.comparison import Comparison, compare
    from vireport.errors import NumericalError, ScenarioError, UsageError, VireportError
    from vireport.export import results
    from vireport.figures import figure_2, figure_4, figure_7, pictures
    from vireport.scenario import load, loads
    from vireport.study import Study, analyse

__version__ = "0.1.0"

_HOME = {
    "Comparison": "comparison",
    "NumericalError": "errors",
    "ScenarioError": "errors",
    "Study": "study",
    "UsageError": "errors",
    "VireportError": "errors",
    "analyse": "study",
    "compare": "comparison",
    "compare_figure": "compare_figures",
    "diff": "baseline",
    "figure_2": "figures",
    "figure_4": "figures",
    "figure_7": "figures",
    "load": "scenario",
    "loads": "scenario",
    "pictures": "figures",
    "results": "export",
}

__all__ = [
    "Comparison",
    "NumericalError",
    "ScenarioError",
    "Study",
    "UsageError",
    "VireportError",
    "analyse",
    "compare",
    "compare_figure",
    "diff",
    "figure_2",
    "figure_4",
    "figure_7",
    "load",
    "loads",
    "pictures",
    "results",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module on first use."""
    if name not in _HOME:
        raise AttributeError(f"module 'vireport' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"vireport.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
