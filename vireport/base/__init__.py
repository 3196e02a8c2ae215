"""What every room stands on: ways to fail, Ctrl-C, streams, files read and written, records, JSON, the version."""

from vireport.base import interrupts, streams
from vireport.base.deferred import deferred
from vireport.base.encoding import json_answer, json_text
from vireport.base.errors import (
    EXTRAS,
    MOST_MISTAKES,
    Mistake,
    Mistakes,
    NumericalError,
    OutputError,
    RenderError,
    ScenarioError,
    UsageError,
    VireportError,
    install_command,
)
from vireport.base.files import WRITTEN_BY, is_marked, require_writable, writable, write_files, write_new, write_whole
from vireport.base.progress import Progress, WorkStep, counted, portion
from vireport.base.reading import ANYWHERE, ReadingPlace
from vireport.base.records import brief, plain
from vireport.base.shares import share_interval
from vireport.base.version import __version__

__all__ = [
    "ANYWHERE",
    "EXTRAS",
    "MOST_MISTAKES",
    "WRITTEN_BY",
    "Mistake",
    "Mistakes",
    "NumericalError",
    "OutputError",
    "Progress",
    "ReadingPlace",
    "RenderError",
    "ScenarioError",
    "UsageError",
    "VireportError",
    "WorkStep",
    "__version__",
    "brief",
    "counted",
    "deferred",
    "install_command",
    "interrupts",
    "is_marked",
    "json_answer",
    "json_text",
    "plain",
    "portion",
    "require_writable",
    "share_interval",
    "streams",
    "writable",
    "write_files",
    "write_new",
    "write_whole",
]
