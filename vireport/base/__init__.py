"""What every room stands on: the ways a run can fail, Ctrl-C, files written whole, reports of progress, the version."""

from vireport.base.errors import (
    Mistake,
    NumericalError,
    OutputError,
    RenderError,
    ScenarioError,
    UsageError,
    VireportError,
    installing,
)
from vireport.base.files import require_writable, writable, write_files, write_new, write_whole
from vireport.base.interrupts import EXIT_CODE, check, deferred, install
from vireport.base.progress import Progress
from vireport.base.shares import wilson
from vireport.base.version import __version__

__all__ = [
    "EXIT_CODE",
    "Mistake",
    "NumericalError",
    "OutputError",
    "Progress",
    "RenderError",
    "ScenarioError",
    "UsageError",
    "VireportError",
    "__version__",
    "check",
    "deferred",
    "install",
    "installing",
    "require_writable",
    "wilson",
    "writable",
    "write_files",
    "write_new",
    "write_whole",
]
