"""Periodic motions, stability and voltage of vibro-impact energy harvesters.

from vireport import load, analyse

study = analyse(load("examples/inclined.yaml"))
for point in study.solution.critical_points:
    print(point.label, point.event, point.sweep_value)
"""

from __future__ import annotations

TYPE_CHECKING = False  # `typing` takes longer to import than all that comes before Ctrl-C is recorded
if TYPE_CHECKING:
    from types import ModuleType
    from typing import Any

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
    "figure_2",
    "figure_4",
    "figure_7",
    "load",
    "loads",
    "pictures",
    "recheck",
    "results",
]


def __getattr__(name: str) -> Any:
    """Import a public name on first use, so that `import vireport` costs nothing."""
    module: ModuleType
    if name in ("NumericalError", "ScenarioError", "UsageError", "VireportError"):
        from vireport.base import errors as module
    elif name == "__version__":
        from vireport.base import version as module
    elif name in ("load", "loads"):
        from vireport import scenario as module
    elif name in ("Study", "analyse", "recheck", "results"):
        from vireport import study as module
    elif name in ("figure_2", "figure_4", "figure_7", "pictures"):
        from vireport import figures as module
    elif name in ("Comparison", "compare", "diff"):
        from vireport import comparison as module
    elif name == "compare_figure":
        from vireport.comparison import figures as module
    else:
        raise AttributeError(f"module 'vireport' has no attribute {name!r}")
    return getattr(module, name)


def __dir__() -> list[str]:
    return __all__
