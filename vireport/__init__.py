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
    from vireport.base.errors import NumericalError, ScenarioError, UsageError, VireportError
    from vireport.base.version import __version__
    from vireport.bench.notebook import explore
    from vireport.comparison.comparison import Comparison, compare
    from vireport.comparison.figures import compare_figure
    from vireport.figures.pictures import pictures
    from vireport.figures.sweeps import figure_2, figure_4, figure_7
    from vireport.findings.proofs.results import recheck_disturbances
    from vireport.findings.tolerances.results import recheck
    from vireport.report.changes.baseline import diff
    from vireport.scenario.loading import load, loads
    from vireport.study.study import Study, analyse, results

_PLACES = {
    "vireport.base.errors": ("NumericalError", "ScenarioError", "UsageError", "VireportError"),
    "vireport.base.version": ("__version__",),
    "vireport.bench.notebook": ("explore",),
    "vireport.scenario.loading": ("load", "loads"),
    "vireport.study.study": ("Study", "analyse", "results"),
    "vireport.findings.proofs.results": ("recheck_disturbances",),
    "vireport.findings.tolerances.results": ("recheck",),
    "vireport.figures.sweeps": ("figure_2", "figure_4", "figure_7"),
    "vireport.figures.pictures": ("pictures",),
    "vireport.comparison.comparison": ("Comparison", "compare"),
    "vireport.comparison.figures": ("compare_figure",),
    "vireport.report.changes.baseline": ("diff",),
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
        for module, names in _PLACES.items():
            if name in names:
                return getattr(import_module(module), name)
        raise AttributeError(f"module 'vireport' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
